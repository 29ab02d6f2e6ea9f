//! Warns of stated facts that have no effect on the program or contradict what it shows: perhaps typing errors.

use super::exclusive_relays::ExclusiveRelays;
use super::violations::{ExclusionViolation, RangeViolation, Violations, bits_of, writes_constant};
use scanbound_base::code::Code;
use scanbound_base::diagnostic::Diagnostic;
use scanbound_base::facts::{Facts, Part, StatedCall, normalized};
use scanbound_base::suggestion;
use scanbound_ir::{
    AreaId, AreaKind, BitSource, BitTarget, Cell, Logic, Program, Radix, Region, Role, Source,
    StartRange, WordSource, flow,
};
use scanbound_passes::values::{Trust, has_no_other_writer, is_unwritten_elsewhere};
use scanbound_timing::price::own_points;
use scanbound_timing::table::Table;
use std::collections::{BTreeMap, BTreeSet};

/// The largest number of facts that are reported.
const MAX_LISTED: usize = 100;

/// Refuses ranges of words if the front of the program's dialect resolves none.
///
/// # Errors
/// One error for each stated range, up to a limit.
pub fn know_words(program: &Program, facts: &Facts) -> Result<(), Vec<Diagnostic>> {
    let faults: Vec<Diagnostic> = facts
        .ranges
        .keys()
        .filter(|_| program.stated_ranges.is_empty())
        .take(MAX_LISTED)
        .map(|device| {
            let message = format!(
                "a range is stated for '{device}', but ranges are not used for programs of this dialect"
            );
            facts.fault(["ranges", device], Part::Key, Code::Fact, message, "remove it")
        })
        .collect();
    if faults.is_empty() { Ok(()) } else { Err(faults) }
}

/// The cells of the devices in a table of the facts file: those that others write, or those that only the program
/// writes.
///
/// # Errors
/// Devices that the machine does not have, or that have another name.
pub fn writers(
    program: &Program,
    facts: &Facts,
    table: &str,
    devices: &[String],
) -> Result<Vec<Region>, Vec<Diagnostic>> {
    let fault = |device: &String| {
        let names: Vec<&str> = program
            .areas
            .iter()
            .filter(|area| area.role != Role::Internal)
            .map(|area| area.name.trim())
            .collect();
        let message = format!(
            "'{device}' under [{table}] is not a device or a device range that scanbound knows by this name"
        );
        let help = format!(
            "write \"D100\" or \"D100-D199\", the lowest number first; the devices of this PLC are {}",
            names.join(", ")
        );
        facts.fault([table, "devices"], Part::Value, Code::Fact, message, &help)
    };
    let (mut regions, mut faults) = (Vec::new(), Vec::new());
    for device in devices {
        let (first, last) = device.split_once('-').unwrap_or((device, device));
        match (cell(program, first), cell(program, last)) {
            (Some(first), Some(last)) if first.area == last.area && first.index <= last.index => {
                regions.push(Region::Range { first, count: last.index - first.index + 1 });
            }
            // Some special registers have no cells.
            _ if table == "external" && is_special(program, device) => {}
            _ => faults.push(fault(device)),
        }
    }
    faults.truncate(MAX_LISTED);
    if faults.is_empty() { Ok(regions) } else { Err(faults) }
}

/// Whether a text names devices of a type that has special registers for the watchdog or the constant scan.
fn is_special(program: &Program, text: &str) -> bool {
    let control = &program.scan_control;
    let special = control.devices.iter().chain(&control.other_names);
    let kinds = special.filter_map(|name| numbered(name)).map(|(kind, ..)| kind);
    numbered(text).is_some_and(|(own, ..)| kinds.into_iter().any(|kind| kind == own))
}

/// A device or device range with decimal numbers: its letters, the first number and the last one. `None` if the text is
/// neither.
fn numbered(text: &str) -> Option<(String, u32, u32)> {
    let one = |text: &str| {
        let text = text.trim().to_ascii_uppercase();
        let letters = text.trim_end_matches(|c: char| c.is_ascii_digit()).to_owned();
        let number: u32 = text[letters.len()..].parse().ok()?;
        (!letters.is_empty()).then_some((letters, number))
    };
    let (first, last) = text.split_once('-').unwrap_or((text, text));
    let ((kind, first), (other, last)) = (one(first)?, one(last)?);
    (kind == other && first <= last).then_some((kind, first, last))
}

