//! Tests of recognition: which front takes a file by its content.

use super::detect;
use scanbound_front::{FileKind, Input};

/// The dialect of a file, or the code and the message of the error.
fn found(bytes: impl AsRef<[u8]>) -> Result<&'static str, (&'static str, String)> {
    let input = Input { name: "a".to_owned(), bytes: bytes.as_ref().to_vec() };
    match detect(&input) {
        Ok(FileKind::Program(dialect)) => Ok(dialect.name),
        Ok(FileKind::Comments) => Err(("comments", String::new())),
        Err(fault) => Err((fault.code.name(), fault.message)),
    }
}

#[test]
fn lists_are_recognised_by_their_content() {
    for (text, name) in [
        ("LD W0.00\nOUT W0.01\nEND(001)", "omron-cx"),
        ("LD X0\nOUT Y0\nEND", "melsec-list"),
        ("LD 00000\nOUT 00500\nEND", "omron-c200h"),
        ("LBL0: AND 1\nCJP LBL0\nJMP LBL0\n", "flowchart"),
        ("0 LBL0: AND 1\n2 CTP LBL1\n3 OUT·NOT 200\n5 JMP LBL0\n", "flowchart"),
        ("LD X00\nOR Y00\nANDI X01\nST Y00\n", "minasec-asm"),
        ("0 LD X00\n1 ST Y00 ; lamp\n", "minasec-asm"),
        ("LD X00\nOUT Y00\nEND\n", "melsec-list"),
        (":00000001FF\n", "minasec-hex"),
    ] {
        assert_eq!(found(text), Ok(name), "{text}");
    }
    for text in ["LD X0\nCJP P0\nOUT Y0\nP0\nEND\n", "LD 00000\nAND 00001\nOUT 00200\nEND\n"] {
        assert_ne!(found(text), Ok("flowchart"), "{text}");
    }
    assert_eq!(found([0; 256]), Ok("minasec-bin"));
    assert_eq!(found([0; 255]).map_err(|fault| fault.0), Err("binary-file"));
}

#[test]
fn what_could_be_two_dialects_is_refused_with_both_named() {
    for (text, names) in [
        ("LD T0\nOUT C5\nEND\n", "melsec-list or omron-c200h"),
        ("LD NOT 00300\nOUTNOT 100.00\nEND\n", "omron-c200h or omron-cx"),
        ("LD X00\nAND X01\n", "minasec-asm"),
    ] {
        let (code, message) = found(text).expect_err(text);
        assert_eq!(code, "two-dialects", "{text}");
        assert!(message.contains(names), "{message}");
    }
}

#[test]
fn every_flowchart_sample_is_recognised_by_its_content() {
    let directory = concat!(env!("CARGO_MANIFEST_DIR"), "/../../samples/flowchart");
    for entry in std::fs::read_dir(directory).expect("samples") {
        let path = entry.expect("a file").path();
        let text = std::fs::read_to_string(&path).expect("text");
        assert_eq!(found(&text), Ok("flowchart"), "{}", path.display());
    }
}
