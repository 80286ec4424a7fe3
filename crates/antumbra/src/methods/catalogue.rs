//! The list of methods: what `antumbra methods` prints, and how a name becomes a method.

use super::{
    Cptsv, Cssv, CubeMap, Dpsv, DpsvQuery, DualParaboloid, LightTiles, Method, Ofts, Oracle, Ptsv, RayCast,
    RayHierarchy, RayHierarchyOptions,
};
use crate::Isa;

/// What a user wants to know before choosing.
#[derive(Clone, Copy, Debug)]
pub struct MethodInfo {
    /// The name on the command line.
    pub name: &'static str,
    /// Other spellings, e.g. those of the comparison framework of Kobrtek et al. 2021.
    pub aliases: &'static [&'static str],
    /// Authors, year, section.
    pub source: &'static str,
    /// True if the mask equals exact arithmetic in every sample.
    pub exact: bool,
    /// One sentence: how it finds blockers.
    pub idea: &'static str,
    /// Cost in triangles T and samples N.
    pub cost: &'static str,
}

/// All methods, the order of `--methods all`.
pub const CATALOGUE: &[MethodInfo] = &[
    MethodInfo {
        name: "oracle",
        aliases: &["brute-force"],
        source: "the definition itself",
        exact: true,
        idea: "tests every triangle against every sample in exact arithmetic",
        cost: "O(T N)",
    },
    MethodInfo {
        name: "ray-cast",
        aliases: &["raytracing", "rtx", "rt"],
        source: "Kobrtek et al. 2021, section 2.6; Lauterbach et al. 2009; Boulos et al. 2006",
        exact: true,
        idea: "walks packets of rays from the light through a bounding volume hierarchy that is built every frame",
        cost: "build O(T), trace O(N log T) expected",
    },
    MethodInfo {
        name: "light-tiles",
        aliases: &[],
        source: "ours; after irregular z-buffers (Johnson et al. 2005) and tiled rasterisation",
        exact: true,
        idea: "gathers samples in tiles around the light, streams the triangles through the tiles, nothing sorted or kept",
        cost: "samples O(N), triangles O(T + touched tiles), then leaves times the triangles near them",
    },
    MethodInfo {
        name: "ofts",
        aliases: &["fts", "irregular-z-buffer"],
        source: "Kobrtek et al. 2021, sections 2.3 and 3.4; Wyman et al. 2015",
        exact: true,
        idea: "sorts samples into cells of directions around the light and rasterises triangles into the cells",
        cost: "lists O(N), traversal O(touched cells and their samples)",
    },
    MethodInfo {
        name: "cube-map",
        aliases: &["cubeshadowmapping", "cube-shadow-map"],
        source: "Williams 1978; Gerasimov 2004; Kobrtek et al. 2021's framework",
        exact: false,
        idea: "keeps the nearest depth of each texel of six faces and compares",
        cost: "draw O(T + texels), look up O(N)",
    },
    MethodInfo {
        name: "dual-paraboloid",
        aliases: &["dpsm"],
        source: "Brabec et al. 2002; Kobrtek et al. 2021's framework",
        exact: false,
        idea: "keeps the nearest distance of each texel of two paraboloids and compares",
        cost: "draw O(T + texels), look up O(N)",
    },
    MethodInfo {
        name: "dpsv-hybrid",
        aliases: &["dpsv"],
        source: "Mora et al. 2016; Gerhards et al. 2015; Kobrtek et al. 2021, section 3.3",
        exact: true,
        idea: "asks a ternary tree over the planes of shadow volumes, with a small stack that overflows into the stackless walk",
        cost: "build O(T log T), query O(N log T) expected, O(T N) at worst",
    },
    MethodInfo {
        name: "dpsv-stack",
        aliases: &[],
        source: "Mora et al. 2016; Gerhards et al. 2015; Kobrtek et al. 2021, section 3.3",
        exact: true,
        idea: "asks a ternary tree over the planes of shadow volumes, with a stack",
        cost: "build O(T log T), query O(N log T) expected, O(T N) at worst",
    },
    MethodInfo {
        name: "dpsv-stackless",
        aliases: &[],
        source: "Mora et al. 2016; Gerhards et al. 2015; Kobrtek et al. 2021, section 3.3",
        exact: true,
        idea: "asks a ternary tree over the planes of shadow volumes, with the way back stored in the tree",
        cost: "build O(T log T), query O(N log T) expected, O(T N) at worst",
    },
    MethodInfo {
        name: "ptsv",
        aliases: &["sintorn"],
        source: "Sintorn, Olsson, Assarsson 2011",
        exact: true,
        idea: "rasterises each triangle's shadow frustum into a pyramid over the picture, whole tiles at once",
        cost: "build O(N + T), walk O(T log N + length of shadow outlines in tiles)",
    },
    MethodInfo {
        name: "cptsv",
        aliases: &["sintorn2"],
        source: "Sintorn, Kämpe, Olsson, Assarsson 2014; Kobrtek et al. 2021, section 2.2",
        exact: true,
        idea: "as ptsv, over a tree of view sample clusters: tiles cut into depth slices",
        cost: "build O(N + T), walk O(T log C + outlines in clusters), C clusters",
    },
    MethodInfo {
        name: "cssv",
        aliases: &["zfail", "shadow-volumes", "stencil"],
        source: "Kobrtek et al. 2021, section 3.1; Kim, Kim, Turk 2008; Milet et al. 2014",
        exact: true,
        idea: "counts the shadow volumes around a sample by the faces that its eye ray crosses beyond it (z-fail)",
        cost: "adjacency O(T), silhouette O(T), count O(faces log N + their outlines in samples)",
    },
    MethodInfo {
        name: "zpass",
        aliases: &["cssv-zpass"],
        source: "Crow 1977; Kobrtek et al. 2021, section 3.1",
        exact: true,
        idea: "as cssv, but counts the faces between eye and sample and the volumes around the eye (z-pass)",
        cost: "adjacency O(T), silhouette O(T), count O(faces log N + their outlines in samples)",
    },
    MethodInfo {
        name: "rh-spheres",
        aliases: &[],
        source: "Olsson, Assarsson 2011, table 1 (Spheres)",
        exact: true,
        idea: "streams triangles through a tree of cones over the rays in screen order; cone against bounding sphere",
        cost: "build O(N), traverse O(T log N) plus crossings",
    },
    MethodInfo {
        name: "rh-spheres-sorted",
        aliases: &[],
        source: "Olsson, Assarsson 2011, table 1 (SpheresSorted)",
        exact: true,
        idea: "the same over rays sorted by direction",
        cost: "build O(N), traverse O(T log N) plus crossings",
    },
    MethodInfo {
        name: "rh-precise",
        aliases: &[],
        source: "Olsson, Assarsson 2011, section 3.2 (Precise)",
        exact: true,
        idea: "streams triangles through a tree of cones over the rays in screen order; cone against triangle",
        cost: "build O(N), traverse O(T log N) plus crossings",
    },
    MethodInfo {
        name: "rh-precise-sorted",
        aliases: &[],
        source: "Olsson, Assarsson 2011, section 3.5 (PreciseSorted)",
        exact: true,
        idea: "the same over rays sorted by direction",
        cost: "build O(N), traverse O(T log N) plus crossings",
    },
    MethodInfo {
        name: "rh-precise-sea",
        aliases: &[],
        source: "Olsson, Assarsson 2011, section 3.3 (PreciseSEA)",
        exact: true,
        idea: "sorted rays; a node that one triangle covers is shadowed at once and never visited again",
        cost: "build O(N), traverse O(T log N) plus crossings",
    },
    MethodInfo {
        name: "rh-precise-eatp",
        aliases: &[],
        source: "Olsson, Assarsson 2011, section 3.4 (PreciseEATP)",
        exact: true,
        idea: "rays in screen order, early accept; large blockers go first, and the rays they shadow leave the tree",
        cost: "build O(N), traverse O(T log N) plus crossings",
    },
    MethodInfo {
        name: "rh-precise-seatp",
        aliases: &["rh", "ray-hierarchy"],
        source: "Olsson, Assarsson 2011, section 3.4 (PreciseSEATP)",
        exact: true,
        idea: "sorted rays, early accept; large blockers go first, and the rays they shadow leave the tree",
        cost: "build O(N), traverse O(T log N) plus crossings",
    },
    MethodInfo {
        name: "rh-leaf-wald",
        aliases: &[],
        source: "Olsson, Assarsson 2011, section 4.1; Wald 2004",
        exact: false,
        idea: "rh-precise-sorted with Wald's projected leaf test in f32: what inexact leaves cost",
        cost: "build O(N), traverse O(T log N) plus crossings",
    },
    MethodInfo {
        name: "rh-leaf-moller-trumbore",
        aliases: &[],
        source: "Olsson, Assarsson 2011, section 4.1; Möller, Trumbore 1997",
        exact: false,
        idea: "rh-precise-sorted with the leaf test of Möller and Trumbore in f32: what inexact leaves cost",
        cost: "build O(N), traverse O(T log N) plus crossings",
    },
];

