//! Lowers references, pointers and interfaces. A reference is a word with the number of the variable to which it
//! points, among the variables whose addresses the project takes.
//!
//! These variables are found before lowering: all code is walked repeatedly until no more are found. An operation
//! through a reference is lowered once for each variable to which it can point, behind a test of the word; without a
//! test if there is only one.

use super::address::Located;
use super::cells::encloses;
use super::spots::{Context, Found, Instance, Spot};
use super::{Entry, Lower};
use crate::assembler::value::{Value, constant};
use scanbound_base::code::Code as FaultCode;
use scanbound_iec::Section;
use scanbound_iec::fault::Fault;
use scanbound_iec_tree::declarations::VarId;
use scanbound_iec_tree::tree::{Expr, ExprKind, Place, Root, Step};
use scanbound_iec_tree::types::{DINT, Type as Typed, TypeId};
use scanbound_ir::errors::is_outside;
use scanbound_ir::{Logic, Number, NumberFormat, Region, RegionSet, Relation, WordSource};

/// The most variables to which one reference may point; beyond, it is refused.
const MOST: usize = 64;

/// The most elements of an array that is searched for references.
const MAX_ELEMENTS: i64 = 4096;

/// The most walks over all code to find the targets of references.
const MAX_ROUNDS: u32 = 50;

/// The word of a reference to the target with this index.
fn word(index: usize) -> i64 {
    i64::try_from(index + 1).unwrap_or(i64::MAX)
}

fn not_followed(line: u32, what: String) -> Fault {
    let help = "let it refer to variables of its own type, which the project names (ADR, REF=)";
    Fault::new(line, what).code(FaultCode::NotModelled).help(help)
}

/// True where these words equal a constant number. One word is compared unsigned, two signed.
pub(super) fn is_number(words: &[WordSource], number: i64, size: u32) -> Logic {
    let format = if size == 1 { NumberFormat::Unsigned } else { NumberFormat::Signed };
    let words = Number::Words(words.to_vec());
    Logic::compare(Relation::Equal, format, words, constant(number, size))
}

/// The position of the first dereference in a path, if there is one.
fn through(place: &Place) -> Option<usize> {
    place.steps.iter().position(|step| matches!(step, Step::Dereference))
}

/// The references that a path uses, each as the path up to it. The `ty` of these places is not adjusted.
pub(super) fn references_in(place: &Place) -> Vec<Place> {
    let steps = place.steps.iter().enumerate();
    steps
        .filter(|(_, step)| matches!(step, Step::Dereference))
        .map(|(end, _)| Place { steps: place.steps[..end].to_vec(), ..place.clone() })
        .collect()
}

impl<'t> Lower<'t> {
    /// Whether a reference of this type can point to a variable.
    fn can_mean(&self, reference: TypeId, spot: &Spot) -> bool {
        let tree = self.tree;
        let unit = self.unit_of(spot.ty);
        match tree.types.get(reference) {
            Typed::Interface(interface) => unit.is_some_and(|unit| {
                let units = tree.lineage(unit).into_iter();
                { units }.any(|one| tree.unit(one).interfaces.contains(interface))
            }),
            Typed::Reference(_, to) => match (self.unit_of(*to), unit) {
                (Some(base), Some(unit)) => tree.lineage(unit).contains(&base),
                _ => *to == spot.ty,
            },
            _ => false,
        }
    }

    /// The indices of the variables to which a reference of this type can point.
    pub(super) fn candidates(&self, reference: TypeId) -> Vec<usize> {
        let spots = self.memory.targets.spots.iter().enumerate();
        spots.filter(|(_, spot)| self.can_mean(reference, spot)).map(|(at, _)| at).collect()
    }

    /// The target index of a variable. Adds the variable if its address was not taken before.
    pub(super) fn target(&mut self, spot: &Spot) -> usize {
        let targets = &mut self.memory.targets;
        if let Some(&known) = targets.numbers.get(&spot.key()) {
            return known;
        }
        targets.spots.push(spot.clone());
        targets.numbers.insert(spot.key(), targets.spots.len() - 1);
        targets.spots.len() - 1
    }

