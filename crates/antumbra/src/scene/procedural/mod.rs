//! Seeded scenes made in code: pictures that need no file, and one tiny scene for each way in which shadow methods
//! have been seen to fail.
//!
//! A scene is asked for by name, with parameters behind a question mark: `room`, `hairball?size=20000&seed=3`. The
//! same spec gives the same bits on every platform and with any number of threads.

mod atrium;
mod build;
mod city;
mod crowd;
mod failure;
mod forest;
mod hairball;
mod math;
mod room;
mod shapes;
mod statue;
#[cfg(test)]
mod tests;

use build::Builder;

use super::Scene;

/// A whole number that a scene can be asked for with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Parameter {
    /// As in `size=20000`.
    pub name: &'static str,
    /// What it does.
    pub summary: &'static str,
    /// Its value if it is not given.
    pub default: u64,
    /// Smallest and largest value.
    pub range: [u64; 2],
}

/// What is known about a scene before it is made.
#[derive(Clone, Copy, Debug)]
pub struct BuiltinInfo {
    /// What it is asked for by.
    pub name: &'static str,
    /// What it shows, in one line.
    pub summary: &'static str,
    /// About how many triangles it has if no parameter is given.
    pub default_triangles: usize,
    /// Whether it moves: see [`time_span`].
    pub animated: bool,
    /// Whether it is a tiny scene that provokes one kind of failure.
    pub failure_mode: bool,
    /// What may follow its name.
    pub parameters: &'static [Parameter],
    make: fn(&Arguments, &mut Builder),
}

/// Values for the parameters of a scene, and the moment.
struct Arguments {
    seed: u64,
    size: usize,
    time: f64,
}

const SEED: Parameter =
    Parameter { name: "seed", summary: "another one of the same kind", default: 1, range: [0, u64::MAX] };

const fn size(default: u64) -> Parameter {
    Parameter { name: "size", summary: "about how many triangles", default, range: [1, 400_000_000] }
}

/// First and last second of the scenes that move.
const SPAN: [f32; 2] = [0.0, 10.0];

const fn show(
    name: &'static str,
    default_triangles: usize,
    make: fn(&Arguments, &mut Builder),
    parameters: &'static [Parameter],
    summary: &'static str,
) -> BuiltinInfo {
    BuiltinInfo { name, summary, default_triangles, animated: false, failure_mode: false, parameters, make }
}

const fn failure(
    name: &'static str,
    default_triangles: usize,
    make: fn(&Arguments, &mut Builder),
    summary: &'static str,
) -> BuiltinInfo {
    BuiltinInfo { failure_mode: true, ..show(name, default_triangles, make, &[SEED], summary) }
}

/// Every scene that [`builtin`] makes.
pub const BUILTINS: &[BuiltinInfo] = &[
    show("room", 22_400, room::room, &[SEED], "a furnished room around a lattice lantern"),
    show(
        "hairball",
        2_880_006,
        hairball::hairball,
        &[SEED, size(2_880_006)],
        "a ball of 12,000 thin hairs between two walls",
    ),
    show(
        "city",
        279_000,
        city::city,
        &[SEED, size(279_000)],
        "blocks of houses with windows, a light above the square",
    ),
    show(
        "atrium",
        279_000,
        atrium::atrium,
        &[SEED, size(279_000)],
        "an ornate courtyard: columns, arches, cloth",
    ),
    show("statue", 1_090_000, statue::statue, &[SEED, size(1_090_000)], "a dense veiled figure in a niche"),
    show("forest", 200_000, forest::forest, &[SEED, size(200_000)], "trees with alpha-tested leaves"),
    BuiltinInfo {
        animated: true,
        ..show(
            "crowd",
            70_000,
            crowd::crowd,
            &[SEED, size(70_000)],
            "people who walk across a square at night",
        )
    },
    failure("empty", 0, failure::simple::empty, "no triangles at all"),
    failure("single", 3, failure::simple::single, "one triangle over a ground"),
    failure("fan", 3_970, failure::topology::fan, "a finely tessellated closed sphere over a plane"),
    failure(
        "fan-rotated",
        3_970,
        failure::topology::fan_rotated,
        "the same with the corners of each triangle rotated",
    ),
    failure(
        "lattice",
        260,
        failure::topology::lattice,
        "cubes, light and ground on the integer lattice: ties galore",
    ),
    failure(
        "seams",
        880,
        failure::topology::seams,
        "a lattice room about the light, samples where the faces of a cube map meet",
    ),
    failure(
        "interpenetrating",
        662,
        failure::topology::interpenetrating,
        "300 triangles through one another, a ball through the ground",
    ),
    failure("edge-fan", 22, failure::topology::edge_fan, "edges of 3, 5 and 12 triangles"),
    failure("layers", 3_602, failure::topology::layers, "300 closed plates one over the other"),
    failure("cracks", 204, failure::topology::cracks, "T-junctions and a crack of a hundred-thousandth"),
    failure(
        "degenerate",
        50,
        failure::numbers::degenerate,
        "zero-area, collinear, duplicate, huge and tiny triangles",
    ),
    failure("offset", 363, failure::numbers::offset, "a scene a million units away, where f32 is coarse"),
    failure("depth-range", 255, failure::numbers::depth_range, "casters from 0.1 to 100,000 from the light"),
    failure(
        "slivers",
        3_002,
        failure::numbers::slivers,
        "3,000 triangles up to a million times longer than wide",
    ),
    failure("light-in-plane", 19, failure::lights::in_plane, "the light exactly in the planes of triangles"),
    failure(
        "light-on-vertex",
        20,
        failure::lights::on_vertex,
        "the light exactly on a corner of five triangles",
    ),
    failure("light-inside", 1_200, failure::lights::inside, "light and eye inside a closed ball"),
    failure("light-at-eye", 15, failure::lights::at_eye, "the light exactly where the eye is"),
    failure("light-behind-eye", 16, failure::lights::behind_eye, "the light, and a caster, behind the eye"),
    failure("eye-in-shadow", 29, failure::lights::eye_in_shadow, "the eye inside of shadow volumes"),
    failure("near-caster", 16, failure::lights::near_caster, "a caster millimetres before the eye"),
    failure("far-light", 15, failure::lights::far, "the light 10,000 scene sizes away"),
    failure("close-large", 17, failure::lights::close_large, "large triangles that nearly touch the light"),
    failure("one-cell", 215, failure::lights::one_cell, "all samples in one tiny solid angle"),
    failure(
        "two-clumps",
        1_060,
        failure::lights::two_clumps,
        "two clumps of samples, 1e-4 apart as seen from the light",
    ),
    failure("tiny", 17_700, failure::density::tiny, "17,000 triangles over few pixels"),
];

