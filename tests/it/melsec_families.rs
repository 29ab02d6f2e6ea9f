//! What MELSEC's families do differently, above all the FX and FX5: each test names operations that one of them can
//! run in one scan, though the others cannot.

use common::melsec::{decoded, together};
use scanbound::base::facts::Facts;
use scanbound::front::melsec::memory::Family;
use scanbound::program::Units;

#[test]
fn a_sum_of_the_fx_that_overflows_is_any_value() {
    // It keeps the sign of the limit that is passed: 32767 and 1 give no negative number.
    let text = "LD M8000; ADD D0 K1 D1; LD= D0 K32767; AND>= D1 K0; Op1; END";
    for family in [Family::Fx, Family::Fx5] {
        let text = if family == Family::Fx5 { &text.replace("M8000", "SM400") } else { text };
        assert_eq!(together(family, text), 1, "{family:?}");
    }
    for (text, want) in [
        ("LD M8000; ADD K32767 K1 D0; LD= D0 K0; Op1; END", 1),
        ("LD M8000; SUB K-32768 K1 D0; LD<= D0 K0; Op1; END", 1),
        ("LD M8000; SUBP D0 K1 D0; LD= D0 K-1; Op1; END", 1),
        ("LD M8000; DADD D0 D2 D0; LDD= D0 K0; ANDD= D2 K1; Op1; END", 1),
        ("LD M8000; DSUB D0 D2 D4; LDD= D4 K0; ANDD> D0 D2; Op1; END", 1),
        ("LD M8000; ADD K32767 K1 K2M0; LDI M0; AND M1; Op1; END", 1),
        // What does not overflow is a sum as ever, and what is not executed stays.
        ("LD M8000; ADD K5 K1 D0; LD<> D0 K6; Op1; END", 0),
        ("LD= D0 K7; ADD D0 K1 D1; LD= D0 K7; AND<> D1 K8; Op1; END", 0),
        ("LD M8000; MOV K3 D1; LD X0; ADD D0 K1 D1; LDI X0; AND<> D1 K3; Op1; END", 0),
        ("LD M8000; SUB K5 K6 D0; LD<> D0 K-1; Op1; END", 0),
        // INC passes the limits as a ring does.
        ("LD M8000; MOV K32767 D0; INC D0; LD<> D0 K-32768; Op1; END", 0),
    ] {
        assert_eq!(together(Family::Fx, text), want, "{text}");
    }
    let ring = "LD SM400; MOV K32767 D0; + K1 D0; LD<> D0 K-32768; Op1; END";
    assert_eq!(together(Family::Q, ring), 0);
    let unsigned = "LD SM400; ADD_U H0FFFF K1 D0; LD= D0 K5; Op1; END";
    assert_eq!(together(Family::Fx5, unsigned), 1);
    assert_eq!(together(Family::Fx5, &unsigned.replace("H0FFFF", "K32767")), 0);
}

#[test]
fn a_special_relay_makes_double_sums_of_the_fx_real_ones() {
    let text = "LD X1; OUT M8023; LD M8000; DMOV K0 D2; DADD D0 D2 D4; LDD<> D0 D4; Op1; END";
    assert_eq!(together(Family::Fx, text), 1);
    assert_eq!(together(Family::Fx, &text.replace("M8023", "M23")), 0);
    // Also where only digits or an index reach it.
    assert_eq!(together(Family::Fx, &text.replace("OUT M8023", "MOV D9 K4M8016")), 1);
    assert_eq!(together(Family::Fx, &text.replace("OUT M8023", "OUT M8000Z0")), 1);
    assert_eq!(together(Family::Fx, &text.replace("OUT M8023", "ZRST M8020 M8030")), 1);
}

