//! What a word may be is told by few values, strides, and what guards say where they hold and where they do not.

use super::{counts, most, none, with_facts};
use common::audited::{asked, listed, table};
use scanbound::audit::{Request, follow};
use scanbound::base::facts::Facts;
use scanbound::passes::values::Trust;

/// What a loop changes grows to what the program compares it with, and is then taken closer.
#[test]
fn what_grows_in_a_loop_grows_to_where_a_guard_ends_it() {
    let moved = |guard: &str| {
        let text = format!(
            "LD SM400; MOV K0 D10; LD X0; CJ P0; LD SM400; LIMIT K1 K3000 D0 D1; FOR D1; LD SM400; INC D10; \
             {guard}; NEXT; P0; LD SM400; FMOV D0 D100 D10; END"
        );
        most(&text)
    };
    assert_eq!(moved("LD> D10 K50; MOV K0 D10"), 50);
    assert_eq!(moved("LD>= D10 K50; MOV K7 D10"), 49);
    assert_eq!(moved("LD= D10 K50; MOV K0 D10"), 49);
    assert_eq!(moved("LD SM400; AND> D10 K50; MOV K0 D10"), 50);
    assert_eq!(moved("LD> D10 K50; OUT M5; LD M5; MOV K0 D10"), 50);
    assert_eq!(moved("LD> D10 K50; OR< D10 K0; MOV K0 D10"), 50);
    assert_eq!(moved("LD<= D10 K50; INV; MOV K0 D10"), 50);
    // Where another contact is off too it goes on.
    assert_eq!(moved("LD> D10 K50; AND X1; MOV K0 D10"), 65_535);
    assert_eq!(moved("LD X1; AND> D10 K50; MOV K0 D10"), 65_535);
    // Only what was counted under the same contact is cleared under it.
    assert_eq!(moved("LD> D10 K50; OR X1; MOV K0 D10"), 50);
    // In steps of ten it is never 55, so that is no end, and 60 is one.
    let tens = |guard: &str| {
        let text = format!(
            "LD SM400; MOV K0 D10; LIMIT K1 K3000 D0 D1; FOR D1; LD SM400; + K10 D10; {guard}; NEXT; LD SM400; FMOV D0 D100 D10; END"
        );
        most(&text)
    };
    assert_eq!((tens("LD> D10 K55; MOV K0 D10"), tens("LD= D10 K60; MOV K0 D10")), (50, 50));
}

/// Where a jump is not taken, or a write does not happen, its guard does not hold.
#[test]
fn what_a_guard_denies_holds_where_it_does_not_act() {
    let moved = |rungs: &str| none(&format!("{rungs}; LD SM400; FMOV D0 D100 D50; END"));
    let all = 65_535;
    assert_eq!(moved("LD SM400; WAND K255 D0 D50; LD> D50 K20; MOV K5 D50"), 20);
    assert_eq!(moved("LD SM400; WAND K255 D0 D50; LD> D50 K20; AND X0; MOV K5 D50"), 255);
    assert_eq!(moved("LD SM400; WAND K255 D0 D50; LD X0; AND> D50 K20; MOV K5 D50"), 255);
    assert_eq!(moved("LD SM400; WAND K255 D0 D50; LD> D50 K20; OR X0; MOV K5 D50"), 20);
    assert_eq!(moved("LD SM400; WAND K255 D0 D50; LD> D50 K20; MOVP K5 D50"), 255);
    assert_eq!(moved("LD SM400; WAND K255 D0 D50; LD> D50 K20; MOV D1 D50"), all);
    // What is read under a contact is known there only.
    let under = "LD SM400; WAND K255 D0 D50; MOV K90 D51; LD X0; MOV K20 D51; LD X0; AND> D50 D51; MOV K5 D50";
    assert_eq!(moved(under), 255);
    let two = "LD SM400; WAND K255 D0 D50; WAND K255 D1 D51; LD X0; MOV K20 D51; LD X0; AND> D50 D51; MOV K5 D50; LD X0; AND X1; FMOV D0 D100 D50; END";
    assert_eq!(none(two), 20);
    // Another value of the word is not what was compared.
    assert_eq!(moved("LD SM400; WAND K255 D0 D50; LD> D50 K20; MOV K255 D50; MOV K5 D50"), 20);
    assert_eq!(
        moved(
            "LD SM400; WAND K255 D0 D50; LD> D50 K20; OUT M5; LD SM400; WAND K255 D1 D50; LD M5; MOV K5 D50"
        ),
        255
    );
    let jump = |guard: &str| {
        none(&format!(
            "LD SM400; WAND K255 D0 D50; {guard}; CJ P1; LD SM400; FMOV D0 D100 D50; P1; NOP; END"
        ))
    };
    assert_eq!(jump("LD> D50 K20"), 20);
    assert_eq!(jump("LD> D50 K20; AND X0"), 255);
    assert_eq!(jump("LD> D50 K20; OR X0"), 20);
    assert_eq!(jump("LD<= D50 K20"), 255);
    assert_eq!(jump("LD D1.0; AND> D50 K20; OUT M5; LD M5"), 255);
}

