//! First stage for tiles, and the plane test in f64: whatever they are certain of is true.
#![expect(clippy::print_stdout, reason = "the tally is a result of the test")]

use antumbra_predicates::aim::Aim;
use antumbra_predicates::exact;
use antumbra_predicates::filter::LIMIT;
use antumbra_predicates::plane::PlaneResolver;
use antumbra_predicates::tile::{NEAREST, Part, PartVerdict, Region, Tested, Tile, TileBlock, TileVerdict};
use fearless_simd::{Level, SimdBase, dispatch, f32x8};

use crate::cases::{Case, Point, Rng, line};
use crate::filter::levels;
use crate::oracle::Truth;

#[derive(Clone, Copy, Debug, Default)]
struct Tally {
    rejected: u32,
    covering: u32,
    flipped: u32,
    culled: u32,
    beside: u32,
    within: u32,
    free: u32,
    blocked: u32,
    open_plane: u32,
    open_sides: u32,
    plane_sure: u32,
    far: u32,
}

/// World coordinates in the frame of a face: axes turned round, w perhaps negated.
fn turn(face: usize, p: Point) -> Point {
    let [u, v, w] = [[1, 2, 0], [0, 2, 1], [0, 1, 2]][face / 2];
    [p[u], p[v], if face.is_multiple_of(2) { p[w] } else { -p[w] }]
}

/// x, y, r of a sample, if it lies within the face.
fn direction(face: usize, p: Point, aim: &Aim) -> Option<Point> {
    let (p, l) = (turn(face, p), aim.light());
    let [u, v, w] = [0, 1, 2].map(|k| p[k] - l[k]);
    ((NEAREST..=LIMIT).contains(&w) && u.abs() <= w && v.abs() <= w).then(|| aim.seen(p))
}

fn bounds(of: &[Point]) -> Region {
    of.iter().fold(Region::EMPTY, |sum, p| sum.union(&Region { lo: *p, hi: *p }))
}

fn columns(points: &[Point]) -> [[f32; 8]; 3] {
    let mut out = [[0.0; 8]; 3];
    for (i, p) in points.iter().enumerate() {
        for k in 0..3 {
            out[k][i] = p[k];
        }
    }
    out
}

fn prepare_at(level: Level, corner: &[[[f32; 8]; 3]; 3], live: u8, tile: &Tile) -> (TileVerdict, TileBlock) {
    let mut block = TileBlock::ZERO;
    let verdict = dispatch!(level, s => {
        let load = |c: &[[f32; 8]; 3]| [
            f32x8::load_array_ref(s, &c[0]),
            f32x8::load_array_ref(s, &c[1]),
            f32x8::load_array_ref(s, &c[2]),
        ];
        let live = block.look(s, [load(&corner[0]), load(&corner[1]), load(&corner[2])], live, tile);
        block.prepare(s, live, tile)
    });
    (verdict, block)
}

fn cull_at(level: Level, block: &TileBlock, region: &Region) -> PartVerdict {
    dispatch!(level, s => block.cull(s, &Part::new(s, f32x8::load_array(s, region.pack()))))
}

/// The samples four times over, two vectors of sixteen, of which callers count the second eight.
fn test_at(
    level: Level,
    block: &TileBlock,
    lane: usize,
    p: &[[f32; 8]; 3],
    sign: f32,
    within: bool,
    alive: u32,
) -> Tested {
    let all = |v: &[f32; 8]| [std::array::from_fn(|i| v[i % 8]); 2];
    let [u, v, w]: [[[f32; 16]; 2]; 3] = [all(&p[0]), all(&p[1]), all(&p[2])];
    dispatch!(level, s => block.test(s, lane, [&u, &v, &w], sign, alive, within))
}

/// Directions, up to eight, in the first lanes or in the last of sixteen: the answer must be the same.
fn not_beside_at(level: Level, block: &TileBlock, lane: usize, at: &[Point]) -> u32 {
    let ask = |first: usize| {
        let [x, y] = [0, 1].map(|k| {
            std::array::from_fn(|i| i.checked_sub(first).and_then(|i| at.get(i)).map_or(9.0, |at| at[k]))
        });
        dispatch!(level, s => block.not_beside(s, lane, [&x, &y])) >> first & 0xff >> (8 - at.len())
    };
    let found = ask(0);
    assert_eq!(found, ask(8), "{level:?}, lane {lane}");
    found
}

