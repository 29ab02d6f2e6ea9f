//! Rewrites a chart so that actions stored by S, SD, SL or DS become explicit parallel branches.
//!
//! A stored action gets a branch of its own: a step that is active while the action is stored. Transitions into the
//! steps that store it also activate this step, and transitions into the steps that reset it also clear it. The
//! branch's step has the action with N (for S), D (for SD) or L (for SL). Its timer starts in the same scan as that of
//! the stored qualifier did, so no time changes and no scan is added.
//!
//! DS stores the action only if its step is still active when the time ends. Its branch begins with a waiting step.
//! This is cleared if the storing step ends first; it is followed by the step with the action (N) if the time ends and
//! nothing ends the storing step in the same scan.
//!
//! A transition that can fire both with and without the branch is split into two, which the branch's step flag makes
//! mutually exclusive. An action that cannot be rewritten without changing a scan is left as it is, with the reason.

use super::coactive::{Analysis, Basis, steps_together};
use super::expansion::named;
use super::names::Taken;
use super::{Block, COMPUTED, Chart, Qualifier, Step, Target, Transition};
use crate::ast::{Expr, Literal, Operator};
use crate::show;
use rustc_hash::FxHashSet;
use scanbound_nets::Bits;
use std::collections::BTreeSet;

/// The result of rewriting one stored action.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Rewriting {
    /// The name of the stored action.
    pub action: String,
    /// The qualifier that stores it.
    pub qualifier: Qualifier,
    /// The name of the first step that stores it.
    pub step: String,
    /// The line of the action block there, from 1.
    pub line: u32,
    /// The names of its branch's steps, or the reason why it was not rewritten.
    pub branch: Result<Vec<String>, String>,
}

/// The state of an action's branch: absent, waiting (DS), or active.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
enum Branch {
    None,
    Wait,
    On,
}

/// Rewrites all stored actions that can be rewritten. `budget` limits the number of markings that are searched.
#[must_use]
pub fn explicit(chart: &Chart, budget: usize) -> (Chart, Vec<Rewriting>) {
    explicit_beside(chart, &mut Taken::default(), budget)
}

/// Like [`explicit`], but new steps avoid the names in `taken`, to which they are added.
#[must_use]
pub fn explicit_beside(chart: &Chart, taken: &mut Taken, budget: usize) -> (Chart, Vec<Rewriting>) {
    for step in &chart.steps {
        taken.add(&step.name);
        step.blocks.iter().for_each(|block| taken.add(&block.target.name()));
    }
    chart.macros.iter().for_each(|one| taken.add(&one.name));
    let mut told = Vec::new();
    let mut now = chart.clone();
    // Rewriting does not change which steps are active together, so this is computed once.
    let mut together = None;
    for action in chart.actions().into_iter().filter(|action| action != COMPUTED) {
        let stored = chart.blocks_of(&action).find(|(_, block)| block.qualifier.is_stored());
        let Some((step, block)) = stored else { continue };
        let (qualifier, line) = (block.qualifier, block.line);
        let step = chart.steps[step].name.clone();
        let branch = Stores::of(chart, &action).and_then(|stores| {
            let together = together.get_or_insert_with(|| steps_together(chart, budget));
            let plan = stores.plan(chart, together)?;
            let mut names = taken.clone();
            let (next, steps) = rewrite(&now, &action, &plan, &mut names, budget)?;
            (now, *taken) = (next, names);
            Ok(steps)
        });
        told.push(Rewriting { action, qualifier, step, line, branch });
    }
    (now, told)
}

/// How an action is stored, once it is known that it can be rewritten.
struct Plan {
    set: Vec<usize>,
    reset: Vec<usize>,
    qualifier: Qualifier,
    time: Option<Expr>,
    target: Target,
    line: u32,
}

