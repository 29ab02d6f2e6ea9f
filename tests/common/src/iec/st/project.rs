//! Draws random projects.

use super::draw::{Draw, Feature, Rank, Scope, read};
use super::tree::{
    Access, Block, Expr, Initial, Kind, NUMBERS, Number, Place, Project, Root, Routine, Section,
    Statement, Struct, Ty, Variable,
};
use crate::iec::generate::Dice;
use std::rc::Rc;

const FEATURES: &[Feature] = &[
    Feature::Objects,
    Feature::Pointers,
    Feature::References,
    Feature::Addresses,
    Feature::Shadows,
    Feature::Reals,
    Feature::Times,
    Feature::Texts,
    Feature::Timers,
    Feature::Enables,
    Feature::Written,
    Feature::Shared,
    Feature::Wide,
    Feature::Parts,
    Feature::Handed,
    Feature::Loops,
];

fn array(low: i128, high: i128, of: Ty) -> Ty {
    Ty::Array(Rc::from([(low, high)]), Rc::new(of))
}

struct Builder<'d> {
    draw: Draw<'d>,
    project: Project,
}

/// A random project.
pub fn project(dice: &mut Dice) -> Project {
    let features: Vec<Feature> = FEATURES.iter().copied().filter(|_| dice.chance(2)).collect();
    let mut numbers: Vec<Number> = vec![NUMBERS[1]];
    for one in NUMBERS {
        let is_wide = one.bits > 32;
        let often = if is_wide && !features.contains(&Feature::Wide) { 100 } else { 3 };
        if one.name != "INT" && dice.chance(often) {
            numbers.push(*one);
        }
    }
    let project = Project {
        structs: Vec::new(),
        globals: Vec::new(),
        functions: Vec::new(),
        blocks: Vec::new(),
    };
    let mut builder = Builder { draw: Draw { dice, features, numbers }, project };
    builder.structs();
    builder.globals();
    builder.functions();
    builder.blocks();
    builder.late();
    builder.program();
    builder.project
}

