//! Bounds hold for whatever blocks; lists hold every sample once; small rounds change nothing.

use antumbra_predicates::exact;

use super::face::{PAD, Shadow, direction};
use super::grid::Axis;
use super::*;
use crate::methods::Oracle;

/// SplitMix64.
struct Random(u64);

impl Random {
    fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    fn unit(&mut self) -> f64 {
        (self.bits() >> 11) as f64 / (1u64 << 53) as f64
    }

    /// A point of one of several kinds: a lattice (ties), a cube, many magnitudes.
    fn point(&mut self, kind: u64) -> [f32; 3] {
        [0; 3].map(|_: i32| match kind {
            0 => (self.bits() % 5) as f32 - 2.0,
            1 => (self.unit() * 4.0 - 2.0) as f32,
            2 => 1e6 + self.unit() as f32,
            _ => {
                let v = f32::from_bits(self.bits() as u32);
                if v.is_finite() { v } else { 0.0 }
            }
        })
    }
}

#[test]
fn values_lie_in_the_cells_that_they_are_counted_in() {
    let mut random = Random(1);
    for round in 0..2000 {
        let a = random.unit() * 2.0 - 1.0;
        let b = if round % 3 == 0 { a + random.unit() * 1e-14 } else { random.unit() * 2.0 - 1.0 };
        let (lo, hi) = (a.min(b), a.max(b));
        let axis = Axis::new(lo, hi, 1 + (random.bits() % 700) as u32);
        let mut values: Vec<f64> =
            (0..20).map(|_| (lo + random.unit() * (hi - lo)).clamp(lo, hi)).chain([lo, hi]).collect();
        values.sort_by(f64::total_cmp);
        for x in &values {
            let k = axis.index(*x);
            let [begin, end] = axis.ends(k, k);
            assert!(k < axis.n && begin - PAD / 4.0 <= *x && *x <= end + PAD / 4.0, "{x} {k} {axis:?}");
        }
        assert!(values.is_sorted_by_key(|x| axis.index(*x)));
    }
}

#[test]
fn no_blocked_sample_escapes_the_bounds() {
    let mut random = Random(2);
    let mut blocked = 0;
    for round in 0..60_000 {
        let kind = round % 4;
        let t = [random.point(kind), random.point(kind), random.point(kind)];
        let light = random.point(kind);
        // Every other sample behind the triangle, so that many are blocked.
        let w = [random.unit(), random.unit(), random.unit()];
        let sum = w[0] + w[1] + w[2];
        let p = if round % 8 < 4 {
            random.point(kind)
        } else {
            let far = 1.0 + random.unit();
            [0, 1, 2].map(|k| {
                let on: f64 = (0..3).map(|c| w[c] / sum * f64::from(t[c][k])).sum();
                let l = f64::from(light[k]);
                (l + (on - l) * far).clamp(-3e38, 3e38) as f32
            })
        };
        if !exact::blocks(&t, light, p) {
            continue;
        }
        blocked += 1;
        let d = direction(p, light).expect("a blocked sample is not at the light");
        let shadow = Shadow::new(&t, light).expect("not degenerate");
        let window = [[d.uv[0]; 2], [d.uv[1]; 2]];
        let on_face = shadow.on_face(d.face, window).unwrap_or_else(|| panic!("{t:?} {light:?} {p:?}"));
        for size in [0.0, 1e-12, 0.01, 1.0] {
            let v = [d.uv[1] - size * random.unit(), d.uv[1] + size * random.unit()];
            let u = [d.uv[0] - size * random.unit(), d.uv[0] + size * random.unit()];
            let span = on_face.span(v).unwrap_or_else(|| panic!("{t:?} {light:?} {p:?} {v:?}"));
            assert!(span[0] <= d.uv[0] && d.uv[0] <= span[1], "{t:?} {light:?} {p:?} {span:?}");
            assert!(!on_face.in_front_of_plane(u, v, d.depth), "{t:?} {light:?} {p:?}");
        }
    }
    assert!(blocked > 8_000, "{blocked}");
}

