//! A unit on a pseudo-terminal that is late, disturbed, silent or unplugged: no value is taken from what is no answer.

use super::*;
use crate::hostlink::AREAS;
use crate::pty::Pty;
use std::io::{Read, Write};
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::{self, JoinHandle};

const PATIENCE: Duration = Duration::from_millis(150);

/// What becomes of an answer on its way.
type Fate = Box<dyn FnMut(usize, &[u8], Vec<u8>) -> Vec<(Duration, Vec<u8>)> + Send>;

/// A unit whose words hold their own number, until it is dropped.
struct Unit {
    over: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

struct Numbered;

impl crate::Memory for Numbered {
    fn words(&mut self, _: &str, first: u32, count: u32) -> Option<Vec<u16>> {
        Some((first..first + count).map(|n| n as u16).collect())
    }

    fn bits(&mut self, _: &str, first: u32, count: u32) -> Option<Vec<bool>> {
        Some((first..first + count).map(|n| n % 3 == 0).collect())
    }

    fn setting(&mut self, coil: Coil, number: u32, from: u32) -> Option<Setting> {
        match (coil, from) {
            (Coil::Timer, 0) => Some(Setting::Number(number as u16 * 10)),
            (Coil::Counter, _) => Some(Setting::Word { area: "DM", index: 7 }),
            _ => None,
        }
    }

    fn state(&mut self) -> State {
        State::Run
    }

    fn model(&mut self) -> String {
        String::new()
    }

