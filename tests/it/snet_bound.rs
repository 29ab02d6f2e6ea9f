//! The bound of a net's code with what the net knows, against a C200H made from the manual alone: no scan of thousands
//! from power-up on takes longer, and every set of relays that the bound rests on is kept when scans start.

use common::tape::cases;

use common::snet::{Random, random_net, ring_net};
use scanbound::audit::{Audit, Request, conclude, follow, net_bound};
use scanbound::base::facts::Facts;
use scanbound::front::Input;
use scanbound::passes::values::Trust;
use scanbound::snet::faults::faults;
use scanbound::snet::knowledge::relays;
use scanbound::snet::translate::{c200h, listing};
use scanbound::snet::{Diagram, text};
use scanbound::timing::table::Table;
use std::collections::{BTreeMap, BTreeSet};

/// What the routines on boxes take, in seconds; all else takes less than one together.
const WORK: [u64; 4] = [1, 2, 4, 8];
const SECOND: u64 = 1_000_000_000_000;

/// An audit of a list with what a net knows, if one is given.
fn audited(code: &str, net: Option<&Diagram>, trust: Trust, facts: &str) -> Audit {
    let inputs = [Input { name: "a.il".to_owned(), bytes: code.as_bytes().to_vec() }];
    let work: String = WORK.iter().map(|n| format!("Op{n},{n}000000,0\n")).collect();
    let table = format!("instruction,on_us,off_us\n@base,c200h\n{work}");
    let table = Table::parse("t.csv", table.as_bytes()).expect("a table").table;
    let facts = Facts::parse("f.toml", &format!("[scan]\nfactor = 1.0\n{facts}")).expect("facts");
    let net = net.map(relays);
    let request = Request {
        dialect: Some("omron-c200h"),
        table: Some(&table),
        net: net.as_ref(),
        trust,
        ..Request::new(&inputs, &facts)
    };
    let followed = follow(&request).unwrap_or_else(|why| panic!("{code}\n{why:?}"));
    let mut concluded =
        conclude(followed, &request).unwrap_or_else(|why| panic!("{code}\n{why:?}"));
    net_bound(&mut concluded, &request).expect("an audit without the net");
    concluded.audit
}

/// One line of a list.
#[derive(Debug, Clone)]
struct Line {
    mnemonic: String,
    is_closed: bool,
    operand: String,
    value: u16,
}

fn parsed(code: &str) -> Vec<Line> {
    let mut lines: Vec<Line> = Vec::new();
    for text in code.lines() {
        let text = text.split('(').next().unwrap_or_default();
        let mut words: Vec<&str> = text.split_whitespace().collect();
        if words.first().is_some_and(|word| word.len() == 5 && word.parse::<u32>().is_ok()) {
            words.remove(0);
        }
        match words.first() {
            None => continue,
            Some(word) if word.starts_with("--") => continue,
            Some(word) if word.starts_with('#') => {
                let last = lines.last_mut().expect("a timer or counter");
                last.value = word[1..].parse().expect("digits");
                continue;
            }
            Some(_) => {}
        }
        let is_closed = words.get(1) == Some(&"NOT");
        let from = if is_closed { 2 } else { 1 };
        let operand = words[from..].concat();
        lines.push(Line { mnemonic: words[0].to_owned(), is_closed, operand, value: 0 });
    }
    lines
}

/// A C200H.
#[derive(Debug, Default)]
struct Cpu {
    on: BTreeSet<String>,
    /// By counter: what is left to count, and whether it was asked to count in the scan before.
    counters: BTreeMap<String, (u16, bool)>,
    is_first: bool,
}

