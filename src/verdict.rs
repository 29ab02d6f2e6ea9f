//! Whether a program keeps to a limit: proved, refuted by a scan, or undecided with the reasons.

use crate::audit::Audit;
use crate::time::Picos;
use std::fmt;
use std::str::FromStr;

/// What is added to a time before it is held against the limit, in millionths.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Margin(u32);

impl Margin {
    /// The time with the margin added, rounded up.
    #[must_use]
    pub fn on(self, time: Picos) -> Picos {
        let scaled = u128::from(time.0) * (1_000_000 + u128::from(self.0));
        Picos(u64::try_from(scaled.div_ceil(1_000_000)).expect("time overflow"))
    }

    /// Whether there is none.
    #[must_use]
    pub fn is_none(self) -> bool {
        self.0 == 0
    }
}

impl FromStr for Margin {
    type Err = String;
    fn from_str(text: &str) -> Result<Margin, String> {
        let help = || format!("'{text}' is not a margin: give percent from 0% to 1000%");
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

/// The answer to a check.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Verdict {
    /// No scan is over the limit.
    Proved,
    /// A scan that was replayed is over the limit, or never ends.
    Refuted,
    /// Neither is known, for these reasons.
    Undecided(Vec<String>),
}

/// A limit and what became of it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Check {
    /// The limit.
    pub limit: Picos,
    /// What is added to the scan before it is held against the limit.
    pub margin: Margin,
    /// The upper bound with the margin.
    pub upper: Picos,
    /// The replayed scan with the margin.
    pub lower: Picos,
    /// The answer.
    pub verdict: Verdict,
}

impl Check {
    /// Holds an audit against a limit. What may make the bound too low keeps it from being proved.
    #[must_use]
    pub fn new(audit: &Audit, limit: Picos, margin: Margin) -> Check {
        let (upper, lower) = (margin.on(audit.bound.upper), margin.on(audit.possible()));
        let verdict = if lower > limit || !audit.unbounded.is_empty() {
            Verdict::Refuted
        } else if upper > limit {
            let reason = match audit.clocked {
                Some(_) => {
                    "the limit lies within the clock's tolerance; measure the clock and state it (--clock)"
                }
                None => {
                    "the limit lies between the scan that was found and the bound; give the search more time (--time-limit)"
                }
            };
            Verdict::Undecided(vec![reason.to_owned()])
        } else if audit.doubts.is_empty() {
            Verdict::Proved
        } else {
            Verdict::Undecided(audit.doubts.clone())
        };
        Check { limit, margin, upper, lower, verdict }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::audit::fixture::fixture;

    #[test]
    fn margins_are_exact_and_rounded_up() {
        let margin: Margin = "12.5%".parse().expect("a margin");
        assert_eq!(margin.on(Picos(8)), Picos(9));
        assert_eq!(margin.on(Picos(9)), Picos(11));
        assert_eq!(margin.to_string(), "12.5 %");
        assert_eq!("10%".parse::<Margin>().map(|m| m.to_string()), Ok("10 %".to_owned()));
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
        audit.doubts = vec!["I0 may run any number of times".to_owned()];
        let check = |ps| Check::new(&audit, Picos(ps), Margin::default()).verdict;
        assert_eq!(check(u64::MAX), Verdict::Undecided(audit.doubts.clone()));
        assert_eq!(check(1), Verdict::Refuted);
    }
}
