//! The bound by its parts: `breakdown`.

use scanbound_audit::Audit;
use scanbound_audit::breakdown::{By, Part, Piece};
use schemars::JsonSchema;
use serde::Serialize;

/// One list for each of the ways to share the bound out; the times of each add up to it.
#[derive(Serialize, JsonSchema)]
pub(super) struct Breakdown {
    program: Vec<Row>,
    routine: Vec<Row>,
    rung: Vec<Row>,
    instruction: Vec<Row>,
}

#[derive(Serialize, JsonSchema)]
struct Row {
    kind: &'static str,
    #[serde(skip_serializing_if = "Option::is_none")]
    name: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    file: Option<u32>,
    #[serde(skip_serializing_if = "Option::is_none")]
    line: Option<u32>,
    #[serde(skip_serializing_if = "Option::is_none")]
    step: Option<u32>,
    #[serde(skip_serializing_if = "Option::is_none")]
    block: Option<u32>,
    instructions: usize,
    ps: u64,
    most_ps: u64,
    always_ps: u64,
}

impl Breakdown {
    pub(super) fn of(audit: &Audit) -> Breakdown {
        let rows = |by| audit.breakdown(by).into_iter().map(Row::of).collect();
        Breakdown {
            program: rows(By::Program),
            routine: rows(By::Routine),
            rung: rows(By::Rung),
            instruction: rows(By::Instruction),
        }
    }
}

impl Row {
    fn of(part: Part) -> Row {
        let kind = part.piece.kind();
        let (name, file, at, block) = match part.piece {
            Piece::Program(file) => (None, Some(file), None, None),
            Piece::Routine(file, name) => {
                (name.map(|name| name.to_string()), Some(file), None, None)
            }
            Piece::Rung { block, at, instruction } => {
                (Some(instruction.to_string()), Some(at.file), Some(at), Some(block))
            }
            Piece::Instruction(name) => (Some(name.to_string()), None, None, None),
            Piece::EveryScan(name) | Piece::Factor(name) => (Some(name), None, None, None),
            Piece::Open => (None, None, None, None),
        };
        Row {
            kind,
            name,
            file,
            line: at.map(|at| at.line),
            step: at.and_then(|at| at.step),
            block,
            instructions: part.instructions,
            ps: part.time.0,
            most_ps: part.most.0,
            always_ps: part.always.0,
        }
    }
}
