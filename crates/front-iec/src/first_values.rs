//! What variables begin with before the first scan, as they are declared, and what constants hold in every scan.

use super::emit::{Emit, Place};
pub(super) use super::lower::first_values::{FIRST_SCAN, First, FirstValue};
use super::types::{Kind, Ty, elementary, holding, lineage};
use super::value::{real, within};
use scanbound_iec::ast::{Argument, Expr, Literal};
use scanbound_iec::parse::{CONSTRUCTED, LISTED, UNREAD};
use scanbound_iec::{Pou, PouKind, Project, Section, TypeRef, Variable, same};
use scanbound_iec_tree::constants::{Constants, Scope};
use scanbound_ir::{Logic, Number, Step};

/// More elements of an array are not looked at one by one.
const MAX_ELEMENTS: usize = 20_000;

/// How many constants may refer to each other in a row.
const DEPTH: u32 = 100;

/// A declaration: the type, what is written as initial value, if anything, and what hides global names in that.
#[derive(Clone, Copy)]
struct Declared<'e> {
    of: &'e TypeRef,
    initial: Option<&'e Expr>,
    scope: &'e Scope<'e>,
}

/// What declarations give to variables at first.
pub(super) struct Firsts<'f> {
    pub(super) project: &'f Project,
    pub(super) constants: &'f Constants<'f>,
}

