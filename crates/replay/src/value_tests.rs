//! Tests of the interpreter's values: cells, numbers, comparisons, effects and stated ranges.

use super::control_tests::{bit, instruction, program, word};
use super::*;
use scanbound_base::time::Picos;
use scanbound_ir::Cell;
use scanbound_ir::ChoiceKey;
use scanbound_ir::{
    AreaId, BitSource, BitTarget, ChoiceId, Compare, Effect, Join, Logic, Number, NumberFormat,
    Region, Relation, StartRange, Step, When, WordSource, WordTarget, Write,
};

/// Runs the writes as instructions that fire if M99 is on. Then evaluates each logic as a contact.
fn ask(writes: Vec<(When, Write)>, asked: Vec<Logic>, witness: &Witness) -> Vec<bool> {
    let contact = |value| instruction(Step::Logic { join: Join::Start, value }, vec![]);
    let act = |effect| instruction(Step::Act { fires: Logic::cell(bit(99)) }, vec![effect]);
    let first = writes.len();
    let acts = writes.into_iter().map(|(when, write)| act(Effect { when, write }));
    let p = program(acts.chain(asked.into_iter().map(contact)).collect());
    let times = vec![Times::new(Picos::ZERO, Picos::ZERO); p.instructions.len()];
    replay(&p, &times, witness).events[first..].iter().map(|event| event.fired).collect()
}

fn truth(logic: Logic, witness: &Witness) -> bool {
    ask(vec![], vec![logic], witness)[0]
}

fn constant(value: u32, words: usize) -> Number {
    let parts = [value as u16, (value >> 16) as u16];
    Number::Words(parts[..words].iter().map(|&part| WordSource::Const(part)).collect())
}

fn compare(relation: Relation, format: NumberFormat, left: Number, right: Number) -> Logic {
    Logic::Compare(Box::new(Compare { relation, format, left, right }))
}

fn equal(left: Number, right: Number) -> Logic {
    compare(Relation::Equal, NumberFormat::Unsigned, left, right)
}

fn cells(cells: &[Cell]) -> Number {
    Number::Words(cells.iter().map(|&cell| WordSource::Cell(cell)).collect())
}

fn holds(cell: Cell, value: u16) -> Logic {
    equal(cells(&[cell]), constant(value.into(), 1))
}

fn targets(cells: &[Cell]) -> Vec<WordTarget> {
    cells.iter().map(|&cell| WordTarget::Cell(cell)).collect()
}

fn start(values: &[(Cell, u16)]) -> Witness {
    Witness { start: values.iter().copied().collect(), ..Witness::default() }
}

const RELATIONS: [Relation; 6] = [
    Relation::Equal,
    Relation::NotEqual,
    Relation::Less,
    Relation::LessOrEqual,
    Relation::Greater,
    Relation::GreaterOrEqual,
];

fn related<T: PartialOrd>(relation: Relation, a: T, b: T) -> bool {
    match relation {
        Relation::Equal => a == b,
        Relation::NotEqual => a != b,
        Relation::Less => a < b,
        Relation::LessOrEqual => a <= b,
        Relation::Greater => a > b,
        Relation::GreaterOrEqual => a >= b,
    }
}

#[test]
fn comparisons_of_one_and_two_words_are_those_of_numbers() {
    let values =
        [0u32, 1, 2, 0x7FFF, 0x8000, 0xFFFF, 0x1_0000, 0x7FFF_FFFF, 0x8000_0000, 0xFFFF_FFFF];
    let none = Witness::default();
    for a in values {
        for b in values {
            for relation in RELATIONS {
                let got = |format, words| {
                    truth(compare(relation, format, constant(a, words), constant(b, words)), &none)
                };
                assert_eq!(got(NumberFormat::Unsigned, 2), related(relation, a, b));
                assert_eq!(got(NumberFormat::Signed, 2), related(relation, a as i32, b as i32));
                assert_eq!(got(NumberFormat::Unsigned, 1), related(relation, a as u16, b as u16));
                assert_eq!(got(NumberFormat::Signed, 1), related(relation, a as i16, b as i16));
            }
        }
    }
}

