//! Tests of decoding, instruction by instruction, and of every error that it reports.

use super::decode::{DecodeOptions, decode};
use crate::catalog::{Extent, Role, find};
use crate::memory::Family;
use crate::source::{RawFile, RawInstruction, RawProject};
use scanbound_base::diagnostic::Diagnostic;
use scanbound_base::facts::Facts;
use scanbound_front::WordPositions;
use scanbound_ir::{Cell, Program, Step, Summary, Units, When, WordTarget, Write};
use scanbound_passes::passed;
use std::fmt::Write as _;

fn raw_file(name: &str, text: &str) -> RawFile {
    let instructions = text
        .split(['\n', ';'])
        .map(str::trim)
        .enumerate()
        .filter(|(_, line)| !line.is_empty())
        .map(|(n, line)| {
            let mut words = line.split_whitespace().map(str::to_owned);
            RawInstruction {
                line: n as u32 + 1,
                step: None,
                mnemonic: words.next().unwrap_or_default(),
                operands: words.collect(),
                text: line.into(),
                places: WordPositions::default(),
            }
        })
        .collect();
    RawFile {
        name: format!("{name}.il"),
        program: name.to_owned(),
        cpu: None,
        instructions,
        source: String::new(),
    }
}

fn decode_files(
    files: &[(&str, &str)],
    family: Family,
    facts: &Facts,
) -> Result<Program, Vec<Diagnostic>> {
    let project = RawProject {
        dialect: "melsec-list",
        files: files.iter().map(|(name, text)| raw_file(name, text)).collect(),
        ..RawProject::default()
    };
    let options = DecodeOptions {
        family,
        is_user_instruction: &|name| name.starts_with("FB"),
        facts,
        absent_calls_take_no_time: false,
    };
    decode(&project, &options).and_then(passed)
}

fn on(family: Family, text: &str) -> Result<Program, Vec<Diagnostic>> {
    decode_files(&[("main", text)], family, &Facts::default())
}

fn program(text: &str) -> Program {
    on(Family::Q, text).unwrap_or_else(|faults| panic!("{text}: {faults:?}"))
}

/// The codes and lines of the diagnostics that decoding the text gives.
fn faults(text: &str) -> Vec<(&'static str, Option<u32>)> {
    let faults = on(Family::Q, text).expect_err("a fault");
    faults.iter().map(|fault| (fault.code.name(), fault.line)).collect()
}

#[test]
fn rungs_are_counted_and_begin_anew_behind_an_output() {
    let p = program(
        "LD X0; AND X1; OUT Y0; OUT Y1; LD X2; LD X3; ORB; MPS; AND X4; OUT Y2; MPP; LD X5; OR X6; ANB; OUT Y3; END",
    );
    let blocks: Vec<u32> = p.instructions.iter().map(|i| i.block).collect();
    assert_eq!(blocks, [1, 1, 1, 1, 2, 2, 2, 2, 2, 2, 2, 2, 2, 2, 2, 3]);
    assert_eq!(p.blocks, 3);
}

#[test]
fn all_faults_are_told_at_once() {
    let text = "LD X0; ANB; OUT Y0; LD X1; MPP; OUT Y1; OUT Y2 Y3; LD X9 X1; OUT Q7; LD X0; NOSUCH D0; CJ P7; LD X1; FB1 D0; END";
    let found = faults(text);
    let codes: Vec<&str> = found.iter().map(|(code, _)| *code).collect();
    for code in
        ["no-block", "no-branch", "operand-count", "operand", "unknown-instruction", "no-label"]
    {
        assert!(codes.contains(&code), "{code} in {codes:?}");
    }
    assert_eq!(found[0], ("no-block", Some(2)));
}

