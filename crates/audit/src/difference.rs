//! What two versions of a project differ in: rungs matched by what they say, and what each change costs.

use super::Audit;
use super::breakdown::{By, Piece};
use scanbound_base::location::Location;
use scanbound_base::time::Picos;
use scanbound_ir::location_text::short_file_name;
use similar::{Algorithm, DiffOp, capture_diff_slices};
use std::cmp::Reverse;
use std::collections::{BTreeMap, BTreeSet};

/// One version's side of a change.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Side {
    /// The file, as the user named it.
    pub file: String,
    /// Where the rung's first instruction stands.
    pub at: Location,
    /// The rung's instructions, apart by ` / `.
    pub text: String,
    /// Its part in the bound, without the table's factor.
    pub time: Picos,
}

/// What became of a rung.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Kind {
    /// It says something else now.
    Changed,
    /// It is new.
    Added,
    /// It is gone.
    Removed,
    /// It says the same elsewhere.
    Moved,
    /// It says the same at its place, and takes another part in the bound.
    Same,
}

impl Kind {
    /// Its name.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Kind::Changed => "changed",
            Kind::Added => "added",
            Kind::Removed => "removed",
            Kind::Moved => "moved",
            Kind::Same => "same",
        }
    }
}

/// A rung in both versions, or in one.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Change {
    /// What became of it.
    pub kind: Kind,
    /// In the old version.
    pub old: Option<Side>,
    /// In the new one.
    pub new: Option<Side>,
}

impl Change {
    /// By how much its part in the bound grew, in picoseconds; negative where it shrank.
    #[must_use]
    pub fn delta(&self) -> i128 {
        let time = |side: &Option<Side>| side.as_ref().map_or(0, |side| i128::from(side.time.0));
        time(&self.new) - time(&self.old)
    }
}

/// What two versions differ in.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Difference {
    /// The files of the old version.
    pub old_files: Vec<String>,
    /// The files of the new one.
    pub new_files: Vec<String>,
    /// The old bound.
    pub old: Picos,
    /// The new bound.
    pub new: Picos,
    /// Rungs that say something else, stand elsewhere or cost something else, those that change the bound most first.
    pub changes: Vec<Change>,
    /// How many rungs say and cost the same.
    pub unchanged: usize,
    /// By how much all else changed the bound: what each scan costs, what the search left open, the factor.
    pub besides: i128,
    /// Whether either bound may be too low, as something is not stated.
    pub is_doubtful: bool,
    /// Whether a scan of the new version can go round a loop for ever: its bound holds for scans that end.
    pub is_endless: bool,
    /// By how many millionths of the old bound the new one may be larger, if that is a condition.
    pub allowed: Option<u32>,
}

impl Difference {
    /// Of two audits. The bound may grow by so many millionths, if that is a condition.
    #[must_use]
    pub fn of(old: &Audit, new: &Audit, allowed: Option<u32>) -> Difference {
        let (before, after) = (rungs(old), rungs(new));
        let mut matched = Matched::default();
        for (old, new) in pairs(&before, &after) {
            matched.add(old, new);
        }
        let (changes, unchanged) = matched.finish();
        let told: i128 = changes.iter().map(Change::delta).sum();
        let whole = i128::from(new.bound.upper.0) - i128::from(old.bound.upper.0);
        let doubtful =
            |audit: &Audit| !audit.all_doubts().is_empty() || !audit.unbounded.is_empty();
        Difference {
            old_files: old.files.clone(),
            new_files: new.files.clone(),
            old: old.bound.upper,
            new: new.bound.upper,
            changes,
            unchanged,
            besides: whole - told,
            is_doubtful: doubtful(old) || doubtful(new),
            is_endless: !new.unbounded.is_empty(),
            allowed,
        }
    }

    /// By how much the bound grew, in picoseconds.
    #[must_use]
    pub fn delta(&self) -> i128 {
        i128::from(self.new.0) - i128::from(self.old.0)
    }

    /// The growth in thousandths of the old bound, rounded to the nearest away from nothing.
    #[must_use]
    pub fn thousandths(&self) -> i128 {
        let (delta, old) = (self.delta(), i128::from(self.old.0).max(1));
        (delta.abs() * 2000 + old) / (old * 2) * delta.signum()
    }

