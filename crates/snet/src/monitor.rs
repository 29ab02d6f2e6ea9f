//! Reads the state of a net from a C200H that runs its code, over Host Link.
//!
//! A poll requests the words of the net's relays, and the flags, current values and set values of its timers and
//! counters. The values in one response are from the same moment, those in different responses are not; so a reading
//! states the number of responses. If one request fails, the poll gives no reading.

use super::address::{Address, Area};
use super::{Diagram, Kind};
use scanbound_link::device::Device;
use scanbound_link::hostlink::{AREAS, MAX_FLAGS, MAX_WORDS};
use scanbound_link::station::Station;
use scanbound_link::{Coil, Fault, Setting, State};
use std::collections::BTreeMap;
use std::time::{Duration, Instant};

/// Words are requested together if their distance is at most this.
const GAP: u32 = 8;

/// The state of a place.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct PlaceReading {
    /// Its relay: of a box whether it is marked, of a timer its box (b), of a counter whether it has started (c);
    /// `None` without an address.
    pub relay: Option<bool>,
    /// The completion flag of its timer or counter (P, bc).
    pub over: Option<bool>,
    /// The set value: tenths of a second, or the count.
    pub setting: Option<u16>,
    /// The current value in the PLC, which counts down from the set value.
    pub present: Option<u16>,
}

impl PlaceReading {
    /// The elapsed time or the count: set value minus current value.
    #[must_use]
    pub fn elapsed(self) -> Option<u16> {
        self.setting?.checked_sub(self.present?)
    }

    /// Whether a timer runs or a counter counts: it has started and has not finished.
    #[must_use]
    pub fn is_running(self) -> Option<bool> {
        Some(self.relay? && !self.over?)
    }
}

/// The result of a poll.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Reading {
    /// The number of responses that it consists of.
    pub answers: usize,
    /// The time from the first request to the last response.
    pub took: Duration,
    /// Whether the CPU runs.
    pub cpu: State,
    /// By place.
    pub places: Vec<PlaceReading>,
    /// By transition: whether its relay is on.
    pub transitions: Vec<Option<bool>>,
    /// By outer gate.
    pub outers: Vec<Option<bool>>,
}

impl Reading {
    /// Whether all values are from the same moment.
    #[must_use]
    pub fn is_of_one_moment(&self) -> bool {
        self.answers == 1
    }
}

/// The requests for one net.
#[derive(Debug, Clone)]
pub struct Plan {
    /// Blocks of words: the first one, and their number.
    words: Vec<(Device, u16)>,
    /// Blocks of timers and counters: the first one, and their number.
    values: Vec<(u32, u16)>,
    flags: Vec<(u32, u16)>,
    relays: Vec<Option<Address>>,
    coils: Vec<Option<(Coil, u32)>>,
    transitions: Vec<Option<Address>>,
    outers: Vec<Option<Address>>,
}

/// Groups numbers to blocks, with gaps of at most `gap` and a length of at most `most`.
fn runs(numbers: impl Iterator<Item = u32>, gap: u32, most: u32) -> Vec<(u32, u16)> {
    let mut sorted: Vec<u32> = numbers.collect();
    sorted.sort_unstable();
    let mut runs: Vec<(u32, u32)> = Vec::new();
    for number in sorted {
        match runs.last_mut() {
            Some((first, last)) if number <= *last + gap && number < *first + most => {
                *last = number
            }
            _ => runs.push((number, number)),
        }
    }
    let long = |(first, last): (u32, u32)| (first, u16::try_from(last - first + 1).unwrap_or(1));
    runs.into_iter().map(long).collect()
}

fn area_name(area: Area) -> &'static str {
    match area {
        Area::Internal => "IR",
        other => other.letters(),
    }
}

impl Plan {
    /// Plans the requests for a net.
    #[must_use]
    pub fn new(diagram: &Diagram) -> Plan {
        let relays: Vec<_> = diagram.places.iter().map(|place| place.head.address).collect();
        let transitions: Vec<_> = diagram.transitions.iter().map(|one| one.head.address).collect();
        let outers: Vec<_> = diagram.outers.iter().map(|outer| outer.head.address).collect();
        let coils: Vec<Option<(Coil, u32)>> = diagram
            .places
            .iter()
            .map(|place| match place.kind {
                Kind::Box => None,
                Kind::Timer { number, .. } => Some((Coil::Timer, u32::from(number?))),
                Kind::Counter { number, .. } => Some((Coil::Counter, u32::from(number?))),
            })
            .collect();
        let mut areas: BTreeMap<Area, Vec<u32>> = BTreeMap::new();
        for address in relays.iter().chain(&transitions).chain(&outers).flatten() {
            areas.entry(address.area).or_default().push(address.word.into());
        }
        let words = areas.into_iter().flat_map(|(area, words)| {
            let name = area_name(area);
            runs(words.into_iter(), GAP, MAX_WORDS).into_iter().filter_map(move |(first, count)| {
                Some((Device::named(&format!("{name}{first}"), AREAS)?, count))
            })
        });
        let words = words.collect();
        let numbers = || coils.iter().flatten().map(|&(_, number)| number);
        let values = runs(numbers(), GAP, MAX_WORDS);
        let flags = runs(numbers(), 4 * GAP, MAX_FLAGS);
        Plan { words, values, flags, relays, coils, transitions, outers }
    }

