//! The part of an OMRON PLC of the CS, CJ and CP series that random programs with counts need, written from the
//! instructions reference manuals only. It takes mnemonics, and returns the executed lines and the memory.

use std::collections::BTreeMap;

/// A word: its area (`CIO`, `W`, `D`, `E0_`, `IR`, `DR`) and its number. An index register is one word here.
pub type Word = (&'static str, u32);

/// The values that the program does not determine.
pub trait Chance {
    /// The value of the word when the scan starts.
    fn start(&mut self, word: Word) -> u32;
    /// A number below `n`, where the manuals do not define the result.
    fn below(&mut self, n: u32) -> u32;
}

/// An executed line: its number from 1 on, whether it was executed with its condition on, and the number of its words.
pub type Executed = (usize, bool, u64);

/// The result of a scan.
pub struct Scanned {
    pub executed: Vec<Executed>,
    /// The words that were read or written, with their values at the end of the scan.
    pub left: BTreeMap<Word, u32>,
    /// The counts: the line and the number.
    pub counts: Vec<(usize, u32)>,
}

/// The areas of internal addresses that programs use.
const AREAS: [&str; 5] = ["W", "D", "IR", "DR", "CIO"];
/// The internal address of D0; that of the first bank of E follows its end.
const D0: u32 = 0x10000;

/// The state of the PLC within a scan.
pub struct Plc<'l, C> {
    lines: Vec<Vec<&'l str>>,
    chance: C,
    memory: BTreeMap<Word, u32>,
    executed: Vec<Executed>,
    /// The conditions so far, and whether the next LD begins a new rung.
    stack: Vec<bool>,
    closed: bool,
    lit: bool,
    /// The flags greater, equal and less after the last CMP.
    flags: [bool; 3],
    counts: Vec<(usize, u32)>,
}

impl<'l, C: Chance> Plc<'l, C> {
    pub fn new(lines: &'l [String], chance: C) -> Self {
        Plc {
            lines: lines.iter().map(|line| line.split(' ').collect()).collect(),
            chance,
            memory: BTreeMap::new(),
            executed: Vec::new(),
            stack: Vec::new(),
            closed: true,
            lit: true,
            flags: [false; 3],
            counts: Vec::new(),
        }
    }

    /// Executes one scan.
    pub fn scan(mut self) -> Scanned {
        self.run(0, self.lines.len());
        Scanned { executed: self.executed, left: self.memory, counts: self.counts }
    }

    fn read(&mut self, word: Word) -> u32 {
        let chance = &mut self.chance;
        *self.memory.entry(word).or_insert_with(|| chance.start(word))
    }

    fn word(&mut self, word: Word) -> u16 {
        self.read(word) as u16
    }

    fn write(&mut self, (area, number): Word, value: u16) {
        // Words beyond the end of an area do not exist. Words far after those that programs name are never read.
        if number < 400 || (area == "E0_" && number < 32_768) {
            self.memory.insert((area, number), value.into());
        }
    }

    /// The location of an operand. `None` if its address is an error.
    fn place(&mut self, operand: &str) -> Option<Word> {
        if let Some(rest) = operand.strip_prefix(',') {
            let (number, steps) = match rest.strip_suffix('+') {
                Some(register) => (register, 1),
                None => (rest, 0),
            };
            let register = ("IR", number.strip_prefix("IR")?.parse().ok()?);
            let at = self.read(register);
            self.memory.insert(register, at.wrapping_add(steps));
            return match at.checked_sub(D0)? {
                within @ 0..32_768 => Some(("D", within)),
                _ => None,
            };
        }
        if let Some(pointer) = operand.strip_prefix('@') {
            let to = self.get(pointer)?;
            // From 8000 hexadecimal on the first bank of E.
            return Some(if to < 0x8000 {
                ("D", to.into())
            } else {
                ("E0_", u32::from(to) - 0x8000)
            });
        }
        if let Some(pointer) = operand.strip_prefix('*') {
            let digits = format!("{:04x}", self.get(pointer)?);
            return digits.parse().ok().map(|to| ("D", to));
        }
        let area = AREAS.iter().find(|area| operand.starts_with(**area));
        match area {
            Some(&area) => Some((area, operand[area.len()..].parse().ok()?)),
            None => Some(("CIO", operand.parse().ok()?)),
        }
    }

