//! Random MELSEC lists whose counts depend on contacts, guards, jumps, loops and indices.

use super::lines::DrawsLines;
use super::tape::Tape;

struct Generator<'t, 'a> {
    tape: &'t mut Tape<'a>,
    lines: Vec<String>,
    labels: u32,
    /// Whether a routine can be called here.
    routine: bool,
    /// The labels after the enclosing loops.
    out: Vec<u32>,
    /// Whether writes may reach almost any device.
    far: bool,
    /// Whether loops may be too long to be unrolled.
    long: bool,
}

/// What programs may contain.
#[derive(Debug, Clone, Copy)]
pub struct Taste {
    /// Counts may also come from the previous scan.
    pub across: bool,
    /// Writes may reach almost any device: through unknown indices, and through addresses.
    pub far: bool,
    /// Loops may be too long to be unrolled.
    pub long: bool,
}

/// A program. Its counts are often written first or, if they come from the previous scan, last.
pub fn generate(tape: &mut Tape<'_>, Taste { across, far, long }: Taste) -> Vec<String> {
    let (lines, out) = (Vec::new(), Vec::new());
    let mut g = Generator { tape, lines, labels: 0, routine: false, out, far, long };
    if !across && g.tape.percent(60) {
        let first = g.tape.below(9);
        g.put("LD SM400");
        g.put(format!("FMOV K{first} D10 K3"));
    }
    let routine = g.tape.percent(30);
    g.routine = routine;
    g.items(0, 7);
    if across {
        g.put("LD SM400");
        for _ in 0..1 + g.tape.below(3) {
            let line = g.pick(&[
                "MOV K7 D10",
                "MOV D10 D11",
                "MOV D11 D12",
                "INC D10",
                "+ K3 D11 D12",
                "LIMIT K0 K9 D12 D11",
                "WAND K15 D12",
                "WAND K31 D11 D10",
                "SER K0 D0 D11 K4",
                "- K20 D10 D12",
                "* D10 K2 D11",
            ]);
            g.put(line);
        }
        if g.tape.percent(40) {
            g.put("LD> D10 K20");
            g.put("MOV K0 D10");
        }
    }
    if routine {
        g.contacts();
        g.put("CALL P100");
        g.items(1, 3);
        g.put("FEND");
        g.put("P100");
        g.routine = false;
        g.items(1, 3);
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
        match self.tape.below(15) {
            0 if depth < 2 => {
                let count = match self.tape.below(4) {
                    0 => "K3",
                    1 => {
                        // Too many iterations to be unrolled.
                        self.put("LD SM400");
                        let most = if self.long { 30_000 } else { 30 };
                        self.put(format!("LIMIT K1 K{most} D0 D13"));
                        "D13"
                    }
                    _ => {
                        self.put("LD SM400");
                        self.put("LIMIT K1 K6 D10 D13");
                        "D13"
                    }
                };
                self.put(format!("FOR {count}"));
                let out = self.label();
                self.out.push(out);
                self.items(depth + 1, 3);
                self.out.pop();
                (0..12).for_each(|_| self.put("NOP"));
                self.put("NEXT");
                self.put(format!("P{out}"));
            }
            1 => {
                self.contacts();
                let label = self.label();
                self.put(format!("CJ P{label}"));
                self.items(2, 2);
                self.put(format!("P{label}"));
            }
            2 => {
                self.contacts();
                self.put("MC N0 M9");
                for _ in 0..2 {
                    self.contacts();
                    self.outputs();
                }
                self.put("MCR N0");
            }
            3 => {
                self.put("LD SM400");
                self.put("WAND K7 Z0");
            }
            4 => self.branches(),
            5..=8 => self.again(),
            9 if self.routine => {
                self.contacts();
                self.put("CALL P100");
            }
            10 | 11 if !self.out.is_empty() => {
                self.contacts();
                let leave = self.pick(&["CJ", "BREAK D13"]);
                let out = self.out.last().expect("a loop");
                self.lines.push(format!("{leave} P{out}"));
            }
            _ => {
                self.contacts();
                self.outputs();
            }
        }
    }
}

impl Generator<'_, '_> {
    fn label(&mut self) -> u32 {
        self.labels += 1;
        self.labels - 1
    }

    /// Counts written under contacts, and instructions with these counts under the same contacts.
    fn again(&mut self) {
        let from = self.lines.len();
        self.contacts();
        let contacts = self.lines[from..].to_vec();
        let to = self.pick(&["D10", "D11", "D12"]);
        let count = match self.tape.below(6) {
            0 => format!("MOV K{} {to}", self.tape.below(40)),
            1 => format!("WAND K15 D0 {to}"),
            2 => format!("SER K0 D0 {to} K4"),
            3 => format!("LIMIT K0 K9 D0 {to}"),
            4 => format!("MOV D12 {to}"),
            _ => format!("BMOV D10 {to} K1"),
        };
        self.put(count);
        if self.tape.percent(40) {
            let by = self.tape.below(6);
            let sign = self.pick(&["+", "-"]);
            self.put(format!("{sign} K{by} {to} {to}"));
        }
        if self.tape.percent(40) {
            let bit = self.pick(&["M0", "M1", "M2"]);
            self.put(format!("OUT {bit}"));
        }
        if self.tape.percent(60) {
            self.item(2);
        }
        let again = self.tape.percent(30);
        if again {
            let count = self.pick(&["K3", "K2", "D13"]);
            self.put(format!("FOR {count}"));
        }
        self.lines.extend(contacts);
        if self.tape.percent(40) {
            self.put(format!("AND> {to} K0"));
        }
        self.put(format!("FMOV D0 D20 {to}"));
        if again {
            if self.tape.percent(70) {
                self.contacts();
                self.outputs();
            }
            self.put("NEXT");
        }
    }

