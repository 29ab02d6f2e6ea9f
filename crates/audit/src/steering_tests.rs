//! Tests of steering: runs that start with 0 everywhere are led to expensive instructions.

use super::pipeline::follow;
use super::real::{RunResults, RunSearch};
use super::request::Request;
use scanbound_base::facts::Facts;
use scanbound_base::time::Picos;
use scanbound_front::Input;
use scanbound_ir::Witness;
use scanbound_ir::meaning::Knowledge;
use scanbound_solve::Limits;

/// The time of the run that starts with 0 everywhere, and of the one to which it is steered.
fn steered(list: &str) -> (Picos, Picos) {
    let inputs = [Input { name: "a.il".to_owned(), bytes: list.as_bytes().to_vec() }];
    let facts = Facts::default();
    let request = Request { cpu: Some("Q26UDV"), ..Request::new(&inputs, &facts) };
    let followed = follow(&request).expect("a program");
    let least = followed.prices.least_times();
    let limits = Limits::default();
    let search = RunSearch { program: &followed.program, least: &least, limits };
    let start = Witness::default();
    let run = search.real(&start).unwrap();
    let first = run.replay.total;
    let mut found = RunResults::first(&followed.program, run, start, Knowledge::new());
    search.steer(&mut found, None).unwrap();
    assert_eq!(search.real(&found.witness).unwrap().replay.total, found.best.replay.total);
    (first, found.best.replay.total)
}

#[test]
fn a_run_is_steered_to_what_is_expensive() {
    let move_all = "BMOV D1000 D3000 K900";
    for way in [
        "LD X0",
        "LD X0\nAND X1\nLDI X2\nAND X3\nORB\nANI X4",
        "LD X0\nMPS\nAND X1\nOUT M9\nMPP\nANI X1",
        "LD X0\nOUT M0\nLD M0",
        "LD SM400\nMOV D5 D6\nLD= D6 K7",
        "LD SM400\nMOV K3 Z1\nLD> D5Z1 K7\nAND M2Z1",
        "LD SM400\nMOV K4X10 D6\nLD D6.B",
        "LD X0\nRST M3\nLD M3",
        "LDD= D10 K70000\nAND<> D12 K0",
        "LD X0\nMC N0 M0\nLD X1\nOUT M1\nMCR N0\nLD M1",
        "LD SM400\nMOV K4X10 D6\nSFR D6 K1\nLD SM700",
        "LD SM400\nMOV K4X10Z1 D6\nROL D6 K3\nLD D6.2",
        "LD SM400\nBMOV D20 D40 K9\nLD D44.7\nAND= D46 K9",
        "LD SM400\nMOV K3 Z1\nBMOV D20Z1 D40 K9\nSWAP D41\nLD D41.B",
        "LD SM400\nWTOB D20 D40 K6\nLD D43.2",
        "LD SM400\nDECO D20 M40 K3\nLD M44",
    ] {
        let (first, last) = steered(&format!("{way}\n{move_all}\nEND\n"));
        // The move takes more than 10 us longer if it fires.
        assert!(last.0 > first.0 + 10_000_000, "{way}: {first} {last}");
    }
    let (first, last) =
        steered("LD X0\nCALL P0\nFEND\nP0\nLD X1\nBMOV D1000 D3000 K900\nRET\nEND\n");
    assert!(last.0 > first.0 + 10_000_000, "{first} {last}");
}

#[test]
fn a_run_is_steered_around_what_stops_it() {
    // Where the address comes from is unknown.
    let (first, last) = steered("LDI X0\nMOV @D0 D2\nLD SM400\nBMOV D1000 D3000 K900\nEND\n");
    assert!(last.0 > first.0 + 10_000_000, "{first} {last}");
}

#[test]
fn a_run_is_steered_around_operation_errors() {
    // A lower limit above the upper one stops the CPU: at the first instruction, and behind it.
    let (first, last) = steered(
        "LD SM400\nDLIMIT K1 D10 D20 D22\nLIMIT K5 D12 D24 D26\nLD X0\nBMOV D1000 D3000 K900\nEND\n",
    );
    assert!(last.0 > first.0 + 10_000_000, "{first} {last}");
}
