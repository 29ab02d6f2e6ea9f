//! Writes of any value, in order of execution, and which of them concern a cell.
//!
//! There are thousands in a large project, and tens of thousands of cells that are read behind them. So the writes to an
//! area are numbered in their order, and a tree of blocks of 1, 2, 4, 8 ... of them stands over these numbers: each block
//! knows which cells any of its writes concerns at most, and which all of them do.

use super::Lit;
use scanbound_ir::{AreaId, Cell, ChoiceId, Frame, Region};

/// A write of any value to a region: a moment from which on cells hold what no one can tell.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Havoc {
    /// What it may write.
    pub region: Region,
    /// Whether it happened.
    pub happened: Lit,
    /// The call context: calls and loop iterations on the path there.
    pub frames: Vec<Frame>,
    /// Under which choice.
    pub choice: ChoiceId,
}

/// Cells of an area that follow each other, by their indices; none if the first is behind the last.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Stretch {
    first: u32,
    last: u32,
}

impl Stretch {
    const NONE: Stretch = Stretch { first: u32::MAX, last: 0 };

    fn of(region: Region) -> Stretch {
        match region {
            Region::Range { count: 0, .. } => Stretch::NONE,
            Region::Range { first, count } => {
                Stretch { first: first.index, last: first.index.saturating_add(count - 1) }
            }
            Region::Area(_) | Region::Everything => Stretch { first: 0, last: u32::MAX },
        }
    }

    fn holds(self, cell: Cell) -> bool {
        (self.first..=self.last).contains(&cell.index)
    }
}

/// What a block of writes to one area says of cells.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Block {
    /// Each of the writes concerns these.
    every: Stretch,
    /// None of the writes concerns others than these.
    any: Stretch,
}

impl Block {
    fn both(self, other: Block) -> Block {
        let (every, any) = (other.every, other.any);
        Block {
            every: Stretch {
                first: self.every.first.max(every.first),
                last: self.every.last.min(every.last),
            },
            any: Stretch {
                first: self.any.first.min(any.first),
                last: self.any.last.max(any.last),
            },
        }
    }
}

/// The writes to one area. A write's place is its number among them.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
struct AreaWrites {
    /// By place: the index into `Havocs::all`.
    indices: Vec<u32>,
    /// The places of those that happen in every scan.
    certain: Vec<u32>,
    /// By the binary logarithm of their size: the blocks that are full, one behind the other.
    blocks: Vec<Vec<Block>>,
}

impl AreaWrites {
    fn push(&mut self, index: u32, region: Region, happened: Lit) {
        if happened == Lit::TRUE {
            self.certain.push(short(self.indices.len()));
        }
        self.indices.push(index);
        let stretch = Stretch::of(region);
        let mut block = Block { every: stretch, any: stretch };
        for level in 0.. {
            if level == self.blocks.len() {
                self.blocks.push(Vec::new());
            }
            let blocks = &mut self.blocks[level];
            blocks.push(block);
            let [.., left, right] = blocks[..] else { return };
            if blocks.len() % 2 == 1 {
                return;
            }
            block = left.both(right);
        }
    }

    /// The place of the newest before `until` that concerns the cell, if it does not lie before `since`: the search goes
    /// down from `until`, block by block, each as large as may be and still ends there.
    fn newest(&self, cell: Cell, since: usize, until: usize) -> Option<usize> {
        let mut end = until;
        'blocks: while end > since {
            let largest = end.trailing_zeros().min((end - since).ilog2());
            for level in (0..=largest).rev() {
                if !self.blocks[level as usize][(end >> level) - 1].any.holds(cell) {
                    end -= 1 << level;
                    continue 'blocks;
                }
            }
            return Some(end - 1);
        }
        None
    }
}

/// All writes of any value of a scan, in order of execution.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Havocs {
    all: Vec<Havoc>,
    /// By area.
    areas: Vec<AreaWrites>,
}

/// A place or an index in half the memory.
fn short(number: usize) -> u32 {
    u32::try_from(number).expect("writes of any value are counted in 32 bits")
}

