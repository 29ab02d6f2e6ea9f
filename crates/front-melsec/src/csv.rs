//! Reads the program CSV of GX Works2, GX Works3 and GX Developer.
//!
//! Row 1 is a title, row 2 names the CPU, row 3 has the headings of seven columns: step number, line statement,
//! instruction, device, blank, PI statement, note. Columns are found by position, because headings exist in every
//! language. GX Works3 imports operands in four forms (GX Works3 Operating Manual, SH(NA)-081215ENG, "CSV file format"
//! of programs): on their own rows, in the device cell, in the instruction cell, or mixed.

use ::csv::{ReaderBuilder, StringRecord};
use scanbound_base::code::Code;
use scanbound_base::diagnostic::Diagnostic;

use super::memory::Family;
use super::source::RawInstruction;
use super::words;
use scanbound_front::WordPositions;
use scanbound_front::{Faults, shown};

/// The tool that wrote a CSV.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Tool {
    /// GX Works2 and GX Developer.
    Works2,
    /// GX Works3.
    Works3,
}

/// How a program's CSV is laid out, and what its heading rows say.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Layout {
    /// The tool that wrote the file.
    pub(super) tool: Tool,
    /// The CPU that the file names. `None` if it names none.
    pub(super) cpu: Option<String>,
    delimiter: u8,
    /// The number of records before the first instruction, the row of column headings included.
    heading: usize,
    columns: usize,
}

/// Headings of the instruction column. The Korean ones are known only from imitations of the tools' output.
const INSTRUCTION_HEADS: [&str; 5] = ["instruction", "命令", "指令", "명령", "명령어"];
/// Texts before the CPU name in files of GX Works2 and GX Developer.
const WORKS2_MARKS: [&str; 7] =
    ["plcinformation", "plctype", "pc情報", "pcタイプ", "plc信息", "plc类型", "plc정보"];
/// Texts before the CPU name in files of GX Works3.
const WORKS3_MARKS: [&str; 5] = ["moduletype", "機種情報", "机型信息", "기종정보", "모듈타입"];
/// Words in the headings by which the code page is recognised.
pub(super) const MARKS: [&str; 12] = [
    "命令",
    "ステップ",
    "デバイス",
    "情報",
    "指令",
    "步号",
    "信息",
    "元件",
    "명령",
    "스텝",
    "정보",
    "디바이스",
];

/// The number of rows at the beginning in which the headings must be.
const HEADING_ROWS: usize = 6;
/// The column of the step number; columns are counted from 0.
const STEP: usize = 0;
/// The column of the line statement.
const STATEMENT: usize = 1;
/// The column of the instruction.
const INSTRUCTION: usize = 2;
/// The column of the device.
const DEVICE: usize = 3;

/// The layout of a program's CSV, found in the first 8192 characters of the file. `None` if the file is not such a CSV.
pub(super) fn layout(beginning: &str) -> Option<Layout> {
    // The headings are near the start: an unclosed quotation mark must not hide the whole file.
    let end = beginning.char_indices().nth(8192).map_or(beginning.len(), |(at, _)| at);
    let text = &beginning[..end];
    let delimiters = [b'\t', b',', b';'].into_iter();
    let mut used = delimiters.filter(|&delimiter| text.as_bytes().contains(&delimiter));
    used.find_map(|delimiter| layout_with(text, delimiter, &|| is_code(beginning)))
}

fn layout_with(beginning: &str, delimiter: u8, is_code: &dyn Fn() -> bool) -> Option<Layout> {
    let records: Vec<StringRecord> = reader(beginning, delimiter)
        .into_records()
        .take(HEADING_ROWS)
        .map_while(Result::ok)
        .collect();
    for (index, record) in records.iter().enumerate() {
        let above = index.checked_sub(1).map(|above| &records[above]);
        let known = record.len() > DEVICE
            && INSTRUCTION_HEADS.contains(&plain(&record[INSTRUCTION]).as_str());
        // Headings in an unknown language: seven words, none a number, below the row of the CPU. Lines of Structured
        // Text may have as many commas, so those are excluded.
        let shaped = record.len() == 7
            && record.iter().take(DEVICE + 1).all(|head| !head.trim().is_empty())
            && !record[STEP].trim().starts_with(|c: char| c.is_ascii_digit())
            && above.is_some_and(|row| row.len() <= 7 && row[0].contains([':', '：']))
            && !record.iter().chain(above.into_iter().flatten()).any(|cell| cell.contains(":="))
            && !is_code();
        if known || shaped {
            let (tool, cpu) = machine(&records[..index], record);
            let columns = record.len();
            return Some(Layout { tool, cpu, delimiter, heading: index + 1, columns });
        }
    }
    None
}

