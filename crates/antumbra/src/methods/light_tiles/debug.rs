//! Pictures of the work: one number a sample.

use super::layout::BLOCK;
use super::leaf::Loose;
use super::{LightTiles, Method, Samples};
use crate::methods::debug::{DebugView, check_view, complete, group};
use crate::scene::{InputError, Triangle};

pub(super) const VIEWS: &[DebugView] = &[
    DebugView::label("tile", "tile of the sample, as a number that differs from its neighbours'"),
    DebugView::amount("triangles", "triangles in the list of the sample's tile (of the last round)"),
    DebugView::label("leaf", "how the sample is held: 0 with its whole block, 1 with part of it, 2 alone"),
];

/// A rerun of the frame, and what it left behind.
pub(super) fn draw(
    method: &mut LightTiles,
    view: &str,
    triangles: &[Triangle],
    samples: Samples<'_>,
    light: [f32; 3],
) -> Result<Option<Vec<f32>>, InputError> {
    if !check_view(VIEWS, view, triangles, samples, light)? {
        return Ok(None);
    }
    let mut mask = vec![0; samples.positions.len()];
    method.shadow(triangles, samples, light, &mut mask)?;
    let layout = super::Layout::new(samples.positions.len(), samples.width);
    let mut out = vec![0.0; mask.len()];
    for tile in 0..method.tiles.len() {
        let (mut entries, list) = (0, method.tiles.list[tile] as usize);
        for worker in &method.binned {
            worker.ids.each(list, |ids| entries += ids.len());
            worker.eights.each(list, |eights| entries += eights.len());
        }
        let number = |held: u8| match view {
            "tile" => group(tile),
            "triangles" => entries as f32,
            _ => f32::from(held),
        };
        let mut put = |block: usize, sample: usize, held: u8| {
            if let Some(i) = layout.index(block, sample) {
                out[i] = number(held);
            }
        };
        for worker in &method.gathered {
            worker.leaves.each(tile, |leaves| {
                for leaf in leaves {
                    let (block, mask) = (leaf.block() as usize, leaf.mask());
                    let held = u8::from(mask != u32::MAX);
                    (0..BLOCK).filter(|i| mask >> i & 1 == 1).for_each(|i| put(block, i, held));
                }
            });
            worker.loose.each(tile, |slots| {
                for (block, sample) in slots.iter().map(Loose::slot) {
                    put(block, sample, 2);
                }
            });
        }
    }
    Ok(Some(complete(out, samples.positions)))
}
