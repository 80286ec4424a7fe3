//! What the arguments mean: everything that can be checked before a file is opened is checked here.

use std::path::{Path, PathBuf};

use antumbra::Isa;
use antumbra::methods::{DebugView, MethodInfo, Options, create, info};
use anyhow::{Result, bail};

use crate::args;
use crate::values;

/// Where a scene comes from.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Source {
    /// What follows `builtin:`.
    Builtin(String),
    File(PathBuf),
}

/// A scene at a moment.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Input {
    pub(crate) source: Source,
    pub(crate) time: Option<f32>,
}

/// The camera as far as it is told; the rest comes from the scene.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct View {
    pub(crate) eye: Option<[f32; 3]>,
    pub(crate) target: Option<[f32; 3]>,
    pub(crate) up: Option<[f32; 3]>,
    pub(crate) fov: Option<f32>,
    pub(crate) index: Option<usize>,
    pub(crate) size: [usize; 2],
}

/// The lights as far as they are told.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Lights {
    pub(crate) positions: Vec<[f32; 3]>,
    pub(crate) indices: Vec<usize>,
    pub(crate) all: bool,
    pub(crate) skip_radius: f32,
    pub(crate) exclude: Vec<String>,
}

/// Threads and instruction set.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Machine {
    pub(crate) threads: Option<usize>,
    pub(crate) isa: Isa,
}

/// A method and its options.
#[derive(Clone, Debug)]
pub(crate) struct Method {
    pub(crate) info: &'static MethodInfo,
    pub(crate) options: Options,
}

/// How the result is told.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Talk {
    pub(crate) json: bool,
    pub(crate) quiet: bool,
}

/// `render`.
#[derive(Clone, Debug)]
pub(crate) struct Render {
    pub(crate) input: Input,
    pub(crate) view: View,
    pub(crate) lights: Lights,
    pub(crate) method: Method,
    /// Drawn instead of the picture.
    pub(crate) debug: Option<DebugView>,
    /// Where its range ends; `None` for the rule.
    pub(crate) debug_max: Option<f32>,
    pub(crate) talk: Talk,
    pub(crate) picture: Option<PathBuf>,
    pub(crate) mask: Option<PathBuf>,
    pub(crate) samples: Option<PathBuf>,
    pub(crate) triangles: Option<PathBuf>,
    pub(crate) stats: Option<PathBuf>,
}

/// `mask`.
#[derive(Clone, Debug)]
pub(crate) struct Mask {
    pub(crate) triangles: PathBuf,
    pub(crate) samples: PathBuf,
    pub(crate) light: [f32; 3],
    pub(crate) skip_radius: f32,
    pub(crate) method: Method,
    pub(crate) talk: Talk,
    pub(crate) output: Option<PathBuf>,
    pub(crate) stats: Option<PathBuf>,
    pub(crate) repeat: usize,
}

/// `compare`.
#[derive(Clone, Debug)]
pub(crate) struct Compare {
    pub(crate) input: Input,
    pub(crate) view: View,
    pub(crate) lights: Lights,
    pub(crate) options: Options,
    pub(crate) talk: Talk,
    /// `None` for all.
    pub(crate) methods: Option<Vec<&'static MethodInfo>>,
    /// `None` for the rule.
    pub(crate) reference: Option<&'static MethodInfo>,
    pub(crate) diff_dir: Option<PathBuf>,
}

/// `reproduce`.
#[derive(Clone, Debug)]
pub(crate) struct Reproduce {
    pub(crate) scenes: Option<PathBuf>,
    /// Empty for all sections.
    pub(crate) only: Vec<String>,
    pub(crate) divide: usize,
    pub(crate) isa: Isa,
    pub(crate) quiet: bool,
    pub(crate) output: Option<PathBuf>,
}

