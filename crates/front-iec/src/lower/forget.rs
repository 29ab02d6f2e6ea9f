//! Resets the charts of instances that are initialised at every call.

use super::Lower;
use super::spots::Spot;
use crate::assembler::memory::set;
use crate::assembler::value::constant;
use scanbound_base::code::Code as FaultCode;
use scanbound_iec::fault::Fault;
use scanbound_iec_tree::charts::Chart;
use scanbound_iec_tree::declarations::{Code, RoutineId, UnitId};
use scanbound_iec_tree::tree::Step;
use scanbound_iec_tree::types::Type as Typed;
use scanbound_ir::{AreaKind, Logic, Region, WordTarget, Write};

/// The most elements of an array of instances with charts that are reset.
const MOST: i64 = 4096;

impl<'t> Lower<'t> {
    /// The routines that are charts, of a unit and of the units that it extends.
    pub(super) fn charts_of(&self, unit: UnitId) -> Vec<(RoutineId, &'t Chart)> {
        let tree = self.tree;
        let units: Vec<_> = tree.lineage(unit).into_iter().map(|one| tree.unit(one)).collect();
        let actions = units.iter().flat_map(|unit| &unit.actions);
        let methods = units.iter().flat_map(|unit| &unit.methods);
        let all = units.iter().map(|unit| &unit.body).chain(actions).chain(methods).copied();
        let chart = |id: RoutineId| match &tree.routine(id).code {
            Code::Chart(chart) => Some((id, &**chart)),
            _ => None,
        };
        all.filter_map(chart).collect()
    }

    /// Clears the state of all charts in a variable, as before their first scan. A fault for an array that is too large
    /// or has several dimensions.
    pub(super) fn forget(&mut self, spot: &Spot, line: u32) -> Result<(), Fault> {
        if !self.has_charts(spot.ty) {
            return Ok(());
        }
        let tree = self.tree;
        let mut parts = Vec::new();
        match tree.types.get(spot.ty) {
            Typed::Block(unit) => {
                self.forget_own(spot, *unit);
                let members = tree.members(*unit).into_iter();
                parts.extend(members.filter_map(|id| self.member(spot, *unit, id)));
            }
            Typed::Struct(id) => {
                let numbers = 0..tree.types.parts(*id).len();
                parts.extend(numbers.filter_map(|at| self.stepped(spot, None, &Step::Part(at))));
            }
            Typed::Array(dimensions, of) => {
                let refused = || {
                    let told = format!(
                        "{} begins anew with every call, and has too many instances with charts to model their state",
                        spot.name
                    );
                    let help = "declare the instance in the VAR of a function block or a program";
                    Fault::new(line, told).code(FaultCode::NotModelled).help(help)
                };
                let [(low, high)] = dimensions[..] else { return Err(refused()) };
                if high - low >= MOST {
                    return Err(refused());
                }
                for number in low..=high {
                    let tag = spot.tag.element(number).ok_or_else(refused)?;
                    parts.push(Spot { name: format!("{}[{number}]", spot.name), tag, ty: *of });
                }
            }
            _ => {}
        }
        parts.iter().try_for_each(|part| self.forget(part, line))
    }

    /// Clears the state of the charts of one instance.
    fn forget_own(&mut self, spot: &Spot, unit: UnitId) {
        let instance = self.instance(spot, unit);
        for (id, _) in self.charts_of(unit) {
            let Some(memory) = self.chart_memory(instance, id) else { continue };
            let mut writes = Vec::new();
            for region in memory.tag.regions() {
                let Region::Range { first, count } = region else { continue };
                let is_bit = self.program().areas[usize::from(first.area.0)].kind == AreaKind::Bit;
                writes.extend((0..count).map(|at| match is_bit {
                    true => set(first.plus(at), Logic::Const(false)),
                    false => Write::Words(vec![WordTarget::Cell(first.plus(at))], constant(0, 1)),
                }));
            }
            self.write(writes);
        }
    }
}