/// Refuses devices under [external] that set the watchdog time or the constant scan, unless the time is stated.
///
/// # Errors
/// One error for each of these devices.
pub fn know_scan_times(program: &Program, facts: &Facts) -> Result<(), Vec<Diagnostic>> {
    let [watchdog, constant, relay] = [0, 1, 2]
        .map(|at| [program.scan_control.devices[at], program.scan_control.other_names[at]]);
    let (of_watchdog, of_constant) = (facts.watchdog.is_some(), facts.constant_scan.is_some());
    let mut faults = Vec::new();
    for (names, is_stated, what, help) in [
        (watchdog, of_watchdog, "sets the watchdog time", "watchdog = \"500ms\""),
        (constant, of_constant, "sets the constant scan time", "constant = \"100ms\", or \"none\""),
        (
            relay,
            of_constant,
            "switches the constant scan on or off",
            "constant = \"100ms\", or \"none\"",
        ),
    ] {
        let is_in = |name: &str, text: &String| {
            let (special, stated) = (numbered(name), numbered(text));
            special.zip(stated).is_some_and(|((kind, number, _), (own, first, last))| {
                kind == own && (first..=last).contains(&number)
            })
        };
        let written = |name: &&str| facts.external.iter().any(|text| is_in(name, text));
        if let Some(special) = names.into_iter().find(written).filter(|_| !is_stated) {
            let message = format!(
                "[external] states that other writers than the program write {special}, which {what}"
            );
            let help = format!("state the time that they set ([scan] {help}), or remove {special}");
            let fact = ["external", "devices"];
            faults.push(facts.fault(fact, Part::Value, Code::Fact, message, &help));
        }
    }
    if faults.is_empty() { Ok(()) } else { Err(faults) }
}

/// Adds the stated sets of exclusive bits to a program's invariants, one invariant for each pair of a set: when a scan
/// starts, the two bits are not both on.
///
/// # Errors
/// Names that are not bits of the machine, or that occur in a set twice.
pub fn exclude(program: &mut Program, facts: &Facts) -> Result<(), Vec<Diagnostic>> {
    let (mut faults, mut stated) = (Vec::new(), Vec::new());
    let mut fault = |message: String| {
        let help = "write bits as the program does, such as X10, M100, or a bit of a word: D100.A";
        let fact = ["exclusive", "sets"];
        faults.push(facts.fault(fact, Part::Value, Code::Fact, message, help));
    };
    for set in &facts.exclusive {
        let mut bits: Vec<BitSource> = Vec::new();
        for name in set {
            match bit(program, name) {
                None => fault(format!(
                    "'{name}' under [exclusive] is not a bit that scanbound knows by this name"
                )),
                Some(bit) if bits.contains(&bit) => {
                    fault(format!("'{name}' occurs twice in a set of [exclusive]"));
                }
                Some(bit) => bits.push(bit),
            }
        }
        for (at, &one) in bits.iter().enumerate() {
            let others = bits[at + 1..].iter();
            stated.extend(others.map(|&other| [Logic::Bit(one), Logic::Bit(other)]));
        }
    }
    faults.truncate(MAX_LISTED);
    if !faults.is_empty() {
        return Err(faults);
    }
    let first = program.invariants.len();
    program.invariants.extend(stated.into_iter().map(|two| Logic::All(two.to_vec()).not()));
    program.stated_exclusions = first..program.invariants.len();
    Ok(())
}

/// A bit by its name as reports write it: a relay, or a bit of a word (`D100.A`, `0.05`). `None` if the program's
/// machine has no such bit.
pub fn bit(program: &Program, name: &str) -> Option<BitSource> {
    let is_bit = |cell: &Cell| program.area(cell.area).kind == AreaKind::Bit;
    if let Some(cell) = cell(program, name).filter(is_bit) {
        return Some(BitSource::Cell(cell));
    }
    let (word, digits) = name.trim().rsplit_once('.')?;
    // One digit is hexadecimal, two are decimal.
    let radix = if digits.len() == 1 { 16 } else { 10 };
    let bit = u8::from_str_radix(digits, radix).ok().filter(|bit| *bit < 16)?;
    let word = cell(program, word).filter(|cell| !is_bit(cell))?;
    Some(BitSource::WordBit(word, bit))
}

