//! Relays that are trusted to be never both on, against a PLC made from the manuals alone: no run of thousands of scans
//! from power-up takes longer than the bound with `--trust all`, whatever inputs do, and the bound is never above one
//! that trusts less.

use common::audited::{asked, listed, table};
use common::plc::{Device, Line, Luck, Plc, line};
use common::tape::{Tape, cases, on_tapes};
use scanbound::audit::{Concluded, Failure, conclude, follow};
use scanbound::base::facts::Facts;
use scanbound::passes::values::Trust;
use std::cell::Cell;
use std::collections::{BTreeMap, BTreeSet};

/// Scans of a program, and after how many of them its power fails.
const SCANS: u64 = 600;
const AFTER_POWER_UP: u64 = 150;

const RELAYS: usize = 6;

/// A program of steps that hand on to each other, interlocked coils, and rungs that cost where two relays are on.
fn generate(tape: &mut Tape<'_>) -> Vec<String> {
    let mut lines = Vec::new();
    for _ in 0..2 + tape.below(10) {
        let (a, b) = (tape.below(RELAYS), tape.below(RELAYS));
        let x = tape.below(3);
        let text = match tape.below(12) {
            0..3 => format!("LD M{a}/AND X{x}/SET M{b}/RST M{a}"),
            3 => format!("LDI M{a}/ANI M{b}/AND X{x}/SET M{a}"),
            4 => format!("LD X{x}/ANI M{a}/OUT M{b}"),
            5 => format!("LD X{x}/OUT M{a}/LDI X{x}/OUT M{b}"),
            6 => format!("LD X{x}/OR M{a}/ANI M{b}/OUT M{a}"),
            7 => format!("LD X{x}/RST M{a}"),
            8 => format!("LD M{a}/AND M{b}/SET M{}", tape.below(RELAYS)),
            9 => format!("LD X{x}/PLS M{a}"),
            10 => format!("LD X{x}/MOV K{} K1M{}", tape.below(4), a.min(RELAYS - 4)),
            _ => format!("LD X{x}/CJ P{}", lines.len()),
        };
        let target = text.rsplit_once("CJ ").map(|(_, label)| label.to_owned());
        lines.extend(text.split('/').map(str::to_owned));
        lines.extend([format!("LD M{a}"), format!("AND M{b}"), "INC D0".to_owned()]);
        lines.extend(target);
        if tape.done() {
            break;
        }
    }
    // What an earlier scan left is read before it is written.
    let mut all: Vec<String> = Vec::new();
    for (a, b) in [(0, 1), (2, 3), (4, 5), (1, 3)] {
        all.extend([format!("LD M{a}"), format!("AND M{b}"), "INC D1".to_owned()]);
    }
    all.extend(lines);
    all.push("END".to_owned());
    all
}

/// Keeps memory from scan to scan. Inputs, and relays that the program never turns on, are something else in each scan.
struct Plant<'a> {
    chance: &'a Cell<u64>,
    own: &'a BTreeSet<u32>,
    memory: &'a BTreeMap<Device, u16>,
}

impl Luck for Plant<'_> {
    fn value(&mut self, of: Device) -> u16 {
        let known = self.memory.get(&of).copied();
        match of {
            ("M", n) if !self.own.contains(&n) => self.below(2) as u16,
            ("X", _) => self.below(2) as u16,
            ("D", _) => self.below(50_000) as u16,
            _ => known.unwrap_or(0),
        }
    }

    fn below(&mut self, n: u32) -> u32 {
        // xorshift64 (G. Marsaglia: Xorshift RNGs, Journal of Statistical Software 8, 2003).
        let mut x = self.chance.get();
        x ^= x << 13;
        x ^= x >> 7;
        x ^= x << 17;
        self.chance.set(x);
        (x >> 16) as u32 % n
    }
}

#[derive(Default)]
struct Tally {
    apart: Cell<u32>,
    lower: Cell<u32>,
    reached: Cell<u32>,
}

fn audited(trust: Trust, facts: &Facts, text: &str) -> Concluded {
    let table = table("INC,1,0,0\n");
    let inputs = listed(text);
    let request = asked(&inputs, &table, facts, trust);
    conclude(follow(&request).expect("followed"), &request).expect("an audit")
}

