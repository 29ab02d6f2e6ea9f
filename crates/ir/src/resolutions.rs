//! How the analysis resolved nondeterministic values in each call context. Replaying a model's scan must resolve them
//! in the same way.

use super::{ChoiceId, Frame, Region};
use std::collections::{BTreeMap, BTreeSet};

/// How the analysis resolved a choice in one call context.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Resolution {
    /// The analysis executed the choice's operation, because its operands were known well enough.
    Exact,
    /// The choice havocs, but only these cells; they may get any values.
    Within(Vec<Region>),
}

/// How choices were resolved in each call context.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Resolutions {
    /// By call context and choice: how the choice was resolved.
    choices: BTreeMap<Vec<Frame>, BTreeMap<ChoiceId, Resolution>>,
    /// For each call context: the instructions whose number of units the analysis read, although
    /// [`super::Counted::is_read`] is false in the context.
    counted: BTreeMap<Vec<Frame>, BTreeSet<usize>>,
}

impl Resolutions {
    /// How the choice was resolved in this call context; `None` if it was left as any value.
    #[must_use]
    pub fn choice(&self, frames: &[Frame], choice: ChoiceId) -> Option<&Resolution> {
        self.choices.get(frames)?.get(&choice)
    }

    /// Whether [`Resolutions::record_count`] was called for the instruction in this call context: the analysis read its
    /// number of units, although [`super::Counted::is_read`] is false there.
    #[must_use]
    pub fn counted(&self, frames: &[Frame], instruction: usize) -> bool {
        self.counted.get(frames).is_some_and(|counted| counted.contains(&instruction))
    }

    /// Records how a choice was resolved.
    pub fn record(&mut self, frames: &[Frame], choice: ChoiceId, resolution: Resolution) {
        match self.choices.get_mut(frames) {
            Some(choices) => _ = choices.insert(choice, resolution),
            None => _ = self.choices.insert(frames.to_vec(), [(choice, resolution)].into()),
        }
    }

    /// Records that the analysis read an instruction's number of units in a call context in which
    /// [`super::Counted::is_read`] is false.
    pub fn record_count(&mut self, frames: &[Frame], instruction: usize) {
        match self.counted.get_mut(frames) {
            Some(counted) => _ = counted.insert(instruction),
            None => _ = self.counted.insert(frames.to_vec(), [instruction].into()),
        }
    }
}
