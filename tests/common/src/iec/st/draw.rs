//! Draws random expressions and statements.

mod statements;

use super::tree::{
    Access, Argument, COLOURS, Call, Expr, Kind, NUMBERS, Number, Place, Project, Root, Routine,
    Section, Step, Target, Ty, Variable,
};
use crate::iec::generate::Dice;

/// What a program may be made of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Feature {
    Objects,
    Pointers,
    References,
    Addresses,
    Shadows,
    Reals,
    Times,
    Texts,
    Timers,
    Enables,
    Written,
    Shared,
    Wide,
    Parts,
    Handed,
    Loops,
}

/// What code calls at most, so that nothing calls itself.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Rank {
    Function,
    Run,
    Level,
    Twist,
    Action,
    Body,
    Late,
    Program,
}

/// What the statements of a unit can name.
#[derive(Debug, Clone)]
pub struct Scope {
    pub rank: Rank,
    /// The block whose code it is.
    pub block: Option<usize>,
    /// Variables, and whether they may be written.
    pub roots: Vec<(Place, bool)>,
    /// Variables for loops, which nothing else writes.
    pub counters: Vec<Place>,
    /// The functions that may be called: those before this one.
    pub functions: usize,
    pub in_loop: bool,
    /// How many calls may still be drawn.
    pub calls: usize,
}

pub struct Draw<'d> {
    pub dice: &'d mut Dice,
    pub features: Vec<Feature>,
    /// The types of numbers that the project has.
    pub numbers: Vec<Number>,
}

pub fn number_expr(value: i128, ty: &Ty) -> Expr {
    Expr { ty: ty.clone(), kind: Kind::Number(value, false, 10) }
}

pub fn read(place: Place) -> Expr {
    Expr { ty: place.ty.clone(), kind: Kind::Read(place) }
}

fn binary(operator: &'static str, one: Expr, two: Expr, ty: Ty) -> Expr {
    Expr { ty, kind: Kind::Binary(operator, Box::new(one), Box::new(two)) }
}

fn standard(name: &str, given: Vec<Expr>, ty: Ty) -> Expr {
    Expr { ty, kind: Kind::Standard(name.to_owned(), given) }
}

/// Whether values of one type become those of the other by themselves.
fn widens(from: Number, to: Number) -> bool {
    from.bits < to.bits
        && from.is_bits == to.is_bits
        && (from.signed == to.signed || !from.signed && !from.is_bits)
}

