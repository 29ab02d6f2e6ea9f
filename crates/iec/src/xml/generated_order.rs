//! The order in which Beremiz and OpenPLC write the steps of a drawn chart as text.
//!
//! Their generator (`PLCGenerator.py`) goes through the elements of the chart in the order of the file. A step notes
//! the transitions before it, a transition the steps before it, and what is not known yet is read first. Then it writes
//! the steps from the initial steps on, depth first along the transitions.

/// An element of a drawn chart, by the numbers of its steps and transitions.
pub(super) enum Drawn {
    /// A step, or an action block of this step.
    Step(usize),
    /// A transition.
    Transition(usize),
    /// A jump to a step, behind these transitions.
    Jump(usize, Vec<usize>),
}

/// The connections of a drawn chart.
pub(super) struct Connections {
    /// For each step, whether it is an initial step.
    pub(super) is_initial: Vec<bool>,
    /// For each step, the transitions before it.
    pub(super) before_step: Vec<Vec<usize>>,
    /// For each transition, the steps before it.
    pub(super) before_transition: Vec<Vec<usize>>,
}

/// What remains to be read.
enum Task {
    Step(usize),
    Transition(usize),
    /// The step is noted behind the transition.
    Enters(usize, usize),
    /// The transition is noted behind the step.
    Leaves(usize, usize),
}

/// The steps in the order in which they are written. `elements` are in the order of the file. Steps that no initial
/// step leads to are left out, as they are in the text.
pub(super) fn of_steps(elements: &[Drawn], connections: &Connections) -> Vec<usize> {
    let Connections { is_initial, before_step, before_transition } = connections;
    let mut known = (vec![false; before_step.len()], vec![false; before_transition.len()]);
    let mut behind_step: Vec<Vec<usize>> = vec![Vec::new(); before_step.len()];
    let mut behind_transition: Vec<Vec<usize>> = vec![Vec::new(); before_transition.len()];
    let mut initial = Vec::new();
    let enters = |step: usize, before: &[usize]| -> Vec<Task> {
        let tasks = before.iter().flat_map(|&at| [Task::Transition(at), Task::Enters(at, step)]);
        tasks.rev().collect()
    };
    for element in elements {
        let mut open = match element {
            Drawn::Step(step) => vec![Task::Step(*step)],
            Drawn::Transition(number) => vec![Task::Transition(*number)],
            Drawn::Jump(target, before) => enters(*target, before),
        };
        while let Some(task) = open.pop() {
            match task {
                Task::Step(step) if !std::mem::replace(&mut known.0[step], true) => {
                    initial.extend(is_initial[step].then_some(step));
                    open.extend(enters(step, &before_step[step]));
                }
                Task::Transition(number) if !std::mem::replace(&mut known.1[number], true) => {
                    let steps = before_transition[number].iter();
                    let tasks = steps.flat_map(|&at| [Task::Step(at), Task::Leaves(number, at)]);
                    open.extend(tasks.rev());
                }
                Task::Step(_) | Task::Transition(_) => {}
                Task::Enters(number, step) => behind_transition[number].push(step),
                Task::Leaves(number, step) => behind_step[step].push(number),
            }
        }
    }
    let mut is_written = vec![false; before_step.len()];
    let mut written = Vec::new();
    let mut open: Vec<usize> = initial.into_iter().rev().collect();
    while let Some(step) = open.pop() {
        if !std::mem::replace(&mut is_written[step], true) {
            written.push(step);
            // A transition is written once, behind the first of the steps before it.
            let transitions = behind_step[step].iter();
            let next = transitions.flat_map(|&at| std::mem::take(&mut behind_transition[at]));
            let next: Vec<usize> = next.collect();
            open.extend(next.into_iter().rev());
        }
    }
    written
}

#[cfg(test)]
mod tests {
    use super::*;

    /// S0 with two branches: T0 to S1, and T1 to S2. T2 and T3 lead back by jumps.
    fn steps(elements: &[Drawn]) -> Vec<usize> {
        let connections = Connections {
            is_initial: vec![true, false, false],
            before_step: vec![vec![], vec![0], vec![1]],
            before_transition: vec![vec![0], vec![0], vec![1], vec![2]],
        };
        of_steps(elements, &connections)
    }

    #[test]
    fn branches_come_in_the_order_in_which_the_file_leads_to_them() {
        use Drawn::{Jump, Step, Transition};
        let all = || [Transition(0), Transition(1), Transition(2), Transition(3)];
        let jumps = || [Jump(0, vec![2]), Jump(0, vec![3])];
        let file = [Step(0), Step(1), Step(2)].into_iter().chain(all()).chain(jumps());
        assert_eq!(steps(&file.collect::<Vec<_>>()), [0, 1, 2]);
        // S2 stands before S1, so that T1 is read before T0.
        let file = [Step(2), Step(1), Step(0)].into_iter().chain(all()).chain(jumps());
        assert_eq!(steps(&file.collect::<Vec<_>>()), [0, 2, 1]);
        // The jump behind T3 reads S2, and this T1.
        let file = jumps().into_iter().rev().chain([Step(0), Step(1), Step(2)]).chain(all());
        assert_eq!(steps(&file.collect::<Vec<_>>()), [0, 2, 1]);
        // Without an initial step that leads there, a step is not written.
        assert_eq!(steps(&[Step(0), Transition(0), Step(1), Transition(2)]), [0, 1]);
    }

    #[test]
    fn a_long_chain_against_the_order_of_the_file_is_followed() {
        let count: usize = 100_000;
        let connections = Connections {
            is_initial: (0..count).map(|step| step == 0).collect(),
            before_step: (0..count).map(|step| step.checked_sub(1).into_iter().collect()).collect(),
            before_transition: (0..count).map(|step| vec![step]).collect(),
        };
        let elements: Vec<Drawn> = (0..count).rev().map(Drawn::Step).collect();
        assert!(of_steps(&elements, &connections).into_iter().eq(0..count));
    }
}
