//! How the mutual exclusion of an S-net's elements (places and transitions) lowers the bound. Sets of relays that the
//! net never marks together are checked on the code, and those that every scan preserves are used.

use super::exclusive_relays::ExclusiveRelays;
use super::failure::Failure;
use super::hints::Hints;
use super::pipeline::{Concluded, audit};
use super::reachable::Relays;
use super::request::{Progress, Request};
use super::requested::NetBound;
pub use super::requested::{Set, UnusedSet, Why};
use super::{Audit, Value};
use scanbound_ir::{BitTarget, Program};
use std::collections::{BTreeMap, BTreeSet};

/// Sorts a net's sets of exclusive elements into those that the bound uses and those that it does not use.
struct SetSorter<'a> {
    hints: &'a Hints<'a>,
    program: &'a Program,
    exclusive: ExclusiveRelays<'a>,
    found: &'a Relays,
}

impl SetSorter<'_> {
    fn set(&self, elements: &[usize], most: usize) -> Set {
        let name = |bit| self.program.bit_name(bit);
        let relay = |one: &usize| self.hints.bit(*one).map_or(String::new(), name);
        Set {
            elements: elements.iter().map(|&one| self.hints.name(one)).collect(),
            relays: elements.iter().map(relay).collect(),
            is_of_places: elements.iter().all(|&one| self.hints.is_place(one)),
            most,
        }
    }

    /// Why a set of elements is not used: the first reason that applies, in the order of the checks.
    fn unused_because(&self, elements: &[usize]) -> Why {
        let name = |one: usize| self.hints.name(one);
        let Some(bits) = self.hints.bits_of(elements) else {
            let lacks = |one: &&usize| self.hints.bit(**one).is_none();
            return Why::NoRelay(
                elements.iter().find(lacks).map_or(String::new(), |&one| name(one)),
            );
        };
        let all = || elements.iter().copied().zip(bits.iter().copied());
        let refused = all().find_map(|(one, bit)| Some((one, self.exclusive.start_unknown(bit)?)));
        if let Some((one, why)) = refused {
            return Why::StartUnknown(name(one), why);
        }
        if let Some((one, _)) = all().find(|(_, bit)| !self.found.known.contains(bit)) {
            return Why::NotRead(name(one));
        }
        if let Some((one, _)) = all().find(|(_, bit)| self.found.freed.contains(bit)) {
            return Why::NeverOn(name(one));
        }
        if self.found.decided { Why::Broken } else { Why::NoTime }
    }

    /// The sets that the code preserves; and the other sets, each with the reason why it is not used.
    fn sorted(&self) -> (Vec<Set>, Vec<UnusedSet>) {
        let proved: BTreeSet<&Vec<BitTarget>> = self.found.exclusive.iter().collect();
        let is_proved = |elements: &&Vec<usize>| {
            self.hints.bits_of(elements).is_some_and(|mut bits| {
                bits.sort_unstable();
                proved.contains(&bits)
            })
        };
        let (used, unused): (Vec<_>, Vec<_>) = self.hints.sets().iter().partition(is_proved);
        let is_of_places = |set: &&Vec<usize>| set.iter().all(|&one| self.hints.is_place(one));
        let (places, others): (Vec<_>, Vec<_>) = used.into_iter().partition(is_of_places);
        let sets = [together(&places), together(&others)].concat();
        let unused = unused.into_iter().map(|elements| UnusedSet {
            set: self.set(elements, elements.len() - 1),
            why: self.unused_because(elements),
        });
        let unused = unused.collect();
        (sets.iter().map(|(elements, most)| self.set(elements, *most)).collect(), unused)
    }
}

/// Combines pairs into sets of mutually exclusive elements, so that each pair is in at least one set. Larger sets stay
/// as they are. Each result is a set and the largest number of its elements that can be on at once.
fn together(sets: &[&Vec<usize>]) -> Vec<(Vec<usize>, usize)> {
    let pairs: BTreeSet<(usize, usize)> = sets
        .iter()
        .filter(|set| set.len() == 2)
        .map(|set| (set[0].min(set[1]), set[0].max(set[1])))
        .collect();
    let all: BTreeSet<usize> = pairs.iter().flat_map(|&(a, b)| [a, b]).collect();
    let are_exclusive = |a: usize, b: usize| pairs.contains(&(a.min(b), a.max(b)));
    let order = Vec::from_iter(all);
    let mut left = pairs.clone();
    let mut groups = Vec::new();
    for (at, &a) in order.iter().enumerate() {
        for &b in &order[at + 1..] {
            if !left.contains(&(a.min(b), a.max(b))) {
                continue;
            }
            let mut group = vec![a, b];
            for &next in &order {
                if !group.contains(&next) && group.iter().all(|&one| are_exclusive(one, next)) {
                    group.push(next);
                }
            }
            left.retain(|(a, b)| !(group.contains(a) && group.contains(b)));
            group.sort_unstable();
            groups.push((group, 1));
        }
    }
    let larger = sets.iter().filter(|set| set.len() > 2);
    groups.extend(larger.map(|set| (set.to_vec(), set.len() - 1)));
    groups
}

/// Adds how a net changes the bound, from two more audits. Each may use the whole time limit. Nothing is added if no
/// net is given, if only a limit is to be decided, or if nothing bounds the scan.
///
/// # Errors
/// If the analysis and the interpreter disagree in these audits.
pub fn net_bound(concluded: &mut Concluded, request: &Request<'_>) -> Result<(), Failure> {
    let Some(net) = request.net else { return Ok(()) };
    if request.limit.is_some() || !concluded.audit.unbounded.is_empty() {
        return Ok(());
    }
    let program = &concluded.followed.program;
    let hints = Hints::of(net, program);
    let exclusive = ExclusiveRelays::of(program, request.trusted());
    let found = concluded.followed.relays();
    let (used, unused) = SetSorter { hints: &hints, program, exclusive, found }.sorted();
    let places = marked(&hints, program, &concluded.audit);
    let marked = hints.places().zip(&places).filter(|(_, marked)| **marked == Some(true));
    let marked = marked.map(|(element, _)| hints.name(element)).collect();
    let asked = Request { net: None, confirm: false, trace: false, response: None, ..*request };
    (request.progress)(Progress::Stage("solving without the net"));
    let alone = audit(&asked)?;
    (request.progress)(Progress::Stage("solving with relays on in any combination"));
    let without = audit(&Request { relays: false, ..asked })?;
    // If the time ran out, the bound with less information may be lower.
    let upper = concluded.audit.bound.upper;
    let alone = alone.bound.upper.max(upper);
    let without = without.bound.upper.max(alone);
    let net = net.file.clone();
    concluded.audit.net = Some(NetBound { net, without, alone, used, unused, places, marked });
    Ok(())
}

/// For each place of the net, whether it is marked when the longest scan starts. `None` if it has no relay, or the
/// start values of that scan do not include the relay.
fn marked(hints: &Hints<'_>, program: &Program, audit: &Audit) -> Vec<Option<bool>> {
    let values: BTreeMap<&str, Value> = audit
        .witness
        .iter()
        .filter(|one| one.at_start)
        .map(|one| (one.name.as_str(), one.value))
        .collect();
    let on = |place: usize| {
        let bit = hints.bit(place)?;
        let value = values.get(program.cell_name(bit.cell()).as_str())?;
        Some(match (*value, bit) {
            (Value::Word(word), BitTarget::WordBit(_, bit)) => word >> bit & 1 == 1,
            (Value::Bit(is_on), _) => is_on,
            (Value::Word(word), BitTarget::Cell(_)) => word != 0,
        })
    };
    hints.places().map(on).collect()
}
