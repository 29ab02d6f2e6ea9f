//! Which files of directories are read, refused or left out.

use super::*;
use scanbound_base::code::Code;

const CSV: &str = "a\nPLC Information:,Q26UDV\nStep No.,Line Statement,Instruction,I/O(Device),Blank,PI Statement,Note\n0,,END,,,,\n";

/// A temporary directory with these files; it is removed at the end.
struct Scratch(PathBuf);

impl Scratch {
    fn new(name: &str, files: &[(&str, &[u8])]) -> Self {
        let path = std::env::temp_dir().join(format!("scanbound-{}-{name}", std::process::id()));
        fs::create_dir_all(path.join("sub")).unwrap();
        for (name, bytes) in files {
            fs::write(path.join(name), bytes).unwrap();
        }
        Scratch(path)
    }

    fn gather(&self) -> Result<Gathered, Vec<Diagnostic>> {
        gather(std::slice::from_ref(&self.0), &Ignore::default())
    }
}

impl Drop for Scratch {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

fn told(found: &[Diagnostic]) -> Vec<(&str, String)> {
    let file = |d: &Diagnostic| name(Path::new(Path::new(&d.file).file_name().unwrap()));
    found.iter().map(|d| (d.code.name(), file(d))).collect()
}

/// The code and file of each diagnostic.
fn list(found: &[Diagnostic]) -> Vec<String> {
    told(found).into_iter().map(|(code, file)| format!("{code} {file}")).collect()
}

fn ignoring(patterns: &[&str]) -> Ignore {
    Ignore::parse(patterns.iter().copied()).unwrap()
}

#[test]
fn a_directory_is_its_programs_in_name_order_and_its_comments() {
    let scratch = Scratch::new(
        "order",
        &[
            ("b.csv", format!("{CSV}\n").as_bytes()),
            ("a.csv", CSV.as_bytes()),
            ("COMMENT.csv", b"Device Name,Comment\nX0,start\n"),
            ("labels.csv", b"Class,Label Name\nVAR,a\n"),
            ("times.csv", b"instruction,on_us,off_us\nLD,0.1,\n"),
            ("README.txt", b"call the customer"),
            ("empty.log", b""),
            (".hidden", b"call the customer"),
        ],
    );
    let gathered = scratch.gather().unwrap();
    let names: Vec<_> =
        gathered.inputs.iter().map(|input| input.name.rsplit('/').next().unwrap()).collect();
    assert_eq!(names, ["COMMENT.csv", "a.csv", "b.csv"]);
    assert_eq!(
        gathered.warnings.iter().map(|one| one.message.as_str()).collect::<Vec<_>>(),
        [
            "left out because they are not programs: .hidden, README.txt, empty.log, labels.csv, sub/, times.csv; device comments: COMMENT.csv",
            "the bound assumes that the programs run in the order of their file names: a.csv, b.csv",
        ]
    );
    assert_eq!(gathered.inputs[1].bytes, CSV.as_bytes());
}

#[test]
fn what_may_be_a_program_is_not_left_out() {
    let files: [(&str, &[u8]); 11] = [
        ("a.csv", CSV.as_bytes()),
        ("b.csv", b""),
        ("c.csv", b"a\xFF\xFF\xFFb\n"),
        ("d.CSV", b"\0\0\0\0"),
        ("e.csv", b"\"Step No.\",\"Line Stat"),
        ("g.L5X", b"<?xml version=\"1.0\"?><RSLogix5000Content/>"),
        ("h.gxw", b"\xD0\xCF\x11\xE0\0\0\0\0"),
        ("i", b"<?xml version=\"1.0\"?>"),
        ("j.txt", b"call the customer"),
        ("sub/k.csv", CSV.as_bytes()),
        (".hidden", b"LD X0\nOUT Y0\nEND\n"),
    ];
    let scratch = Scratch::new("damaged", &files);
    let directory = &scratch.0;
    let found = scratch.gather().unwrap_err();
    assert_eq!(
        list(&found),
        [
            "odd-name .hidden",
            "empty-file b.csv",
            "encoding c.csv",
            "binary-file d.CSV",
            "unknown-dialect e.csv",
            "unsupported-format g.L5X",
            "binary-file h.gxw",
            "unsupported-format i",
            "unknown-dialect j.txt",
            "nested-directory sub",
        ]
    );
    for (fault, what) in [(5, "Rockwell"), (6, "a project of GX Works2"), (7, "XML")] {
        assert!(found[fault].message.contains(what), "{}", found[fault].message);
    }
    assert!(found.iter().all(|fault| fault.help.contains("--ignore '")), "{found:#?}");
    // Each of them can be excluded by name, and all by patterns.
    let patterns: Vec<&str> = files[1..].iter().map(|(name, _)| *name).collect();
    let gathered = gather(std::slice::from_ref(directory), &ignoring(&patterns)).unwrap();
    assert_eq!(gathered.inputs.len(), 1);
    let ignore = ignoring(&["[b-z]*", ".*", "none", "sub/*"]);
    let gathered = gather(std::slice::from_ref(directory), &ignore).unwrap();
    assert_eq!(
        gathered.warnings.iter().map(|one| one.message.as_str()).collect::<Vec<_>>(),
        [
            "excluded by --ignore: .hidden, b.csv, c.csv, d.CSV, e.csv, g.L5X, h.gxw, i, j.txt, sub",
            "--ignore none matches no file",
            "--ignore sub/* matches no file",
        ]
    );
}

#[test]
fn a_label_or_a_comment_in_the_words_of_a_report_is_no_report() {
    let read = |text: &str| {
        let scratch =
            Scratch::new("words", &[("a.csv", CSV.as_bytes()), ("b.txt", text.as_bytes())]);
        scratch.gather().map(|_| ()).map_err(|found| found[0].code.name())
    };
    assert_eq!(read("The bound is 5 us; no single statement lowers that.\n"), Ok(()));
    assert_eq!(
        read("line/scanbound.toml\nREFUTED: a scan takes 5 us, the limit is\n1 us\n"),
        Ok(())
    );
    assert_eq!(read(Code::Jump.page()), Ok(()));
    for text in [
        "# jump\n\nPROGRAM p\n",
        "PROVED: LD scan\nST lamp\n",
        "// No scan takes longer than 5 us here\nLD scan\nST lamp\n",
    ] {
        assert_eq!(read(text), Err("unknown-dialect"), "{text}");
    }
}

#[test]
fn paths_that_give_nothing_or_the_same_twice() {
    let scratch = Scratch::new("twice", &[("a.csv", CSV.as_bytes())]);
    let a = scratch.0.join("a.csv");
    let named = [a.clone(), scratch.0.clone(), scratch.0.join("none"), scratch.0.join("sub")];
    let found = gather(&named, &Ignore::default()).unwrap_err();
    let codes: Vec<_> = found.iter().map(|d| d.code.name()).collect();
    assert_eq!(codes, ["named-twice", "unreadable", "no-program"]);
    let alone = std::slice::from_ref(&a);
    assert_eq!(gather(alone, &Ignore::default()).unwrap().inputs.len(), 1);
    let left = gather(alone, &ignoring(&["*.csv"])).unwrap_err();
    let codes: Vec<_> = left.iter().map(|found| found.code.name()).collect();
    assert_eq!(codes, ["left-out", "no-program"]);
    assert!(Ignore::parse(["a["]).is_err());
}

#[test]
fn a_directory_within_one_is_read_where_it_is_named() {
    let scratch =
        Scratch::new("nested", &[("a.csv", CSV.as_bytes()), ("sub/b.csv", CSV.as_bytes())]);
    let sub = scratch.0.join("sub");
    let gathered = gather(&[sub, scratch.0.clone()], &Ignore::default()).unwrap();
    assert_eq!(gathered.inputs.len(), 2);
    assert!(scratch.gather().is_err());
}

#[cfg(unix)]
#[test]
fn links_that_lead_back_or_nowhere_are_told() {
    use std::os::unix::fs::symlink;
    let scratch = Scratch::new("links", &[("a.csv", CSV.as_bytes())]);
    // A circle of links has no files of its own, but the programs that it leads back to may be part of the scan.
    symlink(scratch.0.join("sub"), scratch.0.join("sub/round")).unwrap();
    assert_eq!(scratch.gather().unwrap().inputs.len(), 1);
    symlink(scratch.0.join("nowhere"), scratch.0.join("b.csv")).unwrap();
    symlink(scratch.0.join("a.csv"), scratch.0.join("c.csv")).unwrap();
    symlink(scratch.0.join("d.csv"), scratch.0.join("d.csv")).unwrap();
    let found = scratch.gather().unwrap_err();
    let errors: Vec<_> =
        found.into_iter().filter(|fault| fault.severity == Severity::Error).collect();
    assert_eq!(list(&errors), ["unreadable b.csv", "named-twice c.csv", "unreadable d.csv"]);
}
