//! Tests of decoding: instruction by instruction, operands, control, faults.

use super::decode::decode;
use super::project;
use super::source::RawProject;
use scanbound_base::diagnostic::Diagnostic;
use scanbound_base::facts::{Facts, InterruptRate};
use scanbound_base::time::{Picos, Times};
use scanbound_front::Options;
use scanbound_front::{Dialect, Fronts, Input};
use scanbound_ir::Witness;
use scanbound_ir::{Program, Region, Step, Units, Write};
use scanbound_passes::passed;
use scanbound_replay::replay;

fn input(name: &str, text: &str) -> Input {
    Input { name: name.to_owned(), bytes: text.as_bytes().to_vec() }
}

fn dialect(name: &str) -> &'static Dialect {
    super::DIALECTS.iter().find(|dialect| dialect.name == name).unwrap()
}

fn raw(name: &str, text: &str) -> RawProject {
    project::read(dialect(name), &[&input("a.txt", text)], &[]).unwrap()
}

fn decoded(name: &str, text: &str) -> Result<Program, Vec<Diagnostic>> {
    let facts = Facts::default();
    let options = Options { is_user_instruction: &|name| name == "SwOp0", ..Options::new(&facts) };
    decode(&raw(name, text), &options).and_then(passed)
}

fn c(text: &str) -> Program {
    decoded("omron-c200h", text).unwrap()
}

fn cx(text: &str) -> Program {
    decoded("omron-cx", text).unwrap()
}

/// The faults' codes with their lines.
fn faults(name: &str, text: &str) -> Vec<(&'static str, u32)> {
    let faults = decoded(name, text).unwrap_err();
    faults.iter().map(|fault| (fault.code.name(), fault.line.unwrap_or(0))).collect()
}

/// Which instructions of the source fire in a scan, by text; all start values and choices are 0 but those given
/// as a cell's written name.
fn fires(program: &Program, on: &[(&str, u16)], choices: u16) -> Vec<(String, bool)> {
    let mut witness = Witness::default();
    for (at, area) in program.areas.iter().enumerate() {
        for &(name, value) in on {
            if let Some(Ok(index)) = name.strip_prefix(area.name.as_str()).map(str::parse) {
                let area = scanbound_ir::AreaId(at as u16);
                witness.start.insert(scanbound_ir::Cell { area, index }, value);
            }
        }
    }
    for id in 0..program.choices {
        let choice = scanbound_ir::ChoiceId(id);
        let key = scanbound_ir::ChoiceKey { frames: Vec::new(), choice, cell: None };
        witness.choices.insert(key, choices);
    }
    let times = vec![Times::new(Picos(1), Picos(1)); program.instructions.len()];
    let events = replay(program, &times, &witness).events;
    let priced =
        events.iter().filter(|event| program.instructions[event.instruction].timing.is_some());
    priced
        .map(|event| (program.instructions[event.instruction].text.to_string(), event.fired))
        .collect()
}

fn fired(program: &Program, text: &str, on: &[(&str, u16)], choices: u16) -> Option<bool> {
    fires(program, on, choices).into_iter().find(|(own, _)| own == text).map(|(_, fired)| fired)
}

#[test]
fn the_reset_priority_self_holding_circuit() {
    let program = c(
        "00000 LD NOT 00300 (MAIN :B01)\n00001 AND 00001\n00002 AND NOT 00002\n00003 OUT 00305\nLD 00300\nAND 00002\nOUT 00306\nLD 00305\nOR 00300\nAND NOT 00306\nOUT 00300\nEND\n",
    );
    assert_eq!(program.blocks, 4);
    assert_eq!(program.approximations, []);
    assert_eq!(fired(&program, "OUT 00300", &[("IR0", 2)], 0), Some(true));
    assert_eq!(fired(&program, "OUT 00300", &[("IR0", 6), ("IR3", 1)], 0), Some(false));
    assert_eq!(program.files[0].count, 12);
    assert_eq!(program.points, Some([16, 16]));
}

