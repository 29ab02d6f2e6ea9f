//! `snet simulate` in batch and `snet draw`, as their users start them.

use crate::command::binary;
use std::path::Path;
use std::process::Output;

const NET: &str = "net 充填\nouter GO\nouter STOP\nbox A marked\ntimer W 0.5s\ncounter C 2\nbox D\n\
                   transition T : A -> W if GO\ntransition U : W -> C A\ntransition V : C -> D if not STOP\n\
                   stop H : W *-> if STOP\n";

fn snet(directory: &Path, arguments: &[&str]) -> (Option<i32>, String, String) {
    std::fs::write(directory.join("a.snet"), NET).expect("written");
    let Output { status, stdout, stderr } =
        binary().arg("snet").args(arguments).current_dir(directory).output().expect("it starts");
    let text = |bytes: Vec<u8>| String::from_utf8_lossy(&bytes).into_owned();
    (status.code(), text(stdout), text(stderr))
}

#[test]
fn a_stimulus_is_followed_to_the_millisecond_and_traced() {
    let directory = tempfile::tempdir().expect("a directory");
    let at = directory.path();
    std::fs::write(at.join("s.csv"), "time_ms,GO,STOP\n100,1,\n1300,,1\n1700,0,\n")
        .expect("written");
    let base = ["simulate", "a.snet", "--for", "5s", "--stimulus", "s.csv", "--vcd", "t.vcd"];
    let (code, stdout, stderr) = snet(at, &base);
    // At 100 ms T, at 610 ms the timer and U, at 620 T, at 1130 U, which fills C; V at once, T. STOP takes W's mark at
    // 1300.
    let rows: Vec<&str> = stdout.lines().collect();
    assert_eq!(rows[0], "time_ms,fired,A,W,W.P,C,C.count,D,GO,STOP");
    assert_eq!(rows[1], "0,,1,0,0,0,0,0,0,0");
    assert_eq!(rows[2], "100,T,0,1,0,0,0,0,1,0");
    assert_eq!(rows[3], "610,U,1,0,0,0,1,0,1,0");
    assert_eq!(rows[4], "620,T,0,1,0,0,1,0,1,0");
    assert_eq!(rows[5], "1130,U,1,0,0,1,2,0,1,0");
    assert_eq!(rows[6], "1140,T,0,1,0,1,2,0,1,0");
    assert_eq!(rows[7], "1150,V,0,1,0,0,0,1,1,0");
    assert_eq!(rows[8], "1300,H,0,0,0,0,0,1,1,1");
    assert_eq!(rows.len(), 9, "{stdout}");
    assert_eq!(code, Some(1), "{stderr}");
    assert!(stderr.contains("deadlock after 1310 ms") && stderr.contains("marked: D"), "{stderr}");
    // The dump says the same.
    let bytes = std::fs::read(at.join("t.vcd")).expect("a dump");
    let mut parser = vcd::Parser::new(&bytes[..]);
    let header = parser.parse_header().expect("a header");
    let wire = header.find_var(&["snet", "C.count"]).expect("a register").code;
    let t = header.find_var(&["snet", "T"]).expect("a wire").code;
    let (mut now, mut counts, mut fired) = (0, Vec::new(), Vec::new());
    for command in parser {
        match command.expect("a command") {
            vcd::Command::Timestamp(time) => now = time,
            vcd::Command::ChangeVector(code, value) if code == wire => {
                let number =
                    value.iter().fold(0, |sum, bit| 2 * sum + u32::from(bit == vcd::Value::V1));
                counts.push((now, number));
            }
            vcd::Command::ChangeScalar(code, vcd::Value::V1) if code == t => fired.push(now),
            _ => {}
        }
    }
    assert_eq!(counts, [(0, 0), (610, 1), (1130, 2), (1150, 0)]);
    assert_eq!(fired, [100, 620, 1140]);
}

#[test]
fn code_without_its_marks_is_dead_and_with_them_it_runs() {
    let directory = tempfile::tempdir().expect("a directory");
    let at = directory.path();
    let base = ["simulate", "a.snet", "--for", "1s", "--rule", "code"];
    let (code, _, stderr) = snet(at, &base);
    assert_eq!(code, Some(1));
    assert!(
        stderr.contains("deadlock after 0 ms") && stderr.contains("no place is marked"),
        "{stderr}"
    );
    let (code, _, stderr) = snet(at, &[&base[..], &["--initial", "first-scan"]].concat());
    assert_eq!((code, &*stderr), (Some(0), ""));
}

#[test]
fn faults_are_told_with_their_line() {
    let directory = tempfile::tempdir().expect("a directory");
    let at = directory.path();
    std::fs::write(at.join("s.csv"), "time_ms,GO,NO\n").expect("written");
    let (code, _, stderr) = snet(at, &["simulate", "a.snet", "--for", "1s", "--stimulus", "s.csv"]);
    assert_eq!(code, Some(2));
    assert!(
        stderr.contains("'NO' is not an outer gate of the net") && stderr.contains("s.csv:1"),
        "{stderr}"
    );
    let (code, _, stderr) = snet(at, &["simulate", "a.snet"]);
    assert_eq!(code, Some(2));
    assert!(stderr.contains("--for"), "{stderr}");
    let (code, _, stderr) = snet(at, &["monitor", "a.snet", "--port", "nowhere"]);
    assert_eq!(code, Some(2));
    assert!(stderr.contains("no element of the net has an address"), "{stderr}");
}

#[test]
fn drawings_have_every_element() {
    let directory = tempfile::tempdir().expect("a directory");
    let at = directory.path();
    let (code, svg, stderr) = snet(at, &["draw", "a.snet"]);
    assert_eq!(code, Some(0), "{stderr}");
    let document = roxmltree::Document::parse(&svg).expect("XML");
    let count = |name: &str, class: &str| {
        let is = |node: &roxmltree::Node<'_, '_>| {
            node.has_tag_name(("http://www.w3.org/2000/svg", name))
                && node.attribute("class").is_some_and(|own| own.split(' ').any(|one| one == class))
        };
        document.descendants().filter(is).count()
    };
    // Boxes, timer with its P, counter with its c; bars; a mark and the dots of permissive gates; circles of inhibiting
    // ones.
    assert_eq!((count("rect", "symbol"), count("circle", "symbol")), (5, 1));
    assert_eq!((count("rect", "bar"), count("rect", "stop")), (3, 1));
    assert_eq!((count("circle", "mark"), count("circle", "off")), (3, 1));
    let arrows = document.descendants().filter(|node| node.attribute("marker-end").is_some());
    assert_eq!(arrows.count(), 8);
    assert!(svg.contains("充填") && svg.contains(">*</text>"));
    let (code, dot, _) = snet(at, &["draw", "a.snet", "--format", "dot"]);
    assert_eq!(code, Some(0));
    assert_eq!(dot.matches(" -> ").count(), 8 + 3);
    assert!(dot.contains("label=\"*\"") && dot.contains("arrowhead=odot"));
}
