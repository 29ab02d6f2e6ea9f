//! Drawn charts of Beremiz and OpenPLC, whose generator writes them as text in an order of its own.

use scanbound::audit::{Request, audit};
use scanbound::base::facts::Facts;
use scanbound::front::Input;
use scanbound::passes::values::Trust;
use scanbound::timing::table::{CLASSES, Table};

/// The bound in microseconds, if SIN takes 1 us, and nothing else anything.
fn bound(text: &str, trust: Trust) -> u64 {
    let classes: String = CLASSES.iter().map(|class| format!("@{class},0,0\n")).collect();
    let rows = format!("instruction,on_us,off_us\n{classes}SIN,1,1\n@end,0,\n");
    let table = Table::parse("t.csv", rows.as_bytes()).expect("a table").table;
    let inputs = [Input { name: "p.xml".to_owned(), bytes: text.as_bytes().to_vec() }];
    let facts = Facts::default();
    let request = Request { table: Some(&table), trust, ..Request::new(&inputs, &facts) };
    let found = audit(&request).unwrap_or_else(|failure| panic!("{failure:?}\n{text}"));
    found.bound.upper.0 / 1_000_000
}

fn text(code: &str) -> String {
    format!("<ST><xhtml xmlns=\"http://www.w3.org/1999/xhtml\">{code}</xhtml></ST>")
}

fn variables(list: &str, names: &[(&str, &str)]) -> String {
    let all = names
        .iter()
        .map(|(name, of)| format!("<variable name=\"{name}\"><type>{of}</type></variable>"));
    format!("<{list}>{}</{list}>", all.collect::<String>())
}

/// A block with this chart, and a program that executes SIN where `condition` is true after a call with these
/// arguments. `actions`: names and code.
fn project(actions: &[(&str, String)], chart: &[String], call: &str, condition: &str) -> String {
    let own = [
        ("i0", "<BOOL/>"),
        ("i1", "<BOOL/>"),
        ("h", "<DINT/>"),
        ("x", "<BOOL/>"),
        ("y", "<BOOL/>"),
    ];
    let actions = actions.iter().map(|(name, code)| {
        format!("<action name=\"{name}\"><body>{}</body></action>", text(code))
    });
    let inputs = "<localVars><variable name=\"i0\" address=\"%IX0.0\"><type><BOOL/></type></variable>\
                  <variable name=\"i1\" address=\"%IX0.1\"><type><BOOL/></type></variable></localVars>";
    format!(
        "<project xmlns=\"http://www.plcopen.org/xml/tc6_0201\"><types><dataTypes/><pous>\
         <pou name=\"FBX\" pouType=\"functionBlock\"><interface>{}</interface><actions>{}</actions>\
         <body><SFC>{}</SFC></body></pou>\
         <pou name=\"main\" pouType=\"program\"><interface>{inputs}{}</interface><body>{}</body></pou>\
         </pous></types><instances><configurations/></instances></project>",
        variables("inputVars", &own),
        actions.collect::<String>(),
        chart.concat(),
        variables("localVars", &[("f", "<derived name=\"FBX\"/>"), ("r", "<REAL/>")]),
        text(&format!("f({call}); IF {condition} THEN r := SIN(r); END_IF;"))
    )
}

/// An element that is connected behind another one, unless that is 0.
fn element(kind: &str, id: u32, from: u32, attributes: &str, inner: &str) -> String {
    let point = match from {
        0 => String::new(),
        from => {
            format!("<connectionPointIn><connection refLocalId=\"{from}\"/></connectionPointIn>")
        }
    };
    format!("<{kind} localId=\"{id}\" {attributes}>{point}{inner}</{kind}>")
}

fn step(id: u32, from: u32, name: &str) -> String {
    let initial = if from == 0 { " initialStep=\"true\"" } else { "" };
    element("step", id, from, &format!("name=\"{name}\"{initial}"), "")
}

fn transition(id: u32, from: u32, priority: &str, condition: &str) -> String {
    let inner = format!("<condition><inline name=\"\">{}</inline></condition>", text(condition));
    element("transition", id, from, priority, &inner)
}

