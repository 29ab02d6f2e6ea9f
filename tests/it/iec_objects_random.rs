//! Random programs of interfaces, properties, references and pointers agree with an interpreter that knows nothing of
//! the analysis.

use super::iec_objects::may;
use crate::common::iec::generate::Dice;
use std::fmt::Write as _;

/// The blocks of the random programs: one has a method `Add`, one extends it and calls it twice, one does something else.
const BLOCKS: &str = "
    INTERFACE I METHOD Add VAR_INPUT k : INT; END_VAR END_METHOD PROPERTY Level : INT GET END_GET SET END_SET END_PROPERTY END_INTERFACE
    FUNCTION_BLOCK A IMPLEMENTS I VAR v : INT; END_VAR
      METHOD Add VAR_INPUT k : INT; END_VAR v := v + Scale(k); END_METHOD
      METHOD Scale : INT VAR_INPUT k : INT; END_VAR Scale := k; END_METHOD
      PROPERTY Level : INT GET Level := v; END_GET SET v := Level; END_SET END_PROPERTY
    END_FUNCTION_BLOCK
    FUNCTION_BLOCK B EXTENDS A
      METHOD Add VAR_INPUT k : INT; END_VAR SUPER^.Add(k); SUPER^.Add(1); END_METHOD
      METHOD Scale : INT VAR_INPUT k : INT; END_VAR Scale := SUPER^.Scale(k) + 2; END_METHOD
    END_FUNCTION_BLOCK
    FUNCTION_BLOCK C IMPLEMENTS I VAR v : INT; END_VAR
      METHOD Add VAR_INPUT k : INT; END_VAR v := v - k; END_METHOD
      PROPERTY Level : INT GET v := v + 1; Level := v; END_GET SET v := 2 * Level; END_SET END_PROPERTY
    END_FUNCTION_BLOCK";

/// What a random program does, as text and as an interpreter of its own carries it out.
#[derive(Clone)]
enum Step {
    /// An interface becomes an instance, or the other interface.
    Mean(usize, usize),
    Same(usize),
    Add(usize, i64),
    Put(usize, i64),
    Get(usize, usize),
    /// A pointer becomes a number's address; a reference likewise.
    Point(usize, usize),
    Write(usize, i64),
    Read(usize, usize),
    If(usize, Vec<Step>, Vec<Step>),
}

const INSTANCES: [(&str, char); 4] = [("o1", 'A'), ("o2", 'B'), ("o3", 'C'), ("o4", 'B')];
const NUMBERS: [&str; 3] = ["x", "y", "z"];

#[derive(Clone, Default)]
struct State {
    values: [i64; 4],
    means: [usize; 2],
    numbers: [i64; 3],
    points: [usize; 2],
}

impl State {
    fn run(&mut self, steps: &[Step], inputs: [bool; 2]) {
        for step in steps {
            match step {
                Step::Mean(which, instance) => self.means[*which] = *instance,
                Step::Same(which) => self.means[*which] = self.means[1 - *which],
                Step::Add(which, k) => {
                    let own = self.means[*which];
                    self.values[own] += match INSTANCES[own].1 {
                        'A' => *k,
                        'B' => k + 2 + 3,
                        _ => -k,
                    };
                }
                Step::Put(which, k) => {
                    let own = self.means[*which];
                    self.values[own] = if INSTANCES[own].1 == 'C' { 2 * k } else { *k };
                }
                Step::Get(which, number) => {
                    let own = self.means[*which];
                    if INSTANCES[own].1 == 'C' {
                        self.values[own] += 1;
                    }
                    self.numbers[*number] = self.values[own];
                }
                Step::Point(which, number) => self.points[*which] = *number,
                Step::Write(which, k) => self.numbers[self.points[*which]] += k,
                Step::Read(which, number) => {
                    self.numbers[*number] = self.numbers[self.points[*which]]
                }
                Step::If(input, yes, no) => self.run(if inputs[*input] { yes } else { no }, inputs),
            }
        }
    }
}

