//! Why a check is undecided, and the text for each reason.

use super::doubt::Doubt;
use super::{Share, UnstatedBase};
use scanbound_base::time::Picos;
use std::fmt;

/// Why a limit is neither proved nor refuted. Some reasons only say what to do about the reason before them.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Reason {
    /// The bound may be too low, for this reason.
    Doubt(Doubt),
    /// The limit is between the lower and the upper bound.
    Between {
        /// Whether a search was ended by the time limit or the user.
        is_cut: bool,
        /// The fact that the user should state first, if the bound depends on a fact that is not stated.
        fact: Option<String>,
    },
    /// The limit is between the bounds only because the clock is known within a tolerance.
    WithinTolerance,
    /// The limit is not exceeded with the points that the program uses, but may be with all points that the CPU can
    /// have.
    MorePoints {
        /// For inputs and outputs (`input`, `output`): the number of points that the program uses.
        seen: Vec<(u32, &'static str)>,
        /// For inputs and outputs (`input`, `output`): the number of points that the CPU can have.
        all: Vec<(u32, &'static str)>,
        /// The upper bound with only the points that the program uses.
        upper: Picos,
        /// The upper bound with all points that the CPU can have.
        most: Picos,
    },
    /// The limit is exceeded with the points that the program uses (their number and `input` or `output`), but not
    /// without any points.
    FewerPoints(Vec<(u32, &'static str)>),
    /// The user should state the number of input points, output points or both.
    StatePoints {
        /// `input`, `output` or both.
        sides: Vec<&'static str>,
        /// A number of points that can be added to those charged so that still no scan exceeds the limit. `None` if the
        /// limit is exceeded even without additional points.
        more: Option<u64>,
    },
    /// The refresh was charged for the slowest base unit, because the base units are not stated.
    SlowestBase(UnstatedBase),
    /// A scan exceeds the limit, but no run from power-up to it was found.
    NotReached {
        /// The time of the scan that exceeds the limit.
        took: Picos,
    },
    /// The constant scan time exceeds the limit, and it is set, or the program may switch it on.
    ConstantScan {
        /// The largest constant scan time.
        most: Picos,
        /// The longest time that interrupts just before the end of the wait add.
        interrupts: Picos,
        /// The relay that switches constant scan on. Empty if the constant scan time is certain.
        device: &'static str,
    },
    /// The watchdog is set to an unknown value.
    WatchdogUnknown {
        /// The device that holds the watchdog time.
        device: &'static str,
        /// The text of the instruction that sets the watchdog.
        instruction: String,
        /// The device from which the watchdog time is set. `None` if there is none.
        from: Option<String>,
    },
    /// The watchdog time before the program sets it (the CPU's default) is unknown.
    DefaultUnknown {
        /// The device that holds the watchdog time.
        device: &'static str,
    },
    /// The watchdog time that the program sets is long enough, but the default, which applies until then, is not.
    DefaultFirst {
        /// The watchdog time from power-up until the program sets it.
        default: Picos,
        /// The watchdog time that the program sets.
        set: Picos,
        /// The device that holds the watchdog time.
        device: &'static str,
    },
    /// More than the permitted share of the deciding time rests on assumed times.
    Assumed {
        /// The share of the deciding time that rests on assumed times.
        share: Share,
        /// True: the share of the longest scan found is meant. False: that of the bound.
        of_lower: bool,
        /// The largest permitted share, as the user gave it.
        most: String,
        /// The names of the assumed times to state first: those on which most of the bound rests.
        first: Vec<String>,
    },
}

impl From<&Doubt> for Reason {
    fn from(doubt: &Doubt) -> Reason {
        Reason::Doubt(doubt.clone())
    }
}

/// Numbers of points, written as `16 input and 32 output`.
struct Sides<'a>(&'a [(u32, &'static str)]);

impl fmt::Display for Sides<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (at, (points, side)) in self.0.iter().enumerate() {
            let and = if at > 0 { " and " } else { "" };
            write!(f, "{and}{points} {side}")?;
        }
        Ok(())
    }
}

impl fmt::Display for Reason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Reason::Doubt(doubt) => doubt.fmt(f),
            Reason::ConstantScan { most, interrupts, device } => {
                match *device {
                    "" => write!(f, "a scan may exceed the limit because it takes at least the constant or minimum scan time of {most}"),
                    _ => write!(
                        f,
                        "the program may switch on a constant scan of {most} ({device}), but no run that does so was found"
                    ),
                }?;
                match *interrupts {
                    Picos::ZERO => Ok(()),
                    _ => write!(
                        f,
                        "; interrupts near the end of this time can lengthen the scan by {interrupts}"
                    ),
                }
            }
            Reason::WatchdogUnknown { device, instruction, from } => {
                write!(f, "`{instruction}` sets the watchdog ({device}) to an unknown value: state ")?;
                if let Some(from) = from {
                    write!(f, "the range of {from} ([ranges] {from} = [200, 500]), or ")?;
                }
                f.write_str("the watchdog's time ([scan] watchdog = \"500ms\")")
            }
            Reason::DefaultUnknown { device } => write!(
                f,
                "the program sets the watchdog ({device}), but the watchdog time before that is unknown: state it ([scan] watchdog = \"200ms\"), or add a row @watchdog to the table"
            ),
            Reason::DefaultFirst { default, set, device } => write!(
                f,
                "the program sets the watchdog ({device}) to {set}, but the watchdog time stays {default} until the first scan ends or a WDT restarts the watchdog: add a WDT after the instruction that sets it"
            ),
            Reason::Between { is_cut, fact } => {
                f.write_str("the limit is between the longest scan found and the bound")?;
                match (fact, is_cut) {
                    (Some(fact), _) => write!(
                        f,
                        ", and the bound depends on a fact that is not stated: state it in a facts file (--facts), such as {fact}"
                    ),
                    (None, true) => f.write_str("; give the search more time (--time-limit)"),
                    (None, false) => f.write_str(
                        "; over-approximation causes the difference: the report lists the places (-v)",
                    ),
                }
            }
            Reason::WithinTolerance => f.write_str(
                "whether scans exceed the limit depends on the clock, which is only known within a tolerance; measure the clock and state it (--clock)",
            ),
            Reason::MorePoints { seen, all, upper, most } => write!(
                f,
                "the result depends on the number of I/O points, which is not stated: with the {} points that the program uses, no scan takes longer than {upper}; with all {} points that the CPU can have, {most}",
                Sides(seen),
                Sides(all)
            ),
            Reason::FewerPoints(seen) => write!(
                f,
                "the result depends on the number of I/O points, which is not stated: the longest scan found is over the limit with the refresh of the {} points that the program uses, but not without this refresh",
                Sides(seen)
            ),
            Reason::StatePoints { sides, more } => {
                let sides: Vec<String> = sides.iter().map(|side| format!("{side}s = N")).collect();
                let sides = sides.join(", ");
                write!(f, "state the number of points in a facts file (--facts): [io] {sides}")?;
                match more {
                    Some(more) => write!(
                        f,
                        "; up to {more} additional points keep the limit"
                    ),
                    None => Ok(()),
                }
            }
            Reason::SlowestBase(UnstatedBase { side, least, saves }) => write!(
                f,
                "{side} refresh is charged for the slowest base unit, because the base units are not stated; on the base unit {least} the refresh takes {saves} less: state the base unit in a facts file (--facts): [io] base = \"{least}\""
            ),
            Reason::NotReached { took } => write!(
                f,
                "the longest scan found takes {took}, but no run from power-up to its start state was found, as --refute reached requires"
            ),
            Reason::Assumed { share, of_lower, most, first } => write!(
                f,
                "{share} of {} rests on assumed times, more than the {most} of --max-assumed: state times (--time, or your own table), first for {}",
                if *of_lower { "the longest scan found" } else { "the bound" },
                first.join(", ")
            ),
        }
    }
}
