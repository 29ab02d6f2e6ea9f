//! The text of a calibration program: blocks selected by the step, and files for programming software.

use super::language::Language;

/// A block of rungs that is executed in a loop during its own steps: first off, then on with each list of operands.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Block {
    pub(super) first: u32,
    pub(super) states: u32,
    pub(super) label: u32,
    pub(super) loops: u32,
    /// The words that are set in each step in which it is on.
    pub(super) operands: Vec<Vec<(u32, u16)>>,
    pub(super) rungs: Vec<String>,
    /// Whether a relay changes in each iteration.
    pub(super) changes: bool,
}

impl Block {
    /// Its lines.
    fn lines(&self, language: Language) -> Vec<String> {
        let [mut lines, end] = language.only(self.first, self.first + self.states - 1, self.label);
        lines.push(language.from_step(self.first + 1));
        lines.push(format!("OUT {}", language.state()));
        for (operands, step) in self.operands.iter().zip(self.first + 1..) {
            lines.push(language.at_step(step));
            let moves = operands.iter();
            lines.extend(moves.map(|(word, bits)| format!("MOV {} D{word}", language.bits(*bits))));
        }
        let indexed =
            |line: &String| line.split(' ').skip(1).any(|operand| operand.ends_with("Z0"));
        if self.rungs.iter().any(indexed) {
            lines.push(format!("LD {}", language.always()));
            lines.push("MOV K0 Z0".to_owned());
        }
        let [begin, next] = language.looped(self.loops);
        lines.push(begin);
        if self.changes {
            lines.extend(language.changes());
        }
        lines.extend(self.rungs.iter().cloned());
        lines.push(next);
        lines.extend(end);
        lines
    }

    /// The steps of program memory that it takes.
    pub(super) fn size(&self, language: Language) -> u32 {
        self.lines(language).iter().map(|line| language.size(line)).sum()
    }
}

/// The contents of a part's program.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct LaidOut {
    pub(super) blocks: Vec<Block>,
    /// The lines behind the end of the program.
    pub(super) routines: Vec<String>,
}

/// All lines of a part with this many steps, of which the first `empty` measure an empty scan.
pub(super) fn lines(
    language: Language,
    laid: &LaidOut,
    [empty, steps]: [u32; 2],
    scans: u32,
) -> Vec<String> {
    let mut lines = language.head(empty, steps, scans);
    lines.extend(laid.blocks.iter().flat_map(|block| block.lines(language)));
    lines.extend(language.tail(&laid.routines));
    lines
}

/// The lines as text.
#[must_use]
pub fn text(lines: &[String]) -> Vec<u8> {
    (lines.join("\n") + "\n").into_bytes()
}

/// The file of a part, in the format of the programming software.
#[must_use]
pub fn file(language: Language, cpu: &str, lines: &[String]) -> Vec<u8> {
    match language {
        Language::Q => exported(language, series(cpu), cpu, lines),
        Language::Fx => exported(language, "FXCPU", &format!("{cpu}/{cpu}C"), lines),
        Language::Cs => text(lines),
    }
}

/// The name of the series in GX Works2 and 3.
fn series(cpu: &str) -> &'static str {
    match cpu {
        _ if cpu.starts_with("FX5") => "FX5CPU",
        _ if cpu.starts_with('R') => "RCPU",
        _ if cpu.starts_with('L') => "LCPU",
        _ => "QCPU (Q mode)",
    }
}

/// The CSV of GX Works2: UTF-16 with a byte order mark, fields quoted and separated by tabs, one row for each operand.
fn exported(language: Language, series: &str, cpu: &str, lines: &[String]) -> Vec<u8> {
    let row = |fields: &[&str]| {
        let quoted: Vec<String> =
            fields.iter().map(|field| format!("\"{}\"", field.replace('"', "\"\""))).collect();
        quoted.join("\t") + "\r\n"
    };
    let mut text = row(&["CALIBRATION"]);
    text += &row(&["PLC Information:", &format!("{series} {cpu}")]);
    text += &row(&[
        "Step No.",
        "Line Statement",
        "Instruction",
        "I/O(Device)",
        "Blank",
        "PI Statement",
        "Note",
    ]);
    let mut step = 0;
    for line in lines {
        let mut words = line.split_whitespace();
        let name = words.next().unwrap_or_default();
        let first = words.next().unwrap_or_default();
        text += &row(&[&step.to_string(), "", name, first, "", "", ""]);
        for operand in words {
            text += &row(&["", "", "", operand, "", "", ""]);
        }
        step += language.size(line);
    }
    let mark = [0xFF, 0xFE];
    mark.into_iter().chain(text.encode_utf16().flat_map(u16::to_le_bytes)).collect()
}
