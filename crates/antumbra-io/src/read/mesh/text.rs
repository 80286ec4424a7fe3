//! Words and numbers of text formats.

/// A walk over the words of a text.
#[derive(Clone, Debug)]
pub(in crate::read) struct Text<'a> {
    /// The whole text.
    pub(in crate::read) bytes: &'a [u8],
    /// Where the walk is.
    pub(in crate::read) at: usize,
}

impl<'a> Text<'a> {
    /// The next word, if any.
    pub(in crate::read) fn word(&mut self) -> Option<&'a [u8]> {
        let rest = &self.bytes[self.at..];
        let start = rest.iter().position(|b| !space(*b))?;
        let len = rest[start..].iter().position(|b| space(*b)).unwrap_or(rest.len() - start);
        self.at += start + len;
        Some(&rest[start..start + len])
    }

    /// What is left of the current line, trimmed; the walk goes on behind it.
    pub(in crate::read) fn rest_of_line(&mut self) -> &'a [u8] {
        let rest = &self.bytes[self.at..];
        let len = rest.iter().position(|b| matches!(b, b'\n' | b'\r')).unwrap_or(rest.len());
        self.at += len;
        rest[..len].trim_ascii()
    }

    /// The line that the walk is in, from 1. Counted only when an error asks for it.
    pub(in crate::read) fn line(&self) -> usize {
        1 + self.bytes[..self.at].iter().filter(|b| **b == b'\n').count()
    }
}

fn space(b: u8) -> bool {
    matches!(b, b' ' | b'\t' | b'\n' | b'\r' | 0x0b | 0x0c)
}

/// A number in decimal notation, as `f32` or `f64` rounds it; overflow gives infinity. Knows the NaN of Windows.
pub(in crate::read) fn number<T: std::str::FromStr>(word: &[u8]) -> Result<T, String> {
    let text = std::str::from_utf8(word).map_err(|_| not_a_number(word))?;
    text.parse().or_else(|_| {
        let bare =
            text.trim_start_matches(['-', '+', '1', '.', '#']).trim_end_matches('0').to_ascii_lowercase();
        let windows = matches!(bare.as_str(), "ind" | "qnan" | "snan" | "inf" | "nan(ind)" | "nan(snan)");
        if windows { "nan".parse().map_err(|_| not_a_number(word)) } else { Err(not_a_number(word)) }
    })
}

fn not_a_number(word: &[u8]) -> String {
    format!("{} is not a number", quote(word))
}

/// A finite number.
pub(in crate::read) fn finite(word: &[u8]) -> Result<f32, String> {
    let value: f32 = number(word)?;
    if value.is_finite() { Ok(value) } else { Err(format!("{} is not a finite number", quote(word))) }
}

/// A piece of the file, for a message: quoted, printable, short.
pub(in crate::read) fn quote(word: &[u8]) -> String {
    let short = String::from_utf8_lossy(&word[..word.len().min(40)]);
    format!("{short:?}{}", if word.len() > 40 { "…" } else { "" })
}
