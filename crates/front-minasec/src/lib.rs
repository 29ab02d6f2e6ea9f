//! The MINASEC-U, a PLC made of 74HC logic ICs: eight instructions, 32 one-bit devices, 256 words that all run in each
//! scan.
//!
//! The source is the machine's description, 「PLCのつくりかた」 (Minagi Yū, first edition, August 2025): the encoding from its
//! chapter on the instruction set, the devices from its table of element names and the counter circuit. That table
//! exchanges the words input and output for X and Y; the text, the terminals and the machine code of the test program
//! do not, and this crate follows them.

pub mod assembly;
pub mod decode;
pub mod machine_code;
mod source;
mod word;

pub use source::{ASSEMBLY, BINARY, HEX, Source};
pub use word::{Device, DeviceKind, Opcode, WORDS, Word};

use scanbound_base::code::Code;
use scanbound_base::diagnostic::Diagnostic;
use scanbound_front::{
    Dialect, Front, Input, MachineOptions, Options, Project, Sniff, SourceOptions, decoded,
};
use scanbound_ir::Program;

/// The dialects, and how each is recognised.
static DIALECTS: [Dialect; 3] = [
    Dialect {
        name: ASSEMBLY,
        what: "MINASEC-U assembly (LD X00, ST Y00)",
        sniff: Sniff::Text(assembly::sniff),
    },
    Dialect {
        name: HEX,
        what: "MINASEC-U machine code as Intel HEX",
        sniff: Sniff::Text(machine_code::sniff_hex),
    },
    Dialect {
        name: BINARY,
        what: "MINASEC-U machine code, 256 bytes",
        sniff: Sniff::Bytes(machine_code::is_image),
    },
];

/// Reads MINASEC-U programs: the implementation of [`Front`] for the three dialects.
pub struct Minasec;

/// The value of [`Minasec`] that the list of all fronts contains.
pub const FRONT: Minasec = Minasec;

impl Front for Minasec {
    fn dialects(&self) -> &'static [Dialect] {
        &DIALECTS
    }

    fn read(
        &self,
        dialect: &Dialect,
        programs: &[&Input],
        _beside: &[&Input],
        _reading: SourceOptions,
    ) -> Result<Box<dyn Project>, Vec<Diagnostic>> {
        Ok(Box::new(read(dialect, programs)?))
    }
}

impl Project for Source {
    fn cpu(&self) -> Option<&str> {
        Some(decode::CPU)
    }

    fn machine_options(&self) -> MachineOptions {
        MachineOptions { clock: true, ..MachineOptions::default() }
    }

    fn decode(&self, _options: &Options<'_>) -> Result<Program, Vec<Diagnostic>> {
        Ok(decode::decode(self))
    }
}

/// Reads the only file.
///
/// # Errors
/// The errors of the file, or that there is more than one file.
fn read(dialect: &Dialect, files: &[&Input]) -> Result<Source, Vec<Diagnostic>> {
    let Some((input, rest)) = files.split_first() else { return Err(Vec::new()) };
    if let Some(second) = rest.first() {
        return Err(vec![Diagnostic::file(
            Code::TwoPrograms,
            &second.name,
            format!("a MINASEC-U runs one program, but {} is a second program", input.name),
            "give one file",
        )]);
    }
    match dialect.name {
        BINARY => machine_code::read_binary(&input.name, &input.bytes),
        HEX => {
            machine_code::read_hex(&input.name, &decoded(input, &[]).map_err(|fault| vec![fault])?)
        }
        _ => assembly::read(&input.name, &decoded(input, &[]).map_err(|fault| vec![fault])?),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_named_dialect_takes_a_shorter_image() {
        let input = |bytes: &[u8]| [Input { name: "a".to_owned(), bytes: bytes.to_vec() }];
        let fronts = scanbound_front::Fronts(&[&FRONT]);
        let read =
            |bytes: &[u8]| fronts.read(&input(bytes), Some(BINARY), SourceOptions::default());
        let source: Source = read(&[0x01, 0xC8]).expect("an image").downcast().expect("its own");
        assert_eq!(source.words[1].to_string(), "ST Y00");
        assert!(read(&[]).is_err());
    }
}
