//! `scanbound snet monitor`: watches a C200H that runs a net's code.

use super::net::read;
use super::terminal::{Pages, Pressed};
use crate::command::line::LineOptions;
use crate::command::options::stop_on_interrupt;
use crate::command::output::{Target, apart, say};
use crate::command::sink::Sink;
use crate::command::{Failure, Outcome, values};
use anyhow::anyhow;
use clap::{Args, ValueEnum};
use scanbound::link::Fault;
use scanbound::link::station::Station;
use scanbound::report::snet::{View, readings};
use scanbound::snet::Diagram;
use scanbound::snet::monitor::{Plan, Reading};
use scanbound::snet::translate::assign;
use std::io::{IsTerminal, Write};
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

pub const ABOUT: &str = "\
Watch a C200H run a net's code, over Host Link on a serial line

Shows on the drawn net which boxes are marked, which transitions fire, how far timers and counters are (set value \
minus present value), and which outer gates are on. Nothing is written to the PLC. If a poll takes several answers, its \
values are from different moments; the display says so. Lost answers, wrong check sums, timeouts and a closed line are \
shown, and the last picture is dimmed until a poll succeeds again.

In a pipe, or with --format, each change is a line of text, or each poll one of JSON.";

const EXAMPLES: &str = "\
Examples:
  scanbound snet monitor line.snet --port /dev/ttyUSB0 --unit 0 --baud 9600 --parity even --bits 7 --stop 2
  scanbound snet monitor line.snet --port plc --format json --for 10s

Keys: arrow keys scroll, Tab shows the next page of the net, q ends.";

/// The arguments of `snet monitor`.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct Arguments {
    /// A net with its addresses (.snet, .pnml)
    #[arg(value_name = "NET")]
    net: PathBuf,
    /// Assign relays and numbers to elements without one, as translate does
    #[arg(long)]
    assign: bool,
    /// The serial line; or HOST:PORT of a serial device server
    #[arg(long, value_name = "DEVICE|HOST:PORT")]
    port: String,
    /// The unit's number on the line
    #[arg(long, value_name = "0-31", default_value_t = 0, value_parser = clap::value_parser!(u8).range(0..32), allow_negative_numbers = true)]
    unit: u8,
    /// How long to wait for each answer
    #[arg(long, value_name = "DURATION", default_value = "1s", value_parser = values::span, allow_hyphen_values = true)]
    timeout: Duration,
    /// The pause between two polls
    #[arg(long, value_name = "DURATION", default_value = "100ms", value_parser = values::span, allow_hyphen_values = true)]
    every: Duration,
    /// End after this time
    #[arg(long = "for", value_name = "DURATION", value_parser = values::span, allow_hyphen_values = true)]
    duration: Option<Duration>,
    /// Lines instead of the picture
    #[arg(long, value_enum, value_name = "FORMAT")]
    format: Option<Format>,
    /// Write the lines to a file
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    #[command(flatten)]
    line: LineOptions,
}

/// The format of lines.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Format {
    #[value(alias = "txt")]
    Text,
    #[value(alias = "jsonl")]
    Json,
}

/// Watches the PLC.
pub fn run(arguments: &Arguments) -> Result<Outcome, Failure> {
    apart(&[&arguments.net], &[("--output", arguments.output.as_deref())])?;
    let mut diagram = read(&arguments.net)?;
    if arguments.assign {
        assign(&mut diagram);
    }
    let plan = Plan::new(&diagram);
    match plan.addressed() {
        (0, _) => {
            let why = "no element of the net has an address: give the addresses of its code, such as `box B01 = 00300`, or use --assign if the code was made with it";
            return Err(anyhow!("{}: {why}", arguments.net.display()).into());
        }
        (_, 0) => {}
        (_, without) => say(&format!("{without} elements have no address and are shown as ?\n")),
    }
    let settings = arguments.line.settings();
    let station = Station::new(&arguments.port, arguments.unit, settings, arguments.timeout);
    let stop = stop_on_interrupt()?;
    let mut watch = Watch {
        arguments,
        diagram: &diagram,
        plan,
        station,
        begun: Instant::now(),
        polls: 0,
        failed: 0,
    };
    let format = values::format_or_suffix(arguments.format, arguments.output.as_deref())?;
    let lines = arguments.format.is_some() || arguments.output.is_some();
    if lines || !std::io::stdout().is_terminal() {
        let mut sink = Sink::open(Target::new(arguments.output.as_deref())?)?;
        let written = watch.lines(format, &mut sink, &stop);
        sink.finish(written)?;
    } else {
        let mut terminal = ratatui::try_init().map_err(|why| anyhow!("no terminal: {why}"))?;
        let shown = watch.screen(&mut terminal, &stop);
        ratatui::restore();
        shown.map_err(|why| anyhow!("the terminal cannot be written: {why}"))?;
    }
    if watch.polls == watch.failed && watch.polls > 0 {
        return Err(anyhow!("none of {} polls was answered", watch.polls).into());
    }
    say(&format!("{} polls, {} of them without a result\n", watch.polls, watch.failed));
    Ok(Outcome::Done)
}

