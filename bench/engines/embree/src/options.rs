//! The combinations of Embree's switches.

use std::fmt;

use anyhow::{Result, bail};

use crate::ffi::{Flags, Quality};

/// How the scene is built and asked.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Options {
    pub(crate) quality: Quality,
    pub(crate) flags: Flags,
    /// Rays a packet: 8 or 16.
    pub(crate) packet: usize,
    /// Whether `packet` was asked for, or is to suit the machine.
    pub(crate) packet_told: bool,
    pub(crate) coherent: bool,
    /// Rays start at the light, which all share; otherwise at their samples.
    pub(crate) from_light: bool,
    /// What is left out at the sample's end (`Case::cut`).
    pub(crate) epsilon: f32,
    /// Build with the threads that trace, rather than with Embree's own.
    pub(crate) join: bool,
}

impl Default for Options {
    fn default() -> Options {
        Options {
            quality: Quality::Low,
            flags: Flags::default(),
            packet: 16,
            packet_told: false,
            coherent: true,
            from_light: true,
            epsilon: 1e-5,
            join: false,
        }
    }
}

impl Options {
    /// Words joined by colons; nothing for the default.
    pub(crate) fn parse(text: &str) -> Result<Options> {
        let mut options = Options::default();
        for word in text.split(':').filter(|w| !w.is_empty()) {
            match word {
                "low" => options.quality = Quality::Low,
                "medium" => options.quality = Quality::Medium,
                "high" => options.quality = Quality::High,
                "dynamic" => options.flags.dynamic = true,
                "robust" => options.flags.robust = true,
                "8" | "16" => {
                    options.packet = if word == "8" { 8 } else { 16 };
                    options.packet_told = true;
                }
                "incoherent" => options.coherent = false,
                "light" => options.from_light = true,
                "sample" => options.from_light = false,
                "join" => options.join = true,
                _ => match word.strip_prefix("eps=").map(str::parse::<f32>) {
                    Some(Ok(epsilon)) if (0.0..1.0).contains(&epsilon) => options.epsilon = epsilon,
                    _ => bail!(
                        "embree:{word}: unknown option; known are low, medium, high, dynamic, robust, 8, 16, incoherent, \
                         light, sample, join, eps=NUMBER"
                    ),
                },
            }
        }
        Ok(options)
    }
}

impl fmt::Display for Options {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let quality = match self.quality {
            Quality::Low => "low",
            Quality::Medium => "medium",
            Quality::High => "high",
        };
        write!(f, "quality {quality}, packets of {}, rays from ", self.packet)?;
        f.write_str(if self.from_light { "the light" } else { "the sample" })?;
        f.write_str(if self.coherent { ", coherent" } else { ", incoherent" })?;
        for (on, word) in
            [(self.flags.robust, ", robust"), (self.flags.dynamic, ", dynamic"), (self.join, ", joined")]
        {
            f.write_str(if on { word } else { "" })?;
        }
        write!(f, ", epsilon {:e}", self.epsilon)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn options_are_words() {
        assert_eq!(Options::parse("").unwrap(), Options::default());
        let options = Options::parse("sample:robust:8:eps=1e-5").unwrap();
        assert!(
            !options.from_light && options.flags.robust && options.packet == 8 && options.epsilon == 1e-5
        );
        assert!(Options::parse("fast").unwrap_err().to_string().contains("known are"));
        assert!(Options::parse("eps=2").is_err());
    }
}