/// Whether a text is IEC 61131-3 code: it contains a keyword such as END_VAR or END_PROGRAM.
fn is_code(text: &str) -> bool {
    const ENDS: [&str; 6] =
        ["END_VAR", "END_TYPE", "END_STRUCT", "END_PROGRAM", "END_STEP", "END_CONFIGURATION"];
    let word = |word: &str| {
        word.trim_matches(|c: char| !c.is_alphanumeric() && c != '_').to_ascii_uppercase()
    };
    text.split_whitespace().any(|own| ENDS.contains(&word(own).as_str()))
}

/// The tool and the CPU, from the rows above the headings. The CPU is `None` if no row names it.
fn machine(above: &[StringRecord], heads: &StringRecord) -> (Tool, Option<String>) {
    for (index, row) in above.iter().enumerate().rev() {
        let Some((label, inline)) = row[0].split_once([':', '：']) else { continue };
        let label = plain(label);
        // The first row is the project's title, which may be any text.
        let known =
            WORKS2_MARKS.contains(&label.as_str()) || WORKS3_MARKS.contains(&label.as_str());
        if index == 0 && !known {
            continue;
        }
        let value = row.iter().skip(1).find(|cell| !cell.trim().is_empty()).unwrap_or(inline);
        let works3 = WORKS3_MARKS.contains(&label.as_str())
            || (!WORKS2_MARKS.contains(&label.as_str()) && is_works3_cpu(value));
        return (if works3 { Tool::Works3 } else { Tool::Works2 }, cpu(value));
    }
    let works3 = heads.get(5).is_some_and(|head| plain(head).starts_with("p/i"));
    (if works3 { Tool::Works3 } else { Tool::Works2 }, None)
}

fn is_works3_cpu(value: &str) -> bool {
    value.starts_with("RCPU") || value.starts_with("FX5")
}

/// The CPU type in a text such as `QCPU (Q mode) Q26UDV`: the last word that begins with a letter and has a digit,
/// otherwise the first word if it has only letters. `None` if there is neither.
fn cpu(value: &str) -> Option<String> {
    let of_type = |word: &&str| {
        word.starts_with(|c: char| c.is_ascii_alphabetic())
            && word.contains(|c: char| c.is_ascii_digit())
    };
    let words = || value.split_whitespace();
    words()
        .rev()
        .find(of_type)
        .or_else(|| words().next().filter(|word| word.bytes().all(|b| b.is_ascii_alphabetic())))
        .map(str::to_owned)
}

/// A heading without blanks and in lower case, to compare it.
fn plain(head: &str) -> String {
    head.chars().filter(|c| !c.is_whitespace()).flat_map(char::to_lowercase).collect()
}

fn reader(text: &str, delimiter: u8) -> ::csv::Reader<&[u8]> {
    ReaderBuilder::new()
        .delimiter(delimiter)
        .has_headers(false)
        .flexible(true)
        .from_reader(text.as_bytes())
}

/// Reads the instructions of a program's CSV, and checks the file as a whole. Rows with errors are reported and left
/// out.
pub(super) fn read(text: &str, layout: &Layout, faults: &mut Faults<'_>) -> Vec<RawInstruction> {
    let mut body = Body { text, instructions: Vec::new(), open: None, steps: Vec::new(), faults };
    let mut lines = Lines { text, counted: 0, line: 1 };
    let mut reader = reader(text, layout.delimiter);
    let mut record = StringRecord::new();
    let mut index = 0_usize;
    let mut start = 0;
    while let Ok(true) = reader.read_record(&mut record) {
        start = lines.start_of(record.position().map_or(0, ::csv::Position::byte));
        if index >= layout.heading {
            body.row(&record, layout.columns, lines.line, start);
        }
        index += 1;
        if words::are_too_many(&body.instructions, body.faults) {
            return body.instructions;
        }
    }
    body.close();
    if is_open(&text[start..], layout.delimiter) {
        body.faults.error_in_line(
            Code::OpenQuote,
            lines.line,
            first_line(&text[start..]),
            "the quotation mark that begins here is never closed",
            "export the file again: the file may be truncated",
        );
    }
    let Body { instructions, steps, faults, .. } = body;
    words::check(&instructions, lines.line, faults);
    let family = layout.cpu.as_deref().and_then(Family::of_cpu);
    check_steps(&steps, layout.tool == Tool::Works2, family, faults);
    instructions
}

