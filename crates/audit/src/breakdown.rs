//! Where the bound's time goes: parts that add up to it, to the picosecond.

use super::{Audit, ChargeUse, Share};
use scanbound_base::location::Location;
use scanbound_base::time::Picos;
use std::cmp::Reverse;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

/// What the time is shared out to.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum By {
    /// Programs: files.
    Program,
    /// Routines of programs: what is called, and the rest.
    Routine,
    /// Rungs.
    Rung,
    /// Kinds of instructions.
    Instruction,
}

impl By {
    /// All of them, the coarsest first.
    pub const ALL: [By; 4] = [By::Program, By::Routine, By::Rung, By::Instruction];

    /// Its name.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            By::Program => "program",
            By::Routine => "routine",
            By::Rung => "rung",
            By::Instruction => "instruction",
        }
    }
}

/// What a part of the bound is for.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Piece {
    /// A program: an index into the files.
    Program(u32),
    /// A routine of a program; without a name what no call leads to.
    Routine(u32, Option<Arc<str>>),
    /// A rung, told by the dearest of its instructions.
    Rung {
        /// Its number.
        block: u32,
        /// The instruction's place.
        at: Location,
        /// The instruction's text.
        instruction: Arc<str>,
    },
    /// A kind of instruction.
    Instruction(Arc<str>),
    /// What each scan costs besides.
    EveryScan(String),
    /// What the search did not settle: the bound is higher than the dearest scan it found by this.
    Open,
    /// What the factor adds to all of the others.
    Factor(String),
}

impl Piece {
    /// What it is, in a word.
    #[must_use]
    pub fn kind(&self) -> &'static str {
        match self {
            Piece::Program(_) => By::Program.name(),
            Piece::Routine(..) => By::Routine.name(),
            Piece::Rung { .. } => By::Rung.name(),
            Piece::Instruction(_) => By::Instruction.name(),
            Piece::EveryScan(_) => "every_scan",
            Piece::Open => "open",
            Piece::Factor(_) => "factor",
        }
    }
}

/// A part of the bound.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Part {
    /// What for.
    pub piece: Piece,
    /// Its time, without the table's factor.
    pub time: Picos,
    /// What it would be if all of it ran at the dearer of its times: what exclusion takes off is the difference.
    pub most: Picos,
    /// How much of it no condition changes.
    pub always: Picos,
    /// How many instructions of the program it has.
    pub instructions: usize,
}

impl Part {
    /// Its share of the bound.
    #[must_use]
    pub fn share(&self, audit: &Audit) -> Share {
        Share::of(self.time, audit.bound.upper)
    }
}

/// Charges that belong together.
#[derive(Default)]
struct Pile<'a> {
    time: Picos,
    most: Picos,
    always: Picos,
    places: BTreeSet<Location>,
    dearest: Option<(Picos, Picos, &'a ChargeUse)>,
}

impl<'a> Pile<'a> {
    fn add(&mut self, charge: &'a ChargeUse, is_always: bool) {
        let most = charge.on.max(charge.off);
        self.time += charge.share;
        self.most += most;
        if is_always {
            self.always += charge.share;
        }
        self.places.insert(charge.at);
        let dearer = |&(share, known, _): &(Picos, Picos, _)| (share, known) < (charge.share, most);
        if self.dearest.as_ref().is_none_or(dearer) {
            self.dearest = Some((charge.share, most, charge));
        }
    }
}

