//! What all parts of a program have in common while its instructions are put together: memory, instances, routines.

pub(super) use super::references::{Place, References};
use super::tally::Tally;
use super::types::{Extent, Kind, Ty, Types, first_name, is_elementary, layout};
use super::value::Value;
use scanbound_base::code::Code;
use scanbound_base::facts::{ActionOrder, StatedCall};
use scanbound_base::location::Location;
use scanbound_front::builder::{Builder, always};
use scanbound_iec::ast::Expr;
use scanbound_iec::fault::Fault;
use scanbound_iec::{Pou, Project, Variable};
use scanbound_ir::errors::is_zero;
use scanbound_ir::meaning::{Arithmetic, Meaning, Operand as Input, Operation, Target};
use scanbound_ir::{
    Area, AreaId, AreaKind, BitTarget, Cell, Logic, Number, Program, Radix, Region, Role, Step,
    Tag, TimingKey, Touched, Units, WordSource, WordTarget, Write,
};
use std::collections::{BTreeMap, BTreeSet};

/// The areas of variables, of what charts remember, and of values between.
const VARIABLES: [AreaId; 2] = [AreaId(0), AreaId(1)];
const HIDDEN: [AreaId; 2] = [AreaId(2), AreaId(3)];
const BETWEEN: [AreaId; 2] = [AreaId(4), AreaId(5)];

/// What of an instance is carried out.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum What {
    Body,
    Action(String),
    Method(String),
    /// The method of this name that the unit of this number has or inherits, whatever the instance's own unit has; without a
    /// name its body.
    Inherited(usize, String),
}

/// The most instances of function blocks in one variable.
const MOST_INSTANCES: u64 = 100_000;

/// An instance of a unit.
#[derive(Debug, Clone)]
pub(super) struct Instance {
    /// Its unit, an index into the project's.
    pub(super) pou: usize,
    /// Its variables.
    pub(super) place: Place,
}

/// What is carried out in one of several rounds.
pub(super) struct Turn {
    /// For each round, the instruction that says whether it is carried out in it.
    pub(super) says: Vec<usize>,
    /// For each round, the instructions that carry it out.
    pub(super) copies: Vec<std::ops::Range<usize>>,
}

/// Something that makes no difference if the rest of the program is as it mostly is.
pub(super) enum OpenEnd {
    /// The instruction writes a bit that is false if a timer's preset, these two words, never changes.
    Preset { at: usize, preset: Cell },
    /// The instruction writes a bit that is false if nothing but these instructions writes a variable.
    Variable { at: usize, cell: Cell, own: Vec<usize> },
    /// In which of several orders these have their turns, if none of them writes what another one reads or writes.
    Turns(Vec<Turn>),
    /// These instructions tell how long a step is active, which need not be told if nobody asks for it.
    StepTime { cell: Cell, own: Vec<usize> },
}

/// A program while it is put together.
pub(super) struct Emit<'p> {
    pub(super) builder: Builder,
    pub(super) project: &'p Project,
    pub(super) types: Types<'p>,
    pub(super) instances: Vec<Instance>,
    /// Those whose charts begin anew with every call.
    pub(super) begun_anew: BTreeSet<usize>,
    pub(super) by_name: BTreeMap<String, usize>,
    pub(super) globals: BTreeMap<String, Place>,
    /// The chart's memory, by instance and what of it.
    pub(super) charts: BTreeMap<(usize, What), Tag>,
    pub(super) routines: BTreeMap<(usize, What), usize>,
    /// Calls whose routines are not put together yet.
    pub(super) open: Vec<(usize, usize, What)>,
    /// Faults and their files.
    pub(super) faults: Vec<(usize, Fault)>,
    /// Values kept under names that begin with `~`, in the routine that is put together.
    pub(super) kept: BTreeMap<String, Value>,
    /// How large they are, of those that are not followed.
    pub(super) kept_extents: BTreeMap<String, Extent>,
    /// Instructions that give back what was handed over in and out, with the file of the call and its line.
    pub(super) given_back: Vec<(std::ops::Range<usize>, usize, u32)>,
    pub(super) tally: Tally,
    /// For each thing that controllers do differently, the bit that says whether the one of a real run does it another way
    /// than the standard.
    pub(super) readings: BTreeMap<&'static str, Cell>,
    pub(super) open_ends: Vec<OpenEnd>,
    /// The bits that say that RETURN ended an action.
    pub(super) returned: BTreeMap<(usize, What), Cell>,
    /// The presets of timers that are called without one.
    pub(super) presets_left: BTreeSet<Cell>,
    /// The times of steps that are asked for.
    pub(super) times_read: BTreeSet<Cell>,
    /// What counters stand at, and where they are through, as far as it is asked for.
    pub(super) counts: BTreeSet<Cell>,
    pub(super) references: References,
    /// Whether variables have to lie in the same places the next time.
    keeps_places: bool,
    /// Whether a declaration gives an instance or a structure values for its parts.
    pub(super) gives_parts: bool,
    between: [u32; 2],
    pub(super) file: usize,
    /// How many tasks there are.
    pub(super) tasks: usize,
    /// The number of the task whose routines are put together.
    pub(super) task: usize,
    /// Whether charts carry out actions before they look at transitions.
    pub(super) actions_first: bool,
    /// Whether methods are carried out before the first scan that no block names.
    pub(super) begins_with_more: bool,
    /// Whether of transitions that compete and of which one has no priority, all clear that are true.
    pub(super) all_clear: bool,
    /// In which order charts carry out actions, as the user states.
    pub(super) action_order: Option<ActionOrder>,
    /// Whether others than the program may write variables.
    pub(super) others_write: bool,
    /// Whether the controller stops at a division by zero and the like.
    pub(super) stops_on_error: bool,
    /// What is stated of units whose bodies are not there, by name as [`scanbound_base::facts::plain`] has it.
    pub(super) calls: BTreeMap<String, StatedCall>,
    /// How often loops are stated to go round, by their places.
    pub(super) stated_turns: BTreeMap<String, (i64, i64)>,
    /// Whether a loop of which nothing is known is taken to go round any number of times, to see what can be stated.
    pub(super) is_incomplete: bool,
}

