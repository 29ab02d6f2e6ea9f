//! Timers, runs from power-up and real scans.

use super::{Run, audit, lower_ns, scanbound, upper_ns};
use crate::command::binary;
use scanbound::timing::table::CLASSES;
use serde_json::Value;
use std::path::Path;

/// Runs the command on a list with the table of `timer-same-scan`.
fn on_list(name: &str, list: &str, arguments: &str) -> Run {
    let directory = Path::new(env!("CARGO_TARGET_TMPDIR")).join("cases-timers");
    std::fs::create_dir_all(&directory).expect("a directory");
    let file = directory.join(name);
    std::fs::write(&file, list).expect("a file");
    let (command, rest) = arguments.split_once(' ').expect("a command and its arguments");
    let output = binary()
        .arg(command)
        .arg(&file)
        .args(rest.split_whitespace())
        .current_dir(super::case("timer-same-scan"))
        .output()
        .expect("the command runs");
    Run::of(&output)
}

/// The JSON report on a list for Q26UDV with the table of `timer-same-scan`.
fn q(name: &str, list: &str, more: &str) -> Value {
    let run =
        on_list(name, list, &format!("audit --table table.csv --cpu Q26UDV --format json {more}"));
    assert_eq!(run.code, Some(0), "{}{}", run.stdout, run.stderr);
    run.json()
}

/// Upper and lower bound in nanoseconds, and whether a run from power-up leads to the lower one.
fn bounds(report: &Value) -> (u64, u64, bool) {
    (upper_ns(report), lower_ns(report), report["scan"]["lower_kind"] == "reached")
}

/// The scans of the run from power-up: number and time in nanoseconds.
fn run_of(report: &Value) -> Vec<(u64, u64)> {
    let number = |value: &Value| value.as_u64().expect("a number");
    let scans = report["witness_run"].as_array().expect("a run");
    scans.iter().map(|scan| (number(&scan["scan"]), number(&scan["took_ps"]) / 1000)).collect()
}

#[test]
fn a_timer_is_not_over_in_the_scan_in_which_its_coil_comes_on() {
    for trust in ["none", "counts", "all"] {
        let arguments = format!("edge.il --table table.csv --cpu Q26UDV --trust {trust}");
        let report = audit("timer-same-scan", &arguments);
        assert_eq!(bounds(&report), (6_800, 6_800, true), "{trust}");
    }
    let check =
        "check edge.il --table table.csv --cpu Q26UDV --limit 10us --refute reached --format json";
    assert_eq!(scanbound("timer-same-scan", check).code, Some(0));
}

#[test]
fn a_run_waits_for_timers_as_long_as_its_scans_take() {
    let report = audit("timer-same-scan", "chained.il --table table.csv --cpu Q26UDV");
    assert_eq!(bounds(&report), (57_300, 57_300, true));
    let run = run_of(&report);
    let (last, scans) = run.split_last().expect("scans");
    assert_eq!(last.1, 57_300);
    // T0 takes 1 s, T1 60 s: at 7.8 us a scan.
    assert!(last.0 > 7_000_000 && run.len() < 8, "{run:?}");
    assert!(scans.iter().all(|scan| scan.1 < 57_300), "{run:?}");
    let text = scanbound("timer-same-scan", "audit chained.il --table table.csv --cpu Q26UDV");
    assert!(text.stdout.contains(" scans later"), "{}", text.stdout);

    let report = audit("timer-same-scan", "held.il --table table.csv --cpu Q26UDV");
    assert_eq!(bounds(&report), (57_300, 57_300, true));
    assert!(run_of(&report).last().is_some_and(|last| last.0 > 100_000));
    let check = "check held.il --table table.csv --cpu Q26UDV --limit 50us --refute reached";
    assert_eq!(scanbound("timer-same-scan", check).code, Some(1));
}

