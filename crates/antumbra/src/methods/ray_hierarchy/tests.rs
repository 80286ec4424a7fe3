//! Bounds are conservative, bits and order are right, and no option but front-face culling changes the mask.

use antumbra_predicates::exact;
use fearless_simd::{Simd, dispatch};

use super::RayHierarchy;
use super::build::{Group, Hierarchy};
use super::cone::Cone;
use super::done::Done;
use super::node_test::{Verdict, precise, sphere};
use super::options::{ConeTest, RayHierarchyOptions};
use super::order::{self, EMPTY, hilbert};
use super::triangle::Caster;
use crate::Isa;
use crate::methods::{CATALOGUE, DebugView, Method, Options, Oracle, Samples};
use crate::scene::{Triangle, procedural};

/// SplitMix64.
struct Random(u64);

impl Random {
    fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    fn unit(&mut self) -> f32 {
        (self.bits() >> 40) as f32 / (1u32 << 24) as f32
    }

    fn point(&mut self, r: f32) -> [f32; 3] {
        [0; 3].map(|_| (self.unit() * 2.0 - 1.0) * r)
    }

    fn lattice(&mut self) -> [f32; 3] {
        [0; 3].map(|_| (self.bits() % 7) as f32 - 3.0)
    }
}

#[test]
fn hilbert_curve_fills_squares_in_unit_steps() {
    for (left, top) in [(0, 0), (64, 320), (16_320, 8_128)] {
        let mut cells: Vec<_> =
            (0..64 * 64).map(|i| (hilbert(left + i % 64, top + i / 64), i % 64, i / 64)).collect();
        cells.sort_unstable();
        for pair in cells.windows(2) {
            let ((d, x, y), (e, u, v)) = (pair[0], pair[1]);
            assert_eq!(e, d + 1);
            assert_eq!(x.abs_diff(u) + y.abs_diff(v), 1);
        }
    }
}

#[test]
fn screen_order_is_made_of_quads_and_holds_each_sample_once() {
    let mut positions = vec![[1.0, 2.0, 3.0]; 21 * 13];
    positions[5] = [f32::NAN; 3];
    positions[7] = [0.0; 3];
    let (mut keys, mut order) = (Vec::new(), Vec::new());
    order::by_screen(Samples::image(&positions, 21), [0.0; 3], &mut keys, &mut order);
    let mut seen: Vec<_> = order.iter().copied().filter(|s| *s != EMPTY).collect();
    seen.sort_unstable();
    let expected: Vec<u32> = (0..21 * 13).filter(|i| *i != 5 && *i != 7).collect();
    assert_eq!(seen, expected);
    assert_eq!(&order[..8], &[0, 1, 21, 22, 2, 3, 23, 24]);
}

#[test]
fn cones_hold_all_rays_below() {
    let mut random = Random(1);
    for (count, spread, light) in
        [(700, 1.0, [0.0; 3]), (90, 1e-6, [3.0, 1.0, 2.0]), (300, 1e30, [1.0; 3]), (3, 1.0, [0.0; 3])]
    {
        let positions: Vec<_> = (0..count)
            .map(|i| {
                let far = [1.0, 1e-3, 1e3][i % 3];
                let p = random.point(spread);
                [p[0] + far, p[1], p[2] * far]
            })
            .collect();
        let mut h = Hierarchy::default();
        order::by_direction(&positions, light, &mut Vec::new(), &mut h.order);
        assert_eq!(h.order.len(), count);
        h.build(&positions, light);
        for level in 1..=h.top() {
            for (leaf, sample) in h.order.iter().enumerate() {
                let node = leaf >> (2 * level);
                let cone = h.level(level)[node / 4].cone(node % 4);
                let ray = Cone::ray(positions[*sample as usize], light);
                assert!(cone.min <= ray.min && ray.max <= cone.max);
                let cross = super::vector::cross(cone.axis, ray.axis);
                let (c, s) = (super::vector::dot(cone.axis, ray.axis), super::vector::length(cross));
                // The angle is at most the half angle, unless that is π.
                let beyond = s * cone.cos - c * cone.sin;
                assert!(cone.cos == -1.0 || (beyond <= 0.0 && c >= cone.cos - 1e-15), "{cone:?} {ray:?}");
            }
        }
    }
}

