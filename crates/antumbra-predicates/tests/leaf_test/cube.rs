//! A closed cube of twelve triangles, with the light and the samples on the same lattice: nearly every case has ties, and
//! still each count of blockers is what it would be without.

use antumbra_predicates::{Triangle, exact, resolve};

use crate::cases::{Point, Rng};
use crate::oracle;

/// Half the cube's side.
const H: i32 = 2;

/// The twelve triangles of the cube `-H..H`; diagonals, order and sense of the corners are random.
fn cube(rng: &mut Rng) -> Vec<Triangle> {
    let mut triangles = Vec::new();
    for axis in 0..3 {
        for side in [-H, H] {
            let corner = |u: i32, v: i32| -> Point {
                let mut p = [0.0; 3];
                p[axis] = side as f32;
                p[(axis + 1) % 3] = (u * H) as f32;
                p[(axis + 2) % 3] = (v * H) as f32;
                p
            };
            let mut quad = [corner(-1, -1), corner(1, -1), corner(1, 1), corner(-1, 1)];
            quad.rotate_left(rng.int(0, 3) as usize);
            for mut t in [[quad[0], quad[1], quad[2]], [quad[0], quad[2], quad[3]]] {
                t.rotate_left(rng.int(0, 2) as usize);
                if rng.one_in(2) {
                    t.swap(0, 1);
                }
                triangles.push(t);
            }
        }
    }
    triangles
}

#[derive(PartialEq, Debug, Clone, Copy)]
enum Place {
    Inside,
    Surface,
    Outside,
}

fn place(p: [i32; 3]) -> Place {
    let furthest = p.map(i32::abs).into_iter().max().unwrap_or(0);
    match furthest.cmp(&H) {
        std::cmp::Ordering::Less => Place::Inside,
        std::cmp::Ordering::Equal => Place::Surface,
        std::cmp::Ordering::Greater => Place::Outside,
    }
}

/// Does the segment meet the open cube (`strict`), or the closed one? By slabs, in whole fractions.
fn meets(a: [i32; 3], b: [i32; 3], strict: bool) -> bool {
    // Parameters are fractions n/d with d > 0; enter is the largest lower end, leave the smallest upper end.
    let (mut enter, mut leave) = ((0, 1), (1, 1));
    for k in 0..3 {
        let d = b[k] - a[k];
        if d == 0 {
            let off = a[k].abs();
            if off > H || (strict && off == H) {
                return false;
            }
            continue;
        }
        let (mut n0, mut n1) = ((-H - a[k]) * d.signum(), (H - a[k]) * d.signum());
        if d < 0 {
            std::mem::swap(&mut n0, &mut n1);
        }
        let d = d.abs();
        if n0 * enter.1 > enter.0 * d {
            enter = (n0, d);
        }
        if n1 * leave.1 < leave.0 * d {
            leave = (n1, d);
        }
    }
    let (l, r) = (enter.0 * leave.1, leave.0 * enter.1);
    if strict { l < r } else { l <= r }
}

#[test]
fn counts_of_blockers_are_even_or_odd_as_they_must_be() {
    let mut rng = Rng(11);
    let mut seen = [0u32; 4];
    for round in 0..40_000 {
        let triangles = cube(&mut rng);
        let mut lattice = |n: i32| [0; 3].map(|_| rng.int(-n, n));
        let (l, p) = (lattice(4), lattice(5));
        let [light, sample] = [l, p].map(|q| q.map(|x| x as f32));
        let claims = |t: &&Triangle| {
            let f = exact::facing(t, light);
            f != 0 && (0..3).all(|k| exact::side(t[k], t[(k + 1) % 3], sample, light) == f)
        };
        let cones = triangles.iter().filter(claims).count();
        let blockers = triangles.iter().filter(|t| resolve::blocks(t, light, sample)).count();
        if round % 100 == 0 {
            let truth = triangles.iter().filter(|t| oracle::ask(t, light, sample).blocks).count();
            assert_eq!(blockers, truth);
        }
        let case = format!("light {l:?}, sample {p:?}, {cones} cones, {blockers} blockers");
        match (place(l), place(p)) {
            (Place::Inside, at) => {
                assert_eq!(cones, 1, "{case}");
                assert_eq!(blockers, usize::from(at == Place::Outside), "{case}");
                seen[0] += 1;
            }
            (Place::Outside, at) => {
                assert!(cones == 0 || cones == 2, "{case}");
                match at {
                    Place::Inside => {
                        assert_eq!(blockers, 1, "{case}");
                        seen[1] += 1;
                    }
                    Place::Outside if meets(l, p, true) => {
                        assert_eq!(blockers, 2, "{case}");
                        seen[2] += 1;
                    }
                    Place::Outside if !meets(l, p, false) => {
                        assert_eq!(blockers, 0, "{case}");
                        seen[3] += 1;
                    }
                    // Along an edge or a face, or ending on one: 0, 1 or 2, but always the same.
                    _ => assert!(blockers <= 2, "{case}"),
                }
            }
            // From a light on the surface the faces through it are edge-on and do not block.
            (Place::Surface, _) => assert!(cones <= 1 && blockers <= 1, "{case}"),
        }
    }
    assert!(seen.iter().all(|&n| n > 500), "{seen:?}");
}
