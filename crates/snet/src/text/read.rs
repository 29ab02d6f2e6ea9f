//! Parses a net from text: first all elements, then the names in arcs, gates and arbiters.

use super::super::address::{Address, TIMERS};
use super::super::{
    Arbiter, Arc, Diagram, Direction, Gate, Head, Kind, Outer, Page, Place, Point, Signal,
    Transition,
};
use super::names::{Named, Names};
use super::token::{Token, is_name, tokens};
use scanbound_base::code::Code;
use scanbound_base::diagnostic::Diagnostic;
use scanbound_base::suggestion::{nearest, with_suggestion};

/// The largest number of errors that are reported.
const SHOWN: usize = 20;

/// Parses a net. [`super::super::faults::faults`] then checks its structure.
///
/// # Errors
/// All syntax errors with their lines.
pub fn read(file: &str, text: &str) -> Result<Diagram, Vec<Diagnostic>> {
    let mut reader = Reader {
        file,
        diagram: Diagram { file: file.to_owned(), ..Diagram::default() },
        names: Names::default(),
        faults: Vec::new(),
        pending: Vec::new(),
    };
    for (at, text) in text.lines().enumerate() {
        let line = u32::try_from(at + 1).unwrap_or(u32::MAX);
        let found = tokens(text);
        if let Some((first, rest)) = found.split_first() {
            let statement = Statement { line, text: text.trim(), words: rest };
            reader.statement(*first, statement);
        }
    }
    reader.finish()
}

/// A line after its first word.
#[derive(Debug, Clone, Copy)]
struct Statement<'a> {
    line: u32,
    text: &'a str,
    words: &'a [Token<'a>],
}

/// A part of a line that is resolved when all elements are known.
#[derive(Debug)]
enum Pending {
    /// The names of an arc's ends.
    Arc { from: String, to: String, is_stop: bool },
    /// A gate at this transition.
    Gate { transition: usize, name: String, is_inhibiting: bool },
    /// A transition of this arbiter.
    Arbitrated { arbiter: usize, name: String },
}

struct Reader<'a> {
    file: &'a str,
    diagram: Diagram,
    names: Names,
    faults: Vec<Diagnostic>,
    /// Each with its page, line and the line's text.
    pending: Vec<(usize, u32, String, Pending)>,
}

/// The attributes between an element's name and the colon.
#[derive(Debug, Default)]
struct Attributes {
    is_marked: bool,
    address: Option<Address>,
    at: Option<Point>,
    number: Option<u16>,
    value: Option<String>,
}

const STATEMENTS: [&str; 9] =
    ["net", "page", "outer", "box", "timer", "counter", "transition", "stop", "arc"];

