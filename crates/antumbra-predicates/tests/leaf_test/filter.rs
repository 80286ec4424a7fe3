//! First stage: whatever the filter is certain of is true, at every instruction set, for every sample of the box.
#![expect(clippy::print_stdout, reason = "the tally is a result of the test")]

use antumbra_predicates::single::TriangleTest;
use antumbra_predicates::{BlockVerdict, Coefficients, Lanes, SampleGroup, TriangleBlock};
use fearless_simd::{Level, Simd, SimdBase, dispatch, f32x8};

use crate::cases::{Case, Point, Rng, Triangle, line};
use crate::oracle::{Truth, within};

/// All instruction sets that this machine has, the scalar fallback first.
pub(crate) fn levels() -> Vec<Level> {
    let best = Level::new();
    #[allow(unused_mut, reason = "only x86 has more than one level")]
    let mut all = vec![Level::fallback()];
    #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
    {
        all.extend(best.as_sse2().map(|token| token.level()));
        all.extend(best.as_sse4_2().map(|token| token.level()));
        all.extend(best.as_avx2().map(|token| token.level()));
        all.extend(best.as_avx512().map(|token| token.level()));
    }
    if !all.iter().any(|l| format!("{l:?}") == format!("{best:?}")) {
        all.push(best);
    }
    all
}

/// How often the filter was certain, so that a filter which is never certain does not pass for a right one.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Tally {
    /// Triangles thrown out for a whole group, and found to cover it.
    pub(crate) rejected: u32,
    pub(crate) covering: u32,
    pub(crate) edge_on: u32,
    /// Triangles turned over after the exact facing was asked.
    pub(crate) flipped: u32,
    /// Single samples found free, blocked, left open.
    pub(crate) free: u32,
    pub(crate) blocked: u32,
    pub(crate) unsure: u32,
    /// Verdicts of [`Coefficients::refine`] that were certain.
    pub(crate) refined: u32,
    /// Single samples that the test without a group was sure of.
    pub(crate) single_sure: u32,
}

pub(crate) fn block(triangles: &[Triangle; 8]) -> TriangleBlock {
    let mut corner = [[[0.0; 8]; 3]; 3];
    for (lane, t) in triangles.iter().enumerate() {
        for i in 0..3 {
            for k in 0..3 {
                corner[i][k][lane] = t[i][k];
            }
        }
    }
    TriangleBlock { corner }
}

/// The kernels behind one `dispatch!` each: every call that is compiled for every level costs seconds of build time.
pub(crate) fn against_at(
    level: Level,
    triangles: &TriangleBlock,
    live: u8,
    light: Point,
    group: &SampleGroup,
) -> (BlockVerdict, Coefficients) {
    let mut tests = Coefficients::ZERO;
    let verdict = dispatch!(level, s => triangles.against(s, live, light, group, &mut tests));
    (verdict, tests)
}

/// As [`against_at`].
pub(crate) fn test_at(level: Level, tests: &Coefficients, lane: usize, samples: &[Point]) -> Lanes {
    let p = [0, 1, 2].map(|k| {
        let mut axis = [0.0; 8];
        for (x, sample) in axis.iter_mut().zip(samples) {
            *x = sample[k];
        }
        axis
    });
    dispatch!(level, s => tests.test(s, lane, [0, 1, 2].map(|k| f32x8::load_array_ref(s, &p[k]))))
}

/// As [`against_at`].
fn single_at(level: Level, test: &TriangleTest, samples: &[Point]) -> Lanes {
    let p = [0, 1, 2].map(|k| {
        let mut axis = [0.0; 8];
        for (x, sample) in axis.iter_mut().zip(samples) {
            *x = sample[k];
        }
        axis
    });
    dispatch!(level, s => test.lanes(s, [0, 1, 2].map(|k| f32x8::load_array_ref(s, &p[k]))))
}

