//! Example lines for each instruction of the MELSEC families.

use super::catalog::{self, names, rows, unpulsed};
use super::list;
use super::memory::Family;
use super::mnemonic::{OperandType, compared, contact};
use scanbound_front::example::{ExampleForm, Examples, Sample, form, samples, variants_of};

/// Programs into which an example line is inserted: rungs, then structures with branches, jumps, loops, calls and
/// master control.
const FRAMES: [&str; 16] = [
    "LD X100\n{}\nEND",
    "{}\nOUT Y100\nEND",
    "LD X100\n{}\nOUT Y100\nEND",
    "LD X100\nLD X101\n{}\nOUT Y100\nEND",
    "LD X100\n{}\nAND X101\nOUT Y100\nMPP\nOUT Y101\nEND",
    "LD X100\nMPS\nOUT Y100\n{}\nOUT Y101\nMPP\nOUT Y102\nEND",
    "LD X100\nMPS\nOUT Y100\n{}\nOUT Y101\nEND",
    "LD X100\n{}\nLD X101\nOUT Y100\nP0\nLD X102\nOUT Y101\nEND",
    "LD X100\n{}\nFEND\nP0\nLD X101\nOUT Y100\nRET\nEND",
    "LD X100\nCALL P0\nFEND\nP0\nLD X101\nOUT Y100\n{}\nEND",
    "{}\nLD X100\nOUT Y100\nNEXT\nEND",
    "FOR K4\nLD X100\nOUT Y100\n{}\nEND",
    "FOR K4\nLD X100\n{}\nNEXT\nP0\nEND",
    "LD X100\n{}\nLD X101\nOUT Y100\nMCR N0\nEND",
    "LD X100\nMC N0 M0\nLD X101\nOUT Y100\n{}\nEND",
    "LD X100\nOUT Y100\n{}",
];

/// Instructions that are not in the catalog, each with the operands of its example lines.
const NOT_IN_CATALOG: [(&str, &[&str]); 47] = [
    ("LD", &["X0"]),
    ("LDI", &["X0"]),
    ("AND", &["X0"]),
    ("ANI", &["X0"]),
    ("OR", &["X0"]),
    ("ORI", &["X0"]),
    ("LDP", &["X0"]),
    ("LDF", &["X0"]),
    ("ANDP", &["X0"]),
    ("ANDF", &["X0"]),
    ("ORP", &["X0"]),
    ("ORF", &["X0"]),
    ("LDPI", &["X0"]),
    ("LDFI", &["X0"]),
    ("ANDPI", &["X0"]),
    ("ANDFI", &["X0"]),
    ("ORPI", &["X0"]),
    ("ORFI", &["X0"]),
    ("ANB", &[""]),
    ("ORB", &[""]),
    ("MPS", &[""]),
    ("MRD", &[""]),
    ("MPP", &[""]),
    ("INV", &[""]),
    ("MEP", &[""]),
    ("MEF", &[""]),
    ("EGP", &["V0"]),
    ("EGF", &["V0"]),
    ("OUT", &["Y0", "M0", "T0 K10", "C0 K10"]),
    ("OUTH", &["T0 K10"]),
    ("SET", &["M0"]),
    ("RST", &["M0", "D0", "T0"]),
    ("PLS", &["M0"]),
    ("PLF", &["M0"]),
    ("FF", &["M0"]),
    ("CJ", &["P0"]),
    ("SCJ", &["P0"]),
    ("JMP", &["P0"]),
    ("CALL", &["P0"]),
    ("CALLP", &["P0"]),
    ("RET", &[""]),
    ("FOR", &["K4"]),
    ("NEXT", &[""]),
    ("MC", &["N0 M0"]),
    ("MCR", &["N0"]),
    ("END", &[""]),
    ("STOP", &[""]),
];

/// The first part of comparison mnemonics: how the contact is connected.
const JOINS: [&str; 3] = ["LD", "AND", "OR"];
/// The second part of comparison mnemonics: the operand type.
const KINDS: [&str; 4] = ["", "D", "E", "$"];
/// The third part of comparison mnemonics: the relation.
const RELATIONS: [&str; 6] = ["=", "<>", "<", "<=", ">", ">="];

/// Prefixes that make the name of a related instruction, such as its double-word form.
const BEFORE: [&str; 2] = ["D", "E"];
/// Suffixes that make the name of a related instruction, such as its pulse form.
const BEHIND: [&str; 4] = ["P", "_U", "P_U", "I"];