#[test]
fn keep_is_set_held_and_reset_with_priority() {
    let program = c("LD 00000\nLD 00001\nKEEP(11) 00300\nLD 00300\nMOV(21) #1 DM 0\nEND(01)");
    for (inputs, held, on) in
        [(0, 0, false), (1, 0, true), (0, 1, true), (2, 1, false), (3, 0, false), (3, 1, false)]
    {
        let start = [("IR0", inputs), ("IR3", held)];
        assert_eq!(fired(&program, "MOV(21) #1 DM 0", &start, 0), Some(on), "{start:?}");
    }
}

#[test]
fn an_interlock_turns_coils_off_and_holds_the_rest() {
    let text = "LD 0.00\nIL(002)\nLDNOT 0.01\nOUTNOT 1.00\nLD 0.01\nOUT 1.01\nLD 0.01\nSET 1.02\nLD 0.01\nDIFU(013) 1.03\nILC(003)\nLD 1.00\nMOV(021) #0 D0\nLD 1.01\nMOV(021) #1 D1\nLD 1.02\nMOV(021) #2 D2\nLD 1.03\nMOV(021) #3 D3\nEND(001)";
    let program = cx(text);
    let state = |on: &[(&str, u16)]| -> Vec<bool> {
        let all = fires(&program, on, 1);
        all.iter().filter(|(text, _)| text.starts_with("MOV")).map(|(_, fired)| *fired).collect()
    };
    // Held off: OUT NOT is off too, SET and DIFU keep what is there.
    assert_eq!(state(&[("CIO0", 2)]), [false, false, false, false]);
    assert_eq!(state(&[("CIO0", 2), ("CIO1", 15)]), [false, false, true, true]);
    // Through: all follow their conditions.
    assert_eq!(state(&[("CIO0", 3)]), [true, true, true, true]);
    assert_eq!(state(&[("CIO0", 1)]), [false, false, false, false]);
    assert_eq!(state(&[("CIO0", 1), ("CIO1", 15)]), [false, false, true, false]);
}

#[test]
fn a_jump_skips_when_its_condition_is_off() {
    let program = cx(
        "LD 0.00\nJMP(004) #1\nLD 0.01\nOUT 1.00\nJME(005) #1\nLD 0.02\nCJP(510) #2\nLD 0.01\nOUT 1.01\nJME(005) #2\nEND(001)",
    );
    let reached = |on: u16| -> Vec<String> {
        fires(&program, &[("CIO0", on)], 0)
            .into_iter()
            .map(|(text, _)| text)
            .filter(|text| text.starts_with("OUT"))
            .collect()
    };
    assert_eq!(reached(0), ["OUT 1.01"]);
    assert_eq!(reached(1), ["OUT 1.00", "OUT 1.01"]);
    assert_eq!(reached(4), [""; 0]);
}

#[test]
fn jumps_with_number_0_cost_at_most_what_they_pass_over_on_the_c_series() {
    let program = c(
        "LD 00000\nJMP(04) 00\nLD 00001\nOUT 00100\nLD 00002\nJMP(04) 00\nLD 00003\nOUT 00101\nJME(05) 00\nEND(01)",
    );
    let units: Vec<Units> = program
        .instructions
        .iter()
        .filter(|instruction| matches!(instruction.step, Step::Jump { .. }))
        .filter_map(|instruction| instruction.timing.as_ref())
        .map(|key| {
            assert_eq!(key.names[0], "JMP:0");
            key.units.clone()
        })
        .collect();
    assert_eq!(units, [Units::AtMost(6), Units::AtMost(2)]);
}

