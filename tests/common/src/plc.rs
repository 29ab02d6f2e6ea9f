//! A small MELSEC PLC that runs list text as in the manuals and uses no part of the library. The time that it takes
//! for a scan must not exceed the bound.

mod data;

use std::collections::BTreeMap;

/// A device: area and number. Timer and counter contacts are areas of their own.
pub type Device = (&'static str, u32);

const AREAS: [(&str, u32); 20] = [
    ("SM", 10),
    ("SD", 10),
    ("ST", 10),
    ("DX", 16),
    ("DY", 16),
    ("ZR", 10),
    ("X", 16),
    ("Y", 16),
    ("M", 10),
    ("L", 10),
    ("B", 16),
    ("V", 10),
    ("T", 10),
    ("C", 10),
    ("D", 10),
    ("W", 16),
    ("Z", 10),
    ("P", 10),
    ("N", 10),
    ("I", 10),
];

#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Operand {
    Constant(i64),
    /// With the index register whose value is added to the number.
    Device(Device, Option<u32>),
    WordBit(Device, u8),
    /// Digits of four bits.
    Group(u8, Device, Option<u32>),
}

#[derive(Debug, Clone)]
pub struct Line {
    pub mnemonic: String,
    pub operands: Vec<Operand>,
}

/// One line of list text.
pub fn line(text: &str) -> Line {
    let mut words = text.split_whitespace();
    let mnemonic = words.next().expect("a mnemonic").to_owned();
    Line { mnemonic, operands: words.map(operand).collect() }
}

fn operand(text: &str) -> Operand {
    if let Some(number) = text.strip_prefix('K') {
        let digits = number.find(|c: char| !c.is_ascii_digit() && c != '-').unwrap_or(number.len());
        let value: i64 = number[..digits].parse().expect("a number");
        if digits == number.len() {
            return Operand::Constant(value);
        }
        let (device, index) = device(&number[digits..]);
        return Operand::Group(value as u8, device, index);
    }
    if let Some(number) = text.strip_prefix('H') {
        return Operand::Constant(i64::from_str_radix(number, 16).expect("a number"));
    }
    if let Some((word, bit)) = text.split_once('.') {
        let bit = u8::from_str_radix(bit, 16).expect("a bit");
        return Operand::WordBit(device(word).0, bit);
    }
    let (device, index) = device(text);
    Operand::Device(device, index)
}

fn device(text: &str) -> (Device, Option<u32>) {
    let area = AREAS.iter().find(|(name, _)| {
        text.strip_prefix(name)
            .is_some_and(|rest| rest.starts_with(|c: char| c.is_ascii_hexdigit()))
    });
    let (name, radix) = area.unwrap_or_else(|| panic!("no device: {text}"));
    let rest = &text[name.len()..];
    let (number, index) = match rest.split_once('Z') {
        Some((number, index)) => (number, Some(index.parse().expect("an index register"))),
        None => (rest, None),
    };
    ((name, u32::from_str_radix(number, *radix).expect("a device number")), index)
}

/// One executed line: file, line from 1, whether it was on, and the number of units that a word counted.
pub type Executed = (usize, usize, bool, u64);

/// The most lines that are executed in one scan.
const MAX_LINES: usize = 2_000;

/// The values that the program does not determine: start values, elapsed time, inputs read directly, interrupts.
pub trait Luck {
    /// The start value of a device, of an instruction's memory (area `!`), or of any other free value.
    fn value(&mut self, of: Device) -> u16;
    /// A number below `n` at this moment.
    fn below(&mut self, n: u32) -> u32;
    /// Whether a loop whose count is below 1 runs once, or not at all.
    fn once(&mut self) -> bool {
        true
    }
}

pub struct Plc<'p, L> {
    files: &'p [Vec<Line>],
    luck: L,
    /// Interrupt pointer and how often it may come in this scan.
    interrupts: Vec<(u32, u32)>,
    memory: BTreeMap<Device, u16>,
    executed: Vec<Executed>,
    enabled: bool,
    interrupted: bool,
    steps: usize,
}

/// The state of a routine.
#[derive(Default)]
struct Rung {
    results: Vec<bool>,
    saved: Vec<bool>,
    masters: Vec<(u32, bool)>,
    /// `FOR`'s line and the iterations left.
    loops: Vec<(usize, u32)>,
}

