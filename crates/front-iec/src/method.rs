//! Methods, calls through references and of what the base has, and what is known of variables as they are declared.

use super::emit::{Emit, Place, What};
use super::function::parameters;
use super::references::{Walk, Way};
use super::resolve::{Context, unknown};
use super::types::{Kind, Refers, Ty, lineage};
use super::value::Value;
use scanbound_base::code::Code;
use scanbound_iec::ast::{Argument, Expr, Operator, Part, Path};
use scanbound_iec::fault::Fault;
use scanbound_iec::{Pou, PouKind, Section, Variable, same, show};
use scanbound_ir::Logic;

impl<'p> Emit<'p> {
    /// What a call through a reference, of what a property gives or of what the base has gives; addresses of variables.
    pub(super) fn function_through(
        &mut self,
        at: &Context,
        path: &Path,
        given: &[Argument],
        line: u32,
    ) -> Result<Option<Value>, Fault> {
        if same(&path.first, "SUPER") {
            let mut names = path.rest.iter().filter(|part| **part != Part::Dereference);
            let (Some(Part::Name(name)), None) = (names.next(), names.next()) else {
                return Err(unknown(line, &show::path(path)));
            };
            return self.inherited(at, name, given, line).map(Some);
        }
        if let (Some(name), [Argument { value: Expr::Variable(of), is_output: false, .. }]) =
            (path.as_name(), given)
        {
            let is_own = self.project.pous.iter().any(|pou| same(&pou.name, name));
            match name.to_ascii_uppercase().as_str() {
                _ if is_own => {}
                "ADR" | "REF" => return self.address_of(at, of, line).map(Some),
                "SIZEOF" | "LOWER_BOUND" | "UPPER_BOUND" => {
                    if let Some(found) = self.measured(at, name, of, 1) {
                        return Ok(Some(found));
                    }
                }
                "__ISVALIDREF" => {
                    let word = self.address(at, &given[0].value, Refers::Reference, line)?;
                    let none = Value::Constant(0);
                    return self.combined(Operator::NotEqual, word, none, line).map(Some);
                }
                _ => {}
            }
        }
        if let (Some(name), [Argument { value: Expr::Variable(of), .. }, which]) =
            (path.as_name(), given)
            && self.project.pou(name).is_none()
            && let Some(which) = self.constant(at, &which.value)
            && let Some(found) = self.measured(at, name, of, which)
        {
            return Ok(Some(found));
        }
        let act = &mut |emit: &mut Self, path: Path| emit.function(at, &path, given, line);
        match self.walk(at, path, true) {
            Walk::Way(Way::Referred(way)) if !way.rest.is_empty() => {
                for one in given {
                    self.stays(at, &way, &one.value, line)?;
                }
                self.each_target(at, &way, line, act).map(Some)
            }
            Walk::Way(Way::Property(property)) if !property.rest.is_empty() => {
                let found = self.through_property(at, &property, line, act)?;
                Ok(Some(self.frozen(found)))
            }
            _ => Ok(None),
        }
    }

    /// How large a variable is, or where one of the dimensions of an array begins or ends.
    fn measured(&mut self, at: &Context, name: &str, of: &Path, which: i64) -> Option<Value> {
        let Walk::Type(ty) = self.walk(at, of, true) else { return None };
        let bound = |high: bool| match &ty {
            Ty::Array { dimensions, .. } => {
                let at = usize::try_from(which - 1).ok()?;
                let (low, most) = dimensions.get(at)?;
                Some(if high { *most } else { *low })
            }
            _ => None,
        };
        let found = match name.to_ascii_uppercase().as_str() {
            "SIZEOF" => bytes(&ty)?,
            "LOWER_BOUND" => bound(false)?,
            "UPPER_BOUND" => bound(true)?,
            _ => return None,
        };
        self.cost(&["FUNCTION"], "special");
        Some(Value::Constant(found))
    }

    /// Carries out a method.
    pub(super) fn method(
        &mut self,
        at: &Context,
        instance: usize,
        name: &str,
        given: &[Argument],
        line: u32,
    ) -> Result<Value, Fault> {
        self.method_from(at, instance, None, name, given, line)
    }

    /// Carries out the method that the base has (`SUPER^.m()`).
    pub(super) fn inherited(
        &mut self,
        at: &Context,
        name: &str,
        given: &[Argument],
        line: u32,
    ) -> Result<Value, Fault> {
        let base = self.base(at, line)?;
        self.method_from(at, at.instance, Some(base), name, given, line)
    }

    /// Carries out the method of an instance, or the one that a unit has which it extends.
    pub(super) fn method_from(
        &mut self,
        at: &Context,
        instance: usize,
        from: Option<usize>,
        name: &str,
        given: &[Argument],
        line: u32,
    ) -> Result<Value, Fault> {
        let own = from.unwrap_or(self.instances[instance].pou);
        let Some((unit, method)) = self.method_in(own, name) else {
            return Err(unknown(line, &format!("{}.{name}", self.instances[instance].place.name)));
        };
        self.is_one_method(own, name, line)?;
        self.has_one_default(own, method, given, line)?;
        if instance != at.instance {
            self.member_names_handed(own, name, line)?;
        }
        let place = self.method_place_of(instance, from, &method.name)?;
        let owner = self.instances[instance].place.name.clone();
        self.leaves_none_out(&method.variables, given, line)?;
        self.has_one_name(at, Some(&owner), &method.variables, given, line)?;
        let enabled = self.begin_enabled(at, &place, given, line)?;
        self.hand_over(at, &place, &method.variables, given, line)?;
        let inner = Context { instance, locals: Some(place.clone()), unit };
        self.begin_anew(&inner, &place, &method.variables, given, line)?;
        self.begin_result(&inner, &place, method, line)?;
        let upper = method.name.to_ascii_uppercase();
        let what = match from {
            Some(from) => What::Inherited(from, upper),
            None => What::Method(upper),
        };
        self.call(Logic::Const(true), instance, what, "CAL");
        self.take_back(at, &place, &method.variables, given, line)?;
        let result = match method.result {
            Some(_) => self.result(&place, method.result_name(), line)?,
            None => Value::Any,
        };
        let enable = self.end_enabled(at, &place, enabled, given, line)?;
        self.open_outputs(at, enable.as_ref(), given, line)?;
        self.result_if(enable, result, line)
    }

