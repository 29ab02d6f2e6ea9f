//! What MELSEC instructions really do: the interpreter's results against those of a PLC made from the manuals alone,
//! and where no manual settles them, that it says so.

use common::melsec::decoded;
use common::plc::{Device, Line, Luck, Plc, line};
use scanbound::base::facts::Facts;
use scanbound::base::time::{Picos, Times};
use scanbound::front::melsec::memory::Family;
use scanbound::program::{AreaKind, Cell, ChoiceKey, Program};
use scanbound::replay::{FreeValues, RealRun, real};
use std::collections::BTreeMap;

/// Start values by device name; the rest is 0.
type Start = BTreeMap<String, u16>;

struct At<'a> {
    program: &'a Program,
    start: &'a Start,
}

impl FreeValues for At<'_> {
    fn start(&mut self, cell: Cell, _kind: AreaKind) -> u16 {
        self.start.get(&self.program.cell_name(cell)).copied().unwrap_or(0)
    }

    fn choice(&mut self, _key: &ChoiceKey, _kind: AreaKind) -> u16 {
        0
    }
}

/// Runs a list really, in which every `Op1` costs one picosecond.
fn run(family: Family, text: &str, start: &Start) -> RealRun {
    let program = decoded(family, &[("MAIN", text)], &Facts::default());
    let program = program.unwrap_or_else(|faults| panic!("{text}\n{faults}"));
    let price = |text: &str| Picos(u64::from(text == "Op1"));
    let times: Vec<_> =
        program.instructions.iter().map(|i| Times::new(price(&i.text), Picos::ZERO)).collect();
    real(&program, &times, || At { program: &program, start }, 100_000)
}

struct Given<'a>(&'a Start);

impl Luck for Given<'_> {
    fn value(&mut self, (area, number): Device) -> u16 {
        self.0.get(&format!("{area}{number}")).copied().unwrap_or(0)
    }

    fn below(&mut self, _n: u32) -> u32 {
        0
    }
}

/// What the PLC of the manuals leaves, as contacts that are all on, each with its `Op1`.
fn checks(instruction: &str, start: &Start) -> Vec<String> {
    let lines: Vec<Line> = ["LD SM400", instruction, "END"].into_iter().map(line).collect();
    let files = [lines];
    let mut left = Plc::new(&files, Given(start), Vec::new()).left();
    for name in start.keys() {
        let letters = name.trim_end_matches(|c: char| c.is_ascii_digit());
        let area = ["D", "M", "Z"].into_iter().find(|area| *area == letters).expect("an area");
        let number = name[letters.len()..].parse().expect("a number");
        left.entry((area, number)).or_insert(start[name]);
    }
    left.into_iter()
        .filter(|((area, _), _)| ["D", "M", "Z"].contains(area))
        .map(|((area, number), value)| match (area, value) {
            ("M", 0) => format!("LDI M{number}; Op1; "),
            ("M", _) => format!("LD M{number}; Op1; "),
            _ => format!("LD= {area}{number} K{}; Op1; ", value as i16),
        })
        .collect()
}

/// The interpreter leaves what the PLC of the manuals leaves.
fn agree(family: Family, instruction: &str, start: &Start) {
    let checks = checks(instruction, start);
    let on = if family == Family::Fx { "M8000" } else { "SM400" };
    let text = format!("LD {on}; {instruction}; {}END", checks.concat());
    let found = run(family, &text, start);
    let told = || format!("{family:?} {text}\nfrom {start:?}");
    assert!(found.undeclared_writes.is_empty(), "{}: {:?}", told(), found.undeclared_writes);
    assert_eq!(found.stopped, None, "{}", told());
    assert_eq!(found.replay.total.0, checks.len() as u64, "{}", told());
}

/// Of what the instruction leaves in `asked` nothing is known.
fn is_open(family: Family, instruction: &str, asked: &str, start: &[(&str, u16)]) {
    let start = start.iter().map(|(name, value)| ((*name).to_owned(), *value)).collect();
    let on = if family == Family::Fx { "M8000" } else { "SM400" };
    let text = format!("LD {on}; {instruction}; LD {asked}; CJ P0; LD {on}; OUT Y0; P0; END");
    let found = run(family, &text, &start);
    assert!(found.stopped.is_some(), "{family:?} {text} {start:?}");
}

/// Numbers by chance, many of them at the limits.
struct Dice(u64);

