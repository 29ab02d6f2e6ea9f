//! Watchdogs, constant scans, addresses of lists, nets and emulated CPUs.

use super::{Run, audit, scanbound, upper_ns};
use crate::command::binary;
use serde_json::Value;
use std::path::{Path, PathBuf};

const POINTS: &str = "[io]\ninputs = 16\noutputs = 16\n";

/// A directory of this test's own with these files.
fn directory(test: &str, files: &[(&str, &str)]) -> PathBuf {
    let directory = Path::new(env!("CARGO_TARGET_TMPDIR")).join("watchdogs").join(test);
    std::fs::create_dir_all(&directory).expect("a directory");
    for (name, text) in files {
        std::fs::write(directory.join(name), text).expect("a file");
    }
    directory
}

/// The command in a directory of its own with these files.
pub(super) fn run(test: &str, files: &[(&str, &str)], arguments: &str) -> Run {
    let directory = directory(test, files);
    scanbound(directory.to_str().expect("a name"), arguments)
}

/// The check of one program with 16 points a side, as JSON, and its verdict.
pub(super) fn check(test: &str, program: &str, facts: &str, arguments: &str) -> (String, Value) {
    let facts = format!("{POINTS}{facts}");
    let files = [("p.il", program), ("facts.toml", &facts)];
    let arguments = format!("check p.il --facts facts.toml --format json {arguments}");
    let run = run(test, &files, &arguments);
    assert!(matches!(run.code, Some(0 | 1 | 3)), "{test}: {}{}", run.stdout, run.stderr);
    let report = run.json();
    let verdict = report["check"]["verdict"].as_str().expect("a verdict").to_owned();
    (verdict, report)
}

#[test]
fn wdt_restarts_the_watchdog() {
    let run = scanbound("wdt-in-loop", "check wdt-in-loop.il --cpu Q00U --limit watchdog");
    assert_eq!(run.code, Some(0), "{}{}", run.stdout, run.stderr);
    let report = audit("wdt-in-loop", "wdt-in-loop.il --cpu Q00U");
    // The scan itself takes 678 ms; 1.2 ms are END processing with all points that the CPU can have.
    assert_eq!(upper_ns(&report) / 1_000_000, 678);
    let stretch = report["scan"]["watchdog"]["stretch_ps"].as_u64().expect("a stretch");
    assert!((35_000_000..1_300_000_000).contains(&stretch), "{stretch}");
    assert_eq!(report["scan"]["cycle_ps"], report["scan"]["upper_ps"]);
}

/// Programs for a Q26UDV in which BMOV takes 1 ms and all else next to nothing, and what becomes of its watchdog of 200
/// ms.
const RESTARTED: [(&str, &str, &str); 12] = [
    ("nested", "FOR K100\nFOR K1000\nLD SM400\nBMOV D0 D100 K10\nWDT\nNEXT\nNEXT\nEND\n", "proved"),
    (
        "called",
        "FOR K1000\nLD SM400\nCALL P1\nNEXT\nFEND\nP1\nLD SM400\nBMOV D0 D100 K10\nWDT\nRET\nEND\n",
        "proved",
    ),
    (
        "straight",
        "FOR K150\nLD SM400\nBMOV D0 D100 K10\nNEXT\nLD SM400\nWDT\nFOR K150\nLD SM400\nBMOV D0 D100 K10\nNEXT\nEND\n",
        "proved",
    ),
    // The stretch over the end of the scan counts, too: 150 ms behind the restart.
    ("pulse", "FOR K1000\nLD SM400\nBMOV D0 D100 K10\nWDTP\nNEXT\nEND\n", "refuted"),
    ("behind", "FOR K1000\nLD SM400\nBMOV D0 D100 K10\nNEXT\nLD SM400\nWDT\nEND\n", "refuted"),
    ("before", "LD SM400\nWDT\nFOR K1000\nLD SM400\nBMOV D0 D100 K10\nNEXT\nEND\n", "refuted"),
    ("condition", "FOR K1000\nLD SM400\nBMOV D0 D100 K10\nLD X0\nWDT\nNEXT\nEND\n", "refuted"),
    (
        "jumped",
        "FOR K1000\nLD SM400\nBMOV D0 D100 K10\nLD X0\nCJ P5\nLD SM400\nWDT\nP5\nNEXT\nEND\n",
        "refuted",
    ),
    (
        "call-condition",
        "FOR K1000\nLD SM400\nBMOV D0 D100 K10\nLD X0\nCALL P1\nNEXT\nFEND\nP1\nLD SM400\nWDT\nRET\nEND\n",
        "refuted",
    ),
    (
        "region",
        "FOR K1000\nLD SM400\nBMOV D0 D100 K10\nLD X0\nMC N0 M0\nLD SM400\nWDT\nMCR N0\nNEXT\nEND\n",
        "refuted",
    ),
    // A scan in which one input is on and restarts it, and the other makes it long.
    ("either", "FOR K1000\nLD X1\nBMOV D0 D100 K10\nLD X0\nWDT\nNEXT\nEND\n", "not proved"),
    ("off", "FOR K1000\nLD SM400\nBMOV D0 D100 K10\nLD SM401\nWDT\nNEXT\nEND\n", "refuted"),
];

