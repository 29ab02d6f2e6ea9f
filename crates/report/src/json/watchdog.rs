//! The watchdog, and the least time of each scan.

use scanbound_audit::Audit;
use schemars::JsonSchema;
use serde::Serialize;

/// An instruction that sets a time of the CPU.
#[derive(Serialize, JsonSchema)]
struct Setting<'a> {
    file: u32,
    line: u32,
    instruction: &'a str,
    least_ps: Option<u64>,
    most_ps: Option<u64>,
}

/// An instruction that switches a constant scan on or off.
#[derive(Serialize, JsonSchema)]
struct Switching<'a> {
    file: u32,
    line: u32,
    instruction: &'a str,
}

fn switching(one: &scanbound_audit::SettingUse) -> Switching<'_> {
    Switching { file: one.at.file, line: one.at.line, instruction: &one.instruction }
}

fn setting(one: &scanbound_audit::SettingUse) -> Setting<'_> {
    Setting {
        file: one.at.file,
        line: one.at.line,
        instruction: &one.instruction,
        least_ps: one.times.map(|times| times.0.0),
        most_ps: one.times.map(|times| times.1.0),
    }
}

/// What a constant scan makes of scans.
#[derive(Serialize, JsonSchema)]
pub(super) struct Constant<'a> {
    most_ps: Option<u64>,
    interrupts_ps: u64,
    found_ps: Option<u64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    found_in: Option<Waiting>,
    stated: bool,
    #[serde(skip_serializing_if = "Option::is_none")]
    by_parameters: Option<&'a str>,
    set_by: Vec<Setting<'a>>,
    switched_by: Vec<Switching<'a>>,
}

/// A scan from power-up that waits, with inputs that do not change.
#[derive(Serialize, JsonSchema)]
pub(super) struct Waiting {
    scan: usize,
    inputs_on: bool,
}

/// The least time of each scan, where anything may set one.
pub(super) fn constant(audit: &Audit) -> Option<Constant<'_>> {
    let cycle = &audit.cycle;
    let is_any = cycle.is_unknown || cycle.upper.is_some() || cycle.unstated.is_some();
    is_any.then(|| Constant {
        most_ps: cycle.upper.map(|time| time.0).filter(|_| !cycle.is_unknown),
        interrupts_ps: cycle.interrupts.0,
        found_ps: cycle.lower.map(|time| time.0),
        found_in: cycle.waits.map(|one| Waiting { scan: one.number, inputs_on: one.inputs_on }),
        stated: cycle.is_stated,
        by_parameters: cycle.unstated,
        set_by: cycle.settings.iter().map(setting).collect(),
        switched_by: cycle.switches.iter().map(switching).collect(),
    })
}

/// The watchdog.
#[derive(Serialize, JsonSchema)]
pub(super) struct Watchdog<'a> {
    default_ps: Option<u64>,
    stated: bool,
    least_ps: Option<u64>,
    stretch_ps: u64,
    found_ps: u64,
    restarts: usize,
    set_by: Vec<Setting<'a>>,
}

/// The watchdog, where anything says what it is.
pub(super) fn watchdog(audit: &Audit) -> Option<Watchdog<'_>> {
    let watchdog = &audit.watchdog;
    let is_any = watchdog.default.is_some() || !watchdog.settings.is_empty();
    let found = watchdog.found.iter().map(|one| one.took).max();
    is_any.then(|| Watchdog {
        default_ps: watchdog.default.map(|time| time.0),
        stated: watchdog.is_stated,
        least_ps: watchdog.least.map(|time| time.0),
        stretch_ps: watchdog.upper.unwrap_or(audit.upper_with_all_points()).0,
        found_ps: found.unwrap_or(audit.lower_without_points()).0,
        restarts: watchdog.restarts,
        set_by: watchdog.settings.iter().map(setting).collect(),
    })
}
