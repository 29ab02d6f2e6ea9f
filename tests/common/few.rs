//! Random MELSEC lists whose words take few values: every start word is masked before it is read otherwise, and what
//! instructions work out keeps to what manuals settle.

use super::tape::Tape;
use std::fmt::Write as _;

/// What may stand in a table for them: a row for each mnemonic.
const MNEMONICS: &str = "LD LDI AND ANI OR ORI LDP ANDP LD= LD<> LD> LD>= LD< LD<= AND= AND<> AND> AND>= AND< AND<= \
    OUT SET RST PLS MOV + - INC DEC WAND WOR WXOR ROL ROR SFL SFR BCD BIN SUM * / BMOV FMOV XCH SWAP LIMIT DECO ENCO \
    MAX SER FOR NEXT BREAK CJ CALL RET FEND END DIS UNI BSET BRST MPS MRD MPP MC MCR CML BK+ WSUM";

/// Rows of a table, each with times by chance, those of blocks by the word. Contacts cost the same either way.
pub fn rows(tape: &mut Tape<'_>) -> String {
    let mut rows = String::new();
    for name in MNEMONICS.split_whitespace() {
        let on = 1 + tape.below(300);
        let off = if tape.percent(20) { on } else { tape.below(60) };
        let per_unit = if matches!(name, "BMOV" | "FMOV") { tape.below(40) } else { 0 };
        let _ = writeln!(rows, "{name},{on},{off},{per_unit}");
    }
    rows
}

struct Generator<'t, 'a> {
    tape: &'t mut Tape<'a>,
    lines: Vec<String>,
    labels: u32,
    routines: u32,
    /// Whether what comes stands in a subroutine, which calls none.
    called: bool,
}

/// The first subroutine's label.
const FIRST: u32 = 100;

/// The lines of a program.
pub fn generate(tape: &mut Tape<'_>) -> Vec<String> {
    let mut g = Generator { tape, lines: Vec::new(), labels: 0, routines: 0, called: false };
    g.put("LD SM400");
    for word in ["D0", "D1", "Z0"] {
        let mask = g.tape.pick(&["K3", "K1", "K7", "K0"]);
        g.put(format!("WAND {mask} {word}"));
    }
    let first = g.tape.pick(&["K1", "K0", "K2"]);
    g.put(format!("FMOV {first} D2 K30"));
    if g.tape.percent(30) {
        g.call();
    }
    g.items(0, 5);
    if g.routines > 0 {
        g.put("FEND");
        g.called = true;
        for routine in 0..g.routines {
            g.put(format!("P{}", FIRST + routine));
            if g.tape.percent(60) {
                // By another count at each call.
                g.put("FOR D9");
                g.items(2, 2);
                g.put("NEXT");
            } else {
                g.items(1, 2);
            }
            g.put("RET");
        }
    }
    g.put("END");
    g.lines
}

impl Generator<'_, '_> {
    fn put(&mut self, line: impl Into<String>) {
        self.lines.push(line.into());
    }

    fn items(&mut self, depth: u32, most: usize) {
        for _ in 0..1 + self.tape.below(most) {
            self.item(depth);
            if self.tape.done() {
                break;
            }
        }
    }

    fn item(&mut self, depth: u32) {
        match self.tape.below(10) {
            6 | 7 if depth < 2 => {
                let count = match self.tape.below(4) {
                    0 => "K2".to_owned(),
                    1 => self.small(),
                    2 => {
                        let word = self.small();
                        self.put("LD SM400");
                        self.put(format!("INC {word}"));
                        word
                    }
                    _ => "K1X0".to_owned(),
                };
                self.put(format!("FOR {count}"));
                if !self.called && self.tape.percent(40) {
                    self.call();
                }
                let left = self.tape.percent(25).then(|| {
                    self.labels += 1;
                    self.contacts();
                    self.put(format!("BREAK D13 P{}", self.labels - 1));
                    self.labels - 1
                });
                self.items(depth + 1, 2);
                self.put("NEXT");
                left.iter().for_each(|label| self.put(format!("P{label}")));
            }
            8 => {
                self.contacts();
                let label = self.labels;
                self.labels += 1;
                self.put(format!("CJ P{label}"));
                self.rungs();
                self.put(format!("P{label}"));
            }
            9 if depth < 2 && !self.called => self.call(),
            _ => self.rungs(),
        }
    }

    /// A call, often with a count for a loop in the subroutine.
    fn call(&mut self) {
        if self.tape.percent(70) {
            self.put("LD SM400");
            let count = self.tape.pick(&["K1", "K2", "K3", "K4"]);
            self.put(format!("MOV {count} D9"));
        } else {
            self.contacts();
        }
        let routine = u32::from(self.tape.percent(20));
        self.routines = self.routines.max(routine + 1);
        self.put(format!("CALL P{}", FIRST + routine));
    }

    fn rungs(&mut self) {
        self.contacts();
        for _ in 0..1 + self.tape.below(3) {
            self.output();
        }
    }

    /// A word that is 0 to 3 from here on, written by a rung of its own.
    fn small(&mut self) -> String {
        let target = self.tape.pick(&["D8", "D9"]);
        let source = self.word();
        self.put("LD SM400");
        self.put(format!("WAND K3 {source} {target}"));
        target.to_owned()
    }