#[test]
fn an_edge_of_the_fx_belongs_to_its_device_and_the_scan() {
    let three = "FOR K3; LDP X0; Op1; NEXT; END";
    for (family, text, want) in [
        (Family::Fx, three, 3),
        (Family::Fx5, three, 3),
        (Family::Q, three, 1),
        (Family::Fx, "LDP X0; Op1; LDP X0; Op2; END", 3),
        (Family::Fx, "FOR K3; LD X1; ANDF X0; Op1; NEXT; END", 3),
        (Family::Fx, "FOR K3; LD X1; ORP X0; INV; ORPI X0; MPS; Op1; MPP; Op2; NEXT; END", 9),
        (Family::Fx, "LD X1; CALL P1; LD X2; CALL P1; FEND; P1; LDP X0; Op1; SRET; END", 2),
        (Family::Q, "LD X1; CALL P1; LD X2; CALL P1; FEND; P1; LDP X0; Op1; RET; END", 1),
        (Family::Fx, "LD X1; CALL P1; FEND; P1; LDP X0; PLS M0; LD M0; Op1; SRET; END", 1),
        // A routine called once, from one that is called twice.
        (
            Family::Fx,
            "LD X1; CALL P1; CALL P1; FEND; P1; LD X2; CALL P2; SRET; P2; LDP X0; Op1; SRET; END",
            2,
        ),
        // One that is called in a loop.
        (Family::Fx, "FOR K3; LD X1; CALL P1; NEXT; FEND; P1; LDF X0; Op1; SRET; END", 3),
        // Pulses alike: no page says otherwise.
        (Family::Fx, "FOR K3; LD X0; PLS M0; LD M0; Op1; NEXT; END", 3),
        (Family::Fx, "LD M8000; MOV K0 D0; FOR K3; LD X0; INCP D0; NEXT; LD= D0 K3; Op1; END", 1),
        // Once a scan it is an edge as ever.
        (Family::Fx, "LDP X0; OUT M0; LDI X0; AND M0; Op1; END", 0),
        (Family::Fx, "FOR K3; LDP X0; OUT M0; LDI X0; AND M0; Op1; NEXT; END", 0),
    ] {
        assert_eq!(together(family, text), want, "{family:?} {text}");
    }
}

#[test]
fn fast_counters_of_the_fx5_count_at_any_moment() {
    for device in ["LC35", "LC55", "LCS40"] {
        let text = format!("LD {device}; Op1; LDI {device}; Op2; END");
        assert_eq!(together(Family::Fx5, &text), 3, "{device}");
    }
    let value = "LDD= LC35 K5; Op1; LDD= LC35 K6; Op2; END";
    assert_eq!(together(Family::Fx5, value), 3);
    let held = "LD X0; OUT LC35 K10; RST LC35; LDI LC35; AND LC35; Op1; DMOV LC35 D0; END";
    assert_eq!(together(Family::Fx5, held), 1);
    assert_eq!(together(Family::Fx5, "LD LC34; Op1; LDI LC34; Op2; END"), 2);
    assert_eq!(together(Family::Iqr, "LD LC35; Op1; LDI LC35; Op2; END"), 2);
}

#[test]
fn a_step_ladder_may_be_kept_from_moving_on() {
    let text = "LD X5; OUT M8040; STL S20; LD X0; Op1; SET S21; RET; LD X0; ANI S21; Op2; END";
    assert_eq!(together(Family::Fx, text), 3);
    assert_eq!(together(Family::Fx5, &text.replace("M8040", "SM8040")), 3);
    assert_eq!(together(Family::Fx, &text.replace("M8040", "M40")), 2);
    let out = text.replace("SET S21", "OUT S21");
    assert_eq!(together(Family::Fx, &out), 3);
    let by_ist = text.replace("OUT M8040", "IST X20 S40 S50").replace("X5", "X7");
    assert_eq!(together(Family::Fx, &by_ist), 3);
}

