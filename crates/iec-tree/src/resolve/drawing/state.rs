//! The state while a drawing is executed: the drawing, what has been executed, and the current expression.

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
use scanbound_iec::drawing::{Drawing, Edge, Element, ElementId};
use scanbound_iec::fault::Fault;
use scanbound_iec::written::behind_edges;
use std::collections::{BTreeMap, BTreeSet};

/// An output of an element: the element and the output's name.
pub(super) type Output<'d> = (ElementId, &'d str);

/// The purpose for which a drawing stores a value; each has separate temporaries or variables.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Use {
    /// An intermediate value that several elements use.
    Way,
    /// The result of a function.
    Result,
    /// The value of EN of an EXECUTE box.
    Enable,
    /// The instance that detects an edge.
    Edge,
    /// A function's result that generators initialize at the start of the surrounding function.
    Begun,
}

/// The key of a stored value: the purpose, the output, and a running number from 1 for repeated storage.
pub(super) type Key<'d> = (Use, Output<'d>, usize);

/// The temporaries and variables created for a drawing, shared by all orders.
#[derive(Default)]
pub(super) struct Hidden<'d> {
    pub(super) temporaries: BTreeMap<Key<'d>, TempId>,
    pub(super) variables: BTreeMap<Key<'d>, VarId>,
    /// Whether a value may have changed between two reads. Values are then stored when they are first read.
    pub(super) looks_again: bool,
    /// Whether the drawing must be processed again, because something became known too late for this pass.
    pub(super) is_stale: bool,
}

/// The properties of a drawing that do not depend on the order.
pub(super) struct Sheet<'d> {
    pub(super) drawing: &'d Drawing,
    pub(super) scope: Scope,
    /// Whether it has jumps, labels or returns.
    pub(super) has_jumps: bool,
    /// Contacts with edges, and the contacts and coils after them.
    pub(super) behind_edges: BTreeSet<ElementId>,
}

/// An executed statement, the element that it belongs to, and its accesses.
pub(super) struct Executed {
    pub(super) statement: Statement,
    pub(super) owner: ElementId,
    pub(super) touched: Touched,
}

/// The progress of executing a drawing in one order.
#[derive(Default)]
pub(super) struct Progress<'d> {
    pub(super) all: Vec<Executed>,
    /// Blocks, coils and outputs that have been executed.
    pub(super) done: BTreeSet<ElementId>,
    /// The element whose statements are being emitted.
    pub(super) owner: ElementId,
    /// The execution number of that element, or of the element that needs it.
    pub(super) acting: Option<u64>,
    /// The values of outputs when they were first stored.
    pub(super) kept: BTreeMap<Output<'d>, Kept>,
    /// The results of edge detections when they were first evaluated.
    pub(super) edges: BTreeMap<Output<'d>, Kept>,
    /// For each stored value, the accesses of its expression and the number of statements executed before it.
    pub(super) stored: BTreeMap<Held, (Touched, usize)>,
    /// How often each value has been stored and each edge evaluated.
    pub(super) times: BTreeMap<(Use, Output<'d>), usize>,
    /// The value of EN with which each block was executed.
    pub(super) enables: BTreeMap<ElementId, Worth>,
    /// The values passed to VAR_IN_OUT pins, by block and pin name in lower case.
    pub(super) given_back: BTreeMap<(ElementId, String), Worth>,
    /// The number of values for which controllers differ.
    pub(super) eithers: usize,
    /// Whether something was done as only generators do it, such as joining a coil's connections by AND or ignoring a
    /// negation.
    pub(super) differs_in_itself: bool,
}

/// The state of the expression that is being built.
#[derive(Default)]
pub(super) struct Term<'d> {
    /// The values of outputs that the expression has already read.
    pub(super) looked_at: BTreeMap<Output<'d>, Worth>,
    /// Whether a value that the expression reads twice is computed only once.
    pub(super) is_written_once: bool,
    /// The number of elements visited for the expression.
    pub(super) visits: usize,
}

