//! Sets of regions that are searched in logarithmic time.

use crate::value::{AreaId, Cell, Region};
use std::collections::BTreeSet;

/// A set of cells, built from regions.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct RegionSet {
    /// Whether the set contains every cell of every area.
    everything: bool,
    /// The areas that the set contains whole.
    areas: BTreeSet<AreaId>,
    /// Ranges in ascending order, none of which overlaps or touches the next one.
    ranges: Vec<(Cell, u32)>,
}

impl RegionSet {
    /// Whether the region and the set have cells in common.
    #[must_use]
    pub fn overlaps(&self, region: Region) -> bool {
        if self.everything {
            return true;
        }
        match region {
            Region::Everything => !self.areas.is_empty() || !self.ranges.is_empty(),
            Region::Area(area) => {
                self.areas.contains(&area)
                    || self.ranges.iter().any(|(first, _)| first.area == area)
            }
            Region::Range { first, count } => {
                let end = first.index.saturating_add(count);
                self.areas.contains(&first.area)
                    || self.last_before(Cell { index: end, ..first }).is_some_and(|(own, many)| {
                        own.area == first.area && first.index < own.index.saturating_add(many)
                    })
            }
        }
    }

    /// Whether the set contains all cells of the region.
    #[must_use]
    pub fn contains(&self, region: Region) -> bool {
        if self.everything {
            return true;
        }
        match region {
            Region::Everything => false,
            Region::Area(area) => self.areas.contains(&area),
            Region::Range { first, count } => {
                let next = Cell { index: first.index.saturating_add(1), ..first };
                self.areas.contains(&first.area)
                    || self.last_before(next).is_some_and(|(own, many)| {
                        own.area == first.area
                            && first.index.saturating_add(count) <= own.index.saturating_add(many)
                    })
            }
        }
    }

    /// The last range that begins before this cell, in the order of areas and indices: it may be in an earlier area.
    /// `None` if there is none.
    fn last_before(&self, cell: Cell) -> Option<(Cell, u32)> {
        let behind = self.ranges.partition_point(|&(first, _)| first < cell);
        self.ranges[..behind].last().copied()
    }

    /// Adds a range, and joins it with those that it overlaps or touches.
    fn insert(&mut self, mut first: Cell, count: u32) {
        let mut end = first.index.saturating_add(count);
        let is_before = |&(own, many): &(Cell, u32)| {
            (own.area, own.index.saturating_add(many)) < (first.area, first.index)
        };
        let from = self.ranges.partition_point(is_before);
        let mut to = from;
        while let Some(&(own, many)) = self.ranges.get(to)
            && own.area == first.area
            && own.index <= end
        {
            first.index = first.index.min(own.index);
            end = end.max(own.index.saturating_add(many));
            to += 1;
        }
        self.ranges.splice(from..to, [(first, end - first.index)]);
    }

    /// The set as regions: everything, whole areas, then ranges. Ranges that overlap or touch are joined, but ranges
    /// within a whole area of the set stay.
    #[must_use]
    pub fn into_regions(self) -> Vec<Region> {
        let everything = self.everything.then_some(Region::Everything).into_iter();
        let areas = self.areas.into_iter().map(Region::Area);
        let ranges = self.ranges.into_iter().map(|(first, count)| Region::Range { first, count });
        everything.chain(areas).chain(ranges).collect()
    }
}

impl Extend<Region> for RegionSet {
    fn extend<I: IntoIterator<Item = Region>>(&mut self, regions: I) {
        let mut ranges = Vec::new();
        for region in regions {
            match region {
                Region::Everything => self.everything = true,
                Region::Area(area) => _ = self.areas.insert(area),
                Region::Range { count: 0, .. } => {}
                Region::Range { first, count } => ranges.push((first, count)),
            }
        }
        ranges.sort_unstable();
        ranges.into_iter().for_each(|(first, count)| self.insert(first, count));
    }
}

impl FromIterator<Region> for RegionSet {
    fn from_iter<I: IntoIterator<Item = Region>>(regions: I) -> RegionSet {
        let mut set = RegionSet::default();
        set.extend(regions);
        set
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::flow::overlap;

    fn range(area: u16, index: u32, count: u32) -> Region {
        Region::Range { first: Cell { area: AreaId(area), index }, count }
    }

    #[test]
    fn a_set_answers_as_its_regions_do() {
        let regions = [
            range(0, 4, 2),
            range(0, 6, 1),
            range(0, 5, 3),
            range(0, 20, 5),
            range(2, 0, 1),
            Region::Area(AreaId(3)),
        ];
        // At once, and one after another.
        let set: RegionSet = regions.into_iter().collect();
        let mut grown = RegionSet::default();
        regions.into_iter().for_each(|one| grown.extend([one]));
        assert_eq!(grown, set);
        let asked = (0..5).flat_map(|area| {
            let ranges = (0..30).flat_map(move |index| (1..6).map(move |n| range(area, index, n)));
            ranges.chain([Region::Area(AreaId(area))])
        });
        for region in asked.chain([Region::Everything]) {
            let overlaps = regions.iter().any(|&own| overlap(own, region));
            assert_eq!(set.overlaps(region), overlaps, "{region:?}");
            let holds = match region {
                Region::Range { first, count } => {
                    (0..count).all(|at| regions.iter().any(|one| one.contains(first.plus(at))))
                }
                region => regions.contains(&region),
            };
            assert_eq!(set.contains(region), holds, "{region:?}");
        }
        let merged = [Region::Area(AreaId(3)), range(0, 4, 4), range(0, 20, 5), range(2, 0, 1)];
        assert_eq!(set.into_regions(), merged);
        assert!(RegionSet::from_iter([Region::Everything]).contains(Region::Area(AreaId(1))));
    }
}
