//! The watchdog and the least cycle, each in a line.

use super::words::place;
use scanbound_audit::verdict::{Check, Margin, Measure, Verdict};
use scanbound_audit::{Audit, SettingUse, Share};
use scanbound_base::time::Picos;
use scanbound_base::time_text::{at_least, at_most};

/// From so many thousandths on a share is told as so many times.
const MANY_TIMES: u64 = 10_000;
/// So many instructions are named.
const NAMED: usize = 3;

/// How long each scan lasts at least, where anything says so: the cycle is the longer of this and what a scan executes.
pub(super) fn cycle(audit: &Audit) -> Option<String> {
    let cycle = &audit.cycle;
    if cycle.is_unknown {
        return Some(format!(
            "a constant scan of unknown time may be switched on: {}",
            by(audit, &cycle.switches)
        ));
    }
    let most = cycle.upper?;
    let whole = at_most(audit.cycle_with_all_points());
    let set = match cycle.settings.is_empty() {
        true => "stated".to_owned(),
        false => {
            let [time, switch] = cycle.devices;
            let all: Vec<SettingUse> = [&*cycle.switches, &*cycle.settings].concat();
            format!("{switch}, {time}: {}", by(audit, &all))
        }
    };
    let interrupts = match cycle.interrupts {
        Picos::ZERO => String::new(),
        time => format!(", and interrupts at the end of the wait add up to {}", at_most(time)),
    };
    let waits = cycle.waits.map_or(String::new(), |scan| {
        let inputs = if scan.inputs_on { "on" } else { "off" };
        format!("; scan {} from power-up waits, with all inputs {inputs}", scan.number)
    });
    Some(format!("{whole} at most: each scan lasts {} ({set}){interrupts}{waits}", at_most(most)))
}

/// That the CPU's parameters may make each scan longer, where nobody states whether they do.
pub(super) fn unstated(audit: &Audit) -> Option<String> {
    let name = audit.cycle.unstated?;
    Some(format!(
        "a {name} that the CPU's parameters may set: state it ([scan] constant = \"20ms\", or \"none\")"
    ))
}

/// How the bound stands to the watchdog. What a check's answer says itself is not said twice.
pub(super) fn told(audit: &Audit, check: Option<&Check>) -> Option<String> {
    let own = Check::of_watchdog(audit, Margin::default())?;
    let watchdog = &audit.watchdog;
    let is_plain = watchdog.settings.is_empty() && watchdog.found.is_empty();
    let is_same = |check: &Check| check.limit == own.limit && check.measure != Measure::Stretch;
    if is_plain && check.is_some_and(is_same) {
        return None;
    }
    let time = own.limit;
    let share = Share::of(own.longest, time);
    let with = match own.measure {
        Measure::Execution if own.longest > audit.bound.upper => {
            format!(", {} with all the points that the CPU can have", at_most(own.longest))
        }
        _ => String::new(),
    };
    let told = match own.verdict {
        Verdict::Proved => format!("kept, {share} of it used{with}"),
        Verdict::Refuted if audit.is_endless() => "runs out in a loop without end".to_owned(),
        Verdict::Refuted if own.measure == Measure::Stretch => {
            format!("{} were found to pass without a restart", at_least(own.took))
        }
        Verdict::Refuted => "a scan was found that takes longer".to_owned(),
        Verdict::Undecided(_) if share <= Share(1000) => {
            format!(
                "not proved to be kept: {share} of it used{with}, what is not stated not counted"
            )
        }
        Verdict::Undecided(_) if share.0 >= MANY_TIMES => {
            format!("not proved to be kept: the bound is {} times it{with}", share.0 / 1000)
        }
        Verdict::Undecided(_) => format!("not proved to be kept: the bound is {share} of it{with}"),
    };
    let set = match watchdog.settings.is_empty() {
        true if watchdog.default.is_some_and(|default| default < time) => {
            "with what WDT adds".to_owned()
        }
        true if watchdog.is_stated => "as stated".to_owned(),
        true => "by default".to_owned(),
        false => {
            let by = by(audit, &watchdog.settings);
            let default = watchdog.default.filter(|&default| default != time);
            let default =
                default.map_or(String::new(), |time| format!("; {} before", at_most(time)));
            format!("({}: {by}{default})", watchdog.device)
        }
    };
    let restarts = match own.measure {
        Measure::Stretch => format!(
            "; {} at most between two restarts (WDT)",
            at_most(watchdog.upper.unwrap_or(Picos::ZERO))
        ),
        _ => String::new(),
    };
    Some(format!("{} {set}: {told}{restarts}", at_most(time)))
}

/// The instructions that set something.
fn by(audit: &Audit, settings: &[SettingUse]) -> String {
    let named = settings.iter().take(NAMED);
    let named = named.map(|one| format!("{} ({})", one.instruction, place(audit, one.at)));
    let mut all: Vec<String> = named.collect();
    if settings.len() > NAMED {
        all.push(format!("{} more", settings.len() - NAMED));
    }
    all.join(", ")
}
