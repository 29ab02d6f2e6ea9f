//! Types of IEC 61131-3 and how much memory they take.

use scanbound_base::code::Code;
use scanbound_base::facts::key;
use scanbound_iec::ast::{Expr, Literal};
use scanbound_iec::fault::Fault;
use scanbound_iec::{Pou, PouKind, Project, TypeRef, Variable, same};
use scanbound_iec_tree::constants::Constants;
pub(super) use scanbound_iec_tree::types::{DINT, INT, Kind, holding};
use scanbound_ir::{Type, tags};
use std::collections::BTreeMap;
use std::ops::Deref;
use std::sync::{Arc, OnceLock};

/// A type.
#[derive(Debug, Clone)]
pub(super) enum Ty {
    Bit,
    Number(Kind),
    /// Text of at most so many characters, whose content is not followed.
    Text(u32),
    Array {
        dimensions: Arc<[(i64, i64)]>,
        of: Arc<Ty>,
    },
    Parts(Arc<Parts>),
    /// An instance of a function block: the standard's, by name, or one of the project's.
    Standard(&'static str, Arc<Parts>),
    Block(usize, Arc<Parts>),
    /// A word that says which variable is meant.
    Reference(Refers, Arc<TypeRef>),
}

/// What a structure or an instance holds: names and types.
#[derive(Debug, Clone, Default)]
pub(super) struct Parts {
    all: Vec<(String, Ty)>,
    /// Where each name stands, in capitals; of several of one name the first.
    by_name: BTreeMap<String, usize>,
    layout: OnceLock<Arc<tags::Parts>>,
}

impl Parts {
    /// The number of the part of this name, in upper or lower case.
    pub(super) fn position(&self, name: &str) -> Option<usize> {
        self.by_name.get(&name.to_ascii_uppercase()).copied()
    }

    /// The part of this name.
    pub(super) fn named(&self, name: &str) -> Option<&(String, Ty)> {
        self.position(name).map(|at| &self.all[at])
    }
}

impl Deref for Parts {
    type Target = [(String, Ty)];

    fn deref(&self) -> &[(String, Ty)] {
        &self.all
    }
}

impl FromIterator<(String, Ty)> for Parts {
    fn from_iter<T: IntoIterator<Item = (String, Ty)>>(all: T) -> Parts {
        let all: Vec<(String, Ty)> = all.into_iter().collect();
        let mut by_name = BTreeMap::new();
        for (at, (name, _)) in all.iter().enumerate() {
            by_name.entry(name.to_ascii_uppercase()).or_insert(at);
        }
        Parts { all, by_name, layout: OnceLock::new() }
    }
}

/// How something refers to a variable.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Refers {
    /// `POINTER TO`: `p^` is the variable.
    Pointer,
    /// `REFERENCE TO`: its name is the variable.
    Reference,
    /// An interface: its name stands for the instance.
    Interface,
}

/// What is told where a time is a number of another type.
pub(super) const ANY_UNIT: &str =
    "a time as a number of another type, in milliseconds or seconds: any value";

/// The most characters of a text that is declared without a length: 80 with CODESYS, 126 with matiec, 254 with Siemens.
pub(super) const TEXT: u32 = 254;

/// The same where the length is declared, and is no constant.
const LONGEST_TEXT: u32 = 65_535;

/// How deep types may stand in each other.
const DEPTH: u32 = 40;

/// The elementary type of a name.
pub(super) fn elementary(name: &str) -> Option<Ty> {
    let whole = |bits, signed| Ty::Number(Kind::Whole { bits, signed });
    Some(match name.to_ascii_uppercase().as_str() {
        "BOOL" | "BIT" => Ty::Bit,
        "SINT" => whole(8, true),
        "INT" => whole(16, true),
        "DINT" => whole(32, true),
        "LINT" => whole(64, true),
        "USINT" | "BYTE" | "CHAR" => whole(8, false),
        "UINT" | "WORD" | "WCHAR" => whole(16, false),
        "UDINT" | "DWORD" => whole(32, false),
        "ULINT" | "LWORD" => whole(64, false),
        "REAL" => Ty::Number(Kind::Real),
        "LREAL" => Ty::Number(Kind::Opaque(4)),
        "TIME" => Ty::Number(Kind::Time),
        "LTIME" | "DATE" | "DT" | "DATE_AND_TIME" | "TOD" | "TIME_OF_DAY" | "LDATE" | "LDT"
        | "LTOD" => Ty::Number(Kind::Opaque(4)),
        "STRING" | "WSTRING" => Ty::Text(TEXT),
        _ => return None,
    })
}

