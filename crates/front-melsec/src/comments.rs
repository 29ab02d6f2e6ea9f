//! Reads device comments (COMMENT.csv): descriptive names of devices.

use std::collections::BTreeMap;

use ::csv::{ReaderBuilder, StringRecord};

/// Headings of the device column, without blanks and in lower case.
const DEVICE_HEADS: [&str; 12] = [
    "devicename",
    "device",
    "devicenumber",
    "デバイス名",
    "デバイス",
    "软元件名",
    "软元件",
    "軟元件名",
    "元件名称",
    "디바이스명",
    "디바이스이름",
    "디바이스",
];
/// Texts in the heading of a comment column.
const COMMENT_HEADS: [&str; 6] = ["comment", "コメント", "注释", "註解", "코멘트", "주석"];
/// Words in the headings by which the code page is recognised.
pub(super) const MARKS: [&str; 5] = ["コメント", "注释", "軟元件", "코멘트", "주석"];
/// The number of rows at the beginning in which the headings must be.
const HEADING_ROWS: usize = 4;
/// The number of data rows that are examined if the headings are in an unknown language.
const LOOKED_AT: usize = 6;

/// How a comment file is laid out: the delimiter, the number of records before the first comment, and the columns.
#[derive(Debug, Clone, PartialEq, Eq)]
struct Layout {
    delimiter: u8,
    heading: usize,
    /// The columns with comments. Of each row, the first one that is not empty is used.
    columns: Vec<usize>,
}

/// Whether the beginning of a file looks like a file of device comments.
pub(super) fn sniff(beginning: &str) -> bool {
    layout(beginning).is_some()
}

fn layout(beginning: &str) -> Option<Layout> {
    let end = beginning.char_indices().nth(8192).map_or(beginning.len(), |(at, _)| at);
    [b'\t', b',', b';'].into_iter().find_map(|delimiter| {
        let records: Vec<StringRecord> = reader(&beginning[..end], delimiter)
            .into_records()
            .take(HEADING_ROWS + LOOKED_AT)
            .map_while(Result::ok)
            .collect();
        let heading = &records[..records.len().min(HEADING_ROWS)];
        let known =
            heading.iter().enumerate().find_map(|(index, record)| heads(index, record, delimiter));
        known.or_else(|| shape(&records, delimiter))
    })
}

/// The layout of a file with headings in an unknown language. Each examined data row must begin with a device and have
/// a second cell. `None` if this does not hold.
fn shape(records: &[StringRecord], delimiter: u8) -> Option<Layout> {
    let is_row = |record: &StringRecord| record.len() >= 2 && is_device(&record[0]);
    let heading = records.iter().take(HEADING_ROWS + 1).position(is_row)?;
    let columns = records[heading].len();
    let heads = records.get(heading.checked_sub(1)?)?;
    let named = heads.len() == columns && !heads[0].contains(|c: char| c.is_ascii_digit());
    (named && records[heading..].iter().all(is_row)).then(|| Layout {
        delimiter,
        heading,
        columns: (1..columns).collect(),
    })
}

/// Whether a word looks like a device such as `X1F`, `ZR100` or `D0.5`: one or two capital letters and a number.
fn is_device(word: &str) -> bool {
    let number = word.trim_start_matches(|c: char| c.is_ascii_uppercase());
    (1..=2).contains(&(word.len() - number.len()))
        && number.starts_with(|c: char| c.is_ascii_digit())
        && number.chars().all(|c| c.is_ascii_hexdigit() || c == '.')
}

fn heads(index: usize, record: &StringRecord, delimiter: u8) -> Option<Layout> {
    let plain: Vec<String> = record
        .iter()
        .map(|head| {
            head.chars().filter(|c| !c.is_whitespace()).flat_map(char::to_lowercase).collect()
        })
        .collect();
    if !DEVICE_HEADS.contains(&plain.first()?.as_str()) {
        return None;
    }
    let columns: Vec<usize> = (1..plain.len())
        .filter(|&column| COMMENT_HEADS.iter().any(|head| plain[column].contains(head)))
        .collect();
    (!columns.is_empty()).then_some(Layout { delimiter, heading: index + 1, columns })
}

fn reader(text: &str, delimiter: u8) -> ::csv::Reader<&[u8]> {
    ReaderBuilder::new()
        .delimiter(delimiter)
        .has_headers(false)
        .flexible(true)
        .from_reader(text.as_bytes())
}

/// Adds a file's comments to those of the project. A device that already has a comment keeps it.
pub(super) fn read(text: &str, comments: &mut BTreeMap<String, String>) {
    let Some(layout) = layout(text) else { return };
    for record in reader(text, layout.delimiter).into_records().skip(layout.heading) {
        let Ok(record) = record else { continue };
        let device = record.get(0).unwrap_or_default().trim();
        let comment = layout
            .columns
            .iter()
            .filter_map(|&column| record.get(column))
            .map(|text| text.split_whitespace().collect::<Vec<_>>().join(" "))
            .find(|text| !text.is_empty());
        if let (false, Some(comment)) = (device.is_empty(), comment) {
            comments.entry(device.to_owned()).or_insert(comment);
        }
    }
}
