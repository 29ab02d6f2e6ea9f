//! What a configuration connects the inputs and outputs of programs to: inputs are copied before the program is carried out,
//! outputs behind it.

use super::emit::{Emit, Place};
use super::resolve::{Context, Found};
use super::value::Value;
use super::whole::Whole;
use scanbound_base::code::Code;
use scanbound_base::location::Location;
use scanbound_front::builder::always;
use scanbound_iec::ast::{Argument, Expr, Part, Path};
use scanbound_iec::fault::Fault;
use scanbound_iec::{Connected, Section, same, show};
use scanbound_ir::Step;

impl Emit<'_> {
    /// Copies what an instance's inputs are connected to, or its outputs.
    pub(super) fn connect(&mut self, instance: usize, connected: &Connected, outputs: bool) {
        let around = std::mem::replace(&mut self.file, connected.file);
        let file = u32::try_from(self.file).unwrap_or(u32::MAX);
        let place = Location { file, line: connected.line, step: None };
        self.builder.at(place, format!("PROGRAM {}", connected.name).into(), [].into());
        for one in connected.given.iter().filter(|one| one.is_output == outputs) {
            if let Err(fault) = self.connect_one(instance, one, connected.line) {
                self.fault(fault);
            }
        }
        self.file = around;
    }

    fn connect_one(&mut self, instance: usize, one: &Argument, line: u32) -> Result<(), Fault> {
        let place = self.instances[instance].place.clone();
        let name = one.name.clone().unwrap_or_default();
        let section = if one.is_output { Section::Output } else { Section::Input };
        let mut declared = self.pou_of(instance).variables.iter();
        let is_one = declared.any(|own| own.section == section && same(&own.name, &name));
        let Some(own) = Self::part(&place, &name).filter(|_| is_one) else {
            let kind = if one.is_output { "output" } else { "input" };
            let help = "connect a variable of VAR_INPUT by :=, and one of VAR_OUTPUT by =>";
            let told = format!("the program of {} has no {kind} {name}", place.name);
            return Err(Fault::new(line, told).code(Code::UnknownName).text(&name).help(help));
        };
        let unit = self.instances[instance].pou;
        let at = Context { instance, locals: None, unit };
        let outside = match &one.value {
            Expr::Variable(path) => self.outside(&at, path, line)?,
            Expr::Literal(_) | Expr::Negate(_) if !one.is_output => {
                let value = self.value(&at, &one.value, line)?;
                return self.copied_to(Found::Place(own), value, line);
            }
            other => return Err(refused(&show::expr(other), line)),
        };
        let (from, to) = if one.is_output { (own, outside) } else { (outside, own) };
        let Some(cell) = from.tag.cell() else {
            return self.copy_whole(&Whole::Place(from), &Whole::Place(to), line);
        };
        self.cost(&["LD"], "contact");
        let value = self.as_count(Some(cell), super::expr::read(cell, &from.ty));
        self.copied_to(Found::Place(to), value, line)
    }

    fn copied_to(&mut self, to: Found, value: Value, line: u32) -> Result<(), Fault> {
        let key = self.store_key(&to, None, line)?;
        let writes = self.writes(to, value, line)?;
        let effects = writes.into_iter().map(always).collect();
        self.builder.add(Some(key), effects, Step::Nothing);
        Ok(())
    }

    /// A global variable or an address: the variables of the program are not known there.
    fn outside(&mut self, at: &Context, path: &Path, line: u32) -> Result<Place, Fault> {
        let is_known = |part: &Part| match part {
            Part::Name(_) => true,
            Part::Index(all) => all.iter().all(|one| matches!(one, Expr::Literal(_))),
            Part::Bit(_) | Part::Dereference => false,
        };
        if !path.rest.iter().all(is_known) {
            return Err(refused(&show::path(path), line));
        }
        match self.find_outside(at, path, line)? {
            Found::Place(place) => Ok(place),
            _ => Err(refused(&show::path(path), line)),
        }
    }
}

fn refused(what: &str, line: u32) -> Fault {
    let help = "connect constants, global variables and addresses";
    let told = format!("what a program is connected to, {what}, is not followed");
    Fault::new(line, told).code(Code::NotModelled).help(help)
}