impl Builder<'_> {
    fn has(&self, feature: Feature) -> bool {
        self.draw.has(feature)
    }

    fn chance(&mut self, of: usize) -> bool {
        self.draw.dice.chance(of)
    }

    /// A variable of one value, which may begin with one.
    fn simple(&mut self, name: &str, section: Section) -> Variable {
        let ty = self.draw.simple();
        let own = Variable::new(name, ty.clone(), section);
        if self.chance(3) { own.begins(self.draw.literal(&ty)) } else { own }
    }

    fn structs(&mut self) {
        let mut parts = vec![
            Variable::new("b", Ty::Bool, Section::Local),
            Variable::new("n", Ty::int(), Section::Local),
        ];
        if self.chance(2) {
            parts.push(self.simple("x", Section::Local));
        }
        if self.chance(2) {
            parts.push(Variable::new("f", array(0, 2, Ty::int()), Section::Local));
        }
        self.project.structs.push(Struct { name: "S", base: None, parts });
        let mut parts = vec![Variable::new("y", Ty::int(), Section::Local)];
        let extends = self.chance(2);
        if !extends {
            parts.push(Variable::new("s", Ty::Struct(0), Section::Local));
        }
        self.project.structs.push(Struct { name: "T", base: extends.then_some(0), parts });
    }

    /// Variables of many types, with names that begin so.
    fn variables(&mut self, prefix: &str, section: Section, many: usize) -> Vec<Variable> {
        let mut found = Vec::new();
        for number in 0..many {
            let name = format!("{prefix}{number}");
            let parts = self.has(Feature::Parts);
            let mut own = match self.draw.dice.below(if parts { 9 } else { 5 }) {
                5 => Variable::new(&name, Ty::Struct(0), section),
                6 => Variable::new(&name, Ty::Struct(1), section),
                7 => {
                    let of = self.draw.simple();
                    let low = self.draw.dice.one(&[0, 1, -1]);
                    let mut own = Variable::new(&name, array(low, low + 2, of.clone()), section);
                    if self.chance(3) {
                        let all = (0..3).map(|_| self.draw.literal(&of)).collect();
                        own.initial = Some(Initial::Elements(all));
                    }
                    own
                }
                8 => {
                    let of = self.draw.dice.one(&[Ty::int(), Ty::Bool, Ty::Struct(0)]);
                    let dimensions = Rc::from([(0, 1), (1, 2)]);
                    Variable::new(&name, Ty::Array(dimensions, Rc::new(of)), section)
                }
                _ => self.simple(&name, section),
            };
            if own.ty == Ty::Struct(0) && self.chance(3) {
                let int = self.draw.literal(&Ty::int());
                own.initial = Some(Initial::Parts(vec![("n".to_owned(), int)]));
            }
            found.push(own);
        }
        found
    }

    fn globals(&mut self) {
        let mut all = self.variables("g", Section::Local, 4);
        all.push(Variable::new("gn", Ty::int(), Section::Local));
        all.push(Variable::new("gb", Ty::Bool, Section::Local));
        let mut fixed = self.simple("gc", Section::Constant);
        if fixed.initial.is_none() {
            fixed = fixed.clone().begins(self.draw.literal(&fixed.ty));
        }
        all.push(fixed);
        if self.has(Feature::Addresses) {
            all.push(Variable::new("gw", Ty::named("WORD"), Section::Local).at("%MW2"));
            all.push(Variable::new("gx", Ty::Bool, Section::Local).at("%MX4.3"));
        }
        self.project.globals = all;
        // What means one of these.
        let at = |name: &str, all: &[Variable]| {
            let number = all.iter().position(|one| one.name == name).expect("a global");
            Place::new(Root::Global(number), all[number].ty.clone())
        };
        let address = |place: Place, ty: Ty| Expr { ty, kind: Kind::Address(place) };
        let int = Rc::new(Ty::int());
        if self.has(Feature::Pointers) {
            let ty = Ty::Pointer(int.clone());
            let own = address(at("gn", &self.project.globals), ty.clone());
            self.project.globals.push(Variable::new("gp", ty, Section::Local).begins(own));
        }
        if self.has(Feature::References) {
            let ty = Ty::Reference(int);
            let own = address(at("gn", &self.project.globals), ty.clone());
            self.project.globals.push(Variable::new("gr", ty, Section::Local).begins(own));
        }
    }

    /// A variable as a root of paths.
    fn root(variable: &Variable, root: Root) -> (Place, bool) {
        let ty = match &variable.ty {
            Ty::Reference(of) => (**of).clone(),
            other => other.clone(),
        };
        let is_input = variable.at.as_ref().is_some_and(|at| at.starts_with("%I"));
        (Place::new(root, ty), variable.section != Section::Constant && !is_input)
    }

    /// What code of a block, or of none, can name outside of its routine.
    fn scope(&self, rank: Rank, block: Option<usize>) -> Scope {
        let project = &self.project;
        let mut roots = Vec::new();
        if self.has(Feature::Shared) || rank > Rank::Body {
            let all = project.globals.iter().enumerate();
            roots.extend(all.map(|(at, one)| Self::root(one, Root::Global(at))));
        }
        let lineage = block.map_or(Vec::new(), |block| project.lineage(block));
        let hidden = |name: &str| {
            let names = lineage.iter().flat_map(|&one| &project.blocks[one].variables);
            { names }.any(|one| one.name == name)
        };
        roots.retain(|one: &(Place, bool)| match one.0.root {
            Root::Global(at) => !hidden(&project.globals[at].name),
            _ => true,
        });
        let mut counters = Vec::new();
        for &one in &lineage {
            for (at, variable) in project.blocks[one].variables.iter().enumerate() {
                let root = Root::Member(one, at);
                if variable.name.starts_with('i') && variable.name.len() == 2 {
                    if Some(one) == block && rank >= Rank::Body {
                        counters.push(Place::new(root, variable.ty.clone()));
                    }
                    continue;
                }
                // What is passed by reference is there in the body alone.
                let is_there = match variable.section {
                    Section::InOut | Section::Temp => rank >= Rank::Body && Some(one) == block,
                    Section::Static => Some(one) == block,
                    _ => !matches!(variable.ty, Ty::Interface) || rank >= Rank::Body,
                };
                if is_there {
                    let own = Self::root(variable, root);
                    let weight =
                        if matches!(own.0.ty, Ty::Block(_) | Ty::Standard(_)) { 1 } else { 2 };
                    roots.extend(std::iter::repeat_n(own, weight));
                }
            }
        }
        let functions =
            project.functions.iter().filter(|one| !one.name.starts_with("Late")).count();
        Scope { rank, block, roots, counters, functions, in_loop: false, calls: 1 }
    }

    /// Draws a routine's statements, once its variables are known.
    fn routine(&mut self, own: &mut Routine, mut scope: Scope, many: usize) {
        scope.roots.retain(|one| match one.0.root {
            Root::Global(at) => {
                let name = &self.project.globals[at].name;
                own.variables.iter().all(|own| own.name != *name)
            }
            _ => true,
        });
        for (at, variable) in own.variables.iter().enumerate() {
            let place = Self::root(variable, Root::Local(at));
            if variable.name.starts_with('i') && variable.name.len() == 2 {
                scope.counters.push(place.0);
                continue;
            }
            scope.roots.extend([place.clone(), place.clone(), place]);
        }
        own.body = self.draw.body(&self.project, &scope, many, 1);
        if let Some(of) = &own.result {
            let value = self.draw.value(&self.project, &scope, of, 2);
            let place = Place::new(Root::Local(0), of.clone());
            let assign = Statement::Assign(place, value);
            let at = self.draw.dice.below(own.body.len() + 1);
            own.body.insert(at, assign);
        }
    }

    fn functions(&mut self) {
        for number in 0..2 {
            let name = format!("Fun{number}");
            let result = match number {
                0 => Ty::int(),
                _ => self.draw.number(),
            };
            let mut variables = vec![
                Variable::new(&name, result.clone(), Section::Local),
                Variable::new("a", self.draw.number(), Section::Input),
            ];
            if self.chance(2) {
                let own = self.simple("d", Section::Input);
                let value = self.draw.literal(&own.ty);
                variables.push(own.begins(value));
            }
            if self.chance(2) {
                variables.push(Variable::new("c", Ty::int(), Section::InOut));
            }
            if self.has(Feature::Parts) && self.chance(2) {
                variables.push(Variable::new("z", Ty::Struct(0), Section::InOut));
            }
            if self.has(Feature::References) && self.chance(2) {
                let ty = Ty::Reference(Rc::new(Ty::int()));
                variables.push(Variable::new("r", ty, Section::Input));
            }
            if self.has(Feature::Pointers) && self.chance(2) {
                let ty = Ty::Pointer(Rc::new(Ty::int()));
                variables.push(Variable::new("p", ty, Section::Input));
            }
            if self.chance(2) {
                variables.push(self.simple("o", Section::Output));
            }
            variables.push(self.simple("k", Section::Local));
            variables.push(Variable::new("i0", self.draw.counted(), Section::Local));
            let mut own = Routine { name, result: Some(result), variables, body: Vec::new() };
            self.hide(&mut own.variables, None, true);
            let mut scope = self.scope(Rank::Function, None);
            scope.functions = number;
            let many = 1 + self.draw.dice.below(3);
            self.routine(&mut own, scope, many);
            self.project.functions.push(own);
        }
    }

    /// Gives some variables names that mean something else outside.
    fn hide(&mut self, own: &mut [Variable], block: Option<usize>, is_routine: bool) {
        if !self.has(Feature::Shadows) {
            return;
        }
        let mut names: Vec<String> =
            self.project.globals.iter().map(|one| one.name.clone()).collect();
        let members: Vec<String> = match block {
            Some(block) => {
                self.project.blocks[block].variables.iter().map(|one| one.name.clone()).collect()
            }
            None => Vec::new(),
        };
        match is_routine {
            true => names.extend(members),
            // A block must not declare again what it inherits.
            false => names.retain(|name| !members.contains(name)),
        }
        names.retain(|name| !name.starts_with('i'));
        for at in 1..own.len() {
            let is_local = matches!(own[at].section, Section::Local | Section::Input);
            if is_local && !own[at].name.starts_with('i') && self.draw.dice.chance(3) {
                let name = self.draw.dice.one(&names);
                if own.iter().all(|one| !one.name.eq_ignore_ascii_case(&name)) {
                    own[at].name = name;
                }
            }
        }
    }

    /// `Run`, `Level`, `Twist` and `Act` of a block, whose variables are known.
    fn methods(&mut self, block: usize) {
        let base = self.project.blocks[block].base;
        let int = Ty::int;
        let mut run = vec![
            Variable::new("Run", int(), Section::Local),
            Variable::new("n", int(), Section::Input),
            self.simple("k", Section::Local),
        ];
        if self.chance(2) {
            run.push(Variable::new("times", int(), Section::Instance));
        }
        run.push(Variable::new("i0", int(), Section::Local));
        let mut own = Routine {
            name: "Run".to_owned(),
            result: Some(int()),
            variables: run,
            body: Vec::new(),
        };
        if base.is_none() || self.chance(2) {
            self.hide(&mut own.variables[2..], Some(block), true);
            let scope = self.scope(Rank::Run, Some(block));
            self.routine(&mut own, scope, 2);
            if base.is_some() && self.chance(2) {
                own.body.push(base_call(block, "Run", &mut self.draw, &self.project));
            }
            self.project.blocks[block].methods.push(own);
        }
        for access in [Access::Get, Access::Set] {
            if base.is_some() && self.chance(2) {
                continue;
            }
            let variables = vec![
                Variable::new("Level", int(), Section::Local),
                self.simple("k", Section::Local),
            ];
            let result = (access == Access::Get).then(int);
            let mut own = Routine { name: "Level".to_owned(), result, variables, body: Vec::new() };
            let mut scope = self.scope(Rank::Level, Some(block));
            scope.calls = 1;
            self.routine(&mut own, scope, 2);
            self.project.blocks[block].properties.push((access, own));
        }
        if base.is_some() && self.chance(2) {
            return;
        }
        let of = self.draw.simple();
        let variables = vec![
            Variable::new("v", int(), Section::Input).begins(self.draw.literal(&int())),
            Variable::new("c", int(), Section::InOut),
            Variable::new("o", of.clone(), Section::Output),
            Variable::new("k", of, Section::Local),
            Variable::new("i0", int(), Section::Local),
        ];
        let mut own =
            Routine { name: "Twist".to_owned(), result: None, variables, body: Vec::new() };
        if let Some(base) = base
            && let Some((_, first)) = self.project.method(base, "Twist")
        {
            own.variables.clone_from(&first.variables);
        }
        let scope = self.scope(Rank::Twist, Some(block));
        self.routine(&mut own, scope, 2);
        self.project.blocks[block].methods.push(own);
    }

    fn blocks(&mut self) {
        for number in 0..3 {
            if number == 1 && (!self.has(Feature::Objects) || self.chance(3)) {
                // The other block stands for itself, too.
            }
            let base = (number == 1 && self.has(Feature::Objects)).then_some(0);
            let mut variables = Vec::new();
            let name = |name: &str| format!("{name}{number}");
            variables.push(Variable::new(&name("p"), Ty::int(), Section::Input));
            variables.push(self.simple(&name("q"), Section::Input));
            if base.is_none() {
                variables.push(Variable::new(&name("c"), Ty::int(), Section::InOut));
                if self.has(Feature::Parts) {
                    variables.push(Variable::new(&name("z"), Ty::Struct(0), Section::InOut));
                }
            }
            variables.push(self.simple(&name("o"), Section::Output));
            let many = 1 + self.draw.dice.below(2);
            let section = self.draw.dice.one(&[Section::Local, Section::Local, Section::Static]);
            variables.extend(self.variables(&format!("v{number}_"), section, many));
            if self.chance(2) {
                variables.push(self.simple(&name("t"), Section::Temp));
            }
            if self.has(Feature::Timers) {
                variables.push(Variable::new(&name("e"), Ty::Standard("R_TRIG"), Section::Local));
                if self.chance(2) {
                    variables.push(Variable::new(&name("y"), Ty::Standard("TON"), Section::Local));
                }
            }
            if number == 2 {
                variables.push(Variable::new("inner", Ty::Block(0), Section::Local));
                if self.has(Feature::Parts) {
                    let ty = array(0, 1, Ty::Block(1));
                    variables.push(Variable::new("many", ty, Section::Local));
                }
                if self.has(Feature::Objects) {
                    variables.push(Variable::new("any", Ty::Interface, Section::Input));
                }
            }
            variables.push(Variable::new(&format!("i{number}"), Ty::int(), Section::Local));
            self.hide(&mut variables, base, false);
            let own = Block {
                name: format!("Block{number}"),
                base,
                has_interface: self.has(Feature::Objects) && number != 1,
                variables,
                methods: Vec::new(),
                properties: Vec::new(),
                actions: Vec::new(),
                body: Vec::new(),
            };
            self.project.blocks.push(own);
            if self.has(Feature::Objects) {
                self.methods(number);
            }
            if base.is_none() && self.chance(2) {
                let scope = self.scope(Rank::Action, Some(number));
                let body = self.draw.body(&self.project, &scope, 2, 1);
                self.project.blocks[number].actions.push(("Act".to_owned(), body));
            }
            let scope = self.scope(Rank::Body, Some(number));
            let many = 2 + self.draw.dice.below(2);
            let mut body = self.draw.body(&self.project, &scope, many, 2);
            if base.is_some() && self.chance(2) {
                let call = super::tree::Call {
                    target: super::tree::Target::BaseBody(number),
                    given: Vec::new(),
                    unnamed: false,
                    enable: None,
                };
                body.insert(0, Statement::Call(call));
            }
            self.project.blocks[number].body = body;
        }
    }

    /// A function that is handed an instance.
    fn late(&mut self) {
        // An instance whose address is taken is not handed over.
        if !self.has(Feature::Handed) || self.has(Feature::Pointers) || self.has(Feature::Objects) {
            return;
        }
        let name = "Late".to_owned();
        let variables = vec![
            Variable::new(&name, Ty::int(), Section::Local),
            Variable::new("f", Ty::Block(0), Section::InOut),
            Variable::new("a", Ty::int(), Section::Input),
            Variable::new("c", Ty::int(), Section::InOut),
            Variable::new("i0", Ty::int(), Section::Local),
        ];
        let mut own = Routine { name, result: Some(Ty::int()), variables, body: Vec::new() };
        let scope = self.scope(Rank::Late, None);
        self.routine(&mut own, scope, 2);
        self.project.functions.push(own);
    }

    fn program(&mut self) {
        let mut variables = vec![
            Variable::new("in0", Ty::Bool, Section::Local).at("%IX0.0"),
            Variable::new("in1", Ty::Bool, Section::Local).at("%IX0.1"),
            Variable::new("in2", Ty::int(), Section::Local).at("%IW2"),
        ];
        for number in 0..3 {
            let ty = if number == 2 { self.draw.counted() } else { Ty::int() };
            variables.push(Variable::new(&format!("i{number}"), ty, Section::Local));
        }
        variables.push(Variable::new("n0", Ty::int(), Section::Local));
        variables.extend(self.variables("m", Section::Local, 5));
        if self.has(Feature::Addresses) {
            variables.push(Variable::new("aw", Ty::int(), Section::Local).at("%MW2"));
            variables.push(Variable::new("ax", Ty::Bool, Section::Local).at("%MX4.3"));
            variables.push(Variable::new("ab", Ty::named("BYTE"), Section::Local).at("%MB5"));
        }
        variables.push(Variable::new("f0", Ty::Block(0), Section::Local));
        variables.push(Variable::new("f1", Ty::Block(1), Section::Local));
        variables.push(Variable::new("f2", Ty::Block(2), Section::Local));
        if self.has(Feature::Parts) {
            variables.push(Variable::new("ff", array(1, 2, Ty::Block(0)), Section::Local));
        }
        if self.has(Feature::Timers) {
            for (name, kind) in [
                ("rt", "R_TRIG"),
                ("ft", "F_TRIG"),
                ("sr", "SR"),
                ("cu", "CTU"),
                ("cd", "CTD"),
                ("ud", "CTUD"),
                ("on", "TON"),
                ("off", "TOF"),
                ("tp", "TP"),
                ("rs", "RS"),
            ] {
                if self.chance(3) {
                    variables.push(Variable::new(name, Ty::Standard(kind), Section::Local));
                }
            }
        }
        let program = self.project.blocks.len();
        let find = |name: &str, all: &[Variable]| {
            let at = all.iter().position(|one| one.name == name).expect("a variable");
            Place::new(Root::Member(program, at), all[at].ty.clone())
        };
        let address = |place: Place, ty: Ty| Expr { ty, kind: Kind::Address(place) };
        if self.has(Feature::Pointers) {
            for (name, target) in [("p0", "n0"), ("pf", "f0")] {
                let to = find(target, &variables);
                let ty = Ty::Pointer(Rc::new(to.ty.clone()));
                let own = Variable::new(name, ty.clone(), Section::Local).begins(address(to, ty));
                variables.push(own);
            }
        }
        if self.has(Feature::References) {
            let to = find("n0", &variables);
            let ty = Ty::Reference(Rc::new(Ty::int()));
            variables.push(Variable::new("r0", ty.clone(), Section::Local).begins(address(to, ty)));
        }
        if self.has(Feature::Objects) {
            let to = find("f0", &variables);
            let own = Variable::new("who", Ty::Interface, Section::Local);
            variables.push(own.begins(Expr { ty: Ty::Interface, kind: Kind::Read(to) }));
        }
        let name = "main".to_owned();
        let own = Block {
            name,
            base: None,
            has_interface: false,
            variables,
            methods: Vec::new(),
            properties: Vec::new(),
            actions: Vec::new(),
            body: Vec::new(),
        };
        self.project.blocks.push(own);
        let mut scope = self.scope(Rank::Program, Some(program));
        scope.functions = self.project.functions.len();
        if self.has(Feature::Addresses) {
            let all = super::tree::ADDRESSES.iter().enumerate();
            scope.roots.extend(all.map(|(at, (_, of))| {
                let ty = if *of == "BOOL" { Ty::Bool } else { Ty::named(of) };
                (Place::new(Root::Address(at), ty), true)
            }));
        }
        let many = 3 + self.draw.dice.below(4);
        self.project.blocks[program].body = self.draw.body(&self.project, &scope, many, 3);
    }
}

/// `k := SUPER^.Run(n)`, as a statement that leaves its result away.
fn base_call(block: usize, name: &'static str, draw: &mut Draw<'_>, _: &Project) -> Statement {
    let n = match draw.dice.chance(2) {
        true => read(Place::new(Root::Local(1), Ty::int())),
        false => super::draw::number_expr(2, &Ty::int()),
    };
    let given = vec![("n".to_owned(), super::tree::Argument::In(n))];
    let target = super::tree::Target::BaseMethod(block, name);
    let call = super::tree::Call { target, given, unnamed: false, enable: None };
    let value = Expr { ty: Ty::int(), kind: Kind::Call(Box::new(call)) };
    Statement::Assign(Place::new(Root::Local(0), Ty::int()), value)
}
