//! Skins: joints that carry vertices along.

use super::accessor::same_length;
use super::math::Affine;
use super::nodes::Tree;
use super::source::{Source, label};
use crate::Error;

/// Joints and how they stood when the mesh was bound to them.
#[derive(Debug)]
pub(super) struct Skin {
    /// Nodes.
    joints: Vec<usize>,
    /// One a joint.
    inverse_bind: Vec<Affine>,
}

impl Skin {
    /// Reads skin `index`.
    pub(super) fn read(source: &Source<'_>, tree: &Tree, index: usize) -> Result<Skin, Error> {
        let json = &source.root.skins[index];
        let name = label("skin", index, json.name.as_deref());
        let joints: Vec<usize> = json.joints.iter().map(|j| j.value()).collect();
        for &joint in &joints {
            source.item(&tree.nodes, joint, "joint node", &name)?;
        }
        let inverse_bind = match json.inverse_bind_matrices {
            None => vec![Affine::IDENTITY; joints.len()],
            Some(accessor) => {
                let matrices = source.floats::<16>(accessor.value(), &name)?;
                if matrices.len() < joints.len() {
                    same_length(source, &name, "inverseBindMatrices", matrices.len(), joints.len())?;
                }
                matrices.iter().take(joints.len()).map(Affine::from_columns).collect()
            }
        };
        Ok(Skin { joints, inverse_bind })
    }

    /// From the space of the bound mesh to the world, for each joint.
    pub(super) fn matrices(&self, world: &[Affine]) -> Vec<Affine> {
        self.joints.iter().zip(&self.inverse_bind).map(|(&joint, bind)| world[joint].after(bind)).collect()
    }
}
