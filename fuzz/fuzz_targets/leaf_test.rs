//! Filter, resolver and expansions against big integers.
#![no_main]

use antumbra_predicates::{Coefficients, Resolver, SampleGroup, Triangle, TriangleBlock, exact};
use fearless_simd::{Level, Simd, SimdBase, dispatch, f32x8};
use libfuzzer_sys::fuzz_target;

#[path = "../../crates/antumbra-predicates/tests/leaf_test/oracle.rs"]
#[allow(dead_code)]
mod oracle;

type Point = [f32; 3];

/// Three corners, a light and two samples. A coordinate is one byte for small fractions and for neighbours of the last
/// coordinate on the same axis, so that the fuzzer finds ties easily, and five bytes for any bit pattern.
fn decode(mut bytes: &[u8]) -> Option<[Point; 6]> {
    let mut points = [[0.0f32; 3]; 6];
    for i in 0..6 {
        for axis in 0..3 {
            let (&tag, rest) = bytes.split_first()?;
            bytes = rest;
            points[i][axis] = match tag {
                0..128 => (f32::from(tag) - 64.0) / 4.0,
                128..192 => {
                    let before = if i == 0 { 1.0 } else { points[i - 1][axis] };
                    let bits = before.to_bits().wrapping_add(u32::from(tag)).wrapping_sub(160);
                    f32::from_bits(bits)
                }
                192.. => {
                    let (word, rest) = bytes.split_first_chunk::<4>()?;
                    bytes = rest;
                    f32::from_le_bytes(*word)
                }
            };
        }
    }
    points.iter().flatten().all(|x| x.is_finite()).then_some(points)
}

fn line(t: &Triangle, light: Point, p: Point, truth: &oracle::Truth) -> String {
    let words: Vec<String> =
        t.iter().chain([&light, &p]).flatten().map(|x| format!("{:08x}", x.to_bits())).collect();
    let [ab, bc, ca] = truth.sides;
    format!(
        "{} | {} {ab} {bc} {ca} {} {}",
        words.join(" "),
        truth.facing,
        truth.beyond,
        u8::from(truth.blocks)
    )
}

/// Lane 3 of a full block, each sample in lanes of its own: (maybe, covers, [(blocked, unsure); 2]).
#[inline(always)]
fn filter<S: Simd>(
    s: S,
    t: &Triangle,
    light: Point,
    samples: [Point; 2],
    facing: i8,
) -> (bool, bool, [(bool, bool); 2]) {
    const LANE: usize = 3;
    let [u, v] = samples;
    let group =
        SampleGroup::from_bounds([0, 1, 2].map(|k| u[k].min(v[k])), [0, 1, 2].map(|k| u[k].max(v[k])));
    let mut tests = Coefficients::ZERO;
    let triangles = TriangleBlock { corner: t.map(|p| p.map(|x| [x; 8])) };
    let verdict = triangles.against(s, 0xff, light, &group, &mut tests);
    let bit = |mask: u8, i: usize| mask >> i & 1 == 1;
    if bit(verdict.edge_on, LANE) {
        match facing {
            0 => return (false, bit(verdict.covers, LANE), [(false, false); 2]),
            -1 => tests.flip(LANE),
            _ => {}
        }
    }
    let p = [0, 1, 2].map(|k| f32x8::from_fn(s, |i| samples[i % 2][k]));
    let lanes = tests.test(s, LANE, p);
    let of = |i: usize| (bit(lanes.blocked, i), bit(lanes.unsure, i));
    (bit(verdict.maybe, LANE), bit(verdict.covers, LANE), [of(0), of(1)])
}

fuzz_target!(|bytes: &[u8]| {
    let Some([a, b, c, light, u, v]) = decode(bytes) else { return };
    let (t, samples) = ([a, b, c], [u, v]);
    let oracle = oracle::Oracle::new(&t, light);
    let truth = samples.map(|p| oracle.ask(p));
    let resolver = Resolver::new(&t, light);
    assert_eq!(resolver.map_or(0, |r| r.facing()), truth[0].facing);
    for (p, truth) in samples.into_iter().zip(&truth) {
        let at = || line(&t, light, p, truth);
        let sides = [0, 1, 2].map(|k| exact::side(t[k], t[(k + 1) % 3], p, light));
        assert_eq!((sides, exact::beyond(&t, p)), (truth.sides, truth.beyond), "exact: {}", at());
        assert_eq!(resolver.is_some_and(|r| r.blocks(p).0), truth.blocks, "resolver: {}", at());
    }
    for level in [Level::fallback(), Level::new()] {
        let (maybe, covers, lanes) = dispatch!(level, s => filter(s, &t, light, samples, truth[0].facing));
        for i in 0..2 {
            let at = || format!("{level:?}: {}", line(&t, light, samples[i], &truth[i]));
            let blocks = truth[i].blocks;
            assert!(maybe || !blocks, "rejected: {}", at());
            assert!(!covers || blocks, "covers: {}", at());
            let (blocked, unsure) = lanes[i];
            assert!(!maybe || unsure || blocked == blocks, "leaf test: {}", at());
        }
    }
});