impl Dice {
    fn draw(&mut self) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        self.0 >> 11
    }

    fn word(&mut self) -> u16 {
        let edges = [0, 1, 2, 3, 7, 15, 16, 0x7FFF, 0x8000, 0xFFFF, 0x00FF, 0xFF00];
        match self.draw() % 3 {
            0 => self.draw() as u16,
            _ => edges[self.draw() as usize % edges.len()],
        }
    }
}

/// Eight starts of D0 to D29, Z0, Z1 and M0 to M39.
fn starts(mut word: impl FnMut(&mut Dice, u32) -> u16) -> Vec<Start> {
    let mut dice = Dice(0x9E37_79B9_7F4A_7C15);
    (0..8)
        .map(|_| {
            let words = (0..30).map(|n| (format!("D{n}"), word(&mut dice, n)));
            let words: Start = words.collect();
            let bits = (0..40).map(|n| (format!("M{n}"), (dice.draw() & 1) as u16));
            words.into_iter().chain(bits).collect()
        })
        .collect()
}

fn agree_on(families: &[Family], instructions: &[&str], starts: &[Start]) {
    for (n, family) in families.iter().enumerate() {
        for instruction in instructions {
            // One family tries them all.
            for start in &starts[..if n == 0 { starts.len() } else { 2 }] {
                agree(*family, instruction, start);
            }
        }
    }
}

const LARGE: [Family; 3] = [Family::Q, Family::L, Family::Iqr];
const ALL: [Family; 5] = [Family::Q, Family::L, Family::Iqr, Family::Fx, Family::Fx5];

#[test]
fn bits_of_words() {
    let any = starts(|dice, _| dice.word());
    agree_on(
        &LARGE,
        &[
            "SWAP D0",
            "SUM D0 D10",
            "SUM K4M0 D10",
            "SUM D0 K2M0",
            "ROL D0 K0",
            "ROL D0 K1",
            "ROR D0 K15",
            "DROL D0 K1",
            "DROR D0 K31",
            "SFL D0 K1",
            "SFR D0 K15",
            "SFL D0 K0",
            "TEST D0 K3 M5",
            "TEST D0 K15 M5",
            "DTEST D0 K31 M5",
            "DTEST D0 K0 M5",
            "BSET D0 K3",
            "MOVP D0 D1",
            "DBL D0 D10",
            "DBL K-5 D10",
            "DIS D0 D10 K4",
            "DIS D0 D10 K1",
            "UNI D0 D10 K4",
            "UNI D0 D10 K2",
            "WTOB D0 D10 K5",
            "WTOB D0 D10 K4",
            "BTOW D0 D10 K6",
            "DECO D0 M0 K3",
            "DECO D0 M0 K5",
            "DECO K7 M0 K3",
        ],
        &any,
    );
    let some: Vec<Start> =
        any.into_iter().filter(|start| (8..16).any(|n| start[&format!("M{n}")] == 1)).collect();
    agree_on(&LARGE, &["ENCO M8 D0 K3"], &some);
    let in_words = ["TEST D0 D1 M5", "DTEST D0 D2 M5", "BSET D0 D1", "BRST D0 D1"];
    agree_on(&[Family::Q, Family::L], &in_words, &some);
    agree_on(&[Family::Fx, Family::Fx5], &["SWAP D0", "SUM D0 D10", "ROL D0 K1"], &some);
}

#[test]
fn numbers_and_their_digits() {
    let any = starts(|dice, _| dice.word());
    agree_on(&LARGE, &["* D0 D1 D10", "* K-3 D0 D10", "D* D0 D2 D10", "D* D0 K7 D10"], &any);
    let divided =
        starts(|dice, n| if n == 1 || n == 2 { 1 + (dice.draw() % 9) as u16 } else { dice.word() });
    agree_on(&LARGE, &["/ D0 D1 D10", "/ D0 K-7 D10", "D/ D4 D2 D10", "D/ D4 K1000 D10"], &divided);
    let small = starts(|dice, n| {
        if n % 2 == 0 { (dice.draw() % 10_000) as u16 } else { (dice.draw() % 1000) as u16 }
    });
    agree_on(&ALL, &["BCD D0 D10", "DBCD D0 D10", "BCD D0 K4M0", "MOV D0 D10"], &small);
    agree_on(&LARGE, &["BKBCD D0 D10 K4"], &small);
    let coded = starts(|dice, _| (0..4).fold(0, |word, _| word << 4 | (dice.draw() % 10) as u16));
    agree_on(&ALL, &["BIN D0 D10", "DBIN D0 D10"], &coded);
    agree_on(&LARGE, &["BKBIN D0 D10 K4"], &coded);
    let limits = starts(|dice, n| match n {
        0 => (dice.draw() % 100) as u16,
        1 => 0,
        2 => 100 + (dice.draw() % 100) as u16,
        3 => 0,
        _ => dice.word() >> 2,
    });
    agree_on(
        &LARGE,
        &["LIMIT D0 D2 D6 D10", "DLIMIT D0 D2 D6 D10", "LIMIT K-9 K9 D6 D10"],
        &limits,
    );
    agree_on(
        &LARGE,
        &["BAND D0 D2 D6 D10", "DBAND D0 D2 D6 D10", "ZONE D0 D2 D6 D10", "DZONE D0 D2 D6 D10"],
        &limits,
    );
}

