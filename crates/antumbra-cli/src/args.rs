//! What can be typed. One table: parsing, `--help`, completions and man pages come from it.
//!
//! Values are kept as text here; `plan.rs` says what they mean and refuses what cannot be meant.

use std::path::PathBuf;

use clap::{ArgAction, Args, Parser, Subcommand, ValueHint};

const AFTER_HELP: &str = "\
Examples:
  antumbra render builtin:room -o room.png
  antumbra render sponza.glb --light -200,600,-50 --eye 1100,350,0 --target 0,300,0 -o sponza.png
  antumbra compare builtin:lattice --methods all
  antumbra info sponza.glb

Data go to stdout or to files, everything else to stderr. Exit code: 0 fine, 1 masks differ, 2 usage or error.
Coordinates are in the units of the scene, angles in degrees, times in seconds.";

const RENDER_HELP: &str = "\
Examples:
  antumbra render scene.glb -o picture.png
  antumbra render scene.glb --light-index 0 --light-index 3 --time 2.5 -o picture.exr --mask mask.npy
  antumbra render scene.ply --light 1,2,-3 --size 640x480 --triangles t.npy --samples s.npy --mask m.npy
  antumbra render scene.glb --method ptsv --debug list
  antumbra render scene.glb --method ptsv --debug level -o levels.png

With several lights each gets a mask of its own: --mask m.npy writes m.0.npy, m.1.npy, … in the order: --light-index,
then --light. The same holds for --triangles where the lights do not share their casters (--skip-radius).
`antumbra mask` on the files of --triangles and --samples gives the same mask again, bit for bit.

If no camera is given: the first camera of the file; else, in a closed room, the longest view inside it; else
three-quarters from outside, as near as all fits. If no light is given: the first point light of the file; else, in a
room, under the ceiling in view; else above and beside the scene. Far-off sky domes do not count: scenes are framed by
the 5 % to 95 % box of their vertices if the whole box is more than four times that on any axis.

The exposure follows from the picture: the median lit surface gets the same brightness in every scene.

--debug draws one number a pixel that shows how the method works: dark violet is 0, yellow the end of the
range, grey background; the picture shines through faintly. Amounts range to their 99.9th percentile (what
is above it is yellow too), levels and labels to their largest, or all to --debug-max. The range is told on
stderr and, with --json, on stdout. With several lights each gets a picture: -o p.png writes p.0.png, p.1.png, …";

const MASK_HELP: &str = "\
Example:
  antumbra mask --triangles t.npy --samples s.npy --light 1,2,-3 --method ray-cast -o mask.npy --stats s.json --repeat 5

t.npy: f32 [T,3,3], s.npy: f32 [H,W,3] or [N,3] (NaN = no sample), mask.npy: u8 of the leading shape of the samples,
0 lit, 1 shadowed, 255 no sample.";

const COMPARE_HELP: &str = "\
Example:
  antumbra compare scene.glb --light 1,2,-3 --methods ray-cast,cube-map --diff-dir differences

The reference is `oracle` (exact arithmetic, every triangle against every sample) where that is at most 1000 million pairs or it is named in --methods,
else `ray-cast` (the same leaf test behind a conservative hierarchy); --reference overrides it. `--methods all` leaves
out the oracle where it would take too long. Leaks: shadowed in the reference, lit here. Acne: the other way round.
Exit code 1 if a method that claims to be exact differs in any sample.";

const REPRODUCE_HELP: &str = "\
Example:
  antumbra reproduce --scenes ../shared/scenes -o docs/reproducing.md

Sections: frames, sorting, precise, early-accept (ray hierarchies), growth, culling (per-triangle shadow volumes), lists
(irregular z-buffer), table-2, bytes (memory), times. All together take some ten minutes; --divide 8 tries them in less than one.
Scenes that are not in the folder are replaced by built-in ones, or left out, and the page says so.";

/// Exact shadows of a point light.
#[derive(Debug, Parser)]
#[command(name = "antumbra", version, about, after_help = AFTER_HELP, max_term_width = 110)]
#[command(propagate_version = true, arg_required_else_help = true)]
pub(crate) struct Cli {
    #[command(subcommand)]
    pub(crate) verb: Verb,
}

/// What to do.
#[derive(Debug, Subcommand)]
pub(crate) enum Verb {
    /// Draw a scene with exact shadows; write the picture, the mask, and what the shadow test saw.
    #[command(after_help = RENDER_HELP)]
    Render(Box<Render>),
    /// Shadow mask of arrays: triangles and samples in, mask out.
    #[command(after_help = MASK_HELP)]
    Mask(Box<Mask>),
    /// Hold methods against a reference, sample by sample.
    #[command(after_help = COMPARE_HELP)]
    Compare(Box<Compare>),
    /// Count again what the papers claim of their methods' work and memory; write the page docs/reproducing.md.
    #[command(after_help = REPRODUCE_HELP)]
    Reproduce(Box<Reproduce>),
    /// List the shadow methods.
    Methods(List),
    /// List the built-in scenes (`builtin:NAME`).
    Scenes(List),
    /// What a scene holds: counts, bounds, lights, cameras, animation, degenerate triangles.
    Info(Info),
    /// Completions for a shell, on stdout.
    Completions {
        /// The shell.
        shell: clap_complete::Shell,
    },
    /// The manual page, on stdout.
    Man {
        /// The page of one verb.
        verb: Option<String>,
    },
}

