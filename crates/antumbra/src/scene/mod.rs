//! What comes in: triangles in world space with materials, lights and a camera, at one moment in time.

mod camera;
mod census;
pub mod defaults;
mod light;
mod material;
pub mod procedural;
mod soup;
mod voxels;

pub use camera::Camera;
pub use census::Census;
pub use light::{Casters, PointLight};
pub use material::{AlphaMode, Material, Texture, Wrap};
pub use soup::{InputError, Object, Soup, Triangle, check_triangles};

/// A scene at one moment: everything in world space, plain data.
///
/// Made by a reader (`antumbra-io`) or by [`procedural`]. Indices in [`Soup`] point into `objects` and `materials`,
/// those in [`Material`] into `textures`.
#[derive(Clone, Debug, Default)]
pub struct Scene {
    /// A short name for reports, e.g. the file's stem.
    pub name: String,
    /// The triangles.
    pub soup: Soup,
    /// Named groups of triangles (nodes of the file).
    pub objects: Vec<Object>,
    /// How surfaces look. Never empty if there are triangles.
    pub materials: Vec<Material>,
    /// Colour images.
    pub textures: Vec<Texture>,
    /// Point lights, in the order of the file.
    pub lights: Vec<PointLight>,
    /// Perspective cameras, in the order of the file.
    pub cameras: Vec<Camera>,
}

impl Scene {
    /// Checks that every number is finite and every index in range.
    ///
    /// # Errors
    /// [`InputError`] names the first offender.
    pub fn validate(&self) -> Result<(), InputError> {
        self.soup.validate(self.objects.len(), self.materials.len())?;
        for (index, material) in self.materials.iter().enumerate() {
            if let Some(texture) = material.base_color_texture
                && texture as usize >= self.textures.len()
            {
                return Err(InputError::Index {
                    what: "texture of material",
                    index,
                    value: texture as usize,
                    len: self.textures.len(),
                });
            }
        }
        for (index, light) in self.lights.iter().enumerate() {
            if !light.position.iter().chain(&light.color).all(|v| v.is_finite())
                || !light.intensity.is_finite()
            {
                return Err(InputError::NotFinite { what: "light", index });
            }
        }
        Ok(())
    }
}
