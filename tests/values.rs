//! What words can hold where they count: within a scan whoever writes between scans, and what the program writes in
//! every scan where that is trusted.

mod common;

use common::audited::table;
use scanbound::audit::{Request, audit};
use scanbound::base::facts::Facts;
use scanbound::front::Input;
use scanbound::passes::values::Trust;

/// What one scan takes at most and at least, in operations `Op1` and words moved.
fn bounds(trust: Trust, text: &str) -> (u64, u64) {
    let table = table("Op1,1,0,0\nOp100,100,0,0\nFMOV,0,0,1\nBMOV,0,0,1\n");
    let lines = text.replace("; ", "\n") + "\n";
    let inputs = [Input { name: "a.txt".to_owned(), bytes: lines.into_bytes() }];
    let facts = Facts::default();
    let request = Request {
        dialect: Some("melsec-list"),
        cpu: Some("Q26UDV"),
        table: Some(&table),
        trust,
        ..Request::new(&inputs, &facts)
    };
    let bound = audit(&request).unwrap_or_else(|why| panic!("{text}\n{why:?}")).bound;
    let us = |time: scanbound::base::time::Picos| (time.0 - bound.overhead.0) / 1_000_000;
    (us(bound.upper), us(bound.lower))
}

fn none(text: &str) -> u64 {
    bounds(Trust::None, text).0
}

fn counts(text: &str) -> u64 {
    bounds(Trust::Counts, text).0
}

#[test]
fn an_index_of_known_range_writes_those_cells_and_no_more() {
    let write = |mask: &str, base: &str| {
        format!(
            "LD SM400; WAND {mask} Z0; MOV K19 D50; MOV K0 D{base}Z0; MOV K0 D200; FOR D50; LD X0; Op1; NEXT; END"
        )
    };
    assert_eq!(none(&write("K7", "60")), 19);
    assert_eq!(none(&write("K7", "40")), 19);
    // It may be D50 itself, which is 0 then: one turn or none.
    assert_eq!(none(&write("K15", "40")), 19);
    let block = |count: &str| {
        format!(
            "LD SM400; WAND K7 Z0; WAND {count} D70; MOV K19 D50; BMOV D100 D30Z0 D70; MOV K0 D200; FOR D50; LD X0; Op1; NEXT; END"
        )
    };
    let moved = |most: u64| none(&block(&format!("K{most}"))) - most;
    assert_eq!(moved(7), 19);
    // 30 + 7 + 15 - 1 = 51: D50 may be any of D100 to D114.
    assert!(moved(15) > 30_000);
}

#[test]
fn an_index_to_an_extended_register_may_have_two_words() {
    let write = |index: &str| {
        format!(
            "LD SM400; {index}; MOV K19 D50; MOV D9 D20000Z0; MOV K0 D30000; FOR D50; LD X0; Op1; NEXT; END"
        )
    };
    assert_eq!(none(&write("DMOV K3 Z0")), 19);
    // Z1 may be anything, and whether it counts is a parameter.
    assert_eq!(none(&write("MOV K3 Z0")), 32_767);
}

#[test]
fn counts_keep_within_what_instructions_can_give() {
    let of = |how: &str| none(&format!("LD SM400; {how}; FOR D50; LD X0; Op1; NEXT; END"));
    assert_eq!(of("WAND K12 D0 D50"), 12);
    assert_eq!(of("LIMIT K1 K9 D0 D50"), 9);
    assert_eq!(of("SUM D0 D50"), 16);
    assert_eq!(of("SER D0 D100 D50 K30"), 30);
    assert_eq!(of("WAND K255 D0 D1; / D1 K20 D50"), 12);
    assert_eq!(of("WAND K255 D0 D1; / D1 K20 D49"), 19);
    assert_eq!(of("WAND K7 D0 D1; * D1 K5 D50"), 35);
    assert_eq!(of("DMOV K70000 D50"), 70_000 - 65_536);
    assert_eq!(of("WAND K7 D0 D50; + K3 D50"), 10);
    assert_eq!(of("WAND K7 D0 D50; - K3 D50"), 4);
    // Anything: D0 may be negative, and as large as a word can be.
    assert_eq!(of("+ K1 D0 D50"), 32_767);
    assert_eq!(of("LIMIT K9 K1 D0 D50"), 32_767);
}

