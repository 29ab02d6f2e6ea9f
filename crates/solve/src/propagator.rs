//! Unit propagation over a growing set of clauses, with the assumptions that cause each conflict.

/// The index in the arena of a clause with more than two literals. Its first two literals are watched.
type Place = u32;

/// Why a literal is true.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Reason {
    /// The literal was assumed, or is true without assumptions.
    None,
    /// The clause has two literals; the one given here is false.
    Binary(i32),
    /// The clause at this place in the arena; all of its other literals are false.
    Clause(Place),
}

#[derive(Clone, Copy)]
struct Watch {
    /// A second literal of the clause; while it is true, nothing has to be done for this clause.
    blocker: i32,
    place: Place,
}

/// Marks the watch of a binary clause, which is not in the arena.
const BINARY: Place = u32::MAX;

/// Clauses, assumptions, and all literals that unit propagation derives from them (the *trail*). Literals are integers
/// as in DIMACS files: a variable (from 1) or its negative.
#[derive(Clone, Default)]
pub struct Propagator {
    /// For every clause with more than two literals: its length, then its literals.
    arena: Vec<i32>,
    watches: Vec<Vec<Watch>>,
    /// By literal: 1 true, -1 false, 0 unassigned.
    values: Vec<i8>,
    levels: Vec<u32>,
    reasons: Vec<Reason>,
    trail: Vec<i32>,
    /// The index in the trail at which each level begins.
    limits: Vec<usize>,
    head: usize,
    seen: Vec<bool>,
    /// Literals that are true without assumptions, to be assigned when the last assumption is removed.
    late: Vec<i32>,
    /// A buffer for the literals of a clause that is being added.
    open: Vec<i32>,
    /// Whether the clauses are known to contradict each other.
    contradiction: bool,
}

fn code(literal: i32) -> usize {
    2 * literal.unsigned_abs() as usize + usize::from(literal < 0)
}

impl Propagator {
    /// An empty propagator with room for this many variables, and for clauses with this many literals in total. There
    /// may be millions of both.
    pub fn with_room(variables: usize, literals: usize) -> Propagator {
        let mut propagator = Propagator::default();
        let further = variables / 8;
        propagator.watches.reserve_exact(2 * (variables + further));
        propagator.values.reserve_exact(2 * (variables + further));
        propagator.levels.reserve_exact(variables + further);
        propagator.reasons.reserve_exact(variables + further);
        propagator.seen.reserve_exact(variables + further);
        propagator.arena.reserve_exact(literals);
        propagator
    }

    /// Makes room for variables up to this one.
    fn reserve(&mut self, variable: usize) {
        if self.levels.len() <= variable {
            self.watches.resize_with(2 * variable + 2, Vec::new);
            self.values.resize(2 * variable + 2, 0);
            self.levels.resize(variable + 1, 0);
            self.reasons.resize(variable + 1, Reason::None);
            self.seen.resize(variable + 1, false);
        }
    }

    /// Adds a clause. Under assumptions, a clause that is already false or unit may go unnoticed until the assumptions
    /// are removed.
    pub fn add(&mut self, clause: &[i32]) {
        self.reserve(
            clause.iter().map(|literal| literal.unsigned_abs() as usize).max().unwrap_or(0),
        );
        let mut open = std::mem::take(&mut self.open);
        open.clear();
        if !self.always_holds(clause, &mut open) {
            self.watch(&mut open);
        }
        self.open = open;
    }

    /// Whether the clause is true without assumptions. If not, `open` gets its literals that are unassigned without
    /// assumptions.
    fn always_holds(&self, clause: &[i32], open: &mut Vec<i32>) -> bool {
        for &literal in clause {
            match self.values[code(literal)] {
                1 if self.level_of(literal) == 0 => return true,
                -1 if self.level_of(literal) == 0 => {}
                _ if open.contains(&-literal) => return true,
                _ if open.contains(&literal) => {}
                _ => open.push(literal),
            }
        }
        false
    }

