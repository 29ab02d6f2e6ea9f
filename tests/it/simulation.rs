//! Programs that run scan by scan from power-up: what they do is what their languages say, and no scan takes longer
//! than the bound.

use scanbound::audit::{Request, audit, ready};
use scanbound::base::facts::Facts;
use scanbound::base::time::Picos;
use scanbound::front::Input;
use scanbound::front::input::{Ignore, gather};
use scanbound::simulation::recording::{End, Recording};
use scanbound::simulation::signals::{Signal, Signals, Value};
use scanbound::simulation::{Change, Length, simulate, stimulus, vcd};
use std::path::PathBuf;

const MS: u64 = 1_000_000_000;

/// Runs a program with a stimulus for a time. The CPU is for MELSEC and OMRON programs.
fn run(name: &str, text: &str, cpu: Option<&str>, changes: &str, ms: u64) -> Recording {
    let inputs = [Input { name: name.to_owned(), bytes: text.as_bytes().to_vec() }];
    let facts = Facts::default();
    let request = Request { cpu, ..Request::new(&inputs, &facts) };
    let ready = ready(&request).unwrap_or_else(|failure| panic!("{failure:?}"));
    let signals = Signals::of(&ready.program);
    let changes = stimulus(&signals, "s.csv", changes.as_bytes());
    let changes = changes.unwrap_or_else(|faults| panic!("{faults:?}"));
    let costs = (&ready.prices.times()[..], ready.prices.overhead_sum());
    let length = Length { scans: u64::MAX, end: Some(Picos(ms * MS)) };
    simulate(&ready.program, costs, &signals, &[], &changes, length)
}

/// When a signal changed to which value: the times in milliseconds at which the scans began, rounded down.
fn changes(recording: &Recording, name: &str) -> Vec<(u64, Value)> {
    let number = recording.signals.iter().position(|(signal, _)| signal.name == name);
    let Some(number) = number else { return Vec::new() };
    let scans = recording.scans.iter();
    let all = scans.flat_map(|scan| scan.after.iter().map(move |change| (scan.start, change)));
    let own = all.filter(|(_, (at, _))| *at == number);
    own.map(|(start, (_, value))| (start.0 / MS, *value)).collect()
}

#[test]
fn a_timer_runs_by_the_times_of_scans() {
    let text = "LD X0\nOUT T0 K5\nLD T0\nOUT Y10\nEND\n";
    let recording = run("a.il", text, Some("Q26UDV"), "time_ms,X0\n10,1\n800,0\n", 1000);
    assert_eq!(recording.end, None);
    let [(on, Value::Whole(1)), (off, Value::Whole(0))] = changes(&recording, "Y10")[..] else {
        panic!("{:?}", changes(&recording, "Y10"))
    };
    // A timer of 100 ms ticks may end up to one tick early or late.
    assert!((410..=610).contains(&on) && (800..=801).contains(&off), "{on} {off}");
}

#[test]
fn bits_of_words_and_present_values_of_omron_programs_are_signals() {
    let text = "LD 0.00\nTIM 0000 #0005\nLD T0000\nOUT 100.00\nEND(001)\n";
    let recording = run("a.il", text, Some("CJ2M"), "time_ms,0.00\n10,1\n", 1000);
    let [(on, Value::Whole(1))] = changes(&recording, "CIO100.0")[..] else {
        panic!("{:?}", recording.signals)
    };
    assert!((410..=610).contains(&on), "{on}");
}

#[test]
fn each_qualifier_of_an_action_does_what_the_standard_says() {
    // The step is active from 100 ms to 3100 ms; a scan begins every 100 ms.
    for (qualifier, expected) in [
        ("N", &[(100, 1), (3100, 0)][..]),
        ("S", &[(100, 1)]),
        ("L, T#1s", &[(100, 1), (1100, 0)]),
        ("D, T#1s", &[(1100, 1), (3100, 0)]),
        ("SD, T#1s", &[(1100, 1)]),
        ("SL, T#1s", &[(100, 1), (1100, 0)]),
        ("DS, T#1s", &[(1100, 1)]),
        ("SD, T#5s", &[(5100, 1)]),
        ("DS, T#5s", &[]),
        ("SL, T#5s", &[(100, 1), (5100, 0)]),
    ] {
        let text = format!(
            "PROGRAM p VAR go AT %IX0.0 : BOOL; a : BOOL; END_VAR INITIAL_STEP S0: END_STEP STEP S1: a({qualifier}); END_STEP \
             STEP S2: END_STEP TRANSITION FROM S0 TO S1 := TRUE; END_TRANSITION TRANSITION FROM S1 TO S2 := go; END_TRANSITION END_PROGRAM \
             CONFIGURATION c RESOURCE r ON plc TASK t(INTERVAL := T#100ms, PRIORITY := 1); PROGRAM main WITH t : p; END_RESOURCE END_CONFIGURATION"
        );
        let recording = run("p.st", &text, None, "time_ms,go\n3050,1\n", 7000);
        assert_eq!(recording.end, None, "{qualifier}");
        let expected = expected.iter().map(|&(at, value)| (at, Value::Whole(value)));
        assert_eq!(changes(&recording, "main.a"), expected.collect::<Vec<_>>(), "{qualifier}");
    }
}