impl Firsts<'_> {
    /// What a variable and its parts begin with; `scope`: what hides global names where it is declared. Nothing is said of
    /// text, nor of what stands in instances of the project's blocks.
    pub(super) fn of(
        &self,
        variable: &Variable,
        place: &Place,
        scope: &Scope<'_>,
    ) -> Vec<FirstValue> {
        let mut found = Vec::new();
        let declared = Declared { of: &variable.of, initial: variable.initial.as_ref(), scope };
        self.firsts(place, declared, &mut found);
        found
    }

    fn firsts(&self, place: &Place, declared: Declared<'_>, found: &mut Vec<FirstValue>) {
        let (declared, is_open) = self.underlying(declared);
        let all = |first| FirstValue { regions: place.tag.regions(), first };
        match &place.ty {
            Ty::Bit | Ty::Number(_) => {
                // Whether a subrange begins with 0 or its lowest value, controllers differ.
                let is_known = declared.initial.is_some() || !is_open;
                let known = is_known.then(|| self.single(&place.ty, declared)).flatten();
                let first = match (known, place.tag.cell(), &place.ty) {
                    (Some(Single::Zero), ..) => First::Zero,
                    (Some(Single::On), Some(cell), _) => First::On(cell),
                    (Some(Single::Number(number)), Some(cell), _) => First::Words(cell, number),
                    _ => First::Unknown,
                };
                found.push(all(first));
            }
            Ty::Reference(..) => {
                let first = declared.initial.map_or(First::Zero, |_| First::Unknown);
                found.push(all(first));
            }
            Ty::Text(_) | Ty::Block(..) => {}
            Ty::Array { dimensions, of } => {
                let known = self.first_elements(place, (dimensions, of), declared);
                match known {
                    Some(known) => found.extend(known),
                    None => found.push(all(First::Unknown)),
                }
            }
            Ty::Parts(_) => {
                let (TypeRef::Struct(parts), Some(given)) =
                    (declared.of, given(declared.initial, CONSTRUCTED))
                else {
                    return found.push(all(First::Unknown));
                };
                for one in parts {
                    let Some(part) = Emit::part(place, &one.name) else { continue };
                    let own = given.iter().find(|own| is_for(own, &one.name));
                    let (initial, scope) = match own {
                        Some(own) => (Some(&own.value), declared.scope),
                        None => (one.initial.as_ref(), &[] as &Scope<'_>),
                    };
                    self.firsts(&part, Declared { of: &one.of, initial, scope }, found);
                }
            }
            Ty::Standard(name, parts) => {
                let Some(given) = given(declared.initial, CONSTRUCTED) else {
                    return found.push(all(First::Unknown));
                };
                for (own, ty) in parts.iter() {
                    let Some(part) = Emit::part(place, own) else { continue };
                    let initial = given.iter().find(|one| is_for(one, own)).map(|one| &one.value);
                    // Whether a falling edge is seen in the first call, controllers differ.
                    let first = match (*name, own.as_str(), initial) {
                        ("F_TRIG", "was", _) => First::Unknown,
                        (.., None) => First::Zero,
                        (.., Some(_)) => {
                            let known = self.single(ty, Declared { initial, ..declared });
                            match (known, part.tag.cell()) {
                                (Some(Single::Zero), _) => First::Zero,
                                (Some(Single::On), Some(cell)) => First::On(cell),
                                (Some(Single::Number(number)), Some(cell)) => {
                                    First::Words(cell, number)
                                }
                                _ => First::Unknown,
                            }
                        }
                    };
                    found.push(FirstValue { regions: part.tag.regions(), first });
                }
            }
        }
    }

    /// What the elements of an array begin with, if they can be looked at.
    fn first_elements(
        &self,
        place: &Place,
        (dimensions, of): (&[(i64, i64)], &Ty),
        declared: Declared<'_>,
    ) -> Option<Vec<FirstValue>> {
        let TypeRef::Array(_, inner) = declared.of else { return None };
        let values = given(declared.initial, LISTED)?;
        let element = |numbers: &[i64]| {
            let tag = numbers.iter().try_fold(place.tag.clone(), |tag, at| tag.element(*at))?;
            Some(Place { name: format!("{}[{numbers:?}]", place.name), tag, ty: of.clone() })
        };
        let mut numbers: Vec<i64> = dimensions.iter().map(|(low, _)| *low).collect();
        let plain = Declared { of: inner, initial: None, scope: &[] };
        let mut first = Vec::new();
        self.firsts(&element(&numbers)?, plain, &mut first);
        let are_all = |value: &First| first.iter().all(|one| one.first == *value);
        if values.is_empty() && !first.is_empty() && are_all(&First::Zero) {
            return Some(vec![FirstValue { regions: place.tag.regions(), first: First::Zero }]);
        }
        let mut counts = dimensions.iter().map(|(low, high)| usize::try_from(high - low + 1).ok());
        let count = counts.try_fold(1_usize, |all, count| all.checked_mul(count?))?;
        // Lists within the list, for several dimensions, are not told apart from values of elements.
        let is_nested = |one: &Argument| given(Some(&one.value), LISTED).is_some();
        // `N(7)` repeats a value as often as the constant says, which is not worked out here.
        let is_call = |one: &Argument| match &one.value {
            Expr::Call(path, _) => {
                !path.as_name().is_some_and(|name| [CONSTRUCTED, LISTED, UNREAD].contains(&name))
            }
            _ => false,
        };
        if count > MAX_ELEMENTS
            || values.len() > count
            || values.iter().any(is_call)
            || (dimensions.len() > 1 && values.iter().any(is_nested))
        {
            return None;
        }
        let mut found = Vec::new();
        for at in 0..count {
            let initial = values.get(at).map(|one| &one.value);
            let scope = if initial.is_some() { declared.scope } else { &[] };
            let one = Declared { of: inner, initial, scope };
            self.firsts(&element(&numbers)?, one, &mut found);
            if found.len() > MAX_ELEMENTS {
                return None;
            }
            // The last index runs fastest.
            for (number, (low, high)) in numbers.iter_mut().zip(dimensions).rev() {
                *number += 1;
                if *number <= *high {
                    break;
                }
                *number = *low;
            }
        }
        Some(found)
    }

    /// The type behind the names of types, with the initial value that they give; and whether it is a subrange that does not
    /// begin with 0.
    fn underlying<'e>(&'e self, declared: Declared<'e>) -> (Declared<'e>, bool) {
        let mut found = declared;
        let mut is_open = false;
        for _ in 0..DEPTH {
            match found.of {
                TypeRef::Named(name) if elementary(name).is_none() => {
                    let own = self.project.types.iter().find(|one| same(&one.name, name));
                    let Some(own) = own else { break };
                    if let (None, Some(initial)) = (found.initial, &own.initial) {
                        (found.initial, found.scope) = (Some(initial), &[]);
                    }
                    found.of = &own.of;
                }
                TypeRef::Subrange(of, range) => {
                    is_open |= self.constants.number(&range.0, found.scope) != Some(0);
                    found.of = of;
                }
                _ => break,
            }
        }
        (found, is_open)
    }

    /// What a variable without parts begins with, if it is known.
    fn single(&self, ty: &Ty, declared: Declared<'_>) -> Option<Single> {
        let Declared { of, initial, scope } = declared;
        let number = match (ty, initial) {
            (Ty::Bit, None) => return Some(Single::Zero),
            (Ty::Bit, Some(initial)) => {
                let on = match self.constant_literal(initial, scope, 0) {
                    Some((Literal::Bool(on), negated)) => *on != negated,
                    _ => self.constants.number(initial, scope)? != 0,
                };
                return Some(if on { Single::On } else { Single::Zero });
            }
            (Ty::Number(kind @ Kind::Whole { .. }), _) => {
                let value = match initial {
                    Some(initial) => self.constants.number(initial, scope)?,
                    None if matches!(of, TypeRef::Enumeration(..)) => self.first_named(of)?,
                    None => 0,
                };
                (holding(*kind, value) == *kind).then(|| within(*kind, value))?
            }
            (Ty::Number(Kind::Real | Kind::Time), None) => return Some(Single::Zero),
            (Ty::Number(Kind::Real), Some(initial)) => match self
                .constant_literal(initial, scope, 0)?
            {
                (Literal::Real(text, _), negated) => real(&signed(text, negated))?,
                (Literal::Int(value, _), negated) => real(&signed(&value.to_string(), negated))?,
                _ => return None,
            },
            (Ty::Number(kind @ Kind::Time), Some(initial)) => {
                match self.constant_literal(initial, scope, 0)? {
                    (Literal::Time(time), false) if time % 1_000_000 == 0 => {
                        let ms = i32::try_from(time / 1_000_000).ok()?;
                        within(*kind, ms.into())
                    }
                    _ => return None,
                }
            }
            _ => return None,
        };
        let Ty::Number(kind) = ty else { return None };
        Some(if number == within(*kind, 0) { Single::Zero } else { Single::Number(number) })
    }

    /// The literal that an expression is, or that constants lead to, and whether a sign or NOT stands before it.
    fn constant_literal<'e>(
        &'e self,
        one: &'e Expr,
        scope: &Scope<'e>,
        depth: u32,
    ) -> Option<(&'e Literal, bool)> {
        let deeper = |one: &'e Expr, scope: &Scope<'e>| {
            (depth < DEPTH).then(|| self.constant_literal(one, scope, depth + 1))?
        };
        match one {
            Expr::Literal(literal) => Some((literal, false)),
            Expr::Negate(inner) | Expr::Not(inner) => {
                deeper(inner, scope).map(|(literal, negated)| (literal, !negated))
            }
            Expr::Variable(path) => {
                let name = path.as_name()?;
                let is_it =
                    |one: &&Variable| one.section != Section::External && same(&one.name, name);
                let own = scope.iter().enumerate().find_map(|(at, all)| {
                    let own: &'e [Variable] = all;
                    Some((at, own.iter().find(is_it)?))
                });
                if let Some((at, own)) = own {
                    let initial = own.initial.as_ref().filter(|_| own.constant)?;
                    return deeper(initial, &scope[at..]);
                }
                let mut all = self.constants.globals(name);
                let (list, variables, own) = all.next().filter(|_| all.next().is_none())?;
                let initial = own.initial.as_ref().filter(|_| own.constant)?;
                if list.is_empty() { deeper(initial, &[]) } else { deeper(initial, &[variables]) }
            }
            _ => None,
        }
    }

    /// The number of the first value of an enumeration.
    fn first_named(&self, of: &TypeRef) -> Option<i64> {
        let TypeRef::Enumeration(values, _) = of else { return None };
        match values.first()? {
            (_, Some(number)) => self.constants.number(number, &[]),
            (_, None) => Some(0),
        }
    }
}

