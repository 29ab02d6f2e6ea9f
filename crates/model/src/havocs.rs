//! The havocs of a scan in order of execution, and a search for those that may write a cell.
//!
//! A large project has thousands of havocs, and reads tens of thousands of cells after them. Therefore the havocs of
//! each area are numbered in order, with a tree of blocks of 1, 2, 4, 8 ... consecutive havocs. Each block has the
//! cells that at least one of its havocs may write, and the cells that all of them may write.

use super::Lit;
use scanbound_ir::{AreaId, Cell, ChoiceId, Frame, Region};

/// One execution of a havoc: where it is executed, the cells of its region get unknown values.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Havoc {
    /// The cells that the havoc may write.
    pub region: Region,
    /// The literal that says whether the havoc is executed.
    pub executed: Lit,
    /// The call context: calls, loop iterations and interrupts on the path to the havoc.
    pub frames: Vec<Frame>,
    /// The choice that stands for the written values.
    pub choice: ChoiceId,
}

/// Consecutive cells of an area, by their first and last index; empty if the first is larger than the last.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct CellRange {
    first: u32,
    last: u32,
}

impl CellRange {
    const NONE: CellRange = CellRange { first: u32::MAX, last: 0 };

    fn of(region: Region) -> CellRange {
        match region {
            Region::Range { count: 0, .. } => CellRange::NONE,
            Region::Range { first, count } => {
                CellRange { first: first.index, last: first.index.saturating_add(count - 1) }
            }
            Region::Area(_) | Region::Everything => CellRange { first: 0, last: u32::MAX },
        }
    }

    fn holds(self, cell: Cell) -> bool {
        (self.first..=self.last).contains(&cell.index)
    }
}

/// The cells that a block, which is a number of consecutive havocs of one area, may write.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Block {
    /// The cells that every havoc of the block may write.
    every: CellRange,
    /// A range that contains all cells that any havoc of the block may write.
    any: CellRange,
}

impl Block {
    fn join(self, other: Block) -> Block {
        let (every, any) = (other.every, other.any);
        Block {
            every: CellRange {
                first: self.every.first.max(every.first),
                last: self.every.last.min(every.last),
            },
            any: CellRange {
                first: self.any.first.min(any.first),
                last: self.any.last.max(any.last),
            },
        }
    }
}

/// The havocs of one area. The position of a havoc is its number among these havocs.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
struct AreaWrites {
    /// For each position, the index into `Havocs::all`.
    indices: Vec<u32>,
    /// The positions of the havocs that are executed in every scan.
    certain: Vec<u32>,
    /// For each binary logarithm of a block's size: the complete blocks of this size, in order.
    blocks: Vec<Vec<Block>>,
}

impl AreaWrites {
    fn push(&mut self, index: u32, region: Region, happened: Lit) {
        if happened == Lit::TRUE {
            self.certain.push(short(self.indices.len()));
        }
        self.indices.push(index);
        let stretch = CellRange::of(region);
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
            block = left.join(right);
        }
    }

    /// The position of the last havoc from `since` to `until` (exclusive) that may write the cell; `None` if there is
    /// none. The search goes downwards from `until`, each time by the largest block that ends there.
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

/// All havocs that a scan may execute, in order of execution.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Havocs {
    all: Vec<Havoc>,
    /// For each area, the havocs that may write it.
    areas: Vec<AreaWrites>,
}

/// Stores a position or index in 32 bits.
fn short(number: usize) -> u32 {
    u32::try_from(number).expect("the number of writes of any value must fit in 32 bits")
}

impl Havocs {
    /// An empty list, for this number of areas.
    #[must_use]
    pub fn of_areas(areas: usize) -> Havocs {
        Havocs { all: Vec::new(), areas: vec![AreaWrites::default(); areas] }
    }

    /// Appends a havoc, as the latest one.
    pub fn push(&mut self, havoc: Havoc) {
        let (index, region, happened) = (short(self.all.len()), havoc.region, havoc.executed);
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

    /// All havocs in order of execution.
    #[must_use]
    pub fn all(&self) -> &[Havoc] {
        &self.all
    }

    /// The number of havocs in the list that may write a cell of the area.
    #[must_use]
    pub fn count(&self, area: AreaId) -> usize {
        self.areas[usize::from(area.0)].indices.len()
    }

    /// The havocs that may write the cell, latest first, among those with the numbers `since..until` in the cell's
    /// area.
    pub fn concerning(&self, cell: Cell, since: u32, until: u32) -> impl Iterator<Item = &Havoc> {
        let area = &self.areas[usize::from(cell.area.0)];
        let (since, mut until) = (since as usize, until as usize);
        std::iter::from_fn(move || {
            until = area.newest(cell, since, until)?;
            Some(&self.all[area.indices[until] as usize])
        })
    }

    /// The havocs that are executed in one scan; `holds` says whether a literal is true in this scan.
    #[must_use]
    pub fn executed(&self, holds: impl Fn(Lit) -> bool) -> ExecutedHavocs<'_> {
        let happens = |&place: &usize, area: &AreaWrites| {
            holds(self.all[area.indices[place] as usize].executed)
        };
        let of = |area: &AreaWrites| {
            let places = 0..area.indices.len();
            places.filter(|place| happens(place, area)).map(short).collect()
        };
        ExecutedHavocs { havocs: self, places: self.areas.iter().map(of).collect() }
    }