#[test]
fn a_restart_under_the_condition_of_what_is_behind_it_counts() {
    // BMOV takes 120 ms, and the watchdog is 200 ms.
    let heavy = "BMOV D0 D100 K10\n";
    for (name, program, wanted) in [
        ("same", "LD X1\nHEAVYLD X0\nWDT\nHEAVY", "proved"),
        ("apart", "LD X1\nHEAVYLD X0\nWDT\nLD X2\nHEAVY", "refuted"),
        ("edge", "LD X1\nHEAVYLD X0\nWDTP\nHEAVY", "refuted"),
        ("narrower", "LD X1\nHEAVYLD X0\nWDT\nAND X2\nHEAVY", "proved"),
        ("chosen", "LD X1\nHEAVYLD X0\nWDT\nLDI X0\nWDT\nLD X2\nHEAVY", "proved"),
        ("either", "LD X1\nHEAVYLD X0\nWDT\nLD X3\nWDT\nLD X0\nOR X3\nHEAVY", "proved"),
        ("three", "LD X1\nHEAVYLD X0\nWDT\nHEAVYLD X2\nWDT\nHEAVY", "proved"),
        ("two", "LD X1\nHEAVYLD X0\nWDT\nHEAVYLD X2\nHEAVY", "refuted"),
        ("jumped", "LD X1\nHEAVYLDI X0\nCJ P0\nLD SM400\nWDT\nP0\nLD X0\nHEAVY", "proved"),
        ("looped", "FOR K3\nLD X0\nWDT\nHEAVYNEXT\n", "proved"),
    ] {
        let program = format!("{}END\n", program.replace("HEAVY", heavy));
        let times = "--time BMOV=120ms/1us --time FOR=1us --time NEXT=1us";
        let arguments = format!("--cpu Q26UDV --limit watchdog {times}");
        let (verdict, report) = check(&format!("condition-{name}"), &program, "", &arguments);
        assert_eq!(verdict, wanted, "{name} {} {}", report["check"], report["scan"]["watchdog"]);
    }
}

#[test]
fn an_assumption_that_only_the_watchdog_needs_is_listed() {
    // Y0 and Y1 are never both on. With X5 on a scan takes as long, but the watchdog is restarted in it.
    let heavy = "BMOV D0 D100 K10\n";
    let program = "LD Y0\nANI X5\nHEAVYLD Y1\nANI X5\nHEAVYLD X5\nHEAVYWDT\nLD X5\nHEAVYLD X0\nOUT Y0\nLDI X0\n\
                   OUT Y1\nEND\n";
    let program = program.replace("HEAVY", heavy);
    let files = [("p.il", &*program), ("facts.toml", POINTS)];
    let arguments =
        "p.il --facts facts.toml --cpu Q26UDV --trust all --what-if --time BMOV=120ms/1us";
    let run = run("watchdog-assumption", &files, &format!("audit {arguments} --format json"));
    assert_eq!(run.code, Some(0), "{}{}", run.stdout, run.stderr);
    let report = run.json();
    let watchdog = &report["scan"]["watchdog"];
    assert!(watchdog["stretch_ps"].as_u64() < Some(200_000_000_000), "{watchdog}");
    let listed = report["assumptions"].as_array().expect("a list");
    let names = |one: &Value| one["name"].as_str().is_some_and(|name| name.contains("Y1"));
    assert!(listed.iter().any(names), "{}", report["assumptions"]);
}

