//! What switches in a project change of instructions' meaning: special relays that it may set, programs that it stops.

use crate::front::melsec::memory::{Family, Kind};
use crate::front::melsec::operand::{Device, Operand, Place, parse, upper};
use crate::front::melsec::source::{RawInstruction, RawProject};

/// What the project's instructions may switch.
pub(super) struct Quirks {
    /// The block of the file register, so that `R` may be any `ZR`.
    pub switches_file_register: bool,
    /// FX, FX5: special relays that change what moves do: M8024 turns BMOV round, M8160 lets XCH swap bytes.
    pub turns_moves: bool,
    /// FX: with M8023 on, sums and differences of double words are of real numbers.
    pub sums_reals: bool,
    /// Q, L: with SM702 on, searches take their blocks for sorted ones.
    pub searches_by_halves: bool,
    /// FX, FX5: M8040, or IST, may keep a step ladder from moving on.
    pub states_may_stay: bool,
    /// FX: with M8164 on, FROM and TO move as many words as D8164 says.
    pub counts_elsewhere: bool,
    /// Files whose programs are called or stopped by their names.
    pub may_rest: Vec<bool>,
}

impl Quirks {
    /// Those of a project.
    pub fn of(project: &RawProject, family: Family) -> Quirks {
        let has = |names: &[&str]| has(project, names);
        let touches = |relays: &[u32]| touches(project, family, relays);
        let is_fx = matches!(family, Family::Fx | Family::Fx5);
        Quirks {
            switches_file_register: has(&["RSET", "RSETP", "QDRSET", "QDRSETP"]),
            turns_moves: is_fx && touches(&[8024, 8160]),
            sums_reals: family == Family::Fx && touches(&[8023]),
            searches_by_halves: touches(&[702]),
            states_may_stay: is_fx && (touches(&[8040]) || has(&["IST"])),
            counts_elsewhere: family == Family::Fx && touches(&[8164]),
            may_rest: may_rest(project),
        }
    }
}

/// Whether the program names one of these special relays of the FX (`M8023`) or FX5 (`SM8023`), alone, among digits or
/// the devices that ZRST clears, or may by an index.
fn touches(project: &RawProject, family: Family, relays: &[u32]) -> bool {
    let instructions = project.files.iter().flat_map(|file| &file.instructions);
    let touched = |first: u32, last: u32| relays.iter().any(|relay| (first..=last).contains(relay));
    let in_name = |text: &String| match parse(text, family) {
        Ok(Operand::Device(device)) if matches!(device.name, "M" | "SM") => match device.place {
            Place::At(_, relay) => touched(relay, relay),
            Place::Digits(_, first, digits) => {
                // Blocks begin with them.
                touched(first, first + 4 * u32::from(digits) - 1)
                    || (first >= FIRST_SPECIAL && touched(first, u32::MAX))
            }
            Place::Indexed(Kind::VolatileBit, _) | Place::IndexedDigits(Kind::VolatileBit, _) => {
                true
            }
            _ => false,
        },
        _ => false,
    };
    let number = |text: &String| match parse(text, family) {
        Ok(Operand::Device(Device { place: Place::At(_, at), .. })) => Some(at),
        _ => None,
    };
    let mut instructions = instructions;
    instructions.any(|raw| {
        let between = match &raw.operands[..] {
            [first, last] if upper(&raw.mnemonic).starts_with("ZRST") => {
                number(first).zip(number(last)).is_some_and(|(from, to)| touched(from, to))
            }
            _ => false,
        };
        between || raw.operands.iter().any(in_name)
    })
}

/// Whether the program has one of these instructions.
fn has(project: &RawProject, names: &[&str]) -> bool {
    let mut instructions = project.files.iter().flat_map(|file| &file.instructions);
    let is_one =
        |raw: &RawInstruction| names.iter().any(|name| raw.mnemonic.eq_ignore_ascii_case(name));
    instructions.any(is_one)
}

/// From here on the FX's relays are special ones.
const FIRST_SPECIAL: u32 = 8000;

/// Which files' programs need not run in every scan: those that are called by name are commonly on standby, and
/// those that are stopped rest. An operand that is no name may be any of them.
fn may_rest(project: &RawProject) -> Vec<bool> {
    let mut rests = vec![false; project.files.len()];
    for raw in project.files.iter().flat_map(|file| &file.instructions) {
        let mnemonic = upper(&raw.mnemonic);
        let names = ["ECALL", "EFCALL", "PSTOP", "POFF", "PSCAN", "PLOW"];
        let is_named =
            |name: &&str| mnemonic.strip_prefix(*name).is_some_and(|p| ["", "P"].contains(&p));
        if !names.iter().any(is_named) {
            continue;
        }
        let text = raw.operands.first().map_or("", String::as_str).trim_matches('"');
        let stem = text.split('.').next().unwrap_or(text);
        let named = project.files.iter().position(|f| f.program.eq_ignore_ascii_case(stem));
        match named {
            Some(file) => rests[file] = true,
            None => rests.fill(true),
        }
    }
    rests
}
