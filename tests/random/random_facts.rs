//! What stating something is worth, on random programs: every bound that is told beside a bound is that of a run with
//! those facts, to the picosecond; what is stated never makes a bound higher; and the more is trusted, the lower it is.

use common::audited::{asked, listed, table};
use common::counting::{Taste, generate};
use common::tape::{Tape, cases, on_tapes};
use scanbound::audit::offer::offers;
use scanbound::audit::{
    Assumption, Audit, Concluded, Failure, LimitedCount, Request, conclude, follow, what_if,
    what_if_offered,
};
use scanbound::base::facts::Facts;
use scanbound::base::time::Picos;
use scanbound::front::Input;
use scanbound::passes::values::Trust;
use scanbound::timing::table::Table;
use std::cell::Cell;

/// What costs something: each word that is counted, iterations, and moves, which tell which of the ways is taken.
const TIMES: &str = "FMOV,1,0,1\nBMOV,1,0,3\nMOV,5,2,0\nOUT,1,3,0\nNEXT,1,1,0\n";
/// Counts are stated to be at most so many.
const MAX_COUNTS: [u32; 2] = [3, 50];
/// So many things are stated of a program, one after the other.
const STATED: usize = 4;

#[derive(Default)]
struct Tally {
    programs: Cell<u32>,
    /// Bounds that were told, and of these those that are below the bound they stand beside.
    told: Cell<u32>,
    lower: Cell<u32>,
}

impl Tally {
    fn add(&self, told: Picos, beside: Picos) {
        self.told.set(self.told.get() + 1);
        self.lower.set(self.lower.get() + u32::from(told != beside));
    }

    #[allow(clippy::print_stdout)] // a long run's figures
    fn print(&self) -> (u32, u32) {
        let (programs, told, lower) = (self.programs.get(), self.told.get(), self.lower.get());
        println!("{programs} programs, {told} bounds, {lower} of them other than the one beside");
        (told, lower)
    }
}

/// A program, and what is asked of it.
struct Asked<'a> {
    inputs: &'a [Input],
    table: &'a Table,
    trust: Trust,
    text: &'a str,
}

impl Asked<'_> {
    /// An audit with these facts; none where such facts cannot be.
    fn audit<T>(
        &self,
        facts: &Facts,
        of: impl Fn(Concluded, &Request<'_>) -> Result<T, Failure>,
    ) -> Result<Option<T>, String> {
        let request = asked(self.inputs, self.table, facts, self.trust);
        let found = follow(&request).and_then(|followed| conclude(followed, &request));
        match found.and_then(|concluded| of(concluded, &request)) {
            Ok(found) => Ok(Some(found)),
            Err(Failure::Input(_)) => Ok(None),
            Err(Failure::Internal(why)) => Err(format!("{why}\n{}", self.text)),
        }
    }

    fn upper(&self, facts: &Facts) -> Result<Option<Picos>, String> {
        self.audit(facts, |concluded, _| Ok(concluded.audit.bound.upper))
    }

    /// Whether what was told is the bound of a run with these facts.
    fn holds(&self, told: Option<Picos>, facts: &Facts) -> Result<(), String> {
        let run = self.upper(facts)?;
        if run == told {
            return Ok(());
        }
        Err(format!("{told:?} was told, and it is {run:?} with\n{facts:?}\n{}", self.text))
    }
}

/// A facts file's text for steps that are taken together.
fn stated(steps: &[LimitedCount], most: u32) -> Facts {
    let mut tables = [("[counts]\n".to_owned(), "counts"), ("[index]\n".to_owned(), "index")];
    for step in steps {
        let unknown = &step.unknown;
        let own = tables.iter_mut().find(|(_, name)| *name == unknown.table());
        let number = |end| unknown.fact.strip_suffix(end).map(|line| format!("{line}[0, {most}]"));
        let line = number("[0, 20]").or_else(|| number("[0, 99]"));
        own.expect("a table").0 += &(line.unwrap_or_else(|| unknown.fact.clone()) + "\n");
    }
    let text: String = tables.into_iter().map(|(text, _)| text).collect();
    Facts::parse("facts.toml", &text).unwrap_or_else(|faults| panic!("{text}\n{faults:?}"))
}

