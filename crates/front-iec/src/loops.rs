//! Loops, and how often they go round.

use super::assembler::Assembler;
use super::emit::Emit;
use super::expr::read;
use super::mixed::{below_zero, mixed};
use super::reach::alike;
use super::resolve::{Context, Found};
use super::statement::Ways;
use super::types::{DINT, Kind, Ty};
use super::value::{Value, constant};
use super::within::{calls, variables};
use scanbound_base::code::Code;
use scanbound_iec::ast::{Expr, Kind as Statements, Operator, Path, Statement};
use scanbound_iec::fault::Fault;
use scanbound_iec::show;
use scanbound_ir::{
    Compare, Logic, Number, NumberFormat, Relation, Step, WordSource, WordTarget, Write,
};
use std::collections::BTreeMap;

/// The most turns that are followed.
pub(super) const MOST: i64 = i16::MAX as i64;

/// How often a loop goes round.
pub(super) struct Turns {
    pub(super) count: WordSource,
    pub(super) least: u32,
    pub(super) most: u32,
}

impl Turns {
    pub(super) fn exactly(turns: u16) -> Turns {
        let count = WordSource::Const(turns);
        Turns { count, least: turns.into(), most: turns.into() }
    }
}

/// With which value a loop begins.
enum First {
    Known(i64),
    Value(Value),
    /// That which its variable holds.
    Held,
}

/// A variable that a loop counts up or down until it has passed an end.
struct Counting {
    variable: Path,
    /// The last value with which the loop goes on is so far from this.
    end: Expr,
    far: i64,
    by: i64,
    /// Whether it ends only where the variable is just beyond the end: from further on it goes round through all values.
    only_there: bool,
}

