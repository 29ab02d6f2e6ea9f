//! The bound of charts, against the interpreter that runs the chart itself: the same on small charts, over all states
//! that can be reached, all inputs and times; never below it in long runs of larger ones.

use common::charts;
use common::tape::cases;

use charts::{Dice, chart, is_done_alike};
use common::chart_run::control::Output;
use common::chart_run::evaluate::Value;
use common::chart_run::run::{Options, Run};
use scanbound::audit::{Concluded, Request, audit, coactivity, conclude, follow};
use scanbound::base::facts::{ActionOrder, Facts};
use scanbound::base::time::Picos;
use scanbound::front::Input;
use scanbound::iec::ast::Expr;
use scanbound::iec::chart::{Chart, Qualifier, text};
use scanbound::iec::{Body, Pou, parse};
use scanbound::passes::values::Trust;
use scanbound::timing::table::{CLASSES, Table};
use std::collections::BTreeSet;

const MS: i64 = 1_000_000;
/// Longer than any time in these charts.
const HORIZON: i64 = 100 * MS;
/// More states than this are not searched.
const STATES: usize = 20_000;

/// A table in which nothing costs anything but stores.
fn table() -> Table {
    let mut text = "instruction,on_us,off_us\n".to_owned();
    for class in CLASSES {
        text += &format!("@{class},0,0\n");
    }
    text += "ST,1,1\n@end,0,\n";
    Table::parse("t.csv", text.as_bytes()).unwrap_or_else(|faults| panic!("{faults:?}")).table
}

/// What each action takes: a store the first, two the second, four the third ...
fn weight(action: &str) -> u64 {
    1 << action.trim_start_matches('m').parse::<u32>().expect("a number")
}

/// A program around a chart, as text.
fn program(chart: &Chart, inputs: usize) -> String {
    let mut source = "PROGRAM main\nVAR\n  v : BOOL;\n".to_owned();
    for input in 0..inputs {
        source += &format!("  i{input} AT %IX0.{input} : BOOL;\n");
    }
    source += "END_VAR\n";
    source += &text::chart(chart, &[]);
    for action in chart.actions() {
        let body = "    v := TRUE;\n".repeat(usize::try_from(weight(&action)).expect("small"));
        source += &format!("  ACTION {action}:\n{body}  END_ACTION\n");
    }
    source + "END_PROGRAM\n"
}

fn bound(source: &str) -> Picos {
    stated(source, &Facts::default())
}

/// The bound where of competing transitions the first clears, or all.
fn bound_by(source: &str, selection: &str) -> Picos {
    let facts = format!("[sfc]\nselection = '{selection}'\n");
    stated(source, &Facts::parse("facts.toml", &facts).expect("facts"))
}

fn stated(source: &str, facts: &Facts) -> Picos {
    let inputs = [Input { name: "main.st".to_owned(), bytes: source.as_bytes().to_vec() }];
    let table = table();
    let request =
        Request { table: Some(&table), trust: Trust::None, ..Request::new(&inputs, facts) };
    audit(&request).unwrap_or_else(|failure| panic!("{failure:?}\n{source}")).bound.upper
}

fn read(source: &str) -> Pou {
    parse::file("main.st", source)
        .unwrap_or_else(|faults| panic!("{faults:?}\n{source}"))
        .pous
        .remove(0)
}

fn cost(run: &Run<'_>, outputs: &[Output]) -> u64 {
    let own = run.actions().iter().zip(outputs).filter(|(_, output)| output.runs);
    own.map(|(action, _)| weight(action)).sum()
}

/// The most that a scan takes, over all states that can be reached, all inputs and times; `None` if there are too many.
fn most(chart: &Chart, pou: &Pou) -> Option<u64> {
    most_of(chart, pou, Options::default(), &[0], &cost)
}