#[test]
fn an_omron_timer_is_not_over_in_the_scan_that_starts_it() {
    let report = audit("timer-same-scan", "c200h.il --cpu C200H");
    let run = run_of(&report);
    // 1 s at 3.9 ms a scan, and the tick by which a timer may be early.
    assert!(run.last().is_some_and(|last| last.0 > 200), "{run:?}");
    assert!(run[0].1 < run[run.len() - 1].1, "{run:?}");
}

#[test]
fn what_one_scan_can_take_decides_which_settings_are_long_enough() {
    let list = |setting: &str| format!("LD X5\nOUT T0 {setting}\nLD T0\nANDP X5\nSwD D4\nEND\n");
    // 0 and 1 may be over at once: a unit of 100 ms may be as good as over.
    for setting in ["K0", "K1", "D100"] {
        let report = q("open.il", &list(setting), "");
        assert_eq!(upper_ns(&report), 56_300, "{setting}");
    }
    for setting in ["K2", "K32767"] {
        let report = q("short.il", &list(setting), "");
        assert_eq!(bounds(&report), (6_800, 6_800, true), "{setting}");
    }
    // A word counts by what it can be.
    let stated = format!("LD SM400\nMOV K20 D100\n{}", list("D100"));
    let report = q("moved.il", &stated, "--time MOV=0us");
    assert_eq!(upper_ns(&report), 6_900);
    // A loop that takes longer than the timer.
    let long = format!("FOR K32000\nLD X0\nSwD D9\nNEXT\n{}", list("K10"));
    let report = q("long.il", &long, "--time FOR=0us --time NEXT=0us");
    assert_eq!(upper_ns(&report), 32_000 * 50_100 + 56_300);
}

#[test]
fn a_timer_whose_value_others_write_may_be_over_at_any_moment() {
    let list = "LD X5\nMOV K10 T0\nLD X5\nOUT T0 K10\nLD T0\nANDP X5\nSwD D4\nEND\n";
    let report = q("written.il", list, "--time MOV=0us");
    assert_eq!(upper_ns(&report), 56_400);
}

#[test]
fn a_reset_makes_a_timer_start_anew() {
    // Reset in every scan before its coil: it never runs for longer than a scan.
    let list = "LD SM400\nRST T0\nLD X5\nOUT T0 K10\nLD T0\nSwD D4\nEND\n";
    let report = q("reset.il", list, "--time RST=0us");
    assert_eq!(bounds(&report), (6_800, 6_800, true));
    let retentive = list.replace("T0", "ST0");
    let report = q("retentive.il", &retentive, "--time RST=0us --time OUT:ST=1us");
    assert_eq!(upper_ns(&report), lower_ns(&report));
    assert!(upper_ns(&report) < 50_000);
}

#[test]
fn a_retentive_timer_goes_on_where_it_stood() {
    // X5 comes and goes: the time adds up.
    let list = "LD X5\nOUT ST0 K10\nLD ST0\nANI X5\nSwD D4\nEND\n";
    let report = q("adds.il", list, "--time OUT:ST=1us --time ANI=0.1us");
    assert_eq!(bounds(&report), (56_300, 56_300, true));
    let run = run_of(&report);
    assert!(run.last().is_some_and(|last| last.0 > 100_000), "{run:?}");
}

#[test]
fn a_timer_that_is_executed_twice_in_a_scan_is_not_over_in_it() {
    let list = "LD X5\nOUT T0 K10\nLD X5\nOUT T0 K10\nLD T0\nANDP X5\nSwD D4\nEND\n";
    let report = q("twice.il", list, "");
    // The second execution finds that the timer ran before; that this was in the same scan only real runs know.
    assert!(lower_ns(&report) < 10_000, "{report}");
}

