//! A toy pass, written here alone: what a new pass takes is one file with a `PASS` such as this, and its line in
//! `PASSES`. The pipeline then runs it on the programs of every front.

use scanbound::audit::{Failure, Request, audit};
use scanbound::base::code::Code;
use scanbound::base::facts::Facts;
use scanbound::base::time::Picos;
use scanbound::front::Input;
use scanbound::passes::{Pass, Passes, calls, interrupts, loops};
use scanbound::program::{BitSource, ChoiceId, Logic, Step};

/// Whether anything fires is any value: a program's rungs exclude nothing any more.
const TOY: Pass = Pass {
    name: "forgetting conditions",
    run: |program, _| {
        for at in 0..program.instructions.len() {
            let choice = ChoiceId(program.choices);
            if let Step::Act { fires } = &mut program.instructions[at].step {
                *fires = Logic::Bit(BitSource::Free(choice));
                program.choices += 1;
                program.approximate(at, "the toy forgets the condition");
            }
        }
        Ok(())
    },
};

/// Refuses programs without a rung.
const PICKY: Pass = Pass {
    name: "looking for rungs",
    run: |program, _| match program.instructions.first() {
        Some(first) if program.instructions.len() < 4 => {
            Err(vec![program.fault(first, Code::Scan, "hardly a program", "write more")])
        }
        _ => Ok(()),
    },
};

static WITHOUT: Passes = Passes(&[&calls::PASS, &loops::PASS, &interrupts::PASS]);
/// The registry, with its lines for the toys.
static WITH: Passes = Passes(&[&calls::PASS, &loops::PASS, &interrupts::PASS, &PICKY, &TOY]);

fn audited(passes: Passes, text: &str) -> Result<(Picos, usize), Failure> {
    let inputs = [Input { name: "a.il".to_owned(), bytes: text.as_bytes().to_vec() }];
    let facts = Facts::default();
    let request = Request { cpu: Some("Q26UDV"), passes, ..Request::new(&inputs, &facts) };
    audit(&request).map(|audit| (audit.bound.upper, audit.approximations.len()))
}

#[test]
fn what_a_pass_makes_of_a_program_is_what_is_bounded() {
    let text = "LD X0\nBMOV D0 D10 K5\nLDI X0\nBMOV D0 D10 K9\nEND\n";
    let (upper, none) = audited(WITHOUT, text).expect("an audit");
    let (wider, some) = audited(WITH, text).expect("an audit");
    assert!(wider > upper, "{wider} {upper}");
    assert_eq!((none, some), (0, 2));
}

#[test]
fn what_a_pass_refuses_is_told_with_its_line() {
    let found = audited(WITH, "LD X0\nOUT Y0\nEND\n");
    let Err(Failure::Input(faults)) = found else { panic!("{found:?}") };
    assert_eq!((faults[0].code, faults[0].line), (Code::Scan, Some(1)));
    assert!(audited(WITHOUT, "LD X0\nOUT Y0\nEND\n").is_ok());
}
