//! How large the rounding of the four tests really is, in units of u times the sum of absolute products: `bounds.md` proves
//! at most 12 (and a little), this climbs towards the worst case and finds less.
#![expect(clippy::print_stdout, reason = "the errors found are a result of the test")]

use fearless_simd::{Level, SimdBase, dispatch, f32x8};

use super::{Coefficients, KAPPA, SampleGroup, TriangleBlock};

type V = [f64; 3];

fn wide(p: [f32; 3]) -> V {
    p.map(f64::from)
}

fn sub(a: V, b: V) -> V {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

fn cross(a: V, b: V) -> V {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn cross_abs(a: V, b: V) -> V {
    let (a, b) = (a.map(f64::abs), b.map(f64::abs));
    [a[1] * b[2] + a[2] * b[1], a[2] * b[0] + a[0] * b[2], a[0] * b[1] + a[1] * b[0]]
}

fn dot(a: V, b: V) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Corners, light, sample.
type Input = [[f32; 3]; 5];

/// The error of each test, in u times the sum of absolute products. f64 stands for the truth: its own error is 2^-29 of
/// what is measured.
fn errors(level: Level, input: &Input) -> [f64; 4] {
    let [a, b, c, light, p] = *input;
    let mut tests = Coefficients::ZERO;
    let group = SampleGroup { center: p, half: [0.0; 3] };
    let triangles = TriangleBlock { corner: [a, b, c].map(|v| v.map(|x| [x; 8])) };
    let mut values = [[0.0; 8]; 4];
    dispatch!(level, s => {
        triangles.against(s, 0xff, light, &group, &mut tests);
        for (value, out) in tests.values(s, 0, p.map(|x| f32x8::splat(s, x))).iter().zip(&mut values) {
            value.store_array(out);
        }
    });
    let [a, b, c, l, p] = input.map(wide);
    let (rel, edge, q) = ([sub(a, l), sub(b, l), sub(c, l)], [sub(b, a), sub(c, b), sub(a, c)], sub(p, a));
    let det = dot(cross(edge[2], edge[0]), rel[0]);
    let det_mag = dot(cross_abs(edge[2], edge[0]), rel[0].map(f64::abs));
    // The filter turns triangles whose facing it is sure of; where it is not, the signs may differ by rounding.
    let sure = det.abs() > 9.0 * 2f64.powi(-24) * det_mag;
    let turned = sure && f64::from(tests.det[0]) * det < 0.0;
    [0, 1, 2, 3].map(|k| {
        let (u, v) = if k < 3 { (rel[k], edge[k]) } else { (edge[2], edge[0]) };
        let constant = if k == 1 { (det, det_mag) } else { (0.0, 0.0) };
        let exact = dot(cross(u, v), q) + constant.0;
        let exact = if turned { -exact } else { exact };
        let sum = dot(cross_abs(u, v), q.map(f64::abs)) + constant.1;
        (f64::from(values[k][0]) - exact).abs() / (sum * 2f64.powi(-24))
    })
}

#[test]
fn rounding_stays_below_the_proven_bound() {
    // xorshift64*: enough for a climb.
    let mut state = 0x2545_f491_4f6c_dd1du64;
    let mut next = move || {
        state ^= state >> 12;
        state ^= state << 25;
        state ^= state >> 27;
        state.wrapping_mul(0x2545_f491_4f6c_dd1d) >> 20
    };
    for level in [Level::fallback(), Level::new()] {
        let mut worst = [0.0f64; 4];
        for start in 0..200 {
            let k = start % 4;
            // Coordinates between 1 and 2: no underflow, which `TINY` covers and this measure does not.
            let mut input: Input = [[0.0; 3]; 5].map(|p| p.map(|_: f32| 1.0 + next() as f32 / 2f32.powi(45)));
            let mut best = errors(level, &input)[k];
            for _ in 0..1000 {
                let (point, axis, step) = (next() as usize % 5, next() as usize % 3, next());
                let old = input[point][axis];
                let reach = 1 << (next() % 22);
                input[point][axis] = f32::from_bits(old.to_bits() ^ (step as u32 & (reach - 1)));
                let now = errors(level, &input)[k];
                if now > best {
                    best = now;
                } else {
                    input[point][axis] = old;
                }
            }
            worst[k] = worst[k].max(best);
        }
        std::println!("{level:?}: worst errors found {worst:.2?} u");
        // Random samples rarely come near a sign that a bound too small would get wrong; this is what guards the constant.
        assert!(worst.iter().all(|&w| w > 1.0 && w < 12.0), "{worst:?}");
        const { assert!(KAPPA >= 12.0 * 0.5 * f32::EPSILON) };
    }
}
