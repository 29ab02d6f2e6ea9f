//! Assigns memory to instances, methods and global variables, and finds the place of a path.

use super::spots::{Context, Element, Found, Instance, Spot};
use super::{Lower, VARIABLES};
use crate::assembler::Assembler;
use scanbound_base::code::Code;
use scanbound_iec::PouKind;
use scanbound_iec::fault::Fault;
use scanbound_iec_tree::blocks::Pin;
use scanbound_iec_tree::declarations::{AddressId, Owner, RoutineId, TempId, UnitId, VarId};
use scanbound_iec_tree::tree::{Expr, Place, Root, Step};
use scanbound_iec_tree::types::{DINT, Kind, Type as Typed, TypeId};
use scanbound_ir::errors::is_outside;
use scanbound_ir::tags::ValueForm;
use scanbound_ir::{Number, Type};
use std::collections::BTreeMap;
use std::sync::Arc;

/// The most function block instances that one variable or program may contain.
const MAX_INSTANCES: u64 = 100_000;

fn too_large(line: u32, name: &str) -> Fault {
    Fault::new(line, format!("{name} is too large for the memory that is modelled"))
        .code(Code::TooLarge)
}

/// The memory layout of a number or time.
fn words(kind: Kind) -> Type {
    let form = match kind {
        Kind::Whole { signed: true, .. } => ValueForm::Signed,
        Kind::Whole { signed: false, .. } => ValueForm::Unsigned,
        Kind::Real => ValueForm::Real,
        Kind::Time => ValueForm::Time,
        Kind::Opaque(_) => ValueForm::Opaque,
    };
    Type::Words(kind.words(), form)
}

impl<'t> Lower<'t> {
    /// The memory layout of a type. A fault if the type, or a unit in it, has one.
    pub(super) fn layout(&mut self, ty: TypeId) -> Result<Type, Fault> {
        if let Some(known) = &self.memory.layouts[ty.index()] {
            return Ok(known.clone());
        }
        let tree = self.tree;
        let found = match tree.types.get(ty) {
            Typed::Elementary(of) => match of.kind() {
                None => Type::Bit,
                Some(kind) => words(kind),
            },
            // One word stands for a text; a reference needs no more.
            Typed::Text(_) | Typed::Reference(..) | Typed::Interface(_) => {
                Type::Words(1, ValueForm::Opaque)
            }
            Typed::Array(dimensions, of) => {
                let of = self.layout(*of)?;
                dimensions.iter().rev().fold(of, |of, (low, high)| {
                    let count = u32::try_from(high - low + 1).unwrap_or(u32::MAX);
                    Type::Array { first: *low, count, of: Arc::new(of) }
                })
            }
            Typed::Struct(id) => {
                let mut parts = Vec::new();
                for (name, of) in tree.types.parts(*id) {
                    parts.push((name.clone(), self.layout(*of)?));
                }
                Type::Parts(Arc::new(parts.into_iter().collect()))
            }
            Typed::Standard(block) => {
                let pin = |pin: Pin| {
                    let of = pin.of().kind().map_or(Type::Bit, words);
                    (pin.name().to_owned(), of)
                };
                Type::Parts(Arc::new(block.pins().map(pin).collect()))
            }
            Typed::Block(unit) => {
                for one in tree.lineage(*unit) {
                    if let Some(fault) = &tree.unit(one).fault {
                        return Err(fault.clone());
                    }
                }
                match self.layout_of(tree.members(*unit))? {
                    // Each instance needs a place of its own.
                    empty if empty.size() == Some([0, 0]) => {
                        Type::Parts(Arc::new([(String::new(), Type::Bit)].into_iter().collect()))
                    }
                    found => found,
                }
            }
            Typed::Faulty(at) => return Err(tree.types.fault(*at)),
            Typed::Untyped | Typed::Unknown | Typed::Nothing => Type::Words(1, ValueForm::Opaque),
        };
        self.memory.layouts[ty.index()] = Some(found.clone());
        Ok(found)
    }

    fn layout_of(&mut self, all: Vec<VarId>) -> Result<Type, Fault> {
        let tree = self.tree;
        let mut parts = Vec::new();
        for id in all {
            let one = tree.variable(id);
            parts.push((one.name.clone(), self.layout(one.ty)?));
        }
        Ok(Type::Parts(Arc::new(parts.into_iter().collect())))
    }

