//! Charts as they are written: forms that the schema allows and that other tools follow, the same charts when they are
//! read again, and what is kept of the file in which they take their places.

use common::charts;
use common::tape::cases;

use charts::{Dice, chart, program};
use roxmltree::{Document, Node};
use scanbound::iec::chart::coactive::BUDGET;
use scanbound::iec::chart::explicit::{Rewriting, explicit, explicit_beside};
use scanbound::iec::chart::names::Taken;
use scanbound::iec::chart::{Chart, Qualifier};
use scanbound::iec::{self, Body, Project, show, xml};
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

fn name<'a>(node: Node<'a, '_>) -> &'a str {
    node.tag_name().name()
}

fn elements<'a, 'i>(node: Node<'a, 'i>) -> impl Iterator<Item = Node<'a, 'i>> {
    node.children().filter(Node::is_element)
}

/// What the schema says of an element of a chart: its attributes, and its children in their order; `*` marks what may
/// come several times, `!` what must.
fn schema(element: &str) -> Option<(&'static str, &'static str)> {
    Some(match element {
        "step" => (
            "localId! name! initialStep",
            "position! connectionPointIn connectionPointOut connectionPointOutAction addData documentation",
        ),
        "macroStep" => (
            "localId! name!",
            "position! connectionPointIn connectionPointOut body addData documentation",
        ),
        "transition" => (
            "localId! priority",
            "position! connectionPointIn connectionPointOut condition addData documentation",
        ),
        "jumpStep" => ("localId! targetName!", "position! connectionPointIn addData documentation"),
        "selectionDivergence" | "simultaneousDivergence" => {
            ("localId!", "position! connectionPointIn connectionPointOut* addData documentation")
        }
        "selectionConvergence" | "simultaneousConvergence" => {
            ("localId!", "position! connectionPointIn* connectionPointOut addData documentation")
        }
        "actionBlock" => ("localId!", "position! connectionPointIn action* addData documentation"),
        "action" => (
            "localId! qualifier duration",
            "relPosition! reference inline connectionPointOut addData documentation",
        ),
        _ => return None,
    })
}

/// Which outputs of which elements have names.
const NAMED: &[&str] = &["step", "selectionDivergence", "simultaneousDivergence"];

/// What is wrong with an element by the schema.
fn wrong(node: Node<'_, '_>) -> Option<String> {
    let (attributes, parts) = schema(name(node))?;
    let told =
        |what: String| Some(format!("{} {:?}: {what}", name(node), node.attribute("localId")));
    for one in attributes.split(' ') {
        let bare = one.trim_end_matches('!');
        if bare != one && node.attribute(bare).is_none() {
            return told(format!("no {bare}"));
        }
    }
    for one in node.attributes() {
        if !attributes.split(' ').any(|own| own.trim_end_matches('!') == one.name()) {
            return told(format!("{} is no attribute", one.name()));
        }
    }
    let mut left: Vec<&str> = parts.split(' ').collect();
    for part in elements(node) {
        let bare = |own: &str| own.trim_end_matches(['!', '*']).to_owned();
        let Some(at) = left.iter().position(|own| bare(own) == name(part)) else {
            return told(format!("{} does not stand here", name(part)));
        };
        if left[..at].iter().any(|own| own.ends_with('!')) {
            return told(format!("something is missing in front of {}", name(part)));
        }
        left.drain(..at + usize::from(!left[at].ends_with('*')));
        let is_named = NAMED.contains(&name(node));
        if name(part).starts_with("connectionPointOut")
            && part.attribute("formalParameter").is_some() != is_named
        {
            return told("the name of an output".to_owned());
        }
    }
    left.iter().find(|own| own.ends_with('!')).and_then(|own| told(format!("no {own}")))
}