/// The same, whichever of these a variable `w` holds when a scan starts, by what a scan takes.
fn most_of(
    chart: &Chart,
    pou: &Pou,
    options: Options,
    starts: &[i64],
    cost: &dyn Fn(&Run<'_>, &[Output]) -> u64,
) -> Option<u64> {
    let mut largest = 0;
    let mut first = Run::new(chart, pou, options);
    for &start in starts {
        first = Run::new(chart, pou, options);
        first.memory.set("w", Value::Int(start));
        let outputs = first.scan(0).expect("a scan");
        largest = largest.max(cost(&first, &outputs));
    }
    let mut known = BTreeSet::from([first.state()]);
    let mut open = vec![first];
    while let Some(run) = open.pop() {
        let enabled: Vec<usize> = (0..chart.transitions.len())
            .filter(|&at| chart.transitions[at].from.iter().all(|&step| run.active()[step]))
            .collect();
        for mask in 0..1_u32 << enabled.len() {
            for (elapsed, &start) in
                [5 * MS, HORIZON].into_iter().flat_map(|time| starts.iter().map(move |w| (time, w)))
            {
                let mut next = run.clone();
                next.memory.set("w", Value::Int(start));
                next.memory.set("cost", Value::Int(0));
                for (bit, &at) in enabled.iter().enumerate() {
                    next.memory.set(&format!("i{at}"), Value::Bool(mask >> bit & 1 == 1));
                }
                let outputs = next.scan(elapsed).expect("a scan");
                largest = largest.max(cost(&next, &outputs));
                next.begin_time_at(elapsed, HORIZON);
                if known.insert(next.state()) {
                    if known.len() > STATES {
                        return None;
                    }
                    open.push(next);
                }
            }
        }
    }
    Some(largest)
}

/// Lets every transition have an input of its own, so that nothing but the chart itself excludes anything.
fn with_own_inputs(mut chart: Chart) -> Chart {
    for (at, one) in chart.transitions.iter_mut().enumerate() {
        one.condition = Expr::name(format!("i{at}"));
    }
    chart
}

fn timed(chart: &Chart) -> usize {
    let actions = chart.actions();
    let feeds = actions.iter().flat_map(|action| chart.inputs_of(action));
    feeds.filter(|feed| feed.qualifier.is_timed()).count()
}

#[test]
fn small_charts_have_the_bound_that_the_interpreter_finds() {
    let (mut equal, mut above) = (0, Vec::new());
    for seed in 0..cases(50) {
        let mut dice = Dice::new(seed + 77);
        let depth = dice.below(3);
        let actions = 1 + dice.below(3);
        let chart = with_own_inputs(chart(&mut dice, depth, actions, &Qualifier::ALL));
        // Timers that hang on each other are followed one by one: what two of them do together may be more than they
        // can.
        if timed(&chart) > 1 || chart.transitions.len() > 14 {
            continue;
        }
        let source = program(&chart, chart.transitions.len());
        let pou = read(&source);
        let Body::Chart(own) = &pou.body else { panic!("a chart") };
        let Some(most) = most(own, &pou) else { continue };
        let upper = bound_by(&source, "first");
        let most = Picos(most * 1_000_000);
        assert!(upper >= most, "bound {} below {}\n{source}", upper.us_text(), most.us_text());
        if upper == most {
            equal += 1;
        } else if is_done_alike(&chart) {
            above.push(source);
        }
    }
    assert!(equal > cases(13_u32) && above.is_empty(), "{equal} equal, above: {above:#?}");
}

#[test]
fn a_bound_covers_controllers_on_which_one_of_competing_transitions_clears_or_all() {
    let (mut all, mut higher) = (0, 0);
    for seed in 0..cases(100) {
        let mut dice = Dice::new(seed + 11_000_000);
        let depth = 1 + dice.below(2);
        let chart = with_own_inputs(chart(&mut dice, depth, 3, &[Qualifier::N, Qualifier::S]));
        if chart.transitions.len() > 7 || !chart.competes() {
            continue;
        }
        let source = program(&chart, chart.transitions.len());
        let pou = read(&source);
        let Body::Chart(own) = &pou.body else { panic!("a chart") };
        let found = [true, false].map(|priority| {
            most_of(own, &pou, Options { priority, ..Options::default() }, &[0], &cost)
        });
        let [Some(first), Some(both)] = found else { continue };
        let longest = Picos(first.max(both) * 1_000_000);
        let either = bound(&source);
        assert!(either >= longest, "{} below {}\n{source}", either.us_text(), longest.us_text());
        assert!(bound_by(&source, "all") >= Picos(both * 1_000_000), "{source}");
        assert!(either >= bound_by(&source, "first"), "{source}");
        all += 1;
        higher += u64::from(both > first);
    }
    assert!(higher > 0, "{higher} of {all} take longer where all clear");
}

/// A program whose actions ask which of them came before, and take the longer for one of these. `store`: what takes so
/// much.
fn asking(chart: &Chart, dice: &mut Dice, store: &dyn Fn(u64) -> String) -> String {
    let mut source = "PROGRAM main\nVAR\n  v : BOOL; w, cost : INT;\n".to_owned();
    for input in 0..chart.transitions.len() {
        source += &format!("  i{input} AT %IX0.{input} : BOOL;\n");
    }
    source += "END_VAR\n";
    source += &text::chart(chart, &[]);
    let mut actions = chart.actions();
    // They are declared in an order of their own.
    for at in (1..actions.len()).rev() {
        actions.swap(at, usize::try_from(dice.below(at as u64 + 1)).expect("small"));
    }
    for action in &actions {
        let asked = dice.below(actions.len() as u64);
        let own = weight(action).trailing_zeros();
        let body = store(weight(action));
        source += &format!(
            "  ACTION {action}: IF w = {asked} THEN {body} END_IF; w := {own}; END_ACTION\n"
        );
    }
    source + "END_PROGRAM\n"
}

#[test]
fn charts_have_the_bound_of_the_order_that_is_stated_and_of_any_where_none_is() {
    let (mut all, mut differ, mut exact, mut orders) = (0, 0, 0, 0);
    for seed in 0..cases(15) {
        let mut dice = Dice::new(seed + 9_000_000);
        let depth = dice.below(3);
        let actions = 2 + dice.below(2);
        let chart = with_own_inputs(chart(&mut dice, depth, actions, &[Qualifier::N]));
        if chart.transitions.len() > 10 || !is_done_alike(&chart) {
            continue;
        }
        let stores = |count: u64| "v := TRUE; ".repeat(usize::try_from(count).expect("small"));
        let source = asking(&chart, &mut Dice::new(seed), &stores);
        let counts = |count: u64| format!("cost := cost + {count};");
        let counting = asking(&chart, &mut Dice::new(seed), &counts);
        let pou = read(&counting);
        let Body::Chart(own) = &pou.body else { panic!("a chart") };
        let cost = |run: &Run<'_>, outputs: &[Output]| {
            let ran = outputs.iter().filter(|output| output.runs).count() as u64;
            match run.memory.get("cost") {
                Some(Value::Int(cost)) => ran + u64::try_from(cost).expect("a cost"),
                _ => ran,
            }
        };
        let starts: Vec<i64> = (0..=i64::try_from(actions).expect("small")).collect();
        let mut most = BTreeSet::new();
        for order in ActionOrder::ALL {
            // The final scan may be left out, which may take longer here.
            let found = [true, false].map(|final_scan| {
                let options = Options { order, final_scan, ..Options::default() };
                most_of(own, &pou, options, &starts, &cost)
            });
            let Some(found) = found.into_iter().collect::<Option<Vec<u64>>>() else { continue };
            let found = found.into_iter().max().expect("two");
            let facts = format!("[sfc]\naction_order = '{}'\n", order.name());
            let facts = Facts::parse("facts.toml", &facts).expect("facts");
            let upper = stated(&source, &facts);
            assert!(upper >= Picos(found * 1_000_000), "seed {seed}, {order:?}\n{source}");
            // Where several blocks name one action, the last may have its way, which the interpreter does not know.
            exact += u64::from(upper == Picos(found * 1_000_000));
            orders += 1;
            most.insert(found);
        }
        let Some(&longest) = most.last() else { continue };
        assert!(bound(&source) >= Picos(longest * 1_000_000), "seed {seed}\n{source}");
        all += 1;
        differ += u64::from(most.len() > 1);
    }
    assert!(all > cases(2_u32) && differ > 0, "{all} charts, of {differ} the order matters");
    assert!(exact * 2 > orders, "{exact} of {orders} bounds are the longest scan");
}

