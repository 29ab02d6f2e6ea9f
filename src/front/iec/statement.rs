//! Statements, and the routines that they stand in.

use super::emit::{Emit, Place, What};
use super::resolve::{Context, Found, unknown};
use super::types::{DINT, Kind, Ty, lineage};
use super::value::{Value, constant};
use crate::base::code::Code;
use crate::iec::ast::{Argument, Expr, Kind as Statements, Operator, Path, Selector, Statement};
use crate::iec::fault::Fault;
use crate::iec::{Body, Pou, PouKind, same, show};
use crate::program::{Logic, Number, Step, WordSource, WordTarget, Write};
use std::collections::BTreeMap;

/// Where jumps of a body lead: labels, and the ends of loops.
#[derive(Default)]
struct Ways {
    labels: BTreeMap<String, Vec<usize>>,
    seen: Vec<String>,
    /// For each loop around: jumps to its end of an iteration, and jumps out of it.
    loops: Vec<[Vec<usize>; 2]>,
}

impl<'p> Emit<'p> {
    /// The body of a routine, and whose file it stands in.
    pub(super) fn body(&self, instance: usize, what: &What) -> Option<(&'p Pou, &'p Body)> {
        let all = lineage(self.project, self.instances[instance].pou);
        match what {
            What::Body => all
                .into_iter()
                .map(|pou| (pou, &pou.body))
                .find(|(_, body)| !is_empty(body))
                .or_else(|| {
                    let own = &self.project.pous[self.instances[instance].pou];
                    Some((own, &own.body))
                }),
            What::Action(name) => {
                all.into_iter().find_map(|pou| Some((pou, &pou.action(name)?.body)))
            }
            What::Method(name) => all.into_iter().find_map(|pou| {
                let method = pou.methods.iter().find(|method| same(&method.name, name))?;
                Some((pou, &method.body))
            }),
        }
    }