/// Options that all methods share.
#[derive(Clone, Debug, Default)]
pub struct Options {
    /// Instruction set of the kernels.
    pub isa: Isa,
    /// Fill the counters that cost time.
    pub count: bool,
}

/// A method name that nobody knows.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("unknown method '{name}'; known are: {known}")]
pub struct UnknownMethod {
    name: String,
    known: String,
}

/// What `auto` is, whatever the work: for many samples or few, for triangles that move or stay, for one light or many. It is the
/// fastest exact method here even against a `ray-cast` whose hierarchy was kept and costs nothing, in all but a few of the
/// measured cases (`docs/performance.md`, "What auto picks").
const AUTO: &str = "light-tiles";

/// Finds a method by name or alias. `auto` is `light-tiles`.
///
/// # Errors
/// [`UnknownMethod`] lists the names there are.
pub fn info(name: &str) -> Result<&'static MethodInfo, UnknownMethod> {
    let lower = name.to_ascii_lowercase();
    let lower = if lower == "auto" { AUTO.to_owned() } else { lower };
    CATALOGUE.iter().find(|m| m.name == lower || m.aliases.contains(&lower.as_str())).ok_or_else(|| {
        UnknownMethod {
            name: name.to_owned(),
            known: CATALOGUE.iter().map(|m| m.name).collect::<Vec<_>>().join(", "),
        }
    })
}

