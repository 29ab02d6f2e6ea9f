//! Code of other languages in pragmas: it is carried out as far as the user states what it takes and writes.

use super::emit::Emit;
use super::resolve::{Context, Found};
use scanbound_base::code::Code;
use scanbound_base::facts::{Facts, StatedCall, key, normalized};
use scanbound_front::builder::always;
use scanbound_iec::ast::{Expr, Kind, Path, Statement};
use scanbound_iec::chart::Target;
use scanbound_iec::fault::{Fault, short};
use scanbound_iec::{Body, Pou, Project, parse, show};
use scanbound_ir::{MissingRoutine, Step, Write};
use std::borrow::Cow;

/// What stands for the value that code of another language gives to a variable.
const WRITTEN: &str = "~foreign";

/// Whether an expression stands for that.
pub(super) fn is_written(value: &Expr) -> bool {
    matches!(value, Expr::Call(path, _) if path.first == WRITTEN)
}

/// The project with what is stated of pragmas: each writes any value to the variables that it is stated to write.
pub(super) fn stated<'p>(project: &'p Project, facts: &Facts) -> Cow<'p, Project> {
    if facts.calls.is_empty() {
        return Cow::Borrowed(project);
    }
    let mut project = project.clone();
    let files = project.files.clone();
    for pou in &mut project.pous {
        let names = names(&files, pou.file);
        in_unit(pou, &mut |line| of(facts, names, line));
    }
    Cow::Owned(project)
}

/// What facts may call a file: its whole name, and the name without its directories where no other file has it.
pub(super) fn names(files: &[String], file: usize) -> [&str; 2] {
    let whole = files.get(file).map_or("", String::as_str);
    [whole, scanbound_ir::location_text::short_file_name(whole, files.iter().map(String::as_str))]
}

/// What is stated of the pragma in this line.
fn of<'f>(facts: &'f Facts, names: [&str; 2], line: u32) -> Option<(String, &'f StatedCall)> {
    names.into_iter().find_map(|file| {
        let name = normalized(&format!("{file}:{line}"));
        facts.calls.get(&name).map(|call| (name, call))
    })
}

type Of<'o, 'f> = &'o mut dyn FnMut(u32) -> Option<(String, &'f StatedCall)>;

fn in_unit(pou: &mut Pou, of: Of<'_, '_>) {
    in_body(&mut pou.body, of);
    pou.actions.iter_mut().chain(&mut pou.transitions).for_each(|one| in_body(&mut one.body, of));
    pou.methods.iter_mut().for_each(|one| in_unit(one, of));
}

fn in_body(body: &mut Body, of: Of<'_, '_>) {
    match body {
        Body::Code(_, statements) => in_statements(statements, of),
        Body::Chart(chart) => {
            for block in chart.steps.iter_mut().flat_map(|step| &mut step.blocks) {
                if let Target::Inline(_, body) = &mut block.target {
                    in_body(body, of);
                }
            }
        }
        Body::Unread(..) => {}
    }
}

fn in_statements(statements: &mut Vec<Statement>, of: Of<'_, '_>) {
    let mut at = 0;
    while at < statements.len() {
        let line = statements[at].line;
        match &mut statements[at].kind {
            Kind::Foreign(_, name) => {
                if let Some((stated, StatedCall { writes: Some(writes), .. })) = of(line) {
                    *name = Some(stated);
                    // What is no variable is a fault where the assignment is followed.
                    let read = |text: &String| match parse::expression(text, line) {
                        Ok(Expr::Variable(path)) => path,
                        _ => Path::name(text.clone()),
                    };
                    let value = || Expr::Call(Path::name(WRITTEN), Vec::new());
                    let any = |text| Kind::Assign(read(text), value());
                    let all: Vec<Statement> =
                        writes.iter().map(|text| Statement { line, kind: any(text) }).collect();
                    let count = all.len();
                    statements.splice(at + 1..=at, all);
                    at += count;
                }
            }
            Kind::If(arms, otherwise) => {
                arms.iter_mut().for_each(|(_, body)| in_statements(body, of));
                in_statements(otherwise, of);
            }
            Kind::Case(_, arms, otherwise) => {
                arms.iter_mut().for_each(|(_, body)| in_statements(body, of));
                in_statements(otherwise, of);
            }
            Kind::For(.., body) | Kind::While(_, body) | Kind::Repeat(body, _) => {
                in_statements(body, of);
            }
            Kind::Either(_, one, other) => {
                in_statements(one, of);
                in_statements(other, of);
            }
            _ => {}
        }
        at += 1;
    }
}

impl Emit<'_> {
    /// A variable that code of another language may have written: that takes no time of its own.
    pub(super) fn foreign_written(
        &mut self,
        at: &Context,
        target: &Path,
        line: u32,
    ) -> Result<(), Fault> {
        let name = show::path(target);
        let Found::Place(place) = self.find(at, target, line)? else {
            let told = format!("what the pragma is stated to write, {name}, is no variable");
            return Err(Fault::new(line, told).code(Code::Fact).help("name variables of the unit"));
        };
        let effects = place.tag.regions().into_iter().map(|region| {
            let choice = self.builder.choice();
            always(Write::Havoc(region, choice))
        });
        let effects = effects.collect();
        let entry = self.builder.add(None, effects, Step::Nothing);
        let why =
            format!("what the pragma writes to {name} may be any value: only its time is stated");
        self.program().approximate(entry, why);
        Ok(())
    }

    /// Code of another language, by the name under which it is stated.
    pub(super) fn foreign(
        &mut self,
        text: &str,
        name: Option<&String>,
        line: u32,
    ) -> Result<(), Fault> {
        let Some((name, time)) = name.and_then(|name| Some((name, self.calls.get(name)?.time)))
        else {
            let file = self.project.files.get(self.file).map_or("", String::as_str);
            let told = format!(
                "what {} takes and writes is not known: Beremiz and OpenPLC carry it out as C",
                short(text)
            );
            let help = format!(
                "state in a facts file (--facts) its time, and all variables that it may write, as the unit names them: [calls] {} = {{ time = \"50us\", writes = [\"x\"] }}, with writes = [] where it writes none; or take it out of a copy of the file where the controller leaves it out",
                key(&format!("{file}:{line}"))
            );
            return Err(Fault::new(line, told).code(Code::Pragma).text(text).help(help));
        };
        let name = name.clone();
        let entry = self.builder.add(None, Vec::new(), Step::Nothing);
        self.program().missing_routines.push(MissingRoutine {
            name,
            entry,
            time,
            stated: true,
            declared: true,
        });
        Ok(())
    }
}
