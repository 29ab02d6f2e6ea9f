//! MELSEC programs whose longest scan is easily overlooked: each names operations that can all run in one scan.

use common::bound::bound;
use common::melsec::{decoded, longest, together};
use scanbound::base::facts::Facts;
use scanbound::base::time::{Picos, Times};
use scanbound::front::melsec::memory::Family;
use scanbound::passes::{Settings, values};
use scanbound::solve::Method;
use scanbound::timing::price::price;
use scanbound::timing::table::Table;
use std::collections::BTreeSet;

#[test]
fn zrst_of_many_devices_clears_those_between() {
    let text = "LD M500; Op1; LD X0; ZRST M0 M1000; LDI M500; Op2; END";
    assert_eq!(together(Family::Q, text), 3);
    assert_eq!(together(Family::Fx, text), 3);
    let timers = "LD T5; Op1; LD X0; ZRST T0 T255; LDI T5; Op2; END";
    assert_eq!(together(Family::Fx, timers), 3);
    let indexed = "LD M500; Op1; LD X0; ZRST M0 M10Z0; LDI M500; Op2; END";
    assert_eq!(together(Family::Q, indexed), 3);
    // And what lies outside stays.
    let outside = "LD M1001; Op1; LD X0; ZRST M0 M1000; LDI M1001; Op2; END";
    assert_eq!(together(Family::Q, outside), 2);
}

#[test]
fn negative_and_unknown_counts_reach_far() {
    for count in ["K-1", "D50"] {
        let text =
            format!("LD= D9000 K1; Op1; LD X0; BMOV D0 D100 {count}; LD= D9000 K2; Op2; END");
        assert_eq!(together(Family::Q, &text), 3, "{count}");
    }
    let text = "LD= D3000 K1; Op1; LD X0; RS D0 D10 D2000 D50; LD= D3000 K2; Op2; END";
    assert_eq!(together(Family::Fx, text), 3);
}

#[test]
fn bkrst_of_words_is_not_taken_as_clearing_them_whole() {
    let text = "LD SM400; BKRST D0 K10; LD= D5 K3; Op1; END";
    assert_eq!(together(Family::Q, text), 1);
    assert_eq!(together(Family::Q, "LD SM400; BKRST M0 K10; LD M5; Op1; END"), 0);
}

#[test]
fn fx_index_registers_pair_z_with_v() {
    let text = "LD= V0 K0; Op1; LD X0; DMOV K65536 Z0; LD= V0 K1; Op2; END";
    assert_eq!(together(Family::Fx, text), 3);
    let next = "LD= Z1 K0; Op1; LD X0; DMOV K65536 Z0; LD= Z1 K1; Op2; END";
    assert_eq!(together(Family::Fx, next), 2);
    assert_eq!(together(Family::Q, next), 3);
    let special = "LD= Z0 K0; Op1; LD X0; MOV K1 D8028; LD= Z0 K1; Op2; END";
    assert_eq!(together(Family::Fx, special), 3);
}

#[test]
fn fx_special_relays_turn_moves_round() {
    let text = "LD X1; OUT M8024; LD= D0 K1; Op1; LD X0; BMOV D0 D100 K2; LD= D0 K2; Op2; END";
    assert_eq!(together(Family::Fx, text), 3);
    let plain = "LD X1; OUT M24; LD= D0 K1; Op1; LD X0; BMOV D0 D100 K2; LD= D0 K2; Op2; END";
    assert_eq!(together(Family::Fx, plain), 2);
}

#[test]
fn fx_long_counters_are_read_as_any_number() {
    let text = "LD X0; OUT C235 K100000; OUT C200 K100000; OUT C201 D0; LDD= C235 K70000; Op1; LDD= C200 K70000; Op2; LD M8000; DMOV C251 D0; END";
    assert_eq!(together(Family::Fx, text), 3);
}

#[test]
fn a_direct_input_refreshes_the_latched_one() {
    let text = "LD X0; Op1; LD DX0; OUT M1; LDI X0; Op2; END";
    assert_eq!(together(Family::Q, text), 3);
    assert_eq!(together(Family::Q, "LD X0; Op1; LD X1; OUT M1; LDI X0; Op2; END"), 2);
}

