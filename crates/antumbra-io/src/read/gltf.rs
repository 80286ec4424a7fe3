//! Reader.
use crate::Error;
use antumbra::scene::Scene;
use std::path::Path;
#[derive(Debug)]
pub(super) struct GltfFile;
pub(super) fn open(path: &Path) -> Result<GltfFile, Error> {
    Err(Error::content(path, "not built yet"))
}
impl GltfFile {
    pub(super) fn at(&self, _time: Option<f32>) -> Result<Scene, Error> {
        Ok(Scene::default())
    }
    pub(super) fn time_span(&self) -> Option<[f32; 2]> {
        None
    }
}
