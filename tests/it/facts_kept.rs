//! Whether the program keeps or breaks what is stated to hold whenever a scan starts: told of what is plain to see, and
//! of random programs held against all their scans, run by an interpreter of the test's own.

use crate::command::binary;

use common::audited::{audited, table};
use common::tape::{Tape, cases, on_tapes};
use scanbound::base::facts::Facts;
use std::cell::Cell;
use std::collections::BTreeSet;
use std::path::Path;

/// What is told of a fact.
#[derive(Debug, Clone, PartialEq, Eq)]
enum Told {
    Kept,
    /// Neither kept nor broken.
    Unproved,
    /// The same, and a scan was found that breaks it: the first warning.
    Warned(String),
    /// It is an error.
    Broken(String),
}

/// What is told of the first of these facts that a program can keep.
fn told(text: &str, facts: &str) -> Told {
    let text = text.replace("; ", "\n") + "\nEND\n";
    let facts = Facts::parse("facts.toml", facts).unwrap_or_else(|faults| panic!("{faults:?}"));
    let table = table("Op1,1,0,0\n");
    let audit = match audited("melsec-list", Some("Q26UDV"), &[("a.il", &text)], &table, &facts) {
        Ok(concluded) => concluded.audit,
        Err(message) => return Told::Broken(message),
    };
    let mut warnings = audit.warnings.iter().filter(|one| one.file == "facts.toml");
    let mut statuses = audit.facts.iter().map(|fact| fact.status().word());
    let status = statuses.find(|word| *word != "stated").expect("a fact");
    match (status, warnings.next()) {
        ("kept", None) => Told::Kept,
        ("unproved", None) => Told::Unproved,
        ("unproved", Some(warning)) => Told::Warned(warning.message.clone()),
        other => panic!("{other:?}: {text}"),
    }
}

fn warned(message: &str) -> Told {
    let what = match message.ends_with("both on") {
        true => "that both are on, which would violate the stated set",
        false => "this value, which would violate the stated range",
    };
    Told::Warned(format!("{message} at the end of a scan: the known facts do not exclude {what}"))
}

fn broken(fact: &str, message: &str) -> Told {
    Told::Broken(format!("{fact}: the program violates this fact: {message}"))
}

/// What is told of D0 = [0, 10].
fn of_range(text: &str) -> Told {
    told(text, "[ranges]\nD0 = [0, 10]")
}

#[test]
fn a_range_is_kept_where_nothing_else_is_written() {
    assert_eq!(of_range("LD X0; MOV K7 D0"), Told::Kept);
    assert_eq!(of_range("LD< D0 K10; INC D0"), Told::Kept);
    assert_eq!(of_range("LD>= D0 K10; MOV K0 D0; LD SM400; INC D0"), Told::Kept);
    assert_eq!(of_range("LD> D0 K0; DEC D0; LD X0; MOV K10 D0"), Told::Kept);
    // What the other word holds is stated, too.
    let both = "[ranges]\nD0 = [0, 10]\nD1 = [2, 3]";
    assert_eq!(told("LD X0; MOV D1 D0", both), Told::Kept);
}

#[test]
fn a_range_is_broken_by_a_constant_or_by_any_run_from_power_up() {
    let range = "D0 = [0, 10]";
    let of = |text: &str, message: &str| assert_eq!(of_range(text), broken(range, message));
    of(
        "LD X0; MOV K11 D0",
        "`MOV K11 D0` (a.il:2) writes 11 to D0, and D0 has this value when the scan ends",
    );
    // The longest scan breaks nothing.
    of(
        "LDI X0; MOV K11 D0; LD X0; Op1",
        "`MOV K11 D0` (a.il:2) writes 11 to D0, and D0 has this value when the scan ends",
    );
    let whatever = |scan| {
        format!(
            "when the scan ends, in scan {scan} after power-up, whatever values the inputs have"
        )
    };
    of(
        "LD SM400; INC D0",
        &format!("`INC D0` (a.il:2) writes 11 to D0, and D0 has this value {}", whatever(11)),
    );
    of(
        "LD SM400; DEC D0",
        &format!("`DEC D0` (a.il:2) writes -1 to D0, and D0 has this value {}", whatever(1)),
    );
    of(
        "LD SM400; WOR K16 D0",
        &format!("`WOR K16 D0` (a.il:2) writes 16 to D0, and D0 has this value {}", whatever(1)),
    );
    of(
        "LD SM400; SET D0.4",
        &format!("`SET D0.4` (a.il:2) writes 16 to D0, and D0 has this value {}", whatever(1)),
    );
}

