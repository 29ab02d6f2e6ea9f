//! The control structure of a project: labels, jumps, calls, loops, master control regions, step ladders and program
//! ends. It is checked before lowering.

mod targets;

use std::collections::{BTreeMap, BTreeSet};
use std::mem::take;

use super::memory::Family;
use super::operand::{HOW_TO_WRITE, Operand, Place};
use super::resolve::{Category, Control, DecodeOptions, Item, Resolved, fault, miscounted};
use scanbound_base::code::Code;
use scanbound_base::facts::normalized;
use scanbound_front::{Faults, absent};
use scanbound_ir::Cell;

/// The deepest nesting of loops that is accepted; no CPU allows as many.
const MAX_NESTING: usize = 64;

/// The number of the label P63, which on the FX means END and needs no label instruction.
const END_OF_FX: u32 = 63;

/// What an item (an instruction, see [`Item`]) does in the control structure. Numbers are the indices of other items,
/// unless said otherwise.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum Part {
    /// A pointer label.
    Label,
    /// The start of an interrupt program.
    Interrupt,
    /// A jump (also a BREAK) to the item with this index.
    Jump(usize),
    /// A call of the routine that begins at this item.
    Call(usize),
    /// A call of a routine that is not in the given files, with the routine's name in the facts file.
    Absent(String),
    /// A return from a routine or interrupt program.
    Return,
    /// The end of a step ladder.
    LadderEnd,
    /// An END or FEND.
    End,
    /// A stop of the CPU.
    Stop,
    /// The start of a loop (FOR), with the item of its NEXT; the item of the FOR itself as long as the NEXT is not
    /// known.
    For(usize),
    /// The end of a loop (NEXT).
    Next,
    /// The start of a master control region of this nesting level.
    Master(u32),
    /// The end of all regions from this nesting level on.
    MasterEnd(u32),
    /// The start of a step ladder state, with the step relays that must all be on for the state to be active.
    LadderState(Vec<Cell>),
}

/// The master control region and the step ladder state in which an item is.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(super) struct Site {
    /// The item that begins the innermost region around this item, a master control region or a step ladder state,
    /// which may prevent this item from acting. `None` if there is none. The item that begins a region is outside of
    /// it.
    pub(super) master: Option<usize>,
    /// The item that begins the step ladder state in which this item is. `None` outside of states.
    pub(super) state: Option<usize>,
}

/// The control structure of a project: routines, jumps, loops and master control regions.
#[derive(Debug, Default)]
pub(super) struct Structure {
    /// The control items by index. An item with a reported error is missing.
    parts: BTreeMap<usize, Part>,
    /// For each item: the regions in which it is.
    sites: Vec<Site>,
    /// For each file: the END to which its program jumps when it does not run. `None` if the program runs in every
    /// scan.
    skip_targets: Vec<Option<usize>>,
    /// The files that contain only routines and do not run by themselves.
    standby: BTreeSet<usize>,
}

impl Structure {
    /// What an item does in the control structure. `None` if nothing, or if an error in it was reported.
    pub(super) fn part(&self, item: usize) -> Option<&Part> {
        self.parts.get(&item)
    }

    /// The master control region and the step ladder state in which an item is.
    pub(super) fn site(&self, item: usize) -> Site {
        self.sites.get(item).copied().unwrap_or_default()
    }

    /// The END (an item) to which a file's program may jump at once, because it need not run in every scan. `None` if
    /// it runs in every scan.
    pub(super) fn skip_target(&self, file: usize) -> Option<usize> {
        self.skip_targets.get(file).copied().flatten()
    }

    /// The name of the routine for each call of a missing routine.
    pub(super) fn missing_routines(&self) -> impl Iterator<Item = &String> {
        self.parts.values().filter_map(|part| match part {
            Part::Absent(name) => Some(name),
            _ => None,
        })
    }

    /// Whether a file contains only routines and does not run by itself.
    pub(super) fn on_standby(&self, file: usize) -> bool {
        self.standby.contains(&file)
    }
}