/// The standard's function blocks: name, inputs, outputs, and what they remember.
const BLOCKS: &[(&str, &[(&str, &str)])] = &[
    ("TON", TIMER),
    ("TOF", TIMER),
    ("TP", TIMER),
    (
        "CTU",
        &[
            ("CU", "BOOL"),
            ("R", "BOOL"),
            ("PV", "INT"),
            ("Q", "BOOL"),
            ("CV", "INT"),
            ("was", "BOOL"),
        ],
    ),
    (
        "CTD",
        &[
            ("CD", "BOOL"),
            ("LD", "BOOL"),
            ("PV", "INT"),
            ("Q", "BOOL"),
            ("CV", "INT"),
            ("was", "BOOL"),
        ],
    ),
    (
        "CTUD",
        &[
            ("CU", "BOOL"),
            ("CD", "BOOL"),
            ("R", "BOOL"),
            ("LD", "BOOL"),
            ("PV", "INT"),
            ("QU", "BOOL"),
            ("QD", "BOOL"),
            ("CV", "INT"),
            ("was", "BOOL"),
            ("was_down", "BOOL"),
        ],
    ),
    ("R_TRIG", &[("CLK", "BOOL"), ("Q", "BOOL"), ("was", "BOOL")]),
    ("F_TRIG", &[("CLK", "BOOL"), ("Q", "BOOL"), ("was", "BOOL")]),
    ("SR", &[("S1", "BOOL"), ("R", "BOOL"), ("Q1", "BOOL")]),
    ("RS", &[("S", "BOOL"), ("R1", "BOOL"), ("Q1", "BOOL")]),
];
const TIMER: &[(&str, &str)] =
    &[("IN", "BOOL"), ("PT", "TIME"), ("Q", "BOOL"), ("ET", "TIME"), ("was", "BOOL")];

/// Inputs that go by two names: block, the second name, the first.
const SECOND_NAMES: &[(&str, &str, &str)] = &[
    ("SR", "SET1", "S1"),
    ("SR", "RESET", "R"),
    ("RS", "SET", "S"),
    ("RS", "RESET1", "R1"),
    ("CTU", "RESET", "R"),
    ("CTD", "LOAD", "LD"),
    ("CTUD", "RESET", "R"),
    ("CTUD", "LOAD", "LD"),
];

/// The name under which a part of a standard block is kept.
pub(super) fn first_name<'n>(kind: &str, name: &'n str) -> &'n str {
    let is = |(block, second, _): &&(&str, &str, &str)| *block == kind && same(second, name);
    SECOND_NAMES.iter().find(is).map_or(name, |(_, _, first)| first)
}

fn standard(name: &str) -> Option<Ty> {
    let (name, parts) = BLOCKS.iter().find(|(own, _)| same(own, name))?;
    let parts = parts.iter().filter_map(|(part, of)| Some(((*part).to_owned(), elementary(of)?)));
    Some(Ty::Standard(name, Arc::new(parts.collect())))
}

/// Whether the standard has a block of this name.
pub(super) fn is_standard(name: &str) -> bool {
    BLOCKS.iter().any(|(own, _)| same(own, name))
}

/// The types of a project.
pub(super) struct Types<'p> {
    project: &'p Project,
    pub(super) constants: Constants<'p>,
    /// The variables that hide global names where a type is written, the innermost first.
    scope: Vec<&'p [Variable]>,
    depth: u32,
    /// By unit: what an instance of it holds.
    known: BTreeMap<usize, Held>,
    /// Declared types, by their names in capitals.
    named: BTreeMap<String, Ty>,
}

/// What an instance of a unit holds.
#[derive(Clone)]
struct Held {
    parts: Arc<Parts>,
    /// How many instances of blocks these are, the instance itself among them.
    instances: u64,
}