#[test]
fn a_range_that_only_some_scan_leaves_is_warned_of() {
    let is_warned = |text: &str, message: &str| assert_eq!(of_range(text), warned(message));
    is_warned("LD X0; INC D0", "`INC D0` (a.il:2) may leave 11 in D0");
    // It is true of each run from power-up, which goes from 0 to 6.
    let reset = "LD= D0 K5; MOV K0 D0; LD SM400; INC D0";
    is_warned(reset, "`INC D0` (a.il:4) may leave 11 in D0");
    assert_eq!(told(reset, "[ranges]\nD0 = [0, 5]"), Told::Kept);
    // Somebody else may set M9, or change D1.
    is_warned("LDI M9; INC D0", "`INC D0` (a.il:2) may leave 11 in D0");
    let Told::Warned(message) = of_range("LD SM400; MOV D1 D0") else { panic!("no warning") };
    assert!(message.starts_with("`MOV D1 D0` (a.il:2) may leave "), "{message}");
    // The longest scan breaks nothing.
    let Told::Warned(message) = of_range("LDI X0; MOV D1 D0; LD X0; Op1") else {
        panic!("no warning")
    };
    assert!(message.starts_with("`MOV D1 D0` (a.il:2) may leave "), "{message}");
}

#[test]
fn of_other_ranges_nothing_is_said() {
    // Nobody but others write it, or set what the program only clears.
    assert_eq!(of_range("LD= D0 K3; Op1"), Told::Unproved);
    assert_eq!(of_range("LD X0; MOV K0 D0"), Told::Unproved);
    let external = "[ranges]\nD0 = [0, 10]\n[external]\ndevices = [\"D0\"]";
    assert_eq!(told("LD X0; MOV K7 D0", external), Told::Unproved);
    // A power failure leaves what stood there in the midst of the scan.
    assert_eq!(of_range("LD SM400; INC D0; MOV K3 D0"), Told::Unproved);
    // At power-up it is 0.
    assert_eq!(told("LD X0; MOV K7 D0", "[ranges]\nD0 = [1, 10]"), Told::Unproved);
    // After a download it may be anything.
    let download = "[ranges]\nD0 = [0, 10]\n[start]\ndownload = true";
    assert_eq!(told("LD X0; MOV K7 D0", download), Told::Unproved);
    assert_eq!(told("LD X0; MOV K7 D0; FOR D0; NEXT", download), Told::Unproved);
}

/// What is told of M0 and M1 as never both on.
fn of_pair(text: &str) -> Told {
    told(text, "[exclusive]\nsets = [[\"M0\", \"M1\"]]")
}

