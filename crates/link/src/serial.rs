//! Serial lines and their settings.

use serial2::{CharSize, FlowControl, KeepSettings, SerialPort, StopBits};
use std::fmt;
use std::io;
use std::path::Path;

/// The parity bit.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Parity {
    /// With it, an even number of bits is 1.
    Even,
    /// With it, an odd number of bits is 1.
    Odd,
    /// There is none.
    None,
}

/// The settings of a serial line.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Settings {
    /// Bits a second.
    pub baud: u32,
    /// The parity.
    pub parity: Parity,
    /// Bits of data in a character: 7 or 8.
    pub bits: u8,
    /// Stop bits: 1 or 2.
    pub stop: u8,
}

impl Default for Settings {
    /// The factory settings of Host Link Units.
    fn default() -> Settings {
        Settings { baud: 9600, parity: Parity::Even, bits: 7, stop: 2 }
    }
}

impl fmt::Display for Settings {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let parity = match self.parity {
            Parity::Even => 'E',
            Parity::Odd => 'O',
            Parity::None => 'N',
        };
        write!(f, "{} {}{parity}{}", self.baud, self.bits, self.stop)
    }
}

/// Whether it is a pseudo-terminal, which ignores these settings.
fn is_pseudo(path: &Path) -> bool {
    let real = path.canonicalize().unwrap_or_else(|_| path.to_owned());
    ["/dev/pts", "/dev/ttys"].iter().any(|begin| real.to_string_lossy().starts_with(begin))
}

/// Opens a line. Without settings its present ones are kept.
///
/// # Errors
/// It cannot be opened, or cannot have these settings.
pub fn open(path: &str, settings: Option<Settings>) -> io::Result<SerialPort> {
    let Some(wanted) = settings else { return SerialPort::open(path, KeepSettings) };
    let pseudo = is_pseudo(Path::new(path));
    let configure = |mut set: serial2::Settings| {
        set.set_raw();
        set.set_flow_control(FlowControl::None);
        // A pseudo-terminal has no speed, parity or character size.
        if !pseudo {
            set.set_baud_rate(wanted.baud)?;
            set.set_char_size(if wanted.bits == 7 { CharSize::Bits7 } else { CharSize::Bits8 });
            set.set_stop_bits(if wanted.stop == 1 { StopBits::One } else { StopBits::Two });
            set.set_parity(match wanted.parity {
                Parity::Even => serial2::Parity::Even,
                Parity::Odd => serial2::Parity::Odd,
                Parity::None => serial2::Parity::None,
            });
        }
        Ok(set)
    };
    SerialPort::open(path, configure)
}
