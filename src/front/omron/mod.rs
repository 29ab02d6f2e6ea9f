//! The OMRON dialects: mnemonics in the C200H's and in CX-Programmer's spelling, and CX-Programmer's text files.

mod assembly;
mod catalog;
mod cxt;
mod data;
mod decode;
mod emit;
mod exact;
mod layout;
mod list;
mod loops;
mod memory;
mod named;
mod operand;
pub mod project;
mod resolve;
pub mod source;
mod symbols;
#[cfg(test)]
mod tests;
mod timers;
mod words;

use super::Dialect;

pub use decode::{DecodeOptions, decode};

/// Whether the beginning of a file is that of a table of symbols.
pub(super) fn is_symbols(beginning: &str) -> bool {
    symbols::sniff(beginning)
}

/// The name of the C200H's spelling.
const C: &str = "omron-c200h";
/// The name of CX-Programmer's spelling.
const CX: &str = "omron-cx";
/// The name of CX-Programmer's text files.
const CXT: &str = "omron-cxt";

/// The dialects, as they are told from each other.
pub(super) const DIALECTS: [Dialect; 3] = [
    Dialect {
        name: C,
        what: "OMRON mnemonics as for C200H (LD NOT 00300, MOV(21))",
        sniff: list::sniff_c,
    },
    Dialect {
        name: CX,
        what: "OMRON mnemonics as in CX-Programmer (LDNOT 0.00, MOV(021))",
        sniff: list::sniff_cx,
    },
    Dialect { name: CXT, what: "a CX-Programmer project saved as text (.cxt)", sniff: cxt::sniff },
];
