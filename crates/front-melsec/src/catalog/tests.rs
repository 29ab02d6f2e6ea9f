//! Tests of the catalog.

use super::*;
use crate::memory;

/// The timing classes that catalog rows may have.
const CLASSES: [&str; 28] = [
    "compare",
    "compare-double",
    "compare-real",
    "compare-string",
    "pulse",
    "move",
    "move-double",
    "arithmetic",
    "arithmetic-double",
    "multiply",
    "multiply-double",
    "divide",
    "divide-double",
    "real",
    "logic",
    "logic-double",
    "conversion",
    "shift",
    "bit",
    "block",
    "string",
    "search",
    "table",
    "clock",
    "module",
    "dedicated",
    "nothing",
    "special",
];

fn found(mnemonic: &str, operands: usize) -> (String, bool) {
    let found = find(mnemonic, operands).expect("is in the catalog");
    (found.entry.mnemonic.to_string(), found.pulsed)
}

fn entries() -> impl Iterator<Item = &'static Entry> {
    CATALOG.all()
}

#[test]
fn the_rows_of_a_mnemonic_differ_in_their_operands() {
    for name in CATALOG.names() {
        let rows = CATALOG.rows(name).unwrap();
        let mut counts = counts(rows);
        counts.dedup();
        assert_eq!(counts.len(), rows.len(), "{name}");
        assert!(rows.iter().all(|row| !row.optional), "{name}: a form has its row here");
    }
}

#[test]
fn what_counts_is_a_number() {
    for entry in entries() {
        let counters = entry.operands.iter().filter_map(|it| it.extent.amount().counter());
        for counter in counters.chain(entry.units) {
            assert_eq!(entry.operands[counter].role, Role::Number, "{}", entry.mnemonic);
        }
    }
}

#[test]
fn every_row_is_well_formed() {
    assert!(CATALOG.names().count() > 500);
    for entry in entries() {
        assert!(CLASSES.contains(&entry.class), "{}: {}", entry.mnemonic, entry.class);
        let writes = entry.operands.iter().any(|it| {
            matches!(
                it.role,
                Role::Destination | Role::ReadWrite | Role::ReadWriteIfDevice | Role::Extra(Axis)
            )
        });
        let silent = matches!(entry.meaning, InstructionEffect::Nothing | InstructionEffect::Free);
        assert_eq!(writes || !entry.also.is_empty(), !silent, "{}", entry.mnemonic);
    }
}

#[test]
fn exact_operations_have_the_operands_they_need() {
    for entry in entries() {
        let roles: Vec<Role> = entry.operands.iter().map(|it| it.role).collect();
        let fits = match entry.meaning {
            InstructionEffect::Havoc
            | InstructionEffect::HavocAlways
            | InstructionEffect::HavocAnytime
            | InstructionEffect::Nothing
            | InstructionEffect::Free => true,
            InstructionEffect::Add
            | InstructionEffect::Subtract
            | InstructionEffect::WordAnd
            | InstructionEffect::WordOr
            | InstructionEffect::WordXor
            | InstructionEffect::WordXnr => {
                let extents = entry.operands.windows(2).all(|two| two[0].extent == two[1].extent);
                extents
                    && matches!(
                        roles[..],
                        [Role::Source, Role::ReadWrite]
                            | [Role::Source, Role::Source, Role::Destination]
                    )
            }
            InstructionEffect::Copy | InstructionEffect::WordNot => {
                entry.operands[0].extent == entry.operands[1].extent
                    && roles.starts_with(&[Role::Source, Role::Destination])
            }
            InstructionEffect::Fill => roles == [Role::Source, Role::Destination, Role::Number],
            InstructionEffect::Exchange => roles.starts_with(&[Role::ReadWrite, Role::ReadWrite]),
            InstructionEffect::Increment
            | InstructionEffect::Decrement
            | InstructionEffect::Negate
            | InstructionEffect::Swap
            | InstructionEffect::ShiftOne
            | InstructionEffect::Alternate => roles == [Role::ReadWrite],
            InstructionEffect::Clear => roles == [Role::Destination, Role::Number],
            InstructionEffect::ClearRange => roles == [Role::Destination, Role::Destination],
            InstructionEffect::SlideUp | InstructionEffect::SlideDown => {
                let amount = entry.operands[0].extent.amount();
                roles == [Role::ReadWrite, Role::Number]
                    && amount == Amount::Counted { unit: 1, operand: 1 }
            }
            InstructionEffect::Pairwise => {
                roles == [Role::Source, Role::Source, Role::Destination, Role::Number]
                    && entry.operands[0].extent == entry.operands[1].extent
            }
            InstructionEffect::Text => {
                roles == [Role::Source, Role::Destination]
                    && entry.operands.iter().all(|it| it.extent == Extent::Text)
            }
            InstructionEffect::Order => {
                roles == [Role::Source, Role::Source, Role::Destination]
                    && entry.operands[0].extent == entry.operands[1].extent
                    && entry.operands[2].extent == Extent::Bits(Amount::Fixed(3))
            }
            InstructionEffect::SetBit | InstructionEffect::ResetBit => {
                roles == [Role::ReadWrite, Role::Number]
            }
        };
        assert!(fits, "{} {:?}", entry.mnemonic, entry.meaning);
    }
}

