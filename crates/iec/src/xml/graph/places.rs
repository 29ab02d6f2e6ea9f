//! Which variables of a drawing are one and the same: those with addresses that overlap.

use crate::ast::{Expr, Part, Path, paths_of};
use crate::xml::reading::Reading;
use crate::{Section, TypeRef, parse, same};
use roxmltree::Node;
use std::collections::{BTreeMap, BTreeSet};

/// Types of which a variable is no larger than its address says.
const ELEMENTARY: &[&str] = &[
    "BOOL", "BYTE", "WORD", "DWORD", "LWORD", "SINT", "INT", "DINT", "LINT", "USINT", "UINT",
    "UDINT", "ULINT", "REAL", "LREAL", "TIME",
];

/// Where a variable lies, and whether it is an elementary one.
type Address = (String, bool);

/// What is known of the variables that a drawing names.
#[derive(Clone, Default)]
pub(super) struct Places {
    /// Those that the unit declares.
    own: BTreeSet<String>,
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
        let mut addresses: BTreeMap<String, Address> = BTreeMap::new();
        for own in &reading.pou.variables {
            if let Some(at) = &own.at {
                let is_plain = matches!(&own.of, TypeRef::Named(name) if is_elementary(name));
                addresses.insert(own.name.to_lowercase(), (at.to_uppercase(), is_plain));
            }
        }
        for node in nodes {
            for inner in node.descendants().filter(|one| one.is_text()) {
                let text = inner.text().unwrap_or_default().trim();
                let Ok(Expr::Variable(path)) = parse::expression(text, 0) else { continue };
                for name in [Some(path.first.as_str()), second(&path)].into_iter().flatten() {
                    let name = name.to_lowercase();
                    if name.starts_with('%') {
                        addresses.insert(name.clone(), (name.to_uppercase(), true));
                    } else if let Some((at, is_plain)) = reading.text.address(&name) {
                        addresses.entry(name).or_insert((at.to_uppercase(), is_plain));
                    }
                }
            }
        }
        let mut located: BTreeMap<String, String> = BTreeMap::new();
        let mut groups: Vec<Vec<(&String, &Address)>> = Vec::new();
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
        let all = reading.pou.variables.iter().map(|own| own.name.to_lowercase());
        Places { own: all.collect(), located, private }
    }

    /// The variables that a path may mean: of a list of globals, the one in it, too.
    pub(super) fn names<'p>(&self, path: &'p Path) -> impl Iterator<Item = &'p str> {
        let is_own = self.own.contains(&path.first.to_lowercase());
        let second = second(path).filter(|_| !is_own);
        std::iter::once(path.first.as_str()).chain(second)
    }

    /// The variables that an expression reads, but those that only hold what leads on.
    pub(super) fn read(&self, value: &Expr) -> BTreeSet<String> {
        let mut found = BTreeSet::new();
        paths_of(&mut value.clone(), &mut |path| {
            if !path.first.starts_with('~') {
                found.extend(self.names(path).map(str::to_owned));
            }
        });
        found
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

/// The name behind the first one.
fn second(path: &Path) -> Option<&str> {
    match path.rest.first() {
        Some(Part::Name(name)) => Some(name),
        _ => None,
    }
}

fn is_elementary(name: &str) -> bool {
    ELEMENTARY.iter().any(|own| same(own, name))
}

/// Whether addresses such as `%QX0.1` and `%QW0` may overlap: two of one size are apart unless they are equal, or one of them
/// is that of an array or a structure.
fn overlap((one, is_plain): &Address, (other, also): &Address) -> bool {
    let parts = |text: &str| {
        let mut letters = text.trim_start_matches('%').chars();
        let area = letters.next();
        let rest: String = letters.collect();
        let digits = rest.trim_start_matches(|c: char| c.is_ascii_alphabetic());
        let size = rest[..rest.len() - digits.len()].trim_start_matches('X').to_owned();
        (area, size, digits.to_owned())
    };
    let (one, other) = (parts(one), parts(other));
    one.0 == other.0 && (!is_plain || !also || one.1 != other.1 || one.2 == other.2)
}
