//! Lowers loops and determines their iteration counts.

use super::Lower;
use super::cells::Effects;
use super::decode::file_names;
use super::effects::is_same;
use super::spots::{Context, Found};
use super::statements::JumpTargets;
use super::values::{literal_value, wraps_in};
use crate::assembler::Assembler;
use crate::assembler::loops::{MOST, Turns, whole_range};
use crate::assembler::mixed::{below_zero, mixed};
use crate::assembler::numbers::read;
use crate::assembler::types::{DINT, Kind, Ty};
use crate::assembler::value::{Value, constant, signed};
use scanbound_base::code::Code as FaultCode;
use scanbound_iec::ast::Operator;
use scanbound_iec::fault::Fault;
use scanbound_iec_tree::elementary::holding;
use scanbound_iec_tree::tree::{
    Expr, ExprKind, ForLoop, Place, Statement, StatementKind, continues, each_statement,
};
use scanbound_iec_tree::types::Type as Typed;
use scanbound_ir::{Logic, Number, Relation, WordSource, WordTarget, Write};

/// The value with which a loop begins.
enum First {
    Known(i64),
    Value(Value),
    /// The current value of the loop variable.
    Held,
}

/// A variable that a loop moves by a constant until it has passed an end.
struct Counting {
    variable: Place,
    /// The loop continues up to the value `end + far`.
    end: Expr,
    far: i64,
    by: i64,
    /// Whether the loop ends only at exactly one value (`<>`). If the variable starts beyond it, the loop runs through
    /// all values of the type.
    only_there: bool,
}

fn endless<T>(line: u32, what: &str) -> Result<T, Fault> {
    Err(Fault::new(line, what)
        .code(FaultCode::LoopCount)
        .help("give the loop a variable of a larger type, or fewer iterations"))
}