fn verdicts(isa: Isa, group: &Group, t: &Caster) -> [Verdict; 2] {
    #[inline(always)]
    fn both<S: Simd>(s: S, group: &Group, t: &Caster) -> [Verdict; 2] {
        [precise(s, group, t, true), sphere(s, group, t)]
    }
    let level = isa.level().expect("available");
    dispatch!(level, s => both(s, group, t))
}

#[test]
fn rejected_and_covered_cones_are_right() {
    let mut random = Random(2);
    let isas = Isa::available();
    let (mut rejected, mut covered, mut open) = ([0, 0], 0, [0, 0]);
    for round in 0..60_000 {
        let scale = [1.0, 1.0, 1.0, 1e-30, 1e30, 1e37][round % 6];
        let on_lattice = round % 4 == 0;
        let mut point = |r: f32| if on_lattice { random.lattice() } else { random.point(r * scale) };
        let light = point(1.0);
        let t: Triangle = [point(2.0), point(2.0), point(2.0)];
        // Bundles of four rays, from narrow to all around.
        let mut rays = [[[0.0f32; 3]; 4]; 4];
        for bundle in &mut rays {
            let centre = point(4.0);
            let width = [0.001, 0.03, 0.3, 1.0, 4.0][round / 6 % 5];
            for p in bundle {
                let d = point(width);
                *p = [0, 1, 2].map(|k| centre[k] + d[k]);
                if *p == light {
                    *p = [light[0] + scale, light[1], light[2]];
                }
            }
        }
        let Some(caster) = Caster::new(&t, light, true) else { continue };
        let group = Group::from_cones(rays.map(|b| Cone::around(&b.map(|p| Cone::ray(p, light)))));
        for (kind, v) in verdicts(isas[round % isas.len()], &group, &caster).into_iter().enumerate() {
            assert_eq!(v.open & v.covered, 0);
            for (i, bundle) in rays.iter().enumerate() {
                let blocked = bundle.map(|p| exact::blocks(&t, light, p));
                if v.covered >> i & 1 == 1 {
                    covered += 1;
                    assert_eq!(blocked, [true; 4], "round {round}: {t:?} {light:?} {bundle:?}");
                } else if v.open >> i & 1 == 0 {
                    rejected[kind] += 1;
                    assert_eq!(blocked, [false; 4], "round {round}: {t:?} {light:?} {bundle:?}");
                } else {
                    open[kind] += 1;
                }
            }
        }
    }
    // The tests must also be worth their while, and the precise one more so.
    assert!(covered > 1000, "{covered}");
    assert!(rejected[0] > 2 * open[0] && open[0] < open[1], "{rejected:?} {open:?}");
}

