//! The user's statements on which the bound rests, and how reports word them.

use super::proved::Proved;
use super::request::Request;
use scanbound_base::facts::{ActionOrder, StatedCall, StatedFactor};
use scanbound_base::time::Picos;
use scanbound_ir::Program;
use scanbound_timing::table::{Override, StatedClock};
use std::collections::BTreeMap;
use std::fmt;

/// Whether a statement of the user is proved, or can be.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Status {
    /// Proved by induction: in every scan that starts with the stated facts true, this one is also true at the end.
    Kept,
    /// The statement is about values that the program computes, and is not proved.
    Unproved,
    /// The statement is about the plant or the PLC, so nothing in a program could prove it.
    Stated,
}

impl Status {
    /// The word for the status in reports.
    #[must_use]
    pub fn word(self) -> &'static str {
        match self {
            Status::Kept => "kept",
            Status::Unproved => "unproved",
            Status::Stated => "stated",
        }
    }
}

/// A statement of the user on which the bound rests.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Fact {
    /// The range of a word, or of two words as one number, whenever a scan starts.
    Range {
        /// The word whose range is stated, as the user wrote it.
        word: String,
        /// The smallest value of the word, signed.
        low: i64,
        /// The largest value of the word, signed.
        high: i64,
        /// Whether it was proved that a scan that starts with the stated facts true does not leave the word outside the
        /// range.
        is_kept: bool,
    },
    /// The number of iterations of a loop, or of units that an instruction handles.
    Count {
        /// The place of the instruction (`MAIN.csv:543`), or the word that holds the number (`D100`).
        at: String,
        /// The smallest number of iterations or units.
        low: i64,
        /// The largest number of iterations or units.
        high: i64,
    },
    /// The value of an index where it selects the device that an instruction writes.
    Index {
        /// The place of the instruction that writes (`MAIN.csv:924`), or the index register (`Z0`).
        at: String,
        /// The smallest value of the index.
        low: i64,
        /// The largest value of the index.
        high: i64,
    },
    /// The time and the writes of a routine whose code is not among the files.
    Call {
        /// The name of the routine.
        name: String,
        /// The longest time of one call of the routine.
        time: Picos,
        /// The devices that the routine writes. `None` if not stated: then it may write any device, unless `declared`
        /// is true.
        writes: Option<Vec<String>>,
        /// Whether the routine's declaration is given. If so, the routine writes its output parameters, its own
        /// variables, and what `writes` lists.
        declared: bool,
    },
    /// The number of bits, 16 or 32, of an index to file registers.
    IndexBits(u32),
    /// The number of devices of an area: its letters and the number.
    Devices(String, u32),
    /// The only devices that are written through indirect addresses (`@`). Empty: none is.
    Indirect(Vec<String>),
    /// Devices that other writers than the program may write between scans, such as an operator panel.
    External(Vec<String>),
    /// Devices that only the program writes.
    Internal(Vec<String>),
    /// A set of bits of which at most one is on when a scan starts.
    Exclusive {
        /// The bits of which at most one is on.
        bits: Vec<String>,
        /// Whether it was proved that a scan that starts with the stated facts true does not leave two of the bits on.
        is_kept: bool,
    },
    /// Memory may have any values when a scan starts, as after a download.
    Download,
    /// Whether all true transitions after a step of a chart fire if they have no priorities (`true`), or only the first
    /// one.
    AllClear(bool),
    /// The order in which a chart's actions run within one scan.
    ActionOrder(ActionOrder),
    /// Transition conditions of a chart that are drawn as a diagram use the outputs that their blocks computed in the
    /// previous scan.
    DrawnLastScan,
    /// Whether the user's controller behaves in one of the ways in which controllers differ from the standard.
    Controller {
        /// The behaviour in words, as the facts file names it.
        what: String,
        /// True: the controller behaves so. False: it behaves as the standard says.
        holds: bool,
    },
    /// How often a routine interrupts a scan.
    Interrupts {
        /// The name of the interrupt routine.
        name: String,
        /// The largest number of interrupts in a scan, as stated or as computed from the interval.
        times: u32,
        /// The stated interval. `None` if the number itself was stated.
        every: Option<Picos>,
    },
    /// The times of an instruction. They replace those of the timing table.
    Time(Override),
    /// Whether the CPU stops at an operation error (`true`) or continues with the next instruction.
    StopsOnError(bool),
    /// Whether a flowchart PC reads its inputs once per pass into an image (`true`), or at each test.
    Latched(bool),
    /// The number of inputs or outputs that the CPU refreshes in each scan.
    Points {
        /// `input` or `output`.
        side: &'static str,
        /// The number of points.
        points: u32,
        /// The number of points on each kind of base unit. Empty if the user states one number for all.
        by_base: BTreeMap<String, u32>,
    },
    /// The kind of base unit on which all I/O modules are mounted.
    Base(String),
    /// The longest time of network refresh in one scan. Zero means that no network is refreshed.
    Network(Picos),
    /// The factor by which other services of the CPU lengthen a scan at most, as the user wrote it. It replaces the
    /// factor of the timing table.
    Factor(String),
    /// A constant or minimum scan time. Zero means that none is set.
    ConstantScan(Picos),
    /// The watchdog time in the CPU's parameters.
    Watchdog(Picos),
    /// The clock of a CPU that executes one program word per clock period.
    Clock(StatedClock),
}