#[test]
fn what_runs_beside_the_program_reaches_as_far_as_its_operands_may_mean() {
    for (family, text) in [
        (Family::Fx, "LD Y0; Op1; LD X0; IST X20 S20 S29; LDI Y0; Op2; END"),
        (Family::Fx5, "LD M1; Op1; LD X0; DZRN K5000 K500 K1 M0; LDI M1; Op2; END"),
        (Family::Fx5, "LD Y0; Op1; LD X0; HIOEN K10 K1 K0; LDI Y0; Op2; END"),
        (Family::Fx5, "LDI Y0; Op1; LD X0; DHIOEN K10 K1 K0; LD Y0; Op2; END"),
        // An axis, by a number or in a word, puts out to what its parameters name.
        (Family::Fx5, "LDI Y0; Op1; LD X0; DDRVI K5000 K500 K1 M0; LD Y0; Op2; END"),
        (Family::Fx5, "LDI Y0; Op1; LD X0; DDRVI K5000 K500 D10 M0; LD Y0; Op2; END"),
        (Family::Fx5, "LDI M1; Op1; LD X0; DRVA K5000 K500 K1 M0; LD M1; Op2; END"),
        (Family::Fx5, "LDI Y4; Op1; LD X0; PLSY K10 K0 K1; LD Y4; Op2; END"),
        (Family::Fx5, "LDI Y4; Op1; LD X0; PWM D0 D1 D2; LD Y4; Op2; END"),
        (Family::Fx5, "LDI M1; Op1; LD X0; DSZR K100 K10 K1 M0; LD M1; Op2; END"),
        (Family::Fx5, "LDI M1; Op1; LD X0; DDSZR D0 D2 K1 M0; LD M1; Op2; END"),
        (Family::Fx5, "LDI Y4; Op1; LD X0; DPLSV K100 K2 M0; LD Y4; Op2; END"),
        (Family::Fx5, "LDI M7; Op1; LD X0; DRVMUL K1 K1 K1 K0 M0; LD M7; Op2; END"),
        (Family::Fx5, "LDI M1; Op1; LD X0; DRVTBL K1 K1 K5 M0; LD M1; Op2; END"),
        (Family::L, "LDI Y0; Op1; LD X0; ICPWM1 D0 D2; LD Y0; Op2; END"),
    ] {
        assert_eq!(together(family, text), 3, "{text}");
    }
    // An output that is named is the only one.
    let named = "LDI Y4; Op1; LD X0; PLSY K10 K0 Y0; LD Y4; Op2; END";
    assert_eq!(together(Family::Fx, named), 2);
    assert_eq!(together(Family::Fx, &named.replace("Y4", "Y0")), 3);
}

