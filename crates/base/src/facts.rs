//! Facts: what the user states because the source does not say it, such as ranges of words, interrupts in a scan,
//! points and networks.

mod calls;
mod places;
mod reader;

use crate::code::Code;
use crate::diagnostic::Diagnostic;
use crate::time::Picos;
use places::FactPositions;
use std::collections::BTreeMap;

pub use calls::{StatedCall, key, normalized};
pub use places::Part;
pub use reader::TABLES;

/// The user's facts. The analysis relies on them: a wrong fact can make the bound too low, so reports list all of them.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Facts {
    /// The name and the SHA-256 of the facts file; `None` if the facts come from elsewhere.
    pub read_from: Option<(String, String)>,
    /// Ranges of words, by device as written (`D100`): the least and the largest value of the device at the start of a
    /// scan, signed.
    pub ranges: BTreeMap<String, (i64, i64)>,
    /// Counts, by place (`MAIN.csv:543`) or word (`D100`) as written: the smallest and the largest. A count is the
    /// number of iterations of a loop, or of units (words, digits) that an instruction processes.
    pub counts: BTreeMap<String, (i64, i64)>,
    /// Missing routines, by the normalised name ([`normalized`]) of a routine that is not among the files, such as
    /// `P153`: its time and writes.
    pub calls: BTreeMap<String, StatedCall>,
    /// Runs of interrupts, by interrupt label in upper case (`I0`): the largest number of runs of the interrupt's
    /// routine in one scan.
    pub interrupts: BTreeMap<String, u32>,
    /// Intervals of interrupts, by interrupt label in upper case (`I28`): the interrupt occurs once in each interval of
    /// this length.
    pub intervals: BTreeMap<String, Picos>,
    /// The number of input points that the CPU refreshes. `None` if not stated.
    pub inputs: Option<u32>,
    /// The number of output points that the CPU refreshes. `None` if not stated.
    pub outputs: Option<u32>,
    /// The type of base unit that holds all modules, by its name in timing tables (`main`). `None` if not stated. What
    /// `by_base` states takes precedence.
    pub base: Option<String>,
    /// The numbers of input points (first) and of output points (second), by type of base unit. A map is empty if no
    /// number, or one number for all base units, is stated; otherwise `inputs` or `outputs` is its sum.
    pub by_base: [BTreeMap<String, u32>; 2],
    /// The longest time that network refresh takes in one scan; zero if there is no network. `None` if not stated.
    pub network: Option<Picos>,
    /// The factor by which the whole scan is multiplied, because other tasks of the CPU lengthen it. It replaces the
    /// factor of the timing table. `None` if not stated.
    pub factor: Option<StatedFactor>,
    /// A CPU parameter: whether the CPU stops at an operation error (`true`) or continues with the next instruction.
    /// `None` if not stated.
    pub stops_on_error: Option<bool>,
    /// The constant scan time, or minimum scan time, in the CPU's parameters; zero if none is set. `None` if not
    /// stated.
    pub constant_scan: Option<Picos>,
    /// The watchdog time in the CPU's parameters. `None` if not stated.
    pub watchdog: Option<Picos>,
    /// Whether a flowchart PC copies its inputs once at the start of each pass (`true`) or reads them at each test
    /// (`false`). `None` if not stated.
    pub latched: Option<bool>,
    /// A CPU parameter: the number of bits, 16 or 32, of an index to file registers and extended data registers. `None`
    /// if not stated.
    pub index_bits: Option<u32>,
    /// A CPU parameter: the number of devices of an area, by its letters as written (`ZR`, `L`).
    pub devices: BTreeMap<String, u32>,
    /// The only devices that the program writes through indirect addresses (`@D0`), as written: single devices or
    /// ranges (`ZR1000-ZR1999`). `None`: such a write may change any device.
    pub indirect: Option<Vec<String>>,
    /// Indices, by place (`MAIN.csv:924`) or index register (`Z0`): the least and the largest index with which
    /// something is written there, or through that register.
    pub indices: BTreeMap<String, (i64, i64)>,
    /// Devices that something other than the program, such as an HMI, writes between scans: single devices or ranges
    /// (`D100-D199`).
    pub external: Vec<String>,
    /// Devices that only the program writes: single devices or ranges (`M1-M9`).
    pub internal: Vec<String>,
    /// Sets of bits, as written, of which no two are on when a scan starts.
    pub exclusive: Vec<Vec<String>>,
    /// Whether the bound also covers scans after a download or a change in RUN, in which memory may hold any values.
    pub download: bool,
    /// How a controller executes charts: whether all true transitions after a step fire if they have no priorities
    /// (`true`), or only the first one (`false`). `None` if this is not stated.
    pub all_clear: Option<bool>,
    /// The order in which a chart's actions are executed in one scan. `None` if not stated.
    pub action_order: Option<ActionOrder>,
    /// How a controller executes charts: whether it executes the blocks of drawn transition conditions in each scan,
    /// and the conditions read the outputs of the previous scan. `false` if this is not stated.
    pub drawn_last_scan: bool,
    /// What the controller does in another way than the standard has it (`true`), or as the standard has it (`false`),
    /// by the description that reports give it.
    pub controller: BTreeMap<String, bool>,
    /// The positions of these facts in the facts file, for findings about them.
    pub places: FactPositions,
}

