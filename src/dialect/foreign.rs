//! Formats that are known but not read: whose they are, and how to come from them to one that is.

use super::Input;
use crate::diagnostic::Diagnostic;

/// A format that cannot be read.
struct Foreign {
    /// How its files' names end, in small letters.
    endings: &'static [&'static str],
    what: &'static str,
    help: &'static str,
}

const WORKS: &str = "open it in the tool and export its programs as CSV";
const LIST: &str =
    "if its instructions can be exported as a list for one of the CPUs that are known, give that";
const NOT_YET: &str = "programs of this maker's PLCs cannot be read";

/// By the endings of names.
const FOREIGN: &[Foreign] = &[
    Foreign {
        endings: &["gxw", "gpj", "gps"],
        what: "a project of GX Works2 or GX Developer",
        help: WORKS,
    },
    Foreign { endings: &["gx3", "gxa"], what: "a project of GX Works3", help: WORKS },
    Foreign {
        endings: &["cxp", "cxr", "opt", "cxf", "cx2"],
        what: "a project of CX-Programmer",
        help: "save it as text (.cxt), or copy its mnemonics to a text file",
    },
    Foreign { endings: &["smc", "smc2"], what: "a project of Sysmac Studio", help: NOT_YET },
    Foreign {
        endings: &["mnm", "kpr", "kvp", "kpx"],
        what: "a program of KEYENCE's KV series",
        help: NOT_YET,
    },
    Foreign {
        endings: &["l5x", "l5k", "acd", "rss", "rsp"],
        what: "a project of Rockwell's Logix tools",
        help: NOT_YET,
    },
    Foreign {
        endings: &[
            "awl", "scl", "s7p", "s7dcl", "ap13", "ap14", "ap15", "ap15_1", "ap16", "ap17", "ap18",
            "ap19", "ap20", "zap15", "zap16", "zap17", "zap18", "zap19", "zap20", "mwp",
        ],
        what: "a program of Siemens' SIMATIC tools",
        help: NOT_YET,
    },
    Foreign {
        endings: &["stu", "sta", "xef", "zef", "xpg", "smbp"],
        what: "a project of Schneider's tools",
        help: NOT_YET,
    },
    Foreign {
        endings: &[
            "project", "library", "pro", "exp", "export", "tsproj", "tcpou", "tcgvl", "tcdut",
            "plcproj",
        ],
        what: "a project of CODESYS or of a tool built on it",
        help: NOT_YET,
    },
    Foreign {
        endings: &["fp", "fpw", "ppn", "spg"],
        what: "a project of Panasonic's tools",
        help: NOT_YET,
    },
    Foreign {
        endings: &["xgwx", "xgp", "dvp", "isp", "wpl"],
        what: "a project of another maker's tool",
        help: NOT_YET,
    },
    Foreign { endings: &["st", "iecst", "stx"], what: "Structured Text (IEC 61131-3)", help: LIST },
    Foreign { endings: &["xml"], what: "XML, such as PLCopen's", help: LIST },
    Foreign {
        endings: &["zip", "7z", "rar", "gz", "tar", "lzh"],
        what: "an archive",
        help: "unpack it and give the programs in it",
    },
    Foreign {
        endings: &["xls", "xlsx", "xlsm", "ods"],
        what: "a spreadsheet",
        help: "save its sheet as CSV, as the vendor's tool exported it",
    },
];

/// By what is in the text: a piece of its beginning.
const CONTENT: [(&str, &str, &str); 4] = [
    ("<RSLogix5000Content", "a project of Rockwell's Logix tools (L5X)", NOT_YET),
    ("plcopen.org/xml", "a project in PLCopen XML", LIST),
    ("<TcPlcObject", "a program of TwinCAT", NOT_YET),
    ("<?xml", "XML", LIST),
];

/// Words with which a line of Structured Text begins, and nothing else's.
const STRUCTURED: [&str; 10] = [
    "FUNCTION_BLOCK",
    "END_FUNCTION_BLOCK",
    "END_PROGRAM",
    "END_FUNCTION",
    "VAR_INPUT",
    "VAR_OUTPUT",
    "END_VAR",
    "END_IF;",
    "ORGANIZATION_BLOCK",
    "END_FOR;",
];

/// That a file is in a known format which cannot be read; `None` if it is in none of them.
pub(super) fn fault(input: &Input, beginning: &str) -> Option<Diagnostic> {
    let (what, help) = by_content(&input.bytes, beginning).or_else(|| by_name(&input.name))?;
    let message = format!("this is {what}, which cannot be read");
    Some(Diagnostic::file("unsupported-format", &input.name, message, help))
}

fn by_name(name: &str) -> Option<(&'static str, &'static str)> {
    let ending = name.rsplit_once('.')?.1.to_ascii_lowercase();
    let one = FOREIGN.iter().find(|one| one.endings.contains(&ending.as_str()))?;
    Some((one.what, one.help))
}

fn by_content(bytes: &[u8], beginning: &str) -> Option<(&'static str, &'static str)> {
    if bytes.starts_with(&[0xD0, 0xCF, 0x11, 0xE0]) || bytes.starts_with(b"PK\x03\x04") {
        // Many tools' projects are such files: the name says more.
        return None;
    }
    let known = CONTENT.iter().find(|(piece, ..)| beginning.contains(piece));
    if let Some(&(_, what, help)) = known {
        return Some((what, help));
    }
    let structured = beginning.lines().any(|line| {
        let first = line.split_whitespace().next().unwrap_or_default();
        STRUCTURED.iter().any(|word| first.eq_ignore_ascii_case(word))
    });
    structured.then_some(("Structured Text (IEC 61131-3)", LIST))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn endings_stand_once() {
        let mut all: Vec<&str> = FOREIGN.iter().flat_map(|one| one.endings).copied().collect();
        all.sort_unstable();
        let before = all.len();
        all.dedup();
        assert_eq!(all.len(), before);
        assert!(all.iter().all(|ending| ending.to_lowercase() == **ending));
    }
}
