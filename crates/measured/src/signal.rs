//! The selection in a capture, and the scan times between the edges of a signal.

use scanbound_base::code::Code;
use std::collections::BTreeSet;

use super::Measurements;
use super::number::Decimal;
use scanbound_base::column::Unit;
use scanbound_base::diagnostic::Diagnostic;
use scanbound_base::time::Picos;

/// Which edges of a captured signal begin a scan.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Edge {
    /// From 0 to 1.
    #[default]
    Rising,
    /// From 1 to 0.
    Falling,
    /// Both: a signal that the program inverts in each scan.
    Both,
}

impl Edge {
    /// Whether a change from one level to the other is such an edge.
    pub(super) fn is(self, before: bool, after: bool) -> bool {
        match self {
            Edge::Rising => !before && after,
            Edge::Falling => before && !after,
            Edge::Both => before != after,
        }
    }

    fn word(self) -> &'static str {
        match self {
            Edge::Rising => "rising edges",
            Edge::Falling => "falling edges",
            Edge::Both => "edges",
        }
    }
}

/// What to read from a file, and how.
#[derive(Debug, Clone, Default)]
pub struct Selection<'a> {
    /// The column of scan times, or of time stamps.
    pub column: Option<&'a str>,
    /// Whether that column holds the time stamps of one pulse per scan.
    pub pulses: bool,
    /// The unit, if the column's heading does not give it.
    pub unit: Option<Unit>,
    /// The captured signal.
    pub signal: Option<&'a str>,
    /// Its edges.
    pub edge: Edge,
    /// The threshold of an analog signal.
    pub threshold: Option<Threshold>,
    /// The decimal separator, if the file does not show it.
    pub decimal: Option<Decimal>,
    /// A one-bit signal: intervals that contain a time at which it is off are ignored.
    pub during: Option<&'a str>,
}

/// The thresholds of an analog signal, in 10^-12 of its unit.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Threshold {
    low: i128,
    high: i128,
}

impl Threshold {
    /// Reads `2.5`, or `0.8..2.0`: at most the first is 0, at least the second is 1, and values in between do not
    /// change the level.
    #[must_use]
    pub fn parse(text: &str) -> Option<Threshold> {
        let read = |text: &str| Unit::from_name("s")?.read(text);
        let (low, high) = match text.split_once("..") {
            Some((low, high)) => (read(low)?, read(high)?),
            None => (read(text)?, read(text)?),
        };
        (low <= high).then_some(Threshold { low, high })
    }

    /// The level of a value; `None` in between.
    pub(super) fn level(self, value: i128) -> Option<bool> {
        if value >= self.high {
            Some(true)
        } else if value <= self.low {
            Some(false)
        } else {
            None
        }
    }
}

/// A fault of the whole file.
pub(super) fn fault(name: &str, message: impl Into<String>, help: impl Into<String>) -> Diagnostic {
    Diagnostic::file(Code::Capture, name, message, help)
}

/// The edges of a signal, collected as its levels are read.
#[derive(Debug)]
pub(super) struct Edges {
    edge: Edge,
    level: Option<bool>,
    /// The number of edges before each gap.
    gaps: BTreeSet<usize>,
    /// Whether the machine stands still.
    still: bool,
    /// When the edges were, in picoseconds.
    pub(super) at: Vec<i128>,
}

impl Edges {
    pub(super) fn new(edge: Edge) -> Edges {
        Edges { edge, level: None, gaps: BTreeSet::new(), still: false, at: Vec::new() }
    }

    /// The signal's level at a moment; `None` if it is unknown.
    pub(super) fn level(&mut self, at: i128, level: Option<bool>) {
        if self.still {
            self.gaps.insert(self.at.len());
        }
        if let (Some(before), Some(after)) = (self.level, level)
            && self.edge.is(before, after)
        {
            self.at.push(at);
        }
        self.level = level;
    }

    /// Whether the machine stands still from now on, and whether it did at this moment, behind the edge that may
    /// be at it: from the last edge to the next is no scan.
    pub(super) fn stands(&mut self, from_now: bool, at_once: bool) {
        self.still = from_now;
        if from_now || at_once {
            self.gaps.insert(self.at.len());
        }
    }
}

/// What is known of a capture besides its times.
pub(super) struct Origin<'a> {
    pub(super) name: &'a str,
    pub(super) resolution: Option<Picos>,
    pub(super) emulated: bool,
}

impl Origin<'_> {
    /// The scan times between the edges of a signal.
    pub(super) fn of_edges(
        &self,
        signal: &str,
        edges: &Edges,
    ) -> Result<Measurements, Vec<Diagnostic>> {
        let how = format!("between the {} of {signal}", edges.edge.word());
        if edges.at.len() < 2 {
            let found = edges.at.len();
            let help = "capture for longer, or check --signal and --edge";
            let message =
                format!("{signal} has {found} {}, but at least two are needed", edges.edge.word());
            return Err(vec![fault(self.name, message, help)]);
        }
        let mut measured = self.of_stamps(how, &edges.at)?;
        // The time before edge n + 1 is that of index n.
        let gaps = edges.gaps.iter().filter_map(|&edges| edges.checked_sub(1));
        let gaps: BTreeSet<usize> = gaps.filter(|&gap| gap < measured.times.len()).collect();
        let mut index = 0;
        measured.times.retain(|_| {
            index += 1;
            !gaps.contains(&(index - 1))
        });
        if measured.times.is_empty() {
            let message = "the signal that shows when the PLC runs (--while) was off for a time in every interval";
            return Err(vec![fault(self.name, message, "capture some scans without a gap")]);
        }
        if !gaps.is_empty() {
            let message = format!(
                "{} of {} intervals are ignored, because the signal that shows when the PLC runs (--while) was off for a time in them",
                gaps.len(),
                gaps.len() + measured.times.len()
            );
            measured.warnings.push(fault(self.name, message, "").warning());
        }
        Ok(measured)
    }

    /// The scan times between time stamps.
    pub(super) fn of_stamps(
        &self,
        how: String,
        stamps: &[i128],
    ) -> Result<Measurements, Vec<Diagnostic>> {
        let mut times = Vec::with_capacity(stamps.len().saturating_sub(1));
        for (index, pair) in stamps.windows(2).enumerate() {
            match u64::try_from(pair[1] - pair[0]) {
                Ok(time @ 1..) => times.push(Picos(time)),
                _ => {
                    let message =
                        format!("time stamp {} is not later than the one before", index + 2);
                    let help = "time stamps must be in order of time; if the column holds scan times, omit --pulses";
                    return Err(vec![fault(self.name, message, help)]);
                }
            }
        }
        if times.is_empty() {
            let help = "two time stamps give one scan time: capture more";
            return Err(vec![fault(self.name, "the column has fewer than two time stamps", help)]);
        }
        Ok(self.measurements(how, times))
    }

    pub(super) fn measurements(&self, how: String, times: Vec<Picos>) -> Measurements {
        Measurements {
            file: self.name.to_owned(),
            how,
            times,
            resolution: self.resolution,
            emulated: self.emulated,
            warnings: Vec::new(),
        }
    }
}
