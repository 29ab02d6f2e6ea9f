//! Loops, and how often they go round.

use super::Lower;
use super::cells::Effects;
use super::decode::file_names;
use super::effects::is_same;
use super::spots::{Context, Found};
use super::statements::JumpTargets;
use crate::assembler::Assembler;
use crate::assembler::loops::{MOST, Turns, whole_range};
use crate::assembler::mixed::{below_zero, mixed};
use crate::assembler::numbers::read;
use crate::assembler::types::{DINT, Kind, Ty};
use crate::assembler::value::{Value, constant, signed};
use scanbound_base::code::Code as FaultCode;
use scanbound_iec::ast::Operator;
use scanbound_iec::fault::Fault;
use scanbound_iec_tree::tree::{
    Expr, ExprKind, ForLoop, Place, Statement, StatementKind, continues, each_statement,
};
use scanbound_ir::{Logic, Number, Relation, WordSource, WordTarget, Write};

/// With which value a loop begins.
enum First {
    Known(i64),
    Value(Value),
    /// That which its variable holds.
    Held,
}

/// A variable that a loop counts up or down until it has passed an end.
struct Counting {
    variable: Place,
    /// The last value with which the loop goes on is so far from this.
    end: Expr,
    far: i64,
    by: i64,
    /// Whether it ends only where the variable is just beyond the end: from further on it goes round through all
    /// values.
    only_there: bool,
}

fn endless<T>(line: u32, what: &str) -> Result<T, Fault> {
    Err(Fault::new(line, what)
        .code(FaultCode::LoopCount)
        .help("give it a variable of a larger type, or fewer turns"))
}