/// A row with a step number.
struct StepRow {
    line: u32,
    step: u32,
    /// The instruction cell and the device cell; empty if the row has neither.
    instruction: String,
}

/// A number of steps that the instruction or statement in one row of an export certainly does not exceed. It is
/// generous: instructions occupy some 20 steps at most, and long statements some 30.
const MOST_STEPS: u32 = 64;

/// Adds an error for each row whose step number shows that rows before it are missing. Does nothing if the file already
/// has errors.
fn check_steps(rows: &[StepRow], is_works2: bool, family: Option<Family>, faults: &mut Faults<'_>) {
    if faults.any_error() {
        return;
    }
    let is_known = is_works2 && matches!(family, Some(Family::Q | Family::L));
    let mut missing = |row: &StepRow, first: u32| {
        let last = row.step.saturating_sub(1);
        let which = match last > first {
            true => format!("steps between {first} and {last} are missing"),
            false => format!("step {first} is missing"),
        };
        let (message, help) = (
            format!("{which} before this row"),
            "rows of the export are missing: export the file again",
        );
        let (file, text) = (faults.file(), shown(&row.instruction));
        let fault = Diagnostic::line(Code::StepOrder, file, row.line, text, message, help);
        faults.push(fault.at_step(Some(row.step)));
    };
    if let Some(first) = rows.first().filter(|first| first.step > 0) {
        missing(first, 0);
    }
    for (row, next) in rows.iter().zip(rows.iter().skip(1)) {
        let most = if is_known && is_one_step(&row.instruction) { 1 } else { MOST_STEPS };
        if next.step > row.step.saturating_add(most) {
            missing(next, row.step + 1);
        }
    }
}

/// The lowest number at which relays of the Q and L series may be extended ones: M8192, and B2000 in hexadecimal.
const FIRST_EXTENDED: u32 = 8192;

/// Whether an instruction certainly occupies one step on the Q and L series: a contact of a relay by its number, or an
/// instruction that combines results.
fn is_one_step(instruction: &str) -> bool {
    let mut words = instruction.split_whitespace();
    let (mnemonic, device) = (words.next().unwrap_or_default(), words.next());
    let Some(device) = device else {
        return matches!(mnemonic, "ANB" | "ORB" | "MPS" | "MRD" | "MPP");
    };
    let is_contact = matches!(mnemonic, "LD" | "LDI" | "AND" | "ANI" | "OR" | "ORI");
    let number = device.strip_prefix(['X', 'Y', 'M', 'L', 'B']).unwrap_or_default();
    let radix = if device.starts_with(['X', 'Y', 'B']) { 16 } else { 10 };
    // Devices with larger numbers are extended ones, whose contacts occupy more steps.
    let is_extended =
        u32::from_str_radix(number, radix).map_or(true, |number| number >= FIRST_EXTENDED);
    is_contact && words.next().is_none() && !is_extended
}

/// Whether the record at the start of `tail` has an unclosed quotation mark.
fn is_open(tail: &str, delimiter: u8) -> bool {
    let tail = tail.trim_end_matches(['\r', '\n']);
    if tail.is_empty() {
        return false;
    }
    // A row appended to it becomes a separate row only if all quotation marks are closed.
    let probed = [tail, "\nx"].concat();
    reader(&probed, delimiter).into_records().map_while(Result::ok).count() == 1
}

fn first_line(text: &str) -> &str {
    text.lines().next().unwrap_or_default()
}

/// Counts the lines of the text while it is read from the beginning to the end: `line` is the line, from 1, at the byte
/// offset `counted`.
struct Lines<'a> {
    text: &'a str,
    counted: usize,
    line: u32,
}

impl Lines<'_> {
    /// Moves to the record that the CSV reader reports at a byte offset. The line ends there may belong to the record
    /// before, so they are skipped. Returns the byte offset at which the record really begins.
    fn start_of(&mut self, byte: u64) -> usize {
        let bytes = self.text.as_bytes();
        let mut start =
            usize::try_from(byte).unwrap_or(usize::MAX).clamp(self.counted, bytes.len());
        while bytes.get(start).is_some_and(|b| matches!(b, b'\r' | b'\n')) {
            start += 1;
        }
        let ends = bytes[self.counted..start].iter().filter(|&&b| b == b'\n').count();
        self.line = self.line.saturating_add(u32::try_from(ends).unwrap_or(u32::MAX));
        self.counted = start;
        start
    }
}