/// That others write what is assumed.
fn without<'a>(assumptions: impl Iterator<Item = &'a Assumption>) -> Facts {
    let devices = assumptions.flat_map(|one| &one.devices);
    let word = |device: &String| device.split('.').next().unwrap_or(device).to_owned();
    Facts { external: devices.map(word).collect(), ..Facts::default() }
}

fn each_is_right(tape: &[u16], trust: Trust, tally: &Tally) -> Result<(), String> {
    let mut tape = Tape::new(tape);
    let taste = Taste { across: trust != Trust::None, far: tape.percent(50), long: false };
    let text = generate(&mut tape, taste).join("\n") + "\n";
    let (inputs, table) = (listed(text.clone()), table(TIMES));
    let asked = Asked { inputs: &inputs, table: &table, trust, text: &text };
    let nothing = Facts::default();
    let priced = |mut concluded: Concluded, request: &Request<'_>| {
        let all = concluded.audit.assumptions.clone();
        what_if(&mut concluded, request, &MAX_COUNTS)?;
        Ok((concluded.audit, all))
    };
    let offered = |mut concluded: Concluded, request: &Request<'_>| {
        what_if_offered(&mut concluded, request, &[])?;
        Ok(concluded.audit)
    };
    let (audit, assumed): (Audit, _) = asked.audit(&nothing, priced)?.ok_or(text.clone())?;
    let upper = audit.bound.upper;
    tally.programs.set(tally.programs.get() + 1);
    let what_if = audit.what_if.as_ref().expect("it was asked for");
    for (place, step) in what_if.steps.iter().enumerate() {
        for (&most, &solved) in what_if.most.iter().zip(&step.solved) {
            asked.holds(solved.map(|one| one.upper), &stated(&what_if.steps[..=place], most))?;
            tally.add(solved.map_or(upper, |one| one.upper), upper);
        }
    }
    for (one, price) in audit.assumptions.iter().filter_map(|one| Some((one, one.without?.upper))) {
        asked.holds(Some(price), &without(std::iter::once(one)))?;
        tally.add(price, upper);
    }
    if let Some(minor) = what_if.minor {
        let is_minor = |one: &&Assumption| {
            audit.assumptions.iter().all(|listed| listed.devices != one.devices)
        };
        let few: Vec<&Assumption> = assumed.iter().filter(is_minor).collect();
        assert_eq!(few.len(), minor.count, "{text}");
        asked.holds(Some(minor.without.upper), &without(few.into_iter()))?;
        tally.add(minor.without.upper, upper);
    }
    let audit = asked.audit(&nothing, offered)?.ok_or(text.clone())?;
    if let Some(own) = audit.what_if.and_then(|what_if| what_if.own) {
        asked.holds(Some(own.bound.upper), &Facts { internal: own.devices, ..nothing })?;
        tally.add(own.bound.upper, upper);
    }
    Ok(())
}

#[test]
#[ignore = "each program takes some fifty audits: minutes without optimisation"]
fn each_bound_that_is_told_is_that_of_a_run_with_those_facts() {
    let tally = Tally::default();
    for trust in [Trust::None, Trust::Counts, Trust::All] {
        on_tapes(cases(10), 120, |tape| each_is_right(tape, trust, &tally));
    }
    let (told, lower) = tally.print();
    assert!(told > cases(10) && lower * 4 > told, "{lower} of {told}");
}

