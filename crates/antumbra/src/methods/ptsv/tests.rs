//! Bounds are conservative, whatever the numbers; the queue may be tiny; views have one number a sample.

use antumbra_predicates::exact;

use super::boxes::{Aabb, Box8, test_extra, test_main};
use super::frustum::Frustum;
use super::space::Space;
use super::{Ptsv, Tuning};
use crate::Isa;
use crate::mask::{LIT, SHADOWED};
use crate::methods::{DebugView, Method, Oracle, Samples};
use crate::samples::View;
use crate::scene::{Camera, Triangle};

/// SplitMix64 (Steele, Lea, Flood 2014).
struct Random(u64);

impl Random {
    fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    fn range(&mut self, r: f32) -> f32 {
        ((self.bits() >> 40) as f32 / (1u32 << 23) as f32 - 1.0) * r
    }

    fn point(&mut self, r: f32) -> [f32; 3] {
        [self.range(r), self.range(r), self.range(r)]
    }
}

fn view() -> View {
    let camera = Camera {
        name: String::new(),
        eye: [0.3, 0.2, 9.0],
        target: [0.0; 3],
        up: [0.0, 1.0, 0.0],
        fov: 60.0,
    };
    View::new(&camera, 64, 48)
}

/// Boxes of one to four samples: a rejected one holds no blocked sample, an accepted one no unblocked sample. Boxes of
/// a single sample leave no slack but the margins, corners on planes make ties.
#[test]
fn rejected_boxes_are_lit_and_accepted_ones_are_shadowed() {
    let mut random = Random(1);
    let (mut rejects, mut accepts, mut extras) = (0, 0, 0);
    for round in 0..20_000 {
        let scale = [1.0, 1e-3, 4.0, 1e15, 1e-30][round % 5];
        let space = match round % 3 {
            0 => Space::clip(&view()),
            1 => Space::World { origin: [0.0; 3] },
            // Axes far from perpendicular.
            _ => Space::clip(&View { right: [0.9, 0.3, 0.2], up: [0.3, 0.4, -0.1], ..view() }),
        };
        let snap =
            |p: [f32; 3]| if round % 2 == 0 { p.map(|v| (v * 2.0 / scale).round() * 0.5 * scale) } else { p };
        let light = snap(random.point(3.0 * scale));
        let triangle: Triangle = [0; 3].map(|_| snap(random.point(3.0 * scale)));
        let count = 1 + random.bits() as usize % 4;
        let mut samples = Vec::new();
        let first = snap(random.point(3.0 * scale));
        for _ in 0..count {
            let d = random.point(0.2 * scale);
            samples.push(if count == 1 { first } else { [0, 1, 2].map(|k| first[k] + d[k]) });
        }
        let (mut lo, mut hi) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
        let mut residual = [0.0f64; 3];
        let mut there = true;
        for p in &samples {
            let c = space.coordinates(*p);
            there &= c.good;
            for k in 0..3 {
                lo[k] = lo[k].min(c.at[k]);
                hi[k] = hi[k].max(c.at[k]);
                residual[k] = residual[k].max(c.residual[k]);
            }
        }
        if !there {
            continue;
        }
        let aabb = Aabb::around(lo, hi);
        let mut boxes = Box8::ZERO;
        boxes.set(0, &aabb);
        let Some(mut frustum) = Frustum::new(&triangle, light, &space, residual) else {
            assert!(exact::facing(&triangle, light) == 0);
            continue;
        };
        assert_eq!(frustum.facing, exact::facing(&triangle, light));
        let (main, extra) = (frustum.main, frustum.extra(&space, residual, true));
        let (reject, accept, more) = fearless_simd::dispatch!(fearless_simd::Level::new(), s => {
            let (reject, accept) = test_main(s, &[boxes], &main, aabb.reach(), 1);
            (reject, accept, test_extra(s, &[boxes], extra, aabb.reach(), 1))
        });
        for p in &samples {
            let blocked = exact::blocks(&triangle, light, *p);
            assert!(!(blocked && reject == 1), "rejected: {triangle:?} {light:?} {p:?}");
            assert!(!(blocked && more == 1), "extra: {triangle:?} {light:?} {p:?}");
            assert!(blocked || accept == 0, "accepted: {triangle:?} {light:?} {p:?}");
        }
        rejects += reject;
        accepts += accept;
        extras += more & !reject;
    }
    // The tests are worth something, too.
    assert!(rejects > 5_000 && accepts > 20 && extras < 5_000, "{rejects} {accepts} {extras}");
}

