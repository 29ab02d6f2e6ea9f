//! Counts (numbers of iterations or units) that the user states, for one place or wherever a word is the count: finds
//! the instructions and applies the statements.

use super::unknown;
use scanbound_base::code::Code;
use scanbound_base::diagnostic::Diagnostic;
use scanbound_base::facts::{Facts, Part};
use scanbound_base::suggestion;
use scanbound_ir::{Approximated, Program, Step, Units, WordSource};
use std::collections::BTreeSet;

/// The largest number of places or files that a message suggests if the stated one does not exist.
const MAX_OFFERED: usize = 8;

/// Applies stated counts to the program: lowers the largest number of iterations or units of the instructions, and
/// records the counts, so that scans with other counts are excluded. Loops to which the front already applied a count
/// are left as they are.
///
/// # Errors
/// Each place that is not in the program or has no count, and each count that is impossible there.
pub fn state(program: &mut Program, facts: &Facts) -> Result<(), Vec<Diagnostic>> {
    let mut faults = Vec::new();
    // Counts that the front already applied to its loops.
    let own: BTreeSet<usize> = program.stated_counts.keys().copied().collect();
    for (place, &(low, high)) in &facts.counts {
        let fault = |part, message: String, help: &str| {
            facts.fault(["counts", place], part, Code::Fact, message, help)
        };
        let found = match instructions_at_key(program, place) {
            Ok(found) => found,
            Err((message, help)) => {
                faults.push(fault(Part::Key, message, &help));
                continue;
            }
        };
        for at in found.into_iter().filter(|at| !own.contains(at)) {
            if !lower(program, at, low, high) {
                let text = program.instructions[at].text.clone();
                let message = format!(
                    "the number of iterations or units of `{text}` at {place} cannot be {low} to {high} as stated"
                );
                faults.push(fault(
                    Part::Value,
                    message,
                    "remove the statement, or state a number that can occur",
                ));
                continue;
            }
            // A line and a step may name the same place: both statements apply.
            let all = program.stated_counts.entry(at).or_insert((low, high));
            *all = (all.0.max(low), all.1.min(high));
            // Its number of iterations is known now: it is followed if they are few enough.
            program.loops_without_count.remove(&at);
            let unknown = |what: &Approximated| matches!(what, Approximated::UnknownCount { .. });
            program.approximations.retain(|one| one.instruction != at || !unknown(&one.what));
        }
    }
    if faults.is_empty() { Ok(()) } else { Err(faults) }
}

/// Whether the number of iterations of the loop, or of units of the instruction, at `at` is not constant.
fn counts(program: &Program, at: usize) -> bool {
    let instruction = &program.instructions[at];
    let iterations = match &instruction.step {
        Step::ForBegin { count, .. } => Some(*count),
        Step::Summary(summary) => summary.iterations.map(|(count, ..)| count),
        _ => None,
    };
    iterations.is_some_and(|count| !matches!(count, WordSource::Const(_)))
        || instruction.counted().is_some()
}

/// The indices of the instructions for which a count can be stated at `place`: `FILE:LINE`, `FILE:step NUMBER`, or the
/// word from which they read the count. `Err` if there are none: the message and the help.
pub(super) fn instructions_at_key(
    program: &Program,
    place: &str,
) -> Result<Vec<usize>, (String, String)> {
    let form = || {
        "write \"FILE:LINE\" as reports show it, \"FILE:step NUMBER\", or the word that holds the number of iterations or units"
            .to_owned()
    };
    let Some((file, number)) = place.rsplit_once(':') else {
        let is_it = |word: &str| word.eq_ignore_ascii_case(place.trim());
        // The source may name a file register differently from the program.
        let written = |at: usize| {
            program.approximations.iter().any(|one| match &one.what {
                Approximated::UnknownCount { word, .. } => one.instruction == at && is_it(word),
                _ => false,
            })
        };
        let is_meant = |&at: &usize| {
            unknown::word(program, at).is_some_and(|word| is_it(&word)) || written(at)
        };
        let found: Vec<usize> = (0..program.instructions.len())
            .filter(|&at| counts(program, at))
            .filter(is_meant)
            .collect();
        if found.is_empty() {
            let all = (0..program.instructions.len()).filter(|&at| counts(program, at));
            let words: BTreeSet<String> =
                all.filter_map(|at| Some(unknown::word(program, at)?.to_string())).collect();
            let help = suggestion::with_suggestion(suggestion::nearest(place, words), &form());
            return Err((
                format!(
                    "no instruction reads a number of iterations or units from the word '{place}'"
                ),
                help,
            ));
        }
        return Ok(found);
    };
    let what = [
        "no instruction reads a number of iterations or units from a word",
        "such instructions are",
        "there is no such instruction",
    ];
    at(program, (file, number), counts, what, form())
}

