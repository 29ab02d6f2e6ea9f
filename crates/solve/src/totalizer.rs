//! Counts how many of some literals are true, as far as was asked so far.

use super::formula::{Formula, Renumber};

/// A balanced tree of unary sums. Output `k` (from 1) is true if at least `k` inputs are; it may be true
/// otherwise, too.
pub struct Totalizer {
    nodes: Vec<Sum>,
    position: usize,
}

struct Sum {
    /// Output `k` is at `k - 1`.
    outputs: Vec<i32>,
    size: usize,
    children: Option<(usize, usize)>,
}

impl Totalizer {
    /// Counts the inputs, of which there is at least one. No output yet.
    pub fn new(inputs: &[i32], position: usize) -> Totalizer {
        let leaf = |&input: &i32| Sum { outputs: vec![input], size: 1, children: None };
        let mut nodes: Vec<Sum> = inputs.iter().map(leaf).collect();
        let mut level: Vec<usize> = (0..nodes.len()).collect();
        while level.len() > 1 {
            let pairs = level.chunks(2).map(|pair| match *pair {
                [left, right] => {
                    let size = nodes[left].size + nodes[right].size;
                    nodes.push(Sum { outputs: vec![], size, children: Some((left, right)) });
                    nodes.len() - 1
                }
                _ => pair[0],
            });
            level = pairs.collect();
        }
        Totalizer { nodes, position }
    }

    /// How many inputs there are.
    pub fn size(&self) -> usize {
        self.nodes.last().map_or(0, |root| root.size)
    }

    /// Where in the circuit the counter belongs.
    pub fn position(&self) -> usize {
        self.position
    }

    /// The output for at least `count` inputs, 1 to `size`.
    pub fn output(&mut self, count: usize, formula: &mut Formula) -> i32 {
        let root = self.nodes.len() - 1;
        self.extend(root, count, formula);
        self.nodes[root].outputs[count - 1]
    }

    fn extend(&mut self, node: usize, count: usize, formula: &mut Formula) {
        let count = count.min(self.nodes[node].size);
        let have = self.nodes[node].outputs.len();
        let Some((left, right)) = self.nodes[node].children else { return };
        if have >= count {
            return;
        }
        self.extend(left, count, formula);
        self.extend(right, count, formula);
        for sum in have + 1..=count {
            let output = formula.new_variable();
            if let Some(&smaller) = self.nodes[node].outputs.last() {
                formula.define(self.position, output, &[-output, smaller]);
            }
            self.nodes[node].outputs.push(output);
            let (a, b) = (&self.nodes[left].outputs, &self.nodes[right].outputs);
            for from_left in sum.saturating_sub(b.len())..=sum.min(a.len()) {
                let from_right = sum - from_left;
                let mut clause = vec![output];
                clause.extend((from_left > 0).then(|| -a[from_left - 1]));
                clause.extend((from_right > 0).then(|| -b[from_right - 1]));
                formula.define(self.position, output, &clause);
            }
        }
    }

    /// Gives its outputs new numbers.
    pub fn renumber(&mut self, renumber: &Renumber) {
        for output in self.nodes.iter_mut().flat_map(|node| &mut node.outputs) {
            *output = renumber.of(*output);
        }
    }
}
