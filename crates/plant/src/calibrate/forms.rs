//! Chooses the instructions to measure and how their copies are placed in rungs: sample lines of the front are tried.

use super::rung::{ROUTINE, Special, special, special_names};
use super::{Language, Rung, Spare, variants};
use scanbound_base::facts::Facts;
use scanbound_base::time::Picos;
use scanbound_front::{Fronts, Input, Options, SourceOptions};
use scanbound_ir::{Instruction, Join, Program, Step, TimingKey, Units};
use scanbound_timing::price::{OperandTags, price_of};
use scanbound_timing::table::{Evidence, Table};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// An instruction that is measured.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Form {
    /// The row of a timing table that it measures.
    pub row: String,
    /// The line of a copy.
    pub line: String,
    /// The measured instruction: in the line, or in the routine that the line calls.
    pub own: String,
    /// Its timing class.
    pub class: &'static str,
    /// The number of units that the copy handles. 0 if it has no count.
    pub units: u64,
    /// How copies are placed in rungs.
    pub rung: Rung,
    /// How often a copy executes it.
    pub runs: u64,
    /// Its largest time by the table that is to be replaced.
    pub assumed: Picos,
    /// Its share of the time of all instructions in the programs, in thousandths.
    pub share: u64,
}

/// An instruction that is not measured.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Unmeasured {
    /// Its row.
    pub row: String,
    /// Why.
    pub why: String,
    /// Its share of the time of all instructions in the programs, in thousandths.
    pub share: u64,
}

/// The timing classes whose instructions are safe to execute in a calibration.
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

/// The classes whose time depends on the data. A margin is added to their times.
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

/// Values of words before a block that probably make instructions of a class slow. Each list is measured separately.
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
        // Four decimal digits, so that both conversions have a result.
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

/// An instruction that programs use: a mnemonic, and the kind of its operands or its coil's device if that has a row of
/// its own.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
struct Asked {
    name: String,
    variant: Option<String>,
}

impl Asked {
    /// The one that belongs to a timing key.
    fn of(key: &TimingKey, table: &Table) -> Asked {
        let name = key.names.last().cloned().unwrap_or_default();
        let variant = key.names.first().and_then(|name| name.split_once(':')).map(|(_, kind)| kind);
        let matters = |kind: &&str| {
            KINDS.contains(kind)
                || ["timer", "counter"].contains(&key.class)
                || (["coil", "set"].contains(&key.class)
                    && (*kind == "M"
                        || table.row(&format!("{name}:{kind}")).is_some()
                        || *kind == "Y"))
        };
        Asked { variant: variant.filter(matters).map(str::to_owned), name }
    }

    /// The name of its row in tables.
    fn text(&self) -> String {
        match &self.variant {
            Some(variant) => format!("{}:{variant}", self.name),
            None => self.name.clone(),
        }
    }
}

/// The kinds of operands that have rows of their own.
const KINDS: [&str; 3] = ["indexed", "digits", "module"];

/// The source of sample lines, and the devices that they may write.
#[derive(Clone, Copy)]
pub(super) struct Source<'a> {
    pub(super) table: &'a Table,
    pub(super) language: Language,
    pub(super) fronts: Fronts,
    pub(super) spare: &'a Spare,
}

/// An instruction that is used, and its share of the programs' time, in thousandths.
struct Used {
    asked: Asked,
    class: &'static str,
    share: u64,
}

/// Chooses the instructions that programs use. Without programs, all for which the table has a row of its own. Those
/// with the largest share of the time come first.
#[must_use]
pub(super) fn choose(
    program: Option<&Program>,
    source: Source<'_>,
) -> (Vec<Form>, Vec<Unmeasured>) {
    let used = match program {
        Some(program) => used(program, source.table),
        None => rows_of(source.table, source.language),
    };
    let (mut forms, mut left) = (Vec::new(), Vec::new());
    for Used { asked, class, share } in used {
        // The instruction that ends a program is part of an empty scan.
        if ENDS.contains(&&*asked.name) {
            continue;
        }
        match forms_of(&asked, class, source) {
            Ok(found) => forms.extend(found.into_iter().map(|form| Form { share, ..form })),
            Err(why) => left.push(Unmeasured { row: asked.text(), why: why.to_owned(), share }),
        }
    }
    // The same line may be the sample of several names.
    let mut seen = std::collections::BTreeSet::new();
    forms.retain(|form| seen.insert((form.line.clone(), form.own.clone(), form.row.clone())));
    (forms, left)
}

/// The instructions that end a program.
pub(super) const ENDS: [&str; 2] = ["END", "FEND"];

