//! Random MELSEC list text: rungs of all contacts and joins, coils, application instructions and control.

use super::tape::Tape;

/// What generated lists may contain.
#[derive(Debug, Clone, Copy)]
pub struct Taste {
    /// Comparisons, moves and arithmetic.
    pub words: bool,
    /// Jumps, calls, loops, master controls, stops.
    pub control: bool,
    /// Constructs that are over-approximated: indexed devices, products, users' instructions, direct inputs,
    /// interrupts, loops counted by a word.
    pub wild: bool,
    /// The most items of a block.
    pub items: usize,
}

/// The file of a project that is generated, which decides what it may contain.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Part {
    First,
    /// Without interrupt routines, because their labels are shared by the project.
    Further,
}

struct Generator<'t, 'a> {
    tape: &'t mut Tape<'a>,
    taste: Taste,
    lines: Vec<String>,
    labels: u32,
    /// Subroutines called so far.
    routines: usize,
    masters: u32,
    /// The labels after the loops that can be left here, and whether each is used.
    breaks: Vec<(u32, bool)>,
    edges: u32,
}

const FIRST_ROUTINE: u32 = 100;
/// The label after the first FEND.
const BEHIND: u32 = 99;

/// The lines of one file.
pub fn generate(tape: &mut Tape<'_>, taste: Taste, part: Part) -> Vec<String> {
    let mut g = Generator {
        tape,
        taste,
        lines: Vec::new(),
        labels: 0,
        routines: 0,
        masters: 0,
        breaks: Vec::new(),
        edges: 0,
    };
    // The first FEND may be skipped by a jump to a second main part after it.
    let second = taste.control && g.tape.percent(15);
    if second {
        g.contacts();
        g.put(format!("CJ P{BEHIND}"));
    }
    g.items(0, 0);
    if second {
        g.put("FEND");
        g.put(format!("P{BEHIND}"));
        g.items(1, 0);
    }
    let interrupt = part == Part::First && taste.wild && taste.control && g.tape.percent(20);
    if g.routines > 0 || interrupt {
        g.put("FEND");
    }
    if interrupt {
        g.put("I0");
        g.items(2, 3);
        g.put("IRET");
    }
    let mut routine = 0;
    while routine < g.routines {
        g.put(format!("P{}", FIRST_ROUTINE + routine as u32));
        g.items(1, routine + 1);
        g.put("RET");
        routine += 1;
    }
    g.put("END");
    g.lines
}

impl Generator<'_, '_> {
    fn put(&mut self, line: impl Into<String>) {
        self.lines.push(line.into());
    }

    fn items(&mut self, depth: usize, callable: usize) {
        let count = 1 + self.tape.below(self.taste.items) / (depth + 1);
        let mut pending: Vec<(u32, usize)> = Vec::new();
        for _ in 0..count {
            self.item(depth, callable, &mut pending);
            for (label, left) in &mut pending {
                *left -= 1;
                if *left == 0 {
                    self.lines.push(format!("P{label}"));
                }
            }
            pending.retain(|(_, left)| *left > 0);
            if self.tape.done() {
                break;
            }
        }
        for (label, _) in pending {
            self.put(format!("P{label}"));
        }
    }

    fn label(&mut self) -> u32 {
        self.labels += 1;
        self.labels - 1
    }

