//! Flowchart programs: the bound against an interpreter of their own, over everything that can be open in a pass
//! and over many passes; the documents' cases with bound and way.

mod common;

use common::flowcharts::{Every, Weather, generate};
use common::tape::{Tape, cases, on_tapes};
use scanbound::audit::{Audit, Request, audit};
use scanbound::dialect::Input;
use scanbound::dialect::flowchart::decode::mnemonic;
use scanbound::dialect::flowchart::interpret::{Ended, Machine, Pass};
use scanbound::dialect::flowchart::{Source, read_text};
use scanbound::facts::Facts;
use scanbound::solve::Method;
use scanbound::table::Table;
use scanbound::time::Picos;

fn audited(name: &str, text: &str, table: &Table) -> Result<Audit, String> {
    let inputs = [Input { name: name.to_owned(), bytes: text.as_bytes().to_vec() }];
    let request = Request {
        inputs: &inputs,
        dialect: Some("flowchart"),
        cpu: None,
        table: Some(table),
        times: &[],
        facts: &Facts::default(),
        strict_times: false,
        method: Method::Auto,
        time_limit: None,
        cancelled: &|| false,
        progress: &|_| {},
    };
    audit(&request).map_err(|failure| format!("{failure:?}"))
}

fn cost(source: &Source, table: &Table, pass: &Pass) -> Picos {
    let one = |&(at, held): &(usize, bool)| {
        let row = table.row(mnemonic(source.instructions[at].op)).expect("a time");
        if held { row.on } else { row.off }
    };
    pass.ran.iter().map(one).sum()
}

fn check(tape: &[u16]) -> Result<(), String> {
    let (text, table) = generate(&mut Tape::new(tape));
    let told = |what: String| format!("{what}\n{text}\n{table}");
    let table = Table::parse("times", table.as_bytes()).map_err(|f| told(format!("{f:?}")))?.table;
    let source = read_text("random", &text).map_err(|faults| told(format!("{faults:?}")))?;
    let audit = audited("random", &text, &table).map_err(told)?;
    let upper = audit.bound.upper;
    if !audit.bound.exact() {
        return Err(told(format!("not exact: {:?}", audit.bound)));
    }
    let (mut most, mut endless, mut complete) = (Picos::ZERO, false, false);
    let mut every = Every::default();
    for _ in 0..2_000 {
        let pass = Machine::anywhere(&source).pass(&mut every);
        if pass.ended == Ended::Never {
            endless = true;
            break;
        }
        let cost = cost(&source, &table, &pass);
        if cost > upper && audit.unbounded.is_empty() {
            return Err(told(format!("the bound is {upper}, a pass takes {cost}: {pass:?}")));
        }
        most = most.max(cost);
        if !every.advance() {
            complete = true;
            break;
        }
    }
    if endless && audit.unbounded.is_empty() {
        return Err(told("a pass never ends, and the audit does not say so".to_owned()));
    }
    if complete && !audit.unbounded.is_empty() {
        return Err(told(format!("every pass ends, the audit says {:?}", audit.unbounded)));
    }
    if complete && most != upper {
        return Err(told(format!("the bound is {upper}, the longest pass takes {most}")));
    }
    // Many passes from switching on.
    let mut machine = Machine::switched_on(&source);
    let mut weather = Weather(tape.iter().map(|&word| u64::from(word)).sum());
    for _ in 0..200 {
        let pass = machine.pass(&mut weather);
        if pass.ended == Ended::Never {
            if audit.unbounded.is_empty() {
                return Err(told("a pass never ends, and the audit does not say so".to_owned()));
            }
            break;
        }
        let cost = cost(&source, &table, &pass);
        if cost > upper && audit.unbounded.is_empty() {
            return Err(told(format!("the bound is {upper}, a later pass takes {cost}: {pass:?}")));
        }
    }
    Ok(())
}

#[test]
fn the_bound_of_random_programs_is_the_longest_pass() {
    on_tapes(cases(600), 120, check);
}
