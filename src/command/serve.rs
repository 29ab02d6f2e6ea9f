//! `scanbound serve`: an emulated CPU that answers requests like a PLC.

use super::options::{ProjectOptions, stop_on_interrupt};
use super::output::{say, tell};
use super::{Failure, Outcome, values};
use anyhow::{Context, anyhow};
use clap::Args;
use scanbound::audit::{Ready, ready};
use scanbound::base::time::Picos;
use scanbound::emulated::{Cpu, Disturbance, Halt};
#[cfg(unix)]
use scanbound::link::pty::Pty;
use scanbound::link::server::{Listening, Request, ServedProtocol};
#[cfg(unix)]
use scanbound::link::server::{PAUSE, answers};
use scanbound::link::{State, registers};
use std::net::{IpAddr, Ipv4Addr, SocketAddr};
#[cfg(unix)]
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
#[cfg(unix)]
use std::sync::mpsc::Sender;
use std::sync::mpsc::{Receiver, channel};
use std::thread;
#[cfg(unix)]
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

pub const ABOUT: &str = "\
Emulates a CPU that runs a program scan by scan with a table's times, and answers requests like a PLC.

The scan times are in the same registers, and with the same resolution, as on a CPU of this family, and can be read over \
SLMP (MC protocol 3E, binary and ASCII), FINS over TCP and UDP, and Host Link over TCP and on a pseudo-terminal. Write \
requests are refused with the end code for an unknown command. Timers and counters run with its own clock; inputs stay as \
they are set. A scan takes as long as the table says, unless --fast.";

const EXAMPLES: &str = "\
Examples:
  scanbound serve PLC/ --cpu Q26UDV --slmp 5007
  scanbound serve main.il --table my.csv --slmp 5007 --jitter 50us --interrupt 80us/10ms
  scanbound serve program.cxt --fins 9600 --set W0=1
  scanbound serve program.il --cpu C200H --pty plc       Host Link on a serial line: ./plc

The address is 127.0.0.1 unless one is given with the port (0.0.0.0:5007 for all that can reach this machine).";

/// The arguments of `serve`.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct Arguments {
    #[command(flatten)]
    serving: ServeOptions,
    #[command(flatten)]
    project: ProjectOptions,
}

/// How the emulated CPU runs, and over which protocols it answers.
#[derive(Debug, Clone, Args)]
pub struct ServeOptions {
    /// Answer SLMP over TCP here: a port, or address and port
    #[arg(long, value_name = "[ADDRESS:]PORT", value_parser = address)]
    slmp: Option<SocketAddr>,
    /// Answer FINS here, over TCP and UDP
    #[arg(long, value_name = "[ADDRESS:]PORT", value_parser = address)]
    fins: Option<SocketAddr>,
    /// Answer Host Link (C-mode) over TCP here, like a serial device server
    #[arg(long, value_name = "[ADDRESS:]PORT", value_parser = address)]
    hostlink: Option<SocketAddr>,
    /// Answer Host Link (C-mode) on a pseudo-terminal, a virtual serial line; a link of this name points to it
    #[cfg(unix)]
    #[arg(long, value_name = "LINK", num_args = 0..=1)]
    pty: Option<Option<PathBuf>>,
    /// The unit's number for Host Link
    #[arg(long, value_name = "0-31", default_value_t = 0, value_parser = clap::value_parser!(u8).range(0..32), allow_negative_numbers = true)]
    unit: u8,
    /// The longest random extension of each scan; the seed determines it
    #[arg(long, value_name = "DURATION", default_value = "0us", value_parser = values::duration)]
    jitter: Picos,
    /// Something interrupts the program: its duration and its interval, such as 80us/10ms
    #[arg(long, value_name = "DURATION/DURATION", value_parser = interrupt)]
    interrupt: Option<(Picos, Picos)>,
    /// The seed of the random numbers
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = values::count::<u64>, allow_negative_numbers = true)]
    seed: u64,
    /// Set a device before the first scan, such as X0=1 or D100=20; may be repeated
    #[arg(long, value_name = "DEVICE=VALUE", value_parser = setting)]
    set: Vec<(String, u16)>,
    /// Start the next scan at once, without waiting for the scan's time to pass
    #[arg(long)]
    fast: bool,
    /// Go to STOP after this many scans, and continue to answer
    #[arg(long, value_name = "N", value_parser = values::count::<u64>, allow_negative_numbers = true)]
    stop_after: Option<u64>,
    /// End after this time
    #[arg(long = "for", value_name = "DURATION", value_parser = values::span, allow_hyphen_values = true)]
    duration: Option<Duration>,
}

