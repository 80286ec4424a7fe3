//! PLY (Stanford), ASCII and binary of both byte orders.
//!
//! Understood: `vertex` with `x y z`, normals, colours and texture coordinates of any scalar type; `face` with
//! `vertex_indices`; `tristrips`. All else is passed over.
//!
//! Source of the format: G. Turk, "The PLY Polygon File Format", 1994.

mod body;
mod header;

use std::path::Path;

use antumbra::scene::Scene;

use super::mesh::polygon::Cutter;
use super::mesh::{Budget, linear_of_byte, linear_of_srgb, load, plain_scene};
use crate::Error;
use body::Body;
use header::{Element, Header, Scalar};

/// Reads a PLY file: one object, one material.
pub(super) fn open(path: &Path) -> Result<Scene, Error> {
    let mut budget = Budget::new();
    let bytes = load(path, &mut budget)?;
    let mesh = read(&bytes, &mut budget).map_err(|e| Error::content(path, e))?;
    budget.give(bytes.len());
    drop(bytes);
    build(path, mesh, &mut budget).map_err(|e| Error::content(path, e))
}

/// Vertices, and triangles as indices. The optional arrays are empty or as long as `positions`.
#[derive(Debug, Default)]
struct Mesh {
    positions: Vec<[f32; 3]>,
    normals: Vec<[f32; 3]>,
    colors: Vec<[f32; 3]>,
    uvs: Vec<[f32; 2]>,
    triangles: Vec<[u32; 3]>,
}

fn read(bytes: &[u8], budget: &mut Budget) -> Result<Mesh, String> {
    let header = header::read(bytes)?;
    let mut mesh = Mesh::default();
    let vertex = header.elements.iter().position(|e| e.name == "vertex");
    let vertex = vertex.ok_or("the header has no element 'vertex'")?;
    let is_surface = |e: &Element| matches!(e.name.as_str(), "face" | "tristrips") && e.count > 0;
    if !header.elements.iter().any(is_surface) {
        return Err(format!(
            "a point cloud: {} vertices and no faces; make a surface of it first",
            header.elements[vertex].count
        ));
    }
    // Faces may stand before their vertices: then those are visited first.
    let mut body = start(bytes, &header);
    for element in &header.elements[..vertex] {
        body.skip_element(element)?;
    }
    read_vertices(&mut body, &header.elements[vertex], &mut mesh, budget)?;
    let after = body;
    let mut body = start(bytes, &header);
    for (i, element) in header.elements.iter().enumerate() {
        if i == vertex {
            body = after.clone();
        } else if is_surface(element) {
            read_faces(&mut body, element, &mut mesh, budget)?;
        } else if header.elements[i..].iter().any(is_surface) {
            body.skip_element(element)?;
        }
    }
    if mesh.triangles.is_empty() {
        return Err("no triangles: no face has three corners".to_owned());
    }
    Ok(mesh)
}

fn start<'a>(bytes: &'a [u8], header: &Header) -> Body<'a> {
    Body::new(bytes, header.body, header.format)
}

/// What a column of the vertices is for.
#[derive(Clone, Copy)]
enum Column {
    Skip,
    Position(usize),
    Normal(usize),
    /// With the value that stands for 1, or 0 if the column is linear already.
    Color(usize, f64),
    Uv(usize),
}

