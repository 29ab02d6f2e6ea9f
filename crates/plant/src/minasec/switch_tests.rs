//! The board's switches and its clock button while a program runs.

use super::stimulus::Stimulus;
use super::{Machine, Observer, Settings, View};
use scanbound_base::time::Picos;
use scanbound_front_minasec::{Device, WORDS, assembly};

/// A word of the nominal clock, in microseconds.
const WORD: u64 = 33;

fn machine(program: &str, stimulus: &str) -> Machine {
    let words = assembly::read("a.asm", program).expect("a program").words;
    let stimulus = Stimulus::parse("s.csv", stimulus.as_bytes()).expect("a stimulus");
    Machine::new(words, &Settings::default(), &stimulus)
}

fn micros(time: Picos) -> u64 {
    time.0 / 1_000_000
}

/// When relay M00 was seen to change, in microseconds.
#[derive(Default)]
struct Seen {
    changes: Vec<(u64, bool)>,
    stopped: Vec<u64>,
}

impl Observer for Seen {
    fn scan(&mut self, _at: Picos, _view: View) {}
    fn change(&mut self, at: Picos, view: View) {
        let relay = view.device(Device::from_name("M00").expect("a relay"));
        if self.changes.last().map_or(relay, |&(_, last)| last != relay) {
            self.changes.push((micros(at), relay));
        }
        if !view.running && self.stopped.last() != Some(&micros(at)) {
            self.stopped.push(micros(at));
        }
    }
}

#[test]
fn while_halted_the_clock_stands_still() {
    // Word 3 has its edge at 115.5 us.
    let program = "LDI X00\nLD Y07\nLDI Y07\nST M00\n";
    for (halt, again) in [(110, 115), (100, 115), (120, 132)] {
        let stimulus = format!("time_us,HALT\n{halt},1\n1000,0\n");
        let mut machine = machine(program, &stimulus);
        let mut seen = Seen::default();
        let scan = machine.scan(&mut seen).expect("a scan");
        assert!(scan.held);
        assert_eq!(seen.stopped.first(), Some(&halt));
        // A word that has not been run begins anew when the clock goes on; one that has is over.
        let edge = if again == 115 { 1000 + 16 } else { 115 };
        assert_eq!(seen.changes, [(edge, true)], "halted at {halt}");
        let left = if again == 115 { WORDS - 3 } else { WORDS - 4 } as u64;
        assert_eq!(micros(scan.time), 1000 + left * WORD);
        let next = machine.scan(&mut ()).expect("a scan");
        assert_eq!((next.held, micros(next.time)), (false, WORDS as u64 * WORD));
    }
}

#[test]
fn the_button_gives_the_clock_by_hand() {
    let mut stimulus = "time_us,HALT,CLOCK\n0,1,\n".to_owned();
    for press in 1..=300 {
        stimulus += &format!("{},,1\n{},,0\n", press * 10, press * 10 + 5);
    }
    let mut machine = machine("LDI X00\nST M00\n", &stimulus);
    let mut seen = Seen::default();
    let scan = machine.scan(&mut seen).expect("a scan");
    // The second press runs the store; the 256th word is left when the button is released.
    assert_eq!(seen.changes, [(20, true)]);
    assert_eq!((scan.held, micros(scan.time)), (true, 2565));
    // The rest is no scan, and nothing goes on.
    assert!(machine.scan(&mut ()).is_none());
}

#[test]
fn a_button_has_no_effect_while_the_clock_runs() {
    let mut machine = machine("LD X00\n", "time_us,CLOCK\n100,1\n200,0\n");
    let scan = machine.scan(&mut ()).expect("a scan");
    assert_eq!((scan.held, micros(scan.time)), (false, WORDS as u64 * WORD));
}

#[test]
fn halted_for_good_there_is_no_scan_and_reset_cuts_it_off() {
    assert!(machine("LD X00\n", "time_us,HALT\n0,1\n").scan(&mut ()).is_none());
    assert!(machine("LD X00\n", "time_us,HALT\n50,1\n").scan(&mut ()).is_none());
    let mut cut = machine("LD X00\n", "time_us,HALT,RESET\n50,1,\n60,,1\n70,0,\n100,,0\n");
    let scan = cut.scan(&mut ()).expect("a scan");
    assert_eq!((micros(scan.start), scan.held), (100, false));
}

#[test]
fn slow_divides_the_clock_from_its_moment_on() {
    let mut machine = machine("LD X00\n", "time_us,SLOW\n8448,1\n2000000,0\n");
    assert_eq!(micros(machine.scan(&mut ()).expect("a scan").time), 8448);
    // Two words are run by 2 s; the third begins anew.
    let scan = machine.scan(&mut ()).expect("a scan");
    assert_eq!(micros(scan.start), 8448);
    assert_eq!(micros(scan.time), 2_000_000 - 8448 + 254 * WORD);
    assert_eq!(micros(machine.scan(&mut ()).expect("a scan").time), 8448);
}
