//! The build equals sequential insertion; the defects that section 5.4 names; minimum capacities.

use std::sync::atomic::Ordering;

use super::build::{Tree, build_sequentially};
use super::node::{NONE, Node, Sample};
use super::{Dpsv, Query};
use crate::methods::{DebugView, Method, Options, Oracle, Samples, Stats};
use crate::scene::{Triangle, procedural};

/// SplitMix64 (Steele, Lea, Flood 2014).
pub(super) struct Random(u64);

impl Random {
    pub(super) fn new(seed: u64) -> Random {
        Random(seed)
    }

    pub(super) fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    pub(super) fn below(&mut self, n: u64) -> u64 {
        self.bits() % n
    }

    /// In [-1, 1).
    pub(super) fn signed(&mut self) -> f64 {
        (self.bits() >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }

    fn point(&mut self, r: f64) -> [f32; 3] {
        [0; 3].map(|_: i32| (self.signed() * r) as f32)
    }

    fn soup(&mut self, count: usize, spread: f64, size: f64) -> Vec<Triangle> {
        (0..count)
            .map(|_| {
                let at = self.point(spread);
                [0; 3].map(|_: i32| {
                    let d = self.point(size);
                    [at[0] + d[0], at[1] + d[1], at[2] + d[2]]
                })
            })
            .collect()
    }
}

const QUERIES: [Query; 5] =
    [Query::Stack, Query::Stackless, Query::HYBRID, Query::Hybrid { stack: 1 }, Query::Hybrid { stack: 3 }];

/// All queries against the oracle, with and without a depth limit. Returns the statistics of the hybrid.
fn check(triangles: &[Triangle], points: &[[f32; 3]], light: [f32; 3]) -> Stats {
    let samples = Samples::image(points, 20);
    let mut expected = vec![77; points.len()];
    Oracle.shadow(triangles, samples, light, &mut expected).unwrap();
    let mut kept = None;
    for query in QUERIES {
        for max_depth in [512, 4, 1] {
            let mut method = Dpsv::new(&Options::default(), query).with_max_depth(max_depth);
            let mut mask = vec![77; points.len()];
            let stats = method.shadow(triangles, samples, light, &mut mask).unwrap();
            let wrong = (0..mask.len()).filter(|&i| mask[i] != expected[i]).count();
            assert_eq!(wrong, 0, "{query:?}, depth {max_depth}: of {}", mask.len());
            if query == Query::HYBRID && max_depth == 512 {
                kept = Some(stats);
            }
        }
    }
    kept.unwrap()
}

fn counter(stats: &Stats, name: &str) -> u64 {
    stats.counters.iter().find(|c| c.0 == name).unwrap().1
}

/// Everything a node holds but its planes.
fn links(node: &Node) -> ([u32; 16], u32) {
    let mut all = [0; 16];
    for k in 0..4 {
        (all[k], all[4 + k]) = (node.outside(k), node.crossing(k));
    }
    for k in 0..3 {
        all[8 + k] = node.wedge[k].load(Ordering::Relaxed);
    }
    (all[11], all[12]) = (node.back(), node.nearest().to_bits());
    (all, node.triangle)
}

fn assert_same_tree(triangles: &[Triangle], light: [f32; 3], threads: usize) {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
    let expected = build_sequentially(triangles, light);
    let mut tree = Tree::default();
    // Twice: nothing of the first build may be left in the second.
    for _ in 0..2 {
        pool.install(|| tree.build(triangles, light, 512));
        assert_eq!(tree.root(), expected.root());
        assert!(tree.rest.is_empty());
        for (got, expected) in tree.nodes.iter().zip(&expected.nodes) {
            assert_eq!(links(got), links(expected));
        }
    }
}

#[test]
fn parallel_build_equals_sequential_insertion() {
    let mut random = Random::new(7);
    for (count, spread, size) in [(1, 1.0, 1.0), (300, 1.0, 1.0), (3000, 3.0, 0.3), (4000, 1.0, 0.02)] {
        let soup = random.soup(count, spread, size);
        for threads in [1, 2, 3] {
            assert_same_tree(&soup, [0.0, 0.1, 0.2], threads);
        }
    }
    let room = procedural::builtin("room", None).unwrap();
    assert_same_tree(&room.soup.positions, room.lights[0].position, 2);
}

#[test]
fn nodes_have_the_published_size() {
    assert_eq!(size_of::<Node>(), 128);
}

#[test]
fn casters_that_cut_each_other_do_not_leak() {
    // 5.4-1: triangles that cross the cap of others, inside their shadow volumes.
    let mut at_caps = 0;
    for seed in 0..6 {
        let mut random = Random::new(seed);
        let light = [0.0, 0.0, 10.0];
        // Nested triangles, each tilted its own way about a line through the z axis: smaller ones lie inside the shadow
        // planes of larger ones and stick through them.
        let mut triangles = Vec::new();
        for i in 0..12 {
            let size = 6.0 * 0.6f64.powi(i);
            let mut tilt = [0; 3].map(|_: i32| 0.3 * size * random.signed());
            tilt[2] = -tilt[0] - tilt[1];
            triangles.push([0, 1, 2].map(|k| {
                let angle = k as f64 * 2.0943951;
                [(size * angle.cos()) as f32, (size * angle.sin()) as f32, tilt[k] as f32]
            }));
        }
        let points: Vec<_> = (0..800)
            .map(|i| {
                let size = 4.0 * 0.6f64.powi(i % 10);
                let p = random.point(size);
                [p[0], p[1], p[2] * 0.3]
            })
            .collect();
        check(&triangles, &points, light);
        let mut tree = Tree::default();
        tree.build(&triangles, light, 512);
        at_caps += tree.nodes.iter().filter(|n| n.crossing(3) != NONE).count();
    }
    assert!(at_caps >= 10, "the scenes must have crossing subtrees at caps, not {at_caps}");
}

#[test]
fn large_triangles_close_to_the_light() {
    // 5.4-2: triangles of up to nearly a half space of directions.
    for seed in 0..6 {
        let mut random = Random::new(100 + seed);
        let triangles = random.soup(40, 1.0, 4.0);
        let points: Vec<_> = (0..800).map(|_| random.point(20.0)).collect();
        check(&triangles, &points, random.point(0.5));
    }
}

#[test]
fn duplicates_are_discarded_and_neighbours_do_not_cross() {
    let one = [[-1.0, -1.0, 1.0], [1.0, -1.0, 1.25], [0.0, 1.0, 1.0]];
    let points: Vec<_> =
        (0..400).map(|i| [(i % 20) as f32 * 0.3 - 3.0, (i / 20) as f32 * 0.3 - 3.0, 2.0]).collect();
    let stats = check(&vec![one; 3000], &points, [0.0; 3]);
    assert_eq!((counter(&stats, "tree_depth"), counter(&stats, "discarded_tris")), (1, 2999));
    // A fan: each triangle shares two corners with the next.
    let rim = |i: usize| {
        let angle = i as f32 * 0.1;
        [angle.cos(), angle.sin(), 1.0]
    };
    let fan: Vec<Triangle> = (0..30).map(|i| [[0.0, 0.0, 1.0], rim(i), rim(i + 1)]).collect();
    let stats = check(&fan, &points, [0.0; 3]);
    assert!(counter(&stats, "insert_crossings") < counter(&stats, "insert_steps") / 4);
}

#[test]
fn a_chain_of_triangles_ends_at_the_depth_limit() {
    // Long thin triangles around the light, each across the planes of the others.
    let triangles: Vec<Triangle> = (0..2000)
        .map(|i| {
            let angle = i as f32 * 0.001;
            let (c, s) = (angle.cos() * 50.0, angle.sin() * 50.0);
            let z = 1.0 + i as f32 * 1e-4;
            [[c, s, z], [-c, -s, z], [-c, -s + 0.01, z]]
        })
        .collect();
    let points: Vec<_> = (0..100).map(|i| [(i % 10) as f32 - 5.0, (i / 10) as f32 - 5.0, 9.0]).collect();
    let stats = check(&triangles, &points, [0.0; 3]);
    assert!(counter(&stats, "tree_depth") <= 512);
}

#[test]
fn signs_that_are_certain_are_right() {
    let mut random = Random::new(11);
    let (mut sure, mut all) = (0, 0);
    for round in 0..3000 {
        let scale = [1.0, 1e-3, 1e6, 1e18, 1e-18, 1e30, 1e-36][round % 7];
        let light = random.point(scale);
        let size = scale * 10f64.powi(-(random.below(6) as i32));
        let mut triangle = random.soup(1, scale, size)[0];
        if round % 3 == 0 {
            // A lattice: ties.
            triangle = triangle.map(|v| v.map(|x| (x / scale as f32 * 4.0).round() * scale as f32));
        }
        let triangles = [triangle];
        let node = Node::new(0, &triangles, light);
        if node.facing == 0 {
            continue;
        }
        for _ in 0..20 {
            let (u, v) = (random.signed() as f32, random.signed() as f32);
            let far = 10f32.powi(random.below(5) as i32 - 2);
            // Close to a plane of the tests: in the plane of the light and an edge, or in that of the triangle.
            let p = [0, 1, 2].map(|k| {
                let [a, b, c] = triangles[0].map(|x| x[k]);
                if round % 2 == 0 {
                    light[k] + (a - light[k]) * u * far + (b - light[k]) * v * far
                } else {
                    a + (b - a) * u * far + (c - a) * v * far
                }
            });
            if !p.iter().all(|x| x.is_finite()) {
                continue;
            }
            let sample = Sample::new(p, light);
            for k in 0..4 {
                let (value, error) = node.value(k, sample.q, sample.sum);
                all += 1;
                if value.abs() > error {
                    sure += 1;
                    assert_eq!(
                        value > 0.0,
                        node.exactly_inside(k, &triangles, light, p),
                        "{k} {triangle:?} {p:?}"
                    );
                }
            }
        }
    }
    assert!(sure > all / 4, "{sure} of {all}");
}

#[test]
fn debug_views_know_the_mask() {
    let room = procedural::builtin("room", None).unwrap();
    let mut random = Random::new(5);
    let mut points: Vec<_> = (0..500).map(|_| random.point(3.0)).collect();
    points[3] = [f32::NAN; 3];
    let (light, samples) = (room.lights[0].position, Samples::image(&points, 25));
    let mut method = Dpsv::new(&Options::default(), Query::HYBRID);
    let mut mask = vec![0; points.len()];
    method.shadow(&room.soup.positions, samples, light, &mut mask).unwrap();
    let depth = method.debug_view("depth", &room.soup.positions, samples, light).unwrap().unwrap();
    for (m, d) in mask.iter().zip(depth) {
        assert_eq!(*m, if d.is_nan() { 255 } else { u8::from(d > 0.0) });
    }
    for DebugView { name, .. } in method.debug_views() {
        assert!(method.debug_view(name, &room.soup.positions, samples, light).unwrap().is_some());
    }
    assert!(method.debug_view("no such view", &room.soup.positions, samples, light).unwrap().is_none());
}
