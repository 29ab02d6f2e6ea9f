//! Blocks of a drawing: function calls, instance calls and EXECUTE boxes.

use super::super::given::{Given, Side, Taker};
use super::super::paths::Found;
use super::super::resolver::Resolver;
use super::state::{Drawer, Key, Output, Use, at_element, resolved};
use super::worth::Worth;
use crate::blocks::StandardBlock;
use crate::show;
use crate::tree::StatementKind;
use crate::types::{TEXT, Type, TypeId};
use scanbound_base::code::Code;
use scanbound_iec::ast::{self, Path};
use scanbound_iec::drawing::{self, Block, Connection, Element, ElementId};
use scanbound_iec::fault::Fault;
use scanbound_iec::{PouKind, Section, same};
use std::collections::BTreeSet;

fn is_enable(name: &str) -> bool {
    name.eq_ignore_ascii_case("EN")
}

fn is_enabled(name: &str) -> bool {
    name.eq_ignore_ascii_case("ENO")
}

/// The inputs of a block: the value of EN, and the values of the other pins with their names.
type Inputs<'d> = (Worth, Vec<(Option<&'d str>, Worth)>);

impl<'d> Drawer<'_, '_, 'd> {
    /// Executes a block, unless it has been executed already.
    pub(super) fn block(&mut self, id: ElementId) -> Result<(), Fault> {
        let one = self.element(id);
        let Some(block) = one.block().filter(|_| self.progress.done.insert(id)) else {
            return Ok(());
        };
        let outer = std::mem::replace(&mut self.progress.owner, id);
        // Elements after a block in a feedback loop may be evaluated again while its inputs are evaluated.
        let sheet = self.sheet;
        let is_block = |id: &ElementId| sheet.drawing.element(*id).block().is_some();
        let (mut blocks, passed): (BTreeSet<_>, BTreeSet<_>) =
            std::mem::take(&mut self.open).into_iter().partition(is_block);
        blocks.insert(id);
        self.open = blocks;
        let asking = self.progress.acting;
        if self.is_generated {
            self.progress.acting = self.number(one);
        }
        let given = self.given(id, one, block);
        self.progress.acting = asking;
        self.open.remove(&id);
        self.open.extend(passed);
        let done = given.and_then(|given| self.call(id, one, block, given));
        self.progress.owner = outer;
        done
    }

