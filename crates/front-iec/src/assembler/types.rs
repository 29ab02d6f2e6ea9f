//! What values are, as far as instructions need it: one bit, a number of a kind, or something that is not followed.

pub(crate) use scanbound_iec_tree::types::{DINT, INT, Kind, TEXT, holding};

/// What a value is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Ty {
    /// A truth value.
    Bit,
    /// A number.
    Number(Kind),
    /// Text, or a whole, whose content is not followed.
    Whole,
}

/// What is told where a time is a number of another type.
pub(crate) const ANY_UNIT: &str =
    "a time as a number of another type, in milliseconds or seconds: any value";

/// What an operand moves besides what its load is charged.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Extent {
    /// No more: it is one elementary value.
    One,
    /// So many elements of a structure, an array or an instance.
    Elements(u64),
    /// So many characters.
    Characters(u64),
}

impl Extent {
    /// One of two of which it is not told which is meant.
    pub(crate) fn larger(self, other: Extent) -> Extent {
        use Extent::{Characters, Elements, One};
        match (self, other) {
            (One, other) | (other, One) => other,
            (Characters(one), Characters(two)) => Characters(one.max(two)),
            (Characters(one) | Elements(one), Characters(two) | Elements(two)) => {
                Elements(one.max(two))
            }
        }
    }

    pub(crate) fn and(self, other: Extent) -> Extent {
        use Extent::{Characters, Elements, One};
        match (self, other) {
            (One, other) | (other, One) => other,
            (Characters(one), Characters(two)) => Characters(one.saturating_add(two)),
            (Characters(one) | Elements(one), Characters(two) | Elements(two)) => {
                Elements(one.saturating_add(two))
            }
        }
    }
}
