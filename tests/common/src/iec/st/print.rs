//! Writes a project as structured text.

use super::tree::{
    ADDRESSES, Access, Argument, Block, COLOURS, Call, Expr, Initial, Kind, Place, Project, Root,
    Routine, Section, Statement, Step, Target, Ty, Variable,
};
use std::fmt::Write;

/// What names mean at a place: the block whose code it is, and the routine.
#[derive(Clone, Copy)]
pub struct Here<'p> {
    pub project: &'p Project,
    pub block: Option<usize>,
    pub locals: &'p [Variable],
}

fn same(one: &str, two: &str) -> bool {
    one.eq_ignore_ascii_case(two)
}

impl<'p> Here<'p> {
    /// Whether an instance's block declares a name.
    fn is_member(&self, name: &str) -> bool {
        let lineage = self.block.map_or(Vec::new(), |block| self.project.lineage(block));
        lineage.into_iter().any(|one| {
            let own = &self.project.blocks[one];
            own.variables.iter().any(|one| same(&one.name, name))
                || own.methods.iter().any(|one| same(&one.name, name))
                || own.properties.iter().any(|one| same(&one.1.name, name))
                || own.actions.iter().any(|one| same(&one.0, name))
        })
    }

    fn is_local(&self, name: &str) -> bool {
        self.locals.iter().any(|one| same(&one.name, name))
    }

    fn root(&self, root: Root) -> String {
        match root {
            Root::Global(at) => {
                let name = &self.project.globals[at].name;
                let is_hidden = self.is_local(name) || self.is_member(name);
                if is_hidden { format!("GVL.{name}") } else { name.clone() }
            }
            Root::Member(block, at) => {
                let name = &self.project.blocks[block].variables[at].name;
                if self.is_local(name) { format!("THIS^.{name}") } else { name.clone() }
            }
            Root::Local(at) => self.locals[at].name.clone(),
            Root::This => "THIS^".to_owned(),
            Root::Address(at) => ADDRESSES[at].0.to_owned(),
        }
    }

    pub fn place(&self, place: &Place) -> String {
        let mut text = self.root(place.root);
        for step in &place.steps {
            match step {
                Step::Part(name) => text += &format!(".{name}"),
                Step::Member(block, at) => {
                    text += &format!(".{}", self.project.blocks[*block].variables[*at].name);
                }
                Step::Pin(name) => text += &format!(".{name}"),
                Step::Element(indices) => {
                    let all: Vec<String> = indices.iter().map(|one| self.expr(one)).collect();
                    text += &format!("[{}]", all.join(", "));
                }
                Step::Bit(bit) => text += &format!(".{bit}"),
                Step::Dereference => text += "^",
            }
        }
        text
    }

    /// What stands before the name of a method, an action or a property.
    fn of(&self, instance: &Option<Place>, name: &str) -> String {
        match instance {
            Some(place) => format!("{}.{name}", self.place(place)),
            // A variable of the routine hides it.
            None if self.is_local(name) => format!("THIS^.{name}"),
            None => name.to_owned(),
        }
    }

    pub fn expr(&self, expr: &Expr) -> String {
        match &expr.kind {
            Kind::Number(value, typed, base) => {
                let of = expr.ty.as_number().map_or("INT", |of| of.name);
                let digits = match base {
                    16 if *value >= 0 => format!("16#{value:X}"),
                    2 if *value >= 0 => format!("2#{value:b}"),
                    _ => value.to_string(),
                };
                if *typed { format!("{of}#{digits}") } else { digits }
            }
            Kind::Bool(value) => if *value { "TRUE" } else { "FALSE" }.to_owned(),
            Kind::Real(value) => format!("{value:?}"),
            Kind::Time(value) => format!("T#{value}ms"),
            Kind::Text(value) => format!("'{value}'"),
            Kind::Colour(at) => {
                let own = COLOURS[*at].0;
                if at % 2 == 0 { own.to_owned() } else { format!("Colour#{own}") }
            }
            Kind::Null => "0".to_owned(),
            Kind::Read(place) => self.place(place),
            Kind::Not(inner) => format!("(NOT {})", self.expr(inner)),
            Kind::Negate(inner) => format!("(-{})", self.expr(inner)),
            Kind::Binary(operator, one, two) => {
                format!("({} {operator} {})", self.expr(one), self.expr(two))
            }
            Kind::Widen(inner) => self.expr(inner),
            Kind::Standard(name, given) => {
                let given: Vec<String> = given.iter().map(|one| self.expr(one)).collect();
                format!("{name}({})", given.join(", "))
            }
            Kind::Call(call) => self.call(call),
            Kind::Get(instance, name) => self.of(instance, name),
            Kind::Address(place) => format!("ADR({})", self.place(place)),
            Kind::IsValid(place) => format!("__ISVALIDREF({})", self.place(place)),
        }
    }