    /// The value of a word operand or a constant.
    fn get(&mut self, operand: &str) -> Option<u16> {
        if let Some(digits) = operand.strip_prefix('#') {
            return u16::from_str_radix(digits, 16).ok();
        }
        if let Some(digits) = operand.strip_prefix('&') {
            return digits.parse().ok();
        }
        let place = self.place(operand)?;
        Some(self.word(place))
    }

    fn bit(&mut self, operand: &str) -> bool {
        match operand {
            "P_On" => true,
            "P_GT" => self.flags[0],
            "P_EQ" => self.flags[1],
            "P_LT" => self.flags[2],
            _ => {
                let (word, bit) = operand.split_once('.').expect("a bit");
                let place = self.place(word).expect("a word");
                self.word(place) >> bit.parse::<u32>().expect("a bit") & 1 == 1
            }
        }
    }

    fn set(&mut self, operand: &str, value: bool) {
        let (word, bit) = operand.split_once('.').expect("a bit");
        let place = self.place(word).expect("a word");
        let mask = 1 << bit.parse::<u32>().expect("a bit");
        let old = self.word(place);
        self.write(place, if value { old | mask } else { old & !mask });
    }

    /// If the line is a contact: its value, and how it is combined.
    fn contact(&mut self, line: &[&str]) -> Option<(&'static str, bool)> {
        let (join, rest) = ["LD", "AND", "OR"]
            .into_iter()
            .find_map(|join| Some((join, line[0].strip_prefix(join)?)))?;
        let value = match rest {
            "" => self.bit(line[1]),
            "NOT" => !self.bit(line[1]),
            "=" | "<>" | "<" | "<=" | ">" | ">=" | "<S" | ">S" | "=S" => {
                let (a, b) = (self.get(line[1]), self.get(line[2]));
                let (Some(a), Some(b)) = (a, b) else { return Some((join, false)) };
                let signed = rest.ends_with('S');
                let read = |x: u16| if signed { i32::from(x.cast_signed()) } else { x.into() };
                let (a, b) = (read(a), read(b));
                match rest.trim_end_matches('S') {
                    "=" => a == b,
                    "<>" => a != b,
                    "<" => a < b,
                    "<=" => a <= b,
                    ">" => a > b,
                    _ => a >= b,
                }
            }
            _ => return None,
        };
        Some((join, value))
    }

    /// Executes the lines up to `end`. Returns whether BREAK left a loop.
    fn run(&mut self, mut at: usize, end: usize) -> bool {
        while at < end {
            let line = self.lines[at].clone();
            let number = at + 1;
            if let Some((join, value)) = self.contact(&line) {
                let top = self.stack.pop();
                match join {
                    "LD" => {
                        if self.closed {
                            self.stack.clear();
                        } else {
                            self.stack.extend(top);
                        }
                        self.stack.push(value);
                    }
                    "AND" => self.stack.push(top.expect("a branch") && value),
                    _ => self.stack.push(top.expect("a branch") || value),
                }
                self.closed = false;
                at += 1;
                continue;
            }
            if let "ANDLD" | "ORLD" = line[0] {
                let (b, a) = (self.stack.pop().expect("two"), self.stack.pop().expect("two"));
                self.stack.push(if line[0] == "ANDLD" { a && b } else { a || b });
                at += 1;
                continue;
            }
            self.closed = true;
            let top = self.stack.last().copied().unwrap_or(false);
            let on = top && self.lit;
            match line[0] {
                "END" | "RET" => {
                    self.executed.push((number, true, 0));
                    return false;
                }
                "SBN" => return false,
                "IL" => self.lit = top,
                "ILC" => self.lit = true,
                "JMP" | "CJPN" | "CJP" => {
                    if top == (line[0] == "CJP") {
                        let label = ["JME", line[1]];
                        at = self.lines.iter().position(|line| line[..] == label).expect("a JME");
                    }
                }
                "FOR" => {
                    let next = self.next_of(at);
                    let count = self.get(line[1]).unwrap_or(0);
                    self.counts.push((number, count.into()));
                    self.executed.push((number, true, 0));
                    for _ in 0..count {
                        let left = self.run(at + 1, next);
                        if left {
                            break;
                        }
                        self.executed.push((next + 1, true, 0));
                    }
                    self.closed = true;
                    at = next + 1;
                    continue;
                }
                "BREAK" if on => return true,
                "SBS" => {
                    self.executed.push((number, on, 0));
                    if on {
                        let label = ["SBN", line[1]];
                        let routine = self.lines.iter().position(|line| line[..] == label);
                        self.run(routine.expect("an SBN") + 1, self.lines.len());
                        self.closed = true;
                    }
                }
                "OUT" => {
                    self.set(line[1], on);
                    self.executed.push((number, on, 0));
                }
                "JME" | "BREAK" => {}
                _ => {
                    let (name, fires) = match line[0].strip_prefix('@') {
                        Some(name) => (name, on && self.chance.below(2) == 1),
                        None => (line[0], on),
                    };
                    let units =
                        if fires { self.carry_out(number, name, &line[1..]) } else { Some(0) };
                    self.executed.push((number, fires && units.is_some(), units.unwrap_or(0)));
                }
            }
            at += 1;
        }
        false
    }