#[test]
fn a_set_of_bits_is_kept_or_broken_or_neither() {
    assert_eq!(of_pair("LD X0; OUT M0; LDI X0; OUT M1"), Told::Kept);
    assert_eq!(of_pair("LD X0; ANI M1; SET M0; LD X1; ANI M0; SET M1; LD X2; RST M0"), Told::Kept);
    let whatever = |by: &str, scan| {
        let fact = "sets = [[\"M0\", \"M1\"]]";
        broken(
            fact,
            &format!(
                "{by} leave M0 and M1 both on when the scan ends, in scan {scan} after power-up, whatever values the inputs have"
            ),
        )
    };
    let both = "`SET M0` (a.il:2) and `SET M1` (a.il:3)";
    assert_eq!(of_pair("LD SM400; SET M0; SET M1"), whatever(both, 1));
    assert_eq!(of_pair("LD M2; SET M0; SET M1; LD SM400; SET M2"), whatever(both, 2));
    // The plant may keep inputs apart; and others may set M9.
    let inputs = "LD X0; OUT M0; LD X1; OUT M1";
    assert_eq!(
        of_pair(inputs),
        warned("`OUT M0` (a.il:2) and `OUT M1` (a.il:4) may leave M0 and M1 both on")
    );
    assert_eq!(
        of_pair("LDI M9; SET M0; SET M1"),
        warned(&format!("{both} may leave M0 and M1 both on"))
    );
    assert_eq!(
        told(inputs, "[exclusive]\nsets = [[\"M0\", \"M1\"], [\"X0\", \"X1\"]]"),
        Told::Kept
    );
    let apart = "[exclusive]\nsets = [[\"X0\", \"X1\"], [\"M0\", \"M1\"]]";
    assert_eq!(told(inputs, apart), Told::Unproved);
    // Of three, two that do not stand side by side.
    let three = "[exclusive]\nsets = [[\"X0\", \"X1\"], [\"M0\", \"M5\", \"M1\"]]";
    let Told::Broken(message) = told("LD SM400; SET M0; SET M1", three) else {
        panic!("is broken")
    };
    assert!(message.contains("leave M0 and M1 both on"), "{message}");
    // Nobody but others write one of them, or set what the program only clears.
    assert_eq!(of_pair("LD X0; Op1"), Told::Unproved);
    assert_eq!(of_pair("LD SM400; RST M0; RST M1"), Told::Unproved);
    let external = "[exclusive]\nsets = [[\"M0\", \"M1\"]]\n[external]\ndevices = [\"M0\"]";
    assert_eq!(told("LD X0; OUT M0; LDI X0; OUT M1", external), Told::Unproved);
}

/// What the command says of a program and its facts: its exit code, and what it prints.
fn printed(text: &str, facts: &str, format: &str) -> (Option<i32>, String, String) {
    let directory = tempfile::tempdir().expect("a directory");
    let write = |name: &str, text: &str| {
        std::fs::write(directory.path().join(name), text).expect("a file is written");
    };
    write("p.il", &(text.replace("; ", "\n") + "\nEND\n"));
    write("f.toml", facts);
    let output = binary()
        .args(["audit", "p.il", "--dialect", "melsec-list", "--cpu", "Q26UDV"])
        .args(["--facts", "f.toml", "--format", format])
        .current_dir(Path::new(directory.path()))
        .output()
        .expect("the program starts");
    let text = |bytes| String::from_utf8(bytes).expect("text");
    (output.status.code(), text(output.stdout), text(output.stderr))
}

#[test]
fn text_and_json_say_so() {
    let pair = "[exclusive]\nsets = [[\"M0\", \"M1\"]]\n[ranges]\nD0 = [0, 10]\n";
    let kept = "LD X0; OUT M0; LDI X0; OUT M1; LD< D0 K10; INC D0";
    let (code, text, _) = printed(kept, pair, "text");
    assert_eq!(code, Some(0));
    let text = text.split_whitespace().collect::<Vec<_>>().join(" ");
    for line in [
        "at most one of M0, M1 is on when a scan starts: the program never leaves two of them on",
        "D0 is 0 to 10 when the scan starts: the program writes nothing else into it",
    ] {
        assert!(text.contains(line), "{text}");
    }
    let statuses = |text: &str| {
        let report: serde_json::Value = serde_json::from_str(text).expect("JSON");
        let word = |one: &serde_json::Value| one["status"].as_str().expect("a word").to_owned();
        report["facts"].as_array().expect("facts").iter().map(word).collect::<Vec<String>>()
    };
    let (code, text, _) = printed(kept, pair, "json");
    assert_eq!((code, statuses(&text)), (Some(0), vec!["kept".to_owned(), "kept".to_owned()]));
    let open = "LD X0; OUT M0; LD X1; OUT M1; LD X0; INC D0";
    for format in ["text", "json"] {
        let (code, text, warned) = printed(open, pair, format);
        assert_eq!(code, Some(0));
        let joined = |text: &str| text.split_whitespace().collect::<Vec<_>>().join(" ");
        let (told, warned) = (joined(&text), joined(&warned));
        for fact in ["may leave 11 in D0", "may leave M0 and M1 both on"] {
            assert!(told.contains(fact) || warned.contains(fact), "{told}\n{warned}");
        }
        if format == "json" {
            assert_eq!(statuses(&text), ["unproved", "unproved"]);
        }
    }
    for (text, word) in
        [("LD SM400; SET M0; SET M1", "M0 and M1"), ("LD SM400; INC D0", "11 to D0")]
    {
        for format in ["text", "json"] {
            let (code, _, told) = printed(text, pair, format);
            assert_eq!(code, Some(2), "{told}");
            assert!(told.contains("broken-fact") && told.contains(word), "{told}");
        }
    }
}