/// Numbers of two words are compared as one.
#[test]
fn guards_of_two_words_bound_both() {
    let moved = |guard: &str| none(&format!("LD X0; {guard}; FMOV K0 D100 D50; END"));
    assert_eq!(moved("ANDD>= D50 K0; ANDD<= D50 K25"), 25);
    assert_eq!(moved("ANDD= D50 K25"), 25);
    assert_eq!(moved("ANDD<= D50 K25"), 65_535);
    assert_eq!(moved("ANDD>= D50 K0; ANDD<= D50 K70000"), 65_535);
    assert_eq!(moved("ANDD>= D50 K70000; ANDD<= D50 K70005"), 4469);
    // One that is not 7 may have 7 as its lower word.
    let unequal = "LD SM400; WAND K7 D0 D50; LDD<> D50 K7; FMOV D0 D100 D50; END";
    assert_eq!(none(unequal), 7);
}

/// An index of a stride, or of a few values, reaches those cells and none between them.
#[test]
fn an_index_with_a_stride_spares_what_lies_between() {
    let turns = |index: &str, word: &str| {
        most(&format!(
            "LD SM400; {index}; MOV K19 {word}; LDI X1; BIN D9 D10Z0; LD SM400; MOV K0 D300; FMOV D0 D500 {word}; END"
        ))
    };
    let even = "WAND K31 D0 D1; * D1 K2 D2; MOV D2 Z0";
    assert_eq!((turns(even, "D50"), turns(even, "D51")), (65_535, 19));
    assert_eq!((turns(even, "D72"), turns(even, "D73")), (65_535, 19));
    assert_eq!((turns(even, "D10"), turns(even, "D74")), (65_535, 19));
    let either = "MOV K3 Z0; LD X2; MOV K40 Z0; LD SM400";
    assert_eq!((turns(either, "D50"), turns(either, "D30")), (65_535, 19));
    assert_eq!((turns(either, "D13"), turns(either, "D14")), (65_535, 19));
    let mask = "WAND K48 D0 Z0";
    assert_eq!((turns(mask, "D42"), turns(mask, "D41")), (65_535, 19));
    // Where another value comes in there is no stride.
    let odd = format!("{even}; LD X3; MOV K7 Z0; LD SM400");
    assert_eq!(turns(&odd, "D51"), 65_535);
    // A block as long as the stride matches no file.
    let block = |words: u32, word: &str| {
        most(&format!(
            "LD SM400; WAND K7 D0 D1; * D1 K10 Z0; MOV K19 {word}; BMOV W0 D100Z0 K{words}; MOV K0 D400; FMOV D0 D500 {word}; END"
        ))
    };
    assert_eq!((block(3, "D112"), block(3, "D113")), (65_535, 19));
    assert_eq!((block(10, "D113"), block(9, "D119")), (65_535, 19));
}

