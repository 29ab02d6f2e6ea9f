//! The bound of random programs, generated behind the dialects: no scan exceeds it, and its witness reaches it.

mod common;

use common::bound::bound;
use common::ir::{Taste, generate};
use common::search::holds;
use common::tape::{Tape, cases, on_tapes};
use scanbound::solve::Method;

const PLAIN: Taste = Taste {
    words: false,
    arithmetic: false,
    reals: false,
    choices: false,
    control: false,
    items: 10,
};

fn check(tape: &[u16], taste: Taste, method: Method, cap: usize) -> Result<(), String> {
    let (program, times) = generate(&mut Tape::new(tape), taste);
    let listing = || {
        let line = |(i, t): (&scanbound::program::Instruction, _)| {
            format!("{} {t:?} {:?}", i.text, i.effects)
        };
        let lines: Vec<String> = program.instructions.iter().zip(&times).map(line).collect();
        format!(
            "{}\nmains {:?} interrupts {:?} ranges {:?}",
            lines.join("\n"),
            program.mains,
            program.interrupts,
            program.ranges
        )
    };
    let bound = bound(&program, &times, method).map_err(|why| format!("{why}\n{}", listing()))?;
    holds(&program, &times, &bound, cap).map_err(|why| format!("{why}\n{}", listing()))?;
    Ok(())
}

#[test]
fn rungs_of_bits() {
    on_tapes(cases(400), 250, |tape| check(tape, PLAIN, Method::Auto, 300));
}

#[test]
fn choices_and_forgotten_cells() {
    let taste = Taste { choices: true, ..PLAIN };
    on_tapes(cases(200), 250, |tape| check(tape, taste, Method::Auto, 300));
}

#[test]
fn words_and_comparisons() {
    let taste = Taste { words: true, ..PLAIN };
    on_tapes(cases(200), 250, |tape| check(tape, taste, Method::Auto, 300));
}

#[test]
fn arithmetic() {
    let taste = Taste { words: true, arithmetic: true, ..PLAIN };
    on_tapes(cases(150), 250, |tape| check(tape, taste, Method::Auto, 300));
}

#[test]
fn reals() {
    let taste = Taste { words: true, reals: true, choices: true, ..PLAIN };
    on_tapes(cases(150), 250, |tape| check(tape, taste, Method::Auto, 300));
}

#[test]
fn control() {
    let taste = Taste { control: true, ..PLAIN };
    on_tapes(cases(400), 350, |tape| check(tape, taste, Method::Auto, 300));
}

#[test]
fn everything_together() {
    let taste = Taste {
        words: true,
        arithmetic: true,
        reals: true,
        choices: true,
        control: true,
        items: 10,
    };
    on_tapes(cases(200), 500, |tape| check(tape, taste, Method::Auto, 200));
}
