//! What is known while a drawing is executed: the drawing, what of it has been executed, and the expression that is put
//! together.

use super::super::resolver::{Resolver, Scope};
use super::super::statements::Labels;
use super::loops::Loops;
use super::touched::{Held, Touched};
use super::worth::{Kept, Worth};
use crate::declarations::{Purpose, TempId, Temporary, VarId};
use crate::show;
use crate::tree::{Statement, StatementKind};
use crate::types::TypeId;
use scanbound_base::code::Code;
use scanbound_iec::ast::Held as HeldOutput;
use scanbound_iec::drawing::{Drawing, Edge, Element, ElementId, ElementKind};
use scanbound_iec::fault::Fault;
use scanbound_iec::written::behind_edges;
use std::collections::{BTreeMap, BTreeSet};

/// An output of an element.
pub(super) type Output<'d> = (ElementId, &'d str);

/// What a drawing keeps something for: each has temporaries or variables of its own.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Use {
    /// What leads on to several elements.
    Way,
    /// What a function gives.
    Result,
    /// Whether a box with text is enabled.
    Enable,
    /// Whether there is an edge.
    Edge,
    /// A result that generators set to its first value when a function begins.
    Begun,
}

/// What is kept: what for, of which output, and how often it has been kept before.
pub(super) type Key<'d> = (Use, Output<'d>, usize);

/// What a drawing keeps and declares, in all its orders.
#[derive(Default)]
pub(super) struct Hidden<'d> {
    pub(super) temporaries: BTreeMap<Key<'d>, TempId>,
    pub(super) variables: BTreeMap<Key<'d>, VarId>,
    /// Whether something is looked at that has changed since it was looked at first: what is looked at is stored then.
    pub(super) looks_again: bool,
    /// Whether all is to be done anew, since something was not known before.
    pub(super) is_stale: bool,
}

/// What is the same in all orders.
pub(super) struct Sheet<'d> {
    pub(super) drawing: &'d Drawing,
    pub(super) scope: Scope,
    /// Whether it has jumps, labels or returns.
    pub(super) has_jumps: bool,
    /// Whether it has connectors.
    pub(super) has_connectors: bool,
    /// Contacts that look at edges, and what they lead to.
    pub(super) behind_edges: BTreeSet<ElementId>,
}

/// A statement, the element to which it belongs, and what it touches.
pub(super) struct Executed {
    pub(super) statement: Statement,
    pub(super) owner: ElementId,
    pub(super) touched: Touched,
}

/// What of a drawing has been executed.
#[derive(Default)]
pub(super) struct Progress<'d> {
    pub(super) all: Vec<Executed>,
    /// Blocks, coils and outputs that have been executed.
    pub(super) done: BTreeSet<ElementId>,
    /// The element that is executed.
    pub(super) owner: ElementId,
    /// Its number of execution, or that of the element that asks for it.
    pub(super) acting: Option<u64>,
    /// What outputs were worth when they were first stored.
    pub(super) kept: BTreeMap<Output<'d>, Kept>,
    /// What edges showed when they were first looked at.
    pub(super) edges: BTreeMap<Output<'d>, Kept>,
    /// What is stored: what it was made of, and how many statements had been executed then.
    pub(super) stored: BTreeMap<Held, (Touched, usize)>,
    /// How often each value was stored and each edge looked at.
    pub(super) times: BTreeMap<(Use, Output<'d>), usize>,
    /// Whether blocks that have been executed were enabled.
    pub(super) enables: BTreeMap<ElementId, Worth>,
    /// What blocks were handed in and out, by the names of the pins in small letters.
    pub(super) given_back: BTreeMap<(ElementId, String), Worth>,
    /// How many values are one of two.
    pub(super) eithers: usize,
    /// Whether something was done as generators alone do it: ways to a coil were joined by AND, a sign was left out.
    pub(super) differs_in_itself: bool,
}

/// The expression that is put together.
#[derive(Default)]
pub(super) struct Term<'d> {
    /// What outputs are worth in it.
    pub(super) looked_at: BTreeMap<Output<'d>, Worth>,
    /// Whether what is asked for twice in it is written once.
    pub(super) is_written_once: bool,
    /// How many elements have been looked at for it.
    pub(super) visits: usize,
}

