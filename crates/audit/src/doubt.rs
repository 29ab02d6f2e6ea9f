//! Why a bound may be too low: mostly facts that it needs and that are not stated, with the message for each case.

use super::{Cycle, LoopUse, NetworkUse};
use scanbound_base::time::Picos;
use scanbound_ir::Program;
use scanbound_timing::price::{MorePoints, Prices, UnstatedPoints};
use std::fmt;

/// The largest number of undecided loops that are listed one by one.
const MAX_LISTED: usize = 10;

/// One reason why a bound may be too low. Its text for reports is its `Display`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Doubt {
    /// The number of inputs or outputs that the CPU refreshes is not stated. The points that the program uses were
    /// charged.
    Points(UnstatedPoints),
    /// It is not stated how often a routine interrupts a scan.
    Interrupts {
        /// The name of the interrupt routine.
        name: String,
        /// The number of interrupts in a scan that was assumed.
        taken: u32,
    },
    /// By the stated interval, a routine is due more often in the longest scan than was charged.
    TooFewInterrupts {
        /// The name of the interrupt routine.
        name: String,
        /// The interval at which the interrupt occurs.
        every: Picos,
        /// The number of interrupts in a scan that was charged.
        taken: u32,
        /// The number of times that the interrupt is due in the longest scan, with all points that the CPU can have.
        due: u64,
    },
    /// The program uses network devices, and the time of network refresh is not stated. The bound does not include it.
    Networks {
        /// The network devices that the program uses, as a list for reports.
        what: String,
        /// The file and line of the first use.
        first: (String, u32),
    },
    /// A scan can reach a loop for which no end is known.
    Endless {
        /// The line to which control jumps back.
        line: u32,
        /// True: a scan can stay in the loop for ever. False: nothing is known that ends the loop.
        certain: bool,
    },
    /// It was not decided whether a scan can reach a loop for which no end is known.
    PerhapsEndless {
        /// The line to which control jumps back.
        line: u32,
    },
    /// The number of further loops as in [`Doubt::PerhapsEndless`], which are not listed one by one.
    MorePerhapsEndless(usize),
    /// Called functions or function blocks have no body. They were assumed to do nothing.
    Bodiless {
        /// The names of the functions and function blocks without a body.
        names: Vec<String>,
        /// The file and line of the first call.
        first: (String, u32),
    },
    /// The bound is not below this time, that of the shortest timer, although it assumes that no timer times out in the
    /// scan that starts it.
    OutlastsTimer(Picos),
    /// The program may switch on a constant scan whose time is unknown.
    ConstantScan {
        /// The register that holds the constant scan time.
        device: &'static str,
        /// The device from which the program sets the register, whose value is unknown. `None` if it is not set from a
        /// device.
        from: Option<String>,
    },
}

impl Doubt {
    /// The doubts about interrupts without a stated number, networks, routines without a body, loops and timers.
    /// `endless` are loops that a scan can reach, `open` those for which that was not decided, `upper` is the bound.
    pub(super) fn all(
        program: &Program,
        networks: &[NetworkUse],
        endless: &[LoopUse],
        open: &[LoopUse],
        upper: Picos,
    ) -> Vec<Doubt> {
        let interrupts = program.unstated_interrupts();
        let interrupts =
            interrupts.map(|one| Doubt::Interrupts { name: one.name.clone(), taken: one.times });
        let what: Vec<&str> = networks.iter().map(|one| one.what.as_str()).collect();
        let networks = networks.iter().map(|one| one.first).min().map(|first| Doubt::Networks {
            what: what.join(", "),
            first: (first.of(&program.files).name.clone(), first.line),
        });
        let endless =
            endless.iter().map(|one| Doubt::Endless { line: one.to.line, certain: one.certain });
        let listed = open.iter().take(MAX_LISTED);
        let listed = listed.map(|one| Doubt::PerhapsEndless { line: one.to.line });
        let more = open.len().checked_sub(MAX_LISTED).filter(|&more| more > 0);
        let bodiless = program.without_body.first().map(|(_, first)| Doubt::Bodiless {
            names: program.without_body.iter().map(|(name, _)| name.clone()).collect(),
            first: (first.of(&program.files).name.clone(), first.line),
        });
        let outlasts = program.shortest_timer.filter(|&shortest| upper >= shortest);
        interrupts
            .chain(networks)
            .chain(bodiless)
            .chain(endless)
            .chain(listed)
            .chain(more.map(Doubt::MorePerhapsEndless))
            .chain(outlasts.map(Doubt::OutlastsTimer))
            .collect()
    }
}

