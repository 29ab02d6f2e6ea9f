//! Tests of the machine: the description's test program, every word, and random programs against an independent
//! evaluation of what their ladder means.

use super::stimulus::{Change, Stimulus, What};
use super::*;
use proptest::prelude::*;
use scanbound_front_minasec::{Device, DeviceKind, Opcode, WORDS, Word, assembly};
use std::collections::BTreeMap;

const TEST_PROGRAM: &str = include_str!("../../../../samples/minasec-u/test-program.asm");
const TEST_STIMULUS: &str = include_str!("../../../../samples/minasec-u/test-program.stimulus.csv");
const SECOND: u64 = 1_000_000_000_000;

fn words(text: &str) -> [Word; WORDS] {
    assembly::read("test.asm", text).expect("a program").words
}

fn device(name: &str) -> Device {
    Device::from_name(name).expect(name)
}

fn run(words: [Word; WORDS], settings: &Settings, stimulus: &Stimulus, until: u64) -> Vec<Scan> {
    let mut machine = Machine::new(words, settings, stimulus);
    let mut scans = Vec::new();
    while let Some(scan) = machine.scan(&mut ()).filter(|scan| scan.start.0 < until) {
        scans.push(scan);
    }
    scans
}

/// The last scan that has ended by then, in tenths of a second.
fn at(scans: &[Scan], tenths: u64) -> View {
    let time = tenths * (SECOND / 10);
    scans.iter().rfind(|scan| scan.start.0 + scan.time.0 <= time).expect("a scan").view
}

fn test_run() -> Vec<Scan> {
    let stimulus = Stimulus::parse("s.csv", TEST_STIMULUS.as_bytes()).expect("a stimulus");
    run(words(TEST_PROGRAM), &Settings::default(), &stimulus, 30 * SECOND)
}

/// When the count changed, and to what.
fn counts(scans: &[Scan]) -> Vec<(u64, u8)> {
    scans
        .windows(2)
        .filter(|pair| pair[0].view.count != pair[1].view.count)
        .map(|pair| (pair[1].start.0, pair[1].view.count))
        .collect()
}

#[test]
fn the_test_program_counts_every_two_seconds() {
    let scans = test_run();
    let counts = counts(&scans);
    let up: Vec<_> = counts.iter().take(10).collect();
    assert_eq!(
        up.iter().map(|(_, count)| *count).collect::<Vec<_>>(),
        (1..=10).collect::<Vec<_>>()
    );
    // The flicker takes up to four scans more than the two delays.
    for pair in up.windows(2) {
        let apart = pair[1].0 - pair[0].0;
        assert!((2 * SECOND..2 * SECOND + 4 * 8_448_000_000).contains(&apart), "{apart}");
    }
    // The first comes 1 s after the start, and the filter's 10 ms and up to three scans.
    let first = up[0].0 - SECOND / 10;
    assert!(
        (SECOND + 10_000_000_000..SECOND + 10_000_000_000 + 3 * 8_448_000_000).contains(&first)
    );
}

#[test]
fn the_test_program_lights_the_lamp_at_10_and_stops_counting() {
    let scans = test_run();
    let lamp = |view: View| view.outputs >> 1 & 1 == 1;
    // The clear stands behind the lamp in the program: the lamp follows it a scan later.
    for pair in scans.windows(2) {
        let equal = pair.iter().map(|scan| scan.view.device(Device::C0)).collect::<Vec<_>>();
        if equal[0] == equal[1] {
            assert_eq!(lamp(pair[1].view), equal[1], "{pair:?}");
        }
    }
    assert!(!lamp(at(&scans, 190)) && lamp(at(&scans, 219)));
    assert_eq!(at(&scans, 219).count, 10);
}

#[test]
fn the_test_program_clears_on_x02_and_stops_on_x01() {
    let scans = test_run();
    assert_eq!(at(&scans, 221).count, 0);
    assert_eq!(at(&scans, 221).outputs, 0b01);
    let stopped = at(&scans, 279);
    assert_eq!((stopped.outputs, stopped.count), (0, 2), "stopped, the count as it was");
    assert_eq!(at(&scans, 269).count, 2);
}

