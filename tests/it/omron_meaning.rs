//! What OMRON instructions really do, against a simulator that was written from the manuals apart: results, carry and
//! the flag of zero over random and odd values; what no manual settles is not known.

use common::real::{RealRun, real};

/// A source of numbers that is the same in every run.
struct Dice(u64);

impl Dice {
    fn next(&mut self) -> u64 {
        self.0 =
            self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        self.0 >> 33
    }

    /// A word, now and then one at an edge.
    fn word(&mut self) -> u16 {
        let odd = [0, 1, 9, 0x7FFF, 0x8000, 0xFFFF, 0x9999, 0x0A00, 0x1000];
        match self.next() % 3 {
            0 => odd[self.next() as usize % odd.len()],
            _ => self.next() as u16,
        }
    }

    /// A word of decimal digits.
    fn digits(&mut self) -> u16 {
        let number = [0, 1, 9999, self.next() % 10_000][self.next() as usize % 4];
        coded(number, 1)[0]
    }
}

/// What an instruction leaves: its words, and the carry where it says one.
type Left = Option<(Vec<u16>, Option<bool>)>;

/// A number of words, the least first.
fn number(words: &[u16]) -> u64 {
    words.iter().rev().fold(0, |number, &word| number * 65_536 + u64::from(word))
}

fn signed(words: &[u16]) -> i64 {
    match words {
        [word] => i64::from(*word as i16),
        _ => i64::from(number(words) as u32 as i32),
    }
}

fn split(number: u64, words: usize) -> Vec<u16> {
    (0..words).map(|n| (number >> (16 * n) & 0xFFFF) as u16).collect()
}

/// By the digits as they are written.
fn decimal(words: &[u16]) -> Option<u64> {
    let text: String = words.iter().rev().map(|word| format!("{word:04x}")).collect();
    text.parse().ok()
}

fn coded(number: u64, words: usize) -> Vec<u16> {
    let text = format!("{number:0width$}", width = 4 * words);
    let text = &text[text.len() - 4 * words..];
    let word = |n: usize| u16::from_str_radix(&text[4 * n..4 * n + 4], 16).expect("digits");
    (0..words).rev().map(word).collect()
}

fn bits(words: &[u16]) -> Vec<bool> {
    words.iter().flat_map(|word| (0..16).map(move |n| word & (1 << n) != 0)).collect()
}

fn packed(bits: &[bool]) -> Vec<u16> {
    bits.chunks(16)
        .map(|word| word.iter().zip(0..).map(|(&bit, n)| u16::from(bit) << n).sum())
        .collect()
}

fn turned(words: &[u16], left: bool, into: bool) -> (Vec<u16>, bool) {
    let mut all = bits(words);
    let out = if left { all.pop() } else { Some(all.remove(0)) };
    all.insert(if left { 0 } else { all.len() }, into);
    (packed(&all), out.expect("a bit"))
}

/// What the manuals say of an instruction on these operands: a in D0 and behind, b in D10, the result in D20 or, of
/// instructions with one operand, in D0.
fn simulated(name: &str, a: &[u16], b: &[u16], carry: bool) -> Left {
    let n = a.len();
    let (x, y, c) = (number(a), number(b), u64::from(carry));
    let plain = |words: Vec<u16>| Some((words, None));
    let all: u64 = 1 << (16 * n);
    let tens: u64 = 10_u64.pow(4 * n as u32);
    let sum = |value: u64, of: u64| (value % of, Some(value >= of));
    let rest = |x: u64, y: u64, of: u64| ((of + x - y) % of, Some(x < y));
    let decimal_of = |(value, carry): (u64, Option<bool>)| Some((coded(value, n), carry));
    let binary_of = |(value, carry): (u64, Option<bool>)| Some((split(value, n), carry));
    match name {
        "BCD" | "BCDL" => (x < tens).then(|| (coded(x, n), None)),
        "BIN" | "BINL" => plain(split(decimal(a)?, n)),
        "NEG" | "NEGL" => plain(split(all - x, n)),
        "SIGN" => plain(split(signed(a) as u64, 2)),
        "ROL" | "ROR" | "ROLL" | "RORL" => {
            let (words, out) = turned(a, name.starts_with("ROL"), carry);
            Some((words, Some(out)))
        }
        "RLNC" | "RRNC" | "RLNL" | "RRNL" => {
            let left = name.starts_with("RL");
            let round = if left { x >= all / 2 } else { x % 2 == 1 };
            let (words, out) = turned(a, left, round);
            Some((words, Some(out)))
        }
        "ASL" | "ASR" | "ASLL" | "ASRL" => {
            let (words, out) = turned(a, name.starts_with("ASL"), false);
            Some((words, Some(out)))
        }
        "+" | "+L" => binary_of(sum(x + y, all)),
        "-" | "-L" => binary_of(rest(x, y, all)),
        "+C" | "+CL" => binary_of(sum(x + y + c, all)),
        "-C" | "-CL" => binary_of(rest(x, y + c, all)),
        "+B" | "+BL" => decimal_of(sum(decimal(a)? + decimal(b)?, tens)),
        "-B" | "-BL" => decimal_of(rest(decimal(a)?, decimal(b)?, tens)),
        "+BC" | "+BCL" => decimal_of(sum(decimal(a)? + decimal(b)? + c, tens)),
        "-BC" | "-BCL" => decimal_of(rest(decimal(a)?, decimal(b)? + c, tens)),
        "++B" => plain(coded((decimal(a)? + 1) % tens, n)),
        "--B" => plain(coded((tens + decimal(a)? - 1) % tens, n)),
        "*U" | "*UL" => plain(split(u128_low(u128::from(x) * u128::from(y)), 2 * n)),
        "*" | "*L" => plain(split((signed(a) * signed(b)) as u64, 2 * n)),
        "*B" | "*BL" => plain(coded(decimal(a)? * decimal(b)?, 2 * n)),
        "/U" | "/UL" => (y != 0).then(|| ([split(x / y, n), split(x % y, n)].concat(), None)),
        "/" | "/L" => {
            let (x, y) = (signed(a), signed(b));
            let beyond = y == 0 || (y == -1 && x == -(all as i64 / 2));
            let both = || [split((x / y) as u64, n), split((x % y) as u64, n)].concat();
            (!beyond).then(|| (both(), None))
        }
        "/B" | "/BL" => {
            let (x, y) = (decimal(a)?, decimal(b)?);
            (y != 0).then(|| ([coded(x / y, n), coded(x % y, n)].concat(), None))
        }
        other => panic!("{other}"),
    }
}

