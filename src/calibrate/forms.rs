//! Which instructions are measured, and how their copies are written: lines that a front shows, tried in rungs.

use super::Language;
use crate::base::facts::Facts;
use crate::base::time::Picos;
use crate::front::{Fronts, Input, Options};
use crate::program::{Instruction, Join, Program, Step, Units};
use crate::timing::price::{Tags, price_of};
use crate::timing::table::{Evidence, Table};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// How copies of an instruction stand in rungs.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Shape {
    /// Behind one contact, one below the other.
    Action,
    /// In series behind one contact, before a coil.
    Series,
    /// Each begins a rung that ends in a coil.
    Start,
}

/// An instruction that is measured.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Form {
    /// The row of a timing table that it gives.
    pub row: String,
    /// A copy of it.
    pub line: String,
    /// Its timing class.
    pub class: &'static str,
    /// How many units the copy handles; 0 where nothing is counted.
    pub units: u64,
    /// How copies stand in rungs.
    pub shape: Shape,
    /// What it takes at most, by the table that is to be replaced.
    pub assumed: Picos,
    /// Its part of all instructions' time in the programs, in thousandths.
    pub share: u64,
}

/// An instruction that is not measured.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Left {
    /// Its row.
    pub row: String,
    /// Why.
    pub why: String,
    /// Its part of all instructions' time in the programs, in thousandths.
    pub share: u64,
}

/// The timing classes whose instructions do nothing that a calibration must not do.
const HARMLESS: &[&str] = &[
    "arithmetic",
    "arithmetic-double",
    "bit",
    "block",
    "coil",
    "compare",
    "compare-double",
    "compare-real",
    "compare-string",
    "contact",
    "conversion",
    "divide",
    "divide-double",
    "logic",
    "logic-double",
    "move",
    "move-double",
    "multiply",
    "multiply-double",
    "nothing",
    "real",
    "search",
    "set",
    "shift",
    "stack",
    "string",
    "table",
];

/// The classes whose time depends on the data, for which a margin is added.
pub const BY_DATA: &[&str] = &[
    "compare-real",
    "compare-string",
    "conversion",
    "divide",
    "divide-double",
    "multiply",
    "multiply-double",
    "real",
    "search",
    "string",
];

/// Values of words before a block: what likely makes instructions of a class slow. Each list is a state of its own.
#[must_use]
pub fn operands(class: &str) -> &'static [&'static [(u32, u16)]] {
    match class {
        "multiply" | "multiply-double" => &[
            &[(0, 0x7FFF), (1, 0x7FFF), (100, 0x7FFF), (101, 0x7FFF)],
            &[(0, 0x5555), (1, 0x2AAA), (100, 0xAAAB), (101, 0xD555)],
        ],
        "divide" | "divide-double" => &[
            &[(0, 0x7FFF), (1, 0x7FFF), (100, 3), (101, 0)],
            &[(0, 0x7FFF), (1, 0x7FFF), (100, 0x7FFE), (101, 0x7FFF)],
        ],
        "real" | "compare-real" => &[
            &[(0, 0x0FDB), (1, 0x4049), (100, 0xF854), (101, 0x402D)],
            &[(0, 0xAAAB), (1, 0x3EAA), (100, 0x0000), (101, 0x4040)],
        ],
        // Four decimal digits, so that either way has a result.
        "conversion" => &[
            &[(0, 0x0999), (1, 0), (100, 0), (101, 0)],
            &[(0, 0x0001), (1, 0), (100, 0), (101, 0)],
        ],
        "string" | "compare-string" => &[&[
            (0, 0x4141),
            (1, 0x4141),
            (2, 0x4141),
            (3, 0x4141),
            (4, 0),
            (100, 0x4141),
            (101, 0x4141),
            (102, 0x4141),
            (103, 0x4141),
            (104, 0),
        ]],
        "search" => &[&[(0, 1), (1, 0), (100, 0), (101, 0)]],
        _ => &[&[(0, 0), (1, 0), (100, 0), (101, 0)]],
    }
}

/// What the programs use of a mnemonic.
struct Used {
    time: u128,
    class: &'static str,
}