/// Executes a drawing in one order.
pub(super) struct Drawer<'r, 'p, 'd> {
    pub(super) resolver: &'r mut Resolver<'p>,
    pub(super) labels: &'r mut Labels,
    pub(super) sheet: &'r Sheet<'d>,
    pub(super) hidden: &'r mut Hidden<'d>,
    pub(super) loops: Loops,
    /// Whether coils in the midst of a way are executed in their own places, as generators do.
    pub(super) is_generated: bool,
    pub(super) progress: Progress<'d>,
    pub(super) term: Term<'d>,
    /// The elements that are being looked at.
    pub(super) open: BTreeSet<ElementId>,
    /// How many of them there are, each as often as it is one.
    pub(super) depth: usize,
}

impl<'d> Sheet<'d> {
    pub(super) fn new(drawing: &'d Drawing, scope: Scope) -> Result<Sheet<'d>, Fault> {
        let mut movers = drawing.elements.iter().filter(|one| one.moves());
        let is_numbered = drawing.elements.iter().any(|one| one.order.is_some());
        if let Some(one) = movers.clone().find(|one| one.order.is_none()).filter(|_| is_numbered) {
            let what = "it has no executionOrderId, but other elements have: what is jumped over is not clear";
            let help = "number it, too, or leave out all numbers: then elements are executed from top to bottom";
            return Err(one.fault(what).code(Code::NotModelled).help(help));
        }
        let has_jumps = movers.next().is_some();
        let mut numbers = BTreeSet::new();
        let is_second =
            |one: &&Element| one.acts() && one.order.is_some_and(|number| !numbers.insert(number));
        if let Some(one) = drawing.elements.iter().find(is_second) {
            let what =
                "another element has its executionOrderId: which of them comes first is not clear";
            let help = "give each a number of its own";
            return Err(one.fault(what).code(Code::NotModelled).help(help));
        }
        let has_connectors = drawing.elements.iter().any(|one| one.kind == ElementKind::Connector);
        let behind_edges = behind_edges(drawing);
        Ok(Sheet { drawing, scope, has_jumps, has_connectors, behind_edges })
    }
}

impl<'r, 'p, 'd> Drawer<'r, 'p, 'd> {
    pub(super) fn new(
        resolver: &'r mut Resolver<'p>,
        sheet: &'r Sheet<'d>,
        hidden: &'r mut Hidden<'d>,
        labels: &'r mut Labels,
        (loops, is_generated): (Loops, bool),
    ) -> Self {
        Drawer {
            resolver,
            labels,
            sheet,
            hidden,
            loops,
            is_generated,
            progress: Progress::default(),
            term: Term { is_written_once: true, ..Term::default() },
            open: BTreeSet::new(),
            depth: 0,
        }
    }

    pub(super) fn element(&self, id: ElementId) -> &'d Element {
        self.sheet.drawing.element(id)
    }

    /// Whether a variable is negated where it is wired up. Generators leave this out.
    pub(super) fn obeys(&mut self, is_negated: bool) -> bool {
        self.progress.differs_in_itself |= is_negated && self.is_generated;
        is_negated && !self.is_generated
    }

    /// The edge that is looked at. Generators look at none of what is negated, sets or resets.
    pub(super) fn edge_beside(&mut self, edge: Option<Edge>, has_sign: bool) -> Option<Edge> {
        let is_left = edge.is_some() && has_sign && self.is_generated;
        self.progress.differs_in_itself |= is_left;
        edge.filter(|_| !is_left)
    }

    /// Whether expressions are written as generators write them. Other controllers take what they have looked at.
    pub(super) fn is_written(&self) -> bool {
        let is_text = self.is_generated || self.sheet.drawing.goal.is_some();
        !self.sheet.drawing.is_executed_as_drawn && (is_text || !self.hidden.looks_again)
    }

    /// The number of execution by which it is known whether what an element asks for has been executed. Generators
    /// execute what outputs ask for before them, whatever its number.
    pub(super) fn number(&self, one: &Element) -> Option<u64> {
        one.order.filter(|_| !self.is_generated || one.block().is_some())
    }

    /// A statement of the element that is executed.
    pub(super) fn add(&mut self, line: u32, kind: StatementKind, text: String) {
        let statement = Statement { kind, text: text.into(), line };
        let statement = self.resolver.statement_after(0, statement);
        let touched = self.resolver.touched(std::slice::from_ref(&statement));
        self.progress.all.push(Executed { statement, owner: self.progress.owner, touched });
    }

