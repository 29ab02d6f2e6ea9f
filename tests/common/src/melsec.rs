//! Decodes MELSEC lists, and computes the largest sum of the times of their operations `Op1`, `Op2`, `Op4` ...

use super::bound::bound;
use super::passed::passed;
use scanbound::base::facts::Facts;
use scanbound::base::time::{Picos, Times};
use scanbound::front::melsec::decode::{DecodeOptions, decode};
use scanbound::front::melsec::memory::Family;
use scanbound::front::melsec::source::RawProject;
use scanbound::front::{Input, read};
use scanbound::program::Program;
use scanbound::solve::Method;

/// Files of instructions that are separated by `; `.
pub fn decoded(family: Family, files: &[(&str, &str)], facts: &Facts) -> Result<Program, String> {
    let inputs: Vec<Input> = files
        .iter()
        .map(|(name, text)| Input {
            name: format!("{name}.il"),
            bytes: text.replace("; ", "\n").into_bytes(),
        })
        .collect();
    let told = |faults: Vec<scanbound::base::diagnostic::Diagnostic>| {
        let all: Vec<String> =
            faults.iter().map(|fault| format!("{}: {}", fault.text, fault.message)).collect();
        all.join("\n")
    };
    let project = read(&inputs, Some("melsec-list")).map_err(told)?;
    let project: RawProject = project.downcast().ok_or("not read as MELSEC")?;
    let is_user_instruction = |name: &str| name.starts_with("Op");
    let options = DecodeOptions {
        family,
        is_user_instruction: &is_user_instruction,
        facts,
        absent_calls_take_no_time: false,
    };
    decode(&project, &options).and_then(passed).map_err(told)
}

/// The time of the longest scan if each operation `Op1`, `Op2`, `Op4` ... takes its number, and nothing when off.
pub fn longest(program: &Program) -> u64 {
    let times = program
        .instructions
        .iter()
        .map(|instruction| {
            let cost = instruction.text.strip_prefix("Op").and_then(|cost| cost.parse().ok());
            Times::new(Picos(cost.unwrap_or(0)), Picos::ZERO)
        })
        .collect::<Vec<Times>>();
    bound(program, &times, Method::Cores).expect("the program can be followed").upper.0
}

/// Instructions that are separated by `; `.
pub fn together(family: Family, text: &str) -> u64 {
    let program = decoded(family, &[("MAIN", text)], &Facts::default());
    longest(&program.unwrap_or_else(|faults| panic!("{text}\n{faults}")))
}
