//! Times and what the user states of the plant, from the source text to the bound and the verdict.

use scanbound::audit::verdict::{Check, Margin, Verdict};
use scanbound::audit::{Audit, Evidence, Reason, Request, audit};
use scanbound::base::facts::Facts;
use scanbound::base::time::Picos;
use scanbound::front::Input;
use scanbound::timing::table::Table;

/// Rungs with every kind of charge, and points of both sides.
const PROGRAM: &str = "LD X0\nMOV D0 D1\nLDI X0\nOUT Y0\nLD M0\nBMOV D0 D10 K5\nEND\n";

fn table(rows: &str) -> Table {
    let text = format!("instruction,on_us,off_us,per_unit_us,unit,evidence,source\n{rows}");
    Table::parse("own.csv", text.as_bytes()).expect("a table").table
}

fn audited(text: &str, table: &Table, facts: &str) -> Audit {
    let inputs = [Input { name: "a.il".to_owned(), bytes: text.as_bytes().to_vec() }];
    let facts = Facts::parse("facts.toml", facts).expect("facts");
    let request = Request {
        dialect: (!matches!(table.family.as_deref(), Some("c" | "cs"))).then_some("melsec-list"),
        table: Some(table),
        ..Request::new(&inputs, &facts)
    };
    audit(&request).expect("an audit")
}

/// What each scan takes for the refresh of inputs, and what that is worked out from.
fn refreshes(audit: &Audit, side: &str) -> Vec<(u64, String)> {
    let terms = audit.overhead.iter().filter(|term| term.name == format!("{side} refresh"));
    terms.map(|term| (term.time.0, term.why.split(';').next().unwrap_or("").to_owned())).collect()
}

#[test]
fn refresh_is_charged_for_the_slowest_base_unless_the_base_is_stated() {
    let own = table("@base,qnudv\n@factor,1,,,,stated,\n");
    let io = "[io]\ninputs = 40\noutputs = 16\n";
    let unstated = audited(PROGRAM, &own, io);
    let why = [
        "3 x 5 us per 16 points, the slowest base: the bound is 18.6 us lower with [io] base = \"main\"",
        "1 x 4.3 us per 16 points, on a further base",
        "1 x 2.3 us per 16 points, on a further base",
        "1 x 1.5 us per 16 points, on a further base",
    ];
    let why = why.map(|why| format!("40 input points, as stated: {why}"));
    let times = [15_000_000, 4_300_000, 2_300_000, 1_500_000];
    assert_eq!(refreshes(&unstated, "input"), times.into_iter().zip(why).collect::<Vec<_>>());
    let saved: Vec<(&str, u64)> =
        unstated.bases.iter().map(|base| (base.least.as_str(), base.saves.0)).collect();
    assert_eq!(saved, [("main", 18_600_000), ("main", 10_500_000)]);
    let main = audited(PROGRAM, &own, &format!("{io}base = 'main'\n"));
    assert!(main.bases.is_empty());
    let saved = unstated.bases.iter().map(|base| base.saves).sum();
    assert_eq!(Some(main.bound.upper), unstated.bound.upper.checked_sub(saved));
    // A scan on the cheapest base is as short as that.
    assert_eq!(unstated.lower_without_points(), main.bound.lower);
    let mixed = audited(PROGRAM, &own, "[io]\ninputs = { main = 24, qa6 = 16 }\noutputs = 0\n");
    let times: Vec<u64> = refreshes(&mixed, "input").iter().map(|(time, _)| *time).collect();
    assert_eq!(times, [3_000_000, 5_000_000]);
    // Of all rows for a base and for any the longest counts; what bases take once a scan adds up.
    let own = table(
        "@end,1\n@input16,3\n@input16:far,9\n@input,5\n@input:far,2\n@input:near,4\nLD,0\nOUT,0\nEND,0\n",
    );
    let found = refreshes(&audited("LD X0\nOUT M0\nEND\n", &own, "[io]\ninputs = 32\n"), "input");
    let times: Vec<u64> = found.into_iter().map(|(time, _)| time / 1_000_000).collect();
    assert_eq!(times, [18, 3, 2, 4]);
    // So where there is no row for any base.
    let own = table("@end,1\n@input16:far,9\n@input16:near,2\n@input:near,1\nLD,0\nOUT,0\nEND,0\n");
    let text = "LD X0\nOUT M0\nEND\n";
    let times = |facts: &str| -> Vec<u64> {
        let found = refreshes(&audited(text, &own, facts), "input");
        found.into_iter().map(|(time, _)| time / 1_000_000).collect()
    };
    assert_eq!(times("[io]\ninputs = 32\n"), [18, 2, 1]);
    assert_eq!(times("[io]\ninputs = 32\nbase = 'near'\n"), [4, 1]);
    assert_eq!(times("[io]\ninputs = 32\nbase = 'far'\n"), [18]);
    assert_eq!(times("[io]\ninputs = 0\n"), [0_u64; 0]);
}

