//! Runs source text with exact operations, as a PLC does.

use super::passed::passed;
use scanbound::base::facts::Facts;
use scanbound::base::time::{Picos, Times};
use scanbound::front::{Input, Options, read};
use scanbound::program::{Cell, Program, Witness};
use scanbound::replay;

/// The executed instructions, and the instruction at which the run stopped.
pub struct RealRun {
    pub fired: Vec<(String, bool)>,
    pub stopped: Option<String>,
}

/// The program of a text; MELSEC text is read for a Q CPU.
pub fn program(dialect: &str, text: &str) -> Program {
    let bytes = format!("{text}\nEND\n").into_bytes();
    let input = Input { name: "a.txt".to_owned(), bytes };
    let facts = Facts::default();
    let user = |name: &str| name.starts_with("SwOp");
    let options = Options { is_user_instruction: &user, ..Options::new(&facts) };
    let project = read(&[input], Some(dialect)).expect("readable");
    project.decode(&options).and_then(passed).unwrap_or_else(|why| panic!("{text}\n{why:?}"))
}

/// Runs one scan from these values; all others are 0.
pub fn real(dialect: &str, text: &str, start: &[(&str, u16)]) -> RealRun {
    let program = program(dialect, text);
    let mut witness = Witness::default();
    for &(name, value) in start {
        witness.start.insert(cell(&program, name), value);
    }
    let times = vec![Times::new(Picos(1), Picos(1)); program.instructions.len()];
    let found = replay::real(&program, &times, || &witness, 100_000);
    assert_eq!(found.undeclared_writes, [], "{text}");
    let priced = |event: &&replay::Event| {
        let instruction = &program.instructions[event.instruction];
        instruction.timing.is_some() && !instruction.text.starts_with("END")
    };
    let told = |at: usize| program.instructions[at].text.to_string();
    RealRun {
        fired: found
            .replay
            .events
            .iter()
            .filter(priced)
            .map(|event| (told(event.instruction), event.fired))
            .collect(),
        stopped: found.stopped.map(|stopped| told(stopped.at)),
    }
}

fn cell(program: &Program, name: &str) -> Cell {
    let found = program.areas.iter().enumerate().find_map(|(at, area)| {
        let index = name.strip_prefix(area.name.as_str())?.parse().ok()?;
        Some(Cell { area: scanbound::program::AreaId(at as u16), index })
    });
    found.unwrap_or_else(|| panic!("no cell: {name}"))
}