#[test]
fn only_a_restart_that_surely_comes_counts() {
    for (name, program, wanted) in RESTARTED {
        let arguments = "--cpu Q26UDV --limit watchdog --time BMOV=1ms --time WDT=1us";
        let (verdict, report) = check(name, program, "", arguments);
        let scan = &report["scan"];
        match wanted {
            "not proved" => assert_ne!(verdict, "proved", "{name}"),
            _ => assert_eq!(verdict, wanted, "{name} {}", report["check"]),
        }
        let (found, stretch) = (&scan["watchdog"]["found_ps"], &scan["watchdog"]["stretch_ps"]);
        assert!(found.as_u64() <= stretch.as_u64(), "{name}");
        assert!(stretch.as_u64() <= scan["upper_ps"].as_u64(), "{name}");
    }
}

#[test]
fn the_watchdog_of_the_fx_is_what_d8000_sets_it_to() {
    let low = scanbound(
        "fx-watchdog",
        "check fx-watchdog.il --cpu FX3U --limit watchdog --refute reached",
    );
    assert_eq!(low.code, Some(1), "{}", low.stdout);
    assert!(
        low.stdout.starts_with("REFUTED: a scan takes 49.84 ms, the limit is 10 ms"),
        "{}",
        low.stdout
    );
    let high = scanbound("fx-watchdog", "check fx-watchdog-high.il --cpu FX3U --limit watchdog");
    assert_eq!(high.code, Some(1), "{}", high.stdout);
    assert!(high.stdout.contains("the limit is 500 ms"), "{}", high.stdout);
    assert!(high.stdout.contains("500 ms (D8000: MOV K500 D8000"), "{}", high.stdout);
}

#[test]
fn a_watchdog_of_unknown_time_before_the_program_sets_it_proves_nothing() {
    let check = "check no-default.il --table no-default.csv --cpu FX3U --limit watchdog";
    let run = scanbound("fx-watchdog", check);
    assert_eq!(run.code, Some(3), "{}{}", run.stdout, run.stderr);
    assert!(run.stdout.contains("@watchdog"), "{}", run.stdout);
}

#[test]
fn blocks_from_below_may_set_the_constant_scan_time() {
    let directory = tempfile::tempdir().expect("a directory");
    let file = directory.path().join("p.il");
    let code = |text: &str, arguments: &[&str]| {
        std::fs::write(&file, format!("{text}END\n")).expect("written");
        let output = binary()
            .args(["check", "--cpu", "FX3U", "--limit", "50ms"])
            .args(arguments)
            .arg(&file)
            .output()
            .expect("the command runs");
        output.status.code()
    };
    let on = "LD M8000\nOUT M8039\n";
    assert_eq!(code(&format!("{on}MOV K20 D8039\n"), &[]), Some(0), "20 ms are known");
    // A user's instruction may write any number of words, and the shift writes from 40 words below on.
    let user = ["--time", "SwOp0=1us"];
    assert_eq!(code(&format!("{on}SwOp0 D8030\n"), &user), Some(3));
    assert_eq!(code(&format!("{on}WSFL D0 D7990 K60 K1\n"), &["--time", "WSFL=1us"]), Some(3));
    // A block of double words is twice as long as its count.
    let known = format!("{on}MOV K20 D8039\n");
    let double =
        |from: &str| code(&format!("{known}DFMOV K5 {from} K20\n"), &["--time", "DFMOV=1us"]);
    assert_eq!(double("D8010"), Some(3));
    assert_eq!(double("D7990"), Some(0));
    // DECO writes 2^n relays.
    let decode =
        |operands: &str| code(&format!("LD X0\nDECO D0 {operands}\n"), &["--time", "DECO=1us"]);
    assert_eq!(decode("M8032 K3"), Some(3));
    assert_eq!(decode("M8024 K4"), Some(3));
    assert_eq!(decode("M8031 K3"), Some(0), "M8038 is the last");
}

#[test]
fn loops_and_indices_count_as_reading_anything_before_a_response() {
    let scans = |text: &str| {
        let directory = tempfile::tempdir().expect("a directory");
        let file = directory.path().join("p.il");
        std::fs::write(&file, text).expect("written");
        let output = binary()
            .args(["audit", "--cpu", "Q26UDV", "--response", "--format", "json"])
            .args(["--input-delay", "10ms", "--output-delay", "10ms"])
            .arg(&file)
            .output()
            .expect("the command runs");
        let report: serde_json::Value = serde_json::from_slice(&output.stdout).expect("JSON");
        report["response"]["scans"].as_u64().expect("scans")
    };
    // The index register decides which word goes out, and it is worked out behind that.
    let index = "LD SM400\nMOV D0Z0 K4Y0\nLD X0\nMOV K1 Z0\nEND\n";
    assert_eq!(scans(index), 3);
    let plain = "LD SM400\nMOV D0 K4Y0\nLD X0\nMOV K1 D5\nEND\n";
    assert_eq!(scans(plain), 2);
    // What a comparison of texts reads is not followed.
    assert_eq!(scans("LD$= D10 D20\nOUT Y0\nLD X0\nMOV K1 D10\nEND\n"), 3);
}

