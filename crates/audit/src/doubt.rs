//! Why a bound may be too low all the same: what it needs and nobody stated. The words for each stand here.

use super::{Audit, Cycle, LoopUse, NetworkUse};
use scanbound_base::time::Picos;
use scanbound_ir::Program;
use scanbound_timing::price::{MorePoints, Prices, UnstatedPoints};
use std::fmt;

/// The most loops listed one by one of which the search did not find out whether they end.
const MOST_TOLD: usize = 10;

/// Why a bound may be too low.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Doubt {
    /// How many points a side has is not stated.
    Points(UnstatedPoints),
    /// How often a routine interrupts a scan is not stated.
    Interrupts {
        /// The routine.
        name: String,
        /// How often it was assumed to.
        taken: u32,
    },
    /// A routine interrupts a scan more often than was counted, by its interval.
    TooFewInterrupts {
        /// The routine.
        name: String,
        /// Its interval.
        every: Picos,
        /// How often it was counted.
        taken: u32,
        /// How often it is due in the longest scan, with all points that the CPU can have.
        due: u64,
    },
    /// What networks take to refresh what the program uses is not stated.
    Networks {
        /// What it uses.
        what: String,
        /// The file and the line of the first use.
        first: (String, u32),
    },
    /// Nothing bounds a loop that a scan can come to.
    Endless {
        /// The line to which control goes back.
        line: u32,
        /// Whether the scan can go round it for ever; else only nothing is known that ends it.
        certain: bool,
    },
    /// Whether a scan can was not found out.
    PerhapsEndless {
        /// The line.
        line: u32,
    },
    /// The number of further such loops.
    MorePerhapsEndless(usize),
    /// Units that are called have no body: they were taken to do nothing.
    Bodiless {
        /// Their names.
        names: Vec<String>,
        /// The file and the line of the first.
        first: (String, u32),
    },
    /// A scan may last longer than a timer that it starts, and that is taken not to run out within it.
    OutlastsTimer(Picos),
    /// The program may switch a constant scan on, and for how long is not known.
    ConstantScan {
        /// The register of its time.
        device: &'static str,
        /// What is taken from there, and is not known.
        from: Option<String>,
    },
}

impl Doubt {
    /// All but those of points that are not stated.
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
        let told = open.iter().take(MOST_TOLD);
        let told = told.map(|one| Doubt::PerhapsEndless { line: one.to.line });
        let more = open.len().checked_sub(MOST_TOLD).filter(|&more| more > 0);
        let bodiless = program.without_body.first().map(|(_, first)| Doubt::Bodiless {
            names: program.without_body.iter().map(|(name, _)| name.clone()).collect(),
            first: (first.of(&program.files).name.clone(), first.line),
        });
        let outlasts = program.shortest_timer.filter(|&shortest| upper >= shortest);
        interrupts
            .chain(networks)
            .chain(bodiless)
            .chain(endless)
            .chain(told)
            .chain(more.map(Doubt::MorePerhapsEndless))
            .chain(outlasts.map(Doubt::OutlastsTimer))
            .collect()
    }
}

impl Doubt {
    /// That the program may make scans last for a time that is not known.
    pub(super) fn of_cycle(cycle: &Cycle) -> Option<Doubt> {
        let from = cycle.settings.iter().find_map(|one| one.from.clone());
        cycle.is_unknown.then_some(Doubt::ConstantScan { device: cycle.devices[0], from })
    }
}

/// What a bound needs and nobody states, as far as that is known before any scan is followed.
#[must_use]
pub(super) fn before(program: &Program, prices: &Prices) -> Vec<Doubt> {
    let place = |at: usize| program.instructions[at].place;
    let uses = prices.networks.iter();
    let networks: Vec<NetworkUse> =
        uses.map(|one| NetworkUse { what: one.what.clone(), first: place(one.first) }).collect();
    let points = prices.points.iter().cloned().map(Doubt::Points);
    points.chain(Doubt::all(program, &networks, &[], &[], Picos::ZERO)).collect()
}

