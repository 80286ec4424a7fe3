//! Where to look from and where to put the light when nobody says: the same rules for every scene, none of them random.
//!
//! # The framed box
//! The box of all vertices, unless it is more than four times as large, on any axis, as that from the 5th to the 95th
//! percentile of the vertices: then the latter, so that sky domes and far hills do not count.
//!
//! # Rooms
//! A scene is a room if the free places of its box see something in at least 75 % of all directions (a box with one side
//! open passes, a house seen as a whole does not), and not just nearby: the mean free distance is at least 8 % of
//! the box's mean side. The box is the framed one; where that is of percentiles, with half as much around it, as walls
//! have few vertices.
//!
//! # The camera
//! 1. The file's first camera.
//! 2. In a room: inside. Of a lattice of free places where the things are (the percentiles' box seen from above), between
//!    15 % and 60 % of the height and with some clearance around, the place and the level direction with the longest
//!    views (mean logarithm of the free distances in a cone; a view that leaves the scene counts 30 %).
//! 3. Otherwise from outside: three quarters from the front of the longer side and from above (more so if the scene is
//!    flat), as near as all vertices of the framed box allow.
//!
//! # The light
//! 1. The file's first point light.
//! 2. In a room: halfway into the view and a bit to the right of it (for a camera outside the room: in its middle), at
//!    80 % of the height between floor and ceiling there.
//! 3. Otherwise above the framed box, to the right and towards the eye, outside the sphere around the box.

use std::sync::OnceLock;

use rayon::prelude::*;

use super::voxels::Voxels;
use super::{Camera, PointLight, Scene};
use crate::vec3::{V3, add, axes, cross, dot, scale, sub, unit};

/// Smallest and largest coordinates.
pub type Bounds = ([f32; 3], [f32; 3]);

/// Something chosen, and by which rule.
#[derive(Clone, Debug, PartialEq)]
pub struct Choice<T> {
    /// What was chosen.
    pub value: T,
    /// In a few words for a report.
    pub rule: &'static str,
}

/// At most about this many vertices are looked at: enough for percentiles and for framing.
const VERTICES: usize = 200_000;

/// Vertical field of view of cameras that are made up, in degrees.
const FOV: f32 = 45.0;

/// The box from the 5th to the 95th percentile of the vertices, axis by axis; `None` if there are no triangles.
pub fn core_bounds(scene: &Scene) -> Option<Bounds> {
    let vertices = scene.soup.positions.as_flattened();
    let step = vertices.len().div_ceil(VERTICES).max(1);
    let (mut lo, mut hi) = ([0.0; 3], [0.0; 3]);
    for k in 0..3 {
        let mut values: Vec<f32> = vertices.iter().step_by(step).map(|p| p[k]).collect();
        let last = values.len().checked_sub(1)?;
        let mut at = |share: f64| {
            *values.select_nth_unstable_by((share * last as f64).round() as usize, f32::total_cmp).1
        };
        (lo[k], hi[k]) = (at(0.05), at(0.95));
    }
    Some((lo, hi))
}

/// The box that pictures are framed by (see the module's page); `None` if there are no triangles.
pub fn framed_bounds(scene: &Scene) -> Option<Bounds> {
    let (all, core) = (scene.soup.bounds()?, core_bounds(scene)?);
    let compact = (0..3).all(|k| all.1[k] - all.0[k] <= 4.0 * (core.1[k] - core.0[k]));
    Some(if compact { all } else { core })
}

/// The rules applied to one scene. What they need to know is found out once, when it is first asked for.
pub struct Defaults<'a> {
    scene: &'a Scene,
    up: V3,
    survey: OnceLock<Option<Survey>>,
}

/// What is known about the space of a scene.
struct Survey {
    framed: Bounds,
    core: Bounds,
    /// Where a room is looked for.
    space: Bounds,
    voxels: Voxels,
    is_room: bool,
}

