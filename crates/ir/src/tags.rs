//! Structured data: how tags of simple types, arrays, structures and function block instances are laid out in cells.
//!
//! A program's memory consists of areas of bits and areas of words. A tag occupies cells of one bit area and of one
//! word area. In each area the cells of its parts are consecutive, so an array with an unknown index, or an instance
//! that may have changed anywhere, is one [`Region`] in each area. A bit of a word (`Speed.3`) is `BitSource::WordBit`,
//! as for any word.

use super::{AreaId, Cell, Region};
use std::collections::BTreeMap;
use std::sync::Arc;

/// The type of a tag.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Type {
    /// A Boolean: one bit cell.
    Bit,
    /// A value of this many words, low word first, and how users read it.
    Words(u32, ValueForm),
    /// An array with indices from `first` on. An array of several dimensions is an array of arrays.
    Array {
        /// The lowest index of the array.
        first: i64,
        /// The number of elements of the array.
        count: u32,
        /// The type of the elements.
        of: Arc<Type>,
    },
    /// Named members: a structure, or a function block instance with everything that it keeps from scan to scan.
    Parts(Arc<Parts>),
}

/// How users read the words of a value.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum ValueForm {
    /// A signed number (two's complement).
    Signed,
    /// An unsigned number.
    Unsigned,
    /// IEEE 754 single precision, two words.
    Real,
    /// A time, the number of half milliseconds.
    Time,
    /// The words do not hold the value: a text or a reference, for which one word stands, or a date.
    Opaque,
}

/// Named members with their offsets.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Parts {
    /// The name and type of each member, and the numbers of bit cells and word cells that precede the member.
    all: Vec<(String, Type, [u32; 2])>,
    /// The index of the first member of each name.
    by_name: BTreeMap<String, usize>,
    /// The number of bit cells and word cells of all members; `None` if the numbers overflow.
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
    /// The number of bit cells and word cells of a value of this type; `None` if the numbers overflow.
    #[must_use]
    pub fn size(&self) -> Option<[u32; 2]> {
        match self {
            Type::Bit => Some([1, 0]),
            Type::Words(words, _) => Some([0, *words]),
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

/// A tag or a part of one, with its location.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Tag {
    /// The type of the tag.
    pub of: Type,
    /// The area of the tag's bits, and the area of its words.
    areas: [AreaId; 2],
    /// The index of the tag's first cell in each of these two areas.
    at: [u32; 2],
}

impl Tag {
    /// The member of a structure with this name. `None` if the tag is not a structure or has no such member.
    #[must_use]
    pub fn part(&self, name: &str) -> Option<Tag> {
        let Type::Parts(parts) = &self.of else { return None };
        let (_, of, before) = &parts.all[*parts.by_name.get(name)?];
        Some(Tag { of: of.clone(), at: added(self.at, *before)?, ..*self })
    }

    /// The cells at which the tag's bits and its words begin. If the tag has no bits, or no words, that cell may belong
    /// to another tag.
    #[must_use]
    pub fn begin(&self) -> [Cell; 2] {
        [0, 1].map(|side| Cell { area: self.areas[side], index: self.at[side] })
    }

    /// The member of a structure with this number, from 0. `None` if the tag is not a structure or has fewer members.
    #[must_use]
    pub fn part_at(&self, number: usize) -> Option<Tag> {
        let Type::Parts(parts) = &self.of else { return None };
        let (_, of, before) = parts.all.get(number)?;
        Some(Tag { of: of.clone(), at: added(self.at, *before)?, ..*self })
    }

    /// The element of an array with this index, counted from the array's own lowest index. `None` if the tag is not an
    /// array or the index is outside it.
    #[must_use]
    pub fn element(&self, number: i64) -> Option<Tag> {
        let Type::Array { first, count, of } = &self.of else { return None };
        let place =
            u32::try_from(number.checked_sub(*first)?).ok().filter(|place| place < count)?;
        let [bits, words] = of.size()?;
        let at = added(self.at, [bits.checked_mul(place)?, words.checked_mul(place)?])?;
        Some(Tag { of: (**of).clone(), at, ..*self })
    }

    /// For a value of a simple type: its bit, or the first of its words. `None` for arrays, structures and values of no
    /// words.
    #[must_use]
    pub fn cell(&self) -> Option<Cell> {
        let side = match self.of {
            Type::Bit => 0,
            Type::Words(1.., _) => 1,
            Type::Words(0, _) | Type::Array { .. } | Type::Parts(_) => return None,
        };
        Some(Cell { area: self.areas[side], index: self.at[side] })
    }

    /// All cells of the tag: at most one range of bits and one of words.
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

/// The structured data of a program: arrays and structures by name.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Tags {
    /// Names and tags by the first bit cell and the first word cell of each.
    starts: BTreeMap<Cell, (Arc<str>, Tag)>,
    /// The first unused cell of each area.
    free: BTreeMap<AreaId, u32>,
}

impl Tags {
    /// Adds a tag after the existing ones in an area of bits and an area of words. `None`, and nothing added, if its
    /// cells do not fit into one of the two areas.
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

    /// The name of a cell of a tag, such as `Axes[3].Speed`. A value of several words has the number of the word after
    /// its name, from the second word on. `None` if the cell belongs to no tag.
    #[must_use]
    pub fn name(&self, cell: Cell) -> Option<String> {
        let SimpleValue { name, word, .. } = self.value(cell)?;
        Some(if word == 0 { name } else { format!("{name}, word {}", word + 1) })
    }

    /// The bit, number or other simple value of a tag to which the cell belongs. `None` if it belongs to no tag.
    #[must_use]
    pub fn value(&self, cell: Cell) -> Option<SimpleValue<'_>> {
        let (first, (name, tag)) = self.starts.range(..=cell).next_back()?;
        let side = tag.areas.iter().position(|&area| area == cell.area)?;
        let offset = cell.index.checked_sub(first.index).filter(|_| cell.area == first.area)?;
        let is_in = offset < tag.of.size()?[side];
        is_in.then(|| simple_value(name.to_string(), &tag.of, side, offset)).flatten()
    }
}