#[test]
fn long_counters_hold_their_contact() {
    let text = "LD X0; OUT LC0 K10; LD LC0; ANI X0; Op1; END";
    assert_eq!(together(Family::Iqr, text), 1);
    let plain = "LD X0; OUT C0 K10; LD C0; ANI X0; Op1; END";
    assert_eq!(together(Family::Q, plain), 1);
    assert_eq!(together(Family::Q, &plain.replace('C', "T")), 0);
}

#[test]
fn a_step_ladder_leaves_its_state_at_any_moment() {
    let left = "STL S20; LD X0; SET S21; LD S20; Op1; RET; LDI S20; Op2; END";
    assert_eq!(together(Family::Fx, left), 3);
    let parallel = "STL S25; LDI X0; Op1; LD X0; OUT S0; RET; LD S0; Op2; END";
    assert_eq!(together(Family::Fx, parallel), 3);
}

#[test]
fn a_rung_goes_on_behind_its_output_with_a_block() {
    let text = "LD X0; OUT Y0; LD X1; OR X2; ANB; Op1; LDI X0; Op2; END";
    assert_eq!(together(Family::Q, text), 2);
    let twice = "LD X0; OUT Y0; LD X1; LD X2; AND= D0 K1; ORB; ANB; Op1; LD X3; Op2; END";
    assert_eq!(together(Family::Q, twice), 3);
    let in_loop = "FOR K1; LD X1; LD X2; ORB; Op1; LDI X1; Op2; NEXT; END";
    assert_eq!(together(Family::Q, in_loop), 3);
    let two_rungs = "LD X0; OUT Y0; LD X1; LD X2; ANB; Op1; LDI X0; Op2; END";
    assert_eq!(together(Family::Q, two_rungs), 3);
}

#[test]
fn a_program_that_is_called_or_stopped_may_rest() {
    let off = ("OFF", "LD SM401; OUT M0; END");
    let work = |by: &str| format!("LD M0; Op1; LD X0; {by}; END");
    let facts = Facts::default();
    let cost = |by: &str| {
        let work = work(by);
        decoded(Family::Q, &[off, ("WORK", &work)], &facts).map(|program| longest(&program))
    };
    assert_eq!(cost("PSTOP \"OFF\""), Ok(1));
    assert_eq!(cost("OUT M5"), Ok(0));
    let called = ("SUB", "P100; LD SM401; OUT M0; RET; END");
    let main = ("MAIN", "LD M0; Op1; LD X0; ECALL \"SUB\" P100; END");
    let program = decoded(Family::Q, &[called, main], &facts).expect("good");
    assert_eq!(longest(&program), 1);
}

#[test]
fn a_range_at_the_start_limits_no_count_that_the_program_writes() {
    let ranges = [("D0".to_owned(), (1, 2))].into();
    let facts = Facts { ranges, ..Facts::default() };
    let iterations = |text: &str| {
        let mut program = decoded(Family::Q, &[("MAIN", text)], &facts).expect("good");
        // The front leaves ranges to the pass on values.
        (values::PASS.run)(&mut program, &Settings::default()).expect("a bound");
        longest(&program)
    };
    assert_eq!(iterations("FOR D0; LD X0; Op1; NEXT; END"), 2);
    assert_eq!(iterations("LD X1; MOV K9 D0; FOR D0; LD X0; Op1; NEXT; END"), 9);
    let wide = [("D0".to_owned(), (0, 40_000))].into();
    let facts = Facts { ranges: wide, ..Facts::default() };
    let told = decoded(Family::Q, &[("MAIN", "LD= D1 K5; Op1; END")], &facts).expect_err("wide");
    assert!(told.contains("above 32767, the largest signed word"), "{told}");
    for device in ["X0", "M5", "QQ7", "K4M0", "D0Z1"] {
        let facts = Facts { ranges: [(device.to_owned(), (0, 1))].into(), ..Facts::default() };
        let told = decoded(Family::Q, &[("MAIN", "LD X0; Op1; END")], &facts).expect_err("no word");
        assert!(told.contains("is not a word"), "{told}");
    }
}

