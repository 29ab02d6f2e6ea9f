//! What all parts of a program have in common while its instructions are put together: memory, instances, routines.

use super::assembler::{Assembler, VARIABLES};
pub(super) use super::references::{Place, References};
use super::tally::Tally;
use super::types::{Extent, Ty, Types, first_name, layout};
use super::value::Value;
use scanbound_base::code::Code;
use scanbound_base::facts::{ActionOrder, StatedCall};
use scanbound_iec::fault::Fault;
use scanbound_iec::{Pou, Project};
use scanbound_iec_tree::resolve;
use scanbound_ir::{Area, AreaKind, Cell, Logic, Program, Radix, Role, Step, Tag};
use std::collections::{BTreeMap, BTreeSet};
use std::ops::{Deref, DerefMut};

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
const MAX_INSTANCES: u64 = 100_000;

/// An instance of a unit.
#[derive(Debug, Clone)]
pub(super) struct Instance {
    /// Its unit, an index into the project's.
    pub(super) pou: usize,
    /// Its variables.
    pub(super) place: Place,
}

/// A program while it is put together.
pub(super) struct Emit<'p> {
    assembler: Assembler,
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
    /// Values kept under names that begin with `~`, in the routine that is put together.
    pub(super) kept: BTreeMap<String, Value>,
    /// How large they are, of those that are not followed.
    pub(super) kept_extents: BTreeMap<String, Extent>,
    /// Instructions that give back what was handed over in and out, with the file of the call and its line.
    pub(super) given_back: Vec<(std::ops::Range<usize>, usize, u32)>,
    /// The bits that say that RETURN ended an action.
    pub(super) returned: BTreeMap<(usize, What), Cell>,
    pub(super) references: References,
    /// Whether variables have to lie in the same places the next time.
    keeps_places: bool,
    /// Whether a declaration gives values to the variables of an instance of the project's blocks.
    pub(super) gives_parts: bool,
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
    /// Whether drawn conditions read what their blocks gave in the last scan, as the user states.
    pub(super) drawn_last_scan: bool,
    /// Whether others than the program may write variables.
    pub(super) others_write: bool,
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
            [("variable ", Role::Memory), ("chart ", Role::Memory), ("value ", Role::Internal)]
        {
            program.areas.push(area(name, AreaKind::Bit, role));
            program.areas.push(area(&format!("{name}word "), AreaKind::Word, role));
        }
        let tally = Tally::of(project, &mut program.statements);
        Emit {
            assembler: Assembler::new(program, tally),
            project,
            types: Types::new(project),
            instances: Vec::new(),
            begun_anew: BTreeSet::new(),
            by_name: BTreeMap::new(),
            globals: BTreeMap::new(),
            charts: BTreeMap::new(),
            routines: BTreeMap::new(),
            open: Vec::new(),
            kept: BTreeMap::new(),
            kept_extents: BTreeMap::new(),
            given_back: Vec::new(),
            returned: BTreeMap::new(),
            references: References::default(),
            keeps_places: false,
            gives_parts: resolve::gives_parts(project),
            tasks: 1,
            task: 0,
            actions_first: false,
            begins_with_more: false,
            all_clear: false,
            action_order: None,
            drawn_last_scan: false,
            others_write: true,
            calls: BTreeMap::new(),
            stated_turns: BTreeMap::new(),
            is_incomplete: false,
        }
    }

    /// A variable of its own.
    pub(super) fn variable(&mut self, name: &str, ty: Ty, line: u32) -> Result<Place, Fault> {
        let instances = self.types.instances(&ty);
        if instances > MAX_INSTANCES {
            let what = format!("{name} holds {instances} instances of function blocks");
            let help = format!("a variable or a program may hold {MAX_INSTANCES}");
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

    /// Calls a routine of an instance where a condition holds.
    pub(super) fn call(&mut self, fires: Logic, instance: usize, what: What, row: &str) {
        let key = Assembler::key(&[row, "CAL"], "call");
        let at = self.builder.add(Some(key), Vec::new(), Step::Call { fires, target: 0 });
        self.open.push((at, instance, what));
    }
}

impl Deref for Emit<'_> {
    type Target = Assembler;

    fn deref(&self) -> &Assembler {
        &self.assembler
    }
}

impl DerefMut for Emit<'_> {
    fn deref_mut(&mut self) -> &mut Assembler {
        &mut self.assembler
    }
}
