//! Writes with an unknown target, and what to state about them.

use super::unknown::{INDEX, Unknown, UnknownKind, key};
use scanbound_front::MachineOptions;
use scanbound_ir::{Cell, ChoiceId, Program, WordSource, WordTarget, Write};
use scanbound_model::{Group, Origin, ScanModel, UnknownWrite};
use std::cmp::Reverse;
use std::collections::BTreeSet;
use std::sync::Arc;

/// The largest number of places that a report names.
const MAX_PLACES: usize = 20;

/// The unknown targets of writes on which the bound depends, those with the most possible indices first. A target is
/// left out if it depends on values that other writes with unknown targets may have written: it may be known once their
/// targets are.
/// `machine` says whether the CPU has parameters for indices and indirect addresses.
pub(super) fn all(
    program: &Program,
    model: &ScanModel,
    groups: &[Group],
    machine: MachineOptions,
) -> Vec<Unknown> {
    let matters = relevant_choices(program, model, groups);
    let first = |far: &&UnknownWrite| far.is_independent && matters.contains(&far.choice);
    let first: Vec<&UnknownWrite> = model.unknown_writes.iter().filter(first).collect();
    let is_open = |far: &&&UnknownWrite| {
        program.indexed.get(&far.choice).is_some_and(|indexed| indexed.indices.len() > 1)
    };
    let text = |far: &UnknownWrite| program.instructions[far.instruction].text.clone();
    let place = |far: &&UnknownWrite| (program.instructions[far.instruction].place, text(far));
    let mut found = Vec::new();
    let either: Vec<&UnknownWrite> = first.iter().filter(is_open).copied().collect();
    if machine.index && !either.is_empty() {
        found.push(Unknown {
            word: "index bits".into(),
            places: either.iter().map(place).take(MAX_PLACES).collect(),
            kind: UnknownKind::IndexBits,
            key: "bits".to_owned(),
            fact: "bits = 16".to_owned(),
        });
    }
    let indirect = |far: &&&UnknownWrite| !far.has_index && text(far).contains('@');
    let indirect: Vec<&UnknownWrite> = first.iter().filter(indirect).copied().collect();
    if machine.index && !indirect.is_empty() {
        found.push(Unknown {
            word: "indirect addresses".into(),
            places: indirect.iter().map(place).take(MAX_PLACES).collect(),
            kind: UnknownKind::Indirect,
            key: "indirect".to_owned(),
            fact: "indirect = [\"D0-D99\"]".to_owned(),
        });
    }
    let mut known = BTreeSet::new();
    let indices = first.iter().filter(|far| far.has_index && !is_open(far));
    let mut indices: Vec<&&UnknownWrite> = indices.collect();
    indices.sort_by_key(|far| Reverse(far.most_values));
    for far in indices.into_iter().take(MAX_PLACES) {
        let place = place(far);
        let key = key(program, place.0);
        // An instruction may write to two such targets.
        if known.insert(key.clone()) {
            found.push(Unknown {
                word: index(program, far),
                kind: UnknownKind::Index(
                    far.start_cells.iter().map(|&cell| program.cell_name(cell)).collect(),
                ),
                fact: format!("{key:?} = [0, {INDEX}]"),
                places: vec![place],
                key,
            });
        }
    }
    found
}

/// The name of the word that is the index of the write, or the instruction's text if no cell is.
fn index(program: &Program, far: &UnknownWrite) -> Arc<str> {
    let readings = program.indexed.get(&far.choice).map(|indexed| &indexed.indices[..]);
    let cells = readings.unwrap_or_default().iter().flatten().filter_map(|word| match word {
        WordSource::Cell(cell) => Some(*cell),
        _ => None,
    });
    let first = cells.map(|cell| program.cell_name(cell)).next();
    first.map_or_else(|| program.instructions[far.instruction].text.clone(), Arc::from)
}

/// The choices of the havocs on which guards of the scan depend: a guard, or the index of another of these havocs,
/// reads a cell that the havoc may have changed; or the havoc has an unknown target, and may overwrite a value that the
/// program writes and a guard reads.
fn relevant_choices(program: &Program, model: &ScanModel, groups: &[Group]) -> BTreeSet<ChoiceId> {
    let mut matter: BTreeSet<ChoiceId> = BTreeSet::new();
    let mut starts: BTreeSet<Cell> = BTreeSet::new();
    let guarding = groups.iter().flat_map(|group| &group.variables);
    for variable in guarding.chain(&model.count_variables) {
        match &model.variables[variable.0 as usize].origin {
            Origin::Start(cell) => _ = starts.insert(*cell),
            Origin::Choice(_) => {}
            &Origin::Havocked { cell, since, until } => {
                let moments = model.havocs.concerning(cell, since, until);
                matter.extend(moments.map(|moment| moment.choice));
            }
        }
    }
    let written = written(program);
    let hidden = |far: &&UnknownWrite| match program.indexed.get(&far.choice) {
        Some(indexed) => {
            starts.iter().any(|cell| cell.area == indexed.first.area && written.contains(cell))
        }
        None => starts.iter().any(|cell| written.contains(cell)),
    };
    matter.extend(model.unknown_writes.iter().filter(hidden).map(|far| far.choice));
    // A write can only affect later ones, so go backwards.
    for far in model.unknown_writes.iter().rev() {
        if matter.contains(&far.choice) {
            matter.extend(&far.depends_on);
        }
    }
    matter
}

/// The words that the program writes directly, not with an index.
fn written(program: &Program) -> BTreeSet<Cell> {
    let written = program.instructions.iter().flat_map(|one| &one.effects);
    written
        .flat_map(|effect| match &effect.write {
            Write::Words(targets, _) => &targets[..],
            Write::Bit(..) | Write::Havoc(..) => &[],
        })
        .filter_map(|target| match target {
            WordTarget::Cell(cell) => Some(*cell),
            WordTarget::Bits { .. } | WordTarget::Discard => None,
        })
        .collect()
}

/// Moves counts to the end whose start value is unknown only because a write with an unknown target may have changed
/// them: they may be known once that target is stated.
pub(super) fn put_last(unknowns: &mut [Unknown], program: &Program, model: &ScanModel) {
    let written = written(program);
    let is_reached = |cell: Cell| {
        model.unknown_writes.iter().any(|far| match program.indexed.get(&far.choice) {
            Some(indexed) => indexed.first.area == cell.area,
            None => true,
        })
    };
    let start = |origin: &Origin| match origin {
        Origin::Start(cell) if written.contains(cell) && is_reached(*cell) => Some(*cell),
        _ => None,
    };
    let hidden = model.variables.iter().filter_map(|variable| start(&variable.origin));
    let hidden: BTreeSet<String> = hidden.map(|cell| program.cell_name(cell)).collect();
    unknowns.sort_by_key(|one| one.counts().is_some() && hidden.contains(&*one.word));
}
