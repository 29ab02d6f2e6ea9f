//! Reads symbol tables of CX-Programmer: one symbol a line, with name, type, address and comment separated by tabs.

use super::source::{Symbol, Symbols};
use scanbound_base::code::Code;
use scanbound_front::Faults;

/// Data types, without array bounds.
const TYPES: [&str; 18] = [
    "BOOL",
    "CHANNEL",
    "NUMBER",
    "WORD",
    "DWORD",
    "LWORD",
    "INT",
    "DINT",
    "LINT",
    "UINT",
    "UDINT",
    "ULINT",
    "UINT_BCD",
    "UDINT_BCD",
    "ULINT_BCD",
    "REAL",
    "LREAL",
    "STRING",
];
/// The types of timers and counters. The address of such a symbol is its number.
const TIMES: [&str; 2] = ["TIMER", "COUNTER"];
/// The number of lines that are examined to recognise a file.
const LOOKED_AT: usize = 50;

/// Whether the beginning of a file looks like a symbol table: each of its first 50 lines is a symbol, except perhaps
/// the first one (headings) and the last one (which may be cut off).
pub(super) fn sniff(beginning: &str) -> bool {
    let lines = beginning.lines().filter(|line| !line.trim().is_empty()).take(LOOKED_AT);
    let fits: Vec<bool> = lines.map(|line| symbol(line).is_some()).collect();
    // Only the beginning was read, so the last line may be incomplete.
    let whole = fits.len().saturating_sub(1).max(1);
    fits.contains(&true) && fits.iter().take(whole).skip(1).all(|&fits| fits)
}

/// Adds the symbols of the table to `symbols`. Reports lines that are not symbols (except the first, which may be a
/// heading), and symbols that are defined twice with different addresses.
pub(super) fn read(text: &str, symbols: &mut Symbols, faults: &mut Faults<'_>) {
    for (line, number) in text.lines().zip(1..) {
        let Some((name, symbol)) = symbol(line) else {
            if number > 1 && !line.trim().is_empty() {
                let message = "this line is not a symbol: it must have a name, a known data type and an address, separated by tabs";
                faults.error_in_line(
                    Code::NoSymbol,
                    number,
                    line,
                    message,
                    "export the symbol table again",
                );
            }
            continue;
        };
        let known = symbols.entry(name).or_insert_with(|| symbol.clone());
        if known.address != symbol.address {
            let message = format!(
                "the symbol is defined twice, with different addresses: its other address is {}",
                known.address
            );
            faults.error_in_line(
                Code::SymbolTwice,
                number,
                line,
                &message,
                "export the symbol table again",
            );
        }
    }
}

fn symbol(line: &str) -> Option<(String, Symbol)> {
    let mut cells = line.split('\t').map(|cell| cell.trim().trim_matches('"'));
    let (name, kind, address) = (cells.next()?, cells.next()?, cells.next()?);
    let comment = cells.next().unwrap_or_default();
    let upper = kind.to_ascii_uppercase();
    let plain = upper.split(['[', '(']).next().unwrap_or_default().trim();
    let timed = TIMES.iter().position(|time| *time == plain);
    (!name.is_empty() && (TYPES.contains(&plain) || timed.is_some())).then(|| {
        let bare = address.bytes().all(|b| b.is_ascii_digit()) && !address.is_empty();
        let address = match timed {
            Some(time) if bare => format!("{}{address}", ["T", "C"][time]),
            _ => address.to_owned(),
        };
        let (kind, comment) = (kind.to_owned(), comment.to_owned());
        (name.to_owned(), Symbol { address, kind, comment })
    })
}