impl Reader<'_> {
    fn fault(&mut self, of: Statement<'_>, part: &str, message: String, help: &str) {
        self.fault_of(Code::NetSyntax, of.line, of.text, part, message, help);
    }

    fn fault_of(
        &mut self,
        code: Code,
        line: u32,
        text: &str,
        part: &str,
        message: String,
        help: &str,
    ) {
        let fault = Diagnostic::line(code, self.file, line, text, message, help);
        self.faults.push(fault.mark(part));
    }

    fn statement(&mut self, first: Token<'_>, statement: Statement<'_>) {
        match first.text() {
            "net" => self.net(statement),
            "page" => self.page(statement),
            "outer" => self.outer(statement),
            "box" | "timer" | "counter" => self.place(first.text(), statement),
            "transition" | "stop" => self.transition(first.text() == "stop", statement),
            "arbiter" => self.arbiter(statement),
            "arc" => self.arc(statement),
            other => {
                let known = STATEMENTS.iter().map(|&name| name.to_owned());
                let help = "begin the line with net, page, outer, box, timer, counter, transition, stop, arbiter or arc";
                let help =
                    with_suggestion(nearest(other, known.chain(["arbiter".to_owned()])), help);
                self.fault(
                    statement,
                    other,
                    format!("`{other}` cannot begin a line of a net"),
                    &help,
                );
            }
        }
    }

    fn net(&mut self, statement: Statement<'_>) {
        let name = statement.text.trim_start_matches("net").split('#').next().unwrap_or_default();
        name.trim().clone_into(&mut self.diagram.name);
    }

    fn page(&mut self, statement: Statement<'_>) {
        let Some(name) = self.own_name(statement) else { return };
        if let Some(page) = self.diagram.pages.iter().find(|page| page.name == name) {
            let message = format!("the page {name} already begins in line {}", page.line);
            self.fault_of(
                Code::NetName,
                statement.line,
                statement.text,
                name,
                message,
                "put all elements of a page together, or give this page another name",
            );
        }
        self.diagram.pages.push(Page { name: name.to_owned(), line: statement.line });
        self.extra(statement, &statement.words[1..]);
    }

    /// The current page; a first page is created if the text does not name one.
    fn current(&mut self, line: u32) -> usize {
        if self.diagram.pages.is_empty() {
            self.diagram.pages.push(Page { name: "MAIN".to_owned(), line });
        }
        self.diagram.pages.len() - 1
    }

    /// The name after the first word.
    fn own_name<'s>(&mut self, statement: Statement<'s>) -> Option<&'s str> {
        let name = statement.words.first().map_or("", |word| word.text());
        if is_name(name) && matches!(statement.words[0], Token::Word(_)) {
            return Some(name);
        }
        let message = if name.is_empty() {
            "a name is missing".to_owned()
        } else {
            format!("`{name}` is not a valid name")
        };
        let help =
            "use letters, digits and _ - / ( ), but not the keywords marked, if, not, at, TIM, CNT";
        self.fault(statement, name, message, help);
        None
    }

    fn named(&mut self, page: usize, statement: Statement<'_>, name: &str, named: Named) {
        if let Err(other) = self.names.add(page, name, statement.line, named) {
            let message = format!("the element in line {other} already has the name {name}");
            let help = "give each element of a page, and each outer gate, a different name";
            self.fault_of(Code::NetName, statement.line, statement.text, name, message, help);
        }
    }

    /// Parses the words between a name and the colon.
    fn attributes(&mut self, statement: Statement<'_>, words: &[Token<'_>]) -> Attributes {
        let mut found = Attributes::default();
        let mut rest = words;
        while let Some((first, behind)) = rest.split_first() {
            rest = behind;
            match first.text() {
                "marked" => found.is_marked = true,
                "=" => {
                    let text = rest.first().map_or("", |word| word.text());
                    // `HR 0107` as well as `HR0107`.
                    let is_area = !text.is_empty() && text.bytes().all(|b| b.is_ascii_alphabetic());
                    let digits =
                        if is_area { rest.get(1).map_or("", |word| word.text()) } else { "" };
                    match format!("{text}{digits}").parse() {
                        Ok(address) => found.address = Some(address),
                        Err(why) => {
                            let message = format!("`{text}{digits}` is not a relay: {why}");
                            let help = "write word and bit, as in 00305, HR0107 or LR0000";
                            let part = if digits.is_empty() { text } else { digits };
                            self.fault_of(
                                Code::NetAddress,
                                statement.line,
                                statement.text,
                                part,
                                message,
                                help,
                            );
                        }
                    }
                    rest = &rest[rest.len().min(1 + usize::from(is_area))..];
                }
                "at" => {
                    let number = |at: usize| -> Option<i32> { rest.get(at)?.word()?.parse().ok() };
                    match (number(0), number(1)) {
                        (Some(x), Some(y)) => found.at = Some(Point { x, y }),
                        _ => self.fault(
                            statement,
                            "at",
                            "the drawing position is not valid".to_owned(),
                            "write two integers after `at`, x to the right and y down: at 120,80",
                        ),
                    }
                    rest = &rest[rest.len().min(2)..];
                }
                "TIM" | "CNT" => {
                    let text = rest.first().map_or("", |word| word.text());
                    match text.parse::<u16>().ok().filter(|number| *number < TIMERS) {
                        Some(number) => found.number = Some(number),
                        None => self.fault_of(
                            Code::NetAddress,
                            statement.line,
                            statement.text,
                            text,
                            format!("`{text}` is not a timer or counter number"),
                            "use TIM or CNT 000 to 511; timers and counters of the C200H share these numbers",
                        ),
                    }
                    rest = &rest[rest.len().min(1)..];
                }
                value
                    if found.value.is_none() && value.starts_with(|c: char| c.is_ascii_digit()) =>
                {
                    found.value = Some(value.to_owned());
                }
                other => {
                    let help = "write only these after a name: marked, = ADDRESS, TIM or CNT NUMBER, at X,Y";
                    self.fault(statement, other, format!("`{other}` is not allowed here"), help);
                }
            }
        }
        found
    }

    /// Reports the first of the remaining words as an error.
    fn extra(&mut self, statement: Statement<'_>, words: &[Token<'_>]) {
        if let Some(word) = words.first() {
            let message = format!("`{}` is not allowed here", word.text());
            self.fault(statement, word.text(), message, "remove it, or begin a line with it");
        }
    }

    /// Reports an attribute that this type of element does not have.
    fn has_none(&mut self, statement: Statement<'_>, is_there: bool, part: &str, what: &str) {
        if is_there {
            let message = format!("this element cannot have {what}");
            self.fault(statement, part, message, "remove it");
        }
    }

    fn outer(&mut self, statement: Statement<'_>) {
        let Some(name) = self.own_name(statement) else { return };
        let attributes = self.attributes(statement, &statement.words[1..]);
        self.has_none(statement, attributes.is_marked, "marked", "a mark");
        self.has_none(statement, attributes.number.is_some(), "", "a timer's or counter's number");
        self.has_none(statement, attributes.value.is_some(), "", "a set value");
        // An outer gate belongs to all pages, and may come before the first one.
        let head = head(0, statement, name, &attributes);
        self.named(0, statement, name, Named::Outer(self.diagram.outers.len()));
        self.diagram.outers.push(Outer { head });
    }

    fn place(&mut self, word: &str, statement: Statement<'_>) {
        let Some(name) = self.own_name(statement) else { return };
        let words = &statement.words[1..];
        let attributes = self.attributes(statement, words);
        let number = attributes.number;
        let other = if word == "timer" { "CNT" } else { "TIM" };
        if number.is_some() && (word == "box" || words.iter().any(|one| one.text() == other)) {
            let message = format!("a {word} cannot have such a number");
            let help = "write TIM and a number for a timer, CNT and a number for a counter, neither for a box";
            let (line, text) = (statement.line, statement.text);
            self.fault_of(Code::NetAddress, line, text, other, message, help);
        }
        let value = attributes.value.as_deref();
        let kind = match word {
            "timer" => {
                let tenths = value.and_then(tenths);
                if tenths.is_none() {
                    let message =
                        "the timer's set value is missing, or is not a time from 0.0s to 999.9s"
                            .to_owned();
                    let help = "write 0.0s to 999.9s after the name: timer TM01 5.0s";
                    self.fault(statement, value.unwrap_or(name), message, help);
                }
                Kind::Timer { number, tenths: tenths.unwrap_or_default() }
            }
            "counter" => {
                let count = value.and_then(|text| text.parse().ok());
                let count = count.filter(|count| (1..=9_999).contains(count));
                if count.is_none() {
                    let message = "the counter's set value is missing, or is not a whole number from 1 to 9999".to_owned();
                    let help = "write 1 to 9999 after the name: counter CN01 10";
                    self.fault(statement, value.unwrap_or(name), message, help);
                }
                self.has_none(statement, attributes.is_marked, "marked", "an initial mark");
                Kind::Counter { number, count: count.unwrap_or(1) }
            }
            _ => {
                self.has_none(statement, value.is_some(), value.unwrap_or(""), "a set value");
                Kind::Box
            }
        };
        let page = self.current(statement.line);
        let head = head(page, statement, name, &attributes);
        self.named(page, statement, name, Named::Place(self.diagram.places.len()));
        self.diagram.places.push(Place { head, kind, is_marked: attributes.is_marked });
    }

    fn transition(&mut self, is_stop: bool, statement: Statement<'_>) {
        let Some(name) = self.own_name(statement) else { return };
        let words = &statement.words[1..];
        let gates_at = words.iter().position(|word| word.text() == "if").unwrap_or(words.len());
        let (front, gates) = words.split_at(gates_at);
        let colon = front.iter().position(|word| *word == Token::Colon).unwrap_or(front.len());
        let (own, arcs) = front.split_at(colon);
        let attributes = self.attributes(statement, own);
        self.has_none(statement, attributes.is_marked, "marked", "a mark");
        self.has_none(statement, attributes.number.is_some(), "", "a timer's or counter's number");
        self.has_none(statement, attributes.value.is_some(), "", "a set value");
        let page = self.current(statement.line);
        let head = head(page, statement, name, &attributes);
        let transition = self.diagram.transitions.len();
        self.named(page, statement, name, Named::Transition(transition));
        self.diagram.transitions.push(Transition { head, is_stop });
        self.arcs_of(name, is_stop, statement, arcs.get(1..).unwrap_or_default());
        self.gates_of(transition, statement, gates.get(1..).unwrap_or_default());
    }

    fn arcs_of(
        &mut self,
        name: &str,
        is_stop: bool,
        statement: Statement<'_>,
        words: &[Token<'_>],
    ) {
        let arrow = if is_stop { Token::Stop } else { Token::Arrow };
        let mut is_behind = false;
        for word in words {
            match word {
                Token::Word(place) => {
                    let (own, place) = (name.to_owned(), (*place).to_owned());
                    let (from, to) = if is_behind { (own, place) } else { (place, own) };
                    self.wait(statement, Pending::Arc { from, to, is_stop: is_stop && !is_behind });
                }
                found if *found == arrow && !is_behind => is_behind = true,
                found => {
                    let help = if is_stop {
                        "write the places to stop, then *->: stop T00 : B01 B02 *-> if E09"
                    } else {
                        "write the input places, ->, and the output places: transition T01 : B01 -> B02 B03"
                    };
                    let message = format!("`{}` is not allowed here", found.text());
                    self.fault(statement, found.text(), message, help);
                    return;
                }
            }
        }
        if !is_behind && !is_stop && !words.is_empty() {
            let message = format!("the `->` of {name} is missing");
            let help =
                "write the input places, ->, and the output places: transition T01 : B01 -> B02";
            self.fault(statement, name, message, help);
        }
    }

    fn gates_of(&mut self, transition: usize, statement: Statement<'_>, words: &[Token<'_>]) {
        let mut is_inhibiting = false;
        for word in words {
            match word {
                Token::Word("not") if !is_inhibiting => is_inhibiting = true,
                Token::Word(name) if *name != "not" && *name != "if" => {
                    let name = (*name).to_owned();
                    self.wait(statement, Pending::Gate { transition, name, is_inhibiting });
                    is_inhibiting = false;
                }
                found => {
                    let message = format!("`{}` is not a gate", found.text());
                    let help =
                        "write gates after `if`, inhibiting gates after `not`: if E01 not E02";
                    self.fault(statement, found.text(), message, help);
                    return;
                }
            }
        }
        if is_inhibiting || (words.is_empty() && statement.words.iter().any(|w| w.text() == "if")) {
            let message = "a gate is missing at the end of the line".to_owned();
            self.fault(statement, "", message, "write its name after `if` or `not`");
        }
    }

    fn arbiter(&mut self, statement: Statement<'_>) {
        let Some(name) = self.own_name(statement) else { return };
        let words = &statement.words[1..];
        let colon = words.iter().position(|word| *word == Token::Colon).unwrap_or(words.len());
        let (own, rest) = words.split_at(colon);
        let attributes = self.attributes(statement, own);
        self.has_none(statement, attributes.address.is_some(), "=", "an address");
        self.has_none(statement, attributes.is_marked, "marked", "a mark");
        let page = self.current(statement.line);
        let head = Head { address: None, ..head(page, statement, name, &attributes) };
        let arbiter = self.diagram.arbiters.len();
        self.diagram.arbiters.push(Arbiter { head, transitions: Vec::new() });
        let names: Vec<&str> = rest.iter().skip(1).filter_map(|word| word.word()).collect();
        if names.len() < 2 || names.len() + 1 != rest.len() {
            let message =
                "an arbiter needs a colon, and after it only the names of two or more transitions"
                    .to_owned();
            let help = "write the transition with the highest priority first: arbiter A1 : T01 T02";
            self.fault(statement, name, message, help);
        }
        for name in names {
            self.wait(statement, Pending::Arbitrated { arbiter, name: name.to_owned() });
        }
    }

    fn arc(&mut self, statement: Statement<'_>) {
        let (from, arrow, to) = match statement.words {
            [Token::Word(from), arrow @ (Token::Arrow | Token::Stop), Token::Word(to)] => {
                (*from, *arrow, *to)
            }
            _ => {
                let message = "an arc needs two elements".to_owned();
                let help = "write: arc B01 -> T01, arc T01 -> B02, or arc B01 *-> T00";
                return self.fault(statement, "", message, help);
            }
        };
        let (from, to) = (from.to_owned(), to.to_owned());
        self.wait(statement, Pending::Arc { from, to, is_stop: arrow == Token::Stop });
    }

    fn wait(&mut self, statement: Statement<'_>, pending: Pending) {
        let page = self.current(statement.line);
        self.pending.push((page, statement.line, statement.text.to_owned(), pending));
    }

    fn finish(mut self) -> Result<Diagram, Vec<Diagnostic>> {
        self.names.pages(&self.diagram);
        let ambiguous = self.names.ambiguous().into_iter();
        let ambiguous: Vec<(String, u32, u32)> =
            ambiguous.map(|(name, gate, line)| (name.to_owned(), gate, line)).collect();
        for (name, gate, line) in ambiguous {
            let message =
                format!("{name} is an outer gate in line {gate} and another element here");
            let help = "give one of the two another name: outer gates belong to all pages";
            self.fault_of(Code::NetName, line, &name, &name, message, help);
        }
        for (page, line, text, pending) in std::mem::take(&mut self.pending) {
            self.resolve(page, line, &text, pending);
        }
        if self.diagram.pages.is_empty() && self.faults.is_empty() {
            let message = "the file contains no net";
            let help = "write one element per line; docs/snet.md has the grammar";
            self.faults.push(Diagnostic::file(Code::NetSyntax, self.file, message, help));
        }
        self.faults.sort_by_key(|fault| fault.line);
        if self.diagram.pages.is_empty() && self.faults.len() > 1 {
            // If no line is an element, the file is something else.
            self.faults.truncate(1);
            self.faults[0].help = "give a file with a net; docs/snet.md has the grammar".to_owned();
        }
        if let Some(left) = self.faults.len().checked_sub(SHOWN).filter(|left| *left > 0) {
            self.faults.truncate(SHOWN);
            let message = format!("and {left} more errors");
            let help = "correct these first";
            self.faults.push(Diagnostic::file(Code::NetSyntax, self.file, message, help));
        }
        if self.faults.is_empty() { Ok(self.diagram) } else { Err(self.faults) }
    }

    fn find(&mut self, page: usize, line: u32, text: &str, name: &str) -> Option<Named> {
        let found = self.names.find(page, name);
        if found.is_none() {
            let help = "declare it on its own line, or write its page before the name: PAGE.NAME";
            let help = with_suggestion(nearest(name, self.names.all(page)), help);
            let message = format!("the net has no element {name}");
            self.fault_of(Code::NetName, line, text, name, message, &help);
        }
        found
    }

    fn resolve(&mut self, page: usize, line: u32, text: &str, pending: Pending) {
        match pending {
            Pending::Arc { from, to, is_stop } => {
                let (Some(first), Some(second)) =
                    (self.find(page, line, text, &from), self.find(page, line, text, &to))
                else {
                    return;
                };
                match join(&self.diagram, first, second, is_stop) {
                    Ok((place, transition, direction)) => {
                        self.diagram.arcs.push(Arc { place, transition, direction, line });
                    }
                    Err(why) => {
                        let message = format!("there can be no arc from {from} to {to}: {why}");
                        let help = "connect a box, timer or counter with a transition; use * only for arcs to emergency-stop transitions";
                        self.fault_of(Code::NetArc, line, text, &from, message, help);
                    }
                }
            }
            Pending::Gate { transition, name, is_inhibiting } => {
                let signal = match self.find(page, line, text, &name) {
                    Some(Named::Place(place)) => Signal::Place(place),
                    Some(Named::Outer(outer)) => Signal::Outer(outer),
                    Some(Named::Transition(_)) => {
                        let message = format!("the gate {name} is a transition");
                        let help = "use a box, a timer, a counter or an outer gate";
                        return self.fault_of(Code::NetArc, line, text, &name, message, help);
                    }
                    None => return,
                };
                self.diagram.gates.push(Gate { transition, signal, is_inhibiting, line });
            }
            Pending::Arbitrated { arbiter, name } => match self.find(page, line, text, &name) {
                Some(Named::Transition(transition)) => {
                    self.diagram.arbiters[arbiter].transitions.push(transition);
                }
                Some(_) => {
                    let message = format!("{name} is not a transition");
                    let help = "write only transitions in an arbiter";
                    self.fault_of(Code::NetArc, line, text, &name, message, help);
                }
                None => {}
            },
        }
    }
}

