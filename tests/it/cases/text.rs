//! Text files: comments, pragmas, encodings, forms of declarations, and what messages say.

use super::{audit, lower_ns, scanbound, upper_ns};
use crate::command::binary;
use std::path::PathBuf;

/// A directory with these files, for the inputs of one test.
fn directory(name: &str, files: &[(&str, &[u8])]) -> PathBuf {
    let path = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("text").join(name);
    let _ = std::fs::remove_dir_all(&path);
    std::fs::create_dir_all(&path).expect("a directory");
    for (file, content) in files {
        let file = path.join(file);
        std::fs::create_dir_all(file.parent().expect("a parent")).expect("a directory");
        std::fs::write(file, content).expect("a file");
    }
    path
}

/// A run on these files in a directory of their own.
fn run(name: &str, files: &[(&str, &[u8])], arguments: &str) -> super::Run {
    let path = directory(name, files);
    scanbound(path.to_str().expect("a path"), arguments)
}

/// The bound of one program in nanoseconds; panics where it is refused.
fn bound(name: &str, text: &str, options: &str) -> u64 {
    let path = directory(name, &[("p.st", text.as_bytes())]);
    upper_ns(&audit(path.to_str().expect("a path"), &format!("p.st {options}")))
}

/// What one program is refused with.
fn refused(name: &str, text: &str, options: &str) -> String {
    let run = run(name, &[("p.st", text.as_bytes())], &format!("audit p.st {options}"));
    assert_eq!(run.code, Some(2), "{text}\n{}{}", run.stdout, run.stderr);
    run.stderr
}

fn program(body: &str) -> String {
    format!("PROGRAM P\nVAR a, b : INT; x : BOOL; END_VAR\n{body}\nEND_PROGRAM\n")
}

#[test]
fn code_in_pragmas_is_refused_unless_it_is_stated() {
    for file in ["c-pragma.st", "c-pragma-in-if.st", "c-pragma-only.st"] {
        let found = scanbound("c-pragma", &format!("check {file} --limit 100us"));
        assert_eq!(found.code, Some(2), "{file}: {}{}", found.stdout, found.stderr);
        assert!(found.stderr.contains("error[pragma]") && found.stderr.contains("[calls]"));
    }
    for body in [
        "{ f(); } a := 1;",
        "IF x THEN {{ f(); }} END_IF;",
        "a := 1; { #include <x.h> }",
        "FOR a := 1 TO 2 DO { f(); } END_FOR;",
        "CASE a OF 1: {f();} ELSE {g();} END_CASE;",
        "{external} a := 1;",
        "{disable code generation} a := 1; {enable code generation}",
        "{CALL(a)}",
    ] {
        let told = refused("code", &program(body), "");
        assert!(told.contains("error[pragma]"), "{body}: {told}");
    }
    // Where no statement stands, and in lists.
    for text in [
        "PROGRAM P\nVAR {c();} a : INT; END_VAR\na := 1;\nEND_PROGRAM\n",
        "{c();}\nPROGRAM P\nVAR a : INT; END_VAR\na := 1;\nEND_PROGRAM\n",
        "PROGRAM P\nVAR a : INT; END_VAR\na := {c()} 1;\nEND_PROGRAM\n",
        "PROGRAM P\nVAR a : INT; END_VAR\nLD a\n{c();}\nST a\nEND_PROGRAM\n",
        "PROGRAM P\nVAR a : INT; END_VAR\n{c();}\nLD a\nST a\nEND_PROGRAM\n",
        "PROGRAM P\nVAR a : INT; END_VAR\nINITIAL_STEP s: B(N); END_STEP\nTRANSITION FROM s TO s := TRUE; END_TRANSITION\nACTION B: {c();} END_ACTION\nEND_PROGRAM\n",
    ] {
        let told = refused("code", text, "");
        assert!(told.contains("pragma") || told.contains("no result"), "{text}: {told}");
    }
}

