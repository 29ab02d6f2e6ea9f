//! A chart whose stored actions were rewritten as explicit parallels behaves as before: both are run side by side, scan
//! by scan, and every action has the same state in every one.

use common::charts;
use common::tape::cases;

use charts::{Dice, INPUTS, chart, program};
use common::chart_run::control::Output;
use common::chart_run::evaluate::Value;
use common::chart_run::run::{Options, Run};
use scanbound::iec::chart::coactive::{Basis, analyse};
use scanbound::iec::chart::explicit::explicit;
use scanbound::iec::chart::{Chart, Qualifier};
use std::collections::BTreeMap;

const BUDGET: usize = 5_000;

fn by_name(run: &Run<'_>, outputs: &[Output]) -> BTreeMap<String, Output> {
    run.actions().iter().cloned().zip(outputs.iter().copied()).collect()
}

/// Runs both charts with the same inputs at the same times.
fn side_by_side(dice: &mut Dice, before: &Chart, after: &Chart, scans: u32, options: Options) {
    let (one, two) = (program(before.clone(), 0), program(after.clone(), 0));
    let (mut first, mut second) = (Run::new(before, &one, options), Run::new(after, &two, options));
    let mut now = 0;
    let lazy = 1 + dice.below(3);
    for scan in 0..scans {
        for input in 0..INPUTS {
            let value = Value::Bool(dice.one_in(lazy));
            first.memory.set(&format!("i{input}"), value);
            second.memory.set(&format!("i{input}"), value);
        }
        let outputs = first.scan(now).expect("a scan");
        let told = by_name(&first, &outputs);
        let outputs = second.scan(now).expect("a scan");
        let again = by_name(&second, &outputs);
        for (action, output) in &told {
            // An action that only resets were left of is named no more.
            let other = again.get(action).copied().unwrap_or_default();
            let shown = || {
                let text = scanbound::iec::chart::text::chart;
                format!("{}\n{}", text(before, &[]), text(after, &[]))
            };
            assert_eq!(*output, other, "{action} in scan {scan}\n{}", shown());
        }
        let steps = before.steps.len();
        assert_eq!(first.active(), &second.active()[..steps], "steps in scan {scan}");
        now += i64::try_from(dice.below(5)).expect("small") * 5_000_000;
    }
}

#[test]
fn rewritten_charts_run_as_before_for_every_qualifier() {
    let stored = [Qualifier::S, Qualifier::Sd, Qualifier::Sl, Qualifier::Ds];
    for (number, qualifier) in stored.into_iter().enumerate() {
        let (mut rewritten, mut refused) = (0, BTreeMap::new());
        for seed in 0..cases(600) {
            let mut dice = Dice::new(seed * 4 + number as u64);
            let depth = dice.below(3);
            let actions = 1 + dice.below(2);
            let before = chart(&mut dice, depth, actions, &[qualifier]);
            let (after, told) = explicit(&before, BUDGET);
            for one in &told {
                match &one.branch {
                    Ok(_) => rewritten += 1,
                    Err(why) => {
                        *refused
                            .entry(why.split(':').next_back().map(str::to_owned))
                            .or_insert(0) += 1
                    }
                }
            }
            if told.iter().any(|one| one.branch.is_ok()) {
                let options = Options { final_scan: dice.one_in(2), ..Options::default() };
                side_by_side(&mut dice, &before, &after, 120, options);
            }
        }
        assert!(rewritten > cases(100_u32), "{qualifier:?}: {rewritten} rewritten, {refused:?}");
    }
}

#[test]
fn rewritten_charts_store_nothing_and_stay_safe() {
    let stored = [Qualifier::S, Qualifier::Sd, Qualifier::Sl, Qualifier::Ds];
    let mut seen = 0;
    for seed in 0..cases(300) {
        let mut dice = Dice::new(seed + 1_000_000);
        let before = chart(&mut dice, 2, 1, &stored);
        let (after, told) = explicit(&before, BUDGET);
        if told.is_empty() || told.iter().any(|one| one.branch.is_err()) {
            continue;
        }
        seen += 1;
        let blocks = || after.steps.iter().flat_map(|step| &step.blocks);
        assert!(blocks().all(|block| !block.qualifier.is_stored()), "all are explicit");
        assert!(matches!(analyse(&after, BUDGET).basis, Basis::Markings(_)), "and it stays safe");
    }
    assert!(seen > 30, "{seen}");
}
