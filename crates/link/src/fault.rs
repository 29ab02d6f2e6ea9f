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
    /// Nobody listens there.
    #[error(
        "{peer} refused the connection: check the port, and that the PLC has a connection open for this protocol"
    )]
    Refused {
        /// Who was asked.
        peer: String,
    },
    /// There is no way there, or the connection broke.
    #[error("{peer} cannot be reached: {error}")]
    Unreachable {
        /// Who was asked.
        peer: String,
        /// Why.
        error: io::Error,
    },
    /// Nothing came in time.
    #[error(
        "{peer} did not answer within {} ms: check the address, the protocol and its settings (binary or ASCII, UDP or TCP)",
        after.as_millis()
    )]
    TimedOut {
        /// Who was asked.
        peer: String,
        /// How long was waited.
        after: Duration,
    },
    /// The answer ended in its midst.
    #[error("{peer} sent half a frame: {got} bytes, and then {}", if *closed { "closed the connection" } else { "nothing more" })]
    Half {
        /// Who was asked.
        peer: String,
        /// How many bytes came.
        got: usize,
        /// Whether the connection was closed.
        closed: bool,
    },
    /// The PLC closed the connection instead of answering.
    #[error("{peer} closed the connection without an answer: all its connections may be in use")]
    Closed {
        /// Who was asked.
        peer: String,
    },
    /// What came is no answer to what was asked.
    #[error("{peer} sent what is no answer to the request: {why}")]
    NoAnswer {
        /// Who was asked.
        peer: String,
        /// What is wrong with it.
        why: String,
    },
    /// The PLC answered that it does not do what was asked.
    #[error("{peer} answered with end code {code}: {meaning}")]
    EndCode {
        /// Who was asked.
        peer: String,
        /// The code, as manuals write it.
        code: String,
        /// What it means.
        meaning: String,
    },
}

impl Fault {
    /// Whether it may be gone when the PLC is asked again: the way there failed, and the PLC did not refuse.
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
    /// It is no answer to what was asked.
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