impl Emit<'_> {
    /// `FOR`
    pub(super) fn counted(
        &mut self,
        at: &Context,
        variable: &Path,
        (from, to, by): (&Expr, &Expr, Option<&Expr>),
        body: &[Statement],
        line: u32,
        ways: &mut Ways,
    ) -> Result<(), Fault> {
        let by = by.map_or(Some(1), |by| self.constant(at, by)).filter(|&by| by != 0);
        let Some(by) = by else {
            return Err(Fault::new(line, "the step of FOR is no constant")
                .code(Code::LoopCount)
                .help("write a number"));
        };
        if self.may_write(at, body, variable) {
            let message = format!("the loop writes to its own variable {}", show::path(variable));
            let help = "use EXIT to leave a loop, and a variable that nothing called in it writes";
            return Err(Fault::new(line, message).code(Code::LoopCount).help(help));
        }
        if self.names_own(at, to, variable, line)? {
            let message = format!("the end of FOR names its own variable {}", show::path(variable));
            let help = "some controllers work the end out once, others before every turn: assign it to another variable";
            return Err(Fault::new(line, message).code(Code::LoopCount).help(help));
        }
        self.end_stays(at, to, body, line)?;
        let first = self.first_of(at, variable, from, line)?;
        let turns = self.turns(at, variable, (first, to, by), (0, 0), line)?;
        if turns.most == 0 {
            self.cost(&["FOR"], "loop");
            return Ok(());
        }
        let begin = self.begin_loop(&turns, Some("FOR"));
        let out = self.around(at, body, ways);
        self.at(line, "END_FOR");
        self.landing();
        let now = self.value(at, &Expr::Variable(variable.clone()), line)?;
        let next = self.combined(Operator::Add, now, Value::Constant(by), line)?;
        self.assign(at, variable, next, line)?;
        // Some controllers work the end out before each turn.
        if self.constant(at, to).is_none() && !matches!(to, Expr::Variable(_)) {
            self.value(at, to, line)?;
        }
        self.close_loop(begin, "END_FOR");
        self.left_behind(at, variable, by, &turns, line)?;
        self.leave_loop(out);
        Ok(())
    }

    /// Gives a loop's variable its first value; that value, or none where it is what the variable holds then: one of another type
    /// does not hold all, and another task may write it at once.
    fn first_of(
        &mut self,
        at: &Context,
        variable: &Path,
        from: &Expr,
        line: u32,
    ) -> Result<First, Fault> {
        let (_, range) = self.range_of(at, variable, line)?;
        let value = self.open_value(at, from, line)?;
        let value = self.frozen(value);
        let fits = match &value {
            Value::Number(Kind::Whole { bits: bits @ ..=32, signed }, _) => {
                let (least, most) = whole_range(*bits, *signed);
                range.0 <= least && most <= range.1
            }
            _ => false,
        };
        self.assign(at, variable, value.clone(), line)?;
        if self.tasks > 1 && self.is_reached(at, variable, true) {
            return Ok(First::Held);
        }
        let known = self.constant(at, from).filter(|from| (range.0..=range.1).contains(from));
        Ok(match known {
            Some(known) => First::Known(known),
            None if fits => First::Value(value),
            None => First::Held,
        })
    }

    /// Behind a loop, its variable is beyond the end, or holds the last value with which it went round: controllers differ.
    fn left_behind(
        &mut self,
        at: &Context,
        variable: &Path,
        by: i64,
        turns: &Turns,
        line: u32,
    ) -> Result<(), Fault> {
        let Found::Place(place) = self.find(at, variable, line)? else { return Ok(()) };
        let Some(cell) = place.tag.cell() else { return Ok(()) };
        let kept = self.bit_between();
        let either = self.unsettled(kept);
        self.write(vec![either]);
        let mut goes_back = vec![Logic::cell(kept)];
        if turns.least == 0 {
            goes_back.push(Logic::Compare(Box::new(Compare {
                relation: Relation::Greater,
                format: NumberFormat::Signed,
                left: Number::Words(vec![turns.count]),
                right: constant(0, 1),
            })));
        }
        let Value::Number(kind, now) = read(cell, &place.ty) else { return Ok(()) };
        let by = constant(by, kind.words());
        let last = self.arithmetic(Operator::Subtract, kind, now, by)?;
        let writes = self.writes(Found::Place(place), last, line)?;
        self.write_if(Logic::All(goes_back), writes, None);
        Ok(())
    }

    /// `WHILE`
    pub(super) fn while_true(
        &mut self,
        at: &Context,
        condition: &Expr,
        body: &[Statement],
        line: u32,
        ways: &mut Ways,
    ) -> Result<(), Fault> {
        let (turns, is_stated) = self.turns_while(at, (condition, true), body, 0, line)?;
        let begin = self.begin_loop(&turns, None);
        let goes_on = self.bit(at, condition, line)?;
        let leave = self.jump(goes_on.not(), Some(Assembler::key(&["JMP"], "jump")));
        let out = self.around(at, body, ways);
        self.at(line, "END_WHILE");
        self.end_loop(begin, "JMP", Vec::new());
        // The test that ends it, where it has gone round as often as it can.
        let goes_on = self.bit(at, condition, line)?;
        self.cost(&["JMP"], "jump");
        if is_stated {
            self.ends_here(goes_on);
        }
        for jump in [leave].into_iter().chain(out) {
            self.land(jump);
        }
        self.landing();
        Ok(())
    }

    /// `REPEAT`
    pub(super) fn repeated(
        &mut self,
        at: &Context,
        body: &[Statement],
        until: &Expr,
        line: u32,
        ways: &mut Ways,
    ) -> Result<(), Fault> {
        let (turns, is_stated) = self.turns_while(at, (until, false), body, 1, line)?;
        let begin = self.begin_loop(&turns, None);
        let mut out = self.around(at, body, ways);
        self.at(line, "END_REPEAT");
        let ends = self.bit(at, until, line)?;
        out.push(self.jump(ends, Some(Assembler::key(&["JMP"], "jump"))));
        self.close_loop(begin, "JMP");
        if is_stated {
            self.ends_here(Logic::Const(true));
        }
        self.leave_loop(out);
        Ok(())
    }

    /// How often WHILE or REPEAT goes round, and whether that is only stated: by what it counts, by EXIT or RETURN at the end of
    /// each turn, or as stated.
    fn turns_while(
        &mut self,
        at: &Context,
        (condition, while_true): (&Expr, bool),
        body: &[Statement],
        fewest: u32,
        line: u32,
    ) -> Result<(Turns, bool), Fault> {
        if ends_in_first_turn(body) {
            return Ok((Turns::exactly(1), false));
        }
        let counting = self.counting(at, condition, while_true, body, line);
        if counting.is_err()
            && let Some(most) = self.most_stated(fewest, line)?
        {
            return Ok((Turns::exactly(most), true));
        }
        match counting {
            Ok(counting) => Ok((self.turns_of(at, &counting, fewest, line)?, false)),
            Err(_) if self.is_incomplete => Ok((self.any_turns(fewest, line), false)),
            Err(fault) => Err(fault),
        }
    }

    fn most_stated(&self, fewest: u32, line: u32) -> Result<Option<u16>, Fault> {
        let names = super::foreign::names(&self.project.files, self.file);
        most_stated(&self.stated_turns, names, fewest, line)
    }

    /// How often a loop goes round that counts a variable, but at least so often.
    fn turns_of(
        &mut self,
        at: &Context,
        counting: &Counting,
        fewest: u32,
        line: u32,
    ) -> Result<Turns, Fault> {
        let Counting { variable, end, far, by, only_there } = counting;
        if *only_there {
            let from = Expr::Variable(variable.clone());
            // A loop that is carried out before it is tested begins one step further on.
            let (first, beyond) = match (fewest, *by > 0) {
                (0, true) => (Operator::Greater, *by),
                (0, false) => (Operator::Less, *by),
                (_, true) => (Operator::Greater, 0),
                (_, false) => (Operator::Less, 0),
            };
            let start = self.value(at, &from, line)?;
            let last = self.value(at, end, line)?;
            let last = match last {
                Value::Number(Kind::Whole { bits: ..32, .. }, _) => {
                    Value::Number(DINT, self.as_number(last, DINT, line)?)
                }
                last => last,
            };
            let last = self.combined(Operator::Add, last, Value::Constant(far + beyond), line)?;
            let beyond = self.holds(first, start, last, line)?;
            self.without_end(beyond);
        }
        self.turns(at, variable, (First::Held, end, *by), (*far, fewest), line)
    }

    /// The body of a loop; gives the jumps out of it.
    fn around(&mut self, at: &Context, body: &[Statement], ways: &mut Ways) -> Vec<usize> {
        ways.loops.push([Vec::new(), Vec::new()]);
        self.statements(at, body, ways);
        let [again, out] = ways.loops.pop().unwrap_or_default();
        for jump in again {
            self.land(jump);
        }
        self.landing();
        out
    }

    /// How often a variable goes from one value to another, or one so far from that, by steps, but at least so often. It has no end where the variable,
    /// beyond its end, would be beyond what its type holds: it begins anew there.
    fn turns(
        &mut self,
        at: &Context,
        variable: &Path,
        (from, to, by): (First, &Expr, i64),
        (far, fewest): (i64, u32),
        line: u32,
    ) -> Result<Turns, Fault> {
        let (held, range) = self.range_of(at, variable, line)?;
        let endless = |what: String| {
            Err(Fault::new(line, what)
                .code(Code::LoopCount)
                .help("give it a variable of a larger type, or fewer turns"))
        };
        let end = self.constant(at, to);
        if !held.is_signed() && end.is_some_and(|end| end < 0) {
            return endless(format!(
                "{} has no sign and the end of the loop is below 0: some controllers take that as a very large number",
                show::path(variable)
            ));
        }
        let end = end.and_then(|to| to.checked_add(far));
        if let (First::Known(from), Some(to)) = (&from, end) {
            let from = *from;
            let none = (by > 0 && from > to) || (by < 0 && from < to);
            let turns = if none { 0 } else { i128::from(to - from).div_euclid(by.into()) + 1 };
            let last = i128::from(from) + turns * i128::from(by);
            if turns > 0 && !(i128::from(range.0)..=i128::from(range.1)).contains(&last) {
                return endless(format!(
                    "{} cannot go beyond {to}, the end of the loop: it would go round for ever",
                    show::path(variable)
                ));
            }
            let turns = turns.max(fewest.into());
            return match u16::try_from(turns).ok().filter(|turns| i64::from(*turns) <= MOST) {
                Some(turns) => Ok(Turns {
                    count: WordSource::Const(turns),
                    least: turns.into(),
                    most: turns.into(),
                }),
                None => endless(format!("the loop goes round {turns} times")),
            };
        }
        let mut ends = Vec::new();
        let from = match from {
            First::Known(value) => Value::Constant(value),
            First::Value(value) => value,
            First::Held => self.value(at, &Expr::Variable(variable.clone()), line)?,
        };
        let to_named = to;
        let to = self.value(at, to, line)?;
        let is_longest = matches!(held, Kind::Whole { bits: 64, signed: false });
        let crosses = matches!(&to, Value::Number(kind, _)
            if mixed(held, *kind).is_some() || (is_longest && kind.is_signed()));
        for (value, far) in [(from, 0), (to, far)] {
            if let Value::Number(Kind::Whole { bits, signed }, _) = value
                && (bits > 32 || (bits == 32 && !signed))
            {
                return endless("the ends of the loop have more than 31 bits".to_owned());
            }
            // A short one is kept as it is: what is known of its one word says more than what is known of two.
            let is_short =
                matches!(value, Value::Number(Kind::Whole { bits: ..=16, .. }, _)) && !crosses;
            let value = match value {
                Value::Number(kind, number) if is_short => {
                    Value::Number(kind, Number::Words(self.copied(number, kind.words())))
                }
                value => value,
            };
            let mut number = self.as_number(value, DINT, line)?;
            if crosses {
                // Some controllers take it as a very large one.
                number = Number::Words(self.copied(number, 2));
                self.without_end(below_zero(DINT, &number));
            }
            if far != 0 {
                number = Number::Add(Box::new(number), Box::new(constant(far, 2)));
            }
            ends.push(match is_short {
                true => number,
                false => Number::Words(self.copies(number, DINT)),
            });
        }
        let number = |number: &Number| Value::Number(DINT, number.clone());
        let (high, low) = if by > 0 { (&ends[1], &ends[0]) } else { (&ends[0], &ends[1]) };
        let last = number(&ends[1]);
        let [high_value, low_value] = [high, low].map(number);
        let difference = Number::Sub(Box::new(high.clone()), Box::new(low.clone()));
        let apart = self.copies(difference.clone(), DINT);
        // How often it goes on behind its first turn, and the value with which it goes round last.
        let (more, last) = match by.abs() {
            1 => (difference, last),
            step => {
                let mut parts = Vec::new();
                for operator in [Operator::Divide, Operator::Modulo] {
                    let steps = constant(step, 2);
                    match self.arithmetic(operator, DINT, difference.clone(), steps)? {
                        Value::Number(_, part) => parts.push(Box::new(part)),
                        _ => return endless("the loop's count is not followed".to_owned()),
                    }
                }
                let end = Box::new(ends[1].clone());
                let (Some(short), Some(more)) = (parts.pop(), parts.pop()) else {
                    return endless("the loop's count is not followed".to_owned());
                };
                let last = if by > 0 { Number::Sub(end, short) } else { Number::Add(end, short) };
                (*more, Value::Number(DINT, last))
            }
        };
        let count = Number::Add(Box::new(more), Box::new(constant(1, 2)));
        // A count of more than 16 bits is the largest there is: beyond that, nothing is bounded. A difference that does not
        // fit 31 bits comes out below 0.
        let words = self.copies(count, DINT);
        let counted = Value::Number(DINT, Number::Words(words.clone()));
        let none = self.holds(Operator::Less, high_value, low_value, line)?;
        let limit = self.holds(Operator::Greater, counted, Value::Constant(MOST), line)?;
        let apart = Value::Number(DINT, Number::Words(apart));
        let wraps = self.holds(Operator::Less, apart, Value::Constant(0), line)?;
        let ever = if by > 0 {
            self.holds(Operator::Greater, last, Value::Constant(range.1 - by), line)?
        } else {
            self.holds(Operator::Less, last, Value::Constant(range.0 - by), line)?
        };
        let endless = Logic::Any(vec![limit, wraps, ever]);
        let beyond = Logic::All(vec![none.clone().not(), endless]);
        self.without_end(beyond);
        if let WordSource::Cell(cell) = words[0] {
            let name = format!("the turns up to {}", self.shown_end(at, to_named));
            self.program().names.insert(cell, name);
            let fewest = constant(fewest.into(), 1);
            let write = Write::Words(vec![WordTarget::Cell(cell)], fewest);
            self.write_if(none, vec![write], None);
        }
        Ok(Turns { count: words[0], least: 0, most: i16::MAX.cast_unsigned().into() })
    }

    /// The end of a loop, by its full name where it is a variable.
    fn shown_end(&mut self, at: &Context, end: &Expr) -> String {
        if let Expr::Variable(path) = end
            && let Ok(Found::Place(place)) = self.find(at, path, 0)
        {
            return place.name;
        }
        show::expr(end)
    }

    /// The type of a loop's variable, and what it can hold.
    fn range_of(
        &mut self,
        at: &Context,
        variable: &Path,
        line: u32,
    ) -> Result<(Kind, (i64, i64)), Fault> {
        let of = |ty: &Ty| match ty {
            Ty::Number(kind @ Kind::Whole { bits: bits @ ..=32, signed }) => {
                Some((*kind, whole_range(*bits, *signed)))
            }
            // More than any count that is followed.
            Ty::Number(kind @ Kind::Whole { signed, .. }) => {
                Some((*kind, (if *signed { -(1 << 40) } else { 0 }, 1 << 40)))
            }
            _ => None,
        };
        let found = match self.find(at, variable, line)? {
            Found::Place(place) => of(&place.ty),
            Found::Element(element) => of(&element.place.ty),
            _ => None,
        };
        found.ok_or_else(|| {
            let message = format!("{} counts a loop and is no whole number", show::path(variable));
            Fault::new(line, message).code(Code::LoopCount).help("declare it as INT or DINT")
        })
    }

    /// Refuses an end that the loop itself may move.
    fn end_stays(
        &self,
        at: &Context,
        end: &Expr,
        body: &[Statement],
        line: u32,
    ) -> Result<(), Fault> {
        if self.constant(at, end).is_some() {
            return Ok(());
        }
        let mut moved = calls(self.project, end).then(|| show::expr(end));
        variables(end, &mut |path| {
            if moved.is_none() && self.may_write(at, body, path) {
                moved = Some(show::path(path));
            }
        });
        match moved {
            None => Ok(()),
            Some(what) => {
                let message = format!("the loop may move its own end: it writes or calls {what}");
                let help = "put the end into a variable that nothing in the loop writes";
                Err(Fault::new(line, message).code(Code::LoopCount).help(help))
            }
        }
    }

    /// What a loop counts that goes on while (or until) a condition holds: a variable that is compared with an end, and that
    /// one statement of the body, which every turn comes to, moves by a constant.
    fn counting(
        &mut self,
        at: &Context,
        condition: &Expr,
        while_true: bool,
        body: &[Statement],
        line: u32,
    ) -> Result<Counting, Fault> {
        let mut parts = Vec::new();
        joined(condition, if while_true { Operator::And } else { Operator::Or }, &mut parts);
        let leaves = |one: &Statement| {
            matches!(one.kind, Statements::Continue | Statements::Jump(..) | Statements::Label(_))
        };
        let mut skips = false;
        scanbound_iec::ast::visit(body, &mut |one| skips |= leaves(one));
        let parts = parts.into_iter().filter(|_| !skips);
        let mut candidates: Vec<_> = parts.flat_map(|part| compared(part, while_true)).collect();
        // What ends a loop only at one value is taken where nothing else does.
        candidates.sort_by_key(|(_, operator, _)| *operator == Operator::NotEqual);
        for (path, operator, end) in candidates {
            let mut steps = body
                .iter()
                .enumerate()
                .filter_map(|(number, one)| Some((number, self.step_of(at, one, path)?)));
            let (Some((number, by)), None) = (steps.next(), steps.next()) else { continue };
            let rest = [&body[..number], &body[number + 1..]].concat();
            let only_there = operator == Operator::NotEqual;
            let upwards = match only_there {
                true => by > 0,
                false => matches!(operator, Operator::Less | Operator::LessOrEqual),
            };
            if upwards != (by > 0)
                || (only_there && (by.abs() != 1 || !self.is_wide(at, path, line)))
                || self.may_write(at, &rest, path)
                || self.end_stays(at, end, body, line).is_err()
            {
                continue;
            }
            let far = match operator {
                Operator::Less => -1,
                Operator::Greater => 1,
                Operator::NotEqual if by > 0 => -1,
                Operator::NotEqual => 1,
                _ => 0,
            };
            return Ok(Counting { variable: path.clone(), end: end.clone(), far, by, only_there });
        }
        let file = self.project.files.get(self.file).map_or("", String::as_str);
        Err(not_known(file, u8::from(!while_true), line))
    }

    /// Whether a variable has so many values that no loop that is followed goes through all of them.
    fn is_wide(&mut self, at: &Context, variable: &Path, line: u32) -> bool {
        self.range_of(at, variable, line).is_ok_and(|(_, (least, most))| most - least > MOST)
    }

    /// By how much a statement moves a variable: `i := i + 1`.
    fn step_of(&self, at: &Context, one: &Statement, variable: &Path) -> Option<i64> {
        let Statements::Assign(target, Expr::Binary(operator, left, right)) = &one.kind else {
            return None;
        };
        let is_own = |one: &Expr| matches!(one, Expr::Variable(path) if alike(path, variable));
        let by = match operator {
            Operator::Add if is_own(left) => self.constant(at, right),
            Operator::Add if is_own(right) => self.constant(at, left),
            Operator::Subtract if is_own(left) => self.constant(at, right)?.checked_neg(),
            _ => None,
        };
        by.filter(|by| *by != 0 && alike(target, variable))
    }
}

