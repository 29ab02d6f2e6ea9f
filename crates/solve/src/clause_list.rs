//! A compact list of clauses: there are millions, most of them with two literals.

/// A list of clauses, stored in one array of literals.
#[derive(Debug, Clone, Default)]
pub struct ClauseList {
    literals: Vec<i32>,
    /// The end of each clause in the array.
    ends: Vec<u32>,
}

impl ClauseList {
    /// Adds a clause.
    pub fn push(&mut self, clause: impl IntoIterator<Item = i32>) {
        self.literals.extend(clause);
        self.ends.push(
            u32::try_from(self.literals.len()).expect("the number of literals must fit in 32 bits"),
        );
    }

    /// All clauses in order of insertion.
    pub fn iter(&self) -> impl ExactSizeIterator<Item = &[i32]> {
        let mut start = 0;
        self.ends.iter().map(move |&end| {
            let clause = &self.literals[start..end as usize];
            start = end as usize;
            clause
        })
    }

    /// The array of literals, and the end of each clause in it.
    #[must_use]
    pub fn into_literals(self) -> (Vec<i32>, Vec<u32>) {
        (self.literals, self.ends)
    }

    /// The literals of all clauses.
    #[must_use]
    pub fn literals(&self) -> &[i32] {
        &self.literals
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn clauses_come_back_as_they_were_put_in() {
        let mut list = ClauseList::default();
        let all: [&[i32]; 4] = [&[1, -2], &[], &[3], &[-1, 2, 3]];
        all.iter().for_each(|clause| list.push(clause.iter().copied()));
        assert!(list.iter().eq(all));
        assert_eq!(list.literals(), [1, -2, 3, -1, 2, 3]);
        assert_eq!(list.iter().len(), 4);
    }
}