    pub(super) fn method_of(&self, instance: usize, name: &str) -> Option<&'p Pou> {
        let all = lineage(self.project, self.instances[instance].pou);
        all.into_iter().find_map(|pou| pou.methods.iter().find(|method| same(&method.name, name)))
    }

    /// Puts a routine together; where it begins.
    pub(super) fn routine(&mut self, instance: usize, what: &What) -> usize {
        let entry = self.builder.next();
        self.routines.insert((instance, what.clone()), entry);
        self.kept.clear();
        let Some((pou, body)) = self.body(instance, what) else {
            self.landing();
            self.builder.add(None, Vec::new(), Step::Return);
            return entry;
        };
        self.file = pou.file;
        self.at(pou.line, &pou.name);
        self.landing();
        let locals = match what {
            What::Method(name) => self.method_place(instance, name).ok(),
            _ => None,
        };
        let context = Context { instance, locals };
        match body {
            Body::Code(_, statements) => {
                let mut ways = Ways::default();
                self.statements(&context, statements, &mut ways);
                for (label, jumps) in ways.labels {
                    if !jumps.is_empty() {
                        let help = "only jumps to labels further down are followed";
                        let fault =
                            Fault::new(pou.line, format!("there is no label {label} further down"));
                        self.faults.push((self.file, fault.code(Code::NoLabel).help(help)));
                    }
                }
            }
            Body::Chart(chart) => self.chart(&context, what, pou, chart),
            Body::Unread(language, fault) => {
                let mut fault = fault.clone();
                fault.message = format!("{} ({})", fault.message, language.name());
                self.faults.push((self.file, fault));
            }
        }
        self.landing();
        self.builder.add(None, Vec::new(), Step::Return);
        entry
    }

    fn statements(&mut self, at: &Context, statements: &[Statement], ways: &mut Ways) {
        for statement in statements {
            let text = show::statements(std::slice::from_ref(statement), 0);
            self.at(statement.line, text.lines().next().unwrap_or_default());
            if let Err(fault) = self.statement(at, statement, ways) {
                let fault =
                    if fault.line == 0 { Fault { line: statement.line, ..fault } } else { fault };
                let place = &self.instances[at.instance].place.name;
                let fault = fault.within(place);
                if !self.faults.contains(&(self.file, fault.clone())) {
                    self.faults.push((self.file, fault));
                }
            }
        }
    }

    /// Statements that stand within a chart.
    pub(super) fn inner(&mut self, at: &Context, statements: &[Statement]) {
        self.statements(at, statements, &mut Ways::default());
    }

    fn statement(&mut self, at: &Context, one: &Statement, ways: &mut Ways) -> Result<(), Fault> {
        let line = one.line;
        match &one.kind {
            Statements::Assign(target, value) => {
                let value = self.value(at, value, line)?;
                self.assign(at, target, value, line)
            }
            Statements::Latch(target, set, condition) => {
                let fires = self.bit(at, condition, line)?;
                let found = self.find(at, target, line)?;
                let writes = self.writes(found, Value::Bit(Logic::Const(*set)), line)?;
                let row = if *set { "S" } else { "R" };
                self.write_if(fires, writes, Some(Self::key(&[row], "coil")));
                Ok(())
            }
            Statements::Call(target, given) => self.called(at, target, given, line),
            Statements::CallIf(condition, target, given) => {
                if condition.is(true) {
                    return self.called(at, target, given, line);
                }
                let enable = self.bit(at, condition, line)?;
                let skip = self.jump(enable.not(), Some(Self::key(&["JMP"], "jump")));
                let done = self.called(at, target, given, line);
                self.land(skip);
                self.landing();
                done
            }
            Statements::If(arms, otherwise) => self.conditional(at, arms, otherwise, line, ways),
            Statements::Case(of, arms, otherwise) => self.case(at, of, arms, otherwise, line, ways),
            Statements::For(variable, from, to, by, body) => {
                self.counted(at, variable, (from, to, by.as_ref()), body, line, ways)
            }
            Statements::While(..) | Statements::Repeat(..) => {
                let help =
                    "write it as FOR with EXIT: how often it goes round is not known otherwise";
                Err(Fault::new(line, "how often WHILE or REPEAT goes round is not known")
                    .code(Code::LoopCount)
                    .help(help))
            }
            Statements::Exit | Statements::Continue => {
                let jump = self.jump(Logic::Const(true), Some(Self::key(&["JMP"], "jump")));
                let side = usize::from(one.kind == Statements::Exit);
                match ways.loops.last_mut() {
                    Some(inner) => inner[side].push(jump),
                    None => return Err(Fault::new(line, "no loop is around EXIT or CONTINUE")),
                }
                Ok(())
            }
            Statements::Return(condition) => {
                let returns = self.bit(at, condition, line)?;
                let stay = self.jump(returns.not(), None);
                self.builder.add(Some(Self::key(&["RET"], "jump")), Vec::new(), Step::Return);
                self.land(stay);
                self.landing();
                Ok(())
            }
            Statements::Jump(condition, label) => {
                let fires = self.bit(at, condition, line)?;
                if ways.seen.iter().any(|seen| same(seen, label)) {
                    let help = "only jumps to labels further down are followed: write it as FOR";
                    return Err(Fault::new(line, format!("the jump to {label} goes back"))
                        .code(Code::JumpBack)
                        .help(help));
                }
                let jump = self.jump(fires, Some(Self::key(&["JMP"], "jump")));
                ways.labels.entry(label.to_ascii_uppercase()).or_default().push(jump);
                Ok(())
            }
            Statements::Label(label) => {
                ways.seen.push(label.clone());
                for jump in ways.labels.remove(&label.to_ascii_uppercase()).unwrap_or_default() {
                    self.land(jump);
                }
                self.landing();
                Ok(())
            }
            Statements::Unread(what) => Err(Fault::new(line, what.clone()).code(Code::NotModelled)),
        }
    }

    /// The branches of IF: each tests, and jumps to the next one where it is false.
    fn conditional(
        &mut self,
        at: &Context,
        arms: &[(Expr, Vec<Statement>)],
        otherwise: &[Statement],
        line: u32,
        ways: &mut Ways,
    ) -> Result<(), Fault> {
        let mut ends = Vec::new();
        for (number, (condition, body)) in arms.iter().enumerate() {
            let holds = self.bit(at, condition, line)?;
            let skip = self.jump(holds.not(), Some(Self::key(&["JMP"], "jump")));
            let kept = self.kept.clone();
            self.statements(at, body, ways);
            self.kept = merged(kept, &self.kept);
            if number + 1 < arms.len() || !otherwise.is_empty() {
                ends.push(self.jump(Logic::Const(true), Some(Self::key(&["JMP"], "jump"))));
            }
            self.land(skip);
            self.landing();
        }
        self.statements(at, otherwise, ways);
        for end in ends {
            self.land(end);
        }
        self.landing();
        Ok(())
    }

    fn case(
        &mut self,
        at: &Context,
        of: &Expr,
        arms: &[(Vec<Selector>, Vec<Statement>)],
        otherwise: &[Statement],
        line: u32,
        ways: &mut Ways,
    ) -> Result<(), Fault> {
        let value = self.value(at, of, line)?;
        let kind = match &value {
            Value::Number(kind, _) => *kind,
            _ => DINT,
        };
        let number = self.as_number(value, kind, line)?;
        let words = self.copies(number, kind);
        let mut ends = Vec::new();
        for (selectors, body) in arms {
            let mut fits = Vec::new();
            for selector in selectors {
                let own = || Value::Number(kind, Number::Words(words.clone()));
                let low = self.value(at, &selector.low, line)?;
                fits.push(match &selector.high {
                    None => self.combined(Operator::Equal, own(), low, line)?,
                    Some(high) => {
                        let high = self.value(at, high, line)?;
                        let above = self.combined(Operator::GreaterOrEqual, own(), low, line)?;
                        let below = self.combined(Operator::LessOrEqual, own(), high, line)?;
                        self.combined(Operator::And, above, below, line)?
                    }
                });
            }
            let bits = fits.into_iter().map(|fit| match fit {
                Value::Bit(logic) => logic,
                _ => Logic::Const(false),
            });
            let holds = Logic::Any(bits.collect());
            let skip = self.jump(holds.not(), Some(Self::key(&["JMP"], "jump")));
            self.statements(at, body, ways);
            ends.push(self.jump(Logic::Const(true), Some(Self::key(&["JMP"], "jump"))));
            self.land(skip);
            self.landing();
        }
        self.statements(at, otherwise, ways);
        for end in ends {
            self.land(end);
        }
        self.landing();
        Ok(())
    }

    fn copies(&mut self, number: Number, kind: Kind) -> Vec<WordSource> {
        let first = self.words_between(kind.words());
        let targets = (0..kind.words()).map(|at| WordTarget::Cell(first.plus(at))).collect();
        self.write(vec![Write::Words(targets, number)]);
        (0..kind.words()).map(|at| WordSource::Cell(first.plus(at))).collect()
    }

    fn counted(
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
        let calls = makes_calls(body);
        let called = |pou: &Pou| {
            let actions = pou.actions.iter().map(|one| &one.body);
            actions.chain(pou.methods.iter().map(|one| &one.body)).any(
                |own| matches!(own, Body::Code(_, statements) if writes_to(statements, variable)),
            )
        };
        let units = lineage(self.project, self.instances[at.instance].pou);
        if writes_to(body, variable) || (calls && units.into_iter().any(called)) {
            let message = format!("the loop writes to its own variable {}", show::path(variable));
            let help = "use EXIT to leave a loop, and a variable that nothing called in it writes";
            return Err(Fault::new(line, message).code(Code::LoopCount).help(help));
        }
        let start = self.value(at, from, line)?;
        self.assign(at, variable, start, line)?;
        let known = self.constant(at, from).zip(self.constant(at, to));
        let (count, least, most) = match known {
            Some((from, to)) => {
                let turns = (to - from).div_euclid(by) + 1;
                let turns = if (by > 0 && from > to) || (by < 0 && from < to) { 0 } else { turns };
                let Ok(turns) = u16::try_from(turns) else {
                    return Err(Fault::new(line, format!("the loop goes round {turns} times"))
                        .code(Code::LoopCount));
                };
                if turns > i16::MAX.cast_unsigned() {
                    return Err(Fault::new(line, format!("the loop goes round {turns} times"))
                        .code(Code::LoopCount));
                }
                (WordSource::Const(turns), u32::from(turns), u32::from(turns))
            }
            None => {
                let (from, to) =
                    (self.number(at, from, DINT, line)?, self.number(at, to, DINT, line)?);
                let (high, low) = if by > 0 { (to, from) } else { (from, to) };
                let [high, low] = [high, low].map(|end| self.copies(end, DINT));
                let ends = [&high, &low].map(|end| Value::Number(DINT, Number::Words(end.clone())));
                let [high, low] = [high, low].map(|end| Box::new(Number::Words(end)));
                let apart = self.copies(Number::Sub(high, low), DINT);
                let difference = Number::Words(apart.clone());
                let count = match by.abs() {
                    1 => Number::Add(Box::new(difference), Box::new(constant(1, 2))),
                    step => {
                        let steps = constant(step, 2);
                        let Value::Number(_, turns) =
                            self.arithmetic(Operator::Divide, DINT, difference, steps)?
                        else {
                            return Err(Fault::new(line, "the loop's count is not followed")
                                .code(Code::LoopCount));
                        };
                        Number::Add(Box::new(turns), Box::new(constant(1, 2)))
                    }
                };
                // A count of more than 16 bits is the largest there is: beyond that, nothing is bounded.
                let words = self.copies(count, DINT);
                let limit = self.combined(
                    Operator::Greater,
                    Value::Number(DINT, Number::Words(words.clone())),
                    Value::Constant(i64::from(i16::MAX)),
                    line,
                )?;
                let Value::Bit(none) =
                    self.combined(Operator::Less, ends[0].clone(), ends[1].clone(), line)?
                else {
                    return Err(
                        Fault::new(line, "the loop's count is not followed").code(Code::LoopCount)
                    );
                };
                // A difference that does not fit 31 bits comes out below 0.
                let wraps = self.combined(
                    Operator::Less,
                    Value::Number(DINT, Number::Words(apart)),
                    Value::Constant(0),
                    line,
                )?;
                if let (Value::Bit(limit), Value::Bit(wraps)) = (limit, wraps) {
                    let beyond =
                        Logic::All(vec![none.clone().not(), Logic::Any(vec![limit, wraps])]);
                    let skip = self.jump(beyond.not(), None);
                    let here = self.builder.next();
                    self.builder.add(None, Vec::new(), Step::Unbounded { from: here });
                    self.land(skip);
                    self.landing();
                }
                if let WordSource::Cell(cell) = words[0] {
                    let zero = Write::Words(vec![WordTarget::Cell(cell)], constant(0, 1));
                    self.write_if(none, vec![zero], None);
                }
                (words[0], 0, i16::MAX.cast_unsigned().into())
            }
        };
        if most == 0 {
            return Ok(());
        }
        let begin = self.builder.add(
            Some(Self::key(&["FOR"], "loop")),
            Vec::new(),
            Step::ForBegin { count, least, most, end: 0 },
        );
        ways.loops.push([Vec::new(), Vec::new()]);
        self.statements(at, body, ways);
        let [again, out] = ways.loops.pop().unwrap_or_default();
        for jump in again {
            self.land(jump);
        }
        self.at(line, "END_FOR");
        self.landing();
        let now = self.value(at, &Expr::Variable(variable.clone()), line)?;
        let next = self.combined(Operator::Add, now, Value::Constant(by), line)?;
        self.assign(at, variable, next, line)?;
        let end = self.builder.add(Some(Self::key(&["END_FOR"], "loop")), Vec::new(), Step::ForEnd);
        if let Step::ForBegin { end: own, .. } = &mut self.builder.program.instructions[begin].step
        {
            *own = end;
        }
        for jump in out {
            self.land(jump);
        }
        self.landing();
        Ok(())
    }

    /// A call as a statement.
    fn called(
        &mut self,
        at: &Context,
        target: &Path,
        given: &[Argument],
        line: u32,
    ) -> Result<(), Fault> {
        if let Some(name) = target.as_name() {
            if self.body(at.instance, &What::Action(name.to_owned())).is_some() {
                let place = self.instances[at.instance].place.clone();
                self.hand_over(at, &place, &[], given, line)?;
                self.call(
                    Logic::Const(true),
                    at.instance,
                    What::Action(name.to_ascii_uppercase()),
                    "CAL",
                );
                return Ok(());
            }
            if self.method_of(at.instance, name).is_some() {
                return self.method(at, at.instance, name, given, line).map(|_| ());
            }
        }
        let place = self.find(at, target, line);
        if let Ok(Found::Place(place)) = place {
            return self.instance_called(at, &place, given, line);
        }
        if let Some((owner, name)) = target.split_last()
            && let Ok(Found::Place(owner)) = self.find(at, &owner, line)
        {
            let pou = match owner.ty {
                Ty::Block(pou, _) => Some(pou),
                _ => self
                    .by_name
                    .get(&owner.name.to_ascii_uppercase())
                    .map(|&own| self.instances[own].pou),
            };
            if let Some(pou) = pou {
                let instance = self.instance(&owner, pou);
                if self.body(instance, &What::Action(name.to_owned())).is_some() {
                    self.hand_over(at, &owner, &[], given, line)?;
                    self.call(
                        Logic::Const(true),
                        instance,
                        What::Action(name.to_ascii_uppercase()),
                        "CAL",
                    );
                    return Ok(());
                }
                return self.method(at, instance, name, given, line).map(|_| ());
            }
        }
        let is_function = |name: &str| {
            self.project
                .pous
                .iter()
                .any(|pou| pou.kind == PouKind::Function && same(&pou.name, name))
        };
        match target.as_name() {
            Some(name) if is_function(name) || given.iter().any(|one| one.is_output) => {
                self.function(at, target, given, line).map(|_| ())
            }
            _ => Err(unknown(line, &show::path(target))),
        }
    }

    fn instance_called(
        &mut self,
        at: &Context,
        place: &Place,
        given: &[Argument],
        line: u32,
    ) -> Result<(), Fault> {
        match place.ty.clone() {
            Ty::Standard(kind, _) => {
                let given: Vec<Argument> = named(kind, given);
                self.hand_over(at, place, &[], &given, line)?;
                self.standard_block(kind, place);
                self.take_back(at, place, &[], &given, line)
            }
            Ty::Block(pou, _) => {
                let instance = self.instance(place, pou);
                let all = lineage(self.project, pou);
                let variables: Vec<_> =
                    all.into_iter().rev().flat_map(|pou| pou.variables.clone()).collect();
                self.hand_over(at, place, &variables, given, line)?;
                self.call(Logic::Const(true), instance, What::Body, "CAL");
                self.take_back(at, place, &variables, given, line)
            }
            _ => match self.by_name.get(&place.name.to_ascii_uppercase()).copied() {
                Some(instance) => {
                    self.hand_over(at, place, &[], given, line)?;
                    self.call(Logic::Const(true), instance, What::Body, "CAL");
                    Ok(())
                }
                // A name alone does nothing.
                None => Ok(()),
            },
        }
    }
}

