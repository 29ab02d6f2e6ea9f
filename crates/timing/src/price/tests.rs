//! Tests of pricing: which rows, units and operands count, and the overhead of a scan.

use super::*;
use crate::table::{CLASSES, POINTS, SINGLE, VARIED};
use scanbound_base::location::Location;
use scanbound_ir::{
    AccessedDevices, Area, AreaId, AreaKind, BitSource, Cell, ChoiceId, Effect, Interrupt, Join,
    Logic, Number, Radix, Region, Role, SourceFile, Step, When, WordSource, WordTarget, Write,
    testing,
};

const HEAD: &str = "instruction,on_us,off_us,per_unit_us,evidence\n";

fn table(rows: &str) -> Table {
    Table::parse("t.csv", format!("{HEAD}{rows}").as_bytes()).unwrap().table
}

fn key(names: &[&str], class: &'static str, units: Units) -> TimingKey {
    TimingKey {
        names: names.iter().map(|name| (*name).to_owned()).collect(),
        class,
        units,
        use_larger_time: false,
        optional: false,
        accessed: AccessedDevices::default(),
    }
}

fn us(n: u64) -> Picos {
    Picos(n * 1_000_000)
}

fn times(table: &Table, key: &TimingKey) -> (Picos, Picos, String) {
    let price = price_of(table, key, &OperandTags::new()).unwrap();
    (price.on, price.off, price.row.to_string())
}

#[test]
fn the_first_name_with_a_row_counts_then_the_class() {
    let table = table("OUT:T,5,4,,published\nOUT,2,1\n@coil,9,8,,assumed\n");
    let found = |names: &[&str]| times(&table, &key(names, "coil", Units::None));
    assert_eq!(found(&["OUT:T", "OUT"]), (us(5), us(4), "OUT:T".into()));
    assert_eq!(found(&["OUT:Y", "OUT"]), (us(2), us(1), "OUT".into()));
    assert_eq!(found(&["OUTH:T", "OUTH"]), (us(9), us(8), "@coil".into()));
    let by_class =
        price_of(&table, &key(&["OUTH"], "coil", Units::None), &OperandTags::new()).unwrap();
    assert_eq!(by_class.instead_of.as_deref(), Some("OUTH"));
    assert_eq!(by_class.evidence, Evidence::Assumed);
    let missing = price_of(&table, &key(&["MOV"], "move", Units::None), &OperandTags::new());
    assert_eq!(missing, Err(NoPrice::Missing));
}

#[test]
fn units_count_when_the_instruction_fires() {
    let table = table("BMOV,10,1,2\nMOV,3,1\n");
    let found =
        |units| price_of(&table, &key(&["BMOV"], "block", units), &OperandTags::new()).unwrap();
    assert_eq!((found(Units::Exactly(1)).on, found(Units::Exactly(10)).on), (us(12), us(30)));
    assert_eq!(found(Units::Exactly(10)).off, us(1));
    assert_eq!(found(Units::Exactly(0)).on, us(10));
    assert_eq!(found(Units::None).on, us(12));
    assert_eq!(found(Units::Exactly(10)).at_most_units, None);
    assert_eq!(
        (found(Units::AtMost(100)).on, found(Units::AtMost(100)).at_most_units),
        (us(210), Some(100))
    );
    let uncounted =
        price_of(&table, &key(&["MOV"], "move", Units::AtMost(7)), &OperandTags::new()).unwrap();
    assert_eq!(uncounted.at_most_units, None);
    let huge =
        price_of(&table, &key(&["BMOV"], "block", Units::AtMost(u64::MAX)), &OperandTags::new());
    assert_eq!(huge, Err(NoPrice::TooLarge));
}

#[test]
fn operands_add_their_rows_unless_the_row_found_is_for_them() {
    let table =
        table("MOV,1,1,,published\nMOV:digits,7,2\n@+digits,20,3\n@+indexed,100,4,50,assumed\n");
    let found = |names: &[&str]| times(&table, &key(names, "move", Units::Exactly(2)));
    assert_eq!(found(&["MOV"]), (us(1), us(1), "MOV".into()));
    assert_eq!(found(&["MOV:digits", "MOV"]), (us(7), us(2), "MOV:digits".into()));
    assert_eq!(
        found(&["MOVP:digits", "MOVP", "MOV:digits", "MOV"]),
        (us(7), us(2), "MOV:digits".into())
    );
    assert_eq!(found(&["MOV:indexed", "MOV"]), (us(201), us(5), "MOV + @+indexed".into()));
    assert_eq!(
        found(&["MOV:indexed", "MOV:digits", "MOV"]),
        (us(207), us(6), "MOV:digits + @+indexed".into())
    );
    let price =
        price_of(&table, &key(&["MOV:indexed", "MOV"], "move", Units::None), &OperandTags::new())
            .unwrap();
    assert_eq!(price.evidence, Evidence::Assumed);
}

