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

    /// The samples as a method of antumbra takes them.
    pub fn asked(&self) -> Samples<'_> {
        Samples { positions: &self.samples, width: self.width, view: self.view.as_ref() }
    }
}
