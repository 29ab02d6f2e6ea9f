//! Random flowchart programs as text, and plants that decide the values that a program does not.

use super::tape::Tape;
use scanbound::front::flowchart::interpret::Plant;
use std::fmt::Write as _;

/// A small program with a main routine and up to two groups, and a table with times.
pub fn generate(tape: &mut Tape<'_>) -> (String, String) {
    let groups = tape.below(3);
    let mut text = String::new();
    let mut labels = 0;
    routine(tape, None, groups, &mut labels, &mut text);
    for group in 0..groups {
        routine(tape, Some(group), groups, &mut labels, &mut text);
    }
    let names = [
        "AND", "AND NOT", "OUT", "OUT NOT", "TIM", "CNR TIM", "JMP", "CJP", "WAIT", "LBL", "GJ",
        "GS", "GOFF", "GN", "GE",
    ];
    let mut table = "instruction,on_us,off_us\n".to_owned();
    for name in names {
        let (on, off) = (1 + tape.below(300), tape.below(300));
        // An instruction without a condition takes the larger of its times.
        let one = matches!(
            name,
            "OUT" | "OUT NOT" | "CNR TIM" | "LBL" | "GJ" | "GS" | "GOFF" | "GN" | "GE" | "JMP"
        );
        let _ = writeln!(table, "{name},{on},{}", if one { on } else { off });
    }
    (text, table)
}

fn routine(
    tape: &mut Tape<'_>,
    group: Option<usize>,
    groups: usize,
    labels: &mut usize,
    text: &mut String,
) {
    let first = *labels;
    let count = 1 + tape.below(3);
    *labels += count;
    if let Some(group) = group {
        let _ = writeln!(text, "GN {group}");
    }
    let label = |tape: &mut Tape<'_>| first + tape.below(count);
    for own in 0..count {
        let _ = writeln!(text, "LBL{}:", first + own);
        for _ in 0..1 + tape.below(4) {
            match tape.below(9) {
                0 => {
                    let _ = writeln!(
                        text,
                        "OUT{} {}",
                        tape.pick(&["", " NOT"]),
                        tape.pick(&[200, 201])
                    );
                }
                1 | 2 => {
                    condition(tape, text);
                    let _ = writeln!(text, "CJP LBL{}", label(tape));
                }
                3 | 4 if group.is_some() || tape.percent(30) => {
                    condition(tape, text);
                    let _ = writeln!(text, "WAIT");
                }
                5 => {
                    let _ = writeln!(text, "CNR TIM {}", tape.pick(&[10, 11]));
                }
                6 | 7 if groups > 0 => {
                    let other = tape.below(groups);
                    if group != Some(other) {
                        let _ = writeln!(text, "{} {other}", tape.pick(&["GS", "GOFF"]));
                    }
                }
                8 if group.is_none() => {
                    let _ = writeln!(text, "GJ");
                }
                _ => {
                    let _ = writeln!(text, "OUT 200");
                }
            }
        }
        if tape.percent(20) {
            let _ = writeln!(text, "JMP LBL{}", label(tape));
        }
    }
    match group {
        Some(group) if tape.percent(50) => {
            let _ = writeln!(text, "GE {group}");
        }
        _ => {
            let _ = writeln!(text, "JMP LBL{}", label(tape));
        }
    }
}

fn condition(tape: &mut Tape<'_>, text: &mut String) {
    if tape.percent(40) {
        let _ = writeln!(text, "TIM {} #{}", tape.pick(&[10, 11]), tape.pick(&[30, 10, 0]));
        return;
    }
    for _ in 0..1 + tape.below(2) {
        let _ = writeln!(text, "AND{} {}", tape.pick(&["", " NOT"]), tape.pick(&[0, 200, 1, 201]));
    }
}

/// Tries all combinations of answers, one for each pass.
#[derive(Default)]
pub struct Every {
    /// For each question: the number of answers and the current answer.
    taken: Vec<(usize, usize)>,
    at: usize,
}

impl Every {
    fn answer(&mut self, options: usize) -> usize {
        if self.at == self.taken.len() {
            self.taken.push((options, 0));
        }
        self.at += 1;
        self.taken[self.at - 1].1
    }

    /// The next combination, if there is one.
    pub fn advance(&mut self) -> bool {
        self.at = 0;
        while let Some((options, taken)) = self.taken.pop() {
            if taken + 1 < options {
                self.taken.push((options, taken + 1));
                return true;
            }
        }
        false
    }
}

impl Plant for Every {
    fn keeps_rest(&mut self, _: u32) -> bool {
        self.answer(2) == 1
    }
    fn bit(&mut self, _: u32) -> bool {
        self.answer(2) == 1
    }
    fn started(&mut self, _: u32) -> bool {
        self.answer(2) == 1
    }
    fn elapsed(&mut self, _: u32) -> bool {
        self.answer(2) == 1
    }
    fn position(&mut self, _: Option<u32>, places: usize) -> usize {
        self.answer(places)
    }
    fn restarts(&mut self, _: u32) -> bool {
        self.answer(2) == 1
    }
}

/// Answers at random; inputs and timers change sometimes.
pub struct Weather(pub u64);

impl Weather {
    fn next(&mut self, n: u64) -> u64 {
        self.0 =
            self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 33) % n
    }
}

impl Plant for Weather {
    fn keeps_rest(&mut self, _: u32) -> bool {
        self.next(2) == 1
    }
    fn bit(&mut self, _: u32) -> bool {
        self.next(2) == 1
    }
    fn started(&mut self, _: u32) -> bool {
        self.next(2) == 1
    }
    fn elapsed(&mut self, _: u32) -> bool {
        self.next(2) == 1
    }
    fn position(&mut self, _: Option<u32>, places: usize) -> usize {
        self.next(places as u64) as usize
    }
    fn restarts(&mut self, _: u32) -> bool {
        self.next(2) == 1
    }
}
