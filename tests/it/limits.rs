//! Searches that end when a limit is decided: the verdict is that of the whole search, and every run ends alike.

#[path = "../../benches/common/plant.rs"]
mod plant;
#[path = "../../benches/common/pools.rs"]
mod pools;

use scanbound::audit::verdict::{Check, Margin, Verdict};
use scanbound::audit::{Audit, Failure, Request, audit};
use scanbound::base::code::Code;
use scanbound::base::facts::Facts;
use scanbound::base::time::Picos;
use scanbound::front::Input;
use scanbound::timing::table::Table;
use std::time::Duration;

struct Case {
    inputs: Vec<Input>,
    table: Table,
    facts: Facts,
}

impl Case {
    fn audit(&self, limit: Option<Picos>, threads: usize) -> Audit {
        self.audit_within(limit, threads, None)
    }

    fn audit_within(
        &self,
        limit: Option<Picos>,
        threads: usize,
        time_limit: Option<Duration>,
    ) -> Audit {
        self.audit_for("Q26UDV", limit, threads, time_limit)
    }

    fn audit_for(
        &self,
        cpu: &str,
        limit: Option<Picos>,
        threads: usize,
        time_limit: Option<Duration>,
    ) -> Audit {
        let request = Request {
            cpu: Some(cpu),
            table: Some(&self.table),
            time_limit,
            limit,
            ..Request::new(&self.inputs, &self.facts)
        };
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        let mut audit = pool.install(|| audit(&request)).expect("an audit");
        audit.elapsed = Duration::ZERO;
        audit
    }

    /// Holds the case against limits all over the range of its bounds.
    fn check(&self) {
        let whole = self.audit(None, 2);
        assert!(whole.bound.exact() && !whole.ended_early);
        let most = whole.upper_with_all_points();
        let surely = whole.lower_without_points();
        let between = |share: u64| Picos(surely.0 + (most.0 - surely.0) / 4 * share);
        let naive = Picos(whole.bound.naive.0 + (most.0 - whole.bound.upper.0));
        let limits = [
            Picos(surely.0 / 2),
            Picos(surely.0 - 1),
            surely,
            between(2),
            Picos(most.0 - 1),
            most,
            Picos(u64::midpoint(most.0, naive.0)),
            Picos(naive.0 * 2),
        ];
        for limit in limits {
            let expected = Check::new(&whole, limit, Margin::default()).verdict;
            let ended = self.audit(Some(limit), 1);
            assert_eq!(Check::new(&ended, limit, Margin::default()).verdict, expected, "{limit}");
            assert!(ended.bound.lower <= whole.bound.lower);
            assert!(ended.bound.upper >= whole.bound.upper);
            // In between no search decides it, so none may end early.
            assert!(!ended.ended_early || limit < surely || limit >= most, "{limit}");
            assert_eq!(self.audit(Some(limit), 3), ended, "{limit}");
        }
        // The search of a group ends within, not only between groups.
        let half = self.audit(Some(Picos(u64::midpoint(most.0, naive.0))), 2);
        assert!(half.ended_early && half.groups[0].solver_calls > 0);
        let calls = |audit: &Audit| audit.groups.iter().map(|g| g.solver_calls).sum::<u64>();
        let far = self.audit(Some(Picos(naive.0 * 2)), 2);
        assert!(far.ended_early && calls(&far) == 0 && calls(&whole) > 0);
        let verdict = Check::new(&far, Picos(naive.0 * 2), Margin::default()).verdict;
        assert_eq!(verdict, Verdict::Proved);
    }
}

#[test]
fn a_plant_is_judged_as_by_the_whole_search() {
    let files = plant::plant(2, 7).into_iter().enumerate();
    let inputs = files.map(|(n, text)| Input { name: format!("{n}.il"), bytes: text.into() });
    let facts = Facts { inputs: Some(64), outputs: Some(64), ..Facts::default() };
    let table = Table::builtin("qnudv").expect("a table");
    Case { inputs: inputs.collect(), table, facts }.check();
}

#[test]
fn points_that_are_not_stated_are_judged_as_by_the_whole_search() {
    let (text, mut table) = pools::pools(150, 3);
    table.push_str("@input16,4,\n@output16,5,\n@max-inputs,1024,\n@max-outputs,512,\n");
    let inputs = vec![Input { name: "pools.il".to_owned(), bytes: text.into() }];
    let table = Table::parse("table", table.as_bytes()).expect("a table").table;
    Case { inputs, table, facts: Facts::default() }.check();
}

fn list(text: String, interrupts: u32) -> Case {
    let mut facts = Facts { inputs: Some(64), outputs: Some(64), ..Facts::default() };
    if text.contains("IRET") {
        facts.interrupts.insert("I0".to_owned(), interrupts);
    }
    let inputs = vec![Input { name: "a.il".to_owned(), bytes: text.into() }];
    Case { inputs, table: Table::builtin("qnudv").expect("a table"), facts }
}

/// Whether something was taken wider, in words that hold this.
fn wider(audit: &Audit, words: &str) -> bool {
    audit.approximations.iter().any(|one| one.what.to_string().contains(words))
}

