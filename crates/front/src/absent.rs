//! Calls of routines that are missing from the given files: the facts that a user can state about them.

use super::builder::StatedRoutine;
use scanbound_base::code::Code;
use scanbound_base::diagnostic::Diagnostic;
use scanbound_base::facts::{Facts, Part, StatedCall, key};
use scanbound_ir::Region;

/// The help text of a call of a missing routine: `first` (what else may be wrong), then the line to add to a facts
/// file.
pub fn help(first: &str, name: &str) -> String {
    format!(
        "{first}, or state in a facts file (--facts) what the routine takes and writes: [calls] {} = {{ time = \"50us\", writes = [\"D100-D199\"] }}",
        key(name)
    )
}

/// The stated time and writes of a routine; if the user states no writes, it may write everything. `region` parses a
/// device or a device range; a stated text that it does not parse is left out here and reported by [`faults`]. `also`
/// is added to what is stated, because every routine may write it.
pub fn stated_routine(
    stated: &StatedCall,
    region: impl Fn(&str) -> Option<Vec<Region>>,
    also: &[Region],
) -> StatedRoutine {
    let writes = match &stated.writes {
        None => vec![Region::Everything],
        // `faults` reports a text that is not a device.
        Some(all) => all.iter().filter_map(|text| region(text)).flatten().collect(),
    };
    StatedRoutine { time: stated.time, writes: [&*writes, also].concat() }
}

/// One error for each stated write that is not a device or a device range.
pub fn faults(facts: &Facts, region: impl Fn(&str) -> Option<Vec<Region>>) -> Vec<Diagnostic> {
    let wrong = facts.calls.values().flat_map(|call| {
        let wrong = call.writes.iter().flatten().filter(|text| region(text).is_none());
        wrong.map(move |text| (call, text)).collect::<Vec<_>>()
    });
    let fault = |(call, text): (&StatedCall, &String)| {
        let message =
            format!("'{text}' in the writes of {} is not a device or a device range", call.name);
        let help =
            "write \"D500\" or \"D100-D199\": devices as in the program, the lowest number first";
        facts.fault(["calls", &call.name], Part::Value, Code::Fact, message, help)
    };
    wrong.map(fault).collect()
}