#[test]
fn timers_of_blocks_and_steps_run_on() {
    let text = "PROGRAM main VAR go AT %IX0.0 : BOOL; t : TON; q : BOOL; e : TIME; END_VAR \
        t(IN := go, PT := T#1s); q := t.Q; e := t.ET; END_PROGRAM \
        CONFIGURATION c RESOURCE r ON plc TASK k(INTERVAL := T#100ms); PROGRAM main WITH k : main; END_RESOURCE END_CONFIGURATION";
    let recording = run("p.st", text, None, "time_ms,go\n200,1\n1900,0\n", 3000);
    let [(on, Value::Whole(1)), (off, Value::Whole(0))] = changes(&recording, "main.q")[..] else {
        panic!("{:?}", changes(&recording, "main.q"))
    };
    assert!((1200..=1300).contains(&on) && off == 1900, "{on} {off}");
    let elapsed = changes(&recording, "main.e");
    assert!(elapsed.contains(&(700, Value::Time(1000))), "{elapsed:?}");
}

/// A timer of a flowchart that was not reset goes on with its remaining time, so that the output is on for less than
/// the 3 s of its setting after a second start: what the document on flowchart PCs says of its figure 3.12.
#[test]
fn a_flowchart_timer_goes_on_with_its_remaining_time() {
    let text = "LBL0: AND 0\nCJP LBL1\nJMP LBL0\nLBL1: AND 1\nCJP LBL2\nTIM 10\n#30\nCJP LBL2\nOUT 200\nJMP LBL1\n\
        LBL2: OUT\u{b7}NOT 200\nJMP LBL0\n";
    let first = "100,1,0\n200,0,0\n";
    let alone = run("a.lst", text, None, &format!("time_ms,IN0,IN1\n{first}"), 6000);
    let [(100, Value::Whole(1)), (off, Value::Whole(0))] = changes(&alone, "OUT200")[..] else {
        panic!("{:?}", changes(&alone, "OUT200"))
    };
    assert!((3000..=3300).contains(&off), "{off}");
    let again = "1000,0,1\n1100,0,0\n2000,1,0\n2100,0,0\n";
    let both = run("a.lst", text, None, &format!("time_ms,IN0,IN1\n{first}{again}"), 6000);
    let expected = [(100, 1), (1000, 0), (2000, 1), (off, 0)];
    let expected = expected.map(|(at, value)| (at, Value::Whole(value)));
    assert_eq!(changes(&both, "OUT200"), expected);
}

#[test]
fn variables_have_values_of_their_types() {
    let text = "PROGRAM main VAR n : INT := 5; big : DINT; u : UINT; r : REAL := 1.5; t : TIME := T#1500ms; \
        a : ARRAY[1..3] OF INT; w : BYTE; END_VAR \
        big := big - 70000; u := 65535; r := r * 2.0; a[2] := n; n := -n; w := 200; t := t + T#1ms; END_PROGRAM";
    let recording = run("main.st", text, None, "time_ms,n,t,r\n1,7,2000,0.25\n", 1);
    let last = |name: &str| changes(&recording, name).first().map(|(_, value)| *value);
    assert_eq!(last("main.big"), Some(Value::Whole(-70_000)));
    assert_eq!(last("main.u"), Some(Value::Whole(65_535)));
    assert_eq!(last("main.w"), Some(Value::Whole(200)));
    assert_eq!(last("main.r"), Some(Value::Real(3.0)));
    assert_eq!(last("main.t"), Some(Value::Time(3002)));
    assert_eq!(last("main.a[2]"), Some(Value::Whole(5)));
    let text = recording.text();
    assert!(text.contains("main.t=1501ms") && text.contains("main.n=-5"), "{text}");
}

