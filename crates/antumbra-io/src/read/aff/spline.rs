//! Interpolation between keys: Kochanek-Bartels splines of points and of rotations.
//!
//! Sources: D. Kochanek, R. Bartels, "Interpolating Splines with Local Tension, Continuity, and Bias Control",
//! SIGGRAPH 1984, equations 8 and 9 with the time adjustment of section 4. K. Shoemake, "Quaternion Calculus and Fast
//! Animation", SIGGRAPH 1987 course notes (`squad`). D. Eberly's combination of both for rotations is what the
//! animation code of BART uses; behaviour that can be seen follows it, to get the pictures everybody else has.

use super::affine::Quaternion;

/// Below this sine two quaternions count as parallel.
const PARALLEL: f64 = 1e-3;

/// A value at a time, with tension, continuity and bias.
#[derive(Clone, Copy, Debug)]
pub(super) struct Key<V> {
    pub(super) time: f64,
    pub(super) value: V,
    pub(super) tcb: [f64; 3],
}

/// What is between two keys.
#[derive(Clone, Debug)]
struct Segment<C> {
    start: f64,
    end: f64,
    /// Coefficients of a cubic, or the quaternions of a `squad`.
    curve: [C; 4],
}

/// The segment that `time` falls into and how far, 0 to 1. Times outside are clamped.
///
/// The first segment that ends after `time` counts, which also gives sense to keys whose times run backwards: the
/// robots have one such. It begins at or before `time`, else the one before it would have been taken.
fn locate<C>(segments: &[Segment<C>], time: f64) -> Option<(&[C; 4], f64)> {
    let (first, last) = (segments.first()?, segments.last()?);
    if time <= first.start {
        return Some((&first.curve, 0.0));
    }
    if time >= last.end {
        return Some((&last.curve, 1.0));
    }
    let segment = segments.iter().find(|s| time < s.end)?;
    Some((&segment.curve, (time - segment.start) / (segment.end - segment.start)))
}

/// Weights of the step before a key and of the step after it in its tangent; `part` is the share of the segment in
/// the time from the key before to the key after.
fn weights([tension, continuity, bias]: [f64; 3], part: f64) -> [f64; 2] {
    let speed = part * (1.0 - tension);
    [speed * (1.0 + continuity) * (1.0 + bias), speed * (1.0 - continuity) * (1.0 - bias)]
}

/// `weights` of the tangents at both ends of the segment from key 1 to key 2.
fn tangent_weights<V>(keys: &[Key<V>; 4]) -> [[f64; 2]; 2] {
    let step = keys[2].time - keys[1].time;
    let part = |whole: f64| if whole == 0.0 { 0.0 } else { step / whole };
    let [tension, continuity, bias] = keys[2].tcb;
    [
        weights(keys[1].tcb, part(keys[2].time - keys[0].time)),
        // What arrives at a key has the continuity turned round.
        weights([tension, -continuity, bias], part(keys[3].time - keys[1].time)),
    ]
}

/// Points over time. The first and the last key only shape the curve: it runs from the second to the last but one.
#[derive(Clone, Debug)]
pub(super) struct PointTrack(Vec<Segment<[f64; 3]>>);

impl PointTrack {
    /// Needs four keys; fewer give a track without a value.
    pub(super) fn new(keys: &[Key<[f64; 3]>]) -> PointTrack {
        PointTrack(keys.array_windows().map(segment_of_points).collect())
    }

    pub(super) fn at(&self, time: f64) -> Option<[f64; 3]> {
        let ([a, b, c, d], u) = locate(&self.0, time)?;
        Some([0, 1, 2].map(|k| a[k] + u * (b[k] + u * (c[k] + u * d[k]))))
    }

    /// First and last time at which the curve can move.
    pub(super) fn span(&self) -> Option<[f64; 2]> {
        Some([self.0.first()?.start, self.0.last()?.end])
    }
}

fn segment_of_points(keys: &[Key<[f64; 3]>; 4]) -> Segment<[f64; 3]> {
    let [leaving, arriving] = tangent_weights(keys);
    let mut curve = [[0.0; 3]; 4];
    for k in 0..3 {
        let step = |i: usize| keys[i + 1].value[k] - keys[i].value[k];
        let leave = leaving[0] * step(0) + leaving[1] * step(1);
        let arrive = arriving[0] * step(1) + arriving[1] * step(2);
        // Hermite's cubic.
        curve[0][k] = keys[1].value[k];
        curve[1][k] = leave;
        curve[2][k] = 3.0 * step(1) - 2.0 * leave - arrive;
        curve[3][k] = leave + arrive - 2.0 * step(1);
    }
    Segment { start: keys[1].time, end: keys[2].time, curve }
}

