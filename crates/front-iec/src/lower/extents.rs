//! The sizes of whole variables, and the charges for copying and initialising them, by number of elements.

use super::Lower;
use super::spots::{Found, Spot};
use crate::assembler::Assembler;
use crate::assembler::charges::{characters, counted};
use crate::assembler::memory::layout;
use crate::assembler::types::Extent;
use crate::assembler::whole::copy_cells;
use scanbound_base::code::Code as FaultCode;
use scanbound_front::builder::always;
use scanbound_iec::Section;
use scanbound_iec::fault::Fault;
use scanbound_iec_tree::declarations::VarId;
use scanbound_iec_tree::standard::{Function, Simple};
use scanbound_iec_tree::tree::{Expr, ExprKind, Place, Root, Step as PathStep};
use scanbound_iec_tree::types::{CONVERTED_TEXT, Type as Typed, TypeId};
use scanbound_ir::{Step, TimingKey, Write};

impl Lower<'_> {
    /// The number of elementary variables in a type. The characters of a text, and the state of timers and charts,
    /// count too.
    pub(super) fn elements(&self, ty: TypeId) -> u64 {
        let tree = self.tree;
        let all = |mut parts: Box<dyn Iterator<Item = TypeId> + '_>| {
            let mut sum = 0_u64;
            for of in &mut parts {
                sum = sum.saturating_add(self.elements(of));
            }
            sum
        };
        match tree.types.get(ty) {
            Typed::Text(characters) => u64::from(*characters).max(1),
            Typed::Array(dimensions, of) => {
                let counts = dimensions.iter().map(|(low, high)| high.abs_diff(*low) + 1);
                counts.fold(self.elements(*of), u64::saturating_mul)
            }
            Typed::Struct(id) => all(Box::new(tree.types.parts(*id).iter().map(|part| part.1))),
            Typed::Standard(block) => u64::try_from(block.pins().count()).unwrap_or(u64::MAX),
            Typed::Block(unit) => {
                let members = tree.members(*unit).into_iter();
                let charts = self.charts_of(*unit).into_iter();
                let charts = charts.filter_map(|(_, chart)| layout(&chart.written).size());
                let remembered = charts.map(|[bits, words]| u64::from(bits) + u64::from(words));
                let parts = all(Box::new(members.map(|one| tree.variable(one).ty)));
                remembered.fold(parts, u64::saturating_add)
            }
            _ => 1,
        }
    }

    /// The charge for writing a whole value of this type. None if one store writes it. `most`: the largest number of
    /// characters that the value has, if known.
    fn stored_whole(&self, ty: TypeId, most: Option<u64>) -> Option<TimingKey> {
        match self.tree.types.get(ty) {
            Typed::Text(_) => {
                let characters = self.elements(ty);
                Some(counted("COPY_TEXT", "string", most.unwrap_or(characters).min(characters)))
            }
            Typed::Array(..) | Typed::Struct(_) | Typed::Standard(_) | Typed::Block(_) => {
                Some(counted("COPY", "block", self.elements(ty)))
            }
            _ => None,
        }
    }

    /// The charge of a store: one, or one for each element that is written. `of`: the expression of the value, if
    /// known.
    pub(super) fn store_key(
        &self,
        found: &Found,
        of: Option<&Expr>,
        line: u32,
    ) -> Result<TimingKey, Fault> {
        let one = || Assembler::key(&["ST"], "move");
        let spot = match found {
            Found::Spot(spot) => spot,
            Found::Element(element) => &element.spot,
            Found::WordBit(..) => return Ok(one()),
        };
        if self.has_charts(spot.ty) {
            let told = format!(
                "{} is written as a whole, and contains an instance with a chart, whose state is not copied",
                spot.name
            );
            let help = "copy the needed variables one by one, and call each instance separately";
            return Err(Fault::new(line, told).code(FaultCode::NotModelled).help(help));
        }
        let most = match of.map(|of| &of.unconverted().kind) {
            Some(ExprKind::Text(text)) => Some(characters(text)),
            _ => None,
        };
        Ok(self.stored_whole(spot.ty, most).unwrap_or_else(one))
    }

    /// The charge for initialising a variable at a call.
    pub(super) fn begin_key(&self, ty: TypeId) -> TimingKey {
        self.stored_whole(ty, None).unwrap_or_else(|| Assembler::key(&["INIT"], "move"))
    }

    /// Whether a type contains instances with charts, whose state is more than their variables.
    pub(super) fn has_charts(&self, ty: TypeId) -> bool {
        let has =
            |of: &Typed| matches!(of, Typed::Block(unit) if !self.charts_of(*unit).is_empty());
        self.tree.holds(ty, &has)
    }

    /// The size of an operand beyond one elementary value.
    pub(super) fn extent(&self, one: &Expr) -> Extent {
        match &one.kind {
            ExprKind::Text(text) => Extent::Characters(characters(text)),
            ExprKind::Read(place) => match place.root {
                Root::Temporary(id) => self.kept.extents.get(&id).copied().unwrap_or(Extent::One),
                _ if self.is_lent(place) => self.longest_text(one.ty),
                _ => self.extent_as(one.ty),
            },
            ExprKind::Call(_) => self.extent_as(one.ty),
            ExprKind::Convert(inner) => self.extent(inner),
            ExprKind::After(both) => self.extent(&both.1),
            ExprKind::Either(Some(both)) => self.extent(&both.0).and(self.extent(&both.1)),
            ExprKind::Standard(applied) => match &applied.function {
                Function::Convert { to: Simple::Text, .. } => {
                    Extent::Characters(CONVERTED_TEXT.into())
                }
                function if function.gives_one() => Extent::One,
                _ => {
                    let inputs = applied.inputs.iter().map(|one| self.extent(one));
                    inputs.fold(Extent::One, Extent::and)
                }
            },
            _ => Extent::One,
        }
    }

    /// Whether a place is a variable of the caller or the target of a reference. Controllers differ in whether a text
    /// there may be longer than declared.
    fn is_lent(&self, place: &Place) -> bool {
        let is_in_out = |id: VarId| self.tree.variable(id).section == Section::InOut;
        match (place.steps.last(), place.root) {
            (None, Root::Variable(id)) => is_in_out(id),
            (Some(PathStep::Member(id)), _) => is_in_out(*id),
            (Some(PathStep::Dereference), _) => true,
            _ => false,
        }
    }

    /// The extent of a text of this type that may be any text of the project, or of another type: its own.
    fn longest_text(&self, ty: TypeId) -> Extent {
        let extent = self.extent_as(ty);
        match self.tree.types.get(ty) {
            Typed::Text(_) => {
                extent.larger(Extent::Characters(self.tree.types.longest_text().into()))
            }
            _ => extent,
        }
    }

    fn extent_as(&self, ty: TypeId) -> Extent {
        match self.tree.types.get(ty) {
            Typed::Text(_) => Extent::Characters(self.elements(ty)),
            Typed::Array(..) | Typed::Struct(_) | Typed::Standard(_) | Typed::Block(_) => {
                Extent::Elements(self.elements(ty))
            }
            _ => Extent::One,
        }
    }

    /// Refuses copying an instance to a variable of a base type: the methods and actions of the target's own unit would
    /// be called, not those of the source.
    pub(super) fn are_of_one_type(&self, from: &Found, to: &Found, line: u32) -> Result<(), Fault> {
        let spot = |one: &'_ Found| match one {
            Found::Spot(spot) => Some((spot.ty, spot.name.clone())),
            Found::Element(element) => Some((element.spot.ty, element.spot.name.clone())),
            Found::WordBit(..) => None,
        };
        let (Some((from, _)), Some((to, name))) = (spot(from), spot(to)) else { return Ok(()) };
        if from == to || self.instances_of(to) == 0 {
            return Ok(());
        }
        let told = format!(
            "{name} gets an instance of another type: it is not known which methods are called through it"
        );
        let help =
            "declare the target with the type of the instance, or pass a reference or an interface";
        Err(Fault::new(line, told).code(FaultCode::NotModelled).help(help))
    }

    /// Lowers the copy of a structure, an array or an instance, charged by `key`: cell by cell if both have the same
    /// layout. Otherwise the target may hold anything.
    pub(super) fn copy(&mut self, from: &Found, to: &Found, key: TimingKey) {
        self.cost(&["LD"], "contact");
        let spots: [Option<&Spot>; 2] = [from, to].map(|one| match one {
            Found::Spot(spot) => Some(spot),
            _ => None,
        });
        if let [Some(from), Some(to)] = spots
            && let Some(writes) = copy_cells(&from.tag, &to.tag)
        {
            self.add_always(key, writes);
            return;
        }
        let regions = match to {
            Found::Spot(to) => to.tag.regions(),
            Found::Element(element) => element.whole.tag.regions(),
            Found::WordBit(..) => Vec::new(),
        };
        let choice = self.builder.choice();
        let effects = regions.into_iter().map(|region| always(Write::Havoc(region, choice)));
        let at = self.assembler().builder.add(Some(key), effects.collect(), Step::Nothing);
        let why = "a whole structure or array that is not modelled: it may hold any value";
        self.program().approximate(at, why);
    }
}
