//! The tasks of a project, each bounded separately, and their response times with interruptions by others.

use super::failure::Failure;
use super::pipeline::{Concluded, audit};
use super::request::{Progress, Request};
use super::requested::TaskUse;
use scanbound_base::time::Picos;
use scanbound_ir::Task;

/// Adds to an audit each task of the project, audited separately, if there are several. Each audit may use the whole
/// time limit. Nothing is added if only a limit is to be decided.
///
/// # Errors
/// If the analysis and the interpreter disagree in one of these audits.
pub fn tasks(concluded: &mut Concluded, request: &Request<'_>) -> Result<(), Failure> {
    let all = concluded.followed.program.tasks.clone();
    if all.len() < 2 || request.limit.is_some() {
        return Ok(());
    }
    let is_alone = concluded.followed.program.interrupts.iter().all(|one| one.times == 0);
    let mut bounds = Vec::new();
    for (number, task) in all.iter().enumerate() {
        if number == 0 && is_alone {
            bounds.push(bounds_of(&concluded.audit));
            continue;
        }
        (request.progress)(Progress::Stage("bounding the other tasks"));
        let own = Request {
            task: Some(&task.name),
            alone: true,
            confirm: false,
            trace: false,
            response: None,
            ..*request
        };
        bounds.push(bounds_of(&audit(&own)?));
    }
    // The time of a task that runs first, including the time to switch to it.
    let entry = concluded.followed.table.row("@interrupt-entry").map_or(Picos::ZERO, |row| row.on);
    let before: Vec<(Option<Picos>, Picos)> = bounds
        .iter()
        .map(|&(upper, _)| (upper, upper.map_or(entry, |upper| upper + entry)))
        .collect();
    let uses = all.iter().zip(&bounds).enumerate().map(|(at, (task, &(upper, lower)))| {
        let others = || all.iter().enumerate().filter(move |(other, _)| *other != at);
        let interrupting = others().filter(|(_, one)| one.interrupts(task));
        let waiting = others().filter(|(_, one)| one.delays(task) && !one.interrupts(task));
        TaskUse {
            name: task.name.clone(),
            interval: task.interval,
            priority: task.priority,
            programs: task.programs.clone(),
            upper,
            lower,
            interrupted_by: interrupting.map(|(_, one)| one.name.clone()).collect(),
            waits_for: waiting.map(|(_, one)| one.name.clone()).collect(),
            response: response(&all, &before, at),
        }
    });
    concluded.audit.tasks = uses.collect();
    Ok(())
}

fn bounds_of(audit: &super::Audit) -> (Option<Picos>, Picos) {
    (audit.unbounded.is_empty().then_some(audit.bound.upper), audit.possible())
}

/// The longest time from a task's due time to its end. `Err` has the reason if there is none. The time is valid only if
/// the tasks that run first are due no earlier than their intervals say, and end before they are due again. So their
/// response times are computed, too.
fn response(all: &[Task], bounds: &[(Option<Picos>, Picos)], at: usize) -> Result<Picos, String> {
    let response = by_intervals(all, bounds, at)?;
    let mut before = vec![at];
    let mut looked = 0;
    while let Some(&this) = before.get(looked) {
        looked += 1;
        for other in (0..all.len()).filter(|&other| other != this) {
            if all[other].delays(&all[this]) && !before.contains(&other) {
                by_intervals(all, bounds, other).map_err(|why| {
                    format!(
                        "the task can be delayed by the task {}, whose response time is unknown because {why}",
                        all[other].name
                    )
                })?;
                before.push(other);
            }
        }
    }
    Ok(response)
}

/// The bound of a task plus the times of all tasks that may run first, each as often as it is due in this time.
/// `bounds` holds for each task its bound, and its time when it runs first. `Err` if there is no such time up to the
/// task's interval, or up to a day.
fn by_intervals(
    all: &[Task],
    bounds: &[(Option<Picos>, Picos)],
    at: usize,
) -> Result<Picos, String> {
    let execution = bounds[at].0.ok_or("its execution time has no bound")?;
    let mut before = Vec::new();
    for (other, task) in all.iter().enumerate() {
        if other == at || !task.delays(&all[at]) {
            continue;
        }
        let interval = task
            .interval
            .ok_or_else(|| format!("it is not stated how often the task {} runs", task.name))?;
        bounds[other]
            .0
            .ok_or_else(|| format!("the time of the task {} has no bound", task.name))?;
        let takes = bounds[other].1;
        before.push((interval, takes));
    }
    let limit = all[at].interval.unwrap_or(LONGEST);
    let mut whole = execution;
    loop {
        let mut next = execution;
        for &(interval, takes) in &before {
            let times = whole.0.div_ceil(interval.0).max(1);
            let more = takes
                .0
                .checked_mul(times)
                .ok_or("the times of the tasks that delay it add up to too large a number")?;
            next = Picos(
                next.0
                    .checked_add(more)
                    .ok_or("the times of the tasks that delay it add up to too large a number")?,
            );
        }
        if next > limit {
            return Err(match all[at].interval {
                Some(interval) => {
                    format!(
                        "the task {} may still be running when its interval of {interval} has passed and it must start again",
                        all[at].name
                    )
                }
                None => format!(
                    "the tasks that delay the task {} may use all of the CPU's time",
                    all[at].name
                ),
            });
        }
        if next == whole {
            return Ok(whole);
        }
        whole = next;
    }
}

