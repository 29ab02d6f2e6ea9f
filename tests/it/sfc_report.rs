//! What is told of charts: pictures, text, JSON, and warnings.

use scanbound::base::facts::Facts;
use scanbound::front::iec::charts::{hang, refused};
use scanbound::iec::chart::Chart;
use scanbound::iec::chart::coactive::{BUDGET, Finding, Rule, analyse, analyse_by};
use scanbound::iec::chart::structure::structure;
use scanbound::iec::{self, Project, xml};
use scanbound::report::sfc::{Elsewhere, Study, json, svg, text};
use std::fs;
use std::path::Path;

/// Shows the studies of a project's charts to something.
fn studied<T>(project: &Project, rule: Rule, show: impl Fn(&[Study<'_>]) -> T) -> T {
    let charts = project.charts();
    let others = |name: &str| -> Vec<(String, &Chart)> {
        let beside = charts.iter().filter(|(other, ..)| other != name);
        beside.map(|(other, _, chart)| (other.clone(), *chart)).collect()
    };
    let study = |(name, pou, chart): &(String, &iec::Pou, &'_ Chart)| {
        (name.clone(), pou.file, others(name), structure(chart), analyse_by(chart, BUDGET, rule))
    };
    let parts: Vec<_> = charts.iter().map(study).collect();
    let studies: Vec<Study<'_>> = charts
        .iter()
        .zip(parts)
        .map(|((_, _, chart), (name, file, others, structure, analysis))| Study {
            name,
            file: &project.files[file],
            chart,
            structure,
            analysis,
            rule,
            elsewhere: Elsewhere::of(chart, &others),
        })
        .collect();
    show(&studies)
}

fn read(text: &str) -> Project {
    iec::read("a.st", text).unwrap_or_else(|faults| panic!("{faults:?}: {text}"))
}

/// A program of these steps and transitions: from, to, condition.
fn program(steps: &str, ways: &[(&str, &str, &str)]) -> Project {
    let mut text = "PROGRAM p VAR a : BOOL; b : BOOL; END_VAR\n".to_owned();
    text += steps;
    for (from, to, condition) in ways {
        text += &format!("\nTRANSITION FROM {from} TO {to} := {condition}; END_TRANSITION");
    }
    read(&(text + "\nEND_PROGRAM"))
}

const LONG: &str =
    "first_of_all AND second_of_all AND third_of_all AND fourth_of_all AND fifth_of_all";

/// Two branches, with a way from one into the other.
fn across() -> Project {
    program(
        "INITIAL_STEP s1: END_STEP STEP s2: lamp(S); END_STEP STEP s3: END_STEP
         STEP s4: valve(L, T#90s); END_STEP STEP s5: lamp(R); END_STEP",
        &[
            ("s1", "s2", LONG),
            ("s1", "s3", "NOT first_of_all"),
            ("s2", "s4", "a"),
            ("s3", "s5", "b"),
            ("s2", "s5", "c"),
            ("s4", "s1", "d"),
            ("s5", "s1", "e"),
        ],
    )
}

/// The value of an attribute.
fn attribute<'a>(line: &'a str, name: &str) -> Option<&'a str> {
    line.split_once(&format!(" {name}=\""))?.1.split('"').next()
}

/// Asserts that lines are straight and texts of one line do not stand on each other.
fn tidy(picture: &str) {
    let mut texts: Vec<(i32, i32, &str)> = Vec::new();
    for line in picture.lines() {
        if line.starts_with("<path d=") || line.starts_with("<path class=\"bar\"") {
            let by = attribute(line, "d").and_then(|path| path.split_once('l')).expect(line).1;
            let (dx, dy) = by.split_once(' ').expect(line);
            assert!(dx == "0" || dy == "0", "a slanted line: {line}");
        }
        let is_middle = line.contains("class=\"mid\"");
        if line.starts_with("<text") && !is_middle && !line.contains("transform") {
            let number = |name| attribute(line, name).and_then(|text| text.parse().ok());
            let shown = line.rsplit_once("</text>").expect(line).0.rsplit('>').next().expect(line);
            texts.push((number("y").expect(line), number("x").expect(line), shown));
        }
    }
    texts.sort_unstable();
    for pair in texts.windows(2) {
        let ((y, x, one), (below, right, other)) = (pair[0], pair[1]);
        let end = x + 6 * i32::try_from(one.chars().count()).expect("short");
        assert!(y != below || end <= right, "{one} and {other} at {y}");
    }
}

#[test]
fn pictures_are_straight_and_name_all_steps() {
    for file in ["line.st", "line.xml", "macros.xml", "figures/delayed-stored-explicit.xml"] {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("samples/sfc").join(file);
        let source = fs::read_to_string(path).expect(file);
        let project = iec::read(file, &source).expect(file);
        let picture = studied(&project, Rule::One, svg::render);
        tidy(&picture);
        for step in &project.charts()[0].2.steps {
            assert!(picture.contains(&format!(">{}</text>", step.name)), "{file}: {}", step.name);
        }
    }
}

#[test]
fn pictures_have_jumps_and_bars_of_stored_actions() {
    let picture = studied(&across(), Rule::One, svg::render);
    tidy(&picture);
    assert!(picture.contains("\u{2026}</text>"), "a long condition is cut");
    assert!(picture.contains(&format!("<title>{LONG}</title>")), "and stands in its title");
    assert!(picture.contains("<title>lamp: stored by s2 until s5</title>"), "{picture}");
    assert!(picture.contains(">s5</text>\n<rect") || picture.contains(">s5</text>"));
    // The way back, and the jump across.
    assert_eq!(picture.matches("class=\"head\"").count(), 2, "{picture}");
    // A parallel has two double bars, a selection single ones.
    let parallel = program(
        "INITIAL_STEP a: END_STEP STEP b: END_STEP STEP c: END_STEP",
        &[("a", "(b, c)", "x"), ("(b, c)", "a", "y")],
    );
    let picture = studied(&parallel, Rule::One, svg::render);
    let bars = picture.lines().filter(|line| {
        let by = attribute(line, "d").and_then(|path| path.split_once('l'));
        line.starts_with("<path d=") && by.is_some_and(|(_, by)| by.ends_with(" 0"))
    });
    assert_eq!(bars.count(), 4, "{picture}");
}

#[test]
fn text_keeps_to_80_columns_and_names_what_does_not_nest() {
    let told = studied(&across(), Rule::One, text::render);
    for line in told.lines() {
        assert!(line.chars().count() <= 80, "{line}");
    }
    assert!(told.contains("1 loop, 2 selections, 0 parallels"), "{told}");
    assert!(told.contains("  does not nest for\n    s2 -> s5  [c]\n  all ways\n"), "{told}");
    let ways = told.split("  all ways\n").nth(1).expect("ways");
    let order = ["s1 -> s2", "s2 -> s4", "s4 -> s1", "s3 -> s5", "s5 -> s1"];
    let places: Vec<_> = order.iter().map(|way| ways.find(way).expect(way)).collect();
    assert!(places.is_sorted(), "in the order of flow: {told}");
    // Pairs by action, a way once.
    assert!(told.contains("    lamp\n      stored by s2 until s5 (way 1): steps"), "{told}");
    assert_eq!(told.matches("\n    1: by ").count(), 1, "{told}");
}

#[test]
fn a_jump_back_is_a_loop_where_the_chart_does_not_nest() {
    let project = program(
        "INITIAL_STEP a: END_STEP STEP b: END_STEP STEP c: END_STEP STEP d: END_STEP",
        &[("a", "(b, c)", "x"), ("c", "d", "x"), ("(b, d)", "a", "x"), ("(b, c)", "a", "y")],
    );
    let told = studied(&project, Rule::One, text::render);
    assert!(told.contains("2 loops, 0 selections, 1 parallel;"), "{told}");
    assert!(told.contains("  does not nest for\n    b, c -> a  [y]\n"), "{told}");
}

#[test]
fn branches_of_a_selection_run_together_where_all_that_are_true_clear() {
    let steps = "INITIAL_STEP s0: END_STEP STEP s1: x(N); END_STEP STEP s2: y(N); END_STEP";
    let ways = [("s0", "s1", "a"), ("s0", "s2", "b"), ("s1", "s0", "a"), ("s2", "s0", "b")];
    let project = program(steps, &ways);
    let flat = |text: String| text.replace("\n    ", " ");
    let one = flat(studied(&project, Rule::One, text::render));
    assert!(one.contains("of competing transitions one clears"), "{one}");
    assert!(!one.contains("active together"), "{one}");
    let all = flat(studied(&project, Rule::All, text::render));
    assert!(all.contains("of competing transitions all clear that are true"), "{all}");
    // A step that is left and entered at once stays: all three may be active.
    assert!(all.contains(" x   in parallel (way 1): steps s0, s2; action y"), "{all}");
    let chart = project.charts()[0].2;
    let (one, all) = (analyse(chart, BUDGET), analyse_by(chart, BUDGET, Rule::All));
    assert!(one.are_apart(1, 2) && !all.are_apart(1, 2) && !all.are_apart(0, 1));
    // What cannot be followed may be together.
    let rough = analyse_by(chart, 2, Rule::All);
    assert!((0..3).all(|one| (0..3).all(|other| !rough.are_apart(one, other))));
    // Priorities say which one clears.
    let ranked = ["1", "2"].map(|rank| format!("TRANSITION (PRIORITY := {rank}) FROM s0 TO s"));
    let ranked = format!(
        "PROGRAM p {steps} {}1 := a; END_TRANSITION {}2 := b; END_TRANSITION
         TRANSITION FROM s1 TO s0 := a; END_TRANSITION TRANSITION FROM s2 TO s0 := b; END_TRANSITION END_PROGRAM",
        ranked[0], ranked[1]
    );
    let project = read(&ranked);
    assert!(analyse_by(project.charts()[0].2, BUDGET, Rule::All).are_apart(1, 2));
}

#[test]
fn what_another_chart_of_the_unit_resets_is_told() {
    let chart = |name: &str, block: &str| {
        format!(
            "ACTION {name}: INITIAL_STEP {name}0: END_STEP STEP {name}1: {block}; END_STEP
             TRANSITION FROM {name}0 TO {name}1 := a; END_TRANSITION
             TRANSITION FROM {name}1 TO {name}0 := NOT a; END_TRANSITION END_ACTION\n"
        )
    };
    let project = read(&format!(
        "FUNCTION_BLOCK valve VAR a : BOOL; v : BOOL; END_VAR a := a;\n{}{}END_FUNCTION_BLOCK",
        chart("go", "v(S)"),
        chart("back", "v(R)")
    ));
    let told = studied(&project, Rule::One, text::render).replace("\n      ", " ");
    assert!(
        told.contains("action v is stored here, by go1, and reset by back1 of valve.back"),
        "{told}"
    );
    assert!(
        told.contains("action v is reset here, by back1, and stored by go1 of valve.go"),
        "{told}"
    );
    assert!(!told.contains("not reset"), "{told}");
}

#[test]
fn why_a_transition_never_clears_is_told_and_p0_is_in_no_pair() {
    let project = program(
        "INITIAL_STEP s0: END_STEP STEP b: x(P0); END_STEP STEP c: y(N); END_STEP STEP d: END_STEP",
        &[("s0", "(b, c)", "a"), ("b", "d", "a"), ("c", "c", "s0.X"), ("(d, c)", "s0", "a")],
    );
    let told = studied(&project, Rule::One, text::render);
    let flat = told.replace("\n      ", " ");
    let why =
        "transition c -> c never clears: its condition requires s0.X while the steps before it";
    assert!(flat.contains(why), "{told}");
    assert!(!flat.contains("action x") && !flat.contains("    x\n"), "{told}");
    let found = analyse(project.charts()[0].2, BUDGET).findings;
    assert_eq!(found, [Finding::NeverTrue(2, vec![(0, true)])]);
}

#[test]
fn json_has_the_tree_and_fields_of_findings() {
    let project = program(
        "INITIAL_STEP s1: END_STEP STEP s2: END_STEP STEP s3: END_STEP STEP s4: END_STEP",
        &[("s1", "s2", "a"), ("s1", "s3", "b"), ("(s2, s3)", "s4", "a"), ("s4", "s1", "a")],
    );
    let written = studied(&project, Rule::One, |studies| {
        let mut out = Vec::new();
        json::write(studies, &mut out).expect("written");
        String::from_utf8(out).expect("text")
    });
    let report: serde_json::Value = serde_json::from_str(&written).expect("JSON");
    let published = scanbound::report::schema::SCHEMAS.iter().find(|one| one.name == "sfc");
    let schema = serde_json::from_str(&published.expect("a schema").text()).expect("JSON");
    let schema = jsonschema::validator_for(&schema).expect("a schema");
    assert!(schema.is_valid(&report), "{written}");
    let chart = &report["charts"][0];
    assert!(chart["structure"]["kind"].is_string(), "{written}");
    assert_eq!(chart["rule"], "one");
    let dead = chart["findings"].as_array().expect("findings").iter();
    let mut dead = dead.filter(|one| one["kind"] == "deadlock");
    let first = dead.next().expect("a deadlock");
    assert_eq!(first["steps"], serde_json::json!(["s2"]));
    assert_eq!(first["path"], serde_json::json!(["s1 -> s2"]));
    assert_eq!(first["line"], 2);
    // A chart that nests: its tree.
    let project = program("INITIAL_STEP s1: END_STEP", &[("s1", "s1", "a")]);
    let written = studied(&project, Rule::One, |studies| {
        let mut out = Vec::new();
        json::write(studies, &mut out).expect("written");
        serde_json::from_slice::<serde_json::Value>(&out).expect("JSON")
    });
    assert_eq!(
        written["charts"][0]["structure"],
        serde_json::json!({ "kind": "loop", "children": [
            { "kind": "step", "name": "s1" },
            { "kind": "transition", "name": "s1 -> s1" },
        ] })
    );
}

#[test]
fn what_an_audit_would_refuse_is_warned_of() {
    let warned = |project: &Project| -> Vec<String> {
        let found = refused(project, &Facts::default());
        assert!(found.iter().all(|one| one.line.is_some_and(|line| line > 0)));
        found.into_iter().map(|one| one.message).collect()
    };
    let fine = "FUNCTION_BLOCK f VAR a : BOOL; y : BOOL; END_VAR
        INITIAL_STEP s: y(N); END_STEP TRANSITION FROM s TO s := a; END_TRANSITION END_FUNCTION_BLOCK";
    assert_eq!(warned(&read(fine)), [""; 0], "without a program that has an instance");
    let unknown = fine.replace(":= a;", ":= zz;");
    assert_eq!(warned(&read(&unknown)), ["f, transition s -> s: there is no zz"]);
    let action = fine.replace("y(N)", "nix(N)");
    assert_eq!(warned(&read(&action)), ["f, step s: there is no nix"]);
    let broken = format!(
        "<project xmlns=\"http://www.plcopen.org/xml/tc6_0201\"><types><pous>\
         <pou name=\"p\" pouType=\"program\"><interface/><body><SFC>\
         <step localId=\"1\" name=\"s\" initialStep=\"true\"/>\
         <transition localId=\"2\"><connectionPointIn><connection refLocalId=\"1\"/></connectionPointIn>\
         <condition><inline><ST><p>{}</p></ST></inline></condition></transition>\
         <jumpStep localId=\"3\" targetName=\"s\"><connectionPointIn><connection refLocalId=\"2\"/>\
         </connectionPointIn></jumpStep></SFC></body></pou></pous></types></project>",
        "a AND"
    );
    let project = xml::file("a.xml", &broken).expect("read");
    let told = warned(&project);
    assert!(
        told.len() == 1 && told[0].starts_with("p, transition s -> s: a condition"),
        "{told:?}"
    );
}

#[test]
fn charts_that_are_not_safe_or_may_stop_are_warned_of() {
    let steps = "INITIAL_STEP s1: END_STEP STEP s2: END_STEP STEP s3: END_STEP STEP s4: END_STEP";
    let told = |ways: &[(&str, &str, &str)]| -> Vec<String> {
        hang(&program(steps, ways)).into_iter().map(|one| one.message).collect()
    };
    let stuck =
        told(&[("s1", "s2", "a"), ("s1", "s3", "b"), ("(s2, s3)", "s4", "a"), ("s4", "s1", "a")]);
    assert_eq!(stuck[0], "p: with s2 active, no transition can clear any more, by s1 -> s2");
    let twice = told(&[("s1", "(s2, s3)", "a"), ("s2", "s4", "a"), ("s3", "s4", "a")]);
    assert_eq!(
        twice,
        ["p: step s4 is entered while it is active, by s1 -> s2, s3; s2 -> s4; s3 -> s4"]
    );
    let fine = [("s1", "(s2, s3)", "a"), ("(s2, s3)", "s4", "a"), ("s4", "s1", "a")];
    assert_eq!(told(&fine), [""; 0]);
}
