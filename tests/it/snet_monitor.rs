//! The monitor against an emulated C200H on a pseudo-terminal: every value that it shows is one that the PLC had within
//! that poll, whatever becomes of the line. `SCANBOUND_CASES=15` has it watch for a minute.
use crate::command::binary;
use common::tape::cases;
use scanbound::base::facts::Facts;
use scanbound::base::time::{Picos, Times};
use scanbound::emulated::{Cpu, Disturbance};
use scanbound::front::{self, Input, Options};
use scanbound::link::pty::Pty;
use scanbound::link::serial::Settings;
use scanbound::link::server::{PAUSE, Request, ServedProtocol, answers};
use scanbound::link::station::Station;
use scanbound::link::{Memory, State};
use scanbound::snet::monitor::{Plan, Reading};
use scanbound::snet::{Diagram, text};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::process::{Child, Output, Stdio};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Sender, channel};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

const NET: &str = "\
outer GO = 00001
outer EMPTIED = 00002
box IDLE = 00300
timer FILL 0.3s = 00301 TIM 000
counter FOUR 4 = 00302 CNT 001
transition COME = 00310 : -> IDLE if GO
transition BEGIN = 00311 : IDLE -> FILL
transition DONE = HR0112 : FILL -> FOUR
transition LEAVE = 00313 : FOUR -> if EMPTIED
";

/// The net's code as the paper makes it.
const CODE: &str = "\
LD NOT 00300\nAND 00001\nOUT 00310
LD 00300\nAND NOT 00301\nOUT 00311
LD TIM000\nAND NOT CNT001\nOUT HR0112
LD CNT001\nAND 00002\nOUT 00313
LD 00310\nOR 00300\nAND NOT 00311\nOUT 00300
LD 00311\nOR 00301\nAND NOT HR0112\nOUT 00301\nLD 00301\nTIM 000 #0003
LD HR0112\nOR 00302\nAND NOT 00313\nOUT 00302\nLD HR0112\nLD 00313\nCNT 001 #0004
END(01)
";

/// What the PLC's memory held from a moment on: IR 0 to 3, HR 1, present values, flags.
#[derive(Debug, Clone, PartialEq)]
struct Held {
    since: Instant,
    ir: Vec<u16>,
    hr: u16,
    present: Vec<u16>,
    over: Vec<bool>,
}

/// A PLC that logs what its memory holds, and its line, which the test unplugs.
struct Plc {
    log: JoinHandle<Vec<Held>>,
    requests: Sender<Request>,
    over: Arc<AtomicBool>,
    line: Option<(JoinHandle<()>, Arc<AtomicBool>)>,
    link: PathBuf,
}

impl Plc {
    fn start(link: &Path) -> Plc {
        let (requests, waiting) = channel::<Request>();
        let over = Arc::new(AtomicBool::new(false));
        let ends = Arc::clone(&over);
        let log = thread::spawn(move || {
            let input = Input { name: "a.il".to_owned(), bytes: CODE.as_bytes().to_vec() };
            let facts = Facts::default();
            let options = Options { family: Some("c"), ..Options::new(&facts) };
            let project = front::read(&[input], Some("omron-c200h")).expect("a program");
            let program = project.decode(&options).expect("a sound one");
            let each = Times::new(Picos(1_000_000), Picos(1_000_000));
            let times = vec![each; program.instructions.len()];
            // A scan takes three milliseconds.
            let overhead = Picos(3_000_000_000);
            let mut cpu = Cpu::new(&program, &times, overhead, None, Disturbance::default());
            let (begun, mut log) = (Instant::now(), Vec::<Held>::new());
            let mut due = begun;
            while !ends.load(Ordering::Relaxed) {
                let ms = begun.elapsed().as_millis();
                cpu.set_named("00001", u16::from(ms / 70 % 3 != 0));
                cpu.set_named("00002", u16::from(ms / 400 % 2 != 0));
                let took = cpu.scan().expect("it runs");
                let held = Held {
                    since: Instant::now(),
                    ir: cpu.words("IR", 0, 4).expect("words"),
                    hr: cpu.words("HR", 1, 1).expect("a word")[0],
                    present: cpu.words("TCPV", 0, 2).expect("values"),
                    over: cpu.bits("TC", 0, 2).expect("flags"),
                };
                log.push(held);
                due = (due + Duration::from_nanos(took.0 / 1000)).max(Instant::now());
                while let Ok(request) =
                    waiting.recv_timeout(due.saturating_duration_since(Instant::now()))
                {
                    request.answer(&mut cpu);
                }
            }
            log
        });
        let mut plc = Plc { log, requests, over, line: None, link: link.to_owned() };
        plc.plug();
        plc
    }