/// The longest response time that is searched for: a day.
const LONGEST: Picos = Picos(86_400_000_000_000_000);

#[cfg(test)]
mod tests {
    use super::*;

    fn task(name: &str, interval: Option<u64>, priority: Option<i64>) -> Task {
        let interval = interval.map(Picos);
        Task { name: name.to_owned(), interval, priority, programs: Vec::new() }
    }

    fn responses(tasks: &[(Option<u64>, Option<i64>, u64)]) -> Vec<Result<u64, String>> {
        let all: Vec<Task> = tasks
            .iter()
            .zip('a'..)
            .map(|(one, name)| task(&name.to_string(), one.0, one.1))
            .collect();
        let bounds: Vec<_> = tasks.iter().map(|one| (Some(Picos(one.2)), Picos(one.2))).collect();
        (0..all.len()).map(|at| response(&all, &bounds, at).map(|found| found.0)).collect()
    }

    #[test]
    fn a_task_waits_for_those_before_it_as_often_as_they_come() {
        // A textbook example: 1 of 4, 2 of 6, 3 of 13.
        let found =
            responses(&[(Some(4), Some(0), 1), (Some(6), Some(1), 2), (Some(13), Some(2), 3)]);
        assert_eq!(found, [Ok(1), Ok(3), Ok(10)]);
    }

    /// Simulates tasks tick by tick, with every combination of first due times, and compares the longest response time
    /// with the computed one.
    #[test]
    fn no_run_of_tasks_takes_longer_than_what_is_worked_out() {
        let mut worst = [0; 3];
        let tasks: [(u64, i64, u64); 3] = [(5, 0, 2), (7, 1, 2), (23, 2, 3)];
        for (second, third) in (0..7).flat_map(|one| (0..23).map(move |two| (one, two))) {
            let starts = [0, second, third];
            let (mut left, mut due) = ([0_u64; 3], [0_u64; 3]);
            for now in 0..2000_u64 {
                for at in 0..3 {
                    if now >= starts[at] && (now - starts[at]) % tasks[at].0 == 0 {
                        assert_eq!(left[at], 0, "it has ended when it is due again");
                        (left[at], due[at]) = (tasks[at].2, now);
                    }
                }
                if let Some(at) = (0..3).find(|&at| left[at] > 0) {
                    left[at] -= 1;
                    if left[at] == 0 {
                        worst[at] = worst[at].max(now + 1 - due[at]);
                    }
                }
            }
        }
        let found =
            responses(&tasks.map(|(every, level, takes)| (Some(every), Some(level), takes)));
        let found: Vec<u64> = found.into_iter().map(|one| one.expect("it ends in time")).collect();
        assert_eq!(found, worst);
    }

    #[test]
    fn what_is_not_known_gives_no_time() {
        let reason = |tasks: &[_], at: usize| responses(tasks)[at].clone().expect_err("not known");
        assert!(
            reason(&[(Some(9), Some(1), 1), (None, Some(0), 1)], 0)
                .contains("how often the task b")
        );
        assert!(
            reason(&[(Some(9), Some(1), 5), (Some(9), Some(0), 5)], 0).contains("must start again")
        );
        assert!(
            reason(&[(Some(90), Some(1), 1), (Some(3), Some(0), 4)], 0)
                .contains("must start again")
        );
        assert!(
            reason(&[(None, Some(1), 1), (Some(3), Some(0), 4)], 0)
                .contains("all of the CPU's time")
        );
        let late = [(Some(90), Some(2), 1), (Some(20), Some(1), 3), (Some(25), Some(1), 18)];
        assert!(
            reason(&late, 0).starts_with("the task can be delayed by the task b"),
            "{}",
            reason(&late, 0)
        );
        // It is unknown which of the two runs first.
        assert_eq!(responses(&[(Some(9), None, 1), (Some(9), Some(0), 2)]), [Ok(3), Ok(3)]);
    }
}
