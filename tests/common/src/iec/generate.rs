//! Random drawings, lists and charts, and the projects that hold them.

use super::control;
use super::drawn::{Drawing, Edge, Input, Manner, Mode, Pin, Run, What, outputs};
use super::list::{self, Instruction, When};
use super::machine::{self, BOOL, DINT, Expr, INT, Machine, Of, Statement, Ty, USINT, Unit};
use super::ring::Ring;
use std::fmt::Write;

pub struct Dice(u64);

impl Dice {
    pub fn new(seed: u64) -> Dice {
        let mut dice = Dice(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1);
        (0..4).for_each(|_| _ = dice.below(2));
        dice
    }

    pub fn below(&mut self, most: usize) -> usize {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        usize::try_from((self.0 >> 11) % most as u64).expect("small")
    }

    pub fn chance(&mut self, of: usize) -> bool {
        self.below(of) == 0
    }

    pub fn one<T: Clone>(&mut self, of: &[T]) -> T {
        of[self.below(of.len())].clone()
    }
}

pub const INPUTS: &[(&str, Ty)] = &[("in0", BOOL), ("in1", BOOL), ("in2", INT)];
pub const GLOBALS: &[(&str, Ty)] = &[
    ("b0", BOOL),
    ("b1", BOOL),
    ("b2", BOOL),
    ("n0", INT),
    ("n1", INT),
    ("n2", INT),
    ("d0", DINT),
    ("u0", USINT),
    ("st.b", BOOL),
    ("st.n", INT),
];
/// What variables hold at first, if not 0.
const INITIAL: &[(&str, &str, i64)] = &[("b2", "TRUE", 1), ("n1", "3", 3)];
pub const STANDARD: &[(&str, &str)] = &[
    ("rt", "R_TRIG"),
    ("ft", "F_TRIG"),
    ("sr", "SR"),
    ("rs", "RS"),
    ("cu", "CTU"),
    ("cd", "CTD"),
    ("on", "TON"),
    ("off", "TOF"),
    ("tp", "TP"),
];
/// What it takes to give timers their times, which a program of its own does.
pub const PRESETS: u64 = 3;
const BITS: &[&str] = &["b0", "b1", "b2"];
const NUMBERS: &[(Ty, &[&str])] = &[(INT, &["n0", "n1", "n2"]), (DINT, &["d0"]), (USINT, &["u0"])];

pub fn variable(name: &str, ty: Ty) -> Expr {
    Expr { ty, of: Of::Variable(name.to_owned()) }
}

/// A truth value to read; only plain variables, where all states are run.
pub fn bit(dice: &mut Dice, plain: bool) -> &'static str {
    let outputs = ["rt.Q", "ft.Q", "sr.Q1", "cu.Q", "on.Q", "off.Q", "tp.Q", "st.b"];
    match dice.below(3) {
        0 => dice.one(&["in0", "in1"]),
        1 if !plain => dice.one(&outputs),
        _ => dice.one(BITS),
    }
}

fn number(dice: &mut Dice, ty: Ty) -> Expr {
    let own = NUMBERS.iter().find(|one| one.0 == ty).expect("a type").1;
    match dice.below(4) {
        0 => Expr { ty, of: Of::Literal(i64::try_from(dice.below(6)).expect("small")) },
        1 if ty == INT => variable(dice.one(&["in2", "cu.CV", "st.n"]), INT),
        _ => variable(dice.one(own), ty),
    }
}

/// A number that has its type by itself.
fn typed(dice: &mut Dice, ty: Ty) -> Expr {
    let own = NUMBERS.iter().find(|one| one.0 == ty).expect("a type").1;
    variable(dice.one(own), ty)
}

fn edge(dice: &mut Dice) -> Edge {
    match dice.below(8) {
        0 => Edge::Rising,
        1 => Edge::Falling,
        _ => Edge::None,
    }
}

fn inputs_of(kind: &str) -> &'static [&'static str] {
    match kind {
        "R_TRIG" | "F_TRIG" => &["CLK"],
        "SR" => &["S1", "R"],
        "RS" => &["S", "R1"],
        "CTU" => &["CU", "R", "PV"],
        "CTD" => &["CD", "LD", "PV"],
        _ => &["IN"],
    }
}

