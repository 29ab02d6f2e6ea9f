//! Searches for the longest scan by running the interpreter: with all free values if they are few, otherwise
//! with random ones.

use super::bound::Bound;
use scanbound::base::time::{Picos, Times};
use scanbound::program::{
    AreaKind, Cell, ChoiceKey, Compare, Logic, Number, Program, Step, WordSource, Write,
};
use scanbound::replay::{FreeValues, Replay, replay, replay_with};
use std::collections::{BTreeMap, BTreeSet};

#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub enum Question {
    Start(Cell),
    Choice(ChoiceKey),
}

/// Enumerates all sequences of answers to the interpreter's questions.
struct Path<'a> {
    words: &'a [u16],
    /// For each question: the number of options and the chosen one.
    taken: Vec<(usize, usize)>,
    at: usize,
    answered: BTreeMap<Question, u16>,
}

impl Path<'_> {
    fn answer(&mut self, question: Question, kind: AreaKind) -> u16 {
        if let Some(answer) = self.answered.get(&question) {
            return *answer;
        }
        let options = if kind == AreaKind::Bit { &[0, 1][..] } else { self.words };
        if self.at == self.taken.len() {
            self.taken.push((options.len(), 0));
        }
        let answer = options[self.taken[self.at].1];
        self.at += 1;
        self.answered.insert(question, answer);
        answer
    }

    /// The next path in depth-first order, if there is one.
    fn advance(&mut self) -> bool {
        self.at = 0;
        self.answered.clear();
        while let Some((options, taken)) = self.taken.pop() {
            if taken + 1 < options {
                self.taken.push((options, taken + 1));
                return true;
            }
        }
        false
    }
}

impl FreeValues for &mut Path<'_> {
    fn start(&mut self, cell: Cell, kind: AreaKind) -> u16 {
        self.answer(Question::Start(cell), kind)
    }

    fn choice(&mut self, key: &ChoiceKey, kind: AreaKind) -> u16 {
        self.answer(Question::Choice(key.clone()), kind)
    }
}

/// Answers at random, but always the same to the same question.
struct Dice<'a> {
    words: &'a [u16],
    state: u64,
    answered: BTreeMap<Question, u16>,
}

impl Dice<'_> {
    fn answer(&mut self, question: Question) -> u16 {
        if let Some(answer) = self.answered.get(&question) {
            return *answer;
        }
        // splitmix64
        self.state = self.state.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.state;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^= z >> 31;
        let answer = match z % 8 {
            0 => (z >> 16) as u16,
            _ => self.words[(z >> 32) as usize % self.words.len()],
        };
        // Bits are taken from bit 0, so it must be random for all words.
        let answer = if (z >> 8) & 7 == 0 { answer ^ 1 } else { answer };
        self.answered.insert(question, answer);
        answer
    }
}

impl FreeValues for &mut Dice<'_> {
    fn start(&mut self, cell: Cell, kind: AreaKind) -> u16 {
        let answer = self.answer(Question::Start(cell));
        if kind == AreaKind::Bit { answer & 1 } else { answer }
    }

    fn choice(&mut self, key: &ChoiceKey, _kind: AreaKind) -> u16 {
        self.answer(Question::Choice(key.clone()))
    }
}

/// The words that are tried: every constant of the program with its neighbours, and the ends of all number ranges.
pub fn words(program: &Program) -> Vec<u16> {
    let mut found = BTreeSet::from([0, 1, 0x7FFF, 0x8000, 0xFFFF]);
    for range in &program.stated_ranges {
        for end in [range.low, range.high] {
            found.extend([end as u16, (end >> 16) as u16]);
        }
    }
    let mut constants = BTreeSet::new();
    for instruction in &program.instructions {
        match &instruction.step {
            Step::Logic { value: logic, .. }
            | Step::Act { fires: logic }
            | Step::Jump { fires: logic, .. }
            | Step::Call { fires: logic, .. }
            | Step::Stop { fires: logic }
            | Step::MasterControlBegin { fires: logic, .. } => in_logic(logic, &mut constants),
            Step::ForBegin { least, most, .. } => {
                constants.extend([*least as u16, *most as u16]);
            }
            _ => {}
        }
        if let Some(counted) = instruction.counted() {
            constants.insert(counted.most as u16);
        }
        for effect in &instruction.effects {
            match &effect.write {
                Write::Bit(_, logic) => in_logic(logic, &mut constants),
                Write::Words(_, number) => in_number(number, &mut constants),
                Write::Havoc(..) => {}
            }
        }
    }
    for constant in constants {
        found.extend([constant.wrapping_sub(1), constant, constant.wrapping_add(1)]);
    }
    found.into_iter().collect()
}