impl<'p> Types<'p> {
    pub(super) fn new(project: &'p Project) -> Types<'p> {
        let constants = Constants::new(project);
        Types {
            project,
            constants,
            scope: Vec::new(),
            depth: 0,
            known: BTreeMap::new(),
            named: BTreeMap::new(),
        }
    }

    /// Does something where these variables hide global names, and no others do.
    fn scoped<T>(&mut self, scope: Vec<&'p [Variable]>, act: impl FnOnce(&mut Self) -> T) -> T {
        let around = std::mem::replace(&mut self.scope, scope);
        let done = act(self);
        self.scope = around;
        done
    }

    /// Does something as it is meant in a unit, or in one of its methods.
    pub(super) fn within<T>(
        &mut self,
        unit: usize,
        method: Option<&'p Pou>,
        act: impl FnOnce(&mut Self) -> T,
    ) -> T {
        let units = lineage(self.project, unit);
        let all = method.into_iter().chain(units).map(|pou| &pou.variables[..]).collect();
        self.scoped(all, act)
    }

    /// The type that a reference means.
    pub(super) fn resolve(&mut self, of: &TypeRef, line: u32) -> Result<Ty, Fault> {
        if self.depth >= DEPTH {
            return Err(Fault::new(line, "types stand in each other without an end")
                .code(Code::UnknownType));
        }
        self.depth += 1;
        let found = self.resolve_here(of, line);
        self.depth -= 1;
        found
    }

    fn resolve_here(&mut self, of: &TypeRef, line: u32) -> Result<Ty, Fault> {
        match of {
            TypeRef::Text(None) => Ok(Ty::Text(TEXT)),
            TypeRef::Text(Some(length)) => {
                let known = self.constant(length).and_then(|one| u32::try_from(one).ok());
                Ok(Ty::Text(known.unwrap_or(LONGEST_TEXT)))
            }
            TypeRef::Pointer(of) => {
                Ok(Ty::Reference(Refers::Pointer, Arc::new(self.with_numbers(of))))
            }
            TypeRef::Reference(of) => {
                Ok(Ty::Reference(Refers::Reference, Arc::new(self.with_numbers(of))))
            }
            TypeRef::Enumeration(_, base) => match base {
                Some(base) => self.resolve(base, line),
                None => Ok(Ty::Number(INT)),
            },
            TypeRef::Subrange(of, ..) => self.resolve(of, line),
            TypeRef::Struct(parts) => {
                self.parts(parts.iter()).map(|parts| Ty::Parts(Arc::new(parts)))
            }
            TypeRef::Array(dimensions, of) => {
                let bound = |one: &Expr| {
                    let known = self.constant(one);
                    known.ok_or_else(|| {
                        Fault::new(line, "an array's bound is no constant").code(Code::UnknownType)
                    })
                };
                let bounds = dimensions
                    .iter()
                    .map(|(low, high)| Ok((bound(low)?, bound(high)?)))
                    .collect::<Result<Vec<_>, Fault>>()?;
                if bounds.iter().any(|(low, high)| low > high) {
                    return Err(
                        Fault::new(line, "an array ends before it begins").code(Code::UnknownType)
                    );
                }
                Ok(Ty::Array { dimensions: bounds.into(), of: Arc::new(self.resolve(of, line)?) })
            }
            TypeRef::Named(name) => self.named(name, line),
        }
    }

    fn named(&mut self, name: &str, line: u32) -> Result<Ty, Fault> {
        if let Some(found) = elementary(name) {
            return Ok(found);
        }
        if let Some(known) = self.named.get(&name.to_ascii_uppercase()) {
            return Ok(known.clone());
        }
        let block = |pou: &Pou| same(&pou.name, name) && pou.kind == PouKind::FunctionBlock;
        if let Some(at) = self.project.pous.iter().position(block) {
            return self.instance(at).map(|parts| Ty::Block(at, parts));
        }
        let interface = |pou: &Pou| same(&pou.name, name) && pou.kind == PouKind::Interface;
        if let Some(own) = self.project.pous.iter().find(|pou| interface(pou)) {
            let of = TypeRef::Named(own.name.clone());
            return Ok(Ty::Reference(Refers::Interface, Arc::new(of)));
        }
        if let Some(own) = self.project.types.iter().find(|one| same(&one.name, name)) {
            // Bases that are declared gave it their parts when all files were read.
            if let Some(base) = &own.extends {
                return Err(unknown_base(&own.name, base, line));
            }
            let found = self.scoped(Vec::new(), |types| types.resolve(&own.of, line))?;
            self.named.insert(name.to_ascii_uppercase(), found.clone());
            return Ok(found);
        }
        standard(name).ok_or_else(|| {
            Fault::new(line, format!("the type {name} is not known"))
                .code(Code::UnknownType)
                .text(name)
                .help(declare("give the file that declares it", name))
        })
    }

    /// A type with numbers for the constants in it: what it means wherever it is looked at.
    fn with_numbers(&self, of: &TypeRef) -> TypeRef {
        let number = |one: &Expr| match self.constant(one) {
            Some(known) => Expr::Literal(Literal::Int(known.into(), None)),
            None => one.clone(),
        };
        let inner = |of: &TypeRef| Box::new(self.with_numbers(of));
        match of {
            TypeRef::Array(dimensions, of) => {
                let bounds = dimensions.iter().map(|(low, high)| (number(low), number(high)));
                TypeRef::Array(bounds.collect(), inner(of))
            }
            TypeRef::Text(Some(length)) => TypeRef::Text(Some(Box::new(number(length)))),
            TypeRef::Pointer(of) => TypeRef::Pointer(inner(of)),
            TypeRef::Reference(of) => TypeRef::Reference(inner(of)),
            other => other.clone(),
        }
    }

    fn parts<'v>(&mut self, all: impl Iterator<Item = &'v Variable>) -> Result<Parts, Fault> {
        all.map(|one| Ok((one.name.clone(), self.resolve(&one.of, one.line)?))).collect()
    }

