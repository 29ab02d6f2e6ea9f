//! The parser of files with programs, function blocks, functions, types and configurations.

use super::chart;
use super::cursor::Cursor;
use super::declaration::{edge_memory, section, task, types, variables};
use super::il;
use super::statement::statements;
use crate::ast::{Argument, Expr, Kind, Path, Statement, visit};
use crate::comment::Comments;
use crate::fault::Fault;
use crate::lexer::{Token, first_words};
use crate::{
    Body, Connected, Language, Named, Pou, PouKind, Project, Section, Task, Variable, same,
};

const BEGIN: &[&str] = &[
    "PROGRAM",
    "FUNCTION_BLOCK",
    "FUNCTION",
    "INTERFACE",
    "TYPE",
    "CONFIGURATION",
    "VAR_GLOBAL",
    "RESOURCE",
];

/// Whether a text may be a file of units in the textual languages, by its first words.
#[must_use]
pub fn begins(text: &str) -> bool {
    // A name or a declaration must follow, as in `PROGRAM main VAR`.
    let begins = |reading| match &first_words(text, reading)[..] {
        [first, _] => BEGIN.iter().any(|own| same(own, first)),
        _ => false,
    };
    begins(Comments::Nested) || begins(Comments::Flat)
}

/// The name of a file without folders and extensions, which names its lists of global variables.
pub(crate) fn file_stem(name: &str) -> &str {
    let base = name.rsplit(['/', '\\']).next().unwrap_or(name);
    base.split_once('.').map_or(base, |(stem, _)| stem)
}

/// Parses a file of units, types and configurations. In charts, every named step must exist.
///
/// # Errors
/// All faults that were found; parsing continues with the next unit after each.
pub fn file(name: &str, text: &str) -> Result<Project, Vec<Fault>> {
    let mut project = Project { files: vec![name.to_owned()], ..Project::default() };
    let mut cursor = Cursor::new(text, 1).map_err(|fault| vec![fault])?;
    let mut faults = Vec::new();
    while *cursor.peek() != Token::End {
        if let Err(fault) = unit(&mut cursor, &mut project) {
            faults.push(fault);
            // Continue after the end of the faulty unit.
            const ENDS: &[&str] = &[
                "END_PROGRAM",
                "END_FUNCTION_BLOCK",
                "END_FUNCTION",
                "END_INTERFACE",
                "END_TYPE",
                "END_CONFIGURATION",
            ];
            while *cursor.peek() != Token::End && !cursor.is_one_of(ENDS) {
                cursor.next();
            }
            cursor.next();
        }
    }
    if faults.is_empty() { Ok(project) } else { Err(faults) }
}

fn unit(cursor: &mut Cursor, project: &mut Project) -> Result<(), Fault> {
    let line = cursor.line();
    if cursor.take_sign(";") {
        return Ok(());
    }
    if cursor.take_word("TYPE") {
        project.types.extend(types(cursor)?);
        return Ok(());
    }
    if cursor.take_word("CONFIGURATION") {
        return configuration(cursor, project);
    }
    if let Some(section) = section(cursor) {
        let found = variables(cursor, section)?;
        let names = found.iter().map(|one| one.name.clone()).collect();
        project.lists.push((file_stem(&project.files[0]).to_owned(), names));
        project.globals.push((String::new(), found));
        return Ok(());
    }
    if matches!(cursor.peek(), Token::Pragma(_)) {
        return Err(cursor.unexpected("a unit"));
    }
    let (kind, end) = match cursor.next() {
        Token::Word(word) if same(&word, "PROGRAM") => (PouKind::Program, "END_PROGRAM"),
        Token::Word(word) if same(&word, "FUNCTION_BLOCK") => {
            (PouKind::FunctionBlock, "END_FUNCTION_BLOCK")
        }
        Token::Word(word) if same(&word, "FUNCTION") => (PouKind::Function, "END_FUNCTION"),
        Token::Word(word) if same(&word, "INTERFACE") => (PouKind::Interface, "END_INTERFACE"),
        _ => {
            let help = "write PROGRAM, FUNCTION_BLOCK, FUNCTION, INTERFACE, TYPE, VAR_GLOBAL or CONFIGURATION";
            return Err(Fault::new(line, "a unit was expected here").help(help));
        }
    };
    let mut pou = pou(cursor, kind, end, line)?;
    if matches!(kind, PouKind::Program | PouKind::FunctionBlock) {
        actions_behind(cursor, &mut pou)?;
    }
    apart(project, &mut pou)?;
    project.pous.push(pou);
    Ok(())
}