impl Lower<'_> {
    /// `FOR`
    pub(super) fn counted_loop(
        &mut self,
        at: &Context,
        own: &ForLoop,
        line: u32,
        targets: &mut JumpTargets,
    ) -> Result<(), Fault> {
        let ForLoop { variable, from, to, by, body } = own;
        let Some(by) = by.filter(|&by| by != 0) else {
            return Err(Fault::new(line, "the step of FOR is no constant")
                .code(FaultCode::LoopCount)
                .help("write a number"));
        };
        let shown = &variable.text;
        if self.may_write(at, body, variable) {
            let message = format!("the loop writes to its own variable {shown}");
            let help = "use EXIT to leave a loop, and a variable that nothing called in it writes";
            return Err(Fault::new(line, message).code(FaultCode::LoopCount).help(help));
        }
        if self.names(at, to, variable) {
            let message = format!("the end of FOR names its own variable {shown}");
            let help = "some controllers work the end out once, others before every turn: assign it to another variable";
            return Err(Fault::new(line, message).code(FaultCode::LoopCount).help(help));
        }
        self.end_stays(at, to, body, line)?;
        let first = self.first_of(at, variable, from, line)?;
        let turns = self.turns(at, variable, (first, to, by), (0, 0), line)?;
        if turns.most == 0 {
            self.cost(&["FOR"], "loop");
            return Ok(());
        }
        let begin = self.begin_loop(&turns, Some("FOR"));
        let out = self.around(at, body, targets);
        self.at(line, "END_FOR");
        self.landing();
        let now = self.held(at, variable, line)?;
        let next = self.combined(Operator::Add, now, Value::Constant(by), line)?;
        self.assign(at, variable, None, next, line)?;
        // Some controllers work the end out before each turn.
        if to.whole().is_none() && !matches!(to.kind, ExprKind::Read(_)) {
            self.value(at, to)?;
        }
        self.close_loop(begin, "END_FOR");
        self.left_behind(at, variable, by, &turns, line)?;
        self.leave_loop(out);
        Ok(())
    }

    /// The value that a variable holds.
    fn held(&mut self, at: &Context, place: &Place, line: u32) -> Result<Value, Fault> {
        let one = Expr { kind: ExprKind::Read(place.clone()), ty: place.ty, line };
        self.value(at, &one)
    }

    /// Gives a loop's variable its first value; that value, or none where it is what the variable holds then: one of
    /// another type does not hold all, and another task may write it at once.
    fn first_of(
        &mut self,
        at: &Context,
        variable: &Place,
        from: &Expr,
        line: u32,
    ) -> Result<First, Fault> {
        let from = from.unconverted();
        let (_, range) = self.range_of(at, variable, line)?;
        let value = self.open_value(at, from)?;
        let value = self.frozen(value);
        let fits = match &value {
            Value::Number(Kind::Whole { bits: bits @ ..=32, signed }, _) => {
                let (least, most) = whole_range(*bits, *signed);
                range.0 <= least && most <= range.1
            }
            _ => false,
        };
        self.assign(at, variable, None, value.clone(), line)?;
        if self.routines.tasks.len() > 1 && self.others_write(at, variable) {
            return Ok(First::Held);
        }
        let known = from.whole().filter(|from| (range.0..=range.1).contains(from));
        Ok(match known {
            Some(known) => First::Known(known),
            None if fits => First::Value(value),
            None => First::Held,
        })
    }

    /// Behind a loop, its variable is beyond the end, or holds the last value with which it went round: controllers
    /// differ.
    fn left_behind(
        &mut self,
        at: &Context,
        variable: &Place,
        by: i64,
        turns: &Turns,
        line: u32,
    ) -> Result<(), Fault> {
        let Some(spot) = self.spot(at, variable, line)? else { return Ok(()) };
        let Some(cell) = spot.tag.cell() else { return Ok(()) };
        let kept = self.bit_between();
        let either = self.unsettled(kept);
        self.write(vec![either]);
        let mut goes_back = vec![Logic::cell(kept)];
        if turns.least == 0 {
            let count = Number::Words(vec![turns.count]);
            goes_back.push(signed(Relation::Greater, count, constant(0, 1)));
        }
        let Value::Number(kind, now) = read(cell, &self.simple(&spot)) else { return Ok(()) };
        let by = constant(by, kind.words());
        let last = self.arithmetic(Operator::Subtract, kind, now, by)?;
        let writes = self.writes(Found::Spot(spot), last, line)?;
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
        targets: &mut JumpTargets,
    ) -> Result<(), Fault> {
        let (turns, is_stated) = self.turns_while(at, (condition, true), body, 0, line)?;
        let begin = self.begin_loop(&turns, None);
        let goes_on = self.bit(at, condition)?;
        let leave = self.jump(goes_on.not(), Assembler::jump_key());
        let out = self.around(at, body, targets);
        self.at(line, "END_WHILE");
        self.end_loop(begin, "JMP", Vec::new());
        // The test that ends it, where it has gone round as often as it can.
        let goes_on = self.bit(at, condition)?;
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
        targets: &mut JumpTargets,
    ) -> Result<(), Fault> {
        let (turns, is_stated) = self.turns_while(at, (until, false), body, 1, line)?;
        let begin = self.begin_loop(&turns, None);
        let mut out = self.around(at, body, targets);
        self.at(line, "END_REPEAT");
        let ends = self.bit(at, until)?;
        out.push(self.jump(ends, Assembler::jump_key()));
        self.close_loop(begin, "JMP");
        if is_stated {
            self.ends_here(Logic::Const(true));
        }
        self.leave_loop(out);
        Ok(())
    }

    /// The body of a loop; gives the jumps out of it.
    fn around(
        &mut self,
        at: &Context,
        body: &[Statement],
        targets: &mut JumpTargets,
    ) -> Vec<usize> {
        targets.loops.push([Vec::new(), Vec::new()]);
        self.statements(at, body, targets);
        let [again, out] = targets.loops.pop().unwrap_or_default();
        for jump in again {
            self.land(jump);
        }
        self.landing();
        out
    }

    /// How often WHILE or REPEAT goes round, and whether that is only stated: by what it counts, by EXIT or RETURN at
    /// the end of each turn, or as stated.
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
            && let Some(most) = self.stated_turns(fewest, line)?
        {
            return Ok((Turns::exactly(most), true));
        }
        match counting {
            Ok(counting) => Ok((self.turns_of(at, &counting, fewest, line)?, false)),
            Err(_) if self.options.is_incomplete => Ok((self.any_turns(fewest, line), false)),
            Err(fault) => Err(fault),
        }
    }

    /// The most turns that are stated of the loop in a line.
    fn stated_turns(&self, fewest: u32, line: u32) -> Result<Option<u16>, Fault> {
        let names = file_names(&self.project.files, self.file);
        crate::assembler::loops::most_stated(&self.options.stated_turns, names, fewest, line)
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
            // A loop that is carried out before it is tested begins one step further on.
            let (first, beyond) = match (fewest, *by > 0) {
                (0, true) => (Operator::Greater, *by),
                (0, false) => (Operator::Less, *by),
                (_, true) => (Operator::Greater, 0),
                (_, false) => (Operator::Less, 0),
            };
            let start = self.held(at, variable, line)?;
            let last = self.value(at, end)?;
            let last = match last {
                Value::Number(Kind::Whole { bits: ..32, .. }, _) => {
                    Value::Number(DINT, self.as_number(last, DINT))
                }
                last => last,
            };
            let last = self.combined(Operator::Add, last, Value::Constant(far + beyond), line)?;
            let beyond = self.holds(first, start, last, line)?;
            self.without_end(beyond);
        }
        self.turns(at, variable, (First::Held, end, *by), (*far, fewest), line)
    }

    /// How often a variable goes from one value to another, or one so far from that, by steps, but at least so often.
    /// It has no end where the variable, beyond its end, would be beyond what its type holds: it begins anew there.
    fn turns(
        &mut self,
        at: &Context,
        variable: &Place,
        (from, to, by): (First, &Expr, i64),
        (far, fewest): (i64, u32),
        line: u32,
    ) -> Result<Turns, Fault> {
        let to = to.unconverted();
        let (held, range) = self.range_of(at, variable, line)?;
        let end = to.whole();
        if !held.is_signed() && end.is_some_and(|end| end < 0) {
            let told = format!(
                "{} has no sign and the end of the loop is below 0: some controllers take that as a very large number",
                variable.text
            );
            return endless(line, &told);
        }
        let end = end.and_then(|to| to.checked_add(far));
        if let (First::Known(from), Some(to)) = (&from, end) {
            let from = *from;
            let none = (by > 0 && from > to) || (by < 0 && from < to);
            let turns = if none { 0 } else { i128::from(to - from) / i128::from(by) + 1 };
            let last = i128::from(from) + turns * i128::from(by);
            if turns > 0 && !(i128::from(range.0)..=i128::from(range.1)).contains(&last) {
                let told = format!(
                    "{} cannot go beyond {to}, the end of the loop: it would go round for ever",
                    variable.text
                );
                return endless(line, &told);
            }
            let turns = turns.max(fewest.into());
            return match u16::try_from(turns).ok().filter(|turns| i64::from(*turns) <= MOST) {
                Some(turns) => Ok(Turns::exactly(turns)),
                None => endless(line, &format!("the loop goes round {turns} times")),
            };
        }
        let from = match from {
            First::Known(value) => Value::Constant(value),
            First::Value(value) => value,
            First::Held => self.held(at, variable, line)?,
        };
        let last = self.value(at, to)?;
        let is_longest = matches!(held, Kind::Whole { bits: 64, signed: false });
        let crosses = matches!(&last, Value::Number(kind, _)
            if mixed(held, *kind).is_some() || (is_longest && kind.is_signed()));
        let ends = [(from, 0), (last, far)];
        let mut found = Vec::new();
        for (value, far) in ends {
            if let Value::Number(Kind::Whole { bits, signed }, _) = value
                && (bits > 32 || (bits == 32 && !signed))
            {
                return endless(line, "the ends of the loop have more than 31 bits");
            }
            found.push(self.loop_end(value, far, crosses));
        }
        let name = match &to.kind {
            ExprKind::Read(place) => match self.find(at, place, line) {
                Ok(Found::Spot(spot)) => spot.name,
                _ => "the end of the loop".to_owned(),
            },
            _ => "the end of the loop".to_owned(),
        };
        let name = format!("the turns up to {name}");
        self.counted_turns([&found[0], &found[1]], (by, range), fewest, &name, line)
    }

    /// The type of a loop's variable, and what it can hold.
    fn range_of(
        &mut self,
        at: &Context,
        variable: &Place,
        line: u32,
    ) -> Result<(Kind, (i64, i64)), Fault> {
        let of = |ty: Ty| match ty {
            Ty::Number(kind @ Kind::Whole { bits: bits @ ..=32, signed }) => {
                Some((kind, whole_range(bits, signed)))
            }
            // More than any count that is followed.
            Ty::Number(kind @ Kind::Whole { signed, .. }) => {
                Some((kind, (if signed { -(1 << 40) } else { 0 }, 1 << 40)))
            }
            _ => None,
        };
        let found = match self.find(at, variable, line)? {
            Found::Spot(spot) => of(self.simple(&spot)),
            Found::Element(element) => of(self.simple(&element.spot)),
            Found::WordBit(..) => None,
        };
        found.ok_or_else(|| {
            let name = &variable.text;
            let message = format!("{name} counts a loop and is no whole number");
            Fault::new(line, message).code(FaultCode::LoopCount).help("declare it as INT or DINT")
        })
    }

    /// Refuses an end that the loop itself may move.
    fn end_stays(
        &mut self,
        at: &Context,
        end: &Expr,
        body: &[Statement],
        line: u32,
    ) -> Result<(), Fault> {
        if end.whole().is_some() || !end.calls() && !self.may_change(at, body, end) {
            return Ok(());
        }
        let mut read = Vec::new();
        end.each(&mut |one| match &one.kind {
            ExprKind::Read(place) => read.push((one.clone(), place.text.clone())),
            ExprKind::Step(_) => read.push((one.clone(), "the step in it".into())),
            _ => {}
        });
        let what = match end.calls() {
            true => "a function".into(),
            false => {
                let moved = read.into_iter().find(|(one, _)| self.may_change(at, body, one));
                moved.map_or("what it is made of".into(), |(_, what)| what)
            }
        };
        let message = format!("the loop may move its own end: it writes or calls {what}");
        let help = "put the end into a variable that nothing in the loop writes";
        Err(Fault::new(line, message).code(FaultCode::LoopCount).help(help))
    }

    /// What a loop counts that goes on while (or until) a condition holds: a variable that is compared with an end, and
    /// that one statement of the body, which every turn comes to, moves by a constant.
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
        let mut skips = false;
        each_statement(body, &mut |one| {
            skips |= matches!(one.kind, StatementKind::Jump(..) | StatementKind::Label(_));
        });
        let parts = parts.into_iter().filter(|_| !skips);
        let mut candidates: Vec<_> = parts.flat_map(|part| compared(part, while_true)).collect();
        // What ends a loop only at one value is taken where nothing else does.
        candidates.sort_by_key(|(_, operator, _)| *operator == Operator::NotEqual);
        for (place, operator, end) in candidates {
            let mut steps = body
                .iter()
                .enumerate()
                .filter_map(|(number, one)| Some((number, step_of(one, place)?)));
            let (Some((number, by)), None) = (steps.next(), steps.next()) else { continue };
            let rest = [&body[..number], &body[number + 1..]].concat();
            let only_there = operator == Operator::NotEqual;
            let upwards = match only_there {
                true => by > 0,
                false => matches!(operator, Operator::Less | Operator::LessOrEqual),
            };
            if upwards != (by > 0)
                || (only_there && (by.abs() != 1 || !self.is_wide(at, place, line)))
                || continues(&body[..number])
                || self.may_write(at, &rest, place)
                || self.end_stays(at, end, body, line).is_err()
                || self.moves_what_it_compares(at, condition, (place, end))
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
            return Ok(Counting { variable: place.clone(), end: end.clone(), far, by, only_there });
        }
        let file = self.project.files.get(self.file).map_or("", String::as_str);
        Err(crate::assembler::loops::not_known(file, u8::from(!while_true), line))
    }

    /// Whether what a condition calls may write the variable or the end that it compares.
    fn moves_what_it_compares(
        &mut self,
        at: &Context,
        condition: &Expr,
        (variable, end): (&Place, &Expr),
    ) -> bool {
        let (mut called, mut compared) = (Effects::default(), Effects::default());
        self.of_expr(at, condition, &mut called);
        self.looked_at(at, variable, &mut compared);
        self.of_expr(at, end, &mut compared);
        called.changes(&compared)
    }

    /// Whether a variable has so many values that no loop that is followed goes through all of them.
    fn is_wide(&mut self, at: &Context, variable: &Place, line: u32) -> bool {
        self.range_of(at, variable, line).is_ok_and(|(_, (least, most))| most - least > MOST)
    }
}