    /// Finds all variables whose addresses the project takes. A fault if they are not found within a fixed number of
    /// walks.
    pub(super) fn find_targets(&mut self) -> Result<(), Fault> {
        let tree = self.tree;
        if !tree.types.has_references() {
            return Ok(());
        }
        for _ in 0..MAX_ROUNDS {
            let before = self.memory.targets.spots.len();
            for (task, all) in self.routines.tasks.clone().into_iter().enumerate() {
                self.routines.task = task;
                self.effects.clear();
                for instance in all {
                    self.effects_of((instance, Entry::Body));
                }
            }
            self.initial_targets()?;
            self.routines.task = 0;
            self.effects.clear();
            if self.memory.targets.spots.len() == before {
                self.find_addresses();
                return Ok(());
            }
        }
        let told = "the targets of references were not found in the allowed number of steps";
        let help = "let references refer to fewer variables";
        Err(Fault::new(1, told).code(FaultCode::NotModelled).help(help))
    }

    /// Notes the memory of all targets, by their cells and by their addresses.
    fn find_addresses(&mut self) {
        let located = self.located();
        let targets = &mut self.memory.targets;
        let addresses = targets.spots.iter().map(|spot| {
            let own: RegionSet = spot.tag.regions().into_iter().collect();
            let overlaps =
                |one: &&Located| one.spot.tag.regions().iter().any(|&region| own.overlaps(region));
            located.iter().filter(overlaps).map(|one| one.taken).collect()
        });
        targets.addresses = addresses.collect();
        targets.regions = targets.spots.iter().flat_map(|spot| spot.tag.regions()).collect();
    }

    /// Finds the addresses taken in declarations, and in code that is executed before the first scan.
    fn initial_targets(&mut self) -> Result<(), Fault> {
        let tree = self.tree;
        let programs: Vec<usize> = self.routines.tasks.iter().flatten().copied().collect();
        for instance in programs {
            self.instance_begins(instance)?;
        }
        let at = Context { instance: 0, frame: None };
        for &id in tree.globals.iter().flat_map(|list| &list.variables) {
            let one = tree.variable(id);
            if self.matters(one.ty) {
                let spot = self.global(id)?;
                self.begins(&at, &spot, one.initial.as_ref())?;
            }
        }
        Ok(())
    }

    fn instance_begins(&mut self, instance: usize) -> Result<(), Fault> {
        let tree = self.tree;
        let Instance { unit, spot } = self.instances[instance].clone();
        let at = Context { instance, frame: None };
        for id in tree.members(unit) {
            let one = tree.variable(id);
            if let (true, Some(part)) = (self.matters(one.ty), self.member(&spot, unit, id)) {
                self.begins(&at, &part, one.initial.as_ref())?;
            }
        }
        for method in tree.lineage(unit).into_iter().flat_map(|one| &tree.unit(one).begins_with) {
            self.effects_of((instance, Entry::Routine(*method)));
        }
        Ok(())
    }

    /// Finds the addresses taken by a variable's initial value and by the instances in it.
    fn begins(&mut self, at: &Context, spot: &Spot, initial: Option<&Expr>) -> Result<(), Fault> {
        let tree = self.tree;
        if let Some(initial) = initial {
            let mut fault = None;
            initial.each(&mut |one| {
                if let ExprKind::Fault(own) = &one.kind {
                    fault = Some((**own).clone());
                }
            });
            if let Some(fault) = fault {
                return Err(fault);
            }
            self.found(|own, found| own.of_expr(at, initial, found));
        }
        match tree.types.get(spot.ty) {
            Typed::Block(unit) => {
                let instance = self.instance(spot, *unit);
                self.instance_begins(instance)
            }
            Typed::Struct(id) => {
                for (number, (name, ty)) in tree.types.parts(*id).iter().enumerate() {
                    let Some(tag) = spot.tag.part_at(number).filter(|_| self.matters(*ty)) else {
                        continue;
                    };
                    let name = format!("{}.{name}", spot.name);
                    self.begins(at, &Spot { name, tag, ty: *ty }, None)?;
                }
                Ok(())
            }
            Typed::Array(dimensions, of) if self.matters(*of) => {
                let [(low, high)] = dimensions[..] else {
                    let told = format!("{}: several dimensions of references", spot.name);
                    return Err(Fault::new(1, told).code(FaultCode::NotModelled));
                };
                if high - low >= MAX_ELEMENTS {
                    let told = format!("{} is too large to hold references", spot.name);
                    return Err(Fault::new(1, told).code(FaultCode::NotModelled));
                }
                for number in low..=high {
                    let Some(tag) = spot.tag.element(number) else { continue };
                    let name = format!("{}[{number}]", spot.name);
                    self.begins(at, &Spot { name, tag, ty: *of }, None)?;
                }
                Ok(())
            }
            _ => Ok(()),
        }
    }