/// What a generator adds to.
struct Draw<'d> {
    dice: &'d mut Dice,
    to: Drawing,
    /// Nothing but truth values, and nothing that is not followed exactly.
    plain: bool,
    blocks: bool,
    labels: Vec<&'static str>,
}

impl Draw<'_> {
    fn wire(&mut self, value: Expr) -> Pin {
        (self.to.add(What::In(value, false)), "")
    }

    /// A truth value that is wired up.
    fn wire_bit(&mut self) -> Pin {
        let name = bit(self.dice, self.plain);
        self.wire(variable(name, BOOL))
    }

    fn input(&mut self, name: &'static str, from: Vec<Pin>) -> Input {
        Input { name, from, negated: false, edge: Edge::None }
    }

    fn condition(&mut self, name: &'static str, from: Vec<Pin>) -> Input {
        let negated = self.dice.chance(4);
        Input { name, from, negated, edge: edge(self.dice) }
    }

    fn standard(&mut self, first: Vec<Pin>, enable: Option<Vec<Pin>>) -> Pin {
        let some: &[(&str, &str)] = if self.plain { &STANDARD[..4] } else { STANDARD };
        let (name, kind) = self.dice.one(some);
        let inputs = inputs_of(kind).iter().enumerate().map(|(at, input)| match at {
            0 => self.condition(input, first.clone()),
            _ if *input == "PV" => {
                let value = number(self.dice, INT);
                let from = self.wire(value);
                self.input(input, vec![from])
            }
            _ => {
                let from = self.wire_bit();
                self.condition(input, vec![from])
            }
        });
        let inputs = inputs.collect();
        let id = self.to.add(What::Standard(name, kind, enable, inputs));
        (id, outputs(kind)[0])
    }

    /// An own block: its inputs, and two variables in and out.
    fn block(&mut self, first: Vec<Pin>, enable: Option<Vec<Pin>>) -> Pin {
        let p = number(self.dice, INT);
        let p = self.wire(p);
        let handed = self.dice.one(&["n0", "n2"]);
        let number = self.wire(variable(handed, INT));
        let whole = self.wire(variable("st", INT));
        let inputs = vec![self.input("p", vec![p]), self.condition("q", first)];
        let (name, unit) = self.dice.one(&[("fb0", 0), ("fb1", 1), ("fb2", 0)]);
        let id = self.to.add(What::Block(name, unit, enable, inputs, [number, whole]));
        (id, "ENO")
    }

    /// A function of numbers, whose result goes to a variable; its ENO.
    fn number(&mut self, enable: Option<Vec<Pin>>) -> Pin {
        let ty = self.dice.one(&[INT, INT, DINT, USINT]);
        let name =
            self.dice.one(&["MOVE", "ADD", "SUB", "MUL", "SEL", "MAX", "LIMIT", "GT", "EQ", "LT"]);
        let own = typed(self.dice, ty);
        let mut values = vec![own];
        let (names, result): (&[&'static str], Ty) = match name {
            "MOVE" => (&["IN"], ty),
            "SEL" => (&["G", "IN0", "IN1"], ty),
            "LIMIT" => (&["MN", "IN", "MX"], ty),
            "GT" | "EQ" | "LT" => (&["IN1", "IN2"], BOOL),
            _ => (&["IN1", "IN2"], ty),
        };
        while values.len() < names.len() {
            values.push(number(self.dice, ty));
        }
        if name == "SEL" {
            values[0] = variable(bit(self.dice, self.plain), BOOL);
            values[1] = typed(self.dice, ty);
        }
        let mut inputs: Vec<Input> = names
            .iter()
            .zip(values)
            .map(|(name, value)| {
                let from = self.wire(value);
                self.input(name, vec![from])
            })
            .collect();
        // Inputs may stand in any order: they have names. The run takes them in that of the function.
        let reversed =
            !["SEL", "GT", "LT"].contains(&name) && enable.is_none() && self.dice.chance(4);
        let has_enable = enable.is_some();
        if reversed {
            inputs.reverse();
        }
        let id = self.to.add(What::Function(name, result, enable, inputs));
        if result == BOOL {
            let target = self.dice.one(BITS);
            let negated = self.dice.chance(20);
            self.to.add(What::Out(target, negated, vec![(id, "OUT")]));
        } else {
            let own = NUMBERS.iter().find(|one| one.0 == ty).expect("a type").1;
            let target = self.dice.one(own);
            self.to.add(What::Out(target, false, vec![(id, "OUT")]));
        }
        if has_enable { (id, "ENO") } else { (id, "OUT") }
    }

    fn contacts(&mut self, from: &[Pin]) -> Vec<Pin> {
        let count = if self.dice.chance(3) { 2 + self.dice.below(2) } else { 1 };
        (0..count)
            .map(|_| {
                let what = What::Contact(
                    bit(self.dice, self.plain),
                    self.dice.chance(3),
                    edge(self.dice),
                    from.to_vec(),
                );
                (self.to.add(what), "")
            })
            .collect()
    }

    fn coil(&mut self, from: &[Pin]) -> Pin {
        let mode =
            self.dice.one(&[Mode::Plain, Mode::Plain, Mode::Negated, Mode::Set, Mode::Reset]);
        let what = What::Coil(self.dice.one(BITS), mode, edge(self.dice), from.to_vec());
        (self.to.add(what), "")
    }

    fn rung(&mut self, rail: usize, next: Option<&'static str>) {
        let mut from = vec![(rail, "")];
        for _ in 0..1 + self.dice.below(3) {
            let before = from.clone();
            from = self.contacts(&from);
            match self.dice.below(9) {
                // A way past the contacts.
                0 => from.push(before[0]),
                // A coil in the midst, and what stands behind it.
                1 => from = vec![self.coil(&from)],
                2 => _ = self.coil(&from),
                3 => from = vec![self.standard(from, None)],
                4 => {
                    let first = vec![self.wire_bit()];
                    let out = self.standard(first, Some(from));
                    from = vec![(out.0, self.dice.one(&["ENO", out.1]))];
                }
                5 if !self.plain => from = vec![self.number(Some(from))],
                6 if self.blocks => {
                    let first = vec![self.wire_bit()];
                    from = vec![self.block(first, Some(from))];
                }
                _ => {}
            }
        }
        match (next, self.dice.below(6)) {
            (Some(label), 0) => {
                self.to.add(What::Jump(label, from));
                self.labels.push(label);
            }
            (_, 1) if self.dice.chance(2) => _ = self.to.add(What::Return(from)),
            _ => {
                for _ in 0..1 + self.dice.below(2) {
                    self.coil(&from);
                }
            }
        }
    }

    fn gate(&mut self, pins: &[Pin]) -> Pin {
        let name = self.dice.one(&["AND", "OR", "XOR", "NOT"]);
        let names: &[&'static str] = if name == "NOT" { &["IN"] } else { &["IN1", "IN2", "IN3"] };
        let count = if name == "NOT" { 1 } else { 2 + self.dice.below(2) };
        let inputs = names[..count].iter().map(|name| {
            let from = match pins {
                [_, ..] if self.dice.chance(2) => self.dice.one(pins),
                _ => self.wire_bit(),
            };
            let negated = self.dice.chance(4);
            Input { name, from: vec![from], negated, edge: Edge::None }
        });
        let inputs = inputs.collect();
        (self.to.add(What::Function(name, BOOL, None, inputs)), "OUT")
    }

    fn network(&mut self) {
        let mut pins: Vec<Pin> = Vec::new();
        for _ in 0..1 + self.dice.below(3) {
            let pin = match self.dice.below(6) {
                0 if !self.plain => {
                    self.number(None);
                    continue;
                }
                1 if !pins.is_empty() => {
                    let first = vec![self.dice.one(&pins)];
                    self.standard(first, None)
                }
                2 if !pins.is_empty() && !self.plain => {
                    let enable = vec![self.dice.one(&pins)];
                    self.number(Some(enable))
                }
                3 if !pins.is_empty() && self.blocks => {
                    let first = vec![self.dice.one(&pins)];
                    self.block(first, None);
                    continue;
                }
                _ => self.gate(&pins),
            };
            pins.push(pin);
        }
        for _ in 0..1 + self.dice.below(2) {
            if !pins.is_empty() {
                let what = What::Out(
                    self.dice.one(BITS),
                    self.dice.chance(20),
                    vec![self.dice.one(&pins)],
                );
                self.to.add(what);
            }
        }
    }
}

const LABELS: &[&str] = &["one", "two", "three", "four"];

/// A ladder diagram, or a function block diagram.
fn drawing(dice: &mut Dice, is_ladder: bool, plain: bool, blocks: bool) -> Drawing {
    let mut draw = Draw { dice, to: Drawing::default(), plain, blocks, labels: Vec::new() };
    draw.to.numbered = draw.dice.chance(2);
    let count = if plain { 1 + draw.dice.below(2) } else { 2 + draw.dice.below(3) };
    let rail = if is_ladder { draw.to.add(What::Rail) } else { 0 };
    for (at, label) in LABELS.iter().enumerate().take(count) {
        if draw.labels.contains(label) {
            draw.to.add(What::Label(label));
        }
        // The last one goes nowhere.
        let next = LABELS.get(at + 1).copied().filter(|_| at + 1 < count);
        if is_ladder { draw.rung(rail, next) } else { draw.network() }
    }
    draw.to
}

/// A list; whether it is a condition, which stores nothing.
pub fn instructions(dice: &mut Dice, plain: bool, is_condition: bool) -> Vec<Instruction> {
    use Instruction as I;
    let mut all = Vec::new();
    let of_bit = |dice: &mut Dice| variable(bit(dice, plain), BOOL);
    let mut open: Vec<&'static str> = Vec::new();
    let mut labels = LABELS.iter();
    let count = if is_condition { 1 } else { 2 + dice.below(if plain { 2 } else { 5 }) };
    for at in 0..count {
        let last = at + 1 == count;
        // Numbers, and what is told of them.
        if !plain && dice.chance(3) {
            let ty = dice.one(&[INT, INT, DINT, USINT]);
            all.push(I::Load(typed(dice, ty), false));
            for _ in 0..dice.below(3) {
                all.push(match dice.below(4) {
                    0 => I::Function(dice.one(&["MAX", "MIN"]), vec![number(dice, ty)]),
                    1 => I::Number(
                        dice.one(&["MUL", "DIV", "MOD"]),
                        Expr {
                            ty,
                            of: Of::Literal(1 + i64::try_from(dice.below(4)).expect("small")),
                        },
                    ),
                    _ => I::Number(dice.one(&["ADD", "SUB"]), number(dice, ty)),
                });
            }
            let own = NUMBERS.iter().find(|one| one.0 == ty).expect("a type").1;
            if !is_condition {
                all.push(I::Store(dice.one(own), false));
            }
            all.push(I::Number(dice.one(&["GT", "GE", "EQ", "NE", "LE", "LT"]), number(dice, ty)));
        } else {
            all.push(I::Load(of_bit(dice), dice.chance(3)));
        }
        for _ in 0..dice.below(3) {
            let of = dice.one(&["AND", "OR", "XOR"]);
            let negated = dice.chance(3);
            all.push(match dice.below(4) {
                0 => {
                    let inner = vec![
                        I::Load(of_bit(dice), dice.chance(3)),
                        I::Logic(dice.one(&["AND", "OR"]), dice.chance(3), of_bit(dice)),
                    ];
                    I::Group(of, negated, inner)
                }
                1 => I::Not,
                _ => I::Logic(of, negated, of_bit(dice)),
            });
        }
        if is_condition {
            return all;
        }
        for _ in 0..dice.below(3) {
            all.push(match dice.below(6) {
                0 => I::Set(dice.one(BITS)),
                1 => I::Reset(dice.one(BITS)),
                2 => {
                    let (name, kind) = dice.one(if plain { &STANDARD[..4] } else { STANDARD });
                    let when = dice.one(&[When::Always, When::True, When::False]);
                    let inputs = inputs_of(kind).iter().map(|input| match *input {
                        "PV" => (*input, number(dice, INT)),
                        _ => (*input, variable(bit(dice, plain), BOOL)),
                    });
                    let inputs = inputs.collect();
                    I::Call(when, name, kind, inputs)
                }
                3 => I::Hand("CLK", dice.one(&["rt", "rt"]), "R_TRIG"),
                _ => I::Store(dice.one(BITS), dice.chance(4)),
            });
        }
        if !last && dice.chance(3) {
            if let Some(label) = labels.next() {
                let when = dice.one(&[When::True, When::False, When::True, When::Always]);
                all.push(I::Jump(when, label));
                open.push(label);
            }
        } else if dice.chance(8) {
            all.push(I::Return(dice.one(&[When::True, When::False])));
        }
        // What jumps meet here, some with the result that they bring.
        if !open.is_empty() && (last || dice.chance(2)) {
            if dice.chance(2) {
                all.push(I::Load(of_bit(dice), false));
            }
            for label in open.drain(..) {
                all.push(I::Label(label));
            }
            if dice.chance(2) {
                all.push(I::Logic(dice.one(&["AND", "OR"]), dice.chance(3), of_bit(dice)));
            }
            all.push(I::Store(dice.one(BITS), false));
        }
    }
    all
}

/// What a program, an action or a transition is written in.
#[derive(Debug, Clone)]
pub enum Code {
    Ladder(Drawing),
    Blocks(Drawing),
    List(Vec<Instruction>),
    Text(Vec<Statement>),
}

impl Code {
    pub fn new(dice: &mut Dice, which: usize, plain: bool, blocks: bool) -> Code {
        match which {
            0 => Code::Ladder(drawing(dice, true, plain, blocks)),
            1 => Code::Blocks(drawing(dice, false, plain, blocks)),
            2 => Code::List(instructions(dice, plain, false)),
            _ => {
                let value = variable(bit(dice, plain), BOOL);
                Code::Text(vec![Statement::Assign(dice.one(BITS).to_owned(), value)])
            }
        }
    }

    pub fn xml(&self) -> String {
        match self {
            Code::Ladder(drawing) => format!("<LD>{}</LD>", drawing.xml()),
            Code::Blocks(drawing) => format!("<FBD>{}</FBD>", drawing.xml()),
            Code::List(list) => format!("<IL><p>{}</p></IL>", list::text(list)),
            Code::Text(statements) => {
                let mut text = String::new();
                machine::text(statements, &mut text);
                format!("<ST><p>{text}</p></ST>")
            }
        }
    }

    pub fn scan(&self, machine: &mut Machine<'_>, name: &str, manner: Manner) -> u64 {
        match self {
            Code::Ladder(drawing) | Code::Blocks(drawing) => {
                Run::scan(drawing, machine, name, manner)
            }
            Code::List(list) => list::scan(list, machine).0,
            Code::Text(statements) => {
                let before = machine.stores;
                machine.run(&machine::Scope::default(), statements);
                machine.stores - before
            }
        }
    }

    /// The memory of edges that the drawing has by itself.
    fn edges(&self) -> Vec<String> {
        let (Code::Ladder(drawing) | Code::Blocks(drawing)) = self else { return Vec::new() };
        let mut found = Vec::new();
        for (id, what) in drawing.elements.iter().enumerate() {
            match what {
                What::Contact(_, _, kind, _) | What::Coil(_, _, kind, _) if *kind != Edge::None => {
                    found.push(format!("edge {id}.m"));
                }
                What::Standard(_, _, _, inputs) | What::Block(_, _, _, inputs, _) => {
                    let own = inputs.iter().filter(|one| one.edge != Edge::None);
                    found.extend(own.map(|one| format!("edge {id} {}.m", one.name)));
                }
                _ => {}
            }
        }
        found
    }
}

#[derive(Debug, Clone)]
pub enum Body {
    Code(Code),
    Chart(Ring),
}

/// A project.
pub struct Case {
    pub body: Body,
    pub blocks: Vec<Unit>,
}

/// A project that runs.
pub struct Running<'c> {
    case: &'c Case,
    manner: Manner,
    /// The order in which actions are carried out that run in one scan, by their numbers, where it is not that in which
    /// the chart names them.
    pub order: Option<[usize; 3]>,
    /// The step of a chart that is active, once it has begun.
    step: Option<usize>,
}