    fn item(&mut self, depth: usize, callable: usize, pending: &mut Vec<(u32, usize)>) {
        let kind = if self.taste.control && depth < 3 { self.tape.below(16) } else { 0 };
        match kind {
            10 => {
                self.contacts();
                let label = self.label();
                let name = self.tape.pick(&["CJ", "CJ", "SCJ"]);
                self.put(format!("{name} P{label}"));
                pending.push((label, 2 + self.tape.below(2)));
            }
            11 | 12 if callable < 3 => {
                self.contacts();
                let routine = callable + self.tape.below(3 - callable);
                self.routines = self.routines.max(routine + 1);
                let name = self.tape.pick(&["CALL", "CALL", "CALLP"]);
                self.put(format!("{name} P{}", FIRST_ROUTINE as usize + routine));
            }
            13 => {
                self.contacts();
                let (level, coil) = (self.masters, 50 + self.masters);
                self.put(format!("MC N{level} M{coil}"));
                let breaks = std::mem::take(&mut self.breaks);
                self.masters += 1;
                self.items(depth + 1, callable);
                self.masters -= 1;
                self.breaks = breaks;
                self.put(format!("MCR N{level}"));
            }
            14 => {
                let count = if self.taste.wild && self.tape.percent(30) {
                    self.tape.pick(&["D0", "K1M0", "D0", "D1"])
                } else {
                    self.tape.pick(&["K1", "K2", "K3"])
                };
                self.put(format!("FOR {count}"));
                let label = self.label();
                self.breaks.push((label, false));
                self.items(depth + 1, callable);
                self.put("NEXT");
                if self.breaks.pop().expect("pushed above").1 {
                    self.put(format!("P{label}"));
                }
            }
            15 if !self.breaks.is_empty() => {
                self.contacts();
                let innermost = self.breaks.last_mut().expect("not empty");
                innermost.1 = true;
                let label = innermost.0;
                let name = if self.taste.words { "BREAK D3" } else { "BREAK D9" };
                self.put(format!("{name} P{label}"));
            }
            15 if self.tape.percent(20) => {
                self.contacts();
                self.put("STOP");
            }
            _ => self.rung(),
        }
    }

    fn rung(&mut self) {
        self.contacts();
        match self.tape.below(4) {
            3 => {
                self.put("MPS");
                self.more_contacts();
                self.output();
                for _ in 0..self.tape.below(2) {
                    self.put("MRD");
                    self.more_contacts();
                    self.output();
                }
                self.put("MPP");
                self.more_contacts();
                self.output();
            }
            several => {
                for _ in 0..=several {
                    self.output();
                    if self.tape.percent(15) {
                        self.contact("AND");
                        self.output();
                    }
                }
            }
        }
    }

    fn more_contacts(&mut self) {
        if self.tape.percent(60) {
            self.contact("AND");
        } else if self.tape.percent(40) {
            self.block("ANB");
        }
    }

    /// A separate block and the instruction that joins it.
    fn block(&mut self, join: &str) {
        self.contact("LD");
        for _ in 0..self.tape.below(2) {
            let kind = self.tape.pick(&["OR", "AND"]);
            self.contact(kind);
        }
        self.put(join);
    }

    fn contacts(&mut self) {
        self.contact("LD");
        for _ in 0..self.tape.below(4) {
            match self.tape.below(8) {
                0..=2 => self.contact("AND"),
                3 | 4 => self.contact("OR"),
                5 => {
                    let join = self.tape.pick(&["ANB", "ORB"]);
                    self.block(join);
                }
                6 => self.put("INV"),
                _ => {
                    if self.tape.percent(50) {
                        let name = self.tape.pick(&["MEP", "MEF"]);
                        self.put(name);
                    } else {
                        let name = self.tape.pick(&["EGP", "EGF"]);
                        self.edges += 1;
                        self.put(format!("{name} V{}", self.edges));
                    }
                }
            }
        }
    }

    /// A contact; `kind` is LD, AND or OR.
    fn contact(&mut self, kind: &str) {
        if self.taste.words && self.tape.percent(30) {
            let double = if self.tape.percent(20) { "D" } else { "" };
            let relation = self.tape.pick(&["=", ">=", "<>", "<", "<=", ">"]);
            let left = self.source(!double.is_empty());
            let right = self.source(!double.is_empty());
            self.put(format!("{kind}{double}{relation} {left} {right}"));
            return;
        }
        let bit = self.bit();
        let inverse = match kind {
            "LD" => "LDI",
            "AND" => "ANI",
            _ => "ORI",
        };
        let name = match self.tape.below(10) {
            0..=4 => kind.to_owned(),
            5..=7 => inverse.to_owned(),
            8 => format!("{kind}{}", self.tape.pick(&["P", "F"])),
            _ => format!("{kind}{}", self.tape.pick(&["PI", "FI", "P"])),
        };
        self.put(format!("{name} {bit}"));
    }

