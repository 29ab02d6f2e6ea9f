//! What the user stated and the bound rests on, and the words for it.

use super::proved::Proved;
use super::request::Request;
use scanbound_base::facts::{ActionOrder, StatedCall, StatedFactor};
use scanbound_base::time::Picos;
use scanbound_ir::Program;
use scanbound_timing::table::{Override, StatedClock};
use std::collections::BTreeMap;
use std::fmt;

/// How something stated stands to the program.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Status {
    /// The program writes nothing else into the word, or never leaves two of the bits on, if scans start as stated.
    Kept,
    /// Nothing here proves it.
    Unproved,
    /// It is about the plant or the PLC: nothing in a program could prove it.
    Stated,
}

impl Status {
    /// Its word in reports.
    #[must_use]
    pub fn word(self) -> &'static str {
        match self {
            Status::Kept => "kept",
            Status::Unproved => "unproved",
            Status::Stated => "stated",
        }
    }
}

/// Something that the user stated.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Fact {
    /// What a word, or two read as one number, holds whenever a scan starts.
    Range {
        /// The word.
        word: String,
        /// Its least value.
        low: i64,
        /// Its largest one.
        high: i64,
        /// Whether the program keeps it.
        is_kept: bool,
    },
    /// What a count is at a place.
    Count {
        /// The place.
        at: String,
        /// The least count.
        low: i64,
        /// The largest one.
        high: i64,
    },
    /// What an index is where something is written by it.
    Index {
        /// The place, or the register.
        at: String,
        /// The least.
        low: i64,
        /// The largest.
        high: i64,
    },
    /// A routine that is not there.
    Call {
        /// The routine.
        name: String,
        /// What it takes.
        time: Picos,
        /// What it writes, if that is stated.
        writes: Option<Vec<String>>,
        /// Whether its declaration is there: besides, it writes what it is handed and what it holds itself.
        declared: bool,
    },
    /// How many bits an index to file registers has.
    IndexBits(u32),
    /// The only devices that are written through indirect addresses.
    Indirect(Vec<String>),
    /// What others than the program write.
    External(Vec<String>),
    /// What nobody but the program writes.
    Internal(Vec<String>),
    /// Of these bits no two are on when a scan starts.
    Exclusive {
        /// The bits.
        bits: Vec<String>,
        /// Whether the program keeps them apart.
        is_kept: bool,
    },
    /// Memory may hold anything when a scan starts, as after a download.
    Download,
    /// Transitions that compete without priorities all clear if they are true.
    AllClear,
    /// The order of a chart's actions.
    ActionOrder(ActionOrder),
    /// How often a routine interrupts a scan.
    Interrupts {
        /// The routine.
        name: String,
        /// The most interrupts in a scan.
        times: u32,
        /// The interval that is stated, from which that was worked out.
        every: Option<Picos>,
    },
    /// An instruction's times.
    Time(Override),
    /// Whether the CPU stops at an operation error.
    StopsOnError(bool),
    /// A flowchart PC reads its inputs once a pass, into an image, or at each test.
    Latched(bool),
    /// How many points of a side are refreshed.
    Points {
        /// `input` or `output`.
        side: &'static str,
        /// How many.
        points: u32,
        /// Those of each kind of base, where they are told apart.
        by_base: BTreeMap<String, u32>,
    },
    /// The base unit of all modules.
    Base(String),
    /// What networks take to refresh.
    Network(Picos),
    /// A factor on the whole scan.
    Factor(String),
    /// A constant or minimum scan time; none if it is zero.
    ConstantScan(Picos),
    /// The watchdog's time.
    Watchdog(Picos),
    /// A clock.
    Clock(StatedClock),
}

impl Fact {
    /// How it stands to the program.
    #[must_use]
    pub fn status(&self) -> Status {
        match self {
            Fact::Range { is_kept: true, .. } | Fact::Exclusive { is_kept: true, .. } => {
                Status::Kept
            }
            Fact::Range { .. }
            | Fact::Count { .. }
            | Fact::Index { .. }
            | Fact::Exclusive { .. } => Status::Unproved,
            _ => Status::Stated,
        }
    }

