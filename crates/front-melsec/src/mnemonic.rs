//! Parses the mnemonics of contacts: how they are connected, which edge they detect, what they compare.

use scanbound_ir::{Join, Relation};

/// The type of the two operands of a comparison contact.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum OperandType {
    Integer {
        /// The number of words of each operand.
        words: usize,
        /// Whether the operands are signed.
        signed: bool,
    },
    /// Real numbers.
    Real {
        /// The number of words of each operand.
        words: usize,
    },
    /// Character strings.
    Text,
    /// Dates or times of day, three words each.
    Clock,
}

/// For the mnemonic of a contact: how it is combined with the result so far, which edge it detects (`Some(true)`:
/// rising, `Some(false)`: falling), and whether it is negated. `None` if it is not a contact.
pub(super) fn contact(mnemonic: &str) -> Option<(Join, Option<bool>, bool)> {
    let (join, rest) = if let Some(rest) = mnemonic.strip_prefix("LD") {
        (Join::Load, rest)
    } else if mnemonic == "ANI" {
        (Join::And, "I")
    } else if let Some(rest) = mnemonic.strip_prefix("AND") {
        (Join::And, rest)
    } else if let Some(rest) = mnemonic.strip_prefix("OR") {
        (Join::Or, rest)
    } else {
        return None;
    };
    Some(match rest {
        "" => (join, None, false),
        "I" if mnemonic != "ANDI" => (join, None, true),
        "P" => (join, Some(true), false),
        "F" => (join, Some(false), false),
        "PI" => (join, Some(true), true),
        "FI" => (join, Some(false), true),
        _ => return None,
    })
}

/// The relation of a comparison symbol such as `>=`. `None` for any other text.
pub(super) fn relation(symbol: &str) -> Option<Relation> {
    Some(match symbol {
        "=" => Relation::Equal,
        "<>" => Relation::NotEqual,
        "<" => Relation::Less,
        "<=" | "=<" => Relation::LessOrEqual,
        ">" => Relation::Greater,
        ">=" | "=>" => Relation::GreaterOrEqual,
        _ => return None,
    })
}

/// Splits the mnemonic of a comparison contact (`ANDD>=`) into its connection, operand type and relation. `None` if it
/// is not one.
pub(super) fn compared(mnemonic: &str) -> Option<(Join, OperandType, Relation)> {
    let at = mnemonic.find(['=', '<', '>'])?;
    let (head, rest) = mnemonic.split_at(at);
    let (symbol, unsigned) = match rest.strip_suffix("_U") {
        Some(symbol) => (symbol, true),
        None => (rest, false),
    };
    let relation = relation(symbol)?;
    let (join, kind) = if let Some(kind) = head.strip_prefix("LD") {
        (Join::Load, kind)
    } else if let Some(kind) = head.strip_prefix("AND") {
        (Join::And, kind)
    } else {
        (Join::Or, head.strip_prefix("OR")?)
    };
    let sort = match (kind, unsigned) {
        ("", _) => OperandType::Integer { words: 1, signed: !unsigned },
        ("D", _) => OperandType::Integer { words: 2, signed: !unsigned },
        ("E", false) => OperandType::Real { words: 2 },
        ("ED", false) => OperandType::Real { words: 4 },
        ("$", false) => OperandType::Text,
        ("DT" | "TM", false) => OperandType::Clock,
        _ => return None,
    };
    Some((join, sort, relation))
}
