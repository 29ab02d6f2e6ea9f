//! Programs run as a PLC runs them: what instructions with an exact meaning really do, in every dialect.

use crate::command::binary;

use common::real::{RealRun, real};

/// What the scan leaves in these words, for a program that asks for each value.
fn is(dialect: &str, lines: &[&str], start: &[(&str, u16)], test: &str) -> bool {
    let text = [lines, &[test, "SwOp0"]].concat().join("\n");
    let RealRun { fired, stopped } = real(dialect, &text, start);
    assert_eq!(stopped, None, "{text}");
    fired.last().is_some_and(|(text, fired)| text.starts_with("SwOp0") && *fired)
}

#[test]
fn melsec_words_are_rotated_counted_and_coded() {
    let q = |lines: &[&str], test: &str| is("melsec-list", lines, &[], test);
    assert!(q(&["LD SM400", "MOV K1 D0", "ROL D0 K1"], "LD= D0 K2"));
    assert!(!q(&["LD SM400", "MOV K1 D0", "ROL D0 K1"], "LD= D0 K1"));
    assert!(q(&["LD SM400", "MOV H8001 D0", "ROR D0 K1"], "LD= D0 HC000"));
    assert!(q(&["LD SM400", "MOV K1234 D0", "BCD D0 D1"], "LD= D1 H1234"));
    assert!(q(&["LD SM400", "MOV H1234 D0", "BIN D0 D1"], "LD= D1 K1234"));
    assert!(q(&["LD SM400", "MOV K7 D0", "SUM D0 D1"], "LD= D1 K3"));
}

#[test]
fn melsec_index_registers_are_added() {
    let q = |lines: &[&str], test: &str| is("melsec-list", lines, &[], test);
    let set = ["LD SM400", "MOV K3 Z0", "MOV K9 D3", "MOV D0Z0 D10"];
    assert!(q(&set, "LD= D10 K9"));
    let put = ["LD SM400", "MOV K3 Z0", "MOV K9 D1Z0", "SET M0Z0", "SET D20Z0.5"];
    for test in ["LD= D4 K9", "LD M3", "LD D23.5", "LD= D1Z0 K9"] {
        assert!(q(&put, test), "{test}");
    }
}

#[test]
fn what_is_not_settled_is_not_known() {
    // What goes on after an error, and what stops there.
    let text = "LD SM400\nMOV HFFFF D0\nBIN D0 D1\nLD= D1 K1\nSwOp0\nCJ P0\nSwOp0\nP0";
    assert_eq!(real("melsec-list", text, &[]).stopped.as_deref(), Some("BIN D0 D1"));
    let text = "LD SM400\nSwOp1 D1\nLD= D1 K1\nSwOp0\nCJ P0\nSwOp0\nP0";
    assert_eq!(real("melsec-list", text, &[]).stopped.as_deref(), Some("CJ P0"));
}

#[test]
fn a_loop_runs_as_often_as_its_count_says() {
    let iterations = |count: &str| {
        let text = format!("LD SM400\nMOV {count} D9\nFOR D9\nLD SM400\nSwOp0\nNEXT");
        let fired = real("melsec-list", &text, &[]).fired;
        fired.iter().filter(|(text, _)| text.starts_with("SwOp0")).count()
    };
    assert_eq!((iterations("K3"), iterations("K0"), iterations("K-5")), (3, 0, 0));
}

/// Whether the way goes on is not known in any scan: the search says so and ends.
#[test]
fn a_scan_whose_way_is_never_known_is_audited_all_the_same() {
    let directory = tempfile::tempdir().expect("a directory");
    let file = directory.path().join("a.il");
    let text = "LD SM400\nSwOp0 D1\nLD= D1 K1\nCJ P0\nLD SM400\nINC D2\nP0\nEND\n";
    std::fs::write(&file, text).expect("written");
    let run = binary()
        .args(["audit", "--cpu", "Q26UDV", "--time", "SwOp0=1us", "--format", "json"])
        .arg(&file)
        .output()
        .expect("it runs");
    assert_eq!(run.status.code(), Some(0), "{}", String::from_utf8_lossy(&run.stderr));
    let report: serde_json::Value = serde_json::from_slice(&run.stdout).expect("JSON");
    assert_eq!(report["scan"]["exact"], false);
}

