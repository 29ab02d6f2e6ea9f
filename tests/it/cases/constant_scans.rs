//! Constant scans: what sets their time and switches them on, and what of it nobody knows.

use super::watchdogs::{check, run};
use super::{audit, scanbound};
use serde_json::Value;

#[test]
fn a_constant_scan_lasts_as_long_as_it_is_set() {
    let limit = |limit: &str| {
        let arguments =
            format!("check fx-constant-scan.il --cpu FX3U --limit {limit} --refute reached");
        scanbound("fx-constant-scan", &arguments).code
    };
    assert_eq!((limit("10ms"), limit("99.9ms"), limit("100ms")), (Some(1), Some(1), Some(0)));
    // The watchdog counts what is executed.
    assert_eq!(limit("watchdog"), Some(0));
    let report = audit("fx-constant-scan", "fx-constant-scan.il --cpu FX3U");
    assert_eq!(report["scan"]["cycle_ps"], 100_000_000_000_u64);
    assert!(report["scan"]["upper_ps"].as_u64() < Some(1_000_000_000));
}

/// What a program for an FX3U does, what is stated, and the verdict on 10 ms: its scan takes below 1 ms.
const CONSTANT: [(&str, &str, &str, &str); 37] = [
    ("none", "LD X0\nOUT Y0\n", "", "proved"),
    ("set", "LD M8000\nSET M8039\nMOV K20 D8039\n", "", "refuted"),
    // Where X0 is off, something else may have set it.
    ("sometimes", "LD M8000\nOUT M8039\nLD X0\nMOV K5 D8039\n", "", "undecided"),
    ("short", "LD M8000\nSET M8039\nMOV K5 D8039\n", "", "proved"),
    ("by-input", "LD X0\nOUT M8039\nLD M8002\nMOV K20 D8039\n", "", "refuted"),
    ("never", "LD M0\nANI M0\nOUT M8039\nLD M8002\nMOV K20 D8039\n", "", "undecided"),
    ("reset", "LD M8000\nMOV K20 D8039\nRST M8039\n", "", "proved"),
    ("time-alone", "LD M8000\nMOV K20 D8039\n", "", "undecided"),
    ("switch-alone", "LD M8000\nOUT M8039\n", "", "undecided"),
    ("word-alone", "LD M8000\nMOV D5 D8039\n", "", "undecided"),
    // What may be written need not be.
    ("fill", "LD M8000\nOUT M8039\nMOV K5 D8039\nFMOV K50 D8030 K20\n", "", "refuted"),
    ("fill-unknown", "LD M8000\nOUT M8039\nMOV K5 D8039\nFMOV K50 D8030 D20\n", "", "undecided"),
    ("fill-none", "LD M8000\nOUT M8039\nMOV K5 D8039\nFMOV K50 D8039 K0\n", "", "undecided"),
    ("fill-word", "LD M8000\nOUT M8039\nMOV K5 D8039\nFMOV K50 D8039 D20\n", "", "undecided"),
    ("fill-long", "LD M8000\nOUT M8039\nMOV K5 D8039\nDFMOV K50 D7100 K500\n", "", "undecided"),
    (
        "fill-index",
        "LD M8000\nOUT M8039\nMOV K5 D8039\nFMOV K50 D8030Z0 K5\n",
        "[external]\ndevices = [\"Z0\"]\n",
        "undecided",
    ),
    ("reset-index", "LD M8000\nMOV D5 Z0\nMOV K20 D8039\nRST M1000Z0\n", "", "undecided"),
    ("reset-index-alone", "LD M8000\nMOV D5 Z0\nRST M1000Z0\n", "", "proved"),
    // What PID gives is unknown, and so is whether the instructions behind it are executed.
    (
        "unknown-time",
        "LD M8000\nOUT M8039\nMOV K50 D8039\nPID D10 D20 D100 D40\nLD= D40 K0\nMOV K5 D8039\n",
        "",
        "undecided",
    ),
    (
        "unknown-switch",
        "LD M8000\nSET M8039\nMOV K50 D8039\nPID D10 D20 D100 D40\nLD= D40 K0\nRST M8039\n",
        "",
        "undecided",
    ),
    ("word", "LD M8000\nOUT M8039\nMOV D5 D8039\n", "", "undecided"),
    ("word-stated", "LD M8000\nOUT M8039\nMOV D5 D8039\n", "[ranges]\nD5 = [1, 9]\n", "proved"),
    ("digits", "LD M8000\nMOV K15 K2M8036\nMOV K20 D8039\n", "", "undecided"),
    ("stated", "LD X0\nOUT Y0\n", "[scan]\nconstant = \"20ms\"\n", "refuted"),
    // A missing routine may write the time and the relay.
    (
        "called-time",
        CALLS,
        "[calls]\nP7 = { time = \"50us\", writes = [\"D8039\"] }\n",
        "undecided",
    ),
    ("called-any", CALLS, "[calls]\nP7 = { time = \"50us\" }\n", "undecided"),
    ("called-none", CALLS, "[calls]\nP7 = { time = \"50us\", writes = [\"D5\"] }\n", "proved"),
    (
        "called-late",
        "LD M8000\nMOV K50 D8039\nCALL P7\nOUT M8039\n",
        "[calls]\nP7 = { time = \"50us\", writes = [\"D8039\"] }\n",
        "undecided",
    ),
    (
        "called-relay",
        "LD M8000\nMOV K50 D8039\nCALL P7\n",
        "[calls]\nP7 = { time = \"50us\", writes = [\"M8039\"] }\n",
        "undecided",
    ),
    // What writes an index register without an operand.
    (
        "popped-index",
        "LD M8000\nOUT M8039\nMOV K5 D8039\nMOV K7000 D1\nZPOP D0\nMOV K50 D1039Z0\n",
        "",
        "undecided",
    ),
    (
        "computed-index",
        "LD M8000\nOUT M8039\nMOV K5 D8039\nMOV D1 Z0\nMOV K50 D1039Z0\n",
        "",
        "undecided",
    ),
    (
        "called-index",
        INDEXED,
        "[calls]\nP7 = { time = \"50us\", writes = [\"Z0\", \"Z1\"] }\n",
        "undecided",
    ),
    (
        "called-no-index",
        INDEXED,
        "[calls]\nP7 = { time = \"50us\", writes = [\"D5\"] }\n",
        "proved",
    ),
    (
        "special-index",
        "LD M8000\nOUT M8039\nMOV K5 D8039\nMOV K7000 D8028\nMOV K50 D1039Z0\n",
        "",
        "undecided",
    ),
    (
        "external-index",
        "LD M8000\nOUT M8039\nMOV K5 D8039\nMOV K50 D1039Z0\n",
        "[external]\ndevices = [\"Z0\"]\n",
        "undecided",
    ),
    // A range may begin below the device that an index gives, and end above it.
    (
        "range-index",
        "LD M8000\nMOV K20 D8039\nOUT M8039\nMOV K7050 Z0\nZRST D1000 D1039Z0\n",
        "",
        "undecided",
    ),
    (
        "index-range",
        "LD M8000\nMOV K20 D8039\nOUT M8039\nMOV K10 Z0\nZRST D7000Z0 D8100\n",
        "",
        "undecided",
    ),
];

