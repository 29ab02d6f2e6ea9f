//! Reads and writes MINASEC-U machine code: the 256 bytes of program memory, as bytes or Intel HEX.

use super::source::{BINARY, HEX, Source};
use super::word::{WORDS, Word};
use ihex::Record;
use scanbound_base::code::Code;
use scanbound_base::diagnostic::Diagnostic;
use scanbound_front::Faults;

/// The number of bytes in each record of a written file.
const RECORD: usize = 16;

/// The sizes of the memory ICs that fit the board (HM6116, HM6264, HM62256). The board connects address lines from A8
/// on to ground, so only the first 256 bytes are the program.
const CHIPS: [usize; 3] = [2048, 8192, 32_768];

/// Whether a file is the program memory (256 bytes) or a whole memory IC (2048, 8192 or 32,768 bytes): it has one of
/// these lengths, a byte that no text has among the first 256, and no byte order mark, and the part that the board
/// cannot reach is empty (all 0 or all FF) or repeats the reachable part.
#[must_use]
pub fn is_image(bytes: &[u8]) -> bool {
    if CHIPS.contains(&bytes.len()) {
        return is_image(&bytes[..WORDS]) && unreachable(bytes).is_none();
    }
    let byte_order_mark = bytes.starts_with(&[0xFF, 0xFE]) || bytes.starts_with(&[0xFE, 0xFF]);
    bytes.len() == WORDS
        && !byte_order_mark
        && bytes
            .iter()
            .any(|&byte| byte < 0x20 && !matches!(byte, b'\t' | b'\n' | b'\r' | 0x0C | 0x1A))
}

/// The index of the first byte of a memory IC that the board cannot reach and that differs from the reachable byte with
/// the same low address. `None` if there is none, or if all unreachable bytes are 0, or all are FF.
fn unreachable(bytes: &[u8]) -> Option<usize> {
    let uniform = |value: u8| bytes[WORDS..].iter().all(|&byte| byte == value);
    if uniform(0) || uniform(0xFF) {
        return None;
    }
    (WORDS..bytes.len()).find(|&at| bytes[at] != bytes[at % WORDS])
}

/// Whether a file begins like Intel HEX: its first eight lines, blank ones aside, are a colon and at least ten
/// hexadecimal digits.
pub(super) fn sniff_hex(beginning: &str) -> bool {
    let mut lines = beginning.lines().map(str::trim).filter(|line| !line.is_empty()).peekable();
    lines.peek().is_some()
        && lines.take(8).all(|line| {
            line.strip_prefix(':')
                .is_some_and(|rest| rest.len() >= 10 && rest.bytes().all(|b| b.is_ascii_hexdigit()))
        })
}

/// Reads the bytes of program memory: at most 256, or those of a whole memory IC, of which only the first 256 are the
/// program. Missing bytes are empty.
///
/// # Errors
/// There is no byte; there are more bytes, but not those of a memory IC; the unreachable part of a memory IC has other
/// contents; or a byte is a store to an input.
pub fn read_binary(name: &str, bytes: &[u8]) -> Result<Source, Vec<Diagnostic>> {
    let mut faults = Faults::new(name);
    let mut source = Source::new(name, BINARY);
    if bytes.is_empty() {
        faults.push(Diagnostic::file(
            Code::EmptyFile,
            name,
            "the file is empty",
            "assemble the program again",
        ));
    }
    let rest = CHIPS.contains(&bytes.len()).then(|| unreachable(bytes));
    if let Some(Some(at)) = rest {
        faults.push(Diagnostic::file(
            Code::Unreachable,
            name,
            format!("the byte at address {at} is not empty, but the board cannot execute it"),
            "give only the first 256 bytes of the memory: the program counter has eight bits",
        ));
    } else if bytes.len() > WORDS && rest.is_none() {
        faults.push(Diagnostic::file(
            Code::TooLong,
            name,
            format!("the file has {} bytes, but the program memory has 256 words", bytes.len()),
            "give the memory's first 256 bytes, or a whole memory IC of 2048, 8192 or 32768 bytes",
        ));
    }
    for (address, &byte) in bytes.iter().take(WORDS).enumerate() {
        store(&mut source, address, byte, address as u32 + 1, &mut faults);
    }
    if faults.any_error() { Err(faults.into_diagnostics()) } else { Ok(source) }
}