/// A bit, a number or another simple value of a tag.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SimpleValue<'t> {
    /// The name of the value, such as `Axes[3].Speed`.
    pub name: String,
    /// [`Type::Bit`] or [`Type::Words`].
    pub of: &'t Type,
    /// Which word of the value a cell is, from 0.
    pub word: u32,
}

/// The simple value at this offset within a value of type `of`, whose own name is `name`. `None` if the value has no
/// such cell.
fn simple_value(name: String, of: &Type, side: usize, offset: u32) -> Option<SimpleValue<'_>> {
    match of {
        Type::Bit | Type::Words(..) => Some(SimpleValue { name, of, word: offset }),
        Type::Array { first, of, .. } => {
            let size = of.size()?[side];
            let number = first + i64::from(offset.checked_div(size)?);
            simple_value(format!("{name}[{number}]"), of, side, offset % size)
        }
        Type::Parts(parts) => {
            // A member without cells in this area has the same offset as the member after it.
            let behind = parts.all.partition_point(|(.., before)| before[side] <= offset);
            let mut before = parts.all[..behind].iter().rev();
            let (part, of, before) =
                before.find(|(_, of, _)| of.size().is_some_and(|size| size[side] > 0))?;
            simple_value(format!("{name}.{part}"), of, side, offset - before[side])
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Area, AreaKind, Program, Radix};

    const AREAS: [AreaId; 2] = [AreaId(0), AreaId(1)];

    /// A test program with a timer instance, and two axes of a structure that contains an array.
    fn program() -> (Program, Tag, Tag) {
        let part = |name: &str, of| (name.to_owned(), of);
        let parts = |all: Vec<(String, Type)>| Type::Parts(Arc::new(all.into_iter().collect()));
        let timer =
            parts([part("Q", Type::Bit), part("ET", Type::Words(2, ValueForm::Time))].into());
        let limits =
            Type::Array { first: -1, count: 3, of: Arc::new(Type::Words(1, ValueForm::Signed)) };
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
        assert_eq!(
            tags.add(AREAS, "A", many(u32::MAX, many(2, Type::Words(1, ValueForm::Signed)))),
            None
        );
        assert!(tags.add(AREAS, "B", many(u32::MAX, Type::Bit)).is_some());
        assert_eq!(tags.add(AREAS, "C", Type::Bit), None);
    }
}
