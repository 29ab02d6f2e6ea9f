//! An audit as JSON, schema `scanbound.audit/1` (docs/json.md): keys may be added, none changes its meaning.

mod assumption;
mod check;
mod format;
mod iec;
mod inputs;
mod net;
mod parts;
mod place;
pub(super) mod projects;
mod response;
mod watchdog;

use super::text::verdict;
pub use format::FORMAT;

use check::{CheckResult, result};
use iec::{Coactivity, Exactness, Task, task};
use place::{UnknownPlace, places};
use response::{Response, response};
use scanbound_audit::verdict::Check;
use scanbound_audit::{Audit, Engine, Opinion};
use scanbound_base::budget::{EarlyStop, StopReason};
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::Serialize;
use serde::ser::SerializeMap;
use std::borrow::Cow;
use std::io;
use std::ops::Not;

/// Something that the user stated.
#[derive(Serialize, JsonSchema)]
struct Stated {
    what: String,
    status: &'static str,
}

#[derive(Serialize, JsonSchema)]
pub(super) struct Report<'a> {
    schema: &'static str,
    scanbound: &'static str,
    answer: String,
    program: inputs::Program<'a>,
    inputs: Vec<inputs::Input<'a>>,
    table: Table<'a>,
    scan: Scan<'a>,
    groups: Vec<Group<'a>>,
    witness: Values<'a>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    witness_run: Vec<RunScan<'a>>,
    deciding: Vec<&'a str>,
    conditions: Vec<Condition<'a>>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    path: Vec<PathStep<'a>>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    unbounded: Vec<Loop<'a>>,
    facts: Vec<Stated>,
    doubts: Vec<String>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    points: Vec<Points<'a>>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    bases: Vec<Base<'a>>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    networks: Vec<Network<'a>>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    assumptions: Vec<assumption::Assumption<'a>>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    unknowns: Vec<Unknown<'a>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    what_if: Option<WhatIf<'a>>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    tasks: Vec<Task<'a>>,
    approximations: Vec<Approximation<'a>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    exactness: Option<Exactness<'a>>,
    warnings: Vec<Warning<'a>>,
    overhead: Vec<Overhead<'a>>,
    breakdown: parts::Breakdown,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    ended: Vec<Ended<'a>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    check: Option<CheckResult>,
    #[serde(skip_serializing_if = "Option::is_none")]
    response: Option<Response<'a>>,
    seconds: f64,
}

/// A value that the longest scan found needs.
#[derive(Serialize, JsonSchema)]
struct Condition<'a> {
    name: &'a str,
    #[serde(skip_serializing_if = "str::is_empty")]
    comment: &'a str,
    at_start: bool,
    worth_ps: u64,
}

/// A count of which nothing is known.
#[derive(Serialize, JsonSchema)]
struct Unknown<'a> {
    name: &'a str,
    kind: &'static str,
    places: Vec<UnknownPlace<'a>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    taken: Option<[i64; 2]>,
    #[serde(skip_serializing_if = "Option::is_none")]
    per_unit_ps: Option<u64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    ps: Option<u64>,
    #[serde(skip_serializing_if = "<[String]>::is_empty")]
    from: &'a [String],
    table: &'static str,
    fact: &'a str,
}

/// Bounds with more stated, or less trusted.
#[derive(Serialize, JsonSchema)]
struct WhatIf<'a> {
    steps: Vec<WhatIfStep<'a>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    minor: Option<Minor>,
}

/// A count that is stated besides those before it.
#[derive(Serialize, JsonSchema)]
struct WhatIfStep<'a> {
    name: &'a str,
    fact: &'a str,
    places: Vec<UnknownPlace<'a>>,
    solved: Vec<Solved>,
}

#[derive(Serialize, JsonSchema)]
struct Solved {
    most: u32,
    upper_ps: Option<u64>,
    #[serde(skip_serializing_if = "Not::not")]
    cut: bool,
}

