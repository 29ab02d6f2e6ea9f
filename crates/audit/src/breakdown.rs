//! Where the bound's time goes: parts that add up to the bound exactly, in picoseconds.

use super::{Audit, ChargeUse, Share};
use scanbound_base::location::Location;
use scanbound_base::time::Picos;
use std::cmp::Reverse;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

/// What [`Audit::breakdown`] divides the bound by.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum By {
    /// One part for each program file.
    Program,
    /// One part for each called routine and each interrupt routine of each file. The code of a file outside of these
    /// routines is one part.
    Routine,
    /// One part for each rung.
    Rung,
    /// One part for each instruction name, over all files.
    Instruction,
}

impl By {
    /// All divisions, the coarsest first.
    pub const ALL: [By; 4] = [By::Program, By::Routine, By::Rung, By::Instruction];

    /// The name of the division in options and reports.
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

/// What a part of the bound belongs to: a piece of the program, or something besides its instructions.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Piece {
    /// All instructions of a program file, by its index in `Audit::files`.
    Program(u32),
    /// A routine, by the index of its file and its name. Without a name: the code of the file outside of called
    /// routines and interrupt routines.
    Routine(u32, Option<Arc<str>>),
    /// A rung, shown by its instruction with the largest part of the bound.
    Rung {
        /// The number of the rung.
        block: u32,
        /// The place of the rung's instruction with the largest part of the bound.
        at: Location,
        /// The text of the rung's instruction with the largest part of the bound.
        instruction: Arc<str>,
    },
    /// All instructions of this name, such as `MOV`.
    Instruction(Arc<str>),
    /// A time that every scan takes besides its instructions, by the name of the term in the table.
    EveryScan(String),
    /// The part that the search left open: the difference between the bound and the longest scan that the model is
    /// known to allow.
    Open,
    /// The time that the table's factor on the whole scan adds to all other parts. Holds the factor as written in the
    /// table.
    Factor(String),
}

impl Piece {
    /// The name of the kind of this piece in reports.
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

/// A part of the bound, as [`Audit::breakdown`] divides it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Part {
    /// The program, routine, rung, instruction or overhead to which the time belongs.
    pub piece: Piece,
    /// The time of the part, without the table's factor. For [`Piece::Factor`]: what the factor adds.
    pub time: Picos,
    /// The time of the part if every charge took the larger of its two times. What exceeds `time` is saved by mutual
    /// exclusion. Equal to `time` for overhead, what is left open, and the factor.
    pub most: Picos,
    /// The time of those charges in the part whose time is the same in every scan. For overhead, all of its time.
    pub always: Picos,
    /// The number of places in the part that have an instruction: several instructions at one line and step count once.
    /// 0 for overhead, what is left open, and the factor.
    pub instructions: usize,
}

impl Part {
    /// The part's time as a share of the audit's upper bound.
    #[must_use]
    pub fn share(&self, audit: &Audit) -> Share {
        Share::of(self.time, audit.bound.upper)
    }
}

/// The charges of one part, added up. `largest` is the charge with the largest share of the bound (of equal shares, the
/// one with the larger on- or off-time), as a tuple: this share, the larger of its two times, and the charge.
#[derive(Default)]
struct ChargePile<'a> {
    time: Picos,
    most: Picos,
    always: Picos,
    places: BTreeSet<Location>,
    largest: Option<(Picos, Picos, &'a ChargeUse)>,
}

impl<'a> ChargePile<'a> {
    fn add(&mut self, charge: &'a ChargeUse, is_always: bool) {
        let most = charge.on.max(charge.off);
        self.time += charge.share;
        self.most += most;
        if is_always {
            self.always += charge.share;
        }
        self.places.insert(charge.at);
        let is_larger =
            |&(share, known, _): &(Picos, Picos, _)| (share, known) < (charge.share, most);
        if self.largest.as_ref().is_none_or(is_larger) {
            self.largest = Some((charge.share, most, charge));
        }
    }
}

/// The key that decides to which part a charge belongs.
#[derive(PartialEq, Eq, PartialOrd, Ord)]
enum Key<'a> {
    File(u32),
    Routine(u32, Option<&'a str>),
    Block(u32),
    Mnemonic(&'a str),
}

impl Audit {
    /// Divides the bound into parts whose times add up to it. The parts come in this order: the requested division, the
    /// longest first; overhead; what the search left open, if anything; the table's factor, if there is one.
    #[must_use]
    pub fn breakdown(&self, by: By) -> Vec<Part> {
        let mut piles: BTreeMap<Key<'_>, ChargePile<'_>> = BTreeMap::new();
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

    /// [`assumed_part`](Audit::assumed_part) as a share of the upper bound.
    #[must_use]
    pub fn assumed_share(&self) -> Share {
        Share::of(self.assumed_part(), self.bound.upper)
    }

    /// The part of the bound that can rest on assumed times, including all that the search left open. 0 if the program
    /// uses no assumed time.
    #[must_use]
    pub fn assumed_part(&self) -> Picos {
        if self.table.assumed.is_empty() {
            return Picos::ZERO;
        }
        self.table.assumed.iter().map(|one| one.part).sum::<Picos>() + self.open()
    }

    fn part(&self, (key, pile): (Key<'_>, ChargePile<'_>)) -> Option<Part> {
        let (.., largest) = pile.largest?;
        let piece = match key {
            Key::File(file) => Piece::Program(file),
            Key::Routine(file, _) => Piece::Routine(file, largest.routine.clone()),
            Key::Block(block) => {
                Piece::Rung { block, at: largest.at, instruction: largest.instruction.clone() }
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

    /// Whether every part of the bound is known: the search left nothing open, or the bound is the structural bound.
    #[must_use]
    pub fn is_settled(&self) -> bool {
        self.open() == Picos::ZERO
    }

    /// The part of the bound that is left open: its difference to the longest scan that the model is known to allow. It
    /// includes the table's factor.
    #[must_use]
    pub fn open(&self) -> Picos {
        let open = self.groups.iter().map(|group| {
            let shares: Picos = group.charges.iter().map(|charge| charge.share).sum();
            group.upper.checked_sub(shares).unwrap_or_default()
        });
        open.sum()
    }

    /// A time without the table's factor, rounded down. Together with the factor's part, the times add up to the bound.
    fn without_factor(&self, time: Picos) -> Picos {
        let Some(factor) = &self.table.factor else { return time };
        let bare = u128::from(time.0) * 1_000_000 / u128::from(factor.millionths.max(1));
        Picos(u64::try_from(bare).unwrap_or(time.0))
    }
}

/// The name of an instruction: the first word of its text. Empty if the text is empty.
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
    fn the_rung_with_the_most_time_comes_first_and_the_gap_is_a_part() {
        let parts = fixture().breakdown(By::Rung);
        let Piece::Rung { block, at, instruction } = &parts[0].piece else { panic!("{parts:?}") };
        assert_eq!((*block, at.line, &**instruction), (2, 4, "BMOV D200 D300 K10"));
        assert_eq!(parts.last().map(|part| &part.piece), Some(&Piece::Open));
        let always: Picos = parts.iter().map(|part| part.always).sum();
        assert_eq!(always, Picos(212_000_000));
    }
}