#[test]
fn a_run_does_not_know_a_timer_whose_coil_was_unknown() {
    // Whether MOVP runs in the first scan is unknown, and with it whether T5 runs from there on. Then its contact rises
    // before M13 is on.
    let list = "LDI X1\nAND X0\nMOV K1 D0\nLD>= D0 K0\nMOVP K1 D5\nLDP T5\nAND M13\nINC D9\n\
        LD= D5 K1\nOR X0\nOUTH T5 K1\nLD M12\nOUT M13\nLD M11\nOUT M12\nLD SM402\nOUT M11\nEND\n";
    let mut table = "instruction,on_us,off_us\n".to_owned();
    table.extend(CLASSES.iter().map(|class| format!("@{class},0,0\n")));
    table += "INC,800,0\nMOV,3,1\n@end,50000,\n";
    let file = Path::new(env!("CARGO_TARGET_TMPDIR")).join("late-timer.csv");
    std::fs::write(&file, table).expect("a file");
    let table = file.display();
    let arguments = format!("audit --table {table} --cpu Q26UDV --trust all --format json");
    let run = on_list("late.il", list, &arguments);
    assert_eq!(bounds(&run.json()), (50_806_000, 50_006_000, false), "{}", run.stderr);
}

#[test]
fn a_report_shows_no_run_that_takes_longer_than_its_lower_bound() {
    let arguments = "witness-run-longer.il --table witness-run-longer.csv --cpu Q26UDV";
    let report = audit("attack", arguments);
    let run = run_of(&report);
    assert_eq!(run.iter().map(|scan| scan.1).max(), Some(lower_ns(&report)));
    assert_eq!(lower_ns(&report), 14_176_000);
    let check = scanbound("attack", &format!("check {arguments} --limit 10ms"));
    assert_eq!(check.code, Some(1), "{}{}", check.stdout, check.stderr);
}

#[test]
fn the_first_pass_of_a_flowchart_is_a_run_from_power_up() {
    let check = "check first-pass.lst --limit 200us --refute reached";
    let run = scanbound("flowchart-power-up", check);
    assert_eq!(run.code, Some(1), "{}{}", run.stdout, run.stderr);
    let report = audit("flowchart-power-up", "first-pass.lst");
    assert_eq!(bounds(&report), (245_000, 245_000, true));
    assert_eq!(run_of(&report), [(1, 245_000)]);
}

#[test]
fn cnr_tim_may_leave_a_timer_the_rest_of_its_time() {
    let report = audit("cnr-tim", "restart.lst");
    assert_eq!(upper_ns(&report), 350_000);
    // Which of both a PLC does no lower bound rests on.
    assert_eq!((lower_ns(&report), &report["scan"]["exact"]), (240_000, &Value::Bool(false)));
    let told = report["approximations"].as_array().expect("a list");
    let about_reset =
        |one: &&Value| one["what"].as_str().is_some_and(|what| what.contains("CNR TIM"));
    assert_eq!(told.iter().filter(about_reset).count(), 1, "{report}");
    let check = scanbound("cnr-tim", "check restart.lst --limit 300us");
    assert_eq!(check.code, Some(3), "{}{}", check.stdout, check.stderr);
}

#[test]
fn a_flowchart_timer_takes_its_time_in_a_run() {
    // 3 s of passes between the one that starts the timer and the one that finds it over.
    let list = "LBL0: AND 0\nCJP LBL1\nJMP LBL0\nLBL1: TIM 10 #30\nCJP LBL2\nJMP LBL1\n\
                LBL2: OUT 200\nOUT 201\nOUT 202\nOUT 203\nOUT 204\nOUT 205\nOUT 206\nJMP LBL0\n";
    let run = on_list("waits.lst", list, "audit --format json");
    assert_eq!(run.code, Some(0), "{}{}", run.stdout, run.stderr);
    let report = run.json();
    assert_eq!(report["scan"]["lower_kind"], "reached", "{report}");
    assert!(run_of(&report).last().is_some_and(|last| last.0 > 5_000), "{report}");
}