/// Programs for an FX3U, before a loop of 300 ms, and what becomes of its watchdog.
const SET: [(&str, &str, &str, &str); 23] = [
    ("default", "", "", "refuted"),
    ("first", "LD M8002\nMOV K500 D8000\nWDT\n", "", "proved"),
    ("always", "LD M8000\nMOV K400 D8000\nWDT\n", "", "proved"),
    // Without a restart it takes effect at the end of the first scan.
    ("late", "LD M8002\nMOV K500 D8000\n", "", "undecided"),
    ("lower", "LD M8002\nMOV K100 D8000\nWDT\n", "", "refuted"),
    ("maybe", "LD X0\nMOV K500 D8000\nWDT\n", "", "undecided"),
    ("maybe-lower", "LD X0\nMOV K100 D8000\n", "", "refuted"),
    ("one-of-two", "LD M8002\nMOV K500 D8000\nWDT\nLD X0\nMOV K250 D8000\n", "", "undecided"),
    ("word", "LD M8002\nMOV D5 D8000\nWDT\n", "", "undecided"),
    ("word-stated", "LD M8002\nMOV D5 D8000\nWDT\n", "[ranges]\nD5 = [400, 600]\n", "proved"),
    ("block", "LD M8002\nBMOV D10 D7990 K20\nWDT\n", "", "undecided"),
    ("fill-none", "LD M8002\nFMOV K500 D8000 K0\nWDT\n", "", "undecided"),
    ("indexed", "LD M8000\nMOV K1000 Z0\nLD M8002\nMOV K500 D7000Z0\nWDT\n", "", "undecided"),
    ("unknown-index", "LD M8000\nMOV D1 Z0\nLD X0\nMOV K900 D100Z0\n", "", "undecided"),
    ("small-index", "LD M8000\nMOV K10 Z0\nLD X0\nMOV K900 D100Z0\n", "", "refuted"),
    (
        "stated-index",
        "LD M8000\nMOV D1 Z0\nLD X0\nMOV K900 D100Z0\n",
        "[index]\nZ0 = [0, 99]\n",
        "refuted",
    ),
    ("by-index", "LD M8002\nMOV K500 D8000Z0\nWDT\n", "", "undecided"),
    // What may be written need not be.
    ("fill", "LD M8002\nFMOV K500 D7995 K10\nWDT\n", "", "proved"),
    ("fill-unknown", "LD M8000\nMOV K10 D20\nFMOV K0 D7990 D20\n", "", "undecided"),
    ("reset-index", "LD M8000\nMOV D5 Z0\nRST D7000Z0\n", "", "undecided"),
    ("stated", "LD X0\nOUT Y0\n", "[scan]\nwatchdog = \"500ms\"\n", "proved"),
    // A missing routine may write D8000.
    (
        "called",
        "LD M8002\nMOV K500 D8000\nWDT\nLD M8000\nCALL P7\n",
        "[calls]\nP7 = { time = \"50us\", writes = [\"D8000\"] }\n",
        "undecided",
    ),
    (
        "called-any",
        "LD M8002\nMOV K500 D8000\nWDT\nLD M8000\nCALL P7\n",
        "[calls]\nP7 = { time = \"50us\" }\n",
        "undecided",
    ),
];

#[test]
fn every_value_that_d8000_can_have_counts() {
    for (name, begin, facts, wanted) in SET {
        let program = format!("{begin}FOR K3000\nLD M8000\nBMOV D0 D100 K10\nNEXT\nEND\n");
        let arguments =
            "--cpu FX3U --limit watchdog --time BMOV=1us --time NEXT=100us --time FOR=1us";
        let (verdict, report) = check(name, &program, facts, arguments);
        assert_eq!(verdict, wanted, "{name} {}", report["check"]);
        // A limit in time is not about the watchdog. A routine that may write anything may cause a constant scan, too.
        let wanted = if name == "called-any" { "undecided" } else { "proved" };
        let (verdict, _) = check(name, &program, facts, &arguments.replace("watchdog", "310ms"));
        assert_eq!(verdict, wanted, "{name}");
    }
}