impl Draw<'_> {
    pub fn has(&self, feature: Feature) -> bool {
        self.features.contains(&feature)
    }

    fn small(&mut self, most: usize) -> i128 {
        i128::try_from(self.dice.below(most)).expect("small")
    }

    pub fn number(&mut self) -> Ty {
        Ty::Number(self.dice.one(&self.numbers))
    }

    /// A type of numbers that are counted with.
    pub fn counted(&mut self) -> Ty {
        let fits = |one: &Number| !one.is_bits && (one.bits < 32 || one.bits == 32 && one.signed);
        let all: Vec<Number> = self.numbers.iter().copied().filter(fits).collect();
        Ty::Number(self.dice.one(&all))
    }

    /// A type of one value.
    pub fn simple(&mut self) -> Ty {
        match self.dice.below(12) {
            0..=3 => Ty::Bool,
            4 => Ty::Colour,
            5 if self.has(Feature::Reals) => Ty::Real,
            6 if self.has(Feature::Times) => Ty::Time,
            7 if self.has(Feature::Texts) => Ty::Text,
            _ => self.number(),
        }
    }

    pub fn literal(&mut self, ty: &Ty) -> Expr {
        let kind = match ty {
            Ty::Bool => Kind::Bool(self.dice.chance(2)),
            Ty::Real => {
                let halves = i16::try_from(self.dice.below(24)).expect("small") - 4;
                Kind::Real(f32::from(halves) / 2.0)
            }
            Ty::Time => Kind::Time(self.small(40)),
            Ty::Text => Kind::Text(self.dice.one(&["", "a", "b", "ab"])),
            Ty::Colour => Kind::Colour(self.dice.below(COLOURS.len())),
            Ty::Number(of) => {
                let value = match self.dice.below(8) {
                    0 => self.small(1 << 20) * if of.bits == 64 { 1 << 30 } else { 1 },
                    1 if of.signed => -self.small(9),
                    _ => self.small(8),
                };
                let value = of.keep(value);
                let value = if (-(1 << 62)..=1 << 62).contains(&value) { value } else { 3 };
                let base = self.dice.one(&[10, 10, 10, 16, 2]);
                Kind::Number(value, self.dice.chance(4), base)
            }
            other => panic!("{other:?}"),
        };
        Expr { ty: ty.clone(), kind }
    }

    /// A literal that has its type by itself.
    fn typed_literal(&mut self, ty: &Ty) -> Expr {
        let mut one = self.literal(ty);
        if let Kind::Number(_, typed, _) = &mut one.kind {
            *typed = true;
        }
        one
    }

    /// An index of an array's dimension.
    fn index(&mut self, project: &Project, scope: &Scope, low: i128, high: i128) -> Expr {
        let int = Ty::int();
        if self.dice.chance(2) {
            return number_expr(
                low + self.small(usize::try_from(high - low + 1).expect("small")),
                &int,
            );
        }
        let Some(own) = self.find(project, scope, &int, false, 0) else {
            return number_expr(low, &int);
        };
        let given = vec![number_expr(low, &int), read(own), number_expr(high, &int)];
        standard("LIMIT", given, int)
    }

    /// Goes on from a variable to a part of a type, or gives up. `depth`: whether indices may be worked out.
    fn descend(
        &mut self,
        project: &Project,
        scope: &Scope,
        mut place: Place,
        mut writes: bool,
        (want, needs, depth): (&Ty, bool, usize),
    ) -> Option<Place> {
        for _ in 0..5 {
            if place.ty == *want && (writes || !needs) {
                return Some(place);
            }
            match place.ty.clone() {
                Ty::Array(dimensions, of) => {
                    let indices = dimensions
                        .iter()
                        .map(|&(low, high)| match depth {
                            0 => {
                                let many = usize::try_from(high - low + 1).expect("small");
                                number_expr(low + self.small(many), &Ty::int())
                            }
                            _ => self.index(project, scope, low, high),
                        })
                        .collect();
                    place = place.then(Step::Element(indices), (*of).clone());
                }
                Ty::Struct(of) => {
                    let all = project.parts(of);
                    let one = all[self.dice.below(all.len())];
                    place = place.then(Step::Part(one.name.clone()), one.ty.clone());
                }
                Ty::Standard(kind) => {
                    let pins: &[&'static str] = match kind {
                        "SR" | "RS" => &["Q1"],
                        "CTU" | "CTD" => &["Q", "CV"],
                        "CTUD" => &["QU", "QD", "CV"],
                        _ => &["Q"],
                    };
                    let name = self.dice.one(pins);
                    let ty = if name == "CV" { Ty::int() } else { Ty::Bool };
                    place = place.then(Step::Pin(name), ty);
                    writes = false;
                }
                Ty::Block(of) => {
                    let lineage = project.lineage(of);
                    let block = self.dice.one(&lineage);
                    let all: Vec<usize> = (0..project.blocks[block].variables.len())
                        .filter(|&at| {
                            let section = project.blocks[block].variables[at].section;
                            matches!(section, Section::Input | Section::Output)
                        })
                        .collect();
                    if all.is_empty() {
                        return None;
                    }
                    let at = self.dice.one(&all);
                    let variable = &project.blocks[block].variables[at];
                    writes = writes && variable.section == Section::Input;
                    let ty = match &variable.ty {
                        Ty::Reference(of) => (**of).clone(),
                        other => other.clone(),
                    };
                    place = place.then(Step::Member(block, at), ty);
                }
                Ty::Pointer(of) => {
                    place = place.then(Step::Dereference, (*of).clone());
                    writes = true;
                }
                Ty::Number(of)
                    if *want == Ty::Bool
                        && of.is_bits
                        && !matches!(place.root, Root::Address(_)) =>
                {
                    let bit = self.dice.below(usize::try_from(of.bits).expect("small"));
                    place = place.then(Step::Bit(u32::try_from(bit).expect("small")), Ty::Bool);
                }
                _ => return None,
            }
        }
        None
    }

    /// A variable of a type, or a part of one.
    pub fn find(
        &mut self,
        project: &Project,
        scope: &Scope,
        want: &Ty,
        needs: bool,
        depth: usize,
    ) -> Option<Place> {
        for _ in 0..12 {
            if scope.roots.is_empty() {
                return None;
            }
            let (place, writes) = self.dice.one(&scope.roots);
            let found = self.descend(project, scope, place, writes, (want, needs, depth));
            if found.is_some() {
                return found;
            }
        }
        None
    }

    /// What may be handed by reference: a variable of this type.
    fn handed(&mut self, project: &Project, scope: &Scope, want: &Ty) -> Option<Place> {
        // An instance is rarely passed in part: it must not be passed as a whole then. What is called rarely reaches
        // what it is passed by another name.
        let (parts, aliases) = (self.dice.chance(30), self.dice.chance(4));
        for _ in 0..8 {
            let found = self.find(project, scope, want, true, 1)?;
            let fits = |step: &Step| match step {
                Step::Bit(_) => false,
                Step::Member(..) => parts,
                Step::Dereference => aliases,
                _ => true,
            };
            let declared = match found.root {
                Root::Global(at) => &project.globals[at],
                Root::Member(block, at) => &project.blocks[block].variables[at],
                Root::Local(_) if found.steps.iter().all(fits) => return Some(found),
                _ => continue,
            };
            let is_plain =
                matches!(found.root, Root::Member(..)) && !matches!(declared.ty, Ty::Reference(_));
            if declared.at.is_none() && (is_plain || aliases) && found.steps.iter().all(fits) {
                return Some(found);
            }
        }
        None
    }

    /// An instance of a block that may be named here.
    fn instance(
        &mut self,
        project: &Project,
        scope: &Scope,
        fits: &dyn Fn(&Ty) -> bool,
    ) -> Option<Place> {
        for _ in 0..8 {
            if scope.roots.is_empty() {
                return None;
            }
            let (mut place, _) = self.dice.one(&scope.roots);
            loop {
                if fits(&place.ty) {
                    return Some(place);
                }
                match place.ty.clone() {
                    Ty::Array(dimensions, of) => {
                        let indices = dimensions
                            .iter()
                            .map(|&(low, high)| self.index(project, scope, low, high));
                        let indices = indices.collect();
                        place = place.then(Step::Element(indices), (*of).clone());
                    }
                    Ty::Pointer(of) => place = place.then(Step::Dereference, (*of).clone()),
                    _ => break,
                }
            }
        }
        None
    }

    /// The arguments of a call; nothing where one cannot be had. `all`: no input may be left out.
    fn arguments(
        &mut self,
        project: &Project,
        scope: &Scope,
        variables: &[Variable],
        all: bool,
    ) -> Option<Vec<(String, Argument)>> {
        let mut given = Vec::new();
        for one in variables {
            let argument = match (one.section, &one.ty) {
                (Section::Input, Ty::Reference(of)) => {
                    Argument::InOut(self.handed(project, scope, of)?)
                }
                (Section::InOut, of) => Argument::InOut(self.handed(project, scope, of)?),
                (Section::Input, _) if !all && self.dice.chance(3) => continue,
                (Section::Input, Ty::Pointer(of)) => {
                    let place = self.handed(project, scope, of)?;
                    Argument::In(Expr { ty: one.ty.clone(), kind: Kind::Address(place) })
                }
                (Section::Input, Ty::Interface) => Argument::In(self.meant(project, scope)?),
                (Section::Input, of) if of.is_simple() => {
                    Argument::In(self.value(project, scope, of, 1))
                }
                (Section::Output, of) if self.dice.chance(2) => {
                    match self.find(project, scope, of, true, 1) {
                        Some(place) => Argument::Out(place),
                        None => continue,
                    }
                }
                _ => continue,
            };
            given.push((one.name.clone(), argument));
        }
        Some(given)
    }

    /// What an interface can mean: an instance, or what another one means.
    fn meant(&mut self, project: &Project, scope: &Scope) -> Option<Expr> {
        let fits = |ty: &Ty| match ty {
            Ty::Interface => true,
            Ty::Block(of) => {
                project.lineage(*of).iter().any(|&one| project.blocks[one].has_interface)
            }
            _ => false,
        };
        let place = self.instance(project, scope, &fits)?;
        Some(Expr { ty: Ty::Interface, kind: Kind::Read(place) })
    }

    /// A call of a function of the project's with a result of this type, or of any.
    fn function(&mut self, project: &Project, scope: &Scope, result: Option<&Ty>) -> Option<Call> {
        let fits = |at: &usize| match result {
            Some(of) => project.functions[*at].result.as_ref() == Some(of),
            None => true,
        };
        let all: Vec<usize> = (0..scope.functions).filter(fits).collect();
        if all.is_empty() {
            return None;
        }
        let at = self.dice.one(&all);
        let own = &project.functions[at];
        self.routine(project, scope, own, Target::Function(at))
    }

    fn routine(
        &mut self,
        project: &Project,
        scope: &Scope,
        own: &Routine,
        target: Target,
    ) -> Option<Call> {
        let unnamed = self.dice.chance(3);
        let mut given = self.arguments(project, scope, &own.variables, unnamed)?;
        if unnamed {
            given.retain(|one| !matches!(one.1, Argument::Out(_)));
        }
        Some(Call { target, given, unnamed, enable: None })
    }

    /// A call of a method of an instance, or of the one whose code it is.
    fn method(&mut self, project: &Project, scope: &Scope, name: &'static str) -> Option<Call> {
        let (own_rank, block) = (if name == "Run" { Rank::Run } else { Rank::Twist }, scope.block);
        if let Some(block) = block
            && scope.rank > own_rank
            && self.dice.chance(2)
        {
            let (_, own) = project.method(block, name)?;
            return self.routine(project, scope, own, Target::Method(None, name));
        }
        if scope.rank < Rank::Body {
            return None;
        }
        let fits = |ty: &Ty| match ty {
            Ty::Interface => name == "Run",
            Ty::Block(of) => project.method(*of, name).is_some(),
            _ => false,
        };
        let place = self.instance(project, scope, &fits)?;
        let block = match place.ty {
            Ty::Block(of) => of,
            _ => 0,
        };
        let (_, own) = project.method(block, name)?;
        self.routine(project, scope, own, Target::Method(Some(place), name))
    }

    /// An instance with the property, or the one whose code it is.
    fn with_level(&mut self, project: &Project, scope: &Scope) -> Option<Option<Place>> {
        if let Some(block) = scope.block
            && scope.rank > Rank::Level
            && project.property(block, "Level", Access::Get).is_some()
            && self.dice.chance(2)
        {
            return Some(None);
        }
        if scope.rank < Rank::Body {
            return None;
        }
        let fits = |ty: &Ty| match ty {
            Ty::Interface => true,
            Ty::Block(of) => project.property(*of, "Level", Access::Get).is_some(),
            _ => false,
        };
        self.instance(project, scope, &fits).map(Some)
    }

    /// An expression of a type. Literals stand only beside what has a type of its own.
    pub fn value(&mut self, project: &Project, scope: &Scope, ty: &Ty, depth: usize) -> Expr {
        if depth == 0 || self.dice.chance(3) {
            return match self.find(project, scope, ty, false, depth) {
                Some(place) => read(place),
                None => self.typed_literal(ty),
            };
        }
        match ty {
            Ty::Bool => self.truth(project, scope, depth),
            Ty::Number(of) => self.whole(project, scope, *of, depth),
            Ty::Colour | Ty::Text => {
                let given = vec![
                    self.value(project, scope, &Ty::Bool, depth - 1),
                    self.value(project, scope, ty, 0),
                    self.value(project, scope, ty, 0),
                ];
                standard("SEL", given, ty.clone())
            }
            Ty::Time => {
                let one = self.value(project, scope, ty, depth - 1);
                let two = self.beside(project, scope, ty, 0);
                binary(self.dice.one(&["+", "-"]), one, two, Ty::Time)
            }
            Ty::Real => {
                let from = [Ty::int(), Ty::named("SINT")];
                if self.dice.chance(3) {
                    let from = self.dice.one(&from);
                    let name = format!("{}_TO_REAL", from.as_number().expect("a number").name);
                    return standard(&name, vec![self.value(project, scope, &from, 0)], Ty::Real);
                }
                let one = self.value(project, scope, ty, depth - 1);
                let two = self.beside(project, scope, ty, 0);
                binary(self.dice.one(&["+", "-", "*"]), one, two, Ty::Real)
            }
            other => panic!("{other:?}"),
        }
    }

    fn beside(&mut self, project: &Project, scope: &Scope, ty: &Ty, depth: usize) -> Expr {
        if self.dice.chance(2) { self.literal(ty) } else { self.value(project, scope, ty, depth) }
    }

    fn truth(&mut self, project: &Project, scope: &Scope, depth: usize) -> Expr {
        let deeper = depth - 1;
        match self.dice.below(9) {
            0 => {
                let inner = self.value(project, scope, &Ty::Bool, deeper);
                Expr { ty: Ty::Bool, kind: Kind::Not(Box::new(inner)) }
            }
            1..=3 => {
                let of = self.simple();
                let of = if of == Ty::Bool { self.number() } else { of };
                let operator = match of {
                    Ty::Colour | Ty::Text => self.dice.one(&["=", "<>"]),
                    _ => self.dice.one(&["=", "<>", "<", "<=", ">", ">="]),
                };
                let one = self.value(project, scope, &of, deeper);
                let two = match of {
                    Ty::Colour | Ty::Text => self.value(project, scope, &of, 0),
                    _ => self.beside(project, scope, &of, deeper),
                };
                binary(operator, one, two, Ty::Bool)
            }
            4 if self.has(Feature::Objects) => {
                let is = |ty: &Ty| *ty == Ty::Interface;
                match self.instance(project, scope, &is) {
                    Some(place) => {
                        let null = Expr { ty: Ty::Interface, kind: Kind::Null };
                        binary(self.dice.one(&["=", "<>"]), read(place), null, Ty::Bool)
                    }
                    None => self.value(project, scope, &Ty::Bool, deeper),
                }
            }
            5 => {
                let own = self.value(project, scope, &Ty::Bool, deeper);
                let other = self.value(project, scope, &Ty::Bool, deeper);
                let choice = self.value(project, scope, &Ty::Bool, 0);
                standard("SEL", vec![choice, own, other], Ty::Bool)
            }
            _ => {
                let all = ["AND", "OR", "XOR", "=", "<>", "AND_THEN", "OR_ELSE"];
                let operator = self.dice.one(&all);
                let one = self.value(project, scope, &Ty::Bool, deeper);
                let two = self.value(project, scope, &Ty::Bool, deeper);
                binary(operator, one, two, Ty::Bool)
            }
        }
    }

    fn whole(&mut self, project: &Project, scope: &Scope, of: Number, depth: usize) -> Expr {
        let (ty, deeper) = (Ty::Number(of), depth - 1);
        match self.dice.below(16) {
            0 if scope.calls > 0 => {
                let mut scope = scope.clone();
                scope.calls -= 1;
                match self.function(project, &scope, Some(&ty)) {
                    Some(call) => Expr { ty, kind: Kind::Call(Box::new(call)) },
                    None => self.value(project, &scope, &ty, deeper),
                }
            }
            1 | 2 if scope.calls > 0 && of.name == "INT" && self.has(Feature::Objects) => {
                let mut scope = scope.clone();
                scope.calls -= 1;
                if self.dice.chance(2) {
                    return match self.with_level(project, &scope) {
                        Some(place) => Expr { ty, kind: Kind::Get(place, "Level") },
                        None => self.value(project, &scope, &ty, deeper),
                    };
                }
                match self.method(project, &scope, "Run") {
                    Some(call) => Expr { ty, kind: Kind::Call(Box::new(call)) },
                    None => self.value(project, &scope, &ty, deeper),
                }
            }
            3 => {
                let inner = self.value(project, scope, &ty, deeper);
                match (of.is_bits, of.signed) {
                    (true, _) => Expr { ty, kind: Kind::Not(Box::new(inner)) },
                    (_, true) if self.dice.chance(2) => standard("ABS", vec![inner], ty),
                    (_, true) => Expr { ty, kind: Kind::Negate(Box::new(inner)) },
                    _ => inner,
                }
            }
            4 | 5 => self.converted(project, scope, of, deeper),
            6 => {
                let from: Vec<Number> =
                    NUMBERS.iter().copied().filter(|from| widens(*from, of)).collect();
                let known: Vec<Number> =
                    from.into_iter().filter(|one| self.numbers.contains(one)).collect();
                if known.is_empty() {
                    return self.value(project, scope, &ty, deeper);
                }
                let from = self.dice.one(&known);
                let inner = self.value(project, scope, &Ty::Number(from), deeper);
                let wider = Expr { ty: ty.clone(), kind: Kind::Widen(Box::new(inner)) };
                if of.is_bits {
                    return wider;
                }
                let one = self.value(project, scope, &ty, 0);
                binary(self.dice.one(&["+", "-"]), one, wider, ty)
            }
            7 => {
                let given = vec![
                    self.value(project, scope, &Ty::Bool, deeper),
                    self.value(project, scope, &ty, deeper),
                    self.value(project, scope, &ty, deeper),
                ];
                standard("SEL", given, ty)
            }
            8 => {
                let int = Ty::int();
                let choice = self.value(project, scope, &int, 0);
                let many = 2 + self.dice.below(2);
                let most = i128::try_from(many - 1).expect("small");
                let given = vec![number_expr(0, &int), choice, number_expr(most, &int)];
                let mut all = vec![standard("LIMIT", given, int)];
                all.extend((0..many).map(|_| self.value(project, scope, &ty, deeper)));
                standard("MUX", all, ty)
            }
            _ if of.is_bits => {
                let one = self.value(project, scope, &ty, deeper);
                if self.dice.chance(2) {
                    let by = self.small(usize::try_from(of.bits).expect("small"));
                    let by = number_expr(by, &Ty::int());
                    return standard(
                        self.dice.one(&["SHL", "SHR", "ROL", "ROR"]),
                        vec![one, by],
                        ty,
                    );
                }
                let two = self.beside(project, scope, &ty, deeper);
                binary(self.dice.one(&["AND", "OR", "XOR"]), one, two, ty)
            }
            9 | 10 => {
                let one = self.value(project, scope, &ty, deeper);
                let by = number_expr(self.small(5) + 1, &ty);
                binary(self.dice.one(&["*", "/", "MOD"]), one, by, ty)
            }
            11 => {
                let given = (0..2 + self.dice.below(2))
                    .map(|_| self.value(project, scope, &ty, deeper))
                    .collect();
                standard(self.dice.one(&["MIN", "MAX", "ADD"]), given, ty)
            }
            12 => {
                let one = self.value(project, scope, &ty, deeper);
                let two = self.value(project, scope, &ty, deeper);
                binary("*", one, two, ty)
            }
            _ => {
                let one = self.value(project, scope, &ty, deeper);
                let two = self.beside(project, scope, &ty, deeper);
                binary(self.dice.one(&["+", "-"]), one, two, ty)
            }
        }
    }

    fn converted(&mut self, project: &Project, scope: &Scope, of: Number, depth: usize) -> Expr {
        let ty = Ty::Number(of);
        let from = match self.dice.below(6) {
            0 => Ty::Bool,
            1 if self.has(Feature::Reals) && of.bits >= 32 && of.signed => Ty::Real,
            _ => self.number(),
        };
        if from == ty {
            return self.value(project, scope, &ty, depth);
        }
        let name = match &from {
            Ty::Bool => "BOOL",
            Ty::Real => "REAL",
            other => other.as_number().expect("a number").name,
        };
        let depth = if from == Ty::Real { 0 } else { depth };
        let inner = self.value(project, scope, &from, depth);
        standard(&format!("{name}_TO_{}", of.name), vec![inner], ty)
    }
}
