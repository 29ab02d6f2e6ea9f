//! A bounded proof by Z3 that the rewriting keeps every scan: the original and the rewritten chart are unrolled over
//! some scans, with free inputs, free moments of the scans and a free time of the qualifier, and no values of these
//! make an action or a step differ in any scan. What charts mean is written here once more, as formulas.

use scanbound::iec::ast::{Expr, Literal, Operator, Part};
use scanbound::iec::chart::explicit::explicit;
use scanbound::iec::chart::{Chart, Qualifier};
use scanbound::iec::{Body, read};
use std::fmt::Write;
use z3::{SatResult, Solver};

/// How many scans are unrolled: enough to go round, and store again.
const SCANS: usize = 9;

/// A chart as formulas over the scans; its names begin with a letter of its own.
struct Unrolled<'c> {
    chart: &'c Chart,
    own: char,
    text: String,
}

fn any(all: impl IntoIterator<Item = String>) -> String {
    let all: Vec<String> = all.into_iter().collect();
    if all.is_empty() { "false".to_owned() } else { format!("(or {})", all.join(" ")) }
}

fn both(one: &str, other: &str) -> String {
    format!("(and {one} {other})")
}

fn not(one: &str) -> String {
    format!("(not {one})")
}

impl Unrolled<'_> {
    fn define(&mut self, name: &str, sort: &str, value: &str) -> String {
        let name = format!("{}_{name}", self.own);
        writeln!(self.text, "(define-fun {name} () {sort} {value})").expect("written");
        name
    }

    fn active(&self, step: usize, scan: usize) -> String {
        format!("{}_s{step}_{scan}", self.own)
    }

    fn any_active(&self, steps: &[usize], scan: usize) -> String {
        any(steps.iter().map(|step| self.active(*step, scan)))
    }

    /// A condition as it is in a scan, on the steps as they were after the one before.
    fn condition(&self, one: &Expr, scan: usize) -> String {
        match one {
            Expr::Literal(Literal::Bool(value)) => value.to_string(),
            Expr::Literal(Literal::Time(_)) => "limit".to_owned(),
            Expr::Not(inner) => not(&self.condition(inner, scan)),
            Expr::Binary(operator, left, right) => {
                let sign = match operator {
                    Operator::And => "and",
                    Operator::Or => "or",
                    Operator::GreaterOrEqual => ">=",
                    Operator::Less => "<",
                    other => panic!("{other:?}"),
                };
                let [left, right] = [left, right].map(|one| self.condition(one, scan));
                format!("({sign} {left} {right})")
            }
            Expr::Variable(path) => match &path.rest[..] {
                [] => format!("{}_{scan}", path.first),
                [Part::Name(part)] => {
                    let step = self.chart.step(&path.first).expect("a step");
                    let active = self.active(step, scan - 1);
                    match part.to_ascii_uppercase().as_str() {
                        "X" => active,
                        _ => {
                            let since = format!("{}_since{step}_{}", self.own, scan - 1);
                            format!("(ite {active} (- now_{scan} {since}) 0)")
                        }
                    }
                }
                other => panic!("{other:?}"),
            },
            other => panic!("{other:?}"),
        }
    }

    fn evolve(&mut self, scan: usize) {
        let chart = self.chart;
        if scan == 0 {
            for (at, step) in chart.steps.iter().enumerate() {
                self.define(&format!("s{at}_0"), "Bool", &step.initial.to_string());
                self.define(&format!("since{at}_0"), "Int", "now_0");
            }
            return;
        }
        let mut clears: Vec<String> = Vec::new();
        for (number, one) in chart.transitions.iter().enumerate() {
            let steps: Vec<String> =
                one.from.iter().map(|step| self.active(*step, scan - 1)).collect();
            let rivals = (0..number)
                .filter(|other| {
                    chart.transitions[*other].from.iter().any(|step| one.from.contains(step))
                })
                .map(|other| clears[other].clone());
            let free = not(&any(rivals));
            let condition = self.condition(&one.condition, scan);
            let value = format!("(and {} {free} {condition})", steps.join(" "));
            clears.push(self.define(&format!("t{number}_{scan}"), "Bool", &value));
        }
        for at in 0..chart.steps.len() {
            let those = |is: &dyn Fn(usize) -> bool| {
                any((0..clears.len())
                    .filter(|number| is(*number))
                    .map(|number| clears[number].clone()))
            };
            let entered = those(&|number| chart.transitions[number].to.contains(&at));
            let left = those(&|number| chart.transitions[number].from.contains(&at));
            let before = self.active(at, scan - 1);
            let stays = both(&before, &not(&left));
            let now =
                self.define(&format!("s{at}_{scan}"), "Bool", &format!("(or {entered} {stays})"));
            let since = format!("{}_since{at}_{}", self.own, scan - 1);
            let value = format!("(ite (and {now} (not {before})) now_{scan} {since})");
            self.define(&format!("since{at}_{scan}"), "Int", &value);
        }
    }

    /// What was remembered under a name in the scan before.
    fn before(&self, name: &str, scan: usize, at_first: &str) -> String {
        match scan {
            0 => at_first.to_owned(),
            _ => format!("{}_{name}_{}", self.own, scan - 1),
        }
    }

    /// An on-delay: whether its input has been true for the time.
    fn timer(&mut self, name: &str, input: &str, scan: usize) -> String {
        let (ran, began) = (format!("{name}runs"), format!("{name}began"));
        let was = self.before(&ran, scan, "false");
        let since = self.before(&began, scan, "0");
        let since = format!("(ite {was} {since} now_{scan})");
        let began = self.define(&format!("{began}_{scan}"), "Int", &since);
        self.define(&format!("{ran}_{scan}"), "Bool", input);
        format!("(and {input} (>= (- now_{scan} {began}) limit))")
    }

    /// The state of an action in a scan.
    fn act(&mut self, action: &str, scan: usize) -> String {
        let feeds = self.chart.inputs_of(action);
        let of = |own: &Self, qualifier: Qualifier| {
            let feeds = feeds.iter().filter(|feed| feed.qualifier == qualifier);
            any(feeds.map(|feed| own.any_active(&feed.steps, scan)).collect::<Vec<_>>())
        };
        let stays = not(&of(self, Qualifier::R));
        let keep = |own: &mut Self, name: &str, sets: &str| {
            let was = own.before(name, scan, "false");
            own.define(
                &format!("{name}_{scan}"),
                "Bool",
                &format!("(and (or {was} {sets}) {stays})"),
            )
        };
        let sets = of(self, Qualifier::S);
        let stored = keep(self, &format!("{action}_stored"), &sets);
        let mut on = vec![of(self, Qualifier::N), stored];
        for (number, feed) in feeds.iter().enumerate() {
            let name = format!("{action}_f{number}");
            let active = self.any_active(&feed.steps, scan);
            match feed.qualifier {
                Qualifier::L => {
                    let over = self.timer(&name, &active, scan);
                    on.push(both(&active, &not(&over)));
                }
                Qualifier::D => on.push(self.timer(&name, &active, scan)),
                Qualifier::Sd => {
                    let stored = keep(self, &name, &active);
                    on.push(self.timer(&name, &stored, scan));
                }
                Qualifier::Sl => {
                    let stored = keep(self, &name, &active);
                    let over = self.timer(&name, &stored, scan);
                    on.push(both(&stored, &not(&over)));
                }
                Qualifier::Ds => {
                    let due = self.timer(&name, &active, scan);
                    on.push(keep(self, &name, &due));
                }
                _ => {}
            }
        }
        both(&any(on), &stays)
    }
}

