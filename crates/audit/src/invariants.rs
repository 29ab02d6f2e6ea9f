//! What a bound rests on besides the model of its groups, as questions for other solvers: what scans keep, and how far
//! words count and indices reach.

use super::pipeline::Concluded;
use scanbound_ir::{Apart, BitTarget, Cell, Program};
use scanbound_model::Group;
use scanbound_scan::fit::SizeLimits;
use scanbound_scan::keeping::{Breach, scan_model_keeping};
use scanbound_solve::{Limits, export, impossible};
use std::collections::BTreeSet;
use std::time::{Duration, Instant};

/// No model larger than this is asked, ...
const NODES: usize = 2_000_000;
const NODES_EACH: usize = 1 << 15;
/// ... and not for longer than this.
const LONGEST: Duration = Duration::from_secs(60);

/// The names of the files.
const POWER_UP: &str = "invariants-power-up.smt2";
const KEPT: &str = "invariants-kept.smt2";
const COUNTS: &str = "counts.smt2";

/// The files, and lines of the index: which there are, and what is shown by which.
pub(super) struct Invariants {
    /// By name, with their text.
    pub files: Vec<(&'static str, String)>,
    /// The lines.
    pub index: Vec<String>,
}

/// What a program's bound rests on, as far as the scan's formula shows it.
pub(super) fn invariants(concluded: &Concluded) -> Invariants {
    let program = &concluded.followed.program;
    let given = given(program);
    let nothing = given.is_empty()
        && program.narrowed.is_empty()
        && program.indexed.values().all(|one| one.found.is_empty());
    let (mut files, mut index) = (Vec::new(), Vec::new());
    if concluded.followed.is_structural_only() || nothing {
        return Invariants { files, index };
    }
    if !given.is_empty() {
        files.push((POWER_UP, power_up(program)));
        index.push(format!("{POWER_UP}: unsat. What runs begin with is as scans keep it:"));
        index.extend(given.iter().map(|one| format!("  {one}")));
    }
    let end = Instant::now() + LONGEST;
    let is_over = || Instant::now() >= end;
    let size = SizeLimits { per_execution: NODES_EACH, in_all: NODES, is_over: &is_over };
    let times = concluded.followed.prices.times();
    let Ok((model, breaches)) = scan_model_keeping(program, &times, &size) else {
        index.push("The scan takes too much to ask of it what the bound rests on:".to_owned());
        index.extend(given.iter().map(|one| format!("  not shown: {one}")));
        return Invariants { files, index };
    };
    let group = |charges: Vec<usize>| Group {
        charges,
        variables: Vec::new(),
        constraints: (0..model.constraints.len()).collect(),
    };
    let limits = Limits { deadline: Some(end), ..Limits::default() };
    let shown = impossible(&model, &group((0..breaches.len()).collect()), &limits);
    let told = |at: usize| tell(program, &breaches[at]);
    let (kept, counted): (Vec<usize>, Vec<usize>) = (0..breaches.len())
        .partition(|&at| matches!(breaches[at], Breach::Word(_) | Breach::All(_)));
    let mut left = Vec::new();
    let mut file = |name: &'static str, asked: Vec<usize>, asks: &str, says: &str| {
        let (shown, open): (Vec<usize>, Vec<usize>) =
            asked.into_iter().partition(|at| shown.contains(at));
        if !shown.is_empty() {
            let mut head =
                vec![asks.to_owned(), "unsat: none can. What holds when it starts:".to_owned()];
            head.extend(given.iter().map(|one| format!("  {one}")));
            head.extend(stated(program));
            let text = export::never(&model, &group(shown.clone()), &head, &told);
            files.push((name, text));
            index.push(format!("{name}: unsat. {says}"));
            index.extend(shown.into_iter().map(|at| format!("  {}", told(at))));
        }
        left.extend(open.into_iter().map(|at| format!("  {}", told(at))));
    };
    file(
        KEPT,
        kept,
        "Can a scan that starts as scans are trusted to start do any of this?",
        "No scan that starts where all of these hold breaks one of them:",
    );
    file(
        COUNTS,
        counted,
        "Can a scan that starts as scans are trusted to start count or reach further than was found?",
        "Nothing counts or reaches further than the bound has it:",
    );
    if !left.is_empty() {
        let why =
            "the scan's formula takes some values as any, sums loops up, or takes too long to ask";
        index.push(format!(
            "Not shown by a file, since {why} (docs/values.md says how it was found):"
        ));
        index.append(&mut left);
    }
    Invariants { files, index }
}

