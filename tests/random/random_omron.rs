//! Random OMRON programs in both spellings, run on an emulator of their own on every state: the bound is the
//! longest scan.

use common::bound::bound;
use common::passed::passed;
use common::tape::{Tape, cases, on_tapes};
use scanbound::base::facts::Facts;
use scanbound::base::time::{Picos, Times};
use scanbound::front::{Input, Options, read};
use scanbound::program::Program;
use scanbound::replay::replay;
use scanbound::solve::Method;

/// Which spelling a program is written in.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Spelling {
    C200h,
    Cx,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Bit {
    Input(u8),
    Relay(u8),
    Done(u8),
    Counted(u8),
    Greater,
    Less,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Edge {
    None,
    Rising,
    Falling,
}

/// An instruction; each is a line of the source. `usize` names the instruction's own memory.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Op {
    Load(Bit, bool),
    And(Bit, bool),
    Or(Bit, bool),
    AndBlock,
    OrBlock,
    Save,
    Fetch,
    Out(u8),
    OutNot(u8),
    Set(u8),
    Reset(u8),
    Keep(u8),
    Rise(u8, usize),
    Fall(u8, usize),
    Timer(u8, usize),
    Counter(u8, usize),
    Move(u16, Edge, usize),
    Compare(u16),
    Interlock,
    InterlockEnd,
    Jump(u8),
    JumpEnd(u8),
    Call,
    Routine,
    Return,
    End,
}

struct Generator<'t, 'a> {
    tape: &'t mut Tape<'a>,
    ops: Vec<Op>,
    memories: usize,
    jumps: u8,
    interlocked: bool,
}

impl Generator<'_, '_> {
    fn bit(&mut self) -> Bit {
        match self.tape.below(9) {
            0..3 => Bit::Input(self.tape.below(3) as u8),
            3..5 => Bit::Relay(self.tape.below(3) as u8),
            5 => Bit::Done(self.tape.below(1) as u8),
            6 => Bit::Counted(self.tape.below(1) as u8),
            7 => Bit::Greater,
            _ => Bit::Less,
        }
    }

    fn memory(&mut self) -> usize {
        self.memories += 1;
        self.memories - 1
    }

    fn condition(&mut self) {
        let (bit, negated) = (self.bit(), self.tape.percent(30));
        self.ops.push(Op::Load(bit, negated));
        for _ in 0..self.tape.below(3) {
            let (bit, negated) = (self.bit(), self.tape.percent(30));
            match self.tape.below(4) {
                0 | 1 => self.ops.push(Op::And(bit, negated)),
                2 => self.ops.push(Op::Or(bit, negated)),
                _ => {
                    self.ops.push(Op::Load(bit, negated));
                    let other = self.bit();
                    self.ops.push(if self.tape.percent(50) {
                        Op::And(other, false)
                    } else {
                        Op::Or(other, true)
                    });
                    self.ops.push(if self.tape.percent(50) { Op::AndBlock } else { Op::OrBlock });
                }
            }
        }
    }

    fn coil(&mut self) {
        let relay = self.tape.below(3) as u8;
        let op = match self.tape.below(11) {
            0 | 1 => Op::Out(relay),
            2 => Op::OutNot(relay),
            3 => Op::Set(relay),
            4 => Op::Reset(relay),
            5 if self.memories < 3 => Op::Rise(relay, self.memory()),
            6 if self.memories < 3 => Op::Fall(relay, self.memory()),
            7 if self.memories < 3 => Op::Timer(0, self.memory()),
            8 => Op::Compare(self.tape.below(3) as u16),
            9 if self.memories < 3 && self.tape.percent(50) => {
                let edge = if self.tape.percent(50) { Edge::Rising } else { Edge::Falling };
                Op::Move(self.tape.below(3) as u16, edge, self.memory())
            }
            _ => Op::Move(self.tape.below(3) as u16, Edge::None, 0),
        };
        self.ops.push(op);
    }

    fn rung(&mut self, routine: bool) {
        self.condition();
        match self.tape.below(10) {
            0 => {
                self.condition();
                let relay = self.tape.below(3) as u8;
                let op = if self.memories < 3 && self.tape.percent(50) {
                    Op::Counter(0, self.memory())
                } else {
                    Op::Keep(relay)
                };
                self.ops.push(op);
            }
            1 => {
                self.ops.push(Op::Save);
                let bit = self.bit();
                self.ops.push(Op::And(bit, false));
                self.coil();
                self.ops.push(Op::Fetch);
                let bit = self.bit();
                self.ops.push(Op::And(bit, true));
                self.coil();
            }
            2 if !self.interlocked => {
                self.jumps += 1;
                let number = self.jumps;
                self.ops.push(Op::Jump(number));
                for _ in 0..self.tape.below(3) {
                    self.rung(routine);
                }
                self.ops.push(Op::JumpEnd(number));
            }
            3 if !self.interlocked => {
                self.interlocked = true;
                self.ops.push(Op::Interlock);
                for _ in 0..1 + self.tape.below(2) {
                    self.rung(routine);
                }
                self.ops.push(Op::InterlockEnd);
                self.interlocked = false;
            }
            // Twice would be twice at the same memories.
            4 if !routine && !self.ops.contains(&Op::Call) => self.ops.push(Op::Call),
            5 => {
                self.coil();
                let bit = self.bit();
                self.ops.push(Op::And(bit, false));
                self.coil();
            }
            _ => self.coil(),
        }
    }
}