#[test]
fn no_scan_of_a_long_run_takes_longer_than_the_bound() {
    for seed in 0..cases(8) {
        let mut dice = Dice::new(seed + 5_000_000);
        let actions = 2 + dice.below(3);
        let depth = 1 + dice.below(2);
        let chart = chart(&mut dice, depth, actions, &Qualifier::ALL);
        let source = program(&chart, usize::try_from(charts::INPUTS).expect("small"));
        let pou = read(&source);
        let Body::Chart(own) = &pou.body else { panic!("a chart") };
        let upper = bound(&source);
        let mut run = Run::new(own, &pou, Options::default());
        let mut now = 0;
        let lazy = 1 + dice.below(3);
        for scan in 0..400 {
            for input in 0..charts::INPUTS {
                run.memory.set(&format!("i{input}"), Value::Bool(dice.one_in(lazy)));
            }
            let outputs = run.scan(now).expect("a scan");
            let took = Picos(cost(&run, &outputs) * 1_000_000);
            assert!(
                took <= upper,
                "scan {scan} takes {}, bound {}\n{source}",
                took.us_text(),
                upper.us_text()
            );
            now += i64::try_from(dice.below(6)).expect("small") * 5 * MS;
        }
    }
}

#[test]
fn what_co_activity_takes_off_is_told_with_what_is_active() {
    let source = "PROGRAM main VAR v : BOOL; i0 AT %IX0.0 : BOOL; END_VAR
        INITIAL_STEP s: m0(N); END_STEP STEP t: m1(N); END_STEP STEP u: m2(N); END_STEP
        TRANSITION FROM s TO t := i0; END_TRANSITION TRANSITION FROM t TO u := i0; END_TRANSITION
        TRANSITION FROM u TO s := i0; END_TRANSITION
        ACTION m0: v := TRUE; END_ACTION ACTION m1: v := TRUE; v := TRUE; END_ACTION
        ACTION m2: v := TRUE; v := TRUE; v := TRUE; v := TRUE; END_ACTION END_PROGRAM";
    let inputs = [Input { name: "main.st".to_owned(), bytes: source.as_bytes().to_vec() }];
    let (facts, table) = (Facts::default(), table());
    let request = Request { table: Some(&table), ..Request::new(&inputs, &facts) };
    let followed = follow(&request).unwrap_or_else(|fault| panic!("{fault:?}"));
    let mut concluded: Concluded =
        conclude(followed, &request).unwrap_or_else(|fault| panic!("{fault:?}"));
    coactivity(&mut concluded, &request).unwrap_or_else(|fault| panic!("{fault:?}"));
    let found = concluded.audit.coactivity.expect("a chart");
    // The step that is entered, and the final scan of the one that is left; else all three.
    assert_eq!(concluded.audit.bound.upper, Picos(6_000_000));
    assert_eq!(found.without.upper, Picos(7_000_000));
    assert!(found.active.iter().any(|name| name == "main.t.X"), "{:?}", found.active);
    assert!(found.active.iter().any(|name| name == "main.action m1.on"), "{:?}", found.active);
}