/// The modifiers that may precede the name of a method, property or function block.
const MODIFIERS: &[&str] =
    &["PUBLIC", "PRIVATE", "PROTECTED", "INTERNAL", "FINAL", "ABSTRACT", "OVERRIDE"];

/// Consumes modifiers; whether `PRIVATE` is among them.
fn modifiers(cursor: &mut Cursor) -> bool {
    let mut is_private = false;
    // A modifier that no word follows is the name of the unit.
    while cursor.is_one_of(MODIFIERS) && matches!(cursor.second(), Token::Word(_)) {
        is_private |= cursor.is_word("PRIVATE");
        cursor.next();
    }
    is_private
}

fn pou(cursor: &mut Cursor, kind: PouKind, end: &str, line: u32) -> Result<Pou, Fault> {
    let is_private = modifiers(cursor);
    let name = cursor.name("a unit's name")?;
    let mut pou = Pou { is_private, ..Pou::new(&name, kind, line) };
    if kind == PouKind::Interface && cursor.is_word("EXTENDS") {
        pou.implements = named_list(cursor)?;
    } else if cursor.take_word("EXTENDS") {
        pou.extends = Some(qualified(cursor)?);
    }
    if cursor.is_word("IMPLEMENTS") {
        pou.implements = named_list(cursor)?;
    }
    if cursor.take_sign(":") {
        pou.result = Some(super::declaration::type_ref(cursor)?);
    }
    let place = pou.name.clone();
    let within = |fault: Fault| fault.within(&place);
    while let Some(section) = section(cursor) {
        pou.variables.extend(variables(cursor, section).map_err(within)?);
    }
    if kind != PouKind::Function {
        methods(cursor, &mut pou).map_err(within)?;
    }
    if kind != PouKind::Interface {
        body(cursor, &mut pou, end).map_err(within)?;
    }
    if kind != PouKind::Function {
        methods(cursor, &mut pou).map_err(within)?;
    }
    cursor.word(end).map_err(within)?;
    edges(&mut pou).map_err(within)?;
    Ok(pou)
}

/// Handles inputs declared R_EDGE or F_EDGE: the body begins with calls of triggers and sees their outputs as the
/// inputs, which have their own values again at its end.
fn edges(pou: &mut Pou) -> Result<(), Fault> {
    let is_input = |one: &&Variable| one.section == Section::Input && one.has_edge;
    let inputs: Vec<Variable> = pou.variables.iter().filter(is_input).cloned().collect();
    for one in inputs {
        let line = one.line;
        let Body::Code(_, statements) = &mut pou.body else {
            let what = format!("{}: edges of inputs of a chart are not followed", one.name);
            return Err(Fault::new(line, what).help("call R_TRIG or F_TRIG yourself"));
        };
        if pou.kind != PouKind::FunctionBlock {
            let what = format!("{}: only a function block remembers edges of its inputs", one.name);
            return Err(Fault::new(line, what));
        }
        let mut returns = None;
        visit(statements, &mut |one| {
            if matches!(one.kind, Kind::Return(_)) {
                returns = Some(one.line);
            }
        });
        if let Some(line) = returns {
            let what =
                format!("RETURN in a block whose input {} has an edge is not followed", one.name);
            return Err(Fault::new(line, what).help("call R_TRIG or F_TRIG yourself"));
        }
        let memory = Path::name(edge_memory(&one.name));
        let value = Expr::name(one.name.clone());
        let given = vec![Argument { name: Some("CLK".to_owned()), is_output: false, value }];
        let [seen, passed] = ["Q", "CLK"].map(|pin| Expr::Variable(memory.clone().with(pin)));
        let input = Path::name(one.name);
        let begins = [Kind::Call(memory, given), Kind::Assign(input.clone(), seen)];
        statements.splice(0..0, begins.map(|kind| Statement { line, kind }));
        statements.push(Statement { line, kind: Kind::Assign(input, passed) });
    }
    Ok(())
}