/// A program: its instructions, and how many memories of their own they have.
fn generate(tape: &mut Tape<'_>) -> (Vec<Op>, usize) {
    let mut g = Generator { tape, ops: Vec::new(), memories: 0, jumps: 0, interlocked: false };
    for _ in 0..1 + g.tape.below(6) {
        g.rung(false);
    }
    if g.ops.contains(&Op::Call) {
        g.ops.push(Op::Routine);
        g.rung(true);
        g.ops.push(Op::Return);
    }
    g.ops.push(Op::End);
    (g.ops, g.memories)
}

fn bit_text(bit: Bit, spelling: Spelling) -> String {
    match (bit, spelling) {
        (Bit::Input(n), Spelling::C200h) => format!("000{n:02}"),
        (Bit::Input(n), Spelling::Cx) => format!("0.{n:02}"),
        (Bit::Relay(n), Spelling::C200h) => format!("010{n:02}"),
        (Bit::Relay(n), Spelling::Cx) => format!("W10.{n:02}"),
        (Bit::Done(n), Spelling::C200h) => format!("TIM {n:03}"),
        (Bit::Done(n), Spelling::Cx) => format!("T{n:04}"),
        (Bit::Counted(n), Spelling::C200h) => format!("CNT {:03}", n + 10),
        (Bit::Counted(n), Spelling::Cx) => format!("C{:04}", n + 10),
        (Bit::Greater, Spelling::C200h) => "25505".to_owned(),
        (Bit::Greater, Spelling::Cx) => "P_GT".to_owned(),
        (Bit::Less, Spelling::C200h) => "25507".to_owned(),
        (Bit::Less, Spelling::Cx) => "P_LT".to_owned(),
    }
}

fn text(op: Op, spelling: Spelling) -> String {
    let c = spelling == Spelling::C200h;
    let bit = |bit| bit_text(bit, spelling);
    let name = |two: &str, one: &str| if c { two.to_owned() } else { one.to_owned() };
    let function = |name: &str, number: u32| {
        if c { format!("{name}({number:02})") } else { format!("{name}({number:03})") }
    };
    let contact = |name: &str, negated: bool| match (negated, c) {
        (false, _) => name.to_owned(),
        (true, true) => format!("{name} NOT"),
        (true, false) => format!("{name}NOT"),
    };
    let word = if c { "DM 0000" } else { "D0" };
    match op {
        Op::Load(at, negated) => format!("{} {}", contact("LD", negated), bit(at)),
        Op::And(at, negated) => format!("{} {}", contact("AND", negated), bit(at)),
        Op::Or(at, negated) => format!("{} {}", contact("OR", negated), bit(at)),
        Op::AndBlock => name("AND LD", "ANDLD"),
        Op::OrBlock => name("OR LD", "ORLD"),
        Op::Save => name("OUT TR 0", "OUT TR0"),
        Op::Fetch => name("LD TR 0", "LD TR0"),
        Op::Out(n) => format!("OUT {}", bit(Bit::Relay(n))),
        Op::OutNot(n) => format!("{} {}", contact("OUT", true), bit(Bit::Relay(n))),
        Op::Set(n) => format!("SET {}", bit(Bit::Relay(n))),
        Op::Reset(n) => format!("RSET {}", bit(Bit::Relay(n))),
        Op::Keep(n) => format!("{} {}", function("KEEP", 11), bit(Bit::Relay(n))),
        Op::Rise(n, _) => format!("{} {}", function("DIFU", 13), bit(Bit::Relay(n))),
        Op::Fall(n, _) => format!("{} {}", function("DIFD", 14), bit(Bit::Relay(n))),
        Op::Timer(n, _) => format!("TIM {n:03} #0010"),
        Op::Counter(n, _) => format!("CNT {:03} #0003", n + 10),
        Op::Move(value, edge, _) => {
            let mark = match edge {
                Edge::None => "",
                Edge::Rising => "@",
                Edge::Falling => "%",
            };
            format!("{mark}{} #{value:04} {word}", function("MOV", 21))
        }
        Op::Compare(value) => format!("{} {word} #{value:04}", function("CMP", 20)),
        Op::Interlock => function("IL", 2),
        Op::InterlockEnd => function("ILC", 3),
        Op::Jump(n) => format!("{} {n:02}", function("JMP", 4)),
        Op::JumpEnd(n) => format!("{} {n:02}", function("JME", 5)),
        Op::Call => format!("{} 01", function("SBS", 91)),
        Op::Routine => format!("{} 01", function("SBN", 92)),
        Op::Return => function("RET", 93),
        Op::End => function("END", 1),
    }
}

