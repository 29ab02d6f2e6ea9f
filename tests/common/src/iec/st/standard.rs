//! Operators, functions and blocks of the standard.

use super::place::Value;
use super::tree::{NUMBERS, Ty};
use std::collections::BTreeMap;

/// What controllers may do in different ways.
#[derive(Debug, Clone, Copy)]
pub struct Manner {
    /// Whether the second operand of AND and OR is left out where the first one settles the result.
    pub skips: bool,
    /// How many bits sums and products keep within an expression: those of their type (0), or at least 32 or 64.
    pub wide: u32,
    /// Whether the variable of FOR holds its last value behind the loop, not the one beyond the end.
    pub last: bool,
    /// Whether the end of FOR is worked out in each turn.
    pub end_again: bool,
    /// Whether operands and arguments are worked out from right to left.
    pub right_first: bool,
    /// Whether what is written is looked for before its value is worked out.
    pub target_first: bool,
    /// Whether all inputs of a block are worked out before the first one is passed.
    pub inputs_at_once: bool,
    /// Whether a falling edge is seen in the first call.
    pub falls: bool,
    /// Whether the sign goes on in the further bits of a longer string of bits.
    pub sign_goes_on: bool,
    /// Whether halves are rounded to even numbers, not away from 0.
    pub to_even: bool,
    /// Whether arguments are worked out, and passed to instances, though EN is false.
    pub disabled_takes: bool,
    pub counting: super::place::Counting,
}

fn truth(value: bool) -> Value {
    Value::Int(i128::from(value))
}

fn ordered<T: PartialOrd>(operator: &str, one: &T, two: &T) -> Option<Value> {
    Some(truth(match operator {
        "=" | "EQ" => one == two,
        "<>" | "NE" => one != two,
        "<" | "LT" => one < two,
        "<=" | "LE" => one <= two,
        ">" | "GT" => one > two,
        ">=" | "GE" => one >= two,
        _ => return None,
    }))
}

/// What an operator makes of two values, before it is told which bits are kept.
pub fn binary(operator: &str, one: &Value, two: &Value) -> Value {
    match (one, two) {
        (Value::Int(one), Value::Int(two)) => {
            if let Some(found) = ordered(operator, one, two) {
                return found;
            }
            Value::Int(match operator {
                "+" | "ADD" => one.wrapping_add(*two),
                "-" | "SUB" => one.wrapping_sub(*two),
                "*" | "MUL" => one.wrapping_mul(*two),
                "/" | "DIV" => one.checked_div(*two).unwrap_or(0),
                "MOD" => one.checked_rem(*two).unwrap_or(0),
                "AND" | "AND_THEN" | "&" => one & two,
                "OR" | "OR_ELSE" => one | two,
                "XOR" => one ^ two,
                other => panic!("{other}"),
            })
        }
        (Value::Real(one), Value::Real(two)) => {
            if let Some(found) = ordered(operator, one, two) {
                return found;
            }
            Value::Real(match operator {
                "+" => one + two,
                "-" => one - two,
                "*" => one * two,
                "/" => one / two,
                other => panic!("{other}"),
            })
        }
        (Value::Text(one), Value::Text(two)) => ordered(operator, one, two).expect("a comparison"),
        (one, two) => truth((one == two) == (operator == "=")),
    }
}

/// How a type's bits are kept within an expression.
pub fn open(ty: &Ty, wide: u32, value: Value) -> Value {
    match (ty, &value) {
        (Ty::Number(of), Value::Int(number)) if !of.is_bits && of.bits < wide => {
            let of = NUMBERS.iter().find(|one| one.bits == wide && one.signed).expect("a type");
            Value::Int(of.keep(*number))
        }
        _ => super::place::kept(ty, value),
    }
}

/// A conversion, by its name.
pub fn converted(from: &Ty, to: &Ty, value: &Value, manner: &Manner) -> Value {
    match (from, to, value) {
        (Ty::Real, Ty::Number(_), Value::Real(real)) => {
            let rounded = if manner.to_even { real.round_ties_even() } else { real.round() };
            #[allow(clippy::cast_possible_truncation)]
            super::place::kept(to, Value::Int(rounded as i128))
        }
        (_, Ty::Bool, Value::Int(value)) => truth(*value != 0),
        (Ty::Number(of), Ty::Number(into), Value::Int(value)) => {
            let cuts = of.signed && into.is_bits && of.bits < into.bits && !manner.sign_goes_on;
            let value = if cuts { value & ((1 << of.bits) - 1) } else { *value };
            super::place::kept(to, Value::Int(value))
        }
        (_, _, value) => super::place::kept(to, value.clone()),
    }
}