impl Machine {
    pub(crate) fn new(args: &args::Machine) -> Result<Machine> {
        match args.backend.as_str() {
            "cpu" => {}
            "gpu" => bail!("--backend gpu: not built into this version; use --backend cpu"),
            other => bail!("--backend {other}: unknown backend; use --backend cpu"),
        }
        let threads = args.threads.as_deref().map(|n| values::count("--threads", n, 1024)).transpose()?;
        let isa = Isa::parse(&args.isa).map_err(|e| anyhow::anyhow!("--isa {}: {e}", args.isa))?;
        Ok(Machine { threads, isa })
    }
}

impl Input {
    pub(crate) fn new(args: &args::Input) -> Result<Input> {
        let source = match args.scene.strip_prefix("builtin:") {
            Some(name) => Source::Builtin(name.to_owned()),
            None => Source::File(PathBuf::from(&args.scene)),
        };
        Ok(Input { source, time: args.time.as_deref().map(|t| values::number("--time", t)).transpose()? })
    }
}

impl View {
    fn new(args: &args::View) -> Result<View> {
        let point = |option, text: &Option<String>| {
            text.as_deref().map(|text| values::point(option, text)).transpose()
        };
        let view = View {
            eye: point("--eye", &args.eye)?,
            target: point("--target", &args.target)?,
            up: args.up.as_deref().map(|text| values::direction("--up", text)).transpose()?,
            fov: args.fov.as_deref().map(|text| values::angle("--fov", text)).transpose()?,
            index: args.camera_index,
            size: values::size(&args.size)?,
        };
        if view.target.is_some() && view.eye.is_none() {
            bail!("--target: needs --eye too");
        }
        if view.eye.is_some() && view.eye == view.target {
            bail!("--eye and --target are the same point: there is no direction to look in");
        }
        Ok(view)
    }
}

impl Lights {
    fn new(args: &args::Lights) -> Result<Lights> {
        Ok(Lights {
            positions: args.light.iter().map(|text| values::point("--light", text)).collect::<Result<_>>()?,
            indices: args.light_index.clone(),
            all: args.all_lights,
            skip_radius: values::radius("--skip-radius", &args.skip_radius)?,
            exclude: args.exclude_object.clone(),
        })
    }
}

impl Method {
    pub(crate) fn new(args: &args::Method, isa: Isa) -> Result<Method> {
        let info = method("--method", &args.method)?;
        Ok(Method { info, options: Options { isa, count: args.count } })
    }
}

impl Talk {
    fn new(args: &args::Talk) -> Talk {
        Talk { json: args.json, quiet: args.quiet }
    }
}

impl Render {
    pub(crate) fn new(args: &args::Render, machine: &Machine) -> Result<Render> {
        let method = Method::new(&args.method, machine.isa)?;
        let plan = Render {
            input: Input::new(&args.input)?,
            view: View::new(&args.view)?,
            lights: Lights::new(&args.lights)?,
            debug: args.debug.as_deref().map(|name| debug_view(&method, name)).transpose()?,
            debug_max: args.debug_max.as_deref().map(|n| values::positive("--debug-max", n)).transpose()?,
            method,
            talk: Talk::new(&args.report.talk),
            picture: output("-o", &args.output, &["png", "exr"])?,
            mask: output("--mask", &args.mask, &["npy", "png"])?,
            samples: output("--samples", &args.samples, &["npy"])?,
            triangles: output("--triangles", &args.triangles, &["npy"])?,
            stats: output("--stats", &args.report.stats, &["json"])?,
        };
        let files = [&plan.picture, &plan.mask, &plan.samples, &plan.triangles, &plan.stats];
        let files: Vec<&Path> = files.into_iter().flatten().map(PathBuf::as_path).collect();
        if files.is_empty() && !plan.talk.json {
            bail!(
                "nothing to write: give -o picture.png, or --mask, --samples, --triangles, --stats, --json"
            );
        }
        if let Some(view) = &plan.debug
            && plan.picture.is_none()
            && !plan.talk.json
        {
            bail!(
                "--debug {}: give -o picture.png or -o numbers.exr to draw it, or --json for its range",
                view.name
            );
        }
        distinct(&files)?;
        Ok(plan)
    }
}

