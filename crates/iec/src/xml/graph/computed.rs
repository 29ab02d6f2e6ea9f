//! Blocks of drawn conditions, as generators write them: an action that the first step stores carries them out in each scan, and the
//! condition reads what they put out.

use super::pins::is_instance;
use super::{Graph, is_called, put_in};
use crate::ast::{Expr, Kind, RESULT, change};
use crate::fault::Fault;
use crate::xml::reading::Reading;

impl<'a, 'i> Graph<'a, 'i> {
    /// What a condition is where its blocks are carried out apart; nothing, if it has none, or they are carried out with it.
    pub(super) fn computed(
        &mut self,
        reading: &mut Reading<'_, '_>,
        value: &Expr,
    ) -> Result<Option<Expr>, Fault> {
        let is_result = |target: &str| target.starts_with(RESULT);
        let acts = |kind: &Kind| match kind {
            Kind::Assign(target, _) => is_result(&target.first),
            _ => true,
        };
        let is_known = |kind: &Kind| matches!(kind, Kind::Assign(..) | Kind::CallIf(..));
        if !reading.computes
            || self.text.is_codesys
            || !self.statements.iter().any(|one| acts(&one.kind))
            || !self.statements.iter().all(|one| is_known(&one.kind))
        {
            return Ok(None);
        }
        let mut value = value.clone();
        let mut apart = Vec::new();
        let mut is_whole = true;
        for statement in self.statements.clone().into_iter().rev() {
            match &statement.kind {
                // What is kept where ways fork is written where it is asked for.
                Kind::Assign(target, own) if !is_result(&target.first) => {
                    let mut put = |one: &mut Expr| is_whole &= put_in(one, target, own).is_some();
                    put(&mut value);
                    change(&mut apart, &mut put, &mut |_| {});
                }
                _ => apart.push(statement),
            }
        }
        if !is_whole {
            return Ok(None);
        }
        apart.reverse();
        let done: Vec<&str> = self.done.iter().copied().collect();
        for id in done {
            let node = self.nodes[id];
            if is_called(node, "block") && !is_instance(node) {
                for output in self.outputs(node) {
                    self.declare(reading, id, node, &output)?;
                }
                if self.gives_enable(node) {
                    self.declare(reading, id, node, "ENO")?;
                }
            }
        }
        self.statements.clear();
        self.owners.clear();
        reading.compute(apart);
        Ok(Some(value))
    }
}
