//! Writes statements on which a bound rests besides its groups as SMT-LIB files, so that other solvers can prove them:
//! what every scan preserves, and limits of counts and indices.

use super::pipeline::Concluded;
use scanbound_ir::{BitTarget, Cell, ExclusiveBits, Program};
use scanbound_model::Group;
use scanbound_scan::size_limits::SizeLimits;
use scanbound_scan::violations::{Violation, scan_model_of_violations};
use scanbound_solve::{Limits, export, unreachable_charges};
use std::collections::BTreeSet;
use std::time::{Duration, Instant};

/// The files about scans are not written if the model has more circuit nodes than this.
const NODES: usize = 2_000_000;
/// The files about scans are not written if one execution of an instruction adds more circuit nodes than this to the
/// model.
const NODES_EACH: usize = 1 << 15;
/// The longest time to build the model and to prove the statements. What is not proved by then is in no file.
const LONGEST: Duration = Duration::from_secs(60);

/// The name of the file about the state at power-up.
const POWER_UP: &str = "invariants-power-up.smt2";
/// The name of the file about what every scan preserves.
const KEPT: &str = "invariants-kept.smt2";
/// The name of the file about limits of counts and indices.
const COUNTS: &str = "counts.smt2";

/// The files for other solvers, and the lines of the index that say what each file proves.
pub(super) struct Invariants {
    /// Each file's name and text.
    pub files: Vec<(&'static str, String)>,
    /// The lines of the index file that belong to the files.
    pub index: Vec<String>,
}

/// The files with which a solver can prove the invariants, counts and indices that the bound uses, as far as the scan's
/// formula is exact and small enough; the index lists the others. Empty if there are none, or if the bound is only the
/// structural one.
pub(super) fn invariants(concluded: &Concluded) -> Invariants {
    let program = &concluded.followed.program;
    let given = given(program);
    let nothing = given.is_empty()
        && program.limited_counts.is_empty()
        && program.indexed.values().all(|one| one.proved.is_empty());
    let (mut files, mut index) = (Vec::new(), Vec::new());
    if concluded.followed.is_structural_only() || nothing {
        return Invariants { files, index };
    }
    if !given.is_empty() {
        files.push((POWER_UP, power_up(program)));
        index
            .push(format!("{POWER_UP}: expected answer unsat. These statements hold at power-up:"));
        index.extend(given.iter().map(|one| format!("  {one}")));
    }
    let end = Instant::now() + LONGEST;
    let is_over = || Instant::now() >= end;
    let size = SizeLimits { per_execution: NODES_EACH, in_all: NODES, is_over: &is_over };
    let times = concluded.followed.prices.times();
    let Ok((model, violations)) = scan_model_of_violations(program, &times, &size) else {
        index.push("The scan is too large to write these statements as files:".to_owned());
        index.extend(given.iter().map(|one| format!("  not shown: {one}")));
        return Invariants { files, index };
    };
    let group = |charges: Vec<usize>| Group {
        charges,
        variables: Vec::new(),
        constraints: (0..model.constraints.len()).collect(),
    };
    let limits = Limits { deadline: Some(end), ..Limits::default() };
    let shown = unreachable_charges(&model, &group((0..violations.len()).collect()), &limits);
    let describe = |at: usize| statement_of(program, &violations[at]);
    let (kept, counted): (Vec<usize>, Vec<usize>) = (0..violations.len())
        .partition(|&at| matches!(violations[at], Violation::Word(_) | Violation::All(_)));
    let mut left = Vec::new();
    let mut file = |name: &'static str, asked: Vec<usize>, asks: &str, says: &str| {
        let (shown, open): (Vec<usize>, Vec<usize>) =
            asked.into_iter().partition(|at| shown.contains(at));
        if !shown.is_empty() {
            let mut head = vec![
                asks.to_owned(),
                "unsat: no scan can. Assumed at the start of the scan:".to_owned(),
            ];
            head.extend(given.iter().map(|one| format!("  {one}")));
            head.extend(stated_facts(program));
            let text = export::never(&model, &group(shown.clone()), &head, &describe);
            files.push((name, text));
            index.push(format!("{name}: expected answer unsat. {says}"));
            index.extend(shown.into_iter().map(|at| format!("  {}", describe(at))));
        }
        left.extend(open.into_iter().map(|at| format!("  {}", describe(at))));
    };
    file(
        KEPT,
        kept,
        "If the assumptions below hold when a scan starts, can the scan violate any of these statements?",
        "If all of these statements are true when a scan starts, all are true when it ends:",
    );
    file(
        COUNTS,
        counted,
        "If the assumptions below hold when a scan starts, can a number of iterations or units, or an index, exceed its limit in the scan?",
        "No number of iterations or units, and no index, exceeds the limit that the bound uses:",
    );
    if !left.is_empty() {
        let why = "the formula of the scan is approximated or too large";
        index.push(format!(
            "No file for these statements: {why} (docs/values.md says how they were found):"
        ));
        index.append(&mut left);
    }
    Invariants { files, index }
}

/// The statements that the bound assumes whenever a scan starts, as sentences: ranges of words, relays that are not on
/// together, and relays that are off in the first scan.
fn given(program: &Program) -> Vec<String> {
    let words = (0..program.trusted_ranges.len())
        .map(|place| statement_of(program, &Violation::Word(place)));
    let sets = sets(program).map(|bits| statement_of(program, &Violation::All(bits)));
    let cleared = cleared(program).map(|bits| statement_of_cleared(program, bits));
    words.chain(sets).chain(cleared).collect()
}

