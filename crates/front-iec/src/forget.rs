//! Instances that begin anew with every call: what their charts remember begins anew with them.

use super::emit::{Emit, Place, What};
use super::memory::set;
use super::types::{Ty, lineage};
use super::value::constant;
use scanbound_base::code::Code;
use scanbound_iec::fault::Fault;
use scanbound_iec::same;
use scanbound_ir::{AreaKind, Logic, Region, WordTarget, Write};

/// Larger arrays of charts are not begun anew.
const MOST: i64 = 4096;

impl Emit<'_> {
    /// Lets the charts in a variable remember nothing, as before their first scan.
    pub(super) fn forget(&mut self, place: &Place, line: u32) -> Result<(), Fault> {
        if !self.has_charts(&place.ty) {
            return Ok(());
        }
        match &place.ty {
            Ty::Block(pou, parts) => {
                self.forget_own(place, *pou);
                self.forget_parts(place, parts, line)
            }
            Ty::Parts(parts) => self.forget_parts(place, parts, line),
            Ty::Array { dimensions, of } => {
                let [(low, high)] = dimensions[..] else { return Err(refused(place, line)) };
                if high - low >= MOST {
                    return Err(refused(place, line));
                }
                for index in low..=high {
                    let tag = place.tag.element(index).ok_or_else(|| refused(place, line))?;
                    let name = format!("{}[{index}]", place.name);
                    self.forget(&Place { name, tag, ty: (**of).clone() }, line)?;
                }
                Ok(())
            }
            _ => Ok(()),
        }
    }

    fn forget_parts(
        &mut self,
        place: &Place,
        parts: &[(String, Ty)],
        line: u32,
    ) -> Result<(), Fault> {
        for (name, _) in parts {
            if let Some(part) = Self::part(place, name) {
                self.forget(&part, line)?;
            }
        }
        Ok(())
    }

    /// The same of the charts of one instance, whichever unit that it extends has them.
    fn forget_own(&mut self, place: &Place, pou: usize) {
        let all = lineage(self.project, pou);
        let methods: Vec<_> = all.iter().flat_map(|unit| &unit.methods).collect();
        let actions = all.iter().flat_map(|unit| &unit.actions);
        let mut charts: Vec<What> =
            actions.map(|action| What::Action(action.name.to_ascii_uppercase())).collect();
        let names = || methods.iter().map(|method| method.name.to_ascii_uppercase());
        charts.extend(names().map(What::Method));
        for base in &all[1..] {
            let own = self.project.pous.iter().position(|one| same(&one.name, &base.name));
            let Some(own) = own else { continue };
            let inherited = names().chain([String::new()]);
            charts.extend(inherited.map(|name| What::Inherited(own, name)));
        }
        charts.push(What::Body);
        charts.sort();
        charts.dedup();
        let instance = self.instance(place, pou);
        self.begun_anew.insert(instance);
        for what in charts {
            let Some(tag) = self.chart_memory(instance, &what) else { continue };
            let mut writes = Vec::new();
            for region in tag.regions() {
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

fn refused(place: &Place, line: u32) -> Fault {
    let told = format!(
        "{} begins anew with every call, and what the charts in so many instances remember is not followed",
        place.name
    );
    let help = "declare the instance in the VAR of a function block or a program";
    Fault::new(line, told).code(Code::NotModelled).help(help)
}
