//! Reader.
use crate::Error;
use antumbra::scene::Scene;
use std::path::Path;
#[derive(Debug)]
pub(super) struct AffFile;
pub(super) fn open(path: &Path) -> Result<AffFile, Error> {
    Err(Error::content(path, "not built yet"))
}
impl AffFile {
    pub(super) fn at(&self, _time: Option<f32>) -> Result<Scene, Error> {
        Ok(Scene::default())
    }
    pub(super) fn time_span(&self) -> Option<[f32; 2]> {
        None
    }
}