impl<'a> Defaults<'a> {
    /// `up` is snapped to the nearest axis for made-up cameras; readers give scenes with Y up.
    pub fn new(scene: &'a Scene, up: [f32; 3]) -> Defaults<'a> {
        let axis = (0..3).fold(1, |best, k| if up[k].abs() > up[best].abs() { k } else { best });
        let mut snapped = [0.0; 3];
        snapped[axis] = if up[axis] < 0.0 { -1.0 } else { 1.0 };
        Defaults { scene, up: snapped, survey: OnceLock::new() }
    }

    /// The camera for a picture of `aspect` (width by height).
    pub fn camera(&self, aspect: f32) -> Choice<Camera> {
        if let Some(camera) = self.scene.cameras.first() {
            return Choice { value: camera.clone(), rule: "first camera of the file" };
        }
        let Some(survey) = self.survey() else {
            let camera = self.looking([0.0, 0.0, 5.0], [0.0; 3]);
            return Choice { value: camera, rule: "nothing to look at" };
        };
        match survey.is_room.then(|| survey.longest_view(self.up)).flatten() {
            Some((eye, target)) => {
                Choice { value: self.looking(eye, target), rule: "longest view inside the room" }
            }
            None => Choice {
                value: self.seen_from_outside(survey, aspect),
                rule: "three-quarter view from outside",
            },
        }
    }

    /// The light for a picture that `camera` takes.
    pub fn light(&self, camera: &Camera) -> Choice<PointLight> {
        if let Some(light) = self.scene.lights.first() {
            return Choice { value: light.clone(), rule: "first point light of the file" };
        }
        let Some(survey) = self.survey() else {
            return Choice { value: PointLight::at([0.0, 5.0, 0.0]), rule: "nothing to light" };
        };
        if let Some(position) = survey.under_ceiling(camera, self.up) {
            return Choice { value: PointLight::at(position), rule: "under the ceiling in view" };
        }
        let (lo, hi) = survey.framed;
        let (centre, radius) = (middle(survey.framed), 0.5 * length(sub(hi, lo)));
        let [right, ..] = axes(camera.eye, camera.target, self.up);
        let towards_eye = cross(right, self.up);
        let offset = add(add(scale(right, 0.6), scale(self.up, 0.85)), scale(towards_eye, 0.8));
        let position = add(centre, scale(offset, if radius > 0.0 { radius } else { 1.0 }));
        Choice { value: PointLight::at(position), rule: "above and beside the scene" }
    }

    fn survey(&self) -> Option<&Survey> {
        let make = || {
            let (framed, core) = (framed_bounds(self.scene)?, core_bounds(self.scene)?);
            let all = self.scene.soup.bounds()?;
            let axes = [0, 1, 2];
            let margin = |k: usize| 0.5 * (framed.1[k] - framed.0[k]);
            let space = (
                axes.map(|k| (framed.0[k] - margin(k)).max(all.0[k])),
                axes.map(|k| (framed.1[k] + margin(k)).min(all.1[k])),
            );
            let voxels = Voxels::new(&self.scene.soup.positions, space.0, space.1);
            let mut survey = Survey { framed, core, space, voxels, is_room: false };
            survey.is_room = survey.looks_like_a_room();
            Some(survey)
        };
        self.survey.get_or_init(make).as_ref()
    }

    fn looking(&self, eye: V3, target: V3) -> Camera {
        Camera { name: String::new(), eye, target, up: self.up, fov: FOV }
    }

    fn seen_from_outside(&self, survey: &Survey, aspect: f32) -> Camera {
        let (lo, hi) = survey.framed;
        let up_axis = (0..3).find(|&k| self.up[k] != 0.0).unwrap_or(1);
        let mut side = [0.0; 3];
        side[(up_axis + 2) % 3] = 1.0;
        let back = cross(side, self.up);
        let reach = |v: V3| dot(v.map(f32::abs), sub(hi, lo));
        let flat = 1.0 - (2.0 * reach(self.up) / reach(side).max(reach(back))).clamp(0.0, 1.0);
        let (a, b) = if reach(side) >= reach(back) { (0.6, 1.0) } else { (1.0, 0.6) };
        let raised = scale(self.up, 0.4 + 0.5 * flat);
        let from = unit(add(add(scale(side, a), scale(back, b)), raised)).unwrap_or(back);

        let inside = |p: &V3| (0..3).all(|k| p[k] >= lo[k] && p[k] <= hi[k]);
        let vertices = self.scene.soup.positions.as_flattened();
        let step = vertices.len().div_ceil(VERTICES).max(1);
        let points: Vec<V3> = vertices.iter().step_by(step).copied().filter(inside).collect();
        let [right, upright, forward] = axes(from, [0.0; 3], self.up);
        let tan = (FOV.to_radians() * 0.5).tan() / 1.08;
        let tan_x = tan * aspect.max(1e-3);
        let radius = length(sub(hi, lo)).max(f32::MIN_POSITIVE);
        let (mut target, mut distance) = (middle(survey.framed), radius);
        // Twice: move to the middle of what is seen, then as near as it fits.
        for _ in 0..3 {
            let eye = sub(target, scale(forward, distance));
            let (mut least, mut most) = ([f32::INFINITY; 2], [f32::NEG_INFINITY; 2]);
            for p in &points {
                let v = sub(*p, eye);
                let depth = dot(v, forward).max(0.05 * distance);
                for (k, axis) in [right, upright].into_iter().enumerate() {
                    let s = dot(v, axis) / depth;
                    (least[k], most[k]) = (least[k].min(s), most[k].max(s));
                }
            }
            let shift = [0, 1].map(|k| 0.5 * (least[k] + most[k]) * distance);
            if shift.iter().all(|s| s.is_finite()) {
                target = add(target, add(scale(right, shift[0]), scale(upright, shift[1])));
            }
            let needed = |p: &V3| {
                let v = sub(*p, target);
                let wide = (dot(v, right).abs() / tan_x).max(dot(v, upright).abs() / tan);
                wide - dot(v, forward)
            };
            distance = points.iter().map(needed).fold(0.02 * radius, f32::max);
        }
        self.looking(sub(target, scale(forward, distance)), target)
    }
}

impl Survey {
    /// See the module's page.
    fn looks_like_a_room(&self) -> bool {
        let directions = sphere(32);
        // By cell, and added up in their order: the same sum for every number of threads.
        let seen: Vec<(usize, f64)> = self
            .lattice(|_| true)
            .into_par_iter()
            .map(|cell| {
                let centre = self.voxels.centre(cell);
                let met = directions.iter().filter_map(|d| self.voxels.free_path(centre, *d).ok());
                met.fold((0, 0.0), |(n, sum), distance| (n + 1, sum + f64::from(distance)))
            })
            .collect();
        let met: usize = seen.iter().map(|s| s.0).sum();
        let free: f64 = seen.iter().map(|s| s.1).sum();
        let extent = sub(self.space.1, self.space.0);
        let side = f64::from(extent[0] + extent[1] + extent[2]) / 3.0;
        met * 100 >= seen.len() * directions.len() * 75 && met > 0 && free / met as f64 >= 0.08 * side
    }

