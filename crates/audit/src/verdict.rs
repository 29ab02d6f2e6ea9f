//! Whether a program stays within a limit: proved, refuted by a scan, or undecided with the reasons.

use crate::{Audit, Doubt, Evidence, Reason, Share, Stretch, UnstatedBase, UnstatedPoints};
use scanbound_base::time::Picos;
use std::cmp::Reverse;
use std::fmt;
use std::str::FromStr;

/// A safety margin in millionths of a time, which is added to the time before it is compared with the limit.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Margin(u32);

impl Margin {
    /// The time with the margin added, rounded up. The largest representable time if it is longer.
    #[must_use]
    pub fn on(self, time: Picos) -> Picos {
        let scaled = u128::from(time.0) * (1_000_000 + u128::from(self.0));
        Picos(u64::try_from(scaled.div_ceil(1_000_000)).unwrap_or(u64::MAX))
    }

    /// The longest time that does not exceed the limit when the margin is added, rounded down.
    #[must_use]
    pub fn room(self, limit: Picos) -> Picos {
        let most = u128::from(limit.0) * 1_000_000 / (1_000_000 + u128::from(self.0));
        Picos(u64::try_from(most).unwrap_or(limit.0))
    }

    /// The safety margin, in millionths of the time to which it is added.
    #[must_use]
    pub fn millionths(self) -> u32 {
        self.0
    }

    /// Whether the margin is zero.
    #[must_use]
    pub fn is_none(self) -> bool {
        self.0 == 0
    }
}

impl FromStr for Margin {
    type Err = String;
    fn from_str(text: &str) -> Result<Margin, String> {
        let help = || format!("'{text}' is not a percentage from 0% to 1000%");
        let number = text.trim().strip_suffix('%').ok_or_else(help)?.trim();
        let (whole, fraction) = number.split_once('.').unwrap_or((number, ""));
        let digits = |part: &str| part.bytes().all(|byte| byte.is_ascii_digit());
        if whole.is_empty() || !digits(whole) || !digits(fraction) || fraction.len() > 4 {
            return Err(help());
        }
        let millionths: u64 = format!("{whole}{fraction:0<4}").parse().map_err(|_| help())?;
        u32::try_from(millionths).ok().filter(|&m| m <= 10_000_000).map(Margin).ok_or_else(help)
    }
}

impl fmt::Display for Margin {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let fraction = format!("{:04}", self.0 % 10_000);
        let fraction = fraction.trim_end_matches('0');
        let point = if fraction.is_empty() { "" } else { "." };
        write!(f, "{}{point}{fraction} %", self.0 / 10_000)
    }
}

/// The largest permitted share of assumed times in the time that decides a check (`--max-assumed`).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct MostAssumed(Margin);

impl FromStr for MostAssumed {
    type Err = String;
    fn from_str(text: &str) -> Result<MostAssumed, String> {
        let most = text.parse().ok().filter(|&Margin(millionths)| millionths <= 1_000_000);
        let help = || format!("'{text}' is not a percentage from 0% to 100%");
        most.map(MostAssumed).ok_or_else(help)
    }
}

impl fmt::Display for MostAssumed {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}

/// How much of the time that decides a check is assumed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Assumed {
    /// The assumed part of the time. For a bound, all that the search left open is included.
    pub time: Picos,
    /// The time that decides the check, of which a part is assumed.
    pub of: Picos,
    /// Whether the assumed part may be less than `time`, because the search left something open.
    pub at_most: bool,
}

impl Assumed {
    /// The assumed part of the bound. If points are not stated: of the bound with all points that the CPU can have.
    fn of_upper(audit: &Audit) -> Assumed {
        let points = audit.points.iter().filter_map(|points| points.most.as_ref());
        let assumed = points.filter(|most| most.founded == Evidence::Assumed);
        let more: Picos = assumed.map(|most| most.more).sum();
        let time = audit.assumed_part() + more;
        let at_most = !audit.is_settled();
        Assumed { time, of: audit.upper_with_all_points(), at_most }
    }