#[test]
fn each_broken_structure_has_its_message() {
    for (text, code) in [
        ("OUT Y0; END", "no-rung"),
        ("AND X0; OUT Y0; END", "no-rung"),
        ("LD X0; LD X1; OUT Y0; END", "unjoined"),
        ("LD X0; MPS; AND X1; OUT Y0; LD X1; OUT Y1; END", "unjoined"),
        ("LD X0; END", "open-rung"),
        ("LD X0; MC N0 M0; LD X1; OUT Y0; END", "open-master-control"),
        ("LD X0; OUT Y0; MCR N0; END", "no-master-control"),
        ("FOR K2; LD X0; OUT Y0; END", "open-loop"),
        ("LD X0; OUT Y0; NEXT; END", "no-loop"),
        ("LD X0; BREAK D0 P0; P0; LD X0; OUT Y0; END", "no-loop"),
        ("FOR K0; LD X0; OUT Y0; NEXT; END", "loop-count"),
        ("P0; LD X0; CJ P0; END", "jump-back"),
        ("LD X0; CJ P0; FOR K2; P0; LD X1; OUT Y0; NEXT; END", "jump-into-loop"),
        (
            "LD X0; CJ P0; LD X1; MC N0 M0; P0; LD X2; OUT Y0; MCR N0; END",
            "jump-across-master-control",
        ),
        ("P0; LD X0; OUT Y0; P0; LD X0; OUT Y1; END", "double-label"),
        ("LD X0; CALL P0; FEND; P0; LD X0; OUT Y0; END", "no-return"),
        (
            "LD X0; CALL P0; FEND; P0; LD X0; CALL P1; RET; P1; LD X0; CALL P0; RET; END",
            "recursion",
        ),
        ("LD X0; ECALL \"SUB\" P0; END", "no-program"),
        ("LD X0; MOV K70000 D0; END", "operand"),
        ("LD X0; MOV K8M0 D0; END", "operand"),
        ("LD X0; MOV K1 X; END", "operand"),
        ("LD X0; MOV K1 K2; END", "operand"),
        ("LD D0; OUT Y0; END", "operand"),
    ] {
        let found = faults(text);
        assert!(found.iter().any(|(found, _)| *found == code), "{text}: {code} in {found:?}");
    }
}

#[test]
fn the_frame_is_checked_whatever_else_is_wrong_and_told_line_by_line() {
    let text = "P0; LD X0; MOV K1 K2; LD X0; CJ P0; LD X1; MOV K1 K3; END";
    assert_eq!(faults(text), [("operand", Some(3)), ("jump-back", Some(5)), ("operand", Some(7))]);
    // With an instruction that is not known, the structure may seem broken where it is not.
    let text = "P0; LD X0; NOSUCH D0; LD X0; CJ P0; END";
    assert_eq!(faults(text), [("unknown-instruction", Some(3))]);
}

#[test]
fn a_state_and_a_master_control_region_that_cut_across_each_other_are_refused() {
    let across = "jump-across-master-control";
    let text = "STL S0; LD X0; OUT Y0; MC N0 M0; LD X1; OUT Y1; RET; LD X1; OUT Y2; MCR N0; END";
    assert_eq!(faults(text), [(across, Some(1))]);
    let nested = text.replace("RET; LD X1; OUT Y2; MCR N0", "MCR N0; LD X1; OUT Y2; RET");
    assert!(on(Family::Q, &nested).is_ok());
}

#[test]
fn inputs_are_octal_on_the_fx() {
    assert!(on(Family::Fx, "LD X8\nOUT Y0\nEND").is_err());
    let p = on(Family::Fx, "LD X10\nOUT Y17\nEND").expect("octal numbers");
    let cell = scanbound_ir::Cell { area: crate::memory::area("X"), index: 8 };
    assert_eq!(p.cell_name(cell), "X10");
}

