//! Breadth-first search over states of a few 64-bit words, fast and small enough for millions of states.

use hashbrown::HashTable;
use rustc_hash::FxHasher;
use std::hash::Hasher as _;

/// The states that were reached, by increasing distance from the start states, each with the step that reached it.
#[derive(Debug)]
pub struct Search {
    width: usize,
    words: Vec<u64>,
    /// For each state its predecessor and the step; a start state is its own predecessor.
    before: Vec<(u32, u32)>,
    /// Whether all reachable states were visited.
    pub complete: bool,
}

impl Search {
    /// The number of states.
    #[must_use]
    pub fn len(&self) -> usize {
        self.before.len()
    }

    /// Whether there are none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.before.is_empty()
    }

    /// The state with this number.
    #[must_use]
    pub fn state(&self, at: usize) -> &[u64] {
        &self.words[at * self.width..(at + 1) * self.width]
    }

    /// The states in the order in which they were reached.
    pub fn states(&self) -> impl Iterator<Item = &[u64]> {
        (0..self.len()).map(|at| self.state(at))
    }

    /// A shortest path to a state: the number of the start state, and the steps.
    #[must_use]
    pub fn path(&self, mut at: usize) -> (usize, Vec<u32>) {
        let mut steps = Vec::new();
        while self.before[at].0 as usize != at {
            steps.push(self.before[at].1);
            at = self.before[at].0 as usize;
        }
        steps.reverse();
        (at, steps)
    }

    fn add(&mut self, known: &mut HashTable<u32>, state: &[u64], from: Option<(u32, u32)>) {
        let at = self.before.len();
        let (width, words) = (self.width, &self.words);
        let of = |at: u32| &words[at as usize * width..(at as usize + 1) * width];
        let number = u32::try_from(at).unwrap_or(u32::MAX);
        known.insert_unique(hash(state), number, |&other| hash(of(other)));
        self.words.extend_from_slice(state);
        self.before.push(from.unwrap_or((number, 0)));
    }

    fn knows(&self, known: &HashTable<u32>, state: &[u64]) -> bool {
        known.find(hash(state), |&other| self.state(other as usize) == state).is_some()
    }
}

fn hash(state: &[u64]) -> u64 {
    let mut hasher = FxHasher::default();
    state.iter().for_each(|&word| hasher.write_u64(word));
    hasher.finish()
}

/// Searches states of `width` words from the start states, at most `limit` states. `next` gets a state's number, the
/// state, and a function to which it passes each possible step with the state after it.
pub fn search(
    width: usize,
    starts: &[Vec<u64>],
    limit: usize,
    mut next: impl FnMut(usize, &[u64], &mut dyn FnMut(u32, &[u64])),
) -> Search {
    let mut found = Search { width, words: Vec::new(), before: Vec::new(), complete: true };
    let mut known = HashTable::new();
    for start in starts {
        if !found.knows(&known, start) {
            found.add(&mut known, start, None);
        }
    }
    let mut at = 0;
    let mut state = vec![0; width];
    // State numbers must fit into `u32`.
    let limit = limit.min(u32::MAX as usize - 1);
    while at < found.len() {
        state.copy_from_slice(found.state(at));
        let from = u32::try_from(at).unwrap_or(u32::MAX);
        next(at, &state, &mut |step, behind| {
            if found.knows(&known, behind) {
                return;
            }
            if found.len() >= limit {
                found.complete = false;
                return;
            }
            found.add(&mut known, behind, Some((from, step)));
        });
        at += 1;
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_states_are_found_by_shortest_ways() {
        // Test system: numbers up to 99; a step adds one or doubles.
        let found = search(1, &[vec![1]], 1_000, |_, state, take| {
            for (step, value) in [(0, state[0] + 1), (1, state[0] * 2)] {
                if value < 100 {
                    take(step, &[value]);
                }
            }
        });
        assert!(found.complete && found.len() == 99);
        let at = found.states().position(|state| state == [96]).unwrap();
        let (start, path) = found.path(at);
        assert_eq!((start, path.len()), (0, 7));
        let value =
            path.iter().fold(1, |value, step| if *step == 0 { value + 1 } else { value * 2 });
        assert_eq!(value, 96);
    }

    #[test]
    fn a_limit_that_is_reached_is_told() {
        let found = search(1, &[vec![0]], 10, |_, state, take| take(0, &[state[0] + 1]));
        assert!(!found.complete && found.len() == 10);
    }
}
