//! OBJ with MTL (Wavefront).
//!
//! Understood: `v` (with colours), `vt`, `vn`, `f` (any polygon, negative and forward indices), `o`, `g`, `usemtl`,
//! `mtllib`. Points, lines and free-form surfaces are passed over. A missing material or texture file does not keep
//! the shapes from loading: shadows do not need it, and the material's name says what is missing.
//!
//! Source of the format: P. Bourke's copy of the Wavefront Advanced Visualizer manual, appendices B1 and B5.

mod build;
mod face;
mod material;
mod texture;

use std::borrow::Cow;
use std::path::Path;

use antumbra::scene::Scene;

use super::mesh::polygon::Cutter;
use super::mesh::{Budget, Names, Text, finite, load, number};
use crate::Error;
use face::{Corner, Counts, Furthest};

/// Reads an OBJ file: every `o` or `g` name is an object, every `usemtl` name a material.
pub(super) fn open(path: &Path) -> Result<Scene, Error> {
    let mut budget = Budget::new();
    let bytes = load(path, &mut budget)?;
    let content = |e| Error::content(path, e);
    let mut file = Obj::default();
    file.read(&bytes, &mut budget).map_err(content)?;
    budget.give(bytes.len());
    drop(bytes);
    if file.corners.is_empty() {
        return Err(content("no triangles: no face has three corners".to_owned()));
    }
    build::scene(path, file, &mut budget)
}

/// More material files than any scene has; each costs a look at the disk.
const MOST_LIBRARIES: usize = 1000;

/// The statements of a file.
#[derive(Debug, Default)]
struct Obj {
    positions: Vec<[f32; 3]>,
    /// sRGB. Empty, or as long as `positions`.
    colors: Vec<[f32; 3]>,
    uvs: Vec<[f32; 2]>,
    normals: Vec<[f32; 3]>,
    /// Per triangle.
    corners: Vec<[Corner; 3]>,
    object: Vec<u32>,
    material: Vec<u32>,
    objects: Names,
    materials: Names,
    libraries: Vec<Vec<u8>>,
}

/// What the next face belongs to. A name becomes an object or a material when a face uses it.
#[derive(Default)]
struct Current<'a> {
    object: Cow<'a, [u8]>,
    material: Cow<'a, [u8]>,
    ids: Option<(u32, u32)>,
}

impl Obj {
    fn read(&mut self, bytes: &[u8], budget: &mut Budget) -> Result<(), String> {
        let mut furthest = Furthest::default();
        let mut polygon = face::Polygon::default();
        let mut cutter = Cutter::default();
        let mut current = Current::default();
        let mut lines = Statements { bytes, at: 0, line: 1 };
        while let Some((line, statement)) = lines.next(budget)? {
            let mut words = Text { bytes: &statement, at: 0 };
            let Some(word) = words.word() else { continue };
            let done = match word {
                b"v" => self.vertex(words, budget),
                b"vt" => uv(words).and_then(|uv| budget.push(&mut self.uvs, uv)),
                b"vn" => normal(words).and_then(|n| budget.push(&mut self.normals, n)),
                b"f" | b"fo" => {
                    let counts = Counts([self.positions.len(), self.uvs.len(), self.normals.len()]);
                    polygon
                        .read(words, counts, line, &mut furthest, budget)
                        .and_then(|()| self.face(&polygon, &mut cutter, &mut current, budget))
                }
                b"o" | b"g" => {
                    current.object = Cow::Owned(words.rest_of_line().to_vec());
                    current.ids = None;
                    Ok(())
                }
                b"usemtl" => {
                    current.material = Cow::Owned(words.rest_of_line().to_vec());
                    current.ids = None;
                    Ok(())
                }
                b"mtllib" => self.library(words.rest_of_line()),
                _ => Ok(()),
            };
            done.map_err(|e| format!("line {line}: {e}"))?;
        }
        furthest.check(Counts([self.positions.len(), self.uvs.len(), self.normals.len()]))
    }

    fn vertex(&mut self, words: Text, budget: &mut Budget) -> Result<(), String> {
        let index = self.positions.len();
        let mut numbers = [0.0; 7];
        let mut count = 0;
        for word in values(words).take(7) {
            let value = if count < 3 { finite(word) } else { number(word) };
            numbers[count] = value.map_err(|e| format!("vertex {}: {e}", index + 1))?;
            count += 1;
        }
        // "x y z", "x y z w", "x y z r g b", "x y z w r g b"; w is for free-form surfaces only.
        let color = match count {
            3..=5 => None,
            6 => Some(3),
            7 => Some(4),
            _ => return Err(format!("vertex {}: {count} coordinates instead of three", index + 1)),
        };
        if let Some(first) = color {
            if self.colors.is_empty() {
                budget.take(index, 12)?;
                self.colors.resize(index, [1.0; 3]);
            }
            let color = [0, 1, 2].map(|k| numbers[first + k]);
            budget.push(&mut self.colors, color.map(|v: f32| if v.is_finite() { v } else { 1.0 }))?;
        } else if !self.colors.is_empty() {
            budget.push(&mut self.colors, [1.0; 3])?;
        }
        budget.push(&mut self.positions, [numbers[0], numbers[1], numbers[2]])
    }