#[test]
fn iec_timers_take_their_time_in_a_run() {
    let body = |kind: &str, condition: &str| {
        format!(
            "PROGRAM p\nVAR x AT %IX0.0 : BOOL; y : BOOL; i : INT; t : {kind}; END_VAR\n\
             t(IN := x, PT := T#10s);\nIF t.Q AND NOT x THEN y := TRUE; END_IF;\n\
             IF {condition} THEN i := 1; i := 2; i := 3; i := 4; i := 5; i := 6; END_IF;\n\
             END_PROGRAM\n"
        )
    };
    for (kind, condition) in [("TON", "t.Q"), ("TP", "x AND NOT t.Q"), ("TOF", "y AND NOT t.Q")] {
        let run = on_list(&format!("{kind}.st"), &body(kind, condition), "audit --format json");
        assert_eq!(run.code, Some(0), "{}{}", run.stdout, run.stderr);
        let report = run.json();
        assert_eq!(report["scan"]["lower_kind"], "reached", "{kind}: {report}");
        // 10 s at some 55 us a scan.
        let last = run_of(&report).last().copied();
        assert!(last.is_some_and(|last| last.0 > 150_000), "{kind}: {last:?}");
    }
}

#[test]
fn an_omron_instruction_sees_an_edge_once() {
    // DM0 counts edges of 00000: a run to 3 of them takes at least six scans, or five after one that was on.
    let list = "LD 00000\n@ADD(30) DM0000 #0001 DM0000\nLD 25313\nCMP(20) DM0000 #0003\n\
                LD 25506\nMOV(21) #0001 DM0010\nMOV(21) #0002 DM0011\nEND(01)\n";
    let run = on_list("edges.il", list, "audit --cpu C200H --format json --trust all");
    assert_eq!(run.code, Some(0), "{}{}", run.stdout, run.stderr);
    let report = run.json();
    if report["scan"]["lower_kind"] == "reached" {
        assert!(run_of(&report).len() >= 5, "{report}");
    }
}

#[test]
fn repeat_begins_where_the_statement_behind_it_left_its_counter() {
    let body =
        |loops: &str| format!("PROGRAM p\nVAR i : INT; END_VAR\n{loops}\ni := 0;\nEND_PROGRAM\n");
    for (name, loops) in [
        ("repeat.st", "REPEAT i := i + 1; UNTIL i >= 10 END_REPEAT;"),
        ("down.st", "REPEAT i := i - 1; UNTIL i <= -12 END_REPEAT;"),
    ] {
        let run = on_list(name, &body(loops), "audit --format json");
        assert_eq!(run.code, Some(0), "{name}: {}{}", run.stdout, run.stderr);
        let report = run.json();
        assert_eq!(report["scan"]["exact"], true, "{name}: {report}");
        assert!(upper_ns(&report) < 70_000, "{name}: {report}");
    }
    // A counter that survives a failure of the power may be anywhere: nothing is proved of it.
    let retained =
        body("REPEAT i := i + 1; UNTIL i >= 10 END_REPEAT;").replace("VAR i", "VAR RETAIN i");
    let run = on_list("retained.st", &retained, "check --limit 1ms");
    assert_ne!(run.code, Some(0), "{}{}", run.stdout, run.stderr);
}

/// A table by which MOV takes 50 us, jumps differ by their condition, and all else takes next to nothing.
const CJ: &str = "audit --cpu CJ2M --format json --table cj.csv";

/// The JSON report on a list for CJ2M.
fn cj(name: &str, list: &str, more: &str) -> Value {
    let table = "instruction,on_us,off_us\nMOV,50,1\n@contact,0.1,\n@coil,0.1,\n@pulse,0.1,\n@timer,0.1,\n\
                 @counter,0.1,\n@shift,0.1,\n@jump,0.1,\n@loop,0.1,\nCJP,100,10\nBREAK,40,10\nEND,1,\n";
    let directory = Path::new(env!("CARGO_TARGET_TMPDIR")).join("cases-timers");
    std::fs::create_dir_all(&directory).expect("a directory");
    // A file for each list: tests run at the same time.
    let file = directory.join(format!("{name}.csv"));
    std::fs::write(&file, table).expect("a file");
    let arguments = CJ.replace("cj.csv", file.to_str().expect("a name"));
    let run = on_list(name, list, &format!("{arguments} {more}"));
    assert_eq!(run.code, Some(0), "{}{}", run.stdout, run.stderr);
    run.json()
}

