//! Pictures of the volumes: the silhouette edges over the picture, and what a run without a reference point has to show.

use antumbra_predicates::resolve;
use rayon::prelude::*;

use super::silhouette::SilhouetteEdge;
use crate::methods::{DebugView, Samples};
use crate::scene::Triangle;

pub(super) const VIEWS: &[DebugView] = &[
    DebugView::label(
        "silhouette",
        "the largest multiplicity of the silhouette edges that the camera sees in the pixel: 1 borders, 2 folds; 0 where there is none, or no camera",
    ),
    DebugView::amount("faces", "faces of volumes that had to be tested against the sample one by one"),
    DebugView::amount("volumes", "shadow volumes that contain the sample"),
];

/// How much farther than the surface an edge may seem, as a part of its distance, and still count as seen: edges lie *on*
/// surfaces. This is a picture, nothing depends on it.
const SLACK: f64 = 0.01;

/// Without a reference point every triangle is tested against every sample.
pub(super) fn test_all(
    view: &str,
    triangles: &[Triangle],
    positions: &[[f32; 3]],
    light: [f32; 3],
) -> Vec<f32> {
    let blocks = |p: &[f32; 3]| triangles.iter().filter(|t| resolve::blocks(t, light, *p)).count();
    let number = |p: &[f32; 3]| match view {
        "faces" => triangles.len() as f32,
        _ if p.iter().any(|v| v.is_nan()) => f32::NAN,
        _ => blocks(p) as f32,
    };
    positions.par_iter().map(number).collect()
}

/// Draws the edges as lines, one pixel wide, where no surface is in front of them.
pub(super) fn silhouettes(edges: &[SilhouetteEdge], samples: Samples<'_>) -> Vec<f32> {
    let mut out = vec![0.0; samples.positions.len()];
    let width = samples.width.max(1);
    let Some(view) = samples.view.filter(|_| width < out.len()) else { return out };
    let size = [width, out.len() / width];
    let clip = view.clip_from_world();
    let depth = |p: [f32; 3]| (0..3).map(|k| view.forward[k] * (f64::from(p[k]) - view.eye[k])).sum::<f64>();
    for edge in edges {
        let weight = edge.multiplicity.unsigned_abs() as f32;
        for_each_pixel([edge.a, edge.b].map(|p| project(&clip, p)), size, |i, w| {
            if w <= depth(samples.positions[i]) * (1.0 + SLACK) {
                out[i] = weight.max(out[i]);
            }
        });
    }
    out
}

/// A point in clip space, without its depth: x, y, w.
fn project(clip: &[[f64; 4]; 4], p: [f32; 3]) -> [f64; 3] {
    let p = p.map(f64::from);
    [0, 1, 3].map(|r| clip[r][0] * p[0] + clip[r][1] * p[1] + clip[r][2] * p[2] + clip[r][3])
}

/// Calls `each` with the pixels that a segment passes through, and its distance along the viewing axis there.
fn for_each_pixel([a, b]: [[f64; 3]; 2], size: [usize; 2], mut each: impl FnMut(usize, f64)) {
    // The part of the segment inside the picture: in front of the eye, and within |x| <= w, |y| <= w.
    let sides = |[x, y, w]: [f64; 3]| [w - 1e-6 * a[2].abs().max(b[2].abs()), w - x, w + x, w - y, w + y];
    let (mut from, mut to) = (0.0f64, 1.0f64);
    for (at_a, at_b) in sides(a).into_iter().zip(sides(b)) {
        if at_a < 0.0 && at_b < 0.0 {
            return;
        }
        let crossing = at_a / (at_a - at_b);
        if at_a < 0.0 {
            from = from.max(crossing);
        } else if at_b < 0.0 {
            to = to.min(crossing);
        }
    }
    if from > to {
        return;
    }
    let [width, height] = size.map(|s| s as f64);
    let ends = [from, to].map(|t| {
        let [x, y, w] = [0, 1, 2].map(|k| a[k] + t * (b[k] - a[k]));
        [(x / w + 1.0) * 0.5 * width, (1.0 - y / w) * 0.5 * height, 1.0 / w]
    });
    if !ends.as_flattened().iter().all(|v| v.is_finite()) {
        return;
    }
    let [p, q] = ends;
    let steps = (q[0] - p[0]).abs().max((q[1] - p[1]).abs()).ceil().max(1.0) as usize;
    for step in 0..=steps {
        let t = step as f64 / steps as f64;
        // On the screen, one over the distance is linear.
        let [x, y, inverse] = [0, 1, 2].map(|k| p[k] + t * (q[k] - p[k]));
        let (x, y) = ((x as usize).min(size[0] - 1), (y as usize).min(size[1] - 1));
        each(y * size[0] + x, 1.0 / inverse);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::samples::View;
    use crate::scene::Camera;

    /// A wall at z = -10 fills the picture; an edge in front of it is drawn, one behind it and one behind the eye are not.
    #[test]
    fn edges_are_drawn_where_the_camera_sees_them() {
        let camera = Camera {
            name: String::new(),
            eye: [0.0; 3],
            target: [0.0, 0.0, -1.0],
            up: [0.0, 1.0, 0.0],
            fov: 90.0,
        };
        let size = [40, 40];
        let view = View::new(&camera, size[0], size[1]);
        let on_wall = |i: usize| view.direction(i % 40, i / 40, 40, 40).map(|v| (10.0 * v) as f32);
        let positions: Vec<[f32; 3]> = (0..1600).map(on_wall).collect();
        let edge = |z: f32, multiplicity: i32| SilhouetteEdge {
            a: [-99.0, z * 0.1, z],
            b: [0.0, z * 0.1, z],
            multiplicity,
        };
        let samples = Samples { positions: &positions, width: 40, view: Some(&view) };
        for (z, multiplicity, seen) in [(-5.0, -2, 20), (-10.0, 1, 20), (-11.0, 1, 0), (5.0, 1, 0)] {
            let drawn = silhouettes(&[edge(z, multiplicity)], samples);
            let row: Vec<usize> = (0..1600).filter(|&i| drawn[i] > 0.0).collect();
            assert!(row.len().abs_diff(seen) <= 1, "{z}: {}", row.len());
            assert!(
                row.iter().all(|i| i / 40 == 22 && drawn[*i] == multiplicity.abs() as f32),
                "{z}: {row:?}"
            );
        }
        // No camera, nothing to draw in.
        let drawn = silhouettes(&[edge(-5.0, 2)], Samples::image(&positions, 40));
        assert_eq!(drawn, vec![0.0; 1600]);
    }
}