fn soup(seed: u64) -> (Vec<Triangle>, Vec<[f32; 3]>) {
    let mut random = Random(seed);
    let triangles = (0..80).map(|_| [random.point(3.0), random.point(3.0), random.point(3.0)]).collect();
    let samples = (0..64 * 48).map(|_| random.point(4.0)).collect();
    (triangles, samples)
}

#[test]
fn smallest_queue_and_budget_give_the_same_mask() {
    let (triangles, positions) = soup(7);
    let light = [0.1, 0.2, 0.3];
    let view = view();
    let samples = Samples { positions: &positions, width: 64, view: Some(&view) };
    let mut expected = vec![9; positions.len()];
    Oracle.shadow(&triangles, samples, light, &mut expected).expect("finite");
    for (budget, queue) in [(1, 0), (1, 3), (2, 1 << 16), (1 << 30, 0)] {
        let mut method = Ptsv::with_tuning(Isa::Auto, Tuning { budget, queue, ..Tuning::default() });
        let mut mask = vec![9; positions.len()];
        for _ in 0..2 {
            let stats = method.shadow(&triangles, samples, light, &mut mask).expect("finite");
            assert_eq!(mask, expected, "{budget} {queue}");
            let counter = |name| stats.counters.iter().find(|c| c.0 == name).map_or(0, |c| c.1);
            assert_eq!(counter("queue_flushes") > 0, budget == 1 && queue < 4, "{budget} {queue}");
            assert!(counter("queue_peak") <= queue as u64);
        }
    }
}

#[test]
fn views_have_one_number_a_sample() {
    let (triangles, mut positions) = soup(8);
    positions[5] = [f32::NAN; 3];
    let view = view();
    for samples in
        [Samples { positions: &positions, width: 64, view: Some(&view) }, Samples::list(&positions)]
    {
        let mut mask = vec![9; positions.len()];
        let mut method = Ptsv::default();
        method.shadow(&triangles, samples, [0.0; 3], &mut mask).expect("finite");
        for DebugView { name, .. } in method.debug_views() {
            let out = method.debug_view(name, &triangles, samples, [0.0; 3]).expect("finite").expect("known");
            assert_eq!(out.len(), positions.len());
            assert!(out.iter().enumerate().all(|(i, v)| v.is_nan() == (i == 5)));
            if *name == "level" {
                assert!(
                    out.iter()
                        .zip(&mask)
                        .all(|(v, m)| (*v > 0.0) == (*m == SHADOWED) && (*v == 0.0) == (*m == LIT))
                );
            }
        }
        assert!(method.debug_view("nothing", &triangles, samples, [0.0; 3]).expect("finite").is_none());
    }
}

#[test]
fn without_front_faces_a_closed_box_still_shadows() {
    let quad = |a: [f32; 3], b: [f32; 3], c: [f32; 3], d: [f32; 3]| [[a, b, c], [a, c, d]];
    let v = |i: usize| [(i & 1) as f32, (i >> 1 & 1) as f32, (i >> 2 & 1) as f32];
    let faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let triangles: Vec<Triangle> =
        faces.iter().flat_map(|f| quad(v(f[0]), v(f[1]), v(f[2]), v(f[3]))).collect();
    let light = [0.4, 0.45, 5.0];
    let mut random = Random(3);
    let positions: Vec<_> = (0..3000)
        .map(|_| {
            let p = random.point(3.0);
            [p[0], p[1], -1.5]
        })
        .collect();
    let samples = Samples::list(&positions);
    let mut full = vec![9; positions.len()];
    let mut culled = full.clone();
    Ptsv::default().shadow(&triangles, samples, light, &mut full).expect("finite");
    let tuning = Tuning { cull_front_faces: true, ..Tuning::default() };
    let stats =
        Ptsv::with_tuning(Isa::Auto, tuning).shadow(&triangles, samples, light, &mut culled).expect("finite");
    assert_eq!(full, culled);
    assert!(full.contains(&SHADOWED) && full.contains(&LIT));
    assert!(stats.counters.iter().any(|c| c.0 == "culled_tris" && c.1 == 2));
}
