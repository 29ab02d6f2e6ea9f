//! In which orders tools carry out the elements of a drawing, and whether these differ in what they do.

use super::pins::is_instance;
use super::places::Places;
use super::rank::{order, position, rank};
use super::{Graph, is_called};
use crate::ast::{Expr, Kind, Statement, visit};
use crate::xml::node::{child, children, inputs, sources};
use petgraph::algo::kosaraju_scc;
use petgraph::graphmap::DiGraphMap;
use roxmltree::Node;
use std::collections::{BTreeMap, BTreeSet};

/// An order: what it is called, the elements in it, and which of the instances that feed each other begin.
pub(super) struct Order<'a> {
    pub(super) what: &'static str,
    pub(super) acting: Vec<&'a str>,
    pub(super) loops: Loops<'a>,
    /// Whether coils in the midst of a way are carried out in their own places.
    pub(super) generated: bool,
}

/// Elements that lead back to themselves by way of blocks.
#[derive(Clone, Default)]
pub(super) struct Loops<'a> {
    /// The number of the loop in which an element stands, and its place in it.
    places: BTreeMap<&'a str, (usize, usize)>,
    /// The instances of each loop, in their places; its functions, where it has no instance.
    instances: BTreeMap<usize, Vec<&'a str>>,
    /// Whether loops begin with their first instance, not with the one that is asked for.
    begin_first: bool,
}

impl<'a> Loops<'a> {
    /// Whether an element stands in a loop.
    pub(super) fn holds(&self, id: &str) -> bool {
        self.places.contains_key(id)
    }

    /// Whether one of the blocks that a loop may begin with comes behind one of these in it.
    pub(super) fn is_behind(&self, id: &str, open: &BTreeSet<&str>) -> bool {
        let Some((own, place)) = self.places.get(id).filter(|_| self.begin_first) else {
            return false;
        };
        if !self.instances.get(own).is_some_and(|all| all.contains(&id)) {
            return false;
        }
        let is_instance = |id: &&&str| self.instances.get(own).is_some_and(|all| all.contains(*id));
        let others = open.iter().filter(is_instance).filter_map(|id| self.places.get(id));
        others.into_iter().any(|(_, before)| before < place)
    }

    /// The instances that are carried out before this element is, where its loop has not been begun: those that come before
    /// it, or the first one.
    pub(super) fn first(
        &self,
        id: &str,
        open: &BTreeSet<&str>,
        done: &BTreeSet<&str>,
    ) -> Vec<&'a str> {
        let Some((own, place)) = self.places.get(id).filter(|_| self.begin_first) else {
            return Vec::new();
        };
        let Some(instances) = self.instances.get(own) else { return Vec::new() };
        let is_open = open.iter().filter_map(|open| self.places.get(open)).any(|(at, _)| at == own);
        if is_open || instances.iter().any(|one| done.contains(one)) {
            return Vec::new();
        }
        let before = instances.iter().copied().filter(|one| self.places[one].1 < *place);
        let before: Vec<&str> = before.collect();
        match before.is_empty() && !instances.contains(&id) {
            true => instances.first().copied().into_iter().collect(),
            false => before,
        }
    }
}

/// Where an element comes: its number, its kind, its height, how far to the right, its place in the file.
type Rank = (u64, i64, i64, i64, usize);

/// How far up or down elements stand in one row, for older generators.
const ROW_HEIGHT: i64 = 100;