#[derive(PartialEq)]
enum Ended {
    Returned,
    File,
    Scan,
}

impl<'p, L: Luck> Plc<'p, L> {
    /// `interrupts`: pointers and how often each may come in the scan.
    pub fn new(files: &'p [Vec<Line>], luck: L, interrupts: Vec<(u32, u32)>) -> Self {
        Plc {
            files,
            luck,
            interrupts,
            memory: BTreeMap::new(),
            executed: Vec::new(),
            enabled: true,
            interrupted: false,
            steps: 0,
        }
    }

    /// Runs one scan and returns the executed lines.
    pub fn scan(mut self) -> Vec<Executed> {
        for file in 0..self.files.len() {
            if self.routine(file, 0) == Ended::Scan {
                break;
            }
        }
        self.executed
    }

    /// Runs one scan and returns the final values of the devices that it used.
    pub fn left(self) -> BTreeMap<Device, u16> {
        self.both().1
    }

    /// Runs one scan and returns the executed lines and the final values of the devices.
    pub fn both(mut self) -> (Vec<Executed>, BTreeMap<Device, u16>) {
        for file in 0..self.files.len() {
            if self.routine(file, 0) == Ended::Scan {
                break;
            }
        }
        (self.executed, self.memory)
    }

    fn label(&self, file: usize, name: &str) -> usize {
        let lines = &self.files[file];
        lines.iter().position(|line| line.mnemonic == name).expect("the label exists")
    }

    fn pointer(&self, file: usize, operand: &Operand) -> usize {
        let Operand::Device(("P", number), None) = operand else { panic!("no pointer") };
        self.label(file, &format!("P{number}"))
    }

    fn routine(&mut self, file: usize, entry: usize) -> Ended {
        let files = self.files;
        let mut rung = Rung::default();
        let mut at = entry;
        loop {
            self.maybe_interrupt();
            let Some(line) = files[file].get(at) else { return Ended::File };
            self.steps += 1;
            if self.steps > MAX_LINES {
                // The lines executed so far are part of a longer scan.
                return Ended::Scan;
            }
            let logged = self.executed.len();
            self.executed.push((file, at + 1, true, 0));
            let (on, next) = self.line(file, at, line, &mut rung);
            self.executed[logged].2 = on;
            match next {
                Ok(next) => at = next,
                Err(ended) => return ended,
            }
        }
    }

    fn maybe_interrupt(&mut self) {
        if !self.enabled || self.interrupted || self.interrupts.is_empty() {
            return;
        }
        let which = self.luck.below(self.interrupts.len() as u32 * 4) as usize;
        let Some((pointer, left)) = self.interrupts.get_mut(which) else { return };
        if *left == 0 {
            return;
        }
        *left -= 1;
        let name = format!("I{pointer}");
        let file = (0..self.files.len())
            .find(|&file| self.files[file].iter().any(|line| line.mnemonic == name));
        let Some(file) = file else { return };
        self.interrupted = true;
        self.routine(file, self.label(file, &name));
        self.interrupted = false;
    }

    fn cell(&mut self, device: Device) -> u16 {
        match device {
            ("SM", 400) => return 1,
            ("SM", 401) => return 0,
            ("DX", _) => return self.luck.below(2) as u16,
            _ => {}
        }
        let device = if device.0 == "DY" { ("Y", device.1) } else { device };
        if let Some(value) = self.memory.get(&device) {
            return *value;
        }
        let value = self.luck.value(device);
        self.memory.insert(device, value);
        value
    }

    fn put(&mut self, device: Device, value: u16) {
        let device = if device.0 == "DY" { ("Y", device.1) } else { device };
        self.memory.insert(device, value);
    }

    fn indexed(&mut self, (area, number): Device, index: Option<u32>) -> Device {
        let offset = index.map_or(0, |z| i64::from(self.cell(("Z", z)) as i16));
        // A number below zero or outside the area is an operation error on the PLC; here it wraps around.
        (area, (i64::from(number) + offset).rem_euclid(64) as u32)
    }