impl Doubt {
    /// The doubt that the program may switch on a constant scan whose time is unknown, if that is so.
    pub(super) fn of_cycle(cycle: &Cycle) -> Option<Doubt> {
        let from = cycle.settings.iter().find_map(|one| one.from.clone());
        cycle.is_unknown.then_some(Doubt::ConstantScan { device: cycle.devices[0], from })
    }
}

/// The doubts that can be found before the analysis follows a scan: those about points, interrupts without a stated
/// number, networks and routines without a body.
#[must_use]
pub(super) fn doubts_before_scan(program: &Program, prices: &Prices) -> Vec<Doubt> {
    let place = |at: usize| program.instructions[at].place;
    let uses = prices.networks.iter();
    let networks: Vec<NetworkUse> =
        uses.map(|one| NetworkUse { what: one.what.clone(), first: place(one.first) }).collect();
    let points = prices.points.iter().cloned().map(Doubt::Points);
    points.chain(Doubt::all(program, &networks, &[], &[], Picos::ZERO)).collect()
}

impl Doubt {
    /// What the doubt is about, in a few words for reports.
    #[must_use]
    pub fn topic(&self) -> &'static str {
        match self {
            Doubt::Points(_) => "I/O points",
            Doubt::Interrupts { .. } | Doubt::TooFewInterrupts { .. } => "interrupts",
            Doubt::Networks { .. } => "network refresh",
            Doubt::Endless { .. } | Doubt::PerhapsEndless { .. } | Doubt::MorePerhapsEndless(_) => {
                "whether loops end"
            }
            Doubt::Bodiless { .. } => "times of functions and function blocks without a body",
            Doubt::ConstantScan { .. } => "the constant scan time",
            Doubt::OutlastsTimer(_) => "timers that time out within a scan",
        }
    }
}

impl fmt::Display for Doubt {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Doubt::Points(UnstatedPoints { side, why, most, .. }) => {
                write!(
                    f,
                    "the number of {side} points is not stated, and the bound assumes {why}"
                )?;
                if let Some(MorePoints { points, more, .. }) = most {
                    write!(
                        f,
                        "; with all {points} points that the CPU can have, a scan takes {more} longer"
                    )?;
                }
                write!(f, ": state them ([io] {side}s)")
            }
            Doubt::Interrupts { name, taken } => write!(
                f,
                "it is not stated how often {name} interrupts a scan (assumed: {taken}): give --interrupts {name}=N"
            ),
            Doubt::TooFewInterrupts { name, every, taken, due } => write!(
                f,
                "{name} occurs every {every} and was charged {taken} times, but it is due {due} times in the longest scan with all points that the CPU can have: state the points, or give --interrupts {name}={due}"
            ),
            Doubt::Networks { what, first: (file, line) } => write!(
                f,
                "the program uses {what} (first in {file}:{line}), but the time of network refresh is not stated and not in the bound: state it in a facts file (--facts): [network] refresh = \"1.5ms\", or refresh = \"none\" if no network refreshes them"
            ),
            Doubt::Endless { line, certain: true } => {
                write!(
                    f,
                    "a scan can stay for ever in the loop that begins in line {line}, so the scan has no bound"
                )
            }
            Doubt::Endless { line, certain: false } => write!(
                f,
                "no condition was found that is sure to end the loop that begins in line {line}, so the scan has no bound: count a variable up or down to a constant well within the limits of its type, or write the loop as FOR with EXIT"
            ),
            Doubt::PerhapsEndless { line } => {
                write!(
                    f,
                    "the audit did not decide whether the loop that begins in line {line} can run for ever"
                )
            }
            Doubt::MorePerhapsEndless(more) => {
                write!(
                    f,
                    "the audit did not decide for {more} more loops whether they can run for ever"
                )
            }
            Doubt::Bodiless { names, first: (file, line) } => write!(
                f,
                "the code of {} (first in {file}:{line}) is not given, and the bound assumes that it does nothing: give the file with the code, or state a time for each name ([calls] \"{}\" = {{ time = \"20us\" }})",
                names.join(", "),
                names.first().map_or("NAME", |name| name)
            ),
            Doubt::ConstantScan { device, from } => {
                write!(
                    f,
                    "the program may switch on a constant scan, but its time in {device} is unknown"
                )?;
                if let Some(from) = from {
                    write!(f, " (it is set from {from})")?;
                }
                f.write_str(": state the scan time ([scan] constant = \"100ms\", or \"none\")")
            }
            Doubt::OutlastsTimer(shortest) => write!(
                f,
                "a scan may take longer than the shortest set value of a timer ({shortest}), but the bound assumes that no timer times out in the scan that starts it"
            ),
        }
    }
}