impl Assembler {
    /// A loop of which nothing is known is taken to go round any number of times: what is found then is no bound.
    pub(super) fn any_turns(&mut self, fewest: u32, line: u32) -> Turns {
        let cell = self.words_between(1);
        let choice = self.builder.choice();
        let any = Number::Words(vec![WordSource::Free(choice)]);
        self.write(vec![Write::Words(vec![WordTarget::Cell(cell)], any)]);
        let name = format!("the turns of the loop in line {line}");
        self.program().names.insert(cell, name);
        let most = i16::MAX.cast_unsigned().into();
        Turns { count: WordSource::Cell(cell), least: fewest, most }
    }

    /// Where a condition holds, nothing is known that ends the loop that begins: its variable begins anew at the other end of
    /// its type and may yet come to a value that does, or it goes round more often than is followed.
    pub(super) fn without_end(&mut self, condition: Logic) {
        let skip = self.jump(condition.not(), None);
        let here = self.builder.next();
        self.builder.add(None, Vec::new(), Step::Unbounded { from: here, certain: false });
        self.land(skip);
        self.landing();
    }

    pub(super) fn begin_loop(&mut self, turns: &Turns, row: Option<&str>) -> usize {
        let Turns { count, least, most } = *turns;
        let key = row.map(|row| Assembler::key(&[row], "loop"));
        self.builder.add(key, Vec::new(), Step::ForBegin { count, least, most, end: 0 })
    }

