//! Random programs in structured text, with function blocks, functions, arrays, structures, enumerations, subranges,
//! loops, timers, counters and edges, what is kept when the power fails, and another task that shares variables: run
//! scan by scan by an interpreter that knows nothing of the analysis. Where a run ends with some values, a scan that
//! ends with them is among those that the bound is about, and none of them takes longer than the bound.
//!
//! `SCANBOUND_CASES=100 cargo test --release --test random iec_random::` runs more of them.

use common::iec::generate::Dice;
use common::iec::machine;
use common::iec::probe::{self, PROBE, audited};
use common::tape::{cases, seeds};

use machine::{
    BOOL, COLOUR, COLOURS, DINT, Expr, INT, Machine, Of, SINT, Scope, Statement, Ty, UINT, USINT,
    Unit,
};
use scanbound::passes::values::Trust;
use std::collections::BTreeMap;

/// What statements of a unit can name.
#[derive(Clone, Default)]
struct Names {
    read: Vec<(String, Ty)>,
    write: Vec<(String, Ty)>,
    arrays: Vec<(&'static str, Ty)>,
    structures: Vec<String>,
    /// Numbers for loops, which nothing else writes.
    counters: Vec<String>,
    functions: usize,
    /// Whole numbers that may be handed over in and out.
    handed: Vec<String>,
    /// Instances: name, unit.
    blocks: Vec<(&'static str, usize)>,
    standard: Vec<(&'static str, &'static str)>,
}

fn typed(names: &[(String, Ty)], ty: Ty) -> Vec<String> {
    names.iter().filter(|one| one.1 == ty).map(|one| one.0.clone()).collect()
}

fn expr(ty: Ty, of: Of) -> Expr {
    Expr { ty, of }
}

fn literal(dice: &mut Dice, ty: Ty) -> Expr {
    let small = i64::try_from(dice.below(8)).expect("small");
    let value = match ty {
        BOOL => small & 1,
        COLOUR => COLOURS[dice.below(COLOURS.len())].1,
        _ if dice.chance(6) => ty.wrap(i64::try_from(dice.below(1 << 20)).expect("small")).max(0),
        _ => small,
    };
    expr(ty, Of::Literal(value))
}

/// An expression of a type. Literals stand only beside what has a type of its own.
fn value(dice: &mut Dice, names: &Names, ty: Ty, depth: usize) -> Expr {
    let variables = typed(&names.read, ty);
    if depth == 0 || dice.chance(3) {
        let arrays: Vec<_> = names.arrays.iter().filter(|one| one.1 == ty).collect();
        if depth > 0 && !arrays.is_empty() && dice.chance(3) {
            let array = arrays[dice.below(arrays.len())].0;
            return expr(ty, Of::Element(array, Box::new(value(dice, names, INT, 0))));
        }
        return match variables.is_empty() {
            true => typed_literal(dice, ty),
            false => expr(ty, Of::Variable(dice.one(&variables))),
        };
    }
    let boxed = |one| Box::new(one);
    if ty == COLOUR {
        let given = vec![
            value(dice, names, BOOL, depth - 1),
            value(dice, names, COLOUR, 0),
            value(dice, names, COLOUR, 0),
        ];
        return expr(ty, Of::Standard("SEL".to_owned(), given));
    }
    if ty == BOOL {
        return match dice.below(6) {
            5 if !typed(&names.read, COLOUR).is_empty() => {
                let one = value(dice, names, COLOUR, 0);
                let two = value(dice, names, COLOUR, 0);
                expr(BOOL, Of::Binary(dice.one(&["=", "<>"]), boxed(one), boxed(two)))
            }
            0 => expr(BOOL, Of::Not(boxed(value(dice, names, BOOL, depth - 1)))),
            1 | 2 => {
                let of = dice.one(&[INT, INT, DINT, UINT, SINT, USINT]);
                let operator = dice.one(&["=", "<>", "<", "<=", ">", ">="]);
                let one = value(dice, names, of, depth - 1);
                let two = beside(dice, names, of, depth - 1);
                expr(BOOL, Of::Binary(operator, boxed(one), boxed(two)))
            }
            _ => {
                let operator = dice.one(&["AND", "OR", "XOR"]);
                let one = value(dice, names, BOOL, depth - 1);
                let two = value(dice, names, BOOL, depth - 1);
                expr(BOOL, Of::Binary(operator, boxed(one), boxed(two)))
            }
        };
    }
    match dice.below(9) {
        0 | 1 => {
            let operator = dice.one(&["+", "-"]);
            let one = value(dice, names, ty, depth - 1);
            let two = beside(dice, names, ty, depth - 1);
            expr(ty, Of::Binary(operator, boxed(one), boxed(two)))
        }
        2 => {
            let operator = dice.one(&["*", "/", "MOD"]);
            let one = value(dice, names, ty, depth - 1);
            let by = expr(ty, Of::Literal(i64::try_from(dice.below(5)).expect("small") + 1));
            expr(ty, Of::Binary(operator, boxed(one), boxed(by)))
        }
        3 => {
            let from = dice.one(&[INT, DINT, UINT, SINT, USINT]);
            if from == ty || typed(&names.read, from).is_empty() {
                return value(dice, names, ty, depth - 1);
            }
            let name = format!("{}_TO_{}", from.name(), ty.name());
            expr(ty, Of::Standard(name, vec![value(dice, names, from, depth - 1)]))
        }
        4 => {
            let given = vec![value(dice, names, ty, depth - 1), value(dice, names, ty, depth - 1)];
            expr(ty, Of::Standard(dice.one(&["MIN", "MAX"]).to_owned(), given))
        }
        5 => {
            let given = vec![
                value(dice, names, BOOL, depth - 1),
                value(dice, names, ty, depth - 1),
                value(dice, names, ty, depth - 1),
            ];
            expr(ty, Of::Standard("SEL".to_owned(), given))
        }
        6 if ty == INT && names.functions > 0 && !names.handed.is_empty() => {
            let input = value(dice, names, INT, depth - 1);
            let both = dice.one(&names.handed);
            expr(INT, Of::Call(dice.below(names.functions), boxed(input), both))
        }
        7 if ty.signed => {
            expr(ty, Of::Standard("ABS".to_owned(), vec![value(dice, names, ty, depth - 1)]))
        }
        _ => value(dice, names, ty, depth - 1),
    }
}

/// A literal that says its type by standing beside a variable, or by itself where there is none.
fn beside(dice: &mut Dice, names: &Names, ty: Ty, depth: usize) -> Expr {
    if dice.chance(2) { literal(dice, ty) } else { value(dice, names, ty, depth) }
}

fn typed_literal(dice: &mut Dice, ty: Ty) -> Expr {
    let one = literal(dice, ty);
    match one.of {
        Of::Literal(number) if ty != BOOL && ty != COLOUR => expr(ty, Of::Typed(number)),
        of => expr(ty, of),
    }
}

fn body(
    dice: &mut Dice,
    names: &Names,
    count: usize,
    depth: usize,
    in_loop: bool,
) -> Vec<Statement> {
    (0..count).map(|_| statement(dice, names, depth, in_loop)).collect()
}

fn statement(dice: &mut Dice, names: &Names, depth: usize, in_loop: bool) -> Statement {
    let count = |dice: &mut Dice| 1 + dice.below(2);
    match dice.below(if depth == 0 { 7 } else { 14 }) {
        5 if names.structures.len() > 1 => {
            Statement::Copy(dice.one(&names.structures), dice.one(&names.structures))
        }
        6 if !names.arrays.is_empty() => {
            let (array, ty) = dice.one(&names.arrays);
            let index = value(dice, names, INT, 1);
            Statement::Store(array, index, value(dice, names, ty, 1))
        }
        7 | 8 => {
            let arms = (0..count(dice))
                .map(|_| {
                    let inner = count(dice);
                    (value(dice, names, BOOL, 2), body(dice, names, inner, depth - 1, in_loop))
                })
                .collect();
            let inner = dice.below(2);
            Statement::If(arms, body(dice, names, inner, depth - 1, in_loop))
        }
        9 => {
            let mut low = -1;
            let arms = (0..count(dice))
                .map(|_| {
                    low += 1 + i64::try_from(dice.below(3)).expect("small");
                    let from = low;
                    low += i64::try_from(dice.below(2)).expect("small");
                    (from, low, body(dice, names, 1, depth - 1, in_loop))
                })
                .collect();
            let of = value(dice, names, INT, 1);
            Statement::Case(of, arms, body(dice, names, 1, depth - 1, in_loop))
        }
        10 if !names.counters.is_empty() => {
            let mut inner = names.clone();
            let counter = inner.counters.pop().expect("one");
            inner.read.push((counter.clone(), INT));
            let count = count(dice);
            let within = body(dice, &inner, count, depth - 1, true);
            if dice.chance(2) {
                let end = 1 + i64::try_from(dice.below(3)).expect("small");
                return Statement::Counting(dice.chance(2), counter, end, within);
            }
            let (from, to, by) =
                dice.one(&[(0, 2, 1), (1, 3, 1), (3, 0, -1), (0, 5, 2), (2, 1, 1)]);
            let mut from = expr(INT, Of::Literal(from));
            if dice.chance(3) {
                // It may name the counter itself.
                let [low, high] = [0, 3].map(|end| expr(INT, Of::Literal(end)));
                let given = vec![low, value(dice, &inner, INT, 1), high];
                from = expr(INT, Of::Standard("LIMIT".to_owned(), given));
            }
            Statement::For(counter, from, to, by, within)
        }
        11 if in_loop => {
            let leave = if dice.chance(2) { Statement::Exit } else { Statement::Continue };
            Statement::If(vec![(value(dice, names, BOOL, 1), vec![leave])], Vec::new())
        }
        12 if !names.blocks.is_empty() => {
            let (instance, unit) = dice.one(&names.blocks);
            let inputs = vec![value(dice, names, INT, 1), value(dice, names, BOOL, 1)];
            let both = [dice.one(&names.handed), dice.one(&names.structures)];
            let output = dice.chance(2).then(|| dice.one(&typed(&names.write, INT)));
            // What the output is written to must not be handed over, too: which comes first is not said.
            let output = output.filter(|to| !names.handed.contains(to) && !to.contains('.'));
            Statement::Block(instance, unit, inputs, both, output)
        }
        13 if !names.standard.is_empty() => {
            let (instance, kind) = dice.one(&names.standard);
            let inputs: &[&str] = match kind {
                "R_TRIG" | "F_TRIG" => &["CLK"],
                "SR" => &["S1", "R"],
                "RS" => &["S", "R1"],
                "CTU" => &["CU", "R", "PV"],
                "CTD" => &["CD", "LD", "PV"],
                _ => &["IN"],
            };
            let given = |dice: &mut Dice, name: &&'static str| {
                (
                    *name,
                    if *name == "PV" { literal(dice, INT) } else { value(dice, names, BOOL, 1) },
                )
            };
            let inputs = inputs.iter().map(|name| given(dice, name)).collect();
            Statement::Standard(instance, kind, inputs)
        }
        _ => {
            let (target, ty) = dice.one(&names.write);
            Statement::Assign(target, value(dice, names, ty, 2))
        }
    }
}

fn named(all: &[(&str, Ty)]) -> Vec<(String, Ty)> {
    all.iter().map(|(name, ty)| ((*name).to_owned(), *ty)).collect()
}

fn strings(all: &[&str]) -> Vec<String> {
    all.iter().map(|one| (*one).to_owned()).collect()
}

const INPUTS: &[(&str, Ty)] = &[("in0", BOOL), ("in1", BOOL), ("in2", INT)];
const OWN: &[(&str, Ty)] = &[
    ("b0", BOOL),
    ("b1", BOOL),
    ("b2", BOOL),
    ("n0", INT),
    ("n1", INT),
    ("n2", INT),
    ("m0", INT),
    ("d0", DINT),
    ("w0", UINT),
    ("u0", USINT),
    ("s0", SINT),
    ("st0.b", BOOL),
    ("st0.n", INT),
    ("st1.b", BOOL),
    ("st1.n", INT),
    ("e0", COLOUR),
    ("e1", COLOUR),
    ("r0", INT),
    ("r1", USINT),
];
/// What is declared in another way than by its type's name, and what it begins with.
const DECLARED: &[(&str, &str, i64)] = &[
    ("e0", "Colour", 2),
    ("e1", "Colour := blue", 5),
    ("r0", "INT (-3..10)", -3),
    ("r1", "USINT (2..200) := 7", 7),
];
/// Variables of the project, which another task may write at any moment.
const SHARED: &[(&str, Ty)] = &[("g0", BOOL), ("g1", INT), ("g2", INT)];
const STANDARD: &[(&str, &str)] = &[
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

/// A program: its functions, its blocks, its statements.
struct Case {
    functions: Vec<Unit>,
    blocks: Vec<Unit>,
    main: Vec<Statement>,
    /// The variables that are kept when the power fails.
    kept: Vec<String>,
    /// What another task does, if there is one.
    other: Option<Vec<Statement>>,
}

fn case(dice: &mut Dice) -> Case {
    let function = Names {
        read: named(&[("a", INT), ("c", INT), ("k", INT), ("l", BOOL), ("i", INT)]),
        write: named(&[("c", INT), ("k", INT), ("l", BOOL)]),
        counters: strings(&["i"]),
        ..Names::default()
    };
    let functions = (0..2).map(|number| {
        let mut own = body(dice, &function, 2, 1, false);
        let result =
            vec![Statement::Assign(format!("Fun{number}"), value(dice, &function, INT, 2))];
        match dice.chance(2) {
            true => own.extend(result),
            // What it does not assign begins anew with every call.
            false => {
                let arms = vec![(value(dice, &function, BOOL, 1), result)];
                own.push(Statement::If(arms, Vec::new()));
            }
        }
        Unit { body: own }
    });
    let functions: Vec<Unit> = functions.collect();
    let mut block = Names {
        read: named(&[
            ("p", INT),
            ("q", BOOL),
            ("r", INT),
            ("z.b", BOOL),
            ("z.n", INT),
            ("o", INT),
            ("k", INT),
            ("l", BOOL),
            ("i", INT),
            ("t.Q", BOOL),
        ]),
        write: named(&[
            ("r", INT),
            ("z.b", BOOL),
            ("z.n", INT),
            ("o", INT),
            ("k", INT),
            ("l", BOOL),
        ]),
        structures: strings(&["z", "y"]),
        counters: strings(&["i"]),
        functions: 2,
        handed: strings(&["k"]),
        standard: vec![("t", "TON"), ("e", "R_TRIG")],
        ..Names::default()
    };
    let inner = Unit { body: body(dice, &block, 3, 2, false) };
    // The other block has an instance of the first.
    block.standard.clear();
    block.read.retain(|one| one.0 != "t.Q");
    block.blocks = vec![("inner", 0)];
    block.structures = strings(&["z", "y"]);
    let mut calling = block.clone();
    calling.structures = strings(&["y", "y2"]);
    let mut outer = body(dice, &block, 2, 1, false);
    outer.extend(body(dice, &calling, 2, 1, false));
    let other = Names {
        read: named(SHARED).into_iter().chain(named(&[("k", INT), ("in1", BOOL)])).collect(),
        write: named(SHARED).into_iter().chain(named(&[("k", INT)])).collect(),
        ..Names::default()
    };
    let other = dice.chance(3).then(|| body(dice, &other, 3, 1, false));
    let shared = || named(SHARED).into_iter().filter(|_| other.is_some());
    let main = Names {
        read: named(INPUTS)
            .into_iter()
            .chain(named(OWN))
            .chain(shared())
            .chain(STANDARD.iter().map(|(name, kind)| {
                let output = if matches!(*kind, "SR" | "RS") { "Q1" } else { "Q" };
                (format!("{name}.{output}"), BOOL)
            }))
            .chain(["cu.CV", "fb0.o", "i0", "i1"].map(|name| (name.to_owned(), INT)))
            .collect(),
        write: named(OWN).into_iter().chain(shared()).collect(),
        arrays: vec![("arr", INT), ("set", BOOL)],
        structures: strings(&["st0", "st1"]),
        counters: strings(&["i0", "i1"]),
        functions: 2,
        handed: strings(&["m0", "n2"]),
        blocks: vec![("fb0", 0), ("fb1", 1), ("fb2", 0)],
        standard: STANDARD.to_vec(),
    };
    let count = 5 + dice.below(4);
    let main = body(dice, &main, count, 3, false);
    let all = OWN.iter().map(|one| one.0.split('.').next().unwrap_or(one.0));
    let all =
        all.chain(STANDARD.iter().map(|one| one.0)).chain(["arr", "set", "fb0", "fb1", "fb2"]);
    let mut kept: Vec<String> = all.map(str::to_owned).collect();
    kept.dedup();
    let often = 1 + dice.below(4);
    kept.retain(|_| dice.chance(often));
    if dice.chance(2) {
        kept.clear();
    }
    Case { functions, blocks: vec![inner, Unit { body: outer }], main, kept, other }
}

/// The project as text. `probe` stands at its end.
fn source(case: &Case, probe: &str) -> String {
    let mut text = "TYPE S : STRUCT b : BOOL; n : INT; END_STRUCT; END_TYPE\n".to_owned();
    let colours: Vec<String> =
        COLOURS.iter().map(|(name, value)| format!("{name} := {value}")).collect();
    text += &format!("TYPE Colour : ({}); END_TYPE\n", colours.join(", "));
    for (number, unit) in case.functions.iter().enumerate() {
        text += &format!(
            "FUNCTION Fun{number} : INT VAR_INPUT a : INT; END_VAR VAR_IN_OUT c : INT; END_VAR VAR k, i : INT; l : BOOL; END_VAR\n"
        );
        machine::text(&unit.body, &mut text);
        text += "END_FUNCTION\n";
    }
    for (number, unit) in case.blocks.iter().enumerate() {
        let inner =
            if number == 0 { "t : TON := (PT := T#20ms); e : R_TRIG;" } else { "inner : Block0;" };
        let inner = inner.replace(" := (PT := T#20ms)", "");
        text += &format!(
            "FUNCTION_BLOCK Block{number} VAR_INPUT p : INT; q : BOOL; END_VAR VAR_IN_OUT r : INT; z : S; END_VAR VAR_OUTPUT o : INT; END_VAR VAR k, i : INT; l : BOOL; y, y2 : S; {inner} END_VAR\n"
        );
        if number == 0 {
            text += "t.PT := T#20ms;\n";
        }
        machine::text(&unit.body, &mut text);
        text += "END_FUNCTION_BLOCK\n";
    }
    text += "PROGRAM main\nVAR in0 AT %IX0.0 : BOOL; in1 AT %IX0.1 : BOOL; in2 AT %IW2 : INT; i0, i1 : INT; probe : REAL; END_VAR\n";
    let plain = OWN.iter().filter(|(name, _)| !name.contains('.'));
    let plain = plain.map(|(name, ty)| {
        let own = DECLARED.iter().find(|one| one.0 == *name);
        (*name, own.map_or_else(|| ty.name().to_owned(), |one| one.1.to_owned()))
    });
    let standard = STANDARD.iter().map(|(name, kind)| (*name, (*kind).to_owned()));
    let rest = [
        ("st0", "S"),
        ("st1", "S"),
        ("arr", "ARRAY[0..3] OF INT"),
        ("set", "ARRAY[0..3] OF BOOL"),
        ("fb0", "Block0"),
        ("fb1", "Block1"),
        ("fb2", "Block0"),
    ];
    for (name, of) in plain.chain(standard).chain(rest.map(|(name, of)| (name, of.to_owned()))) {
        let retain = if case.kept.iter().any(|kept| kept == name) { "RETAIN " } else { "" };
        text += &format!("VAR {retain}{name} : {of}; END_VAR\n");
    }
    let external = "VAR_EXTERNAL g0 : BOOL; g1, g2 : INT; END_VAR\n";
    if case.other.is_some() {
        text += external;
    }
    text += "on.PT := T#20ms; off.PT := T#20ms; tp.PT := T#20ms;\n";
    machine::text(&case.main, &mut text);
    text += probe;
    text += "END_PROGRAM\n";
    if let Some(other) = &case.other {
        text += &format!("PROGRAM other\n{external}VAR k : INT; in1 AT %IX0.1 : BOOL; END_VAR\n");
        machine::text(other, &mut text);
        text += "END_PROGRAM\nCONFIGURATION c VAR_GLOBAL g0 : BOOL; g1, g2 : INT; END_VAR RESOURCE r ON plc \
            TASK fast(INTERVAL := T#10ms, PRIORITY := 1); TASK slow(INTERVAL := T#100ms, PRIORITY := 5); \
            PROGRAM one WITH fast : other; PROGRAM two WITH slow : main; END_RESOURCE END_CONFIGURATION\n";
    }
    text
}

/// The bound in microseconds, or why there is none.
fn bound(text: &str, trust: Trust) -> Result<u64, String> {
    audited(&[("main.st", text)], "", trust).map(|found| probe::bound(&found))
}

/// What asks whether a scan ends with these values.
fn ends_with(state: &BTreeMap<String, i64>) -> String {
    let mut known: Vec<(String, Ty)> = named(INPUTS).into_iter().chain(named(OWN)).collect();
    known.extend((0..4).map(|at| (format!("arr[{at}]"), INT)));
    known.extend((0..4).map(|at| (format!("set[{at}]"), BOOL)));
    known.push(("fb0.o".to_owned(), INT));
    let told = known.iter().map(|(name, ty)| {
        let value = state.get(name).copied().unwrap_or(0);
        match *ty {
            BOOL if value == 0 => format!("NOT {name}"),
            BOOL => name.clone(),
            COLOUR => {
                let own = COLOURS.iter().find(|one| one.1 == value).map_or("blue", |one| one.0);
                format!("{name} = {own}")
            }
            _ => format!("{name} = {value}"),
        }
    });
    let told: Vec<String> = told.collect();
    format!("IF {} THEN probe := LN(probe); END_IF\n", told.join(" AND "))
}

/// Gives variables that hold nothing yet what they begin with.
fn power_up(machine: &mut Machine<'_>) {
    for name in ["on", "off", "tp", "fb0.t", "fb2.t", "fb1.inner.t"] {
        machine.state.insert(format!("{name}.PT"), 20);
    }
    for (name, _, value) in DECLARED {
        machine.state.entry((*name).to_owned()).or_insert(*value);
    }
}

/// The seconds of a run: the state after some scans from power-up, and how many stores the last one took.
fn run(case: &Case, dice: &mut Dice) -> (BTreeMap<String, i64>, u64) {
    let mut machine = Machine::new(&case.functions, &case.blocks);
    machine.skips = dice.chance(2);
    power_up(&mut machine);
    if let Some(other) = &case.other {
        machine.other = Some((other, dice.below(1 << 30) as u64));
    }
    machine.wide = dice.chance(2);
    machine.last = dice.chance(2);
    machine.right_first = dice.chance(2);
    machine.target_first = dice.chance(2);
    // Whether a falling edge is seen in the first call, controllers differ.
    let falls = i64::from(dice.chance(2));
    machine.state.insert("ft.m".to_owned(), falls);
    let scans = 1 + dice.below(5);
    let fails = if case.kept.is_empty() { 0 } else { dice.below(3) };
    for at in 0..scans + fails {
        for (name, ty) in INPUTS {
            let value = if dice.chance(4) { dice.below(1 << 16) } else { dice.below(5) };
            let value = ty.wrap(i64::try_from(value).expect("small"));
            machine.state.insert((*name).to_owned(), value);
            // The other task looks at the same input.
            machine.state.insert(format!("other.{name}"), value);
        }
        machine.passed = i64::try_from(dice.below(25)).expect("small");
        machine.stores = 0;
        let is_last = at + 1 == scans + fails;
        machine.fails = (!is_last && fails > 0 && dice.chance(2)).then(|| dice.below(12) as u64);
        machine.run(&Scope::default(), &case.main);
        machine.fails = None;
        if let Some(left) = machine.left.take() {
            // What is kept holds what the scan that was cut off left in it.
            machine.state = left;
            let kept = |key: &String| {
                let first = key.split(['.', '[']).next().unwrap_or(key);
                case.kept.iter().any(|kept| kept == first)
            };
            machine.state.retain(|key, _| kept(key));
            power_up(&mut machine);
            machine.state.entry("ft.m".to_owned()).or_insert(falls);
        }
    }
    (machine.state.clone(), machine.stores)
}

#[test]
fn no_scan_of_random_programs_is_left_out_of_the_bound() {
    let (mut followed, mut refused, mut asked, mut excluded) = (0, BTreeMap::new(), 0_u32, 0_u32);
    for seed in seeds(12) {
        let mut dice = Dice::new(seed);
        let case = case(&mut dice);
        let trust = if seed % 2 == 0 { Trust::All } else { Trust::None };
        let (mut state, stores) = run(&case, &mut dice);
        let text = source(&case, &ends_with(&state));
        match bound(&text, trust) {
            Ok(found) => {
                assert!(
                    found >= PROBE + stores,
                    "seed {seed}, {trust:?}: {found} < {PROBE} + {stores}\n{text}"
                );
                followed += 1;
            }
            Err(why) => {
                *refused.entry(why).or_insert(0) += 1;
                continue;
            }
        }
        // A value that it does not end with is often known not to be.
        let (name, ty) = OWN[dice.below(OWN.len())];
        let value = state.get(name).copied().unwrap_or(0);
        let next = if ty == COLOUR { if value == 5 { 3 } else { 5 } } else { ty.wrap(value + 1) };
        state.insert(name.to_owned(), next);
        asked += 1;
        let other = bound(&source(&case, &ends_with(&state)), trust).unwrap_or(u64::MAX);
        excluded += u32::from(other < PROBE);
    }
    assert!(followed >= cases(9_u32), "most are followed: {followed}, {refused:#?}");
    assert!(excluded * 20 >= asked, "values are followed: {excluded} of {asked}");
}
