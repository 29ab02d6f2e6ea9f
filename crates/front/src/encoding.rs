//! Decodes bytes to text: as a byte order mark or an XML declaration says, then as UTF-8, then in the code pages that
//! the vendors' tools use.

use std::borrow::Cow;

use encoding_rs::{
    DecoderResult, EUC_KR, Encoding, GBK, SHIFT_JIS, UTF_8, UTF_16BE, UTF_16LE, WINDOWS_1252,
};

/// The code pages to try on text that is not UTF-8, in this order (CP932, CP936, CP949).
const CODE_PAGES: [&Encoding; 3] = [SHIFT_JIS, GBK, EUC_KR];

/// A text encoding that the user named.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Named(&'static Encoding);

impl std::str::FromStr for Named {
    type Err = String;

    fn from_str(text: &str) -> Result<Named, String> {
        let label = match text.to_ascii_lowercase().as_str() {
            "cp932" => "shift_jis".to_owned(),
            "cp936" => "gbk".to_owned(),
            "cp949" => "euc-kr".to_owned(),
            other => other.replace('_', "-").replace("shift-jis", "shift_jis"),
        };
        Encoding::for_label(label.as_bytes()).map(Named).ok_or_else(|| {
            "unknown encoding: write windows-1252, windows-1251, windows-1250, shift_jis, gbk, euc-kr or another name of the WHATWG encoding standard".to_owned()
        })
    }
}

impl std::fmt::Display for Named {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.0.name().to_ascii_lowercase())
    }
}

impl Named {
    /// Converts the bytes to UTF-8. `None` if they are UTF-8 already, declare an encoding, or are not valid in this
    /// encoding.
    pub fn recoded(self, bytes: &[u8]) -> Option<String> {
        if declared(bytes).is_some() || std::str::from_utf8(bytes).is_ok() {
            return None;
        }
        strict(self.0, bytes).ok().map(Cow::into_owned)
    }
}

/// All decodings of bytes that are not UTF-8 and declare no encoding, each with the encoding's name: those of
/// Shift-JIS, GBK and EUC-KR in which every byte is valid, and that of windows-1252. Empty for other bytes.
pub fn candidates(bytes: &[u8]) -> Vec<(&'static str, Cow<'_, str>)> {
    if declared(bytes).is_some() || std::str::from_utf8(bytes).is_ok() {
        return Vec::new();
    }
    let pages = CODE_PAGES.into_iter().chain([WINDOWS_1252]);
    pages.filter_map(|page| Some((page.name(), strict(page, bytes).ok()?))).collect()
}

/// Why a file could not be decoded, and where.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Undecodable {
    /// The byte offset in the file at which decoding failed, from 0.
    pub offset: usize,
    /// The line in which decoding failed, from 1.
    pub line: u32,
    /// The names of the encodings that were tried.
    pub tried: String,
    /// Whether decoding failed in the last three bytes of the file, so that it probably ends in the middle of a
    /// character.
    pub cut: bool,
}

/// Decodes a file: in the encoding that it declares, otherwise as UTF-8, otherwise in one of the code pages Shift-JIS,
/// GBK and EUC-KR. If several code pages fit, the first one whose text contains one of `known_words` is used, otherwise
/// the first one that fits.
///
/// # Errors
/// The bytes are not valid in the declared encoding; or none is declared and no encoding fits. The place is then where
/// decoding failed in the encoding that came furthest.
pub fn decode<'a>(bytes: &'a [u8], known_words: &[&str]) -> Result<Cow<'a, str>, Undecodable> {
    if let Some((encoding, skip)) = declared(bytes) {
        return strict(encoding, &bytes[skip..])
            .map_err(|at| undecodable(encoding, bytes, skip, at, encoding.name()));
    }
    let mut furthest = match std::str::from_utf8(bytes) {
        Ok(text) => return Ok(Cow::Borrowed(text)),
        Err(error) => (error.valid_up_to(), UTF_8),
    };
    let mut fitting = None;
    for encoding in CODE_PAGES {
        match strict(encoding, bytes) {
            Ok(text) if known_words.iter().any(|mark| text.contains(mark)) => return Ok(text),
            Ok(text) => fitting = fitting.or(Some(text)),
            Err(at) if at > furthest.0 => furthest = (at, encoding),
            Err(_) => {}
        }
    }
    fitting.ok_or_else(|| {
        undecodable(
            furthest.1,
            bytes,
            0,
            furthest.0,
            "UTF-8, Shift-JIS, GBK (CP936) or EUC-KR (CP949)",
        )
    })
}

/// Decodes the first `limit` bytes: in the declared encoding; otherwise in that of UTF-8 and the code pages that fits
/// and whose text contains one of `known_words`, or in the first one that fits. A character that the limit cuts is left
/// out. If no encoding fits, or bytes are invalid in the declared one, invalid bytes are replaced.
pub fn beginning<'a>(bytes: &'a [u8], limit: usize, known_words: &[&str]) -> Cow<'a, str> {
    let head = &bytes[..bytes.len().min(limit)];
    if let Some((encoding, skip)) = declared(head) {
        return encoding.decode_without_bom_handling(&head[skip..]).0;
    }
    // ASCII is the same in all the code pages.
    if head.is_ascii() {
        return String::from_utf8_lossy(head);
    }
    let mut candidates: Vec<Cow<'_, str>> = std::iter::once(UTF_8)
        .chain(CODE_PAGES)
        .filter_map(|encoding| {
            // The limit may cut a character in two: invalid bytes at the very end are ignored.
            (head.len().saturating_sub(4)..=head.len())
                .rev()
                .find_map(|end| strict(encoding, &head[..end]).ok())
        })
        .collect();
    if candidates.is_empty() {
        return String::from_utf8_lossy(head);
    }
    let marked =
        candidates.iter().position(|text| known_words.iter().any(|mark| text.contains(mark)));
    candidates.swap_remove(marked.unwrap_or(0))
}

