//! The memory of OMRON PLCs: areas and their letters, cells that the system changes, condition flags.

use super::source::Family;
use scanbound_ir::{Area, AreaId, AreaKind, BitTarget, Cell, PowerUp, Radix, Region, Role};

/// What the cells of an area are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum AreaUse {
    /// Words of data, each with sixteen bits.
    Words,
    /// Completion flags of timers or counters. The number is that of the area of their present values.
    Flags(usize),
    /// Current values of timers or counters.
    Values,
    /// The condition flags and clock pulses.
    Conditions,
    /// Hidden bits that instructions use.
    Memories,
}

struct AreaDefinition {
    /// The name of the area in reports.
    name: &'static str,
    /// The letters with which operands name the area; none for an area that they cannot name.
    letters: &'static [&'static str],
    /// The number of words or bits that the area has in the family's largest CPU.
    size: u32,
    role: AreaUse,
}

const fn words(name: &'static str, letters: &'static [&'static str], size: u32) -> AreaDefinition {
    AreaDefinition { name, letters, size, role: AreaUse::Words }
}

const fn other(
    name: &'static str,
    letters: &'static [&'static str],
    size: u32,
    role: AreaUse,
) -> AreaDefinition {
    AreaDefinition { name, letters, size, role }
}

/// The areas of the C series: IR and SR (one area), HR, AR, LR, DM, EM; timers and counters share numbers.
const C_AREAS: [AreaDefinition; 10] = [
    words("IR", &["", "IR", "SR", "CIO"], 512),
    words("HR", &["HR", "H"], 100),
    words("AR", &["AR", "A"], 28),
    words("LR", &["LR", "L"], 64),
    words("DM", &["DM", "D"], 10_000),
    words("EM", &["EM"], 6_144),
    other("TC", &["TIM", "CNT", "TC", "T", "C"], 512, AreaUse::Flags(7)),
    other("TCPV", &[], 512, AreaUse::Values),
    other("TIMER-RUNS-", &[], 512, AreaUse::Memories),
    other("EDGE-", &[], u32::MAX, AreaUse::Memories),
];

/// The areas of CS, CJ and CP except E: words, timers, counters, flags, registers, and scanbound's own memories. The
/// banks of E are areas after these.
const CS_AREAS: [AreaDefinition; 15] = [
    words("CIO", &["", "CIO"], 6_144),
    words("W", &["W"], 512),
    words("H", &["H"], 1_536),
    words("A", &["A"], 11_536),
    words("D", &["D"], 32_768),
    other("T", &["T", "TIM"], 4_096, AreaUse::Flags(6)),
    other("TPV", &[], 4_096, AreaUse::Values),
    other("C", &["C", "CNT"], 4_096, AreaUse::Flags(8)),
    other("CPV", &[], 4_096, AreaUse::Values),
    other("CF", &["CF"], 128, AreaUse::Conditions),
    words("TK", &["TK"], 128),
    other("TIMER-RUNS-", &[], 4_096, AreaUse::Memories),
    // An index register has two words.
    words("IR-word ", &[], 32),
    words("DR", &[], 16),
    other("EDGE-", &[], u32::MAX, AreaUse::Memories),
];

/// The number of banks of the E area.
const BANKS: u32 = 25;
/// The number of words of a bank of the E area.
const BANK: u32 = 32_768;

/// The memory map of a family. An area's id is its index in the family's list of areas; the banks of E follow.
#[derive(Debug, Clone, Copy)]
pub(super) struct Memory {
    pub(super) family: Family,
}

/// The condition flags of CS, CJ and CP: name in the catalog, and bit in the flag area.
const FLAGS: [(&str, u32); 12] = [
    ("GE", 0),
    ("NE", 1),
    ("LE", 2),
    ("ER", 3),
    ("CY", 4),
    ("GT", 5),
    ("EQ", 6),
    ("LT", 7),
    ("N", 8),
    ("OF", 9),
    ("UF", 10),
    ("AER", 11),
];

