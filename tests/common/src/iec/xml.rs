//! Projects of PLCopen XML with a drawing, put together from elements, and what is asked of their bounds.

use scanbound::audit::{Failure, Request, audit};
use scanbound::base::facts::Facts;
use scanbound::base::time::Picos;
use scanbound::front::Input;
use scanbound::passes::values::Trust;
use scanbound::timing::table::{CLASSES, Table};

/// The longest scan in microseconds, where a store takes one and nothing else anything.
pub fn bound(text: &str) -> Result<u64, Vec<String>> {
    bound_of(text, "ST")
}

/// The same where this takes one, and nothing else anything.
pub fn bound_of(text: &str, row: &str) -> Result<u64, Vec<String>> {
    bound_by(text, row, &Facts::default())
}

/// The same by what is stated.
pub fn bound_by(text: &str, row: &str, facts: &Facts) -> Result<u64, Vec<String>> {
    let mut rows = "instruction,on_us,off_us\n".to_owned();
    for class in CLASSES {
        rows += &format!("@{class},0,0\n");
    }
    rows += &format!("{row},1,1\n@end,0,\n");
    let table =
        Table::parse("t.csv", rows.as_bytes()).unwrap_or_else(|faults| panic!("{faults:?}")).table;
    let inputs = [Input { name: "main.xml".to_owned(), bytes: text.as_bytes().to_vec() }];
    let request =
        Request { table: Some(&table), trust: Trust::None, ..Request::new(&inputs, facts) };
    match audit(&request) {
        Ok(found) => Ok(found.bound.upper.0.div_ceil(Picos(1_000_000).0)),
        Err(Failure::Input(faults)) => Err(faults.into_iter().map(|fault| fault.message).collect()),
        Err(other) => panic!("{other:?}"),
    }
}

/// A project: units, variables in a list of globals, the program's body, and a condition that is asked for behind it.
pub fn project(units: &str, variables: &str, body: &str, condition: &str) -> String {
    let variable = |(name, of): (&str, &str)| {
        let of = match of {
            "BOOL" | "INT" => format!("<{of}/>"),
            _ => format!("<derived name=\"{of}\"/>"),
        };
        let address = if name == "a" { " address=\"%IX0.0\"" } else { "" };
        format!("<variable name=\"{name}\"{address}><type>{of}</type></variable>")
    };
    let all = format!("a:BOOL {variables}");
    let globals: String =
        all.split_whitespace().filter_map(|one| one.split_once(':')).map(variable).collect();
    let condition = condition.replace('<', "&lt;");
    format!(
        "<project xmlns=\"http://www.plcopen.org/xml/tc6_0201\"><types><dataTypes/><pous>{units}\
         <pou name=\"main\" pouType=\"program\"><interface/><body>{body}</body></pou>\
         <pou name=\"behind\" pouType=\"program\"><interface><localVars><variable name=\"heavy\"><type><INT/></type></variable></localVars></interface>\
         <body><ST><p>IF {condition} THEN FOR heavy := 1 TO 50 DO ; END_FOR END_IF</p></ST></body></pou></pous></types>\
         <instances><configurations><configuration name=\"c\"><resource name=\"r\"><globalVars>{globals}</globalVars></resource></configuration></configurations></instances></project>"
    )
}

/// A project as CODESYS writes it: drawings are executed as they are drawn.
pub fn as_drawn(text: &str) -> String {
    let data = "<addData><data name=\"http://www.3s-software.com/plcopenxml/objectid\"/></addData>";
    text.replacen("<types>", &format!("{data}<types>"), 1)
}

/// Whether a condition may hold behind a program.
pub fn may(units: &str, variables: &str, body: &str, condition: &str) -> bool {
    let text = project(units, variables, body, condition);
    bound(&text).unwrap_or_else(|faults| panic!("{faults:?}\n{text}")) > 50
}

/// An element with what leads to it.
pub fn at(head: &str, id: u32, from: &[(u32, &str)], inner: &str) -> String {
    let from: String = from
        .iter()
        .map(|(id, output)| {
            format!("<connection refLocalId=\"{id}\" formalParameter=\"{output}\"/>")
        })
        .collect();
    let name = head.split(' ').next().unwrap_or_default();
    format!(
        "<{head} localId=\"{id}\"><position x=\"{id}\" y=\"0\"/><connectionPointIn>{from}</connectionPointIn>{inner}</{name}>"
    )
}

pub fn contact(id: u32, more: &str, from: u32, of: &str) -> String {
    at(&format!("contact {more}"), id, &[(from, "")], &format!("<variable>{of}</variable>"))
}

pub fn coil(id: u32, from: u32, of: &str) -> String {
    at("coil", id, &[(from, "")], &format!("<variable>{of}</variable>"))
}

pub fn wired(id: u32, of: &str) -> String {
    at("inVariable", id, &[], &format!("<expression>{of}</expression>"))
}

pub fn out(id: u32, from: (u32, &str), of: &str) -> String {
    at("outVariable", id, &[from], &format!("<expression>{of}</expression>"))
}

pub fn block(id: u32, head: &str, inputs: &[(&str, (u32, &str))], outputs: &[&str]) -> String {
    let input = |(name, (from, output)): &(&str, (u32, &str))| {
        format!(
            "<variable formalParameter=\"{name}\"><connectionPointIn><connection refLocalId=\"{from}\" formalParameter=\"{output}\"/></connectionPointIn></variable>"
        )
    };
    let inputs: String = inputs.iter().map(input).collect();
    let output = |name: &&str| {
        let negated = if name.starts_with('!') { " negated=\"true\"" } else { "" };
        let name = name.trim_start_matches('!');
        format!("<variable formalParameter=\"{name}\"{negated}><connectionPointOut/></variable>")
    };
    let outputs: String = outputs.iter().map(output).collect();
    format!(
        "<block {head} localId=\"{id}\"><position x=\"{id}\" y=\"0\"/><inputVariables>{inputs}</inputVariables><inOutVariables/>\
         <outputVariables>{outputs}</outputVariables></block>"
    )
}

pub const RAIL: &str = "<leftPowerRail localId=\"0\"/>";

/// An element that stands elsewhere.
pub fn moved(text: &str, x: u32, y: u32) -> String {
    let (front, back) = text.split_once("<position").expect("a position");
    let behind = back.split_once("/>").expect("its end").1;
    format!("{front}<position x=\"{x}\" y=\"{y}\"/>{behind}")
}

/// A chart of one step, whose action blocks have bodies of their own.
pub fn chart(bodies: &[String], condition: &str) -> String {
    let actions: String = bodies
        .iter()
        .map(|body| format!("<action qualifier=\"N\"><inline>{body}</inline></action>"))
        .collect();
    format!(
        "<SFC><step localId=\"1\" name=\"s\" initialStep=\"true\"/>{}{}{}</SFC>",
        at("actionBlock", 2, &[(1, "")], &actions),
        at("transition", 3, &[(1, "")], &format!("<condition>{condition}</condition>")),
        at("jumpStep targetName=\"s\"", 4, &[(3, "")], "")
    )
}