    /// The number of function block instances in a variable of this type, at all depths. Standard blocks do not count.
    pub(super) fn instances_of(&self, ty: TypeId) -> u64 {
        self.count_instances(ty, &mut BTreeMap::new())
    }

    /// `counted`: the blocks that were already counted. A block that holds two of another, which holds two of a third,
    /// and so on, is counted in linear time.
    fn count_instances(&self, ty: TypeId, counted: &mut BTreeMap<UnitId, u64>) -> u64 {
        match self.tree.types.get(ty) {
            Typed::Block(unit) => {
                if let Some(&count) = counted.get(unit) {
                    return count;
                }
                let is_block = self.tree.unit(*unit).kind == PouKind::FunctionBlock;
                let mut count = u64::from(is_block);
                for member in self.tree.members(*unit) {
                    let inner = self.count_instances(self.tree.variable(member).ty, counted);
                    count = count.saturating_add(inner);
                }
                counted.insert(*unit, count);
                count
            }
            Typed::Array(dimensions, of) => {
                let counts = dimensions.iter().map(|(low, high)| high.abs_diff(low - 1));
                counts.fold(self.count_instances(*of, counted), u64::saturating_mul)
            }
            Typed::Struct(id) => {
                let parts = self.tree.types.parts(*id).iter();
                parts.fold(0, |sum, (_, of)| sum.saturating_add(self.count_instances(*of, counted)))
            }
            _ => 0,
        }
    }

    /// Allocates memory for a variable. A fault if it is too large.
    pub(super) fn placed(&mut self, name: &str, ty: TypeId, line: u32) -> Result<Spot, Fault> {
        let layout = self.layout(ty)?;
        let instances = self.instances_of(ty);
        if instances > MAX_INSTANCES {
            let what = format!("{name} holds {instances} instances of function blocks");
            let help = format!("a variable or a program may hold {MAX_INSTANCES}");
            return Err(Fault::new(line, what).code(Code::TooLarge).help(help));
        }
        let tag = self.program().tags.add(VARIABLES, name, layout);
        let tag = tag.ok_or_else(|| too_large(line, name))?;
        Ok(Spot { name: name.to_owned(), tag, ty })
    }

    /// The name of a global variable, with that of its list if it has one.
    pub(super) fn full_name(&self, id: VarId) -> String {
        let one = self.tree.variable(id);
        match one.owner {
            Owner::Global(list) if !self.tree.globals[list].name.is_empty() => {
                format!("{}.{}", self.tree.globals[list].name, one.name)
            }
            _ => one.name.clone(),
        }
    }

    pub(super) fn global(&mut self, id: VarId) -> Result<Spot, Fault> {
        if let Some(known) = self.memory.globals.get(&id) {
            return Ok(known.clone());
        }
        let one = self.tree.variable(id);
        let (ty, line, name) = (one.ty, one.line, self.full_name(id));
        let spot = self.placed(&name, ty, line)?;
        self.memory.globals.insert(id, spot.clone());
        Ok(spot)
    }

    fn direct(&mut self, id: AddressId, line: u32) -> Result<Spot, Fault> {
        if let Some(known) = self.memory.addresses.get(&id) {
            return Ok(known.clone());
        }
        let own = self.tree.address(id);
        let spot = self.placed(&own.text, own.ty, line)?;
        self.memory.addresses.insert(id, spot.clone());
        Ok(spot)
    }

    /// The index of the instance at a spot, which is created if it is new.
    pub(super) fn instance(&mut self, spot: &Spot, unit: UnitId) -> usize {
        let next = self.instances.len();
        let at = *self.memory.instances.entry(spot.key()).or_insert(next);
        if at == next {
            if self.is_function(unit) {
                self.memory.begin_anew.extend(spot.tag.regions());
            }
            self.instances.push(Instance { unit, spot: spot.clone() });
        }
        at
    }

    /// The instance index of a program, which is allocated at the first request.
    pub(super) fn program_instance(&mut self, at: usize) -> Result<usize, Fault> {
        if let Some(&known) = self.memory.programs.get(&at) {
            return Ok(known);
        }
        let own = &self.tree.programs[at];
        let instance = self.unit_instance(&own.name, own.unit)?;
        self.memory.programs.insert(at, instance);
        Ok(instance)
    }