    fn bit(&mut self) -> String {
        let plain = ["X0", "X1", "M0", "M1", "X2", "M2", "M3", "Y0", "T0", "C0", "M4", "T1", "ST0"];
        match self.tape.below(12) {
            8 if self.taste.words => self.tape.pick(&["D0.0", "D1.F", "D2.1"]).to_owned(),
            9 if self.taste.wild => self.tape.pick(&["M0Z0", "DX0", "X0Z1", "DY0"]).to_owned(),
            10 if self.taste.control => self.tape.pick(&["M50", "SM400", "SM401"]).to_owned(),
            _ => self.tape.pick(&plain).to_owned(),
        }
    }

    fn target_bit(&mut self) -> String {
        match self.tape.below(10) {
            7 if self.taste.words => self.tape.pick(&["D0.0", "D1.F"]).to_owned(),
            8 if self.taste.wild => self.tape.pick(&["M0Z0", "Y0Z1", "DY0"]).to_owned(),
            _ => self.tape.pick(&["M0", "M1", "Y0", "M2", "M3", "M4"]).to_owned(),
        }
    }

    fn constant(&mut self) -> String {
        let all = ["K0", "K1", "K2", "K3", "K-1", "H0F", "K5", "K32767", "K-32768", "H0FFFF"];
        let few = if self.tape.percent(80) { 4 } else { all.len() };
        self.tape.pick(&all[..few]).to_owned()
    }

    fn source(&mut self, double: bool) -> String {
        match self.tape.below(8) {
            0..=2 => self.word(),
            3 | 4 => self.constant(),
            5 => self.tape.pick(&["K1M0", "K2M0", "K1X0", "K4M0"]).to_owned(),
            6 if double => self.tape.pick(&["K8M0", "K5M0"]).to_owned(),
            6 => self.tape.pick(&["T0", "C0"]).to_owned(),
            _ if self.taste.wild => self.tape.pick(&["D0Z0", "K1M0Z1"]).to_owned(),
            _ => self.word(),
        }
    }

    fn word(&mut self) -> String {
        self.tape.pick(&["D0", "D1", "D2"]).to_owned()
    }

    fn target(&mut self, double: bool) -> String {
        match self.tape.below(8) {
            5 => self.tape.pick(&["K1M0", "K2M0", "K1Y0"]).to_owned(),
            6 if double => "K5M0".to_owned(),
            7 if self.taste.wild => self.tape.pick(&["D0Z0", "K1M0Z1", "Z0"]).to_owned(),
            _ => self.word(),
        }
    }

