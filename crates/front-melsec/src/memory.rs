//! The memory of MELSEC CPUs: areas, their names and how their indices are written, by CPU family.

use scanbound_ir::{Area, AreaId, AreaKind, Cell, PowerUp, Radix, Region, Role};

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
    /// The family's name in messages.
    #[must_use]
    pub fn series(self) -> &'static str {
        match self {
            Family::Q => "MELSEC-Q",
            Family::L => "MELSEC-L",
            Family::Fx => "MELSEC-F",
            Family::Iqr => "MELSEC iQ-R",
            Family::Fx5 => "MELSEC iQ-F",
        }
    }

    /// The steps that the largest CPU of the family holds: no program has more instructions.
    #[must_use]
    pub fn most_steps(self) -> usize {
        const K: usize = 1024;
        match self {
            Family::Fx => 64 * K,
            Family::Fx5 => 128 * K,
            Family::L => 260 * K,
            Family::Q => 1000 * K,
            Family::Iqr => 1200 * K,
        }
    }

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
    /// A bit of this area.
    Bit(AreaId),
    /// A word of this area.
    Word(AreaId),
    /// Timer or counter: contact, coil and present value.
    Timed(Timed),
    /// A bit that changes without the program: reads are free, writes vanish.
    VolatileBit,
    /// A word that changes without the program, likewise.
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

impl Timed {
    /// The areas that change where it is not known what becomes of one of these devices.
    pub fn areas(self) -> impl Iterator<Item = AreaId> {
        let memory = (self.contact == TIMER.contact).then_some(const { area("T ran ") });
        [self.value, self.contact, self.coil].into_iter().chain(memory)
    }

    /// The bit in which a timer that is not retentive remembers whether its coil was on when it was executed last. Nobody
    /// but its own instructions writes it.
    pub fn ran(self, index: u32) -> Option<Cell> {
        let is_plain = self.contact == TIMER.contact && !self.retentive;
        is_plain.then_some(Cell { area: const { area("T ran ") }, index })
    }
}

/// Every area a MELSEC program can have, by its place here.
const AREAS: [(&str, AreaKind); 43] = [
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
    ("stood at ", AreaKind::Word),
    ("T ran ", AreaKind::Bit),
];

/// Cells that a network refreshes where one is fitted, and what they are.
#[must_use]
pub fn networks(family: Family) -> Vec<(Region, String)> {
    // The FX series link plain D and M, which no look at a program tells from others.
    let names: &[&str] = if family == Family::Fx { &[] } else { &["B", "W", "SB", "SW"] };
    let at = |name: &str| AREAS.iter().position(|(own, _)| *own == name);
    let cells = |name: &&str| {
        let area = AreaId(u16::try_from(at(name)?).ok()?);
        Some((Region::Area(area), (*name).to_owned()))
    };
    names.iter().filter_map(cells).collect()
}

/// How a CPU comes up whose memory was cleared. Edge relays, what instructions remember, and long timers and counters
/// are left out: no page settles them.
#[must_use]
pub fn power_up(family: Family) -> PowerUp {
    let cleared = [
        "Y",
        "M",
        "L",
        "F",
        "B",
        "S",
        "D",
        "W",
        "ZR",
        "Z",
        "T",
        "T coil ",
        "T value ",
        "ST",
        "ST coil ",
        "ST value ",
        "C",
        "C coil ",
        "C value ",
        "T ran ",
    ];
    // By the CPUs' parameters as they come; those of FX have latched ranges in all kinds of device.
    let latched: &[&str] = match family {
        Family::Fx => &["M", "L", "S", "D", "T", "T value ", "ST", "ST value ", "C", "C value "],
        _ => &["L", "ZR", "ST", "ST value ", "C", "C value "],
    };
    let (relays, first) = if family == Family::Fx { ("M", 8002) } else { ("SM", 402) };
    PowerUp {
        inputs: vec![Region::Area(area("X"))],
        cleared: cleared.map(|name| Region::Area(area(name))).into(),
        latched: latched.iter().map(|name| Region::Area(area(name))).collect(),
        first_scan: vec![Cell { area: area(relays), index: first }],
        // STOP to RUN clears no relays: no bit says that memory was cleared.
        ..PowerUp::default()
    }
}

/// The area of that name in `AREAS`.
///
/// # Panics
/// If there is none: only names of that list are asked for.
#[must_use]
pub const fn area(name: &str) -> AreaId {
    let mut at = 0;
    while at < AREAS.len() {
        if is_same(AREAS[at].0.as_bytes(), name.as_bytes()) {
            return AreaId(at as u16);
        }
        at += 1;
    }
    panic!("only names of the list above are asked for")
}

