//! The text of calibration programs for each family of CPUs.

use std::fmt::Write;

/// The families for which programs are written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Language {
    /// MELSEC-Q, L, iQ-R and FX5, with special registers.
    Q,
    /// MELSEC-F.
    Fx,
    /// OMRON CS, CJ and CP.
    Cs,
}

/// The word with the number of the step that is being measured.
pub const STEP: u32 = 1000;
/// The first word of the results, two words per step.
pub const RESULTS: u32 = 1100;
/// The label behind the rungs at the beginning that store results. Number 0 has a special meaning in the C series.
const HEAD: u32 = 1;
/// The label before the end, to which scans jump that run no block.
const LAST_LABEL: u32 = 2;
/// The number of scans of the current step.
const SCAN: u32 = 1001;
/// The smallest and the largest reading of the current step.
const SMALLEST: u32 = 1002;
const LARGEST: u32 = 1003;
/// The time of the last scan, in tenths of a millisecond.
const LAST: u32 = 1010;
/// The scans at the beginning of a step whose readings do not count, because they may belong to the step before.
pub const SETTLING: u32 = 2;

impl Language {
    /// The language for a family of timing tables.
    #[must_use]
    pub fn of(family: &str) -> Option<Language> {
        match family {
            "q" | "l" | "iqr" | "fx5" => Some(Language::Q),
            "fx" => Some(Language::Fx),
            "cs" => Some(Language::Cs),
            _ => None,
        }
    }