#[test]
fn the_fx5_has_its_watchdog_and_constant_scan_in_special_registers() {
    let program = "LD SM402\nMOV K10 SD8000\nMOV K50 SD8039\nLD SM400\nOUT SM8039\nFOR K200\nLD SM400\nBMOV D0 D100 K10\nNEXT\nEND\n";
    let times = "--cpu FX5U --time BMOV=100us --time FOR=1us --time NEXT=1us";
    let (verdict, _) = check("fx5", program, "", &format!("{times} --limit watchdog"));
    assert_eq!(verdict, "refuted");
    let (verdict, report) = check("fx5", program, "", &format!("{times} --limit 45ms"));
    assert_eq!(verdict, "refuted");
    assert_eq!(report["scan"]["cycle_ps"], 50_000_000_000_u64);
    assert!(report["scan"]["upper_ps"].as_u64() < Some(45_000_000_000));
}

#[test]
fn d8000_is_an_ordinary_register_of_the_fx5() {
    let program = "LD SM402\nMOV K10 D8000\nMOV K50 D8039\nLD SM400\nOUT M8039\nEND\n";
    let (verdict, report) = check("fx5-d8000", program, "", "--cpu FX5U --limit 45ms");
    assert_eq!(verdict, "proved", "{report}");
    assert_eq!(report["scan"]["watchdog"]["set_by"], serde_json::json!([]), "{report}");
    assert_eq!(report["scan"]["constant_scan"]["found_ps"], Value::Null, "{report}");
}

#[test]
fn instructions_that_write_several_words_reach_d8000() {
    for (operation, verdict) in [("TRD D7995", "undecided"), ("TRD D7990", "proved")] {
        let program = format!("LD X0\n{operation}\nEND\n");
        let arguments = "--cpu FX3U --limit watchdog --time TRD=1us";
        let found = check("fx-trd", &program, "", arguments);
        assert_eq!(found.0, verdict, "{operation} {}", found.1["check"]);
    }
}

#[test]
fn what_wdt_of_omron_adds_is_told() {
    let list = "LD P_On\nWDT(094) &30\nLD 0.00\nOUT 1.00\nEND(001)\n";
    let run = run("omron-wdt", &[("p.il", list)], "audit p.il --cpu CJ2M --time WDT=1us");
    assert_eq!(run.code, Some(0), "{}{}", run.stdout, run.stderr);
    assert!(run.stdout.contains("with what WDT adds: kept"), "{}", run.stdout);
}

#[test]
fn measured_cycles_are_held_against_the_cycle() {
    let times = "scan_ms\n100\n99.9\n";
    let program = "LD M8000\nOUT M8039\nLD M8002\nMOV K100 D8039\nEND\n";
    let files = [("p.il", program), ("times.csv", times), ("facts.toml", POINTS)];
    let run = run("compared", &files, "compare p.il times.csv --cpu FX3U --facts facts.toml");
    assert_eq!(run.code, Some(0), "{}{}", run.stdout, run.stderr);
}

#[test]
fn wdt_of_omron_makes_the_time_longer() {
    // A scan of 1.05 s; the cycle time monitor of 1 s is extended by so many times 10 ms.
    for (name, wdt, wanted) in [
        ("omron-none", "LD P_On\nOUT W0.00\n", "refuted"),
        ("omron-100ms", "LD P_On\nWDT(094) &10\n", "proved"),
        ("omron-10ms", "LD P_On\nWDT(094) &1\n", "refuted"),
        ("omron-input", "LD 0.00\nWDT(094) &10\n", "refuted"),
    ] {
        let program =
            format!("{wdt}FOR(512) &1000\nLD P_On\nMOV(021) D0 D1\nNEXT(513)\nEND(001)\n");
        let times = "--time MOV=1050us --time NEXT=1ns --time FOR=1ns --time LD=1ns --time WDT=1us";
        let (verdict, report) = check(
            name,
            &program,
            "[scan]\nfactor = 1\n",
            &format!("--cpu CJ2M --limit watchdog {times}"),
        );
        assert_eq!(verdict, wanted, "{name} {}", report["check"]);
    }
}