    /// Empty cells, every third on each axis.
    fn lattice(&self, keep: impl Fn(V3) -> bool) -> Vec<[usize; 3]> {
        let size = self.voxels.size;
        let mut cells = Vec::new();
        for z in (1..size[2].saturating_sub(1)).step_by(3) {
            for y in (1..size[1].saturating_sub(1)).step_by(3) {
                for x in (1..size[0].saturating_sub(1)).step_by(3) {
                    let cell = [x, y, z];
                    if !self.voxels.cell_is_full(cell) && keep(self.voxels.centre(cell)) {
                        cells.push(cell);
                    }
                }
            }
        }
        cells
    }

    /// Eye and target of the view that sees farthest, `None` if there is no room to stand.
    fn longest_view(&self, up: V3) -> Option<(V3, V3)> {
        const AROUND: usize = 16;
        // Weights of the directions around the viewing one: depth counts more than width.
        const CONE: [f32; 5] = [0.5, 2.0, 3.0, 2.0, 0.5];
        // What a view out of the scene is worth: an open roof is no wall, but there is nothing to see.
        const OPEN_VIEW: f32 = 0.3;
        let [side, _, front] = axes([0.0; 3], [up[1], up[2], up[0]], up);
        let (low, high) = (dot(up, self.space.0), dot(up, self.space.1));
        let (low, high) = (low.min(high), low.max(high));
        let (least, most) = self.core;
        let level = |p: V3| {
            (0.15..0.6).contains(&((dot(up, p) - low) / (high - low)))
                && (0..3).all(|k| up[k] != 0.0 || (least[k]..=most[k]).contains(&p[k]))
        };
        let direction = |azimuth: usize, tilt: f32| {
            let angle = azimuth as f32 * std::f32::consts::TAU / AROUND as f32;
            let flat = add(scale(side, angle.cos()), scale(front, angle.sin()));
            add(scale(flat, tilt.cos()), scale(up, tilt.sin()))
        };
        let cell = self.voxels.cell;
        let best_from = |cell_index: [usize; 3]| -> Option<(f32, V3, V3)> {
            let eye = self.voxels.centre(cell_index);
            let reach = |azimuth, tilt| match self.voxels.free_path(eye, direction(azimuth, tilt)) {
                Ok(distance) => distance,
                Err(distance) => OPEN_VIEW * distance,
            };
            let rays: Vec<[f32; 3]> = (0..AROUND).map(|a| [-0.25, 0.0, 0.25].map(|t| reach(a, t))).collect();
            // Not with the nose, or the back of the head, at a wall.
            if rays.iter().flatten().any(|d| *d < 1.5 * cell) {
                return None;
            }
            let score = |azimuth: usize| {
                let part = |(k, weight): (usize, &f32)| {
                    let column = rays[(azimuth + AROUND - 2 + k) % AROUND];
                    weight * column.iter().map(|d| (d / cell).ln()).sum::<f32>()
                };
                CONE.iter().enumerate().map(part).sum::<f32>()
            };
            let azimuth = (0..AROUND).max_by(|&a, &b| score(a).total_cmp(&score(b)))?;
            let target = add(eye, scale(direction(azimuth, -0.06), 0.6 * rays[azimuth][1]));
            Some((score(azimuth), eye, target))
        };
        let views: Vec<_> = self.lattice(level).into_par_iter().filter_map(best_from).collect();
        views.into_iter().max_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, eye, target)| (eye, target))
    }

    /// A place for a lamp in the room that the camera looks into, `None` if it is none or if there is no place.
    fn under_ceiling(&self, camera: &Camera, up: V3) -> Option<V3> {
        let voxels = &self.voxels;
        let either = |path: Result<f32, f32>| path.unwrap_or_else(|d| d);
        let [right, _, forward] = axes(camera.eye, camera.target, up);
        let level = unit(sub(forward, scale(up, dot(forward, up)))).unwrap_or(forward);
        let inside = (0..3).all(|k| (self.space.0[k]..=self.space.1[k]).contains(&camera.eye[k]));
        let places = if inside {
            let ahead = either(voxels.free_path(camera.eye, level));
            let halfway = add(camera.eye, scale(level, 0.5 * ahead));
            [add(halfway, scale(right, 0.12 * ahead)), halfway]
        } else {
            [middle(self.space); 2]
        };
        let is_free = |p: &V3| voxels.is_full(*p) == Some(false);
        let place = places.into_iter().find(is_free).filter(|_| self.is_room)?;
        let above = either(voxels.free_path(place, up));
        let below = either(voxels.free_path(place, scale(up, -1.0)));
        // Not so near to the ceiling that it sits in a beam.
        let rise = (0.8 * (above + below) - below).min(above - 1.5 * voxels.cell);
        Some(add(place, scale(up, rise)))
    }
}

