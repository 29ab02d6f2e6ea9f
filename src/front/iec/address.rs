//! Direct addresses: memory and outputs that two variables share are not followed, so that no write goes unseen.

use crate::base::code::Code;
use crate::iec::fault::Fault;
use crate::iec::{Project, Variable};

/// An area, and from where to where in it, in both ways of counting.
type Bits = (char, [(u64, u64); 2]);

/// The bits that an address takes: counted in bytes, as some count, and in units of its own size, as others do.
fn bits(address: &str) -> Option<Bits> {
    let rest = address.strip_prefix('%')?;
    let area = rest.chars().next().filter(|area| matches!(area, 'Q' | 'M'))?;
    let rest = &rest[1..];
    let digits = rest.trim_start_matches(|c: char| c.is_ascii_alphabetic());
    let size = match rest[..rest.len() - digits.len()].chars().next() {
        None | Some('X') => 1,
        Some('B') => 8,
        Some('W') => 16,
        Some('D') => 32,
        Some(_) => 64,
    };
    let numbers: Option<Vec<u64>> = digits.split('.').map(|part| part.parse().ok()).collect();
    let numbers = numbers.filter(|numbers| !numbers.is_empty())?;
    let (first, last) = (numbers[0], numbers[numbers.len() - 1]);
    let at = match (size, numbers.len()) {
        // A bit of a byte.
        (1, 2..) => [first.checked_mul(8)?.checked_add(last)?; 2],
        (1, _) => [first; 2],
        _ => [first.checked_mul(8)?, first.checked_mul(size)?],
    };
    Some((area, at.map(|at| (at, at.saturating_add(size)))))
}

/// The faults of variables that share memory or outputs: with each other, with addresses that code names by themselves, or
/// with those of another instance of the same unit.
pub(super) fn shared(
    project: &Project,
    named: &[Variable],
    has_instances: &dyn Fn(&str) -> bool,
) -> Vec<(usize, Fault)> {
    let mut found: Vec<(usize, &Variable, Bits)> = Vec::new();
    let mut faults = Vec::new();
    let globals = project.globals.iter().flat_map(|(_, list)| list).map(|one| (0, one));
    let own =
        project.pous.iter().flat_map(|pou| pou.variables.iter().map(move |one| (pou.file, one)));
    for (file, variable) in globals.chain(own).chain(named.iter().map(|one| (0, one))) {
        let Some(taken) = variable.at.as_deref().and_then(bits) else { continue };
        let meets = |one: &&(usize, &Variable, Bits)| {
            let overlap = |side: usize| {
                let ((a, b), (c, d)) = (one.2.1[side], taken.1[side]);
                a < d && c < b
            };
            one.2.0 == taken.0 && (overlap(0) || overlap(1))
        };
        if let Some((_, other, _)) = found.iter().find(meets) {
            let message = format!(
                "{} at {} may share memory with {} at {}, which is not followed",
                variable.name,
                variable.at.as_deref().unwrap_or_default(),
                other.name,
                other.at.as_deref().unwrap_or_default()
            );
            let help = "let one variable have the address, and use that in both places";
            faults.push((
                file,
                Fault::new(variable.line, message).code(Code::NotModelled).help(help),
            ));
        }
        found.push((file, variable, taken));
    }
    for pou in project.pous.iter().filter(|pou| has_instances(&pou.name)) {
        let fixed = |one: &&Variable| one.at.as_deref().and_then(bits).is_some();
        if let Some(one) = pou.variables.iter().find(fixed) {
            let message = format!(
                "{} has an address of its own, which several instances of {} share",
                one.name, pou.name
            );
            let help = "hand the variable over as an input or output";
            faults
                .push((pou.file, Fault::new(one.line, message).code(Code::NotModelled).help(help)));
        }
    }
    faults
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::iec::parse::file;

    #[test]
    fn variables_that_share_memory_are_found_and_others_left_alone() {
        let faults = |variables: &str| {
            let text = format!("PROGRAM p VAR {variables} END_VAR x := 1; END_PROGRAM");
            shared(&file("a.st", &text).expect("a program"), &[], &|_| false).len()
        };
        assert_eq!(faults("a AT %MW0 : INT; b AT %MX0.3 : BOOL;"), 1);
        assert_eq!(faults("a AT %MW1 : INT; b AT %MB2 : BYTE;"), 1);
        assert_eq!(faults("a AT %QX0.0 : BOOL; b AT %QX0.0 : BOOL;"), 1);
        assert_eq!(
            faults("a AT %QX0.0 : BOOL; b AT %QX0.1 : BOOL; c AT %MW8 : INT; d AT %IX0.0 : BOOL;"),
            0
        );
    }
}
