//! How large variables are as wholes, and what it is charged to copy, compare or begin them: by their elements.

use super::assembler::Assembler;
use super::emit::Emit;
use super::memory;
use super::references::{Walk, Way};
use super::resolve::{Context, Found};
use super::types::{Extent, Kind, TEXT, Ty, lineage};
use scanbound_base::code::Code;
use scanbound_iec::ast::{Expr, Literal, Path};
use scanbound_iec::fault::Fault;
use scanbound_iec::{Body, Pou, getter, same};
use scanbound_ir::{TimingKey, Units};

/// The price of a function of texts holds so many characters.
const TEXT_HELD: u64 = 80;

impl Emit<'_> {
    /// How many elementary variables a type has: a text's characters, what timers and charts remember among them.
    pub(super) fn elements(&self, ty: &Ty) -> u64 {
        let all = |parts: &[(String, Ty)]| {
            parts.iter().map(|(_, of)| self.elements(of)).fold(0, u64::saturating_add)
        };
        match ty {
            Ty::Bit | Ty::Number(_) | Ty::Reference(..) => 1,
            Ty::Text(characters) => u64::from(*characters).max(1),
            Ty::Array { dimensions, of } => {
                let counts = dimensions.iter().map(|(low, high)| high.abs_diff(*low) + 1);
                counts.fold(self.elements(of), u64::saturating_mul)
            }
            Ty::Parts(parts) | Ty::Standard(_, parts) => all(parts),
            Ty::Block(pou, parts) => {
                let bodies = lineage(self.project, *pou).into_iter().flat_map(bodies);
                let charts = bodies.filter_map(|body| match body {
                    Body::Chart(chart) => memory::layout(chart).size(),
                    _ => None,
                });
                let remembered = charts.map(|[bits, words]| u64::from(bits) + u64::from(words));
                remembered.fold(all(parts), u64::saturating_add)
            }
        }
    }

    /// What a whole of this type is charged to be written, and nothing for what one store writes. `most`: the value has no
    /// more characters.
    fn stored_whole(&self, ty: &Ty, most: Option<u64>) -> Option<TimingKey> {
        match ty {
            Ty::Bit | Ty::Number(_) | Ty::Reference(..) => None,
            Ty::Text(_) => {
                let characters = self.elements(ty);
                Some(counted("COPY_TEXT", "string", most.unwrap_or(characters).min(characters)))
            }
            _ => Some(counted("COPY", "block", self.elements(ty))),
        }
    }

    /// What a store is charged: one, or as many as what is written has elements. `of`: the expression whose value it is.
    pub(super) fn store_key(
        &self,
        found: &Found,
        of: Option<&Expr>,
        line: u32,
    ) -> Result<TimingKey, Fault> {
        let one = || Assembler::key(&["ST"], "move");
        let place = match found {
            Found::Place(place) => place,
            Found::Element(element) => &element.place,
            _ => return Ok(one()),
        };
        self.has_no_chart(&place.name, &place.ty, line)?;
        let most = match of {
            Some(Expr::Literal(Literal::Text(text))) => Some(characters(text)),
            _ => None,
        };
        Ok(self.stored_whole(&place.ty, most).unwrap_or_else(one))
    }

    /// What it is charged that a variable begins anew.
    pub(super) fn begin_key(&self, ty: &Ty) -> TimingKey {
        self.stored_whole(ty, None).unwrap_or_else(|| Assembler::key(&["INIT"], "move"))
    }

    /// Refuses to copy what remembers more than its variables.
    pub(super) fn has_no_chart(&self, name: &str, ty: &Ty, line: u32) -> Result<(), Fault> {
        if !self.has_charts(ty) {
            return Ok(());
        }
        let told = format!(
            "{name} is written as a whole, and has an instance with a chart, whose state is not copied"
        );
        let help =
            "copy the variables that are needed one by one, and call each instance for itself";
        Err(Fault::new(line, told).code(Code::NotModelled).help(help))
    }

    /// Whether a type holds instances with charts, which remember more than their variables.
    pub(super) fn has_charts(&self, ty: &Ty) -> bool {
        match ty {
            Ty::Array { of, .. } => self.has_charts(of),
            Ty::Parts(parts) => parts.iter().any(|(_, of)| self.has_charts(of)),
            Ty::Block(pou, parts) => {
                let own = |pou: &Pou| bodies(pou).any(|body| matches!(body, Body::Chart(_)));
                lineage(self.project, *pou).into_iter().any(own)
                    || parts.iter().any(|(_, of)| self.has_charts(of))
            }
            _ => false,
        }
    }

    /// How much an operand moves as a whole.
    pub(super) fn extent(&mut self, at: &Context, expr: &Expr) -> Extent {
        match expr {
            Expr::Literal(Literal::Text(text)) => Extent::Characters(characters(text)),
            Expr::Variable(path) => self.extent_of(at, path),
            Expr::Call(path, given) => {
                let last =
                    path.split_last().map_or(path.first.clone(), |(_, name)| name.to_owned());
                if let Some(own) = self.extent_given(&|one| same(&one.name, &last)) {
                    return own;
                }
                let upper = last.to_ascii_uppercase();
                if upper.ends_with("TO_STRING") || upper.ends_with("TO_WSTRING") {
                    return Extent::Characters(u64::from(TEXT));
                }
                if GIVES_ONE.contains(&upper.as_str()) {
                    return Extent::One;
                }
                let inputs = given.iter().filter(|one| !one.is_output);
                let all: Vec<_> = inputs.map(|one| self.extent(at, &one.value)).collect();
                all.into_iter().fold(Extent::One, Extent::and)
            }
            _ => Extent::One,
        }
    }

    /// The most that units and methods of some name give: which of them is meant may be told by a reference.
    fn extent_given(&mut self, is: &dyn Fn(&Pou) -> bool) -> Option<Extent> {
        let project = self.project;
        let all = project.pous.iter().enumerate().flat_map(|(unit, pou)| {
            let methods = pou.methods.iter().map(move |method| (unit, Some(method), method));
            std::iter::once((unit, None, pou)).chain(methods)
        });
        let given = all.filter(|(.., one)| is(one)).map(|(unit, method, one)| match &one.result {
            Some(of) => {
                let ty = self.types.within(unit, method, |types| types.resolve(of, one.line));
                ty.map_or(Extent::One, |ty| self.extent_as(&ty))
            }
            None => Extent::One,
        });
        given.collect::<Vec<_>>().into_iter().reduce(Extent::larger)
    }

    /// Takes note of how large a value is that is kept and not followed.
    pub(super) fn note_extent(&mut self, at: &Context, name: &str, of: &Expr) {
        let own = self.extent(at, of);
        let known = self.kept_extents.get(name).copied().unwrap_or(Extent::One);
        self.kept_extents.insert(name.to_owned(), known.larger(own));
    }

    fn extent_of(&mut self, at: &Context, path: &Path) -> Extent {
        if let Some(known) = self.kept_extents.get(&path.first) {
            return *known;
        }
        match self.walk(at, path, true) {
            Walk::Type(ty) => self.extent_as(&ty),
            Walk::Way(Way::Referred(way)) => {
                let can = self.candidates(way.kind, &way.of);
                let Some(&first) = can.first() else { return Extent::One };
                let place = self.target_at(first);
                let found = self.with_name(place, "", |emit, first| {
                    Ok(emit.extent_of(at, &Path { first, rest: way.rest }))
                });
                found.unwrap_or(Extent::One)
            }
            Walk::Way(Way::Property(own)) => {
                self.extent_given(&|one| same(&one.name, &getter(&own.name))).unwrap_or(Extent::One)
            }
            Walk::Unknown => Extent::One,
        }
    }

    fn extent_as(&self, ty: &Ty) -> Extent {
        match ty {
            Ty::Bit | Ty::Number(_) | Ty::Reference(..) => Extent::One,
            Ty::Text(_) => Extent::Characters(self.elements(ty)),
            _ => Extent::Elements(self.elements(ty)),
        }
    }

    /// Charges what a function of the standard is given by its size, which its own price does not hold.
    pub(super) fn charge_inputs(&mut self, at: &Context, name: &str, inputs: &[&Expr]) {
        if name == "SIZEOF" {
            return;
        }
        let all: Vec<_> = inputs.iter().map(|one| self.extent(at, one)).collect();
        self.charge_whole(all.into_iter().fold(Extent::One, Extent::and));
    }
}

