//! `scanbound calibrate`: measures the times of a CPU's instructions.

use super::live::{PlcOptions, fault};
use super::options::{ProjectOptions, stop_on_interrupt};
use super::output::{Target, say, tell};
use super::{Failure, Outcome, tables, values};
use anyhow::{Context, anyhow};
use clap::{ArgGroup, Args, Subcommand};
use scanbound::audit::read;
use scanbound::base::time::Picos;
use scanbound::calibrate::fit::{Check, Fit, fit};
use scanbound::calibrate::language::{RESULTS, STEP};
use scanbound::calibrate::table::Origin;
use scanbound::calibrate::{Language, Plan, Settings, Spare, Unmeasured, Written, result, table};
use scanbound::front::FRONTS;
use scanbound::front::input::read_small;
use scanbound::timing::table::Table;
use std::path::{Path, PathBuf};
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

pub const ABOUT: &str = "\
Measures the times of a CPU's instructions: writes a program that measures them, reads its results, and makes a timing table from them. docs/measuring.md describes all steps.";

/// The arguments of `calibrate`.
#[derive(Debug, Args)]
pub struct Arguments {
    #[command(subcommand)]
    action: Action,
}

#[derive(Debug, Subcommand)]
enum Action {
    /// Write the program for a CPU: for the instructions that programs use, or for those in the CPU's table
    Write(WriteArguments),
    /// Read the results from a CPU that runs the program; nothing is written to the CPU
    Read(ReadArguments),
    /// Make a timing table from the results
    Fit(FitArguments),
}

const WRITE_EXAMPLES: &str = "\
Examples:
  scanbound calibrate write --cpu Q26UDV PLC/ -o calibration
  scanbound calibrate write --cpu CJ2M -o calibration
  scanbound calibrate write --cpu Q26UDV PLC/ --table my-cpu.csv -o again    what is still assumed";

#[derive(Debug, Args)]
#[command(after_help = WRITE_EXAMPLES)]
struct WriteArguments {
    /// A new directory for the programs and the plan
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
    /// The number of scans over which each step is measured
    #[arg(long, value_name = "N", default_value_t = 20, value_parser = clap::value_parser!(u32).range(2..10_000))]
    scans: u32,
    /// The longest scan of the program by the table [default: a third of the CPU's watchdog time, at most 100ms]
    #[arg(long, value_name = "DURATION", value_parser = values::duration)]
    scan_time: Option<Picos>,
    /// The most steps of program memory for each part
    #[arg(long, value_name = "N", default_value_t = 15_000, value_parser = clap::value_parser!(u32).range(1000..))]
    memory: u32,
    /// Unused devices that the program may write in addition to its own: an output (Y1F0), a latched relay (L100), 64
    /// words of a module's buffer memory (U4\G100; TO writes their current values back)
    #[arg(long, value_name = "DEVICE", value_delimiter = ',')]
    spare: Vec<String>,
    #[command(flatten)]
    project: ProjectOptions,
}

#[derive(Debug, Args)]
#[command(group = ArgGroup::new("plc").required(true))]
struct ReadArguments {
    /// The directory from `calibrate write`
    #[arg(value_name = "DIR")]
    directory: PathBuf,
    /// The part that is running
    #[arg(long, value_name = "N", default_value_t = 1)]
    part: usize,
    /// A file for the results (CSV)
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    /// How long to wait until everything is measured [default: three times the planned time, plus a minute]
    #[arg(long, value_name = "DURATION", value_parser = values::span)]
    wait: Option<Duration>,
    #[command(flatten)]
    plc: PlcOptions,
}

#[derive(Debug, Args)]
struct FitArguments {
    /// The directory from `calibrate write`
    #[arg(value_name = "DIR")]
    directory: PathBuf,
    /// The results, one file for each part, in their order
    #[arg(value_name = "RESULT", required = true)]
    results: Vec<PathBuf>,
    /// A file for the timing table
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    /// The CPU's serial number, for the table
    #[arg(long, value_name = "TEXT", default_value = "")]
    serial: String,
    /// The I/O modules are unchanged: the refresh of their points is part of the measured scan, and is not added again
    #[arg(long)]
    fitted: bool,
    /// The day of the measurement [default: today]
    #[arg(long, value_name = "YYYY-MM-DD")]
    date: Option<String>,
}

