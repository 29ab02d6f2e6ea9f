//! The closed loop: a CPU whose times nobody knows runs the calibration program, and the fit finds them.

use scanbound::audit::{Ready, Request, audit, read, ready};
use scanbound::base::facts::Facts;
use scanbound::base::time::Picos;
use scanbound::calibrate::fit::{Fit, RowTimes, Unfit, fit};
use scanbound::calibrate::language::{RESULTS, STEP};
use scanbound::calibrate::result::Words;
use scanbound::calibrate::table::Origin;
use scanbound::calibrate::{Part, Plan, Settings, Spare, Written, result, table, write};
use scanbound::emulated::{Cpu, Disturbance};
use scanbound::front::{FRONTS, Input};
use scanbound::link::{Memory, registers};
use scanbound::program::Region;
use scanbound::timing::table::Table;
use std::collections::BTreeMap;
use std::fmt::Write;

/// A family: the CPU, its dialect and table, and a program that uses what is to be measured.
struct Family {
    cpu: &'static str,
    dialect: &'static str,
    table: &'static str,
    program: &'static str,
    /// Devices that may be written.
    spare: [&'static str; 2],
}

const QNUDV: Family = Family {
    cpu: "Q26UDV",
    dialect: "melsec-list",
    table: "qnudv",
    program: "LD X0\nANI X1\nOUT M10\nSET M11\nMOV D0 D10\n+ D0 D10\n* D0 D1 D20\n/ D0 D1 D22\nBMOV D0 D100 K20\nLD= D0 K5\nAND> D1 K3\nOUT Y10\nE+ D30 D32 D34\n\
              LD X2\nOUT T5 K10\nOUT C5 K10\nPLS M20\nLDP X3\nANDF X4\nOUT M21\nLD X5\nMPS\nAND X6\nOUT M22\nMRD\nAND X7\nOUT M23\n\
              MPP\nAND X8\nOUT M24\nLD X9\nOR XA\nLD XB\nOR XC\nANB\nOUT M25\nLD X9\nAND XA\nLD XB\nAND XC\nORB\nOUT M26\n\
              LD X0\nMC N0 M50\nLD X1\nOUT M27\nMCR N0\nLD X0\nCJ P3\nLD X1\nOUT M28\nP3\nFOR K3\nLD X1\nINC D50\nNEXT\nLD X2\nCALL P4\n\
              MOV D0Z3 D10\nMOV K4M100 D10\nFROM H4 K0 D200 K4\nTO H4 K10 D210 K4\nMOV U4\\G20 D220\nRST T5\nRST C5\nRST D5\nFEND\nP4\nLD SM400\nMOV D1 D2\nRET\nEND\n",
    spare: ["Y1F", "U4\\G100"],
};

const FX3U: Family = Family {
    cpu: "FX3U",
    dialect: "melsec-list",
    table: "fx3u",
    program: "LD X000\nAND X001\nOUT M10\nSET M11\nMOV D0 D10\nINC D5\nCMP D0 D1 M20\nMUL D0 D1 D20\nBMOV D0 D100 K20\nLD= D0 K5\nOUT Y010\n\
              LD X002\nOUT T5 K10\nOUT C5 K10\nPLS M20\nLDP X003\nOUT M21\nFOR K3\nLD X001\nINC D50\nNEXT\nLD X002\nCALL P4\nMOV D0Z0 D10\nFEND\n\
              P4\nLD M8000\nMOV D1 D2\nSRET\nEND\n",
    spare: ["Y017", "M7000"],
};

const CJ2M: Family = Family {
    cpu: "CJ2M",
    dialect: "omron-cx",
    table: "cj2m",
    program: "LD 0.00\nAND 0.01\nOUT W10.00\nSET W10.01\nMOV D0 D10\n+ D0 D1 D10\n* D0 D1 D20\nXFER &20 D0 D100\nANDW D1 D2 D3\n\
              LD 0.02\nTIM 0001 #0010\nLD 0.03\nSBS 4\nLD 0.04\nIL\nLD 0.05\nOUT W11.00\nILC\nLD 0.06\nJMP 5\nLD 0.05\nOUT W12.00\nJME 5\n\
              SBN 4\nLD P_On\nMOV D1 D2\nRET\nEND\n",
    spare: ["W100", "W101"],
};

/// Short scans, since what is emulated takes its time here.
const SETTINGS: Settings = Settings { scans: 3, scan_time: Picos(1_500_000_000), memory: 15_000 };

fn input(name: &str, bytes: &[u8]) -> Input {
    Input { name: name.to_owned(), bytes: bytes.to_vec() }
}

fn calibration(family: &Family, settings: Settings) -> Written {
    let inputs = [input("a.il", family.program.as_bytes())];
    let facts = Facts::default();
    let request = Request {
        cpu: Some(family.cpu),
        dialect: Some(family.dialect),
        ..Request::new(&inputs, &facts)
    };
    let program = read(&request).expect("a sound program");
    let table = Table::builtin(family.table).expect("a table");
    let spare = Spare::new(&family.spare.map(str::to_owned)).expect("devices");
    let written = write(Some(&program), &table, family.cpu, settings, &spare, FRONTS);
    written.expect("something to measure")
}

/// A CPU's own times, which the calibration does not know: of each row that it measures a part of what is assumed,
/// drawn by the row's name; on, off and a unit.
fn hidden(plan: &Plan) -> BTreeMap<String, [Picos; 3]> {
    let base = Table::builtin(&plan.table).expect("a table");
    let mut times = BTreeMap::new();
    for measure in plan.parts.iter().flat_map(|part| &part.measures) {
        let mut seed = measure
            .row
            .bytes()
            .fold(7u64, |sum, byte| (sum ^ u64::from(byte)).wrapping_mul(0x0100_0000_01B3));
        let mut part = |time: Picos| {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            Picos(time.0 * (300 + (seed >> 33) % 700) / 1000)
        };
        let named = measure.row.split(':').next().expect("a name");
        // Its class's row where it has none of its own: only the order of magnitude matters.
        let row =
            base.row(&measure.row).or_else(|| base.row(named)).or_else(|| base.row(class(named)));
        let row = row.unwrap_or_else(|| panic!("a row of {named}"));
        let (on, off, unit) = (part(row.on), part(row.off), part(row.per_unit));
        // The price of a contact is the larger of its two times.
        let both = ["LD", "AN", "OR"].iter().any(|contact| named.starts_with(contact))
            || ONE_TIME.contains(&named);
        let off = if both && named != "ANDW" { on } else { off };
        times.entry(measure.row.clone()).or_insert([on, off, unit]);
    }
    times
}

/// What is charged the larger of its two times.
const ONE_TIME: [&str; 13] =
    ["MPS", "MRD", "MPP", "MC", "MCR", "FOR", "NEXT", "RET", "SRET", "IL", "ILC", "JME", "SBN"];

fn class(name: &str) -> &'static str {
    match name {
        "OUT" => "@timer",
        "RST" | "SET" => "@set",
        "PLS" => "@pulse",
        "LDP" | "ANDF" | "ANB" | "ORB" => "@contact",
        "MPS" | "MRD" | "MPP" => "@stack",
        "MC" | "MCR" | "IL" | "ILC" => "@master",
        "CJ" | "JMP" | "JME" => "@jump",
        "FOR" | "NEXT" => "@loop",
        "CALL" | "RET" | "SRET" | "SBS" | "SBN" => "@call",
        "FROM" | "TO" => "@module",
        "*" | "MUL" => "@multiply",
        "/" => "@divide",
        "E+" => "@real",
        "INC" => "@arithmetic",
        "XFER" => "@block",
        name if name.contains(['=', '>']) => "@compare",
        _ => "@arithmetic",
    }
}