/// What `==` says, where constants are worked out.
const fn is_same(a: &[u8], b: &[u8]) -> bool {
    let mut at = 0;
    while at < a.len() && at < b.len() && a[at] == b[at] {
        at += 1;
    }
    at == a.len() && at == b.len()
}

/// All areas, with their radix in this family.
#[must_use]
pub fn areas(family: Family) -> Vec<Area> {
    AREAS
        .iter()
        .map(|&(name, kind)| Area {
            role: role(name),
            // File registers have a number in all blocks and one in the block that is set.
            aliases: if name == "ZR" { &["R"] } else { &[] },
            ..Area::new(name, kind, radix(name, family))
        })
        .collect()
}

fn role(name: &str) -> Role {
    match name {
        "X" => Role::Input,
        "Y" => Role::Output,
        "edge " | "stood at " | "T ran " => Role::Internal,
        _ => Role::Memory,
    }
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

/// The hidden bit in which an instruction remembers an earlier result, numbered apart from those of the others.
#[must_use]
pub fn edge_memory(index: u32) -> Cell {
    Cell { area: area("edge "), index }
}

/// A device name.
#[derive(Debug)]
pub struct Name {
    /// Its letters.
    pub letters: &'static str,
    /// What it means where the family does not say otherwise.
    kind: Kind,
}

const TIMER: Timed = timed(["T", "T coil ", "T value "], false);
const RETENTIVE: Timed = timed(["ST", "ST coil ", "ST value "], true);
const COUNTER: Timed = timed(["C", "C coil ", "C value "], true);
const LONG_TIMER: Timed = timed(["LT", "LT coil ", "LT value "], false);
const LONG_RETENTIVE: Timed = timed(["LST", "LST coil ", "LST value "], true);
const LONG_COUNTER: Timed = timed(["LC", "LC coil ", "LC value "], true);

/// All device names, in the order of their letters.
static NAMES: [Name; 55] = [
    name("B", bit("B")),
    name("C", Kind::Timed(COUNTER)),
    name("CC", Kind::Bit(COUNTER.coil)),
    name("CN", Kind::Word(COUNTER.value)),
    name("CS", Kind::Bit(COUNTER.contact)),
    name("D", word("D")),
    name("DX", Kind::VolatileBit),
    name("DY", bit("Y")),
    name("ER", word("ER")),
    name("F", bit("F")),
    name("FD", word("FD")),
    name("FX", bit("FX")),
    name("FY", bit("FY")),
    name("L", bit("L")),
    name("LC", Kind::Timed(LONG_COUNTER)),
    name("LCC", Kind::Bit(LONG_COUNTER.coil)),
    // Each holds two words of its own: they are not followed.
    name("LCN", Kind::VolatileWord),
    name("LCS", Kind::Bit(LONG_COUNTER.contact)),
    name("LST", Kind::Timed(LONG_RETENTIVE)),
    name("LSTC", Kind::Bit(LONG_RETENTIVE.coil)),
    name("LSTN", Kind::VolatileWord),
    name("LSTS", Kind::Bit(LONG_RETENTIVE.contact)),
    name("LT", Kind::Timed(LONG_TIMER)),
    name("LTC", Kind::Bit(LONG_TIMER.coil)),
    name("LTN", Kind::VolatileWord),
    name("LTS", Kind::Bit(LONG_TIMER.contact)),
    name("LZ", Kind::VolatileWord),
    name("M", bit("M")),
    name("R", word("ZR")),
    name("RD", word("RD")),
    name("S", bit("S")),
    name("SB", bit("SB")),
    name("SC", Kind::Bit(RETENTIVE.coil)),
    name("SD", Kind::VolatileWord),
    name("SM", Kind::VolatileBit),
    name("SN", Kind::Word(RETENTIVE.value)),
    name("SS", Kind::Bit(RETENTIVE.contact)),
    name("SSC", Kind::Bit(RETENTIVE.coil)),
    name("SSN", Kind::Word(RETENTIVE.value)),
    name("SSS", Kind::Bit(RETENTIVE.contact)),
    name("ST", Kind::Timed(RETENTIVE)),
    name("STC", Kind::Bit(RETENTIVE.coil)),
    name("STN", Kind::Word(RETENTIVE.value)),
    name("STS", Kind::Bit(RETENTIVE.contact)),
    name("SW", word("SW")),
    name("T", Kind::Timed(TIMER)),
    name("TC", Kind::Bit(TIMER.coil)),
    name("TN", Kind::Word(TIMER.value)),
    name("TS", Kind::Bit(TIMER.contact)),
    name("V", bit("V")),
    name("W", word("W")),
    name("X", bit("X")),
    name("Y", bit("Y")),
    name("Z", word("Z")),
    name("ZR", word("ZR")),
];

const fn name(letters: &'static str, kind: Kind) -> Name {
    Name { letters, kind }
}

const fn bit(name: &str) -> Kind {
    Kind::Bit(area(name))
}

const fn word(name: &str) -> Kind {
    Kind::Word(area(name))
}

const fn timed([contact, coil, value]: [&str; 3], retentive: bool) -> Timed {
    Timed { contact: area(contact), coil: area(coil), value: area(value), retentive }
}

/// The device name that a text begins with, and the radix of the number behind it: the longest name that is
/// followed by a digit.
#[must_use]
pub fn name_of(text: &str, family: Family) -> Option<(&'static Name, Radix)> {
    let letters = text.bytes().take(LONGEST_NAME).take_while(u8::is_ascii_uppercase).count();
    (1..=letters).rev().find_map(|length| {
        let at = NAMES.binary_search_by_key(&&text[..length], |name| name.letters).ok()?;
        let radix = radix(NAMES[at].letters, family);
        let next = *text.as_bytes().get(length)?;
        is_digit(next, radix).then_some((&NAMES[at], radix))
    })
}

/// No device name has more letters.
const LONGEST_NAME: usize = 4;

/// Whether a number of this radix may have such a digit: an 8 in an octal one is told of later.
#[must_use]
pub fn is_digit(byte: u8, radix: Radix) -> bool {
    match radix {
        Radix::Hexadecimal => byte.is_ascii_hexdigit(),
        Radix::Decimal | Radix::Octal => byte.is_ascii_digit(),
    }
}

/// Whether an FX timer runs on wherever the scan is: those for subroutines, 1 ms timers, 100 ms retentive ones.
#[must_use]
pub fn has_own_clock(timer: u32) -> bool {
    matches!(timer, 192..=199 | 246..)
}

/// Words that each function register has: FD1 lies that far behind FD0.
pub const FUNCTION_WORDS: u32 = 4;

/// What the device of these letters means in a family; `None` if there is no such device. `index` is as for
/// [`Name::kind`].
#[must_use]
pub fn kind(letters: &str, index: u32, family: Family) -> Option<Kind> {
    let at = NAMES.binary_search_by_key(&letters, |name| name.letters).ok()?;
    NAMES[at].kind(index, family)
}

impl Name {
    /// What the name means in a family; `None` if the family has no such device. `index` tells special relays and
    /// registers of the FX from plain ones.
    #[must_use]
    pub fn kind(&self, index: u32, family: Family) -> Option<Kind> {
        // Fast counters of the FX5, as C235 of the FX, and long timers of iQ-R: no page tells when their contacts change.
        let by_itself = match (self.letters, family) {
            ("LC" | "LCS" | "LCC", Family::Fx5) => (35..=55).contains(&index),
            ("LT" | "LTS" | "LST" | "LSTS", Family::Iqr) => true,
            _ => false,
        };
        if by_itself {
            return Some(Kind::VolatileBit);
        }
        if family != Family::Fx {
            return Some(self.kind);
        }
        Some(match self.letters {
            "M" if index >= 8000 => Kind::VolatileBit,
            "D" if index >= 8000 => Kind::VolatileWord,
            // 1 ms and 100 ms retentive timers, counted in interrupts.
            "T" if (246..=255).contains(&index) => Kind::Timed(Timed { retentive: true, ..TIMER }),
            "TS" | "TC" if has_own_clock(index) => Kind::VolatileBit,
            "TN" if has_own_clock(index) => Kind::VolatileWord,
            // High-speed counters count in interrupts.
            "C" | "CS" | "CC" if index >= 235 => Kind::VolatileBit,
            "CN" if index >= 200 => Kind::VolatileWord,
            "V" => word("V index "),
            "FX" | "FY" => return None,
            _ => self.kind,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_in_order_and_none_is_too_long() {
        assert!(NAMES.is_sorted_by(|a, b| a.letters < b.letters));
        assert_eq!(NAMES.iter().map(|name| name.letters.len()).max(), Some(LONGEST_NAME));
    }

    #[test]
    fn a_name_ends_where_its_number_begins() {
        let q = |text| name_of(text, Family::Q).map(|(name, _)| name.letters);
        for (text, name) in [
            ("STN5", "STN"),
            ("LSTS5", "LSTS"),
            ("ST5", "ST"),
            ("S5", "S"),
            ("SBF", "SB"),
            ("BF0", "B"),
        ] {
            assert_eq!(q(text), Some(name), "{text}");
        }
        for text in ["", "5", "STN", "FA", "LCX5", "d5", "あ5", "Dあ"] {
            assert_eq!(q(text), None, "{text}");
        }
    }
}
