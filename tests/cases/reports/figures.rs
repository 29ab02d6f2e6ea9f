//! Every figure of a report that follows from others of it is worked out again: text against JSON, JSON against itself, and
//! the headline against the verdicts of checks. A line with a figure that is not known here makes the test fail.

use super::pattern::{
    Found, down, exactly, fits, near, normal, part, share, shown, up, up_in_column,
};
use scanbound::audit::verdict::{Check, Margin, Verdict};
use scanbound::audit::{Audit, Request, audit};
use scanbound::base::facts::Facts;
use scanbound::base::time::Picos;
use scanbound::front::Input;
use scanbound::report::format::{Detail, Extent};
use scanbound::report::{json, text};
use scanbound::timing::table::Table;
use serde_json::Value;
use std::time::Duration;

/// What is audited, and how.
#[derive(Default, Clone)]
pub struct Project {
    pub files: Vec<(String, Vec<u8>)>,
    pub cpu: Option<&'static str>,
    pub table: Option<(String, Vec<u8>)>,
    pub facts: String,
    pub has_response: bool,
    pub time_limit: Option<Duration>,
}

impl Project {
    /// An instruction list for a CPU.
    pub fn list(cpu: &'static str, list: &str) -> Project {
        let files = vec![("main.il".to_owned(), list.as_bytes().to_vec())];
        Project { files, cpu: Some(cpu), ..Project::default() }
    }

    fn audit(&self) -> Audit {
        let input =
            |(name, bytes): &(String, Vec<u8>)| Input { name: name.clone(), bytes: bytes.clone() };
        let inputs: Vec<Input> = self.files.iter().map(input).collect();
        let facts = Facts::parse("facts.toml", &self.facts).expect("right facts");
        let table = self.table.as_ref();
        let table = table.map(|(name, bytes)| Table::parse(name, bytes).expect("a table").table);
        let request = Request {
            cpu: self.cpu,
            table: table.as_ref(),
            response: self.has_response.then(Default::default),
            time_limit: self.time_limit,
            ..Request::new(&inputs, &facts)
        };
        audit(&request).unwrap_or_else(|fault| panic!("{}: {fault:?}", self.files[0].0))
    }
}

/// A report: what JSON says, what the text says, and what it was made of.
struct Report<'a> {
    audit: &'a Audit,
    json: Value,
    /// Sections: the heading, then its lines. The first has the answer for its heading.
    sections: Vec<(String, Vec<String>)>,
    /// Whether all is shown.
    is_full: bool,
}

/// Works out every figure of the reports of a project, and of its checks.
pub fn hold(project: &Project) {
    let found = project.audit();
    for detail in [Detail::Usual, Detail::Full] {
        Report::of(&found, None, detail).hold(None);
    }
    verdicts(&found);
    let margins = ["0%", "20%"].map(|margin| margin.parse::<Margin>().expect("a margin"));
    let upper = found.upper_with_all_points();
    let lower = found.lower_without_points();
    let limits =
        [upper.0, upper.0 - 1, found.bound.upper.0, lower.0, lower.0.saturating_sub(1).max(1)];
    for limit in limits.map(Picos) {
        for margin in margins {
            let check = Check::new(&found, limit, margin);
            for detail in [Detail::Short, Detail::Full] {
                Report::of(&found, Some(&check), detail).hold(Some(&check));
            }
        }
    }
}

/// The headline claims what checks say, no more and no less.
fn verdicts(audit: &Audit) {
    let check = |limit| Check::new(audit, Picos(limit), Margin::default()).verdict;
    let report: Value = serde_json::from_str(&json::render(audit, None)).expect("JSON");
    match report["scan"]["proved_ps"].as_u64() {
        Some(proved) => {
            assert_eq!(check(proved), Verdict::Proved);
            assert_ne!(check(proved - 1), Verdict::Proved);
        }
        None => assert_ne!(check(u64::MAX), Verdict::Proved),
    }
    let refuted = report["scan"]["refuted_ps"].as_u64().expect("a time");
    if audit.unbounded.is_empty() {
        assert_ne!(check(refuted), Verdict::Refuted);
        assert!(refuted == 0 || check(refuted - 1) == Verdict::Refuted);
    }
}

fn ps(value: &Value) -> u64 {
    value.as_u64().unwrap_or_else(|| panic!("no time: {value}"))
}

fn list(value: &Value) -> &[Value] {
    value.as_array().map_or(&[], Vec::as_slice)
}

fn sum(all: &[Value], key: &str) -> u64 {
    all.iter().map(|one| ps(&one[key])).sum()
}

fn number(found: &Found, name: &str) -> u64 {
    found[name].parse().expect("a number")
}