#[test]
fn points_on_bases_that_are_not_stated_take_as_long_as_on_any() {
    let rows = "@end,1\n@input16:far,9\n@input16:mid,8\n@input16:near,2\nLD,0\nOUT,0\nEND,0\n";
    let text = "LD X0\nOUT M0\nEND\n";
    let us = |own: &Table, facts: &str| -> u64 {
        let found = refreshes(&audited(text, own, facts), "input");
        found.into_iter().map(|(time, _)| time / 1_000_000).sum()
    };
    let own = table(rows);
    for points in [1, 2, 3, 16, 17, 18, 19, 32, 34, 48] {
        let split = |[far, mid, near]: [u32; 3]| {
            us(&own, &format!("[io]\ninputs = {{ far = {far}, mid = {mid}, near = {near} }}\n"))
        };
        // What is begun is rounded up on each base, so a point may count as much as sixteen do.
        let few = |points: u32| [0, 1, 2, points / 2, points / 3].map(|few| few.min(points));
        let splits = few(points).into_iter().flat_map(|mid| {
            few(points - mid).into_iter().map(move |near| [points - mid - near, mid, near])
        });
        let longest = splits.map(split).max();
        let unstated = us(&own, &format!("[io]\ninputs = {points}\n"));
        assert_eq!(Some(unstated), longest, "{points} points");
    }
    // Each row is for its own number of points; a row for any base is that of a base without one of its own.
    let own = table(&format!("{rows}@input16,10\n@input8:far,1\n@input8,3\n"));
    let by_sixteens = 2 * 10 + 9 + 8 + 2;
    let by_eights = 3 * 3 + 3 + 1;
    assert_eq!(us(&own, "[io]\ninputs = 20\n"), by_sixteens + by_eights);
    // Points that the program names are counted by addresses: modules take these up by sixteens.
    assert_eq!(us(&table(rows), ""), 9);
    assert_eq!(us(&table(rows), "[io]\ninputs = 16\n"), 9 + 8 + 2);
}

#[test]
fn what_is_proved_with_all_points_holds_for_any_number_that_is_stated() {
    let own = table("@base,qnudv\n");
    let open = audited(PROGRAM, &own, "");
    let all = open.upper_with_all_points();
    let stated = |inputs: u32, outputs: u32| {
        audited(PROGRAM, &own, &format!("[io]\ninputs = {inputs}\noutputs = {outputs}\n"))
            .bound
            .upper
    };
    for points in [0, 1, 16, 40, 1024, 4000, 4079, 4080, 4081, 4095, 4096] {
        assert!(stated(points, 4096) <= all && stated(4096, points) <= all, "{points} points");
    }
    assert_eq!(stated(4096, 4096), all);
    // So many more as it says keep the limit, on whichever side they are.
    for limit in [open.bound.upper.0 + 30_000_000, open.bound.upper.0 + 500_000_000] {
        let check = Check::new(&open, Picos(limit), Margin::default());
        let Verdict::Undecided(reasons) = &check.verdict else { panic!("{check:?}") };
        let more = reasons.iter().find_map(|reason| match reason {
            Reason::StatePoints { more, .. } => *more,
            _ => None,
        });
        let more = u32::try_from(more.expect("a number")).expect("a number");
        for (inputs, outputs) in [(16 + more, 16), (16, 16 + more)] {
            assert!(stated(inputs, outputs).0 <= limit, "{more} more points");
        }
    }
}