    /// What the request states of the program, of which so much is proved to be kept.
    pub(super) fn all(request: &Request<'_>, program: &Program, proved: &Proved) -> Vec<Fact> {
        let facts = request.facts;
        let ranges = facts.ranges.iter().map(|(word, &(low, high))| {
            let is_kept = proved.ranges.contains(word);
            Fact::Range { word: word.clone(), low, high, is_kept }
        });
        let counts = facts.counts.iter().map(|(at, &(low, high))| {
            let at = at.clone();
            Fact::Count { at, low, high }
        });
        let indices = facts.indices.iter().map(|(at, &(low, high))| {
            let at = at.clone();
            Fact::Index { at, low, high }
        });
        let lacked = |name: &String| program.missing_routines.iter().any(|one| one.name == *name);
        let calls = facts.calls.iter().filter(|(name, _)| lacked(name));
        let calls = calls.map(|(plain, call)| {
            let StatedCall { name, time, writes } = call.clone();
            let declared =
                program.missing_routines.iter().any(|one| one.name == *plain && one.declared);
            Fact::Call { name, time, writes, declared }
        });
        let interrupts = program.interrupts.iter().filter(|one| one.stated);
        let interrupts = interrupts.map(|one| Fact::Interrupts {
            name: one.name.clone(),
            times: one.times,
            every: facts.intervals.get(&one.name.to_ascii_uppercase()).copied(),
        });
        let [inputs, outputs] = &facts.by_base;
        let sides = [("input", facts.inputs, inputs), ("output", facts.outputs, outputs)];
        let points = sides.into_iter().filter_map(|(side, points, by_base)| {
            Some(Fact::Points { side, points: points?, by_base: by_base.clone() })
        });
        let exclusive = facts.exclusive.iter().enumerate().map(|(at, bits)| Fact::Exclusive {
            bits: bits.clone(),
            is_kept: proved.exclusive.contains(&at),
        });
        let factor = facts.factor.iter().map(|StatedFactor { text, .. }| text.clone());
        ranges
            .chain(counts)
            .chain(calls)
            .chain(facts.index_bits.map(Fact::IndexBits))
            .chain(indices)
            .chain(facts.indirect.clone().map(Fact::Indirect))
            .chain((!facts.external.is_empty()).then(|| Fact::External(facts.external.clone())))
            .chain((!facts.internal.is_empty()).then(|| Fact::Internal(facts.internal.clone())))
            .chain(exclusive)
            .chain(facts.download.then_some(Fact::Download))
            .chain(facts.all_clear.then_some(Fact::AllClear))
            .chain(facts.action_order.map(Fact::ActionOrder))
            .chain(interrupts)
            .chain(request.times.iter().cloned().map(Fact::Time))
            .chain(facts.stops_on_error.map(Fact::StopsOnError))
            .chain(facts.latched.map(Fact::Latched))
            .chain(points)
            .chain(facts.base.iter().cloned().map(Fact::Base))
            .chain(facts.network.map(Fact::Network))
            .chain(factor.map(Fact::Factor))
            .chain(facts.constant_scan.map(Fact::ConstantScan))
            .chain(facts.watchdog.map(Fact::Watchdog))
            .chain(request.clock.cloned().map(Fact::Clock))
            .collect()
    }
}