    fn bit(&mut self, operand: &Operand) -> bool {
        match *operand {
            Operand::Device((area @ ("T" | "C" | "ST"), n), None) => {
                let contact = contact_area(area);
                self.cell((contact, n)) & 1 == 1
            }
            Operand::Device(device, index) => {
                let device = if index.is_some() { self.indexed(device, index) } else { device };
                self.cell(device) & 1 == 1
            }
            Operand::WordBit(device, bit) => self.cell(device) >> bit & 1 == 1,
            _ => panic!("no bit: {operand:?}"),
        }
    }

    fn set_bit(&mut self, operand: &Operand, value: bool) {
        match *operand {
            Operand::Device((area @ ("T" | "C" | "ST"), n), None) => {
                self.put((contact_area(area), n), value.into());
            }
            Operand::Device(device, index) => {
                let device = if index.is_some() { self.indexed(device, index) } else { device };
                self.put(device, value.into());
            }
            Operand::WordBit(device, bit) => {
                let rest = self.cell(device) & !(1 << bit);
                self.put(device, rest | u16::from(value) << bit);
            }
            _ => panic!("no bit: {operand:?}"),
        }
    }

    /// A number of one or two words, sign-extended; a digit group is not signed unless it fills the words.
    fn number(&mut self, operand: &Operand, words: u32) -> i64 {
        match *operand {
            Operand::Constant(value) => extend(value, words),
            Operand::Device(device, index) => {
                let (area, n) = if index.is_some() { self.indexed(device, index) } else { device };
                let mut value = u32::from(self.cell((area, n)));
                if words == 2 {
                    value |= u32::from(self.cell((area, n + 1))) << 16;
                }
                extend(i64::from(value), words)
            }
            Operand::Group(digits, device, index) => {
                let (area, n) = if index.is_some() { self.indexed(device, index) } else { device };
                let bits = (u32::from(digits) * 4).min(words * 16);
                let value = (0..bits)
                    .map(|bit| u32::from(self.cell((area, n + bit)) & 1) << bit)
                    .fold(0, |a, b| a | b);
                extend(i64::from(value), words)
            }
            Operand::WordBit(..) => panic!("no number: {operand:?}"),
        }
    }

    fn set_number(&mut self, operand: &Operand, words: u32, value: i64) {
        match *operand {
            Operand::Device(device, index) => {
                let (area, n) = if index.is_some() { self.indexed(device, index) } else { device };
                self.put((area, n), value as u16);
                if words == 2 {
                    self.put((area, n + 1), (value >> 16) as u16);
                }
            }
            Operand::Group(digits, device, index) => {
                let (area, n) = if index.is_some() { self.indexed(device, index) } else { device };
                for bit in 0..(u32::from(digits) * 4).min(words * 16) {
                    self.put((area, n + bit), (value >> bit & 1) as u16);
                }
            }
            _ => panic!("not to be written: {operand:?}"),
        }
    }

    /// The memory of one instruction, such as the last value of its condition.
    fn remembered(&mut self, file: usize, at: usize) -> bool {
        self.cell(("!", (file * 10_000 + at) as u32)) & 1 == 1
    }

    fn remember(&mut self, file: usize, at: usize, value: bool) {
        self.put(("!", (file * 10_000 + at) as u32), value.into());
    }

    /// Whether the value rose or fell since this instruction was last executed.
    fn edge(&mut self, file: usize, at: usize, value: bool, rising: bool) -> bool {
        let last = self.remembered(file, at);
        self.remember(file, at, value);
        if rising { value && !last } else { !value && last }
    }