#[test]
fn stated_code_takes_its_time_and_writes_its_variables() {
    let body = "a := 0;\n{{ f(); }}\nIF a = 3 THEN b := b + 1; END_IF;";
    let stated = |writes: &str| {
        let facts = format!("[calls]\n\"p.st:4\" = {{ time = \"40us\", writes = [{writes}] }}\n");
        let files = [("p.st", program(body).into_bytes()), ("f.toml", facts.into_bytes())];
        let files: Vec<(&str, &[u8])> = files.iter().map(|(n, c)| (*n, c.as_slice())).collect();
        let path = directory("stated", &files);
        audit(path.to_str().expect("a path"), "p.st --facts f.toml")
    };
    let plain = bound("plain", &program("a := 0;\n\nIF a = 3 THEN b := b + 1; END_IF;"), "");
    assert_eq!(upper_ns(&stated("")), plain + 40_000);
    // `b := b + 1` (350 ns) runs where the pragma may have written 3; no scan is known in which it has.
    let written = stated("\"a\"");
    assert_eq!(upper_ns(&written), plain + 40_000 + 350);
    assert_eq!(lower_ns(&written), plain + 40_000);
    assert!(written["facts"].to_string().contains("p.st:4"));
    // What is not all stated is refused.
    for facts in ["{ time = \"40us\" }", "{ time = \"40us\", writes = [\"nothing\"] }"] {
        let facts = format!("[calls]\n\"p.st:4\" = {facts}\n");
        let text = program(body);
        let files: [(&str, &[u8]); 2] = [("p.st", text.as_bytes()), ("f.toml", facts.as_bytes())];
        let found = run("stated-not", &files, "audit p.st --facts f.toml");
        assert_eq!(found.code, Some(2), "{facts}: {}", found.stdout);
    }
}

#[test]
fn pragmas_that_change_what_runs_are_refused_and_others_left_out() {
    let found = scanbound("attack", "audit pragma-if.st --table zero.csv --facts calls.toml");
    assert_eq!(found.code, Some(2), "{}", found.stdout);
    assert!(found.stderr.contains("selects what is compiled"), "{}", found.stderr);
    for text in [
        "{IF hasattribute (pou: P, 'x')} a := 1; {ELSE} a := 2; {END_IF}",
        "{if defined (X)} a := 1; {elsif defined (Y)} a := 2; {end_if}",
        "a := 1; {END_IF}",
    ] {
        assert!(refused("if", &program(text), "").contains("selects what is compiled"), "{text}");
    }
    for attribute in ["no_init", "initialize_on_call", "TcRetain", "is_connected", "anything"] {
        let text = format!("{{attribute '{attribute}' := '1'}}\n{}", program("a := 1;"));
        assert!(
            refused("attribute", &text, "").contains("values of variables is not known"),
            "{attribute}"
        );
    }
    let plain = bound("harmless", &program("a := 1;"), "");
    for text in [
        program("{region 'it'} a := 1; {endregion} {warning 'a; b'}"),
        format!("{{attribute 'hide'}}{{define X}}\n{}", program("a := 1;")),
        program("a := 1;").replace("x :", "{attribute 'symbol' := 'readwrite'} x :"),
        program("a := 1; {attribute 'warning disable C0195'}"),
    ] {
        assert_eq!(bound("harmless", &text, ""), plain, "{text}");
    }
}

#[test]
fn comments_that_read_differently_need_a_choice() {
    for file in ["flat-comments.st", "flat-refused.st"] {
        let found = scanbound("flat-comments", &format!("audit {file}"));
        assert_eq!(found.code, Some(2), "{file}: {}", found.stdout);
        let told = &found.stderr;
        assert!(told.contains("--comments flat") && told.contains("--comments nested"), "{told}");
    }
    let ns = |arguments: &str| upper_ns(&audit("flat-comments", arguments));
    let as_it_is_run = ns("as-it-is-run.st");
    assert_eq!(as_it_is_run, 53_050);
    assert_eq!(ns("flat-comments.st --comments flat"), as_it_is_run);
    assert_eq!(ns("flat-comments.st --comments nested"), 52_000);
    assert_eq!(ns("flat-refused.st --comments flat"), 52_350);
    let nested = scanbound("flat-comments", "audit flat-refused.st --comments nested");
    assert_eq!(nested.code, Some(2), "{}", nested.stdout);
    // The same with other marks, in lists, within pragmas and in drawings' text.
    for (text, nested) in
        [("/* /* */ a := 1; /* */ */", ""), ("a := 1; (* (* *) a := 1; (* *) *)", "a := 1;")]
    {
        let text = program(text);
        assert!(refused("nesting", &text, "").contains("error[comments]"), "{text}");
        assert_eq!(bound("nesting", &text, "--comments nested"), bound("n", &program(nested), ""));
        let told = refused("nesting", &text, "--comments flat");
        assert!(told.contains("error[syntax]"), "the end that is left over: {told}");
    }
    let told = refused("nesting", &program("{ if (x) { f(); } } a := 1;"), "");
    assert!(told.contains("error[comments]"), "{told}");
}