/// What charges are sorted by.
#[derive(PartialEq, Eq, PartialOrd, Ord)]
enum Key<'a> {
    File(u32),
    Routine(u32, Option<&'a str>),
    Block(u32),
    Mnemonic(&'a str),
}

impl Audit {
    /// The bound by its parts, without the table's factor, which is a part of its own. The dearest of what was asked for
    /// come first, then what each scan costs, what the search left open, and the factor. All of them together are the
    /// bound.
    #[must_use]
    pub fn breakdown(&self, by: By) -> Vec<Part> {
        let mut piles: BTreeMap<Key<'_>, Pile<'_>> = BTreeMap::new();
        let groups = self.groups.iter().flat_map(|group| &group.charges);
        let charges = groups.map(|charge| (charge, false));
        for (charge, is_always) in charges.chain(self.always.iter().map(|one| (one, true))) {
            let key = match by {
                By::Program => Key::File(charge.at.file),
                By::Routine => Key::Routine(charge.at.file, charge.routine.as_deref()),
                By::Rung => Key::Block(charge.block),
                By::Instruction => Key::Mnemonic(mnemonic(&charge.instruction)),
            };
            piles.entry(key).or_default().add(charge, is_always);
        }
        let mut parts: Vec<Part> = piles.into_iter().filter_map(|one| self.part(one)).collect();
        parts.sort_by_key(|part| (Reverse(part.time), Reverse(part.most)));
        parts.extend(self.overhead.iter().map(|term| {
            let time = self.without_factor(term.time);
            let piece = Piece::EveryScan(term.name.clone());
            Part { piece, time, most: time, always: time, instructions: 0 }
        }));
        let alone =
            |piece, time| Part { piece, time, most: time, always: Picos::ZERO, instructions: 0 };
        let open = self.without_factor(self.open());
        if open > Picos::ZERO {
            parts.push(alone(Piece::Open, open));
        }
        if let Some(factor) = &self.table.factor {
            let others: Picos = parts.iter().map(|part| part.time).sum();
            let rest = self.bound.upper.checked_sub(others).unwrap_or_default();
            parts.push(alone(Piece::Factor(factor.text.clone()), rest));
        }
        parts
    }

    /// The same as a share of the bound.
    #[must_use]
    pub fn assumed_share(&self) -> Share {
        Share::of(self.assumed_part(), self.bound.upper)
    }

    /// How much of the bound rests on assumed times, what the search left open with it.
    #[must_use]
    pub fn assumed_part(&self) -> Picos {
        if self.table.assumed.is_empty() {
            return Picos::ZERO;
        }
        self.table.assumed.iter().map(|one| one.part).sum::<Picos>() + self.open()
    }

    fn part(&self, (key, pile): (Key<'_>, Pile<'_>)) -> Option<Part> {
        let (.., dearest) = pile.dearest?;
        let piece = match key {
            Key::File(file) => Piece::Program(file),
            Key::Routine(file, _) => Piece::Routine(file, dearest.routine.clone()),
            Key::Block(block) => {
                Piece::Rung { block, at: dearest.at, instruction: dearest.instruction.clone() }
            }
            Key::Mnemonic(name) => Piece::Instruction(name.into()),
        };
        Some(Part {
            piece,
            time: self.without_factor(pile.time),
            most: self.without_factor(pile.most),
            always: self.without_factor(pile.always),
            instructions: pile.places.len(),
        })
    }

    /// Whether it is known of all of the bound what takes it: the search left nothing open, or the bound is the sum of all.
    #[must_use]
    pub fn is_settled(&self) -> bool {
        self.open() == Picos::ZERO
    }

    /// By how much the bound is higher than the dearest scan that the search found.
    #[must_use]
    pub fn open(&self) -> Picos {
        let open = self.groups.iter().map(|group| {
            let shares: Picos = group.charges.iter().map(|charge| charge.share).sum();
            group.upper.checked_sub(shares).unwrap_or_default()
        });
        open.sum()
    }

    /// A time without the table's factor, rounded down: together with the factor's part this makes the bound.
    fn without_factor(&self, time: Picos) -> Picos {
        let Some(factor) = &self.table.factor else { return time };
        let bare = u128::from(time.0) * 1_000_000 / u128::from(factor.millionths.max(1));
        Picos(u64::try_from(bare).unwrap_or(time.0))
    }
}

/// The kind of an instruction: its first word.
fn mnemonic(text: &str) -> &str {
    text.split_whitespace().next().unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixture::fixture;
    use crate::{Evidence, FactorUse};

    fn sum(parts: &[Part]) -> Picos {
        parts.iter().map(|part| part.time).sum()
    }

    #[test]
    fn the_parts_add_up_to_the_bound_whatever_it_is_shared_out_by() {
        let mut audit = fixture();
        for by in By::ALL {
            assert_eq!(sum(&audit.breakdown(by)), audit.bound.upper, "{}", by.name());
        }
        let upper = audit.bound.upper;
        audit.table.factor = Some(FactorUse {
            text: "1.07".to_owned(),
            evidence: Evidence::Assumed,
            source: String::new(),
            without: upper,
            millionths: 1_070_000,
            part: Picos::ZERO,
        });
        for by in By::ALL {
            let parts = audit.breakdown(by);
            assert_eq!(sum(&parts), upper, "{}", by.name());
            let factor = parts.last().expect("a factor");
            assert_eq!(factor.piece, Piece::Factor("1.07".to_owned()));
            assert_eq!(factor.share(&audit).to_string(), "6.5 %");
        }
    }

    #[test]
    fn the_dearest_rung_comes_first_and_what_is_open_is_a_part() {
        let parts = fixture().breakdown(By::Rung);
        let Piece::Rung { block, at, instruction } = &parts[0].piece else { panic!("{parts:?}") };
        assert_eq!((*block, at.line, &**instruction), (2, 4, "BMOV D200 D300 K10"));
        assert_eq!(parts.last().map(|part| &part.piece), Some(&Piece::Open));
        let always: Picos = parts.iter().map(|part| part.always).sum();
        assert_eq!(always, Picos(212_000_000));
    }
}
