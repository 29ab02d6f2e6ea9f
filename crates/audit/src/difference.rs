//! Compares two versions of a project: matches rungs by their text and gives the cost of each change.

use super::Audit;
use super::breakdown::{By, Piece};
use scanbound_base::location::Location;
use scanbound_base::time::Picos;
use scanbound_ir::location_text::short_file_name;
use similar::{Algorithm, DiffOp, capture_diff_slices};
use std::cmp::Reverse;
use std::collections::{BTreeMap, BTreeSet};

/// A changed rung as it is in one of the two versions.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Side {
    /// The file, as the user named it.
    pub file: String,
    /// The place of the rung's first instruction that has a time.
    pub at: Location,
    /// The texts of the rung's instructions that have a time, separated by ` / `.
    pub text: String,
    /// The part of the bound that the rung takes, without the table's factor.
    pub time: Picos,
}

/// How a rung changed between the two versions.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum ChangeKind {
    /// The text of the rung changed: at least half of the instructions are the same as those of a rung at that place in
    /// the old version.
    Changed,
    /// The rung exists only in the new version. A rung that changed too much counts as removed and added.
    Added,
    /// The rung exists only in the old version.
    Removed,
    /// The text of the rung is the same, but it is in another place among the rungs, or in another file. Its part of
    /// the bound may have changed too.
    Moved,
    /// The text of the rung and its place among the rungs are the same, but the part of the bound that the rung takes
    /// changed.
    Same,
}

impl ChangeKind {
    /// The name of the change in reports.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            ChangeKind::Changed => "changed",
            ChangeKind::Added => "added",
            ChangeKind::Removed => "removed",
            ChangeKind::Moved => "moved",
            ChangeKind::Same => "same",
        }
    }
}

/// A rung that differs between the versions, as it is in each of them.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Change {
    /// How the rung changed.
    pub kind: ChangeKind,
    /// The rung in the old version. `None` if it was added.
    pub old: Option<Side>,
    /// The rung in the new version. `None` if it was removed.
    pub new: Option<Side>,
}

impl Change {
    /// The rung's part of the new bound minus its part of the old one, in picoseconds. A rung that does not exist
    /// counts as 0.
    #[must_use]
    pub fn delta(&self) -> i128 {
        let time = |side: &Option<Side>| side.as_ref().map_or(0, |side| i128::from(side.time.0));
        time(&self.new) - time(&self.old)
    }
}

/// The differences between the audits of two versions of a project.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Difference {
    /// The files of the old version.
    pub old_files: Vec<String>,
    /// The files of the new version.
    pub new_files: Vec<String>,
    /// The upper bound of the old version.
    pub old: Picos,
    /// The upper bound of the new version.
    pub new: Picos,
    /// The rungs whose text, place or time changed: first edited and moved rungs, then rungs of which only the time
    /// changed, last rungs with the same time. In each of the three, the largest change of time comes first.
    pub changes: Vec<Change>,
    /// The number of rungs whose text, place among the other rungs, and time did not change.
    pub unchanged: usize,
    /// The change of the bound that belongs to no rung, in picoseconds: of overhead, of what the search left open, and
    /// of the table's factor.
    pub besides: i128,
    /// Whether one of the two bounds may be too low, because something is not stated or a loop may never end.
    pub is_doubtful: bool,
    /// Whether a scan of the new version can reach a loop for which no end is known. The new bound is only valid for
    /// scans that end.
    pub is_endless: bool,
    /// The permitted growth of the bound in millionths of the old one, if there is such a condition.
    pub allowed: Option<u32>,
}

impl Difference {
    /// Compares two audits. `allowed` is the permitted growth of the bound in millionths, if there is such a condition.
    #[must_use]
    pub fn of(old: &Audit, new: &Audit, allowed: Option<u32>) -> Difference {
        let (before, after) = (rungs(old), rungs(new));
        let mut matched = Matched::default();
        for (old, new) in pairs(&before, &after) {
            matched.add(old, new);
        }
        let (changes, unchanged) = matched.finish();
        let total: i128 = changes.iter().map(Change::delta).sum();
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
            besides: whole - total,
            is_doubtful: doubtful(old) || doubtful(new),
            is_endless: !new.unbounded.is_empty(),
            allowed,
        }
    }

    /// The new bound minus the old bound, in picoseconds.
    #[must_use]
    pub fn delta(&self) -> i128 {
        i128::from(self.new.0) - i128::from(self.old.0)
    }

    /// The change of the bound in thousandths of the old bound, rounded to the nearest, halves away from zero. Negative
    /// if the bound fell.
    #[must_use]
    pub fn thousandths(&self) -> i128 {
        let (delta, old) = (self.delta(), i128::from(self.old.0).max(1));
        (delta.abs() * 2000 + old) / (old * 2) * delta.signum()
    }

    /// Whether the bound grew by more than `allowed`. Also true if a scan of the new version may never end. Always
    /// false if `allowed` is `None`.
    #[must_use]
    pub fn is_above(&self) -> bool {
        let above =
            |allowed| self.delta() * 1_000_000 > i128::from(self.old.0) * i128::from(allowed);
        self.allowed.is_some_and(|allowed| self.is_endless || above(allowed))
    }
}