/// Parses the name of a unit, without a library's name in front of it.
fn qualified(cursor: &mut Cursor) -> Result<String, Fault> {
    let mut name = cursor.name("a unit's name")?;
    while cursor.take_sign(".") {
        name = cursor.name("a unit's name")?;
    }
    Ok(name)
}

/// `IMPLEMENTS a, b`
fn named_list(cursor: &mut Cursor) -> Result<Vec<String>, Fault> {
    cursor.next();
    let mut found = vec![qualified(cursor)?];
    while cursor.take_sign(",") {
        found.push(qualified(cursor)?);
    }
    Ok(found)
}

/// Parses `METHOD PUBLIC name : type ... END_METHOD` and `PROPERTY name : type ... END_PROPERTY`.
fn methods(cursor: &mut Cursor, pou: &mut Pou) -> Result<(), Fault> {
    loop {
        let line = cursor.line();
        if cursor.take_word("METHOD") {
            let kind = PouKind::Function;
            let method = match pou.kind {
                PouKind::Interface => signature(cursor, line)?,
                _ => self::pou(cursor, kind, "END_METHOD", line)?,
            };
            pou.methods.push(method);
        } else if cursor.take_word("PROPERTY") {
            property(cursor, pou)?;
        } else {
            return Ok(());
        }
    }
}

/// Parses a method of an interface, which has no body; END_METHOD may be missing.
fn signature(cursor: &mut Cursor, line: u32) -> Result<Pou, Fault> {
    modifiers(cursor);
    let name = cursor.name("a method's name")?;
    let mut method = Pou::new(&name, PouKind::Function, line);
    if cursor.take_sign(":") {
        method.result = Some(super::declaration::type_ref(cursor)?);
    }
    cursor.take_sign(";");
    while let Some(section) = section(cursor) {
        method.variables.extend(variables(cursor, section)?);
    }
    cursor.take_word("END_METHOD");
    Ok(method)
}

/// Parses `PROPERTY PUBLIC name : type GET ... END_GET SET ... END_SET END_PROPERTY` into a getter and a setter method.
fn property(cursor: &mut Cursor, pou: &mut Pou) -> Result<(), Fault> {
    modifiers(cursor);
    let name = cursor.name("a property's name")?;
    cursor.sign(":")?;
    let of = super::declaration::type_ref(cursor)?;
    cursor.take_sign(";");
    // Variables declared in the property itself are added to both accessors.
    let mut common = Vec::new();
    while let Some(section) = section(cursor) {
        common.extend(variables(cursor, section)?);
    }
    let is_interface = pou.kind == PouKind::Interface;
    while cursor.is_one_of(&["GET", "SET", "PUBLIC", "PRIVATE", "PROTECTED", "INTERNAL"]) {
        modifiers(cursor);
        let line = cursor.line();
        let reads = cursor.is_word("GET");
        let end = if reads { "END_GET" } else { "END_SET" };
        if !reads && !cursor.is_word("SET") {
            return Err(cursor.unexpected("GET or SET"));
        }
        cursor.next();
        let mut method = Pou::accessor(&name, &of, reads, line);
        method.variables.extend(common.clone());
        while let Some(section) = section(cursor) {
            method.variables.extend(variables(cursor, section)?);
        }
        if is_interface {
            cursor.take_sign(";");
            cursor.take_word(end);
        } else {
            body(cursor, &mut method, end)?;
            cursor.word(end)?;
        }
        pou.methods.push(method);
    }
    if is_interface && !cursor.is_word("END_PROPERTY") {
        return Ok(());
    }
    cursor.word("END_PROPERTY")
}