impl Plan {
    /// The state of the branch after the transition fires.
    fn next(&self, one: &Transition, branch: Branch) -> Branch {
        let enters = |steps: &[usize]| one.to.iter().any(|step| steps.contains(step));
        let leaves = one.from.iter().any(|step| self.set.contains(step));
        if enters(&self.reset) {
            return Branch::None;
        }
        match branch {
            Branch::On => Branch::On,
            Branch::None if !enters(&self.set) => Branch::None,
            Branch::None if self.qualifier == Qualifier::Ds => Branch::Wait,
            Branch::None => Branch::On,
            Branch::Wait if leaves && !enters(&self.set) => Branch::None,
            Branch::Wait => Branch::Wait,
        }
    }
}

/// The action blocks of a stored action, if their own properties allow it to be rewritten.
struct Stores<'c> {
    blocks: Vec<(usize, &'c Block)>,
    set: Vec<usize>,
    reset: Vec<usize>,
    qualifier: Qualifier,
    /// The first action block that stores it.
    first: &'c Block,
}

impl<'c> Stores<'c> {
    fn of(chart: &'c Chart, action: &'c str) -> Result<Stores<'c>, String> {
        let blocks: Vec<(usize, &Block)> = chart.blocks_of(action).collect();
        let that = |is: fn(Qualifier) -> bool| {
            let own = blocks.iter().filter(move |(_, block)| is(block.qualifier));
            own.map(|(step, _)| *step).collect::<Vec<_>>()
        };
        let (set, reset) = (that(Qualifier::is_stored), that(|kind| kind == Qualifier::R));
        if reset.is_empty() {
            // The branch would never end, and would keep the action on after code outside the chart resets it.
            return Err("no step of this chart resets it".to_owned());
        }
        let stored = || blocks.iter().map(|(_, block)| *block);
        let mut stored = stored().filter(|block| block.qualifier.is_stored());
        let first = stored.next().ok_or("nothing stores it")?;
        if stored.any(|block| block.qualifier != first.qualifier || block.time != first.time) {
            return Err("it is stored by different qualifiers or times".to_owned());
        }
        let mut qualifier = first.qualifier;
        if qualifier.is_timed() && first.constant_time().is_none() {
            return Err("its time is no constant".to_owned());
        }
        if qualifier == Qualifier::Ds && first.constant_time().is_some_and(|time| time <= 0) {
            // Without a delay, DS stores at once.
            qualifier = Qualifier::S;
        }
        if let Some(step) = set.iter().map(|&step| &chart.steps[step]).find(|step| step.initial) {
            return Err(format!("it is stored by the initial step {}", step.name));
        }
        let made = made(qualifier);
        let alike = |(_, block): &&(usize, &Block)| made == Some(block.qualifier);
        if let Some((step, block)) = blocks.iter().find(alike) {
            let (name, with) = (&chart.steps[*step].name, block.qualifier.name());
            return Err(format!("the step {name} has it with {with} already"));
        }
        Ok(Stores { blocks, set, reset, qualifier, first })
    }

    /// The plan, unless steps that store or reset it conflict because they can be active together.
    fn plan(self, chart: &Chart, analysis: &Analysis) -> Result<Plan, String> {
        match analysis.basis {
            Basis::Markings(_) => {}
            Basis::Invariants(_) | Basis::Open(_) => {
                return Err("the chart has too many markings to look at all of them".to_owned());
            }
            Basis::Unsafe(_) => {
                return Err("a step of the chart can be entered while it is active".to_owned());
            }
        }
        let Stores { blocks, set, reset, qualifier, first } = self;
        let name = |step: usize| chart.steps[step].name.as_str();
        let meet = |one: &[usize], other: &[usize], what: &str| {
            let pairs = one.iter().flat_map(|&a| other.iter().map(move |&b| (a, b)));
            let mut met = pairs.filter(|&(a, b)| a == b || !analysis.are_apart(a, b));
            met.next().map_or(Ok(()), |(a, b)| {
                Err(format!("the steps {} and {} can be active together: {what}", name(a), name(b)))
            })
        };
        meet(&set, &reset, "one stores the action and the other resets it")?;
        for (at, &step) in set.iter().enumerate() {
            meet(&[step], &set[at + 1..], "both store the action")?;
        }
        for (at, &step) in reset.iter().enumerate() {
            meet(&[step], &reset[at + 1..], "both reset the action")?;
        }
        for (step, block) in blocks {
            if !block.qualifier.is_stored()
                && !matches!(block.qualifier, Qualifier::R | Qualifier::P0 | Qualifier::P1)
            {
                meet(&[step], &reset, "one runs the action, and the other resets it")?;
            }
        }
        Ok(Plan {
            set,
            reset,
            qualifier,
            time: first.time.clone(),
            target: first.target.clone(),
            line: first.line,
        })
    }
}