    /// Whether a type contains references, interfaces or instances, so that its initial value may take addresses.
    fn matters(&self, ty: TypeId) -> bool {
        let is =
            |of: &Typed| matches!(of, Typed::Reference(..) | Typed::Interface(_) | Typed::Block(_));
        self.tree.holds(ty, &is)
    }

    /// The word to store in a reference. A fault if the value is not known to be an address of a matching type, or
    /// NULL.
    pub(super) fn reference_word(
        &mut self,
        reference: TypeId,
        value: Value,
        line: u32,
    ) -> Result<Number, Fault> {
        match value {
            Value::Constant(0) => Ok(constant(0, 1)),
            Value::Address(number, from) => {
                let can = self.candidates(reference);
                match from.iter().find(|one| !can.contains(one)) {
                    None => Ok(number),
                    Some(&other) => {
                        let other = &self.memory.targets.spots[other].name;
                        let what =
                            format!("a reference may refer to {other}, which is of another type");
                        Err(not_followed(line, what))
                    }
                }
            }
            _ => Err(not_followed(line, "the target of this reference is not known".to_owned())),
        }
    }

    /// Lowers taking the address of a place (ADR, REF): a reference that points to its variable. A fault for a bit of a
    /// word, for a VAR_IN_OUT parameter, and for array elements that are not modelled.
    pub(super) fn address(
        &mut self,
        at: &Context,
        place: &Place,
        line: u32,
    ) -> Result<Value, Fault> {
        let through = &mut |own: &mut Self, place: Place| own.address(at, &place, line);
        if let Some(found) = self.each_target(at, place, line, through)? {
            return Ok(found);
        }
        let what =
            || not_followed(line, format!("taking the address of {} is not modelled", place.text));
        let element = match place.steps.split_last() {
            Some((Step::Element(indices), path))
                if indices.iter().any(|one| one.whole().is_none()) =>
            {
                Some((indices, Place { steps: path.to_vec(), ..place.clone() }))
            }
            _ => None,
        };
        let Some((indices, whole)) = element else {
            let Found::Spot(spot) = self.find(at, place, line)? else { return Err(what()) };
            self.is_no_copy(&spot, line)?;
            let index = self.target(&spot);
            return Ok(Value::Address(constant(word(index), 1), vec![index]));
        };
        // The index is evaluated once; then each of its values is tried.
        if whole.has_open_index() {
            return Err(what());
        }
        let Found::Spot(array) = self.find(at, &whole, line)? else { return Err(what()) };
        let Typed::Array(dimensions, _) = self.tree.types.get(array.ty) else { return Err(what()) };
        let ([(low, high)], [index]) = (&dimensions[..], &indices[..]) else { return Err(what()) };
        let (low, high) = (*low, *high);
        if usize::try_from(high - low).is_ok_and(|many| many >= MOST) {
            return Err(what());
        }
        let value = self.value(at, index)?;
        let number = self.as_number(value, DINT);
        let words = self.copied(number, 2);
        self.not_followed_where(is_outside(&Number::Words(words.clone()), low, high));
        let (mut known, mut ends) = (None, Vec::new());
        for number in low..=high {
            let mut one = place.clone();
            let kind = ExprKind::Named(number);
            one.steps.pop();
            one.steps.push(Step::Element(vec![Expr { kind, ..index.clone() }]));
            let skip = Some(self.jump(is_number(&words, number, 2).not(), None));
            let found = self.address(at, &one, line)?;
            known = Some(self.gathered(known, found));
            self.past(skip, &mut ends);
        }
        Ok(self.otherwise_any(known, ends))
    }

