//! Whether the conditions of two transitions are mutually exclusive, such as `x` and `NOT x`.

use super::Chart;
use crate::ast::{Expr, Literal, Operator};
use crate::show;

/// Whether two conditions are never true together, judged by their text: an operand that one requires is the negation
/// of an operand that the other requires, or both compare a variable with constants so that no value satisfies both.
/// The caller must ensure that no variable changes between the evaluations of the two conditions.
#[must_use]
pub fn never_both(one: &Expr, other: &Expr) -> bool {
    let (one, other) = (parts(one, true), parts(other, true));
    one.iter().any(|one| other.iter().any(|other| excludes(one, other)))
}

/// Whether evaluating the conditions of this chart has no side effects, judged by their text: none contains a call or
/// an unreadable part.
#[must_use]
pub fn calls_nothing(chart: &Chart) -> bool {
    fn is_quiet(expr: &Expr) -> bool {
        match expr {
            Expr::Call(..) | Expr::List(..) | Expr::Unread(_) => false,
            Expr::Literal(_) | Expr::Variable(_) | Expr::Kept(_) | Expr::Held(_) => true,
            Expr::Not(inner) | Expr::Negate(inner) => is_quiet(inner),
            Expr::Binary(_, left, right) => is_quiet(left) && is_quiet(right),
        }
    }
    chart.transitions.iter().all(|one| is_quiet(&one.condition))
}

/// A required operand of a condition: an expression and the truth value that it must have.
type Part<'e> = (&'e Expr, bool);

fn parts(condition: &Expr, is: bool) -> Vec<Part<'_>> {
    match (condition, is) {
        (Expr::Not(inner), _) => parts(inner, !is),
        (Expr::Binary(Operator::And | Operator::AndThen, left, right), true)
        | (Expr::Binary(Operator::Or | Operator::OrElse, left, right), false) => {
            [parts(left, is), parts(right, is)].concat()
        }
        _ => vec![(condition, is)],
    }
}

fn excludes((one, is): &Part<'_>, (other, other_is): &Part<'_>) -> bool {
    // Step flags may change during an evolution, and an index may be evaluated differently each time.
    let is_plain = |expr: &Expr| {
        matches!(expr, Expr::Variable(path)
            if path.rest.iter().all(|part| matches!(part, crate::ast::Part::Name(_)))
                && !path.split_last().is_some_and(|(_, last)| crate::same(last, "X") || crate::same(last, "T")))
    };
    match (one, other) {
        (Expr::Variable(left), Expr::Variable(right)) => {
            is != other_is && is_plain(one) && crate::same(&show::path(left), &show::path(right))
        }
        (Expr::Held(left), Expr::Held(right)) => is != other_is && left == right,
        (Expr::Binary(first, left, low), Expr::Binary(second, right, high)) => {
            let (Expr::Variable(left_path), Expr::Variable(right_path)) = (&**left, &**right)
            else {
                return false;
            };
            let (Expr::Literal(Literal::Int(low, None)), Expr::Literal(Literal::Int(high, None))) =
                (&**low, &**high)
            else {
                return false;
            };
            // If the variable is not a number (NaN), both comparisons are false, so their negations can be true
            // together.
            if !is && !other_is && is_order(*first) && is_order(*second) {
                return false;
            }
            let first = if *is { Some(*first) } else { negated(*first) };
            let second = if *other_is { Some(*second) } else { negated(*second) };
            let (Some(first), Some(second)) = (first, second) else { return false };
            is_plain(left)
                && crate::same(&show::path(left_path), &show::path(right_path))
                && disjoint((first, *low), (second, *high))
        }
        _ => false,
    }
}

fn is_order(operator: Operator) -> bool {
    !matches!(operator, Operator::Equal | Operator::NotEqual)
}

fn negated(operator: Operator) -> Option<Operator> {
    Some(match operator {
        Operator::Equal => Operator::NotEqual,
        Operator::NotEqual => Operator::Equal,
        Operator::Less => Operator::GreaterOrEqual,
        Operator::GreaterOrEqual => Operator::Less,
        Operator::Greater => Operator::LessOrEqual,
        Operator::LessOrEqual => Operator::Greater,
        _ => return None,
    })
}

/// Whether no integer satisfies both comparisons.
fn disjoint(one: (Operator, i128), other: (Operator, i128)) -> bool {
    let below = |(operator, limit): (Operator, i128)| match operator {
        Operator::Less => Some((limit, true)),
        Operator::LessOrEqual | Operator::Equal => Some((limit, false)),
        _ => None,
    };
    let above = |(operator, limit): (Operator, i128)| match operator {
        Operator::Greater => Some((limit, true)),
        Operator::GreaterOrEqual | Operator::Equal => Some((limit, false)),
        _ => None,
    };
    let crosses = |low, high| {
        let (Some((high, is_open)), Some((low, also_open))) = (below(low), above(high)) else {
            return false;
        };
        high < low || (high == low && (is_open || also_open))
    };
    let differs = matches!(
        (one, other),
        ((Operator::Equal, a), (Operator::NotEqual, b))
        | ((Operator::NotEqual, b), (Operator::Equal, a)) if a == b
    );
    differs || crosses(one, other) || crosses(other, one)
}

#[cfg(test)]
mod tests {
    use super::{calls_nothing, never_both};
    use crate::{Project, read};

    /// The conditions of two transitions in one chart.
    fn project(one: &str, other: &str) -> Project {
        let text = format!(
            "PROGRAM p VAR a, b : BOOL; n : INT; i : Inner; END_VAR
             INITIAL_STEP S0: END_STEP STEP S1: END_STEP
             TRANSITION FROM S0 TO S1 := {one}; END_TRANSITION
             TRANSITION FROM S0 TO S1 := {other}; END_TRANSITION
             END_PROGRAM"
        );
        read("p.st", &text).unwrap_or_else(|faults| panic!("{faults:?}"))
    }

    fn apart(one: &str, other: &str) -> bool {
        let project = project(one, other);
        let all = &project.charts()[0].2.transitions;
        never_both(&all[0].condition, &all[1].condition)
    }

    #[test]
    fn conditions_exclude_each_other_by_a_part_of_each() {
        for (one, other) in [
            ("a", "NOT a"),
            ("A AND b", "NOT (b OR a)"),
            ("a AND_THEN b", "NOT a"),
            ("i.Q", "NOT i.q"),
            ("n = 1", "n = 2"),
            ("n = 1", "n <> 1"),
            ("n < 3 AND a", "n >= 3"),
            ("n <= 3", "NOT (n <= 3)"),
            ("n > 3", "n < 4 AND n < 3"),
        ] {
            assert!(apart(one, other) && apart(other, one), "{one}; {other}");
        }
        for (one, other) in [
            ("a", "b"),
            ("a OR b", "NOT a"),
            ("NOT (a AND b)", "a"),
            ("S0.X", "NOT S0.X"),
            ("S0.T > 3", "S0.T < 3"),
            ("n <= 3", "n >= 3"),
            ("NOT (n > 3)", "NOT (n < 5)"),
            ("n > 3", "n <> 4"),
            ("n = 1", "n = 1"),
            ("n < 3.0", "n > 4.0"),
        ] {
            assert!(!apart(one, other) && !apart(other, one), "{one}; {other}");
        }
    }

    #[test]
    fn a_condition_that_calls_something_may_change_what_the_next_one_reads() {
        let quiet = |one: &str| calls_nothing(project(one, "a").charts()[0].2);
        assert!(quiet("NOT (n + 1 > -n)"));
        assert!(!quiet("NOT f(n)"));
    }
}