/// Assumptions that are not listed.
#[derive(Serialize, JsonSchema)]
struct Minor {
    count: usize,
    upper_without_ps: u64,
    #[serde(skip_serializing_if = "Not::not")]
    cut: bool,
}

/// A stage that was cut short.
#[derive(Serialize, JsonSchema)]
struct Ended<'a> {
    by: &'static str,
    stage: &'a str,
    open: &'a str,
}

#[derive(Serialize, JsonSchema)]
struct Table<'a> {
    name: &'a str,
    title: &'a str,
    all_assumed: bool,
    not_included: &'a [String],
    watchdog_ps: Option<u64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    factor: Option<Factor<'a>>,
    unverified: Vec<&'a str>,
    unverified_ps: u64,
    unverified_rows: Vec<Unverified<'a>>,
}

#[derive(Serialize, JsonSchema)]
struct Factor<'a> {
    factor: &'a str,
    evidence: &'static str,
    why: &'a str,
    upper_without_ps: u64,
    ps: u64,
}

#[derive(Serialize, JsonSchema)]
struct Unverified<'a> {
    name: &'a str,
    row: &'a str,
    by_class: bool,
    count: usize,
    worst_ps: u64,
    ps: u64,
}

#[derive(Serialize, JsonSchema)]
struct Scan<'a> {
    upper_ps: Option<u64>,
    lower_ps: u64,
    proved_ps: Option<u64>,
    refuted_ps: u64,
    weighed_ps: u64,
    lower_kind: &'static str,
    model_ps: u64,
    stands_between: Option<String>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    devices: Vec<NeededDevices<'a>>,
    trust: &'static str,
    exact: bool,
    naive_ps: u64,
    always_ps: u64,
    overhead_ps: u64,
    cycle_ps: Option<u64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    constant_scan: Option<watchdog::Constant<'a>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    watchdog: Option<watchdog::Watchdog<'a>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    coactivity: Option<Coactivity<'a>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    net: Option<net::Net<'a>>,
}

#[derive(Serialize, JsonSchema)]
struct NeededDevices<'a> {
    name: &'a str,
    least: u32,
}

#[derive(Serialize, JsonSchema)]
struct Group<'a> {
    id: usize,
    blocks: &'a [u32],
    devices: &'a [String],
    upper_ps: u64,
    lower_ps: u64,
    exact: bool,
    naive_ps: u64,
    solver_calls: u64,
    method: &'static str,
    #[serde(skip_serializing_if = "Option::is_none")]
    confirmed: Option<&'static str>,
    charges: Vec<Charge<'a>>,
    excluded: Vec<Excluded<'a>>,
}

#[derive(Serialize, JsonSchema)]
struct Charge<'a> {
    file: u32,
    line: u32,
    #[serde(skip_serializing_if = "Option::is_none")]
    step: Option<u32>,
    block: u32,
    instruction: &'a str,
    #[serde(skip_serializing_if = "<[String]>::is_empty")]
    via: &'a [String],
    on_ps: u64,
    off_ps: u64,
    runs: bool,
    reached: bool,
    cost_ps: u64,
    evidence: &'a str,
    row: &'a str,
}

#[derive(Serialize, JsonSchema)]
struct Excluded<'a> {
    block: u32,
    by_blocks: &'a [u32],
    through: &'a [String],
}

#[derive(Serialize, JsonSchema)]
struct Approximation<'a> {
    file: u32,
    line: u32,
    instruction: &'a str,
    what: String,
}

#[derive(Serialize, JsonSchema)]
struct Warning<'a> {
    code: &'a str,
    file: &'a str,
    line: Option<u32>,
    message: &'a str,
}

