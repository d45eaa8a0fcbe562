//! What a file of no known format seems to be: enough for a message, and nothing of its content, which may be none of ours.

/// Kinds of files that people pick by mistake, by what they begin with.
const KNOWN: [(&[u8], &str); 10] = [
    (b"PK\x03\x04", "a ZIP archive or an office document"),
    (b"\x1f\x8b", "a gzip archive"),
    (b"7z\xbc\xaf", "a 7z archive"),
    (b"%PDF", "a PDF document"),
    (b"\x89PNG", "a picture"),
    (b"\xff\xd8\xff", "a picture"),
    (b"\x89HDF", "an HDF5 file"),
    (b"CDF", "a NetCDF file"),
    (b"SQLite", "a database"),
    (b"PAR1", "a Parquet file"),
];

/// In words, from a file's first bytes.
#[must_use]
pub fn kind_of(begin: &[u8]) -> &'static str {
    let known = KNOWN.iter().find(|(magic, _)| begin.starts_with(magic));
    if let Some((_, name)) = known {
        return name;
    }
    // a cut at the end may fall within a letter
    let text = match std::str::from_utf8(begin) {
        Ok(text) => Some(text),
        Err(error) if error.error_len().is_none() => {
            std::str::from_utf8(&begin[..error.valid_up_to()]).ok()
        }
        Err(_) => None,
    };
    let printable = |c: char| !c.is_control() || c.is_whitespace();
    match text {
        _ if begin.is_empty() => "an empty file",
        Some(text) if text.chars().all(printable) => "some text",
        _ => "binary data of no known format",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn kinds_are_told_without_their_content() {
        assert_eq!(kind_of(b""), "an empty file");
        assert_eq!(kind_of(b"root:x:0:0:root:"), "some text");
        assert_eq!(kind_of("Größ".as_bytes()), "some text");
        assert_eq!(kind_of(&"Größ".as_bytes()[..3]), "some text");
        assert_eq!(kind_of(&[0, 1, 2, 3]), "binary data of no known format");
        assert_eq!(kind_of(b"\xff\xfe\xfd"), "binary data of no known format");
        assert_eq!(
            kind_of(b"PK\x03\x04..."),
            "a ZIP archive or an office document"
        );
    }
}
