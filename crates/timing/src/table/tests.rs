//! Tests of reading tables and of the tables that come with the program.

use std::collections::BTreeSet;

use super::*;
use scanbound_base::diagnostic::{Diagnostic, Severity};

const HEAD: &str = "instruction,on_us,off_us\n";

fn parse(text: &str) -> Table {
    Table::parse("t.csv", text.as_bytes()).unwrap().table
}

fn faults(text: &str) -> Vec<Diagnostic> {
    Table::parse("t.csv", text.as_bytes()).unwrap_err()
}

/// The message of the only fault that this row causes.
fn fault(row: &str) -> String {
    let found = faults(&format!("{HEAD}{row}\n"));
    assert_eq!(found.len(), 1, "{found:?}");
    assert_eq!((found[0].file.as_str(), found[0].line), ("t.csv", Some(2)));
    assert_eq!(found[0].text, row);
    assert!(!found[0].help.is_empty());
    found[0].message.clone()
}

#[test]
fn rows_are_read_exactly_and_an_empty_off_time_is_the_on_time() {
    let table = parse(
        "\u{feff}# a comment, with a \"quote\r\ninstruction , ON_US,off_us,per_unit_us,unit,evidence,source\r\n\
         MOV,1.52,,,,published,\"Manual, p. 3\"\r\n\r\n  # another\r\nBMOV, 107.5 ,6.4,1.7,word,measured,\r\nSwOp0,0,5\r\n",
    );
    let mov = table.row("mov").unwrap();
    assert_eq!((mov.on, mov.off, mov.per_unit), (Picos(1_520_000), Picos(1_520_000), Picos(0)));
    assert_eq!((mov.evidence, mov.source.as_str()), (Evidence::Published, "Manual, p. 3"));
    let bmov = table.row("BMOV").unwrap();
    assert_eq!((bmov.off, bmov.per_unit), (Picos(6_400_000), Picos(1_700_000)));
    assert_eq!(bmov.unit, "word");
    assert_eq!(table.row("SwOp0").unwrap().evidence, Evidence::Stated);
    assert_eq!(table.row("SwOp0").unwrap().on, Picos(0));
    assert!(table.knows("SwOp0") && !table.knows("MOVP") && !table.knows("@end"));
}

#[test]
fn a_faulty_row_is_told_with_its_line_and_what_to_do() {
    assert_eq!(fault("MOV,-1,2"), "on_us is -1: a time cannot be negative");
    assert_eq!(fault("MOV,1,-2"), "off_us is -2: a time cannot be negative");
    assert_eq!(fault("MOV,,2"), "on_us is missing");
    assert_eq!(fault("MOV"), "on_us is missing");
    assert_eq!(fault("MOV,fast,2"), "on_us is 'fast': not a decimal number");
    assert_eq!(fault("MOV,1e3,2"), "on_us is '1e3': not a decimal number");
    assert_eq!(fault("MOV,1.5us,2"), "on_us is '1.5us': not a decimal number");
    assert_eq!(fault("MOV,0.0000001,2"), "on_us is '0.0000001': finer than a picosecond");
    assert!(fault("MOV,10000000.1,2").contains("at most 10 s"));
    assert!(fault("MOV,99999999999999999999,2").contains("at most 10 s"));
    assert_eq!(fault("MOV,0,08,0,08"), "the row has 5 fields, but the table has 3 columns");
    assert_eq!(fault("\"MOV,1,2"), "a double quote is not closed");
    assert_eq!(fault(",1,2"), "the row has no instruction");
    assert_eq!(fault("@ned,1,"), "'@ned' is not a known @ row");
    assert_eq!(fault("@+,1,"), "'@+' is not a known @ row");
    assert_eq!(
        fault("@end,1,2"),
        "the row @end takes only one time, in on_us, but its column off_us is not empty"
    );
    assert_eq!(fault("@factor,0.9,"), "the factor '0.9' is not a decimal from 1 to 10");
    assert_eq!(fault("@factor,,"), "the factor '' is not a decimal from 1 to 10");
    assert_eq!(fault("@family,s7,"), "'s7' is not a CPU family that scanbound knows");
    assert_eq!(fault("@base,fx9,"), "there is no built-in table 'fx9' to amend");
    assert_eq!(
        fault("@max-inputs,4k,"),
        "'4k' in the row @max-inputs is not a number of points up to 65536"
    );
    assert_eq!(
        fault("@max-outputs,65537,"),
        "'65537' in the row @max-outputs is not a number of points up to 65536"
    );
    assert_eq!(
        fault("@max-outputs,,"),
        "'' in the row @max-outputs is not a number of points up to 65536"
    );
    for bad in ["today", "2026-13-01", "2026-1-01", "26-01-01", "2026-01-32", "2026-01-+1"] {
        assert_eq!(fault(&format!("@date,{bad},")), format!("'{bad}' is not a date"));
    }
    assert_eq!(
        fault("@title,one,two"),
        "the row @title must have a text in the column on_us, and nothing in the column off_us"
    );
}

