//! Charts as users meet them: samples, their explicit forms, and files that are broken in every way.

use common::iec::xml as drawn;
use scanbound::iec::chart::coactive::{BUDGET, Basis, Finding, Other, analyse};
use scanbound::iec::chart::explicit::explicit;
use scanbound::iec::chart::structure::structure;
use scanbound::iec::{self, Body, Project, xml};
use std::fs;
use std::path::{Path, PathBuf};

fn samples() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("samples/sfc")
}

fn project(file: &str) -> Project {
    let text = fs::read_to_string(samples().join(file)).expect(file);
    iec::read(file, &text).expect(file)
}

/// What the project is as PLCopen XML when all its charts are explicit.
fn explicit_form(mut project: Project) -> String {
    for pou in &mut project.pous {
        if let Body::Chart(chart) = &mut pou.body {
            let (next, told) = explicit(chart, BUDGET);
            assert!(told.iter().all(|one| one.branch.is_ok()), "{told:?}");
            **chart = next;
        }
    }
    xml::write::project(&project).expect("XML")
}

#[test]
fn every_figure_lies_beside_its_explicit_form() {
    for name in ["stored", "figure-2", "figure-4", "delayed-stored"] {
        let form = explicit_form(project(&format!("figures/{name}.st")));
        let file = samples().join(format!("figures/{name}-explicit.xml"));
        if std::env::var("INSTA_UPDATE").is_ok_and(|value| value == "always") {
            fs::write(&file, &form).expect("written");
        }
        assert_eq!(fs::read_to_string(&file).expect("the sample"), form, "{name}");
        let read = iec::read("explicit.xml", &form).expect("read again");
        let charts = read.charts();
        let (_, _, chart) = &charts[0];
        let found = analyse(chart, BUDGET);
        assert!(found.findings.is_empty(), "{name}: {:?}", found.findings);
        // The action now runs beside the step between by an explicit parallel.
        let between = chart.step("S3").expect("a step");
        let pair = found
            .pairs
            .iter()
            .find(|pair| pair.action == "A" && pair.other == Other::Step(between));
        assert_eq!(
            pair.map(|pair| &pair.how),
            Some(&scanbound::iec::chart::coactive::How::Parallel),
            "{name}"
        );
    }
}

#[test]
fn the_line_is_the_same_in_text_and_in_xml() {
    let text = project("line.st");
    let file = samples().join("line.xml");
    let written = xml::write::project(&text).expect("XML");
    if std::env::var("INSTA_UPDATE").is_ok_and(|value| value == "always") {
        fs::write(&file, &written).expect("written");
    }
    assert_eq!(fs::read_to_string(&file).expect("the sample"), written);
    let again = iec::read("line.xml", &written).expect("read");
    let shown = |project: &Project| {
        let charts = project.charts();
        let found = analyse(charts[0].2, BUDGET);
        let mut pairs: Vec<String> = found
            .pairs
            .iter()
            .map(|pair| format!("{} {:?} {:?}", pair.action, pair.other, pair.how))
            .collect();
        pairs.sort();
        (found.basis, pairs)
    };
    assert_eq!(shown(&text), shown(&again));
    assert!(
        analyse(text.charts()[0].2, BUDGET)
            .findings
            .iter()
            .all(|one| !matches!(one, Finding::Deadlock(..)))
    );
}

const HEAD: &str = "<project xmlns=\"http://www.plcopen.org/xml/tc6_0201\"><types><pous>\
    <pou name=\"main\" pouType=\"program\"><interface/><body>";
const TAIL: &str = "</body></pou></pous></types></project>";

/// The messages about a body.
fn faults(body: &str) -> Vec<String> {
    let text = format!("{HEAD}{body}{TAIL}");
    let faults = xml::file("a.xml", &text).expect_err(body);
    faults.into_iter().map(|fault| fault.message).collect()
}