#[test]
fn a_limit_that_hangs_on_the_base_is_neither_proved_nor_refuted() {
    let own = table("@base,qnudv\n");
    let io = "[io]\ninputs = 40\noutputs = 16\n";
    let far = audited(PROGRAM, &own, io);
    let near = audited(PROGRAM, &own, &format!("{io}base = 'main'\n"));
    let verdict = |limit| Check::new(&far, limit, Margin::default()).verdict;
    let Verdict::Undecided(reasons) = verdict(near.bound.upper) else { panic!() };
    assert!(
        reasons.iter().any(|reason| reason.to_string().contains("[io] base = \"main\"")),
        "{reasons:?}"
    );
    assert_eq!(verdict(far.bound.upper), Verdict::Proved);
    assert_eq!(verdict(Picos(near.bound.lower.0 - 1)), Verdict::Refuted);
}

#[test]
fn what_networks_refresh_is_never_proved_unless_it_is_priced() {
    let io = "[io]\ninputs = 64\noutputs = 64\nbase = 'main'\n";
    let own = table("@base,qnudv\n");
    let verdict = |audit: &Audit| Check::new(audit, Picos(u64::MAX), Margin::default()).verdict;
    for (text, what) in [
        ("LD B0\nOUT Y0\nEND\n", "B"),
        ("LD X0\nOUT SB0\nEND\n", "SB"),
        ("LD X0\nMOV W10 D0\nEND\n", "W"),
        ("LD X0\nMOV K1 W0Z1\nEND\n", "W"),
        ("LD SW10.3\nOUT Y0\nEND\n", "SW"),
        ("LD X0\nMOV J1\\W10 D0\nEND\n", "MOV J1\\W10 D0"),
        ("LD J2\\B5\nOUT Y0\nEND\n", "LD J2\\B5"),
        ("LD X1000\nOUT Y0\nEND\n", "X1000 and beyond"),
        ("LD X0\nOUT Y1F0F\nEND\n", "Y1000 and beyond"),
        ("LD X0\nMOV D0 K4YFFA\nEND\n", "Y1000 and beyond"),
        ("LD X0\nFMOV K0 D0 K5\nBMOV D0 W0 K5\nEND\n", "W"),
    ] {
        let audit = audited(text, &own, io);
        assert_eq!(audit.networks.len(), 1, "{text}");
        assert!(audit.networks[0].what.contains(what), "{text}: {:?}", audit.networks);
        let line = text.lines().position(|line| {
            ["B0", "SB0", "W10", "W0", "SW10", "J2", "X1000", "Y1F", "YFFA"]
                .iter()
                .any(|name| line.contains(name))
        });
        assert_eq!(
            Some(audit.networks[0].first.line as usize),
            line.map(|line| line + 1),
            "{text}"
        );
        assert!(matches!(verdict(&audit), Verdict::Undecided(_)), "{text}");
        let told = scanbound::report::text::render(&audit, None, Default::default());
        assert!(told.contains("plus network refresh"), "{told}");
        for (facts, table) in [
            ("[network]\nrefresh = 'none'\n", "@base,qnudv\n"),
            ("[network]\nrefresh = '2ms'\n", "@base,qnudv\n"),
            ("", "@base,qnudv\n@network:CC-Link,800,,,,measured,bench\n"),
        ] {
            let priced = audited(text, &self::table(table), &format!("{io}{facts}"));
            assert_eq!(verdict(&priced), Verdict::Proved, "{text}");
            let term = priced.overhead.iter().find(|term| {
                term.name != "END processing"
                    && term.why.contains("stated")
                    && term.name.contains("network")
                    || term.name == "CC-Link"
            });
            let more = priced.bound.upper.checked_sub(audit.bound.upper);
            assert_eq!(term.map_or(Picos::ZERO, |term| term.time), more.unwrap(), "{text}");
        }
    }
    for text in [PROGRAM, "LD XFF0\nOUT YF0F\nEND\n", "LD X0\nFMOV K0 Y0 D0\nMOV K0 D0Z0\nEND\n"] {
        assert_eq!(audited(text, &own, io).networks, [], "{text}");
    }
    let fx = table("@base,fx3u\n");
    assert_eq!(audited("LD X0\nOUT Y0\nEND\n", &fx, "").networks, []);
}

