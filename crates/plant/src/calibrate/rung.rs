//! How copies of an instruction are placed in rungs.

use super::{Language, Spare};

/// A placeholder for a label that each copy needs for itself.
pub const LABEL: &str = "?";
/// A placeholder for the label of the routine.
pub const ROUTINE: &str = "!";

/// Rungs with copies of an instruction.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Rung {
    /// How a rung begins.
    pub open: Vec<String>,
    /// The lines before each copy.
    pub before: Vec<String>,
    /// The lines behind each copy.
    pub after: Vec<String>,
    /// How a rung ends.
    pub close: Vec<String>,
    /// A routine behind the end of the program that copies call.
    pub routine: Vec<String>,
    /// Whether the instruction acts on an edge. Then its relay changes in each iteration, while the state of the step
    /// is on.
    pub changes: bool,
}

fn lines<const N: usize>(lines: [&str; N]) -> Vec<String> {
    lines.map(str::to_owned).to_vec()
}

impl Rung {
    /// Copies behind one contact, one below the other.
    #[must_use]
    pub fn action(language: Language) -> Rung {
        Rung { open: vec![format!("LD {}", language.state())], ..Rung::default() }
    }

    /// Copies in series behind a contact that is always on, before a coil.
    #[must_use]
    pub fn series(language: Language) -> Rung {
        let open = vec![format!("LD {}", language.always())];
        Rung { open, close: vec![coil(language)], ..Rung::default() }
    }

    /// Each copy begins a rung that ends in a coil.
    #[must_use]
    pub fn start(language: Language) -> Rung {
        Rung { after: vec![coil(language)], ..Rung::default() }
    }

    /// The three kinds of plain rungs.
    pub(super) fn plain(language: Language) -> [Rung; 3] {
        [Rung::action(language), Rung::series(language), Rung::start(language)]
    }

    /// The same rungs with a relay that changes in each iteration.
    #[must_use]
    pub(super) fn on_edges(self, language: Language) -> Rung {
        let relay = |line: String| match line == format!("LD {}", language.state()) {
            true => format!("LD {}", language.changing()),
            false => line,
        };
        let open = self.open.into_iter().map(relay).collect();
        Rung { open, changes: true, ..self }
    }

    /// Whether a rung contains only the contact of the step's state and copies.
    #[must_use]
    pub(super) fn is_action(&self, language: Language) -> bool {
        *self == Rung::action(language)
    }

    /// The instructions that are executed with each copy of a line, except the measured one and labels.
    pub(super) fn besides(&self, line: &str, own: &str) -> Vec<String> {
        let copy = self.before.iter().map(String::as_str).chain([line]);
        let all = copy.chain(self.after.iter().chain(&self.routine).map(String::as_str));
        let is_label = |one: &str| ["P?", "P!"].contains(&one);
        all.filter(|one| *one != own && !is_label(one)).map(str::to_owned).collect()
    }

    /// Whether each copy needs its own label.
    #[must_use]
    pub(super) fn labels(&self) -> bool {
        self.before.iter().chain(&self.after).any(|line| line.contains(LABEL))
    }

    /// This many rungs with this many copies of a line each. `label` returns an unused label; `routine` is the label of
    /// the routine.
    pub(super) fn lines(
        &self,
        line: &str,
        [rungs, copies]: [u64; 2],
        routine: u32,
        mut label: impl FnMut() -> u32,
    ) -> Vec<String> {
        let mut lines = Vec::new();
        let routine = routine.to_string();
        for _ in 0..rungs {
            lines.extend(self.open.iter().cloned());
            for _ in 0..copies {
                let own = if self.labels() { label().to_string() } else { String::new() };
                let copy = self.before.iter().map(String::as_str).chain([line]);
                let copy = copy.chain(self.after.iter().map(String::as_str));
                lines.extend(copy.map(|line| line.replace(LABEL, &own).replace(ROUTINE, &routine)));
            }
            lines.extend(self.close.iter().cloned());
        }
        lines
    }
}

