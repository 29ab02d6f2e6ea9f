//! A totalizer: counts how many of some literals are true, built as far as needed.

use super::formula::{Formula, Renumbering};

/// A balanced tree of unary sums. Output `k` (from 1) is true if at least `k` inputs are true. The converse is not
/// encoded: an output may be true with fewer true inputs.
pub struct Totalizer {
    nodes: Vec<Sum>,
    position: usize,
}

struct Sum {
    /// Output `k` is at index `k - 1`.
    outputs: Vec<i32>,
    size: usize,
    children: Option<(usize, usize)>,
}

impl Totalizer {
    /// A totalizer for at least one input. It has no outputs yet.
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

    /// The number of inputs.
    pub fn size(&self) -> usize {
        self.nodes.last().map_or(0, |root| root.size)
    }

    /// The position of the totalizer in the order of execution.
    pub fn position(&self) -> usize {
        self.position
    }

    /// The output that is true if at least `count` inputs are true (1 to `size`). Adds the clauses that it still lacks.
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

    /// Gives the variables of inputs and outputs their new numbers.
    pub fn renumber(&mut self, renumber: &Renumbering) {
        for output in self.nodes.iter_mut().flat_map(|node| &mut node.outputs) {
            *output = renumber.of(*output);
        }
    }
}