    /// The number of relays and gates with an address, and of those without.
    #[must_use]
    pub fn addressed(&self) -> (usize, usize) {
        let all = || self.relays.iter().chain(&self.transitions).chain(&self.outers);
        let with = all().flatten().count();
        (with, all().count() - with)
    }

    /// Sends all requests once.
    ///
    /// # Errors
    /// A response is missing or invalid.
    pub fn poll(&self, station: &mut Station) -> Result<Reading, Fault> {
        station.open()?;
        let begun = Instant::now();
        let mut answers = 0;
        let mut words: BTreeMap<(&str, u32), u16> = BTreeMap::new();
        for &(device, count) in &self.words {
            let read = station.words(device, count)?;
            answers += 1;
            words.extend(
                (device.index..).zip(read).map(|(at, word)| ((device.area.name, at), word)),
            );
        }
        let (mut present, mut over) = (BTreeMap::new(), BTreeMap::new());
        for &(first, count) in &self.values {
            present.extend((first..).zip(station.present(first, count)?));
            answers += 1;
        }
        for &(first, count) in &self.flags {
            over.extend((first..).zip(station.flags(first, count)?));
            answers += 1;
        }
        let mut settings = BTreeMap::new();
        for &(coil, number) in self.coils.iter().flatten() {
            let setting = match station.setting(0, coil, number) {
                Ok(setting) => Some(setting),
                // The PLC's program has no such timer, so it is not the code of this net.
                Err(Fault::EndCode { .. }) => None,
                Err(fault) => return Err(fault),
            };
            answers += 1;
            let value = match setting {
                Some(Setting::Number(number)) => Some(number),
                Some(Setting::Word { area, index }) => {
                    let device = station_device(area, index)?;
                    answers += 1;
                    station.words(device, 1)?.first().copied().and_then(decimal)
                }
                None => None,
            };
            settings.insert(number, value);
        }
        let cpu = station.state()?;
        let took = begun.elapsed();
        let bit = |address: &Option<Address>| {
            let address = (*address)?;
            let word = words.get(&(area_name(address.area), u32::from(address.word)))?;
            Some(word >> address.bit & 1 == 1)
        };
        let place = |(relay, coil): (&Option<Address>, &Option<(Coil, u32)>)| PlaceReading {
            relay: bit(relay),
            over: coil.and_then(|(_, number)| over.get(&number).copied()),
            setting: coil.and_then(|(_, number)| settings.get(&number).copied().flatten()),
            present: coil.and_then(|(_, number)| present.get(&number).copied().and_then(decimal)),
        };
        Ok(Reading {
            answers,
            took,
            cpu,
            places: self.relays.iter().zip(&self.coils).map(place).collect(),
            transitions: self.transitions.iter().map(bit).collect(),
            outers: self.outers.iter().map(bit).collect(),
        })
    }
}

fn station_device(area: &str, index: u32) -> Result<Device, Fault> {
    let name = format!("{area}{index}");
    Device::named(&name, AREAS)
        .ok_or_else(|| Fault::Usage(format!("{name} is not a valid word address")))
}

/// The value of a BCD word; `None` if a digit is above 9.
fn decimal(word: u16) -> Option<u16> {
    (0..4).rev().try_fold(0, |sum, place| {
        let digit = word >> (4 * place) & 15;
        (digit < 10).then_some(10 * sum + digit)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::text::read;

    #[test]
    fn neighbours_are_asked_for_together() {
        assert_eq!(runs([30, 31, 33, 60].into_iter(), 8, 30), [(30, 4), (60, 1)]);
        assert_eq!(runs((0..40).rev(), 8, 30), [(0, 30), (30, 10)]);
        assert_eq!(runs([].into_iter(), 8, 30), []);
        assert_eq!((decimal(0x1234), decimal(0x12A4), decimal(0)), (Some(1234), None, Some(0)));
    }

    #[test]
    fn a_plan_has_every_word_once() {
        let text = "outer E = 00001\nbox A = 00300\ntimer W 1.0s = HR0102 TIM 007\nbox N\n\
                    transition T = 00305 : A -> W if E\ntransition U = LR0000 : W -> A N\n";
        let diagram = read("a.snet", text).expect("a net");
        let plan = Plan::new(&diagram);
        let asked: Vec<(String, u16)> =
            plan.words.iter().map(|(device, count)| (device.to_string(), *count)).collect();
        let own = [("IR0", 4), ("HR1", 1), ("LR0", 1)];
        assert_eq!(asked, own.map(|(name, count)| (name.to_owned(), count)));
        assert_eq!((&*plan.values, &*plan.flags), (&[(7, 1)][..], &[(7, 1)][..]));
        assert_eq!(plan.addressed(), (5, 1));
    }

    #[test]
    fn elapsed_is_the_set_value_less_the_present_one() {
        let shown = |setting, present| {
            PlaceReading { setting, present, ..PlaceReading::default() }.elapsed()
        };
        assert_eq!(shown(Some(25), Some(13)), Some(12));
        // The set value was changed between two answers: nothing is made up.
        assert_eq!(shown(Some(5), Some(13)), None);
        assert_eq!(shown(None, Some(13)), None);
    }
}
