//! What projects of IEC 61131-3 have: charts, tasks and statements.

use scanbound_audit::TaskUse;
use schemars::JsonSchema;
use serde::Serialize;

/// A task of a project that has several.
#[derive(Serialize, JsonSchema)]
pub(super) struct Task<'a> {
    name: &'a str,
    interval_ps: Option<u64>,
    priority: Option<i64>,
    programs: &'a [String],
    upper_ps: Option<u64>,
    lower_ps: u64,
    exact: bool,
    interrupted_by: &'a [String],
    waits_for: &'a [String],
    response_ps: Option<u64>,
    no_response: Option<&'a str>,
}

/// A task as it is written.
pub(super) fn task(one: &TaskUse) -> Task<'_> {
    Task {
        name: &one.name,
        interval_ps: one.interval.map(|time| time.0),
        priority: one.priority.filter(|&level| level < i64::MAX),
        programs: &one.programs,
        upper_ps: one.upper.map(|time| time.0),
        lower_ps: one.lower.0,
        exact: one.upper == Some(one.lower),
        interrupted_by: &one.interrupted_by,
        waits_for: &one.waits_for,
        response_ps: one.response.as_ref().ok().map(|time| time.0),
        no_response: one.response.as_ref().err().map(String::as_str),
    }
}

/// What it is worth that steps and stored actions exclude each other.
#[derive(Serialize, JsonSchema)]
pub(super) struct Coactivity<'a> {
    without_ps: u64,
    cut: bool,
    active: &'a [String],
}

impl Coactivity<'_> {
    pub(super) fn of(found: &scanbound_audit::Coactivity) -> Coactivity<'_> {
        Coactivity {
            without_ps: found.without.upper.0,
            cut: found.without.cut,
            active: &found.active,
        }
    }
}

/// How much of the source is followed exactly.
#[derive(Serialize, JsonSchema)]
pub(super) struct Exactness<'a> {
    statements: u64,
    exact: u64,
    languages: Vec<Language<'a>>,
    constructs: Vec<Construct<'a>>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    unread: Vec<Unread<'a>>,
}

#[derive(Serialize, JsonSchema)]
struct Language<'a> {
    language: &'a str,
    bodies: u64,
    uncalled: u64,
    statements: u64,
    exact: u64,
}

#[derive(Serialize, JsonSchema)]
struct Construct<'a> {
    what: &'a str,
    statements: u64,
    places: Vec<Inexact<'a>>,
}

#[derive(Serialize, JsonSchema)]
struct Inexact<'a> {
    file: u32,
    line: u32,
    body: &'a str,
    statement: &'a str,
}

#[derive(Serialize, JsonSchema)]
struct Unread<'a> {
    body: &'a str,
    why: &'a str,
}

impl Exactness<'_> {
    pub(super) fn of(found: &scanbound_audit::Exactness) -> Exactness<'_> {
        let (statements, exact) = found.total();
        let language = |one: &scanbound_audit::LanguageUse| Language {
            language: one.language,
            bodies: one.called,
            uncalled: one.uncalled,
            statements: one.statements,
            exact: one.exact,
        };
        let unread = found.unread.iter().map(|(body, why)| Unread { body, why });
        Exactness {
            statements,
            exact,
            languages: found.languages.iter().map(language).collect(),
            constructs: found.constructs.iter().map(construct).collect(),
            unread: unread.collect(),
        }
    }
}

fn construct(one: &scanbound_audit::Construct) -> Construct<'_> {
    let inexact = one.places.iter().map(|place| Inexact {
        file: place.at.file,
        line: place.at.line,
        body: &place.body,
        statement: &place.text,
    });
    Construct { what: &one.what, statements: one.statements, places: inexact.collect() }
}