#[test]
fn branches_are_kept_in_branch_registers() {
    let program = c(
        "LD 00000\nOUT TR 0\nAND 00001\nOUT 00100\nLD TR 0\nAND 00002\nOUT 00101\nLD TR 0\nAND 00003\nLD TR 0\nAND 00004\nKEEP(11) 00102\nLD 00102\nMOV(21) #1 DM 0\nEND(01)",
    );
    assert_eq!(fired(&program, "OUT 00101", &[("IR0", 0b0101)], 0), Some(true));
    assert_eq!(fired(&program, "OUT 00100", &[("IR0", 0b0101)], 0), Some(false));
    assert_eq!(fired(&program, "MOV(21) #1 DM 0", &[("IR0", 0b1001)], 0), Some(true));
    assert_eq!(fired(&program, "MOV(21) #1 DM 0", &[("IR0", 0b11001)], 0), Some(false));
}

#[test]
fn timers_are_done_at_some_time_and_only_with_their_condition() {
    let program = cx("LD 0.00\nTIM 0001 #0010\nLD T0001\nMOV(021) #1 D0\nEND(001)");
    let moves = |on: &[(&str, u16)], choices| fired(&program, "MOV(021) #1 D0", on, choices);
    assert_eq!(moves(&[("CIO0", 1), ("TIMER-RUNS-1", 1)], 1), Some(true));
    assert_eq!(moves(&[("CIO0", 1), ("TIMER-RUNS-1", 1)], 0), Some(false));
    assert_eq!(moves(&[("T1", 1), ("TIMER-RUNS-1", 1)], 1), Some(false));
    // It did not run before, and one scan takes no more than one of its ten units.
    assert_eq!(moves(&[("CIO0", 1)], 1), Some(false));
}

#[test]
fn fast_timers_run_out_between_instructions() {
    let program = cx(
        "LDNOT T0001\nMOV(021) #1 D0\nLD T0001\nMOV(021) #2 D0\nLD 0.00\nTIMH(015) 0001 #0010\nLD=(300) T0001 #5\nMOV(021) #3 D0\nEND(001)",
    );
    let run = |on: &[(&str, u16)], choices| {
        ["MOV(021) #1 D0", "MOV(021) #2 D0"].map(|text| fired(&program, text, on, choices).unwrap())
    };
    assert_eq!(run(&[("TIMER-RUNS-1", 1)], 1), [false, true]);
    assert_eq!(run(&[("TIMER-RUNS-1", 1)], 0), [true, false]);
    assert_eq!(run(&[], 1), [true, false]);
    assert_eq!(program.approximations.len(), 3);
}

#[test]
fn odd_operands_are_refused_or_understood_without_harm() {
    for operand in [
        "*".repeat(100_000),
        "D0[99999999999]".to_owned(),
        "D0[4294967295]".to_owned(),
        "#".to_owned(),
        "&".to_owned(),
        "é,IR0".to_owned(),
        "E_5".to_owned(),
        "[".to_owned(),
        "]".to_owned(),
        "+".to_owned(),
        "D32768".to_owned(),
    ] {
        let _ = decoded(
            "omron-cx",
            &format!("LD P_On\nMOV(021) {operand} D1\nLD {operand}\nOUT {operand}\nEND(001)"),
        );
        let _ = decoded(
            "omron-c200h",
            &format!("LD 25313\nMOV(21) {operand} DM 1\nLD {operand}\nOUT {operand}\nEND(01)"),
        );
    }
}

#[test]
fn counters_count_with_their_input_hold_and_are_reset() {
    let program = c("LD 00000\nLD 00001\nCNT 002 #0003\nLD CNT 002\nMOV(21) #1 DM 0\nEND(01)");
    let done = |inputs: u16, flag: u16, counts: u16| {
        fired(&program, "MOV(21) #1 DM 0", &[("IR0", inputs), ("TC2", flag)], counts)
    };
    assert_eq!(done(0, 1, 0), Some(true));
    assert_eq!(done(0, 0, 1), Some(false));
    assert_eq!(done(1, 0, 1), Some(true));
    assert_eq!(done(3, 1, 1), Some(false));
}

