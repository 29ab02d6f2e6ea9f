//! Writes projects and charts as PLCopen XML 2.01, as other tools open them.

use super::node::{ACTIVE, ELEMENT, ENTRY, EXIT};
use crate::iec::ast::Expr;
use crate::iec::chart::plain::plain;
use crate::iec::chart::{Block, Chart, Step, Target};
use crate::iec::{Body, Pou, PouKind, Project, Section, TypeRef, Variable, show};
use std::collections::BTreeMap;
use std::fmt::Write;

const NAMESPACE: &str = "http://www.plcopen.org/xml/tc6_0201";
const HTML: &str = "http://www.w3.org/1999/xhtml";

/// A text as XML has it.
fn escaped(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => out += "&amp;",
            '<' => out += "&lt;",
            '>' => out += "&gt;",
            '"' => out += "&quot;",
            _ => out.push(c),
        }
    }
    out
}

/// A chart as the element SFC, in the default namespace of what stands around it.
///
/// # Errors
/// What of it cannot be written, in words: parts of drawings that have no form in text.
pub fn chart(chart: &Chart) -> Result<String, String> {
    if let Some(own) = chart.macros.first() {
        return Err(format!("the macro step {} was not replaced before", own.name));
    }
    let mut writer = Writer { chart, text: String::new(), next: 1, steps: Vec::new() };
    writer.chart()?;
    if writer.text.contains('~') {
        return Err("a condition or an action of it was drawn, and has no form in text".to_owned());
    }
    Ok(format!("<SFC>\n{}</SFC>", writer.text))
}

/// A file in which these charts take the places of those that it has.
///
/// # Errors
/// As with [`chart`].
pub fn replaced(file: &str, charts: &[&Chart]) -> Result<String, String> {
    let mut places: Vec<((usize, usize), String)> = Vec::new();
    for &one in charts {
        let span = one.span.ok_or("the chart does not stand in a file of XML")?;
        places.push((span, chart(one)?));
    }
    places.sort();
    let mark = usize::from(file.starts_with('\u{feff}')) * '\u{feff}'.len_utf8();
    let mut text = String::new();
    let mut at = 0;
    for ((start, end), element) in places {
        let (start, end) = (start + mark, end + mark);
        let before = file.get(at..start).ok_or("charts overlap")?;
        text += before;
        // The element keeps its prefix, if it has one, by naming its namespace.
        let own = file.get(start..end).unwrap_or_default();
        let is_plain = own.starts_with("<SFC");
        if is_plain {
            text += &element
        } else {
            text += &with_namespace(file, &element)
        }
        at = end;
    }
    text += file.get(at..).unwrap_or_default();
    Ok(text)
}

fn with_namespace(file: &str, element: &str) -> String {
    let uri =
        file.split("http://www.plcopen.org/xml/").nth(1).and_then(|rest| rest.split('"').next());
    let uri = uri
        .map_or_else(|| NAMESPACE.to_owned(), |rest| format!("http://www.plcopen.org/xml/{rest}"));
    element.replacen("<SFC>", &format!("<SFC xmlns=\"{uri}\">"), 1)
}

struct Writer<'c> {
    chart: &'c Chart,
    text: String,
    next: u32,
    /// The number of each step.
    steps: Vec<u32>,
}