#[test]
fn pointers_that_files_share_are_found_in_the_other_file() {
    let files = [
        ("a", "LD X0; CALL P5; FEND; END"),
        ("b", "LD X0; OUT Y0; FEND; P5; LD X1; OUT Y1; RET; END"),
    ];
    let p = decode_files(&files, Family::Q, &Facts::default()).expect("a common pointer");
    let target = p.instructions.iter().find_map(|i| match i.step {
        Step::Call { target, .. } => Some(target),
        _ => None,
    });
    assert_eq!(&*p.instructions[target.expect("a call")].text, "P5");
    assert_eq!(p.mains.len(), 2);
}

#[test]
fn a_file_of_subroutines_alone_runs_only_where_it_is_called() {
    let main = ("a", "LD X0; CALL P5; FEND; END");
    let standby = |other: &str| {
        let files = [main, ("b", other)];
        let p = decode_files(&files, Family::Q, &Facts::default()).expect("a common pointer");
        assert_eq!(p.mains.len() + p.standby.len(), 2);
        p.standby
    };
    assert_eq!(standby("P5; LD X1; OUT Y1; RET; P6; LD X2; OUT Y2; RET; END"), [1]);
    assert_eq!(standby("NOPLF; P5; FOR K3; LD X1; OUT Y1; NEXT; RET; END"), [1]);
    // A main routine stands in front, or control may get past the return.
    for other in [
        "FEND; P5; LD X1; OUT Y1; RET; END",
        "LD X0; OUT Y0; P5; LD X1; OUT Y1; RET; END",
        "P5; LD X1; OUT Y1; FEND; P6; RET; END",
        "P5; LD X1; CJ P6; RET; P6; LD X2; OUT Y2; RET; END",
        "P5; LD X1; STOP; RET; END",
        "P5; LD X1; MC N0 M0; RET; MCR N0; RET; END",
    ] {
        assert_eq!(standby(other), [0; 0], "{other}");
    }
    // Something must run.
    let alone = on(Family::Q, "P5; LD X1; OUT Y1; RET; END").expect("a program");
    assert_eq!((alone.mains.len(), alone.standby.len()), (1, 0));
}

#[test]
fn a_loop_of_unknown_length_is_summarised() {
    let text = "FOR D0; LD X0; INC D5; LD X1; BREAK D9 P0; NEXT; P0; LD X0; OUT Y0; END";
    let p = program(text);
    let summary = p.instructions.iter().find_map(|one| match &one.step {
        Step::Summary(summary) => Some(summary),
        _ => None,
    });
    let Some(Summary { charges, exits, havocs, .. }) = summary.map(|summary| &**summary) else {
        panic!("{p:?}")
    };
    assert!(charges.iter().all(|&(_, times)| times == 32_767));
    assert_eq!(exits.len(), 1);
    assert!(!havocs.is_empty() && !p.approximations.is_empty());
}

#[test]
fn blocks_of_a_known_length_are_copied_word_by_word() {
    let p = program("LD X0; BMOV D0 D1 K3; END");
    let Write::Words(targets, _) = &p.instructions[1].effects[0].write else { panic!() };
    let d = |index| WordTarget::Cell(scanbound_ir::Cell { area: crate::memory::area("D"), index });
    assert_eq!(targets[..], [d(1), d(2), d(3)]);
    assert_eq!(p.instructions[1].timing.as_ref().map(|key| &key.units), Some(&Units::Exactly(3)));
}

#[test]
fn user_instructions_lose_their_operands() {
    let p = program("LD X0; FB7 D5; END");
    assert!(matches!(
        p.instructions[1].effects[..],
        [scanbound_ir::Effect { when: When::Fired, write: Write::Havoc(..) }]
    ));
    assert_eq!(p.approximations.len(), 1);
}

/// The text of `count` operands with which the instruction decodes, each after a blank. If the catalog does not know
/// the instruction, they are words.
fn operands(mnemonic: &str, count: usize) -> String {
    let entry = find(mnemonic, count).map(|found| found.entry.into_owned());
    let mut text = String::new();
    for n in 0..count {
        let operand = entry.as_ref().ok().map(|entry| entry.operands[n]);
        let place = 200 + 40 * n;
        let _ = match operand.map(|operand| (operand.role, operand.extent)) {
            Some((Role::Number, _)) => write!(text, " K3"),
            Some((Role::Address, _)) => write!(text, " \"U0\""),
            Some((Role::Source, Extent::Text)) => write!(text, " \"abc\""),
            Some((_, Extent::Bits(_))) => write!(text, " M{place}"),
            _ => write!(text, " D{place}"),
        };
    }
    text
}