/// The sets of relays that are off in a scan before which memory was cleared.
fn cleared(program: &Program) -> impl Iterator<Item = &[BitTarget]> {
    program.mutually_exclusive.iter().filter(|one| one.max_on == 0).map(|one| &one.bits[..])
}

fn statement_of_cleared(program: &Program, bits: &[BitTarget]) -> String {
    let names: Vec<String> = bits.iter().map(|&bit| program.bit_name(bit)).collect();
    let are = if names.len() == 1 { "is" } else { "are" };
    let names = names.join(", ");
    format!("{names} {are} off when the first scan starts, because memory was cleared before it")
}

/// The ranges of words that the user states for the start of a scan, as sentences, except for words whose range was
/// also derived.
fn stated_facts(program: &Program) -> Vec<String> {
    let trusted: BTreeSet<Cell> = program.trusted_ranges.iter().map(|one| one.cell).collect();
    let by_user = program
        .stated_ranges
        .iter()
        .filter(|one| !one.cells.iter().any(|cell| trusted.contains(cell)));
    by_user
        .map(|one| {
            let cells: Vec<String> =
                one.cells.iter().map(|&cell| program.cell_name(cell)).collect();
            format!("  {} is {} to {}, as stated", cells.join(" with "), one.low, one.high)
        })
        .collect()
}

/// The sets of relays that are never all on when a scan starts.
fn sets(program: &Program) -> impl Iterator<Item = Vec<BitTarget>> + '_ {
    program.mutually_exclusive.iter().flat_map(ExclusiveBits::forbidden_sets)
}

/// The statement that is true if this violation never occurs, as a sentence.
fn statement_of(program: &Program, violation: &Violation) -> String {
    let place = |at: usize| {
        let instruction = &program.instructions[at];
        let file = &instruction.place.of(&program.files).name;
        format!("{file}:{} {}", instruction.place.line, instruction.text)
    };
    match *violation {
        Violation::Word(at) => {
            let word = &program.trusted_ranges[at];
            format!("{} is {}", program.cell_name(word.cell), word.text())
        }
        Violation::All(ref bits) => {
            let names: Vec<String> = bits.iter().map(|&bit| program.bit_name(bit)).collect();
            match &names[..] {
                [a, b] => format!("{a} and {b} are not both on"),
                _ => format!("{} are not all on", names.join(", ")),
            }
        }
        Violation::Count(at) => format!(
            "the number of iterations or units of {} is at most the limit that the bound uses",
            place(at)
        ),
        Violation::Reach(at) => {
            format!("{} writes only cells that the bound takes into account", place(at))
        }
    }
}

/// The text of the file that asks whether the state at power-up, with cleared memory and initial values, violates a
/// range of a word or has relays on that exclude each other.
fn power_up(program: &Program) -> String {
    let mut text = String::from(
        "; Does memory that is cleared at power-up or reset violate any of this?\n\
         ; unsat: it does not. (A latched word keeps the value that a scan wrote into it: the other file covers every\n\
         ; write, not only of the last one.)\n\
         (set-logic QF_BV)\n",
    );
    let mut asked = String::new();
    for (place, one) in program.trusted_ranges.iter().enumerate() {
        let name = program.cell_name(one.cell);
        text += &format!(
            "(declare-const w{place} (_ BitVec 16)) ; {name}\n(assert (= w{place} #x{:04X}))\n",
            program.power_up.initial_value(one.cell)
        );
        let [low, high] = [one.low, one.high].map(|end| end as u16);
        let is_one = one.values.iter().map(|value| format!(" (= w{place} #x{value:04X})"));
        let within = match one.values.is_empty() {
            true => format!("(and (bvsle #x{low:04X} w{place}) (bvsle w{place} #x{high:04X}))"),
            false => format!("(or{})", is_one.collect::<String>()),
        };
        asked +=
            &format!("  (not {within}) ; {}\n", statement_of(program, &Violation::Word(place)));
    }
    let mut relays: BTreeSet<BitTarget> = BTreeSet::new();
    let name = |bit: BitTarget| match bit {
        BitTarget::Cell(cell) => format!("r{}x{}", cell.area.0, cell.index),
        BitTarget::WordBit(cell, bit) => format!("r{}x{}x{bit}", cell.area.0, cell.index),
    };
    for bits in sets(program) {
        let own: Vec<String> = bits.iter().map(|&bit| name(bit)).collect();
        relays.extend(&bits);
        asked += &format!(
            "  (and {}) ; {}\n",
            own.join(" "),
            statement_of(program, &Violation::All(bits))
        );
    }
    for bits in cleared(program) {
        let own: Vec<String> = bits.iter().map(|&bit| name(bit)).collect();
        relays.extend(bits);
        let says = statement_of_cleared(program, bits);
        asked += &format!("  (or {}) ; {says}\n", own.join(" "));
    }
    for bit in relays {
        let (own, called) = (name(bit), program.bit_name(bit));
        let (cell, place) = match bit {
            BitTarget::Cell(cell) => (cell, 0),
            BitTarget::WordBit(cell, place) => (cell, place),
        };
        let is_on = program.power_up.initial_value(cell) >> place & 1 == 1;
        text += &format!("(declare-const {own} Bool) ; {called}\n(assert (= {own} {is_on}))\n");
    }
    format!("{text}(assert (or false\n{asked}))\n(check-sat)\n")
}