/// Moves VAR_STAT variables (shared by all instances) to global variables, and VAR_INST variables of methods to their
/// unit. They get names that are unique in the project, and code is changed to these names.
///
/// # Errors
/// The fault of such variables in a unit with a chart, where this is not supported.
pub(crate) fn apart(project: &mut Project, pou: &mut Pou) -> Result<(), Fault> {
    let unit = pou.name.clone();
    let mut methods = std::mem::take(&mut pou.methods);
    let found = methods.iter_mut().try_for_each(|method| {
        let owner = format!("{unit}.{}", method.name);
        move_out(project, &owner, method, Some(&mut pou.variables))
    });
    pou.methods = methods;
    found.and_then(|()| {
        // Methods may use the variables of their unit, too.
        let names = apart_of(pou);
        move_out(project, &unit, pou, None)?;
        for method in &mut pou.methods {
            let hidden = |name: &str| method.variables.iter().any(|one| same(&one.name, name));
            let own: Vec<_> = names.iter().filter(|name| !hidden(name)).cloned().collect();
            rename(&mut method.body, &unit, &own)?;
        }
        Ok(())
    })
}

fn apart_of(pou: &Pou) -> Vec<String> {
    let own = |one: &&Variable| matches!(one.section, Section::Static | Section::Instance);
    pou.variables.iter().filter(own).map(|one| one.name.clone()).collect()
}

fn move_out(
    project: &mut Project,
    owner: &str,
    pou: &mut Pou,
    mut instance: Option<&mut Vec<Variable>>,
) -> Result<(), Fault> {
    let names = apart_of(pou);
    if names.is_empty() {
        return Ok(());
    }
    let (moved, own): (Vec<_>, Vec<_>) =
        pou.variables.drain(..).partition(|one| names.contains(&one.name));
    pou.variables = own;
    let mut global = Vec::new();
    for one in moved {
        let is_static = one.section == Section::Static;
        let named = Variable { name: format!("{owner}.{}", one.name), ..one };
        match &mut instance {
            Some(list) if !is_static => list.push(Variable { section: Section::Local, ..named }),
            _ => global.push(Variable { section: Section::Global, ..named }),
        }
    }
    if !global.is_empty() {
        project.globals.push((String::new(), global));
    }
    rename(&mut pou.body, owner, &names)?;
    for action in &mut pou.actions {
        rename(&mut action.body, owner, &names)?;
    }
    Ok(())
}

/// Renames moved variables in a body.
fn rename(body: &mut Body, owner: &str, names: &[String]) -> Result<(), Fault> {
    if matches!(body, Body::Chart(_)) && !names.is_empty() {
        let what = "VAR_STAT and VAR_INST of a unit with a chart are not followed";
        let help = "declare the variables as VAR, or VAR_GLOBAL";
        return Err(Fault::new(0, what).within(owner).help(help));
    }
    let change = |path: &mut Path| {
        if let Some(own) = names.iter().find(|own| same(own, &path.first)) {
            path.first = format!("{owner}.{own}");
        }
    };
    body.change(&mut |expr| crate::ast::paths_of(expr, &mut |path| change(path)), &mut |path| {
        crate::ast::path_of(path, &mut |path| change(path))
    });
    Ok(())
}

fn body(cursor: &mut Cursor, pou: &mut Pou, end: &str) -> Result<(), Fault> {
    if chart::begins(cursor) {
        let (chart, actions) = chart::chart(cursor, action)?;
        pou.body = Body::Chart(Box::new(chart));
        pou.actions = actions;
        return Ok(());
    }
    if il::begins(cursor) {
        pou.body = Body::Code(Language::Il, il::instructions(cursor)?);
    } else {
        pou.body =
            Body::Code(Language::St, statements(cursor, &[end, "ACTION", "METHOD", "PROPERTY"])?);
    }
    while cursor.is_word("ACTION") {
        pou.actions.push(action(cursor)?);
    }
    Ok(())
}

