//! The heads of oscilloscopes' CSV files, which are several rows: what makers write before the samples.
//!
//! - Keysight: `x-axis,1,2` and `second,Volt,Volt`.
//! - Rigol: `X,CH1,CH2,Start,Increment` and `Sequence,Volt,Volt,-6e-04,1e-06`: the rows count samples.
//! - Siglent: settings from `Record Length` on, the channels behind `Source`, then `Second,Volt` or `Second,Value`.
//! - Tektronix: settings from `Model` on, then `TIME,CH1`; on older ones settings stand left of the samples in the
//!   first rows, from `Record Length` on.

use scanbound_base::column::Unit;

/// The heading is within this many first rows.
pub(super) const ROWS: usize = 64;

/// A heading of several rows.
#[derive(Debug, PartialEq, Eq)]
pub(super) struct Heading {
    /// The columns' names. That of the time includes its unit.
    pub(super) heads: Vec<String>,
    /// The number of rows before the first sample.
    pub(super) rows: usize,
    /// If the first column counts samples: the time of the first sample and the time between two, in picoseconds.
    pub(super) counted: Option<(i128, i128)>,
}

/// The heading of a known maker's file, from its first rows.
pub(super) fn read(rows: &[Vec<String>]) -> Option<Heading> {
    let first = rows.first()?;
    let begins = |row: &[String], word: &str| row.first().is_some_and(|cell| same(cell, word));
    let seconds = Unit::from_name("s")?;
    let number = |cell: &String| seconds.read(cell);
    let second = rows.get(1).map_or(&[][..], Vec::as_slice);
    if begins(first, "x-axis") && begins(second, "second") {
        return Some(Heading { heads: timed(first, "s"), rows: 2, counted: None });
    }
    if begins(first, "X") && begins(second, "Sequence") {
        let column = |word: &str| first.iter().position(|cell| same(cell, word));
        let start = second.get(column("Start")?).and_then(number)?;
        let step = second.get(column("Increment")?).and_then(number)?;
        let counted = Some((start, step)).filter(|_| step > 0);
        return counted.map(|_| Heading { heads: first.clone(), rows: 2, counted });
    }
    if begins(first, "Record Length") && first.len() > 4 && number(&first[3]).is_some() {
        let source = rows.iter().find(|row| begins(row, "Source")).and_then(|row| row.get(1));
        let mut heads = vec![String::new(); first.len()];
        heads[3] = "Time [s]".to_owned();
        heads[4] = source.map_or("CH1", String::as_str).to_owned();
        return Some(Heading { heads, rows: 0, counted: None });
    }
    if begins(first, "Record Length") {
        let at = rows.iter().position(|row| begins(row, "Second"))?;
        let source = rows[..at].iter().rev().find(|row| begins(row, "Source"));
        let heads = source.filter(|row| row.len() >= rows[at].len()).unwrap_or(&rows[at]);
        return Some(Heading {
            heads: timed(&heads[..rows[at].len()], "s"),
            rows: at + 1,
            counted: None,
        });
    }
    if begins(first, "Model") {
        let at = rows.iter().position(|row| begins(row, "TIME"))?;
        let unit = rows[..at].iter().find(|row| begins(row, "Horizontal Units"));
        let unit = unit.and_then(|row| row.get(1)).map_or("s", String::as_str);
        return Some(Heading { heads: timed(&rows[at], unit), rows: at + 1, counted: None });
    }
    None
}

/// The headings, with the first one made that of the time.
fn timed(heads: &[String], unit: &str) -> Vec<String> {
    let mut heads = heads.to_vec();
    heads[0] = format!("Time [{unit}]");
    heads
}

fn same(cell: &str, word: &str) -> bool {
    cell.trim().eq_ignore_ascii_case(word)
}