/// The last four are left out where the table does not know the most points.
#[derive(Serialize, JsonSchema)]
struct Points<'a> {
    side: &'a str,
    taken: u32,
    taken_ps: u64,
    why: &'a str,
    #[serde(skip_serializing_if = "Option::is_none")]
    most: Option<u32>,
    #[serde(skip_serializing_if = "Option::is_none")]
    more_ps: Option<u64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    most_evidence: Option<&'static str>,
    #[serde(skip_serializing_if = "Option::is_none")]
    most_why: Option<&'a str>,
}

#[derive(Serialize, JsonSchema)]
struct Base<'a> {
    side: &'a str,
    least: &'a str,
    saves_ps: u64,
}

#[derive(Serialize, JsonSchema)]
struct Network<'a> {
    what: &'a str,
    file: u32,
    line: u32,
}

#[derive(Serialize, JsonSchema)]
struct PathStep<'a> {
    file: u32,
    line: u32,
    instruction: &'a str,
    #[serde(skip_serializing_if = "<[String]>::is_empty")]
    via: &'a [String],
    held: bool,
    cost_ps: u64,
}

#[derive(Serialize, JsonSchema)]
struct Loop<'a> {
    file: u32,
    from_line: u32,
    to_line: u32,
    begins: &'a str,
    ends: &'a str,
    certain: bool,
}

#[derive(Serialize, JsonSchema)]
struct Overhead<'a> {
    name: &'a str,
    ps: u64,
    evidence: &'a str,
    why: &'a str,
}

/// One scan of the run from power-up.
#[derive(Serialize, JsonSchema)]
struct RunScan<'a> {
    /// Its number from 1 at power-up; scans that are left out are like the one before: the run waits for a timer.
    scan: u64,
    inputs: Values<'a>,
    took_ps: u64,
}

fn run_scan(scan: &scanbound_audit::RunScan) -> RunScan<'_> {
    let inputs = scan.inputs.iter().map(|(name, value)| (name.as_str(), *value));
    RunScan { scan: scan.number, inputs: Values(inputs.collect()), took_ps: scan.took.0 }
}

/// Values by their names as one object, in this order.
struct Values<'a>(Vec<(&'a str, scanbound_audit::Value)>);

impl JsonSchema for Values<'_> {
    fn schema_name() -> Cow<'static, str> {
        "Values".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({ "type": "object", "additionalProperties": { "type": ["boolean", "integer"] } })
    }
}

impl Serialize for Values<'_> {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(Some(self.0.len()))?;
        for (name, value) in &self.0 {
            match value {
                scanbound_audit::Value::Bit(bit) => map.serialize_entry(name, bit)?,
                scanbound_audit::Value::Word(word) => map.serialize_entry(name, word)?,
            }
        }
        map.end()
    }
}

/// The audit, and the check's result if there is one, on indented lines.
#[must_use]
pub fn render(audit: &Audit, check: Option<&Check>) -> String {
    let mut bytes = Vec::new();
    write(audit, check, &mut bytes).expect("memory takes all");
    String::from_utf8(bytes).expect("JSON is text")
}

fn write(audit: &Audit, check: Option<&Check>, out: &mut dyn io::Write) -> io::Result<()> {
    let report = report(audit, check);
    serde_json::to_writer_pretty(&mut *out, &report)?;
    out.write_all(b"\n")
}

/// The same on one line, but for what it says of each execution of each instruction and of each device.
pub(super) fn without_charges(audit: &Audit, check: Option<&Check>) -> serde_json::Result<String> {
    let mut report = report(audit, check);
    report.groups.iter_mut().for_each(|group| group.charges.clear());
    report.witness.0.clear();
    report.path.clear();
    serde_json::to_string(&report)
}