/// The timed qualifier of the branch's step; `None` if it has no time.
fn made(qualifier: Qualifier) -> Option<Qualifier> {
    match qualifier {
        Qualifier::Sd => Some(Qualifier::D),
        Qualifier::Sl => Some(Qualifier::L),
        _ => None,
    }
}

/// For each transition, the states of the branch in which it can fire, under any firing order.
fn occurring(chart: &Chart, plan: &Plan, budget: usize) -> Result<Vec<BTreeSet<Branch>>, String> {
    let net = chart.net();
    let firing = net.enabled_index();
    let mut found = vec![BTreeSet::new(); chart.transitions.len()];
    let start = (net.start(), Branch::None);
    let mut known: FxHashSet<(Bits, Branch)> = FxHashSet::from_iter([start.clone()]);
    let mut open = vec![start];
    while let Some((marking, branch)) = open.pop() {
        if known.len() > budget {
            return Err("the chart has too many markings to look at all of them".to_owned());
        }
        let mut add = |state: (Bits, Branch)| {
            if known.insert(state.clone()) {
                open.push(state);
            }
        };
        if branch == Branch::Wait {
            add((marking.clone(), Branch::On));
        }
        let too_many = || "too many transitions can clear at once".to_owned();
        for set in firing.next_steps(&marking).ok_or_else(too_many)? {
            let mut next = branch;
            for &at in &set {
                found[at].insert(branch);
                next = plan.next(&chart.transitions[at], next);
            }
            add((net.fire(&set, &marking).0, next));
        }
    }
    Ok(found)
}

fn flag(step: &str) -> Expr {
    Expr::Variable(named(step).with("X"))
}

fn rewrite(
    chart: &Chart,
    action: &str,
    plan: &Plan,
    taken: &mut Taken,
    budget: usize,
) -> Result<(Chart, Vec<String>), String> {
    let occurring = occurring(chart, plan, budget)?;
    let mut next = chart.clone();
    for step in &mut next.steps {
        step.blocks.retain(|block| {
            let is_own = crate::same(&block.target.name(), action);
            !is_own || !(block.qualifier.is_stored() || block.qualifier == Qualifier::R)
        });
    }
    let is_delayed = plan.qualifier == Qualifier::Ds;
    let mut branch = Vec::new();
    let mut add = |next: &mut Chart, suffix: &str, qualifier: Option<Qualifier>| {
        let name = taken.free(&format!("{}_{suffix}", plain(action)));
        let mut step = Step::new(name.clone(), false, plan.line);
        let time = plan.time.clone().filter(|_| qualifier.is_some_and(Qualifier::is_timed));
        let block = qualifier.map(|qualifier| Block {
            qualifier,
            is_qualified: true,
            time,
            target: plan.target.clone(),
            line: plan.line,
        });
        step.blocks.extend(block);
        next.steps.push(step);
        branch.push(name.clone());
        (next.steps.len() - 1, name)
    };
    let wait = is_delayed.then(|| add(&mut next, "wait", None));
    let on = add(&mut next, "on", Some(made(plan.qualifier).unwrap_or(Qualifier::N)));
    let place = |branch: Branch| match branch {
        Branch::None => None,
        Branch::Wait => wait.as_ref(),
        Branch::On => Some(&on),
    };
    next.transitions.clear();
    for (at, (one, states)) in chart.transitions.iter().zip(&occurring).enumerate() {
        let first = next.transitions.len();
        let (changing, staying): (Vec<Branch>, Vec<Branch>) =
            states.iter().partition(|&&state| plan.next(one, state) != state);
        for &state in &changing {
            let mut variant = one.clone();
            match place(state) {
                Some((step, _)) => variant.from.push(*step),
                None if states.len() > 1 => {
                    // No branch: none of its steps is active.
                    let others = states.iter().filter_map(|&other| place(other));
                    for (_, name) in others {
                        variant.condition = variant.condition.and(flag(name).not());
                    }
                }
                None => {}
            }
            variant.to.extend(place(plan.next(one, state)).map(|(step, _)| *step));
            rename(&mut variant, &changing, &staying, state);
            next.transitions.push(variant);
        }
        if !staying.is_empty() || changing.is_empty() {
            let mut variant = one.clone();
            if changing.contains(&Branch::None) {
                let present =
                    staying.iter().filter_map(|&state| place(state)).map(|(_, name)| flag(name));
                if let Some(present) = present.reduce(Expr::or) {
                    variant.condition = variant.condition.and(present);
                }
            }
            for (_, name) in changing.iter().filter_map(|&state| place(state)) {
                variant.condition = variant.condition.and(flag(name).not());
            }
            next.transitions.push(variant);
        }
        if next.transitions[first..].iter().any(|variant| variant.condition != one.condition) {
            in_text(chart, at)?;
        }
    }
    let (first, _) = wait.as_ref().unwrap_or(&on);
    if !next.transitions.iter().any(|one| one.to.contains(first)) {
        return Err("no step that stores it is ever active".to_owned());
    }
    if let Some(wait) = &wait {
        let over = over(chart, plan, &occurring, wait, &on)?;
        next.transitions.push(over);
    }
    Ok((next, branch))
}

