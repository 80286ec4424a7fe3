//! The list of methods: what `antumbra methods` prints, and how a name becomes a method.

use super::{Method, Oracle, RayCast, RayHierarchy, RayHierarchyOptions};
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

/// Finds a method by name or alias. `auto` is resolved to the method that it picks.
///
/// # Errors
/// [`UnknownMethod`] lists the names there are.
pub fn info(name: &str) -> Result<&'static MethodInfo, UnknownMethod> {
    let lower = name.to_ascii_lowercase();
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
        name if name.starts_with("rh-") => {
            let variant = RayHierarchyOptions::named(name, options).unwrap_or_default();
            Box::new(RayHierarchy::new(name, variant))
        }
        other => unreachable!("{other} is in the catalogue"),
    };
    Ok(method)
}