/// What END takes on these CPUs, beside what else each scan has by the table.
const END_US: u64 = 217;

fn table_of(plan: &Plan, times: &BTreeMap<String, [Picos; 3]>) -> Table {
    let mut text = "instruction,on_us,off_us,per_unit_us,unit\n".to_owned();
    writeln!(text, "@base,{}\n@factor,1\n@end,{END_US}", plan.table).expect("written");
    for (row, [on, off, unit]) in times {
        let (on, off, unit) = (on.us_text(), off.us_text(), unit.us_text());
        writeln!(text, "{row},{on},{off},{unit},unit").expect("written");
    }
    Table::parse("hidden.csv", text.as_bytes()).expect("a sound table").table
}

/// What the part's results are on a CPU with these times, and how long its program took.
fn run(part: &Part, file: &[u8], table: &Table, cpu: &str, noise: Disturbance) -> (Words, Picos) {
    let inputs = [input(&part.file, file)];
    let facts = Facts::default();
    let request = Request { cpu: Some(cpu), table: Some(table), ..Request::new(&inputs, &facts) };
    let Ready { program, table, prices, .. } = ready(&request).expect("a sound program");
    let registers = table.family.as_deref().and_then(registers::of);
    let times = prices.times();
    let mut cpu = Cpu::new(&program, &times, prices.overhead_sum(), registers, noise);
    let word = |cpu: &mut Cpu<'_>, at: u32| cpu.words("D", at, 1).expect("a register")[0];
    let most = u64::from(part.steps + 1) * u64::from(SETTINGS.scans + 3) + 100;
    while u32::from(word(&mut cpu, STEP)) < part.steps {
        assert!(cpu.scan().is_some(), "{:?}", cpu.halted());
        assert!(cpu.scans() <= most, "step {} of {}", word(&mut cpu, STEP), part.steps);
    }
    let words = cpu.words("D", RESULTS, 2 * part.steps).expect("registers");
    // As they come back: through a file.
    let text = result::write(RESULTS, &words);
    assert!(text.lines().count() <= 200);
    (result::read("r.csv", text.as_bytes()).expect("they are read"), cpu.clock())
}