    /// Executes one line. Returns whether it was on, and the next line.
    fn line(
        &mut self,
        file: usize,
        at: usize,
        line: &Line,
        rung: &mut Rung,
    ) -> (bool, Result<usize, Ended>) {
        let next = Ok(at + 1);
        let operands = &line.operands[..];
        let top = rung.results.last().copied().unwrap_or(true);
        let condition = top && rung.masters.iter().all(|master| master.1);
        if let Some(value) = self.contact(file, at, line) {
            let name = line.mnemonic.as_str();
            let joined = if name.starts_with("LD") {
                rung.results.push(value);
                return (value, next);
            } else if name.starts_with("AN") {
                top && value
            } else {
                top || value
            };
            rung.results.pop();
            rung.results.push(joined);
            return (value, next);
        }
        let replace = |rung: &mut Rung, value| {
            rung.results.pop();
            rung.results.push(value);
        };
        match line.mnemonic.as_str() {
            "ANB" | "ORB" => {
                let b = rung.results.pop().expect("a block");
                let a = rung.results.pop().expect("a block");
                rung.results.push(if line.mnemonic == "ANB" { a && b } else { a || b });
            }
            "MPS" => rung.saved.push(top),
            "MRD" => replace(rung, *rung.saved.last().expect("MPS")),
            "MPP" => {
                let saved = rung.saved.pop().expect("MPS");
                replace(rung, saved);
            }
            "INV" => replace(rung, !top),
            "MEP" | "MEF" => {
                let edge = self.edge(file, at, top, line.mnemonic == "MEP");
                replace(rung, edge);
            }
            "EGP" | "EGF" => {
                let last = self.bit(&operands[0]);
                self.set_bit(&operands[0], top);
                replace(rung, if line.mnemonic == "EGP" { top && !last } else { !top && last });
            }
            "MC" => {
                self.set_bit(&operands[1], condition);
                rung.masters.push((nesting(&operands[0]), condition));
                return (condition, next);
            }
            "MCR" => rung.masters.retain(|master| master.0 < nesting(&operands[0])),
            "CJ" | "JMP" => {
                if condition || line.mnemonic == "JMP" {
                    let target = self.pointer(file, &operands[0]);
                    leave_loops(&self.files[file], rung, target);
                    return (true, Ok(target));
                }
                return (false, next);
            }
            "SCJ" => {
                let last = self.remembered(file, at);
                self.remember(file, at, condition);
                if condition && last {
                    let target = self.pointer(file, &operands[0]);
                    leave_loops(&self.files[file], rung, target);
                    return (true, Ok(target));
                }
                return (false, next);
            }
            "CALL" | "CALLP" => {
                let pulse = line.mnemonic == "CALLP";
                let called = if pulse { self.edge(file, at, condition, true) } else { condition };
                if called {
                    let target = self.pointer(file, &operands[0]);
                    match self.routine(file, target) {
                        Ended::Returned => {}
                        ended => return (true, Err(ended)),
                    }
                }
                return (called, next);
            }
            "RET" | "IRET" => return (true, Err(Ended::Returned)),
            "FEND" | "END" => return (true, Err(Ended::File)),
            "STOP" => {
                return (condition, if condition { Err(Ended::Scan) } else { next });
            }
            "FOR" => {
                let iterations = self.number(&operands[0], 1);
                if iterations < 1 && !self.luck.once() {
                    return (true, Ok(loop_end(&self.files[file], at) + 1));
                }
                rung.loops.push((at, iterations.max(1) as u32));
            }
            "NEXT" => {
                let (begin, left) = rung.loops.pop().expect("FOR");
                if left > 1 {
                    rung.loops.push((begin, left - 1));
                    return (true, Ok(begin + 1));
                }
            }
            "BREAK" => {
                if condition {
                    rung.loops.pop();
                    // The number of remaining iterations, as the manual says.
                    let left = self.luck.below(4);
                    self.set_number(&operands[0], 1, i64::from(left));
                    return (true, Ok(self.pointer(file, &operands[1])));
                }
                return (false, next);
            }
            "EI" => self.enabled = true,
            "DI" => self.enabled = false,
            "NOP" | "NOPLF" => {}
            name if name.starts_with(['P', 'I']) && name[1..].parse::<u32>().is_ok() => {}
            _ => return (self.output(file, at, line, condition), next),
        }
        (true, next)
    }

    /// The value of a contact. `None` if the line is not a contact.
    fn contact(&mut self, file: usize, at: usize, line: &Line) -> Option<bool> {
        let name = line.mnemonic.as_str();
        let operands = &line.operands[..];
        let value = match name {
            "LD" | "AND" | "OR" => self.bit(&operands[0]),
            "LDI" | "ANI" | "ORI" => !self.bit(&operands[0]),
            "LDP" | "ANDP" | "ORP" | "LDF" | "ANDF" | "ORF" => {
                let value = self.bit(&operands[0]);
                self.edge(file, at, value, name.ends_with('P'))
            }
            "LDPI" | "ANDPI" | "ORPI" | "LDFI" | "ANDFI" | "ORFI" => {
                let value = self.bit(&operands[0]);
                !self.edge(file, at, value, name.ends_with("PI"))
            }
            _ => {
                let sign = name.find(['=', '<', '>'])?;
                let words = match &name[..sign] {
                    "LD" | "AND" | "OR" => 1,
                    "LDD" | "ANDD" | "ORD" => 2,
                    _ => return None,
                };
                let (a, b) = (self.number(&operands[0], words), self.number(&operands[1], words));
                match &name[sign..] {
                    "=" => a == b,
                    "<>" => a != b,
                    "<" => a < b,
                    "<=" => a <= b,
                    ">" => a > b,
                    ">=" => a >= b,
                    _ => return None,
                }
            }
        };
        Some(value)
    }

