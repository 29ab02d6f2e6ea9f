//! Builds loops with a known number of iterations.

use super::Assembler;
use super::value::{Value, constant};
use scanbound_base::code::Code;
use scanbound_iec::ast::Operator;
use scanbound_iec::fault::Fault;
use scanbound_ir::{Logic, Number, Step, WordSource, WordTarget, Write};
use std::collections::BTreeMap;

/// The largest iteration count that is modelled.
pub(crate) const MOST: i64 = i16::MAX as i64;

/// The number of iterations of a loop: the word that holds it, and its limits.
pub(crate) struct Turns {
    pub(crate) count: WordSource,
    pub(crate) least: u32,
    pub(crate) most: u32,
}

impl Turns {
    pub(crate) fn exactly(turns: u16) -> Turns {
        let count = WordSource::Const(turns);
        Turns { count, least: turns.into(), most: turns.into() }
    }
}

impl Assembler {
    /// The iterations of a loop with no known count: any number from `fewest` on. The result is then not a bound.
    pub(crate) fn any_turns(&mut self, fewest: u32, line: u32) -> Turns {
        let cell = self.words_between(1);
        let choice = self.builder.choice();
        let any = Number::Words(vec![WordSource::Free(choice)]);
        self.write(vec![Write::Words(vec![WordTarget::Cell(cell)], any)]);
        let name = format!("the iterations of the loop in line {line}");
        self.program().names.insert(cell, name);
        let most = i16::MAX.cast_unsigned().into();
        Turns { count: WordSource::Cell(cell), least: fewest, most }
    }

    /// Marks the loop that begins here as unbounded where `condition` is true: its variable wraps around before the
    /// loop ends, or it runs more iterations than are modelled.
    pub(crate) fn without_end(&mut self, condition: Logic) {
        let skip = self.jump(condition.not(), None);
        let here = self.builder.next();
        self.builder.add(None, Vec::new(), Step::Unbounded { from: here, certain: false });
        self.land(skip);
        self.landing();
    }

    pub(crate) fn begin_loop(&mut self, turns: &Turns, row: Option<&str>) -> usize {
        let Turns { count, least, most } = *turns;
        let key = row.map(|row| Assembler::key(&[row], "loop"));
        self.builder.add(key, Vec::new(), Step::ForBegin { count, least, most, end: 0 })
    }

    pub(crate) fn close_loop(&mut self, begin: usize, row: &str) {
        let end = self.builder.add(Some(Assembler::key(&[row], "loop")), Vec::new(), Step::ForEnd);
        if let Step::ForBegin { end: own, .. } = &mut self.builder.program.instructions[begin].step
        {
            *own = end;
        }
    }

    pub(crate) fn end_loop(&mut self, begin: usize, row: &str, out: Vec<usize>) {
        self.close_loop(begin, row);
        self.leave_loop(out);
    }

    /// Sets the target of the jumps out of a loop to the next instruction.
    pub(crate) fn leave_loop(&mut self, out: Vec<usize>) {
        for jump in out {
            self.land(jump);
        }
        self.landing();
    }

    /// Excludes scans in which a loop would run more iterations than the user states. `goes_on`: whether it would
    /// continue after the stated number.
    pub(crate) fn ends_here(&mut self, goes_on: Logic) {
        let cell = self.words_between(1);
        let write = |value| Write::Words(vec![WordTarget::Cell(cell)], constant(value, 1));
        self.write(vec![write(0)]);
        self.write_if(goes_on, vec![write(1)], None);
        let more = Turns { count: WordSource::Cell(cell), least: 0, most: 1 };
        let begin = self.begin_loop(&more, None);
        let end = self.builder.add(None, Vec::new(), Step::ForEnd);
        let program = self.program();
        if let Step::ForBegin { end: own, .. } = &mut program.instructions[begin].step {
            *own = end;
        }
        program.stated_counts.insert(begin, (0, 0));
        program.names.insert(cell, "one iteration more than is stated".to_owned());
    }

    pub(crate) fn holds(
        &mut self,
        operator: Operator,
        left: Value,
        right: Value,
        line: u32,
    ) -> Result<Logic, Fault> {
        match self.combined(operator, left, right, line)? {
            Value::Bit(logic) => Ok(logic),
            _ => Err(Fault::new(line, "the iteration count of the loop is not modelled")
                .code(Code::LoopCount)),
        }
    }
}

/// The largest iteration count that the user states for the loop in a line of a file with these names. None if nothing
/// is stated. A fault if the stated minimum is above `fewest`, or the maximum is out of range.
pub(crate) fn most_stated(
    all: &BTreeMap<String, (i64, i64)>,
    names: [&str; 2],
    fewest: u32,
    line: u32,
) -> Result<Option<u16>, Fault> {
    let stated = |name: &str| {
        all.iter().find(|(place, _)| {
            let place = place.rsplit_once(':');
            place.is_some_and(|(own, number)| {
                number.trim() == line.to_string() && own.eq_ignore_ascii_case(name)
            })
        })
    };
    let Some((place, &(low, high))) = names.into_iter().find_map(stated) else {
        return Ok(None);
    };
    let most = u16::try_from(high).ok().filter(|&most| i64::from(most) <= MOST);
    let most = most.filter(|&most| u32::from(most) >= fewest && low <= fewest.into());
    most.map(Some).ok_or_else(|| {
        let told = format!(
            "for the loop at {place}, only the largest iteration count can be stated, from {fewest} to {MOST}"
        );
        let help = format!("write [counts] \"{place}\" = [{fewest}, 10]");
        Fault::new(line, told).code(Code::Fact).help(help)
    })
}

/// The fault of a loop whose iteration count is not known.
pub(crate) fn not_known(file: &str, fewest: u8, line: u32) -> Fault {
    let help = "compare a variable with an end (WHILE i < 10 DO), and let one statement of the loop move it by a \
                constant (i := i + 1), or write the loop as FOR with EXIT";
    let place = scanbound_base::facts::key(&format!("{file}:{line}"));
    let help = format!(
        "{help}; or state its largest iteration count in a facts file (--facts): [counts] {place} = [{fewest}, 10]"
    );
    Fault::new(line, "the iteration count of WHILE or REPEAT is not known")
        .code(Code::LoopCount)
        .help(help)
}

/// The relation between the operands of a comparison while a loop continues, and the same with the operands exchanged.
/// `while_true`: whether the loop continues while the comparison is true. None if the operator is not a comparison.
pub(crate) fn goes_on(operator: Operator, while_true: bool) -> Option<(Operator, Operator)> {
    use Operator::{Equal, Greater, GreaterOrEqual, Less, LessOrEqual, NotEqual};
    let other = match operator {
        Equal => Equal,
        NotEqual => NotEqual,
        Less => Greater,
        LessOrEqual => GreaterOrEqual,
        Greater => Less,
        GreaterOrEqual => LessOrEqual,
        _ => return None,
    };
    let goes_on = |operator: Operator| match (while_true, operator) {
        (true, operator) => operator,
        (false, Equal) => NotEqual,
        (false, Less) => GreaterOrEqual,
        (false, LessOrEqual) => Greater,
        (false, Greater) => LessOrEqual,
        (false, NotEqual) => Equal,
        (false, _) => Less,
    };
    Some((goes_on(operator), goes_on(other)))
}

/// The least and the largest value of an integer type.
pub(crate) fn whole_range(bits: u8, signed: bool) -> (i64, i64) {
    match signed {
        true => (-(1 << (bits - 1)), (1 << (bits - 1)) - 1),
        false => (0, (1 << bits) - 1),
    }
}