/// Makes a method ready to run.
///
/// # Errors
/// [`UnknownMethod`] lists the names there are.
pub fn create(name: &str, options: &Options) -> Result<Box<dyn Method>, UnknownMethod> {
    let method: Box<dyn Method> = match info(name)?.name {
        "oracle" => Box::new(Oracle),
        "ray-cast" => Box::new(RayCast::new(options)),
        "light-tiles" => Box::new(LightTiles::new(options)),
        "ofts" => Box::new(Ofts::new(options)),
        "cube-map" => Box::new(CubeMap::new(options)),
        "dual-paraboloid" => Box::new(DualParaboloid::new(options)),
        "dpsv-hybrid" => Box::new(Dpsv::new(options, DpsvQuery::HYBRID)),
        "dpsv-stack" => Box::new(Dpsv::new(options, DpsvQuery::Stack)),
        "dpsv-stackless" => Box::new(Dpsv::new(options, DpsvQuery::Stackless)),
        "ptsv" => Box::new(Ptsv::new(options)),
        "cptsv" => Box::new(Cptsv::new(options)),
        "cssv" => Box::new(Cssv::new(options)),
        "zpass" => Box::new(Cssv::z_pass(options)),
        name if name.starts_with("rh-") => {
            let variant = RayHierarchyOptions::named(name, options).unwrap_or_default();
            Box::new(RayHierarchy::new(name, variant))
        }
        other => unreachable!("{other} is in the catalogue"),
    };
    Ok(method)
}