    /// The assumed part of the longest scan found, without refresh that may not occur.
    fn of_lower(audit: &Audit) -> Assumed {
        let of = audit.lower_without_points();
        // The clock's tolerance, and refresh that may not occur, are not part of it.
        let factor = audit.table.factor.as_ref();
        let tolerance = match factor.is_some_and(|one| one.evidence == Evidence::Assumed) {
            true => audit.bound.lower.checked_sub(audit.possible()).unwrap_or_default(),
            false => Picos::ZERO,
        };
        let is_assumed = |side: &str| {
            let name = format!("{side} refresh");
            let mut terms = audit.overhead.iter().filter(|term| term.name == name);
            terms.all(|term| term.evidence == Evidence::Assumed)
        };
        let points = audit.points.iter().filter(|one| is_assumed(one.side)).map(|one| one.time);
        let is_counted = |base: &&UnstatedBase| {
            is_assumed(base.side) && audit.points.iter().all(|one| one.side != base.side)
        };
        let bases = audit.bases.iter().filter(is_counted).map(|base| base.saves);
        let less = tolerance + points.chain(bases).sum();
        let time = audit.table.assumed_time.checked_sub(less).unwrap_or_default();
        Assumed { time: time.min(of), of, at_most: false }
    }

    /// The assumed part as a share.
    #[must_use]
    pub fn share(&self) -> Share {
        Share::of(self.time, self.of)
    }

    /// Whether the assumed part is more than permitted.
    #[must_use]
    pub fn is_above(&self, most: MostAssumed) -> bool {
        u128::from(self.time.0) * 1_000_000 > u128::from(self.of.0) * u128::from((most.0).0)
    }
}

/// The verdict of a check.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Verdict {
    /// The limit is proved: no scan exceeds it, even with the margin added to its time.
    Proved,
    /// The limit is refuted: a scan was found that exceeds it with the margin added, or that never ends.
    Refuted,
    /// The limit is neither proved nor refuted, for these reasons.
    Undecided(Vec<Reason>),
}

impl Verdict {
    /// The name of the verdict in reports.
    #[must_use]
    pub fn name(&self) -> &'static str {
        match self {
            Verdict::Proved => "proved",
            Verdict::Refuted => "refuted",
            Verdict::Undecided(_) => "undecided",
        }
    }
}

/// Which time is compared with a limit.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Measure {
    /// The scan's execution time, including the wait for the constant scan time.
    Cycle,
    /// The scan's execution time, without the wait for the constant scan time.
    Execution,
    /// The longest time without a restart of the watchdog, which the watchdog limits.
    Stretch,
}

impl Measure {
    /// The name of the measure in options and reports.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Measure::Cycle => "cycle",
            Measure::Execution => "execution",
            Measure::Stretch => "stretch",
        }
    }
}

/// The comparison of a time with a limit, and its verdict.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Check {
    /// The limit that is checked.
    pub limit: Picos,
    /// Which time is compared with the limit.
    pub measure: Measure,
    /// The upper bound on the measured time, without the margin.
    pub longest: Picos,
    /// The largest measured time that was found, without the margin. If points are not stated, the refresh time of
    /// points is not included.
    pub took: Picos,
    /// Whether a run from power-up to the scan that takes `took` was found.
    pub is_reached: bool,
    /// The margin that is added before the comparison.
    pub margin: Margin,
    /// The upper bound with the margin. If points are not stated, with all points that the CPU can have.
    pub upper: Picos,
    /// The time `took` with the margin. If points are not stated, the refresh time of points is not included.
    pub lower: Picos,
    /// The assumed part of the time that decides: of the scan found if that refutes the limit, otherwise of the bound.
    pub assumed: Assumed,
    /// The largest permitted share of assumed times. `None` if the user gave none.
    pub most_assumed: Option<MostAssumed>,
    /// The result of the comparison.
    pub verdict: Verdict,
}