#[test]
fn comparisons_set_the_flags_exactly() {
    for (value, flags) in
        [(9, [false, false, true]), (10, [false, true, false]), (11, [true, false, false])]
    {
        let program = c(
            "LD 25313\nCMP(20) DM 0 #000A\nLD 25505\nMOV(21) #1 DM 1\nLD 25506\nMOV(21) #2 DM 1\nLD 25507\nMOV(21) #3 DM 1\nEND(01)",
        );
        // MOV may change the equals flag: only what stands before it is exact.
        assert_eq!(fired(&program, "MOV(21) #1 DM 1", &[("DM0", value)], 0), Some(flags[0]));
        let program = cx(
            "LD P_On\nCMP(020) D0 &10\nLD P_GT\nOUT 1.00\nLD P_EQ\nOUT 1.01\nLD P_LT\nOUT 1.02\nEND(001)",
        );
        let outs = ["OUT 1.00", "OUT 1.01", "OUT 1.02"]
            .map(|out| fired(&program, out, &[("D0", value)], 0));
        assert_eq!(outs, flags.map(Some));
        let program =
            cx("LD=(300) D0 &10\nOUT 1.00\nLD P_On\nAND>S(322) D0 &10\nOUT 1.01\nEND(001)");
        assert_eq!(fired(&program, "OUT 1.00", &[("D0", value)], 0), Some(flags[1]));
        assert_eq!(fired(&program, "OUT 1.01", &[("D0", value)], 0), Some(flags[0]));
    }
    let program = cx("LD<S(312) D0 &0\nOUT 1.00\nLD<L(311) D0 &65536\nOUT 1.01\nEND(001)");
    assert_eq!(fired(&program, "OUT 1.00", &[("D0", 0xFFFF)], 0), Some(true));
    assert_eq!(fired(&program, "OUT 1.01", &[("D0", 0xFFFF)], 0), Some(true));
    assert_eq!(fired(&program, "OUT 1.01", &[("D1", 1)], 0), Some(false));
}

#[test]
fn words_that_are_moved_and_added_are_followed() {
    for (text, ask) in [
        ("MOV(021) #1234 D0", "=(300) D0 #1234"),
        ("MVN(022) #00FF D0", "=(300) D0 #FF00"),
        ("MOVL(498) #12345678 D0", "=L(301) D0 #12345678"),
        ("XCHG(073) D5 D0", "=(300) D0 &7"),
        ("BSET(071) #5 D0 D3", "=(300) D3 #5"),
        ("XFER(070) &2 D5 D0", "=(300) D1 &8"),
        ("+(400) D5 &3 D0", "=(300) D0 &10"),
        ("-(410) D5 &8 D0", "=S(302) D0 -1"),
        ("++(590) D5", "=(300) D5 &8"),
        ("--L(593) D5", "=L(301) D5 &524294"),
        ("ANDW(034) D5 #3 D0", "=(300) D0 #3"),
        ("XNRW(037) D5 D6 D0", "=(300) D0 #FFF0"),
        ("COM(029) D5", "=(300) D5 #FFF8"),
        ("WSFT(016) #9 D5 D6", "=(300) D6 &7"),
        ("MOVB(082) D5 #0301 D0", "TST(350) D0 &3"),
        ("SETB(532) D5 &4", "=(300) D5 #17"),
        ("RSTA(531) D5 &1 &17", "=L(301) D5 #00080001"),
        ("OUTB(534) D5 &15", "=(300) D5 #8007"),
    ] {
        let program = cx(&format!("LD P_On\n{text}\nLD{ask}\nMOV(021) #FFFF D100\nEND(001)"));
        let start = [("D5", 7), ("D6", 8)];
        assert_eq!(fired(&program, "MOV(021) #FFFF D100", &start, 0), Some(true), "{text}");
        assert_eq!(program.approximations, [], "{text}");
    }
}