/// Keeps names unique: the variants of a named transition get suffixes, except one.
fn rename(variant: &mut Transition, changing: &[Branch], staying: &[Branch], state: Branch) {
    if let Some(name) = &mut variant.name
        && (changing.len() > 1 || !staying.is_empty())
    {
        *name = format!("{name}_{}", ["without", "waiting", "with"][state as usize]);
    }
}

/// The transition from the waiting step to the step with the action. It fires if the time has ended and nothing ends
/// the storing step in the same scan.
fn over(
    chart: &Chart,
    plan: &Plan,
    occurring: &[BTreeSet<Branch>],
    (wait, name): &(usize, String),
    (on, _): &(usize, String),
) -> Result<Transition, String> {
    let time = plan.time.clone().unwrap_or(Expr::Literal(Literal::Time(0)));
    let elapsed = Expr::Variable(named(name).with("T"));
    let mut condition = Expr::Binary(Operator::GreaterOrEqual, Box::new(elapsed), Box::new(time));
    let ends = |at: usize| {
        occurring[at].contains(&Branch::Wait)
            && plan.next(&chart.transitions[at], Branch::Wait) != Branch::Wait
    };
    for (at, one) in chart.transitions.iter().enumerate().filter(|&(at, _)| ends(at)) {
        for (rival, other) in chart.transitions.iter().enumerate() {
            if !ends(rival)
                && other.from.iter().any(|step| one.from.contains(step))
                && plan.next(other, Branch::Wait) == Branch::Wait
            {
                return Err(format!(
                    "{} may keep {} from ending the storing step",
                    chart.transition_name(rival),
                    chart.transition_name(at)
                ));
            }
        }
        in_text(chart, at)?;
        let mut clears = one.condition.clone();
        for &step in one.from.iter().filter(|step| !plan.set.contains(step)) {
            clears = flag(&chart.steps[step].name).and(clears);
        }
        if plan.set.len() > 1 {
            // The branch does not show which of the storing steps is active.
            for &step in one.from.iter().filter(|step| plan.set.contains(step)) {
                clears = flag(&chart.steps[step].name).and(clears);
            }
        }
        condition = condition.and(clears.not());
    }
    Ok(Transition {
        name: None,
        from: vec![*wait],
        to: vec![*on],
        condition,
        priority: None,
        line: plan.line,
        id: None,
    })
}

/// An action's name as a valid name of a step.
fn plain(action: &str) -> String {
    action.chars().map(|c| if c.is_alphanumeric() { c } else { '_' }).collect()
}