#[test]
fn a_pulse_form_is_found_under_its_base() {
    for (written, operands, base, pulsed) in [
        ("MOV", 2, "MOV", false),
        ("MOVP", 2, "MOV", true),
        ("+P", 2, "+", true),
        ("D+P", 3, "D+", true),
        ("$MOVP", 2, "$MOV", true),
        ("DINCP_U", 1, "DINC_U", true),
        ("SWAP", 1, "SWAP", false),
        ("SWAPP", 1, "SWAP", true),
        ("CMP", 3, "CMP", false),
        ("ZCPP", 4, "ZCP", true),
    ] {
        assert_eq!(found(written, operands), (base.to_owned(), pulsed), "{written}");
    }
    assert!(matches!(find("SORTP", 5), Err(NotFound::Unknown)));
}

#[test]
fn extents_count_by_operands() {
    let bmov = find("BMOV", 3).unwrap().entry;
    let counted = Extent::Words(Amount::Counted { unit: 1, operand: 2 });
    assert_eq!(bmov.operands[0], Operand { role: Role::Source, extent: counted });
    assert_eq!(bmov.operands[1], Operand { role: Role::Destination, extent: counted });
    assert_eq!((bmov.units, bmov.unit_size, bmov.most_units), (Some(2), 1, None));
    let dfmov = find("DFMOV", 3).unwrap().entry;
    assert_eq!((dfmov.units, dfmov.unit_size), (Some(2), 2));
    assert_eq!(find("BINDA", 2).unwrap().entry.most_units, Some(6));
    let product = find("D*", 3).unwrap().entry;
    assert_eq!(product.operands[2].extent, Extent::Words(Amount::Fixed(4)));
}

#[test]
fn destinations_reach_as_far_as_the_manuals_say() {
    for (mnemonic, operands, number, extent) in [
        ("MAX", 3, 2, Extent::Words(Amount::Fixed(3))), // value, position, how many
        ("DMAX", 3, 2, Extent::Words(Amount::Fixed(4))),
        ("/", 3, 3, Extent::Words(Amount::Fixed(2))), // quotient, remainder
        ("D/", 3, 3, Extent::Words(Amount::Fixed(4))),
        ("DATERD", 1, 1, Extent::Words(Amount::Fixed(7))),
        ("CMP", 3, 3, Extent::Bits(Amount::Fixed(3))),
        ("BINDA", 2, 2, Extent::Words(Amount::Fixed(4))), // sign, five digits, NUL
        ("DBINDA", 2, 2, Extent::Words(Amount::Fixed(6))),
        ("DECO", 3, 2, Extent::Bits(Amount::Power { operand: 2 })),
        ("BKRST", 2, 1, Extent::Devices(Amount::Counted { unit: 1, operand: 1 })),
        ("ZP.OPEN", 4, 4, Extent::Bits(Amount::Fixed(2))), // done, failed
        ("SER", 4, 3, Extent::Words(Amount::Fixed(5))),    // how many, first, last, least, greatest
        ("DSER", 4, 3, Extent::Words(Amount::Fixed(10))),
        ("TYPERD", 2, 2, Extent::Words(Amount::Fixed(10))),
        ("PRUN", 2, 2, Extent::Words(Amount::Fixed(2))), // M0 to M17 for sixteen bits
        ("ASC", 2, 2, Extent::Words(Amount::Fixed(8))),  // M8161: a word for each character
        ("DRVI", 4, 4, Extent::Bits(Amount::Fixed(2))),  // direction, or done and failed
        ("HOURM", 3, 2, Extent::Words(Amount::Fixed(2))),
        ("STMR", 3, 3, Extent::Bits(Amount::Fixed(4))),
        ("TIMCHK", 3, 1, Extent::Words(Amount::Fixed(2))),
    ] {
        let found = find(mnemonic, operands).unwrap();
        let operand = found.entry.operands[number - 1];
        assert_eq!(operand.extent, extent, "{mnemonic}");
        assert!(matches!(operand.role, Role::Destination | Role::ReadWrite), "{mnemonic}");
    }
}

#[test]
fn the_number_of_operands_is_checked() {
    assert_eq!(find("+", 4).err(), Some(NotFound::OperandCount { expected: vec![2, 3] }));
    assert_eq!(find("MOVP", 3).err(), Some(NotFound::OperandCount { expected: vec![2] }));
}

#[test]
fn an_unknown_mnemonic_suggests_a_near_one() {
    assert!(matches!(find("DMVO", 2), Err(NotFound::Unknown)));
    assert_eq!(close("DMVO").as_deref(), Some("DMOV"));
    assert_eq!(close("BMVO").as_deref(), Some("BMOV"));
    assert_eq!(close("SwOp0"), None);
}

