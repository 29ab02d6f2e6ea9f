//! What the user states about the plant and the source does not say: ranges of words, interrupts a scan, points, networks.

mod calls;
mod places;
mod reader;

use crate::code::Code;
use crate::diagnostic::Diagnostic;
use crate::time::Picos;
use places::Places;
use std::collections::BTreeMap;

pub use calls::{StatedCall, key, plain};
pub use places::Part;
pub use reader::TABLES;

/// The user's statements. They are believed: a wrong one can make the bound too low, so reports list them.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Facts {
    /// The file that they were read from, if from one: its name and the SHA-256 of its bytes.
    pub read_from: Option<(String, String)>,
    /// Device as written (`D100`) to the least and the largest value that it holds when the scan starts, signed.
    pub ranges: BTreeMap<String, (i64, i64)>,
    /// Place as written (`MAIN.csv:543`) to the least and the largest count that an instruction there has, wherever it is
    /// executed: a loop's iterations, a block's length. Or a word (`D100`): wherever it counts.
    pub counts: BTreeMap<String, (i64, i64)>,
    /// Routine that is not among the files, as [`plain`] has its name (`P153`), to what is known of it.
    pub calls: BTreeMap<String, StatedCall>,
    /// Interrupt label in upper case (`I0`) to how often its routine runs in one scan at most.
    pub interrupts: BTreeMap<String, u32>,
    /// Interrupt label in upper case (`I28`) to how often it comes: once in each such interval.
    pub intervals: BTreeMap<String, Picos>,
    /// Input points that the CPU refreshes.
    pub inputs: Option<u32>,
    /// Output points that the CPU refreshes.
    pub outputs: Option<u32>,
    /// The kind of base unit that all modules sit on, as timing tables name it (`main`).
    pub base: Option<String>,
    /// Input points and output points by base; empty where a side has one number only. The number is their sum.
    pub by_base: [BTreeMap<String, u32>; 2],
    /// What the refresh of networks takes in one scan at most; zero if there is none.
    pub network: Option<Picos>,
    /// The factor on the whole scan, in place of the table's.
    pub factor: Option<StatedFactor>,
    /// Whether the CPU stops at an operation error, or goes on with the next instruction: a parameter of some CPUs.
    pub stops_on_error: Option<bool>,
    /// The constant or minimum scan time that the CPU's parameters set; zero if they set none.
    pub constant_scan: Option<Picos>,
    /// The watchdog's time that the CPU's parameters set.
    pub watchdog: Option<Picos>,
    /// Whether a flowchart PC reads its inputs once a pass, into an image, instead of at each test.
    pub latched: Option<bool>,
    /// How many bits an index to file registers and extended data registers has, 16 or 32: a parameter of some CPUs.
    pub index_bits: Option<u32>,
    /// The only devices that are written through an indirect address (`@D0`), each as written: from the first to the last
    /// (`ZR1000-ZR1999`), or one.
    pub indirect: Option<Vec<String>>,
    /// What an index is where something is written by it, at a place (`MAIN.csv:924`) or wherever a register is the index
    /// (`Z0`): the least and the largest.
    pub indices: BTreeMap<String, (i64, i64)>,
    /// Devices that others than the program write between scans, such as HMIs: each as `D100`, or `D100-D199`.
    pub external: Vec<String>,
    /// Devices that nobody but the program writes, likewise.
    pub internal: Vec<String>,
    /// Sets of bits of which no two are on when a scan starts, each bit as written.
    pub exclusive: Vec<Vec<String>>,
    /// Whether scans after a download or a change in RUN count, when memory may hold anything.
    pub download: bool,
    /// Whether of transitions of a chart that compete for a step, and of which one has no priority, all clear whose conditions
    /// are true.
    pub all_clear: bool,
    /// In which order a chart's actions are carried out in one scan, where that is known.
    pub action_order: Option<ActionOrder>,
    /// Where they stand.
    pub places: Places,
}

/// In which order the actions of a chart that run in one scan are carried out.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ActionOrder {
    /// As the chart first names them.
    Named,
    /// Boolean variables first, then actions as they are declared.
    Declared,
    /// By their names; those that have ended, which are carried out once more, before the others.
    Alphabetical,
}

impl ActionOrder {
    /// All.
    pub const ALL: [ActionOrder; 3] =
        [ActionOrder::Named, ActionOrder::Declared, ActionOrder::Alphabetical];

    /// As facts files write it.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            ActionOrder::Named => "named",
            ActionOrder::Declared => "declared",
            ActionOrder::Alphabetical => "alphabetical",
        }
    }
}

/// How often an interrupt routine runs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum HowOften {
    /// So many times in a scan at most.
    Times(u32),
    /// Once in each interval of this length, which is above 0.
    Every(Picos),
}

impl std::str::FromStr for HowOften {
    type Err = ();
    fn from_str(text: &str) -> Result<HowOften, ()> {
        if let Ok(times) = text.parse() {
            return Ok(HowOften::Times(times));
        }
        let time: Picos = text.parse().map_err(|_| ())?;
        if time > Picos::ZERO { Ok(HowOften::Every(time)) } else { Err(()) }
    }
}

/// A factor on the whole scan that the user states.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct StatedFactor {
    /// In millionths, at least a million.
    pub millionths: u64,
    /// As written.
    pub text: String,
}

impl Facts {
    /// How often an interrupt routine runs in one scan at most, if that is stated; letter case does not count.
    #[must_use]
    pub fn interrupt(&self, label: &str) -> Option<u32> {
        self.interrupts.get(&label.to_ascii_uppercase()).copied()
    }

    /// States how often an interrupt routine runs, whatever a file says: so many times in a scan, or once in each interval.
    pub fn state_interrupt(&mut self, label: &str, often: HowOften) {
        self.places.forget("interrupts", label);
        let label = label.to_ascii_uppercase();
        self.interrupts.remove(&label);
        self.intervals.remove(&label);
        match often {
            HowOften::Times(times) => _ = self.interrupts.insert(label, times),
            HowOften::Every(interval) => _ = self.intervals.insert(label, interval),
        }
    }

    /// A finding about the fact of this table and key, at its place in the file if it stands in one.
    #[must_use]
    pub fn fault(
        &self,
        fact: [&str; 2],
        part: Part,
        code: Code,
        message: impl Into<String>,
        help: &str,
    ) -> Diagnostic {
        self.places.fault(fact, part, code, message.into(), help)
    }
}