#[test]
fn evidence_is_one_of_four_words() {
    let found = faults("instruction,on_us,off_us,evidence\nMOV,1,,guessed\n");
    assert_eq!(found[0].message, "'guessed' is not a kind of evidence");
    assert_eq!(found[0].span, Some((7, 14)));
    let head = "instruction,on_us,off_us,evidence\n";
    assert_eq!(
        parse(&format!("{head}A,1,,MEASURED\n")).row("A").unwrap().evidence,
        Evidence::Measured
    );
}

#[test]
fn all_faults_of_a_table_are_told_at_once() {
    let found = faults(&format!("{HEAD}A,-1,\nB,1,\nb,2,\nC,x,y\n@end,,\n"));
    let lines: Vec<_> = found.iter().map(|f| (f.code.name(), f.line.unwrap())).collect();
    assert_eq!(
        lines,
        [
            ("table-time", 2),
            ("table-duplicate", 4),
            ("table-time", 5),
            ("table-time", 5),
            ("table-time", 6)
        ]
    );
    assert_eq!(found[1].message, "b has a second row here: the first one is in line 3");
}

#[test]
fn a_table_without_its_columns_or_rows_is_refused() {
    let found = faults("instruction;on_us;off_us\nMOV;1;2\n");
    assert_eq!(found.len(), 1);
    assert_eq!(
        found[0].message,
        "the first line of the table lacks the columns instruction, on_us, off_us"
    );
    assert_eq!(
        faults("instruction,on_us\nA,1\n")[0].message,
        "the first line of the table lacks the column off_us"
    );
    assert_eq!(
        faults("instruction,on_us,on_us,off_us\n")[0].message,
        "the column on_us occurs twice"
    );
    assert_eq!(faults("")[0].message, "the table is empty");
    assert_eq!(faults("\n# only this\n")[0].message, "the table is empty");
    assert_eq!(faults(HEAD)[0].message, "the table has no rows");
    let latin = Table::parse("t.csv", b"instruction,on_us,off_us\nMOV,1,\xe9\n").unwrap_err();
    assert_eq!((latin[0].code.name(), latin[0].line), ("table-encoding", Some(2)));
    assert_eq!(latin[0].text, "MOV,1,");
}

#[test]
fn garbage_of_any_length_ends_in_a_list_of_bounded_length() {
    let found = faults(&format!("{HEAD}{}", "\u{1}garbage,x,,,\"\n".repeat(100_000)));
    assert_eq!(found.len(), 1001);
    assert_eq!(found[1000].message, "99000 more errors are not listed");
    let found = faults(&"no table at all \u{7}\u{0}\n".repeat(100_000));
    assert_eq!(found.len(), 1);
    let found = faults(&"x".repeat(1_000_000));
    assert_eq!((found.len(), found[0].text.len()), (1, 200));
}