fn unrolled(chart: &Chart, own: char) -> (String, Vec<Vec<String>>) {
    let mut all = Unrolled { chart, own, text: String::new() };
    let mut states = Vec::new();
    for scan in 0..SCANS {
        all.evolve(scan);
        let steps = (0..chart.steps.len()).map(|step| all.active(step, scan)).collect();
        let mut seen: Vec<String> = steps;
        for action in ["A", "B"] {
            let state = all.act(action, scan);
            seen.push(all.define(&format!("{action}_{scan}"), "Bool", &state));
        }
        states.push(seen);
    }
    (all.text, states)
}

/// Whether some inputs, moments and a time make the charts differ in a scan, in an action or in a step of the first.
fn can_differ(before: &Chart, after: &Chart) -> SatResult {
    let mut text = "(declare-const limit Int)\n(assert (> limit 0))\n".to_owned();
    for scan in 0..SCANS {
        for input in ["i0", "i1", "i2"] {
            writeln!(text, "(declare-const {input}_{scan} Bool)").expect("written");
        }
        writeln!(text, "(declare-const now_{scan} Int)").expect("written");
        if scan > 0 {
            writeln!(text, "(assert (>= now_{scan} now_{}))", scan - 1).expect("written");
        }
    }
    let (one, first) = unrolled(before, 'a');
    let (two, second) = unrolled(after, 'b');
    text += &(one + &two);
    let steps = before.steps.len();
    let mut differ = Vec::new();
    for (first, second) in first.iter().zip(&second) {
        let actions = [first.len() - 2, first.len() - 1]
            .into_iter()
            .zip([second.len() - 2, second.len() - 1]);
        let pairs = (0..steps).map(|step| (step, step)).chain(actions);
        differ.extend(pairs.map(|(one, two)| format!("(xor {} {})", first[one], second[two])));
    }
    writeln!(text, "(assert {})", any(differ)).expect("written");
    let solver = Solver::new();
    solver.from_string(text);
    solver.check()
}