#[test]
fn numbers_of_many_words_compare_from_the_top() {
    let long = |words: [u16; 5]| Number::Words(words.map(WordSource::Const).to_vec());
    let less = |format, a, b| {
        truth(compare(Relation::Less, format, long(a), long(b)), &Witness::default())
    };
    assert!(less(NumberFormat::Unsigned, [9, 9, 9, 9, 0], [0, 0, 0, 0, 1]));
    assert!(less(NumberFormat::Signed, [9, 9, 9, 9, 0xFFFF], [0, 0, 0, 0, 0]));
    assert!(!less(NumberFormat::Signed, [9, 0, 0, 0, 3], [8, 0, 0, 0, 3]));
}

#[test]
fn arithmetic_wraps_and_carries() {
    let none = Witness::default();
    let cases = [
        (0u32, 0u32),
        (1, 1),
        (0xFFFF, 1),
        (0x1_0000, 1),
        (0xFFFF_FFFF, 1),
        (0, 1),
        (0x1234_5678, 0x8765_4321),
    ];
    for (a, b) in cases {
        let operands = |words| (Box::new(constant(a, words)), Box::new(constant(b, words)));
        let check = |number: Number, want: u32, words: usize| {
            assert!(truth(equal(number, constant(want, words)), &none), "{a:x} {b:x}");
        };
        for words in [1, 2] {
            let (l, r) = operands(words);
            check(Number::Add(l, r), a.wrapping_add(b), words);
            let (l, r) = operands(words);
            check(Number::Sub(l, r), a.wrapping_sub(b), words);
            let (l, r) = operands(words);
            check(Number::And(l, r), a & b, words);
            let (l, r) = operands(words);
            check(Number::Or(l, r), a | b, words);
            let (l, r) = operands(words);
            check(Number::Xor(l, r), a ^ b, words);
        }
    }
}

#[test]
fn reals_compare_and_the_peculiar_ones_are_a_choice() {
    let real = |value: f32| constant(value.to_bits(), 2);
    let choice = ChoiceId(5);
    let mut chosen = Witness::default();
    chosen.choices.insert(ChoiceKey { frames: vec![], choice, cell: None }, 3);
    for relation in RELATIONS {
        let ask = |a, b, witness: &Witness| {
            truth(compare(relation, NumberFormat::Real(choice), real(a), real(b)), witness)
        };
        for a in [0.0, 1.5, -1.5, 3.25, f32::MAX, f32::MIN, f32::MIN_POSITIVE] {
            for b in [0.0, 1.5, -7.0] {
                assert_eq!(ask(a, b, &chosen), related(relation, a, b), "{a} {b}");
                assert_eq!(ask(b, a, &Witness::default()), related(relation, b, a), "{b} {a}");
            }
        }
        for odd in [
            -0.0,
            f32::NAN,
            f32::INFINITY,
            f32::NEG_INFINITY,
            f32::from_bits(1),
            -f32::from_bits(7),
        ] {
            for other in [0.0, 1.0] {
                assert!(ask(odd, other, &chosen) && ask(other, odd, &chosen));
                assert!(!ask(odd, other, &Witness::default()));
            }
        }
    }
}

#[test]
fn bits_of_words_and_groups_of_bits_are_read_and_written() {
    let witness = start(&[(word(0), 0x8001), (bit(4), 1), (bit(7), 1), (bit(99), 1)]);
    let group = |first, count| Number::Words(vec![WordSource::Bits { first, count }]);
    let word_bit = |n| Logic::Bit(BitSource::WordBit(word(0), n));
    assert!(truth(word_bit(0), &witness) && truth(word_bit(15), &witness));
    assert!(!truth(word_bit(1), &witness));
    assert!(truth(equal(group(bit(4), 4), constant(0b1001, 1)), &witness));
    assert!(truth(equal(group(bit(4), 3), constant(0b001, 1)), &witness));
    assert!(truth(equal(group(bit(0), 16), constant(0x90, 1)), &witness));

    let set = Write::Bit(BitTarget::WordBit(word(0), 3), Logic::Const(true));
    let clear = Write::Bit(BitTarget::WordBit(word(0), 15), Logic::Const(false));
    let writes = vec![(When::Always, set), (When::Always, clear)];
    assert_eq!(ask(writes, vec![holds(word(0), 9)], &witness), [true]);

    let spread =
        Write::Words(vec![WordTarget::Bits { first: bit(4), count: 4 }], constant(0xFFF6, 1));
    let asked = (3..9).map(|n| Logic::cell(bit(n))).collect();
    let got = ask(vec![(When::Always, spread)], asked, &witness);
    assert_eq!(got, [false, false, true, true, false, false]);
}