    /// Whether the bound grew by more than is allowed, as it does where a scan need not end.
    #[must_use]
    pub fn is_above(&self) -> bool {
        let above =
            |allowed| self.delta() * 1_000_000 > i128::from(self.old.0) * i128::from(allowed);
        self.allowed.is_some_and(|allowed| self.is_endless || above(allowed))
    }
}

/// The rungs of each file, in its order, by the file's short name.
fn rungs(audit: &Audit) -> BTreeMap<String, Vec<Side>> {
    let mut lines: BTreeMap<u32, BTreeSet<(Location, &str)>> = BTreeMap::new();
    let groups = audit.groups.iter().flat_map(|group| &group.charges);
    for charge in groups.chain(&audit.always) {
        lines.entry(charge.block).or_default().insert((charge.at, &charge.instruction));
    }
    let names = || audit.files.iter().map(String::as_str);
    let mut found: BTreeMap<String, Vec<Side>> = BTreeMap::new();
    for part in audit.breakdown(By::Rung) {
        let Piece::Rung { block, at, .. } = part.piece else { continue };
        let lines = &lines[&block];
        let text: Vec<&str> = lines.iter().map(|(_, text)| *text).collect();
        let file = at.of(&audit.files);
        let side = Side {
            file: file.clone(),
            at: lines.first().map_or(at, |(first, _)| *first),
            text: text.join(" / "),
            time: part.time,
        };
        found.entry(short_file_name(file, names()).to_owned()).or_default().push(side);
    }
    found.values_mut().for_each(|sides| sides.sort_by_key(|side| side.at));
    found
}

type Rungs = BTreeMap<String, Vec<Side>>;

/// The files that are one another's versions: of one name, or each the only one.
fn pairs<'a>(old: &'a Rungs, new: &'a Rungs) -> Vec<(&'a [Side], &'a [Side])> {
    if let (1, 1) = (old.len(), new.len()) {
        return old.values().zip(new.values()).map(|(a, b)| (&a[..], &b[..])).collect();
    }
    let names: BTreeSet<&String> = old.keys().chain(new.keys()).collect();
    let of = |rungs: &'a Rungs, name: &String| rungs.get(name).map_or(&[][..], Vec::as_slice);
    names.into_iter().map(|name| (of(old, name), of(new, name))).collect()
}

/// A rung that one version alone has, so far, and the stretch of the files in which it stands.
struct Loose {
    stretch: usize,
    side: Side,
}

/// So many rungs of a stretch are looked at as what an old one became.
const MOST_LOOKED_AT: usize = 64;

/// What was matched so far.
#[derive(Default)]
struct Matched {
    changes: Vec<Change>,
    unchanged: usize,
    stretches: usize,
    removed: Vec<Loose>,
    added: Vec<Loose>,
}

impl Matched {
    /// Matches the rungs of one file.
    fn add(&mut self, old: &[Side], new: &[Side]) {
        let texts =
            |sides: &[Side]| -> Vec<String> { sides.iter().map(|one| one.text.clone()).collect() };
        for op in capture_diff_slices(Algorithm::Patience, &texts(old), &texts(new)) {
            let (old, new) = (&old[op.old_range()], &new[op.new_range()]);
            if let DiffOp::Equal { .. } = op {
                for (old, new) in old.iter().zip(new) {
                    match old.time == new.time {
                        true => self.unchanged += 1,
                        false => self.both(Kind::Same, old.clone(), new.clone()),
                    }
                }
                continue;
            }
            self.stretches += 1;
            let stretch = self.stretches;
            let loose = |side: &Side| Loose { stretch, side: side.clone() };
            self.removed.extend(old.iter().map(loose));
            self.added.extend(new.iter().map(loose));
        }
    }

    fn both(&mut self, kind: Kind, old: Side, new: Side) {
        self.changes.push(Change { kind, old: Some(old), new: Some(new) });
    }