    /// Refuses the address of a variable within a VAR_IN_OUT parameter, which is only a copy of the caller's. An
    /// instance that has such a parameter is not itself within one.
    fn is_no_copy(&mut self, spot: &Spot, line: u32) -> Result<(), Fault> {
        let tree = self.tree;
        let is_both = |id: VarId| tree.variable(id).section == Section::InOut;
        let mut copies = Vec::new();
        for Instance { unit, spot } in self.instances.clone() {
            for id in tree.members(unit).into_iter().filter(|&id| is_both(id)) {
                copies.extend(self.member(&spot, unit, id));
            }
        }
        for ((_, method), frame) in &self.memory.frames {
            let own = tree.routine(*method).variables.iter();
            copies.extend(
                own.filter(|&&id| is_both(id)).filter_map(|&id| self.local(frame, *method, id)),
            );
        }
        let own = spot.tag.regions();
        let is_within = |copy: &Spot| {
            let all = copy.tag.regions();
            let holds = |own: &Region| all.iter().any(|copy| encloses(*copy, *own));
            own.iter().all(holds)
        };
        if !copies.iter().any(is_within) {
            return Ok(());
        }
        let what = format!(
            "taking the address of {}, which is passed as VAR_IN_OUT, is not modelled",
            spot.name
        );
        let help = "pass a reference or a pointer instead of VAR_IN_OUT";
        Err(Fault::new(line, what).code(FaultCode::NotModelled).help(help))
    }

    /// Ends the code for one value of an index or reference: jumps to the common end, and sets the target of the
    /// skipping jump.
    pub(super) fn past(&mut self, skip: Option<usize>, ends: &mut Vec<usize>) {
        let Some(skip) = skip else { return };
        ends.push(self.jump(Logic::Const(true), None));
        self.land(skip);
        self.landing();
    }

    pub(super) fn all_land(&mut self, ends: Vec<usize>) {
        ends.into_iter().for_each(|end| self.land(end));
        self.landing();
    }

    /// Merges the value of one alternative with that of the alternatives before it.
    pub(super) fn gathered(&mut self, known: Option<Value>, value: Value) -> Value {
        match known {
            None => self.stored(value, true),
            Some(known) => self.merged(known, value),
        }
    }

    /// The place that a path reaches before step `end`, with its type. None if the type is not known.
    fn before(&self, at: &Context, place: &Place, end: usize) -> Option<Place> {
        let mut ty = self.root_type(at, place)?;
        for step in &place.steps[..end] {
            ty = self.step_type(ty, step)?;
        }
        Some(Place { steps: place.steps[..end].to_vec(), ty, ..place.clone() })
    }

    /// Reads a reference that can point to these variables: its word, or no word if it is not known. A run ends where
    /// the reference points to none of them.
    fn reference_read(
        &mut self,
        at: &Context,
        reference: &Place,
        can: &[usize],
        line: u32,
    ) -> Result<Vec<WordSource>, Fault> {
        self.cost(&["LD"], "contact");
        let value = match self.find(at, reference, line)? {
            Found::Spot(spot) => self.read_spot(&spot),
            Found::Element(element) => self.element(&element),
            Found::WordBit(..) => Value::Any,
        };
        match value {
            Value::Address(number, _) => {
                let words = self.copied(number, 1);
                let means = |&index: &usize| is_number(&words, word(index), 1);
                self.not_followed_where(Logic::Any(can.iter().map(means).collect()).not());
                Ok(words)
            }
            // With one possible target, the word only says whether the reference is NULL.
            _ if can.len() == 1 => {
                self.not_followed_where(Logic::Const(true));
                Ok(Vec::new())
            }
            _ => Err(not_followed(line, format!("the target of {} is not known", reference.text))),
        }
    }

