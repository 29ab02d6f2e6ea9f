//! Recognises file formats that scanbound does not read, and says how to export them in a format that it reads.

use super::input::Input;
use scanbound_base::code::Code;
use scanbound_base::diagnostic::Diagnostic;
use scanbound_base::facts::TABLES;

/// An unsupported format and its file name extensions.
struct Foreign {
    /// The extensions in lower case, without the dot.
    endings: &'static [&'static str],
    kind: Kind,
}

/// What a message calls the format, and what the user can do.
#[derive(Clone, Copy)]
struct Kind {
    what: &'static str,
    help: &'static str,
}

// The help texts: how to get a file that scanbound reads.
const WORKS: &str = "open the project in the tool, export each program and the device comments to CSV, and give these files";
const LIST: &str = "if the tool can export an instruction list for a supported CPU, give that list";
const MEASURED: &str = "give the program before the measurements: the last file of `compare` is the one with measurements";
const NONE: &str = "scanbound reads no file of this tool: give a program of MELSEC, of OMRON's C, CS, CJ and CP series, of MINASEC-U, of flowchart PCs, or in a language of IEC 61131-3 (PLCopen XML, text)";
const PLCOPEN: &str = "export the PLC project as PLCopen XML (in CODESYS: Project, Export PLCopenXML; in TwinCAT: PLC project, Export PLCopenXML), and give that file";
const UNIT: &str = "begin the file with PROGRAM, FUNCTION_BLOCK, FUNCTION, INTERFACE, TYPE, VAR_GLOBAL or CONFIGURATION; for statements alone, write PROGRAM name, VAR ... END_VAR with all variables, the statements, and END_PROGRAM";
const NET: &str =
    "use scanbound snet check for a net, or scanbound snet bound for the scan time of its code";
const UNPACK: &str = "unpack the archive, and give the program files in it";
const SHEET: &str = "save the sheet as CSV, with the columns of the vendor's export";

const fn kind(what: &'static str, help: &'static str) -> Kind {
    Kind { what, help }
}

const ROCKWELL: Kind = kind("a project of Rockwell's Logix tools", NONE);
const SIEMENS: Kind = kind("a program of Siemens' SIMATIC tools", NONE);
const SCHNEIDER: Kind = kind("a project of a Schneider Electric PLC programming tool", NONE);
const KEYENCE: Kind = kind("a program of the KEYENCE KV series", NONE);
const CODESYS: Kind = kind("a project of CODESYS or of a tool built on CODESYS", PLCOPEN);
const TWINCAT: Kind = kind("a TwinCAT project or a part of one", PLCOPEN);
const PETRI: Kind = kind("a Petri net, not a program", NET);
const SYSMAC: Kind = kind("a project of Sysmac Studio (OMRON's NJ, NX and NY series)", NONE);
const STRUCTURED: Kind = kind(
    "Structured Text (IEC 61131-3) that does not begin with PROGRAM, FUNCTION_BLOCK, FUNCTION or a declaration",
    UNIT,
);
const ARCHIVE: Kind = kind("an archive", UNPACK);

const FOREIGN: &[Foreign] = &[
    Foreign { endings: &["gxw"], kind: kind("a project of GX Works2", WORKS) },
    Foreign { endings: &["gpj", "gps"], kind: kind("a project of GX Developer", WORKS) },
    Foreign { endings: &["gx3", "gxa"], kind: kind("a project of GX Works3", WORKS) },
    Foreign {
        endings: &["cxp", "cxr", "opt", "cxf", "cx2"],
        kind: kind(
            "a project of CX-Programmer in its binary format",
            "save the project as text (.cxt), or copy the mnemonics to a text file",
        ),
    },
    Foreign { endings: &["smc", "smc2", "csm2"], kind: SYSMAC },
    Foreign { endings: &["mnm", "kpr", "kvp", "kpx"], kind: KEYENCE },
    Foreign { endings: &["l5x", "l5k", "acd", "rss", "rsp"], kind: ROCKWELL },
    Foreign {
        endings: &[
            "awl", "scl", "s7p", "s7dcl", "ap13", "ap14", "ap15", "ap15_1", "ap16", "ap17", "ap18",
            "ap19", "ap20", "zap15", "zap16", "zap17", "zap18", "zap19", "zap20", "mwp",
        ],
        kind: SIEMENS,
    },
    Foreign {
        endings: &["stu", "sta", "xef", "zef", "xpg", "smbp", "xst", "xld", "xbd", "xil", "xsf"],
        kind: SCHNEIDER,
    },
    Foreign { endings: &["project", "library", "pro", "exp", "export"], kind: CODESYS },
    Foreign { endings: &["tsproj", "tcpou", "tcgvl", "tcdut", "plcproj", "tnzip"], kind: TWINCAT },
    Foreign {
        endings: &["fp", "fpw", "ppn", "spg"],
        kind: kind("a project of a Panasonic PLC programming tool", NONE),
    },
    Foreign { endings: &["xgwx", "xgp"], kind: kind("a project of LS ELECTRIC XG5000", NONE) },
    Foreign {
        endings: &["dvp", "isp", "wpl"],
        kind: kind("a project of Delta WPLSoft or ISPSoft", NONE),
    },
    Foreign { endings: &["st", "iecst", "stx"], kind: STRUCTURED },
    Foreign { endings: &["xml"], kind: kind("XML", LIST) },
    Foreign { endings: &["pnml", "snet"], kind: PETRI },
    Foreign { endings: &["zip", "7z", "rar", "gz", "tar", "lzh"], kind: ARCHIVE },
    Foreign { endings: &["xls", "xlsx", "xlsm", "ods"], kind: kind("a spreadsheet", SHEET) },
];