#[test]
fn the_larger_time_is_taken_before_the_factor_rounds_up() {
    let table = table("LD,0.000001,0.000003\n@factor,1.05,\n");
    let mut contact = key(&["LD"], "contact", Units::None);
    assert_eq!(times(&table, &contact), (Picos(2), Picos(4), "LD".into()));
    contact.use_larger_time = true;
    assert_eq!(times(&table, &contact), (Picos(4), Picos(4), "LD".into()));
}

#[test]
fn a_price_from_the_command_line_replaces_the_row() {
    let mut table = table("MOV,1,1,5,published\n@factor,2,\n");
    table.amend("mov", us(3), us(2));
    table.amend("SwOp0", us(50), us(0));
    let found =
        price_of(&table, &key(&["MOV"], "move", Units::Exactly(9)), &OperandTags::new()).unwrap();
    assert_eq!((found.on, found.off, found.evidence), (us(6), us(4), Evidence::Stated));
    assert_eq!(times(&table, &key(&["SwOp0"], "user", Units::None)).0, us(100));
}

#[test]
fn what_is_stated_of_a_name_holds_for_its_variants_unless_they_are_stated_or_slower() {
    let found = |rows: &str, names: &[&str]| {
        times(&table(&format!("@base,qnudv\n@factor,1\n{rows}")), &key(names, "coil", Units::None))
    };
    let out = ["OUT:Y", "OUT"];
    assert_eq!(found("OUT,5,4\n", &out), (us(5), us(4), "OUT".into()));
    for rows in ["OUT,5\nOUT:Y,1\n", "OUT:Y,1\nOUT,5\n"] {
        assert_eq!(found(rows, &out), (us(1), us(1), "OUT:Y".into()));
    }
    assert_eq!(found("RST,5\n", &["RSTP:Y", "RSTP", "RST:Y", "RST"]).0, us(5));
    let fault = found("", &["OUT:F", "OUT"]);
    assert!(fault.0 > us(1));
    assert_eq!(found("OUT,1\n", &["OUT:F", "OUT"]), fault, "an annunciator keeps its larger time");
    let mixed = found("OUT,900,0\n", &["OUT:F", "OUT"]);
    assert_eq!((mixed.0, mixed.1), (us(900), fault.1));

    let mut table = Table::builtin("qnudv").unwrap();
    table.amend("out", us(500), us(5));
    assert_eq!(times(&table, &key(&out, "coil", Units::None)).0, us(556), "with the factor");
}

#[test]
fn what_a_table_says_of_r_holds_for_zr() {
    let found = |rows: &str| {
        let mut table = table(rows);
        table.join_cells(&["ZR", "R"]);
        let tags = [("ZR".to_owned(), 2)].into();
        let price = price_of(&table, &key(&["MOV"], "move", Units::None), &tags).unwrap();
        (price.on, price.off)
    };
    assert_eq!(found("MOV,1\n@+R,3,1\n"), (us(7), us(3)));
    assert_eq!(found("@+R,3,1\n@+ZR,2,2\nMOV,1\n"), (us(7), us(5)));
    assert_eq!(found("@base,qnudv\n@factor,1\nMOV,1\n@+R,3,1\n"), (us(7), us(3)));
    assert_eq!(found("@base,qnudv\n@factor,1\nMOV,1\n@+ZR,3,1\n"), (us(7), us(3)));
}

const X: AreaId = AreaId(0);
const Y: AreaId = AreaId(1);
const D: AreaId = AreaId(2);
const ZR: AreaId = AreaId(3);

fn cell(area: AreaId, index: u32) -> Cell {
    Cell { area, index }
}

