//! Computes which cells code reads and writes, including all that it calls, separately for each instance. As effects
//! are cells, two names of one variable are recognised as one. A variable with an address also has its address bits,
//! numbered in all ways that controllers use.

use super::address::taken;
use super::cells::{Cells, Effects, add};
use super::references::references_in;
use super::spots::{Bits, Context, Spot};
use super::{Entry, Lower};
use scanbound_base::code::Code as FaultCode;
use scanbound_iec::fault::Fault;
use scanbound_iec::{PouKind, Section};
use scanbound_iec_tree::accesses::{self, Accesses};
use scanbound_iec_tree::charts::Chart;
use scanbound_iec_tree::declarations::{Code, RoutineId, RoutineKind, UnitId, VarId};
use scanbound_iec_tree::tree::{
    Call, Expr, Parameter, Passed, Place, Root, Statement, Step, StepFlag, Target,
};
use scanbound_iec_tree::types::Type as Typed;
use scanbound_ir::{AreaId, Cell, RegionSet};

/// The first of nine pseudo areas for the bits of direct addresses: inputs, outputs and memory, each in all ways of
/// numbering. No variable is stored there.
const BITS: u16 = u16::MAX - 9;

/// A pseudo area with one cell for the whole state of each chart.
const CHARTS: u16 = BITS - 1;

/// Arrays of up to this many elements are examined element by element. For larger ones, any effect is assumed.
const MOST: i64 = 64;

/// Whether two paths certainly name the same place. Array elements must have the same constant indices.
pub(super) fn is_same(one: &Place, other: &Place) -> bool {
    let step = |(one, other): (&Step, &Step)| match (one, other) {
        (Step::Part(one), Step::Part(other)) => one == other,
        (Step::Member(one), Step::Member(other)) => one == other,
        (Step::Pin(one), Step::Pin(other)) => one == other,
        (Step::Bit(one), Step::Bit(other)) => one == other,
        (Step::Element(one), Step::Element(other)) => {
            one.len() == other.len()
                && one
                    .iter()
                    .zip(other)
                    .all(|(one, other)| one.whole().is_some() && one.whole() == other.whole())
        }
        (Step::Result(one, of_base), Step::Result(other, also)) => one == other && of_base == also,
        _ => false,
    };
    one.root == other.root
        && one.steps.len() == other.steps.len()
        && one.steps.iter().zip(&other.steps).all(step)
}