impl Running<'_> {
    /// One scan: what it takes, at least.
    pub fn scan(&mut self, machine: &mut Machine<'_>) -> u64 {
        let ring = match &self.case.body {
            Body::Code(code) => return code.scan(machine, "", self.manner),
            Body::Chart(ring) => ring,
        };
        let step = match self.step {
            None => 0,
            Some(step) => {
                // All that leave the step are looked at; the first that holds clears.
                let ways = ring.transitions.iter().filter(|way| way.0 == step);
                { ways }.find(|way| way.2.holds(machine)).map_or(step, |way| way.1)
            }
        };
        self.step = Some(step);
        let mut order: Vec<usize> = Vec::new();
        for (action, _) in ring.blocks.iter().flatten() {
            if !order.contains(action) {
                order.push(*action);
            }
        }
        // All controls are worked out before the first action is carried out.
        if let Some(own) = self.order {
            order.sort_by_key(|action| own.iter().position(|one| one == action));
        }
        let runs: Vec<usize> = order
            .into_iter()
            .filter(|&action| {
                let active = |qualifier: &str| ring.blocks[step].contains(&(action, qualifier));
                control::runs(machine, &format!("control {action} "), ring.times[action], &active)
            })
            .collect();
        let mut cost = 0;
        for action in runs {
            let name = format!("act{action}:");
            cost += ring.actions[action].scan(machine, &name, self.manner);
        }
        cost
    }
}

