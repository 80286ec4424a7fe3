//! What makes a case hard: changes to the arrays of a definition.
//!
//! All random numbers come from a fixed seed, so that the arrays are the same everywhere.

use antumbra::scene::Triangle;
use serde::Deserialize;

/// One change, or several. They are applied in the order of the fields.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Stress {
    /// Every triangle is cut into four at the middles of its edges. The middles are rounded, so the picture is only nearly
    /// the same; engines are held against each other on the same arrays.
    #[serde(default)]
    pub split: bool,
    /// So many triangles are added that are about a tenth of the scene long and a hundred-thousandth of that wide.
    #[serde(default)]
    pub slivers: usize,
    /// So many triangles are added that are a few scene sizes large, none of them inside the sphere around the scene: they
    /// shadow nothing if light and samples are in the scene, but their boxes are everywhere.
    #[serde(default)]
    pub huge: usize,
    /// The light is moved away from the middle of the scene, in the direction of where it was, by so many scene sizes.
    pub light_away: Option<f32>,
    /// The samples are replaced by two clumps, each so many radians wide as seen from the light.
    pub clumps: Option<f32>,
}

/// The arrays of a case.
#[derive(Clone, Debug)]
pub struct Arrays {
    /// The casters.
    pub triangles: Vec<Triangle>,
    /// NaN = none.
    pub samples: Vec<[f32; 3]>,
    /// Where it is.
    pub light: [f32; 3],
}

impl Stress {
    /// Applies the changes.
    pub fn apply(&self, arrays: &mut Arrays) {
        let bounds = Sphere::around(&arrays.triangles);
        let mut random = Random(0x9e37_79b9_7f4a_7c15);
        if self.split {
            arrays.triangles = arrays.triangles.iter().flat_map(split).collect();
        }
        arrays.triangles.extend((0..self.slivers).map(|_| sliver(&bounds, &mut random)));
        arrays.triangles.extend((0..self.huge).map(|_| huge(&bounds, &mut random)));
        if let Some(sizes) = self.light_away {
            let away = unit(sub(arrays.light.map(f64::from), bounds.middle));
            arrays.light = to_f32(add(bounds.middle, scale(away, f64::from(sizes) * 2.0 * bounds.radius)));
        }
        if let Some(width) = self.clumps {
            clump(&mut arrays.samples, arrays.light, f64::from(width), &mut random);
        }
    }
}