/// A function of the standard's but conversions.
pub fn function(name: &str, ty: &Ty, given: &[Value]) -> Value {
    let int = |at: usize| given[at].int();
    let shift = |value: i128, by: i128, left: bool, rotates: bool| {
        let bits = ty.as_number().expect("a string of bits").bits;
        let by = u32::try_from(by).expect("small");
        let back = bits - by;
        match (left, rotates) {
            (true, false) => value << by,
            (false, false) => value >> by,
            (true, true) => value << by | value >> back,
            (false, true) => value >> by | value << back,
        }
    };
    match name {
        "ABS" => match &given[0] {
            Value::Int(value) => Value::Int(value.abs()),
            Value::Real(value) => Value::Real(value.abs()),
            other => other.clone(),
        },
        "MIN" | "MAX" => given[1..].iter().fold(given[0].clone(), |one, two| {
            let takes = binary(if name == "MIN" { "<" } else { ">" }, two, &one).int() == 1;
            if takes { two.clone() } else { one }
        }),
        "LIMIT" => Value::Int(int(1).max(int(0)).min(int(2))),
        "SEL" => given[if int(0) == 0 { 1 } else { 2 }].clone(),
        "MUX" => given[usize::try_from(int(0)).expect("in range") + 1].clone(),
        "SHL" => Value::Int(shift(int(0), int(1), true, false)),
        "SHR" => Value::Int(shift(int(0), int(1), false, false)),
        "ROL" => Value::Int(shift(int(0), int(1), true, true)),
        "ROR" => Value::Int(shift(int(0), int(1), false, true)),
        "MOVE" => given[0].clone(),
        "NOT" => Value::Int(!int(0)),
        "TRUNC" =>
        {
            #[allow(clippy::cast_possible_truncation)]
            Value::Int(given[0].real().trunc() as i128)
        }
        other => given[1..].iter().fold(given[0].clone(), |one, two| binary(other, &one, two)),
    }
}

/// One call of a standard block, with the values of its pins.
pub fn block(kind: &str, pins: &BTreeMap<&str, i128>, passed: i128) -> Vec<(&'static str, i128)> {
    let get = |name: &str| pins.get(name).copied().unwrap_or(0);
    let on = |name: &str| get(name) == 1;
    let truth = i128::from;
    match kind {
        "R_TRIG" => vec![("Q", truth(on("CLK") && !on("m"))), ("m", get("CLK"))],
        "F_TRIG" => vec![("Q", truth(!on("CLK") && on("m"))), ("m", get("CLK"))],
        "SR" => vec![("Q1", truth(on("S1") || (!on("R") && on("Q1"))))],
        "RS" => vec![("Q1", truth(!on("R1") && (on("S") || on("Q1"))))],
        "CTU" => {
            let count = match (on("R"), on("CU") && !on("m")) {
                (true, _) => 0,
                (false, true) => (get("CV") + 1).min(32767),
                _ => get("CV"),
            };
            vec![("CV", count), ("Q", truth(count >= get("PV"))), ("m", get("CU"))]
        }
        "CTD" => {
            let count = match (on("LD"), on("CD") && !on("m")) {
                (true, _) => get("PV"),
                (false, true) => (get("CV") - 1).max(-32768),
                _ => get("CV"),
            };
            vec![("CV", count), ("Q", truth(count <= 0)), ("m", get("CD"))]
        }
        "CTUD" => {
            let (up, down) = (on("CU") && !on("m"), on("CD") && !on("n"));
            let count = match (on("R"), on("LD"), up, down) {
                (true, ..) => 0,
                (_, true, ..) => get("PV"),
                (_, _, true, false) => (get("CV") + 1).min(32767),
                (_, _, false, true) => (get("CV") - 1).max(-32768),
                _ => get("CV"),
            };
            let (full, empty) = (truth(count >= get("PV")), truth(count <= 0));
            vec![("CV", count), ("QU", full), ("QD", empty), ("m", get("CU")), ("n", get("CD"))]
        }
        "TON" => {
            let elapsed = if on("IN") && on("m") { get("ET") + passed } else { 0 };
            let elapsed = elapsed.min(get("PT"));
            let over = truth(on("IN") && elapsed >= get("PT"));
            vec![("ET", elapsed), ("Q", over), ("m", get("IN"))]
        }
        "TOF" => {
            let begins = !on("IN") && on("m");
            let runs = !on("IN") && on("Q") && !begins;
            let elapsed = if runs { get("ET") + passed } else { 0 };
            let held = on("Q") && !on("IN") && elapsed < get("PT");
            vec![("ET", elapsed), ("Q", truth(on("IN") || held)), ("m", get("IN"))]
        }
        _ => {
            let elapsed = if on("Q") { get("ET") + passed } else { 0 };
            let goes_on = on("Q") && elapsed < get("PT");
            let begins = !on("Q") && on("IN") && !on("m") && get("PT") > 0;
            vec![("ET", elapsed), ("Q", truth(goes_on || begins)), ("m", get("IN"))]
        }
    }
}