fn columns(element: &Element) -> Result<Vec<Column>, String> {
    let mut columns = vec![Column::Skip; element.properties.len()];
    let single = |names: &[&str]| element.find(names).filter(|&i| element.properties[i].count.is_none());
    for (k, name) in ["x", "y", "z"].into_iter().enumerate() {
        let i = single(&[name]).ok_or_else(|| format!("the vertices have no property '{name}'"))?;
        columns[i] = Column::Position(k);
    }
    let normals = ["nx", "ny", "nz"].map(|n| single(&[n]));
    if let [Some(x), Some(y), Some(z)] = normals {
        [x, y, z].into_iter().enumerate().for_each(|(k, i)| columns[i] = Column::Normal(k));
    }
    let colors =
        [["red", "r", "diffuse_red"], ["green", "g", "diffuse_green"], ["blue", "b", "diffuse_blue"]];
    if let [Some(r), Some(g), Some(b)] = colors.map(|names| single(&names)) {
        for (k, i) in [r, g, b].into_iter().enumerate() {
            columns[i] = Column::Color(k, element.properties[i].value.full());
        }
    }
    let uvs = [["s", "u", "texture_u", "texture_s"], ["t", "v", "texture_v", "texture_t"]];
    if let [Some(u), Some(v)] = uvs.map(|names| single(&names)) {
        [u, v].into_iter().enumerate().for_each(|(k, i)| columns[i] = Column::Uv(k));
    }
    Ok(columns)
}

fn read_vertices(
    body: &mut Body,
    element: &Element,
    mesh: &mut Mesh,
    budget: &mut Budget,
) -> Result<(), String> {
    let columns = columns(element)?;
    let rows = body.rows(element)?;
    if u32::try_from(rows).is_err() {
        return Err(format!("{rows} vertices are more than 32-bit indices can name"));
    }
    let any = |wanted: fn(&Column) -> bool| columns.iter().any(wanted);
    let normals = any(|c| matches!(c, Column::Normal(_)));
    let colors = any(|c| matches!(c, Column::Color(..)));
    let uvs = any(|c| matches!(c, Column::Uv(_)));
    budget.take(rows, 12 + 12 * usize::from(normals) + 12 * usize::from(colors) + 8 * usize::from(uvs))?;
    mesh.positions.reserve_exact(rows);
    mesh.normals.reserve_exact(if normals { rows } else { 0 });
    mesh.colors.reserve_exact(if colors { rows } else { 0 });
    mesh.uvs.reserve_exact(if uvs { rows } else { 0 });
    for row in 0..rows {
        let (mut position, mut normal, mut color, mut uv) = ([0.0f32; 3], [0.0; 3], [0.0; 3], [0.0; 2]);
        for (property, column) in element.properties.iter().zip(&columns) {
            let mut next = || body.value(property.value);
            let done = match *column {
                Column::Skip => body.skip(property),
                Column::Position(k) => next().map(|v| position[k] = v as f32),
                Column::Normal(k) => next().map(|v| normal[k] = v as f32),
                Column::Color(k, full) => next().map(|v| color[k] = linear(v, full)),
                Column::Uv(k) => next().map(|v| uv[k] = v as f32),
            };
            done.map_err(|e| format!("vertex {row}{}: {e}", body.place()))?;
        }
        if !position.iter().all(|v| v.is_finite()) {
            return Err(format!("vertex {row}{}: {position:?} is not finite", body.place()));
        }
        mesh.positions.push(position);
        // Nothing depends on the rest but looks, and scanners do write NaN normals: "unknown" is better than an error.
        if normals {
            mesh.normals.push(if normal.iter().all(|v| v.is_finite()) { normal } else { [0.0; 3] });
        }
        if colors {
            mesh.colors.push(color.map(|v| if v.is_finite() { v } else { 1.0 }));
        }
        if uvs {
            // Programs that write these count v upwards.
            mesh.uvs.push(if uv.iter().all(|v| v.is_finite()) { [uv[0], 1.0 - uv[1]] } else { [0.0; 2] });
        }
    }
    Ok(())
}

/// Integer colours are sRGB, floating-point ones linear.
fn linear(value: f64, full: f64) -> f32 {
    if full == 255.0 {
        linear_of_byte(value as u8)
    } else if full > 0.0 {
        linear_of_srgb((value / full).clamp(0.0, 1.0) as f32)
    } else {
        value as f32
    }
}

/// Bytes a corner of the longest list that it takes to hold and cut it, with slack for growth.
const SCRATCH: usize = 160;