    /// Allocates an instance of a unit under a name.
    pub(super) fn unit_instance(&mut self, name: &str, unit: UnitId) -> Result<usize, Fault> {
        let line = self.tree.unit(unit).line;
        let ty = self.tree.types.find(&Typed::Block(unit));
        let ty = ty.ok_or_else(|| too_large(line, name))?;
        let spot = self.placed(name, ty, line)?;
        Ok(self.instance(&spot, unit))
    }

    /// The instance of a function in the current task. Each task has its own, since a task may interrupt another one
    /// within the function.
    pub(super) fn function_instance(&mut self, unit: UnitId) -> Result<usize, Fault> {
        let task = self.routines.task;
        if let Some(&known) = self.memory.functions.get(&(unit, task)) {
            return Ok(known);
        }
        let own = self.tree.unit(unit);
        let name = match task {
            0 => format!("function {}", own.name),
            task => format!("function {} of task {}", own.name, task + 1),
        };
        let instance = self.unit_instance(&name, unit)?;
        self.memory.functions.insert((unit, task), instance);
        Ok(instance)
    }

    /// The memory for the variables of a method of an instance.
    pub(super) fn frame(&mut self, instance: usize, method: RoutineId) -> Result<Spot, Fault> {
        if let Some(known) = self.memory.frames.get(&(instance, method)) {
            return Ok(known.clone());
        }
        let tree = self.tree;
        let own = tree.routine(method);
        let unit = self.instances[instance].unit;
        let of = match tree.dispatched(unit, method) == method {
            true => String::new(),
            false => format!("{}::", tree.unit(own.unit).name),
        };
        let name = format!("{}.{of}{}()", self.instances[instance].spot.name, own.name);
        let layout = self.layout_of(own.variables.clone())?;
        let tag = self.program().tags.add(VARIABLES, &name, layout);
        let tag = tag.ok_or_else(|| too_large(own.line, &name))?;
        let ty = tree.types.elementary(scanbound_iec_tree::types::Elementary::Bool);
        let spot = Spot { name, tag, ty };
        self.memory.begin_anew.extend(spot.tag.regions());
        self.memory.frames.insert((instance, method), spot.clone());
        Ok(spot)
    }

    /// The position of a variable within the instances of a unit. None if the unit does not have it.
    fn position(&mut self, unit: UnitId, id: VarId) -> Option<usize> {
        if let Some(&known) = self.memory.positions.get(&(unit, id)) {
            return Some(known);
        }
        for (at, one) in self.tree.members(unit).into_iter().enumerate() {
            self.memory.positions.insert((unit, one), at);
        }
        self.memory.positions.get(&(unit, id)).copied()
    }

    /// The place of a variable in an instance of `unit`. None if the unit does not have it.
    pub(super) fn member(&mut self, spot: &Spot, unit: UnitId, id: VarId) -> Option<Spot> {
        let tag = spot.tag.part_at(self.position(unit, id)?)?;
        let one = self.tree.variable(id);
        Some(Spot { name: format!("{}.{}", spot.name, one.name), tag, ty: one.ty })
    }

    /// The place of a variable in a method's memory. None if the method does not have it.
    pub(super) fn local(&self, frame: &Spot, method: RoutineId, id: VarId) -> Option<Spot> {
        let at = self.tree.routine(method).variables.iter().position(|&one| one == id)?;
        let one = self.tree.variable(id);
        let tag = frame.tag.part_at(at)?;
        Some(Spot { name: format!("{}.{}", frame.name, one.name), tag, ty: one.ty })
    }

    /// The place of a variable that code in this context names.
    pub(super) fn variable(&mut self, at: &Context, id: VarId) -> Result<Spot, Fault> {
        let one = self.tree.variable(id);
        let missing = || too_large(one.line, &one.name);
        match one.owner {
            Owner::Global(_) => self.global(id),
            Owner::Unit(_) => {
                let Instance { unit, spot } = self.instances[at.instance].clone();
                self.member(&spot, unit, id).ok_or_else(missing)
            }
            Owner::Routine(method) => {
                let frame = at.frame.as_ref().ok_or_else(missing)?;
                self.local(frame, method, id).ok_or_else(missing)
            }
        }
    }