impl Havocs {
    /// None yet, of cells of so many areas.
    #[must_use]
    pub fn of_areas(areas: usize) -> Havocs {
        Havocs { all: Vec::new(), areas: vec![AreaWrites::default(); areas] }
    }

    /// A further one.
    pub fn push(&mut self, havoc: Havoc) {
        let (index, region, happened) = (short(self.all.len()), havoc.region, havoc.happened);
        self.all.push(havoc);
        match region {
            Region::Range { first: Cell { area, .. }, .. } | Region::Area(area) => {
                self.areas[usize::from(area.0)].push(index, region, happened);
            }
            Region::Everything => {
                self.areas.iter_mut().for_each(|area| area.push(index, region, happened));
            }
        }
    }

    /// All, in order of execution.
    #[must_use]
    pub fn all(&self) -> &[Havoc] {
        &self.all
    }

    /// How many may have written to cells of the area.
    #[must_use]
    pub fn count(&self, area: AreaId) -> usize {
        self.areas[usize::from(area.0)].indices.len()
    }

    /// Of those that may have written to the cell's area, from `since` to `until`: those that concern the cell, the newest first.
    pub fn concerning(&self, cell: Cell, since: u32, until: u32) -> impl Iterator<Item = &Havoc> {
        let area = &self.areas[usize::from(cell.area.0)];
        let (since, mut until) = (since as usize, until as usize);
        std::iter::from_fn(move || {
            until = area.newest(cell, since, until)?;
            Some(&self.all[area.indices[until] as usize])
        })
    }

    /// Those that happen where this holds.
    #[must_use]
    pub fn where_holds(&self, holds: impl Fn(Lit) -> bool) -> Happened<'_> {
        let happens = |&place: &usize, area: &AreaWrites| {
            holds(self.all[area.indices[place] as usize].happened)
        };
        let of = |area: &AreaWrites| {
            let places = 0..area.indices.len();
            places.filter(|place| happens(place, area)).map(short).collect()
        };
        Happened { havocs: self, places: self.areas.iter().map(of).collect() }
    }

    /// The place in the cell's area of the newest that concerns it and happens in every scan, if it does not lie
    /// before `since`.
    #[must_use]
    pub fn newest_certain(&self, cell: Cell, since: usize) -> Option<usize> {
        let area = &self.areas[usize::from(cell.area.0)];
        let places = area.certain.iter().rev().map(|&place| place as usize);
        let mut places = places.take_while(|&place| place >= since);
        places.find(|&place| area.blocks[0][place].any.holds(cell))
    }

    /// Which writes of a block of an area concern the cell: those of its area's places from `number << level` to
    /// `(number + 1) << level`.
    #[must_use]
    pub fn block(&self, cell: Cell, level: u32, number: usize) -> Concerned {
        let block = self.areas[usize::from(cell.area.0)].blocks[level as usize][number];
        match (block.any.holds(cell), block.every.holds(cell)) {
            (false, _) => Concerned::None,
            (true, true) => Concerned::All,
            (true, false) => Concerned::Some,
        }
    }

    /// Whether the write at this place of the area happens.
    #[must_use]
    pub fn happened(&self, area: AreaId, place: usize) -> Lit {
        self.all[self.areas[usize::from(area.0)].indices[place] as usize].happened
    }

    /// The same writes, happening where this says.
    #[must_use]
    pub fn where_happened(&self, mut happened: impl FnMut(Lit) -> Lit) -> Havocs {
        let mut found = Havocs::of_areas(self.areas.len());
        for havoc in &self.all {
            found.push(Havoc { happened: happened(havoc.happened), ..havoc.clone() });
        }
        found
    }
}

/// The writes of any value that happen in one scan.
pub struct Happened<'a> {
    havocs: &'a Havocs,
    /// By area: their places there.
    places: Vec<Vec<u32>>,
}

impl<'a> Happened<'a> {
    /// Of those that may have written to the cell's area, from `since` to `until`: the newest that happens and concerns the cell.
    #[must_use]
    pub fn newest(&self, cell: Cell, since: u32, until: u32) -> Option<&'a Havoc> {
        let area = &self.havocs.areas[usize::from(cell.area.0)];
        let places = &self.places[usize::from(cell.area.0)];
        let before = &places[..places.partition_point(|&place| place < until)];
        let mut newest = before.iter().rev().take_while(|&&place| place >= since);
        let newest = newest.find(|&&place| area.blocks[0][place as usize].any.holds(cell));
        newest.map(|&place| &self.havocs.all[area.indices[place as usize] as usize])
    }
}

