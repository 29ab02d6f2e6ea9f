//! Why a check is undecided, and the words for each reason.

use super::doubt::Doubt;
use super::{Share, UnstatedBase};
use scanbound_base::time::Picos;
use std::fmt;

/// Why a limit is neither proved nor refuted. Some reasons say what to do about the one before.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Reason {
    /// The bound may be too low.
    Doubt(Doubt),
    /// The limit lies between the lower and the upper bound.
    Between {
        /// Whether a search was cut short.
        is_cut: bool,
        /// The fact to state first, where the bound hangs on something that nobody stated.
        fact: Option<String>,
    },
    /// The same where only a clock's tolerance lies between them.
    WithinTolerance,
    /// The limit is kept with the points that the program uses, and not with all that the CPU can have.
    MorePoints {
        /// The points that it uses, of each side.
        seen: Vec<(u32, &'static str)>,
        /// All that the CPU can have.
        all: Vec<(u32, &'static str)>,
        /// The bound with those used.
        upper: Picos,
        /// The bound with all.
        most: Picos,
    },
    /// The limit is broken with the points that the program uses, and not without any.
    FewerPoints(Vec<(u32, &'static str)>),
    /// The points of these sides are to be stated; so many more than are used keep the limit, if it can be kept.
    StatePoints {
        /// The sides.
        sides: Vec<&'static str>,
        /// How many more.
        more: Option<u64>,
    },
    /// The dearest base unit was taken.
    DearestBase(UnstatedBase),
    /// A scan refutes, and no run from power-up leads to it.
    NotReached {
        /// How long it takes.
        took: Picos,
    },
    /// The program may switch a constant scan on that lasts longer.
    ConstantScan {
        /// How long it lasts at most.
        most: Picos,
        /// The relay that switches it on.
        device: &'static str,
    },
    /// The watchdog is set to what is not known.
    WatchdogUnknown {
        /// Its device.
        device: &'static str,
        /// What sets it.
        instruction: String,
        /// The device that it is set from, where it is one.
        from: Option<String>,
    },
    /// The program sets the watchdog, and its time before that is not known.
    DefaultUnknown {
        /// The watchdog's device.
        device: &'static str,
    },
    /// What the program sets the watchdog to is kept, and what it is before that is not.
    DefaultFirst {
        /// What it is at power-up.
        default: Picos,
        /// What it is set to.
        set: Picos,
        /// Its device.
        device: &'static str,
    },
    /// More than was allowed rests on assumed times.
    Assumed {
        /// How much does.
        share: Share,
        /// Whether of the scan that was found; else of the bound.
        of_lower: bool,
        /// How much may, as it was given.
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

/// `16 input and 32 output`.
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
            Reason::ConstantScan { most, device: "" } => write!(
                f,
                "a constant or minimum scan time of {most} is stated"
            ),
            Reason::ConstantScan { most, device } => write!(
                f,
                "a constant scan of {most} may be switched on ({device}): no run was found that surely does, and none is excluded"
            ),
            Reason::WatchdogUnknown { device, instruction, from } => {
                write!(f, "`{instruction}` sets the watchdog ({device}), and nothing says to what: state ")?;
                if let Some(from) = from {
                    write!(f, "the range of {from} ([ranges] {from} = [200, 500]), or ")?;
                }
                f.write_str("the watchdog's time ([scan] watchdog = \"500ms\")")
            }
            Reason::DefaultUnknown { device } => write!(
                f,
                "the program sets the watchdog ({device}), and the timing table does not say its time before that: state it ([scan] watchdog = \"200ms\"), or give the table a row @watchdog"
            ),
            Reason::DefaultFirst { default, set, device } => write!(
                f,
                "the program sets the watchdog ({device}) to {set}; before that takes effect, at the end of the first scan or at a WDT behind the instruction, it is {default}: restart it (WDT) behind that instruction"
            ),
            Reason::Between { is_cut, fact } => {
                f.write_str("the limit lies between the scan that was found and the bound")?;
                match (fact, is_cut) {
                    (Some(fact), _) => write!(
                        f,
                        ", which depends on what nobody stated: say it in a facts file (--facts), such as {fact}"
                    ),
                    (None, true) => f.write_str("; give the search more time (--time-limit)"),
                    (None, false) => f.write_str(
                        "; what is between them could not be worked out: the report lists what is over-approximated (-v)",
                    ),
                }
            }
            Reason::WithinTolerance => f.write_str(
                "the limit lies within the clock's tolerance; measure the clock and state it (--clock)",
            ),
            Reason::MorePoints { seen, all, upper, most } => write!(
                f,
                "it depends on how many I/O points are fitted, which is not stated: with the {} points that the program is seen to use no scan takes longer than {upper}, with all {} points that the CPU can have {most}",
                Sides(seen),
                Sides(all)
            ),
            Reason::FewerPoints(seen) => write!(
                f,
                "it depends on how many I/O points are fitted, which is not stated: the scan that was found is over the limit with the {} points that the program is seen to use, and not without any",
                Sides(seen)
            ),
            Reason::StatePoints { sides, more } => {
                let sides: Vec<String> = sides.iter().map(|side| format!("{side}s = N")).collect();
                let sides = sides.join(", ");
                write!(f, "state those that are fitted in a facts file (--facts): [io] {sides}")?;
                match more {
                    Some(more) => write!(
                        f,
                        "; up to {more} points more than it is seen to use keep the limit"
                    ),
                    None => Ok(()),
                }
            }
            Reason::DearestBase(UnstatedBase { side, least, saves }) => write!(
                f,
                "{side} refresh is counted on the dearest base unit, since it is not stated on which the modules sit: on the base {least} it takes {saves} less: state it in a facts file (--facts): [io] base = \"{least}\""
            ),
            Reason::NotReached { took } => write!(
                f,
                "a scan takes {took}, but no run from power-up to the state in which it starts was found (--refute reached)"
            ),
            Reason::Assumed { share, of_lower, most, first } => write!(
                f,
                "{share} of {} rests on assumed times, more than the {most} of --max-assumed: state times (--time, or a table of your own), first of {}",
                if *of_lower { "the scan that was found" } else { "the bound" },
                first.join(", ")
            ),
        }
    }
}
