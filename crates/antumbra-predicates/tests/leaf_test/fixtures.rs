//! Hard inputs, one per line, with their verdicts: `fixtures/*.txt`.
//!
//! `a b c light sample` in hexadecimal bit patterns, then `facing ab bc ca beyond blocks`. `regressions.txt` holds what once
//! came out wrong; the other files were drawn from the generator by [`write_fixtures`], their verdicts from the oracle.

use std::{fs, path::PathBuf};

use antumbra_predicates::{Decided, Resolver, exact};

use crate::cases::{Case, Law, Point, Rng, Triangle, line};
use crate::filter::{Tally, check_at, levels};
use crate::oracle::{self, Truth};

fn folder() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("fixtures")
}

fn parse(text: &str) -> Option<(Triangle, Point, Point, [i8; 6])> {
    let (input, verdict) = text.split_once('|')?;
    let mut words = input.split_whitespace().map(|w| u32::from_str_radix(w, 16).map(f32::from_bits));
    let mut points = [[0.0; 3]; 5];
    for x in points.iter_mut().flatten() {
        *x = words.next()?.ok()?;
    }
    let verdict: Vec<i8> = verdict.split_whitespace().map(|w| w.parse()).collect::<Result<_, _>>().ok()?;
    let [a, b, c, light, sample] = points;
    Some(([a, b, c], light, sample, verdict.try_into().ok()?))
}

fn verdict(t: &Truth) -> [i8; 6] {
    [t.facing, t.sides[0], t.sides[1], t.sides[2], t.beyond, i8::from(t.blocks)]
}

/// The fixture's pair alone in its box, then in boxes that reach to the corners of the triangle.
fn boxes(t: &Triangle, light: Point, p: Point) -> [Case; 4] {
    [p, t[0], t[1], t[2]].map(|far| {
        let lo = [0, 1, 2].map(|k| p[k].min(far[k]));
        let hi = [0, 1, 2].map(|k| p[k].max(far[k]));
        let mut samples = [p; 16];
        for (i, s) in samples[..8].iter_mut().enumerate() {
            *s = [0, 1, 2].map(|k| if i >> k & 1 == 0 { lo[k] } else { hi[k] });
        }
        let [a, b, c] = *t;
        let orders = [[a, b, c], [b, c, a], [c, a, b], [b, a, c], [a, c, b], [c, b, a], [a, b, c], [b, a, c]];
        Case { law: Law::Bits, light, triangles: orders, samples, lo, hi }
    })
}

#[test]
fn every_fixture_has_its_verdict_at_every_stage() {
    let levels = levels();
    let mut read = 0;
    for entry in fs::read_dir(folder()).expect("fixtures") {
        let path = entry.expect("fixtures").path();
        for (number, text) in fs::read_to_string(&path).expect("fixture").lines().enumerate() {
            if text.is_empty() || text.starts_with('#') {
                continue;
            }
            let at = format!("{}:{}", path.display(), number + 1);
            let (t, light, p, want) = parse(text).unwrap_or_else(|| panic!("{at}: not a fixture"));
            assert_eq!(verdict(&oracle::ask(&t, light, p)), want, "{at}: oracle");
            let sides = [0, 1, 2].map(|k| exact::side(t[k], t[(k + 1) % 3], p, light));
            assert_eq!((exact::facing(&t, light), exact::beyond(&t, p)), (want[0], want[4]), "{at}");
            assert_eq!(sides, want[1..4], "{at}: sides");
            let resolved = Resolver::new(&t, light).is_some_and(|r| r.blocks(p).0);
            assert_eq!(i8::from(resolved), want[5], "{at}: resolver");
            for case in boxes(&t, light, p) {
                let truth = case.truth();
                for &level in &levels {
                    check_at(level, &case, 0xff, &truth, &mut Tally::default());
                }
            }
            read += 1;
        }
    }
    assert!(read > 200, "{read} fixtures");
}

/// Draws the fixtures again: `cargo test -p antumbra-predicates -- --ignored write_fixtures`.
#[test]
#[ignore = "writes into the source tree"]
fn write_fixtures() {
    let files: [(&str, &str, fn(Law) -> bool); 5] = [
        ("lattice", "small integers: every kind of tie", |l| l == Law::Lattice),
        ("offset", "a huge common offset, differences of a few ulps", |l| matches!(l, Law::Offset(_))),
        ("rounded", "uniform coordinates; points rounded onto edges, planes and rays", |l| l == Law::Uniform),
        ("extremes", "up to 3.4e38 and down to 1e-45", |l| {
            matches!(l, Law::Huge | Law::Subnormal | Law::Scaled(_))
        }),
        ("mixed", "any exponents together, and magnitudes about the filter's limit", |l| {
            matches!(l, Law::Bits | Law::Limit)
        }),
    ];
    let mut rng = Rng(15);
    for (name, what, wanted) in files {
        let mut text = format!("# {what}\n");
        // Blocked and free pairs that f64 cannot decide; ties without that; and pairs that any stage decides.
        let mut room = [20, 20, 10, 6];
        while room.iter().any(|&n| n > 0) {
            let case = Case::random(&mut rng);
            if !wanted(case.law) {
                continue;
            }
            let (t, p) = (case.triangles[rng.int(0, 7) as usize], case.samples[rng.int(0, 15) as usize]);
            let truth = oracle::ask(&t, case.light, p);
            let hard = Resolver::new(&t, case.light).is_some_and(|r| r.blocks(p).1 == Decided::Exact);
            let kind = match (hard, truth.blocks, truth.tie) {
                (true, true, _) => 0,
                (true, false, _) => 1,
                (false, _, true) => 2,
                _ => 3,
            };
            if room[kind] > 0 {
                room[kind] -= 1;
                text += &line(&t, case.light, p, &truth);
                text.push('\n');
            }
        }
        fs::write(folder().join(format!("{name}.txt")), text).expect("write fixture");
    }
}
