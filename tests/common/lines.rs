//! What generators of list text have in common.

use super::tape::Tape;

/// Draws the lines of a program from a tape, item by item.
pub trait DrawsLines<'a> {
    /// What is drawn from.
    fn tape(&mut self) -> &mut Tape<'a>;

    /// The lines so far.
    fn lines(&mut self) -> &mut Vec<String>;

    /// Draws an item: some rungs, or a loop or jump around further items, which are one deeper.
    fn item(&mut self, depth: u32);

    fn put(&mut self, line: impl Into<String>) {
        self.lines().push(line.into());
    }

    fn pick(&mut self, of: &[&'static str]) -> &'static str {
        self.tape().pick(of)
    }

    /// Draws items, so many at most, as long as there is anything on the tape.
    fn items(&mut self, depth: u32, most: usize) {
        for _ in 0..1 + self.tape().below(most) {
            self.item(depth);
            if self.tape().done() {
                break;
            }
        }
    }
}
