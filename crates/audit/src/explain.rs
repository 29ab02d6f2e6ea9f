//! What is known of an instruction: its times by a table, and what the analysis follows of it. Both are read off lines that
//! its front writes and understands as it does those of any program.

use scanbound_base::facts::Facts;
use scanbound_front::{Examples, Form, Front, Fronts, Input, Options, SourceOptions};
use scanbound_ir::{
    BitSource, BitTarget, Cell, ChoiceId, ChoiceKind, Effect, Instruction, Program, Region, Source,
    Step, WordSource, WordTarget, Write,
};
use scanbound_passes::values;
use scanbound_timing::price::{Price, Tags, price_of};
use scanbound_timing::table::{Factor, Row, Table};

/// An instruction by a table.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Explained {
    /// Its name.
    pub name: String,
    /// The table's name.
    pub table: String,
    /// What the table is for, one line.
    pub title: String,
    /// Instructions that do the same in another way.
    pub variants: Vec<String>,
    /// Its forms.
    pub forms: Vec<FormUse>,
    /// What is added where operands lie in some areas (`@+ZR`), or are bits of words.
    pub extras: Vec<Row>,
    /// The factor on the whole scan, which these times do not hold.
    pub factor: Option<Factor>,
}

/// A form of an instruction.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FormUse {
    /// A line that shows it.
    pub line: String,
    /// The table's rows that price it; none if it has no time.
    pub rows: Vec<Row>,
    /// Whether the first of them is that of its class.
    pub by_class: bool,
    /// Its timing class.
    pub class: &'static str,
    /// What the line shown takes, without the factor; none if it has no time.
    pub price: Option<Price>,
    /// What is followed of it.
    pub follow: Follow,
    /// What is over-approximated of it, each in a sentence.
    pub approximations: Vec<String>,
}

/// What the analysis follows of an instruction, that of which most is known first.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Follow {
    /// It changes no device.
    Nothing,
    /// All of it.
    Exactly,
    /// Its result is any value in the scan's model; of what counts and indices are made of, a range is worked out; real runs
    /// carry it out.
    Range,
    /// Its result is any value in the scan's model; real runs carry it out.
    RealRuns,
    /// Its result is what the outside gives: any value.
    Outside,
    /// Its result is any value, and no real run knows it.
    Unknown,
}

impl Follow {
    /// Its name in reports.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Follow::Nothing => "nothing-written",
            Follow::Exactly => "exactly",
            Follow::Range => "range",
            Follow::RealRuns => "real-runs",
            Follow::Outside => "outside",
            Follow::Unknown => "any-value",
        }
    }
}

/// What is known of an instruction by a table; `None` if no front knows it in the table's family.
#[must_use]
pub fn explain(name: &str, table: &Table, fronts: Fronts) -> Option<Explained> {
    let name = name.trim().to_ascii_uppercase();
    let family = table.family.as_deref()?;
    let (front, Examples { dialect, variants, forms }) =
        fronts.0.iter().find_map(|front| Some((*front, front.examples(&name, family)?)))?;
    let mut bare = table.clone();
    bare.factor = None;
    let forms: Vec<FormUse> =
        forms.iter().filter_map(|form| shown(front, dialect, family, form, &bare)).collect();
    let extras = table.rows().iter().filter(|row| row.name.starts_with("@+")).cloned().collect();
    Some(Explained {
        name,
        table: table.name.clone(),
        title: table.title.clone(),
        variants,
        forms,
        extras,
        factor: table.factor.clone(),
    })
}

/// The names of all instructions that the fronts know.
#[must_use]
pub fn names(fronts: Fronts) -> Vec<String> {
    fronts.0.iter().flat_map(|front| front.instructions()).collect()
}