impl<'a> Graph<'a, '_> {
    /// The orders that tools keep; the first one is the standard's.
    pub(super) fn orders(&self) -> Vec<Order<'a>> {
        let all = || self.nodes.iter().map(|(&id, &node)| (id, node));
        let sorted = |rank: &dyn Fn(Node<'_, '_>) -> Rank| {
            let mut acting: Vec<_> = all().map(|(id, node)| (rank(node), id)).collect();
            acting.sort();
            acting.into_iter().map(|(_, id)| id).collect::<Vec<&'a str>>()
        };
        let standard = sorted(&|node| {
            let (number, y, x, at) = rank(node, node.range().start);
            (number, 0, y, x, at)
        });
        let loops = self.loops_among(&standard);
        let mut orders = Vec::new();
        let by_demand = Loops { begin_first: false, ..loops.clone() };
        if !loops.places.is_empty() {
            let what = "instances that feed each other begin with the one that is asked for first";
            orders.push(Order {
                what,
                acting: standard.clone(),
                loops: by_demand.clone(),
                generated: false,
            });
        }
        orders.insert(0, Order { what: "", acting: standard, loops, generated: false });
        // Generators know no jumps, and CODESYS and TwinCAT carry out their drawings themselves.
        if self.jumps || self.text.is_codesys {
            return orders;
        }
        let kind = |node: Node<'_, '_>| match node.tag_name().name() {
            "block" => 1,
            "connector" => 2,
            _ => 0,
        };
        let number = |node: Node<'_, '_>| order(node).unwrap_or(u64::MAX);
        let rows = self.rows();
        let in_rows = |node: Node<'_, '_>| {
            let (y, x) = position(node);
            (rows.get(&y).copied().unwrap_or(y), x)
        };
        let mut add = |what, acting| {
            orders.push(Order { what, acting, loops: by_demand.clone(), generated: true });
        };
        add(
            "coils and outputs come as the file has them, and blocks behind them",
            sorted(&|node| (number(node), kind(node), 0, 0, node.range().start)),
        );
        add(
            "coils and outputs come from left to right in rows, and blocks behind them",
            sorted(&|node| {
                let (row, x) = in_rows(node);
                (number(node), kind(node), row, x, node.range().start)
            }),
        );
        add(
            "coils, outputs and blocks come from left to right in rows",
            sorted(&|node| {
                let (row, x) = in_rows(node);
                (number(node), 0, row, x, node.range().start)
            }),
        );
        orders
    }

    /// In which row elements at each height stand.
    fn rows(&self) -> BTreeMap<i64, i64> {
        let heights: BTreeSet<i64> = self.nodes.values().map(|node| position(*node).0).collect();
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
    fn loops_among(&self, acting: &[&'a str]) -> Loops<'a> {
        let mut ways: DiGraphMap<&str, ()> = DiGraphMap::new();
        for (&id, &node) in &self.nodes {
            let pins = ["inputVariables", "inOutVariables"].into_iter();
            let pins = pins.filter_map(|list| child(node, list));
            let pins = pins.flat_map(|list| children(list, "variable"));
            let points = pins.flat_map(|pin| children(pin, "connectionPointIn"));
            let mut from: Vec<&str> = points.flat_map(sources).map(|(from, _)| from).collect();
            from.extend(inputs(node).into_iter().map(|(from, _)| from));
            if is_called(node, "continuation") {
                let name = node.attribute("name");
                let connectors = self.nodes.iter().filter(|(_, one)| {
                    is_called(**one, "connector") && one.attribute("name") == name
                });
                from.extend(connectors.map(|(&id, _)| id));
            }
            for from in from {
                ways.add_edge(from, id, ());
            }
        }
        let place: BTreeMap<&str, usize> = acting.iter().copied().zip(0..).collect();
        let mut loops = Loops { begin_first: true, ..Loops::default() };
        for (number, loop_) in kosaraju_scc(&ways).into_iter().enumerate() {
            let found = loop_.into_iter().filter_map(|id| self.nodes.get_key_value(id));
            let mut own: Vec<(&'a str, Node<'_, '_>)> =
                found.map(|(&id, &node)| (id, node)).collect();
            own.sort_by_key(|(id, _)| place[id]);
            let leads_back = own.len() > 1 || own.iter().all(|(id, _)| ways.contains_edge(id, id));
            let mut instances: Vec<&str> =
                own.iter().filter(|(_, node)| is_instance(*node)).map(|(id, _)| *id).collect();
            if instances.is_empty() {
                let blocks = own.iter().filter(|(_, node)| is_called(*node, "block"));
                instances = blocks.map(|(id, _)| *id).collect();
            }
            if leads_back && !instances.is_empty() {
                loops.places.extend(own.into_iter().map(|(id, _)| (id, (number, place[id]))));
                loops.instances.insert(number, instances);
            }
        }
        loops
    }
}

/// What a variable is called that stands for all that is shared with other units.
const SHARED: &str = "";

/// What a variable is called that stands for all there are: what is jumped over hangs on where the jump stands.
const ALL: &str = "*";

/// What a statement reads and writes.
#[derive(Default)]
struct Touched {
    reads: BTreeSet<String>,
    writes: BTreeSet<String>,
}

/// A drawing as one order carries it out.
pub(super) struct Carried<'a> {
    pub(super) statements: Vec<Statement>,
    /// Whether ways to a coil were joined by AND: no order alone makes that.
    pub(super) joins_all: bool,
    /// What each statement touches, and where it stands: by its element and its number among that one's.
    touched: BTreeMap<(&'a str, usize), (usize, Touched)>,
}

impl<'a> Carried<'a> {
    pub(super) fn new(
        statements: Vec<Statement>,
        owners: Vec<&'a str>,
        foreign: &[usize],
        handed: &[(usize, String)],
        places: &Places,
    ) -> Carried<'a> {
        let mut counts: BTreeMap<&str, usize> = BTreeMap::new();
        let mut touched = BTreeMap::new();
        for (at, (owner, statement)) in owners.iter().zip(&statements).enumerate() {
            let count = counts.entry(owner).or_insert(0);
            let mut own = Touched::default();
            own.add(statement, places);
            if foreign.contains(&at) {
                own.writes.insert(SHARED.to_owned());
            }
            let handed = handed.iter().filter(|(call, _)| *call == at);
            own.writes.extend(handed.map(|(_, name)| name.clone()));
            touched.insert((*owner, *count), (at, own));
            *count += 1;
        }
        Carried { statements, joins_all: false, touched }
    }

    /// Whether two orders may do different things: two statements come the other way round, and one writes what the other one
    /// touches.
    pub(super) fn differs(&self, other: &Carried<'a>, places: &Places) -> bool {
        if self.joins_all != other.joins_all || self.touched.keys().ne(other.touched.keys()) {
            return true;
        }
        // By variable, the statements that touch it: their places in both orders, and whether they write it.
        let mut by_name: BTreeMap<String, Vec<(usize, usize, bool)>> = BTreeMap::new();
        for ((here, one), (there, also)) in self.touched.values().zip(other.touched.values()) {
            let mut names = BTreeMap::from([(ALL.to_owned(), false)]);
            for (touched, writes) in [
                (&one.reads, false),
                (&also.reads, false),
                (&one.writes, true),
                (&also.writes, true),
            ] {
                for name in touched {
                    if name != SHARED && name != ALL && places.is_shared(name) {
                        names.entry(SHARED.to_owned()).or_insert(false);
                    }
                    *names.entry(places.one_name(name)).or_insert(false) |= writes;
                }
            }
            for (name, writes) in names {
                by_name.entry(name).or_default().push((*here, *there, writes));
            }
        }
        by_name.into_values().any(|touching| {
            let writers = || touching.iter().filter(|(.., writes)| *writes);
            writers().any(|(here, there, _)| {
                touching.iter().any(|(own, also, _)| (own < here) != (also < there))
            })
        })
    }
}

impl Touched {
    fn add(&mut self, statement: &Statement, places: &Places) {
        visit(std::slice::from_ref(statement), &mut |one| {
            let mut reads = |value: &Expr| self.reads.extend(places.read(value));
            let target = match &one.kind {
                Kind::Assign(target, value) | Kind::Latch(target, _, value) => {
                    reads(value);
                    target
                }
                Kind::Call(target, given) | Kind::CallIf(_, target, given) => {
                    if let Kind::CallIf(enable, ..) = &one.kind {
                        reads(enable);
                    }
                    given.iter().for_each(|one| reads(&one.value));
                    target
                }
                Kind::If(arms, _) => return arms.iter().for_each(|(holds, _)| reads(holds)),
                _ => {
                    self.writes.insert(ALL.to_owned());
                    return;
                }
            };
            reads(&Expr::Variable(target.clone()));
            if !target.first.starts_with('~') {
                self.writes.extend(places.names(target).map(str::to_owned));
            }
        });
    }
}