/// A program that calls a missing routine after it has set the time.
const CALLS: &str = "LD M8000\nOUT M8039\nMOV K5 D8039\nCALL P7\n";
/// A program that calls a missing routine and writes through an index register that it does not set.
const INDEXED: &str = "LD M8000\nOUT M8039\nMOV K5 D8039\nCALL P7\nMOV K50 D1039Z0\n";

#[test]
fn every_constant_scan_that_may_be_switched_on_counts() {
    for (name, program, facts, wanted) in CONSTANT {
        let program = format!("{program}END\n");
        let (verdict, report) =
            check(&format!("constant-{name}"), &program, facts, "--cpu FX3U --limit 10ms");
        assert_eq!(verdict, wanted, "{name} {}", report["check"]);
    }
}

#[test]
fn nothing_that_others_may_write_sets_the_constant_scan_if_nobody_is_trusted() {
    let first = "LD M8000\nOUT M8039\nLD M8002\nMOV K5 D8039\nEND\n";
    let always = "LD M8000\nOUT M8039\nMOV K5 D8039\nEND\n";
    let indexed = always.replace("END", "MOV K50 D1039Z0\nEND");
    for (name, program, facts, by_counts, by_none) in [
        ("first", first, "", "proved", "undecided"),
        ("always", always, "", "proved", "proved"),
        ("index", &indexed, "", "proved", "undecided"),
        ("index-stated", &indexed, "[index]\nZ0 = [0, 9]\n", "proved", "proved"),
        ("relay", "LD M8000\nOUT M10Z0\nEND\n", "", "proved", "undecided"),
        ("relay-off", "LD M8000\nRST M10Z0\nEND\n", "", "proved", "proved"),
    ] {
        for (trust, wanted) in [("counts", by_counts), ("none", by_none)] {
            let arguments = format!("--cpu FX3U --limit 10ms --trust {trust}");
            let (verdict, report) = check(&format!("trust-{name}"), program, facts, &arguments);
            assert_eq!(verdict, wanted, "{name} {trust} {}", report["check"]);
        }
    }
}

