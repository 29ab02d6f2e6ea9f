//! The distribution of scan times: bins of a round width, and one for times far above the others.

use super::figures::Figures;
use scanbound_base::time::Picos;

/// The most bins.
const BINS: u64 = 16;

/// A histogram.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Histogram {
    /// The bins' width.
    pub width: Picos,
    /// The bins, each of the same width, from the one with the shortest scan on.
    pub bins: Vec<Bin>,
    /// The number of scans above the last bin.
    pub beyond: usize,
}

/// The scans from `from` up to, but not including, the beginning of the next bin.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Bin {
    /// Where it begins.
    pub from: Picos,
    /// The number of scans.
    pub count: usize,
}

impl Histogram {
    /// The histogram of scan times. A few that are far above all others are only counted.
    #[must_use]
    pub fn of(times: &[Picos], figures: &Figures) -> Histogram {
        let (least, most, usual) = (figures.least.0, figures.most.0, usual(times).0);
        let far = times.len() > 10 && most - usual > 2 * (usual - least);
        let last = if far { usual } else { most };
        let width = round_width((last - least) / BINS + 1);
        let first = least / width * width;
        let count = ((last - first) / width + 1) as usize;
        let mut bins: Vec<Bin> = (0..count as u64)
            .map(|bin| Bin { from: Picos(first + bin * width), count: 0 })
            .collect();
        let mut beyond = 0;
        for time in times {
            match bins.get_mut(((time.0 - first) / width) as usize) {
                Some(bin) => bin.count += 1,
                None => beyond += 1,
            }
        }
        Histogram { width: Picos(width), bins, beyond }
    }
}

/// The longest time after the longest thousandth of the scans, at least one, is removed.
fn usual(times: &[Picos]) -> Picos {
    let mut sorted = times.to_vec();
    sorted.sort_unstable();
    let out = 1 + (sorted.len() / 1000).max(1);
    sorted.get(sorted.len().saturating_sub(out)).copied().unwrap_or_default()
}

/// The next of 1, 2, 5, 10, 20 ... that is not smaller.
fn round_width(least: u64) -> u64 {
    let mut ten = 1_u64;
    loop {
        for step in [1, 2, 5] {
            match ten.checked_mul(step) {
                Some(width) if width >= least => return width,
                Some(_) => {}
                None => return least,
            }
        }
        match ten.checked_mul(10) {
            Some(next) => ten = next,
            None => return least,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(times: &[u64]) -> Histogram {
        let times: Vec<Picos> = times.iter().copied().map(Picos).collect();
        Histogram::of(&times, &Figures::of(&times).expect("times"))
    }

    #[test]
    fn every_scan_is_in_a_bin() {
        let histogram = of(&[100, 101, 115, 131, 131]);
        assert_eq!(histogram.width, Picos(2));
        assert_eq!(histogram.bins.len(), 16);
        assert_eq!(histogram.bins[0], Bin { from: Picos(100), count: 2 });
        assert_eq!(histogram.bins[15], Bin { from: Picos(130), count: 2 });
        assert_eq!(histogram.beyond, 0);
    }

    #[test]
    fn equal_scans_are_one_bin() {
        assert_eq!(of(&[7, 7, 7]).bins, [Bin { from: Picos(7), count: 3 }]);
    }

    #[test]
    fn what_lies_far_out_does_not_flatten_the_rest() {
        let mut times: Vec<u64> = (0..2000).map(|n| 1_000_000 + n % 50).collect();
        times.push(9_000_000);
        let histogram = of(&times);
        assert_eq!(histogram.beyond, 1);
        assert!(histogram.width < Picos(10));
    }
}
