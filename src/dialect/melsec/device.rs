//! The memory of MELSEC CPUs: areas, their names and how their indices are written, by CPU family.

use crate::program::{Area, AreaId, AreaKind, Cell, Radix};

/// CPU families that differ in how they write devices or what instructions mean.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Family {
    /// MELSEC-Q: Q02, QnU and their kin.
    Q,
    /// MELSEC-L.
    L,
    /// MELSEC-F: FX1S to FX3U.
    Fx,
    /// MELSEC iQ-R.
    Iqr,
    /// MELSEC iQ-F.
    Fx5,
}

impl Family {
    /// The family of a CPU as sources name it (`Q26UDV`, `FX3U/FX3UC`, `L26-BT`, `R08`).
    #[must_use]
    pub fn of_cpu(cpu: &str) -> Option<Family> {
        let cpu = cpu.trim().to_ascii_uppercase();
        let series = cpu.strip_prefix("MELSEC").unwrap_or(&cpu).trim_start_matches(['-', ' ']);
        if series.starts_with("FX5") {
            Some(Family::Fx5)
        } else if series.starts_with("FX") {
            Some(Family::Fx)
        } else {
            match series.chars().next()? {
                'Q' => Some(Family::Q),
                'L' => Some(Family::L),
                'R' => Some(Family::Iqr),
                _ => None,
            }
        }
    }

    /// The family of that short name, as timing tables give it.
    #[must_use]
    pub fn named(name: &str) -> Option<Family> {
        Some(match name {
            "q" => Family::Q,
            "l" => Family::L,
            "fx" => Family::Fx,
            "iqr" => Family::Iqr,
            "fx5" => Family::Fx5,
            _ => return None,
        })
    }

    /// Inputs and outputs are numbered in octal.
    #[must_use]
    pub fn octal_inputs(self) -> bool {
        matches!(self, Family::Fx | Family::Fx5)
    }
}

/// What a device name stands for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// One area of bits.
    Bit(AreaId),
    /// One area of words.
    Word(AreaId),
    /// Timer or counter: contact, coil and present value.
    Timed(Timed),
    /// Bits that change without the program: reads are free, writes vanish.
    VolatileBit,
    /// Words that change without the program.
    VolatileWord,
}

/// The three areas of timers, retentive timers or counters.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Timed {
    /// Contacts.
    pub contact: AreaId,
    /// Coils.
    pub coil: AreaId,
    /// Present values.
    pub value: AreaId,
    /// Contact and value stay while the coil is off: retentive timers and counters.
    pub retentive: bool,
}

/// Every area a MELSEC program can have, by its place here.
const AREAS: [(&str, AreaKind); 41] = [
    ("X", AreaKind::Bit),
    ("Y", AreaKind::Bit),
    ("M", AreaKind::Bit),
    ("L", AreaKind::Bit),
    ("F", AreaKind::Bit),
    ("S", AreaKind::Bit),
    ("B", AreaKind::Bit),
    ("SB", AreaKind::Bit),
    ("V", AreaKind::Bit),
    ("FX", AreaKind::Bit),
    ("FY", AreaKind::Bit),
    ("T", AreaKind::Bit),
    ("T coil ", AreaKind::Bit),
    ("T value ", AreaKind::Word),
    ("ST", AreaKind::Bit),
    ("ST coil ", AreaKind::Bit),
    ("ST value ", AreaKind::Word),
    ("C", AreaKind::Bit),
    ("C coil ", AreaKind::Bit),
    ("C value ", AreaKind::Word),
    ("D", AreaKind::Word),
    ("W", AreaKind::Word),
    ("SW", AreaKind::Word),
    ("ZR", AreaKind::Word),
    ("Z", AreaKind::Word),
    ("FD", AreaKind::Word),
    ("V index ", AreaKind::Word),
    ("SM", AreaKind::Bit),
    ("edge ", AreaKind::Bit),
    ("RD", AreaKind::Word),
    ("ER", AreaKind::Word),
    ("LZ", AreaKind::Word),
    ("LC", AreaKind::Bit),
    ("LC coil ", AreaKind::Bit),
    ("LT", AreaKind::Bit),
    ("LT coil ", AreaKind::Bit),
    ("LT value ", AreaKind::Word),
    ("LST", AreaKind::Bit),
    ("LST coil ", AreaKind::Bit),
    ("LST value ", AreaKind::Word),
    ("LC value ", AreaKind::Word),
];

/// The area of that name in `AREAS`.
#[must_use]
pub fn area(name: &str) -> AreaId {
    let place = AREAS.iter().position(|(known, _)| *known == name);
    AreaId(
        u16::try_from(place.expect("only names of the list above are asked for"))
            .expect("the list is short"),
    )
}

