//! Connections that carry frames: TCP, UDP and a serial line.

use super::Split;
use super::fault::Fault;
use super::serial::{self, Settings};
use serial2::SerialPort;
use std::io::{self, ErrorKind, Read, Write};
use std::net::{SocketAddr, TcpStream, ToSocketAddrs, UdpSocket};
use std::time::{Duration, Instant};

/// A connection to a PLC.
pub struct Transport {
    peer: String,
    patience: Duration,
    line: Line,
    /// Received bytes that are not yet part of a whole frame.
    rest: Vec<u8>,
}

enum Line {
    Tcp(TcpStream),
    Udp(UdpSocket),
    Serial(SerialPort),
}

impl Transport {
    /// The address of a peer.
    fn address(peer: &str) -> Result<SocketAddr, Fault> {
        let unknown = |error| Fault::Unreachable { peer: peer.to_owned(), error };
        let found = peer.to_socket_addrs().map_err(unknown)?.next();
        found.ok_or_else(|| Fault::Usage(format!("{peer} has no address")))
    }

    fn of(peer: &str, patience: Duration, line: Line) -> Transport {
        Transport { peer: peer.to_owned(), patience, line, rest: Vec::new() }
    }

    /// Connects over TCP.
    pub fn tcp(peer: &str, patience: Duration) -> Result<Transport, Fault> {
        let address = Transport::address(peer)?;
        let stream = TcpStream::connect_timeout(&address, patience);
        let stream = stream.map_err(|error| failed(peer, patience, error))?;
        let set = stream.set_nodelay(true).and_then(|()| stream.set_write_timeout(Some(patience)));
        set.map_err(|error| failed(peer, patience, error))?;
        Ok(Transport::of(peer, patience, Line::Tcp(stream)))
    }

    /// Opens a UDP socket that accepts only datagrams from the peer.
    pub fn udp(peer: &str, patience: Duration) -> Result<Transport, Fault> {
        let address = Transport::address(peer)?;
        let own = if address.is_ipv4() { "0.0.0.0:0" } else { "[::]:0" };
        let socket = UdpSocket::bind(own).and_then(|socket| {
            socket.connect(address)?;
            Ok(socket)
        });
        let socket = socket.map_err(|error| failed(peer, patience, error))?;
        Ok(Transport::of(peer, patience, Line::Udp(socket)))
    }

    /// Opens a serial line. Without settings its present ones are kept.
    pub fn serial(
        peer: &str,
        settings: Option<Settings>,
        patience: Duration,
    ) -> Result<Transport, Fault> {
        let unknown = |error| Fault::Unreachable { peer: peer.to_owned(), error };
        let mut port = serial::open(peer, settings).map_err(unknown)?;
        port.set_write_timeout(patience).map_err(unknown)?;
        Ok(Transport::of(peer, patience, Line::Serial(port)))
    }

    /// The address or the serial line of the peer.
    pub fn peer(&self) -> &str {
        &self.peer
    }

    /// The last bytes of this computer's and the peer's addresses, which serve as node numbers; 0 without an address.
    pub fn nodes(&self) -> (u8, u8) {
        let last = |address: io::Result<SocketAddr>| match address {
            Ok(SocketAddr::V4(address)) => address.ip().octets()[3],
            _ => 0,
        };
        match &self.line {
            Line::Udp(socket) => (last(socket.local_addr()), last(socket.peer_addr())),
            Line::Tcp(_) | Line::Serial(_) => (0, 0),
        }
    }

    /// Sends a request and waits for a whole frame.
    pub fn ask(&mut self, request: &[u8], split: fn(&[u8]) -> Split) -> Result<Vec<u8>, Fault> {
        // Bytes that arrived late belong to the answer to an earlier request.
        self.rest.clear();
        self.discard();
        self.send(request)?;
        self.next(split)
    }

    /// Sends.
    pub fn send(&mut self, request: &[u8]) -> Result<(), Fault> {
        let sent = match &mut self.line {
            Line::Tcp(stream) => stream.write_all(request),
            Line::Udp(socket) => socket.send(request).map(drop),
            Line::Serial(port) => port.write_all(request),
        };
        sent.map_err(|error| failed(&self.peer, self.patience, error))
    }

    /// Waits for a whole frame.
    pub fn next(&mut self, split: fn(&[u8]) -> Split) -> Result<Vec<u8>, Fault> {
        let end = Instant::now() + self.patience;
        loop {
            match split(&self.rest) {
                Split::Frame(length) => {
                    let rest = self.rest.split_off(length);
                    return Ok(std::mem::replace(&mut self.rest, rest));
                }
                Split::Garbage if !self.rest.is_empty() => {
                    return Err(Fault::NoAnswer {
                        peer: self.peer.clone(),
                        why: "it does not begin like a frame of this protocol".to_owned(),
                    });
                }
                Split::Garbage | Split::More => {}
            }
            let left = end.saturating_duration_since(Instant::now());
            if left.is_zero() {
                return Err(self.late());
            }
            let came = self.receive(left).map_err(|error| match error.kind() {
                ErrorKind::WouldBlock | ErrorKind::TimedOut => self.late(),
                _ => failed(&self.peer, self.patience, error),
            })?;
            if came.is_empty() {
                let peer = self.peer.clone();
                return Err(match self.rest.len() {
                    0 => Fault::Closed { peer },
                    got => Fault::Half { peer, got, closed: true },
                });
            }
            self.rest.extend(came);
        }
    }

    fn late(&self) -> Fault {
        let peer = self.peer.clone();
        match self.rest.len() {
            0 => Fault::TimedOut { peer, after: self.patience },
            got => Fault::Half { peer, got, closed: false },
        }
    }

    /// The next received bytes; empty if the line was closed.
    fn receive(&mut self, patience: Duration) -> io::Result<Vec<u8>> {
        let mut buffer = [0; 4096];
        match &mut self.line {
            Line::Tcp(stream) => {
                stream.set_read_timeout(Some(patience))?;
                stream.read(&mut buffer).map(|count| buffer[..count].to_vec())
            }
            Line::Udp(socket) => {
                socket.set_read_timeout(Some(patience))?;
                socket.recv(&mut buffer).map(|count| buffer[..count].to_vec())
            }
            Line::Serial(port) => {
                port.set_read_timeout(patience)?;
                match port.read(&mut buffer) {
                    Ok(count) => Ok(buffer[..count].to_vec()),
                    // The device or its other end was removed.
                    Err(error) if error.kind() == ErrorKind::BrokenPipe => Ok(Vec::new()),
                    Err(error) => Err(error),
                }
            }
        }
    }

    /// Discards bytes that arrived before the request.
    pub fn discard(&mut self) {
        self.rest.clear();
        if let Line::Serial(port) = &self.line {
            // If this fails, the check of the answer finds the remaining bytes.
            let _ = port.discard_input_buffer();
        }
    }
}

fn failed(peer: &str, patience: Duration, error: io::Error) -> Fault {
    let peer = peer.to_owned();
    match error.kind() {
        ErrorKind::ConnectionRefused => Fault::Refused { peer },
        ErrorKind::TimedOut | ErrorKind::WouldBlock => Fault::TimedOut { peer, after: patience },
        ErrorKind::ConnectionReset | ErrorKind::ConnectionAborted | ErrorKind::BrokenPipe => {
            Fault::Closed { peer }
        }
        _ => Fault::Unreachable { peer, error },
    }
}