/// Executes a drawing in one order and emits its statements.
pub(super) struct Drawer<'r, 'p, 'd> {
    pub(super) resolver: &'r mut Resolver<'p>,
    pub(super) labels: &'r mut Labels,
    pub(super) sheet: &'r Sheet<'d>,
    pub(super) hidden: &'r mut Hidden<'d>,
    pub(super) loops: Loops,
    /// Whether coils in the middle of a rung are executed in their own place in the order, as in generated text.
    pub(super) is_generated: bool,
    pub(super) progress: Progress<'d>,
    pub(super) term: Term<'d>,
    /// The elements on the current evaluation path.
    pub(super) open: BTreeSet<ElementId>,
    /// The length of the current evaluation path.
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
        let behind_edges = behind_edges(drawing);
        Ok(Sheet { drawing, scope, has_jumps, behind_edges })
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

    /// Whether the negation of a variable element is applied; generators ignore it.
    pub(super) fn obeys(&mut self, is_negated: bool) -> bool {
        self.progress.differs_in_itself |= is_negated && self.is_generated;
        is_negated && !self.is_generated
    }

    /// The edge to detect. Generators ignore an edge that is combined with a negation, set or reset (`has_sign`).
    pub(super) fn edge_beside(&mut self, edge: Option<Edge>, has_sign: bool) -> Option<Edge> {
        let is_left = edge.is_some() && has_sign && self.is_generated;
        self.progress.differs_in_itself |= is_left;
        edge.filter(|_| !is_left)
    }

    /// Whether expressions have the form that generators write. Other controllers use stored values.
    pub(super) fn is_written(&self) -> bool {
        let is_text = self.is_generated || self.sheet.drawing.goal.is_some();
        !self.sheet.drawing.is_executed_as_drawn && (is_text || !self.hidden.looks_again)
    }

    /// The execution number used to decide whether the elements that this one needs have run. For outputs in generated
    /// text `None`: what they need runs before them, whatever its number.
    pub(super) fn number(&self, one: &Element) -> Option<u64> {
        one.order.filter(|_| !self.is_generated || one.block().is_some())
    }

    /// Emits a statement of the current element.
    pub(super) fn add(&mut self, line: u32, kind: StatementKind, text: String) {
        let statement = Statement { kind, text: text.into(), line };
        let statement = self.resolver.statement_after(0, statement);
        let touched = self.resolver.touched(std::slice::from_ref(&statement));
        self.progress.all.push(Executed { statement, owner: self.progress.owner, touched });
    }

    /// Emits a statement that writes a variable, executed only if the condition is true.
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

    /// The key of the next value stored for this purpose and output.
    pub(super) fn next_key(&mut self, of: Use, output: Output<'d>) -> Key<'d> {
        let times = self.progress.times.entry((of, output)).or_insert(0);
        *times += 1;
        (of, output, *times)
    }

    /// The temporary with this key, created if necessary.
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

    /// The internal variable with this key, declared if necessary.
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

    /// Records the variable that the condition of this drawing reads for an element's output.
    pub(super) fn note_for_condition(&mut self, id: VarId, one: &Element, output: Option<&str>) {
        if let (Some(goal), Some(unit)) = (&self.sheet.drawing.goal, self.sheet.scope.unit) {
            let (part, local_id) = (goal.part.clone(), one.local_id.clone());
            let held = HeldOutput { part, local_id, output: output.map(str::to_owned) };
            self.resolver.held.insert((unit, held), id);
        }
    }

    /// The name of a stored value, for messages.
    pub(super) fn display_name(&self, (of, (id, output), times): Key<'d>) -> String {
        let local_id = &self.element(id).local_id;
        let name = match of {
            Use::Way => format!("the value from localId {local_id}"),
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

/// The statement, or its fault as a statement.
pub(super) fn resolved(kind: Result<StatementKind, Fault>) -> StatementKind {
    kind.unwrap_or_else(|fault| StatementKind::Fault(Box::new(fault)))
}

/// Adds the element to the fault of an undeclared name; other faults stay.
pub(super) fn at_element(one: &Element, fault: Fault) -> Fault {
    match fault.code {
        Code::UnknownName => fault.within(&one.called()),
        _ => fault,
    }
}