/// A soup around the light, samples all around, some of them crowded, some in one direction, some missing.
fn scene(seed: u64, samples: usize) -> (Vec<Triangle>, Vec<[f32; 3]>, [f32; 3]) {
    let mut random = Random(seed);
    let triangles = (0..300)
        .map(|_| {
            let c = random.point(1);
            [c, c, c].map(|c| [0, 1, 2].map(|k| c[k] + 0.3 * random.point(1)[k]))
        })
        .collect();
    let positions = (0..samples)
        .map(|i| match i % 8 {
            0 => [f32::NAN; 3],
            1 => [1.0 + 2.0 * i as f32; 3],
            2 | 3 => [0, 1, 2].map(|k| 3.0 + 1e-3 * random.point(1)[k]),
            _ => [0, 1, 2].map(|k| 4.0 * random.point(1)[k]),
        })
        .collect();
    (triangles, positions, random.point(1))
}

#[test]
fn any_size_of_rounds_and_any_number_of_threads_work_alike() {
    let (triangles, positions, light) = scene(5, 6000);
    let samples = Samples::list(&positions);
    let mut expected = vec![0; positions.len()];
    Oracle.shadow(&triangles, samples, light, &mut expected).unwrap();
    let mut counters = Vec::new();
    for threads in [1, 2, 3] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        for (run, pairs) in [(1 << 16, 1 << 20), (7, 1), (300, 50)] {
            let mut method = Ofts::new(&Options::default());
            method.round_triangles = run;
            method.set_round_pairs(pairs);
            let mut mask = vec![9; positions.len()];
            // The second call finds memory of the first.
            pool.install(|| method.shadow(&triangles[..20], samples, light, &mut mask)).unwrap();
            let stats = pool.install(|| method.shadow(&triangles, samples, light, &mut mask)).unwrap();
            assert!(mask == expected, "{threads} threads, rounds of {run} triangles, {pairs} pairs");
            let flushes = stats.counters.iter().find(|c| c.0 == "queue_flushes").unwrap().1;
            assert_eq!(flushes > 0, run < 1000);
            counters.push((run, stats.counters));
        }
    }
    for (run, found) in &counters {
        let first = counters.iter().find(|c| c.0 == *run).unwrap();
        assert_eq!(first.1, *found, "work depends on the number of threads");
    }
}

#[test]
fn lists_are_short_unless_samples_share_a_direction() {
    let (triangles, mut positions, light) = scene(6, 40_000);
    let mut method = Ofts::new(&Options::default());
    positions.retain(|p| p[0] != p[1]);
    let mut mask = vec![0; positions.len()];
    let stats = method.shadow(&triangles, Samples::list(&positions), light, &mut mask).unwrap();
    let counter = |name: &str| stats.counters.iter().find(|c| c.0 == name).unwrap().1;
    assert!(counter("list_len_max") <= tuning::LIST_MAX as u64, "{:?}", stats.counters);
    assert!(counter("sub_grids") > 0);

    let same: Vec<_> = (1..5000).map(|i| [i as f32, 2.0 * i as f32, -3.0 * i as f32]).collect();
    let mut mask = vec![0; same.len()];
    let mut expected = mask.clone();
    Oracle.shadow(&triangles, Samples::list(&same), [0.0; 3], &mut expected).unwrap();
    let stats = method.shadow(&triangles, Samples::list(&same), [0.0; 3], &mut mask).unwrap();
    assert!(mask == expected);
    assert_eq!(stats.counters.iter().find(|c| c.0 == "active_faces").unwrap().1, 1);
}

#[test]
fn debug_views_agree_with_the_counters() {
    let (triangles, positions, light) = scene(7, 9000);
    let samples = Samples::list(&positions);
    let mut method = Ofts::new(&Options::default());
    let mut mask = vec![0; positions.len()];
    let stats = method.shadow(&triangles, samples, light, &mut mask).unwrap();
    let counter = |name: &str| stats.counters.iter().find(|c| c.0 == name).unwrap().1 as f32;
    for DebugView { name: view, .. } in method.debug_views() {
        let values = method.debug_view(view, &triangles, samples, light).unwrap().unwrap();
        assert!(values.iter().zip(&mask).all(|(v, m)| v.is_nan() == (*m == NONE)), "{view}");
        let known = values.iter().filter(|v| !v.is_nan());
        match *view {
            "tests" => assert_eq!(known.sum::<f32>(), counter("leaf_tests")),
            "list-length" => assert_eq!(known.fold(0.0, |a: f32, &b| a.max(b)), counter("list_len_max")),
            _ => assert!(known.fold(0.0, |a: f32, &b| a.max(b)) >= 1.0),
        }
    }
    assert!(method.debug_view("colour", &triangles, samples, light).unwrap().is_none());
}
