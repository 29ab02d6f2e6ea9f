//! Every figure of a report that follows from others of it is worked out again: text against JSON, JSON against itself,
//! and the headline against the verdicts of checks. A line with a figure that is not known here makes the test fail.

use super::pattern::{Found, down, exactly, fits, near, normal, share, up};
use scanbound::audit::verdict::{Check, Margin, Verdict};
use scanbound::audit::{Audit, Request, audit};
use scanbound::base::facts::Facts;
use scanbound::base::time::Picos;
use scanbound::front::Input;
use scanbound::report::format::{Detail, Extent};
use scanbound::report::{csv, html, json, text};
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

/// What must hold of the figures of a line.
type Holds<'a> = &'a dyn Fn(&Found) -> bool;

/// A report: what JSON says, what the text says, and what it was made of.
pub(super) struct Report<'a> {
    pub(super) audit: &'a Audit,
    pub(super) json: Value,
    /// Sections: the heading, then its lines. The first has the answer for its heading.
    sections: Vec<(String, Vec<String>)>,
}

/// Works out every figure of the reports of a project, and of its checks.
pub fn hold(project: &Project) {
    let found = project.audit();
    for detail in [Detail::Usual, Detail::Full] {
        Report::of(&found, None, detail).hold(None);
    }
    verdicts(&found);
    rows(&found);
    page(&found);
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

/// The rows for spreadsheets say of every charge what JSON says, and add up to its sums.
fn rows(audit: &Audit) {
    let report: Value = serde_json::from_str(&json::render(audit, None)).expect("JSON");
    let told = csv::render(audit);
    let mut reader = ::csv::Reader::from_reader(told.trim_start_matches('\u{feff}').as_bytes());
    let heads = reader.headers().expect("heads").clone();
    let at = |name: &str| heads.iter().position(|head| head == name).expect("a column");
    let (part, group) = (at("part"), at("group"));
    let rows: Vec<::csv::StringRecord> = reader.records().map(|row| row.expect("a row")).collect();
    let time = |row: &::csv::StringRecord, name: &str| {
        let found = super::pattern::shown(&format!("{} us", &row[at(name)])).ps;
        u64::try_from(found).expect("a time")
    };
    let costs = |of: &str| -> u64 {
        rows.iter().filter(|row| &row[part] == of).map(|row| time(row, "cost_us")).sum()
    };
    assert_eq!(costs("always"), ps(&report["scan"]["always_ps"]));
    assert_eq!(costs("overhead"), ps(&report["scan"]["overhead_ps"]));
    let mut charges = rows.iter().filter(|row| &row[part] == "group");
    for one in list(&report["groups"]) {
        for charge in list(&one["charges"]) {
            let row = charges.next().expect("a row for each charge");
            assert_eq!(&row[group], one["id"].to_string());
            for (column, key) in [("on_us", "on_ps"), ("off_us", "off_ps"), ("cost_us", "cost_ps")]
            {
                assert_eq!(time(row, column), ps(&charge[key]), "{column} of {row:?}");
            }
            for key in ["runs", "reached"] {
                assert_eq!(row[at(key)], charge[key].to_string(), "{key} of {row:?}");
            }
        }
    }
    assert!(charges.next().is_none(), "no row more");
}

/// The page holds the same report.
fn page(audit: &Audit) {
    let report: Value = serde_json::from_str(&json::render(audit, None)).expect("JSON");
    let mut bytes = Vec::new();
    (html::FORMAT.audit)(audit, None, Extent::default(), &mut bytes).expect("memory takes it");
    let page = String::from_utf8(bytes).expect("text");
    let (_, data) = page.split_once("id=\"data\">").expect("data");
    let (data, _) = data.split_once("</script>").expect("data");
    let data: Value = serde_json::from_str(data).expect("JSON");
    for key in
        ["answer", "scan", "overhead", "breakdown", "conditions", "points", "doubts", "table"]
    {
        assert_eq!(data["report"][key], report[key], "{key}");
    }
    let sums = |groups: &Value| -> Vec<[u64; 3]> {
        let of = |one: &Value| ["upper_ps", "lower_ps", "naive_ps"].map(|key| ps(&one[key]));
        list(groups).iter().map(of).collect()
    };
    assert_eq!(sums(&data["report"]["groups"]), sums(&report["groups"]));
}

pub(super) fn ps(value: &Value) -> u64 {
    value.as_u64().unwrap_or_else(|| panic!("no time: {value}"))
}

pub(super) fn list(value: &Value) -> &[Value] {
    value.as_array().map_or(&[], Vec::as_slice)
}

pub(super) fn sum(all: &[Value], key: &str) -> u64 {
    all.iter().map(|one| ps(&one[key])).sum()
}

pub(super) fn number(found: &Found, name: &str) -> u64 {
    found[name].parse().expect("a number")
}

impl<'a> Report<'a> {
    pub(super) fn of(audit: &'a Audit, check: Option<&Check>, detail: Detail) -> Report<'a> {
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
        Report { audit, json, sections }
    }

    /// Fails with the line and what stands beside it.
    pub(super) fn must(&self, holds: bool, line: &str) {
        assert!(
            holds,
            "not so: {line}\n{}",
            serde_json::to_string_pretty(&self.json["scan"]).unwrap_or_default()
        );
    }

    pub(super) fn scan(&self, key: &str) -> u64 {
        // Nothing bounds the scan: the parts are those of scans that were cut off.
        if key == "upper_ps" && self.json["scan"][key].is_null() {
            assert!(!self.audit.unbounded.is_empty());
            return self.scan("always_ps")
                + self.scan("overhead_ps")
                + sum(list(&self.json["groups"]), "upper_ps");
        }
        ps(&self.json["scan"][key])
    }

    /// The parts of the bound without the factor, and what the factor makes of a time.
    pub(super) fn millionths(&self) -> u64 {
        let factor = self.json["table"]["factor"]["factor"].as_str().unwrap_or("1");
        let (whole, part) = factor.split_once('.').unwrap_or((factor, ""));
        format!("{whole}{part:0<6}").parse().expect("a factor")
    }

    pub(super) fn bare(&self, time: u64) -> u64 {
        let bare = (u128::from(time) * 1_000_000).div_ceil(u128::from(self.millionths()));
        u64::try_from(bare).expect("a time")
    }

    pub(super) fn scaled(&self, time: u128) -> u64 {
        let scaled = (time * u128::from(self.millionths())).div_ceil(1_000_000);
        u64::try_from(scaled).expect("a time")
    }

    pub(super) fn all_points(&self) -> u64 {
        let more = list(&self.json["points"]).iter().filter_map(|side| side["more_ps"].as_u64());
        self.scan("upper_ps") + more.sum::<u64>()
    }

    pub(super) fn open(&self) -> u64 {
        let rows = list(&self.json["breakdown"]["rung"]).iter();
        rows.filter(|row| row["kind"] == "open").map(|row| ps(&row["ps"])).sum()
    }

    pub(super) fn hold(&self, check: Option<&Check>) {
        self.json_adds_up(check);
        for (heading, lines) in &self.sections {
            self.section(heading, lines, check);
        }
    }

    pub(super) fn json_adds_up(&self, check: Option<&Check>) {
        let json = &self.json;
        let (scan, groups) = (&json["scan"], list(&json["groups"]));
        assert_eq!(
            self.scan("upper_ps"),
            self.scan("always_ps") + self.scan("overhead_ps") + sum(groups, "upper_ps")
        );
        let has_bound = self.audit.unbounded.is_empty();
        for key in ["upper_ps", "cycle_ps"] {
            assert_eq!(scan[key].is_null(), !has_bound, "{key}");
        }
        assert_eq!(sum(list(&json["overhead"]), "ps"), self.scan("overhead_ps"));
        assert!(self.scan("naive_ps") >= self.scan("upper_ps"));
        assert!(self.scan("weighed_ps") <= self.scan("model_ps").max(self.scan("weighed_ps")));
        let is_exact = scan["upper_ps"] == scan["lower_ps"] && !scan["proved_ps"].is_null();
        assert_eq!(scan["exact"], is_exact);
        for group in groups {
            let charges = list(&group["charges"]);
            let larger = |one: &Value| ps(&one["on_ps"]).max(ps(&one["off_ps"]));
            assert_eq!(charges.iter().map(larger).sum::<u64>(), ps(&group["naive_ps"]));
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
        assert!(rungs.is_sorted_by(|a, b| a >= b), "the longest first");
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

    pub(super) fn section(&self, heading: &str, lines: &[String], check: Option<&Check>) {
        let json = &self.json;
        let among = |key: &Value| {
            let by_parameters = json["scan"]["constant_scan"]["by_parameters"].as_str();
            let constant = by_parameters.map(|name| {
                normal(&format!(
                    "a {name} that the CPU's parameters may set: state it ([scan] constant = \"20ms\", or \"none\")"
                ))
            });
            let known = list(key).iter().filter_map(Value::as_str).map(normal);
            let known: Vec<String> = known.chain(constant).collect();
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
            "The bound depends on unstated counts, the largest time first" => self.counts(lines),
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
            _ if heading.starts_with("Where the ") => self.longest(heading, lines),
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
    pub(super) fn each(&self, lines: &[String], known: &[(&str, Holds<'_>)]) {
        for line in lines {
            let plain = normal(line);
            let fitting =
                known.iter().find_map(|(pattern, holds)| Some((fits(pattern, &plain)?, holds)));
            let Some((found, holds)) = fitting else { panic!("no known line: {line}") };
            self.must(holds(&found), line);
        }
    }

    /// The answer, and what it rests on.
    pub(super) fn first(&self, answer: &str, lines: &[String], check: Option<&Check>) {
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
        let times = "watchdog {t:limit} by default: not proved to be kept: the bound is {n:times} times it{*}";
        let instructions = ps(&self.json["program"]["instructions"]);
        self.each(&lines, &[
            ("program {*}: {n:n} instruction[[s]]; {*}table {*}", &|found| number(found, "n") == instructions),
            ("on call {*}", &|_| true),
            (&kept, &watchdog),
            (&open, &watchdog),
            (&over, &watchdog),
            (times, &|found| {
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

    pub(super) fn rests_on(&self, item: &str) {
        let json = &self.json;
        let assumed = sum(list(&json["table"]["unverified_rows"]), "ps") + self.open_with_factor();
        let unknown = |is_count: bool| {
            let all = list(&json["unknowns"]).iter();
            all.filter(|one| (one["kind"] == "count") == is_count).count() as u64
        };
        let known: [(&str, Holds<'_>); 6] = [
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
    pub(super) fn open_with_factor(&self) -> u64 {
        self.audit.open().0
    }

    pub(super) fn headline(&self, answer: &str) {
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
        let known: [(String, Holds<'_>); 7] = [
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
        let known: Vec<(&str, Holds<'_>)> =
            known.iter().map(|(pattern, holds)| (pattern.as_str(), *holds)).collect();
        self.each(&[answer.to_owned()], &known);
    }

    pub(super) fn verdict(&self, answer: &str, check: &Check) {
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
        let known: [(String, Holds<'_>); 7] = [
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
        let known: Vec<(&str, Holds<'_>)> =
            known.iter().map(|(pattern, holds)| (pattern.as_str(), *holds)).collect();
        self.each(&[answer.to_owned()], &known);
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
