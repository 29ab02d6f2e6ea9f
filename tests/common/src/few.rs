//! Random MELSEC lists whose words have few values: every start word is masked before it is read otherwise, and only
//! operations that manuals define are used.

use super::lines::DrawsLines;
use super::tape::Tape;
use std::fmt::Write as _;

/// The possible rows of a table: one for each mnemonic.
const MNEMONICS: &str = "LD LDI AND ANI OR ORI LDP ANDP LD= LD<> LD> LD>= LD< LD<= AND= AND<> AND> AND>= AND< AND<= \
    OUT SET RST PLS MOV + - INC DEC WAND WOR WXOR ROL ROR SFL SFR BCD BIN SUM * / BMOV FMOV XCH SWAP LIMIT DECO ENCO \
    MAX SER FOR NEXT BREAK CJ CALL RET FEND END DIS UNI BSET BRST MPS MRD MPP MC MCR CML BK+ WSUM";

/// Rows of a table with random times; those of block instructions have a time per word. Contacts have equal times.
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
    /// Whether the next lines are in a subroutine, which calls no other.
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
                // With a different count at each call.
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

/// The lines of a program that reads and writes by index. The index is set again before calls, in iterations and after
/// guards, and the cells that it selects differ. D0 is stated to be 0 to 7 when a scan starts.
pub fn indexed(tape: &mut Tape<'_>) -> Vec<String> {
    let mut g = Generator { tape, lines: Vec::new(), labels: 0, routines: 0, called: false };
    g.put("LD SM400");
    if g.tape.percent(50) {
        let mask = g.tape.pick(&["K3", "K1", "K0", "K7"]);
        g.put(format!("WAND {mask} Z0"));
    } else {
        g.put("FMOV K1 Z0 K1");
    }
    if g.tape.percent(30) {
        g.put("WAND K3 D0");
    }
    for all in ["K1 Z1 K1", "K2 D1 K16", "K2 D17 K16"] {
        g.put(format!("FMOV {all}"));
    }
    for cell in ["D12", "D13", "D14", "D16"] {
        let value = g.tape.pick(&["K1", "K0", "K3", "K5", "K4"]);
        g.put(format!("MOV {value} {cell}"));
    }
    if g.tape.percent(80) {
        let bits = g.tape.pick(&["K5", "K0", "K6", "K19"]);
        g.put(format!("MOV {bits} K4M0"));
    }
    g.index_items(0, 6);
    // The final values of the cells decide the time.
    for _ in 0..2 + g.tape.below(4) {
        g.left_over();
    }
    if g.routines > 0 {
        g.put("FEND");
        g.called = true;
        g.put(format!("P{FIRST}"));
        g.index_items(1, 4);
        g.put("RET");
    }
    g.put("END");
    g.lines
}

impl<'a> DrawsLines<'a> for Generator<'_, 'a> {
    fn tape(&mut self) -> &mut Tape<'a> {
        self.tape
    }

    fn lines(&mut self) -> &mut Vec<String> {
        &mut self.lines
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
}

impl Generator<'_, '_> {
    /// A rung that depends on the value of a cell.
    fn left_over(&mut self) {
        let contact = match self.tape.below(4) {
            0 => self.tape.pick(&["LD M2", "LDI M3", "LD M4", "LDI M1"]).to_owned(),
            _ => {
                let cell = self.tape.pick(&["D12", "D13", "D14", "D15", "D2", "D3", "D4", "D5"]);
                let relation = self.tape.pick(&["=", "<>", ">"]);
                let value = self.tape.pick(&["K5", "K2", "K3", "K1", "K0"]);
                format!("LD{relation} {cell} {value}")
            }
        };
        self.put(contact);
        self.put("SWAP D30");
    }

    fn index_items(&mut self, depth: u32, most: usize) {
        for _ in 0..1 + self.tape.below(most) {
            self.index_item(depth);
            if self.tape.done() {
                break;
            }
        }
    }

    fn index_item(&mut self, depth: u32) {
        match self.tape.below(10) {
            5 if self.called => self.index(),
            5 => {
                for _ in 0..1 + self.tape.below(3) {
                    if self.tape.percent(80) {
                        self.index();
                    }
                    if self.tape.percent(70) {
                        self.put("LD SM400");
                    } else {
                        self.index_contacts();
                    }
                    self.routines = 1;
                    self.put(format!("CALL P{FIRST}"));
                }
            }
            6 if depth < 2 => {
                let count = match self.tape.below(3) {
                    0 => "K2".to_owned(),
                    1 => "K3".to_owned(),
                    _ => {
                        let source = self.tape.pick(&["D12Z0", "D0", "D13Z1", "D3"]);
                        self.put("LD SM400");
                        self.put(format!("WAND K3 {source} D8"));
                        "D8".to_owned()
                    }
                };
                self.put(format!("FOR {count}"));
                self.index_items(depth + 1, 2);
                if self.tape.percent(80) {
                    let index = self.tape.pick(&["Z0", "Z1"]);
                    self.put("LD SM400");
                    self.put(format!("INC {index}"));
                    self.put(format!("WAND K7 {index}"));
                }
                self.put("NEXT");
            }
            7 => {
                self.index_contacts();
                let label = self.labels;
                self.labels += 1;
                self.put(format!("CJ P{label}"));
                if self.tape.percent(50) {
                    self.index();
                }
                self.accesses();
                self.put(format!("P{label}"));
            }
            8 => {
                // After the guard, its condition on the index holds.
                let word = self.tape.pick(&["D0", "D1"]);
                let least = self.tape.pick(&["K0", "K1", "K2"]);
                let most = self.tape.pick(&["K2", "K1", "K3", "K5"]);
                self.put(format!("LD>= {word} {least}"));
                self.put(format!("AND<= {word} {most}"));
                let index = self.tape.pick(&["Z0", "Z1"]);
                self.put(format!("MOV {word} {index}"));
                self.access();
            }
            9 => self.index(),
            _ => self.accesses(),
        }
    }