/// [`TriangleTest`], which knows no group, against the truth.
fn check_single(level: Level, case: &Case, truth: &[[Truth; 16]; 8], tally: &mut Tally) {
    for (t, truths) in case.triangles.iter().zip(truth) {
        let Some(test) = TriangleTest::new(t, case.light) else {
            assert_eq!(truths[0].facing, 0, "dropped: {}", line(t, case.light, case.samples[0], &truths[0]));
            continue;
        };
        assert_ne!(truths[0].facing, 0, "degenerate: {}", line(t, case.light, case.samples[0], &truths[0]));
        let lanes = [0, 8].map(|first| single_at(level, &test, &case.samples[first..]));
        for (i, (&p, truth)) in case.samples.iter().zip(truths).enumerate() {
            let Lanes { blocked, unsure } = lanes[i / 8];
            let wrong = || format!("single, {level:?}, {:?}: {}", case.law, line(t, case.light, p, truth));
            match (blocked >> (i % 8) & 1, unsure >> (i % 8) & 1) {
                (1, 0) => {
                    tally.single_sure += 1;
                    assert!(truth.blocks, "blocked: {}", wrong());
                }
                (0, 0) => {
                    tally.single_sure += 1;
                    assert!(!truth.blocks, "free: {}", wrong());
                }
                (0, 1) => {}
                _ => panic!("blocked and unsure: {}", wrong()),
            }
        }
    }
}

/// Coefficients of a group (facings settled) against its two halves of eight samples.
fn check_refined(
    level: Level,
    case: &Case,
    lanes: u8,
    truth: &[[Truth; 16]; 8],
    tests: &Coefficients,
    tally: &mut Tally,
) {
    for first in [0, 8] {
        let samples = &case.samples[first..first + 8];
        if samples.iter().flatten().any(|v| v.is_nan()) {
            continue;
        }
        let fold = |f: fn(f32, f32) -> f32| {
            [0, 1, 2].map(|k| samples.iter().map(|p| p[k]).reduce(f).expect("eight samples"))
        };
        let part = SampleGroup::from_bounds(fold(f32::min), fold(f32::max));
        let (maybe, covers) = dispatch!(level, s => tests.refine(s, &part));
        for lane in (0..8).filter(|lane| lanes >> lane & 1 == 1 && truth[*lane][0].facing != 0) {
            tally.refined += u32::from(maybe >> lane & 1 == 0) + u32::from(covers >> lane & 1);
            for (&p, truth) in samples.iter().zip(&truth[lane][first..]) {
                let wrong = || {
                    format!(
                        "refined, {level:?}, {:?}: {}",
                        case.law,
                        line(&case.triangles[lane], case.light, p, truth)
                    )
                };
                assert!(maybe >> lane & 1 == 1 || !truth.blocks, "rejected: {}", wrong());
                assert!(covers >> lane & 1 == 0 || truth.blocks, "covers: {}", wrong());
            }
        }
    }
}

