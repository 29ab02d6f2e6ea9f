//! `scanbound live`: reads a PLC's scan times while it runs.

use super::line::LineOptions;
use super::options::{ProjectOptions, SearchOptions, stop_on_interrupt};
use super::output::{Target, apart, complaint, say};
use super::sink::Sink;
use super::{Failure, Outcome, values};
use anyhow::anyhow;
use clap::{ArgGroup, Args};
use scanbound::audit::{Audit, Concluded, Value, conclude, follow};
use scanbound::base::time::Picos;
use scanbound::link::client::{Plc, Protocol};
use scanbound::link::device::Device;
use scanbound::link::registers::{self, Registers};
use scanbound::link::slmp::Code;
use scanbound::link::{Fault, State};
use scanbound::measured::live::{How, Notice, Watch, gap, head, row};
use scanbound::measured::{Bounds, Comparison, Measurements};
use scanbound::report::compare;
use scanbound::report::live::screen;
use scanbound::timing::table::Table;
use std::io::IsTerminal;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

pub const ABOUT: &str = "\
Reads a PLC's scan times while it runs, and compares them with the bound.

The CPU's own scan-time registers are read, again and again: the last scan, and the longest since the CPU runs, so that \
a long scan between two readings is seen, too. Nothing is ever written to the PLC. With programs, or --bound, it says \
when a scan came within 5 % of the bound, and draws on a terminal how the scans lie below it.";

const EXAMPLES: &str = "\
Examples:
  scanbound live PLC/ --slmp 192.168.3.39:5007 --for 10m -o scans.csv
  scanbound live --slmp 127.0.0.1:5007 --cpu Q26UDV --for 5s
  scanbound live program.cxt --fins 192.168.250.1 --watch-devices
  scanbound live --hostlink /dev/ttyUSB0 --baud 9600 --cpu C200H

scanbound compare PLC/ scans.csv reads the file again.

Exit codes: 0 done, 1 a scan lies above the bound, 2 the PLC cannot be read, or bad usage, 70 internal error";

/// The arguments of `live`.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
#[command(group = ArgGroup::new("plc").required(true))]
pub struct Arguments {
    #[command(flatten)]
    plc: PlcOptions,
    /// How long to read
    #[arg(long = "for", value_name = "DURATION", default_value = "60s", value_parser = values::span, allow_hyphen_values = true)]
    duration: Duration,
    /// The pause between two readings
    #[arg(long, value_name = "DURATION", default_value = "20ms", value_parser = values::span, allow_hyphen_values = true)]
    every: Duration,
    /// The bound, if no program is named
    #[arg(long, value_name = "DURATION", value_parser = values::duration, allow_hyphen_values = true)]
    bound: Option<Picos>,
    /// Read the devices of the program's worst scan whenever a scan is longer than all before
    #[arg(long)]
    watch_devices: bool,
    /// Write the readings to a file (CSV), which `scanbound compare` reads
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    #[command(flatten)]
    project: ProjectOptions,
    #[command(flatten)]
    search: SearchOptions,
}

/// The PLC, and the protocol to it.
#[derive(Debug, Args)]
#[command(next_help_heading = "PLC")]
pub struct PlcOptions {
    /// A PLC that speaks SLMP (MC protocol 3E) over TCP
    #[arg(long, value_name = "HOST:PORT", group = "plc")]
    slmp: Option<String>,
    /// A PLC that speaks FINS over UDP; the default port is 9600
    #[arg(long, value_name = "HOST[:PORT]", group = "plc")]
    fins: Option<String>,
    /// A PLC that speaks Host Link (C-mode): a serial line, or a serial device server
    #[arg(long, value_name = "DEVICE|HOST:PORT", group = "plc")]
    hostlink: Option<String>,
    /// SLMP in ASCII rather than binary
    #[arg(long, requires = "slmp")]
    ascii: bool,
    /// FINS over TCP rather than UDP
    #[arg(long, requires = "fins")]
    tcp: bool,
    /// The unit's number on the serial line
    #[arg(long, value_name = "0-31", default_value_t = 0, requires = "hostlink", value_parser = clap::value_parser!(u8).range(0..32))]
    unit: u8,
    /// How long to wait for each answer of the PLC
    #[arg(long, value_name = "DURATION", default_value = "2s", value_parser = values::span, allow_hyphen_values = true)]
    timeout: Duration,
    #[command(flatten)]
    line: LineOptions,
}