#[test]
fn an_unknown_column_is_warned_about_and_not_used() {
    let text = "instruction,on_us,off_us,colour\nMOV,1,2,red\n";
    let parsed = Table::parse("t.csv", text.as_bytes()).unwrap();
    assert_eq!(parsed.warnings.len(), 1);
    assert_eq!(parsed.warnings[0].severity, Severity::Warning);
    assert_eq!(parsed.warnings[0].message, "the column 'colour' is unknown and ignored");
    assert_eq!(parsed.table.row("MOV").unwrap().off, Picos(2_000_000));
}

#[test]
fn a_table_may_amend_a_built_in_one() {
    let table = parse(&format!(
        "{HEAD}@base,QnUDV,\nMOV,7,\nSwOp0,50,1\n@factor,1.5,\n@max-inputs,64,\n@note,\"mine, too\",\n"
    ));
    let base = Table::builtin("qnudv").unwrap();
    assert_eq!((table.name.as_str(), table.base.as_deref()), ("t.csv", Some("qnudv")));
    assert_eq!(table.row("LD"), base.row("LD"));
    assert_eq!(table.row("MOV").unwrap().on, Picos(7_000_000));
    assert_eq!(table.row("MOV").unwrap().table, "t.csv");
    assert_eq!(table.rows().len(), base.rows().len() + 1);
    assert_eq!((table.family, table.cpus), (base.family, base.cpus));
    assert_eq!(table.factor.unwrap().text, "1.5");
    assert_eq!(table.most_inputs.unwrap().points, 64);
    assert_eq!(table.most_outputs, base.most_outputs);
    assert_eq!(table.notes.last().unwrap(), "mine, too");
    assert_eq!(table.notes.len(), base.notes.len() + 1);
}

#[test]
fn the_factor_rounds_up() {
    let table = parse(&format!("{HEAD}@factor,1.000001,\n"));
    assert_eq!(table.scaled(Picos(0)), Some(Picos(0)));
    assert_eq!(table.scaled(Picos(1)), Some(Picos(2)));
    assert_eq!(table.scaled(Picos(1_000_000)), Some(Picos(1_000_001)));
    assert_eq!(table.scaled(Picos(1_000_001)), Some(Picos(1_000_003)));
    assert_eq!(table.scaled(Picos(u64::MAX)), None);
}

#[test]
fn prices_from_the_command_line_are_read_exactly() {
    let read = |text: &str| parse_override(text).map(|o| (o.name, o.on, o.off));
    let us = |n: u64| Picos(n * 1_000_000);
    assert_eq!(read("MOV=12.5us"), Ok(("MOV".into(), Picos(12_500_000), Picos(12_500_000))));
    assert_eq!(read("MOV=12 us / 300ns"), Ok(("MOV".into(), us(12), Picos(300_000))));
    assert_eq!(read("LD==1us"), Ok(("LD=".into(), us(1), us(1))));
    assert_eq!(read("AND<>=1us"), Ok(("AND<>".into(), us(1), us(1))));
    assert_eq!(read("D/=1us/2us"), Ok(("D/".into(), us(1), us(2))));
    for bad in ["MOV", "=1us", "MOV=", "MOV=1", "MOV=-1us", "MOV=1us/", "@end=1us", "MOV=11s"] {
        assert!(read(bad).unwrap_err().contains("write NAME=12.5us"), "{bad}");
    }
}

#[test]
fn every_table_file_is_registered_and_reads() {
    let directory = concat!(env!("CARGO_MANIFEST_DIR"), "/../../timing-tables");
    let files: BTreeSet<String> = std::fs::read_dir(directory)
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    let registered: BTreeSet<String> =
        builtin::names().iter().map(|name| format!("{name}.csv")).collect();
    assert_eq!(files, registered);
    for name in builtin::names() {
        let parsed = Table::parse(name, builtin::text(name).unwrap().as_bytes()).unwrap();
        assert_eq!(parsed.warnings, []);
        assert_eq!(Table::builtin(name).as_ref(), Some(&parsed.table));
    }
}