impl Assembler {
    /// Charges the size of what is moved, which no price of its own holds.
    pub(super) fn charge_whole(&mut self, extent: Extent) {
        match extent {
            Extent::One => {}
            Extent::Elements(count) => self.charge("COPY", "block", count),
            Extent::Characters(count) => self.charge_beyond(count),
        }
    }

    /// Charges that wholes are compared, element by element: no further than the shorter text.
    pub(super) fn charge_comparison(&mut self, one: Extent, two: Extent) {
        match (one, two) {
            (Extent::Elements(one), Extent::Elements(two)) => {
                self.charge("COMPARE", "block", one.max(two))
            }
            (Extent::Elements(count), _) | (_, Extent::Elements(count)) => {
                self.charge("COMPARE", "block", count);
            }
            (Extent::Characters(one), Extent::Characters(two)) => {
                self.charge_beyond(one.min(two));
            }
            (Extent::Characters(count), _) | (_, Extent::Characters(count)) => {
                self.charge_beyond(count);
            }
            (Extent::One, Extent::One) => {}
        }
    }

    /// Charges the characters that the price of a function of texts does not hold.
    fn charge_beyond(&mut self, characters: u64) {
        if characters > TEXT_HELD {
            self.charge("COPY_TEXT", "string", characters - TEXT_HELD);
        }
    }

