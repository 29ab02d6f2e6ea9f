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

/// How far up or down elements stand in one row, for older generators, in whole units.
const ROW_HEIGHT: i64 = 10;

/// How far down and how far to the right an element stands, in whole units, as generators read them.
fn place(one: &Element) -> (i64, i64) {
    (one.position.0 / 10, one.position.1 / 10)
}

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
        if !self.is_generated() {
            return orders;
        }
        let kind = |one: &Element| match one.kind {
            ElementKind::Block(_) => 1,
            ElementKind::Connector => 2,
            _ => 0,
        };
        // They look at the numbers of blocks and outputs alone.
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
            "coils and outputs come as the file has them, and blocks behind them",
            sorted(&|one| (number(one), kind(one), 0, 0)),
            true,
        );
        add(
            "coils and outputs come from left to right in rows, and blocks behind them",
            sorted(&by_list),
            true,
        );
        add("coils, outputs and blocks come from left to right in rows", sorted(&as_one), true);
        orders
    }

    /// Whether generators may make text of it: CODESYS and TwinCAT execute their drawings themselves.
    fn is_generated(&self) -> bool {
        !self.drawing.is_executed_as_drawn
    }

    /// The elements that generators sort by their places.
    fn placed(&self) -> impl Iterator<Item = (ElementId, &Element)> {
        self.drawing.all().filter(|(_, one)| {
            let is_numbered = one.order.is_some() && one.kind != ElementKind::Coil;
            one.acts() && !one.moves() && one.kind != ElementKind::Connector && !is_numbered
        })
    }

    /// In which row those of these elements stand that are at each height.
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

    /// Elements that may come in any order where rows are sorted by: of three heights, the outer ones stand in rows
    /// of their own, but not the one between.
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

    /// The blocks that an element asks for.
    pub(super) fn blocks_before(&self, id: ElementId) -> BTreeSet<ElementId> {
        let mut found = self.drawing.reaching(self.drawing.element(id).leading());
        found.retain(|id| self.drawing.element(*id).block().is_some());
        found
    }

    /// Elements that lead back to themselves, with their places in this order.
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