#[test]
fn the_test_program_keeps_its_count_without_power_and_nothing_else() {
    let stimulus = "time_s,X00,POWER\n0,1,\n1,0,\n6,,0\n7,,1\n";
    let stimulus = Stimulus::parse("s.csv", stimulus.as_bytes()).expect("a stimulus");
    let scans = run(words(TEST_PROGRAM), &Settings::default(), &stimulus, 9 * SECOND);
    let (before, after) = (at(&scans, 60), at(&scans, 71));
    assert_eq!((before.count, before.outputs), (3, 1));
    assert_eq!((after.count, after.outputs), (3, 0), "it does not run again by itself");
    assert!(
        !scans.iter().any(|scan| (6 * SECOND..7 * SECOND).contains(&(scan.start.0 + scan.time.0)))
    );
    assert_eq!(
        scans.iter().find(|scan| scan.start.0 >= 6 * SECOND).map(|s| s.start.0),
        Some(7 * SECOND)
    );
}

#[test]
fn the_reset_switch_and_the_clear_button_do_what_their_names_say() {
    let stimulus = "time_s,X00,RESET,CNTCLR\n0,1,,\n1,0,,\n6,,1,\n6.5,,0,\n7,,,1\n7.1,,,0\n";
    let stimulus = Stimulus::parse("s.csv", stimulus.as_bytes()).expect("a stimulus");
    let scans = run(words(TEST_PROGRAM), &Settings::default(), &stimulus, 8 * SECOND);
    assert_eq!((at(&scans, 69).count, at(&scans, 69).outputs), (3, 0));
    assert_eq!(at(&scans, 72).count, 0);
}

#[test]
fn a_scan_takes_256_clocks() {
    let scans = test_run();
    assert!(scans.iter().all(|scan| scan.time == Picos(8_448_000_000)));
    let slow = Settings { clock: Clock { slow: true, ..Clock::default() }, ..Settings::default() };
    let scans = run(words("LD X00"), &slow, &Stimulus::default(), 1);
    assert_eq!(scans[0].time, Picos(8_448_000_000 * 32_768));
}

#[test]
fn a_trembling_clock_gives_scans_around_the_boards_own() {
    let clock = |seed| Clock {
        tolerance: Fraction(50_000),
        jitter: Fraction(10_000),
        seed,
        ..Clock::default()
    };
    let times = |seed| -> Vec<Picos> {
        let settings = Settings { clock: clock(seed), ..Settings::default() };
        run(words("LD X00"), &settings, &Stimulus::default(), 2 * SECOND)
            .iter()
            .map(|scan| scan.time)
            .collect()
    };
    let (one, two) = (times(1), times(2));
    assert_eq!(one, times(1));
    assert_ne!(one, two);
    assert!(one.iter().any(|time| *time != one[0]));
    let most = clock(1).longest().times(256);
    assert!(one.iter().chain(&two).all(|&time| time <= most));
}

#[test]
fn inputs_are_latched_and_outputs_shown_at_the_scans_edges() {
    // X00 comes on in the middle of the second scan: the third sees it, and shows it at its end.
    let settings = Settings { filter: Picos::ZERO, ..Settings::default() };
    let stimulus = Stimulus {
        changes: vec![Change { at: Picos(8_448_000_000 + 1), what: What::Input(0), on: true }],
    };
    let program = words("LD X00\nST Y00\nLD Y00\nST M00\n");
    let scans = run(program, &settings, &stimulus, SECOND);
    let seen: Vec<_> = scans
        .iter()
        .take(3)
        .map(|scan| (scan.view.inputs(), scan.view.outputs, scan.view.device(device("M00"))))
        .collect();
    assert_eq!(seen, [(0, 0, false), (0, 0, false), (1, 1, true)]);
}

#[test]
fn a_timer_closes_within_a_scan_and_opens_with_its_coil() {
    // SLOW: a word takes 1.08 s, so T0 (0.5 s) has closed by the next word but not in the same.
    let settings = Settings {
        clock: Clock { slow: true, ..Clock::default() },
        t0: Picos(SECOND / 2),
        t1: Picos(3 * SECOND),
        ..Settings::default()
    };
    let program = words(
        "LDI C0CLR\nST T0\nST T1\nLD T0\nST M00\nLD T1\nST M01\nLDI T1\nSTI T0\nLD T0\nST M02\nLDI C0CLR\nSTI T0\nLD T0\nST M03",
    );
    let view = run(program, &settings, &Stimulus::default(), 1)[0].view;
    let relay = |name: &str| view.device(device(name));
    assert!(relay("M00"), "T0 has run out after two words");
    assert!(relay("M01"), "T1 has run out after three words and a half");
    assert!(relay("M02"), "T0 was left on");
    assert!(!relay("M03"), "T0 opens with its coil");
    assert_eq!(view.coils, 0b10);
}