/// Rotations over time; first and last key as in [`PointTrack`].
#[derive(Clone, Debug)]
pub(super) struct RotationTrack(Vec<Segment<Quaternion>>);

impl RotationTrack {
    /// Needs four keys; fewer give a track without a value.
    pub(super) fn new(keys: &[Key<Quaternion>]) -> RotationTrack {
        let mut keys = keys.to_vec();
        let mut segments = Vec::with_capacity(keys.len().saturating_sub(3));
        for i in 0..keys.len().saturating_sub(3) {
            // The shorter way round between the two keys of this segment. The key after them is turned only when its
            // own segment comes, and the first key never: BART does so, and its tangents depend on it.
            if keys[i + 1].value.dot(keys[i + 2].value) < 0.0 {
                keys[i + 2].value = keys[i + 2].value.negated();
            }
            segments.push(segment_of_rotations([keys[i], keys[i + 1], keys[i + 2], keys[i + 3]]));
        }
        RotationTrack(segments)
    }

    pub(super) fn at(&self, time: f64) -> Option<Quaternion> {
        let ([p, a, b, q], s) = locate(&self.0, time)?;
        Some(slerp(slerp(*p, *q, s), slerp(*a, *b, s), 2.0 * s * (1.0 - s)))
    }

    /// First and last time at which the rotation can change.
    pub(super) fn span(&self) -> Option<[f64; 2]> {
        Some([self.0.first()?.start, self.0.last()?.end])
    }
}

fn segment_of_rotations(keys: [Key<Quaternion>; 4]) -> Segment<Quaternion> {
    let [leaving, arriving] = tangent_weights(&keys);
    let step = |i: usize| logarithm(keys[i].value.conjugate().times(keys[i + 1].value));
    let (before, here, after) = (step(0), step(1), step(2));
    let control = |k: usize| {
        let leave = leaving[0] * before[k] + leaving[1] * here[k];
        let arrive = arriving[0] * here[k] + arriving[1] * after[k];
        [0.5 * (leave - here[k]), 0.5 * (here[k] - arrive)]
    };
    let controls = [control(0), control(1), control(2)];
    let (p, q) = (keys[1].value, keys[2].value);
    let a = p.times(exponential(controls.map(|c| c[0])));
    let b = q.times(exponential(controls.map(|c| c[1])));
    Segment { start: keys[1].time, end: keys[2].time, curve: [p, a, b, q] }
}

/// The vector `A n` of `cos A + sin A n`.
fn logarithm(q: Quaternion) -> [f64; 3] {
    let [w, x, y, z] = q.0;
    let angle = w.clamp(-1.0, 1.0).acos();
    let sin = angle.sin();
    // Parallel quaternions: no turn, also where they point opposite ways (a whole turn between them).
    let factor = if sin < PARALLEL { 1.0 } else { angle / sin };
    [x * factor, y * factor, z * factor]
}

/// The inverse of [`logarithm`].
fn exponential(v: [f64; 3]) -> Quaternion {
    let angle = (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]).sqrt();
    let factor = if angle < PARALLEL { 1.0 } else { angle.sin() / angle };
    Quaternion([angle.cos(), v[0] * factor, v[1] * factor, v[2] * factor])
}

/// The great arc from `p` to `q`, the long way round too if their dot product is negative (as `squad` wants it).
fn slerp(p: Quaternion, q: Quaternion, t: f64) -> Quaternion {
    let cos = p.dot(q).clamp(-1.0, 1.0);
    let angle = cos.acos();
    let sin = angle.sin();
    let [near, far] = match (sin < PARALLEL, cos > 0.0) {
        (false, _) => [((1.0 - t) * angle).sin() / sin, (t * angle).sin() / sin],
        // So near to each other that the chord is the arc.
        (true, true) => [1.0 - t, t],
        // Opposite: no arc is better than another.
        (true, false) => [1.0, 0.0],
    };
    Quaternion([0, 1, 2, 3].map(|k| near * p.0[k] + far * q.0[k]))
}