fn u128_low(value: u128) -> u64 {
    value as u64
}

/// Runs the instruction and asks for each word that it leaves, for the carry, and for the flag of zero.
fn check(name: &str, places: &str, at: u32, a: &[u16], b: &[u16], carry: bool) {
    let expected = simulated(name, a, b, carry);
    let mut start: Vec<(String, u16)> = vec![("CF4".to_owned(), u16::from(carry))];
    start.extend(a.iter().zip(0..).map(|(&word, n)| (format!("D{n}"), word)));
    start.extend(b.iter().zip(10..).map(|(&word, n)| (format!("D{n}"), word)));
    let start: Vec<(&str, u16)> = start.iter().map(|(name, word)| (name.as_str(), *word)).collect();
    let head = format!("LD P_On\n{name} {places}");
    let Some((words, carried)) = expected else {
        let text = format!("{head}\nLD=(300) D{at} #1\nJMP(004) #1\nSwOp0\nJME(005) #1");
        assert!(real("omron-cx", &text, &start).stopped.is_some(), "{text} {start:?}");
        return;
    };
    let mut tests = Vec::new();
    // No manual says whether a decimal remainder counts.
    let is_told = !name.starts_with("/B");
    if let Some(carried) = carried {
        tests.push((if carried { "LD W0.01" } else { "LDNOT W0.01" }).to_owned());
    }
    let told = if name.starts_with('/') { &words[..words.len() / 2] } else { &words[..] };
    let zero = told.iter().all(|&word| word == 0);
    if is_told {
        tests.insert(0, (if zero { "LD W0.00" } else { "LDNOT W0.00" }).to_owned());
    }
    let hits = tests.len() + words.len();
    tests.extend(words.iter().zip(at..).map(|(word, n)| format!("LD=(300) D{n} #{word:04X}")));
    let asked: String = tests.iter().map(|test| format!("\n{test}\nSwOp0")).collect();
    // What is asked changes the flags: they are kept.
    let text = head + "\nLD P_EQ\nOUT W0.00\nLD P_CY\nOUT W0.01" + &asked;
    let RealRun { fired, stopped } = real("omron-cx", &text, &start);
    assert_eq!(stopped, None, "{text} {start:?}");
    let done = fired.iter().filter(|(text, fired)| text.starts_with("SwOp0") && *fired).count();
    assert_eq!(done, hits, "{text} {start:?}");
}