    pub(super) fn close_loop(&mut self, begin: usize, row: &str) {
        let end = self.builder.add(Some(Assembler::key(&[row], "loop")), Vec::new(), Step::ForEnd);
        if let Step::ForBegin { end: own, .. } = &mut self.builder.program.instructions[begin].step
        {
            *own = end;
        }
    }

    pub(super) fn end_loop(&mut self, begin: usize, row: &str, out: Vec<usize>) {
        self.close_loop(begin, row);
        self.leave_loop(out);
    }

    /// Jumps out of a loop lead to here.
    pub(super) fn leave_loop(&mut self, out: Vec<usize>) {
        for jump in out {
            self.land(jump);
        }
        self.landing();
    }

    /// Leaves out scans in which a loop would go round once more than is stated.
    pub(super) fn ends_here(&mut self, goes_on: Logic) {
        let cell = self.words_between(1);
        let write = |value| Write::Words(vec![WordTarget::Cell(cell)], constant(value, 1));
        self.write(vec![write(0)]);
        self.write_if(goes_on, vec![write(1)], None);
        let more = Turns { count: WordSource::Cell(cell), least: 0, most: 1 };
        let begin = self.begin_loop(&more, None);
        let end = self.builder.add(None, Vec::new(), Step::ForEnd);
        let program = self.program();
        if let Step::ForBegin { end: own, .. } = &mut program.instructions[begin].step {
            *own = end;
        }
        program.stated_counts.insert(begin, (0, 0));
        program.names.insert(cell, "a turn more than is stated".to_owned());
    }