/// `n` directions spread evenly (Fibonacci lattice).
fn sphere(n: usize) -> Vec<V3> {
    let golden = std::f32::consts::PI * (3.0 - 5f32.sqrt());
    (0..n)
        .map(|i| {
            let y = 1.0 - (2.0 * i as f32 + 1.0) / n as f32;
            let (radius, angle) = ((1.0 - y * y).sqrt(), golden * i as f32);
            [radius * angle.cos(), y, radius * angle.sin()]
        })
        .collect()
}

fn middle((lo, hi): Bounds) -> V3 {
    [0, 1, 2].map(|k| 0.5 * lo[k] + 0.5 * hi[k])
}

fn length(v: V3) -> f32 {
    dot(v, v).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Material, Object, Soup, Triangle};

    fn scene(positions: Vec<Triangle>) -> Scene {
        let n = positions.len();
        Scene {
            soup: Soup { positions, object: vec![0; n], material: vec![0; n], ..Soup::default() },
            objects: vec![Object::default()],
            materials: vec![Material::default()],
            ..Scene::default()
        }
    }

    /// The faces of an axis-aligned box.
    fn cuboid(lo: V3, hi: V3) -> Vec<Triangle> {
        let corner = |i: usize| [0, 1, 2].map(|k| if i >> k & 1 == 0 { lo[k] } else { hi[k] });
        [[0, 1, 3, 2], [4, 5, 7, 6], [0, 1, 5, 4], [2, 3, 7, 6], [0, 2, 6, 4], [1, 3, 7, 5]]
            .iter()
            .flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]])
            .map(|t| t.map(corner))
            .collect()
    }

    const UP: V3 = [0.0, 1.0, 0.0];

    #[test]
    fn a_sky_dome_does_not_blow_up_the_frame() {
        let mut positions = cuboid([-1000.0; 3], [1000.0; 3]);
        for i in 0..40 {
            let x = i as f32 * 0.1;
            positions.extend(cuboid([x, 0.0, 0.0], [x + 0.1, 1.0, 2.0]));
        }
        let (lo, hi) = framed_bounds(&scene(positions)).unwrap();
        assert!(lo[0] >= 0.0 && hi[0] <= 4.1, "{lo:?} {hi:?}");
    }

    #[test]
    fn a_statue_is_seen_from_outside_and_fits() {
        let mut positions = cuboid([-3.0, 0.0, -3.0], [3.0, 0.1, 3.0]);
        positions.extend(cuboid([-0.5, 0.1, -0.5], [0.5, 2.0, 0.5]));
        let scene = scene(positions);
        for up in [UP, [0.0, 0.0, 1.0], [-1.0, 0.0, 0.0]] {
            let defaults = Defaults::new(&scene, up);
            let Choice { value: camera, rule } = defaults.camera(1.5);
            assert_eq!(rule, "three-quarter view from outside");
            let [right, upright, forward] = axes(camera.eye, camera.target, camera.up);
            let tan = (camera.fov.to_radians() * 0.5).tan();
            let mut widest = 0f32;
            for p in scene.soup.positions.as_flattened() {
                let v = sub(*p, camera.eye);
                let (x, y) =
                    (dot(v, right) / dot(v, forward) / tan / 1.5, dot(v, upright) / dot(v, forward) / tan);
                widest = widest.max(x.abs()).max(y.abs());
            }
            assert!(widest < 1.0 && widest > 0.7, "{up:?}: {widest}");
            let light = defaults.light(&camera);
            assert_eq!(light.rule, "above and beside the scene");
            assert!(dot(light.value.position, up) > 0.0);
        }
    }

    #[test]
    fn a_room_is_seen_from_inside_with_a_lamp_under_the_ceiling() {
        let mut positions = cuboid([0.0; 3], [8.0, 3.0, 5.0]);
        positions.extend(cuboid([3.0, 0.0, 2.0], [4.0, 0.8, 3.0]));
        let scene = scene(positions);
        let defaults = Defaults::new(&scene, UP);
        let Choice { value: camera, rule } = defaults.camera(1.5);
        assert_eq!(rule, "longest view inside the room");
        let inside = |p: V3| (0..3).all(|k| p[k] > 0.1 && p[k] < [7.9, 2.9, 4.9][k]);
        assert!(inside(camera.eye), "{camera:?}");
        assert!(length(sub(camera.target, camera.eye)) > 3.0, "{camera:?}");
        let light = defaults.light(&camera);
        assert_eq!(light.rule, "under the ceiling in view");
        assert!(inside(light.value.position) && light.value.position[1] > 2.0, "{light:?}");
    }

    #[test]
    fn the_file_comes_first_and_strange_scenes_do_not_panic() {
        let mut any = scene(cuboid([0.0; 3], [1.0; 3]));
        any.lights.push(PointLight::at([7.0; 3]));
        let defaults = Defaults::new(&any, UP);
        assert_eq!(defaults.light(&defaults.camera(1.0).value).value, any.lights[0]);
        for positions in [
            Vec::new(),
            vec![[[1.0; 3]; 3]],
            vec![[[0.0; 3], [1e30, 0.0, 0.0], [0.0, 1e30, 0.0]]],
            vec![[[-3e38; 3], [3e38, 0.0, 0.0], [0.0, 3e38, 3e38]]],
        ] {
            let scene = scene(positions);
            let defaults = Defaults::new(&scene, UP);
            let camera = defaults.camera(16.0 / 9.0).value;
            let _ = defaults.light(&camera);
        }
    }
}
