//! Frames by hand, answers of a CPU, and whatever else may come.

use super::*;
use crate::Memory;

struct Counted;

impl Memory for Counted {
    fn words(&mut self, area: &str, first: u32, count: u32) -> Option<Vec<u16>> {
        let all = matches!(area, "AR" | "DM") && first + count <= 1000;
        all.then(|| (first..first + count).map(|n| n as u16).collect())
    }

    fn bits(&mut self, _: &str, _: u32, _: u32) -> Option<Vec<bool>> {
        None
    }

    fn state(&mut self) -> State {
        State::Run
    }

    fn model(&mut self) -> String {
        String::new()
    }

    fn scan_times(&mut self) -> [u32; 3] {
        [0; 3]
    }
}

fn device(name: &str) -> Device {
    Device::named(name, AREAS).expect("a device")
}

#[test]
fn frames_end_with_the_sum_of_their_characters() {
    // The example of the C200HS's manual.
    assert_eq!(request(10, device("IR31"), 1), b"@10RR0031000142*\r");
    // By hand: 40^30^30^52^44 = 56, ^ "00000010" = 57.
    assert_eq!(request(0, device("DM0"), 10), b"@00RD0000001057*\r");
    assert_eq!(request(0, device("AR26"), 2)[..13], *b"@00RJ00260002");
    assert_eq!(state_request(0), b"@00MS5E*\r");
}

#[test]
fn answers_are_read() {
    let request = request(0, device("DM0"), 2);
    let good = closed("@00RD0000030190".to_owned());
    assert_eq!(words(&good, &request, 2), Ok(vec![3, 0x190]));
    let mut wrong = good.clone();
    let at = wrong.len() - 3;
    wrong[at] = if wrong[at] == b'0' { b'1' } else { b'0' };
    let Err(Wrong::NoAnswer(why)) = words(&wrong, &request, 2) else { panic!("a fault") };
    assert!(why.contains("check sum"));
    let refused = closed("@00RD15".to_owned());
    let Err(Wrong::EndCode { code, meaning }) = words(&refused, &request, 2) else {
        panic!("a refusal")
    };
    assert_eq!((&*code, meaning.contains("beyond")), ("15", true));
    let other = closed("@01RD000003".to_owned());
    assert!(matches!(words(&other, &request, 1), Err(Wrong::NoAnswer(_))));
    let asked = state_request(0);
    assert_eq!(state(&closed("@00MS000000".to_owned()), &asked), Ok(State::Stop));
    assert_eq!(state(&closed("@00MS000300".to_owned()), &asked), Ok(State::Run));
}

#[test]
fn the_cpu_answers_what_it_is_asked() {
    let ask = |frame: &[u8]| answer(frame, 0, &mut Counted);
    let asked = request(0, device("AR26"), 2);
    let back = ask(&asked).expect("an answer");
    assert_eq!(split(&back), Split::Frame(back.len()));
    assert_eq!(words(&back, &asked, 2), Ok(vec![26, 27]));
    let asked = state_request(0);
    assert_eq!(state(&ask(&asked).expect("an answer"), &asked), Ok(State::Run));
    assert_eq!(ask(&request(1, device("AR26"), 2)), None);
    let code = |text: &str| ask(&closed(text.to_owned())).expect("an answer")[5..7].to_vec();
    assert_eq!(code("@00RD99990002"), b"15");
    assert_eq!(code("@00RD0000"), b"14");
    assert_eq!(code("@00RD00000031"), b"14");
    assert_eq!(code("@00WD00000001"), b"16");
    assert_eq!(ask(b"@00RD0000001000*\r").expect("an answer")[5..7], *b"13");
}

#[test]
fn no_frame_brings_it_down() {
    for frame in [request(0, device("AR26"), 2), state_request(0)] {
        for at in 0..frame.len() {
            let _ = answer(&frame[..at], 0, &mut Counted);
            for value in 0..=255 {
                let mut changed = frame.clone();
                changed[at] = value;
                let _ = split(&changed);
                let _ = answer(&changed, 0, &mut Counted);
                let _ = words(&changed, &frame, 2);
            }
        }
    }
}