/// Reads Intel HEX: data records with addresses below 256, and an end-of-file record. Bytes above may follow only if
/// they are empty (0 or FF) and fill a memory IC to its end.
///
/// # Errors
/// The errors with their lines, at most 50. Reading stops at a record after the end-of-file record.
pub fn read_hex(name: &str, text: &str) -> Result<Source, Vec<Diagnostic>> {
    let mut faults = Faults::new(name);
    let mut source = Source::new(name, HEX);
    let mut ended = false;
    // The first unreachable byte, preferably one that is not empty; and the end of the memory.
    let mut outside: Option<(u32, &str, usize, bool)> = None;
    let mut end = 0;
    let mut number = 0_u32;
    for line in text.lines() {
        number = number.saturating_add(1);
        let record = line.trim();
        if record.is_empty() {
            continue;
        }
        if ended {
            faults.error_in_line(
                Code::BehindTheEnd,
                number,
                line,
                "this record comes after the end-of-file record",
                "give each program a file of its own",
            );
            break;
        }
        match Record::from_record_string(record) {
            Ok(Record::Data { offset, value }) => {
                for (address, byte) in (usize::from(offset)..).zip(value) {
                    if address < WORDS {
                        store(&mut source, address, byte, number, &mut faults);
                        continue;
                    }
                    end = end.max(address + 1);
                    let empty = matches!(byte, 0 | 0xFF);
                    if !empty || outside.is_none() {
                        outside =
                            outside.filter(|_| empty).or(Some((number, line, address, empty)));
                    }
                }
            }
            Ok(Record::EndOfFile) => ended = true,
            // Some tools write an upper address of 0 before a small image.
            Ok(Record::ExtendedLinearAddress(0) | Record::ExtendedSegmentAddress(0)) => {}
            Ok(_) => faults.error_in_line(
                Code::HexRecord,
                number,
                line,
                "this record is not data, an end of file or an upper address of 0",
                "write data records (type 00) and an end-of-file record (type 01)",
            ),
            Err(error) => faults.error_in_line(
                Code::HexRecord,
                number,
                line,
                &format!("not an Intel HEX record: {error}"),
                "write the file again: it was changed by hand or is truncated",
            ),
        }
    }
    if let Some((number, line, address, empty)) = outside
        && !(empty && CHIPS.contains(&end))
    {
        faults.error_in_line(
            Code::TooLong,
            number,
            line,
            &format!("address {address} is outside the program memory"),
            "use addresses 0 to 255: the program counter has eight bits",
        );
    }
    if !ended && !faults.any_error() {
        faults.push(Diagnostic::file(
            Code::NoEnd,
            name,
            "the end-of-file record is missing",
            "write the file again: it is truncated",
        ));
    }
    if faults.any_error() { Err(faults.into_diagnostics()) } else { Ok(source) }
}

fn store(source: &mut Source, address: usize, byte: u8, line: u32, faults: &mut Faults<'_>) {
    let word = Word(byte);
    if word.stores_to_input() {
        faults.error_in_line(
            Code::StoreToInput,
            line,
            &word.to_string(),
            &format!("word {address} writes to the input {}", word.device()),
            "an input cannot be written: if the program does not have this word, it is left from before: clear the program memory, then write the program again",
        );
    }
    if let Some(first) = source.lines.insert(address as u8, line) {
        faults.error_in_line(
            Code::WordTwice,
            line,
            &word.to_string(),
            &format!("line {first} already has address {address}"),
            "give each address once",
        );
    }
    source.words[address] = word;
}

