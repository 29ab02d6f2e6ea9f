//! No lower bound rests on a scan that starts in a state which no scan leaves.

use super::{Run, lower_ns, upper_ns};
use crate::command::binary;
use serde_json::Value;
use std::path::Path;

/// Nothing takes time but END (9 ms, or 60 ms) and SwA (50 us where it fires, else 1 us).
const TABLE: &str = "instruction,on_us,off_us\n@watchdog,200000,\n@contact,0,0\n@compare,0,0\n@coil,0,0\n@timer,0,0\n\
                     @counter,0,0\n@set,0,0\n@pulse,0,0\n@move,0,0\n@jump,0,0\n@block,0,0\n@loop,0,0\n@nothing,0,0\n@special,0,0\n@master,0,0\n@shift,0,0\nDMOV,0,0\nSwA,50,1\n";

/// The JSON report on a list in which END takes so many milliseconds.
fn report(name: &str, cpu: &str, list: &str, [end_ms, trust]: [&str; 2]) -> Value {
    with_facts(name, cpu, list, [end_ms, trust, ""])
}

fn with_facts(name: &str, cpu: &str, list: &str, [end_ms, trust, facts]: [&str; 3]) -> Value {
    let directory = Path::new(env!("CARGO_TARGET_TMPDIR")).join("cases-start-states");
    std::fs::create_dir_all(&directory).expect("a directory");
    let (file, table) = (directory.join(name), directory.join(format!("{name}.csv")));
    std::fs::write(&file, list).expect("a file");
    std::fs::write(&table, format!("{TABLE}END,{end_ms}000,\n")).expect("a file");
    let stated = directory.join(format!("{name}.toml"));
    std::fs::write(&stated, facts).expect("a file");
    let output = binary()
        .args(["audit", "--format", "json", "--cpu", cpu, "--trust", trust, "--table"])
        .args([&table, &file])
        .arg("--facts")
        .arg(&stated)
        .output()
        .expect("the command runs");
    let run = Run::of(&output);
    assert_eq!(run.code, Some(0), "{name} {cpu}: {}{}\n{list}", run.stdout, run.stderr);
    run.json()
}

/// Whether a lower bound rests on a scan in which SwA fires, and whether a run from power-up leads there.
fn fires(name: &str, cpu: &str, list: &str, end_ms: &str) -> (bool, bool) {
    let report = report(name, cpu, list, [end_ms, "all"]);
    let end = 1_000_000 * end_ms.parse::<u64>().expect("a number");
    let lower = lower_ns(&report);
    assert!(lower <= upper_ns(&report) && lower >= end, "{name} {cpu}: {report}");
    (lower >= end + 50_000, report["scan"]["lower_kind"] == "reached")
}

#[test]
fn no_lower_bound_rests_on_a_state_that_no_scan_leaves() {
    for (name, list) in [
        // A counter is through with the value of its setting, not beyond it.
        ("beyond.il", "LD X0\nOUT C0 K2\nLD<> C0 K2\nAND C0\nSwA D100\nEND\n"),
        ("below.il", "LD X0\nOUT C0 K2\nLD= C0 K2\nANI C0\nSwA D100\nEND\n"),
        // A timer's contact is off where its condition was.
        ("contact.il", "LDP X0\nAND T0\nSwA D100\nLD X0\nOUT T0 K2\nEND\n"),
        ("other-relay.il", "LD T0\nAND M0\nSwA D100\nLD X0\nOUT T0 K2\nLDI X0\nOUT M0\nEND\n"),
        // The contact stays on as long as the coil does.
        ("falls.il", "LD X0\nOUT T0 K5\nLDF T0\nAND X0\nSwA D100\nEND\n"),
        ("falls-in-word.il", "LD X0\nOUT T0 D9\nLDF T0\nAND X0\nSwA D100\nEND\n"),
        ("counter-falls.il", "LD X0\nOUT C0 K2\nLDF C0\nSwA D100\nEND\n"),
        // One counter counts where the input comes on, the other where it goes off.
        ("together.il", "LDP C0\nANDP C1\nSwA D100\nLD X0\nOUT C0 K5\nLDI X0\nOUT C1 K5\nEND\n"),
        // After the first scan D0 is 3.
        ("initial.il", "LD SM402\nMOV K3 D0\nLD<> D0 K3\nANI SM402\nSwA D100\nEND\n"),
        // The upper word of 5 is 0.
        ("upper-word.il", "LD= D1 K1\nSwA D100\nLD X0\nDMOV K5 D0\nEND\n"),
        // Nothing resets M600.
        ("never-falls.il", "LD X1\nCJ P0\nLDF M600\nSwA D100\nP0\nLD X0\nSET M600\nEND\n"),
        // The memory of the edge is written only while the input is off.
        ("behind.il", "LD X0\nCJ P1\nLDF X0\nSwA D100\nP1\nEND\n"),
    ] {
        for cpu in ["Q26UDV", "FX3U"] {
            let list = &list.replace("SM402", if cpu == "FX3U" { "M8002" } else { "SM402" });
            assert!(!fires(name, cpu, list, "9").0, "{name} {cpu}");
        }
    }
    let falls = "LD 0.00\nTIM 0000 #0005\nLD T0000\nDIFD(014) W0.00\nLD W0.00\nAND 0.00\nSwA D100\nEND(001)\n";
    assert!(!fires("falls-cj.il", "CJ2M", falls, "9").0);
    let falls = "LD 00000\nTIM 000 #0005\nLD TIM000\nDIFD(14) 03000\nLD 03000\nAND 00000\nSwA DM0100\nEND(01)\n";
    assert!(!fires("falls-c200h.il", "C200H", falls, "9").0);
}