impl Case {
    pub fn new(dice: &mut Dice, seed: u64, plain: bool) -> Case {
        let which = usize::try_from(seed % if plain { 3 } else { 5 }).expect("small");
        let body = match which {
            3.. => Body::Chart(Ring::new(dice)),
            _ => Body::Code(Code::new(dice, which, plain, !plain)),
        };
        Case { body, blocks: vec![unit(dice), unit(dice)] }
    }

    pub fn run(&self, manner: Manner) -> Running<'_> {
        Running { case: self, manner, order: None, step: None }
    }

    /// The state at power-up.
    pub fn power_up(&self, machine: &mut Machine<'_>) {
        for (name, _, value) in INITIAL {
            machine.state.insert((*name).to_owned(), *value);
        }
        for name in ["on", "off", "tp"] {
            machine.state.insert(format!("{name}.PT"), 20);
        }
    }

    /// All truth values that a scan may read, where there is nothing else.
    pub fn memory(&self) -> Vec<String> {
        let Body::Code(code) = &self.body else { return Vec::new() };
        let mut all: Vec<String> =
            ["in0", "in1"].iter().chain(BITS).map(|one| (*one).to_owned()).collect();
        let written = code.xml();
        for (name, kind) in &STANDARD[..4] {
            if written.contains(&format!("\"{name}\"")) || written.contains(&format!(" {name}")) {
                let output = outputs(kind)[0];
                all.push(format!("{name}.{output}"));
                if kind.ends_with("TRIG") {
                    all.push(format!("{name}.m"));
                }
            }
        }
        all.extend(code.edges());
        all
    }

    /// The project as XML, with statements behind its program.
    pub fn xml(&self, probe: &str) -> String {
        let initial = |name: &str| {
            let own = INITIAL.iter().find(|one| one.0 == name);
            own.map_or(String::new(), |(_, text, _)| {
                format!("<initialValue><simpleValue value=\"{text}\"/></initialValue>")
            })
        };
        let plain = |name: &str, ty: &str, more: &str| {
            format!(
                "<variable name=\"{name}\"{more}><type><{ty}/></type>{}</variable>",
                initial(name)
            )
        };
        let of = |name: &str, ty: &str| {
            format!("<variable name=\"{name}\"><type><derived name=\"{ty}\"/></type></variable>")
        };
        let mut globals = String::new();
        for ((name, ty), address) in INPUTS.iter().zip(["%IX0.0", "%IX0.1", "%IW2"]) {
            globals += &plain(name, ty.name(), &format!(" address=\"{address}\""));
        }
        for (name, ty) in GLOBALS.iter().filter(|one| !one.0.contains('.')) {
            globals += &plain(name, ty.name(), "");
        }
        globals += &of("st", "S");
        globals += &plain("probe", "REAL", "");
        let mut own: String = STANDARD.iter().map(|(name, kind)| of(name, kind)).collect();
        for (name, unit) in [("fb0", "Block0"), ("fb1", "Block1"), ("fb2", "Block0")] {
            own += &of(name, unit);
        }
        own += &plain("presets", "BOOL", "");
        let mut units = String::new();
        for (number, unit) in self.blocks.iter().enumerate() {
            let mut text = String::new();
            machine::text(&unit.body, &mut text);
            let text = text.replace('<', "&lt;");
            let _ = write!(
                units,
                "<pou name=\"Block{number}\" pouType=\"functionBlock\"><interface><inputVars>{}{}</inputVars><inOutVars>{}{}</inOutVars>\
                 <outputVars>{}</outputVars><localVars>{}</localVars></interface><body><ST><p>{text}</p></ST></body></pou>",
                plain("p", "INT", ""),
                plain("q", "BOOL", ""),
                plain("r", "INT", ""),
                of("z", "S"),
                plain("o", "INT", ""),
                plain("k", "INT", ""),
            );
        }
        let (body, actions) = match &self.body {
            Body::Code(code) => (code.xml(), String::new()),
            Body::Chart(ring) => ring.xml(),
        };
        format!(
            "<project xmlns=\"http://www.plcopen.org/xml/tc6_0201\"><types><dataTypes><dataType name=\"S\"><baseType><struct>{}{}\
             </struct></baseType></dataType></dataTypes><pous>{units}\
             <pou name=\"presets\" pouType=\"program\"><interface/><body><ST><p>main.on.PT := T#20ms; main.off.PT := T#20ms; main.tp.PT := T#20ms;</p></ST></body></pou>\
             <pou name=\"main\" pouType=\"program\"><interface><localVars>{own}</localVars></interface><actions>{actions}</actions><body>{body}</body></pou>\
             <pou name=\"probing\" pouType=\"program\"><interface/><body><ST><p>{}</p></ST></body></pou>\
             </pous></types><instances><configurations><configuration name=\"c\"><resource name=\"r\"><globalVars>{globals}</globalVars>\
             </resource></configuration></configurations></instances></project>",
            plain("b", "BOOL", ""),
            plain("n", "INT", ""),
            probe.replace('<', "&lt;")
        )
    }
}

