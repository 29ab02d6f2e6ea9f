//! Malformed inputs: samples of every dialect and of every other kind of file, changed at random.

use std::fs;
use std::ops::Range;
use std::path::Path;

/// A run: its files and its arguments.
pub struct Case {
    pub files: Vec<(String, Vec<u8>)>,
    pub arguments: Vec<String>,
    /// Whether the command searches for a bound where its input is sound.
    pub searches: bool,
}

/// Random numbers that depend only on the seed.
pub struct Random(u64);

impl Random {
    pub fn new(seed: u64) -> Random {
        Random(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15))
    }

    /// A number below `end`, which is not 0.
    fn below(&mut self, end: usize) -> usize {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        (z ^ (z >> 31)) as usize % end.max(1)
    }

    fn once_in(&mut self, times: usize) -> bool {
        self.below(times) == 0
    }

    fn pick<'a, T>(&mut self, all: &'a [T]) -> &'a T {
        &all[self.below(all.len())]
    }
}

/// A sample and the commands for it.
struct Sample {
    /// Name, and path or content. The first is the program.
    files: &'static [(&'static str, Source)],
    arguments: &'static [&'static str],
    /// The number of lines that are not changed.
    heading: usize,
    searches: bool,
}

enum Source {
    File(&'static str),
    Text(&'static str),
}

use Source::{File, Text};

const WORKS3: &str = "t\n\"Module Type Information:\",\"R08\"\n\"Step No.\",\"Line Statement\",\"Instruction\",\"I/O (Device)\",\"Blank\",\"P/I Statement\",\"Note\"\n\"0\",\"\",\"LD\",\"X0\",\"\",\"\",\"\"\n\"\",\"\",\"AND\",\"M1\",\"\",\"\",\"\"\n\"\",\"\",\"MOV\",\"K5 D0\",\"\",\"\",\"\"\n\"\",\"\",\"OUT\",\"Y20\",\"\",\"\",\"\"\n\"\",\"\",\"LD>\",\"D0 K7\",\"\",\"\",\"\"\n\"\",\"\",\"BMOV\",\"D0 D10 K4\",\"\",\"\",\"\"\n\"\",\"\",\"LDP\",\"X1\",\"\",\"\",\"\"\n\"\",\"\",\"INC\",\"D0\",\"\",\"\",\"\"\n\"\",\"\",\"END\",\"\",\"\",\"\",\"\"\n";
const C200H: &str = "LD 00000\nAND NOT 00001\nTIM 000 #0050\nOUT 10000\nLD TIM 000\nMOV(21) #0010 DM 0100\nINC(38) DM 0100\nLD NOT 00002\nCMP(20) DM 0100 #0100\nOUT 10001\nLD 25506\nBSET(71) #0000 DM 0000 DM 0010\nLD 00003\nLD 00004\nKEEP(11) HR 0000\nEND(01)\n";
const CX: &str = "LD 0.00\nANDNOT W0.01\nTIM 0 #0050\nOUT 100.00\nLD T0\nMOV(021) &10 D100\n++(590) D100\nLD>(320) D100 &50\nBSET(071) #0 D0 D10\nLD P_On\n+(400) D1 D2 D3\nFOR(512) &3\nLD 0.03\nXFER(070) &4 D0 D20\nNEXT(513)\nEND(001)\n";
const FX: &str = "LD M8000\nMOV K3 D0\nFOR K4\nLD X0\nINC D1\nNEXT\nLDP X1\nCALL P0\nLD> D1 K9\nOUT T0 K30\nLD T0\nMOV K4M0 D2\nLD X2\nMC N0 M10\nLD X3\nOUT Y0\nMCR N0\nFEND\nP0\nLD X4\nADD D0 K1 D3\nLD= D3 K7\nOUT Y1\nSRET\nEND\n";
const SCANS: &str = "scan,start_ms,scan_us\n1,0,8448.1\n2,8.4481,8447.9\n3,16.8960,8448.0\n";
const DUMP: &str = "$timescale 1 us $end\n$scope module m $end\n$var wire 1 ! scan $end\n$var real 64 \" level $end\n$upscope $end\n$enddefinitions $end\n#0\n0!\nr0.5 \"\n#10\n1!\nr3.5 \"\n#20\n0!\n#8458\n1!\n#8470\n0!\nr0.1 \"\n#16906\n1!\nr4.0 \"\n";
const SCOPE: &str = "X,CH1,Start,Increment,\nSequence,Volt,-1.0e-03,1.0e-03,\n0,0.1,\n1,4.9,\n2,0.2,\n9,0.1,\n10,4.8,\n";
const COMMENTS: &str =
    "\"Device Name\",\"Comment\"\n\"X0\",\"start\"\n\"M1\",\"mode\"\n\"D0\",\"count\"\n";
const FACTS: &str = "[ranges]\nD0 = [0, 10]\nD1 = [0, 100]\n[io]\ninputs = 32\noutputs = 16\n";
const ASM: &str = "samples/minasec-u/test-program.asm";

const SAMPLES: &[Sample] = &[
    Sample {
        files: &[
            ("MAIN.csv", File("samples/filler/MAIN.csv")),
            ("COMMENT.csv", File("samples/filler/COMMENT.csv")),
        ],
        arguments: &["audit", "."],
        heading: 3,
        searches: true,
    },
    Sample {
        files: &[
            ("SUB.csv", File("samples/filler/SUB.csv")),
            ("MAIN.csv", File("samples/filler/MAIN.csv")),
        ],
        arguments: &["check", "MAIN.csv", "SUB.csv", "--limit", "900us"],
        heading: 3,
        searches: true,
    },
    Sample {
        files: &[("a.csv", Text(WORKS3)), ("COMMENT.csv", Text(COMMENTS))],
        arguments: &["audit", ".", "--format", "json"],
        heading: 3,
        searches: true,
    },
    Sample {
        files: &[
            ("a.il", File("samples/paper/program.il")),
            ("table.csv", File("samples/paper/table.csv")),
        ],
        arguments: &["audit", "a.il", "--table", "table.csv"],
        heading: 0,
        searches: true,
    },
    Sample {
        files: &[
            ("table.csv", File("samples/paper/table.csv")),
            ("a.il", File("samples/paper/program.il")),
        ],
        arguments: &["audit", "a.il", "--table", "table.csv"],
        heading: 1,
        searches: true,
    },
    Sample {
        files: &[("a.il", File("samples/drives/drives.il"))],
        arguments: &["audit", "a.il", "--cpu", "Q26UDV"],
        heading: 0,
        searches: true,
    },
    Sample {
        files: &[("a.il", File("samples/sorter/sorter.il"))],
        arguments: &["check", "a.il", "--cpu", "Q03UD", "--limit", "300us"],
        heading: 0,
        searches: true,
    },
    Sample {
        files: &[("a.il", Text(FX)), ("facts.toml", Text(FACTS))],
        arguments: &["audit", "a.il", "--cpu", "FX3U", "--facts", "facts.toml"],
        heading: 0,
        searches: true,
    },
    Sample {
        files: &[("a.il", Text(FX))],
        arguments: &["audit", "a.il", "--cpu", "FX5U"],
        heading: 0,
        searches: true,
    },
    Sample {
        files: &[
            ("facts.toml", File("samples/transfer-line/facts.toml")),
            ("a.il", File("samples/transfer-line/line.il")),
        ],
        arguments: &[
            "check",
            "a.il",
            "--cpu",
            "Q26UDV",
            "--facts",
            "facts.toml",
            "--limit",
            "750us",
        ],
        heading: 0,
        searches: true,
    },
    Sample {
        files: &[("a.txt", Text(C200H))],
        arguments: &["audit", "a.txt", "--cpu", "C200H"],
        heading: 0,
        searches: true,
    },
    Sample {
        files: &[("a.txt", Text(CX))],
        arguments: &["audit", "a.txt", "--cpu", "CJ2M", "--format", "csv"],
        heading: 0,
        searches: true,
    },
    Sample {
        files: &[("a.cxt", File("samples/sorter/sorter.cxt"))],
        arguments: &["audit", "a.cxt", "--cpu", "CJ2M"],
        heading: 60,
        searches: true,
    },
    Sample {
        files: &[("a.asm", File(ASM))],
        arguments: &["audit", "a.asm", "--response"],
        heading: 0,
        searches: true,
    },
    Sample {
        files: &[("a.lst", File("samples/flowchart/traffic-signals.lst"))],
        arguments: &["audit", "a.lst"],
        heading: 0,
        searches: true,
    },
    Sample {
        files: &[("a.lst", File("samples/flowchart/star-delta-group.lst"))],
        arguments: &["check", "a.lst", "--limit", "500us"],
        heading: 0,
        searches: true,
    },
    Sample {
        files: &[
            ("s.csv", File("samples/minasec-u/test-program.stimulus.csv")),
            ("a.asm", File(ASM)),
        ],
        arguments: &["emulate", "a.asm", "--stimulus", "s.csv", "--scans", "50"],
        heading: 1,
        searches: false,
    },
    Sample {
        files: &[("m.csv", Text(SCANS)), ("a.asm", File(ASM))],
        arguments: &["compare", "a.asm", "m.csv", "--fit"],
        heading: 1,
        searches: true,
    },
    Sample {
        files: &[("m.vcd", Text(DUMP)), ("a.asm", File(ASM))],
        arguments: &["compare", "a.asm", "m.vcd", "--signal", "scan"],
        heading: 6,
        searches: true,
    },
    Sample {
        files: &[("m.csv", Text(SCOPE)), ("a.asm", File(ASM))],
        arguments: &["compare", "a.asm", "m.csv", "--signal", "CH1", "--threshold", "0.8..2.0"],
        heading: 2,
        searches: true,
    },
    Sample {
        files: &[("COMMENT.csv", Text(COMMENTS)), ("a.csv", Text(WORKS3))],
        arguments: &["audit", "."],
        heading: 1,
        searches: true,
    },
];

/// A case from a sample: its first file is changed, and repeated up to a size if one is given.
pub fn case(random: &mut Random, size: Option<usize>) -> Case {
    let sample = random.pick(SAMPLES);
    let mut files: Vec<(String, Vec<u8>)> =
        sample.files.iter().map(|(name, source)| ((*name).to_owned(), source.read())).collect();
    let text = String::from_utf8(files[0].1.clone());
    files[0].1 = match text {
        Ok(text) => {
            let mut lines: Vec<String> = text.lines().map(str::to_owned).collect();
            // Large files are changed less; otherwise almost none would be valid.
            for _ in 0..=random.below(if size.is_some() { 1 } else { 3 }) {
                change(&mut lines, sample.heading, random);
            }
            // Addresses out of order are refused, so most lists have no addresses.
            if !random.once_in(4) {
                lines.iter_mut().for_each(|line| *line = without_address(line));
            }
            if let Some(size) = size {
                lines = blown_up(&lines, sample.heading, size);
            }
            (lines.join("\n") + "\n").into_bytes()
        }
        Err(error) => error.into_bytes(),
    };
    if random.once_in(16) {
        damage(&mut files[0].1, random);
    }
    let mut arguments: Vec<String> = sample.arguments.iter().map(|&one| one.to_owned()).collect();
    if sample.arguments[0] != "emulate" {
        arguments.extend(["--time-limit", "2s", "--jobs", "1"].map(str::to_owned));
    }
    Case { files, arguments, searches: sample.searches }
}

impl Source {
    fn read(&self) -> Vec<u8> {
        match self {
            File(path) => {
                let path = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../..")).join(path);
                fs::read(path).expect("a sample")
            }
            Text(text) => text.as_bytes().to_vec(),
        }
    }
}

/// One change after the heading; most of them keep the program valid.
fn change(lines: &mut Vec<String>, heading: usize, random: &mut Random) {
    let heading = heading.min(lines.len().saturating_sub(1));
    if lines.len() < heading + 2 {
        return;
    }
    let body = lines.len() - heading;
    let (at, other) = (heading + random.below(body), heading + random.below(body));
    let rungs = rungs(lines, heading);
    let (rung, next) = (random.pick(&rungs).clone(), random.pick(&rungs).clone());
    match random.below(24) {
        // Changes a number: a device, a constant, a count, a label, a time.
        0..=11 => lines[at] = renumbered(&lines[at], random),
        12 | 13 => lines[at] = borrowed(&lines[at], &lines[other], random),
        // Copies, moves or deletes a rung.
        14..=16 => {
            let copy: Vec<String> = lines[rung].to_vec();
            let copies = if random.once_in(8) { 40 } else { 1 };
            for _ in 0..copies {
                lines.splice(next.start..next.start, copy.iter().cloned());
            }
        }
        17 | 18 => {
            let taken: Vec<String> = lines.drain(rung).collect();
            let to = (heading + random.below(body)).min(lines.len());
            if random.once_in(2) {
                lines.splice(to..to, taken);
            }
        }
        19 | 20 if rung.end <= next.start => {
            let taken: Vec<String> = lines.drain(rung.clone()).collect();
            let to = next.start - rung.len();
            lines.splice(to..to, taken);
        }
        // Changes that make most programs invalid.
        21 => lines.swap(at, other),
        22 => {
            lines.remove(at);
        }
        _ => {
            let line = lines[at].clone();
            lines.insert(other, line);
        }
    }
}

/// The rungs after the heading: each begins with a load instruction. If there is none, single lines.
fn rungs(lines: &[String], heading: usize) -> Vec<Range<usize>> {
    let loads = |line: &String| {
        let line = line.trim_start_matches(|c: char| c.is_ascii_digit() || " \t\",".contains(c));
        line.starts_with("LD")
    };
    let last = lines.len() - 1;
    let mut starts: Vec<usize> = (heading..last).filter(|&at| loads(&lines[at])).collect();
    if starts.is_empty() {
        starts = (heading..last).collect();
    }
    let ends = starts.iter().skip(1).copied().chain([last]);
    starts.iter().copied().zip(ends).map(|(from, to)| from..to.max(from)).collect()
}

/// The line without the address at its beginning: a number and a blank.
fn without_address(line: &str) -> String {
    let rest = line.trim_start().trim_start_matches(|c: char| c.is_ascii_digit());
    let is_address = rest.len() < line.trim_start().len() && rest.starts_with(' ');
    if is_address { rest.trim_start().to_owned() } else { line.to_owned() }
}

/// The line with one of its numbers changed.
fn renumbered(line: &str, random: &mut Random) -> String {
    let bytes = line.as_bytes();
    // The number of a function must match its name.
    let begins = |&at: &usize| {
        bytes[at].is_ascii_digit()
            && (at == 0 || !(bytes[at - 1].is_ascii_digit() || bytes[at - 1] == b'('))
    };
    let starts: Vec<usize> = (0..bytes.len()).filter(begins).collect();
    if starts.is_empty() {
        return line.to_owned();
    }
    let from = *random.pick(&starts);
    let length = bytes[from..].iter().take_while(|byte| byte.is_ascii_digit()).count();
    let old: u64 = line[from..from + length].parse().unwrap_or(0);
    let new = match random.below(30) {
        0..=2 => "0".to_owned(),
        3 => old.saturating_mul(10).to_string(),
        4 => random.pick(&["32767", "32768", "65535", "4294967295", "99999999999"]).to_string(),
        5 => format!("-{old}"),
        6..=11 => old.saturating_sub(1).to_string(),
        12..=20 => old.saturating_add(1).to_string(),
        _ => random.below(8).to_string(),
    };
    // OMRON's lists and lists with addresses have numbers of a fixed width.
    let padded = if bytes[from] == b'0' { format!("{new:0>length$}") } else { new };
    format!("{}{padded}{}", &line[..from], &line[from + length..])
}

/// The line with one of its words replaced by a word of another line.
fn borrowed(line: &str, other: &str, random: &mut Random) -> String {
    let separator = if line.contains(',') { ',' } else { ' ' };
    let mut words: Vec<&str> = line.split(separator).collect();
    let others: Vec<&str> = other.split(separator).collect();
    let at = random.below(words.len());
    let at = (0..words.len())
        .rev()
        .find(|&at| words[at].contains(|c: char| c.is_ascii_digit()))
        .unwrap_or(at);
    words[at] = others.get(at).copied().unwrap_or_else(|| others[random.below(others.len())]);
    words.join(&separator.to_string())
}

/// The lines after the heading except the last, repeated up to a size.
fn blown_up(lines: &[String], heading: usize, size: usize) -> Vec<String> {
    let heading = heading.min(lines.len().saturating_sub(1));
    let (head, body) = lines.split_at(heading);
    let Some((last, body)) = body.split_last() else { return lines.to_vec() };
    let length: usize = body.iter().map(|line| line.len() + 1).sum();
    let times = (size / length.max(1)).max(1);
    let mut all = head.to_vec();
    for _ in 0..times {
        all.extend_from_slice(body);
    }
    all.push(last.clone());
    all
}

/// Changes that no editor makes: a changed byte, a truncated file, inserted foreign bytes.
fn damage(bytes: &mut Vec<u8>, random: &mut Random) {
    if bytes.is_empty() {
        return;
    }
    let at = random.below(bytes.len());
    match random.below(4) {
        0 => bytes[at] = random.below(256) as u8,
        1 => bytes.truncate(at),
        2 => {
            let foreign: [&[u8]; 5] = [b"\xFF\xFE", b"\0\0\0", b"\"", b"\xE3\x81", b"\r\r\n\n"];
            let piece = random.pick(&foreign).to_vec();
            bytes.splice(at..at, piece);
        }
        _ => {
            let line: Vec<u8> =
                bytes.iter().map(|&byte| if byte == b'\n' { b' ' } else { byte }).collect();
            let length = line.len().min(2000);
            bytes.splice(at..at, line[..length].to_vec());
        }
    }
}
