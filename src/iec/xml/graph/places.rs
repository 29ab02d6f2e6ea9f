//! Which variables of a drawing are one and the same: those with addresses that overlap.

use crate::iec::ast::Path;
use crate::iec::xml::reading::Reading;
use crate::iec::{Section, parse};
use roxmltree::Node;
use std::collections::{BTreeMap, BTreeSet};

/// What is known of the variables that a drawing names.
#[derive(Clone, Default)]
pub(super) struct Places {
    /// Those with an address, and one of all that overlap with it.
    located: BTreeMap<String, String>,
    /// Those that nothing but this unit reads and writes.
    private: BTreeSet<String>,
}

impl Places {
    pub(super) fn new<'a, 'i: 'a>(
        reading: &Reading<'_, '_>,
        nodes: impl Iterator<Item = Node<'a, 'i>>,
    ) -> Places {
        let mut addresses: BTreeMap<String, String> = BTreeMap::new();
        for own in &reading.pou.variables {
            if let Some(at) = &own.at {
                addresses.insert(own.name.to_lowercase(), at.to_uppercase());
            }
        }
        for node in nodes {
            for inner in node.descendants().filter(|one| one.is_text()) {
                let text = inner.text().unwrap_or_default().trim();
                let name = match parse::expression(text, 0) {
                    Ok(crate::iec::ast::Expr::Variable(Path { first, .. })) => first.to_lowercase(),
                    _ => continue,
                };
                if name.starts_with('%') {
                    addresses.insert(name.clone(), name.to_uppercase());
                } else if let Some(at) = reading.text.address(&name) {
                    addresses.entry(name).or_insert_with(|| at.to_uppercase());
                }
            }
        }
        let mut located: BTreeMap<String, String> = BTreeMap::new();
        let mut groups: Vec<Vec<(&String, &String)>> = Vec::new();
        for one in &addresses {
            let (meeting, mut others): (Vec<_>, Vec<_>) = groups
                .into_iter()
                .partition(|group| group.iter().any(|(_, other)| overlap(one.1, other)));
            let mut group: Vec<_> = meeting.into_iter().flatten().collect();
            group.push(one);
            others.push(group);
            groups = others;
        }
        for group in groups {
            let Some((first, _)) = group.first() else { continue };
            let shown = format!("%{first}");
            located.extend(group.iter().map(|(name, _)| ((*name).clone(), shown.clone())));
        }
        let own = reading.pou.variables.iter().filter(|own| {
            own.at.is_none()
                && matches!(
                    own.section,
                    Section::Local | Section::Temp | Section::Input | Section::Output
                )
        });
        let private = own.map(|own| own.name.to_lowercase()).collect();
        Places { located, private }
    }

    /// The one name of all that is the same variable.
    pub(super) fn one_name(&self, name: &str) -> String {
        let name = name.to_lowercase();
        self.located.get(&name).cloned().unwrap_or(name)
    }

    /// Whether two names may be those of one variable.
    pub(super) fn are_one(&self, one: &str, other: &str) -> bool {
        self.one_name(one) == self.one_name(other)
    }

    /// Whether something else than the unit may write or read a variable.
    pub(super) fn is_shared(&self, name: &str) -> bool {
        !self.private.contains(&name.to_lowercase())
    }
}

/// Whether addresses such as `%QX0.1` and `%QW0` may overlap: two of one size are apart unless they are equal.
fn overlap(one: &str, other: &str) -> bool {
    let parts = |text: &str| {
        let mut letters = text.trim_start_matches('%').chars();
        let area = letters.next();
        let rest: String = letters.collect();
        let digits = rest.trim_start_matches(|c: char| c.is_ascii_alphabetic());
        let size = rest[..rest.len() - digits.len()].trim_start_matches('X').to_owned();
        (area, size, digits.to_owned())
    };
    let (one, other) = (parts(one), parts(other));
    one.0 == other.0 && (one.1 != other.1 || one.2 == other.2)
}
