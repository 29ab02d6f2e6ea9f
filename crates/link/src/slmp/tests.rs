//! Frames of SLMP against frames made by hand from the description of the protocol.

use super::*;
use crate::State;

/// A memory in which each word is its number, and each third bit is on.
pub struct Counted;

impl Memory for Counted {
    fn words(&mut self, area: &str, first: u32, count: u32) -> Option<Vec<u16>> {
        let all = matches!(area, "D" | "SD" | "M") && first + count <= 12_288;
        all.then(|| (first..first + count).map(|n| n as u16).collect())
    }

    fn bits(&mut self, area: &str, first: u32, count: u32) -> Option<Vec<bool>> {
        (area == "M" && first + count <= 8192)
            .then(|| (first..first + count).map(|n| n % 3 == 0).collect())
    }

    fn state(&mut self) -> State {
        State::Run
    }

    fn model(&mut self) -> String {
        "Q26UDVCPU".to_owned()
    }

    fn scan_times(&mut self) -> [u32; 3] {
        [34, 50, 20]
    }
}

fn device(name: &str) -> Device {
    Device::named(name, AREAS).expect("a device")
}

const READ: [u8; 21] = [
    0x50, 0x00, 0x00, 0xFF, 0xFF, 0x03, 0x00, 0x0C, 0x00, 0x04, 0x00, 0x01, 0x04, 0x00, 0x00, 0x08,
    0x02, 0x00, 0xA9, 0x08, 0x00,
];

#[test]
fn reading_scan_times_is_the_frame_of_the_manual() {
    assert_eq!(request(Query::Words(device("SD520"), 8), Code::Binary), READ);
    let text = request(Query::Words(device("SD520"), 8), Code::Ascii);
    assert_eq!(text, b"500000FF03FF000018000404010000SD0005200008");
    let bits = request(Query::Bits(device("X1F"), 3), Code::Ascii);
    assert!(bits.ends_with(b"04010001X*00001F0003"));
}

#[test]
fn answers_hold_words_least_byte_first() {
    let frame =
        [0xD0, 0x00, 0x00, 0xFF, 0xFF, 0x03, 0x00, 0x06, 0x00, 0x00, 0x00, 0x03, 0x00, 0x90, 0x01];
    assert_eq!(split(&frame, true), Split::Frame(frame.len()));
    assert_eq!(words(&frame, 2), Ok(vec![3, 400]));
    assert!(
        matches!(words(&frame, 3), Err(Wrong::NoAnswer(why)) if why.contains("2 were received"))
    );
    assert_eq!(words(b"D00000FF03FF00000C000000030190", 2), Ok(vec![3, 0x190]));
}

#[test]
fn end_codes_are_told() {
    let frame = [
        0xD0, 0x00, 0x00, 0xFF, 0xFF, 0x03, 0x00, 0x0B, 0x00, 0x56, 0xC0, 0x00, 0xFF, 0xFF, 0x03,
        0x00, 0x01, 0x04, 0x00, 0x00,
    ];
    let Err(Wrong::EndCode { code, meaning }) = words(&frame, 1) else { panic!("a refusal") };
    assert_eq!(code, "C056");
    assert!(meaning.contains("beyond"));
}

#[test]
fn a_stream_is_split_at_frames() {
    for length in 0..READ.len() {
        assert_eq!(split(&READ[..length], false), Split::More, "{length}");
    }
    assert_eq!(split(&[READ.as_slice(), &[1, 2]].concat(), false), Split::Frame(READ.len()));
    assert_eq!(split(b"GET / HTTP/1.1", false), Split::Garbage);
    assert_eq!(split(&READ, true), Split::Garbage);
    assert_eq!(split(b"500000FF03FF0000ZZ", false), Split::Garbage);
}

#[test]
fn the_cpu_answers_what_it_is_asked() {
    for code in [Code::Binary, Code::Ascii] {
        let ask = |ask| answer(&request(ask, code), &mut Counted);
        assert_eq!(words(&ask(Query::Words(device("SD520"), 3)), 3), Ok(vec![520, 521, 522]));
        let on = [true, false, false, true, false];
        assert_eq!(bits(&ask(Query::Bits(device("M3"), 5)), 5), Ok(on.to_vec()));
        assert_eq!(model(&ask(Query::Model)), Ok("Q26UDVCPU".to_owned()));
        let refused = |frame: Vec<u8>| match words(&frame, 1) {
            Err(Wrong::EndCode { code, .. }) => code,
            other => panic!("{other:?}"),
        };
        assert_eq!(refused(ask(Query::Words(device("D12288"), 1))), "C056");
        assert_eq!(refused(ask(Query::Words(device("M1"), 1))), "C05C");
        assert_eq!(refused(ask(Query::Words(device("D0"), 961))), "C051");
        assert_eq!(refused(ask(Query::Bits(device("D0"), 1))), "C05C");
    }
}

#[test]
fn writing_is_not_known() {
    // A batch write of one word to D100.
    let frame = [
        0x50, 0x00, 0x00, 0xFF, 0xFF, 0x03, 0x00, 0x0E, 0x00, 0x04, 0x00, 0x01, 0x14, 0x00, 0x00,
        0x64, 0x00, 0x00, 0xA8, 0x01, 0x00, 0x07, 0x00,
    ];
    let Err(Wrong::EndCode { code, .. }) = words(&answer(&frame, &mut Counted), 1) else {
        panic!("a refusal")
    };
    assert_eq!(code, "C059");
}

#[test]
fn no_frame_brings_it_down() {
    // Every cut and every changed byte of requests, whole frames or not.
    for ask in [Query::Words(device("SD520"), 8), Query::Bits(device("M0"), 5), Query::Model] {
        for code in [Code::Binary, Code::Ascii] {
            let frame = request(ask, code);
            for at in 0..frame.len() {
                assert!(!answer(&frame[..at], &mut Counted).is_empty());
                for value in 0..=255 {
                    let mut changed = frame.clone();
                    changed[at] = value;
                    let _ = split(&changed, false);
                    let back = answer(&changed, &mut Counted);
                    assert_eq!(split(&back, true), Split::Frame(back.len()));
                }
            }
        }
    }
}
