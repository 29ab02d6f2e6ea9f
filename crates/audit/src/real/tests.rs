//! Tests of the search for long real runs.

use super::*;
use crate::pipeline::{Followed, follow};
use crate::request::Request;
use scanbound_base::facts::Facts;
use scanbound_front::Input;

fn followed(list: &str) -> Followed {
    let inputs = [Input { name: "a.il".to_owned(), bytes: list.as_bytes().to_vec() }];
    let facts = Facts::default();
    let request = Request { cpu: Some("Q26UDV"), ..Request::new(&inputs, &facts) };
    follow(&request).expect("a program")
}

/// Runs a program both ways: from the model's longest scan, and with early runs before that scan is known.
fn both_ways(list: &str) -> (Picos, Picos, Picos) {
    let followed = followed(list);
    let least = followed.prices.least_times();
    let (model, slices) = (&followed.model, &followed.groups);
    let methods = vec![Method::Cores; slices.len()];
    let found = maxima(model, slices, &methods, &Limits::default(), &|_, _, _| {});
    let mut all = Assignment(vec![0; model.variables.len()]);
    let mut upper = model.cost(&model.constant_charges(), &all);
    for found in &found {
        upper += found.upper;
        found.best.copy_to(&mut all);
    }
    let longest = witness(model, &all);
    let limits = Limits::default();
    let search = RunSearch { program: &followed.program, least: &least, limits };
    let other = Witness::default();
    let run = search.run([&longest, &other], upper, Knowledge::new()).unwrap();
    let early = search.search_early().unwrap();
    let beside = search.continue_from(&longest, upper, early).unwrap();
    assert!(beside.best.is_possible() && run.best.is_possible());
    (run.best.replay.total, beside.best.replay.total, upper)
}

#[test]
fn what_is_scouted_is_as_long_as_what_the_models_scan_leads_to() {
    // The path depends on the sum. The model assumes both that it is 7 or more and that it is less.
    let sum =
        "LD X0\n+ D0 D1 D2\nLD> D2 K7\nBMOV D100 D200 K50\nLD<= D2 K7\nBMOV D100 D200 K40\nEND\n";
    let sine = "LD X0\nSIN D0 D2\nLDD> D2 K5\nAND X1\nBMOV D100 D200 K50\nEND\n";
    let none = "LD X0\nMOV K1 D0\nEND\n";
    for list in [sum, sine, none] {
        let (run, beside, upper) = both_ways(list);
        assert_eq!(run, beside, "{list}");
        assert!(run <= upper);
    }
}

#[test]
fn a_run_is_worth_its_round_if_it_is_longer_by_a_hundredth() {
    let list = "LD X0\nBMOV D0 D1000 K200\nLD X1\nBMOV D0 D3000 K900\nEND\n";
    let followed = followed(list);
    let least = followed.prices.least_times();
    let search = RunSearch { program: &followed.program, least: &least, limits: Limits::default() };
    let with = |bits: &[u32]| {
        let area = followed.program.areas.iter().position(|area| area.name == "X").unwrap();
        let area = scanbound_ir::AreaId(u16::try_from(area).unwrap());
        let start = bits.iter().map(|&index| (Cell { area, index }, 1)).collect();
        search.real(&Witness { start, ..Witness::default() }).unwrap()
    };
    let (none, one, all) = (with(&[]), with(&[0]), with(&[0, 1]));
    assert!(none.replay.total < one.replay.total && one.replay.total < all.replay.total);
    assert!(!is_hardly_longer(&all, &one));
    assert!(is_hardly_longer(&one, &one) && is_hardly_longer(&none, &all));
}

#[test]
fn a_run_follows_an_address_to_the_device_that_adrset_named() {
    let list = "LD SM400\nADRSET D100 D0\nD+ D0 K5 D2\nBMOV @D2 D200 K50\nMOV K3 @D0\nLD= D200 K7\nAND= D100 K3\nBMOV D0 D3000 K900\nEND\n";
    let (run, beside, upper) = both_ways(list);
    assert_eq!((run, beside), (upper, upper));
}

#[test]
fn a_run_stops_at_an_address_that_is_not_certain() {
    let stops = |way: &str| {
        let list = format!("LD SM400\nADRSET D100 D0\n{way}\nLD SM400\nMOV @D2 D9\nEND\n");
        let followed = followed(&list);
        let least = followed.prices.least_times();
        let limits = Limits::default();
        let search = RunSearch { program: &followed.program, least: &least, limits };
        search.real(&Witness::default()).unwrap().stopped.map(|stopped| stopped.reason)
    };
    assert_eq!(stops("D+ D0 K9 D2"), None);
    assert_eq!(stops("DMOV D0 D2\nDINC D2"), None);
    for way in [
        // Beyond the data registers; the halves moved separately; not a sum; a sum of two addresses; only the low
        // word added; written afterwards, and without ADRSET.
        "D- D0 K101 D2",
        "MOV D0 D2\nMOV D1 D3",
        "DAND D0 D0 D2",
        "D+ D0 D0 D2",
        "DMOV D0 D2\nINC D2",
        "DMOV D0 D2\nMOV D0 D2",
        "DMOV K1 D2",
    ] {
        let reason = stops(way);
        assert!(matches!(reason, Some(StopReason::Unknown(_))), "{way}: {reason:?}");
    }
}

#[test]
fn what_a_module_delivers_does_not_change_within_a_run() {
    let runs = |first: &str, second: &str| {
        let list = format!(
            "{first}\nBMOV D1000 D2000 K500\n{second}\nBMOV D1000 D2000 K500\nLD X0\nZP.OPEN \"U0\" K1 D10 M100\nEND\n"
        );
        both_ways(&list)
    };
    let (none, ..) = runs("LDI SM400", "LDI SM400");
    let (twice, ..) = runs("LD M100", "LD M100");
    let (once, _, upper) = runs("LD M100", "LDI M100");
    assert!(none < once && once < twice, "{none} {once} {twice}");
    // The analysis lets it change.
    assert!(once < upper && twice <= upper, "{once} {upper}");
}

#[test]
fn a_scouted_run_above_the_bound_is_an_error() {
    let followed = followed("LD X0\nBMOV D100 D200 K50\nEND\n");
    let least = followed.prices.least_times();
    let limits = Limits::default();
    let search = RunSearch { program: &followed.program, least: &least, limits };
    let early = search.search_early().unwrap();
    assert!(early.goes_on);
    let low = Picos(early.found.best.replay.total.0 - 1);
    let found = search.continue_from(&Witness::default(), low, early);
    assert!(found.is_err_and(|told| told.contains("more than the bound of")));
}