impl<'p> Emit<'p> {
    pub(super) fn new(project: &'p Project, dialect: &str) -> Emit<'p> {
        let area = |name: &str, kind, role| Area { role, ..Area::new(name, kind, Radix::Decimal) };
        let mut program = Program { dialect: dialect.to_owned(), ..Program::default() };
        for (name, role) in
            [("variable ", Role::Memory), ("chart ", Role::Memory), ("value ", Role::Hidden)]
        {
            program.areas.push(area(name, AreaKind::Bit, role));
            program.areas.push(area(&format!("{name}word "), AreaKind::Word, role));
        }
        let tally = Tally::of(project, &mut program.statements);
        Emit {
            tally,
            builder: Builder::new(program),
            project,
            types: Types::new(project),
            instances: Vec::new(),
            begun_anew: BTreeSet::new(),
            by_name: BTreeMap::new(),
            globals: BTreeMap::new(),
            charts: BTreeMap::new(),
            routines: BTreeMap::new(),
            open: Vec::new(),
            faults: Vec::new(),
            kept: BTreeMap::new(),
            kept_extents: BTreeMap::new(),
            given_back: Vec::new(),
            readings: BTreeMap::new(),
            open_ends: Vec::new(),
            returned: BTreeMap::new(),
            presets_left: BTreeSet::new(),
            times_read: BTreeSet::new(),
            counts: BTreeSet::new(),
            references: References::default(),
            keeps_places: false,
            gives_parts: gives_parts(project),
            between: [0, 0],
            file: 0,
            tasks: 1,
            task: 0,
            actions_first: false,
            begins_with_more: false,
            all_clear: false,
            action_order: None,
            others_write: true,
            stops_on_error: true,
            calls: BTreeMap::new(),
            stated_turns: BTreeMap::new(),
            is_incomplete: false,
        }
    }

    pub(super) fn program(&mut self) -> &mut Program {
        &mut self.builder.program
    }

    /// A variable of its own.
    pub(super) fn variable(&mut self, name: &str, ty: Ty, line: u32) -> Result<Place, Fault> {
        let instances = self.types.instances(&ty);
        if instances > MOST_INSTANCES {
            let what = format!("{name} holds {instances} instances of function blocks");
            let help = format!("a variable or a program may hold {MOST_INSTANCES}");
            return Err(Fault::new(line, what).code(Code::TooLarge).help(help));
        }
        let (known, is_again) = self.references.variable(name);
        if let Some(known) = known {
            if is_again {
                let what = format!("there are two variables {name}");
                let help = "give one of them another name: references tell them apart by it";
                return Err(Fault::new(line, what).code(Code::NotModelled).help(help));
            }
            return Ok(known);
        }
        let place = Place { name: name.to_owned(), tag: self.placed(name, &ty, line)?, ty };
        if self.keeps_places {
            self.references.add_variable(&place);
        }
        Ok(place)
    }

    fn placed(&mut self, name: &str, ty: &Ty, line: u32) -> Result<Tag, Fault> {
        self.program().tags.add(VARIABLES, name, layout(ty)).ok_or_else(|| {
            Fault::new(line, format!("there is no room for {name}")).code(Code::TooLarge)
        })
    }

    /// Begins with what is known of references; variables lie where they lay.
    pub(super) fn begin_with(&mut self, references: References) -> Result<(), Fault> {
        self.keeps_places = true;
        for place in references.variables() {
            self.placed(&place.name, &place.ty, 1)?;
        }
        self.references = references;
        Ok(())
    }

    /// Memory of a chart.
    pub(super) fn hidden(&mut self, name: &str, of: scanbound_ir::Type) -> Option<Tag> {
        self.program().tags.add(HIDDEN, name, of)
    }

    /// The type of the part of this name.
    pub(super) fn part_type(place: &Place, name: &str) -> Option<Ty> {
        let (Ty::Parts(parts) | Ty::Standard(_, parts) | Ty::Block(_, parts)) = &place.ty else {
            return None;
        };
        let name = match &place.ty {
            Ty::Standard(kind, _) => first_name(kind, name),
            _ => name,
        };
        parts.named(name).map(|(_, ty)| ty.clone())
    }

    /// The part of this name, in upper or lower case.
    pub(super) fn part(place: &Place, name: &str) -> Option<Place> {
        let (Ty::Parts(parts) | Ty::Standard(_, parts) | Ty::Block(_, parts)) = &place.ty else {
            return None;
        };
        let name = match &place.ty {
            Ty::Standard(kind, _) => first_name(kind, name),
            _ => name,
        };
        let (own, ty) = parts.named(name)?;
        let tag = place.tag.part(own)?;
        Some(Place { name: format!("{}.{own}", place.name), tag, ty: ty.clone() })
    }

    /// The instance at a place.
    pub(super) fn instance(&mut self, place: &Place, pou: usize) -> usize {
        let key = place.name.to_ascii_uppercase();
        if let Some(&known) = self.by_name.get(&key) {
            return known;
        }
        self.instances.push(Instance { pou, place: place.clone() });
        self.by_name.insert(key, self.instances.len() - 1);
        self.instances.len() - 1
    }

    pub(super) fn pou_of(&self, instance: usize) -> &'p Pou {
        &self.project.pous[self.instances[instance].pou]
    }