/// Texts near the beginning of a file that identify a format; the first match counts.
const TEXTS: [(&str, Kind); 21] = [
    ("<pnml", PETRI),
    ("<RSLogix5000Content", kind("a project of Rockwell's Logix tools (L5X)", NONE)),
    ("IE_VER :=", kind("a project of Rockwell's Logix tools (L5K)", NONE)),
    ("https://www.ia.omron.com/Smc", SYSMAC),
    ("TC65SC65BWG7TF10", kind("a project in XML of IEC 61131-10", LIST)),
    ("plcopen.org/xml", kind("a project in PLCopen XML", LIST)),
    ("<TcPlcObject", TWINCAT),
    ("<TcSmProject", TWINCAT),
    ("<SW.Blocks.", kind("a block of Siemens' TIA Portal in XML", NONE)),
    ("<CAEXFile", kind("a project in AutomationML", NONE)),
    ("ExchangeFile>", SCHNEIDER),
    ("<StructuredView Guid=", CODESYS),
    ("(* @NESTEDCOMMENTS :=", CODESYS),
    ("(* @OBJECTFLAGS :=", CODESYS),
    ("ORGANIZATION_BLOCK", SIEMENS),
    ("{ S7_", SIEMENS),
    (";MODULE_TYPE:", KEYENCE),
    ("_FILES_CLASSICLADDER", kind("a project of ClassicLadder", NONE)),
    ("$timescale", kind("a captured signal (VCD)", MEASURED)),
    ("; CSV generated by", kind("a captured signal", MEASURED)),
    ("<?xml", kind("XML", LIST)),
];

/// The first bytes of binary formats. Many tools keep a project in an archive or a compound file, so a known file name
/// extension is preferred to these.
const BYTES: [(&[u8], Kind); 7] = [
    (b"PK\x03\x04", kind("an archive (ZIP), or a tool's project in ZIP format", UNPACK)),
    (
        b"\xD0\xCF\x11\xE0",
        kind("a compound file, the project format of GX Works2 and other Windows tools", WORKS),
    ),
    (b"7z\xBC\xAF\x27\x1C", ARCHIVE),
    (b"Rar!\x1A\x07", ARCHIVE),
    (b"\x1F\x8B", ARCHIVE),
    (b"SQLite format 3\0", kind("a database, the project format of some tools", WORKS)),
    (
        b"%PDF-",
        kind("a PDF", "export the program as text or CSV from the tool instead of printing it"),
    ),
];

/// Words that only Structured Text has at the beginning of a line.
const WORDS: [&str; 9] = [
    "FUNCTION_BLOCK",
    "END_FUNCTION_BLOCK",
    "END_PROGRAM",
    "END_FUNCTION",
    "VAR_INPUT",
    "VAR_OUTPUT",
    "END_VAR",
    "END_IF;",
    "END_FOR;",
];

/// Words that only a sequential function chart in text form has at the beginning of a line.
const CHART: [&str; 3] = ["INITIAL_STEP", "END_STEP", "END_TRANSITION"];

/// The error for a file in a known format that scanbound does not read; `None` if the format is not recognised.
pub fn fault(input: &Input, beginning: &str) -> Option<Diagnostic> {
    if let Some((what, help)) = own_format(beginning) {
        let message = format!("this is {what}, not a program");
        return Some(Diagnostic::file(Code::UnknownDialect, &input.name, message, help));
    }
    let found =
        by_text(beginning).or_else(|| by_name(&input.name)).or_else(|| by_bytes(&input.bytes));
    let Kind { what, help } = found?;
    // An instruction list is supported, its vendor's project format is not.
    let message = match help {
        NONE | LIST => format!("this is {what}: not supported yet"),
        UNIT | NET => format!("this is {what}"),
        _ => format!("this is {what}, which scanbound cannot read"),
    };
    Some(Diagnostic::file(Code::UnsupportedFormat, &input.name, message, help))
}

