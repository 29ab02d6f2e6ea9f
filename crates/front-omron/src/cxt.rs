//! Reads CX-Programmer's text files (`.cxt`): programs, the mnemonics of rungs, symbols, the CPU.
//!
//! `Key:=value;` is a value. After `Key:=` alone follows a block (BEGIN to END), a text between two equal marks
//! `$?St$Bk?_#[n]`, or a list of lines (BEGIN_LIST). A rung's mnemonics have the key `SL`. Symbols are in
//! `VariableList`: name, address, type, three other columns and the comment. Task numbers from 256 on are cyclic tasks,
//! lower ones interrupt tasks.
//!
//! Nothing within `Programs` is skipped: each program must have its sections, each section as many rungs as it states,
//! and each rung its mnemonics. Other blocks that may contain code are refused.

use super::list;
use super::source::{Family, RawFile, RawProgram, Symbol, Symbols, Task};
use scanbound_base::code::Code;
use scanbound_front::Faults;

/// The beginning of the mark that stands before and after a text.
const MARK: &str = "$?St$Bk?_#[";

/// The lowest number of a cyclic task.
const FIRST_CYCLIC: u32 = 256;

/// The blocks that contain rungs, from the outside in. For each block: its name, the name of the block that contains
/// it, and the key with which the containing block states how many such blocks it has.
const LEVELS: [Level; 5] = [
    Level { name: "Program", parent: "Programs", count: Some("ProgramCount") },
    Level { name: "Sections", parent: "Program", count: None },
    Level { name: "Sec", parent: "Sections", count: Some("SC") },
    Level { name: "ProgramData", parent: "Sec", count: None },
    Level { name: "R", parent: "ProgramData", count: Some("RC") },
];

/// Blocks that contain no code, neither directly nor in other blocks.
const NO_CODE: [&str; 2] = ["LocalVariables", "AtchCmts"];

/// Keys of texts that contain no code.
const NO_CODE_TEXTS: [&str; 2] = ["Com", "Comment"];

/// A block that contains rungs, directly or in other blocks.
struct Level {
    name: &'static str,
    parent: &'static str,
    /// The parent's key for the number of these blocks. `None`: the parent has exactly one such block.
    count: Option<&'static str>,
}

/// A block of the file whose END was not read yet.
struct Block {
    /// The key of the block, without an index in brackets.
    name: String,
    /// The line where the block begins.
    line: usize,
    /// The number of blocks with rungs that were found in the block so far; for a rung, the number of mnemonic lists.
    contained: u32,
    /// The number of contained blocks that the file states for the block. `None` if it states none.
    stated: Option<u32>,
}

/// Whether the beginning of a file looks like a CX-Programmer text file: lines `Key:=value;` with this format's keys.
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