/// Does what is asked.
pub fn run(arguments: &Arguments) -> Result<Outcome, Failure> {
    match &arguments.action {
        Action::Write(arguments) => write(arguments),
        Action::Read(arguments) => read_results(arguments),
        Action::Fit(arguments) => make_table(arguments),
    }
}

/// The file name of a plan.
const PLAN: &str = "plan.json";

/// The table of the CPU that is calibrated, and the CPU's name.
fn table_of(project: &ProjectOptions) -> Result<(Table, String), Failure> {
    let (named, cpu) = project.table_and_cpu();
    let cpu = cpu.ok_or_else(|| anyhow!("name the CPU with --cpu"))?;
    let own = Table::for_cpu(cpu).ok_or_else(|| anyhow!(Table::advice(cpu)))?;
    let parsed = tables::find("--table ", named.unwrap_or(own))?;
    tell(&parsed.warnings);
    Ok((parsed.table, cpu.to_owned()))
}

fn write(arguments: &WriteArguments) -> Result<Outcome, Failure> {
    let (table, cpu) = table_of(&arguments.project)?;
    let family = table.family.clone().unwrap_or_default();
    let Some(language) = Language::of(&family) else {
        return Err(anyhow!("calibration programs are written for MELSEC-Q, L, iQ-R, FX5 and F and for OMRON CS, CJ and CP, not for family {family}: its programs have no loops, which are needed to repeat a short instruction until its time shows in the scan-time register").into());
    };
    let third = table.watchdog().map_or(u64::MAX, |watchdog| watchdog.0 / 3);
    let usual = Picos(third.min(100_000_000_000));
    let settings = Settings {
        scans: arguments.scans,
        scan_time: arguments.scan_time.unwrap_or(usual),
        memory: arguments.memory,
    };
    let program = match arguments.project.is_open() {
        true => None,
        false => Some(arguments.project.with_request(|request| Ok(read(request)?))?),
    };
    let spare = Spare::new(&arguments.spare).map_err(|device| {
        anyhow!("--spare: {device} is not a device; write it as Y1F0, L100 or U4\\G100")
    })?;
    let program = program.as_ref();
    let written = scanbound::calibrate::write(program, &table, &cpu, settings, &spare, FRONTS);
    let Some(Written { plan, files, lists }) = written else {
        return Err(anyhow!("there is nothing to measure: all times of these programs are measured, published or stated, or cannot be measured").into());
    };
    let directory = &arguments.output;
    let cannot = || format!("{} cannot be written", directory.display());
    std::fs::create_dir_all(directory).with_context(cannot)?;
    for ((part, bytes), list) in plan.parts.iter().zip(files).zip(lists) {
        let file = directory.join(&part.file);
        std::fs::write(&file, bytes).with_context(cannot)?;
        std::fs::write(file.with_extension("il"), list).with_context(cannot)?;
    }
    let json = serde_json::to_string_pretty(&plan).context("the plan cannot be written")?;
    std::fs::write(directory.join(PLAN), json + "\n").with_context(cannot)?;
    Target::new(None)?.write(&told(&plan, language, directory, &table, &spare))?;
    Ok(Outcome::Done)
}

