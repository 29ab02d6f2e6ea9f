//! Loops without a bound: which of them a scan can reach, each shown by a replayed scan.

use super::LoopUse;
use scanbound_base::time::{Picos, Times};
use scanbound_ir::meaning::Knowledge;
use scanbound_ir::{Program, Step};
use scanbound_model::groups::{groups, witness};
use scanbound_model::{Assignment, Charge, Lit, ScanModel};
use scanbound_replay::replay_knowing;
use scanbound_solve::{Limits, Method, maximum};
use std::collections::BTreeSet;

/// The search ends when it has found this many loops: a single one is enough to leave a scan without a bound.
const MAX_FOUND: usize = 10;

/// The loops without a bound, by whether a scan can reach them. Loops that no scan reaches are in neither list.
pub struct Loops {
    /// The unbounded loops that a scan can reach.
    pub found: Vec<LoopUse>,
    /// The loops for which it was not decided whether a scan can reach them.
    pub open: Vec<LoopUse>,
}

/// Searches the unbounded loops of the model for those that a scan can reach, until no other can be reached, ten are
/// found, or the limits end the search. `knowledge` is what real runs had shown when the model was made.
///
/// # Errors
/// If the interpreter does not reach a loop that the analysis says is reachable.
pub fn loops(
    program: &Program,
    times: &[Times],
    model: &ScanModel,
    knowledge: &Knowledge,
    limits: &Limits<'_>,
) -> Result<Loops, String> {
    let mut known = Loops { found: Vec::new(), open: Vec::new() };
    if model.unbounded.iter().all(|one| one.reached == Lit::FALSE) {
        return Ok(known);
    }
    let mut bare = ScanModel { charges: Vec::new(), unbounded: Vec::new(), ..model.clone() };
    let mut rest: Vec<_> = model.unbounded.iter().filter(|one| one.reached != Lit::FALSE).collect();
    while let Some(first) = rest.first() {
        // The model's only charge, of one picosecond, is for reaching any of the loops: its maximum says whether that
        // is possible.
        let reached = bare.circuit.any(rest.iter().map(|one| one.reached).collect::<Vec<_>>());
        bare.charges = vec![Charge {
            instruction: first.instruction,
            frames: first.frames.clone(),
            reached,
            fires: reached,
            on: Picos(1),
            off: Picos::ZERO,
            counted: None,
        }];
        let mut assignment = Assignment(vec![0; model.variables.len()]);
        let mut possible = reached == Lit::TRUE;
        let mut proved = possible;
        for group in groups(&bare) {
            let found = maximum(&bare, &group, Method::Cores, limits);
            possible |= found.upper > Picos::ZERO;
            proved |= found.lower > Picos::ZERO;
            found.best.copy_to(&mut assignment);
        }
        if !proved {
            if possible {
                known.open = rest.iter().map(|one| shown(program, one.instruction)).collect();
                known.open.sort();
                known.open.dedup();
            }
            break;
        }
        let values = bare.circuit.evaluate(&assignment);
        let come_to = rest.iter().filter(|one| values.get(one.reached));
        let come_to: Vec<LoopUse> = come_to.map(|one| shown(program, one.instruction)).collect();
        let replayed = replay_knowing(program, times, knowledge, &witness(model, &assignment));
        if replayed.unbounded.is_none() || come_to.is_empty() {
            let line = shown(program, first.instruction).to.line;
            return Err(format!(
                "the scan ends in the interpreter, but the analysis says that it stays for ever in the loop to line {line} or in a later loop"
            ));
        }
        known.found.extend(come_to);
        known.found.sort();
        known.found.dedup();
        if known.found.len() >= MAX_FOUND {
            break;
        }
        rest.retain(|one| !known.found.contains(&shown(program, one.instruction)));
    }
    Ok(known)
}

/// All unbounded loops of the program, for a structural bound, with which it is not asked whether a scan reaches them.
pub fn unasked(program: &Program) -> Vec<LoopUse> {
    let steps = program.instructions.iter().enumerate();
    let endless = steps.filter(|(_, one)| matches!(one.step, Step::Unbounded { .. }));
    let found: BTreeSet<LoopUse> = endless.map(|(at, _)| shown(program, at)).collect();
    found.into_iter().collect()
}

fn shown(program: &Program, at: usize) -> LoopUse {
    let end = &program.instructions[at];
    let (from, certain) = match end.step {
        Step::Unbounded { from, certain } => (from, certain),
        _ => (at, true),
    };
    let start = &program.instructions[from];
    LoopUse {
        from: start.place,
        to: end.place,
        begins: start.text.to_string(),
        ends: end.text.to_string(),
        certain,
    }
}