impl Writer<'_> {
    fn number(&mut self) -> u32 {
        self.next += 1;
        self.next - 1
    }

    /// Where a step stands: its distance from the initial steps.
    fn levels(&self) -> Vec<usize> {
        let mut levels = vec![usize::MAX; self.chart.steps.len()];
        let mut open = self.chart.initial();
        open.iter().for_each(|&step| levels[step] = 0);
        while let Some(step) = (!open.is_empty()).then(|| open.remove(0)) {
            for one in self.chart.transitions.iter().filter(|one| one.from.contains(&step)) {
                for &next in &one.to {
                    if levels[next] == usize::MAX {
                        levels[next] = levels[step] + 1;
                        open.push(next);
                    }
                }
            }
        }
        let last = levels.iter().filter(|&&level| level != usize::MAX).max().copied().unwrap_or(0);
        levels.iter_mut().filter(|level| **level == usize::MAX).for_each(|level| *level = last + 1);
        levels
    }

    fn line(&mut self, level: usize, text: &str) {
        let _ = writeln!(self.text, "{}{text}", "  ".repeat(level));
    }

    fn position(&mut self, (x, y): (usize, usize)) {
        self.line(2, &format!("<position x=\"{x}\" y=\"{y}\"/>"));
    }

    /// Points where an element is led into, each from one of these numbers.
    fn inputs(&mut self, from: &[u32]) {
        for id in from {
            self.line(2, "<connectionPointIn>");
            self.line(3, &format!("<connection refLocalId=\"{id}\"/>"));
            self.line(2, "</connectionPointIn>");
        }
    }

    fn outputs(&mut self, count: usize) {
        (0..count).for_each(|_| self.line(2, "<connectionPointOut formalParameter=\"\"/>"));
    }

    /// A bar between steps and transitions; its number.
    fn bar(&mut self, name: &str, at: (usize, usize), from: &[u32], out: usize) -> u32 {
        let id = self.number();
        self.line(1, &format!("<{name} localId=\"{id}\">"));
        self.position(at);
        self.inputs(from);
        // The schema has names for the ways out of a bar that diverges alone.
        match name {
            "selectionConvergence" | "simultaneousConvergence" => {
                self.line(2, "<connectionPointOut/>")
            }
            _ => self.outputs(out),
        }
        self.line(1, &format!("</{name}>"));
        id
    }

    fn chart(&mut self) -> Result<(), String> {
        let chart = self.chart;
        let levels = self.levels();
        let mut columns: BTreeMap<usize, usize> = BTreeMap::new();
        let places: Vec<(usize, usize)> = levels
            .iter()
            .map(|&level| {
                let column = columns.entry(level).or_insert(0);
                *column += 1;
                (40 + (*column - 1) * 260, 40 + level * 160)
            })
            .collect();
        self.steps = chart.steps.iter().map(|_| self.number()).collect();
        // What leads out of each step: itself, or the bar of a selection.
        let mut out: Vec<u32> = self.steps.clone();
        for step in 0..chart.steps.len() {
            let ways = chart.transitions.iter().filter(|one| one.from.contains(&step)).count();
            if ways > 1 {
                let (x, y) = places[step];
                out[step] = self.bar("selectionDivergence", (x, y + 40), &[self.steps[step]], ways);
            }
        }
        let mut into: Vec<Vec<u32>> = vec![Vec::new(); chart.steps.len()];
        for (at, one) in chart.transitions.iter().enumerate() {
            let (x, y) = places[one.from[0]];
            let shift =
                chart.transitions[..at].iter().filter(|other| other.from[0] == one.from[0]).count();
            let place = (x + shift * 120, y + 80);
            let mut from: Vec<u32> = one.from.iter().map(|&step| out[step]).collect();
            if from.len() > 1 {
                from = vec![self.bar("simultaneousConvergence", (place.0, place.1 - 20), &from, 1)];
            }
            let id = self.transition(at, &from, place)?;
            let mut end = id;
            if one.to.len() > 1 {
                end = self.bar(
                    "simultaneousDivergence",
                    (place.0, place.1 + 20),
                    &[id],
                    one.to.len(),
                );
            }
            for &step in &one.to {
                let is_forward =
                    levels[step] > one.from.iter().map(|&from| levels[from]).max().unwrap_or(0);
                if is_forward && !chart.steps[step].initial {
                    into[step].push(end);
                } else {
                    self.jump(&chart.steps[step].name, end, (place.0, place.1 + 40));
                }
            }
        }
        for (step, from) in into.into_iter().enumerate() {
            let (x, y) = places[step];
            let from = if from.len() > 1 {
                vec![self.bar("selectionConvergence", (x, y - 20), &from, 1)]
            } else {
                from
            };
            self.step(step, &from, places[step])?;
        }
        Ok(())
    }

    fn transition(
        &mut self,
        at: usize,
        from: &[u32],
        place: (usize, usize),
    ) -> Result<u32, String> {
        let one = &self.chart.transitions[at];
        let id = self.number();
        let rivals = self.chart.transitions.iter().enumerate();
        let rivals =
            rivals.filter(|(_, other)| other.from.iter().any(|step| one.from.contains(step)));
        let rank = rivals.clone().take_while(|(other, _)| *other <= at).count();
        let priority =
            if rivals.count() > 1 { format!(" priority=\"{rank}\"") } else { String::new() };
        self.line(1, &format!("<transition localId=\"{id}\"{priority}>"));
        self.position(place);
        self.inputs(from);
        self.line(2, "<connectionPointOut/>");
        self.line(2, "<condition>");
        let condition = escaped(&show::expr(&one.condition));
        self.line(
            3,
            &format!("<inline name=\"\"><ST><p xmlns=\"{HTML}\">{condition}</p></ST></inline>"),
        );
        self.line(2, "</condition>");
        self.line(1, "</transition>");
        Ok(id)
    }

    fn jump(&mut self, name: &str, from: u32, place: (usize, usize)) {
        let id = self.number();
        self.line(1, &format!("<jumpStep localId=\"{id}\" targetName=\"{}\">", escaped(name)));
        self.position(place);
        self.inputs(&[from]);
        self.line(1, "</jumpStep>");
    }

    fn step(&mut self, at: usize, from: &[u32], place: (usize, usize)) -> Result<(), String> {
        let step = &self.chart.steps[at];
        let (id, name) = (self.steps[at], escaped(&step.name));
        let initial = if step.initial { " initialStep=\"true\"" } else { "" };
        self.line(1, &format!("<step localId=\"{id}\" name=\"{name}\"{initial}>"));
        self.position(place);
        self.inputs(from);
        self.outputs(1);
        if !step.blocks.is_empty() {
            self.line(2, "<connectionPointOutAction formalParameter=\"\"/>");
        }
        self.own_actions(step);
        self.line(1, "</step>");
        if step.blocks.is_empty() {
            return Ok(());
        }
        let block = self.number();
        self.line(1, &format!("<actionBlock localId=\"{block}\">"));
        self.position((place.0 + 100, place.1));
        self.inputs(&[id]);
        for block in &step.blocks {
            self.block(block)?;
        }
        self.line(1, "</actionBlock>");
        Ok(())
    }

    /// The actions of a step itself, as CODESYS and TwinCAT write them.
    fn own_actions(&mut self, step: &Step) {
        let all = [(ENTRY, &step.entry), (ACTIVE, &step.active), (EXIT, &step.exit)];
        if all.iter().all(|(_, path)| path.is_none()) {
            return;
        }
        self.line(2, "<addData>");
        self.line(3, &format!("<data name=\"{ELEMENT}\" handleUnknown=\"implementation\">"));
        self.line(4, "<attributes xmlns=\"\">");
        for (guid, path) in all {
            if let Some(path) = path {
                self.line(
                    5,
                    &format!(
                        "<attribute guid=\"{guid}\">{}</attribute>",
                        escaped(&show::path(path))
                    ),
                );
            }
        }
        self.line(4, "</attributes>");
        self.line(3, "</data>");
        self.line(2, "</addData>");
    }

    fn block(&mut self, block: &Block) -> Result<(), String> {
        let id = self.number();
        let duration =
            block.time.as_ref().map(|time| format!(" duration=\"{}\"", escaped(&show::expr(time))));
        let (qualifier, duration) = (block.qualifier.name(), duration.unwrap_or_default());
        self.line(2, &format!("<action localId=\"{id}\" qualifier=\"{qualifier}\"{duration}>"));
        self.line(3, "<relPosition x=\"0\" y=\"0\"/>");
        match &block.target {
            Target::Path(path) => {
                self.line(3, &format!("<reference name=\"{}\"/>", escaped(&show::path(path))));
            }
            Target::Inline(name, body) => match body.as_ref() {
                Body::Code(_, statements) => {
                    let text = escaped(&show::statements(statements, 0));
                    self.line(
                        3,
                        &format!("<inline><ST><p xmlns=\"{HTML}\">{text}</p></ST></inline>"),
                    );
                }
                _ => return Err(format!("the action {name} has no form in text")),
            },
        }
        self.line(2, "</action>");
        Ok(())
    }
}

