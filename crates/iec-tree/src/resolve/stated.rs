//! Facts that state the time and writes of code that is missing or in another language.

use super::paths::{Found, start};
use super::resolver::{Resolver, Scope};
use crate::declarations::{RoutineKind, Stated};
use crate::tree::{Place, Root, StatementKind};
use scanbound_base::code::Code;
use scanbound_base::facts::{StatedCall, key, normalized};
use scanbound_iec::fault::{Fault, short};
use scanbound_iec::{PouKind, ast, parse, show};

impl Resolver<'_> {
    /// Resolves a pragma with code of another language; a fault if no fact states its time and writes.
    pub(super) fn foreign(
        &mut self,
        scope: Scope,
        text: &str,
        line: u32,
    ) -> Result<StatementKind, Fault> {
        let file = scope.unit.map_or(0, |unit| self.tree.unit(unit).file);
        let names = self.facts.files.get(file).copied().unwrap_or_default();
        let calls = self.facts.calls;
        let found = names.iter().find_map(|file| {
            let name = normalized(&format!("{file}:{line}"));
            Some((calls.get(&name)?, name))
        });
        let Some((StatedCall { time, writes: Some(writes), .. }, name)) = found else {
            let told = format!(
                "the time and the writes of {} are not known: Beremiz and OpenPLC execute it as C",
                short(text)
            );
            let help = format!(
                "state in a facts file (--facts) its time, and all variables that it may write, as the unit names them: [calls] {} = {{ time = \"50us\", writes = [\"x\"] }}, with writes = [] where it writes none; or take it out of a copy of the file where the controller leaves it out",
                key(&format!("{}:{line}", names[0]))
            );
            return Err(Fault::new(line, told).code(Code::Pragma).text(text).help(help));
        };
        let writes = writes.iter().map(|text| self.stated_variable(scope, text, line)).collect();
        Ok(StatementKind::Foreign(Stated { name, time: *time, writes }))
    }

    fn stated_variable(&mut self, scope: Scope, text: &str, line: u32) -> Result<Place, Fault> {
        let path = match parse::expression(text, line) {
            Ok(ast::Expr::Variable(path)) => path,
            _ => ast::Path::name(text),
        };
        if let Found::Place(place) = self.one_path(scope, &path, line)? {
            return Ok(place);
        }
        let name = show::path(&path);
        let told = format!("the pragma is stated to write {name}, which is not a variable");
        Err(Fault::new(line, told).code(Code::Fact).help("name variables of the unit"))
    }

    /// Records the facts stated for functions, function blocks and methods without code.
    pub(super) fn state_routines(&mut self) {
        let calls = self.facts.calls;
        for at in 0..self.tree.routines.len() {
            let routine = &self.tree.routines[at];
            let unit = self.tree.unit(routine.unit);
            let name = match routine.kind {
                RoutineKind::Body => unit.name.clone(),
                RoutineKind::Method => format!("{}.{}", unit.name, routine.name),
                RoutineKind::Action => continue,
            };
            if unit.kind == PouKind::Program || !routine.code.is_empty() {
                continue;
            }
            let Some(stated) = calls.get(&normalized(&name)) else { continue };
            let line = routine.line;
            let writes = stated.writes.iter().flatten();
            let writes = writes.map(|name| self.stated_global(&stated.name, name, line)).collect();
            let (name, time) = (stated.name.clone(), stated.time);
            self.tree.routines[at].stated = Some(Stated { name, time, writes });
        }
    }

    fn stated_global(&self, of: &str, name: &str, line: u32) -> Result<Place, Fault> {
        if let Some(&id) = self.index.globals(name).first() {
            return Ok(start(Root::Variable(id), self.tree.variable(id).ty));
        }
        let told = format!("{of} is stated to write {name}, which is not a global variable");
        let help = "name global variables; what a call passes is counted without that";
        Err(Fault::new(line, told).code(Code::Fact).help(help))
    }
}
