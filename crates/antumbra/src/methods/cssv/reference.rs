//! The point from which crossings are counted: the eye, or a point close by that lies in no shadow plane.
//!
//! Any point serves, as long as it is *generic*: on no plane through the light and a silhouette edge, and on no plane of
//! a triangle that faces the light or away from it. Then no line from it to a sample, moved as the definition says,
//! meets a face anywhere but in its interior (see `mod.rs`). That is checked with exact signs; a point that fails is moved.

use antumbra_predicates::exact;
use rayon::prelude::*;

use super::silhouette::Casters;
use super::tuning::REFERENCE_TRIES;
use crate::samples::View;
use crate::scene::Triangle;

type V3 = [f64; 3];

/// Where counting starts, and axes to measure samples by.
#[derive(Clone, Copy, Debug)]
pub(super) struct Reference {
    pub(super) point: [f32; 3],
    /// Right, up, forward: orthonormal to within [`SKEW`].
    pub(super) axes: [V3; 3],
    /// Points tried.
    pub(super) tries: u32,
}

/// Products of two axes are off by this at most; `face.rs` relies on it.
pub(super) const SKEW: f64 = 1.0 / (1u64 << 48) as f64;

const WORLD: [V3; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

fn dot(a: V3, b: V3) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: V3, b: V3) -> V3 {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn unit(a: V3) -> V3 {
    let length = dot(a, a).sqrt();
    a.map(|v| v / length)
}

/// Orthonormal axes with the given third one; the world's where that is impossible (NaN fails the check too).
fn axes(forward: V3, right: V3) -> [V3; 3] {
    let f = unit(forward);
    let without = |r: V3| {
        let d = dot(r, f);
        unit([0, 1, 2].map(|k| r[k] - d * f[k]))
    };
    let r = without(without(unit(right)));
    let axes = [r, unit(cross(r, f)), f];
    let good = (0..3)
        .all(|i| (0..3).all(|j| (dot(axes[i], axes[j]) - f64::from(u8::from(i == j))).abs() <= SKEW * 0.5));
    if good { axes } else { WORLD }
}

/// Smallest and largest coordinates of all samples; `None` without samples.
fn bounds(positions: &[[f32; 3]]) -> Option<[[f32; 3]; 2]> {
    let join = |a: [[f32; 3]; 2], b: [[f32; 3]; 2]| {
        [[0, 1, 2].map(|k| a[0][k].min(b[0][k])), [0, 1, 2].map(|k| a[1][k].max(b[1][k]))]
    };
    let nothing = [[f32::INFINITY; 3], [f32::NEG_INFINITY; 3]];
    let all = positions
        .par_iter()
        .filter(|p| !p.iter().any(|v| v.is_nan()))
        .fold(|| nothing, |b, p| join(b, [*p, *p]))
        .reduce(|| nothing, join);
    (all[0][0] <= all[1][0]).then_some(all)
}

/// A sequence of numbers in [-1, 1), always the same.
struct Noise(u64);

impl Noise {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (self.0 >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }
}

/// Chooses the reference point: the eye of `view`, or outside the samples where there is none. `None` if no generic
/// point was found.
pub(super) fn choose(
    view: Option<&View>,
    positions: &[[f32; 3]],
    triangles: &[Triangle],
    casters: &Casters,
) -> Option<Reference> {
    let [lo, hi] = bounds(positions)?.map(|p| p.map(f64::from));
    let size = (0..3).map(|k| hi[k] - lo[k]).fold(0.0, f64::max);
    let view = view.filter(|v| v.eye.iter().all(|c| c.abs() <= f64::from(f32::MAX)));
    let (eye, axes) = match view {
        Some(view) => (view.eye, axes(view.forward, view.right)),
        None => {
            // Far enough outside the box of the samples that all of them lie in front.
            let forward = unit([-0.48, -0.36, -0.8]);
            let eye = [0, 1, 2].map(|k| lo[k] * 0.5 + hi[k] * 0.5 - 1.8 * size * forward[k]);
            (eye, axes(forward, [1.0, 0.0, 0.0]))
        }
    };
    // One part in 2^22 of the largest number around: a few steps of f32.
    let largest = eye.iter().fold(size, |m, v| m.max(v.abs()));
    let mut step = if largest > 0.0 { largest } else { 1.0 } / f64::from(1u32 << 22);
    let mut noise = Noise(1);
    let limit = f64::from(f32::MAX);
    for tries in 1..=REFERENCE_TRIES {
        let move_by = if tries == 1 { 0.0 } else { step };
        let point = eye.map(|v| (v + move_by * noise.next()).clamp(-limit, limit) as f32);
        if is_generic(point, triangles, casters) {
            return Some(Reference { point, axes, tries });
        }
        step *= 2.0;
    }
    None
}

/// Does `point` lie on no plane through the light and a silhouette edge, and on no plane of a triangle that counts?
fn is_generic(point: [f32; 3], triangles: &[Triangle], casters: &Casters) -> bool {
    casters.edges.par_iter().all(|e| exact::orientation(e.a, e.b, point, casters.light) != 0)
        && triangles
            .par_iter()
            .zip(&casters.facing)
            .all(|(t, &facing)| facing == 0 || exact::orientation(t[0], t[1], t[2], point) != 0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn axes_are_orthonormal_or_the_worlds() {
        let mut noise = Noise(3);
        for _ in 0..2000 {
            let mut v = || [noise.next(), noise.next(), noise.next() * 1e-3];
            let a = axes(v(), v());
            for i in 0..3 {
                for j in 0..3 {
                    let expected = f64::from(u8::from(i == j));
                    assert!((dot(a[i], a[j]) - expected).abs() <= SKEW);
                }
            }
        }
        assert_eq!(axes([0.0; 3], [1.0, 0.0, 0.0]), WORLD);
        assert_eq!(axes([f64::NAN; 3], [1.0, 0.0, 0.0]), WORLD);
        assert_eq!(axes([1.0, 0.0, 0.0], [1.0, 0.0, 0.0]), WORLD);
    }
}
