//! Writes projects and charts as PLCopen XML 2.01, in a form that other tools can open.

use super::drawing::{self, HTML, escaped};
use super::kept::Kept;
use super::node::Text;
use crate::ast::Expr;
use crate::chart::Chart;
use crate::chart::plain::plain;
use crate::{Body, Pou, PouKind, Project, Section, TypeRef, Variable, show};
use roxmltree::Document;
use std::fmt::Write;

const NAMESPACE: &str = "http://www.plcopen.org/xml/tc6_0201";

/// Writes a chart as an element SFC in the default namespace of its surroundings.
///
/// # Errors
/// The reason why a part cannot be written, such as a drawn condition that has no text form.
pub fn chart(chart: &Chart) -> Result<String, String> {
    Ok(format!("<SFC>\n{}</SFC>", drawing::chart(chart, None)?))
}

/// Replaces charts of a file. Parts that a chart shares with the one that it replaces are copied: conditions, bodies of
/// actions, comments, documentation, additional data.
///
/// # Errors
/// The file cannot be read, a chart is not one of the file, or as for [`chart`].
pub fn replaced(file: &str, charts: &[&Chart]) -> Result<String, String> {
    let plain = file.trim_start_matches('\u{feff}');
    let wrong = |error: roxmltree::Error| format!("the file cannot be read: {error}");
    let document = Document::parse(plain).map_err(wrong)?;
    let before = super::file("", plain)
        .map_err(|faults| faults.first().map_or_else(String::new, |one| one.message.clone()))?;
    let (lines, all) = (Text::new(plain, &document, None), before.charts());
    let mut places: Vec<((usize, usize), String)> = Vec::new();
    for &one in charts {
        let span = one.span.ok_or("the chart is not from an XML file")?;
        let own = all.iter().find(|(.., chart)| chart.span == Some(span));
        let mut nodes = document.descendants();
        let node =
            nodes.find(|node| node.is_element() && (node.range().start, node.range().end) == span);
        let (Some((name, _, own)), Some(node)) = (own, node) else {
            return Err("the chart is not one of the file".to_owned());
        };
        let kept = Kept::new(plain, &lines, node, own);
        let inner = drawing::chart(one, Some(&kept)).map_err(|why| format!("{name}: {why}"))?;
        // An element with a namespace prefix is written without it, in the same namespace.
        let element = match kept.opening().filter(|opening| opening.starts_with("<SFC")) {
            Some(opening) => format!("{opening}\n{inner}</SFC>"),
            None => {
                let uri = node.tag_name().namespace().unwrap_or(NAMESPACE);
                format!("<SFC xmlns=\"{uri}\">\n{inner}</SFC>")
            }
        };
        places.push((span, element));
    }
    places.sort();
    let mut text = file[..file.len() - plain.len()].to_owned();
    let mut at = 0;
    for ((start, end), element) in places {
        text += plain.get(at..start).ok_or("charts overlap")?;
        text += &element;
        at = end;
    }
    text += plain.get(at..).unwrap_or_default();
    match Document::parse(text.trim_start_matches('\u{feff}')) {
        Ok(_) => Ok(text),
        Err(error) => {
            Err(format!("what is kept of the file is not valid in its new place: {error}"))
        }
    }
}

/// Writes a whole project; bodies other than charts are written as structured text.
///
/// # Errors
/// The reason why a part of it cannot be written.
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
    text += "</pous>\n</types>\n<instances>\n<configurations>\n";
    let first = project.tasks.first().and_then(|task| task.resource.split_once(' '));
    let (configuration, resource) = first.unwrap_or(("config", "resource"));
    let (configuration, resource) = (escaped(configuration), escaped(resource));
    let _ =
        write!(text, "<configuration name=\"{configuration}\">\n<resource name=\"{resource}\">\n");
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
            return Err(format!("{}: PLCopen XML cannot express interfaces", pou.name));
        }
    };
    if let Some(method) = pou.methods.first() {
        let (unit, name) = (&pou.name, &method.name);
        return Err(format!("{unit}: PLCopen XML cannot express methods such as {name}"));
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
                body(&action.body).map_err(|why| format!("{}.{}: {why}", pou.name, action.name))?
            );
        }
        text += "</actions>\n";
    }
    let own = body(&pou.body).map_err(|why| format!("{}: {why}", pou.name))?;
    let _ = writeln!(text, "<body>{own}</body>\n</pou>");
    Ok(text)
}

fn body(body: &Body) -> Result<String, String> {
    match body {
        Body::Chart(one) => chart(one),
        other => {
            let text = escaped(&drawing::in_text(other)?);
            Ok(format!("<ST><p xmlns=\"{HTML}\">{text}</p></ST>"))
        }
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
            None | Some(Expr::Call(..) | Expr::List(..)) => String::new(),
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
            return Err("PLCopen XML cannot express references".to_owned());
        }
        TypeRef::Pointer(of) => format!("<pointer><baseType>{}</baseType></pointer>", type_of(of)?),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chart::text;
    use crate::{parse, xml};

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
