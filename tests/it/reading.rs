//! MELSEC programs in every encoding, head language and notation are read as the same instructions.

use encoding_rs::{EUC_KR, Encoding, GBK, SHIFT_JIS};
use proptest::prelude::*;
use scanbound::base::diagnostic::{Diagnostic, Severity};
use scanbound::front::Input;
use scanbound::front::melsec::source::{RawInstruction, RawProject};

/// How a tool writes text to a file.
#[derive(Debug, Clone, Copy)]
enum Form {
    Utf16Le,
    Utf16Be,
    Utf8,
    Utf8Bom,
    Page(&'static Encoding),
}

/// CPU row and column heads of one language.
struct Heads {
    cpu: [&'static str; 2],
    columns: [&'static str; 7],
    form: Form,
    text: &'static str,
}

const ENGLISH: [&str; 7] =
    ["Step No.", "Line Statement", "Instruction", "I/O(Device)", "Blank", "PI Statement", "Note"];

fn languages() -> Vec<Heads> {
    vec![
        Heads {
            cpu: ["PLC Information:", "QCPU (Q mode) Q26UDV"],
            columns: ENGLISH,
            form: Form::Utf8,
            text: "conveyor",
        },
        Heads {
            cpu: ["PC情報:", "QCPU (Q mode) Q26UDV"],
            columns: [
                "ステップ番号",
                "行間ステートメント",
                "命令",
                "I/O(デバイス)",
                "空欄",
                "PIステートメント",
                "ノート",
            ],
            form: Form::Page(SHIFT_JIS),
            text: "搬送 ｲﾝﾀｰﾛｯｸ",
        },
        Heads {
            cpu: ["PLC信息:", "QCPU (Q mode) Q26UDV"],
            columns: ["步号", "行间声明", "指令", "I/O(软元件)", "空白栏", "PI声明", "注解"],
            form: Form::Page(GBK),
            text: "急停按钮",
        },
        Heads {
            cpu: ["PLC 정보:", "QCPU (Q mode) Q26UDV"],
            columns: [
                "스텝 번호",
                "행간 스테이트먼트",
                "명령",
                "I/O(디바이스)",
                "공란",
                "PI 스테이트먼트",
                "노트",
            ],
            form: Form::Page(EUC_KR),
            text: "비상정지",
        },
    ]
}

fn encode(text: &str, form: Form) -> Vec<u8> {
    match form {
        Form::Utf8 => text.as_bytes().to_vec(),
        Form::Utf8Bom => [b"\xEF\xBB\xBF", text.as_bytes()].concat(),
        Form::Utf16Le => {
            [0xFEFF].into_iter().chain(text.encode_utf16()).flat_map(u16::to_le_bytes).collect()
        }
        Form::Utf16Be => {
            [0xFEFF].into_iter().chain(text.encode_utf16()).flat_map(u16::to_be_bytes).collect()
        }
        Form::Page(encoding) => {
            let (bytes, _, lossy) = encoding.encode(text);
            assert!(!lossy, "{text} has no form in {}", encoding.name());
            bytes.into_owned()
        }
    }
}

/// An instruction with what GX Works2 writes around it.
#[derive(Debug, Clone)]
struct Line {
    statement: Option<String>,
    words: Vec<String>,
    pi: Option<String>,
    note: Option<String>,
}

fn line(words: &[&str]) -> Line {
    Line {
        statement: None,
        words: words.iter().map(|&word| word.to_owned()).collect(),
        pi: None,
        note: None,
    }
}

/// The rows of a GX Works2 export: each instruction with its first operand, the others on rows of their own.
fn rows(title: &str, heads: &Heads, program: &[Line]) -> Vec<Vec<String>> {
    let row = |cells: &[&str]| cells.iter().map(|&cell| cell.to_owned()).collect::<Vec<_>>();
    let mut out = vec![row(&[title]), row(&heads.cpu), row(&heads.columns)];
    for (index, line) in program.iter().enumerate() {
        let step = index.to_string();
        if let Some(statement) = &line.statement {
            out.push(row(&[&step, statement, "", "", "", "", ""]));
        }
        let word = |index: usize| line.words.get(index).map_or("", String::as_str);
        out.push(row(&[&step, "", word(0), word(1), "", "", ""]));
        for operand in line.words.iter().skip(2) {
            out.push(row(&["", "", "", operand, "", "", ""]));
        }
        if let Some(pi) = &line.pi {
            out.push(row(&["", "", "", "", "", pi, ""]));
        }
        if let Some(note) = &line.note {
            out.push(row(&["", "", "", "", "", "", note]));
        }
    }
    out
}

/// Every field quoted, quotation known_words doubled, CR LF.
fn quoted(rows: &[Vec<String>], separator: &str) -> String {
    let mut out = String::new();
    for row in rows {
        let cells: Vec<String> =
            row.iter().map(|cell| format!("\"{}\"", cell.replace('"', "\"\""))).collect();
        out.push_str(&cells.join(separator));
        out.push_str("\r\n");
    }
    out
}

fn input(name: &str, bytes: impl Into<Vec<u8>>) -> Input {
    Input { name: name.to_owned(), bytes: bytes.into() }
}

fn read(name: &str, bytes: impl Into<Vec<u8>>) -> Result<RawProject, Vec<Diagnostic>> {
    read_project(&[input(name, bytes)], None)
}

fn read_project(inputs: &[Input], dialect: Option<&str>) -> Result<RawProject, Vec<Diagnostic>> {
    scanbound::front::read(inputs, dialect).map(|project| project.downcast().expect("MELSEC"))
}

fn texts(project: &RawProject) -> Vec<&str> {
    project.files[0].instructions.iter().map(|i| &*i.text).collect()
}

fn codes(found: &[Diagnostic]) -> Vec<(&str, Option<u32>)> {
    found.iter().map(|d| (d.code.name(), d.line)).collect()
}

/// The faults of a file, each with its code and line.
fn faults(bytes: impl Into<Vec<u8>>) -> Vec<(&'static str, Option<u32>)> {
    let found = read("a.csv", bytes).expect_err("the file is at fault");
    for fault in &found {
        assert!(!fault.message.is_empty() && !fault.help.is_empty(), "{fault:?}");
        assert!(fault.text.chars().count() < 130, "{fault:?}");
    }
    found.iter().map(|d| (d.code.name(), d.line)).collect()
}

fn sample(text: &str) -> Vec<Line> {
    let mut program = vec![
        line(&["LD", "X0C21"]),
        line(&["AND<>", "D100", "K-1"]),
        line(&["OUT", "T0", "K50"]),
        line(&["P50"]),
        line(&["NOPLF"]),
        line(&["LD", "SM400"]),
        line(&["$MOV", "\"a \"\"b\"", "ZR42050Z11"]),
        line(&["BMOV", "U0Z0\\G74", "K4L20000", "K10"]),
        line(&["END"]),
    ];
    program[0].statement = Some(text.to_owned());
    program[2].note = Some(format!("{text}\t\"{text}\""));
    program[3].pi = Some(text.to_owned());
    program[3].statement = Some(String::new());
    program
}

const SAMPLE: [&str; 9] = [
    "LD X0C21",
    "AND<> D100 K-1",
    "OUT T0 K50",
    "P50",
    "NOPLF",
    "LD SM400",
    "$MOV \"a \"\"b\" ZR42050Z11",
    "BMOV U0Z0\\G74 K4L20000 K10",
    "END",
];

#[test]
fn every_language_in_every_encoding() {
    for heads in languages() {
        let program = sample(heads.text);
        let rows = rows("(no title)", &heads, &program);
        for form in [Form::Utf16Le, Form::Utf16Be, Form::Utf8, Form::Utf8Bom, heads.form] {
            for separator in ["\t", ",", ";"] {
                let text = quoted(&rows, separator);
                for text in [text.clone(), text.replace("\r\n", "\n")] {
                    let bytes = encode(&text, form);
                    let project = read("plant/MAIN.csv", bytes).unwrap_or_else(|e| {
                        panic!("{form:?} {separator:?} {:?}: {e:?}", heads.cpu)
                    });
                    assert_eq!(project.dialect, "melsec-csv");
                    assert_eq!(texts(&project), SAMPLE);
                    assert_eq!(project.files[0].cpu.as_deref(), Some("Q26UDV"));
                    assert_eq!(project.files[0].program, "MAIN");
                    assert_eq!(project.warnings, []);
                }
            }
        }
    }
}

#[test]
fn lines_are_those_of_the_file() {
    let heads = &languages()[0];
    let text = quoted(&rows("a", heads, &sample("statement")), "\t");
    let project = read("a.csv", encode(&text, Form::Utf16Le)).unwrap();
    let physical: Vec<&str> = text.lines().collect();
    for instruction in &project.files[0].instructions {
        let at = physical[instruction.line as usize - 1];
        let mnemonic = format!("\t\"{}\"\t", instruction.mnemonic);
        assert!(at.contains(&mnemonic), "{instruction:?} is said to be at {at}");
        assert!(instruction.step.is_some());
    }
    // Blank lines, and lines within a statement, count as well.
    let text = "a\n\n\"PLC Information:\",FX3U\n\nStep No.,Line Statement,Instruction,I/O(Device),Blank,PI Statement,Note\n0,\"two\nlines\",,,,,\n0,,LD,X0,,,\n\n\n1,,END,,,,\n";
    let project = read("a.csv", text).unwrap();
    let lines: Vec<u32> = project.files[0].instructions.iter().map(|i| i.line).collect();
    assert_eq!(lines, [8, 11]);
}

#[test]
fn works3_and_its_four_ways_to_write_operands() {
    for body in [
        "0,,LD,X0,,,\n1,,MOV,D0,,,\n,,,D1,,,\n3,,END,,,,\n",
        "0,,LD X0,,,,\n1,,MOV D0 D1,,,,\n3,,END,,,,\n",
        "0,,LD,X0,,,\n1,,MOV,D0 D1,,,\n3,,END,,,,\n",
        "0,,LD,X0,,,\n1,,MOV D0,D1,,,\n3,,END,,,,\n",
    ] {
        for info in
            ["Module Type Information:,RCPU R08", "機種情報:,RCPU R08", "机型信息:,RCPU R08"]
        {
            let text = format!(
                "\"ST20\"\n{info}\nStep No.,Line Statement,Instruction,I/O (Device),Blank,P/I Statement,Note\n0,[Title]a,,,,,\n{body}"
            );
            let project = read("a.csv", text).unwrap();
            assert_eq!(project.dialect, "melsec-gx3-csv");
            assert_eq!(texts(&project), ["LD X0", "MOV D0 D1", "END"]);
            assert_eq!(project.files[0].cpu.as_deref(), Some("R08"));
        }
    }
}

#[test]
fn cpus_as_files_name_them() {
    for (info, cpu, dialect) in [
        ("\"PLC Information:\"\t\"FXCPU FX3U/FX3UC\"", Some("FX3U/FX3UC"), "melsec-csv"),
        ("\"PLC Information:\"\t\"LCPU L26-BT\"", Some("L26-BT"), "melsec-csv"),
        ("\"PLC Information:\"\t\"QCPU (Q mode)\"", Some("QCPU"), "melsec-csv"),
        ("\"PLC Type:FX3U(C)\"", Some("FX3U(C)"), "melsec-csv"),
        ("\"PLC Information:\"", None, "melsec-csv"),
        ("\"Module Type Information:\"\t\"FX5U\"", Some("FX5U"), "melsec-gx3-csv"),
        (
            "\"Machine: FX3U\"\r\n\"PLC Information:\"\t\"QCPU (Q mode) Q03UDV\"",
            Some("Q03UDV"),
            "melsec-csv",
        ),
        ("\"Something else:\"\t\"RCPU R120\"", Some("R120"), "melsec-gx3-csv"),
    ] {
        let text = format!(
            "\"a\"\r\n{info}\r\n{}\r\n\"0\"\t\"\"\t\"END\"\t\"\"\t\"\"\t\"\"\t\"\"\r\n",
            ENGLISH.map(|head| format!("\"{head}\"")).join("\t")
        );
        let project = read("a.csv", text).unwrap();
        assert_eq!((project.files[0].cpu.as_deref(), project.dialect), (cpu, dialect), "{info}");
    }
}

#[test]
fn heads_of_an_unknown_language_are_known_by_their_shape() {
    let text = "a\nThông tin PLC:,FXCPU FX3G\nBước,Dòng,Lệnh,Thiết bị,Trống,PI,Ghi chú\n0,,LD,X000,,,\n1,,END,,,,\n";
    let project = read("a.csv", text).unwrap();
    assert_eq!(texts(&project), ["LD X000", "END"]);
}

#[test]
fn list_text() {
    let text = "\u{FEFF}; a comment\n0 LD X0\n0001:AND\tX1 // both\n2: OUT Y0\n\nP50\nP51:\nP52: LD= D0 K1\n$MOV \"a; // b\" D0\nSwOp0 D9002\nLDI M0\nORB\nEND ; done\n; after\n";
    let project = read("a.il", text).unwrap();
    assert_eq!(project.dialect, "melsec-list");
    assert_eq!(
        texts(&project),
        [
            "LD X0",
            "AND X1",
            "OUT Y0",
            "P50",
            "P51",
            "P52",
            "LD= D0 K1",
            "$MOV \"a; // b\" D0",
            "SwOp0 D9002",
            "LDI M0",
            "ORB",
            "END"
        ]
    );
    let at: Vec<(u32, Option<u32>)> =
        project.files[0].instructions.iter().take(4).map(|i| (i.line, i.step)).collect();
    assert_eq!(at, [(2, Some(0)), (3, Some(1)), (4, Some(2)), (6, None)]);
}

#[test]
fn a_list_of_mostly_application_instructions() {
    for text in [
        "LD SM400\nWAND D0 D1\n+ K1 D2\nSwOp0 D0\nFB1 D2\nBKAND D0 D10 D20 K5\nEND\n",
        "P0\nRET\nEND\n",
        "EI\nFB1 D0\nEND",
        "ld x0\nout y0\nend\n",
        "END",
    ] {
        let project = read("a.il", text).unwrap();
        assert_eq!(project.files[0].instructions.len(), text.lines().count(), "{text}");
    }
}

#[test]
fn faults_of_a_list_are_told_at_once() {
    let text = "LD X0\n12\n)x\n$MOV \"a D0\nOUT Y0\nEND\nLD X1\nOUT Y1\n";
    let found = read("a.il", text).unwrap_err();
    assert_eq!(
        codes(&found),
        [
            ("bare-step", Some(2)),
            ("not-an-instruction", Some(3)),
            ("open-string", Some(4)),
            ("after-end", Some(7))
        ]
    );
    assert_eq!(codes(&read("a.il", "LD X0\nOUT Y0\n").unwrap_err()), [("no-end", Some(2))]);
}

/// A GX Works2 file of these rows under English heads.
fn works2(body: &str) -> String {
    format!("a\nPLC Information:,Q26UDV\n{}\n{body}", ENGLISH.join(","))
}

#[test]
fn faults_of_a_csv_are_told_at_once() {
    assert_eq!(
        faults(works2(
            "0,,,D0,,,\n0,,LD,X0,,,\n1,,OUT,Y0\nx,,LD,X1,,,\n3,,LD,X1,,,,,more\n4,,\"$MOV\",\"\"\"a D0\",,,\n5,,(,,,,\n6,,LD,\"X\n0\",,,\n7,,END,,,,\n8,,LD,X1,,,\n9,,OUT,Y1,,,\n"
        )),
        [
            ("stray-operand", Some(4)),
            ("columns", Some(6)),
            ("step-number", Some(7)),
            ("columns", Some(8)),
            ("open-string", Some(9)),
            ("not-an-instruction", Some(10)),
            ("open-quote", Some(11)),
            ("after-end", Some(14)),
        ]
    );
}

#[test]
fn a_file_cut_anywhere_is_never_taken() {
    let text = quoted(&rows("a", &languages()[1], &sample("文")), "\t");
    for form in [Form::Utf16Le, Form::Utf8, Form::Page(SHIFT_JIS)] {
        let bytes = encode(&text, form);
        // The last cell is empty: without it and its line end nothing is lost.
        let nothing = if matches!(form, Form::Utf16Le) { 8 } else { 4 };
        for length in 0..bytes.len() - nothing {
            let found = read("a.csv", &bytes[..length]);
            assert!(found.is_err(), "{form:?} cut to {length} of {}: {found:?}", bytes.len());
        }
    }
}

#[test]
fn rows_that_are_missing_are_an_error() {
    for (rows, line, message) in [
        ("5,,LD,X0,,,\n6,,OUT,Y0,,,\n7,,END,,,,\n", 4, "steps between 0 and 4 are missing"),
        ("0,,LD,X0,,,\n2,,OUT,Y0,,,\n3,,END,,,,\n", 5, "step 1 is missing"),
        ("0,,LD,X0,,,\n1,,OUT,Y0,,,\n150,,LD,X1,,,\n151,,END,,,,\n", 6, "steps between 2 and 149"),
        ("0,,LD,X0,,,\n1,,ANB,,,,\n9,,OUT,Y0,,,\n10,,END,,,,\n", 6, "steps between 2 and 8"),
    ] {
        let faults = read("a.csv", works2(rows)).expect_err("a fault");
        assert_eq!(codes(&faults), [("step-order", Some(line))], "{rows}");
        assert!(faults[0].message.starts_with(message), "{}", faults[0].message);
    }
    for device in ["M8191", "B1FFF", "X1FFF"] {
        let rows = format!("0,,LD,{device},,,\n2,,OUT,Y0,,,\n3,,END,,,,\n");
        let faults = read("a.csv", works2(&rows)).expect_err("a fault");
        assert_eq!(codes(&faults), [("step-order", Some(5))], "{rows}");
    }
    // A contact of an extended relay may occupy two.
    for device in ["M8192", "M9000", "B2000", "M12000"] {
        let rows = format!("0,,LD,{device},,,\n2,,OUT,Y0,,,\n3,,END,,,,\n");
        assert!(read("a.csv", works2(&rows)).is_ok(), "{rows}");
    }
    // Statements, notes and most instructions occupy several steps.
    let rows = "0,filling,,,,,\n9,,LD,X0,,,\n10,,OUT,T0 K10,,,\n14,,LD,D0.1,,,\n16,,OUT,Y0,,,\n40,,END,,,,\n";
    assert!(read("a.csv", works2(rows)).is_ok());
}

#[test]
fn steps_that_do_not_rise_are_an_error() {
    for steps in [[4, 2, 3], [1, 1, 2]] {
        let [a, b, c] = steps;
        let text = works2(&format!("{a},,LD,X0,,,\n{b},,OUT,Y0,,,\n{c},,END,,,,\n"));
        let faults = read("a.csv", text).expect_err("a fault");
        assert_eq!(codes(&faults), [("step-order", Some(5))]);
        assert_eq!((faults[0].severity, faults[0].step), (Severity::Error, Some(b)));
    }
}

#[test]
fn comments_give_devices_their_names() {
    let program = input("MAIN.csv", works2("0,,END,,,,\n"));
    for (text, form) in [
        (
            "\"COMMENT\"\r\n\"Device Name\"\t\"Comment\"\r\n\"X0\"\t\"start\"\r\n\"D0\"\t\"\"\r\n",
            Form::Utf16Le,
        ),
        ("\"機\"\r\n\"デバイス名\"\t\"コメント\"\r\n\"X0\"\t\"start\"\r\n", Form::Utf16Le),
        ("デバイス名,コメント\r\nX0,start\r\n", Form::Page(SHIFT_JIS)),
        ("\"软元件名\"\t\"注释\"\r\n\"X0\"\t\"start\"\r\n", Form::Page(GBK)),
        ("디바이스명,코멘트\nX0,start\n", Form::Page(EUC_KR)),
        ("Device,Label,Comment\nX0,PB1,start\n", Form::Utf8),
        ("MAIN\nThiết bị,Chú thích\nX0,start\nX1,\n", Form::Utf8),
        ("Device Name,Comment1,Comment2\nX0,,\"start\"\nX0,,again\n", Form::Utf8Bom),
    ] {
        let comments = input("COMMENT.csv", encode(text, form));
        let project = read_project(&[comments, program.clone()], None).unwrap();
        let found: Vec<_> = project.comments.iter().collect();
        assert_eq!(found, [(&"X0".to_owned(), &"start".to_owned())], "{text}");
    }
}

#[test]
fn faults_in_comments_stop_nothing() {
    let program = input("MAIN.csv", works2("0,,END,,,,\n"));
    let comments = input("COMMENT.csv", b"Device Name,Comment\nX0,\xFF\xFF\n".to_vec());
    let project = read_project(&[program, comments], None).unwrap();
    assert_eq!(codes(&project.warnings), [("encoding", Some(2))]);
}

#[test]
fn what_is_no_program_is_refused_with_a_reason() {
    let code = |bytes: &[u8]| read("a.csv", bytes).unwrap_err()[0].code.name();
    assert_eq!(code(b""), "empty-file");
    assert_eq!(code(b"\xFF\xFE"), "empty-file");
    assert_eq!(code(b" \r\n \r\n"), "empty-file");
    assert_eq!(code(b"\x7FELF\x02\x01\x01\0\0\0\0\0\0\0\0\0"), "binary-file");
    assert_eq!(code(b"PK\x03\x04\x14\0\x08\x08"), "binary-file");
    assert_eq!(code("Dear all,\nplease find attached".as_bytes()), "unknown-dialect");
    assert_eq!(code(b"or just call the customer, and set it out\n"), "unknown-dialect");
    assert_eq!(code(b"Part,Count\nM8 screws,100\nM10,5\n"), "unknown-dialect");
    assert_eq!(code("Device Name,Comment\nX0,start\n".as_bytes()), "comments-alone");
    assert_eq!(code(b"LD X0\nOUT Y0\n\xFF\xFF\nEND\n"), "encoding");
    assert_eq!(read_project(&[], None).unwrap_err()[0].code.name(), "no-program");
}

#[test]
fn a_named_dialect_is_kept_to() {
    let list = [input("a.il", "OUT Y0\nX ; odd\nX\nX\nEND\n")];
    assert_eq!(read_project(&list, None).unwrap_err()[0].code.name(), "unknown-dialect");
    assert_eq!(read_project(&list, Some("melsec-list")).unwrap().dialect, "melsec-list");
    assert_eq!(read_project(&list, Some("melsec-csv")).unwrap_err()[0].code.name(), "no-heads");
    let csv = [input("a.csv", works2("0,,END,,,,\n"))];
    assert_eq!(
        read_project(&csv, Some("melsec-list")).unwrap_err()[0].code.name(),
        "other-dialect"
    );
    let unknown = read_project(&csv, Some("ladder")).unwrap_err();
    assert_eq!(unknown[0].code.name(), "no-such-dialect");
    assert!(unknown[0].help.contains("melsec-gx3-csv"));
}

#[test]
fn a_project_is_one_dialect_and_one_cpu() {
    let works2_file =
        |name: &str, cpu: &str| input(name, works2("0,,END,,,,\n").replace("Q26UDV", cpu));
    let project =
        read_project(&[works2_file("b.csv", "Q26UDV"), works2_file("a.csv", "Q26UDV")], None);
    let project = project.unwrap();
    let names: Vec<&str> = project.files.iter().map(|file| file.name.as_str()).collect();
    assert_eq!(names, ["b.csv", "a.csv"], "the given order is the order of the scan");
    let mixed = read_project(&[works2_file("a.csv", "FX3U"), input("b.il", "LD X0\nEND\n")], None);
    assert_eq!(mixed.unwrap_err()[0].code.name(), "mixed-dialects");
    let two = read_project(&[works2_file("a.csv", "FX3U"), works2_file("b.csv", "Q26UDV")], None);
    assert_eq!(two.unwrap_err()[0].code.name(), "other-cpu");
    let near =
        read_project(&[works2_file("a.csv", "Q03UDV"), works2_file("b.csv", "Q26UDV")], None);
    assert_eq!(codes(&near.unwrap().warnings), [("other-cpu", None)]);
}

#[test]
fn a_large_file_of_garbage_is_refused_briefly() {
    let mut state = 1_u64;
    let block: Vec<u8> = std::iter::repeat_with(|| {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
        state.to_be_bytes()[0]
    })
    .take(1 << 20)
    .collect();
    let bytes = block.repeat(100);
    let name = "garbage.csv".to_owned();
    assert_eq!(read_project(&[Input { name, bytes }], None).unwrap_err().len(), 1);
    let heading = works2("");
    let text = format!("{heading}\n{}", ",".repeat(1 << 20));
    assert_eq!(faults(text), [("long-line", Some(5))]);
    let text = format!("{heading}{}", "garbage garbage\n".repeat(20_000));
    let found = read("a.csv", text).unwrap_err();
    assert_eq!(found.len(), 51);
    assert!(found[50].message.contains("19951 more"), "{}", found[50].message);
}

fn operand() -> impl Strategy<Value = String> {
    prop_oneof![
        "[XYMDTCLBW][0-9A-F]{1,4}",
        "K-?[0-9]{1,5}",
        "U[0-9]Z[0-9]\\\\G[0-9]{1,3}",
        "K4M[0-9]{1,4}Z[0-9]",
        "@D[0-9]{1,3}",
        "\"[a-z,;/.|\t]{0,3} [ a-zあ한]{0,6}\"",
    ]
}

fn any_line() -> impl Strategy<Value = Line> {
    let words = (
        prop_oneof![
            "(LD|AND|OR|OUT|SET|RST|MOVP?|D\\+P|LD<=|BKCMP<>|\\$MOV|ZP\\.OPEN|FB[0-9]{1,2}|P[0-9]{1,3})",
        ],
        prop::collection::vec(operand(), 0..5),
    );
    let text = || prop::option::of("[ -~あ漢]{0,12}");
    (words, text(), text(), text()).prop_map(|((mnemonic, operands), statement, pi, note)| {
        let pointer = mnemonic.starts_with('P');
        let mut words = vec![mnemonic];
        words.extend(operands.into_iter().filter(|_| !pointer));
        Line { statement, words, pi, note }
    })
}

fn same(instructions: &[RawInstruction], program: &[Line]) {
    let found: Vec<Vec<&str>> = instructions
        .iter()
        .map(|i| std::iter::once(&i.mnemonic).chain(&i.operands).map(String::as_str).collect())
        .collect();
    let meant: Vec<Vec<&str>> =
        program.iter().map(|line| line.words.iter().map(String::as_str).collect()).collect();
    assert_eq!(found, meant);
    for instruction in instructions {
        let words: Vec<&str> = std::iter::once(&instruction.mnemonic)
            .chain(&instruction.operands)
            .map(|w| w.as_str())
            .collect();
        assert_eq!(&*instruction.text, words.join(" "));
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(128))]

    #[test]
    fn what_is_written_is_read(mut program in prop::collection::vec(any_line(), 0..30), language in 0_usize..4, form in 0_usize..4, comma: bool) {
        program.push(line(&["END"]));
        let heads = &languages()[language];
        let form = [Form::Utf16Le, Form::Utf16Be, Form::Utf8, Form::Utf8Bom][form];
        let text = quoted(&rows("title", heads, &program), if comma { "," } else { "\t" });
        let project = read("a.csv", encode(&text, form)).unwrap();
        same(&project.files[0].instructions, &program);
    }

    #[test]
    fn a_list_that_is_written_is_read(mut program in prop::collection::vec(any_line(), 0..30), numbered: bool) {
        program.insert(0, line(&["LD", "X0"]));
        program.push(line(&["END"]));
        let text: Vec<String> = program.iter().enumerate().map(|(index, line)| {
            let step = if numbered { format!("{index} ") } else { String::new() };
            format!("{step}{} ; {}\n", line.words.join("\t"), line.note.clone().unwrap_or_default())
        }).collect();
        let project = read_project(&[input("a.il", text.concat())], Some("melsec-list")).unwrap();
        same(&project.files[0].instructions, &program);
    }

    #[test]
    fn arbitrary_bytes_never_panic(bytes in prop::collection::vec(any::<u8>(), 0..400), dialect in 0_usize..4) {
        let dialect = [None, Some("melsec-csv"), Some("melsec-gx3-csv"), Some("melsec-list")][dialect];
        let _ = read_project(&[input("a", bytes.clone())], dialect);
        let _ = read_project(&[input("a", [works2("").into_bytes(), bytes].concat())], dialect);
    }

    #[test]
    fn arbitrary_text_never_panics(text in "[\"\t,;:\r\nLDXP0-9あ가\u{FEFF}/$ ]{0,80}", dialect in 0_usize..4) {
        let dialect = [None, Some("melsec-csv"), Some("melsec-gx3-csv"), Some("melsec-list")][dialect];
        let _ = read_project(&[input("a", text.clone())], dialect);
        let _ = read_project(&[input("a", works2(&text))], dialect);
    }
}
