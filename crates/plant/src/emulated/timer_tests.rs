//! Timers and counters by the emulated clock, held against what manuals say of each instruction.

use super::tests::times;
use super::*;
use scanbound_base::facts::Facts;
use scanbound_front::{Input, Options};
use scanbound_link::{Coil, Memory, Setting};

const MS: u64 = 1_000_000_000;

fn c200h(text: &str) -> Program {
    let input = Input { name: "a.il".to_owned(), bytes: text.as_bytes().to_vec() };
    let facts = Facts::default();
    let options = Options { family: Some("c"), ..Options::new(&facts) };
    let project = scanbound_fronts::read(&[input], Some("omron-c200h")).expect("a program");
    project.decode(&options).expect("a sound one")
}

/// A CPU whose instructions take no time and whose scans take a millisecond.
fn cpu<'p>(program: &'p Program, times: &'p [Times]) -> Cpu<'p> {
    Cpu::new(program, times, Picos(MS), None, Disturbance::default())
}

/// Makes scans up to a time, and gives whether a timer is over then, and what it stands at.
fn at(cpu: &mut Cpu<'_>, ms: u64, number: u32) -> (bool, u16) {
    while cpu.clock() < Picos(ms * MS) {
        cpu.scan().expect("it runs");
    }
    let flag = cpu.bits("TC", number, 1).expect("a flag")[0];
    (flag, cpu.words("TCPV", number, 1).expect("a value")[0])
}

fn input(cpu: &mut Cpu<'_>, bits: u16) {
    let word = cpu.named("IR0").expect("an input word");
    cpu.set(word, bits);
}

#[test]
fn a_timer_counts_tenths_of_a_second_down() {
    let program = c200h("LD 00000\nTIM 005 #0012\nLD TIM005\nOUT 00500\nEND\n");
    let times = times(&program, Picos::ZERO);
    let mut cpu = cpu(&program, &times);
    // Off, it stands at its setting.
    assert_eq!(at(&mut cpu, 35, 5), (false, 0x12));
    input(&mut cpu, 1);
    assert_eq!(at(&mut cpu, 90, 5), (false, 0x12));
    // The clock's next tenth is 65 ms away.
    assert_eq!(at(&mut cpu, 102, 5), (false, 0x11));
    assert_eq!(at(&mut cpu, 302, 5), (false, 0x09));
    assert_eq!(at(&mut cpu, 1200, 5), (false, 0x01));
    assert_eq!(at(&mut cpu, 1202, 5), (true, 0));
    assert_eq!(cpu.words("IR", 5, 1), Some(vec![1]));
    assert_eq!(at(&mut cpu, 5000, 5), (true, 0));
    // One scan without its condition starts it anew.
    input(&mut cpu, 0);
    assert_eq!(at(&mut cpu, 5001, 5), (false, 0x12));
    input(&mut cpu, 1);
    assert_eq!(at(&mut cpu, 5150, 5), (false, 0x11));
}

#[test]
fn a_fast_timer_counts_hundredths_and_its_contact_follows() {
    let program = c200h("LD 00000\nTIMH 007 #0025\nLD TIM007\nOUT 00500\nEND\n");
    let times = times(&program, Picos::ZERO);
    let mut cpu = cpu(&program, &times);
    input(&mut cpu, 1);
    assert_eq!(at(&mut cpu, 248, 7), (false, 1));
    assert_eq!(cpu.words("IR", 5, 1), Some(vec![0]));
    assert_eq!(at(&mut cpu, 252, 7), (true, 0));
    assert_eq!(cpu.words("IR", 5, 1), Some(vec![1]));
    assert_eq!(cpu.halted(), None);
}

#[test]
fn a_timer_takes_its_setting_from_a_word_while_it_stands() {
    let program = c200h("LD 00000\nTIM 005 DM 0010\nEND\n");
    let times = times(&program, Picos::ZERO);
    let mut cpu = cpu(&program, &times);
    let word = cpu.named("DM10").expect("a word");
    cpu.set(word, 0x0203);
    assert_eq!(at(&mut cpu, 5, 5), (false, 0x0203));
    assert_eq!(cpu.setting(Coil::Timer, 5, 0), Some(Setting::Word { area: "DM", index: 10 }));
    // Digits above 9: it is not carried out.
    cpu.set(word, 0x0A00);
    input(&mut cpu, 1);
    assert_eq!(at(&mut cpu, 1005, 5), (false, 0x0203));
}