fn address(text: &str) -> Result<SocketAddr, String> {
    if let Ok(port) = text.parse::<u16>() {
        return Ok(SocketAddr::new(IpAddr::V4(Ipv4Addr::LOCALHOST), port));
    }
    text.parse().map_err(|_| "give a port, or an address and a port such as 127.0.0.1:5007".into())
}

pub(super) fn interrupt(text: &str) -> Result<(Picos, Picos), String> {
    let form = || "give the duration and the interval, such as 80us/10ms".to_owned();
    let (takes, every) = text.split_once('/').ok_or_else(form)?;
    let (takes, every) = (values::duration(takes)?, values::duration(every)?);
    match takes < every {
        true => Ok((takes, every)),
        false => Err("the duration must be shorter than the interval".to_owned()),
    }
}

fn setting(text: &str) -> Result<(String, u16), String> {
    let form = || "give a device and a number from -32768 to 65535, such as D100=20".to_owned();
    let (name, value) = text.split_once('=').ok_or_else(form)?;
    let value: i32 = value.trim().parse().map_err(|_| form())?;
    let word =
        u16::try_from(value).ok().or_else(|| i16::try_from(value).ok().map(i16::cast_unsigned));
    Ok((name.trim().to_owned(), word.ok_or_else(form)?))
}

/// Serves until Ctrl-C, or for the requested time.
pub fn run(arguments: &Arguments) -> Result<Outcome, Failure> {
    arguments.serving.asked()?;
    let project = arguments.project.or_here()?;
    let ready = project.with_request(|request| Ok(ready(request)?))?;
    arguments.serving.serve(&ready, project.table_and_cpu().1)
}

impl ServeOptions {
    /// The same with other names for the devices that are set, if they have any.
    pub fn renamed(&self, name: impl Fn(&str) -> Option<String>) -> ServeOptions {
        let mut other = self.clone();
        for (device, _) in &mut other.set {
            if let Some(name) = name(device) {
                *device = name;
            }
        }
        other
    }

    /// The network addresses to listen on.
    pub fn asked(&self) -> Result<Vec<(ServedProtocol, SocketAddr)>, Failure> {
        let asked = [
            (ServedProtocol::Slmp, self.slmp),
            (ServedProtocol::FinsTcp, self.fins),
            (ServedProtocol::FinsUdp, self.fins),
            (ServedProtocol::HostLink(self.unit), self.hostlink),
        ];
        let asked: Vec<(ServedProtocol, SocketAddr)> =
            asked.into_iter().filter_map(|(spoken, address)| Some((spoken, address?))).collect();
        #[cfg(unix)]
        if self.pty.is_some() {
            return Ok(asked);
        }
        if asked.is_empty() {
            let ways = "--slmp, --fins, --hostlink or --pty";
            return Err(anyhow!("choose a protocol: {ways}").into());
        }
        Ok(asked)
    }

    /// Answers on a pseudo-terminal, if requested.
    #[cfg(unix)]
    fn answer_on_pty(
        &self,
        requests: &Sender<Request>,
        over: &Arc<AtomicBool>,
    ) -> Result<Option<JoinHandle<()>>, Failure> {
        let Some(link) = &self.pty else { return Ok(None) };
        let pty =
            Pty::open(link.as_deref(), PAUSE).context("a pseudo-terminal cannot be opened")?;
        say(&format!("listening: HostLink on {}\n", pty.path().display()));
        let (requests, over, spoken) =
            (requests.clone(), Arc::clone(over), ServedProtocol::HostLink(self.unit));
        let answer = move || {
            // If the line breaks, the thread ends by itself.
            let _ = answers(pty, spoken, &requests, &over);
        };
        Ok(Some(thread::spawn(answer)))
    }