    /// A statement under a condition that writes a variable.
    pub(super) fn add_if(
        &mut self,
        line: u32,
        condition: Worth,
        kind: StatementKind,
        target: &str,
    ) {
        let text = show::statement(&self.resolver.tree, &kind, target);
        if condition.is(true) {
            return self.add(line, kind, text);
        }
        let outer = format!("IF {} THEN", show::expr(&self.resolver.tree, &condition.expr));
        let inner = Statement { kind, text: text.into(), line };
        let inner = self.resolver.statement_after(0, inner);
        let kind = StatementKind::If(vec![(condition.expr, vec![inner])], Vec::new());
        self.add(line, kind, outer);
    }

    /// The key of what is kept once more.
    pub(super) fn next_key(&mut self, of: Use, output: Output<'d>) -> Key<'d> {
        let times = self.progress.times.entry((of, output)).or_insert(0);
        *times += 1;
        (of, output, *times)
    }

    /// The temporary of a key.
    pub(super) fn temporary(&mut self, key: Key<'d>, ty: TypeId) -> TempId {
        if let Some(&known) = self.hidden.temporaries.get(&key) {
            return known;
        }
        let purpose = match key.0 {
            Use::Result => Purpose::Result,
            Use::Enable => Purpose::Loaded,
            Use::Way => Purpose::Between,
            Use::Edge | Use::Begun => unreachable!("a variable is declared for it"),
        };
        let text = self.display_name(key);
        let all = &mut self.resolver.tree.temporaries;
        all.push(Temporary { purpose, ty, text });
        let id = TempId::at(all.len() - 1);
        self.hidden.temporaries.insert(key, id);
        id
    }

    /// The variable of a key, which is declared where there is none.
    pub(super) fn variable(&mut self, key: Key<'d>, ty: TypeId) -> VarId {
        if let Some(&known) = self.hidden.variables.get(&key) {
            return known;
        }
        self.hidden.is_stale |= self.hidden.temporaries.contains_key(&key);
        let goal = self.sheet.drawing.goal.as_ref();
        let part = goal.filter(|goal| !goal.part.is_empty());
        let part = part.map_or(String::new(), |goal| format!(" in {}", goal.part));
        let line = self.element(key.1.0).line;
        let name = format!("{}{part}, line {line}", self.display_name(key));
        let id = self.resolver.hidden_variable(self.sheet.scope, name, ty);
        self.hidden.variables.insert(key, id);
        id
    }

    /// Notes a variable that the condition reads whose drawing this is.
    pub(super) fn note_for_condition(&mut self, id: VarId, one: &Element, output: Option<&str>) {
        if let (Some(goal), Some(unit)) = (&self.sheet.drawing.goal, self.sheet.scope.unit) {
            let (part, local_id) = (goal.part.clone(), one.local_id.clone());
            let held = HeldOutput { part, local_id, output: output.map(str::to_owned) };
            self.resolver.held.insert((unit, held), id);
        }
    }

    /// What is kept, for messages.
    pub(super) fn display_name(&self, (of, (id, output), times): Key<'d>) -> String {
        let local_id = &self.element(id).local_id;
        let name = match of {
            Use::Way => format!("what leads on from localId {local_id}"),
            Use::Edge => format!("the edge at localId {local_id}"),
            Use::Enable => format!("EN of the block with localId {local_id}"),
            Use::Result | Use::Begun if output.is_empty() => {
                format!("the result of the block with localId {local_id}")
            }
            Use::Result | Use::Begun => {
                format!("output {output} of the block with localId {local_id}")
            }
        };
        if times > 1 { format!("{name} ({times})") } else { name }
    }
}

/// What a statement does, or what is wrong with it.
pub(super) fn resolved(kind: Result<StatementKind, Fault>) -> StatementKind {
    kind.unwrap_or_else(|fault| StatementKind::Fault(Box::new(fault)))
}

/// A fault with the element that asks for a name which is not there.
pub(super) fn at_element(one: &Element, fault: Fault) -> Fault {
    match fault.code {
        Code::UnknownName => fault.within(&one.called()),
        _ => fault,
    }
}
