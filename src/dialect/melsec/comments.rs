//! Reads device comments (COMMENT.csv): the names by which people know devices.

use std::collections::BTreeMap;

use ::csv::{ReaderBuilder, StringRecord};

/// Heads of the device column, without blanks and in lower case.
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
/// What the head of a comment column contains.
const COMMENT_HEADS: [&str; 6] = ["comment", "コメント", "注释", "註解", "코멘트", "주석"];
/// Words of the heads that only the right code page yields.
pub(super) const MARKS: [&str; 5] = ["コメント", "注释", "軟元件", "코멘트", "주석"];
/// The heads stand within the first so many rows.
const HEADING_ROWS: usize = 4;

/// How a comment file is laid out.
#[derive(Debug, Clone, PartialEq, Eq)]
struct Layout {
    delimiter: u8,
    heading: usize,
    /// The columns that hold comments, the first that is not empty counts.
    columns: Vec<usize>,
}

/// Whether the beginning of a file is that of device comments.
pub(super) fn sniff(beginning: &str) -> bool {
    layout(beginning).is_some()
}

fn layout(beginning: &str) -> Option<Layout> {
    let end = beginning.char_indices().nth(8192).map_or(beginning.len(), |(at, _)| at);
    [b'\t', b',', b';'].into_iter().find_map(|delimiter| {
        reader(&beginning[..end], delimiter)
            .into_records()
            .take(HEADING_ROWS)
            .map_while(Result::ok)
            .enumerate()
            .find_map(|(index, record)| heads(index, &record, delimiter))
    })
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

/// Adds a file's comments to those of the project. A device that has one already keeps it.
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