#[test]
fn a_shift_register_shifts_on_the_rising_edge() {
    let program = c(
        "LD 00000\nLD 00001\nLD 00002\nSFT(10) 010 011\nLD 01100\nMOV(21) #1 DM 0\nLD 01000\nMOV(21) #2 DM 0\nEND(01)",
    );
    let bits = |inputs: u16, was: u16| {
        let start = [("IR0", inputs), ("IR10", 0x8001), ("EDGE-0", was)];
        ["MOV(21) #1 DM 0", "MOV(21) #2 DM 0"].map(|text| fired(&program, text, &start, 0).unwrap())
    };
    assert_eq!(bits(0b011, 0), [true, true]);
    assert_eq!(bits(0b010, 0), [true, false]);
    assert_eq!(bits(0b010, 1), [false, true]);
    assert_eq!(bits(0b111, 0), [false, false]);
}

#[test]
fn what_is_not_followed_is_havocked_and_noted() {
    for (text, what) in [
        ("ADD(30) DM 0 #5 DM 10", "DM 10 may have any value"),
        ("MUL(32) DM 0 #5 DM 10", "DM 10 and the word after it may have any value"),
        ("MOV(21) #5 *DM 3", "everything that *DM 3 may point to may have any value"),
        (
            "CMP(20) *DM 3 DM 4",
            "*DM 3 is read through an unknown address: any value is assumed for *DM 3",
        ),
        ("XFER(70) DM 0 DM 1 LR 00", "the whole area of LR 00 may have any value"),
    ] {
        let program = c(&format!("LD 00000\n{text}\nEND(01)"));
        let notes: Vec<String> =
            program.approximations.iter().map(|note| note.what.to_string()).collect();
        assert_eq!(notes, [what], "{text}");
    }
    let program = cx("LD ,IR0\nOUT ,IR1\nEND(001)");
    assert_eq!(program.approximations.len(), 2);
}

#[test]
fn a_refresh_of_units_may_write_wherever_their_links_lie() {
    let program = cx("LD W0.00\nDLNK(226) #0\nEND(001)");
    let writes = program.instructions.iter().flat_map(|instruction| &instruction.effects);
    assert!(
        writes
            .into_iter()
            .any(|effect| matches!(effect.write, Write::Havoc(Region::Everything, _)))
    );
}

#[test]
fn subroutines_run_when_called() {
    let program = c(
        "LD 00000\nSBS(91) 05\nLD 00002\nOUT 00200\nSBN(92) 05\nLD 00001\nOUT 00100\nRET(93)\nEND(01)",
    );
    let reached = |on| -> Vec<String> {
        fires(&program, &[("IR0", on)], 0)
            .into_iter()
            .map(|(text, _)| text)
            .filter(|text| text.starts_with("OUT") || text.starts_with("END"))
            .collect()
    };
    assert_eq!(reached(0), ["OUT 00200", "END(01)"]);
    assert_eq!(reached(1), ["OUT 00100", "OUT 00200", "END(01)"]);
    let behind = c("LD 00000\nSBS(91) 05\nEND(01)\nSBN(92) 05\nLD 00001\nOUT 00100\nRET(93)");
    assert_eq!(behind.mains, vec![0..3]);
}

#[test]
fn uncalled_subroutines_are_interrupt_routines_where_interrupts_are_let_in() {
    let text = "LD 00000\nSBS(91) 05\nINT\nEND(01)\nSBN(92) 05\nLD 00001\nOUT 00100\nRET(93)\nSBN(92) 99\nLD 00001\nOUT 00101\nRET(93)";
    let none = c(&text.replace("INT", "OUT 00102"));
    assert_eq!(none.interrupts, []);
    let program = c(&text.replace("INT", "INT(89) 002 004 DM 0"));
    let names: Vec<(&str, u32, bool)> =
        program.interrupts.iter().map(|one| (one.name.as_str(), one.times, one.stated)).collect();
    assert_eq!(names, [("SBN 05", 1, false), ("SBN 99", 1, false)]);
}

