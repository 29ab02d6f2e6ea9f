//! What names stand for.

use super::emit::{Emit, Place, What};
use super::references::{Walk, Way};
use super::types::{Kind, Ty, elementary, holding, layout, lineage};
use super::value::{Value, constant};
use scanbound_base::code::Code;
use scanbound_iec::ast::{Expr, Literal, Part, Path};
use scanbound_iec::fault::Fault;
use scanbound_iec::{Body, PouKind, Section, TypeRef, Variable, same, show};
use scanbound_ir::errors::is_outside;
use scanbound_ir::meaning::{Address, IntegerFormat, Term};
use scanbound_ir::{Cell, Logic, Number, Region, WordSource};

/// Where a statement stands.
#[derive(Debug, Clone)]
pub(super) struct Context {
    pub(super) instance: usize,
    /// The variables of the method or function that is carried out.
    pub(super) locals: Option<Place>,
    /// The unit whose code it is: that of the instance, or one that it extends.
    pub(super) unit: usize,
}

/// An element of an array whose number is worked out.
#[derive(Debug, Clone)]
pub(super) struct Element {
    /// The part that is meant, in the array's first element.
    pub(super) place: Place,
    /// Indices, and how many bits and words they count in.
    terms: Vec<(Vec<WordSource>, [i64; 2])>,
    /// What the least indices take off, in bits and in words.
    base: [i64; 2],
    /// The array that bounds it all.
    pub(super) whole: Place,
}

impl Element {
    /// All cells of the array of the kind that is meant.
    pub(super) fn region(&self) -> Option<(Cell, u32)> {
        let own = self.place.tag.cell()?;
        self.whole.tag.regions().into_iter().find_map(|region| match region {
            Region::Range { first, count } if first.area == own.area => Some((first, count)),
            _ => None,
        })
    }

    pub(super) fn address(&self) -> Option<Address> {
        let (first, count) = self.region()?;
        let offset = i64::from(self.place.tag.cell()?.index - first.index);
        let side = usize::from(!matches!(self.place.ty, Ty::Bit));
        let term = |(words, sizes): &(Vec<WordSource>, [i64; 2])| Term {
            words: words.clone(),
            format: IntegerFormat::Signed,
            factor: sizes[side],
        };
        let terms = self.terms.iter().map(term).collect();
        Some(Address::within(first, count, self.base[side] + offset, terms))
    }
}

/// What a path stands for.
#[derive(Debug, Clone)]
pub(super) enum Found {
    Place(Place),
    Element(Element),
    /// A bit of a word, and the last of those that follow it: the sign of 8 bits fills its word.
    WordBit(Cell, u8, u8),
    Value(Value),
    /// How long a step is active.
    Elapsed(Cell),
}

pub(super) fn unknown(line: u32, name: &str) -> Fault {
    Fault::new(line, format!("there is no {name}"))
        .code(Code::UnknownName)
        .text(name)
        .help("give all files of the project, or declare it")
}

/// A global variable's name, with that of its list.
pub(super) fn full_name(list: &str, one: &Variable) -> String {
    if list.is_empty() { one.name.clone() } else { format!("{list}.{}", one.name) }
}

/// The elementary type that a variable is declared with.
fn elementary_of(one: &Variable) -> Option<Ty> {
    match &one.of {
        TypeRef::Named(name) => elementary(name),
        _ => None,
    }
}

impl<'p> Emit<'p> {
    /// What a path stands for, through references that can mean one variable alone.
    pub(super) fn find(&mut self, at: &Context, path: &Path, line: u32) -> Result<Found, Fault> {
        let Walk::Way(Way::Referred(way)) = self.walk(at, path, true) else {
            return self.find_plain(at, path, line);
        };
        let can = self.candidates(way.kind, &way.of);
        let ([only], None) = (&can[..], &way.among) else {
            let what = format!(
                "{} may mean one of several variables, which is not followed here",
                show::path(path)
            );
            let help = "assign it to a variable of its own before, or call it in a statement";
            return Err(Fault::new(line, what).code(Code::NotModelled).help(help));
        };
        self.cost(&["LD"], "contact");
        let place = self.target_at(*only);
        self.with_name(place, &show::path(&way.before), |emit, first| {
            emit.find(at, &Path { first, rest: way.rest }, line)
        })
    }

    /// Whether the unit, or the method, has a variable of this name.
    pub(super) fn has_variable(&self, at: &Context, name: &str) -> bool {
        let own = at.locals.as_ref().and_then(|place| Self::part_type(place, name));
        own.or_else(|| Self::part_type(&self.instances[at.instance].place, name)).is_some()
    }

