//! Scan times as they are read from a running CPU, one reading after the other.

use scanbound_audit::Share;
use scanbound_base::time::Picos;
use scanbound_link::client::ScanTimes;
use std::io::{self, Write};
use std::time::Duration;

/// A scan that takes at least this part of the bound, in thousandths, is reported.
const NEAR: u64 = 950;

/// A reading of the scan times.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Reading {
    /// The time since the first reading.
    pub at: Duration,
    /// The scan.
    pub time: Picos,
    /// The longest scan time since the CPU started.
    pub longest: Option<Picos>,
    /// How the CPU reported it.
    pub how: How,
}

/// How the CPU reported a scan.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum How {
    /// As the last scan when the CPU was read.
    Read,
    /// As a new longest scan: it was made since the reading before.
    Grown,
}

/// Something about a reading that is worth reporting.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Notice {
    /// It is close to the bound; its share of the bound.
    Near(Share),
    /// It exceeds the bound.
    Above,
}

/// The readings so far.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Watch {
    bound: Option<Picos>,
    readings: Vec<Reading>,
    /// The CPU's longest scan time at the last reading.
    longest: Option<Picos>,
    /// The longest time that was reported to the user.
    told: Picos,
}

impl Watch {
    /// Before the first reading.
    #[must_use]
    pub fn new(bound: Option<Picos>) -> Watch {
        Watch { bound, ..Watch::default() }
    }

    /// The bound.
    #[must_use]
    pub fn bound(&self) -> Option<Picos> {
        self.bound
    }

    /// What was read.
    #[must_use]
    pub fn readings(&self) -> &[Reading] {
        &self.readings
    }

    /// The scan times that were read.
    #[must_use]
    pub fn times(&self) -> Vec<Picos> {
        self.readings.iter().map(|reading| reading.time).collect()
    }

    /// Records what the CPU reported, and returns the new readings. The CPU's longest scan before the first reading is
    /// not among them.
    pub fn take(&mut self, at: Duration, told: ScanTimes) -> &[Reading] {
        let before = self.readings.len();
        let grown = match (self.longest, told.most) {
            // The last scan itself may be the longest.
            (Some(before), Some(now)) if now > before && now != told.current => Some(now),
            _ => None,
        };
        let reading = |time, how| Reading { at, time, longest: told.most, how };
        self.readings.extend(grown.map(|time| reading(time, How::Grown)));
        self.readings.push(reading(told.current, How::Read));
        self.longest = told.most;
        &self.readings[before..]
    }

    /// Whether a time is worth reporting because it is close to the bound or above it. Each case is reported once, and
    /// again for a longer time.
    pub fn notice(&mut self, time: Picos) -> Option<Notice> {
        let bound = self.bound?;
        let share = u128::from(time.0) * 1000;
        if share < u128::from(bound.0) * u128::from(NEAR) || time <= self.told {
            return None;
        }
        self.told = time;
        Some(if time > bound { Notice::Above } else { Notice::Near(Share::of(time, bound)) })
    }
}

/// The heading of the file of readings. `compare` finds the scan times by it, so only one column has a name with
/// `scan`.
///
/// # Errors
/// Those of the writer.
pub fn head(out: &mut dyn Write) -> io::Result<()> {
    writeln!(out, "at_s,scan_ms,longest_ms,how,devices")
}

/// A line of that file; `devices` are names and values.
///
/// # Errors
/// Of the writer.
pub fn row(out: &mut dyn Write, reading: &Reading, devices: &[(String, u16)]) -> io::Result<()> {
    let ms = |time: Picos| {
        let us = time.0 / 1_000_000;
        format!("{}.{:03}", us / 1000, us % 1000)
    };
    let how = match reading.how {
        How::Read => "read",
        How::Grown => "grown",
    };
    let longest = reading.longest.map(ms).unwrap_or_default();
    let devices: Vec<String> =
        devices.iter().map(|(name, value)| format!("{name}={value}")).collect();
    writeln!(
        out,
        "{}.{:03},{},{longest},{how},{}",
        reading.at.as_secs(),
        reading.at.subsec_millis(),
        ms(reading.time),
        devices.join(" ")
    )
}

/// Marks in that file an interval without readings: a comment, which `compare` ignores.
///
/// # Errors
/// Those of the writer.
pub fn gap(out: &mut dyn Write, from: Duration, to: Duration) -> io::Result<()> {
    let seconds = |time: Duration| format!("{}.{:03}", time.as_secs(), time.subsec_millis());
    writeln!(out, "# gap: nothing was read from {} s to {} s", seconds(from), seconds(to))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ms(ms: u64) -> Picos {
        Picos(ms * 1_000_000_000)
    }

    fn told(current: u64, most: u64) -> ScanTimes {
        ScanTimes { current: ms(current), least: None, most: Some(ms(most)) }
    }

    #[test]
    fn a_longest_scan_between_two_readings_is_one_too() {
        let mut watch = Watch::new(None);
        let second = Duration::from_secs(1);
        assert_eq!(watch.take(second, told(3, 20)).len(), 1);
        assert_eq!(watch.take(second, told(3, 20)).len(), 1);
        let grown = watch.take(second, told(3, 21)).to_vec();
        assert_eq!((grown[0].time, grown[0].how), (ms(21), How::Grown));
        assert_eq!((grown[1].time, grown[1].how), (ms(3), How::Read));
        // The last scan is the longest: it is read once.
        assert_eq!(watch.take(second, told(22, 22)).len(), 1);
        assert_eq!(watch.times(), [3, 3, 21, 3, 22].map(ms));
    }

    #[test]
    fn scans_near_the_bound_are_told_of_once() {
        let mut watch = Watch::new(Some(ms(100)));
        assert_eq!(watch.notice(ms(94)), None);
        assert_eq!(watch.notice(ms(95)), Some(Notice::Near(Share::of(ms(95), ms(100)))));
        assert_eq!(watch.notice(ms(95)), None);
        assert_eq!(watch.notice(ms(100)), Some(Notice::Near(Share::of(ms(1), ms(1)))));
        assert_eq!(watch.notice(ms(101)), Some(Notice::Above));
        assert_eq!(watch.notice(ms(101)), None);
        assert_eq!(Watch::new(None).notice(ms(101)), None);
    }

    #[test]
    fn the_file_is_one_that_compare_reads() {
        let mut out = Vec::new();
        let reading = Reading {
            at: Duration::from_millis(1250),
            time: Picos(3_400_000_000),
            longest: Some(ms(5)),
            how: How::Read,
        };
        head(&mut out).expect("written");
        row(&mut out, &reading, &[("X0".to_owned(), 1), ("D5".to_owned(), 7)]).expect("written");
        gap(&mut out, Duration::from_millis(1300), Duration::from_millis(2050)).expect("written");
        row(&mut out, &reading, &[]).expect("written");
        gap(&mut out, Duration::from_secs(3), Duration::from_secs(4)).expect("written");
        let text = String::from_utf8(out.clone()).expect("text");
        let head = "at_s,scan_ms,longest_ms,how,devices";
        let lines: Vec<&str> = text.lines().take(3).collect();
        let gap = "# gap: nothing was read from 1.300 s to 2.050 s";
        assert_eq!(lines, [head, "1.250,3.400,5.000,read,X0=1 D5=7", gap]);
        let selection = crate::Selection::default();
        let read = crate::capture::read("a.csv", &out, &selection).expect("it is read");
        assert_eq!(read.times, [Picos(3_400_000_000); 2]);
    }
}
