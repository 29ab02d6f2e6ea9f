//! The standard functions: their names and result types.

use crate::types::{Elementary, Kind, Type, TypeId, Types, common, holding};
use scanbound_iec::ast::Operator;

/// The source or target type in the name of a conversion.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Simple {
    /// An elementary type.
    Elementary(Elementary),
    /// A string (`STRING` or `WSTRING`).
    Text,
}

impl Simple {
    fn named(name: &str) -> Option<Simple> {
        if ["STRING", "WSTRING"].contains(&name) {
            return Some(Simple::Text);
        }
        Elementary::named(name).map(Simple::Elementary)
    }

    /// Whether it is a string type.
    #[must_use]
    pub fn is_text(self) -> bool {
        self == Simple::Text
    }

    /// Whether it is `TIME`. The number that a conversion of a time gives depends on the controller's unit:
    /// milliseconds or seconds.
    #[must_use]
    pub fn is_time(self) -> bool {
        self == Simple::Elementary(Elementary::Time)
    }

    /// Whether it is a bit string.
    #[must_use]
    pub fn is_bits(self) -> bool {
        matches!(self, Simple::Elementary(one) if one.is_bits())
    }

    fn whole(self) -> Option<(u8, bool)> {
        match self {
            Simple::Elementary(one) => match one.kind()? {
                Kind::Whole { bits, signed } => Some((bits, signed)),
                _ => None,
            },
            Simple::Text => None,
        }
    }
}

/// The kind of a shift or rotate function.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct Shift {
    /// Whether it rotates: bits that leave at one end enter at the other.
    pub rotates: bool,
    /// Whether it moves bits to the left.
    pub left: bool,
}

/// A standard function.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Function {
    /// An operator called as a function, such as `ADD` or `ADD_TIME`.
    Operator {
        /// The operator.
        operator: Operator,
        /// Whether it was called by its name for times, such as `ADD_TIME`.
        of_times: bool,
    },
    /// `MOVE`
    Move,
    /// `NOT`
    Not,
    /// `SEL`
    Sel,
    /// `MUX`
    Mux,
    /// `MAX` or `MIN`.
    Extreme {
        /// Whether it is `MAX`.
        larger: bool,
    },
    /// `LIMIT`
    Limit,
    /// `ABS`
    Abs,
    /// `SHL`, `SHR`, `ROL` or `ROR`.
    Shift(Shift),
    /// A type conversion: `X_TO_Y` or `TO_Y`.
    Convert {
        /// The source type in the name; `None` for `TO_Y`.
        from: Option<Simple>,
        /// The target type.
        to: Simple,
    },
    /// A conversion from or to BCD (four bits for each decimal digit).
    Decimal {
        /// Whether it converts from BCD; `false`: to BCD.
        reads: bool,
        /// The result type, if the name states it.
        to: Option<Simple>,
    },
    /// `SIZEOF`, `LOWER_BOUND` or `UPPER_BOUND` of a variable: the result is this constant.
    Measured(i64),
    /// A function whose result is not modelled and may be any value, with its name in capitals.
    Unfollowed(&'static str),
}

/// Functions that map a `REAL` or `LREAL` to the same type.
const OF_REALS: &[&str] =
    &["SQRT", "LN", "LOG", "EXP", "SIN", "COS", "TAN", "ASIN", "ACOS", "ATAN"];

/// Further functions whose results are not modelled and may be any value.
const UNFOLLOWED: &[&str] = &[
    "TRUNC",
    "LEN",
    "LEFT",
    "RIGHT",
    "MID",
    "CONCAT",
    "INSERT",
    "DELETE",
    "REPLACE",
    "FIND",
    "SIZEOF",
    "CONCAT_DATE_TOD",
    "TIME",
    "LTIME",
];

fn decimal(name: &str) -> Option<(bool, Option<Simple>)> {
    if let Some((digits, number)) = name.split_once("BCD_TO_") {
        let is_own = digits.is_empty() || Simple::named(digits.strip_suffix('_')?).is_some();
        return Simple::named(number).filter(|_| is_own).map(|to| (true, Some(to)));
    }
    let (number, digits) = name.split_once("_TO_BCD")?;
    Simple::named(number)?;
    match digits.strip_prefix('_') {
        Some(to) => Some((false, Some(Simple::named(to)?))),
        None => digits.is_empty().then_some((false, None)),
    }
}

