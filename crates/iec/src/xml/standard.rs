//! Blocks of the standard: they write nothing but what they put out.

use crate::same;

const BLOCKS: &[&str] = &["TON", "TOF", "TP", "CTU", "CTD", "CTUD", "R_TRIG", "F_TRIG", "SR", "RS"];

const FUNCTIONS: &[&str] = &[
    "ADD", "SUB", "MUL", "DIV", "MOD", "EXPT", "MOVE", "ADD_TIME", "SUB_TIME", "MULTIME",
    "DIVTIME", "AND", "OR", "XOR", "NOT", "GT", "GE", "EQ", "NE", "LE", "LT", "SEL", "MUX", "MIN",
    "MAX", "LIMIT", "SHL", "SHR", "ROL", "ROR", "ABS", "SQRT", "LN", "LOG", "EXP", "SIN", "COS",
    "TAN", "ASIN", "ACOS", "ATAN", "TRUNC", "LEN", "LEFT", "RIGHT", "MID", "CONCAT", "INSERT",
    "DELETE", "REPLACE", "FIND",
];

/// Whether a block of this type is one of the standard's own.
pub(super) fn is_standard(name: &str, has_instance: bool) -> bool {
    if has_instance {
        return BLOCKS.iter().any(|own| same(own, name));
    }
    let upper = name.to_ascii_uppercase();
    let is_word = upper.chars().all(|c| c.is_ascii_alphanumeric() || c == '_');
    !is_word
        || FUNCTIONS.contains(&upper.as_str())
        || upper.contains("_TO_")
        || upper.starts_with("TO_")
}
