//! Where buffers and images come from: `data:` URIs and files beside the scene.

use std::path::PathBuf;

/// What a URI stands for.
#[derive(Debug, PartialEq)]
pub(super) enum Target {
    /// Content of a `data:` URI.
    Data(Vec<u8>),
    /// A path relative to the folder of the scene file.
    File(PathBuf),
}

/// Takes a URI of a glTF file apart. The message of an error fits behind "buffer 3: ".
pub(super) fn resolve(uri: &str) -> Result<Target, String> {
    if let Some(rest) = uri.strip_prefix("data:") {
        let (head, body) = rest.split_once(',').ok_or("data: URI without a comma")?;
        let bytes = if head.ends_with(";base64") { base64(body)? } else { percent_decode(body) };
        return Ok(Target::Data(bytes));
    }
    // A scheme is letters before a colon; one letter would be a drive of Windows, which is not relative either.
    if let Some((scheme, _)) = uri.split_once(':')
        && !scheme.is_empty()
        && scheme.chars().all(|c| c.is_ascii_alphanumeric() || "+-.".contains(c))
    {
        return Err(format!(
            "'{}' is not a relative path; only files beside the scene are read",
            shorten(uri)
        ));
    }
    let path = String::from_utf8(percent_decode(uri))
        .map_err(|_| format!("'{}' is not UTF-8 after percent-decoding", shorten(uri)))?;
    if path.is_empty() || path.contains('\0') {
        return Err(format!("'{}' is not a file name", shorten(uri)));
    }
    let path = PathBuf::from(path);
    if path.is_absolute() || path.has_root() {
        return Err(format!("'{}' is an absolute path; only relative ones are read", shorten(uri)));
    }
    Ok(Target::File(path))
}

/// The first characters of a URI, fit for a message.
fn shorten(uri: &str) -> String {
    uri.chars().filter(|c| !c.is_control()).take(80).collect()
}

/// Turns `%20` into a space and so on; a `%` without two hexadecimal digits stays as it is.
fn percent_decode(text: &str) -> Vec<u8> {
    let bytes = text.as_bytes();
    let digit = |at: usize| bytes.get(at).and_then(|&b| char::from(b).to_digit(16));
    let mut out = Vec::with_capacity(bytes.len());
    let mut at = 0;
    while at < bytes.len() {
        if bytes[at] == b'%'
            && let (Some(high), Some(low)) = (digit(at + 1), digit(at + 2))
        {
            out.push((high * 16 + low) as u8);
            at += 3;
        } else {
            out.push(bytes[at]);
            at += 1;
        }
    }
    out
}

/// Decodes RFC 4648 base64, both alphabets, with or without padding.
fn base64(text: &str) -> Result<Vec<u8>, String> {
    let mut out = Vec::with_capacity(text.len() / 4 * 3 + 3);
    let (mut bits, mut count) = (0u32, 0u32);
    for (at, byte) in text.bytes().enumerate() {
        let value = match byte {
            b'A'..=b'Z' => byte - b'A',
            b'a'..=b'z' => byte - b'a' + 26,
            b'0'..=b'9' => byte - b'0' + 52,
            b'+' | b'-' => 62,
            b'/' | b'_' => 63,
            b'=' | b'\r' | b'\n' | b' ' => continue,
            _ => return Err(format!("byte {at} of the base64 data is not base64")),
        };
        bits = (bits << 6) | u32::from(value);
        count += 6;
        if count >= 8 {
            count -= 8;
            out.push((bits >> count) as u8);
        }
    }
    Ok(out)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn data(uri: &str) -> Vec<u8> {
        match resolve(uri) {
            Ok(Target::Data(bytes)) => bytes,
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn data_uris_are_decoded() {
        assert_eq!(data("data:application/octet-stream;base64,AAECAw=="), [0, 1, 2, 3]);
        assert_eq!(data("data:;base64,AAEC"), [0, 1, 2]);
        assert_eq!(data("data:text/plain,a%20b"), b"a b");
        assert!(resolve("data:;base64,A*B").unwrap_err().contains("byte 1"));
        assert!(resolve("data:nothing").is_err());
    }

    #[test]
    fn only_relative_paths_are_files() {
        assert_eq!(resolve("a%20b/c.bin"), Ok(Target::File("a b/c.bin".into())));
        assert_eq!(resolve("../textures/x%.png"), Ok(Target::File("../textures/x%.png".into())));
        for uri in ["http://example.org/a.bin", "file:///a.bin", "/a.bin", "", "a%00b", "%ff"] {
            assert!(resolve(uri).is_err(), "{uri}");
        }
    }
}