/// The most units that an instruction of an OMRON CJ handles.
fn of_omron(text: &str) -> u64 {
    let lines = listed(text.replace("; ", "\n") + "\n");
    let facts = Facts::default();
    let request =
        Request { dialect: Some("omron-cx"), cpu: Some("CJ2M"), ..Request::new(&lines, &facts) };
    let followed = follow(&request).unwrap_or_else(|why| panic!("{text}\n{why:?}"));
    let counted = followed.program.instructions.iter().filter_map(|one| one.counted());
    counted.map(|counted| counted.most).max().expect("something is counted")
}

/// Numbers below 0 go down where they are shifted to the right, and comparisons may be of unsigned words.
#[test]
fn signs_are_read_as_instructions_read_them() {
    // -3 becomes -2: 10 - -2 words are moved.
    let shifted = "LD P_On; MOV(021) #FFFD D0; NASR(581) D0 #8001; -(410) &10 D0 D1; XFER(070) D1 D100 D2000; END(001)";
    assert!(of_omron(shifted) >= 12, "{}", of_omron(shifted));
    // Where it is 3 it is followed.
    assert_eq!(of_omron(&shifted.replace("#FFFD", "#0003")), 9);
    let compared = |relation: &str| {
        of_omron(&format!("LD P_On; {relation} D50 &20; XFER(070) D50 D100 D2000; END(001)"))
    };
    assert_eq!((compared("AND>(320)"), compared("AND<=(315)")), (65_535, 20));
}

/// What the first scan starts with counts where later ones start from less.
#[test]
fn what_power_up_leaves_is_kept_where_a_range_is_taken_closer() {
    let text = "LD SM400; - K5000 D50 D60; FMOV D0 D100 D60; LD> D50 K4000; MOV K1 D50; LD SM400; INC D50; END";
    assert_eq!(counts(text), 5_000);
    // What is in words of the system or of a module at power-up nobody says.
    let later = |word: &str| {
        counts(&format!("FOR {word}; LD X0; Op1; NEXT; LD SM400; MOV K19 {word}; END"))
    };
    let all = ["D50", "SD1000", "SW50", "U0\\G50"].map(later);
    assert_eq!(all, [19, 32_767, 32_767, 32_767]);
}

/// Nor is what others than the program set: special units have their words in D20000 and on, input units theirs up to
/// 319.
#[test]
fn words_of_units_are_not_trusted() {
    let counted = |word: &str| {
        of_omron(&format!(
            "LD P_On; BCNT(067) {word} D100 W20; LD P_On; MOV(021) #0005 {word}; END(001)"
        ))
    };
    let all = ["D19999", "W10", "3000", "D20000", "10"].map(counted);
    assert_eq!(all, [5, 5, 5, 65_535, 65_535]);
}

/// A loop that is left after its first iteration leaves what that one wrote.
#[test]
fn what_a_first_iteration_leaves_is_not_forgotten() {
    let text = "LD SM400; MOV K0 D10; MOV K200 D11; LIMIT K1 K3000 D0 D1; FOR D1; LD SM400; MOV D11 D50; MOV K5 D11; \
        INC D10; LD> D10 K50; MOV K0 D10; NEXT; LD SM400; FMOV D0 D100 D50; END";
    assert_eq!(none(text), 200);
}

/// One value is unequal to another, and no more are.
#[test]
fn single_values_and_bits_are_no_more_than_that() {
    let unequal = "LD SM400; LIMIT K0 K6 D0 D50; LD<> D50 K5; FMOV D0 D100 D50; END";
    assert_eq!(none(unequal), 6);
    // Perhaps the bit is off, and 20 - 0 words are moved.
    let bit =
        "LD SM400; MOV K8 D50; LD X0; OUT D50.3; LD SM400; - K20 D50 D51; FMOV D0 D100 D51; END";
    assert_eq!(none(bit), 20);
    // A number of five digits is an error, which leaves what was there.
    let digits =
        |value: u32| none(&format!("LD SM400; MOV K{value} D1; BCD D1 D50; FMOV D0 D100 D50; END"));
    assert_eq!((digits(1_234), digits(12_000)), (0x1234, 65_535));
}