    pub(super) fn holds(
        &mut self,
        operator: Operator,
        left: Value,
        right: Value,
        line: u32,
    ) -> Result<Logic, Fault> {
        match self.combined(operator, left, right, line)? {
            Value::Bit(logic) => Ok(logic),
            _ => Err(Fault::new(line, "the loop's count is not followed").code(Code::LoopCount)),
        }
    }
}

/// The most turns that are stated of the loop in a line of a file that has these names.
pub(super) fn most_stated(
    all: &BTreeMap<String, (i64, i64)>,
    names: [&str; 2],
    fewest: u32,
    line: u32,
) -> Result<Option<u16>, Fault> {
    let stated = |name: &str| {
        all.iter().find(|(place, _)| {
            let place = place.rsplit_once(':');
            place.is_some_and(|(own, number)| {
                number.trim() == line.to_string() && own.eq_ignore_ascii_case(name)
            })
        })
    };
    let Some((place, &(low, high))) = names.into_iter().find_map(stated) else {
        return Ok(None);
    };
    let most = u16::try_from(high).ok().filter(|&most| i64::from(most) <= MOST);
    let most = most.filter(|&most| u32::from(most) >= fewest && low <= fewest.into());
    most.map(Some).ok_or_else(|| {
        let told = format!(
            "of the loop at {place} only the most turns can be stated, from {fewest} to {MOST}"
        );
        let help = format!("write [counts] \"{place}\" = [{fewest}, 10]");
        Fault::new(line, told).code(Code::Fact).help(help)
    })
}