#[test]
fn blocks() {
    let any = starts(|dice, _| dice.word());
    agree_on(
        &LARGE,
        &[
            "BK+ D0 D5 D10 K5",
            "BK- D0 D5 D10 K5",
            "BK+ D0 K3 D10 K5",
            "BKAND D0 D5 D10 K3",
            "BKOR D0 D5 D10 K3",
            "BKXOR D0 D5 D10 K3",
            "BKXNR D0 D5 D10 K3",
            "BK+ D0 D5 D0 K5",
            "BKCMP= D0 D5 M0 K5",
            "BKCMP<> D0 D5 M0 K5",
            "BKCMP< D0 D5 M0 K5",
            "BKCMP<= D0 D5 M0 K5",
            "BKCMP> D0 D5 M0 K5",
            "BKCMP>= D0 D5 M0 K5",
            "BKCMP= K3 D5 M0 K5",
            "BXCH D0 D10 K4",
            "DSFL D0 K5",
            "DSFR D0 K5",
            "BSFL M3 K7",
            "BSFR M3 K7",
            "BKRST M0 K9",
            "BMOV D0 D10 K5",
            "FMOV D0 D10 K5",
            "DFMOV D0 D10 K3",
            "BMOV D0 D2 K5",
            "BMOV D2 D0 K5",
        ],
        &any,
    );
    let counted =
        starts(|dice, n| if n == 29 { 1 + (dice.draw() % 6) as u16 } else { dice.word() });
    agree_on(&LARGE, &["BMOV D0 D10 D29", "FMOV D0 D10 D29", "FMOV K7 D10 D29"], &counted);
    let table = starts(|dice, n| if n == 10 { (dice.draw() % 6) as u16 } else { dice.word() });
    agree_on(&LARGE, &["FIFW D0 D10", "FIFW K-3 D10"], &table);
}

#[test]
fn searches_and_sums() {
    let few =
        starts(|dice, _| (dice.draw() % 4) as u16 ^ if dice.draw() % 2 == 0 { 0xFFFF } else { 0 });
    agree_on(
        &LARGE,
        &[
            "MAX D0 D10 K8",
            "MIN D0 D10 K8",
            "DMAX D0 D20 K5",
            "DMIN D0 D20 K5",
            "WSUM D0 D10 K8",
            "DWSUM D0 D20 K5",
        ],
        &few,
    );
    let search = ["SER D0 D1 D10 K8", "SER K2 D1 D10 K8", "DSER D0 D2 D20 K5"];
    agree_on(&[Family::Q, Family::L], &search, &few);
    let even = starts(|dice, _| 8 * (dice.draw() % 100) as u16);
    agree_on(&LARGE, &["MEAN D0 D10 K8", "MEAN D0 D10 K1"], &even);
}

#[test]
fn places_by_index_registers() {
    let start = |z0: i16, z1: i16| {
        let words = (0..30).map(|n| (format!("D{n}"), 100 + n));
        let index = [("Z0".to_owned(), z0 as u16), ("Z1".to_owned(), z1 as u16)];
        words.chain(index).chain([("M7".to_owned(), 1)]).collect::<Start>()
    };
    let starts = [start(0, 0), start(3, 5), start(-2, 7), start(9, -3)];
    agree_on(
        &LARGE,
        &[
            "MOV D5Z0 D20",
            "MOV D4 D5Z0",
            "MOV D5Z0 D10Z1",
            "DMOV D5Z0 D10Z1",
            "MOV K4M10Z0 D20",
            "MOV K2M10Z0 D20",
            "DMOV K6M10Z0 D20",
            "MOV D4 K4M10Z0",
            "MOV D4 K1M10Z0",
            "DMOV D4 K7M4Z0",
            "BMOV D5Z0 D20 K3",
            "BMOV D0 D10Z1 K3",
            "INC D5Z0",
            "+ D4 D5Z0",
        ],
        &starts,
    );
}

