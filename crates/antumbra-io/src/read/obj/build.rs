//! Statements to a scene.

use std::path::Path;

use antumbra::scene::{Scene, Soup};

use super::super::mesh::{Budget, linear_of_srgb, stem};
use super::{Obj, material};
use crate::Error;

/// Resolves indices and materials.
pub(super) fn scene(path: &Path, file: Obj, budget: &mut Budget) -> Result<Scene, Error> {
    let look = material::look_up(path, &file.materials, &file.libraries, budget)?;
    let any = |k: usize| file.corners.iter().flatten().any(|c| c.0[k] != super::face::NONE);
    let (uvs, normals, colors) = (any(1), any(2), !file.colors.is_empty());
    let size = 36 + 24 * usize::from(uvs) + 36 * (usize::from(normals) + usize::from(colors));
    budget.take(file.corners.len(), size).map_err(|e| Error::content(path, e))?;
    let mut soup = Soup {
        positions: file.corners.iter().map(|t| t.map(|c| file.positions[c.position()])).collect(),
        ..Soup::default()
    };
    if normals {
        let normal = |i: u32| file.normals.get(i as usize).copied().unwrap_or_default();
        soup.normals = file.corners.iter().map(|t| t.map(|c| normal(c.0[2]))).collect();
    }
    if uvs {
        let uv = |i: u32, material: u32| {
            let Some(&uv) = file.uvs.get(i as usize) else { return [0.0; 2] };
            let moved = look.moved.get(material as usize);
            let [u, v] = moved.map_or(uv, |(s, o)| [uv[0] * s[0] + o[0], uv[1] * s[1] + o[1]]);
            // The file counts v upwards.
            [u, 1.0 - v]
        };
        let triangles = file.corners.iter().zip(&file.material);
        soup.uvs = triangles.map(|(t, m)| t.map(|c| uv(c.0[1], *m))).collect();
    }
    if colors {
        // Some programs write 0 to 255.
        let full = if file.colors.as_flattened().iter().any(|v| *v > 1.0) { 255.0 } else { 1.0 };
        let color = |i: usize| file.colors[i].map(|v| linear_of_srgb((v / full).clamp(0.0, 1.0)));
        soup.colors = file.corners.iter().map(|t| t.map(|c| color(c.position()))).collect();
    }
    soup.object = file.object;
    soup.material = file.material;
    let name = stem(path);
    Ok(Scene {
        objects: file.objects.into_objects(&name),
        name,
        soup,
        materials: look.materials,
        textures: look.textures,
        ..Scene::default()
    })
}