impl Lower<'_> {
    /// Counts the calls in an expression that write something which remains after the call.
    pub(super) fn acting_calls(&mut self, at: &Context, one: &Expr) -> usize {
        let mut own = Vec::new();
        one.each_call(&mut |one| own.push(one.clone()));
        own.iter().filter(|one| !self.expression_effects(at, one).writes.is_empty()).count()
    }

    /// The effects of an expression, without the variables that exist only during its calls.
    pub(super) fn expression_effects(&mut self, at: &Context, one: &Expr) -> Effects {
        let found = self.found(|own, found| own.of_expr(at, one, found));
        self.lasting(at, found)
    }

    /// Removes effects on variables that are initialised at every call, except those of the instance or method at `at`.
    pub(super) fn lasting(&self, at: &Context, found: Effects) -> Effects {
        let own = self.instances[at.instance].spot.tag.regions();
        let frame = at.frame.as_ref().map(|frame| frame.tag.regions()).unwrap_or_default();
        let own: RegionSet = own.into_iter().chain(frame).collect();
        // Variables of functions and methods are initialised at every call; those of the code itself still count.
        let functions = &self.memory.begin_anew;
        // A reference may lead to those of a call around this one.
        let targets = &self.memory.targets.regions;
        found.lasting(|region| {
            !functions.overlaps(region) || own.overlaps(region) || targets.overlaps(region)
        })
    }

    /// Collects effects in a new set and returns it.
    pub(super) fn found(&mut self, find: impl FnOnce(&mut Self, &mut Effects)) -> Effects {
        let mut found = Effects::default();
        find(self, &mut found);
        found
    }

    /// Whether the evaluation order of two expressions may change a result: one of them has calls and writes what the
    /// other reads or writes.
    pub(super) fn order_matters(&mut self, at: &Context, one: &Expr, other: &Expr) -> bool {
        if !one.calls() && !other.calls() {
            return false;
        }
        let (one, other) = (self.expression_effects(at, one), self.expression_effects(at, other));
        one.changes(&other) || other.changes(&one)
    }

    /// Refuses a path in which a call in an index changes what an index in other brackets reads: controllers evaluate
    /// these in different orders. Indices in the same brackets are lowered both ways.
    pub(super) fn has_one_order(
        &mut self,
        at: &Context,
        place: &Place,
        line: u32,
    ) -> Result<(), Fault> {
        let brackets: Vec<&[Expr]> = place
            .steps
            .iter()
            .filter_map(|step| match step {
                Step::Element(indices) => Some(&indices[..]),
                _ => None,
            })
            .collect();
        for (nth, later) in brackets.iter().enumerate() {
            for earlier in &brackets[..nth] {
                let pairs =
                    earlier.iter().flat_map(|one| later.iter().map(move |other| (one, other)));
                for (one, other) in pairs {
                    if self.order_matters(at, one, other) {
                        return Err(self.index_calls(place, line));
                    }
                }
            }
        }
        Ok(())
    }

    /// The fault for a path with a call in an index that changes what other parts of the path mean.
    pub(super) fn index_calls(&self, place: &Place, line: u32) -> Fault {
        let told = format!(
            "a call in an index of {} changes what another part of it reads, and controllers evaluate these in different orders",
            place.text
        );
        let help = "assign the result of the call to a separate variable first";
        Fault::new(line, told).code(FaultCode::NotModelled).help(help)
    }

    /// Whether statements, or code that they call, may write the variable at a place or change which variable it is.
    /// Always true for an index that is not constant.
    pub(super) fn may_write(&mut self, at: &Context, body: &[Statement], place: &Place) -> bool {
        // The index may change, and with it the element.
        if place.has_open_index() {
            return true;
        }
        let written = self.found(|own, found| own.of_statements(at, body, found));
        written.changes(&self.found(|own, found| own.looked_at(at, place, found)))
    }

    /// Whether statements, or code that they call, may change the value of an expression.
    pub(super) fn may_change(&mut self, at: &Context, body: &[Statement], one: &Expr) -> bool {
        let written = self.found(|own, found| own.of_statements(at, body, found));
        written.changes(&self.found(|own, found| own.of_expr(at, one, found)))
    }

    /// Whether an expression, or code that it calls, reads or writes a variable, by any name.
    pub(super) fn names(&mut self, at: &Context, one: &Expr, place: &Place) -> bool {
        let named = self.found(|own, found| own.of_expr(at, one, found));
        named.meets(&self.found(|own, found| own.looked_at(at, place, found)))
    }

    /// Whether programs of tasks other than the one being lowered may write a variable.
    pub(super) fn others_write(&mut self, at: &Context, place: &Place) -> bool {
        let own = self.found(|own, found| own.looked_at(at, place, found));
        let here = self.routines.task;
        if !self.routines.others.contains_key(&here) {
            // Each task has its own instances of functions.
            let around = std::mem::take(&mut self.effects);
            let mut found = Effects::default();
            for (task, all) in self.routines.tasks.clone().into_iter().enumerate() {
                self.routines.task = task;
                self.effects.clear();
                for instance in all.into_iter().filter(|_| task != here) {
                    let more = self.effects_of((instance, Entry::Body));
                    found.join(&more);
                }
            }
            self.routines.task = here;
            self.effects = around;
            self.routines.others.insert(here, found);
        }
        self.routines.others[&here].changes(&own)
    }

    /// The effects of a routine of an instance, of what it calls, and of the initial values that its call evaluates.
    pub(super) fn effects_of(&mut self, (instance, entry): (usize, Entry)) -> Effects {
        if let Some(known) = self.effects.get(&(instance, entry)) {
            return known.clone();
        }
        // Ends recursion; recursive calls are refused elsewhere.
        self.effects.insert((instance, entry), Effects::default());
        let mut found = Effects::default();
        let tree = self.tree;
        let unit = self.instances[instance].unit;
        let is_temp = |id: &VarId| tree.variable(*id).section == Section::Temp;
        let temporary = |unit| tree.members(unit).into_iter().filter(is_temp).collect();
        let (routine, begun): (_, Vec<VarId>) = match entry {
            Entry::Body if tree.unit(unit).kind == PouKind::Function => {
                (self.body_in(unit), tree.unit(unit).variables.clone())
            }
            Entry::Body => (self.body_in(unit), temporary(unit)),
            Entry::Routine(id) => match (tree.routine(id).kind, tree.routine(id).unit) {
                (RoutineKind::Body, of) => (self.body_in(of), temporary(of)),
                (RoutineKind::Action, _) => (Some(id), Vec::new()),
                (RoutineKind::Method, _) => (Some(id), tree.routine(id).variables.clone()),
            },
        };
        let frame = match entry {
            Entry::Routine(id) if tree.routine(id).kind == RoutineKind::Method => {
                self.frame(instance, id).ok()
            }
            _ => None,
        };
        let at = Context { instance, frame };
        self.initial_effects(&at, &begun, &mut found);
        match routine {
            Some(id) if self.stated_of(instance, entry).is_none() => match &tree.routine(id).code {
                Code::Statements(all) => self.of_statements(&at, all, &mut found),
                Code::Chart(chart) => self.of_chart(&at, id, chart, &mut found),
                Code::Unread(_) => found.anything = true,
            },
            _ => self.of_absent((instance, entry), &mut found),
        }
        self.effects.insert((instance, entry), found.clone());
        found
    }

    /// Adds the effects of a missing body whose time is stated: it may write everything that its instance has, and what
    /// it is stated to write. Adds nothing if nothing is stated.
    fn of_absent(&mut self, called: (usize, Entry), found: &mut Effects) {
        let Some((routine, stated)) = self.stated_of(called.0, called.1) else { return };
        match self.all_it_writes(called.0, called.1, routine.line, stated) {
            Ok(regions) => add(&mut found.writes, regions),
            Err(_) => found.anything = true,
        }
    }

    pub(super) fn of_statements(&mut self, at: &Context, all: &[Statement], found: &mut Effects) {
        accesses::of_statements(all, &mut Walk { lower: self, at, found });
    }

    pub(super) fn of_expr(&mut self, at: &Context, one: &Expr, found: &mut Effects) {
        accesses::of_expr(one, &mut Walk { lower: self, at, found });
    }

    pub(super) fn of_actions(&mut self, at: &Context, chart: &Chart, found: &mut Effects) {
        accesses::of_chart_code(chart, &mut Walk { lower: self, at, found });
    }

    pub(super) fn of_call(&mut self, at: &Context, call: &Call, found: &mut Effects) {
        accesses::of_call(call, &mut Walk { lower: self, at, found });
    }

    /// Adds the effects of the routine that a call executes, and of finding it. The effects of indices in the path are
    /// added elsewhere.
    fn of_target(&mut self, at: &Context, call: &Call, found: &mut Effects) {
        let tree = self.tree;
        let own = match &call.target {
            Target::Function(unit) => {
                self.function_instance(*unit).ok().map(|instance| (instance, Entry::Body))
            }
            Target::BaseMethod(method) => Some((at.instance, Entry::Routine(*method))),
            Target::BaseBody(base) => Some((at.instance, Entry::Routine(tree.unit(*base).body))),
            Target::Standard(place, _) => {
                self.led_through(at, place, found);
                self.reads_of(at, place, found);
                self.writes_of(at, place, found);
                None
            }
            Target::Instance(place, _) | Target::Program(place, _) => {
                self.led_through(at, place, found);
                self.passed_to(at, place, &call.passed, found);
                for instance in self.instances_at(at, place, found) {
                    let more = self.effects_of((instance, Entry::Body));
                    found.join(&more);
                }
                None
            }
            Target::Action(place, routine) | Target::Method(place, routine) => {
                self.led_through(at, place, found);
                for instance in self.instances_at(at, place, found) {
                    let unit = self.instances[instance].unit;
                    let own = tree.dispatched(unit, *routine);
                    let more = self.effects_of((instance, Entry::Routine(own)));
                    found.join(&more);
                }
                None
            }
        };
        if let Some(own) = own {
            let more = self.effects_of(own);
            found.join(&more);
        }
    }

    /// Adds the passed parameters of an instance as reads and writes of its call.
    pub(super) fn passed_to(
        &mut self,
        at: &Context,
        place: &Place,
        passed: &[(Parameter, Passed)],
        found: &mut Effects,
    ) {
        for (parameter, _) in passed {
            let mut own = place.clone();
            own.steps.push(match parameter {
                Parameter::Variable(id) => Step::Member(*id),
                Parameter::Pin(pin) => Step::Pin(*pin),
            });
            self.reads_of(at, &own, found);
            self.writes_of(at, &own, found);
        }
    }

    /// Adds the effects of evaluating the initial values of those of these variables that begin anew with each call.
    fn initial_effects(&mut self, at: &Context, all: &[VarId], found: &mut Effects) {
        let tree = self.tree;
        for &id in all {
            let one = tree.variable(id);
            // Initial values of inputs are constant.
            let begins = matches!(one.section, Section::Local | Section::Temp | Section::Output);
            if let Some(initial) = one.initial.as_ref().filter(|_| begins) {
                self.of_expr(at, initial, found);
            }
        }
    }

    /// Whether a reference can point to at most one variable.
    pub(super) fn means_one(&mut self, at: &Context, reference: &Place) -> bool {
        let mut found = Effects::default();
        let spots = self.spots(at, reference, &mut found);
        !found.anything && spots.iter().all(|spot| self.candidates(spot.ty).len() < 2)
    }

    /// The instances that a place may denote. Sets `found.anything` if they are not all known.
    pub(super) fn instances_at(
        &mut self,
        at: &Context,
        place: &Place,
        found: &mut Effects,
    ) -> Vec<usize> {
        let mut known = Vec::new();
        for spot in self.spots(at, place, found) {
            let unit = self.unit_of(spot.ty);
            known.extend(unit.map(|unit| self.instance(&spot, unit)));
        }
        known
    }

    /// The pseudo cell that stands for the whole state of the chart of a routine.
    pub(super) fn chart_cell(&mut self, instance: usize, id: RoutineId) -> (Cell, u32) {
        let next = u32::try_from(self.charts.numbers.len()).unwrap_or(u32::MAX);
        let index = *self.charts.numbers.entry((instance, id)).or_insert(next);
        (Cell { area: AreaId(CHARTS), index }, 1)
    }

    /// The variables that a place may denote, with each possible array element by itself. Sets `found.anything` if they
    /// are not all known.
    fn spots(&mut self, at: &Context, place: &Place, found: &mut Effects) -> Vec<Spot> {
        let Ok(root) = self.root(at, place.root, 0) else {
            found.anything |= !matches!(place.root, Root::Temporary(_));
            return Vec::new();
        };
        let mut spots = vec![root];
        let mut first = self.root_unit(at, place.root);
        for step in &place.steps {
            let mut next = Vec::new();
            for spot in &spots {
                let unit = first.or_else(|| self.unit_of(spot.ty));
                if matches!(step, Step::Dereference) {
                    let can = self.candidates(spot.ty);
                    next.extend(can.into_iter().map(|at| self.memory.targets.spots[at].clone()));
                    continue;
                }
                if let Some(one) = self.stepped(spot, unit, step) {
                    next.push(one);
                    continue;
                }
                match (self.tree.types.get(spot.ty), step) {
                    (Typed::Array(dimensions, of), Step::Element(_))
                        if elements(dimensions) <= MOST =>
                    {
                        let mut all = vec![Spot { ty: *of, ..spot.clone() }];
                        for &(low, high) in dimensions {
                            let outer = std::mem::take(&mut all);
                            for (one, number) in outer
                                .iter()
                                .flat_map(|one| (low..=high).map(move |number| (one, number)))
                            {
                                let Some(tag) = one.tag.element(number) else {
                                    found.anything = true;
                                    continue;
                                };
                                let name = format!("{}[{number}]", one.name);
                                all.push(Spot { name, tag, ty: *of });
                            }
                        }
                        next.extend(all);
                    }
                    _ => found.anything = true,
                }
            }
            spots = next;
            first = None;
        }
        spots
    }

    /// Adds the effects of finding a place: those of its indices, and reads of the references in it.
    pub(super) fn led_to(&mut self, at: &Context, place: &Place, found: &mut Effects) {
        for index in place.indices() {
            self.of_expr(at, index, found);
        }
        self.led_through(at, place, found);
    }

    /// Adds reads of the references in a path.
    fn led_through(&mut self, at: &Context, place: &Place, found: &mut Effects) {
        for before in references_in(place) {
            match self.cells(at, &before) {
                Some(cells) => found.reads.extend(cells),
                None => found.anything = true,
            }
        }
    }

    /// Adds the effects of reading a place: the cells that it may denote, and those of finding it.
    pub(super) fn looked_at(&mut self, at: &Context, place: &Place, found: &mut Effects) {
        self.led_to(at, place, found);
        self.reads_of(at, place, found);
    }

    /// Adds the effects of writing a place: the cells that it may denote, and those of finding it.
    pub(super) fn written(&mut self, at: &Context, place: &Place, found: &mut Effects) {
        self.led_to(at, place, found);
        self.writes_of(at, place, found);
    }

    fn reads_of(&mut self, at: &Context, place: &Place, found: &mut Effects) {
        match self.cells(at, place) {
            Some(cells) => found.reads.extend(cells),
            None => found.anything = true,
        }
    }

    fn writes_of(&mut self, at: &Context, place: &Place, found: &mut Effects) {
        match self.cells(at, place) {
            Some(cells) => found.writes.extend(cells),
            None => found.anything = true,
        }
    }

    /// The cells that a place may denote; empty for a temporary. None if they are not known.
    fn cells(&mut self, at: &Context, place: &Place) -> Option<Cells> {
        if let Root::Temporary(_) = place.root {
            return Some(Cells::new());
        }
        let spot = self.root(at, place.root, 0).ok()?;
        let mut found = Cells::new();
        match place.root {
            Root::Variable(id) => self.add_address(id, &mut found),
            Root::Address(id) => {
                let taken = taken(self.tree, spot.ty, &self.tree.address(id).text);
                taken.into_iter().for_each(|taken| add_bits(taken, &mut found));
            }
            Root::This | Root::Program(_) | Root::Temporary(_) | Root::Target(_) => {}
        }
        let unit = self.root_unit(at, place.root);
        self.add_cells(spot, unit, &place.steps, &mut found);
        Some(found)
    }

    fn add_cells(&mut self, spot: Spot, unit: Option<UnitId>, steps: &[Step], found: &mut Cells) {
        let Some((step, rest)) = steps.split_first() else {
            return add(found, spot.tag.regions());
        };
        if matches!(step, Step::Dereference) {
            for at in self.candidates(spot.ty) {
                let target = self.memory.targets.spots[at].clone();
                let unit = self.unit_of(target.ty);
                self.add_cells(target, unit, rest, found);
                self.add_target_address(at, found);
            }
            return;
        }
        match self.stepped(&spot, unit, step) {
            Some(next) => {
                if let Step::Member(id) = step {
                    self.add_address(*id, found);
                }
                let unit = self.unit_of(next.ty);
                self.add_cells(next, unit, rest, found);
            }
            None => {
                // For an unknown index, the whole array counts, with all targets of the references in its elements.
                add(found, spot.tag.regions());
                if let (Step::Element(_), Typed::Array(_, of)) =
                    (step, self.tree.types.get(spot.ty))
                {
                    self.add_through(*of, rest, found);
                }
            }
        }
    }

    /// Adds the addresses of members of an array element with an unknown index, and the cells that can be reached
    /// through references in it.
    fn add_through(
        &mut self,
        of: scanbound_iec_tree::types::TypeId,
        steps: &[Step],
        found: &mut Cells,
    ) {
        let mut ty = of;
        for (at, step) in steps.iter().enumerate() {
            if matches!(step, Step::Dereference) {
                for number in self.candidates(ty) {
                    let target = self.memory.targets.spots[number].clone();
                    let unit = self.unit_of(target.ty);
                    self.add_cells(target, unit, &steps[at + 1..], found);
                    self.add_target_address(number, found);
                }
                return;
            }
            if let Step::Member(id) = step {
                self.add_address(*id, found);
            }
            match self.step_type(ty, step) {
                Some(next) => ty = next,
                None => return,
            }
        }
    }

    /// Adds the addresses at which a target of references is.
    fn add_target_address(&self, target: usize, found: &mut Cells) {
        let addresses = self.memory.targets.addresses.get(target);
        addresses.into_iter().flatten().for_each(|&taken| add_bits(taken, found));
    }

    /// Adds the address of a variable, if it has one.
    fn add_address(&self, id: VarId, found: &mut Cells) {
        let variable = self.tree.variable(id);
        let taken = variable.at.as_ref().and_then(|at| taken(self.tree, variable.ty, at));
        taken.into_iter().for_each(|taken| add_bits(taken, found));
    }

    /// The body of a unit, or the nearest body that it inherits. None if all are empty.
    pub(super) fn body_in(&self, unit: UnitId) -> Option<RoutineId> {
        let tree = self.tree;
        let bodies = tree.lineage(unit).into_iter().map(|unit| tree.unit(unit).body);
        { bodies }.find(|&id| !tree.routine(id).code.is_empty())
    }

    /// Whether a type contains instances for which controllers execute a method by themselves at the beginning or end
    /// of their life (such as FB_Init).
    pub(super) fn begins_with_method(&self, ty: scanbound_iec_tree::types::TypeId) -> bool {
        let tree = self.tree;
        let begins = |of: &Typed| match of {
            Typed::Block(unit) => {
                tree.lineage(*unit).into_iter().any(|one| tree.unit(one).begins_with_method)
            }
            _ => false,
        };
        tree.holds(ty, &begins)
    }
}