/// The PLC: what its program reads and writes, and each instruction's own memory.
#[derive(Debug, Clone, Default)]
struct Plc {
    inputs: u16,
    relays: u16,
    done: bool,
    counted: bool,
    greater: bool,
    less: bool,
    word: u16,
    memories: u16,
}

struct Emulator<'a> {
    ops: &'a [Op],
    times: &'a [Times],
    plc: Plc,
    total: Picos,
}

impl Emulator<'_> {
    fn bit(&self, bit: Bit) -> bool {
        match bit {
            Bit::Input(n) => self.plc.inputs >> n & 1 == 1,
            Bit::Relay(n) => self.plc.relays >> n & 1 == 1,
            Bit::Done(_) => self.plc.done,
            Bit::Counted(_) => self.plc.counted,
            Bit::Greater => self.plc.greater,
            Bit::Less => self.plc.less,
        }
    }

    fn write(&mut self, relay: u8, value: bool) {
        self.plc.relays = self.plc.relays & !(1 << relay) | u16::from(value) << relay;
    }

    /// Runs from `at` to END or RET; contacts and what has several branches cost the same on and off.
    fn run(&mut self, mut at: usize) {
        let mut stack: Vec<bool> = Vec::new();
        let mut branch = false;
        let mut lit = true;
        let mut fresh = true;
        loop {
            let op = self.ops[at];
            let mut on = true;
            let top = stack.last().copied().unwrap_or(false);
            let coil = !matches!(
                op,
                Op::Load(..)
                    | Op::And(..)
                    | Op::Or(..)
                    | Op::AndBlock
                    | Op::OrBlock
                    | Op::Save
                    | Op::Fetch
            );
            match op {
                Op::Load(bit, negated) => {
                    if fresh {
                        stack.clear();
                    }
                    stack.push(self.bit(bit) != negated);
                }
                Op::And(bit, negated) => {
                    *stack.last_mut().expect("a branch") &= self.bit(bit) != negated
                }
                Op::Or(bit, negated) => {
                    *stack.last_mut().expect("a branch") |= self.bit(bit) != negated
                }
                Op::AndBlock | Op::OrBlock => {
                    let (b, a) = (stack.pop().expect("two"), stack.pop().expect("two"));
                    stack.push(if op == Op::AndBlock { a && b } else { a || b });
                }
                Op::Save => branch = top,
                Op::Fetch => stack = vec![branch],
                Op::Out(n) => {
                    on = top && lit;
                    self.write(n, on);
                }
                Op::OutNot(n) => {
                    on = !top && lit;
                    self.write(n, on);
                }
                Op::Set(n) | Op::Reset(n) => {
                    on = top && lit;
                    if on {
                        self.write(n, matches!(op, Op::Set(_)));
                    }
                }
                Op::Keep(n) => {
                    let set = stack[stack.len() - 2];
                    if lit && (top || set) {
                        self.write(n, !top);
                    }
                }
                Op::Rise(n, memory) | Op::Fall(n, memory) => {
                    let before = self.plc.memories >> memory & 1 == 1;
                    on = lit
                        && if matches!(op, Op::Rise(..)) { top && !before } else { !top && before };
                    if lit {
                        self.write(n, on);
                    }
                }
                Op::Timer(_, memory) => {
                    on = top && lit;
                    self.plc.done = on && self.plc.memories >> memory & 1 == 1;
                }
                Op::Counter(_, memory) => {
                    let counts = stack[stack.len() - 2];
                    if lit && top {
                        self.plc.counted = false;
                    } else if lit && counts && self.plc.memories >> memory & 1 == 1 {
                        self.plc.counted = true;
                    }
                }
                Op::Move(value, edge, memory) => {
                    let before = self.plc.memories >> memory & 1 == 1;
                    on = match edge {
                        Edge::None => top && lit,
                        Edge::Rising => top && lit && !before,
                        Edge::Falling => !(top && lit) && before,
                    };
                    if on {
                        self.plc.word = value;
                    }
                }
                Op::Compare(value) => {
                    on = top && lit;
                    if on {
                        (self.plc.greater, self.plc.less) =
                            (self.plc.word > value, self.plc.word < value);
                    }
                }
                Op::Interlock => lit = top,
                Op::InterlockEnd => lit = true,
                Op::Jump(_) | Op::JumpEnd(_) | Op::Routine => {}
                Op::Call => on = top && lit,
                Op::Return | Op::End => {}
            }
            let Times { on: on_time, off: off_time, .. } = self.times[at];
            self.total += if on { on_time } else { off_time };
            fresh = coil;
            match op {
                Op::Jump(n) if !top => {
                    at = self.ops.iter().position(|&op| op == Op::JumpEnd(n)).expect("a JME")
                }
                Op::Call => {
                    if on {
                        self.run(
                            self.ops.iter().position(|&op| op == Op::Routine).expect("an SBN"),
                        );
                    }
                    at += 1;
                }
                Op::Return | Op::End => return,
                _ => at += 1,
            }
            // What comes next may be the subroutine, which is not run in passing.
            if self.ops[at] == Op::Routine && (op != Op::Call || coil) {
                at = self.ops.len() - 1;
            }
        }
    }
}