#[test]
fn no_lower_bound_rests_on_stated_relays_whose_states_were_not_examined() {
    // M0, M1 and M2 are never on together, and with so many more relays their states are not examined.
    let mut list = "LD M0\nAND M1\nAND M2\nSwA D100\nLD X0\nOUT M0\nLD X1\nOUT M1\n\
        LD X0\nANI X1\nOUT M3\nLDI X0\nAND X1\nOR M3\nOUT M2\n"
        .to_owned();
    for relay in 10..220 {
        list += &format!("LD M{relay}\nOUT Y{relay:X}\nLD X0\nOUT M{relay}\n");
    }
    list += "END\n";
    let facts = "[internal]\ndevices = [\"M0-M999\"]\n";
    let report = with_facts("internal.il", "Q26UDV", &list, ["9", "counts", facts]);
    assert!(lower_ns(&report) < 9_050_000, "{}", report["scan"]);
}

#[test]
fn what_scans_leave_remains_a_lower_bound() {
    for (name, list) in [
        ("through.il", "LD= C0 K2\nAND C0\nSwA D100\nLD X0\nOUT C0 K2\nEND\n"),
        ("one-less.il", "LD= C0 K1\nANI C0\nSwA D100\nLD X0\nOUT C0 K2\nEND\n"),
        ("over.il", "LD T0\nANI X0\nSwA D100\nLD X0\nOUT T0 K2\nEND\n"),
        ("resets.il", "LD X0\nOUT C0 K2\nLDF C0\nSwA D100\nLD X1\nRST C0\nEND\n"),
        ("held.il", "LD X0\nOR M600\nOUT M600\nLD M600\nANI X0\nSwA D100\nEND\n"),
    ] {
        for cpu in ["Q26UDV", "FX3U"] {
            assert!(fires(name, cpu, list, "9").0, "{name} {cpu}");
        }
    }
}

#[test]
fn a_counter_that_counts_a_loop_is_at_its_setting_at_most() {
    let list = "LD X1\nOUT C0 K7\nFOR C0\nLD SM400\nSwA D100\nNEXT\nEND\n";
    let report = report("counts-loop.il", "Q26UDV", list, ["9", "all"]);
    assert!(lower_ns(&report) <= 9_350_000, "{report}");
    assert!(lower_ns(&report) >= 9_300_000, "{report}");
}

#[test]
fn a_timer_that_ran_for_a_scan_is_over_if_the_scan_takes_longer() {
    let list = "LD X0\nOUTH T0 K2\nLD X0\nAND M0\nANI T0\nSwA D100\nLD X0\nOUT M0\nEND\n";
    assert!(!fires("must-be-over.il", "Q26UDV", list, "60").0);
    assert!(fires("may-run.il", "Q26UDV", list, "9").0);
}

#[test]
fn a_timer_is_over_as_late_as_a_run_shows() {
    // X0 has been on for one scan, for two scans, and the timer takes 60 s.
    for list in [
        "LD X0\nOUT T0 K600\nLD M0\nANI M1\nAND T0\nSwA D100\nLD M0\nOUT M1\nLD X0\nOUT M0\nEND\n",
        "LD X0\nOUT T0 K600\nLD M1\nANI M2\nAND T0\nSwA D100\nLD M1\nOUT M2\nLD M0\nOUT M1\nLD X0\nOUT M0\nEND\n",
        "LD X0\nOUT ST0 K600\nLD X1\nRST ST0\nLD M0\nANI M1\nAND ST0\nSwA D100\nLD M0\nOUT M1\nLD ST0\nOUT M0\nEND\n",
    ] {
        let (fires, is_reached) = fires("early.il", "Q26UDV", list, "9");
        assert!(!fires || is_reached, "{list}");
    }
    let over =
        "LD X0\nOUT T0 K600\nLD M0\nAND T0\nANI M1\nSwA D100\nLD T0\nOUT M1\nLD X0\nOUT M0\nEND\n";
    assert_eq!(fires("late.il", "Q26UDV", over, "9"), (true, true));
}