impl Cpu {
    /// One scan, of so many lines at most; how many seconds its routines take.
    fn scan(&mut self, lines: &[Line], random: &mut Random, most: usize) -> u64 {
        let (mut stack, mut is_out, mut took): (Vec<bool>, bool, u64) = (Vec::new(), false, 0);
        for line in lines.iter().take(most) {
            let contact = match line.operand.as_str() {
                "25315" => self.is_first,
                name => self.on.contains(name),
            } != line.is_closed;
            if std::mem::take(&mut is_out) && line.mnemonic == "LD" {
                stack.clear();
            }
            let top = stack.last().copied().unwrap_or(true);
            let under = || stack.len().checked_sub(2).map(|at| stack[at]).expect("two conditions");
            let own = line.operand.clone();
            is_out = true;
            match line.mnemonic.as_str() {
                "LD" => stack.push(contact),
                "AND" => *stack.last_mut().expect("a condition") &= contact,
                "OR" => *stack.last_mut().expect("a condition") |= contact,
                "OUT" => self.set(own, top != line.is_closed),
                "SET" if top => self.set(own, true),
                "RSET" if top => self.set(own, false),
                "SET" | "RSET" => {}
                "TIM" => {
                    let name = format!("TIM{own}");
                    let is_over = top && (self.on.contains(&name) || random.one_in(3));
                    self.set(name, is_over);
                    let number: u16 = own.parse().expect("a timer's number");
                    self.set(format!("TIMER-RUNS-{number}"), top);
                }
                "CNT" => {
                    let (count, reset) = (under(), top);
                    let (left, before) =
                        self.counters.get(&own).copied().unwrap_or((line.value, false));
                    let left = match () {
                        () if reset => line.value,
                        () if count && !before => left.saturating_sub(1),
                        () => left,
                    };
                    self.counters.insert(own.clone(), (left, count));
                    self.set(format!("CNT{own}"), left == 0);
                }
                "END" => break,
                work => {
                    let seconds: u64 = work[2..].parse().unwrap_or_else(|_| panic!("{work}"));
                    took += if top { seconds } else { 0 };
                }
            }
            is_out &= !matches!(line.mnemonic.as_str(), "LD" | "AND" | "OR");
        }
        self.is_first = false;
        took
    }

    fn set(&mut self, name: String, is_on: bool) {
        if is_on {
            self.on.insert(name);
        } else {
            self.on.remove(&name);
        }
    }

    /// Power fails and comes back: holding relays and counters keep what they have.
    fn power_up(&mut self) {
        self.on.retain(|name| name.starts_with("HR") || name.starts_with("CNT"));
        self.is_first = true;
    }

    /// Whether a relay is on, by the name that reports have: `IR3.A`.
    fn has(&self, name: &str) -> bool {
        let (area, rest) = name.split_at(name.find(|c: char| c.is_ascii_digit()).expect("a word"));
        if name.starts_with("TIMER-RUNS-") {
            return self.on.contains(name);
        }
        let (word, bit) = rest.split_once('.').unwrap_or_else(|| panic!("{name} is no relay"));
        let (word, bit) = (word.parse::<u16>().expect("a word"), u8::from_str_radix(bit, 16));
        let digits = if area == "IR" { 3 } else { 2 };
        let area = if area == "IR" { "" } else { area };
        self.on.contains(&format!("{area}{word:0digits$}{:02}", bit.expect("a bit")))
    }
}

/// A random relay of a net.
fn relay(net: &Diagram, random: &mut Random) -> String {
    let heads: Vec<_> = (net.places.iter().map(|one| &one.head))
        .chain(net.transitions.iter().map(|one| &one.head))
        .chain(net.outers.iter().map(|one| &one.head))
        .collect();
    // Boxes most of all.
    let count = if random.one_in(3) { heads.len() } else { net.places.len() };
    heads[random.below(count)].address.expect("an address").to_string()
}

/// Routines on boxes, and now and then something that meddles with them.
fn work(net: &Diagram, random: &mut Random, meddles: bool) -> String {
    let mut out = String::new();
    for _ in 0..random.below(6) {
        let not = |random: &mut Random| if random.one_in(4) { "NOT " } else { "" };
        out += &format!("LD {}{}\n", not(random), relay(net, random));
        for _ in 0..random.below(3) {
            let word = if random.one_in(5) { "OR" } else { "AND" };
            out += &format!("{word} {}{}\n", not(random), relay(net, random));
        }
        out += &match random.below(12) {
            0 if meddles => format!("SET {}\n", relay(net, random)),
            1 if meddles => format!("RSET {}\n", relay(net, random)),
            2 if meddles => format!("OUT {}\n", relay(net, random)),
            _ => format!("Op{}\n", WORK[random.below(WORK.len())]),
        };
    }
    out
}

/// A random net, some of whose boxes may be holding relays.
fn net(random: &mut Random) -> Diagram {
    loop {
        let mut source = if random.one_in(3) { random_net(random, 6) } else { ring_net(random) };
        if random.one_in(8) {
            let word = 300 + random.below(4);
            source = source.replace(&format!("= {word:05}"), &format!("= HR{:04}", word - 300));
        }
        let found = text::read("n.snet", &source).unwrap_or_else(|why| panic!("{source}\n{why:?}"));
        if faults(&found).is_empty() {
            return found;
        }
    }
}