/// The condition flags of the C series: name, and bit in word 255.
const C_FLAGS: [(&str, u8); 5] = [("ER", 3), ("CY", 4), ("GT", 5), ("EQ", 6), ("LT", 7)];

/// The predefined symbols of the programming tool: name, address on CS, CJ and CP, address on the C series.
const SYMBOLS: [(&str, &str, &str); 25] = [
    ("P_On", "CF113", "25313"),
    ("P_Off", "CF114", "25314"),
    ("P_First_Cycle", "A200.11", "25315"),
    ("P_First_Cycle_Task", "A200.15", ""),
    ("P_Step", "A200.12", "25407"),
    ("P_0_02s", "CF103", "25401"),
    ("P_0_1s", "CF100", "25500"),
    ("P_0_2s", "CF101", "25501"),
    ("P_1s", "CF102", "25502"),
    ("P_1min", "CF104", "25400"),
    ("P_GE", "CF0", ""),
    ("P_NE", "CF1", ""),
    ("P_LE", "CF2", ""),
    ("P_ER", "CF3", "25503"),
    ("P_CY", "CF4", "25504"),
    ("P_GT", "CF5", "25505"),
    ("P_EQ", "CF6", "25506"),
    ("P_LT", "CF7", "25507"),
    ("P_N", "CF8", ""),
    ("P_OF", "CF9", "25404"),
    ("P_UF", "CF10", "25405"),
    ("P_AER", "CF11", ""),
    ("P_Low_Battery", "A402.04", "25308"),
    ("P_Output_Off_Bit", "A500.15", "25215"),
    ("P_Cycle_Time_Error", "A401.08", "25309"),
];

/// Whether a read of a bit gives the value that was written last.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum BitBehavior {
    /// The bit has the value that was written last.
    Held,
    /// The bit always has this value.
    Fixed(bool),
    /// The system may change the bit at any time.
    Volatile,
}