fn text(steps: &[Step]) -> String {
    let mut all = String::new();
    for step in steps {
        let end = match step {
            Step::Mean(which, own) => writeln!(all, "i{which} := {};", INSTANCES[*own].0),
            Step::Same(which) => writeln!(all, "i{which} := i{};", 1 - which),
            Step::Add(which, k) => writeln!(all, "i{which}.Add({k});"),
            Step::Put(which, k) => writeln!(all, "i{which}.Level := {k};"),
            Step::Get(which, number) => writeln!(all, "{} := i{which}.Level;", NUMBERS[*number]),
            Step::Point(0, number) => writeln!(all, "p := ADR({});", NUMBERS[*number]),
            Step::Point(_, number) => writeln!(all, "r REF= {};", NUMBERS[*number]),
            Step::Write(0, k) => writeln!(all, "p^ := p^ + {k};"),
            Step::Write(_, k) => writeln!(all, "r := r + {k};"),
            Step::Read(0, number) => writeln!(all, "{} := p^;", NUMBERS[*number]),
            Step::Read(_, number) => writeln!(all, "{} := r;", NUMBERS[*number]),
            Step::If(input, yes, no) => {
                let name = ["a", "b"][*input];
                writeln!(all, "IF {name} THEN\n{}ELSE\n{}END_IF", text(yes), text(no))
            }
        };
        end.expect("a string takes all");
    }
    all
}

fn steps(dice: &mut Dice, many: usize, depth: usize) -> Vec<Step> {
    let one = |dice: &mut Dice| {
        let (which, k) = (dice.below(2), i64::try_from(dice.below(9)).expect("small") + 1);
        match dice.below(if depth > 0 { 10 } else { 8 }) {
            0 => Step::Mean(which, dice.below(4)),
            1 => Step::Same(which),
            2 => Step::Add(which, k),
            3 => Step::Put(which, k),
            4 => Step::Get(which, dice.below(3)),
            5 => Step::Point(which, dice.below(3)),
            6 => Step::Write(which, k),
            7 => Step::Read(which, dice.below(3)),
            _ => {
                let [yes, no] = [0; 2].map(|_| steps(dice, 3, depth - 1));
                Step::If(which, yes, no)
            }
        }
    };
    (0..many).map(|_| one(dice)).collect()
}

#[test]
fn random_programs_agree_with_an_interpreter() {
    let more: u64 = std::env::var("SCANBOUND_CASES").ok().and_then(|n| n.parse().ok()).unwrap_or(1);
    let variables = "o1 : A; o2, o4 : B; o3 : C; i0, i1 : I; x, y, z : INT; p : POINTER TO INT; r : REFERENCE TO INT;";
    for case in 0..12 * more {
        let mut dice = Dice::new(case);
        let mut all = vec![Step::Mean(0, dice.below(4)), Step::Mean(1, dice.below(4))];
        all.extend([Step::Point(0, dice.below(3)), Step::Point(1, dice.below(3))]);
        all.extend(steps(&mut dice, 8, 2));
        let begin = "o1.v := 0; o2.v := 0; o3.v := 0; o4.v := 0; x := 0; y := 0; z := 0;";
        let body = format!("{begin}\n{}", text(&all));
        let ends: Vec<String> = [(false, false), (false, true), (true, false), (true, true)]
            .iter()
            .map(|&(a, b)| {
                let mut state = State::default();
                state.run(&all, [a, b]);
                let owns = INSTANCES
                    .iter()
                    .zip(state.values)
                    .map(|((name, _), v)| format!("{name}.v = {v}"));
                let numbers =
                    NUMBERS.iter().zip(state.numbers).map(|(name, v)| format!("{name} = {v}"));
                let all: Vec<String> = owns.chain(numbers).collect();
                let input =
                    |name: &str, on: bool| if on { name.to_owned() } else { format!("NOT {name}") };
                format!("({} AND {} AND {})", input("a", a), input("b", b), all.join(" AND "))
            })
            .collect();
        for end in &ends {
            assert!(may(BLOCKS, variables, &body, end), "case {case}: never {end}\n{body}");
        }
        let none = format!("NOT ({})", ends.join(" OR "));
        assert!(!may(BLOCKS, variables, &body, &none), "case {case}: {none}\n{body}");
    }
}