    /// What is added from here on stands at this line of a unit's file.
    pub(super) fn at(&mut self, line: u32, text: &str) {
        let file = u32::try_from(self.file).unwrap_or(u32::MAX);
        let text: String = text.chars().take(120).collect();
        self.builder.at(Location { file, line, step: None }, text.into(), [].into());
        self.program().blocks += 1;
    }

    /// How something is priced: by its rows' names, the most specific first, else by its class.
    pub(super) fn key(names: &[&str], class: &'static str) -> TimingKey {
        TimingKey {
            names: names.iter().map(|name| (*name).to_owned()).collect(),
            class,
            units: Units::None,
            dearer: false,
            optional: false,
            touched: Touched::default(),
        }
    }

    /// Charges something that changes nothing by itself.
    pub(super) fn cost(&mut self, names: &[&str], class: &'static str) {
        self.builder.add(Some(Self::key(names, class)), Vec::new(), Step::Nothing);
    }

    /// Writes, without a charge.
    pub(super) fn write(&mut self, writes: Vec<Write>) -> usize {
        self.builder.add(None, writes.into_iter().map(always).collect(), Step::Nothing)
    }

    /// Writes where a condition holds; charged, if a row is named.
    pub(super) fn write_if(
        &mut self,
        fires: Logic,
        writes: Vec<Write>,
        key: Option<TimingKey>,
    ) -> usize {
        let effects = writes.into_iter().map(scanbound_front::builder::fired).collect();
        self.builder.add(key, effects, Step::Act { fires })
    }

    /// Whether a cell is for values between.
    pub(super) fn is_between(cell: Cell) -> bool {
        BETWEEN.contains(&cell.area)
    }

    /// A bit for a value between.
    pub(super) fn bit_between(&mut self) -> Cell {
        self.between[0] += 1;
        Cell { area: BETWEEN[0], index: self.between[0] - 1 }
    }

    /// Words for a value between; the first.
    pub(super) fn words_between(&mut self, words: u32) -> Cell {
        self.between[1] += words;
        Cell { area: BETWEEN[1], index: self.between[1] - words }
    }

    /// The words of a number, kept between if they have to be.
    pub(super) fn words(&mut self, number: Number, words: u32) -> Vec<WordSource> {
        if let Number::Words(words) = number {
            return words;
        }
        let first = self.words_between(words);
        let targets = (0..words).map(|at| WordTarget::Cell(first.plus(at))).collect();
        self.write(vec![Write::Words(targets, number)]);
        (0..words).map(|at| WordSource::Cell(first.plus(at))).collect()
    }

