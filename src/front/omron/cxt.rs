//! Reads CX-Programmer's text files (`.cxt`): programs, their rungs' mnemonics, symbols, the CPU.
//!
//! `Key:=value;` are values, `Key:=` before BEGIN and END a block, before a mark `$?St$Bk?_#[n]` a text up to the
//! same mark, before BEGIN_LIST a list of lines. A rung's mnemonics stand under `SL`, symbols under `VariableList`
//! as name, address, type, three further columns and the comment. Tasks from 256 on are cyclic, below interrupts.

use super::list;
use super::source::{Family, RawFile, RawProgram, Symbol, Symbols, Task};
use crate::base::code::Code;
use crate::front::Faults;

/// What opens and closes a text.
const MARK: &str = "$?St$Bk?_#[";

/// Numbers of cyclic tasks begin here.
const FIRST_CYCLIC: u32 = 256;

/// Whether the beginning of a file is such a text.
pub(super) fn sniff(beginning: &str) -> bool {
    if !beginning.contains(":=") {
        return false;
    }
    let keys = beginning.lines().take(200).filter(|line| {
        let key = line.trim_start().split(":=").next().unwrap_or_default();
        line.contains(":=")
            && !key.is_empty()
            && key.chars().all(|c| c.is_alphanumeric() || "_[]".contains(c))
    });
    let blocks = beginning.lines().any(|line| line.trim() == "BEGIN");
    keys.count() >= 3
        && blocks
        && (beginning.contains(MARK)
            || beginning.contains("CXProgVer")
            || beginning.contains("SL:="))
}

/// The family of a device by its name.
///
/// # Errors
/// Why there is none: its special bits stand elsewhere than in either family.
pub(super) fn family(cpu: &str) -> Result<Family, String> {
    let device = cpu.trim().to_ascii_uppercase();
    let is = |names: &[&str]| names.iter().any(|name| device.starts_with(name));
    if is(&["C200", "C1000", "C2000", "CQM1", "CPM", "SRM"]) {
        Ok(Family::C)
    } else if is(&["C20", "C28", "C40", "C60", "C500", "C120", "CV"]) {
        Err(format!(
            "the program is for {}, whose special bits stand elsewhere than those of the CPUs that are known",
            cpu.trim()
        ))
    } else {
        Ok(Family::Cs)
    }
}

/// Reads a file.
pub(super) fn read(text: &str, name: &str, faults: &mut Faults<'_>) -> RawFile {
    let lines: Vec<&str> = text.lines().collect();
    let mut reader = Reader {
        file: RawFile { name: name.to_owned(), ..RawFile::default() },
        text,
        lines: &lines,
        at: 0,
        path: Vec::new(),
        faults,
    };
    reader.run();
    reader.file
}

struct Reader<'a, 'f> {
    file: RawFile,
    text: &'a str,
    lines: &'a [&'a str],
    at: usize,
    /// The keys of the open blocks, without their index in brackets.
    path: Vec<String>,
    faults: &'a mut Faults<'f>,
}

impl Reader<'_, '_> {
    fn run(&mut self) {
        while let Some(&line) = self.lines.get(self.at) {
            self.at += 1;
            let line = line.trim();
            match line.split_once(":=") {
                Some((key, "")) => self.block(key.trim()),
                Some((key, value)) => {
                    let value = value.trim().trim_end_matches(';').trim_matches('"');
                    self.value(key.trim(), value);
                }
                None if line.trim_end_matches(';') == "END" && self.path.pop().is_none() => {
                    self.broken(line, "this END closes no block");
                }
                None => {}
            }
        }
        if !self.path.is_empty() {
            let last = self.lines.last().copied().unwrap_or_default();
            self.at = self.lines.len();
            self.broken(last, "the file ends within a block");
        }
        if self.file.programs.is_empty() {
            self.at = 1;
            self.broken("", "the project holds no program with rungs");
        }
    }

    fn broken(&mut self, text: &str, message: &str) {
        let line = u32::try_from(self.at.max(1)).unwrap_or(u32::MAX);
        self.faults.at(
            Code::BrokenProject,
            line,
            text,
            message,
            "save the project as text (.cxt) again",
        );
    }