fn block(id: u32, of: u32, actions: &[(&str, &str)]) -> String {
    let action = |(qualifier, name): &(&str, &str)| {
        format!("<action qualifier=\"{qualifier}\"><reference name=\"{name}\"/></action>")
    };
    element("actionBlock", id, of, "", &actions.iter().map(action).collect::<String>())
}

#[test]
fn actions_run_in_the_order_in_which_the_generator_comes_to_them() {
    // S0 leads to S1 and S3, or to S2 and S4.
    let s0 = step(1, 0, "S0");
    let steps = [step(2, 12, "S1"), step(3, 13, "S2"), step(4, 14, "S3"), step(5, 15, "S4")];
    let blocks = [
        block(22, 2, &[("S", "e"), ("S", "b")]),
        block(23, 3, &[("S", "d")]),
        block(24, 4, &[("S", "a")]),
        block(25, 5, &[("S", "c")]),
    ];
    let transitions = [
        transition(12, 1, "", "i0"),
        transition(13, 1, "", "NOT i0"),
        transition(14, 2, "", "TRUE"),
        transition(15, 3, "", "TRUE"),
        transition(16, 4, "", "TRUE"),
        transition(17, 5, "", "TRUE"),
    ];
    let jumps = [16, 17].map(|from| element("jumpStep", from + 20, from, "targetName=\"S0\"", ""));
    let actions: Vec<(&str, String)> = ["a", "b", "c", "d", "e"]
        .into_iter()
        .zip(1..)
        .map(|(name, number)| (name, format!("h := h * 9 + {number};")))
        .collect();
    // The last steps first: S4 leads to S2 and its transition before S3 leads to S1. So S2 and S4 are written first.
    let chart: Vec<String> = steps
        .iter()
        .rev()
        .chain([&s0])
        .chain(&transitions)
        .chain(&blocks)
        .chain(&jumps)
        .cloned()
        .collect();
    let order =
        |names: &str| names.bytes().fold(0, |sum, name| sum * 9 + u32::from(name - b'a' + 1));
    for trust in [Trust::Counts, Trust::All] {
        let longest = |names: &str| {
            let condition = format!("f.h = {}", order(names));
            bound(&project(&actions, &chart, "i0 := i0, i1 := i1, h := 0", &condition), trust)
        };
        assert_eq!(longest("dceba"), 1, "{trust:?}");
        // An order that nothing leads to.
        assert_eq!(longest("acbed"), 0, "{trust:?}");
    }
}

#[test]
fn of_transitions_with_the_same_priority_any_may_come_first() {
    // A1 and B1 are active together. B1 leads to B2 while A1 is active, and to B3 otherwise.
    let chart = |is_reversed: bool| -> Vec<String> {
        let mut ways = [
            transition(13, 3, "priority=\"1\"", "i0"),
            transition(14, 4, "priority=\"1\"", "A1.X AND i0"),
            transition(15, 4, "priority=\"2\"", "NOT A1.X AND i0"),
        ];
        if is_reversed {
            ways.reverse();
        }
        let begin = [
            step(1, 0, "S0"),
            transition(11, 1, "", "i0"),
            element("simultaneousDivergence", 12, 11, "", ""),
            step(3, 12, "A1"),
            step(4, 12, "B1"),
        ];
        let end = [
            step(5, 13, "A2"),
            step(6, 14, "B2"),
            step(7, 15, "B3"),
            block(25, 5, &[("P1", "ax")]),
            block(27, 7, &[("P1", "bx")]),
        ];
        begin.into_iter().chain(ways).chain(end).collect()
    };
    let actions = [("ax", "x := TRUE;".to_owned()), ("bx", "y := TRUE;".to_owned())];
    let call = "i0 := i0, i1 := i1, x := FALSE, y := FALSE";
    for is_reversed in [false, true] {
        let longest = |chart: &[String], condition: &str| {
            bound(&project(&actions, chart, call, condition), Trust::Counts)
        };
        assert_eq!(longest(&chart(is_reversed), "f.x AND f.y"), 1, "reversed {is_reversed}");
    }
}