impl Emit<'_> {
    /// What a variable and its parts begin with; `scope`: what hides global names where it is declared.
    pub(super) fn first_values(
        &self,
        variable: &Variable,
        place: &Place,
        scope: &Scope<'_>,
    ) -> Vec<FirstValue> {
        let firsts = Firsts { project: self.project, constants: &self.types.constants };
        firsts.of(variable, place, scope)
    }

    /// The constants by their names, with what they hold.
    pub(super) fn constants(&self) -> Vec<(String, Vec<FirstValue>)> {
        let project = self.project;
        let mut all: Vec<(String, Vec<FirstValue>)> = Vec::new();
        for instance in &self.instances {
            let units = lineage(project, instance.pou);
            let is_handed = self.gives_parts && project.pous[instance.pou].kind != PouKind::Program;
            for (number, unit) in units.iter().enumerate() {
                let scope: Vec<&[Variable]> =
                    units[number..].iter().map(|pou| &pou.variables[..]).collect();
                for one in unit.variables.iter().filter(|one| is_given(one)) {
                    let Some(part) = Self::part(&instance.place, &one.name) else { continue };
                    let mut found = self.first_values(one, &part, &scope);
                    if is_handed {
                        found.iter_mut().for_each(|one| one.first = First::Unknown);
                    }
                    all.push((part.name, found));
                }
            }
        }
        for (list, variables) in &project.globals {
            let scope: &Scope<'_> = if list.is_empty() { &[] } else { &[variables] };
            for one in variables.iter().filter(|one| is_given(one)) {
                let name = super::resolve::full_name(list, one).to_ascii_uppercase();
                let Some(place) = self.globals.get(&name) else { continue };
                all.push((place.name.clone(), self.first_values(one, place, scope)));
            }
        }
        all
    }

    /// Where bits are turned on as the first scan begins; which, is given when it is known what the program writes.
    pub(super) fn first_scan(&mut self) -> Option<usize> {
        let place = self.variable(FIRST_SCAN, Ty::Bit, 1).ok()?;
        self.at(1, "first values");
        let fires = Logic::cell(place.tag.cell()?);
        Some(self.builder.add(None, Vec::new(), Step::Act { fires }))
    }
}

