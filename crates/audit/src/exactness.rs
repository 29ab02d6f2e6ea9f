//! How many of a project's statements are followed exactly, and why the others are not.
//!
//! A statement is followed exactly if the model of the scan gives everything that it reads or writes the same value as
//! a PLC. Inputs, and how far timers have run, may have any value nevertheless. `docs/sfc.md` says what counts as a
//! statement.

use scanbound_base::location::Location;
use scanbound_ir::meaning::{ChoiceKind, Operation};
use scanbound_ir::{
    Approximated, BitSource, ChoiceId, Frame, Instruction, Program, Resolution, Source, Step,
    WordSource, Write,
};
use scanbound_model::{Origin, ScanModel};
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

/// How many statements of a project are followed exactly, by language, and why the others are not.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Exactness {
    /// One entry for each language, the one with the most statements first.
    pub languages: Vec<LanguageUse>,
    /// The reasons why statements are not followed exactly, the one with the most statements first.
    pub constructs: Vec<Construct>,
    /// The names of bodies that could not be read and that no scan calls, each with the reason why it could not be
    /// read.
    pub unread: Vec<(String, String)>,
}

/// The numbers of bodies and statements in one language.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct LanguageUse {
    /// The abbreviation of the language, such as ST.
    pub language: &'static str,
    /// The number of bodies that a scan can call.
    pub called: u64,
    /// The number of bodies that no scan can call. Their statements are not counted.
    pub uncalled: u64,
    /// The number of statements in the called bodies.
    pub statements: u64,
    /// The number of statements in the called bodies that are followed exactly.
    pub exact: u64,
}

/// A reason why statements are not followed exactly: a construct whose result may be any value in the model. A
/// statement with several reasons is counted only for the first.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Construct {
    /// The reason as a text for reports, such as `any value is assumed for a product of two values`.
    pub what: String,
    /// The number of statements for which this is the first reason.
    pub statements: u64,
    /// The statements for which this is the first reason, sorted by place.
    pub places: Vec<InexactUse>,
}

/// A statement that is not followed exactly.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct InexactUse {
    /// The place of the statement.
    pub at: Location,
    /// The name of the body that contains the statement.
    pub body: String,
    /// The first line of the statement.
    pub text: Arc<str>,
}

impl Exactness {
    /// The number of statements in all languages, and the number of those that are followed exactly.
    #[must_use]
    pub fn total(&self) -> (u64, u64) {
        let sum = |of: fn(&LanguageUse) -> u64| self.languages.iter().map(of).sum();
        (sum(|one| one.statements), sum(|one| one.exact))
    }

    /// Counts the statements of a program that the model follows exactly. `None` if the program's front lists no
    /// bodies.
    pub(super) fn of(program: &Program, model: &ScanModel) -> Option<Exactness> {
        let source = &program.statements;
        if source.bodies.is_empty() {
            return None;
        }
        let reasons = reasons(program, model);
        let by_instruction = source.by_instruction(program.instructions.len());
        // If a statement has several reasons, the first one is reported.
        let mut inexact: BTreeMap<usize, String> = BTreeMap::new();
        for (instruction, reason) in reasons {
            if let Some(statement) = by_instruction.get(instruction).copied().flatten() {
                inexact.entry(statement).or_insert(reason);
            }
        }
        let mut languages: BTreeMap<&'static str, LanguageUse> = BTreeMap::new();
        let blank =
            |language| LanguageUse { language, called: 0, uncalled: 0, statements: 0, exact: 0 };
        for body in &source.bodies {
            let language = languages.entry(body.language).or_insert_with(|| blank(body.language));
            *if body.is_called { &mut language.called } else { &mut language.uncalled } += 1;
        }
        let mut constructs: BTreeMap<&str, Construct> = BTreeMap::new();
        for (at, one) in source.all.iter().enumerate() {
            let body = &source.bodies[one.body];
            let language = languages.entry(body.language).or_insert_with(|| blank(body.language));
            let count = u64::from(one.count);
            language.statements += count;
            let Some(what) = inexact.get(&at) else {
                language.exact += count;
                continue;
            };
            let construct = constructs.entry(what).or_insert_with(|| Construct {
                what: what.clone(),
                statements: 0,
                places: Vec::new(),
            });
            construct.statements += count;
            let (name, text) = (body.name.clone(), one.text.clone());
            construct.places.push(InexactUse { at: one.place, body: name, text });
        }
        let mut languages: Vec<LanguageUse> = languages.into_values().collect();
        languages.sort_by_key(|one| std::cmp::Reverse(one.statements));
        let mut constructs: Vec<Construct> = constructs.into_values().collect();
        constructs.iter_mut().for_each(|one| one.places.sort_by_key(|place| place.at));
        constructs.sort_by_key(|one| std::cmp::Reverse(one.statements));
        let unread = source.bodies.iter().filter(|body| !body.is_called);
        let unread = unread.filter_map(|body| Some((body.name.clone(), body.unreadable.clone()?)));
        Some(Exactness { languages, constructs, unread: unread.collect() })
    }
}