/// The coil of rungs that need one.
fn coil(language: Language) -> String {
    format!("OUT {}", language.coil())
}

/// An instruction that needs special rungs.
#[derive(Debug, Clone)]
pub(super) struct Special {
    /// The instruction in the rungs, by which it is found.
    pub(super) own: String,
    /// The line that is copied. It differs from the instruction only if that is in a routine.
    pub(super) line: String,
    /// The rungs.
    pub(super) rung: Rung,
    /// How often a copy executes it.
    pub(super) runs: u64,
}

fn one(line: &str, rung: Rung) -> Vec<Special> {
    vec![Special { own: line.to_owned(), line: line.to_owned(), rung, runs: 1 }]
}

/// The number of iterations of a loop that measures `NEXT`.
const TURNS: u32 = 64;

/// The instructions with special rungs.
#[must_use]
pub(super) fn special_names(language: Language) -> &'static [&'static str] {
    match language {
        Language::Cs => {
            &["ANDLD", "ORLD", "IL", "ILC", "JMP", "JME", "SBS", "SBN", "RET", "FOR", "NEXT"]
        }
        Language::Q | Language::Fx => &[
            "ANB", "ORB", "MPS", "MRD", "MPP", "MC", "MCR", "CJ", "CALL", "FOR", "NEXT", "OUT:T",
            "OUT:C", "PLS", "PLF", "LDP", "LDF", "ANDP", "ANDF", "ORP", "ORF",
        ],
    }
}

/// The rungs of an instruction that occurs only together with others, or that acts on an edge. Empty if plain rungs
/// suffice. `variant` distinguishes coils of timers and counters from others.
#[must_use]
pub(super) fn special(
    name: &str,
    variant: Option<&str>,
    language: Language,
    spare: &Spare,
) -> Vec<Special> {
    let common = match name {
        "FOR" => {
            let rung = Rung { after: lines(["NEXT"]), ..Rung::default() };
            one(&format!("FOR {}", language.number(1)), rung)
        }
        "NEXT" => {
            let before = vec![format!("FOR {}", language.number(TURNS))];
            let mut next = one("NEXT", Rung { before, ..Rung::default() });
            next.iter_mut().for_each(|next| next.runs = TURNS.into());
            next
        }
        _ => Vec::new(),
    };
    match language {
        _ if !common.is_empty() => common,
        Language::Cs => omron(name, language),
        Language::Q | Language::Fx => melsec(name, variant, language, spare),
    }
}

