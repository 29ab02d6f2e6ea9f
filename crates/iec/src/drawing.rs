//! Ladder and function block diagrams as data: elements and the connections between them.

use crate::ast::{Expr, Path, Statement, change};
use crate::fault::Fault;
use scanbound_base::code::Code;
use std::collections::BTreeSet;

/// An element of a drawing, by its index in [`Drawing::elements`].
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct ElementId(pub usize);

/// A ladder or function block network in which every connection has an existing source element.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Drawing {
    /// The elements in the order of the file.
    pub elements: Vec<Element>,
    /// Whether the controller's tool executes the network directly (CODESYS, TwinCAT), not text generated from it.
    pub is_executed_as_drawn: bool,
    /// For the drawing of a chart's conditions: the part to execute. `None`: all of the drawing is executed.
    pub goal: Option<Goal>,
}

/// The part of a drawing that computes one or more conditions.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Goal {
    /// The name of the drawing, unique within the unit; empty for the unit's body.
    pub part: String,
    /// For each condition, the connections that feed it.
    pub from: Vec<Vec<Connection>>,
}

/// An element of a drawing.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Element {
    /// Its `localId` in the file, for messages.
    pub local_id: String,
    /// Its kind, with the data that only this kind has.
    pub kind: ElementKind,
    /// The variable or expression written at it, or the fault in that text.
    pub operand: Result<Expr, Fault>,
    /// Whether its incoming value is negated.
    pub negated_in: bool,
    /// Whether its outgoing value is negated.
    pub negated_out: bool,
    /// The edge that it detects, of its variable or of its incoming value; `None` if it detects none.
    pub edge: Option<Edge>,
    /// For a set coil `true`, for a reset coil `false`: it writes that value if its incoming value is true. `None`
    /// otherwise.
    pub latch: Option<bool>,
    /// The incoming connections; empty for a block, whose pins hold them.
    pub inputs: Vec<Connection>,
    /// The number of connections that start at it.
    pub uses: usize,
    /// Its execution order number, if the file gives one.
    pub order: Option<u64>,
    /// Its position (down, right), in tenths of the file's unit.
    pub position: (i64, i64),
    /// Its line, from 1.
    pub line: u32,
}

/// An edge of a Boolean value.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[allow(missing_docs, reason = "their names say it")]
pub enum Edge {
    Rising,
    Falling,
}

/// The source of a connection.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Connection {
    /// The source element.
    pub from: ElementId,
    /// The name of the source's output; empty for the only or the first one.
    pub output: String,
}

/// The kinds of elements.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum ElementKind {
    /// The left power rail, which is always true.
    LeftRail,
    /// The right power rail, which ends rungs.
    RightRail,
    /// A contact: ANDs its variable with the incoming power.
    Contact,
    /// A coil: writes the incoming power to its variable and passes the power on.
    Coil,
    /// Supplies the value of its expression.
    In,
    /// Writes the incoming value to its variable.
    Out,
    /// An in-out variable: writes the incoming value, if any, and supplies its variable's value.
    InOut,
    /// A connector: its incoming value continues at the continuations of the same name.
    Connector,
    /// A continuation, with the connector whose value it supplies.
    Continuation(ElementId),
    /// A call of a function or an instance, or a box that contains text.
    Block(Box<Block>),
    /// A jump target.
    Label(String),
    /// A jump to this label, taken if the incoming value is true.
    Jump(String),
    /// A return, taken if the incoming value is true.
    Return,
    /// An unsupported element, by its name in the file.
    Other(String),
}

/// A block: a call of a function or an instance, or an EXECUTE box.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Block {
    /// The name of its type: the function or the instance's type.
    pub of: String,
    /// The path of the function that it calls if it has no instance, or the fault in that name.
    pub function: Result<Path, Fault>,
    /// The path of its instance, or the fault in that name; `None` for a function.
    pub instance: Option<Result<Path, Fault>>,
    /// The input pins, those of VAR_IN_OUT included.
    pub inputs: Vec<InputPin>,
    /// The output pins.
    pub outputs: Vec<OutputPin>,
    /// The statements of an EXECUTE box, or the fault in them; `None` for other blocks.
    pub code: Option<Result<Vec<Statement>, Fault>>,
}

/// An input pin of a block.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct InputPin {
    /// Its name.
    pub name: String,
    /// Whether it belongs to VAR_IN_OUT.
    pub is_in_out: bool,
    /// The value that the pin receives.
    pub given: Given,
    /// Whether the value is negated.
    pub negated: bool,
    /// The edge of the value that the pin passes; `None`: the value itself.
    pub edge: Option<Edge>,
}

/// The source of an input pin's value.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Given {
    /// The pin is unconnected.
    Nothing,
    /// The expression written at the pin, or the fault in it.
    Written(Result<Expr, Fault>),
    /// The connections to the pin.
    Wired(Vec<Connection>),
}

/// An output pin of a block.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct OutputPin {
    /// Its name.
    pub name: String,
    /// Whether the output is negated.
    pub negated: bool,
    /// The variable written at the pin, or the fault in it, and its line; `None` if none is written there.
    pub written: Option<(Result<Path, Fault>, u32)>,
}

impl Drawing {
    /// The element with this id.
    #[must_use]
    pub fn element(&self, id: ElementId) -> &Element {
        &self.elements[id.0]
    }