    fn scan_times(&mut self) -> [u32; 3] {
        [0; 3]
    }
}

impl Unit {
    /// A unit on a line of that name; `fate` gets each answer's number, the request and the answer.
    fn on(link: &Path, mut fate: Fate) -> Unit {
        let mut pty = Pty::open(Some(link), Duration::from_millis(5)).expect("a line");
        let over = Arc::new(AtomicBool::new(false));
        let ends = Arc::clone(&over);
        let thread = thread::spawn(move || {
            let (mut held, mut buffer, mut count) = (Vec::new(), [0; 64], 0);
            let mut due: Vec<(Instant, Vec<u8>)> = Vec::new();
            while !ends.load(Ordering::Relaxed) {
                if let Ok(came) = pty.read(&mut buffer) {
                    held.extend(&buffer[..came]);
                }
                while let Some(end) = held.iter().position(|byte| *byte == b'\r') {
                    let request: Vec<u8> = held.drain(..=end).collect();
                    let Some(back) = hostlink::answer(&request, 0, &mut Numbered) else { continue };
                    let sent = fate(count, &request, back);
                    due.extend(sent.into_iter().map(|(after, one)| (Instant::now() + after, one)));
                    count += 1;
                }
                while due.first().is_some_and(|(when, _)| *when <= Instant::now()) {
                    let _ = pty.write_all(&due.remove(0).1);
                }
            }
        });
        Unit { over, thread: Some(thread) }
    }
}

impl Drop for Unit {
    fn drop(&mut self) {
        self.over.store(true, Ordering::Relaxed);
        let _ = self.thread.take().map(JoinHandle::join);
    }
}

fn at_once(answer: Vec<u8>) -> Vec<(Duration, Vec<u8>)> {
    vec![(Duration::ZERO, answer)]
}

fn device(name: &str) -> Device {
    Device::named(name, AREAS).expect("a device")
}

fn station(link: &Path) -> Station {
    Station::new(&link.display().to_string(), 0, Settings::default(), PATIENCE)
}

/// A directory, and the name of a line in it.
fn place() -> (tempfile::TempDir, std::path::PathBuf) {
    let directory = tempfile::tempdir().expect("a directory");
    let link = directory.path().join("line");
    (directory, link)
}

#[test]
fn everything_that_can_be_asked_is_answered() {
    let (_directory, link) = place();
    let _unit = Unit::on(&link, Box::new(|_, _, answer| at_once(answer)));
    let mut station = station(&link);
    for (name, first) in [("IR5", 5), ("SR253", 253), ("HR9", 9), ("AR27", 27), ("LR63", 63)] {
        assert_eq!(station.words(device(name), 1).expect("a word"), [first]);
    }
    assert_eq!(station.words(device("DM100"), 30).expect("words").len(), 30);
    assert_eq!(station.present(17, 2).expect("values"), [17, 18]);
    assert_eq!(station.flags(3, 4).expect("flags"), [true, false, false, true]);
    assert_eq!(station.number(Coil::Timer, 5).expect("a value"), Setting::Number(50));
    let fault = station.number(Coil::Counter, 5).expect_err("no number");
    assert!(matches!(&fault, Fault::EndCode { code, .. } if code == "16"), "{fault}");
    let word = Setting::Word { area: "DM", index: 7 };
    assert_eq!(station.setting(0, Coil::Counter, 5).expect("a word"), word);
    assert_eq!(station.setting(12_345, Coil::Counter, 5).expect("a word"), word);
    assert_eq!(station.state().expect("a state"), State::Run);
}

#[test]
fn what_comes_late_is_not_the_answer_to_what_is_asked_next() {
    let (_directory, link) = place();
    // The second answer (the first is that to the test) comes when the third request is on its way.
    let late = |count, _: &[u8], answer| match count {
        1 => vec![(PATIENCE + Duration::from_millis(60), answer)],
        _ => at_once(answer),
    };
    let _unit = Unit::on(&link, Box::new(late));
    let mut station = station(&link);
    let fault = station.words(device("DM10"), 1).expect_err("late");
    assert!(matches!(fault, Fault::TimedOut { .. }), "{fault}");
    for number in 20..30 {
        assert_eq!(station.words(device(&format!("DM{number}")), 1).expect("a word"), [number]);
    }
}

#[test]
fn a_wrong_check_sum_is_a_fault_and_the_next_answer_is_good() {
    let (_directory, link) = place();
    let disturbed = |count, _: &[u8], mut answer: Vec<u8>| {
        if count % 4 == 2 {
            answer[8] ^= 1;
        }
        at_once(answer)
    };
    let _unit = Unit::on(&link, Box::new(disturbed));
    let mut station = station(&link);
    let mut faults = 0;
    for number in 0..40 {
        match station.words(device(&format!("DM{number}")), 1) {
            Ok(words) => assert_eq!(words, [number]),
            Err(fault) => {
                assert!(fault.to_string().contains("check sum"), "{fault}");
                faults += 1;
            }
        }
    }
    assert!(faults >= 8, "{faults}");
}

#[test]
fn noise_and_halves_are_never_values() {
    let (_directory, link) = place();
    let noise = |count: usize, _: &[u8], mut answer: Vec<u8>| match count % 5 {
        1 => at_once([b"\xFF\x00@@0".to_vec(), answer].concat()),
        3 => {
            answer.truncate(answer.len() / 2);
            at_once(answer)
        }
        _ => at_once(answer),
    };
    let _unit = Unit::on(&link, Box::new(noise));
    let mut station = station(&link);
    let mut good = 0;
    for number in 0..12 {
        if let Ok(words) = station.words(device(&format!("DM{number}")), 1) {
            assert_eq!(words, [number]);
            good += 1;
        }
    }
    assert!(good >= 2, "{good}");
}

#[test]
fn a_line_that_was_unplugged_is_opened_again() {
    let (_directory, link) = place();
    let good = || -> Fate { Box::new(|_, _, answer| at_once(answer)) };
    let mut station = station(&link);
    let fault = station.words(device("DM1"), 1).expect_err("no line");
    assert!(matches!(fault, Fault::Unreachable { .. }), "{fault}");
    for round in 0..3 {
        let unit = Unit::on(&link, good());
        assert_eq!(station.words(device("DM1"), 1).expect("a word"), [1], "round {round}");
        drop(unit);
        let fault = station.words(device("DM1"), 1).expect_err("unplugged");
        assert!(!station.is_open(), "{fault}");
    }
}