#[test]
fn nodes_die_with_their_rays() {
    let mut random = Random(3);
    for leaves in [1usize, 15, 64, 300, 5000] {
        let mut valid = vec![0u64; leaves.div_ceil(64)];
        let mut expected: Vec<bool> = (0..leaves).map(|_| random.unit() < 0.02).collect();
        for (i, done) in expected.iter().enumerate() {
            valid[i / 64] |= u64::from(!done) << (i % 64);
        }
        let mut done = Done::default();
        done.reset(&valid);
        let mut top = 1;
        while leaves.div_ceil(1 << (2 * top)) > 4 {
            top += 1;
        }
        for _ in 0..60 {
            let level = (random.bits() % (top as u64 + 1)) as usize;
            let node = (random.bits() % leaves.div_ceil(1 << (2 * level)) as u64) as usize;
            done.kill(level, node);
            let end = leaves.min((node + 1) << (2 * level));
            expected[node << (2 * level)..end].fill(true);
            for level in 1..=top {
                for node in 0..leaves.div_ceil(1 << (2 * level)) {
                    let dead = done.dead(level, node / 4) >> (node % 4) & 1 == 1;
                    let end = leaves.min((node + 1) << (2 * level));
                    let all = expected[node << (2 * level)..end].iter().all(|v| *v);
                    assert!(all || !dead, "{leaves} leaves, level {level}, node {node}");
                }
            }
        }
        done.hand_down();
        for (i, expected) in expected.iter().enumerate() {
            assert_eq!(done.rays(i / 64) >> (i % 64) & 1 == 1, *expected, "{leaves} leaves, leaf {i}");
        }
    }
}

/// Casters around a light, samples among them.
fn soup(seed: u64) -> (Vec<Triangle>, Vec<[f32; 3]>, [f32; 3]) {
    let mut random = Random(seed);
    let triangles = (0..300)
        .map(|i| {
            let centre = random.point(4.0);
            let size = if i % 20 == 0 { 3.0 } else { 0.4 };
            [0; 3].map(|_| {
                let d = random.point(size);
                [0, 1, 2].map(|k| centre[k] + d[k])
            })
        })
        .collect();
    (triangles, (0..3000).map(|_| random.point(5.0)).collect(), random.point(0.5))
}

fn names() -> impl Iterator<Item = &'static str> {
    CATALOGUE.iter().filter(|m| m.exact && m.name.starts_with("rh-")).map(|m| m.name)
}

fn named(name: &str) -> RayHierarchyOptions {
    RayHierarchyOptions::named(name, &Options::default()).expect("a name of this method")
}

