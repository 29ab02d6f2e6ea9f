//! All clauses of a search: those of the circuit and those that the search adds.

use super::clauses::Clauses;
use super::oracle::Oracle;

/// Clauses, and where in the circuit they belong.
///
/// Every variable has a home, a place in the order of execution; what a search adds has the home of what it
/// was added for. Every clause helps to define one variable. So the clauses that define the variables of a part
/// of the program can be looked at by themselves: what they exclude is excluded, since the whole only adds
/// to them.
pub struct Formula {
    homes: Vec<usize>,
    /// Gates' outputs and counters: their values follow from their inputs'.
    defined: Vec<bool>,
    clauses: Vec<(usize, Vec<i32>)>,
}

impl Formula {
    /// The clauses of a circuit, whose variables are numbered in the order of execution.
    pub fn new(clauses: &Clauses) -> Formula {
        let homes = (0..=clauses.variables).collect();
        let owners = clauses.owners.iter().map(|owner| owner.unsigned_abs() as usize);
        let mut defined = vec![true; clauses.variables + 1];
        for input in clauses.inputs() {
            defined[input.unsigned_abs() as usize] = false;
        }
        Formula { homes, defined, clauses: owners.zip(clauses.clauses.iter().cloned()).collect() }
    }

    /// Where a literal's variable is at home.
    pub fn home(&self, literal: i32) -> usize {
        self.homes[literal.unsigned_abs() as usize]
    }

    /// All variables.
    pub fn variables(&self) -> impl Iterator<Item = i32> + use<> {
        1..i32::try_from(self.homes.len()).expect("variables are counted in 31 bits")
    }

    /// A further variable, which further clauses define.
    pub fn variable(&mut self, home: usize, oracle: &mut Oracle<'_>) -> i32 {
        self.homes.push(home);
        self.defined.push(true);
        let variable =
            i32::try_from(self.homes.len() - 1).expect("variables are counted in 31 bits");
        oracle.define(variable);
        variable
    }

    /// A further clause, which the solver at work is told too.
    pub fn add(&mut self, owner: i32, clause: Vec<i32>, oracle: &mut Oracle<'_>) {
        oracle.add(&clause);
        self.clauses.push((owner.unsigned_abs() as usize, clause));
    }

    /// The clauses sorted by their homes' parts, each of so many homes.
    pub fn parts(&self, size: usize, parts: usize) -> Vec<Vec<usize>> {
        let mut sorted = vec![Vec::new(); parts];
        for (index, &(owner, _)) in self.clauses.iter().enumerate() {
            sorted[self.homes[owner] / size].push(index);
        }
        sorted
    }

    /// All clauses from this index on.
    pub fn since(&self, index: usize) -> impl Iterator<Item = &[i32]> {
        self.clauses[index..].iter().map(|clause| &clause.1[..])
    }

    /// How many clauses there are.
    pub fn len(&self) -> usize {
        self.clauses.len()
    }

    /// Tells a solver some of the clauses, by their indices.
    pub fn teach(&self, indices: &[usize], oracle: &mut Oracle<'_>) {
        for &index in indices {
            let owner = self.clauses[index].0;
            if self.defined[owner] {
                oracle.define(i32::try_from(owner).expect("variables are counted in 31 bits"));
            }
        }
        for &index in indices {
            oracle.add(&self.clauses[index].1);
        }
    }
}