fn instruction(line: u32, block: u32, text: &str, class: &'static str) -> Instruction {
    let name = text.split(' ').next().unwrap();
    Instruction {
        place: Location { file: 0, line, step: Some(line * 10) },
        block,
        text: text.into(),
        timing: Some(Box::new(key(&[name], class, Units::None))),
        ..testing::instruction(Step::Act { fires: Logic::Condition })
    }
}

fn load(line: u32, block: u32, at: Cell) -> Instruction {
    let value = Logic::cell(at);
    Instruction {
        step: Step::Logic { join: Join::Start, value },
        ..instruction(line, block, "LD", "contact")
    }
}

fn program(instructions: Vec<Instruction>) -> Program {
    let area = |name: &str, kind, radix| Area::new(name, kind, radix);
    let points = |name: &str, role| Area { role, ..area(name, AreaKind::Bit, Radix::Hexadecimal) };
    let count = instructions.len();
    Program {
        areas: vec![
            points("X", Role::Input),
            points("Y", Role::Output),
            area("D", AreaKind::Word, Radix::Decimal),
            area("ZR", AreaKind::Word, Radix::Decimal),
        ],
        files: vec![SourceFile { name: "a.csv".into(), instructions: 0..count, count }],
        mains: std::iter::once(0..count).collect(),
        instructions,
        ..Program::default()
    }
}

#[test]
fn every_instruction_without_a_time_is_named() {
    let program = program(vec![
        instruction(1, 1, "LD X0", "contact"),
        instruction(2, 1, "BMOV D0 D1 K3", "block"),
        instruction(3, 1, "SwOp0 D0", "user"),
    ]);
    let faults = price(&program, &table("LD,1,\n"), &Facts::default()).unwrap_err();
    let seen: Vec<_> = faults.iter().map(|f| (f.line, f.step, f.text.as_str())).collect();
    assert_eq!(seen, [(Some(2), Some(20), "BMOV D0 D1 K3"), (Some(3), Some(30), "SwOp0 D0")]);
    assert_eq!(faults[0].file, "a.csv");
    assert_eq!(faults[0].message, "the table t.csv has no time for BMOV");
    assert!(faults[0].help.contains("BMOV=12.5us"));
}

#[test]
fn labels_and_parts_of_instructions_are_free() {
    let mut label = instruction(1, 1, "P50", "nothing");
    label.timing.as_mut().unwrap().optional = true;
    let mut part = instruction(2, 1, "LD X0", "contact");
    part.timing = None;
    let program = program(vec![label, part]);
    // If the row is optional, the instruction is not priced by its class, only by its own row.
    let prices = price(&program, &table("@nothing,1,\n"), &Facts::default()).unwrap();
    assert_eq!(prices.instructions, [None, None]);
    assert_eq!(prices.times(), [Times::default(); 2]);
    let prices = price(&program, &table("P50,4,\n"), &Facts::default()).unwrap();
    assert_eq!(prices.times(), [Times::new(us(4), us(4)), Times::default()]);
}

#[test]
fn words_of_an_area_and_bits_of_words_add_what_they_cost() {
    let mut moved = instruction(1, 1, "DMOV ZR0 D0", "move");
    let value = Number::Words(vec![WordSource::Cell(cell(ZR, 0)), WordSource::Cell(cell(ZR, 1))]);
    let targets = vec![WordTarget::Cell(cell(D, 0)), WordTarget::Cell(cell(D, 1))];
    moved.effects = vec![Effect { when: When::Fired, write: Write::Words(targets, value) }];
    let mut bit = load(2, 1, cell(X, 0));
    let value = Logic::Bit(BitSource::WordBit(cell(ZR, 7), 3));
    bit.step = Step::Logic { join: Join::Start, value };
    let mut havocs = instruction(3, 1, "BMOV D0 ZR0 K3", "block");
    havocs.timing.as_mut().unwrap().units = Units::Exactly(3);
    let region = |count| Write::Havoc(Region::Range { first: cell(ZR, 0), count }, ChoiceId(0));
    havocs.effects = vec![Effect { when: When::Fired, write: region(30_000) }];
    let table = table("DMOV,1,\nLD,1,\nBMOV,1,\n@+ZR,10,0\n@+wordbit,100,\n");
    let prices = price(&program(vec![moved, bit, havocs]), &table, &Facts::default()).unwrap();
    let expected = [(21, 1), (111, 101), (81, 1)].map(|(on, off)| Times::new(us(on), us(off)));
    assert_eq!(prices.times(), expected);
    assert_eq!(&*prices.instructions[1].as_ref().unwrap().row, "LD + @+wordbit + @+ZR");
}

