//! Bounds of random programs under a table in which stores count and one call, the probe, takes longer than all of
//! them.

#![allow(dead_code, reason = "not every test binary has random programs of this kind")]

use scanbound::audit::{Audit, Failure, Request, audit};
use scanbound::base::facts::Facts;
use scanbound::front::Input;
use scanbound::passes::values::Trust;
use scanbound::timing::table::{CLASSES, Table};
use std::time::Duration;

/// What the probe takes, in microseconds; a store takes one.
pub const PROBE: u64 = 1_000_000;

/// A table in which everything but these rows and the probe takes no time.
fn table(rows: &str) -> Table {
    let mut text = "instruction,on_us,off_us\n".to_owned();
    for class in CLASSES {
        text += &format!("@{class},0,0\n");
    }
    text += &format!("ST,1,1\n{rows}LN,{PROBE},{PROBE}\n@end,0,\n");
    Table::parse("t.csv", text.as_bytes()).unwrap_or_else(|faults| panic!("{faults:?}")).table
}

/// A bound that the time limit ends is a bound all the same. Few programs need more than a second.
const LONGEST: Duration = Duration::from_secs(20);

/// The audit of files (name, text), or the first fault.
///
/// # Panics
/// The audit fails other than by a fault in the files.
pub fn audited(files: &[(&str, &str)], rows: &str, trust: Trust) -> Result<Audit, String> {
    let table = table(rows);
    let input = |&(name, text): &(&str, &str)| Input {
        name: name.to_owned(),
        bytes: text.as_bytes().to_vec(),
    };
    let inputs: Vec<Input> = files.iter().map(input).collect();
    let facts = Facts::default();
    let request = Request {
        table: Some(&table),
        trust,
        time_limit: Some(LONGEST),
        ..Request::new(&inputs, &facts)
    };
    match audit(&request) {
        Ok(found) => Ok(found),
        Err(Failure::Input(faults)) => {
            Err(faults.first().map_or(String::new(), |one| one.message.clone()))
        }
        Err(other) => panic!("{other:?}\n{files:?}"),
    }
}

/// The bound in microseconds.
pub fn bound(found: &Audit) -> u64 {
    found.bound.upper.0 / 1_000_000
}