#[test]
fn guards_bound_what_stands_behind_them() {
    let moved = |contacts: &str| none(&format!("LD X0; {contacts}; FMOV K0 D100 D50; END"));
    assert_eq!(moved("AND> D50 K0; AND<= D50 K25"), 25);
    assert_eq!(moved("AND> K25 D50; AND<= K0 D50"), 24);
    assert_eq!(moved("AND= D50 K25"), 25);
    // A negative count is a large one, and here another write comes between.
    assert_eq!(moved("AND<= D50 K25"), 65_535);
    assert_eq!(none("LD<= D50 K25; AND> D50 K0; MOV D0 D50; FMOV K0 D100 D50; END"), 65_535);
}

#[test]
fn loops_add_up_indices_turn_by_turn() {
    let text = "LD SM400; MOV K0 Z0; MOV K19 D50; FOR K10; LD SM400; MOV K0 D100Z0; + K5 Z0; NEXT; \
        LD SM400; MOV K0 D200; FOR D50; LD X0; Op1; NEXT; END";
    assert_eq!(none(text), 19);
    // 45 cells from D10 on: D50 among them.
    let over = text.replace("D100Z0", "D10Z0");
    assert_eq!(none(&over), 1, "it is D50 in the ninth turn, and 0 gives one turn");
    let moved = over.replace("MOV K0 D10Z0", "MOV D300 D10Z0");
    assert_eq!(none(&moved), 32_767);
}

#[test]
fn what_is_written_in_every_scan_is_trusted_and_nothing_else() {
    let later = "FOR D50; LD X0; Op1; NEXT; LD SM400; MOV K19 D50; END";
    assert_eq!((none(later), counts(later)), (32_767, 19));
    // 0 at power-up, and one more in every scan.
    let growing = "FOR D50; LD X0; Op1; NEXT; LD SM400; INC D50; END";
    assert_eq!(counts(growing), 32_767);
    let round = "FOR D50; LD X0; Op1; NEXT; LD SM400; INC D50; LD> D50 K10; MOV K0 D50; END";
    assert_eq!(counts(round), 32_767, "where the guard ends it is not followed across scans yet");
    // A default, a parameter, another's words.
    for free in [
        "LD SM402; MOV K19 D50",
        "LD X1; MOV K19 D50",
        "LD SM400; MOV K19 D51",
        "LD X1; CJ P1; LD SM400; MOV K19 D50; P1",
        "LD SM400; MOV K19 W50; MOV W50 D51",
    ] {
        let text = format!("FOR D50; LD X0; Op1; NEXT; {free}; LD X2; OUT Y0; END");
        assert_eq!(counts(&text), 32_767, "{free}");
    }
    // Written at another place under a condition, too: that counts as well.
    let other = "FOR D50; LD X0; Op1; NEXT; LD X3; MOV K25 D50; LD X4; CJ P1; LD X5; MOV K30 D50; P1; LD SM400; MOV D50 D60; FOR D60; LD X0; Op1; NEXT; LD SM400; MOV K19 D50; LD X6; MOV K40 D50; END";
    assert_eq!(counts(other), 80);
    // What stands there in the midst of a scan is what a power failure leaves of a latched word.
    let midst = "FOR D50; LD X0; Op1; NEXT; LD SM400; MOV K30 D50; MOV K19 D50; END";
    assert_eq!(counts(midst), 30);
    // An index that may be anything voids it all.
    let index = "FOR D50; LD X0; Op1; NEXT; LD SM400; MOV K19 D50; MOV D9 D100Z0; END";
    assert_eq!(counts(index), 32_767);
    let known = "LD SM400; WAND K7 Z0; FOR D50; LD X0; Op1; NEXT; LD SM400; MOV K19 D50; MOV D9 D100Z0; MOV K0 D200; END";
    assert_eq!(counts(known), 19);
}

#[test]
fn lower_bounds_start_from_what_is_trusted() {
    let later = "FOR D50; LD X0; Op1; NEXT; LD SM400; MOV K19 D50; END";
    assert_eq!(bounds(Trust::Counts, later), (19, 19));
}