/// Something that may be stated of a program, with the table of the facts file in front of its line.
fn statements(tape: &mut Tape<'_>, asked: &Asked<'_>) -> Result<Vec<String>, String> {
    let offered = |concluded: Concluded, request: &Request<'_>| Ok(offers(&concluded, request));
    let offers = asked.audit(&Facts::default(), offered)?.unwrap_or_default();
    let is_about_program = |table: &str| ["ranges", "counts", "index"].contains(&table);
    let lines = offers.into_iter().filter(|one| is_about_program(one.table));
    let mut lines: Vec<String> =
        lines.map(|one| format!("[{}]\n{}\n", one.table, one.line)).collect();
    for word in ["D0", "D5", "D10", "D11", "D12", "D13", "Z0", "Z1"] {
        // A word that is stated never to be 0 somebody else has written before the first scan: nothing else is known of
        // it.
        let low = tape.pick(&if asked.trust == Trust::None { [0, 1, -40] } else { [0, 0, -40] });
        let high = low.max(0) + tape.pick(&[3, 20, 3000]);
        lines.push(format!("[ranges]\n{word} = [{low}, {high}]\n"));
    }
    for line in
        ["bits = 16", "indirect = []", "indirect = ['D20-D40']", "Z1 = [0, 30]", "Z0 = [2, 5]"]
    {
        lines.push(format!("[index]\n{line}\n"));
    }
    for word in ["D10", "D11", "D12", "D13"] {
        lines.push(format!("[counts]\n{word} = [{}, {}]\n", tape.below(2), tape.pick(&[1, 6, 40])));
    }
    lines.push("[internal]\ndevices = ['D10-D12', 'M0-M9']\n".to_owned());
    lines.push("[exclusive]\nsets = [['M0', 'M1']]\n".to_owned());
    Ok(lines)
}

/// Facts files' texts as one; none where they say something twice.
fn together(lines: &[String]) -> Option<Facts> {
    let mut tables: std::collections::BTreeMap<&str, String> = std::collections::BTreeMap::new();
    for line in lines {
        let (table, line) = line.split_once('\n')?;
        *tables.entry(table).or_default() += line;
    }
    let text: String =
        tables.into_iter().map(|(table, lines)| format!("{table}\n{lines}")).collect();
    Facts::parse("facts.toml", &text).ok()
}

fn none_is_higher(tape: &[u16], trust: Trust, tally: &Tally) -> Result<(), String> {
    let mut tape = Tape::new(tape);
    let taste = Taste { across: tape.percent(60), far: tape.percent(60), long: false };
    let text = generate(&mut tape, taste).join("\n") + "\n";
    let (inputs, table) = (listed(text.clone()), table(TIMES));
    let asked = Asked { inputs: &inputs, table: &table, trust, text: &text };
    tally.programs.set(tally.programs.get() + 1);
    let all = statements(&mut tape, &asked)?;
    let mut said: Vec<String> = Vec::new();
    let mut upper = asked.upper(&Facts::default())?.ok_or(text.clone())?;
    for _ in 0..STATED {
        let mut more = said.clone();
        more.push(tape.pick(&all));
        let Some(facts) = together(&more) else { continue };
        let Some(lower) = asked.upper(&facts)? else { continue };
        if lower > upper {
            return Err(format!(
                "{lower:?} with\n{}\n{upper:?} without the last of these\n{text}",
                more.concat()
            ));
        }
        tally.add(lower, upper);
        (said, upper) = (more, lower);
    }
    Ok(())
}

#[test]
#[ignore = "each program takes some ten audits: minutes without optimisation"]
fn what_is_stated_makes_no_bound_higher() {
    let tally = Tally::default();
    for trust in [Trust::None, Trust::Counts, Trust::All] {
        on_tapes(cases(20), 120, |tape| none_is_higher(tape, trust, &tally));
    }
    let (told, lower) = tally.print();
    assert!(told > cases(20) && lower * 10 > told, "{lower} of {told}");
}

#[test]
fn the_more_is_trusted_the_lower_is_the_bound() {
    let tally = Tally::default();
    on_tapes(cases(4), 140, |tape| {
        let mut tape = Tape::new(tape);
        let taste = Taste { across: true, far: tape.percent(30), long: false };
        let text = generate(&mut tape, taste).join("\n") + "\n";
        let (inputs, table) = (listed(text.clone()), table(TIMES));
        tally.programs.set(tally.programs.get() + 1);
        let mut known: Option<(Trust, Picos)> = None;
        for trust in [Trust::None, Trust::Counts, Trust::All] {
            let asked = Asked { inputs: &inputs, table: &table, trust, text: &text };
            let upper = asked.upper(&Facts::default())?.ok_or(text.clone())?;
            if let Some((less, higher)) = known {
                if upper > higher {
                    return Err(format!("{upper:?} by {trust:?}, {higher:?} by {less:?}\n{text}"));
                }
                tally.add(upper, higher);
            }
            known = Some((trust, upper));
        }
        Ok(())
    });
    let (told, lower) = tally.print();
    assert!(told > cases(4) && lower * 20 > told, "{lower} of {told}");
}
