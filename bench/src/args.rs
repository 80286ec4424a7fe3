//! What is typed.

use std::path::PathBuf;

use clap::{Args, Parser};

/// Times antumbra's methods and other programs on the same triangles, samples and light, by turns in one process.
#[derive(Debug, Parser)]
#[command(name = "antumbra-rivals", after_help = AFTER)]
pub struct Cli {
    /// f32 [T,3,3].
    #[arg(long, value_name = "T.npy")]
    pub triangles: PathBuf,
    /// f32 [H,W,3] or [N,3]; NaN = no sample.
    #[arg(long, value_name = "S.npy")]
    pub samples: PathBuf,
    /// Where the light is.
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true, value_parser = point)]
    pub light: [f32; 3],
    /// How it is run.
    #[command(flatten)]
    pub how: How,
    /// One row an engine and round.
    #[arg(short, long, value_name = "RECORD.csv")]
    pub output: Option<PathBuf>,
    /// The report as JSON.
    #[arg(long)]
    pub json: bool,
}

/// How the engines are run.
#[derive(Clone, Debug, Args)]
pub struct How {
    /// Comma-separated: antumbra:METHOD, embree[:OPTION...], obvhs[:PRESET].
    #[arg(long, value_delimiter = ',', default_value = "antumbra:auto,antumbra:ray-cast,embree")]
    pub engines: Vec<String>,
    /// Frames of each engine that count; one more before them does not.
    #[arg(long, default_value_t = 9, value_parser = clap::value_parser!(u16).range(1..))]
    pub rounds: u16,
    /// Threads of each engine [default: all].
    #[arg(long, value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: Option<u16>,
    /// Milliseconds of rest before each frame, for the other engines' threads to fall asleep.
    #[arg(long, default_value_t = 5)]
    pub rest: u64,
}

const AFTER: &str = "\
Embree is looked for where ANTUMBRA_EMBREE_LIB says; bench/engines/embree/fetch.sh gets it and prints the path.
Arrays are made by: antumbra render SCENE --triangles t.npy --samples s.npy (and --light, --eye, ...).
Exit code 1: masks of exact methods differ.";

/// `X,Y,Z`.
fn point(text: &str) -> Result<[f32; 3], String> {
    let parts: Result<Vec<f32>, _> = text.split(',').map(|v| v.trim().parse::<f32>()).collect();
    match parts.map(<[f32; 3]>::try_from) {
        Ok(Ok(point)) if point.iter().all(|v| v.is_finite()) => Ok(point),
        _ => Err(format!("'{text}' is not three finite numbers X,Y,Z")),
    }
}