    /// The place at which a path begins. A fault for a temporary, or if there is no room for the variable.
    pub(super) fn root(&mut self, at: &Context, root: Root, line: u32) -> Result<Spot, Fault> {
        match root {
            Root::Variable(id) => self.variable(at, id),
            Root::This => Ok(self.instances[at.instance].spot.clone()),
            Root::Program(number) => {
                let instance = self.program_instance(number)?;
                Ok(self.instances[instance].spot.clone())
            }
            Root::Address(id) => self.direct(id, line),
            Root::Temporary(id) => Err(self.nothing_kept(id, line)),
            Root::Target(number) => Ok(self.memory.targets.spots[number as usize].clone()),
        }
    }

    /// The place one step further along a path. None for an array element with a run-time index, a bit, or a step that
    /// does not match the type.
    pub(super) fn stepped(
        &mut self,
        spot: &Spot,
        unit: Option<UnitId>,
        step: &Step,
    ) -> Option<Spot> {
        let tree = self.tree;
        match (tree.types.get(spot.ty), step) {
            (Typed::Struct(id), Step::Part(number)) => {
                let (name, ty) = &tree.types.parts(*id)[*number];
                let tag = spot.tag.part_at(*number)?;
                Some(Spot { name: format!("{}.{name}", spot.name), tag, ty: *ty })
            }
            (_, Step::Member(id)) => self.member(spot, unit?, *id),
            (_, Step::Result(method, of_base)) => {
                let unit = unit?;
                let method = if *of_base { *method } else { tree.dispatched(unit, *method) };
                let instance = self.instance(spot, unit);
                let frame = self.frame(instance, method).ok()?;
                self.local(&frame, method, tree.routine(method).result?)
            }
            (Typed::Standard(block), Step::Pin(pin)) => {
                let tag = spot.tag.part_at(block.position(*pin)?)?;
                let ty = tree.types.elementary(pin.of());
                Some(Spot { name: format!("{}.{}", spot.name, pin.name()), tag, ty })
            }
            (Typed::Array(_, of), Step::Element(indices)) => {
                let known: Vec<i64> = indices.iter().map(Expr::whole).collect::<Option<_>>()?;
                let mut tag = spot.tag.clone();
                for &number in &known {
                    tag = tag.element(number)?;
                }
                let numbers: Vec<String> = known.iter().map(ToString::to_string).collect();
                let name = format!("{}[{}]", spot.name, numbers.join(", "));
                Some(Spot { name, tag, ty: *of })
            }
            _ => None,
        }
    }

    /// The unit of the instance at which a path begins. None if it does not begin at an instance.
    pub(super) fn root_unit(&self, at: &Context, root: Root) -> Option<UnitId> {
        match root {
            Root::This => Some(self.instances[at.instance].unit),
            Root::Program(number) => Some(self.tree.programs[number].unit),
            Root::Variable(id) => self.unit_of(self.tree.variable(id).ty),
            Root::Target(number) => self.unit_of(self.memory.targets.spots[number as usize].ty),
            Root::Address(_) | Root::Temporary(_) => None,
        }
    }

    /// The fault of a temporary that was never set.
    pub(super) fn nothing_kept(&self, id: TempId, line: u32) -> Fault {
        let text = &self.tree.temporaries[id.index()].text;
        let help = "give all files of the project, or declare it";
        Fault::new(line, format!("there is no {text}")).code(Code::UnknownName).help(help)
    }

    pub(super) fn unit_of(&self, ty: TypeId) -> Option<UnitId> {
        match self.tree.types.get(ty) {
            Typed::Block(unit) => Some(*unit),
            _ => None,
        }
    }