#[test]
fn jumps_with_a_condition_take_the_time_of_that_condition() {
    for (name, list, bound) in [
        // It jumps: LD, CJP, JME, END.
        (
            "cjp.il",
            "LD 0.00\nCJP(510) #1\nLD 0.01\nMOV(021) D0 D1\nJME(005) #1\nEND(001)\n",
            101_200,
        ),
        // It does not leave the loop: FOR, LD, BREAK, LD, MOV, NEXT, END.
        (
            "break.il",
            "FOR(512) &1\nLD 0.00\nBREAK(514)\nLD 0.01\nMOV(021) D0 D1\nNEXT(513)\nEND(001)\n",
            61_400,
        ),
    ] {
        assert_eq!(bounds(&cj(name, list, "")), (bound, bound, true), "{name}");
    }
}

#[test]
fn an_accumulative_timer_takes_its_time_in_a_run() {
    // It is over when 0.05 has been on for 999.9 s, and stays so: then 0.05 goes off, and on again.
    let list = "LD 0.05\nLD 0.06\nTTIM(087) 0 #9999\nLD 0.05\nANDNOT 10.00\nAND T0\nMOV(021) D0 D1\n\
                LD 0.05\nOUT 10.00\nEND(001)\n";
    for (name, list) in [
        ("accumulates.il", list.to_owned()),
        ("accumulates-binary.il", list.replace("TTIM(087) 0 #9999", "TTIMX(555) 0 &9999")),
        ("accumulates-never-reset.il", list.replace("LD 0.06", "LD P_Off")),
    ] {
        let report = cj(name, &list, "");
        assert_eq!(report["scan"]["lower_kind"], "reached", "{name}: {report}");
        let run = run_of(&report);
        let last = run.last().expect("scans");
        // The scans before take no more than 10 us.
        assert!(last.1 > 50_000 && last.0 > 90_000_000, "{name}: {run:?}");
        assert!(run.iter().any(|scan| scan.0 == last.0 - 1), "{name}: {run:?}");
    }
    // One that is reset whenever it does not run is never over in the scan that starts it.
    let restarts = list.replace("LD 0.06", "LDNOT 0.05").replace("ANDNOT 10.00", "UP(521)");
    let report = cj("accumulates-anew.il", &restarts, "--trust all");
    assert!(lower_ns(&report) < 50_000, "{report}");
}

#[test]
fn counters_and_shift_registers_go_by_edges() {
    // What the flag or bit was before the instruction, and that its input was on before: then it cannot come on.
    let list = |coil: &str, bit: &str| {
        format!(
            "LD {bit}\nOUT W0.00\nLD P_On\n{coil}\nLD {bit}\nANDNOT W0.00\nAND W0.01\nMOV(021) D0 D1\n\
             LD P_On\nOUT W0.01\nEND(001)\n"
        )
    };
    for (name, coil, bit) in [
        ("counts.il", "LD 0.06\nCNT 0 #9999", "C0"),
        ("counts-both-ways.il", "LD P_Off\nLD 0.06\nCNTR(012) 0 #9999", "C0"),
        ("shifts.il", "LD P_On\nLD 0.06\nSFT(010) W5 W5", "W5.00"),
    ] {
        // A shift register's first branch is its data, the second what shifts it.
        let report = cj(name, &list(coil, bit), "--trust all");
        // Whether a shift register sees its input during a reset is open.
        let is_low = lower_ns(&report) < 10_000;
        let may_be_high = name == "shifts.il" && report["scan"]["lower_kind"] == "admissible";
        assert!(is_low || may_be_high, "{name}: {report}");
        // An input that is off in between counts.
        let counts = list(coil, bit).replacen("LD P_On", "LD 0.00", 1).replace("AND W0.01\n", "");
        let report = cj(&format!("again-{name}"), &counts.replace("#9999", "#0002"), "");
        assert_eq!(bounds(&report).0, bounds(&report).1, "{name}: {report}");
    }
}