fn run(
    options: RayHierarchyOptions,
    threads: usize,
    case: &(Vec<Triangle>, Vec<[f32; 3]>, [f32; 3]),
) -> (Vec<u8>, Vec<(&'static str, u64)>) {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
    let mut mask = vec![9; case.1.len()];
    let mut method = RayHierarchy::new("test", options);
    let stats = pool
        .install(|| method.shadow(&case.0, Samples::image(&case.1, 60), case.2, &mut mask))
        .expect("good input");
    (mask, stats.counters.to_vec())
}

fn counter(counters: &[(&'static str, u64)], name: &str) -> u64 {
    counters.iter().find(|c| c.0 == name).unwrap_or_else(|| panic!("no counter {name}")).1
}

#[test]
fn no_option_changes_the_mask() {
    let case = soup(4);
    let mut expected = vec![9; case.1.len()];
    Oracle.shadow(&case.0, Samples::list(&case.1), case.2, &mut expected).expect("good input");
    for name in names() {
        let (mask, usual) = run(named(name), 2, &case);
        assert!(mask == expected, "{name}");
        // The smallest queues: everything is flushed, nothing is lost.
        let options = RayHierarchyOptions { queue_capacity: 0, block: 7, ..named(name) };
        let (mask, counters) = run(options, 2, &case);
        assert!(mask == expected, "{name} with minimum queues");
        assert!(counter(&counters, "queue_flushes") > counter(&usual, "queue_flushes"), "{name}");
        assert!(counter(&counters, "queue_peak") <= 4, "{name}");
        // With and without rebuilding, with no blockers and with nothing else.
        for (blocker_share, rebuild_share) in [(0.2, 0.0), (0.2, 2.0), (0.0, 0.0), (1.0, 0.0)] {
            let options = RayHierarchyOptions {
                blocker_share,
                rebuild_share,
                blocker_solid_angle: 0.0,
                two_pass: true,
                ..named(name)
            };
            assert!(run(options, 1, &case).0 == expected, "{name}, {blocker_share}, {rebuild_share}");
        }
    }
}

#[test]
fn plain_variants_count_the_same_with_any_number_of_threads() {
    let case = soup(5);
    for name in names().filter(|n| !named(n).early_accept) {
        assert_eq!(run(named(name), 1, &case), run(named(name), 3, &case), "{name}");
    }
}

#[test]
fn improvements_cut_visits() {
    let scene = procedural::builtin("room", None).expect("there is a room");
    let view = crate::samples::gbuffer::render(&scene, &scene.cameras[0], 96, 64, &Default::default());
    let case = (scene.soup.positions, view.samples.positions, scene.lights[0].position);
    let visits = |name: &str| counter(&run(named(name), 2, &case).1, "node_visits");
    assert!(visits("rh-precise") < visits("rh-spheres"));
    assert!(visits("rh-precise-sorted") < visits("rh-spheres-sorted"));
    assert!(visits("rh-precise-sorted") < visits("rh-precise"));
    assert!(visits("rh-precise-sea") < visits("rh-precise-sorted"));
}

#[test]
fn front_face_culling_keeps_the_shadow_of_a_closed_mesh() {
    // A tetrahedron, corners counter-clockwise as seen from outside.
    let v = [[1.0f32, 1.0, 1.0], [1.0, -1.0, -1.0], [-1.0, 1.0, -1.0], [-1.0, -1.0, 1.0]];
    let triangles = vec![[v[0], v[1], v[2]], [v[0], v[3], v[1]], [v[0], v[2], v[3]], [v[1], v[3], v[2]]];
    let mut random = Random(6);
    let outside: Vec<_> =
        (0..2000).map(|_| random.point(6.0)).filter(|p| p.iter().any(|v| v.abs() > 1.0)).collect();
    let case = (triangles, outside, [4.1, 0.3, 0.2]);
    for cone_test in [ConeTest::Sphere, ConeTest::Precise] {
        let all = RayHierarchyOptions { cone_test, ..RayHierarchyOptions::default() };
        let culled = RayHierarchyOptions { front_face_culling: true, ..all };
        let ((a, counts), (b, fewer)) = (run(all, 1, &case), run(culled, 1, &case));
        assert!(a.contains(&1) && a == b);
        assert!(counter(&fewer, "setup_tris") < counter(&counts, "setup_tris"));
    }
}

#[test]
fn rough_leaves_report_their_mistakes() {
    let case = soup(7);
    for name in ["rh-leaf-wald", "rh-leaf-moller-trumbore"] {
        let (exact, _) = run(named("rh-precise-sorted"), 1, &case);
        let (mask, counters) = run(RayHierarchyOptions { count: true, ..named(name) }, 1, &case);
        let wrong = (0..mask.len()).filter(|&i| mask[i] != exact[i]).count() as u64;
        let pairs = counter(&counters, "leaf_false_hits") + counter(&counters, "leaf_false_misses");
        // Random points rarely lie on an edge: the tests are sound, if not exact.
        assert!(wrong <= pairs && pairs < 20, "{name}: {wrong} samples, {pairs} pairs");
    }
}

#[test]
fn debug_views_have_a_number_for_every_ray() {
    let (triangles, mut positions, light) = soup(8);
    positions[11] = [f32::NAN; 3];
    for name in names() {
        let mut method = RayHierarchy::new(name, named(name));
        for DebugView { name: view, .. } in method.debug_views() {
            let samples = Samples::image(&positions, 60);
            let numbers =
                method.debug_view(view, &triangles, samples, light).expect("good input").expect("a view");
            assert!(numbers.iter().enumerate().all(|(i, v)| v.is_nan() == (i == 11)), "{name} {view}");
            assert!(numbers.iter().any(|v| *v > 0.0) || *view == "accept-level", "{name} {view}");
        }
        let samples = Samples::image(&positions, 60);
        assert_eq!(method.debug_view("none such", &triangles, samples, light), Ok(None));
    }
}
