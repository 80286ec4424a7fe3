//! Triangles for cones, spheres and polygons.

use std::f64::consts::{PI, TAU};

use super::affine::{cross, dot, subtract, unit};
use super::model::Corner;

/// Triangles round a cone, cylinder or sphere. Few enough for hundreds of table legs, round enough (1 % of the radius
/// off) for their shadows.
const AROUND: usize = 24;
/// Rings of a sphere from pole to pole: the same angle as around.
const RINGS: usize = 12;

fn corner(center: [f64; 3], direction: [f64; 3], radius: f64, normal: [f64; 3]) -> Corner {
    let position = [0, 1, 2].map(|k| (center[k] + direction[k] * radius) as f32);
    let normal = unit(normal).unwrap_or_default().map(|v| v as f32);
    Corner { position, normal, uv: [0.0; 2] }
}

/// The mantle between two circles, without end caps. Negative radii: seen from inside. `None` if it has no axis.
pub(super) fn cone(
    base: [f64; 3],
    base_radius: f64,
    apex: [f64; 3],
    apex_radius: f64,
) -> Option<Vec<[Corner; 3]>> {
    let along = subtract(apex, base);
    let axis = unit(along)?;
    // Across the smallest component: never parallel to the axis.
    let smallest = (0..3).min_by(|&a, &b| axis[a].abs().total_cmp(&axis[b].abs())).unwrap_or(0);
    let u = unit(cross(axis, [0, 1, 2].map(|k| f64::from(u8::from(k == smallest)))))?;
    let v = cross(axis, u);
    let side = if base_radius < 0.0 || apex_radius < 0.0 { -1.0 } else { 1.0 };
    let [base_radius, apex_radius] = [base_radius.abs(), apex_radius.abs()];
    let height = dot(along, along).sqrt();
    let ring = |i: usize| {
        let (sin, cos) = (TAU * (i % AROUND) as f64 / AROUND as f64).sin_cos();
        let direction = [0, 1, 2].map(|k| u[k] * cos + v[k] * sin);
        let slope = (base_radius - apex_radius) / height;
        let normal = [0, 1, 2].map(|k| side * (direction[k] + axis[k] * slope));
        [corner(base, direction, base_radius, normal), corner(apex, direction, apex_radius, normal)]
    };
    let mut triangles = Vec::with_capacity(2 * AROUND);
    for i in 0..AROUND {
        let ([a, d], [b, c]) = (ring(i), ring(i + 1));
        // At a tip one of the two triangles is nothing.
        if base_radius > 0.0 {
            triangles.push([a, b, c]);
        }
        if apex_radius > 0.0 {
            triangles.push([a, c, d]);
        }
        if base_radius == 0.0 && apex_radius == 0.0 {
            triangles.push([a, b, c]);
        }
    }
    Some(triangles)
}

/// A sphere with its poles up and down. A negative radius: seen from inside.
pub(super) fn sphere(center: [f64; 3], radius: f64) -> Vec<[Corner; 3]> {
    let side = if radius < 0.0 { -1.0 } else { 1.0 };
    let at = |ring: usize, i: usize| {
        let (sin, cos) = (PI * ring as f64 / RINGS as f64).sin_cos();
        let (across, away) = (TAU * (i % AROUND) as f64 / AROUND as f64).sin_cos();
        let direction = match ring {
            0 => [0.0, 1.0, 0.0],
            RINGS => [0.0, -1.0, 0.0],
            _ => [sin * away, cos, -sin * across],
        };
        corner(center, direction, radius.abs(), direction.map(|v| side * v))
    };
    let mut triangles = Vec::with_capacity(2 * AROUND * (RINGS - 1));
    for ring in 0..RINGS {
        for i in 0..AROUND {
            let (a, b, c, d) = (at(ring, i), at(ring + 1, i), at(ring + 1, i + 1), at(ring, i + 1));
            if ring + 1 < RINGS {
                triangles.push([a, b, c]);
            }
            if ring > 0 {
                triangles.push([a, c, d]);
            }
        }
    }
    triangles
}

