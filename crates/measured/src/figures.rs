//! The figures that are compared: those of the measurement, and what the analysis says.

use scanbound_audit::Audit;
use scanbound_base::time::Picos;

/// What the analysis says about a scan.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Bounds {
    /// No scan takes longer.
    pub upper: Picos,
    /// A scan that was replayed takes this long.
    pub lower: Picos,
    /// Every scan takes as long at least, if the table's times are the machine's: what no condition avoids,
    /// without the factor, which allows for what need not happen.
    pub least: Picos,
    /// The timing table.
    pub table: String,
    /// How much of the bound rests on assumed times.
    pub assumed: Picos,
    /// Why the bound may be too low.
    pub doubts: Vec<String>,
    /// The words of a scan and the clock's division, for a machine that runs one word a clock.
    pub clocked: Option<u64>,
}

impl Bounds {
    /// The bounds of an audit.
    #[must_use]
    pub fn of(audit: &Audit) -> Bounds {
        Bounds {
            upper: audit.cycle_upper(),
            lower: audit.cycle_lower(),
            least: audit.least(),
            table: audit.table.name.clone(),
            assumed: audit.table.assumed_time,
            doubts: audit.all_doubts().iter().map(ToString::to_string).collect(),
            clocked: audit.clocked,
        }
    }
}

/// The figures of a measurement.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Figures {
    /// How many scans.
    pub count: usize,
    /// The shortest.
    pub least: Picos,
    /// The mean, rounded to the nearest picosecond.
    pub mean: Picos,
    /// Half of the scans are no longer.
    pub median: Picos,
    /// 99.9 in a hundred scans are no longer (nearest rank).
    pub p999: Picos,
    /// The longest.
    pub most: Picos,
    /// The longest scan's number, from 1.
    pub most_at: usize,
}

impl Figures {
    /// The figures of scan times; `None` of none.
    #[must_use]
    pub fn of(times: &[Picos]) -> Option<Figures> {
        let mut sorted = times.to_vec();
        sorted.sort_unstable();
        let (least, most) = (*sorted.first()?, *sorted.last()?);
        let count = sorted.len();
        let sum: u128 = sorted.iter().map(|time| u128::from(time.0)).sum();
        let mean = (sum + count as u128 / 2) / count as u128;
        // The nearest rank: the smallest time that so many are no longer than.
        let rank = |thousandths: usize| sorted[(count * thousandths).div_ceil(1000).max(1) - 1];
        Some(Figures {
            count,
            least,
            mean: Picos(u64::try_from(mean).unwrap_or(u64::MAX)),
            median: rank(500),
            p999: rank(999),
            most,
            most_at: times.iter().position(|&time| time == most)? + 1,
        })
    }
}
