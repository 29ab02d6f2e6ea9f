//! `scanbound snet simulate`: simulates a net, on a terminal step by step or with a stimulus.

use super::net::{Initial, read_sound};
use super::terminal::{Pages, Pressed};
use crate::command::output::{Target, apart, say};
use crate::command::sink::Sink;
use crate::command::{Failure, Outcome, values};
use anyhow::{Context, anyhow};
use clap::{Args, ValueEnum};
use rand_pcg::Pcg64Mcg;
use rand_pcg::rand_core::{Rng, SeedableRng};
use ratatui::DefaultTerminal;
use scanbound::front::input::read_small;
use scanbound::report::snet::View;
use scanbound::report::snet::trace::{Dump, Rows};
use scanbound::snet::Diagram;
use scanbound::snet::simulation::{Rule, Simulation};
use scanbound::snet::stimulus::{Change, parse};
use std::io::{IsTerminal, Write};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

pub const ABOUT: &str = "\
Simulate a net: on the terminal step by step, or in batch by a stimulus

On the terminal the drawn net shows its marks, and the transitions that can fire are lit. A bell and a notice report a \
deadlock: no transition can fire any more, whatever the outer gates do and after all timers.

With --for, a simulation runs by itself: a stimulus (CSV: time_ms or time_s, then outer gates) says when gates change, and \
a row is written for each change. With the net's rule (the default), one transition fires in each step: the first in the \
net's order, or a random one with --seed. With --rule code, all that can fire do so in the same scan.";

const EXAMPLES: &str = "\
Examples:
  scanbound snet simulate line.snet
  scanbound snet simulate line.snet --for 30s --stimulus plant.csv --trace marks.csv --vcd marks.vcd
  scanbound snet simulate line.snet --rule code --step 5ms --for 1m

Keys: space steps, > and < choose among the transitions that can fire, r runs and pauses, b goes back, 1 to 9 and A to Z \
toggle gates, t lets time go by to the next timer's end, arrows move the picture, Tab turns the page, q ends.

Exit codes: 0 done, 1 the net came to a deadlock, 2 bad usage or input, 70 internal error";

/// The arguments of `snet simulate`.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct Arguments {
    /// A net (.snet, .pnml)
    #[arg(value_name = "NET")]
    net: PathBuf,
    /// The rule for firing transitions
    #[arg(long, value_enum, value_name = "RULE", default_value = "net")]
    rule: By,
    /// How the code gets the initial marks
    #[arg(long, value_enum, value_name = "HOW", default_value_t)]
    initial: Initial,
    /// The time of one firing, or of one scan
    #[arg(long, value_name = "DURATION", default_value = "10ms", value_parser = values::span, allow_hyphen_values = true)]
    step: Duration,
    /// Run automatically for this time
    #[arg(long = "for", value_name = "DURATION", value_parser = values::span, allow_hyphen_values = true)]
    duration: Option<Duration>,
    /// The outer gates over time: a CSV of times and gates
    #[arg(long, value_name = "FILE", requires = "duration")]
    stimulus: Option<PathBuf>,
    /// Write one row per change (CSV) to this file instead of stdout
    #[arg(long, value_name = "FILE", requires = "duration")]
    trace: Option<PathBuf>,
    /// Write every change (VCD, for GTKWave) to a file
    #[arg(long, value_name = "FILE", requires = "duration")]
    vcd: Option<PathBuf>,
    /// Choose at random which of several transitions fires, with this seed
    #[arg(long, value_name = "N", value_parser = values::count::<u64>, allow_negative_numbers = true)]
    seed: Option<u64>,
}

/// A rule.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum By {
    Net,
    Code,
}

