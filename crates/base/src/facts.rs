//! What the user states about the plant and the source does not say: ranges of words, interrupts a scan, points, networks.

mod calls;
mod places;
mod reader;

use crate::code::Code;
use crate::diagnostic::Diagnostic;
use crate::time::Picos;
use places::Places;
use std::collections::BTreeMap;

pub use calls::{StatedCall, key, plain};
pub use places::Part;
pub use reader::TABLES;

/// The user's statements. They are believed: a wrong one can make the bound too low, so reports list them.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Facts {
    /// The file that they were read from, if from one: its name and the SHA-256 of its bytes.
    pub read_from: Option<(String, String)>,
    /// Device as written (`D100`) to the least and the largest value that it holds when the scan starts, signed.
    pub ranges: BTreeMap<String, (i64, i64)>,
    /// Place as written (`MAIN.csv:543`) to the least and the largest count that an instruction there has, wherever it is
    /// executed: a loop's iterations, a block's length. Or a word (`D100`): wherever it counts.
    pub counts: BTreeMap<String, (i64, i64)>,
    /// Routine that is not among the files, as [`plain`] has its name (`P153`), to what is known of it.
    pub calls: BTreeMap<String, StatedCall>,
    /// Interrupt label in upper case (`I0`) to how often its routine runs in one scan at most.
    pub interrupts: BTreeMap<String, u32>,
    /// Interrupt label in upper case (`I28`) to how often it comes: once in each such interval.
    pub intervals: BTreeMap<String, Picos>,
    /// Input points that the CPU refreshes.
    pub inputs: Option<u32>,
    /// Output points that the CPU refreshes.
    pub outputs: Option<u32>,
    /// The kind of base unit that all modules sit on, as timing tables name it (`main`).
    pub base: Option<String>,
    /// Input points and output points by base; empty where a side has one number only. The number is their sum.
    pub by_base: [BTreeMap<String, u32>; 2],
    /// What the refresh of networks takes in one scan at most; zero if there is none.
    pub network: Option<Picos>,
    /// The factor on the whole scan, in place of the table's.
    pub factor: Option<StatedFactor>,
    /// Whether the CPU stops at an operation error, or goes on with the next instruction: a parameter of some CPUs.
    pub stops_on_error: Option<bool>,
    /// The constant or minimum scan time that the CPU's parameters set; zero if they set none.
    pub constant_scan: Option<Picos>,
    /// The watchdog's time that the CPU's parameters set.
    pub watchdog: Option<Picos>,
    /// Whether a flowchart PC reads its inputs once a pass, into an image, instead of at each test.
    pub latched: Option<bool>,
    /// How many bits an index to file registers and extended data registers has, 16 or 32: a parameter of some CPUs.
    pub index_bits: Option<u32>,
    /// The only devices that are written through an indirect address (`@D0`), each as written: from the first to the last
    /// (`ZR1000-ZR1999`), or one.
    pub indirect: Option<Vec<String>>,
    /// What an index is where something is written by it, at a place (`MAIN.csv:924`) or wherever a register is the index
    /// (`Z0`): the least and the largest.
    pub indices: BTreeMap<String, (i64, i64)>,
    /// Devices that others than the program write between scans, such as HMIs: each as `D100`, or `D100-D199`.
    pub external: Vec<String>,
    /// Devices that nobody but the program writes, likewise.
    pub internal: Vec<String>,
    /// Sets of bits of which no two are on when a scan starts, each bit as written.
    pub exclusive: Vec<Vec<String>>,
    /// Whether scans after a download or a change in RUN count, when memory may hold anything.
    pub download: bool,
    /// Whether of transitions of a chart that compete for a step, and of which one has no priority, all clear whose conditions
    /// are true.
    pub all_clear: bool,
    /// In which order a chart's actions are carried out in one scan, where that is known.
    pub action_order: Option<ActionOrder>,
    /// Where they stand.
    pub places: Places,
}

/// In which order the actions of a chart that run in one scan are carried out.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ActionOrder {
    /// As the chart first names them.
    Named,
    /// Boolean variables first, then actions as they are declared.
    Declared,
    /// By their names; those that have ended, which are carried out once more, before the others.
    Alphabetical,
}

impl ActionOrder {
    /// All.
    pub const ALL: [ActionOrder; 3] =
        [ActionOrder::Named, ActionOrder::Declared, ActionOrder::Alphabetical];

    /// As facts files write it.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            ActionOrder::Named => "named",
            ActionOrder::Declared => "declared",
            ActionOrder::Alphabetical => "alphabetical",
        }
    }
}

/// How often an interrupt routine runs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum HowOften {
    /// So many times in a scan at most.
    Times(u32),
    /// Once in each interval of this length, which is above 0.
    Every(Picos),
}

