//! Exports the problem of a group in the formats of other solvers: WCNF for MaxSAT, SMT-LIB 2 for SMT.

use super::clauses::Clauses;
use super::{Group, Item, Problem};
use scanbound_base::time::Picos;
use scanbound_model::{Atom, GroupAssignment, Lit, Node, ScanModel, VarId, VarKind};
use std::collections::BTreeMap;
use std::fmt::Write;

/// The problem as weighted partial MaxSAT, in the format of the MaxSAT evaluations since 2022: a hard clause begins
/// with `h`, a soft clause with its weight. The group's maximum in picoseconds is the constant plus all weights (given
/// in a comment) minus the least weight of violated soft clauses.
///
/// `charge` describes a charge (an index into `ScanModel::charges`) in one line.
#[must_use]
pub fn wcnf(model: &ScanModel, group: &Group, charge: &dyn Fn(usize) -> String) -> String {
    let problem = Problem::new(model, group);
    let clauses = Clauses::new(&problem);
    let mut text = String::new();
    line(
        &mut text,
        format_args!("c The maximum cost of this group of charges in one scan, in picoseconds:"),
    );
    line(
        &mut text,
        format_args!("c {} minus the weight of the violated soft clauses.", problem.naive()),
    );
    let always = problem.constant.saturating_sub(problem.deducted);
    line(&mut text, format_args!("c {always} of this is constant."));
    for &(variable, atom) in &clauses.atoms {
        let atom = atom_text(model, &problem, atom);
        line(&mut text, format_args!("c variable {variable}: {atom}"));
    }
    for clause in clauses.clauses.iter() {
        line(&mut text, format_args!("h {}0", literals(clause)));
    }
    for (item, &literal) in problem.items.iter().zip(&clauses.items) {
        for &index in &item.charges {
            line(&mut text, format_args!("c soft {literal}: {}", one_line(&charge(index))));
        }
        line(&mut text, format_args!("{} {literal} 0", item.weight));
    }
    text
}

/// The problem in SMT-LIB 2, for a solver with optimisation (`assert-soft`). `charge` describes a charge (an index into
/// [`ScanModel::charges`]) in one line.
#[must_use]
pub fn smt2(model: &ScanModel, group: &Group, charge: &dyn Fn(usize) -> String) -> String {
    let problem = Problem::new(model, group);
    let mut text = String::new();
    line(
        &mut text,
        format_args!("; The maximum cost of this group of charges in one scan, in picoseconds:"),
    );
    line(&mut text, format_args!("; {} minus the objective.", problem.naive()));
    definitions(&mut text, model, &problem);
    for item in &problem.items {
        for &index in &item.charges {
            line(&mut text, format_args!("; {}", one_line(&charge(index))));
        }
        let guard = reference(item.guard);
        line(&mut text, format_args!("(assert-soft {guard} :weight {} :id scan)", item.weight));
    }
    text.push_str("(check-sat)\n(get-objectives)\n(get-model)\n");
    text
}

/// A decision problem in SMT-LIB 2 without optimisation: can the group cost more than `bound`? The answer `unsat`
/// confirms the bound.
#[must_use]
pub fn certificate(
    model: &ScanModel,
    group: &Group,
    bound: Picos,
    charge: &dyn Fn(usize) -> String,
) -> String {
    let problem = Problem::new(model, group);
    let mut text = String::new();
    line(
        &mut text,
        format_args!("; Can this group of charges cost more than {} ps in one scan?", bound.0),
    );
    line(&mut text, format_args!("; unsat: it cannot."));
    text.push_str("(set-logic ALL)\n");
    definitions(&mut text, model, &problem);
    total(&mut text, &problem, charge);
    line(&mut text, format_args!("(assert (> total {}))", bound.0));
    text.push_str("(check-sat)\n");
    text
}

/// A decision problem in SMT-LIB 2: can any of the group's charges be reached? Each must have an on-time and an
/// off-time that are equal and not 0. `head` is the comment at the top, line by line; `charge` describes a charge. The
/// answer `unsat` confirms that none can.
#[must_use]
pub fn never(
    model: &ScanModel,
    group: &Group,
    head: &[String],
    charge: &dyn Fn(usize) -> String,
) -> String {
    let problem = Problem::with_negations(model, group);
    let mut text = String::new();
    head.iter().for_each(|one| line(&mut text, format_args!("; {}", one_line(one))));
    text.push_str("(set-logic QF_BV)\n");
    definitions(&mut text, model, &problem);
    text.push_str("(assert (or false\n");
    for &index in &group.charges {
        // Charges that are excluded by their structure have no item and need no query.
        let of = |item: &&Item| item.charges.contains(&index);
        let guard = problem.items.iter().find(of).map_or(Lit::FALSE, |item| item.guard);
        let guard = if model.charges[index].reached == Lit::TRUE { Lit::TRUE } else { guard };
        line(&mut text, format_args!("  {} ; {}", reference(guard), one_line(&charge(index))));
    }
    text.push_str("))\n(check-sat)\n");
    text
}