#[test]
fn what_the_families_have_is_known() {
    for (family, text) in [
        (Family::Fx5, "STL S0; LD X0; SET S20; STL S20; LD X1; OUT Y0; RETSTL; END"),
        (Family::Q, "LD X0; EDMOV E1.5 D0; EDMOV E1.5+100 D0; ED+ E1 D0 D4; END"),
        (Family::Iqr, "LD X0; $MOVP_WS \"A\" D0; LENP_WS D0 D10; $+P_WS D0 D20 D40; END"),
        (
            Family::Q,
            "LD X0; GP.READ U0 D0 D10 D20 M0; SP.CCPASET U3E0 D0 D2 M0; G.READ U1Z2 D0 D10 D20 M0; END",
        ),
        (
            Family::Iqr,
            "LD LTS0; AND LTC0; OR LSTS1; OR LSTC1; OR LCS2; OR LCC2; DMOV LTN0 D0; DMOV LSTN1 D2; DMOV LCN2 D4; END",
        ),
        (Family::Iqr, "LD X0; M.SVST H3E1 \"J1\" K0 M0 D0; MP.DDRD H3E1 D0 D10 D20 M0; END"),
        (
            Family::Q,
            "LD X0; ECON D0 D4; EDCONP D4 D0; LOGTRG K1; LOGTRGR K1; EROMWR D0 ZR0 K1 M0; END",
        ),
        (Family::Q, "LDDT= D0 D3 K7; OR<> D9 K1; ANDTM>= D10 D13 H7; ORDT< D0 D3 K1; OUT Y0; END"),
        (Family::Q, "LDPCHK \"SUB\"; OUT Y0; LD X0; CHKST; LD X1; OR X2; CHK; END"),
        (
            Family::Iqr,
            "LD X0; UNIINFRD H0 D0 K1; EDZCP D0 D4 D8 M0; SERDATA D0 D10 D20 K5; DSERDATAP D0 D10 D20 K5; END",
        ),
        (
            Family::Fx5,
            "LD X0; SERMM D0 D10 D20 K5; DSERMM D0 D10 D20 K5; SERDATA D0 D10 D20 K5; SORTTBL D0 K5 K3 D100 K1; DSORTTBL2_U D0 K5 K3 D100 K1; RAMPF D0 D1 D2 K5; UDCNTF LC0 K100; LOGTRG K1; END",
        ),
        (
            Family::Fx,
            "LD X0; FLCRT K0 D0 K1 K1; FLDEL K0 D0 K1; FLWR D0 D10 D20 D30 K1; FLRD D0 D10 D20 D30 K1; FLCMD K1 K1; FLSTRD K1 D0 K1; END",
        ),
    ] {
        together(family, text);
    }
    // Whatever the comparison says.
    assert_eq!(together(Family::Q, "LDDT= D0 D3 K7; Op1; LDDT<> D0 D3 K7; Op2; END"), 3);
    assert_eq!(together(Family::Iqr, "LD LTS0; Op1; LDI LT0; Op2; END"), 3);
    let told = decoded(
        Family::Q,
        &[("MAIN", "LD X0; IX D0; LD M0; OUT Y0; IXEND; END")],
        &Facts::default(),
    )
    .expect_err("not modelled");
    assert!(told.contains("adds index registers to all devices"), "{told}");
}

#[test]
fn units_reach_as_far_as_the_instruction_can() {
    let units = |family, text: &str| {
        let program = decoded(family, &[("MAIN", text)], &Facts::default()).expect("good");
        program.instructions[1].timing.clone().expect("is priced").units
    };
    for (family, text, want) in [
        (Family::Q, "LD X0; Z.MRECV \"U0\" D0 D10 D20 M0; END", Units::AtMost(6517)),
        (Family::Q, "LD X0; SP.FREAD U0 K0 D0 D10 D20 M0; END", Units::AtMost(65_535)),
        (Family::Q, "LD X0; S.DEVLD D0 D10 K30000; END", Units::Exactly(30_000)),
        (Family::Q, "LD X0; SP.DEVST D0 D10 K30000 M0; END", Units::Exactly(30_000)),
        (Family::Q, "LD X0; PIDINIT D0; END", Units::AtMost(32)),
        (Family::Q, "LD X0; PIDCONT D0; END", Units::AtMost(32)),
        (Family::Q, "LD X0; COM; END", Units::AtMost(1_077_504)),
        (Family::Q, "LD X0; S.ZCOM \"J1\"; END", Units::AtMost(1_077_504)),
        (Family::Fx, "LD X0; RWER R0 K3000; END", Units::Exactly(3000)),
        (Family::Fx, "LD X0; INITR R0 K2; END", Units::Exactly(2)),
        (Family::Fx, "LD X0; LOGR D0 K5 R0 K1 D100; END", Units::Exactly(5)),
    ] {
        assert_eq!(units(family, text), want, "{text}");
    }
}