struct Watch<'a> {
    arguments: &'a Arguments,
    diagram: &'a Diagram,
    plan: Plan,
    station: Station,
    begun: Instant,
    polls: u64,
    failed: u64,
}

impl Watch<'_> {
    fn goes_on(&self, stop: &AtomicBool) -> bool {
        let over = self.arguments.duration.is_some_and(|end| self.begun.elapsed() >= end);
        !over && !stop.load(Ordering::Relaxed)
    }

    fn poll(&mut self) -> Result<Reading, Fault> {
        let read = self.plan.poll(&mut self.station);
        self.polls += 1;
        self.failed += u64::from(read.is_err());
        read
    }

    /// How long to wait before the next poll. A lost line is not retried without a pause.
    fn pause(&self, read: &Result<Reading, Fault>) -> Duration {
        const GONE: Duration = Duration::from_millis(500);
        if read.is_err() { self.arguments.every.max(GONE) } else { self.arguments.every }
    }

    /// Writes one line per poll, or per change.
    fn lines(&mut self, format: Format, sink: &mut Sink, stop: &AtomicBool) -> std::io::Result<()> {
        let mut last = String::new();
        while self.goes_on(stop) {
            let read = self.poll();
            let since = self.begun.elapsed();
            match format {
                Format::Json => {
                    let line = match &read {
                        Ok(reading) => readings::json(self.diagram, since, reading),
                        Err(fault) => readings::json_fault(since, &fault.to_string()),
                    };
                    sink.write_all(line?.as_bytes())?;
                    sink.flush()?;
                }
                Format::Text => {
                    let line = match &read {
                        Ok(reading) => {
                            let from = match reading.is_of_one_moment() {
                                true => String::new(),
                                false => format!(" [from {} answers]", reading.answers),
                            };
                            readings::text(self.diagram, reading) + &from
                        }
                        Err(fault) => format!("fault: {fault}"),
                    };
                    if line != last {
                        writeln!(sink, "{:8.2} s  {line}", since.as_secs_f64())?;
                        sink.flush()?;
                        last = line;
                    }
                }
            }
            std::thread::sleep(self.pause(&read));
        }
        Ok(())
    }

    /// Shows the picture until the user ends it.
    fn screen(
        &mut self,
        terminal: &mut ratatui::DefaultTerminal,
        stop: &AtomicBool,
    ) -> std::io::Result<()> {
        let mut pages = Pages::new(self.diagram);
        let mut view = View::unknown(self.diagram);
        let mut good: Option<Instant> = None;
        while self.goes_on(stop) {
            let read = self.poll();
            let head;
            let words = match &read {
                Ok(reading) => {
                    good = Some(Instant::now());
                    view = View::read(self.diagram, reading);
                    head = headline(&self.arguments.port, reading);
                    vec![String::new()]
                }
                Err(fault) => {
                    view.is_old = true;
                    head = match good {
                        Some(good) => format!("not read for {:.1} s", good.elapsed().as_secs_f64()),
                        None => "nothing read yet".to_owned(),
                    };
                    vec![format!("fault: {fault}"), String::new()]
                }
            };
            let mut words = words;
            if let Some(last) = words.last_mut() {
                *last = "q ends, arrows move, Tab turns the page".to_owned();
            }
            terminal.draw(|frame| {
                let area = frame.area();
                pages.draw(frame.buffer_mut(), area, &view, &head, &words);
            })?;
            let next = Instant::now() + self.pause(&read);
            while self.goes_on(stop) && Instant::now() < next {
                let left = next.saturating_duration_since(Instant::now());
                match pages.pressed(left)? {
                    Some(Pressed::Quit) => return Ok(()),
                    Some(_) => {
                        terminal.draw(|frame| {
                            let area = frame.area();
                            pages.draw(frame.buffer_mut(), area, &view, &head, &words);
                        })?;
                    }
                    None => {}
                }
            }
        }
        Ok(())
    }
}

/// The heading above a picture.
fn headline(port: &str, reading: &Reading) -> String {
    let moment = match reading.is_of_one_moment() {
        true => "one moment".to_owned(),
        false => format!(
            "put together from {} answers in {} ms",
            reading.answers,
            reading.took.as_millis()
        ),
    };
    format!("{port}: CPU in {}; {moment}", readings::cpu(reading.cpu).to_ascii_uppercase())
}
