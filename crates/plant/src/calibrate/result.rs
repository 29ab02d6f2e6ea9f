//! Readings from the CPU: values of data registers, from programming software or from a connection.

use scanbound_base::code::Code;
use scanbound_base::diagnostic::Diagnostic;
use std::collections::BTreeMap;

/// Values of data registers.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Words(pub BTreeMap<u32, u16>);

/// Reads a file of rows that begin with a register (`D1100`) and contain the values of it and the following registers:
/// the format that [`write()`] writes and in which programming software exports device memory. Other rows are ignored.
///
/// # Errors
/// There is no such row, or a value is not a 16-bit number.
pub fn read(name: &str, bytes: &[u8]) -> Result<Words, Vec<Diagnostic>> {
    let text = text(bytes);
    let mut words = BTreeMap::new();
    let mut faults = Vec::new();
    for (number, line) in (1..).zip(text.lines()) {
        let cells = line.split(['\t', ',', ';']).map(|cell| cell.trim().trim_matches('"').trim());
        let mut cells = cells.filter(|cell| !cell.is_empty());
        let Some(first) = cells.next().and_then(register) else { continue };
        for (cell, at) in cells.zip(first..) {
            match value(cell) {
                Some(word) => drop(words.insert(at, word)),
                None => {
                    let message = format!("D{at} is `{cell}`, which is not a 16-bit number");
                    let help = "export the registers as decimal numbers of 16 bits";
                    faults.push(Diagnostic::line(Code::Capture, name, number, line, message, help));
                    break;
                }
            }
        }
    }
    if faults.is_empty() && words.is_empty() {
        let message = "no row begins with a data register";
        let help = "export the device memory of the registers that scanbound calibrate write named";
        faults.push(Diagnostic::file(Code::Capture, name, message, help));
    }
    if faults.is_empty() { Ok(Words(words)) } else { Err(faults) }
}

fn text(bytes: &[u8]) -> String {
    let (encoding, _) = encoding_rs::Encoding::for_bom(bytes).unwrap_or((encoding_rs::UTF_8, 0));
    encoding.decode(bytes).0.into_owned()
}

fn register(cell: &str) -> Option<u32> {
    let digits = cell.strip_prefix(['D', 'd'])?;
    let all = !digits.is_empty() && digits.bytes().all(|byte| byte.is_ascii_digit());
    all.then(|| digits.parse().ok())?
}

fn value(cell: &str) -> Option<u16> {
    if let Some(digits) = cell.strip_prefix(['H', '#']) {
        return u16::from_str_radix(digits, 16).ok();
    }
    let number: i32 = cell.trim_start_matches(['K', '&']).parse().ok()?;
    u16::try_from(number).ok().or_else(|| i16::try_from(number).ok().map(i16::cast_unsigned))
}

/// The rows for these registers, ten values each.
#[must_use]
pub fn write(first: u32, words: &[u16]) -> String {
    let row = |(row, words): (u32, &[u16])| {
        let values: String = words.iter().map(|word| format!(",{word}")).collect();
        format!("D{}{values}\n", first + 10 * row)
    };
    (0..).zip(words.chunks(10)).map(row).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_are_read_as_they_are_written_and_as_software_exports_them() {
        let words: Vec<u16> = (0..25).map(|n| n * 1000).collect();
        let text = write(1100, &words);
        assert_eq!(text.lines().count(), 3);
        let read_back = read("r.csv", text.as_bytes()).expect("it is read");
        let expected: BTreeMap<u32, u16> = (1100..).zip(words).collect();
        assert_eq!(read_back.0, expected);
        let exported =
            "\"Device Memory\"\r\n\"Device\"\t\"+0\"\t\"+1\"\r\n\"D1100\"\t\"-1\"\t\"H7FFF\"\r\n";
        let utf_16: Vec<u8> = [0xFF, 0xFE]
            .into_iter()
            .chain(exported.encode_utf16().flat_map(u16::to_le_bytes))
            .collect();
        let read_back = read("r.csv", &utf_16).expect("it is read");
        assert_eq!(read_back.0, [(1100, 0xFFFF), (1101, 0x7FFF)].into());
    }

    #[test]
    fn what_is_no_result_is_told() {
        assert!(read("r.csv", b"a,b\n1,2\n").is_err());
        let faults = read("r.csv", b"D1100,1,2\nD1110,70000\n").expect_err("a fault");
        assert!(faults[0].message.contains("D1110"), "{faults:?}");
    }
}
