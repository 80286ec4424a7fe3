//! Two hemispheres, +z and -z. A direction `d` of length 1 is at `(d.x, d.y) / (1 + |d.z|)`; a texel holds the distance.

use std::sync::atomic::{AtomicU32, Ordering::Relaxed};

use super::{DepthMap, ShadowMapOptions, cross, dot, relative, sub, texel_at};

pub(super) struct Paraboloid;

/// Splits of one corner triangle in a row at most: stops where a corner is at the light and every arc is long.
const SPLITS: u32 = 16;

type V3 = [f64; 3];

fn middle(a: V3, b: V3) -> V3 {
    [0, 1, 2].map(|k| 0.5 * a[k] + 0.5 * b[k])
}

fn length(a: V3) -> f64 {
    dot(a, a).sqrt()
}

/// The layer of a direction with this z, and its sign.
fn hemisphere(z: f64) -> (usize, f64) {
    if z >= 0.0 { (0, 1.0) } else { (1, -1.0) }
}

/// Where a point lies on the paraboloid of the hemisphere with `z * sign >= 0`. Points behind it lie beyond the unit circle.
fn project(p: V3, sign: f64) -> [f64; 2] {
    let scale = 1.0 / (length(p) + p[2] * sign);
    [p[0] * scale, p[1] * scale]
}

/// The direction of a place on the paraboloid, length 1.
fn unproject([x, y]: [f64; 2], sign: f64) -> V3 {
    let square = x * x + y * y;
    let scale = 1.0 / (1.0 + square);
    [2.0 * x * scale, 2.0 * y * scale, sign * (1.0 - square) * scale]
}

/// A triangle's plane as distance along a direction.
struct Plane {
    n: V3,
    det: f64,
}

impl Plane {
    fn distance(&self, direction: V3) -> f64 {
        self.det / dot(self.n, direction)
    }
}

struct Draw<'a> {
    options: &'a ShadowMapOptions,
    bias: f64,
    plane: Plane,
    farthest: f64,
    sign: f64,
    texels: &'a [AtomicU32],
}

impl Draw<'_> {
    /// Subdivides until every edge is close to its arc.
    fn part(&self, t: [V3; 3], splits: u32) {
        let q = t.map(|c| project(c, self.sign));
        if q.as_flattened().iter().any(|v| !v.is_finite()) {
            return;
        }
        if let Some(limit) = self.options.arc_error
            && splits < SPLITS
        {
            let scale = 0.5 * f64::from(self.options.resolution);
            let error = [0, 1, 2].map(|k| {
                let (a, b) = (k, (k + 1) % 3);
                let m = project(middle(t[a], t[b]), self.sign);
                // Distance of the arc's middle from the straight edge.
                let e = [q[b][0] - q[a][0], q[b][1] - q[a][1]];
                let d = [m[0] - q[a][0], m[1] - q[a][1]];
                let size = (e[0] * e[0] + e[1] * e[1]).sqrt().max(1e-300);
                (e[0] * d[1] - e[1] * d[0]).abs() / size * scale
            });
            let worst = (0..3).fold(0, |w, k| if error[k] > error[w] { k } else { w });
            if error[worst] > f64::from(limit) {
                let (a, b, c) = (t[worst], t[(worst + 1) % 3], t[(worst + 2) % 3]);
                let m = middle(a, b);
                self.part([a, m, c], splits + 1);
                self.part([m, b, c], splits + 1);
                return;
            }
        }
        self.raster(q);
    }

    /// Texel centres of one straight triangle; each gets the distance of the plane in its own direction.
    fn raster(&self, q: [[f64; 2]; 3]) {
        let r = self.options.resolution;
        let half = 0.5 * f64::from(r);
        let [a, b, c] = q.map(|p| [(p[0] + 1.0) * half - 0.5, (p[1] + 1.0) * half - 0.5]);
        let area = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
        if area == 0.0 {
            return;
        }
        let side = |p: [f64; 2], q: [f64; 2], x: f64, y: f64| {
            ((q[0] - p[0]) * (y - p[1]) - (q[1] - p[1]) * (x - p[0])) * area.signum()
        };
        let range = |k: usize| {
            let lo = a[k].min(b[k]).min(c[k]).ceil() as u32;
            let hi = (a[k].max(b[k]).max(c[k]).floor() + 1.0) as u32;
            lo.min(r)..hi.min(r)
        };
        let texel_at =
            |x: f64, y: f64| unproject([(x + 0.5) / half - 1.0, (y + 0.5) / half - 1.0], self.sign);
        for row in range(1) {
            for column in range(0) {
                let (x, y) = (f64::from(column), f64::from(row));
                if side(a, b, x, y) < 0.0 || side(b, c, x, y) < 0.0 || side(c, a, x, y) < 0.0 {
                    continue;
                }
                let direction = texel_at(x, y);
                let distance = self.plane.distance(direction);
                // No point of a triangle is farther than its farthest corner; a centre just outside the arc may seem so.
                if !(distance > 0.0 && self.options.within(distance.min(self.farthest))) {
                    continue;
                }
                let mut bias = self.bias;
                if self.options.slope_bias != 0.0 {
                    // A neighbour that looks past the plane's horizon sees it nowhere: as far as can be.
                    let change = |d: V3| match self.plane.distance(d) {
                        there if there > 0.0 => (there.min(self.farthest) - distance).abs(),
                        _ => (self.farthest - distance).abs(),
                    };
                    let slope = change(texel_at(x + 1.0, y)).max(change(texel_at(x, y + 1.0)));
                    bias += f64::from(self.options.slope_bias) * slope;
                }
                let stored = (distance.min(self.farthest) + bias).max(0.0) as f32;
                // Bits of floats that are not negative are in the order of their values.
                self.texels[(row * r + column) as usize].fetch_min(stored.to_bits(), Relaxed);
            }
        }
    }
}

