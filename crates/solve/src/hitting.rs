//! Minimum-weight hitting sets: the cheapest items that contain at least one element of every core.

/// Finds a hitting set with the least weight: elements (indices into `weights`, ascending) of which every core contains
/// at least one. Cores must not be empty or contain an element twice. `None` if `stop` ended the search.
pub fn least_hitting_set(
    weights: &[u64],
    cores: &[Vec<usize>],
    stop: &dyn Fn() -> bool,
) -> Option<Vec<usize>> {
    let mut search = Search { weights, stop, steps: 0, stopped: false };
    let found = search.least(cores.to_vec(), u64::MAX);
    if search.stopped {
        return None;
    }
    let (_, mut set) = found?;
    set.sort_unstable();
    Some(set)
}

struct Search<'a> {
    weights: &'a [u64],
    stop: &'a dyn Fn() -> bool,
    steps: u64,
    stopped: bool,
}

impl Search<'_> {
    /// The weight and the elements of the hitting set with the least weight. `None` if it does not weigh less than
    /// `limit`, or the search was stopped.
    fn least(&mut self, mut cores: Vec<Vec<usize>>, limit: u64) -> Option<(u64, Vec<usize>)> {
        self.steps += 1;
        if self.stopped || (self.steps.is_multiple_of(1024) && (self.stop)()) {
            self.stopped = true;
            return None;
        }
        let (mut weight, mut set) = (0, Vec::new());
        // The element of a core with one element must be taken.
        while let Some(core) = cores.iter().find(|core| core.len() == 1) {
            let forced = core[0];
            weight += self.weights[forced];
            set.push(forced);
            cores.retain(|core| !core.contains(&forced));
        }
        if weight >= limit || cores.iter().any(Vec::is_empty) {
            return None;
        }
        let mut parts = components(cores);
        if parts.len() == 1 {
            let (more, rest) = self.branch(parts.remove(0), limit - weight)?;
            set.extend(rest);
            return Some((weight + more, set));
        }
        let mut bounds: Vec<u64> = parts.iter().map(|part| self.lower_bound(part)).collect();
        for (index, part) in parts.into_iter().enumerate() {
            bounds[index] = 0;
            let others: u64 = bounds[index..].iter().sum();
            let (more, rest) = self.branch(part, limit.checked_sub(weight + others)?)?;
            weight += more;
            set.extend(rest);
        }
        (weight < limit).then_some((weight, set))
    }

    /// Searches two cases: the element that is in most cores is in the hitting set, or it is not. Returns the weight of
    /// the best set and its elements; `None` if no set weighs less than `limit`.
    fn branch(&mut self, cores: Vec<Vec<usize>>, limit: u64) -> Option<(u64, Vec<usize>)> {
        if self.lower_bound(&cores) >= limit {
            return None;
        }
        let mut hits = std::collections::BTreeMap::new();
        for &element in cores.iter().flatten() {
            *hits.entry(element).or_insert(0usize) += 1;
        }
        let busiest = hits.iter().max_by_key(|&(element, hits)| (hits, std::cmp::Reverse(element)));
        let element = *busiest.expect("a component has a core, and a core has elements").0;
        let weight = self.weights[element];
        let mut best = None;
        let mut limit = limit;
        if weight < limit {
            let rest = cores.iter().filter(|core| !core.contains(&element)).cloned().collect();
            if let Some((more, mut set)) = self.least(rest, limit - weight) {
                set.push(element);
                limit = weight + more;
                best = Some((limit, set));
            }
        }
        let mut rest = cores;
        for core in &mut rest {
            core.retain(|&other| other != element);
        }
        self.least(rest, limit).or(best)
    }

    /// A lower bound: each core in turn takes the smallest remaining weight of its elements.
    fn lower_bound(&self, cores: &[Vec<usize>]) -> u64 {
        let mut left = std::collections::BTreeMap::new();
        let mut bound = 0;
        for core in cores {
            let rest = |left: &std::collections::BTreeMap<usize, u64>, e: usize| {
                left.get(&e).copied().unwrap_or(self.weights[e])
            };
            let least = core.iter().map(|&element| rest(&left, element)).min().unwrap_or(0);
            for &element in core {
                let value = rest(&left, element) - least;
                left.insert(element, value);
            }
            bound += least;
        }
        bound
    }
}

/// Divides the cores into components that share elements, directly or through others. No cores give no component, since
/// an empty one could not be branched on.
fn components(cores: Vec<Vec<usize>>) -> Vec<Vec<Vec<usize>>> {
    let mut parts: Vec<(Vec<usize>, Vec<Vec<usize>>)> = Vec::new();
    for core in cores {
        let (mut elements, mut together) = (core.clone(), vec![core]);
        let mut apart = Vec::new();
        for part in parts {
            if part.0.iter().any(|element| elements.contains(element)) {
                elements.extend(part.0);
                together.extend(part.1);
            } else {
                apart.push(part);
            }
        }
        elements.sort_unstable();
        elements.dedup();
        apart.push((elements, together));
        parts = apart;
    }
    parts.into_iter().map(|part| part.1).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equals_trying_every_set() {
        // A fixed mix of cores over eight items, from a linear congruential generator.
        let mut state = 1u64;
        let mut next = |below: u64| {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            (state >> 33) % below
        };
        for _ in 0..300 {
            let weights: Vec<u64> = (0..8).map(|_| 1 + next(20)).collect();
            let cores: Vec<Vec<usize>> = (0..next(9))
                .map(|_| {
                    let members = 1 + next(255);
                    (0..8).filter(|element| members >> element & 1 == 1).collect()
                })
                .collect();
            let weight = |set: &[usize]| set.iter().map(|&e| weights[e]).sum::<u64>();
            let least = (0..256usize)
                .map(|set| (0..8).filter(|e| set >> e & 1 == 1).collect::<Vec<usize>>())
                .filter(|set| cores.iter().all(|core| core.iter().any(|e| set.contains(e))))
                .map(|set| weight(&set))
                .min();
            let found = least_hitting_set(&weights, &cores, &|| false).unwrap();
            assert!(cores.iter().all(|core| core.iter().any(|e| found.contains(e))));
            assert_eq!(Some(weight(&found)), least);
        }
    }

    #[test]
    fn stops_when_told() {
        let cores: Vec<Vec<usize>> =
            (0..60).flat_map(|a| (1..8).map(move |d| vec![a, (a + d * d) % 60])).collect();
        assert_eq!(least_hitting_set(&[1; 60], &cores, &|| true), None);
    }
}