    pub fn call(&self, call: &Call) -> String {
        let project = self.project;
        let name = match &call.target {
            Target::Function(at) => project.functions[*at].name.clone(),
            Target::Instance(place) | Target::Standard(place, _) => self.place(place),
            Target::Method(instance, name) => self.of(instance, name),
            Target::BaseMethod(_, name) => format!("SUPER^.{name}"),
            Target::BaseBody(_) => "SUPER^".to_owned(),
            Target::Action(instance, block, at) => {
                self.of(instance, &project.blocks[*block].actions[*at].0)
            }
        };
        let mut given: Vec<String> = Vec::new();
        if let Some((condition, _)) = &call.enable {
            given.push(format!("EN := {}", self.expr(condition)));
        }
        for (name, one) in &call.given {
            given.push(match one {
                Argument::In(value) if call.unnamed => self.expr(value),
                Argument::InOut(place) if call.unnamed => self.place(place),
                Argument::In(value) => format!("{name} := {}", self.expr(value)),
                Argument::InOut(place) => format!("{name} := {}", self.place(place)),
                Argument::Out(place) => format!("{name} => {}", self.place(place)),
            });
        }
        if let Some((_, Some(to))) = &call.enable {
            given.push(format!("ENO => {}", self.place(to)));
        }
        format!("{name}({})", given.join(", "))
    }

    pub fn body(&self, all: &[Statement], out: &mut String) {
        for one in all {
            self.statement(one, out);
        }
    }

    fn statement(&self, one: &Statement, out: &mut String) {
        match one {
            Statement::Assign(to, value) => {
                *out += &format!("{} := {};\n", self.place(to), self.expr(value));
            }
            Statement::Copy(to, from) => {
                *out += &format!("{} := {};\n", self.place(to), self.place(from));
            }
            Statement::Refer(to, of) => {
                *out += &format!("{} REF= {};\n", self.place(to), self.place(of));
            }
            Statement::Latch(to, sets, when) => {
                let sign = if *sets { "S=" } else { "R=" };
                *out += &format!("{} {sign} {};\n", self.place(to), self.expr(when));
            }
            Statement::Call(call) => *out += &format!("{};\n", self.call(call)),
            Statement::Set(instance, name, value) => {
                *out += &format!("{} := {};\n", self.of(instance, name), self.expr(value));
            }
            Statement::If(arms, otherwise) => {
                for (number, (condition, body)) in arms.iter().enumerate() {
                    let word = if number == 0 { "IF" } else { "ELSIF" };
                    *out += &format!("{word} {} THEN\n", self.expr(condition));
                    self.body(body, out);
                }
                if !otherwise.is_empty() {
                    *out += "ELSE\n";
                    self.body(otherwise, out);
                }
                *out += "END_IF;\n";
            }
            Statement::Case(of, arms, otherwise) => {
                *out += &format!("CASE {} OF\n", self.expr(of));
                for (values, body) in arms {
                    let value = |value: i128| match of.ty {
                        Ty::Colour => {
                            let own = COLOURS.iter().find(|one| one.1 == value);
                            own.map_or("blue", |one| one.0).to_owned()
                        }
                        _ => value.to_string(),
                    };
                    let one = |(low, high): &(i128, i128)| match low == high {
                        true => value(*low),
                        false => format!("{}..{}", value(*low), value(*high)),
                    };
                    let all: Vec<String> = values.iter().map(one).collect();
                    *out += &format!("{}:\n", all.join(", "));
                    self.body(body, out);
                    *out += ";\n";
                }
                *out += "ELSE\n";
                self.body(otherwise, out);
                *out += "END_CASE;\n";
            }
            Statement::For(own) => {
                let by = own.by.map_or(String::new(), |by| format!(" BY {by}"));
                *out += &format!(
                    "FOR {} := {} TO {}{by} DO\n",
                    self.place(&own.variable),
                    self.expr(&own.from),
                    self.expr(&own.to)
                );
                self.body(&own.body, out);
                *out += "END_FOR;\n";
            }
            Statement::While(condition, body) => {
                *out += &format!("WHILE {} DO\n", self.expr(condition));
                self.body(body, out);
                *out += "END_WHILE;\n";
            }
            Statement::Repeat(body, until) => {
                *out += "REPEAT\n";
                self.body(body, out);
                *out += &format!("UNTIL {} END_REPEAT;\n", self.expr(until));
            }
            Statement::Exit => *out += "EXIT;\n",
            Statement::Continue => *out += "CONTINUE;\n",
            Statement::Return => *out += "RETURN;\n",
        }
    }