/// `internal`: instead of all the first relays are trusted, so many, since they are stated to be the program's own.
fn check(tape: &[u16], internal: Option<u32>, tally: &Tally) -> Result<(), String> {
    let lines = generate(&mut Tape::new(tape));
    let text = lines.join("\n") + "\n";
    let listed = || {
        let lines = lines.iter().enumerate().map(|(at, line)| format!("{:3} {line}", at + 1));
        lines.collect::<Vec<_>>().join("\n")
    };
    let upper = |found: &Concluded| found.audit.bound.upper.0 / 1_000_000;
    let (trust, facts) = match internal {
        None => (Trust::All, Facts::default()),
        Some(few) => {
            let internal = (0..few).map(|n| format!("M{n}")).collect();
            (Trust::Counts, Facts { internal, ..Facts::default() })
        }
    };
    let none = audited(Trust::None, &Facts::default(), &text);
    let all = audited(trust, &facts, &text);
    if upper(&all) > upper(&none) {
        return Err(format!("{} above {}\n{}", upper(&all), upper(&none), listed()));
    }
    let apart = &all.followed.program.mutually_exclusive;
    tally.apart.set(tally.apart.get() + u32::from(!apart.is_empty()));
    tally.lower.set(tally.lower.get() + u32::from(upper(&all) < upper(&none)));
    let turned_on = |n: &u32| {
        lines.iter().any(|line| {
            let on = ["SET", "OUT", "PLS"].iter().any(|name| *line == format!("{name} M{n}"));
            on || line.starts_with("MOV")
        })
    };
    let own: BTreeSet<u32> = (0..internal.unwrap_or(RELAYS as u32)).filter(turned_on).collect();
    let program = [lines.iter().map(|text| line(text)).collect::<Vec<Line>>()];
    let chance = Cell::new(0x9E37_79B9_7F4A_7C15);
    let mut memory: BTreeMap<Device, u16> = BTreeMap::new();
    let mut longest = 0;
    for scan in 0..SCANS {
        if scan.is_multiple_of(AFTER_POWER_UP) {
            memory.clear();
        }
        for group in apart {
            let name = |cell| all.followed.program.cell_name(cell);
            let held = |cell| {
                let on = memory.iter().find(|((area, n), _)| format!("{area}{n}") == name(cell));
                on.is_some_and(|(_, &value)| value & 1 == 1)
            };
            if group.bits.iter().filter(|bit| held(bit.cell())).count() > 1 {
                let names: Vec<String> = group.bits.iter().map(|bit| name(bit.cell())).collect();
                return Err(format!("two of {names:?} are on\n{}", listed()));
            }
        }
        let plant = Plant { chance: &chance, own: &own, memory: &memory };
        let (executed, left) = Plc::new(&program, plant, Vec::new()).both();
        let costs =
            |&&(_, at, on, _): &&(usize, usize, bool, u64)| on && lines[at - 1].starts_with("INC");
        longest = longest.max(executed.iter().filter(costs).count() as u64);
        if longest > upper(&all) {
            return Err(format!("a scan takes {longest}, at most {}\n{}", upper(&all), listed()));
        }
        memory.extend(left);
    }
    tally.reached.set(tally.reached.get() + u32::from(longest == upper(&all)));
    Ok(())
}

#[test]
#[allow(clippy::print_stdout)] // a long run's figures
fn no_run_from_power_up_takes_longer_than_with_all_trusted() {
    let tally = Tally::default();
    on_tapes(cases(60), 100, |tape| check(tape, None, &tally));
    let (apart, lower, reached) = (tally.apart.get(), tally.lower.get(), tally.reached.get());
    println!("{apart} with relays apart, {lower} bounds lower, {reached} reached");
    assert!(lower > cases(60) / 20 && reached > cases(60) / 4, "{apart} {lower} {reached}");
}

#[test]
fn no_run_from_power_up_takes_longer_than_with_the_programs_own_relays_trusted() {
    let tally = Tally::default();
    on_tapes(cases(40), 100, |tape| check(tape, Some(4), &tally));
    assert!(tally.lower.get() > cases(40) / 20, "{}", tally.lower.get());
}

/// The bound of a program with all trusted, in microseconds.
fn all(text: &str) -> u64 {
    audited(Trust::All, &Facts::default(), &text.replace('/', "\n")).audit.bound.upper.0 / 1_000_000
}

#[test]
fn steps_that_hand_on_are_never_both_on() {
    let both = "LD M1/AND M2/INC D0/LD M1/AND M3/INC D0/LD M2/AND M3/INC D0/";
    let begin = "LDI M1/ANI M2/ANI M3/SET M1/";
    let step = |from, to, x| format!("LD M{from}/AND X{x}/SET M{to}/RST M{from}/");
    let ring = [step(1, 2, 1), step(2, 3, 2), step(3, 1, 3)].concat();
    assert_eq!(all(&format!("{both}{begin}{ring}END/")), 0);
    // Each may be on by itself.
    let each = "LD M1/INC D0/INC D0/LD M2/INC D0/INC D0/INC D0/LD M3/INC D0/";
    assert_eq!(all(&format!("{each}{begin}{ring}END/")), 3);
    let first = each.replacen("LD M1/", "LD M1/INC D0/INC D0/", 1);
    assert_eq!(all(&format!("{first}{begin}{ring}END/")), 4);
    // One more that turns a step on by itself.
    assert_eq!(all(&format!("{both}{begin}{ring}LD X9/SET M3/END/")), 3);
}