#[test]
fn every_built_in_table_is_complete_and_says_where_its_times_come_from() {
    for name in builtin::names() {
        let table = Table::builtin(name).unwrap();
        assert!(!table.title.is_empty() && !table.cpus.is_empty(), "{name}");
        let date = builtin::dates().find(|(own, _)| *own == name).map(|(_, date)| date);
        assert!(date.is_some() && date == table.date.as_deref(), "{name}: {date:?}");
        for row in table.rows() {
            assert!(!row.source.is_empty(), "{name}: {}", row.name);
            assert_ne!(row.evidence, Evidence::Stated, "{name}: {}", row.name);
        }
    }
}

/// The built-in tables of MELSEC CPUs: those with a family.
fn melsec() -> impl Iterator<Item = (&'static str, Table)> {
    let tables = builtin::names().into_iter().map(|name| (name, Table::builtin(name).unwrap()));
    tables.filter(|(_, table)| table.family.is_some())
}

#[test]
fn only_machines_without_classes_have_no_family() {
    let without = builtin::names().len() - melsec().count();
    assert_eq!(without, 3);
    for name in ["minasec-u", "flowchart-pc", "iec"] {
        assert_eq!(Table::builtin(name).unwrap().family, None);
    }
}

#[test]
fn every_melsec_table_has_a_time_for_every_class() {
    for (name, table) in melsec() {
        for class in CLASSES {
            assert!(table.row(&format!("@{class}")).is_some(), "{name}: @{class}");
        }
        for most in [&table.most_inputs, &table.most_outputs] {
            let most = most.as_ref().unwrap();
            assert!(most.points >= 240 && !most.source.is_empty(), "{name}");
        }
        for class in ["block", "string", "search", "module"] {
            assert!(
                table.row(&format!("@{class}")).unwrap().per_unit > Picos::ZERO,
                "{name}: @{class}"
            );
        }
        for needed in ["@end", "@watchdog", "@interrupt-entry", "@+indexed", "@+digits", "@+module"]
        {
            assert!(table.row(needed).is_some(), "{name}: {needed}");
        }
    }
}

#[test]
fn assumed_classes_have_large_times() {
    for (name, table) in melsec() {
        let load = table.row("LD").unwrap().on;
        let moved = table.row("MOV").unwrap().on;
        for class in CLASSES {
            let row = table.row(&format!("@{class}")).unwrap();
            let least = if matches!(class, "contact" | "stack" | "nothing") { load } else { moved };
            assert!(row.on >= least, "{name}: @{class}");
            // Even an instruction that does nothing has a few steps to skip.
            assert!(row.off >= load, "{name}: @{class}");
        }
    }
}

#[test]
fn a_cpus_name_finds_its_table() {
    for (cpu, table) in [
        ("Q26UDV", "qnudv"),
        ("Q13UDV", "qnudv"),
        ("Q03UDVCPU", "qnudv"),
        ("Q06UDEH", "qnudeh"),
        ("q26udh", "qnudeh"),
        ("Q02H", "q02h"),
        ("Q02(H)", "q02"),
        ("FX3U/FX3UC", "fx3u"),
        ("FX3U(C)", "fx3u"),
        ("FX2N(C)", "fx2n"),
        ("FX5U", "fx5u"),
        ("L26-BT", "l26"),
        ("L26CPU-BT", "l26"),
        ("L02", "l02"),
        ("R08", "iqr"),
        ("MINASEC-U", "minasec-u"),
        ("CJ2M-CPU31", "cj2m"),
        ("cj2m-cpu11", "cj2m"),
        ("CJ2M_CPU35", "cj2m"),
        ("OMRON CJ2M-CPU31", "cj2m"),
        ("CJ2M CPU31", "cj2m"),
        ("CP1L-M40", "cp1l"),
        ("CP1L-M40DR-A", "cp1l"),
        ("CP1L M", "cp1l"),
        ("C200H-CPU01-E", "c200h"),
        ("FX3U-32MR/ES", "fx3u"),
        ("FX3UC-16MT/D", "fx3u"),
        ("FX2N-48MR", "fx2n"),
        ("FX5U-32MT/ESS", "fx5u"),
        ("MELSEC-Q Q26UDVCPU", "qnudv"),
        ("MELSEC iQ-R R08CPU", "iqr"),
        ("L26CPU-PBT", "l26"),
    ] {
        assert_eq!(Table::for_cpu(cpu), Some(table), "{cpu}");
    }
    for cpu in [
        "FX3G",
        "FX3G-40MR",
        "Q00J",
        "S7-1200",
        "",
        "CPU",
        "-",
        "-CPU",
        "Q",
        "UDV",
        "C200HE-CPU42",
        "C200HX",
        "CJ1M-CPU11",
        "CP1H-X40",
    ] {
        assert_eq!(Table::for_cpu(cpu), None, "{cpu}");
    }
    assert!(Table::advice("FX3G").contains("similar names: FX3U (table fx3u), FX3UC (table fx3u)"));
    assert!(!Table::advice("S7-1200").contains("nearest"));
}