impl Function {
    /// The standard function of this name, ignoring case; `None` if there is none.
    #[must_use]
    pub fn named(name: &str) -> Option<Function> {
        let upper = name.to_ascii_uppercase();
        if let Some((reads, to)) = decimal(&upper) {
            return Some(Function::Decimal { reads, to });
        }
        if let Some((from, to)) = upper.split_once("_TO_") {
            let (from, to) = (Simple::named(from)?, Simple::named(to)?);
            return Some(Function::Convert { from: Some(from), to });
        }
        if let Some(to) = upper.strip_prefix("TO_").and_then(Simple::named) {
            return Some(Function::Convert { from: None, to });
        }
        if let Some(operator) = Operator::named(&upper) {
            return Some(Function::Operator { operator, of_times: false });
        }
        let of_times = |operator| Function::Operator { operator, of_times: true };
        Some(match upper.as_str() {
            "ADD_TIME" => of_times(Operator::Add),
            "SUB_TIME" => of_times(Operator::Subtract),
            "MULTIME" => of_times(Operator::Multiply),
            "DIVTIME" => of_times(Operator::Divide),
            "MOVE" => Function::Move,
            "NOT" => Function::Not,
            "SEL" => Function::Sel,
            "MUX" => Function::Mux,
            "MAX" => Function::Extreme { larger: true },
            "MIN" => Function::Extreme { larger: false },
            "LIMIT" => Function::Limit,
            "ABS" => Function::Abs,
            "SHL" => Function::Shift(Shift { rotates: false, left: true }),
            "SHR" => Function::Shift(Shift { rotates: false, left: false }),
            "ROL" => Function::Shift(Shift { rotates: true, left: true }),
            "ROR" => Function::Shift(Shift { rotates: true, left: false }),
            other => Function::Unfollowed(
                UNFOLLOWED.iter().chain(OF_REALS).copied().find(|&own| own == other)?,
            ),
        })
    }

    /// The sort key of a named input: inputs are ordered by ascending rank. `G`, `K` and `MN` come first, then `IN`,
    /// then `IN0`, `IN1` and so on; other names come last.
    #[must_use]
    pub fn rank(name: &str) -> u32 {
        let upper = name.to_ascii_uppercase();
        match upper.strip_prefix("IN") {
            Some("") => 1,
            Some(number) => {
                number.parse::<u32>().map_or(u32::MAX, |number| number.saturating_add(2))
            }
            None if ["G", "K", "MN"].contains(&upper.as_str()) => 0,
            None => u32::MAX,
        }
    }

    /// Whether it is an operator in function form (other than `EXPT` and the functions for times), `MOVE` or `NOT`.
    /// These accept operands that do not fit the type.
    #[must_use]
    pub fn is_operator(&self) -> bool {
        match self {
            Function::Operator { operator, of_times } => *operator != Operator::Power && !of_times,
            Function::Move | Function::Not => true,
            _ => false,
        }
    }

    /// Whether its result depends on how many bits the controller keeps of an input that is wider than its type.
    #[must_use]
    pub fn shows_bits(&self) -> bool {
        match self {
            Function::Operator { operator, .. } => {
                matches!(operator, Operator::Multiply | Operator::Divide | Operator::Modulo)
            }
            Function::Shift(_) | Function::Mux | Function::Abs | Function::Decimal { .. } => true,
            Function::Convert { from, to, .. } => {
                // Some controllers extend the sign into the additional bits when they convert to a longer bit string.
                let longer = to.whole().filter(|_| to.is_bits()).map_or(0, |(bits, _)| bits);
                match from {
                    Some(from) => {
                        from.whole().is_some_and(|(bits, signed)| signed && bits < longer)
                    }
                    None => longer > 8,
                }
            }
            _ => false,
        }
    }