/// Which writes of a block concern a cell.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Concerned {
    /// None of them.
    None,
    /// Perhaps some of them.
    Some,
    /// Each of them.
    All,
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cell(area: u16, index: u32) -> Cell {
        Cell { area: AreaId(area), index }
    }

    /// Writes to two areas, here and there, some of them certain.
    fn some(count: u32) -> Havocs {
        let mut havocs = Havocs::of_areas(2);
        for n in 0..count {
            let first = cell((n % 3 == 0).into(), n * n % 37);
            let region = match n % 11 {
                0 => Region::Everything,
                1 => Region::Area(first.area),
                _ => Region::Range { first, count: n % 7 },
            };
            let happened = if n % 13 == 5 { Lit::TRUE } else { Lit(2 * n + 2) };
            havocs.push(Havoc { region, happened, frames: Vec::new(), choice: ChoiceId(n) });
        }
        havocs
    }

    #[test]
    fn what_concerns_a_cell_is_found_newest_first() {
        for count in [0, 1, 2, 7, 64, 100] {
            let havocs = some(count);
            let holds = |lit: Lit| lit.0.is_multiple_of(8);
            let happened = havocs.where_holds(holds);
            for area in 0..2 {
                let own = |havoc: &&Havoc| match havoc.region {
                    Region::Range { first, .. } => first.area.0 == area,
                    Region::Area(other) => other.0 == area,
                    Region::Everything => true,
                };
                let own: Vec<&Havoc> = havocs.all.iter().filter(own).collect();
                assert_eq!(havocs.count(AreaId(area)), own.len());
                for index in 0..50 {
                    let cell = cell(area, index);
                    for since in 0..own.len() {
                        for until in since..=own.len() {
                            let all = own[since..until].iter().rev().copied();
                            let wanted = all.filter(|one| one.region.holds(cell));
                            let found = havocs.concerning(cell, since as u32, until as u32);
                            assert!(found.eq(wanted.clone()), "{area} {index} {since} {until}");
                            let newest = happened.newest(cell, since as u32, until as u32);
                            let mut happening = wanted.filter(|one| holds(one.happened));
                            assert_eq!(newest, happening.next());
                        }
                        let certain = |place: &usize| {
                            own[*place].happened == Lit::TRUE && own[*place].region.holds(cell)
                        };
                        let newest = (since..own.len()).rev().find(certain);
                        assert_eq!(havocs.newest_certain(cell, since), newest);
                    }
                }
            }
        }
    }

    #[test]
    fn a_block_says_which_cells_it_concerns() {
        let havocs = some(90);
        let mut told = [0; 3];
        for index in 0..50 {
            let cell = cell(0, index);
            for (level, blocks) in (0..).zip(&havocs.areas[0].blocks) {
                for number in 0..blocks.len() {
                    let places = number << level..(number + 1) << level;
                    let own = &havocs.areas[0].indices[places];
                    let holds = |&index: &u32| havocs.all[index as usize].region.holds(cell);
                    let concerned = havocs.block(cell, level, number);
                    match concerned {
                        Concerned::None => assert!(!own.iter().any(holds)),
                        Concerned::All => assert!(own.iter().all(holds)),
                        Concerned::Some => {}
                    }
                    told[concerned as usize] += 1;
                }
            }
        }
        assert!(told.iter().all(|&count| count > 100), "{told:?}");
    }

    #[test]
    fn other_conditions_make_others_certain() {
        let havocs = some(30).where_happened(|happened| Lit(happened.0 / 4));
        let certain: usize = havocs.areas.iter().map(|area| area.certain.len()).sum();
        let holding = havocs.areas.iter().flat_map(|area| &area.indices);
        let wanted = holding.filter(|&&index| havocs.all[index as usize].happened == Lit::TRUE);
        assert_eq!(certain, wanted.count());
        assert!(certain > 3);
    }
}