/// Lists with addresses, the CPU or dialect that they are for, and the line of the first address that is wrong.
const NUMBERED: [(&str, &str, &str, Option<u32>); 12] = [
    ("omron", "00000 LD 00000\n00001 OUT 00500\n00002 END(01)\n", "--cpu C200H", None),
    ("omron-from-200", "00200 LD 00000\n00201 OUT 00500\n00202 END(01)\n", "--cpu C200H", None),
    ("omron-missing", "00000 LD 00000\n00002 OUT 00500\n00003 END(01)\n", "--cpu C200H", Some(2)),
    (
        "omron-doubled",
        "00000 LD 00000\n00001 AND 00001\n00001 OUT 00500\n00002 END(01)\n",
        "--cpu C200H",
        Some(3),
    ),
    ("omron-falling", "00003 LD 00000\n00002 OUT 00500\n00003 END(01)\n", "--cpu C200H", Some(2)),
    (
        "omron-some",
        "00000 LD 00000\nAND 00001\n00003 OUT 00500\n00004 END(01)\n",
        "--cpu C200H",
        Some(3),
    ),
    ("minasec", "0 LD X00\n1 ST Y00\n", "--dialect minasec-asm", None),
    ("minasec-missing", "0 LD X00\n2 ST Y00\n", "--dialect minasec-asm", Some(2)),
    ("melsec-doubled", "0 LD X0\n1 OUT Y0\n1 OUT Y1\n2 END\n", "--cpu Q26UDV", Some(3)),
    ("melsec-falling", "0 LD X0\n2 OUT Y0\n1 END\n", "--cpu Q26UDV", Some(3)),
    ("melsec-apart", "0 LD X0\n1 OUT T0 K10\n5 LD T0\n6 OUT Y0\n7 END\n", "--cpu Q26UDV", None),
    (
        "melsec-label",
        "0 LD X0\n1 CJ P0\n3 LD X1\n4 OUT Y0\n5 P0\n5 LD X2\n6 OUT Y1\n7 END\n",
        "--cpu Q26UDV",
        None,
    ),
];

#[test]
fn an_address_that_does_not_follow_is_an_error() {
    for (name, list, cpu, wrong) in NUMBERED {
        let run = run(&format!("numbered-{name}"), &[("p.il", list)], &format!("audit p.il {cpu}"));
        match wrong {
            None => assert_eq!(run.code, Some(0), "{name}: {}{}", run.stdout, run.stderr),
            Some(line) => {
                assert_eq!(run.code, Some(2), "{name}: {}{}", run.stdout, run.stderr);
                assert!(run.stderr.contains("error[step-order]"), "{name}: {}", run.stderr);
                assert!(run.stderr.contains(&format!("p.il:{line}:")), "{name}: {}", run.stderr);
            }
        }
    }
    for file in ["line-2-missing.il", "out-of-order.il"] {
        let run = scanbound("missing-address", &format!("audit {file} --cpu C200H"));
        assert_eq!(run.code, Some(2), "{file}: {}", run.stdout);
        assert!(run.stderr.contains(&format!("{file}:3:")), "{}", run.stderr);
    }
}

#[test]
fn a_flowchart_list_without_one_of_its_lines_is_refused() {
    let list = "0 LBL0: AND 0\n2 CJP LBL1\n3 JMP LBL0\n4 LBL1: OUT 200\n6 JMP LBL0\n";
    let right = run("flow", &[("p.lst", list)], "audit p.lst");
    assert_eq!(right.code, Some(0), "{}{}", right.stdout, right.stderr);
    let lost = run("flow-lost", &[("p.lst", &list.replace("3 JMP LBL0\n", ""))], "audit p.lst");
    assert_eq!(lost.code, Some(2), "{}", lost.stdout);
    assert!(lost.stderr.contains("error[step-order]: address 3 is missing"), "{}", lost.stderr);
}

#[test]
fn what_another_dialect_does_not_have_is_told_with_its_line() {
    let list = "LD X00\nOUT Y00\n";
    let run = run("minasec-named", &[("p.asm", list)], "audit p.asm --dialect minasec-asm");
    assert_eq!(run.code, Some(2), "{}", run.stdout);
    assert!(run.stderr.contains("MINASEC-U has no instruction 'OUT'"), "{}", run.stderr);
    assert!(run.stderr.contains("p.asm:2:1"), "{}", run.stderr);
}