    fn word(&mut self) -> &'static str {
        self.tape.pick(&["D0", "D1", "D2", "D3", "D4", "D5"])
    }

    fn contacts(&mut self) {
        self.contact("LD");
        for _ in 0..self.tape.below(3) {
            let kind = self.tape.pick(&["AND", "AND", "OR"]);
            self.contact(kind);
        }
    }

    fn contact(&mut self, kind: &str) {
        match self.tape.below(8) {
            0..=2 => {
                let bit = self.tape.pick(&["X0", "X1", "M0", "M1", "M2", "X2", "D2.0", "D3.1"]);
                let name = match (kind, self.tape.below(5)) {
                    ("LD", 3) => "LDI",
                    ("AND", 3) => "ANI",
                    ("OR", 3) => "ORI",
                    ("LD", 4) => "LDP",
                    ("AND", 4) => "ANDP",
                    (kind, _) => kind,
                };
                self.put(format!("{name} {bit}"));
            }
            3 => {
                let bit =
                    self.tape.pick(&["M0Z0", "SM400", "M3", "M0Z0", "SM400", "M3", "T0", "C0"]);
                self.put(format!("{kind} {bit}"));
            }
            _ if kind == "OR" => self.put("OR M1"),
            4 if self.tape.percent(10) => {
                let relation = self.tape.pick(&["=", ">", "<="]);
                let present = self.tape.pick(&["T0", "C0"]);
                let value = self.tape.pick(&["K1", "K2", "K3", "K5"]);
                self.put(format!("{kind}{relation} {present} {value}"));
            }
            _ => {
                let relation = self.tape.pick(&["=", ">", "<", "<>", ">=", "<="]);
                let left = self.word();
                let right = match self.tape.below(3) {
                    0 | 1 => self.tape.pick(&["K1", "K2", "K3", "K5", "K0", "K4", "K21"]),
                    _ => self.word(),
                };
                self.put(format!("{kind}{relation} {left} {right}"));
            }
        }
    }

    fn output(&mut self) {
        let (a, b, to) = (self.word(), self.word(), self.word());
        let line = match self.tape.below(30) {
            0 if self.tape.percent(20) => {
                let what = self.tape.pick(&["OUT T0", "OUT C0", "RST T0", "RST C0"]);
                let setting = self.tape.pick(&[" K3", " K2", " K1"]);
                format!("{what}{}", if what.starts_with('O') { setting } else { "" })
            }
            0..=2 => {
                let bit = self.tape.pick(&["M0", "M1", "M2", "M3"]);
                let name = self.tape.pick(&["OUT", "SET", "RST", "PLS"]);
                format!("{name} {bit}")
            }
            3 | 4 => format!("MOV {a} {to}"),
            5 => format!("MOV {} {to}", self.tape.pick(&["K3", "K1", "K5", "K12"])),
            6 => {
                let name = self.tape.pick(&["+", "-"]);
                format!("{name} {a} {b} {to}")
            }
            7 => {
                let name = self.tape.pick(&["INC", "DEC"]);
                format!("{name} {to}")
            }
            8 => {
                let name = self.tape.pick(&["WAND", "WOR", "WXOR"]);
                format!("{name} {a} {b} {to}")
            }
            9 | 10 => {
                let name = self.tape.pick(&["ROL", "ROR", "SFL", "SFR"]);
                format!("{name} {to} {}", self.tape.pick(&["K1", "K4"]))
            }
            11 | 12 => {
                // Four bits, so that it has two digits.
                self.put(format!("WAND K15 {a} D6"));
                self.put("BCD D6 D7");
                if self.tape.percent(50) {
                    self.put("BIN D7 D6");
                }
                format!("MOV {} {to}", self.tape.pick(&["D7", "D6"]))
            }
            13 => format!("SUM {a} {to}"),
            14 => {
                self.put(format!("* {a} {b} D10"));
                format!("MOV D10 {to}")
            }
            15 => {
                let by = self.tape.pick(&["K2", "K3"]);
                self.put(format!("/ {a} {by} D10"));
                format!("MOV {} {to}", self.tape.pick(&["D10", "D11"]))
            }
            16 | 17 => {
                self.put(format!("WAND K3 {a} D8"));
                self.put("INC D8");
                let name = self.tape.pick(&["BMOV", "FMOV"]);
                format!(
                    "{name} {} {} D8",
                    self.tape.pick(&["D0", "D1"]),
                    self.tape.pick(&["D2", "D3"])
                )
            }
            18 | 19 => match self.tape.below(4) {
                0 => format!("MOV D0Z0 {to}"),
                1 => format!("MOV {a} D2Z0"),
                2 => "SET M0Z0".to_owned(),
                _ => "RST M1Z0".to_owned(),
            },
            20 => {
                let mask = self.tape.pick(&["K1", "K0", "K3"]);
                format!("WAND {mask} {a} Z0")
            }
            21 => format!("XCH {a} {to}"),
            22 => format!("SWAP {to}"),
            23 => format!("LIMIT K1 K4 {a} {to}"),
            24 => format!("DECO {a} M0 K2"),
            25 => format!("MOV K1M0 {to}"),
            26 => format!("MOV {a} K1M0"),
            27 => {
                self.put("MAX D0 D12 K3");
                format!("MOV {} {to}", self.tape.pick(&["D12", "D13", "D14"]))
            }
            28 => {
                self.put(format!("SER {a} D0 D12 K3"));
                format!("MOV {} {to}", self.tape.pick(&["D12", "D13"]))
            }
            _ => format!("BSET {to} {}", self.tape.pick(&["K1", "K0"])),
        };
        self.put(line);
    }
}