fn in_logic(logic: &Logic, found: &mut BTreeSet<u16>) {
    match logic {
        Logic::Not(inner) => in_logic(inner, found),
        Logic::All(parts) | Logic::Any(parts) => {
            parts.iter().for_each(|part| in_logic(part, found));
        }
        Logic::Compare(compare) => {
            let Compare { left, right, .. } = &**compare;
            in_number(left, found);
            in_number(right, found);
        }
        Logic::Condition | Logic::Const(_) | Logic::Bit(_) => {}
    }
}

fn in_number(number: &Number, found: &mut BTreeSet<u16>) {
    match number {
        Number::Words(sources) => found.extend(sources.iter().filter_map(|source| match source {
            WordSource::Const(value) => Some(*value),
            _ => None,
        })),
        Number::Add(a, b)
        | Number::Sub(a, b)
        | Number::And(a, b)
        | Number::Or(a, b)
        | Number::Xor(a, b) => {
            in_number(a, found);
            in_number(b, found);
        }
    }
}

/// The result of a search.
pub struct Found {
    /// The longest scan found.
    pub most: Picos,
    /// Whether all combinations of the tried values were run.
    pub complete: bool,
    pub runs: usize,
}

/// Runs the program with every combination of the tried values, or with the first `cap` and as many random
/// ones. Fails at the first scan for which `check` returns an error. Scans outside the stated ranges are ignored.
pub fn search(
    program: &Program,
    times: &[Times],
    cap: usize,
    check: impl Fn(&Replay, &BTreeMap<Question, u16>) -> Result<(), String>,
) -> Result<Found, String> {
    let words = words(program);
    let mut found = Found { most: Picos::ZERO, complete: true, runs: 0 };
    let mut path = Path { words: &words, taken: Vec::new(), at: 0, answered: BTreeMap::new() };
    loop {
        let replay = replay_with(program, times, &mut path);
        found.runs += 1;
        if replay.broken_ranges.is_empty() {
            check(&replay, &path.answered)?;
            found.most = found.most.max(replay.total);
        }
        if !path.advance() {
            return Ok(found);
        }
        if found.runs >= cap {
            break;
        }
    }
    found.complete = false;
    for state in 0..cap as u64 {
        let mut dice = Dice { words: &words, state, answered: BTreeMap::new() };
        let replay = replay_with(program, times, &mut dice);
        found.runs += 1;
        if replay.broken_ranges.is_empty() {
            check(&replay, &dice.answered)?;
            found.most = found.most.max(replay.total);
        }
    }
    Ok(found)
}

/// Whether the bound is correct and reached: no scan found takes longer, and its witness takes exactly this time.
pub fn holds(
    program: &Program,
    times: &[Times],
    bound: &Bound,
    cap: usize,
) -> Result<Found, String> {
    if bound.lower != bound.upper {
        return Err(format!("not exact: {:?} to {:?}", bound.lower, bound.upper));
    }
    let reached = replay(program, times, &bound.best);
    if !reached.broken_ranges.is_empty() {
        return Err(format!("the witness is outside the stated ranges: {:?}", bound.best));
    }
    if reached.total != bound.upper {
        return Err(format!(
            "the bound is {:?}, its witness costs {:?}: {:?}\n{}",
            bound.upper,
            reached.total,
            bound.best,
            told(&reached)
        ));
    }
    none_above(program, times, bound.upper, cap)
}

/// Whether no scan found takes longer than the bound.
pub fn none_above(
    program: &Program,
    times: &[Times],
    upper: Picos,
    cap: usize,
) -> Result<Found, String> {
    search(program, times, cap, |replay, answered| {
        if replay.total <= upper {
            return Ok(());
        }
        Err(format!(
            "the bound is {upper:?}, but a scan costs {:?}: {answered:?}\n{}",
            replay.total,
            told(replay)
        ))
    })
}

/// The executions of a scan as text, one in each line.
pub fn told(replay: &Replay) -> String {
    let line = |event: &scanbound::replay::Event| {
        let frames: Vec<String> =
            event.frames.iter().map(|frame| format!("{}.{}", frame.at, frame.iteration)).collect();
        let on = if event.fired { "on" } else { "off" };
        format!("  {} [{}] {on} {:?}", event.instruction, frames.join(" "), event.cost)
    };
    replay.events.iter().map(line).collect::<Vec<_>>().join("\n")
}
