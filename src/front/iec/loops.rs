//! Loops, and how often they go round.

use super::emit::Emit;
use super::resolve::{Context, Found};
use super::statement::Ways;
use super::types::{DINT, Kind, Ty, lineage};
use super::value::{Value, constant};
use super::within::{calls, each, multiplies, shown, variables};
use crate::base::code::Code;
use crate::iec::ast::{Argument, Expr, Kind as Statements, Operator, Part, Path, Statement};
use crate::iec::fault::Fault;
use crate::iec::{Body, Section, same, show};
use crate::program::{Logic, Number, Step, WordSource, WordTarget, Write};

/// The most turns that are followed.
const MOST: i64 = i16::MAX as i64;

/// How often a loop goes round.
struct Turns {
    count: WordSource,
    least: u32,
    most: u32,
}

/// A variable that a loop counts up or down until it has passed an end.
struct Counting {
    variable: Path,
    /// The last value with which the loop goes on.
    end: Expr,
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
        self.end_stays(at, to, body, line)?;
        let start = self.value(at, from, line)?;
        self.assign(at, variable, start, line)?;
        let turns = self.turns(at, variable, (from, to, by), 0, line)?;
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
        self.end_loop(begin, "END_FOR", out);
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
        let counting = self.counting(at, condition, true, body, line)?;
        let turns = self.turns_of(at, &counting, 0, line)?;
        let begin = self.begin_loop(&turns, None);
        let goes_on = self.bit(at, condition, line)?;
        let leave = self.jump(goes_on.not(), Some(Self::key(&["JMP"], "jump")));
        let out = self.around(at, body, ways);
        self.at(line, "END_WHILE");
        self.end_loop(begin, "JMP", Vec::new());
        // The test that ends it, where it has gone round as often as it can.
        self.bit(at, condition, line)?;
        self.cost(&["JMP"], "jump");
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
        let counting = self.counting(at, until, false, body, line)?;
        let turns = self.turns_of(at, &counting, 1, line)?;
        let begin = self.begin_loop(&turns, None);
        let mut out = self.around(at, body, ways);
        self.at(line, "END_REPEAT");
        let ends = self.bit(at, until, line)?;
        out.push(self.jump(ends, Some(Self::key(&["JMP"], "jump"))));
        self.end_loop(begin, "JMP", out);
        Ok(())
    }

    /// How often a loop goes round that counts a variable, but at least so often.
    fn turns_of(
        &mut self,
        at: &Context,
        counting: &Counting,
        fewest: u32,
        line: u32,
    ) -> Result<Turns, Fault> {
        let Counting { variable, end, by, only_there } = counting;
        let from = Expr::Variable(variable.clone());
        if *only_there {
            // A loop that is carried out before it is tested begins one step further on.
            let (first, far) = match (fewest, *by > 0) {
                (0, true) => (Operator::Greater, *by),
                (0, false) => (Operator::Less, *by),
                (_, true) => (Operator::Greater, 0),
                (_, false) => (Operator::Less, 0),
            };
            let start = self.value(at, &from, line)?;
            let last = self.value(at, end, line)?;
            let last = self.combined(Operator::Add, last, Value::Constant(far), line)?;
            let beyond = self.holds(first, start, last, line)?;
            self.without_end(beyond);
        }
        self.turns(at, variable, (&from, end, *by), fewest, line)
    }

    /// Where a condition holds, the loop that begins has no end.
    fn without_end(&mut self, condition: Logic) {
        let skip = self.jump(condition.not(), None);
        let here = self.builder.next();
        self.builder.add(None, Vec::new(), Step::Unbounded { from: here });
        self.land(skip);
        self.landing();
    }

    fn begin_loop(&mut self, turns: &Turns, row: Option<&str>) -> usize {
        let Turns { count, least, most } = *turns;
        let key = row.map(|row| Self::key(&[row], "loop"));
        self.builder.add(key, Vec::new(), Step::ForBegin { count, least, most, end: 0 })
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

    fn end_loop(&mut self, begin: usize, row: &str, out: Vec<usize>) {
        let end = self.builder.add(Some(Self::key(&[row], "loop")), Vec::new(), Step::ForEnd);
        if let Step::ForBegin { end: own, .. } = &mut self.builder.program.instructions[begin].step
        {
            *own = end;
        }
        for jump in out {
            self.land(jump);
        }
        self.landing();
    }

    /// How often a variable goes from one value to another by steps, but at least so often. It has no end where the variable,
    /// beyond its end, would be beyond what its type holds: it begins anew there.
    fn turns(
        &mut self,
        at: &Context,
        variable: &Path,
        (from, to, by): (&Expr, &Expr, i64),
        fewest: u32,
        line: u32,
    ) -> Result<Turns, Fault> {
        let range = self.range_of(at, variable, line)?;
        let endless = |what: String| {
            Err(Fault::new(line, what)
                .code(Code::LoopCount)
                .help("give it a variable of a larger type, or fewer turns"))
        };
        if let Some((from, to)) = self.constant(at, from).zip(self.constant(at, to)) {
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
        for one in [from, to] {
            let mut value = self.value(at, one, line)?;
            // A variable of a longer type shows how many bits a compiler keeps of a product.
            if multiplies(one) && range.1 > i64::from(i16::MAX) {
                value = shown(one, value, &Ty::Number(DINT));
            }
            if let Value::Number(Kind::Whole { bits, signed }, _) = value
                && (bits > 32 || (bits == 32 && !signed))
            {
                return endless("the ends of the loop have more than 31 bits".to_owned());
            }
            let number = self.as_number(value, DINT, line)?;
            ends.push(self.copies(number, DINT));
        }
        let number = |words: &Vec<WordSource>| Value::Number(DINT, Number::Words(words.clone()));
        let (high, low) = if by > 0 { (&ends[1], &ends[0]) } else { (&ends[0], &ends[1]) };
        let last = number(&ends[1]);
        let [high_value, low_value] = [high, low].map(number);
        let [high, low] = [high, low].map(|end| Box::new(Number::Words(end.clone())));
        let apart = self.copies(Number::Sub(high, low), DINT);
        let difference = Number::Words(apart.clone());
        let count = match by.abs() {
            1 => Number::Add(Box::new(difference), Box::new(constant(1, 2))),
            step => {
                let steps = constant(step, 2);
                let Value::Number(_, turns) =
                    self.arithmetic(Operator::Divide, DINT, difference, steps)?
                else {
                    return endless("the loop's count is not followed".to_owned());
                };
                Number::Add(Box::new(turns), Box::new(constant(1, 2)))
            }
        };
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
            let fewest = constant(fewest.into(), 1);
            let write = Write::Words(vec![WordTarget::Cell(cell)], fewest);
            self.write_if(none, vec![write], None);
        }
        Ok(Turns { count: words[0], least: 0, most: i16::MAX.cast_unsigned().into() })
    }

    fn holds(
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

    /// What a loop's variable can hold.
    fn range_of(&mut self, at: &Context, variable: &Path, line: u32) -> Result<(i64, i64), Fault> {
        let of = |ty: &Ty| match ty {
            Ty::Number(Kind::Whole { bits, signed: true }) if *bits <= 32 => {
                Some((-(1i64 << (bits - 1)), (1i64 << (bits - 1)) - 1))
            }
            Ty::Number(Kind::Whole { bits, signed: false }) if *bits <= 32 => {
                Some((0, (1i64 << bits) - 1))
            }
            // More than any count that is followed.
            Ty::Number(Kind::Whole { .. }) => Some((-(1 << 40), 1 << 40)),
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
        crate::iec::ast::visit(body, &mut |one| skips |= leaves(one));
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
            let one = |operator| {
                let one = Expr::Literal(crate::iec::ast::Literal::Int(1, None));
                Expr::Binary(operator, Box::new(end.clone()), Box::new(one))
            };
            let end = match operator {
                Operator::Less => one(Operator::Subtract),
                Operator::Greater => one(Operator::Add),
                Operator::NotEqual if by > 0 => one(Operator::Subtract),
                Operator::NotEqual => one(Operator::Add),
                _ => end.clone(),
            };
            return Ok(Counting { variable: path.clone(), end, by, only_there });
        }
        let help = "let it go on while a variable is below an end (WHILE i < 10 DO), which one statement of the loop moves \
                    by a constant (i := i + 1), or write it as FOR with EXIT";
        Err(Fault::new(line, "how often WHILE or REPEAT goes round is not known")
            .code(Code::LoopCount)
            .help(help))
    }

    /// Whether a variable has so many values that no loop that is followed goes through all of them.
    fn is_wide(&mut self, at: &Context, variable: &Path, line: u32) -> bool {
        self.range_of(at, variable, line).is_ok_and(|(least, most)| most - least > MOST)
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

    /// Whether statements, or what they call, may write a variable.
    fn may_write(&self, at: &Context, body: &[Statement], variable: &Path) -> bool {
        // Which element an index means may change.
        if variable.rest.iter().any(|part| matches!(part, Part::Index(_) | Part::Dereference)) {
            return true;
        }
        if writes_to(body, variable) || self.writes_beside(body, variable) {
            return true;
        }
        let mut called = false;
        let mut handed = false;
        crate::iec::ast::visit(body, &mut |one| {
            called |= matches!(one.kind, Statements::Call(..) | Statements::CallIf(..));
            expressions(one, &mut |expr| called |= calls(self.project, expr));
            handed |= self.hands_over(one, variable);
        });
        if handed {
            return true;
        }
        if !called {
            return false;
        }
        let own = lineage(self.project, self.instances[at.instance].pou);
        let is_own = own.iter().any(|pou| {
            let kept = pou.variables.iter().filter(|one| one.section != Section::External);
            kept.into_iter().any(|one| same(&one.name, &variable.first))
        });
        let is_local =
            at.locals.as_ref().is_some_and(|place| Self::part(place, &variable.first).is_some());
        // What is a routine's own, nothing that it calls can reach.
        if is_local {
            return false;
        }
        self.project.pous.iter().any(|pou| {
            // Nothing that is called carries out the body of the same instance. Its own actions and methods name the variable
            // as it does, other units through its instance.
            let related = own.iter().any(|one| same(&one.name, &pou.name));
            bodies(pou, !related).into_iter().any(|body| {
                let named = (related || !is_own) && writes_to(body, variable);
                named || reaches(body, &variable.first)
            })
        })
    }

    /// Whether a variable has an address, and statements write another that has one, or call what may: both may share memory.
    fn writes_beside(&self, body: &[Statement], variable: &Path) -> bool {
        let has_address = |name: &str| {
            let globals = self.project.globals.iter().flat_map(|(_, list)| list);
            let own = self.project.pous.iter().flat_map(|pou| &pou.variables);
            let is = |one: &crate::iec::Variable| one.at.is_some() && same(&one.name, name);
            name.starts_with('%') || globals.chain(own).any(is)
        };
        let mut found = false;
        if has_address(&variable.first) {
            crate::iec::ast::visit(body, &mut |one| {
                found |= match &one.kind {
                    Statements::Assign(target, _)
                    | Statements::Latch(target, ..)
                    | Statements::For(target, ..) => {
                        !alike(target, variable) && has_address(&target.first)
                    }
                    Statements::Call(..) | Statements::CallIf(..) => true,
                    _ => false,
                };
                expressions(one, &mut |expr| found |= calls(self.project, expr));
            });
        }
        found
    }

    /// Whether a call hands a variable over for being changed.
    fn hands_over(&self, one: &Statement, variable: &Path) -> bool {
        let changes = |given: &Argument| {
            let in_out = self.project.pous.iter().flat_map(|pou| {
                let methods = pou.methods.iter().flat_map(|method| &method.variables);
                pou.variables.iter().chain(methods)
            });
            let mut in_out = in_out.filter(|one| one.section == Section::InOut);
            let is_own = matches!(&given.value, Expr::Variable(path) if alike(path, variable)
                || (same(&path.first, &variable.first) && path.rest.len() < variable.rest.len()));
            is_own
                && match &given.name {
                    Some(name) => in_out.any(|one| same(&one.name, name)),
                    None => in_out.next().is_some(),
                }
        };
        let mut found = false;
        if let Statements::Call(_, given) | Statements::CallIf(_, _, given) = &one.kind {
            found |= given.iter().any(changes);
        }
        expressions(one, &mut |expr| {
            each(expr, &mut |inner| {
                if let Expr::Call(_, given) = inner {
                    found |= given.iter().any(|one| changes(one) || one.is_output);
                }
            });
        });
        found
    }
}

/// Whether two paths mean the same variable.
pub(super) fn alike(one: &Path, other: &Path) -> bool {
    let part = |(one, other): (&Part, &Part)| match (one, other) {
        (Part::Name(one), Part::Name(other)) => same(one, other),
        (one, other) => one == other,
    };
    same(&one.first, &other.first)
        && one.rest.len() == other.rest.len()
        && one.rest.iter().zip(&other.rest).all(part)
}

/// The parts of a condition that are joined so.
fn joined<'e>(one: &'e Expr, by: Operator, parts: &mut Vec<&'e Expr>) {
    match one {
        Expr::Binary(operator, left, right) if *operator == by => {
            joined(left, by, parts);
            joined(right, by, parts);
        }
        other => parts.push(other),
    }
}

/// Variables, how they are to an end while a loop goes on, and the end.
fn compared(one: &Expr, while_true: bool) -> Vec<(&Path, Operator, &Expr)> {
    use Operator::{Equal, Greater, GreaterOrEqual, Less, LessOrEqual, NotEqual};
    let Expr::Binary(operator, left, right) = one else { return Vec::new() };
    let mirrored = |operator: Operator| match operator {
        Equal => Some(Equal),
        NotEqual => Some(NotEqual),
        Less => Some(Greater),
        LessOrEqual => Some(GreaterOrEqual),
        Greater => Some(Less),
        GreaterOrEqual => Some(LessOrEqual),
        _ => None,
    };
    let Some(other) = mirrored(*operator) else { return Vec::new() };
    let goes_on = |operator: Operator| match (while_true, operator) {
        (true, operator) => operator,
        (false, Equal) => NotEqual,
        (false, Less) => GreaterOrEqual,
        (false, LessOrEqual) => Greater,
        (false, Greater) => LessOrEqual,
        (false, NotEqual) => Equal,
        (false, _) => Less,
    };
    let mut found = Vec::new();
    if let Expr::Variable(path) = &**left {
        found.push((path, goes_on(*operator), &**right));
    }
    if let Expr::Variable(path) = &**right {
        found.push((path, goes_on(other), &**left));
    }
    // A loop that goes on at one value alone says nothing of its turns.
    found.retain(|(_, operator, _)| *operator != Equal);
    found
}

/// Whether statements assign to a variable, to a part of it, or to what it is a part of.
fn writes_to(body: &[Statement], variable: &Path) -> bool {
    let overlaps = |target: &Path| {
        let own = |part: &Part| !matches!(part, Part::Bit(_));
        let [one, other] = [target, variable].map(|path| path.rest.iter().filter(|part| own(part)));
        same(&target.first, &variable.first)
            && one.zip(other).all(|(one, other)| match (one, other) {
                (Part::Name(one), Part::Name(other)) => same(one, other),
                _ => true,
            })
    };
    let through_this = |target: &Path| {
        let names = target.rest.iter().find_map(|part| match part {
            Part::Name(name) => Some(name),
            _ => None,
        });
        same(&target.first, "THIS") && names.is_none_or(|name| same(name, &variable.first))
    };
    let mut found = false;
    crate::iec::ast::visit(body, &mut |one| {
        found |= match &one.kind {
            Statements::Assign(target, _)
            | Statements::Latch(target, ..)
            | Statements::For(target, ..) => overlaps(target) || through_this(target),
            Statements::Call(_, given) | Statements::CallIf(_, _, given) => {
                given.iter().any(|one| {
                    one.is_output && matches!(&one.value, Expr::Variable(path) if overlaps(path))
                })
            }
            Statements::Unread(_) => true,
            _ => false,
        };
    });
    found
}

/// Whether statements assign to a part of this name of something, as those do that reach an instance from outside.
fn reaches(body: &[Statement], name: &str) -> bool {
    let is_part = |part: &Part| matches!(part, Part::Name(one) if same(one, name));
    let mut found = false;
    crate::iec::ast::visit(body, &mut |one| {
        if let Statements::Assign(target, _) | Statements::Latch(target, ..) = &one.kind {
            found |= target.rest.iter().any(is_part);
        }
    });
    found
}

/// The statements of a unit's actions, methods and charts, and those of its body, if it is asked for.
pub(super) fn bodies(pou: &crate::iec::Pou, with_body: bool) -> Vec<&[Statement]> {
    let own = with_body.then_some(&pou.body).into_iter();
    let own = own.chain(pou.actions.iter().map(|one| &one.body));
    let mut found: Vec<&[Statement]> = Vec::new();
    for body in own {
        match body {
            Body::Code(_, statements) => found.push(statements),
            Body::Chart(chart) => {
                let blocks = chart.steps.iter().flat_map(|step| &step.blocks);
                found.extend(blocks.filter_map(|block| match &block.target {
                    crate::iec::chart::Target::Inline(_, body) => match &**body {
                        Body::Code(_, statements) => Some(&statements[..]),
                        _ => None,
                    },
                    crate::iec::chart::Target::Path(_) => None,
                }));
            }
            Body::Unread(..) => {}
        }
    }
    found.extend(pou.methods.iter().flat_map(|method| bodies(method, true)));
    found
}

/// Whether statements name a variable, to read or to write it: its first name, or one behind it.
pub(super) fn names(body: &[Statement], is_it: &dyn Fn(&str) -> bool) -> bool {
    fn named(path: &Path, is_it: &dyn Fn(&str) -> bool) -> bool {
        let part = |part: &Part| match part {
            Part::Name(name) => is_it(name),
            Part::Index(all) => {
                let mut found = false;
                let mut see = |path: &Path| found |= named(path, is_it);
                all.iter().for_each(|one| variables(one, &mut see));
                found
            }
            _ => false,
        };
        is_it(&path.first) || path.rest.iter().any(part)
    }
    let named = |path: &Path| named(path, is_it);
    let mut found = false;
    crate::iec::ast::visit(body, &mut |one| {
        found |= match &one.kind {
            Statements::Assign(target, _)
            | Statements::Latch(target, ..)
            | Statements::For(target, ..) => named(target),
            Statements::Unread(_) => true,
            _ => false,
        };
        expressions(one, &mut |expr| variables(expr, &mut |path| found |= named(path)));
    });
    found
}

/// The expressions of a statement, but for those of statements in it.
fn expressions(one: &Statement, see: &mut dyn FnMut(&Expr)) {
    let mut given = |all: &[Argument]| all.iter().for_each(|one| see(&one.value));
    match &one.kind {
        Statements::Call(_, all) => given(all),
        Statements::CallIf(condition, _, all) => {
            given(all);
            see(condition);
        }
        Statements::Assign(_, value) | Statements::Latch(_, _, value) => see(value),
        Statements::If(arms, _) => arms.iter().for_each(|(condition, _)| see(condition)),
        Statements::Case(of, ..) => see(of),
        Statements::For(_, from, to, by, _) => {
            [Some(from), Some(to), by.as_ref()].into_iter().flatten().for_each(see);
        }
        Statements::While(condition, _)
        | Statements::Repeat(_, condition)
        | Statements::Return(condition)
        | Statements::Jump(condition, _) => see(condition),
        _ => {}
    }
}