#[test]
fn a_present_value_that_the_program_has_read_lets_one_unit_pass() {
    // T0 stands at 1 of 9 when the scan begins: it is not over in it.
    for timer in ["T0", "ST0"] {
        let list = format!(
            "LD= {timer} K1\nOUT M5\nLD X5\nOUT {timer} K9\nLD M5\nAND {timer}\nSwD D4\nEND\n"
        );
        let report = q(
            &format!("seen-{timer}.il"),
            &list,
            "--time LD==0.1us --time OUT=0.1us --time OUT:ST=1us --time AND=0.1us",
        );
        assert!(lower_ns(&report) < 10_000, "{timer}: {report}");
    }
    // At 8 it may be.
    let list = "LD= T0 K8\nOUT M5\nLD X5\nOUT T0 K9\nLD M5\nAND T0\nSwD D4\nEND\n";
    let report = q("seen-last.il", list, "--time LD==0.1us --time OUT=0.1us --time AND=0.1us");
    assert_eq!(lower_ns(&report), upper_ns(&report));
}

/// What a list takes at most and at least on a CPU, with its built-in table, in nanoseconds.
fn on_cpu(cpu: &str, name: &str, list: &str, more: &str) -> (u64, u64, bool) {
    let run = on_list(name, list, &format!("audit --cpu {cpu} --format json {more}"));
    assert_eq!(run.code, Some(0), "{name}: {}{}", run.stdout, run.stderr);
    bounds(&run.json())
}

#[test]
fn no_lower_bound_rests_on_a_timer_that_is_over_in_the_scan_that_starts_it() {
    for (cpu, list) in [
        ("FX3U", "LD X0\nOUT T0 SETTING\nLDP X0\nAND T0\nBMOV D0 D100 K100\nEND\n"),
        ("Q26UDV", "LD X0\nOUT T0 SETTING\nLDP X0\nAND T0\nBMOV D0 D100 K100\nEND\n"),
        ("FX3U", "LD X0\nOUT M0\nLD M0\nOUT T0 SETTING\nLDP M0\nAND T0\nBMOV D0 D100 K100\nEND\n"),
        ("Q26UDV", "LD X0\nOUT T0 SETTING\nLDP X0\nAND T0\nAND T0\nBMOVP D0 D100 K100\nEND\n"),
    ] {
        for (setting, trust) in [("K1", "none"), ("K1", "counts"), ("K1", "all"), ("K50", "all")] {
            let list = list.replace("SETTING", setting);
            let more = format!("--trust {trust}");
            let (upper, lower, _) = on_cpu(cpu, "starts.il", &list, &more);
            let without = list.replace("AND T0", "ANI SM400\nAND M8000");
            let without = if cpu == "FX3U" {
                without.replace("ANI SM400\nAND M8000", "ANI M8000")
            } else {
                without.replace("\nAND M8000", "")
            };
            let least = on_cpu(cpu, "never.il", &without, &more).1;
            // A contact of a timer may take another time than one of a relay, but no 10 us.
            assert!(lower < least + 10_000, "{cpu} {setting} {trust}: {lower} {least}\n{list}");
            assert!(lower <= upper);
        }
    }
}