/// The cell of a device, as [`cell`] finds it. For a bit of a word: the cell of the word. `None` if there is none.
pub fn holder(program: &Program, name: &str) -> Option<Cell> {
    let of_word = || match bit(program, name)? {
        BitSource::WordBit(word, _) => Some(word),
        _ => None,
    };
    cell(program, name).or_else(of_word)
}

/// The devices, with each bit of a word replaced by its word: which writers write a word can be stated only for the
/// whole word.
pub fn whole<'a>(program: &Program, devices: impl Iterator<Item = &'a String>) -> BTreeSet<String> {
    let name = |cell| program.cell_name(cell);
    devices.map(|one| holder(program, one).map_or_else(|| one.clone(), name)).collect()
}

/// Warns of devices under [internal] for which the statement that only the program writes them has no effect.
#[must_use]
pub fn useless_internal(program: &Program, facts: &Facts, trust: Trust) -> Vec<Diagnostic> {
    let exclusive = ExclusiveRelays::of(program, trust);
    let fact = ["internal", "devices"];
    let warn = |message: String, help: &str| {
        facts.fault(fact, Part::Value, Code::UnusedFact, message, help).warning()
    };
    if trust == Trust::None && !facts.internal.is_empty() {
        let message = "[internal] has no effect with --trust none".to_owned();
        return vec![warn(
            message,
            "audit with --trust counts or --trust all, or remove [internal]",
        )];
    }
    let is_idle = |&(_, region): &(&String, &Region)| match *region {
        Region::Range { first, count } => {
            let is_known = |cell| {
                has_no_other_writer(program, cell)
                    || exclusive.is_output(cell) && is_unwritten_elsewhere(program, cell)
            };
            !(0..count).any(|n| is_known(Cell { index: first.index + n, ..first }))
        }
        _ => false,
    };
    let idle = facts.internal.iter().zip(&program.internal).filter(is_idle).take(MAX_LISTED);
    idle.map(|(device, _)| {
        let message = format!(
            "{device} under [internal] has no effect: it is an input, is not cleared at power-up, is also under [external], or the CPU, a module or an interrupt may write it"
        );
        warn(message, "remove it")
    })
    .collect()
}

/// The cell that a report calls by this name. `None` if there is none.
pub fn cell(program: &Program, name: &str) -> Option<Cell> {
    let name = name.trim().to_ascii_uppercase();
    let known = program.areas.iter().zip(0..).filter_map(|(area, at)| {
        let digits = name.strip_prefix(area.name.as_str())?;
        let radix = match area.radix {
            Radix::Decimal => 10,
            Radix::Hexadecimal => 16,
            Radix::Octal => 8,
        };
        let index = u32::from_str_radix(digits, radix).ok()?;
        (area.role != Role::Internal).then_some(Cell { area: AreaId(at), index })
    });
    // The area with the longest matching name: S1 is not SM.
    known.max_by_key(|cell| program.area(cell.area).name.len())
}

/// Warns of routines under [calls] whose code is given, or that are not called.
#[must_use]
pub fn unused_calls(program: &Program, facts: &Facts) -> Vec<Diagnostic> {
    let lacked: BTreeSet<&str> =
        program.missing_routines.iter().map(|one| one.name.as_str()).collect();
    let unused = facts.calls.iter().filter(|(name, _)| !lacked.contains(name.as_str()));
    let warning = |(plain_name, call): (&String, &StatedCall)| {
        let StatedCall { name, .. } = call;
        let (message, help) = match label(program, plain_name) {
            Some(place) => (
                format!(
                    "the statement about {name} under [calls] is not used: the program contains the routine, in {place}"
                ),
                "remove the line from the facts file: the audit uses the routine's code",
            ),
            None => (
                format!(
                    "the statement about {name} under [calls] is not used: no instruction calls {name}"
                ),
                "write the name as in the call instruction, or remove the line if the routine is not called",
            ),
        };
        facts.fault(["calls", name], Part::Key, Code::UnusedFact, message, help).warning()
    };
    unused.take(MAX_LISTED).map(warning).collect()
}