/// An index may be all that is stated of it.
#[test]
fn a_stated_index_reaches_to_its_ends() {
    let text = "LD SM400; MOV K19 D50; MOV D9 D40Z0; FOR D50; LD X0; Op1; NEXT; END";
    let stated = |most: u32| {
        let facts = format!("[index]\nZ0 = [0, {most}]\n");
        with_facts(Trust::None, &facts, text).map(|found| found.0)
    };
    assert_eq!((stated(9), stated(10)), (Ok(19), Ok(32_767)));
}

/// An interrupt comes at any moment: an index that it writes is none that is known, nor is a word that an index leads
/// to.
#[test]
fn what_interrupts_write_is_no_known_index_and_no_known_count() {
    let of = |main: &str, routine: &str| {
        let text = format!("LD SM400; {main}; FEND; I0; LD SM400; {routine}; IRET; END");
        let facts = "[interrupts]\nI0 = 1\n";
        with_facts(Trust::None, facts, &text).map(|found| found.0)
    };
    let led = "MOV K3 Z0; MOV K7 D103; MOV D100Z0 D50; FMOV K0 D200 D50";
    assert_eq!(of(led, "MOV K9 D104"), Ok(7));
    assert_eq!(of(led, "MOV K9 D103"), Ok(65_535));
    assert_eq!(of(led, "MOV K9 Z0"), Ok(65_535));
    let index = "MOV K3 Z0; MOV K19 D50; MOV D9 D40Z0; MOV K0 D300; FMOV K0 D200 D50";
    assert_eq!(of(index, "MOV K10 D9"), Ok(19));
    assert_eq!(of(index, "MOV K10 Z0"), Ok(65_535));
}

/// Counts and addresses are read with the signs that they have.
#[test]
fn large_counts_and_negative_indices_are_followed_as_they_are() {
    // 45,536 words from D30 on.
    let long = |count: &str| {
        most(&format!(
            "LD SM400; MOV K19 D3000; WAND K7 Z0; {count}; BMOV ZR0 D30Z0 D70; MOV K0 D300; FMOV D0 ZR0 D3000; END"
        ))
    };
    assert_eq!((long("MOV K100 D70"), long("MOV K-20000 D70")), (100, 65_535));
    // 99,997, not 65,536 more.
    let known = "LD SM400; MOV K-3 Z0; MOV K9 ZR99997; MOV K1 ZR165533; MOV ZR100000Z0 D50";
    let counted = ["ZR99997", "ZR165533", "D50"].map(|word| format!("FMOV K0 D200 {word}"));
    let stated = with_facts(
        Trust::None,
        "[index]\nbits = 16\n",
        &format!("{known}; {}; END", counted.join("; ")),
    );
    assert_eq!(stated.map(|found| found.0), Ok(9 + 1 + 9));
}

/// What is stated is kept where it holds at power-up, too.
#[test]
fn a_range_without_0_is_not_kept_from_power_up_on() {
    let kept = |range: &str| {
        let (inputs, table) = (listed("LD SM400\nMOV K7 D50\nEND\n"), table(""));
        let facts = format!("[ranges]\nD50 = {range}\n");
        let facts = Facts::parse("facts.toml", &facts).expect("facts");
        let followed = follow(&asked(&inputs, &table, &facts, Trust::None)).expect("a model");
        followed.program.proved_ranges.len()
    };
    assert_eq!([kept("[0, 7]"), kept("[1, 7]"), kept("[0, 6]"), kept("[0, 20]")], [1, 0, 0, 1]);
}

