//! What the names of contacts say: how they join, what they look for or compare.

use scanbound_ir::{Join, Relation};

/// As what a comparison contact reads its operands.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Sort {
    /// Whole numbers.
    Integer {
        /// How many words each has.
        words: usize,
        /// Whether they have a sign.
        signed: bool,
    },
    /// Real numbers.
    Real {
        /// How many words each has.
        words: usize,
    },
    /// Strings.
    Text,
    /// Dates or times of day, three words each, and which parts of them.
    Clock,
}

/// How a contact joins, whether it looks for an edge (rising or falling), whether it is negated.
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

/// The relation of a symbol.
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

/// Splits a comparison contact into how it joins, what it compares, and the relation.
pub(super) fn compared(mnemonic: &str) -> Option<(Join, Sort, Relation)> {
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
        ("", _) => Sort::Integer { words: 1, signed: !unsigned },
        ("D", _) => Sort::Integer { words: 2, signed: !unsigned },
        ("E", false) => Sort::Real { words: 2 },
        ("ED", false) => Sort::Real { words: 4 },
        ("$", false) => Sort::Text,
        ("DT" | "TM", false) => Sort::Clock,
        _ => return None,
    };
    Some((join, sort, relation))
}
