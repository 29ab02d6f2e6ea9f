//! The sections of a text report, each figure held against JSON.

use super::figures::{Report, list, number, ps, sum};
use super::pattern::{
    Found, down, exactly, fits, near, normal, part, share, shown, up, up_in_column,
};
use serde_json::Value;

impl Report<'_> {
    /// Shown parts add up to the shown bound; those that are told in a smaller unit round to nothing.
    pub(super) fn add_up(&self, times: &[String], what: &str) {
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

    pub(super) fn longest(&self, heading: &str, lines: &[String]) {
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

    pub(super) fn programs(&self, told: &str) {
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

    pub(super) fn next(&self, line: &str) {
        let line = line.strip_prefix("next ").unwrap_or(line);
        let unknowns = list(&self.json["unknowns"]).iter();
        let longest = unknowns.filter_map(|one| one["ps"].as_u64()).max();
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
                near(&found["time"], longest.expect("a count"))
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

    pub(super) fn counts(&self, lines: &[String]) {
        let mut counts: Vec<&Value> =
            list(&self.json["unknowns"]).iter().filter(|one| one["kind"] == "count").collect();
        counts.sort_by_key(|one| std::cmp::Reverse(ps(&one["ps"])));
        let mut left = counts.into_iter();
        for line in lines {
            let plain = normal(line);
            let pattern = "{t:time} {*} assumed up to {n:most}, {t:each} each";
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
                std::slice::from_ref(line),
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

    pub(super) fn bound(&self, lines: &[String]) {
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
            ("longest scan {t:time} exact[[ with the points that the program names]]: {*}", &|found| is(found, "upper_ps") && is(found, "lower_ps")),
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

    pub(super) fn parts(&self, lines: &[String]) {
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
    pub(super) fn term(&self, line: &str, plain: &str, time: u64) {
        let product = fits("{*}: {n:n} x {t:each} {*} points{*}", plain)
            .or_else(|| fits("{*} {p:share} {n:n} x {t:each}[[ {*}]]", plain));
        if let Some(found) = product {
            let all = u128::from(number(&found, "n")) * shown(&found["each"]).ps;
            self.must(self.scaled(all) == time, line);
        }
        if let Some(found) =
            fits("{*}, the slowest base: the bound is {t:saves} lower with {*}", plain)
        {
            let saves = |base: &Value| exactly(&found["saves"], ps(&base["saves_ps"]));
            self.must(list(&self.json["bases"]).iter().any(saves), line);
        }
    }

    pub(super) fn excluded(&self, lines: &[String]) {
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
            let of_line =
                rungs.iter().filter(|row| row["line"].as_u64() == found["line"].parse().ok());
            let most = of_line.map(|row| ps(&row["most_ps"]) - ps(&row["ps"])).max();
            // A rung is told by the longest of its instructions, which need not be the same one.
            let most = most.unwrap_or_else(|| {
                rungs.iter().map(|row| ps(&row["most_ps"]) - ps(&row["ps"])).max().unwrap_or(0)
            });
            self.must(saved.ps <= u128::from(most) + saved.step && saved.ps <= before, line);
            before = saved.ps;
        }
    }

    pub(super) fn group(&self, heading: &str, lines: &[String]) {
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

    pub(super) fn conditions(&self, heading: &str, lines: &[String]) {
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

    pub(super) fn run(&self, lines: &[String]) {
        let mut scans = list(&self.json["witness_run"]).iter();
        self.each_run(lines, &mut scans);
        assert_eq!(scans.len(), 0, "all scans are shown");
    }

    pub(super) fn each_run<'j>(
        &self,
        lines: &[String],
        scans: &mut impl Iterator<Item = &'j Value>,
    ) {
        for (at, line) in lines.iter().enumerate() {
            let plain = normal(line);
            let found = fits("scan {n:n} {t:took} inputs {*}", &plain);
            let later = || fits("{*} scan[[s]] later {t:took} inputs {*}", &plain);
            let Some(found) = found.or_else(later) else { panic!("no known line: {line}") };
            let took = ps(&scans.next().expect("a scan")["took_ps"]);
            self.must(
                found.get("n").is_none_or(|n| n.parse() == Ok(at as u64 + 1))
                    && down(&found["took"], took),
                line,
            );
        }
    }

    pub(super) fn assumed(&self, heading: &str, lines: &[String]) {
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

    pub(super) fn trusted(&self, lines: &[String]) {
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
                let values = match one["values"].as_array().map(Vec::as_slice) {
                    Some([first @ .., last]) if !first.is_empty() => {
                        let first: Vec<String> = first.iter().map(ToString::to_string).collect();
                        format!("{} or {last}", first.join(", "))
                    }
                    _ => format!("{low} to {high}"),
                };
                let told = format!(" is {values} whenever a scan starts: written by ");
                let single =
                    format!("{{*}} is {low}[[, {{*}}]] or {high} whenever a scan starts: {{*}}");
                self.must(plain.contains(&told) || fits(&single, &plain).is_some(), line);
            }
            let without = fits("{*}; without that the bound is {t:time}{*}", &plain);
            let holds =
                without.is_none_or(|found| up(&found["time"], ps(&one["upper_without_ps"])));
            self.must(holds, line);
        }
    }

    pub(super) fn response(&self, lines: &[String]) {
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

    pub(super) fn path(&self, lines: &[String]) {
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

    pub(super) fn exactness(&self, heading: &str, lines: &[String]) {
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