    /// Adds a clause of these literals, which are unassigned without assumptions.
    fn watch(&mut self, open: &mut [i32]) {
        // Watch literals that are not false, else those that became false last.
        open.sort_by_key(|&l| match self.values[code(l)] {
            -1 => u32::MAX - self.level_of(l),
            _ => 0,
        });
        match *open {
            [] => self.contradiction = true,
            [literal] => {
                self.late.push(literal);
                if self.limits.is_empty() {
                    self.assign_fixed();
                }
            }
            [a, b] => {
                self.watches[code(-a)].push(Watch { blocker: b, place: BINARY });
                self.watches[code(-b)].push(Watch { blocker: a, place: BINARY });
                if self.value(a) == 0 && self.value(b) == -1 {
                    self.set(a, Reason::Binary(b));
                }
            }
            [a, b, ..] => {
                let place = Place::try_from(self.arena.len()).expect("clauses fit 32 bits");
                self.arena.push(open.len() as i32);
                self.arena.extend_from_slice(open);
                self.watches[code(-a)].push(Watch { blocker: b, place });
                self.watches[code(-b)].push(Watch { blocker: a, place });
                if self.value(a) == 0 && self.value(b) == -1 {
                    self.set(a, Reason::Clause(place));
                }
            }
        }
    }

    fn level_of(&self, literal: i32) -> u32 {
        self.levels[literal.unsigned_abs() as usize]
    }

    /// 1 if the literal is true, -1 if it is false, 0 if it is unassigned.
    pub fn value(&self, literal: i32) -> i8 {
        self.values.get(code(literal)).copied().unwrap_or(0)
    }

    /// The number of clauses in which the variable is watched.
    pub fn occurrences(&self, variable: i32) -> usize {
        let of = |literal| self.watches.get(code(literal)).map_or(0, Vec::len);
        of(variable) + of(-variable)
    }

    /// The number of assumptions.
    pub fn level(&self) -> usize {
        self.limits.len()
    }

    /// The assumptions and all literals that follow from them, without those that are true without assumptions.
    pub fn implied(&self) -> &[i32] {
        &self.trail[self.limits.first().copied().unwrap_or(0)..]
    }

    /// The number of literals that are assigned true, with or without assumptions.
    pub fn length(&self) -> usize {
        self.trail.len()
    }

    /// The literals that were assigned true after the trail had this length.
    pub fn since(&self, length: usize) -> &[i32] {
        &self.trail[length..]
    }

    /// Removes assumptions until this many remain.
    pub fn retract_to(&mut self, level: usize) {
        if level < self.limits.len() {
            self.undo(level);
        }
        if level == 0 {
            self.assign_fixed();
        }
    }

    /// Assigns the literals that are true without assumptions.
    fn assign_fixed(&mut self) {
        for literal in std::mem::take(&mut self.late) {
            match self.value(literal) {
                0 => {
                    self.set(literal, Reason::None);
                    self.contradiction |= self.propagate().is_some();
                }
                1 => {}
                _ => self.contradiction = true,
            }
        }
    }

    /// Whether propagation without assumptions has shown that the clauses contradict each other. Then not all
    /// consequences are assigned, and later queries find less.
    pub fn has_contradiction(&self) -> bool {
        self.contradiction
    }

    fn undo(&mut self, level: usize) {
        let keep = self.limits[level];
        for &literal in &self.trail[keep..] {
            self.values[code(literal)] = 0;
            self.values[code(-literal)] = 0;
        }
        self.trail.truncate(keep);
        self.limits.truncate(level);
        self.head = keep;
    }

    /// Assumes an unassigned literal. On a conflict, returns assumptions (including this one) that cannot be true
    /// together, and removes the assumption. `None` if there is no conflict.
    pub fn assume(&mut self, literal: i32) -> Option<Vec<i32>> {
        self.reserve(literal.unsigned_abs() as usize);
        // Removing the assumption of an assigned literal would remove the assignment, too.
        debug_assert_eq!(self.value(literal), 0, "a literal must be unassigned when it is assumed");
        self.limits.push(self.trail.len());
        self.set(literal, Reason::None);
        let (first, reason) = self.propagate()?;
        // `first` is false, as are all other literals of the reason.
        let mut false_literals = vec![first];
        self.others(first, reason, &mut false_literals);
        let core = self.ancestors(false_literals);
        self.retract_to(self.limits.len() - 1);
        Some(core)
    }

