//! STL, binary and ASCII.
//!
//! A binary file may begin with "solid" as an ASCII one does, so its size decides: 84 bytes and 50 a facet. Facet
//! normals are left out, as they follow from the corners and many programs write rubbish there.

use std::path::Path;

use antumbra::scene::{Scene, Triangle};

use super::mesh::{Budget, Names, Text, load, number, plain_scene, quote};
use crate::Error;

/// Bytes before the first facet, and of a facet.
const HEAD: usize = 84;
const FACET: usize = 50;

/// Reads an STL file: every `solid` of an ASCII file is an object, a binary file is one object.
pub(super) fn open(path: &Path) -> Result<Scene, Error> {
    let mut budget = Budget::new();
    let bytes = load(path, &mut budget)?;
    let scene = read(path, &bytes, &mut budget).map_err(|e| Error::content(path, e))?;
    if scene.soup.is_empty() {
        return Err(Error::content(path, "no triangles"));
    }
    Ok(scene)
}

fn read(path: &Path, bytes: &[u8], budget: &mut Budget) -> Result<Scene, String> {
    let count = bytes.get(80..HEAD).map(|c| u32::from_le_bytes([c[0], c[1], c[2], c[3]]) as usize);
    let expected = count.map(|n| HEAD as u64 + FACET as u64 * n as u64);
    if expected == Some(bytes.len() as u64) {
        let positions = read_binary(&bytes[HEAD..], budget)?;
        return Ok(plain_scene(path, positions));
    }
    let start = bytes.trim_ascii_start();
    let binary = bytes.iter().take(1024).any(|b| *b == 0);
    if !binary && start.get(..5).is_some_and(|w| w.eq_ignore_ascii_case(b"solid")) {
        return read_ascii(path, bytes, budget);
    }
    Err(match (count, expected) {
        (Some(n), Some(size)) => {
            format!("binary STL of {n} facets should have {size} bytes, but has {}: truncated?", bytes.len())
        }
        _ => "neither a binary STL (under 84 bytes) nor an ASCII one (no 'solid')".to_owned(),
    })
}

fn read_binary(facets: &[u8], budget: &mut Budget) -> Result<Vec<Triangle>, String> {
    // Corners, object and material.
    budget.take(facets.len() / FACET, size_of::<Triangle>() + 8)?;
    let mut positions = Vec::with_capacity(facets.len() / FACET);
    for (index, facet) in facets.as_chunks::<FACET>().0.iter().enumerate() {
        let (words, _) = facet[12..48].as_chunks::<4>();
        let corner = |v: usize| [0, 1, 2].map(|k| f32::from_le_bytes(words[3 * v + k]));
        let triangle = [corner(0), corner(1), corner(2)];
        check(&triangle, index)?;
        positions.push(triangle);
    }
    Ok(positions)
}

fn check(triangle: &Triangle, index: usize) -> Result<(), String> {
    match triangle.iter().position(|v| !v.iter().all(|x| x.is_finite())) {
        None => Ok(()),
        Some(v) => Err(format!("triangle {index}, vertex {v}: {:?} is not finite", triangle[v])),
    }
}

fn read_ascii(path: &Path, bytes: &[u8], budget: &mut Budget) -> Result<Scene, String> {
    let mut scene = plain_scene(path, Vec::new());
    let mut text = Text { bytes, at: 0 };
    let mut objects = Names::default();
    let mut solid: &[u8] = b"";
    let mut object = None;
    let mut corners = Vec::with_capacity(4);
    let mut ended = false;
    while let Some(word) = text.word() {
        ended = false;
        let at = |e: String, text: &Text| format!("line {}: {e}", text.line());
        match word.to_ascii_lowercase().as_slice() {
            b"solid" => (solid, object) = (text.rest_of_line(), None),
            b"endsolid" => {
                text.rest_of_line();
                ended = true;
            }
            // The normal is whatever stands there, on that line.
            b"facet" => {
                text.rest_of_line();
            }
            b"outer" => {
                text.word()
                    .filter(|w| w.eq_ignore_ascii_case(b"loop"))
                    .ok_or_else(|| at("'outer' without 'loop'".to_owned(), &text))?;
                corners.clear();
            }
            b"vertex" => {
                let index = scene.soup.len();
                let mut vertex = [0.0f32; 3];
                for value in &mut vertex {
                    let word =
                        text.word().ok_or_else(|| at(format!("triangle {index} ends early"), &text))?;
                    *value = number(word).map_err(|e| at(format!("triangle {index}: {e}"), &text))?;
                }
                if corners.len() == 3 {
                    return Err(at(format!("triangle {index} has more than three vertices"), &text));
                }
                corners.push(vertex);
            }
            b"endloop" => {
                let index = scene.soup.len();
                let triangle: Triangle = corners.as_slice().try_into().map_err(|_| {
                    at(format!("triangle {index} has {} vertices instead of three", corners.len()), &text)
                })?;
                check(&triangle, index).map_err(|e| at(e, &text))?;
                let id = match object {
                    Some(id) => id,
                    None => objects.id(solid, budget)?,
                };
                object = Some(id);
                budget.push(&mut scene.soup.positions, triangle)?;
                budget.push(&mut scene.soup.object, id)?;
                budget.push(&mut scene.soup.material, 0)?;
                corners.clear();
            }
            b"endfacet" => {}
            _ => return Err(at(format!("{} is no STL keyword", quote(word)), &text)),
        }
    }
    if !ended {
        return Err(format!("no 'endsolid' after triangle {}: truncated?", scene.soup.len()));
    }
    scene.objects = objects.into_objects(&scene.name);
    Ok(scene)
}
