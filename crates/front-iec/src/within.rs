//! What stands within an expression.

use super::emit::Emit;
use super::types::{Kind, Ty};
use super::value::Value;
use scanbound_iec::ast::{Expr, Operator, Part, Path};
use scanbound_iec::{PouKind, Project, same};
use scanbound_ir::Logic;

/// An expression and all in it.
pub(super) fn each(one: &Expr, see: &mut dyn FnMut(&Expr)) {
    see(one);
    match one {
        Expr::Not(inner) | Expr::Negate(inner) => each(inner, see),
        Expr::Binary(_, left, right) => {
            each(left, see);
            each(right, see);
        }
        Expr::Call(_, given) => given.iter().for_each(|one| each(&one.value, see)),
        Expr::Literal(_) | Expr::Variable(_) => {}
    }
}

/// The same with what stands in indices.
pub(super) fn each_deep(one: &Expr, see: &mut dyn FnMut(&Expr)) {
    each(one, &mut |one| {
        see(one);
        if let Expr::Variable(path) | Expr::Call(path, _) = one {
            for part in &path.rest {
                if let Part::Index(indices) = part {
                    indices.iter().for_each(|index| each_deep(index, see));
                }
            }
        }
    });
}

/// Whether an expression adds, subtracts or negates anything.
pub(super) fn sums(one: &Expr) -> bool {
    let mut found = false;
    each(one, &mut |one| {
        found |= match one {
            Expr::Binary(operator, ..) => matches!(operator, Operator::Add | Operator::Subtract),
            Expr::Negate(inner) => !matches!(**inner, Expr::Literal(_)),
            Expr::Call(path, _) => ["ADD", "SUB"].iter().any(|name| same(name, &path.first)),
            _ => false,
        };
    });
    found
}

/// Whether an expression multiplies anything.
pub(super) fn multiplies(one: &Expr) -> bool {
    let mut found = false;
    each(one, &mut |one| {
        found |= match one {
            Expr::Binary(operator, ..) => *operator == Operator::Multiply,
            Expr::Call(path, _) => same("MUL", &path.first),
            _ => false,
        };
    });
    found
}

/// An expression's value where it becomes one of a type: any, if the type is longer than that of sums and the like of 32 bits
/// which a function of the standard was given, as it shows how many bits a compiler keeps of these. Of shorter ones, such
/// functions are given all bits, and what no function was given says by itself where it does not fit.
pub(super) fn shown(of: &Expr, value: Value, ty: &Ty) -> Value {
    match (value, ty) {
        (Value::Number(kind @ Kind::Whole { bits: own @ 32.., .. }, number), Ty::Number(to))
            if !matches!(to, Kind::Whole { bits, .. } if *bits <= own) && works(of) =>
        {
            Value::Open(kind, number, Logic::Const(true))
        }
        (Value::Number(Kind::Whole { bits: 32.., .. }, _), Ty::Bit) if works(of) => Value::Any,
        (value, _) => value,
    }
}

/// Whether an expression adds, multiplies, negates or complements anything.
pub(super) fn works(one: &Expr) -> bool {
    let mut complements = false;
    each(one, &mut |one| {
        complements |= match one {
            Expr::Not(_) => true,
            Expr::Call(path, _) => ["NOT", "ABS", "SHL"].iter().any(|name| same(name, &path.first)),
            _ => false,
        };
    });
    complements || sums(one) || multiplies(one)
}

/// The variables of an expression.
pub(super) fn variables(one: &Expr, see: &mut dyn FnMut(&Path)) {
    each_deep(one, &mut |one| {
        if let Expr::Variable(path) = one {
            see(path);
        }
    });
}

impl Emit<'_> {
    /// Whether an expression calls what the project declares.
    pub(super) fn calls_own(&self, one: &Expr) -> bool {
        calls(self.project, one)
    }
}

/// Whether an expression calls what the project declares.
pub(super) fn calls(project: &Project, one: &Expr) -> bool {
    let mut found = false;
    each_deep(one, &mut |one| {
        let path = match one {
            Expr::Call(path, _) => path,
            // A property is read by a method.
            Expr::Variable(path) => return found |= names_property(project, path),
            _ => return,
        };
        found |= names_property(project, path);
        let last = path.split_last().map_or(path.first.as_str(), |(_, last)| last);
        found |= project.pous.iter().any(|pou| {
            let is_function = pou.kind == PouKind::Function && same(&pou.name, last);
            is_function || pou.methods.iter().any(|method| same(&method.name, last))
        });
    });
    found
}

/// Whether a path has the name of a property, of whichever unit.
pub(super) fn names_property(project: &Project, path: &Path) -> bool {
    let parts = path.rest.iter().filter_map(|part| match part {
        Part::Name(name) => Some(name.as_str()),
        _ => None,
    });
    let mut names = std::iter::once(path.first.as_str()).chain(parts);
    let methods = || project.pous.iter().flat_map(|pou| &pou.methods);
    names.any(|name| methods().any(|one| one.property().is_some_and(|own| same(own, name))))
}