/// So many routines, each of which calls the next one twice.
fn calling_twice(routines: usize) -> String {
    let mut calls = "LD X0\nCALL P0\nFEND\n".to_owned();
    for n in 0..routines {
        let next = format!("CALL P{}\n", n + 1).repeat(2);
        let body = if n + 1 < routines { next } else { "OUT Y0\n".to_owned() };
        calls += &format!("P{n}\nLD X0\n{body}RET\n");
    }
    calls + "END\n"
}

#[test]
fn a_scan_longer_than_times_can_tell_is_refused_by_all_that_look_at_it() {
    let case = list(calling_twice(41), 0);
    let request = Request { table: Some(&case.table), ..Request::new(&case.inputs, &case.facts) };
    let request = Request { cpu: Some("Q26UDV"), ..request };
    let Err(Failure::Input(faults)) = audit(&request) else { panic!("no scan is that long") };
    assert!(faults.iter().all(|fault| fault.code == Code::NoTime), "{faults:?}");
}

#[test]
fn what_multiplies_is_counted_before_it_is_followed() {
    let calls = list(calling_twice(20), 0).audit(None, 1);
    assert!(wider(&calls, "the routines that it calls run too often"));
    // 2^20 runs of the last routine, none of them cheaper than a nanosecond.
    assert!(calls.bound.upper > Picos(1_000 << 19));

    let routine = "LD X0\nOUT Y0\nFEND\nI0\nLD X1\nINC D0\nIRET\nEND\n";
    let once = list(routine.to_owned(), 1).audit(None, 1).bound;
    let often = list(routine.to_owned(), u32::MAX).audit(None, 1);
    assert!(wider(&often, "4294967295 times, every instruction at its larger time"));
    let each = Picos((often.bound.upper.0 - once.upper.0) / u64::from(u32::MAX - 1));
    assert!(each > Picos::ZERO && each < once.upper, "{each}");

    let iterations =
        format!("{}LD X0\nINC D0\n{}END\n", "FOR K30000\n".repeat(2), "NEXT\n".repeat(2));
    assert!(list(iterations, 0).audit(None, 1).bound.upper > Picos(900_000_000 * 1_000));
}

#[test]
fn values_that_take_too_much_are_given_up_where_they_are_read() {
    let sums: String = (0..1000).map(|n| format!("LD X{:X}\nINC D0\n", n % 64)).collect();
    let audit = list(sums + "LD= D0 K5\nOUT Y0\nEND\n", 0).audit(None, 2);
    assert!(wider(
        &audit,
        "the computation of the value that this instruction reads is too complex"
    ));
    assert!(audit.bound.upper > Picos::ZERO);
}

#[test]
fn a_limit_that_strikes_before_there_is_a_model_leaves_the_sum_of_all_that_can_run() {
    let files = plant::plant(2, 7).into_iter().enumerate();
    let inputs = files.map(|(n, text)| Input { name: format!("{n}.il"), bytes: text.into() });
    let facts = Facts { inputs: Some(64), outputs: Some(64), ..Facts::default() };
    let table = Table::builtin("qnudv").expect("a table");
    let case = Case { inputs: inputs.collect(), table, facts };
    let whole = case.audit(None, 2);
    let ended = case.audit_within(None, 2, Some(Duration::ZERO));
    assert_eq!(ended.bound.upper, whole.bound.naive);
    assert!(ended.bound.lower <= whole.bound.lower && !ended.bound.exact());
    let stages: Vec<&str> = ended.cuts.iter().map(|cut| cut.stage).collect();
    assert_eq!(stages, ["following the scan", "searching"]);
    let check = Check::new(&ended, whole.bound.upper, Margin::default());
    assert!(matches!(check.verdict, Verdict::Undecided(_)));
}

#[test]
fn the_time_that_small_groups_leave_over_goes_to_the_others() {
    // A deadline that is far away, and groups of which each gets a small share of it first.
    let files = plant::plant(3, 7).into_iter().enumerate();
    let inputs = files.map(|(n, text)| Input { name: format!("{n}.il"), bytes: text.into() });
    let facts = Facts { inputs: Some(64), outputs: Some(64), ..Facts::default() };
    let table = Table::builtin("qnudv").expect("a table");
    let case = Case { inputs: inputs.collect(), table, facts };
    let whole = case.audit(None, 2);
    let limited = case.audit_within(None, 2, Some(Duration::from_secs(600)));
    assert_eq!(limited.bound, whole.bound);
    assert!(limited.cuts.is_empty());
}

#[test]
fn thousands_of_open_interlocks_are_no_more_than_one() {
    let audit = |count: usize| {
        let text = format!(
            "{}LD 0.01\nOUT 10.00\nILC(003)\nEND(001)\n",
            "LD 0.00\nIL(002)\n".repeat(count)
        );
        let inputs = vec![Input { name: "a.mn".to_owned(), bytes: text.into() }];
        let table = Table::builtin("cj2m").expect("a table");
        let facts = Facts { inputs: Some(16), outputs: Some(16), ..Facts::default() };
        Case { inputs, table, facts }.audit_for("CJ2M", None, 1, None).bound
    };
    let (few, many) = (audit(10), audit(3000));
    let each = (many.upper.0 - few.upper.0) / 2990;
    assert_eq!(audit(11).upper.0 - few.upper.0, each);
}