    fn ty(&self, ty: &Ty) -> String {
        match ty {
            Ty::Bool => "BOOL".to_owned(),
            Ty::Number(of) => of.name.to_owned(),
            Ty::Real => "REAL".to_owned(),
            Ty::Time => "TIME".to_owned(),
            Ty::Text => "STRING".to_owned(),
            Ty::Colour => "Colour".to_owned(),
            Ty::Array(dimensions, of) => {
                let all: Vec<String> =
                    dimensions.iter().map(|(low, high)| format!("{low}..{high}")).collect();
                format!("ARRAY[{}] OF {}", all.join(", "), self.ty(of))
            }
            Ty::Struct(of) => self.project.structs[*of].name.to_owned(),
            Ty::Block(of) => self.project.blocks[*of].name.clone(),
            Ty::Standard(name) => (*name).to_owned(),
            Ty::Interface => "I_Any".to_owned(),
            Ty::Pointer(of) => format!("POINTER TO {}", self.ty(of)),
            Ty::Reference(of) => format!("REFERENCE TO {}", self.ty(of)),
        }
    }

    fn declared(&self, variable: &Variable) -> String {
        let at = variable.at.as_ref().map_or(String::new(), |at| format!(" AT {at}"));
        let sign = if matches!(variable.ty, Ty::Reference(_)) { "REF=" } else { ":=" };
        let value = |value: &Expr| match (&variable.ty, &value.kind) {
            (Ty::Reference(_), Kind::Address(place)) => self.place(place),
            _ => self.expr(value),
        };
        let initial = match &variable.initial {
            None => String::new(),
            Some(Initial::Value(one)) => format!(" {sign} {}", value(one)),
            Some(Initial::Elements(all)) => {
                let all: Vec<String> = all.iter().map(|one| self.expr(one)).collect();
                format!(" := [{}]", all.join(", "))
            }
            Some(Initial::Parts(all)) => {
                let one =
                    |(name, value): &(String, Expr)| format!("{name} := {}", self.expr(value));
                let all: Vec<String> = all.iter().map(one).collect();
                format!(" := ({})", all.join(", "))
            }
        };
        format!("{}{at} : {}{initial};", variable.name, self.ty(&variable.ty))
    }

    fn section(&self, all: &[Variable], plain: &str, out: &mut String) {
        for one in all {
            let section = match one.section {
                Section::Local => plain,
                Section::Temp => "VAR_TEMP",
                Section::Static => "VAR_STAT",
                Section::Instance => "VAR_INST",
                Section::Input => "VAR_INPUT",
                Section::Output => "VAR_OUTPUT",
                Section::InOut => "VAR_IN_OUT",
                Section::Constant => &format!("{plain} CONSTANT"),
                Section::Retain => &format!("{plain} RETAIN"),
            };
            let _ = writeln!(out, "{section} {} END_VAR", self.declared(one));
        }
    }
}

