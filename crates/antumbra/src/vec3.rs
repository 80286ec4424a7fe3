//! Three-vectors as arrays, for code where rounding does not decide anything: cameras, shading, framing.

pub(crate) type V3 = [f32; 3];

pub(crate) fn add(a: V3, b: V3) -> V3 {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

pub(crate) fn sub(a: V3, b: V3) -> V3 {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

pub(crate) fn scale(a: V3, s: f32) -> V3 {
    [a[0] * s, a[1] * s, a[2] * s]
}

/// Component by component.
pub(crate) fn mul(a: V3, b: V3) -> V3 {
    [a[0] * b[0], a[1] * b[1], a[2] * b[2]]
}

pub(crate) fn dot(a: V3, b: V3) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub(crate) fn cross(a: V3, b: V3) -> V3 {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// `a` at `t = 0`, `b` at `t = 1`.
pub(crate) fn mix(a: V3, b: V3, t: f32) -> V3 {
    [a[0] + (b[0] - a[0]) * t, a[1] + (b[1] - a[1]) * t, a[2] + (b[2] - a[2]) * t]
}

/// Length 1, or `None` where there is no direction.
pub(crate) fn unit(a: V3) -> Option<V3> {
    let square = dot(a, a);
    if (1e-30..1e30).contains(&square) {
        return Some(scale(a, 1.0 / square.sqrt()));
    }
    // Scaled first, so that neither tiny nor huge vectors are lost.
    let largest = a[0].abs().max(a[1].abs()).max(a[2].abs());
    if largest.is_nan() || largest <= 0.0 || largest.is_infinite() {
        return None;
    }
    let a = [a[0] / largest, a[1] / largest, a[2] / largest];
    Some(scale(a, 1.0 / dot(a, a).sqrt()))
}

/// Right, up and forward of a viewer, all of length 1. An `up` along the view is replaced by another axis.
pub(crate) fn axes(eye: V3, target: V3, up: V3) -> [V3; 3] {
    let forward = unit(sub(target, eye)).unwrap_or([0.0, 0.0, -1.0]);
    let right = [up, [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]
        .into_iter()
        .filter_map(unit)
        .map(|up| cross(forward, up))
        .find(|r| dot(*r, *r) > 1e-10)
        .and_then(unit)
        .unwrap_or([1.0, 0.0, 0.0]);
    [right, cross(right, forward), forward]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_of_tiny_and_huge_vectors() {
        for v in [1e-40, 1e-20, 1.0, 1e20, 3e38] {
            let u = unit([v, -v, 0.0]).unwrap();
            assert!((dot(u, u) - 1.0).abs() < 1e-6 && u[0] > 0.0, "{v}: {u:?}");
        }
        assert_eq!((unit([0.0; 3]), unit([f32::NAN; 3]), unit([f32::INFINITY; 3])), (None, None, None));
    }

    #[test]
    fn axes_are_right_handed_even_looking_straight_down() {
        for (target, up) in [([0.0, 0.0, -3.0], [0.0, 2.0, 0.0]), ([0.0, -1e-30, 0.0], [0.0, 1.0, 0.0])] {
            let [r, u, f] = axes([0.0; 3], target, up);
            assert!((dot(cross(r, u), f) + 1.0).abs() < 1e-5, "{r:?} {u:?} {f:?}");
        }
    }
}