/// A decision problem in SMT-LIB 2 in which every variable is fixed to its value in `best`: does that scan satisfy the
/// constraints and cost `cost`? The answer `sat` confirms that the group can cost that much.
#[must_use]
pub fn attained(
    model: &ScanModel,
    group: &Group,
    best: &GroupAssignment,
    cost: Picos,
    charge: &dyn Fn(usize) -> String,
) -> String {
    let problem = Problem::new(model, group);
    let mut text = String::new();
    line(&mut text, format_args!("; A scan in which this group of charges costs {} ps.", cost.0));
    line(&mut text, format_args!("; sat: it does."));
    text.push_str("(set-logic ALL)\n");
    let best: BTreeMap<VarId, u16> = best.0.iter().copied().collect();
    for &variable in definitions(&mut text, model, &problem) {
        let value = best.get(&variable).copied().unwrap_or(0);
        let value = match model.variables[variable.0 as usize].kind {
            VarKind::Bit => (value != 0).to_string(),
            VarKind::Word => format!("#x{value:04X}"),
        };
        line(&mut text, format_args!("(assert (= v{} {value}))", variable.0));
    }
    total(&mut text, &problem, charge);
    line(&mut text, format_args!("(assert (= total {}))", cost.0));
    text.push_str("(check-sat)\n");
    text
}

/// Defines `total`, the cost of the group in picoseconds.
fn total(text: &mut String, problem: &Problem, charge: &dyn Fn(usize) -> String) {
    text.push_str("(define-fun total () Int (+\n");
    line(text, format_args!("  {} ; always", problem.constant));
    if problem.deducted > 0 {
        line(text, format_args!("  (- {}) ; units that are not processed", problem.deducted));
    }
    for item in &problem.items {
        let names: Vec<String> = item.charges.iter().map(|&c| one_line(&charge(c))).collect();
        let guard = reference(item.guard);
        line(text, format_args!("  (ite {guard} {} 0) ; {}", item.weight, names.join(" | ")));
    }
    text.push_str("  0))\n");
}

/// Declares the variables, defines the gates of the circuit and asserts the constraints. Returns the variables.
fn definitions<'a>(text: &mut String, model: &ScanModel, problem: &'a Problem) -> &'a [VarId] {
    let nodes = problem.circuit.nodes();
    let number = |own: VarId| problem.variable(own).0;
    for &variable in &problem.variables {
        let described = &model.variables[variable.0 as usize];
        let sort = match described.kind {
            VarKind::Bit => "Bool",
            VarKind::Word => "(_ BitVec 16)",
        };
        let name = one_line(&described.name);
        line(text, format_args!("(declare-const v{} {sort}) ; {name}", variable.0));
    }
    for (index, node) in nodes.iter().enumerate() {
        let meaning = match *node {
            Node::True => continue,
            Node::Atom(Atom::Bit(v)) => format!("v{}", number(v)),
            Node::Atom(Atom::AtLeast(v, least)) => {
                format!("(bvuge v{} #x{least:04X})", number(v))
            }
            Node::Atom(Atom::WordBit(v, bit)) => {
                format!("(= ((_ extract {bit} {bit}) v{}) #b1)", number(v))
            }
            Node::And(a, b) => format!("(and {} {})", reference(a), reference(b)),
        };
        line(text, format_args!("(define-fun g{index} () Bool {meaning})"));
    }
    for &lit in &problem.hard {
        line(text, format_args!("(assert {})", reference(lit)));
    }
    &problem.variables
}

fn reference(lit: Lit) -> String {
    match lit {
        Lit::TRUE => "true".to_owned(),
        Lit::FALSE => "false".to_owned(),
        _ if lit.is_negated() => format!("(not g{})", lit.node()),
        _ => format!("g{}", lit.node()),
    }
}

fn atom_text(model: &ScanModel, problem: &Problem, atom: Atom) -> String {
    let variable = problem.variable(atom.variable());
    let name = one_line(&model.variables[variable.0 as usize].name);
    match atom {
        Atom::Bit(_) => name,
        Atom::AtLeast(_, least) => format!("{name} >= {least} (unsigned)"),
        Atom::WordBit(_, bit) => format!("{name}.{bit:X}"),
    }
}

fn literals(clause: &[i32]) -> String {
    clause.iter().map(|literal| format!("{literal} ")).collect()
}

/// Replaces line breaks, since a comment ends with its line.
fn one_line(text: &str) -> String {
    text.replace(['\n', '\r'], " ")
}

fn line(text: &mut String, arguments: std::fmt::Arguments<'_>) {
    text.write_fmt(arguments).expect("writing to a string does not fail");
    text.push('\n');
}