/// The encoding that the file declares by a byte order mark or an XML declaration, or UTF-16 if one of the first two
/// bytes is zero; and the length of the byte order mark (0 if there is none). `None` if nothing shows the encoding.
fn declared(bytes: &[u8]) -> Option<(&'static Encoding, usize)> {
    Encoding::for_bom(bytes).or(match bytes {
        // Only UTF-16 text has a NUL beside a character of ASCII.
        [first, 0, ..] if *first != 0 => Some((UTF_16LE, 0)),
        [0, second, ..] if *second != 0 => Some((UTF_16BE, 0)),
        _ => of_xml(bytes).map(|encoding| (encoding, 0)),
    })
}

/// The encoding that the XML declaration names. `None` if no declaration ends in the first 200 bytes, or if it names
/// UTF-8, UTF-16 or an unknown encoding.
fn of_xml(bytes: &[u8]) -> Option<&'static Encoding> {
    let end = bytes.iter().take(MAX_DECLARED).position(|&byte| byte == b'>')?;
    let head = std::str::from_utf8(&bytes[..end]).ok()?;
    let (_, label) = head.strip_prefix("<?xml")?.split_once("encoding")?;
    let label = label.trim_start().strip_prefix('=')?.trim_start();
    let label = label.get(1..)?.split(['\'', '"']).next()?;
    Encoding::for_label(label.as_bytes())
        .filter(|own| *own != UTF_8 && *own != UTF_16LE && *own != UTF_16BE)
}

/// The largest length of an XML declaration, in bytes.
const MAX_DECLARED: usize = 200;

/// Decodes all bytes, or returns the offset of the first invalid one.
fn strict<'a>(encoding: &'static Encoding, bytes: &'a [u8]) -> Result<Cow<'a, str>, usize> {
    if let Some(text) = encoding.decode_without_bom_handling_and_without_replacement(bytes) {
        return Ok(text);
    }
    let mut decoder = encoding.new_decoder_without_bom_handling();
    let mut sink = [0_u8; 4096];
    let mut at = 0;
    loop {
        let (result, read, _) =
            decoder.decode_to_utf8_without_replacement(&bytes[at..], &mut sink, true);
        at += read;
        match result {
            DecoderResult::Malformed(bad, after) => {
                return Err(at.saturating_sub(usize::from(bad) + usize::from(after)));
            }
            DecoderResult::InputEmpty => return Err(bytes.len()),
            DecoderResult::OutputFull => {}
        }
    }
}

fn undecodable(
    encoding: &'static Encoding,
    bytes: &[u8],
    skip: usize,
    at: usize,
    tried: &str,
) -> Undecodable {
    let before = encoding.decode_without_bom_handling(&bytes[skip..skip + at]).0;
    let lines = before.bytes().filter(|&b| b == b'\n').count();
    Undecodable {
        offset: skip + at,
        line: u32::try_from(lines + 1).unwrap_or(u32::MAX),
        tried: tried.to_owned(),
        cut: skip + at + 4 > bytes.len(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sixteen(text: &str, little: bool) -> Vec<u8> {
        text.encode_utf16()
            .flat_map(|unit| if little { unit.to_le_bytes() } else { unit.to_be_bytes() })
            .collect()
    }

    #[test]
    fn every_declared_encoding_is_read() {
        let text = "\"命令\"\t\"명령\"\r\n";
        for (mark, little) in [(&[0xFF, 0xFE], true), (&[0xFE, 0xFF], false)] {
            let bytes = [&mark[..], &sixteen(text, little)].concat();
            assert_eq!(decode(&bytes, &[]).unwrap(), text);
        }
        assert_eq!(decode(&sixteen("LD X0\n停止", true), &[]).unwrap(), "LD X0\n停止");
        assert_eq!(decode(&sixteen("LD X0\n停止", false), &[]).unwrap(), "LD X0\n停止");
        let bom = [b"\xEF\xBB\xBF", text.as_bytes()].concat();
        assert_eq!(decode(&bom, &[]).unwrap(), text);
        assert_eq!(decode(text.as_bytes(), &[]).unwrap(), text);
    }

    #[test]
    fn the_known_words_tell_the_code_pages_apart() {
        let known_words = ["命令", "指令", "명령"];
        for (encoding, text) in [
            (SHIFT_JIS, "ステップ番号,命令,ｲﾝﾀｰﾛｯｸ"),
            (GBK, "步号,指令,急停按钮"),
            (EUC_KR, "스텝,명령,비상정지"),
        ] {
            let bytes = encoding.encode(text).0;
            assert_eq!(decode(&bytes, &known_words).unwrap(), text, "{}", encoding.name());
            for limit in 0..=bytes.len() {
                beginning(&bytes, limit, &known_words);
            }
        }
    }

    #[test]
    fn a_fault_has_its_place() {
        let mut bytes = b"LD X0\nOUT Y0\n".to_vec();
        bytes.extend([0xFF, 0xFF, b'\n', b'E', b'N', b'D', b'\n']);
        let fault = decode(&bytes, &[]).unwrap_err();
        assert_eq!((fault.offset, fault.line, fault.cut), (13, 3, false));
        let mut bytes = [&[0xFF, 0xFE][..], &sixteen("a\nb\n", true)].concat();
        bytes.push(b'"');
        let fault = decode(&bytes, &[]).unwrap_err();
        assert_eq!((fault.offset, fault.line, fault.cut), (10, 3, true));
    }
}
