//! Ladder and function block diagrams as data: elements, and what leads to them.

use crate::ast::{Expr, Path, Statement, change};
use crate::fault::Fault;
use scanbound_base::code::Code;
use std::collections::BTreeSet;

/// An element of a drawing, by its number.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct ElementId(pub usize);

/// A drawing whose connections all lead somewhere.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Drawing {
    /// The elements as the file has them.
    pub elements: Vec<Element>,
    /// Whether the controller's tool executes the drawing itself (CODESYS, TwinCAT) and does not generate text from it.
    pub is_executed_as_drawn: bool,
    /// What of it is executed, of the drawing of conditions; all, if nothing is said.
    pub goal: Option<Goal>,
}

/// What conditions are drawn with.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Goal {
    /// Where they are drawn, by a name of its own within the unit; none, for the unit's body.
    pub part: String,
    /// What leads to each of them.
    pub from: Vec<Vec<Connection>>,
}

/// An element.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Element {
    /// Its `localId`, for messages.
    pub local_id: String,
    /// What it is.
    pub kind: ElementKind,
    /// The variable or expression that stands at it, or what is wrong with that.
    pub operand: Result<Expr, Fault>,
    /// Whether what leads to it is negated.
    pub negated_in: bool,
    /// Whether what it gives is negated.
    pub negated_out: bool,
    /// The edge of its variable, or of what leads to it.
    pub edge: Option<Edge>,
    /// Whether its variable is set (true) or reset (false) where what leads to it is true.
    pub latch: Option<bool>,
    /// What leads to it; of a block its pins have that.
    pub inputs: Vec<Connection>,
    /// How many connections lead away from it.
    pub uses: usize,
    /// Its number of execution, if it has one.
    pub order: Option<u64>,
    /// How far down and how far to the right it stands, in tenths of the file's unit.
    pub position: (i64, i64),
    /// Its line.
    pub line: u32,
}

/// An edge.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[allow(missing_docs, reason = "their names say it")]
pub enum Edge {
    Rising,
    Falling,
}

/// Where a connection begins.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Connection {
    /// The element.
    pub from: ElementId,
    /// Which of its outputs; empty for the only one, or the first.
    pub output: String,
}

/// What an element is.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum ElementKind {
    /// It gives power.
    LeftRail,
    /// It ends rungs.
    RightRail,
    /// It lets power through where its variable is true.
    Contact,
    /// It writes the power that leads to it, and lets it through.
    Coil,
    /// It gives an expression's value.
    In,
    /// It writes a variable.
    Out,
    /// Both.
    InOut,
    /// What leads to it goes on at continuations.
    Connector,
    /// What leads to a connector goes on here.
    Continuation(ElementId),
    /// A function, an instance, or a box with text.
    Block(Box<Block>),
    /// A label.
    Label(String),
    /// A jump to a label where what leads to it is true.
    Jump(String),
    /// A return where what leads to it is true.
    Return,
    /// An element that is not followed, by its name.
    Other(String),
}

/// A block.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Block {
    /// Its type: a function, or that of its instance.
    pub of: String,
    /// The function that it stands for without an instance, or what is wrong with its name.
    pub function: Result<Path, Fault>,
    /// Its instance, or what is wrong with its name.
    pub instance: Option<Result<Path, Fault>>,
    /// Its pins on the left.
    pub inputs: Vec<InputPin>,
    /// Its pins on the right.
    pub outputs: Vec<OutputPin>,
    /// The statements of an EXECUTE box, or what is wrong with it.
    pub code: Option<Result<Vec<Statement>, Fault>>,
}

/// A pin on the left of a block.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct InputPin {
    /// Its name.
    pub name: String,
    /// Whether it stands among those that are handed over in and out.
    pub is_in_out: bool,
    /// What it is given.
    pub given: Given,
    /// Whether that is negated.
    pub negated: bool,
    /// Which edge of it.
    pub edge: Option<Edge>,
}

/// What a pin is given.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Given {
    /// Nothing.
    Nothing,
    /// What stands right at it.
    Written(Result<Expr, Fault>),
    /// What leads to it.
    Wired(Vec<Connection>),
}