impl<'a> Report<'a> {
    fn of(audit: &'a Audit, check: Option<&Check>, detail: Detail) -> Report<'a> {
        let is_full = detail == Detail::Full;
        let many = if is_full { 1_000_000 } else { 10 };
        let extent = Extent {
            detail,
            top: many,
            values: many,
            width: 100_000,
            height: usize::MAX,
            ..Extent::default()
        };
        let plain = anstream_free(&text::render(audit, check, extent));
        let mut sections: Vec<(String, Vec<String>)> = Vec::new();
        let mut begins = true;
        for line in plain.lines() {
            match (line.is_empty(), begins) {
                (true, _) => begins = true,
                (false, true) => {
                    sections.push((line.to_owned(), Vec::new()));
                    begins = false;
                }
                (false, false) => sections.last_mut().expect("a section").1.push(line.to_owned()),
            }
        }
        let json = serde_json::from_str(&json::render(audit, check)).expect("JSON");
        Report { audit, json, sections, is_full }
    }

    /// Fails with the line and what stands beside it.
    fn must(&self, holds: bool, line: &str) {
        assert!(
            holds,
            "not so: {line}\n{}",
            serde_json::to_string_pretty(&self.json["scan"]).unwrap_or_default()
        );
    }

    fn scan(&self, key: &str) -> u64 {
        ps(&self.json["scan"][key])
    }

    /// The parts of the bound without the factor, and what the factor makes of a time.
    fn millionths(&self) -> u64 {
        let factor = self.json["table"]["factor"]["factor"].as_str().unwrap_or("1");
        let (whole, part) = factor.split_once('.').unwrap_or((factor, ""));
        format!("{whole}{part:0<6}").parse().expect("a factor")
    }

    fn bare(&self, time: u64) -> u64 {
        let bare = (u128::from(time) * 1_000_000).div_ceil(u128::from(self.millionths()));
        u64::try_from(bare).expect("a time")
    }

    fn scaled(&self, time: u128) -> u64 {
        let scaled = (time * u128::from(self.millionths())).div_ceil(1_000_000);
        u64::try_from(scaled).expect("a time")
    }

    fn all_points(&self) -> u64 {
        let more = list(&self.json["points"]).iter().filter_map(|side| side["more_ps"].as_u64());
        self.scan("upper_ps") + more.sum::<u64>()
    }

    fn open(&self) -> u64 {
        let rows = list(&self.json["breakdown"]["rung"]).iter();
        rows.filter(|row| row["kind"] == "open").map(|row| ps(&row["ps"])).sum()
    }

    fn hold(&self, check: Option<&Check>) {
        self.json_adds_up(check);
        for (heading, lines) in &self.sections {
            self.section(heading, lines, check);
        }
    }

    fn json_adds_up(&self, check: Option<&Check>) {
        let json = &self.json;
        let (scan, groups) = (&json["scan"], list(&json["groups"]));
        assert_eq!(
            self.scan("upper_ps"),
            self.scan("always_ps") + self.scan("overhead_ps") + sum(groups, "upper_ps")
        );
        assert_eq!(sum(list(&json["overhead"]), "ps"), self.scan("overhead_ps"));
        assert!(self.scan("naive_ps") >= self.scan("upper_ps"));
        assert!(self.scan("weighed_ps") <= self.scan("model_ps").max(self.scan("weighed_ps")));
        let is_exact = scan["upper_ps"] == scan["lower_ps"] && !scan["proved_ps"].is_null();
        assert_eq!(scan["exact"], is_exact);
        for group in groups {
            let charges = list(&group["charges"]);
            let dearer = |one: &Value| ps(&one["on_ps"]).max(ps(&one["off_ps"]));
            assert_eq!(charges.iter().map(dearer).sum::<u64>(), ps(&group["naive_ps"]));
            assert_eq!(sum(charges, "cost_ps"), ps(&group["lower_ps"]));
            assert_eq!(group["exact"], group["upper_ps"] == group["lower_ps"]);
            for charge in charges {
                let cost = match (charge["runs"].as_bool(), charge["reached"].as_bool()) {
                    (Some(true), _) => "on_ps",
                    (_, Some(true)) => "off_ps",
                    _ => continue,
                };
                // What is not known of a unit or of a branch counts as little as it can.
                assert!(
                    charge["cost_ps"].as_u64()
                        <= charge[cost].as_u64().max(charge["on_ps"].as_u64())
                );
            }
        }
        for by in ["program", "routine", "rung", "instruction"] {
            assert_eq!(sum(list(&json["breakdown"][by]), "ps"), self.scan("upper_ps"), "{by}");
        }
        let rungs = list(&json["breakdown"]["rung"]).iter();
        let rungs: Vec<u64> =
            rungs.filter(|row| row["kind"] == "rung").map(|row| ps(&row["ps"])).collect();
        assert!(rungs.is_sorted_by(|a, b| a >= b), "the dearest first");
        assert!(rungs.len() as u64 <= ps(&json["program"]["blocks"]));
        let assumed = list(&json["table"]["unverified_rows"]);
        assert!(assumed.is_sorted_by(|a, b| ps(&a["ps"]) >= ps(&b["ps"])), "those that weigh most");
        assert_eq!(sum(assumed, "worst_ps"), ps(&json["table"]["unverified_ps"]));
        let rest = self.scan("weighed_ps") - self.scan("always_ps") - self.scan("overhead_ps");
        for one in list(&json["conditions"]) {
            assert!(ps(&one["worth_ps"]) <= rest, "{one} of {rest}");
        }
        for one in list(&json["unknowns"]) {
            assert!(one["ps"].as_u64().unwrap_or(0) <= self.scan("upper_ps"), "{one}");
        }
        if let Some(response) = json.get("response") {
            let scans = ps(&response["scans"]) * ps(&response["scan_ps"]);
            let all = ps(&response["input_ps"]) + scans + ps(&response["output_ps"]);
            assert_eq!(ps(&response["upper_ps"]), all);
        }
        let Some(check) = check else { return };
        let told = &json["check"];
        let with = |time: u64| {
            let all =
                u128::from(time) * u128::from(1_000_000 + u64::from(check.margin.millionths()));
            u64::try_from(all.div_ceil(1_000_000)).expect("a time")
        };
        assert_eq!(ps(&told["upper_with_margin_ps"]), with(self.all_points()));
        assert_eq!(ps(&told["lower_with_margin_ps"]), with(self.scan("refuted_ps")));
        assert_eq!(told["verdict"], check.verdict.name());
        assert!(ps(&told["assumed_ps"]) <= ps(&told["assumed_of_ps"]));
    }

    fn section(&self, heading: &str, lines: &[String], check: Option<&Check>) {
        let json = &self.json;
        let among = |key: &Value| {
            let known: Vec<String> =
                list(key).iter().filter_map(Value::as_str).map(normal).collect();
            // Lines of an entry follow each other.
            for line in lines.iter().map(|line| normal(line)) {
                self.must(known.contains(&line), &line);
            }
        };
        let places = &list(&json["approximations"]);
        match heading {
            "Parts of the bound: groups that depend on no common device add up" => {
                self.parts(lines)
            }
            "The bound, exactly" => self.bound(lines),
            "The bound rests on counts that nobody stated, the dearest first" => self.counts(lines),
            "What can not run in the same scan, and so is not in the bound" => self.excluded(lines),
            "How a PLC with cleared memory comes to it, from power-up" => self.run(lines),
            "From an input's edge to an output's" => self.response(lines),
            "Its path through the program" => self.path(lines),
            "What the table's times do not hold" => among(&json["table"]["not_included"]),
            "Left open: what is not stated may make the bound too low" => among(&json["doubts"]),
            "What was stated and is believed" => {
                for (line, fact) in lines.iter().zip(list(&json["facts"])) {
                    let what = normal(fact["what"].as_str().unwrap_or_default());
                    self.must(normal(line).starts_with(&what), line);
                }
            }
            "Warnings" => {
                for (line, one) in lines.iter().zip(list(&json["warnings"])) {
                    let what = normal(one["message"].as_str().unwrap_or_default());
                    self.must(normal(line).ends_with(&what), line);
                }
            }
            "Loops that can run without end in one scan"
            | "Loops of which nothing is known that ends them" => {
                assert_eq!(lines.len(), list(&json["unbounded"]).len());
            }
            "It is not known where these write: any such device may hold anything then" => {}
            _ if heading.starts_with("What is trusted: ") => self.trusted(lines),
            _ if heading.starts_with("Where the ") => self.dearest(heading, lines),
            _ if heading.starts_with("Group ") => self.group(heading, lines),
            _ if heading.starts_with("Assumed times: ") => self.assumed(heading, lines),
            _ if heading.contains(" and its conditions, by what ") => {
                self.conditions(heading, lines)
            }
            _ if heading.starts_with("Over-approximated at ") => {
                let found = fits("Over-approximated at {n:n} place[[s]]: {*}", heading);
                self.must(
                    found.is_some_and(|one| number(&one, "n") == places.len() as u64),
                    heading,
                );
            }
            _ if heading.starts_with("Followed exactly: ") => self.exactness(heading, lines),
            _ => self.first(heading, lines, check),
        }
    }

    /// Each line by the first pattern that fits, and what must hold of it.
    fn each(&self, lines: &[String], known: &[(&str, &dyn Fn(&Found) -> bool)]) {
        for line in lines {
            let plain = normal(line);
            let fitting =
                known.iter().find_map(|(pattern, holds)| Some((fits(pattern, &plain)?, holds)));
            let Some((found, holds)) = fitting else { panic!("no known line: {line}") };
            self.must(holds(&found), line);
        }
    }

    /// The answer, and what it rests on.
    fn first(&self, answer: &str, lines: &[String], check: Option<&Check>) {
        let said = self.json["answer"].as_str().unwrap_or_default();
        self.must(normal(answer) == normal(said), answer);
        match check {
            None => self.headline(answer),
            Some(check) => self.verdict(answer, check),
        }
        let reasons: Vec<String> = list(&self.json["check"]["reasons"])
            .iter()
            .filter_map(Value::as_str)
            .map(normal)
            .collect();
        let lines: Vec<String> =
            lines.iter().filter(|line| !reasons.contains(&normal(line))).cloned().collect();
        let watchdog = |found: &Found| {
            let limit = self.json["table"]["watchdog_ps"].as_u64().expect("a watchdog");
            let share_is =
                |share: &String| *share == super::pattern::share(self.all_points(), limit);
            up(&found["limit"], limit)
                && found.get("share").is_none_or(share_is)
                && found.get("all").is_none_or(|all| up(all, self.all_points()))
                && found.contains_key("all")
                    == (found.contains_key("share") && self.all_points() > self.scan("upper_ps"))
        };
        let all = "[[, {t:all} with all the points that the CPU can have]]";
        let kept = format!("watchdog {{t:limit}} by default: kept, {{p:share}} of it used{all}");
        let open = format!(
            "watchdog {{t:limit}} by default: not proved to be kept: {{p:share}} of it used{all}, what is not stated not counted"
        );
        let over = format!(
            "watchdog {{t:limit}} by default: not proved to be kept: the bound is {{p:share}} of it{all}"
        );
        let times = format!(
            "watchdog {{t:limit}} by default: not proved to be kept: the bound is {{n:times}} times it{{*}}"
        );
        let instructions = ps(&self.json["program"]["instructions"]);
        self.each(&lines, &[
            ("program {*}: {n:n} instruction[[s]]; {*}table {*}", &|found| number(found, "n") == instructions),
            ("on call {*}", &|_| true),
            (&kept, &watchdog),
            (&open, &watchdog),
            (&over, &watchdog),
            (&times, &|found| {
                let limit = ps(&self.json["table"]["watchdog_ps"]);
                number(found, "times") == self.all_points() / limit
            }),
            ("watchdog {t:limit} by default: a scan was found that takes longer", &watchdog),
            ("watchdog {t:limit} by default: runs out in a loop without end", &watchdog),
            ("rests on {*}", &|_| true),
            ("nominal {t:time} without the factor {*}", &|found| {
                exactly(&found["time"], ps(&self.json["table"]["factor"]["upper_without_ps"]))
            }),
            ("ended by {*} while {*}: {*}; the bound is {t:above} above the longest scan found", &|found| {
                near(&found["above"], self.scan("upper_ps") - self.scan("lower_ps"))
            }),
            ("ended by {*} while {*}: {*}", &|_| true),
            ("ended as soon as the limit was decided; audit looks for the longest scan", &|_| true),
            ("warning {*}", &|_| true),
            ("task {*}", &|_| true),
        ]);
        for line in lines.iter().map(|line| normal(line)) {
            if let Some(items) = line.strip_prefix("rests on ") {
                items.split(", ").for_each(|item| self.rests_on(item));
            }
        }
    }

    fn rests_on(&self, item: &str) {
        let json = &self.json;
        let assumed = sum(list(&json["table"]["unverified_rows"]), "ps") + self.open_with_factor();
        let unknown = |is_count: bool| {
            let all = list(&json["unknowns"]).iter();
            all.filter(|one| (one["kind"] == "count") == is_count).count() as u64
        };
        let known: [(&str, &dyn Fn(&Found) -> bool); 6] = [
            ("assumed times ([[at most ]]{p:share})", &|found| {
                found["share"] == share(assumed, self.scan("upper_ps"))
            }),
            ("{n:n} count[[s]] that nobody stated", &|found| number(found, "n") == unknown(true)),
            ("{n:n} ind[[ex]][[ices]] that nobody stated", &|found| {
                number(found, "n") == unknown(false)
            }),
            ("{n:n} trusted word[[s]]", &|found| {
                number(found, "n") == list(&json["assumptions"]).len() as u64
            }),
            ("{n:n} stated fact[[s]]", &|found| {
                number(found, "n") == list(&json["facts"]).len() as u64
            }),
            ("{*} not stated", &|_| true),
        ];
        self.each(&[item.to_owned()], &known);
    }

    /// What the search left open, the factor included.
    fn open_with_factor(&self) -> u64 {
        self.audit.open().0
    }

    fn headline(&self, answer: &str) {
        let (upper, refuted) = (self.scan("upper_ps"), self.scan("refuted_ps"));
        let proved = self.json["scan"]["proved_ps"].as_u64();
        let saves = sum(list(&self.json["bases"]), "saves_ps");
        let named = |found: &Found| {
            let points = |side: &str| {
                let all = list(&self.json["points"]).iter();
                all.filter(|one| one["side"] == side).map(|one| ps(&one["taken"])).next()
            };
            found.get("inputs").map(|n| n.parse().ok()) == points("input").map(Some)
                && found.get("outputs").map(|n| n.parse().ok()) == points("output").map(Some)
        };
        let table = "[[ (table {*}, all times assumed, no controller named)]].";
        let of_points = "No scan takes longer than {t:all} with all the points that the CPU can have; with the [[{n:inputs} input]][[ and ]][[{n:outputs} output]] points that the program names, ";
        let known: [(String, &dyn Fn(&Found) -> bool); 7] = [
            (format!("The longest scan takes {{t:upper}}: none takes longer{table}"), &|found| {
                up(&found["upper"], upper) && proved == Some(upper) && refuted == upper
            }),
            (
                format!(
                    "No scan takes longer than {{t:upper}}; the longest found takes {{t:lower}}[[ on the cheapest base units]][[ without the I/O points that are not stated]]{table}"
                ),
                &|found| {
                    up(&found["upper"], upper)
                        && proved == Some(upper)
                        && down(&found["lower"], refuted)
                },
            ),
            (format!("{of_points}the longest takes {{t:upper}}{table}"), &|found| {
                up(&found["all"], proved.expect("points are known"))
                    && up(&found["upper"], upper)
                    && self.scan("lower_ps") == upper
                    && saves == 0
                    && named(found)
            }),
            (
                format!(
                    "{of_points}none takes longer than {{t:upper}}, and the longest found takes {{t:lower}}[[ on the cheapest base units]]{table}"
                ),
                &|found| {
                    up(&found["all"], proved.expect("points are known"))
                        && up(&found["upper"], upper)
                        && down(&found["lower"], self.scan("lower_ps").saturating_sub(saves))
                        && named(found)
                },
            ),
            (
                format!(
                    "The bound of {{t:upper}} may be too low, since this is not stated: {{*}}. The longest scan found takes {{t:lower}}[[ on the cheapest base units]][[ without the I/O points that are not stated]]{table}"
                ),
                &|found| {
                    up(&found["upper"], upper) && proved.is_none() && down(&found["lower"], refuted)
                },
            ),
            (
                format!(
                    "Nothing bounds the scan: it can go round the loop at {{*}} without end{table}"
                ),
                &|_| proved.is_none(),
            ),
            (
                format!(
                    "Nothing is known to bound the scan: the loop at {{*}} may go round any number of times{table}"
                ),
                &|_| proved.is_none(),
            ),
        ];
        let known: Vec<(&str, &dyn Fn(&Found) -> bool)> =
            known.iter().map(|(pattern, holds)| (pattern.as_str(), *holds)).collect();
        self.each(&[answer.to_owned()], &known);
    }

    fn verdict(&self, answer: &str, check: &Check) {
        let (all, refuted, limit) = (self.all_points(), self.scan("refuted_ps"), check.limit.0);
        let (above, below) = (check.upper.0, check.lower.0);
        let told = &self.json["check"];
        let sides = |found: &Found| {
            found.get("rest").is_none_or(|share| {
                *share == super::pattern::share(ps(&told["assumed_ps"]), ps(&told["assumed_of_ps"]))
            })
        };
        let most = |found: &Found| {
            up(&found["upper"], all)
                && up(&found["limit"], limit)
                && found.get("above").is_none_or(|time| up(time, above))
                && found.contains_key("above") != check.margin.is_none()
                && sides(found)
        };
        let least = |found: &Found| {
            found.get("lower").is_none_or(|time| down(time, refuted))
                && found.get("below").is_none_or(|time| down(time, below))
                && up(&found["limit"], limit)
                && sides(found)
        };
        let upper = "{t:upper}[[ ({t:above} with the margin of {*})]][[, even with all {*} points that the CPU can have[[ (assumed)]]]]";
        let lower = "{t:lower}[[ ({t:below} with the margin of {*})]][[ on the cheapest base units]][[ without the I/O points that are not stated]]";
        let rests = "[[ ([[at most ]]{p:rest} of it on assumed times)]]";
        let table = "[[ (table {*}, all times assumed, no controller named)]]";
        let both = |found: &Found| least(found) && most(found);
        let is = |verdict: &str| told["verdict"] == verdict;
        let known: [(String, &dyn Fn(&Found) -> bool); 7] = [
            (
                format!(
                    "PROVED: no scan takes longer than {upper}, the limit is {{t:limit}}{rests}{table}"
                ),
                &|found| is("proved") && most(found),
            ),
            (
                format!(
                    "REFUTED: a scan takes {lower}, the limit is {{t:limit}}{rests}[[; no run from power-up to its start state was found]]{table}"
                ),
                &|found| is("refuted") && least(found),
            ),
            (format!("REFUTED: a scan can go round the loop at {{*}} without end{table}"), &|_| {
                is("refuted")
            }),
            (
                format!(
                    "UNDECIDED: the bound of {upper} is within the limit of {{t:limit}}, but may be too low{table}"
                ),
                &|found| is("undecided") && most(found),
            ),
            (
                format!(
                    "UNDECIDED: the limit is {{t:limit}}; [[a scan takes {lower}, and ]]no scan takes more than {upper}{table}"
                ),
                &|found| is("undecided") && both(found),
            ),
            (
                format!(
                    "UNDECIDED: the limit is {{t:limit}}; [[a scan takes {lower}, and ]]the bound is {upper} and may be too low{table}"
                ),
                &|found| is("undecided") && both(found),
            ),
            (
                format!("UNDECIDED: {{*}} the loop at {{*}}; the limit is {{t:limit}}{table}"),
                &|found| is("undecided") && up(&found["limit"], limit),
            ),
        ];
        let known: Vec<(&str, &dyn Fn(&Found) -> bool)> =
            known.iter().map(|(pattern, holds)| (pattern.as_str(), *holds)).collect();
        self.each(&[answer.to_owned()], &known);
    }

    /// Shown parts add up to the shown bound; those that are told in a smaller unit round to nothing.
    fn add_up(&self, times: &[String], what: &str) {
        let unit = times.iter().map(|time| shown(time)).max_by_key(|one| one.ps).expect("a row");
        let fine = |time: &&String| time.rsplit(' ').next() == Some(unit.unit);
        let all: Vec<_> = times.iter().filter(fine).map(|time| shown(time)).collect();
        let step = all.iter().map(|one| one.digit).max().unwrap_or(1);
        let total: u128 = all.iter().map(|one| one.ps).sum();
        let upper = u128::from(self.scan("upper_ps"));
        // In a unit of its own a part is less than a step.
        let missing = (times.len() - all.len()) as u128 * step;
        let holds = total + missing >= upper && total < upper + step + missing;
        assert!(holds, "{what}: {times:?} are {total}, the bound is {upper}");
    }

    fn dearest(&self, heading: &str, lines: &[String]) {
        let upper = self.scan("upper_ps");
        let is_upper = |found: &Found| up(&found["upper"], upper);
        self.each(
            &[heading.to_owned()],
            &[
                ("Where the {t:upper} go", &is_upper),
                (
                    "Where the time goes: {t:upper} with the points that the program names",
                    &is_upper,
                ),
            ],
        );
        let rows = list(&self.json["breakdown"]["rung"]);
        let of_kind =
            |kind: &str| rows.iter().filter(|row| row["kind"] == kind).collect::<Vec<_>>();
        let (rungs, every) = (of_kind("rung"), of_kind("every_scan"));
        let mut times = Vec::new();
        let mut next = 0;
        let mut is_over = false;
        for line in lines {
            let plain = normal(line);
            if let Some(programs) = plain.strip_prefix("programs ") {
                self.programs(programs);
                continue;
            }
            is_over |= plain.starts_with("next ") || plain.starts_with("more ");
            if is_over {
                self.next(&plain);
                continue;
            }
            let found = fits("{t:time} {p:share} {*}", &plain);
            let Some(found) = found else { panic!("no known line: {line}") };
            let told = &plain[found["time"].len() + found["share"].len() + 2..];
            let told = told.trim();
            let time = |of: &[&Value]| of.iter().map(|row| ps(&row["ps"])).sum::<u64>();
            let own = if let Some(rest) = fits("{n:n} [[other ]]rung[[s]][[ {*}]]", told) {
                assert_eq!(number(&rest, "n"), (rungs.len() - next) as u64, "{line}");
                let rest = &rungs[next..];
                next = rungs.len();
                time(rest)
            } else if told.starts_with("every scan") {
                time(&every)
            } else if told.starts_with("left open") {
                time(&of_kind("open"))
            } else if told.starts_with("factor ") {
                time(&of_kind("factor"))
            } else if every.len() == 1
                && told.starts_with(every[0]["name"].as_str().expect("a name"))
            {
                time(&every)
            } else {
                let row = rungs[next];
                next += 1;
                let place = format!(":{} ", row["line"]);
                self.must(format!("{told} ").contains(&place), line);
                ps(&row["ps"])
            };
            self.must(part(&found["time"], own) && found["share"] == share(own, upper), line);
            times.push(found["time"].clone());
        }
        if times.is_empty() {
            return;
        }
        assert_eq!(next, rungs.len(), "all rungs are shown or counted: {lines:?}");
        self.add_up(&times, heading);
    }

    fn programs(&self, told: &str) {
        let upper = self.scan("upper_ps");
        let rows = list(&self.json["breakdown"]["program"]);
        let own: Vec<&Value> = rows.iter().filter(|row| row["kind"] == "program").collect();
        let all: u64 = own.iter().map(|row| ps(&row["ps"])).sum();
        let mut rest = all;
        for (at, item) in told.split(", ").enumerate() {
            let outside = share(upper - all, upper);
            let holds = if let Some(found) = fits("outside programs {p:share}", item) {
                found["share"] == outside
            } else if let Some(found) = fits("{n:n} more {p:share}", item) {
                number(&found, "n") == (own.len() - at) as u64
                    && found["share"] == share(rest, upper)
            } else if let Some(found) = fits("{*} {p:share}", item) {
                rest -= ps(&own[at]["ps"]);
                found["share"] == share(ps(&own[at]["ps"]), upper)
            } else {
                panic!("no known item: {item}")
            };
            self.must(holds, told);
        }
    }

    fn next(&self, line: &str) {
        let line = line.strip_prefix("next ").unwrap_or(line);
        let unknowns = list(&self.json["unknowns"]).iter();
        let dearest = unknowns.filter_map(|one| one["ps"].as_u64()).max();
        let first =
            list(&self.json["table"]["unverified_rows"]).iter().find(|one| ps(&one["count"]) > 0);
        let points = |found: &Found| {
            list(&self.json["points"]).iter().all(|one| {
                let taken = one["taken"].to_string();
                found.get(one["side"].as_str().unwrap_or_default()) == Some(&taken)
            })
        };
        self.each(&[line.to_owned()], &[
            ("state what {*} is at most ({*}), up to {t:time} of the bound depend on it: scanbound facts{*}", &|found| {
                near(&found["time"], dearest.expect("a count"))
            }),
            ("state the I/O points: [io] [[inputs = {n:input}]][[, ]][[outputs = {n:output}]] or more (--facts)", &points),
            ("replace assumed times, {w:name} first: --time {*}=1.5us, or --table FILE", &|found| {
                let name = first.and_then(|one| one["name"].as_str()).unwrap_or_default();
                name.split(' ').next() == Some(&found["name"])
            }),
            ("give it more time: --time-limit 10min", &|_| true),
            ("state what network refresh takes: [network] refresh = \"1.5ms\" (--facts)", &|_| true),
            ("state how often {*} interrupts a scan: --interrupts {*}", &|_| true),
            ("give the code of {*}, or state its time: {*}", &|_| true),
            ("state {*}: what is written there may be anywhere: {*}", &|_| true),
            ("more -v the whole report, --by program|rung|instruction where the time goes", &|_| true),
        ]);
    }

    fn counts(&self, lines: &[String]) {
        let mut counts: Vec<&Value> =
            list(&self.json["unknowns"]).iter().filter(|one| one["kind"] == "count").collect();
        counts.sort_by_key(|one| std::cmp::Reverse(ps(&one["ps"])));
        let mut left = counts.into_iter();
        for line in lines {
            let plain = normal(line);
            let pattern = "{t:time} {*} taken as up to {n:most}, {t:each} each";
            if let Some(found) = fits(pattern, &plain) {
                let one = left.next().expect("a count");
                let holds = near(&found["time"], ps(&one["ps"]))
                    && number(&found, "most") == ps(&one["taken"][1])
                    && near(&found["each"], ps(&one["per_unit_ps"]));
                self.must(holds, line);
                continue;
            }
            let rest = left.len() as u64;
            self.each(
                &[line.clone()],
                &[
                    ("and {n:n} count[[s]] (-v)", &|found| number(found, "n") == rest),
                    ("say in a facts file (--facts) what they are, such as at most 20:", &|_| true),
                    ("[counts]", &|_| true),
                    ("\"{*}\" = [0, 20]", &|_| true),
                    (
                        "--what-if solves the bound for counts and indices of at most 20 and 100",
                        &|_| true,
                    ),
                ],
            );
        }
    }

    fn bound(&self, lines: &[String]) {
        let (upper, naive) = (self.scan("upper_ps"), self.scan("naive_ps"));
        let is = |found: &Found, key: &str| exactly(&found["time"], self.scan(key));
        let above = |found: &Found, key: &str, lower: u64| {
            let time = shown(&found[key]).ps;
            let saved = shown(&found["saved"]).ps;
            saved == time - u128::from(lower)
                && found["share"]
                    == share(
                        u64::try_from(saved).expect("a time"),
                        u64::try_from(time).expect("a time"),
                    )
        };
        self.each(lines, &[
            ("longest scan {t:time} exact: {*}", &|found| is(found, "upper_ps") && is(found, "lower_ps")),
            ("longest scan {t:time} a scan that takes this long was found and replayed{*}", &|found| {
                is(found, "upper_ps") && is(found, "lower_ps") && self.json["scan"]["proved_ps"].is_null()
            }),
            ("longest scan {t:time} at most{*}", &|found| is(found, "upper_ps")),
            ("longest scan unbounded {*}", &|_| self.json["scan"]["proved_ps"].is_null()),
            ("cut off {t:time} at most, {*}", &|found| is(found, "upper_ps")),
            ("{t:time} at least: {*}", &|found| is(found, "lower_ps")),
            ("by the search {t:time} {*}", &|found| is(found, "model_ps")),
            ("structural bound {t:time} sum of all instructions, each at its larger time; mutual exclusion saves [[at least ]]{t:saved} ({p:share})", &|found| {
                is(found, "naive_ps")
                    && exactly(&found["saved"], naive - upper)
                    && found["share"] == share(naive - upper, naive)
            }),
            ("without charts {t:time} {*}: co-activity takes off [[at most ]]{t:saved} ({p:share}); {*}", &|found| above(found, "time", upper)),
            ("plus network refresh not stated {*}", &|_| !list(&self.json["networks"]).is_empty()),
            ("search {*}", &|_| true),
            ("confirmed {*}", &|_| true),
        ]);
    }

    fn parts(&self, lines: &[String]) {
        let upper = self.scan("upper_ps");
        let groups = list(&self.json["groups"]);
        let mut overhead = list(&self.json["overhead"]).iter();
        let (mut times, mut shown_groups) = (Vec::new(), 0);
        for line in lines {
            let plain = normal(line);
            let Some(found) = fits("{*} {t:time} {p:share}[[ {*}]]", &plain) else {
                panic!("no known line: {line}")
            };
            let own = if plain.starts_with("always ") {
                self.bare(self.scan("always_ps"))
            } else if let Some(group) = fits(
                "group {n:id} {t:time} {p:share} [[exact]][[at most]]; structural {t:naive}",
                &plain,
            ) {
                shown_groups += 1;
                let one = &groups[number(&group, "id") as usize - 1];
                self.must(
                    plain.contains("% exact; ") == one["exact"].as_bool().expect("a flag"),
                    line,
                );
                self.must(up_in_column(&group["naive"], self.bare(ps(&one["naive_ps"]))), line);
                self.must(shown(&group["naive"]).ps >= shown(&group["time"]).ps, line);
                self.bare(ps(&one["upper_ps"]))
            } else if let Some(small) = fits("{n:n} small group[[s]] {*}", &plain) {
                let rest = &groups[shown_groups..];
                assert_eq!(number(&small, "n"), rest.len() as u64, "{line}");
                rest.iter().map(|one| self.bare(ps(&one["upper_ps"]))).sum()
            } else if let Some(factor) = fits("factor {w:factor} {t:time} {*}", &plain) {
                self.must(
                    self.json["table"]["factor"]["factor"] == factor["factor"].as_str(),
                    line,
                );
                ps(&self.json["table"]["factor"]["ps"])
            } else {
                let term = overhead.next().unwrap_or_else(|| panic!("no known line: {line}"));
                self.must(plain.starts_with(term["name"].as_str().expect("a name")), line);
                self.term(line, &plain, ps(&term["ps"]));
                self.bare(ps(&term["ps"]))
            };
            self.must(part(&found["time"], own) && found["share"] == share(own, upper), line);
            times.push(found["time"].clone());
        }
        self.add_up(&times, "parts");
    }

    /// So many times so much makes the term.
    fn term(&self, line: &str, plain: &str, time: u64) {
        let product = fits("{*}: {n:n} x {t:each} {*} points{*}", plain)
            .or_else(|| fits("{*} {p:share} {n:n} x {t:each}[[ {*}]]", plain));
        if let Some(found) = product {
            let all = u128::from(number(&found, "n")) * shown(&found["each"]).ps;
            self.must(self.scaled(all) == time, line);
        }
        if let Some(found) =
            fits("{*}, the dearest base: the bound is {t:saves} less if {*}", plain)
        {
            let saves = |base: &Value| exactly(&found["saves"], ps(&base["saves_ps"]));
            self.must(list(&self.json["bases"]).iter().any(saves), line);
        }
    }

    fn excluded(&self, lines: &[String]) {
        let mut before = u128::MAX;
        let rungs = list(&self.json["breakdown"]["rung"]);
        for line in lines {
            let plain = normal(line);
            if fits("and {n:n} such rung[[s]] (-v)", &plain).is_some() {
                continue;
            }
            let Some(found) = fits("{t:time} {*}:{n:line} {*}", &plain) else {
                panic!("no known line: {line}")
            };
            let saved = shown(&found["time"]);
            let of_line = rungs.iter().filter(|row| row["line"].to_string() == found["line"]);
            let most = of_line.map(|row| ps(&row["most_ps"]) - ps(&row["ps"])).max();
            // A rung is told by the dearest of its instructions, which need not be the same one.
            let most = most.unwrap_or_else(|| {
                rungs.iter().map(|row| ps(&row["most_ps"]) - ps(&row["ps"])).max().unwrap_or(0)
            });
            self.must(saved.ps <= u128::from(most) + saved.step && saved.ps <= before, line);
            before = saved.ps;
        }
    }

    fn group(&self, heading: &str, lines: &[String]) {
        let head =
            "Group {n:id}: at most {t:upper}, [[exact]][[at least {t:lower}]]; {n:n} rung[[s]]";
        let found = fits(head, &normal(heading)).expect("a group's heading");
        let group = &list(&self.json["groups"])[number(&found, "id") as usize - 1];
        let nanos = |time: u64| self.bare(time).div_ceil(1000) * 1000;
        let upper = nanos(ps(&group["upper_ps"]));
        self.must(exactly(&found["upper"], upper), heading);
        self.must(
            found.get("lower").is_none_or(|time| exactly(time, nanos(ps(&group["lower_ps"])))),
            heading,
        );
        let blocks = list(&group["blocks"]).len();
        self.must(number(&found, "n") == blocks as u64, heading);
        let (mut cost, mut naive, mut rungs) = (0, 0, 0u64);
        for line in lines {
            let plain = normal(line);
            // Devices may be called anything; they stand on one line here.
            if plain.starts_with("tied by ") {
                continue;
            }
            let all = [
                "runs {t:cost} rung {n:n} {*}",
                "off {t:cost} rung {n:n} {*}",
                "partly {t:cost} of {t:naive} rung {n:n} {*}",
                "excluded 0 of {t:naive} rung {n:n} {*}",
                "excluded {t:cost} of {t:naive} rung {n:n} {*}",
            ];
            let Some(found) = all.iter().find_map(|pattern| fits(pattern, &plain)) else {
                panic!("no known line: {line}")
            };
            let own = found.get("cost").map_or(0, |time| shown(time).ps);
            cost += own;
            naive += found.get("naive").map_or(own, |time| shown(time).ps);
            rungs += 1;
        }
        // Each is rounded up by less than a nanosecond, and by one picosecond for the factor.
        let slack = u128::from(rungs + 1) * 1001;
        let close = |shown: u128, whole: u64| shown.abs_diff(u128::from(self.bare(whole))) <= slack;
        assert_eq!(rungs, blocks as u64, "{heading}");
        self.must(close(naive, ps(&group["naive_ps"])), heading);
        if self.open() == 0 && list(&self.json["ended"]).is_empty() {
            self.must(close(cost, ps(&group["upper_ps"])), heading);
        }
    }

    fn conditions(&self, heading: &str, lines: &[String]) {
        let lower = |found: &Found| down(&found["lower"], self.scan("lower_ps"));
        self.each(&[heading.to_owned()], &[
            ("The longest scan[[ found]] ({t:lower}) and its conditions, by what it would lose without each", &|found| {
                lower(found) && self.scan("weighed_ps") == self.scan("lower_ps")
            }),
            ("The longest scan[[ found]] ({t:lower}) and its conditions, by what the model's scan with the same start ({t:weighed}) would lose without each", &|found| {
                lower(found) && near(&found["weighed"], self.scan("weighed_ps"))
            }),
        ]);
        let all = list(&self.json["conditions"]);
        let mut left = all.iter();
        for line in lines {
            let plain = normal(line);
            let rest = left.len() as u64;
            let free = self.json["witness"].as_object().map_or(0, |all| all.len()) - all.len();
            let found = fits("and {n:n} condition[[s]] that add[[s]] no more (-v)", &plain);
            if let Some(found) = found {
                self.must(number(&found, "n") == rest, line);
            } else if let Some(found) = fits("{n:n} other value[[s]] may be anything", &plain) {
                self.must(number(&found, "n") == free as u64, line);
            } else {
                let one = left.next().expect("a condition");
                let worth = ps(&one["worth_ps"]);
                let holds = match fits("{t:time} {*}", &plain) {
                    Some(found) => near(&found["time"], worth),
                    None => worth == 0 && plain.starts_with("- "),
                };
                let name = normal(one["name"].as_str().expect("a name"));
                self.must(holds && plain.contains(&name), line);
                let value = &self.json["witness"][one["name"].as_str().expect("a name")];
                let state = match value {
                    Value::Bool(true) => " is on".to_owned(),
                    Value::Bool(false) => " is off".to_owned(),
                    word => format!(" = {word}"),
                };
                self.must(plain.contains(&state), line);
            }
        }
    }

    fn run(&self, lines: &[String]) {
        let mut scans = list(&self.json["witness_run"]).iter();
        self.each_run(lines, &mut scans);
        assert_eq!(scans.len(), 0, "all scans are shown");
    }

    fn each_run<'j>(&self, lines: &[String], scans: &mut impl Iterator<Item = &'j Value>) {
        for (at, line) in lines.iter().enumerate() {
            let plain = normal(line);
            let found = fits("scan {n:n} {t:took} inputs {*}", &plain);
            let Some(found) = found else { panic!("no known line: {line}") };
            let took = ps(&scans.next().expect("a scan")["took_ps"]);
            self.must(number(&found, "n") == at as u64 + 1 && down(&found["took"], took), line);
        }
    }

