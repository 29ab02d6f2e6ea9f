//! Audits source text with a table of the test: only the instructions in the table take time.

use scanbound::audit::{Concluded, Failure, Request, conclude, follow};
use scanbound::base::facts::Facts;
use scanbound::front::Input;
use scanbound::passes::values::Trust;
use scanbound::timing::table::{CLASSES, Table};

/// A table with these rows (`Op1,1,0,0`: name, on, off, per unit). All other instructions take no time.
pub fn table(rows: &str) -> Table {
    let mut text = "instruction,on_us,off_us,per_unit_us\n".to_owned();
    for class in CLASSES {
        text += &format!("@{class},0,0,0\n");
    }
    text += rows;
    Table::parse("t.csv", text.as_bytes()).unwrap_or_else(|faults| panic!("{faults:?}")).table
}

/// The request to audit a MELSEC list.
pub fn asked<'a>(
    inputs: &'a [Input],
    table: &'a Table,
    facts: &'a Facts,
    trust: Trust,
) -> Request<'a> {
    Request {
        dialect: Some("melsec-list"),
        cpu: Some("Q26UDV"),
        table: Some(table),
        trust,
        ..Request::new(inputs, facts)
    }
}

/// A list as the only file of a project.
pub fn listed(text: impl Into<String>) -> [Input; 1] {
    [Input { name: "a.txt".to_owned(), bytes: text.into().into_bytes() }]
}

/// The project and its audit.
pub fn audited(
    dialect: &str,
    cpu: Option<&str>,
    files: &[(&str, &str)],
    table: &Table,
    facts: &Facts,
) -> Result<Concluded, String> {
    let input = |(name, text): &(&str, &str)| Input {
        name: (*name).to_owned(),
        bytes: text.as_bytes().to_vec(),
    };
    let inputs: Vec<Input> = files.iter().map(input).collect();
    // Scans may start in any state.
    let trust = Trust::None;
    let request = Request {
        dialect: Some(dialect),
        cpu,
        table: Some(table),
        trust,
        ..Request::new(&inputs, facts)
    };
    let told = |failure| match failure {
        Failure::Input(faults) => {
            let faults: Vec<String> =
                faults.iter().map(|fault| format!("{}: {}", fault.text, fault.message)).collect();
            faults.join("\n")
        }
        Failure::Internal(why) => why,
    };
    conclude(follow(&request).map_err(told)?, &request).map_err(told)
}
