//! The declarations of a project's files: types, variables, units and tasks.

use crate::ast::{Argument, Expr, same};
use crate::body::{Body, Chart, Named};
use crate::fault::Fault;

/// A variable's type as written.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum TypeRef {
    /// An elementary type, or one that the project or the standard declares.
    Named(String),
    /// An array: the lower and upper bound of each dimension, and the element type.
    Array(Vec<(Expr, Expr)>, Box<TypeRef>),
    /// A string, with its maximum number of characters if one is declared.
    Text(Option<Box<Expr>>),
    /// A structure, with its fields.
    Struct(Vec<Variable>),
    /// An enumeration: its value names with their numbers if written, and its base type if written.
    Enumeration(Vec<(String, Option<Expr>)>, Option<Box<TypeRef>>),
    /// A subrange: the base type, and the lower and upper limit. The limits are not enforced at run time.
    Subrange(Box<TypeRef>, Box<(Expr, Expr)>),
    /// `POINTER TO` or `REF_TO`.
    Pointer(Box<TypeRef>),
    /// `REFERENCE TO`: its name stands for the variable that it refers to.
    Reference(Box<TypeRef>),
}

/// The section of a variable's declaration.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Section {
    /// `VAR`
    Local,
    /// `VAR_TEMP`
    Temp,
    /// `VAR_INPUT`
    Input,
    /// `VAR_OUTPUT`
    Output,
    /// `VAR_IN_OUT`
    InOut,
    /// `VAR_EXTERNAL`
    External,
    /// `VAR_GLOBAL`
    Global,
    /// `VAR_STAT`: shared by all instances.
    Static,
    /// `VAR_INST` in a method: one for each instance.
    Instance,
}

/// A declared variable or a field of a structure.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Variable {
    /// Its name.
    pub name: String,
    /// The section in which it is declared.
    pub section: Section,
    /// Its type as written.
    pub of: TypeRef,
    /// The initial value, if one is written.
    pub initial: Option<Expr>,
    /// The address (`AT %IX0.1`, `%Q*`), if one is written.
    pub at: Option<String>,
    /// Whether it is declared `CONSTANT`.
    pub constant: bool,
    /// Whether it is retentive: it keeps its value without power.
    pub retain: bool,
    /// Whether the reader created it: the memory of an edge, or of a value that a drawing reads before computing it.
    pub is_internal: bool,
    /// Whether it is an input declared R_EDGE or F_EDGE.
    pub has_edge: bool,
    /// Its line, from 1.
    pub line: u32,
}

/// The kinds of program organization units.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum PouKind {
    /// A program.
    Program,
    /// A function block.
    FunctionBlock,
    /// A function, or a method of a function block.
    Function,
    /// An interface, which function blocks implement.
    Interface,
}

/// A program organization unit: a program, function block, function, method or interface.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Pou {
    /// Its name.
    pub name: String,
    /// Its kind.
    pub kind: PouKind,
    /// The function block that it extends, if any.
    pub extends: Option<String>,
    /// The interfaces that it implements; for an interface, those that it extends.
    pub implements: Vec<String>,
    /// The result type of a function or method; `None` if it has no result.
    pub result: Option<TypeRef>,
    /// Its variables of all sections, without the result.
    pub variables: Vec<Variable>,
    /// Its body; empty for interfaces and for units without code.
    pub body: Body,
    /// Its actions.
    pub actions: Vec<Named>,
    /// Its named transitions.
    pub transitions: Vec<Named>,
    /// Its methods, and the accessors of its properties ([`getter`], [`setter`]).
    pub methods: Vec<Pou>,
    /// Whether it is a `PRIVATE` method, which only its unit may call.
    pub is_private: bool,
    /// The index of its file in [`Project::files`].
    pub file: usize,
    /// Its line, from 1.
    pub line: u32,
}

/// The name of the accessor method that reads a property.
#[must_use]
pub fn getter(property: &str) -> String {
    format!("{property}.Get")
}

/// The name of the accessor method that writes a property.
#[must_use]
pub fn setter(property: &str) -> String {
    format!("{property}.Set")
}

impl Variable {
    /// A variable without initial value, address or attributes.
    #[must_use]
    pub fn new(name: impl Into<String>, section: Section, of: TypeRef, line: u32) -> Variable {
        Variable {
            name: name.into(),
            section,
            of,
            initial: None,
            at: None,
            constant: false,
            retain: false,
            is_internal: false,
            has_edge: false,
            line,
        }
    }
}

