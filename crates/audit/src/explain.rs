//! What is known of an instruction: its times by a timing table, and how precisely the analysis follows it. Both come
//! from sample lines of the front, which are decoded like any program.

use scanbound_base::facts::Facts;
use scanbound_front::{ExampleForm, Examples, Front, Fronts, Input, Options, SourceOptions};
use scanbound_ir::{
    BitSource, BitTarget, Cell, ChoiceId, ChoiceKind, Effect, Instruction, Program, Region, Source,
    Step, WordSource, WordTarget, Write,
};
use scanbound_passes::values;
use scanbound_timing::price::{OperandTags, Price, price_of};
use scanbound_timing::table::{Factor, Row, Table};

/// What a timing table and the analysis say about an instruction.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ExplainedInstruction {
    /// The name of the instruction, in upper case.
    pub name: String,
    /// The name of the timing table.
    pub table: String,
    /// The title of the table, one line.
    pub title: String,
    /// Names of instructions that have the same effect and only differ in their form, such as pulse forms.
    pub variants: Vec<String>,
    /// The forms of the instruction, such as those with different operands. Forms of which no sample line can be
    /// decoded are left out.
    pub forms: Vec<FormUse>,
    /// The rows of the table that add time for operands in some areas (`@+ZR`) or for bits of words. The times in
    /// `forms` do not include them.
    pub extras: Vec<Row>,
    /// The factor on the whole scan. The times in `forms` do not include it. `None` if the table has none.
    pub factor: Option<Factor>,
}

/// One form of an instruction, described by a sample line.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FormUse {
    /// A sample line of this form.
    pub line: String,
    /// The rows of the table that give the time of the sample line. Empty if the table has no time for it.
    pub rows: Vec<Row>,
    /// Whether the first of `rows` is not for the instruction itself, but for its timing class.
    pub by_class: bool,
    /// The timing class of this form: the table may have one row for all instructions of a class.
    pub class: &'static str,
    /// The times of the sample line, without the factor and without [`ExplainedInstruction::extras`]. `None` if the
    /// table has no time for it.
    pub price: Option<Price>,
    /// How precisely the analysis follows this form.
    pub follow: Follow,
    /// What the analysis over-approximates in this form, one text each.
    pub approximations: Vec<String>,
}

/// How precisely the analysis follows an instruction. The most precise comes first.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Follow {
    /// The instruction changes no device.
    Nothing,
    /// Everything that the instruction writes and decides is followed exactly.
    Exactly,
    /// The result may be any value in the scan's model, but a range of values is computed if a number of iterations or
    /// an index depends on it. Real runs compute the result exactly.
    Range,
    /// The result may be any value in the scan's model, but real runs compute it exactly.
    RealRuns,
    /// The result comes from outside the program and may be any value.
    Outside,
    /// The result may be any value, and real runs do not know it either.
    Unknown,
}

impl Follow {
    /// The name of this degree of precision in reports.
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

/// What a table and the fronts know about an instruction. `None` if no front of the table's CPU family knows it, or if
/// the table names no family.
#[must_use]
pub fn explain(name: &str, table: &Table, fronts: Fronts) -> Option<ExplainedInstruction> {
    let name = name.trim().to_ascii_uppercase();
    let family = table.family.as_deref()?;
    let (front, Examples { dialect, variants, forms }) =
        fronts.0.iter().find_map(|front| Some((*front, front.examples(&name, family)?)))?;
    let mut bare = table.clone();
    bare.factor = None;
    let forms: Vec<FormUse> =
        forms.iter().filter_map(|form| shown(front, dialect, family, form, &bare)).collect();
    let extras = table.rows().iter().filter(|row| row.name.starts_with("@+")).cloned().collect();
    Some(ExplainedInstruction {
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

/// Describes a form by the first of its sample lines that can be decoded. `None` if none can.
fn shown(
    front: &dyn Front,
    dialect: &str,
    family: &str,
    form: &ExampleForm,
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
        let price = price_of(table, key, &OperandTags::new()).ok();
        let rows = price.iter().flat_map(|price| price.row.split(" + "));
        let rows = rows.filter_map(|row| table.row(row).cloned()).collect();
        let found =
            program.approximations.iter().filter(|found| parts.contains(&found.instruction));
        Some(FormUse {
            line: one.line.clone(),
            rows,
            by_class: price.as_ref().is_some_and(|price| price.instead_of.is_some()),
            class: key.class,
            price,
            follow: parts.iter().map(|&at| follow(&program, &program.instructions[at])).max()?,
            approximations: found.map(|found| found.what.to_string()).collect(),
        })
    })
}

/// How precisely the analysis follows what a part of an instruction writes and decides. The least precise value that it
/// reads or writes decides. Flags count only if the part writes none of its operands.
fn follow(program: &Program, part: &Instruction) -> Follow {
    let part = &at_operands(part);
    let is_quiet = part.effects.is_empty() && matches!(part.step, Step::Act { .. } | Step::Nothing);
    let mut least = if is_quiet { Follow::Nothing } else { Follow::Exactly };
    let mut see = |choice: ChoiceId| least = least.max(follow_of_choice(program, choice));
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

/// A copy of a part with only those effects that write its operands, which leaves out flags and memory bits. If no
/// effect writes an operand, all effects are kept.
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

fn follow_of_choice(program: &Program, choice: ChoiceId) -> Follow {
    if program.always_followed.contains(&choice) {
        return Follow::Exactly;
    }
    match program.kinds.get(&choice) {
        Some(ChoiceKind::Exact(meaning)) if values::follows(program, meaning) => Follow::Range,
        Some(ChoiceKind::Exact(_)) => Follow::RealRuns,
        Some(ChoiceKind::Iterations(_) | ChoiceKind::UnsignedIterations(_)) => Follow::Exactly,
        Some(
            ChoiceKind::External
            | ChoiceKind::StableExternal(_)
            | ChoiceKind::Reading(_)
            | ChoiceKind::ExtraTime
            | ChoiceKind::Parameter
            | ChoiceKind::PresentValue { .. }
            | ChoiceKind::ScanTicks { .. },
        ) => Follow::Outside,
        Some(ChoiceKind::AddressOf { .. } | ChoiceKind::Unreachable(_)) => Follow::Unknown,
        None => Follow::Unknown,
    }
}