impl std::str::FromStr for HowOften {
    type Err = ();
    fn from_str(text: &str) -> Result<HowOften, ()> {
        if let Ok(times) = text.parse() {
            return Ok(HowOften::Times(times));
        }
        let time: Picos = text.parse().map_err(|_| ())?;
        if time > Picos::ZERO { Ok(HowOften::Every(time)) } else { Err(()) }
    }
}

/// A factor on the whole scan that the user states.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct StatedFactor {
    /// In millionths, at least a million.
    pub millionths: u64,
    /// As written.
    pub text: String,
}

impl Facts {
    /// How often an interrupt routine runs in one scan at most, if that is stated; letter case does not count.
    #[must_use]
    pub fn interrupt(&self, label: &str) -> Option<u32> {
        self.interrupts.get(&label.to_ascii_uppercase()).copied()
    }

    /// States how often an interrupt routine runs, whatever a file says: so many times in a scan, or once in each interval.
    pub fn state_interrupt(&mut self, label: &str, often: HowOften) {
        self.places.forget("interrupts", label);
        let label = label.to_ascii_uppercase();
        self.interrupts.remove(&label);
        self.intervals.remove(&label);
        match often {
            HowOften::Times(times) => _ = self.interrupts.insert(label, times),
            HowOften::Every(interval) => _ = self.intervals.insert(label, interval),
        }
    }