/// Whether a variable is a constant that gets its value as each scan begins. Inputs may be constant, too, and are handed over.
pub(super) fn is_given(one: &Variable) -> bool {
    one.constant && one.at.is_none() && matches!(one.section, Section::Local | Section::Global)
}

/// What a variable without parts begins with.
enum Single {
    Zero,
    On,
    Number(Number),
}

/// A number as it is written, with another sign.
fn signed(text: &str, negated: bool) -> String {
    if negated { format!("-{text}") } else { text.to_owned() }
}

/// The values that an initial value lists for elements or parts: none, if there is no initial value. Nothing, if it is another
/// one.
fn given<'e>(initial: Option<&'e Expr>, kind: &str) -> Option<&'e [Argument]> {
    match initial {
        None => Some(&[]),
        Some(Expr::Call(path, given)) if path.first == kind => Some(given),
        Some(_) => None,
    }
}

fn is_for(one: &Argument, name: &str) -> bool {
    one.name.as_ref().is_some_and(|own| same(own, name))
}

/// Whether any variable is declared with a first value, or a type gives one: nothing is to be written without one.
pub(super) fn any(project: &Project) -> bool {
    let lists = project.globals.iter().map(|(_, list)| list);
    let all = project.pous.iter().map(|pou: &Pou| &pou.variables).chain(lists);
    let of_types = project.types.iter().any(|one| {
        one.initial.is_some()
            || matches!(&one.of, TypeRef::Struct(parts) if parts.iter().any(|one| one.initial.is_some()))
    });
    of_types || all.flatten().any(|one| one.initial.is_some() && !one.constant)
}

/// Whether there are constants.
pub(super) fn has_constants(project: &Project) -> bool {
    let units = project.pous.iter().map(|pou| &pou.variables);
    let mut all = units.chain(project.globals.iter().map(|(_, list)| list)).flatten();
    all.any(is_given)
}
