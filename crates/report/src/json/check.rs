//! The answer to a check as JSON.

use scanbound_audit::Audit;
use scanbound_audit::verdict::{Check, Verdict};
use schemars::JsonSchema;
use serde::Serialize;

#[derive(Serialize, JsonSchema)]
pub(crate) struct CheckResult {
    #[schemars(extend("enum" = ["proved", "refuted", "undecided"]))]
    verdict: &'static str,
    limit_ps: u64,
    #[schemars(extend("enum" = ["cycle", "execution", "stretch"]))]
    measure: &'static str,
    margin: String,
    upper_with_margin_ps: u64,
    lower_with_margin_ps: u64,
    assumed_ps: u64,
    assumed_of_ps: u64,
    #[serde(skip_serializing_if = "Option::is_none")]
    max_assumed: Option<String>,
    reasons: Vec<String>,
    ended_early: bool,
}

pub(super) fn result(audit: &Audit, check: &Check) -> CheckResult {
    let reasons = match &check.verdict {
        Verdict::Proved | Verdict::Refuted => Vec::new(),
        Verdict::Undecided(reasons) => reasons.iter().map(ToString::to_string).collect(),
    };
    CheckResult {
        verdict: check.verdict.name(),
        limit_ps: check.limit.0,
        measure: check.measure.name(),
        margin: check.margin.to_string(),
        upper_with_margin_ps: check.upper.0,
        lower_with_margin_ps: check.lower.0,
        assumed_ps: check.assumed.time.0,
        assumed_of_ps: check.assumed.of.0,
        max_assumed: check.most_assumed.map(|most| most.to_string()),
        reasons,
        ended_early: audit.ended_early,
    }
}
