//! Small random models, and their maxima by brute force.

use super::{Limits, Maximum, Method, maximum};
use scanbound_base::time::Picos;
use scanbound_ir::{AreaId, Cell};
use scanbound_model::Group;
use scanbound_model::{
    Assignment, Atom, ByUnits, Charge, Lit, Origin, ScanModel, VarId, VarKind, Variable,
};
use std::collections::BTreeSet;
use std::sync::atomic::{AtomicU64, Ordering};

/// A pseudo-random number generator with a fixed seed.
pub struct Dice(pub u64);

impl Dice {
    pub fn below(&mut self, bound: u64) -> u64 {
        self.0 =
            self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 33) % bound
    }

    pub fn one_in(&mut self, n: u64) -> bool {
        self.below(n) == 0
    }
}

/// A model under construction.
#[derive(Default)]
pub struct Builder {
    pub model: ScanModel,
}

impl Builder {
    pub fn variable(&mut self, kind: VarKind) -> VarId {
        let index = u32::try_from(self.model.variables.len()).unwrap();
        let cell = Cell { area: AreaId(0), index };
        let name = format!("V{index}");
        self.model.variables.push(Variable { kind, origin: Origin::Start(cell), name });
        VarId(index)
    }

    pub fn bit(&mut self) -> Lit {
        let variable = self.variable(VarKind::Bit);
        self.model.circuit.atom(Atom::Bit(variable))
    }

    /// The literal that the word equals this number.
    pub fn equals(&mut self, word: VarId, value: u16) -> Lit {
        let low = self.model.circuit.atom(Atom::AtLeast(word, value));
        let Some(above) = value.checked_add(1) else { return low };
        let high = self.model.circuit.atom(Atom::AtLeast(word, above));
        self.model.circuit.and(low, !high)
    }

    pub fn charge(&mut self, reached: Lit, condition: Lit, on: u64, off: u64) {
        let fires = self.model.circuit.and(reached, condition);
        let instruction = self.model.charges.len();
        let (on, off) = (Picos(on), Picos(off));
        self.model.charges.push(Charge {
            instruction,
            frames: vec![],
            reached,
            fires,
            on,
            off,
            counted: None,
        });
    }

    /// All charges with variable cost, as one group.
    pub fn group(&self) -> Group {
        let charges = &self.model.charges;
        Group {
            charges: (0..charges.len()).filter(|&c| !charges[c].is_constant()).collect(),
            variables: (0..self.model.variables.len()).map(|v| VarId(v as u32)).collect(),
            constraints: (0..self.model.constraints.len()).collect(),
        }
    }
}

/// A random model with few variables and about `charges` charges.
pub fn random(seed: u64, charges: u64) -> ScanModel {
    let mut dice = Dice(seed);
    let mut b = Builder::default();
    let mut pool: Vec<Lit> = (0..1 + dice.below(5)).map(|_| b.bit()).collect();
    for _ in 0..dice.below(3) {
        let word = b.variable(VarKind::Word);
        let step = 1 + dice.below(20) as u16;
        for _ in 0..1 + dice.below(4) {
            let value = step * dice.below(5) as u16;
            let lit = match dice.below(4) {
                0 => b.model.circuit.atom(Atom::AtLeast(word, value)),
                _ => b.equals(word, value),
            };
            pool.push(lit);
        }
        while dice.one_in(2) {
            let bit = dice.below(6) as u8;
            pool.push(b.model.circuit.atom(Atom::WordBit(word, bit)));
        }
    }
    let pick = |dice: &mut Dice, pool: &[Lit]| {
        let lit = pool[dice.below(pool.len() as u64) as usize];
        if dice.one_in(2) { !lit } else { lit }
    };
    for _ in 0..dice.below(12) {
        let (x, y, z) = (pick(&mut dice, &pool), pick(&mut dice, &pool), pick(&mut dice, &pool));
        let circuit = &mut b.model.circuit;
        pool.push(match dice.below(4) {
            0 => circuit.ite(x, y, z),
            1 => circuit.xor(x, y),
            _ => circuit.and(x, y),
        });
    }
    for _ in 0..charges {
        let reached = if dice.one_in(3) { pick(&mut dice, &pool) } else { Lit::TRUE };
        let condition = pick(&mut dice, &pool);
        let off = if dice.one_in(2) { 0 } else { dice.below(30) };
        let on = dice.below(40);
        b.charge(reached, condition, on, off);
        if dice.one_in(4) {
            let fires = b.model.charges.last().map_or(Lit::TRUE, |charge| charge.fires);
            let units: Vec<(Lit, Picos)> = (0..1 + dice.below(3))
                .map(|place| {
                    let bit = pick(&mut dice, &pool);
                    (b.model.circuit.and(fires, bit), Picos(7 << place))
                })
                .collect();
            if let Some(charge) = b.model.charges.last_mut() {
                charge.on += units.iter().map(|(_, more)| *more).sum();
                charge.counted = Some(Box::new(ByUnits { base: Picos(on), units }));
            }
        }
    }
    // Add the constraint only if it is satisfiable.
    if dice.one_in(2) {
        let (x, y) = (pick(&mut dice, &pool), pick(&mut dice, &pool));
        let lit = b.model.circuit.or(x, y);
        b.model.constraints.push(lit);
        if brute(&b.model, &b.group()).is_none() {
            b.model.constraints.pop();
        }
    }
    b.model
}