/// The report as it is written.
pub(super) fn report<'a>(audit: &'a Audit, check: Option<&Check>) -> Report<'a> {
    Report {
        schema: "scanbound.audit/1",
        scanbound: env!("CARGO_PKG_VERSION"),
        answer: verdict::answer(audit, check).plain(),
        program: inputs::program(audit),
        inputs: inputs::inputs(audit),
        table: table(&audit.table),
        scan: Scan {
            upper_ps: audit.unbounded.is_empty().then_some(audit.bound.upper.0),
            lower_ps: audit.possible().0,
            proved_ps: audit.proved().map(|limit| limit.max(audit.cycle_upper()).0),
            refuted_ps: audit.cycle_without_points().0,
            weighed_ps: audit.weighed.0,
            lower_kind: if audit.is_reached() { "reached" } else { "admissible" },
            model_ps: audit.bound.model.0,
            stands_between: audit.stands_between.clone().or_else(|| tolerance(audit)),
            devices: audit
                .needed_devices
                .iter()
                .map(|(name, least)| NeededDevices { name, least: *least })
                .collect(),
            trust: audit.trust.name(),
            exact: audit.possible() == audit.bound.upper && audit.proved().is_some(),
            naive_ps: audit.bound.naive.0,
            always_ps: audit.bound.always.0,
            overhead_ps: audit.bound.overhead.0,
            cycle_ps: audit.unbounded.is_empty().then_some(audit.cycle_upper().0),
            constant_scan: watchdog::constant(audit),
            watchdog: watchdog::watchdog(audit),
            coactivity: audit.coactivity.as_ref().map(Coactivity::of),
            net: audit.net.as_ref().map(net::Net::of),
        },
        groups: audit.groups.iter().map(group).collect(),
        witness: Values(
            audit.witness.iter().map(|free| (free.name.as_str(), free.value)).collect(),
        ),
        witness_run: audit.witness_run.iter().map(run_scan).collect(),
        deciding: audit.witness.iter().filter(|v| v.matters).map(|v| v.name.as_str()).collect(),
        conditions: conditions(audit),
        path: audit.path.iter().map(step).collect(),
        unbounded: audit.unbounded.iter().map(endless).collect(),
        facts: audit
            .facts
            .iter()
            .map(|fact| Stated { what: fact.to_string(), status: fact.status().word() })
            .collect(),
        doubts: audit.all_doubts().iter().map(ToString::to_string).collect(),
        points: audit.points.iter().map(points).collect(),
        bases: audit
            .bases
            .iter()
            .map(|base| Base { side: base.side, least: &base.least, saves_ps: base.saves.0 })
            .collect(),
        networks: audit
            .networks
            .iter()
            .map(|one| Network { what: &one.what, file: one.first.file, line: one.first.line })
            .collect(),
        assumptions: audit.assumptions.iter().map(assumption::assumption).collect(),
        unknowns: audit.unknowns.iter().map(unknown).collect(),
        what_if: audit.what_if.as_ref().map(what_if),
        tasks: audit.tasks.iter().map(task).collect(),
        approximations: audit
            .approximations
            .iter()
            .map(|one| Approximation {
                file: one.at.file,
                line: one.at.line,
                instruction: &one.instruction,
                what: one.what.to_string(),
            })
            .collect(),
        exactness: audit.exactness.as_ref().map(Exactness::of),
        warnings: audit
            .warnings
            .iter()
            .map(|one| Warning {
                code: one.code.name(),
                file: &one.file,
                line: one.line,
                message: &one.message,
            })
            .collect(),
        overhead: audit
            .overhead
            .iter()
            .map(|term| Overhead {
                name: &term.name,
                ps: term.time.0,
                evidence: term.evidence.word(),
                why: &term.why,
            })
            .collect(),
        breakdown: parts::Breakdown::of(audit),
        ended: audit.cuts.iter().map(ended).collect(),
        check: check.map(|check| result(audit, check)),
        response: audit.response.as_ref().map(response),
        seconds: audit.elapsed.as_secs_f64(),
    }
}

