//! Programs of one kind of rung over and over, and side files of one kind of line: what fits a file of 10 MB ends in
//! exit code 0 to 3 within 1 GB.
//!
//! The ordinary run takes little files. `SCANBOUND_LARGE=1 cargo test --release --test it large:: -- --nocapture` takes
//! those of 10 MB, holds each to its memory, and prints what it took.

use crate::measured::run;
use std::fmt::Write;

/// What a large run may take, in kilobytes.
const KILOBYTES: u64 = 1 << 20;
/// How large a little file is, and a large one.
const SIZES: [usize; 2] = [4 << 10, 10 << 20];

/// A file of lines that repeat.
struct Kind {
    name: &'static str,
    /// The command but for the file; `FILE` stands for it.
    command: &'static str,
    file: &'static str,
    head: &'static str,
    /// What repeats. `{n}` is the repetition's number, `{n:100}` what it leaves divided by 100, `{n:o64}` that in
    /// octal, `{n:x64}` in hexadecimal, `{n:b64}` as a bit of an OMRON's in C200H style (00315), `{n:c64}` in CX style
    /// (3.15).
    body: &'static str,
    tail: &'static str,
    /// So many instructions a repetition has, of so many that are not refused; else 0.
    instructions: usize,
    most: usize,
    utf16: bool,
    /// How a little one ends.
    code: i32,
}

const KIND: Kind = Kind {
    name: "",
    command: "audit FILE --cpu Q26UDV",
    file: "a.il",
    head: "",
    body: "",
    tail: "END\n",
    instructions: 2,
    most: 399_000,
    utf16: false,
    code: 0,
};
const FX: Kind = Kind { command: "audit FILE --cpu FX5U", most: 131_000, ..KIND };
const C: Kind = Kind {
    command: "audit FILE --cpu C200H",
    file: "a.txt",
    tail: "END(01)\n",
    most: 306_000,
    ..KIND
};
const CX: Kind = Kind { command: "audit FILE --cpu CJ2M", tail: "END(001)\n", ..C };
const SIDE: Kind = Kind { tail: "", instructions: 0, most: 0, ..KIND };

const HEADS: &str = "\"t\"\n\"PLC Information:\",\"Q26UDV\"\n\"Step No.\",\"Line Statement\",\"Instruction\",\"I/O (Device)\",\"Blank\",\"PI Statement\",\"Note\"\n";
const FROM_STEP_0: &str = "\"t\"\n\"PLC Information:\",\"Q26UDV\"\n\"Step No.\",\"Line Statement\",\"Instruction\",\"I/O (Device)\",\"Blank\",\"PI Statement\",\"Note\"\n\"0\",\"\",\"LD\",\"X0\",\"\",\"\",\"\"\n\"\",\"\",\"OUT\",\"Y20\",\"\",\"\",\"\"\n";
const TABS: &str = "\"t\"\n\"PLC Information:\"\t\"Q26UDV\"\n\"Step No.\"\t\"Line Statement\"\t\"Instruction\"\t\"I/O (Device)\"\t\"Blank\"\t\"PI Statement\"\t\"Note\"\n";
const DUMP: &str = "$timescale 1 us $end\n$scope module m $end\n$var wire 1 ! scan $end\n$upscope $end\n$enddefinitions $end\n";