impl Check {
    /// Checks an audit against a limit on the scan time, including the wait for the constant scan time. If the bound
    /// may be too low, the limit is not proved. Times that may not occur do not refute it.
    ///
    /// # Examples
    /// ```
    /// use scanbound_audit::verdict::{Check, Margin, Verdict};
    /// use scanbound_audit::{Request, audit};
    /// use scanbound_base::{facts::Facts, time::Picos};
    /// use scanbound_front::Input;
    ///
    /// let inputs = [Input { name: "main.il".into(), bytes: "LD X0\nMOV K1 D0\nEND\n".into() }];
    /// let facts = Facts::parse("facts.toml", "[io]\ninputs = 16\noutputs = 0\n").expect("right facts");
    /// let found = audit(&Request { cpu: Some("Q26UDV"), ..Request::new(&inputs, &facts) })?;
    /// let check = |limit| Check::new(&found, limit, Margin::default()).verdict;
    /// assert_eq!(check(Picos(10_000_000_000)), Verdict::Proved);
    /// assert_eq!(check(Picos(1)), Verdict::Refuted);
    /// # Ok::<(), scanbound_audit::Failure>(())
    /// ```
    #[must_use]
    pub fn new(audit: &Audit, limit: Picos, margin: Margin) -> Check {
        let waits = audit.cycle.lower.unwrap_or_default();
        let lower = audit.cycle_without_points();
        let check = Check {
            measure: Measure::Cycle,
            longest: audit.cycle_with_all_points(),
            took: lower,
            is_reached: audit.is_reached() || waits > limit,
            ..Check::execution(audit, limit, margin)
        };
        check.judged(audit, lower)
    }

    /// Checks an audit against the watchdog time: the longest time without a restart of the watchdog, or the execution
    /// time of the scan if no instruction restarts it. `None` if neither the CPU's default nor any time that the
    /// program sets is known.
    #[must_use]
    pub fn of_watchdog(audit: &Audit, margin: Margin) -> Option<Check> {
        let watchdog = &audit.watchdog;
        let known = watchdog.settings.iter().filter_map(|one| Some(one.times?.0));
        let limit = watchdog.default.into_iter().chain(known).min()?;
        let is_plain = watchdog.settings.is_empty() && watchdog.found.is_empty();
        let check = Check::execution(audit, limit, margin);
        let longest = watchdog.upper.unwrap_or(audit.upper_with_all_points());
        if is_plain {
            return Some(check.judged(audit, audit.lower_without_points()));
        }
        let limit = watchdog.least.filter(|&least| least > Picos::ZERO).unwrap_or(limit);
        let measure = if watchdog.restarts > 0 { Measure::Stretch } else { Measure::Execution };
        let above = |one: &&Stretch| one.watchdog.is_some_and(|most| margin.on(one.took) > most);
        let refuting = watchdog.found.iter().filter(above);
        let refuting = refuting.max_by_key(|one| (one.is_reached, Reverse(one.watchdog), one.took));
        let check = match refuting {
            Some(one) => Check {
                limit: one.watchdog.unwrap_or(limit),
                took: one.took,
                is_reached: one.is_reached,
                ..check
            },
            None => {
                let took = watchdog.found.iter().map(|one| one.took).max();
                Check { limit, took: took.unwrap_or_default(), ..check }
            }
        };
        let check = Check { measure, longest, ..check };
        let lower = if refuting.is_some() { check.took } else { Picos::ZERO };
        let mut check = check.judged(audit, lower);
        check.lower = margin.on(check.took);
        if check.verdict == Verdict::Refuted && refuting.is_none() && watchdog.restarts > 0 {
            // An endless loop may restart the watchdog again and again.
            check.verdict = Verdict::Undecided(reasons(&audit.doubts));
        }
        let unknown = watchdog.settings.iter().find(|one| one.times.is_none());
        let unknown = unknown.filter(|_| !watchdog.is_stated);
        if let (true, Some(one)) = (check.verdict != Verdict::Refuted, unknown) {
            let (device, from) = (watchdog.device, one.from.clone());
            let instruction = one.instruction.to_string();
            let reason = Reason::WatchdogUnknown { device, instruction, from };
            check.verdict = Verdict::Undecided(vec![reason]);
        }
        if check.verdict == Verdict::Proved && watchdog.default.is_none() {
            let reason = Reason::DefaultUnknown { device: watchdog.device };
            check.verdict = Verdict::Undecided(vec![reason]);
        }
        Some(check)
    }

    /// The comparison of a scan's execution time with a limit, still without a verdict.
    fn execution(audit: &Audit, limit: Picos, margin: Margin) -> Check {
        Check {
            limit,
            measure: Measure::Execution,
            longest: audit.upper_with_all_points(),
            took: audit.lower_without_points(),
            is_reached: audit.is_reached(),
            margin,
            upper: Picos::ZERO,
            lower: Picos::ZERO,
            assumed: Assumed::of_upper(audit),
            most_assumed: None,
            verdict: Verdict::Proved,
        }
    }