#[test]
fn what_nests_too_deep_is_refused() {
    let mut calls = "LD X0; CALL P0; FEND; ".to_owned();
    for n in 0..4000 {
        calls += &format!("P{n}; LD X0; CALL P{}; RET; ", n + 1);
    }
    calls += "P4000; LD X0; OUT Y0; RET; END";
    let facts = Facts::default();
    let told = decoded(Family::Q, &[("MAIN", &calls)], &facts).expect_err("too deep");
    assert!(told.contains("calls are nested more than"), "{told}");
    let loops = format!("{}LD X0; OUT Y0; {}END", "FOR K1; ".repeat(4000), "NEXT; ".repeat(4000));
    let told = decoded(Family::Q, &[("MAIN", &loops)], &facts).expect_err("too deep");
    assert!(told.contains("loops are nested more than"), "{told}");
}

/// What all instructions cost together by a table of these rows, in picoseconds, each at its larger time; others
/// cost nothing.
fn priced(family: Family, text: &str, rows: &str) -> u64 {
    let program = decoded(family, &[("MAIN", text)], &Facts::default()).expect("good");
    let classes: BTreeSet<&str> = program
        .instructions
        .iter()
        .filter_map(|instruction| Some(instruction.timing.as_ref()?.class))
        .collect();
    let others: String = classes
        .iter()
        .filter(|class| !rows.contains(&format!("@{class},")))
        .map(|class| format!("@{class},0,0\n"))
        .collect();
    let table = format!("instruction,on_us,off_us,per_unit_us\n{others}{rows}");
    let table = Table::parse("t.csv", table.as_bytes()).expect("a table").table;
    let prices = price(&program, &table, &Facts::default()).expect("prices");
    prices.instructions.iter().flatten().map(|price| price.on.max(price.off).0).sum()
}

#[test]
fn every_instruction_pays_for_the_kinds_of_its_operands() {
    let rows = "@+indexed,0.000001,0.000001\n@+digits,0.0001,0.0001\n@+module,0.01,0.01\n";
    for (text, want) in [
        ("LD M0Z1; OUT Y0; END", 1),
        ("LDP D0Z1.3; OUT M0Z0; END", 2),
        ("LD= K4M0 K5; SET M1Z1; END", 101),
        ("LD>= U0\\G100 K5; OUT U0\\G200.1; END", 20_000),
        ("LD X0; OUT T0 D0Z0; PLS M0Z2; RST D5Z1; FF D3Z1.2; END", 4),
        ("LD X0; MC N0 M0Z1; MCR N0; LDE= D0Z1 E1.5; OUT Y0; END", 2),
        ("LD X0; MOVP D0Z1 U0\\G5; BMOV K4X0 D0 K2; END", 10_101),
    ] {
        assert_eq!(priced(Family::Q, text, rows), want, "{text}");
    }
    let own = "LD:module,0.000003,0.000003\nLD,0.1,0.1\n";
    assert_eq!(priced(Family::Q, "LD U0\\G0.1; OUT Y0; END", own), 3);
}

#[test]
fn what_is_taken_as_any_value_costs_its_area_all_the_same() {
    let rows = "@+ZR,0.000001\n@+wordbit,0.0001,0.0001\n";
    for (text, want) in [
        ("LD X0; BCD ZR0 D0; END", 1),
        ("LD X0; TO H0 K0 ZR0 K3; END", 3),
        ("LD X0; BMOV ZR0 D0 K600; END", 600),
        ("LD X0; DMOV R0Z1 D0; END", 2),
        ("LDD= ZR0 K1; OUT Y0; END", 2),
        ("LD X0; MOV R0 D0; FEND; I0; LD X1; INC ZR0; IRET; END", 3),
        ("LD D0.3; OUT Y0; FEND; I0; LD X1; MOV K1 D0; IRET; END", 100),
        ("LD SD0.3; OUT Y0; LD D0Z1.3; OUT D0Z2.4; END", 300),
    ] {
        assert_eq!(priced(Family::Q, text, rows), want, "{text}");
    }
    // Points that only such an instruction names are refreshed too.
    let program = decoded(Family::Q, &[("MAIN", "LD X0; BCD K4X100 D0; END")], &Facts::default());
    let table = Table::parse("t.csv", b"instruction,on_us,off_us\nLD,0\nBCD,0\nEND,0\n@input16,1");
    let table = table.expect("a table").table;
    let prices = price(&program.expect("good"), &table, &Facts::default()).expect("prices");
    assert_eq!(prices.overhead_sum(), Picos(17_000_000));
}