const KINDS: &[Kind] = &[
    Kind { name: "coils", body: "LD X0\nOUT Y20\n", ..KIND },
    Kind { name: "relays", body: "LD M{n:7000}\nOUT M{n:6000}\n", ..KIND },
    Kind { name: "moves", body: "LD X0\nMOV D{n:7000} D{n:6000}\n", ..KIND },
    Kind { name: "timers", body: "LD X0\nOUT T{n:2000} K50\n", ..KIND },
    Kind { name: "edges", body: "LDP X0\nINCP D0\n", ..KIND },
    Kind { name: "indices", body: "LD X0\nMOV D0Z0 D10Z1\n", ..KIND },
    Kind { name: "block-moves", body: "LD X0\nBMOV D0 D1000 K512\n", ..KIND },
    Kind { name: "block-resets", body: "LD X0\nBKRST M0 K512\n", ..KIND },
    Kind { name: "double-sums", body: "LD X0\nD+ D0 D2 D4\n", ..KIND },
    Kind { name: "comparisons", body: "LD> D{n:100} K9\nOUT Y{n:o64}\n", ..KIND },
    Kind {
        name: "contacts",
        head: "LD X0\n",
        body: "AND X1\n",
        tail: "OUT Y20\nEND\n",
        instructions: 1,
        ..KIND
    },
    Kind {
        name: "branches",
        head: "LD X0\n",
        body: "MPS\nAND X1\nOUT Y20\nMPP\nOUT Y21\n",
        instructions: 5,
        ..KIND
    },
    Kind {
        name: "zones",
        body: "LD X0\nMC N0 M0\nLD X1\nOUT Y20\nMCR N0\n",
        instructions: 5,
        ..KIND
    },
    // Devices counted up: each rung has its own.
    Kind { name: "own-edges", body: "LDP X{n:x8192}\nINCP D{n:10000}\n", ..KIND },
    Kind { name: "own-pulses", body: "LD X{n:x8192}\nPLS M{n:8191}\n", ..KIND },
    Kind { name: "own-timers", body: "LD X{n:x8192}\nOUT T{n:2000} K10\n", ..KIND },
    Kind { name: "own-counters", body: "LD X{n:x8192}\nOUT C{n:1000} K10\n", ..KIND },
    Kind { name: "own-sums", body: "LD X{n:x8192}\nDINC D{n:10000}\n", ..KIND },
    Kind { name: "own-moves", body: "LD X{n:x8192}\nMOVP D{n:9973} D{n:10007}\n", ..KIND },
    Kind { name: "own-digits", body: "LD X{n:x8192}\nMOV K4M{n:8000} D{n:10007}\n", ..KIND },
    Kind { name: "own-bits", body: "LD X{n:x8192}\nMOV D{n:10007} K4M{n:8000}\n", ..KIND },
    Kind { name: "own-comparisons", body: "LD> D{n:9973} D{n:997}\nOUT Y{n:x8192}\n", ..KIND },
    Kind {
        name: "counts-compared",
        body: "LD X{n:x8192}\nINC D{n:100}\nLD> D{n:100} K{n:3000}\nOUT M{n:8000}\n",
        instructions: 4,
        ..KIND
    },
    Kind {
        name: "word-bits",
        body: "LD X{n:x8192}\nOUT D{n:100}.3\nLD D{n:101}.4\nSET M{n:8000}\n",
        instructions: 4,
        ..KIND
    },
    Kind { name: "unknown-instructions", body: "LD X0\nFOO D{n:100}\n", code: 2, ..KIND },
    Kind { name: "wrong-operands", body: "LD X0\nMOV K99999 D{n:100}\n", code: 2, ..KIND },
    Kind { name: "no-rungs", body: "AND X0\nMPP\n", code: 2, ..KIND },
    Kind { name: "fx-timers", body: "LD X0\nOUT T{n:200} K50\n", ..FX },
    Kind { name: "fx-block-moves", body: "LD X0\nBMOV D0 D1000 K512\n", ..FX },
    Kind { name: "fx-zones", body: "LD X0\nZCP D0 D2 D4 M0\n", ..FX },
    Kind { name: "fx-own-edges", body: "LDP X{n:o1024}\nINCP D{n:7000}\n", ..FX },
    Kind { name: "fx-own-timers", body: "LD M{n:7000}\nOUT T{n:500} K10\n", ..FX },
    Kind { name: "fx-own-pulses", body: "LD M{n:7000}\nPLS M{n:6999}\n", ..FX },
    Kind {
        name: "fx-own-comparisons",
        body: "LD> D{n:7000} K{n:30000}\nMOVP K4M{n:7000} D{n:6999}\n",
        ..FX
    },
    Kind { name: "fx-beyond", body: "LD X0\nOUT Y0\n", most: usize::MAX, ..FX },
    Kind {
        name: "csv",
        file: "a.csv",
        command: "audit FILE",
        head: HEADS,
        body: ",,LD,X0,,,\n,,OUT,Y20,,,\n",
        tail: ",,END,,,,\n",
        ..KIND
    },
    Kind {
        name: "csv-steps",
        file: "a.csv",
        command: "audit FILE",
        head: FROM_STEP_0,
        body: "\"{n}\",\"\",\"LD\",\"X0\",\"\",\"\",\"\"\n\"\",\"\",\"OUT\",\"Y20\",\"\",\"\",\"\"\n",
        tail: ",,END,,,,\n",
        ..KIND
    },
    Kind {
        name: "csv-statements",
        file: "a.csv",
        command: "audit FILE",
        head: HEADS,
        body: ",,LD,X0,,,\n,,OUT,Y20,,,\n,what this does,,,,,\n",
        tail: ",,END,,,,\n",
        ..KIND
    },
    Kind {
        name: "csv-operands",
        file: "a.csv",
        command: "audit FILE",
        head: HEADS,
        body: ",,LD,X0,,,\n,,BMOV,D0,,,\n,,,D100,,,\n,,,K20,,,\n",
        tail: ",,END,,,,\n",
        ..KIND
    },
    Kind {
        name: "csv-utf16",
        file: "a.csv",
        command: "audit FILE",
        head: TABS,
        body: "\"\"\t\"\"\t\"LD\"\t\"X0\"\t\"\"\t\"\"\t\"\"\n\"\"\t\"\"\t\"OUT\"\t\"Y20\"\t\"\"\t\"\"\t\"\"\n",
        tail: "\"\"\t\"\"\t\"END\"\t\"\"\t\"\"\t\"\"\t\"\"\n",
        utf16: true,
        ..KIND
    },
    Kind { name: "c-coils", body: "LD 00000\nOUT 10000\n", ..C },
    Kind { name: "c-counters", body: "LD 00000\nLD 00001\nCNT 001 #0050\n", instructions: 3, ..C },
    Kind { name: "c-keeps", body: "LD 00000\nLD 00001\nKEEP(11) HR 0000\n", instructions: 3, ..C },
    Kind { name: "c-blocks", body: "LD 00000\nXFER(70) #0255 DM 0000 DM 0500\n", ..C },
    Kind {
        name: "c-interlocks",
        body: "LD 00000\nIL(02)\nLD 00001\nOUT 10001\nILC(03)\n",
        instructions: 5,
        ..C
    },
    Kind { name: "c-own-edges", body: "LD {n:b480}\nDIFU(13) {n:b3040}\n", ..C },
    Kind { name: "c-own-timers", body: "LD {n:b480}\nTIM {n:500} #0050\n", ..C },
    Kind { name: "c-own-moves", body: "LD {n:b480}\n@MOV(21) DM {n:1000} DM {n:999}\n", ..C },
    Kind {
        name: "c-own-comparisons",
        body: "LD {n:b480}\nCMP(20) DM {n:1000} #{n:9000}\nAND 25505\nOUT {n:b3040}\n",
        instructions: 4,
        ..C
    },
    Kind { name: "c-unknown", body: "LD 00000\nFOO 00001\n", code: 2, ..C },
    Kind { name: "cx-own-edges", body: "LD {n:c2240}\nDIFU(013) W{n:c8000}\n", ..CX },
    Kind { name: "cx-own-timers", body: "LD {n:c2240}\nTIM {n:4000} #0050\n", ..CX },
    Kind { name: "cx-own-sums", body: "LD {n:c2240}\n@++(590) D{n:30000}\n", ..CX },
    Kind { name: "cx-own-moves", body: "LD {n:c2240}\nMOV(021) D{n:30000} D{n:29999}\n", ..CX },
    Kind {
        name: "cx-own-comparisons",
        body: "LD {n:c2240}\nAND>(320) D{n:30000} &{n:60000}\nOUT W{n:c8000}\n",
        instructions: 3,
        ..CX
    },
    Kind { name: "cx-sums", body: "LD 0.00\n+(400) D1 D2 D3\n", ..CX },
    Kind { name: "cx-bits", body: "LD 0.00\nSETA(530) D0 #0 &4000\n", ..CX },
    Kind {
        name: "cx-loops",
        body: "FOR(512) &3\nLD 0.03\nOUT 100.00\nNEXT(513)\n",
        instructions: 4,
        ..CX
    },
    Kind {
        name: "cx-operands",
        head: "LD 0.00\nMOV(021)\n",
        body: "#1\n",
        instructions: 1,
        most: usize::MAX,
        code: 2,
        ..CX
    },
    Kind {
        name: "flowchart",
        file: "a.lst",
        command: "audit FILE",
        body: "LBL{n:9000}: AND {n:60}\n CJP LBL{n:9000}\n OUT 200\n GJ\n",
        head: "",
        tail: "JMP LBL1\n",
        instructions: 1,
        most: 9000,
        ..SIDE
    },
    Kind {
        name: "facts",
        file: "f.toml",
        command: "audit program.il --cpu Q26UDV --facts FILE",
        head: "[ranges]\n",
        body: "D{n} = [0, 10]\n",
        code: 0,
        ..SIDE
    },
    Kind {
        name: "table",
        file: "t.csv",
        command: "audit program.il --table FILE",
        head: "instruction,on_us,off_us,evidence,source\n",
        body: "FB{n},1.5,0.5,assumed,made up\n",
        code: 2,
        ..SIDE
    },
    Kind {
        name: "measurements",
        file: "m.csv",
        command: "compare words.asm FILE --fit",
        head: "scan,start_ms,scan_us\n",
        body: "{n},{n}.5,8448.1\n",
        code: 0,
        ..SIDE
    },
    Kind {
        name: "dump",
        file: "m.vcd",
        command: "compare words.asm FILE --signal scan",
        head: DUMP,
        body: "#{n}000\n1!\n#{n}500\n0!\n",
        code: 0,
        ..SIDE
    },
    Kind {
        name: "capture",
        file: "m.csv",
        command: "compare words.asm FILE --signal CH1 --threshold 0.8..2.0",
        head: "X,CH1,Start,Increment,\nSequence,Volt,-1.0e-03,1.0e-03,\n",
        body: "{n},0.1,\n",
        code: 2,
        ..SIDE
    },
    Kind {
        name: "stimulus",
        file: "s.csv",
        command: "emulate words.asm --stimulus FILE --scans 50",
        head: "time_s,X00,X01,X02,POWER\n",
        body: "0.{n},1,,,\n",
        code: 2,
        ..SIDE
    },
];

