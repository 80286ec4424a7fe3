//! From a plan and a scene to what is on stage: the camera and the lights, told or by rule.

use antumbra::scene::defaults::{Choice, Defaults, framed_bounds};
use antumbra::scene::{Camera, PointLight, Scene};
use anyhow::{Result, bail};

use crate::plan;
use crate::values::matches;

/// Names that an error message lists before it says "…".
const NAMES_SHOWN: usize = 8;

/// Where the picture is taken from, and what shines.
pub(crate) struct Stage {
    pub(crate) camera: Choice<Camera>,
    pub(crate) lights: Vec<Choice<PointLight>>,
}

impl Stage {
    pub(crate) fn set(scene: &Scene, view: &plan::View, lights: &plan::Lights) -> Result<Stage> {
        let defaults = Defaults::new(scene, view.up.unwrap_or([0.0, 1.0, 0.0]));
        let camera = camera(scene, view, &defaults)?;
        let lights = choose_lights(scene, lights, &camera.value, &defaults)?;
        Ok(Stage { camera, lights })
    }
}

fn camera(scene: &Scene, view: &plan::View, defaults: &Defaults<'_>) -> Result<Choice<Camera>> {
    let aspect = view.size[0] as f32 / view.size[1] as f32;
    let mut choice = match (view.index, view.eye) {
        (Some(index), _) => {
            let Some(camera) = scene.cameras.get(index) else {
                bail!("--camera-index {index}: {}", there_are(scene.cameras.len(), "camera"));
            };
            Choice { value: camera.clone(), rule: "as told" }
        }
        (None, Some(eye)) => {
            let middle = |(lo, hi): ([f32; 3], [f32; 3])| [0, 1, 2].map(|k| 0.5 * lo[k] + 0.5 * hi[k]);
            let target = view.target.or_else(|| framed_bounds(scene).map(middle)).unwrap_or_default();
            let camera = Camera { name: String::new(), eye, target, up: [0.0, 1.0, 0.0], fov: 45.0 };
            if eye == target {
                bail!("--eye: is the middle of the scene; give --target too");
            }
            Choice { value: camera, rule: "as told" }
        }
        (None, None) => defaults.camera(aspect),
    };
    let camera = &mut choice.value;
    camera.up = view.up.unwrap_or(camera.up);
    camera.fov = view.fov.unwrap_or(camera.fov);
    let numbers = [camera.eye, camera.target, camera.up];
    let usable = |fov: f32| fov > 0.0 && fov < 180.0;
    if !numbers.iter().flatten().all(|v| v.is_finite()) || !usable(camera.fov) {
        bail!(
            "the camera ({}) has numbers that cannot be meant; give --eye, --target and --fov",
            choice.rule
        );
    }
    Ok(choice)
}

fn choose_lights(
    scene: &Scene,
    plan: &plan::Lights,
    camera: &Camera,
    defaults: &Defaults<'_>,
) -> Result<Vec<Choice<PointLight>>> {
    let indices = if plan.all { (0..scene.lights.len()).collect() } else { plan.indices.clone() };
    if plan.all && indices.is_empty() {
        bail!("--all-lights: the file has no point light; give --light X,Y,Z");
    }
    let mut lights = Vec::new();
    for index in indices {
        let Some(light) = scene.lights.get(index) else {
            bail!("--light-index {index}: {}", there_are(scene.lights.len(), "point light"));
        };
        lights.push(Choice { value: light.clone(), rule: "of the file" });
    }
    // Beside lights of the file, in whatever unit, a light that is told by position should be seen.
    let brightest = lights.iter().map(|l| l.value.intensity).fold(0.0, f32::max);
    for &position in &plan.positions {
        let intensity = if brightest > 0.0 { brightest } else { 1.0 };
        lights.push(Choice { value: PointLight { intensity, ..PointLight::at(position) }, rule: "as told" });
    }
    if lights.is_empty() {
        lights.push(defaults.light(camera));
    }
    let excluded = excluded(scene, &plan.exclude)?;
    for Choice { value: light, rule } in &mut lights {
        if !light.position.iter().all(|v| v.is_finite()) {
            bail!("the light ({rule}) is not at a finite place; give --light X,Y,Z");
        }
        // The file's own say on what does not cast stays, and is added to.
        light.skip_radius = light.skip_radius.max(plan.skip_radius);
        light.excluded.extend(&excluded);
    }
    Ok(lights)
}

/// Indices of the objects that any of the patterns names. A pattern that names none is a mistake.
fn excluded(scene: &Scene, patterns: &[String]) -> Result<Vec<u32>> {
    let mut found = Vec::new();
    for pattern in patterns {
        let before = found.len();
        let objects = scene.objects.iter().enumerate();
        found.extend(objects.filter(|(_, o)| matches(pattern, &o.name)).map(|(i, _)| i as u32));
        if found.len() == before {
            let mut names: Vec<&str> = scene.objects.iter().map(|o| o.name.as_str()).collect();
            names.dedup();
            let more = if names.len() > NAMES_SHOWN { ", … (`antumbra info` lists more)" } else { "" };
            names.truncate(NAMES_SHOWN);
            bail!(
                "--exclude-object {pattern}: no object has that name; there are: {}{more}",
                names.join(", ")
            );
        }
    }
    found.sort_unstable();
    found.dedup();
    Ok(found)
}

fn there_are(n: usize, what: &str) -> String {
    match n {
        0 => format!("the scene has no {what}"),
        1 => format!("the scene has one {what}: 0"),
        n => format!("the scene has {n} {what}s: 0 to {}", n - 1),
    }
}

#[cfg(test)]
mod tests {
    use antumbra::scene::Object;

    use super::*;

    fn scene() -> Scene {
        let names = ["lamp 1", "lamp 2", "floor"];
        Scene {
            objects: names.map(|n| Object { name: n.to_owned() }).into(),
            lights: vec![PointLight { intensity: 40.0, ..PointLight::at([1.0; 3]) }],
            ..Scene::default()
        }
    }

    fn plan() -> plan::Lights {
        plan::Lights { positions: vec![], indices: vec![], all: false, skip_radius: 0.0, exclude: vec![] }
    }

    fn lights(plan: &plan::Lights) -> Result<Vec<Choice<PointLight>>> {
        let scene = scene();
        let defaults = Defaults::new(&scene, [0.0, 1.0, 0.0]);
        let camera = defaults.camera(1.0).value;
        choose_lights(&scene, plan, &camera, &defaults)
    }

    #[test]
    fn lights_of_the_file_come_first_and_exclusions_reach_all() {
        let told = plan::Lights {
            positions: vec![[2.0; 3]],
            indices: vec![0],
            exclude: vec!["lamp*".to_owned(), "lamp 1".to_owned()],
            skip_radius: 0.5,
            ..plan()
        };
        let lights = lights(&told).unwrap();
        assert_eq!(lights.len(), 2);
        assert_eq!(lights[1].value.position, [2.0; 3]);
        assert_eq!(lights[1].value.intensity, 40.0);
        assert!(lights.iter().all(|l| l.value.excluded == [0, 1] && l.value.skip_radius == 0.5));
    }

    #[test]
    fn what_is_not_there_is_named() {
        let out = plan::Lights { indices: vec![1], ..plan() };
        assert_eq!(
            lights(&out).unwrap_err().to_string(),
            "--light-index 1: the scene has one point light: 0"
        );
        let none = plan::Lights { exclude: vec!["x*".to_owned()], ..plan() };
        assert!(lights(&none).unwrap_err().to_string().contains("floor"));
    }
}