impl Mask {
    pub(crate) fn new(args: &args::Mask, machine: &Machine) -> Result<Mask> {
        let plan = Mask {
            triangles: args.triangles.clone(),
            samples: args.samples.clone(),
            light: values::point("--light", &args.light)?,
            skip_radius: values::radius("--skip-radius", &args.skip_radius)?,
            method: Method::new(&args.method, machine.isa)?,
            talk: Talk::new(&args.report.talk),
            output: output("-o", &args.output, &["npy", "png"])?,
            stats: output("--stats", &args.report.stats, &["json"])?,
            repeat: values::count("--repeat", &args.repeat, 1_000_000)?,
        };
        if plan.output.is_none() && plan.stats.is_none() && !plan.talk.json {
            bail!("nothing to write: give -o mask.npy, or --stats, --json");
        }
        let files = [&plan.output, &plan.stats];
        let mut files: Vec<&Path> = files.into_iter().flatten().map(PathBuf::as_path).collect();
        files.extend([plan.triangles.as_path(), &plan.samples]);
        distinct(&files)?;
        Ok(plan)
    }
}

impl Compare {
    pub(crate) fn new(args: &args::Compare, machine: &Machine) -> Result<Compare> {
        let methods = match args.methods.as_str() {
            "all" => None,
            names => {
                let mut methods: Vec<&'static MethodInfo> = Vec::new();
                for name in names.split(',') {
                    let info = method("--methods", name.trim())?;
                    if !methods.iter().any(|m| m.name == info.name) {
                        methods.push(info);
                    }
                }
                Some(methods)
            }
        };
        if let Some(dir) = &args.diff_dir
            && dir.exists()
            && !dir.is_dir()
        {
            bail!("--diff-dir {}: is a file, not a folder", dir.display());
        }
        Ok(Compare {
            input: Input::new(&args.input)?,
            view: View::new(&args.view)?,
            lights: Lights::new(&args.lights)?,
            options: Options { isa: machine.isa, count: false },
            talk: Talk::new(&args.talk),
            methods,
            reference: args.reference.as_deref().map(|name| method("--reference", name)).transpose()?,
            diff_dir: args.diff_dir.clone(),
        })
    }
}

impl Reproduce {
    pub(crate) fn new(args: &args::Reproduce, machine: &Machine) -> Result<Reproduce> {
        let told = args.scenes.clone();
        if let Some(folder) = told.as_deref().filter(|f| !f.is_dir()) {
            bail!("--scenes {}: is not a folder", folder.display());
        }
        Ok(Reproduce {
            scenes: told.or_else(|| std::env::var_os("ANTUMBRA_SCENES").map(PathBuf::from)),
            only: args.only.iter().map(|key| key.trim().to_owned()).collect(),
            divide: values::count("--divide", &args.divide, 256)?,
            isa: machine.isa,
            quiet: args.quiet,
            output: output("-o", &args.output, &["md"])?,
        })
    }
}

/// A method by name, or what `auto` picks.
pub(crate) fn method(option: &str, name: &str) -> Result<&'static MethodInfo> {
    info(name).map_err(|e| anyhow::anyhow!("{option} {name}: {e}"))
}

/// A debug view of a method by name.
fn debug_view(method: &Method, name: &str) -> Result<DebugView> {
    let views = create(method.info.name, &method.options)?.debug_views();
    if let Some(view) = views.iter().find(|v| v.name == name) {
        return Ok(*view);
    }
    let method = method.info.name;
    if views.is_empty() {
        bail!("--debug {name}: {method} has no debug views");
    }
    let known: Vec<String> = views.iter().map(|v| format!("{} ({})", v.name, v.shows)).collect();
    bail!("--debug {name}: {method} has no such view; there are: {}", known.join("; "))
}

