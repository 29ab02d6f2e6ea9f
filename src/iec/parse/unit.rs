//! Files of programs, function blocks, functions, types and configurations.

use super::chart;
use super::cursor::Cursor;
use super::declaration::{edge_memory, section, task, types, variables};
use super::il;
use super::statement::statements;
use crate::iec::ast::{Argument, Expr, Kind, Path, Statement};
use crate::iec::fault::Fault;
use crate::iec::lexer::Token;
use crate::iec::{
    Body, Connected, Language, Named, Pou, PouKind, Project, Section, Task, Variable, same,
};

const BEGIN: &[&str] =
    &["PROGRAM", "FUNCTION_BLOCK", "FUNCTION", "TYPE", "CONFIGURATION", "VAR_GLOBAL", "RESOURCE"];

/// Whether a text begins as a file of units does.
pub(super) fn begins(text: &str) -> bool {
    let Ok(mut cursor) = Cursor::new(text, 1) else {
        // The text may be cut off within a comment or quotes.
        let first = text.trim_start_matches('\u{feff}').split_whitespace().next();
        return first.is_some_and(|word| BEGIN.iter().any(|own| same(own, word)));
    };
    if !cursor.is_one_of(BEGIN) {
        return false;
    }
    // A name, or a declaration, follows: `PROGRAM main VAR`.
    cursor.next();
    matches!(cursor.peek(), Token::Word(_))
}

/// Reads a file.
pub(super) fn file(name: &str, text: &str) -> Result<Project, Vec<Fault>> {
    let mut project = Project { files: vec![name.to_owned()], ..Project::default() };
    let mut cursor = Cursor::new(text, 1).map_err(|fault| vec![fault])?;
    let mut faults = Vec::new();
    while *cursor.peek() != Token::End {
        if let Err(fault) = unit(&mut cursor, &mut project) {
            faults.push(fault);
            // Goes on behind the unit that is at fault.
            const ENDS: &[&str] = &[
                "END_PROGRAM",
                "END_FUNCTION_BLOCK",
                "END_FUNCTION",
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
        project.globals.push((String::new(), found));
        return Ok(());
    }
    let (kind, end) = match cursor.next() {
        Token::Word(word) if same(&word, "PROGRAM") => (PouKind::Program, "END_PROGRAM"),
        Token::Word(word) if same(&word, "FUNCTION_BLOCK") => {
            (PouKind::FunctionBlock, "END_FUNCTION_BLOCK")
        }
        Token::Word(word) if same(&word, "FUNCTION") => (PouKind::Function, "END_FUNCTION"),
        _ => {
            let help = "write PROGRAM, FUNCTION_BLOCK, FUNCTION, TYPE, VAR_GLOBAL or CONFIGURATION";
            return Err(Fault::new(line, "no unit begins here").help(help));
        }
    };
    let pou = pou(cursor, kind, end, line)?;
    project.pous.push(pou);
    Ok(())
}

/// What may stand between METHOD and its name.
const MODIFIERS: &[&str] =
    &["PUBLIC", "PRIVATE", "PROTECTED", "INTERNAL", "FINAL", "ABSTRACT", "OVERRIDE"];

fn pou(cursor: &mut Cursor, kind: PouKind, end: &str, line: u32) -> Result<Pou, Fault> {
    let name = cursor.name("a unit's name")?;
    let mut pou = Pou {
        name,
        kind,
        extends: None,
        result: None,
        variables: Vec::new(),
        body: Body::empty(),
        actions: Vec::new(),
        transitions: Vec::new(),
        methods: Vec::new(),
        file: 0,
        line,
    };
    if cursor.take_word("EXTENDS") {
        pou.extends = Some(cursor.name("a function block's name")?);
    }
    if cursor.take_sign(":") {
        pou.result = Some(super::declaration::type_ref(cursor)?);
    }
    let place = pou.name.clone();
    let within = |fault: Fault| fault.within(&place);
    while let Some(section) = section(cursor) {
        pou.variables.extend(variables(cursor, section).map_err(within)?);
    }
    if cursor.is_word("VAR_STAT") || cursor.is_word("VAR_INST") {
        let fault = Fault::new(cursor.line(), "VAR_STAT and VAR_INST are not followed");
        return Err(within(
            fault.help("declare the variables as VAR of a function block, or VAR_GLOBAL"),
        ));
    }
    methods(cursor, &mut pou).map_err(within)?;
    body(cursor, &mut pou, end).map_err(within)?;
    methods(cursor, &mut pou).map_err(within)?;
    cursor.word(end).map_err(within)?;
    edges(&mut pou).map_err(within)?;
    Ok(pou)
}

/// Of inputs with R_EDGE or F_EDGE a body sees edges, as if it began with the trigger that says so.
fn edges(pou: &mut Pou) -> Result<(), Fault> {
    let inputs = pou.variables.iter().filter(|one| one.section == Section::Input);
    let has_memory =
        |one: &&Variable| pou.variables.iter().any(|other| other.name == edge_memory(&one.name));
    let inputs: Vec<Variable> = inputs.filter(has_memory).cloned().collect();
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
        let memory = Path::name(edge_memory(&one.name));
        let value = Expr::name(one.name.clone());
        let given = vec![Argument { name: Some("CLK".to_owned()), is_output: false, value }];
        let seen = Expr::Variable(memory.clone().with("Q"));
        let begins = [Kind::Call(memory, given), Kind::Assign(Path::name(one.name), seen)];
        statements.splice(0..0, begins.map(|kind| Statement { line, kind }));
    }
    Ok(())
}

/// `METHOD PUBLIC name : type ... END_METHOD`, of a function block.
fn methods(cursor: &mut Cursor, pou: &mut Pou) -> Result<(), Fault> {
    while pou.kind == PouKind::FunctionBlock && cursor.is_word("METHOD") {
        let line = cursor.line();
        cursor.word("METHOD")?;
        while MODIFIERS.iter().any(|word| cursor.take_word(word)) {}
        let method = self::pou(cursor, PouKind::Function, "END_METHOD", line)?;
        pou.methods.push(method);
    }
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
        pou.body = Body::Code(Language::St, statements(cursor, &[end, "ACTION", "METHOD"])?);
    }
    while cursor.is_word("ACTION") {
        pou.actions.push(action(cursor)?);
    }
    Ok(())
}