#[test]
fn points_beyond_the_cpus_own_are_not_charged_as_local() {
    let own = table("@base,qnudv\n@factor,1,,,,stated,\n");
    let inputs = |text: &str| {
        let audit = audited(text, &own, "");
        let own = &audit.points[0];
        let more = own.most.as_ref().map(|most| most.more.0);
        assert_eq!(own.time.0 + more.unwrap_or(0), 256 * 5_000_000, "{text}");
        (own.taken, own.why.clone())
    };
    let why = "48 input points, since X2F is the highest input among the CPU's own 4096".to_owned();
    assert_eq!(inputs("LD X2F\nAND X1F1F\nOUT Y0\nEND\n"), (48, why));
    assert_eq!(inputs("LD X1F1F\nOUT Y0\nEND\n").0, 0);
    assert_eq!(inputs("LD SM400\nMOV K4XFF8 D0\nEND\n").0, 4096);
    assert_eq!(inputs("LD XFFF\nOUT M0\nMOV D0 D1\nEND\n").0, 4096);
}

#[test]
fn omron_words_of_links_and_units_need_a_time_too() {
    let cs = table("@base,cj2m\n");
    let verdict = |audit: &Audit| Check::new(audit, Picos(u64::MAX), Margin::default()).verdict;
    for (word, what) in [
        ("1000.00", "data links"),
        ("1500.00", "CPU Bus Units"),
        ("2005.01", "Special I/O Units"),
        ("3199.15", ""),
        ("3210.00", "DeviceNet"),
    ] {
        let audit = audited(&format!("LD 0.00\nOUT {word}\nEND\n"), &cs, "");
        let found = audit.networks.first().map(|one| one.what.as_str());
        assert_eq!(found.is_some(), !what.is_empty(), "{word}");
        assert!(found.unwrap_or_default().contains(what), "{word}");
        let is_proved = verdict(&audit) == Verdict::Proved;
        assert_eq!(is_proved, what.is_empty(), "{word}");
    }
    let c = table("@base,c200h\n");
    let audit = audited("LD 00000\nOUT LR0000\nEND(01)\n", &c, "");
    assert!(audit.networks[0].what.contains("data links"));
    assert_eq!(audited("LD 00000\nOUT 01000\nEND(01)\n", &c, "").networks, []);
}

#[test]
fn a_stated_factor_takes_the_tables_place() {
    let own = table("@base,qnudv\n");
    let audit = audited(PROGRAM, &own, "[scan]\nfactor = 1\n");
    let factor = audit.table.factor.as_ref().expect("a factor");
    assert_eq!((factor.part, factor.evidence), (Picos::ZERO, Evidence::Stated));
    let plain = audited(PROGRAM, &own, "");
    // Each time was rounded up with the factor, so a few picoseconds may be left of it.
    let without = plain.table.factor.map_or(0, |factor| factor.without.0);
    assert!(without.abs_diff(audit.bound.upper.0) < 100);
    assert!(audit.facts.iter().any(|fact| fact.to_string().contains("by at most the factor 1")));
}