#[test]
fn reals_that_are_exact() {
    let whole = starts(|dice, n| {
        let value = f32::to_bits((dice.draw() % 2001) as f32 - 1000.0);
        if n % 2 == 0 { value as u16 } else { 0 }
    });
    let whole: Vec<Start> = whole
        .into_iter()
        .enumerate()
        .map(|(k, mut start)| {
            for n in 0..8u32 {
                let value = ((k as u32 * 7919 + n * 104_729) % 2001) as f32 - 1000.0;
                let value = if n == 1 { 0.5 + k as f32 } else { value };
                let bits = value.to_bits();
                start.insert(format!("D{}", 2 * n), bits as u16);
                start.insert(format!("D{}", 2 * n + 1), (bits >> 16) as u16);
            }
            start
        })
        .collect();
    agree_on(
        &LARGE,
        &["E+ D0 D4 D20", "E- D0 D4 D20", "E* D0 D4 D20", "DINT D4 D20", "INT D4 D20"],
        &whole,
    );
    let halves: Vec<Start> = whole
        .iter()
        .cloned()
        .map(|mut start| {
            start.insert("D6".to_owned(), 0);
            start.insert("D7".to_owned(), (8f32.to_bits() >> 16) as u16);
            start
        })
        .collect();
    agree_on(&LARGE, &["E/ D0 D6 D20"], &halves);
    let any = starts(|dice, _| dice.word());
    agree_on(&ALL, &["FLT D0 D10"], &any);
    let clock = starts(|dice, n| (dice.draw() % if n == 0 { 24 } else { 60 }) as u16);
    agree_on(&LARGE, &["SECOND D0 D10"], &clock);
    let seconds = starts(|dice, n| if n == 0 { dice.word() } else { 0 });
    agree_on(&LARGE, &["HOUR D0 D10"], &seconds);
}

#[test]
fn what_no_manual_settles_is_not_known() {
    let q = Family::Q;
    for (instruction, asked, start) in [
        ("/ D0 D1 D10", "D10.0", &[("D0", 7)][..]),
        ("/ D0 D1 D10", "D10.0", &[("D0", 0x8000), ("D1", 0xFFFF)]),
        ("BCD D0 D10", "D10.0", &[("D0", 10_000)]),
        ("BCD D0 D10", "D10.0", &[("D0", 0xFFFF)]),
        ("BIN D0 D10", "D10.0", &[("D0", 0x00A0)]),
        ("LIMIT D0 D1 D2 D10", "D10.0", &[("D0", 5), ("D1", 4)]),
        ("BAND K-32768 K-1 D2 D10", "D10.0", &[("D2", 0x7FFF)]),
        ("ZONE K-5 K5 D2 D10", "D10.0", &[("D2", 0x7FFF)]),
        ("ENCO M0 D10 K3", "D10.0", &[]),
        ("DECO D0 M0 K0", "M0", &[]),
        ("ROL D0 K17", "D0.0", &[]),
        ("SFL D0 D1", "D0.0", &[("D1", 16)]),
        ("RCL D0 K1", "D0.0", &[("D0", 2)]),
        ("BMOV D0 D10 D29", "D10.0", &[("D29", 0xFFFF)]),
        ("FMOV D0 D10 D29", "D10.0", &[("D29", 0xFFFF)]),
        ("MEAN D0 D10 K2", "D10.0", &[("D0", 1)]),
        ("BK+ D0 D5 D1 K5", "D2.0", &[]),
        ("MOV D0Z0 D10", "D10.0", &[("Z0", 0xFFFF)]),
        ("MOV D5 D0Z0", "D10.0", &[("Z0", 0xFFFF)]),
        ("MOV D0Z0 D10", "D10.0", &[("Z0", 0x7FFF)]),
        // 0.1 and 0.2, whose sum is rounded.
        (
            "E+ D0 D2 D10",
            "D10.0",
            &[("D0", 0xCCCD), ("D1", 0x3DCC), ("D2", 0xCCCD), ("D3", 0x3E4C)],
        ),
        ("E/ D0 D2 D10", "D10.0", &[("D1", 0x3F80), ("D2", 0), ("D3", 0x4040)]),
        ("E/ D0 D2 D10", "D10.0", &[("D1", 0x3F80)]),
        ("INT D0 D10", "D10.0", &[("D0", 0), ("D1", 0x3F00)]),
        ("SECOND D0 D10", "D10.0", &[("D0", 24)]),
        ("HOUR D0 D10", "D10.0", &[("D1", 0xFFFF)]),
        ("WORD D0 D10", "D10.0", &[("D1", 1)]),
    ] {
        is_open(q, instruction, asked, start);
    }
    is_open(q, "MAX D0 D1 K3", "D1.0", &[]);
    is_open(q, "MIN D5 D7 D4", "D7.0", &[("D4", 3)]);
    is_open(q, "SER D0 D1 D2 K3", "D2.0", &[]);
    is_open(q, "SER D0 D5Z0 D2 K3", "D2.0", &[("Z0", 0xFFFD)]);
    is_open(q, "BTOW D0 D10 K3", "D11.8", &[]);
    is_open(q, "SET SM702; SER D0 D1 D10 K3", "D10.0", &[]);
    is_open(Family::Iqr, "TEST D0 D1 M0", "M0", &[]);
    is_open(Family::Fx, "DEADD K1065353216 D0 D10; MOV D11 K4M0", "M0", &[]);
    // Of the FX, sums past a limit, and relays that change what is done.
    is_open(Family::Fx, "ADD D0 D1 K4M0", "M0", &[("D0", 0x7FFF), ("D1", 1)]);
    is_open(Family::Fx, "OUT M8023; LD M8000; BCD D0 K4M0", "M0", &[("D0", 5)]);
    is_open(Family::Fx, "SER D0 D1 D20 K5; MOV D20 K4M0", "M0", &[]);
}

