//! How the mutual exclusion of a net's boxes lowers the bound. Sets of relays that the net never marks together are
//! checked on the code, and those that every scan preserves are used.

use super::failure::Failure;
use super::hints::Hints;
use super::own::{NotOwn, Owners};
use super::pipeline::{Concluded, audit};
use super::reachable::Relays;
use super::request::{Progress, Request};
use super::{Audit, Value};
use scanbound_base::time::Picos;
use scanbound_ir::{BitTarget, Program};
use std::collections::{BTreeMap, BTreeSet};
use std::fmt;

/// How a net changes the bound of its code.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct NetBound {
    /// The net's file.
    pub net: String,
    /// The bound if relays could be on in any combination when a scan starts.
    pub without: Picos,
    /// The bound without the net: combinations are excluded only if the audit finds that itself.
    pub alone: Picos,
    /// Sets that the net states and the code preserves.
    pub kept: Vec<Set>,
    /// Sets that the net states and that are not used.
    pub dropped: Vec<Dropped>,
    /// For each place of the net: whether it is marked when the longest scan starts, if that scan depends on it. A
    /// counter counts as marked once it has counted.
    pub places: Vec<Option<bool>>,
    /// The names of the marked places.
    pub marked: Vec<String>,
}

/// Elements of a net, with their relays, that are never all on.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Set {
    /// Their names.
    pub elements: Vec<String>,
    /// Their relays.
    pub relays: Vec<String>,
    /// Whether all of them are boxes, timers or counters, and none a transition.
    pub is_of_places: bool,
    /// The largest number of them that can be on at once: one, or all but one.
    pub most: usize,
}

/// A set that the net states and that is not used.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Dropped {
    /// Elements that are never all on, according to the net.
    pub set: Set,
    /// Why the set is not used.
    pub why: Why,
}

/// Why a set that the net states is not used.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub enum Why {
    /// The CPU has no such relay, or the element has no address.
    NoRelay(String),
    /// The value of this element's relay at the start of a scan is unknown.
    NotOwn(String, NotOwn),
    /// The program never turns on this element's relay, so others may do so at any time.
    NeverOn(String),
    /// No scan depends on the start value of this element's relay.
    NotRead(String),
    /// A scan of the code violates it.
    Broken,
    /// The time was over.
    NoTime,
}

impl Why {
    /// The element because of which the set is not used, if it is only one.
    #[must_use]
    pub fn element(&self) -> Option<&str> {
        match self {
            Why::NoRelay(name) | Why::NotOwn(name, _) | Why::NeverOn(name) | Why::NotRead(name) => {
                Some(name)
            }
            Why::Broken | Why::NoTime => None,
        }
    }

    /// The reason, without the name of the element.
    #[must_use]
    pub fn reason(&self) -> String {
        match self {
            Why::NoRelay(_) => "it has no relay in this code".to_owned(),
            Why::NotOwn(_, why) => why.to_string(),
            Why::NeverOn(_) => "the code never turns it on, so others may do so at any time (the code sets initial marks only if it is translated with --initial first-scan)".to_owned(),
            Why::NotRead(_) => "no scan depends on its value from the scan before".to_owned(),
            Why::Broken => "a scan of the code can turn them all on".to_owned(),
            Why::NoTime => "not decided within the time limit".to_owned(),
        }
    }
}

impl fmt::Display for Why {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(name) = self.element() {
            write!(f, "{name}: ")?;
        }
        f.write_str(&self.reason())
    }
}

/// Sorts a net's sets into used and unused ones.
struct Judge<'a> {
    hints: &'a Hints<'a>,
    program: &'a Program,
    owners: Owners<'a>,
    found: &'a Relays,
}

impl Judge<'_> {
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

    /// Why a set is not used.
    fn why(&self, elements: &[usize]) -> Why {
        let name = |one: usize| self.hints.name(one);
        let Some(bits) = self.hints.bits_of(elements) else {
            let lacks = |one: &&usize| self.hints.bit(**one).is_none();
            return Why::NoRelay(
                elements.iter().find(lacks).map_or(String::new(), |&one| name(one)),
            );
        };
        let all = || elements.iter().copied().zip(bits.iter().copied());
        let refused = all().find_map(|(one, bit)| Some((one, self.owners.refuses(bit)?)));
        if let Some((one, why)) = refused {
            return Why::NotOwn(name(one), why);
        }
        if let Some((one, _)) = all().find(|(_, bit)| !self.found.known.contains(bit)) {
            return Why::NotRead(name(one));
        }
        if let Some((one, _)) = all().find(|(_, bit)| self.found.freed.contains(bit)) {
            return Why::NeverOn(name(one));
        }
        if self.found.decided { Why::Broken } else { Why::NoTime }
    }

    /// The sets that the code preserves, and the others with the reason.
    fn judged(&self) -> (Vec<Set>, Vec<Dropped>) {
        let proved: BTreeSet<&Vec<BitTarget>> = self.found.apart.iter().collect();
        let is_proved = |elements: &&Vec<usize>| {
            self.hints.bits_of(elements).is_some_and(|mut bits| {
                bits.sort_unstable();
                proved.contains(&bits)
            })
        };
        let (kept, dropped): (Vec<_>, Vec<_>) = self.hints.sets().iter().partition(is_proved);
        let is_of_places = |set: &&Vec<usize>| set.iter().all(|&one| self.hints.is_place(one));
        let (places, others): (Vec<_>, Vec<_>) = kept.into_iter().partition(is_of_places);
        let sets = [together(&places), together(&others)].concat();
        let dropped = dropped.into_iter().map(|elements| Dropped {
            set: self.set(elements, elements.len() - 1),
            why: self.why(elements),
        });
        let dropped = dropped.collect();
        (sets.iter().map(|(elements, most)| self.set(elements, *most)).collect(), dropped)
    }
}

/// Combines pairs into sets of mutually exclusive elements, so that each pair is in at least one set.
fn together(sets: &[&Vec<usize>]) -> Vec<(Vec<usize>, usize)> {
    let pairs: BTreeSet<(usize, usize)> = sets
        .iter()
        .filter(|set| set.len() == 2)
        .map(|set| (set[0].min(set[1]), set[0].max(set[1])))
        .collect();
    let all: BTreeSet<usize> = pairs.iter().flat_map(|&(a, b)| [a, b]).collect();
    let is_apart = |a: usize, b: usize| pairs.contains(&(a.min(b), a.max(b)));
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
                if !group.contains(&next) && group.iter().all(|&one| is_apart(one, next)) {
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
    let owners = Owners::of(program, request.trusted());
    let found = concluded.followed.relays();
    let (kept, dropped) = Judge { hints: &hints, program, owners, found }.judged();
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
    concluded.audit.net = Some(NetBound { net, without, alone, kept, dropped, places, marked });
    Ok(())
}

/// For each place, whether it is marked when the longest scan starts.
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