/// Parses actions after the end of their unit, as exported by CoDeSys 2.3 and B&R, or within `ACTIONS unit ...
/// END_ACTIONS`.
fn actions_behind(cursor: &mut Cursor, pou: &mut Pou) -> Result<(), Fault> {
    let place = pou.name.clone();
    loop {
        if cursor.is_word("ACTION") {
            pou.actions.push(action(cursor).map_err(|fault| fault.within(&place))?);
        } else if cursor.take_word("ACTIONS") {
            let line = cursor.line();
            if !cursor.is_word("ACTION") {
                let of = cursor.name("a unit's name")?;
                cursor.take_sign(":");
                if !same(&of, &pou.name) {
                    let told = format!("these are actions of {of}, but follow {}", pou.name);
                    let help = format!("put them directly after the end of {of}");
                    return Err(Fault::new(line, told).help(help));
                }
            }
            while cursor.is_word("ACTION") {
                pou.actions.push(action(cursor).map_err(|fault| fault.within(&place))?);
            }
            cursor.word("END_ACTIONS")?;
        } else {
            return Ok(());
        }
    }
}

/// Parses `ACTION name: ... END_ACTION`.
fn action(cursor: &mut Cursor) -> Result<Named, Fault> {
    let line = cursor.line();
    cursor.word("ACTION")?;
    let name = cursor.name("an action's name")?;
    cursor.take_sign(":");
    let body = action_body(cursor)?;
    cursor.word("END_ACTION")?;
    Ok(Named { name, body, line })
}

/// Parses the body of an action.
fn action_body(cursor: &mut Cursor) -> Result<Body, Fault> {
    if chart::begins(cursor) {
        let (chart, _): (_, Vec<Named>) = chart::chart(cursor, action)?;
        return Ok(Body::Chart(Box::new(chart)));
    }
    if il::begins(cursor) {
        return Ok(Body::Code(Language::Il, il::instructions(cursor)?));
    }
    Ok(Body::Code(Language::St, statements(cursor, &["END_ACTION"])?))
}

fn configuration(cursor: &mut Cursor, project: &mut Project) -> Result<(), Fault> {
    let configuration = cursor.name("a configuration's name")?;
    let mut resource = String::new();
    while !cursor.take_word("END_CONFIGURATION") {
        if let Some(section) = section(cursor) {
            let found = variables(cursor, section)?;
            project.globals.push((String::new(), found));
        } else if cursor.take_word("RESOURCE") {
            resource = format!("{configuration} {}", cursor.name("a resource's name")?);
            cursor.word("ON")?;
            cursor.name("a processor's name")?;
        } else if cursor.take_word("END_RESOURCE") || cursor.take_sign(";") {
        } else if cursor.take_word("TASK") {
            let name = cursor.name("a task's name")?;
            let (interval, priority) = task(cursor)?;
            cursor.sign(";")?;
            let (resource, instances) = (resource.clone(), Vec::new());
            project.tasks.push(Task { name, resource, interval, priority, instances });
        } else if cursor.take_word("PROGRAM") {
            instance(cursor, project, &resource)?;
        } else {
            return Err(cursor.unexpected("TASK, PROGRAM or END_CONFIGURATION"));
        }
    }
    Ok(())
}

/// Parses a program instance: `name WITH task : type (...);`.
fn instance(cursor: &mut Cursor, project: &mut Project, resource: &str) -> Result<(), Fault> {
    let is_retained = cursor.take_word("RETAIN");
    let _ = cursor.take_word("NON_RETAIN");
    let line = cursor.line();
    let name = cursor.name("an instance's name")?;
    let task = if cursor.take_word("WITH") { cursor.name("a task's name")? } else { String::new() };
    cursor.sign(":")?;
    let of = cursor.name("a program's name")?;
    if cursor.is_sign("(") {
        let given = super::expression::arguments(cursor)?;
        if !given.is_empty() {
            project.connected.push(Connected { name: name.clone(), given, file: 0, line });
        }
    }
    cursor.sign(";")?;
    if is_retained {
        project.retained.push(of.clone());
    }
    let is_own = |own: &&mut Task| same(&own.name, &task) && same(&own.resource, resource);
    match project.tasks.iter_mut().rev().find(is_own) {
        Some(own) => own.instances.push((name, of)),
        None if task.is_empty() => project.tasks.push(Task {
            name: task,
            resource: resource.to_owned(),
            interval: None,
            priority: None,
            instances: vec![(name, of)],
        }),
        None => return Err(Fault::new(line, format!("there is no task {task}"))),
    }
    Ok(())
}