    /// Adds the verdict to the check. `lower` is a lower bound on the scan time.
    fn judged(mut self, audit: &Audit, lower: Picos) -> Check {
        let (limit, margin) = (self.limit, self.margin);
        (self.upper, self.lower) = (margin.on(self.longest), margin.on(lower));
        let doubts = reasons(&audit.uncounted_doubts());
        self.verdict = if self.lower > limit || audit.is_endless() {
            Verdict::Refuted
        } else if !audit.unbounded.is_empty() {
            Verdict::Undecided(reasons(&audit.doubts))
        } else if self.upper > limit {
            let bases = audit.bases.iter().cloned().map(Reason::SlowestBase);
            let found = [self.open(audit), bases.collect(), reasons(&audit.doubts)];
            Verdict::Undecided(found.concat())
        } else if doubts.is_empty() {
            Verdict::Proved
        } else {
            Verdict::Undecided(doubts)
        };
        if self.verdict == Verdict::Refuted {
            self.assumed = Assumed::of_lower(audit);
        }
        self
    }

    /// Why a limit between the lower and the upper bound is neither proved nor refuted, and what to do.
    fn open(&self, audit: &Audit) -> Vec<Reason> {
        let (limit, margin) = (self.limit, self.margin);
        let cycle = &audit.cycle;
        let most =
            cycle.upper.filter(|_| cycle.longest().is_some_and(|most| margin.on(most) > limit));
        match self.measure {
            Measure::Cycle => match most {
                Some(most) => {
                    let is_sure = cycle.lower == cycle.upper;
                    let device = if is_sure { "" } else { cycle.devices[1] };
                    let interrupts = cycle.interrupts;
                    vec![Reason::ConstantScan { most, interrupts, device }]
                }
                None => open(audit, limit, margin),
            },
            Measure::Execution | Measure::Stretch => {
                let watchdog = &audit.watchdog;
                let is_stretch = self.measure == Measure::Stretch;
                let set = watchdog.settings.iter().filter_map(|one| Some(one.times?.0)).min();
                match (watchdog.default, set) {
                    (Some(default), Some(set)) if self.upper <= set => {
                        vec![Reason::DefaultFirst { default, set, device: watchdog.device }]
                    }
                    (_, None) if margin.on(audit.possible()) <= limit && !is_stretch => {
                        open(audit, limit, margin)
                    }
                    _ => vec![Reason::Between { is_cut: !audit.cuts.is_empty(), fact: None }],
                }
            }
        }
    }

    /// Makes the check undecided if it is refuted by a scan to which no run from power-up was found. An endless loop
    /// refutes the limit in any case.
    #[must_use]
    pub fn if_reached(mut self, audit: &Audit) -> Check {
        if self.verdict == Verdict::Refuted && !audit.is_endless() && !self.is_reached {
            let reason = Reason::NotReached { took: self.took };
            self.verdict = Verdict::Undecided(vec![reason]);
        }
        self
    }

    /// Makes the check undecided if more than the share `most` of the deciding time is assumed. An endless loop refutes
    /// the limit in any case, because it does not depend on times.
    #[must_use]
    pub fn if_assumed_at_most(mut self, audit: &Audit, most: MostAssumed) -> Check {
        self.most_assumed = Some(most);
        if audit.is_endless() || !self.assumed.is_above(most) {
            return self;
        }
        let reason = Reason::Assumed {
            share: self.assumed.share(),
            of_lower: self.verdict == Verdict::Refuted,
            most: most.to_string(),
            first: audit.table.assumed.iter().take(MAX_NAMED).map(|one| one.name.clone()).collect(),
        };
        self.verdict = match self.verdict {
            Verdict::Undecided(reasons) => Verdict::Undecided([reasons, vec![reason]].concat()),
            Verdict::Proved | Verdict::Refuted => Verdict::Undecided(vec![reason]),
        };
        self
    }
}

/// The largest number of assumed times that [`Reason::Assumed`] names.
const MAX_NAMED: usize = 6;