#[test]
fn an_unlisted_dedicated_instruction_may_write_all_its_operands() {
    let found = find("GP.NOSUCH", 3).unwrap();
    assert!(found.pulsed);
    assert_eq!((&*found.entry.mnemonic, found.entry.class), ("G.NOSUCH", "dedicated"));
    let all = Operand { role: Role::ReadWrite, extent: Extent::Devices(Amount::Unknown) };
    assert_eq!(found.entry.operands, vec![all; 3]);
    assert!(matches!(find("G.", 0), Err(NotFound::Unknown)));
    assert_eq!(found.entry.also, [EVERYWHERE]);
    for known in ["GP.READ", "J.SWRITE", "SP.DATE+", "ZP.PSTRT3", "D.CHGV"] {
        assert!(find(known, 4).unwrap().entry.also.is_empty(), "{known}");
    }
    assert!(WRITES_ONLY_OPERANDS.is_sorted());
}

/// A class with a time per unit needs to know how many there are: from an operand, by a limit or from the text.
#[test]
fn instructions_of_many_units_tell_how_many() {
    for entry in entries() {
        if ["block", "search", "string", "module", "table"].contains(&entry.class) {
            let reads_text = entry
                .operands
                .iter()
                .any(|it| it.extent == Extent::Text && it.role != Role::Destination);
            let told = entry.units.is_some() || entry.most_units.is_some() || reads_text;
            assert!(told, "{}", entry.mnemonic);
        }
    }
}

#[test]
fn every_area_that_the_catalog_names_exists() {
    let mut named = 0;
    for &name in entries().flat_map(|entry| &entry.also).filter(|name| **name != EVERYWHERE) {
        let area = memory::area(name);
        assert_eq!(memory::areas(memory::Family::Q)[usize::from(area.0)].name, name);
        named += 1;
    }
    assert!(named > 10);
}

#[test]
fn areas_that_are_written_besides_are_told_apart() {
    assert_eq!(find("ZPOP", 1).unwrap().entry.also, ["Z", "V index ", "LZ"]);
    assert_eq!(find("COM", 0).unwrap().entry.also, ["*"]);
}

#[test]
fn its_own_words_are_checked() {
    let read = |text| {
        catalog::row::<Vocabulary>(&["mnemonic", "pulse", "operands", "class", "meaning"], text)
    };
    assert!(read("A,P,a:b,move,havoc-anytime").is_ok());
    for wrong in ["A,Q,s,move,havoc", "A,P,t,move,havoc", "A,P,d,move,forget"] {
        assert!(read(wrong).is_err(), "{wrong}");
    }
}

/// Whether the decoder knows the mnemonic without the catalog: contacts, the stack, coils, jumps, calls and loops.
fn is_of_the_decoder(mnemonic: &str) -> bool {
    const NAMES: [&str; 46] = [
        "LD", "LDI", "AND", "ANI", "OR", "ORI", "LDP", "LDF", "ANDP", "ANDF", "ORP", "ORF", "LDPI",
        "LDFI", "ANDPI", "ANDFI", "ORPI", "ORFI", "ANB", "ORB", "MPS", "MRD", "MPP", "INV", "MEP",
        "MEF", "EGP", "EGF", "OUT", "OUTH", "SET", "RST", "PLS", "PLF", "FF", "MC", "MCR", "CJ",
        "CALL", "RET", "SRET", "IRET", "ECALL", "BREAK", "FOR", "NEXT",
    ];
    let compares = ["LD", "AND", "OR"].iter().any(|begin| {
        let rest = mnemonic.strip_prefix(begin).unwrap_or("");
        let rest = rest.strip_prefix(['D', 'E', '$']).unwrap_or(rest);
        ["=", "<>", "<", "<=", ">", ">="].contains(&rest)
    });
    let base = mnemonic.strip_suffix('P').unwrap_or(mnemonic);
    compares || [mnemonic, base].iter().any(|it| NAMES.contains(it) || ["END", "FEND"].contains(it))
}

/// Mnemonics and their numbers of operands, as counted in programs of real plants.
#[test]
fn instructions_of_real_programs_are_known() {
    let counts = include_str!("../../../../tests/data/melsec-operand-counts.csv");
    let mut application = 0;
    for row in counts.lines().skip(1) {
        let (mnemonic, operands) = row.split_once(',').unwrap();
        if is_of_the_decoder(mnemonic) {
            continue;
        }
        application += 1;
        assert!(find(mnemonic, operands.parse().unwrap()).is_ok(), "{row}");
    }
    assert!(application > 100);
}

#[test]
fn no_pulse_form_hides_another_instruction() {
    for entry in entries().filter(|entry| entry.extra.pulse) {
        let name = &entry.mnemonic;
        let pulsed = match name.split_once('.') {
            Some((prefix, rest)) => format!("{prefix}P.{rest}"),
            None => match name.strip_suffix("_U") {
                Some(base) => format!("{base}P_U"),
                None => format!("{name}P"),
            },
        };
        assert_eq!(found(&pulsed, entry.operands.len()), (name.to_string(), true));
        assert!(!is_of_the_decoder(name), "{name} is the decoder's");
    }
}