    fn output(&mut self) {
        let kind = self.tape.below(if self.taste.words { 20 } else { 11 });
        let line = match kind {
            0..=3 => format!("OUT {}", self.target_bit()),
            4 | 5 => {
                let name = self.tape.pick(&["SET", "RST"]);
                format!("{name} {}", self.target_bit())
            }
            6 => {
                let name = self.tape.pick(&["PLS", "PLF", "FF"]);
                format!("{name} {}", self.tape.pick(&["M0", "M1", "M2", "M3"]))
            }
            7 => {
                let timer = self.tape.pick(&["OUT T0", "OUT T1", "OUT ST0", "OUTH T1"]);
                format!("{timer} {}", self.setting())
            }
            8 => format!("OUT C0 {}", self.setting()),
            9 => self.tape.pick(&["RST T0", "RST C0", "RST C0", "RST ST0"]).to_owned(),
            10 if self.taste.wild => {
                self.tape.pick(&["SwOp0 D0", "SwOp1 M1 D2", "SwOp2 K3 M0"]).to_owned()
            }
            10 => format!("OUT {}", self.target_bit()),
            11..=13 => {
                let double = self.tape.percent(25);
                let (d, pulse) = (if double { "D" } else { "" }, self.pulse());
                let name = self.tape.pick(&["MOV", "MOV", "MOV", "CML"]);
                let source = self.source(double);
                format!("{d}{name}{pulse} {source} {}", self.target(double))
            }
            14 | 15 => {
                let double = self.tape.percent(25);
                let (d, pulse) = (if double { "D" } else { "" }, self.pulse());
                let name = self.tape.pick(&["+", "-"]);
                let a = self.source(double);
                let b =
                    if self.tape.percent(40) { self.source(double) + " " } else { String::new() };
                format!("{d}{name}{pulse} {a} {b}{}", self.word())
            }
            16 => {
                let (d, pulse) = (if self.tape.percent(25) { "D" } else { "" }, self.pulse());
                let name = self.tape.pick(&["INC", "DEC"]);
                format!("{d}{name}{pulse} {}", self.word())
            }
            17 => {
                let pulse = self.pulse();
                let double = self.tape.percent(25);
                let name = match (double, self.tape.below(3)) {
                    (false, 0) => "WAND",
                    (false, 1) => "WOR",
                    (false, _) => "WXOR",
                    (true, 0) => "DAND",
                    (true, 1) => "DOR",
                    (true, _) => "DXOR",
                };
                let a = self.source(double);
                let b =
                    if self.tape.percent(40) { self.source(double) + " " } else { String::new() };
                format!("{name}{pulse} {a} {b}{}", self.word())
            }
            18 => {
                let pulse = self.pulse();
                self.tape
                    .pick(&[
                        "FMOV? K0 D0 K3",
                        "BMOV? D0 D1 K2",
                        "BMOV? D1 D0 K2",
                        "FMOV? D2 D0 K2",
                        "XCH? D0 D1",
                        "BSET? D0 K1",
                        "BRST? D1 K15",
                        "DSFL? D0 K3",
                        "DSFR? D0 K2",
                        "BSFL? M0 K3",
                        "BSFR? M1 K3",
                        "BK+? D0 K1 D0 K2",
                        "BK-? D0 D1 D2 K1",
                        "BKAND? D0 D1 D0 K1",
                        "BKCMP=? D0 D1 M2 K1",
                        "BKCMP<? K1 D0 M0 K3",
                    ])
                    .replace('?', pulse)
            }
            _ if self.taste.wild => {
                let pulse = self.pulse();
                self.tape
                    .pick(&[
                        "*? D0 D1 D2",
                        "/? D0 K2 D1",
                        "BMOV? D0 D1 D2",
                        "FMOV? K1 D0 D3",
                        "BSET? D0 D1",
                        "BK+? D0 K1 D1 K2",
                        "ROL? D0 K1",
                        "SUM? D0 D1",
                        "LIMIT? K-1 K2 D0 D1",
                        "WTOB? D0 D1 K2",
                        "DECO? D0 M0 K2",
                        "SWAP? D1",
                        "BCD? D0 D1",
                        "BIN? D1 D0",
                        "MAX? D0 D1 K2",
                        "SER? D0 D1 D1 K2",
                        "WSUM? D0 D1 K2",
                        "DIS? D0 D1 K2",
                        "UNI? D0 D1 K2",
                        "TEST? D0 D1 M2",
                        "ZONE? K-1 K1 D0 D1",
                        "DBL? D0 D1",
                        "D*? D0 D1 D0",
                        "SFL? D0 K3",
                        "E+? D0 D1 D2",
                    ])
                    .replace('?', pulse)
            }
            _ => format!("MOV {} {}", self.constant(), self.word()),
        };
        self.put(line);
    }

    fn pulse(&mut self) -> &'static str {
        if self.tape.percent(25) { "P" } else { "" }
    }

    fn setting(&mut self) -> String {
        if self.taste.words && self.tape.percent(20) {
            self.word()
        } else {
            self.tape.pick(&["K1", "K3", "K2"]).to_owned()
        }
    }
}
