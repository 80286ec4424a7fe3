//! Second stage: what `Resolver` says is the truth, always; and f64 decides where it can.

use antumbra_predicates::{Decided, Resolver, resolve};

use crate::cases::{Case, Rng, line};

#[test]
fn every_answer_is_right() {
    let mut rng = Rng(3);
    let (mut double, mut exact) = (0u32, 0u32);
    for _ in 0..1500 {
        let case = Case::random(&mut rng);
        let light = case.light;
        for (t, truths) in case.triangles.iter().zip(case.truth()) {
            let resolver = Resolver::new(t, light);
            assert_eq!(resolver.map_or(0, |r| r.facing()), truths[0].facing, "{:?}", case.law);
            for (&p, truth) in case.samples.iter().zip(&truths) {
                let (blocks, decided) = resolver.map_or((false, Decided::Double), |r| r.blocks(p));
                assert_eq!(blocks, truth.blocks, "{:?}: {}", case.law, line(t, light, p, truth));
                match decided {
                    Decided::Double => double += 1,
                    Decided::Exact => exact += 1,
                }
            }
            assert_eq!(resolve::blocks(t, light, case.samples[9]), truths[9].blocks);
        }
    }
    // Both stages have been at work.
    assert!(double > 100_000 && exact > 5000, "{double} by f64, {exact} exactly");
}
