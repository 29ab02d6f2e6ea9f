//! What is known of the state after power-up, and what keeps its values when the power fails.

use super::super::first_values::{FirstValue, first_value};
use super::super::types::{Kind, Ty};
use super::super::value::{real, within};
use super::Lower;
use super::places::{Instance, Spot};
use scanbound_iec::PouKind;
use scanbound_iec_tree::blocks::{Pin, StandardBlock};
use scanbound_iec_tree::declarations::{First, Owner, VarId};
use scanbound_iec_tree::tree::{Expr, ExprKind};
use scanbound_iec_tree::types::Type as Typed;
use scanbound_ir::{AreaId, PowerUp, Region, flow};

impl Lower<'_> {
    /// What is known of the state after power-up. `gives_parts`: whether a declaration gives an instance values for its parts.
    pub(super) fn power_up(
        &mut self,
        gives_parts: bool,
        begins_with_more: bool,
    ) -> (PowerUp, Vec<FirstValue>) {
        let mut known = PowerUp {
            declares_latched: true,
            cleared: vec![Region::Area(AreaId(2)), Region::Area(AreaId(3))],
            ..PowerUp::default()
        };
        let mut values = Vec::new();
        let tree = self.tree;
        let instances = self.instances.clone();
        for at in 0..instances.len() {
            if self.is_retained(at) {
                known.latched.extend(instances[at].spot.tag.regions());
            }
        }
        for Instance { unit, spot } in &instances {
            // What an instance's declaration gives to its parts is not followed: then no instance is known to begin with 0.
            if gives_parts && tree.unit(*unit).kind != PouKind::Program {
                continue;
            }
            for id in tree.lineage(*unit).into_iter().flat_map(|one| &tree.unit(one).variables) {
                if tree.unit(*unit).result == Some(*id) {
                    continue;
                }
                if let Some(part) = self.member(spot, *unit, *id) {
                    values.extend(self.starts(&mut known, *id, &part));
                }
            }
        }
        for id in tree.globals.iter().flat_map(|list| &list.variables) {
            if let Some(spot) = self.memory.globals.get(id).cloned() {
                values.extend(self.starts(&mut known, *id, &spot));
            }
        }
        self.latch_within(&mut known);
        for (id, spot) in &self.memory.addresses {
            if tree.address(*id).text.starts_with("%I") {
                known.inputs.extend(spot.tag.regions());
            }
        }
        // What is called before the first scan may leave other values in variables.
        if begins_with_more {
            known.cleared.retain(|own| matches!(own, Region::Area(_)));
            values.clear();
        }
        (known, values)
    }

    /// Takes note of the value with which a variable begins; that value, if it is another one than 0.
    fn starts(&self, known: &mut PowerUp, id: VarId, spot: &Spot) -> Option<FirstValue> {
        let one = self.tree.variable(id);
        if one.at.as_ref().is_some_and(|at| at.starts_with("%I")) {
            known.inputs.extend(spot.tag.regions());
            return None;
        }
        let regions = spot.tag.regions();
        if one.retain {
            known.latched.extend(regions.iter().copied());
        }
        if let Typed::Standard(block) = self.tree.types.get(spot.ty) {
            if one.initial.is_some() {
                return None;
            }
            // Whether a falling edge is seen in the first call, controllers differ.
            let cleared = match block {
                StandardBlock::FTrig => {
                    let pin = |pin| spot.tag.part_at(block.position(pin)?);
                    let parts = [Pin::Clk, Pin::Q].into_iter().filter_map(pin);
                    parts.flat_map(|part| part.regions()).collect()
                }
                _ => regions,
            };
            known.cleared.extend(cleared);
            return None;
        }
        let words = self.first_words(id, spot)?;
        match words {
            None => {
                known.cleared.extend(regions);
                None
            }
            Some(words) => Some(first_value(*regions.first()?, spot.tag.cell()?, words)),
        }
    }

    /// The words with which a variable begins, if they are known: nothing for 0, and none for a bit that is on.
    fn first_words(&self, id: VarId, spot: &Spot) -> Option<Option<Option<scanbound_ir::Number>>> {
        let one = self.tree.variable(id);
        if one.first == First::Unknown {
            return None;
        }
        spot.tag.cell()?;
        let initial = one.initial.as_ref();
        let first = match one.first {
            First::Number(number) => number,
            _ => 0,
        };
        match self.simple(spot) {
            Ty::Bit => {
                let on = match initial.map(|one| &one.kind) {
                    None => false,
                    Some(ExprKind::Bool(on)) if is_literal(initial) => *on,
                    Some(_) => one.value? != 0,
                };
                Some(on.then_some(None))
            }
            Ty::Number(kind) => {
                let number = match (kind, initial) {
                    (Kind::Whole { bits: ..=32, .. }, None) => within(kind, first),
                    (Kind::Real | Kind::Time | Kind::Whole { .. }, None) => within(kind, 0),
                    (Kind::Whole { bits: ..=32, .. }, Some(_)) => within(kind, one.value?),
                    (Kind::Real, Some(initial)) => match &initial.kind {
                        ExprKind::Real(text) => real(text)?,
                        ExprKind::Whole(value) | ExprKind::Typed(value) => {
                            real(&value.to_string())?
                        }
                        _ => return None,
                    },
                    (Kind::Time, Some(initial)) => match &initial.kind {
                        ExprKind::Time(time) => {
                            let ms = i32::try_from(time / 1_000_000).ok()?;
                            (time % 1_000_000 == 0).then(|| within(kind, ms.into()))?
                        }
                        _ => return None,
                    },
                    _ => return None,
                };
                Some((number != within(kind, 0)).then_some(Some(number)))
            }
            _ => None,
        }
    }

    /// Whether an instance keeps what it holds when the power fails: it, or one that it stands in, is declared so.
    pub(super) fn is_retained(&self, instance: usize) -> bool {
        let tree = self.tree;
        let own = self.instances[instance].spot.tag.regions();
        if tree.unit(self.instances[instance].unit).retain {
            return true;
        }
        let kept = super::super::decode::merged(self.retained_regions());
        !own.is_empty() && own.iter().all(|own| kept.iter().any(|kept| holds(*kept, *own)))
    }

    /// What is declared to be kept when the power fails: the instances of programs, global variables, parts of instances.
    fn retained_regions(&self) -> Vec<Region> {
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
        found
    }

    /// What stands in an instance, a structure or an array that survives a loss of power does so, too.
    fn latch_within(&self, known: &mut PowerUp) {
        let regions = super::super::decode::merged(self.retained_regions());
        let own = known.cleared.iter().filter(|own| !matches!(own, Region::Area(_)));
        let own = own.filter(|own| regions.iter().any(|one| flow::overlap(**own, *one)));
        known.latched.extend(own.copied().collect::<Vec<_>>());
    }
}

/// Whether a region has all cells of another one.
fn holds(kept: Region, own: Region) -> bool {
    match (kept, own) {
        (Region::Range { first, count }, Region::Range { first: inner, count: many }) => {
            first.area == inner.area
                && first.index <= inner.index
                && inner.index + many <= first.index + count
        }
        _ => false,
    }
}

fn is_literal(one: Option<&Expr>) -> bool {
    one.is_some_and(|one| matches!(one.kind, ExprKind::Bool(_)))
}