#[test]
fn loops_run_as_often_as_they_say_or_until_they_break() {
    let program = cx(
        "FOR(512) &3\nLD P_On\n++(590) D0\nLD=(300) D0 &2\nBREAK(514)\nLD P_On\nMOV(021) #1 D1\nNEXT(513)\nEND(001)",
    );
    let count = |start| {
        fires(&program, &[("D0", start)], 0)
            .iter()
            .filter(|(text, _)| text.starts_with("MOV"))
            .count()
    };
    assert_eq!(count(0), 1);
    assert_eq!(count(5), 3);
}

#[test]
fn all_faults_are_told_at_once() {
    let text = "LD 0.00\nMOV(022) #1 D0\nLD 0.16\nOUT 1.00\nLD NoSuch\nOUT 1.01\nLD 0.00\nFOO D1\nLD 0.00\nMOV(021) #1\nLD 0.00\nMOV(021) #12345 D0\nLD 0.00\nMOV(021) D0 #1\nEND(001)";
    assert_eq!(
        faults("omron-cx", text),
        [
            ("function-number", 2),
            ("operand", 3),
            ("operand", 5),
            ("unknown-instruction", 8),
            ("operands", 10),
            ("operand", 12),
            ("operand", 14)
        ]
    );
    let structure = "LD 00000\nLD 00001\nOUT 00100\nKEEP(11) 00101\nLD 00000\nJMP(04) 5\nLD TR 1\nOUT 00100\nRET(93)\nLD 00000\nSBS(91) 9\nLD 00000\nSTEP(08) 00500";
    let found: Vec<&str> =
        faults("omron-c200h", structure).into_iter().map(|(code, _)| code).collect();
    for code in ["branches", "jump", "no-routine", "no-subroutine", "not-modelled"] {
        assert!(found.contains(&code), "{code} in {found:?}");
    }
    assert_eq!(
        faults(
            "omron-cx",
            "LD 0.00\nSBS(091) 1\nEND(001)\nSBN(092) 1\nLD 0.00\nSBS(091) 1\nRET(093)"
        ),
        [("recursion", 6)]
    );
    assert_eq!(
        faults("omron-c200h", "LD 00000\nIL(02)\nLD 00000\nJMP(04) 1\nILC(03)\nJME(05) 1\nEND(01)"),
        [("jump", 4)]
    );
}

#[test]
fn names_and_numbers_must_agree_where_they_are_fixed() {
    assert!(decoded("omron-c200h", "LD 00000\nFUN(21) #1 DM 0\nEND(01)").is_ok());
    assert!(decoded("omron-c200h", "LD 00000\nCMPL(17) DM 0 DM 2\nEND(01)").is_ok());
    assert_eq!(
        faults("omron-c200h", "LD 00000\nCMPL(21) DM 0 DM 2\nEND(01)"),
        [("function-number", 2)]
    );
    assert_eq!(
        faults("omron-c200h", "LD 00000\nFUN(95) #1 DM 0\nEND(01)"),
        [("unknown-instruction", 2)]
    );
    assert_eq!(
        faults("omron-cx", "LD 0.00\nADD(30) D0 D1 D2\nEND(001)"),
        [("unknown-instruction", 2)]
    );
}

#[test]
fn a_users_instruction_may_write_its_operands() {
    let program = cx("LD 0.00\nSwOp0 D10\nEND(001)");
    assert_eq!(program.instructions[1].timing.as_ref().unwrap().names, ["SwOp0"]);
    assert_eq!(program.approximations[0].what.to_string(), "D10 may have any value");
}

