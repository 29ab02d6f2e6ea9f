//! The frame of a project: labels, jumps, calls, loops, master control regions, step ladders and ends, checked before
//! anything is emitted.

mod routes;

use std::collections::{BTreeMap, BTreeSet};
use std::mem::take;

use super::memory::Family;
use super::operand::{HOW_TO_WRITE, Operand, Place};
use super::resolve::{Category, Control, DecodeOptions, Item, Resolved, fault, miscounted};
use scanbound_base::code::Code;
use scanbound_base::facts::normalized;
use scanbound_front::{Faults, absent};
use scanbound_ir::Cell;

/// Loops in each other beyond this are refused: no CPU can follow them either.
const MOST_NESTED: usize = 64;

/// The FX's P63 is END, without a label.
const END_OF_FX: u32 = 63;

/// What an item is in the frame. Others are named by their places among all items.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum Part {
    /// A pointer's label.
    Label,
    /// Where an interrupt program begins.
    Interrupt,
    /// A jump to a label or an end.
    Jump(usize),
    /// A call of the routine at a label.
    Call(usize),
    /// A call of a routine that is not there, by its name in the facts.
    Absent(String),
    /// The end of a routine.
    Return,
    /// The end of a step ladder.
    LadderEnd,
    /// The end of a program.
    End,
    /// A stop of the CPU.
    Stop,
    /// The beginning of the loop that this NEXT ends.
    For(usize),
    Next,
    /// The beginning of a master control region of this level.
    Master(u32),
    /// The end of all regions from this level on.
    MasterEnd(u32),
    /// A state of a step ladder, by the relays that must all be on.
    State(Vec<Cell>),
}

/// Where an item stands.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(super) struct Site {
    /// What began the innermost region that may hold it off, a master control or a state.
    pub(super) master: Option<usize>,
    /// The state of a step ladder.
    pub(super) state: Option<usize>,
}

/// How a project's items hang together.
#[derive(Debug, Default)]
pub(super) struct Frame {
    /// The items that make it. One whose fault was told is missing.
    parts: BTreeMap<usize, Part>,
    /// Where each item stands.
    sites: Vec<Site>,
    /// For each file whose program need not run in every scan, the end to which it goes then.
    rests: Vec<Option<usize>>,
    /// The files that hold routines alone and do not run by themselves.
    standby: BTreeSet<usize>,
}

impl Frame {
    /// What an item is in the frame.
    pub(super) fn part(&self, item: usize) -> Option<&Part> {
        self.parts.get(&item)
    }

    /// Where an item stands.
    pub(super) fn site(&self, item: usize) -> Site {
        self.sites.get(item).copied().unwrap_or_default()
    }

    /// The end to which a file's program goes that need not run in every scan.
    pub(super) fn rest(&self, file: usize) -> Option<usize> {
        self.rests.get(file).copied().flatten()
    }

    /// Whether a file holds routines alone and does not run by itself.
    pub(super) fn on_standby(&self, file: usize) -> bool {
        self.standby.contains(&file)
    }
}

/// Works the frame out, and tells all that is wrong with it.
pub(super) fn frame(
    resolved: &Resolved<'_>,
    options: &DecodeOptions<'_>,
    faults: &mut [Faults<'_>],
) -> Frame {
    let mut walk = Walk {
        resolved,
        options,
        faults,
        frame: Frame::default(),
        file: 0,
        labels: vec![BTreeMap::new(); resolved.files.len()],
        wanted: Vec::new(),
        leaps: Vec::new(),
        loops: Vec::new(),
        masters: Vec::new(),
        state: None,
    };
    for file in 0..resolved.files.len() {
        walk.file(file);
    }
    walk.connect();
    walk.standby();
    walk.rests();
    if !walk.faults.iter().any(Faults::any_error) {
        walk.check_leaps();
    }
    if !walk.faults.iter().any(Faults::any_error) {
        walk.check_routines();
    }
    walk.frame
}

/// The region that an open region is, by what began it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Region {
    Master(u32, usize),
    State(usize),
}

impl Region {
    fn begin(self) -> usize {
        match self {
            Region::Master(_, begin) | Region::State(begin) => begin,
        }
    }
}

/// A routine's name in the facts.
fn routine(program: Option<&str>, label: u32) -> String {
    // What stands behind a dot says a program's kind.
    let stem = |program: &str| program.split('.').next().unwrap_or(program).to_owned();
    let program = program.map_or(String::new(), |program| stem(program) + ":");
    normalized(&format!("{program}P{label}"))
}