    fn plug(&mut self) {
        let pty = Pty::open(Some(&self.link), PAUSE).expect("a line");
        let over = Arc::new(AtomicBool::new(false));
        let (ends, requests) = (Arc::clone(&over), self.requests.clone());
        let serve = move || {
            let _ = answers(pty, ServedProtocol::HostLink(3), &requests, &ends);
        };
        self.line = Some((thread::spawn(serve), over));
    }

    fn unplug(&mut self) {
        let Some((thread, over)) = self.line.take() else { return };
        over.store(true, Ordering::Relaxed);
        thread.join().expect("it ends");
    }

    fn end(mut self) -> Vec<Held> {
        self.unplug();
        self.over.store(true, Ordering::Relaxed);
        drop(self.requests);
        self.log.join().expect("a log")
    }
}

/// Holds what a poll shows against what the PLC had while it lasted.
fn check(diagram: &Diagram, reading: &Reading, from: Instant, to: Instant, log: &[Held]) {
    // What was held when the poll began, and all that came until it ended.
    let last = log.partition_point(|held| held.since <= to);
    let first = log.partition_point(|held| held.since <= from).saturating_sub(1);
    let during = &log[first..last];
    let bit = |held: &Held, name: &str| {
        let number: usize = name[name.len() - 4..].parse().expect("digits");
        let (word, bit) = (number / 100, number % 100);
        let word = if name.starts_with("HR") { held.hr } else { held.ir[word] };
        word >> bit & 1 == 1
    };
    let had = |what: &str, is: &dyn Fn(&Held) -> bool| {
        assert!(during.iter().any(is), "{what} of {reading:?} was none of {during:#?}");
    };
    for (place, shown) in diagram.places.iter().zip(&reading.places) {
        let (address, name) = (place.head.address.expect("one").to_string(), &place.head.name);
        had(name, &|held| Some(bit(held, &address)) == shown.relay);
    }
    for (one, on) in diagram.transitions.iter().zip(&reading.transitions) {
        let address = one.head.address.expect("one").to_string();
        had(&one.head.name, &|held| Some(bit(held, &address)) == *on);
    }
    for (outer, on) in diagram.outers.iter().zip(&reading.outers) {
        let address = outer.head.address.expect("one").to_string();
        had(&outer.head.name, &|held| Some(bit(held, &address)) == *on);
    }
    for (number, setting) in [(0, 3), (1, 4)] {
        let shown = reading.places[1 + number];
        assert_eq!(shown.setting, Some(setting));
        had("a present value", &|held| Some(held.present[number]) == shown.present);
        had("a flag", &|held| Some(held.over[number]) == shown.over);
        assert_eq!(shown.elapsed(), shown.present.map(|present| setting - present));
    }
    assert_eq!(reading.cpu, State::Run);
}

#[test]
fn every_value_that_is_shown_is_one_that_the_plc_had_and_unplugging_is_survived() {
    let cases = cases(1);
    let diagram = text::read("a.snet", NET).expect("a net");
    let plan = Plan::new(&diagram);
    let directory = tempfile::tempdir().expect("a directory");
    let link = directory.path().join("plc");
    let mut plc = Plc::start(&link);
    let patience = Duration::from_millis(300);
    let mut station = Station::new(&link.display().to_string(), 3, Settings::default(), patience);
    let (begun, mut good, mut unplugged) = (Instant::now(), Vec::new(), 0);
    let mut next = begun + Duration::from_secs(1);
    // Much is to be seen: all marks come and go, timer and counter pass through all they can stand at.
    let mut unseen: BTreeSet<(usize, u16)> = (0..=3).map(|value| (1, value)).collect();
    unseen.extend((0..=4).map(|value| (2, value)));
    unseen.extend((0..3).flat_map(|place| [(10 + place, 0), (10 + place, 1)]));
    // On a machine that is busy all takes longer; what is not there in a minute never comes.
    let patient = Duration::from_secs(60 * cases);
    while begun.elapsed() < Duration::from_secs(4 * cases) || unplugged < 3 || !unseen.is_empty() {
        assert!(begun.elapsed() < patient, "unplugged {unplugged} times, not seen: {unseen:?}");
        if Instant::now() >= next {
            plc.unplug();
            assert!(plan.poll(&mut station).is_err(), "there is no line");
            plc.plug();
            while plan.poll(&mut station).is_err() {
                assert!(begun.elapsed() < patient, "the line does not come back");
            }
            (unplugged, next) = (unplugged + 1, Instant::now() + Duration::from_secs(1));
        }
        let from = Instant::now();
        if let Ok(reading) = plan.poll(&mut station) {
            for (place, shown) in reading.places.iter().enumerate() {
                shown.relay.map(|on| unseen.remove(&(10 + place, u16::from(on))));
                shown.present.map(|value| unseen.remove(&(place, value)));
            }
            good.push((from, Instant::now(), reading));
        }
    }
    let log = plc.end();
    for (from, to, reading) in &good {
        assert!(!reading.is_of_one_moment());
        check(&diagram, reading, *from, *to, &log);
    }
}

