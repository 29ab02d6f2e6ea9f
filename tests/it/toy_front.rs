//! The front of `examples/custom_front.rs`: one file and one line of a registry are all that a dialect takes, and
//! everything behind `Program` serves it.

use scanbound::audit::{Audit, Failure, Request, audit};
use scanbound::base::code::Code;
use scanbound::base::facts::Facts;
use scanbound::base::time::Picos;
use scanbound::front::melsec::Melsec;
use scanbound::front::{FileKind, Fronts, Input};
use scanbound::timing::table::Table;

#[allow(dead_code)] // its `main`
#[path = "../../examples/custom_front.rs"]
mod custom_front;

use custom_front::{TIMES, Toy};

/// A registry, with its line for the toy.
static FRONTS: Fronts = Fronts(&[&Melsec, &Toy]);

fn audited(files: &[(&str, &str)]) -> Result<Audit, Failure> {
    let table = Table::parse("toy.csv", TIMES.as_bytes()).expect("a table").table;
    let input = |(name, text): &(&str, &str)| Input {
        name: (*name).to_owned(),
        bytes: text.as_bytes().to_vec(),
    };
    let inputs: Vec<Input> = files.iter().map(input).collect();
    let facts = Facts::default();
    audit(&Request { fronts: FRONTS, table: Some(&table), ..Request::new(&inputs, &facts) })
}

#[test]
fn a_toys_longest_scan_is_found_and_shown_in_its_own_names() {
    let found = audited(&[
        ("fill.toy", "toy\nwhen IN1\nfill COIL2\n"),
        ("drain.toy", "toy\nunless IN1\ndrain COIL20\n"),
        ("names.txt", "toy's names\nIN1 tank is empty\n"),
    ]);
    let audit = found.expect("an audit");
    // Filling and draining exclude each other through IN1; 16 points come in and 32 go out.
    let us = |us: u64| Picos(us * 1_000_000);
    assert_eq!(audit.bound.upper, us(1 + 2 + 1 + 80 + 10 + 4 + 2 * 5));
    assert_eq!(audit.bound.lower, audit.bound.upper);
    assert_eq!((audit.dialect.as_str(), audit.instructions), ("toy", 4));
    let tie = &audit.groups[0].ties[0];
    assert_eq!((tie.device.as_str(), tie.comment.as_str()), ("IN1", "tank is empty"));
}

#[test]
fn a_toys_faults_are_told_with_their_lines() {
    let Err(Failure::Input(faults)) = audited(&[("a.toy", "toy\nwhen IN1\njump COIL2\nfill D\n")])
    else {
        panic!("a fault in each of two lines")
    };
    let told: Vec<_> = faults.iter().map(|fault| (fault.line, fault.message.as_str())).collect();
    assert_eq!(
        told,
        [(Some(3), "'jump' is no word of a toy"), (Some(4), "'D' is no COIL and a number"),]
    );
}

#[test]
fn a_toys_files_are_told_from_those_of_other_fronts() {
    let kind = |text: &str| {
        let input = Input { name: "a.txt".to_owned(), bytes: text.as_bytes().to_vec() };
        match FRONTS.detect(&input) {
            Ok(FileKind::Program(dialect)) => Ok(dialect.name),
            Ok(FileKind::Comments) => Ok("beside"),
            Err(fault) => Err(fault.code),
        }
    };
    assert_eq!(kind("toy\nwhen IN1\n"), Ok("toy"));
    assert_eq!(kind("toy's names\n"), Ok("beside"));
    assert_eq!(kind("LD X0\nOUT Y0\nEND\n"), Ok("melsec-list"));
    assert_eq!(
        kind("LD 00000\nOUT 00100\n"),
        Err(Code::UnknownDialect),
        "a front that is not listed"
    );
    let mixed = audited(&[("a.toy", "toy\nwhen IN1\n"), ("b.il", "LD X0\nOUT Y0\nEND\n")]);
    let Err(Failure::Input(faults)) = mixed else { panic!("two dialects") };
    assert_eq!(faults[0].code, Code::MixedDialects);
}
