//! Tells of stated facts that say nothing of the program, or less than it shows: perhaps a slip of the pen.

use crate::diagnostic::Diagnostic;
use crate::facts::Facts;
use crate::price::points_seen;
use crate::program::{BitSource, Cell, Program, Region, Source, WordSource, flow};

/// Refuses ranges of words where the machine has none.
///
/// # Errors
/// Each such range.
pub fn know_words(program: &Program, facts: &Facts) -> Result<(), Vec<Diagnostic>> {
    let faults: Vec<Diagnostic> = facts
        .ranges
        .keys()
        .filter(|_| program.ranges.is_empty())
        .map(|device| {
            let message = format!("a range is stated for '{device}', but the machine has no words");
            Diagnostic::file("fact", "", message, "leave it out")
        })
        .collect();
    if faults.is_empty() { Ok(()) } else { Err(faults) }
}

/// Warns of ranges of words that the program does not name, and of fewer points than it names.
#[must_use]
pub fn odd(program: &Program, facts: &Facts) -> Vec<Diagnostic> {
    let warning =
        |message: String, help: &str| Diagnostic::file("unused-fact", "", message, help).warning();
    let ranges = program.ranges.iter().filter(|range| {
        !range
            .cells
            .iter()
            .any(|&cell| (0..program.instructions.len()).any(|at| names(program, at, cell)))
    });
    let mut warnings: Vec<Diagnostic> = ranges
        .map(|range| {
            let word = program.cell_name(range.cells[0]);
            let message = format!("a range is stated for {word}, which the program does not name");
            warning(
                message,
                "write the word as in the program; leave the range out if it is not used",
            )
        })
        .collect();
    for (side, area, stated) in [("input", "X", facts.inputs), ("output", "Y", facts.outputs)] {
        let (seen, why) = points_seen(program, side, area);
        if let Some(stated) = stated.filter(|&stated| stated < seen) {
            let message = format!("{stated} {side} points are stated, but the program shows {why}");
            warnings.push(warning(message, "state all the points that the CPU refreshes"));
        }
    }
    warnings
}

/// Whether an instruction reads a cell, writes it, or has it among its operands.
fn names(program: &Program, at: usize, cell: Cell) -> bool {
    let instruction = &program.instructions[at];
    let mut read = false;
    instruction.each_read(&mut |source| {
        read |= match source {
            Source::Bit(BitSource::Cell(one) | BitSource::WordBit(one, _)) => one == cell,
            Source::Word(WordSource::Cell(one)) => one == cell,
            _ => false,
        };
    });
    let written = flow::written(program, at);
    let operands = instruction.timing.iter().flat_map(|key| &key.touched.regions);
    let mut regions = written.iter().chain(operands);
    read || regions.any(|&region: &Region| region.holds(cell))
}