/// The shared runner: one block of triangles against one group at one level, everything that is certain compared with the
/// truth.
pub(crate) fn check_at(level: Level, case: &Case, live: u8, truth: &[[Truth; 16]; 8], tally: &mut Tally) {
    check_single(level, case, truth, tally);
    let mut triangles = case.triangles;
    for (lane, t) in triangles.iter_mut().enumerate() {
        if live >> lane & 1 == 0 {
            // Whatever is in a dead lane must not matter.
            *t = [[f32::NAN, f32::INFINITY, -0.0]; 3];
        }
    }
    let group = SampleGroup::from_bounds(case.lo, case.hi);
    let (verdict, mut tests) = against_at(level, &block(&triangles), live, case.light, &group);
    assert_eq!(verdict.maybe & !live, 0, "dead lanes");
    assert_eq!(verdict.covers & !verdict.maybe, 0, "covers without maybe");
    assert_eq!(verdict.edge_on & !verdict.maybe, 0, "edge-on without maybe");
    for lane in (0..8).filter(|lane| live >> lane & 1 == 1) {
        let (t, truths) = (&case.triangles[lane], &truth[lane]);
        let bit = |mask: u8| mask >> lane & 1 == 1;
        let wrong = |p: Point, truth: &Truth| {
            format!("{level:?}, {:?}, lane {lane}: {}", case.law, line(t, case.light, p, truth))
        };
        for (&p, truth) in case.samples.iter().zip(truths) {
            assert!(bit(verdict.maybe) || !truth.blocks, "rejected: {}", wrong(p, truth));
            assert!(!bit(verdict.covers) || truth.blocks, "covers: {}", wrong(p, truth));
        }
        tally.covering += u32::from(bit(verdict.covers));
        if !bit(verdict.maybe) {
            tally.rejected += 1;
            continue;
        }
        let facing = truths[0].facing;
        if bit(verdict.edge_on) {
            // As a method does: the exact facing is asked before the samples are.
            tally.edge_on += 1;
            match facing {
                0 => continue,
                -1 => {
                    tally.flipped += 1;
                    tests.flip(lane);
                }
                _ => {}
            }
        }
        assert_ne!(facing, 0, "degenerate, and not said so: {}", wrong(case.samples[0], &truths[0]));
        let lanes = [0, 8].map(|first| test_at(level, &tests, lane, &case.samples[first..]));
        for (i, (&p, truth)) in case.samples.iter().zip(truths).enumerate() {
            let Lanes { blocked, unsure } = lanes[i / 8];
            match (blocked >> (i % 8) & 1, unsure >> (i % 8) & 1) {
                (1, 0) => {
                    tally.blocked += 1;
                    assert!(truth.blocks, "blocked: {}", wrong(p, truth));
                }
                (0, 1) => tally.unsure += 1,
                (0, 0) => {
                    tally.free += 1;
                    assert!(!truth.blocks, "free: {}", wrong(p, truth));
                }
                _ => panic!("blocked and unsure: {}", wrong(p, truth)),
            }
        }
    }
    check_refined(level, case, live & verdict.maybe, truth, &tests, tally);
}

#[test]
fn certain_is_true_at_every_level() {
    let levels = levels();
    let mut tallies = vec![Tally::default(); levels.len()];
    let mut rng = Rng(4);
    for round in 0..2000 {
        let case = Case::random(&mut rng);
        let truth = case.truth();
        let live = if round % 2 == 0 { 0xff } else { rng.next() as u8 };
        for (&level, tally) in levels.iter().zip(&mut tallies) {
            check_at(level, &case, live, &truth, tally);
        }
    }
    for (level, t) in levels.iter().zip(&tallies) {
        println!("{level:?}: {t:?}");
        assert!(t.rejected > 1000 && t.covering > 300 && t.flipped > 1000, "{t:?}");
        assert!(t.free > 10_000 && t.blocked > 5000 && t.unsure > 10_000, "{t:?}");
    }
}

#[test]
fn group_holds_its_samples() {
    let mut rng = Rng(5);
    for _ in 0..20_000 {
        let case = Case::random(&mut rng);
        let group = SampleGroup::from_bounds(case.lo, case.hi);
        for p in case.samples {
            for k in 0..3 {
                let (x, c, h) = (p[k], group.center[k], group.half[k]);
                assert!(h == f32::INFINITY || within(x, c, h), "{x:e} outside {c:e} ± {h:e}");
            }
        }
    }
}

#[test]
fn background_samples_are_never_certain() {
    for seed in 0..50 {
        let case = Case::random(&mut Rng(seed));
        let group = SampleGroup::from_bounds(case.lo, case.hi);
        for level in levels() {
            let (_, tests) = against_at(level, &block(&case.triangles), 0xff, case.light, &group);
            for lane in 0..8 {
                let lanes = test_at(level, &tests, lane, &[[f32::NAN; 3]; 8]);
                assert_eq!(lanes, Lanes { blocked: 0, unsure: 0xff });
            }
        }
    }
}
