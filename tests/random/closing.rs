//! What an audit says of programs whose words take so few values that every start and every input can be tried: the
//! longest scan of a PLC made from the manuals alone, over all of them, is what the lower bound says. The interpreter
//! that finds lower bounds and the analysis have no part in it.

use common::audited::{audited, table};
use common::few::{generate, indexed, rows};
use common::plc::{Device, Executed, Line, Luck, Plc, line};
use common::tape::{Tape, cases, on_tapes};
use scanbound::audit::Followed;
use scanbound::base::facts::Facts;
use scanbound::base::time::{Picos, Times};
use std::cell::RefCell;
use std::collections::BTreeMap;

/// Programs with more ways than this are passed over.
const MAX_WAYS: usize = 6_000;

/// Answers every question in every way, one way a scan.
#[derive(Default)]
struct Every {
    /// How many answers there are and which was given, question by question.
    taken: Vec<(u16, u16)>,
    at: usize,
    /// Whether loops with counts below 1 run once, and whether there was one.
    once: bool,
    asked: bool,
}

impl Every {
    fn answer(&mut self, of: u16) -> u16 {
        if self.at == self.taken.len() {
            self.taken.push((of, 0));
        }
        self.at += 1;
        self.taken[self.at - 1].1
    }

    /// The next way of answering, if there is one.
    fn advance(&mut self) -> bool {
        self.at = 0;
        while let Some((of, given)) = self.taken.pop() {
            if given + 1 < of {
                self.taken.push((of, given + 1));
                return true;
            }
        }
        false
    }
}

impl Luck for &mut Every {
    fn value(&mut self, (area, number): Device) -> u16 {
        match (area, number) {
            // Programs mask these before anything else reads them.
            ("D" | "Z", 0 | 1) => self.answer(8),
            ("D" | "Z" | "W", _) => panic!("{area}{number} is read before it is written"),
            ("T" | "C" | "ST", _) => self.answer(8),
            _ => self.answer(2),
        }
    }

    fn below(&mut self, n: u32) -> u32 {
        self.answer(n as u16).into()
    }

    fn once(&mut self) -> bool {
        self.asked = true;
        self.once
    }
}

/// What each line costs on and off, by the table.
fn prices(followed: &Followed) -> BTreeMap<usize, Times> {
    let mut prices: BTreeMap<usize, Times> = BTreeMap::new();
    for (instruction, times) in followed.program.instructions.iter().zip(followed.prices.times()) {
        let sum = prices.entry(instruction.place.line as usize).or_default();
        sum.on += times.on;
        sum.off += times.off;
        sum.per_unit += times.per_unit;
    }
    prices
}

/// The longest scan of all, if there are not too many ways, and whether a loop's count was below 1.
fn longest(lines: &[String], prices: &BTreeMap<usize, Times>, once: bool) -> Option<(Picos, bool)> {
    let files = [lines.iter().map(|text| line(text)).collect::<Vec<Line>>()];
    let mut every = Every { once, ..Every::default() };
    let mut most = Picos::ZERO;
    for _ in 0..MAX_WAYS {
        let executed = Plc::new(&files, &mut every, Vec::new()).scan();
        let cost = |(_, line, on, units): &Executed| {
            let times = prices.get(line).copied().unwrap_or_default();
            if *on { times.with(*units) } else { times.off }
        };
        most = most.max(executed.iter().map(cost).sum());
        if !every.advance() {
            return Some((most, every.asked));
        }
    }
    None
}

/// How many programs were tried, and of how many the bound was exact.
#[derive(Default)]
struct Tally {
    tried: u32,
    doubtful: u32,
    exact: u32,
    short: u32,
}

fn check(
    tape: &[u16],
    generate: fn(&mut Tape<'_>) -> Vec<String>,
    facts: &Facts,
    tally: &RefCell<Tally>,
) -> Result<(), String> {
    let mut tape = Tape::new(tape);
    let lines = generate(&mut tape);
    let text = lines.join("\n") + "\n";
    let table = table(&rows(&mut tape));
    let found = match audited("melsec-list", None, &[("a.txt", &text)], &table, facts) {
        Ok(found) => found,
        // Three loops of unknown counts in each other are refused.
        Err(why) if why.contains("more often than can be counted") => return Ok(()),
        Err(why) => return Err(format!("{why}\n{text}")),
    };
    let prices = prices(&found.followed);
    let longest = |once| longest(&lines, &prices, once);
    let Some((one, asked)) = longest(true) else { return Ok(()) };
    let none = if asked { longest(false).map(|(none, _)| none) } else { Some(one) };
    let Some(none) = none else { return Ok(()) };
    let bound = &found.audit.bound;
    let (upper, lower) = (bound.upper.0 - bound.overhead.0, bound.lower.0 - bound.overhead.0);
    let told = |what: &str| {
        let priced: Vec<String> = lines
            .iter()
            .enumerate()
            .map(|(at, line)| {
                format!("{line:24} {:?}", prices.get(&(at + 1)).copied().unwrap_or_default())
            })
            .collect();
        Err(format!(
            "{what}: upper {upper}, longest {} or {}, lower {lower}\n{}\n{:?}",
            one.0,
            none.0,
            priced.join("\n"),
            found.audit.stands_between
        ))
    };
    if upper < one.0.max(none.0) {
        return told("the bound is too low");
    }
    if lower > one.0.min(none.0) {
        return told("no scan takes as long as the lower bound");
    }
    if bound.exact() && upper != one.0 {
        return told("the bound is no exact one");
    }
    let mut tally = tally.borrow_mut();
    tally.tried += 1;
    tally.doubtful += u32::from(asked);
    tally.exact += u32::from(bound.exact());
    if !asked && lower < one.0 {
        tally.short += 1;
        if std::env::var("SCANBOUND_STRICT").is_ok() {
            return told("the lower bound is not the longest scan");
        }
    }
    Ok(())
}

#[test]
#[allow(clippy::print_stdout)] // a long run's figures
fn lower_bounds_are_what_a_plc_takes_at_most() {
    let tally = RefCell::new(Tally::default());
    on_tapes(cases(40), 120, |tape| check(tape, generate, &Facts::default(), &tally));
    let Tally { tried, doubtful, exact, short } = tally.into_inner();
    println!("{tried} tried, {doubtful} with a count below 1, {exact} exact, {short} short");
    // SCANBOUND_STRICT shows the first program that falls short.
    assert!(tried * 3 >= cases(40), "{tried} tried");
    assert!(exact * 10 >= tried * 9 && short * 50 <= tried, "{exact} exact, {short} short");
}

#[test]
#[allow(clippy::print_stdout)] // a long run's figures
fn what_is_reached_by_index_is_what_a_plc_reaches() {
    let tally = RefCell::new(Tally::default());
    let ranges = [("D0".to_owned(), (0, 7))].into();
    let facts = Facts { ranges, ..Facts::default() };
    on_tapes(cases(60), 120, |tape| check(tape, indexed, &facts, &tally));
    let Tally { tried, exact, short, .. } = tally.into_inner();
    println!("{tried} tried, {exact} exact, {short} short");
    assert!(tried * 2 >= cases(60), "{tried} tried");
    assert!(exact * 10 >= tried * 9 && short * 20 <= tried, "{exact} exact, {short} short");
}