#[test]
fn no_lower_bound_rests_on_edges_that_contradict_each_other() {
    // Either the input came on in this scan, or it was on before.
    let list = "LD 0.00\nUP(521)\nMOV(021) D0 D1\nLDNOT 0.01\nAND 0.00\nDOWN(522)\nAND 0.00\n@MOV(021) D0 D1\n\
                END(001)\n";
    for trust in ["none", "counts", "all"] {
        let report = cj("edges.il", list, &format!("--trust {trust}"));
        assert!((50_000..60_000).contains(&lower_ns(&report)), "{trust}: {report}");
        assert!(upper_ns(&report) > 60_000 || report["scan"]["exact"] == true, "{report}");
    }
    // The same edge at two places.
    let twice = "LD 0.00\nUP(521)\nMOV(021) D0 D1\nLD 0.00\nDIFU(013) W0.00\nLD W0.00\nMOV(021) D0 D1\nEND(001)\n";
    let report = cj("twice.il", twice, "");
    assert!(lower_ns(&report) > 100_000 && report["scan"]["exact"] == true, "{report}");
}

#[test]
fn a_present_value_agrees_with_its_flag() {
    let list =
        |first: &str| format!("{first}\nMOV(021) D0 D1\nLD 0.00\nLD 0.01\nCNT 0 #0003\nEND(001)\n");
    for (first, is_possible) in [
        ("LDNOT C0\nAND=(300) C0 #0005", false),
        ("LD C0\nAND=(300) C0 #0002", false),
        ("LDNOT C0\nAND=(300) C0 #0002", true),
        ("LD C0\nAND=(300) C0 #0000", true),
    ] {
        for trust in ["counts", "all"] {
            let report = cj("agrees.il", &list(first), &format!("--time ==0.1us --trust {trust}"));
            assert_eq!(lower_ns(&report) > 50_000, is_possible, "{first} {trust}: {report}");
        }
    }
    for (first, is_possible) in
        [("LDI C0\nAND= C0 K5", false), ("LD C0\nAND= C0 K2", false), ("LDI C0\nAND= C0 K2", true)]
    {
        let list = format!("{first}\nSwD D4\nLD X0\nOUT C0 K3\nEND\n");
        let report = q("agrees-q.il", &list, "--time AND==0.1us --time LDI=0.1us --time OUT:C=1us");
        assert_eq!(lower_ns(&report) > 50_000, is_possible, "{first}: {report}");
    }
}

#[test]
fn a_counter_with_two_instructions_may_compare_either_input() {
    // Whether the second instruction finds that the first one's input was off is open, so it may count in every scan.
    let list = "LD P_Off\nLD P_Off\nCNT 0 #0002\nLD P_On\nLD P_Off\nCNT 0 #0002\nLD C0\nANDNOT W0.00\nAND W0.01\n\
                MOV(021) D0 D1\nLD C0\nOUT W0.00\nLD P_On\nOUT W0.01\nEND(001)\n";
    let report = cj("two-counters.il", list, "");
    assert!(upper_ns(&report) > 50_000, "{report}");
}

#[test]
fn what_a_jump_zero_passes_over_may_take_no_time() {
    let list = "LD 0.00\nJMP0(515)\nLD 0.01\nMOV(021) D0 D1\nLD 0.02\nMOV(021) D0 D2\nJME0(516)\nEND(001)\n";
    let (upper, lower, _) = on_cpu("CJ2M", "jump-zero.il", list, "");
    assert!(lower < upper, "{lower} {upper}");
    let run = on_list("jump-zero.il", list, "audit --cpu CJ2M");
    let text = run.stdout.split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(text.contains("how long the PLC takes to skip an instruction"), "{text}");
}

#[test]
fn no_lower_bound_rests_on_a_timer_s_contact_that_its_coil_has_switched_off() {
    // T0 is on when the scan starts: then X5 was on in the scan before, and does not come on now.
    let list = "LD T0\nANDP X5\nSwD D4\nLD X5\nOUT T0 K2\nEND\n";
    let report = q("switched-off.il", list, "--trust all");
    assert!(lower_ns(&report) < 50_000, "{report}");
}
