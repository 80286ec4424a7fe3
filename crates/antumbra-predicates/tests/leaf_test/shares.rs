//! How far each stage gets on scenes that nobody made to be hard. The numbers are printed with `--nocapture`.
#![expect(clippy::print_stdout, reason = "the shares are a result of the tests")]

use antumbra_predicates::{Resolver, SampleGroup, Shares, Triangle};
use fearless_simd::Level;

use crate::cases::{Point, Rng, between, finite};
use crate::filter::{against_at, block, test_at};

/// Shares of the pairs that come as far as the leaf test, and numbers of pairs that the group test settles.
#[derive(Default)]
struct Count {
    leaf: Shares,
    by_group: u64,
}

fn run(triangles: &[[Triangle; 8]], light: Point, groups: &[[Point; 8]]) -> Count {
    let level = Level::new();
    let mut count = Count::default();
    for samples in groups {
        let lo = [0, 1, 2].map(|k| samples.iter().map(|p| p[k]).fold(f32::MAX, f32::min));
        let hi = [0, 1, 2].map(|k| samples.iter().map(|p| p[k]).fold(-f32::MAX, f32::max));
        let group = SampleGroup::from_bounds(lo, hi);
        for eight in triangles {
            let (verdict, mut tests) = against_at(level, &block(eight), 0xff, light, &group);
            count.by_group += 8 * u64::from((!verdict.maybe | verdict.covers).count_ones());
            let open = verdict.maybe & !verdict.covers;
            for lane in (0..8).filter(|lane| open >> lane & 1 == 1) {
                let Some(resolver) = Resolver::new(&eight[lane], light) else { continue };
                if verdict.edge_on >> lane & 1 == 1 && resolver.facing() < 0 {
                    tests.flip(lane);
                }
                let lanes = test_at(level, &tests, lane, samples);
                for i in 0..8 {
                    if lanes.unsure >> i & 1 == 1 {
                        count.leaf.count(resolver.blocks(samples[i]).1);
                    } else {
                        count.leaf.single += 1;
                    }
                }
            }
        }
    }
    count
}

fn report(name: &str, triangles: &[[Triangle; 8]], light: Point, groups: &[[Point; 8]]) -> Shares {
    let count = run(triangles, light, groups);
    println!("{name}: leaf tests: {}; settled by the group test: {}", count.leaf, count.by_group);
    count.leaf
}

/// A soup of triangles of the given size in a cube of side 2.
fn soup(rng: &mut Rng, size: f64) -> Vec<[Triangle; 8]> {
    let mut point = || [0; 3].map(|_| (rng.unit() * 2.0 - 1.0) as f32);
    let mut triangle = || {
        let [at, u, v] = [point(), point(), point()];
        [at, between(at, u, size), between(at, v, size)]
    };
    (0..64).map(|_| [0; 8].map(|_| triangle())).collect()
}

/// Eight samples on a triangle of the soup, moved off it by `lift` of its size: what a picture asks for.
fn on_surface(rng: &mut Rng, t: &Triangle, lift: f64) -> [Point; 8] {
    [0; 8].map(|_| {
        let (u, v) = (rng.unit() * 0.5, rng.unit() * 0.5);
        let x = |i: usize, k: usize| f64::from(t[i][k]);
        let [e, f] = [1, 2].map(|i| [0, 1, 2].map(|k| x(i, k) - x(0, k)));
        let n = [e[1] * f[2] - e[2] * f[1], e[2] * f[0] - e[0] * f[2], e[0] * f[1] - e[1] * f[0]];
        let scale = lift / n.iter().map(|x| x * x).sum::<f64>().sqrt().max(1e-30);
        [0, 1, 2].map(|k| finite(x(0, k) + u * e[k] + v * f[k] + scale * n[k]))
    })
}

#[test]
fn generic_scenes_hardly_leave_f32() {
    let mut rng = Rng(12);
    let light = [0.3, -0.2, 1.7];
    for (name, size) in [("large triangles", 1.0), ("small triangles", 0.05)] {
        let triangles = soup(&mut rng, size);
        // Free samples in small boxes, and samples lifted off surfaces by 1e-4, as the sample stage makes them.
        let mut groups: Vec<[Point; 8]> = (0..1000)
            .map(|_| {
                let at = [0; 3].map(|_| (rng.unit() * 2.0 - 1.0) as f32);
                [0; 8].map(|_| at.map(|x| x + (rng.unit() * 0.02) as f32))
            })
            .collect();
        for t in triangles.iter().flatten() {
            groups.push(on_surface(&mut rng, t, 1e-4));
        }
        let shares = report(name, &triangles, light, &groups);
        assert!(shares.total() > 5000);
        assert!(shares.single as f64 > 0.95 * shares.total() as f64, "{shares}");
        assert!(shares.exact as f64 <= 0.01 * (shares.double + shares.exact) as f64, "{shares}");
    }
}

#[test]
fn samples_that_lie_on_their_triangles_hardly_leave_f64() {
    let mut rng = Rng(13);
    let light = [0.3, -0.2, 1.7];
    let triangles = soup(&mut rng, 0.3);
    // Not lifted at all: each sample is within rounding of its own triangle's plane.
    let groups: Vec<_> = triangles.iter().flatten().map(|t| on_surface(&mut rng, t, 0.0)).collect();
    let shares = report("samples on surfaces", &triangles, light, &groups);
    assert!(shares.exact as f64 <= 0.001 * shares.total() as f64, "{shares}");
}

#[test]
fn a_lattice_needs_every_stage() {
    let mut rng = Rng(14);
    let mut point = |n: i32| [0; 3].map(|_| rng.int(-n, n) as f32);
    let triangles: Vec<_> = (0..64).map(|_| [0; 8].map(|_| [point(4), point(4), point(4)])).collect();
    let groups: Vec<_> = (0..1000).map(|_| [0; 8].map(|_| point(4))).collect();
    let shares = report("lattice", &triangles, point(4), &groups);
    assert!(shares.exact > 0 && shares.single > 0, "{shares}");
}