/// `render`.
#[derive(Debug, Args)]
pub(crate) struct Render {
    #[command(flatten)]
    pub(crate) input: Input,
    #[command(flatten)]
    pub(crate) view: View,
    #[command(flatten)]
    pub(crate) lights: Lights,
    #[command(flatten)]
    pub(crate) method: Method,
    #[command(flatten)]
    pub(crate) machine: Machine,
    #[command(flatten)]
    pub(crate) report: Report,
    /// Draw one of the debug views of the method instead of the picture: .png in false colours, .exr with the numbers
    /// themselves. `--debug list` says which there are.
    #[arg(long, value_name = "NAME", help_heading = "Method")]
    pub(crate) debug: Option<String>,
    /// The number that the last colour of --debug stands for, so that several pictures can be compared [default: by the
    /// picture, see below].
    #[arg(long, value_name = "NUMBER", requires = "debug", help_heading = "Method")]
    pub(crate) debug_max: Option<String>,
    /// The picture: .png (sRGB) or .exr (linear, exposed).
    #[arg(short, long, value_name = "FILE", value_hint = ValueHint::FilePath, help_heading = "Output")]
    pub(crate) output: Option<PathBuf>,
    /// The mask: .npy (u8, 0 lit, 1 shadowed, 255 no sample) or .png.
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath, help_heading = "Output")]
    pub(crate) mask: Option<PathBuf>,
    /// The points that were asked: .npy, f32 [H,W,3], NaN = no sample.
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath, help_heading = "Output")]
    pub(crate) samples: Option<PathBuf>,
    /// The triangles that cast: .npy, f32 [T,3,3].
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath, help_heading = "Output")]
    pub(crate) triangles: Option<PathBuf>,
}

/// `mask`.
#[derive(Debug, Args)]
pub(crate) struct Mask {
    /// Triangles: .npy, f32 [T,3,3].
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub(crate) triangles: PathBuf,
    /// Sample points: .npy, f32 [H,W,3] or [N,3], NaN = no sample.
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub(crate) samples: PathBuf,
    /// Position of the light.
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true)]
    pub(crate) light: String,
    /// Triangles nearer than this to the light do not cast.
    #[arg(long, value_name = "R", default_value = "0", allow_hyphen_values = true)]
    pub(crate) skip_radius: String,
    #[command(flatten)]
    pub(crate) method: Method,
    #[command(flatten)]
    pub(crate) machine: Machine,
    #[command(flatten)]
    pub(crate) report: Report,
    /// The mask: .npy, or .png where the samples are a picture.
    #[arg(short, long, value_name = "FILE", value_hint = ValueHint::FilePath, help_heading = "Output")]
    pub(crate) output: Option<PathBuf>,
    /// Run N times (scratch memory is reused); the statistics give all times and their median.
    #[arg(long, value_name = "N", default_value = "1")]
    pub(crate) repeat: String,
}

/// `compare`.
#[derive(Debug, Args)]
pub(crate) struct Compare {
    #[command(flatten)]
    pub(crate) input: Input,
    #[command(flatten)]
    pub(crate) view: View,
    #[command(flatten)]
    pub(crate) lights: Lights,
    #[command(flatten)]
    pub(crate) machine: Machine,
    #[command(flatten)]
    pub(crate) talk: Talk,
    /// `all`, or names with commas between them (`antumbra methods` lists them).
    #[arg(long, value_name = "NAMES", default_value = "all")]
    pub(crate) methods: String,
    /// The method that is right by definition; see below for the default.
    #[arg(long, value_name = "NAME")]
    pub(crate) reference: Option<String>,
    /// Write a PNG a method into this folder: the mask in greys, leaks red, acne blue.
    #[arg(long, value_name = "DIR", value_hint = ValueHint::DirPath)]
    pub(crate) diff_dir: Option<PathBuf>,
}

/// `reproduce`.
#[derive(Debug, Args)]
pub(crate) struct Reproduce {
    /// The folder of scenes [default: the environment's ANTUMBRA_SCENES].
    #[arg(long, value_name = "DIR", value_hint = ValueHint::DirPath)]
    pub(crate) scenes: Option<PathBuf>,
    /// Only these sections, with commas between them; see below.
    #[arg(long, value_name = "SECTIONS", value_delimiter = ',')]
    pub(crate) only: Vec<String>,
    /// Divide width and height of all pictures: a trial, and the page says so.
    #[arg(long, value_name = "N", default_value = "1")]
    pub(crate) divide: String,
    #[command(flatten)]
    pub(crate) machine: Machine,
    /// Nothing on stderr but errors.
    #[arg(short, long)]
    pub(crate) quiet: bool,
    /// The page: .md [default: stdout].
    #[arg(short, long, value_name = "FILE", value_hint = ValueHint::FilePath, help_heading = "Output")]
    pub(crate) output: Option<PathBuf>,
}

