//! The memory of MELSEC CPUs: device names, areas, and the radix of device numbers, by CPU family.

use scanbound_ir::{Area, AreaId, AreaKind, Cell, PowerUp, Radix, Region, Role};

/// A family of MELSEC CPUs. Families differ in device notation and in what some instructions mean.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Family {
    /// MELSEC-Q: Q02, QnU and others.
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

    /// The program capacity of the largest CPU of the family, in steps. No program has more instructions, because each
    /// takes at least one step.
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

    /// The family of a CPU by its name (`Q26UDV`, `FX3U/FX3UC`, `L26-BT`, `R08`). `None` if the name belongs to none of
    /// them.
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

    /// The family by the short name that timing tables use: `q`, `l`, `fx`, `iqr` or `fx5`. `None` for any other text.
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

    /// Whether inputs and outputs are numbered in octal, as on the FX and FX5.
    #[must_use]
    pub fn octal_inputs(self) -> bool {
        matches!(self, Family::Fx | Family::Fx5)
    }
}

/// What kind of device a name stands for, and the areas that hold its cells.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum DeviceType {
    /// A bit device, whose cells are in this area.
    Bit(AreaId),
    /// A word device, whose cells are in this area.
    Word(AreaId),
    /// A timer or counter, which has a contact, a coil and a present value.
    Timed(Timed),
    /// A bit that changes without the program. Two reads may give different values; writes are ignored.
    VolatileBit,
    /// A word that changes without the program. Two reads may give different values; writes are ignored.
    VolatileWord,
}

/// The three areas that hold the cells of ordinary timers, of retentive timers, or of counters.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Timed {
    /// The area of the contacts.
    pub contact: AreaId,
    /// The area of the coils.
    pub coil: AreaId,
    /// The area of the present values.
    pub value: AreaId,
    /// Whether contact and present value are kept while the coil is off: retentive timers and counters.
    pub retentive: bool,
}

impl Timed {
    /// The areas that may change if a write goes to an unknown device of this type: values, contacts, coils, and for
    /// ordinary timers the hidden bits of [`Timed::ran`].
    pub fn areas(self) -> impl Iterator<Item = AreaId> {
        let memory = (self.contact == TIMER.contact).then_some(const { area("T ran ") });
        [self.value, self.contact, self.coil].into_iter().chain(memory)
    }

    /// The hidden bit that records whether the coil of ordinary timer number `index` was on when the timer was last
    /// executed. Only instructions on this timer write it. `None` for retentive timers, long timers and counters.
    pub fn ran(self, index: u32) -> Option<Cell> {
        let is_plain = self.contact == TIMER.contact && !self.retentive;
        is_plain.then_some(Cell { area: const { area("T ran ") }, index })
    }
}

/// All areas. The id of an area is its index in this list.
const AREAS: [(&str, AreaKind); 44] = [
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
    ("SD", AreaKind::Word),
];

/// The regions that a network refreshes if one is installed, each with its name: the areas B, W, SB and SW. Empty for
/// the FX.
#[must_use]
pub fn networks(family: Family) -> Vec<(Region, String)> {
    // The FX series links ordinary D and M, which cannot be told from unlinked ones.
    let names: &[&str] = if family == Family::Fx { &[] } else { &["B", "W", "SB", "SW"] };
    let at = |name: &str| AREAS.iter().position(|(own, _)| *own == name);
    let cells = |name: &&str| {
        let area = AreaId(u16::try_from(at(name)?).ok()?);
        Some((Region::Area(area), (*name).to_owned()))
    };
    names.iter().filter_map(cells).collect()
}

/// What is known about memory when a CPU of the family is switched on: the inputs, the areas that are 0 if memory was
/// cleared, those of them that are latched by default, and the relay of the first scan. Edge relays, hidden bits, and
/// long timers and counters are left out, because no manual page defines them.
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
    // The default latched ranges. The FX has latched ranges in all device types; of its timers, the retentive ones
    // are latched.
    let latched: &[&str] = match family {
        Family::Fx => &["M", "L", "S", "D", "ST", "ST value ", "C", "C value "],
        _ => &["L", "ZR", "ST", "ST value ", "C", "C value "],
    };
    let mut latched: Vec<Region> = latched.iter().map(|name| Region::Area(area(name))).collect();
    if family == Family::Fx {
        let retentive = |area| Region::Range { first: Cell { area, index: 246 }, count: 10 };
        latched.extend([const { area("T") }, const { area("T value ") }].map(retentive));
    }
    let (relays, first) = if family == Family::Fx { ("M", 8002) } else { ("SM", 402) };
    PowerUp {
        inputs: vec![Region::Area(area("X"))],
        cleared: cleared.map(|name| Region::Area(area(name))).into(),
        latched,
        first_scan: vec![Cell { area: area(relays), index: first }],
        // On these, STOP to RUN does not clear relays, so no relay shows that memory was cleared.
        ..PowerUp::default()
    }
}

