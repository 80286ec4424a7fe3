//! What follows from the definition, and what users of shadows rely on.

use antumbra_predicates::{Triangle, exact, resolve};

use crate::cases::{Case, Point, Rng, between};

#[test]
fn an_edge_seen_from_the_other_side_has_the_other_sign() {
    let mut rng = Rng(7);
    let mut checked = 0;
    for _ in 0..4000 {
        let case = Case::random(&mut rng);
        for t in &case.triangles {
            for &p in &case.samples {
                let s = exact::side(t[0], t[1], p, case.light);
                assert_eq!(s, -exact::side(t[1], t[0], p, case.light));
                checked += u32::from(s != 0);
            }
        }
    }
    assert!(checked > 400_000, "{checked}");
}

#[test]
fn order_of_corners_does_not_matter() {
    let mut rng = Rng(8);
    for _ in 0..2000 {
        let case = Case::random(&mut rng);
        for &[a, b, c] in &case.triangles {
            for &p in &case.samples[6..10] {
                let first = resolve::blocks(&[a, b, c], case.light, p);
                for t in [[b, c, a], [c, a, b], [b, a, c], [a, c, b], [c, b, a]] {
                    assert_eq!(resolve::blocks(&t, case.light, p), first);
                }
            }
        }
    }
}

#[test]
fn powers_of_two_do_not_matter() {
    let mut rng = Rng(9);
    for _ in 0..20_000 {
        let mut point = || [0; 3].map(|_| rng.int(-3, 3) as f32);
        let (t, light, p) = ([point(), point(), point()], point(), point());
        let k = rng.int(-149, 125);
        // Two steps: 2^-149 has no inverse, and is itself out of reach of `powi` in one.
        let scaled = |p: Point| p.map(|x| (f64::from(x) * 2f64.powi(k)) as f32);
        assert_eq!(
            resolve::blocks(&t, light, p),
            resolve::blocks(&t.map(scaled), scaled(light), scaled(p)),
            "2^{k}"
        );
    }
}

/// How many triangles of the closed fan about `hub` block `p`.
fn claims(hub: Point, ring: &[Point], light: Point, p: Point) -> usize {
    let fan = |i: usize| -> Triangle { [hub, ring[i], ring[(i + 1) % ring.len()]] };
    (0..ring.len()).filter(|&i| resolve::blocks(&fan(i), light, p)).count()
}

/// All triangles face the light, or all face away: then the ring goes round the hub once.
fn is_open_umbrella(hub: Point, ring: &[Point], light: Point) -> bool {
    let first = exact::facing(&[hub, ring[0], ring[1]], light);
    first != 0
        && (0..ring.len()).all(|i| exact::facing(&[hub, ring[i], ring[(i + 1) % ring.len()]], light) == first)
}

#[test]
fn a_closed_fan_claims_each_sample_once() {
    let mut rng = Rng(10);
    let (mut fans, mut samples) = (0, 0);
    let hexagon = [[3, 0], [2, 3], [-2, 3], [-3, 0], [-2, -3], [2, -3]];
    for _ in 0..3000 {
        // On the lattice, where samples behind hub, spokes and interiors are all exact, and ties are the rule.
        let hub = [0; 3].map(|_| rng.int(-1, 1));
        let ring = hexagon.map(|[x, y]| [x + rng.int(-1, 1), y + rng.int(-1, 1), rng.int(-1, 1)]);
        let light = [rng.int(-2, 2), rng.int(-2, 2), rng.int(6, 9)];
        let float = |p: [i32; 3]| p.map(|x| x as f32);
        let ring_f = ring.map(float);
        if !is_open_umbrella(float(hub), &ring_f, float(light)) {
            continue;
        }
        fans += 1;
        let mut once = |p: [i32; 3], what: &str| {
            samples += 1;
            let n = claims(float(hub), &ring_f, float(light), float(p));
            assert_eq!(n, 1, "{what}: hub {hub:?}, ring {ring:?}, light {light:?}, sample {p:?}");
        };
        once([0, 1, 2].map(|k| 2 * hub[k] - light[k]), "hub");
        for i in 0..6 {
            let (u, v) = (ring[i], ring[(i + 1) % 6]);
            once([0, 1, 2].map(|k| hub[k] + u[k] - light[k]), "spoke");
            once([0, 1, 2].map(|k| 2 * hub[k] + u[k] + v[k] - 3 * light[k]), "interior");
        }
        // Off the lattice: rounded points on the spokes, at another scale and place.
        let away = float([0; 3].map(|_| rng.int(-2000, 2000)));
        let place = |p: [i32; 3]| [0, 1, 2].map(|k| p[k] as f32 * 0.1 + away[k]);
        let (hub, ring, light) = (place(hub), ring.map(place), place(light));
        if is_open_umbrella(hub, &ring, light) {
            for spoke in ring {
                let x = between(hub, spoke, 0.5 * rng.unit());
                let p = between(light, x, 1.5 + rng.unit());
                assert_eq!(claims(hub, &ring, light, p), 1);
            }
        }
    }
    assert!(fans > 1000 && samples > 10_000, "{fans} fans, {samples} samples");
}