impl Lower<'_> {
    /// Lowers a FOR loop. A fault if its step is not a constant other than 0, or if the body may change the loop
    /// variable or the end.
    pub(super) fn counted_loop(
        &mut self,
        at: &Context,
        own: &ForLoop,
        line: u32,
        targets: &mut JumpTargets,
    ) -> Result<(), Fault> {
        let ForLoop { variable, from, to, by, body } = own;
        let Some(by) = by.filter(|&by| by != 0) else {
            return Err(Fault::new(line, "the step of FOR must be a constant other than 0")
                .code(FaultCode::LoopCount)
                .help("write a number"));
        };
        let shown = &variable.text;
        if self.may_write(at, body, variable) {
            let message = format!("the loop may write to its own variable {shown}");
            let help = "use EXIT to leave a loop, a variable that no code called in the loop writes, and arrays of up to 64 instances";
            return Err(Fault::new(line, message).code(FaultCode::LoopCount).help(help));
        }
        if self.names(at, to, variable) {
            let message = format!("the end of FOR names its own variable {shown}");
            let help = "some controllers evaluate the end once, others before every iteration: assign it to another variable";
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
        // Some controllers evaluate the end before each iteration.
        if to.whole().is_none() && !matches!(to.kind, ExprKind::Read(_)) {
            self.value(at, to)?;
        }
        self.close_loop(begin, "END_FOR");
        self.left_behind(at, variable, by, &turns, line)?;
        self.leave_loop(out);
        Ok(())
    }

    /// Lowers a read of a variable, and charges it.
    fn held(&mut self, at: &Context, place: &Place, line: u32) -> Result<Value, Fault> {
        let one = Expr { kind: ExprKind::Read(place.clone()), ty: place.ty, line };
        self.value(at, &one)
    }

    /// Assigns the first value to a loop variable and returns it. Returns [`First::Held`] if the variable may then hold
    /// another value: its type does not hold all values of the expression, or another task may write it.
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
        let known = from.whole().filter(|_| self.keeps_its_types(from));
        let known = known.filter(|from| (range.0..=range.1).contains(from));
        Ok(match known {
            Some(known) => First::Known(known),
            None if fits => First::Value(value),
            None => First::Held,
        })
    }

    /// After a loop, its variable is beyond the end, or holds the value of the last iteration: controllers differ.
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

    /// Lowers a WHILE loop. A fault if its iteration count is neither found nor stated.
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
        // The last test, after the largest number of iterations.
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

    /// Lowers a REPEAT loop. A fault if its iteration count is neither found nor stated.
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

    /// Lowers the body of a loop. Returns the jumps out of it (EXIT).
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

    /// The iteration count of WHILE or REPEAT, and whether it is only stated by the user. It comes from an EXIT or
    /// RETURN that ends each iteration, from a counted variable, or from a stated maximum. `fewest`: the iterations
    /// that run without a test.
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

    /// The largest iteration count that the user states for the loop in this line of the current file. None if nothing
    /// is stated.
    fn stated_turns(&self, fewest: u32, line: u32) -> Result<Option<u16>, Fault> {
        let names = file_names(&self.project.files, self.file);
        crate::assembler::loops::most_stated(&self.options.stated_turns, names, fewest, line)
    }

    /// The iteration count of a loop that counts a variable, but at least `fewest`.
    fn turns_of(
        &mut self,
        at: &Context,
        counting: &Counting,
        fewest: u32,
        line: u32,
    ) -> Result<Turns, Fault> {
        let Counting { variable, end, far, by, only_there } = counting;
        if *only_there {
            // A loop that is tested after its body starts one step further on.
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

    /// The iteration count of a loop from `from` up or down to `to + far` in steps of `by`, but at least `fewest`. The
    /// loop is unbounded where its variable would leave the range of its type beyond the end, since it wraps around
    /// there.
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
        let steps = range.0.min(-range.1)..=range.1;
        let end = literal_value(to).map(Value::Constant);
        if !steps.contains(&by) || end.is_some_and(|end| wraps_in(to, &end, held)) {
            let told = format!(
                "the step or the end of the loop is computed beyond the type of {}: controllers differ in what they make of it",
                variable.text
            );
            return endless(line, &told);
        }
        let end = to.whole().filter(|_| self.keeps_its_types(to));
        if !held.is_signed() && end.is_some_and(|end| end < 0) {
            let told = format!(
                "{} is unsigned and the end of the loop is below 0: some controllers take it as a very large number",
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
                    "{} cannot go beyond {to}, the end of the loop: the loop would never end",
                    variable.text
                );
                return endless(line, &told);
            }
            let turns = turns.max(fewest.into());
            return match u16::try_from(turns).ok().filter(|turns| i64::from(*turns) <= MOST) {
                Some(turns) => Ok(Turns::exactly(turns)),
                None => endless(line, &format!("the loop runs {turns} iterations")),
            };
        }
        let from = match from {
            First::Known(value) => Value::Constant(value),
            First::Value(value) => value,
            First::Held => self.held(at, variable, line)?,
        };
        let last = self.value(at, to)?;
        let is_longest = matches!(held, Kind::Whole { bits: 64, signed: false });
        let crosses_kind = |kind| mixed(held, kind).is_some() || (is_longest && kind.is_signed());
        let crosses = match &last {
            Value::Constant(end) => !held.is_signed() && *end < 0,
            Value::Number(kind, _) | Value::Open(kind, ..) => {
                crosses_kind(*kind) || self.kind_of(to).is_some_and(crosses_kind)
            }
            _ => false,
        };
        let ends = [(from, 0), (last, far)];
        let is_short = |value: &Value| match value {
            Value::Constant(value) => (i16::MIN.into()..=u16::MAX.into()).contains(value),
            Value::Number(Kind::Whole { bits, .. }, _) => *bits <= 16,
            _ => false,
        };
        let may_wrap = !ends.iter().all(|(value, _)| is_short(value));
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
        let name = format!("the iterations up to {name}");
        self.counted_turns([&found[0], &found[1]], may_wrap, (by, range), fewest, &name, line)
    }

    /// The type of a loop variable, and its least and largest value. A fault if it is not an integer.
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
            // A range larger than any count that is modelled.
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
            let message = format!("{name} counts a loop and is not an integer");
            Fault::new(line, message).code(FaultCode::LoopCount).help("declare it as INT or DINT")
        })
    }

    /// Refuses an end of a loop that the loop itself may change.
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
                moved.map_or("a variable in it".into(), |(_, what)| what)
            }
        };
        let message = format!("the loop may change its own end: it writes or calls {what}");
        let help = "put the end into a variable that nothing in the loop writes";
        Err(Fault::new(line, message).code(FaultCode::LoopCount).help(help))
    }

    /// Finds the variable that a loop counts, for a loop that continues while (or until) `condition` is true: one that
    /// the condition compares with an end, and that exactly one statement, executed in every iteration, moves by a
    /// constant. A fault if there is none.
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
        // An end at exactly one value is used only if no other is found.
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

    /// Whether code that a condition calls may write the variable or the end that it compares.
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

    /// The kind of number that an expression has by its type.
    fn kind_of(&self, one: &Expr) -> Option<Kind> {
        match self.tree.types.get(one.ty) {
            Typed::Elementary(of) => of.kind(),
            _ => None,
        }
    }

    /// Whether each part of a constant expression fits its type, so that no controller works it out otherwise.
    fn keeps_its_types(&self, one: &Expr) -> bool {
        let kind = self.kind_of(one);
        let fits = |value| kind.is_none_or(|kind| holding(kind, value) == kind);
        let mut all = one.whole().is_none_or(fits);
        one.each_operand(&mut |part| all &= self.keeps_its_types(part));
        all
    }

    /// Whether a variable has more values than the largest iteration count that is modelled.
    fn is_wide(&mut self, at: &Context, variable: &Place, line: u32) -> bool {
        self.range_of(at, variable, line).is_ok_and(|(_, (least, most))| most - least > MOST)
    }
}