    /// Evaluates the inputs of a block: EN and the other pins.
    fn given(
        &mut self,
        id: ElementId,
        one: &'d Element,
        block: &'d Block,
    ) -> Result<Inputs<'d>, Fault> {
        let mut given = Vec::new();
        let mut enable = self.truth(true, one.line);
        for is_in_out in [false, true] {
            let mut pins: Vec<_> =
                block.inputs.iter().filter(|pin| pin.is_in_out == is_in_out).collect();
            // Edges at pins may depend on EN, so it is evaluated first.
            if pins.iter().any(|pin| pin.edge.is_some()) {
                pins.sort_by_key(|pin| !is_enable(&pin.name));
            }
            for pin in pins {
                let mut value = match &pin.given {
                    drawing::Given::Nothing => continue,
                    drawing::Given::Written(written) => {
                        let written = written.as_ref().map_err(Fault::clone)?;
                        self.written(written, one)
                    }
                    drawing::Given::Wired(from) => self.used(one, from)?,
                };
                if let Some(edge) = self.edge_beside(pin.edge, pin.negated) {
                    let always = self.truth(true, one.line);
                    let looked_at = match enable.is_constant() {
                        true => always,
                        false => self.one_of(enable.clone(), always),
                    };
                    value = self.edge(one, (id, &pin.name), edge, value, looked_at)?;
                }
                if pin.negated {
                    // The negation of a constant takes time, too; but EN must stay a known constant.
                    value = if is_enable(&pin.name) { value.not() } else { value.negated() };
                }
                if pin.is_in_out || block.has_output(&pin.name) {
                    let key = (id, pin.name.to_ascii_lowercase());
                    self.progress.given_back.insert(key, value.clone());
                }
                if !is_enable(&pin.name) {
                    given.push((Some(&*pin.name).filter(|name| !name.is_empty()), value));
                } else if value.is_constant() || self.gives_enable(block) {
                    enable = value;
                } else {
                    enable = self.store(one, (id, "ENO"), value);
                }
            }
        }
        Ok((enable, given))
    }

    /// Emits the call of a block with evaluated inputs.
    fn call(
        &mut self,
        id: ElementId,
        one: &'d Element,
        block: &'d Block,
        (enable, given): Inputs<'d>,
    ) -> Result<(), Fault> {
        self.progress.enables.insert(id, enable.clone());
        if let Some(code) = &block.code {
            let code = code.as_ref().map_err(Fault::clone)?;
            self.execute(id, one, code, enable);
            return Ok(());
        }
        match &block.instance {
            Some(instance) => {
                let target = instance.as_ref().map_err(Fault::clone)?;
                self.is_of_its_type(one, block, target)?;
                let mut given: Vec<Given<'_>> = given.iter().map(handed_over).collect();
                // Generators pass EN to the call. For an instance, some controllers then pass the other inputs and
                // others skip the call.
                let is_passed = !self.sheet.drawing.is_executed_as_drawn && gives_to_enable(block);
                if is_passed {
                    given.push(Given { name: Some("EN"), side: Side::In(enable.value()) });
                }
                let jumps = !is_passed && !enable.is(true);
                let condition = jumps.then(|| enable.expr.clone());
                let scope = self.sheet.scope;
                let kind = self.resolver.call_if(scope, condition, target, &given, one.line);
                let text = format!("{}();", scanbound_iec::show::path(target));
                self.add(one.line, resolved(kind.map_err(|fault| at_element(one, fault))), text);
            }
            None => self.function(id, one, block, (enable, given))?,
        }
        self.written_beside(id, one, block)
    }

    /// Emits the call of a function with evaluated inputs.
    fn function(
        &mut self,
        id: ElementId,
        one: &'d Element,
        block: &'d Block,
        (enable, mut given): Inputs<'d>,
    ) -> Result<(), Fault> {
        if !self.sheet.drawing.is_executed_as_drawn
            && matches!(&block.outputs[..], [only] if is_enabled(&only.name))
        {
            let what = "only its output ENO is drawn: generators assign its result to ENO";
            let help = "draw its result, too";
            return Err(one.fault(what).code(Code::NotModelled).help(help));
        }
        if self.resolver.declares_output(block) {
            let what = "its first output is not its result, but a declared output";
            let help = "draw its result as the first output";
            return Err(one.fault(what).code(Code::NotModelled).help(help));
        }
        if block.are_counted(given.len()) {
            given.iter_mut().for_each(|(name, _)| *name = None);
        }
        // A condition reads the results, so they need variables.
        if self.sheet.drawing.goal.is_some() {
            let enable = block.outputs.iter().map(|pin| pin.name.as_str());
            let enable = enable.filter(|name| is_enabled(name) && self.gives_enable(block));
            for output in block.results().chain(enable).collect::<Vec<_>>() {
                self.declare_result((id, output), one, block)?;
            }
        }
        let mut all: Vec<Given<'_>> = given.iter().map(handed_over).collect();
        for other in block.results().skip(1) {
            if let Some(ty) = self.output_type(id, other, &mut BTreeSet::new()) {
                self.copies_large((id, other), ty);
            }
            let taker = self.result_taker((id, other));
            all.push(Given { name: Some(other), side: Side::Out(taker) });
        }
        if self.gives_enable(block) {
            let taker = self.result_taker((id, "ENO"));
            all.push(Given { name: Some("ENO"), side: Side::Out(taker) });
            let enabled = self.result((id, "ENO"), one.line);
            self.progress.enables.insert(id, enabled);
        }
        if !enable.is(true) || !self.sheet.drawing.is_executed_as_drawn && gives_to_enable(block) {
            all.push(Given { name: Some("EN"), side: Side::In(enable.value()) });
        }
        let path = block.function.clone()?;
        let of = scanbound_iec::show::path(&path);
        let scope = self.sheet.scope;
        let inputs = all.iter().filter_map(|given| match &given.side {
            Side::In(value) => Some(self.resolver.value(scope, value, one.line)),
            Side::Out(_) => None,
        });
        let inputs: Vec<_> = inputs.collect();
        let texts = inputs.iter().map(|value| show::expr(&self.resolver.tree, value));
        let shown = format!("{of}({})", texts.collect::<Vec<_>>().join(", "));
        let called = self.resolver.called(scope, &path, &all, one.line);
        let called =
            called.unwrap_or_else(|fault| self.resolver.faulty(at_element(one, fault), one.line));
        // The result of a function of strings whose type is not known, such as CONCAT, is a string.
        let longest = self.resolver.tree.types.id(Type::Text(TEXT));
        let is = |ty, of: fn(&Type) -> bool| of(self.resolver.tree.types.get(ty));
        let is_text = is(called.ty, |ty| matches!(ty, Type::Unknown))
            && inputs.iter().any(|value| is(value.ty, |ty| matches!(ty, Type::Text(_))));
        let ty = if is_text { longest } else { called.ty };
        self.copies_large((id, first_output(block)), ty);
        self.begins_anew(id, block);
        match self.result_taker((id, first_output(block))) {
            Taker::Kept(temporary) => {
                self.keep(one.line, temporary, called, Some(shown));
            }
            Taker::Variable(variable) => {
                let place = self.resolver.start(variable);
                let target = place.text.to_string();
                let kind = resolved(self.resolver.assigned(place, called, one.line));
                self.add(one.line, kind, format!("{target} := {shown};"));
            }
            Taker::Written(_) => {}
        }
        Ok(())
    }

    /// Generators declare a variable for each output of a function and copy strings, arrays and structures into it;
    /// strings have the standard's length there. Declares that variable.
    fn copies_large(&mut self, output: Output<'d>, ty: TypeId) {
        let longest = self.resolver.tree.types.id(Type::Text(TEXT));
        let large = match self.resolver.tree.types.get(ty) {
            Type::Text(length) if *length < TEXT => longest,
            Type::Text(_) | Type::Array(..) | Type::Struct(_) => ty,
            _ => return,
        };
        if !self.sheet.drawing.is_executed_as_drawn {
            let key = self.result_key(output);
            self.variable(key, large);
        }
    }

    /// The storage of a function's output: a variable if it is read before the function runs, otherwise a temporary.
    fn result_taker(&mut self, output: Output<'d>) -> Taker<'static> {
        let key = self.result_key(output);
        if let Some(&variable) = self.hidden.variables.get(&key) {
            return Taker::Variable(variable);
        }
        let ty = match is_enabled(output.1) {
            true => self.resolver.bool(),
            false => self.resolver.unknown(),
        };
        Taker::Kept(self.temporary(key, ty))
    }

    /// The key under which a function's output is stored.
    pub(super) fn result_key(&self, (id, output): Output<'d>) -> Key<'d> {
        let first = self.element(id).block().map_or("", first_output);
        let output = if output == first { "" } else { output };
        (Use::Result, (id, output), 1)
    }

    /// The stored value of a function's output.
    fn result(&mut self, output: Output<'d>, line: u32) -> Worth {
        let place = match self.result_taker(output) {
            Taker::Variable(id) => self.resolver.start(id),
            Taker::Kept(id) => self.resolver.kept_place(id),
            Taker::Written(_) => unreachable!("a drawing keeps it"),
        };
        Worth::variable(place, line)
    }

    /// The value that the previous scan left at an output. For a function's result, a variable of the unit is declared,
    /// as generators do.
    pub(super) fn fed_back(
        &mut self,
        (id, output): Output<'d>,
        one: &'d Element,
    ) -> Result<Worth, Fault> {
        let Some(block) = one.block().filter(|block| block.instance.is_none()) else {
            return Ok(self.block_output(id, output));
        };
        let is_enable = is_enabled(output);
        let named = if output.is_empty() { first_output(block) } else { output };
        self.declare_result((id, named), one, block)?;
        if is_enable {
            return Ok(self.result((id, "ENO"), one.line));
        }
        Ok(self.block_output(id, output))
    }

    /// Declares a variable for a function's output; a fault if its type is not known.
    fn declare_result(
        &mut self,
        (id, named): Output<'d>,
        one: &Element,
        block: &'d Block,
    ) -> Result<(), Fault> {
        let is_own = match is_enabled(named) {
            true => self.gives_enable(block),
            false => block.results().any(|own| own == named),
        };
        let known = self.output_type(id, named, &mut BTreeSet::new());
        let Some(ty) = known.filter(|_| is_own) else {
            let what = "its result is read before it is computed, and its type is not known";
            let help = "write the result to a variable, and read that instead";
            return Err(one.fault(what).code(Code::NotModelled).help(help));
        };
        let key = self.result_key((id, named));
        // The variable that was declared for its first value is used for the result.
        if let Some(&begun) = self.hidden.variables.get(&(Use::Begun, (id, named), 1)) {
            self.hidden.is_stale |= self.hidden.variables.insert(key, begun).is_none();
        }
        let variable = self.variable(key, ty);
        self.note_for_condition(variable, one, Some(named));
        Ok(())
    }

    /// In functions, generators declare a variable for each result of a drawn function and initialize it in each call.
    fn begins_anew(&mut self, id: ElementId, block: &'d Block) {
        let unit = self.sheet.scope.unit.filter(|_| self.sheet.scope.method.is_none());
        let is_function = match unit {
            Some(unit) => self.resolver.tree.unit(unit).kind == PouKind::Function,
            None => true,
        };
        if !is_function || self.sheet.drawing.is_executed_as_drawn {
            return;
        }
        let enable =
            block.outputs.iter().map(|pin| pin.name.as_str()).find(|name| is_enabled(name));
        for output in block.results().chain(enable) {
            let result = self.hidden.variables.get(&self.result_key((id, output)));
            // A variable that keeps the result is initialized like the function's other variables.
            if result.is_some() {
                continue;
            }
            let ty = self.output_type(id, output, &mut BTreeSet::new());
            let ty = ty.unwrap_or_else(|| self.resolver.bool());
            self.variable((Use::Begun, (id, output), 1), ty);
        }
    }

    /// Whether ENO of a function is stored in a variable, as generators do.
    fn gives_enable(&self, block: &Block) -> bool {
        !self.sheet.drawing.is_executed_as_drawn && block.gives_enable()
    }

    /// Rejects a standard block that is drawn with another type than its instance has.
    fn is_of_its_type(
        &mut self,
        one: &Element,
        block: &Block,
        instance: &Path,
    ) -> Result<(), Fault> {
        let found = self.resolver.one_path(self.sheet.scope, instance, one.line);
        let declared = match found {
            Ok(Found::Place(place)) => Some(self.resolver.tree.types.get(place.ty)),
            _ => None,
        };
        let (Some(Type::Standard(declared)), Some(drawn)) =
            (declared, StandardBlock::named(&block.of))
        else {
            return Ok(());
        };
        if *declared == drawn {
            return Ok(());
        }
        let name = scanbound_iec::show::path(instance);
        let what = format!("it is drawn as {}, and {name} is a {}", block.of, declared.name());
        Err(one.fault(&what))
    }

    /// Emits the statements of an EXECUTE box, under the condition EN.
    fn execute(&mut self, id: ElementId, one: &Element, code: &[ast::Statement], enable: Worth) {
        let scope = self.sheet.scope;
        if enable.is(true) {
            for statement in code {
                let found = self.resolver.statement(scope, statement, self.labels);
                self.add(found.line, found.kind, found.text.to_string());
            }
            return;
        }
        let key = (Use::Enable, (id, ""), 1);
        let temporary = self.temporary(key, enable.expr.ty);
        let (loaded, _) = self.keep(one.line, temporary, enable.expr.clone(), None);
        self.progress.enables.insert(id, loaded);
        let body = self.resolver.statements(scope, code, self.labels);
        let text = format!("IF {} THEN", show::expr(&self.resolver.tree, &enable.expr));
        self.add(one.line, StatementKind::If(vec![(enable.expr, body)], Vec::new()), text);
    }

    /// Writes the variables drawn directly at a block's outputs (CODESYS, TwinCAT).
    fn written_beside(
        &mut self,
        id: ElementId,
        one: &'d Element,
        block: &'d Block,
    ) -> Result<(), Fault> {
        for pin in &block.outputs {
            let Some((target, line)) = &pin.written else { continue };
            let target = target.as_ref().map_err(Fault::clone)?;
            let value = self.block_output(id, &pin.name);
            let is_taken = self.takes_over(id, &pin.name);
            let scope = self.sheet.scope;
            let kind = resolved(self.resolver.assign(scope, target, &value.value(), *line));
            let shown = scanbound_iec::show::path(target);
            let at = if is_taken.is(true) { *line } else { one.line };
            self.add_if(at, is_taken, kind, &shown);
        }
        Ok(())
    }

    /// The value of EN with which a block was executed; TRUE if none is recorded.
    fn enabled(&self, id: ElementId) -> Worth {
        let known = self.progress.enables.get(&id).cloned();
        known.unwrap_or_else(|| self.truth(true, self.element(id).line))
    }

    /// The condition under which an element uses its incoming value instead of keeping its variable.
    pub(super) fn is_taken(&mut self, from: &'d [Connection]) -> Worth {
        match from {
            [one] => self.takes_over(one.from, &one.output),
            _ => self.truth(true, 0),
        }
    }

    /// The condition under which an output's value is used. An output of a disabled function is not used. For a
    /// disabled function block controllers differ; for ENO generators use the value only if it is TRUE.
    fn takes_over(&mut self, id: ElementId, output: &str) -> Worth {
        let one = self.element(id);
        let always = self.truth(true, one.line);
        let Some(block) = one.block() else { return always };
        let is_told = is_enabled(output) || block.code.is_some();
        if is_told && self.sheet.drawing.is_executed_as_drawn {
            return always;
        }
        let enable = self.enabled(id);
        match enable.is(true) || !is_told && block.instance.is_none() {
            true => enable,
            false => self.one_of(enable, always),
        }
    }

    /// The value of an output of a block that has been executed.
    pub(super) fn block_output(&mut self, id: ElementId, output: &'d str) -> Worth {
        let one = self.element(id);
        let Some(block) = one.block().filter(|block| !is_enabled(output) && block.code.is_none())
        else {
            return self.enabled(id);
        };
        let named = if output.is_empty() { first_output(block) } else { output };
        let is_negated = block.negates(named);
        let given_back = self.progress.given_back.get(&(id, named.to_ascii_lowercase()));
        let value = match (given_back, &block.instance) {
            (Some(given_back), _) => given_back.clone(),
            (None, Some(Ok(instance))) => {
                let read = ast::Expr::Variable(instance.clone().with(named));
                self.written(&read, one)
            }
            (None, Some(Err(fault))) => {
                let expr = self.resolver.faulty(fault.clone(), one.line);
                Worth::formula(expr)
            }
            (None, None) => self.result((id, named), one.line),
        };
        if is_negated { value.not() } else { value }
    }
}

impl Resolver<'_> {
    /// Whether the first output drawn at a function is an output parameter of a function or method of that name, not
    /// its result.
    fn declares_output(&self, block: &Block) -> bool {
        let Ok(path) = &block.function else { return false };
        let of = path.split_last().map_or(path.first.as_str(), |(_, last)| last);
        let named = first_output(block);
        let units = self.tree.units.iter().filter(|unit| same(&unit.name, of));
        let routines = self.tree.routines.iter().filter(|one| same(&one.name, of));
        let all = units.flat_map(|one| one.variables.iter().filter(|id| one.result != Some(**id)));
        let all = all.chain(
            routines.flat_map(|one| one.variables.iter().filter(|id| one.result != Some(**id))),
        );
        { all }.map(|&id| self.tree.variable(id)).any(|one| {
            same(&one.name, named) && matches!(one.section, Section::Output | Section::InOut)
        })
    }
}

/// Whether the block's EN pin has a value.
fn gives_to_enable(block: &Block) -> bool {
    let is_given = |pin: &drawing::InputPin| !matches!(pin.given, drawing::Given::Nothing);
    block.inputs.iter().any(|pin| is_enable(&pin.name) && !pin.is_in_out && is_given(pin))
}

/// The name of the block's first output other than ENO; empty if there is none.
pub(super) fn first_output(block: &Block) -> &str {
    block.results().next().unwrap_or_default()
}

fn handed_over<'a>((name, value): &'a (Option<&'a str>, Worth)) -> Given<'a> {
    Given { name: *name, side: Side::In(value.value()) }
}
