//! Which free variables determine the time of the longest scan: the others may have any value.

use scanbound_model::{Assignment, Lit, Node, ScanModel, VarId};
use std::collections::BTreeSet;

/// For each variable of the model, whether its value in `assignment` is needed to show that these charges take at least
/// the time that they take under it, and that all constraints of the model hold. The set is small, but not always
/// minimal.
pub fn needed_variables(
    model: &ScanModel,
    assignment: &Assignment,
    charges: &[usize],
) -> Vec<bool> {
    let values = model.circuit.evaluate(assignment);
    let nodes = model.circuit.nodes();
    let mut needed = vec![false; nodes.len()];
    let mut need = |lit: Lit| needed[lit.node()] = true;
    for &index in charges {
        let charge = &model.charges[index];
        let (reached, fires) = (values.get(charge.reached), values.get(charge.fires));
        // A charge that fires is also reached.
        let (on, units) = charge.cost_if_fired();
        if fires && on > charge.off {
            need(charge.fires);
        } else if reached {
            need(charge.reached);
            if on < charge.off && !fires {
                need(charge.fires);
            }
        }
        units.iter().filter(|(handled, _)| values.get(*handled)).for_each(|(lit, _)| need(*lit));
    }
    model.constraints.iter().copied().for_each(&mut need);
    let mut variables = vec![false; model.variables.len()];
    // Gates follow their inputs, so one backward pass finds everything that is needed.
    for index in (0..nodes.len()).rev() {
        if !needed[index] {
            continue;
        }
        match nodes[index] {
            Node::True => {}
            Node::Atom(atom) => variables[atom.variable().0 as usize] = true,
            Node::And(a, b) => match (values.get(a), values.get(b)) {
                (true, true) => {
                    needed[a.node()] = true;
                    needed[b.node()] = true;
                }
                (false, true) => needed[a.node()] = true,
                (true, false) => needed[b.node()] = true,
                // One input is enough: prefer one that is needed anyway, otherwise the one nearer to the leaves.
                (false, false) => {
                    if !needed[a.node()] && !needed[b.node()] {
                        needed[a.node().min(b.node())] = true;
                    }
                }
            },
        }
    }
    variables
}

/// The variables that occur in the guards of these charges.
pub fn depends_on(model: &ScanModel, charges: &[usize]) -> BTreeSet<VarId> {
    let guards = charges.iter().map(|&index| &model.charges[index]);
    let mut open: Vec<usize> = guards.flat_map(|charge| charge.literals()).map(Lit::node).collect();
    let mut seen = vec![false; model.circuit.nodes().len()];
    let mut variables = BTreeSet::new();
    while let Some(index) = open.pop() {
        if std::mem::replace(&mut seen[index], true) {
            continue;
        }
        match model.circuit.nodes()[index] {
            Node::True => {}
            Node::Atom(atom) => {
                variables.insert(atom.variable());
            }
            Node::And(a, b) => open.extend([a.node(), b.node()]),
        }
    }
    variables
}

#[cfg(test)]
mod tests {
    use super::*;
    use scanbound_base::time::Picos;
    use scanbound_ir::{AreaId, Cell};
    use scanbound_model::{Atom, Charge, Origin, VarKind, Variable};

    #[test]
    fn only_what_a_running_charge_needs_decides() {
        let mut model = ScanModel::default();
        for index in 0..4 {
            model.variables.push(Variable {
                kind: VarKind::Bit,
                origin: Origin::Start(Cell { area: AreaId(0), index }),
                name: format!("X{index}"),
            });
        }
        let x: Vec<Lit> = (0..4).map(|v| model.circuit.atom(Atom::Bit(VarId(v)))).collect();
        let either = model.circuit.or(x[0], x[1]);
        let both = model.circuit.and(x[2], x[3]);
        for (fires, on, off) in [(either, 5, 1), (both, 9, 1)] {
            model.charges.push(Charge {
                instruction: 0,
                frames: Vec::new(),
                reached: Lit::TRUE,
                fires,
                on: Picos(on),
                off: Picos(off),
                counted: None,
            });
        }
        let decide =
            |values: [u16; 4]| needed_variables(&model, &Assignment(values.into()), &[0, 1]);
        // The second charge takes its smaller time in any case. Either X0 or X1 is enough.
        assert_eq!(decide([1, 1, 1, 0]), [true, false, false, false]);
        assert_eq!(decide([0, 1, 1, 1]), [false, true, true, true]);
        assert_eq!(decide([0, 0, 0, 0]), [false; 4]);
        assert_eq!(depends_on(&model, &[1]), BTreeSet::from([VarId(2), VarId(3)]));
    }
}