/// What a list of `Op1` and others takes when it is run really.
fn real_cost(text: &str, start: &[(&str, u16)]) -> (u64, bool) {
    let start = start.iter().map(|(name, value)| ((*name).to_owned(), *value)).collect();
    let found = run(Family::Q, text, &start);
    assert!(found.undeclared_writes.is_empty(), "{text}: {:?}", found.undeclared_writes);
    (found.replay.total.0, found.stopped.is_none())
}

#[test]
fn counters_count_and_timers_do_not_run_backwards() {
    let counter = "LD SM400; OUT C0 K3; LD C0; Op1; LD= C0 K3; Op1; LD= C0 K2; Op1; END";
    for (start, want) in [
        (&[("C value 0", 2)][..], 2),
        (&[("C value 0", 1)], 1),
        (&[("C value 0", 2), ("C coil 0", 1)], 1),
        (&[("C value 0", 3), ("C0", 1)], 2),
        (&[("C value 0", 7)], 0),
    ] {
        assert_eq!(real_cost(counter, start), (want, true), "{start:?}");
    }
    let open = "LD SM400; OUT C0 K3; LD C0; CJ P0; LD SM400; OUT Y0; P0; END";
    assert_eq!(real_cost(open, &[("C value 0", 7)]), (0, false));
    assert_eq!(real_cost(open, &[("C value 0", 1)]), (0, true));
    // The outside gives the timer no time here: it stays where it was.
    let timer = "LD SM400; OUT T0 K100; LD T0; Op1; LD= T0 K40; Op1; LD= T0 K100; Op1; END";
    assert_eq!(real_cost(timer, &[("T value 0", 40), ("T ran 0", 1)]), (1, true));
    // It was through: what it says now is not settled.
    let through = "LD SM400; OUT T0 K100; LD T0; CJ P0; LD SM400; OUT Y0; P0; END";
    assert_eq!(real_cost(through, &[("T value 0", 100), ("T ran 0", 1)]), (0, false));
    let open = "LD SM400; OUT T0 D0; LD T0; CJ P0; LD SM400; OUT Y0; P0; END";
    assert_eq!(real_cost(open, &[("D0", 0)]), (0, false));
    assert_eq!(real_cost(open, &[("D0", 10)]), (0, true));
    let off = "LD SM401; OUT T0 K100; LD T0; OR<> T0 K0; Op1; END";
    assert_eq!(real_cost(off, &[("T value 0", 100), ("T0", 1)]), (0, true));
}