/// The fault of a loop of which it is not known how often it goes round.
pub(super) fn not_known(file: &str, fewest: u8, line: u32) -> Fault {
    let help = "let it go on while a variable is below an end (WHILE i < 10 DO), which one statement of the loop moves \
                by a constant (i := i + 1), or write it as FOR with EXIT";
    let place = scanbound_base::facts::key(&format!("{file}:{line}"));
    let help = format!(
        "{help}; or state in a facts file (--facts) how often it goes round at most: [counts] {place} = [{fewest}, 10]"
    );
    Fault::new(line, "how often WHILE or REPEAT goes round is not known")
        .code(Code::LoopCount)
        .help(help)
}

/// How two operands are to each other while a loop goes on, and the other way round.
pub(super) fn goes_on(operator: Operator, while_true: bool) -> Option<(Operator, Operator)> {
    use Operator::{Equal, Greater, GreaterOrEqual, Less, LessOrEqual, NotEqual};
    let other = match operator {
        Equal => Equal,
        NotEqual => NotEqual,
        Less => Greater,
        LessOrEqual => GreaterOrEqual,
        Greater => Less,
        GreaterOrEqual => LessOrEqual,
        _ => return None,
    };
    let goes_on = |operator: Operator| match (while_true, operator) {
        (true, operator) => operator,
        (false, Equal) => NotEqual,
        (false, Less) => GreaterOrEqual,
        (false, LessOrEqual) => Greater,
        (false, Greater) => LessOrEqual,
        (false, NotEqual) => Equal,
        (false, _) => Less,
    };
    Some((goes_on(operator), goes_on(other)))
}