    /// What a path stands for, no reference being followed.
    pub(super) fn find_plain(
        &mut self,
        at: &Context,
        path: &Path,
        line: u32,
    ) -> Result<Found, Fault> {
        if let Some(place) = self.references.meant(&path.first).cloned() {
            return self.follow(at, Found::Place(place), &path.rest, path, line);
        }
        if let Some(kept) = self.kept.get(&path.first).filter(|_| path.rest.is_empty()) {
            return Ok(Found::Value(kept.clone()));
        }
        let rest = &path.rest[..];
        if ["THIS", "SUPER"].iter().any(|own| same(own, &path.first)) {
            let place = self.instances[at.instance].place.clone();
            let behind =
                rest.iter().position(|part| *part != Part::Dereference).unwrap_or(rest.len());
            return self.follow(at, Found::Place(place), &rest[behind..], path, line);
        }
        let own = self.own_variable(at, &path.first);
        if let Some(found) = self.step_flag(at, path) {
            if own.is_some() && path.rest.len() == 1 {
                let told = format!("{} may be a variable or a step", path.first);
                let help = "give one of them another name";
                return Err(Fault::new(line, told).code(Code::DeclaredTwice).help(help));
            }
            return Ok(found);
        }
        if own.is_none() && self.has_property(at.unit, &path.first) {
            let told = format!("the property {} is not followed here", path.first);
            let help = "assign it to a variable of its own before";
            return Err(Fault::new(line, told).code(Code::NotModelled).help(help));
        }
        if let Some(value) = self.constant_value(at, path) {
            return Ok(Found::Value(value));
        }
        if let Some(place) = own.or_else(|| self.global(None, &path.first)) {
            return self.follow(at, Found::Place(place), rest, path, line);
        }
        if let (Some(list), [Part::Name(name), rest @ ..]) =
            (self.project.globals.iter().find(|(name, _)| same(name, &path.first)), rest)
            && list.1.iter().any(|one| same(&one.name, name))
            && let Some(place) = self.global(Some(&list.0), name)
        {
            return self.follow(at, Found::Place(place), rest, path, line);
        }
        if let Some(place) = self.program_place(&path.first) {
            return self.follow(at, Found::Place(place), rest, path, line);
        }
        let last = path.split_last().map_or(path.first.as_str(), |(_, last)| last);
        if let Some(number) = self.types.named_constant(&path.first).or_else(|| {
            let of = format!("{}#{last}", path.first);
            self.types.named_constant(&of).filter(|_| path.rest.len() == 1)
        }) {
            return Ok(Found::Value(Value::Constant(number)));
        }
        if path.first.starts_with('%') {
            let place = self.direct(&path.first, line)?;
            return self.follow(at, Found::Place(place), rest, path, line);
        }
        Err(self.not_declared(at, path, line))
    }

    /// The variable of a method, or of the instance, by its name.
    pub(super) fn own_variable(&self, at: &Context, name: &str) -> Option<Place> {
        let own = at.locals.as_ref().and_then(|place| Self::part(place, name));
        own.or_else(|| Self::part(&self.instances[at.instance].place, name))
    }

    /// What a path stands for where no unit's own variables are known: a global variable, or an address.
    pub(super) fn find_outside(
        &mut self,
        at: &Context,
        path: &Path,
        line: u32,
    ) -> Result<Found, Fault> {
        if path.first.starts_with('%') {
            let place = self.direct(&path.first, line)?;
            return self.follow(at, Found::Place(place), &path.rest, path, line);
        }
        let list = self.project.globals.iter().find(|(name, _)| same(name, &path.first));
        let (list, name, rest) = match (list, &path.rest[..]) {
            (Some((list, _)), [Part::Name(name), rest @ ..]) => (Some(list.as_str()), name, rest),
            (_, rest) => (None, &path.first, rest),
        };
        let place = self.global(list, name).ok_or_else(|| unknown(line, &show::path(path)))?;
        self.follow(at, Found::Place(place), rest, path, line)
    }

    /// The instance of a program that is named by its type.
    pub(super) fn program_place(&mut self, name: &str) -> Option<Place> {
        let own = self.by_name.get(&name.to_ascii_uppercase()).copied();
        let own = own.or_else(|| {
            let is = |one: &super::emit::Instance| {
                let pou = &self.project.pous[one.pou];
                pou.kind == PouKind::Program && same(&pou.name, name)
            };
            self.instances.iter().position(is)
        });
        own.filter(|&own| self.pou_of(own).kind == PouKind::Program)
            .map(|own| self.instances[own].place.clone())
    }