    fn branches(&mut self) {
        self.contacts();
        self.put("MPS");
        self.contact("AND");
        self.outputs();
        if self.tape.percent(50) {
            self.put("MRD");
            self.contact("AND");
            self.outputs();
        }
        self.put("MPP");
        if self.tape.percent(50) {
            self.contact("AND");
        }
        self.outputs();
    }

    fn contacts(&mut self) {
        self.contact("LD");
        for _ in 0..self.tape.below(3) {
            match self.tape.below(8) {
                0 => self.contact("OR"),
                1 => {
                    self.contact("LD");
                    self.contact("AND");
                    let block = self.pick(&["ANB", "ORB"]);
                    self.put(block);
                }
                2 => self.put("INV"),
                3 => self.put("MEP"),
                _ => self.contact("AND"),
            }
        }
    }

    fn contact(&mut self, kind: &str) {
        match self.tape.below(6) {
            0..=2 => {
                let bit = self.pick(&["X0", "M0", "M1", "M2", "D1.0", "SM400", "M0Z0"]);
                let name = match (kind, self.tape.below(5)) {
                    ("LD", 3) => "LDI",
                    ("AND", 3) => "ANI",
                    ("OR", 3) => "ORI",
                    (kind, _) => kind,
                };
                self.put(format!("{name} {bit}"));
            }
            _ => {
                let relation = self.pick(&["=", ">", "<", "<>", ">=", "<="]);
                let (left, right) = (self.word(), self.number());
                self.put(format!("{kind}{relation} {left} {right}"));
            }
        }
    }

    fn word(&mut self) -> &'static str {
        self.pick(&["D10", "D11", "D12", "D0", "D1"])
    }

    fn number(&mut self) -> &'static str {
        self.pick(&["K0", "K1", "K5", "K20", "K-1", "D10", "D11", "D0"])
    }

    fn outputs(&mut self) {
        for _ in 0..1 + self.tape.below(3) {
            self.output();
        }
    }

    fn output(&mut self) {
        let (a, b, to) = (self.word(), self.number(), self.pick(&["D10", "D11", "D12"]));
        if self.far && self.tape.percent(25) {
            let line = match self.tape.below(6) {
                0 => format!("MOV {a} Z1"),
                1 => format!("DMOV {a} Z0"),
                2 => format!("MOV {b} @D{}", 5 + self.tape.below(6)),
                3 => format!("FMOV {b} D5Z1 {to}"),
                4 => format!("MOV ZR12 {to}"),
                _ => {
                    let device = self.pick(&["D5Z1", "ZR5Z0", "ZR10", "W5Z1"]);
                    format!("MOV {b} {device}")
                }
            };
            return self.put(line);
        }
        let line = match self.tape.below(29) {
            0..=5 => {
                let name = self.pick(&["FMOV", "BMOV"]);
                format!("{name} D0 D20 {to}")
            }
            6..=8 => {
                let value = self.pick(&["K0", "K3", "K7", "K30", "K-2"]);
                format!("MOV {value} {to}")
            }
            9 => format!("MOV {a} {to}"),
            10 | 11 => {
                let name = self.pick(&["+", "-", "*"]);
                format!("{name} {a} {b} {to}")
            }
            12 => format!("WAND K15 {a} {to}"),
            13 => format!("LIMIT K0 K9 {a} {to}"),
            14 => format!("SER K0 D0 {to} K4"),
            15 => format!("/ {a} K7 {to}"),
            16 => format!("DMOV K70003 {to}"),
            17 => format!("INC {to}"),
            18 | 19 => {
                let name = self.pick(&["OUT", "SET", "RST", "PLS", "PLF", "FF"]);
                let bit = self.pick(&["M0", "M1", "M2", "M0Z0"]);
                let bit = if name == "FF" { "M1" } else { bit };
                format!("{name} {bit}")
            }
            24 => format!("XCH D11 {to}"),
            25 => format!("MOV {b} K4M0"),
            26 => format!("DMOV {a} {to}"),
            27 => format!("BMOV D9 D10 {to}"),
            28 => format!("WXOR {a} D0 {to}"),
            20 => format!("MOVP K{} {to}", 1 + self.tape.below(9)),
            21 => format!("BMOV D0 {to} K2"),
            22 => {
                let device = self.pick(&["D5Z0", "D8Z0"]);
                format!("MOV {b} {device}")
            }
            _ => {
                let target = self.pick(&["K1M0", "D1.0"]);
                if target == "D1.0" { format!("SET {target}") } else { format!("MOV {b} {target}") }
            }
        };
        self.put(line);
    }
}