#[test]
fn omron_words_are_rotated_and_coded() {
    let cx = |lines: &[&str], test: &str| is("omron-cx", lines, &[], test);
    assert!(cx(&["LD CF113", "MOV #1 D0", "ROL D0"], "LD=(300) D0 #2"));
    assert!(cx(&["LD CF113", "MOV &1234 D0", "BCD D0 D1"], "LD=(300) D1 #1234"));
    assert!(cx(&["LD CF113", "MOV #1234 D0", "BIN D0 D1"], "LD=(300) D1 &1234"));
}

/// No clock changes twice within a scan, no date is any number, and no step comes and goes between two rungs.
#[test]
fn clocks_do_not_jump_within_a_scan() {
    let cost = |cpu: &str, text: &str| {
        let directory = tempfile::tempdir().expect("a directory");
        let file = directory.path().join("a.il");
        std::fs::write(&file, text).expect("written");
        let run = binary()
            .args(["audit", "--cpu", cpu, "--format", "json"])
            .args(["--time", "SwOp0=100us/0us", "--time", "SwOp1=100us/0us"])
            .arg(&file)
            .output()
            .expect("it runs");
        assert_eq!(run.status.code(), Some(0), "{}", String::from_utf8_lossy(&run.stderr));
        let report: serde_json::Value = serde_json::from_slice(&run.stdout).expect("JSON");
        let of = |name: &str| report["scan"][name].as_u64().expect("a number");
        (of("upper_ps") - of("lower_ps")) / 100_000_000
    };
    for (cpu, relay) in [("Q26UDV", "SM412"), ("FX3U", "M8013"), ("Q26UDV", "BL0\\S5")] {
        let text = format!("LD {relay}\nSwOp0\nLDI {relay}\nSwOp1\nLD {relay}\nSwOp0\nEND\n");
        assert!(cost(cpu, &text) >= 1, "{relay}");
        let text = format!("LD {relay}\nSwOp0\nLD {relay}\nSwOp1\nEND\n");
        assert!(relay.starts_with("BL") || cost(cpu, &text) == 0, "{relay}");
    }
    assert!(cost("Q26UDV", "LD= SD210 K-7\nSwOp0\nEND\n") >= 1);
    assert!(cost("FX3U", "LD= D8013 K99\nSwOp0\nEND\n") >= 1);
}

/// What DATERD stores is outside the program, but it is always a date, and the same one in the whole scan.
#[test]
fn melsec_clock_data_are_one_date_that_exists() {
    let leap_day = [("SD210", 59), ("SD211", 1439), ("SD212", 0xFFFF)];
    let read = ["LD SM400", "DATERD D0", "DATERD D10"];
    for test in [
        "LD= D0 K1980",
        "LD= D1 K2",
        "LD= D2 K29",
        "LD= D3 K23",
        "LD= D4 K59",
        "LD= D5 K15",
        "LD= D6 K5",
        "LD= D2 D12",
    ] {
        assert!(is("melsec-list", &read, &leap_day, test), "{test}");
    }
    let coded = ["LD SM400", "DATERD D0", "BKBCD D0 D10 K7"];
    assert!(is("melsec-list", &coded, &leap_day, "LD= D10 H1980"));
}

/// SM702 may let SER search by bisection; M702 is an ordinary relay.
#[test]
fn melsec_searches_are_known_beside_ordinary_relays() {
    let search = |relay: &str| {
        let lines = ["LD X0", relay, "LD SM400", "MOV K7 D3", "SER K7 D0 D10 K5"].join("\n");
        real("melsec-list", &format!("{lines}\nLD= D10 K4\nCJ P0\nLD X0\nOUT Y0\nP0"), &[]).stopped
    };
    assert_eq!(search("SET M702"), None);
    assert!(search("SET SM702").is_some());
}