#[test]
fn every_word_does_what_the_descriptions_tables_say() {
    for byte in 0..=255_u8 {
        let word = Word(byte);
        for (accumulator, value) in [(false, false), (false, true), (true, false), (true, true)] {
            one_word(word, accumulator, value);
        }
    }
}

/// Runs a word with the accumulator and the device at given values, and compares with the truth table.
fn one_word(word: Word, accumulator: bool, value: bool) {
    let mut program = [Word::default(); WORDS];
    let device_used = word.device();
    let always_off = Device::CLEAR;
    let load = |on: bool| Word::new(if on { Opcode::Ldi } else { Opcode::Ld }, always_off);
    let mut settings = Settings { filter: Picos::ZERO, setting: 1, ..Settings::default() };
    let mut stimulus = Stimulus::default();
    let mut next = 0;
    let mut put = |word: Word| {
        program[next] = word;
        next += 1;
    };
    // Bring the device to its value.
    match device_used.kind() {
        DeviceKind::Input => stimulus.changes.push(Change {
            at: Picos::ZERO,
            what: What::Input(device_used.address()),
            on: value,
        }),
        DeviceKind::Output | DeviceKind::Relay => {
            put(load(value));
            put(Word::new(Opcode::St, device_used));
        }
        DeviceKind::Timer => {
            settings.clock.slow = true;
            put(load(value));
            put(Word::new(Opcode::St, device_used));
        }
        DeviceKind::Counter => settings.count = u8::from(value),
        DeviceKind::Clear => {}
    }
    let reads = value && device_used.kind() != DeviceKind::Clear;
    put(load(accumulator));
    put(word);
    // The accumulator is seen through a relay that the word does not use.
    let witness = if device_used == device("M00") { device("M01") } else { device("M00") };
    put(Word::new(Opcode::St, witness));
    let view = run(program, &settings, &stimulus, 1)[0].view;
    let expected = match word.opcode() {
        Opcode::Ld => reads,
        Opcode::Ldi => !reads,
        Opcode::And => accumulator && reads,
        Opcode::Andi => accumulator && !reads,
        Opcode::Or => accumulator || reads,
        Opcode::Ori => accumulator || !reads,
        Opcode::St | Opcode::Sti => accumulator,
    };
    let case = format!("{word}, accumulator {accumulator}, device {value}");
    assert_eq!(view.device(witness), expected, "{case}");
    let stored = match word.opcode() {
        Opcode::St => Some(accumulator),
        Opcode::Sti => Some(!accumulator),
        _ => None,
    };
    let Some(stored) = stored else { return };
    match device_used.kind() {
        DeviceKind::Input => {
            assert_eq!(view.device(device_used), value, "{case}: inputs have no latch")
        }
        DeviceKind::Output | DeviceKind::Relay => {
            assert_eq!(view.device(device_used), stored, "{case}")
        }
        DeviceKind::Timer => {
            assert_eq!(view.coils >> (device_used.address() - 28) & 1 == 1, stored, "{case}")
        }
        // With setting 1, a rising edge counts from 0 to 1, and no further.
        DeviceKind::Counter => assert_eq!(view.count, u8::from(value || stored), "{case}"),
        DeviceKind::Clear => assert_eq!(view.count, 0, "{case}"),
    }
}

/// A rung: series and parallel contacts, and the coils that it drives.
#[derive(Debug, Clone)]
enum Contacts {
    One(u8, bool),
    Series(Vec<Contacts>),
    Parallel(Vec<Contacts>),
}

#[derive(Debug, Clone)]
struct Rung {
    contacts: Contacts,
    coils: Vec<(u8, bool)>,
}

/// Relays M10 to M13 are the compiler's temporary stores, one a level of nesting.
const TEMPORARY: u8 = 24;

fn contacts() -> impl Strategy<Value = Contacts> {
    let readable =
        prop_oneof![4 => 0..TEMPORARY, 1 => Just(28), 1 => Just(29), 1 => Just(30), 1 => Just(31)];
    let one =
        (readable, any::<bool>()).prop_map(|(device, inverse)| Contacts::One(device, inverse));
    one.prop_recursive(2, 12, 3, |inner| {
        prop_oneof![
            prop::collection::vec(inner.clone(), 1..4).prop_map(Contacts::Series),
            prop::collection::vec(inner, 1..4).prop_map(Contacts::Parallel),
        ]
    })
}