/// A pin on the right of a block.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct OutputPin {
    /// Its name.
    pub name: String,
    /// Whether it gives the negation.
    pub negated: bool,
    /// The variable that stands right at it, and its line.
    pub written: Option<(Result<Path, Fault>, u32)>,
}

impl Drawing {
    /// An element.
    #[must_use]
    pub fn element(&self, id: ElementId) -> &Element {
        &self.elements[id.0]
    }

    /// All elements and their numbers.
    pub fn all(&self) -> impl Iterator<Item = (ElementId, &Element)> {
        self.elements.iter().enumerate().map(|(at, one)| (ElementId(at), one))
    }

    /// Elements, and everything that leads to them.
    pub fn reaching(&self, ends: impl IntoIterator<Item = ElementId>) -> BTreeSet<ElementId> {
        let mut found = BTreeSet::new();
        let mut open: Vec<ElementId> = ends.into_iter().collect();
        while let Some(id) = open.pop() {
            if found.insert(id) {
                open.extend(self.element(id).leading());
            }
        }
        found
    }

    /// Whether an element does anything.
    #[must_use]
    pub fn acts(&self) -> bool {
        self.elements.iter().any(Element::acts)
    }

    /// Shows every expression, to be changed; what is written and what is called as a path of its own.
    pub fn change(&mut self, expr: &mut dyn FnMut(&mut Expr), path: &mut dyn FnMut(&mut Path)) {
        for one in &mut self.elements {
            match (&one.kind, &mut one.operand) {
                (ElementKind::Coil | ElementKind::Out, Ok(Expr::Variable(target))) => path(target),
                (_, Ok(operand)) => expr(operand),
                (_, Err(_)) => {}
            }
            let ElementKind::Block(block) = &mut one.kind else { continue };
            if let Some(Ok(instance)) = &mut block.instance {
                path(instance);
            }
            for pin in &mut block.inputs {
                if let Given::Written(Ok(written)) = &mut pin.given {
                    expr(written);
                }
            }
            for pin in &mut block.outputs {
                if let Some((Ok(written), _)) = &mut pin.written {
                    path(written);
                }
            }
            if let Some(Ok(code)) = &mut block.code {
                change(code, expr, path);
            }
        }
    }
}

impl Element {
    /// Whether it does anything by itself.
    #[must_use]
    pub fn acts(&self) -> bool {
        match self.kind {
            ElementKind::InOut | ElementKind::Connector => !self.inputs.is_empty(),
            ElementKind::LeftRail
            | ElementKind::RightRail
            | ElementKind::Contact
            | ElementKind::In
            | ElementKind::Continuation(_) => false,
            _ => true,
        }
    }

    /// Whether it is a jump, a return or a label.
    #[must_use]
    pub fn moves(&self) -> bool {
        matches!(self.kind, ElementKind::Label(_) | ElementKind::Jump(_) | ElementKind::Return)
    }

    /// Refuses an element at which a variable is missing.
    ///
    /// # Errors
    /// That it names none.
    pub fn operand_is_there(&self) -> Result<(), Fault> {
        match (&self.kind, &self.operand) {
            (
                ElementKind::Contact
                | ElementKind::Coil
                | ElementKind::In
                | ElementKind::Out
                | ElementKind::InOut,
                Err(fault),
            ) if fault.code == Code::Xml => Err(fault.clone()),
            _ => Ok(()),
        }
    }

    /// The element's block, if it is one.
    #[must_use]
    pub fn block(&self) -> Option<&Block> {
        match &self.kind {
            ElementKind::Block(block) => Some(block),
            _ => None,
        }
    }

    /// Whether it is a block that remembers.
    #[must_use]
    pub fn is_instance(&self) -> bool {
        self.block().is_some_and(|block| block.instance.is_some())
    }

    /// Everything that leads to it, to its pins, too.
    pub fn sources(&self) -> impl Iterator<Item = &Connection> {
        let pins = self.block().into_iter().flat_map(|block| &block.inputs);
        let wired = pins.flat_map(|pin| match &pin.given {
            Given::Wired(from) => &from[..],
            _ => &[],
        });
        self.inputs.iter().chain(wired)
    }

