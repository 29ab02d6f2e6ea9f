//! Serves an emulated CPU: listens, and passes every whole request to the thread that holds its memory.

use super::{Memory, Split, fins, hostlink, slmp};
use std::fmt;
use std::io::{self, ErrorKind, Read, Write};
use std::net::{SocketAddr, TcpListener, TcpStream, UdpSocket};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::mpsc::{Sender, channel};
use std::thread;
use std::time::Duration;

/// A protocol to serve.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ServedProtocol {
    /// SLMP over TCP; the coding of each request decides that of its answer.
    Slmp,
    /// FINS over TCP.
    FinsTcp,
    /// FINS over UDP.
    FinsUdp,
    /// Host Link over TCP, as a serial device server carries it, or on a serial line; the unit's number.
    HostLink(u8),
}

impl fmt::Display for ServedProtocol {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            ServedProtocol::Slmp => "Slmp",
            ServedProtocol::FinsTcp => "FinsTcp",
            ServedProtocol::FinsUdp => "FinsUdp",
            ServedProtocol::HostLink(_) => "HostLink",
        })
    }
}

impl ServedProtocol {
    /// Whether a stream begins with a request.
    #[must_use]
    pub fn split(self, bytes: &[u8]) -> Split {
        match self {
            ServedProtocol::Slmp => slmp::split(bytes, false),
            ServedProtocol::FinsTcp => fins::split(bytes),
            ServedProtocol::FinsUdp => Split::Frame(bytes.len()),
            ServedProtocol::HostLink(_) => hostlink::split(bytes),
        }
    }

    /// The answer to a request. `None` if it needs no answer.
    #[must_use]
    pub fn answer(self, frame: &[u8], memory: &mut dyn Memory) -> Option<Vec<u8>> {
        match self {
            ServedProtocol::Slmp => Some(slmp::answer(frame, memory)),
            ServedProtocol::FinsTcp => fins::answer_over_tcp(frame, memory),
            ServedProtocol::FinsUdp => fins::answer(frame, memory),
            ServedProtocol::HostLink(unit) => hostlink::answer(frame, unit, memory),
        }
    }
}

/// A request that the CPU will answer between two scans.
pub struct Request {
    spoken: ServedProtocol,
    frame: Vec<u8>,
    back: Sender<Option<Vec<u8>>>,
}

impl Request {
    /// Answers it. The client may have closed the connection meanwhile.
    pub fn answer(self, memory: &mut dyn Memory) {
        let _ = self.back.send(self.spoken.answer(&self.frame, memory));
    }
}

/// The most connections at a time.
const MAX_CONNECTIONS: usize = 64;
/// The stack size of a connection's thread.
const STACK: usize = 128 << 10;
/// If more bytes than this contain no whole frame, none is expected any more.
const LONGEST: usize = 1 << 17;
/// How long a read waits before the server checks whether it must stop.
pub const PAUSE: Duration = Duration::from_millis(20);

/// A listening socket.
pub struct Listening {
    /// The address. If port 0 was requested, it contains the port that the system chose.
    pub address: SocketAddr,
    spoken: ServedProtocol,
    socket: Socket,
}

enum Socket {
    Tcp(TcpListener),
    Udp(UdpSocket),
}

impl Listening {
    /// Starts to listen.
    ///
    /// # Errors
    /// The address is in use, or does not belong to this computer.
    pub fn on(spoken: ServedProtocol, address: SocketAddr) -> io::Result<Listening> {
        let (socket, address) = match spoken {
            ServedProtocol::FinsUdp => {
                let socket = UdpSocket::bind(address)?;
                socket.set_read_timeout(Some(PAUSE))?;
                let address = socket.local_addr()?;
                (Socket::Udp(socket), address)
            }
            ServedProtocol::Slmp | ServedProtocol::FinsTcp | ServedProtocol::HostLink(_) => {
                let listener = TcpListener::bind(address)?;
                listener.set_nonblocking(true)?;
                let address = listener.local_addr()?;
                (Socket::Tcp(listener), address)
            }
        };
        Ok(Listening { address, spoken, socket })
    }

    /// Its protocol.
    #[must_use]
    pub fn spoken(&self) -> ServedProtocol {
        self.spoken
    }

