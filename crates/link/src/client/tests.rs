//! Each way in which a PLC fails to answer, with its message; requests to a server over each protocol.

use super::*;
use crate::Memory;
use crate::registers;
use crate::server::{Listening, ServedProtocol};
use std::io::{Read, Write};
use std::net::{SocketAddr, TcpListener, UdpSocket};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::channel;
use std::thread;
use std::time::Instant;

const SOON: Duration = Duration::from_millis(200);
const BINARY: Protocol = Protocol::Slmp(Code::Binary);

/// A PLC that sends some bytes to whoever asks, and then closes the connection or not.
fn sends(bytes: Vec<u8>, closes: bool) -> String {
    let listener = TcpListener::bind("127.0.0.1:0").expect("a port");
    let address = listener.local_addr().expect("its address").to_string();
    thread::spawn(move || {
        let (mut stream, _) = listener.accept().expect("a client");
        let mut buffer = [0; 256];
        let _ = stream.read(&mut buffer);
        let _ = stream.write_all(&bytes);
        if !closes {
            thread::sleep(Duration::from_secs(5));
        }
    });
    address
}

/// What is told of a PLC that answers the question for its current scan time with these bytes.
fn told(bytes: &[u8], closes: bool) -> String {
    let peer = sends(bytes.to_vec(), closes);
    let mut plc = Plc::connect(BINARY, &peer, SOON).expect("a connection");
    let registers = registers::of("q").expect("registers");
    let fault = plc.scan_times(registers).expect_err("a fault");
    fault.to_string().replace(&peer, "PLC")
}

#[test]
fn a_refused_connection_is_told() {
    let closed = TcpListener::bind("127.0.0.1:0").expect("a port").local_addr().expect("it");
    let fault = Plc::connect(BINARY, &closed.to_string(), SOON).err().expect("a fault");
    assert!(matches!(&fault, Fault::Refused { .. }), "{fault}");
    assert!(fault.to_string().contains("refused the connection: check the port"));
}

#[test]
fn a_name_that_is_none_is_told() {
    let fault = Plc::connect(BINARY, "127.0.0.1:http", SOON).err().expect("a fault");
    assert!(matches!(fault, Fault::Unreachable { .. }));
    let fault =
        Plc::connect(Protocol::HostLink(0, None), "/dev/none", SOON).err().expect("a fault");
    assert!(fault.to_string().starts_with("/dev/none cannot be reached"));
}

#[test]
fn silence_is_a_time_out() {
    assert!(told(&[], false).starts_with("PLC did not answer within 200 ms"));
}

#[test]
fn silence_is_a_time_out_over_udp() {
    let silent = UdpSocket::bind("127.0.0.1:0").expect("a port");
    let peer = silent.local_addr().expect("its address").to_string();
    let begun = Instant::now();
    let mut plc = Plc::connect(Protocol::FinsUdp, &peer, SOON).expect("a socket");
    let fault = plc.state("cs").expect_err("a fault");
    assert!(matches!(fault, Fault::TimedOut { .. }), "{fault}");
    assert!(begun.elapsed() >= SOON);
}

#[test]
fn half_frames_are_told() {
    let half = [0xD0, 0, 0, 0xFF, 0xFF, 3, 0, 6, 0, 0, 0, 3];
    assert_eq!(
        told(&half, true),
        "PLC sent an incomplete frame: 12 bytes, then it closed the connection"
    );
    assert_eq!(told(&half, false), "PLC sent an incomplete frame: 12 bytes, then nothing more");
    assert!(told(&[], true).starts_with("PLC closed the connection without an answer"));
}

#[test]
fn end_codes_are_told_with_what_they_mean() {
    let frame = [0xD0, 0, 0, 0xFF, 0xFF, 3, 0, 2, 0, 0x59, 0xC0];
    assert_eq!(
        told(&frame, false),
        "PLC answered with end code C059: the CPU does not know this command"
    );
}

#[test]
fn what_is_no_answer_is_told() {
    assert!(
        told(b"HTTP/1.1 400 Bad Request", false)
            .contains("does not begin like a frame of this protocol")
    );
    let short = [0xD0, 0, 0, 0xFF, 0xFF, 3, 0, 4, 0, 0, 0, 3, 0];
    assert!(told(&short, false).contains("2 words were requested, but 1 were received"));
    let no_time = [0xD0, 0, 0, 0xFF, 0xFF, 3, 0, 6, 0, 0, 0, 3, 0, 0xFF, 0xFF];
    assert!(told(&no_time, false).contains("SD520 contains"));
}

#[test]
fn a_wrong_check_sum_is_told() {
    let peer = sends(b"@00RJ00012300*\r".to_vec(), false);
    let mut plc = Plc::connect(Protocol::HostLink(0, None), &peer, SOON).expect("a connection");
    let fault = plc.scan_times(registers::of("c").expect("registers")).expect_err("a fault");
    assert!(fault.to_string().contains("check sum is 00"), "{fault}");
}

