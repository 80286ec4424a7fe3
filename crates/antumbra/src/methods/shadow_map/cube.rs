//! Six faces. A texel holds `1 / distance` along the face's axis, which is linear over a projected triangle.

use std::sync::atomic::{AtomicU32, Ordering::Relaxed};

use super::{DepthMap, ShadowMapOptions, cross, dot, sub, texel_at};

pub(super) struct Cube;

/// The axis that a face is perpendicular to, the two others, and the sign along the first.
fn axes(face: usize) -> (usize, [usize; 2], f64) {
    (face / 2, [[1, 2], [0, 2], [0, 1]][face / 2], if face.is_multiple_of(2) { 1.0 } else { -1.0 })
}

/// The face of a direction, its (u, v) in [-1, 1] and its component along the face's axis.
fn face_of(p: [f64; 3]) -> (usize, [f64; 2], f64) {
    let size = p.map(f64::abs);
    let major = match (size[0] >= size[1], size[0] >= size[2], size[1] >= size[2]) {
        (true, true, _) => 0,
        (_, _, true) => 1,
        _ => 2,
    };
    let face = 2 * major + usize::from(p[major] < 0.0);
    let (_, [i, j], _) = axes(face);
    (face, [p[i] / size[major], p[j] / size[major]], size[major])
}

/// The texels between two values of u (or v), first and one past the last centre.
fn centers(lo: f64, hi: f64, r: u32) -> std::ops::Range<u32> {
    let half = 0.5 * f64::from(r);
    // Casts saturate, so infinite bounds are the map's own.
    let first = ((lo + 1.0) * half - 0.5).ceil() as u32;
    let end = (((hi + 1.0) * half - 0.5).floor() + 1.0) as u32;
    first.min(r)..end.min(r)
}

fn center(i: u32, r: u32) -> f64 {
    f64::from(2 * i + 1) / f64::from(r) - 1.0
}

impl DepthMap for Cube {
    const NAME: &'static str = "cube-map";
    const LAYERS: usize = 6;
    const EMPTY: f32 = 0.0;

    fn range(_: &ShadowMapOptions, _: &[[f32; 3]], _: [f32; 3]) -> f64 {
        1.0
    }

    fn draw(options: &ShadowMapOptions, _: f64, t: &[[f64; 3]; 3], texels: &[AtomicU32]) {
        let edges = [sub(t[1], t[0]), sub(t[2], t[1]), sub(t[0], t[2])];
        let n = cross(edges[0], edges[1]);
        let det = dot(n, t[0]);
        if det == 0.0 {
            return;
        }
        let m = [0, 1, 2].map(|k| cross(t[k], edges[k]).map(|v| v * det.signum()));
        let plane = n.map(|v| v / det);
        let r = options.resolution;
        let layer = r as usize * r as usize;
        for (face, texels) in texels.chunks_exact(layer).enumerate() {
            let (major, [i, j], sign) = axes(face);
            let front = t.map(|c| c[major] * sign);
            if front.iter().all(|&f| f <= 0.0) {
                continue;
            }
            let all_front = front.iter().all(|&f| f > 0.0);
            let bounds = |axis: usize| {
                let q = [0, 1, 2].map(|k| t[k][axis] / front[k]);
                match all_front {
                    true => [q[0].min(q[1]).min(q[2]), q[0].max(q[1]).max(q[2])],
                    false => [-1.0, 1.0],
                }
            };
            let (u_bounds, v_bounds) = (bounds(i), bounds(j));
            // Linear functions of (u, v): edges, and one over the depth.
            let edge = m.map(|m| [m[i], m[j], m[major] * sign]);
            let [du, dv, at_zero] = [plane[i], plane[j], plane[major] * sign];
            let slope = du.abs().max(dv.abs()) * 2.0 / f64::from(r);
            let nearest = front.iter().filter(|&&f| f > 0.0).fold(f64::INFINITY, |a, &b| a.min(b));
            // A unit in the last place of the nearest corner's depth, as polygon offset of float depth buffers.
            let unit = ((1.0 / nearest) as f32).max(f32::MIN_POSITIVE);
            let unit = f64::from(unit.next_up() - unit);
            let bias = f64::from(options.slope_bias) * slope + f64::from(options.constant_bias) * unit;
            for row in centers(v_bounds[0], v_bounds[1], r) {
                let v = center(row, r);
                let [mut lo, mut hi] = u_bounds;
                for [a, b, c] in edge {
                    let rest = b * v + c;
                    if a > 0.0 {
                        lo = lo.max(-rest / a);
                    } else if a < 0.0 {
                        hi = hi.min(-rest / a);
                    } else if rest < 0.0 {
                        lo = f64::INFINITY;
                    }
                }
                for column in centers(lo, hi, r) {
                    let inverse = du * center(column, r) + dv * v + at_zero;
                    if inverse > 0.0 && options.within(1.0 / inverse) {
                        let stored = (inverse - bias).max(0.0) as f32;
                        let texel = &texels[(row * r + column) as usize];
                        // Bits of floats that are not negative are in the order of their values.
                        if f32::from_bits(texel.load(Relaxed)) < stored {
                            texel.fetch_max(stored.to_bits(), Relaxed);
                        }
                    }
                }
            }
        }
    }

    fn lit(options: &ShadowMapOptions, _: f64, p: [f64; 3], texels: &[AtomicU32]) -> f32 {
        let (face, uv, depth) = face_of(p);
        if !options.within(depth) {
            return 1.0;
        }
        let (major, [i, j], sign) = axes(face);
        let r = f64::from(options.resolution);
        let lit = options.taps().filter(|tap| {
            // The sample moved along its face's plane; over the border it is on another face.
            let mut q = [0.0; 3];
            q[major] = sign;
            q[i] = uv[0] + tap[0] * 2.0 / r;
            q[j] = uv[1] + tap[1] * 2.0 / r;
            let (face, uv, along) = if options.pcf == 1 { (face, uv, 1.0) } else { face_of(q) };
            let texel = &texels[texel_at(options.resolution, face, uv)];
            f32::from_bits(texel.load(Relaxed)) <= (1.0 / (depth * along)) as f32
        });
        lit.count() as f32 / (options.pcf * options.pcf) as f32
    }

    fn texel(resolution: u32, p: [f64; 3]) -> usize {
        let (face, uv, _) = face_of(p);
        texel_at(resolution, face, uv)
    }
}