    /// Looks up a place and evaluates its run-time indices.
    pub(super) fn find(&mut self, at: &Context, place: &Place, line: u32) -> Result<Found, Fault> {
        if let Some(own) = self.only_target(at, place, line)? {
            return self.find(at, &own, line);
        }
        self.has_one_order(at, place, line)?;
        let mut found = Found::Spot(self.root(at, place.root, line)?);
        let mut unit = self.root_unit(at, place.root);
        for step in &place.steps {
            let (spot, outer) = match &found {
                Found::Spot(spot) => (spot, None),
                Found::Element(element) => (&element.spot, Some(element)),
                Found::WordBit(..) => return Err(not_followed(line)),
            };
            if let Step::Pin(pin @ (Pin::Cv | Pin::Pv)) = step
                && let Some(part) = self.stepped(&spot.clone(), None, step)
            {
                self.note_count(&spot.clone(), *pin, &part);
            }
            let (spot, outer) = (spot.clone(), outer.cloned());
            if let Step::Bit(bit) = step {
                if outer.is_some() {
                    return Err(super::elements::unknown_number(line));
                }
                found = self.bit_of(&spot, *bit).ok_or_else(|| not_followed(line))?;
                continue;
            }
            if let Some(next) = self.stepped(&spot, unit, step) {
                unit = self.unit_of(next.ty);
                found = match outer {
                    None => Found::Spot(next),
                    Some(outer) => Found::Element(Element { spot: next, ..outer }),
                };
                continue;
            }
            let Step::Element(indices) = step else { return Err(not_followed(line)) };
            let element = self.element_of(at, &spot, indices, outer, line)?;
            unit = self.unit_of(element.spot.ty);
            found = Found::Element(element);
        }
        Ok(found)
    }

    fn note_count(&mut self, spot: &Spot, _: Pin, part: &Spot) {
        if let Typed::Standard(block) = self.tree.types.get(spot.ty)
            && block.is_counter()
        {
            let cell = part.tag.cell();
            self.counts.extend(cell);
        }
    }

    fn bit_of(&self, spot: &Spot, bit: u8) -> Option<Found> {
        let Kind::Whole { bits, signed } = self.tree.types.kind(spot.ty)? else { return None };
        let cell = spot.tag.cell()?;
        let last = if (bits, bit, signed) == (8, 7, true) { 15 } else { bit % 16 };
        Some(Found::WordBit(cell.plus(u32::from(bit / 16)), bit % 16, last))
    }

    /// Lowers the indices of an array element that are computed at run time.
    fn element_of(
        &mut self,
        at: &Context,
        spot: &Spot,
        indices: &[Expr],
        outer: Option<Element>,
        line: u32,
    ) -> Result<Element, Fault> {
        let Typed::Array(dimensions, of) = self.tree.types.get(spot.ty) else {
            return Err(not_followed(line));
        };
        let mut first = spot.tag.clone();
        for (low, _) in dimensions {
            let empty = || Fault::new(line, format!("{} is too large", spot.name));
            first = first.element(*low).ok_or_else(empty)?;
        }
        let inner = Spot { name: format!("{}[..]", spot.name), tag: first, ty: *of };
        let (mut terms, mut base, whole) = match outer {
            Some(outer) => (outer.terms, outer.base, outer.whole),
            None => (Vec::new(), [0, 0], spot.clone()),
        };
        let size = inner.tag.of.size().unwrap_or_default().map(i64::from);
        let mut step = dimensions.iter().rev().fold(vec![1_i64], |mut steps, (low, high)| {
            let last = steps.last().copied().unwrap_or(1);
            steps.push(last * (high - low + 1));
            steps
        });
        step.pop();
        let all: Vec<&Expr> = indices.iter().collect();
        let values = self.operands(at, &all, line, &mut |own, which| own.value(at, all[which]))?;
        for ((value, (low, high)), step) in
            values.into_iter().zip(dimensions).zip(step.iter().rev())
        {
            let value = self.as_number(value, DINT);
            let words = self.words(value, 2);
            self.not_followed_where(is_outside(&Number::Words(words.clone()), *low, *high));
            terms.push((words, size.map(|size| size * step)));
            (0..2).for_each(|side| base[side] -= low * step * size[side]);
        }
        Ok(Element { spot: inner, terms, base, whole })
    }

    /// Copies the index values of an element, so that later writes do not change which element is meant.
    pub(super) fn staying(&mut self, found: Found) -> Found {
        let Found::Element(mut element) = found else { return found };
        for (words, _) in &mut element.terms {
            let now = scanbound_ir::Number::Words(std::mem::take(words));
            *words = self.copied(now, 2);
        }
        Found::Element(element)
    }

    /// Whether a unit is a function.
    pub(super) fn is_function(&self, unit: UnitId) -> bool {
        self.tree.unit(unit).kind == PouKind::Function
    }

    pub(super) fn assembler(&mut self) -> &mut Assembler {
        &mut self.assembler
    }
}

fn not_followed(line: u32) -> Fault {
    Fault::new(line, "this part of a variable is not modelled").code(Code::NotModelled)
}