    fn finish(mut self) -> (Vec<Change>, usize) {
        // What says the same elsewhere was moved; the rest is new, unless it is much like what stood there.
        let mut same: BTreeMap<String, Vec<Loose>> = BTreeMap::new();
        for loose in std::mem::take(&mut self.added).into_iter().rev() {
            same.entry(loose.side.text.clone()).or_default().push(loose);
        }
        let mut gone = Vec::new();
        for old in std::mem::take(&mut self.removed) {
            match same.get_mut(&old.side.text).and_then(Vec::pop) {
                Some(new) => self.both(Kind::Moved, old.side, new.side),
                None => gone.push(old),
            }
        }
        let mut fresh: BTreeMap<usize, Vec<Side>> = BTreeMap::new();
        for loose in same.into_values().flatten() {
            fresh.entry(loose.stretch).or_default().push(loose.side);
        }
        fresh.values_mut().for_each(|sides| sides.sort_by_key(|side| side.at));
        for old in gone {
            let candidates = fresh.entry(old.stretch).or_default();
            match nearest(&old.side, candidates) {
                Some(index) => {
                    let new = candidates.remove(index);
                    self.both(Kind::Changed, old.side, new);
                }
                None => {
                    let change = Change { kind: Kind::Removed, old: Some(old.side), new: None };
                    self.changes.push(change);
                }
            }
        }
        let added = fresh.into_values().flatten();
        self.changes.extend(added.map(|new| Change {
            kind: Kind::Added,
            old: None,
            new: Some(new),
        }));
        // What somebody changed comes first: the longest scan may run otherwise for a tie alone.
        self.changes.sort_by_cached_key(|one| {
            let side = one.new.as_ref().or(one.old.as_ref());
            let group = match one.kind {
                _ if one.delta() == 0 => 2,
                Kind::Same => 1,
                _ => 0,
            };
            (
                group,
                Reverse(one.delta().abs()),
                one.kind,
                side.map(|side| (side.file.clone(), side.at)),
            )
        });
        (self.changes, self.unchanged)
    }
}

/// The new rung that an old one most likely became: at least half of their instructions are the same.
fn nearest(old: &Side, fresh: &[Side]) -> Option<usize> {
    let own: Vec<&str> = old.text.split(" / ").collect();
    let alike = fresh.iter().take(MOST_LOOKED_AT).enumerate().filter_map(|(index, new)| {
        let other: Vec<&str> = new.text.split(" / ").collect();
        let ops = capture_diff_slices(Algorithm::Myers, &own, &other);
        let equal = ops.iter().filter(|op| matches!(op, DiffOp::Equal { .. }));
        let same: usize = equal.map(|op| op.old_range().len()).sum();
        let all = own.len() + other.len();
        (same * 4 >= all).then_some((same * 2000 / all, Reverse(index), index))
    });
    alike.max().map(|(.., index)| index)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn side(line: u32, text: &str, time: u64) -> Side {
        let at = Location { file: 0, line, step: None };
        Side { file: "a.il".to_owned(), at, text: text.to_owned(), time: Picos(time) }
    }

    #[test]
    fn rungs_are_matched_by_what_they_say() {
        let old = [
            side(1, "LD X0 / OUT Y0", 5),
            side(3, "LD X1 / MOV K1 D0", 20),
            side(5, "LD X2 / OUT Y2", 5),
            side(7, "LD X3 / OUT Y3", 5),
            side(9, "LD X4 / BMOV D0 D9 K9", 70),
        ];
        let new = [
            side(1, "LD X3 / OUT Y3", 5),
            side(3, "LD X0 / OUT Y0", 5),
            side(5, "LD X1 / MOV K7 D0", 30),
            side(7, "LD X2 / OUT Y2", 6),
            side(9, "FMOV K0 D0 K50", 90),
        ];
        let mut matched = Matched::default();
        matched.add(&old, &new);
        let (changes, unchanged) = matched.finish();
        assert_eq!(unchanged, 1);
        let told: Vec<(&str, i128)> =
            changes.iter().map(|one| (one.kind.name(), one.delta())).collect();
        assert_eq!(
            told,
            [("added", 90), ("removed", -70), ("changed", 10), ("same", 1), ("moved", 0)]
        );
    }
}