    /// Whether it compares its inputs or returns one of them unchanged.
    #[must_use]
    pub fn chooses(&self) -> bool {
        match self {
            Function::Extreme { .. } | Function::Limit | Function::Sel | Function::Mux => true,
            Function::Operator { operator, .. } => (4..=5).contains(&operator.binding()),
            _ => false,
        }
    }

    /// Whether its result is a single elementary value for inputs of any type.
    #[must_use]
    pub fn gives_one(&self) -> bool {
        match self {
            Function::Operator { operator, .. } => (4..=5).contains(&operator.binding()),
            Function::Measured(_) => true,
            Function::Unfollowed(name) => ["LEN", "FIND", "SIZEOF"].contains(name),
            _ => false,
        }
    }

    /// Whether it maps a `REAL` or `LREAL` to the same type.
    #[must_use]
    pub fn is_of_reals(&self) -> bool {
        matches!(self, Function::Unfollowed(name) if OF_REALS.contains(name))
    }

    /// The result type for inputs of these types.
    pub fn result(&self, types: &mut Types, inputs: &[TypeId]) -> TypeId {
        let unknown = types.id(Type::Unknown);
        let first = inputs.first().copied().unwrap_or(unknown);
        let simple = |types: &mut Types, one: Simple| match one {
            Simple::Elementary(one) => types.elementary(one),
            Simple::Text => types.id(Type::Text(crate::types::CONVERTED_TEXT)),
        };
        match self {
            Function::Operator { operator, .. } => {
                let meet = |one, two| operated(types, *operator, one, two);
                let mut all = inputs.iter().copied();
                let Some(start) = all.next() else { return unknown };
                all.fold(start, meet)
            }
            Function::Move | Function::Not | Function::Abs | Function::Shift(_) => first,
            Function::Sel | Function::Mux => joined(types, inputs.get(1..).unwrap_or_default()),
            Function::Extreme { .. } | Function::Limit => joined(types, inputs),
            Function::Convert { to, .. } => simple(types, *to),
            Function::Decimal { to, .. } => to.map_or(unknown, |to| simple(types, to)),
            Function::Measured(_) => types.id(Type::Untyped),
            Function::Unfollowed(name) => match *name {
                "TRUNC" | "LEN" | "FIND" | "SIZEOF" => types.elementary(Elementary::Dint),
                "TIME" => types.elementary(Elementary::Time),
                "LTIME" => types.elementary(Elementary::Date),
                _ if self.is_of_reals() => first,
                _ => unknown,
            },
        }
    }
}

fn joined(types: &mut Types, inputs: &[TypeId]) -> TypeId {
    let unknown = types.id(Type::Unknown);
    let mut all = inputs.iter().copied();
    let Some(first) = all.next() else { return unknown };
    all.fold(first, |one, two| meeting(types, one, two))
}

/// The common type of two values: equal types stay, numbers take [`common`], and an untyped integer takes the other
/// type; otherwise [`Type::Unknown`].
pub fn meeting(types: &mut Types, one: TypeId, two: TypeId) -> TypeId {
    if one == two {
        return one;
    }
    let unknown = types.id(Type::Unknown);
    match (types.kind(one), types.kind(two)) {
        (Some(one), Some(two)) => types.elementary(Elementary::of(common(one, two))),
        _ if *types.get(one) == Type::Untyped => two,
        _ if *types.get(two) == Type::Untyped => one,
        _ => unknown,
    }
}

/// The result type of a binary operator: `BOOL` for comparisons, otherwise the common type ([`meeting`]).
pub fn operated(types: &mut Types, operator: Operator, one: TypeId, two: TypeId) -> TypeId {
    match operator.binding() {
        4 | 5 => types.elementary(Elementary::Bool),
        _ => meeting(types, one, two),
    }
}

/// The type used to combine a value of type `of` with an integer constant: `of` if the constant fits or `of` is not a
/// number, otherwise a type that holds both.
pub fn beside(types: &mut Types, of: TypeId, value: i64) -> TypeId {
    match types.kind(of) {
        Some(kind) => {
            let holds = holding(kind, value);
            if holds == kind { of } else { types.elementary(Elementary::of(holds)) }
        }
        None => of,
    }
}
