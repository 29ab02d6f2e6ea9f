//! A small audit made by hand, which every renderer is tested on.

use super::method::SearchUse;
use super::*;
use scanbound_base::code::Code;
use scanbound_base::diagnostic::Diagnostic;
use scanbound_base::location::Location;
use scanbound_base::time::Picos;
use std::time::Duration;

fn us(time: u64) -> Picos {
    Picos(time * 1_000_000)
}

fn charge(line: u32, block: u32, instruction: &str, on: u64, off: u64, runs: bool) -> ChargeUse {
    ChargeUse {
        at: Location { file: u32::from(line > 99), line, step: Some(line * 2) },
        block,
        instruction: instruction.into(),
        via: Vec::new(),
        on: us(on),
        off: us(off),
        runs,
        reached: true,
        cost: us(if runs { on } else { off }),
        share: us(if runs { on } else { off }),
        routine: None,
        row: instruction.split(' ').next().unwrap_or_default().into(),
        evidence: if instruction.starts_with("BMOV") {
            Evidence::Assumed
        } else {
            Evidence::Published
        },
    }
}

fn rung(charge: &ChargeUse, fate: Fate, comments: &[&str]) -> RungUse {
    RungUse {
        block: charge.block,
        at: charge.at,
        instruction: charge.instruction.clone(),
        comments: comments.iter().map(|&comment| comment.to_owned()).collect(),
        others: 0,
        fate,
        is_charged_off: false,
        cost: charge.cost,
        naive: charge.on.max(charge.off),
        exclusion: None,
    }
}

fn tie(device: &str, comment: &str, uses: usize) -> Tie {
    Tie { device: device.to_owned(), comment: comment.to_owned(), uses }
}

fn free(name: &str, comment: &str, value: Value) -> FreeValue {
    FreeValue {
        name: name.to_owned(),
        comment: comment.to_owned(),
        value,
        at_start: true,
        matters: true,
        worth: us(40),
    }
}

