//! The names that people know things by: devices with their comments, and the ways to an instruction.

use crate::program::{Area, BitTarget, Cell, Frame, Program, Radix, Role, Step, Write};
use crate::scan::model::{Origin, Variable};
use std::cmp::Reverse;
use std::collections::BTreeMap;

/// Looks up device comments and tells places.
pub struct Names<'a> {
    program: &'a Program,
    /// The areas, the longer names before those they begin with.
    areas: Vec<&'a Area>,
    comments: BTreeMap<String, &'a str>,
    /// The instructions that remember something in a cell that no device is.
    memories: BTreeMap<Cell, usize>,
}

impl<'a> Names<'a> {
    /// Over a program and the comments it came with.
    pub fn new(program: &'a Program) -> Names<'a> {
        let mut areas: Vec<&Area> = program.areas.iter().collect();
        areas.sort_by_key(|area| Reverse(area.name.len()));
        let comments = program
            .comments
            .iter()
            .map(|(name, comment)| (plain(&areas, name), comment.trim()))
            .filter(|(_, comment)| !comment.is_empty())
            .collect();
        let mut memories = BTreeMap::new();
        for (index, instruction) in program.instructions.iter().enumerate() {
            for effect in &instruction.effects {
                if let Write::Bit(BitTarget::Cell(cell), _) = effect.write
                    && program.area(cell.area).role == Role::Hidden
                {
                    memories.entry(cell).or_insert(index);
                }
            }
        }
        Names { program, areas, comments, memories }
    }

    /// What is free, by a name that people know.
    pub fn free(&self, variable: &Variable) -> String {
        match &variable.origin {
            Origin::Start(cell) => self.cell(*cell),
            Origin::Choice(key) => {
                let turns = key.frames.iter().filter_map(|&frame| self.turn(frame));
                turns.fold(variable.name.clone(), |name, turn| format!("{name}, {turn}"))
            }
            Origin::Forgotten(..) => variable.name.clone(),
        }
    }

    fn cell(&self, cell: Cell) -> String {
        let Some(&index) = self.memories.get(&cell) else { return self.program.cell_name(cell) };
        let at = &self.program.instructions[index];
        format!("last state of `{}` in line {}", at.text, at.place.line)
    }

    fn turn(&self, frame: Frame) -> Option<String> {
        match self.program.instructions[frame.at].step {
            Step::Call { .. } => None,
            Step::ForBegin { .. } => Some(format!("turn {}", frame.turn + 1)),
            _ => Some(format!("run {}", frame.turn + 1)),
        }
    }

    /// The comment of a device or of what is named after one (`T0 contact`); empty if there is none.
    pub fn comment(&self, name: &str) -> String {
        if self.comments.is_empty() {
            return String::new();
        }
        let device = name.split(' ').next().unwrap_or_default();
        let comment = self.comments.get(&plain(&self.areas, device));
        comment.map_or(String::new(), |comment| (*comment).to_owned())
    }

    /// The devices named by an instruction's text that have a comment, each with it.
    pub fn comments_in(&self, text: &str) -> Vec<String> {
        let mut found: Vec<String> = Vec::new();
        if self.comments.is_empty() {
            return found;
        }
        for operand in text.split(' ').skip(1) {
            let device = base(operand);
            let comment = self.comment(device);
            let entry = format!("{device} {comment}");
            if !comment.is_empty() && !found.contains(&entry) {
                found.push(entry);
            }
        }
        found
    }

    /// The device that a free variable is about.
    pub fn device(&self, variable: &Variable) -> String {
        let cell = match &variable.origin {
            Origin::Start(cell) | Origin::Forgotten(cell, _) => Some(*cell),
            Origin::Choice(key) => key.cell,
        };
        cell.map_or_else(|| variable.name.clone(), |cell| self.cell(cell))
    }

    /// The calls, loop turns and interrupts on the way to an instruction.
    pub fn via(&self, frames: &[Frame]) -> Vec<String> {
        frames.iter().map(|frame| self.frame(*frame)).collect()
    }

    fn frame(&self, frame: Frame) -> String {
        let interrupt = self.program.interrupts.iter().find(|one| one.entry == frame.at);
        let at = &self.program.instructions[frame.at];
        match (&at.step, interrupt) {
            (Step::Call { .. }, _) => format!("{} in line {}", at.text, at.place.line),
            (Step::ForBegin { .. }, _) => {
                format!("{} in line {}, turn {}", at.text, at.place.line, frame.turn + 1)
            }
            (_, Some(interrupt)) => format!("{}, run {}", interrupt.name, frame.turn + 1),
            _ => format!("{} in line {}", at.text, at.place.line),
        }
    }
}

/// A device's name as `Program::cell_name` writes it, where it is one; else as it stands.
fn plain(areas: &[&Area], name: &str) -> String {
    let name = name.trim().to_uppercase();
    for area in areas {
        let radix = match area.radix {
            Radix::Decimal => 10,
            Radix::Hexadecimal => 16,
            Radix::Octal => 8,
        };
        let rest = name.strip_prefix(area.name.as_str());
        if let Some(rest) = rest
            && u32::from_str_radix(rest, radix).is_ok()
        {
            let digits = rest.trim_start_matches('0');
            return format!("{}{}", area.name, if digits.is_empty() { "0" } else { digits });
        }
    }
    name
}

/// The device within an operand: without the digits of a group in front, an index or a bit behind.
fn base(operand: &str) -> &str {
    let mut device = operand.trim_start_matches('@');
    if let Some(rest) = device.strip_prefix('K') {
        let behind = rest.trim_start_matches(|c: char| c.is_ascii_digit());
        if !behind.is_empty() && behind.len() < rest.len() {
            device = behind;
        }
    }
    device = device.split('.').next().unwrap_or(device);
    match device.rfind('Z') {
        Some(at) if at > 0 && device[..at].ends_with(|c: char| c.is_ascii_hexdigit()) => {
            &device[..at]
        }
        _ => device,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::program::AreaKind;

    fn program(comments: &[(&str, &str)]) -> Program {
        let area = |name: &str, radix| Area::new(name, AreaKind::Bit, radix);
        Program {
            areas: vec![
                area("X", Radix::Hexadecimal),
                area("D", Radix::Decimal),
                area("Z", Radix::Decimal),
                area("ZR", Radix::Decimal),
            ],
            comments: comments
                .iter()
                .map(|&(name, comment)| (name.to_owned(), comment.to_owned()))
                .collect(),
            ..Program::default()
        }
    }

    #[test]
    fn a_comment_is_found_however_the_device_is_written() {
        let program =
            program(&[("X00A", "start"), ("D100", "step"), ("ZR5", "recipe"), ("D1", " ")]);
        let names = Names::new(&program);
        for (name, comment) in [
            ("XA", "start"),
            ("X0A", "start"),
            ("D100", "step"),
            ("D100 behind line 3", "step"),
            ("D1", ""),
        ] {
            assert_eq!(names.comment(name), comment, "{name}");
        }
        assert_eq!(
            names.comments_in("MOV K4X0A D100Z2 ZR5.F D1 D100"),
            ["X0A start", "D100 step", "ZR5 recipe"]
        );
    }
}
