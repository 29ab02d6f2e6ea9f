//! Why a PLC could not be read.

use std::io;
use std::time::Duration;
use thiserror::Error;

/// Why a PLC could not be read.
#[derive(Debug, Error)]
pub enum Fault {
    /// The name of the PLC, or of its device, cannot be used.
    #[error("{0}")]
    Usage(String),
    /// Nothing listens at this address.
    #[error(
        "{peer} refused the connection: check the port, and that the PLC has a connection open for this protocol"
    )]
    Refused {
        /// The address or serial line of the PLC.
        peer: String,
    },
    /// There is no route, or the connection broke.
    #[error("{peer} cannot be reached: {error}")]
    Unreachable {
        /// The address or serial line of the PLC.
        peer: String,
        /// The cause.
        error: io::Error,
    },
    /// No answer arrived in time.
    #[error(
        "{peer} did not answer within {} ms: check the address, the protocol and its settings (binary or ASCII, UDP or TCP)",
        after.as_millis()
    )]
    TimedOut {
        /// The address or serial line of the PLC.
        peer: String,
        /// The time waited.
        after: Duration,
    },
    /// The answer is incomplete.
    #[error("{peer} sent an incomplete frame: {got} bytes, then {}", if *closed { "it closed the connection" } else { "nothing more" })]
    Half {
        /// The address or serial line of the PLC.
        peer: String,
        /// The number of bytes that arrived.
        got: usize,
        /// Whether the connection was closed.
        closed: bool,
    },
    /// The PLC closed the connection instead of answering.
    #[error("{peer} closed the connection without an answer: all its connections may be in use")]
    Closed {
        /// The address or serial line of the PLC.
        peer: String,
    },
    /// The PLC sent something that does not answer the request.
    #[error("{peer} sent an invalid answer: {why}")]
    NoAnswer {
        /// The address or serial line of the PLC.
        peer: String,
        /// What is wrong with the answer.
        why: String,
    },
    /// The PLC refused the request.
    #[error("{peer} answered with end code {code}: {meaning}")]
    EndCode {
        /// The address or serial line of the PLC.
        peer: String,
        /// The code, as manuals write it.
        code: String,
        /// What it means.
        meaning: String,
    },
}

impl Fault {
    /// Whether another request may succeed: the connection failed, and the PLC did not refuse.
    #[must_use]
    pub fn may_pass(&self) -> bool {
        match self {
            Fault::Refused { .. }
            | Fault::Unreachable { .. }
            | Fault::TimedOut { .. }
            | Fault::Half { .. }
            | Fault::Closed { .. }
            | Fault::NoAnswer { .. } => true,
            Fault::Usage(_) | Fault::EndCode { .. } => false,
        }
    }
}

/// What is wrong with an answer, before it is known from whom it came.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Wrong {
    /// It does not answer the request.
    NoAnswer(String),
    /// It is a refusal.
    EndCode {
        /// The code, as manuals write it.
        code: String,
        /// What it means.
        meaning: String,
    },
}

impl Wrong {
    /// No answer, since.
    pub fn no(why: impl Into<String>) -> Wrong {
        Wrong::NoAnswer(why.into())
    }

    /// The same with who sent it.
    #[must_use]
    pub fn from(self, peer: &str) -> Fault {
        let peer = peer.to_owned();
        match self {
            Wrong::NoAnswer(why) => Fault::NoAnswer { peer, why },
            Wrong::EndCode { code, meaning } => Fault::EndCode { peer, code, meaning },
        }
    }
}