impl Assembler {
    /// An end of a loop as a number.
    fn loop_end(&mut self, value: Value, far: i64, crosses: bool) -> Number {
        // A short one is kept as it is: what is known of its one word says more than what is known of two.
        let is_short =
            matches!(value, Value::Number(Kind::Whole { bits: ..=16, .. }, _)) && !crosses;
        let value = match value {
            Value::Number(kind, number) if is_short => {
                Value::Number(kind, Number::Words(self.copied(number, kind.words())))
            }
            value => value,
        };
        let mut number = self.as_number(value, DINT);
        if crosses {
            // Some controllers take it as a very large one.
            number = Number::Words(self.copied(number, 2));
            self.without_end(below_zero(DINT, &number));
        }
        if far != 0 {
            number = Number::Add(Box::new(number), Box::new(constant(far, 2)));
        }
        match is_short {
            true => number,
            false => Number::Words(self.copied(number, 2)),
        }
    }

    /// How often a number goes from one end to the other by steps.
    fn counted_turns(
        &mut self,
        ends: [&Number; 2],
        (by, range): (i64, (i64, i64)),
        fewest: u32,
        name: &str,
        line: u32,
    ) -> Result<Turns, Fault> {
        let number = |number: &Number| Value::Number(DINT, number.clone());
        let (high, low) = if by > 0 { (ends[1], ends[0]) } else { (ends[0], ends[1]) };
        let last = number(ends[1]);
        let [high_value, low_value] = [high, low].map(number);
        let difference = Number::Sub(Box::new(high.clone()), Box::new(low.clone()));
        let apart = self.copied(difference.clone(), 2);
        // How often it goes on behind its first turn, and the value with which it goes round last.
        let (more, last) = match by.abs() {
            1 => (difference, last),
            step => {
                let mut parts = Vec::new();
                for operator in [Operator::Divide, Operator::Modulo] {
                    let steps = constant(step, 2);
                    match self.arithmetic(operator, DINT, difference.clone(), steps)? {
                        Value::Number(_, part) => parts.push(Box::new(part)),
                        _ => return endless(line, "the loop's count is not followed"),
                    }
                }
                let end = Box::new(ends[1].clone());
                let (Some(short), Some(more)) = (parts.pop(), parts.pop()) else {
                    return endless(line, "the loop's count is not followed");
                };
                let last = if by > 0 { Number::Sub(end, short) } else { Number::Add(end, short) };
                (*more, Value::Number(DINT, last))
            }
        };
        let count = Number::Add(Box::new(more), Box::new(constant(1, 2)));
        // A count of more than 16 bits is the largest there is: beyond that, nothing is bounded. A difference that does
        // not fit 31 bits comes out below 0.
        let words = self.copied(count, 2);
        let counted = Value::Number(DINT, Number::Words(words.clone()));
        let none = self.holds(Operator::Less, high_value, low_value, line)?;
        let limit = self.holds(Operator::Greater, counted, Value::Constant(MOST), line)?;
        let apart = Value::Number(DINT, Number::Words(apart));
        let wraps = self.holds(Operator::Less, apart, Value::Constant(0), line)?;
        let (operator, most) =
            if by > 0 { (Operator::Greater, range.1) } else { (Operator::Less, range.0) };
        let ever = self.holds(operator, last, Value::Constant(most - by), line)?;
        let endless = Logic::Any(vec![limit, wraps, ever]);
        let beyond = Logic::All(vec![none.clone().not(), endless]);
        self.without_end(beyond);
        if fewest > 0 {
            // A turn that is made without a test may leave the type, and come back before the end.
            let first = number(ends[0]);
            let leaves = self.holds(operator, first, Value::Constant(most - by), line)?;
            self.without_end(Logic::All(vec![none.clone(), leaves]));
        }
        if let WordSource::Cell(cell) = words[0] {
            self.program().names.insert(cell, name.to_owned());
            let fewest = constant(fewest.into(), 1);
            let write = Write::Words(vec![WordTarget::Cell(cell)], fewest);
            self.write_if(none, vec![write], None);
        }
        Ok(Turns { count: words[0], least: 0, most: i16::MAX.cast_unsigned().into() })
    }
}