/// How many corners may still be looked at for cutting ears, in all of a scene: some seconds' worth. Cutting takes
/// time of the third power in the worst case, and a file can ask for it as often as it likes.
pub(super) struct EarBudget(u64);

impl Default for EarBudget {
    fn default() -> Self {
        EarBudget(1_000_000_000)
    }
}

/// Cuts a flat polygon of n ≥ 3 corners into n - 2 triangles: a fan from the first corner if it has no dent, else
/// by ears (G. Meisters, "Polygons Have Ears", American Mathematical Monthly 82, 1975).
pub(super) fn polygon(corners: &[[f32; 3]], budget: &mut EarBudget) -> Result<Vec<[u32; 3]>, String> {
    let n = corners.len();
    let flat = flatten(corners);
    let turn = |a: usize, b: usize, c: usize| turn(flat[a], flat[b], flat[c]);
    // Rounded coordinates make straight corners a little dented: not worth an ear.
    let size = flat.iter().flatten().fold(0.0, |m: f64, v| m.max(v.abs()));
    let straight = -1e-6 * size * size;
    let fan = |list: &[u32]| list.windows(2).skip(1).map(|w| [list[0], w[0], w[1]]).collect::<Vec<_>>();
    let mut left: Vec<u32> = (0..n as u32).collect();
    if n == 3 || (0..n).all(|i| turn(i, (i + 1) % n, (i + 2) % n) >= straight) {
        return Ok(fan(&left));
    }
    let mut triangles = Vec::with_capacity(n - 2);
    while left.len() > 3 {
        let m = left.len();
        let ear = (0..m).find(|&i| {
            let [a, b, c] = [left[(i + m - 1) % m], left[i], left[(i + 1) % m]].map(|k| k as usize);
            budget.0 = budget.0.saturating_sub(1);
            if turn(a, b, c) <= 0.0 || budget.0 == 0 {
                return false;
            }
            budget.0 = budget.0.saturating_sub(m as u64);
            !left.iter().map(|&k| k as usize).any(|k| {
                let same = |corner: usize| k == corner || flat[k] == flat[corner];
                !same(a)
                    && !same(b)
                    && !same(c)
                    && turn(a, b, k) >= 0.0
                    && turn(b, c, k) >= 0.0
                    && turn(c, a, k) >= 0.0
            })
        });
        if budget.0 == 0 {
            return Err(format!(
                "{n} corners with dents, after many others: too much work, cut it beforehand"
            ));
        }
        // A polygon that crosses itself may have no ear left: what remains is a fan.
        let Some(i) = ear else { break };
        triangles.push([left[(i + m - 1) % m], left[i], left[(i + 1) % m]]);
        left.remove(i);
    }
    triangles.extend(fan(&left));
    Ok(triangles)
}

/// Twice the area of a triangle in the plane, above 0 if it turns left.
fn turn(a: [f64; 2], b: [f64; 2], c: [f64; 2]) -> f64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

/// The polygon from above, seen so that it turns left, and moved to its first corner.
fn flatten(corners: &[[f32; 3]]) -> Vec<[f64; 2]> {
    let origin = corners.first().copied().unwrap_or_default().map(f64::from);
    let points: Vec<[f64; 3]> = corners.iter().map(|p| subtract(p.map(f64::from), origin)).collect();
    // The sum over a fan is the area vector whatever the shape.
    let normal = points.windows(2).fold([0.0; 3], |sum, w| {
        let n = cross(w[0], w[1]);
        [0, 1, 2].map(|k| sum[k] + n[k])
    });
    let axis = (0..3).max_by(|&a, &b| normal[a].abs().total_cmp(&normal[b].abs())).unwrap_or(2);
    let (x, y) = ((axis + 1) % 3, (axis + 2) % 3);
    let flip = if normal[axis] < 0.0 { -1.0 } else { 1.0 };
    points.iter().map(|p| [p[x] * flip, p[y]]).collect()
}
