//! Constraints on the state in which a scan starts.

use super::{BitTarget, Cell, Logic, Region};
use std::collections::{BTreeMap, BTreeSet};

/// A range that the user stated, or of a trusted word: the value of a word, or of two words read as one number, at the
/// start of a scan.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct StartRange {
    /// The one or two cells, low word first.
    pub cells: Vec<Cell>,
    /// The least value of the word, or of the number in both words, signed.
    pub low: i64,
    /// The largest value of the word, or of the number in both words, signed.
    pub high: i64,
    /// The only values that the word may have, if it cannot have all values from `low` to `high`; otherwise empty.
    pub values: Vec<u16>,
}

impl StartRange {
    /// Whether the cells may have this signed value.
    #[must_use]
    pub fn contains(&self, value: i64) -> bool {
        let is_one = |&one: &u16| i64::from(one.cast_signed()) == value;
        (self.low..=self.high).contains(&value)
            && (self.values.is_empty() || self.values.iter().any(is_one))
    }

    /// The allowed value nearest to 0, as a signed number.
    #[must_use]
    pub fn nearest_to_zero(&self) -> i64 {
        let values = self.values.iter().map(|value| i64::from(value.cast_signed()));
        values.min_by_key(|value| value.abs()).unwrap_or_else(|| 0.clamp(self.low, self.high))
    }
}

/// A proved range: the value of a word at the start of every scan after power-up, because the program writes it in
/// every scan and nothing else writes it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TrustedRange {
    /// The word whose range is trusted.
    pub cell: Cell,
    /// The least value of the word, signed.
    pub low: i64,
    /// The largest value of the word, signed.
    pub high: i64,
    /// The only values that the word may have, as in [`StartRange::values`].
    pub values: Vec<u16>,
    /// The instructions that write the word, indices into `Program::instructions`.
    pub writers: Vec<usize>,
}

impl TrustedRange {
    /// The range as text: `0 to 7`, or its values: `0 or 10`.
    #[must_use]
    pub fn text(&self) -> String {
        range_or_values((self.low, self.high), &self.values)
    }
}

/// The range as text (`0 to 7`), or its values in ascending order if `values` is not empty (`0, 5 or 10`).
#[must_use]
pub fn range_or_values((low, high): (i64, i64), values: &[u16]) -> String {
    let mut values: Vec<i64> = values.iter().map(|value| value.cast_signed().into()).collect();
    values.sort_unstable();
    let all: Vec<String> = values.iter().map(i64::to_string).collect();
    match &all[..] {
        [] => format!("{low} to {high}"),
        [one] => one.clone(),
        [first @ .., last] => format!("{} or {last}", first.join(", ")),
    }
}

/// Bits of which only a limited number is on at the start of every scan after power-up, because only the program writes
/// them.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ExclusiveBits {
    /// The bits of which the number that is on is limited.
    pub bits: Vec<BitTarget>,
    /// The largest number of these bits that are on at once: 1, or all but one. With 0, all bits are off in a scan
    /// before which memory was cleared ([`PowerUp::after_clear`]).
    pub max_on: usize,
    /// The instructions that write the bits, indices into `Program::instructions`.
    pub writers: Vec<usize>,
}

impl ExclusiveBits {
    /// The sets of bits that are never all on at once: every pair if `max_on` is 1, the set of all bits if it is
    /// larger. None if it is 0: then the bits are off only after memory was cleared.
    pub fn forbidden_sets(&self) -> impl Iterator<Item = Vec<BitTarget>> + '_ {
        let is_all = self.max_on != 1;
        let whole = (self.max_on > 1).then(|| self.bits.clone());
        let pairs = self.bits.iter().enumerate().flat_map(move |(at, &one)| {
            let others = self.bits[at + 1..].iter().filter(move |_| !is_all);
            others.map(move |&other| vec![one, other])
        });
        whole.into_iter().chain(pairs)
    }
}

/// What is known of the state of a CPU after power-up with cleared memory, and which cells are inputs. The start values
/// of all other cells are unknown.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct PowerUp {
    /// Cells that are inputs: set from outside before each scan, unless the program writes them.
    pub inputs: Vec<Region>,
    /// The cells that are 0 after power-up, or have their value in [`PowerUp::values`].
    pub cleared: Vec<Region>,
    /// Initial values other than 0, as the program declares them.
    pub values: BTreeMap<Cell, u16>,
    /// Cells among `cleared` that keep their values when power fails, or may keep them.
    pub latched: Vec<Region>,
    /// For latched cells that a routine uses under other names: the cells that stand for them until the routine ends
    /// (copies of VAR_IN_OUT arguments). On the PLC they are the same memory, so that after a power failure a latched
    /// cell may have any value that one of these cells had.
    pub lent: BTreeMap<Cell, BTreeSet<Cell>>,
    /// Invariants of the start state that hold even where the manuals can be understood in several ways. Real runs rely
    /// on these only.
    pub certain_invariants: Vec<Logic>,
    /// Whether the program declares which cells are latched, so that all others are cleared when power fails. If not,
    /// CPU parameters may latch further cells.
    pub declares_latched: bool,
    /// Bits that are on in the first scan and off in all others.
    pub first_scan: Vec<Cell>,
    /// A bit that is on only in a scan before which all non-latched memory was cleared. If a CPU keeps its memory
    /// between STOP and RUN, the first-scan bit does not guarantee this. `None` if there is no such bit.
    pub after_clear: Option<BitTarget>,
    /// The word of the bit with which the program keeps memory across a change to RUN (IOM Hold Bit). `None` if the PLC
    /// has no such bit.
    pub memory_hold_word: Option<Cell>,
}

impl PowerUp {
    /// Whether a power failure certainly erases the value of the cell: the program declares which cells are latched,
    /// and this one is not among them.
    #[must_use]
    pub fn is_lost_at_power_failure(&self, cell: Cell) -> bool {
        self.declares_latched && !self.latched.iter().any(|region| region.contains(cell))
    }

    /// The value of a cell after power-up, if it is one of [`PowerUp::cleared`]: the declared initial value, otherwise
    /// 0.
    #[must_use]
    pub fn initial_value(&self, cell: Cell) -> u16 {
        self.values.get(&cell).copied().unwrap_or(0)
    }
}