/// What a rung does with its bit.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Does {
    Out,
    Set,
    Reset,
}

/// Contacts in series, each a bit and whether it is wanted on, and what they write. Bits are M0 to M3, then X0 and X1.
#[derive(Debug, Clone)]
struct Rung {
    contacts: Vec<(usize, bool)>,
    does: Does,
    bit: usize,
}

const RELAYS: usize = 4;
const BITS: usize = 6;

impl Rung {
    fn random(tape: &mut Tape<'_>) -> Rung {
        let contacts = 1 + tape.below(3);
        let contact = |tape: &mut Tape<'_>| (tape.below(BITS), tape.below(2) == 1);
        let mut contacts: Vec<(usize, bool)> = (0..contacts).map(|_| contact(tape)).collect();
        let does = [Does::Out, Does::Set, Does::Reset][tape.below(3)];
        let bit = tape.below(3);
        // Bits that lock each other are kept apart now and then.
        if bit < 2 && tape.percent(60) {
            contacts.push((1 - bit, false));
        }
        Rung { contacts, does, bit }
    }

    fn text(&self) -> String {
        let name = |bit: usize| match bit.checked_sub(RELAYS) {
            None => format!("M{bit}"),
            Some(input) => format!("X{input}"),
        };
        let contact = |(at, &(bit, on)): (usize, &(usize, bool))| {
            let word = match (at, on) {
                (0, true) => "LD",
                (0, false) => "LDI",
                (_, true) => "AND",
                (_, false) => "ANI",
            };
            format!("{word} {}\n", name(bit))
        };
        let contacts: String = self.contacts.iter().enumerate().map(contact).collect();
        let does = match self.does {
            Does::Out => "OUT",
            Does::Set => "SET",
            Does::Reset => "RST",
        };
        format!("{contacts}{does} {}", name(self.bit))
    }

    fn run(&self, bits: &mut [bool; BITS]) {
        let holds = self.contacts.iter().all(|&(bit, on)| bits[bit] == on);
        match self.does {
            Does::Out => bits[self.bit] = holds,
            Does::Set => bits[self.bit] |= holds,
            Does::Reset => bits[self.bit] &= !holds,
        }
    }
}

/// All states of so many bits, the first ones changing the fastest.
fn states() -> impl Iterator<Item = [bool; BITS]> {
    (0..1u32 << BITS).map(|state| std::array::from_fn(|bit| state >> bit & 1 == 1))
}

#[derive(Default)]
struct Tally {
    kept: Cell<u32>,
    warned: Cell<u32>,
    broken: Cell<u32>,
    programs: Cell<u32>,
}