    /// For a false literal: a core that consists of it and of the assumptions that make it false.
    fn core_of(&mut self, literal: i32) -> Vec<i32> {
        let mut core = self.ancestors(vec![literal]);
        core.push(literal);
        core
    }

    /// Assumes a literal, whatever its current value is. If propagation shows a conflict, returns assumptions that
    /// cannot be true together, and does not assume the literal. `None` if there is no conflict.
    pub fn require(&mut self, literal: i32) -> Option<Vec<i32>> {
        match self.value(literal) {
            0 => self.assume(literal),
            1 => None,
            _ => Some(self.core_of(literal)),
        }
    }

    fn set(&mut self, literal: i32, reason: Reason) {
        let variable = literal.unsigned_abs() as usize;
        self.values[code(literal)] = 1;
        self.values[code(-literal)] = -1;
        self.levels[variable] = self.limits.len() as u32;
        self.reasons[variable] = reason;
        self.trail.push(literal);
    }

    fn propagate(&mut self) -> Option<(i32, Reason)> {
        while self.head < self.trail.len() {
            let truth = self.trail[self.head];
            self.head += 1;
            let at = code(truth);
            let mut watches = std::mem::take(&mut self.watches[at]);
            let (mut read, mut kept) = (0, 0);
            let mut conflict = None;
            while read < watches.len() {
                let watch = watches[read];
                read += 1;
                let blocker = self.values[code(watch.blocker)];
                if blocker == 1 {
                    watches[kept] = watch;
                    kept += 1;
                    continue;
                }
                if watch.place == BINARY {
                    watches[kept] = watch;
                    kept += 1;
                    if blocker == -1 {
                        conflict = Some((watch.blocker, Reason::Binary(-truth)));
                        break;
                    }
                    self.set(watch.blocker, Reason::Binary(-truth));
                    continue;
                }
                let start = watch.place as usize + 1;
                let length = self.arena[watch.place as usize] as usize;
                let clause = &mut self.arena[start..start + length];
                if clause[0] == -truth {
                    clause.swap(0, 1);
                }
                let other = clause[0];
                let watch = Watch { blocker: other, place: watch.place };
                if self.values[code(other)] == 1 {
                    watches[kept] = watch;
                    kept += 1;
                    continue;
                }
                let values = &self.values;
                if let Some(next) = (2..length).find(|&k| values[code(clause[k])] != -1) {
                    clause.swap(1, next);
                    let literal = clause[1];
                    self.watches[code(-literal)].push(watch);
                    continue;
                }
                watches[kept] = watch;
                kept += 1;
                if self.values[code(other)] == -1 {
                    conflict = Some((other, Reason::Clause(watch.place)));
                    break;
                }
                self.set(other, Reason::Clause(watch.place));
            }
            watches.copy_within(read.., kept);
            watches.truncate(kept + watches.len() - read);
            self.watches[at] = watches;
            if conflict.is_some() {
                return conflict;
            }
        }
        None
    }

    /// Adds the false literals of a reason, except `literal` and its negation.
    fn others(&self, literal: i32, reason: Reason, found: &mut Vec<i32>) {
        match reason {
            Reason::None => {}
            Reason::Binary(other) => found.push(other),
            Reason::Clause(place) => {
                let start = place as usize + 1;
                let clause = &self.arena[start..start + self.arena[place as usize] as usize];
                found.extend(clause.iter().copied().filter(|l| l.abs() != literal.abs()));
            }
        }
    }

    /// Assumptions that together make these false literals false.
    fn ancestors(&mut self, mut open: Vec<i32>) -> Vec<i32> {
        let (mut core, mut marked) = (Vec::new(), Vec::new());
        while let Some(literal) = open.pop() {
            let variable = literal.unsigned_abs() as usize;
            if self.seen[variable] || self.levels[variable] == 0 {
                continue;
            }
            self.seen[variable] = true;
            marked.push(variable);
            match self.reasons[variable] {
                Reason::None => core.push(-literal),
                reason => self.others(literal, reason, &mut open),
            }
        }
        for variable in marked {
            self.seen[variable] = false;
        }
        core
    }
}