#[test]
fn what_the_program_never_turns_on_somebody_else_does() {
    let both = "LD M1/AND M2/INC D0/";
    assert_eq!(all(&format!("{both}LD X1/RST M1/LD X2/ANI M1/SET M2/LD M1/RST M2/END/")), 1);
    // By effect: M1 would need M9, which nothing turns on. An HMI sets M9, so that M1 may come on.
    let locked = format!("{both}LD M9/SET M1/LD X2/ANI M1/OUT M2/LD X3/RST M9/END/");
    assert_eq!(all(&locked), 0, "M2 is off in the scan after M1 came on");
    // M8 needs itself: it never comes on, so somebody else writes it.
    assert_eq!(all(&format!("{both}LD M8/SET M8/SET M1/LD X2/SET M2/END/")), 1);
}

#[test]
fn latched_relays_and_what_others_refresh_are_not_trusted() {
    let apart =
        |a: &str, b: &str| all(&format!("LD {a}/AND {b}/INC D0/LD X1/OUT {a}/LDI X1/OUT {b}/END/"));
    assert_eq!(apart("M1", "M2"), 0);
    assert_eq!(apart("Y1", "Y2"), 0);
    assert_eq!(apart("L1", "L2"), 1);
    assert_eq!(apart("B1", "B2"), 1);
}

#[test]
fn what_others_write_and_scans_after_a_download_are_covered_if_stated() {
    let text = "LD M1\nAND M2\nINC D0\nLD X1\nOUT M1\nLDI X1\nOUT M2\nEND\n";
    let stated = |facts: &str| {
        let facts = Facts::parse("facts.toml", facts).expect("facts");
        let table = table("INC,1,0,0\n");
        let inputs = listed(text);
        let request = asked(&inputs, &table, &facts, Trust::All);
        let followed = follow(&request).ok()?;
        let concluded = conclude(followed, &request).expect("an audit");
        Some(concluded.audit.bound.upper.0 / 1_000_000)
    };
    assert_eq!(stated(""), Some(0));
    assert_eq!(stated("[external]\ndevices = [\"M5\", \"D0-D9\"]\n"), Some(0));
    assert_eq!(stated("[external]\ndevices = [\"M0-M1\"]\n"), Some(1));
    assert_eq!(stated("[start]\ndownload = true\n"), Some(1));
    for wrong in ["Q7", "M9-M1", "M1-D5", "M"] {
        assert_eq!(stated(&format!("[external]\ndevices = [\"{wrong}\"]\n")), None, "{wrong}");
    }
}

#[test]
fn relays_that_are_stated_to_be_the_programs_own_are_trusted_with_counts_too() {
    let stated = |trust: Trust, facts: &str, text: &str| {
        let facts = Facts::parse("facts.toml", facts).expect("facts");
        let audit = audited(trust, &facts, &text.replace('/', "\n")).audit;
        let told = audit.warnings.iter().filter(|one| one.file == "facts.toml").count();
        (audit.bound.upper.0 / 1_000_000, told, audit.facts.len())
    };
    let internal = |devices: &str| format!("[internal]\ndevices = [{devices}]\n");
    let text = "LD M1/AND M2/INC D0/LD X1/OUT M1/LDI X1/OUT M2/END/";
    let counts = |facts: &str| stated(Trust::Counts, facts, text);
    assert_eq!(counts(""), (1, 0, 0));
    assert_eq!(counts(&internal("'M0-M2'")), (0, 0, 1));
    assert_eq!(counts(&internal("'M2', 'm1'")), (0, 0, 1));
    assert_eq!(counts(&internal("'M1'")).0, 1);
    let other = internal("'M0-M9'") + "[external]\ndevices = ['M2']\n";
    assert_eq!(counts(&other), (1, 0, 2));
    // Where memory may hold anything, and where nobody is trusted, nothing follows from it.
    assert_eq!(counts(&(internal("'M1', 'M2'") + "[start]\ndownload = true")), (1, 1, 2));
    assert_eq!(stated(Trust::None, &internal("'M1', 'M2'"), text), (1, 1, 1));
    assert_eq!(stated(Trust::All, &internal("'M1', 'M2'"), text), (0, 0, 1));
    let of = |a: &str| text.replace('M', a);
    // B is a network's where there is one.
    assert_eq!(stated(Trust::Counts, &internal("'B1', 'B2'"), &of("B")), (0, 0, 1));
    assert_eq!(stated(Trust::Counts, &internal("'L1', 'L2'"), &of("L")), (1, 0, 1));
    assert_eq!(counts(&internal("'X1', 'M1'")), (1, 1, 1), "an input");
    let wrong = Facts::parse("facts.toml", &internal("'Q7'")).expect("facts");
    let (table, inputs) = (table("INC,1,0,0\n"), listed("LD X0\nOUT Y0\nEND\n"));
    let Err(Failure::Input(faults)) = follow(&asked(&inputs, &table, &wrong, Trust::All)) else {
        panic!("Q7 is no device")
    };
    assert!(faults[0].message.starts_with("'Q7' under [internal] is not a device"));
}
