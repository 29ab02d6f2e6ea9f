//! Facts about routines that a program calls but whose source is not among the files given.

use crate::time::Picos;

/// What the user states about one missing routine.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct StatedCall {
    /// The routine's name as it stands in the facts file.
    pub name: String,
    /// The longest time from the call of the routine to its return, without the call instruction itself.
    pub time: Picos,
    /// The devices that the routine writes: single devices or ranges (`D100-D199`). `None`: the routine may write any
    /// device.
    pub writes: Option<Vec<String>>,
}

/// Normalises a routine's name: removes what may be written in several ways (letter case, blanks, leading zeros of the
/// number, function codes). `SBN(092) 010` becomes `SBN10`. A program's name may precede it (`SUB:P10`).
#[must_use]
pub fn normalized(name: &str) -> String {
    let joined = |text: &str| text.split_whitespace().collect::<String>().to_uppercase();
    if let Some((program, name)) = name.rsplit_once(':') {
        return format!("{}:{}", joined(program), normalized(name));
    }
    let mut name = joined(name);
    if let (Some(open), Some(close)) = (name.find('('), name.find(')'))
        && open < close
    {
        name.replace_range(open..=close, "");
    }
    let at = name.find(|c: char| c.is_ascii_digit()).unwrap_or(name.len());
    let (letters, number) = name.split_at(at);
    // If all digits are zeros, one zero remains.
    let zeros = number.bytes().take_while(|&digit| digit == b'0').count();
    let is_zero = number.as_bytes().get(zeros).is_none_or(|next| !next.is_ascii_alphanumeric());
    let zeros = if is_zero { zeros.saturating_sub(1) } else { zeros };
    format!("{letters}{}", &number[zeros..])
}

/// Formats a name as a key of a facts file, in quotation marks where TOML needs them.
#[must_use]
pub fn key(name: &str) -> String {
    let is_bare = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '-';
    if !name.is_empty() && name.chars().all(is_bare) {
        return name.to_owned();
    }
    let mut quoted = String::from("\"");
    for c in name.chars() {
        match c {
            '"' | '\\' => quoted.extend(['\\', c]),
            c if c.is_control() => quoted += &format!("\\u{:04X}", u32::from(c)),
            c => quoted.push(c),
        }
    }
    quoted + "\""
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::facts::Facts;

    #[test]
    fn names_are_the_same_however_they_are_written() {
        let names = ["p007", "P 7", "SUB:p07", "SBN(092) 010", "gsbn 0", "P00", "D10.A", "W0FF"];
        let plain = names.map(normalized);
        assert_eq!(plain, ["P7", "P7", "SUB:P7", "SBN10", "GSBN0", "P0", "D10.A", "WFF"]);
    }

    #[test]
    fn every_fault_of_a_routine_is_told_at_its_place() {
        let text = "[calls]\nP1 = '50us'\nP2 = { writes = ['D1'] }\nP3 = { time = 50 }\nP4 = { time = '1us', write = ['D1'] }\nP5 = { time = '1us', writes = 'D1' }\nP06 = { time = '11s' }\nP7 = { time = '1us' }\nP07 = { time = '2us' }\n";
        let faults = Facts::parse("facts.toml", text).expect_err("seven faults");
        let errors: Vec<(u32, &str)> =
            faults.iter().map(|fault| (fault.line.unwrap_or(0), &*fault.message)).collect();
        assert_eq!(
            errors,
            [
                (2, "the facts about the routine P1 must be in braces"),
                (3, "the longest execution time of P2 is not stated"),
                (4, "the time of the routine P3 must be at most 10 s, in quotes with its unit"),
                (5, "'write' is not a key of a routine in [calls]"),
                (6, "writes of P5 must be a list of devices"),
                (7, "the time of the routine P06 must be at most 10 s, in quotes with its unit"),
                (8, "[calls] states the same routine twice, as P7 and as P07"),
            ]
        );
        assert!(faults[3].help.starts_with("did you mean writes?"));
    }
}