#[test]
fn an_unknown_word_of_the_stated_dialect_is_told_alone() {
    let list = "LD X00\nAND X01\nFOO 1\nST Y00\n";
    let run = run("minasec-unknown", &[("p.asm", list)], "audit p.asm --dialect minasec-asm");
    assert_eq!(run.code, Some(2), "{}", run.stdout);
    assert!(run.stderr.contains("MINASEC-U has no instruction 'FOO'"), "{}", run.stderr);
    assert!(run.stderr.contains("p.asm:3:1"), "{}", run.stderr);
    assert!(!run.stderr.contains("this is a"), "{}", run.stderr);
}

#[test]
fn a_box_in_an_input_word_is_refused() {
    for command in ["snet check box.snet", "snet translate box.snet --to c200h"] {
        let run = scanbound("snet-input-word", command);
        assert_eq!(run.code, Some(2), "{command}: {}", run.stdout);
        assert!(run.stderr.contains("box.snet:4"), "{}", run.stderr);
        assert!(
            run.stderr.contains("the CPU overwrites word 000 when it reads the inputs"),
            "{}",
            run.stderr
        );
    }
}

#[test]
fn a_word_of_which_a_bit_is_read_and_not_written_has_inputs() {
    let points = |case: &str, arguments: &str| {
        let report = audit(case, arguments);
        let points = report["points"].as_array().expect("points").clone();
        let of = |side: &str| {
            let found = points.iter().find(|one| one["side"] == side);
            found.and_then(|one| one["taken"].as_u64())
        };
        (of("input"), of("output"))
    };
    assert_eq!(points("snet-input-word", "smallest.il --cpu C200H"), (Some(16), Some(16)));
    // A relay that is written and read is none.
    let kept = "LD 00001\nOR 00500\nOUT 00500\nEND(01)\n";
    let kept = directory("kept", &[("p.il", kept)]);
    let kept = points(kept.to_str().expect("a name"), "p.il --cpu C200H");
    assert_eq!(kept, (Some(16), Some(16)));
}

#[test]
fn the_emulated_cpu_tells_its_first_cycle() {
    use scanbound::base::facts::Facts;
    use scanbound::base::time::{Picos, Times};
    use scanbound::front::{Input, Options, read};
    use scanbound::program::Cell;
    use scanbound::replay::emulated::Emulated;
    let first = std::fs::read(super::case("snet-first-cycle").join("first.il")).expect("a case");
    let first = String::from_utf8(first).expect("text");
    let cs = |bit: &str| format!("LD {bit}\nSET 3.00\nLD P_On\nOUT 3.01\nEND(001)\n");
    for (family, dialect, area, index, text) in [
        ("c", "omron-c200h", "IR", 30, first),
        ("cs", "omron-cx", "CIO", 3, cs("A200.11")),
        ("cs", "omron-cx", "CIO", 3, cs("P_First_Cycle")),
    ] {
        let input = Input { name: "p.il".to_owned(), bytes: text.clone().into_bytes() };
        let facts = Facts::default();
        let options = Options { family: Some(family), ..Options::new(&facts) };
        let project = read(&[input], Some(dialect)).expect("a program");
        let program = project.decode(&options).expect("a sound one");
        let times = vec![Times::new(Picos(1), Picos(1)); program.instructions.len()];
        let mut cpu = Emulated::new(&program, &times);
        let area = program.areas.iter().position(|one| one.name == area).expect("an area");
        let word = Cell { area: scanbound::program::AreaId(area as u16), index };
        cpu.scan(1_000);
        assert_eq!(cpu.value(word), 3, "{text}");
        // Only the first: what is cleared stays so.
        cpu.set(word, 0);
        cpu.scan(1_000);
        assert_eq!(cpu.value(word), 2, "{text}");
    }
}