/// A write with an index is charged for as many cells as the instruction writes, not for all that the index may reach.
#[test]
fn what_is_written_by_an_index_is_charged_once() {
    let mut moved = instruction(1, 1, "FMOV K0 ZR0Z0 K300", "block");
    moved.timing.as_mut().unwrap().units = Units::Exactly(300);
    let write = Write::Havoc(Region::Range { first: cell(ZR, 0), count: 30_000 }, ChoiceId(0));
    moved.effects = vec![Effect { when: When::Fired, write }];
    let mut indexed = program(vec![moved]);
    let readings = vec![vec![WordSource::Cell(cell(D, 0))]];
    let (stated, found) = (None, Vec::new());
    let length = scanbound_ir::Length::Exactly(300);
    let reached = scanbound_ir::IndexedWrite {
        first: cell(ZR, 0),
        indices: readings,
        length,
        stated,
        proved: found,
    };
    let of = |program: &Program| {
        let table = table("FMOV,1,\n@+ZR,10,0\n");
        price(program, &table, &Facts::default()).unwrap().times()[0].on
    };
    // Without a known index, twice as many cells are charged.
    assert_eq!(of(&indexed), us(6_001));
    indexed.indexed.insert(ChoiceId(0), reached);
    assert_eq!(of(&indexed), us(3_001));
}

#[test]
fn a_rung_costs_at_its_first_priced_instruction() {
    let mut label = instruction(1, 1, "P50", "nothing");
    label.timing.as_mut().unwrap().optional = true;
    let program = program(vec![
        label,
        load(2, 1, cell(X, 0)),
        instruction(3, 1, "MOV D0 D1", "move"),
        load(4, 2, cell(X, 0)),
    ]);
    let prices = price(&program, &table("LD,1,\nMOV,2,\n@rung,6,\n"), &Facts::default()).unwrap();
    assert_eq!(
        prices.times().iter().map(|t| t.on).collect::<Vec<_>>(),
        [us(0), us(7), us(2), us(7)]
    );
    assert_eq!(prices.overhead, []);
}

#[test]
fn an_interrupt_costs_where_it_is_entered() {
    let mut program = program(vec![
        load(1, 1, cell(X, 0)),
        Instruction { timing: None, step: Step::Nothing, ..instruction(2, 2, "I0", "nothing") },
        load(3, 2, cell(X, 0)),
    ]);
    let interrupt =
        |entry, name: &str| Interrupt { name: name.into(), entry, times: 3, stated: true };
    program.interrupts = vec![interrupt(1, "I0"), interrupt(2, "I1")];
    let prices =
        price(&program, &table("LD,1,\n@interrupt-entry,40,\n"), &Facts::default()).unwrap();
    assert_eq!(prices.times().iter().map(|t| t.on).collect::<Vec<_>>(), [us(1), us(40), us(41)]);
}

/// Rows with one number that are not part of a scan: a limit for it, and the parts of a response time outside of scans.
const BESIDE_SCANS: [&str; 3] = ["@watchdog", "@input-delay", "@output-delay"];

#[test]
fn every_kind_of_row_is_charged() {
    // The program has everything that a row may be for: rungs, an interrupt, two main routines, inputs and outputs.
    let mut program = program(vec![
        load(1, 1, cell(X, 3)),
        load(2, 1, cell(Y, 3)),
        instruction(3, 2, "I0", "interrupt"),
    ]);
    program.interrupts = vec![Interrupt { name: "I0".into(), entry: 2, times: 1, stated: true }];
    program.mains.push(3..3);
    let found = |rows: &str| {
        let table = table(&format!("LD,0,\nI0,0,\n{rows}"));
        let prices = price(&program, &table, &Facts::default()).unwrap();
        let instructions: Picos = prices.times().iter().map(|times| times.on).sum();
        (instructions + prices.overhead_sum(), prices.more_points())
    };
    assert_eq!(found(""), (us(0), us(0)));
    let varied = VARIED.map(|kind| format!("{kind}:name"));
    for row in SINGLE.map(str::to_owned).into_iter().chain(varied) {
        let (charged, _) = found(&format!("{row},5,\n"));
        assert_eq!(charged < us(5), BESIDE_SCANS.contains(&&*row), "{row} is charged {charged}");
    }
    for row in POINTS {
        let (_, more) = found(&format!("{row},64,\n@input16,5,\n@output16,5,\n"));
        assert_eq!(more, us(15), "{row}");
    }
    for class in CLASSES {
        let table = table(&format!("@{class},5,\n"));
        assert_eq!(times(&table, &key(&["OP"], class, Units::None)).0, us(5), "{class}");
    }
}

