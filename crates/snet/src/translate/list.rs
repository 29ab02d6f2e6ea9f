//! The instructions for a net, with its elements as operands: the common basis of all code formats.

use crate::{Diagram, Direction, Head, Kind, Signal};
use scanbound_base::code::Code;
use scanbound_base::diagnostic::Diagnostic;

/// The operand of an instruction.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Operand {
    /// A transition's relay.
    Transition(usize),
    /// A place's relay: of a timer its box (b), of a counter whether it has started to count (c).
    Place(usize),
    /// The contact of a timer (P) or counter (bc).
    Contact(usize),
    /// An outer gate.
    Outer(usize),
    /// The relay that is on only in the first scan.
    FirstScan,
}

/// The operation of an instruction. For contacts, whether they are normally closed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Operation {
    /// LD, LD NOT.
    Load(bool),
    /// AND, AND NOT.
    And(bool),
    /// OR, OR NOT.
    Or(bool),
    /// OUT.
    Out,
    /// TIM: the place's timer runs while the condition is true.
    Timer,
    /// CNT: the place's counter counts on the first condition and is reset by the second.
    Counter,
}

/// An instruction.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Instruction {
    /// The operation.
    pub operation: Operation,
    /// The operand.
    pub operand: Operand,
}

/// The purpose of a group of instructions.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Element {
    /// The initial marks, set in the first scan.
    Initial,
    /// An emergency stop or other transition.
    Transition(usize),
    /// A box, timer or counter.
    Place(usize),
}

/// The instructions of a net, in groups.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Listing {
    /// The groups in the order of the code.
    pub groups: Vec<(Element, Vec<Instruction>)>,
}

/// Makes the code of a net. With `initial`, it begins with setting the initial marks in the first scan.
///
/// # Errors
/// Elements without an address, each with its line.
pub fn listing(diagram: &Diagram, initial: bool) -> Result<Listing, Vec<Diagnostic>> {
    let missing = missing(diagram);
    if !missing.is_empty() {
        return Err(missing);
    }
    let mut groups = Vec::new();
    let marked = diagram.places.iter().enumerate().filter(|(_, place)| place.is_marked);
    let marks: Vec<Instruction> = marked
        .flat_map(|(at, _)| {
            let place = Operand::Place(at);
            [load(Operand::FirstScan), or(place), out(place)]
        })
        .collect();
    if initial && !marks.is_empty() {
        groups.push((Element::Initial, marks));
    }
    let transitions = 0..diagram.transitions.len();
    let (stops, others): (Vec<usize>, Vec<usize>) =
        transitions.partition(|&at| diagram.transitions[at].is_stop);
    let stops = stops.into_iter().map(|at| (Element::Transition(at), stop(diagram, at)));
    groups.extend(stops);
    let others = others.into_iter().map(|at| (Element::Transition(at), transition(diagram, at)));
    groups.extend(others);
    let is_kind: [fn(Kind) -> bool; 3] = [
        |kind| kind == Kind::Box,
        |kind| matches!(kind, Kind::Timer { .. }),
        |kind| matches!(kind, Kind::Counter { .. }),
    ];
    for is in is_kind {
        let own = (0..diagram.places.len()).filter(|&at| is(diagram.places[at].kind));
        groups.extend(own.map(|at| (Element::Place(at), place(diagram, at))));
    }
    Ok(Listing { groups })
}

fn load(operand: Operand) -> Instruction {
    Instruction { operation: Operation::Load(false), operand }
}

fn or(operand: Operand) -> Instruction {
    Instruction { operation: Operation::Or(false), operand }
}

fn out(operand: Operand) -> Instruction {
    Instruction { operation: Operation::Out, operand }
}

/// The signal that transitions and gates read: of timers and counters their contacts.
fn signal(diagram: &Diagram, place: usize) -> Operand {
    match diagram.places[place].kind {
        Kind::Box => Operand::Place(place),
        _ => Operand::Contact(place),
    }
}

/// The signal that a transition into this place reads: of a timer its box, of a counter its contact.
fn room(diagram: &Diagram, place: usize) -> Operand {
    match diagram.places[place].kind {
        Kind::Counter { .. } => Operand::Contact(place),
        _ => Operand::Place(place),
    }
}

