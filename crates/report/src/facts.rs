//! A facts file that offers what is worth stating, nothing of it stated yet.

use super::text::place;
use scanbound_audit::Audit;
use scanbound_audit::offer::{Offer, SolvedLimits};
use scanbound_ir::MissingRoutine;
use std::fmt::Write;

/// More places of one fact are counted, not shown.
const MAX_PLACES: usize = 5;

/// The file. What can be stated stands behind one `#`, what is told of it behind two: without the first of each line
/// all of it is TOML. `absent` are the routines that are not there.
#[must_use]
pub fn file(audit: &Audit, offers: &[Offer], absent: &[MissingRoutine]) -> String {
    let mut text = head(audit, offers, absent);
    let mut table = "";
    for offer in offers {
        if offer.table != table {
            table = offer.table;
            let _ = write!(text, "\n[{table}]\n");
        } else {
            text.push('\n');
        }
        text += &told(&offer.what);
        if let Some(worth) = worth(audit, offer) {
            text += &told(&worth);
        }
        if let Some(solved) = offer.solved.as_ref().and_then(solved) {
            text += &told(&solved);
        }
        for (at, instruction) in offer.places.iter().take(MAX_PLACES) {
            text += &told(&format!("  {}  {instruction}", place(audit, *at)));
        }
        if let Some(more) = offer.places.len().checked_sub(MAX_PLACES).filter(|more| *more > 0) {
            text += &told(&format!("  and {more} more"));
        }
        let _ = writeln!(text, "# {}", offer.line);
    }
    text
}

fn head(audit: &Audit, offers: &[Offer], absent: &[MissingRoutine]) -> String {
    let mut text = String::new();
    let missing = absent.iter().any(|one| !one.stated);
    text += &told(&match missing {
        true => format!(
            "Routines are not there: without their times the bound is {}.",
            audit.bound.upper
        ),
        false => format!("The bound is {}.", audit.bound.upper),
    });
    text += &told(match offers.is_empty() {
        true => "Nothing is worth stating: what the bound rests on is known.",
        false => {
            "Replace the values by what is true and take the # away in front of them: what is stated is believed."
        }
    });
    text
}

/// What stating it is worth.
fn worth(audit: &Audit, offer: &Offer) -> Option<String> {
    let share = |worth| scanbound_audit::Share::of(worth, audit.bound.upper);
    offer.worth.map(|worth| format!("worth {worth} at most, {} of the bound", share(worth)))
}

/// What the bound is where it is stated.
fn solved(solved: &SolvedLimits) -> Option<String> {
    let ((most, bound), others) = solved.bounds.split_first()?;
    let others: String = others.iter().map(|(most, bound)| format!("; {most}: {bound}")).collect();
    let with = match &solved.with[..] {
        [] => String::new(),
        words => format!(" ({} likewise)", words.join(", ")),
    };
    Some(format!("at most {most}: the bound is {bound}{others}{with}"))
}

/// A line that is no fact. What a device's comment holds of line breaks ends no line here.
fn told(what: &str) -> String {
    let what: String = what.chars().map(|c| if c.is_control() { ' ' } else { c }).collect();
    format!("## {what}\n")
}