    fn next_of(&self, at: usize) -> usize {
        let mut open = 0;
        for (n, line) in self.lines.iter().enumerate().skip(at) {
            open += i32::from(line[0] == "FOR") - i32::from(line[0] == "NEXT");
            if open == 0 {
                return n;
            }
        }
        panic!("a NEXT");
    }

    /// Whether this many words are within their area. Otherwise the manuals do not say that nothing is done.
    fn fits(&mut self, (_, first): Word, count: u32) -> bool {
        first + count <= 32_768 || self.chance.below(2) == 1
    }

    fn list(&mut self, (area, first): Word, count: u32) -> Vec<u16> {
        // Words far after those that programs name are 0.
        (first..first + count).map(|n| if n < 400 { self.word((area, n)) } else { 0 }).collect()
    }

    /// Executes an instruction. Returns the number of its words, or `None` after an error.
    fn carry_out(&mut self, number: usize, name: &str, operands: &[&str]) -> Option<u64> {
        let signed = |x: u16| i32::from(x.cast_signed());
        match name {
            "SET" | "RSET" => self.set(operands[0], name == "SET"),
            "SETB" => {
                let (place, bit) = (self.place(operands[0])?, self.get(operands[1])?);
                let old = self.word(place);
                self.write(place, old | 1 << (bit & 15));
            }
            "MOV" | "MVN" | "NEG" | "BCD" | "BIN" => {
                let value = self.get(operands[0])?;
                let value = match name {
                    "MOV" => value,
                    "MVN" => !value,
                    "NEG" => value.wrapping_neg(),
                    "BCD" if value > 9_999 => return None,
                    "BCD" => u16::from_str_radix(&value.to_string(), 16).ok()?,
                    _ => format!("{value:x}").parse().ok()?,
                };
                let to = self.place(operands[1])?;
                self.write(to, value);
            }
            "MOVL" => {
                let (low, high) = match operands[0].strip_prefix('&') {
                    Some(digits) => {
                        let all: u32 = digits.parse().ok()?;
                        (all as u16, (all >> 16) as u16)
                    }
                    None => {
                        let (area, first) = self.place(operands[0])?;
                        (self.word((area, first)), self.word((area, first + 1)))
                    }
                };
                let (area, to) = self.place(operands[1])?;
                self.write((area, to), low);
                self.write((area, to + 1), high);
            }
            "MOVR" => {
                let (_, first) = self.place(operands[0])?;
                let register = self.place(operands[1])?;
                self.memory.insert(register, D0 + first);
            }
            "XCHG" => {
                let (a, b) = (self.place(operands[0])?, self.place(operands[1])?);
                let (x, y) = (self.word(a), self.word(b));
                self.write(a, y);
                self.write(b, x);
            }
            "++" | "--" | "COM" | "ASL" | "ASR" => {
                let place = self.place(operands[0])?;
                let old = self.word(place);
                let new = match name {
                    "++" => old.wrapping_add(1),
                    "--" => old.wrapping_sub(1),
                    "COM" => !old,
                    "ASL" => old << 1,
                    _ => old >> 1,
                };
                self.write(place, new);
            }
            "+" | "-" | "ANDW" | "ORW" | "XORW" | "+B" | "-B" => {
                let (a, b) = (self.get(operands[0])?, self.get(operands[1])?);
                let decimal = |x: u16| format!("{x:x}").parse::<i32>().ok();
                let value = match name {
                    "+" => a.wrapping_add(b),
                    "-" => a.wrapping_sub(b),
                    "ANDW" => a & b,
                    "ORW" => a | b,
                    "XORW" => a ^ b,
                    _ => {
                        let (a, b) = (decimal(a)?, decimal(b)?);
                        let sum = if name == "+B" { a + b } else { a - b };
                        u16::from_str_radix(&sum.rem_euclid(10_000).to_string(), 16).ok()?
                    }
                };
                let to = self.place(operands[2])?;
                self.write(to, value);
            }
            "*U" | "/U" | "*" | "/" => {
                let (a, b) = (self.get(operands[0])?, self.get(operands[1])?);
                let (low, high) = match name {
                    "*U" => {
                        let all = u32::from(a) * u32::from(b);
                        (all as u16, (all >> 16) as u16)
                    }
                    "*" => {
                        let all = signed(a) * signed(b);
                        (all as u16, (all >> 16) as u16)
                    }
                    _ if b == 0 => return None,
                    "/U" => (a / b, a % b),
                    // The only quotient that does not fit into a word.
                    _ if signed(b) == -1 && a == 0x8000 => return None,
                    _ => ((signed(a) / signed(b)) as u16, (signed(a) % signed(b)) as u16),
                };
                let (area, to) = self.place(operands[2])?;
                self.write((area, to), low);
                self.write((area, to + 1), high);
            }
            "CMP" => {
                let (a, b) = (self.get(operands[0])?, self.get(operands[1])?);
                self.flags = [a > b, a == b, a < b];
            }
            "LMT" => {
                let value = signed(self.get(operands[0])?);
                let (area, first) = self.place(operands[1])?;
                let low = signed(self.word((area, first)));
                let high = signed(self.word((area, first + 1)));
                if low > high {
                    return None;
                }
                let to = self.place(operands[2])?;
                self.write(to, value.clamp(low, high) as u16);
            }
            "XFER" => {
                let count = self.get(operands[0])?;
                self.counts.push((number, count.into()));
                let (from, to) = (self.place(operands[1])?, self.place(operands[2])?);
                if !(self.fits(from, count.into()) && self.fits(to, count.into())) {
                    return None;
                }
                let words = self.list(from, count.into());
                for (word, n) in words.into_iter().zip(to.1..) {
                    self.write((to.0, n), word);
                }
                return Some(count.into());
            }
            "BSET" => {
                let value = self.get(operands[0])?;
                let (first, last) = (self.place(operands[1])?, self.place(operands[2])?);
                if first.1 > last.1 {
                    return None;
                }
                (first.1..=last.1).for_each(|n| self.write((first.0, n), value));
            }
            "BCNT" | "MAX" | "SUM" | "SRCH" => {
                let count = self.get(operands[0])?;
                self.counts.push((number, count.into()));
                if count == 0 {
                    return None;
                }
                let signed_words = name == "MAX" && {
                    let (area, first) = self.place(operands[0])?;
                    self.word((area, first + 1)) & 0x8000 != 0
                };
                let from = self.place(operands[1])?;
                if !self.fits(from, count.into()) {
                    return None;
                }
                let words = self.list(from, count.into());
                match name {
                    "BCNT" => {
                        let bits: u32 = words.iter().map(|word| word.count_ones()).sum();
                        if bits > 0xFFFF {
                            return None;
                        }
                        let to = self.place(operands[2])?;
                        self.write(to, bits as u16);
                    }
                    "MAX" => {
                        let greatest = match signed_words {
                            true => {
                                words.iter().map(|word| word.cast_signed()).max()?.cast_unsigned()
                            }
                            false => words.iter().copied().max()?,
                        };
                        let to = self.place(operands[2])?;
                        let (area, first) = self.place(operands[0])?;
                        // If requested, its address is written to IR0.
                        if self.word((area, first + 1)) & 0x4000 != 0 {
                            let at = words.iter().position(|word| *word == greatest)?;
                            self.memory.insert(("IR", 0), D0 + from.1 + at as u32);
                        }
                        self.write(to, greatest);
                    }
                    "SRCH" => {
                        let sought = self.get(operands[2])?;
                        if let Some(at) = words.iter().position(|word| *word == sought) {
                            self.memory.insert(("IR", 0), D0 + from.1 + at as u32);
                        }
                        let (area, first) = self.place(operands[0])?;
                        if self.word((area, first + 1)) & 0x8000 != 0 {
                            let matches = words.iter().filter(|word| **word == sought).count();
                            self.write(("DR", 0), matches as u16);
                        }
                    }
                    _ => {
                        // In words or bytes; no count depends on it, so the result may be any value.
                        let (area, to) = self.place(operands[2])?;
                        let sum = self.chance.below(u32::MAX);
                        self.write((area, to), sum as u16);
                        self.write((area, to + 1), (sum >> 16) as u16);
                    }
                }
                return Some(count.into());
            }
            other => panic!("{other}"),
        }
        Some(0)
    }
}