/// Why instructions are not followed exactly: indices of instructions, ascending, each with a reason as a text. An
/// instruction with several reasons occurs several times.
fn reasons(program: &Program, model: &ScanModel) -> Vec<(usize, String)> {
    let mut found: Vec<(usize, String)> = Vec::new();
    let taken = taken(program, model);
    for one in &program.approximations {
        if !holds_here(program, &taken, one.instruction) {
            continue;
        }
        let text = one.what.to_string();
        match (&one.what, &program.instructions[one.instruction].step) {
            (Approximated::WholeSummary(_), _) => {
                found.extend((0..program.instructions.len()).map(|at| (at, text.clone())));
            }
            (_, Step::Summary(summary)) => {
                found.extend(summary.charges.iter().map(|(at, _)| (*at, text.clone())));
            }
            _ => {}
        }
        found.push((one.instruction, text));
    }
    for (at, instruction) in program.instructions.iter().enumerate() {
        let inexact = choices(instruction).into_iter().filter(|choice| taken.contains(choice));
        found.extend(inexact.filter_map(|choice| Some((at, construct(program, choice)?))));
    }
    found.sort_by_key(|(at, _)| *at);
    found
}

/// The choices (nondeterministic values) that an instruction reads or writes.
fn choices(instruction: &Instruction) -> Vec<ChoiceId> {
    let mut found = Vec::new();
    instruction.each_read(&mut |source| match source {
        Source::Bit(BitSource::Free(choice)) | Source::Word(WordSource::Free(choice)) => {
            found.push(choice);
        }
        Source::Bit(_) | Source::Word(_) => {}
    });
    found.extend(instruction.effects.iter().filter_map(|effect| match effect.write {
        Write::Havoc(_, choice) => Some(choice),
        Write::Bit(..) | Write::Words(..) => None,
    }));
    found
}

/// Whether an approximation of the instruction `at` matters in the model: one of its choices is among `taken`, or it
/// has no choices.
fn holds_here(program: &Program, taken: &BTreeSet<ChoiceId>, at: usize) -> bool {
    let choices_here = choices(&program.instructions[at]);
    choices_here.is_empty() || choices_here.iter().any(|choice| taken.contains(choice))
}

/// The choices that may have any value somewhere in the model. Left out are choices that the model resolved to exact
/// results, and results that the language leaves undefined.
fn taken(program: &Program, model: &ScanModel) -> BTreeSet<ChoiceId> {
    let read = model.variables.iter().filter_map(|variable| match &variable.origin {
        Origin::Choice(key) => Some((&key.frames, key.choice)),
        Origin::Start(_) | Origin::Havocked { .. } => None,
    });
    let written = model.havocs.all().iter().map(|havoc| (&havoc.frames, havoc.choice));
    let is_followed = |(frames, choice): &(&Vec<Frame>, ChoiceId)| {
        model.resolutions.choice(frames, *choice) == Some(&Resolution::Exact)
            || program.statements.undefined_by_language.contains(choice)
    };
    read.chain(written).filter(|one| !is_followed(one)).map(|(_, choice)| choice).collect()
}

/// The reason why a choice may have any value, named after the operation of which it is the result, as a text for
/// reports. `None` if the value comes from outside.
fn construct(program: &Program, choice: ChoiceId) -> Option<String> {
    let meaning = match program.kinds.get(&choice) {
        Some(ChoiceKind::Exact(meaning)) => meaning,
        Some(_) => return None,
        None => {
            return Some(
                "any value is assumed for the result of an instruction whose meaning is not modelled"
                    .to_owned(),
            );
        }
    };
    let what = match &meaning.operation {
        Operation::Copy => "an element of an array whose index is unknown",
        Operation::Multiply { .. } => "a product of two values",
        Operation::Divide { .. } | Operation::DivideJoined { .. } => "a quotient or remainder",
        Operation::Shift { .. } | Operation::Rotate { .. } => "shifted or rotated bits",
        Operation::Real(_) => "arithmetic of REAL",
        Operation::ToReal | Operation::FromReal(_) => "a conversion from or to REAL",
        _ => "the result of an operation",
    };
    Some(format!("any value is assumed for {what}"))
}