/// A process that ends with its test.
struct Served(Child);

impl Drop for Served {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

fn monitor(directory: &Path, arguments: &[&str]) -> (Option<i32>, String, String) {
    let Output { status, stdout, stderr } = binary()
        .args(["snet", "monitor", "a.snet", "--port", "plc"])
        .args(arguments)
        .current_dir(directory)
        .output()
        .expect("it starts");
    let text = |bytes: Vec<u8>| String::from_utf8_lossy(&bytes).into_owned();
    (status.code(), text(stdout), text(stderr))
}

#[test]
fn the_command_writes_lines_of_text_and_json() {
    let directory = tempfile::tempdir().expect("a directory");
    let at = directory.path();
    std::fs::write(at.join("a.snet"), NET).expect("written");
    std::fs::write(at.join("a.il"), CODE).expect("written");
    let (code, _, stderr) = monitor(at, &["--for", "600ms", "--timeout", "100ms"]);
    assert_eq!(code, Some(2), "{stderr}");
    assert!(stderr.contains("polls was answered"), "{stderr}");
    let child = binary()
        .args(["serve", "a.il", "--dialect", "omron-c200h", "--cpu", "C200H", "--pty", "plc"])
        .args(["--set", "00001=1", "--for", "60s"])
        .current_dir(at)
        .stderr(Stdio::null())
        .spawn()
        .expect("it starts");
    let _served = Served(child);
    while !at.join("plc").exists() {
        thread::sleep(Duration::from_millis(20));
    }
    let (code, stdout, stderr) = monitor(at, &["--for", "2500ms", "--every", "10ms"]);
    assert_eq!(code, Some(0), "{stderr}");
    assert!(stdout.contains("FILL running 0.1 s of 0.3 s"), "{stdout}");
    assert!(stdout.contains("on: GO [from "), "{stdout}");
    let (code, stdout, stderr) = monitor(at, &["--for", "500ms", "--format", "json"]);
    assert_eq!(code, Some(0), "{stderr}");
    let rows: Vec<serde_json::Value> =
        stdout.lines().map(|line| serde_json::from_str(line).expect("JSON")).collect();
    assert!(rows.len() > 2, "{stdout}");
    let last = &rows[rows.len() - 1];
    assert_eq!(last["schema"], "scanbound.snet-monitor/1");
    // The counter is full, and nothing leaves: FILL stays over.
    let reading = &last["reading"];
    assert_eq!(reading["one_moment"], false);
    assert_eq!(reading["marks"]["FOUR"], true);
    assert_eq!(reading["counters"]["FOUR"]["elapsed"], 4);
    assert_eq!(reading["timers"]["FILL"]["state"], "over");
    assert_eq!(reading["outers"]["GO"], true);
    assert_eq!(reading["outers"]["EMPTIED"], false);
    // Another unit's number: silence, and no value.
    let (code, stdout, _) =
        monitor(at, &["--for", "800ms", "--unit", "5", "--timeout", "200ms", "--format", "json"]);
    assert_eq!(code, Some(2));
    assert!(stdout.lines().all(|line| line.contains("\"fault\":") && !line.contains("reading")));
}

#[test]
fn a_net_is_served_by_the_code_that_is_made_of_it() {
    let directory = tempfile::tempdir().expect("a directory");
    let at = directory.path();
    std::fs::write(at.join("a.snet"), NET).expect("written");
    let child = binary()
        .args(["snet", "serve", "a.snet", "--pty", "plc", "--set", "GO=1", "--for", "60s"])
        .current_dir(at)
        .stderr(Stdio::null())
        .spawn()
        .expect("it starts");
    let _served = Served(child);
    let begun = Instant::now();
    while !at.join("plc").exists() {
        assert!(begun.elapsed() < Duration::from_secs(30), "no line");
        thread::sleep(Duration::from_millis(20));
    }
    // Four times the timer, and the counter is full: nothing leaves it before EMPTIED.
    thread::sleep(Duration::from_secs(3));
    let (code, stdout, stderr) = monitor(at, &["--for", "500ms", "--format", "json"]);
    assert_eq!(code, Some(0), "{stderr}");
    let last = stdout.lines().last().expect("a reading");
    let row: serde_json::Value = serde_json::from_str(last).expect("JSON");
    assert_eq!(row["reading"]["counters"]["FOUR"]["elapsed"], 4, "{last}");
    assert_eq!(row["reading"]["marks"]["FOUR"], true, "{last}");
    assert_eq!(row["reading"]["outers"]["GO"], true, "{last}");
}
