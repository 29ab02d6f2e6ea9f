//! Resolves names: an element of the same page, an element of another page (with the page before it), or an outer gate.

use super::super::Diagram;
use std::collections::BTreeMap;

/// The element that a name stands for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Named {
    /// A box, a timer or a counter.
    Place(usize),
    /// A transition, or an emergency-stop transition.
    Transition(usize),
    /// An outer gate.
    Outer(usize),
}

/// All names of a net.
#[derive(Debug, Default)]
pub(super) struct Names {
    /// By page and name; outer gates have no page.
    known: BTreeMap<(Option<usize>, String), (Named, u32)>,
    pages: BTreeMap<String, usize>,
}

impl Names {
    /// Adds the names of the pages.
    pub(super) fn pages(&mut self, diagram: &Diagram) {
        let named = diagram.pages.iter().enumerate();
        self.pages = named.map(|(at, page)| (page.name.clone(), at)).collect();
    }

    /// Adds a name. Returns the line of another element that already has it.
    pub(super) fn add(
        &mut self,
        page: usize,
        name: &str,
        line: u32,
        named: Named,
    ) -> Result<(), u32> {
        let page = (!matches!(named, Named::Outer(_))).then_some(page);
        let key = (page, name.to_owned());
        if let Some(&(_, other)) = self.known.get(&key) {
            return Err(other);
        }
        self.known.insert(key, (named, line));
        Ok(())
    }

    /// Names that an outer gate and another element share: the name, the gate's line, the other's line.
    pub(super) fn ambiguous(&self) -> Vec<(&str, u32, u32)> {
        let others = self.known.iter().filter(|((page, _), _)| page.is_some());
        let both = others.filter_map(|((_, name), &(_, line))| {
            let (_, gate) = self.known.get(&(None, name.clone()))?;
            Some((name.as_str(), *gate, line))
        });
        both.collect()
    }

    /// The element of a name that is used on a page.
    pub(super) fn find(&self, page: usize, name: &str) -> Option<Named> {
        let qualified = || {
            let (page, own) = name.split_once('.')?;
            Some((Some(*self.pages.get(page)?), own.to_owned()))
        };
        let keys =
            [Some((Some(page), name.to_owned())), qualified(), Some((None, name.to_owned()))];
        keys.into_iter().flatten().find_map(|key| self.known.get(&key).map(|&(named, _)| named))
    }

    /// All names that can be used on a page.
    pub(super) fn all(&self, page: usize) -> impl Iterator<Item = String> + '_ {
        let page_name = |at: usize| {
            self.pages.iter().find(|(_, own)| **own == at).map_or("", |(name, _)| name.as_str())
        };
        self.known.keys().map(move |(own, name)| match own {
            Some(other) if *other != page => format!("{}.{name}", page_name(*other)),
            _ => name.clone(),
        })
    }
}