/// By how much a statement moves a variable: `i := i + 1`.
fn step_of(one: &Statement, place: &Place) -> Option<i64> {
    let StatementKind::Assign(target, value) = &one.kind else { return None };
    let ExprKind::Binary(operator, left, right) = &value.unconverted().kind else { return None };
    let is_own =
        |one: &Expr| matches!(&one.unconverted().kind, ExprKind::Read(own) if is_same(own, place));
    let by = match operator {
        Operator::Add if is_own(left) => right.whole(),
        Operator::Add if is_own(right) => left.whole(),
        Operator::Subtract if is_own(left) => right.whole()?.checked_neg(),
        _ => None,
    };
    by.filter(|by| *by != 0 && is_same(target, place))
}

/// Whether no turn of a loop with this body is followed by another one: each comes to an EXIT or RETURN.
fn ends_in_first_turn(body: &[Statement]) -> bool {
    let leaves = |one: &Statement| match &one.kind {
        StatementKind::Exit => true,
        StatementKind::Return(condition) => matches!(condition.kind, ExprKind::Bool(true)),
        _ => false,
    };
    let Some(first) = body.iter().position(leaves) else { return false };
    let mut skips = continues(&body[..first]);
    each_statement(&body[..first], &mut |one| {
        skips |= matches!(one.kind, StatementKind::Jump(..) | StatementKind::Label(_));
    });
    !skips
}

/// The parts of a condition that are joined so.
fn joined<'e>(one: &'e Expr, by: Operator, parts: &mut Vec<&'e Expr>) {
    match &one.kind {
        ExprKind::Binary(operator, left, right) if operator.eager() == by => {
            joined(left, by, parts);
            joined(right, by, parts);
        }
        _ => parts.push(one),
    }
}

/// Variables, how they are to an end while a loop goes on, and the end.
fn compared(one: &Expr, while_true: bool) -> Vec<(&Place, Operator, &Expr)> {
    let ExprKind::Binary(operator, left, right) = &one.kind else { return Vec::new() };
    let Some((own, other)) = crate::assembler::loops::goes_on(*operator, while_true) else {
        return Vec::new();
    };
    let (left, right) = (left.unconverted(), right.unconverted());
    let mut found = Vec::new();
    if let ExprKind::Read(place) = &left.kind {
        found.push((place, own, right));
    }
    if let ExprKind::Read(place) = &right.kind {
        found.push((place, other, left));
    }
    // A loop that goes on at one value alone says nothing of its turns.
    found.retain(|(_, operator, _)| *operator != Operator::Equal);
    found
}