    /// What follows a key without a value: a block, a text, a list.
    fn block(&mut self, key: &str) {
        let next = self.lines.get(self.at).map_or("", |line| line.trim());
        if next == "BEGIN" {
            self.at += 1;
            self.open(key);
        } else if next.starts_with(MARK) {
            self.text(key);
        } else if let Some(number) = next.strip_prefix("BEGIN_LIST_") {
            self.at += 1;
            let end = format!("END_LIST_{number}");
            while let Some(&line) = self.lines.get(self.at) {
                self.at += 1;
                if line.trim().trim_end_matches(';') == end {
                    return;
                }
                if key == "VariableList" {
                    self.symbol(line);
                }
            }
            self.broken(next, "this list has no end");
        }
    }

    fn open(&mut self, key: &str) {
        let name = key.split('[').next().unwrap_or(key).to_owned();
        if name == "Program" && self.path.last().is_some_and(|parent| parent == "Programs") {
            let number = self.file.programs.len();
            self.file.programs.push(RawProgram {
                name: format!("program {number}"),
                task: Task::Each,
                symbols: Symbols::new(),
                instructions: Vec::new(),
            });
        }
        self.path.push(name);
    }

    fn within(&self, block: &str) -> bool {
        self.path.iter().any(|key| key == block)
    }

    fn value(&mut self, key: &str, value: &str) {
        let parent = self.path.last().map_or("", String::as_str);
        match (parent, key) {
            ("PLC", "Config") => {
                let part = |name: &str| {
                    value.split([';', ']']).find_map(|part| part.trim().strip_prefix(name))
                };
                let words: Vec<&str> = [part("DEV:"), part("CPU:")].into_iter().flatten().collect();
                self.file.cpu = (!words.is_empty()).then(|| words.join(" "));
            }
            ("Program", "Name") => {
                if let Some(program) = self.file.programs.last_mut() {
                    value.clone_into(&mut program.name);
                }
            }
            ("Program", "TaskID") => {
                if let (Some(program), Ok(task)) =
                    (self.file.programs.last_mut(), value.parse::<u32>())
                {
                    program.task = if task < FIRST_CYCLIC {
                        Task::Interrupt(task)
                    } else {
                        Task::Cyclic(task - FIRST_CYCLIC)
                    };
                }
            }
            ("R", "SL") if !value.is_empty() && self.within("Programs") => {
                let line = value.to_owned();
                self.rung(&line, self.at);
            }
            _ => {}
        }
    }

    /// A text between two marks; the second may stand behind the last line's text.
    fn text(&mut self, key: &str) {
        let opening = self.lines[self.at].trim();
        let end = opening.find(']').map_or(opening.len(), |end| end + 1);
        let (mark, first) = opening.split_at(end);
        let (mark, begin) = (mark.to_owned(), self.at);
        let rung = key == "SL"
            && self.path.last().is_some_and(|parent| parent == "R")
            && self.within("Programs");
        let mut rest = Some(first);
        loop {
            let Some(line) = rest.take().or_else(|| self.lines.get(self.at).copied()) else {
                self.at = begin + 1;
                self.broken(opening, "this text has no end");
                self.at = self.lines.len();
                return;
            };
            self.at += 1;
            let (text, closed) = match line.split_once(mark.as_str()) {
                Some((text, _)) => (text, true),
                None => (line, false),
            };
            if rung {
                self.rung(text, self.at);
            }
            if closed {
                return;
            }
        }
    }

    fn rung(&mut self, line: &str, number: usize) {
        let Some(program) = self.file.programs.last_mut() else { return };
        let number = u32::try_from(number).unwrap_or(u32::MAX);
        list::read_line(self.text, line, number, &mut program.instructions, self.faults);
    }

    /// A symbol: `name,address,type,,,,"comment";`
    fn symbol(&mut self, line: &str) {
        let mut reader = csv::ReaderBuilder::new()
            .has_headers(false)
            .flexible(true)
            .from_reader(line.trim().trim_end_matches(';').as_bytes());
        let Some(Ok(record)) = reader.records().next() else { return };
        let field = |at: usize| record.get(at).unwrap_or_default().trim().to_owned();
        let symbol = Symbol { address: field(1), kind: field(2), comment: field(6) };
        if field(0).is_empty() {
            return;
        }
        let symbols = match self
            .file
            .programs
            .last_mut()
            .filter(|_| self.path.iter().any(|key| key == "Program"))
        {
            Some(program) => &mut program.symbols,
            None => &mut self.file.symbols,
        };
        symbols.insert(field(0), symbol);
    }
}