/// The maximum over all assignments that satisfy the constraints; `None` if there is no such assignment. For a word,
/// one value of each class that the circuit's atoms distinguish is tried.
pub fn brute(model: &ScanModel, group: &Group) -> Option<Picos> {
    use scanbound_model::Node;
    let values = |variable: usize| -> Vec<u16> {
        let own = |atom: &Atom| atom.variable().0 as usize == variable;
        let atoms: Vec<Atom> = model
            .circuit
            .nodes()
            .iter()
            .filter_map(|node| match node {
                Node::Atom(atom) if own(atom) => Some(*atom),
                _ => None,
            })
            .collect();
        let mut seen = BTreeSet::new();
        let truth = |value: u16| -> Vec<bool> {
            atoms
                .iter()
                .map(|atom| match *atom {
                    Atom::Bit(_) => value != 0,
                    Atom::AtLeast(_, threshold) => value >= threshold,
                    Atom::WordBit(_, bit) => value >> bit & 1 == 1,
                })
                .collect()
        };
        let most = if model.variables[variable].kind == VarKind::Bit { 1 } else { u16::MAX };
        (0..=most).filter(|&value| seen.insert(truth(value))).collect()
    };
    let domains: Vec<Vec<u16>> = (0..model.variables.len()).map(values).collect();
    let mut best = None;
    let mut places = vec![0; domains.len()];
    loop {
        let assignment =
            Assignment(places.iter().zip(&domains).map(|(&place, domain)| domain[place]).collect());
        let truth = model.circuit.evaluate(&assignment);
        if group.constraints.iter().all(|&c| truth.get(model.constraints[c])) {
            best = best.max(Some(model.cost(&group.charges, &assignment)));
        }
        let Some(next) = (0..places.len()).find(|&v| places[v] + 1 < domains[v].len()) else {
            return best;
        };
        places[next] += 1;
        places[..next].fill(0);
    }
}

/// Asserts the properties that every result must have.
pub fn sound(model: &ScanModel, group: &Group, found: &Maximum) {
    assert!(found.lower <= found.upper);
    let best = found.best.complete(model);
    let truth = model.circuit.evaluate(&best);
    if group.constraints.iter().all(|&c| truth.get(model.constraints[c])) {
        assert_eq!(model.cost(&group.charges, &best), found.lower);
        assert!(found.feasible);
    } else {
        assert!(!found.feasible);
        assert_eq!(found.lower, Picos::ZERO);
    }
}