/// The indices of the instructions at a line (`543`) or step (`step 120`) of a file for which `can_be_stated` is true.
/// `Err` if there are none: the message and the help. `what` has three texts for them: that there is none at the place,
/// what introduces the list of other places, and that there is none in the file.
pub(super) fn at(
    program: &Program,
    (file, number): (&str, &str),
    can_be_stated: fn(&Program, usize) -> bool,
    what: [&str; 3],
    form: String,
) -> Result<Vec<usize>, (String, String)> {
    let place = format!("{file}:{number}");
    let number = number.trim();
    let (is_step, digits) = match number.strip_prefix("step") {
        Some(digits) => (true, digits.trim()),
        None => (false, number),
    };
    let Ok(number) = digits.parse::<u32>() else {
        return Err((
            format!(
                "'{place}' does not end with a line number (FILE:543) or a step (FILE:step 120)"
            ),
            form,
        ));
    };
    let files = matching(program, file);
    let [file] = files[..] else {
        let names: Vec<&str> =
            program.files.iter().take(MAX_OFFERED).map(|file| file.name.as_str()).collect();
        let message = match files.is_empty() {
            true => format!("there is no file '{file}' in this program"),
            false => format!("{} files of the project are named '{file}'", files.len()),
        };
        return Err((message, format!("write one of {}", names.join(", "))));
    };
    let of_file = |&at: &usize| program.instructions[at].place.file as usize == file;
    let all: Vec<usize> = (0..program.instructions.len())
        .filter(of_file)
        .filter(|&at| can_be_stated(program, at))
        .collect();
    let is_meant = |&at: &usize| {
        let place = program.instructions[at].place;
        if is_step { place.step == Some(number) } else { place.line == number }
    };
    let found: Vec<usize> = all.iter().copied().filter(is_meant).collect();
    if !found.is_empty() {
        return Ok(found);
    }
    let mut near = all;
    near.sort_by_key(|&at| program.instructions[at].place.line.abs_diff(number));
    let offered: Vec<String> = near
        .into_iter()
        .take(MAX_OFFERED)
        .map(|at| &program.instructions[at])
        .map(|one| format!("{} ({})", one.place.line, one.text))
        .collect();
    let help = match offered.is_empty() {
        true => format!("{} in that file", what[2]),
        false => format!("in that file {} in the lines {}", what[1], offered.join(", ")),
    };
    Err((format!("at {place}, {}", what[0]), help))
}

/// The indices of the files with exactly this name. If there are none: of those with this name after their directories,
/// upper and lower case being the same.
fn matching(program: &Program, name: &str) -> Vec<usize> {
    let all = || program.files.iter().enumerate();
    let whole: Vec<usize> =
        all().filter(|(_, file)| file.name == name).map(|(index, _)| index).collect();
    if !whole.is_empty() {
        return whole;
    }
    let last = |name: &str| name.rsplit(['/', '\\']).next().unwrap_or_default().to_lowercase();
    all().filter(|(_, file)| last(&file.name) == name.to_lowercase()).map(|(at, _)| at).collect()
}

/// Limits the number of iterations or units of an instruction to the stated range. Returns false if a loop can have no
/// number of iterations in this range; it is then unchanged. True for all other instructions.
fn lower(program: &mut Program, at: usize, low: i64, high: i64) -> bool {
    let keep_within = |least: &mut u32, most: &mut u32| {
        let (low, high) = (low.max(0).unsigned_abs(), high.max(0).unsigned_abs());
        if low > u64::from(*most) || high < u64::from(*least) {
            return false;
        }
        // It fits into `u32`: it is at most the old value.
        *most = u64::from(*most).min(high) as u32;
        *least = u64::from(*least).max(low) as u32;
        true
    };
    let instruction = &mut program.instructions[at];
    let iterations = match &mut instruction.step {
        Step::ForBegin { least, most, .. } => keep_within(least, most),
        Step::Summary(summary) => match &mut summary.iterations {
            Some((_, least, most)) => keep_within(least, most),
            None => true,
        },
        _ => true,
    };
    if let Some(Units::Counted(counted)) = instruction.timing.as_mut().map(|key| &mut key.units) {
        counted.most = counted.most.min(high.max(0).unsigned_abs());
    }
    iterations
}
