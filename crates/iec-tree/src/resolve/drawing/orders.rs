//! The orders in which tools execute the elements of a drawing.

use super::loops::Loops;
use super::state::Sheet;
use petgraph::algo::kosaraju_scc;
use petgraph::graphmap::DiGraphMap;
use scanbound_iec::drawing::{Element, ElementId, ElementKind};
use std::collections::{BTreeMap, BTreeSet};

/// An execution order: its description for reports, the elements in order, and how feedback loops start.
pub(super) struct Order {
    pub(super) what: &'static str,
    pub(super) acting: Vec<ElementId>,
    pub(super) loops: Loops,
    /// Whether coils in the middle of a rung are executed in their own place in the order.
    pub(super) is_generated: bool,
}

/// The sort key of an element: its execution number, its kind, its vertical and its horizontal position.
type Rank = (u64, i64, i64, i64);

/// The height of a row in older generators, in whole units of the file.
const ROW_HEIGHT: i64 = 10;

/// The vertical and horizontal position of an element in whole units, as generators read it.
fn place(one: &Element) -> (i64, i64) {
    (one.position.0 / 10, one.position.1 / 10)
}

impl Sheet<'_> {
    /// The orders that tools use. The first is the standard's: by execution number, then from top to bottom and from
    /// left to right, then as in the file.
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
            let what = "feedback loops begin with the instance that is evaluated first";
            add(what, standard, false);
        }
        if !self.is_generated() {
            return orders;
        }
        let kind = |one: &Element| match one.kind {
            ElementKind::Block(_) => 1,
            ElementKind::Connector => 2,
            _ => 0,
        };
        // Generators use the execution numbers of blocks and outputs only.
        let number = |one: &Element| match one.kind {
            ElementKind::Coil | ElementKind::Connector => u64::MAX,
            _ => number(one),
        };
        let lists = [0, 1].map(|own| self.rows(&|one| kind(one) == own));
        let both = self.rows(&|_| true);
        let row = |rows: &BTreeMap<i64, i64>, one: &Element| {
            let (height, across) = place(one);
            (rows.get(&height).copied().unwrap_or(height), across)
        };
        let by_list = |one: &Element| {
            let (row, across) = row(&lists[usize::from(kind(one) == 1)], one);
            (number(one), kind(one), row, across)
        };
        let as_one = |one: &Element| {
            let (row, across) = row(&both, one);
            (number(one), 0, row, across)
        };
        add(
            "coils and outputs come in the order of the file, and blocks after them",
            sorted(&|one| (number(one), kind(one), 0, 0)),
            true,
        );
        add(
            "coils and outputs come from left to right in rows, and blocks after them",
            sorted(&by_list),
            true,
        );
        add("coils, outputs and blocks come from left to right in rows", sorted(&as_one), true);
        orders
    }

    /// Whether generators may translate it to text. CODESYS and TwinCAT execute drawings directly.
    fn is_generated(&self) -> bool {
        !self.drawing.is_executed_as_drawn
    }

    /// The elements that generators sort by position.
    fn placed(&self) -> impl Iterator<Item = (ElementId, &Element)> {
        self.drawing.all().filter(|(_, one)| {
            let is_numbered = one.order.is_some() && one.kind != ElementKind::Coil;
            one.acts() && !one.moves() && one.kind != ElementKind::Connector && !is_numbered
        })
    }

    /// The row of each vertical position among the elements for which `is_one` holds.
    fn rows(&self, is_one: &dyn Fn(&Element) -> bool) -> BTreeMap<i64, i64> {
        let own = self.placed().filter(|(_, one)| is_one(one));
        let heights: BTreeSet<i64> = own.map(|(_, one)| place(one).0).collect();
        let mut rows = BTreeMap::new();
        let mut first = None;
        for height in heights {
            let row = first.filter(|row| height - row < ROW_HEIGHT).unwrap_or(height);
            first = Some(row);
            rows.insert(height, row);
        }
        rows
    }

    /// Groups of elements whose order is ambiguous when sorted into rows: neighbours are closer than a row's height,
    /// but the group as a whole is not.
    pub(super) fn unclear_rows(&self) -> Vec<Vec<ElementId>> {
        let mut all: Vec<_> = self.placed().map(|(id, one)| (place(one).0, id)).collect();
        all.retain(|_| self.is_generated());
        all.sort();
        let near = all.chunk_by(|(one, _), (other, _)| other - one < ROW_HEIGHT);
        let is_unclear = |own: &&[(i64, ElementId)]| {
            own.first().zip(own.last()).is_some_and(|(one, other)| other.0 - one.0 >= ROW_HEIGHT)
        };
        near.filter(is_unclear).map(|own| own.iter().map(|(_, id)| *id).collect()).collect()
    }

    /// The blocks from which connections lead to this element, directly or through others.
    pub(super) fn blocks_before(&self, id: ElementId) -> BTreeSet<ElementId> {
        let mut found = self.drawing.reaching(self.drawing.element(id).leading());
        found.retain(|id| self.drawing.element(*id).block().is_some());
        found
    }

    /// The feedback loops of the drawing, with positions in this order.
    fn loops_among(&self, acting: &[ElementId]) -> Loops {
        let mut ways: DiGraphMap<ElementId, ()> = DiGraphMap::new();
        for (id, one) in self.drawing.all() {
            one.leading().for_each(|from| _ = ways.add_edge(from, id, ()));
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