/// What holds whenever a scan starts, where the program is trusted with it.
fn given(program: &Program) -> Vec<String> {
    let words = (0..program.trusted.len()).map(|place| tell(program, &Breach::Word(place)));
    let sets = sets(program).map(|bits| tell(program, &Breach::All(bits)));
    let fresh = program.apart.iter().filter(|one| one.most == 0);
    let cleared = fresh.map(|one| {
        let names: Vec<String> = one.bits.iter().map(|&bit| program.bit_name(bit)).collect();
        format!("{} are off in the first scan, before which memory was cleared", names.join(", "))
    });
    words.chain(sets).chain(cleared).collect()
}

/// What the user states of words that start a scan.
fn stated(program: &Program) -> Vec<String> {
    let trusted: BTreeSet<Cell> = program.trusted.iter().map(|one| one.cell).collect();
    let by_user =
        program.ranges.iter().filter(|one| !one.cells.iter().any(|cell| trusted.contains(cell)));
    by_user
        .map(|one| {
            let cells: Vec<String> =
                one.cells.iter().map(|&cell| program.cell_name(cell)).collect();
            format!("  {} is {} to {}, as is stated", cells.join(" with "), one.low, one.high)
        })
        .collect()
}

/// The sets of relays that are never all on.
fn sets(program: &Program) -> impl Iterator<Item = Vec<BitTarget>> + '_ {
    program.apart.iter().flat_map(Apart::never)
}

/// What holds if this never happens.
fn tell(program: &Program, breach: &Breach) -> String {
    let place = |at: usize| {
        let instruction = &program.instructions[at];
        let file = &instruction.place.of(&program.files).name;
        format!("{file}:{} {}", instruction.place.line, instruction.text)
    };
    match *breach {
        Breach::Word(at) => {
            let word = &program.trusted[at];
            format!("{} is {}", program.cell_name(word.cell), word.told())
        }
        Breach::All(ref bits) => {
            let names: Vec<String> = bits.iter().map(|&bit| program.bit_name(bit)).collect();
            match &names[..] {
                [a, b] => format!("{a} and {b} are never both on"),
                _ => format!("{} are never all on", names.join(", ")),
            }
        }
        Breach::Count(at) => format!("{} counts no more than was found", place(at)),
        Breach::Reach(at) => format!("{} reaches no further than was found", place(at)),
    }
}

/// Whether the state in which runs begin breaks any of it: cleared memory.
fn power_up(program: &Program) -> String {
    let mut text = String::from(
        "; Does memory that is cleared at power-up or reset break any of this?\n\
         ; unsat: it does not. (A latched word comes up with what a scan wrote into it: the other file asks of every\n\
         ; write, not only of the last one.)\n\
         (set-logic QF_BV)\n",
    );
    let mut asked = String::new();
    for (place, one) in program.trusted.iter().enumerate() {
        let name = program.cell_name(one.cell);
        text += &format!(
            "(declare-const w{place} (_ BitVec 16)) ; {name}\n(assert (= w{place} #x{:04X}))\n",
            program.power_up.word(one.cell)
        );
        let [low, high] = [one.low, one.high].map(|end| end as u16);
        let is_one = one.values.iter().map(|value| format!(" (= w{place} #x{value:04X})"));
        let within = match one.values.is_empty() {
            true => format!("(and (bvsle #x{low:04X} w{place}) (bvsle w{place} #x{high:04X}))"),
            false => format!("(or{})", is_one.collect::<String>()),
        };
        asked += &format!("  (not {within}) ; {}\n", tell(program, &Breach::Word(place)));
    }
    let mut relays: BTreeSet<BitTarget> = BTreeSet::new();
    let name = |bit: BitTarget| match bit {
        BitTarget::Cell(cell) => format!("r{}x{}", cell.area.0, cell.index),
        BitTarget::WordBit(cell, bit) => format!("r{}x{}x{bit}", cell.area.0, cell.index),
    };
    for bits in sets(program) {
        let own: Vec<String> = bits.iter().map(|&bit| name(bit)).collect();
        relays.extend(&bits);
        asked += &format!("  (and {}) ; {}\n", own.join(" "), tell(program, &Breach::All(bits)));
    }
    for bit in relays {
        let (own, called) = (name(bit), program.bit_name(bit));
        text += &format!("(declare-const {own} Bool) ; {called}\n(assert (not {own}))\n");
    }
    format!("{text}(assert (or false\n{asked}))\n(check-sat)\n")
}