    fn assumed(&self, heading: &str, lines: &[String]) {
        let rows = list(&self.json["table"]["unverified_rows"]);
        let (upper, open) = (self.scan("upper_ps"), self.open_with_factor());
        let found = fits(
            "Assumed times: {p:share} of the bound[[ at most, with the {t:open} that the search left open]]; the part of each in the bound",
            heading,
        );
        let found = found.unwrap_or_else(|| panic!("no known line: {heading}"));
        self.must(found["share"] == share(sum(rows, "ps") + open, upper), heading);
        self.must(found.get("open").map_or(open == 0, |time| near(time, open)), heading);
        let mut left = rows.iter();
        for line in lines {
            let plain = normal(line);
            if let Some(more) = fits("and {n:n} assumed time[[s]] (-v)", &plain) {
                self.must(number(&more, "n") == left.len() as u64, line);
                continue;
            }
            let one = left.next().expect("an assumed time");
            let name = normal(one["name"].as_str().expect("a name"));
            let used = match ps(&one["count"]) {
                0 if one["row"] == "@factor" => {
                    "on the whole scan: what it adds to other times".to_owned()
                }
                0 => "a term of the scan".to_owned(),
                1 => "once in the program".to_owned(),
                n => format!("{n} times in the program"),
            };
            let told = plain.strip_prefix(&name).unwrap_or_default().trim();
            let found = fits("{t:time} {*}", told);
            let holds = found.is_some_and(|found| near(&found["time"], ps(&one["ps"])));
            self.must(holds && told.contains(&used), line);
        }
    }

