//! How many times faster than the machine the emulator is, on one core: the test program and a full memory.
#![allow(clippy::print_stdout)]

use scanbound::front::minasec::{Opcode, WORDS, Word, assembly};
use scanbound::minasec::stimulus::Stimulus;
use scanbound::minasec::{Clock, Fraction, Machine, Settings};
use std::time::{Duration, Instant};

/// So long each case is run.
const RUN: Duration = Duration::from_secs(1);

fn main() {
    let test = include_str!("../samples/minasec-u/test-program.asm");
    let test = assembly::read("test-program.asm", test).expect("the sample assembles").words;
    let stimulus = "time_s,X00\n0.1,1\n0.3,0\n";
    let stimulus = Stimulus::parse("start", stimulus.as_bytes()).expect("a stimulus");
    let trembling = Settings {
        clock: Clock { tolerance: Fraction(50_000), jitter: Fraction(1_000), ..Clock::default() },
        ..Settings::default()
    };
    for (name, words, settings) in [
        ("test program", test, &Settings::default()),
        ("256 words", full(), &Settings::default()),
        ("256 words, jitter", full(), &trembling),
    ] {
        let factor = factor(words, settings, &stimulus);
        println!("{name}: {factor} times as fast as the machine");
    }
}

/// A memory without an empty word: contacts of all devices, a store in every fourth.
fn full() -> [Word; WORDS] {
    std::array::from_fn(|at| {
        let mixed = (at * 97 + 31) as u8;
        let store =
            Word::new(if at % 8 == 3 { Opcode::St } else { Opcode::Sti }, Word(mixed).device());
        match Word(mixed) {
            _ if at % 4 == 3 && !store.stores_to_input() => store,
            word if word.opcode().is_store() => Word(mixed & 0x7F),
            word => word,
        }
    })
}

fn factor(words: [Word; WORDS], settings: &Settings, stimulus: &Stimulus) -> u128 {
    let mut machine = Machine::new(words, settings, stimulus);
    let begun = Instant::now();
    while begun.elapsed() < RUN {
        for _ in 0..1000 {
            std::hint::black_box(machine.scan(&mut ()));
        }
    }
    u128::from(machine.now().0) / 1000 / begun.elapsed().as_nanos()
}