    /// Sets an index to a value from -2 to 7.
    fn index(&mut self) {
        let index = self.tape.pick(&["Z0", "Z0", "Z1"]);
        if self.tape.percent(50) {
            self.put("LD SM400");
        } else {
            // To one of two values.
            let value = self.tape.pick(&["K1", "K0", "K3", "D0"]);
            self.put("LD SM400");
            self.put(format!("MOV {value} {index}"));
            self.index_contacts();
        }
        let source = match self.tape.below(8) {
            0..=3 => self.tape.pick(&["K2", "K0", "K3", "K1", "K4", "K-2", "K-1"]),
            4 => self.tape.pick(&["D0", "D1"]),
            5 => {
                let word = self.tape.pick(&["D12Z0", "D13Z1", "D3"]);
                self.put(format!("WAND K3 {word} {index}"));
                return;
            }
            6 => {
                self.put(format!("+ K1 {index}"));
                self.put(format!("WAND K7 {index}"));
                return;
            }
            _ => {
                let by = self.tape.pick(&["D0", "K1", "K3"]);
                self.put(format!("* K2 {by} D6"));
                self.put(format!("WAND K7 D6 {index}"));
                return;
            }
        };
        self.put(format!("MOV {source} {index}"));
    }

    fn accesses(&mut self) {
        self.index_contacts();
        for _ in 0..1 + self.tape.below(3) {
            self.access();
        }
    }

    fn index_contacts(&mut self) {
        self.index_contact("LD");
        for _ in 0..self.tape.below(3) {
            let kind = self.tape.pick(&["AND", "AND", "OR"]);
            self.index_contact(kind);
        }
    }

    fn index_contact(&mut self, kind: &str) {
        let line = match self.tape.below(8) {
            0 | 1 => {
                let bit = self.tape.pick(&["X0", "X1", "SM400", "M2"]);
                format!("{kind} {bit}")
            }
            2 | 3 => {
                let bit = self.tape.pick(&["M0Z0", "M1Z1", "M3Z0"]);
                format!("{kind} {bit}")
            }
            4..=6 if kind != "OR" => {
                let relation = self.tape.pick(&["=", ">", "<", "<>", ">=", "<="]);
                let left = self.tape.pick(&["D12Z0", "D13Z1", "D2", "D14Z0", "Z0"]);
                let right = self.tape.pick(&["K2", "K1", "K3", "K5", "D12", "D13Z0"]);
                format!("{kind}{relation} {left} {right}")
            }
            _ => {
                let relation = self.tape.pick(&["=", ">", "<="]);
                let left = self.tape.pick(&["D0", "D12", "D3"]);
                let right = self.tape.pick(&["K2", "K1", "K0"]);
                let kind = if kind == "OR" { "AND" } else { kind };
                format!("{kind}{relation} {left} {right}")
            }
        };
        self.put(line);
    }

    /// Reads or writes by an index.
    fn access(&mut self) {
        let word = self.tape.pick(&["D2", "D3", "D4", "D5"]);
        let there = self.tape.pick(&["D12Z0", "D13Z1", "D12Z1", "D15Z0"]);
        let line = match self.tape.below(22) {
            0..=2 => {
                let value = self.tape.pick(&["K5", "K0", "K1", "K3", "D0", "D3", "D14"]);
                format!("MOV {value} {there}")
            }
            3 | 4 => format!("MOV {there} {word}"),
            5 => format!("BMOV {there} D2 {}", self.tape.pick(&["K2", "K1", "K3"])),
            6 => format!("BMOV {word} {there} {}", self.tape.pick(&["K2", "K1", "K3"])),
            7 => format!("BMOV D12Z0 D14Z1 {}", self.tape.pick(&["K2", "K1", "K3"])),
            8 => {
                let name = self.tape.pick(&["FMOV", "BMOV"]);
                self.put(format!("WAND K3 {word} D9"));
                self.put("INC D9");
                format!("{name} D3 {there} D9")
            }
            9 => format!("FMOV {word} {there} K2"),
            10 => format!("DMOV {there} D4"),
            11 => format!("DMOV D2 {there}"),
            12 => format!("{} {word} {there}", self.tape.pick(&["+", "-"])),
            13 => format!("{} {there}", self.tape.pick(&["INC", "DEC"])),
            14 => {
                let by = self.tape.pick(&["K3", "D13", "K-1"]);
                self.put(format!("* {there} {by} D6"));
                format!("MOV D6 {word}")
            }
            15 => {
                let by = self.tape.pick(&["K2", "K3", "K-2"]);
                self.put(format!("/ {there} {by} D6"));
                format!("MOV {} {word}", self.tape.pick(&["D6", "D7"]))
            }
            16 | 17 => {
                let name = self.tape.pick(&["SET", "RST", "OUT"]);
                let bit = self.tape.pick(&["M0Z0", "M1Z1", "M3Z0", "M2"]);
                format!("{name} {bit}")
            }
            18 => format!("MOV {word} {}", self.tape.pick(&["K1M0Z0", "K1M1Z1", "K2M0Z1"])),
            19 => format!("MOV {} {word}", self.tape.pick(&["K1M0Z0", "K1M1Z1", "K2M0Z1"])),
            20 => format!("XCH {word} {there}"),
            _ => format!("WAND K6 {there} {word}"),
        };
        self.put(line);
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