/// Asserts that a method finds the same maximum as brute force, and gives valid bounds wherever it is interrupted.
pub fn equals_brute(method: Method, seed: u64, charges: u64) {
    let model = random(seed, charges);
    let group = Builder { model: model.clone() }.group();
    let truth = brute(&model, &group).unwrap();
    let looks = AtomicU64::new(0);
    let count = || {
        looks.fetch_add(1, Ordering::Relaxed);
        false
    };
    let limits = Limits { cancelled: &count, ..Limits::default() };
    let found = maximum(&model, &group, method, &limits);
    sound(&model, &group, &found);
    assert_eq!((found.lower, found.upper), (truth, truth), "seed {seed}");
    let looks = looks.load(Ordering::Relaxed);
    for allowed in (0..looks).step_by(1 + (looks / 7) as usize) {
        let left = AtomicU64::new(allowed);
        let stop = || {
            left.fetch_update(Ordering::Relaxed, Ordering::Relaxed, |n| n.checked_sub(1)).is_err()
        };
        let worst = AtomicU64::new(u64::MAX);
        let check_bounds = |upper: Picos, lower: Picos| {
            assert!(lower <= truth && truth <= upper, "seed {seed}");
            worst.fetch_min(upper.0, Ordering::Relaxed);
        };
        let limits = Limits { cancelled: &stop, progress: &check_bounds, ..Limits::default() };
        let found = maximum(&model, &group, method, &limits);
        sound(&model, &group, &found);
        assert!(found.lower <= truth && truth <= found.upper, "seed {seed}");
    }
}

/// The condition under which a charge of a station fires.
struct Rule {
    /// The required step number; `None` if the step does not matter.
    step: Option<u16>,
    /// Bits of the station, as indices, with their required values.
    bits: Vec<(usize, bool)>,
    /// Shared mode bits, as indices, with their required values.
    modes: Vec<(usize, bool)>,
    on: u64,
    off: u64,
}

const MODES: usize = 3;
const BITS: usize = 4;

/// Stations that share only three mode bits, and their maximum: for each setting of the mode bits, the maxima of the
/// stations add up.
pub fn plant(seed: u64, stations: usize) -> (ScanModel, Picos) {
    let mut dice = Dice(seed);
    let mut b = Builder::default();
    let modes: Vec<Lit> = (0..MODES).map(|_| b.bit()).collect();
    let mut totals = [0; 1 << MODES];
    for _ in 0..stations {
        let steps = 2 + dice.below(8) as u16;
        let some = |dice: &mut Dice, of: usize, one_in: u64| -> Vec<(usize, bool)> {
            let all: Vec<_> = (0..of).map(|n| (n, dice.one_in(2), dice.one_in(one_in))).collect();
            all.into_iter().filter(|bit| bit.2).map(|bit| (bit.0, bit.1)).collect()
        };
        let mut rules = Vec::new();
        for _ in 0..4 + dice.below(12) {
            let step = dice.one_in(2).then(|| 10 * dice.below(u64::from(steps)) as u16);
            let bits = some(&mut dice, BITS, 3);
            let modes = some(&mut dice, MODES, 4);
            let on = [1 + dice.below(50), 500 + dice.below(5000)][dice.below(2) as usize];
            rules.push(Rule { step, bits, modes, on, off: dice.below(30) });
        }
        let bits: Vec<Lit> = (0..BITS).map(|_| b.bit()).collect();
        let word = b.variable(VarKind::Word);
        for rule in &rules {
            let step = rule.step.map(|step| b.equals(word, step));
            let of = |lits: &[Lit], wanted: &[(usize, bool)]| -> Vec<Lit> {
                wanted.iter().map(|&(n, value)| if value { lits[n] } else { !lits[n] }).collect()
            };
            let all = [of(&bits, &rule.bits), of(&modes, &rule.modes)].concat();
            let condition = b.model.circuit.all(all.into_iter().chain(step));
            b.charge(Lit::TRUE, condition, rule.on, rule.off);
        }
        for (setting, total) in totals.iter_mut().enumerate() {
            let cost = |bits: usize, word: u16| -> u64 {
                let holds = |wanted: &[(usize, bool)], of: usize| {
                    wanted.iter().all(|&(n, value)| (of >> n & 1 == 1) == value)
                };
                let fires = |rule: &&Rule| {
                    rule.step.is_none_or(|step| step == word)
                        && holds(&rule.bits, bits)
                        && holds(&rule.modes, setting)
                };
                rules.iter().map(|r| if fires(&r) { r.on } else { r.off }).sum()
            };
            // Any step, or no step (5).
            let words = (0..steps).map(|step| 10 * step).chain([5]);
            *total += words
                .flat_map(|word| (0..1 << BITS).map(move |bits| cost(bits, word)))
                .max()
                .unwrap();
        }
    }
    (b.model, Picos(totals.into_iter().max().unwrap()))
}
