//! Supplies the nondeterministic values of a scan: the start values of cells, and choices.

use super::timed::TimedInputs;
use scanbound_base::time::Picos;
use scanbound_ir::timers::TimerOrCounter;
#[cfg(doc)]
use scanbound_ir::timers::{TIME_UNIT, Timekeeping};
use scanbound_ir::{AreaKind, Cell, ChoiceId, ChoiceKey, Resolutions, Witness};

/// Supplies the nondeterministic values of a scan. Within a scan, the same question must get the same answer.
pub trait FreeValues {
    /// The value of the cell at the start of the scan. For a bit cell, only bit 0 matters.
    fn start(&mut self, cell: Cell, kind: AreaKind) -> u16;
    /// A mask of the bits of the cell's start value that are unknown.
    fn unknown(&mut self, _cell: Cell) -> u16 {
        0
    }
    /// The value of the choice. If `kind` is `Bit`, only bit 0 matters. The answer must not depend on `kind`.
    fn choice(&mut self, key: &ChoiceKey, kind: AreaKind) -> u16;
    /// Whether all values from outside the program are unknown. Then what depends on them is unknown too, although
    /// [`FreeValues::choice`] gives a value.
    fn outside_is_unknown(&self) -> bool {
        false
    }
    /// The value of the CPU's register that this choice reads, if it is known.
    fn register(&mut self, _choice: ChoiceId) -> Option<u16> {
        None
    }
    /// The completion flag and the present value after a timer or counter was executed. `None` if time is not
    /// simulated, or if they are unknown.
    fn timed(&mut self, _timed: &TimerOrCounter, _found: &TimedInputs) -> Option<(bool, u16)> {
        None
    }
    /// Notes that a timer or counter was executed with an unknown input.
    fn lose_timed(&mut self, _timed: &TimerOrCounter) {}
    /// Whether time is simulated. Then timers and counters are executed as instructions, and none times out between two
    /// instructions.
    fn simulates_time(&self) -> bool {
        false
    }
    /// Whether scans follow each other from power-up, so that the elapsed time of a timer follows from the times of
    /// earlier scans.
    fn counts_time(&self) -> bool {
        false
    }
    /// How long the timer with this memory cell has been running when the scan begins: the least and the greatest
    /// possible time. `None` if only a single scan is run, or time is not simulated.
    fn ran_for(&mut self, _memory: Cell) -> Option<(Picos, Picos)> {
        None
    }
    /// For an emulated PLC, which tracks all times: how many units of [`TIME_UNIT`] passed between the beginnings of
    /// the previous scan and of this one. `None` for other runs.
    fn passed(&self) -> Option<u64> {
        None
    }
    /// For an emulated PLC: whether the time of this choice ([`Timekeeping::ends`]) is over. `None` if it has none, and
    /// for other runs.
    fn is_over(&self, _choice: ChoiceId) -> Option<bool> {
        None
    }
    /// Which choices the analysis computed when it found this scan. `None` if the scan does not come from the analysis.
    fn resolutions(&self) -> Option<&Resolutions> {
        None
    }
}

impl FreeValues for &Witness {
    fn start(&mut self, cell: Cell, _kind: AreaKind) -> u16 {
        self.start.get(&cell).copied().unwrap_or(0)
    }

    fn choice(&mut self, key: &ChoiceKey, _kind: AreaKind) -> u16 {
        self.choices.get(key).copied().unwrap_or(0)
    }

    fn resolutions(&self) -> Option<&Resolutions> {
        Some(&self.resolutions)
    }
}

/// How nondeterministic values are treated.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Mode {
    /// As in the analysis: a choice has the value that [`FreeValues`] gives, unless the analysis computed it or a real
    /// run observed it.
    Model,
    /// Operations have exact results, as on a PLC: a real run, see [`scanbound_ir::meaning`].
    Real,
}
