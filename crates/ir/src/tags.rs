//! Data that is not flat: tags of simple types, arrays, structures and instances of function blocks, laid out over cells.
//!
//! A program's memory is areas of bits and of words, and stays so: a tag takes cells of one area of bits and of one of
//! words. In each the cells of its parts stand behind each other, so that an array whose index is not known, or an
//! instance of which anything may have changed, is one [`Region`] an area. A bit of a word (`Speed.3`) is
//! `BitSource::WordBit` as of any word.

use super::{AreaId, Cell, Region};
use std::collections::BTreeMap;
use std::sync::Arc;

/// What a tag holds.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Type {
    /// A truth value: one bit cell.
    Bit,
    /// A number, a time or a text of so many words, the least first.
    Words(u32),
    /// Elements of one type, numbered from `first` on. One of several dimensions is an array of arrays.
    Array {
        /// The first one's number.
        first: i64,
        /// How many.
        count: u32,
        /// What each holds.
        of: Arc<Type>,
    },
    /// Named parts: a structure, or an instance of a function block with all that it keeps from scan to scan.
    Parts(Arc<Parts>),
}

/// Named parts, and where each lies.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Parts {
    /// Names, types, and how many bit cells and word cells stand before each.
    all: Vec<(String, Type, [u32; 2])>,
    /// The number of the first part of each name.
    by_name: BTreeMap<String, usize>,
    /// How many cells all of them take; `None` if these are more than can be numbered.
    size: Option<[u32; 2]>,
}

impl FromIterator<(String, Type)> for Parts {
    fn from_iter<T: IntoIterator<Item = (String, Type)>>(parts: T) -> Parts {
        let mut found = Parts { all: Vec::new(), by_name: BTreeMap::new(), size: Some([0, 0]) };
        for (name, of) in parts {
            let before = found.size.unwrap_or([u32::MAX; 2]);
            found.size = of.size().and_then(|size| added(found.size?, size));
            found.by_name.entry(name.clone()).or_insert(found.all.len());
            found.all.push((name, of, before));
        }
        found
    }
}

impl Type {
    /// How many bit cells and word cells it takes; `None` if these are more than can be numbered.
    #[must_use]
    pub fn size(&self) -> Option<[u32; 2]> {
        match self {
            Type::Bit => Some([1, 0]),
            Type::Words(words) => Some([0, *words]),
            Type::Array { count, of, .. } => {
                let [bits, words] = of.size()?;
                Some([bits.checked_mul(*count)?, words.checked_mul(*count)?])
            }
            Type::Parts(parts) => parts.size,
        }
    }
}

fn added([bits, words]: [u32; 2], [more, further]: [u32; 2]) -> Option<[u32; 2]> {
    Some([bits.checked_add(more)?, words.checked_add(further)?])
}

/// A tag, or a part of one, and where it lies.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Tag {
    /// What it holds.
    pub of: Type,
    /// The areas of its bits and of its words.
    areas: [AreaId; 2],
    /// Its first cells there.
    at: [u32; 2],
}

impl Tag {
    /// The part of this name.
    #[must_use]
    pub fn part(&self, name: &str) -> Option<Tag> {
        let Type::Parts(parts) = &self.of else { return None };
        let (_, of, before) = &parts.all[*parts.by_name.get(name)?];
        Some(Tag { of: of.clone(), at: added(self.at, *before)?, ..*self })
    }

    /// The element of this number.
    #[must_use]
    pub fn element(&self, number: i64) -> Option<Tag> {
        let Type::Array { first, count, of } = &self.of else { return None };
        let place =
            u32::try_from(number.checked_sub(*first)?).ok().filter(|place| place < count)?;
        let [bits, words] = of.size()?;
        let at = added(self.at, [bits.checked_mul(place)?, words.checked_mul(place)?])?;
        Some(Tag { of: (**of).clone(), at, ..*self })
    }

    /// The bit, or the first of the words, where it is one value.
    #[must_use]
    pub fn cell(&self) -> Option<Cell> {
        let side = match self.of {
            Type::Bit => 0,
            Type::Words(1..) => 1,
            Type::Words(0) | Type::Array { .. } | Type::Parts(_) => return None,
        };
        Some(Cell { area: self.areas[side], index: self.at[side] })
    }

    /// All its cells.
    #[must_use]
    pub fn regions(&self) -> Vec<Region> {
        let size = self.of.size().unwrap_or_default();
        let sides = (0..2).filter(|&side| size[side] > 0);
        let region = |side: usize| Region::Range {
            first: Cell { area: self.areas[side], index: self.at[side] },
            count: size[side],
        };
        sides.map(region).collect()
    }
}

/// The tags of a program.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Tags {
    /// Names and tags by the first cells of their bits and of their words.
    starts: BTreeMap<Cell, (Arc<str>, Tag)>,
    /// The first cell of each area that no tag has.
    free: BTreeMap<AreaId, u32>,
}

impl Tags {
    /// Lays out a tag in an area of bits and one of words, behind what these have; `None` if there is no room.
    pub fn add(&mut self, areas: [AreaId; 2], name: &str, of: Type) -> Option<Tag> {
        let size = of.size()?;
        let at = areas.map(|area| self.free.get(&area).copied().unwrap_or(0));
        let end = added(at, size)?;
        let tag = Tag { of, areas, at };
        let name: Arc<str> = name.into();
        for side in (0..2).filter(|&side| size[side] > 0) {
            let first = Cell { area: areas[side], index: at[side] };
            self.starts.insert(first, (name.clone(), tag.clone()));
            self.free.insert(areas[side], end[side]);
        }
        Some(tag)
    }