#[test]
fn bad_xml_is_refused_with_the_place() {
    let step = "<step localId=\"1\" name=\"s\" initialStep=\"true\"/>";
    let condition = "<condition><inline><ST><p>TRUE</p></ST></inline></condition>";
    for (body, told) in [
        ("<SFC><step name=\"s\"/></SFC>".to_owned(), "main: an element step has no localId"),
        (
            format!("<SFC>{step}<step localId=\"1\" name=\"t\"/></SFC>"),
            "main: two elements have the localId 1",
        ),
        (
            format!("<SFC>{step}<transition localId=\"2\"><connectionPointIn><connection refLocalId=\"9\"/></connectionPointIn>{condition}</transition></SFC>"),
            "main: transition with localId 2: a connection refers to localId 9, which does not exist",
        ),
        (
            format!(
                "<SFC>{step}<selectionDivergence localId=\"3\"><connectionPointIn><connection refLocalId=\"4\"/></connectionPointIn></selectionDivergence>\
                 <selectionDivergence localId=\"4\"><connectionPointIn><connection refLocalId=\"3\"/></connectionPointIn></selectionDivergence>\
                 <transition localId=\"2\"><connectionPointIn><connection refLocalId=\"3\"/></connectionPointIn>{condition}</transition></SFC>"
            ),
            "main: selectionDivergence with localId 3: the connections through it form a loop",
        ),
        (
            format!("<SFC>{step}<transition localId=\"2\"><connectionPointIn><connection refLocalId=\"1\"/></connectionPointIn></transition></SFC>"),
            "main: transition with localId 2: it has no condition",
        ),
        (
            format!("<SFC>{step}<actionBlock localId=\"5\"><connectionPointIn><connection refLocalId=\"1\"/></connectionPointIn><action qualifier=\"Q\"><reference name=\"a\"/></action></actionBlock></SFC>"),
            "main: step s: 'Q' is not an action qualifier",
        ),
        (
            "<LD><contact localId=\"1\"><connectionPointIn><connection refLocalId=\"2\"/></connectionPointIn><variable>a</variable></contact>\
             <contact localId=\"2\"><connectionPointIn><connection refLocalId=\"1\"/></connectionPointIn><variable>b</variable></contact>\
             <coil localId=\"3\"><connectionPointIn><connection refLocalId=\"1\"/></connectionPointIn><variable>c</variable></coil></LD>"
                .to_owned(),
            "main: contact with localId 1: the connections through it form a loop",
        ),
        (
            "<LD><coil localId=\"3\"><connectionPointIn><connection refLocalId=\"7\"/></connectionPointIn><variable>c</variable></coil></LD>"
                .to_owned(),
            "main: coil with localId 3: a connection refers to localId 7, which does not exist",
        ),
        ("<LD><coil localId=\"3\"/></LD>".to_owned(), "main: coil with localId 3: it names no variable"),
    ] {
        assert_eq!(faults(&body), [told], "{body}");
    }
}

#[test]
fn entities_are_not_read() {
    let bomb = format!(
        "<?xml version=\"1.0\"?><!DOCTYPE x [<!ENTITY a \"aaaaaaaaaa\"><!ENTITY b \"&a;&a;&a;&a;&a;&a;&a;&a;\">]>{HEAD}<ST><p>&b;</p></ST>{TAIL}"
    );
    let faults = xml::file("a.xml", &bomb).expect_err("refused");
    assert!(faults[0].message.contains("DTD"), "{}", faults[0].message);
}

#[test]
fn deep_and_wide_drawings_end() {
    // Ways that fork and join again and again: 2 to the power of 60 paths.
    let mut body = "<LD><leftPowerRail localId=\"0\"/>".to_owned();
    let point = |from: &[usize]| {
        let all: String =
            from.iter().map(|id| format!("<connection refLocalId=\"{id}\"/>")).collect();
        format!("<connectionPointIn>{all}</connectionPointIn>")
    };
    let mut last = vec![0];
    for level in 0..60 {
        let ids = [2 * level + 1, 2 * level + 2];
        for id in ids {
            body += &format!(
                "<contact localId=\"{id}\">{}<variable>a{id}</variable></contact>",
                point(&last)
            );
        }
        last = ids.to_vec();
    }
    body += &format!("<coil localId=\"999\">{}<variable>c</variable></coil></LD>", point(&last));
    let variables: String = (1..=120).map(|id| format!(" a{id}:BOOL")).collect();
    let text = drawn::project("", &format!("c:BOOL{variables}"), &body, "c");
    let loads = drawn::bound_of(&text, "LD").expect("read");
    assert!(loads < 200, "each fork is kept once: {loads}");
    // Brackets without an end in structured text.
    let text = format!("PROGRAM p x := {}1; END_PROGRAM", "(".repeat(100_000));
    assert!(iec::read("a.st", &text).is_err());
    let text = format!("PROGRAM p {} END_PROGRAM", "IF a THEN ".repeat(100_000));
    assert!(iec::read("a.st", &text).is_err());
}

