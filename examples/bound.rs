//! Prints the bound of the program files that are named.
#![allow(clippy::print_stdout)]

use std::error::Error;

fn main() -> Result<(), Box<dyn Error>> {
    let mut names: Vec<String> = std::env::args().skip(1).collect();
    if names.is_empty() {
        names.push("samples/filler/MAIN.csv".to_owned());
    }
    let mut analysis = scanbound::Analysis::new();
    for name in names {
        let content = std::fs::read(&name)?;
        analysis = analysis.file(name, content);
    }
    let report = analysis.run()?;
    println!("longest scan found: {}, bound: {}", report.lower(), report.upper());
    Ok(())
}