/// As [`Check::open`], for a limit on the execution time of the scan. Empty if the possible scan exceeds the limit and
/// no points are unstated.
fn open(audit: &Audit, limit: Picos, margin: Margin) -> Vec<Reason> {
    let seen = audit.points.iter().map(|points| (points.taken, points.side)).collect();
    let sides = audit.points.iter().map(|points| points.side).collect();
    let upper = audit.bound.upper;
    if margin.on(upper) <= limit {
        let all = |points: &UnstatedPoints| {
            let most = points.most.as_ref().map_or(0, |most| most.points);
            (most.max(points.taken), points.side)
        };
        let all = audit.points.iter().map(all).collect();
        let most = audit.upper_with_all_points();
        let begun: Picos = audit.points.iter().map(|points| points.begun).sum();
        let room = margin.room(limit).checked_sub(upper + begun).unwrap_or_default();
        let largest = audit.points.iter().map(|points| points.sixteen.0).max().unwrap_or(0);
        let more = room.0.checked_div(largest).unwrap_or(0).saturating_mul(16);
        let depends = Reason::MorePoints { seen, all, upper, most };
        return vec![depends, Reason::StatePoints { sides, more: Some(more) }];
    }
    if margin.on(audit.possible()) > limit {
        if audit.points.is_empty() {
            return Vec::new();
        }
        return vec![Reason::FewerPoints(seen), Reason::StatePoints { sides, more: None }];
    }
    vec![match audit.clocked {
        Some(_) => Reason::WithinTolerance,
        None => Reason::Between {
            is_cut: !audit.cuts.is_empty(),
            fact: {
                let count = audit.unknowns.iter().find(|one| one.counts().is_some());
                let first = count.or(audit.unknowns.first());
                first.map(|one| format!("[{}] {}", one.table(), one.fact))
            },
        },
    }]
}

