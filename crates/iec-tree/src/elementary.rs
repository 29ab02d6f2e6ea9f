//! The elementary types of the standard, and the number formats used to compute with them.

/// The format of a number in computations: its width and interpretation. A time is a count of 0.5 ms in 32 bits.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Kind {
    /// An integer or a bit string.
    Whole {
        /// The number of bits.
        bits: u8,
        /// Whether it is signed (two's complement).
        signed: bool,
    },
    /// `REAL`
    Real,
    /// `TIME`
    Time,
    /// A long real or a date, whose arithmetic is not modelled; the width is in words of 16 bits.
    Opaque(u8),
}

/// `INT`
pub const INT: Kind = Kind::Whole { bits: 16, signed: true };
/// `DINT`
pub const DINT: Kind = Kind::Whole { bits: 32, signed: true };

impl Kind {
    /// The number of 16-bit words it occupies.
    #[must_use]
    pub fn words(self) -> u32 {
        match self {
            Kind::Whole { bits, .. } => u32::from(bits.div_ceil(16)),
            Kind::Real | Kind::Time => 2,
            Kind::Opaque(words) => u32::from(words),
        }
    }

    /// Whether it can be negative: all kinds but unsigned integers.
    #[must_use]
    pub fn is_signed(self) -> bool {
        !matches!(self, Kind::Whole { signed: false, .. })
    }
}

/// The kind used to combine a number of this kind with an integer constant: `kind` itself if the constant fits or if it
/// is not an integer kind, otherwise a wider signed kind, or [`Kind::Opaque`] beyond 64 bits.
#[must_use]
pub fn holding(kind: Kind, value: i64) -> Kind {
    let Kind::Whole { bits, signed } = kind else { return kind };
    let (least, most) = match signed {
        true => (-(1_i128 << (bits - 1)), (1 << (bits - 1)) - 1),
        false => (0, (1 << bits) - 1),
    };
    let fits = |bits: u32| (-(1_i128 << (bits - 1))..1 << (bits - 1)).contains(&value.into());
    match value {
        value if (least..=most).contains(&value.into()) => kind,
        _ if bits < 32 && fits(32) => DINT,
        _ if bits < 64 => Kind::Whole { bits: 64, signed: true },
        _ => Kind::Opaque(4),
    }
}

/// The kind to which two operands are converted: the wider one. Integers of different signedness become a signed kind
/// that holds both, or [`Kind::Opaque`] beyond 64 bits.
#[must_use]
pub fn common(one: Kind, two: Kind) -> Kind {
    let rank = |kind: Kind| match kind {
        Kind::Whole { bits, .. } => u32::from(bits),
        Kind::Time => 100,
        Kind::Real => 200,
        Kind::Opaque(_) => 300,
    };
    match (one, two) {
        (Kind::Whole { bits, signed }, Kind::Whole { bits: other, signed: also })
            if signed != also =>
        {
            let (with_sign, without) = if signed { (bits, other) } else { (other, bits) };
            if with_sign > without {
                return Kind::Whole { bits: with_sign, signed: true };
            }
            // A signed kind that holds both must be twice as wide; there is none above 64 bits.
            match bits.max(other) {
                64.. => Kind::Opaque(4),
                bits => Kind::Whole { bits: bits * 2, signed: true },
            }
        }
        _ if rank(one) >= rank(two) => one,
        _ => two,
    }
}

/// The elementary types of the standard except strings.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
#[allow(missing_docs, reason = "their names are the standard's")]
pub enum Elementary {
    Bool,
    Sint,
    Int,
    Dint,
    Lint,
    Usint,
    Uint,
    Udint,
    Ulint,
    Byte,
    Word,
    Dword,
    Lword,
    Real,
    Lreal,
    Time,
    /// A long time (`LTIME`), a date or a time of day.
    Date,
}

