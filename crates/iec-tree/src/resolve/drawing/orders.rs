//! In which orders tools execute the elements of a drawing.

use super::loops::Loops;
use super::state::Sheet;
use petgraph::algo::kosaraju_scc;
use petgraph::graphmap::DiGraphMap;
use scanbound_iec::drawing::{Element, ElementId, ElementKind};
use std::collections::{BTreeMap, BTreeSet};

/// An order: what it is called, the elements in it, and which of the instances that feed each other begin.
pub(super) struct Order {
    pub(super) what: &'static str,
    pub(super) acting: Vec<ElementId>,
    pub(super) loops: Loops,
    /// Whether coils in the midst of a way are executed in their own places.
    pub(super) is_generated: bool,
}

/// Where an element comes: its number, its kind, how far down, how far to the right.
type Rank = (u64, i64, i64, i64);

/// How far up or down elements stand in one row, for older generators.
const ROW_HEIGHT: i64 = 100;

impl Sheet<'_> {
    /// The orders that tools keep; the first one is the standard's: by the numbers of execution, else from top to
    /// bottom and from left to right, else as the file has them.
    pub(super) fn orders(&self) -> Vec<Order> {
        let sorted = |rank: &dyn Fn(&Element) -> Rank| {
            let mut acting: Vec<ElementId> = self.drawing.all().map(|(id, _)| id).collect();
            acting.sort_by_key(|&id| (rank(self.drawing.element(id)), id));
            acting
        };
        let number = |one: &Element| one.order.unwrap_or(u64::MAX);
        let standard = sorted(&|one| (number(one), 0, one.position.0, one.position.1));
        let loops = self.loops_among(&standard);
        let by_demand = Loops { begin_first: false, ..loops.clone() };
        let has_loops = !loops.places.is_empty();
        let acting = standard.clone();
        let mut orders = vec![Order { what: "", acting, loops, is_generated: false }];
        let mut add = |what, acting, is_generated| {
            orders.push(Order { what, acting, loops: by_demand.clone(), is_generated });
        };
        if has_loops {
            let what = "instances that feed each other begin with the one that is asked for first";
            add(what, standard, false);
        }
        // Generators know no jumps, and CODESYS and TwinCAT execute their drawings themselves.
        if self.has_jumps || self.drawing.is_executed_as_drawn {
            return orders;
        }
        let kind = |one: &Element| match one.kind {
            ElementKind::Block(_) => 1,
            ElementKind::Connector => 2,
            _ => 0,
        };
        let rows = self.rows();
        let row = |one: &Element| rows.get(&one.position.0).copied().unwrap_or(one.position.0);
        add(
            "coils and outputs come as the file has them, and blocks behind them",
            sorted(&|one| (number(one), kind(one), 0, 0)),
            true,
        );
        add(
            "coils and outputs come from left to right in rows, and blocks behind them",
            sorted(&|one| (number(one), kind(one), row(one), one.position.1)),
            true,
        );
        add(
            "coils, outputs and blocks come from left to right in rows",
            sorted(&|one| (number(one), 0, row(one), one.position.1)),
            true,
        );
        orders
    }

    /// In which row elements at each height stand.
    fn rows(&self) -> BTreeMap<i64, i64> {
        let heights: BTreeSet<i64> =
            self.drawing.elements.iter().map(|one| one.position.0).collect();
        let mut rows = BTreeMap::new();
        let mut first = None;
        for height in heights {
            let row = first.filter(|row| height - row < ROW_HEIGHT).unwrap_or(height);
            first = Some(row);
            rows.insert(height, row);
        }
        rows
    }

    /// Elements that lead back to themselves, with their places in this order.
    fn loops_among(&self, acting: &[ElementId]) -> Loops {
        let mut ways: DiGraphMap<ElementId, ()> = DiGraphMap::new();
        for (id, one) in self.drawing.all() {
            for connection in one.sources() {
                ways.add_edge(connection.from, id, ());
            }
            if let ElementKind::Continuation(from) = one.kind {
                ways.add_edge(from, id, ());
            }
        }
        let place: BTreeMap<ElementId, usize> = acting.iter().copied().zip(0..).collect();
        let mut loops = Loops { begin_first: true, ..Loops::default() };
        for (number, mut own) in kosaraju_scc(&ways).into_iter().enumerate() {
            own.sort_by_key(|id| place[id]);
            let leads_back = own.len() > 1 || own.iter().all(|&id| ways.contains_edge(id, id));
            let of = |is: &dyn Fn(&Element) -> bool| -> Vec<ElementId> {
                own.iter().copied().filter(|&id| is(self.drawing.element(id))).collect()
            };
            let mut instances = of(&Element::is_instance);
            if instances.is_empty() {
                instances = of(&|one| one.block().is_some());
            }
            if leads_back && !instances.is_empty() {
                loops.places.extend(own.into_iter().map(|id| (id, (number, place[&id]))));
                loops.instances.insert(number, instances);
            }
        }
        loops
    }
}