    /// Executes a coil or an application instruction. Returns whether it was on.
    fn output(&mut self, file: usize, at: usize, line: &Line, condition: bool) -> bool {
        let operands = &line.operands[..];
        match line.mnemonic.as_str() {
            "OUT" | "OUTH" => {
                self.coil(operands, condition);
                condition
            }
            "SET" => {
                if condition {
                    self.set_bit(&operands[0], true);
                }
                condition
            }
            "RST" => {
                if condition {
                    self.reset(&operands[0]);
                }
                condition
            }
            "PLS" | "PLF" => {
                let edge = self.edge(file, at, condition, line.mnemonic == "PLS");
                self.set_bit(&operands[0], edge);
                edge
            }
            "FF" => {
                let edge = self.edge(file, at, condition, true);
                if edge {
                    let value = self.bit(&operands[0]);
                    self.set_bit(&operands[0], !value);
                }
                edge
            }
            name => {
                if name.starts_with("SwOp") {
                    if condition {
                        for operand in operands {
                            self.scribble(operand);
                        }
                    }
                    return condition;
                }
                let pulse = name.len() > 1 && name.ends_with('P') && name != "SWAP";
                let on = if pulse { self.edge(file, at, condition, true) } else { condition };
                if on {
                    self.apply(name.strip_suffix('P').filter(|_| pulse).unwrap_or(name), operands);
                }
                on
            }
        }
    }

    /// A user's instruction may write any values into its operands.
    fn scribble(&mut self, operand: &Operand) {
        let value = self.luck.below(0x1_0000);
        match operand {
            Operand::Constant(_) => {}
            Operand::Device((area, _), _)
                if ["X", "Y", "M", "L", "B", "T", "C", "SM", "DY"].contains(area) =>
            {
                self.set_bit(operand, value & 1 == 1);
            }
            Operand::WordBit(..) => self.set_bit(operand, value & 1 == 1),
            _ => self.set_number(operand, 1, i64::from(value)),
        }
    }

    fn coil(&mut self, operands: &[Operand], condition: bool) {
        match operands[0] {
            Operand::Device((area @ ("T" | "ST"), n), None) => {
                if condition {
                    let elapsed = i64::from(self.luck.below(8));
                    let current = i64::from(self.cell((area, n))) + elapsed;
                    self.put((area, n), current.min(0x7FFF) as u16);
                    let setting = self.number(&operands[1], 1);
                    self.put((contact_area(area), n), u16::from(current >= setting));
                } else if area == "T" {
                    self.put((area, n), 0);
                    self.put((contact_area(area), n), 0);
                }
            }
            Operand::Device(("C", n), None) => {
                let was = self.cell(("c", n)) & 1 == 1;
                self.put(("c", n), condition.into());
                let setting = self.number(&operands[1], 1);
                let current = i64::from(self.cell(("C", n)) as i16);
                if condition && !was && current < setting {
                    self.put(("C", n), (current + 1) as u16);
                    if current + 1 >= setting {
                        self.put(("C!", n), 1);
                    }
                }
            }
            _ => self.set_bit(&operands[0], condition),
        }
    }

    fn reset(&mut self, operand: &Operand) {
        match *operand {
            Operand::Device((area @ ("T" | "C" | "ST"), n), None) => {
                self.put((area, n), 0);
                self.put((contact_area(area), n), 0);
                if area == "C" {
                    self.put(("c", n), 0);
                }
            }
            Operand::Device(("D" | "W" | "Z" | "ZR", _), _) => self.set_number(operand, 1, 0),
            _ => self.set_bit(operand, false),
        }
    }

