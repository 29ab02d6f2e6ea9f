//! Resolution of calls: the target, and the argument of each parameter.

use super::given::{Given, Side, Value};
use super::paths::{Found, Property, property_here};
use super::resolver::{Resolver, Scope, unknown_name};
use super::types::declare;
use crate::blocks::StandardBlock;
use crate::declarations::{RoutineId, RoutineKind, UnitId, VarId};
use crate::standard::Function;
use crate::tree::{
    Applied, Call, Enable, Expr, ExprKind, Parameter, Passed, Place, Root, Statement,
    StatementKind, Step, Target,
};
use crate::types::{Type, TypeId};
use scanbound_base::code::Code;
use scanbound_iec::ast::{self, Part, Path};
use scanbound_iec::fault::Fault;
use scanbound_iec::{Pou, PouKind, Section, same, show};

/// The declaration whose parameters the arguments are matched with.
#[derive(Clone, Copy)]
enum Callee {
    /// A function, or an instance of a function block.
    Unit(UnitId),
    /// The base of the current unit, for `SUPER^()`.
    Base(UnitId),
    /// A method of a unit.
    Method(RoutineId),
    /// A program or an action of the unit: only arguments named after the unit's variables are accepted.
    Named(UnitId),
    /// A standard block.
    Standard(StandardBlock),
}

/// The maximum number of inputs of a standard function.
const MAX_INPUTS: usize = 200;

