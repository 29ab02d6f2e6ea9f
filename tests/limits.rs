//! Searches that end when a limit is decided: the verdict is that of the whole search, and every run ends alike.

#[path = "../benches/common/plant.rs"]
mod plant;
#[path = "../benches/common/pools.rs"]
mod pools;

use scanbound::audit::{Audit, Request, audit};
use scanbound::dialect::Input;
use scanbound::facts::Facts;
use scanbound::solve::Method;
use scanbound::table::Table;
use scanbound::time::Picos;
use scanbound::verdict::{Check, Margin, Verdict};
use std::time::Duration;

struct Case {
    inputs: Vec<Input>,
    table: Table,
    facts: Facts,
}

impl Case {
    fn audit(&self, limit: Option<Picos>, threads: usize) -> Audit {
        let request = Request {
            inputs: &self.inputs,
            dialect: None,
            cpu: Some("Q26UDV"),
            table: Some(&self.table),
            times: &[],
            clock: None,
            warnings: &[],
            facts: &self.facts,
            strict_times: false,
            method: Method::Auto,
            trace: false,
            confirm: false,
            time_limit: None,
            limit,
            cancelled: &|| false,
            progress: &|_| {},
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