#[test]
fn others_that_write_the_scan_times_are_refused_unless_these_are_stated() {
    for (devices, what, stated) in [
        ("D8000", "sets the watchdog time", "watchdog = \"500ms\""),
        ("D8039", "sets the constant scan time", "constant = \"20ms\""),
        ("M8000-M8100", "switches the constant scan on or off", "constant = \"none\""),
        ("SD8039", "sets the constant scan time", "constant = \"20ms\""),
        ("SM8000-SM8100", "switches the constant scan on or off", "constant = \"none\""),
    ] {
        let facts = format!("[external]\ndevices = [\"{devices}\"]\n");
        let program = "LD M8000\nOUT M8039\nMOV K5 D8039\nMOV K500 D8000\nWDT\nEND\n";
        let files = [("p.il", program), ("facts.toml", &facts)];
        let run = run("others", &files, "check p.il --cpu FX3U --facts facts.toml --limit 10ms");
        assert_eq!(run.code, Some(2), "{devices}: {}", run.stdout);
        assert!(run.stderr.contains(&format!(", which {what}\n")), "{}", run.stderr);
        let facts = format!("{facts}[scan]\n{stated}\n");
        _ = check("others-stated", program, &facts, "--cpu FX3U --limit 10ms");
    }
}

#[test]
fn break_writes_the_iterations_that_are_left() {
    for (operand, verdict) in [("SD8039", "undecided"), ("D5", "proved")] {
        let program = format!(
            "LD SM400\nOUT SM8039\nMOV K5 SD8039\nFOR K60\nLD X0\nBREAK {operand} P1\nNEXT\nP1\nLD X0\nOUT Y0\nEND\n"
        );
        let name = format!("break-{operand}");
        let (found, report) = check(&name, &program, "", "--cpu FX5U --limit 10ms");
        assert_eq!(found, verdict, "{name} {}", report["check"]);
    }
}

#[test]
fn the_scan_that_waits_is_shown() {
    // The longest scan executes SwOp0, and does not set the time.
    let program = "LD X0\nOUT M8039\nLD X1\nMOV K20 D8039\nLD X0\nANI X1\nBMOV D0 D100 K100\nEND\n";
    let arguments = "--cpu FX3U --limit 10ms --trust all --refute reached";
    let (verdict, report) = check("constant-shown", program, "", arguments);
    assert_eq!(verdict, "refuted", "{report}");
    let constant = &report["scan"]["constant_scan"];
    assert_eq!(constant["found_ps"], 20_000_000_000_u64, "{constant}");
    assert_eq!(constant["found_in"]["scan"], 1, "{constant}");
    assert_eq!(constant["found_in"]["inputs_on"], true, "{constant}");
}

#[test]
fn parameters_may_set_a_constant_scan_where_nobody_states_it() {
    for (cpu, program, name) in [
        ("Q26UDV", "LD X0\nOUT Y0\nEND\n", "constant scan"),
        ("R08", "LD X0\nOUT Y0\nEND\n", "constant scan"),
        ("C200H", "LD 00000\nOUT 00100\nEND(01)\n", "minimum cycle time"),
    ] {
        let arguments = format!("--cpu {cpu} --limit 50ms");
        let (_, report) = check(&format!("parameters-{cpu}"), program, "", &arguments);
        assert_eq!(report["scan"]["constant_scan"]["by_parameters"], name);
        let facts = "[scan]\nconstant = \"60ms\"\n";
        let (verdict, report) = check(&format!("parameters-{cpu}"), program, facts, &arguments);
        assert_eq!(verdict, "refuted", "{cpu}");
        assert_eq!(report["scan"]["cycle_ps"], 60_000_000_000_u64);
        let facts = "[scan]\nconstant = \"none\"\n";
        let (verdict, report) = check(&format!("parameters-{cpu}"), program, facts, &arguments);
        assert_eq!((verdict.as_str(), &report["scan"]["constant_scan"]), ("proved", &Value::Null));
    }
}

#[test]
fn an_interrupt_at_the_end_of_the_wait_makes_the_cycle_longer() {
    let list = "LD X0\nMOV K1 D0\nFEND\nI28\nLD SM400\nBMOV D0 D100 K10\nIRET\nEND\n";
    let arguments = "--cpu Q26UDV --interrupts I28=2 --time BMOV=5ms --time IRET=1ms";
    for (wait, verdict_of_21, verdict_of_40) in
        [(20, "undecided", "proved"), (1, "proved", "proved")]
    {
        let facts = format!("[scan]\nconstant = \"{wait}ms\"\n");
        let of = |limit: &str| check("late", list, &facts, &format!("{arguments} --limit {limit}"));
        let (verdict, report) = of("21ms");
        assert_eq!(verdict, verdict_of_21, "{}", report["check"]);
        let scan = &report["scan"];
        let ps = |value: &Value| value.as_u64().expect("a time");
        let added = ps(&scan["constant_scan"]["interrupts_ps"]);
        // Two of 6 ms and what it takes to begin each, with the factor of the table.
        assert!((13_000_000_000..14_000_000_000).contains(&added), "{scan}");
        let whole = ps(&scan["constant_scan"]["most_ps"]) + added;
        assert_eq!(ps(&scan["cycle_ps"]), whole.max(ps(&scan["upper_ps"])));
        assert_eq!(of("40ms").0, verdict_of_40);
    }
}
