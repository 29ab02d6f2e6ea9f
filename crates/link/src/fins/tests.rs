//! Frames of FINS against frames made by hand from the description of the protocol.

use super::*;

struct Counted;

impl Memory for Counted {
    fn words(&mut self, area: &str, first: u32, count: u32) -> Option<Vec<u16>> {
        let all = matches!(area, "A" | "D") && first + count <= 1000;
        all.then(|| (first..first + count).map(|n| n as u16).collect())
    }

    fn bits(&mut self, _: &str, _: u32, _: u32) -> Option<Vec<bool>> {
        None
    }

    fn state(&mut self) -> State {
        State::Stop
    }

    fn model(&mut self) -> String {
        "CJ2M".to_owned()
    }

    fn scan_times(&mut self) -> [u32; 3] {
        [650, 700, 0x0001_0002]
    }
}

const NODES: Nodes = Nodes { own: 2, plc: 1 };

/// Two words from A264 on.
const READ: [u8; 18] =
    [0x80, 0, 2, 0, 1, 0, 0, 2, 0, 7, 0x01, 0x01, 0xB3, 0x01, 0x08, 0x00, 0x00, 0x02];

fn device(name: &str) -> Device {
    Device::named(name, AREAS).expect("a device")
}

#[test]
fn reading_cycle_times_is_the_frame_of_the_manual() {
    assert_eq!(request(Query::Words(device("A264"), 2), NODES, 7), READ);
    assert_eq!(request(Query::CycleTimes, NODES, 7)[10..], [0x06, 0x20, 0x01]);
    assert_eq!(request(Query::State, NODES, 7)[10..], [0x06, 0x01]);
}

#[test]
fn answers_hold_words_most_byte_first() {
    let frame = [0xC0, 0, 2, 0, 2, 0, 0, 1, 0, 7, 0x01, 0x01, 0, 0, 0x02, 0x8A, 0, 0];
    assert_eq!(accepted(&frame, &READ).and_then(|data| words(data, 2)), Ok(vec![650, 0]));
    assert!(accepted(&frame, &READ).and_then(|data| words(data, 1)).is_err());
    // Bits that tell of a battery that is low are no refusal.
    let mut warned = frame;
    warned[13] = 0x40;
    assert!(accepted(&warned, &READ).is_ok());
    let mut other = frame;
    other[9] = 8;
    assert!(matches!(accepted(&other, &READ), Err(Wrong::NoAnswer(_))));
    let mut refused = frame;
    refused[12..14].copy_from_slice(&[0x11, 0x04]);
    let Err(Wrong::EndCode { code, .. }) = accepted(&refused, &READ) else { panic!("a refusal") };
    assert_eq!(code, "1104");
    assert!(accepted(&frame[..11], &READ).is_err() && accepted(&frame[..13], &READ).is_err());
}

#[test]
fn the_cpu_answers_what_it_is_asked() {
    let ask = |ask| {
        let request = request(ask, NODES, 9);
        let frame = answer(&request, &mut Counted).expect("an answer");
        assert_eq!((frame[4], frame[7]), (NODES.own, NODES.plc));
        accepted(&frame, &request).map(<[u8]>::to_vec)
    };
    let read = ask(Query::Words(device("A264"), 2)).and_then(|data| words(&data, 2));
    assert_eq!(read, Ok(vec![264, 265]));
    assert_eq!(ask(Query::State).and_then(|data| state(&data)), Ok(State::Stop));
    let times = ask(Query::CycleTimes).and_then(|data| cycle_times(&data));
    assert_eq!(times, Ok([650, 700, 0x0001_0002]));
    let code = |refused| match refused {
        Err(Wrong::EndCode { code, .. }) => code,
        other => panic!("{other:?}"),
    };
    assert_eq!(code(ask(Query::Words(device("A999"), 2))), "1104");
    assert_eq!(code(ask(Query::Words(device("A0"), 501))), "110B");
    let mut unknown = READ;
    // A memory area write.
    unknown[11] = 0x02;
    let back = answer(&unknown, &mut Counted).expect("an answer");
    assert_eq!(code(accepted(&back, &unknown).map(<[u8]>::to_vec)), "0401");
}

#[test]
fn over_tcp_a_header_stands_in_front() {
    let hello = hello();
    assert_eq!(hello[..12], [b'F', b'I', b'N', b'S', 0, 0, 0, 12, 0, 0, 0, 0]);
    assert_eq!(split(&hello), Split::Frame(20));
    for length in 0..hello.len() {
        assert_eq!(split(&hello[..length]), Split::More);
    }
    assert_eq!(split(b"FINX"), Split::Garbage);
    assert_eq!(split(b"FINS\xFF\0\0\0"), Split::Garbage);
    let told = answer_over_tcp(&hello, &mut Counted).expect("an answer");
    assert_eq!(nodes(&told), Ok(NODES));
    let wrapped = over_tcp(Over::Frame, 0, &READ);
    let back = answer_over_tcp(&wrapped, &mut Counted).expect("an answer");
    let inner = unwrapped(&back).expect("a frame");
    assert_eq!(accepted(inner, &READ).and_then(|data| words(data, 2)), Ok(vec![264, 265]));
    let full = over_tcp(Over::TellNodes, 0x20, &[0; 8]);
    assert!(matches!(nodes(&full), Err(Wrong::EndCode { meaning, .. }) if meaning.contains("use")));
}

#[test]
fn no_frame_brings_it_down() {
    let frames = [READ.to_vec(), over_tcp(Over::Frame, 0, &READ), hello()];
    for frame in frames {
        for at in 0..frame.len() {
            let _ = answer(&frame[..at], &mut Counted);
            let _ = answer_over_tcp(&frame[..at], &mut Counted);
            for value in 0..=255 {
                let mut changed = frame.clone();
                changed[at] = value;
                let _ = split(&changed);
                let _ = answer(&changed, &mut Counted);
                let _ = answer_over_tcp(&changed, &mut Counted);
            }
        }
    }
}