fn rungs() -> impl Strategy<Value = Vec<Rung>> {
    let coil = prop_oneof![4 => 8..TEMPORARY, 1 => 28..=31_u8];
    let coils = prop::collection::vec((coil, prop::bool::weighted(0.2)), 1..3);
    let rung = (contacts(), coils).prop_map(|(contacts, coils)| Rung { contacts, coils });
    prop::collection::vec(rung, 1..8)
}

/// Compiles contacts so that the accumulator ends as their value, by the description's rules: a branch that is
/// no single contact goes through a temporary relay.
fn compile(contacts: &Contacts, level: u8, code: &mut Vec<Word>) {
    let (parts, join, relay_join) = match contacts {
        Contacts::One(device, inverse) => {
            let opcode = if *inverse { Opcode::Ldi } else { Opcode::Ld };
            code.push(Word::new(opcode, Device::at(*device)));
            return;
        }
        Contacts::Series(parts) => (parts, [Opcode::And, Opcode::Andi], Opcode::And),
        Contacts::Parallel(parts) => (parts, [Opcode::Or, Opcode::Ori], Opcode::Or),
    };
    compile(&parts[0], level + 1, code);
    for part in &parts[1..] {
        if let Contacts::One(device, inverse) = part {
            code.push(Word::new(join[usize::from(*inverse)], Device::at(*device)));
        } else {
            let relay = Device::at(TEMPORARY + level);
            code.push(Word::new(Opcode::St, relay));
            compile(part, level + 1, code);
            code.push(Word::new(relay_join, relay));
        }
    }
}

/// An independent evaluation of a ladder: devices by name, rungs as Boolean formulas. It knows nothing of words
/// and of the accumulator.
struct Ladder {
    devices: BTreeMap<u8, bool>,
    /// Coils of the timers: on since which scan's beginning, by the word that closed them.
    timers: BTreeMap<u8, Option<u64>>,
    clock: bool,
    clear: bool,
    count: u8,
}

impl Ladder {
    fn value(&self, device: u8, now: u64) -> bool {
        match device {
            28 | 29 => self.timers[&device].is_some_and(|since| now - since >= SECOND),
            30 => self.count == 3,
            31 => false,
            _ => self.devices.get(&device).copied().unwrap_or(false),
        }
    }

    fn evaluate(&self, contacts: &Contacts, times: &mut impl Iterator<Item = u64>) -> bool {
        match contacts {
            Contacts::One(device, inverse) => {
                self.value(*device, times.next().expect("a time")) != *inverse
            }
            Contacts::Series(parts) => self.all(parts, times).iter().all(|&on| on),
            Contacts::Parallel(parts) => self.all(parts, times).iter().any(|&on| on),
        }
    }

    fn all(&self, parts: &[Contacts], times: &mut impl Iterator<Item = u64>) -> Vec<bool> {
        parts.iter().map(|part| self.evaluate(part, times)).collect()
    }

    fn drive(&mut self, device: u8, on: bool, now: u64) {
        match device {
            28 | 29 => {
                let since = self.timers.get_mut(&device).expect("a timer");
                *since = if on { since.or(Some(now)) } else { None };
            }
            30 => {
                if on && !self.clock && self.count != 3 && !self.clear {
                    self.count += 1;
                }
                self.clock = on;
            }
            31 => {
                self.clear = on;
                if on {
                    self.count = 0;
                }
            }
            _ => {
                self.devices.insert(device, on);
            }
        }
    }
}

