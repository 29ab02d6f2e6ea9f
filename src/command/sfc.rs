//! `scanbound sfc`: sequential function charts: what runs together in them, and their explicit form.

use super::output::{Target, apart};
use super::source_text::SourceText;
use super::values::format_or_suffix;
use super::{Failure, Outcome};
use anyhow::anyhow;
use clap::{Args, ValueEnum};
use scanbound::base::code::Code;
use scanbound::base::diagnostic::Diagnostic;
use scanbound::base::facts::Facts;
use scanbound::front::iec::charts::refused;
use scanbound::front::input::{Ignore, gather};
use scanbound::iec::chart::Chart;
use scanbound::iec::chart::coactive::{BUDGET, Rule, analyse_by};
use scanbound::iec::chart::explicit::{Rewriting, explicit_beside};
use scanbound::iec::chart::names::Taken;
use scanbound::iec::chart::plain::plain_beside;
use scanbound::iec::chart::structure::structure;
use scanbound::iec::{self, Body, Pou, Project, same, xml};
use scanbound::report::sfc::{Elsewhere, Study, dot, json, svg, text};
use std::path::PathBuf;

pub const ABOUT: &str = "\
Analyse sequential function charts: loops, selections, parallels, and what runs at the same time

Reads PLCopen XML and charts in text. For each chart: its structure as a tree; which actions can run together with which \
steps and other actions, by explicit parallels and by actions that S, SD, SL and DS store, with the steps that store and \
reset them and a way that leads there; steps entered twice, steps never active, dead ends.

With --explicit, charts are rewritten so that stored actions become explicit parallel sequences, which behave the same in \
every scan; docs/sfc.md says how. Macro steps are written expanded.";

const EXAMPLES: &str = "\
Examples:
  scanbound sfc line.xml                             all its charts
  scanbound sfc line.xml --chart Crane               one
  scanbound sfc line.xml --format svg -o line.svg    as a picture
  scanbound sfc line.xml --explicit -o explicit.xml  with explicit parallels, as PLCopen XML

Exit codes: 0 done, 1 a fault was found in a chart, 2 bad usage or input, 70 internal error";

/// The arguments of `sfc`.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct Arguments {
    /// Files of one project: PLCopen XML, or programs in text
    #[arg(required = true, value_name = "FILE")]
    files: Vec<PathBuf>,
    /// Only the chart of this unit, action or method, as the report names it
    #[arg(long, value_name = "NAME")]
    chart: Option<String>,
    /// Facts about the controller; only [sfc] selection = "all" is used here
    #[arg(long, value_name = "FILE")]
    facts: Option<PathBuf>,
    /// The output format
    #[arg(long, value_enum, value_name = "FORMAT", conflicts_with = "explicit")]
    format: Option<Format>,
    /// Rewrite stored actions as explicit parallels, and write PLCopen XML
    #[arg(long)]
    explicit: bool,
    #[command(flatten)]
    source_text: SourceText,
    /// The output file; its suffix names the format
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
}

/// A format.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Format {
    #[value(alias = "txt")]
    Text,
    #[value(alias = "gv")]
    Dot,
    Svg,
    Json,
}

