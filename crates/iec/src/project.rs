//! What the files of a project declare: types, variables, units and tasks.

use crate::ast::{Argument, Expr, same};
use crate::body::{Body, Chart, Named};
use crate::fault::Fault;

/// A variable's type as it is written.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum TypeRef {
    /// An elementary type, or one that the project or the standard declares.
    Named(String),
    /// An array: the least and the largest index of each dimension.
    Array(Vec<(Expr, Expr)>, Box<TypeRef>),
    /// Text, with the most characters that it holds if that is declared.
    Text(Option<Box<Expr>>),
    /// A structure.
    Struct(Vec<Variable>),
    /// One of these names, with their numbers.
    Enumeration(Vec<(String, Option<Expr>)>, Option<Box<TypeRef>>),
    /// A range of a type's numbers, which a variable may leave at run time; it begins with one of them.
    Subrange(Box<TypeRef>, Box<(Expr, Expr)>),
    /// A pointer to something (`POINTER TO`, `REF_TO`).
    Pointer(Box<TypeRef>),
    /// A reference, which stands for what it refers to (`REFERENCE TO`).
    Reference(Box<TypeRef>),
}

/// In which section a variable is declared.
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
    /// `VAR_STAT`: one for all instances.
    Static,
    /// `VAR_INST`, of a method: one for each instance.
    Instance,
}

/// A variable.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Variable {
    /// Its name.
    pub name: String,
    /// Its section.
    pub section: Section,
    /// Its type.
    pub of: TypeRef,
    /// What it holds at first.
    pub initial: Option<Expr>,
    /// Its direct address (`%IX0.1`, `%Q*`).
    pub at: Option<String>,
    /// Whether nothing writes it.
    pub constant: bool,
    /// Whether it survives a loss of power.
    pub retain: bool,
    /// Whether a reader made it: the memory of an edge, or of what a drawing reads before it is worked out.
    pub is_internal: bool,
    /// Its line.
    pub line: u32,
}

/// What a program organization unit is.
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

/// A program organization unit.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Pou {
    /// Its name.
    pub name: String,
    /// What it is.
    pub kind: PouKind,
    /// The function block that it extends.
    pub extends: Option<String>,
    /// The interfaces that it implements, or extends where it is one itself.
    pub implements: Vec<String>,
    /// The type of its result, of a function.
    pub result: Option<TypeRef>,
    /// Its variables.
    pub variables: Vec<Variable>,
    /// Its body.
    pub body: Body,
    /// Its actions.
    pub actions: Vec<Named>,
    /// Its named transitions.
    pub transitions: Vec<Named>,
    /// Its methods, and what its properties read and write ([`getter`], [`setter`]).
    pub methods: Vec<Pou>,
    /// Whether only the unit that declares it may call it, of a method (PRIVATE).
    pub is_private: bool,
    /// The file, an index into the files that were read.
    pub file: usize,
    /// Its line.
    pub line: u32,
}

/// The name of the method that reads a property.
#[must_use]
pub fn getter(property: &str) -> String {
    format!("{property}.Get")
}

/// The name of the method that writes a property.
#[must_use]
pub fn setter(property: &str) -> String {
    format!("{property}.Set")
}

impl Variable {
    /// A variable about which nothing else is said.
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
            line,
        }
    }
}

impl Pou {
    /// The method that reads (or writes) a property, without its body. What is written is an input of the property's
    /// name.
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

    /// A unit, or a method, that holds nothing yet.
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

    /// The variable that holds its result: its name, or that of the property that it reads.
    #[must_use]
    pub fn result_name(&self) -> &str {
        self.name.split_once('.').map_or(&self.name, |(property, _)| property)
    }

    /// The property that it reads or writes, of a method.
    #[must_use]
    pub fn property(&self) -> Option<&str> {
        self.name.split_once('.').map(|(property, _)| property)
    }

    /// Its charts: that of the body, those of actions and of methods, each with the name of what it belongs to.
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