/// The rows below the headings, while they are converted to instructions.
struct Body<'a, 'f, 'n> {
    text: &'a str,
    instructions: Vec<RawInstruction>,
    /// The instruction whose operands may continue on the next row. `None` if there is none.
    open: Option<Pending>,
    /// The rows that have a step number.
    steps: Vec<StepRow>,
    faults: &'f mut Faults<'n>,
}

/// An instruction whose later operands may be on the next rows.
struct Pending {
    line: u32,
    step: Option<u32>,
    mnemonic: String,
    operands: Vec<String>,
    /// For the mnemonic and for each operand: the line of the row on which it stands.
    rows: Vec<u32>,
}

impl Body<'_, '_, '_> {
    fn row(&mut self, record: &StringRecord, columns: usize, line: u32, start: usize) {
        let cell = |column: usize| record.get(column).unwrap_or_default().trim();
        let fault = |faults: &mut Faults<'_>, code, message: &str, help| {
            faults.error_in_line(code, line, first_line(&self.text[start..]), message, help);
        };
        if record.len() < columns
            || record.iter().skip(columns).any(|extra| !extra.trim().is_empty())
        {
            let cells = match record.len() {
                1 => "1 cell".to_owned(),
                n => format!("{n} cells"),
            };
            let message = format!("this row has {cells}, but the heading row has {columns}");
            let help = "export the file again: the file may be truncated, or a spreadsheet program may have saved it; put a text that contains a separator in quotation marks";
            fault(self.faults, Code::Columns, &message, help);
            return;
        }
        if [STEP, INSTRUCTION, DEVICE].iter().any(|&column| cell(column).contains(['\n', '\r'])) {
            let message = "a quotation mark in this row is not closed before the end of the line";
            fault(self.faults, Code::OpenQuote, message, "export the file again");
            return;
        }
        let step = match cell(STEP) {
            "" => None,
            digits => match digits.parse::<u32>() {
                Ok(step) => Some(step),
                Err(_) => {
                    let message = format!("'{}' is not a step number", shown(digits));
                    let help = "export the file again: each field of the first column must be a step number or empty";
                    fault(self.faults, Code::StepNumber, &message, help);
                    return;
                }
            },
        };
        if let Some(step) = step {
            let instruction = format!("{} {}", cell(INSTRUCTION), cell(DEVICE)).trim().to_owned();
            self.steps.push(StepRow { line, step, instruction });
        }
        let mut found = Vec::new();
        for column in [INSTRUCTION, DEVICE] {
            match words::split(cell(column)) {
                Ok(more) => found.extend(more),
                Err(_) => {
                    let message = "a string has no closing quotation mark";
                    fault(self.faults, Code::OpenString, message, "close the string with \"");
                    return;
                }
            }
        }
        if cell(INSTRUCTION).is_empty() {
            if found.is_empty() {
                // A statement ends the instruction before it; notes and PI statements belong to it.
                if step.is_some() || !cell(STATEMENT).is_empty() {
                    self.close();
                }
                return;
            }
            let Some(open) = &mut self.open else {
                let message = "this row has an operand, but no instruction comes before it";
                let help = "export the file again: a row with only a device continues the instruction above it, and that instruction is missing";
                fault(self.faults, Code::StrayOperand, message, help);
                return;
            };
            open.rows.extend(found.iter().map(|_| line));
            open.operands.extend(found.into_iter().map(str::to_owned));
            return;
        }
        self.close();
        let (mnemonic, operands) = found.split_first().map_or(("", &[][..]), |(m, o)| (*m, o));
        if !words::can_be_mnemonic(mnemonic) {
            let message = "the text in the instruction column of this row is not a mnemonic";
            let help =
                "export the file again: the third column must contain mnemonics such as LD or MOV";
            fault(self.faults, Code::NotAnInstruction, message, help);
            return;
        }
        let rows = vec![line; found.len()];
        let operands = operands.iter().map(|&operand| operand.to_owned()).collect();
        self.open = Some(Pending { line, step, mnemonic: mnemonic.to_owned(), operands, rows });
    }

    /// Adds the pending instruction, if there is one, to the list of instructions.
    fn close(&mut self) {
        if let Some(Pending { line, step, mnemonic, operands, rows }) = self.open.take() {
            let places = WordPositions::Rows(rows.into());
            self.instructions.push(words::instruction(line, step, &mnemonic, operands, places));
        }
    }
}