    /// A whole number that is known as it stands: of numbers, and of names that no variable here hides.
    pub(super) fn constant(&self, at: &Context, one: &Expr) -> Option<i64> {
        let hides = |path: &Path| {
            let name = &path.first;
            let constants = &self.types.constants;
            self.own_variable(at, name).is_some()
                || self.has_property(at.unit, name)
                || constants.globals(name).any(|(.., one)| !one.constant)
                || !(path.rest.is_empty() || constants.is_list_or_type(name))
        };
        fn names<'e>(one: &'e Expr, found: &mut Vec<&'e Path>) {
            match one {
                Expr::Variable(path) => found.push(path),
                Expr::Negate(inner) | Expr::Not(inner) => names(inner, found),
                Expr::Binary(_, left, right) => {
                    names(left, found);
                    names(right, found);
                }
                Expr::Literal(_) | Expr::Call(..) => {}
            }
        }
        match one {
            Expr::Variable(path) if self.own_constant(at, path).is_some() => {
                let own = self.own_constant(at, path)?;
                let initial = own.initial.as_ref()?;
                let mut found = Vec::new();
                names(initial, &mut found);
                let value =
                    self.types.constant(initial).filter(|_| !found.into_iter().any(hides))?;
                let Some(Ty::Number(kind)) = elementary_of(own) else { return None };
                return (holding(kind, value) == kind).then_some(value);
            }
            Expr::Negate(inner) => return self.constant(at, inner)?.checked_neg(),
            Expr::Binary(operator, left, right) => {
                let (left, right) = (self.constant(at, left)?, self.constant(at, right)?);
                return operator.of_constants(left, right);
            }
            _ => {}
        }
        let mut found = Vec::new();
        names(one, &mut found);
        self.types.constant(one).filter(|_| !found.into_iter().any(hides))
    }

    /// The constant that a unit declares by this name.
    fn own_constant(&self, at: &Context, path: &Path) -> Option<&'p Variable> {
        let name = path.as_name().filter(|name| self.types.constants.is_own(name))?;
        if at.locals.as_ref().is_some_and(|place| Self::part(place, name).is_some()) {
            return None;
        }
        let lineage = lineage(self.project, self.instances[at.instance].pou);
        let own = lineage.into_iter().flat_map(|pou| &pou.variables);
        let mut own = own.filter(|one| one.section != Section::External);
        own.find(|one| same(&one.name, name)).filter(|one| self.is_fixed(one))
    }

    /// Whether a variable always holds what it begins with: inputs may be constant, too, and are handed over; what an
    /// instance's declaration gives to its parts is not followed.
    fn is_fixed(&self, one: &Variable) -> bool {
        match one.section {
            Section::Global => one.constant,
            Section::Local => one.constant && !self.gives_parts,
            _ => false,
        }
    }

    /// What a constant of the unit's, or else a global one, holds.
    fn constant_value(&self, at: &Context, path: &Path) -> Option<Value> {
        let name = path.as_name()?;
        let one = match self.own_variable(at, name) {
            Some(_) => self.own_constant(at, path)?,
            None if self.has_property(at.unit, name) => return None,
            None => {
                let mut all = self.types.constants.globals(name).map(|(.., one)| one);
                all.next().filter(|one| one.constant && all.next().is_none())?
            }
        };
        match (elementary_of(one)?, one.initial.as_ref()?) {
            (Ty::Bit, Expr::Literal(Literal::Bool(value))) => {
                Some(Value::Bit(Logic::Const(*value)))
            }
            (Ty::Number(kind @ Kind::Whole { .. }), _) => {
                let value = self.constant(at, &Expr::Variable(path.clone()))?;
                let fits = holding(kind, value) == kind;
                fits.then(|| Value::Number(kind, constant(value, kind.words())))
            }
            _ => None,
        }
    }

    /// A global variable: of a list, or the first of all of its name.
    pub(super) fn global(&mut self, list: Option<&str>, name: &str) -> Option<Place> {
        let is_it = |own: &str| list.is_none_or(|list| same(own, list));
        let mut named = self.types.constants.globals(name);
        let (list, all, one) = named.find(|(own, ..)| is_it(own))?;
        drop(named);
        let full = full_name(list, one);
        let key = full.to_ascii_uppercase();
        if let Some(known) = self.globals.get(&key) {
            return Some(known.clone());
        }
        let ty = self.types.of_global(list, all, one).ok()?;
        let place = self.variable(&full, ty, one.line).ok()?;
        self.globals.insert(key, place.clone());
        Some(place)
    }

    /// A direct address. Overlaps of bits with words are not known, so words of addresses are any value.
    fn direct(&mut self, name: &str, line: u32) -> Result<Place, Fault> {
        let key = name.to_ascii_uppercase();
        if let Some(known) = self.globals.get(&key) {
            return Ok(known.clone());
        }
        let size = key.trim_start_matches('%').chars().nth(1).unwrap_or('X');
        let ty = match size {
            'B' => Ty::Number(Kind::Whole { bits: 8, signed: false }),
            'W' => Ty::Number(Kind::Whole { bits: 16, signed: false }),
            'D' => Ty::Number(Kind::Whole { bits: 32, signed: false }),
            'L' => Ty::Number(Kind::Whole { bits: 64, signed: false }),
            _ => Ty::Bit,
        };
        let place = self.variable(&key, ty, line)?;
        self.globals.insert(key, place.clone());
        Ok(place)
    }

    /// A step's flag or time, of a chart of the instance, or of one of its actions.
    fn step_flag(&mut self, at: &Context, path: &Path) -> Option<Found> {
        let [before @ .., Part::Name(flag)] = &path.rest[..] else { return None };
        if !same(flag, "X") && !same(flag, "T") {
            return None;
        }
        // A step in macro steps has several names: `M1.S3`.
        let names = |parts: &[Part]| {
            let name = |part: &Part| match part {
                Part::Name(name) => Some(name.clone()),
                _ => None,
            };
            Some(parts.iter().map(name).collect::<Option<Vec<_>>>()?.join("."))
        };
        let all = [&[Part::Name(path.first.clone())], before].concat();
        let flag_of = |emit: &mut Self, instance: usize, step: &str| {
            let what = emit.chart_with(instance, step)?;
            let tag = emit.chart_memory(instance, &what)?;
            let (_, Body::Chart(chart)) = emit.body(instance, &what)? else { return None };
            let cells = chart.flagged(step)?.into_iter().map(|step| {
                Some(Logic::cell(tag.part(&chart.steps[step].name)?.part("X")?.cell()?))
            });
            let mut cells = cells.collect::<Option<Vec<_>>>()?;
            let active = if cells.len() == 1 { cells.remove(0) } else { Logic::Any(cells) };
            let own = chart.step(step).map(|step| &chart.steps[step].name);
            let of_macro = || chart.macros.iter().find(|one| same(&one.name, step));
            let name = own.or_else(|| of_macro().map(|one| &one.name))?;
            Some((active, tag.part(name)?.part("T")?.cell()?))
        };
        let own = names(&all).and_then(|step| flag_of(self, at.instance, &step));
        let (active, time) = match own {
            Some(found) => found,
            // The first names lead to an instance of a function block.
            None => (1..all.len()).rev().find_map(|cut| {
                let step = names(&all[cut..])?;
                let owner = Path { first: path.first.clone(), rest: all[1..cut].to_vec() };
                let Ok(Found::Place(place)) = self.find(at, &owner, 0) else { return None };
                let Ty::Block(pou, _) = place.ty else { return None };
                let instance = self.instance(&place, pou);
                flag_of(self, instance, &step)
            })?,
        };
        Some(if same(flag, "X") {
            Found::Value(Value::Bit(active))
        } else {
            self.times_read.insert(time);
            Found::Elapsed(time)
        })
    }

    /// Which chart of an instance has a step of this name.
    fn chart_with(&self, instance: usize, step: &str) -> Option<What> {
        let all = lineage(self.project, self.instances[instance].pou);
        all.iter().find_map(|pou| {
            let has =
                |body: &Body| matches!(body, Body::Chart(chart) if chart.flagged(step).is_some());
            if has(&pou.body) {
                return Some(What::Body);
            }
            let own = pou.actions.iter().find(|action| has(&action.body))?;
            Some(What::Action(own.name.to_ascii_uppercase()))
        })
    }

    /// What was found, whatever indices are written next.
    pub(super) fn staying(&mut self, found: Found) -> Found {
        let Found::Element(mut element) = found else { return found };
        for (words, _) in &mut element.terms {
            let now = Number::Words(std::mem::take(words));
            *words = self.copied(now, 2);
        }
        Found::Element(element)
    }

    /// Follows parts behind a place.
    fn follow(
        &mut self,
        at: &Context,
        from: Found,
        rest: &[Part],
        path: &Path,
        line: u32,
    ) -> Result<Found, Fault> {
        let mut found = from;
        for part in rest {
            found = match (found, part) {
                (Found::Place(place), Part::Name(name)) => match Self::part(&place, name) {
                    Some(part) => {
                        if let Ty::Block(pou, _) = place.ty
                            && place.name != self.instances[at.instance].place.name
                        {
                            self.names_handed(pou, name, line)?;
                        }
                        self.note_count(&place.ty, &part);
                        Found::Place(part)
                    }
                    None => return Err(unknown(line, &show::path(path))),
                },
                (Found::Element(element), Part::Name(name)) => {
                    match Self::part(&element.place, name) {
                        Some(place) => {
                            if let Ty::Block(pou, _) = element.place.ty {
                                self.names_handed(pou, name, line)?;
                            }
                            self.note_count(&element.place.ty, &place);
                            Found::Element(Element { place, ..element })
                        }
                        None => return Err(unknown(line, &show::path(path))),
                    }
                }
                (Found::Place(place), Part::Index(indices)) => {
                    self.index(at, place, indices, None, line)?
                }
                (Found::Element(element), Part::Index(indices)) => {
                    self.index(at, element.place.clone(), indices, Some(element), line)?
                }
                (Found::Place(place), Part::Bit(bit)) => match (&place.ty, place.tag.cell()) {
                    (Ty::Number(Kind::Whole { bits, signed }), Some(cell)) if bit < bits => {
                        let last =
                            if (*bits, *bit, *signed) == (8, 7, true) { 15 } else { bit % 16 };
                        Found::WordBit(cell.plus(u32::from(bit / 16)), bit % 16, last)
                    }
                    _ => return Err(Fault::new(line, format!("{} has no bit {bit}", place.name))),
                },
                _ => {
                    let message = format!("{} is not followed", show::path(path));
                    return Err(Fault::new(line, message).code(Code::NotModelled));
                }
            };
        }
        Ok(found)
    }

    /// The element of an array.
    fn index(
        &mut self,
        at: &Context,
        place: Place,
        indices: &[Expr],
        outer: Option<Element>,
        line: u32,
    ) -> Result<Found, Fault> {
        let Ty::Array { dimensions, of } = place.ty.clone() else {
            return Err(Fault::new(line, format!("{} is no array", place.name)));
        };
        if indices.len() != dimensions.len() {
            let message = format!("{} has {} dimensions", place.name, dimensions.len());
            return Err(Fault::new(line, message));
        }
        let known: Option<Vec<i64>> =
            indices.iter().map(|index| self.constant(at, index)).collect();
        if let Some(known) = known {
            let mut tag = place.tag.clone();
            for (&number, (low, high)) in known.iter().zip(dimensions.iter()) {
                let outside = || {
                    Fault::new(line, format!("{}[{number}] lies outside {low}..{high}", place.name))
                };
                tag = tag.element(number).ok_or_else(outside)?;
            }
            let numbers: Vec<String> = known.iter().map(ToString::to_string).collect();
            let name = format!("{}[{}]", place.name, numbers.join(", "));
            let inner = Place { name, tag, ty: (*of).clone() };
            return Ok(match outer {
                None => Found::Place(inner),
                Some(outer) => Found::Element(Element { place: inner, ..outer }),
            });
        }
        let mut first = place.tag.clone();
        for (low, _) in dimensions.iter() {
            let empty = || Fault::new(line, format!("{} is too large", place.name));
            first = first.element(*low).ok_or_else(empty)?;
        }
        let inner = Place { name: format!("{}[..]", place.name), tag: first, ty: (*of).clone() };
        let (mut terms, mut base, whole) = match outer {
            Some(outer) => (outer.terms, outer.base, outer.whole),
            None => (Vec::new(), [0, 0], place.clone()),
        };
        let size = layout(&of).size().unwrap_or_default();
        let mut step = dimensions.iter().rev().fold(vec![1_i64], |mut steps, (low, high)| {
            let last = steps.last().copied().unwrap_or(1);
            steps.push(last * (high - low + 1));
            steps
        });
        step.pop();
        let size = size.map(i64::from);
        let all: Vec<&Expr> = indices.iter().collect();
        let values =
            self.operands(at, &all, line, &mut |emit, which| emit.value(at, all[which], line))?;
        for ((value, (low, high)), step) in
            values.into_iter().zip(dimensions.iter()).zip(step.iter().rev())
        {
            let value = self.as_number(value, super::types::DINT, line)?;
            let words = self.words(value, 2);
            self.not_followed_where(is_outside(&Number::Words(words.clone()), *low, *high));
            terms.push((words, size.map(|size| size * step)));
            (0..2).for_each(|side| base[side] -= low * step * size[side]);
        }
        Ok(Found::Element(Element { place: inner, terms, base, whole }))
    }
}