impl Kind {
    fn text(&self, size: usize) -> String {
        let mut text = self.head.to_owned();
        let (mut number, mut instructions) = (0, 0);
        let size = if self.utf16 { size / 2 } else { size };
        while text.len() < size && (self.most == 0 || instructions < self.most) {
            number += 1;
            instructions += self.instructions;
            numbered(&mut text, self.body, number);
        }
        text + self.tail
    }

    fn bytes(&self, size: usize) -> Vec<u8> {
        let text = self.text(size);
        if self.utf16 {
            let units = std::iter::once(0xFEFF).chain(text.encode_utf16());
            return units.flat_map(u16::to_le_bytes).collect();
        }
        text.into_bytes()
    }
}

/// Adds the lines with their numbers put in.
fn numbered(text: &mut String, body: &str, number: usize) {
    let mut pieces = body.split("{n");
    text.push_str(pieces.next().unwrap_or_default());
    for piece in pieces {
        let (how, rest) = piece.split_once('}').expect("a closing brace");
        let by = |digits: &str| digits.parse::<usize>().expect("a number");
        match how.strip_prefix(':') {
            None => write!(text, "{number}"),
            Some(how) => match how.split_at(1) {
                ("o", digits) => write!(text, "{:o}", number % by(digits)),
                ("x", digits) => write!(text, "{:X}", number % by(digits)),
                ("b", digits) => {
                    let bit = number % by(digits);
                    write!(text, "{:03}{:02}", bit / 16, bit % 16)
                }
                ("c", digits) => {
                    let bit = number % by(digits);
                    write!(text, "{}.{:02}", bit / 16, bit % 16)
                }
                _ => write!(text, "{}", number % by(how)),
            },
        }
        .expect("a string takes all");
        text.push_str(rest);
    }
}