    /// Refuses a method that a base has as PRIVATE, too: by the standard's third edition the base's own calls mean that one, and
    /// not all controllers do so.
    fn is_one_method(&self, unit: usize, name: &str, line: u32) -> Result<(), Fault> {
        let all = lineage(self.project, unit).into_iter();
        let methods = all.flat_map(|pou| &pou.methods).filter(|method| same(&method.name, name));
        let methods: Vec<&Pou> = methods.collect();
        let is_hidden = methods.iter().skip(1).any(|method| method.is_private);
        if !is_hidden {
            return Ok(());
        }
        let told = format!("{name} is a PRIVATE method of a base, too: which one is meant differs");
        let help = "give one of the two another name";
        Err(Fault::new(line, told).code(Code::NotModelled).help(help))
    }

    /// Refuses a call that leaves out an input which another declaration of the method gives another value: which declaration
    /// the call sees is not told.
    fn has_one_default(
        &self,
        unit: usize,
        method: &Pou,
        given: &[Argument],
        line: u32,
    ) -> Result<(), Fault> {
        let family = lineage(self.project, unit);
        let interfaces = self.project.pous.iter().filter(|pou| pou.kind == PouKind::Interface);
        let all = family.into_iter().chain(interfaces).flat_map(|pou| &pou.methods);
        let others: Vec<&Pou> = all.filter(|one| same(&one.name, &method.name)).collect();
        let handed: Vec<&String> =
            parameters(&method.variables, given).filter_map(|(name, _)| name).collect();
        let is_input = |one: &&Variable| one.section == Section::Input;
        let left_out = method.variables.iter().filter(is_input).find(|own| {
            let is_own = |one: &&Variable| same(&one.name, &own.name);
            !handed.iter().any(|name| same(name, &own.name))
                && others.iter().any(|other| {
                    let also = other.variables.iter().find(is_own);
                    also.is_some_and(|also| also.initial != own.initial)
                })
        });
        let Some(own) = left_out else { return Ok(()) };
        let told = format!(
            "{} of {} is left out, and what it is then differs by declaration",
            own.name, method.name
        );
        let help = "hand it over";
        Err(Fault::new(line, told).code(Code::NotModelled).help(help))
    }

    /// Whether a name alone means a method or an action of the unit whose code it is.
    pub(super) fn has_member(&self, at: &Context, name: &str) -> bool {
        let is_local = at.locals.as_ref().is_some_and(|place| Self::part(place, name).is_some());
        !is_local
            && lineage(self.project, at.unit).into_iter().any(|pou| {
                pou.action(name).is_some() || pou.methods.iter().any(|one| same(&one.name, name))
            })
    }

    /// The method that a unit has or inherits, and the unit that declares it.
    fn method_in(&self, unit: usize, name: &str) -> Option<(usize, &'p Pou)> {
        let all = &self.project.pous;
        lineage(self.project, unit).into_iter().find_map(|pou| {
            let method = pou.methods.iter().find(|method| same(&method.name, name))?;
            Some((all.iter().position(|one| std::ptr::eq(one, pou))?, method))
        })
    }

    /// The variables of a method of an instance.
    pub(super) fn method_place(&mut self, instance: usize, name: &str) -> Result<Place, Fault> {
        self.method_place_of(instance, None, name)
    }

    /// The same of the method that a unit has which the instance's extends.
    pub(super) fn method_place_of(
        &mut self,
        instance: usize,
        from: Option<usize>,
        name: &str,
    ) -> Result<Place, Fault> {
        let own = from.unwrap_or(self.instances[instance].pou);
        let Some((unit, method)) = self.method_in(own, name) else {
            return Err(unknown(0, name));
        };
        let of = match from {
            Some(_) => format!("{}::", self.project.pous[unit].name),
            None => String::new(),
        };
        let key = format!("{}.{of}{}()", self.instances[instance].place.name, method.name);
        if let Some(known) = self.globals.get(&key.to_ascii_uppercase()) {
            return Ok(known.clone());
        }
        let parts = self.types.variables(unit, Some(method))?;
        let place = self.variable(&key, Ty::Parts(parts), method.line)?;
        self.globals.insert(key.to_ascii_uppercase(), place.clone());
        Ok(place)
    }
}

/// How many bytes a variable of a type takes, where no controller adds any between its parts.
fn bytes(ty: &Ty) -> Option<i64> {
    match ty {
        Ty::Bit => Some(1),
        Ty::Number(Kind::Whole { bits, .. }) => Some(i64::from(bits / 8)),
        Ty::Number(Kind::Real | Kind::Time) => Some(4),
        Ty::Array { dimensions, of } => {
            let counts = dimensions.iter().map(|(low, high)| high - low + 1);
            { counts }.try_fold(bytes(of)?, i64::checked_mul)
        }
        _ => None,
    }
}