impl Elementary {
    /// All types, in the order of their type ids.
    pub const ALL: [Elementary; 17] = [
        Elementary::Bool,
        Elementary::Sint,
        Elementary::Int,
        Elementary::Dint,
        Elementary::Lint,
        Elementary::Usint,
        Elementary::Uint,
        Elementary::Udint,
        Elementary::Ulint,
        Elementary::Byte,
        Elementary::Word,
        Elementary::Dword,
        Elementary::Lword,
        Elementary::Real,
        Elementary::Lreal,
        Elementary::Time,
        Elementary::Date,
    ];

    /// The type of this name, ignoring case; `None` if there is none. `CHAR` and `WCHAR` are treated as unsigned
    /// integers.
    #[must_use]
    pub fn named(name: &str) -> Option<Elementary> {
        use Elementary as E;
        Some(match name.to_ascii_uppercase().as_str() {
            "BOOL" | "BIT" => E::Bool,
            "SINT" => E::Sint,
            "INT" => E::Int,
            "DINT" => E::Dint,
            "LINT" => E::Lint,
            "USINT" | "CHAR" => E::Usint,
            "BYTE" => E::Byte,
            "UINT" | "WCHAR" => E::Uint,
            "WORD" => E::Word,
            "UDINT" => E::Udint,
            "DWORD" => E::Dword,
            "ULINT" => E::Ulint,
            "LWORD" => E::Lword,
            "REAL" => E::Real,
            "LREAL" => E::Lreal,
            "TIME" => E::Time,
            "LTIME" | "DATE" | "DT" | "DATE_AND_TIME" | "TOD" | "TIME_OF_DAY" | "LDATE" | "LDT"
            | "LTOD" => E::Date,
            _ => return None,
        })
    }

    /// The number format; `None` for `BOOL`.
    #[must_use]
    pub fn kind(self) -> Option<Kind> {
        use Elementary as E;
        let whole = |bits, signed| Some(Kind::Whole { bits, signed });
        match self {
            E::Bool => None,
            E::Sint => whole(8, true),
            E::Int => whole(16, true),
            E::Dint => whole(32, true),
            E::Lint => whole(64, true),
            E::Usint | E::Byte => whole(8, false),
            E::Uint | E::Word => whole(16, false),
            E::Udint | E::Dword => whole(32, false),
            E::Ulint | E::Lword => whole(64, false),
            E::Real => Some(Kind::Real),
            E::Time => Some(Kind::Time),
            E::Lreal | E::Date => Some(Kind::Opaque(4)),
        }
    }

    /// An elementary type with this number format; bit strings and dates are never returned.
    #[must_use]
    pub fn of(kind: Kind) -> Elementary {
        use Elementary as E;
        match kind {
            Kind::Whole { bits: ..=8, signed: true } => E::Sint,
            Kind::Whole { bits: ..=8, signed: false } => E::Usint,
            Kind::Whole { bits: ..=16, signed: true } => E::Int,
            Kind::Whole { bits: ..=16, signed: false } => E::Uint,
            Kind::Whole { bits: ..=32, signed: true } => E::Dint,
            Kind::Whole { bits: ..=32, signed: false } => E::Udint,
            Kind::Whole { signed: true, .. } => E::Lint,
            Kind::Whole { signed: false, .. } => E::Ulint,
            Kind::Real => E::Real,
            Kind::Time => E::Time,
            Kind::Opaque(_) => E::Lreal,
        }
    }

    /// Whether it is a bit string: `BYTE`, `WORD`, `DWORD` or `LWORD`.
    #[must_use]
    pub fn is_bits(self) -> bool {
        use Elementary as E;
        matches!(self, E::Byte | E::Word | E::Dword | E::Lword)
    }
}

/// A time in units of 0.5 ms. `None` if it is not a whole number of milliseconds or does not fit in 32 bits.
#[must_use]
pub fn time_in_units(nanoseconds: i64) -> Option<i32> {
    let is_whole = nanoseconds % 1_000_000 == 0;
    is_whole.then(|| i32::try_from(nanoseconds / 500_000).ok()).flatten()
}
