//! The state after power-up, and the variables that keep their values without power.

use super::Lower;
use super::first_values::{First, FirstValue};
use super::spots::{Instance, Spot};
use scanbound_iec::{PouKind, Section};
use scanbound_iec_tree::declarations::{Owner, VarId};
use scanbound_ir::{AreaId, PowerUp, Region, RegionSet};

impl Lower<'_> {
    /// The known state after power-up, and the initial values of variables. `begins_with_more`: the tool may execute
    /// code before the first scan that is not in the tree; then no initial values are known.
    pub(super) fn power_up(&mut self, begins_with_more: bool) -> (PowerUp, Vec<FirstValue>) {
        let mut known = PowerUp {
            declares_latched: true,
            cleared: vec![Region::Area(AreaId(2)), Region::Area(AreaId(3))],
            ..PowerUp::default()
        };
        let mut values = Vec::new();
        let tree = self.tree;
        let instances = self.instances.clone();
        let retained = self.retained_regions();
        let is_retained: Vec<bool> =
            (0..instances.len()).map(|at| self.is_retained_in(at, &retained)).collect();
        let own = instances.iter().zip(&is_retained).filter(|(_, is_retained)| **is_retained);
        known.latched.extend(own.flat_map(|(one, _)| one.spot.tag.regions()));
        let charts = self.charts.memories.iter().filter(|((of, _), _)| is_retained[*of]);
        known.latched.extend(charts.flat_map(|(_, memory)| memory.tag.regions()));
        for Instance { unit, spot } in &instances {
            // Initial values that a declaration gives to the parts of an instance are not modelled. If the project has
            // any, no function block's variables are known to begin with 0.
            if tree.gives_parts && tree.unit(*unit).kind != PouKind::Program {
                continue;
            }
            for id in tree.lineage(*unit).into_iter().flat_map(|one| &tree.unit(one).variables) {
                if tree.unit(*unit).result == Some(*id) {
                    continue;
                }
                let Some(part) = self.member(spot, *unit, *id) else { continue };
                // What is outside of a program gives values to its inputs.
                let is_input = tree.variable(*id).section == Section::Input;
                if is_input && tree.unit(*unit).kind == PouKind::Program {
                    self.program().external.extend(part.tag.regions());
                }
                values.extend(self.starts(&mut known, *id, &part));
            }
        }
        for id in tree.globals.iter().flat_map(|list| &list.variables) {
            if let Some(spot) = self.memory.globals.get(id).cloned() {
                values.extend(self.starts(&mut known, *id, &spot));
            }
        }
        // Parts of a retained instance, structure or array are retained too.
        let own = known.cleared.iter().filter(|own| !matches!(own, Region::Area(_)));
        let own: Vec<Region> = own.filter(|own| retained.overlaps(**own)).copied().collect();
        known.latched.extend(own);
        for (id, spot) in &self.memory.addresses {
            if tree.address(*id).text.starts_with("%I") {
                known.inputs.extend(spot.tag.regions());
            }
        }
        // Code called before the first scan may leave other values in variables.
        if begins_with_more || tree.begins_before {
            known.cleared.retain(|own| matches!(own, Region::Area(_)));
            values.clear();
        }
        (known, values)
    }

    /// Records whether a variable is an input or retained. Returns its initial value, unless it is an input or a
    /// constant.
    fn starts(&self, known: &mut PowerUp, id: VarId, spot: &Spot) -> Vec<FirstValue> {
        let one = self.tree.variable(id);
        if one.at.as_ref().is_some_and(|at| at.starts_with("%I")) {
            known.inputs.extend(spot.tag.regions());
            return Vec::new();
        }
        if one.retain {
            known.latched.extend(spot.tag.regions());
        }
        if one.is_given() {
            return Vec::new();
        }
        let mut values = Vec::new();
        self.first_values(&one.begins, spot, &mut values);
        let zeros = values.extract_if(.., |one| one.first == First::Zero);
        known.cleared.extend(zeros.flat_map(|one| one.regions));
        values.retain(|one| one.first != First::Unknown);
        values
    }

    /// All local and global constants without an address, by name, with their values.
    pub(super) fn given_constants(&mut self) -> Vec<(String, Vec<FirstValue>)> {
        let tree = self.tree;
        let mut all = Vec::new();
        for Instance { unit, spot } in self.instances.clone() {
            let is_handed = tree.gives_parts && tree.unit(unit).kind != PouKind::Program;
            for id in tree.lineage(unit).into_iter().flat_map(|one| &tree.unit(one).variables) {
                if let Some(part) = self.member(&spot, unit, *id) {
                    all.push((*id, part, is_handed));
                }
            }
        }
        for id in tree.globals.iter().flat_map(|list| &list.variables) {
            all.extend(self.memory.globals.get(id).map(|spot| (*id, spot.clone(), false)));
        }
        let mut found = Vec::new();
        for (id, spot, is_handed) in all {
            let one = tree.variable(id);
            if !one.is_given() {
                continue;
            }
            let mut values = Vec::new();
            self.first_values(&one.begins, &spot, &mut values);
            if is_handed {
                values.iter_mut().for_each(|one| one.first = First::Unknown);
            }
            found.push((spot.name, values));
        }
        found
    }

    /// Whether an instance keeps its values without power: it, or a variable that contains it, is declared RETAIN.
    pub(super) fn is_retained(&self, instance: usize) -> bool {
        self.is_retained_in(instance, &self.retained_regions())
    }

    fn is_retained_in(&self, instance: usize, retained: &RegionSet) -> bool {
        let Instance { unit, spot } = &self.instances[instance];
        self.tree.unit(*unit).retain
            || spot.tag.regions().into_iter().all(|own| retained.contains(own))
    }

    /// The memory that is declared RETAIN: instances of programs, parts of instances, and global variables.
    fn retained_regions(&self) -> RegionSet {
        let tree = self.tree;
        let mut found = Vec::new();
        for Instance { unit, spot } in &self.instances {
            if tree.unit(*unit).retain {
                found.extend(spot.tag.regions());
            }
            for (at, id) in tree.members(*unit).into_iter().enumerate() {
                if tree.variable(id).retain {
                    found.extend(
                        spot.tag.part_at(at).map(|part| part.regions()).unwrap_or_default(),
                    );
                }
            }
        }
        for (id, spot) in &self.memory.globals {
            if tree.variable(*id).retain && matches!(tree.variable(*id).owner, Owner::Global(_)) {
                found.extend(spot.tag.regions());
            }
        }
        found.into_iter().collect()
    }
}