#[test]
fn no_lower_bound_rests_on_one_reading_of_a_reset() {
    // A timer that is reset while its coil is on goes on from 0 with the next scan, or starts anew in it.
    for (name, list, cpu) in [
        ("after.il", "LD SM400\nOUTH T0 K2\nLDI T0\nRST T0\nLD T0\nSwA D100\nEND\n", "Q26UDV"),
        ("before.il", "LD SM400\nOUTH T0 K2\nLD T0\nSwA D100\nLD SM400\nRST T0\nEND\n", "Q26UDV"),
        (
            "off.il",
            "LD SM400\nOUTH T0 K2\nLDI T0\nANI SM402\nSwA D100\nLD SM400\nRST T0\nEND\n",
            "Q26UDV",
        ),
        (
            "retentive.il",
            "LD SM400\nOUTH ST0 K2\nLD ST0\nSwA D100\nLD SM400\nRST ST0\nEND\n",
            "Q26UDV",
        ),
        ("fx.il", "LD M8000\nOUT T200 K2\nLDI T200\nRST T200\nLD T200\nSwA D100\nEND\n", "FX3U"),
    ] {
        let (fires, is_reached) = fires(name, cpu, list, "60");
        assert!(!fires, "{name}: {is_reached}");
    }
    let fx = "LD M8000\nOUT T200 K2\nLDI T200\nANI M8002\nSwA D100\nLD M8000\nRESET\nEND\n";
    let q = "LD SM400\nMOV K0 Z0\nOUTH T0 K2\nLDI T0\nANI SM402\nSwA D100\nLD SM400\nRESET\nEND\n";
    let counter = "LD SM400\nOUT C0 K1\nLD C0\nANI SM402\nSwA D100\nLD SM400\nRESET\nEND\n";
    for (list, cpu, reset) in [
        (fx, "FX3U", "ZRST T200 T200"),
        (fx, "FX3U", "ZRSTP T190 T210"),
        (q, "Q26UDV", "BKRST T0 K1"),
        (q, "Q26UDV", "BKRSTP T0 D5"),
        (&q.replace("T0", "ST0"), "Q26UDV", "BKRST ST0 K1"),
        (q, "Q26UDV", "RST T0Z0"),
        (&q.replace("MOV K0 Z0\n", ""), "Q26UDV", "RST T0Z0"),
        (counter, "Q26UDV", "BKRST C0 K1"),
    ] {
        let name = format!("{}.il", reset.replace(' ', "-"));
        let (fires, is_reached) = fires(&name, cpu, &list.replace("RESET", reset), "60");
        assert!(!fires, "{reset}: {is_reached}");
    }
    // A reset of other timers says nothing about this one.
    let over = fx.replace("LDI T200", "LD T200").replace("RESET", "ZRST T201 T210");
    assert_eq!(fires("others.il", "FX3U", &over, "60"), (true, true));
    // In either case it is off behind the reset.
    let list = "LD SM400\nOUT T0 K2\nRST T0\nLDI T0\nSwA D100\nEND\n";
    assert!(fires("behind-reset.il", "Q26UDV", list, "60").0);
}

#[test]
fn no_lower_bound_of_omron_rests_on_one_reading_of_a_reset() {
    // A counter counts again after a reset whose input stays on, or it does not.
    let by_input = "LD P_On\nLD P_First_Cycle\nCNT 0000 #0001\n";
    let by_cnr = "LD P_On\nCNR(545) C0000 C0000\nLD P_On\nLD P_Off\nCNT 0000 #0001\n";
    let timer = "LD P_On\nCNR(545) T0000 T0000\nLD P_On\nTIMH(015) 0000 #0002\n";
    for (name, begin, flag) in
        [("cnt", by_input, "C0000"), ("cnr", by_cnr, "C0000"), ("timer", timer, "T0000")]
    {
        for contact in ["LD", "LDNOT"] {
            let list =
                format!("{begin}{contact} {flag}\nANDNOT P_First_Cycle\nSwA D100\nEND(001)\n");
            let report = report(&format!("{name}-{contact}.il"), "CJ2M", &list, ["60", "all"]);
            assert!(lower_ns(&report) < 60_050_000, "{name} {contact}: {report}");
            assert!(upper_ns(&report) >= 60_050_000, "{name} {contact}: {report}");
        }
    }
}

