//! Example lines for each instruction of the OMRON families.

use super::catalog::{self, Row};
use super::source::{C, CX, Family};
use scanbound_front::example::{ExampleForm, Examples, Sample, form, samples, variants_of};

/// Programs into which an example line is inserted: rungs, blocks, branches, and instructions that come in pairs.
const FRAMES: [&str; 12] = [
    "LD {in0}\n{}\nEND",
    "{}\nOUT {out}\nEND",
    "LD {in0}\n{}\nOUT {out}\nEND",
    "LD {in0}\nLD {in1}\n{}\nOUT {out}\nEND",
    "LD {in0}\nLD {in1}\n{}\nEND",
    "LD {in0}\nLD {in1}\nLD {in0}\n{}\nEND",
    "LD {in0}\n{}\nLD {in1}\nOUT {out}\nILC\nEND",
    "LD {in0}\nIL\nLD {in1}\nOUT {out}\n{}\nEND",
    "{}\nLD {in0}\nOUT {out}\nNEXT\nEND",
    "FOR #4\nLD {in0}\nOUT {out}\n{}\nEND",
    "LD {in0}\n{}\nLD {in1}\nOUT {out}\nJME 1\nEND",
    "LD {in0}\nOUT {out}\n{}",
];

/// Prefixes of variants of an instruction.
const BEFORE: [&str; 2] = ["@", "%"];
/// Suffixes of variants of an instruction.
const BEHIND: [&str; 4] = ["L", "D", "B", "F"];

/// The names of all instructions.
pub fn all() -> Vec<String> {
    catalog::all_names().map(str::to_owned).collect()
}

/// The example lines of an instruction, whose name may have the prefixes `@`, `%` and `!`, and the names of its
/// variants. `None` if the family does not have it.
pub fn examples(name: &str, family: Family) -> Option<Examples> {
    let plain = name.trim_start_matches(['@', '%', '!']);
    let found = catalog::find(plain, family)?;
    let frames: Vec<String> = FRAMES.iter().map(|structure| framed(structure, family)).collect();
    let frames: Vec<&str> = frames.iter().map(String::as_str).collect();
    let forms: Vec<ExampleForm> =
        found.rows.iter().map(|row| form(&lines(name, row, family), &frames)).collect();
    let known = catalog::all_names().filter(|name| catalog::find(name, family).is_some());
    let variants = variants_of(plain, known, &BEFORE, &BEHIND);
    Some(Examples { dialect: if family == Family::C { C } else { CX }, variants, forms })
}

fn framed(structure: &str, family: Family) -> String {
    let [in0, in1, out] = match family {
        Family::C => ["00000", "00001", "01000"],
        Family::Cs => ["0.00", "0.01", "100.00"],
    };
    structure.replace("{in0}", in0).replace("{in1}", in1).replace("{out}", out)
}

fn lines(name: &str, row: &Row, family: Family) -> Vec<String> {
    let samples = samples(row);
    let line = |other: usize, count: usize| {
        let operands = samples[..count].iter().enumerate();
        let operands = operands.map(|(at, sample)| operand(*sample, at, other, family));
        [vec![name.to_owned()], operands.collect()].concat().join(" ")
    };
    let all = samples.len();
    (0..4).flat_map(|other| [line(other, all), line(other, all.saturating_sub(1))]).collect()
}

/// An example operand of the kind `sample`; `at` is its position among the operands.
fn operand(sample: Sample, at: usize, other: usize, family: Family) -> String {
    let is_c = family == Family::C;
    match sample {
        Sample::Bit if is_c => format!("002{at:02}"),
        Sample::Bit => format!("W{at}.00"),
        Sample::Word if other == 1 && at > 0 => "#1".to_owned(),
        Sample::Word if other == 2 && is_c => format!("{:03}", 100 + at * 10),
        Sample::Word if is_c => format!("DM {}", 10 * at),
        Sample::Word => format!("D{}", 100 * at),
        Sample::Number => ["#4", "1", "&4", "0"][other].to_owned(),
        Sample::Address => ["D0", "0", "W0.00", "#1"][other].to_owned(),
        Sample::Extra if is_c => format!("{:03}", at + 1),
        Sample::Extra => format!("{:04}", at + 1),
    }
}