#[test]
fn blocks_that_move_by_one_place_are_followed() {
    for (family, text, want) in [
        (
            Family::Q,
            "LD SM400; MOV K3 D0; MOV K4 D1; DSFL D0 K3; LD<> D1 K3; OR<> D2 K4; OR<> D0 K0; Op1; END",
            0,
        ),
        (
            Family::Q,
            "LD SM400; MOV K3 D1; MOV K4 D2; DSFRP D0 K3; LD SM400; DSFR D0 K3; LD<> D2 K0; Op1; END",
            0,
        ),
        (Family::Q, "LD SM400; SET M0; BSFL M0 K3; LDI M1; OR M0; Op1; END", 0),
        (Family::Q, "LD SM400; SET M2; BSFR M0 K3; LDI M1; OR M2; Op1; END", 0),
        (Family::Q, "LD= D1 K3; DSFL D0 D9; LD= D1 K4; Op1; END", 1),
        (Family::Q, "LD= D0 K3; DSFL D0 K0; LD= D0 K4; Op1; END", 1),
        (Family::Fx, "LD M8000; CMP K5 D0 M0; LDI M1; AND= D0 K5; Op1; END", 0),
        (Family::Fx, "LD M8000; DCMP D0 K-1 M0; LD M2; ANDD>= D0 K-1; Op1; END", 0),
        (Family::Fx5, "LD SM400; CMP_U H0FFFF D0 M0; LDI M0; AND= D0 K5; Op1; END", 0),
        // What is compared lies among the bits.
        (Family::Fx, "LD M8000; SET M1; CMP K1M0 K0 M0; LDI M0; Op1; END", 1),
    ] {
        assert_eq!(together(family, text), want, "{text}");
    }
}

#[test]
fn blocks_are_worked_out_element_by_element() {
    let sum = "LD SM400; MOV K3 D1; MOV K4 D11; BK+ D0 D10 D20 K3; LD<> D21 K7; Op1; END";
    let same = "LD SM400; MOV K3 D1; MOV K1 D0; BK- D0 K1 D0 K3; LD<> D1 K2; OR<> D0 K0; Op1; END";
    for (family, text, want) in [
        (Family::Q, sum, 0),
        (Family::Fx, &*sum.replace("SM400", "M8000"), 1),
        (Family::Q, same, 0),
        // Written where it is read, at other places: the order is not told.
        (Family::Q, "LD SM400; MOV K3 D0; BK+ D0 K1 D1 K3; LD<> D1 K4; Op1; END", 1),
        (Family::Q, "LD SM400; MOV K3 D1; BKCMP= D0 K3 M0 K2; LDI M1; Op1; END", 0),
        (Family::Fx, "LD M8000; DMOV K-3 D2; DBKCMP> K0 D0 M0 K2; LDI M1; Op1; END", 0),
        (Family::Iqr, "LD SM400; MOV K-1 D0; BKCMP<_U D0 K3 M0 K1; LD M0; Op1; END", 0),
        (Family::Q, "LD SM400; MOV K5 D0; BKXNR D0 D0 D9 K1; LD<> D9 K-1; Op1; END", 0),
        (Family::Q, "LD SM400; MOV K5 D0; BKAND D0 K4 D9 K2; LD<> D9 K4; Op1; END", 0),
        (Family::Q, "LD= D9 K0; BKAND D0 K4 D9 D30; LD= D9 K3; Op1; END", 1),
    ] {
        assert_eq!(together(family, text), want, "{text}");
    }
}

#[test]
fn a_constant_text_fills_its_words_alone() {
    for (text, want) in [
        ("LD SM400; $MOV \"AB1\" D0; LD<> D0 H4241; OR<> D1 H31; Op1; END", 0),
        ("LD SM400; $MOV \"AB\" D0; LD<> D0 H4241; OR D1.7; Op1; LD D1.8; Op2; END", 2),
        ("LD= D3 K1; $MOV \"AB1\" D0; LD= D3 K2; Op1; END", 1),
        ("LD= D3 K1; Op1; LD SM400; $MOV \"AB1\" D0; LD= D3 K2; Op2; END", 2),
    ] {
        assert_eq!(together(Family::Q, text), want, "{text}");
    }
}