    /// The action of this name.
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
    /// The structure that it extends.
    pub extends: Option<String>,
    /// What it is.
    pub of: TypeRef,
    /// What a variable of it holds at first.
    pub initial: Option<Expr>,
    /// The file, an index into the files that were read.
    pub file: usize,
    /// Its line.
    pub line: u32,
}

/// A task, and what it runs.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Task {
    /// Its name; empty for programs that no task is named for.
    pub name: String,
    /// Its interval in nanoseconds, where it has one.
    pub interval: Option<i64>,
    /// Its priority as it is written.
    pub priority: Option<String>,
    /// The instances of programs in their order: name and type.
    pub instances: Vec<(String, String)>,
}

/// What the inputs and outputs of an instance of a program are connected to (`PROGRAM i WITH t : p (x := a, y => b)`).
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Connected {
    /// The instance's name.
    pub name: String,
    /// Its inputs and outputs.
    pub given: Vec<Argument>,
    /// The file, an index into the files that were read.
    pub file: usize,
    /// The line.
    pub line: u32,
}

/// What the files of a project say.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Project {
    /// The files' names.
    pub files: Vec<String>,
    /// Declared types.
    pub types: Vec<TypeDeclaration>,
    /// Lists of global variables, by their names (empty where they have none).
    pub globals: Vec<(String, Vec<Variable>)>,
    /// How many lists of global variables there are up to the end of each file but the last.
    pub global_ends: Vec<usize>,
    /// The program organization units.
    pub pous: Vec<Pou>,
    /// The tasks.
    pub tasks: Vec<Task>,
    /// The types of programs of which an instance keeps all its variables when the power fails (`PROGRAM RETAIN`).
    pub retained: Vec<String>,
    /// The instances of programs whose inputs or outputs are connected to variables.
    pub connected: Vec<Connected>,
    /// What a controller may carry out and nothing here reads, with the file that it stands in: nothing is known of a
    /// scan with it.
    pub unread: Vec<(usize, Fault)>,
    /// The lists of global variables in text, by their files' names, with the names of their variables.
    pub lists: Vec<(String, Vec<String>)>,
}

impl Project {
    /// Whether a unit is a program that keeps all its variables when the power fails.
    #[must_use]
    pub fn retains(&self, pou: usize) -> bool {
        self.retained.iter().any(|of| same(of, &self.pous[pou].name))
    }

    /// The unit of this name.
    #[must_use]
    pub fn pou(&self, name: &str) -> Option<&Pou> {
        self.pous.iter().find(|pou| same(&pou.name, name))
    }

    /// The file of a list of global variables, an index into the files that were read.
    #[must_use]
    pub fn file_of_list(&self, list: usize) -> usize {
        self.global_ends.partition_point(|&end| end <= list)
    }

    /// Takes in what another file says.
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
        for task in other.tasks {
            // Tasks of two resources may have one name.
            let is_same = |own: &&mut Task| {
                let differs = (own.interval.is_some()
                    && task.interval.is_some_and(|_| own.interval != task.interval))
                    || (own.priority.is_some()
                        && task.priority.is_some()
                        && own.priority != task.priority);
                same(&own.name, &task.name) && !differs
            };
            match self.tasks.iter_mut().find(is_same) {
                Some(own) => own.instances.extend(task.instances),
                None => self.tasks.push(task),
            }
        }
    }

    /// Gives structures the parts of those that they extend, when all files are read.
    pub fn inherit_parts(&mut self) {
        // Each time one more stands above.
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

    /// Every chart, with the name of what it belongs to and the unit that it stands in.
    #[must_use]
    pub fn charts(&self) -> Vec<(String, &Pou, &Chart)> {
        let all = self
            .pous
            .iter()
            .flat_map(|pou| pou.charts().into_iter().map(move |(name, chart)| (name, pou, chart)));
        all.collect()
    }
}