/// The instructions that programs use, or where none are named all that the table has a row of its own for; the dearest
/// part of the programs first.
#[must_use]
pub fn choose(
    program: Option<&Program>,
    table: &Table,
    language: Language,
    fronts: Fronts,
) -> (Vec<Form>, Vec<Left>) {
    let mut used: BTreeMap<String, Used> = BTreeMap::new();
    let mut total: u128 = 0;
    match program {
        Some(program) => {
            for instruction in &program.instructions {
                let Some(key) = instruction.timing.as_deref() else { continue };
                let Ok(price) = price_of(table, key, &Tags::new()) else { continue };
                // A row of somebody's own that is measured or published needs no other.
                if price.evidence != Evidence::Assumed {
                    continue;
                }
                let name = key.names.last().cloned().unwrap_or_default();
                let time = u128::from(price.on.max(price.off).0);
                total += time;
                let one = used.entry(name).or_insert(Used { time: 0, class: key.class });
                one.time += time;
            }
        }
        None => {
            let own = table.rows().iter().filter(|row| !row.name.starts_with('@'));
            for row in own.filter(|row| row.evidence == Evidence::Assumed) {
                let name = row.name.split(':').next().unwrap_or_default().to_owned();
                used.entry(name).or_insert(Used { time: 0, class: "" });
            }
        }
    }
    let mut used: Vec<(String, Used)> = used.into_iter().collect();
    used.sort_by(|(a, one), (b, other)| other.time.cmp(&one.time).then_with(|| a.cmp(b)));
    let (mut forms, mut left) = (Vec::new(), Vec::new());
    for (name, Used { time, class }) in used {
        let share = u64::try_from((time * 1000).checked_div(total).unwrap_or(0)).unwrap_or(1000);
        match forms_of(&name, class, table, language, fronts) {
            Ok(found) => forms.extend(found.into_iter().map(|form| Form { share, ..form })),
            Err(why) => left.push(Left { row: name, why: why.to_owned(), share }),
        }
    }
    left.extend(other_rows(program, table, &forms, total));
    // Different names may be shown by the same line.
    let mut seen = std::collections::BTreeSet::new();
    forms.retain(|form| seen.insert(form.line.clone()));
    (forms, left)
}

/// Rows of their own that price instructions of the programs, and that no form gives: coils of outputs beside those of
/// relays.
fn other_rows(program: Option<&Program>, table: &Table, forms: &[Form], total: u128) -> Vec<Left> {
    let mut times: BTreeMap<String, u128> = BTreeMap::new();
    for instruction in program.iter().flat_map(|program| &program.instructions) {
        let Some(key) = instruction.timing.as_deref() else { continue };
        let Ok(price) = price_of(table, key, &Tags::new()) else { continue };
        let row = price.row.split(" + ").next().unwrap_or_default();
        let plain = key.names.last().is_some_and(|name| name == row);
        let measured = forms.iter().any(|form| form.row == row);
        // What is not measured by its plain name is told of under that.
        let named = forms.iter().any(|form| {
            key.names.last() == form.line.split(' ').next().map(str::to_owned).as_ref()
        });
        if !row.starts_with('@')
            && !plain
            && !measured
            && named
            && price.evidence == Evidence::Assumed
        {
            *times.entry(row.to_owned()).or_default() += u128::from(price.on.max(price.off).0);
        }
    }
    let left = times.into_iter().map(|(row, time)| {
        let share = u64::try_from((time * 1000).checked_div(total).unwrap_or(0)).unwrap_or(1000);
        let why = "only other operands are measured, which have a row of their own".to_owned();
        Left { row, why, share }
    });
    left.collect()
}

/// The forms of an instruction, or why it is not measured.
fn forms_of(
    name: &str,
    class: &str,
    table: &Table,
    language: Language,
    fronts: Fronts,
) -> Result<Vec<Form>, &'static str> {
    if !class.is_empty() && !HARMLESS.contains(&class) {
        return Err(why_not(class));
    }
    let family = table.family.as_deref().unwrap_or_default();
    let specimens = fronts.0.iter().find_map(|front| front.specimens(name, family));
    let Some(specimens) = specimens else { return Err("no line of it is known here") };
    let mut found = Vec::new();
    for form in specimens.forms {
        let mut lines: Vec<String> = Vec::new();
        for one in &form.tries {
            if !lines.contains(&one.line) {
                lines.push(one.line.clone());
            }
        }
        let tried = lines.iter().find_map(|line| of_line(line, table, language, fronts));
        let Some(form) = tried else { continue };
        // What counts is measured with few units and with many.
        if form.units > 0
            && let Some(counts) = with_counts(&form, table, language, fronts)
        {
            found.extend(counts);
        } else {
            found.push(form);
        }
    }
    if found.is_empty() { Err(why_not(class)) } else { Ok(found) }
}

/// Why an instruction of a class is not measured.
fn why_not(class: &str) -> &'static str {
    match class {
        "jump" | "call" | "loop" | "master" | "interrupt" | "nothing" => {
            "it changes how the program runs"
        }
        "timer" | "counter" | "pulse" | "contact" => "what it takes hangs on the scans before",
        "stack" => "it stands only where rungs branch",
        "module" | "dedicated" | "clock" | "special" => "it reaches beyond the CPU",
        _ => "no line is known here that does no harm",
    }
}

/// The same form with one unit and with many.
fn with_counts(
    form: &Form,
    table: &Table,
    language: Language,
    fronts: Fronts,
) -> Option<[Form; 2]> {
    // As fronts write a count in the lines that they show.
    let shown = if language == Language::Cs { "#4" } else { "K4" };
    let words: Vec<&str> = form.line.split(' ').collect();
    let at = words.iter().rposition(|word| *word == shown)?;
    let many = 64;
    let counted = |count: u32| {
        let number =
            if language == Language::Cs { format!("&{count}") } else { format!("K{count}") };
        let mut words = words.clone();
        words[at] = &number;
        of_line(&words.join(" "), table, language, fronts)
    };
    let both = [counted(1)?, counted(many)?];
    (both[0].units < both[1].units).then_some(both)
}

