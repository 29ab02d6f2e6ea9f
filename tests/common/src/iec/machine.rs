//! Programs of IEC 61131-3 as a tree of their own, which writes itself as text and is run by a small interpreter: by
//! the standard alone, and by no line of what it is held against. What is handed over in and out is a reference here.

#![allow(dead_code, reason = "not every suite has all statements and types")]

use std::collections::BTreeMap;

/// What all tasks share: variables of the project.
pub const OTHER: &[&str] = &["g0", "g1", "g2"];

/// A type of numbers, or of truth values with 1 bit.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Ty {
    pub bits: u32,
    pub signed: bool,
}

pub const BOOL: Ty = Ty { bits: 1, signed: false };
pub const SINT: Ty = Ty { bits: 8, signed: true };
pub const USINT: Ty = Ty { bits: 8, signed: false };
pub const INT: Ty = Ty { bits: 16, signed: true };
pub const UINT: Ty = Ty { bits: 16, signed: false };
pub const DINT: Ty = Ty { bits: 32, signed: true };
/// An enumeration of the project's.
pub const COLOUR: Ty = Ty { bits: 3, signed: false };
/// Its values; a variable begins with the first.
pub const COLOURS: &[(&str, i64)] = &[("red", 2), ("green", 3), ("blue", 5), ("black", 0)];

impl Ty {
    pub fn name(self) -> &'static str {
        match (self.bits, self.signed) {
            (1, _) => "BOOL",
            (3, _) => "Colour",
            (8, true) => "SINT",
            (8, false) => "USINT",
            (16, true) => "INT",
            (16, false) => "UINT",
            _ => "DINT",
        }
    }

    /// What of a number the type keeps.
    pub fn wrap(self, value: i64) -> i64 {
        let low = value & ((1 << self.bits) - 1);
        if self.signed && low >> (self.bits - 1) & 1 == 1 { low - (1 << self.bits) } else { low }
    }

    fn literal(self, value: i64) -> String {
        match self {
            BOOL => if value == 0 { "FALSE" } else { "TRUE" }.to_owned(),
            COLOUR => {
                let own = COLOURS.iter().find(|one| one.1 == value).expect("a value").0;
                // With its type's name, or without.
                if value & 1 == 1 { own.to_owned() } else { format!("Colour#{own}") }
            }
            _ => value.to_string(),
        }
    }
}

/// An expression and its type.
#[derive(Debug, Clone)]
pub struct Expr {
    pub ty: Ty,
    pub of: Of,
}

