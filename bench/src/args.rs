//! What is typed.

use std::path::PathBuf;

use clap::{Args, Parser};

/// What is to be done.
#[derive(Debug)]
pub enum Plan {
    /// One case from files.
    Arrays(Arrays),
    /// A folder of scenes: everything after the word `suite`.
    Suite(Suite),
}

impl Plan {
    /// Reads the command line; ends the program where that cannot be meant.
    pub fn parse() -> Plan {
        let mut words: Vec<_> = std::env::args_os().collect();
        if words.get(1).is_some_and(|word| word == "suite") {
            words.remove(1);
            return Plan::Suite(Suite::parse_from(words));
        }
        Plan::Arrays(Arrays::parse_from(words))
    }
}

/// Times antumbra's methods and other programs on the same triangles, samples and light, by turns in one process.
#[derive(Debug, Parser)]
#[command(name = "antumbra-rivals", after_help = AFTER)]
pub struct Arrays {
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

/// Times a folder of scenes, checks their answers, and keeps a record.
#[derive(Debug, Parser)]
#[command(name = "antumbra-rivals suite")]
pub struct Suite {
    /// The folder of `.toml` files.
    #[arg(long, default_value = "bench/definitions")]
    pub definitions: PathBuf,
    /// Only cases whose names contain one of these.
    #[arg(long, value_delimiter = ',')]
    pub only: Vec<String>,
    /// Pictures of cases that do not say it themselves.
    #[arg(long, value_name = "WxH", default_value = "1920x1080")]
    pub size: String,
    /// How it is run.
    #[command(flatten)]
    pub how: How,
    /// Where records are kept: RECORD/<machine>/<date>-<size>.csv.
    #[arg(long, default_value = "bench/record")]
    pub record: PathBuf,
    /// What this machine is called in records [default: processor and threads].
    #[arg(long)]
    pub machine: Option<String>,
    /// Writes no record.
    #[arg(long)]
    pub no_record: bool,
    /// Writes what is found into the definitions, as the right answer. Uses exact engines only.
    #[arg(long)]
    pub update: bool,
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
    /// Seconds after which a case gets no more rounds, however many it has had (one at least).
    #[arg(long, default_value_t = 120)]
    pub budget: u64,
    /// Threads of each engine [default: all].
    #[arg(long, value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: Option<u16>,
    /// Milliseconds of rest before each frame, for the other engines' threads to fall asleep.
    #[arg(long, default_value_t = 5)]
    pub rest: u64,
    /// After a round with a frame longer than so many milliseconds, each engine makes one more first, which does not count.
    #[arg(long, default_value_t = 1000)]
    pub stale: u64,
}

const AFTER: &str = "\
antumbra-rivals suite --help: a folder of scenes instead of files of arrays.
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arrays_and_suite() {
        let words = "antumbra-rivals --triangles t.npy --samples s.npy --light -1,2,3 --engines embree,antumbra:oracle";
        let arrays = Arrays::try_parse_from(words.split(' ')).unwrap();
        assert_eq!(arrays.light, [-1.0, 2.0, 3.0]);
        assert_eq!(arrays.how.engines, ["embree", "antumbra:oracle"]);
        assert!(Arrays::try_parse_from(["antumbra-rivals", "--light", "1,2"]).is_err());
        let suite = Suite::try_parse_from(["antumbra-rivals suite", "--only", "sponza,dragon"]).unwrap();
        assert_eq!((suite.only.len(), suite.size.as_str()), (2, "1920x1080"));
    }
}