/// Simulates.
pub fn run(arguments: &Arguments) -> Result<Outcome, Failure> {
    let files: Vec<&Path> = [Some(&arguments.net), arguments.stimulus.as_ref()]
        .into_iter()
        .flatten()
        .map(|one| &**one)
        .collect();
    let written = [("--trace", arguments.trace.as_deref()), ("--vcd", arguments.vcd.as_deref())];
    apart(&files, &written)?;
    let diagram = read_sound(&arguments.net, false)?;
    let (rule, marked) = match arguments.rule {
        By::Net => (Rule::Net, true),
        By::Code => (Rule::Code, arguments.initial == Initial::FirstScan),
    };
    let step = u64::try_from(arguments.step.as_millis()).unwrap_or(u64::MAX);
    if step == 0 {
        return Err(anyhow!("--step: a step takes a millisecond at least").into());
    }
    let mut net = Simulation::new(&diagram, rule, marked, step);
    if let Some(duration) = arguments.duration {
        return batch(arguments, &diagram, net, duration);
    }
    if !std::io::stdout().is_terminal() {
        return Err(
            anyhow!("this is not a terminal: give the time to run automatically (--for)").into()
        );
    }
    let mut terminal = ratatui::try_init().map_err(|why| anyhow!("no terminal: {why}"))?;
    let done = Screen::new(&diagram, step).run(&mut net, &mut terminal);
    ratatui::restore();
    done.map_err(|why| anyhow!("the terminal cannot be written: {why}"))?;
    Ok(Outcome::Done)
}

/// Runs automatically.
fn batch(
    arguments: &Arguments,
    diagram: &Diagram,
    mut net: Simulation<'_>,
    duration: Duration,
) -> Result<Outcome, Failure> {
    let changes = match &arguments.stimulus {
        None => Vec::new(),
        Some(file) => {
            let name = file.display().to_string();
            let bytes = read_small(file).with_context(|| format!("{name} cannot be read"))?;
            parse(diagram, &name, &bytes)?
        }
    };
    let mut sink = Sink::open(Target::new(arguments.trace.as_deref())?)?;
    let mut dumped = match &arguments.vcd {
        Some(file) => Some(Sink::open(Target::new(Some(file))?)?),
        None => None,
    };
    let mut random = arguments.seed.map(Pcg64Mcg::seed_from_u64);
    let end = u64::try_from(duration.as_millis()).unwrap_or(u64::MAX);
    let mut follow = || -> std::io::Result<Option<u64>> {
        let mut waiting = changes.iter().peekable();
        let apply =
            |net: &mut Simulation<'_>,
             waiting: &mut std::iter::Peekable<std::slice::Iter<'_, Change>>| {
                while let Some(change) = waiting.next_if(|change| change.ms <= net.now().ms) {
                    net.set(change.outer, change.on);
                }
            };
        apply(&mut net, &mut waiting);
        let mut rows = Rows::new(&mut sink, &net)?;
        let mut dump = match &mut dumped {
            Some(sink) => Some(Dump::new(sink, &net)?),
            None => None,
        };
        let mut dead = None;
        while net.now().ms < end {
            apply(&mut net, &mut waiting);
            let begun = net.now().ms;
            let happened = net.step(|firable| match &mut random {
                Some(random) => {
                    usize::try_from(random.next_u64() % firable.len() as u64).unwrap_or(0)
                }
                None => 0,
            });
            rows.row(&net, begun, &happened)?;
            if let Some(dump) = &mut dump {
                dump.row(&net, begun, &happened)?;
            }
            if !happened.is_nothing() {
                continue;
            }
            if net.is_dead() {
                dead = Some(begun);
                break;
            }
            // Nothing happens until a gate changes or a timer runs out.
            let next = [waiting.peek().map(|change| change.ms), net.next_due()];
            net.wait_until(next.into_iter().flatten().min().unwrap_or(end).min(end));
        }
        rows.finish()?;
        if let Some(dump) = dump {
            dump.finish(net.now().ms)?;
        }
        Ok(dead)
    };
    let done = follow();
    let dead = *done.as_ref().unwrap_or(&None);
    sink.finish(done.map(drop))?;
    if let Some(sink) = dumped {
        sink.finish(Ok(()))?;
    }
    match dead {
        None => Ok(Outcome::Done),
        Some(ms) => {
            say(&format!(
                "deadlock after {ms} ms: no transition can fire any more; {}\n",
                marks(&net)
            ));
            Ok(Outcome::Refuted)
        }
    }
}

