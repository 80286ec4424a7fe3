//! Text to numbers. Every message names the option, what was given, and what would do.

use anyhow::{Context, Result, bail};

/// `X,Y,Z`: three finite numbers.
pub(crate) fn point(option: &str, text: &str) -> Result<[f32; 3]> {
    let numbers: Vec<f32> = text.split(',').map_while(finite).collect();
    match <[f32; 3]>::try_from(numbers) {
        Ok(point) if text.split(',').count() == 3 => Ok(point),
        _ => bail!("{option} {text}: expected three finite numbers, e.g. {option} 1,2.5,-3"),
    }
}

/// A point that is not zero.
pub(crate) fn direction(option: &str, text: &str) -> Result<[f32; 3]> {
    let v = point(option, text)?;
    if v == [0.0; 3] {
        bail!("{option} {text}: a direction cannot be zero, e.g. {option} 0,1,0");
    }
    Ok(v)
}

/// A finite number.
pub(crate) fn number(option: &str, text: &str) -> Result<f32> {
    finite(text).with_context(|| format!("{option} {text}: expected a finite number, e.g. {option} 1.5"))
}

/// A finite number, not below zero.
pub(crate) fn radius(option: &str, text: &str) -> Result<f32> {
    match finite(text) {
        Some(v) if v >= 0.0 => Ok(v),
        _ => bail!("{option} {text}: expected a number that is not negative, e.g. {option} 1.5"),
    }
}

/// A finite number above zero.
pub(crate) fn positive(option: &str, text: &str) -> Result<f32> {
    match finite(text) {
        Some(v) if v > 0.0 => Ok(v),
        _ => bail!("{option} {text}: expected a number above zero, e.g. {option} 100"),
    }
}

/// Degrees of a field of view.
pub(crate) fn angle(option: &str, text: &str) -> Result<f32> {
    match finite(text) {
        Some(v) if (0.001..=179.0).contains(&v) => Ok(v),
        _ => bail!("{option} {text}: expected degrees between 0.001 and 179, e.g. {option} 45"),
    }
}

/// A whole number of at least 1.
pub(crate) fn count(option: &str, text: &str, most: usize) -> Result<usize> {
    match text.trim().parse() {
        Ok(n) if (1..=most).contains(&n) => Ok(n),
        _ => bail!("{option} {text}: expected a whole number from 1 to {most}"),
    }
}

/// Longest side and most pixels of a picture: some 100 bytes a pixel are in flight, so this is about 13 GB.
const LONGEST_SIDE: usize = 65_535;
const MOST_PIXELS: usize = 1 << 27;

/// `WxH`.
pub(crate) fn size(text: &str) -> Result<[usize; 2]> {
    let sides = text
        .split_once(['x', 'X', '×'])
        .and_then(|(w, h)| Some([w.trim().parse::<usize>().ok()?, h.trim().parse::<usize>().ok()?]));
    match sides {
        Some([w, h]) if w == 0 || h == 0 => bail!("--size {text}: a picture needs at least 1x1 pixels"),
        Some([w, h]) if w.max(h) > LONGEST_SIDE || w * h > MOST_PIXELS => bail!(
            "--size {text}: more than is supported ({LONGEST_SIDE} a side, {} million pixels in all)",
            MOST_PIXELS / 1_000_000
        ),
        Some(sides) => Ok(sides),
        None => bail!("--size {text}: expected width x height in pixels, e.g. --size 1920x1080"),
    }
}

fn finite(text: &str) -> Option<f32> {
    text.trim().parse().ok().filter(|v: &f32| v.is_finite())
}

/// Does `name` match `pattern`, in which `*` stands for any text and `?` for any one letter?
pub(crate) fn matches(pattern: &str, name: &str) -> bool {
    let (p, n): (Vec<char>, Vec<char>) = (pattern.chars().collect(), name.chars().collect());
    let (mut i, mut j) = (0, 0);
    // Where the last star was, and up to where it has eaten: a later star makes earlier ones final.
    let mut star = None;
    while j < n.len() {
        match p.get(i) {
            Some('*') => {
                star = Some((i, j));
                i += 1;
            }
            Some(c) if *c == '?' || *c == n[j] => {
                i += 1;
                j += 1;
            }
            _ => {
                let Some((at, eaten)) = star else { return false };
                star = Some((at, eaten + 1));
                (i, j) = (at + 1, eaten + 1);
            }
        }
    }
    p[i..].iter().all(|c| *c == '*')
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_are_three_finite_numbers() {
        assert_eq!(point("--light", "-1,2.5, 3e2").unwrap(), [-1.0, 2.5, 300.0]);
        for bad in ["", "1,2", "1,2,3,4", "1,2,x", "nan,0,0", "0,inf,0", "1e39,0,0", "1,,2,3", "--size"] {
            let message = point("--light", bad).unwrap_err().to_string();
            assert!(message.starts_with("--light") && message.contains("1,2.5,-3"), "{message}");
        }
        assert!(direction("--up", "0,0,0").is_err());
    }

    #[test]
    fn sizes_have_limits() {
        assert_eq!(size("1920x1080").unwrap(), [1920, 1080]);
        for bad in ["0x0", "10x0", "x", "10", "-3x4", "70000x1", "20000x20000", "99999999999999999999x1"] {
            assert!(size(bad).unwrap_err().to_string().contains("--size"), "{bad}");
        }
    }

    #[test]
    fn numbers_have_ranges() {
        assert!(radius("--skip-radius", "-1").is_err() && radius("--skip-radius", "0").is_ok());
        assert!(
            angle("--fov", "180").is_err() && angle("--fov", "0").is_err() && angle("--fov", "45").is_ok()
        );
        assert!(count("--threads", "0", 9).is_err() && count("--threads", "9", 9).is_ok());
        assert!(number("--time", "nan").is_err());
    }

    #[test]
    fn globs() {
        for (pattern, name) in
            [("*", ""), ("lamp*", "lamp 3"), ("*glass*", "a glass b"), ("a?c", "abc"), ("*a*b", "xaayb")]
        {
            assert!(matches(pattern, name), "{pattern} {name}");
        }
        for (pattern, name) in [("", "a"), ("lamp", "lamp 3"), ("a?c", "ac"), ("*a*b", "ba"), ("?", "")] {
            assert!(!matches(pattern, name), "{pattern} {name}");
        }
    }
}