const BIT_CONTACTS: [&str; 18] = [
    "LD", "LDI", "AND", "ANI", "OR", "ORI", "LDP", "LDF", "ANDP", "ANDF", "ORP", "ORF", "LDPI",
    "LDFI", "ANDPI", "ANDFI", "ORPI", "ORFI",
];
const STRUCTURES: [&str; 17] = [
    "ANB", "ORB", "MPS", "MRD", "MPP", "END", "FEND", "RET", "SRET", "IRET", "MC", "MCR", "FOR",
    "NEXT", "BREAK", "ECALL", "CJ",
];

/// The text of a rung around an instruction with `count` operands. `None` for instructions that need a structure of
/// their own, such as loops.
fn rung(mnemonic: &str, count: usize) -> Option<String> {
    let compares = mnemonic.contains(['=', '<', '>']) && !mnemonic.starts_with("BKCMP");
    let is_label = mnemonic.contains("<n>");
    if is_label || STRUCTURES.contains(&mnemonic) {
        return None;
    }
    let contact = |arguments: &str| {
        let before = if mnemonic.starts_with("LD") { "" } else { "LD X1;" };
        Some(format!("{before}{mnemonic}{arguments};OUT M5;"))
    };
    let arguments = match mnemonic {
        _ if compares && mnemonic.contains('$') => return contact(" D0 \"ab\""),
        _ if compares => return contact(" D0 K5"),
        _ if BIT_CONTACTS.contains(&mnemonic) => return contact(" X1F"),
        "INV" | "MEP" | "MEF" => return contact(""),
        "EGP" | "EGF" => return contact(" V5"),
        "OUT" | "OUTH" if count == 2 => " T5 K10".to_owned(),
        "OUT" | "SET" | "RST" | "PLS" | "PLF" | "FF" => " M9".to_owned(),
        "CALL" | "CALLP" => " P1".to_owned(),
        "NOPLF" => return Some("NOPLF;".to_owned()),
        _ => operands(mnemonic, count),
    };
    Some(format!("LD X1;{mnemonic}{arguments};"))
}

#[test]
fn every_instruction_of_real_programs_is_decoded() {
    let counts = include_str!("../../../tests/data/melsec-operand-counts.csv");
    let mut text = String::new();
    let mut tried = 0;
    for line in counts.lines().filter(|line| !line.starts_with('#')).skip(1) {
        let (mnemonic, counts) = line.rsplit_once(',').expect("two columns");
        let mnemonic = mnemonic.trim_matches('"');
        for count in counts.split_whitespace().map(|count| count.parse().expect("a count")) {
            if let Some(rung) = rung(mnemonic, count) {
                text.push_str(&rung);
                tried += 1;
            }
        }
    }
    text.push_str("LD X0; LD X1; ANB; LD X2; ORB; MPS; AND X3; OUT M7; MRD; OUT M8; MPP; OUT M9; LD X0; MC N0 M20;");
    text.push_str("LD X2; OUT M21; MCR N0; FOR K3; LD X1; BREAK D77 P5; NEXT; P5; LD X1; CJ P2; LD X2; OUT M44; P2;");
    text.push_str(
        "LD X1; ECALL \"main\" P1; FEND; P1; LD X1; OUT M50; RET; I0; LD X1; OUT M60; IRET; END",
    );
    assert!(tried > 180, "{tried} forms");
    let p = program(&text);
    let table = scanbound_timing::table::Table::builtin("qnudv").expect("a built-in table");
    let prices = scanbound_timing::price::price(&p, &table, &Facts::default());
    assert!(prices.is_ok(), "{prices:?}");
}