/// A CPU whose scans take 3.4 ms, 5 ms and 2 ms.
struct Steady;

impl Memory for Steady {
    fn words(&mut self, area: &str, first: u32, count: u32) -> Option<Vec<u16>> {
        let word = |at: u32| match (area, at) {
            ("SD", 520 | 526 | 524) => {
                [3, 5, 2][[520, 526, 524].iter().position(|n| *n == at)?].into()
            }
            ("SD", 521) => Some(400),
            ("A", 264) | ("AR", 27) => Some(if area == "A" { 34 } else { 0x34 }),
            ("A", 262) | ("AR", 26) => Some(if area == "A" { 50 } else { 0x50 }),
            ("SD" | "A" | "AR", 0..1000) => Some(0),
            _ => None,
        };
        (first..first + count).map(word).collect()
    }

    fn bits(&mut self, area: &str, first: u32, count: u32) -> Option<Vec<bool>> {
        (area == "M").then(|| (first..first + count).map(|n| n == 5).collect())
    }

    fn state(&mut self) -> State {
        State::Stop
    }

    fn model(&mut self) -> String {
        "TEST".to_owned()
    }

    fn scan_times(&mut self) -> [u32; 3] {
        [34, 50, 20]
    }
}

/// A server of that CPU, until the flag is set.
fn serves(spoken: ServedProtocol) -> (String, Arc<AtomicBool>) {
    let loopback: SocketAddr = "127.0.0.1:0".parse().expect("an address");
    let listening = Listening::on(spoken, loopback).expect("a port");
    let peer = listening.address.to_string();
    let over = Arc::new(AtomicBool::new(false));
    let (requests, asked) = channel();
    let until = over.clone();
    thread::spawn(move || listening.serve(requests, until));
    thread::spawn(move || {
        for request in asked {
            request.answer(&mut Steady);
        }
    });
    (peer, over)
}

#[test]
fn scan_times_are_read_over_each_protocol() {
    let tenth = |tenths: u64| Picos(tenths * 100_000_000);
    let cases = [
        (ServedProtocol::Slmp, BINARY, "q"),
        (ServedProtocol::Slmp, Protocol::Slmp(Code::Ascii), "q"),
        (ServedProtocol::FinsUdp, Protocol::FinsUdp, "cs"),
        (ServedProtocol::FinsTcp, Protocol::FinsTcp, "cs"),
        (ServedProtocol::HostLink(0), Protocol::HostLink(0, None), "c"),
    ];
    for (spoken, protocol, family) in cases {
        let (peer, over) = serves(spoken);
        let patience = Duration::from_secs(5);
        let mut plc = Plc::connect(protocol, &peer, patience).expect("a connection");
        let times = plc.scan_times(registers::of(family).expect("registers")).expect("times");
        let least = (family == "q").then(|| tenth(20));
        assert_eq!(times, ScanTimes { current: tenth(34), least, most: Some(tenth(50)) });
        let state = plc.state(family).expect("a state");
        // SD203 of this CPU is 0.
        let expected = if family == "q" { State::Run } else { State::Stop };
        assert_eq!(state, expected, "{protocol:?}");
        if family == "q" {
            assert_eq!(plc.model().expect("a name").as_deref(), Some("TEST"));
            let on = plc.device("M5").expect("a device");
            assert_eq!(plc.value(on).expect("a bit"), 1);
            let beyond = plc.device("SD999").expect("a device");
            let fault = plc.words(beyond, 2).expect_err("a fault").to_string();
            assert!(fault.contains("end code C056"), "{fault}");
            assert_eq!(plc.many(plc.device("SD0").expect("one"), 970).expect("words").len(), 970);
        }
        over.store(true, Ordering::Relaxed);
    }
}

#[test]
fn garbage_ends_one_connection_and_not_the_server() {
    for spoken in [ServedProtocol::Slmp, ServedProtocol::FinsTcp, ServedProtocol::HostLink(0)] {
        let (peer, over) = serves(spoken);
        let mut seed = 1u64;
        for _ in 0..20 {
            let mut stream = std::net::TcpStream::connect(&peer).expect("a connection");
            let noise: Vec<u8> = (0..400)
                .map(|_| {
                    seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
                    (seed >> 33) as u8
                })
                .collect();
            let _ = stream.write_all(&noise);
        }
        let protocol = match spoken {
            ServedProtocol::Slmp => BINARY,
            ServedProtocol::FinsTcp => Protocol::FinsTcp,
            _ => Protocol::HostLink(0, None),
        };
        let family = if spoken == ServedProtocol::Slmp { "q" } else { "c" };
        let patience = Duration::from_secs(5);
        let mut plc = Plc::connect(protocol, &peer, patience).expect("it still listens");
        assert!(plc.state(family).is_ok());
        over.store(true, Ordering::Relaxed);
    }
}