#[test]
fn forms_of_other_tools_are_read() {
    assert_eq!(upper_ns(&audit("time-blank", "time-blank.st")), 54_300);
    let action = audit("action-behind", "action-behind.st");
    let inside = "PROGRAM P\nVAR n : INT; END_VAR\nup();\nACTION up:\nn := n + 1;\nEND_ACTION\nEND_PROGRAM\n";
    assert_eq!(upper_ns(&action), bound("inside", inside, ""));
    let block = "PROGRAM P\nVAR n : INT; END_VAR\nup();\nEND_PROGRAM\nACTIONS P\nACTION up\nn := n + 1;\nEND_ACTION\nEND_ACTIONS\n";
    assert_eq!(upper_ns(&action), bound("actions", block, ""));
    let other = block.replace("ACTIONS P", "ACTIONS Q");
    assert!(refused("actions", &other, "").contains("actions of Q"));
}

#[test]
fn lists_of_global_variables_are_named_after_their_files() {
    let named = upper_ns(&audit("named-globals", "GVL.st P.st"));
    assert_eq!(named, 52_450);
    assert_eq!(named, upper_ns(&audit("named-globals", "P.st GVL.st")));
    let list = "VAR_GLOBAL Level : INT; END_VAR\n";
    // A variable of the unit's hides the list's: what is meant then is not found.
    let text = "PROGRAM P VAR Level : BOOL; x : INT; END_VAR x := GVL.Level; END_PROGRAM\n";
    let found = run("hidden", &[("GVL.st", list.as_bytes()), ("p.st", text.as_bytes())], "audit .");
    assert_eq!(found.code, Some(2), "{}", found.stdout);
    // Of what the list does not hold, nothing is known.
    let text = "PROGRAM P VAR x : INT; END_VAR x := GVL.Other; END_PROGRAM\n";
    let found = run("other", &[("GVL.st", list.as_bytes()), ("p.st", text.as_bytes())], "audit .");
    assert_eq!(found.code, Some(2), "{}", found.stdout);
    // A value that the list's variable always holds.
    let list = "VAR_GLOBAL CONSTANT N : INT := 2; END_VAR\nVAR_GLOBAL k : INT; END_VAR\n";
    let text = "PROGRAM P VAR x : ARRAY[0..GVL.N] OF INT; END_VAR FOR gvl.k := 0 TO GVL.N DO x[Gvl.K] := 1; END_FOR; END_PROGRAM\n";
    let found = run("bounds", &[("GVL.st", list.as_bytes()), ("p.st", text.as_bytes())], "audit .");
    assert_eq!(found.code, Some(0), "{}", found.stderr);
}

#[test]
fn western_encodings_are_read() {
    for file in ["encoding-western.st", "encoding-cyrillic.st"] {
        let found = scanbound("encoding-western", &format!("audit {file} --format json"));
        assert_eq!(upper_ns(&found.json()), 52_350, "{file}");
        assert!(found.json().to_string().contains("not UTF-8"), "{file}");
    }
    for (file, name) in [("cyrillic", "windows-1251"), ("western", "cp1252")] {
        let stated = audit("encoding-western", &format!("encoding-{file}.st --encoding {name}"));
        assert_eq!((upper_ns(&stated), lower_ns(&stated)), (52_350, 52_350));
        assert!(!stated.to_string().contains("not UTF-8"));
    }
    let found = scanbound("encoding-western", "audit encoding-western.st --encoding klingon");
    assert_eq!(found.code, Some(2));
    assert!(found.stderr.contains("windows-1252"), "{}", found.stderr);
    // A name that is another one in another encoding, and a bracket that is a half of a character in one.
    for text in [
        &b"PROGRAM P VAR temp\xE9rature : INT; END_VAR temp\xE9rature := 1; END_PROGRAM\n"[..],
        &b"PROGRAM P VAR a : INT; END_VAR {text 'caf\xE9} a := 1; {text 'x'} END_PROGRAM\n"[..],
    ] {
        let found = run("ambiguous", &[("p.st", text)], "audit p.st");
        assert_eq!(found.code, Some(2), "{}", found.stdout);
        assert!(found.stderr.contains("--encoding"), "{}", found.stderr);
    }
    let named = b"PROGRAM P VAR temp\xE9rature : INT; END_VAR temp\xE9rature := 1; END_PROGRAM\n";
    let found = run("stated", &[("p.st", named)], "audit p.st --encoding windows-1252");
    assert_eq!(found.code, Some(0), "{}", found.stderr);
}