#[test]
fn a_counter_counts_rises_down_and_its_reset_wins() {
    let program = c200h("LD 00000\nLD 00001\nCNT 003 #0003\nEND\n");
    let times = times(&program, Picos::ZERO);
    let mut cpu = cpu(&program, &times);
    let mut next = |bits: u16| {
        input(&mut cpu, bits);
        let end = cpu.clock().0 / MS + 1;
        at(&mut cpu, end, 3)
    };
    assert_eq!(next(0), (false, 3));
    assert_eq!(next(1), (false, 2));
    // What stays on is no further rise.
    assert_eq!(next(1), (false, 2));
    assert_eq!(next(0), (false, 2));
    assert_eq!(next(1), (false, 1));
    assert_eq!(next(0), (false, 1));
    assert_eq!(next(1), (true, 0));
    assert_eq!((next(0), next(1)), ((true, 0), (true, 0)));
    assert_eq!(next(2), (false, 3));
    // While it is reset it counts nothing; an input that was on then rises no more behind it.
    assert_eq!(
        (next(3), next(1), next(0), next(1)),
        ((false, 3), (false, 3), (false, 3), (false, 2))
    );
}

#[test]
fn a_reversible_counter_goes_round() {
    let program = c200h("LD 00000\nLD 00001\nLD 00002\nCNTR 004 #0002\nEND\n");
    let times = times(&program, Picos::ZERO);
    let mut cpu = cpu(&program, &times);
    let mut next = |bits: u16| {
        input(&mut cpu, bits);
        let end = cpu.clock().0 / MS + 1;
        at(&mut cpu, end, 4)
    };
    assert_eq!(next(0), (false, 0));
    assert_eq!(
        (next(1), next(0), next(1), next(0)),
        ((false, 1), (false, 1), (false, 2), (false, 2))
    );
    // Round to 0, and on until it moves on.
    assert_eq!(
        (next(1), next(0), next(1), next(0)),
        ((true, 0), (true, 0), (false, 1), (false, 1))
    );
    assert_eq!(
        (next(2), next(0), next(2), next(0)),
        ((false, 0), (false, 0), (true, 2), (true, 2))
    );
    // Both at once change nothing.
    assert_eq!((next(3), next(0), next(4)), ((true, 2), (true, 2), (false, 0)));
}

#[test]
fn an_interlock_resets_timers_and_holds_counters() {
    let program = c200h(
        "LD 00015\nIL\nLD 00000\nTIM 005 #0009\nLD 00001\nLD 00002\nCNT 003 #0005\nILC\nEND\n",
    );
    let times = times(&program, Picos::ZERO);
    let mut cpu = cpu(&program, &times);
    input(&mut cpu, 0x8000);
    at(&mut cpu, 5, 5);
    input(&mut cpu, 0x8003);
    assert_eq!((at(&mut cpu, 310, 5), at(&mut cpu, 310, 3)), ((false, 6), (false, 4)));
    input(&mut cpu, 0x0003);
    assert_eq!((at(&mut cpu, 320, 5), at(&mut cpu, 320, 3)), ((false, 9), (false, 4)));
}

#[test]
fn an_active_interlock_resets_no_accumulative_timer() {
    let text = "LD 0.15\nIL\nLD 0.00\nLD 0.01\nTTIM 5 #9\nILC\nEND\n";
    let input = Input { name: "a.il".to_owned(), bytes: text.as_bytes().to_vec() };
    let facts = Facts::default();
    let options = Options { family: Some("cj"), ..Options::new(&facts) };
    let project = scanbound_fronts::read(&[input], Some("omron-cx")).expect("a program");
    let program = project.decode(&options).expect("a sound one");
    let times = times(&program, Picos::ZERO);
    let mut cpu = cpu(&program, &times);
    let mut next = |bits: u16, ms: u64| {
        let word = cpu.named("CIO0").expect("an input word");
        cpu.set(word, bits);
        while cpu.clock() < Picos(ms * MS) {
            cpu.scan().expect("it runs");
        }
        cpu.words("TPV", 5, 1).expect("a value")[0]
    };
    assert_eq!([next(0x8002, 5), next(0x8001, 310), next(0x0002, 320)], [0, 3, 3]);
    assert_eq!(next(0x8002, 330), 0);
}