/// The file and line at which a routine of this name begins. `None` if no label has this name.
fn label(program: &Program, name: &str) -> Option<String> {
    let (of, name) = name.rsplit_once(':').map_or((None, name), |(of, name)| (Some(of), name));
    let found = program.instructions.iter().find(|one| {
        let file = &one.place.of(&program.files).name;
        let stem = file.rsplit(['/', '\\']).next().unwrap_or_default();
        let stem = stem.rsplit_once('.').map_or(stem, |(stem, _)| stem);
        normalized(&one.text) == name && of.is_none_or(|of| stem.eq_ignore_ascii_case(of))
    })?;
    Some(format!("{}:{}", found.place.of(&program.files).name, found.place.line))
}

/// Warns of ranges of words that the program does not use, and of fewer points than it uses or more than the CPU can
/// address.
#[must_use]
pub fn questionable(program: &Program, table: &Table, facts: &Facts) -> Vec<Diagnostic> {
    let mut warnings = Vec::new();
    if !program.stated_ranges.is_empty() {
        let named = NamedCells::of(program);
        let unknown = program
            .stated_ranges
            .iter()
            .filter(|range| !range.cells.iter().any(|&cell| named.holds(cell)));
        let keys: BTreeMap<String, &String> =
            facts.ranges.keys().map(|key| (normalized(key), key)).collect();
        let mut dropped = 0;
        for range in unknown {
            if warnings.len() >= MAX_LISTED {
                dropped += 1;
                continue;
            }
            let word = program.cell_name(range.cells[0]);
            let near = suggestion::nearest(&word, named.words(program));
            let near = near.map_or(String::new(), |near| format!(": did you mean {near}?"));
            let message =
                format!("a range is stated for {word}, which the program does not use{near}");
            let help = "write the word as in the program, or remove the range";
            let fact = ["ranges", keys.get(&normalized(&word)).map_or("", |key| key.as_str())];
            warnings.push(facts.fault(fact, Part::Key, Code::UnusedFact, message, help).warning());
        }
        if dropped > 0 {
            let message =
                format!("{dropped} more ranges are stated for words that the program does not use");
            warnings.push(Diagnostic::file(Code::UnusedFact, "", message, "").warning());
        }
    }
    let sides = [
        ("input", Role::Input, facts.inputs, &table.most_inputs),
        ("output", Role::Output, facts.outputs, &table.most_outputs),
    ];
    let mut odd_points = |side: &str, message: String, help: &str| {
        let fact = ["io", &format!("{side}s")];
        warnings.push(facts.fault(fact, Part::Value, Code::UnusedFact, message, help).warning());
    };
    for (side, role, stated, most) in sides {
        let Some(stated) = stated else { continue };
        let (seen, why) = own_points(program, side, role, most.as_ref());
        if stated < seen {
            let message = format!("{stated} {side} points are stated, but the program shows {why}");
            let help = "state the number of all points that the CPU refreshes";
            odd_points(side, message, help);
        }
        if let Some(most) = most.as_ref().map(|most| most.points).filter(|&most| stated > most) {
            let message =
                format!("{stated} {side} points are stated, but the CPU can address only {most}");
            let help = "count only the points of modules on the CPU's own bases; state network refresh under [network]";
            odd_points(side, message, help);
        }
    }
    warnings
}

