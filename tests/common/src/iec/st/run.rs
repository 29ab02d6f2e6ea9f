//! The interpreter: runs a project scan by scan.

mod statements;

use super::place::{self, At, Loc, Map, Value, kept, pins, plain};
use super::standard::{self, Manner, converted, open};
use super::tree::{
    Access, Argument, Call, Expr, For, Initial, Kind, Place, Project, Root, Routine, Section,
    Statement, Step, Target, Ty, Variable,
};
use std::collections::BTreeMap;

/// Why a run ends early.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stop {
    /// What means nothing is used, or an index is beyond its array.
    Null,
    /// It takes too long.
    Long,
}

type Run<T> = Result<T, Stop>;

/// How a statement ends.
#[derive(PartialEq, Eq)]
enum Flow {
    On,
    Exit,
    Continue,
    Return,
}

/// What code sees: its instance, and its routine's variables with the cells where they lie.
#[derive(Clone, Default)]
struct Frame<'p> {
    /// The instance's first cell and its block.
    this: Option<(usize, usize)>,
    variables: &'p [Variable],
    cells: Vec<usize>,
}

pub struct Machine<'p> {
    pub project: &'p Project,
    pub manner: Manner,
    map: Map,
    cells: Vec<Value>,
    bits: BTreeMap<u64, bool>,
    globals: Vec<usize>,
    /// Variables that all instances of a block share: block, variable, cell.
    statics: BTreeMap<(usize, usize), usize>,
    program: usize,
    /// How many numbers and truth values were assigned.
    pub stores: u64,
    /// How many statements may be carried out.
    pub steps: u64,
    /// How many milliseconds have passed since the scan before.
    pub passed: i128,
}

