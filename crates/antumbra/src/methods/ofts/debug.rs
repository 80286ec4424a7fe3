//! Pictures of the lists and of the work on them.

use super::build::{NO_ID, SUB_GRID, Tile};
use crate::methods::DebugView;
use crate::methods::debug::{complete, group};

pub(super) const VIEWS: &[DebugView] = &[
    DebugView::amount("tests", "exact tests of the sample"),
    DebugView::amount("list-length", "samples in the list that the sample is in"),
    DebugView::label(
        "grid-level",
        "grids around the grid that the sample's list is in: 0 for a tile's own grid",
    ),
    DebugView::label("cell", "the cell that the sample is in; numbers only tell neighbours apart"),
    DebugView::label("tile", "the tile that the sample is in; numbers only tell neighbours apart"),
];

/// One number a sample, from tiles that have been worked on with their tests counted.
pub(super) fn draw(tiles: &[Tile], view: &str, positions: &[[f32; 3]]) -> Vec<f32> {
    let mut out = vec![f32::NAN; positions.len()];
    let mut list = 0;
    for (number, tile) in tiles.iter().enumerate() {
        for node in &tile.nodes {
            let cells = &tile.cells[node.first_cell as usize..][..node.grid.cells()];
            for cell in cells.iter().filter(|c| c.blocks != SUB_GRID) {
                list += 1;
                let blocks = cell.first as usize..(cell.first + cell.blocks) as usize;
                let real = |i: usize| (0..8).filter(move |&lane| tile.blocks[i].id[lane] != NO_ID);
                let length: usize = blocks.clone().map(|i| real(i).count()).sum();
                for (i, lane) in blocks.flat_map(|i| real(i).map(move |lane| (i, lane))) {
                    out[tile.blocks[i].id[lane] as usize] = match view {
                        "tests" => tile.tests[i][lane] as f32,
                        "list-length" => length as f32,
                        "grid-level" => node.level as f32,
                        "cell" => group(list),
                        _ => group(number),
                    };
                }
            }
        }
    }
    complete(out, positions)
}