    /// The dialect of its lines.
    #[must_use]
    pub fn dialect(self) -> &'static str {
        match self {
            Language::Q | Language::Fx => "melsec-list",
            Language::Cs => "omron-cx",
        }
    }

    /// The relay that is on in steps that measure on-times, and off in those for off-times.
    #[must_use]
    pub fn state(self) -> &'static str {
        match self {
            Language::Q | Language::Fx => "M990",
            Language::Cs => "W501.00",
        }
    }

    /// The coil of rungs that need one.
    #[must_use]
    pub fn coil(self) -> &'static str {
        match self {
            Language::Q | Language::Fx => "M991",
            Language::Cs => "W501.01",
        }
    }

    /// The relay that changes in each iteration if edges are measured.
    #[must_use]
    pub fn changing(self) -> &'static str {
        match self {
            Language::Q | Language::Fx => "M992",
            Language::Cs => "W501.02",
        }
    }

    /// Rungs that change it while the state of the step is on.
    pub(super) fn changes(self) -> [String; 3] {
        let not = if self == Language::Cs { "ANDNOT" } else { "ANI" };
        let relay = self.changing();
        [format!("LD {}", self.state()), format!("{not} {relay}"), format!("OUT {relay}")]
    }

    /// The relay that is on in the scan that stores a step's readings.
    fn stores(self) -> &'static str {
        match self {
            Language::Q | Language::Fx => "M995",
            Language::Cs => "W501.05",
        }
    }

    /// The relay that is always on.
    #[must_use]
    pub fn always(self) -> &'static str {
        match self {
            Language::Q => "SM400",
            Language::Fx => "M8000",
            Language::Cs => "P_On",
        }
    }

    /// A constant.
    pub(super) fn number(self, number: u32) -> String {
        match self {
            Language::Q | Language::Fx => format!("K{number}"),
            Language::Cs => format!("&{number}"),
        }
    }

    /// Sixteen bits.
    #[must_use]
    pub fn bits(self, word: u16) -> String {
        match self {
            Language::Q | Language::Fx => format!("H{word:X}"),
            Language::Cs => format!("#{word:X}"),
        }
    }

    /// The beginning and the end of a loop.
    #[must_use]
    pub fn looped(self, times: u32) -> [String; 2] {
        [format!("FOR {}", self.number(times)), "NEXT".to_owned()]
    }

    /// A contact that compares a word.
    fn compares(self, contact: &str, word: u32, number: u32) -> String {
        format!("{contact} D{word} {}", self.number(number))
    }

    /// Rungs that copy the last scan time into a word.
    fn reads(self) -> Vec<String> {
        let lines: &[&str] = match self {
            Language::Q => &[
                "LD SM400",
                "MOV SD520 D1004",
                "MOV SD521 D1005",
                "* D1004 K10 D1006",
                "/ D1005 K100 D1008",
                "+ D1006 D1008 D1010",
            ],
            Language::Fx => &["LD M8000", "MOV D8010 D1010"],
            Language::Cs => &["LD P_On", "MOV A264 D1010"],
        };
        lines.iter().map(|line| (*line).to_owned()).collect()
    }

    /// A rung that initialises these words in the first scan.
    fn begins(self, words: &[(u32, u32)]) -> Vec<String> {
        let mut lines: Vec<String> = match self {
            Language::Q => vec!["LD SM402".to_owned()],
            Language::Fx => vec!["LD M8002".to_owned()],
            // This relay is off whenever the CPU starts.
            Language::Cs => vec!["LDNOT W500.00".to_owned()],
        };
        lines.extend(words.iter().map(|(word, number)| self.moves(*number, *word)));
        if self == Language::Cs {
            lines.push("SET W500.00".to_owned());
        }
        lines
    }

    fn moves(self, number: u32, word: u32) -> String {
        format!("MOV {} D{word}", self.number(number))
    }

    fn counts(self, word: u32) -> String {
        match self {
            Language::Q | Language::Fx => format!("INC D{word}"),
            Language::Cs => format!("++ D{word}"),
        }
    }

    /// The label of the block with this number.
    #[must_use]
    pub fn label(self, number: u32) -> u32 {
        // They follow those of the head and the end. On the FX, P63 is the end of the program.
        let label = LAST_LABEL + 1 + number;
        if self == Language::Fx && label >= 63 { label + 1 } else { label }
    }

    /// Rungs before and behind a section that is skipped unless the step is one of these.
    #[must_use]
    pub fn only(self, first: u32, last: u32, label: u32) -> [Vec<String>; 2] {
        match self {
            Language::Q | Language::Fx => [
                vec![
                    self.compares("LD<", STEP, first),
                    self.compares("OR>", STEP, last),
                    format!("CJ P{label}"),
                ],
                vec![format!("P{label}")],
            ],
            Language::Cs => [
                vec![
                    self.compares("LD>=", STEP, first),
                    self.compares("AND<=", STEP, last),
                    format!("JMP {}", self.number(label)),
                ],
                vec![format!("JME {}", self.number(label))],
            ],
        }
    }

    /// A contact that is on from this step on.
    #[must_use]
    pub fn from_step(self, step: u32) -> String {
        self.compares("LD>=", STEP, step)
    }

    /// A contact that is on at this step.
    #[must_use]
    pub fn at_step(self, step: u32) -> String {
        self.compares("LD=", STEP, step)
    }

    /// The rungs before the blocks: they read the scan time, keep the smallest and largest value for each of `steps`
    /// steps over `scans` scans, and then start the next step.
    #[must_use]
    pub fn head(self, empty: u32, steps: u32, scans: u32) -> Vec<String> {
        const NOTHING: [(u32, u32); 3] = [(SCAN, 0), (SMALLEST, 32_767), (LARGEST, 0)];
        let settled = SETTLING + 1;
        let mut lines = self.reads();
        lines.extend(self.begins(&[&[(STEP, 0)][..], &NOTHING].concat()));
        lines.push(format!("LD {}", self.always()));
        lines.push(self.counts(SCAN));
        for (relation, kept) in [("<", SMALLEST), (">", LARGEST)] {
            lines.push(self.compares("LD>=", SCAN, settled));
            lines.push(format!("AND{relation} D{LAST} D{kept}"));
            lines.push(format!("MOV D{LAST} D{kept}"));
        }
        lines.push(self.compares("LD>=", SCAN, SETTLING + scans));
        lines.push(self.compares("AND<", STEP, steps));
        lines.push(format!("OUT {}", self.stores()));
        match self {
            Language::Q | Language::Fx => {
                lines.push(format!("LDI {}", self.stores()));
                lines.push(format!("CJ P{HEAD}"));
            }
            Language::Cs => {
                lines.push(format!("LD {}", self.stores()));
                lines.push(format!("JMP {}", self.number(HEAD)));
            }
        }
        for step in 0..steps {
            lines.push(self.at_step(step));
            lines.push(format!("MOV D{SMALLEST} D{}", RESULTS + 2 * step));
            lines.push(format!("MOV D{LARGEST} D{}", RESULTS + 2 * step + 1));
        }
        lines.push(format!("LD {}", self.always()));
        lines.push(self.counts(STEP));
        lines.extend(NOTHING.iter().map(|(word, number)| self.moves(*number, *word)));
        lines.push(match self {
            Language::Q | Language::Fx => format!("P{HEAD}"),
            Language::Cs => format!("JME {}", self.number(HEAD)),
        });
        // The first steps measure an empty scan.
        let [skip, _] = self.only(empty, 32_767, LAST_LABEL);
        lines.extend(skip);
        lines
    }

    /// The lines behind the blocks: routines that they call.
    #[must_use]
    pub fn tail(self, routines: &[String]) -> Vec<String> {
        let end = |name: &str| vec![name.to_owned()];
        let (label, before) = match self {
            Language::Q | Language::Fx => (format!("P{LAST_LABEL}"), end("FEND")),
            Language::Cs => (format!("JME {}", self.number(LAST_LABEL)), Vec::new()),
        };
        [vec![label], before, routines.to_vec(), end("END")].concat()
    }

    /// An upper estimate of the steps of program memory that a line takes.
    #[must_use]
    pub fn size(self, line: &str) -> u32 {
        let words = u32::try_from(line.split_whitespace().count()).unwrap_or(u32::MAX);
        match (self, line.split_whitespace().next().unwrap_or_default()) {
            (_, "OUT" | "LD" | "LDI" | "AND" | "ANI" | "OR" | "ORI" | "NOP" | "INV") => 1,
            (_, "ANB" | "ORB" | "MPS" | "MRD" | "MPP") => 1,
            // With 16-bit operations, the name takes one step and each operand two; otherwise one and four.
            (Language::Fx, _) => 1 + 4 * words.saturating_sub(1),
            (Language::Q, _) => words + 1,
            (Language::Cs, _) => words + 1,
        }
    }

    /// The devices that the program writes, as text.
    #[must_use]
    pub fn writes(self, steps: u32) -> String {
        let last = RESULTS + 2 * steps - 1;
        let mut text = format!("D0 to D899, D{STEP} to D{LAST}, D{RESULTS} to D{last}");
        let _ = match self {
            Language::Q => write!(text, ", M0 to M999, T0, C0, Z0"),
            Language::Fx => write!(
                text,
                ", M0 to M999, T0, C0, Z0 (of these D200 and up, and M500 and up, are latched unless parameters say otherwise)"
            ),
            Language::Cs => write!(text, ", W0 to W9, W500, W501, T0 (all D are held)"),
        };
        text
    }
}