/// An action that is stored in a loop with a selection: reset on one way, stored again on both.
fn example(qualifier: Qualifier) -> Chart {
    let time = if qualifier.is_timed() { ", T#50ms" } else { "" };
    let name = qualifier.name();
    let text = format!(
        "PROGRAM p VAR i0, i1, i2, A, B : BOOL; END_VAR
         INITIAL_STEP a: END_STEP
         STEP b: A({name}{time}); END_STEP
         STEP c: B(N); END_STEP
         STEP d: A(R); END_STEP
         TRANSITION FROM a TO b := i0; END_TRANSITION
         TRANSITION FROM b TO c := i1; END_TRANSITION
         TRANSITION FROM c TO d := i2; END_TRANSITION
         TRANSITION FROM c TO b := i0; END_TRANSITION
         TRANSITION FROM d TO a := i1; END_TRANSITION
         END_PROGRAM"
    );
    let project = read("p.st", &text).expect("a program");
    match &project.pous[0].body {
        Body::Chart(chart) => (**chart).clone(),
        _ => panic!("a chart"),
    }
}

fn rewritten(before: &Chart) -> Chart {
    let (after, told) = explicit(before, 5_000);
    assert!(told.len() == 1 && told[0].branch.is_ok(), "{told:?}");
    assert!(after.steps.len() > before.steps.len());
    after
}

fn proved(qualifier: Qualifier) {
    let before = example(qualifier);
    let after = rewritten(&before);
    assert_eq!(can_differ(&before, &after), SatResult::Unsat, "{qualifier:?}");
}

#[test]
fn s_and_r_are_proved() {
    proved(Qualifier::S);
}

#[test]
fn sd_and_r_are_proved() {
    proved(Qualifier::Sd);
}

#[test]
fn sl_and_r_are_proved() {
    proved(Qualifier::Sl);
}

#[test]
fn ds_and_r_are_proved() {
    proved(Qualifier::Ds);
}

/// What is not the same is found: a branch that begins without its timer, one that does not wait for the reset, another
/// qualifier.
#[test]
fn what_differs_is_found() {
    for (qualifier, other) in [
        (Qualifier::S, Qualifier::Sd),
        (Qualifier::Sd, Qualifier::Ds),
        (Qualifier::Ds, Qualifier::S),
        (Qualifier::Sl, Qualifier::S),
    ] {
        let after = rewritten(&example(other));
        assert_eq!(can_differ(&example(qualifier), &after), SatResult::Sat, "{qualifier:?}");
    }
    for qualifier in [Qualifier::S, Qualifier::Sd, Qualifier::Sl, Qualifier::Ds] {
        let before = example(qualifier);
        let mut after = rewritten(&before);
        // Its last transition, which the rewriting made or changed, clears a scan later than it should, or never.
        let steps = before.steps.len();
        let touched = after.transitions.iter_mut().rev();
        let one = touched
            .into_iter()
            .find(|one| one.from.iter().chain(&one.to).any(|step| *step >= steps));
        one.expect("a transition of the branch").condition = Expr::bool(false);
        assert_eq!(can_differ(&before, &after), SatResult::Sat, "{qualifier:?}");
    }
}