#[test]
fn a_pulse_form_costs_what_its_plain_form_costs() {
    assert_eq!(priced(Family::Iqr, "LD X0; +P_U D0 D1; END", "+_U,3,0\n"), 3_000_000);
    let open = "LD X0; ZP.OPEN \"U0\" K1 D0 M0; END";
    assert_eq!(priced(Family::Q, open, "Z.OPEN,3,0\n"), 3_000_000);
}

#[test]
fn registers_of_several_words_do_not_overlap() {
    // LZ holds two words, a function register four.
    for (family, text) in [
        (Family::Iqr, "LD SM400; DMOV K0 LZ0; LDD= LZ1 K5; Op1; END"),
        (Family::Iqr, "LDD= LZ0 K0; Op1; LD X0; RST LZ0; LDD= LZ0 K65536; Op2; END"),
        (Family::Q, "LD SM400; DMOV K0 FD0; LD= FD1 K5; Op1; END"),
        (Family::Q, "LD SM400; MOV K0 FD0; LD FD1.3; Op1; END"),
    ] {
        assert!(together(family, text) >= 1, "{text}");
    }
    assert_eq!(together(Family::Q, "LD SM400; DMOV K65541 FD1; LDD= FD1 K65541; Op1; END"), 1);
    assert_eq!(together(Family::Q, "LD SM400; MOV K5 FD1; LD= FD1 K4; Op1; END"), 0);
}

#[test]
fn fx_numbers_that_end_in_special_devices_change_by_themselves() {
    for read in ["K4T190", "K4M7990", "K4C230"] {
        let text = format!("LD M8000; MOV {read} D0; MOV {read} D1; LD<> D0 D1; Op1; END");
        assert_eq!(together(Family::Fx, &text), 1, "{read}");
    }
    let block = "LD M8000; BMOV T190 D0 K5; BMOV T190 D10 K5; LD<> D2 D12; Op1; END";
    assert_eq!(together(Family::Fx, block), 1);
    let plain = block.replace("K5", "K2").replace("D2 D12", "D1 D11");
    assert_eq!(together(Family::Fx, &plain), 0);
    assert_eq!(together(Family::Fx, &block.replace("T190", "D7998")), 1);
}

#[test]
fn counts_in_words_are_as_large_as_the_cpu_takes_them() {
    let cost = |family, text: &str, row: &str| priced(family, text, &format!("{row},0,0,0.000001"));
    assert_eq!(cost(Family::Fx, "LD X0; FROM K0 K0 R0 D0; END", "FROM"), 65_535);
    assert_eq!(cost(Family::Fx, "LD X0; BMOV D0 D100 D50; END", "BMOV"), 512);
    assert_eq!(cost(Family::Q, "LD X0; BMOV D0 D100 D50; END", "BMOV"), 65_535);
    assert_eq!(cost(Family::Iqr, "LD X0; BMOVL ZR0 D100 K70000; END", "BMOVL"), 70_000);
    // A range of the lower word says nothing of a count of two.
    let facts = Facts { ranges: [("D50".to_owned(), (0, 10))].into(), ..Facts::default() };
    let text = "LD= D5000 K1; Op1; LD X0; BMOVL ZR0 D100 D50; LD= D5000 K2; Op2; END";
    let program = decoded(Family::Iqr, &[("MAIN", text)], &facts).expect("good");
    assert_eq!(longest(&program), 3);
    assert!(cost(Family::Iqr, "LD X0; BMOVL ZR0 D100 D50; END", "BMOVL") > 10_000_000);
}