fn read_faces(
    body: &mut Body,
    element: &Element,
    mesh: &mut Mesh,
    budget: &mut Budget,
) -> Result<(), String> {
    let list = element.find(&["vertex_indices", "vertex_index"]);
    let list = list.filter(|&i| element.properties[i].count.is_some());
    let list = list.ok_or_else(|| format!("the element '{}' has no list 'vertex_indices'", element.name))?;
    let strips = element.name == "tristrips";
    let mut cutter = Cutter::default();
    let mut corners: Vec<u32> = Vec::new();
    let mut longest = 0;
    for row in 0..body.rows(element)? {
        let mut done = Ok(());
        for (i, property) in element.properties.iter().enumerate() {
            done = match property.count {
                Some(count) if i == list => {
                    let len = body.list_len(count, property.value);
                    len.and_then(|len| {
                        budget.take(len.saturating_sub(longest), SCRATCH)?;
                        longest = longest.max(len);
                        read_list(body, len, property.value, strips, mesh.positions.len(), &mut corners)
                    })
                }
                _ => body.skip(property),
            };
            if done.is_err() {
                break;
            }
        }
        done.and_then(|()| {
            if strips {
                return add_strips(&corners, mesh, budget);
            }
            match *corners.as_slice() {
                [a, b, c] => budget.push(&mut mesh.triangles, [a, b, c]),
                _ => {
                    cutter.cut(corners.iter().map(|&i| mesh.positions[i as usize]))?;
                    for t in &cutter.corners {
                        budget.push(&mut mesh.triangles, t.map(|i| corners[i]))?;
                    }
                    Ok(())
                }
            }
        })
        .map_err(|e| format!("{} {row}{}: {e}", element.name, body.place()))?;
    }
    Ok(())
}

/// Ends a strip.
const RESTART: u32 = u32::MAX;

fn read_list(
    body: &mut Body,
    len: usize,
    item: Scalar,
    strips: bool,
    vertices: usize,
    corners: &mut Vec<u32>,
) -> Result<(), String> {
    corners.clear();
    for _ in 0..len {
        let value = body.value(item)?;
        if value >= 0.0 && value < vertices as f64 && value.fract() == 0.0 {
            corners.push(value as u32);
        } else if strips && value == -1.0 {
            corners.push(RESTART);
        } else {
            return Err(format!("vertex index {value} out of range (there are {vertices})"));
        }
    }
    Ok(())
}

fn add_strips(corners: &[u32], mesh: &mut Mesh, budget: &mut Budget) -> Result<(), String> {
    for strip in corners.split(|&i| i == RESTART) {
        for (i, &[a, b, c]) in strip.array_windows().enumerate() {
            let triangle = if i % 2 == 0 { [a, b, c] } else { [b, a, c] };
            budget.push(&mut mesh.triangles, triangle)?;
        }
    }
    Ok(())
}

fn build(path: &Path, mesh: Mesh, budget: &mut Budget) -> Result<Scene, String> {
    let columns = 1 + usize::from(!mesh.normals.is_empty()) + usize::from(!mesh.colors.is_empty());
    budget.take(mesh.triangles.len(), 8 + 36 * columns + if mesh.uvs.is_empty() { 0 } else { 24 })?;
    let mut scene = plain_scene(path, gather(&mesh.triangles, &mesh.positions));
    scene.soup.normals = gather(&mesh.triangles, &mesh.normals);
    scene.soup.colors = gather(&mesh.triangles, &mesh.colors);
    scene.soup.uvs = gather(&mesh.triangles, &mesh.uvs);
    Ok(scene)
}

fn gather<T: Copy>(triangles: &[[u32; 3]], values: &[T]) -> Vec<[T; 3]> {
    if values.is_empty() {
        return Vec::new();
    }
    triangles.iter().map(|t| t.map(|i| values[i as usize])).collect()
}
