//! What was read of a net from a PLC, as lines: of text, or of JSON.

use scanbound_link::State;
use scanbound_snet::monitor::{PlaceReading, Reading};
use scanbound_snet::picture::seconds;
use scanbound_snet::{Diagram, Kind};
use schemars::JsonSchema;
use serde::Serialize;
use std::collections::BTreeMap;
use std::time::Duration;

/// The name of the JSON lines' form.
pub const SCHEMA: &str = "scanbound.snet-monitor/1";

/// A line: a reading, or a fault.
#[derive(Debug, Serialize, JsonSchema)]
pub struct Row<'a> {
    schema: &'static str,
    ms: u64,
    #[serde(skip_serializing_if = "Option::is_none")]
    fault: Option<&'a str>,
    #[serde(skip_serializing_if = "Option::is_none")]
    reading: Option<Values<'a>>,
}

#[derive(Debug, Serialize, JsonSchema)]
struct Values<'a> {
    cpu: &'static str,
    answers: usize,
    one_moment: bool,
    took_ms: u64,
    marks: BTreeMap<String, Option<bool>>,
    transitions: BTreeMap<String, Option<bool>>,
    timers: BTreeMap<String, Timed>,
    counters: BTreeMap<String, Timed>,
    outers: BTreeMap<&'a str, Option<bool>>,
}

#[derive(Debug, Serialize, JsonSchema)]
struct Timed {
    state: Option<&'static str>,
    set: Option<u16>,
    present: Option<u16>,
    elapsed: Option<u16>,
}

fn millis(time: Duration) -> u64 {
    u64::try_from(time.as_millis()).unwrap_or(u64::MAX)
}

/// What a timer or counter does.
#[must_use]
pub fn state(shown: PlaceReading) -> Option<&'static str> {
    match (shown.over?, shown.is_running()?) {
        (true, _) => Some("over"),
        (false, true) => Some("running"),
        (false, false) => Some("idle"),
    }
}

/// What the CPU does.
#[must_use]
pub fn cpu(state: State) -> &'static str {
    match state {
        State::Run => "run",
        State::Stop => "stop",
    }
}

fn values<'a>(diagram: &'a Diagram, reading: &Reading) -> Values<'a> {
    let places = || diagram.places.iter().zip(&reading.places).enumerate();
    let timed = |is_timer: bool| {
        places()
            .filter(|(_, (place, _))| match place.kind {
                Kind::Box => false,
                Kind::Timer { .. } => is_timer,
                Kind::Counter { .. } => !is_timer,
            })
            .map(|(at, (_, shown))| {
                let (set, present) = (shown.setting, shown.present);
                let timed = Timed { state: state(*shown), set, present, elapsed: shown.elapsed() };
                (diagram.place_name(at), timed)
            })
            .collect()
    };
    let mark = |place: &scanbound_snet::Place, shown: &PlaceReading| match place.kind {
        Kind::Counter { .. } => shown.over,
        Kind::Box | Kind::Timer { .. } => shown.relay,
    };
    Values {
        cpu: cpu(reading.cpu),
        answers: reading.answers,
        one_moment: reading.is_of_one_moment(),
        took_ms: millis(reading.took),
        marks: places()
            .map(|(at, (place, shown))| (diagram.place_name(at), mark(place, shown)))
            .collect(),
        transitions: (0..)
            .zip(&reading.transitions)
            .map(|(at, on)| (diagram.transition_name(at), *on))
            .collect(),
        timers: timed(true),
        counters: timed(false),
        outers: diagram
            .outers
            .iter()
            .zip(&reading.outers)
            .map(|(outer, on)| (&*outer.head.name, *on))
            .collect(),
    }
}

/// A reading as a line of JSON; `since` is how long the monitor has been running.
///
/// # Errors
/// None that is known: names and numbers can be written.
pub fn json(diagram: &Diagram, since: Duration, reading: &Reading) -> serde_json::Result<String> {
    let reading = Some(values(diagram, reading));
    let row = Row { schema: SCHEMA, ms: millis(since), fault: None, reading };
    Ok(serde_json::to_string(&row)? + "\n")
}

/// A fault as a line of JSON.
///
/// # Errors
/// None that is known.
pub fn json_fault(since: Duration, fault: &str) -> serde_json::Result<String> {
    let row = Row { schema: SCHEMA, ms: millis(since), fault: Some(fault), reading: None };
    Ok(serde_json::to_string(&row)? + "\n")
}

/// A reading in words, without the time: the marks, timers and counters that are not idle, gates that are on.
#[must_use]
pub fn text(diagram: &Diagram, reading: &Reading) -> String {
    let mut parts = Vec::new();
    if reading.cpu == State::Stop {
        parts.push("the CPU is in STOP".to_owned());
    }
    let (mut marks, mut unknown) = (Vec::new(), Vec::new());
    for (at, (place, shown)) in diagram.places.iter().zip(&reading.places).enumerate() {
        let marked = match place.kind {
            Kind::Counter { .. } => shown.over,
            Kind::Box | Kind::Timer { .. } => shown.relay,
        };
        match marked {
            Some(true) => marks.push(diagram.place_name(at)),
            Some(false) => {}
            None => unknown.push(diagram.place_name(at)),
        }
        let number =
            |value: Option<u16>| value.map_or_else(|| "?".to_owned(), |one| one.to_string());
        let time = |value: Option<u16>| value.map_or_else(|| "?".to_owned(), seconds);
        let (gone, set) = (shown.elapsed(), shown.setting);
        let state = state(*shown).unwrap_or("?");
        match place.kind {
            Kind::Timer { .. } if state != "idle" => parts.push(format!(
                "{} {state} {} of {}",
                diagram.place_name(at),
                time(gone),
                time(set)
            )),
            Kind::Counter { .. } if state != "idle" => parts.push(format!(
                "{} {state} {} of {}",
                diagram.place_name(at),
                number(gone),
                number(set)
            )),
            _ => {}
        }
    }
    let list =
        |names: Vec<String>| if names.is_empty() { "none".to_owned() } else { names.join(" ") };
    parts.insert(0, format!("marked: {}", list(marks)));
    let gates = diagram.outers.iter().zip(&reading.outers).filter(|(_, on)| **on == Some(true));
    let gates: Vec<String> = gates.map(|(outer, _)| outer.head.name.clone()).collect();
    if !gates.is_empty() {
        parts.push(format!("on: {}", gates.join(" ")));
    }
    if !unknown.is_empty() {
        parts.push(format!("without address: {}", unknown.join(" ")));
    }
    parts.join("; ")
}