#[test]
fn faults_of_a_stimulus_have_their_places() {
    let inputs = [Input { name: "a.il".to_owned(), bytes: b"LD X0\nMOV K1 D0\nEND\n".to_vec() }];
    let facts = Facts::default();
    let request = Request { cpu: Some("Q26UDV"), ..Request::new(&inputs, &facts) };
    let program = ready(&request).expect("a program").program;
    let signals = Signals::of(&program);
    let faults = stimulus(&signals, "s.csv", b"time_ms,x0,D0,Motor\n1,2,65535,1\n2,1,-32769,0\n");
    let faults: Vec<_> = { faults.expect_err("faults") }
        .into_iter()
        .map(|fault| (fault.line.unwrap_or(0), fault.message))
        .collect();
    let told = [
        (1, "the program has no device or variable 'Motor'"),
        (2, "'2' is not a value of X0"),
        (3, "'-32769' is not a value of D0"),
    ];
    assert_eq!(faults, told.map(|(line, message)| (line, message.to_owned())));
}

#[test]
fn a_run_ends_at_an_operation_error() {
    let ends = |body: &str| {
        let text = format!("PROGRAM main VAR n, k : INT; END_VAR n := n + 1; {body} END_PROGRAM");
        let recording = run("main.st", &text, None, "time_ms\n", 1);
        (recording.scans.len(), recording.end)
    };
    let (scans, end) = ends("k := 7 / (3 - n);");
    assert!(scans == 2 && matches!(end, Some(End::Error(_))), "{scans} {end:?}");
    let (scans, end) = ends("k := 7 / n;");
    assert!(scans > 2 && end.is_none(), "{scans} {end:?}");
}

/// No scan of a sample that is run with its inputs off, all on, or changing at random takes longer than its bound.
#[test]
fn no_scan_of_a_sample_takes_longer_than_its_bound() {
    let mut scans = 0;
    for (path, cpu, facts) in [
        ("transfer-line/line.il", Some("Q26UDV"), Some("transfer-line/facts.toml")),
        ("filler", None, None),
        ("drives/drives.il", Some("FX3U"), None),
        ("recipes", None, Some("recipes/facts.toml")),
        ("sorter/sorter.il", Some("CJ2M"), None),
        ("snet/self-holding.il", Some("C200H"), None),
        ("sfc/line.st", None, None),
        ("flowchart/traffic-signals.lst", None, None),
        ("flowchart/star-delta-group.lst", None, None),
    ] {
        let sample =
            |name: &str| PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("samples").join(name);
        let facts = facts.map_or_else(Facts::default, |name| {
            let text = std::fs::read_to_string(sample(name)).expect("the facts");
            Facts::parse(name, &text).expect("facts")
        });
        let ignored = Ignore::parse(std::iter::empty()).expect("no pattern");
        let gathered = gather(&[sample(path)], &ignored).expect("the sample");
        let request = Request { cpu, ..Request::new(&gathered.inputs, &facts) };
        let bound = audit(&request).unwrap_or_else(|failure| panic!("{path} {failure:?}")).bound;
        let ready = ready(&request).expect("a program");
        let signals = Signals::of(&ready.program);
        let costs = (&ready.prices.times()[..], ready.prices.overhead_sum());
        let inputs: Vec<Signal> = signals.inputs();
        assert!(!inputs.is_empty(), "{path}");
        for way in 0..3u64 {
            let changes = (0..60).flat_map(|step: u64| {
                inputs.iter().enumerate().map(move |(at, signal)| {
                    let mixed =
                        (step * 31 + at as u64 * 7 + 11).wrapping_mul(0x9E37_79B9_7F4A_7C15);
                    let is_on = way == 1 || way == 2 && mixed >> 61 & 1 == 1;
                    let words = signal.place.cells().map(|_| u16::from(is_on)).collect();
                    Change { at: Picos(step * 5 * MS), place: signal.place, words }
                })
            });
            let changes: Vec<Change> = changes.collect();
            let length = Length { scans: 300, end: None };
            let recording = simulate(&ready.program, costs, &signals, &[], &changes, length);
            scans += recording.scans.len();
            if let Some((number, longest)) = recording.longest() {
                assert!(longest <= bound.upper, "{path}, scan {number}: {longest}");
            }
            let mut dump = Vec::new();
            vcd::write(&recording, &mut dump).expect("a dump");
            assert!(String::from_utf8_lossy(&dump).contains("$enddefinitions"));
        }
    }
    assert!(scans > 5000, "{scans}");
}
