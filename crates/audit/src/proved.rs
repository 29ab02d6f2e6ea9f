//! Whether scans preserve the facts that are stated for the start of a scan: proved with the scan's model, or disproved
//! by real runs.

use super::exclusive_relays::ExclusiveRelays;
use super::real::{RunResults, RunSearch, standing, summary_choices};
use super::stated::bit;
use scanbound_base::facts::{Facts, normalized};
use scanbound_base::time::{Picos, Times};
use scanbound_ir::meaning::Knowledge;
use scanbound_ir::{BitSource, BitTarget, Program, StartRange};
use scanbound_model::groups::witness;
use scanbound_model::lower_bound::lower_bound_model;
use scanbound_model::{Charge, Group, Lit, ScanModel};
use scanbound_passes::values::{Trust, has_no_other_writer, is_unwritten_elsewhere};
use scanbound_replay::run::{Outside, OutsideValues, Run};
use scanbound_scan::Purpose;
use scanbound_scan::size_limits::SizeLimits;
use scanbound_scan::violations::{Candidate, CandidateOutcome, scan_model_of_candidates};
use scanbound_solve::{Limits, unreachable_charges};
use std::collections::{BTreeMap, BTreeSet};
use std::time::{Duration, Instant};

/// The check is skipped for models with more circuit nodes than this.
const NODES: usize = 2_000_000;
/// The check is skipped if one execution of an instruction adds more circuit nodes than this to the model.
const NODES_EACH: usize = 1 << 15;
/// The check may take at most this time.
const LONGEST: Duration = Duration::from_secs(10);
/// The check may take at most 1/`PARTS` of the remaining time.
const PARTS: u32 = 8;
/// Only this many facts are checked: the first ones, ranges before exclusive sets.
const MAX_FACTS: usize = 100;
/// The number of rounds in which a scan that violates a fact is searched for. Each round uses what the runs before it
/// showed.
const ROUNDS: usize = 3;
/// The largest number of scans of the run from power-up in which the facts are observed.
const SCANS: usize = 100;
/// The largest number of instructions that this run executes in all its scans.
const MAX_INSTRUCTIONS: u64 = 400_000;

/// The stated facts that the program is proved to keep: they are true at the end of every scan that starts with them.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Proved {
    /// The ranges that are kept, by the words' keys in the facts file.
    pub ranges: BTreeSet<String>,
    /// The sets of exclusive bits that are kept, by their index in the facts file.
    pub exclusive: BTreeSet<usize>,
}

/// The stated fact that is checked.
enum StatedFact {
    /// A range: its index in `Program::stated_ranges`, and its key in the facts file.
    Range(usize, String),
    /// A set of exclusive bits: its index in the facts file, and the indices of its pairs in `Program::invariants`.
    Set(usize, Vec<usize>),
}

/// A stated fact, and the statement about the start of a scan that it makes.
struct FactCheck {
    of: StatedFact,
    stays: Candidate,
}

impl FactCheck {
    /// Whether a real run was found that violates the fact.
    fn is_broken(&self, found: &RunResults) -> bool {
        match &self.of {
            StatedFact::Range(at, _) => found.violations.ranges.contains_key(at),
            StatedFact::Set(_, pairs) => {
                pairs.iter().any(|pair| found.violations.exclusions.contains_key(pair))
            }
        }
    }
}

/// The stated facts that the program is proved to keep. Real runs that violate others are recorded in `found`.
/// `is_whole`: the model is only the structural bound, so nothing can be proved with it.
///
/// # Errors
/// If the analysis and the interpreter disagree.
pub fn proved(
    search: &RunSearch<'_>,
    facts: &Facts,
    is_whole: bool,
    found: &mut RunResults,
) -> Result<Proved, String> {
    let program = search.program;
    let mut proved = Proved::default();
    if facts.ranges.is_empty() && facts.exclusive.is_empty() {
        return Ok(proved);
    }
    let mut asked = fact_checks(program, facts);
    if !facts.download {
        // Facts that the abstract interpretation has proved need not be checked again.
        asked.retain(|one| match (&one.of, &one.stays) {
            (StatedFact::Range(_, key), Candidate::Within(cells, ..))
                if cells.len() == 1 && program.proved_ranges.contains(&cells[0]) =>
            {
                proved.ranges.insert(key.clone());
                false
            }
            _ => true,
        });
    }
    asked.truncate(MAX_FACTS);
    if asked.is_empty() || search.limits.reached() {
        return Ok(proved);
    }
    let now = Instant::now();
    let left = search.limits.deadline.map(|end| end.saturating_duration_since(now) / PARTS);
    let deadline = Some(now + left.unwrap_or(LONGEST).min(LONGEST));
    let limits = Limits { deadline, ..search.limits };
    let search = RunSearch { program, least: search.least, limits };
    run_unseen(&search, found);
    if is_whole {
        return Ok(proved);
    }
    let open: Vec<usize> = (0..asked.len()).filter(|&at| !asked[at].is_broken(found)).collect();
    // If no scan can start as stated, every fact would count as proved.
    let is_provable = !facts.download && found.best.is_possible();
    let kept = if is_provable { provably_kept(&search, &asked, &open) } else { BTreeSet::new() };
    seek(&search, &asked, found)?;
    for at in kept {
        if asked[at].is_broken(found) {
            return Err("a simulated scan violates a fact, although the analysis proved that no scan violates it".to_owned());
        }
        match &asked[at].of {
            StatedFact::Range(_, key) => _ = proved.ranges.insert(key.clone()),
            StatedFact::Set(at, _) => _ = proved.exclusive.insert(*at),
        }
    }
    Ok(proved)
}