/// A form by the first of its lines that is sound.
fn shown(
    front: &dyn Front,
    dialect: &str,
    family: &str,
    form: &Form,
    table: &Table,
) -> Option<FormUse> {
    let dialect = front.dialects().iter().find(|one| one.name == dialect)?;
    let facts = Facts::default();
    form.candidates.iter().find_map(|one| {
        let input = Input { name: "example".to_owned(), bytes: one.program.clone().into_bytes() };
        let project = front.read(dialect, &[&input], &[], SourceOptions::default()).ok()?;
        let options = Options { family: Some(family), ..Options::new(&facts) };
        let program = project.decode(&options).ok()?;
        let own = |at: &usize| *program.instructions[*at].text == *one.line;
        let parts: Vec<usize> = (0..program.instructions.len()).filter(own).collect();
        let key = parts.iter().find_map(|&at| program.instructions[at].timing.as_deref())?;
        let price = price_of(table, key, &Tags::new()).ok();
        let rows = price.iter().flat_map(|price| price.row.split(" + "));
        let rows = rows.filter_map(|row| table.row(row).cloned()).collect();
        let told = program.approximations.iter().filter(|told| parts.contains(&told.instruction));
        Some(FormUse {
            line: one.line.clone(),
            rows,
            by_class: price.as_ref().is_some_and(|price| price.instead_of.is_some()),
            class: key.class,
            price,
            follow: parts.iter().map(|&at| follow(&program, &program.instructions[at])).max()?,
            approximations: told.map(|told| told.what.to_string()).collect(),
        })
    })
}

/// The least that is known of what a part of an instruction writes and decides.
fn follow(program: &Program, part: &Instruction) -> Follow {
    let part = &at_operands(part);
    let is_quiet = part.effects.is_empty() && matches!(part.step, Step::Act { .. } | Step::Nothing);
    let mut least = if is_quiet { Follow::Nothing } else { Follow::Exactly };
    let mut see = |choice: ChoiceId| least = least.max(known(program, choice));
    part.each_read(&mut |source| match source {
        Source::Bit(BitSource::Free(choice)) | Source::Word(WordSource::Free(choice)) => {
            see(choice)
        }
        _ => {}
    });
    for effect in &part.effects {
        if let Write::Havoc(_, choice) = effect.write {
            see(choice);
        }
    }
    least
}

/// A part with those of its effects alone that write its operands, if any does: flags and memories besides are not what is
/// asked.
fn at_operands(part: &Instruction) -> Instruction {
    let is_operand =
        |region: Region| part.operands.iter().any(|one| region.contains(one.device.cell));
    let one = |first: Cell| Region::Range { first, count: 1 };
    let writes = |effect: &&Effect| match &effect.write {
        Write::Bit(BitTarget::Cell(cell) | BitTarget::WordBit(cell, _), _) => {
            is_operand(one(*cell))
        }
        Write::Words(targets, _) => targets.iter().any(|target| match target {
            WordTarget::Cell(cell) => is_operand(one(*cell)),
            WordTarget::Bits { first, count } => {
                is_operand(Region::Range { first: *first, count: u32::from(*count) })
            }
            WordTarget::Discard => false,
        }),
        Write::Havoc(region, _) => is_operand(*region),
    };
    let own: Vec<Effect> = part.effects.iter().filter(writes).cloned().collect();
    let effects = if own.is_empty() { part.effects.clone() } else { own };
    Instruction { effects, ..part.clone() }
}

fn known(program: &Program, choice: ChoiceId) -> Follow {
    match program.kinds.get(&choice) {
        Some(ChoiceKind::Exact(meaning)) if values::follows(program, meaning) => Follow::Range,
        Some(ChoiceKind::Exact(_)) => Follow::RealRuns,
        Some(ChoiceKind::Iterations(_) | ChoiceKind::UnsignedIterations(_)) => Follow::Exactly,
        Some(
            ChoiceKind::External
            | ChoiceKind::StableExternal(_)
            | ChoiceKind::PresentValue { .. }
            | ChoiceKind::ScanTicks { .. },
        ) => Follow::Outside,
        None => Follow::Unknown,
    }
}