fn results(written: &Written, table: &Table, cpu: &str, noise: Disturbance) -> (Vec<Words>, Picos) {
    let parts = written.plan.parts.iter().zip(&written.files);
    let all: Vec<(Words, Picos)> =
        parts.map(|(part, file)| run(part, file, table, cpu, noise)).collect();
    let took = all.iter().map(|(_, took)| *took).sum();
    (all.into_iter().map(|(words, _)| words).collect(), took)
}

fn found<'f>(fit: &'f Fit, row: &str) -> &'f RowTimes {
    fit.rows.iter().find(|found| found.row == row).expect("the row")
}

const NOISE: Disturbance = Disturbance { jitter: Picos(150_000_000), interrupt: None, seed: 3 };

/// Every time lies within its interval, so none that the table gets is below it.
fn holds(family: &Family) {
    let written = calibration(family, SETTINGS);
    let times = hidden(&written.plan);
    let (results, took) = results(&written, &table_of(&written.plan, &times), family.cpu, NOISE);
    let fit = fit(&written.plan, &results).expect("all results");
    assert_eq!(fit.rows.len(), times.len());
    for (row, [on, off, unit]) in &times {
        let found = found(&fit, row);
        let told = format!("{row}: {on} on, {off} off, {unit} a unit: {found:?}");
        assert!(found.on.low <= *on && *on <= found.on.high, "{told}");
        assert!(found.off.low <= *off && *off <= found.off.high, "{told}");
        if let Some(each) = found.per_unit {
            assert!(each.low <= *unit && *unit <= each.high, "{told}");
        }
    }
    // A scan that does nothing takes what END, the start of a program and all else of the table take together.
    let table = table_of(&written.plan, &times);
    let on = |row: &str| table.row(row).map_or(0, |row| row.on.0);
    let own = ["@end", "@program", "@end:latch", "@end:peripheral servicing"].map(on);
    let own = Picos(own.iter().sum::<u64>() + on("END").max(on("FEND")));
    let empty = fit.empty.expect("it was measured");
    // It counts the steps and chooses what is measured, too, which takes less than a millisecond.
    assert!(own <= empty.high && empty.high.0 <= own.0 + 1_000_000_000, "{own}: {empty:?}");
    for check in &fit.checks {
        assert!(check.steady && check.sum_agrees(), "{check:?}");
    }
    assert!(fit.checks.iter().any(|check| check.sum.is_some()));
    // No more than what was told beforehand, by times that are assumed high.
    let planned: u64 = written.plan.parts.iter().map(|part| part.takes_ms).sum();
    assert!(took.0 / 1_000_000_000 <= planned, "{took} of {planned} ms");
    let origin = Origin { date: "2026-11-23".to_owned(), serial: "0123".to_owned() };
    let text = table::write(&written.plan, &fit, &origin, false);
    let made = Table::parse("made.csv", text.as_bytes()).expect("a sound table");
    assert!(made.warnings.is_empty(), "{:?}", made.warnings);
    for (row, [on, off, _]) in &times {
        let row = made.table.row(row).expect("the row");
        assert!(row.on >= *on && row.off >= *off);
        assert_eq!(row.evidence.word(), "measured");
        assert!(row.source.contains("2026-11-23") && row.source.contains("serial 0123"));
    }
}

