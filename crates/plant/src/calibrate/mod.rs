//! Calibrates a CPU: writes a program that measures by itself what instructions take, and makes a timing table of what
//! it found.
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
mod resolve;
pub mod result;
mod rung;
mod spare;
pub mod table;
mod variants;

pub use forms::{Form, Unmeasured};
pub use language::Language;
pub use plan::{Measure, Part, Plan, Settings, State};
pub use rung::Rung;
pub use spare::Spare;

use scanbound_front::Fronts;
use scanbound_ir::Program;
use scanbound_timing::table::Table;

/// A calibration, with the files of its parts.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Written {
    /// The meaning of the results.
    pub plan: Plan,
    /// Each part's program, as it is loaded into the CPU.
    pub files: Vec<Vec<u8>>,
    /// The same programs as instruction lists.
    pub lists: Vec<Vec<u8>>,
}

/// Writes a calibration for a CPU, for the instructions that programs use or for those in the table. `None` if there is
/// no language for the family, or nothing to measure.
#[must_use]
pub fn write(
    program: Option<&Program>,
    table: &Table,
    cpu: &str,
    settings: Settings,
    spare: &Spare,
    fronts: Fronts,
) -> Option<Written> {
    let language = Language::of(table.family.as_deref()?)?;
    let mut bare = table.clone();
    bare.factor = None;
    let source = forms::Source { table: &bare, language, fronts, spare };
    let (mut forms, left) = forms::choose(program, source);
    // The other instructions in the rungs of a copy must be measured, too.
    let mut wanted: Vec<String> = Vec::new();
    for form in &forms {
        wanted.extend(form.rung.besides(&form.line, &form.own));
        // Contacts need a coil.
        wanted.extend(form.rung.close.iter().cloned());
    }
    if !wanted.is_empty() {
        wanted.push(format!("OUT {}", language.coil()));
    }
    for line in wanted {
        if !forms.iter().any(|form| form.line == line) {
            forms.extend(forms::of_line(&line, source));
        }
    }
    let (plan, laid) = plan::lay_out(&forms, left, &bare, language, cpu, settings);
    let all: Vec<Vec<String>> = plan
        .parts
        .iter()
        .zip(&laid)
        .map(|(part, laid)| {
            program::lines(language, laid, [part.empty, part.steps], settings.scans)
        })
        .collect();
    let files: Vec<Vec<u8>> = all.iter().map(|lines| program::file(language, cpu, lines)).collect();
    let lists = all.iter().map(|lines| program::text(lines)).collect();
    (!files.is_empty()).then_some(Written { plan, files, lists })
}