/// The rungs with a time of each file, in the order of the file, by the file's short name.
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

/// The rungs of files that are versions of each other: files of the same short name, or the only file of each version.
/// A file without a counterpart is paired with an empty list.
fn pairs<'a>(old: &'a Rungs, new: &'a Rungs) -> Vec<(&'a [Side], &'a [Side])> {
    if let (1, 1) = (old.len(), new.len()) {
        return old.values().zip(new.values()).map(|(a, b)| (&a[..], &b[..])).collect();
    }
    let names: BTreeSet<&String> = old.keys().chain(new.keys()).collect();
    let of = |rungs: &'a Rungs, name: &String| rungs.get(name).map_or(&[][..], Vec::as_slice);
    names.into_iter().map(|name| (of(old, name), of(new, name))).collect()
}

/// A rung that is not matched yet, and the number of the section of differing rungs in which it is (`stretch`).
struct Loose {
    stretch: usize,
    side: Side,
}

/// The largest number of new rungs in a section that are compared with one old rung. Further ones are not considered.
const MAX_COMPARED: usize = 64;

/// The changes found so far, and the rungs of both versions that are not matched yet.
#[derive(Default)]
struct Matched {
    changes: Vec<Change>,
    unchanged: usize,
    stretches: usize,
    removed: Vec<Loose>,
    added: Vec<Loose>,
}

impl Matched {
    /// Matches the rungs of one file that have the same text in the same order. The others become `removed` and
    /// `added`.
    fn add(&mut self, old: &[Side], new: &[Side]) {
        let texts =
            |sides: &[Side]| -> Vec<String> { sides.iter().map(|one| one.text.clone()).collect() };
        for op in capture_diff_slices(Algorithm::Patience, &texts(old), &texts(new)) {
            let (old, new) = (&old[op.old_range()], &new[op.new_range()]);
            if let DiffOp::Equal { .. } = op {
                for (old, new) in old.iter().zip(new) {
                    match old.time == new.time {
                        true => self.unchanged += 1,
                        false => self.match_rungs(ChangeKind::Same, old.clone(), new.clone()),
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

    fn match_rungs(&mut self, kind: ChangeKind, old: Side, new: Side) {
        self.changes.push(Change { kind, old: Some(old), new: Some(new) });
    }

    fn finish(mut self) -> (Vec<Change>, usize) {
        // A rung with the same text elsewhere was moved. The others are new, unless they resemble what was at their
        // place.
        let mut same: BTreeMap<String, Vec<Loose>> = BTreeMap::new();
        for loose in std::mem::take(&mut self.added).into_iter().rev() {
            same.entry(loose.side.text.clone()).or_default().push(loose);
        }
        let mut gone = Vec::new();
        for old in std::mem::take(&mut self.removed) {
            match same.get_mut(&old.side.text).and_then(Vec::pop) {
                Some(new) => self.match_rungs(ChangeKind::Moved, old.side, new.side),
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
                    self.match_rungs(ChangeKind::Changed, old.side, new);
                }
                None => {
                    let change =
                        Change { kind: ChangeKind::Removed, old: Some(old.side), new: None };
                    self.changes.push(change);
                }
            }
        }
        let added = fresh.into_values().flatten();
        self.changes.extend(added.map(|new| Change {
            kind: ChangeKind::Added,
            old: None,
            new: Some(new),
        }));
        // Edited rungs come first. Other rungs may differ only because the longest scan takes another of two equally
        // long paths.
        self.changes.sort_by_cached_key(|one| {
            let side = one.new.as_ref().or(one.old.as_ref());
            let group = match one.kind {
                _ if one.delta() == 0 => 2,
                ChangeKind::Same => 1,
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

/// The index of the rung in `fresh` that resembles the old rung most, of the first [`MAX_COMPARED`]. `None` if none of
/// them shares at least half of its instructions with the old rung (half of the average length of both rungs).
fn nearest(old: &Side, fresh: &[Side]) -> Option<usize> {
    let own: Vec<&str> = old.text.split(" / ").collect();
    let alike = fresh.iter().take(MAX_COMPARED).enumerate().filter_map(|(index, new)| {
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
        let found: Vec<(&str, i128)> =
            changes.iter().map(|one| (one.kind.name(), one.delta())).collect();
        assert_eq!(
            found,
            [("added", 90), ("removed", -70), ("changed", 10), ("same", 1), ("moved", 0)]
        );
    }
}