#[test]
fn a_relay_that_is_read_before_it_is_written_costs_a_scan() {
    let response = |case: &str, arguments: &str| {
        let report = audit(case, &format!("{arguments} --response"));
        let found = &report["response"];
        (found["scans"].as_u64().expect("scans"), found["upper_ps"].as_u64().expect("a time"))
    };
    let two = response("response-two-scans", "two-scans.asm");
    assert_eq!(two, (3, 53_264_000_000));
    for (name, list, scans) in [
        ("none", "LD X00\nST M00\nLD M00\nST Y00\n", 2),
        ("direct", "LD X00\nST Y00\n", 2),
        // From the output back to the input: each relay waits for the next scan.
        ("chain", "LD M02\nST Y00\nLD M01\nST M02\nLD M00\nST M01\nLD X00\nST M00\n", 5),
        ("mixed", "LD M01\nST Y00\nLD X00\nST M00\nLD M00\nST M01\n", 3),
        // The way of the second output is the longer one.
        ("two", "LD X00\nST Y00\nLD M00\nST Y01\nLD X01\nST M00\n", 3),
        // A relay that holds itself does not wait for itself.
        ("held", "LD X00\nOR Y00\nANDI X01\nST Y00\n", 2),
        // No output follows from it.
        ("apart", "LD X00\nST Y00\nLD M00\nST M01\nLD X01\nST M00\n", 2),
    ] {
        let directory = directory(&format!("response-{name}"), &[("p.asm", list)]);
        let found = response(directory.to_str().expect("a name"), "p.asm");
        assert_eq!(found.0, scans, "{name}");
    }
    // The same of a program for a Q, with SET, RST and a subroutine.
    for (name, list, scans) in [
        ("q-set", "LD M0\nOUT Y0\nLD X0\nSET M0\nLD X1\nRST M0\nEND\n", 3),
        ("q-direct", "LD X0\nSET M0\nLD X1\nRST M0\nLD M0\nOUT Y0\nEND\n", 2),
        ("q-words", "LD= D0 K1\nOUT Y0\nLD X0\nMOV K1 D0\nEND\n", 3),
        ("q-jump", "LD M0\nCJ P0\nLD SM400\nOUT Y0\nP0\nLD X0\nOUT M0\nEND\n", 3),
    ] {
        let directory = directory(&format!("response-{name}"), &[("p.il", list)]);
        let arguments = "p.il --cpu Q26UDV --input-delay 10ms --output-delay 1ms";
        let found = response(directory.to_str().expect("a name"), arguments);
        assert_eq!(found.0, scans, "{name}");
    }
}

#[test]
fn interrupts_at_intervals_are_counted_as_often_as_they_are_due() {
    let points = directory("intervals", &[("facts.toml", POINTS)]);
    let facts = points.join("facts.toml");
    let upper = |often: &str, times: &str| {
        let arguments = format!(
            "fixed-scan-interrupt.il --cpu Q26UDV --interrupts I28={often} --facts {} {times}",
            facts.display()
        );
        let report = audit("fixed-scan-interrupt", &arguments);
        assert_eq!(report["doubts"], serde_json::json!([]));
        report["scan"]["upper_ps"].as_u64().expect("a bound")
    };
    for times in ["", "--time MOV=9ms", "--time MOV=30ms --time BMOV=3ms"] {
        let least = upper("4ms", times);
        let due = |scan: u64| scan.div_ceil(4_000_000_000);
        let count = due(least);
        assert_eq!(upper(&count.to_string(), times), least, "{times}");
        let fewer = (1..count).map(|fewer| (fewer, upper(&fewer.to_string(), times)));
        for (fewer, scan) in fewer.skip(count.saturating_sub(4) as usize) {
            assert!(due(scan) > fewer, "{times}: {fewer} interrupts are enough");
        }
    }
    // DI may let one wait for a later scan: it adds to those that are due there.
    let list = std::fs::read_to_string(
        super::case("fixed-scan-interrupt").join("fixed-scan-interrupt.il"),
    );
    let list = list.expect("the case");
    for (name, begin, held) in [
        ("di", "DI\n", 1),
        // Interrupts are enabled from the beginning of the first scan, or late.
        ("ei", "EI\n", 0),
        ("late-ei", "LD X0\nCJ P0\nEI\nP0\n", 1),
    ] {
        let text = format!("{begin}{list}");
        let files = [("p.il", text.as_str()), ("facts.toml", POINTS)];
        let of = |count: &str| {
            let arguments = format!(
                "audit p.il --cpu Q26UDV --facts facts.toml --format json --interrupts I28={count}"
            );
            run(name, &files, &arguments).json()["scan"]["upper_ps"].as_u64().expect("a bound")
        };
        let due = of("4ms").div_ceil(4_000_000_000);
        assert_eq!(of("4ms"), of(&(due + held).to_string()), "{name}");
    }
    let arguments =
        "audit fixed-scan-interrupt.il --cpu Q26UDV --interrupts I28=4ms --time BMOV=5ms";
    let run = scanbound("fixed-scan-interrupt", arguments);
    assert_eq!(run.code, Some(2), "{}", run.stdout);
    assert!(run.stderr.contains("the scan has no bound"), "{}", run.stderr);
}