    /// What users call a cell of a tag: `Axes[3].Speed`, of words behind the first of a value with their number.
    #[must_use]
    pub fn name(&self, cell: Cell) -> Option<String> {
        let (first, (name, tag)) = self.starts.range(..=cell).next_back()?;
        let side = tag.areas.iter().position(|&area| area == cell.area)?;
        let offset = cell.index.checked_sub(first.index).filter(|_| cell.area == first.area)?;
        let is_in = offset < tag.of.size()?[side];
        is_in.then(|| named(name.to_string(), &tag.of, side, offset)).flatten()
    }
}

/// What users call the cell at an offset from the first of a type's.
fn named(name: String, of: &Type, side: usize, offset: u32) -> Option<String> {
    match of {
        Type::Bit | Type::Words(_) if offset == 0 => Some(name),
        Type::Bit | Type::Words(_) => Some(format!("{name}, word {}", offset + 1)),
        Type::Array { first, of, .. } => {
            let size = of.size()?[side];
            let number = first + i64::from(offset.checked_div(size)?);
            named(format!("{name}[{number}]"), of, side, offset % size)
        }
        Type::Parts(parts) => {
            // Parts that take nothing there stand at the same place as the one behind them.
            let behind = parts.all.partition_point(|(.., before)| before[side] <= offset);
            let mut before = parts.all[..behind].iter().rev();
            let (part, of, before) =
                before.find(|(_, of, _)| of.size().is_some_and(|size| size[side] > 0))?;
            named(format!("{name}.{part}"), of, side, offset - before[side])
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Area, AreaKind, Program, Radix};

    const AREAS: [AreaId; 2] = [AreaId(0), AreaId(1)];

    /// A timer's instance, and two axes of a structure with an array in it.
    fn program() -> (Program, Tag, Tag) {
        let part = |name: &str, of| (name.to_owned(), of);
        let parts = |all: Vec<(String, Type)>| Type::Parts(Arc::new(all.into_iter().collect()));
        let timer = parts([part("Q", Type::Bit), part("ET", Type::Words(2))].into());
        let limits = Type::Array { first: -1, count: 3, of: Arc::new(Type::Words(1)) };
        let axis = [part("On", Type::Bit), part("Limits", limits), part("Delay", timer.clone())];
        let axes = Type::Array { first: 1, count: 2, of: Arc::new(parts(axis.into())) };
        let kinds = [AreaKind::Bit, AreaKind::Word];
        let areas = kinds.map(|kind| Area::new("cell ", kind, Radix::Decimal));
        let mut program = Program { areas: areas.into(), ..Program::default() };
        let wait = program.tags.add(AREAS, "Wait", timer).expect("room");
        let axes = program.tags.add(AREAS, "Axes", axes).expect("room");
        (program, wait, axes)
    }

    #[test]
    fn every_cell_of_a_tag_is_its_own_and_has_the_name_that_leads_to_it() {
        let (program, wait, axes) = program();
        let delay = axes.element(2).and_then(|axis| axis.part("Delay")).expect("a part");
        let limit = axes.element(1).and_then(|axis| axis.part("Limits")?.element(-1));
        for (tag, name, area, index) in [
            (wait.part("Q"), "Wait.Q", 0, 0),
            (wait.part("ET"), "Wait.ET", 1, 0),
            (limit, "Axes[1].Limits[-1]", 1, 2),
            (delay.part("Q"), "Axes[2].Delay.Q", 0, 4),
            (delay.part("ET"), "Axes[2].Delay.ET", 1, 10),
        ] {
            let cell = tag.and_then(|tag| tag.cell()).expect(name);
            assert_eq!(cell, Cell { area: AreaId(area), index }, "{name}");
            assert_eq!(program.cell_name(cell), name);
        }
        let second = Cell { area: AreaId(1), index: 11 };
        assert_eq!(program.cell_name(second), "Axes[2].Delay.ET, word 2");
        let behind = Cell { area: AreaId(1), index: 12 };
        assert_eq!(program.cell_name(behind), "cell 12");
    }

    #[test]
    fn what_may_have_changed_of_a_tag_is_one_region_an_area() {
        let (_, wait, axes) = program();
        let range =
            |area, index, count| Region::Range { first: Cell { area: AreaId(area), index }, count };
        assert_eq!(wait.regions(), [range(0, 0, 1), range(1, 0, 2)]);
        assert_eq!(axes.regions(), [range(0, 1, 4), range(1, 2, 10)]);
        assert_eq!((axes.cell(), axes.element(0), axes.element(3)), (None, None, None));
        assert_eq!(axes.part("Delay"), None);
    }

    #[test]
    fn what_is_too_large_to_be_numbered_has_no_room() {
        let many = |count, of| Type::Array { first: 0, count, of: Arc::new(of) };
        let mut tags = Tags::default();
        assert_eq!(tags.add(AREAS, "A", many(u32::MAX, many(2, Type::Words(1)))), None);
        assert!(tags.add(AREAS, "B", many(u32::MAX, Type::Bit)).is_some());
        assert_eq!(tags.add(AREAS, "C", Type::Bit), None);
    }
}