/// The gates of a transition, permissive ones first.
fn gates(diagram: &Diagram, at: usize) -> Vec<(Operand, bool)> {
    let mut found: Vec<(Operand, bool)> = diagram
        .gates_of(at)
        .map(|gate| {
            let operand = match gate.signal {
                Signal::Place(place) => signal(diagram, place),
                Signal::Outer(outer) => Operand::Outer(outer),
            };
            (operand, gate.is_inhibiting)
        })
        .collect();
    found.sort_by_key(|&(_, is_inhibiting)| is_inhibiting);
    found
}

/// Contacts in series.
fn series(contacts: &[(Operand, bool)], begins: bool) -> Vec<Instruction> {
    let one = |(at, &(operand, is_closed)): (usize, &(Operand, bool))| Instruction {
        operation: if begins && at == 0 {
            Operation::Load(is_closed)
        } else {
            Operation::And(is_closed)
        },
        operand,
    };
    contacts.iter().enumerate().map(one).collect()
}

/// Contacts in parallel.
fn parallel(contacts: &[Operand]) -> Vec<Instruction> {
    let one = |(at, &operand): (usize, &Operand)| if at == 0 { load(operand) } else { or(operand) };
    contacts.iter().enumerate().map(one).collect()
}

fn stop(diagram: &Diagram, at: usize) -> Vec<Instruction> {
    let places: Vec<Operand> = diagram.places_of(at, Direction::Stop).map(Operand::Place).collect();
    let mut all = parallel(&places);
    all.extend(series(&gates(diagram, at), false));
    all.push(out(Operand::Transition(at)));
    all
}

fn transition(diagram: &Diagram, at: usize) -> Vec<Instruction> {
    let inputs =
        diagram.places_of(at, Direction::Into).map(|place| (signal(diagram, place), false));
    let outputs = diagram.places_of(at, Direction::OutOf).map(|place| (room(diagram, place), true));
    let mut contacts: Vec<(Operand, bool)> = inputs.chain(outputs).collect();
    contacts.extend(gates(diagram, at));
    let mut all = series(&contacts, true);
    all.push(out(Operand::Transition(at)));
    all
}

fn place(diagram: &Diagram, at: usize) -> Vec<Instruction> {
    let of = |direction| -> Vec<Operand> {
        diagram.transitions_of(at, direction).map(Operand::Transition).collect()
    };
    let own = Operand::Place(at);
    let (inputs, outputs) = (of(Direction::OutOf), of(Direction::Into));
    let takers: Vec<Operand> = outputs.iter().copied().chain(of(Direction::Stop)).collect();
    let fills: Vec<Operand> = inputs.iter().copied().chain([own]).collect();
    let closed: Vec<(Operand, bool)> = takers.iter().map(|&taker| (taker, true)).collect();
    let mut all = parallel(&fills);
    all.extend(series(&closed, false));
    all.push(out(own));
    match diagram.places[at].kind {
        Kind::Box => {}
        Kind::Timer { .. } => {
            all.push(load(own));
            all.push(Instruction { operation: Operation::Timer, operand: Operand::Contact(at) });
        }
        Kind::Counter { .. } => {
            all.extend(parallel(&inputs));
            all.extend(parallel(&takers));
            all.push(Instruction { operation: Operation::Counter, operand: Operand::Contact(at) });
        }
    }
    all
}

/// One error for each element that needs an address and has none.
fn missing(diagram: &Diagram) -> Vec<Diagnostic> {
    let mut found = Vec::new();
    let mut tell = |head: &Head, what: &str, help: &str| {
        let message = format!("{} has no {what}, which its code needs", head.name);
        found.push(Diagnostic::line(Code::NetAddress, &diagram.file, head.line, "", message, help));
    };
    let relay =
        "write a relay after its name (= 00305), or use --assign to assign relays to all elements";
    let heads = (diagram.outers.iter().map(|one| &one.head))
        .chain(diagram.transitions.iter().map(|one| &one.head))
        .chain(diagram.places.iter().map(|one| &one.head));
    heads.filter(|head| head.address.is_none()).for_each(|head| tell(head, "address", relay));
    for place in &diagram.places {
        match place.kind {
            Kind::Timer { number: None, .. } => {
                tell(&place.head, "timer number", "write TIM and a number, 000 to 511");
            }
            Kind::Counter { number: None, .. } => {
                tell(&place.head, "counter number", "write CNT and a number, 000 to 511");
            }
            _ => {}
        }
    }
    found.sort_by_key(|one| one.line);
    found
}