/// The form that a line shows, in the first shape in which the front takes it.
pub(super) fn of_line(
    line: &str,
    table: &Table,
    language: Language,
    fronts: Fronts,
) -> Option<Form> {
    let line = with_own_devices(line, language)?;
    [Shape::Action, Shape::Series, Shape::Start]
        .into_iter()
        .find_map(|shape| shaped(&line, shape, table, language, fronts))
}

/// A line whose inputs are the relay of the step's state; none where it would write an output, or a timer.
fn with_own_devices(line: &str, language: Language) -> Option<String> {
    let (inputs, mut words): (&[&str], _) = match language {
        Language::Q | Language::Fx => (&["X0"], line.split_whitespace()),
        Language::Cs => (&["0.00"], line.split_whitespace()),
    };
    let name = words.next()?;
    let mut own = name.to_owned();
    let contact = is_contact(name);
    for operand in words {
        let begins = |letters: &[char]| operand.starts_with(letters);
        let bad = match language {
            Language::Q | Language::Fx => {
                begins(&['Y', 'T', 'C', 'S', 'U', 'J', 'P', 'N', 'V', 'L', '"'])
                    || (begins(&['X']) && !inputs.contains(&operand))
            }
            Language::Cs => !begins(&['D', 'W', '#', '&', '0', '1', '4']),
        };
        if bad {
            return None;
        }
        let input = inputs.contains(&operand) || (contact && operand == "W0.00");
        own += " ";
        own += if input { language.state() } else { operand };
    }
    Some(own)
}

fn is_contact(name: &str) -> bool {
    ["LD", "AND", "OR", "LDI", "ANI", "ORI", "LDNOT", "ANDNOT", "ORNOT", "INV"].contains(&name)
}

/// The rungs of so many copies of a line.
#[must_use]
pub fn rungs(line: &str, shape: Shape, copies: u32, language: Language) -> Vec<String> {
    let copies = (0..copies).map(|_| line.to_owned());
    let coil = format!("OUT {}", language.coil());
    match shape {
        Shape::Action => {
            std::iter::once(format!("LD {}", language.state())).chain(copies).collect()
        }
        Shape::Series => std::iter::once(format!("LD {}", language.always()))
            .chain(copies)
            .chain([coil])
            .collect(),
        Shape::Start => copies.flat_map(|line| [line, coil.clone()]).collect(),
    }
}

/// The form in this shape, if the front takes it so and it does what such rungs need.
fn shaped(
    line: &str,
    shape: Shape,
    table: &Table,
    language: Language,
    fronts: Fronts,
) -> Option<Form> {
    let mut text = rungs(line, shape, 2, language).join("\n");
    text += "\nEND\n";
    let program = decoded(&text, table, language, fronts)?;
    let own: Vec<&Instruction> =
        program.instructions.iter().filter(|one| *one.text == *line).collect();
    let [first, _] = own[..] else { return None };
    let fits = matches!(
        (&first.step, shape),
        (Step::Act { .. } | Step::Nothing, Shape::Action)
            | (Step::Logic { join: Join::And | Join::Or | Join::Replace, .. }, Shape::Series,)
            | (Step::Logic { join: Join::Start | Join::Load, .. }, Shape::Start)
    );
    let key = first.timing.as_deref().filter(|_| fits)?;
    let name = line.split(' ').next().unwrap_or_default();
    // Edges fire in one scan alone.
    if !HARMLESS.contains(&key.class) || (key.class == "contact" && !is_contact(name)) {
        return None;
    }
    let price = price_of(table, key, &Tags::new()).ok()?;
    let units = match key.units {
        Units::Exactly(units) if table_counts(table, key.class, &price.row) => units,
        Units::None | Units::Exactly(_) => 0,
        Units::AtMost(_) | Units::Counted(_) => return None,
    };
    // Its own row if the table has one, else the name that holds for all its variants.
    let own = key.names.iter().find(|name| table.row(name).is_some());
    let row = own.or(key.names.last())?.clone();
    let assumed = price.on.max(price.off);
    let class = key.class;
    let line = line.to_owned();
    Some(Form { row, line, class, units, shape, assumed, share: 0 })
}

/// Whether the rows that price an instruction have times per unit.
fn table_counts(table: &Table, class: &str, row: &str) -> bool {
    let rows = row.split(" + ").chain([class]);
    rows.filter_map(|name| table.row(name)).any(|row| row.per_unit > Picos::ZERO)
}

/// A program in the language's dialect; none where it has a fault.
pub(super) fn decoded(
    text: &str,
    table: &Table,
    language: Language,
    fronts: Fronts,
) -> Option<Program> {
    let dialect = |front: &&'static dyn crate::front::Front| {
        front.dialects().iter().find(|one| one.name == language.dialect()).map(|one| (*front, one))
    };
    let (front, dialect) = fronts.0.iter().find_map(dialect)?;
    let input = Input { name: "block".to_owned(), bytes: text.as_bytes().to_vec() };
    let facts = Facts::default();
    let options = Options { family: table.family.as_deref(), ..Options::new(&facts) };
    front.read(dialect, &[&input], &[]).ok()?.decode(&options).ok()
}