/// Builds the control structure, and reports the errors in it. Jumps are checked only if nothing else was wrong before,
/// and ends of routines only if the jumps are right.
pub(super) fn structure(
    resolved: &Resolved<'_>,
    options: &DecodeOptions<'_>,
    faults: &mut [Faults<'_>],
) -> Structure {
    let mut walk = Checker {
        resolved,
        options,
        faults,
        structure: Structure::default(),
        file: 0,
        labels: vec![BTreeMap::new(); resolved.files.len()],
        wanted: Vec::new(),
        transfers: Vec::new(),
        loops: Vec::new(),
        masters: Vec::new(),
        state: None,
    };
    for file in 0..resolved.files.len() {
        walk.file(file);
    }
    walk.connect();
    walk.standby();
    walk.skip_targets();
    if !walk.faults.iter().any(Faults::any_error) {
        walk.check_jumps();
    }
    if !walk.faults.iter().any(Faults::any_error) {
        walk.check_routines();
    }
    walk.structure
}

/// A master control region or step ladder state that is open, with the item that begins it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum OpenRegion {
    Master(u32, usize),
    LadderState(usize),
}

impl OpenRegion {
    fn begin(self) -> usize {
        match self {
            OpenRegion::Master(_, begin) | OpenRegion::LadderState(begin) => begin,
        }
    }
}

/// The name of a routine in the facts file: `MAIN:P10` with a program, `P10` without. It is normalized, so that it can
/// be compared.
fn routine(program: Option<&str>, label: u32) -> String {
    // The text after a dot is the program's file name extension.
    let stem = |program: &str| program.split('.').next().unwrap_or(program).to_owned();
    let program = program.map_or(String::new(), |program| stem(program) + ":");
    normalized(&format!("{program}P{label}"))
}

/// A jump or call whose label is not resolved yet.
struct UnresolvedJump {
    item: usize,
    label: u32,
    /// The file in which the label is searched first.
    file: usize,
    /// Whether the label is searched only in this file.
    only: bool,
    is_call: bool,
}

/// A control transfer from one item to another.
#[derive(Debug, Clone, Copy)]
struct Transfer {
    from: usize,
    to: usize,
    /// The innermost regions around both items, which a jump must not cross; two times `None` for transfers to END.
    masters: [Option<usize>; 2],
}

/// Builds the control structure item by item, and reports the errors in it.
struct Checker<'r, 'f> {
    resolved: &'r Resolved<'r>,
    options: &'r DecodeOptions<'r>,
    faults: &'r mut [Faults<'f>],
    structure: Structure,
    /// The file that is being checked.
    file: usize,
    /// The labels of each file, and the items where they are.
    labels: Vec<BTreeMap<u32, usize>>,
    /// The jumps and calls so far. Their labels are resolved when all files are read.
    wanted: Vec<UnresolvedJump>,
    /// The control transfers so far that are checked later: jumps, and the skips over states and programs.
    transfers: Vec<Transfer>,
    /// The FOR items of open loops.
    loops: Vec<usize>,
    /// The master control regions and step ladder states that are open, the outermost first.
    masters: Vec<OpenRegion>,
    /// The item of the step ladder state that is open, and the item of the innermost region around it. `None` if no
    /// state is open.
    state: Option<(usize, Option<usize>)>,
}

