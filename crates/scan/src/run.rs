//! The state of a symbolic execution.

use super::known::KnownChoices;
use super::memory::Memory;
use super::settings::{Purpose, SizeLimits};
use scanbound_base::time::Times;
use scanbound_ir::meaning::Knowledge;
use scanbound_ir::{Frame, Program, WordSource};
use scanbound_model::Lit;
use std::collections::{BTreeMap, BTreeSet};

/// The results of the current rung: the stack on which contacts combine their values, and the slots in which
/// `Step::Save` saved results.
#[derive(Debug, Clone, Default)]
pub(super) struct RungResults {
    /// The stack, with the newest result last. `None` after paths with different stack depths have joined, after a loop
    /// whose iterations may differ in number, and after a summary: nothing may be read until the next rung starts.
    pub(super) stack: Option<Vec<Lit>>,
    pub(super) slots: BTreeMap<u32, Lit>,
}

/// A forward jump whose target is not reached yet: the literal that says whether it was taken, and the results of the
/// rung at the jump. Jumps with one target are merged.
#[derive(Debug, Clone)]
pub(super) struct PendingJump {
    pub(super) taken: Lit,
    pub(super) results: RungResults,
}

/// An open master control region, with its level and the condition of its begin.
#[derive(Debug, Clone, Copy)]
pub(super) struct OpenRegion {
    pub(super) level: u32,
    pub(super) condition: Lit,
    /// The conjunction of the conditions of this region and of all regions opened before it.
    pub(super) all: Lit,
    /// The highest nesting level of this region and of all regions that were opened before it.
    pub(super) highest: u32,
}

/// One execution of a routine, from its call to its return.
pub(super) struct Activation {
    /// The literal that says whether control reaches the current instruction.
    pub(super) active: Lit,
    pub(super) results: RungResults,
    /// The open master control regions, outermost first; there may be thousands.
    pub(super) open_regions: Vec<OpenRegion>,
    /// The jumps that may have been taken and whose target is not reached yet, by the index of the target.
    pub(super) pending_jumps: BTreeMap<usize, PendingJump>,
    /// The literal that says whether a `Return` of this routine was executed.
    pub(super) returned: Lit,
}

/// The state of the symbolic execution of one scan.
pub(super) struct Run<'p> {
    pub(super) program: &'p Program,
    pub(super) times: &'p [Times],
    /// What real runs showed about the results of operations (choices with a known operation).
    pub(super) knowledge: &'p Knowledge,
    pub(super) purpose: Purpose,
    /// The values of choices that were computed so far, and what is known where the current instruction is reached.
    pub(super) known: KnownChoices,
    pub(super) memory: Memory<'p>,
    /// The current call context, outermost frame first.
    pub(super) frames: Vec<Frame>,
    /// The literal that says whether a `Stop` or an unbounded loop ended the main programs.
    pub(super) stopped: Lit,
    /// The number of instructions executed so far.
    pub(super) executed: usize,
    /// The size limits of the model, and the caller's request to stop.
    pub(super) limits: &'p SizeLimits<'p>,
    /// The instructions of which one execution exceeded [`SizeLimits::per_execution`].
    pub(super) costly: BTreeSet<usize>,
}

/// The operands of a loop that is executed iteration by iteration, as in
/// [`Step::ForBegin`](scanbound_ir::Step::ForBegin).
#[derive(Clone, Copy)]
pub(super) struct ForLoop {
    /// The index of the loop's `ForBegin`.
    pub at: usize,
    pub count: WordSource,
    pub least: u32,
    pub most: u32,
    /// The index of the loop's `ForEnd`.
    pub end: usize,
}
