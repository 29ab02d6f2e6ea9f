//! Network refresh: its overhead, and what a program uses of a network for which no time is given.

use super::overhead::{OverheadTerm, charged};
use crate::table::{Evidence, Row, Table};
use scanbound_base::diagnostic::Diagnostic;
use scanbound_base::facts::Facts;
use scanbound_base::time::Picos;
use scanbound_ir::{
    AreaId, BitSource, BitTarget, Cell, Instruction, Program, Region, Role, Source, WordSource,
    WordTarget, Write,
};

/// What the program uses of a network: devices that the network refreshes, or a station.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct NetworkUse {
    /// The name of the network devices, such as `B`, or `X1000 and beyond`; or the station.
    pub what: String,
    /// The first instruction that uses the network, an index into `Program::instructions`.
    pub first: usize,
}

/// Whether the table or the user gives the time of network refresh, or says that there is no network.
pub fn is_priced(table: &Table, facts: &Facts) -> bool {
    facts.network.is_some() || table.terms("@network").next().is_some()
}

/// The overhead of network refresh: what the user states, otherwise the table's `@network` rows. Empty if neither gives
/// any, or the user says that there is no network.
pub fn terms(table: &Table, facts: &Facts) -> Result<Vec<OverheadTerm>, Vec<Diagnostic>> {
    let term = |row: &Row| -> Result<OverheadTerm, Vec<Diagnostic>> {
        let name = row.name.split_once(':').map_or("network refresh", |(_, name)| name);
        let time = charged(table, row, 1)?;
        let (evidence, why) = (row.evidence, row.source.clone());
        Ok(OverheadTerm { name: name.to_owned(), time, evidence, why })
    };
    match facts.network {
        None => table.terms("@network").map(term).collect(),
        Some(Picos::ZERO) => Ok(Vec::new()),
        Some(time) => {
            let row = Row {
                name: "@network".to_owned(),
                on: time,
                off: time,
                per_unit: Picos::ZERO,
                unit: String::new(),
                evidence: Evidence::Stated,
                source: format!("{time} as stated"),
                table: table.name.clone(),
                amends: true,
            };
            Ok(vec![term(&row)?])
        }
    }
}

/// What the program uses of networks: link devices of the dialect, points above the largest number the CPU can have,
/// and stations that instructions access.
pub fn used(program: &Program, table: &Table) -> Vec<NetworkUse> {
    let beyond =
        [(Role::Input, "input", &table.most_inputs), (Role::Output, "output", &table.most_outputs)];
    let beyond = beyond.into_iter().filter_map(|(role, side, most)| {
        let most = most.as_ref()?.points;
        let area = program.areas.iter().position(|area| area.role == role)?;
        let first = Cell { area: AreaId(u16::try_from(area).ok()?), index: most };
        let cells = Region::Range { first, count: u32::MAX - most };
        let what = format!(
            "{} and beyond (more than the {most} {side} points that the CPU can have)",
            program.cell_name(first)
        );
        Some((cells, what))
    });
    let cells: Vec<(Region, String)> = program.networks.iter().cloned().chain(beyond).collect();
    let mut firsts: Vec<Option<usize>> = vec![None; cells.len()];
    for (at, instruction) in program.instructions.iter().enumerate() {
        if firsts.iter().all(Option::is_some) {
            break;
        }
        each_region(instruction, &mut |region| {
            for ((cells, _), first) in cells.iter().zip(&mut firsts) {
                if first.is_none() && meet(*cells, region) {
                    *first = Some(at);
                }
            }
        });
    }
    let used = cells
        .into_iter()
        .zip(firsts)
        .filter_map(|((_, what), first)| Some(NetworkUse { what, first: first? }));
    let direct = program.first_direct_access.map(|first| {
        let text = program.instructions.get(first).map_or("", |one| &*one.text);
        NetworkUse { what: format!("the station that {text} accesses"), first }
    });
    used.chain(direct).collect()
}

/// A range with more cells than this has an unknown end: only its first cell counts as used.
const MAX_CELLS: u32 = 1 << 24;

/// The number of cells that a range of `count` cells certainly names: only 1 if its end is unknown.
pub fn known_length(count: u32) -> u32 {
    if count > MAX_CELLS { 1 } else { count }
}

/// Whether the region `named` by an instruction certainly has a cell in the region `cells` of a network. A `named`
/// region whose place within its area is unknown counts only if `cells` is the whole area.
fn meet(cells: Region, named: Region) -> bool {
    match (cells, named) {
        (Region::Area(area), Region::Area(other)) => area == other,
        (Region::Area(area), Region::Range { first, .. }) => area == first.area,
        (Region::Range { first: a, count: n }, Region::Range { first: b, count: m }) => {
            let end = |cell: Cell, count: u32| u64::from(cell.index) + u64::from(count);
            a.area == b.area
                && u64::from(a.index) < end(b, known_length(m))
                && u64::from(b.index) < end(a, n)
        }
        _ => false,
    }
}

/// Calls `each` with every region that an instruction reads, writes or names as an operand. Writes to an unknown place
/// are left out.
pub fn each_region(instruction: &Instruction, each: &mut impl FnMut(Region)) {
    let mut range = |first: Cell, count: u32| each(Region::Range { first, count });
    instruction.each_read(&mut |source| match source {
        Source::Bit(BitSource::Cell(cell) | BitSource::WordBit(cell, _))
        | Source::Word(WordSource::Cell(cell)) => range(cell, 1),
        Source::Word(WordSource::Bits { first, count }) => range(first, u32::from(count)),
        _ => {}
    });
    for effect in &instruction.effects {
        match &effect.write {
            Write::Bit(BitTarget::Cell(cell) | BitTarget::WordBit(cell, _), _) => range(*cell, 1),
            Write::Words(targets, _) => targets.iter().for_each(|target| match target {
                WordTarget::Cell(cell) => range(*cell, 1),
                WordTarget::Bits { first, count } => range(*first, u32::from(*count)),
                WordTarget::Discard => {}
            }),
            Write::Havoc(Region::Range { first, count }, _) => range(*first, *count),
            Write::Havoc(..) => {}
        }
    }
    for region in instruction.timing.iter().flat_map(|key| &key.accessed.regions) {
        each(*region);
    }
}
