//! The kinds of values that instructions distinguish: a bit, a number, or a value that is not modelled.

pub(crate) use scanbound_iec_tree::types::{DINT, INT, Kind, holding};

/// The kind of a value.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Ty {
    /// A Boolean.
    Bit,
    /// A number of this kind.
    Number(Kind),
    /// A text, or a whole structure, array or instance. Its content is not modelled as one value.
    Whole,
}

/// Reason for the report where a TIME is used as another type.
pub(crate) const ANY_UNIT: &str =
    "a time is converted to another type in milliseconds or seconds: any value";

/// The size of an operand beyond one elementary value, for charging copies.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Extent {
    /// One elementary value: the charge of its load covers it.
    One,
    /// This many elements of a structure, an array or an instance.
    Elements(u64),
    /// A text of this many characters.
    Characters(u64),
}

impl Extent {
    /// The larger of two extents, for an operand that may be either.
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