    /// Charges that a number becomes a real or a long real, or one of these something else, as the conversions that are written
    /// are. A whole number is loaded at whichever length.
    pub(super) fn charge_conversion(&mut self, from: Kind, to: Kind) {
        if from != to && (is_real(from) || is_real(to)) {
            let name = format!("{}_TO_{}", name_of(from), name_of(to));
            self.cost(&[&name, "CONVERT"], "conversion");
        }
    }

    /// Charges that a value of which even the type is not known may become a real or a long real.
    pub(super) fn charge_any_conversion(&mut self, to: Kind) {
        if is_real(to) {
            self.cost(&[&format!("ANY_TO_{}", name_of(to)), "CONVERT"], "conversion");
        }
    }

    fn charge(&mut self, name: &str, class: &'static str, units: u64) {
        let key = counted(name, class, units);
        self.builder.add(Some(key), Vec::new(), scanbound_ir::Step::Nothing);
    }
}

/// Functions of the standard that give one elementary value, whatever they are given.
const GIVES_ONE: &[&str] = &[
    "LEN",
    "FIND",
    "SIZEOF",
    "LOWER_BOUND",
    "UPPER_BOUND",
    "ADR",
    "EQ",
    "NE",
    "LT",
    "LE",
    "GT",
    "GE",
];

pub(super) fn counted(name: &str, class: &'static str, units: u64) -> TimingKey {
    TimingKey { units: Units::Exactly(units), ..Assembler::key(&[name], class) }
}

fn is_real(kind: Kind) -> bool {
    matches!(kind, Kind::Real | Kind::Opaque(_))
}

fn name_of(kind: Kind) -> &'static str {
    match kind {
        Kind::Whole { bits: ..=8, signed: true } => "SINT",
        Kind::Whole { bits: ..=8, signed: false } => "USINT",
        Kind::Whole { bits: ..=16, signed: true } => "INT",
        Kind::Whole { bits: ..=16, signed: false } => "UINT",
        Kind::Whole { bits: ..=32, signed: true } => "DINT",
        Kind::Whole { bits: ..=32, signed: false } => "UDINT",
        Kind::Whole { signed: true, .. } => "LINT",
        Kind::Whole { signed: false, .. } => "ULINT",
        Kind::Real => "REAL",
        Kind::Time => "TIME",
        Kind::Opaque(_) => "LREAL",
    }
}

/// The characters of a constant, and what ends it.
pub(super) fn characters(text: &str) -> u64 {
    u64::try_from(text.chars().count()).unwrap_or(u64::MAX).saturating_add(1)
}

/// The bodies whose charts are an instance's.
pub(super) fn bodies(pou: &Pou) -> impl Iterator<Item = &Body> {
    let inner = pou.actions.iter().map(|action| &action.body);
    [&pou.body].into_iter().chain(inner).chain(pou.methods.iter().map(|one| &one.body))
}
