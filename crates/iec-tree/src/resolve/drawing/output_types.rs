//! The types of outputs that are read before they are computed, so that variables can be declared for them.

use super::super::resolver::Resolver;
use super::block::first_output;
use super::state::{Drawer, Output};
use crate::standard::Function;
use crate::types::{Type, TypeId};
use scanbound_iec::ast;
use scanbound_iec::drawing::{Block, ElementId, ElementKind, Given};
use std::collections::BTreeSet;

/// Inputs of functions that do not determine the result type.
const OTHERS: &[&str] = &["EN", "G", "K", "N"];

impl Resolver<'_> {
    fn is_known(&self, ty: TypeId) -> bool {
        !matches!(
            self.tree.types.get(ty),
            Type::Unknown | Type::Untyped | Type::Nothing | Type::Faulty(_)
        )
    }
}

impl<'d> Drawer<'_, '_, 'd> {
    /// The type of an element's output; `None` if it is not known. `seen` guards against feedback loops.
    pub(super) fn output_type(
        &mut self,
        id: ElementId,
        output: &'d str,
        seen: &mut BTreeSet<Output<'d>>,
    ) -> Option<TypeId> {
        if output.eq_ignore_ascii_case("ENO") {
            return Some(self.resolver.bool());
        }
        if !seen.insert((id, output)) {
            return None;
        }
        let one = self.element(id);
        match &one.kind {
            ElementKind::Contact
            | ElementKind::Coil
            | ElementKind::LeftRail
            | ElementKind::RightRail => Some(self.resolver.bool()),
            ElementKind::In | ElementKind::InOut => self.type_of(one.operand.as_ref().ok()?),
            ElementKind::Out | ElementKind::Connector => {
                let mut from = one.inputs.iter();
                from.find_map(|from| self.output_type(from.from, &from.output, seen))
            }
            ElementKind::Continuation(from) => self.output_type(*from, "", seen),
            ElementKind::Block(block) => match &block.instance {
                Some(instance) => {
                    let named = if output.is_empty() { first_output(block) } else { output };
                    let path = instance.as_ref().ok()?.clone().with(named);
                    self.type_of(&ast::Expr::Variable(path))
                }
                None => {
                    let own = self.function_type(block, output, seen);
                    own.or_else(|| self.target_type(id, output))
                }
            },
            _ => None,
        }
    }

    fn type_of(&mut self, written: &ast::Expr) -> Option<TypeId> {
        let ty = self.resolver.expression(self.sheet.scope, written, 0).ty;
        self.resolver.is_known(ty).then_some(ty)
    }

    /// The type of a variable to which an output is connected.
    fn target_type(&mut self, id: ElementId, output: &str) -> Option<TypeId> {
        let sheet = self.sheet;
        let mut ends = sheet.drawing.elements.iter().filter(|one| one.kind == ElementKind::Out);
        ends.find_map(|end| {
            let mut from = end.inputs.iter();
            from.find(|one| {
                one.from == id && (one.output.is_empty() || one.output.eq_ignore_ascii_case(output))
            })?;
            self.type_of(end.operand.as_ref().ok()?)
        })
    }

    /// The result type of a function: the declared one, or derived from those of its inputs whose types are known.
    fn function_type(
        &mut self,
        block: &'d Block,
        output: &str,
        seen: &mut BTreeSet<Output<'d>>,
    ) -> Option<TypeId> {
        let name = block.function.as_ref().ok()?.as_name()?;
        if let Some(unit) = self.resolver.index.function(name) {
            let own = match output.is_empty() || output == first_output(block) {
                true => self.resolver.tree.unit(unit).result,
                false => self.resolver.index.member(unit, output),
            };
            let ty = self.resolver.tree.variable(own?).ty;
            return self.resolver.is_known(ty).then_some(ty);
        }
        let function = Function::named(name)?;
        let mut found: Option<TypeId> = None;
        for pin in &block.inputs {
            let is_other = OTHERS.iter().any(|other| pin.name.eq_ignore_ascii_case(other));
            let Given::Wired(from) = &pin.given else { continue };
            for one in from.iter().filter(|_| !is_other && !pin.is_in_out) {
                let Some(of) = self.output_type(one.from, &one.output, seen) else { continue };
                if found.is_some_and(|known| known != of) && !function.gives_one() {
                    return None;
                }
                found = Some(of);
            }
        }
        let types = &mut self.resolver.tree.types;
        let of = found.unwrap_or_else(|| types.id(Type::Unknown));
        let ty = function.result(types, &[of, of, of]);
        self.resolver.is_known(ty).then_some(ty)
    }
}
