//! What a net's relays are called in each kind of code.

use super::list::Operand;
use crate::address::{Address, Area};
use crate::{Diagram, Head, Kind};
use scanbound_base::code::Code;
use scanbound_base::diagnostic::Diagnostic;

/// A kind of code, by how it names relays.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Spelling {
    /// The C200H's: word and bit.
    C200h,
    /// That of CS, CJ and CP: internal relays keep word and bit, holding relays are H, link relays CIO 1000 on; special
    /// relays are those that have a symbol there.
    Cx,
    /// MELSEC's: a relay's number is its word times 16 and its bit; internal relays are M, holding ones L, link ones B, outer
    /// gates among the internal ones X.
    Melsec,
}

/// Special relays of the C200H and the symbols that say the same.
const SYMBOLS: [(u16, u8, &str); 5] = [
    (253, 13, "P_On"),
    (253, 14, "P_Off"),
    (255, 0, "P_0_1s"),
    (255, 1, "P_0_2s"),
    (255, 2, "P_1s"),
];

impl Spelling {
    /// All of them, each with a word by whose name programs of this kind are told apart from those that follow.
    pub const ALL: [(Spelling, Option<&str>); 3] =
        [(Spelling::Cx, Some("CIO0")), (Spelling::C200h, Some("IR0")), (Spelling::Melsec, None)];

    /// A relay as code has it; `None` where these CPUs have no such relay.
    #[must_use]
    pub fn relay(self, address: Address, is_outer: bool) -> Option<String> {
        let Address { area, word, bit } = address;
        let number = u32::from(word) * 16 + u32::from(bit);
        let is_special = area == Area::Internal && !address.is_writable();
        match (self, area) {
            (Spelling::C200h, _) => Some(address.to_string()),
            (_, Area::Auxiliary) => None,
            (Spelling::Cx, Area::Internal) if is_special => {
                let found = SYMBOLS.iter().find(|(own, at, _)| (*own, *at) == (word, bit));
                found.map(|(.., symbol)| (*symbol).to_owned())
            }
            (Spelling::Cx, Area::Internal) => Some(format!("{word}.{bit:02}")),
            (Spelling::Cx, Area::Holding) => Some(format!("H{word}.{bit:02}")),
            (Spelling::Cx, Area::Link) => Some(format!("{}.{bit:02}", 1_000 + word)),
            (Spelling::Melsec, Area::Internal) if is_special => None,
            (Spelling::Melsec, Area::Internal) if is_outer => Some(format!("X{number:X}")),
            (Spelling::Melsec, Area::Internal) => Some(format!("M{number}")),
            (Spelling::Melsec, Area::Holding) => Some(format!("L{number}")),
            (Spelling::Melsec, Area::Link) => Some(format!("B{number:X}")),
        }
    }

    /// A relay by the name of its area, its word and bit, as reports have it.
    #[must_use]
    pub fn device(self, address: Address) -> Option<String> {
        let Address { area, word, bit } = address;
        match (self, area) {
            (Spelling::C200h, Area::Internal) => Some(format!("IR{word}.{bit:02}")),
            (Spelling::C200h, _) => Some(format!("{}{word}.{bit:02}", area.letters())),
            (Spelling::Cx, Area::Internal) if address.is_writable() => {
                Some(format!("CIO{word}.{bit:02}"))
            }
            (Spelling::Cx, Area::Link) => Some(format!("CIO{}.{bit:02}", 1_000 + word)),
            _ => self.relay(address, false),
        }
    }

    fn first_scan(self) -> &'static str {
        match self {
            Spelling::C200h => "25315",
            Spelling::Cx => "P_First_Cycle",
            Spelling::Melsec => "SM402",
        }
    }

    fn contact(self, letter: char, number: u16) -> String {
        match self {
            Spelling::Cx => format!("{letter}{number:04}"),
            Spelling::C200h | Spelling::Melsec => format!("{letter}{number}"),
        }
    }
}

/// An operand as code has it.
pub(super) fn operand(diagram: &Diagram, operand: Operand, spelling: Spelling) -> String {
    let own = |head: &Head, is_outer| {
        let name = head.address.and_then(|address| spelling.relay(address, is_outer));
        name.unwrap_or_default()
    };
    match operand {
        Operand::Transition(at) => own(&diagram.transitions[at].head, false),
        Operand::Place(at) => own(&diagram.places[at].head, false),
        Operand::Outer(at) => own(&diagram.outers[at].head, true),
        Operand::FirstScan => spelling.first_scan().to_owned(),
        Operand::Contact(at) => match diagram.places[at].kind {
            Kind::Timer { number, .. } => spelling.contact('T', number.unwrap_or(0)),
            Kind::Counter { number, .. } => spelling.contact('C', number.unwrap_or(0)),
            Kind::Box => own(&diagram.places[at].head, false),
        },
    }
}

/// Refuses relays that the CPUs have no counterpart of, whose they are in words.
pub(super) fn refuse_missing(
    diagram: &Diagram,
    spelling: Spelling,
    whose: &str,
    help: &str,
) -> Result<(), Vec<Diagnostic>> {
    let outers = diagram.outers.iter().map(|one| (&one.head, true));
    let transitions = diagram.transitions.iter().map(|one| (&one.head, false));
    let places = diagram.places.iter().map(|one| (&one.head, false));
    let fault = |(head, is_outer): (&Head, bool)| {
        let address = head.address?;
        if spelling.relay(address, is_outer).is_some() {
            return None;
        }
        let message = format!("{} = {address}: {whose} no such relay", head.name);
        let (file, code) = (&diagram.file, Code::NetAddress);
        Some(Diagnostic::line(code, file, head.line, "", message, help))
    };
    let faults: Vec<Diagnostic> =
        outers.chain(transitions).chain(places).filter_map(fault).collect();
    if faults.is_empty() { Ok(()) } else { Err(faults) }
}
