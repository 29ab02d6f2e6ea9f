//! Loops whose count stands in a word, and loops too large to be followed turn by turn.

use super::assembly::Assembly;
use crate::base::code::Code;
use crate::program::{Approximation, Step, WordSource, flow, summary};
use std::collections::BTreeSet;

/// Loops of more executed instructions are summarised.
const MOST_UNROLLED: u64 = 200_000;

/// Holds counts to the ranges that are stated of their words, and summarises what is too large. A stated range is
/// one of the scan's start, so it says something of words that the program does not write.
pub(super) fn settle(asm: &mut Assembly) {
    let mut unknown = BTreeSet::new();
    for (at, word) in std::mem::take(&mut asm.counted) {
        let stated = asm.program.ranges.iter().find(|range| Some(range.cells[0]) == word);
        let Some((cell, low, high)) = stated
            .filter(|range| range.cells.len() == 1 && range.low >= 0)
            .map(|range| (range.cells[0], range.low, range.high))
            .filter(|(cell, ..)| {
                !flow::is_written(&asm.program, *cell) && !asm.memory.is_volatile(*cell)
            })
        else {
            // A count from 32768 on is none that a signed word says.
            unknown.insert(at);
            continue;
        };
        if let Step::ForBegin { count, least, most, .. } = &mut asm.program.instructions[at].step {
            *count = WordSource::Cell(cell);
            (*least, *most) = (low as u32, high as u32);
        }
    }
    let mut behind = 0;
    for (begin, end) in flow::loops(&asm.program) {
        let Step::ForBegin { most, .. } = asm.program.instructions[begin].step else { continue };
        let size = flow::unrolled(&asm.program, begin + 1, end).saturating_mul(u64::from(most));
        if begin < behind || (size <= MOST_UNROLLED && !unknown.contains(&begin)) {
            continue;
        }
        behind = end;
        let Some(step) = summary::of_loop(&mut asm.program, begin, end, u64::from(most)) else {
            let instruction = &asm.program.instructions[begin];
            let message = "loops and calls multiply to more turns here than can be counted";
            let help = "state the range of its count in the facts file";
            let fault = asm.program.fault(instruction, Code::Loop, message, help);
            asm.faults.push(fault);
            continue;
        };
        asm.program.instructions[begin].step = step;
        let what = summary::charged(most).into();
        asm.program.approximations.push(Approximation { instruction: begin, what });
    }
}