/// Into four at the middles of the edges.
fn split(t: &Triangle) -> [Triangle; 4] {
    let middle =
        |a: [f32; 3], b: [f32; 3]| [0, 1, 2].map(|k| (0.5 * (f64::from(a[k]) + f64::from(b[k]))) as f32);
    let [a, b, c] = *t;
    let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
    [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
}

fn sliver(bounds: &Sphere, random: &mut Random) -> Triangle {
    let length = 0.2 * bounds.radius;
    let a = add(bounds.middle, scale(random.in_ball(), bounds.radius));
    let b = add(a, scale(random.direction(), length));
    let c = add(b, scale(random.direction(), 1e-5 * length));
    [a, b, c].map(to_f32)
}

/// In a plane that misses the sphere around the scene by a little or by a lot.
fn huge(bounds: &Sphere, random: &mut Random) -> Triangle {
    let normal = random.direction();
    let across = unit(cross(normal, random.direction()));
    let along = cross(normal, across);
    let foot = add(bounds.middle, scale(normal, bounds.radius * (1.01 + random.number())));
    // Corners a third of a turn apart, by constants: a sine may differ from machine to machine.
    [[1.0, 0.0], [-0.5, 0.75_f64.sqrt()], [-0.5, -0.75_f64.sqrt()]].map(|[x, y]| {
        let reach = bounds.radius * (2.0 + 4.0 * random.number());
        to_f32(add(foot, add(scale(across, reach * x), scale(along, reach * y))))
    })
}

/// Every sample moves close to one of two of them, between half and all of the way from the light to it. Gaps stay gaps.
fn clump(samples: &mut [[f32; 3]], light: [f32; 3], width: f64, random: &mut Random) {
    let there: Vec<usize> = (0..samples.len()).filter(|&i| !samples[i].iter().any(|v| v.is_nan())).collect();
    let (Some(&first), Some(&second)) = (there.get(there.len() / 3), there.get(2 * there.len() / 3)) else {
        return;
    };
    let light = light.map(f64::from);
    let ways = [first, second].map(|i| sub(samples[i].map(f64::from), light));
    for (n, &i) in there.iter().enumerate() {
        let way = ways[n % 2];
        let distance = dot(way, way).sqrt() * (0.5 + 0.5 * random.number());
        let direction = add(unit(way), scale(random.in_ball(), 0.5 * width));
        samples[i] = to_f32(add(light, scale(direction, distance)));
    }
}

/// A sphere that holds a scene.
struct Sphere {
    middle: [f64; 3],
    radius: f64,
}

impl Sphere {
    fn around(triangles: &[Triangle]) -> Sphere {
        let (mut lo, mut hi) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
        for p in triangles.as_flattened() {
            for k in 0..3 {
                lo[k] = lo[k].min(f64::from(p[k]));
                hi[k] = hi[k].max(f64::from(p[k]));
            }
        }
        if lo[0] > hi[0] {
            return Sphere { middle: [0.0; 3], radius: 1.0 };
        }
        let diagonal = sub(hi, lo);
        Sphere { middle: scale(add(lo, hi), 0.5), radius: 0.5 * dot(diagonal, diagonal).sqrt() }
    }
}

/// SplitMix64: Steele, Lea, Flood 2014, "Fast Splittable Pseudorandom Number Generators".
struct Random(u64);

impl Random {
    /// At least 0, less than 1.
    fn number(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }

    fn in_ball(&mut self) -> [f64; 3] {
        loop {
            let v = [0; 3].map(|_| 2.0 * self.number() - 1.0);
            if dot(v, v) <= 1.0 {
                return v;
            }
        }
    }

    fn direction(&mut self) -> [f64; 3] {
        unit(self.in_ball())
    }
}

fn add(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [0, 1, 2].map(|k| a[k] + b[k])
}

fn sub(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [0, 1, 2].map(|k| a[k] - b[k])
}

fn scale(a: [f64; 3], s: f64) -> [f64; 3] {
    a.map(|v| v * s)
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// Of length one; something of length one if there is no direction.
fn unit(a: [f64; 3]) -> [f64; 3] {
    let length = dot(a, a).sqrt();
    if length > 0.0 { scale(a, 1.0 / length) } else { [0.0, 1.0, 0.0] }
}

fn to_f32(a: [f64; 3]) -> [f32; 3] {
    a.map(|v| v as f32)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn arrays() -> Arrays {
        let triangles = vec![[[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [0.0, 2.0, 1.0]]];
        Arrays { triangles, samples: vec![[1.0, 1.0, 0.5]; 6], light: [0.5, 0.5, 3.0] }
    }

    #[test]
    fn huge_triangles_stay_out_of_the_sphere() {
        let mut a = arrays();
        let sphere = Sphere::around(&a.triangles);
        Stress { huge: 200, ..Stress::default() }.apply(&mut a);
        assert_eq!(a.triangles.len(), 201);
        for t in &a.triangles[1..] {
            let v = t.map(|p| sub(p.map(f64::from), sphere.middle));
            let normal = unit(cross(sub(v[1], v[0]), sub(v[2], v[0])));
            assert!(dot(normal, v[0]).abs() > sphere.radius, "{t:?}");
        }
    }

    #[test]
    fn clumps_are_narrow_and_gaps_stay() {
        let mut a = arrays();
        a.samples[1] = [f32::NAN; 3];
        a.samples[5] = [1.0, 0.0, 0.0];
        Stress { clumps: Some(1e-4), ..Stress::default() }.apply(&mut a);
        assert!(a.samples[1][0].is_nan());
        let way = |p: [f32; 3]| unit(sub(p.map(f64::from), a.light.map(f64::from)));
        let apart = sub(way(a.samples[0]), way(a.samples[3]));
        assert!(dot(apart, apart).sqrt() < 1.1e-4);
    }

    #[test]
    fn four_for_one_and_the_light_moves() {
        let mut a = arrays();
        Stress { split: true, light_away: Some(100.0), slivers: 3, ..Stress::default() }.apply(&mut a);
        assert_eq!(a.triangles.len(), 7);
        assert!(a.light[2] > 100.0);
    }
}