impl fmt::Display for Fact {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Fact::Range { word, low, high, .. } => {
                write!(f, "{word} is {low} to {high} when the scan starts")
            }
            Fact::Count { at, low, high } if low == high => {
                write!(f, "the count at {at} is {low}")
            }
            Fact::Count { at, low, high } => write!(f, "the count at {at} is {low} to {high}"),
            Fact::Index { at, low, high } => {
                let at = if at.contains(':') { format!("at {at}") } else { at.clone() };
                write!(f, "the index {at} is {low} to {high} where it says what is written")
            }
            Fact::Call { name, time, writes, declared: true } => {
                write!(f, "the body of {name} is not there: it takes {time} at most, and writes what it is handed and holds itself")?;
                match writes.as_deref() {
                    None | Some([]) => Ok(()),
                    Some(variables) => write!(f, ", and {}", variables.join(", ")),
                }
            }
            Fact::Call { name, time, writes, declared: false } => {
                write!(f, "the routine {name} is not there: it takes {time} at most, and ")?;
                match writes.as_deref() {
                    None => f.write_str("may write anything"),
                    Some([]) => f.write_str("writes nothing"),
                    Some(devices) => write!(f, "writes {} only", devices.join(", ")),
                }
            }
            Fact::IndexBits(bits) => write!(f, "an index to file registers has {bits} bits"),
            Fact::Indirect(devices) if devices.is_empty() => {
                f.write_str("nothing is written through @")
            }
            Fact::Indirect(devices) => {
                write!(f, "what is written through @ is {} only", devices.join(", "))
            }
            Fact::External(devices) => {
                write!(f, "others than the program write {}", devices.join(", "))
            }
            Fact::Internal(devices) => {
                write!(f, "nobody but the program writes {}", devices.join(", "))
            }
            Fact::Exclusive { bits, .. } => {
                write!(f, "of {} no two are on when a scan starts", bits.join(", "))
            }
            Fact::Download => f.write_str("memory may hold anything when a scan starts"),
            Fact::AllClear => f.write_str(
                "of transitions that compete for a step without priorities, all clear that are true",
            ),
            Fact::ActionOrder(ActionOrder::Named) => {
                f.write_str("actions are carried out as the chart first names them")
            }
            Fact::ActionOrder(ActionOrder::Declared) => f.write_str(
                "Boolean variables of actions are written first, then actions are carried out as they are declared",
            ),
            Fact::ActionOrder(ActionOrder::Alphabetical) => f.write_str(
                "actions are carried out by their names, those that have ended before the others",
            ),
            Fact::Interrupts { name, times, every: Some(every) } => {
                write!(f, "{name} comes every {every}: at most {times} times in a scan")
            }
            Fact::Interrupts { name, times, every: None } => {
                write!(f, "{name} interrupts a scan at most {times} times")
            }
            Fact::Time(Override { name, on, off }) if on == off => write!(f, "{name} takes {on}"),
            Fact::Time(Override { name, on, off }) => {
                write!(f, "{name} takes {on}, {off} where it does not run")
            }
            Fact::StopsOnError(true) => f.write_str("the CPU stops at an operation error"),
            Fact::StopsOnError(false) => f.write_str("the CPU goes on after an operation error"),
            Fact::Latched(true) => f.write_str("inputs are read once a pass, into an image"),
            Fact::Latched(false) => f.write_str("inputs are read at each test"),
            Fact::Points { side, points, by_base } => {
                write!(f, "{points} {side} points are refreshed")?;
                let bases = by_base.iter().map(|(base, points)| format!("{points} on {base}"));
                match bases.collect::<Vec<_>>().as_slice() {
                    [] => Ok(()),
                    bases => write!(f, ": {}", bases.join(", ")),
                }
            }
            Fact::Base(base) => write!(f, "all I/O modules sit on the base {base}"),
            Fact::Network(Picos::ZERO) => f.write_str("no network is refreshed"),
            Fact::Network(time) => {
                write!(f, "the refresh of networks takes {time} a scan at most")
            }
            Fact::Factor(text) => {
                write!(f, "what else the CPU serves lengthens a scan by the factor {text} at most")
            }
            Fact::ConstantScan(Picos::ZERO) => {
                f.write_str("no constant or minimum scan time is set")
            }
            Fact::ConstantScan(time) => write!(f, "each scan lasts {time} at least"),
            Fact::Watchdog(time) => write!(f, "the watchdog is set to {time}"),
            Fact::Clock(clock) => clock.fmt(f),
        }
    }
}
