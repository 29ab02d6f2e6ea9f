//! Calibrates a CPU: writes a program that measures by itself what instructions take, and makes a timing table of what it
//! found.
//!
//! An instruction is measured by the difference of two blocks that are alike but for the number of its copies: what a
//! loop, a rung and a scan cost besides cancels out. Each block is chosen by a step word; the CPU's own scan-time
//! register is read over many scans, and the least and the largest reading of each step are kept in data registers.
//! A reading is right to one step of the register, so a difference is right to two, and to what the readings scatter;
//! its upper end is what the table gets.

pub mod fit;
pub mod forms;
pub mod language;
pub mod plan;
pub mod program;
pub mod result;
pub mod table;

pub use forms::{Form, Left, Shape};
pub use language::Language;
pub use plan::{Measure, Part, Plan, Settings, State};

use crate::front::Fronts;
use crate::program::Program;
use crate::timing::table::Table;

/// A calibration with the files of its parts.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Written {
    /// What the results will mean.
    pub plan: Plan,
    /// Each part's program, as it is loaded.
    pub files: Vec<Vec<u8>>,
}

/// Writes a calibration for a CPU: of what programs use, or of the table's own instructions. None where the family's
/// programs cannot be written, or nothing is left to be measured.
#[must_use]
pub fn write(
    program: Option<&Program>,
    table: &Table,
    cpu: &str,
    settings: Settings,
    fronts: Fronts,
) -> Option<Written> {
    let language = Language::of(table.family.as_deref()?)?;
    let mut bare = table.clone();
    bare.factor = None;
    let (mut forms, left) = forms::choose(program, &bare, language, fronts);
    // What brings coils along needs to know what a coil takes.
    if forms.iter().any(|form| form.shape == Shape::Start) {
        let coil = format!("OUT {}", language.coil());
        let form = forms::of_line(&coil, &bare, language, fronts);
        forms.retain(|form| !form.line.starts_with("OUT "));
        forms.extend(form);
    }
    let (plan, blocks) = plan::lay_out(&forms, left, &bare, language, cpu, settings);
    let files = plan.parts.iter().zip(&blocks).map(|(part, blocks)| {
        let lines = program::lines(language, blocks, part.steps, settings.scans);
        program::file(language, cpu, &lines)
    });
    let files: Vec<Vec<u8>> = files.collect();
    (!files.is_empty()).then_some(Written { plan, files })
}
