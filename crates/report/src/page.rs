//! What each code of findings means: the pages of `crates/base/codes`.

use super::columns::{fitted, left};
use super::findings::rules;
use scanbound_base::code::Code;

/// The page of a code; `limit-` in front of a verdict may be left out.
#[must_use]
pub fn of(name: &str) -> Option<&'static str> {
    let code = Code::ALL.iter().find(|code| code.name() == name).map(|code| code.page());
    let is_meant = |rule: &str| rule == name || rule.strip_prefix("limit-") == Some(name);
    let rule = || rules::ALL.iter().find(|rule| is_meant(rule.name)).map(|rule| rule.page);
    code.or_else(rule)
}

/// All codes.
pub fn names() -> impl Iterator<Item = &'static str> {
    all().map(|(name, _)| name)
}

/// All codes and what each means, in the order of their names.
#[must_use]
pub fn list(width: usize) -> String {
    let mut all: Vec<(&str, &str)> = all().collect();
    all.sort_unstable();
    let rows: Vec<_> = all.iter().map(|(name, about)| vec![left(*name), left(*about)]).collect();
    fitted(0, &rows, width)
}

fn all() -> impl Iterator<Item = (&'static str, &'static str)> {
    let codes = Code::ALL.iter().map(|code| (code.name(), code.summary()));
    codes.chain(rules::ALL.iter().map(|rule| (rule.name, rule.about)))
}