/// The order in which a chart's actions are executed within one scan.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ActionOrder {
    /// Actions are executed in the order in which the chart first names them.
    Named,
    /// Boolean variables are written first, then actions are executed in the order of their declaration.
    Declared,
    /// Actions are executed in the order of their names. Actions that have ended, and are executed a last time, come
    /// first.
    Alphabetical,
}

impl ActionOrder {
    /// All orders of actions, in the order in which error messages list them.
    pub const ALL: [ActionOrder; 3] =
        [ActionOrder::Named, ActionOrder::Declared, ActionOrder::Alphabetical];

    /// The name of the order in facts files.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            ActionOrder::Named => "named",
            ActionOrder::Declared => "declared",
            ActionOrder::Alphabetical => "alphabetical",
        }
    }
}

/// How often an interrupt routine interrupts a scan.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum InterruptRate {
    /// At most this many times in one scan.
    Times(u32),
    /// The interrupt occurs once in each interval of this length, which is not 0.
    Every(Picos),
}

impl std::str::FromStr for InterruptRate {
    type Err = ();
    fn from_str(text: &str) -> Result<InterruptRate, ()> {
        if let Ok(times) = text.parse() {
            return Ok(InterruptRate::Times(times));
        }
        let time: Picos = text.parse().map_err(|_| ())?;
        if time > Picos::ZERO { Ok(InterruptRate::Every(time)) } else { Err(()) }
    }
}

/// A factor on the scan time that the user states.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct StatedFactor {
    /// The factor in millionths, at least 1,000,000.
    pub millionths: u64,
    /// The factor as the user wrote it.
    pub text: String,
}

impl Facts {
    /// The stated number of runs of an interrupt routine in one scan. `None` if no number is stated, even if an
    /// interval is. Letter case of the label does not matter.
    #[must_use]
    pub fn interrupt(&self, label: &str) -> Option<u32> {
        self.interrupts.get(&label.to_ascii_uppercase()).copied()
    }

    /// States the rate of an interrupt routine. This replaces what the facts file states about the routine.
    pub fn state_interrupt(&mut self, label: &str, often: InterruptRate) {
        self.places.forget("interrupts", label);
        let label = label.to_ascii_uppercase();
        self.interrupts.remove(&label);
        self.intervals.remove(&label);
        match often {
            InterruptRate::Times(times) => _ = self.interrupts.insert(label, times),
            InterruptRate::Every(interval) => _ = self.intervals.insert(label, interval),
        }
    }

    /// An error about the fact with this table and key, at its position in the file if it has one.
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
