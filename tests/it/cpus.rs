//! One program by every table of its family: each row says what an audit by that table says.

use scanbound::audit::cpus::{CpuCheck, CpuComparison, CpuResult, Limit, compare_cpus};
use scanbound::audit::verdict::{Check, Margin, Verdict};
use scanbound::audit::{Request, audit};
use scanbound::base::code::Code;
use scanbound::base::facts::Facts;
use scanbound::base::time::Picos;
use scanbound::front::Input;
use scanbound::timing::table::{Table, builtin, parse_override};

/// A loop that a word counts, moves by it and by an index: the pass on values has work to do.
const TEXT: &str = "LD SM400\nWAND K7 D0 D1\nMOV D1 Z0\nLD X0\nMOV K5 D100Z0\nFOR D1\nLD X1\nBMOV D200 D300 K8\nNEXT\nLDI X0\nFMOV K0 D400 D1\nEND\n";
const FACTS: &str = "[io]\ninputs = 64\noutputs = 64\n";

fn facts() -> Facts {
    Facts::parse("facts.toml", FACTS).expect("facts")
}

fn inputs() -> [Input; 1] {
    [Input { name: "main.il".to_owned(), bytes: TEXT.into() }]
}

fn chosen(request: &Request<'_>, limit: Option<Limit>) -> CpuComparison {
    let condition = CpuCheck { limit, ..CpuCheck::default() };
    compare_cpus(request, condition).expect("a choice")
}

fn upper(one: &CpuResult) -> Picos {
    one.outcome.as_ref().expect("a bound").upper.expect("an end")
}

#[test]
fn each_row_is_the_audit_by_that_table() {
    let (inputs, facts) = (inputs(), facts());
    let request = Request { cpu: Some("Q26UDV"), ..Request::new(&inputs, &facts) };
    let limit = upper(&chosen(&request, None).candidates[3]);
    let choice = chosen(&request, Some(Limit::Time(limit)));
    let names: Vec<&str> = choice.candidates.iter().map(|one| one.table.as_str()).collect();
    let mut sorted = names.clone();
    sorted.sort_unstable();
    assert_eq!(sorted, ["q00u", "q02", "q02h", "q02u", "q03ud", "qnudeh", "qnudv"]);
    for one in &choice.candidates {
        let table = Table::builtin(&one.table).expect("a table");
        let alone =
            audit(&Request { table: Some(&table), ..request_of(&request) }).expect("an audit");
        let found = one.outcome.as_ref().expect("a bound");
        assert_eq!(found.upper, Some(alone.bound.upper), "{}", one.table);
        assert_eq!(found.lower, alone.bound.lower, "{}", one.table);
        let check = Check::new(&alone, limit, Margin::default());
        assert_eq!(found.check.as_ref(), Some(&check), "{}", one.table);
        assert_eq!(one.is_own, one.table == "qnudv");
    }
    let bounds: Vec<Picos> = choice.candidates.iter().map(upper).collect();
    assert!(bounds.windows(2).all(|two| two[0] >= two[1]), "{bounds:?}");
    // The limit lies among them, and the first that keeps to it is the one that is named.
    let slowest = choice.slowest().expect("one keeps to it");
    assert!(slowest.is_proved() && upper(slowest) <= limit);
    let place = names.iter().position(|name| *name == slowest.table).expect("a row");
    assert!(place == 3 && bounds[place - 1] > limit, "{bounds:?}");
}

fn request_of<'a>(request: &Request<'a>) -> Request<'a> {
    Request { cpu: request.cpu, ..Request::new(request.inputs, request.facts) }
}

#[test]
fn each_cpus_watchdog_may_be_the_limit_and_none_may_keep_to_it() {
    let (inputs, facts) = (inputs(), facts());
    let request = Request { cpu: Some("Q02"), ..Request::new(&inputs, &facts) };
    let choice = chosen(&request, Some(Limit::Watchdog));
    for one in &choice.candidates {
        let check = one.outcome.as_ref().expect("a bound").check.as_ref().expect("a check");
        assert_eq!((check.limit, &check.verdict), (Picos(200_000_000_000), &Verdict::Proved));
    }
    assert_eq!(choice.slowest().map(|one| one.table.as_str()), Some("q02"));
    let choice = chosen(&request, Some(Limit::Time(Picos(1))));
    assert_eq!(choice.slowest(), None);
}

#[test]
fn a_table_without_a_time_has_no_bound_and_the_others_have() {
    let (inputs, facts) = (inputs(), facts());
    // A table of the user's own that knows two instructions only.
    let text = "instruction,on_us,off_us\n@family,q,\nMOV,1,1\nLD,1,1\n";
    let own = Table::parse("own.csv", text.as_bytes()).expect("a table").table;
    let request = Request { table: Some(&own), ..Request::new(&inputs, &facts) };
    let choice = chosen(&request, None);
    assert_eq!(choice.candidates.len(), builtin::of_family("q").len() + 1);
    let last = choice.candidates.last().expect("a row");
    assert!(last.is_own && last.table == "own.csv");
    let faults = last.outcome.as_ref().expect_err("no times");
    assert!(faults.iter().all(|fault| fault.code == Code::NoTime) && !faults.is_empty());
    let others = &choice.candidates[..choice.candidates.len() - 1];
    assert!(others.iter().all(|one| one.outcome.is_ok()));
    // What is stated on the command line holds by every table.
    let times = [parse_override("BMOV=900us").expect("a time")];
    let slow = Request { cpu: Some("Q26UDV"), times: &times, ..Request::new(&inputs, &facts) };
    let slow = chosen(&slow, None);
    for one in &slow.candidates {
        assert!(upper(one) >= Picos(6_300_000_000), "{}: seven moves", one.table);
    }
}