    /// All elements with their ids.
    pub fn all(&self) -> impl Iterator<Item = (ElementId, &Element)> {
        self.elements.iter().enumerate().map(|(at, one)| (ElementId(at), one))
    }

    /// The elements `ends` and all elements from which connections lead to them, directly or through others.
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

    /// Whether the drawing has an effect: any element for which [`Element::acts`] is true.
    #[must_use]
    pub fn acts(&self) -> bool {
        self.elements.iter().any(Element::acts)
    }

    /// Calls `expr` for every outermost expression, and `path` for every variable that is written or called, both
    /// mutably.
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
    /// Whether it has an effect or belongs to the control flow. Rails, contacts, plain values, continuations, and
    /// in-out variables or connectors without an incoming connection do not.
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

    /// Whether no connection can start at it: its kind has no output.
    #[must_use]
    pub fn has_no_output(&self) -> bool {
        matches!(self.kind, ElementKind::Out | ElementKind::RightRail | ElementKind::Connector)
            || self.moves()
    }

    /// Whether it is a jump, a return or a label.
    #[must_use]
    pub fn moves(&self) -> bool {
        matches!(self.kind, ElementKind::Label(_) | ElementKind::Jump(_) | ElementKind::Return)
    }

    /// Rejects a contact, coil or variable element without a variable.
    ///
    /// # Errors
    /// [`Element::operand`]'s fault, if its code is [`Code::Xml`]; other faults are accepted here.
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

    /// Its block; `None` if it is not a block.
    #[must_use]
    pub fn block(&self) -> Option<&Block> {
        match &self.kind {
            ElementKind::Block(block) => Some(block),
            _ => None,
        }
    }

    /// Whether it is a block with an instance, which keeps state.
    #[must_use]
    pub fn is_instance(&self) -> bool {
        self.block().is_some_and(|block| block.instance.is_some())
    }

    /// All incoming connections, those of a block's pins included.
    pub fn sources(&self) -> impl Iterator<Item = &Connection> {
        let pins = self.block().into_iter().flat_map(|block| &block.inputs);
        let wired = pins.flat_map(|pin| match &pin.given {
            Given::Wired(from) => &from[..],
            _ => &[],
        });
        self.inputs.iter().chain(wired)
    }

    /// The source elements of its incoming connections; for a continuation, its connector as well.
    pub fn leading(&self) -> impl Iterator<Item = ElementId> {
        let connector = match self.kind {
            ElementKind::Continuation(from) => Some(from),
            _ => None,
        };
        self.sources().map(|from| from.from).chain(connector)
    }

    /// The element's name in messages, such as "coil with localId 5".
    #[must_use]
    pub fn called(&self) -> String {
        format!("{} with localId {}", self.kind.name(), self.local_id)
    }

    /// The fault `what` at this element, with its line and `localId`.
    #[must_use]
    pub fn fault(&self, what: &str) -> Fault {
        Fault::new(self.line, format!("{}: {what}", self.called()))
            .code(Code::Xml)
            .text(format!("<{} localId=\"{}\">", self.kind.name(), self.local_id))
            .help("export it again as PLCopen XML, or mend it in its editor")
    }
}

impl ElementKind {
    /// Its element name in PLCopen XML.
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
    /// Whether it has an output pin of this name, ignoring case.
    #[must_use]
    pub fn has_output(&self, name: &str) -> bool {
        self.outputs.iter().any(|pin| pin.name.eq_ignore_ascii_case(name))
    }

    /// Whether it is a function without an input pin other than EN.
    #[must_use]
    pub fn has_no_pin(&self) -> bool {
        let is_own = |pin: &InputPin| pin.is_in_out || !pin.name.eq_ignore_ascii_case("EN");
        self.instance.is_none() && !self.inputs.iter().any(is_own)
    }

    /// Whether it has an input pin of this name, ignoring case.
    #[must_use]
    pub fn has_input(&self, name: &str) -> bool {
        self.inputs.iter().any(|pin| pin.name.eq_ignore_ascii_case(name))
    }

    /// Whether the output of this name is negated.
    #[must_use]
    pub fn negates(&self, name: &str) -> bool {
        self.outputs.iter().any(|pin| pin.negated && pin.name.eq_ignore_ascii_case(name))
    }

    /// Whether generated text assigns the function's ENO to a variable: the block has an ENO pin, and none of its pins
    /// (VAR_IN_OUT aside) detects an edge.
    #[must_use]
    pub fn gives_enable(&self) -> bool {
        self.instance.is_none()
            && self.has_output("ENO")
            && !self.inputs.iter().any(|pin| !pin.is_in_out && pin.edge.is_some())
    }

    /// Whether the input pins of a function are all named `IN` and a number, with numbers that ascend from 2 or more,
    /// and exactly `given` of them exist. EN does not count here, but CODESYS and TwinCAT count it when they number the
    /// pins.
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

    /// The names of the outputs without ENO and without the output side of VAR_IN_OUT pins, which appear on both sides.
    pub fn results(&self) -> impl Iterator<Item = &str> {
        let names = self.outputs.iter().map(|pin| pin.name.as_str());
        names.filter(|name| {
            let is_given_back = !name.is_empty() && self.has_input(name);
            !name.eq_ignore_ascii_case("ENO") && !is_given_back
        })
    }
}