impl Pou {
    /// The getter (`reads`) or setter of a property, without a body. The setter has an input with the property's name.
    #[must_use]
    pub fn accessor(property: &str, of: &TypeRef, reads: bool, line: u32) -> Pou {
        let name = if reads { getter(property) } else { setter(property) };
        let mut own = Pou::new(&name, PouKind::Function, line);
        match reads {
            true => own.result = Some(of.clone()),
            false => {
                own.variables.push(Variable::new(property, Section::Input, of.clone(), line));
            }
        }
        own
    }

    /// A unit or method without contents, in the file with index 0.
    #[must_use]
    pub fn new(name: &str, kind: PouKind, line: u32) -> Pou {
        Pou {
            name: name.to_owned(),
            kind,
            extends: None,
            implements: Vec::new(),
            result: None,
            variables: Vec::new(),
            body: Body::empty(),
            actions: Vec::new(),
            transitions: Vec::new(),
            methods: Vec::new(),
            is_private: false,
            file: 0,
            line,
        }
    }

    /// The name of its result variable: its own name, or for a getter the name of the property.
    #[must_use]
    pub fn result_name(&self) -> &str {
        self.name.split_once('.').map_or(&self.name, |(property, _)| property)
    }

    /// The property that this accessor method belongs to; `None` for other units.
    #[must_use]
    pub fn property(&self) -> Option<&str> {
        self.name.split_once('.').map(|(property, _)| property)
    }

    /// All charts in its body, actions and methods, each with a qualified name such as `Unit.Action`.
    #[must_use]
    pub fn charts(&self) -> Vec<(String, &Chart)> {
        let actions = self.actions.iter();
        let actions = actions.map(|one| (format!("{}.{}", self.name, one.name), &one.body));
        let bodies = [(self.name.clone(), &self.body)].into_iter().chain(actions);
        let own = bodies.filter_map(|(name, body)| match body {
            Body::Chart(chart) => Some((name, &**chart)),
            _ => None,
        });
        let inner = self.methods.iter().flat_map(Pou::charts);
        let inner = inner.map(|(name, chart)| (format!("{}.{name}", self.name), chart));
        own.chain(inner).collect()
    }

    /// The action of this name, ignoring case.
    #[must_use]
    pub fn action(&self, name: &str) -> Option<&Named> {
        self.actions.iter().find(|one| same(&one.name, name))
    }
}

/// A declared type.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TypeDeclaration {
    /// Its name.
    pub name: String,
    /// The structure that it extends; `None` if it extends none. [`Project::inherit_parts`] clears it if that
    /// structure is known.
    pub extends: Option<String>,
    /// Its definition.
    pub of: TypeRef,
    /// The default initial value of its variables, if one is written.
    pub initial: Option<Expr>,
    /// The index of its file in [`Project::files`].
    pub file: usize,
    /// Its line, from 1.
    pub line: u32,
}

/// A task and the program instances that it runs.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Task {
    /// Its name; empty for program instances without a task.
    pub name: String,
    /// The configuration and resource to which it belongs; empty if the file names none.
    pub resource: String,
    /// Its interval in nanoseconds, if it has one.
    pub interval: Option<i64>,
    /// Its priority as written, if it has one.
    pub priority: Option<String>,
    /// The program instances in order: name and program.
    pub instances: Vec<(String, String)>,
}

/// The connections of a program instance's inputs and outputs: `PROGRAM i WITH t : p (x := a, y => b)`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Connected {
    /// The instance's name.
    pub name: String,
    /// The connected inputs and outputs.
    pub given: Vec<Argument>,
    /// The index of the file in [`Project::files`].
    pub file: usize,
    /// The line of the program instance, from 1.
    pub line: u32,
}

