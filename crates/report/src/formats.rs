//! Which format is meant, by its name or by a file's.

use super::format::Format;

/// The format of this name.
#[must_use]
pub fn named<'f>(formats: &'f [Format], name: &str) -> Option<&'f Format> {
    formats.iter().find(|format| format.name == name)
}

/// The format that a file's name means by its end; of several ends the longest counts (`a.sarif.json`).
#[must_use]
pub fn by_suffix<'f>(formats: &'f [Format], file: &str) -> Option<&'f Format> {
    let file = file.to_lowercase();
    let ends =
        formats.iter().flat_map(|format| format.suffixes.iter().map(move |end| (end, format)));
    let meant =
        ends.filter(|(end, _)| file.strip_suffix(**end).is_some_and(|name| name.ends_with('.')));
    meant.max_by_key(|(end, _)| end.len()).map(|(_, format)| format)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::FORMATS;
    use std::collections::BTreeSet;

    #[test]
    fn no_two_formats_share_a_name_or_a_suffix() {
        let mut known = BTreeSet::new();
        for format in FORMATS {
            assert!(known.insert(format.name.to_owned()), "{}", format.name);
            assert!(std::ptr::eq(named(FORMATS, format.name).expect(format.name), format));
            for suffix in format.suffixes {
                assert!(known.insert(format!(".{suffix}")), "{suffix}");
                let found = by_suffix(FORMATS, &format!("a.b.{}", suffix.to_uppercase()));
                assert_eq!(found.map(|found| found.name), Some(format.name));
            }
        }
    }

    #[test]
    fn a_name_without_a_known_suffix_means_no_format() {
        for file in ["report", "json", "report.", "report.log"] {
            assert!(by_suffix(FORMATS, file).is_none(), "{file}");
        }
    }
}