/// Reports facts that are stated for the start of a scan, but that a real run violates: as warnings, if the fact may
/// still be right.
///
/// # Errors
/// If the program writes a constant outside of a range, or a run from power-up violates the fact whatever comes from
/// outside: then the fact is wrong.
pub fn violations(
    program: &Program,
    facts: &Facts,
    found: &Violations,
) -> Result<Vec<Diagnostic>, Vec<Diagnostic>> {
    let keys: BTreeMap<String, &String> =
        facts.ranges.keys().map(|key| (normalized(key), key)).collect();
    let (mut broken, mut doubtful) = (Vec::new(), Vec::new());
    let wrote = |by: usize| {
        let at = &program.instructions[by];
        let file = &at.place.of(&program.files).name;
        format!("`{}` ({file}:{})", at.text, at.place.line)
    };
    let from_power_up =
        |scan: usize| format!("in scan {scan} after power-up, whatever values the inputs have");
    for (&range, &RangeViolation { value, by, scan }) in &found.ranges {
        let word = program.cell_name(program.stated_ranges[range].cells[0]);
        // A range that was derived, not stated, was proved.
        let Some(key) = keys.get(&normalized(&word)) else { continue };
        let (fact, wrote) = (["ranges", key.as_str()], wrote(by));
        if writes_constant(program, by) || scan.is_some() {
            let when = scan.map_or(String::new(), |scan| format!(", {}", from_power_up(scan)));
            let message = format!(
                "the program violates this fact: {wrote} writes {value} to {word}, and {word} has this value when the scan ends{when}"
            );
            let help = "state a range that contains this value, or remove the fact";
            broken.push(facts.fault(fact, Part::Value, Code::BrokenFact, message, help));
        } else {
            let message = format!(
                "{wrote} may leave {value} in {word} at the end of a scan: the known facts do not exclude this value, which would violate the stated range"
            );
            let help = "check the range, or state what prevents this value, such as the ranges of the words that it is computed from";
            doubtful
                .push(facts.fault(fact, Part::Value, Code::BrokenFact, message, help).warning());
        }
    }
    for (&pair, ExclusionViolation { by, scan }) in found.exclusions.iter().take(MAX_LISTED) {
        let names: Vec<String> = bits_of(&program.invariants[pair])
            .iter()
            .filter_map(|bit| bit_name(program, bit))
            .collect();
        let (names, by): (String, Vec<String>) =
            (names.join(" and "), by.iter().map(|&by| wrote(by)).collect());
        let (by, fact) = (by.join(" and "), ["exclusive", "sets"]);
        if let Some(scan) = scan {
            let leave = if by.contains(" and ") { "leave" } else { "leaves" };
            let message = format!(
                "the program violates this fact: {by} {leave} {names} both on when the scan ends, {}",
                from_power_up(*scan)
            );
            let help = "both bits can be on when a scan starts: remove one of them from the set";
            broken.push(facts.fault(fact, Part::Value, Code::BrokenFact, message, help));
        } else {
            let message = format!(
                "{by} may leave {names} both on at the end of a scan: the known facts do not exclude that both are on, which would violate the stated set"
            );
            let help = "check the set, or state what prevents this, such as inputs that are never on together";
            doubtful
                .push(facts.fault(fact, Part::Value, Code::BrokenFact, message, help).warning());
        }
    }
    if broken.is_empty() { Ok(doubtful) } else { Err(broken) }
}

fn bit_name(program: &Program, bit: &BitSource) -> Option<String> {
    match *bit {
        BitSource::Cell(cell) => Some(program.bit_name(BitTarget::Cell(cell))),
        BitSource::WordBit(cell, bit) => Some(program.bit_name(BitTarget::WordBit(cell, bit))),
        BitSource::Const(_) | BitSource::Free(_) => None,
    }
}

/// Removes the ranges of words that the program does not use and that share no word with a range of used words: they
/// have no effect.
pub fn forget_unnamed(program: &mut Program) {
    let named = NamedCells::of(program);
    let mut cells_in_use: BTreeSet<Cell> = BTreeSet::new();
    let mut open = std::mem::take(&mut program.stated_ranges);
    loop {
        let (say, rest): (Vec<StartRange>, Vec<StartRange>) = open.into_iter().partition(|range| {
            range.cells.iter().any(|&cell| named.holds(cell) || cells_in_use.contains(&cell))
        });
        open = rest;
        if say.is_empty() {
            break;
        }
        cells_in_use.extend(say.iter().flat_map(|range| range.cells.iter().copied()));
        program.stated_ranges.extend(say);
    }
}

/// The cells that instructions read, write, or have among their operands: those that the program uses.
struct NamedCells {
    cells: BTreeSet<Cell>,
    /// Ranges of cells by their first cell. Each value is the largest end of this range and all ranges before it.
    ranges: BTreeMap<Cell, u64>,
    areas: BTreeSet<AreaId>,
    everything: bool,
}

