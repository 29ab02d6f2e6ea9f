//! The bound of random programs, generated behind the dialects: no scan exceeds it, and its witness reaches it.

use common::bound::{bound, bound_within};
use common::ir::{Taste, generate};
use common::search::{holds, none_above};
use common::tape::{Tape, cases, on_tapes};
use scanbound::base::time::Times;
use scanbound::passes::loops;
use scanbound::replay::replay;
use scanbound::scan::size_limits::scan_model_fitted;
use scanbound::solve::{Limits, Method};
use std::sync::atomic::{AtomicU32, Ordering};

const PLAIN: Taste = Taste {
    words: false,
    arithmetic: false,
    reals: false,
    choices: false,
    control: false,
    items: 10,
};

const ALL: Taste =
    Taste { words: true, arithmetic: true, reals: true, choices: true, control: true, items: 10 };

/// Checks a program with the search that its tape draws.
fn check(tape: &[u16], taste: Taste, cap: usize) -> Result<(), String> {
    let method = match tape.len() % 4 {
        0 => Method::Subsets,
        1 => Method::Cores,
        _ => Method::Auto,
    };
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
            program.stated_ranges
        )
    };
    let bound = bound(&program, &times, method).map_err(|why| format!("{why}\n{}", listing()))?;
    holds(&program, &times, &bound, cap).map_err(|why| format!("{why}\n{}", listing()))?;
    Ok(())
}

#[test]
fn rungs_of_bits() {
    on_tapes(cases(400), 250, |tape| check(tape, PLAIN, 300));
}

#[test]
fn choices_and_havocked_cells() {
    let taste = Taste { choices: true, ..PLAIN };
    on_tapes(cases(200), 250, |tape| check(tape, taste, 300));
}

#[test]
fn words_and_comparisons() {
    let taste = Taste { words: true, ..PLAIN };
    on_tapes(cases(200), 250, |tape| check(tape, taste, 300));
}

#[test]
fn arithmetic() {
    let taste = Taste { words: true, arithmetic: true, ..PLAIN };
    on_tapes(cases(150), 250, |tape| check(tape, taste, 300));
}

#[test]
fn reals() {
    let taste = Taste { words: true, reals: true, choices: true, ..PLAIN };
    on_tapes(cases(150), 250, |tape| check(tape, taste, 300));
}

#[test]
fn control() {
    let taste = Taste { control: true, ..PLAIN };
    on_tapes(cases(400), 350, |tape| check(tape, taste, 300));
}

#[test]
fn everything_together() {
    on_tapes(cases(200), 500, |tape| check(tape, ALL, 200));
}

/// However early a search ends, its upper bound holds, and its lower bound is a scan where it says so.
#[test]
fn an_early_end_leaves_valid_bounds() {
    on_tapes(cases(200), 350, |tape| {
        let (program, times) = generate(&mut Tape::new(tape), ALL);
        let told = |why: scanbound::scan::ScanError| why.to_string();
        let exact = bound(&program, &times, Method::Auto).map_err(told)?;
        for method in [Method::Auto, Method::Subsets, Method::Cores] {
            for patience in [0, 1, 3, 10] {
                let asked = AtomicU32::new(0);
                let cancelled = || asked.fetch_add(1, Ordering::Relaxed) >= patience;
                let limits = Limits { cancelled: &cancelled, ..Limits::default() };
                let early = bound_within(&program, &times, method, &limits).map_err(told)?;
                let reached = replay(&program, &times, &early.best);
                let is_scan = reached.broken_ranges.is_empty();
                if early.upper < exact.upper
                    || early.lower > exact.upper
                    || is_scan && reached.total < early.lower
                {
                    return Err(format!(
                        "{method:?} stopped after {patience} says {:?} to {:?}, its scan costs {:?}, the maximum is {:?}",
                        early.lower, early.upper, reached.total, exact.upper
                    ));
                }
            }
        }
        Ok(())
    });
}

/// Whatever is summarised, no scan of the program as it stands takes longer than the bound.
#[test]
fn what_is_summarised_bounds_every_scan() {
    on_tapes(cases(60), 400, |tape| {
        let (program, mut times) = generate(&mut Tape::new(tape), ALL);
        for most in [0, 3, 10, 40] {
            let mut fitted = program.clone();
            loops::fit(&mut fitted, most).map_err(|why| format!("{why:?}"))?;
            let count = program.instructions.len();
            times.resize(fitted.instructions.len(), Times::default());
            // A rung that goes on behind a loop has no result there any more: refused, not misjudged.
            let Ok(bound) = bound(&fitted, &times, Method::Auto) else { continue };
            holds(&fitted, &times, &bound, 50)?;
            none_above(&program, &times[..count], bound.upper, 100)
                .map_err(|why| format!("at most {most}: {why}"))?;
        }
        Ok(())
    });
}

/// Whatever a model may take, no scan of the program as it stands takes longer than the bound.
#[test]
fn what_is_given_up_bounds_every_scan() {
    on_tapes(cases(60), 400, |tape| {
        let (program, mut times) = generate(&mut Tape::new(tape), ALL);
        let count = program.instructions.len();
        let told = |why: scanbound::scan::ScanError| why.to_string();
        let mut given_up = 0;
        for all in [0, 20, 60, 200, 600] {
            let mut wider = program.clone();
            times.truncate(count);
            let model = scan_model_fitted(&mut wider, &times, all, &|| false).map_err(told)?;
            if model.is_none() {
                loops::summarise_all(
                    &mut wider,
                    scanbound::program::SummaryReason::TooManyInstructions,
                )
                .map_err(|why| format!("{why:?}"))?;
                times.resize(wider.instructions.len(), Times::default());
            }
            given_up += wider.approximations.len();
            let bound = bound(&wider, &times, Method::Auto).map_err(told)?;
            holds(&wider, &times, &bound, 50)?;
            none_above(&program, &times[..count], bound.upper, 100)
                .map_err(|why| format!("within {all}: {why}"))?;
        }
        if given_up == 0 { Err("nothing was given up".to_owned()) } else { Ok(()) }
    });
}