fn reasons(doubts: &[Doubt]) -> Vec<Reason> {
    doubts.iter().map(Reason::from).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::MorePoints;
    use crate::fixture::fixture;

    #[test]
    fn margins_are_exact_and_rounded_up() {
        let margin: Margin = "12.5%".parse().expect("a margin");
        assert_eq!(margin.on(Picos(8)), Picos(9));
        assert_eq!(margin.on(Picos(9)), Picos(11));
        assert_eq!(margin.to_string(), "12.5 %");
        assert_eq!("10%".parse::<Margin>().map(|m| m.to_string()), Ok("10 %".to_owned()));
        assert_eq!(margin.on(Picos(u64::MAX - 1)), Picos(u64::MAX));
        for bad in ["", "%", "10", "-1%", "1.00001%", "2000%", "a%"] {
            assert!(bad.parse::<Margin>().is_err(), "{bad}");
        }
    }

    #[test]
    fn the_limit_itself_is_kept_to() {
        let mut audit = fixture();
        audit.doubts.clear();
        let limit = |ps| Check::new(&audit, Picos(ps), Margin::default()).verdict;
        let (upper, lower) = (audit.bound.upper.0, audit.bound.lower.0);
        assert!(lower < upper);
        assert_eq!(limit(upper), Verdict::Proved);
        assert!(matches!(limit(upper - 1), Verdict::Undecided(_)));
        assert!(matches!(limit(lower), Verdict::Undecided(_)));
        assert_eq!(limit(lower - 1), Verdict::Refuted);
    }

    #[test]
    fn a_doubt_keeps_a_bound_from_being_proof_but_not_from_being_refuted() {
        let mut audit = fixture();
        audit.doubts = vec![Doubt::Interrupts { name: "I0".to_owned(), taken: 1 }];
        let check = |ps| Check::new(&audit, Picos(ps), Margin::default()).verdict;
        assert_eq!(check(u64::MAX), Verdict::Undecided(super::reasons(&audit.doubts)));
        assert_eq!(check(1), Verdict::Refuted);
    }

    #[test]
    fn what_rests_on_assumed_times_can_be_made_a_condition() {
        let mut audit = fixture();
        audit.doubts.clear();
        // 120 us of the scan's 442 us are assumed, and the part of the bound (452.5 us) above that scan counts as
        // assumed.
        let (upper, lower) = (audit.bound.upper, audit.bound.lower);
        let check = |limit, most: &str| {
            let check = Check::new(&audit, limit, Margin::default());
            check.if_assumed_at_most(&audit, most.parse().expect("a share")).verdict
        };
        assert_eq!(check(upper, "28.8398%"), Verdict::Proved);
        let told = |verdict| match verdict {
            Verdict::Undecided(reasons) => told_all(&reasons),
            other => panic!("{other:?}"),
        };
        assert!(told(check(upper, "28.8397%")).contains("28.8 % of the bound rests"));
        let below = Picos(lower.0 - 1);
        assert_eq!(check(below, "27.15%"), Verdict::Refuted);
        assert!(told(check(below, "27.14%")).contains("of the longest scan found"));
        let mut endless = audit.clone();
        let at = scanbound_base::location::Location { file: 0, line: 1, step: None };
        let one = String::new;
        let found = crate::LoopUse { from: at, to: at, begins: one(), ends: one(), certain: true };
        endless.unbounded = vec![found.clone()];
        let check = Check::new(&endless, upper, Margin::default());
        let none = "0%".parse().expect("a share");
        assert_eq!(check.if_assumed_at_most(&endless, none).verdict, Verdict::Refuted);
        for bad in ["30", "101%", "-1%", "", "100.0001%"] {
            assert!(bad.parse::<MostAssumed>().is_err(), "{bad}");
        }
    }

    fn told_all(reasons: &[Reason]) -> String {
        reasons.iter().map(|reason| format!("{reason}\n")).collect()
    }

    /// The fixture without other doubts: 16 input points are charged with 4.3 us, and there may be 4096 in all.
    fn with_points(most: Option<u64>) -> Audit {
        let mut audit = fixture();
        audit.doubts.clear();
        audit.bound.lower = audit.bound.upper;
        audit.points = vec![UnstatedPoints {
            side: "input",
            taken: 16,
            time: Picos(4_300_000),
            sixteen: Picos(4_300_000),
            begun: Picos::ZERO,
            why: "16 input points, since X5 is the highest input used".to_owned(),
            most: most.map(|more| MorePoints {
                points: 4096,
                more: Picos(more),
                evidence: Evidence::Assumed,
                founded: Evidence::Assumed,
                source: String::new(),
            }),
        }];
        audit
    }

    #[test]
    fn points_that_are_not_stated_count_above_and_not_below() {
        let audit = with_points(Some(1_096_500_000));
        let (upper, more, taken) = (audit.bound.upper.0, 1_096_500_000, 4_300_000);
        let check = |ps| Check::new(&audit, Picos(ps), Margin::default());
        assert_eq!(check(upper + more).verdict, Verdict::Proved);
        assert_eq!(check(upper + more).upper, Picos(upper + more));
        let reasons = |ps| match check(ps).verdict {
            Verdict::Undecided(reasons) => told_all(&reasons),
            other => panic!("{other:?}"),
        };
        assert!(
            reasons(upper + more - 1).contains("[io] inputs = N; up to 4064 additional points")
        );
        assert!(reasons(upper).contains("up to 0 additional points"));
        assert!(
            reasons(upper - 1)
                .contains("with the refresh of the 16 input points that the program uses")
        );
        assert!(
            reasons(upper - taken)
                .contains("with the refresh of the 16 input points that the program uses")
        );
        assert_eq!(check(upper - taken - 1).verdict, Verdict::Refuted);
    }

    #[test]
    fn points_of_which_the_most_is_not_known_stay_a_doubt() {
        let audit = with_points(None);
        let check = |ps| Check::new(&audit, Picos(ps), Margin::default()).verdict;
        assert_eq!(check(u64::MAX), Verdict::Undecided(super::reasons(&audit.all_doubts())));
        assert_eq!(check(1), Verdict::Refuted);
        // All possible points are charged, so no doubt remains.
        assert_eq!(with_points(Some(0)).all_doubts(), []);
        assert_eq!(with_points(Some(1)).all_doubts().len(), 1);
    }

    #[test]
    fn what_a_limit_leaves_with_a_margin_keeps_it() {
        let margin: Margin = "12.5%".parse().expect("a margin");
        for limit in 0..100 {
            let room = margin.room(Picos(limit));
            assert!(margin.on(room) <= Picos(limit) && margin.on(Picos(room.0 + 1)) > Picos(limit));
        }
    }
}