/// A time for each line; what is larger one way only costs that much both ways where a table can't tell them apart.
fn times(ops: &[Op]) -> Vec<Times> {
    let both = |op: Op| {
        !matches!(
            op,
            Op::Out(_)
                | Op::OutNot(_)
                | Op::Set(_)
                | Op::Reset(_)
                | Op::Rise(..)
                | Op::Fall(..)
                | Op::Timer(..)
                | Op::Move(..)
                | Op::Compare(_)
                | Op::Call
        )
    };
    let time = |(at, &op): (usize, &Op)| {
        let on = 1 + (at as u64 * 7919) % 101;
        let off = if both(op) { on } else { 1 + (at as u64 * 104_729) % 37 };
        Times::new(Picos(on), Picos(off))
    };
    ops.iter().enumerate().map(time).collect()
}

fn program(source: &str) -> Result<Program, String> {
    let input = Input { name: "a.txt".to_owned(), bytes: source.as_bytes().to_vec() };
    let project = read(&[input], None).map_err(|faults| format!("{faults:#?}"))?;
    let facts = Facts::default();
    let program = project.decode(&Options::new(&facts)).and_then(passed);
    let program = program.map_err(|faults| format!("{faults:#?}"))?;
    match program.dialect.as_str() {
        "omron-c200h" | "omron-cx" => Ok(program),
        other => Err(format!("taken for {other}")),
    }
}

fn check(tape: &[u16], spelling: Spelling) -> Result<(), String> {
    let (ops, memories) = generate(&mut Tape::new(tape));
    let source: Vec<String> = ops.iter().map(|&op| text(op, spelling)).collect();
    let source = source.join("\n");
    let told = |what: String| format!("{what}\n{source}");
    let program = program(&source).map_err(told)?;
    let times = times(&ops);
    let mut of_program = Vec::new();
    let mut lines = times.iter();
    for instruction in &program.instructions {
        of_program.push(match instruction.timing {
            Some(_) => *lines
                .next()
                .ok_or_else(|| told("more priced instructions than lines".to_owned()))?,
            None => Times::default(),
        });
    }
    let bound =
        bound(&program, &of_program, Method::Auto).map_err(|error| told(format!("{error:?}")))?;
    let reached = replay(&program, &of_program, &bound.best).total;
    let mut most = (Picos::ZERO, Plc::default());
    for state in 0..1u32 << (3 + 3 + 4 + memories) {
        for word in [0, 1, 2, 3] {
            let mut rest = state;
            let mut take = |bits: u32| {
                let value = rest & ((1 << bits) - 1);
                rest >>= bits;
                value as u16
            };
            let plc = Plc {
                inputs: take(3),
                relays: take(3),
                done: take(1) == 1,
                counted: take(1) == 1,
                greater: take(1) == 1,
                less: take(1) == 1,
                word,
                memories: take(memories as u32),
            };
            let mut emulator =
                Emulator { ops: &ops, times: &times, plc: plc.clone(), total: Picos::ZERO };
            emulator.run(0);
            if emulator.total > most.0 {
                most = (emulator.total, plc);
            }
        }
    }
    if bound.upper != most.0 || reached != most.0 {
        return Err(told(format!(
            "the bound is {:?}, its scan {reached:?}, the longest {:?} from {:?}",
            bound.upper, most.0, most.1
        )));
    }
    Ok(())
}

#[test]
fn the_bound_is_the_longest_scan_in_c200h_spelling() {
    on_tapes(cases(250), 120, |tape| check(tape, Spelling::C200h));
}

#[test]
fn the_bound_is_the_longest_scan_in_cx_programmer_spelling() {
    on_tapes(cases(250), 120, |tape| check(tape, Spelling::Cx));
}