/// `methods`, `scenes`.
#[derive(Debug, Args)]
pub(crate) struct List {
    /// For machines.
    #[arg(long)]
    pub(crate) json: bool,
}

/// `info`.
#[derive(Debug, Args)]
pub(crate) struct Info {
    #[command(flatten)]
    pub(crate) input: Input,
    /// For machines; lists everything.
    #[arg(long)]
    pub(crate) json: bool,
    /// Names of each kind to print as text.
    #[arg(long, value_name = "N", default_value = "10")]
    pub(crate) first: usize,
}

/// Which scene.
#[derive(Debug, Args)]
pub(crate) struct Input {
    /// A .glb .gltf .obj .ply .stl .aff file, .npy triangles, or builtin:NAME (`antumbra scenes` lists them).
    #[arg(value_name = "SCENE", value_hint = ValueHint::FilePath)]
    pub(crate) scene: String,
    /// The moment of an animated scene, in seconds.
    #[arg(long, value_name = "SECONDS", allow_hyphen_values = true)]
    pub(crate) time: Option<String>,
}

/// What the eye sees.
#[derive(Debug, Args)]
#[command(next_help_heading = "Camera")]
pub(crate) struct View {
    /// Where the eye is.
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true, conflicts_with = "camera_index")]
    pub(crate) eye: Option<String>,
    /// What it looks at; the middle of the scene if only --eye is given.
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true, conflicts_with = "camera_index")]
    pub(crate) target: Option<String>,
    /// What is up in the picture [default: that of the camera, else 0,1,0].
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true)]
    pub(crate) up: Option<String>,
    /// Vertical field of view in degrees [default: that of the camera, else 45].
    #[arg(long, value_name = "DEGREES", allow_hyphen_values = true)]
    pub(crate) fov: Option<String>,
    /// A camera of the file, from 0.
    #[arg(long, value_name = "N")]
    pub(crate) camera_index: Option<usize>,
    /// Width and height in pixels.
    #[arg(long, value_name = "WxH", default_value = "1920x1080")]
    pub(crate) size: String,
}

/// What shines, and what does not cast.
#[derive(Debug, Args)]
#[command(next_help_heading = "Lights")]
pub(crate) struct Lights {
    /// Position of a light; may be given several times.
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true, action = ArgAction::Append)]
    pub(crate) light: Vec<String>,
    /// A point light of the file, from 0; may be given several times.
    #[arg(long, value_name = "N", action = ArgAction::Append)]
    pub(crate) light_index: Vec<usize>,
    /// All point lights of the file.
    #[arg(long, conflicts_with = "light_index")]
    pub(crate) all_lights: bool,
    /// Triangles nearer than this to a light do not cast its shadows (lamps sit in lamp glass).
    #[arg(long, value_name = "R", default_value = "0", allow_hyphen_values = true)]
    pub(crate) skip_radius: String,
    /// Objects of this name (* and ? stand for anything) do not cast; may be given several times.
    #[arg(long, value_name = "NAME", action = ArgAction::Append)]
    pub(crate) exclude_object: Vec<String>,
}

/// Who answers.
#[derive(Debug, Args)]
#[command(next_help_heading = "Method")]
pub(crate) struct Method {
    /// The shadow method (`antumbra methods` lists them).
    #[arg(long, value_name = "NAME", default_value = "auto")]
    pub(crate) method: String,
    /// Fill the work counters of the statistics, even those that cost time.
    #[arg(long)]
    pub(crate) count: bool,
}

/// On what.
#[derive(Debug, Args)]
#[command(next_help_heading = "Machine")]
pub(crate) struct Machine {
    /// cpu or gpu.
    #[arg(long, value_name = "NAME", default_value = "cpu")]
    pub(crate) backend: String,
    /// Threads [default: one a core].
    #[arg(long, value_name = "N")]
    pub(crate) threads: Option<String>,
    /// Instruction set of the kernels: auto, scalar, sse2, sse4.2, avx2, avx512, neon, simd128.
    #[arg(long, value_name = "LEVEL", default_value = "auto")]
    pub(crate) isa: String,
}

/// What is told.
#[derive(Debug, Args)]
#[command(next_help_heading = "Output")]
pub(crate) struct Report {
    #[command(flatten)]
    pub(crate) talk: Talk,
    /// The statistics as JSON.
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub(crate) stats: Option<PathBuf>,
}

/// How much is told.
#[derive(Debug, Args)]
#[command(next_help_heading = "Output")]
pub(crate) struct Talk {
    /// Print the results as JSON on stdout.
    #[arg(long)]
    pub(crate) json: bool,
    /// Nothing on stderr but errors.
    #[arg(short, long)]
    pub(crate) quiet: bool,
}
