//! How a bound depends on its timing table: the times that are only assumed, and the factor on the whole scan.

use super::{AssumedUse, Bound, FactorUse, Share, TableUse};
use scanbound_base::time::Picos;
use scanbound_timing::price::{Price, Prices};
use scanbound_timing::table::{Evidence, Factor, Table};
use std::cmp::Reverse;
use std::collections::BTreeMap;
use std::sync::Arc;

/// The prices of a program and its bound, from which it follows how the bound depends on the table.
pub struct TableParts<'a> {
    pub prices: &'a Prices,
    pub bound: &'a Bound,
}

impl TableParts<'_> {
    /// How the bound depends on the table. `costs` are the instructions' times in the longest scan found, `shares`
    /// their parts of the bound, `groups` the groups' upper bounds.
    pub fn table_use(
        &self,
        table: &Table,
        costs: &[(usize, Picos)],
        shares: &[(usize, Picos)],
        groups: impl Iterator<Item = Picos>,
    ) -> TableUse {
        let mut assumed = self.assumed_instructions(costs, shares);
        assumed.extend(self.assumed_overhead());
        let factor = self.prices.factor.as_ref();
        let assumed_factor = factor.filter(|factor| factor.evidence == Evidence::Assumed);
        let certain: Picos = shares.iter().map(|(_, share)| *share).sum();
        let certain = certain + self.bound.overhead;
        let open = self.bound.upper.checked_sub(certain).unwrap_or_default();
        assumed.extend(assumed_factor.map(|factor| self.assumed_factor(factor, &assumed, open)));
        let rank = |one: &AssumedUse| (Reverse(one.part), Reverse(one.time), one.name.clone());
        assumed.sort_by_cached_key(rank);
        let assumed_time: Picos = assumed.iter().map(|one| one.time).sum();
        TableUse {
            name: table.name.clone(),
            title: table.title.clone(),
            is_all_assumed: table.rows().iter().all(|row| row.evidence == Evidence::Assumed),
            notes: table.notes.clone(),
            watchdog: table.watchdog(),
            factor: factor.map(|factor| self.factor_use(factor, groups)),
            assumed_share: Share::of(assumed_time, self.bound.lower),
            assumed,
            assumed_time,
        }
    }

    /// The assumed times of instructions, one entry for each row of the table. For a class row, one entry for each name
    /// under which the table could have a row for the instruction itself.
    fn assumed_instructions(
        &self,
        costs: &[(usize, Picos)],
        shares: &[(usize, Picos)],
    ) -> Vec<AssumedUse> {
        let is_assumed = |price: &&Arc<Price>| price.evidence == Evidence::Assumed;
        let mut rows: Vec<AssumedUse> = Vec::new();
        let mut known: BTreeMap<&str, usize> = BTreeMap::new();
        // The row of each instruction.
        let mut row_of: Vec<Option<usize>> = Vec::new();
        for price in &self.prices.instructions {
            let row = price.as_ref().filter(is_assumed).map(|price| {
                let name = price.instead_of.as_ref().unwrap_or(&price.row);
                let row = *known.entry(name).or_insert_with(|| {
                    rows.push(AssumedUse {
                        name: name.to_string(),
                        row: price.row.to_string(),
                        by_class: price.instead_of.is_some(),
                        count: 0,
                        time: Picos::ZERO,
                        part: Picos::ZERO,
                    });
                    rows.len() - 1
                });
                rows[row].count += 1;
                row
            });
            row_of.push(row);
        }
        for &(instruction, cost) in costs {
            if let Some(row) = row_of[instruction] {
                rows[row].time += cost;
            }
        }
        for &(instruction, share) in shares {
            if let Some(row) = row_of[instruction] {
                rows[row].part += share;
            }
        }
        rows
    }

    /// The assumed overhead terms.
    fn assumed_overhead(&self) -> impl Iterator<Item = AssumedUse> {
        let assumed = self.prices.overhead.iter().filter(|t| t.evidence == Evidence::Assumed);
        assumed.map(|term| AssumedUse {
            name: term.name.clone(),
            row: term.name.clone(),
            by_class: false,
            count: 0,
            time: term.time,
            part: term.time,
        })
    }

    /// The entry for an assumed factor: how much of the bound it adds. Its effect on times that are assumed themselves,
    /// and on the gap between the bounds, is not counted.
    fn assumed_factor(&self, factor: &Factor, assumed: &[AssumedUse], open: Picos) -> AssumedUse {
        let added = |whole: Picos, own: Picos| {
            let others = whole.checked_sub(own).unwrap_or_default();
            others.checked_sub(factor.taken_off(others)).unwrap_or_default()
        };
        let own: Picos = assumed.iter().map(|one| one.time).sum();
        let part: Picos = assumed.iter().map(|one| one.part).sum();
        AssumedUse {
            name: format!("factor {}", factor.text),
            row: "@factor".to_owned(),
            by_class: false,
            count: 0,
            time: added(self.bound.lower, own),
            part: added(self.bound.upper, part + open),
        }
    }

    fn factor_use(&self, factor: &Factor, groups: impl Iterator<Item = Picos>) -> FactorUse {
        let parts = self.prices.overhead.iter().map(|term| term.time).chain(groups);
        let bare: Picos = parts.chain([self.bound.always]).map(|time| factor.taken_off(time)).sum();
        FactorUse {
            text: factor.text.clone(),
            evidence: factor.evidence,
            source: factor.source.clone(),
            without: factor.taken_off(self.bound.upper),
            millionths: factor.millionths,
            part: self.bound.upper.checked_sub(bare).unwrap_or_default(),
        }
    }
}
