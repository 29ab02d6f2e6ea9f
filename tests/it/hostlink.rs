//! Host Link as others see it: frames that a script of its own made, and an emulated C200H on a pseudo-terminal.
use crate::command::binary;
use scanbound::link::device::Device;
use scanbound::link::hostlink::{self, AREAS};
use scanbound::link::serial::Settings;
use scanbound::link::station::Station;
use scanbound::link::{Coil, Memory, Setting, State};
use std::path::{Path, PathBuf};
use std::process::{Child, Output, Stdio};
use std::time::{Duration, Instant};

const SOON: Duration = Duration::from_millis(1500);

/// The unit that `hostlink_peer.py` plays.
struct Unit;

impl Memory for Unit {
    fn words(&mut self, area: &str, first: u32, count: u32) -> Option<Vec<u16>> {
        let digits =
            |n: u32| (0..4).fold(0, |word, at| word | (n / 10u32.pow(at) % 10) << (4 * at));
        let word = |n: u32| if area == "TCPV" { digits(n) } else { 7 * n };
        Some((first..first + count).map(|n| word(n) as u16).collect())
    }

    fn bits(&mut self, area: &str, first: u32, count: u32) -> Option<Vec<bool>> {
        (area == "TC").then(|| (first..first + count).map(|n| n % 3 == 0).collect())
    }