/// Why a spec names no scene; the message says what would be right.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum UnknownScene {
    /// No scene has this name.
    #[error("no built-in scene is called `{name}`; there are {}", names())]
    Name {
        /// The name that was asked for.
        name: String,
    },
    /// The scene has no such parameter.
    #[error("scene `{scene}` has no parameter `{parameter}`; it has {known}")]
    Parameter {
        /// The scene.
        scene: &'static str,
        /// The parameter that was given.
        parameter: String,
        /// Those that it has.
        known: String,
    },
    /// The value is not a number, or out of range.
    #[error("scene `{scene}`: `{parameter}={value}` is not a whole number from {} to {}", range[0], range[1])]
    Value {
        /// The scene.
        scene: &'static str,
        /// The parameter.
        parameter: &'static str,
        /// The value that was given.
        value: String,
        /// Smallest and largest value.
        range: [u64; 2],
    },
}

fn names() -> String {
    BUILTINS.iter().map(|b| b.name).collect::<Vec<_>>().join(", ")
}

/// Finds the scene of a spec and reads its parameters.
fn parse(spec: &str) -> Result<(&'static BuiltinInfo, Arguments), UnknownScene> {
    let (name, list) = spec.split_once('?').unwrap_or((spec, ""));
    let info =
        BUILTINS.iter().find(|b| b.name == name).ok_or_else(|| UnknownScene::Name { name: name.into() })?;
    let default = |name: &str| info.parameters.iter().find(|p| p.name == name).map_or(0, |p| p.default);
    let mut arguments = Arguments { seed: default("seed"), size: default("size") as usize, time: 0.0 };
    for pair in list.split('&').filter(|pair| !pair.is_empty()) {
        let (name, text) = pair.split_once('=').unwrap_or((pair, ""));
        let parameter =
            info.parameters.iter().find(|p| p.name == name).ok_or_else(|| UnknownScene::Parameter {
                scene: info.name,
                parameter: name.into(),
                known: info
                    .parameters
                    .iter()
                    .map(|p| format!("`{}` ({})", p.name, p.summary))
                    .collect::<Vec<_>>()
                    .join(", "),
            })?;
        let range = parameter.range;
        let value = text.parse().ok().filter(|v| (range[0]..=range[1]).contains(v)).ok_or_else(|| {
            UnknownScene::Value { scene: info.name, parameter: parameter.name, value: text.into(), range }
        })?;
        match parameter.name {
            "seed" => arguments.seed = value,
            _ => arguments.size = value as usize,
        }
    }
    Ok((info, arguments))
}

/// Makes the scene of a spec such as `room` or `city?seed=3&size=20000`: what follows `builtin:` on the command line.
///
/// `time` is in seconds, clamped to [`time_span`]; scenes that do not move ignore it.
///
/// # Errors
/// [`UnknownScene`] lists the names or parameters that there are.
pub fn builtin(spec: &str, time: Option<f32>) -> Result<Scene, UnknownScene> {
    let (info, mut arguments) = parse(spec)?;
    let moment = time.filter(|t| !t.is_nan()).unwrap_or(SPAN[0]);
    arguments.time = f64::from(moment.clamp(SPAN[0], SPAN[1]));
    let mut builder = Builder::new();
    (info.make)(&arguments, &mut builder);
    Ok(builder.finish(info.name))
}

/// First and last moment in seconds of a scene that moves; `None` for one that does not, or that there is not.
pub fn time_span(spec: &str) -> Option<[f32; 2]> {
    parse(spec).ok().filter(|(info, _)| info.animated).map(|_| SPAN)
}
