//! Third stage: the expansions of `robust` equal the integers, sign by sign, over the whole range of `f32`.

use antumbra_predicates::exact;

use crate::cases::{Case, Rng, line};

#[test]
fn every_sign_is_right() {
    let mut rng = Rng(1);
    let (mut ties, mut blocked) = (0, 0);
    for _ in 0..1500 {
        let case = Case::random(&mut rng);
        let light = case.light;
        for (t, truths) in case.triangles.iter().zip(case.truth()) {
            assert_eq!(exact::facing(t, light), truths[0].facing);
            for (&p, truth) in case.samples.iter().zip(&truths) {
                let sides = [0, 1, 2].map(|k| exact::side(t[k], t[(k + 1) % 3], p, light));
                let seen = (sides, exact::beyond(t, p), exact::blocks(t, light, p));
                let want = (truth.sides, truth.beyond, truth.blocks);
                assert_eq!(seen, want, "{:?}: {}", case.law, line(t, light, p, truth));
                ties += u32::from(truth.tie);
                blocked += u32::from(truth.blocks);
            }
        }
    }
    // The generator is worth nothing if it makes no ties and no blockers.
    assert!(ties > 20_000 && blocked > 10_000, "{ties} ties, {blocked} blocked");
}

#[test]
fn tie_break_is_zero_only_if_collinear_with_the_light() {
    let mut rng = Rng(2);
    let mut zeros = 0;
    for _ in 0..20_000 {
        let [a, b, l] = [0; 3].map(|_| [0; 3].map(|_| rng.int(-2, 2) as f32));
        let [u, v] = [a, b].map(|p| [0, 1, 2].map(|k| (p[k] - l[k]) as i32));
        let cross = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
        let first = cross.iter().find(|&&x| x != 0).map_or(0, |x| x.signum() as i8);
        assert_eq!(exact::tie_break(a, b, l), first);
        zeros += u32::from(first == 0);
    }
    assert!(zeros > 100);
}