#[test]
fn bits_of_words_are_set_and_read_by_name() {
    let program = c200h("LD 00001\nOUT HR0107\nEND\n");
    let times = times(&program, Picos::ZERO);
    let mut cpu = cpu(&program, &times);
    assert!(cpu.set_named("00001", 1) && cpu.set_named("IR0.15", 1));
    cpu.scan().expect("it runs");
    assert_eq!(cpu.words("IR", 0, 1), Some(vec![0x8002]));
    assert_eq!((cpu.value_named("HR0107"), cpu.value_named("HR1")), (Some(1), Some(0x80)));
    assert!(cpu.set_named("00001", 0));
    assert_eq!((cpu.value_named("00001"), cpu.value_named("00015")), (Some(0), Some(1)));
    assert!(!cpu.set_named("00016", 1) && !cpu.set_named("XY7", 1) && !cpu.set_named("", 1));
    assert!(cpu.set_named("DM0010", 7) && cpu.value_named("DM10") == Some(7));
}

#[test]
fn set_values_are_found_by_name_number_and_program_address() {
    let text = "LD 00000\nTIM 005 #0012\nLD 00001\nTIM 005 #0034\nLD 00000\nLD 00001\nCNT 006 HR 02\nEND\n";
    let program = c200h(text);
    let times = times(&program, Picos::ZERO);
    let mut cpu = cpu(&program, &times);
    let timer = |cpu: &mut Cpu<'_>, from| cpu.setting(Coil::Timer, 5, from);
    assert_eq!(timer(&mut cpu, 0), Some(Setting::Number(12)));
    assert_eq!(timer(&mut cpu, 1), Some(Setting::Number(12)));
    assert_eq!(timer(&mut cpu, 2), Some(Setting::Number(34)));
    assert_eq!(timer(&mut cpu, 4), None);
    assert_eq!(cpu.setting(Coil::FastTimer, 5, 0), None);
    assert_eq!(cpu.setting(Coil::Counter, 6, 0), Some(Setting::Word { area: "HR", index: 2 }));
}

#[test]
fn timers_that_count_up_are_over_at_their_setting() {
    let input = |text: &str| Input { name: "a.il".to_owned(), bytes: text.as_bytes().to_vec() };
    let facts = Facts::default();
    let text = "LD X0\nOUT T0 K3\nLD X0\nOUTH T1 K3\nLD X0\nOUT ST2 K3\nLD X1\nRST ST2\nEND\n";
    let options = Options { family: Some("q"), ..Options::new(&facts) };
    let project = scanbound_fronts::read(&[input(text)], Some("melsec-list")).expect("a program");
    let program = project.decode(&options).expect("a sound one");
    let times = times(&program, Picos::ZERO);
    let mut cpu = cpu(&program, &times);
    let see = |cpu: &mut Cpu<'_>, ms: u64| {
        while cpu.clock() < Picos(ms * MS) {
            cpu.scan().expect("it runs");
        }
        let flags = cpu.bits("TS", 0, 2).expect("flags");
        let values = cpu.words("TN", 0, 2).expect("values");
        let st = (cpu.bits("ST", 2, 1).expect("a flag")[0], cpu.words("ST value ", 2, 1));
        (flags, values, st.0, st.1.expect("a value")[0])
    };
    let x = ["X0", "X1"].map(|name| cpu.named(name).expect("an input"));
    cpu.set(x[0], 1);
    assert_eq!(see(&mut cpu, 15), (vec![false, false], vec![0, 1], false, 0));
    assert_eq!(see(&mut cpu, 35), (vec![false, true], vec![0, 3], false, 0));
    assert_eq!(see(&mut cpu, 210), (vec![false, true], vec![2, 3], false, 2));
    cpu.set(x[0], 0);
    // The one that is not retentive begins anew.
    assert_eq!(see(&mut cpu, 420), (vec![false, false], vec![0, 0], false, 2));
    cpu.set(x[0], 1);
    assert_eq!(see(&mut cpu, 510), (vec![false, true], vec![1, 3], true, 3));
    cpu.set(x[1], 1);
    cpu.set(x[0], 0);
    assert_eq!(see(&mut cpu, 520), (vec![false, false], vec![0, 0], false, 0));
    assert_eq!(cpu.halted(), None);
}