/// Whether no turn of a loop with this body is followed by another one: each comes to an EXIT or RETURN.
fn ends_in_first_turn(body: &[Statement]) -> bool {
    let leaves = |one: &Statement| match &one.kind {
        Statements::Exit => true,
        Statements::Return(condition) => condition.is(true),
        _ => false,
    };
    let Some(first) = body.iter().position(leaves) else { return false };
    let mut skips = false;
    scanbound_iec::ast::visit(&body[..first], &mut |one| {
        skips |=
            matches!(one.kind, Statements::Continue | Statements::Jump(..) | Statements::Label(_));
    });
    !skips
}

/// What a whole number of a type can be.
pub(super) fn whole_range(bits: u8, signed: bool) -> (i64, i64) {
    match signed {
        true => (-(1 << (bits - 1)), (1 << (bits - 1)) - 1),
        false => (0, (1 << bits) - 1),
    }
}

/// The parts of a condition that are joined so.
fn joined<'e>(one: &'e Expr, by: Operator, parts: &mut Vec<&'e Expr>) {
    match one {
        Expr::Binary(operator, left, right) if operator.eager() == by => {
            joined(left, by, parts);
            joined(right, by, parts);
        }
        other => parts.push(other),
    }
}

/// Variables, how they are to an end while a loop goes on, and the end.
fn compared(one: &Expr, while_true: bool) -> Vec<(&Path, Operator, &Expr)> {
    let Expr::Binary(operator, left, right) = one else { return Vec::new() };
    let Some((own, other)) = goes_on(*operator, while_true) else { return Vec::new() };
    let mut found = Vec::new();
    if let Expr::Variable(path) = &**left {
        found.push((path, own, &**right));
    }
    if let Expr::Variable(path) = &**right {
        found.push((path, other, &**left));
    }
    // A loop that goes on at one value alone says nothing of its turns.
    found.retain(|(_, operator, _)| *operator != Operator::Equal);
    found
}
