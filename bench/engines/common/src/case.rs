//! The question: triangles, samples and a light.

use antumbra::methods::Samples;
use antumbra::samples::View;
use antumbra::scene::Triangle;

/// The arrays that all engines share.
#[derive(Clone, Debug)]
pub struct Case {
    /// The triangles and one more of zeros: Embree loads 16 bytes where a vertex has 12, so that something must follow the
    /// last vertex.
    padded: Vec<Triangle>,
    /// One point a pixel, row by row; NaN = no sample.
    pub samples: Vec<[f32; 3]>,
    /// Samples a row.
    pub width: usize,
    /// Where the light is.
    pub light: [f32; 3],
    /// The camera that saw the samples, where known.
    pub view: Option<View>,
}

impl Case {
    /// Takes the arrays over.
    pub fn new(
        mut triangles: Vec<Triangle>,
        samples: Vec<[f32; 3]>,
        width: usize,
        light: [f32; 3],
        view: Option<View>,
    ) -> Case {
        triangles.push([[0.0; 3]; 3]);
        Case { padded: triangles, samples, width: width.max(1), light, view }
    }

    /// The casters.
    pub fn triangles(&self) -> &[Triangle] {
        &self.padded[..self.padded.len() - 1]
    }

    /// Rows of samples.
    pub fn height(&self) -> usize {
        self.samples.len().div_ceil(self.width)
    }

    /// What an epsilon comes to, as a part of the way from light to sample: of the distance, or of the size of the scene where the
    /// light is farther away than that. Otherwise a far light would cut off half of the scene.
    pub fn cut(&self, epsilon: f32) -> f32 {
        let (mut lo, mut hi) = ([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]);
        for p in self.triangles().as_flattened() {
            for k in 0..3 {
                (lo[k], hi[k]) = (lo[k].min(p[k]), hi[k].max(p[k]));
            }
        }
        let length = |v: [f32; 3]| v.iter().map(|&x| f64::from(x) * f64::from(x)).sum::<f64>().sqrt();
        let size = length([0, 1, 2].map(|k| hi[k] - lo[k]));
        let away = length([0, 1, 2].map(|k| self.light[k] - 0.5 * (lo[k] + hi[k])));
        if size < away { (f64::from(epsilon) * size / away) as f32 } else { epsilon }
    }

    /// The samples as a method of antumbra takes them.
    pub fn asked(&self) -> Samples<'_> {
        Samples { positions: &self.samples, width: self.width, view: self.view.as_ref() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_far_light_cuts_no_more_of_the_scene_than_a_near_one() {
        let case = |z| {
            let triangles = vec![[[-3.0, 0.0, 0.0], [3.0, 0.0, 0.0], [0.0, 8.0, 0.0]]];
            Case::new(triangles, vec![[0.0; 3]], 1, [0.0, 4.0, z], None)
        };
        assert_eq!(case(5.0).cut(1e-3), 1e-3);
        assert!((case(1000.0).cut(1e-3) - 1e-5).abs() < 1e-8);
        assert_eq!(Case::new(vec![], vec![], 0, [0.0; 3], None).cut(1e-3), 1e-3);
    }
}