#[test]
fn the_loop_closes_for_qnudv() {
    holds(&QNUDV);
}

#[test]
fn the_loop_closes_for_fx3u() {
    holds(&FX3U);
}

#[test]
fn the_loop_closes_for_cj2m() {
    holds(&CJ2M);
}

/// A program that uses few instructions, for what hangs on no particular one.
const SMALL: Family =
    Family { program: "LD X0\nMOV D0 D10\n+ D0 D10\nWAND D0 D1\nSET M5\nEND\n", ..QNUDV };

#[test]
fn the_program_is_read_back_without_a_complaint() {
    let small = Family { program: "LD 0.00\nMOV D0 D10\nMOVL D0 D12\nEND\n", ..CJ2M };
    let fx = Family {
        program: "LD X000\nINC D5\nCALL P4\nMC N0 M50\nLDP X001\nOUT C5 K10\nMCR N0\nFEND\nP4\nLD X002\nOUT M1\nSRET\nEND\n",
        ..FX3U
    };
    for family in [SMALL, fx, small] {
        let written = calibration(&family, SETTINGS);
        for (part, file) in written.plan.parts.iter().zip(&written.files) {
            let inputs = [input(&part.file, file)];
            let facts = Facts::default();
            let cpu = Some(family.cpu).filter(|_| family.dialect == "omron-cx");
            let request = Request { cpu, ..Request::new(&inputs, &facts) };
            let found = audit(&request).expect("a sound program");
            assert!(found.warnings.is_empty(), "{:?}", found.warnings);
            assert!(found.unbounded.is_empty());
            let watchdog = found.table.watchdog.expect("a watchdog");
            assert!(found.bound.upper < watchdog, "{}: {}", part.file, found.bound.upper);
        }
    }
}

