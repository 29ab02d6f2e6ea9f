//! The common part of generators of list text.

use super::tape::Tape;

/// Draws the lines of a program from a tape, item by item.
pub trait DrawsLines<'a> {
    /// The source of random numbers.
    fn tape(&mut self) -> &mut Tape<'a>;

    /// The lines so far.
    fn lines(&mut self) -> &mut Vec<String>;

    /// Draws an item: some rungs, or a loop or jump around further items at the next depth.
    fn item(&mut self, depth: u32);

    fn put(&mut self, line: impl Into<String>) {
        self.lines().push(line.into());
    }

    fn pick(&mut self, of: &[&'static str]) -> &'static str {
        self.tape().pick(of)
    }

    /// Draws at most this many items, until the tape ends.
    fn items(&mut self, depth: u32, most: usize) {
        for _ in 0..1 + self.tape().below(most) {
            self.item(depth);
            if self.tape().done() {
                break;
            }
        }
    }
}
