//! Replaces macro steps for tools that do not know them: their steps get plain names, `M1_S3` for `M1.S3`, and
//! references to them are changed.

use super::expansion::{bodies, named};
use super::names::Taken;
use super::{Chart, Step, Target};
use crate::ast::{Expr, Path, paths_of};
use crate::{Body, Pou, same, show};

/// The unit with its macro steps replaced; `None` if it has none.
///
/// # Errors
/// The reason why a reference cannot be expressed without macro steps.
pub fn plain(pou: &Pou) -> Result<Option<Pou>, String> {
    plain_beside(pou, &mut Taken::of(pou))
}

/// Like [`plain`], but new names avoid those in `taken`, to which they are added.
///
/// # Errors
/// As with [`plain`].
pub fn plain_beside(pou: &Pou, taken: &mut Taken) -> Result<Option<Pou>, String> {
    let names: Vec<Names> =
        pou.charts().into_iter().map(|(_, chart)| Names::of(chart, taken)).collect();
    if names.iter().all(|one| one.macros.is_empty()) {
        return Ok(None);
    }
    let mut pou = pou.clone();
    let mut wrong = None;
    let mut asks = |expr: &mut Expr| {
        for one in &names {
            if let Err(why) = one.replace(expr) {
                wrong.get_or_insert(why);
            }
        }
    };
    bodies(&mut pou, &mut |body| {
        body.change(&mut asks, &mut |_| {});
        if let Body::Chart(chart) = body
            && let Some(own) = names.iter().find(|one| one.line == (chart.line, chart.span))
        {
            own.rename(chart);
        }
    });
    wrong.map_or(Ok(Some(pou)), Err)
}

/// The new names of a chart's steps.
struct Names {
    line: (u32, Option<(usize, usize)>),
    /// The full name and the new name of each step.
    steps: Vec<(String, String)>,
    /// The macro steps, each with the new names of its steps.
    macros: Vec<(String, Vec<String>)>,
}

impl Names {
    fn of(chart: &Chart, taken: &mut Taken) -> Names {
        let now = |step: &Step| match step.name.contains('.') {
            true => taken.free(&step.name.replace('.', "_")),
            false => step.name.clone(),
        };
        let now: Vec<String> = chart.steps.iter().map(now).collect();
        let macros = chart.macros.iter().map(|one| {
            let own = one.steps.iter().map(|&step| now[step].clone()).collect();
            (one.name.clone(), own)
        });
        Names {
            line: (chart.line, chart.span),
            macros: macros.collect(),
            steps: chart.steps.iter().map(|step| step.name.clone()).zip(now).collect(),
        }
    }

    /// Changes step flags and times to the new names. A macro step's flag becomes the OR of its steps' flags; a fault
    /// for its time.
    fn replace(&self, expr: &mut Expr) -> Result<(), String> {
        let mut wrong = None;
        self.flags(expr);
        paths_of(expr, &mut |path| {
            let Some((step, last)) = path.split_last() else { return };
            let full = show::path(&step);
            if !same(last, "X") && !same(last, "T") {
                return;
            }
            if let Some((_, now)) = self.steps.iter().find(|(own, _)| same(own, &full)) {
                *path = Path::name(now.clone()).with(last);
            } else if self.macros.iter().any(|(own, _)| same(own, &full)) {
                let shown = show::path(path);
                wrong.get_or_insert(format!("{shown} cannot be written without the macro step"));
            }
        });
        wrong.map_or(Ok(()), Err)
    }

    /// Replaces the flags of macro steps.
    fn flags(&self, expr: &mut Expr) {
        if let Expr::Variable(path) = expr {
            let Some((step, last)) = path.split_last() else { return };
            let full = show::path(&step);
            let own = self.macros.iter().find(|(own, _)| same(own, &full) && same(last, "X"));
            let flags = own.into_iter().flat_map(|(_, steps)| steps);
            let flags = flags.map(|now| Expr::Variable(named(now).with("X")));
            if let Some(any) = flags.reduce(Expr::or) {
                *expr = any;
            }
            return;
        }
        expr.operands_mut().into_iter().for_each(|one| self.flags(one));
    }

    fn rename(&self, chart: &mut Chart) {
        for (step, (_, now)) in chart.steps.iter_mut().zip(&self.steps) {
            step.name.clone_from(now);
            for block in &mut step.blocks {
                if let Target::Inline(name, _) = &mut block.target {
                    *name = name.replace('.', "_");
                }
            }
        }
        chart.macros.clear();
    }
}