#[test]
#[expect(clippy::print_stdout, reason = "what it took is told where it is measured")]
fn large_files_of_every_kind_end_within_their_memory() {
    let large = std::env::var_os("SCANBOUND_LARGE").is_some();
    let words =
        std::fs::read(concat!(env!("CARGO_MANIFEST_DIR"), "/samples/minasec-u/test-program.asm"));
    let words = words.expect("a sample");
    let mut faults = Vec::new();
    for kind in KINDS {
        let files = [
            (kind.file.to_owned(), kind.bytes(SIZES[usize::from(large)])),
            ("program.il".to_owned(), b"LD X0\nMOV K3 D0\nEND\n".to_vec()),
            ("words.asm".to_owned(), words.clone()),
        ];
        let command = kind.command.replace("FILE", kind.file);
        let mut arguments: Vec<String> = command.split(' ').map(str::to_owned).collect();
        if arguments[0] != "emulate" {
            arguments.extend(["--time-limit", "2s", "--jobs", "1"].map(str::to_owned));
        }
        let directory = tempfile::tempdir().expect("a directory");
        let run = run(&files, &arguments, directory.path());
        if large {
            let (seconds, megabytes) = (run.time.as_secs_f64(), run.memory >> 10);
            println!("{:22} exit {:?} {seconds:5.1} s {megabytes:5} MB", kind.name, run.code);
        }
        let ends = match large {
            true => matches!(run.code, Some(0..=3)) && run.memory <= KILOBYTES,
            false => run.code == Some(kind.code),
        };
        if !ends {
            faults.push(format!(
                "{}: exit {:?}, {} MB: {:.300}",
                kind.name,
                run.code,
                run.memory >> 10,
                run.told
            ));
        }
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}
