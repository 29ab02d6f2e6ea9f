//! What MELSEC's families do differently, above all the FX and FX5: each test names operations that one of them can
//! run in one scan, though the others cannot.

mod common;

use common::melsec::together;
use scanbound::dialect::melsec::device::Family;

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