impl<'p> Machine<'p> {
    /// A project at power-up.
    pub fn new(project: &'p Project, manner: Manner) -> Machine<'p> {
        let mut machine = Machine {
            project,
            manner,
            map: Map::new(project),
            cells: Vec::new(),
            bits: BTreeMap::new(),
            globals: Vec::new(),
            statics: BTreeMap::new(),
            program: 0,
            stores: 0,
            steps: 0,
            passed: 0,
        };
        for variable in &project.globals {
            let at = machine.room(&variable.ty);
            machine.globals.push(at);
        }
        for (block, own) in project.blocks.iter().enumerate() {
            for (number, variable) in own.variables.iter().enumerate() {
                if variable.section == Section::Static {
                    let at = machine.room(&variable.ty);
                    machine.statics.insert((block, number), at);
                }
            }
        }
        machine.program = machine.room(&Ty::Block(project.program()));
        let none = Frame::default();
        for (number, variable) in project.globals.iter().enumerate() {
            let at = machine.globals[number];
            machine.begin(&none, variable, at);
        }
        for (&(block, number), &at) in &machine.statics.clone() {
            machine.begin(&none, &project.blocks[block].variables[number], at);
        }
        machine.begin_instance(machine.program, project.program());
        machine
    }

    /// New cells, which hold what a type begins with.
    fn room(&mut self, ty: &Ty) -> usize {
        let at = self.cells.len();
        self.fill(ty);
        at
    }

    fn fill(&mut self, ty: &Ty) {
        match ty {
            Ty::Array(dimensions, of) => {
                let many: i128 = dimensions.iter().map(|(low, high)| high - low + 1).product();
                (0..many).for_each(|_| self.fill(of));
            }
            Ty::Struct(of) => {
                let project = self.project;
                project.parts(*of).into_iter().for_each(|part| self.fill(&part.ty));
            }
            Ty::Block(of) => {
                let project = self.project;
                let own = &project.blocks[*of];
                if let Some(base) = own.base {
                    self.fill(&Ty::Block(base));
                }
                for variable in &own.variables {
                    match variable.section {
                        Section::InOut => self.cells.push(Value::Meant(None)),
                        _ => self.fill(&variable.ty),
                    }
                }
                for method in &own.methods {
                    let kept = method.variables.iter();
                    for one in kept.filter(|one| one.section == Section::Instance) {
                        self.fill(&one.ty);
                    }
                }
            }
            Ty::Standard(kind) => {
                for (name, ty) in pins(kind) {
                    let falls = *kind == "F_TRIG" && *name == "m" && self.manner.falls;
                    let first = if falls { Value::Int(1) } else { plain(ty) };
                    self.cells.push(first);
                }
            }
            other => self.cells.push(plain(other)),
        }
    }

    /// Gives what lies at a cell the values that a declaration says.
    fn begin(&mut self, frame: &Frame<'p>, variable: &Variable, at: usize) {
        self.begin_type(&variable.ty, at);
        let loc = match &variable.at {
            Some(address) => Loc {
                at: At::Bit(place::first_bit(address, self.manner.counting)),
                ty: variable.ty.clone(),
                bit: None,
            },
            None => Loc { at: At::Cell(at), ty: variable.ty.clone(), bit: None },
        };
        let value = |machine: &mut Self, loc: Loc, one: &Expr| {
            let value = machine.value(frame, one).expect("a constant");
            machine.put(&loc, kept(&loc.ty, value));
        };
        match &variable.initial {
            None => {}
            Some(Initial::Value(one)) => value(self, loc, one),
            Some(Initial::Elements(all)) => {
                let Ty::Array(_, of) = &variable.ty else { panic!("no array") };
                for (number, one) in all.iter().enumerate() {
                    let at = At::Cell(at + number * self.map.size(self.project, of));
                    value(self, Loc { at, ty: (**of).clone(), bit: None }, one);
                }
            }
            Some(Initial::Parts(all)) => {
                for (name, one) in all {
                    let part = self.part(loc.clone(), name);
                    value(self, part, one);
                }
            }
        }
    }

    /// What the parts of a type declare.
    fn begin_type(&mut self, ty: &Ty, at: usize) {
        let project = self.project;
        match ty {
            Ty::Array(dimensions, of) => {
                let many: i128 = dimensions.iter().map(|(low, high)| high - low + 1).product();
                let size = self.map.size(project, of);
                (0..usize::try_from(many).expect("small"))
                    .for_each(|number| self.begin_type(of, at + number * size));
            }
            Ty::Struct(of) => {
                let mut at = at;
                for part in project.parts(*of) {
                    self.begin(&Frame::default(), part, at);
                    at += self.map.size(project, &part.ty);
                }
            }
            Ty::Block(of) => self.begin_instance(at, *of),
            _ => {}
        }
    }

    fn begin_instance(&mut self, at: usize, block: usize) {
        let project = self.project;
        let frame = Frame { this: Some((at, block)), ..Frame::default() };
        for one in project.lineage(block).into_iter().rev() {
            for (number, variable) in project.blocks[one].variables.iter().enumerate() {
                if !matches!(variable.section, Section::InOut | Section::Static) {
                    let cell = at + self.map.layouts[one].members[number];
                    self.begin(&frame, variable, cell);
                }
            }
            for (&(method, number), cell) in &self.map.layouts[one].kept.clone() {
                let variable = &project.blocks[one].methods[method].variables[number];
                self.begin(&frame, variable, at + cell);
            }
        }
    }

    fn part(&self, loc: Loc, name: &str) -> Loc {
        let (Ty::Struct(of), At::Cell(mut at)) = (&loc.ty, loc.at) else {
            panic!("{loc:?}.{name}")
        };
        for part in self.project.parts(*of) {
            if part.name == name {
                return Loc { at: At::Cell(at), ty: part.ty.clone(), bit: None };
            }
            at += self.map.size(self.project, &part.ty);
        }
        panic!("{name}")
    }

    fn pin(loc: &Loc, name: &str) -> Loc {
        let (Ty::Standard(kind), At::Cell(at)) = (&loc.ty, loc.at) else {
            panic!("{loc:?}.{name}")
        };
        let number = place::pin(kind, name);
        Loc { at: At::Cell(at + number), ty: pins(kind)[number].1.clone(), bit: None }
    }

    /// A variable of an instance, declared by a block.
    fn member(&self, this: usize, block: usize, number: usize) -> (Loc, &'p Variable) {
        let project = self.project;
        let variable = &project.blocks[block].variables[number];
        let at = match (&variable.at, variable.section) {
            (Some(address), _) => At::Bit(place::first_bit(address, self.manner.counting)),
            (None, Section::Static) => At::Cell(self.statics[&(block, number)]),
            _ => At::Cell(this + self.map.layouts[block].members[number]),
        };
        (Loc { at, ty: variable.ty.clone(), bit: None }, variable)
    }

    /// What a variable means: itself, or what it was passed or refers to.
    fn meant(&self, (loc, variable): (Loc, &Variable)) -> Run<Loc> {
        let refers = variable.section == Section::InOut || matches!(variable.ty, Ty::Reference(_));
        if refers { self.dereferenced(&loc) } else { Ok(loc) }
    }

    fn dereferenced(&self, loc: &Loc) -> Run<Loc> {
        match self.load(loc) {
            Value::Meant(Some(loc)) => Ok(loc),
            Value::Meant(None) => Err(Stop::Null),
            other => panic!("{other:?} means nothing"),
        }
    }

    fn declared(&self, frame: &Frame<'p>, root: Root) -> (Loc, &'p Variable) {
        let project = self.project;
        match root {
            Root::Global(number) => {
                let variable = &project.globals[number];
                let at = match &variable.at {
                    Some(at) => At::Bit(place::first_bit(at, self.manner.counting)),
                    None => At::Cell(self.globals[number]),
                };
                (Loc { at, ty: variable.ty.clone(), bit: None }, variable)
            }
            Root::Member(block, number) => {
                self.member(frame.this.expect("an instance").0, block, number)
            }
            Root::Local(number) => {
                let variable = &frame.variables[number];
                let at = At::Cell(frame.cells[number]);
                (Loc { at, ty: variable.ty.clone(), bit: None }, variable)
            }
            Root::This | Root::Address(_) => panic!("not declared"),
        }
    }

    fn locate(&mut self, frame: &Frame<'p>, place: &Place) -> Run<Loc> {
        let mut loc = match place.root {
            Root::This => Self::this(frame),
            Root::Address(number) => place::address(number, self.manner.counting),
            root => self.meant(self.declared(frame, root))?,
        };
        for step in &place.steps {
            loc = match step {
                Step::Part(name) => self.part(loc, name),
                Step::Pin(name) => Self::pin(&loc, name),
                Step::Member(block, number) => {
                    let At::Cell(at) = loc.at else { panic!("an instance at an address") };
                    self.meant(self.member(at, *block, *number))?
                }
                Step::Bit(bit) => Loc { bit: Some(*bit), ty: Ty::Bool, at: loc.at },
                Step::Dereference => self.dereferenced(&loc)?,
                Step::Element(indices) => {
                    let found = self.values(frame, indices)?;
                    let (Ty::Array(dimensions, of), At::Cell(at)) = (&loc.ty, loc.at) else {
                        panic!("{loc:?}")
                    };
                    let mut number = 0;
                    for ((low, high), index) in dimensions.iter().zip(&found) {
                        let index = index.int();
                        if !(*low..=*high).contains(&index) {
                            return Err(Stop::Null);
                        }
                        number = number * (high - low + 1) + (index - low);
                    }
                    let number = usize::try_from(number).expect("in range");
                    let at = At::Cell(at + number * self.map.size(self.project, of));
                    Loc { at, ty: (**of).clone(), bit: None }
                }
            };
        }
        Ok(loc)
    }

    fn this(frame: &Frame<'p>) -> Loc {
        let (at, block) = frame.this.expect("an instance");
        Loc { at: At::Cell(at), ty: Ty::Block(block), bit: None }
    }

    pub fn load(&self, loc: &Loc) -> Value {
        match loc.at {
            At::Cell(at) => match (&self.cells[at], loc.bit) {
                (Value::Int(value), Some(bit)) => Value::Int(value >> bit & 1),
                (value, _) => value.clone(),
            },
            At::Bit(first) => {
                let (first, many) = match loc.bit {
                    Some(bit) => (first + u64::from(bit), 1),
                    None => (first, place::width(&loc.ty)),
                };
                let on = |at: u64| self.bits.get(&(first + at)).copied().unwrap_or(false);
                let sum = (0..u64::from(many)).map(|at| i128::from(on(at)) << at).sum();
                if loc.bit.is_some() { Value::Int(sum) } else { kept(&loc.ty, Value::Int(sum)) }
            }
        }
    }

    /// Writes a value without counting it.
    pub fn put(&mut self, loc: &Loc, value: Value) {
        match loc.at {
            At::Cell(at) => {
                let value = match (loc.bit, &self.cells[at]) {
                    (Some(bit), Value::Int(before)) => {
                        Value::Int(before & !(1 << bit) | value.int() << bit)
                    }
                    _ => value,
                };
                self.cells[at] = value;
            }
            At::Bit(first) => {
                let (first, many) = match loc.bit {
                    Some(bit) => (first + u64::from(bit), 1),
                    None => (first, place::width(&loc.ty)),
                };
                for at in 0..u64::from(many) {
                    self.bits.insert(first + at, value.int() >> at & 1 == 1);
                }
            }
        }
    }

    fn set(&mut self, loc: &Loc, value: Value) {
        self.stores += u64::from(loc.ty != Ty::Text);
        let value = if loc.bit.is_some() { value } else { kept(&loc.ty, value) };
        self.put(loc, value);
    }

    /// Copies what lies at one place to another; what that takes depends on its size.
    fn copy(&mut self, to: &Loc, from: &Loc) {
        let (At::Cell(to_at), At::Cell(at)) = (to.at, from.at) else {
            let value = self.load(from);
            return self.put(to, kept(&to.ty, value));
        };
        let all = self.cells[at..at + self.map.size(self.project, &to.ty)].to_vec();
        for (number, value) in all.into_iter().enumerate() {
            self.cells[to_at + number] = value;
        }
    }

    /// The values of some expressions, each worked out in its turn.
    fn values(&mut self, frame: &Frame<'p>, all: &[Expr]) -> Run<Vec<Value>> {
        let mut found = vec![Value::Int(0); all.len()];
        for number in 0..all.len() {
            let at = if self.manner.right_first { all.len() - 1 - number } else { number };
            found[at] = self.value(frame, &all[at])?;
        }
        Ok(found)
    }

    /// The value of an expression as one of its type.
    fn typed(&mut self, frame: &Frame<'p>, expr: &Expr) -> Run<Value> {
        let value = self.value(frame, expr)?;
        Ok(kept(&expr.ty, value))
    }

    fn holds(&mut self, frame: &Frame<'p>, expr: &Expr) -> Run<bool> {
        Ok(self.value(frame, expr)?.int() == 1)
    }

    pub fn value_of(&mut self, expr: &Expr) -> Run<Value> {
        let frame =
            Frame { this: Some((self.program, self.project.program())), ..Frame::default() };
        self.value(&frame, expr)
    }

    pub fn place_of(&mut self, place: &Place) -> Run<Loc> {
        let frame =
            Frame { this: Some((self.program, self.project.program())), ..Frame::default() };
        self.locate(&frame, place)
    }

    fn value(&mut self, frame: &Frame<'p>, expr: &Expr) -> Run<Value> {
        let wide = self.manner.wide;
        Ok(match &expr.kind {
            Kind::Number(value, ..) | Kind::Time(value) => Value::Int(*value),
            Kind::Bool(value) => Value::Int(i128::from(*value)),
            Kind::Real(value) => Value::Real(*value),
            Kind::Text(value) => Value::Text((*value).to_owned()),
            Kind::Colour(at) => Value::Int(super::tree::COLOURS[*at].1),
            Kind::Null => Value::Meant(None),
            Kind::Read(place) => {
                let loc = self.locate(frame, place)?;
                match loc.ty {
                    // An instance is what an interface can mean.
                    Ty::Block(_) => Value::Meant(Some(loc)),
                    _ => self.load(&loc),
                }
            }
            Kind::Address(place) => Value::Meant(Some(self.locate(frame, place)?)),
            Kind::IsValid(place) => {
                let (loc, _) = self.declared(frame, place.root);
                Value::Int(i128::from(self.load(&loc) != Value::Meant(None)))
            }
            Kind::Not(inner) => {
                let value = self.value(frame, inner)?.int();
                match expr.ty {
                    Ty::Bool => Value::Int(value ^ 1),
                    _ => kept(&expr.ty, Value::Int(!value)),
                }
            }
            Kind::Negate(inner) => match self.value(frame, inner)? {
                Value::Real(value) => Value::Real(-value),
                value => open(&expr.ty, wide, Value::Int(-value.int())),
            },
            Kind::Widen(inner) => {
                let value = self.value(frame, inner)?;
                if expr.ty == Ty::Real { kept(&Ty::Real, value) } else { value }
            }
            Kind::Binary(operator, one, two) => {
                let found = self.binary(frame, operator, one, two)?;
                if expr.ty == Ty::Bool { found } else { open(&expr.ty, wide, found) }
            }
            Kind::Standard(name, given) => {
                let found = self.values(frame, given)?;
                if name.contains("_TO_") {
                    return Ok(converted(&given[0].ty, &expr.ty, &found[0], &self.manner));
                }
                let found = standard::function(name, &expr.ty, &found);
                if expr.ty == Ty::Bool { found } else { open(&expr.ty, wide, found) }
            }
            Kind::Call(call) => match self.call(frame, call)? {
                Some(value) => value,
                None => plain(&expr.ty),
            },
            Kind::Get(instance, name) => {
                let (at, block) = self.instance(frame, instance.as_ref())?;
                let (_, own) = self.project.property(block, name, Access::Get).expect("a property");
                self.routine(own, Some((at, block)), |_, _| {})?[0].clone()
            }
        })
    }

    fn binary(&mut self, frame: &Frame<'p>, operator: &str, one: &Expr, two: &Expr) -> Run<Value> {
        let settles = |first: &Value| {
            let word = operator.split('_').next().unwrap_or(operator);
            matches!((word, first), ("AND", Value::Int(0)) | ("OR", Value::Int(1)))
        };
        let is_short = operator.contains('_');
        if self.manner.right_first && !is_short {
            let second = self.value(frame, two)?;
            if self.manner.skips && one.ty == Ty::Bool && settles(&second) {
                return Ok(second);
            }
            let first = self.value(frame, one)?;
            return Ok(standard::binary(operator, &first, &second));
        }
        let first = self.value(frame, one)?;
        if (is_short || self.manner.skips) && one.ty == Ty::Bool && settles(&first) {
            return Ok(first);
        }
        let second = self.value(frame, two)?;
        Ok(standard::binary(operator, &first, &second))
    }

    /// The instance whose method, action or property is meant.
    fn instance(&mut self, frame: &Frame<'p>, place: Option<&Place>) -> Run<(usize, usize)> {
        let Some(place) = place else { return Ok(frame.this.expect("an instance")) };
        let mut loc = self.locate(frame, place)?;
        if loc.ty == Ty::Interface {
            loc = self.dereferenced(&loc)?;
        }
        match (loc.at, &loc.ty) {
            (At::Cell(at), Ty::Block(block)) => Ok((at, *block)),
            other => panic!("{other:?} is no instance"),
        }
    }

    /// Carries out a function or a method, and gives what its variables hold then, its result first. `pass` puts its
    /// parameters into the frame.
    fn routine(
        &mut self,
        own: &'p Routine,
        this: Option<(usize, usize)>,
        pass: impl FnOnce(&mut Self, &Frame<'p>),
    ) -> Run<Vec<Value>> {
        let before = self.cells.len();
        let mut frame = Frame { this, variables: &own.variables, cells: Vec::new() };
        for variable in &own.variables {
            let cell = self.cells.len();
            match variable.section {
                Section::InOut => self.cells.push(Value::Meant(None)),
                _ => self.fill(&variable.ty),
            }
            frame.cells.push(cell);
        }
        // What each instance keeps lies there.
        if let Some((at, block)) = this {
            for one in self.project.lineage(block) {
                let methods = &self.project.blocks[one].methods;
                let is_own = |(number, _): &(usize, usize)| std::ptr::eq(&methods[*number], own);
                let kept = &self.map.layouts[one].kept;
                for (&(_, variable), cell) in kept.iter().filter(|(key, _)| is_own(key)) {
                    frame.cells[variable] = at + cell;
                }
            }
        }
        for (number, variable) in own.variables.iter().enumerate() {
            if !matches!(variable.section, Section::InOut | Section::Instance) {
                self.begin(&frame, variable, frame.cells[number]);
            }
        }
        pass(self, &frame);
        self.body(&frame, &own.body)?;
        let left = frame.cells.iter().filter_map(|&cell| self.cells.get(cell).cloned()).collect();
        self.cells.truncate(before);
        Ok(left)
    }

    /// What an argument gives: a value, or where the variable is that is passed.
    fn argument(&mut self, frame: &Frame<'p>, one: &Argument) -> Run<Option<Value>> {
        Ok(match one {
            Argument::In(value) => Some(self.typed(frame, value)?),
            Argument::InOut(place) => Some(Value::Meant(Some(self.locate(frame, place)?))),
            Argument::Out(place) if self.manner.target_first => {
                Some(Value::Meant(Some(self.locate(frame, place)?)))
            }
            Argument::Out(_) => None,
        })
    }

    fn order(&self, many: usize) -> Vec<usize> {
        let mut all: Vec<usize> = (0..many).collect();
        if self.manner.right_first {
            all.reverse();
        }
        all
    }

    fn call(&mut self, frame: &Frame<'p>, call: &Call) -> Run<Option<Value>> {
        let mut skipped = false;
        if let Some((condition, to)) = &call.enable {
            let on = self.holds(frame, condition)?;
            skipped = !on;
            if let (Some(to), false) = (to, on) {
                let loc = self.locate(frame, to)?;
                self.set(&loc, Value::Int(0));
            }
        }
        let found = self.called(frame, call, skipped)?;
        if let (Some((_, Some(to))), false) = (&call.enable, skipped) {
            let loc = self.locate(frame, to)?;
            self.set(&loc, Value::Int(1));
        }
        Ok(found)
    }

    fn called(&mut self, frame: &Frame<'p>, call: &Call, skipped: bool) -> Run<Option<Value>> {
        let project = self.project;
        match &call.target {
            Target::Instance(place) | Target::Standard(place, _) => {
                let loc = self.locate(frame, place)?;
                self.instance_call(frame, call, &loc, skipped)?;
                Ok(None)
            }
            Target::BaseBody(block) => {
                let base = project.blocks[*block].base.expect("a base");
                let (at, actual) = frame.this.expect("an instance");
                self.block_body(at, actual, base)?;
                Ok(None)
            }
            Target::Action(place, block, number) => {
                let this = self.instance(frame, place.as_ref())?;
                let inner = Frame { this: Some(this), ..Frame::default() };
                self.body(&inner, &project.blocks[*block].actions[*number].1)?;
                Ok(None)
            }
            Target::Function(number) => {
                self.function(frame, call, &project.functions[*number], None, skipped)
            }
            Target::Method(place, name) => {
                let this = self.instance(frame, place.as_ref())?;
                let (_, own) = project.method(this.1, name).expect("a method");
                self.function(frame, call, own, Some(this), skipped)
            }
            Target::BaseMethod(block, name) => {
                let this = frame.this.expect("an instance");
                let base = project.blocks[*block].base.expect("a base");
                let (_, own) = project.method(base, name).expect("a method");
                self.function(frame, call, own, Some(this), skipped)
            }
        }
    }

    fn function(
        &mut self,
        frame: &Frame<'p>,
        call: &Call,
        own: &'p Routine,
        this: Option<(usize, usize)>,
        skipped: bool,
    ) -> Run<Option<Value>> {
        if skipped && !self.manner.disabled_takes {
            return Ok(None);
        }
        let mut given: Vec<Option<Value>> = vec![None; call.given.len()];
        for at in self.order(call.given.len()) {
            given[at] = self.argument(frame, &call.given[at].1)?;
        }
        if skipped {
            return Ok(None);
        }
        let number = |name: &str| {
            own.variables.iter().position(|one| one.name == name).expect("a parameter")
        };
        let left = self.routine(own, this, |machine, inner| {
            for ((name, argument), value) in call.given.iter().zip(&given) {
                if let (Argument::In(_) | Argument::InOut(_), Some(value)) = (argument, value) {
                    let at = number(name);
                    machine.cells[inner.cells[at]] = kept(&inner.variables[at].ty, value.clone());
                }
            }
        })?;
        for ((name, argument), value) in call.given.iter().zip(given) {
            if let Argument::Out(place) = argument {
                self.take(frame, place, value, left[number(name)].clone())?;
            }
        }
        Ok(own.result.as_ref().map(|_| left[0].clone()))
    }

    /// A result goes to a place, which may be known already.
    fn take(
        &mut self,
        frame: &Frame<'p>,
        place: &Place,
        known: Option<Value>,
        value: Value,
    ) -> Run<()> {
        let loc = match known {
            Some(Value::Meant(Some(loc))) => loc,
            _ => self.locate(frame, place)?,
        };
        self.set(&loc, value);
        Ok(())
    }

    fn parameter(&self, loc: &Loc, name: &str) -> Loc {
        let Ty::Block(block) = loc.ty else { return Self::pin(loc, name) };
        let At::Cell(at) = loc.at else { panic!("an instance at an address") };
        let find = |one: usize| {
            let all = &self.project.blocks[one].variables;
            Some((one, all.iter().position(|own| own.name == name)?))
        };
        let (block, number) =
            self.project.lineage(block).into_iter().find_map(find).expect("a parameter");
        self.member(at, block, number).0
    }

    fn instance_call(
        &mut self,
        frame: &Frame<'p>,
        call: &Call,
        loc: &Loc,
        skipped: bool,
    ) -> Run<()> {
        let mut given: Vec<Option<Value>> = vec![None; call.given.len()];
        if skipped && !self.manner.disabled_takes {
            return Ok(());
        }
        let pass = |machine: &mut Self, at: usize, value: &Option<Value>| {
            let (name, argument) = &call.given[at];
            if let (Argument::In(_) | Argument::InOut(_), Some(value)) = (argument, value) {
                let to = machine.parameter(loc, name);
                let value = if let Argument::In(_) = argument {
                    kept(&to.ty, value.clone())
                } else {
                    value.clone()
                };
                machine.put(&to, value);
            }
        };
        let order = self.order(call.given.len());
        for &at in &order {
            given[at] = self.argument(frame, &call.given[at].1)?;
            if !self.manner.inputs_at_once {
                pass(self, at, &given[at]);
            }
        }
        if self.manner.inputs_at_once {
            for &at in &order {
                pass(self, at, &given[at]);
            }
        }
        if skipped {
            return Ok(());
        }
        match (loc.at, &loc.ty) {
            (At::Cell(at), Ty::Block(block)) => self.block_body(at, *block, *block)?,
            (At::Cell(at), Ty::Standard(kind)) => {
                let now: BTreeMap<&str, i128> = pins(kind)
                    .iter()
                    .enumerate()
                    .map(|(number, (name, _))| (*name, self.cells[at + number].int()))
                    .collect();
                for (name, value) in standard::block(kind, &now, self.passed) {
                    self.cells[at + place::pin(kind, name)] = Value::Int(value);
                }
            }
            other => panic!("{other:?} is no instance"),
        }
        for ((name, argument), value) in call.given.iter().zip(given) {
            if let Argument::Out(place) = argument {
                let own = self.load(&self.parameter(loc, name));
                self.take(frame, place, value, own)?;
            }
        }
        Ok(())
    }

    /// The body that a block declares, for an instance of it or of one that extends it.
    fn block_body(&mut self, at: usize, actual: usize, block: usize) -> Run<()> {
        let project = self.project;
        let frame = Frame { this: Some((at, actual)), ..Frame::default() };
        for (number, variable) in project.blocks[block].variables.iter().enumerate() {
            if variable.section == Section::Temp {
                let cell = at + self.map.layouts[block].members[number];
                let before = self.cells.len();
                self.fill(&variable.ty);
                let many = self.cells.len() - before;
                for number in 0..many {
                    self.cells[cell + number] = self.cells[before + number].clone();
                }
                self.cells.truncate(before);
                self.begin(&frame, variable, cell);
            }
        }
        self.body(&frame, &project.blocks[block].body)?;
        Ok(())
    }
}