/// The arguments of a standard block with the names that those without one stand for.
fn named(kind: &str, given: &[Argument]) -> Vec<Argument> {
    let inputs: &[&str] = match kind {
        "TON" | "TOF" | "TP" => &["IN", "PT"],
        "CTU" => &["CU", "R", "PV"],
        "CTD" => &["CD", "LD", "PV"],
        "CTUD" => &["CU", "CD", "R", "LD", "PV"],
        "SR" => &["S1", "R"],
        "RS" => &["S", "R1"],
        _ => &["CLK"],
    };
    let with = |(at, one): (usize, &Argument)| Argument {
        name: one.name.clone().or_else(|| inputs.get(at).map(|name| (*name).to_owned())),
        ..one.clone()
    };
    given.iter().enumerate().map(with).collect()
}

fn is_empty(body: &Body) -> bool {
    matches!(body, Body::Code(_, statements) if statements.is_empty())
}

/// Whether statements assign to a variable.
fn writes_to(body: &[Statement], variable: &Path) -> bool {
    let mut found = false;
    crate::iec::ast::visit(body, &mut |one| {
        found |= match &one.kind {
            Statements::Assign(target, _)
            | Statements::Latch(target, ..)
            | Statements::For(target, ..) => {
                same(&target.first, &variable.first) && target.rest == variable.rest
            }
            Statements::Call(_, given) | Statements::CallIf(_, _, given) => given
                .iter()
                .any(|one| one.is_output && one.value == Expr::Variable(variable.clone())),
            _ => false,
        };
    });
    found
}

/// Whether statements call something.
fn makes_calls(body: &[Statement]) -> bool {
    let mut found = false;
    crate::iec::ast::visit(body, &mut |one| {
        found |= matches!(one.kind, Statements::Call(..) | Statements::CallIf(..));
    });
    found
}

/// Values that are kept on one way only hold what they held, or nothing, on the other.
fn merged(
    mut before: BTreeMap<String, Value>,
    after: &BTreeMap<String, Value>,
) -> BTreeMap<String, Value> {
    for (name, value) in after {
        before.entry(name.clone()).or_insert_with(|| value.clone());
    }
    before
}