fn result(here: &Here<'_>, routine: &Routine) -> String {
    routine.result.as_ref().map_or(String::new(), |of| format!(" : {}", here.ty(of)))
}

/// A routine's variables and statements; the first variable is its result where it has one.
fn inside(here: &Here<'_>, routine: &Routine, out: &mut String) {
    let own = usize::from(routine.result.is_some());
    here.section(&routine.variables[own..], "VAR", out);
    here.body(&routine.body, out);
}

fn block(project: &Project, at: usize, probe: &str, out: &mut String) {
    let own: &Block = &project.blocks[at];
    let here = Here { project, block: Some(at), locals: &[] };
    let (word, end) = match at == project.program() {
        true => ("PROGRAM", "END_PROGRAM"),
        false => ("FUNCTION_BLOCK", "END_FUNCTION_BLOCK"),
    };
    *out += &format!("{word} {}", own.name);
    if let Some(base) = own.base {
        *out += &format!(" EXTENDS {}", project.blocks[base].name);
    }
    *out += if own.has_interface { " IMPLEMENTS I_Any\n" } else { "\n" };
    here.section(&own.variables, "VAR", out);
    here.body(&own.body, out);
    *out += probe;
    for (name, body) in &own.actions {
        *out += &format!("ACTION {name}:\n");
        here.body(body, out);
        *out += "END_ACTION\n";
    }
    for method in &own.methods {
        let here = Here { locals: &method.variables, ..here };
        *out += &format!("METHOD {}{}\n", method.name, result(&here, method));
        inside(&here, method, out);
        *out += "END_METHOD\n";
    }
    let mut names: Vec<&str> = own.properties.iter().map(|one| one.1.name.as_str()).collect();
    names.dedup();
    for name in names {
        let all = own.properties.iter().filter(|one| one.1.name == name);
        for (number, (access, routine)) in all.enumerate() {
            let here = Here { locals: &routine.variables, ..here };
            if number == 0 {
                let of = here.ty(&routine.variables[0].ty);
                *out += &format!("PROPERTY {name} : {of}\n");
            }
            let word = if *access == Access::Get { "GET" } else { "SET" };
            *out += &format!("{word}\n");
            here.section(&routine.variables[1..], "VAR", out);
            here.body(&routine.body, out);
            *out += &format!("END_{word}\n");
        }
        *out += "END_PROPERTY\n";
    }
    *out += &format!("{end}\n");
}

/// The list of global variables, and all else with a probe behind the program's statements.
pub fn files(project: &Project, probe: &str) -> [String; 2] {
    let here = Here { project, block: None, locals: &[] };
    let mut globals = String::new();
    here.section(&project.globals, "VAR_GLOBAL", &mut globals);
    let colours: Vec<String> =
        COLOURS.iter().map(|(name, value)| format!("{name} := {value}")).collect();
    let mut text = format!("TYPE Colour : ({}); END_TYPE\n", colours.join(", "));
    for one in &project.structs {
        let base = one
            .base
            .map_or(String::new(), |base| format!(" EXTENDS {}", project.structs[base].name));
        let parts: String = one.parts.iter().map(|part| here.declared(part)).collect();
        text += &format!("TYPE {}{base} : STRUCT {parts} END_STRUCT; END_TYPE\n", one.name);
    }
    if project.blocks.iter().any(|one| one.has_interface) {
        text += "INTERFACE I_Any METHOD Run : INT VAR_INPUT n : INT; END_VAR END_METHOD \
            PROPERTY Level : INT GET END_GET SET END_SET END_PROPERTY END_INTERFACE\n";
    }
    for one in &project.functions {
        let here = Here { locals: &one.variables, ..here };
        text += &format!("FUNCTION {}{}\n", one.name, result(&here, one));
        inside(&here, one, &mut text);
        text += "END_FUNCTION\n";
    }
    for at in 0..project.blocks.len() {
        block(project, at, if at == project.program() { probe } else { "" }, &mut text);
    }
    [globals, text]
}