/// The longest of many scans of a list from power-up on. What the audit rests on has to hold whenever one starts.
fn longest(code: &str, audit: &Audit, random: &mut Random) -> u64 {
    let lines = parsed(code);
    let (mut cpu, mut longest) = (Cpu::default(), 0);
    let rests: Vec<(&[String], usize)> = (audit.assumptions.iter())
        .filter(|one| one.range.is_none())
        .map(|one| (one.devices.as_slice(), one.most))
        .chain(audit.net.iter().flat_map(|net| &net.used).map(|set| (&set.relays[..], set.most)))
        .collect();
    cpu.power_up();
    for scan in 0..1_500 {
        if scan % 60 == 59 {
            let some = random.below(lines.len());
            cpu.scan(&lines, random, some);
            cpu.power_up();
        }
        for &(relays, most) in rests.iter().filter(|(_, most)| *most > 0 || cpu.is_first) {
            let on: Vec<&String> = relays.iter().filter(|one| cpu.has(one)).collect();
            assert!(on.len() <= most, "{on:?} of {relays:?} are on\n{code}");
        }
        for outer in ["00000", "00001", "00002"] {
            if !random.one_in(3) {
                let is_on = random.one_in(2);
                cpu.set(outer.to_owned(), is_on);
            }
        }
        longest = longest.max(cpu.scan(&lines, random, usize::MAX));
    }
    longest
}

#[test]
fn no_scan_from_power_up_takes_longer_than_the_bound_with_the_net() {
    let mut random = Random::new(23);
    let (mut with_net, mut lower, mut lower_by_net, mut reached, mut refused) = (0, 0, 0, 0, 0);
    for case in 0..cases(150_u32) {
        let own = net(&mut random);
        let meddles = random.one_in(4);
        let is_first_scan = !random.one_in(4);
        let list = c200h(&own, &listing(&own, is_first_scan).expect("addresses"));
        let list = list.rsplit_once('\n').and_then(|(list, _)| list.rsplit_once('\n'));
        let list = list.expect("an END").0;
        let (front, behind) = (work(&own, &mut random, meddles), work(&own, &mut random, meddles));
        let code = format!("{front}{list}\n{behind}END\n");
        // What a net knows that has nothing to do with the code must do no harm.
        let is_wrong = random.one_in(4);
        let hinting = if is_wrong { net(&mut random) } else { own.clone() };
        let audit = audited(&code, Some(&hinting), Trust::All, "");
        let upper = audit.bound.upper.0 / SECOND;
        let found = audit.net.as_ref().expect("a net was given");
        assert!(found.without >= found.alone && found.alone >= audit.bound.upper, "{case}\n{code}");
        let longest = longest(&code, &audit, &mut random);
        assert!(longest <= upper, "case {case}: {longest} s, and the bound is {upper} s\n{code}");
        with_net += u32::from(!found.used.is_empty());
        lower += u32::from(upper < found.without.0 / SECOND);
        lower_by_net += u32::from(upper < found.alone.0 / SECOND);
        reached += u32::from(longest == upper);
        refused += u32::from(is_wrong && !found.unused.is_empty());
    }
    assert!(
        with_net > 30 && lower > 15 && lower_by_net > 0 && reached > 20 && refused > 10,
        "{with_net} with sets, {lower} lower, {lower_by_net} by the net, {reached} reached, {refused} refused"
    );
}

const CAROUSEL: &str = include_str!("../../samples/snet/carousel.snet");
const STATIONS: &str = "LD 00300\nOp1\nLD 00301\nOp2\nLD 00302\nOp4\n";

fn carousel(is_first_scan: bool) -> (Diagram, String) {
    let net = text::read("carousel.snet", CAROUSEL).expect("a net");
    let list = c200h(&net, &listing(&net, is_first_scan).expect("addresses"));
    (net, format!("{STATIONS}{list}"))
}

fn seconds(audit: &Audit) -> u64 {
    audit.bound.upper.0 / SECOND
}

