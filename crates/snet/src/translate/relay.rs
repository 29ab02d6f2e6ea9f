//! The names of a net's relays in each code format.

use super::list::Operand;
use crate::address::{Address, Area};
use crate::{Diagram, Head, Kind};
use scanbound_base::code::Code;
use scanbound_base::diagnostic::Diagnostic;

/// A code format, by its notation of relays.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Spelling {
    /// C200H: word and bit.
    C200h,
    /// CS, CJ and CP: internal relays keep word and bit, holding relays are H, link relays are CIO 1000 and above; only
    /// special relays with a predefined symbol can be used.
    Cx,
    /// MELSEC: a relay's number is its word times 16 plus its bit; internal relays are M, holding relays L, link relays
    /// B, and internal relays of outer gates X.
    Melsec,
}

/// Special relays of the C200H, with the predefined symbols of the same meaning.
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

    /// A relay in the notation of the code; `None` if these CPUs do not have it.
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

    /// A relay as reports write it: area name, word and bit.
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

/// An operand in the notation of the code.
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

/// One error for each relay that the CPUs do not have; `whose` names the CPUs.
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