    /// What an instance of a unit holds: its variables, those of the units that it extends first.
    pub(super) fn instance(&mut self, at: usize) -> Result<Arc<Parts>, Fault> {
        if let Some(known) = self.known.get(&at) {
            return Ok(known.parts.clone());
        }
        let units = lineage(self.project, at);
        for unit in &units {
            // Without what it inherits, its calls and copies would cost too little.
            if let Some(base) =
                unit.extends.as_ref().filter(|base| self.project.pou(base).is_none())
            {
                return Err(unknown_base(&unit.name, base, unit.line));
            }
        }
        let mut all = Vec::new();
        for number in (0..units.len()).rev() {
            let scope = units[number..].iter().map(|pou| &pou.variables[..]).collect();
            let kept = units[number].variables.iter().filter(|one| is_kept(one));
            all.extend(self.scoped(scope, |types| types.parts(kept))?.all);
        }
        let parts = Arc::new(Parts::from_iter(all));
        let within = parts.iter().map(|(_, ty)| self.instances(ty));
        let instances = within.fold(1, u64::saturating_add);
        self.known.insert(at, Held { parts: parts.clone(), instances });
        Ok(parts)
    }

    /// How many instances of units' blocks a variable of this type holds. Few lines declare millions, if each block has
    /// two of the one before.
    pub(super) fn instances(&self, ty: &Ty) -> u64 {
        match ty {
            Ty::Block(at, _) => self.known.get(at).map_or(1, |held| held.instances),
            Ty::Array { dimensions, of } => {
                let counts = dimensions.iter().map(|(low, high)| high.abs_diff(low - 1));
                counts.fold(self.instances(of), u64::saturating_mul)
            }
            Ty::Parts(parts) => {
                parts.iter().map(|(_, of)| self.instances(of)).fold(0, u64::saturating_add)
            }
            _ => 0,
        }
    }

    /// What a function holds, or a method of a unit.
    pub(super) fn variables(
        &mut self,
        unit: usize,
        method: Option<&'p Pou>,
    ) -> Result<Arc<Parts>, Fault> {
        let pou = method.unwrap_or(&self.project.pous[unit]);
        self.within(unit, method, |types| {
            let mut parts = types.parts(pou.variables.iter().filter(|one| is_kept(one)))?.all;
            if let Some(result) = &pou.result {
                parts.push((pou.result_name().to_owned(), types.resolve(result, pou.line)?));
            }
            Ok(Arc::new(parts.into_iter().collect()))
        })
    }

    /// The type of a global variable of a list.
    pub(super) fn of_global(
        &mut self,
        list: &str,
        all: &'p [Variable],
        one: &Variable,
    ) -> Result<Ty, Fault> {
        let scope = if list.is_empty() { Vec::new() } else { vec![all] };
        self.scoped(scope, |types| types.resolve(&one.of, one.line))
    }

    /// A whole number that is known as it stands.
    pub(super) fn constant(&self, one: &Expr) -> Option<i64> {
        self.constants.number(one, &self.scope)
    }

    /// The number of the first value of an enumeration, which variables of it begin with unless its declaration says another.
    pub(super) fn first_named(&self, of: &TypeRef) -> Option<i64> {
        match of {
            TypeRef::Enumeration(values, _) => match values.first()? {
                (_, Some(number)) => self.constant(number),
                (_, None) => Some(0),
            },
            TypeRef::Named(name) => {
                let own = self.project.types.iter().find(|one| same(&one.name, name))?;
                let is_one = matches!(own.of, TypeRef::Enumeration(..)) && own.initial.is_none();
                is_one.then(|| self.first_named(&own.of))?
            }
            _ => None,
        }
    }

    /// The number of an enumeration's value, or of a global constant.
    pub(super) fn named_constant(&self, name: &str) -> Option<i64> {
        self.constants.named(name)
    }
}

