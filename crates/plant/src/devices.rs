//! Devices by the names that users write.

use scanbound_ir::{Area, AreaId, AreaKind, Cell, Program, Radix};

/// The area of that name.
pub(crate) fn area(program: &Program, name: &str) -> Option<AreaId> {
    let found = program.areas.iter().position(|area| area.name == name)?;
    u16::try_from(found).ok().map(AreaId)
}

/// The cell of a device as users write it (`X1F`, `D100`). `None` if there is no such device.
pub(crate) fn cell(program: &Program, name: &str) -> Option<Cell> {
    let name = name.trim().to_ascii_uppercase();
    let number = |area: &Area| {
        let digits = name.strip_prefix(&*area.name).filter(|rest| !rest.is_empty())?;
        let radix = match area.radix {
            Radix::Decimal => 10,
            Radix::Hexadecimal => 16,
            Radix::Octal => 8,
        };
        let all = digits.chars().all(|digit| digit.is_digit(radix));
        all.then(|| u32::from_str_radix(digits, radix).ok())?
    };
    let found = program.areas.iter().enumerate().filter_map(|(at, area)| {
        let area_id = AreaId(u16::try_from(at).ok()?);
        Some((area.name.len(), Cell { area: area_id, index: number(area)? }))
    });
    found.max_by_key(|(length, _)| *length).map(|(_, cell)| cell)
}

/// A bit of a word, written after a point or as the last two of four or five digits (`00001`, `HR0107`, `IR0.01`).
pub(crate) fn bit_of_word(program: &Program, name: &str) -> Option<(Cell, u8)> {
    let name = name.trim().to_ascii_uppercase();
    let has_ir = area(program, "IR").is_some();
    let (word, bit) = match name.split_once('.') {
        Some(parts) => parts,
        None => {
            let digits = name.len() - name.trim_start_matches(|c: char| !c.is_ascii_digit()).len();
            // Only if the numbers of words are short enough to leave two digits.
            let few = has_ir && matches!(&name[..digits], "" | "IR" | "SR" | "HR" | "AR" | "LR");
            let is_bit = few && matches!(name.len() - digits, 4 | 5);
            if !is_bit {
                return None;
            }
            name.split_at(name.len() - 2)
        }
    };
    // One digit is hexadecimal, two are decimal.
    let radix = if bit.len() == 1 { 16 } else { 10 };
    let bit = u8::from_str_radix(bit, radix).ok().filter(|bit| *bit < 16)?;
    let begins_with_digit = word.starts_with(|c: char| c.is_ascii_digit());
    let word = match (begins_with_digit, word.strip_prefix("SR")) {
        (true, _) => format!("{}{word}", if has_ir { "IR" } else { "CIO" }),
        (_, Some(number)) => format!("IR{number}"),
        _ => word.to_owned(),
    };
    let cell = cell(program, &word)?;
    (program.area(cell.area).kind == AreaKind::Word).then_some((cell, bit))
}