/// Reads the charts, and shows or rewrites them.
pub fn run(arguments: &Arguments) -> Result<Outcome, Failure> {
    let read: Vec<&std::path::Path> = arguments.files.iter().map(PathBuf::as_path).collect();
    apart(&read, &[("--output", arguments.output.as_deref())])?;
    let target = Target::new(arguments.output.as_deref())?;
    let mut gathered = gather(&arguments.files, &Ignore::default())?;
    arguments.source_text.recode(&mut gathered.inputs);
    let mut project = Project::default();
    let mut texts = Vec::new();
    let mut faults = Vec::new();
    for input in &gathered.inputs {
        let text = scanbound::front::decoded(input, &[]).map_err(|fault| vec![fault])?.into_owned();
        match iec::read_as(&input.name, &text, arguments.source_text.reading().comments) {
            Ok(more) => project.join(more),
            Err(more) => faults.extend(more.into_iter().map(|fault| fault.in_file(&input.name))),
        }
        texts.push(text);
    }
    if !faults.is_empty() {
        return Err(faults.into());
    }
    let facts = super::options::facts(arguments.facts.as_deref())?;
    let is_wanted = |name: &str| arguments.chart.as_deref().is_none_or(|own| same(own, name));
    let charts = project.charts();
    if !charts.iter().any(|(name, ..)| is_wanted(name)) {
        let names: Vec<&str> = charts.iter().map(|(name, ..)| name.as_str()).collect();
        let has = if names.is_empty() { "no chart".to_owned() } else { names.join(", ") };
        return Err(anyhow!("there is no such chart: the files have {has}").into());
    }
    let competes = charts.iter().find(|(name, _, chart)| is_wanted(name) && chart.competes());
    if let (true, true, Some((name, ..))) =
        (arguments.explicit, facts.all_clear == Some(true), competes)
    {
        return Err(anyhow!(
            "{name}: with [sfc] selection = \"all\", several true transitions after a step fire together if they have no priorities, and the rewritten chart would behave differently; give them priorities"
        )
        .into());
    }
    if arguments.explicit {
        return rewrite(arguments, &mut project, &texts, target);
    }
    show(arguments, &project, &facts, target)
}

fn show(
    arguments: &Arguments,
    project: &Project,
    facts: &Facts,
    target: Target,
) -> Result<Outcome, Failure> {
    let format = format_or_suffix(arguments.format, arguments.output.as_deref())?;
    let wanted = |name: &str| arguments.chart.as_deref().is_none_or(|own| same(own, name));
    let warnings = refused(project, facts);
    let rule = match facts.all_clear {
        Some(true) => Rule::All,
        Some(false) | None => Rule::One,
    };
    let charts = project.charts();
    let others = |name: &str| -> Vec<(String, &Chart)> {
        let unit = |name: &str| name.split('.').next().unwrap_or_default().to_ascii_lowercase();
        let beside = charts.iter().filter(|(other, ..)| other != name && unit(other) == unit(name));
        beside.map(|(other, _, chart)| (other.clone(), *chart)).collect()
    };
    let studies: Vec<Study<'_>> = charts
        .iter()
        .filter(|(name, ..)| wanted(name))
        .map(|(name, pou, chart)| Study {
            name: name.clone(),
            file: &project.files[pou.file],
            chart,
            structure: structure(chart),
            analysis: analyse_by(chart, BUDGET, rule),
            rule,
            elsewhere: Elsewhere::of(chart, &others(name)),
        })
        .collect();
    if !warnings.is_empty() {
        super::output::tell(&warnings);
    }
    match format {
        Format::Text => target.write(&text::render(&studies))?,
        Format::Dot => target.write(&dot::render(&studies))?,
        Format::Svg => target.write(&svg::render(&studies))?,
        Format::Json => target.fill(|out| json::write(&studies, out))?,
    }
    let is_sound = studies.iter().all(Study::is_sound);
    Ok(if is_sound { Outcome::Done } else { Outcome::Refuted })
}

/// The charts of a unit, for rewriting.
fn bodies(pou: &mut Pou) -> Vec<(String, &mut Chart)> {
    let name = pou.name.clone();
    let mut found = Vec::new();
    if let Body::Chart(chart) = &mut pou.body {
        found.push((name.clone(), chart.as_mut()));
    }
    for action in &mut pou.actions {
        if let Body::Chart(chart) = &mut action.body {
            found.push((format!("{name}.{}", action.name), chart.as_mut()));
        }
    }
    for method in &mut pou.methods {
        let inner = bodies(method);
        found.extend(inner.into_iter().map(|(own, chart)| (format!("{name}.{own}"), chart)));
    }
    found
}

