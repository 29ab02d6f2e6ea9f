//! Ranges that the user states for the index of writes, for one place or wherever a register is the index.

use super::counts;
use scanbound_base::code::Code;
use scanbound_base::diagnostic::Diagnostic;
use scanbound_base::facts::{Facts, Part};
use scanbound_ir::{ChoiceId, IndexedWrite, Program, WordSource, Write};

/// Applies stated ranges of indices: limits the cells that writes with these indices can reach.
///
/// # Errors
/// Each place without a write by an index, each name that is not the index register of a write, each index whose number
/// of bits is not stated, and each range that contradicts another one for the same write.
pub fn state(program: &mut Program, facts: &Facts) -> Result<(), Vec<Diagnostic>> {
    let mut faults = Vec::new();
    for (place, &(low, high)) in &facts.indices {
        let mut fault = |message: String, help: &str| {
            faults.push(facts.fault(["index", place], Part::Key, Code::Fact, message, help));
        };
        let found = match choices_at_key(program, place) {
            Ok(found) => found,
            Err((message, help)) => {
                fault(message, &help);
                continue;
            }
        };
        let is_open = |choice: &ChoiceId| program.indexed[choice].indices.len() > 1;
        if found.iter().any(is_open) {
            let message = format!("the number of bits of the index '{place}' is not stated");
            fault(
                message,
                "state the number of bits first, in the same table: bits = 16, or bits = 32",
            );
            continue;
        }
        for choice in found {
            let Some(indexed) = program.indexed.get_mut(&choice) else { continue };
            // An index may be stated by its register and by its place: both statements apply.
            let bits = 16 * indexed.indices.iter().map(Vec::len).min().unwrap_or(1);
            let largest = (1i64 << (bits - 1)) - 1;
            let (least, largest) = indexed.stated.unwrap_or((-largest - 1, largest));
            let both = (least.max(low), largest.min(high));
            if both.0 > both.1 {
                let message = format!(
                    "the index '{place}' cannot be {low} to {high}: with {bits} bits and the other statements about it, it is {least} to {largest}"
                );
                let help = "correct this range, the number of bits, or another statement about the same index";
                faults.push(facts.fault(["index", place], Part::Value, Code::Fact, message, help));
                break;
            }
            indexed.stated = Some(both);
        }
    }
    if faults.is_empty() { Ok(()) } else { Err(faults) }
}

/// The choices (nondeterministic values) that the instruction `at` writes to cells that an index selects.
fn indexed(program: &Program, at: usize) -> Vec<ChoiceId> {
    let effects = program.instructions[at].effects.iter();
    let choices = effects.filter_map(|effect| match effect.write {
        Write::Havoc(_, choice) if program.indexed.get(&choice).is_some_and(has_index) => {
            Some(choice)
        }
        _ => None,
    });
    choices.collect()
}

/// Whether a word selects the place of the write, and not only its length.
fn has_index(indexed: &IndexedWrite) -> bool {
    indexed.indices.iter().flatten().any(|word| !matches!(word, WordSource::Const(_)))
}

fn choices_at_key(program: &Program, place: &str) -> Result<Vec<ChoiceId>, (String, String)> {
    let form = || {
        "write \"FILE:LINE\" = [0, 99] for the writes of that line, or Z0 = [0, 99] for all writes with this index"
            .to_owned()
    };
    let instructions = match place.rsplit_once(':') {
        Some((file, number)) => {
            let none = "no instruction writes to a device that an index selects";
            let what = [none, "such instructions are", none];
            let is_meant = |program: &Program, at| !indexed(program, at).is_empty();
            counts::at(program, (file, number), is_meant, what, form())?
        }
        None => (0..program.instructions.len()).collect(),
    };
    let is_by = |choice: &ChoiceId| {
        place.contains(':')
            || program.indexed[choice].indices.iter().any(|reading| match reading.first() {
                Some(WordSource::Cell(cell)) => {
                    program.cell_name(*cell).eq_ignore_ascii_case(place.trim())
                }
                _ => false,
            })
    };
    let found: Vec<ChoiceId> =
        instructions.into_iter().flat_map(|at| indexed(program, at)).filter(is_by).collect();
    if found.is_empty() {
        return Err((
            format!("no instruction writes to a device that the index '{place}' selects"),
            form(),
        ));
    }
    Ok(found)
}