#[test]
fn texts_and_modules() {
    for (text, want) in [
        (
            "LD SM400; $MOV \"AB1\" D0; LD= D0 H4241; Op1; LD= D1 H31; Op1; LD$= D0 \"AB1\"; Op1; END",
            3,
        ),
        ("LD SM400; $MOV \"AB\" D0; LD= D0 H4241; Op1; END", 1),
        ("LD SM400; $MOV \"AB\" D0; LD= D2 K7; Op1; END", 1),
        ("LD SM400; FROM H0 K0 D0 K2; LD= D1 K0; Op1; END", 1),
    ] {
        assert_eq!(real_cost(text, &[("D2", 7), ("D1", 5)]), (want, true), "{text}");
    }
    let open = "LD SM400; $MOV \"AB\" D0; LD D1.8; CJ P0; LD SM400; OUT Y0; P0; END";
    assert_eq!(real_cost(open, &[]), (0, false));
    let open = "LD SM400; FROM H0 K0 D0 D9; LD D0.0; CJ P0; LD SM400; OUT Y0; P0; END";
    assert_eq!(real_cost(open, &[]), (0, false));
}

/// Digits rotate and shift within themselves, by the remainder of the places: which no operation here does.
#[test]
fn digits_of_bits_are_not_whole_words() {
    for instruction in ["ROL K2M0 K1", "ROR K2M0 K1", "DROL K5M0 K3", "SFL K2M0 K9", "SFR K2M0 K9"]
    {
        is_open(Family::Q, instruction, "M0", &[("M7", 1)]);
    }
    is_open(Family::Q, "SWAP K2M0", "M0", &[("M7", 1)]);
    is_open(Family::Fx, "BCD D0 K2M0", "M0", &[("D0", 123)]);
}

/// The FX and FX5 code 16 bits of words at most.
#[test]
fn codes_of_the_fx_in_words_end_at_sixteen_bits() {
    for family in [Family::Fx, Family::Fx5] {
        is_open(family, "DECO D0 D10 K5; MOV D10 K4M0", "M3", &[("D0", 3)]);
        is_open(family, "ENCO D10 D0 K5; MOV D0 K4M0", "M0", &[("D10", 8)]);
    }
}

/// A sum past the limit is no ring's on the FX wherever it is stored, and an index of a double word has 32 bits.
#[test]
fn the_fx_at_index_registers() {
    let over = [("D0", 0x7FFF), ("D1", 1)];
    is_open(Family::Fx, "ADD D0 D1 D10Z0; MOV D10 K4M0", "M0", &over);
    is_open(Family::Fx, "SUB D0 D1 D10Z0; MOV D10 K4M0", "M0", &[("D0", 0x8000), ("D1", 1)]);
    is_open(Family::Fx5, "ADD D0 D1 K4M0Z0", "M0", &over);
    is_open(Family::Fx, "DFMOV K1 D10Z0 K600; MOV D10 K4M0", "M0", &[]);
    is_open(Family::Fx, "DMEAN D10Z0 D30 K2; MOV D30 K4M0", "M0", &[]);
}

/// Where a routine runs with its coils off, an indexed coil is off, too.
#[test]
fn indexed_coils_are_held_off_with_their_routine() {
    let routine = "FEND; P1; LD SM400; OUT M0Z0; LDI M3; CJ P2; LD SM400; OUT Y0; P2; RET; END";
    let found = run(
        Family::Q,
        &format!("LD X0; FCALL P1; {routine}"),
        &Start::from([("Z0".to_owned(), 3), ("X0".to_owned(), 1)]),
    );
    assert!(found.stopped.is_some());
}

/// Of what every Q CPU has for certain.
#[test]
fn the_smallest_cpu_ends_the_areas() {
    // A run that goes beyond says so.
    for (instruction, index, needs) in [
        ("MOV D0Z0 K4M0", 11_136, 11_137),
        ("MOV W0Z0 K4M0", 0x800, 0x801),
        ("MOV K4B0Z0 K4M0", 0x7FF, 0x80F),
        ("MOV D0Z0 K4M0", 11_135, 0),
    ] {
        let start = Start::from([("Z0".to_owned(), index)]);
        let text = format!("LD SM400; {instruction}; LD M0; CJ P0; LD SM400; OUT Y0; P0; END");
        let found = run(Family::Q, &text, &start);
        assert_eq!(
            found.needed_devices.values().copied().max().unwrap_or(0),
            needs,
            "{instruction}"
        );
    }
}