/// Whether a file's charts have the schema's forms, and those that other tools follow.
fn is_well_drawn(text: &str) -> Result<(), String> {
    let document = Document::parse(text).map_err(|error| error.to_string())?;
    for sfc in document.descendants().filter(|node| name(*node) == "SFC") {
        let mut known: BTreeMap<&str, Node<'_, '_>> = BTreeMap::new();
        let mut places = BTreeSet::new();
        for node in elements(sfc) {
            let id = node.attribute("localId").ok_or("no localId")?;
            if known.insert(id, node).is_some() {
                return Err(format!("two elements have the localId {id}"));
            }
            let position = elements(node).find(|part| name(*part) == "position");
            let position = position.ok_or_else(|| format!("{id} stands nowhere"))?;
            let place = (position.attribute("x"), position.attribute("y"));
            if !places.insert(place) {
                return Err(format!("{id} stands where another one does: {place:?}"));
            }
        }
        let all = sfc
            .descendants()
            .filter(|node| node.ancestors().find(|one| name(*one) == "SFC") == Some(sfc));
        if let Some(told) = all.filter_map(wrong).next() {
            return Err(told);
        }
        for node in elements(sfc) {
            let points: Vec<Node<'_, '_>> =
                elements(node).filter(|part| name(*part) == "connectionPointIn").collect();
            for point in points {
                let ways: Vec<&str> =
                    elements(point).filter_map(|way| way.attribute("refLocalId")).collect();
                if schema(name(node)).is_some() && ways.len() != 1 {
                    return Err(format!("{} ways into one point of {}", ways.len(), name(node)));
                }
                for way in ways {
                    let from = known.get(way).ok_or_else(|| format!("{way} is not there"))?;
                    let allowed: &[&str] = match name(node) {
                        "step" | "jumpStep" | "macroStep" => {
                            &["transition", "selectionConvergence", "simultaneousDivergence"]
                        }
                        "transition" => {
                            &["step", "macroStep", "selectionDivergence", "simultaneousConvergence"]
                        }
                        "simultaneousConvergence" | "selectionDivergence" => &["step", "macroStep"],
                        "selectionConvergence" | "simultaneousDivergence" => &["transition"],
                        "actionBlock" => &["step", "macroStep"],
                        _ => continue,
                    };
                    if !allowed.contains(&name(*from)) {
                        return Err(format!("{} leads into {}", name(*from), name(node)));
                    }
                }
            }
        }
    }
    Ok(())
}

fn samples() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("samples/sfc")
}

#[test]
fn samples_are_drawn_as_the_schema_has_it() {
    let mut seen = 0;
    for directory in [samples(), samples().join("figures")] {
        for entry in fs::read_dir(directory).expect("samples").flatten() {
            let file = entry.path();
            if file.extension().is_some_and(|suffix| suffix == "xml") {
                let text = fs::read_to_string(&file).expect("a sample");
                assert_eq!(is_well_drawn(&text), Ok(()), "{}", file.display());
                seen += 1;
            }
        }
    }
    assert!(seen >= 6, "{seen}");
}

fn written(chart: &Chart) -> String {
    let project = Project {
        files: vec!["a.st".to_owned()],
        pous: vec![program(chart.clone(), 0)],
        ..Project::default()
    };
    xml::write::project(&project).expect("XML")
}

/// Steps with their actions, and transitions; those that compete with others in their order.
fn shown(chart: &Chart) -> BTreeSet<String> {
    let names = |steps: &[usize]| {
        let mut names: Vec<&str> = steps.iter().map(|&step| &*chart.steps[step].name).collect();
        names.sort_unstable();
        names.join(" ")
    };
    let mut all = BTreeSet::new();
    for step in &chart.steps {
        let blocks = step.blocks.iter().map(|block| {
            format!("{}({:?} {:?})", block.target.name(), block.qualifier, block.time)
        });
        all.insert(format!("{} {} {:?}", step.name, step.initial, blocks.collect::<Vec<_>>()));
    }
    for (at, one) in chart.transitions.iter().enumerate() {
        let rivals = chart.transitions[..at].iter();
        let rivals = rivals.filter(|other| other.from.iter().any(|step| one.from.contains(step)));
        let (from, to, rank) = (names(&one.from), names(&one.to), rivals.count());
        all.insert(format!("{from} -> {to} {rank} {}", show::expr(&one.condition)));
    }
    all
}

#[test]
fn random_charts_are_drawn_as_others_follow_them_and_read_again() {
    let stored = [Qualifier::S, Qualifier::Sd, Qualifier::Sl, Qualifier::Ds];
    let (mut rewritten, mut joins) = (0, 0);
    for seed in 0..cases(400) {
        let mut dice = Dice::new(seed + 41_000_000);
        let depth = dice.below(3);
        let before = chart(&mut dice, depth, 2, &stored);
        let (after, told) = explicit(&before, 5_000);
        for one in [&before, &after] {
            let text = written(one);
            assert_eq!(is_well_drawn(&text), Ok(()), "{text}");
            let again =
                xml::file("a.xml", &text).unwrap_or_else(|faults| panic!("{faults:?}\n{text}"));
            let Body::Chart(again) = &again.pous[0].body else { panic!("a chart") };
            assert_eq!(shown(again), shown(one), "{text}");
        }
        rewritten += told.iter().filter(|one| one.branch.is_ok()).count();
        let chosen = |step: &usize| {
            after.transitions.iter().filter(|one| one.from.contains(step)).count() > 1
        };
        let join = after.transitions.iter().filter(|one| one.from.len() > 1);
        joins += join.filter(|one| one.from.iter().any(chosen)).count();
    }
    assert!(
        rewritten > 150 && joins > 100,
        "{rewritten} rewritten, {joins} joins behind selections"
    );
}

