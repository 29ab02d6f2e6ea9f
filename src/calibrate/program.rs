//! The text of a calibration program: blocks that are chosen by the step, and the files that programming software takes.

use super::language::Language;

/// A block of rungs that is run in a loop while the step is one of its own: off first, then on with each list of
/// operands.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Block {
    pub(super) first: u32,
    pub(super) states: u32,
    pub(super) label: u32,
    pub(super) loops: u32,
    /// The words that are set in each step in which it is on.
    pub(super) operands: Vec<Vec<(u32, u16)>>,
    pub(super) rungs: Vec<String>,
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
        let [begin, next] = language.looped(self.loops);
        lines.push(begin);
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

/// All lines of a part.
pub(super) fn lines(language: Language, blocks: &[Block], steps: u32, scans: u32) -> Vec<String> {
    let mut lines = language.head(steps, scans);
    lines.extend(blocks.iter().flat_map(|block| block.lines(language)));
    lines.push("END".to_owned());
    lines
}

/// The file of a part, as programming software takes it.
#[must_use]
pub fn file(language: Language, cpu: &str, lines: &[String]) -> Vec<u8> {
    match language {
        Language::Q => exported(language, "QCPU (Q mode)", cpu, lines),
        Language::Fx => exported(language, "FXCPU", &format!("{cpu}/{cpu}C"), lines),
        Language::Cs => (lines.join("\n") + "\n").into_bytes(),
    }
}

/// The CSV of GX Works2: UTF-16 with a mark of its order, fields apart by tabs and quoted; an operand more, a row more.
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
