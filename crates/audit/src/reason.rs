//! Why a check is undecided, and the text for each reason.

use super::doubt::Doubt;
use super::{Share, UnstatedBase};
use scanbound_base::time::Picos;
use std::fmt;

/// Why a limit is neither proved nor refuted. Some reasons only add what to do about the one before.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Reason {
    /// The bound may be too low.
    Doubt(Doubt),
    /// The limit is between the lower and the upper bound.
    Between {
        /// Whether a search was cut short.
        is_cut: bool,
        /// The fact to state first, if the bound depends on something that nobody stated.
        fact: Option<String>,
    },
    /// The limit is between the bounds, but only because of a clock's tolerance.
    WithinTolerance,
    /// The limit is kept with the points that the program uses, but not with all that the CPU can have.
    MorePoints {
        /// The numbers of points that it uses, for inputs and outputs.
        seen: Vec<(u32, &'static str)>,
        /// The numbers of points that the CPU can have.
        all: Vec<(u32, &'static str)>,
        /// The bound with the points that it uses.
        upper: Picos,
        /// The bound with all points.
        most: Picos,
    },
    /// The limit is exceeded with the points that the program uses, but not without any points.
    FewerPoints(Vec<(u32, &'static str)>),
    /// The numbers of these points should be stated.
    StatePoints {
        /// `input`, `output` or both.
        sides: Vec<&'static str>,
        /// How many more points than are used still keep the limit. `None` if the limit cannot be kept.
        more: Option<u64>,
    },
    /// The slowest base unit was assumed.
    SlowestBase(UnstatedBase),
    /// A scan exceeds the limit, but no run from power-up to it was found.
    NotReached {
        /// The time of that scan.
        took: Picos,
    },
    /// The program may switch on a constant scan that exceeds the limit.
    ConstantScan {
        /// The largest constant scan time.
        most: Picos,
        /// The most that interrupts add that occur just before the wait ends.
        interrupts: Picos,
        /// The relay that switches it on.
        device: &'static str,
    },
    /// The watchdog is set to an unknown value.
    WatchdogUnknown {
        /// The device that holds the watchdog time.
        device: &'static str,
        /// The instruction that sets it.
        instruction: String,
        /// The device whose value it is set to, if there is one.
        from: Option<String>,
    },
    /// The program sets the watchdog, and its time before that is unknown.
    DefaultUnknown {
        /// The watchdog's device.
        device: &'static str,
    },
    /// The watchdog time that the program sets is kept, but not the one before that.
    DefaultFirst {
        /// The watchdog time at power-up.
        default: Picos,
        /// The time that the program sets.
        set: Picos,
        /// The device that holds it.
        device: &'static str,
    },
    /// More than the permitted share rests on assumed times.
    Assumed {
        /// The share.
        share: Share,
        /// True: the share of the longest scan found. False: of the bound.
        of_lower: bool,
        /// The permitted share, as it was given.
        most: String,
        /// The times to state first.
        first: Vec<String>,
    },
}

impl From<&Doubt> for Reason {
    fn from(doubt: &Doubt) -> Reason {
        Reason::Doubt(doubt.clone())
    }
}

/// Written as `16 input and 32 output`.
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
                    "" => write!(f, "a constant or minimum scan time of {most} is stated"),
                    _ => write!(
                        f,
                        "a constant scan of {most} may be switched on ({device}): it is not decided whether a run does so"
                    ),
                }?;
                match *interrupts {
                    Picos::ZERO => Ok(()),
                    _ => write!(
                        f,
                        "; interrupts just before the end of the wait add up to {interrupts}"
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
                "the program sets the watchdog ({device}), but its time before that is unknown: state it ([scan] watchdog = \"200ms\"), or add a row @watchdog to the table"
            ),
            Reason::DefaultFirst { default, set, device } => write!(
                f,
                "the program sets the watchdog ({device}) to {set}, but it stays {default} until the first scan ends or a WDT restarts it: add a WDT after that instruction"
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
                "the limit is within the clock's tolerance; measure the clock and state it (--clock)",
            ),
            Reason::MorePoints { seen, all, upper, most } => write!(
                f,
                "it depends on the number of I/O points, which is not stated: with the {} points that the program uses, no scan takes longer than {upper}; with all {} points that the CPU can have, {most}",
                Sides(seen),
                Sides(all)
            ),
            Reason::FewerPoints(seen) => write!(
                f,
                "it depends on the number of I/O points, which is not stated: the longest scan found is over the limit with the {} points that the program uses, but not without them",
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
                "{side} refresh is charged for the slowest base unit, because the base units are not stated; on the base {least} it takes {saves} less: state it in a facts file (--facts): [io] base = \"{least}\""
            ),
            Reason::NotReached { took } => write!(
                f,
                "a scan takes {took}, but no run from power-up to its start state was found (--refute reached)"
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