    /// Runs `act` for each variable to which the first reference of a path can point, behind a test of the reference.
    /// Returns the merged value, or None if the path has no reference.
    pub(super) fn each_target(
        &mut self,
        at: &Context,
        place: &Place,
        line: u32,
        act: &mut dyn FnMut(&mut Lower<'t>, Place) -> Result<Value, Fault>,
    ) -> Result<Option<Value>, Fault> {
        let Some(end) = through(place) else { return Ok(None) };
        let shown = || place.text.trim_end_matches('^').to_owned();
        let Some(before) = self.before(at, place, end) else {
            return Err(not_followed(line, format!("the target of {} is not known", shown())));
        };
        let can = self.candidates(before.ty);
        if can.is_empty() {
            return Err(not_followed(
                line,
                format!("no variable is known to which {} can refer", shown()),
            ));
        }
        if can.len() > MOST {
            let what = format!("{} may refer to {} variables", shown(), can.len());
            return Err(not_followed(line, what));
        }
        // The index of a later part may change the reference.
        let later = Place { steps: place.steps[end..].to_vec(), ..place.clone() };
        for index in later.indices().filter(|index| index.calls()) {
            let written = self.expression_effects(at, index);
            if written.changes(&self.found(|own, found| own.looked_at(at, &before, found))) {
                return Err(self.index_calls(place, line));
            }
        }
        let words = self.reference_read(at, &before, &can, line)?;
        let (mut known, mut ends) = (None, Vec::new());
        // Outside of an array, or of what is known to be one, a reference may be any number.
        let may_be_outside = self.memory.targets.may_be_outside || before.has_open_index();
        let is_open = may_be_outside && !words.is_empty();
        for (number, &index) in can.iter().enumerate() {
            let is_tested = is_open || number + 1 < can.len();
            let skip = is_tested.then(|| self.jump(is_number(&words, word(index), 1).not(), None));
            let root = Root::Target(u32::try_from(index).unwrap_or(u32::MAX));
            let steps = place.steps[end + 1..].to_vec();
            let value = act(self, Place { root, steps, ..place.clone() })?;
            if can.len() == 1 && !is_tested {
                return Ok(Some(value));
            }
            known = Some(self.gathered(known, value));
            self.past(skip, &mut ends);
        }
        if is_open {
            return Ok(Some(self.otherwise_any(known, ends)));
        }
        self.all_land(ends);
        Ok(Some(known.unwrap_or(Value::Any)))
    }

    /// Ends the code for the values of an index or reference. With any other value, which means no variable that is
    /// known, nothing was executed, and the result may be any.
    pub(super) fn otherwise_any(&mut self, known: Option<Value>, ends: Vec<usize>) -> Value {
        let any = match &known {
            Some(Value::Bit(_)) => Value::Bit(self.free_bit()),
            Some(Value::Number(kind, _) | Value::Open(kind, ..)) => {
                Value::Number(*kind, self.worked_out(kind.words(), None))
            }
            Some(Value::Address(..)) => Value::Address(self.worked_out(1, None), Vec::new()),
            _ => Value::Any,
        };
        let merged = known.map(|known| self.merged(known, any)).unwrap_or(Value::Any);
        self.all_land(ends);
        merged
    }

    /// Whether a path has a dereference.
    pub(super) fn is_referred(place: &Place) -> bool {
        through(place).is_some()
    }

    /// The path with its reference replaced by the only variable to which it can point. None if it has no reference; a
    /// fault if there are several possible targets.
    pub(super) fn only_target(
        &mut self,
        at: &Context,
        place: &Place,
        line: u32,
    ) -> Result<Option<Place>, Fault> {
        let Some(end) = through(place) else { return Ok(None) };
        let before = self.before(at, place, end);
        let before = before.filter(|_| !self.memory.targets.may_be_outside);
        let can = before.as_ref().map(|before| self.candidates(before.ty)).unwrap_or_default();
        let (Some(before), [only]) = (before, &can[..]) else {
            let what = format!(
                "{} may mean one of several variables, or none that is known, which is not modelled here",
                place.text
            );
            let help = "assign it to a separate variable first, or call it in a statement";
            return Err(Fault::new(line, what).code(FaultCode::NotModelled).help(help));
        };
        self.reference_read(at, &before, &can, line)?;
        let root = Root::Target(u32::try_from(*only).unwrap_or(u32::MAX));
        Ok(Some(Place { root, steps: place.steps[end + 1..].to_vec(), ..place.clone() }))
    }

    /// Refuses an assignment through a reference if evaluating the value may change the reference.
    pub(super) fn stays(
        &mut self,
        at: &Context,
        place: &Place,
        value: &Expr,
        line: u32,
    ) -> Result<(), Fault> {
        if !value.calls() {
            return Ok(());
        }
        for before in references_in(place) {
            let is_one = self.means_one(at, &before);
            let read = Expr { ty: before.ty, kind: ExprKind::Read(before), line };
            if !is_one && self.order_matters(at, value, &read) {
                let what = format!("the value may change which variable {} refers to", place.text);
                let help = "assign the value to a separate variable first";
                return Err(Fault::new(line, what).code(FaultCode::NotModelled).help(help));
            }
        }
        Ok(())
    }
}