impl<'r> Checker<'r, '_> {
    fn item(&self, at: usize) -> &'r Item<'r> {
        &self.resolved.items[at]
    }

    /// Reports an error at an item of the current file; `part` is a slice of the item's text or one of its words.
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

    /// Reports an error at an item of any file.
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
            // The instruction that begins a state or region is itself outside of it.
            let open = |begin: &usize| *begin != at;
            let master = self.masters.iter().rev().map(|region| region.begin()).find(open);
            let state = self.state.map(|(begin, _)| begin);
            self.structure.sites.push(Site { master, state });
            self.structure.parts.extend(part.map(|part| (at, part)));
        }
        self.end_of_file(items.end);
    }

    /// Finds what a control instruction does, and opens or closes its region or loop. `None` if this is found later
    /// (jumps and calls by label), or if an error was reported.
    fn control(&mut self, at: usize, control: Control) -> Option<Part> {
        let count = match control {
            Control::Break | Control::Master => 2,
            Control::Jump | Control::For | Control::MasterEnd | Control::LadderState => 1,
            Control::Call | Control::Label(_) | Control::Interrupt => self.item(at).operands.len(),
            _ => 0,
        };
        // This happens even if operands are wrong, so that no further error follows.
        let ends_state = match control {
            Control::LadderState | Control::End | Control::LadderEnd | Control::Return => {
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
            // Its NEXT is not known yet.
            Control::For => Part::For(at),
            Control::Next => return self.loop_ends(at),
            Control::Break => return self.breaks(at),
            Control::Master => return self.master_begins(at),
            Control::MasterEnd => return self.master_ends(at),
            Control::LadderState => return self.state_begins(at),
        })
    }

    fn takes(&mut self, at: usize, count: usize) -> bool {
        let fault = miscounted(self.item(at).raw, &self.resolved.project.files[self.file], count);
        let fits = fault.is_none();
        fault.into_iter().for_each(|fault| self.faults[self.file].push(fault));
        fits
    }

    /// Operand `n` of an item; reports an error and returns `None` if it is invalid.
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
        self.fault(at, Code::Operand, text, format!("`{text}` is not a {what}"), help);
        None
    }

    /// The label number in operand `n` of an item; reports an error and returns `None` if the operand is not a label.
    fn pointer(&mut self, at: usize, n: usize) -> Option<u32> {
        match self.operand(at, n)? {
            Operand::Pointer(label) => Some(*label),
            _ => self.wrong(at, n, "label", "write a label such as P10"),
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
            let message = format!("the label {name} exists twice in this file");
            self.fault(at, Code::DoubleLabel, name, message, "use a different label at each place");
        }
        Part::Label
    }

    fn jump(&mut self, at: usize) -> Option<Part> {
        let label = self.pointer(at, 0)?;
        if label == END_OF_FX && self.options.family == Family::Fx {
            return self.jump_to_end(at);
        }
        self.jump_to(at, label)
    }

    fn jump_to(&mut self, item: usize, label: u32) -> Option<Part> {
        let jump = UnresolvedJump { item, label, file: self.file, only: true, is_call: false };
        self.wanted.push(jump);
        None
    }

    fn jump_to_end(&mut self, at: usize) -> Option<Part> {
        let to = self.end_behind(self.file, at + 1);
        if to.is_none() {
            let message =
                "this jump leads to the END of the program, but no END or FEND comes after the jump".to_owned();
            self.fault(at, Code::NoEnd, "", message, "write END after the last instruction");
        }
        self.transfers.extend(to.map(|to| Transfer { from: at, to, masters: [None, None] }));
        to.map(Part::Jump)
    }

    /// The first END or FEND of a file at item `from` or after it. `None` if there is none.
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
        self.wanted.push(UnresolvedJump { item: at, label, file, only: by_file, is_call: true });
        None
    }

    /// The name of a program in the first operand of an item; reports an error and returns `None` if it is not a text.
    fn program(&mut self, at: usize) -> Option<&'r str> {
        match self.operand(at, 0)? {
            Operand::Text(name) => Some(name),
            _ => self.wrong(at, 0, "program name", "write the name in quotes"),
        }
    }

    /// The part for a call of a program that is not in the given files: an absent routine if that is allowed; otherwise
    /// reports an error and returns `None`.
    fn without_program(&mut self, at: usize, program: &str, label: u32) -> Option<Part> {
        let name = routine(Some(program), label);
        if self.may_lack(&name) {
            return Some(Part::Absent(name));
        }
        let message = format!("the program `{program}` is not among the given files");
        let text = &self.item(at).raw.operands[0];
        let help = absent::help(
            "give all files of the project, and give each file the name of the program in it",
            &name,
        );
        self.fault(at, Code::NoProgram, text, message, &help);
        None
    }

    /// Whether a call of this missing routine is allowed: its time is stated in the facts, or the option says that such
    /// calls take no time.
    fn may_lack(&self, name: &str) -> bool {
        self.options.absent_calls_take_no_time || self.options.facts.calls.contains_key(name)
    }

    fn loop_begins(&mut self, at: usize) {
        self.loops.push(at);
        if self.loops.len() > MAX_NESTING {
            let message = format!("loops are nested more than {MAX_NESTING} levels deep");
            self.fault(
                at,
                Code::Nesting,
                "FOR",
                message,
                "nest at most 16 loops: CPUs allow no more",
            );
        }
    }

    fn loop_ends(&mut self, at: usize) -> Option<Part> {
        let Some(begin) = self.loops.pop() else {
            let message = "`NEXT` has no FOR before it".to_owned();
            self.fault(at, Code::NoLoop, "NEXT", message, "begin the loop with FOR");
            return None;
        };
        if let Some(Part::For(next)) = self.structure.parts.get_mut(&begin) {
            *next = at;
        }
        if self.structure.sites[begin].master != self.masters.last().map(|region| region.begin()) {
            let message =
                "the loop overlaps with a master control region or a step ladder state".to_owned();
            let help = "put the whole loop inside the region or state, or the whole region or state inside the loop";
            self.fault(at, Code::CrossedMasterControl, "NEXT", message, help);
        }
        Some(Part::Next)
    }

    fn breaks(&mut self, at: usize) -> Option<Part> {
        if self.loops.is_empty() {
            let message = "`BREAK` is outside a loop".to_owned();
            let help = "put the instruction between FOR and NEXT";
            self.fault(at, Code::NoLoop, &self.item(at).name, message, help);
            return None;
        }
        let label = self.pointer(at, 1)?;
        self.jump_to(at, label)
    }

    fn master_begins(&mut self, at: usize) -> Option<Part> {
        let level = self.nesting(at)?;
        if let Some(&OpenRegion::Master(open, _)) = self.masters.last()
            && open >= level
        {
            let text = &self.item(at).raw.operands[0];
            let message = format!(
                "this region has level N{level}, but is inside a master control region of level N{open}"
            );
            let help = "give the inner region a higher level number";
            self.fault(at, Code::Nesting, text, message, help);
        }
        self.masters.push(OpenRegion::Master(level, at));
        Some(Part::Master(level))
    }

    fn master_ends(&mut self, at: usize) -> Option<Part> {
        let level = self.nesting(at)?;
        let is_open =
            |region: &OpenRegion| matches!(region, OpenRegion::Master(open, _) if *open == level);
        if !self.masters.iter().any(is_open) {
            let text = &self.item(at).raw.operands[0];
            let message = format!("no MC begins a region of level N{level} before this line");
            self.fault(at, Code::NoMasterControl, text, message, "begin the region with MC");
            return None;
        }
        // A state is above all nesting levels.
        self.masters
            .retain(|region| matches!(region, OpenRegion::Master(open, _) if *open < level));
        Some(Part::MasterEnd(level))
    }

    fn state_begins(&mut self, at: usize) -> Option<Part> {
        let relay = match self.operand(at, 0)? {
            Operand::Device(device) => match device.place {
                Place::At(kind, index) if device.name == "S" => kind.cell(index),
                _ => None,
            },
            _ => return self.wrong(at, 0, "device", "write a device"),
        };
        let Some(relay) = relay else {
            return self.wrong(at, 0, "step relay", "write S0, S1 ...");
        };
        // Consecutive STL instructions are in series: all relays must be on.
        let before =
            at.checked_sub(1).filter(|before| self.resolved.files[self.file].contains(before));
        let mut relays = match before.and_then(|before| self.structure.parts.get(&before)) {
            Some(Part::LadderState(relays)) => relays.clone(),
            _ => Vec::new(),
        };
        relays.push(relay);
        self.state = Some((at, self.masters.last().map(|region| region.begin())));
        self.masters.push(OpenRegion::LadderState(at));
        Some(Part::LadderState(relays))
    }

    /// Ends the step ladder state that is open before an item; the jump over the state leads to that item. Returns
    /// whether a state was open.
    fn close_state(&mut self, at: usize) -> bool {
        let Some((begin, around)) = self.state.take() else { return false };
        self.masters.retain(|region| matches!(region, OpenRegion::Master(..)));
        let masters = [around, self.masters.last().map(|region| region.begin())];
        self.transfers.push(Transfer { from: begin, to: at, masters });
        true
    }

    /// Ends the state that is open at the end of a file, and reports the first loop and the first region that are still
    /// open.
    fn end_of_file(&mut self, end: usize) {
        self.close_state(end);
        let (loops, masters) = (take(&mut self.loops), take(&mut self.masters));
        let Some(last) = end.checked_sub(1) else { return };
        if let Some(&begin) = loops.first() {
            let message = format!("the FOR in line {} has no NEXT", self.item(begin).raw.line);
            self.fault(last, Code::OpenLoop, "", message, "end the loop with NEXT");
        }
        if let Some(&OpenRegion::Master(level, begin)) = masters.first() {
            let line = self.item(begin).raw.line;
            let message = format!("the MC N{level} in line {line} has no MCR");
            self.fault(last, Code::OpenMasterControl, "", message, "end the region with MCR");
        }
    }
}