#[test]
fn a_step_and_branches_that_jump_converge_before_a_transition() {
    let at = |kind: &str, id: u32, more: &str, from: &[u32], inner: &str| {
        let from: String = from
            .iter()
            .map(|id| {
                format!("<connectionPointIn><connection refLocalId=\"{id}\"/></connectionPointIn>")
            })
            .collect();
        format!("<{kind} localId=\"{id}\" {more}>{from}{inner}</{kind}>")
    };
    let clears = |id, from| {
        at("transition", id, "", &[from], "<condition><inline><ST>TRUE</ST></inline></condition>")
    };
    let read = |body: &[String]| {
        let text = format!(
            "<project xmlns=\"http://www.plcopen.org/xml/tc6_0201\"><types><dataTypes/><pous>\
             <pou name=\"main\" pouType=\"program\"><body><SFC>{}</SFC></body></pou></pous></types></project>",
            body.concat()
        );
        let project = iec::read("a.xml", &text).ok()?;
        let charts = project.charts();
        let all = charts.first()?.2.transitions.iter();
        Some(all.map(|one| (one.from.clone(), one.to.clone())).collect::<Vec<_>>())
    };
    let body = [
        at("step", 1, "name=\"s\" initialStep=\"true\"", &[], ""),
        at("selectionDivergence", 2, "", &[1], ""),
        clears(3, 2),
        at("step", 4, "name=\"t\"", &[3], ""),
        clears(5, 2),
        at("jumpStep", 6, "targetName=\"s\"", &[5], ""),
        at("selectionConvergence", 7, "", &[4, 6], ""),
        clears(8, 7),
        at("jumpStep", 9, "targetName=\"s\"", &[8], ""),
    ];
    let ways = read(&body).expect("a chart");
    assert_eq!(ways.len(), 3);
    for way in [(vec![0], vec![1]), (vec![0], vec![0]), (vec![1], vec![0])] {
        assert!(ways.contains(&way), "{way:?} of {ways:?}");
    }
    // A join does not wait for a branch that jumps, and needs another one.
    let join = |ends: &[u32]| {
        let body = [
            at("step", 1, "name=\"s\" initialStep=\"true\"", &[], ""),
            clears(2, 1),
            at("simultaneousDivergence", 3, "", &[2], ""),
            at("step", 4, "name=\"t\"", &[3], ""),
            at("step", 5, "name=\"u\"", &[3], ""),
            clears(6, 5),
            at("jumpStep", 7, "targetName=\"u\"", &[6], ""),
            at("simultaneousConvergence", 8, "", ends, ""),
            clears(9, 8),
            at("jumpStep", 10, "targetName=\"s\"", &[9], ""),
        ];
        read(&body)
    };
    let ways = join(&[4, 7]).expect("a chart");
    assert!(ways.contains(&(vec![1], vec![0])) && ways.contains(&(vec![2], vec![2])), "{ways:?}");
    assert_eq!(join(&[7]), None);
}

/// A chart in text, with one unit around it.
fn of_text(text: &str) -> Project {
    iec::read("a.st", &format!("PROGRAM main {text} END_PROGRAM")).expect("a program")
}

#[test]
fn a_loop_of_thousands_of_steps_is_told_like_a_short_one() {
    let steps = 5_000;
    let mut text = "INITIAL_STEP s0: m(S); END_STEP ".to_owned();
    for at in 1..steps {
        let block = if at == steps / 2 { "m(R);" } else { "" };
        text += &format!("STEP s{at}: {block} END_STEP ");
    }
    for at in 0..steps {
        let next = (at + 1) % steps;
        text += &format!("TRANSITION FROM s{at} TO s{next} := TRUE; END_TRANSITION ");
        if at % 10 == 4 && next != 0 {
            text += &format!("TRANSITION FROM s{at} TO s{next} := FALSE; END_TRANSITION ");
        }
    }
    let project = of_text(&text);
    let chart = project.charts()[0].2;
    assert!(format!("{:?}", structure(chart)).contains("Loop"));
    let found = analyse(chart, BUDGET);
    assert_eq!(found.basis, Basis::Markings(steps));
    assert!(found.findings.is_empty(), "{:?}", found.findings);
    assert_eq!(found.pairs.len(), steps / 2 - 1, "stored up to the step that resets it");
}

#[test]
fn many_stored_actions_of_a_large_chart_are_each_told_of() {
    // More markings than are looked at, and as many actions as steps in the branches.
    let (branches, steps) = (20, 8);
    let mut text = "INITIAL_STEP a: END_STEP STEP z: END_STEP ".to_owned();
    let mut all = Vec::new();
    for branch in 0..branches {
        for at in 0..steps {
            let reset = (at + 1) % steps;
            text +=
                &format!("STEP b{branch}_{at}: x{branch}_{at}(S); x{branch}_{reset}(R); END_STEP ");
            if at + 1 < steps {
                text += &format!(
                    "TRANSITION FROM b{branch}_{at} TO b{branch}_{} := TRUE; END_TRANSITION ",
                    at + 1
                );
            }
        }
        all.push(branch);
    }
    let ends = |at: usize| {
        let names: Vec<String> = all.iter().map(|branch| format!("b{branch}_{at}")).collect();
        names.join(", ")
    };
    let (first, last) = (ends(0), ends(steps - 1));
    text += &format!(
        "TRANSITION FROM a TO ({first}) := TRUE; END_TRANSITION TRANSITION FROM ({last}) TO z := TRUE; END_TRANSITION TRANSITION FROM z TO a := TRUE; END_TRANSITION"
    );
    let project = of_text(&text);
    let chart = project.charts()[0].2;
    let (_, told) = explicit(chart, BUDGET);
    assert_eq!(told.len(), branches * steps);
    assert!(
        told.iter().all(|one| one.branch
            == Err("the chart has too many markings to look at all of them".to_owned())),
        "{told:?}"
    );
}
