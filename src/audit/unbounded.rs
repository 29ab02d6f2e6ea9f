//! Loops that a scan can go round for ever: which of them can be reached at all, each proved by a replayed scan.

use super::{LoopUse, Where};
use crate::groups::{groups, witness};
use crate::model::{Assignment, Charge, Lit, ScanModel};
use crate::program::{Program, Step};
use crate::replay::replay;
use crate::solve::{Limits, Method, maximum};
use crate::time::Picos;
use std::collections::{BTreeMap, BTreeSet};

/// What is known of the loops.
pub struct Loops {
    /// Those that a scan can come to.
    pub found: Vec<LoopUse>,
    /// Those of which the search did not find out.
    pub open: Vec<LoopUse>,
}

/// Asks of every loop of the model whether a scan can come to it.
///
/// # Errors
/// If the interpreter does not come to a loop that the analysis says it comes to.
pub fn loops(
    program: &Program,
    times: &[(Picos, Picos)],
    model: &ScanModel,
    limits: &Limits<'_>,
) -> Result<Loops, String> {
    let mut known: BTreeMap<LoopUse, bool> = BTreeMap::new();
    let mut bare = ScanModel { charges: Vec::new(), unbounded: Vec::new(), ..model.clone() };
    for one in model.unbounded.iter().filter(|one| one.reached != Lit::FALSE) {
        let shown = shown(program, one.instruction);
        if known.get(&shown) == Some(&true) {
            continue;
        }
        // Worth a picosecond, and nothing else worth anything: the maximum tells whether it can be reached.
        bare.charges = vec![Charge {
            instruction: one.instruction,
            frames: one.frames.clone(),
            reached: one.reached,
            fires: one.reached,
            on: Picos(1),
            off: Picos::ZERO,
        }];
        let mut assignment = Assignment(vec![0; model.variables.len()]);
        let mut possible = one.reached == Lit::TRUE;
        let mut proved = possible;
        for group in groups(&bare) {
            let found = maximum(&bare, &group, Method::Cores, limits);
            possible |= found.upper > Picos::ZERO;
            proved |= found.lower > Picos::ZERO;
            for variable in &group.variables {
                let index = variable.0 as usize;
                assignment.0[index] = found.best.0[index];
            }
        }
        if proved {
            let replayed = replay(program, times, &witness(model, &assignment));
            if replayed.unbounded.is_none() {
                let line = shown.to.line;
                return Err(format!(
                    "the interpreter's scan ends, the analysis says that it goes round the loop to line {line} for ever"
                ));
            }
        }
        if possible {
            *known.entry(shown).or_default() |= proved;
        }
    }
    let take = |wanted: bool| {
        let kept = known.iter().filter(|(_, proved)| **proved == wanted);
        kept.map(|(shown, _)| shown.clone()).collect()
    };
    Ok(Loops { found: take(true), open: take(false) })
}

/// All loops of the program, where none was asked about.
pub fn unasked(program: &Program) -> Vec<LoopUse> {
    let steps = program.instructions.iter().enumerate();
    let endless = steps.filter(|(_, one)| matches!(one.step, Step::Unbounded { .. }));
    let found: BTreeSet<LoopUse> = endless.map(|(at, _)| shown(program, at)).collect();
    found.into_iter().collect()
}

fn shown(program: &Program, at: usize) -> LoopUse {
    let end = &program.instructions[at];
    let from = match end.step {
        Step::Unbounded { from } => from,
        _ => at,
    };
    let start = &program.instructions[from];
    let place = |place: crate::program::Place| Where {
        file: place.file as usize,
        line: place.line,
        step: place.step,
    };
    LoopUse {
        from: place(start.place),
        to: place(end.place),
        begins: start.text.clone(),
        ends: end.text.clone(),
    }
}