impl Memory {
    fn known(self) -> &'static [AreaDefinition] {
        match self.family {
            Family::C => &C_AREAS,
            Family::Cs => &CS_AREAS,
        }
    }

    /// All areas, in the order of their ids.
    pub(super) fn areas(self) -> Vec<Area> {
        let mut areas: Vec<Area> = self
            .known()
            .iter()
            .map(|known| {
                let kind = match known.role {
                    AreaUse::Words | AreaUse::Values => AreaKind::Word,
                    AreaUse::Flags(_) | AreaUse::Conditions | AreaUse::Memories => AreaKind::Bit,
                };
                let is_hidden = known.role == AreaUse::Memories;
                let role = if is_hidden { Role::Internal } else { Role::Memory };
                Area { role, ..Area::new(known.name, kind, Radix::Decimal) }
            })
            .collect();
        if self.family == Family::Cs {
            let bank = |bank| Area::new(format!("E{bank:X}_"), AreaKind::Word, Radix::Decimal);
            areas.extend((0..BANKS).map(bank));
        }
        areas
    }

    /// The area with these letters, and what it contains. `None` if the family has no such area.
    pub(super) fn area(self, letters: &str) -> Option<(AreaId, AreaUse)> {
        let at = self.known().iter().position(|known| known.letters.contains(&letters))?;
        Some((AreaId(at as u16), self.known()[at].role))
    }

    /// The area of the E bank with this number, written in hexadecimal (0 to 18). `None` if there is no such bank, or
    /// on the C series.
    pub(super) fn bank(self, digits: &str) -> Option<AreaId> {
        let bank = u32::from_str_radix(digits, 16).ok().filter(|bank| *bank < BANKS)?;
        (self.family == Family::Cs).then(|| AreaId((CS_AREAS.len() as u32 + bank) as u16))
    }

    /// All banks of the E area; on the C series, the single area EM.
    pub(super) fn extended(self) -> Vec<AreaId> {
        match self.family {
            Family::C => vec![AreaId(5)],
            Family::Cs => {
                (0..BANKS).map(|bank| AreaId((CS_AREAS.len() as u32 + bank) as u16)).collect()
            }
        }
    }

    /// The number of cells of the area in the family's largest CPU.
    pub(super) fn size(self, area: AreaId) -> u32 {
        self.known().get(usize::from(area.0)).map_or(BANK, |known| known.size)
    }

    /// The address of a symbol that CX-Programmer predefines, such as `P_On`: an empty text if this family does not
    /// have it. `None` if the name is not that of such a symbol.
    pub(super) fn symbol(self, name: &str) -> Option<&'static str> {
        let found = SYMBOLS.iter().find(|(known, ..)| known.eq_ignore_ascii_case(name))?;
        Some(if self.family == Family::Cs { found.1 } else { found.2 })
    }

    /// The first cell with condition flags, and the number of such cells.
    pub(super) fn flags(self) -> (Cell, u32) {
        match self.family {
            Family::C => (Cell { area: AreaId(0), index: 255 }, 1),
            Family::Cs => (Cell { area: AreaId(9), index: 0 }, FLAGS.len() as u32),
        }
    }

    /// The bit of a condition flag, by its name in the catalog. `None` if the family does not have the flag.
    pub(super) fn flag(self, name: &str) -> Option<BitTarget> {
        let (first, _) = self.flags();
        match self.family {
            Family::C => C_FLAGS
                .iter()
                .find(|(flag, _)| *flag == name)
                .map(|&(_, bit)| BitTarget::WordBit(first, bit)),
            Family::Cs => FLAGS
                .iter()
                .find(|(flag, _)| *flag == name)
                .map(|&(_, at)| BitTarget::Cell(first.plus(at))),
        }
    }

    /// Whether a read of a bit of a word gives the value that was written last.
    pub(super) fn bit_behavior(self, cell: Cell, bit: u8) -> BitBehavior {
        match (self.family, cell.area.0, cell.index, bit) {
            (Family::C, 0, 253, 13) => BitBehavior::Fixed(true),
            (Family::C, 0, 253, 14) => BitBehavior::Fixed(false),
            (Family::C, 0, 253, 15) | (Family::C, 0, 255, 4..=7) => BitBehavior::Held,
            // The first scan flag does not change within a scan.
            (Family::Cs, 3, 200, 11) => BitBehavior::Held,
            _ if self.is_volatile(cell) => BitBehavior::Volatile,
            _ => BitBehavior::Held,
        }
    }

    /// Whether a read of a cell of a bit area gives the value that was written last.
    pub(super) fn cell_behavior(self, cell: Cell) -> BitBehavior {
        match (self.family, cell.area.0, cell.index) {
            (Family::Cs, 9, 113) => BitBehavior::Fixed(true),
            (Family::Cs, 9, 114) => BitBehavior::Fixed(false),
            // Any instruction may set the error flags; bits from 12 on are clock pulses.
            (Family::Cs, 9, 3 | 11..) => BitBehavior::Volatile,
            _ => BitBehavior::Held,
        }
    }

    /// Whether the system may change the word at any time within a scan: special and auxiliary words, task flags, and
    /// on CS, CJ and CP the present values of timers 0 to 2047.
    pub(super) fn is_volatile(self, cell: Cell) -> bool {
        match self.family {
            Family::C => cell.area.0 == 2 || (cell.area.0 == 0 && (236..300).contains(&cell.index)),
            // In a long scan, the system updates the values of timers 0 to 2047 every 80 ms.
            Family::Cs => matches!(cell.area.0, 3 | 10) || (cell.area.0 == 6 && cell.index < 2_048),
        }
    }

    /// The name of a word's area.
    pub(super) fn name_of(self, cell: Cell) -> &'static str {
        self.known().get(usize::from(cell.area.0)).map_or("", |known| known.name)
    }

    /// Whether the cell is in the area of inputs and outputs (IR or CIO), where the prefix `!` of an instruction
    /// refreshes it.
    pub(super) fn is_refreshed(cell: Cell) -> bool {
        cell.area.0 == 0
    }

    /// Whether the word is in the I/O area: IR 0 to 49 and 100 to 115 (outputs of CQM1), CIO 0 to 319.
    pub(super) fn is_point(self, cell: Cell) -> bool {
        cell.area.0 == 0
            && match self.family {
                Family::C => cell.index < 50 || (100..116).contains(&cell.index),
                Family::Cs => cell.index < 320,
            }
    }

    /// The words that networks and special units refresh, with descriptions.
    pub(super) fn networks(self) -> Vec<(Region, String)> {
        let known: &[(u16, u32, u32, &str)] = match self.family {
            Family::C => &[
                (0, 50, 99, "remote I/O"),
                (0, 100, 199, "Special I/O Units"),
                (0, 200, 231, "remote I/O"),
                (3, 0, 63, "data links"),
            ],
            Family::Cs => &[
                (0, 1000, 1199, "data links"),
                (0, 1500, 1899, "CPU Bus Units"),
                (0, 2000, 2959, "Special I/O Units"),
                (0, 3100, 3189, "serial PLC links"),
                (0, 3200, 3799, "DeviceNet"),
            ],
        };
        let named = |&(area, first, last, what): &(u16, u32, u32, &str)| {
            let name = self.known().get(usize::from(area)).map_or("", |known| known.name);
            let cells = Region::Range {
                first: Cell { area: AreaId(area), index: first },
                count: last - first + 1,
            };
            (cells, format!("{name} {first} to {last} ({what})"))
        };
        known.iter().map(named).collect()
    }

    /// What is known about memory when a CPU is switched on: the words that may be inputs, the regions that are 0 if
    /// memory was cleared, the areas that keep their values without power, the flag of the first scan, and the word
    /// with the IOM hold bit.
    pub(super) fn power_up(self) -> PowerUp {
        let cells = |area: u16, first: u32, end: u32| Region::Range {
            first: Cell { area: AreaId(area), index: first },
            count: end - first,
        };
        let (inputs, io, words): (_, _, &[u16]) = match self.family {
            Family::C => (cells(0, 0, 50), cells(0, 0, 236), &[1]),
            Family::Cs => (cells(0, 0, 320), cells(0, 0, 6_144), &[1, 2]),
        };
        let words = words.iter().map(|&area| Region::Area(AreaId(area)));
        // From here on, DM holds the words of special units.
        let data = if self.family == Family::C { 1_000 } else { 20_000 };
        // Timers are reset when the program starts. On the C series, counters share their numbers.
        let timers: &[u16] = if self.family == Family::C { &[8] } else { &[5, 6, 11] };
        let timers = timers.iter().map(|&area| Region::Area(AreaId(area)));
        let cleared = [io, cells(4, 0, data)].into_iter().chain(words).chain(timers).collect();
        // The areas that are kept at power-off: holding relays and DM.
        let held = if self.family == Family::C { [1, 4] } else { [2, 4] };
        let latched = held.map(|area| Region::Area(AreaId(area))).into();
        // When the program starts, other areas are cleared; the first scan flag shows it.
        let fresh = match self.family {
            Family::C => (0, 253, 15),
            Family::Cs => (3, 200, 11),
        };
        let (area, index, bit) = fresh;
        let fresh = Some(BitTarget::WordBit(Cell { area: AreaId(area), index }, bit));
        // The IOM hold bit: 25212, A500.12.
        let hold = match self.family {
            Family::C => Cell { area: AreaId(0), index: 252 },
            Family::Cs => Cell { area: AreaId(3), index: 500 },
        };
        let holds = Some(hold);
        PowerUp {
            inputs: vec![inputs],
            cleared,
            latched,
            after_clear: fresh,
            memory_hold_word: holds,
            ..PowerUp::default()
        }
    }

    /// The hidden bit that records whether a timer's condition was on at its last execution. Only the timer's own
    /// instructions write it.
    pub(super) fn runs(self, flag: Cell) -> Cell {
        let area = match self.family {
            Family::C => 8,
            Family::Cs => 11,
        };
        Cell { area: AreaId(area), index: flag.index }
    }

    /// The hidden bit with this number, in which one instruction remembers a value from one scan to the next.
    pub(super) fn edge(self, index: u32) -> Cell {
        let area = match self.family {
            Family::C => 9,
            Family::Cs => 14,
        };
        Cell { area: AreaId(area), index }
    }

    /// The areas of timers and counters: flags, current values, hidden bits.
    pub(super) fn timing_areas(self) -> Vec<AreaId> {
        let at: &[u16] = match self.family {
            Family::C => &[6, 7, 8],
            Family::Cs => &[5, 6, 7, 8, 11],
        };
        at.iter().copied().map(AreaId).collect()
    }

    /// The first of the two words of an index register; the lower word comes first. `None` on the C series, or if there
    /// is no such register.
    pub(super) fn index_register(self, number: u32) -> Option<Cell> {
        (self.family == Family::Cs && number < 16)
            .then_some(Cell { area: AreaId(12), index: 2 * number })
    }

    /// The word of a data register. `None` on the C series, or if there is no such register.
    pub(super) fn data_register(self, number: u32) -> Option<Cell> {
        (self.family == Family::Cs && number < 16)
            .then_some(Cell { area: AreaId(13), index: number })
    }

    /// The areas of index and data registers, whose values are not kept from one task to another.
    pub(super) fn registers(self) -> &'static [AreaId] {
        match self.family {
            Family::C => &[],
            Family::Cs => &[AreaId(12), AreaId(13)],
        }
    }

    /// The completion flags of all timers; on the C series also those of counters, which are in the same area.
    pub(super) fn timers(self) -> impl Iterator<Item = Cell> {
        let area = AreaId(self.timing_areas()[0].0);
        (0..self.size(area)).map(move |index| Cell { area, index })
    }

    /// The words for parameters and results of a macro. C series: 232 to 239 and 290 to 297, on the CQM1 96 to 99 and
    /// 196 to 199, all of which are returned. CS, CJ and CP: A600 to A607.
    pub(super) fn parameters(self) -> Vec<(Cell, u32)> {
        match self.family {
            Family::C => [(232, 8), (290, 8), (96, 4), (196, 4)]
                .map(|(index, count)| (Cell { area: AreaId(0), index }, count))
                .to_vec(),
            Family::Cs => vec![(Cell { area: AreaId(3), index: 600 }, 8)],
        }
    }

    /// The areas to which an indirect address in `area` may point.
    pub(super) fn reach(self, area: AreaId) -> Vec<AreaId> {
        let mut areas = vec![area];
        if self.family == Family::Cs {
            // Values from 8000 (hexadecimal) on point from D to E, and from one bank to the next.
            areas.extend(self.extended());
        }
        areas.sort_unstable();
        areas.dedup();
        areas
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn areas_stand_at_their_ids() {
        let (c, cs) = (Memory { family: Family::C }, Memory { family: Family::Cs });
        assert_eq!(c.areas()[5].name, "EM");
        assert_eq!(c.areas()[7].name, "TCPV");
        assert_eq!(cs.areas()[9].name, "CF");
        assert_eq!(cs.areas()[3].name, "A");
        assert_eq!(cs.areas()[4].name, "D");
        assert_eq!(cs.areas()[cs.bank("18").unwrap().0 as usize].name, "E18_");
        assert_eq!(cs.bank("19"), None);
        assert_eq!(c.area("CNT"), c.area("TIM"));
        assert_ne!(cs.area("C"), cs.area("T"));
    }

    #[test]
    fn flags_are_where_the_symbols_say() {
        for memory in [Memory { family: Family::C }, Memory { family: Family::Cs }] {
            for (name, flag) in [("P_GT", "GT"), ("P_EQ", "EQ"), ("P_LT", "LT"), ("P_CY", "CY")] {
                let address = memory.symbol(name).unwrap();
                let place = match memory.flag(flag).unwrap() {
                    BitTarget::Cell(cell) => format!("CF{}", cell.index),
                    BitTarget::WordBit(cell, bit) => format!("{}{bit:02}", cell.index),
                };
                assert_eq!(address, place);
            }
        }
    }
}