/// The stated ranges and exclusive sets whose words and bits the program has, each as a candidate that can be checked.
fn fact_checks(program: &Program, facts: &Facts) -> Vec<FactCheck> {
    let keys: BTreeMap<String, &String> =
        facts.ranges.keys().map(|key| (normalized(key), key)).collect();
    // In this list, trusted ranges follow the stated ones.
    let stated = program.stated_ranges.len() - program.trusted_ranges.len();
    let range = |(at, range): (usize, &StartRange)| {
        let key = keys.get(&normalized(&program.cell_name(range.cells[0])))?;
        // A word may be stated by two names.
        facts.ranges.get(*key).filter(|stated| **stated == (range.low, range.high))?;
        let stays = Candidate::Within(range.cells.clone(), range.low, range.high);
        Some(FactCheck { of: StatedFact::Range(at, (*key).clone()), stays })
    };
    let mut pairs = program.stated_exclusions.clone();
    let set = |(at, names): (usize, &Vec<String>)| {
        let count = names.len() * names.len().saturating_sub(1) / 2;
        let own: Vec<usize> = pairs.by_ref().take(count).collect();
        let target = |name: &String| match bit(program, name)? {
            BitSource::Cell(cell) => Some(BitTarget::Cell(cell)),
            BitSource::WordBit(cell, bit) => Some(BitTarget::WordBit(cell, bit)),
            BitSource::Const(_) | BitSource::Free(_) => None,
        };
        let bits: Option<Vec<BitTarget>> = names.iter().map(target).collect();
        Some(FactCheck { of: StatedFact::Set(at, own), stays: Candidate::Exclusive(bits?) })
    };
    let ranges: Vec<FactCheck> =
        program.stated_ranges[..stated].iter().enumerate().filter_map(range).collect();
    let sets: Vec<FactCheck> = facts.exclusive.iter().enumerate().filter_map(set).collect();
    ranges.into_iter().chain(sets).collect()
}

/// Simulates scans from power-up with all values from outside unknown. A violation found in this way occurs whatever
/// these values are.
fn run_unseen(search: &RunSearch<'_>, found: &mut RunResults) {
    let outside = Outside::with_unknown_values(search.program);
    let mut run = Run::new(&outside, search.least, Picos::ZERO);
    let (choices, mut executed) = (BTreeMap::new(), 0);
    for number in 1..=SCANS {
        let given = OutsideValues { inputs: BTreeMap::new(), choices: &choices, seed: None };
        let scan = run.scan(&given, MAX_INSTRUCTIONS - executed);
        executed += scan.replay.events.len() as u64;
        found.violations.note(search.program, &scan, Some(number));
        // The scans after a violation start in a state that contradicts the facts.
        let goes_on = scan.is_possible() && scan.stopped.is_none() && executed < MAX_INSTRUCTIONS;
        if !goes_on
            || !scan.range_violations.is_empty()
            || !scan.exclusion_violations.is_empty()
            || search.limits.reached()
        {
            break;
        }
    }
}

