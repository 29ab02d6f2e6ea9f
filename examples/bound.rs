//! Prints the bound of the program files that are named.
#![allow(clippy::print_stdout)]

use std::error::Error;

fn main() -> Result<(), Box<dyn Error>> {
    let mut names: Vec<String> = std::env::args().skip(1).collect();
    if names.is_empty() {
        names.push("samples/filler/MAIN.csv".to_owned());
    }
    println!("{}", bound(&names)?);
    Ok(())
}

/// The bound of these files as one project, in words.
///
/// # Errors
/// A file cannot be read, or the project cannot be analysed.
pub fn bound(names: &[String]) -> Result<String, Box<dyn Error>> {
    let mut analysis = scanbound::Analysis::new();
    for name in names {
        analysis = analysis.file(name, std::fs::read(name)?);
    }
    let report = analysis.run()?;
    Ok(format!("longest scan found: {}, bound: {}", report.lower(), report.upper()))
}