#[derive(Debug, Clone)]
pub enum Of {
    Literal(i64),
    /// With its type in front.
    Typed(i64),
    Variable(String),
    /// `name[LIMIT(0, index, 3)]`.
    Element(&'static str, Box<Expr>),
    Not(Box<Expr>),
    Binary(&'static str, Box<Expr>, Box<Expr>),
    /// `ABS`, `MIN`, `MAX`, `LIMIT`, `SEL`, conversions.
    Standard(String, Vec<Expr>),
    /// A function of the project's: its inputs, and what it is handed in and out.
    Call(usize, Box<Expr>, String),
}

#[derive(Debug, Clone)]
pub enum Statement {
    Assign(String, Expr),
    /// To `name[LIMIT(0, index, 3)]`.
    Store(&'static str, Expr, Expr),
    /// One structure to another.
    Copy(String, String),
    If(Vec<(Expr, Vec<Statement>)>, Vec<Statement>),
    Case(Expr, Vec<(i64, i64, Vec<Statement>)>, Vec<Statement>),
    For(String, Expr, i64, i64, Vec<Statement>),
    /// A loop that counts up to an end: as WHILE, or as REPEAT.
    Counting(bool, String, i64, Vec<Statement>),
    Exit,
    Continue,
    /// An instance, its unit, its inputs, what it is handed in and out, and where its output goes.
    Block(&'static str, usize, Vec<Expr>, [String; 2], Option<String>),
    /// An instance of a standard block, its type, and its inputs.
    Standard(&'static str, &'static str, Vec<(&'static str, Expr)>),
}

/// A function, or a function block with variables of its own.
#[derive(Debug, Clone, Default)]
pub struct Unit {
    pub body: Vec<Statement>,
}

impl Expr {
    pub fn text(&self) -> String {
        match &self.of {
            Of::Literal(value) => self.ty.literal(*value),
            Of::Typed(value) => format!("{}#{value}", self.ty.name()),
            Of::Variable(name) => name.clone(),
            Of::Element(name, index) => format!("{name}[LIMIT(0, {}, 3)]", index.text()),
            Of::Not(inner) => format!("(NOT {})", inner.text()),
            Of::Binary(operator, one, two) => {
                format!("({} {operator} {})", one.text(), two.text())
            }
            Of::Standard(name, given) => {
                let given: Vec<String> = given.iter().map(Expr::text).collect();
                format!("{name}({})", given.join(", "))
            }
            Of::Call(unit, input, both) => format!("Fun{unit}(a := {}, c := {both})", input.text()),
        }
    }
}

pub fn text(statements: &[Statement], out: &mut String) {
    for one in statements {
        match one {
            Statement::Assign(target, value) => *out += &format!("{target} := {};\n", value.text()),
            Statement::Store(name, index, value) => {
                *out += &format!("{name}[LIMIT(0, {}, 3)] := {};\n", index.text(), value.text());
            }
            Statement::Copy(to, from) => *out += &format!("{to} := {from};\n"),
            Statement::If(arms, otherwise) => {
                for (number, (condition, body)) in arms.iter().enumerate() {
                    let word = if number == 0 { "IF" } else { "ELSIF" };
                    *out += &format!("{word} {} THEN\n", condition.text());
                    text(body, out);
                }
                *out += "ELSE\n";
                text(otherwise, out);
                *out += "END_IF;\n";
            }
            Statement::Case(of, arms, otherwise) => {
                *out += &format!("CASE {} OF\n", of.text());
                for (low, high, body) in arms {
                    *out += &if low == high {
                        format!("{low}:\n")
                    } else {
                        format!("{low}..{high}:\n")
                    };
                    text(body, out);
                }
                *out += "ELSE\n";
                text(otherwise, out);
                *out += "END_CASE;\n";
            }
            Statement::For(variable, from, to, by, body) => {
                *out += &format!("FOR {variable} := {} TO {to} BY {by} DO\n", from.text());
                text(body, out);
                *out += "END_FOR;\n";
            }
            Statement::Counting(is_while, variable, end, body) => {
                *out += &format!("{variable} := 0;\n");
                *out += &if *is_while {
                    format!("WHILE {variable} < {end} DO\n")
                } else {
                    "REPEAT\n".to_owned()
                };
                *out += &format!("{variable} := {variable} + 1;\n");
                text(body, out);
                *out += &if *is_while {
                    "END_WHILE;\n".to_owned()
                } else {
                    format!("UNTIL {variable} >= {end} END_REPEAT;\n")
                };
            }
            Statement::Exit => *out += "EXIT;\n",
            Statement::Continue => *out += "CONTINUE;\n",
            Statement::Block(instance, _, inputs, [number, both], output) => {
                let output = output.as_ref().map_or(String::new(), |to| format!(", o => {to}"));
                *out += &format!(
                    "{instance}(p := {}, q := {}, r := {number}, z := {both}{output});\n",
                    inputs[0].text(),
                    inputs[1].text()
                );
            }
            Statement::Standard(instance, _, inputs) => {
                let inputs: Vec<String> = inputs
                    .iter()
                    .map(|(name, value)| format!("{name} := {}", value.text()))
                    .collect();
                *out += &format!("{instance}({});\n", inputs.join(", "));
            }
        }
    }
}

/// How a statement ends.
#[derive(PartialEq, Eq)]
enum Flow {
    On,
    Exit,
    Continue,
}

/// The state of a program, and what of it runs.
pub struct Machine<'a> {
    pub functions: &'a [Unit],
    pub blocks: &'a [Unit],
    /// Variables by their full names.
    pub state: BTreeMap<String, i64>,
    /// How many assignments were carried out.
    pub stores: u64,
    /// How many milliseconds have passed since the scan before.
    pub passed: i64,
    /// Whether the second operand of AND and OR is left out where the first one settles the result.
    pub skips: bool,
    /// At which store the power fails, and what stood in memory then.
    pub fails: Option<u64>,
    pub left: Option<BTreeMap<String, i64>>,
    /// Another task's statements, which run between those of this one, at random by these numbers.
    pub other: Option<(&'a [Statement], u64)>,
    /// Whether sums and products within an expression keep all of their bits until they are assigned or handed over.
    pub wide: bool,
    /// Whether the variable of FOR holds its last value behind the loop, not the one beyond the end.
    pub last: bool,
    /// Whether operands and arguments are worked out from right to left.
    pub right_first: bool,
    /// Whether the index of an assigned element is evaluated before the value.
    pub target_first: bool,
    calls: u64,
}

/// What names stand for: those that are handed over by reference, and what stands before all others.
#[derive(Clone, Default)]
pub struct Scope {
    prefix: String,
    references: BTreeMap<String, String>,
}

impl Scope {
    /// Where a unit's own names stand, and what it is handed in and out.
    pub fn within(prefix: &str, handed: impl Iterator<Item = (String, String)>) -> Scope {
        Scope { prefix: prefix.to_owned(), references: handed.collect() }
    }

    pub fn key(&self, name: &str) -> String {
        let (first, rest) = name.split_at(name.find(['.', '[']).unwrap_or(name.len()));
        match self.references.get(first) {
            Some(to) => format!("{to}{rest}"),
            None => format!("{}{name}", self.prefix),
        }
    }
}

impl<'a> Machine<'a> {
    pub fn new(functions: &'a [Unit], blocks: &'a [Unit]) -> Machine<'a> {
        Machine {
            functions,
            blocks,
            state: BTreeMap::new(),
            stores: 0,
            passed: 0,
            skips: false,
            fails: None,
            left: None,
            other: None,
            wide: false,
            last: false,
            right_first: false,
            target_first: false,
            calls: 0,
        }
    }

    pub fn get(&self, key: &str) -> i64 {
        self.state.get(key).copied().unwrap_or(0)
    }

    fn index(&mut self, scope: &Scope, name: &str, index: &Expr) -> String {
        let index = self.value(scope, index).clamp(0, 3);
        scope.key(&format!("{name}[{index}]"))
    }

    pub fn value(&mut self, scope: &Scope, expr: &Expr) -> i64 {
        let found = match &expr.of {
            Of::Literal(value) | Of::Typed(value) => *value,
            Of::Variable(name) => self.get(&scope.key(name)),
            Of::Element(name, index) => {
                let key = self.index(scope, name, index);
                self.get(&key)
            }
            Of::Not(inner) => !self.value(scope, inner),
            Of::Binary(operator, one, two) => {
                let [begin, end] = if self.right_first { [two, one] } else { [one, two] };
                let first = self.value(scope, begin);
                if self.skips && matches!((*operator, first), ("AND", 0) | ("OR", 1)) {
                    return first;
                }
                let second = self.value(scope, end);
                let (one, two) = if self.right_first { (second, first) } else { (first, second) };
                match *operator {
                    "+" => one + two,
                    "-" => one - two,
                    "*" => one.wrapping_mul(two),
                    "/" => one.checked_div(two).unwrap_or(0),
                    "MOD" => one.checked_rem(two).unwrap_or(0),
                    "AND" => one & two,
                    "OR" => one | two,
                    "XOR" => one ^ two,
                    "=" => i64::from(one == two),
                    "<>" => i64::from(one != two),
                    "<" => i64::from(one < two),
                    "<=" => i64::from(one <= two),
                    ">" => i64::from(one > two),
                    _ => i64::from(one >= two),
                }
            }
            Of::Standard(name, given) => {
                let given = self.values(scope, given);
                match name.as_str() {
                    "ABS" => given[0].abs(),
                    "MIN" => given[0].min(given[1]),
                    "MAX" => given[0].max(given[1]),
                    "LIMIT" => given[1].max(given[0]).min(given[2]),
                    "SEL" => given[if given[0] == 0 { 1 } else { 2 }],
                    _ => given[0],
                }
            }
            Of::Call(unit, input, both) => {
                let input = self.typed(scope, input);
                let both = scope.key(both);
                self.calls += 1;
                let prefix = format!("call {}.", self.calls);
                let references = BTreeMap::from([("c".to_owned(), both)]);
                self.state.insert(format!("{prefix}a"), input);
                let inner = Scope { prefix: prefix.clone(), references };
                let functions = self.functions;
                self.run(&inner, &functions[*unit].body);
                let result = self.get(&format!("{prefix}Fun{unit}"));
                self.state.retain(|key, _| !key.starts_with(&prefix));
                result
            }
        };
        let is_open = match &expr.of {
            Of::Binary(..) => true,
            Of::Standard(name, _) => !name.contains("_TO_"),
            _ => false,
        };
        if self.wide && is_open && expr.ty != BOOL { found } else { expr.ty.wrap(found) }
    }

    /// The values of some expressions, each worked out in its turn.
    fn values(&mut self, scope: &Scope, all: &[Expr]) -> Vec<i64> {
        let mut found = vec![0; all.len()];
        for number in 0..all.len() {
            let at = if self.right_first { all.len() - 1 - number } else { number };
            found[at] = self.value(scope, &all[at]);
        }
        found
    }

    /// The value of an expression as one of its type.
    fn typed(&mut self, scope: &Scope, expr: &Expr) -> i64 {
        let value = self.value(scope, expr);
        expr.ty.wrap(value)
    }

    pub fn set(&mut self, key: String, value: i64) {
        if self.fails == Some(self.stores) && self.left.is_none() {
            self.left = Some(self.state.clone());
        }
        self.stores += 1;
        self.state.insert(key, value);
    }

    pub fn run(&mut self, scope: &Scope, statements: &[Statement]) {
        self.all(scope, statements);
    }

    fn all(&mut self, scope: &Scope, statements: &[Statement]) -> Flow {
        for one in statements {
            let flow = self.statement(scope, one);
            if flow != Flow::On {
                return flow;
            }
        }
        Flow::On
    }

    /// Lets the other task run, or not.
    fn interrupt(&mut self) {
        let Some((statements, number)) = self.other.take() else { return };
        let number =
            number.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        if number >> 33 & 3 == 0 {
            let stores = self.stores;
            self.all(
                &Scope::within(
                    "other.",
                    OTHER.iter().map(|name| ((*name).to_owned(), (*name).to_owned())),
                ),
                statements,
            );
            self.stores = stores;
        }
        self.other = Some((statements, number));
    }

    fn statement(&mut self, scope: &Scope, one: &Statement) -> Flow {
        self.interrupt();
        match one {
            Statement::Assign(target, value) => {
                let value = self.typed(scope, value);
                self.set(scope.key(target), value);
            }
            Statement::Store(name, index, value) => {
                let before = self.target_first.then(|| self.index(scope, name, index));
                let value = self.typed(scope, value);
                let key = match before {
                    Some(key) => key,
                    None => self.index(scope, name, index),
                };
                self.set(key, value);
            }
            Statement::Copy(to, from) => {
                let (to, from) = (scope.key(to), scope.key(from));
                self.stores += 1;
                for part in [".b", ".n"] {
                    let value = self.get(&format!("{from}{part}"));
                    self.state.insert(format!("{to}{part}"), value);
                }
            }
            Statement::If(arms, otherwise) => {
                for (condition, body) in arms {
                    if self.value(scope, condition) == 1 {
                        return self.all(scope, body);
                    }
                }
                return self.all(scope, otherwise);
            }
            Statement::Case(of, arms, otherwise) => {
                let of = self.value(scope, of);
                let fits = arms.iter().find(|(low, high, _)| (*low..=*high).contains(&of));
                return self.all(scope, fits.map_or(otherwise, |(.., body)| body));
            }
            Statement::For(variable, from, to, by, body) => {
                let key = scope.key(variable);
                let first = self.typed(scope, from);
                self.state.insert(key.clone(), first);
                let mut goes_round = false;
                loop {
                    let at = self.get(&key);
                    if (*by > 0 && at > *to) || (*by < 0 && at < *to) {
                        if self.last && goes_round {
                            self.state.insert(key, at - by);
                        }
                        break;
                    }
                    goes_round = true;
                    if self.all(scope, body) == Flow::Exit {
                        break;
                    }
                    let next = self.get(&key) + by;
                    self.state.insert(key.clone(), next);
                }
            }
            Statement::Counting(is_while, variable, end, body) => {
                let key = scope.key(variable);
                self.state.insert(key.clone(), 0);
                while !is_while || self.get(&key) < *end {
                    let next = self.get(&key) + 1;
                    self.state.insert(key.clone(), next);
                    if self.all(scope, body) == Flow::Exit || (!is_while && next >= *end) {
                        break;
                    }
                }
            }
            Statement::Exit => return Flow::Exit,
            Statement::Continue => return Flow::Continue,
            Statement::Block(instance, unit, inputs, [number, both], output) => {
                let prefix = scope.key(instance) + ".";
                let given = self.values(scope, inputs);
                self.state.insert(format!("{prefix}p"), inputs[0].ty.wrap(given[0]));
                self.state.insert(format!("{prefix}q"), inputs[1].ty.wrap(given[1]));
                let references =
                    [("r".to_owned(), scope.key(number)), ("z".to_owned(), scope.key(both))];
                let inner = Scope { prefix: prefix.clone(), references: references.into() };
                let blocks = self.blocks;
                self.run(&inner, &blocks[*unit].body);
                if let Some(to) = output {
                    let value = self.get(&format!("{prefix}o"));
                    self.set(scope.key(to), value);
                }
            }
            Statement::Standard(instance, kind, inputs) => {
                let prefix = scope.key(instance) + ".";
                for number in 0..inputs.len() {
                    let at = if self.right_first { inputs.len() - 1 - number } else { number };
                    let (name, value) = &inputs[at];
                    let value = self.typed(scope, value);
                    self.state.insert(format!("{prefix}{name}"), value);
                }
                self.standard(kind, &prefix);
            }
        }
        Flow::On
    }

    /// A standard block as the standard writes its body.
    pub fn standard(&mut self, kind: &str, at: &str) {
        let get = |name: &str| self.get(&format!("{at}{name}"));
        let on = |name: &str| get(name) == 1;
        let mut after: Vec<(&str, i64)> = Vec::new();
        match kind {
            "R_TRIG" => {
                after = vec![("Q", i64::from(on("CLK") && !on("m"))), ("m", get("CLK"))];
            }
            // The memory begins as if the clock had been off.
            "F_TRIG" => {
                after = vec![("Q", i64::from(!on("CLK") && on("m"))), ("m", get("CLK"))];
            }
            "SR" => after.push(("Q1", i64::from(on("S1") || (!on("R") && on("Q1"))))),
            "RS" => after.push(("Q1", i64::from(!on("R1") && (on("S") || on("Q1"))))),
            "CTU" => {
                let count = match (on("R"), on("CU") && !on("m")) {
                    (true, _) => 0,
                    (false, true) if get("CV") < 32767 => get("CV") + 1,
                    _ => get("CV"),
                };
                let full = i64::from(count >= get("PV"));
                after = vec![("CV", count), ("Q", full), ("m", get("CU"))];
            }
            "CTD" => {
                let count = match (on("LD"), on("CD") && !on("m")) {
                    (true, _) => get("PV"),
                    (false, true) if get("CV") > -32768 => get("CV") - 1,
                    _ => get("CV"),
                };
                after = vec![("CV", count), ("Q", i64::from(count <= 0)), ("m", get("CD"))];
            }
            "TON" => {
                let elapsed = if on("IN") && on("m") { get("t") + self.passed } else { 0 };
                let elapsed = elapsed.min(get("PT"));
                let over = i64::from(on("IN") && elapsed >= get("PT"));
                after = vec![("t", elapsed), ("Q", over), ("m", get("IN"))];
            }
            "TOF" => {
                let begins = !on("IN") && on("m");
                let runs = !on("IN") && on("Q") && !begins;
                let elapsed = if runs { get("t") + self.passed } else { 0 };
                let held = on("Q") && !on("IN") && elapsed < get("PT");
                after = vec![("t", elapsed), ("Q", i64::from(on("IN") || held)), ("m", get("IN"))];
            }
            _ => {
                let elapsed = if on("Q") { get("t") + self.passed } else { 0 };
                let goes_on = on("Q") && elapsed < get("PT");
                let begins = !on("Q") && on("IN") && !on("m") && get("PT") > 0;
                after = vec![("t", elapsed), ("Q", i64::from(goes_on || begins)), ("m", get("IN"))];
            }
        }
        for (name, value) in after {
            self.state.insert(format!("{at}{name}"), value);
        }
    }
}
