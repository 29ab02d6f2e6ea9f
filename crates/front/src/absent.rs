//! Calls of routines that are not among the files given: what the user may state of such a routine instead.

use super::builder::Known;
use scanbound_base::code::Code;
use scanbound_base::diagnostic::Diagnostic;
use scanbound_base::facts::{Facts, Part, StatedCall, key};
use scanbound_ir::Region;

/// The help for a call whose routine is not there: what else may be wrong, and the line for a facts file.
pub fn help(first: &str, name: &str) -> String {
    format!(
        "{first}, or state in a facts file (--facts) what the routine takes and writes: [calls] {} = {{ time = \"50us\", writes = [\"D100-D199\"] }}",
        key(name)
    )
}

/// What is stated of a routine. `region` reads devices: one, or from the first to the last; `also` is what every routine may
/// write whatever is stated.
pub fn known(
    stated: &StatedCall,
    region: impl Fn(&str) -> Option<Vec<Region>>,
    also: &[Region],
) -> Known {
    let writes = match &stated.writes {
        None => vec![Region::Everything],
        // What is no device is a fault.
        Some(all) => all.iter().filter_map(|text| region(text)).flatten().collect(),
    };
    Known { time: stated.time, writes: [&*writes, also].concat() }
}

/// The faults of what routines are stated to write, where it is no devices.
pub fn faults(facts: &Facts, region: impl Fn(&str) -> Option<Vec<Region>>) -> Vec<Diagnostic> {
    let wrong = facts.calls.values().flat_map(|call| {
        let wrong = call.writes.iter().flatten().filter(|text| region(text).is_none());
        wrong.map(move |text| (call, text)).collect::<Vec<_>>()
    });
    let fault = |(call, text): (&StatedCall, &String)| {
        let message = format!("'{text}' is no device, nor from one to another of its kind");
        let help = "write \"D100-D199\" or \"D500\": devices as in the program, the least first";
        facts.fault(["calls", &call.name], Part::Value, Code::Fact, message, help)
    };
    wrong.map(fault).collect()
}
