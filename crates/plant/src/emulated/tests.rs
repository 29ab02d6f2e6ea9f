//! What the emulated CPU's registers hold against the times that its scans take.

use super::*;
use scanbound_base::facts::Facts;
use scanbound_front::{Input, Options};
use scanbound_link::{Memory, registers};

const TENTH: u64 = 100_000_000;

fn program(text: &str, family: &str) -> Program {
    let input = Input { name: "a.il".to_owned(), bytes: text.as_bytes().to_vec() };
    let facts = Facts::default();
    let options = Options { family: Some(family), ..Options::new(&facts) };
    let dialect = if family == "cs" { "omron-cx" } else { "melsec-list" };
    let project = scanbound_fronts::read(&[input], Some(dialect)).expect("a program");
    project.decode(&options).expect("a sound one")
}

pub(super) fn times(program: &Program, each: Picos) -> Vec<Times> {
    vec![Times::new(each, each); program.instructions.len()]
}

#[test]
fn registers_hold_the_scan_time_in_steps() {
    let program = program("LD SM400\nMOV SD520 D0\nMOV SD521 D1\nEND\n", "q");
    let times = times(&program, Picos(250_000_000));
    let quiet = Disturbance::default();
    // Four instructions with 0.25 ms in all, and 2.44 ms of overhead.
    let mut cpu = Cpu::new(&program, &times, Picos(2_440_000_000), registers::of("q"), quiet);
    let mut seen = std::collections::BTreeSet::new();
    for _ in 0..100 {
        assert_eq!(cpu.scan(), Some(Picos(3_440_000_000)));
        let words = cpu.words("SD", 520, 2).expect("registers");
        assert_eq!(words[0], 3);
        seen.insert(words[1]);
    }
    // A clock with steps shows the step below, or the one above.
    assert_eq!(seen, [400, 500].into());
    assert_eq!(cpu.words("SD", 524, 4), Some(vec![3, 400, 3, 500]));
    // The program reads the time of the scan before the last.
    assert_eq!(cpu.words("D", 0, 1), Some(vec![3]));
    assert_eq!(cpu.scans(), 100);
    assert_eq!(cpu.clock(), Picos(344_000_000_000));
}

#[test]
fn what_disturbs_makes_scans_longer_and_never_shorter() {
    let program = program("LD X0\nOUT Y0\nEND\n", "q");
    let times = times(&program, Picos(TENTH));
    let own = Picos(3 * TENTH);
    let jitter = Disturbance { jitter: Picos(TENTH), ..Disturbance::default() };
    let mut cpu = Cpu::new(&program, &times, Picos::ZERO, registers::of("q"), jitter);
    let seen: Vec<Picos> = (0..200).filter_map(|_| cpu.scan()).collect();
    assert!(seen.iter().all(|time| (own..=own + Picos(TENTH)).contains(time)));
    assert!(seen.iter().max() > seen.iter().min());
    // A tenth of a millisecond every millisecond: the program gets nine tenths of the time.
    let interrupt = Some((Picos(TENTH), Picos(10 * TENTH)));
    let interrupted = Disturbance { interrupt, ..Disturbance::default() };
    let mut cpu = Cpu::new(&program, &times, Picos::ZERO, registers::of("q"), interrupted);
    let sum: Picos = (0..900).filter_map(|_| cpu.scan()).sum();
    assert!(sum.0.abs_diff(3000 * TENTH) <= 2 * TENTH, "{sum}");
}

#[test]
fn a_cpu_in_stop_makes_no_scan_and_says_so() {
    let program = program("LD X0\nINC D0\nEND\n", "q");
    let times = times(&program, Picos(TENTH));
    let quiet = Disturbance::default();
    let mut cpu = Cpu::new(&program, &times, Picos::ZERO, registers::of("q"), quiet);
    let x0 = cpu.named("x0").expect("an input");
    cpu.set(x0, 1);
    assert!(cpu.scan().is_some() && cpu.scan().is_some());
    assert_eq!(cpu.words("SD", 203, 1), Some(vec![0]));
    cpu.switch(State::Stop);
    assert_eq!(cpu.scan(), None);
    assert_eq!(cpu.words("SD", 203, 1), Some(vec![2]));
    assert_eq!(cpu.words("D", 0, 1), Some(vec![2]));
    assert_eq!(cpu.bits("X", 0, 2), Some(vec![true, false]));
    assert_eq!(cpu.words("X", 0, 1), Some(vec![1]));
    assert_eq!(cpu.words("Q", 0, 1), None);
    assert_eq!(cpu.words("D", u32::MAX, 2), None);
}

#[test]
fn a_scan_that_nobody_can_follow_ends_in_stop() {
    // The result of RND is unknown.
    let program = program("LD SM400\nRND D0\nLD> D0 K5\nCJ P0\nINC D1\nP0\nEND\n", "q");
    let times = times(&program, Picos(TENTH));
    let quiet = Disturbance::default();
    let mut cpu = Cpu::new(&program, &times, Picos::ZERO, registers::of("q"), quiet);
    assert_eq!(cpu.scan(), None);
    assert_eq!(cpu.halted(), Some(Halt::Unknown(1)));
    assert!(!cpu.running());
}

#[test]
fn each_family_keeps_its_scan_times_in_its_own_registers() {
    let fx = program("LD M8000\nMOV D8010 D0\nEND\n", "fx");
    let times_of_fx = times(&fx, Picos(10 * TENTH));
    let quiet = Disturbance::default();
    let mut cpu = Cpu::new(&fx, &times_of_fx, Picos::ZERO, registers::of("fx"), quiet);
    assert!(cpu.scan().is_some() && cpu.scan().is_some());
    assert_eq!(cpu.words("D", 8010, 3), Some(vec![30; 3]));
    assert_eq!(cpu.words("D", 0, 1), Some(vec![30]));
    assert_eq!(cpu.bits("M", 8000, 1), Some(vec![true]));
    let cs = program("LD P_On\nMOV(021) A264 D0\nEND(001)\n", "cs");
    let times_of_cs = times(&cs, Picos(10 * TENTH));
    let mut cpu = Cpu::new(&cs, &times_of_cs, Picos::ZERO, registers::of("cs"), quiet);
    assert!(cpu.scan().is_some() && cpu.scan().is_some());
    assert_eq!(cpu.words("A", 262, 4), Some(vec![30, 0, 30, 0]));
    assert_eq!(cpu.words("D", 0, 1), Some(vec![30]));
}