/// The instructions of a program whose times are assumed, those with the most time first.
fn used(program: &Program, table: &Table) -> Vec<Used> {
    let mut times: BTreeMap<Asked, (u128, &'static str)> = BTreeMap::new();
    for instruction in &program.instructions {
        let Some(key) = instruction.timing.as_deref() else { continue };
        let Ok(price) = price_of(table, key, &OperandTags::new()) else { continue };
        // A row of the user that is measured or published need not be measured again.
        if price.evidence == Evidence::Assumed {
            let one = times.entry(Asked::of(key, table)).or_insert((0, key.class));
            one.0 += u128::from(price.on.max(price.off).0);
        }
    }
    let total: u128 = times.values().map(|(time, _)| time).sum();
    let mut times: Vec<_> = times.into_iter().collect();
    times.sort_by(|(a, one), (b, other)| other.0.cmp(&one.0).then_with(|| a.cmp(b)));
    let share = |time: u128| {
        let share = (time * 1000).checked_div(total).unwrap_or(0);
        u64::try_from(share).unwrap_or(1000)
    };
    let used = times.into_iter();
    used.map(|(asked, (time, class))| Used { asked, class, share: share(time) }).collect()
}

/// The instructions that have rows of their own in a table, and those that have special rungs here.
fn rows_of(table: &Table, language: Language) -> Vec<Used> {
    let own = table.rows().iter().filter(|row| !row.name.starts_with('@'));
    let own = own.filter(|row| row.evidence == Evidence::Assumed).map(|row| &*row.name);
    let mut seen = std::collections::BTreeSet::new();
    let all = own.chain(special_names(language).iter().copied());
    let mut used = Vec::new();
    for row in all.filter(|row| seen.insert((*row).to_owned())) {
        let (name, variant) = match row.split_once(':') {
            Some((name, variant)) => (name, Some(variant.to_owned())),
            None => (row, None),
        };
        used.push(Used { asked: Asked { name: name.to_owned(), variant }, class: "", share: 0 });
    }
    used
}

/// The forms of an instruction, or why it is not measured.
fn forms_of(asked: &Asked, class: &str, source: Source<'_>) -> Result<Vec<Form>, &'static str> {
    let variant = asked.variant.as_deref();
    let special = special(&asked.name, variant, source.language, source.spare);
    if !special.is_empty() && !variant.is_some_and(|kind| KINDS.contains(&kind)) {
        let found: Vec<Form> =
            special.into_iter().filter_map(|special| special_form(special, source)).collect();
        return if found.is_empty() { Err(why_not(class)) } else { Ok(found) };
    }
    if !class.is_empty() && !HARMLESS.contains(&class) {
        return Err(why_not(class));
    }
    let family = source.table.family.as_deref().unwrap_or_default();
    let examples = source.fronts.0.iter().find_map(|front| front.examples(&asked.name, family));
    let Some(examples) = examples else { return Err("no sample line is known for it") };
    let mut found = Vec::new();
    for form in examples.forms {
        let mut lines: Vec<String> = Vec::new();
        for one in &form.candidates {
            if !lines.contains(&one.line) {
                lines.push(one.line.clone());
            }
        }
        let changes = variants::of(variant, source.language, source.spare);
        for change in changes {
            let tried = lines.iter().filter_map(|line| with_own_devices(line, source.language));
            let tried = tried.filter_map(|line| change.apply(&line, source.language));
            let Some(form) = tried.into_iter().find_map(|line| of_line(&line, source)) else {
                continue;
            };
            // It is another variant of the same name.
            if variant.is_some_and(|kind| form.row != format!("{}:{kind}", asked.name)) {
                continue;
            }
            // An instruction with a count is measured with few units and with many.
            if form.units > 0
                && let Some(counts) = with_counts(&form, source)
            {
                found.extend(counts);
            } else {
                found.push(form);
            }
        }
    }
    match (found.is_empty(), variant) {
        (false, _) => Ok(found),
        (true, Some("module")) => {
            Err("it accesses a module: name buffer memory with --spare U4\\G100")
        }
        (true, Some(kind)) if !KINDS.contains(&kind) => {
            Err("it writes devices that are not the program's own: name one with --spare")
        }
        (true, _) => Err(why_not(class)),
    }
}

/// A form with special rungs, if the front accepts it.
fn special_form(special: Special, source: Source<'_>) -> Option<Form> {
    let Special { own, line, rung, runs } = special;
    let mut label = 10;
    let next = || {
        label += 1;
        label
    };
    let mut lines = rung.lines(&line, [1, 2], 5, next);
    let routine = rung.routine.iter().map(|line| line.replace(ROUTINE, "5"));
    if !rung.routine.is_empty() && source.language != Language::Cs {
        lines.push("FEND".to_owned());
    }
    lines.extend(routine);
    let program = decoded(&(lines.join("\n") + "\nEND\n"), source)?;
    let name = own.split(' ').next()?;
    let named = |one: &&Instruction| one.text.split(' ').next() == Some(name);
    let exact = program.instructions.iter().find(|one| *one.text == *own);
    let key = exact.or_else(|| program.instructions.iter().find(named))?.timing.as_deref()?;
    let price = price_of(source.table, key, &OperandTags::new()).ok()?;
    let units = match key.units {
        Units::Exactly(units) if table_counts(source.table, key.class, &price.row) => units,
        _ => 0,
    };
    let device = ["timer", "counter"].contains(&key.class);
    let row = if device { key.names.first() } else { key.names.last() }?.clone();
    let assumed = price.on.max(price.off);
    Some(Form { row, line, own, class: key.class, units, rung, runs, assumed, share: 0 })
}

/// Why an instruction of a class is not measured.
fn why_not(class: &str) -> &'static str {
    match class {
        "jump" | "call" | "loop" | "master" | "interrupt" | "nothing" => {
            "it changes the program's control flow, which a measuring block does not allow"
        }
        "timer" | "counter" | "pulse" | "contact" => "its time depends on earlier scans",
        "stack" => "it occurs only where rungs branch",
        "module" => "it accesses a module: name buffer memory with --spare U4\\G100",
        "dedicated" | "clock" | "special" => {
            "instructions of its class may communicate, set the clock, drive outputs or take many scans"
        }
        _ => "no safe sample line is known for it",
    }
}

/// The same form with one unit, and with many.
fn with_counts(form: &Form, source: Source<'_>) -> Option<[Form; 2]> {
    // The format in which fronts write a count in their sample lines.
    let shown = if source.language == Language::Cs { "#4" } else { "K4" };
    let words: Vec<&str> = form.line.split(' ').collect();
    let at = words.iter().rposition(|word| *word == shown)?;
    let many = 64;
    let counted = |count: u32| {
        let number = source.language.number(count);
        let mut words = words.clone();
        words[at] = &number;
        of_line(&words.join(" "), source)
    };
    let both = [counted(1)?, counted(many)?];
    (both[0].units < both[1].units).then_some(both)
}

/// The form of a sample line, in the first plain rungs in which the front accepts it.
pub(super) fn of_line(line: &str, source: Source<'_>) -> Option<Form> {
    let rungs = Rung::plain(source.language);
    rungs.into_iter().find_map(|rung| shaped(line, rung, source))
}

/// A line whose inputs are replaced by the relay of the step's state. `None` if it would write an output or a timer.
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

/// The form in these rungs, if the front accepts it and it has the properties that such rungs need.
fn shaped(line: &str, rung: Rung, source: Source<'_>) -> Option<Form> {
    let table = source.table;
    let lines = rung.lines(line, [1, 2], 0, || 0);
    let program = decoded(&(lines.join("\n") + "\nEND\n"), source)?;
    let own: Vec<&Instruction> =
        program.instructions.iter().filter(|one| *one.text == *line).collect();
    let [first, _] = own[..] else { return None };
    let [action, series, _] = Rung::plain(source.language);
    let fits = match &first.step {
        Step::Act { .. } | Step::Nothing => rung == action,
        Step::Logic { join: Join::And | Join::Or | Join::Replace, .. } => rung == series,
        Step::Logic { join: Join::Start | Join::Load, .. } => rung != action && rung != series,
        _ => false,
    };
    let key = first.timing.as_deref().filter(|_| fits)?;
    let name = line.split(' ').next().unwrap_or_default();
    // Instructions on edges have special rungs.
    if !HARMLESS.contains(&key.class) || (key.class == "contact" && !is_contact(name)) {
        return None;
    }
    let price = price_of(table, key, &OperandTags::new()).ok()?;
    let units = match key.units {
        Units::Exactly(units) if table_counts(table, key.class, &price.row) => units,
        Units::None | Units::Exactly(_) => 0,
        Units::AtMost(_) | Units::Counted(_) => return None,
    };
    // The name that applies to all its variants, unless it was measured as one of them.
    let asked = Asked::of(key, table);
    let row = match &asked.variant {
        Some(_) => asked.text(),
        None => key.names.last()?.clone(),
    };
    let assumed = price.on.max(price.off);
    let (class, line) = (key.class, line.to_owned());
    Some(Form { row, own: line.clone(), line, class, units, rung, runs: 1, assumed, share: 0 })
}

/// Whether the rows that price an instruction have times per unit.
fn table_counts(table: &Table, class: &str, row: &str) -> bool {
    let rows = row.split(" + ").chain([class]);
    rows.filter_map(|name| table.row(name)).any(|row| row.per_unit > Picos::ZERO)
}

/// A program in the language's dialect. `None` if it has a fault.
fn decoded(text: &str, source: Source<'_>) -> Option<Program> {
    let Source { table, language, fronts, .. } = source;
    let dialect = |front: &&'static dyn scanbound_front::Front| {
        front.dialects().iter().find(|one| one.name == language.dialect()).map(|one| (*front, one))
    };
    let (front, dialect) = fronts.0.iter().find_map(dialect)?;
    let input = Input { name: "block".to_owned(), bytes: text.as_bytes().to_vec() };
    let facts = Facts::default();
    let options = Options { family: table.family.as_deref(), ..Options::new(&facts) };
    front.read(dialect, &[&input], &[], SourceOptions::default()).ok()?.decode(&options).ok()
}
