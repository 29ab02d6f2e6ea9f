//! What words can hold where they count: within a scan whoever writes between scans, and what the program writes in
//! every scan where that is trusted.

#[path = "values/domain.rs"]
mod domain;

use common::audited::{asked, listed, table};
use scanbound::audit::{Counts, Failure, Request, audit, follow};
use scanbound::base::facts::Facts;
use scanbound::front::Input;
use scanbound::passes::values::Trust;
use scanbound::program::Step;

/// What one scan takes at most and at least, in operations `Op1` and words moved.
fn bounds(trust: Trust, text: &str) -> (u64, u64) {
    with_facts(trust, "", text).unwrap_or_else(|why| panic!("{text}\n{why}"))
}

/// The same where something is stated, or the first fault.
fn with_facts(trust: Trust, facts: &str, text: &str) -> Result<(u64, u64), String> {
    let table = table("Op1,1,0,0\nOp100,100,0,0\nFMOV,0,0,1\nBMOV,0,0,1\n");
    let lines = text.replace("; ", "\n") + "\n";
    let inputs = listed(lines);
    let facts = Facts::parse("facts.toml", facts).map_err(|faults| faults[0].message.clone())?;
    let request = asked(&inputs, &table, &facts, trust);
    let bound = match audit(&request) {
        Ok(audit) => audit.bound,
        Err(Failure::Input(faults)) => return Err(faults[0].message.clone()),
        Err(why) => return Err(format!("{why:?}")),
    };
    let us = |time: scanbound::base::time::Picos| (time.0 - bound.overhead.0) / 1_000_000;
    Ok((us(bound.upper), us(bound.lower)))
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
    // It may be D50 itself, which is 0 then: one iteration or none.
    assert_eq!(none(&write("K15", "40")), 19);
    // Nor are others written where the program names none so far on.
    assert_eq!(none(&write("K7", "60").replace("D200", "D55")), 19);
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
fn what_a_module_delivers_anywhere_is_no_bookkeeping_of_the_scan() {
    let after =
        |asked: &str| format!("FOR D50; LD X0; Op1; NEXT; {asked}; LD SM400; MOV K3 D50; END");
    assert_eq!(counts(&after("LD X1; SP.DATERD D100")), 3);
    // It comes between scans, behind the write that is in every scan.
    assert!(counts(&after("LD X1; GP.NOSUCH U0 D100 M0")) > 30_000);
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
    let one = write("MOV K3 Z0");
    assert_eq!(none(&one), 32_767);
    let stated = |bits: u32, text: &str| {
        with_facts(Trust::None, &format!("[index]\nbits = {bits}\n"), text).map(|found| found.0)
    };
    assert_eq!(stated(16, &one), Ok(19));
    // Such a D may be no extended one all the same; a file register has one reading.
    assert_eq!(stated(32, &one), Ok(32_767));
    let file = "LD SM400; MOV K0 Z1; MOV K19 ZR50; MOV D9 ZR40Z0; FOR ZR50; LD X0; Op1; NEXT; END";
    assert_eq!(none(file), 32_767);
    let low = file.replace("MOV K0 Z1", "DMOV K3 Z0");
    assert_eq!(stated(32, &low), Ok(19));
    assert_eq!(stated(16, &low), Ok(19));
    assert_eq!(stated(16, file), Ok(32_767));
}

#[test]
fn counts_keep_within_what_instructions_can_give() {
    let of = |how: &str| none(&format!("LD SM400; {how}; FOR D50; LD X0; Op1; NEXT; END"));
    assert_eq!(of("WAND K12 D0 D50"), 12);
    assert_eq!(of("LIMIT K1 K9 D0 D50"), 9);
    assert_eq!(of("WAND K2 D0 D50; WOR K1 D50"), 3);
    assert_eq!(of("MOV K9 D50; TEST D1 K3 D50.1"), 32_767, "a bit of it is not followed");
    // One iteration or none.
    assert_eq!(of("LIMIT K-5 K0 D0 D50"), 1);
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

/// An index is known anew in each call and each iteration: what is read and written by it is that cell and no other.
#[test]
fn what_an_index_is_known_to_be_is_the_cell_itself() {
    let called = |body: &str| {
        format!(
            "LD SM400; MOV K3 D103; MOV K5 D105; MOV K3 Z0; CALL P1; MOV K5 Z0; CALL P1; FEND; P1; \
             LD SM400; {body}; FOR D50; LD X0; Op1; NEXT; RET; END"
        )
    };
    assert_eq!(none(&called("MOV D100Z0 D50")), 8, "3 in the first call, 5 in the second");
    // A product of what is known, and a double word.
    assert_eq!(none(&called("* Z0 K35 D60; MOV K4 D175; MOV D60 Z1; MOV D0Z1 D50")), 5 + 4);
    // Written in one call, asked for in the next: it is the same cell or it is not.
    let asked = |from: u16| {
        format!(
            "LD SM400; MOV K3 Z0; CALL P1; MOV K{from} Z0; CALL P1; FEND; P1; \
             LD= D100Z0 K7; MOV K1 D100Z0; Op100; RET; END"
        )
    };
    assert_eq!((none(&asked(3)), none(&asked(4))), (100, 200));
    let bits = |from: u16| {
        format!(
            "LD SM400; MOV K3 Z0; CALL P1; MOV K{from} Z0; CALL P1; FEND; P1; \
             LD M100Z0; RST M100Z0; Op100; RET; END"
        )
    };
    assert_eq!((none(&bits(3)), none(&bits(4))), (100, 200));
    // Blocks that are moved carry what they hold.
    let moved = "LD SM400; MOV K9 D15; MOV K10 Z2; BMOV D0Z2 D40Z2 K8; MOV D55 D50; FOR D50; LD X0; Op1; NEXT; END";
    assert_eq!(none(moved), 9 + 8);
    let turns = "LD SM400; MOV K0 Z0; FOR K4; LD= D100Z0 K7; Op100; LD SM400; MOV K0 D101Z0; + K1 Z0; NEXT; END";
    assert_eq!(none(turns), 100, "each iteration clears what the next asks for");
}

/// An index that may be one of two leads to one cell in each scan.
#[test]
fn an_index_of_a_few_values_leads_to_one_cell_each() {
    let either = "LD SM400; MOV K5 Z0; LD X0; MOV K4 Z0; LD SM400";
    let written = "FMOV K9 D104 K2; MOV K1 D100Z0; LD= D104 K9; Op100; LD= D105 K9; Op100; END";
    assert_eq!(none(&format!("{either}; {written}")), 102, "one of the two is left");
    for (first, second) in [(7, 9), (9, 7)] {
        let read = format!(
            "MOV K{first} D104; MOV K{second} D105; MOV D100Z0 D50; LD= D50 K7; Op100; LD= D50 K9; Op1; END"
        );
        assert_eq!(none(&format!("{either}; {read}")), 100);
    }
    // A count is any of those that may stand there, the last one too.
    let last = "LD SM400; MOV K1 D100; MOV K2 D101; MOV K30 D102; LIMIT K0 K2 D0 Z0; MOV D100Z0 D50; FOR D50; LD X0; Op1; NEXT; END";
    assert_eq!(none(last), 30);
    let bits = "SET M4; SET M5; RST M0Z0; LD M4; Op100; LD M5; Op100; END";
    assert_eq!(none(&format!("{either}; {bits}")), 100);
    // A coil behind a guard is written where the guard does not hold, too: M3 goes off then.
    let coil =
        "LD SM400; MOV K3 Z0; SET M3; LD X1; MOV K4 Z0; LD= Z0 K4; OUT M0Z0; LDI M3; Op100; END";
    assert_eq!(none(coil), 100);
}

/// Where an index to a file register has 32 bits both of its words count.
#[test]
fn an_index_of_two_words_is_one_number() {
    let wide =
        |text: &str| with_facts(Trust::None, "[index]\nbits = 32\n", text).map(|found| found.0);
    let known = "LD SM400; MOV K7 ZR65549; MOV K5 ZR14; DMOV K65539 Z0; MOV ZR10Z0 D50; LD= D50 K7; Op100; END";
    assert_eq!(wide(known), Ok(100));
    for (first, second) in [(7, 9), (9, 7)] {
        let text = format!(
            "LD SM400; MOV K{first} ZR13; MOV K{second} ZR14; MOV K{first} ZR65549; MOV K{second} ZR65550; \
             DMOV K3 Z0; LD X0; MOV K4 Z0; LD X1; MOV K1 Z1; LD SM400; MOV ZR10Z0 D50; \
             LD= D50 K7; Op100; LD= D50 K9; Op1; END"
        );
        assert_eq!(wide(&text), Ok(100));
    }
}

/// Behind a loop all may be that may be where it ends earlier.
#[test]
fn what_is_known_in_a_loops_last_iteration_ends_with_it() {
    let text = "LD SM400; MOV K7 D103; MOV K0 D105; MOV K5 Z0; MOV K2 D9; LD X0; MOV K3 Z0; MOV K1 D9; \
        FOR D9; LD X1; OUT Y0; NEXT; LD= D100Z0 K7; Op100; END";
    assert_eq!(none(text), 100);
}

/// An interrupt comes at any moment: what it reads by index is what stood there then.
#[test]
fn what_interrupts_read_by_index_is_any_value() {
    let text = "LD SM400; MOV K3 Z0; MOV K7 D103; LD X0; OUT Y0; LD SM400; MOV K5 D103; FEND; \
        I0; LD= D100Z0 K7; Op100; IRET; END";
    let of = |text: &str| {
        with_facts(Trust::None, "[interrupts]\nI0 = 1\n", text).map(|(upper, _)| upper)
    };
    assert_eq!(of(text), Ok(100));
    // And what they write may be read at once.
    let written = "LD SM400; MOV K3 Z0; MOV K7 D103; LD= D100Z0 K9; Op100; FEND; I0; LD SM400; MOV K9 D103; IRET; END";
    assert_eq!(of(written), Ok(100));
}

/// Digits from an index on are as many bits in a row, and a number that does not fit its words is not followed.
#[test]
fn numbers_keep_their_bits_where_they_go() {
    let digits = "LD SM400; MOV K1 Z0; DMOV K65537 K8M0Z0; LD M17; AND M1; ANI M2; Op100; END";
    assert_eq!(none(digits), 100);
    let word = "LD SM400; MOV K5 D10; DMOV K70000 D0; WORD D0 D10; LD= D10 K5; Op100; END";
    assert_eq!(none(word), 100);
}

/// Quotients are cut towards zero, and rests have the dividend's sign.
#[test]
fn what_is_known_is_divided_as_a_plc_divides() {
    for (of, by, quotient, rest) in [(-7, 2, -3, -1), (7, -2, -3, 1), (-7, -2, 3, -1)] {
        let text = format!(
            "LD SM400; MOV K{of} D0; MOV K{by} D1; / D0 D1 D10; LD= D10 K{quotient}; AND= D11 K{rest}; Op100; END"
        );
        assert_eq!(none(&text), 100);
    }
}

/// A guard says what an index is, or between which ends it lies.
#[test]
fn what_a_guard_says_of_an_index_holds_behind_it() {
    let text = |guard: &str, write: &str| {
        format!("LD SM400; MOV K2 D50; {guard}; MOV D0 Z0; {write}; FOR D50; LD X0; Op1; NEXT; END")
    };
    // D10 to D49 are written, then D50 too.
    let between = |most: u16| format!("LD>= D0 K0; AND<= D0 K{most}");
    assert_eq!(none(&text(&between(39), "MOV K9 D10Z0")), 2);
    assert_eq!(none(&text(&between(40), "MOV K9 D10Z0")), 9);
    // Four bits are up to 15.
    assert_eq!(
        none("LD SM400; MOV K2 D50; MOV K1M0 Z0; MOV K9 D36Z0; FOR D50; LD X0; Op1; NEXT; END"),
        9
    );
    assert_eq!(
        none("LD SM400; MOV K2 D50; MOV K1M0 Z0; MOV K9 D34Z0; FOR D50; LD X0; Op1; NEXT; END"),
        2
    );
    // D50 is the first of them, or the one before.
    assert_eq!(none(&text(&between(39), "MOV K9 D50Z0")), 9);
    assert_eq!(none(&text("LD>= D0 K1; AND<= D0 K39", "MOV K9 D50Z0")), 2);
    assert_eq!(none(&text("LD= D0 K40", "MOV K9 D10Z0")), 9);
    assert_eq!(none(&text("LD= D0 K41", "MOV K9 D10Z0")), 2);
    assert_eq!(none(&text(&between(39), "FMOV K9 D10Z0 K1")), 3);
    assert_eq!(none(&text(&between(39), "FMOV K9 D10Z0 K2")), 2 + 9);
    let wider = |bits: &str| {
        let text = "LD SM400; MOV K7 ZR50; MOV D0 Z0; LD= ZR5Z0 K1; MOV K0 ZR5Z0; Op100; LD= ZR5Z0 K1; Op100; LD ZR99.0; OUT Y0; END";
        with_facts(Trust::None, bits, text).map(|bound| bound.0)
    };
    assert_eq!(wider(""), Ok(200));
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
    assert_eq!(none(&over), 1, "it is D50 in the ninth iteration, and 0 gives one");
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
    assert_eq!(counts(round), 32_767, "power may fail before the reset: 11, then 12 ...");
    let before = |guard: &str| {
        counts(&format!("FOR D50; LD X0; Op1; NEXT; {guard}; MOV K0 D50; LD SM400; INC D50; END"))
    };
    assert_eq!((before("LD>= D50 K10"), before("LD> D50 K10")), (10, 11));
    assert_eq!((before("LD= D50 K10"), before("LD X1; AND= D50 K10")), (10, 32_767));
    // A default, a parameter, another's words.
    for free in [
        "LD SM402; MOV K19 D50",
        "LD X1; MOV K19 D50",
        "LD SM400; MOV K19 D51",
        "LD X1; CJ P1; LD SM400; MOV K19 D50; P1",
        "LD X1; STOP; LD SM400; MOV K19 D50",
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
    // What the program only ever clears somebody else sets, even where all is trusted.
    let cleared = "FOR D50; LD X0; Op1; NEXT; LD X1; MOV K0 D50; END";
    assert_eq!(bounds(Trust::All, cleared).0, 32_767);
    assert_eq!(bounds(Trust::All, &cleared.replace("K0", "K6")).0, 6);
    // An index that may be anything voids it all.
    let index = "FOR D50; LD X0; Op1; NEXT; LD SM400; MOV K19 D50; MOV D9 D100Z0; END";
    assert_eq!(counts(index), 32_767);
    let known = "LD SM400; WAND K7 Z0; FOR D50; LD X0; Op1; NEXT; LD SM400; MOV K19 D50; MOV D9 D100Z0; MOV K0 D200; END";
    assert_eq!(counts(known), 19);
}

#[test]
fn words_that_are_stated_to_be_the_programs_own_are_trusted_wherever_they_serve() {
    let stated = |trust: Trust, text: &str| {
        let facts = "[internal]\ndevices = ['D50-D59']\n";
        (
            with_facts(trust, "", text).map(|one| one.0),
            with_facts(trust, facts, text).map(|one| one.0),
        )
    };
    // Written under X0 only: an HMI's parameter with a default, unless that is excluded.
    let count = "LD X0; MOV K19 D50; FOR D50; LD X1; Op1; NEXT; END";
    assert_eq!(stated(Trust::Counts, count), (Ok(32_767), Ok(19)));
    assert_eq!(stated(Trust::None, count), (Ok(32_767), Ok(32_767)));
    // Not only what counts: what is compared, too, and what that is worked out from.
    let compared = "LD> D50 K19; Op100; LD X0; MOV D51 D50; LD X1; MOV K7 D51; END";
    assert_eq!(stated(Trust::Counts, compared), (Ok(100), Ok(0)));
    let free = "LD> D50 K19; Op100; LD X0; MOV D61 D50; LD SM400; MOV K7 D61; END";
    assert_eq!(stated(Trust::Counts, free), (Ok(100), Ok(100)), "D61 may be another's");
    let both = "LD> D50 K19; Op100; LD X0; MOV K7 D50; FOR D70; LD X1; Op1; NEXT; LD SM400; MOV K9 D70; END";
    assert_eq!(stated(Trust::Counts, both), (Ok(109), Ok(9)));
}

#[test]
fn lower_bounds_start_from_what_is_trusted() {
    let later = "FOR D50; LD X0; Op1; NEXT; LD SM400; MOV K19 D50; END";
    assert_eq!(bounds(Trust::Counts, later), (19, 19));
}

#[test]
fn a_stated_count_holds_at_its_place_and_excludes_scans_with_another() {
    let stated = |facts: &str, text: &str| with_facts(Trust::None, facts, text);
    let five = "[counts]\n\"a.txt:2\" = [0, 5]\n";
    // Turns and units, whoever wrote the word.
    assert_eq!(stated(five, "NOP; FOR D50; LD X1; Op1; NEXT; END"), Ok((5, 5)));
    assert_eq!(stated(five, "LD X0; BMOV D0 D100 D50; END"), Ok((5, 5)));
    assert_eq!(
        stated("[counts]\n\"a.txt:2\" = 3\n", "NOP; FOR D50; LD X1; Op1; NEXT; END"),
        Ok((3, 3))
    );
    // A scan that counts otherwise there is none: what it would do elsewhere costs nothing.
    let elsewhere = "NOP; FOR D50; LD X1; Op1; NEXT; LD> D50 K9; Op100; END";
    assert_eq!(bounds(Trust::None, elsewhere).0, 32_767 + 100);
    assert_eq!(stated(five, elsewhere), Ok((5, 5)));
    let elsewhere = "LD X0; BMOV D0 D100 D50; LD> D50 K9; Op100; END";
    // Where the block is not moved nothing is said of the word.
    assert_eq!(stated(five, elsewhere), Ok((100, 100)));
    assert_eq!(stated(five, &elsewhere.replace("LD X0", "LD SM400")), Ok((5, 5)));
    // Where control does not come there nothing is said of the word.
    let passed = "LD X0; CJ P0; FOR D50; LD X1; Op1; NEXT; P0; LD> D50 K9; Op100; END";
    assert_eq!(stated("[counts]\n\"a.txt:3\" = [0, 5]\n", passed), Ok((100, 100)));
    // At this place and no other.
    let twice = "NOP; FOR D50; LD X1; Op1; NEXT; LD SM400; INC D50; FOR D50; LD X1; Op1; NEXT; END";
    assert_eq!(stated(five, twice).map(|(upper, _)| upper), Ok(5 + 6));
    // What the program always counts otherwise no scan keeps; what it may count otherwise is left out.
    let set = "LD X0; FMOV K0 D100 D50; LD SM400; MOV K19 D50; FOR D50; LD X1; Op1; NEXT; END";
    let other = |low: u32| format!("[counts]\n\"a.txt:5\" = [{low}, 18]\n");
    let contradicts = |low: u32| {
        Err(format!(
            "the number of iterations or units of `FOR D50` (a.txt:5) cannot be {low} to 18 as stated: `MOV K19 D50` (a.txt:4) writes D50"
        ))
    };
    assert_eq!(stated(&other(0), set), contradicts(0));
    assert_eq!(stated(&other(18), set), contradicts(18));
    let may = set.replace("LD SM400", "LD X2");
    assert_eq!(stated(&other(0), &may).map(|found| found.0), Ok(18 + 18));
    // An index that nobody knows writes the word in between.
    let lost = "NOP; FOR D50; LD SM400; MOV K900 D0Z5; Op1; NEXT; FOR D50; LD X1; Op1; NEXT; END";
    assert_eq!(stated(five, lost).map(|(upper, _)| upper), Ok(5 + 32_767));
}

#[test]
fn counts_are_stated_of_places_that_count() {
    let loops = "NOP; FOR D50; LD X1; Op1; NEXT; FOR K9; LD X1; Op1; NEXT; END";
    for (facts, told) in [
        (
            "\"a.txt:3\" = 5",
            "at a.txt:3, no instruction reads a number of iterations or units from a word",
        ),
        // A constant.
        (
            "\"a.txt:6\" = 5",
            "at a.txt:6, no instruction reads a number of iterations or units from a word",
        ),
        ("\"b.txt:2\" = 5", "there is no file 'b.txt' in this program"),
        (
            "\"a.txt\" = 5",
            "no instruction reads a number of iterations or units from the word 'a.txt'",
        ),
        (
            "\"a.txt:x\" = 5",
            "'a.txt:x' does not end with a line number (FILE:543) or a step (FILE:step 120)",
        ),
        (
            "\"a.txt:2\" = 40000",
            "the number of iterations or units of `FOR D50` at a.txt:2 cannot be 40000 to 40000 as stated",
        ),
        (
            "\"a.txt:2\" = [3, 1]",
            "'a.txt:2' in [counts] must be a non-negative integer or [min, max]",
        ),
    ] {
        let fault = with_facts(Trust::None, &format!("[counts]\n{facts}\n"), loops);
        assert_eq!(fault, Err(told.to_owned()));
    }
}

#[test]
fn counts_that_are_not_known_are_told_with_the_fact_that_would_help() {
    let table = table("Op1,1,0,0\nFMOV,0,0,1\n");
    let text =
        "LD X0\nFMOV K0 D100 D50\nFOR D51\nLD X1\nOp1\nOp1\nNEXT\nFOR K3\nLD X1\nOp1\nNEXT\nEND\n";
    let told = |text: &str, facts: &str| {
        let inputs = [Input { name: "dir/a b.txt".to_owned(), bytes: text.as_bytes().to_vec() }];
        let facts = Facts::parse("facts.toml", facts).expect("facts");
        let request = asked(&inputs, &table, &facts, Trust::None);
        audit(&request).expect("an audit").unknowns
    };
    let unknowns = told(text, "");
    let us = |time: scanbound::base::time::Picos| time.0 / 1_000_000;
    let shown: Vec<_> = unknowns
        .iter()
        .map(|one| (one, *one.counts().expect("a count")))
        .map(|(one, Counts { most, each, cost })| {
            (&*one.word, one.places[0].0.line, most, us(each), us(cost))
        })
        .collect();
    // The block's 65,535 words at 1 us each, the loop's 32,767 iterations at 2 us.
    assert_eq!(shown, [("D50", 2, 65_535, 1, 65_535), ("D51", 3, 32_767, 2, 65_534)]);
    assert_eq!(unknowns[0].fact, "\"a b.txt:2\" = [0, 20]");
    // A little is known of the one, enough of the other.
    let guards = text.replace("LD X0\nFMOV", "LD X0\nAND>= D50 K0\nAND<= D50 K9000\nFMOV");
    let guards = guards.replace("NEXT\nFOR K3", "NEXT\nLD SM400\nWAND K63 D51\nFOR D51");
    let words: Vec<(String, i64)> = told(&guards, "")
        .iter()
        .map(|one| (one.word.to_string(), one.counts().expect("a count").most))
        .collect();
    assert_eq!(words, [("D51".to_owned(), 32_767), ("D50".to_owned(), 9000)]);
    // What is offered is taken, and nothing is left to be said.
    let lines: Vec<&str> = unknowns.iter().map(|one| one.fact.as_str()).collect();
    assert_eq!(told(text, &format!("[counts]\n{}\n", lines.join("\n"))), []);
}

#[test]
fn a_count_may_be_stated_by_its_step() {
    let head = "\"t\"\n\"PLC Information:\",\"Q26UDV\"\n\"Step No.\",\"Line Statement\",\"Instruction\",\"I/O (Device)\",\"Blank\",\"PI Statement\",\"Note\"\n";
    let rows = "0,,LD,X0,,,\n1,,FMOV,K0,,,\n,,,D100,,,\n,,,D50,,,\n5,,FMOV,K0,,,\n,,,D100,,,\n,,,D51,,,\n9,,END,,,,\n";
    let inputs =
        [Input { name: "MAIN.csv".to_owned(), bytes: format!("{head}{rows}").into_bytes() }];
    let told = |facts: &str| {
        let facts = Facts::parse("facts.toml", facts).expect("facts");
        let table = table("FMOV,0,0,1\n");
        let found = audit(&Request { table: Some(&table), ..Request::new(&inputs, &facts) });
        let unknowns = found.expect("an audit").unknowns;
        unknowns.iter().map(|one| one.places[0].0.step).collect::<Vec<_>>()
    };
    assert_eq!(told(""), [Some(1), Some(5)]);
    assert_eq!(told("[counts]\n\"main.csv:step 5\" = [0, 9]\n"), [Some(1)]);
    // Line 8 is the one in which it begins.
    assert_eq!(told("[counts]\n\"MAIN.csv:8\" = 9\n\"MAIN.csv:step 1\" = 9\n"), []);
}

/// The most units that are counted.
fn most(text: &str) -> u64 {
    let inputs = listed(text.replace("; ", "\n") + "\n");
    let (facts, table) = (Facts::default(), table(""));
    let request = asked(&inputs, &table, &facts, Trust::default());
    let followed = follow(&request).unwrap_or_else(|why| panic!("{text}\n{why:?}"));
    let counted = followed.program.instructions.iter().filter_map(|one| one.counted());
    counted.map(|counted| counted.most).max().expect("something is counted")
}

#[test]
fn what_is_written_and_read_under_the_same_contacts_is_what_was_written() {
    let moved = |rungs: &str| most(&format!("{rungs}; FMOV K0 D100 D50; END"));
    let all = 65_535;
    assert_eq!(moved("LD M0; MOV K7 D50; LD M0"), 7);
    assert_eq!(moved("LD M0; MOV K7 D50; LD M0; AND X1"), 7);
    assert_eq!(moved("LD M0; MOV K7 D50; LD M1"), all);
    assert_eq!(moved("LD M0; AND X1; MOV K7 D50; LD M0"), all);
    assert_eq!(moved("LD M0; MOV K7 D50; LDI M0"), all);
    assert_eq!(moved("LDI M0; MOV K7 D50; LDI M0"), 7);
    assert_eq!(moved("LD M0; MOV K7 D50; LD M0; OR M1"), all);
    // That a coil is off says nothing of one of its contacts.
    assert_eq!(moved("LD M0; AND M1; OUT M5; LDI M0; MOV K7 D50; LDI M5"), all);
    // Of very many contacts some are remembered.
    let many = |count: u32| {
        let more: Vec<String> = (1..count).map(|n| format!("; AND M{n}")).collect();
        format!("LD M0{}", more.concat())
    };
    assert_eq!(moved(&format!("{}; MOV K7 D50; {}", many(24), many(24))), 7);
    assert_eq!(moved(&format!("{}; MOV K7 D50; {}", many(25), many(24))), all);
    // What is worked out from it, and what a comparison has seen once.
    let worked = "LD M0; SER K0 D200 D20 K30; - K30 D21 D50; LD M0; AND< K0 D50";
    assert_eq!(moved(worked), 30);
    assert_eq!(moved("LD= D9 K1; MPS; MOV K7 D50; MPP; AND X1"), 7);
    assert_eq!(moved("LD= D9 K1; MOV K7 D50; LD= D9 K1"), all);
    // The contact is written in between, by itself, as a digit or through an index.
    for between in ["OUT M0", "SET M0", "MOV K1 K1M0", "MOV K1 K1M1Z0", "PLS M0"] {
        let text = format!("LD M0; MOV K7 D50; LD X2; {between}; LD M0");
        assert_eq!(moved(&text), all, "{between}");
    }
    assert_eq!(moved("LD M0; MOV K7 D50; LD X2; OUT M1; LD M0"), 7);
    // Another write of the word in between, or one that did not happen.
    assert_eq!(moved("LD M0; MOV K7 D50; LD X2; MOV K9 D50; LD M0"), 9);
    assert_eq!(moved("LD M0; MOV K7 D50; LD X2; MOV D9 D50; LD M0"), all);
    assert_eq!(moved("LD M0; MOV K7 D50; LDI M0; MOV D9 D50; LD M0"), 7);
    assert_eq!(moved("LD M0; MOV K7 D50; LD X2; CJ P1; LD X1; OUT M0; P1; LD M0"), all);
    // A coil is on when what it was written from is.
    assert_eq!(moved("LD> D50 K0; AND<= D50 K10; OUT M5; LD X1; AND M5"), 10);
    assert_eq!(moved("LD> D50 K0; AND<= D50 K10; OUT M5; LD SM400; MOV D9 D50; LD M5"), all);
    assert_eq!(moved("LD> D50 K0; AND<= D50 K10; SET M5; LD M5"), all);
    // In a loop the contact of the iteration before is another.
    let round = "LD M0; MOV K7 D50; FOR K3; LD M0; FMOV K0 D100 D50; LD X1; OUT M0; NEXT; END";
    assert_eq!(most(round), all);
    assert_eq!(most(&round.replace("OUT M0", "OUT M1")), 7);
}

#[test]
fn a_block_reaches_as_far_as_its_count() {
    let text = |to: &str, mask: &str| {
        format!(
            "LD SM400; MOV K19 D50; WAND {mask} D70; BMOV W0 {to} D70; MOV K0 D300; FOR D50; LD X0; Op1; NEXT; END"
        )
    };
    let turns = |to: &str, mask: &str, most: u64| none(&text(to, mask)) - most;
    assert_eq!(turns("D51", "K15", 15), 19);
    assert_eq!(turns("D30", "K15", 15), 19);
    assert_eq!(turns("D40", "K15", 15), 32_767);
    // A count of two words is more than its lower one says.
    let long = |to: &str| {
        let text =
            format!("LD SM400\nMOV K19 D50\nWAND K7 D70\nBMOVL W0 {to} D70\nFOR D50\nNEXT\nEND\n");
        let inputs = listed(text);
        let (facts, table) = (Facts::default(), table(""));
        let request =
            Request { cpu: Some("R04CPU"), ..asked(&inputs, &table, &facts, Trust::default()) };
        let followed = follow(&request).expect("followed");
        let most = followed.program.instructions.iter().filter_map(|one| match one.step {
            Step::ForBegin { most, .. } => Some(most),
            _ => None,
        });
        let summary = followed.program.instructions.iter().filter_map(|one| match &one.step {
            Step::Summary(summary) => summary.iterations.map(|(.., most)| most),
            _ => None,
        });
        most.chain(summary).next()
    };
    assert_eq!((long("D51"), long("D30")), (Some(19), Some(32_767)));
}

#[test]
fn what_is_written_through_an_address_may_be_stated() {
    let text =
        "LD SM400; MOV K19 D50; MOV D9 @D20; BMOV W0 @D22 K3; FOR D50; LD X0; Op1; NEXT; END";
    let stated = |devices: &str| {
        let facts = format!("[index]\nindirect = [{devices}]\n");
        with_facts(Trust::None, &facts, text).map(|found| found.0)
    };
    assert_eq!(none(text), 32_767 + 3);
    assert_eq!(stated("\"ZR1000-ZR1999\", \"D51-D60\""), Ok(19 + 3));
    assert_eq!(stated("\"ZR1000-ZR1999\", \"D50\""), Ok(32_767 + 3));
    assert_eq!(stated(""), Ok(19 + 3));
    // Which words R are is switched: any of the file register.
    let file = |set: &str| {
        let text =
            format!("LD SM400; {set}; MOV K19 ZR50; MOV D9 @D20; FOR ZR50; LD X0; Op1; NEXT; END");
        with_facts(Trust::None, "[index]\nindirect = [\"R100-R199\"]\n", &text).map(|found| found.0)
    };
    assert_eq!((file("MOV K0 D1"), file("RSET K1")), (Ok(19), Ok(32_767)));
    let wrong = |devices: &str| {
        assert_eq!(
            stated(&format!("\"{devices}\"")),
            Err(format!("'{devices}' under [index] indirect is not a device or a device range"))
        );
    };
    ["D9-D5", "D5-W9", "K5", "T0", ""].iter().for_each(|devices| wrong(devices));
}

#[test]
fn a_count_may_be_stated_by_its_word() {
    let text = "LD X0; FMOV K0 D100 D50; LD X1; FMOV K0 D200 D50; LD X2; FMOV K0 D300 D51; END";
    let stated = |facts: &str| {
        with_facts(Trust::None, &format!("[counts]\n{facts}\n"), text).map(|found| found.0)
    };
    assert_eq!(stated("D50 = [0, 4]\nd51 = 5"), Ok(4 + 4 + 5));
    assert_eq!(
        stated("D50 = [0, 4]\n\"a.txt:4\" = 1\nD51 = 5"),
        Ok(4 + 5),
        "where the second runs it is 1 in both"
    );
    assert_eq!(
        stated("D100 = 4"),
        Err("no instruction reads a number of iterations or units from the word 'D100'".to_owned())
    );
}

#[test]
fn what_a_long_loop_leaves_is_not_forgotten_where_it_makes_less_of_it() {
    // D10 halves in every iteration, so what comes out of one is never what went in.
    let text = "LD SM400; MOV K3 D10; LD X0; CJ P0; LD SM400; LIMIT K0 K500 D0 D10; FOR K3000; LD SM400; \
        / D10 K2 D20; MOV D20 D10; NOPS; NEXT; LD SM400; WAND K255 D1 D10; P0; LD SM400; FMOV D0 D100 D10; END";
    let text = text.replace("NOPS", &["NOP"; 150].join("; "));
    assert_eq!(none(&text), 255);
}

#[test]
fn contacts_are_told_apart_by_the_writes_of_their_bits() {
    let moved = |between: &str| {
        none(&format!("LD M0; MOV K9 D10; {between}; LD M0; FMOV D0 D100 D10; END"))
    };
    assert_eq!(moved("LD X0; OUT M5"), 9);
    for between in [
        "LD SM400; MOV D1 K4M0",
        "LD X2; TEST D0 K3 M0",
        "LD X1; SET M0Z0",
        "LD X0; CJ P0; LD X1; OUT M0; P0",
        "LD X0; CJ P0; LD X1; OUT M0; LD SM400; CJ P1; P0; NOP; P1",
    ] {
        assert_eq!(moved(between), 65_535, "{between}");
    }
    // On one of the ways D10 is not written.
    assert_eq!(none("LD X0; CJ P0; LD M0; MOV K9 D10; P0; LD M0; FMOV D0 D100 D10; END"), 65_535);
}

#[test]
fn every_way_to_a_place_counts() {
    let moved = |rungs: &str| none(&format!("LD SM400; {rungs}; LD SM400; FMOV D0 D100 D10; END"));
    // A loop may make no iteration.
    assert_eq!(moved("MOV K9 D10; FOR D50; LD SM400; MOV K3 D10; NEXT"), 9);
    // Two jumps lead to one label.
    let jumps = "MOV K9 D10; LD X0; CJ P0; LD SM400; MOV K3 D10; LD X1; CJ P0; LD SM400; MOV K1 D10; P0; NOP";
    assert_eq!(moved(jumps), 9);
    // On one of them the word is another than the one that was compared.
    let compared = "OUT Y0; LD> D10 K0; AND<= D10 K7; OUT M5; LDI X0; CJ P1; LD SM400; MOV D9 D10; CJ P0; P1; NOP; P0; \
        LD M5; FMOV D0 D100 D10; END";
    assert_eq!(none(&format!("LD SM400; {compared}")), 65_535);
    // A bit of a word of which little is known.
    assert_eq!(moved("WAND K3 D0 D10; LD X0; SET D10.3"), 11);
    // A master control region that is never on ends.
    let zone = "LD SM400; MOV K3 D10; LD SM401; MC N0 M9; LD X0; OUT Y0; MCR N0; LD SM400; MOV K9 D10; \
        FOR D10; LD X0; Op1; NEXT; END";
    assert_eq!(none(zone), 9);
}

/// A loop is followed until nothing new comes: another value within the same range is something new where more was
/// known of the one before.
#[test]
fn what_is_known_of_a_value_is_not_known_of_the_next_iterations() {
    let moved = |before: &str, changes: &str| {
        none(&format!("{before}; FOR K3; LD M0; FMOV K0 D100 D50; LD SM400; {changes}; NEXT; END"))
    };
    // Where M0 is on D50 is 1 in the first iteration.
    let written = "LD SM400; LIMIT K1 K30 D8 D9; MOV K30 D50; LD M0; MOV K1 D50";
    assert_eq!((moved(written, "MOV D9 D51"), moved(written, "MOV D9 D50")), (3, 1 + 30 + 30));
    // The same two values again, and M1 decides which.
    assert_eq!(moved(written, "MOV K30 D50; LD M1; MOV K1 D50"), 1 + 30 + 30);
    // Where M0 is on D50 is at most 5 in the first iteration. (What `LIMIT` gives is charged by its most in each.)
    let compared = "LD SM400; LIMIT K0 K30 D8 D50; LD<= D50 K5; OUT M0";
    let limited = |to: &str| moved(compared, &format!("LIMIT K0 K30 D9 {to}"));
    assert_eq!((limited("D51"), limited("D50")), (3 * 5, 3 * 30));
}

#[test]
fn what_grows_in_a_long_loop_grows_to_the_end() {
    let text = "LD SM400; MOV K3 D10; LD X0; CJ P0; LD SM400; MOV K0 D10; FOR K3000; LD SM400; INC D10; NOPS; NEXT; \
        P0; LD SM400; FMOV D0 D100 D10; END";
    assert_eq!(none(&text.replace("NOPS", &["NOP"; 150].join("; "))), 65_535);
}

#[test]
fn a_block_is_written_up_to_its_last_word() {
    let words = |count: u32| {
        none(&format!("LD SM400; MOV K19 D50; ASC D200 D40 K{count}; FMOV D0 D100 D50; END"))
    };
    assert_eq!((words(10), words(11)), (19, 65_535));
}

/// The table of docs/values.md: what an instruction is known to give is the most units that a block has then.
#[test]
fn what_instructions_are_known_to_give_is_as_the_page_has_it() {
    let page = include_str!("../../docs/values.md");
    let mut examples = 0;
    for row in page.lines().filter(|row| row.starts_with("| ") && row.contains(" D50`")) {
        let cells: Vec<&str> = row.split('|').map(str::trim).collect();
        let [.., example, most, ""] = cells[..] else { panic!("{row}") };
        let most: u64 = most.parse().unwrap_or_else(|_| panic!("{row}"));
        let example = example.trim_matches('`');
        let text = format!("LD SM400; {example}; FMOV K0 D200 D50; END");
        assert_eq!(self::most(&text), most, "{row}");
        examples += 1;
    }
    assert!(examples >= 10, "{examples}");
}

/// A word that is never 0 was not as power-up leaves it when the first scan started.
#[test]
fn what_is_stated_never_to_be_0_is_not_trusted_to_be_the_programs_own() {
    let text = "LD X0; FMOV K0 D100 D50; LD SM400; MOV K7 D50; END";
    let stated =
        |trust, range: &str| with_facts(trust, &format!("[ranges]\nD50 = {range}\n"), text);
    for trust in [Trust::Counts, Trust::All] {
        assert_eq!(stated(trust, "[0, 20]").map(|found| found.0), Ok(7));
        assert_eq!(stated(trust, "[1, 20]").map(|found| found.0), Ok(20));
    }
}

/// What an instruction may write is lost whole, however long it is.
#[test]
fn all_that_a_long_write_may_change_may_hold_anything() {
    let words = |of: &dyn Fn(u32) -> String| (100..180).map(of).collect::<String>();
    let known = words(&|d| format!("MOV K1 D{d}; "));
    let counted = words(&|d| format!("FMOV K0 D2000 D{d}; "));
    let small = |write: &str| {
        let lines = format!("LD SM400; {known}{write}{counted}END").replace("; ", "\n") + "\n";
        let (inputs, table, facts) = (listed(lines), table("FMOV,0,0,1\n"), Facts::default());
        let followed = follow(&asked(&inputs, &table, &facts, Trust::None)).expect("a model");
        let counted = followed.program.instructions.iter().filter_map(|one| one.counted());
        let most: Vec<bool> = counted.map(|counted| counted.most == 1).collect();
        most
    };
    let but = |from: usize, to: usize| -> Vec<bool> {
        (100..180).map(|d| !(from..to).contains(&d)).collect()
    };
    assert_eq!(small(""), but(0, 0));
    assert_eq!(small("FROM H0 K0 D100 K80; "), but(100, 180));
    assert_eq!(small("FROM H0 K0 D135 K40; "), but(135, 175));
}