/// What matters, the worthiest first.
fn conditions(audit: &Audit) -> Vec<Condition<'_>> {
    let mut found: Vec<&scanbound_audit::FreeValue> =
        audit.witness.iter().filter(|v| v.matters).collect();
    found.sort_by_key(|value| std::cmp::Reverse(value.worth));
    found.into_iter().map(condition).collect()
}

fn condition(value: &scanbound_audit::FreeValue) -> Condition<'_> {
    Condition {
        name: &value.name,
        comment: &value.comment,
        at_start: value.at_start,
        worth_ps: value.worth.0,
    }
}

fn what_if(found: &scanbound_audit::WhatIf) -> WhatIf<'_> {
    let step = |step| what_if_step(step, &found.most);
    let minor = found.minor.map(|scanbound_audit::Minor { count, without }| Minor {
        count,
        upper_without_ps: without.upper.0,
        cut: without.cut,
    });
    WhatIf { steps: found.steps.iter().map(step).collect(), minor }
}

fn what_if_step<'a>(step: &'a scanbound_audit::LimitedCount, most: &[u32]) -> WhatIfStep<'a> {
    let solved = most.iter().zip(&step.solved);
    WhatIfStep {
        name: &step.unknown.word,
        fact: &step.unknown.fact,
        places: places(&step.unknown.places),
        solved: solved
            .map(|(&most, bound)| Solved {
                most,
                upper_ps: bound.map(|bound| bound.upper.0),
                cut: bound.is_some_and(|bound| bound.cut),
            })
            .collect(),
    }
}

fn unknown(one: &scanbound_audit::Unknown) -> Unknown<'_> {
    let counts = one.counts();
    Unknown {
        name: &one.word,
        kind: match one.kind {
            scanbound_audit::UnknownKind::Count(_) => "count",
            scanbound_audit::UnknownKind::Index(_) => "index",
            scanbound_audit::UnknownKind::IndexBits => "index-bits",
            scanbound_audit::UnknownKind::Indirect => "indirect",
        },
        places: places(&one.places),
        taken: counts.map(|counts| [0, counts.most]),
        per_unit_ps: counts.map(|counts| counts.each.0),
        ps: counts.map(|counts| counts.cost.0),
        from: match &one.kind {
            scanbound_audit::UnknownKind::Index(from) => from,
            _ => &[],
        },
        table: one.table(),
        fact: &one.fact,
    }
}

fn points(points: &scanbound_audit::UnstatedPoints) -> Points<'_> {
    let most = points.most.as_ref();
    Points {
        side: points.side,
        taken: points.taken,
        taken_ps: points.time.0,
        why: &points.why,
        most: most.map(|most| most.points),
        more_ps: most.map(|most| most.more.0),
        most_evidence: most.map(|most| most.evidence.word()),
        most_why: most.map(|most| most.source.as_str()),
    }
}

fn table(table: &scanbound_audit::TableUse) -> Table<'_> {
    Table {
        name: &table.name,
        title: &table.title,
        all_assumed: table.is_all_assumed,
        not_included: &table.notes,
        watchdog_ps: table.watchdog.map(|time| time.0),
        factor: table.factor.as_ref().map(|factor| Factor {
            factor: &factor.text,
            evidence: factor.evidence.word(),
            why: &factor.source,
            upper_without_ps: factor.without.0,
            ps: factor.part.0,
        }),
        unverified: table.assumed.iter().map(|one| one.name.as_str()).collect(),
        unverified_ps: table.assumed_time.0,
        unverified_rows: table
            .assumed
            .iter()
            .map(|one| Unverified {
                name: &one.name,
                row: &one.row,
                by_class: one.by_class,
                count: one.count,
                worst_ps: one.time.0,
                ps: one.part.0,
            })
            .collect(),
    }
}