#[test]
fn a_routine_run_with_its_coils_off_passes_its_jumps_and_costs_its_off_times() {
    for call in ["FCALL", "XCALL"] {
        let out = format!("LD X0; {call} P0; FEND; P0; LD SM400; OUT Y0; RET; END");
        assert_eq!(possible(&out, &|text| text.starts_with("OUT")), 1, "{call}");
        let jump = format!(
            "LD X0; {call} P0; FEND; P0; LD SM400; CJ P1; LD SM401; OUT M1; P1; LD SM400; CALL P2; RET; \
             P2; LD SM400; OUT Y0; RET; END"
        );
        assert_eq!(possible(&jump, &|text| text == "OUT M1"), 1, "{call}");
        assert_eq!(possible(&jump, &|text| text == "OUT Y0"), 1, "{call}");
    }
    let plain = "LD X0; CALL P0; FEND; P0; LD SM400; OUT Y0; RET; END";
    assert_eq!(possible(plain, &|text| text.starts_with("OUT")), 0);
}

/// The bound where the instructions asked for cost 1 when they are reached with their condition false.
fn possible(text: &str, asked: &dyn Fn(&str) -> bool) -> u64 {
    let program = decoded(Family::Q, &[("MAIN", text)], &Facts::default()).expect("good");
    let off = |text: &str| Picos(u64::from(asked(text)));
    let times = program
        .instructions
        .iter()
        .map(|i| Times::new(Picos::ZERO, off(&i.text)))
        .collect::<Vec<Times>>();
    bound(&program, &times, Method::Cores).expect("the program can be followed").upper.0
}

#[test]
fn a_master_control_may_hold_off_what_an_edge_relay_remembers() {
    let text = "LD X0; MC N0 M0; LD SM400; EGP V0; OUT Y1; MCR N0; LDI V0; Op1; END";
    assert_eq!(together(Family::Q, text), 1);
    let plain = "LD SM400; EGP V0; OUT Y1; LDI V0; Op1; END";
    assert_eq!(together(Family::Q, plain), 0);
    let again = "LDI X0; RST M0; FOR K2; LD M0; MC N0 M1; LD SM400; MEP; Op1; MCR N0; LD SM400; SET M0; NEXT; END";
    assert_eq!(together(Family::Q, again), 1);
}

#[test]
fn spelling_does_not_hide_a_switch_of_the_file_register() {
    for switch in ["RSET K1", "rset K1", "rsetp K1", "Qdrset \"A\""] {
        let text = format!("LD SM400; {switch}; MOV K6 R0; LD= ZR0 K5; Op1; END");
        assert_eq!(together(Family::Q, &text), 1, "{switch}");
    }
}

#[test]
fn an_indexed_special_register_may_be_an_index_register() {
    let text = "LD M8000; MOV K5 Z0; MOV K3 D8020V1; LD= Z0 K3; Op1; END";
    assert_eq!(together(Family::Fx, text), 1);
}

#[test]
fn a_program_may_begin_with_states() {
    let text = "STL S20; LD X0; SET S21; STL S21; LD X1; Op1; RET; LD S20; Op2; END";
    assert_eq!(together(Family::Fx, text), 3);
}

#[test]
fn the_end_is_reached_from_within_a_master_control() {
    let text = "LD X0; MC N0 M0; LD X1; GOEND; Op1; MCR N0; LDI M0; Op2; LDI X1; Op4; END";
    assert_eq!(together(Family::Q, text), 6);
}

#[test]
fn what_a_module_is_asked_for_comes_later() {
    let at_once = "LD X0; SP.DATERD D100; LD SM400; MOV K1 D100; LD= D100 K5; Op1; END";
    assert_eq!(together(Family::Q, at_once), 0);
    for asked in
        ["ZP.BUFRCV \"U0\" K1 D10 D100 M0", "GP.READ U0 D10 D100 M0", "GP.INPUT U0 D10 D100 M0"]
    {
        let text = format!("LD X0; {asked}; LD SM400; MOV K1 D100; LD= D100 K5; Op1; END");
        assert_eq!(together(Family::Q, &text), 1, "{asked}");
    }
}