/// All areas, with their radix in this family.
#[must_use]
pub fn areas(family: Family) -> Vec<Area> {
    AREAS
        .iter()
        .map(|&(name, kind)| Area { name: name.to_owned(), kind, radix: radix(name, family) })
        .collect()
}

/// How indices behind a device name are written.
#[must_use]
pub fn radix(name: &str, family: Family) -> Radix {
    match name {
        "X" | "Y" | "DX" | "DY" if family.octal_inputs() => Radix::Octal,
        "X" | "Y" | "DX" | "DY" | "B" | "W" | "SB" | "SW" | "FX" | "FY" => Radix::Hexadecimal,
        _ => Radix::Decimal,
    }
}

/// The retained edges' area: one hidden bit for each instruction that remembers an earlier result.
#[must_use]
pub fn edge(index: u32) -> Cell {
    Cell { area: area("edge "), index }
}

/// Device names, the longer before those they begin with.
pub const NAMES: [&str; 48] = [
    "STN", "STC", "STS", "LSTN", "LST", "LT", "LCN", "LCC", "LCS", "LC", "SSN", "SSC", "SSS", "TN",
    "TC", "TS", "CN", "CC", "CS", "SM", "SD", "SB", "SW", "SS", "SC", "SN", "ST", "ZR", "DX", "DY",
    "FX", "FY", "FD", "RD", "ER", "LZ", "X", "Y", "M", "L", "F", "S", "B", "V", "T", "C", "D", "W",
];

/// Further names of one letter.
pub const SHORT_NAMES: [&str; 2] = ["R", "Z"];

/// Whether an FX timer runs on wherever the scan is: those for subroutines, 1 ms timers, 100 ms retentive ones.
#[must_use]
pub fn own_clock(timer: u32) -> bool {
    matches!(timer, 192..=199 | 246..)
}

/// What a device name means in a family; `None` if the family has no such device. `index` tells special
/// relays and registers of the FX from plain ones.
#[must_use]
pub fn kind(name: &str, index: u32, family: Family) -> Option<Kind> {
    let fx = family == Family::Fx;
    let timed = |name: &str, retentive: bool| Timed {
        contact: area(name),
        coil: area(&format!("{name} coil ")),
        value: area(&format!("{name} value ")),
        retentive,
    };
    let retentive = || timed("ST", true);
    let timer = || timed("T", false);
    let counter = || timed("C", true);
    Some(match name {
        "M" if fx && index >= 8000 => Kind::VolatileBit,
        "D" if fx && index >= 8000 => Kind::VolatileWord,
        // 1 ms and 100 ms retentive timers, counted in interrupts.
        "T" if fx && (246..=255).contains(&index) => {
            Kind::Timed(Timed { retentive: true, ..timer() })
        }
        "TS" | "TC" if fx && own_clock(index) => Kind::VolatileBit,
        "TN" if fx && own_clock(index) => Kind::VolatileWord,
        // High-speed counters count in interrupts.
        "C" | "CS" | "CC" if fx && index >= 235 => Kind::VolatileBit,
        "CN" if fx && index >= 200 => Kind::VolatileWord,
        "V" if fx => Kind::Word(area("V index ")),
        "X" | "Y" | "M" | "L" | "F" | "S" | "B" | "SB" | "V" => Kind::Bit(area(name)),
        "FX" | "FY" if !fx => Kind::Bit(area(name)),
        "DY" => Kind::Bit(area("Y")),
        "DX" | "SM" => Kind::VolatileBit,
        "SD" => Kind::VolatileWord,
        "D" | "W" | "SW" | "ZR" | "Z" | "FD" | "RD" | "ER" | "LZ" => Kind::Word(area(name)),
        "R" => Kind::Word(area("ZR")),
        "T" => Kind::Timed(timer()),
        "ST" => Kind::Timed(retentive()),
        "C" => Kind::Timed(counter()),
        "LC" => Kind::Timed(timed("LC", true)),
        "LT" => Kind::Timed(timed("LT", false)),
        "LST" => Kind::Timed(timed("LST", true)),
        "TS" => Kind::Bit(timer().contact),
        "TC" => Kind::Bit(timer().coil),
        "TN" => Kind::Word(timer().value),
        "CS" => Kind::Bit(counter().contact),
        "CC" => Kind::Bit(counter().coil),
        "CN" => Kind::Word(counter().value),
        "STS" | "SS" | "SSS" => Kind::Bit(retentive().contact),
        "STC" | "SC" | "SSC" => Kind::Bit(retentive().coil),
        "STN" | "SN" | "SSN" => Kind::Word(retentive().value),
        _ => return None,
    })
}