#[test]
fn all_words_are_read_before_any_is_written() {
    let witness = start(&[(word(0), 1), (word(1), 2), (word(2), 3)]);
    let shift = Write::Words(targets(&[word(1), word(2)]), cells(&[word(0), word(1)]));
    let asked = vec![holds(word(0), 1), holds(word(1), 1), holds(word(2), 2)];
    assert_eq!(ask(vec![(When::Always, shift)], asked, &witness), [true; 3]);
    // Both targets are the same bits: the later write wins.
    let twice = Write::Words(
        vec![WordTarget::Discard, WordTarget::Cell(word(3)), WordTarget::Cell(word(3))],
        Number::Words([7, 8, 9].map(WordSource::Const).to_vec()),
    );
    assert_eq!(ask(vec![(When::Always, twice)], vec![holds(word(3), 9)], &witness), [true]);
}

#[test]
fn effects_see_the_effects_before_but_expressions_the_state_before_all() {
    let condition = |cell, value| Effect {
        when: When::Always,
        write: Write::Bit(BitTarget::Cell(cell), value),
    };
    // A rising edge fires if M0 is on and the memory bit M1 was off. The memory bit is updated at once.
    let edge = Logic::All(vec![Logic::cell(bit(0)), Logic::cell(bit(1)).not()]);
    let contact = instruction(
        Step::Logic { join: Join::Start, value: edge },
        vec![
            condition(bit(1), Logic::cell(bit(0))),
            condition(bit(2), Logic::cell(bit(1))),
            condition(bit(3), Logic::Condition),
            Effect {
                when: When::Fired,
                write: Write::Bit(BitTarget::Cell(bit(4)), Logic::Const(true)),
            },
        ],
    );
    let asked = (1..5).map(|n| {
        instruction(Step::Logic { join: Join::Start, value: Logic::cell(bit(n)) }, vec![])
    });
    let p = program([contact].into_iter().chain(asked).collect());
    let times = [Times::new(Picos(10), Picos(1)); 5];
    let fired = |witness: &Witness| {
        replay(&p, &times, witness).events.iter().map(|event| event.fired).collect::<Vec<_>>()
    };
    // The condition was true (empty stack) although the contact is false.
    assert_eq!(fired(&start(&[(bit(0), 1)])), [true, true, true, true, true]);
    assert_eq!(fired(&start(&[(bit(0), 1), (bit(1), 1)])), [false, true, true, true, false]);
    assert_eq!(fired(&start(&[(bit(1), 1)])), [false, false, false, true, false]);
}

#[test]
fn effects_of_what_does_not_fire_are_left_out() {
    let write = |value| Write::Words(targets(&[word(0)]), constant(value, 1));
    let writes = vec![(When::Always, write(5)), (When::Fired, write(6))];
    assert_eq!(ask(writes.clone(), vec![holds(word(0), 5)], &Witness::default()), [true]);
    assert_eq!(ask(writes, vec![holds(word(0), 6)], &start(&[(bit(99), 1)])), [true]);
}