/// Whether a variable takes memory of its instance; globals that it names and constants do not.
fn is_kept(one: &Variable) -> bool {
    one.section != scanbound_iec::Section::External && !one.name.is_empty()
}

/// Whether a variable's type is one of the standard's own, which begin with 0. An enumeration begins with its first value,
/// and a type of the project's with what that says.
pub(super) fn is_elementary(variable: &Variable) -> bool {
    matches!(&variable.of, TypeRef::Named(name) if elementary(name).is_some())
}

/// The help for a name that the project does not declare: what else may be wrong, and what to do where a library has it.
pub(super) fn declare(first: &str, name: &str) -> String {
    format!(
        "{first}; of what a library has, declare inputs and outputs without a body, and state its time in a facts file (--facts): [calls] {} = {{ time = \"50us\" }}",
        key(name)
    )
}

/// What an operand moves besides what its load is charged.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Extent {
    /// No more: it is one elementary value.
    One,
    /// So many elements of a structure, an array or an instance.
    Elements(u64),
    /// So many characters.
    Characters(u64),
}

impl Extent {
    /// One of two of which it is not told which is meant.
    pub(super) fn larger(self, other: Extent) -> Extent {
        use Extent::{Characters, Elements, One};
        match (self, other) {
            (One, other) | (other, One) => other,
            (Characters(one), Characters(two)) => Characters(one.max(two)),
            (Characters(one) | Elements(one), Characters(two) | Elements(two)) => {
                Elements(one.max(two))
            }
        }
    }

    pub(super) fn and(self, other: Extent) -> Extent {
        use Extent::{Characters, Elements, One};
        match (self, other) {
            (One, other) | (other, One) => other,
            (Characters(one), Characters(two)) => Characters(one.saturating_add(two)),
            (Characters(one) | Elements(one), Characters(two) | Elements(two)) => {
                Elements(one.saturating_add(two))
            }
        }
    }
}

fn unknown_base(name: &str, base: &str, line: u32) -> Fault {
    Fault::new(line, format!("{name} extends {base}, which is not known"))
        .code(Code::UnknownType)
        .text(base)
        .help("give the file that declares it")
}

/// A unit and those that it extends, the last the first of all.
pub(super) fn lineage(project: &Project, at: usize) -> Vec<&Pou> {
    let mut found = vec![&project.pous[at]];
    while let Some(base) = found.last().and_then(|pou| project.pou(pou.extends.as_ref()?)) {
        if found.iter().any(|own| same(&own.name, &base.name)) {
            break;
        }
        found.push(base);
    }
    found
}

/// Whether two types are the same.
pub(super) fn same_type(one: &Ty, other: &Ty) -> bool {
    let parts = |one: &[(String, Ty)], other: &[(String, Ty)]| {
        one.len() == other.len()
            && one
                .iter()
                .zip(other)
                .all(|((name, ty), (own, of))| same(name, own) && same_type(ty, of))
    };
    match (one, other) {
        (Ty::Bit, Ty::Bit) | (Ty::Text(_), Ty::Text(_)) => true,
        (Ty::Number(one), Ty::Number(other)) => one == other,
        (Ty::Array { dimensions, of }, Ty::Array { dimensions: own, of: also }) => {
            dimensions == own && same_type(of, also)
        }
        (Ty::Parts(one), Ty::Parts(other)) => parts(one, other),
        (Ty::Standard(one, _), Ty::Standard(other, _)) => one == other,
        (Ty::Block(one, _), Ty::Block(other, _)) => one == other,
        (Ty::Reference(kind, of), Ty::Reference(own, also)) => kind == own && of == also,
        _ => false,
    }
}

/// How a type is laid out.
pub(super) fn layout(ty: &Ty) -> Type {
    match ty {
        Ty::Bit => Type::Bit,
        Ty::Number(kind) => Type::Words(kind.words()),
        // One word stands for what is not followed.
        Ty::Text(_) | Ty::Reference(..) => Type::Words(1),
        Ty::Array { dimensions, of } => {
            dimensions.iter().rev().fold(layout(of), |of, (low, high)| {
                let count = u32::try_from(high - low + 1).unwrap_or(u32::MAX);
                Type::Array { first: *low, count, of: Arc::new(of) }
            })
        }
        Ty::Parts(parts) | Ty::Standard(_, parts) | Ty::Block(_, parts) => {
            let all = || parts.iter().map(|(name, of)| (name.clone(), layout(of))).collect();
            Type::Parts(parts.layout.get_or_init(|| Arc::new(all())).clone())
        }
    }
}
