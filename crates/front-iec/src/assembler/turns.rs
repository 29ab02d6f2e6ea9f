//! Execution order of the actions of a chart. The standard does not define it, and controllers differ. An action is
//! lowered once for each possible order if it writes what another one reads or writes, or the reverse; one run uses one
//! order. All other actions are lowered once.

use super::memory::all;
use super::{Assembler, OpenEnd, Turn};
use scanbound_base::facts::ActionOrder;
use scanbound_iec::chart::Chart;
use scanbound_iec_tree::charts::Orders;
use scanbound_ir::meaning::ChoiceKind;
use scanbound_ir::{Cell, Logic, Region, RegionSet, Step, Write, flow};
use std::collections::BTreeSet;
use std::ops::{DerefMut, Range};

/// One pass over all actions in one possible order.
pub(crate) struct Round {
    /// The actions in this order, by number.
    order: Vec<usize>,
    /// Some(true): only the actions that have ended run in this pass; Some(false): only the others. None: all.
    ended: Option<bool>,
    /// The reading (kind of controller) to which this pass belongs. None if it applies to all.
    of: Option<ActionOrder>,
    /// Of two alphabetical orders, whether this is the one with `_` before letters and digits. None if they are equal,
    /// or for another order.
    sign_first: Option<bool>,
}

/// The lasting cells that some instructions read and write.
#[derive(Default)]
struct Footprint {
    reads: Cells,
    writes: Cells,
    /// Whether they may end the chart, or have effects that are not known.
    ends: bool,
}

impl Footprint {
    /// Whether the order of two groups of instructions matters.
    fn meets(&self, other: &Footprint) -> bool {
        self.ends
            || other.ends
            || self.writes.meet(&other.writes)
            || self.writes.meet(&other.reads)
            || self.reads.meet(&other.writes)
    }
}

/// Sorted, disjoint ranges of cells.
#[derive(Default)]
struct Cells(Vec<(Cell, u32)>);

impl Cells {
    fn new(regions: BTreeSet<(Cell, u32)>) -> Cells {
        let mut found: Vec<(Cell, u32)> = Vec::new();
        for (first, count) in regions {
            match found.last_mut() {
                Some((own, so_far)) if own.area == first.area && own.plus(*so_far) >= first => {
                    *so_far = (*so_far).max(first.index - own.index + count);
                }
                _ => found.push((first, count)),
            }
        }
        Cells(found)
    }

    fn meet(&self, other: &Cells) -> bool {
        let (mut ones, mut others) = (self.0.iter().peekable(), other.0.iter().peekable());
        while let (Some(&&(one, count)), Some(&&(two, more))) = (ones.peek(), others.peek()) {
            if one.plus(count) <= two {
                ones.next();
            } else if two.plus(more) <= one {
                others.next();
            } else {
                return true;
            }
        }
        false
    }
}

/// The possible passes over the actions of a chart. `stated` is the order that the user states, which leaves one order
/// if it is clear.
pub(crate) fn rounds(orders: &Orders, stated: Option<ActionOrder>) -> Vec<Round> {
    let Orders { declared, declared_is_clear, alphabetical } = orders;
    let stated = stated.filter(|one| *one != ActionOrder::Declared || *declared_is_clear);
    let named: Vec<usize> = (0..declared.len()).collect();
    let all = ActionOrder::ALL.into_iter().filter(|&one| stated.is_none_or(|own| own == one));
    let of = |one: ActionOrder| stated.is_none().then_some(one);
    let whole = |order: &[usize], one| Round {
        order: order.to_vec(),
        ended: None,
        of: of(one),
        sign_first: None,
    };
    all.flat_map(|one| match one {
        ActionOrder::Named => vec![whole(&named, one)],
        ActionOrder::Declared => vec![whole(declared, one)],
        ActionOrder::Alphabetical => {
            let differ = alphabetical[0] != alphabetical[1];
            let orders = alphabetical.iter().zip([false, true]).take(if differ { 2 } else { 1 });
            let parts = orders.flat_map(|(order, sign_first)| {
                let sign_first = differ.then_some(sign_first);
                [true, false].map(|ended| Round {
                    ended: Some(ended),
                    sign_first,
                    ..whole(order, one)
                })
            });
            parts.collect()
        }
    })
    .collect()
}

/// The possible passes over the hooks of `count` steps: the chart's own order and, where two steps may be active at
/// once, a second pass with which any two can run the other way round. `may_be_any`: whether any steps may be active,
/// whatever the chart says.
pub(crate) fn of_steps(chart: &Chart, count: usize, may_be_any: bool) -> Vec<Round> {
    let round =
        |of| Round { order: (0..count).collect(), ended: None, of: Some(of), sign_first: None };
    match is_sequence(chart) && !may_be_any {
        true => vec![round(ActionOrder::Named)],
        false => vec![round(ActionOrder::Named), round(ActionOrder::Declared)],
    }
}

/// Whether exactly one step is always active: there is one initial step, and each transition leads from one step to one
/// step.
fn is_sequence(chart: &Chart) -> bool {
    chart.steps.iter().filter(|step| step.initial).count() == 1
        && chart.transitions.iter().all(|one| one.from.len() == 1 && one.to.len() == 1)
}