    /// A finding about the fact of this table and key, at its place in the file if it stands in one.
    #[must_use]
    pub fn fault(
        &self,
        fact: [&str; 2],
        part: Part,
        code: Code,
        message: impl Into<String>,
        help: &str,
    ) -> Diagnostic {
        self.places.fault(fact, part, code, message.into(), help)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_fact_is_read() {
        let text = "[ranges]\nD100 = [0, 10]\n'Z0' = [-1, 0x1F]\n[counts]\n'A.csv:7' = [0, 9]\n'A.csv:9' = 3\n[calls]\np007 = { time = '2us', writes = ['D1-D9'] }\n[index]\nbits = 32\nindirect = ['D1-D9', 'W5']\nZ3 = [-4, 9]\n[interrupts]\nI0 = 2\nI28 = '4ms'\n[io]\ninputs = 64\noutputs = 32\nlatched = true\nbase = 'Main'\n[network]\nrefresh = '1.5ms'\n[scan]\nfactor = 1.05\nconstant = 'none'\nwatchdog = '0.5s'\non_error = 'continue'\n[external]\ndevices = ['D5']\n[internal]\ndevices = ['M1-M9']\n[exclusive]\nsets = [['X1', 'X2'], ['M1', 'M2', 'M3']]\n[start]\ndownload = true\n[sfc]\nselection = 'all'\naction_order = 'alphabetical'\n";
        let facts = Facts::parse("facts.toml", text).expect("the facts are well-formed");
        let writes = Some(vec!["D1-D9".to_owned()]);
        let call = StatedCall { name: "p007".to_owned(), time: Picos(2_000_000), writes };
        assert_eq!(
            facts,
            Facts {
                read_from: Some(("facts.toml".to_owned(), sha256(text.as_bytes()))),
                ranges: [("D100".to_owned(), (0, 10)), ("Z0".to_owned(), (-1, 31))].into(),
                counts: [("A.csv:7".to_owned(), (0, 9)), ("A.csv:9".to_owned(), (3, 3))].into(),
                calls: [("P7".to_owned(), call)].into(),
                index_bits: Some(32),
                indirect: Some(vec!["D1-D9".to_owned(), "W5".to_owned()]),
                indices: [("Z3".to_owned(), (-4, 9))].into(),
                external: vec!["D5".to_owned()],
                internal: vec!["M1-M9".to_owned()],
                exclusive: [&["X1", "X2"][..], &["M1", "M2", "M3"]]
                    .map(|set| set.iter().map(|one| (*one).to_owned()).collect())
                    .into(),
                download: true,
                all_clear: true,
                action_order: Some(ActionOrder::Alphabetical),
                interrupts: [("I0".to_owned(), 2)].into(),
                intervals: [("I28".to_owned(), Picos(4_000_000_000))].into(),
                inputs: Some(64),
                outputs: Some(32),
                base: Some("main".to_owned()),
                by_base: Default::default(),
                network: Some(Picos(1_500_000_000)),
                factor: Some(StatedFactor { millionths: 1_050_000, text: "1.05".to_owned() }),
                stops_on_error: Some(false),
                constant_scan: Some(Picos::ZERO),
                watchdog: Some(Picos(500_000_000_000)),
                latched: Some(true),
                places: facts.places.clone(),
            }
        );
        assert_eq!((facts.interrupt("i0"), facts.interrupt("I1")), (Some(2), None));
        let read_from = Some(("facts.toml".to_owned(), sha256(b"")));
        let empty = Facts { read_from, places: Places::new("facts.toml", ""), ..Facts::default() };
        assert_eq!(Facts::parse("facts.toml", ""), Ok(empty));
    }

    #[test]
    fn points_are_stated_by_base_too_and_no_network_is_none() {
        let text = "[io]\ninputs = { main = 32, Extension = 16 }\n[network]\nrefresh = 'none'\n[scan]\nfactor = 2\n";
        let facts = Facts::parse("facts.toml", text).expect("facts");
        assert_eq!((facts.inputs, facts.outputs), (Some(48), None));
        let bases = [("main".to_owned(), 32), ("extension".to_owned(), 16)];
        assert_eq!(facts.by_base, [bases.into(), BTreeMap::new()]);
        assert_eq!(facts.network, Some(Picos::ZERO));
        assert_eq!(facts.factor.map(|factor| factor.millionths), Some(2_000_000));
        for wrong in [
            "[network]\nrefresh = 5",
            "[network]\nrefresh = '11s'",
            "[network]\nrefresh = '-1ms'",
            "[network]\ntime = '1ms'",
            "[scan]\nfactor = 0.9",
            "[scan]\nfactor = 11",
            "[scan]\nfactor = 1e1",
            "[io]\nbase = 1",
            "[io]\ninputs = { main = -1 }",
            "[io]\ninputs = { a = 4294967295, b = 1 }",
        ] {
            let faults = Facts::parse("facts.toml", wrong).expect_err(wrong);
            assert_eq!(faults.iter().map(|fault| fault.line).collect::<Vec<_>>(), [Some(2)]);
        }
    }

    #[test]
    fn faults_found_later_mark_the_key_or_the_value() {
        let long = " ".repeat(1000);
        let text = format!("[ranges]\r\n\"D 1\" = [3, 4]\r\nD2 ={long}[5, 6]\r\n");
        let facts = Facts::parse("facts.toml", &text).expect("facts");
        let marked = |key, part| {
            let fault = facts.fault(["ranges", key], part, Code::Fact, "wrong", "help");
            let (from, to) = fault.span.expect("a span");
            (fault.line, fault.text[from..to].to_owned())
        };
        assert_eq!(marked("D 1", Part::Key), (Some(2), "\"D 1\"".to_owned()));
        assert_eq!(marked("D 1", Part::Value), (Some(2), "[3, 4]".to_owned()));
        assert_eq!(marked("D2", Part::Value), (Some(3), "[5, 6]".to_owned()));
        let unknown = facts.fault(["ranges", "D3"], Part::Key, Code::Fact, "wrong", "help");
        assert_eq!((unknown.file.as_str(), unknown.line), ("", None));
    }

    #[test]
    fn many_faults_are_counted() {
        let text: String = (0..500).map(|n| format!("[a{n}]\n")).collect();
        let faults = Facts::parse("facts.toml", &text).expect_err("500 faults");
        assert_eq!(faults.len(), MOST_FAULTS + 1);
        assert_eq!(faults[MOST_FAULTS].message, "and 400 further faults, not listed");
    }

    #[test]
    fn all_faults_are_told_at_once_in_order() {
        let text = "speed = 3\n[ranges]\nD1 = [3, 1]\nD2 = 5\n[interrupts]\nI0 = -1\n[io]\nmodules = 3\nlatched = 1\n";
        let faults = Facts::parse("facts.toml", text).expect_err("six faults");
        let told: Vec<(Option<u32>, &str)> =
            faults.iter().map(|fault| (fault.line, fault.message.as_str())).collect();
        assert_eq!(
            told,
            [
                (Some(1), "'speed' is not a fact"),
                (Some(3), "the range of D1 is empty: 3 is above 1"),
                (Some(4), "the range of D2 is not two whole numbers"),
                (Some(6), "I0 is not a whole number from 0 on"),
                (Some(8), "'modules' is not known in [io]"),
                (Some(9), "latched is true or false"),
            ]
        );
        assert_eq!(faults[1].text, "D1 = [3, 1]");
        assert_eq!(faults[1].span, Some((5, 11)));
    }

    #[test]
    fn what_is_not_toml_is_told_with_its_line() {
        let faults =
            Facts::parse("facts.toml", "[ranges]\nD1 = [0, 1\nD2 == 3\n").expect_err("not TOML");
        assert!(faults.iter().all(|fault| fault.line.is_some()));
        assert!(faults.iter().any(|fault| fault.message.starts_with("not TOML")));
    }
}