#[test]
fn every_result_is_the_simulators() {
    let mut dice = Dice(3);
    for round in 0..40 {
        for name in [
            "BCD", "BIN", "NEG", "SIGN", "ROL", "ROR", "RLNC", "RRNC", "ASL", "ASR", "+", "-",
            "+C", "-C", "+B", "-B", "+BC", "-BC", "++B", "--B", "*U", "*", "*B", "/U", "/", "/B",
            "BCDL", "BINL", "NEGL", "ROLL", "RORL", "RLNL", "RRNL", "ASLL", "ASRL", "+L", "-L",
            "+CL", "-CL", "+BL", "-BL", "+BCL", "-BCL", "*UL", "*L", "*BL", "/UL", "/L", "/BL",
        ] {
            let wide = if name.ends_with('L') && !matches!(name, "ROL" | "ASL") { 2 } else { 1 };
            // Decimal digits most of the time, where they are asked for.
            let coded = (name.contains('B') && name != "BCD" && name != "BCDL") && round % 4 > 0;
            let mut word = || if coded { dice.digits() } else { dice.word() };
            let (mut a, b): (Vec<u16>, Vec<u16>) =
                ((0..wide).map(|_| word()).collect(), (0..wide).map(|_| word()).collect());
            if name == "BCDL" && round % 2 == 0 {
                a[1] &= 0x01FF;
            }
            let own =
                ["RO", "RL", "RR", "AS", "++", "--"].iter().any(|begin| name.starts_with(begin));
            let to = ["BCD", "BIN", "NEG", "SIGN", "BCDL", "BINL", "NEGL"].contains(&name);
            let (places, at) = match (own, to) {
                (true, _) => ("D0", 0),
                (_, true) => ("D0 D20", 20),
                _ => ("D0 D10 D20", 20),
            };
            check(name, places, at, &a, &b, round % 3 == 0);
        }
    }
}

/// Whether a test holds behind some lines, and nothing on the way was unknown.
fn holds(dialect: &str, lines: &[&str], start: &[(&str, u16)], test: &str) -> bool {
    let text = [lines, &[test, "SwOp0"]].concat().join("\n");
    let RealRun { fired, stopped } = real(dialect, &text, start);
    assert_eq!(stopped, None, "{text}");
    fired.last().is_some_and(|(text, fired)| text.starts_with("SwOp0") && *fired)
}

#[test]
fn words_and_digits_are_moved() {
    let cx = |line: &str, start: &[(&str, u16)], test: &str| {
        holds("omron-cx", &["LD P_On", line], start, test)
    };
    // Overlapping areas: all is read before anything is written.
    let three = [("D0", 1), ("D1", 2), ("D2", 3)];
    assert!(cx("XFER(070) &3 D0 D1", &three, "LD=(300) D3 #3"));
    assert!(cx("XFER(070) &3 D0 D1", &three, "LD=(300) D1 #1"));
    assert!(cx("MOVD(083) D0 #0210 D1", &[("D0", 0x1234), ("D1", 0xABCD)], "LD=(300) D1 #34CD"));
    assert!(cx("MOVD(083) D0 #0013 D1", &[("D0", 0x1234), ("D1", 0xABCD)], "LD=(300) D1 #AB41"));
    assert!(cx("SLD(074) D0 D1", &[("D0", 0x1234), ("D1", 0xABCD)], "LD=(300) D1 #BCD1"));
    assert!(cx("SRD(075) D0 D1", &[("D0", 0x1234), ("D1", 0xABCD)], "LD=(300) D0 #D123"));
    assert!(cx("BCNT(067) &2 D0 D5", &[("D0", 0xF0F0), ("D1", 1)], "LD=(300) D5 &9"));
    assert!(cx("COLL(081) D0 D9 D5", &[("D9", 2), ("D2", 77)], "LD=(300) D5 &77"));
    assert!(cx("DIST(080) #0042 D0 D9", &[("D9", 3)], "LD=(300) D3 #42"));
    assert!(cx("MLPX(076) D0 #0000 D5", &[("D0", 0x123A), ("D5", 1)], "LD=(300) D5 #0400"));
}

#[test]
fn decimal_arithmetic_of_the_c_series_takes_the_carry_along() {
    let c = |line: &str, start: &[(&str, u16)], test: &[&str]| {
        let lines = [
            &["LD 25313", "CLC(41)", "LD 25313", line],
            test,
            &["LD 25313", "CMP(20) DM 0020 DM 0030"],
        ];
        holds("omron-c200h", &lines.concat(), start, "LD 25506")
    };
    let sum = [("DM0", 0x9999), ("DM10", 0x0002), ("DM30", 0x0001)];
    assert!(c("ADD(30) DM 0000 DM 0010 DM 0020", &sum, &[]));
    let lines = [
        "LD 25313",
        "STC(40)",
        "LD 25313",
        "ADD(30) DM 0000 DM 0010 DM 0020",
        "LD 25313",
        "CMP(20) DM 0020 DM 0030",
    ];
    assert!(holds("omron-c200h", &lines, &[sum[0], sum[1], ("DM30", 2)], "LD 25506"));
    let rest = [("DM0", 0x0001), ("DM10", 0x0002), ("DM30", 0x9999)];
    assert!(c("SUB(31) DM 0000 DM 0010 DM 0020", &rest, &[]));
    assert!(c(
        "MUL(32) DM 0000 DM 0010 DM 0020",
        &[("DM0", 0x9999), ("DM10", 3), ("DM30", 0x9997)],
        &[]
    ));
    assert!(c(
        "DIV(33) DM 0000 DM 0010 DM 0020",
        &[("DM0", 0x0100), ("DM10", 7), ("DM30", 0x0014)],
        &[]
    ));
    assert!(c("INC(38) DM 0020", &[("DM20", 0x0999), ("DM30", 0x1000)], &[]));
    assert!(c("DEC(39) DM 0020", &[("DM20", 0), ("DM30", 0x9999)], &[]));
}

