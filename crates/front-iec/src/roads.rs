//! Which road a project takes while there are two: the one by names, or the one by the typed tree. Only builds for tests
//! look at the environment: `SCANBOUND_IEC_ROAD=tree` takes the new one, and `both` lowers on both, compares the programs and
//! appends the outcome to the file that `SCANBOUND_IEC_LOG` names.

use super::{decode as names, lower};
use scanbound_base::diagnostic::Diagnostic;
use scanbound_iec::Project;
use scanbound_iec_tree::resolve::NOT_YET;
use scanbound_ir::{AreaId, Cell, Program, Region};
use std::collections::BTreeMap;
use std::io::Write as _;

/// What a project means.
pub(super) fn decode(
    project: &Project,
    dialect: &str,
    charts: names::Options,
    asked: &scanbound_front::Options<'_>,
) -> Result<Program, Vec<Diagnostic>> {
    let road = match cfg!(debug_assertions) {
        true => std::env::var("SCANBOUND_IEC_ROAD").unwrap_or_default(),
        false => String::new(),
    };
    if road.is_empty() {
        return names::decode(project, dialect, charts, asked);
    }
    let tree = lower::decode(project, dialect, charts, asked);
    if road == "tree" {
        return tree;
    }
    let found = names::decode(project, dialect, charts, asked);
    log(&outcome(&found, &tree), project);
    found
}

fn log(outcome: &str, project: &Project) {
    let Ok(path) = std::env::var("SCANBOUND_IEC_LOG") else { return };
    let first = project.files.first().map_or("", String::as_str);
    let unit = project.pous.first().map_or("", |pou| &pou.name);
    let thread = std::thread::current();
    let name = thread.name().unwrap_or_default();
    let file = std::fs::OpenOptions::new().create(true).append(true).open(path);
    if let Ok(mut file) = file {
        _ = writeln!(file, "{outcome}\t{name}\t{first}\t{unit}");
    }
}

type Lowered = Result<Program, Vec<Diagnostic>>;

/// How the programs of both roads compare.
fn outcome(names: &Lowered, tree: &Lowered) -> String {
    let first =
        |faults: &[Diagnostic]| faults.first().map_or(String::new(), |one| one.message.clone());
    let is_not_yet = |faults: &[Diagnostic]| faults.iter().any(|one| one.message.contains(NOT_YET));
    match (names, tree) {
        (_, Err(faults)) if is_not_yet(faults) => {
            let mut of = faults.iter().filter(|one| one.message.contains(NOT_YET));
            let of = of.next().map_or("", |one| one.message.as_str());
            let what = of.split_once(NOT_YET).map_or("", |(_, what)| what);
            format!("not yet{what}")
        }
        (Err(one), Err(two)) if first(one) == first(two) => "same fault".to_owned(),
        (Err(one), Err(two)) => format!("other fault: {} / {}", first(one), first(two)),
        (Ok(_), Err(faults)) => format!("refused: {}", first(faults)),
        (Err(faults), Ok(_)) => format!("accepted: {}", first(faults)),
        (Ok(one), Ok(two)) => {
            let (one, two) = (Shown::of(one), Shown::of(two));
            let mut pairs = one.lines.iter().zip(&two.lines);
            match pairs.position(|(one, two)| one != two) {
                Some(at) => format!("differs at {at}: {} / {}", one.lines[at], two.lines[at]),
                None if one.lines.len() != two.lines.len() => {
                    format!("differs in length: {} / {}", one.lines.len(), two.lines.len())
                }
                None => "same".to_owned(),
            }
        }
    }
}

/// A program as lines in which nothing depends on where variables lie and how values between are numbered.
struct Shown<'p> {
    program: &'p Program,
    lines: Vec<String>,
    between: BTreeMap<Cell, usize>,
    choices: BTreeMap<u32, usize>,
    /// Choices whose meanings are to be shown.
    open: Vec<u32>,
}

impl<'p> Shown<'p> {
    fn of(program: &'p Program) -> Shown<'p> {
        let mut shown = Shown {
            program,
            lines: Vec::new(),
            between: BTreeMap::new(),
            choices: BTreeMap::new(),
            open: Vec::new(),
        };
        for (at, one) in program.instructions.iter().enumerate() {
            let error = program.errors.get(&at);
            let text = format!(
                "{}:{} {} {:?} {:?} {:?} {error:?}",
                one.place.file, one.place.line, one.text, one.timing, one.effects, one.step
            );
            shown.push(&text);
        }
        let start = &program.power_up;
        for (what, regions) in
            [("inputs", &start.inputs), ("latched", &start.latched), ("cleared", &start.cleared)]
        {
            let mut cells: Vec<String> = Vec::new();
            for region in regions {
                if let Region::Range { first, count } = region {
                    cells.extend(
                        (0..(*count).min(20_000)).map(|at| program.cell_name(first.plus(at))),
                    );
                }
            }
            cells.sort();
            cells.dedup();
            shown.lines.push(format!("{what}: {}", cells.join(" ")));
        }
        let mut values: Vec<String> = { &start.values }
            .iter()
            .map(|(cell, word)| format!("{} = {word}", program.cell_name(*cell)))
            .collect();
        values.sort();
        shown.lines.push(format!("values: {}", values.join(" ")));
        let mut told: Vec<String> = program
            .approximations
            .iter()
            .map(|one| format!("{}: {:?}", one.instruction, one))
            .collect();
        told.sort();
        shown.lines.push(format!("approximated: {}", told.join("; ")));
        shown
    }

    /// Takes in a text in which cells and choices stand as they are shown for developers.
    fn push(&mut self, text: &str) {
        let mut found = String::new();
        let mut rest = text;
        while let Some(at) =
            rest.find("Cell { area: AreaId(").into_iter().chain(rest.find("ChoiceId(")).min()
        {
            found += &rest[..at];
            rest = &rest[at..];
            if let Some(behind) = rest.strip_prefix("ChoiceId(") {
                let end = behind.find(')').unwrap_or(0);
                let number: u32 = behind[..end].parse().unwrap_or(0);
                let next = self.choices.len();
                let known = *self.choices.entry(number).or_insert_with(|| {
                    self.open.push(number);
                    next
                });
                found += &format!("choice {known}");
                rest = &behind[end + 1..];
                continue;
            }
            let end = rest.find('}').unwrap_or(0);
            let digits: Vec<u32> = rest[..end]
                .split(|c: char| !c.is_ascii_digit())
                .filter_map(|part| part.parse().ok())
                .collect();
            rest = &rest[end + 1..];
            let [area, index] = digits[..] else { continue };
            let cell = Cell { area: AreaId(u16::try_from(area).unwrap_or(0)), index };
            found += &match area {
                4 | 5 => {
                    let next = self.between.len();
                    format!("between {}", self.between.entry(cell).or_insert(next))
                }
                _ => self.program.cell_name(cell),
            };
        }
        found += rest;
        self.lines.push(found);
        for number in std::mem::take(&mut self.open) {
            let choice = scanbound_ir::ChoiceId(number);
            let own = (
                self.program.kinds.get(&choice),
                self.program.followed.contains(&choice),
                self.program.statements.unsettled.contains(&choice),
                self.program.timekeeping.uncounted.contains(&choice),
            );
            let text = format!("meaning {own:?}");
            self.push(&text);
        }
    }
}