/// Writes the whole program memory as Intel HEX.
#[must_use]
pub fn write_hex(words: &[Word; WORDS]) -> String {
    let bytes = words.map(|word| word.0);
    let mut records: Vec<Record> = bytes
        .chunks(RECORD)
        .enumerate()
        .map(|(row, chunk)| Record::Data { offset: (row * RECORD) as u16, value: chunk.to_vec() })
        .collect();
    records.push(Record::EndOfFile);
    ihex::create_object_file_representation(&records)
        .expect("records of 16 bytes that end with an end-of-file record are well formed")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::assembly;

    #[test]
    fn a_whole_memory_ic_is_read_where_the_rest_says_nothing() {
        let image = image();
        for length in CHIPS {
            for fill in [Some(0), Some(0xFF), None] {
                let bytes: Vec<u8> = (0..length)
                    .map(
                        |at| if at < WORDS { image[at] } else { fill.unwrap_or(image[at % WORDS]) },
                    )
                    .collect();
                assert!(is_image(&bytes));
                let source = read_binary("a.bin", &bytes).expect("a program");
                assert_eq!(source.words.map(|word| word.0), image);
                let mut other = bytes.clone();
                other[length - 1] = 0x55;
                assert!(!is_image(&other));
                assert_eq!(
                    read_binary("a.bin", &other).expect_err("refused")[0].code.name(),
                    "unreachable"
                );
            }
        }
        let odd = vec![0; 1000];
        assert_eq!(read_binary("a.bin", &odd).expect_err("refused")[0].code.name(), "too-long");
    }

    /// A program with every word except stores to an input.
    fn image() -> [u8; WORDS] {
        let mut bytes = [0; WORDS];
        for (at, byte) in bytes.iter_mut().enumerate() {
            let word = Word(at as u8);
            *byte = if word.stores_to_input() { 0 } else { word.0 };
        }
        bytes
    }

    fn codes(found: Result<Source, Vec<Diagnostic>>) -> Vec<(&'static str, Option<u32>)> {
        found.expect_err("faults").iter().map(|fault| (fault.code.name(), fault.line)).collect()
    }

    #[test]
    fn bytes_hex_and_assembly_give_the_same_memory() {
        let bytes = image();
        let binary = read_binary("a.bin", &bytes).expect("an image");
        assert_eq!(binary.bytes(), bytes);
        let hex = write_hex(&binary.words);
        assert!(sniff_hex(&hex));
        assert_eq!(read_hex("a.hex", &hex).expect("hex").bytes(), bytes);
        assert_eq!(
            assembly::read("a.asm", &assembly::write(&binary.words)).expect("asm").bytes(),
            bytes
        );
        assert!(is_image(&bytes));
    }

    #[test]
    fn hex_is_written_as_the_format_has_it() {
        let mut bytes = [0; WORDS];
        bytes[1] = 0x88;
        let hex = write_hex(&read_binary("a.bin", &bytes).expect("an image").words);
        let lines: Vec<&str> = hex.lines().collect();
        assert_eq!(lines.len(), 17);
        assert_eq!(lines[0], ":100000000088000000000000000000000000000068");
        assert_eq!(lines[16], ":00000001FF");
    }

    #[test]
    fn broken_images_are_refused() {
        assert_eq!(codes(read_binary("a.bin", &[])), [("empty-file", None)]);
        assert_eq!(codes(read_binary("a.bin", &[0; 257])), [("too-long", None)]);
        assert_eq!(codes(read_binary("a.bin", &[0, 0xC0])), [("store-to-input", Some(2))]);
        assert_eq!(codes(read_hex("a.hex", "")), [("no-end", None)]);
        assert_eq!(codes(read_hex("a.hex", ":0100000088FF\n")), [("hex-record", Some(1))]);
        assert_eq!(codes(read_hex("a.hex", ":01010000886C\n")).len(), 1);
        assert_eq!(codes(read_hex("a.hex", ":010100000")), [("hex-record", Some(1))]);
        let beyond = ihex::create_object_file_representation(&[
            Record::Data { offset: 256, value: vec![0] },
            Record::EndOfFile,
        ]);
        assert_eq!(
            codes(read_hex("a.hex", &beyond.expect("well formed"))),
            [("too-long", Some(1))]
        );
        let twice = ihex::create_object_file_representation(&[
            Record::Data { offset: 0, value: vec![0] },
            Record::Data { offset: 0, value: vec![0] },
            Record::EndOfFile,
        ]);
        assert_eq!(
            codes(read_hex("a.hex", &twice.expect("well formed"))),
            [("word-twice", Some(2))]
        );
    }
}
