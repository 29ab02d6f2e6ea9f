//! What the analysis settled on its way through a scan, by the moment: a run of the model takes it likewise.

use super::{ChoiceId, Frame, Region};
use std::collections::{BTreeMap, BTreeSet};

/// How a choice was settled at one moment.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Settling {
    /// Its operation was carried out: what it reads was known well enough.
    Exact,
    /// What it writes is any value, in these cells alone.
    Within(Vec<Region>),
}

/// What was settled. A moment is a call context, and what was settled in it.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Settled {
    /// Choices.
    choices: BTreeMap<Vec<Frame>, BTreeMap<ChoiceId, Settling>>,
    /// Instructions whose units were counted where they are not asked for else ([`super::Counted::is_asked`]).
    counted: BTreeMap<Vec<Frame>, BTreeSet<usize>>,
}

impl Settled {
    /// How a choice was settled, if it was.
    #[must_use]
    pub fn choice(&self, frames: &[Frame], choice: ChoiceId) -> Option<&Settling> {
        self.choices.get(frames)?.get(&choice)
    }

    /// Whether an instruction's units were counted.
    #[must_use]
    pub fn counted(&self, frames: &[Frame], instruction: usize) -> bool {
        self.counted.get(frames).is_some_and(|counted| counted.contains(&instruction))
    }

    /// Settles a choice.
    pub fn settle(&mut self, frames: &[Frame], choice: ChoiceId, settling: Settling) {
        match self.choices.get_mut(frames) {
            Some(choices) => _ = choices.insert(choice, settling),
            None => _ = self.choices.insert(frames.to_vec(), [(choice, settling)].into()),
        }
    }

    /// Notes that an instruction's units were counted.
    pub fn count(&mut self, frames: &[Frame], instruction: usize) {
        match self.counted.get_mut(frames) {
            Some(counted) => _ = counted.insert(instruction),
            None => _ = self.counted.insert(frames.to_vec(), [instruction].into()),
        }
    }
}