/// The id of the area with this name: its index in the list of all areas.
///
/// # Panics
///
/// If no area has this name. The names are those of that list, such as `D`, `T coil ` or `V index `.
#[must_use]
pub const fn area(name: &str) -> AreaId {
    let mut at = 0;
    while at < AREAS.len() {
        if is_same(AREAS[at].0.as_bytes(), name.as_bytes()) {
            return AreaId(at as u16);
        }
        at += 1;
    }
    panic!("no area has this name")
}

/// Whether two texts are equal. Unlike `==`, it can be used in constant expressions.
const fn is_same(a: &[u8], b: &[u8]) -> bool {
    let mut at = 0;
    while at < a.len() && at < b.len() && a[at] == b[at] {
        at += 1;
    }
    at == a.len() && at == b.len()
}

/// All areas, with name, role, and the radix that their numbers have in this family. The id of an area is its index.
#[must_use]
pub fn areas(family: Family) -> Vec<Area> {
    AREAS
        .iter()
        .map(|&(name, kind)| Area {
            role: role(name),
            // A file register has a number over all blocks (ZR) and one in the current block (R).
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

/// The radix of the numbers that follow a device name: hexadecimal for inputs, outputs and link devices, octal for
/// inputs and outputs of the FX and FX5, decimal for all others.
#[must_use]
pub fn radix(name: &str, family: Family) -> Radix {
    match name {
        "X" | "Y" | "DX" | "DY" if family.octal_inputs() => Radix::Octal,
        "X" | "Y" | "DX" | "DY" | "B" | "W" | "SB" | "SW" | "FX" | "FY" => Radix::Hexadecimal,
        _ => Radix::Decimal,
    }
}

/// The hidden bit with this number. It keeps a result of one instruction until that instruction runs again, as edges
/// need it.
#[must_use]
pub fn edge_memory(index: u32) -> Cell {
    Cell { area: area("edge "), index }
}

/// One of the names with which devices are written, such as `D`, `ZR` or `TN`.
#[derive(Debug)]
pub struct Name {
    /// The letters of the device name.
    pub letters: &'static str,
    /// What the name stands for, unless [`Name::kind`] makes an exception for the family or the number.
    kind: DeviceType,
}

const TIMER: Timed = timed(["T", "T coil ", "T value "], false);
const RETENTIVE: Timed = timed(["ST", "ST coil ", "ST value "], true);
const COUNTER: Timed = timed(["C", "C coil ", "C value "], true);
const LONG_TIMER: Timed = timed(["LT", "LT coil ", "LT value "], false);
const LONG_RETENTIVE: Timed = timed(["LST", "LST coil ", "LST value "], true);
const LONG_COUNTER: Timed = timed(["LC", "LC coil ", "LC value "], true);

/// All device names in alphabetical order.
static NAMES: [Name; 55] = [
    name("B", bit("B")),
    name("C", DeviceType::Timed(COUNTER)),
    name("CC", DeviceType::Bit(COUNTER.coil)),
    name("CN", DeviceType::Word(COUNTER.value)),
    name("CS", DeviceType::Bit(COUNTER.contact)),
    name("D", word("D")),
    name("DX", DeviceType::VolatileBit),
    name("DY", bit("Y")),
    name("ER", word("ER")),
    name("F", bit("F")),
    name("FD", word("FD")),
    name("FX", bit("FX")),
    name("FY", bit("FY")),
    name("L", bit("L")),
    name("LC", DeviceType::Timed(LONG_COUNTER)),
    name("LCC", DeviceType::Bit(LONG_COUNTER.coil)),
    // These have two words, which are not modelled.
    name("LCN", DeviceType::VolatileWord),
    name("LCS", DeviceType::Bit(LONG_COUNTER.contact)),
    name("LST", DeviceType::Timed(LONG_RETENTIVE)),
    name("LSTC", DeviceType::Bit(LONG_RETENTIVE.coil)),
    name("LSTN", DeviceType::VolatileWord),
    name("LSTS", DeviceType::Bit(LONG_RETENTIVE.contact)),
    name("LT", DeviceType::Timed(LONG_TIMER)),
    name("LTC", DeviceType::Bit(LONG_TIMER.coil)),
    name("LTN", DeviceType::VolatileWord),
    name("LTS", DeviceType::Bit(LONG_TIMER.contact)),
    name("LZ", DeviceType::VolatileWord),
    name("M", bit("M")),
    name("R", word("ZR")),
    name("RD", word("RD")),
    name("S", bit("S")),
    name("SB", bit("SB")),
    name("SC", DeviceType::Bit(RETENTIVE.coil)),
    name("SD", DeviceType::VolatileWord),
    name("SM", DeviceType::VolatileBit),
    name("SN", DeviceType::Word(RETENTIVE.value)),
    name("SS", DeviceType::Bit(RETENTIVE.contact)),
    name("SSC", DeviceType::Bit(RETENTIVE.coil)),
    name("SSN", DeviceType::Word(RETENTIVE.value)),
    name("SSS", DeviceType::Bit(RETENTIVE.contact)),
    name("ST", DeviceType::Timed(RETENTIVE)),
    name("STC", DeviceType::Bit(RETENTIVE.coil)),
    name("STN", DeviceType::Word(RETENTIVE.value)),
    name("STS", DeviceType::Bit(RETENTIVE.contact)),
    name("SW", word("SW")),
    name("T", DeviceType::Timed(TIMER)),
    name("TC", DeviceType::Bit(TIMER.coil)),
    name("TN", DeviceType::Word(TIMER.value)),
    name("TS", DeviceType::Bit(TIMER.contact)),
    name("V", bit("V")),
    name("W", word("W")),
    name("X", bit("X")),
    name("Y", bit("Y")),
    name("Z", word("Z")),
    name("ZR", word("ZR")),
];

const fn name(letters: &'static str, kind: DeviceType) -> Name {
    Name { letters, kind }
}

const fn bit(name: &str) -> DeviceType {
    DeviceType::Bit(area(name))
}

const fn word(name: &str) -> DeviceType {
    DeviceType::Word(area(name))
}

const fn timed([contact, coil, value]: [&str; 3], retentive: bool) -> Timed {
    Timed { contact: area(contact), coil: area(coil), value: area(value), retentive }
}

/// The device name at the start of a text in upper case, and the radix of its number: the longest known name that a
/// digit of this radix follows. `None` if there is none.
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

/// The length of the longest device name.
const LONGEST_NAME: usize = 4;

/// Whether the character may be a digit of this radix. For octal 8 and 9 count, too, so that they can be reported as
/// wrong.
#[must_use]
pub fn is_digit(byte: u8, radix: Radix) -> bool {
    match radix {
        Radix::Hexadecimal => byte.is_ascii_hexdigit(),
        Radix::Decimal | Radix::Octal => byte.is_ascii_digit(),
    }
}

/// Whether the FX timer with this number counts even while the scan runs: timers for subroutines (T192 to T199), and 1
/// ms and 100 ms retentive timers and 1 ms timers (from T246 on).
#[must_use]
pub fn has_own_clock(timer: u32) -> bool {
    matches!(timer, 192..=199 | 246..)
}

/// The number of words of a function register: `FD1` begins this many words after `FD0`.
pub const FUNCTION_WORDS: u32 = 4;

/// What these letters stand for in a family, for the device number `index`: see [`Name::kind`]. `None` if the family
/// has no such device.
#[must_use]
pub fn kind(letters: &str, index: u32, family: Family) -> Option<DeviceType> {
    let at = NAMES.binary_search_by_key(&letters, |name| name.letters).ok()?;
    NAMES[at].kind(index, family)
}

impl Name {
    /// What the name stands for in a family, for the device number `index`. `None` if the family has no such device.
    /// The number matters for the FX (special relays and registers, timers and counters that count in interrupts) and
    /// for the high-speed counters of the FX5.
    #[must_use]
    pub fn kind(&self, index: u32, family: Family) -> Option<DeviceType> {
        // High-speed counters of the FX5 and long timers of iQ-R: no manual page says when their contacts change.
        let by_itself = match (self.letters, family) {
            ("LC" | "LCS" | "LCC", Family::Fx5) => (35..=55).contains(&index),
            ("LT" | "LTS" | "LST" | "LSTS", Family::Iqr) => true,
            _ => false,
        };
        if by_itself {
            return Some(DeviceType::VolatileBit);
        }
        if family != Family::Fx {
            return Some(self.kind);
        }
        Some(match self.letters {
            "M" if index >= 8000 => DeviceType::VolatileBit,
            "D" if index >= 8000 => DeviceType::VolatileWord,
            // 1 ms and 100 ms retentive timers count in interrupts.
            "T" if (246..=255).contains(&index) => {
                DeviceType::Timed(Timed { retentive: true, ..TIMER })
            }
            "TS" | "TC" if has_own_clock(index) => DeviceType::VolatileBit,
            "TN" if has_own_clock(index) => DeviceType::VolatileWord,
            // High-speed counters count in interrupts.
            "C" | "CS" | "CC" if index >= 235 => DeviceType::VolatileBit,
            "CN" if index >= 200 => DeviceType::VolatileWord,
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
