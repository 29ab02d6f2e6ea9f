//! The figures that are compared: those of the measurement and those of the analysis.

use scanbound_audit::Audit;
use scanbound_base::time::Picos;

/// The bounds of a scan from the analysis.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Bounds {
    /// No scan takes longer.
    pub upper: Picos,
    /// The time of a replayed scan.
    pub lower: Picos,
    /// Every scan takes at least this long if the table's times are those of the machine: the time that no condition
    /// avoids, without the service factor, because services need not run.
    pub least: Picos,
    /// The timing table.
    pub table: String,
    /// The part of the bound that consists of assumed times.
    pub assumed: Picos,
    /// Why the bound may be too low.
    pub doubts: Vec<String>,
    /// For a machine that executes one word in each clock cycle: the number of words in each scan.
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
    /// The number of scans.
    pub count: usize,
    /// The shortest.
    pub least: Picos,
    /// The mean, rounded to the nearest picosecond.
    pub mean: Picos,
    /// Half of the scans take at most this long.
    pub median: Picos,
    /// 99.9 % of the scans take at most this long (nearest rank).
    pub p999: Picos,
    /// The longest.
    pub most: Picos,
    /// The longest scan's number, from 1.
    pub most_at: usize,
}

impl Figures {
    /// The figures of scan times. `None` if there are no times.
    #[must_use]
    pub fn of(times: &[Picos]) -> Option<Figures> {
        let mut sorted = times.to_vec();
        sorted.sort_unstable();
        let (least, most) = (*sorted.first()?, *sorted.last()?);
        let count = sorted.len();
        let sum: u128 = sorted.iter().map(|time| u128::from(time.0)).sum();
        let mean = (sum + count as u128 / 2) / count as u128;
        // The nearest rank: the smallest time that is not exceeded by this share of the scans.
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