    fn apply(&mut self, name: &str, operands: &[Operand]) {
        if self.data(name, operands) {
            return;
        }
        let words = 1 + u32::from(name.starts_with('D') && name != "DEC");
        let plain = if words == 2 { &name[1..] } else { name };
        let last = operands.last().expect("operands");
        match plain {
            "MOV" | "CML" => {
                let value = self.number(&operands[0], words);
                self.set_number(last, words, if plain == "CML" { !value } else { value });
            }
            "INC" | "DEC" => {
                let value = self.number(last, words);
                self.set_number(last, words, if plain == "INC" { value + 1 } else { value - 1 });
            }
            "+" | "-" | "WAND" | "WOR" | "WXOR" | "AND" | "OR" | "XOR" => {
                // With two operands the destination is the left side.
                let (left, right) = if operands.len() == 2 { (1, 0) } else { (0, 1) };
                let a = self.number(&operands[left], words);
                let b = self.number(&operands[right], words);
                let value = match plain {
                    "+" => a + b,
                    "-" => a - b,
                    "WAND" | "AND" => a & b,
                    "WOR" | "OR" => a | b,
                    _ => a ^ b,
                };
                self.set_number(last, words, value);
            }
            "*" => {
                let product = self.number(&operands[0], 1) * self.number(&operands[1], 1);
                self.set_number(last, 2, product);
            }
            "/" => {
                let (a, b) = (self.number(&operands[0], 1), self.number(&operands[1], 1));
                if b != 0 {
                    self.set_number(last, 1, a / b);
                    if let Operand::Device((area, n), None) = *last {
                        self.put((area, n + 1), (a % b) as u16);
                    }
                }
            }
            "XCH" => {
                let a = self.number(&operands[0], words);
                let b = self.number(&operands[1], words);
                self.set_number(&operands[0], words, b);
                self.set_number(&operands[1], words, a);
            }
            "BMOV" | "FMOV" => {
                let count = self.number(last, 1).clamp(0, 16) as u32;
                if let Some(executed) = self.executed.last_mut() {
                    executed.3 = count.into();
                }
                let device = |plc: &mut Self, operand: &Operand| match *operand {
                    Operand::Device(device, None) => Some(device),
                    Operand::Device(device, index) => Some(plc.indexed(device, index)),
                    _ => None,
                };
                let (from, to) = (device(self, &operands[0]), device(self, &operands[1]));
                let (Some((from, f)), Some((to, t))) = (from, to) else {
                    // A constant fills all words.
                    let value = self.number(&operands[0], 1);
                    let Operand::Device((to, t), None) = operands[1] else { panic!("FMOV") };
                    (0..count).for_each(|n| self.put((to, t + n), value as u16));
                    return;
                };
                let step = u32::from(plain == "BMOV");
                let values: Vec<u16> =
                    (0..count).map(|n| self.cell((from, f + n * step))).collect();
                for (n, value) in values.into_iter().enumerate() {
                    self.put((to, t + n as u32), value);
                }
            }
            "BSET" | "BRST" => {
                let bit = self.number(last, 1) & 15;
                let value = self.number(&operands[0], 1);
                let value = if plain == "BSET" { value | 1 << bit } else { value & !(1 << bit) };
                self.set_number(&operands[0], 1, value);
            }
            _ => panic!("no such instruction: {name}"),
        }
    }
}

fn contact_area(area: &str) -> &'static str {
    match area {
        "T" => "T!",
        "C" => "C!",
        _ => "ST!",
    }
}

fn nesting(operand: &Operand) -> u32 {
    let Operand::Device(("N", level), None) = operand else { panic!("no nesting level") };
    *level
}

fn extend(value: i64, words: u32) -> i64 {
    if words == 1 { i64::from(value as i16) } else { i64::from(value as i32) }
}

/// The last line of the loop that begins at a line.
fn loop_end(lines: &[Line], begin: usize) -> usize {
    let mut depth = 0;
    let end = lines.iter().enumerate().skip(begin).find_map(|(at, line)| {
        match line.mnemonic.as_str() {
            "FOR" => depth += 1,
            "NEXT" => depth -= 1,
            _ => {}
        }
        (depth == 0).then_some(at)
    });
    end.expect("NEXT")
}

/// A jump ends the loops that it leaves.
fn leave_loops(lines: &[Line], rung: &mut Rung, target: usize) {
    rung.loops.retain(|(begin, _)| *begin < target && target <= loop_end(lines, *begin));
}