impl NamedCells {
    fn of(program: &Program) -> NamedCells {
        let mut named = NamedCells {
            cells: BTreeSet::new(),
            ranges: BTreeMap::new(),
            areas: BTreeSet::new(),
            everything: false,
        };
        for (at, instruction) in program.instructions.iter().enumerate() {
            instruction.each_read(&mut |source| match source {
                Source::Bit(BitSource::Cell(cell) | BitSource::WordBit(cell, _))
                | Source::Word(WordSource::Cell(cell)) => {
                    named.cells.insert(cell);
                }
                _ => {}
            });
            let operands = instruction.timing.iter().flat_map(|key| &key.accessed.regions);
            for &region in flow::written(program, at).iter().chain(operands) {
                named.region(region);
            }
        }
        named.reach();
        named
    }

    /// Sets the end of each range to the largest end of this range and all ranges before it.
    fn reach(&mut self) {
        let mut reach: Option<(AreaId, u64)> = None;
        for (first, end) in &mut self.ranges {
            let before = reach.filter(|(area, _)| *area == first.area).map_or(0, |(_, end)| end);
            *end = before.max(*end);
            reach = Some((first.area, *end));
        }
    }

    fn region(&mut self, region: Region) {
        match region {
            Region::Range { first, count } => {
                let end = u64::from(first.index) + u64::from(count);
                let known = self.ranges.entry(first).or_insert(end);
                *known = end.max(*known);
            }
            Region::Area(area) => {
                self.areas.insert(area);
            }
            Region::Everything => self.everything = true,
        }
    }

    /// The names of the words that instructions use individually, or as the first of a block.
    fn words<'a>(&'a self, program: &'a Program) -> impl Iterator<Item = String> + 'a {
        let is_word = |cell: &&Cell| {
            let area = program.area(cell.area);
            area.kind != AreaKind::Bit && area.role != Role::Internal
        };
        let all = self.cells.iter().chain(self.ranges.keys());
        all.filter(is_word).map(|&cell| program.cell_name(cell))
    }

    fn holds(&self, cell: Cell) -> bool {
        let before = self.ranges.range(..=cell).next_back();
        let ranges = before
            .is_some_and(|(first, &end)| first.area == cell.area && u64::from(cell.index) < end);
        self.everything || self.areas.contains(&cell.area) || self.cells.contains(&cell) || ranges
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use scanbound_ir::{ChoiceId, Effect, Step, When, Write, testing};

    #[test]
    fn ranges_are_kept_that_hang_together_with_a_named_word() {
        let cell = |index| Cell { area: AreaId(0), index };
        let mut program = Program::default();
        let range = |first: u32, count: u32| StartRange {
            cells: (first..first + count).map(cell).collect(),
            low: 0,
            high: 9,
            values: Vec::new(),
        };
        program.stated_ranges = vec![range(0, 1), range(0, 2), range(1, 2), range(7, 1)];
        let write = Write::Havoc(Region::Range { first: cell(2), count: 1 }, ChoiceId(0));
        let effects = vec![Effect { when: When::Always, write }];
        program.instructions.push(testing::with_effects(Step::Nothing, effects));
        forget_unnamed(&mut program);
        let mut firsts: Vec<u32> =
            program.stated_ranges.iter().map(|one| one.cells[0].index).collect();
        firsts.sort_unstable();
        assert_eq!(firsts, [0, 0, 1]);
    }

    #[test]
    fn a_cell_is_named_by_any_range_that_reaches_it() {
        let cell = |index| Cell { area: AreaId(0), index };
        let mut named = NamedCells::of(&Program::default());
        named.region(Region::Range { first: cell(10), count: 100 });
        named.region(Region::Range { first: cell(20), count: 5 });
        named.region(Region::Range { first: Cell { area: AreaId(1), index: 0 }, count: 1 });
        named.reach();
        for (index, holds) in [(9, false), (10, true), (24, true), (109, true), (110, false)] {
            assert_eq!(named.holds(cell(index)), holds, "{index}");
        }
        assert!(!named.holds(Cell { area: AreaId(1), index: 1 }));
    }
}