    fn setting(&mut self, coil: Coil, number: u32, _: u32) -> Option<Setting> {
        match (coil, number) {
            (Coil::Timer, 5) => Some(Setting::Number(50)),
            (Coil::Counter, 6) => Some(Setting::Word { area: "DM", index: 7 }),
            _ => None,
        }
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

/// Pairs of a request and its answer that the script made.
fn frames() -> Vec<(Vec<u8>, Vec<u8>)> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/hostlink-frames.txt");
    let text = std::fs::read_to_string(path).expect("frames");
    let lines = text.lines().filter(|line| !line.starts_with('#'));
    let frame = |text: &str| [text.as_bytes(), b"\r"].concat();
    let pairs = lines.map(|line| line.split_once('\t').expect("a pair"));
    pairs.map(|(request, answer)| (frame(request), frame(answer))).collect()
}

#[test]
fn requests_of_a_script_are_answered_as_it_answers_them() {
    let frames = frames();
    assert!(frames.len() > 15);
    for (request, answer) in frames {
        let unit = std::str::from_utf8(&request[1..3]).expect("digits").parse().expect("a number");
        let own = hostlink::answer(&request, unit, &mut Unit).expect("an answer");
        assert_eq!(String::from_utf8_lossy(&own), String::from_utf8_lossy(&answer));
        assert_eq!(hostlink::answer(&request, unit + 1, &mut Unit), None);
    }
}

#[test]
fn requests_are_those_of_a_script_and_its_answers_are_read() {
    let frames = frames();
    let answer = |request: &[u8]| {
        let found = frames.iter().find(|(one, _)| one == request);
        let text = String::from_utf8_lossy(request).into_owned();
        found.unwrap_or_else(|| panic!("the script asks nothing like {text}")).1.clone()
    };
    let device = |name: &str| Device::named(name, AREAS).expect("a device");
    for (unit, name, count) in [
        (0, "IR0", 1),
        (0, "SR255", 1),
        (10, "IR31", 1),
        (31, "IR10", 30),
        (0, "HR99", 1),
        (0, "AR27", 1),
        (0, "LR0", 4),
        (0, "DM0", 30),
    ] {
        let device = device(name);
        let request = hostlink::request(unit, device, count);
        let words = hostlink::words(&answer(&request), &request, count).expect("words");
        let own: Vec<u16> =
            (device.index..device.index + u32::from(count)).map(|n| 7 * n as u16).collect();
        assert_eq!(words, own, "{name}");
    }
    let request = hostlink::present_request(0, 0, 10);
    let values = hostlink::words(&answer(&request), &request, 10).expect("values");
    assert_eq!(values, (0..10).collect::<Vec<u16>>());
    let request = hostlink::flags_request(0, 500, 12);
    let flags = hostlink::flags(&answer(&request), &request, 12).expect("flags");
    assert_eq!(flags, (500..512).map(|n| n % 3 == 0).collect::<Vec<bool>>());
    let request = hostlink::number_request(0, Coil::Timer, 5);
    assert_eq!(hostlink::setting(&answer(&request), &request), Ok(Setting::Number(50)));
    let word = Setting::Word { area: "DM", index: 7 };
    for from in [123, 12_345] {
        let request = hostlink::setting_request(0, from, Coil::Counter, 6);
        assert_eq!(hostlink::setting(&answer(&request), &request), Ok(word));
    }
    let request = hostlink::state_request(0);
    assert_eq!(hostlink::state(&answer(&request), &request), Ok(State::Run));
    let request = hostlink::test_request(0, "123456");
    assert_eq!(answer(&request), request);
}

/// An emulated C200H that ends with its test.
struct Served(Child);

impl Drop for Served {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

const PROGRAM: &str = "LD 00000\nAND NOT TIM005\nTIM 005 #0003\nLD TIM005\nLD 00001\nCNT 006 #0004\n\
                       LD TIM005\nOUT 00500\nEND(01)\n";

fn serve(directory: &Path) -> (Served, PathBuf) {
    let link = directory.join("plc");
    std::fs::write(directory.join("a.il"), PROGRAM).expect("written");
    let child = binary()
        .args(["serve", "a.il", "--dialect", "omron-c200h", "--cpu", "C200H", "--pty", "plc"])
        .args(["--set", "00000=1", "--for", "60s"])
        .current_dir(directory)
        .stderr(Stdio::null())
        .spawn()
        .expect("it starts");
    let (served, begun) = (Served(child), Instant::now());
    while !link.exists() {
        assert!(begun.elapsed() < Duration::from_secs(20), "no line");
        std::thread::sleep(Duration::from_millis(20));
    }
    (served, link)
}

#[test]
fn an_emulated_c200h_runs_its_timers_and_tells_of_them() {
    let directory = tempfile::tempdir().expect("a directory");
    let (_served, link) = serve(directory.path());
    let mut plc = Station::new(&link.display().to_string(), 0, Settings::default(), SOON);
    assert_eq!(plc.state().expect("a state"), State::Run);
    assert_eq!(plc.number(Coil::Timer, 5).expect("a value"), Setting::Number(3));
    assert_eq!(plc.number(Coil::Counter, 6).expect("a value"), Setting::Number(4));
    // The timer starts itself anew each 0.3 s, and the counter counts that down to 0.
    let (mut timer, mut counter) = (Vec::new(), Vec::new());
    let begun = Instant::now();
    while begun.elapsed() < Duration::from_secs(3) {
        let values = plc.present(5, 2).expect("values");
        timer.push(values[0]);
        counter.push(values[1]);
    }
    assert!(timer.iter().all(|&value| value <= 3), "{timer:?}");
    assert!((1..=3).all(|value| timer.contains(&value)), "{timer:?}");
    assert!(counter.is_sorted_by(|a, b| a >= b), "{counter:?}");
    assert_eq!(counter.last(), Some(&0));
    assert!(plc.flags(5, 2).expect("flags")[1], "the counter is through");
}

#[test]
fn live_reads_an_emulated_c200h_over_a_line() {
    let directory = tempfile::tempdir().expect("a directory");
    let (_served, _) = serve(directory.path());
    let Output { status, stdout, stderr } = binary()
        .args(["live", "--hostlink", "plc", "--baud", "9600", "--parity", "even", "--cpu", "C200H"])
        .args(["--for", "500ms", "--bound", "100ms"])
        .current_dir(directory.path())
        .output()
        .expect("it starts");
    let told = String::from_utf8_lossy(&stderr);
    assert_eq!(status.code(), Some(0), "{told}");
    assert!(String::from_utf8_lossy(&stdout).contains("- bound -"), "{told}");
}