/// The contents of a project's files.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Project {
    /// The names of the files.
    pub files: Vec<String>,
    /// Declared types.
    pub types: Vec<TypeDeclaration>,
    /// The lists of global variables, with their names (empty if unnamed).
    pub globals: Vec<(String, Vec<Variable>)>,
    /// For each file except the last, the number of lists in `globals` up to its end.
    pub global_ends: Vec<usize>,
    /// The program organization units.
    pub pous: Vec<Pou>,
    /// The tasks.
    pub tasks: Vec<Task>,
    /// The programs that have an instance declared `PROGRAM RETAIN`: all of its variables are retentive.
    pub retained: Vec<String>,
    /// The program instances with connected inputs or outputs.
    pub connected: Vec<Connected>,
    /// Contents that a controller may execute and that could not be read, with their files. No scan of the project can
    /// then be bounded.
    pub unread: Vec<(usize, Fault)>,
    /// The lists of global variables in text files: the name that the file gives to the list, and its variables.
    pub lists: Vec<(String, Vec<String>)>,
    /// Whether CODESYS or TwinCAT wrote one of the files.
    pub is_of_codesys: bool,
}

impl Project {
    /// Whether all variables of this unit are retentive (`PROGRAM RETAIN`).
    #[must_use]
    pub fn retains(&self, pou: usize) -> bool {
        self.retained.iter().any(|of| same(of, &self.pous[pou].name))
    }

    /// The unit of this name, ignoring case.
    #[must_use]
    pub fn pou(&self, name: &str) -> Option<&Pou> {
        self.pous.iter().find(|pou| same(&pou.name, name))
    }

    /// The index in [`Project::files`] of the file that declares this list of global variables.
    #[must_use]
    pub fn file_of_list(&self, list: usize) -> usize {
        self.global_ends.partition_point(|&end| end <= list)
    }

    /// Appends the contents of another file. Tasks of one name are merged unless they state different
    /// intervals or priorities.
    pub fn join(&mut self, mut other: Project) {
        let shift = self.files.len();
        other.pous.iter_mut().for_each(|pou| {
            pou.file += shift;
            pou.methods.iter_mut().for_each(|method| method.file += shift);
        });
        other.connected.iter_mut().for_each(|one| one.file += shift);
        other.types.iter_mut().for_each(|one| one.file += shift);
        if shift > 0 {
            self.global_ends.push(self.globals.len());
        }
        self.global_ends.extend(other.global_ends.iter().map(|end| end + self.globals.len()));
        self.files.append(&mut other.files);
        self.types.append(&mut other.types);
        self.globals.append(&mut other.globals);
        self.pous.append(&mut other.pous);
        self.retained.append(&mut other.retained);
        self.connected.append(&mut other.connected);
        self.unread.extend(other.unread.into_iter().map(|(file, fault)| (file + shift, fault)));
        self.lists.append(&mut other.lists);
        self.is_of_codesys |= other.is_of_codesys;
        for task in other.tasks {
            // Tasks of different resources may have the same name.
            let is_same = |own: &&mut Task| {
                let differs = (own.interval.is_some()
                    && task.interval.is_some_and(|_| own.interval != task.interval))
                    || (own.priority.is_some()
                        && task.priority.is_some()
                        && own.priority != task.priority);
                same(&own.name, &task.name) && same(&own.resource, &task.resource) && !differs
            };
            match self.tasks.iter_mut().find(is_same) {
                Some(own) => own.instances.extend(task.instances),
                None => self.tasks.push(task),
            }
        }
    }

    /// Inserts inherited fields into structures that extend others. Call it after all files have been read.
    pub fn inherit_parts(&mut self) {
        // Each pass resolves one more level of inheritance.
        for _ in 0..self.types.len() {
            let whole: Vec<(String, Vec<Variable>)> = self
                .types
                .iter()
                .filter(|one| one.extends.is_none())
                .filter_map(|one| match &one.of {
                    TypeRef::Struct(parts) => Some((one.name.clone(), parts.clone())),
                    _ => None,
                })
                .collect();
            let mut is_done = true;
            for one in &mut self.types {
                let Some(base) = &one.extends else { continue };
                let base = whole.iter().find(|(name, _)| same(name, base));
                if let (Some((_, parts)), TypeRef::Struct(own)) = (base, &mut one.of) {
                    own.splice(0..0, parts.clone());
                    one.extends = None;
                    is_done = false;
                }
            }
            if is_done {
                break;
            }
        }
    }

    /// All charts of the project, each with its qualified name and the unit that contains it.
    #[must_use]
    pub fn charts(&self) -> Vec<(String, &Pou, &Chart)> {
        let all = self
            .pous
            .iter()
            .flat_map(|pou| pou.charts().into_iter().map(move |(name, chart)| (name, pou, chart)));
        all.collect()
    }
}