/// A contact is another one once its bit is written, and of more writes than are told apart none is forgotten.
#[test]
fn writes_under_contacts_are_told_apart_and_none_is_forgotten() {
    let moved =
        |rungs: &str| most(&format!("LD SM400; MOV K3 D50; {rungs}; FMOV K0 D100 D50; END"));
    assert_eq!(moved("LD M0; MOV K7 D50; LDI M0"), 3);
    assert_eq!(moved("LD M0; MOV K7 D50; LD X2; OUT M0; LDI M0"), 7);
    assert_eq!(moved("LD M0; MOV K7 D50; LD X2; OUT M0; LD M0"), 7);
    for count in 1..8 {
        let later: Vec<String> = (0..count).map(|n| format!("LD M{n}; MOV K{n} D50; ")).collect();
        let rungs = format!("LD M9; MOV K30 D50; {}LD X1", later.concat());
        assert_eq!(moved(&rungs), 30, "{count}");
    }
}

/// What was found of a value says nothing of what a module puts there, and a loop is bounded by its largest count.
#[test]
fn another_value_and_another_call_count_for_themselves() {
    let seen = |between: &str| {
        most(&format!(
            "LD> D50 K0; AND<= D50 K10; OUT M5; LD SM400; {between}; LD M5; FMOV K0 D100 D50; END"
        ))
    };
    assert_eq!((seen("FROM H0 K0 D51 K1"), seen("FROM H0 K0 D50 K1")), (10, 65_535));
    let called = |first: u32, second: u32| {
        none(&format!(
            "LD SM400; MOV K{first} D50; CALL P1; LD SM400; MOV K{second} D50; CALL P1; FEND; \
             P1; FOR D50; LD X0; Op1; NEXT; RET; END"
        ))
    };
    assert_eq!((called(5, 3), called(3, 5)), (8, 8));
}

/// Should the power fail while a latched word holds what a module delivered, the next scan starts from that.
#[test]
fn what_stands_in_a_word_for_a_moment_is_what_a_power_failure_leaves() {
    let left = |writes: &str| {
        counts(&format!(
            "FOR D50; LD X0; Op1; NEXT; FOR D51; LD X0; Op1; NEXT; LD SM400; {writes}; MOV K19 D50; MOV K19 D51; END"
        ))
    };
    assert_eq!(left("FROM H0 K0 D52 K1"), 19 + 19);
    assert_eq!(left("FROM H0 K0 D51 K1"), 19 + 32_767);
    assert_eq!(left("FROM H0 K0 D50 K1; FROM H0 K0 D50 K2"), 2 * 32_767);
}

/// A comparison holds where it holds of the numbers, whichever of some they are, and is denied where it does not.
#[test]
fn comparisons_hold_of_the_numbers_of_which_they_do() {
    type Holds = fn(&i32, &i32) -> bool;
    let relations: [(&str, Holds); 6] = [
        ("=", i32::eq),
        ("<>", i32::ne),
        ("<", i32::lt),
        ("<=", i32::le),
        (">", i32::gt),
        (">=", i32::ge),
    ];
    let (numbers, sets) = ([-2, 4, 5, 6], [[4, 4], [5, 5], [4, 6], [-2, 5]]);
    let counted = "LD SM400; WAND K7 D0 D60; FMOV K0 D100 D60; FMOV K0 D100 D50";
    for (relation, holds) in relations {
        for (with, some) in numbers.into_iter().flat_map(|with| sets.map(|some| (with, some))) {
            for (double, turned) in [(false, false), (false, true), (true, false)] {
                let (d, one) = if double { ("D", "DMOV") } else { ("", "MOV") };
                let sides = if turned { format!("K{with} D0") } else { format!("D0 K{with}") };
                let is_on = |&value: &i32| {
                    if turned { holds(&with, &value) } else { holds(&value, &with) }
                };
                let set = format!("LD SM400; {one} K{} D0; LD X0; {one} K{} D0", some[0], some[1]);
                let guard = format!("LD{d}{relation} {sides}");
                // Where it does not hold 90 words are moved, else 10; what D0 holds is counted, too.
                let denied =
                    format!("{set}; LD SM400; MOV K90 D50; {guard}; MOV K10 D50; {counted}; END");
                let expected = if some.iter().all(is_on) { 10 } else { 90 };
                let found = most(&denied);
                assert!(found >= expected, "{guard} of {some:?}: {found}");
                assert!(found == expected || double || some[0] != some[1], "{guard} of {some:?}");
                // As many as the number says where it holds.
                let held = format!("{set}; {guard}; AND>= D0 K0; FMOV K0 D100 D0; END");
                let moved = some.into_iter().filter(|value| is_on(value) && *value >= 0).max();
                let found = most(&held);
                assert!(
                    moved.is_none_or(|moved| found >= moved as u64),
                    "{guard} of {some:?}: {found}"
                );
            }
        }
    }
}