/// Lowers actions in the orders of `rounds`; a free choice selects the order. `ended`: for each action, whether it has
/// ended. `memory`: that of the chart's instance. `carry_out` lowers one action.
pub(crate) fn in_turns<H: DerefMut<Target = Assembler>>(
    host: &mut H,
    rounds: &[Round],
    ended: &[Logic],
    memory: Vec<Region>,
    carry_out: &mut dyn FnMut(&mut H, usize),
) {
    if let ([_], _) | (_, [] | [_]) = (rounds, ended) {
        for &at in rounds.first().map_or(&[][..], |round| &round.order) {
            carry_out(host, at);
        }
        return;
    }
    let differ = rounds.iter().any(|round| round.sign_first.is_some());
    let ways: Vec<(Logic, Logic, Option<Logic>)> = ended
        .iter()
        .map(|_| {
            let other =
                host.differs("actions do not run in the order in which the chart names them");
            let declared = host.differs("actions run in the order of their declarations");
            let [other, declared] = [other, declared].map(|bit| host.keep_bit(bit));
            let sign_first = differ.then(|| {
                let first =
                    host.differs("the alphabetical order has `_` before letters and digits");
                host.keep_bit(first)
            });
            (other, declared, sign_first)
        })
        .collect();
    let mut turns: Vec<Turn> =
        ended.iter().map(|_| Turn { says: Vec::new(), copies: Vec::new() }).collect();
    let mut blocks = vec![0; ended.len()];
    for (number, round) in rounds.iter().enumerate() {
        for &at in &round.order {
            let (other, declared, sign_first) = ways[at].clone();
            let of = match round.of {
                None => Logic::Const(true),
                Some(ActionOrder::Named) => other.not(),
                Some(ActionOrder::Declared) if rounds.len() == 2 => other,
                Some(ActionOrder::Declared) => all([other, declared]),
                Some(ActionOrder::Alphabetical) => all([other, declared.not()]),
            };
            let sign = match (round.sign_first, sign_first) {
                (Some(true), Some(first)) => first,
                (Some(false), Some(first)) => first.not(),
                _ => Logic::Const(true),
            };
            let part = match round.ended {
                None => Logic::Const(true),
                Some(true) => ended[at].clone(),
                Some(false) => ended[at].clone().not(),
            };
            let (here, says) = host.unless_settled(all([of, sign, part]));
            // A copy belongs to the same block as the first one.
            let after = host.program().blocks;
            if number > 0 {
                host.program().blocks = blocks[at];
            }
            blocks[at] = host.program().blocks;
            let from = host.builder.next();
            let skip = host.jump(here.not(), None);
            carry_out(host, at);
            host.land(skip);
            host.landing();
            if number > 0 {
                host.program().blocks = after;
            }
            turns[at].says.push(says);
            turns[at].copies.push(from..host.builder.next());
        }
    }
    host.open_ends.push(OpenEnd::Turns { actions: turns, memory });
}

impl Assembler {
    /// Keeps only the first copy of each action that meets no other action, since its order does not matter, and clears
    /// the others.
    pub(crate) fn settle_turns(&mut self, turns: &[Turn], own: &RegionSet) {
        let prints: Vec<Footprint> =
            turns.iter().map(|turn| self.footprint(&turn.copies[0], own)).collect();
        for (at, turn) in turns.iter().enumerate() {
            let others = prints.iter().enumerate().filter(|(other, _)| *other != at);
            if { others }.any(|(_, other)| prints[at].meets(other)) {
                continue;
            }
            self.set_to(turn.says[0], true);
            for copy in &turn.copies[1..] {
                let program = self.program();
                program.approximations.retain(|one| !copy.contains(&one.instruction));
                for instruction in &mut program.instructions[copy.clone()] {
                    instruction.timing = None;
                    instruction.effects.clear();
                    instruction.step = Step::Nothing;
                }
            }
        }
    }

    /// The footprint of a range of instructions and of all that they call. Temporary cells and the regions in `own`
    /// (variables that are initialised at every call) are left out.
    fn footprint(&self, range: &Range<usize>, own: &RegionSet) -> Footprint {
        let program = &self.builder.program;
        let ends = program.instructions[range.clone()].iter().any(|one| one.step == Step::Return);
        let (mut reads, mut writes) = (BTreeSet::new(), BTreeSet::new());
        let mut seen: BTreeSet<usize> = BTreeSet::new();
        let mut open = vec![range.clone()];
        while let Some(part) = open.pop() {
            for at in part {
                let instruction = &program.instructions[at];
                if let Step::Call { target, .. } = instruction.step
                    && seen.insert(target)
                    && let Some(end) = flow::routine_end(program, target)
                {
                    open.push(target..end + 1);
                }
                writes.extend(flow::written(program, at));
                instruction.each_read(&mut |source| reads.extend(source.region()));
                for effect in &instruction.effects {
                    let Write::Havoc(_, choice) = &effect.write else { continue };
                    if let Some(ChoiceKind::Exact(meaning)) = program.kinds.get(choice) {
                        meaning.each_read(&mut |region| _ = reads.insert(region));
                    }
                }
            }
        }
        let lasting = |regions: BTreeSet<Region>| {
            let stretch = |region: Region| match region {
                Region::Range { first, count } => {
                    let lasts = !Assembler::is_between(first) && !own.overlaps(region);
                    lasts.then_some((first, count))
                }
                Region::Area(_) | Region::Everything => None,
            };
            Cells::new(regions.into_iter().filter_map(stretch).collect())
        };
        let is_whole = |region: &Region| !matches!(region, Region::Range { .. });
        let ends = ends || reads.iter().chain(&writes).any(is_whole);
        Footprint { reads: lasting(reads), writes: lasting(writes), ends }
    }
}