#[test]
fn long_and_deep_texts_are_refused_in_short() {
    let long = refused("long", &program(&format!("a := {};", "7".repeat(1_000_000))), "");
    assert!(long.len() < 2_000, "{}", long.len());
    let name = "n".repeat(1_000_000);
    let long = refused("long-name", &program(&format!("{name} := 1;")), "");
    assert!(long.len() < 5_000, "{}", long.len());
    let nested = |open: &str, inner: &str, close: &str| {
        program(&format!("{}{inner}{}", open.repeat(100_000), close.repeat(100_000)))
    };
    for text in [
        nested("(*", "", ""),
        nested("(*", "", "*)"),
        nested("{", "", "}"),
        nested("{", "", ""),
        nested("/*", "", "*/"),
        program(&format!("a := {}1{};", "(".repeat(100_000), ")".repeat(100_000))),
        program(&format!("x := {}x;", "NOT ".repeat(100_000))),
        program(&format!("a := {}a;", "- ".repeat(100_000))),
        nested("IF x THEN ", "a := 1;", " END_IF;"),
        nested("FOR a := 1 TO 2 DO ", "b := 1;", " END_FOR;"),
        program(&format!("a := b{};", "[b".repeat(100_000))),
        program(&format!("a := {}1{};", "ABS(".repeat(100_000), ")".repeat(100_000))),
        "PROGRAM P VAR a : ".to_owned()
            + &"ARRAY[0..1] OF ".repeat(100_000)
            + "INT; END_VAR END_PROGRAM",
        "PROGRAM P VAR a : ".to_owned() + &"STRUCT b : ".repeat(100_000),
        "PROGRAM P VAR a : BOOL; END_VAR\nLD a\n".to_owned() + &"AND(\nLD a\n".repeat(100_000),
        program(&format!("a := 1{};", " + 1".repeat(100_000))),
        program(&format!("a := b{};", ".b".repeat(100_000))),
        program(&format!("a := b{};", "^".repeat(100_000))),
    ] {
        let told = refused("deep", &text, "");
        assert!(told.len() < 20_000, "{} of {}", told.len(), &text[..80]);
    }
}

#[test]
fn captures_may_have_time_stamps() {
    let found =
        scanbound("capture-iso", "compare P.st capture-iso.csv --signal SCAN --format json");
    assert_eq!(found.code, Some(1), "{}{}", found.stdout, found.stderr);
    assert_eq!(found.json()["scans"]["max_ps"], 1_000_000_000, "{}", found.stdout);
    let program = program("a := 1;");
    let of = |head: &str, stamps: [&str; 4]| {
        let rows: Vec<String> = (0..4).map(|at| format!("{},{}", stamps[at], at % 2)).collect();
        let capture = format!("{head},SCAN\n{}\n", rows.join("\n"));
        let files: [(&str, &[u8]); 2] =
            [("p.st", program.as_bytes()), ("c.csv", capture.as_bytes())];
        run("capture", &files, "compare p.st c.csv --signal SCAN --format json")
    };
    let plain = ["12:00:00.000", "12:00:00.001", "12:00:00.0015", "12:00:00.003"];
    for head in ["Time [s]", "Time", "timestamp", "Date"] {
        let found = of(head, plain);
        assert_eq!(found.json()["scans"]["max_ps"], 2_000_000_000_u64, "{}", found.stderr);
    }
    for wrong in [
        ["12:00:00.000", "2026-01-01 12:00:00.001", "12:00:00.0015", "12:00:00.003"],
        ["12:00:00.000", "12:00:00.001Z", "12:00:00.0015", "12:00:00.003"],
        ["12:00:00.000", "0.001", "12:00:00.0015", "12:00:00.003"],
        ["12:00:00.000", "11:00:00.001", "12:00:00.0015", "12:00:00.003"],
    ] {
        let found = of("Time", wrong);
        assert_eq!(found.code, Some(2), "{}", found.stdout);
        assert!(found.stderr.contains("error[capture]"), "{}", found.stderr);
    }
}

