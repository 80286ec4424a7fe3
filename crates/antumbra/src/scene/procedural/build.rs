//! The builder that every scene is made with: current object, material and placement, and one way to add a triangle.

use super::math::{V3, add, cross, dot, scale, sub, turn, unit};
use crate::scene::{AlphaMode, Camera, Material, Object, PointLight, Scene, Texture};

/// Where local coordinates go in the world: `origin + x axes[0] + y axes[1] + z axes[2]`.
#[derive(Clone, Copy)]
pub(super) struct Place {
    axes: [V3; 3],
    origin: V3,
}

impl Place {
    pub(super) fn at(origin: V3) -> Place {
        Place { axes: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]], origin }
    }

    /// Turned about the local y axis first: z goes towards x.
    pub(super) fn turned(self, turns: f64) -> Place {
        let (cos, sin) = turn(turns);
        self.of([[cos, 0.0, -sin], [0.0, 1.0, 0.0], [sin, 0.0, cos]])
    }

    /// Scaled along the local axes first.
    pub(super) fn scaled(self, [x, y, z]: V3) -> Place {
        self.of([[x, 0.0, 0.0], [0.0, y, 0.0], [0.0, 0.0, z]])
    }

    fn of(self, axes: [V3; 3]) -> Place {
        Place { axes: axes.map(|a| self.direction(a)), origin: self.origin }
    }

    fn direction(&self, p: V3) -> V3 {
        add(add(scale(self.axes[0], p[0]), scale(self.axes[1], p[1])), scale(self.axes[2], p[2]))
    }

    pub(super) fn point(&self, p: V3) -> V3 {
        add(self.direction(p), self.origin)
    }
}

/// The nearest `f32`; zero always positive, so that equal points have equal bits.
pub(super) fn round(p: V3) -> [f32; 3] {
    p.map(|v| v as f32 + 0.0)
}

/// A scene in the making.
pub(super) struct Builder {
    pub(super) scene: Scene,
    place: Place,
    object: u32,
    material: u32,
}

impl Builder {
    pub(super) fn new() -> Builder {
        Builder { scene: Scene::default(), place: Place::at([0.0; 3]), object: 0, material: 0 }
    }

    /// Number of triangles so far.
    pub(super) fn len(&self) -> usize {
        self.scene.soup.len()
    }

    /// What follows belongs to a new object.
    pub(super) fn object(&mut self, name: impl Into<String>) -> &mut Self {
        self.object = self.scene.objects.len() as u32;
        self.scene.objects.push(Object { name: name.into() });
        self
    }

    /// What follows has this material (made on its first use): `0xRRGGBB` as a web page writes colours.
    pub(super) fn paint(&mut self, name: &str, rgb: u32) -> &mut Self {
        let [r, g, b] = linear(rgb);
        self.material(Material { name: name.into(), base_color: [r, g, b, 1.0], ..Material::default() })
    }

    /// As [`Builder::paint`], and it shines.
    pub(super) fn glow(&mut self, name: &str, rgb: u32, strength: f32) -> &mut Self {
        let [r, g, b] = linear(rgb);
        let emissive = linear(rgb).map(|c| c * strength);
        self.material(Material {
            name: name.into(),
            base_color: [r, g, b, 1.0],
            emissive,
            ..Material::default()
        })
    }

    /// As [`Builder::paint`], with a texture whose alpha is there or not there.
    pub(super) fn cut_out(&mut self, texture: Texture) -> &mut Self {
        let index = self.scene.textures.len() as u32;
        self.scene.textures.push(texture);
        self.material(Material {
            name: self.scene.textures[index as usize].name.clone(),
            base_color: [1.0; 4],
            base_color_texture: Some(index),
            alpha_mode: AlphaMode::Mask { cutoff: 0.5 },
            ..Material::default()
        })
    }

    fn material(&mut self, material: Material) -> &mut Self {
        let materials = &mut self.scene.materials;
        let index = materials.iter().position(|m| m.name == material.name).unwrap_or(materials.len());
        if index == materials.len() {
            materials.push(material);
        }
        self.material = index as u32;
        self
    }

    /// Back to a material by the name that it was made with.
    pub(super) fn with_material(&mut self, name: &str) -> &mut Self {
        let index = self.scene.materials.iter().position(|m| m.name == name);
        self.material = index.map_or(0, |i| i as u32);
        self
    }

    /// Adds a light that is right for surfaces at distance `reach`.
    pub(super) fn light(&mut self, position: V3, rgb: u32, reach: f64) -> &mut Self {
        let light = PointLight {
            name: format!("light {}", self.scene.lights.len()),
            color: linear(rgb),
            intensity: (reach * reach) as f32,
            ..PointLight::at(round(position))
        };
        self.scene.lights.push(light);
        self
    }

