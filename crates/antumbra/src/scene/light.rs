//! Point lights, and which triangles cast for them.

use std::borrow::Cow;

use super::{Soup, Triangle};

/// A point light.
#[derive(Clone, Debug, PartialEq)]
pub struct PointLight {
    /// Name in the file, or empty.
    pub name: String,
    /// World space.
    pub position: [f32; 3],
    /// Linear colour; what it is scaled by is `intensity`.
    pub color: [f32; 3],
    /// Candela, as in `KHR_lights_punctual`; shading may normalise it.
    pub intensity: f32,
    /// Triangles nearer than this to the light do not block (lamps sit in lamp glass); 0 for none.
    pub skip_radius: f32,
    /// Objects (indices into [`super::Scene::objects`]) that do not block this light.
    pub excluded: Vec<u32>,
}

impl PointLight {
    /// A white light of unit intensity at `position`, with nothing left out.
    pub fn at(position: [f32; 3]) -> PointLight {
        PointLight {
            name: String::new(),
            position,
            color: [1.0; 3],
            intensity: 1.0,
            skip_radius: 0.0,
            excluded: Vec::new(),
        }
    }
}

/// The triangles that cast for one light, and where they stand in the soup.
#[derive(Clone, Debug)]
pub struct Casters<'a> {
    /// The triangles that the shadow test sees.
    pub triangles: Cow<'a, [Triangle]>,
    /// For each of them its index in the soup; `None` means "all, in order".
    pub source: Option<Vec<u32>>,
}

impl Soup {
    /// The casters of `light`: all triangles but those of excluded objects and those whose nearest point is nearer to
    /// the light than `skip_radius`. This happens *before* the shadow test, so exactness is untouched.
    pub fn casters(&self, light: &PointLight) -> Casters<'_> {
        if light.skip_radius <= 0.0 && light.excluded.is_empty() {
            return Casters { triangles: Cow::Borrowed(&self.positions), source: None };
        }
        let radius = f64::from(light.skip_radius);
        let keep = |&i: &u32| {
            let t = &self.positions[i as usize];
            !light.excluded.contains(&self.object[i as usize])
                && (radius <= 0.0 || distance_squared(t, light.position) >= radius * radius)
        };
        let source: Vec<u32> = (0..self.len() as u32).filter(keep).collect();
        let triangles = source.iter().map(|&i| self.positions[i as usize]).collect();
        Casters { triangles: Cow::Owned(triangles), source: Some(source) }
    }
}

/// Squared distance of a point to a triangle (Ericson 2005, "Real-Time Collision Detection", section 5.1.5).
fn distance_squared(t: &Triangle, p: [f32; 3]) -> f64 {
    let v = |a: [f32; 3], b: [f32; 3]| [0, 1, 2].map(|k| f64::from(a[k]) - f64::from(b[k]));
    let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    let along = |a: [f64; 3], u: [f64; 3], s: f64| [0, 1, 2].map(|k| a[k] - u[k] * s);
    let edge = |a: [f32; 3], b: [f32; 3]| {
        let (u, w) = (v(b, a), v(p, a));
        let length = dot(u, u);
        let s = if length > 0.0 { (dot(u, w) / length).clamp(0.0, 1.0) } else { 0.0 };
        let d = along(w, u, s);
        dot(d, d)
    };
    let [a, b, c] = *t;
    let (ab, ac, ap) = (v(b, a), v(c, a), v(p, a));
    let edges = edge(a, b).min(edge(b, c)).min(edge(c, a));
    let (d00, d01, d11, d20, d21) = (dot(ab, ab), dot(ab, ac), dot(ac, ac), dot(ap, ab), dot(ap, ac));
    let det = d00 * d11 - d01 * d01;
    let (s, t) = ((d11 * d20 - d01 * d21) / det, (d00 * d21 - d01 * d20) / det);
    if det > 0.0 && s >= 0.0 && t >= 0.0 && s + t <= 1.0 {
        let d = along(along(ap, ab, s), ac, t);
        return dot(d, d).min(edges);
    }
    edges
}

#[cfg(test)]
mod tests {
    use super::*;

    fn two_triangles() -> Soup {
        let near = [[-1.0, 1.0, -1.0], [1.0, 1.0, -1.0], [0.0, 1.0, 2.0]];
        let far = near.map(|[x, _, z]| [x, -5.0, z]);
        Soup { positions: vec![near, far], object: vec![0, 1], material: vec![0, 0], ..Soup::default() }
    }

    #[test]
    fn skip_radius_measures_the_nearest_point_not_the_vertices() {
        let soup = two_triangles();
        let light = |skip_radius| PointLight { skip_radius, ..PointLight::at([0.0; 3]) };
        assert_eq!(soup.casters(&light(0.0)).triangles.len(), 2);
        assert_eq!(soup.casters(&light(0.99)).triangles.len(), 2);
        assert_eq!(soup.casters(&light(1.01)).source, Some(vec![1]));
    }

    #[test]
    fn excluded_objects_do_not_cast() {
        let soup = two_triangles();
        let light = PointLight { excluded: vec![1], ..PointLight::at([0.0; 3]) };
        assert_eq!(soup.casters(&light).source, Some(vec![0]));
    }
}