impl PlcOptions {
    /// The protocol, the PLC's name, and the usual family of CPUs with this protocol, which is used if nothing else
    /// gives the family.
    fn peer(&self) -> Result<(Protocol, String, &'static str), Fault> {
        Ok(match (&self.slmp, &self.fins, &self.hostlink) {
            (Some(peer), ..) => {
                let code = if self.ascii { Code::Ascii } else { Code::Binary };
                (Protocol::Slmp(code), peer.clone(), "q")
            }
            (_, Some(peer), _) => {
                let protocol = if self.tcp { Protocol::FinsTcp } else { Protocol::FinsUdp };
                let has_port = peer.rsplit_once(':').is_some();
                let peer = if has_port { peer.clone() } else { format!("{peer}:9600") };
                (protocol, peer, "cs")
            }
            (.., Some(peer)) => {
                (Protocol::HostLink(self.unit, self.line.stated()), peer.clone(), "c")
            }
            _ => {
                return Err(Fault::Usage(
                    "name the PLC with --slmp, --fins or --hostlink".to_owned(),
                ));
            }
        })
    }

    fn reach(&self) -> Result<Plc, Fault> {
        let (protocol, peer, _) = self.peer()?;
        Plc::connect(protocol, &peer, self.timeout)
    }

    /// Connects. Also returns the usual family of CPUs with this protocol, which is used if nothing else gives the
    /// family.
    pub fn connect(&self) -> Result<(Plc, &'static str), Failure> {
        let (_, _, family) = self.peer().map_err(fault)?;
        Ok((self.reach().map_err(fault)?, family))
    }
}

/// Why the PLC could not be read.
pub fn fault(fault: Fault) -> Failure {
    anyhow!(fault).into()
}

/// The project's audit and the family of its table.
fn audited(arguments: &Arguments) -> Result<Option<(Audit, Option<String>)>, Failure> {
    if arguments.project.is_open() {
        return Ok(None);
    }
    arguments.project.with_request(|request| {
        let request = arguments.search.of(request);
        let Concluded { audit, followed, .. } = conclude(follow(&request)?, &request)?;
        Ok(Some((audit, followed.table.family)))
    })
}

/// The registers of the CPU: by the program's table, by --table or --cpu, or by the protocol.
fn registers(
    arguments: &Arguments,
    audited: Option<&str>,
    usual: &'static str,
) -> Result<&'static Registers, Failure> {
    let named = match arguments.project.table_or_cpu() {
        Some(name) => {
            let table = Table::for_cpu(name).unwrap_or(name);
            Table::builtin(table).and_then(|table| table.family)
        }
        None => None,
    };
    let family = audited.map(str::to_owned).or(named).unwrap_or_else(|| usual.to_owned());
    registers::of(&family).ok_or_else(|| {
        let known: Vec<&str> = registers::families().collect();
        let known = known.join(", ");
        anyhow!(
            "the scan-time registers of CPUs of family {family} are unknown; known are those of {known}"
        )
        .into()
    })
}

/// Reads scan times, and compares them with the bound.
pub fn run(arguments: &Arguments) -> Result<Outcome, Failure> {
    let read: Vec<&Path> = arguments.project.reads();
    apart(&read, &[("--output", arguments.output.as_deref())])?;
    if arguments.watch_devices && arguments.project.is_open() {
        return Err(anyhow!(
            "--watch-devices: name the program, whose worst scan gives the devices"
        )
        .into());
    }
    let audited = audited(arguments)?;
    let (audit, family) = match audited {
        Some((audit, family)) => (Some(audit), family),
        None => (None, None),
    };
    let bound = arguments.bound.or_else(|| audit.as_ref().map(|audit| audit.bound.upper));
    let (mut plc, usual) = arguments.plc.connect()?;
    let registers = registers(arguments, family.as_deref(), usual)?;
    let devices = match &audit {
        Some(audit) if arguments.watch_devices => devices(audit, &plc),
        _ => Vec::new(),
    };
    let mut sink = match &arguments.output {
        Some(file) => Some(Sink::open(Target::new(Some(file))?)?),
        None => None,
    };
    let stop = stop_on_interrupt()?;
    let mut watching = Watching {
        arguments,
        registers,
        devices,
        watch: Watch::new(bound),
        longest: Picos::ZERO,
        drawn: 0,
        stopped: false,
        answered: false,
        at_longest: Vec::new(),
    };
    let ended = watching.read(&mut plc, &mut sink, &stop);
    if let Some(sink) = sink {
        sink.finish(Ok(()))?;
    }
    watching.clear();
    let peer = plc.peer().to_owned();
    watching.conclude(&peer, audit.as_ref())?;
    ended?;
    let above = |time: &Picos| bound.is_some_and(|bound| *time > bound);
    let is_above = watching.watch.times().iter().any(above);
    Ok(if is_above { Outcome::Refuted } else { Outcome::Done })
}

