//! The settings of a serial line: the same options for every command that opens one.

use clap::{Args, ValueEnum};
use scanbound::link::serial;

/// The settings of a serial line.
#[derive(Debug, Args)]
#[command(next_help_heading = "Serial line")]
pub struct LineOptions {
    /// Bits a second [default: 9600]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(50..=4_000_000))]
    baud: Option<u32>,
    /// The parity bit [default: even]
    #[arg(long, value_enum, value_name = "PARITY")]
    parity: Option<Parity>,
    /// Bits of data in a character: 7 (ASCII) or 8 (JIS 8) [default: 7]
    #[arg(long, value_name = "7|8", value_parser = clap::value_parser!(u8).range(7..=8))]
    bits: Option<u8>,
    /// Stop bits [default: 2]
    #[arg(long, value_name = "1|2", value_parser = clap::value_parser!(u8).range(1..=2))]
    stop: Option<u8>,
}

/// A parity.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Parity {
    Even,
    Odd,
    None,
}

impl LineOptions {
    /// The settings. Those that are not given are the factory settings of Host Link Units.
    pub fn settings(&self) -> serial::Settings {
        let usual = serial::Settings::default();
        let parity = self.parity.map_or(usual.parity, |parity| match parity {
            Parity::Even => serial::Parity::Even,
            Parity::Odd => serial::Parity::Odd,
            Parity::None => serial::Parity::None,
        });
        serial::Settings {
            baud: self.baud.unwrap_or(usual.baud),
            parity,
            bits: self.bits.unwrap_or(usual.bits),
            stop: self.stop.unwrap_or(usual.stop),
        }
    }

    /// The settings, if at least one was given. Otherwise the line keeps its settings.
    pub fn stated(&self) -> Option<serial::Settings> {
        let any = self.baud.is_some() || self.parity.is_some();
        (any || self.bits.is_some() || self.stop.is_some()).then(|| self.settings())
    }
}
