//! Which cells an instruction reads and writes, as far as its meaning shows them.

use scanbound_ir::{
    AccessedDevices, AreaId, BitSource, BitTarget, Cell, ChoiceId, IndexedWrite, Instruction,
    Length, Region, Source, WordSource, WordTarget, Write,
};
use std::collections::BTreeMap;

/// If the instruction's meaning does not say how many cells of a range it accesses, twice as many cells as the
/// instruction has units are counted, or this number if that is larger, but never more than the range has.
const LEAST_RANGE: u64 = 8;
/// A range with more cells than this has an unknown end: only its first cell counts as used.
const MAX_CELLS: u32 = 1 << 24;

/// The cells that an instruction reads, writes or names, counted by area. Tables charge extra time for some of them
/// (`@+ZR`).
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Cells {
    /// The cells by area. Few instructions use more than two areas.
    pub areas: Vec<OfArea>,
    /// How often the instruction uses a single bit of a word, such as `D0.5`.
    pub word_bits: u64,
    units: u64,
}

/// The cells of one area that an instruction uses.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct OfArea {
    /// The area that contains the cells.
    pub area: AreaId,
    /// The number of cells. A cell that is mentioned twice counts twice.
    pub count: u64,
    /// The highest index among the cells that the instruction certainly names. `None` if it names only the area, not a
    /// place in it.
    pub highest: Option<u32>,
}

impl Cells {
    /// The cells that an instruction that processes `units` units uses. `indexed` gives the cells that writes with an
    /// index may reach.
    #[must_use]
    pub fn of(
        instruction: &Instruction,
        units: u64,
        indexed: &BTreeMap<ChoiceId, IndexedWrite>,
    ) -> Cells {
        let mut cells = Cells { units, ..Cells::default() };
        instruction.each_read(&mut |source| match source {
            Source::Bit(source) => cells.bit(source),
            Source::Word(source) => cells.word(source),
        });
        // The cells already counted for each write with an index.
        let mut counted: Vec<(ChoiceId, u64)> = Vec::new();
        for effect in &instruction.effects {
            match &effect.write {
                Write::Bit(BitTarget::Cell(cell), _) => cells.range(*cell, 1, 1),
                Write::Bit(BitTarget::WordBit(cell, _), _) => cells.word_bit(*cell),
                Write::Words(targets, _) => {
                    for target in targets {
                        match target {
                            WordTarget::Cell(cell) => cells.range(*cell, 1, 1),
                            WordTarget::Bits { first, count } => cells.bits(*first, *count),
                            WordTarget::Discard => {}
                        }
                    }
                }
                Write::Havoc(region, choice) => {
                    let written = indexed.get(choice).filter(|one| one.shares_area(*region));
                    let (Some(written), Region::Range { first, count }) = (written, *region) else {
                        cells.region(*region);
                        continue;
                    };
                    // Whatever the index is, the instruction writes no more cells than its meaning says.
                    let most = match written.length {
                        Length::Exactly(length) => length.into(),
                        Length::Counted(..) | Length::Unknown => cells.most_of_range(),
                    };
                    let before = counted.iter().filter(|(own, _)| own == choice);
                    let before = before.fold(0, |all: u64, (_, count)| all.saturating_add(*count));
                    let left = most.saturating_sub(before);
                    cells.range(first, count, u64::from(count).min(left));
                    counted.push((*choice, count.into()));
                }
            }
        }
        if let Some(key) = &instruction.timing {
            cells.add_named(&key.accessed);
        }
        cells
    }

    /// The largest number of cells of a range that are counted, if the instruction's meaning does not say how many it
    /// accesses.
    fn most_of_range(&self) -> u64 {
        LEAST_RANGE.max(self.units.saturating_mul(2))
    }

    /// Adds the cells that operands name. In each area, the larger number counts: that of the cells found in reads and
    /// effects, or that of the cells named.
    fn add_named(&mut self, touched: &AccessedDevices) {
        let mut named = Cells { units: self.units, ..Cells::default() };
        touched.regions.iter().for_each(|&region| named.region(region));
        for OfArea { area, count, highest } in named.areas {
            let shown = self.of_area(area);
            shown.count = shown.count.max(count);
            shown.highest = shown.highest.max(highest);
        }
        self.word_bits = self.word_bits.max(touched.word_bits);
    }

    fn range(&mut self, first: Cell, length: u32, counted: u64) {
        let length = if length > MAX_CELLS { 1 } else { length };
        let last = first.index.saturating_add(length.saturating_sub(1));
        let of = self.of_area(first.area);
        of.count += counted;
        of.highest = of.highest.max(Some(last));
    }

    fn of_area(&mut self, area: AreaId) -> &mut OfArea {
        let at = self.areas.iter().position(|of| of.area == area).unwrap_or_else(|| {
            self.areas.push(OfArea { area, count: 0, highest: None });
            self.areas.len() - 1
        });
        &mut self.areas[at]
    }

    fn bits(&mut self, first: Cell, count: u8) {
        self.range(first, u32::from(count), u64::from(count));
    }

    fn word_bit(&mut self, cell: Cell) {
        self.word_bits += 1;
        self.range(cell, 1, 1);
    }

    fn region(&mut self, region: Region) {
        match region {
            Region::Range { first, count } => {
                self.range(first, count, u64::from(count).min(self.most_of_range()));
            }
            Region::Area(area) => self.of_area(area).count += 1,
            Region::Everything => {}
        }
    }

    fn bit(&mut self, source: BitSource) {
        match source {
            BitSource::Cell(cell) => self.range(cell, 1, 1),
            BitSource::WordBit(cell, _) => self.word_bit(cell),
            BitSource::Const(_) | BitSource::Free(_) => {}
        }
    }

    fn word(&mut self, source: WordSource) {
        match source {
            WordSource::Cell(cell) => self.range(cell, 1, 1),
            WordSource::Bits { first, count } => self.bits(first, count),
            WordSource::Const(_) | WordSource::Free(_) => {}
        }
    }
}