/// The devices of the worst scan that the protocol can read, and their values in that scan.
fn devices(audit: &Audit, plc: &Plc) -> Vec<(String, Device, u16)> {
    let asked = audit.witness.iter().filter(|one| one.at_start && one.matters);
    asked
        .filter_map(|one| {
            let value = match one.value {
                Value::Bit(bit) => u16::from(bit),
                Value::Word(word) => word.cast_unsigned(),
            };
            Some((one.name.clone(), plc.device(&one.name).ok()?, value))
        })
        .collect()
}

/// The interval for reading the CPU's state, redrawing, and retrying a lost connection.
const OFTEN: Duration = Duration::from_millis(500);

fn unwritten(error: std::io::Error) -> Failure {
    anyhow!("the readings cannot be written: {error}").into()
}

fn seconds(time: Duration) -> String {
    format!("{}.{} s", time.as_secs(), time.subsec_millis() / 100)
}

/// Why reading ends.
enum Trouble {
    /// The PLC did not answer, or refused.
    Plc(Fault),
    /// Any other reason.
    Other(Failure),
}

impl From<Fault> for Trouble {
    fn from(why: Fault) -> Trouble {
        Trouble::Plc(why)
    }
}

impl From<Failure> for Trouble {
    fn from(why: Failure) -> Trouble {
        Trouble::Other(why)
    }
}

/// The state of a reading session.
struct Watching<'a> {
    arguments: &'a Arguments,
    registers: &'static Registers,
    devices: Vec<(String, Device, u16)>,
    watch: Watch,
    longest: Picos,
    /// The number of drawn lines.
    drawn: usize,
    stopped: bool,
    /// Whether it answered all requests at least once.
    answered: bool,
    /// The values of the devices at the longest scan.
    at_longest: Vec<(String, u16)>,
}