/// The number of elements of an array with these index ranges, capped at `i64::MAX`.
fn elements(dimensions: &[(i64, i64)]) -> i64 {
    let count = |(low, high): &(i64, i64)| high.saturating_sub(*low).saturating_add(1);
    dimensions.iter().map(count).fold(1, i64::saturating_mul)
}

/// Adds the pseudo cells of the bits of an address, in both ways of numbering. Nothing for an address of another form.
fn add_bits((area, taken): Bits, found: &mut Cells) {
    let number = match area {
        'I' => 0,
        'Q' => 3,
        _ => 6,
    };
    for (side, (from, to)) in (0..).zip(taken) {
        let index = u32::try_from(from).unwrap_or(u32::MAX / 2);
        let first = Cell { area: AreaId(BITS + number + side), index };
        found.insert((first, u32::try_from(to - from).unwrap_or(u32::MAX / 2)));
    }
}

/// Collects the effects of code in a context while walking through it.
struct Walk<'w, 't> {
    lower: &'w mut Lower<'t>,
    at: &'w Context,
    found: &'w mut Effects,
}

impl Accesses for Walk<'_, '_> {
    fn reads(&mut self, place: &Place) {
        self.lower.led_through(self.at, place, self.found);
        self.lower.reads_of(self.at, place, self.found);
    }

    fn writes(&mut self, place: &Place) {
        self.lower.led_through(self.at, place, self.found);
        self.lower.writes_of(self.at, place, self.found);
    }

    fn takes_address(&mut self, place: &Place) {
        self.lower.memory.targets.may_be_outside |= place.has_open_index();
        self.lower.led_through(self.at, place, self.found);
        for spot in self.lower.spots(self.at, place, self.found) {
            self.lower.target(&spot);
        }
    }

    fn asks(&mut self, flag: &StepFlag) {
        self.lower.led_through(self.at, &flag.owner, self.found);
        for instance in self.lower.instances_at(self.at, &flag.owner, self.found) {
            self.found.reads.insert(self.lower.chart_cell(instance, flag.chart));
        }
    }

    fn calls(&mut self, call: &Call) {
        self.lower.of_target(self.at, call, self.found);
    }

    fn unread(&mut self) {
        self.found.anything = true;
    }
}