impl Resolver<'_> {
    /// Resolves a call in an expression: of a method, a function, or a standard function.
    pub(super) fn called(
        &mut self,
        scope: Scope,
        path: &Path,
        given: &[Given<'_>],
        line: u32,
    ) -> Result<Expr, Fault> {
        let own = path.as_name().filter(|name| self.has_member(scope, name));
        if let (Some(name), Some(unit)) = (own, scope.unit)
            && let Some(method) = self.index.method(unit, name)
        {
            let place = self.this(unit);
            return self.method(scope, place, method, given, line);
        }
        if same(&path.first, "SUPER") {
            let mut names = path.rest.iter().filter(|part| **part != Part::Dereference);
            let (Some(Part::Name(name)), None) = (names.next(), names.next()) else {
                return Err(unknown_name(line, &show::path(path)));
            };
            let base = self.base(scope, line)?;
            let Some(method) = self.index.method(base, name) else {
                return Err(unknown_name(line, &show::path(path)));
            };
            return self.method_call(scope, Target::BaseMethod(method), base, method, given, line);
        }
        if let Some(name) = path.as_name() {
            if let Some(found) = self.measured(scope, name, given, line)? {
                return Ok(found);
            }
            self.note_global(scope, name);
            if let Some(unit) = self.index.function(name) {
                let (passed, enable) = self.passed(scope, Callee::Unit(unit), given, line)?;
                let result = self.tree.unit(unit).result;
                let ty = self.result_type(result);
                let call = Call { target: Target::Function(unit), passed, enable };
                return Ok(Expr { kind: ExprKind::Call(Box::new(call)), ty, line });
            }
            return self.standard(scope, name, given, line);
        }
        if let Some((owner, name)) = path.split_last() {
            let place = self.owner(scope, &owner, line)?;
            if let Type::Block(unit) = *self.tree.types.get(place.ty)
                && let Some(method) = self.index.method(unit, name)
            {
                return self.method(scope, place, method, given, line);
            }
        }
        Err(unknown_name(line, &show::path(path)))
    }

    /// A read of a property: the call of its getter.
    pub(super) fn property_read(
        &mut self,
        scope: Scope,
        property: &Property,
        line: u32,
    ) -> Result<Expr, Fault> {
        let name = scanbound_iec::getter(&property.name);
        self.accessor(scope, property, &name, &[], line)
    }

    /// A write of a property: the call of its setter.
    pub(super) fn property_written(
        &mut self,
        scope: Scope,
        property: &Property,
        value: &Value<'_>,
        line: u32,
    ) -> Result<StatementKind, Fault> {
        let given = [Given { name: Some(&property.name), side: Side::In(value.clone()) }];
        let name = scanbound_iec::setter(&property.name);
        self.accessor(scope, property, &name, &given, line).map(as_statement)
    }

    fn accessor(
        &mut self,
        scope: Scope,
        property: &Property,
        name: &str,
        given: &[Given<'_>],
        line: u32,
    ) -> Result<Expr, Fault> {
        let Some(method) = self.index.method(property.unit, name) else {
            return Err(unknown_name(line, &format!("{}.{name}", property.owner.text)));
        };
        let target = match property.of_base {
            true => Target::BaseMethod(method),
            false => Target::Method(property.owner.clone(), method),
        };
        self.method_call(scope, target, property.unit, method, given, line)
    }

    fn result_type(&mut self, result: Option<VarId>) -> TypeId {
        match result {
            Some(result) => self.tree.variable(result).ty,
            None => self.tree.types.id(Type::Nothing),
        }
    }

    /// The base unit of the unit that contains the code; a fault if there is none.
    fn base(&self, scope: Scope, line: u32) -> Result<UnitId, Fault> {
        let base = scope.unit.and_then(|unit| self.tree.unit(unit).base);
        base.ok_or_else(|| {
            let help = "give the file that declares what it extends";
            unknown_name(line, "SUPER^").help(help)
        })
    }

    /// Whether the name alone refers to an action or method of the unit that contains the code.
    fn has_member(&self, scope: Scope, name: &str) -> bool {
        let is_local = scope.method.is_some_and(|method| self.index.local(method, name).is_some());
        !is_local
            && scope.unit.is_some_and(|unit| {
                self.index.action(unit, name).is_some() || self.index.method(unit, name).is_some()
            })
    }

    fn method(
        &mut self,
        scope: Scope,
        place: Place,
        method: RoutineId,
        given: &[Given<'_>],
        line: u32,
    ) -> Result<Expr, Fault> {
        let unit = match *self.tree.types.get(place.ty) {
            Type::Block(unit) => unit,
            _ => self.tree.routine(method).unit,
        };
        self.method_call(scope, Target::Method(place, method), unit, method, given, line)
    }

    fn method_call(
        &mut self,
        scope: Scope,
        target: Target,
        unit: UnitId,
        method: RoutineId,
        given: &[Given<'_>],
        line: u32,
    ) -> Result<Expr, Fault> {
        self.has_one_default(unit, method, given, line)?;
        let (passed, enable) = self.passed(scope, Callee::Method(method), given, line)?;
        let result = self.tree.routine(method).result;
        let ty = self.result_type(result);
        let call = Call { target, passed, enable };
        Ok(Expr { kind: ExprKind::Call(Box::new(call)), ty, line })
    }

    /// Rejects a call that omits an input if another declaration of the method has a different default: it is unknown
    /// which declaration applies.
    fn has_one_default(
        &self,
        unit: UnitId,
        method: RoutineId,
        given: &[Given<'_>],
        line: u32,
    ) -> Result<(), Fault> {
        let name = &self.tree.routine(method).name;
        let of = |pou: &'_ Pou| pou.kind == PouKind::Interface;
        // Through derived or base units, a call may refer to their declarations.
        let is_related = |one: &UnitId| {
            self.tree.lineage(*one).contains(&unit) || self.tree.lineage(unit).contains(one)
        };
        let family = (0..self.tree.units.len()).map(UnitId::at).filter(is_related);
        let family = family.map(|one| &self.project.pous[one.index()]);
        let all = family.chain(self.project.pous.iter().filter(|one| of(one)));
        let others: Vec<&Pou> =
            all.flat_map(|pou| &pou.methods).filter(|one| same(&one.name, name)).collect();
        let inputs: Vec<VarId> = self.parameters(Callee::Method(method));
        let mut unnamed = inputs.iter();
        let handed: Vec<&str> = given
            .iter()
            .filter_map(|one| match one.name {
                Some(name) => Some(name),
                None => unnamed.next().map(|&id| self.tree.variable(id).name.as_str()),
            })
            .collect();
        let declared = self.tree.routine(method).unit;
        let declared = self.project.pous[declared.index()].methods.iter();
        let Some(own) = { declared }.find(|one| same(&one.name, name)) else { return Ok(()) };
        let is_input = |one: &&scanbound_iec::Variable| one.section == Section::Input;
        let left_out = own.variables.iter().filter(is_input).find(|own| {
            !handed.iter().any(|name| same(name, &own.name))
                && others.iter().any(|other| {
                    let also = other.variables.iter().find(|one| same(&one.name, &own.name));
                    also.is_some_and(|also| also.initial != own.initial)
                })
        });
        let Some(own) = left_out else { return Ok(()) };
        let told = format!(
            "{} of {name} is left out, and its default differs between declarations",
            own.name
        );
        Err(Fault::new(line, told).code(Code::NotModelled).help("pass it"))
    }

    /// The inputs and VAR_IN_OUT, in the order of positional arguments.
    fn parameters(&self, callee: Callee) -> Vec<VarId> {
        let all = match callee {
            Callee::Unit(unit) | Callee::Base(unit) => self.tree.members(unit),
            Callee::Method(method) => self.tree.routine(method).variables.clone(),
            Callee::Named(_) | Callee::Standard(_) => Vec::new(),
        };
        let is_input =
            |id: &VarId| matches!(self.tree.variable(*id).section, Section::Input | Section::InOut);
        all.into_iter().filter(is_input).collect()
    }

    fn parameter(&self, callee: Callee, name: &str) -> Option<Parameter> {
        let variable = match callee {
            Callee::Unit(unit) | Callee::Base(unit) | Callee::Named(unit) => {
                self.index.member(unit, name)
            }
            Callee::Method(method) => self.index.local(method, name),
            Callee::Standard(block) => return block.pin(name).map(Parameter::Pin),
        };
        variable.map(Parameter::Variable)
    }

    /// The instance before the dot of a method or action; an interface is dereferenced.
    fn owner(&mut self, scope: Scope, path: &Path, line: u32) -> Result<Place, Fault> {
        let mut place = match self.path(scope, path, line)? {
            Found::Property(property) => self.given_whole(scope, property, line)?,
            _ => self.place(scope, path, line)?,
        };
        if let Type::Interface(unit) = *self.tree.types.get(place.ty) {
            place.steps.push(Step::Dereference);
            place.ty = self.block(unit);
        }
        Ok(place)
    }

    /// The place of a reference itself, not of its target.
    pub(super) fn reference_place(
        &mut self,
        scope: Scope,
        path: &Path,
        line: u32,
    ) -> Result<Place, Fault> {
        match self.reference(scope, path, line)? {
            Found::Place(place) => Ok(place),
            _ => {
                let told = format!("{} is not a reference", show::path(path));
                Err(Fault::new(line, told).code(Code::Operand))
            }
        }
    }

    fn parameter_type(&self, parameter: Parameter) -> TypeId {
        match parameter {
            Parameter::Pin(pin) => self.tree.types.elementary(pin.of()),
            Parameter::Variable(id) => self.tree.variable(id).ty,
        }
    }

    fn callee_name(&self, callee: Callee) -> &str {
        match callee {
            Callee::Unit(unit) | Callee::Base(unit) | Callee::Named(unit) => {
                &self.tree.unit(unit).name
            }
            Callee::Method(method) => &self.tree.routine(method).name,
            Callee::Standard(block) => block.name(),
        }
    }

    /// Matches arguments with parameters.
    fn passed(
        &mut self,
        scope: Scope,
        callee: Callee,
        given: &[Given<'_>],
        line: u32,
    ) -> Result<(Vec<(Parameter, Passed)>, Enable), Fault> {
        let inputs = self.parameters(callee);
        let mut unnamed = inputs.iter().map(|&one| Parameter::Variable(one));
        let mut found = Vec::new();
        let mut enable = self.enable(scope, given, line)?;
        enable.is_input = self.parameter(callee, "EN").is_some();
        enable.is_output = self.parameter(callee, "ENO").is_some();
        for (at, one) in given.iter().enumerate() {
            let parameter = match (one.name, callee) {
                (Some(name), _) => self.parameter(callee, name),
                (None, Callee::Standard(block)) => {
                    block.inputs().get(at).map(|&pin| Parameter::Pin(pin))
                }
                (None, _) => match unnamed.next() {
                    Some(parameter) => Some(parameter),
                    None => {
                        let told = format!("{} has fewer inputs", self.callee_name(callee));
                        return Err(Fault::new(line, told));
                    }
                },
            };
            let value = match &one.side {
                Side::In(value) => value,
                Side::Out(taker) => {
                    let Some(parameter) = parameter else { continue };
                    let ty = self.parameter_type(parameter);
                    let passed = match self.taken(scope, taker, ty, line)? {
                        Some((place, negated)) => Passed::Output(place, negated),
                        None => Passed::Dropped,
                    };
                    found.push((parameter, passed));
                    continue;
                }
            };
            if one.is_named("EN") && parameter.is_none() {
                continue;
            }
            let Some(parameter) = parameter else {
                let name = one.name.unwrap_or_default();
                let told = format!("{}.{name}", self.callee_name(callee));
                return Err(unknown_name(line, &told));
            };
            let ty = self.parameter_type(parameter);
            let value = self.value_for(scope, value, ty, line);
            found.push((parameter, self.pass(parameter, value, line)?));
        }
        if matches!(callee, Callee::Unit(_) | Callee::Method(_)) {
            self.leaves_none_out(&inputs, &found, line)?;
        }
        Ok((found, enable))
    }

    fn pass(&mut self, parameter: Parameter, value: Expr, line: u32) -> Result<Passed, Fault> {
        let variable = match parameter {
            Parameter::Pin(pin) => {
                let ty = self.tree.types.elementary(pin.of());
                return Ok(Passed::ByValue(self.converted(value, ty)));
            }
            Parameter::Variable(id) => self.tree.variable(id),
        };
        let (ty, section, name) = (variable.ty, variable.section, variable.name.clone());
        if let ExprKind::Read(place) = &value.after_calls().kind
            && !matches!(place.root, Root::Temporary(_))
        {
            self.has_own_type(&name, ty, place.ty, line)?;
        }
        Ok(match section {
            Section::InOut if matches!(value.kind, ExprKind::After(_)) => {
                return Err(property_here(line, &name));
            }
            Section::InOut => Passed::InOut(value),
            _ => Passed::ByValue(self.converted(value, ty)),
        })
    }

    /// Rejects an instance passed to or copied into a variable of another block type, such as a base: calls through it
    /// would have to be dispatched.
    pub(super) fn has_own_type(
        &self,
        name: &str,
        target: TypeId,
        value: TypeId,
        line: u32,
    ) -> Result<(), Fault> {
        if target == value || !self.tree.holds(target, &|of| matches!(of, Type::Block(_))) {
            return Ok(());
        }
        let message = format!(
            "the value of {name} has another block type: which methods are called through it is not followed"
        );
        let help = "declare it with the type of the instance, or pass a reference or an interface";
        Err(Fault::new(line, message).code(Code::NotModelled).help(help))
    }

    /// Rejects a call that omits a VAR_IN_OUT argument.
    fn leaves_none_out(
        &self,
        inputs: &[VarId],
        found: &[(Parameter, Passed)],
        line: u32,
    ) -> Result<(), Fault> {
        let mut both =
            inputs.iter().filter(|&&one| self.tree.variable(one).section == Section::InOut);
        let is_given = |id: VarId| found.iter().any(|(own, _)| *own == Parameter::Variable(id));
        let Some(&left_out) = both.find(|&&one| !is_given(one)) else { return Ok(()) };
        let name = &self.tree.variable(left_out).name;
        let message = format!("{name} is VAR_IN_OUT, and this call leaves it out");
        let help = "pass it in every call: controllers differ in what a call without it does";
        Err(Fault::new(line, message).code(Code::NotModelled).help(help))
    }

    fn enable(&mut self, scope: Scope, given: &[Given<'_>], line: u32) -> Result<Enable, Fault> {
        let mut found = Enable::default();
        for one in given {
            match &one.side {
                Side::In(value) if one.is_named("EN") && found.condition.is_none() => {
                    found.condition = Some(self.value(scope, value, line));
                }
                Side::Out(taker) if one.is_named("ENO") && found.result.is_none() => {
                    let bool = self.bool();
                    found.result = self.taken(scope, taker, bool, line)?;
                }
                _ => {}
            }
        }
        Ok(found)
    }

    /// Evaluates `SIZEOF`, `LOWER_BOUND` and `UPPER_BOUND`, and resolves `ADR`, `REF` and `__ISVALIDREF`. `None` if it
    /// is another call or the value is not known.
    fn measured(
        &mut self,
        scope: Scope,
        name: &str,
        given: &[Given<'_>],
        line: u32,
    ) -> Result<Option<Expr>, Fault> {
        let upper = name.to_ascii_uppercase();
        if self.index.unit(name).is_some() || given.iter().any(Given::is_output) {
            return Ok(None);
        }
        let (of, which) = match given {
            [of] => (of, None),
            [of, which] => (of, Some(which)),
            _ => return Ok(None),
        };
        let Some(Value::Written(of)) = of.value() else { return Ok(None) };
        let ast::Expr::Variable(path) = of else { return Ok(None) };
        if which.is_none() && ["ADR", "REF", "__ISVALIDREF"].contains(&upper.as_str()) {
            if upper == "__ISVALIDREF" {
                let word = self.address(scope, of, line);
                let none = self.null(line);
                return Ok(Some(self.operation(ast::Operator::NotEqual, word, none)));
            }
            let place = self.place(scope, path, line)?;
            return self.address_of(place, line).map(Some);
        }
        if !["SIZEOF", "LOWER_BOUND", "UPPER_BOUND"].contains(&upper.as_str()) {
            return Ok(None);
        }
        let which = match which.and_then(Given::value) {
            None => Some(1),
            Some(which) => self.value(scope, which, line).whole(),
        };
        let place = match self.one_path(scope, path, line) {
            Ok(Found::Place(place)) => place,
            _ => return Ok(None),
        };
        let bound = |high: bool| match self.tree.types.get(place.ty) {
            Type::Array(dimensions, _) => {
                let at = usize::try_from(which? - 1).ok()?;
                let (low, most) = dimensions.get(at)?;
                Some(if high { *most } else { *low })
            }
            _ => None,
        };
        let found = match upper.as_str() {
            "SIZEOF" => self.bytes(place.ty),
            "LOWER_BOUND" => bound(false),
            _ => bound(true),
        };
        let Some(found) = found else { return Ok(None) };
        let applied = Applied {
            function: Function::Measured(found),
            name: upper,
            inputs: Vec::new(),
            order: Some(Vec::new()),
            outputs: Vec::new(),
            enable: Enable::default(),
        };
        let ty = self.tree.types.id(Type::Untyped);
        Ok(Some(Expr { kind: ExprKind::Standard(Box::new(applied)), ty, line }))
    }

    /// The size of a type in bytes; `None` if it may differ between controllers, as with structures.
    fn bytes(&self, ty: TypeId) -> Option<i64> {
        use crate::types::Kind;
        match self.tree.types.get(ty) {
            Type::Elementary(of) => match of.kind() {
                None => Some(1),
                Some(Kind::Whole { bits, .. }) => Some(i64::from(bits / 8)),
                Some(Kind::Real | Kind::Time) => Some(4),
                Some(Kind::Opaque(_)) => None,
            },
            Type::Array(dimensions, of) => {
                let counts = dimensions.iter().map(|(low, high)| high - low + 1);
                { counts }.try_fold(self.bytes(*of)?, i64::checked_mul)
            }
            _ => None,
        }
    }

    /// Resolves a call of a standard function.
    fn standard(
        &mut self,
        scope: Scope,
        name: &str,
        given: &[Given<'_>],
        line: u32,
    ) -> Result<Expr, Fault> {
        let Some(function) = Function::named(name) else {
            let help = declare("give all files of the project", name);
            return Err(unknown_name(line, &format!("function {name}")).help(help));
        };
        let enable = self.enable(scope, given, line)?;
        let inputs: Vec<&Given<'_>> =
            given.iter().filter(|one| !one.is_output() && !one.is_named("EN")).collect();
        if inputs.len() > MAX_INPUTS {
            let told = format!("{} has more than {MAX_INPUTS} inputs", name.to_ascii_uppercase());
            let help = "give a part of them to another call";
            return Err(Fault::new(line, told).code(Code::NotModelled).help(help));
        }
        let order = in_order(&inputs);
        let mut values = Vec::new();
        for value in inputs.into_iter().filter_map(Given::value) {
            values.push(self.value(scope, value, line));
        }
        let mut outputs = Vec::new();
        for one in given.iter().filter(|one| !one.is_named("ENO")) {
            if let Side::Out(taker) = &one.side {
                let unknown = self.unknown();
                let taken = self.taken(scope, taker, unknown, line)?;
                // The output may be any value, so its negation needs no record.
                outputs.extend(taken.map(|(place, _)| place));
            }
        }
        let types: Vec<TypeId> = match &order {
            Some(order) => order.iter().map(|&at| values[at].ty).collect(),
            None => Vec::new(),
        };
        let ty = function.result(&mut self.tree.types, &types);
        let name = name.to_ascii_uppercase();
        let applied = Applied { function, name, inputs: values, order, outputs, enable };
        Ok(Expr { kind: ExprKind::Standard(Box::new(applied)), ty, line })
    }

    /// Resolves a call as a statement.
    pub(super) fn call_statement(
        &mut self,
        scope: Scope,
        target: &Path,
        given: &[Given<'_>],
        line: u32,
    ) -> Result<StatementKind, Fault> {
        let own = target.as_name().filter(|name| self.has_member(scope, name));
        if let (Some(name), Some(unit)) = (own, scope.unit) {
            let place = self.this(unit);
            if let Some(found) = self.member_called(scope, place, unit, name, given, line)? {
                return Ok(found);
            }
        }
        if same(&target.first, "SUPER") {
            if target.rest.iter().any(|part| *part != Part::Dereference) {
                return self.called(scope, target, given, line).map(as_statement);
            }
            let base = self.base(scope, line)?;
            let (passed, enable) = self.passed(scope, Callee::Base(base), given, line)?;
            return Ok(StatementKind::Call(Call {
                target: Target::BaseBody(base),
                passed,
                enable,
            }));
        }
        let around = self.before.len();
        match self.path(scope, target, line) {
            Ok(Found::Place(place)) => {
                let hides =
                    target.as_name().is_some_and(|name| self.index.function(name).is_some());
                return self.instance_called(scope, place, given, hides, line);
            }
            Ok(Found::Property(_)) if !given.is_empty() => {
                return Err(property_here(line, &show::path(target)));
            }
            Ok(Found::Property(property)) => {
                let kind = as_statement(self.property_read(scope, &property, line)?);
                let read = Statement { kind, text: show::path(target).into(), line };
                let what = "a property that stands alone is read";
                return Ok(StatementKind::Either(what, vec![read], Vec::new()));
            }
            _ => self.before.truncate(around),
        }
        if let Some((owner, name)) = target.split_last()
            && let Ok(place) = self.owner(scope, &owner, line)
            && let Type::Block(unit) = *self.tree.types.get(place.ty)
        {
            let found = self.member_called(scope, place, unit, name, given, line)?;
            return found.ok_or_else(|| unknown_name(line, &show::path(target)));
        }
        match target.as_name() {
            Some(name)
                if self.index.function(name).is_some() || given.iter().any(Given::is_output) =>
            {
                self.called(scope, target, given, line).map(as_statement)
            }
            _ => Err(unknown_name(line, &show::path(target))),
        }
    }

    /// Resolves a call of an instance's action or method; `None` if the unit has none of this name.
    fn member_called(
        &mut self,
        scope: Scope,
        place: Place,
        unit: UnitId,
        name: &str,
        given: &[Given<'_>],
        line: u32,
    ) -> Result<Option<StatementKind>, Fault> {
        if let Some(action) = self.index.action(unit, name) {
            let (passed, enable) = self.passed(scope, Callee::Named(unit), given, line)?;
            let call = Call { target: Target::Action(place, action), passed, enable };
            return Ok(Some(StatementKind::Call(call)));
        }
        let Some(method) = self.index.method(unit, name) else { return Ok(None) };
        debug_assert_eq!(self.tree.routine(method).kind, RoutineKind::Method);
        self.method(scope, place, method, given, line).map(|found| Some(as_statement(found)))
    }

    fn instance_called(
        &mut self,
        scope: Scope,
        place: Place,
        given: &[Given<'_>],
        hides_function: bool,
        line: u32,
    ) -> Result<StatementKind, Fault> {
        let (target, callee) = match *self.tree.types.get(place.ty) {
            Type::Standard(block) => (Target::Standard(place, block), Callee::Standard(block)),
            Type::Block(unit) if self.tree.unit(unit).kind == PouKind::Program => {
                (Target::Program(place, unit), Callee::Named(unit))
            }
            Type::Block(unit) => (Target::Instance(place, unit), Callee::Unit(unit)),
            _ if hides_function || !given.is_empty() => {
                let what = format!("{} is a variable, which cannot be called", place.text);
                let help = "rename the variable if the function of this name is meant";
                return Err(Fault::new(line, what).code(Code::NotModelled).help(help));
            }
            // It is unknown whether a controller evaluates the calls in indices of a name that stands alone.
            _ if place.indices().any(Expr::calls) => {
                let what =
                    format!("{} stands alone, and an index of it contains a call", place.text);
                let help =
                    "assign it to a variable, or call the function in a statement of its own";
                return Err(Fault::new(line, what).code(Code::NotModelled).help(help));
            }
            // A name that stands alone has no effect.
            _ => return Ok(StatementKind::Nothing),
        };
        let (passed, enable) = self.passed(scope, callee, given, line)?;
        Ok(StatementKind::Call(Call { target, passed, enable }))
    }
}

/// Turns a call expression into a statement that drops the result.
fn as_statement(one: Expr) -> StatementKind {
    match one.kind {
        ExprKind::Call(call) => StatementKind::Call(*call),
        ExprKind::Standard(applied) => StatementKind::Standard(*applied),
        ExprKind::Fault(fault) => StatementKind::Fault(fault),
        _ => {
            let what = "its value is not used: whether a controller computes it is not known";
            let help = "assign it to a variable";
            let fault = Fault::new(one.line, what).code(Code::NotModelled).help(help);
            StatementKind::Fault(Box::new(fault))
        }
    }
}

/// The positions in `given` of a standard function's inputs, in parameter order. `None` if a numbered input is missing.
fn in_order(given: &[&Given<'_>]) -> Option<Vec<usize>> {
    let names: Option<Vec<&str>> = given.iter().map(|one| one.name).collect();
    let Some(names) = names else { return Some((0..given.len()).collect()) };
    let mut ranked: Vec<(u32, usize)> =
        names.iter().enumerate().map(|(at, name)| (Function::rank(name), at)).collect();
    ranked.sort_by_key(|(rank, _)| *rank);
    // Numbered inputs start with IN1, or with IN0 if a selector input (`G`, `K`, `MN`) comes first.
    let numbered: Vec<u32> =
        ranked.iter().map(|(rank, _)| *rank).filter(|rank| (2..u32::MAX).contains(rank)).collect();
    let first = if ranked.iter().any(|(rank, _)| *rank == 0) { 2 } else { 3 };
    let is_whole = numbered.iter().zip(first..).all(|(own, expected)| *own == expected);
    is_whole.then(|| ranked.into_iter().map(|(_, at)| at).collect())
}
