//! The registers in which CPUs store their scan times, and their formats.
//!
//! Q: QnUCPU User's Manual (SD520 to SD527). The others are unverified: docs/measuring.md says how to check in
//! a minute whether they are right for a CPU.

use scanbound_base::time::Picos;

/// A scan time in registers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Register {
    /// The area.
    pub area: &'static str,
    /// Its first word.
    pub first: u32,
    /// Its format.
    pub form: TimeFormat,
}

/// The format of a scan time.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TimeFormat {
    /// A word of milliseconds, and one of microseconds.
    Parts,
    /// Tenths of a millisecond in one word.
    Word,
    /// Tenths of a millisecond in two words, the low word first.
    Double,
    /// Tenths of a millisecond in four decimal digits.
    Bcd,
}

/// The registers in which a CPU stores its scan times.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Registers {
    /// The family of timing tables.
    pub family: &'static str,
    /// The last scan.
    pub current: Register,
    /// The shortest scan since the CPU started.
    pub least: Option<Register>,
    /// The longest scan since the CPU started.
    pub most: Option<Register>,
    /// The resolution of the times.
    pub step: Picos,
}

/// A tenth of a millisecond.
const TENTH: Picos = Picos(100_000_000);

const fn at(area: &'static str, first: u32, form: TimeFormat) -> Register {
    Register { area, first, form }
}

const fn parts(
    family: &'static str,
    current: u32,
    least: u32,
    most: u32,
    step: Picos,
) -> Registers {
    Registers {
        family,
        current: at("SD", current, TimeFormat::Parts),
        least: Some(at("SD", least, TimeFormat::Parts)),
        most: Some(at("SD", most, TimeFormat::Parts)),
        step,
    }
}

const ALL: &[Registers] = &[
    parts("q", 520, 524, 526, TENTH),
    parts("l", 520, 524, 526, TENTH),
    parts("iqr", 520, 522, 524, Picos(1_000_000)),
    parts("fx5", 520, 522, 524, TENTH),
    Registers {
        family: "fx",
        current: at("D", 8010, TimeFormat::Word),
        least: Some(at("D", 8011, TimeFormat::Word)),
        most: Some(at("D", 8012, TimeFormat::Word)),
        step: TENTH,
    },
    Registers {
        family: "cs",
        current: at("A", 264, TimeFormat::Double),
        least: None,
        most: Some(at("A", 262, TimeFormat::Double)),
        step: TENTH,
    },
    Registers {
        family: "c",
        current: at("AR", 27, TimeFormat::Bcd),
        least: None,
        most: Some(at("AR", 26, TimeFormat::Bcd)),
        step: TENTH,
    },
];

/// The registers of a family of timing tables.
#[must_use]
pub fn of(family: &str) -> Option<&'static Registers> {
    ALL.iter().find(|one| one.family == family)
}

/// The families whose registers are known.
pub fn families() -> impl Iterator<Item = &'static str> {
    ALL.iter().map(|one| one.family)
}

impl TimeFormat {
    /// How many words it takes.
    #[must_use]
    pub fn words(self) -> u16 {
        match self {
            TimeFormat::Parts | TimeFormat::Double => 2,
            TimeFormat::Word | TimeFormat::Bcd => 1,
        }
    }

    /// The time in these words. `None` if they do not hold a time.
    #[must_use]
    pub fn read(self, words: &[u16]) -> Option<Picos> {
        let tenths = |tenths: u32| Picos(u64::from(tenths) * TENTH.0);
        match (self, words) {
            (TimeFormat::Parts, &[ms, us]) if us < 1000 => {
                Some(Picos(u64::from(ms) * 1_000_000_000 + u64::from(us) * 1_000_000))
            }
            (TimeFormat::Word, &[word]) => Some(tenths(word.into())),
            (TimeFormat::Double, &[low, high]) => {
                Some(tenths(u32::from(high) << 16 | u32::from(low)))
            }
            (TimeFormat::Bcd, &[word]) => {
                let digits = [12, 8, 4, 0].map(|shift| u32::from(word >> shift & 0xF));
                let all = digits.iter().all(|digit| *digit < 10);
                all.then(|| tenths(digits.iter().fold(0, |sum, digit| 10 * sum + digit)))
            }
            _ => None,
        }
    }

    /// Encodes a time. A time that is too long becomes the longest possible one.
    #[must_use]
    pub fn write(self, time: Picos) -> Vec<u16> {
        let low = |number: u64| u16::try_from(number).unwrap_or(u16::MAX);
        let tenths = time.0 / TENTH.0;
        match self {
            TimeFormat::Parts => {
                vec![low(time.0 / 1_000_000_000), low(time.0 / 1_000_000 % 1000)]
            }
            TimeFormat::Word => vec![low(tenths)],
            TimeFormat::Double => {
                let tenths = u32::try_from(tenths).unwrap_or(u32::MAX);
                vec![low(u64::from(tenths & 0xFFFF)), low(u64::from(tenths >> 16))]
            }
            TimeFormat::Bcd => {
                let tenths = tenths.min(9999);
                let digit = |power: u64| low(tenths / power % 10);
                vec![digit(1000) << 12 | digit(100) << 8 | digit(10) << 4 | digit(1)]
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scan_times_are_written_as_they_are_read() {
        assert_eq!(TimeFormat::Parts.read(&[3, 400]), Some(Picos(3_400_000_000)));
        assert_eq!(TimeFormat::Parts.read(&[3, 1000]), None);
        assert_eq!(TimeFormat::Bcd.read(&[0x0123]), Some(Picos(12_300_000_000)));
        assert_eq!(TimeFormat::Bcd.read(&[0x00A3]), None);
        assert_eq!(TimeFormat::Double.read(&[1, 1]), Some(Picos(6_553_700_000_000)));
        for form in [TimeFormat::Parts, TimeFormat::Word, TimeFormat::Double, TimeFormat::Bcd] {
            for tenths in [0, 1, 34, 999, 1000, 9999] {
                let time = Picos(tenths * TENTH.0);
                let words = form.write(time);
                assert_eq!(words.len(), usize::from(form.words()));
                assert_eq!(form.read(&words), Some(time), "{form:?} {tenths}");
            }
        }
        for (at, one) in ALL.iter().enumerate() {
            assert!(ALL[..at].iter().all(|other| other.family != one.family));
        }
    }
}
