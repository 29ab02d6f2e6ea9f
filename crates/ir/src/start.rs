//! What is known of the state in which a scan starts.

use super::{BitTarget, Cell, Logic, Region};
use std::collections::BTreeMap;

/// A stated range of a word, or of two words read as one number, at the start of the scan.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct StartRange {
    /// The cells, least word first; one or two.
    pub cells: Vec<Cell>,
    /// Least value, signed.
    pub low: i64,
    /// Largest value, signed.
    pub high: i64,
    /// Of one word, the only values, where these are not all from the least to the largest; else empty.
    pub values: Vec<u16>,
}

impl StartRange {
    /// Whether the cells may hold this value.
    #[must_use]
    pub fn has(&self, value: i64) -> bool {
        let is_one = |&one: &u16| i64::from(one.cast_signed()) == value;
        (self.low..=self.high).contains(&value)
            && (self.values.is_empty() || self.values.iter().any(is_one))
    }

    /// The value nearest to 0.
    #[must_use]
    pub fn least(&self) -> i64 {
        let values = self.values.iter().map(|value| i64::from(value.cast_signed()));
        values.min_by_key(|value| value.abs()).unwrap_or_else(|| 0.clamp(self.low, self.high))
    }
}

/// What a word holds whenever a scan starts, since the program writes it in every scan and nobody else does: what every
/// scan from power-up on keeps.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TrustedRange {
    /// The word.
    pub cell: Cell,
    /// Least value, signed.
    pub low: i64,
    /// Largest value, signed.
    pub high: i64,
    /// The only values, as in [`StartRange`].
    pub values: Vec<u16>,
    /// The instructions that write it, indices into `Program::instructions`.
    pub written: Vec<usize>,
}

impl TrustedRange {
    /// What it holds, in words: `0 to 7`, or `0 or 10`.
    #[must_use]
    pub fn told(&self) -> String {
        range_or_values((self.low, self.high), &self.values)
    }
}

/// A range in words, or its only values, if there are some.
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

/// Bits of which few are on at once when a scan starts, since the program alone writes them: what every scan from power-up
/// on keeps.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Apart {
    /// The bits.
    pub bits: Vec<BitTarget>,
    /// So many of them are ever on at once, and no more: one, or all but one. With 0 all are off in a scan before which
    /// memory was cleared, as [`PowerUp::fresh`] says.
    pub most: usize,
    /// The instructions that write them, indices into `Program::instructions`.
    pub written: Vec<usize>,
}

impl Apart {
    /// The sets of bits that are never all on.
    pub fn never(&self) -> impl Iterator<Item = Vec<BitTarget>> + '_ {
        let is_all = self.most != 1;
        let whole = (self.most > 1).then(|| self.bits.clone());
        let pairs = self.bits.iter().enumerate().flat_map(move |(at, &one)| {
            let others = self.bits[at + 1..].iter().filter(move |_| !is_all);
            others.map(move |&other| vec![one, other])
        });
        whole.into_iter().chain(pairs)
    }
}

/// What is known of the state in which a CPU with cleared memory comes up, and of what the outside sets. Cells that are
/// not named here start with a value that is not known.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct PowerUp {
    /// Cells that the outside sets before each scan, unless the program writes them.
    pub inputs: Vec<Region>,
    /// Cells that are 0, or hold what [`PowerUp::values`] says.
    pub cleared: Vec<Region>,
    /// Words that hold something else than 0, as the program declares them.
    pub values: BTreeMap<Cell, u16>,
    /// Those of them that keep what they held when the power fails, or may do so.
    pub latched: Vec<Region>,
    /// What holds whenever a scan starts, however what manuals leave open is read: real scans keep to it, too.
    pub in_every_reading: Vec<Logic>,
    /// Whether the program declares what is latched, so that all else is cleared when the power fails. Else parameters may
    /// latch more.
    pub declares_latched: bool,
    /// Bits that are on in the first scan and off in all others.
    pub first_scan: Vec<Cell>,
    /// A bit that is on in a scan only if all that is not latched was cleared before it. (Where a CPU goes on with what
    /// memory holds when it is stopped and started again, the bit of the first scan is none.)
    pub fresh: Option<BitTarget>,
    /// The word of the bit with which a program makes memory outlast that.
    pub holds: Option<Cell>,
}

impl PowerUp {
    /// Whether a failure of the power in mid-scan leaves nothing of what a word held then.
    #[must_use]
    pub fn forgets(&self, cell: Cell) -> bool {
        self.declares_latched && !self.latched.iter().any(|region| region.holds(cell))
    }

    /// What a word holds that is cleared.
    #[must_use]
    pub fn word(&self, cell: Cell) -> u16 {
        self.values.get(&cell).copied().unwrap_or(0)
    }
}