    /// Adds a camera.
    pub(super) fn camera(&mut self, eye: V3, target: V3, fov: f32) -> &mut Self {
        let [eye, target] = [eye, target].map(round);
        let name = format!("camera {}", self.scene.cameras.len());
        self.scene.cameras.push(Camera { name, eye, target, up: [0.0, 1.0, 0.0], fov });
        self
    }

    /// Everything that `make` adds is put at `place` (within the current placement).
    pub(super) fn within(&mut self, place: Place, make: impl FnOnce(&mut Builder)) -> &mut Self {
        let outer = self.place;
        self.place =
            Place { axes: place.axes.map(|a| outer.direction(a)), origin: outer.point(place.origin) };
        make(self);
        self.place = outer;
        self
    }

    /// The current placement applied.
    pub(super) fn placed(&self, p: V3) -> V3 {
        self.place.point(p)
    }

    /// One triangle in local coordinates, as it is.
    pub(super) fn triangle(&mut self, corners: [V3; 3]) -> &mut Self {
        let world = corners.map(|p| round(self.place.point(p)));
        self.world_triangle(world)
    }

    /// One triangle in world coordinates, as it is.
    pub(super) fn world_triangle(&mut self, corners: [[f32; 3]; 3]) -> &mut Self {
        self.scene.soup.positions.push(corners);
        self.scene.soup.object.push(self.object);
        self.scene.soup.material.push(self.material);
        self
    }

    /// One triangle in world coordinates with shading normals.
    pub(super) fn smooth_triangle(&mut self, corners: [[f32; 3]; 3], normals: [[f32; 3]; 3]) {
        let soup = &mut self.scene.soup;
        // Flat triangles before this one have no normals yet.
        soup.normals.resize(soup.positions.len(), [[0.0; 3]; 3]);
        soup.normals.push(normals);
        self.world_triangle(corners);
    }

    /// Many triangles in world coordinates.
    pub(super) fn world_triangles(&mut self, triangles: Vec<[[f32; 3]; 3]>) {
        let soup = &mut self.scene.soup;
        let len = soup.len() + triangles.len();
        if soup.positions.is_empty() {
            soup.positions = triangles;
        } else {
            soup.positions.extend_from_slice(&triangles);
        }
        soup.object.resize(len, self.object);
        soup.material.resize(len, self.material);
    }

    /// One quadrangle as two triangles.
    pub(super) fn quad(&mut self, [a, b, c, d]: [V3; 4]) -> &mut Self {
        self.triangle([a, b, c]).triangle([a, c, d])
    }

    /// One quadrangle with the whole of the current texture on it, `a` at the bottom left.
    pub(super) fn textured_quad(&mut self, corners: [V3; 4]) -> &mut Self {
        let uvs = &mut self.scene.soup.uvs;
        uvs.resize(self.scene.soup.positions.len(), [[0.0; 2]; 3]);
        let [a, b, c, d] = [[0.0, 1.0], [1.0, 1.0], [1.0, 0.0], [0.0, 0.0]];
        uvs.extend([[a, b, c], [a, c, d]]);
        self.quad(corners)
    }

    /// The finished scene.
    pub(super) fn finish(mut self, name: &str) -> Scene {
        let soup = &mut self.scene.soup;
        let len = soup.positions.len();
        if !soup.normals.is_empty() {
            soup.normals.resize(len, [[0.0; 3]; 3]);
        }
        if !soup.uvs.is_empty() {
            soup.uvs.resize(len, [[0.0; 2]; 3]);
        }
        self.scene.name = name.into();
        self.scene
    }
}

/// `0xRRGGBB` in sRGB to linear, by a cubic that is within 1 % (no `powf`: see [`super::math`]).
fn linear(rgb: u32) -> [f32; 3] {
    [16, 8, 0].map(|shift| {
        let x = ((rgb >> shift) & 255) as f32 / 255.0;
        x * (x * (x * 0.305_306 + 0.682_171_1) + 0.012_522_878)
    })
}

/// Two directions that make a right-handed frame with the unit vector `z`.
pub(super) fn frame(z: V3) -> [V3; 2] {
    let helper = if z[1].abs() < 0.9 { [0.0, 1.0, 0.0] } else { [1.0, 0.0, 0.0] };
    let x = unit(cross(helper, z));
    [x, cross(z, x)]
}

/// `x` made square to the unit vector `z`, at length 1.
pub(super) fn square_to(x: V3, z: V3) -> V3 {
    unit(sub(x, scale(z, dot(x, z))))
}