    /// Runs a program and answers, until Ctrl-C or for the requested time.
    pub fn serve(&self, ready: &Ready, model: Option<&str>) -> Result<Outcome, Failure> {
        let Ready { program, table, prices, warnings } = ready;
        let arguments = self;
        tell(warnings);
        let listening: Vec<Listening> = self
            .asked()?
            .into_iter()
            .map(|(spoken, address)| {
                Listening::on(spoken, address)
                    .with_context(|| format!("{address} cannot be listened to"))
            })
            .collect::<Result<_, _>>()?;
        for one in &listening {
            say(&format!("listening: {} on {}\n", one.spoken(), one.address));
            if !one.address.ip().is_loopback() {
                say("  everybody who can reach this address can read the emulated CPU\n");
            }
        }
        let times = prices.times();
        let registers = table.family.as_deref().and_then(registers::of);
        let disturbance = Disturbance {
            jitter: arguments.jitter,
            interrupt: arguments.interrupt,
            seed: arguments.seed,
        };
        let mut cpu = Cpu::new(program, &times, prices.overhead_sum(), registers, disturbance);
        if let Some(model) = model {
            cpu.call(model);
        }
        for (name, value) in &arguments.set {
            if !cpu.set_named(name, *value) {
                return Err(anyhow!("--set {name}: the CPU has no such device").into());
            }
        }
        let over = stop_on_interrupt()?;
        let (requests, waiting) = channel();
        for one in listening {
            let (requests, over) = (requests.clone(), Arc::clone(&over));
            thread::spawn(move || one.serve(requests, over));
        }
        #[cfg(unix)]
        let line = self.answer_on_pty(&requests, &over)?;
        drop(requests);
        serve(arguments, &mut cpu, &waiting, &over);
        over.store(true, Ordering::Relaxed);
        // Requests that still wait get no answer. Then the line is removed together with its link.
        drop(waiting);
        #[cfg(unix)]
        if let Some(line) = line {
            let _ = line.join();
        }
        if let Some(halt) = cpu.halted() {
            let (Halt::Unknown(at) | Halt::Endless(at)) = halt;
            let text = program.instructions.get(at).map_or("", |one| &*one.text);
            let why = match halt {
                Halt::Unknown(_) => "the program's path depends on its result, which is unknown",
                Halt::Endless(_) => "the scan does not end",
            };
            say(&format!("the CPU went to STOP after {} scans at {text}: {why}\n", cpu.scans()));
        }
        if let Some([_, least, most]) = cpu.measured() {
            let (scans, clock) = (cpu.scans(), cpu.clock());
            say(&format!("{scans} scans in {clock}, from {least} to {most} by its registers\n"));
        }
        Ok(Outcome::Done)
    }
}

/// Runs scans, and answers between them.
fn serve(
    arguments: &ServeOptions,
    cpu: &mut Cpu<'_>,
    waiting: &Receiver<Request>,
    over: &AtomicBool,
) {
    const IDLE: Duration = Duration::from_millis(20);
    let begun = Instant::now();
    let mut due = begun;
    while !over.load(Ordering::Relaxed) {
        if arguments.duration.is_some_and(|end| begun.elapsed() >= end) {
            return;
        }
        if arguments.stop_after == Some(cpu.scans()) {
            cpu.switch(State::Stop);
        }
        match cpu.scan() {
            // Requests are answered at the end of a scan, after the time that the scan takes on a CPU.
            Some(time) if !arguments.fast => {
                due += Duration::from_nanos(time.0 / 1000);
                // If this machine is too slow, the emulated CPU does not try to catch up.
                due = due.max(Instant::now());
            }
            Some(_) => due = Instant::now(),
            None => due = Instant::now() + IDLE,
        }
        loop {
            let left = due.saturating_duration_since(Instant::now());
            match waiting.recv_timeout(left) {
                Ok(request) => request.answer(cpu),
                Err(_) => break,
            }
            if left.is_zero() && arguments.fast {
                break;
            }
        }
    }
}
