//! Loops whose count stands in a word.

use super::assembly::Assembly;
use scanbound_ir::{Step, WordSource, flow};

/// Holds counts to the ranges that are stated of their words. A stated range is one of the scan's start, so it says
/// something of words that the program does not write.
pub(super) fn settle(asm: &mut Assembly) {
    for (at, word) in std::mem::take(&mut asm.counted) {
        let stated =
            asm.out.program.stated_ranges.iter().find(|range| Some(range.cells[0]) == word);
        let Some((cell, low, high)) = stated
            .filter(|range| range.cells.len() == 1 && range.low >= 0)
            .map(|range| (range.cells[0], range.low, range.high))
            .filter(|(cell, ..)| {
                !flow::is_written(&asm.out.program, *cell) && !asm.memory.is_volatile(*cell)
            })
        else {
            // A count from 32768 on is none that a signed word says.
            asm.out.program.loops_without_count.insert(at);
            continue;
        };
        if let Step::ForBegin { count, least, most, .. } =
            &mut asm.out.program.instructions[at].step
        {
            *count = WordSource::Cell(cell);
            (*least, *most) = (low as u32, high as u32);
        }
    }
}