#[test]
fn a_factor_is_a_part_of_the_bound_and_assumed_where_it_is() {
    for evidence in ["assumed", "published"] {
        let own = table(&format!("@base,qnudv\n@factor,1.2345,,,,{evidence},why\n"));
        let audit = audited(PROGRAM, &own, "");
        let factor = audit.table.factor.as_ref().expect("a factor");
        let parts = [audit.bound.always].into_iter();
        let parts = parts.chain(audit.overhead.iter().map(|term| term.time));
        let parts = parts.chain(audit.groups.iter().map(|group| group.upper));
        let bare: Picos = parts.map(|time| audit.bare(time)).sum();
        assert_eq!(bare + factor.part, audit.bound.upper);
        let share = u128::from(factor.part.0) * 12_345 / (u128::from(audit.bound.upper.0) * 2_345);
        assert!(factor.part > Picos::ZERO && share <= 1, "{share}");
        let row = audit.table.assumed.iter().find(|one| one.row == "@factor");
        assert_eq!(row.is_some(), evidence == "assumed");
        let sum: Picos = audit.table.assumed.iter().map(|one| one.time).sum();
        assert_eq!(sum, audit.table.assumed_time);
        let text = scanbound::report::text::render(&audit, None, Default::default());
        assert!(text.contains("factor 1.2345"), "{text}");
        let csv = scanbound::report::csv::render(&audit);
        assert!(csv.contains(&format!("factor 1.2345,,,,,,,{evidence},'@factor,factor,")), "{csv}");
        let json = scanbound::report::json::render(&audit, None);
        assert!(json.contains(&format!("\"ps\": {}", factor.part.0)), "{json}");
    }
    // All that a scan takes beyond its one published time is the factor's.
    let own =
        table("@factor,1.25,,,,assumed,why\n@end,80,,,,published,page\nLD,0,0\nOUT,0,0\nEND,0,0\n");
    let audit = audited("LD X0\nOUT M0\nEND\n", &own, "");
    assert_eq!(audit.bound.upper, Picos(100_000_000));
    assert_eq!(audit.table.assumed_time, Picos(20_000_000));
    assert_eq!(audit.overhead[0].evidence, Evidence::Published);
}

/// The larger time of the first instruction of this name, without the table's factor.
fn time_of(audit: &Audit, name: &str) -> Picos {
    let charges = audit.groups.iter().flat_map(|group| &group.charges).chain(&audit.always);
    let mut found = charges.filter(|charge| charge.instruction.split(' ').next() == Some(name));
    let charge = found.next().expect("it is charged");
    audit.bare(charge.on.max(charge.off))
}

#[test]
fn built_in_times_are_as_wide_as_what_is_known() {
    let us = |number: u64| Picos(number * 1_000_000);
    let q = |text: &str, name: &str| time_of(&audited(text, &table("@base,q02h\n"), ""), name);
    let call =
        |arguments: &str| q(&format!("LD X0\nCALL P0{arguments}\nFEND\nP0\nRET\nEND\n"), "CALL");
    assert_eq!(call(" D0 M0").checked_sub(call("")), Some(us(50)));
    let fx = |text: &str, name: &str| time_of(&audited(text, &table("@base,fx2n\n"), ""), name);
    assert_eq!(fx("LD X0\nOUT M8040\nEND\n", "OUT"), us(24));
    assert_eq!(fx("LD X0\nSET M8040\nEND\n", "SET"), us(24));
    assert_eq!(fx("LD X0\nOUT M7679\nEND\n", "OUT"), Picos(160_000));
    // Without a row of their own, special relays cost what plain ones do.
    let own = table("@family,fx\nLD,1\nOUT:M,5\nEND,1\n");
    assert_eq!(time_of(&audited("LD X0\nOUT M8040\nEND\n", &own, ""), "OUT"), us(5));
    let cs = |text: &str, name: &str| time_of(&audited(text, &table("@base,cj2m\n"), ""), name);
    let bits =
        |count: u64| cs(&format!("LD 0.00\nSETA(530) W0 #0000 &{count}\nEND\n"), "SETA(530)").0;
    assert_eq!(bits(1001) - bits(1), 1000 * 128_000);
    let unknown = cs("LD 0.00\nSETA(530) W0 #0000 D0\nEND\n", "SETA(530)");
    assert_eq!(unknown.0, bits(65_535));
}