    fn face(
        &mut self,
        polygon: &face::Polygon,
        cutter: &mut Cutter,
        current: &mut Current,
        budget: &mut Budget,
    ) -> Result<(), String> {
        let corners = polygon.corners.as_slice();
        if corners.len() < 3 {
            return Ok(());
        }
        let (object, material) = match current.ids {
            Some(ids) => ids,
            None => {
                let object = self.objects.id(&current.object, budget)?;
                (object, self.materials.id(&current.material, budget)?)
            }
        };
        current.ids = Some((object, material));
        // Corners that are yet to come (rare) have no place yet to cut by; then all of it is a fan.
        let place = |c: &Corner| self.positions.get(c.position()).copied().unwrap_or_default();
        cutter.cut(corners.iter().map(place))?;
        for t in &cutter.corners {
            budget.push(&mut self.corners, t.map(|i| corners[i]))?;
            budget.push(&mut self.object, object)?;
            budget.push(&mut self.material, material)?;
        }
        Ok(())
    }

    fn library(&mut self, name: &[u8]) -> Result<(), String> {
        if name.is_empty() || self.libraries.iter().any(|l| l == name) {
            return Ok(());
        }
        if self.libraries.len() == MOST_LIBRARIES {
            return Err(format!("more than {MOST_LIBRARIES} material files"));
        }
        self.libraries.push(name.to_vec());
        Ok(())
    }
}

/// The words up to a comment.
fn values(mut words: Text<'_>) -> impl Iterator<Item = &[u8]> {
    std::iter::from_fn(move || words.word()).take_while(|w| w[0] != b'#')
}

/// Texture coordinates as they stand; what is not finite is 0, since some programs write NaN for "none".
fn uv(words: Text) -> Result<[f32; 2], String> {
    let mut uv = [0.0; 2];
    let mut count = 0;
    for (value, word) in uv.iter_mut().zip(values(words)) {
        let read: f32 = number(word)?;
        *value = if read.is_finite() { read } else { 0.0 };
        count += 1;
    }
    if count == 0 { Err("a texture coordinate without numbers".to_owned()) } else { Ok(uv) }
}

/// A normal; what is not finite becomes "use the geometric one".
fn normal(words: Text) -> Result<[f32; 3], String> {
    let mut normal = [0.0f32; 3];
    let mut count = 0;
    for (value, word) in normal.iter_mut().zip(values(words)) {
        *value = number(word)?;
        count += 1;
    }
    if count < 3 {
        return Err(format!("a normal of {count} numbers instead of three"));
    }
    Ok(if normal.iter().all(|v| v.is_finite()) { normal } else { [0.0; 3] })
}

/// Lines, joined where one ends in a backslash.
struct Statements<'a> {
    bytes: &'a [u8],
    at: usize,
    line: usize,
}

impl<'a> Statements<'a> {
    /// The next statement and the line that it begins in.
    fn next(&mut self, budget: &mut Budget) -> Result<Option<(usize, Cow<'a, [u8]>)>, String> {
        let rest = &self.bytes[self.at..];
        if rest.is_empty() {
            return Ok(None);
        }
        let (first, mut end, mut joined) = (self.line, 0, false);
        loop {
            let len = rest[end..].iter().position(|b| *b == b'\n');
            self.line += 1;
            let line = &rest[end..len.map_or(rest.len(), |len| end + len)];
            end = len.map_or(rest.len(), |len| end + len + 1);
            if len.is_none() || !line.trim_ascii_end().ends_with(b"\\") {
                break;
            }
            joined = true;
        }
        self.at += end;
        let statement = &rest[..end];
        if !joined {
            return Ok(Some((first, Cow::Borrowed(statement))));
        }
        // Freed with the statement; charged for good, as a file has few of them.
        budget.take(end, 1)?;
        let blank = |b: &u8| if matches!(b, b'\\' | b'\n' | b'\r') { b' ' } else { *b };
        Ok(Some((first, Cow::Owned(statement.iter().map(blank).collect()))))
    }
}
