//! Builds a model for lower bounds, in which nothing depends on unknown values: each charge costs what a scan costs at
//! least, whatever the unknown values are.

use super::{Atom, Charge, Circuit, Lit, Node, ScanModel, VarId};
use scanbound_base::time::Picos;

/// What the search for a lower bound may assume about a free variable.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Treatment {
    /// The search may choose any value for the variable.
    Free,
    /// The variable has the value 0.
    Zero,
    /// The search may assume nothing: the value is unknown, so a lower bound must not depend on it.
    Unknown,
}

/// Two literals for one node of the old circuit: that the node is certainly true whatever the unknown values are, and
/// that it is certainly false. Both are false in scans in which neither is certain.
type Pair = (Lit, Lit);

/// The model in which nothing depends on unknown variables (`standing` says which are unknown): each charge has the
/// time that it takes at least, whatever the values of these variables are. Scans are excluded in which a constraint is
/// not certainly true or an error certainly occurs and, if `strict`, in which it is unknown whether control reaches a
/// charge with a time. Variables keep their numbers; charges do not.
#[must_use]
pub fn lower_bound_model(
    model: &ScanModel,
    standing: &dyn Fn(VarId) -> Treatment,
    strict: bool,
) -> ScanModel {
    lower_bound_model_with(model, standing, strict, &[]).0
}

/// As [`lower_bound_model`]. Also returns two literals of the new model for each of `literals`, which are literals of
/// `model`: that it is certainly true, and that it is certainly false.
#[must_use]
pub fn lower_bound_model_with(
    model: &ScanModel,
    standing: &dyn Fn(VarId) -> Treatment,
    strict: bool,
    literals: &[Lit],
) -> (ScanModel, Vec<(Lit, Lit)>) {
    let mut circuit = Circuit::default();
    let mut pairs: Vec<Pair> = Vec::with_capacity(model.circuit.nodes().len());
    let of = |pairs: &[Pair], lit: Lit| {
        let (yes, no) = pairs[lit.node()];
        if lit.is_negated() { (no, yes) } else { (yes, no) }
    };
    for node in model.circuit.nodes() {
        let pair = match *node {
            Node::True => (Lit::TRUE, Lit::FALSE),
            Node::Atom(atom) => match standing(atom.variable()) {
                Treatment::Free => {
                    let lit = circuit.atom(atom);
                    (lit, !lit)
                }
                Treatment::Zero => {
                    let lit = Lit::constant(matches!(atom, Atom::AtLeast(_, 0)));
                    (lit, !lit)
                }
                Treatment::Unknown => (Lit::FALSE, Lit::FALSE),
            },
            Node::And(a, b) => {
                let ((yes, no), (also, nor)) = (of(&pairs, a), of(&pairs, b));
                let yes = circuit.and(yes, also);
                // If neither input depends on unknown values, one gate serves both literals.
                let no = if is_known(&pairs, a) && is_known(&pairs, b) {
                    !yes
                } else {
                    circuit.or(no, nor)
                };
                (yes, no)
            }
        };
        pairs.push(pair);
    }
    let mut found = ScanModel { variables: model.variables.clone(), ..ScanModel::default() };
    for charge in &model.charges {
        let (reached, passed) = of(&pairs, charge.reached);
        let (fires, idle) = of(&pairs, charge.fires);
        if strict && charge.largest_cost() > Picos::ZERO {
            found.constraints.push(circuit.or(reached, passed));
        }
        let ((on, units), off) = (charge.cost_if_fired(), charge.off);
        let bare = || Charge { counted: None, ..charge.clone() };
        let mut add = |holds: Lit, more: Picos| {
            let (reached, fires) = (holds, holds);
            found.charges.push(Charge { reached, fires, on: more, off: Picos::ZERO, ..bare() });
        };
        for &(handled, more) in units {
            add(of(&pairs, handled).0, more);
        }
        let base = on.min(off);
        let known = reached == !passed && fires == !idle;
        if known || on == off {
            let fires = if known { fires } else { reached };
            found.charges.push(Charge { reached, fires, on, off, ..bare() });
            continue;
        }
        let larger = if on > off { fires } else { circuit.and(reached, idle) };
        add(larger, Picos(on.max(off).0 - base.0));
        let fires = reached;
        found.charges.push(Charge { reached, fires, on: base, off: base, ..bare() });
    }
    found.constraints.extend(model.constraints.iter().map(|&holds| of(&pairs, holds).0));
    // The real run finds out whether an error occurs that depends on unknown values.
    found.constraints.extend(model.errors.iter().map(|&error| !of(&pairs, error).0));
    found.constraints.retain(|&holds| holds != Lit::TRUE);
    found.constraints.sort_unstable();
    found.constraints.dedup();
    found.havocs = model.havocs.with_conditions(|happened| of(&pairs, happened).0);
    found.circuit = circuit;
    let literals = literals.iter().map(|&lit| of(&pairs, lit)).collect();
    (found, literals)
}

/// Whether the literal depends on no unknown value.
fn is_known(pairs: &[Pair], lit: Lit) -> bool {
    let (yes, no) = pairs[lit.node()];
    yes == !no
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Assignment, Origin, VarKind, Variable};
    use scanbound_ir::{AreaId, Cell};

    #[test]
    fn what_is_not_known_costs_the_least_and_decides_no_path() {
        let mut model = ScanModel::default();
        for index in 0..3 {
            model.variables.push(Variable {
                kind: VarKind::Bit,
                origin: Origin::Start(Cell { area: AreaId(0), index }),
                name: format!("X{index}"),
            });
        }
        let x: Vec<Lit> = (0..3).map(|v| model.circuit.atom(Atom::Bit(VarId(v)))).collect();
        let either = model.circuit.or(x[0], x[1]);
        for (reached, fires) in [(Lit::TRUE, either), (either, either), (Lit::TRUE, x[2])] {
            let fires = model.circuit.and(reached, fires);
            let (on, off) = (Picos(100), Picos(7));
            model.charges.push(Charge {
                instruction: 0,
                frames: Vec::new(),
                reached,
                fires,
                on,
                off,
                counted: None,
            });
        }
        let unknown = |variable: VarId| match variable.0 {
            1 => Treatment::Unknown,
            2 => Treatment::Zero,
            _ => Treatment::Free,
        };
        let found = lower_bound_model(&model, &unknown, true);
        let run = |x0: u16| {
            let assignment = Assignment(vec![x0, 1, 1]);
            let all: Vec<usize> = (0..found.charges.len()).collect();
            let values = found.circuit.evaluate(&assignment);
            let holds = found.constraints.iter().all(|&holds| values.get(holds));
            (holds, found.cost(&all, &assignment))
        };
        // If X0 is on, everything is known. If it is off, it is unknown whether the second charge is reached, and the
        // first has the smaller of its times.
        assert_eq!(run(1), (true, Picos(100 + 100 + 7)));
        assert_eq!(run(0), (false, Picos(7 + 7)));
    }
}
