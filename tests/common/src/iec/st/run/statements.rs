//! Runs statements, scan by scan.

use super::*;

impl<'p> Machine<'p> {
    /// One scan.
    pub fn scan(&mut self) -> Run<()> {
        self.stores = 0;
        self.steps = 20_000;
        let program = self.project.program();
        self.block_body(self.program, program, program)
    }

    pub(super) fn body(&mut self, frame: &Frame<'p>, all: &'p [Statement]) -> Run<Flow> {
        for one in all {
            let flow = self.statement(frame, one)?;
            if flow != Flow::On {
                return Ok(flow);
            }
        }
        Ok(Flow::On)
    }

    pub(super) fn tick(&mut self) -> Run<()> {
        self.steps = self.steps.checked_sub(1).ok_or(Stop::Long)?;
        Ok(())
    }

    pub(super) fn statement(&mut self, frame: &Frame<'p>, one: &'p Statement) -> Run<Flow> {
        self.tick()?;
        match one {
            Statement::Assign(to, value) => {
                let before = match self.manner.target_first {
                    true => Some(self.locate(frame, to)?),
                    false => None,
                };
                let value = self.typed(frame, value)?;
                let loc = match before {
                    Some(loc) => loc,
                    None => self.locate(frame, to)?,
                };
                self.set(&loc, value);
            }
            Statement::Copy(to, from) => {
                let (to, from) = (self.locate(frame, to)?, self.locate(frame, from)?);
                self.copy(&to, &from);
            }
            Statement::Refer(to, of) => {
                let (loc, _) = self.declared(frame, to.root);
                let of = self.locate(frame, of)?;
                self.set(&loc, Value::Meant(Some(of)));
            }
            Statement::Latch(to, sets, when) => {
                if self.holds(frame, when)? {
                    let loc = self.locate(frame, to)?;
                    self.put(&loc, Value::Int(i128::from(*sets)));
                }
            }
            Statement::Call(call) => {
                self.call(frame, call)?;
            }
            Statement::Set(place, name, value) => {
                let before = match self.manner.target_first {
                    true => Some(self.instance(frame, place.as_ref())?),
                    false => None,
                };
                let value = self.typed(frame, value)?;
                let this = match before {
                    Some(this) => this,
                    None => self.instance(frame, place.as_ref())?,
                };
                let (_, own) =
                    self.project.property(this.1, name, Access::Set).expect("a property");
                self.routine(own, Some(this), |machine, inner| {
                    machine.cells[inner.cells[0]] = kept(&inner.variables[0].ty, value);
                })?;
            }
            Statement::If(arms, otherwise) => {
                for (condition, body) in arms {
                    if self.holds(frame, condition)? {
                        return self.body(frame, body);
                    }
                }
                return self.body(frame, otherwise);
            }
            Statement::Case(of, arms, otherwise) => {
                let of = self.value(frame, of)?.int();
                let fits = |all: &[(i128, i128)]| {
                    all.iter().any(|(low, high)| (*low..=*high).contains(&of))
                };
                let own = arms.iter().find(|arm| fits(&arm.0)).map_or(otherwise, |arm| &arm.1);
                return self.body(frame, own);
            }
            Statement::For(own) => return self.counted(frame, own),
            Statement::While(condition, body) => {
                while self.holds(frame, condition)? {
                    self.tick()?;
                    match self.body(frame, body)? {
                        Flow::Exit => break,
                        Flow::Return => return Ok(Flow::Return),
                        Flow::On | Flow::Continue => {}
                    }
                }
            }
            Statement::Repeat(body, until) => loop {
                self.tick()?;
                match self.body(frame, body)? {
                    Flow::Exit => break,
                    Flow::Return => return Ok(Flow::Return),
                    Flow::On | Flow::Continue => {}
                }
                if self.holds(frame, until)? {
                    break;
                }
            },
            Statement::Exit => return Ok(Flow::Exit),
            Statement::Continue => return Ok(Flow::Continue),
            Statement::Return => return Ok(Flow::Return),
        }
        Ok(Flow::On)
    }

    pub(super) fn counted(&mut self, frame: &Frame<'p>, own: &'p For) -> Run<Flow> {
        let loc = self.locate(frame, &own.variable)?;
        let first = self.typed(frame, &own.from)?;
        self.put(&loc, kept(&loc.ty, first));
        let by = own.by.unwrap_or(1);
        let mut end = self.value(frame, &own.to)?.int();
        let mut turns = 0_u32;
        loop {
            self.tick()?;
            if turns > 0 && self.manner.end_again {
                end = self.value(frame, &own.to)?.int();
            }
            let at = self.load(&loc).int();
            if (by > 0 && at > end) || (by < 0 && at < end) {
                if self.manner.last && turns > 0 {
                    self.put(&loc, kept(&loc.ty, Value::Int(at - by)));
                }
                return Ok(Flow::On);
            }
            turns += 1;
            match self.body(frame, &own.body)? {
                Flow::Exit => return Ok(Flow::On),
                Flow::Return => return Ok(Flow::Return),
                Flow::On | Flow::Continue => {}
            }
            let next = self.load(&loc).int() + by;
            let wrapped = kept(&loc.ty, Value::Int(next));
            if self.manner.last && wrapped != Value::Int(next) {
                // It stops before it leaves its type.
                return Ok(Flow::On);
            }
            self.put(&loc, wrapped);
        }
    }
}