fn plane_at(level: Level, plane: &PlaneResolver, p: &[[f32; 8]; 3]) -> (u8, u8) {
    dispatch!(level, s => {
        let p = [
            f32x8::load_array_ref(s, &p[0]),
            f32x8::load_array_ref(s, &p[1]),
            f32x8::load_array_ref(s, &p[2]),
        ];
        plane.lanes(s, p)
    })
}

/// The samples of the case that lie in one face, with their directions.
fn seen(case: &Case, face: usize, aim: &Aim) -> Vec<(usize, Point)> {
    (0..16).filter_map(|i| direction(face, case.samples[i], aim).map(|at| (i, at))).collect()
}

/// The samples of the case that lie in one face, as a tile: as they are seen along the axis, and from one of them.
fn check(level: Level, case: &Case, face: usize, live: u8, truth: &[[Truth; 16]; 8], tally: &mut Tally) {
    let light = turn(face, case.light);
    let straight = Aim::straight(light);
    let inside = seen(case, face, &straight);
    let Some(&(_, first)) = inside.first() else { return };
    check_from(level, case, face, live, truth, &straight, tally);
    let aim = Aim::at(light, first);
    if !aim.is_straight() {
        tally.far += 1;
        check_from(level, case, face, live, truth, &aim, tally);
    }
}

