//! Makes a project smaller as long as something holds of it.

use super::tree::{Argument, Call, Expr, Kind, Place, Project, Statement, Step};

/// Looks for the place of the next change.
struct Walk {
    /// How many places are passed over.
    left: usize,
    /// Which of the changes of a place is made.
    which: usize,
    done: bool,
}

impl Walk {
    /// Whether the change is to be made here; `many` ways are known.
    fn here(&mut self, many: usize) -> bool {
        if self.done {
            return false;
        }
        if self.left >= many {
            self.left -= many;
            return false;
        }
        self.which = self.left;
        self.done = true;
        true
    }

    fn body(&mut self, all: &mut Vec<Statement>) {
        let mut at = 0;
        while at < all.len() && !self.done {
            let inner: Vec<Vec<Statement>> = match &all[at] {
                Statement::If(arms, otherwise) => {
                    arms.iter().map(|arm| arm.1.clone()).chain([otherwise.clone()]).collect()
                }
                Statement::Case(_, arms, otherwise) => {
                    arms.iter().map(|arm| arm.1.clone()).chain([otherwise.clone()]).collect()
                }
                Statement::For(own) => vec![own.body.clone()],
                Statement::While(_, body) | Statement::Repeat(body, _) => vec![body.clone()],
                _ => Vec::new(),
            };
            if self.here(1 + inner.len()) {
                // It goes away, or one of its bodies takes its place.
                let instead = self.which.checked_sub(1).map(|which| inner[which].clone());
                all.splice(at..=at, instead.unwrap_or_default());
                return;
            }
            self.statement(&mut all[at]);
            at += 1;
        }
    }

    fn statement(&mut self, one: &mut Statement) {
        match one {
            Statement::Assign(to, value) => {
                self.place(to);
                self.expr(value);
            }
            Statement::Copy(to, from) | Statement::Refer(to, from) => {
                self.place(to);
                self.place(from);
            }
            Statement::Latch(to, _, when) => {
                self.place(to);
                self.expr(when);
            }
            Statement::Call(call) => self.call(call),
            Statement::Set(place, _, value) => {
                place.iter_mut().for_each(|place| self.place(place));
                self.expr(value);
            }
            Statement::If(arms, otherwise) => {
                if arms.len() > 1 && self.here(1) {
                    arms.pop();
                    return;
                }
                for (condition, body) in arms {
                    self.expr(condition);
                    self.body(body);
                }
                self.body(otherwise);
            }
            Statement::Case(of, arms, otherwise) => {
                self.expr(of);
                if arms.len() > 1 && self.here(1) {
                    arms.pop();
                    return;
                }
                for (values, body) in arms {
                    if values.len() > 1 && self.here(1) {
                        values.pop();
                        return;
                    }
                    self.body(body);
                }
                self.body(otherwise);
            }
            Statement::For(own) => {
                self.expr(&mut own.from);
                self.expr(&mut own.to);
                self.body(&mut own.body);
            }
            Statement::While(condition, body) | Statement::Repeat(body, condition) => {
                self.expr(condition);
                self.body(body);
            }
            Statement::Exit | Statement::Continue | Statement::Return => {}
        }
    }

    fn place(&mut self, place: &mut Place) {
        for step in &mut place.steps {
            if let Step::Element(indices) = step {
                indices.iter_mut().for_each(|one| self.expr(one));
            }
        }
    }

    fn call(&mut self, call: &mut Call) {
        if call.enable.is_some() && self.here(1) {
            call.enable = None;
            return;
        }
        if !call.unnamed {
            for at in 0..call.given.len() {
                if !matches!(call.given[at].1, Argument::InOut(_)) && self.here(1) {
                    call.given.remove(at);
                    return;
                }
            }
        }
        for (_, argument) in &mut call.given {
            match argument {
                Argument::In(value) => self.expr(value),
                Argument::InOut(place) | Argument::Out(place) => self.place(place),
            }
        }
    }

    fn expr(&mut self, expr: &mut Expr) {
        let ty = expr.ty.clone();
        let mut operands: Vec<Expr> = match &expr.kind {
            Kind::Not(inner) | Kind::Negate(inner) | Kind::Widen(inner) => vec![(**inner).clone()],
            Kind::Binary(_, one, two) => vec![(**one).clone(), (**two).clone()],
            Kind::Standard(_, given) => given.clone(),
            _ => Vec::new(),
        };
        operands.retain(|one| one.ty == ty);
        let mut plain = |kind: Kind| operands.push(Expr { ty: ty.clone(), kind });
        match (&ty, &expr.kind) {
            (_, Kind::Number(..) | Kind::Bool(_) | Kind::Null | Kind::Address(_)) => {}
            (super::tree::Ty::Bool, _) => [false, true].map(Kind::Bool).into_iter().for_each(plain),
            (super::tree::Ty::Number(_), _) => plain(Kind::Number(1, true, 10)),
            _ => {}
        }
        if self.here(operands.len()) {
            *expr = operands[self.which].clone();
            return;
        }
        match &mut expr.kind {
            Kind::Read(place) | Kind::Address(place) => self.place(place),
            Kind::Not(inner) | Kind::Negate(inner) | Kind::Widen(inner) => self.expr(inner),
            Kind::Binary(_, one, two) => {
                self.expr(one);
                self.expr(two);
            }
            Kind::Standard(_, given) => given.iter_mut().for_each(|one| self.expr(one)),
            Kind::Call(call) => self.call(call),
            Kind::Get(Some(place), _) => self.place(place),
            _ => {}
        }
    }
}

/// The project with the change of this number, if there are so many.
fn changed(project: &Project, number: usize) -> Option<Project> {
    let mut project = project.clone();
    let mut walk = Walk { left: number, which: 0, done: false };
    for block in project.blocks.iter_mut().rev() {
        walk.body(&mut block.body);
        block.methods.iter_mut().for_each(|one| walk.body(&mut one.body));
        block.properties.iter_mut().for_each(|one| walk.body(&mut one.1.body));
        block.actions.iter_mut().for_each(|one| walk.body(&mut one.1));
    }
    project.functions.iter_mut().for_each(|one| walk.body(&mut one.body));
    walk.done.then_some(project)
}

/// The smallest project that is found of which it still holds.
pub fn smaller(project: &Project, holds: &mut dyn FnMut(&Project) -> bool) -> Project {
    let mut best = project.clone();
    loop {
        let (mut at, mut found) = (0, false);
        while let Some(next) = changed(&best, at) {
            if holds(&next) {
                best = next;
                found = true;
            } else {
                at += 1;
            }
        }
        if !found {
            return best;
        }
    }
}

/// The text without the lines that it does not need, of those that may go away.
pub fn shorter(
    text: &str,
    may: &dyn Fn(&str) -> bool,
    holds: &mut dyn FnMut(&str) -> bool,
) -> String {
    let mut lines: Vec<&str> = text.lines().collect();
    let mut at = lines.len();
    while at > 0 {
        at -= 1;
        if !may(lines[at]) {
            continue;
        }
        let mut next = lines.clone();
        next.remove(at);
        if holds(&next.join("\n")) {
            lines = next;
        }
    }
    lines.join("\n")
}