/// A whole project; bodies other than charts as structured text.
///
/// # Errors
/// What of it cannot be written, in words.
pub fn project(project: &Project) -> Result<String, String> {
    let mut text = format!(
        "<?xml version=\"1.0\" encoding=\"utf-8\"?>\n<project xmlns=\"{NAMESPACE}\">\n\
         <fileHeader companyName=\"\" productName=\"scanbound\" productVersion=\"1\" creationDateTime=\"1970-01-01T00:00:00\"/>\n\
         <contentHeader name=\"\">\n<coordinateInfo><fbd><scaling x=\"1\" y=\"1\"/></fbd><ld><scaling x=\"1\" y=\"1\"/></ld>\
         <sfc><scaling x=\"1\" y=\"1\"/></sfc></coordinateInfo>\n</contentHeader>\n<types>\n<dataTypes>\n"
    );
    for one in &project.types {
        let of = type_of(&one.of)?;
        let _ = writeln!(
            text,
            "<dataType name=\"{}\"><baseType>{of}</baseType></dataType>",
            escaped(&one.name)
        );
    }
    text += "</dataTypes>\n<pous>\n";
    for pou in &project.pous {
        text += &unit(pou)?;
    }
    text += "</pous>\n</types>\n<instances>\n<configurations>\n<configuration name=\"config\">\n<resource name=\"resource\">\n";
    for task in &project.tasks {
        let mut instances = String::new();
        for (name, of) in &task.instances {
            let _ = writeln!(
                instances,
                "<pouInstance name=\"{}\" typeName=\"{}\"/>",
                escaped(name),
                escaped(of)
            );
        }
        if task.name.is_empty() {
            text += &instances;
            continue;
        }
        let interval = task.interval.map(|time| format!(" interval=\"{}\"", show::time(time)));
        let priority = task.priority.as_deref().unwrap_or("0");
        let (name, interval) = (escaped(&task.name), interval.unwrap_or_default());
        let _ = writeln!(
            text,
            "<task name=\"{name}\"{interval} priority=\"{priority}\">\n{instances}</task>"
        );
    }
    for (_, variables) in &project.globals {
        text += &section("globalVars", variables.iter())?;
    }
    text += "</resource>\n</configuration>\n</configurations>\n</instances>\n</project>\n";
    Ok(text)
}