impl Assembler {
    /// An end of a loop, plus `far`, as a number. `crosses`: signed and unsigned numbers are compared, so that a
    /// negative end is unbounded.
    fn loop_end(&mut self, value: Value, far: i64, crosses: bool) -> Number {
        // A 16-bit number stays in one word: more is known about one word than about two.
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
            // Some controllers take a negative end as a very large number.
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

    /// The iteration count between two ends known only at run time, in steps of `by`. `may_wrap`: whether their
    /// difference may have more than 31 bits.
    fn counted_turns(
        &mut self,
        ends: [&Number; 2],
        may_wrap: bool,
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
        let apart = Value::Number(DINT, difference.clone());
        // The iterations after the first one, and the value of the variable in the last one.
        let (more, last) = match by.abs() {
            1 => (difference, last),
            step => {
                let mut parts = Vec::new();
                for operator in [Operator::Divide, Operator::Modulo] {
                    let steps = constant(step, 2);
                    match self.arithmetic(operator, DINT, difference.clone(), steps)? {
                        Value::Number(_, part) => parts.push(Box::new(part)),
                        _ => {
                            return endless(
                                line,
                                "the iteration count of the loop is not modelled",
                            );
                        }
                    }
                }
                let end = Box::new(ends[1].clone());
                let (Some(short), Some(more)) = (parts.pop(), parts.pop()) else {
                    return endless(line, "the iteration count of the loop is not modelled");
                };
                let last = if by > 0 { Number::Sub(end, short) } else { Number::Add(end, short) };
                (*more, Value::Number(DINT, last))
            }
        };
        let count = Number::Add(Box::new(more), Box::new(constant(1, 2)));
        let words = self.copied(count, 2);
        let none = self.holds(Operator::Less, high_value, low_value, line)?;
        // Counts above the largest one that is modelled are unbounded. A difference of more than 31 bits is negative.
        let least = by.checked_abs().and_then(|by| by.checked_mul(MOST));
        let least = least.filter(|least| i32::try_from(*least).is_ok());
        let limit = match least {
            Some(least) => {
                let least = Value::Constant(least);
                self.holds(Operator::GreaterOrEqual, apart.clone(), least, line)?
            }
            None => Logic::Const(false),
        };
        let wraps = match may_wrap {
            true => self.holds(Operator::Less, apart, Value::Constant(0), line)?,
            false => Logic::Const(false),
        };
        let (operator, most) =
            if by > 0 { (Operator::Greater, range.1) } else { (Operator::Less, range.0) };
        // The last value is not beyond the end, of which more may be known.
        let near = [number(ends[1]), last].map(|value| (value, Value::Constant(most - by)));
        let [end, last] = near.map(|(value, near)| self.holds(operator, value, near, line));
        let ever = Logic::All(vec![end?, last?]);
        let endless = Logic::Any(vec![limit, wraps, ever]);
        let beyond = Logic::All(vec![none.clone().not(), endless]);
        self.without_end(beyond);
        if fewest > 0 {
            // An iteration without a test may leave the range of the type and wrap around before the end.
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

/// The constant by which a statement such as `i := i + 1` moves a variable. None for other statements.
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

/// Whether a loop with this body ends in its first iteration: each path reaches an EXIT or RETURN.
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

/// Collects the operands of nested AND or OR (`by`) in a condition.
fn joined<'e>(one: &'e Expr, by: Operator, parts: &mut Vec<&'e Expr>) {
    match &one.kind {
        ExprKind::Binary(operator, left, right) if operator.eager() == by => {
            joined(left, by, parts);
            joined(right, by, parts);
        }
        _ => parts.push(one),
    }
}

/// The comparisons of a variable with an end in an expression: the variable, the relation that holds while the loop
/// continues, and the end. Empty if the expression is not a comparison.
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
    // A loop that continues at only one value gives no iteration count.
    found.retain(|(_, operator, _)| *operator != Operator::Equal);
    found
}
