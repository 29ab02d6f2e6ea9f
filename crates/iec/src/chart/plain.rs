//! Charts without macro steps: the steps in them get names of their own, `M1_S3` for `M1.S3`, and what asks for them is
//! changed with them, so that any tool reads what is written.

use super::expansion::{bodies, named};
use super::names::Taken;
use super::{Chart, Step, Target};
use crate::ast::{Expr, Path, paths_of};
use crate::{Body, Pou, same, show};

/// The unit with its macro steps replaced, if it has any.
///
/// # Errors
/// What cannot be said without them, in words.
pub fn plain(pou: &Pou) -> Result<Option<Pou>, String> {
    plain_beside(pou, &mut Taken::of(pou))
}

/// The same, with names that are not taken.
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

/// What the steps of a chart are called now.
struct Names {
    line: (u32, Option<(usize, usize)>),
    /// Full names of steps in macro steps, and their new names.
    steps: Vec<(String, String)>,
    /// Macro steps, and the new names of the steps in their places.
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

    /// What asks for a step's flag or time asks for the step by its new name; a macro step's flag is one of its steps'.
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
                wrong.get_or_insert(format!("{shown} has no form without the macro step"));
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