/// The family of a CPU by its name. A name that is not known counts as one of CS, CJ and CP.
///
/// # Errors
/// The CPU is known to belong to neither family: its special bits have other addresses.
pub(super) fn family(cpu: &str) -> Result<Family, String> {
    let device = cpu.trim().to_ascii_uppercase();
    let is = |names: &[&str]| names.iter().any(|name| device.starts_with(name));
    if is(&["C200", "C1000", "C2000", "CQM1", "CPM", "SRM"]) {
        Ok(Family::C)
    } else if is(&["C20", "C28", "C40", "C60", "C500", "C120", "CV"]) {
        Err(format!(
            "the program is for {}, whose special bits have other addresses than those of supported CPUs",
            cpu.trim()
        ))
    } else {
        Ok(Family::Cs)
    }
}

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
    /// The open blocks, outermost first.
    path: Vec<Block>,
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
                None if line.trim_end_matches(';') == "END" => match self.path.pop() {
                    Some(block) => self.check_block(&block),
                    None => self.broken(line, "this END has no BEGIN"),
                },
                None if !line.is_empty() && self.holds_code() => {
                    self.broken(line, "this line has no key (`KEY := value`), or the mark before a text is missing");
                }
                None => {}
            }
        }
        if !self.path.is_empty() {
            let last = self.lines.last().copied().unwrap_or_default();
            self.at = self.lines.len();
            self.broken(last, "the file ends inside a block");
        }
        if self.file.programs.is_empty() {
            self.at = 1;
            self.broken("", "the project contains no program");
        }
    }

    fn broken(&mut self, text: &str, message: &str) {
        let line = u32::try_from(self.at.max(1)).unwrap_or(u32::MAX);
        self.faults.error_in_line(
            Code::BrokenProject,
            line,
            text,
            message,
            "save the project as text (.cxt) again",
        );
    }

    /// Reads what follows a key without a value: a block, a text or a list.
    fn block(&mut self, key: &str) {
        let next = self.lines.get(self.at).map_or("", |line| line.trim());
        if next == "BEGIN" {
            self.at += 1;
            self.open_block(key);
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
        } else if self.holds_code() {
            self.broken(key, "this key has no value: BEGIN, or the mark before a text, is missing");
        }
    }

    /// Whether the current block may contain code: it is in `Programs`, and not in a block without code.
    fn holds_code(&self) -> bool {
        let is = |names: &[&str]| self.path.iter().any(|one| names.contains(&one.name.as_str()));
        is(&["Programs"]) && !is(&NO_CODE)
    }

    /// Whether the innermost block has this name.
    fn is_in(&self, name: &str) -> bool {
        self.path.last().is_some_and(|block| block.name == name)
    }

    fn open_block(&mut self, key: &str) {
        let name = key.split('[').next().unwrap_or(key);
        let level = LEVELS.iter().find(|level| level.name == name && self.is_in(level.parent));
        if self.holds_code() {
            match level {
                Some(level) => self.count_block(level, key),
                None if NO_CODE.contains(&name) => {}
                None => self.broken(
                    key,
                    "scanbound does not read this block: it reads only sections with ladder rungs or mnemonics",
                ),
            }
        }
        if level.is_some_and(|level| level.name == "Program") {
            let number = self.file.programs.len();
            self.file.programs.push(RawProgram {
                name: format!("program {number}"),
                task: Task::Each,
                symbols: Symbols::new(),
                instructions: Vec::new(),
            });
        }
        let (name, line) = (name.to_owned(), self.at - 1);
        self.path.push(Block { name, line, contained: 0, stated: None });
    }

    /// Raises by one the number of blocks that the current block contains. Reports an error if the index of the new
    /// block is not the next number.
    fn count_block(&mut self, level: &Level, key: &str) {
        let Some(parent) = self.path.last_mut() else { return };
        let place = parent.contained;
        parent.contained += 1;
        let number = key.split_once('[').map(|(_, number)| number.trim_end_matches(']'));
        if level.count.is_some() && number.is_some_and(|number| number.parse() != Ok(place)) {
            let message = format!("{}[{place}] is missing before this one", level.name);
            self.broken(key, &message);
        }
    }

    /// Checks that a finished block contains the number of blocks that it states, or exactly one if its format has no
    /// such number. A missing number is an error, except for the number of programs.
    fn check_block(&mut self, block: &Block) {
        if !(self.holds_code() || block.name == "Programs") {
            return;
        }
        let contained = LEVELS.iter().find(|level| level.parent == block.name);
        let (what, count) = match contained {
            Some(Level { name, count, .. }) => (*name, *count),
            None if block.name == "R" => ("SL", None),
            None => return,
        };
        let message = match (count, block.stated) {
            (None, _) if block.contained == 1 => return,
            (None, _) => format!(
                "the block {} must contain one {what}, but contains {}",
                block.name, block.contained
            ),
            (Some(_), Some(stated)) if stated == block.contained => return,
            (Some(count), Some(stated)) => {
                format!("{count} is {stated}, but the file contains {} {what}", block.contained)
            }
            // Older files do not state the number of programs.
            (Some("ProgramCount"), None) => return,
            (Some(count), None) => {
                format!("{} does not state how many {what} it contains ({count})", block.name)
            }
        };
        let (end, text) = (self.at, self.lines.get(block.line.saturating_sub(1)).copied());
        self.at = block.line;
        self.broken(text.unwrap_or_default().trim(), &message);
        self.at = end;
    }

    fn within(&self, block: &str) -> bool {
        self.path.iter().any(|one| one.name == block)
    }

    fn value(&mut self, key: &str, value: &str) {
        let counts =
            LEVELS.iter().find(|level| level.count == Some(key) && self.is_in(level.parent));
        if let (Some(_), Some(block)) = (counts, self.path.last_mut()) {
            block.stated = value.parse().ok();
        }
        let parent = self.path.last().map_or("", |block| block.name.as_str());
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
            ("R", "SL") if self.within("Programs") => {
                let line = value.to_owned();
                self.list();
                self.rung(&line, self.at);
            }
            _ => {}
        }
    }

    /// Reads a text between two marks. The second mark may follow the last line of text directly.
    fn text(&mut self, key: &str) {
        let opening = self.lines[self.at].trim();
        let end = opening.find(']').map_or(opening.len(), |end| end + 1);
        let (mark, first) = opening.split_at(end);
        let (mark, begin) = (mark.to_owned(), self.at);
        let rung = key == "SL" && self.is_in("R") && self.within("Programs");
        if rung {
            self.list();
        } else if self.holds_code() && !NO_CODE_TEXTS.contains(&key) {
            let message = format!(
                "scanbound does not read `{key}`: it expects the mnemonics of a rung under `SL`"
            );
            self.broken(key, &message);
        }
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

    /// Raises the number of mnemonic lists of the current rung by one.
    fn list(&mut self) {
        if let Some(rung) = self.path.last_mut() {
            rung.contained += 1;
        }
    }

    fn rung(&mut self, line: &str, number: usize) {
        let Some(program) = self.file.programs.last_mut() else { return };
        let number = u32::try_from(number).unwrap_or(u32::MAX);
        list::read_line(self.text, line, number, &mut program.instructions, self.faults);
    }

    /// Reads a symbol: `name,address,type,,,,"comment";`
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
            .filter(|_| self.path.iter().any(|block| block.name == "Program"))
        {
            Some(program) => &mut program.symbols,
            None => &mut self.file.symbols,
        };
        symbols.insert(field(0), symbol);
    }
}