#[test]
fn what_an_instruction_saw_is_the_outsides_only_in_its_first_run() {
    let stops =
        |lines: &[&str]| real("omron-cx", &lines.join("\n"), &[("W0", 1)]).stopped.is_some();
    let once = ["LD P_On", "@SwOp0", "LD P_On", "JMP(004) #1", "JME(005) #1"];
    assert!(!stops(&once));
    let edge = ["LD W0.00", "DIFU(013) W0.01", "LD W0.01", "JMP(004) #1", "SwOp0", "JME(005) #1"];
    assert!(!stops(&edge));
    assert!(stops(&[&["FOR(512) &2"], &edge[..], &["NEXT(513)"]].concat()));
    let called = |calls: usize| {
        let call = ["LD P_On", "SBS(091) 1"].repeat(calls);
        [&call[..], &["END", "SBN(092) 1"], &edge[..], &["RET(093)"]].concat()
    };
    assert_eq!((stops(&called(1)), stops(&called(2))), (false, true));
}

#[test]
fn a_timer_of_no_time_or_of_wrong_digits_is_not_the_outsides() {
    let stops = |line: &str, setting: u16| {
        let text = format!("LD P_On\n{line}\nLD T0000\nJMP(004) #1\nSwOp0\nJME(005) #1");
        real("omron-cx", &text, &[("D0", setting)]).stopped.is_some()
    };
    assert!(stops("TIM 0000 #0", 0));
    assert!(!stops("TIM 0000 #10", 0));
    assert!(stops("TIM 0000 D0", 0));
    assert!(!stops("TIM 0000 D0", 0x10));
    assert!(stops("TIM 0000 D0", 0x1A));
    assert!(!stops("TIMX(550) 0000 D0", 0x1A));
}

#[test]
fn numbers_are_shifted_by_places_and_held_to_limits() {
    let cx = |line: &str, start: &[(&str, u16)], test: &str| {
        holds("omron-cx", &["LD P_On", line], start, test)
    };
    assert!(cx("NASL(580) D0 #0004", &[("D0", 0x9234)], "LD=(300) D0 #2340"));
    assert!(cx("NASL(580) D0 #0004", &[("D0", 0x9234)], "LD P_CY"));
    assert!(cx("NASL(580) D0 #0010", &[("D0", 0x9234)], "LD P_EQ"));
    assert!(cx("NASR(581) D0 #8004", &[("D0", 0x9234)], "LD=(300) D0 #F923"));
    assert!(cx("NASR(581) D0 #8004", &[("D0", 0x9234)], "LD P_N"));
    assert!(cx("NASR(581) D0 #0003", &[("D0", 0x9234)], "LD P_CY"));
    let two = [("D0", 0x5678), ("D1", 0x1234)];
    assert!(cx("NSLL(582) D0 #0008", &two, "LD=L(301) D0 #34567800"));
    assert!(cx("NSRL(583) D0 #0010", &two, "LD=L(301) D0 #1234"));
    let limits = |value| [("D0", value), ("D10", 0xFFF0), ("D11", 5)];
    assert!(cx("LMT(680) D0 D10 D5", &limits(0xFF00), "LD=(300) D5 #FFF0"));
    assert!(cx("LMT(680) D0 D10 D5", &limits(9), "LD=(300) D5 #5"));
    assert!(cx("BAND(681) D0 D10 D5", &limits(9), "LD=(300) D5 #4"));
    assert!(cx("ZONE(682) D0 D10 D5", &limits(9), "LD=(300) D5 #E"));
    assert!(cx("ZONE(682) D0 D10 D5", &limits(0), "LD P_EQ"));
    let stops = |line: &str| {
        let text = format!("LD P_On\n{line}\nLD=(300) D5 #1\nJMP(004) #1\nSwOp0\nJME(005) #1");
        real("omron-cx", &text, &[("D10", 7), ("D11", 5)]).stopped.is_some()
    };
    // The limits in the wrong order are an error.
    assert!(stops("LMT(680) D0 D10 D5"));
    assert!(stops("BAND(681) D0 D10 D5"));
    assert!(stops("ZONE(682) D0 D10 D5"));
    assert!(stops("NASL(580) D5 #0011"));
    assert!(stops("NASL(580) D5 #8004"));
}