fn unit(pou: &Pou) -> Result<String, String> {
    let plain = plain(pou)?;
    let pou = plain.as_ref().unwrap_or(pou);
    let kind = match pou.kind {
        PouKind::Program => "program",
        PouKind::FunctionBlock => "functionBlock",
        PouKind::Function => "function",
        PouKind::Interface => {
            return Err(format!("{}: PLCopen XML has no place for interfaces", pou.name));
        }
    };
    if let Some(method) = pou.methods.first() {
        let (unit, name) = (&pou.name, &method.name);
        return Err(format!("{unit}: PLCopen XML has no place for methods such as {name}"));
    }
    let mut text =
        format!("<pou name=\"{}\" pouType=\"{kind}\">\n<interface>\n", escaped(&pou.name));
    if let Some(result) = &pou.result {
        let _ = writeln!(text, "<returnType>{}</returnType>", type_of(result)?);
    }
    let sections = [
        (Section::Input, "inputVars"),
        (Section::Output, "outputVars"),
        (Section::InOut, "inOutVars"),
        (Section::Local, "localVars"),
        (Section::Temp, "tempVars"),
        (Section::External, "externalVars"),
    ];
    for (own, name) in sections {
        text += &section(name, pou.variables.iter().filter(|one| one.section == own))?;
    }
    text += "</interface>\n";
    if !pou.actions.is_empty() {
        text += "<actions>\n";
        for action in &pou.actions {
            let name = escaped(&action.name);
            let _ = writeln!(
                text,
                "<action name=\"{name}\">\n<body>{}</body>\n</action>",
                body(&action.body)?
            );
        }
        text += "</actions>\n";
    }
    let _ = writeln!(text, "<body>{}</body>\n</pou>", body(&pou.body)?);
    Ok(text)
}