impl Doubt {
    /// What it is about, in a word or two.
    #[must_use]
    pub fn topic(&self) -> &'static str {
        match self {
            Doubt::Points(_) => "I/O points",
            Doubt::Interrupts { .. } | Doubt::TooFewInterrupts { .. } => "interrupts",
            Doubt::Networks { .. } => "network refresh",
            Doubt::Endless { .. } | Doubt::PerhapsEndless { .. } | Doubt::MorePerhapsEndless(_) => {
                "whether loops end"
            }
            Doubt::Bodiless { .. } => "times of units without a body",
            Doubt::ConstantScan { .. } => "the constant scan time",
            Doubt::OutlastsTimer(_) => "timers that run out within a scan",
        }
    }
}

impl Audit {
    /// All reasons why the bound may be too low, points that are not stated among them.
    #[must_use]
    pub fn all_doubts(&self) -> Vec<Doubt> {
        let is_more = |points: &&UnstatedPoints| {
            points.most.as_ref().is_none_or(|most| most.more > Picos::ZERO)
        };
        let points = self.points.iter().filter(is_more).cloned().map(Doubt::Points);
        points.chain(self.doubts.iter().cloned()).collect()
    }

    /// The reasons that [`Audit::upper_with_all_points`] does not count. There are none where only points are not stated
    /// and the table knows how many the CPU can have.
    #[must_use]
    pub fn uncounted_doubts(&self) -> Vec<Doubt> {
        let is_unknown = self.points.iter().any(|points| points.most.is_none());
        if is_unknown { self.all_doubts() } else { self.doubts.clone() }
    }
}

impl fmt::Display for Doubt {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Doubt::Points(UnstatedPoints { side, why, most, .. }) => {
                write!(f, "{side} points are not stated: {why}")?;
                if let Some(MorePoints { points, more, .. }) = most {
                    write!(
                        f,
                        ", with all {points} that the CPU can have a scan takes {more} longer"
                    )?;
                }
                write!(f, ": state them ([io] {side}s)")
            }
            Doubt::Interrupts { name, taken } => write!(
                f,
                "how often {name} interrupts a scan is not stated, {taken} was taken: give --interrupts {name}=N"
            ),
            Doubt::TooFewInterrupts { name, every, taken, due } => write!(
                f,
                "{name} comes every {every} and was counted {taken} times: in the longest scan, with all points that the CPU can have, it is due {due} times: state the points, or give --interrupts {name}={due}"
            ),
            Doubt::Networks { what, first: (file, line) } => write!(
                f,
                "the program uses {what} (first in {file}:{line}): what networks take to refresh these is not stated and not in the bound: state it in a facts file (--facts): [network] refresh = \"1.5ms\", or refresh = \"none\" where nothing refreshes them"
            ),
            Doubt::Endless { line, certain: true } => write!(
                f,
                "a scan can go round the loop to line {line} without end: nothing bounds it"
            ),
            Doubt::Endless { line, certain: false } => write!(
                f,
                "nothing is known that ends the loop to line {line}: let it count a variable up or down to a constant that its type holds with room to spare, or write it as FOR with EXIT"
            ),
            Doubt::PerhapsEndless { line } => {
                write!(f, "whether the loop to line {line} can run without end was not found out")
            }
            Doubt::MorePerhapsEndless(more) => write!(f, "nor was it of {more} more loops"),
            Doubt::Bodiless { names, first: (file, line) } => write!(
                f,
                "{} (first in {file}:{line}) without a body, taken to do nothing: give the file with its code, or state what it takes ([calls] \"{}\" = {{ time = \"20us\" }})",
                names.join(", "),
                names.first().map_or("NAME", |name| name)
            ),
            Doubt::ConstantScan { device, from } => {
                write!(
                    f,
                    "the program may switch a constant scan on, and nothing says what {device} holds then"
                )?;
                if let Some(from) = from {
                    write!(f, " (it is set from {from})")?;
                }
                f.write_str(": state the scan time ([scan] constant = \"100ms\", or \"none\")")
            }
            Doubt::OutlastsTimer(shortest) => write!(
                f,
                "a scan may last longer than the shortest timer ({shortest}), which is taken not to run out within the scan that starts it"
            ),
        }
    }
}