    fn trusted(&self, lines: &[String]) {
        let mut left = list(&self.json["assumptions"]).iter();
        for line in lines {
            let plain = normal(line);
            if plain.starts_with("--what-if solves what each is worth")
                || plain.starts_with("not covered: ")
            {
                continue;
            }
            if let Some(more) = fits("and {n:n} word[[s]] or set[[s]] of relays (-v)", &plain) {
                self.must(number(&more, "n") == left.len() as u64, line);
                continue;
            }
            let one = left.next().unwrap_or_else(|| panic!("no known line: {line}"));
            if let Some([low, high]) = one["range"].as_array().map(Vec::as_slice) {
                let told = format!(" is {low} to {high} whenever a scan starts: written by ");
                self.must(plain.contains(&told), line);
            }
            let without = fits("{*}; without that the bound is {t:time}{*}", &plain);
            let holds =
                without.is_none_or(|found| up(&found["time"], ps(&one["upper_without_ps"])));
            self.must(holds, line);
        }
    }

    fn response(&self, lines: &[String]) {
        let told = &self.json["response"];
        let is = |found: &Found, key: &str| exactly(&found["time"], ps(&told[key]));
        self.each(
            lines,
            &[
                ("input {t:time} {*}", &|found| is(found, "input_ps")),
                ("output {t:time} {*}", &|found| is(found, "output_ps")),
                ("scans {t:time} {n:n} x {t:each}: {*}", &|found| {
                    number(found, "n") == ps(&told["scans"])
                        && exactly(&found["each"], ps(&told["scan_ps"]))
                        && exactly(&found["time"], ps(&told["scans"]) * ps(&told["scan_ps"]))
                }),
                ("together {t:time} {*}", &|found| is(found, "upper_ps")),
            ],
        );
    }