    /// The elements that lead to it; to a continuation, its connector.
    pub fn leading(&self) -> impl Iterator<Item = ElementId> {
        let connector = match self.kind {
            ElementKind::Continuation(from) => Some(from),
            _ => None,
        };
        self.sources().map(|from| from.from).chain(connector)
    }

    /// The element for messages.
    #[must_use]
    pub fn called(&self) -> String {
        format!("{} with localId {}", self.kind.name(), self.local_id)
    }

    /// A fault at the element: what is wrong with it.
    #[must_use]
    pub fn fault(&self, what: &str) -> Fault {
        Fault::new(self.line, format!("{}: {what}", self.called()))
            .code(Code::Xml)
            .text(format!("<{} localId=\"{}\">", self.kind.name(), self.local_id))
            .help("export it again as PLCopen XML, or mend it in its editor")
    }
}

impl ElementKind {
    /// Its name in a file.
    #[must_use]
    pub fn name(&self) -> &str {
        match self {
            ElementKind::LeftRail => "leftPowerRail",
            ElementKind::RightRail => "rightPowerRail",
            ElementKind::Contact => "contact",
            ElementKind::Coil => "coil",
            ElementKind::In => "inVariable",
            ElementKind::Out => "outVariable",
            ElementKind::InOut => "inOutVariable",
            ElementKind::Connector => "connector",
            ElementKind::Continuation(_) => "continuation",
            ElementKind::Block(_) => "block",
            ElementKind::Label(_) => "label",
            ElementKind::Jump(_) => "jump",
            ElementKind::Return => "return",
            ElementKind::Other(name) => name,
        }
    }
}

impl Block {
    /// Whether a pin of this name stands on the right.
    #[must_use]
    pub fn has_output(&self, name: &str) -> bool {
        self.outputs.iter().any(|pin| pin.name.eq_ignore_ascii_case(name))
    }

    /// Whether it is a function without a pin on the left but EN.
    #[must_use]
    pub fn has_no_pin(&self) -> bool {
        let is_own = |pin: &InputPin| pin.is_in_out || !pin.name.eq_ignore_ascii_case("EN");
        self.instance.is_none() && !self.inputs.iter().any(is_own)
    }

    /// Whether a pin of this name stands on the left.
    #[must_use]
    pub fn has_input(&self, name: &str) -> bool {
        self.inputs.iter().any(|pin| pin.name.eq_ignore_ascii_case(name))
    }

    /// Whether an output gives the negation.
    #[must_use]
    pub fn negates(&self, name: &str) -> bool {
        self.outputs.iter().any(|pin| pin.negated && pin.name.eq_ignore_ascii_case(name))
    }

    /// Whether generators take ENO of a function into a variable: it is drawn, and no edge at a pin depends on EN.
    #[must_use]
    pub fn gives_enable(&self) -> bool {
        self.instance.is_none()
            && self.has_output("ENO")
            && !self.inputs.iter().any(|pin| !pin.is_in_out && pin.edge.is_some())
    }

    /// Whether a function's pins are only counted, and not from 1 on, where so many but EN are given something: CODESYS
    /// and TwinCAT count EN, too.
    #[must_use]
    pub fn are_counted(&self, given: usize) -> bool {
        let number = |name: &str| {
            let (front, digits) = name.split_at_checked(2)?;
            digits.parse::<u32>().ok().filter(|_| front.eq_ignore_ascii_case("IN"))
        };
        let is_own = |pin: &&InputPin| !pin.is_in_out && !pin.name.eq_ignore_ascii_case("EN");
        let own = self.inputs.iter().filter(is_own);
        let numbers: Option<Vec<u32>> = own.map(|pin| number(&pin.name)).collect();
        numbers.is_some_and(|numbers| {
            numbers.len() == given
                && numbers.is_sorted()
                && numbers.first().is_some_and(|&first| first > 1)
        })
    }

    /// The names of the outputs but ENO and what is given back: a VAR_IN_OUT has a pin on either side.
    pub fn results(&self) -> impl Iterator<Item = &str> {
        let names = self.outputs.iter().map(|pin| pin.name.as_str());
        names.filter(|name| {
            let is_given_back = !name.is_empty() && self.has_input(name);
            !name.eq_ignore_ascii_case("ENO") && !is_given_back
        })
    }
}