/// What a file is that scanbound itself reads or writes but that is not a program (a timing table, facts, a project
/// file, a report), and how to give it. `None` for other files.
fn own_format(beginning: &str) -> Option<(&'static str, &'static str)> {
    let lines = || beginning.lines().map(str::trim);
    let is_written = |line: &&str| !line.is_empty() && !line.starts_with('#');
    let head = lines().find(is_written).unwrap_or_default().to_ascii_lowercase();
    let is_column = |name: &str| head.split(',').any(|column| column.trim() == name);
    if is_column("instruction") && is_column("on_us") {
        return Some((
            "a timing table",
            "give the table with --table, and the program files as arguments",
        ));
    }
    let table = |line: &str| line.strip_prefix('[')?.strip_suffix(']').map(str::to_owned);
    if head.starts_with('[')
        && lines().filter_map(table).any(|name| TABLES.contains(&name.as_str()))
    {
        return Some((
            "a facts file",
            "give the facts file with --facts, and the program files as arguments",
        ));
    }
    if lines().any(|line| line.starts_with("programs") && line.contains('=') && line.contains('['))
    {
        let help = "scanbound reads this file if no program is named: run the command in the directory of this file, without program files as arguments";
        return Some(("a project file (scanbound.toml)", help));
    }
    let is_report = beginning.trim_start().starts_with('{') && beginning.contains("\"scanbound.");
    is_report
        .then_some(("a report of scanbound", "give the program files, not a report about them"))
}

fn by_name(name: &str) -> Option<Kind> {
    let ending = name.rsplit_once('.')?.1.to_ascii_lowercase();
    let one = FOREIGN.iter().find(|one| one.endings.contains(&ending.as_str()))?;
    Some(one.kind)
}

fn by_bytes(bytes: &[u8]) -> Option<Kind> {
    BYTES.iter().find(|(begins, _)| bytes.starts_with(begins)).map(|&(_, kind)| kind)
}

fn by_text(beginning: &str) -> Option<Kind> {
    if let Some(&(_, kind)) = TEXTS.iter().find(|(piece, _)| beginning.contains(piece)) {
        return Some(kind);
    }
    let begins = |words: &[&str]| {
        beginning.lines().any(|line| {
            let first = line.split_whitespace().next().unwrap_or_default();
            words.iter().any(|word| first.eq_ignore_ascii_case(word))
        })
    };
    // Siemens statement lists have networks and block titles of this form.
    if begins(&["NETWORK"]) && beginning.contains("TITLE =") {
        return Some(SIEMENS);
    }
    if begins(&CHART) {
        return Some(kind(
            "a sequential function chart (IEC 61131-3) that does not begin with PROGRAM or FUNCTION_BLOCK",
            UNIT,
        ));
    }
    begins(&WORDS).then_some(STRUCTURED)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn content_tells_more_than_a_name() {
        let what = |name: &str, text: &str| {
            let input = Input { name: name.to_owned(), bytes: text.as_bytes().to_vec() };
            fault(&input, text).map(|fault| fault.message)
        };
        let is = |name: &str, text: &str, part: &str| {
            let message = what(name, text).expect("a known format");
            assert!(message.contains(part), "{message}");
        };
        is("a.csv", "; CSV generated by libsigrok\n", "captured signal");
        is("a.txt", "$date today $end\n$timescale 1 ns $end\n", "VCD");
        is("a.GXW", "\u{0}", "a project of GX Works2, which scanbound cannot read");
        is("a.cxp", "\u{0}", "CX-Programmer");
        is("a.bin", "PK\u{3}\u{4}", "ZIP");
        for (text, part) in [
            ("<?xml version=\"1.0\"?>\n<RSLogix5000Content>", "Rockwell's Logix tools (L5X)"),
            ("(*****\n  Import-Export\n*****)\n\nIE_VER := 2.11;\n", "(L5K)"),
            ("DATA_BLOCK DB 1\nTITLE =\nBEGIN\nNETWORK\n", "Siemens"),
            ("ORGANIZATION_BLOCK \"Main\"\n{ S7_Optimized_Access := 'TRUE' }\n", "Siemens"),
            ("<project xmlns=\"http://www.plcopen.org/xml/tc6_0201\">", "PLCopen XML"),
            ("<Project xmlns:smcext=\"https://www.ia.omron.com/Smc\">", "Sysmac Studio"),
            ("<?xml version=\"1.0\"?>\n<FEFExchangeFile>", "Schneider"),
            ("DEVICE:55\n;MODULE:Main\n;MODULE_TYPE:0\nLD R0\n", "KEYENCE"),
        ] {
            is("a.txt", text, part);
            is("a.txt", text, ": not supported yet");
        }
        is("a.txt", "a := 1;\nEND_IF;\n", "Structured Text (IEC 61131-3) that does not begin with");
        is("a.txt", "INITIAL_STEP s0:\nEND_STEP\n", "sequential function chart");
        is("a.txt", "<?xml version=\"1.0\"?>\n<TcPlcObject Version=\"1.1\">", "TwinCAT");
        is("a.txt", "(* @NESTEDCOMMENTS := 'Yes' *)\nPROGRAM p\nVAR\n", "CODESYS");
        is("a.txt", "<pnml xmlns=\"x\">", "a Petri net");
        assert_eq!(what("a.txt", "call the customer"), None);
    }

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