/// `ACTION name: ... END_ACTION`
fn action(cursor: &mut Cursor) -> Result<Named, Fault> {
    let line = cursor.line();
    cursor.word("ACTION")?;
    let name = cursor.name("an action's name")?;
    cursor.take_sign(":");
    let body = action_body(cursor)?;
    cursor.word("END_ACTION")?;
    Ok(Named { name, body, line })
}

/// The body of an action.
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
    cursor.name("a configuration's name")?;
    while !cursor.take_word("END_CONFIGURATION") {
        if let Some(section) = section(cursor) {
            let found = variables(cursor, section)?;
            project.globals.push((String::new(), found));
        } else if cursor.take_word("RESOURCE") {
            cursor.name("a resource's name")?;
            cursor.word("ON")?;
            cursor.name("a processor's name")?;
        } else if cursor.take_word("END_RESOURCE") || cursor.take_sign(";") {
        } else if cursor.take_word("TASK") {
            let name = cursor.name("a task's name")?;
            let (interval, priority) = task(cursor)?;
            cursor.sign(";")?;
            project.tasks.push(Task { name, interval, priority, instances: Vec::new() });
        } else if cursor.take_word("PROGRAM") {
            instance(cursor, project)?;
        } else {
            return Err(cursor.unexpected("TASK, PROGRAM or END_CONFIGURATION"));
        }
    }
    Ok(())
}

/// `name WITH task : type (...);`
fn instance(cursor: &mut Cursor, project: &mut Project) -> Result<(), Fault> {
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
    match project.tasks.iter_mut().rev().find(|own| same(&own.name, &task)) {
        Some(own) => own.instances.push((name, of)),
        None if task.is_empty() => project.tasks.push(Task {
            name: task,
            interval: None,
            priority: None,
            instances: vec![(name, of)],
        }),
        None => return Err(Fault::new(line, format!("there is no task {task}"))),
    }
    Ok(())
}