/// A file with a chart that stores an action: these variables, actions, and elements in the chart.
fn file(variables: &str, actions: &str, first: &str, extra: &str) -> String {
    let condition = |text: &str| {
        format!("<condition><inline name=\"\"><ST><p>{text}</p></ST></inline></condition>")
    };
    let (second, third) = (condition("b (* when it is there *)"), condition("c"));
    let way = |id: u32, from: u32, condition: &str| {
        format!(
            "<transition localId=\"{id}\"><connectionPointIn><connection refLocalId=\"{from}\"/></connectionPointIn>{condition}</transition>\n"
        )
    };
    let step = |id: u32, from: u32, more: &str, inner: &str| {
        format!(
            "<step localId=\"{id}\" {more}><connectionPointIn><connection refLocalId=\"{from}\"/></connectionPointIn>{inner}</step>\n"
        )
    };
    let action = |id: u32, step: u32, qualifier: &str| {
        format!(
            "<actionBlock localId=\"{id}\"><connectionPointIn><connection refLocalId=\"{step}\"/></connectionPointIn>\n<action localId=\"1{id}\" qualifier=\"{qualifier}\"><reference name=\"A\"/></action></actionBlock>\n"
        )
    };
    let data = "<addData><data name=\"http://vendor.example/x\" handleUnknown=\"preserve\"><mark xmlns=\"\">red</mark></data></addData>";
    format!(
        "<project xmlns=\"http://www.plcopen.org/xml/tc6_0201\"><types><dataTypes/><pous>\n\
         <pou name=\"main\" pouType=\"program\"><interface><localVars>{variables}</localVars></interface>\
         <actions>{actions}</actions><body><SFC>\n{}{}{}{}{}{}{}{}{}{}{extra}</SFC></body></pou></pous></types></project>",
        step(1, 6, "name=\"s0\" initialStep=\"true\"", ""),
        way(2, 1, first),
        step(
            3,
            2,
            "name=\"s1\" width=\"77\"",
            &format!(
                "{data}<documentation><p xmlns=\"http://www.w3.org/1999/xhtml\">the first</p></documentation>"
            )
        ),
        way(4, 3, &second),
        step(5, 4, "name=\"s2\"", ""),
        way(6, 5, &third),
        action(7, 3, "S"),
        action(8, 5, "R"),
        "<comment localId=\"9\" width=\"9\" height=\"9\"><position x=\"1\" y=\"2\"/><content><p xmlns=\"http://www.w3.org/1999/xhtml\">mind the gap</p></content></comment>\n",
        "<!-- drawn in May -->\n",
    )
}

const PLAIN: &str = "<condition><inline name=\"\"><ST><p>a</p></ST></inline></condition>";

/// The file with its chart rewritten, and what became of its actions.
fn rewritten(text: &str) -> (Result<String, String>, Vec<Rewriting>) {
    let project = iec::read("a.xml", text).unwrap_or_else(|faults| panic!("{faults:?}\n{text}"));
    let mut taken = Taken::around(&project, &project.pous[0]);
    let Body::Chart(chart) = &project.pous[0].body else { panic!("a chart\n{text}") };
    let (next, told) = explicit_beside(chart, &mut taken, BUDGET);
    (xml::write::replaced(text, &[&next]), told)
}

fn boolean(name: &str) -> String {
    format!("<variable name=\"{name}\"><type><BOOL/></type></variable>")
}

#[test]
fn new_steps_take_no_name_that_is_taken() {
    let action = "<action name=\"A_ON2\"><body><ST><p>;</p></ST></body></action>";
    for (variables, actions, expected) in [
        (String::new(), "", "A_on"),
        (boolean("a_on"), "", "A_on2"),
        (boolean("a_on"), action, "A_on3"),
    ] {
        let (text, told) = rewritten(&file(&variables, actions, PLAIN, ""));
        assert_eq!(told[0].branch, Ok(vec![expected.to_owned()]));
        assert!(text.expect("written").contains(&format!("name=\"{expected}\"")));
    }
    let mut text = file("", "", PLAIN, "");
    text = text.replace(
        "<dataTypes/>",
        "<dataTypes><dataType name=\"A_ON\"><baseType><BOOL/></baseType></dataType></dataTypes>",
    );
    assert_eq!(rewritten(&text).1[0].branch, Ok(vec!["A_on2".to_owned()]));
}