fn check(tape: &mut Tape<'_>, tally: &Tally) -> Result<(), String> {
    let rungs: Vec<Rung> = (0..1 + tape.below(6)).map(|_| Rung::random(tape)).collect();
    let text = rungs.iter().map(Rung::text).collect::<Vec<_>>().join("\n");
    let both = |bits: &[bool; BITS]| bits[0] && bits[1];
    let scan = |mut bits: [bool; BITS]| {
        rungs.iter().for_each(|rung| rung.run(&mut bits));
        bits
    };
    let starts: Vec<[bool; BITS]> = states().filter(|start| !both(start)).collect();
    let is_breaking = starts.iter().any(|&start| both(&scan(start)));
    // What the program never turns on somebody else does.
    let turns_on = |bit: usize| starts.iter().any(|start| !start[bit] && scan(*start)[bit]);
    let is_kept = !is_breaking && turns_on(0) && turns_on(1);
    let fault = |told: &Told| Err(format!("{told:?}, breaking {is_breaking}:\n{text}"));
    let told = of_pair(&text);
    let count = |cell: &Cell<u32>| cell.set(cell.get() + 1);
    count(&tally.programs);
    match &told {
        Told::Kept if is_kept => count(&tally.kept),
        Told::Unproved if !is_kept && !is_breaking => {}
        Told::Warned(_) if is_breaking => count(&tally.warned),
        Told::Broken(message) if is_breaking => {
            count(&tally.broken);
            let (_, number) = message.split_once("in scan ").expect("the scan is told");
            let number: usize = number.split(' ').next().unwrap_or_default().parse().expect("one");
            // Whatever the outside gives, and whoever sets what the program does not write: no way leads further.
            let written: BTreeSet<usize> = rungs.iter().map(|rung| rung.bit).collect();
            let own = |bits: &[bool; BITS]| -> Vec<bool> {
                (0..RELAYS).map(|bit| written.contains(&bit) && bits[bit]).collect()
            };
            let mut before: BTreeSet<Vec<bool>> = BTreeSet::from([vec![false; RELAYS]]);
            for _ in 0..number {
                let from = states().filter(|start| {
                    before.contains(&own(start)) && {
                        // What is not the program's own is any value.
                        !both(start)
                    }
                });
                before = from.map(scan).filter(|end| !both(end)).map(|end| own(&end)).collect();
            }
            if !before.is_empty() {
                return fault(&told);
            }
        }
        _ => return fault(&told),
    }
    Ok(())
}

#[test]
#[allow(clippy::print_stdout)] // a long run's figures
fn of_random_programs_it_is_told_what_all_their_scans_do() {
    let tally = Tally::default();
    on_tapes(cases(300), 160, |tape| check(&mut Tape::new(tape), &tally));
    let Tally { kept, warned, broken, programs } = tally;
    let (kept, warned, broken, programs) = (kept.get(), warned.get(), broken.get(), programs.get());
    println!("{kept} kept, {warned} warned of, {broken} broken of {programs}");
    assert!(kept > programs / 50 && warned > programs / 20 && broken > 0);
}

/// A guard in front of an instruction that writes D0.
#[derive(Debug, Clone, Copy)]
enum Guard {
    Input(bool),
    Equal(i16),
    Less(i16),
    Greater(i16),
}

/// What is written into D0.
#[derive(Debug, Clone, Copy)]
enum Into {
    Constant(i16),
    Sum(i16),
    Mask(i16),
}

impl Guard {
    fn text(self) -> String {
        match self {
            Guard::Input(on) => if on { "LD X0" } else { "LDI X0" }.to_owned(),
            Guard::Equal(than) => format!("LD= D0 K{than}"),
            Guard::Less(than) => format!("LD< D0 K{than}"),
            Guard::Greater(than) => format!("LD> D0 K{than}"),
        }
    }

    fn holds(self, value: i16, input: bool) -> bool {
        match self {
            Guard::Input(on) => input == on,
            Guard::Equal(than) => value == than,
            Guard::Less(than) => value < than,
            Guard::Greater(than) => value > than,
        }
    }
}