    /// The position in the cell's area of the last havoc from `since` on that may write the cell and is executed in
    /// every scan (its literal is constant true); `None` if there is none.
    #[must_use]
    pub fn newest_certain(&self, cell: Cell, since: usize) -> Option<usize> {
        let area = &self.areas[usize::from(cell.area.0)];
        let places = area.certain.iter().rev().map(|&place| place as usize);
        let mut places = places.take_while(|&place| place >= since);
        places.find(|&place| area.blocks[0][place].any.holds(cell))
    }

    /// Which havocs of a block may write the cell. The block consists of the positions from `number << level` to
    /// `(number + 1) << level` (exclusive) of the cell's area.
    #[must_use]
    pub fn block(&self, cell: Cell, level: u32, number: usize) -> Coverage {
        let block = self.areas[usize::from(cell.area.0)].blocks[level as usize][number];
        match (block.any.holds(cell), block.every.holds(cell)) {
            (false, _) => Coverage::None,
            (true, true) => Coverage::All,
            (true, false) => Coverage::Some,
        }
    }

    /// The literal that says whether the havoc at this position of the area is executed.
    #[must_use]
    pub fn happened(&self, area: AreaId, place: usize) -> Lit {
        self.all[self.areas[usize::from(area.0)].indices[place] as usize].executed
    }

    /// A copy in which each havoc has a new literal for whether it is executed: the one that `happened` returns for the
    /// old literal.
    #[must_use]
    pub fn with_conditions(&self, mut happened: impl FnMut(Lit) -> Lit) -> Havocs {
        let mut found = Havocs::of_areas(self.areas.len());
        for havoc in &self.all {
            found.push(Havoc { executed: happened(havoc.executed), ..havoc.clone() });
        }
        found
    }
}

/// The havocs that are executed in one scan.
pub struct ExecutedHavocs<'a> {
    havocs: &'a Havocs,
    /// For each area, the positions of the executed havocs among the havocs of the area, ascending.
    places: Vec<Vec<u32>>,
}

impl<'a> ExecutedHavocs<'a> {
    /// The last executed havoc that may write the cell, among numbers `since..until` of the cell's area; `None` if
    /// there is none.
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

/// Which havocs of a block may write a cell.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Coverage {
    /// None of the havocs may write the cell.
    None,
    /// Some of the havocs may write the cell. It is also possible that none may, because the joined range of several
    /// havocs includes the gaps between their ranges.
    Some,
    /// All of the havocs may write the cell.
    All,
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cell(area: u16, index: u32) -> Cell {
        Cell { area: AreaId(area), index }
    }

    /// Random havocs of two areas, some of which are always executed.
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
            havocs.push(Havoc {
                region,
                executed: happened,
                frames: Vec::new(),
                choice: ChoiceId(n),
            });
        }
        havocs
    }

    #[test]
    fn what_concerns_a_cell_is_found_newest_first() {
        for count in [0, 1, 2, 7, 64, 100] {
            let havocs = some(count);
            let holds = |lit: Lit| lit.0.is_multiple_of(8);
            let happened = havocs.executed(holds);
            for area in 0..2 {
                let in_area = |havoc: &&Havoc| match havoc.region {
                    Region::Range { first, .. } => first.area.0 == area,
                    Region::Area(other) => other.0 == area,
                    Region::Everything => true,
                };
                let in_area: Vec<&Havoc> = havocs.all.iter().filter(in_area).collect();
                assert_eq!(havocs.count(AreaId(area)), in_area.len());
                for index in 0..50 {
                    let cell = cell(area, index);
                    for since in 0..in_area.len() {
                        for until in since..=in_area.len() {
                            let all = in_area[since..until].iter().rev().copied();
                            let wanted = all.filter(|one| one.region.contains(cell));
                            let found = havocs.concerning(cell, since as u32, until as u32);
                            assert!(found.eq(wanted.clone()), "{area} {index} {since} {until}");
                            let newest = happened.newest(cell, since as u32, until as u32);
                            let mut happening = wanted.filter(|one| holds(one.executed));
                            assert_eq!(newest, happening.next());
                        }
                        let certain = |place: &usize| {
                            in_area[*place].executed == Lit::TRUE
                                && in_area[*place].region.contains(cell)
                        };
                        let newest = (since..in_area.len()).rev().find(certain);
                        assert_eq!(havocs.newest_certain(cell, since), newest);
                    }
                }
            }
        }
    }

    #[test]
    fn a_block_says_which_cells_it_concerns() {
        let havocs = some(90);
        let mut tested = [0; 3];
        for index in 0..50 {
            let cell = cell(0, index);
            for (level, blocks) in (0..).zip(&havocs.areas[0].blocks) {
                for number in 0..blocks.len() {
                    let places = number << level..(number + 1) << level;
                    let in_block = &havocs.areas[0].indices[places];
                    let holds = |&index: &u32| havocs.all[index as usize].region.contains(cell);
                    let concerned = havocs.block(cell, level, number);
                    match concerned {
                        Coverage::None => assert!(!in_block.iter().any(holds)),
                        Coverage::All => assert!(in_block.iter().all(holds)),
                        Coverage::Some => {}
                    }
                    tested[concerned as usize] += 1;
                }
            }
        }
        assert!(tested.iter().all(|&count| count > 100), "{tested:?}");
    }

    #[test]
    fn other_conditions_make_others_certain() {
        let havocs = some(30).with_conditions(|happened| Lit(happened.0 / 4));
        let certain: usize = havocs.areas.iter().map(|area| area.certain.len()).sum();
        let holding = havocs.areas.iter().flat_map(|area| &area.indices);
        let wanted = holding.filter(|&&index| havocs.all[index as usize].executed == Lit::TRUE);
        assert_eq!(certain, wanted.count());
        assert!(certain > 3);
    }
}