#[test]
fn a_stated_range_does_not_bound_a_count_that_the_scan_overwrites() {
    let text = "LD X0; MOV K100 D0; FOR D0; LD X1; FB1 D9; NEXT; LD X0; BMOV D10 D20 D0; END";
    let facts = Facts { ranges: [("D0".to_owned(), (1, 3))].into(), ..Facts::default() };
    let p = decode_files(&[("main", text)], Family::Q, &facts).expect("a program");
    assert!(p.instructions.iter().any(|i| matches!(i.step, Step::Summary(_))));
    let units = p.instructions.iter().filter_map(|i| i.timing.as_ref()).map(|key| &key.units);
    let most = |units: &Units| match units {
        Units::Counted(counted) => counted.most,
        _ => 0,
    };
    assert_eq!(units.into_iter().map(most).max(), Some(65_535));
}

#[test]
fn high_speed_counters_of_the_fx_are_taken_as_any_value() {
    let text = "LD X0; OUT C235 K10; LD C235; OUT Y0; LD> C235 K5; OUT Y1; LD X1; DMOV K0 C235; RST C235; END";
    on(Family::Fx, &text.replace(';', "\n")).expect("a program");
}

/// Whether the second instruction havocs this cell.
fn loses(p: &Program, area: &str, index: u32) -> bool {
    let cell = Cell { area: crate::memory::area(area), index };
    p.instructions[1]
        .effects
        .iter()
        .any(|effect| matches!(effect.write, Write::Havoc(region, _) if region.contains(cell)))
}

#[test]
fn results_in_digits_reach_as_far_as_there_are_results() {
    let fx = |text: &str| on(Family::Fx, &text.replace(';', "\n")).expect("a program");
    let five = fx("LD X0; SER D0 D10 K1Y0 K5; END");
    assert!(loses(&five, "Y", 19) && !loses(&five, "Y", 20));
    let ten = fx("LD X0; DSER D0 D10 K8M0 K5; END");
    assert!(loses(&ten, "M", 159) && !loses(&ten, "M", 160));
    let octal = fx("LD X0; PRUN K4X0 K4M0; END");
    assert!(loses(&octal, "M", 17));
    let double = fx("LD X0; DPRUN K8X0 K8M0; END");
    assert!(loses(&double, "M", 37));
    let one = fx("LD X0; DBCD D0 K8M0; END");
    assert!(loses(&one, "M", 31) && !loses(&one, "M", 32));
}

#[test]
fn sorts_of_both_families_are_understood() {
    let q = program("LD X0; SORT D0 K10 K2 M0 D100; END");
    assert!(loses(&q, "D", 5) && loses(&q, "M", 0) && loses(&q, "D", 101));
    let fx = on(Family::Fx, "LD X0\nSORT D0 K5 K4 D100 K2\nEND").expect("a program");
    assert!(loses(&fx, "D", 119));
}

#[test]
fn outputs_that_no_operand_names_may_change_at_any_moment() {
    let p = on(Family::Fx, "LD X0\nZRN K100 K10 X5 Y0\nLD Y4\nOUT M0\nEND").expect("a program");
    let Step::Logic { value, .. } = &p.instructions[2].step else { panic!() };
    assert!(matches!(value, scanbound_ir::Logic::Bit(scanbound_ir::BitSource::Free(_))));
}

#[test]
fn a_count_told_by_a_special_register_is_refused() {
    let text = "LD X0\nSET M8164\nLD X1\nFROM K0 K5 D0 K4\nEND";
    let faults = on(Family::Fx, text).expect_err("a fault");
    assert_eq!(
        faults.iter().map(|f| (f.code.name(), f.line)).collect::<Vec<_>>(),
        [("not-modelled", Some(4))]
    );
    on(Family::Fx, &text.replace("M8164", "M8163")).expect("a program");
}
