//! The page for a browser holds what the report holds, all rungs, and nothing that a project could slip into it.

use crate::command::binary;
use serde_json::Value;

/// The page of a project.
fn page(arguments: &[&str]) -> String {
    written(&[&["audit"], arguments].concat())
}

/// The page that a command writes.
fn written(command: &[&str]) -> String {
    let output = binary()
        .args(command)
        .args(["--format", "html", "--time-limit", "600s"])
        .output()
        .expect("the program starts");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).expect("UTF-8")
}

/// What the page's script reads.
fn data(page: &str) -> Value {
    let (_, after) = page.split_once("id=\"data\">").expect("data");
    let (data, _) = after.split_once("</script>").expect("its end");
    serde_json::from_str(data).expect("JSON")
}

#[test]
fn the_page_holds_all_rungs_and_what_each_takes() {
    let page = page(&["samples/transfer-line/line.il", "--cpu", "Q26UDV"]);
    let data = data(&page);
    let rungs = data["ladder"].as_array().expect("rungs");
    assert_eq!(rungs.len() as u64, data["report"]["program"]["blocks"].as_u64().expect("a number"));
    let elements = || rungs.iter().flat_map(|rung| rung[3].as_array().expect("elements"));
    let instructions = data["report"]["program"]["instructions"].as_u64().expect("a number");
    assert_eq!(elements().count() as u64, instructions);
    // All that instructions take is in some rung.
    let scan = &data["report"]["scan"];
    let ps = |value: &Value| value.as_u64().expect("a time");
    let parts: u64 = elements().map(|one| ps(&one[8])).sum();
    let rows = data["report"]["breakdown"]["rung"].as_array().expect("parts");
    let told = rows.iter().filter(|row| row.get("block").is_some()).map(|row| ps(&row["ps"]));
    // Rounded once an instruction.
    assert!(parts.abs_diff(told.sum()) <= instructions, "{parts}");
    assert!(parts > 0 && parts < ps(&scan["upper_ps"]));
    let lit = elements().filter(|one| one[7].as_u64() > Some(0)).count();
    assert!(
        lit > 0 && lit < elements().count(),
        "some conduct in the longest scan, and some do not"
    );
}

#[test]
fn the_page_needs_no_network_and_takes_names_for_text() {
    let directory = tempfile::tempdir().expect("a directory");
    let file = directory.path().join("a<script>alert(1)</script>.il");
    // A slash is no part of a name.
    let file = std::path::PathBuf::from(file.to_str().expect("UTF-8").replace("</script>", "<b>"));
    std::fs::write(&file, "LD X0\nOUT Y0\nEND\n").expect("written");
    let page = page(&[file.to_str().expect("UTF-8"), "--cpu", "Q26UDV"]);
    assert!(!page.contains("<script>alert"), "a file's name is text");
    assert_eq!(page.matches("</script>").count(), 2);
    assert!(page.contains("default-src 'none'"));
    for address in ["http://", "https://"] {
        let others = page.replace("http://www.w3.org/2000/svg", "");
        assert!(!others.contains(address), "{address}");
    }
}

/// The cells of each row of a page's tables, as text.
fn rows(page: &str) -> Vec<Vec<String>> {
    let plain = |cell: &str| {
        let mut told = String::new();
        let mut is_tag = false;
        for letter in cell.chars() {
            match letter {
                '<' => is_tag = true,
                '>' => is_tag = false,
                _ if !is_tag => told.push(letter),
                _ => {}
            }
        }
        told
    };
    let row = |row: &str| row.split("</td>").map(plain).filter(|cell| !cell.is_empty()).collect();
    page.split("<tr>").skip(1).map(row).collect()
}

#[test]
fn two_versions_and_measurements_are_pages_of_tables() {
    let directory = tempfile::tempdir().expect("a directory");
    let file = |name: &str, text: &str| {
        let file = directory.path().join(name);
        std::fs::write(&file, text).expect("written");
        file.to_str().expect("a plain path").to_owned()
    };
    let old = file("old.il", "LD X0\nMOV K1 D0\nLD< D0 K5\nOUT Y1\nEND\n");
    let new = file("new.il", "LD X0\nMOV K1 D0\nLD< D0 K5\nFMOV K0 D0 K400\nEND\n");
    let page = written(&["diff", &old, &new, "--cpu", "Q26UDV"]);
    assert!(!page.contains("<script") && page.contains("LD&lt; D0 K5"), "{page}");
    let rows_of = |page: &str, first: &str| {
        rows(page).into_iter().filter(|row| row.iter().any(|cell| cell == first)).count()
    };
    assert_eq!((rows_of(&page, "changed"), rows_of(&page, "outside rungs")), (1, 1));

    let measured = file("m.csv", "scan_ms\n0.40\n0.42\n0.41\n");
    let page = written(&["compare", &old, &measured, "--cpu", "Q26UDV"]);
    assert_eq!((rows_of(&page, "longest"), rows_of(&page, "bound")), (1, 1));
    assert!(page.contains("<div class=\"answer proved\">WITHIN"), "{page}");
}