/// What instructions of arithmetic give, worked out here: the words with their numbers.
fn results(a: i16, b: i16) -> Vec<(u32, u16)> {
    let halves = |at: u32, value: i64| [(at, value as u16), (at + 1, (value >> 16) as u16)];
    let (x, y) = (i64::from(a), i64::from(b));
    let mut found = vec![(50, (x + y) as u16), (51, (x - y) as u16)];
    found.extend(halves(52, x * y));
    if y != 0 {
        found.extend([(54, (x / y) as u16), (55, (x % y) as u16)]);
    }
    found.extend([(56, (x & y) as u16), (57, (x | y) as u16), (58, (x ^ y) as u16)]);
    found.extend(halves(60, x + y));
    found.extend(halves(62, x - y));
    found.extend([(64, (-x) as u16), (66, (x as u16).count_ones() as u16)]);
    if (0..=9999).contains(&x) {
        found.push((65, (0..4).map(|n| (x / 10i64.pow(n) % 10) << (4 * n)).sum::<i64>() as u16));
    }
    found.push((67, x as u16));
    // What does not fit is an error, which leaves what was there.
    found.push((68, if i16::try_from(x + y).is_ok() { (x + y) as u16 } else { 77 }));
    found
}

/// Each word of a result counts as much as it is, whichever of two numbers it comes from.
#[test]
fn arithmetic_gives_every_word_of_its_result() {
    const WORKED: &str = "LD SM400; + D0 D1 D50; - D0 D1 D51; * D0 D1 D52; / D0 D1 D54; WAND D0 D1 D56; \
        WOR D0 D1 D57; WXOR D0 D1 D58; DBL D0 D10; DBL D1 D12; D+ D10 D12 D60; D- D10 D12 D62; MOV D0 D64; NEG D64; \
        BCD D0 D65; SUM D0 D66; WORD D10 D67; MOV K77 D68; WORD D60 D68";
    let numbers = [-32_768, -300, -1, 0, 1, 7, 300, 32_767];
    let counts: String = (50..69).map(|word| format!("; FMOV K0 D200 D{word}")).collect();
    let (mut all, mut exact) = (0, 0);
    for (a, b) in numbers.into_iter().flat_map(|a| numbers.map(|b| (a, b))) {
        for other in [a, numbers[2], numbers[6]] {
            let text = format!(
                "LD SM400; MOV K{a} D0; MOV K{b} D1; LD X0; MOV K{other} D0; {WORKED}{counts}; END"
            );
            let (inputs, table, facts) =
                (listed(text.replace("; ", "\n") + "\n"), table(""), Facts::default());
            let followed = follow(&asked(&inputs, &table, &facts, Trust::None)).expect("a model");
            let counted = followed.program.instructions.iter().filter_map(|one| one.counted());
            let most: Vec<u64> = counted.map(|counted| counted.most).collect();
            assert_eq!(most.len(), 19);
            for (word, value) in results(a, b).into_iter().chain(results(other, b)) {
                let (found, value) = (most[word as usize - 50], u64::from(value));
                assert!(found >= value, "{a} or {other}, {b}: D{word} is {value}, at most {found}");
                (all, exact) = (all + 1, exact + u32::from(found == value));
            }
        }
    }
    assert!(exact * 2 > all, "{exact} of {all}");
}