/// The result of an audit of two files with Japanese comments: its first group is exact, its second is not.
pub fn fixture() -> Audit {
    let first = [
        charge(4, 2, "BMOV D200 D300 K10", 120, 2, true),
        charge(9, 3, "DMOV K0 D300", 30, 2, false),
    ];
    let mut looped = charge(120, 8, "FB1 D5", 70, 0, true);
    looped.via = vec!["FOR K2 (iteration 1)".to_owned()];
    looped.share = us(68);
    let second = [charge(104, 7, "FB0 D5", 50, 40, false), looped];
    let mut excluded = rung(&first[1], Fate::Excluded, &[]);
    excluded.cost = Picos::ZERO;
    excluded.exclusion =
        Some(Exclusion { blocks: vec![2], devices: vec!["X0".to_owned(), "D100".to_owned()] });
    let mut more = rung(&second[1], Fate::Runs, &[]);
    more.others = 2;
    Audit {
        files: vec!["搬送.csv".to_owned(), "sub.csv".to_owned()],
        standby: vec![1],
        sources: vec![
            Source {
                what: SourceKind::Program,
                name: "搬送.csv".to_owned(),
                date: None,
                sha256: "0f".repeat(32),
            },
            Source {
                what: SourceKind::Table,
                name: "qnudv".to_owned(),
                date: Some("2026-11-21".to_owned()),
                sha256: "1e".repeat(32),
            },
        ],
        dialect: "melsec-csv".to_owned(),
        cpu: Some("Q26UDV".to_owned()),
        instructions: 42,
        blocks: 9,
        clocked: None,
        table: TableUse {
            name: "qnudv".to_owned(),
            title: "QnUDV".to_owned(),
            is_all_assumed: false,
            notes: vec!["not included: communication".to_owned()],
            watchdog: Some(us(200_000)),
            factor: None,
            assumed: vec![AssumedUse {
                name: "BMOV".to_owned(),
                row: "@block".to_owned(),
                by_class: true,
                count: 1,
                time: us(120),
                part: us(120),
            }],
            assumed_time: us(120),
            assumed_share: Share::of(us(120), us(442)),
        },
        bound: Bound {
            upper: Picos(452_500_000),
            lower: us(442),
            model: us(442),
            naive: Picos(492_500_000),
            always: us(12),
            overhead: us(200),
            groups: Picos(240_500_000),
        },
        cycle: super::Cycle::default(),
        holds_interrupts: false,
        watchdog: super::Watchdog {
            default: Some(us(200_000)),
            least: Some(us(200_000)),
            ..super::Watchdog::default()
        },
        overhead: vec![OverheadUse {
            name: "@end".to_owned(),
            time: us(200),
            evidence: Evidence::Published,
            why: "END processing".to_owned(),
        }],
        always: vec![charge(1, 1, "LD SM400", 12, 12, true)],
        groups: vec![
            GroupUse {
                id: 1,
                blocks: vec![2, 3],
                devices: vec!["X0".to_owned(), "D100".to_owned()],
                ties: vec![tie("D100", "工程番号", 4), tie("X0", "起動", 2)],
                upper: us(122),
                lower: us(122),
                naive: us(150),
                solver_calls: 5,
                rungs: vec![rung(&first[0], Fate::Runs, &["D200 レシピ", "D300 設定値"]), excluded],
                charges: first.into(),
                search: SearchUse::by(Engine::Subsets),
            },
            GroupUse {
                id: 2,
                blocks: vec![7, 8],
                devices: vec!["X1F".to_owned()],
                ties: vec![tie("X1F", "", 2)],
                upper: Picos(118_500_000),
                lower: us(108),
                naive: us(120),
                solver_calls: 9,
                rungs: vec![more, rung(&second[0], Fate::Partly, &[])],
                charges: second.into(),
                search: SearchUse::by(Engine::Cores),
            },
        ],
        witness: vec![
            free("D100", "工程番号", Value::Word(-10)),
            free("X0", "起動", Value::Bit(true)),
            FreeValue { matters: false, worth: us(0), ..free("X1F", "", Value::Bit(false)) },
            FreeValue { at_start: false, ..free("T0 contact", "遅延", Value::Bit(true)) },
        ],
        weighed: us(442),
        witness_run: vec![
            RunScan { number: 1, inputs: Vec::new(), took: us(40) },
            RunScan { number: 2, inputs: vec![("X0".to_owned(), Value::Bit(true))], took: us(185) },
        ],
        needed_devices: Vec::new(),
        stands_between: None,
        path: Vec::new(),
        unbounded: Vec::new(),
        facts: vec![Fact::Range { word: "D100".to_owned(), low: -10, high: 10, is_kept: false }],
        points: Vec::new(),
        bases: Vec::new(),
        networks: Vec::new(),
        doubts: vec![Doubt::Interrupts { name: "I0".to_owned(), taken: 1 }],
        assumptions: vec![Assumption {
            most: 0,
            devices: vec!["D60".to_owned()],
            range: Some((0, 19)),
            values: Vec::new(),
            without: None,
            written: vec![(Location { file: 0, line: 5, step: None }, "MOV K19 D60".into())],
        }],
        unknowns: vec![Unknown {
            word: "D50".into(),
            places: vec![(Location { file: 0, line: 6, step: None }, "BMOV D0 D100 D50".into())],
            kind: UnknownKind::Count(Counts {
                most: 65_535,
                each: Picos(40_000),
                cost: Picos(452_500_000),
            }),
            key: "a.il:6".to_owned(),
            fact: "\"a.il:6\" = [0, 20]".to_owned(),
        }],
        what_if: None,
        coactivity: None,
        bounded_task: None,
        tasks: Vec::new(),
        net: None,
        ladder: None,
        readings: Vec::new(),
        approximations: [
            (7, "MOV K1 D300Z0", "an indexed device is written: any D may have changed"),
            (8, "MOV K1 D301Z0", "an indexed device is written: any D may have changed"),
            (9, "MUL D1 D2 D3", "everything that MUL writes may have any value"),
            (11, "BCD D1 D2", "everything that BCD writes may have any value"),
        ]
        .map(|(line, instruction, what)| ApproximationUse {
            at: Location { file: 0, line, step: None },
            instruction: instruction.into(),
            what: what.into(),
        })
        .into(),
        exactness: None,
        warnings: vec![
            Diagnostic::file(Code::LeftOut, "搬送.csv", "no comments", "export COMMENT.csv")
                .warning(),
        ],
        response: None,
        trust: scanbound_passes::values::Trust::None,
        ended_early: false,
        cuts: Vec::new(),
        named: String::new(),
        elapsed: Duration::from_millis(1_250),
    }
}