#[cfg(unix)]
#[test]
fn only_files_are_read_and_none_without_an_end() {
    let text = program("a := 1;");
    let path = directory("pipe", &[("p.st", text.as_bytes())]);
    let made = std::process::Command::new("mkfifo").arg(path.join("pipe.st")).status();
    assert!(made.expect("mkfifo").success());
    let at = path.to_str().expect("a path");
    for arguments in [
        "audit pipe.st",
        "audit p.st pipe.st",
        "audit p.st --facts pipe.st",
        "audit p.st --facts /dev/zero",
        "audit p.st --table /dev/zero",
        "audit /dev/zero",
        "compare p.st pipe.st",
        "tables --check pipe.st",
        "snet check pipe.st",
        "sfc pipe.st",
    ] {
        let found = scanbound(at, arguments);
        assert_eq!(found.code, Some(2), "{arguments}: {}", found.stdout);
        assert!(found.stderr.contains("a pipe or a device"), "{arguments}: {}", found.stderr);
    }
    // In a directory it is left out.
    let found = scanbound(at, "audit .");
    assert_eq!(found.code, Some(0), "{}", found.stderr);
}

#[test]
fn loops_go_round_as_often_as_stated() {
    let at = "loop-count-stated";
    for (file, line, ns) in
        [("loop-count-stated.st", 4, 69_350), ("half.st", 4, 73_450), ("queue.st", 3, 77_950)]
    {
        let refused = scanbound(at, &format!("audit {file}"));
        assert_eq!(refused.code, Some(2), "{}", refused.stdout);
        let fact = format!("[counts] \"{file}:{line}\" = [0, 10]");
        assert!(refused.stderr.contains(&fact), "{}", refused.stderr);
        let offered = scanbound(at, &format!("facts {file}"));
        assert!(offered.stdout.contains(&format!("# \"{file}:{line}\" = ")), "{}", offered.stdout);
        let text = std::fs::read_to_string(super::case(at).join(file)).expect(file);
        let stated = |fact: &str| {
            let facts = format!("[counts]\n\"{file}:{line}\" = {fact}\n");
            run(
                "turns",
                &[(file, text.as_bytes()), ("f.toml", facts.as_bytes())],
                &format!("audit {file} --facts f.toml --format json"),
            )
        };
        let ten = stated("[0, 10]").json();
        assert_eq!(upper_ns(&ten), ns, "{file}");
        assert!(lower_ns(&ten) <= ns && lower_ns(&ten) > ns / 2, "{file}");
        // Ten turns of the queue read beyond its array: no scan is told that does.
        if file == "queue.st" {
            assert_eq!(lower_ns(&ten), 75_400);
        }
        // Fewer turns take less, and no scan is told that would go on.
        let three = stated("[0, 3]").json();
        assert!(upper_ns(&three) < ns && lower_ns(&three) <= upper_ns(&three));
        assert_eq!(stated("[2, 10]").code, Some(2));
        assert_eq!(stated("[0, 100000]").code, Some(2));
    }
    let given = audit(at, "loop-count-stated.st --facts loop-count-stated.toml");
    assert_eq!(upper_ns(&given), 69_350);
    // One turn: test, addition, EXIT.
    assert_eq!(upper_ns(&audit(at, "while_exit.st")), 52_800);
    let page = scanbound(at, "explain loop-count");
    assert!(page.stdout.contains("[counts]") && page.stdout.contains("WHILE"), "{}", page.stdout);
    // The most turns are one fewer than the halvings that fit: with x at most 7 there are 3.
    let half = "PROGRAM P\nVAR n : INT; x : INT; END_VAR\nREPEAT x := x / 2; n := n + 1; UNTIL x = 0 END_REPEAT\nEND_PROGRAM\n";
    let facts = "[counts]\n\"p.st:3\" = [1, 4]\n";
    let files: [(&str, &[u8]); 2] = [("p.st", half.as_bytes()), ("f.toml", facts.as_bytes())];
    let found = run("repeat", &files, "audit p.st --facts f.toml --format json");
    let least = bound("repeat-1", &program("x := TRUE;"), "");
    assert!(upper_ns(&found.json()) > least, "{}", found.stderr);
    assert!(lower_ns(&found.json()) <= upper_ns(&found.json()));
    // A turn that CONTINUE may end is followed by another one.
    for body in [
        "WHILE a = 3 DO IF x THEN CONTINUE; END_IF; EXIT; END_WHILE",
        "WHILE a = 3 DO IF x THEN EXIT; END_IF; END_WHILE",
    ] {
        assert!(refused("again", &program(body), "").contains("[counts]"), "{body}");
    }
    for body in ["WHILE a = 3 DO b := 1; RETURN; END_WHILE", "REPEAT EXIT; UNTIL x END_REPEAT"] {
        bound("once", &program(body), "");
    }
}