impl DepthMap for Paraboloid {
    const NAME: &'static str = "dual-paraboloid";
    const LAYERS: usize = 2;
    const EMPTY: f32 = f32::INFINITY;

    /// From the near plane (or the light) to the far plane (or the deepest sample).
    fn range(options: &ShadowMapOptions, positions: &[[f32; 3]], light: [f32; 3]) -> f64 {
        let far = options.far.map_or_else(
            || {
                let distance = |p: &[f32; 3]| length(relative(*p, light));
                positions.iter().map(distance).filter(|d| d.is_finite()).fold(0.0, f64::max)
            },
            f64::from,
        );
        (far - options.near.map_or(0.0, f64::from)).max(0.0)
    }

    fn draw(options: &ShadowMapOptions, range: f64, t: &[V3; 3], texels: &[AtomicU32]) {
        let n = cross(sub(t[1], t[0]), sub(t[2], t[0]));
        let det = dot(n, t[0]);
        if det == 0.0 {
            return;
        }
        let farthest = t.iter().map(|c| length(*c)).fold(0.0, f64::max);
        let layer = options.resolution as usize * options.resolution as usize;
        for (sign, texels) in [1.0, -1.0].into_iter().zip(texels.chunks_exact(layer)) {
            let bias = f64::from(options.constant_bias) * range;
            let draw = Draw { options, bias, plane: Plane { n, det }, farthest, sign, texels };
            // The part of the triangle on this side of the light: none, a triangle, or a quad.
            let (mut part, mut count) = ([[0.0; 3]; 4], 0);
            for k in 0..3 {
                let (a, b) = (t[k], t[(k + 1) % 3]);
                let (za, zb) = (a[2] * sign, b[2] * sign);
                if za >= 0.0 {
                    part[count] = a;
                    count += 1;
                }
                if (za >= 0.0) != (zb >= 0.0) {
                    let w = za / (za - zb);
                    part[count] = [a[0] + (b[0] - a[0]) * w, a[1] + (b[1] - a[1]) * w, 0.0];
                    count += 1;
                }
            }
            for k in 2..count {
                draw.part([part[0], part[k - 1], part[k]], 0);
            }
        }
    }

    fn lit(options: &ShadowMapOptions, _: f64, p: V3, texels: &[AtomicU32]) -> f32 {
        let depth = length(p);
        if !options.within(depth) {
            return 1.0;
        }
        let (layer, sign) = hemisphere(p[2]);
        let at = project(p, sign);
        let r = f64::from(options.resolution);
        let lit = options.taps().filter(|tap| {
            let (mut layer, mut at) = (layer, at);
            if options.pcf > 1 {
                // Beyond the unit circle is the other hemisphere.
                let d = unproject([at[0] + tap[0] * 2.0 / r, at[1] + tap[1] * 2.0 / r], sign);
                let sign;
                (layer, sign) = hemisphere(d[2]);
                at = project(d, sign);
            }
            let texel = &texels[texel_at(options.resolution, layer, at)];
            depth as f32 <= f32::from_bits(texel.load(Relaxed))
        });
        lit.count() as f32 / (options.pcf * options.pcf) as f32
    }

    fn texel(resolution: u32, p: V3) -> usize {
        let (layer, sign) = hemisphere(p[2]);
        texel_at(resolution, layer, project(p, sign))
    }
}
