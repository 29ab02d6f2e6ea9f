//! The state of the execution.

use super::known::Known;
use super::memory::Memory;
use super::settings::{Purpose, SizeLimits};
use scanbound_base::time::Times;
use scanbound_ir::meaning::Knowledge;
use scanbound_ir::{Frame, Program, WordSource};
use scanbound_model::Lit;
use std::collections::{BTreeMap, BTreeSet};

/// The results of a routine's rungs: stack and save slots.
#[derive(Debug, Clone, Default)]
pub(super) struct Results {
    /// `None` where paths of different depth met: nothing may be read until a rung starts.
    pub(super) stack: Option<Vec<Lit>>,
    pub(super) slots: BTreeMap<u32, Lit>,
}

/// A jump that has not reached its target yet: whether it was taken, and the results it carries.
#[derive(Debug, Clone)]
pub(super) struct Landing {
    pub(super) taken: Lit,
    pub(super) results: Results,
}

/// An open master control region.
#[derive(Debug, Clone, Copy)]
pub(super) struct Master {
    pub(super) level: u32,
    pub(super) condition: Lit,
    /// The conditions of this master control region and of all that were opened before it.
    pub(super) all: Lit,
    /// The highest level of these.
    pub(super) highest: u32,
}

/// One activation of a routine.
pub(super) struct Activation {
    /// Whether control is here.
    pub(super) active: Lit,
    pub(super) results: Results,
    /// The open master control regions: there may be thousands.
    pub(super) masters: Vec<Master>,
    /// Jumps that were taken and whose target is not reached yet, by their target.
    pub(super) landings: BTreeMap<usize, Landing>,
    /// Whether a `Return` was reached.
    pub(super) returned: Lit,
}

/// The state of the execution.
pub(super) struct Run<'p> {
    pub(super) program: &'p Program,
    pub(super) times: &'p [Times],
    /// What was learned of exact choices.
    pub(super) knowledge: &'p Knowledge,
    pub(super) purpose: Purpose,
    /// What the choices of which something is known were found to be so far.
    pub(super) known: Known,
    pub(super) memory: Memory<'p>,
    /// The calls, loop iterations and interrupts that lead here, outermost first.
    pub(super) frames: Vec<Frame>,
    /// Whether a `Stop` ended the scan.
    pub(super) stopped: Lit,
    /// How many instructions were executed.
    pub(super) executed: usize,
    /// How large the model may get.
    pub(super) limits: &'p SizeLimits<'p>,
    /// The instructions of which one execution passed the limit for one.
    pub(super) costly: BTreeSet<usize>,
}

/// A loop that is followed, as [`Step::ForBegin`](scanbound_ir::Step::ForBegin) says.
#[derive(Clone, Copy)]
pub(super) struct ForLoop {
    /// Where it begins.
    pub at: usize,
    pub count: WordSource,
    pub least: u32,
    pub most: u32,
    /// Where it ends.
    pub end: usize,
}
