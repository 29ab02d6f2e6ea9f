//! Random charts of nested selections, parallels and loops, with actions of all qualifiers.

use rand_pcg::Pcg64Mcg;
use rand_pcg::rand_core::Rng;
use scanbound::iec::ast::{Expr, Literal, Operator, Path};
use scanbound::iec::chart::{Block, Chart, Qualifier, Step, Target, Transition};
use scanbound::iec::{Body, Pou, PouKind, Section, TypeRef, Variable};

/// Random numbers from a seed.
pub struct Dice(Pcg64Mcg);

impl Dice {
    pub fn new(seed: u64) -> Dice {
        Dice(Pcg64Mcg::new(u128::from(seed) << 1 | 0xcafe_f00d_d15e_a5e5_0000_0000_0000_0000))
    }

    /// A number below this one.
    pub fn below(&mut self, limit: u64) -> u64 {
        (self.0.next_u64() >> 11) % limit
    }

    pub fn one_in(&mut self, many: u64) -> bool {
        self.below(many) == 0
    }
}

/// The number of inputs that conditions read.
pub const INPUTS: u64 = 3;
const MS: i64 = 1_000_000;

struct Maker<'d> {
    dice: &'d mut Dice,
    chart: Chart,
}

impl Maker<'_> {
    fn step(&mut self, initial: bool) -> usize {
        let name = format!("s{}", self.chart.steps.len());
        self.chart.steps.push(Step::new(name, initial, 1));
        self.chart.steps.len() - 1
    }

    fn condition(&mut self) -> Expr {
        let input = Expr::name(format!("i{}", self.dice.below(INPUTS)));
        match self.dice.below(6) {
            0 => input.not(),
            1 => {
                let step = self.dice.below(self.chart.steps.len() as u64) as usize;
                let time =
                    Expr::Variable(Path::name(self.chart.steps[step].name.clone()).with("T"));
                let limit = Expr::Literal(Literal::Time(10 * MS));
                input.and(
                    Expr::Binary(Operator::GreaterOrEqual, Box::new(time), Box::new(limit)).not(),
                )
            }
            2 => Expr::bool(true),
            _ => input,
        }
    }

    fn join(&mut self, from: Vec<usize>, to: Vec<usize>) {
        let condition = self.condition();
        let one = Transition { name: None, from, to, condition, priority: None, line: 1, id: None };
        self.chart.transitions.push(one);
    }

    /// Draws steps from one on; returns the first and the last ones.
    fn part(&mut self, depth: u64) -> (usize, usize) {
        let first = self.step(false);
        let mut last = first;
        for _ in 0..1 + self.dice.below(2) {
            last = match if depth == 0 { 0 } else { self.dice.below(4) } {
                1 => {
                    let end = self.step(false);
                    for _ in 0..2 {
                        let (begin, stop) = self.part(depth - 1);
                        self.join(vec![last], vec![begin]);
                        self.join(vec![stop], vec![end]);
                    }
                    end
                }
                2 => {
                    let (one, two) = (self.part(depth - 1), self.part(depth - 1));
                    self.join(vec![last], vec![one.0, two.0]);
                    let end = self.step(false);
                    self.join(vec![one.1, two.1], vec![end]);
                    end
                }
                3 => {
                    let (begin, stop) = self.part(depth - 1);
                    self.join(vec![last], vec![begin]);
                    self.join(vec![stop], vec![last]);
                    let end = self.step(false);
                    self.join(vec![stop], vec![end]);
                    end
                }
                _ => {
                    let end = self.step(false);
                    self.join(vec![last], vec![end]);
                    end
                }
            };
        }
        (first, last)
    }
}

/// A random chart that returns to its initial step. Its blocks control some of the actions m0, m1 ...; their qualifiers
/// are from these.
pub fn chart(dice: &mut Dice, depth: u64, actions: u64, qualifiers: &[Qualifier]) -> Chart {
    let mut maker = Maker { dice, chart: Chart { line: 1, ..Chart::default() } };
    let start = maker.step(true);
    let (first, last) = maker.part(depth);
    maker.join(vec![start], vec![first]);
    maker.join(vec![last], vec![start]);
    let Maker { dice, mut chart } = maker;
    for action in 0..actions {
        let qualifier = qualifiers[dice.below(qualifiers.len() as u64) as usize];
        let time = i64::try_from(dice.below(4)).expect("small") * 10 * MS + 5 * MS;
        let mut add = |dice: &mut Dice, qualifier: Qualifier| {
            let step = dice.below(chart.steps.len() as u64) as usize;
            let time = qualifier.is_timed().then_some(Expr::Literal(Literal::Time(time)));
            let target = Target::Path(Path::name(format!("m{action}")));
            chart.steps[step].blocks.push(Block {
                qualifier,
                is_qualified: true,
                time,
                target,
                line: 1,
            });
        };
        for _ in 0..1 + dice.below(2) {
            add(dice, qualifier);
        }
        if qualifier.is_stored() {
            for _ in 0..1 + dice.below(2) {
                add(dice, Qualifier::R);
            }
        }
        if dice.one_in(3) {
            let other = Qualifier::ALL[dice.below(11) as usize];
            add(dice, other);
        }
    }
    chart
}

/// Whether all controllers execute its actions in the same way, except for the final scan and for blocks that override
/// each other, which only lengthen a scan. They differ if several steps use pulses or times of the same action, and in
/// R and the times of stored actions.
pub fn is_done_alike(chart: &Chart) -> bool {
    use Qualifier as Q;
    chart.actions().iter().all(|action| {
        let feeds = chart.inputs_of(action);
        let has = |kinds: &[Q]| feeds.iter().any(|feed| kinds.contains(&feed.qualifier));
        let apart = [Q::P, Q::P0, Q::P1, Q::L, Q::D];
        let is_shared =
            feeds.iter().any(|one| one.steps.len() > 1 && apart.contains(&one.qualifier));
        let held_off = has(&[Q::R]) && has(&[Q::N, Q::L, Q::D, Q::P]);
        !is_shared && !held_off && !has(&[Q::Sd, Q::Sl, Q::Ds])
    })
}

/// A program around a chart: its inputs and its actions are Boolean variables.
pub fn program(chart: Chart, actions: u64) -> Pou {
    let variable = |name: String, at: Option<String>| Variable {
        name,
        section: Section::Local,
        of: TypeRef::Named("BOOL".to_owned()),
        initial: None,
        at,
        constant: false,
        retain: false,
        is_internal: false,
        has_edge: false,
        line: 1,
    };
    let inputs = (0..INPUTS).map(|n| variable(format!("i{n}"), Some(format!("%IX0.{n}"))));
    let outputs = (0..actions).map(|n| variable(format!("m{n}"), None));
    Pou {
        name: "main".to_owned(),
        kind: PouKind::Program,
        extends: None,
        implements: Vec::new(),
        result: None,
        variables: inputs.chain(outputs).collect(),
        body: Body::Chart(Box::new(chart)),
        actions: Vec::new(),
        transitions: Vec::new(),
        methods: Vec::new(),
        is_private: false,
        file: 0,
        line: 1,
    }
}