    fn path(&self, lines: &[String]) {
        let all = list(&self.json["path"]);
        let mut left = all.iter();
        for line in lines {
            if let Some(found) = fits("{t:time} line {n:line} {*}", &normal(line)) {
                let one = left.next().expect("a step of the path");
                let holds = exactly(&found["time"], ps(&one["cost_ps"]))
                    && number(&found, "line") == ps(&one["line"]);
                self.must(holds, line);
            }
        }
        assert_eq!(left.len(), 0, "the whole path is shown");
        assert_eq!(sum(all, "cost_ps") + self.scan("overhead_ps"), self.scan("lower_ps"));
    }

    fn exactness(&self, heading: &str, lines: &[String]) {
        let told = &self.json["exactness"];
        let (exact, all) = (ps(&told["exact"]), ps(&told["statements"]));
        self.each(
            &[heading.to_owned()],
            &[
                ("Followed exactly: all {n:all} statements", &|found| {
                    number(found, "all") == all && exact == all
                }),
                ("Followed exactly: {n:exact} of {n:all} statements ({p:share})", &|found| {
                    number(found, "all") == all
                        && number(found, "exact") == exact
                        && found["share"] == share(exact, all)
                }),
            ],
        );
        for (line, one) in lines.iter().zip(list(&told["languages"])) {
            let found = fits(
                "{w:name} {n:exact} of {n:all}[[ {p:share}]] in {n:bodies} bod[[y]][[ies]][[; {n:uncalled} more that nothing calls]]",
                &normal(line),
            );
            let Some(found) = found else { panic!("no known line: {line}") };
            let is = |name: &str, key: &str| number(&found, name) == ps(&one[key]);
            let holds = is("exact", "exact")
                && is("all", "statements")
                && is("bodies", "bodies")
                && found
                    .get("share")
                    .is_none_or(|told| *told == share(ps(&one["exact"]), ps(&one["statements"])));
            self.must(holds, line);
        }
    }
}

/// The text without colour codes.
fn anstream_free(text: &str) -> String {
    let mut plain = String::new();
    let mut rest = text;
    while let Some((before, code)) = rest.split_once('\u{1b}') {
        plain += before;
        rest = code.split_once('m').map_or("", |(_, behind)| behind);
    }
    plain + rest
}