impl Into {
    fn text(self) -> String {
        match self {
            Into::Constant(value) => format!("MOV K{value} D0"),
            Into::Sum(1) => "INC D0".to_owned(),
            Into::Sum(-1) => "DEC D0".to_owned(),
            Into::Sum(more) => format!("+ K{more} D0"),
            Into::Mask(mask) => format!("WAND K{mask} D0"),
        }
    }

    fn of(self, value: i16) -> i16 {
        match self {
            Into::Constant(value) => value,
            Into::Sum(more) => value.wrapping_add(more),
            Into::Mask(mask) => value & mask,
        }
    }
}

fn check_word(tape: &mut Tape<'_>, tally: &Tally) -> Result<(), String> {
    let bounds = [0, 3, 8, 10, 11];
    let lines: Vec<(Guard, Into)> = (0..1 + tape.below(4))
        .map(|_| {
            let than = tape.pick(&bounds);
            let guards = [
                Guard::Input(tape.percent(50)),
                Guard::Equal(than),
                Guard::Less(than),
                Guard::Greater(than),
            ];
            let constant = Into::Constant(tape.pick(&bounds));
            let all = [constant, Into::Sum(1), Into::Sum(-1), Into::Sum(2), Into::Mask(7)];
            (tape.pick(&guards), tape.pick(&all))
        })
        .collect();
    let text: Vec<String> =
        lines.iter().map(|(guard, into)| format!("{}\n{}", guard.text(), into.text())).collect();
    let text = text.join("\n");
    // What a scan writes, one after the other.
    let scan = |mut value: i16, input: bool| {
        let mut written = Vec::new();
        for (guard, into) in &lines {
            if guard.holds(value, input) {
                value = into.of(value);
                written.push(value);
            }
        }
        written
    };
    let range = 0..=10;
    let starts = || range.clone().flat_map(|start| [(start, false), (start, true)]);
    let mut scans = starts().map(|(start, input)| scan(start, input));
    let is_within = scans.clone().all(|written| written.iter().all(|one| range.contains(one)));
    let is_breaking = scans.any(|written| written.last().is_some_and(|one| !range.contains(one)));
    let moves = [false, true].iter().any(|&on| scan(0, on).last().is_some_and(|&end| end != 0));
    let count = |cell: &Cell<u32>| cell.set(cell.get() + 1);
    count(&tally.programs);
    match of_range(&text) {
        // What only masks or lowers a word writes it, too, though somebody else sets it.
        Told::Kept if is_within => count(&tally.kept),
        Told::Unproved if !(is_breaking || is_within && moves) => {}
        Told::Warned(_) if is_breaking => count(&tally.warned),
        Told::Broken(message) if is_breaking => {
            count(&tally.broken);
            let Some((_, number)) = message.split_once("in scan ") else {
                // A constant that lies outside stands there.
                return if message.contains("`MOV K11 D0`") { Ok(()) } else { Err(message) };
            };
            let number: usize = number.split(' ').next().unwrap_or_default().parse().expect("one");
            let mut before = BTreeSet::from([0]);
            for _ in 0..number {
                let ends = before.iter().flat_map(|&start| {
                    [false, true].map(|on| scan(start, on).last().copied().unwrap_or(start))
                });
                before = ends.filter(|end| range.contains(end)).collect();
            }
            if !before.is_empty() {
                return Err(format!("{message}: {before:?} are left:\n{text}"));
            }
        }
        other => return Err(format!("{other:?}, breaking {is_breaking}:\n{text}")),
    }
    Ok(())
}

#[test]
#[allow(clippy::print_stdout)] // a long run's figures
fn of_random_counters_it_is_told_what_all_their_scans_do() {
    let tally = Tally::default();
    on_tapes(cases(300), 80, |tape| check_word(&mut Tape::new(tape), &tally));
    let Tally { kept, warned, broken, programs } = tally;
    let (kept, warned, broken, programs) = (kept.get(), warned.get(), broken.get(), programs.get());
    println!("{kept} kept, {warned} warned of, {broken} broken of {programs}");
    assert!(kept > programs / 50 && warned > programs / 50 && broken > programs / 50);
}