#[test]
fn no_lower_bound_rests_on_what_an_input_in_an_omron_interlock_was() {
    // What counters, SFT and DIFU remember of their inputs while the interlock is active is open.
    let held = [
        ("count", "C0000", "LD P_On\nLD 0.02\nCNT 0000 #0002\n"),
        ("either", "C0000", "LD P_On\nLD 0.01\nLD NOT 0.02\nCNTR(012) 0000 #0001\n"),
        ("shift", "W0.00", "LD P_On\nLD P_On\nLD 0.02\nSFT(010) W0 W0\n"),
        ("pulse", "W0.00", "LD P_On\nDIFU(013) W0.00\n"),
    ];
    for (name, flag, body) in held {
        let list =
            |begin: &str, end: &str| format!("LD {flag}\nSwA D100\n{begin}{body}{end}END(001)\n");
        let name = format!("interlocked-{name}.il");
        let report =
            report(&name, "CJ2M", &list("LD 0.01\nIL(002)\n", "ILC(003)\n"), ["60", "all"]);
        assert!(lower_ns(&report) < 60_050_000, "{name}: {report}");
        assert!(upper_ns(&report) >= 60_050_000, "{name}: {report}");
    }
    // Outside of an interlock the edges are followed.
    let counts = "LD C0000\nSwA D100\nLD 0.01\nLD 0.02\nCNT 0000 #0002\nEND(001)\n";
    assert_eq!(fires("counts.il", "CJ2M", counts, "60"), (true, true));
}

#[test]
fn no_lower_bound_rests_on_limits_in_the_wrong_order() {
    let list = "LD P_On\nMOV(021) #0005 D10\nMOV(021) #FFFB D11\nZONE(682) D0 D10 D1\nLD P_On\n\
                AND=S(302) D1 #FFFE\nAND=S(302) D0 #0003\nSwA D100\nEND(001)\n";
    assert!(!fires("zone.il", "CJ2M", list, "9").0);
}

#[test]
fn no_lower_bound_rests_on_a_state_that_was_not_followed_to_its_beginning() {
    // M5000 and on take X0 from relay to relay, M6000 and on X1, M7000 and on whether not both are on: the last of the
    // three rows are never on together.
    let walking = |count: u32, others: u32| {
        let rows = [5000, 6000, 7000];
        let last: Vec<String> = rows.iter().map(|row| format!("M{}", row + count)).collect();
        let mut list = format!("LD {}\nAND {}\nAND {}\nSwA D100\n", last[0], last[1], last[2]);
        for at in (0..count).rev() {
            rows.iter().for_each(|row| {
                list += &format!("LD M{}\nOUT M{}\n", row + at, row + at + 1);
            });
        }
        list += "LD X0\nOUT M5000\nLD X1\nOUT M6000\nLDI X0\nORI X1\nOUT M7000\n";
        for one in 0..others {
            list += &format!("LD M{one}\nOUT Y10\nLD X8\nOUT M{one}\n");
        }
        list + "END\n"
    };
    for (name, count, others) in [("short", 2, 0), ("long", 12, 0), ("many", 2, 200)] {
        let (fires, _) = fires(&format!("{name}.il"), "Q26UDV", &walking(count, others), "9");
        assert!(!fires, "{name}");
    }
}

#[test]
fn a_range_with_its_ends_in_the_wrong_order_is_reset_as_the_cpu_does() {
    // X1 sets both relays, then the range is reset. The FX resets its first device alone; other CPUs may stop.
    let list = |relay: &str| {
        format!(
            "LD X1\nSET M2\nSET M5\nLD X0\nZRST M5 M2\nLD X1\nAND X0\nAND {relay}\nSwA D100\nEND\n"
        )
    };
    for (cpu, relay, most, least) in [
        ("FX3U", "M2", 9_050_000, 9_050_000),
        ("FX3U", "M5", 9_001_000, 9_001_000),
        ("FX5U", "M2", 9_050_000, 9_001_000),
        ("FX5U", "M5", 9_050_000, 9_001_000),
    ] {
        let report = report(&format!("order-{cpu}-{relay}.il"), cpu, &list(relay), ["9", "all"]);
        assert_eq!((upper_ns(&report), lower_ns(&report)), (most, least), "{cpu} {relay}");
    }
}

#[test]
fn a_counter_may_count_again_after_every_kind_of_reset() {
    // C0 counts again in the scan of its reset if its coil counts as off after it.
    let rest = "LD X0\nOUT C0 K1\nLD X0\nANI C0\nSwA D100\nEND\n";
    for (cpu, on, reset) in [
        ("FX3U", "M8000", "RST C0"),
        ("FX3U", "M8000", "ZRST C0 C0"),
        ("FX3U", "M8000", "ZRST C0 C5"),
        ("Q26UDV", "SM400", "RST C0"),
        ("Q26UDV", "SM400", "BKRST C0 K1"),
    ] {
        let list = format!("LD {on}\n{reset}\n{rest}");
        let name = format!("count-{}-{cpu}.il", reset.replace(' ', "-"));
        for trust in ["all", "none"] {
            let report = report(&name, cpu, &list, ["60", trust]);
            assert!(upper_ns(&report) >= 60_050_000, "{reset} {trust}: {report}");
        }
    }
}