/// When each contact and each coil of a compiled program is read or written, within a scan.
fn times_of(code: &[Word]) -> (Vec<u64>, Vec<u64>) {
    let at = |index: usize| 33_000_000 * index as u64 + 16_500_000;
    let (mut contacts, mut coils) = (Vec::new(), Vec::new());
    for (index, word) in code.iter().enumerate() {
        let temporary = (TEMPORARY..28).contains(&word.device().address());
        match (word.opcode().is_store(), temporary) {
            (_, true) => {}
            (true, false) => coils.push(at(index)),
            (false, false) => contacts.push(at(index)),
        }
    }
    (contacts, coils)
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 300, ..ProptestConfig::default() })]

    #[test]
    fn random_ladders_mean_the_same_to_the_machine_and_to_their_formulas(
        rungs in rungs(),
        inputs in prop::collection::vec(any::<u8>(), 1..12),
    ) {
        let mut code = Vec::new();
        for rung in &rungs {
            compile(&rung.contacts, 0, &mut code);
            for (device, inverse) in &rung.coils {
                let opcode = if *inverse { Opcode::Sti } else { Opcode::St };
                code.push(Word::new(opcode, Device::at(*device)));
            }
        }
        prop_assume!(code.len() <= WORDS);
        let mut program = [Word::default(); WORDS];
        program[..code.len()].copy_from_slice(&code);
        // Inputs change every 40 scans, so that timers of 1 s run out now and then.
        let scan = 8_448_000_000_u64;
        let each = 40 * scan;
        let mut stimulus = Stimulus::default();
        for (turn, bits) in inputs.iter().enumerate() {
            for bit in 0..8 {
                stimulus.changes.push(Change {
                    at: Picos(turn as u64 * each),
                    what: What::Input(bit),
                    on: bits >> bit & 1 == 1,
                });
            }
        }
        let settings = Settings { filter: Picos::ZERO, setting: 3, ..Settings::default() };
        let mut machine = Machine::new(program, &settings, &stimulus);
        let mut ladder = Ladder {
            devices: BTreeMap::new(),
            timers: BTreeMap::from([(28, None), (29, None)]),
            clock: false,
            clear: false,
            count: 0,
        };
        let (contact_times, coil_times) = times_of(&code);
        for index in 0..inputs.len() as u64 * 40 {
            let start = index * scan;
            for bit in 0..8 {
                ladder.devices.insert(bit, inputs[(index / 40) as usize] >> bit & 1 == 1);
            }
            let mut contacts = contact_times.iter().map(|time| start + time);
            let mut coils = coil_times.iter().map(|time| start + time);
            for rung in &rungs {
                let on = ladder.evaluate(&rung.contacts, &mut contacts);
                for &(device, inverse) in &rung.coils {
                    ladder.drive(device, on != inverse, coils.next().expect("a time"));
                }
            }
            let scanned = machine.scan(&mut ()).expect("a scan");
            for device in Device::all().filter(|device| !(TEMPORARY..28).contains(&device.address())) {
                let expected = ladder.value(device.address(), start + scan);
                prop_assert_eq!(scanned.view.device(device), expected, "{} in scan {}", device, index);
            }
            prop_assert_eq!(scanned.view.count, ladder.count);
            prop_assert_eq!(scanned.view.outputs, (scanned.view.devices >> 8) as u8);
        }
    }

    #[test]
    fn random_memories_do_what_their_words_say_one_by_one(
        bytes in prop::array::uniform32(any::<u8>()),
        inputs in prop::collection::vec(any::<u8>(), 1..6),
    ) {
        let mut program = [Word::default(); WORDS];
        for (word, byte) in program.iter_mut().zip(bytes.iter().cycle()) {
            *word = Word(*byte);
        }
        let scan = 8_448_000_000_u64;
        let changes = inputs.iter().enumerate().flat_map(|(turn, bits)| {
            (0..8).map(move |bit| Change {
                at: Picos(turn as u64 * scan),
                what: What::Input(bit),
                on: bits >> bit & 1 == 1,
            })
        });
        let stimulus = Stimulus { changes: changes.collect() };
        let settings = Settings { filter: Picos::ZERO, setting: 3, ..Settings::default() };
        let mut machine = Machine::new(program, &settings, &stimulus);
        let mut ladder = Ladder {
            devices: BTreeMap::new(),
            timers: BTreeMap::from([(28, None), (29, None)]),
            clock: false,
            clear: false,
            count: 0,
        };
        let mut accumulator = false;
        for (turn, bits) in inputs.iter().enumerate() {
            let start = turn as u64 * scan;
            for bit in 0..8 {
                ladder.devices.insert(bit, bits >> bit & 1 == 1);
            }
            for (index, word) in program.iter().enumerate() {
                let now = start + 33_000_000 * index as u64 + 16_500_000;
                let device = word.device().address();
                let read = ladder.value(device, now);
                match word.to_string().split(' ').next().expect("a mnemonic") {
                    "LD" => accumulator = read,
                    "LDI" => accumulator = !read,
                    "AND" => accumulator &= read,
                    "ANDI" => accumulator &= !read,
                    "OR" => accumulator |= read,
                    "ORI" => accumulator |= !read,
                    _ if device < 8 => {}
                    "ST" => ladder.drive(device, accumulator, now),
                    _ => ladder.drive(device, !accumulator, now),
                }
            }
            let scanned = machine.scan(&mut ()).expect("a scan");
            for device in Device::all() {
                let expected = ladder.value(device.address(), start + scan);
                prop_assert_eq!(scanned.view.device(device), expected, "{} in scan {}", device, turn);
            }
            prop_assert_eq!(scanned.view.count, ladder.count);
        }
    }
}