#[test]
fn points_are_those_stated_or_up_to_the_highest_used() {
    let mut range = instruction(2, 1, "MOV K4X10 D0", "move");
    let value = Number::Words(vec![WordSource::Bits { first: cell(X, 0x10), count: 16 }]);
    let write = Write::Words(vec![WordTarget::Cell(cell(D, 9000))], value);
    range.effects = vec![Effect { when: When::Fired, write }];
    let program = program(vec![load(1, 1, cell(X, 3)), range, load(3, 1, cell(Y, 0x20))]);
    let rows = "LD,1,\nMOV,1,\n@input16,2,,,published\n@output8,3,\n@end,100,,,measured\n@end:network,50,\n@program,7,\n@factor,1.5,\n@max-inputs,64,,,assumed\n@max-outputs,40,\n";
    let table = table(rows);
    let found = |facts: &Facts| {
        let prices = price(&program, &table, facts).unwrap();
        let terms: Vec<_> = prices.overhead.iter().map(|t| (t.name.clone(), t.time)).collect();
        (terms, prices.points, prices.overhead)
    };
    let (terms, points, overhead) = found(&Facts::default());
    let us15 = |n: u64| Picos(n * 1_500_000);
    let expected = |input, output| {
        [
            ("END processing", 100),
            ("network", 50),
            ("program starts", 7),
            ("input refresh", input),
            ("output refresh", output),
        ]
        .map(|(name, time)| (name.to_owned(), us15(time)))
    };
    assert_eq!(terms, expected(4, 15));
    assert!(
        overhead[3]
            .why
            .starts_with("32 input points, since X1F is the highest input used: 2 x 2 us")
    );
    assert_eq!(
        overhead.iter().map(|t| t.evidence).collect::<Vec<_>>()[..2],
        [Evidence::Measured, Evidence::Stated]
    );
    let told: Vec<_> = points.iter().map(|p| (p.side, p.taken, p.time, p.sixteen)).collect();
    assert_eq!(told, [("input", 32, us15(4), us15(2)), ("output", 40, us15(15), us15(6))]);
    let more = |points: &UnstatedPoints| points.most.as_ref().map(|m| (m.points, m.more));
    assert_eq!(more(&points[0]), Some((64, us15(4))));
    // Points above the CPU's maximum are not its own.
    assert_eq!(more(&points[1]), Some((40, us15(0))));
    let stated = Facts { inputs: Some(65), outputs: Some(8), ..Facts::default() };
    let (terms, points, _) = found(&stated);
    assert_eq!(terms, expected(10, 3));
    assert_eq!(points, []);
    let none = Facts { inputs: Some(0), outputs: Some(0), ..Facts::default() };
    assert_eq!(found(&none).0.len(), 3);
}

#[test]
fn built_in_tables_price_what_their_cpus_run() {
    for name in crate::table::builtin::names() {
        let table = Table::builtin(name).unwrap();
        if table.family.is_none() {
            continue;
        }
        let price = |names: &[&str], class: &'static str, units| {
            price_of(&table, &key(names, class, units), &OperandTags::new()).unwrap()
        };
        let block = |n| price(&["BMOVP", "BMOV"], "block", Units::Exactly(n)).on;
        assert!(block(10) > block(1), "{name}");
        let moved = |names: &[&str]| price(names, "move", Units::None).on;
        assert!(moved(&["MOV:digits", "MOV"]) > moved(&["MOV"]), "{name}");
        assert!(moved(&["MOV:module", "MOV"]) > moved(&["MOV:indexed", "MOV"]), "{name}");
        // Annunciators, if the CPU has them.
        let coil = |names: &[&str]| price(names, "coil", Units::None).on;
        let slower = coil(&["OUT:F", "OUT"]) > coil(&["OUT:M", "OUT"]);
        assert_eq!(slower, table.row("OUT:F").is_some() || table.row("OUT:M").is_some(), "{name}");
    }
}