    /// A bit kept as it is now.
    pub(super) fn keep_bit(&mut self, value: Logic) -> Logic {
        if matches!(value, Logic::Const(_)) {
            return value;
        }
        let cell = self.bit_between();
        self.write(vec![Write::Bit(BitTarget::Cell(cell), value)]);
        Logic::cell(cell)
    }

    /// A number that an operation gives, in so many words; any value, where it has no meaning.
    pub(super) fn worked_out(
        &mut self,
        words: u32,
        meaning: Option<(Operation, Vec<Input>, u32)>,
    ) -> Number {
        let first = self.words_between(words);
        let choice = self.builder.choice();
        let mut error = None;
        if let Some((operation, inputs, wide)) = meaning {
            // What the operation gives beyond the words that are asked for is lost.
            let target = |at| match at < words {
                true => WordTarget::Cell(first.plus(at)),
                false => WordTarget::Discard,
            };
            let outputs = vec![Target::Words((0..wide).map(target).collect())];
            let meaning = Meaning { operation, inputs, outputs };
            error = self.error_of(&meaning);
            self.builder.followed(choice, meaning);
        }
        let at = self.write(vec![Write::Havoc(Region::Range { first, count: words }, choice)]);
        self.program().errors.extend(error.map(|error| (at, error)));
        Number::Words((0..words).map(|at| WordSource::Cell(first.plus(at))).collect())
    }

    /// When a controller stops where it works something out: at a divisor of zero, and at an element that is not there.
    fn error_of(&self, meaning: &Meaning) -> Option<Logic> {
        let divisor = match (&meaning.operation, &meaning.inputs[..]) {
            (Operation::Real(Arithmetic::Divide), [_, Input::Number(divisor)]) => {
                let size = [u16::MAX, 0x7FFF].map(WordSource::Const).to_vec();
                let size = Box::new(Number::Words(size));
                Some(is_zero(&Number::And(Box::new(divisor.clone()), size)))
            }
            (Operation::DivideJoined { .. } | Operation::Copy, _) => meaning.error(),
            _ => None,
        };
        divisor.filter(|_| self.stops_on_error)
    }

    /// Notes that the controller stops here where this holds.
    pub(super) fn stops_where(&mut self, error: Logic) {
        if self.stops_on_error {
            let at = self.builder.add(None, Vec::new(), Step::Nothing);
            self.program().errors.insert(at, error);
        }
    }

    /// Any number, and why.
    pub(super) fn any_number(&mut self, kind: Kind, why: &str) -> Number {
        let number = self.worked_out(kind.words(), None);
        let at = self.builder.next() - 1;
        self.program().approximate(at, why);
        number
    }

    /// Any bit, and why.
    pub(super) fn any_bit(&mut self, why: &str) -> Logic {
        let bit = self.builder.free_bit();
        let kept = self.keep_bit(bit);
        let at = self.builder.next() - 1;
        self.program().approximate(at, why);
        kept
    }

    /// A bit of how much time has passed, which a run from power-up does not count.
    pub(super) fn uncounted_bit(&mut self) -> Logic {
        let choice = self.builder.world();
        self.builder.program.timekeeping.uncounted.insert(choice);
        Logic::Bit(scanbound_ir::BitSource::Free(choice))
    }

    /// A bit that the outside gives.
    pub(super) fn world_bit(&mut self) -> Logic {
        Logic::Bit(scanbound_ir::BitSource::Free(self.builder.world()))
    }

    /// Calls a routine of an instance where a condition holds.
    pub(super) fn call(&mut self, fires: Logic, instance: usize, what: What, row: &str) {
        let key = Self::key(&[row, "CAL"], "call");
        let at = self.builder.add(Some(key), Vec::new(), Step::Call { fires, target: 0 });
        self.open.push((at, instance, what));
    }

    /// A jump whose target is set later.
    pub(super) fn jump(&mut self, fires: Logic, key: Option<TimingKey>) -> usize {
        self.builder.add(key, Vec::new(), Step::Jump { fires, target: 0 })
    }

    /// Lets a jump go to what is added next.
    pub(super) fn land(&mut self, jump: usize) {
        let next = self.builder.next();
        if let Step::Jump { target, .. } = &mut self.builder.program.instructions[jump].step {
            *target = next;
        }
    }

    /// Somewhere for jumps to land that need not be a statement.
    pub(super) fn landing(&mut self) {
        self.builder.add(None, Vec::new(), Step::Nothing);
    }
}

/// Whether a declaration gives an instance or a structure values for its parts.
fn gives_parts(project: &Project) -> bool {
    let gives = |one: &Variable| {
        !is_elementary(one) && !matches!(one.initial, None | Some(Expr::Literal(_)))
    };
    let units = project.pous.iter().map(|pou| &pou.variables);
    let mut all = units.chain(project.globals.iter().map(|(_, list)| list)).flatten();
    all.any(gives)
}
