//! Answers for an emulated CPU: listens, and hands every whole frame to who holds its memory.

use super::{Memory, Split, fins, hostlink, slmp};
use std::fmt;
use std::io::{self, ErrorKind, Read, Write};
use std::net::{SocketAddr, TcpListener, TcpStream, UdpSocket};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::mpsc::{Sender, channel};
use std::thread;
use std::time::Duration;

/// What is listened to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Spoken {
    /// SLMP over TCP, binary or ASCII as each request is.
    Slmp,
    /// FINS over TCP.
    FinsTcp,
    /// FINS over UDP.
    FinsUdp,
    /// Host Link over TCP, as a serial device server carries it, or on a serial line; the unit's number.
    HostLink(u8),
}

impl fmt::Display for Spoken {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Spoken::Slmp => "Slmp",
            Spoken::FinsTcp => "FinsTcp",
            Spoken::FinsUdp => "FinsUdp",
            Spoken::HostLink(_) => "HostLink",
        })
    }
}

impl Spoken {
    /// How far a stream's beginning is a request.
    #[must_use]
    pub fn split(self, bytes: &[u8]) -> Split {
        match self {
            Spoken::Slmp => slmp::split(bytes, false),
            Spoken::FinsTcp => fins::split(bytes),
            Spoken::FinsUdp => Split::Frame(bytes.len()),
            Spoken::HostLink(_) => hostlink::split(bytes),
        }
    }

    /// The answer to a request; none to what is not answered.
    #[must_use]
    pub fn answer(self, frame: &[u8], memory: &mut dyn Memory) -> Option<Vec<u8>> {
        match self {
            Spoken::Slmp => Some(slmp::answer(frame, memory)),
            Spoken::FinsTcp => fins::answer_over_tcp(frame, memory),
            Spoken::FinsUdp => fins::answer(frame, memory),
            Spoken::HostLink(unit) => hostlink::answer(frame, unit, memory),
        }
    }
}

/// A request that waits for the CPU to answer it between two scans.
pub struct Request {
    spoken: Spoken,
    frame: Vec<u8>,
    back: Sender<Option<Vec<u8>>>,
}

impl Request {
    /// Answers it. Who asked may have gone.
    pub fn answer(self, memory: &mut dyn Memory) {
        let _ = self.back.send(self.spoken.answer(&self.frame, memory));
    }
}

/// The most connections at a time.
const MOST: usize = 64;
/// What a connection's thread takes of memory.
const STACK: usize = 128 << 10;
/// More bytes than this without a frame are none.
const LONGEST: usize = 1 << 17;
/// How long a read waits before it is seen whether all is over.
pub const PAUSE: Duration = Duration::from_millis(20);

/// Who listens, and where.
pub struct Listening {
    /// The address, with the port that was chosen where 0 was asked for.
    pub address: SocketAddr,
    spoken: Spoken,
    socket: Socket,
}

enum Socket {
    Tcp(TcpListener),
    Udp(UdpSocket),
}

impl Listening {
    /// Begins to listen.
    ///
    /// # Errors
    /// The address is in use, or none of this machine.
    pub fn on(spoken: Spoken, address: SocketAddr) -> io::Result<Listening> {
        let (socket, address) = match spoken {
            Spoken::FinsUdp => {
                let socket = UdpSocket::bind(address)?;
                socket.set_read_timeout(Some(PAUSE))?;
                let address = socket.local_addr()?;
                (Socket::Udp(socket), address)
            }
            Spoken::Slmp | Spoken::FinsTcp | Spoken::HostLink(_) => {
                let listener = TcpListener::bind(address)?;
                listener.set_nonblocking(true)?;
                let address = listener.local_addr()?;
                (Socket::Tcp(listener), address)
            }
        };
        Ok(Listening { address, spoken, socket })
    }

    /// What is spoken there.
    #[must_use]
    pub fn spoken(&self) -> Spoken {
        self.spoken
    }

    /// Serves until `over`, each connection on a thread of its own. Requests are handed on to who holds the memory.
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
                    if open.fetch_add(1, Ordering::Relaxed) >= MOST {
                        open.fetch_sub(1, Ordering::Relaxed);
                        continue;
                    }
                    let (requests, over, open) = (requests.clone(), over.clone(), open.clone());
                    let spoken = self.spoken;
                    let left = Arc::clone(&open);
                    let answer = move || {
                        // Whatever a client does ends its own connection alone.
                        let _ = connection(stream, spoken, &requests, &over);
                        open.fetch_sub(1, Ordering::Relaxed);
                    };
                    // Where memory is short, the connection is closed.
                    if thread::Builder::new().stack_size(STACK).spawn(answer).is_err() {
                        left.fetch_sub(1, Ordering::Relaxed);
                    }
                }
            }
        }
    }
}

/// Has a frame answered.
fn asked(spoken: Spoken, frame: &[u8], requests: &Sender<Request>) -> Option<Vec<u8>> {
    let (back, answer) = channel();
    requests.send(Request { spoken, frame: frame.to_vec(), back }).ok()?;
    answer.recv().ok()?
}

fn datagrams(socket: &UdpSocket, spoken: Spoken, requests: &Sender<Request>, over: &AtomicBool) {
    let mut buffer = [0; 4096];
    while !over.load(Ordering::Relaxed) {
        let Ok((count, peer)) = socket.recv_from(&mut buffer) else { continue };
        if let Some(back) = asked(spoken, &buffer[..count], requests) {
            // Who asked may have gone.
            let _ = socket.send_to(&back, peer);
        }
    }
}

fn connection(
    stream: TcpStream,
    spoken: Spoken,
    requests: &Sender<Request>,
    over: &AtomicBool,
) -> io::Result<()> {
    // On some systems a connection inherits what its listener was set to.
    stream.set_nonblocking(false)?;
    stream.set_nodelay(true)?;
    stream.set_read_timeout(Some(PAUSE))?;
    stream.set_write_timeout(Some(Duration::from_secs(5)))?;
    answers(stream, spoken, requests, over)
}

/// Answers what comes on a line until it ends or all is `over`. Its reads wait for a short time only.
///
/// # Errors
/// The line broke.
pub fn answers(
    mut stream: impl Read + Write,
    spoken: Spoken,
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
            // A serial line may be disturbed: what comes before a frame is passed over.
            Split::Garbage if matches!(spoken, Spoken::HostLink(_)) => {
                held.remove(0);
                continue;
            }
            // Where a stream went wrong, no next frame can be found.
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
