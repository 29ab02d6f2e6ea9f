//! All clauses of a search: those of the circuit and those that the search adds.

use super::clauses::Clauses;
use super::oracle::Oracle;

/// Clauses of a search, each with its position in the order of execution.
///
/// The position of a clause is the variable that it helps to define; a clause that a search adds has the position of
/// the thing for which it was added. So the clauses in one partition of the program can be examined alone. What they
/// exclude is excluded in the whole program, which only has more clauses.
pub struct Formula {
    /// The number of variables, including those that the search added.
    variables: usize,
    clauses: Vec<Place>,
    /// The literals of all clauses.
    literals: Vec<i32>,
}

#[derive(Clone, Copy)]
struct Place {
    position: u32,
    /// The variable that the clause helps to define; 0 if it defines none.
    defines: i32,
    /// The end of the clause in the array of literals.
    end: u32,
}

impl Formula {
    /// Takes the clauses out of `clauses`, whose variables are numbered in the order of execution. They are moved, not
    /// copied, because there are millions.
    pub fn new(clauses: &mut Clauses) -> Formula {
        let mut defined = vec![true; clauses.variables + 1];
        for input in clauses.inputs() {
            defined[input.unsigned_abs() as usize] = false;
        }
        let owners = std::mem::take(&mut clauses.owners);
        let (literals, ends) = std::mem::take(&mut clauses.clauses).into_literals();
        let place = |(owner, end): (i32, u32)| {
            let position = owner.unsigned_abs();
            let defines = if defined[position as usize] { owner.abs() } else { 0 };
            Place { position, defines, end }
        };
        let places = owners.into_iter().zip(ends).map(place).collect();
        Formula { variables: clauses.variables, clauses: places, literals }
    }

    fn empty(variables: usize) -> Formula {
        Formula { variables, clauses: Vec::new(), literals: Vec::new() }
    }

    fn push(&mut self, position: usize, defines: i32, clause: &[i32]) {
        self.literals.extend_from_slice(clause);
        self.clauses.push(Place {
            position: small(position),
            defines,
            end: small(self.literals.len()),
        });
    }

    /// The clauses that remain if some values are fixed: 1 for a literal that is true, -1 for one that is false, else
    /// 0.
    pub fn under(&self, value: impl Fn(i32) -> i8) -> Formula {
        let mut left = Formula::empty(self.variables);
        let mut open = Vec::new();
        for (index, place) in self.clauses.iter().enumerate() {
            let clause = self.clause(index);
            if clause.iter().any(|&literal| value(literal) == 1) {
                continue;
            }
            open.clear();
            open.extend(clause.iter().copied().filter(|&literal| value(literal) == 0));
            left.push(place.position as usize, place.defines, &open);
        }
        left
    }

    /// The number of variables, including those that the search added.
    pub fn variable_count(&self) -> usize {
        self.variables
    }

    /// All variables.
    pub fn variables(&self) -> impl Iterator<Item = i32> + use<> {
        1..=i32::try_from(self.variables).expect("the number of variables must fit in 31 bits")
    }

    /// Adds a variable, to be defined by further clauses.
    pub fn new_variable(&mut self) -> i32 {
        self.variables += 1;
        i32::try_from(self.variables).expect("the number of variables must fit in 31 bits")
    }

    /// Adds a clause that helps to define an added variable.
    pub fn define(&mut self, position: usize, variable: i32, clause: &[i32]) {
        self.push(position, variable, clause);
    }

    /// Adds a clause that defines no variable.
    pub fn add(&mut self, position: usize, clause: &[i32]) {
        self.push(position, 0, clause);
    }

    /// The number of clauses.
    pub fn len(&self) -> usize {
        self.clauses.len()
    }

    /// The clauses from the one with this index on, in the order in which they were added.
    pub fn since(&self, index: usize) -> impl Iterator<Item = &[i32]> {
        (index..self.len()).map(|index| self.clause(index))
    }

    fn clause(&self, index: usize) -> &[i32] {
        let start = if index == 0 { 0 } else { self.clauses[index - 1].end as usize };
        &self.literals[start..self.clauses[index].end as usize]
    }

    /// Passes the clauses from this index on to the solver `oracle`.
    pub fn pass_to(&self, index: usize, oracle: &mut Oracle<'_>) {
        for place in &self.clauses[index..] {
            if place.defines != 0 {
                oracle.define(place.defines);
            }
        }
        for clause in self.since(index) {
            oracle.add(clause);
        }
    }

    /// Splits the clauses by their positions into partitions of `size` positions each. No clause remains here.
    pub fn split(&mut self, size: usize, partitions: usize) -> Vec<Formula> {
        if partitions == 1 {
            let none = Formula::empty(self.variables);
            return vec![std::mem::replace(self, none)];
        }
        let mut split: Vec<Formula> =
            (0..partitions).map(|_| Formula::empty(self.variables)).collect();
        for (index, place) in self.clauses.iter().enumerate() {
            let position = place.position as usize;
            split[position / size].push(position, place.defines, self.clause(index));
        }
        *self = Formula::empty(self.variables);
        split
    }

    /// Takes back the clauses of a partition. Variables that the partition added get numbers after those of the
    /// partitions before it.
    pub fn join(&mut self, partition: Formula, renumber: &Renumbering) {
        if self.clauses.is_empty() && renumber.by == 0 {
            *self = partition;
            return;
        }
        for (index, place) in partition.clauses.iter().enumerate() {
            self.literals
                .extend(partition.clause(index).iter().map(|&literal| renumber.of(literal)));
            let defines = renumber.of(place.defines);
            self.clauses.push(Place { defines, end: small(self.literals.len()), ..*place });
        }
        self.variables += partition.variables - renumber.shared;
    }

    /// The renumbering for the next partition to be joined. `shared` is the number of variables when the partitions
    /// were split.
    pub fn renumber(&self, shared: usize) -> Renumbering {
        Renumbering { shared, by: self.variables - shared }
    }
}

/// Stores an index in 32 bits, because there are very many clauses.
fn small(number: usize) -> u32 {
    u32::try_from(number).expect("the number of literals must fit in 32 bits")
}

/// A renumbering of the variables that a partition has added.
pub struct Renumbering {
    /// The number of variables that all partitions share; these keep their numbers.
    shared: usize,
    /// The number of variables that the partitions before this one have added.
    by: usize,
}

impl Renumbering {
    /// The literal with the new number of its variable.
    pub fn of(&self, literal: i32) -> i32 {
        if literal.unsigned_abs() as usize <= self.shared {
            return literal;
        }
        let by = i32::try_from(self.by).expect("the number of variables must fit in 31 bits");
        literal + literal.signum() * by
    }
}