/// A jump or call whose label is to be found.
struct Wanted {
    item: usize,
    label: u32,
    /// The file in which to look first.
    file: usize,
    /// No other will do.
    only: bool,
    is_call: bool,
}

/// A way of control that leads on from one item to another, whatever makes it.
#[derive(Debug, Clone, Copy)]
struct Leap {
    from: usize,
    to: usize,
    /// The regions on both sides.
    masters: [Option<usize>; 2],
}

struct Walk<'r, 'f> {
    resolved: &'r Resolved<'r>,
    options: &'r DecodeOptions<'r>,
    faults: &'r mut [Faults<'f>],
    frame: Frame,
    /// The file under way.
    file: usize,
    /// Where the labels of each file stand.
    labels: Vec<BTreeMap<u32, usize>>,
    wanted: Vec<Wanted>,
    leaps: Vec<Leap>,
    /// Open loops.
    loops: Vec<usize>,
    /// Open regions.
    masters: Vec<Region>,
    /// The open state of a step ladder, and the region around it.
    state: Option<(usize, Option<usize>)>,
}

impl<'r> Walk<'r, '_> {
    fn item(&self, at: usize) -> &'r Item<'r> {
        &self.resolved.items[at]
    }

    /// Tells a fault of an item of the file under way; `part` is a slice of it or a word of it.
    fn fault(&mut self, at: usize, code: Code, part: &str, message: String, help: &str) {
        self.fault_in(self.file, at, (code, part), message, help);
    }

    fn fault_in(
        &mut self,
        file: usize,
        at: usize,
        what: (Code, &str),
        message: String,
        help: &str,
    ) {
        let raw_file = &self.resolved.project.files[file];
        let fault = fault(self.item(at).raw, raw_file, what, message, help);
        self.faults[file].push(fault);
    }

    /// Tells a fault of an item of any file.
    fn fault_at(&mut self, at: usize, code: Code, message: String, help: &str) {
        let file = self.resolved.files.iter().position(|items| items.contains(&at));
        self.fault_in(file.unwrap_or(0), at, (code, ""), message, help);
    }

    fn file(&mut self, file: usize) {
        self.file = file;
        let items = self.resolved.files[file].clone();
        for at in items.clone() {
            let part = match self.item(at).category {
                Category::Control(control) => self.control(at, control),
                _ => None,
            };
            // A state begins behind itself, and a region of a master control too: both stand outside.
            let open = |begin: &usize| *begin != at;
            let master = self.masters.iter().rev().map(|region| region.begin()).find(open);
            let state = self.state.map(|(begin, _)| begin);
            self.frame.sites.push(Site { master, state });
            self.frame.parts.extend(part.map(|part| (at, part)));
        }
        self.end_of_file(items.end);
    }

    /// What a control instruction is in the frame; what it opens and closes.
    fn control(&mut self, at: usize, control: Control) -> Option<Part> {
        let count = match control {
            Control::Break | Control::Master => 2,
            Control::Jump | Control::For | Control::MasterEnd | Control::State => 1,
            Control::Call | Control::Label(_) | Control::Interrupt => self.item(at).operands.len(),
            _ => 0,
        };
        // States end and loops begin also where operands are at fault, so that no further fault follows.
        let ends_state = match control {
            Control::State | Control::End | Control::LadderEnd | Control::Return => {
                self.close_state(at)
            }
            Control::For => {
                self.loop_begins(at);
                false
            }
            _ => false,
        };
        if !self.takes(at, count) {
            return None;
        }
        Some(match control {
            Control::Label(label) => self.label(at, label),
            Control::Interrupt => Part::Interrupt,
            Control::Jump => return self.jump(at),
            Control::JumpToEnd => return self.jump_to_end(at),
            Control::Call => return self.call(at),
            Control::Return if ends_state => Part::LadderEnd,
            Control::Return | Control::OnlyReturn => Part::Return,
            Control::LadderEnd => Part::LadderEnd,
            Control::End => Part::End,
            Control::Stop => Part::Stop,
            // Its NEXT comes later.
            Control::For => Part::For(at),
            Control::Next => return self.loop_ends(at),
            Control::Break => return self.breaks(at),
            Control::Master => return self.master_begins(at),
            Control::MasterEnd => return self.master_ends(at),
            Control::State => return self.state_begins(at),
        })
    }

    fn takes(&mut self, at: usize, count: usize) -> bool {
        let fault = miscounted(self.item(at).raw, &self.resolved.project.files[self.file], count);
        let fits = fault.is_none();
        fault.into_iter().for_each(|fault| self.faults[self.file].push(fault));
        fits
    }

    /// What an operand says; a fault is told where it says nothing.
    fn operand(&mut self, at: usize, n: usize) -> Option<&'r Operand> {
        let item = self.item(at);
        match &item.operands[n] {
            Ok(operand) => Some(operand),
            Err(message) => {
                let text = &item.raw.operands[n];
                self.fault(at, Code::Operand, text, message.clone(), HOW_TO_WRITE);
                None
            }
        }
    }

    fn wrong<T>(&mut self, at: usize, n: usize, what: &str, help: &str) -> Option<T> {
        let text = &self.item(at).raw.operands[n];
        self.fault(at, Code::Operand, text, format!("`{text}` is no {what}"), help);
        None
    }

    /// The label that an operand names.
    fn pointer(&mut self, at: usize, n: usize) -> Option<u32> {
        match self.operand(at, n)? {
            Operand::Pointer(label) => Some(*label),
            _ => self.wrong(at, n, "label", "name a label such as P10"),
        }
    }

    fn nesting(&mut self, at: usize) -> Option<u32> {
        match self.operand(at, 0)? {
            Operand::Nesting(level) => Some(*level),
            _ => self.wrong(at, 0, "nesting level", "write N0 to N14"),
        }
    }

    fn label(&mut self, at: usize, label: u32) -> Part {
        if self.labels[self.file].insert(label, at).is_some() {
            let name = &*self.item(at).name;
            let message = format!("the label {name} stands twice in this file");
            self.fault(at, Code::DoubleLabel, name, message, "give each place a label of its own");
        }
        Part::Label
    }

    fn jump(&mut self, at: usize) -> Option<Part> {
        let label = self.pointer(at, 0)?;
        if label == END_OF_FX && self.options.family == Family::Fx {
            return self.jump_to_end(at);
        }
        self.wanted.push(Wanted { item: at, label, file: self.file, only: true, is_call: false });
        None
    }

    fn jump_to_end(&mut self, at: usize) -> Option<Part> {
        let to = self.end_behind(self.file, at + 1);
        if to.is_none() {
            let message = "the program has no END behind this jump to it".to_owned();
            self.fault(at, Code::NoEnd, "", message, "write END after the last instruction");
        }
        self.leaps.extend(to.map(|to| Leap { from: at, to, masters: [None, None] }));
        to.map(Part::Jump)
    }

    /// A file's next end from an item on.
    fn end_behind(&self, file: usize, from: usize) -> Option<usize> {
        let is_end =
            |at: &usize| matches!(self.item(*at).category, Category::Control(Control::End));
        (from..self.resolved.files[file].end).find(is_end)
    }

    fn call(&mut self, at: usize) -> Option<Part> {
        let item = self.item(at);
        let by_file = item.name.starts_with('E');
        let first = usize::from(by_file);
        if item.operands.len() <= first {
            self.takes(at, first + 1);
            return None;
        }
        let program = if by_file { self.program(at).map(Some) } else { Some(None) };
        let label = self.pointer(at, first);
        let (Some(program), Some(label)) = (program, label) else { return None };
        let file = program.map_or(Some(self.file), |program| self.resolved.named(program));
        let Some(file) = file else { return self.without_program(at, program?, label) };
        self.wanted.push(Wanted { item: at, label, file, only: by_file, is_call: true });
        None
    }

    /// The program that the first operand names.
    fn program(&mut self, at: usize) -> Option<&'r str> {
        match self.operand(at, 0)? {
            Operand::Text(name) => Some(name),
            _ => self.wrong(at, 0, "program's name", "write the name in quotes"),
        }
    }

    /// A call into a program that is not there.
    fn without_program(&mut self, at: usize, program: &str, label: u32) -> Option<Part> {
        let name = routine(Some(program), label);
        if self.may_lack(&name) {
            return Some(Part::Absent(name));
        }
        let message = format!("the program `{program}` is not among the files given");
        let text = &self.item(at).raw.operands[0];
        let help = absent::help("give all files of the project, each named as its program", &name);
        self.fault(at, Code::NoProgram, text, message, &help);
        None
    }

    /// Whether a routine may be called that is not there.
    fn may_lack(&self, name: &str) -> bool {
        self.options.absent_calls_take_no_time || self.options.facts.calls.contains_key(name)
    }

    fn loop_begins(&mut self, at: usize) {
        self.loops.push(at);
        if self.loops.len() > MOST_NESTED {
            let message = format!("more than {MOST_NESTED} loops stand in each other");
            self.fault(at, Code::Nesting, "FOR", message, "no CPU allows more than 16");
        }
    }

    fn loop_ends(&mut self, at: usize) -> Option<Part> {
        let Some(begin) = self.loops.pop() else {
            let message = "`NEXT` without a FOR before it".to_owned();
            self.fault(at, Code::NoLoop, "NEXT", message, "begin the loop with FOR");
            return None;
        };
        if let Some(Part::For(next)) = self.frame.parts.get_mut(&begin) {
            *next = at;
        }
        if self.frame.sites[begin].master != self.masters.last().map(|region| region.begin()) {
            let message = "the loop and a master control cut across each other".to_owned();
            let help = "close the one within the other";
            self.fault(at, Code::CrossedMasterControl, "NEXT", message, help);
        }
        Some(Part::Next)
    }

    fn breaks(&mut self, at: usize) -> Option<Part> {
        if self.loops.is_empty() {
            let message = "`BREAK` outside a loop".to_owned();
            let help = "it ends the loop of FOR and NEXT in which it stands";
            self.fault(at, Code::NoLoop, &self.item(at).name, message, help);
            return None;
        }
        let label = self.pointer(at, 1)?;
        self.wanted.push(Wanted { item: at, label, file: self.file, only: true, is_call: false });
        None
    }

    fn master_begins(&mut self, at: usize) -> Option<Part> {
        let level = self.nesting(at)?;
        if matches!(self.masters.last(), Some(Region::Master(open, _)) if *open >= level) {
            let text = &self.item(at).raw.operands[0];
            let message = format!("N{level} is open already");
            let help = "nest master controls with rising numbers";
            self.fault(at, Code::Nesting, text, message, help);
        }
        self.masters.push(Region::Master(level, at));
        Some(Part::Master(level))
    }

    fn master_ends(&mut self, at: usize) -> Option<Part> {
        let level = self.nesting(at)?;
        let is_open = |region: &Region| matches!(region, Region::Master(open, _) if *open == level);
        if !self.masters.iter().any(is_open) {
            let text = &self.item(at).raw.operands[0];
            let message = format!("no MC has opened N{level}");
            self.fault(at, Code::NoMasterControl, text, message, "open the master control with MC");
            return None;
        }
        // A state lies above all levels.
        self.masters.retain(|region| matches!(region, Region::Master(open, _) if *open < level));
        Some(Part::MasterEnd(level))
    }

    fn state_begins(&mut self, at: usize) -> Option<Part> {
        let relay = match self.operand(at, 0)? {
            Operand::Device(device) => match device.place {
                Place::At(kind, index) if device.name == "S" => kind.cell(index),
                _ => None,
            },
            _ => return self.wrong(at, 0, "device", "name a device"),
        };
        let Some(relay) = relay else {
            return self.wrong(at, 0, "step relay", "write S0, S1 ...");
        };
        // STL directly behind STL: both relays are needed.
        let before =
            at.checked_sub(1).filter(|before| self.resolved.files[self.file].contains(before));
        let mut relays = match before.and_then(|before| self.frame.parts.get(&before)) {
            Some(Part::State(relays)) => relays.clone(),
            _ => Vec::new(),
        };
        relays.push(relay);
        self.state = Some((at, self.masters.last().map(|region| region.begin())));
        self.masters.push(Region::State(at));
        Some(Part::State(relays))
    }

    /// Ends the open state in front of an item, if there is one: what runs it while it is off leads there.
    fn close_state(&mut self, at: usize) -> bool {
        let Some((begin, around)) = self.state.take() else { return false };
        self.masters.retain(|region| matches!(region, Region::Master(..)));
        let masters = [around, self.masters.last().map(|region| region.begin())];
        self.leaps.push(Leap { from: begin, to: at, masters });
        true
    }

    /// What must be closed when a file ends.
    fn end_of_file(&mut self, end: usize) {
        self.close_state(end);
        let (loops, masters) = (take(&mut self.loops), take(&mut self.masters));
        let Some(last) = end.checked_sub(1) else { return };
        if let Some(&begin) = loops.first() {
            let message = format!("the FOR in line {} has no NEXT", self.item(begin).raw.line);
            self.fault(last, Code::OpenLoop, "", message, "end the loop with NEXT");
        }
        if let Some(&Region::Master(level, begin)) = masters.first() {
            let line = self.item(begin).raw.line;
            let message = format!("the MC N{level} in line {line} has no MCR");
            self.fault(
                last,
                Code::OpenMasterControl,
                "",
                message,
                "end the master control with MCR",
            );
        }
    }
}
