//! `methods` and `scenes`: what there is to choose from.

use std::process::ExitCode;

use antumbra::methods::CATALOGUE;
use antumbra::scene::procedural::BUILTINS;
use anyhow::Result;
use serde::Serialize;

use crate::console::{print, print_json, table};
use crate::plan;
use crate::report::SCHEMA_VERSION;

#[derive(Serialize)]
struct MethodEntry {
    name: &'static str,
    aliases: &'static [&'static str],
    source: &'static str,
    exact: bool,
    idea: &'static str,
    cost: &'static str,
}

#[derive(Serialize)]
struct Methods {
    schema_version: u32,
    /// What `--method auto` picks.
    auto: &'static str,
    methods: Vec<MethodEntry>,
}

/// `methods`.
pub(crate) fn methods(json: bool) -> Result<ExitCode> {
    let auto = plan::method("--method", "auto")?.name;
    let entry = |m: &antumbra::methods::MethodInfo| MethodEntry {
        name: m.name,
        aliases: m.aliases,
        source: m.source,
        exact: m.exact,
        idea: m.idea,
        cost: m.cost,
    };
    let methods: Vec<MethodEntry> = CATALOGUE.iter().map(entry).collect();
    if json {
        print_json(&Methods { schema_version: SCHEMA_VERSION, auto, methods })?;
        return Ok(ExitCode::SUCCESS);
    }
    let mut text = String::new();
    for m in &methods {
        let exact = if m.exact { "exact" } else { "approximate" };
        text += &format!("{} ({exact}; {})\n    {}\n    {}\n", m.name, m.cost, m.idea, m.source);
        if !m.aliases.is_empty() {
            text += &format!("    also called: {}\n", m.aliases.join(", "));
        }
    }
    print(&format!("{text}\n--method auto is {auto}. T triangles, N samples.\n"))?;
    Ok(ExitCode::SUCCESS)
}

#[derive(Serialize)]
struct Parameter {
    name: &'static str,
    summary: &'static str,
    default: u64,
    range: [u64; 2],
}

#[derive(Serialize)]
struct SceneEntry {
    name: &'static str,
    summary: &'static str,
    default_triangles: usize,
    animated: bool,
    failure_mode: bool,
    parameters: Vec<Parameter>,
}

#[derive(Serialize)]
struct Scenes {
    schema_version: u32,
    scenes: Vec<SceneEntry>,
}

/// `scenes`.
pub(crate) fn scenes(json: bool) -> Result<ExitCode> {
    if json {
        let scenes = BUILTINS.iter().map(|b| SceneEntry {
            name: b.name,
            summary: b.summary,
            default_triangles: b.default_triangles,
            animated: b.animated,
            failure_mode: b.failure_mode,
            parameters: b
                .parameters
                .iter()
                .map(|p| Parameter { name: p.name, summary: p.summary, default: p.default, range: p.range })
                .collect(),
        });
        print_json(&Scenes { schema_version: SCHEMA_VERSION, scenes: scenes.collect() })?;
        return Ok(ExitCode::SUCCESS);
    }
    let mut rows = vec![["name", "triangles", "what it shows"].map(str::to_owned).to_vec()];
    for b in BUILTINS {
        let mut notes: Vec<String> = Vec::new();
        if b.animated {
            notes.push("moves".to_owned());
        }
        if !b.parameters.is_empty() {
            notes.push(b.parameters.iter().map(|p| format!("{}=", p.name)).collect::<Vec<_>>().join(" "));
        }
        let notes = if notes.is_empty() { String::new() } else { format!(" ({})", notes.join("; ")) };
        rows.push(vec![
            format!("builtin:{}", b.name),
            b.default_triangles.to_string(),
            format!("{}{notes}", b.summary),
        ]);
    }
    let example =
        "Parameters follow a question mark: builtin:room?seed=3. Triangles: about, without parameters.\n";
    print(&format!("{}\n{example}", table(&rows, &[0, 2])))?;
    Ok(ExitCode::SUCCESS)
}