/// An output file: its ending must be one of `endings`, its folder must be there.
fn output(option: &str, path: &Option<PathBuf>, endings: &[&str]) -> Result<Option<PathBuf>> {
    let Some(path) = path else { return Ok(None) };
    let shown = path.display();
    if !endings.contains(&ending(path).as_str()) {
        bail!("{option} {shown}: the name must end in .{}", endings.join(" or ."));
    }
    match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() && !folder.is_dir() => {
            bail!("{option} {shown}: there is no folder {}; make it first", folder.display())
        }
        _ => Ok(Some(path.clone())),
    }
}

/// The ending of a file name, in small letters.
pub(crate) fn ending(path: &Path) -> String {
    path.extension().map(|e| e.to_string_lossy().to_ascii_lowercase()).unwrap_or_default()
}

fn distinct(files: &[&Path]) -> Result<()> {
    for (i, file) in files.iter().enumerate() {
        if files[..i].contains(file) {
            bail!("{}: named twice; each file needs a name of its own", file.display());
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use clap::Parser;

    use super::*;
    use crate::args::{Cli, Verb};

    fn render(words: &str) -> Result<Render> {
        let words = ["antumbra", "render"].into_iter().chain(words.split_whitespace());
        let Verb::Render(args) = Cli::try_parse_from(words)?.verb else { bail!("not render") };
        Render::new(&args, &Machine::new(&args.machine)?)
    }

    #[test]
    fn negative_coordinates_may_follow_a_space_or_an_equals_sign() {
        for words in
            ["a.glb --json --light -1,2,3", "a.glb --light=-1,2,3 --json", "--light -1,2,3 a.glb --json"]
        {
            assert_eq!(render(words).unwrap().lights.positions, [[-1.0, 2.0, 3.0]], "{words}");
        }
        let plan =
            render("a.glb --json --light -1,2,3 --light .5,0,-0 --light-index 2 --light-index 0").unwrap();
        assert_eq!((plan.lights.positions.len(), plan.lights.indices), (2, vec![2, 0]));
    }

    #[test]
    fn cameras_are_checked() {
        let plan =
            render("builtin:room?seed=3 --json --eye -1,0,0 --up 0,0,1 --fov 30 --size 64x48").unwrap();
        assert_eq!(plan.input.source, Source::Builtin("room?seed=3".to_owned()));
        assert_eq!((plan.view.eye, plan.view.size), (Some([-1.0, 0.0, 0.0]), [64, 48]));
        for bad in [
            "a.glb --json --target 1,2,3",
            "a.glb --json --eye 1,2,3 --target 1,2,3",
            "a.glb --json --eye 1,2,3 --camera-index 0",
            "a.glb --json --up 0,0,0",
            "a.glb --json --fov 0",
        ] {
            assert!(render(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn outputs_are_checked_before_work_begins() {
        for (bad, part) in [
            ("a.glb", "nothing to write"),
            ("a.glb -o a.jpg", ".png or .exr"),
            ("a.glb -o no/such/folder/a.png", "no folder"),
            ("a.glb -o a.png --mask a.png", "named twice"),
            ("a.glb -o a.png --method foo", "known are"),
            ("a.glb -o a.png --method ptsv --debug depth", "has no such view; there are: visits (tests of"),
            ("a.glb -o a.png --debug triangles --debug-max 0", "--debug-max 0"),
            ("a.glb -o a.png --debug-max 3", "--debug"),
            ("a.glb --mask a.npy --debug triangles", "--debug triangles: give -o"),
            ("a.glb -o a.png --backend gpu", "not built into this version; use --backend cpu"),
            ("a.glb -o a.png --isa mmx", "--isa mmx"),
            ("a.glb -o a.png --threads 0", "--threads 0"),
        ] {
            let message = format!("{:#}", render(bad).unwrap_err());
            assert!(message.contains(part), "{bad}: {message}");
        }
    }

    #[test]
    fn auto_is_a_method() {
        assert!(method("--method", "auto").unwrap().exact);
    }
}