/// The names of the instructions of which examples can be shown: contacts, coils and control instructions, comparison
/// contacts, and those of the catalog with their pulse forms.
pub fn all() -> Vec<String> {
    let own = NOT_IN_CATALOG.iter().map(|(name, _)| (*name).to_owned());
    let compare = JOINS.iter().flat_map(|join| {
        KINDS.iter().flat_map(move |kind| {
            RELATIONS.iter().map(move |relation| format!("{join}{kind}{relation}"))
        })
    });
    let listed = names().flat_map(|name| {
        let has_pulse = rows(name).is_some_and(|rows| rows.iter().any(|row| row.extra.pulse));
        [Some(name.to_owned()), has_pulse.then(|| pulsed(name))].into_iter().flatten()
    });
    own.chain(compare).chain(listed).collect()
}

/// The name of the pulse form of an instruction: `MOVP` of `MOV`, `+P_U` of `+_U`, `ZP.OPEN` of `Z.OPEN`.
fn pulsed(name: &str) -> String {
    if let (true, Some((prefix, rest))) = (name.contains('.'), name.split_once('.')) {
        return format!("{prefix}P.{rest}");
    }
    for kind in ["_U", "_WS"] {
        if let Some(base) = name.strip_suffix(kind) {
            return format!("{base}P{kind}");
        }
    }
    format!("{name}P")
}

/// The example lines of an instruction, and the names of its variants. `None` if there is no such instruction.
pub fn examples(name: &str, family: Family) -> Option<Examples> {
    let forms = forms(name, family)?;
    let all = all();
    let plain = unpulsed(name).filter(|plain| all.contains(plain));
    let of = plain.as_deref().unwrap_or(name);
    let mut variants = variants_of(of, all.iter().map(String::as_str), &BEFORE, &BEHIND);
    variants.extend(plain);
    variants.retain(|variant| variant != name);
    variants.sort_unstable();
    variants.dedup();
    Some(Examples { dialect: list::DIALECT, variants, forms })
}

fn forms(name: &str, family: Family) -> Option<Vec<ExampleForm>> {
    let written = |operands: &str| [format!("{name} {operands}").trim_end().to_owned()];
    if let Some((_, operands)) = NOT_IN_CATALOG.iter().find(|(own, _)| *own == name) {
        return Some(operands.iter().map(|one| form(&written(one), &FRAMES)).collect());
    }
    if contact(name).is_some() {
        return Some(vec![form(&written("X0"), &FRAMES)]);
    }
    if let Some((_, sort, _)) = compared(name) {
        let operands = match sort {
            OperandType::Integer { .. } => "D0 D10",
            OperandType::Real { .. } | OperandType::Text => "D0 D10",
            OperandType::Clock => "D0 D10 K1",
        };
        return Some(vec![form(&written(operands), &FRAMES)]);
    }
    let rows = catalog::forms(name)?;
    let lines = |row: &catalog::Entry| -> Vec<String> {
        let samples = samples(row);
        let alternatives = (0..ALTERNATIVES).map(|other| {
            let operands =
                samples.iter().enumerate().map(|(at, sample)| operand(*sample, at, other, family));
            [vec![name.to_owned()], operands.collect()].concat().join(" ")
        });
        alternatives.collect()
    };
    Some(rows.into_iter().map(|row| form(&lines(row), &FRAMES)).collect())
}

/// The number of example lines that are written for each catalog row, with different types of operands.
const ALTERNATIVES: usize = 4;

/// An example operand of the kind `sample`, in line number `other` of the alternatives; `at` is its position among the
/// operands.
fn operand(sample: Sample, at: usize, other: usize, family: Family) -> String {
    let place = at * 100;
    match sample {
        Sample::Bit => format!("M{place}"),
        Sample::Word if other == 1 => format!("M{place}"),
        Sample::Word if other == 3 && at > 0 => "K1".to_owned(),
        Sample::Word => format!("D{place}"),
        Sample::Number if other == 2 && !family.octal_inputs() => "H0".to_owned(),
        Sample::Number => "K4".to_owned(),
        Sample::Address => ["D0", "K1", "U0", "\"A\""][other].to_owned(),
        Sample::Extra => "Y0".to_owned(),
    }
}