fn head(page: usize, statement: Statement<'_>, name: &str, of: &Attributes) -> Head {
    Head { name: name.to_owned(), page, line: statement.line, address: of.address, at: of.at }
}

/// The arc between two elements, or why there cannot be one.
fn join(
    diagram: &Diagram,
    from: Named,
    to: Named,
    is_stop: bool,
) -> Result<(usize, usize, Direction), &'static str> {
    let is_emergency = |transition: usize| diagram.transitions[transition].is_stop;
    match (from, to) {
        (Named::Place(place), Named::Transition(transition)) => {
            match (is_stop, is_emergency(transition)) {
                (true, true) => Ok((place, transition, Direction::Stop)),
                (false, false) => Ok((place, transition, Direction::Into)),
                (true, false) => Err("an arc with *-> must lead to an emergency stop"),
                (false, true) => Err("all arcs to an emergency stop must be written *->"),
            }
        }
        (Named::Transition(transition), Named::Place(_)) if is_emergency(transition) => {
            Err("an emergency stop only removes marks, so no arc leads out of it")
        }
        (Named::Transition(transition), Named::Place(place)) if !is_stop => {
            Ok((place, transition, Direction::OutOf))
        }
        (Named::Transition(_), Named::Place(_)) => {
            Err("an arc with *-> must lead to an emergency stop")
        }
        (Named::Place(_), Named::Place(_)) => {
            Err("both are boxes, timers or counters, so a transition is needed between them")
        }
        (Named::Transition(_), Named::Transition(_)) => {
            Err("both are transitions, so a box is needed between them")
        }
        _ => Err("an outer gate has no arcs; write it after `if`"),
    }
}

/// Parses a time such as `5s` or `0.5s`, up to 999.9s, in tenths of a second.
fn tenths(text: &str) -> Option<u16> {
    let number = text.strip_suffix('s')?;
    let (whole, part) = number.split_once('.').unwrap_or((number, "0"));
    let is_digits = |text: &str| !text.is_empty() && text.bytes().all(|b| b.is_ascii_digit());
    if !is_digits(whole) || !is_digits(part) || part.len() > 1 {
        return None;
    }
    let tenths: u32 = format!("{whole}{part}").parse().ok()?;
    u16::try_from(tenths).ok().filter(|tenths| *tenths <= 9_999)
}