#[test]
fn of_three_stations_with_two_pallets_one_is_empty_as_only_the_net_knows() {
    let (net, code) = carousel(true);
    let audit = audited(&code, Some(&net), Trust::All, "");
    let found = audit.net.as_ref().expect("a net");
    // The audit looks at pairs of relays alone.
    assert_eq!((seconds(&audit), found.alone.0 / SECOND, found.without.0 / SECOND), (6, 7, 7));
    assert_eq!(found.marked, ["PRESS", "CHECK"]);
    let (first, all) = (&found.used[0], ["LOAD", "PRESS", "CHECK"]);
    assert_eq!((&first.elements[..], first.most), (&all.map(str::to_owned)[..], 2));
}

#[test]
fn without_trust_nothing_is_used_and_internal_devices_are() {
    let (net, code) = carousel(true);
    for trust in [Trust::None, Trust::Counts] {
        let audit = audited(&code, Some(&net), trust, "");
        let found = audit.net.as_ref().expect("a net");
        assert_eq!((seconds(&audit), found.without.0 / SECOND), (7, 7));
        assert!(found.used.is_empty() && !found.unused.is_empty());
        assert!(found.unused.iter().all(|one| one.why.to_string().contains("--trust all")));
    }
    let internal = "[internal]\ndevices = [\"IR3\"]\n";
    assert_eq!(seconds(&audited(&code, Some(&net), Trust::Counts, internal)), 6);
    assert_eq!(seconds(&audited(&code, Some(&net), Trust::None, internal)), 7);
    let external = "[external]\ndevices = [\"IR3\"]\n";
    assert_eq!(seconds(&audited(&code, Some(&net), Trust::All, external)), 7);
    let download = "[start]\ndownload = true\n";
    assert_eq!(seconds(&audited(&code, Some(&net), Trust::All, download)), 7);
}

#[test]
fn what_is_stated_never_to_be_zero_somebody_else_set() {
    let (net, code) = carousel(true);
    let stated = "[ranges]\nIR3 = [7, 7]\n";
    assert_eq!(seconds(&audited(&code, Some(&net), Trust::All, stated)), 7);
    let stated = "[ranges]\nIR3 = [0, 7]\n";
    assert_eq!(seconds(&audited(&code, Some(&net), Trust::All, stated)), 6);
}

/// The bound with the net, and why what it knows of the three stations is not used.
fn refused(net: &Diagram, code: &str, facts: &str) -> String {
    let audit = audited(code, Some(net), Trust::All, facts);
    assert_eq!(seconds(&audit), 7, "{code}");
    let found = audit.net.expect("a net");
    let all = found.unused.iter().find(|one| one.set.elements.len() == 3);
    all.expect("the three stations").why.to_string()
}

#[test]
fn what_the_code_does_not_keep_is_refused_with_the_reason() {
    let (net, code) = carousel(true);
    // Initial marks that nobody puts in are put in by somebody, at any time.
    let (_, dead) = carousel(false);
    assert!(refused(&net, &dead, "").contains("never turns this relay on"));
    // A hand switch puts a third pallet in; so does a first scan that comes again.
    let by_hand = code.replace("LD 00300\nOp1", "LD 00009\nSET 00302\nLD 00300\nOp1");
    assert!(refused(&net, &by_hand, "").contains("it is not proved that scans preserve this set"));
    // With the IOM hold bit relays outlast STOP, and the flag of the first scan comes on.
    let kept = code.replace("LD 00300\nOp1", "LD 00009\nOUT 25212\nLD 00300\nOp1");
    assert_ne!(kept, code);
    assert!(refused(&net, &kept, "").contains("it is not proved that scans preserve this set"));
    let again = code.replace("25315", "00009");
    assert!(refused(&net, &again, "").contains("it is not proved that scans preserve this set"));
    // Holding relays survive a power failure in mid-scan, and the first scan puts two more pallets in.
    let held = CAROUSEL.replace("00300", "HR0000").replace("00301", "HR0001");
    let held = text::read("carousel.snet", &held).expect("a net");
    let list = code.replace("00300", "HR0000").replace("00301", "HR0001");
    assert!(refused(&held, &list, "").contains("power failure"));
    // Data links write what they like.
    let linked = CAROUSEL.replace("00300", "LR0000");
    let linked = text::read("carousel.snet", &linked).expect("a net");
    assert!(refused(&linked, &code.replace("00300", "LR0000"), "").contains("a network"));
    // A word of which other bits are read is one of inputs.
    let read = code.replace("LD 00301\nOp2", "LD 00315\nOp1\nLD 00301\nOp2");
    let audit = audited(&read, Some(&net), Trust::All, "");
    assert_eq!(seconds(&audit), 8);
}