fn check_from(
    level: Level,
    case: &Case,
    face: usize,
    live: u8,
    truth: &[[Truth; 16]; 8],
    aim: &Aim,
    tally: &mut Tally,
) {
    let light = aim.light();
    let inside = seen(case, face, aim);
    let at: Vec<Point> = inside.iter().map(|s| s.1).collect();
    let tile = Tile::new(*aim, bounds(&at));
    let mut corner = [[[f32::NAN; 8]; 3]; 3];
    for lane in (0..8).filter(|lane| live >> lane & 1 == 1) {
        for c in 0..3 {
            let p = turn(face, case.triangles[lane][c]);
            (0..3).for_each(|k| corner[c][k][lane] = p[k]);
        }
    }
    let (verdict, mut block) = prepare_at(level, &corner, live, &tile);
    assert_eq!(verdict.maybe & !live, 0, "dead lanes");
    assert_eq!((verdict.covers | verdict.edge_on) & !verdict.maybe, 0, "covers or edge-on without maybe");
    let mut settled = 0;
    for lane in (0..8).filter(|lane| live >> lane & 1 == 1) {
        let t = &case.triangles[lane];
        let bit = |mask: u8| mask >> lane & 1 == 1;
        tally.rejected += u32::from(!bit(verdict.maybe));
        tally.covering += u32::from(bit(verdict.covers));
        for &(i, _) in &inside {
            let truth = &truth[lane][i];
            let wrong = || format!("{level:?}, face {face}: {}", line(t, case.light, case.samples[i], truth));
            assert!(bit(verdict.maybe) || !truth.blocks, "rejected: {}", wrong());
            assert!(!bit(verdict.covers) || truth.blocks, "covers: {}", wrong());
        }
        if !bit(verdict.maybe) {
            continue;
        }
        if bit(verdict.edge_on) {
            match exact::facing(&t.map(|p| turn(face, p)), light) {
                0 => continue,
                -1 => {
                    tally.flipped += 1;
                    block.flip(lane);
                }
                _ => {}
            }
        }
        assert_ne!(truth[lane][0].facing, 0, "degenerate, and not said so: {t:?}");
        settled |= 1 << lane;
    }
    // Halves of the tile: a region within it.
    for part in inside.chunks(8) {
        let region = bounds(&part.iter().map(|s| s.1).collect::<Vec<_>>());
        let PartVerdict { maybe, within, covers } = cull_at(level, &block, &region);
        assert_eq!(
            (within & !maybe) | (covers & !within),
            0,
            "covers without within, or within without maybe"
        );
        // As the method has them: axes in the order of the face, w with the sign of the world.
        let sign = if face.is_multiple_of(2) { 1.0 } else { -1.0 };
        let points = columns(
            &part
                .iter()
                .map(|s| {
                    let [u, v, w] = turn(face, case.samples[s.0]);
                    [u, v, w * sign]
                })
                .collect::<Vec<_>>(),
        );
        let world = columns(&part.iter().map(|s| case.samples[s.0]).collect::<Vec<_>>());
        let alive = (0xffu32 >> (8 - part.len())) as u8;
        for lane in (0..8).filter(|lane| settled >> lane & 1 == 1) {
            let t = &case.triangles[lane];
            tally.culled += u32::from(maybe >> lane & 1 == 0) + u32::from(covers >> lane & 1);
            let alive = u32::from(alive) << 8;
            let found = test_at(level, &block, lane, &points, sign, false, alive);
            assert_eq!((found.blocked | found.plane | found.sides) & !alive, 0, "dead samples");
            let inside = within >> lane & 1 == 1;
            if inside {
                tally.within += 1;
                let again = test_at(level, &block, lane, &points, sign, true, alive);
                // Sides that are certain over a region are certain in its samples, or close to it: never wrong.
                assert_eq!(found.blocked & !again.blocked, 0, "{level:?}, face {face}, lane {lane}");
                assert_eq!(again.sides, 0, "sides are known");
            }
            let at: Vec<Point> = part.iter().map(|s| s.1).collect();
            let not_beside = not_beside_at(level, &block, lane, &at);
            let plane = PlaneResolver::new(t, case.light);
            let plane = plane.map(|plane| plane_at(level, &plane, &world));
            for (bit, &(i, _)) in part.iter().enumerate() {
                let truth = &truth[lane][i];
                let wrong =
                    || format!("{level:?}, face {face}: {}", line(t, case.light, case.samples[i], truth));
                assert!(maybe >> lane & 1 == 1 || !truth.blocks, "culled: {}", wrong());
                assert!(covers >> lane & 1 == 0 || truth.blocks, "region covered: {}", wrong());
                tally.beside += u32::from(not_beside >> bit & 1 == 0);
                assert!(not_beside >> bit & 1 == 1 || !truth.blocks, "beside: {}", wrong());
                assert!(!inside || truth.sides == [truth.facing; 3], "within: {}", wrong());
                let is = |mask: u32| mask >> (8 + bit) & 1 == 1;
                match (is(found.blocked), is(found.plane), is(found.sides)) {
                    (true, false, false) => {
                        tally.blocked += 1;
                        assert!(truth.blocks, "blocked: {}", wrong());
                    }
                    (false, false, false) => {
                        tally.free += 1;
                        assert!(!truth.blocks, "free: {}", wrong());
                    }
                    (false, true, false) => {
                        tally.open_plane += 1;
                        assert_eq!(truth.sides, [truth.facing; 3], "inside: {}", wrong());
                    }
                    (false, false, true) => tally.open_sides += 1,
                    _ => panic!("two answers: {}", wrong()),
                }
                let is = |mask: u8| mask >> bit & 1 == 1;
                if let Some((beyond, unsure)) = plane
                    && !is(unsure)
                {
                    tally.plane_sure += 1;
                    let beyond = if is(beyond) { truth.facing } else { -truth.facing };
                    assert_eq!(truth.beyond, beyond, "plane: {}", wrong());
                }
            }
        }
    }
}

#[test]
fn certain_is_true_for_tiles() {
    let levels = levels();
    let mut tallies = vec![Tally::default(); levels.len()];
    let mut rng = Rng(11);
    for round in 0..2000 {
        let case = Case::random(&mut rng);
        let truth = case.truth();
        let live = if round % 2 == 0 { 0xff } else { rng.next() as u8 };
        for (&level, tally) in levels.iter().zip(&mut tallies) {
            (0..6).for_each(|face| check(level, &case, face, live, &truth, tally));
        }
    }
    for (level, t) in levels.iter().zip(&tallies) {
        println!("{level:?}: {t:?}");
        assert!(
            t.rejected > 1000
                && t.covering > 100
                && t.flipped > 100
                && t.culled > 1000
                && t.beside > 3000
                && t.within > 100,
            "{t:?}"
        );
        assert!(t.free > 3000 && t.blocked > 1000 && t.open_plane > 300 && t.open_sides > 1000, "{t:?}");
        assert!(t.plane_sure > 1000 && t.far > 1000, "{t:?}");
    }
}