#[test]
fn what_nothing_changes_stays_as_it_is_written() {
    let drawn = "<inline><FBD><inVariable localId=\"1\"><connectionPointOut/><expression>b</expression></inVariable>\
        <block localId=\"2\" typeName=\"TON\" instanceName=\"timer\"><inputVariables><variable formalParameter=\"IN\"><connectionPointIn><connection refLocalId=\"1\"/></connectionPointIn></variable></inputVariables><inOutVariables/><outputVariables/></block></FBD></inline>";
    let extra = format!(
        "<actionBlock localId=\"20\"><connectionPointIn><connection refLocalId=\"5\"/></connectionPointIn>\n<action localId=\"21\" qualifier=\"N\">{drawn}</action></actionBlock>"
    );
    let timer = "<variable name=\"timer\"><type><derived name=\"TON\"/></type></variable>";
    let source = file(timer, "", PLAIN, &extra);
    let (text, told) = rewritten(&source);
    assert!(told[0].branch.is_ok(), "{told:?}");
    let text = text.expect("written");
    for part in [
        drawn,
        "b (* when it is there *)",
        "<mark xmlns=\"\">red</mark>",
        "the first",
        "mind the gap",
        "<!-- drawn in May -->",
        "width=\"77\"",
    ] {
        assert_eq!(text.matches(part).count(), 1, "{part}\n{text}");
    }
    let again = iec::read("a.xml", &text).unwrap_or_else(|faults| panic!("{faults:?}\n{text}"));
    let Body::Chart(chart) = &again.pous[0].body else { panic!("a chart") };
    assert!(chart.step("A_on").is_some());
    // As the file has it, a second time changes nothing.
    assert_eq!(xml::write::replaced(&text, &[chart]).expect("written").matches(drawn).count(), 1);
}

#[test]
fn conditions_that_are_drawn_are_kept_or_their_actions_left_alone() {
    // A comparison, drawn beside the chart.
    let drawn = "<inVariable localId=\"30\"><connectionPointOut/><expression>n</expression></inVariable>\
        <inVariable localId=\"31\"><connectionPointOut/><expression>3</expression></inVariable>\
        <block localId=\"3100\" typeName=\"GT\"><inputVariables><variable formalParameter=\"IN1\"><connectionPointIn><connection refLocalId=\"30\"/></connectionPointIn></variable><variable formalParameter=\"IN2\"><connectionPointIn><connection refLocalId=\"31\"/></connectionPointIn></variable></inputVariables><inOutVariables/><outputVariables><variable formalParameter=\"OUT\"><connectionPointOut/></variable></outputVariables></block>";
    let condition = "<condition><connectionPointIn><connection refLocalId=\"3100\" formalParameter=\"OUT\"/></connectionPointIn></condition>";
    let number = "<variable name=\"n\"><type><INT/></type></variable>";
    let source = file(number, "", condition, drawn);
    let (text, told) = rewritten(&source);
    assert!(told[0].branch.is_ok(), "{told:?}");
    let text = text.expect("written");
    assert!(text.contains(condition) && text.contains("localId=\"3100\""), "{text}");
    assert_eq!(text.matches("localId=\"30\"").count(), 1, "no step takes its number");
    let again = iec::read("a.xml", &text).unwrap_or_else(|faults| panic!("{faults:?}\n{text}"));
    let Body::Chart(chart) = &again.pous[0].body else { panic!("a chart") };
    assert!(chart.step("A_on").is_some());
    // What cannot be read stays as it is, too, as long as nothing is added to it.
    let broken = "<condition><inline name=\"\"><ST><p>a ???</p></ST></inline></condition>";
    let (text, told) = rewritten(&file("", "", broken, ""));
    assert!(told[0].branch.is_ok() && text.expect("written").contains("a ???"));
    // The wait of DS asks for what ends its step.
    let delayed = file("", "", PLAIN, "")
        .replace("qualifier=\"S\"", "qualifier=\"DS\" duration=\"T#5s\"")
        .replace("b (* when it is there *)", "b ???");
    let (text, told) = rewritten(&delayed);
    let why = told[0].branch.clone().expect_err("left alone");
    assert!(
        why.contains("transition s1 -> s2 in line 6") && why.contains("cannot be read"),
        "{why}"
    );
    assert!(text.is_ok() && told[0].step == "s1" && told[0].line > 0);
}

#[test]
fn what_cannot_be_written_is_told_with_its_place() {
    let broken = "<condition><inline name=\"\"><ST><p>a ???</p></ST></inline></condition>";
    let project = iec::read("a.xml", &file("", "", broken, "")).expect("read");
    let why = xml::write::project(&project).expect_err("no form in text");
    assert!(
        why.starts_with("main: transition s0 -> s1 (line 4, localId 2): it cannot be read: "),
        "{why}"
    );
}

#[test]
fn an_action_that_is_never_stored_gets_no_step_that_nothing_leads_to() {
    // The way to its step asks for the step itself.
    let never = PLAIN.replace("<p>a</p>", "<p>s1.X</p>");
    let (text, told) = rewritten(&file("", "", &never, ""));
    assert_eq!(told[0].branch, Err("no step that stores it is ever active".to_owned()));
    assert!(!text.expect("written").contains("A_on"));
}