#[test]
fn a_run_that_was_disturbed_is_told() {
    let written = calibration(&SMALL, SETTINGS);
    let table = table_of(&written.plan, &hidden(&written.plan));
    // Long interruptions now and then.
    let interrupt = Some((Picos(5_000_000_000), Picos(61_000_000_000)));
    let noise = Disturbance { interrupt, ..NOISE };
    let (disturbed, _) = results(&written, &table, SMALL.cpu, noise);
    let told = fit(&written.plan, &disturbed).expect("all results");
    assert!(told.checks.iter().any(|check| !check.outliers.is_empty()), "{:?}", told.checks);
    let (quiet, _) = results(&written, &table, SMALL.cpu, NOISE);
    let told = fit(&written.plan, &quiet).expect("all results");
    assert!(told.checks.iter().all(|check| check.is_good()), "{:?}", told.checks);
    // A block that takes another time at the end.
    let mut drifted = quiet.clone();
    let [_, last] = written.plan.parts[0].reference;
    for at in [RESULTS + 2 * last, RESULTS + 2 * last + 1] {
        *drifted[0].0.get_mut(&at).expect("a result") += 40;
    }
    let told = fit(&written.plan, &drifted).expect("all results");
    assert!(!told.checks[0].steady);
    // A sum that is not that of the parts.
    let mut wrong = quiet.clone();
    let sum = written.plan.parts[0].sum.clone().expect("a sum");
    for at in [RESULTS + 2 * sum.full, RESULTS + 2 * sum.full + 1] {
        *wrong[0].0.get_mut(&at).expect("a result") += 300;
    }
    let told = fit(&written.plan, &wrong).expect("all results");
    assert!(!told.checks[0].sum_agrees());
}

#[test]
fn results_that_are_missing_are_told() {
    let written = calibration(&SMALL, SETTINGS);
    let part = &written.plan.parts[0];
    let mut words = Words((RESULTS..RESULTS + 2 * part.steps).map(|at| (at, 50)).collect());
    assert!(fit(&written.plan, std::slice::from_ref(&words)).is_ok());
    let zero = RESULTS + 7;
    words.0.insert(zero, 0);
    let told = fit(&written.plan, std::slice::from_ref(&words)).expect_err("a fault");
    assert!(matches!(told, Unfit::Unmeasured { step: 3, .. }), "{told}");
    words.0.remove(&zero);
    let told = fit(&written.plan, std::slice::from_ref(&words)).expect_err("a fault");
    assert!(told.to_string().contains("lack D1107"), "{told}");
    assert!(matches!(fit(&written.plan, &[]), Err(Unfit::Parts { .. })));
}

#[test]
fn nothing_is_written_but_what_was_named() {
    for family in [QNUDV, FX3U, CJ2M] {
        let written = calibration(&family, SETTINGS);
        for (part, file) in written.plan.parts.iter().zip(&written.files) {
            let inputs = [input(&part.file, file)];
            let facts = Facts::default();
            let request = Request { cpu: Some(family.cpu), ..Request::new(&inputs, &facts) };
            let program = read(&request).expect("a sound program");
            let last = RESULTS + 2 * part.steps;
            let named = |name: &str, at: u32| match name {
                "D" => at < 900 || (STEP..STEP + 11).contains(&at) || (RESULTS..last).contains(&at),
                "M" => at < 1000,
                "T" | "T coil " | "T value " | "C" | "C coil " | "C value " | "Z" => at == 0,
                "Y" => at == if family.cpu == "FX3U" { 0o17 } else { 0x1F },
                "W" => at < 10 || at == 500 || at == 501,
                // What instructions leave of their results: flags and the like.
                other => !matches!(other, "Y" | "L" | "B" | "ZR" | "CIO" | "H" | "ST" | "S" | "F"),
            };
            for at in 0..program.instructions.len() {
                for region in scanbound::program::flow::written(&program, at) {
                    let text = &program.instructions[at].text;
                    // Z0 is set to 0 before.
                    if text.ends_with("Z0") && matches!(region, Region::Area(_)) {
                        continue;
                    }
                    let Region::Range { first, count } = region else {
                        panic!("{text} writes {region:?}")
                    };
                    let name = &program.areas[usize::from(first.area.0)].name;
                    let within = (first.index..first.index + count).all(|at| named(name, at));
                    assert!(within, "{text} writes {name}{} and {count} on", first.index);
                }
            }
        }
    }
}