fn group(group: &scanbound_audit::GroupUse) -> Group<'_> {
    Group {
        id: group.id,
        blocks: &group.blocks,
        devices: &group.devices,
        upper_ps: group.upper.0,
        lower_ps: group.lower.0,
        exact: group.exact(),
        naive_ps: group.naive.0,
        solver_calls: group.solver_calls,
        method: match group.search.engine {
            Engine::Subsets => "subsets",
            Engine::Cores => "cores",
        },
        confirmed: group.search.opinion.map(|opinion| match opinion {
            Opinion::Confirmed => "yes",
            Opinion::TooLarge => "too_large",
            Opinion::RanOut => "ran_out",
            Opinion::NoSolver => "no_solver",
        }),
        charges: group.charges.iter().map(charge).collect(),
        excluded: group
            .rungs
            .iter()
            .filter_map(|rung| {
                let reason = rung.exclusion.as_ref()?;
                Some(Excluded {
                    block: rung.block,
                    by_blocks: &reason.blocks,
                    through: &reason.devices,
                })
            })
            .collect(),
    }
}

fn charge(charge: &scanbound_audit::ChargeUse) -> Charge<'_> {
    Charge {
        file: charge.at.file,
        line: charge.at.line,
        step: charge.at.step,
        block: charge.block,
        instruction: &charge.instruction,
        via: &charge.via,
        on_ps: charge.on.0,
        off_ps: charge.off.0,
        runs: charge.runs,
        reached: charge.reached,
        cost_ps: charge.cost.0,
        evidence: charge.evidence.word(),
        row: &charge.row,
    }
}

fn step(step: &scanbound_audit::PathStep) -> PathStep<'_> {
    PathStep {
        file: step.at.file,
        line: step.at.line,
        instruction: &step.instruction,
        via: &step.via,
        held: step.held,
        cost_ps: step.cost.0,
    }
}

fn ended(cut: &EarlyStop) -> Ended<'_> {
    let by = match cut.reason {
        StopReason::TimeLimit(_) => "time-limit",
        StopReason::Cancelled => "ctrl-c",
    };
    Ended { by, stage: cut.stage, open: &cut.unfinished }
}

/// Why no scan is known to take as long as the model's longest: the clock's tolerance is in no scan that was found.
fn tolerance(audit: &Audit) -> Option<String> {
    let factor = audit.table.factor.as_ref()?;
    let is_less = audit.clocked.is_some() && audit.possible() < audit.bound.model;
    is_less.then(|| format!("no clock is known to be as slow as the factor {} has it", factor.text))
}

fn endless(one: &scanbound_audit::LoopUse) -> Loop<'_> {
    Loop {
        file: one.from.file,
        from_line: one.from.line,
        to_line: one.to.line,
        begins: &one.begins,
        ends: &one.ends,
        certain: one.certain,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use scanbound_audit::fixture::fixture;
    use scanbound_audit::verdict::Margin;
    use scanbound_base::time::Picos;

    #[test]
    fn the_fixture_as_json() {
        insta::assert_snapshot!(render(&fixture(), None));
    }

    #[test]
    fn a_check_is_added_to_the_audit() {
        let audit = fixture();
        let check = Check::new(&audit, Picos::ZERO, Margin::default());
        let json: serde_json::Value =
            serde_json::from_str(&render(&audit, Some(&check))).expect("JSON");
        assert_eq!(json["check"]["verdict"], "refuted");
        assert_eq!(json["schema"], "scanbound.audit/1");
    }

    #[test]
    fn the_parts_add_up_to_the_bound() {
        let json: serde_json::Value =
            serde_json::from_str(&render(&fixture(), None)).expect("JSON");
        let ps = |value: &serde_json::Value| value.as_u64().expect("a time");
        let scan = &json["scan"];
        let groups: u64 = json["groups"]
            .as_array()
            .expect("groups")
            .iter()
            .map(|group| ps(&group["upper_ps"]))
            .sum();
        assert_eq!(
            ps(&scan["upper_ps"]),
            ps(&scan["always_ps"]) + ps(&scan["overhead_ps"]) + groups
        );
    }
}
