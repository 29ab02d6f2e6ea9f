//! The bound of a project under several timing tables: the maximum of the model, without a search for real scans.

use scanbound::audit::{PreparedProject, Request};
use scanbound::base::facts::Facts;
use scanbound::base::time::Picos;
use scanbound::front::Input;
use scanbound::scan::model::Assignment;
use scanbound::solve::{Limits, Method, maximum};
use scanbound::timing::table::Table;

/// The bounds of a file, one for each table.
///
/// # Panics
/// If the file cannot be audited.
pub fn model_bounds(name: &str, text: &str, tables: &[Table]) -> Vec<Picos> {
    let inputs = [Input { name: name.to_owned(), bytes: text.as_bytes().to_vec() }];
    let facts = Facts::default();
    let request = |table| {
        let request = Request::new(&inputs, &facts);
        Request { table: Some(table), relays: false, ..request }
    };
    let Some(first) = tables.first() else { return Vec::new() };
    let prepared = PreparedProject::of(&request(first));
    let prepared = prepared.unwrap_or_else(|failure| panic!("{failure:?}\n{text}"));
    let mut bounds = Vec::new();
    for table in tables {
        let request = request(table);
        let followed = prepared.with_table(table.clone(), &request).priced(&request);
        let followed = followed.unwrap_or_else(|failure| panic!("{failure:?}\n{text}"));
        let model = &followed.model;
        let none = Assignment(vec![0; model.variables.len()]);
        let longest = |group| maximum(model, group, Method::Cores, &Limits::default()).upper;
        let groups: Picos = followed.groups.iter().map(longest).sum();
        let always = model.cost(&model.constant_charges(), &none);
        bounds.push(followed.prices.overhead_sum() + always + groups);
    }
    bounds
}