fn body(body: &Body) -> Result<String, String> {
    match body {
        Body::Chart(one) => chart(one),
        Body::Code(_, statements) => {
            let text = escaped(&show::statements(statements, 0));
            if text.contains('~') {
                return Err("a body keeps a result for itself, and has no form in text".to_owned());
            }
            Ok(format!("<ST><p xmlns=\"{HTML}\">{text}</p></ST>"))
        }
        Body::Unread(_, fault) => Err(fault.message.clone()),
    }
}

fn section<'v>(
    name: &str,
    variables: impl Iterator<Item = &'v Variable>,
) -> Result<String, String> {
    let mut text = String::new();
    for one in variables {
        let at =
            one.at.as_ref().map(|at| format!(" address=\"{}\"", escaped(at))).unwrap_or_default();
        let of = type_of(&one.of)?;
        let initial = match &one.initial {
            None | Some(Expr::Call(..)) => String::new(),
            Some(value) => {
                let value = escaped(&show::expr(value));
                format!("<initialValue><simpleValue value=\"{value}\"/></initialValue>")
            }
        };
        let element = format!(
            "<variable name=\"{}\"{at}><type>{of}</type>{initial}</variable>",
            escaped(&one.name)
        );
        let constant = if one.constant { " constant=\"true\"" } else { "" };
        let retain = if one.retain { " retain=\"true\"" } else { "" };
        let _ = writeln!(text, "<{name}{constant}{retain}>{element}</{name}>");
    }
    Ok(text)
}