/// Those of the `open` facts (indices into `asked`) that are true at the end of every scan that starts with all facts
/// true. Only facts are checked whose cells only the program writes and that are true for cleared memory; not ranges of
/// two words as one number. A fact does not count as proved if no scan changes one of its words or bits: then something
/// else must write it.
fn provably_kept(search: &RunSearch<'_>, asked: &[FactCheck], open: &[usize]) -> BTreeSet<usize> {
    let program = search.program;
    let exclusive = ExclusiveRelays::of(program, Trust::All);
    let is_own = |at: &&usize| match &asked[**at].stays {
        Candidate::Within(cells, low, high) => match cells[..] {
            // The check does not follow numbers of two words through the scan.
            [cell] => {
                let is_output = exclusive.is_output(cell) && is_unwritten_elsewhere(program, cell);
                let first = program.power_up.initial_value(cell).cast_signed();
                (has_no_other_writer(program, cell) || is_output)
                    && (*low..=*high).contains(&first.into())
            }
            _ => false,
        },
        Candidate::Exclusive(bits) => {
            bits.iter().all(|&bit| exclusive.start_unknown(bit).is_none())
        }
    };
    let own: Vec<usize> = open.iter().filter(is_own).copied().collect();
    if own.is_empty() {
        return BTreeSet::new();
    }
    let stays: Vec<Candidate> = own.iter().map(|&at| asked[at].stays.clone()).collect();
    let Some((mut model, found)) = model(search, &Knowledge::new(), Purpose::UpperBound, &stays)
    else {
        return BTreeSet::new();
    };
    // For each fact, the condition under which the scan violates it. Each of its bits or words must be written: if the
    // program only clears it, others set it.
    let mut places: Vec<(usize, Vec<usize>)> = Vec::new();
    for CandidateOutcome { violated: breaks, changed: moves, .. } in found {
        let first = model.charges.len();
        model.charges.extend([breaks].into_iter().chain(moves).map(charge));
        places.push((first, (first + 1..model.charges.len()).collect()));
    }
    let group = Group {
        charges: (0..model.charges.len()).collect(),
        variables: Vec::new(),
        constraints: (0..model.constraints.len()).collect(),
    };
    let never = unreachable_charges(&model, &group, &search.limits);
    let holds = |(breaks, moves): &(usize, Vec<usize>)| {
        never.contains(breaks) && !moves.iter().any(|one| never.contains(one))
    };
    own.into_iter().zip(&places).filter(|(_, places)| holds(places)).map(|(at, _)| at).collect()
}

/// Searches for real runs that violate facts which no run has violated so far, and records them in `found`. `Err` if
/// the analysis and the interpreter disagree.
fn seek(search: &RunSearch<'_>, asked: &[FactCheck], found: &mut RunResults) -> Result<(), String> {
    let program = search.program;
    let stays: Vec<Candidate> = asked.iter().map(|one| one.stays.clone()).collect();
    let summary = summary_choices(program);
    for _ in 0..ROUNDS {
        let is_open = |at: &usize| !asked[*at].is_broken(found);
        let open: Vec<usize> = (0..asked.len()).filter(is_open).collect();
        if open.is_empty() || search.limits.reached() {
            break;
        }
        let Some((mut full, ends)) = model(search, &found.knowledge, Purpose::LowerBound, &stays)
        else {
            break;
        };
        full.charges = ends.iter().map(|one| charge(one.violated_at_end)).collect();
        let mut sure = lower_bound_model(
            &full,
            &|variable| standing(program, &summary, &full, variable),
            false,
        );
        let charges = std::mem::take(&mut sure.charges);
        let mut news = false;
        for at in open {
            if charges[at].reached == Lit::FALSE || search.limits.reached() {
                continue;
            }
            sure.charges = vec![charges[at].clone()];
            let Some((assignment, _)) = search.longest(&sure) else { continue };
            let mut one = search.real(&witness(&sure, &assignment))?;
            news |= found.note(program, &mut one);
        }
        if !news {
            break;
        }
    }
    Ok(())
}

fn model(
    search: &RunSearch<'_>,
    knowledge: &Knowledge,
    purpose: Purpose,
    stays: &[Candidate],
) -> Option<(ScanModel, Vec<CandidateOutcome>)> {
    let is_over = || search.limits.reached();
    let limits = SizeLimits { per_execution: NODES_EACH, in_all: NODES, is_over: &is_over };
    let times: &[Times] = search.least;
    scan_model_of_candidates(search.program, times, (knowledge, purpose), &limits, stays).ok()
}

/// A charge of one picosecond that occurs if `holds` is true.
fn charge(holds: Lit) -> Charge {
    Charge {
        instruction: 0,
        frames: Vec::new(),
        reached: holds,
        fires: holds,
        on: Picos(1),
        off: Picos(1),
        counted: None,
    }
}