/// Something in a unit, besides its charts, that reads steps of macro steps. Without the macro steps, these have other
/// names.
fn asking(pou: &Pou, without: &Pou) -> Option<String> {
    let is_code = |body: &Body| matches!(body, Body::Code(..) | Body::Drawn(..));
    let actions = pou.actions.iter().zip(&without.actions).map(|pair| ("action", pair));
    let ways = pou.transitions.iter().zip(&without.transitions).map(|pair| ("transition", pair));
    let mut all = actions.chain(ways);
    let changed =
        all.find(|(_, (before, after))| is_code(&before.body) && before.body != after.body);
    let methods = || pou.methods.iter().zip(&without.methods);
    let of_methods = || methods().find_map(|(before, after)| asking(before, after));
    let own = (is_code(&pou.body) && pou.body != without.body).then(|| "its body".to_owned());
    own.or_else(|| changed.map(|(what, (one, _))| format!("{what} {}", one.name)))
        .or_else(of_methods)
}

fn rewrite(
    arguments: &Arguments,
    project: &mut Project,
    texts: &[String],
    target: Target,
) -> Result<Outcome, Failure> {
    let mut told: Vec<(usize, String, Rewriting)> = Vec::new();
    let mut changed: Vec<(usize, Chart)> = Vec::new();
    let is_one_xml = project.files.len() == 1 && xml::begins(&texts[0]);
    let names = |pou: &Pou| match pou.charts().is_empty() {
        true => Taken::default(),
        false => Taken::around(project, pou),
    };
    let taken: Vec<Taken> = project.pous.iter().map(names).collect();
    for (pou, mut taken) in project.pous.iter_mut().zip(taken) {
        let file = pou.file;
        let without =
            plain_beside(pou, &mut taken).map_err(|why| anyhow!("{}: {why}", pou.name))?;
        let has_macros = without.is_some();
        if let Some(without) = without {
            if is_one_xml && let Some(other) = asking(pou, &without) {
                let unit = &pou.name;
                return Err(anyhow!(
                    "{unit}: {other} reads steps inside macro steps, which the rewriting replaces: read a variable that the chart writes instead"
                )
                .into());
            }
            *pou = without;
        }
        for (name, chart) in bodies(pou) {
            if arguments.chart.as_deref().is_some_and(|own| !same(own, &name)) {
                continue;
            }
            let (next, rewritings) = explicit_beside(chart, &mut taken, BUDGET);
            if has_macros || rewritings.iter().any(|one| one.branch.is_ok()) {
                *chart = next;
                changed.push((file, chart.clone()));
            }
            told.extend(rewritings.into_iter().map(|one| (file, name.clone(), one)));
        }
    }
    let written = if is_one_xml {
        let charts: Vec<&Chart> = changed.iter().map(|(_, chart)| chart).collect();
        xml::write::replaced(&texts[0], &charts)
    } else {
        xml::write::project(project)
    };
    let written = written.map_err(|why| anyhow!("the charts cannot be written: {why}"))?;
    let refused = told.iter().filter_map(|(file, name, one)| {
        let why = one.branch.as_ref().err()?;
        let message = format!(
            "{name}: action {} stays stored by {} at step {}: {why}",
            one.action,
            one.qualifier.name(),
            one.step
        );
        let help =
            "the rest is rewritten; this action runs beside the steps that `scanbound sfc` lists";
        let file = &project.files[*file];
        Some(Diagnostic::line(Code::NotRewritten, file, one.line, "", message, help).warning())
    });
    let warnings: Vec<Diagnostic> = refused.collect();
    if !warnings.is_empty() {
        super::output::tell(&warnings);
    }
    for (_, name, one) in &told {
        if let Ok(steps) = &one.branch {
            let (action, qualifier) = (&one.action, one.qualifier.name());
            super::output::say(&format!(
                "{name}: {action}, stored by {qualifier}, is now the branch {}\n",
                steps.join(", ")
            ));
        }
    }
    target.write(&written)?;
    Ok(Outcome::Done)
}