#[test]
fn a_project_file_gives_programs_symbols_and_the_cpu() {
    let text = "CXProgVer:=\"2.3\";\r\nName:=\"T\";\r\nResource[0]:=\r\nBEGIN\r\n PLC:=\r\n BEGIN\r\n  Config:=\"[DEV]DEV:CJ2M;CPU:CPU33;\";\r\n END;\r\n GlobalVariables:=\r\n BEGIN\r\n  VariableList:=\r\n  BEGIN_LIST_$#[4]\r\n   Go,W10.00,BOOL,,,,\"start, go\";\r\n   Table,D100,WORD[8],,,,\"\";\r\n  END_LIST_$#[4];\r\n END;\r\n Programs:=\r\n BEGIN\r\n  Program[0]:=\r\n  BEGIN\r\n   Name:=\"P1\";\r\n   TaskID:=256;\r\n   LocalVariables:=\r\n   BEGIN\r\n    VariableList:=\r\n    BEGIN_LIST_$#[8]\r\n     Mine,0.05,BOOL,,,,\"\";\r\n    END_LIST_$#[8];\r\n   END;\r\n   Sections:=\r\n   BEGIN\r\n    SC:=1;\r\n    Sec[0]:=\r\n    BEGIN\r\n     ProgramData:=\r\n     BEGIN\r\n      RC:=2;\r\n      R[0]:=\r\n      BEGIN\r\n       Com:=\r\n$?St$Bk?_#[10]\r\nfirst\r\nLD X$?St$Bk?_#[10]\r\n       SL:=\r\n$?St$Bk?_#[11]\r\n'  R0\r\nLD Go\r\nAND Mine\r\nMOV(021) Table[3] D0\r\n$?St$Bk?_#[11]\r\n      END;\r\n      R[1]:=\r\n      BEGIN\r\n       SL:=\r\n$?St$Bk?_#[12]\r\nEND(001)\r\n$?St$Bk?_#[12]\r\n      END;\r\n     END;\r\n    END;\r\n   END;\r\n  END;\r\n END;\r\nEND;\r\n";
    let file = input("plant.cxt", text);
    match Fronts(&[&super::FRONT]).detect(&file) {
        Ok(scanbound_front::FileKind::Program(found)) => assert_eq!(found.name, "omron-cxt"),
        other => panic!("{other:?}"),
    }
    let raw = project::read(dialect("omron-cxt"), &[&file], &[]).unwrap();
    assert_eq!(raw.files[0].cpu.as_deref(), Some("CJ2M CPU33"));
    let facts = Facts::default();
    let options = Options::new(&facts);
    let program = decode(&raw, &options).unwrap();
    let named = program.comments.iter().find(|(device, _)| {
        (program.cell_name(device.cell).as_str(), device.bit) == ("W10", Some(0))
    });
    let go = named.map(|(_, comment)| comment);
    assert_eq!(go.map(String::as_str), Some("Go: start, go"));
    assert_eq!(fired(&program, "MOV(021) Table[3] D0", &[("W10", 1), ("CIO0", 32)], 0), Some(true));
    let line = program
        .instructions
        .iter()
        .find(|instruction| &*instruction.text == "AND Mine")
        .unwrap()
        .place
        .line;
    assert_eq!(text.lines().nth(line as usize - 1), Some("AND Mine"));
}

#[test]
fn cut_project_files_are_refused() {
    let text = "CXProgVer:=\"2.3\";\nA:=1;\nB:=2;\nPrograms:=\nBEGIN\n Program[0]:=\n BEGIN\n  Sections:=\n  BEGIN\n   Sec[0]:=\n   BEGIN\n    ProgramData:=\n    BEGIN\n     R[0]:=\n     BEGIN\n      SL:=\n$?St$Bk?_#[1]\nLD 0.00\n";
    let faults = project::read(dialect("omron-cxt"), &[&input("cut.cxt", text)], &[]).unwrap_err();
    assert_eq!(faults[0].code.name(), "broken-project");
}