/// Rejects a transition whose condition would be extended or repeated elsewhere but cannot be written as text.
fn in_text(chart: &Chart, at: usize) -> Result<(), String> {
    let one = &chart.transitions[at];
    match show::formless(&one.condition) {
        None => Ok(()),
        Some(why) => Err(format!(
            "the condition of transition {} in line {} would become a part of another one: {why}",
            chart.transition_name(at),
            one.line
        )),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chart::coactive::BUDGET;
    use crate::chart::text;
    use crate::parse::file;
    use crate::{Body, Pou};

    fn unit(text: &str) -> Pou {
        file("a.st", &format!("PROGRAM p {text} END_PROGRAM")).expect("a chart").pous.remove(0)
    }

    fn rewritten(text: &str) -> (Chart, Vec<Rewriting>) {
        let pou = unit(text);
        let Body::Chart(chart) = &pou.body else { panic!("a chart") };
        explicit(chart, BUDGET)
    }

    fn stored(qualifier: &str) -> String {
        format!(
            "INITIAL_STEP s0: END_STEP STEP s1: m({qualifier}); END_STEP STEP s2: v(N); END_STEP
             STEP s3: m(R); END_STEP
             TRANSITION FROM s0 TO s1 := a; END_TRANSITION
             TRANSITION FROM s1 TO s2 := b; END_TRANSITION
             TRANSITION FROM s2 TO s3 := c; END_TRANSITION
             TRANSITION FROM s3 TO s0 := d; END_TRANSITION"
        )
    }

    #[test]
    fn a_stored_action_becomes_a_branch() {
        for (from, to) in [("S", "N"), ("SD, T#5s", "D, T#5s"), ("SL, T#5s", "L, T#5s")] {
            let (chart, told) = rewritten(&stored(from));
            assert_eq!(told[0].branch, Ok(vec!["m_on".to_owned()]));
            let shown = text::chart(&chart, &[]);
            for part in [
                "STEP s1:\n  END_STEP",
                &format!("STEP m_on:\n    m({to});\n  END_STEP"),
                "FROM s0 TO (s1, m_on)\n    := a;",
                "FROM s1 TO s2\n    := b;",
                "FROM (s2, m_on) TO s3\n    := c;",
            ] {
                assert!(shown.contains(part), "{part}\n{shown}");
            }
            assert_eq!(chart.transitions.len(), 4);
        }
    }

    #[test]
    fn a_delayed_and_stored_action_waits_in_its_branch() {
        let (chart, told) = rewritten(&stored("DS, T#5s"));
        assert_eq!(told[0].branch, Ok(vec!["m_wait".to_owned(), "m_on".to_owned()]));
        let shown = text::chart(&chart, &[]);
        for part in [
            "FROM s0 TO (s1, m_wait)\n    := a;",
            "FROM (s1, m_wait) TO s2\n    := b;",
            "FROM s1 TO s2\n    := b AND NOT m_wait.X;",
            "FROM (s2, m_on) TO s3\n    := c;",
            "FROM s2 TO s3\n    := c AND NOT m_on.X;",
            "FROM m_wait TO m_on\n    := m_wait.T >= T#5s AND NOT b;",
        ] {
            assert!(shown.contains(part), "{part}\n{shown}");
        }
    }

    #[test]
    fn what_would_not_stay_the_same_is_refused() {
        let refused = |text: &str| {
            let (_, told) = rewritten(text);
            told[0].branch.clone().expect_err("refused")
        };
        let parallel = "INITIAL_STEP s0: END_STEP STEP s1: m(S); END_STEP STEP s2: m(R); END_STEP
             TRANSITION FROM s0 TO (s1, s2) := a; END_TRANSITION
             TRANSITION FROM (s1, s2) TO s0 := b; END_TRANSITION";
        assert_eq!(
            refused(parallel),
            "the steps s1 and s2 can be active together: one stores the action and the other resets it"
        );
        assert!(refused(&stored("SD, t")).contains("no constant"));
        assert!(
            refused(&stored("S").replace("s0: END_STEP", "s0: m(S); END_STEP")).contains("initial")
        );
        assert!(refused(&stored("S").replace("v(N)", "m(SL, T#1s)")).contains("different"));
    }
}