fn melsec(name: &str, variant: Option<&str>, language: Language, spare: &Spare) -> Vec<Special> {
    let state = language.state();
    let [ld, and, or] = ["LD", "AND", "OR"].map(|contact| format!("{contact} {state}"));
    let (action, series, coil) = (Rung::action(language), Rung::series(language), coil(language));
    let changing = language.changing();
    let mc = "MC N0 M993".to_owned();
    match (name, variant) {
        // A block of one contact would become a plain contact in a conversion.
        ("ANB", _) => one(name, Rung { before: vec![ld, or], ..series }),
        ("ORB", _) => one(name, Rung { before: vec![ld, and], ..series }),
        ("MPS", _) => {
            let after = vec![and.clone(), coil, "MPP".to_owned(), and];
            one(name, Rung { after, ..series })
        }
        ("MPP", _) => {
            let before = vec!["MPS".to_owned(), and.clone(), coil];
            one(name, Rung { before, after: vec![and], ..series })
        }
        ("MRD", _) => {
            let first = ["MPS".to_owned(), and.clone(), coil.clone()];
            let open = [series.open, first.to_vec()].concat();
            let close = vec!["MPP".to_owned(), and.clone(), coil.clone()];
            one(name, Rung { open, after: vec![and, coil], close, ..Rung::default() })
        }
        ("MC", _) => {
            one(&mc, Rung { before: vec![ld], after: lines(["MCR N0"]), ..Rung::default() })
        }
        ("MCR", _) => one("MCR N0", Rung { before: vec![ld, mc], ..Rung::default() }),
        ("CJ", _) => {
            one("CJ P?", Rung { before: vec![ld], after: lines(["P?"]), ..Rung::default() })
        }
        ("CALL", _) => one("CALL P!", Rung { routine: lines(["P!", "RET"]), ..action }),
        ("RET" | "SRET", _) => {
            let routine = vec!["P!".to_owned(), name.to_owned()];
            let (own, line) = (name.to_owned(), "CALL P!".to_owned());
            vec![Special { own, line, rung: Rung { routine, ..action }, runs: 1 }]
        }
        // One that is always running, and one that is over after a tenth of a second.
        ("OUT", Some("T")) => ["OUT T0 K32767", "OUT T0 K1"]
            .iter()
            .flat_map(|line| one(line, action.clone()))
            .collect(),
        // One that counts at each edge, and one that has reached its end.
        ("OUT", Some("C")) => {
            let edges = action.clone().on_edges(language);
            let [counting, ended] = ["OUT C0 K32767", "OUT C0 K1"];
            [one(counting, edges), one(ended, action)].concat()
        }
        ("PLS" | "PLF", _) => one(&format!("{name} M994"), action.on_edges(language)),
        ("LDP" | "LDF" | "LDPI" | "LDFI", _) => {
            one(&format!("{name} {changing}"), Rung::start(language).on_edges(language))
        }
        ("ANDP" | "ANDF" | "ORP" | "ORF" | "ANDPI" | "ANDFI" | "ORPI" | "ORFI", _) => {
            one(&format!("{name} {changing}"), series.on_edges(language))
        }
        ("FROM" | "TO" | "DFRO" | "DTO", _) => {
            let Some((unit, address)) = spare.module() else { return Vec::new() };
            let head = match language {
                Language::Fx => format!("K{unit}"),
                _ => format!("H{unit:X}"),
            };
            // It writes back what was just read from the same place.
            let first = match name {
                "TO" => Some(format!("FROM {head} K{address} D0 K32")),
                "DTO" => Some(format!("FROM {head} K{address} D0 K64")),
                _ => None,
            };
            let before = first.map(|first| [format!("LD {}", language.always()), first]);
            let open = before.into_iter().flatten().chain(action.open.clone()).collect();
            let rung = Rung { open, ..Rung::default() };
            let line = |count: u32| format!("{name} {head} K{address} D0 K{count}");
            [1, 32].iter().flat_map(|count| one(&line(*count), rung.clone())).collect()
        }
        _ => Vec::new(),
    }
}

fn omron(name: &str, language: Language) -> Vec<Special> {
    let state = language.state();
    let [ld, and, or] = ["LD", "AND", "OR"].map(|contact| format!("{contact} {state}"));
    let (action, series) = (Rung::action(language), Rung::series(language));
    let within = |before: Vec<String>, after: &[&str]| {
        let after = after.iter().map(|line| (*line).to_owned()).collect();
        Rung { before, after, ..Rung::default() }
    };
    match name {
        "ANDLD" => one(name, Rung { before: vec![ld, or], ..series }),
        "ORLD" => one(name, Rung { before: vec![ld, and], ..series }),
        "IL" => one(name, within(vec![ld], &["ILC"])),
        "ILC" => one(name, within(vec![ld, "IL".to_owned()], &[])),
        "JMP" => one("JMP &?", within(vec![ld], &["JME &?"])),
        "JME" => one("JME &?", within(vec![ld, "JMP &?".to_owned()], &[])),
        "SBS" | "SBN" | "RET" => {
            let own = if name == "RET" { name.to_owned() } else { format!("{name} !") };
            let rung = Rung { routine: lines(["SBN !", "RET"]), ..action };
            vec![Special { own, line: "SBS !".to_owned(), rung, runs: 1 }]
        }
        "TIM" => ["TIM 0 #9999", "TIM 0 #0001"]
            .iter()
            .flat_map(|line| one(line, action.clone()))
            .collect(),
        _ => Vec::new(),
    }
}