fn type_of(of: &TypeRef) -> Result<String, String> {
    Ok(match of {
        TypeRef::Named(name) => {
            const ELEMENTARY: &[&str] = &[
                "BOOL", "BYTE", "WORD", "DWORD", "LWORD", "SINT", "INT", "DINT", "LINT", "USINT",
                "UINT", "UDINT", "ULINT", "REAL", "LREAL", "TIME", "DATE", "DT", "TOD",
            ];
            let upper = name.to_ascii_uppercase();
            if ELEMENTARY.contains(&upper.as_str()) {
                format!("<{upper}/>")
            } else {
                format!("<derived name=\"{}\"/>", escaped(name))
            }
        }
        TypeRef::Subrange(of, range) => {
            let unsigned =
                matches!(&**of, TypeRef::Named(name) if name.to_ascii_uppercase().starts_with('U'));
            let kind = if unsigned { "subrangeUnsigned" } else { "subrangeSigned" };
            let [lower, upper] = [&range.0, &range.1].map(|bound| escaped(&show::expr(bound)));
            format!(
                "<{kind}><range lower=\"{lower}\" upper=\"{upper}\"/><baseType>{}</baseType></{kind}>",
                type_of(of)?
            )
        }
        TypeRef::Text(None) => "<string/>".to_owned(),
        TypeRef::Text(Some(length)) => {
            format!("<string length=\"{}\"/>", escaped(&show::expr(length)))
        }
        TypeRef::Array(dimensions, of) => {
            let mut text = "<array>".to_owned();
            for (low, high) in dimensions {
                let (low, high) = (escaped(&show::expr(low)), escaped(&show::expr(high)));
                let _ = write!(text, "<dimension lower=\"{low}\" upper=\"{high}\"/>");
            }
            let _ = write!(text, "<baseType>{}</baseType></array>", type_of(of)?);
            text
        }
        TypeRef::Struct(parts) => {
            let mut text = "<struct>".to_owned();
            for part in parts {
                let (name, of) = (escaped(&part.name), type_of(&part.of)?);
                let _ = write!(text, "<variable name=\"{name}\"><type>{of}</type></variable>");
            }
            text + "</struct>"
        }
        TypeRef::Enumeration(values, base) => {
            let value = |(name, number): &(String, Option<Expr>)| {
                let number = number.as_ref().map(|number| escaped(&show::expr(number)));
                let number =
                    number.map(|number| format!(" value=\"{number}\"")).unwrap_or_default();
                format!("<value name=\"{}\"{number}/>", escaped(name))
            };
            let values: String = values.iter().map(value).collect();
            let base = match base {
                Some(base) => format!("<baseType>{}</baseType>", type_of(base)?),
                None => String::new(),
            };
            format!("<enum><values>{values}</values>{base}</enum>")
        }
        TypeRef::Reference(_) => {
            return Err("PLCopen XML has no place for references".to_owned());
        }
        TypeRef::Pointer(of) => format!("<pointer><baseType>{}</baseType></pointer>", type_of(of)?),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::iec::chart::text;
    use crate::iec::{parse, xml};

    const TEXT: &str = "
        PROGRAM main VAR a AT %IX0.0 : BOOL; n : ARRAY[1..3] OF INT := 5; m, v : BOOL; END_VAR
        INITIAL_STEP s0: END_STEP
        STEP s1: m(SD, T#1s500ms); count(P); END_STEP
        STEP s2: v(N); END_STEP
        STEP s3: m(R); END_STEP
        STEP s4: END_STEP
        TRANSITION FROM s0 TO (s1, s2) := a AND n[1] < 3; END_TRANSITION
        TRANSITION FROM s1 TO s3 := a; END_TRANSITION
        TRANSITION FROM s1 TO s4 := NOT a; END_TRANSITION
        TRANSITION FROM s4 TO s3 := TRUE; END_TRANSITION
        TRANSITION FROM (s2, s3) TO s0 := TRUE; END_TRANSITION
        TRANSITION FROM s4 TO s1 := s4.T > T#1s; END_TRANSITION
        ACTION count: n[2] := n[2] + 1; END_ACTION
        END_PROGRAM
        CONFIGURATION c RESOURCE r ON p TASK t(INTERVAL := T#20ms, PRIORITY := 1); PROGRAM i WITH t : main; END_RESOURCE END_CONFIGURATION";

    /// The chart's elements, sorted: transitions that do not compete may stand in any order.
    fn shown(project: &Project) -> Vec<String> {
        let Body::Chart(chart) = &project.pous[0].body else { panic!("a chart") };
        let text = text::chart(chart, &[]).replace("  TRANSITION", "END_TRANSITION");
        let mut parts: Vec<String> =
            text.split("END_TRANSITION").map(|part| part.trim().to_owned()).collect();
        parts.sort();
        parts
    }

    #[test]
    fn what_is_written_is_read_again() {
        let read = parse::file("a.st", TEXT).expect("a program");
        let written = project(&read).expect("XML");
        assert!(xml::begins(&written));
        let again = xml::file("a.xml", &written).expect("the same");
        assert_eq!(shown(&again), shown(&read));
        assert_eq!(again.pous[0].actions[0].name, "count");
        assert_eq!(again.tasks, read.tasks);
        let plain = |project: &Project| {
            let own = project.pous[0].variables.iter();
            own.map(|one| (one.name.clone(), one.of.clone(), one.at.clone(), one.initial.clone()))
                .collect::<Vec<_>>()
        };
        assert_eq!(plain(&again), plain(&read));
    }

    #[test]
    fn a_chart_takes_its_place_in_a_file_and_nothing_else_changes() {
        let read = parse::file("a.st", TEXT).expect("a program");
        let written = project(&read).expect("XML").replace("<pous>", "<pous><!-- ours \u{e9} -->");
        let file = xml::file("a.xml", &written).expect("read");
        let Body::Chart(own) = &file.pous[0].body else { panic!("a chart") };
        let mut changed = own.as_ref().clone();
        changed.steps[4].name = "other".to_owned();
        let replaced = replaced(&written, &[&changed]).expect("replaced");
        assert!(replaced.contains("<!-- ours \u{e9} -->") && replaced.contains("name=\"other\""));
        let again = xml::file("a.xml", &replaced).expect("read again");
        let mut renamed: Vec<String> = shown(&file)
            .iter()
            .map(|part| part.replace("s4", "other").replace("other.T", "s4.T"))
            .collect();
        renamed.sort();
        assert_eq!(shown(&again), renamed);
    }
}