#[test]
fn havocked_cells_take_the_choice_until_they_are_written() {
    let mut witness = start(&[(word(1), 5), (word(2), 5), (bit(0), 1)]);
    let choice = |n, cell, value| {
        (ChoiceKey { frames: vec![], choice: ChoiceId(n), cell: Some(cell) }, value)
    };
    witness.choices.extend([
        choice(1, word(1), 11),
        choice(2, word(1), 22),
        choice(1, word(2), 12),
        choice(2, bit(0), 2),
    ]);
    let range = Region::Range { first: word(1), count: 2 };
    let havoc = |region, n| (When::Always, Write::Havoc(region, ChoiceId(n)));
    let keep = (When::Always, Write::Words(targets(&[word(2)]), constant(7, 1)));
    let ask = |writes, asked| ask(writes, asked, &witness);

    let asked = vec![holds(word(1), 11), holds(word(2), 12), holds(word(3), 0)];
    assert_eq!(ask(vec![havoc(range, 1)], asked.clone()), [true; 3]);
    assert_eq!(ask(vec![havoc(Region::Area(AreaId(1)), 1)], asked), [true; 3]);
    assert_eq!(ask(vec![havoc(range, 1), keep.clone()], vec![holds(word(2), 7)]), [true]);
    let all = havoc(Region::Everything, 2);
    let asked = vec![holds(word(1), 22), holds(word(2), 0), Logic::cell(bit(0)).not()];
    assert_eq!(ask(vec![havoc(range, 1), keep, all], asked), [true; 3]);
    // Writing a bit of a havocked word keeps the word's other bits.
    let low = (When::Always, Write::Bit(BitTarget::WordBit(word(1), 2), Logic::Const(true)));
    assert_eq!(ask(vec![havoc(range, 1), low], vec![holds(word(1), 15)]), [true]);
    // A copy of a havocked word keeps the value of the original.
    let copy = (When::Always, Write::Words(targets(&[word(9)]), cells(&[word(1)])));
    let asked = vec![equal(cells(&[word(9)]), cells(&[word(1)]))];
    assert_eq!(ask(vec![havoc(range, 1), copy], asked), [true]);
}

#[test]
fn all_and_any_of_nothing() {
    let none = Witness::default();
    assert!(truth(Logic::All(vec![]), &none));
    assert!(!truth(Logic::Any(vec![]), &none));
    assert!(truth(Logic::Any(vec![Logic::Const(false), Logic::Const(true)]), &none));
}

#[test]
fn a_range_is_broken_only_by_what_was_read() {
    let broken = |range: StartRange, read: &[Cell], witness: &Witness| {
        let contact = |&cell: &Cell| {
            instruction(Step::Logic { join: Join::Start, value: holds(cell, 0) }, vec![])
        };
        let mut p = program(read.iter().map(contact).collect());
        p.stated_ranges = vec![range];
        let times = vec![Times::new(Picos::ZERO, Picos::ZERO); read.len()];
        !replay(&p, &times, witness).broken_ranges.is_empty()
    };
    let one = StartRange { cells: vec![word(0)], low: -3, high: 4, values: Vec::new() };
    assert!(!broken(one.clone(), &[word(0)], &start(&[(word(0), 0xFFFD)])));
    assert!(broken(one.clone(), &[word(0)], &start(&[(word(0), 0xFFFC)])));
    assert!(broken(one.clone(), &[word(0)], &start(&[(word(0), 5)])));
    assert!(!broken(one, &[], &start(&[(word(0), 5)])));

    let two = StartRange {
        cells: vec![word(0), word(1)],
        low: 0x1_FFFE,
        high: 0x2_0001,
        values: Vec::new(),
    };
    for (low, high, want) in
        [(0xFFFE, 1, false), (0xFFFD, 1, true), (1, 2, false), (2, 2, true), (0, 3, true)]
    {
        let witness = start(&[(word(0), low), (word(1), high)]);
        assert_eq!(broken(two.clone(), &[word(0), word(1)], &witness), want, "{low} {high}");
    }
    assert!(broken(two.clone(), &[word(0)], &start(&[(word(0), 2)])));
    assert!(!broken(two.clone(), &[word(0)], &start(&[(word(0), 1)])));
    assert!(broken(two.clone(), &[word(1)], &start(&[(word(1), 3)])));
    assert!(!broken(two, &[word(1)], &start(&[(word(1), 2)])));
}
