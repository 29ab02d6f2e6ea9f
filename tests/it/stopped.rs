//! The time limit and the user end an audit while its source is read: then there is no bound, and the error says why.

use scanbound::audit::{self, Failure, Request};
use scanbound::base::code::Code;
use scanbound::base::facts::Facts;
use scanbound::front::Input;
use std::time::Duration;

const CHART: &str = "PROGRAM p VAR x : BOOL; END_VAR
INITIAL_STEP a: END_STEP STEP b: END_STEP
TRANSITION FROM a TO b := x; END_TRANSITION TRANSITION FROM b TO a := NOT x; END_TRANSITION
END_PROGRAM";

fn input(name: &str, text: &str) -> Input {
    Input { name: name.to_owned(), bytes: text.as_bytes().to_vec() }
}

/// How an audit fails on its input: codes and messages; `None` if there is a bound.
fn faults(request: &Request<'_>) -> Option<Vec<(Code, String)>> {
    match audit::audit(request) {
        Ok(_) => None,
        Err(Failure::Input(all)) => {
            Some(all.into_iter().map(|one| (one.code, one.message)).collect())
        }
        Err(other) => panic!("{other:?}"),
    }
}

#[test]
fn a_cancelled_audit_has_no_bound_of_a_source_that_is_not_read() {
    let facts = Facts::default();
    let list = "LD X0\nOUT Y0\nEND\n";
    for (name, text) in [("a.st", CHART), ("b.il", list)] {
        let inputs = [input(name, text)];
        let request = Request {
            cpu: (name == "b.il").then_some("FX5U"),
            cancelled: &|| true,
            ..Request::new(&inputs, &facts)
        };
        let message =
            "a signal (Ctrl-C, SIGTERM) ended the audit before the program was read".to_owned();
        assert_eq!(faults(&request), Some(vec![(Code::Stopped, message)]), "{name}");
    }
}

#[test]
fn the_time_limit_ends_the_lowering_of_text_and_no_list_without_a_bound() {
    let facts = Facts::default();
    let time_limit = Some(Duration::ZERO);
    let inputs = [input("a.st", CHART)];
    let found = faults(&Request { time_limit, ..Request::new(&inputs, &facts) });
    let message = "the time limit of 0ns ended the audit before the program was read".to_owned();
    assert_eq!(found, Some(vec![(Code::Stopped, message)]));
    let inputs = [input("b.il", "LD X0\nOUT Y0\nEND\n")];
    let cpu = Some("FX5U");
    assert_eq!(faults(&Request { cpu, time_limit, ..Request::new(&inputs, &facts) }), None);
}

#[test]
fn a_second_audit_that_is_stopped_leaves_the_first_as_it_is() {
    let facts = Facts::default();
    let inputs = [input("a.st", CHART)];
    let request = Request::new(&inputs, &facts);
    let mut concluded = audit::concluded(&request).expect("a bound");
    let upper = concluded.audit.bound.upper;
    let stopped = Request { cancelled: &|| true, ..request };
    audit::coactivity(&mut concluded, &stopped).expect("no fault");
    assert!(concluded.audit.coactivity.is_none() && concluded.audit.bound.upper == upper);
    audit::coactivity(&mut concluded, &request).expect("no fault");
    assert!(concluded.audit.coactivity.is_some());
}
