//! Which instruction set the kernels use: detected once, can be forced, never changes a result.

use fearless_simd::Level;

/// An instruction set that the kernels are compiled for.
///
/// Masks are the same for every level: the filters only differ in what they leave to the exact stage.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Isa {
    /// The best level that this machine has.
    #[default]
    Auto,
    /// No vector instructions.
    Scalar,
    /// x86: the baseline of `x86_64`.
    Sse2,
    /// x86-64-v2.
    Sse42,
    /// x86-64-v3: AVX2 with FMA.
    Avx2,
    /// Ice-Lake-class AVX-512.
    Avx512,
    /// 64-bit ARM.
    Neon,
    /// WebAssembly with `simd128`.
    WasmSimd128,
}

/// A level that does not exist, or not on this machine.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("instruction set '{name}' is not available here; this machine has: {available}")]
pub struct UnknownIsa {
    name: String,
    available: String,
}

impl Isa {
    /// All levels but [`Isa::Auto`], weakest first.
    pub const ALL: [Isa; 7] =
        [Isa::Scalar, Isa::Sse2, Isa::Sse42, Isa::Avx2, Isa::Avx512, Isa::Neon, Isa::WasmSimd128];

    /// The name used on the command line and in reports.
    pub fn name(self) -> &'static str {
        match self {
            Isa::Auto => "auto",
            Isa::Scalar => "scalar",
            Isa::Sse2 => "sse2",
            Isa::Sse42 => "sse4.2",
            Isa::Avx2 => "avx2",
            Isa::Avx512 => "avx512",
            Isa::Neon => "neon",
            Isa::WasmSimd128 => "simd128",
        }
    }

    /// The levels that this machine can run, weakest first.
    pub fn available() -> Vec<Isa> {
        Isa::ALL.into_iter().filter(|isa| isa.is_available()).collect()
    }

    fn is_available(self) -> bool {
        self.level().is_some()
    }

    /// Reads a name as [`Isa::name`] gives it.
    ///
    /// # Errors
    /// [`UnknownIsa`] if there is no such level or this machine lacks it; the message lists those it has.
    pub fn parse(name: &str) -> Result<Isa, UnknownIsa> {
        let lower = name.to_ascii_lowercase();
        std::iter::once(Isa::Auto)
            .chain(Isa::ALL)
            .find(|isa| isa.name() == lower && isa.level().is_some())
            .ok_or_else(|| UnknownIsa {
                name: name.to_owned(),
                available: Isa::available().iter().map(|isa| isa.name()).collect::<Vec<_>>().join(", "),
            })
    }

    /// The level to dispatch on, `None` where this machine lacks it.
    #[cfg(target_arch = "x86_64")]
    pub(crate) fn level(self) -> Option<Level> {
        let best = Level::new();
        match self {
            Isa::Auto => Some(best),
            Isa::Scalar => Some(Level::fallback()),
            Isa::Sse2 => best.as_sse2().map(Level::Sse2),
            Isa::Sse42 => best.as_sse4_2().map(Level::Sse4_2),
            Isa::Avx2 => best.as_avx2().map(Level::Avx2),
            Isa::Avx512 => best.as_avx512().map(Level::Avx512),
            Isa::Neon | Isa::WasmSimd128 => None,
        }
    }

    /// The level to dispatch on, `None` where this machine lacks it.
    #[cfg(not(target_arch = "x86_64"))]
    pub(crate) fn level(self) -> Option<Level> {
        let best = Level::new();
        let named = if cfg!(target_arch = "aarch64") { Isa::Neon } else { Isa::WasmSimd128 };
        match self {
            Isa::Auto => Some(best),
            Isa::Scalar => Some(Level::fallback()),
            isa if isa == named && !best.is_fallback() => Some(best),
            _ => None,
        }
    }

    /// The level that will really run: [`Isa::Auto`] resolved.
    pub fn resolved(self) -> Isa {
        match self {
            Isa::Auto => Isa::ALL.into_iter().rfind(|isa| isa.is_available()).unwrap_or(Isa::Scalar),
            isa => isa,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_round_trip_and_unknown_ones_name_the_remedy() {
        for isa in Isa::available() {
            assert_eq!(Isa::parse(isa.name()), Ok(isa));
        }
        let message = Isa::parse("mmx").unwrap_err().to_string();
        assert!(message.contains("mmx") && message.contains("scalar"), "{message}");
        assert_ne!(Isa::Auto.resolved(), Isa::Auto);
    }
}