#[test]
fn interrupt_tasks_make_what_they_share_free() {
    let mut raw = raw("omron-cx", "LD W0.00\nOUT 100.00\nLD W1.00\nOUT 100.01\nEND(001)");
    let other = self::raw("omron-cx", "LD 0.00\nOUT W0.00\nEND(001)");
    raw.files[0].programs.extend(other.files[0].programs.clone());
    raw.files[0].programs[1].task = super::source::Task::Interrupt(5);
    let mut facts = Facts::default();
    facts.state_interrupt("Task 5", InterruptRate::Times(2));
    let options = Options::new(&facts);
    let program = decode(&raw, &options).and_then(passed).unwrap();
    assert_eq!((program.interrupts[0].times, program.interrupts[0].stated), (2, true));
    assert_eq!(fired(&program, "OUT 100.00", &[("W0", 1)], 0), Some(false));
    assert_eq!(fired(&program, "OUT 100.00", &[], 1), Some(true));
    assert_eq!(fired(&program, "OUT 100.01", &[("W1", 1)], 0), Some(true));
}

#[test]
fn what_is_taken_as_any_value_costs_its_area_all_the_same() {
    let row = "instruction,on_us,off_us\n@+DM,0.000001\n@+D,0.000001\n@contact,0\n@coil,0\n@move,0\n@block,0\n@special,0\n@nothing,0\n@interrupt,0\n@call,0\n@arithmetic,0\n@conversion,0\n";
    let table =
        scanbound_timing::table::Table::parse("t.csv", row.as_bytes()).expect("a table").table;
    let priced = |program: &Program| -> u64 {
        let prices =
            scanbound_timing::price::price(program, &table, &Facts::default()).expect("prices");
        prices.times().iter().map(|times| times.on.0).sum()
    };
    let interrupts = "SBN(92) 000\nLD 00001\n@INC(38) DM0010\nRET(93)\n";
    for (text, want) in [
        ("LD 00000\nMOV(21) DM0000 HR00\n", 1),
        ("LD 00000\n@BCD(24) DM0000 DM0001\n", 2),
        ("LD 00000\nXFER(70) #0005 DM0000 DM0100\n", 10),
    ] {
        let alone = priced(&c(&format!("{text}END(01)\n")));
        let between = format!("LD 25313\nINT(89) 000 000 HR10\n{text}{interrupts}END(01)\n");
        let structure = format!("LD 25313\nINT(89) 000 000 HR10\n{interrupts}END(01)\n");
        assert_eq!(alone, want, "{text}");
        assert_eq!(priced(&c(&between)) - priced(&c(&structure)), want, "{text}");
    }
    // What is changed, and an address that is not known.
    assert_eq!(priced(&c("LD 00000\nMOV(21) *DM0000 HR00\nEND(01)\n")), 1);
    assert_eq!(priced(&cx("LD W0.00\n++ D0\nMOV @D0 W1\nEND\n")), 3);
}

#[test]
fn cpus_whose_special_bits_stand_elsewhere_are_refused() {
    let project = |cpu: &str| {
        let text = format!(
            "CXProgVer:=9;\nPLC:=\nBEGIN\nConfig:=\"DEV:{cpu}]\";\nPrograms:=\nBEGIN\nProgram[0]:=\nBEGIN\nName:=\"Main\";\nTaskID:=256;\nSections:=\nBEGIN\nSC:=1;\nSec[0]:=\nBEGIN\nProgramData:=\nBEGIN\nRC:=3;\nR[0]:=\nBEGIN\nSL:=LD 0.00;\nEND\nR[1]:=\nBEGIN\nSL:=OUT 1.00;\nEND\nR[2]:=\nBEGIN\nSL:=END(001);\nEND\nEND\nEND\nEND\nEND\nEND\nEND\n"
        );
        project::read(dialect("omron-cxt"), &[&input("a.cxt", &text)], &[])
    };
    for cpu in ["C20K", "C28P", "C500", "C120", "CVM1", "CV500"] {
        assert_eq!(project(cpu).expect_err(cpu)[0].code.name(), "other-cpu", "{cpu}");
    }
    let told = |cpu: &str| -> Vec<&str> {
        project(cpu).expect(cpu).warnings.iter().map(|one| one.code.name()).collect()
    };
    assert_eq!(told("CJ2M CPU33"), [""; 0]);
    assert_eq!(told("CJ1G-H CPU44"), ["parallel"]);
}