impl Fact {
    /// Whether the statement is proved. Only ranges and sets of exclusive bits can be; counts and indices are always
    /// [`Status::Unproved`], and all other statements [`Status::Stated`].
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

    /// The statements of the user on which the bound rests, in the order of reports. Left out are those under [calls]
    /// about routines whose code is given or that nothing calls. `proved` says which statements are proved.
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
        let controller = facts.controller.iter();
        let controller =
            controller.map(|(what, &holds)| Fact::Controller { what: what.clone(), holds });
        let devices = facts.devices.iter();
        let devices = devices.map(|(letters, &count)| Fact::Devices(letters.clone(), count));
        let factor = facts.factor.iter().map(|StatedFactor { text, .. }| text.clone());
        ranges
            .chain(counts)
            .chain(calls)
            .chain(facts.index_bits.map(Fact::IndexBits))
            .chain(devices)
            .chain(indices)
            .chain(facts.indirect.clone().map(Fact::Indirect))
            .chain((!facts.external.is_empty()).then(|| Fact::External(facts.external.clone())))
            .chain((!facts.internal.is_empty()).then(|| Fact::Internal(facts.internal.clone())))
            .chain(exclusive)
            .chain(facts.download.then_some(Fact::Download))
            .chain(facts.all_clear.map(Fact::AllClear))
            .chain(facts.action_order.map(Fact::ActionOrder))
            .chain(facts.drawn_last_scan.then_some(Fact::DrawnLastScan))
            .chain(controller)
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
            Fact::Count { at, low, high } => {
                // A place has a colon; a word is the number wherever instructions read it.
                let of = if at.contains(':') { "at" } else { "from the word" };
                write!(f, "the number of iterations or units {of} {at} is {low}")?;
                if low == high { Ok(()) } else { write!(f, " to {high}") }
            }
            Fact::Index { at, low, high } => {
                let at = if at.contains(':') { format!("at {at}") } else { at.clone() };
                write!(f, "the index {at} is {low} to {high} where it selects the written device")
            }
            Fact::Call { name, time, writes, declared: true } => {
                write!(f, "the code of {name} is not given: {name} takes at most {time}, and writes only its output parameters and its own variables")?;
                match writes.as_deref() {
                    None | Some([]) => Ok(()),
                    Some(variables) => write!(f, ", and {}", variables.join(", ")),
                }
            }
            Fact::Call { name, time, writes, declared: false } => {
                write!(f, "the code of the routine {name} is not given: the routine takes at most {time}, and ")?;
                match writes.as_deref() {
                    None => f.write_str("may write anything"),
                    Some([]) => f.write_str("writes nothing"),
                    Some(devices) => write!(f, "writes only {}", devices.join(", ")),
                }
            }
            Fact::IndexBits(bits) => write!(f, "an index to file registers has {bits} bits"),
            Fact::Devices(letters, count) => write!(f, "the CPU has {count} devices {letters}"),
            Fact::Indirect(devices) if devices.is_empty() => {
                f.write_str("nothing is written through @")
            }
            Fact::Indirect(devices) => {
                write!(f, "indirect addresses (@) write only to {}", devices.join(", "))
            }
            Fact::External(devices) => {
                write!(f, "other writers than the program may also write {}", devices.join(", "))
            }
            Fact::Internal(devices) => {
                write!(f, "only the program writes {}", devices.join(", "))
            }
            Fact::Exclusive { bits, .. } => {
                write!(f, "at most one of {} is on when a scan starts", bits.join(", "))
            }
            Fact::Download => f.write_str("memory may have any values when a scan starts"),
            Fact::AllClear(true) => f.write_str(
                "if several transitions without priorities after the same step are true, all of them fire",
            ),
            Fact::AllClear(false) => f.write_str(
                "if several transitions without priorities after the same step are true, the first of them fires",
            ),
            Fact::Controller { what, holds: true } => write!(f, "the controller does this: {what}"),
            Fact::Controller { what, holds: false } => write!(f, "the controller does not do this: {what}"),
            Fact::ActionOrder(ActionOrder::Named) => {
                f.write_str("actions run in the order in which the chart first names them")
            }
            Fact::ActionOrder(ActionOrder::Declared) => f.write_str(
                "Boolean variables of actions are written first, then actions run in the order of their declarations",
            ),
            Fact::ActionOrder(ActionOrder::Alphabetical) => f.write_str(
                "actions that have just ended run first, then the other actions, each of the two in the order of their names",
            ),
            Fact::DrawnLastScan => f.write_str(
                "transition conditions drawn as a diagram use the outputs that their blocks computed in the previous scan",
            ),
            Fact::Interrupts { name, times, every: Some(every) } => {
                write!(f, "the interrupt {name} occurs every {every}: at most {times} times in a scan")
            }
            Fact::Interrupts { name, times, every: None } => {
                write!(f, "the interrupt {name} interrupts a scan at most {times} times")
            }
            Fact::Time(Override { name, on, off }) if on == off => write!(f, "{name} takes {on}"),
            Fact::Time(Override { name, on, off }) => {
                write!(f, "{name} takes {on} if it is executed, and {off} if its condition is off")
            }
            Fact::StopsOnError(true) => f.write_str("the CPU stops at an operation error"),
            Fact::StopsOnError(false) => f.write_str("the CPU continues after an operation error"),
            Fact::Latched(true) => f.write_str("the inputs are copied to an image once per pass"),
            Fact::Latched(false) => f.write_str("each instruction that tests an input reads the input itself"),
            Fact::Points { side, points, by_base } => {
                write!(f, "{points} {side} points are refreshed")?;
                let bases = by_base.iter().map(|(base, points)| format!("{points} on {base}"));
                match bases.collect::<Vec<_>>().as_slice() {
                    [] => Ok(()),
                    bases => write!(f, ": {}", bases.join(", ")),
                }
            }
            Fact::Base(base) => write!(f, "all I/O modules are on the base {base}"),
            Fact::Network(Picos::ZERO) => f.write_str("no network is refreshed"),
            Fact::Network(time) => {
                write!(f, "network refresh takes at most {time} per scan")
            }
            Fact::Factor(text) => {
                write!(f, "other services of the CPU lengthen a scan by at most the factor {text}")
            }
            Fact::ConstantScan(Picos::ZERO) => {
                f.write_str("no constant or minimum scan time is set")
            }
            Fact::ConstantScan(time) => write!(f, "each scan takes at least {time}"),
            Fact::Watchdog(time) => write!(f, "the watchdog is set to {time}"),
            Fact::Clock(clock) => clock.fmt(f),
        }
    }
}