impl Watching<'_> {
    fn read(
        &mut self,
        plc: &mut Plc,
        sink: &mut Option<Sink>,
        stop: &AtomicBool,
    ) -> Result<(), Failure> {
        if let Some(sink) = sink {
            head(sink).map_err(unwritten)?;
        }
        let begun = Instant::now();
        let (mut asked, mut shown) = (None::<Instant>, None::<Instant>);
        let late = |last: Option<Instant>| last.is_none_or(|last| last.elapsed() >= OFTEN);
        while begun.elapsed() < self.arguments.duration && !stop.load(Ordering::Relaxed) {
            let ask_state = late(asked);
            if ask_state {
                asked = Some(Instant::now());
            }
            match self.round(plc, sink, begun, ask_state) {
                Ok(()) => self.answered = true,
                Err(Trouble::Plc(why)) if self.answered && why.may_pass() => {
                    self.reconnect(plc, sink, begun, stop, why)?;
                    asked = None;
                }
                Err(Trouble::Plc(why)) => return Err(fault(why)),
                Err(Trouble::Other(why)) => return Err(why),
            }
            if self.stopped {
                std::thread::sleep(OFTEN.min(self.arguments.duration));
                continue;
            }
            if late(shown) {
                shown = Some(Instant::now());
                self.draw();
            }
            std::thread::sleep(self.arguments.every);
        }
        Ok(())
    }

    /// Reads once.
    fn round(
        &mut self,
        plc: &mut Plc,
        sink: &mut Option<Sink>,
        begun: Instant,
        ask_state: bool,
    ) -> Result<(), Trouble> {
        if ask_state {
            self.state(plc)?;
        }
        if self.stopped {
            return Ok(());
        }
        let told = plc.scan_times(self.registers)?;
        let readings = self.watch.take(begun.elapsed(), told).to_vec();
        for reading in &readings {
            // The reading is kept even if the devices can no longer be read.
            let held = match reading.time > self.longest {
                true => self.held(plc),
                false => Ok(Vec::new()),
            };
            let devices = held.as_ref().map_or(&[][..], Vec::as_slice);
            if let Some(sink) = sink {
                row(sink, reading, devices).map_err(unwritten)?;
            }
            if let Some(notice) = self.watch.notice(reading.time) {
                self.notice(&notice, reading.time, reading.how);
            }
            if reading.time > self.longest {
                self.longest = reading.time;
                self.at_longest = held?;
            }
        }
        Ok(())
    }

    /// Reconnects after the connection was lost, and marks the gap in the record. Gives up if the time is over, or if
    /// the PLC refuses.
    fn reconnect(
        &mut self,
        plc: &mut Plc,
        sink: &mut Option<Sink>,
        begun: Instant,
        stop: &AtomicBool,
        why: Fault,
    ) -> Result<(), Failure> {
        let lost = begun.elapsed();
        self.clear();
        say(&format!("the connection was lost after {}: {why}; trying again\n", seconds(lost)));
        let mut ended = Err(fault(why));
        while begun.elapsed() < self.arguments.duration && !stop.load(Ordering::Relaxed) {
            let left = self.arguments.duration.saturating_sub(begun.elapsed());
            std::thread::sleep(OFTEN.min(left));
            let again = self.arguments.plc.reach().and_then(|mut new| {
                let state = new.state(self.registers.family);
                match state {
                    Ok(_) | Err(Fault::EndCode { .. }) => Ok(new),
                    Err(why) => Err(why),
                }
            });
            match again {
                Ok(new) => {
                    *plc = new;
                    say(&format!("connected again after {}\n", seconds(begun.elapsed() - lost)));
                    ended = Ok(());
                    break;
                }
                Err(why) if why.may_pass() => {}
                Err(why) => {
                    ended = Err(fault(why));
                    break;
                }
            }
        }
        if let Some(sink) = sink {
            gap(sink, lost, begun.elapsed()).map_err(unwritten)?;
        }
        ended
    }

    /// Reads whether the CPU runs, and reports a change.
    fn state(&mut self, plc: &mut Plc) -> Result<(), Fault> {
        let state = match plc.state(self.registers.family) {
            Ok(state) => state,
            // A CPU that refuses this may still give its scan times.
            Err(Fault::EndCode { .. }) => State::Run,
            Err(why) => return Err(why),
        };
        let stopped = state == State::Stop;
        if stopped != self.stopped {
            self.clear();
            say(match stopped {
                true => {
                    "the CPU is in STOP: it makes no scans, and its registers keep the last values\n"
                }
                false => "the CPU is in RUN\n",
            });
        }
        self.stopped = stopped;
        Ok(())
    }

    /// The current values of the devices of the worst scan.
    fn held(&self, plc: &mut Plc) -> Result<Vec<(String, u16)>, Fault> {
        let held = self
            .devices
            .iter()
            .map(|(name, device, _)| plc.value(*device).map(|value| (name.clone(), value)));
        held.collect()
    }

    fn notice(&mut self, notice: &Notice, time: Picos, how: How) {
        self.clear();
        let when = match how {
            How::Read => "",
            How::Grown => ", between two readings,",
        };
        let bound = self.watch.bound().unwrap_or_default();
        say(&match notice {
            Notice::Near(share) => {
                format!(
                    "a scan of {time}{when} came within 5 % of the bound of {bound} ({share})\n"
                )
            }
            Notice::Above => {
                complaint(&format!("a scan of {time}{when} is above the bound of {bound}"))
            }
        });
    }

    /// Redraws the figures on a terminal.
    fn draw(&mut self) {
        if !std::io::stderr().is_terminal() {
            return;
        }
        self.clear();
        let text = screen(&self.watch);
        self.drawn = text.lines().count();
        say(&text);
    }

    /// Removes what was drawn.
    fn clear(&mut self) {
        if self.drawn > 0 {
            say(&format!("\x1b[{}A\x1b[J", self.drawn));
            self.drawn = 0;
        }
    }

    /// Reports all readings, compared with the bound.
    fn conclude(&self, peer: &str, audit: Option<&Audit>) -> Result<(), Failure> {
        let times = self.watch.times();
        if times.is_empty() {
            return Ok(());
        }
        let measured = Measurements {
            file: peer.to_owned(),
            how: format!("read from the CPU's registers, {} readings", times.len()),
            times,
            resolution: Some(self.registers.step),
            emulated: false,
            warnings: Vec::new(),
        };
        let compared = audit.and_then(|audit| {
            Comparison::new(audit.files.clone(), Bounds::of(audit), measured, false)
        });
        let mut text = match &compared {
            Some(found) => compare::text::render(found),
            None => screen(&self.watch),
        };
        if !self.devices.is_empty() {
            text += &self.devices_at_longest();
        }
        Target::new(None)?.write(&text)
    }

    /// The devices' values at the longest scan, compared with those in the program's worst scan.
    fn devices_at_longest(&self) -> String {
        let rows = self.devices.iter().zip(&self.at_longest);
        let differ: Vec<String> = rows
            .filter(|((_, _, worst), (_, held))| worst != held)
            .map(|((name, _, worst), (_, held))| format!("{name} {held}, not {worst}"))
            .collect();
        let (all, same) = (self.devices.len(), self.devices.len() - differ.len());
        let rest =
            if differ.is_empty() { String::new() } else { format!(": {}", differ.join("; ")) };
        format!(
            "\nat the longest scan, {same} of {all} devices had the values of the program's worst scan{rest}\n"
        )
    }
}
