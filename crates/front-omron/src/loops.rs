//! Loops whose number of iterations is in a word: the stated range of the word limits it.

use super::builder::OmronBuilder;
use scanbound_ir::{Step, WordSource, flow};

/// Limits loop counts to the stated ranges of their words. A range is about the start of the scan, so it applies only
/// to words that the program does not write.
pub(super) fn apply_stated_ranges(builder: &mut OmronBuilder) {
    for (at, word) in std::mem::take(&mut builder.counted) {
        let stated =
            builder.out.program.stated_ranges.iter().find(|range| Some(range.cells[0]) == word);
        let Some((cell, low, high)) = stated
            .filter(|range| range.cells.len() == 1 && range.low >= 0)
            .map(|range| (range.cells[0], range.low, range.high))
            .filter(|(cell, ..)| {
                !flow::is_written(&builder.out.program, *cell) && !builder.memory.is_volatile(*cell)
            })
        else {
            // A signed word cannot hold a count of 32768 or more.
            builder.out.program.loops_without_count.insert(at);
            continue;
        };
        if let Step::ForBegin { count, least, most, .. } =
            &mut builder.out.program.instructions[at].step
        {
            *count = WordSource::Cell(cell);
            (*least, *most) = (low as u32, high as u32);
        }
    }
}