/// The body of a block of one's own.
fn unit(dice: &mut Dice) -> Unit {
    let int = |name: &str| variable(name, INT);
    let binary = |of, one, two, ty| Expr { ty, of: Of::Binary(of, Box::new(one), Box::new(two)) };
    let all = [
        Statement::Assign("r".to_owned(), binary("+", int("r"), int("p"), INT)),
        Statement::Assign("k".to_owned(), binary("+", int("k"), int("z.n"), INT)),
        Statement::Assign("o".to_owned(), int("k")),
        Statement::Assign("z.b".to_owned(), variable("q", BOOL)),
        Statement::Assign("z.n".to_owned(), int("r")),
        Statement::If(
            vec![(
                binary(">", int("r"), int("k"), BOOL),
                vec![Statement::Assign("z.n".to_owned(), int("p"))],
            )],
            vec![Statement::Assign("r".to_owned(), int("o"))],
        ),
    ];
    Unit { body: (0..3).map(|_| dice.one(&all)).collect() }
}

/// Puts anything into the variables and the blocks.
pub fn any_state(machine: &mut Machine<'_>, dice: &mut Dice) {
    let mut put = |name: String, ty: Ty, dice: &mut Dice| {
        let value = i64::try_from(dice.below(1 << 16)).expect("small");
        machine.state.insert(name, ty.wrap(value));
    };
    for (name, ty) in GLOBALS {
        put((*name).to_owned(), *ty, dice);
    }
    for (name, kind) in STANDARD {
        put(format!("{name}.{}", outputs(kind)[0]), BOOL, dice);
        put(format!("{name}.m"), BOOL, dice);
        if kind.starts_with("CT") {
            put(format!("{name}.CV"), INT, dice);
        }
    }
}