/// The marked places, as text.
fn marks(net: &Simulation<'_>) -> String {
    let marked = |at: &usize| net.rules().is_marked(&net.now().state, *at);
    let all = (0..net.diagram().places.len()).filter(marked);
    let names: Vec<String> = all.map(|at| net.diagram().place_name(at)).collect();
    if names.is_empty() {
        "no place is marked".to_owned()
    } else {
        format!("marked: {}", names.join(" "))
    }
}

/// A simulation on the terminal.
struct Screen<'a> {
    pages: Pages<'a>,
    step: Duration,
    runs: bool,
    /// Which of the transitions that can fire is selected.
    chosen: usize,
    /// Whether the bell was rung for the current deadlock.
    told: bool,
}

/// The keys of outer gates.
fn gate_keys() -> impl Iterator<Item = char> {
    ('1'..='9').chain('A'..='Z')
}

impl<'a> Screen<'a> {
    fn new(diagram: &'a Diagram, step_ms: u64) -> Screen<'a> {
        let step = Duration::from_millis(step_ms);
        Screen { pages: Pages::new(diagram), step, runs: false, chosen: 0, told: false }
    }

    fn run(
        &mut self,
        net: &mut Simulation<'_>,
        terminal: &mut DefaultTerminal,
    ) -> std::io::Result<()> {
        // The time between two pictures. Several shorter steps are made at once.
        const FRAME: Duration = Duration::from_millis(40);
        loop {
            let (head, words) = self.words(net);
            let view = View::simulated(net);
            terminal.draw(|frame| {
                let area = frame.area();
                self.pages.draw(frame.buffer_mut(), area, &view, &head, &words);
            })?;
            let dead = net.is_dead();
            if dead && !self.told {
                std::io::stdout().write_all(b"\x07")?;
                std::io::stdout().flush()?;
                self.runs = false;
            }
            self.told = dead;
            let patience = if self.runs { FRAME } else { Duration::from_secs(3600) };
            let until = Instant::now() + FRAME;
            match self.pages.pressed(patience)? {
                Some(Pressed::Quit) => return Ok(()),
                Some(pressed) => self.pressed(net, pressed),
                None => {}
            }
            if self.runs {
                std::thread::sleep(until.saturating_duration_since(Instant::now()));
                let steps = (FRAME.as_millis() / self.step.as_millis().max(1)).max(1);
                for _ in 0..steps {
                    self.one_step(net);
                }
            }
        }
    }

    fn one_step(&mut self, net: &mut Simulation<'_>) {
        net.keep();
        let chosen = self.chosen;
        net.step(|firable| chosen.min(firable.len() - 1));
        self.chosen = 0;
    }

    /// Applies a key to the net.
    fn pressed(&mut self, net: &mut Simulation<'_>, pressed: Pressed) {
        let count = net.firable().len();
        match pressed {
            Pressed::Key(' ' | 's' | '\n') => self.one_step(net),
            Pressed::Key('r') => self.runs = !self.runs,
            Pressed::Key('b') | Pressed::Back => {
                self.runs = false;
                net.back();
            }
            Pressed::Key('>') if count > 0 => self.chosen = (self.chosen + 1) % count,
            Pressed::Key('<') if count > 0 => self.chosen = (self.chosen + count - 1) % count,
            Pressed::Key('t') => {
                if let Some(due) = net.next_due() {
                    net.keep();
                    net.wait_until(due);
                    net.step(|_| 0);
                }
            }
            Pressed::Key(key) => {
                let outer = gate_keys().position(|one| one == key);
                if let Some(outer) = outer.filter(|&outer| outer < net.now().outers.len()) {
                    net.keep();
                    let on = net.now().outers[outer];
                    net.set(outer, !on);
                }
            }
            Pressed::Quit | Pressed::Other => {}
        }
    }

    /// The texts above and below the picture.
    fn words(&self, net: &Simulation<'_>) -> (String, Vec<String>) {
        let diagram = net.diagram();
        let ms = net.now().ms;
        let state = if self.runs { "runs" } else { "stands" };
        let head = format!("{}.{:03} s, {state}", ms / 1000, ms % 1000);
        let firable = net.firable();
        let firable: Vec<String> = firable
            .iter()
            .enumerate()
            .map(|(number, &at)| {
                let name = diagram.transition_name(at);
                if number == self.chosen.min(firable.len() - 1) {
                    format!("[{name}]")
                } else {
                    name
                }
            })
            .collect();
        let gates: Vec<String> = gate_keys()
            .zip(&diagram.outers)
            .zip(&net.now().outers)
            .map(|((key, outer), on)| format!("{key} {}={}", outer.head.name, u8::from(*on)))
            .collect();
        let can = match (net.is_dead(), firable.is_empty()) {
            (true, _) => format!("DEADLOCK: no transition can fire any more; {}", marks(net)),
            (false, true) => "none can fire now".to_owned(),
            (false, false) => format!("can fire: {}", firable.join(" ")),
        };
        let keys = "space steps, <> choose, r runs, t to the next timer, b back, q ends";
        (head, vec![can, format!("gates: {}", gates.join("  ")), keys.to_owned()])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ratatui::Terminal;
    use ratatui::backend::TestBackend;
    use scanbound::snet::text::read;

    /// The screen as text.
    fn shown(screen: &Screen<'_>, net: &Simulation<'_>) -> String {
        let mut terminal = Terminal::new(TestBackend::new(76, 34)).expect("a terminal");
        let (head, words) = screen.words(net);
        let view = View::simulated(net);
        terminal
            .draw(|frame| {
                let area = frame.area();
                screen.pages.draw(frame.buffer_mut(), area, &view, &head, &words);
            })
            .expect("drawn");
        terminal.backend().to_string()
    }

    const NET: &str = "outer GO\nouter 停止\nbox A marked\ntimer W 0.5s\nbox B\nbox C\n\
                       transition T : A -> W if GO not 停止\ntransition U : W -> B\ntransition V : A -> C if GO\n";

    #[test]
    fn a_net_is_stepped_with_keys_and_gone_back() {
        let diagram = read("a.snet", NET).expect("a net");
        let mut net = Simulation::new(&diagram, Rule::Net, true, 10);
        let mut screen = Screen::new(&diagram, 10);
        let first = shown(&screen, &net);
        assert!(first.contains("none can fire now") && first.contains("│ ● │ A"), "{first}");
        let press = |screen: &mut Screen<'_>, net: &mut Simulation<'_>, keys: &str| {
            for key in keys.chars() {
                screen.pressed(net, Pressed::Key(key));
            }
        };
        press(&mut screen, &mut net, "1");
        let lit = shown(&screen, &net);
        assert!(lit.contains("can fire: [T] V") && lit.contains("1 GO=1"), "{lit}");
        press(&mut screen, &mut net, ">");
        assert!(shown(&screen, &net).contains("can fire: T [V]"));
        press(&mut screen, &mut net, "2");
        assert!(shown(&screen, &net).contains("can fire: [V]"));
        press(&mut screen, &mut net, "2 ");
        assert_eq!(net.now().fired, [2]);
        assert!(shown(&screen, &net).contains("│ ● │ C"));
        // Step back through the firing and the gates to the beginning.
        for _ in 0..4 {
            screen.pressed(&mut net, Pressed::Back);
        }
        assert_eq!(shown(&screen, &net), first);
    }

    #[test]
    fn a_timer_passes_and_a_deadlock_is_told() {
        let diagram = read("a.snet", NET).expect("a net");
        let mut net = Simulation::new(&diagram, Rule::Net, true, 10);
        let mut screen = Screen::new(&diagram, 10);
        for key in ['1', ' '] {
            screen.pressed(&mut net, Pressed::Key(key));
        }
        assert!(shown(&screen, &net).contains("0.0/0.5 s"));
        for _ in 0..25 {
            screen.pressed(&mut net, Pressed::Key(' '));
        }
        assert!(shown(&screen, &net).contains("0.2/0.5 s"), "{}", shown(&screen, &net));
        screen.pressed(&mut net, Pressed::Key('t'));
        let end = shown(&screen, &net);
        assert!(end.contains("DEADLOCK") && end.contains("│ ● │ B"), "{end}");
        screen.pressed(&mut net, Pressed::Key('b'));
        assert!(!shown(&screen, &net).contains("DEADLOCK"));
    }
}