/// What the calibration needs and does, shown before it is loaded into the CPU.
fn told(plan: &Plan, language: Language, directory: &Path, table: &Table, spare: &Spare) -> String {
    let mut text = format!("calibration of {} in {}\n", plan.cpu, directory.display());
    for part in &plan.parts {
        let last = RESULTS + 2 * part.steps - 1;
        text += &format!(
            "  {}: about {} steps of program memory, {} blocks; {} s by the table, scans up to {} ms\n    results in D{RESULTS} to D{last} ({} lines), complete when D{STEP} is {}; writes {}\n",
            part.file,
            part.memory,
            part.steps,
            part.takes_ms.div_ceil(1000),
            part.longest_us.div_ceil(1000),
            (2 * part.steps).div_ceil(10),
            part.steps,
            language.writes(part.steps),
        );
    }
    if !spare.devices().is_empty() {
        text += &format!(
            "  instructions that write {} are measured on these devices, too\n",
            spare.devices().join(", ")
        );
    }
    let mut rows: Vec<&str> = Vec::new();
    for measure in plan.parts.iter().flat_map(|part| &part.measures) {
        if !rows.contains(&&*measure.row) {
            rows.push(&measure.row);
        }
    }
    text += &format!("  measures {} rows: {}\n", rows.len(), rows.join(" "));
    if let Some(watchdog) = table.watchdog() {
        text += &format!("  the CPU's watchdog must not be below its default of {watchdog}\n");
    }
    text + &left(&plan.left)
}

/// The list of times that are not measured.
fn left(left: &[Unmeasured]) -> String {
    let mut text = String::new();
    if !left.is_empty() {
        text += "  not measured, and so still assumed:\n";
    }
    for one in left {
        let share = match one.share {
            0 => String::new(),
            share => {
                format!(" ({}.{} % of the programs' instructions' time)", share / 10, share % 10)
            }
        };
        text += &format!("    {}{share}: {}\n", one.row, one.why);
    }
    text
}

/// The plan of a directory.
fn plan_of(directory: &Path) -> Result<Plan, Failure> {
    let file = directory.join(PLAN);
    let name = file.display();
    let text = read_small(&file).with_context(|| format!("{name} cannot be read"))?;
    let plan: Plan = serde_json::from_slice(&text)
        .with_context(|| format!("{name} is not a plan from scanbound calibrate write"))?;
    match plan.schema == scanbound::calibrate::plan::SCHEMA {
        true => Ok(plan),
        false => {
            Err(anyhow!("{name} is from another version of scanbound: write the calibration again")
                .into())
        }
    }
}

fn read_results(arguments: &ReadArguments) -> Result<Outcome, Failure> {
    let plan = plan_of(&arguments.directory)?;
    let part = arguments.part.checked_sub(1).and_then(|part| plan.parts.get(part));
    let part = part.ok_or_else(|| anyhow!("the plan has parts 1 to {}", plan.parts.len()))?;
    let target = Target::new(Some(&arguments.output))?;
    let (mut plc, _) = arguments.plc.connect()?;
    let stop = stop_on_interrupt()?;
    let usual = Duration::from_millis(3 * part.takes_ms) + Duration::from_secs(60);
    let (wait, begun) = (arguments.wait.unwrap_or(usual), Instant::now());
    let name = if plc.device("D0").is_ok() { "D" } else { "DM" };
    let counted = plc.device(&format!("{name}{STEP}")).map_err(fault)?;
    loop {
        let step = u32::from(plc.value(counted).map_err(fault)?);
        if step == part.steps {
            break;
        }
        if step > part.steps {
            return Err(anyhow!(
                "D{STEP} is {step}, but {} has {} steps: another program is running",
                part.file,
                part.steps
            )
            .into());
        }
        if begun.elapsed() >= wait || stop.load(Ordering::Relaxed) {
            return Err(anyhow!(
                "the CPU is at step {step} of {}: wait, and read again",
                part.steps
            )
            .into());
        }
        std::thread::sleep(Duration::from_millis(200).min(wait));
    }
    let first = plc.device(&format!("{name}{RESULTS}")).map_err(fault)?;
    let words = plc.many(first, 2 * part.steps).map_err(fault)?;
    target.write(&result::write(RESULTS, &words))?;
    Ok(Outcome::Done)
}