    /// Serves until `over` is set, each connection on its own thread. Requests are passed to the thread that holds the
    /// memory.
    pub fn serve(self, requests: Sender<Request>, over: Arc<AtomicBool>) {
        match self.socket {
            Socket::Udp(socket) => datagrams(&socket, self.spoken, &requests, &over),
            Socket::Tcp(listener) => {
                let open = Arc::new(AtomicUsize::new(0));
                while !over.load(Ordering::Relaxed) {
                    let Ok((stream, _)) = listener.accept() else {
                        thread::sleep(PAUSE);
                        continue;
                    };
                    if open.fetch_add(1, Ordering::Relaxed) >= MAX_CONNECTIONS {
                        open.fetch_sub(1, Ordering::Relaxed);
                        continue;
                    }
                    let (requests, over, open) = (requests.clone(), over.clone(), open.clone());
                    let spoken = self.spoken;
                    let left = Arc::clone(&open);
                    let answer = move || {
                        // An error of a client ends only its connection.
                        let _ = connection(stream, spoken, &requests, &over);
                        open.fetch_sub(1, Ordering::Relaxed);
                    };
                    // If no thread can be started, the connection is closed.
                    if thread::Builder::new().stack_size(STACK).spawn(answer).is_err() {
                        left.fetch_sub(1, Ordering::Relaxed);
                    }
                }
            }
        }
    }
}

/// Passes a request on and waits for its answer.
fn asked(spoken: ServedProtocol, frame: &[u8], requests: &Sender<Request>) -> Option<Vec<u8>> {
    let (back, answer) = channel();
    requests.send(Request { spoken, frame: frame.to_vec(), back }).ok()?;
    answer.recv().ok()?
}

fn datagrams(
    socket: &UdpSocket,
    spoken: ServedProtocol,
    requests: &Sender<Request>,
    over: &AtomicBool,
) {
    let mut buffer = [0; 4096];
    while !over.load(Ordering::Relaxed) {
        let Ok((count, peer)) = socket.recv_from(&mut buffer) else { continue };
        if let Some(back) = asked(spoken, &buffer[..count], requests) {
            // The client may have closed the connection meanwhile.
            let _ = socket.send_to(&back, peer);
        }
    }
}

fn connection(
    stream: TcpStream,
    spoken: ServedProtocol,
    requests: &Sender<Request>,
    over: &AtomicBool,
) -> io::Result<()> {
    // On some systems a connection inherits the settings of its listener.
    stream.set_nonblocking(false)?;
    stream.set_nodelay(true)?;
    stream.set_read_timeout(Some(PAUSE))?;
    stream.set_write_timeout(Some(Duration::from_secs(5)))?;
    answers(stream, spoken, requests, over)
}

/// Answers the requests on a line until it ends or `over` is set. Its reads wait only for a short time.
///
/// # Errors
/// The line broke.
pub fn answers(
    mut stream: impl Read + Write,
    spoken: ServedProtocol,
    requests: &Sender<Request>,
    over: &AtomicBool,
) -> io::Result<()> {
    let mut held = Vec::new();
    let mut buffer = [0; 4096];
    while !over.load(Ordering::Relaxed) {
        match spoken.split(&held) {
            Split::Frame(length) => {
                let rest = held.split_off(length);
                let frame = std::mem::replace(&mut held, rest);
                if let Some(back) = asked(spoken, &frame, requests) {
                    stream.write_all(&back)?;
                }
                continue;
            }
            // A serial line may be disturbed: bytes before a frame are skipped.
            Split::Garbage if matches!(spoken, ServedProtocol::HostLink(_)) => {
                held.remove(0);
                continue;
            }
            // After a wrong byte in a TCP stream the next frame cannot be found.
            Split::Garbage => return Ok(()),
            Split::More if held.len() > LONGEST => return Ok(()),
            Split::More => {}
        }
        match stream.read(&mut buffer) {
            Ok(0) => return Ok(()),
            Ok(count) => held.extend(&buffer[..count]),
            Err(error) if matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut) => {}
            Err(error) => return Err(error),
        }
    }
    Ok(())
}