#[test]
fn messages_say_what_is_missing_and_what_to_do() {
    let told = |file: &str, parts: &[&str]| {
        let found = scanbound("wrong-hints", &format!("audit {file}"));
        let text = found.stderr.split_whitespace().collect::<Vec<_>>().join(" ");
        assert_eq!(found.code, Some(2), "{file}: {text}");
        for part in parts {
            assert!(text.contains(part), "{file}: {part}: {text}");
        }
        for wrong in ["not supported yet", "nothing else", "expected a program's CSV"] {
            assert!(!text.contains(wrong), "{file}: {text}");
        }
    };
    told("body.st", &["does not begin with PROGRAM", "PROGRAM name", "END_PROGRAM"]);
    told("MAIN.TcPOU", &["TwinCAT", "PLCopen XML"]);
    told("net.pnml", &["Petri net", "scanbound snet check"]);
    told("external.st", &["dist is declared as VAR_EXTERNAL", "VAR_GLOBAL"]);
    let counted = scanbound("wrong-hints", "audit count-name.st");
    assert!(counted.stdout.contains("Main.lp.k"), "{}", counted.stdout);
    assert!(!counted.stdout.contains("word 5"), "{}", counted.stdout);
    let offered = scanbound("wrong-hints", "facts count-name.st");
    assert!(offered.stdout.contains("Main.lp.k"), "{}", offered.stdout);
    // A directory within one is read where it is named, and not left out then.
    for command in ["audit", "doctor"] {
        let found = scanbound("wrong-hints", &format!("{command} dirs dirs/sub"));
        assert_eq!(found.code, Some(0), "{}", found.stderr);
        assert!(!format!("{}{}", found.stdout, found.stderr).contains("left out"), "{command}");
    }
    let found = scanbound("wrong-hints", "audit dirs");
    assert!(found.stderr.contains("fb1.st in it may be a program"), "{}", found.stderr);
}

#[test]
fn all_unknown_types_are_listed_at_once() {
    let text = "PROGRAM P\nVAR a : Foo; b : Bar; c : ARRAY[0..1] OF Baz; q : Q; END_VAR\nq();\nEND_PROGRAM\n\
        FUNCTION_BLOCK Q\nVAR z : Zed; y : foo; END_VAR\nz();\nEND_FUNCTION_BLOCK\n\
        FUNCTION_BLOCK U\nVAR z : Unused; END_VAR\nz();\nEND_FUNCTION_BLOCK\n";
    for command in ["audit", "doctor"] {
        let found = run("types", &[("p.st", text.as_bytes())], &format!("{command} p.st"));
        let told = format!("{}{}", found.stdout, found.stderr);
        for name in ["Foo", "Bar", "Baz", "Zed"] {
            let part = format!("the type {name} is not known");
            assert_eq!(told.matches(&part).count(), 1, "{command}: {name}: {told}");
        }
        assert!(!told.contains("Unused"), "{told}");
    }
}

#[test]
fn the_same_program_twice_is_told() {
    let list: &[u8] = b"LD X0\nOUT Y0\nEND\n";
    let files = [("a.il", list), ("b.il", list), ("c.il", b"LD X1\nOUT Y1\nEND\n")];
    for arguments in ["audit a.il b.il c.il --cpu Q26UDV", "doctor . --cpu Q26UDV"] {
        let found = run("twice", &files, arguments);
        let told = format!("{}{}", found.stdout, found.stderr);
        assert!(told.contains("has the same content as") && found.code == Some(0), "{told}");
    }
    let page = run("twice", &files, "explain same-content");
    assert!(page.stdout.contains("--ignore"), "{}", page.stdout);
}

#[test]
fn a_comment_that_a_lone_carriage_return_may_end_is_refused() {
    let directory = tempfile::tempdir().expect("a directory");
    let file = directory.path().join("p.st");
    let code = |text: &str| {
        std::fs::write(&file, text).expect("written");
        let output = binary()
            .args(["check", "--limit", "1s"])
            .arg(&file)
            .output()
            .expect("the command runs");
        (output.status.code(), String::from_utf8_lossy(&output.stderr).into_owned())
    };
    let body = |end: &str| {
        format!("PROGRAM p\nVAR n : INT; END_VAR\nn := 1; // x{end}n := 2;\nEND_PROGRAM\n")
    };
    let (lone, told) = code(&body("\r"));
    assert_eq!(lone, Some(2), "{told}");
    assert!(told.contains("error[comments]"), "{told}");
    for end in ["\n", "\r\n"] {
        assert_eq!(code(&body(end)).0, Some(0), "{end:?}");
    }
}