#[test]
fn no_cpu_has_two_tables() {
    let mut seen = BTreeSet::new();
    for table in builtin::list() {
        for cpu in table.cpus {
            assert!(seen.insert(cpu.clone()), "{cpu}");
        }
        assert!(table.rows.iter().any(|(_, count)| *count > 0));
    }
}

#[test]
fn published_times_are_below_the_class_that_stands_for_their_like() {
    let table = Table::builtin("iqr").unwrap();
    let clock = table.row("@clock").unwrap();
    let published = table.rows().iter().filter(|row| row.evidence == Evidence::Published);
    let instructions: Vec<_> = published.filter(|row| !row.name.starts_with('@')).collect();
    assert_eq!(instructions.len(), 10);
    for row in instructions {
        assert!(row.on <= clock.on, "{}", row.name);
    }
}

#[test]
fn what_was_not_read_on_a_page_is_not_published() {
    let c200h = Table::builtin("c200h").unwrap();
    for row in c200h.rows().iter().filter(|row| !row.name.starts_with('@')) {
        assert_eq!(row.evidence, Evidence::Assumed, "{}", row.name);
    }
    for name in builtin::names() {
        let table = Table::builtin(name).unwrap();
        for row in table.rows().iter().filter(|row| row.evidence == Evidence::Published) {
            let told = row.source.contains("not at hand") || row.source.contains("recalled");
            assert!(!told && !row.source.is_empty(), "{name}: {}", row.name);
        }
    }
}

#[test]
fn unstated_refresh_is_that_of_the_slowest_base() {
    for name in builtin::names() {
        let table = Table::builtin(name).unwrap();
        for kind in ["@input16", "@output16", "@input8", "@output8", "@input", "@output"] {
            let Some(plain) = table.row(kind) else { continue };
            let own = |row: &&Row| row.name.starts_with(&format!("{kind}:"));
            for row in table.rows().iter().filter(own) {
                assert!(row.on <= plain.on, "{name}: {}", row.name);
            }
        }
    }
    for (name, input, output) in [("q00u", 5.7, 4.9), ("q02u", 5.3, 4.9), ("qnudv", 5.0, 4.8)] {
        let table = Table::builtin(name).unwrap();
        for (kind, us) in [("@input16", input), ("@output16", output)] {
            assert_eq!(table.row(kind).map(|row| row.on.0 as f64 / 1e6), Some(us), "{name}");
        }
    }
}

#[test]
fn the_field_itself_is_marked_and_odd_columns_are_told_of_a_few_times() {
    let text = "instruction,on_us,off_us,unit\n1x,2,1x,1x\n";
    let faults = Table::parse("own.csv", text.as_bytes()).expect_err("no time");
    assert_eq!(faults[0].span, Some((5, 7)));
    let odd: String = (0..500).map(|n| format!(",c{n}")).collect();
    let text = format!("instruction,on_us,off_us{odd}\nLD,1,1\n");
    let warnings = Table::parse("own.csv", text.as_bytes()).expect("a table").warnings;
    assert_eq!(warnings.len(), 21);
    assert!(warnings[20].message.starts_with("and 480 further columns"));
}
