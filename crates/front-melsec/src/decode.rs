//! Decodes a MELSEC project to a program of `ir`: resolves instructions and operands, checks the control structure, and
//! lowers each instruction.

use super::lower::Lowering;
use super::memory::Family;
pub use super::resolve::DecodeOptions;
use super::resolve::resolve;
use super::source::RawProject;
use super::structure::structure;
use scanbound_base::code::Code;
use scanbound_base::diagnostic::Diagnostic;
use scanbound_front::Faults;
use scanbound_ir::Program;

/// Resolves, checks and lowers a project to a program of `ir`.
///
/// # Errors
///
/// If any diagnostic is an error: the diagnostics of all files, warnings included, of each file at most 50 errors and
/// 50 warnings. Errors in the user's facts are reported only if the files have none. A project with more instructions
/// than the largest CPU of the family can hold gives that error alone.
pub fn decode(
    project: &RawProject,
    options: &DecodeOptions<'_>,
) -> Result<Program, Vec<Diagnostic>> {
    too_many(project, options.family)?;
    let mut faults: Vec<Faults<'_>> =
        project.files.iter().map(|file| Faults::new(&file.name)).collect();
    let resolved = resolve(project, options, &mut faults);
    let structure = structure(&resolved, options, &mut faults);
    let mut emitter = Lowering::new(&resolved, &structure, options, faults);
    for file in 0..project.files.len() {
        emitter.file(file);
    }
    emitter.finish()
}

/// Returns an error for a project that has more instructions than the largest CPU of its family can hold (each takes at
/// least one step).
fn too_many(project: &RawProject, family: Family) -> Result<(), Vec<Diagnostic>> {
    let most = family.most_steps();
    let files = project.files.iter();
    let mut all = files.flat_map(|file| file.instructions.iter().map(move |one| (file, one)));
    let Some((file, one)) = all.nth(most) else { return Ok(()) };
    let message = format!("the project has more than {most} instructions");
    let help =
        format!("check the file and the CPU: no {} can hold so many instructions", family.series());
    let fault = Diagnostic::line(Code::TooMany, &file.name, one.line, &*one.text, message, help);
    Err(vec![fault.at_step(one.step)])
}
