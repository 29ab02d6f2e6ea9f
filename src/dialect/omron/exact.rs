//! What OMRON instructions really do where the effects say any value.

use super::assembly::Assembly;
use super::operand::Operand;
use super::resolve::Item;
use crate::program::meaning::{ChoiceKind, Meaning, Operand as Input, Operation, Target, Unary};
use crate::program::{BitSource, BitTarget, ChoiceId, WordSource, WordTarget};

/// The choice of an instruction that writes any value: with its exact meaning, where it has one.
pub(super) fn choice(asm: &mut Assembly, item: &Item<'_>) -> ChoiceId {
    let meaning = meaning(asm, item);
    let choice = asm.choice();
    if let Some(meaning) = meaning {
        asm.program.kinds.insert(choice, ChoiceKind::Exact(Box::new(meaning)));
    }
    choice
}

/// The exact meaning of an instruction whose written operands are taken as any value; its flags are apart.
fn meaning(asm: &mut Assembly, item: &Item<'_>) -> Option<Meaning> {
    let one =
        |operation, inputs, output| Some(Meaning { operation, inputs, outputs: vec![output] });
    match &*item.name {
        "BCD" => {
            one(Operation::Each(Unary::ToBcd), vec![words(asm, item, 0, 1)?], target(item, 1, 1)?)
        }
        "BIN" => {
            one(Operation::Each(Unary::FromBcd), vec![words(asm, item, 0, 1)?], target(item, 1, 1)?)
        }
        "ROL" | "ROR" => {
            let left = item.name == "ROL";
            let places = Input::Words(vec![WordSource::Const(1)]);
            let inputs = vec![words(asm, item, 0, 1)?, places, carry(asm)?];
            one(Operation::Rotate { left, through: true }, inputs, target(item, 0, 1)?)
        }
        _ => None,
    }
}

/// So many words from an operand on, as they are read.
fn words(asm: &mut Assembly, item: &Item<'_>, at: usize, count: u32) -> Option<Input> {
    let memory = asm.memory;
    let sources = item.operands.get(at)?.sources(count, memory, &mut || asm.choice())?;
    Some(Input::Words(sources))
}

/// The carry flag.
fn carry(asm: &Assembly) -> Option<Input> {
    let flag = match asm.memory.flag("CY")? {
        BitTarget::Cell(cell) => BitSource::Cell(cell),
        BitTarget::WordBit(cell, bit) => BitSource::WordBit(cell, bit),
    };
    Some(Input::Bits(vec![flag]))
}

/// Where so many words from an operand on are written.
fn target(item: &Item<'_>, at: usize, count: u32) -> Option<Target> {
    let Operand::Word(first) = item.operands.get(at)? else { return None };
    Some(Target::Words((0..count).map(|n| WordTarget::Cell(first.plus(n))).collect()))
}
