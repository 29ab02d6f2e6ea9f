//! A table that numbers values and stores equal values once. There are millions of values, so the hash table holds only
//! their numbers.

use hashbrown::HashTable;
use rustc_hash::FxBuildHasher;
use std::hash::{BuildHasher, Hash};

/// Distinct values with their numbers, which are assigned from 0 on in order of insertion.
#[derive(Debug, Clone)]
pub struct Shared<T> {
    values: Vec<T>,
    numbers: HashTable<u32>,
}

impl<T> Default for Shared<T> {
    fn default() -> Shared<T> {
        Shared { values: Vec::new(), numbers: HashTable::new() }
    }
}

impl<T: Copy + Eq + Hash> Shared<T> {
    /// The number of a value; if the value is new, it is stored with the next number.
    pub fn number(&mut self, value: T) -> u32 {
        let Shared { values, numbers } = self;
        let hash = |value: &T| FxBuildHasher.hash_one(value);
        let entry = numbers.entry(
            hash(&value),
            |&number| values[number as usize] == value,
            |&number| hash(&values[number as usize]),
        );
        let new = || u32::try_from(values.len()).expect("the number of values must fit in 32 bits");
        let number = *entry.or_insert_with(new).get();
        if number as usize == values.len() {
            values.push(value);
        }
        number
    }

    /// The value with this number.
    #[must_use]
    pub fn get(&self, number: u32) -> T {
        self.values[number as usize]
    }

    /// All values, by number.
    #[must_use]
    pub fn all(&self) -> &[T] {
        &self.values
    }

    /// Changes the values in place; different values must remain different. Values that do not change keep their place
    /// in the hash table.
    pub fn change(&mut self, mut change: impl FnMut(&mut T)) {
        let Shared { values, numbers } = self;
        let hash = |value: &T| FxBuildHasher.hash_one(value);
        let mut changed = Vec::new();
        for (value, number) in values.iter_mut().zip(0u32..) {
            let before = *value;
            change(value);
            if *value != before {
                if let Ok(entry) = numbers.find_entry(hash(&before), |&other| other == number) {
                    entry.remove();
                }
                changed.push(number);
            }
        }
        for number in changed {
            let again = |&number: &u32| hash(&values[number as usize]);
            numbers.insert_unique(hash(&values[number as usize]), number, again);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_values_have_one_number() {
        let mut shared = Shared::default();
        let numbers = |shared: &mut Shared<u64>| -> Vec<u32> {
            (0..1000).map(|n| shared.number(n * n % 1009)).collect()
        };
        let first = numbers(&mut shared);
        assert_eq!(first[10], first[999]);
        assert_eq!(numbers(&mut shared), first);
        assert!((0..1000).all(|n| shared.get(first[n]) == (n * n % 1009) as u64));
        assert!(shared.all().len() < 1000);
        let before = shared.all().to_vec();
        shared.change(|value| *value += 7);
        assert!(before.iter().zip(0..).all(|(value, n)| shared.number(value + 7) == n));
    }
}