fn make_table(arguments: &FitArguments) -> Result<Outcome, Failure> {
    let plan = plan_of(&arguments.directory)?;
    let mut results = Vec::new();
    for file in &arguments.results {
        let name = file.display().to_string();
        let bytes = read_small(file).with_context(|| format!("{name} cannot be read"))?;
        results.push(result::read(&name, &bytes)?);
    }
    let found = fit(&plan, &results).map_err(|unfit| anyhow!(unfit.to_string()))?;
    let date = arguments.date.clone().unwrap_or_else(today);
    let origin = Origin { date, serial: arguments.serial.clone() };
    Target::new(Some(&arguments.output))?.write(&table::write(
        &plan,
        &found,
        &origin,
        arguments.fitted,
    ))?;
    Target::new(None)?.write(&summary(&plan, &found))?;
    for check in found.checks.iter().filter(|check| !check.is_good()) {
        say(&doubt(check));
    }
    Ok(Outcome::Done)
}

/// A summary of the results, one line for each row.
fn summary(plan: &Plan, found: &Fit) -> String {
    let mut text = format!("{} rows measured on {}\n", found.rows.len(), plan.cpu);
    if let Some(empty) = found.empty {
        text += &format!(
            "  a scan that does nothing: {} to {} us\n",
            empty.low.us_text(),
            empty.high.us_text()
        );
    }
    for row in &found.rows {
        let units = match row.per_unit {
            Some(unit) => {
                format!(", {} to {} us per unit", unit.low.us_text(), unit.high.us_text())
            }
            None => String::new(),
        };
        text += &format!(
            "  {}: {} to {} us on{units}, {} to {} us off\n",
            row.row,
            row.on.low.us_text(),
            row.on.high.us_text(),
            row.off.low.us_text(),
            row.off.high.us_text()
        );
    }
    for check in &found.checks {
        text += &format!(
            "{}: half of the steps vary by {} ms or less",
            check.file,
            tenths(check.scatter)
        );
        if let Some([measured, said]) = check.sum {
            text += &format!(
                "; a block of many different instructions takes {} to {} us, and the single times above add up to {} to {} us",
                measured.low.us_text(),
                measured.high.us_text(),
                said.low.us_text(),
                said.high.us_text()
            );
        }
        text += "\n";
    }
    text + &left(&plan.left)
}

fn tenths(tenths: u64) -> String {
    format!("{}.{}", tenths / 10, tenths % 10)
}

/// The warning that a run may have been disturbed.
fn doubt(check: &Check) -> String {
    let mut why = Vec::new();
    if !check.steady {
        why.push("the same block took different times at the beginning and at the end".to_owned());
    }
    if !check.outliers.is_empty() {
        why.push(format!("readings differ too much at {}", check.outliers.join(", ")));
    }
    if !check.sum_agrees() {
        why.push(
            "the time of a block of many instructions differs from the sum of the single times"
                .to_owned(),
        );
    }
    format!(
        "warning: the measurement of {} may have been disturbed: {}. Measure again without communication, monitoring and interrupts; the table contains the upper ends of what was measured\n",
        check.file,
        why.join("; ")
    )
}

/// Today's date.
fn today() -> String {
    let seconds = SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |since| since.as_secs());
    date_of(seconds / 86_400)
}

/// The date that is this many days after 1 January 1970.
fn date_of(mut days: u64) -> String {
    let leap = |year: u64| {
        year.is_multiple_of(4) && (!year.is_multiple_of(100) || year.is_multiple_of(400))
    };
    let mut year = 1970;
    while days >= 365 + u64::from(leap(year)) {
        days -= 365 + u64::from(leap(year));
        year += 1;
    }
    let mut month = 0;
    for length in [31, 28 + u64::from(leap(year)), 31, 30, 31, 30, 31, 31, 30, 31, 30, 31] {
        month += 1;
        if days < length {
            break;
        }
        days -= length;
    }
    format!("{year}-{month:02}-{:02}", days + 1)
}

#[cfg(test)]
mod tests {
    use super::date_of;

    #[test]
    fn days_are_dates() {
        assert_eq!(date_of(0), "1970-01-01");
        assert_eq!(date_of(59), "1970-03-01");
        assert_eq!(date_of(11_016), "2000-02-29");
        assert_eq!(date_of(20_780), "2026-11-23");
    }
}
