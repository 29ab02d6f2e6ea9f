//! The frame of a program: its end, subroutines, jumps, loops and interlocks, checked before anything is emitted.

use scanbound_base::code::Code;
use std::collections::BTreeMap;

use super::resolve::Item;
use super::source::Family;
use scanbound_base::diagnostic::Diagnostic;
use scanbound_front::Faults;
use scanbound_front::shown;

/// A subroutine's place among the items.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Routine {
    pub(super) number: u32,
    /// Its SBN.
    pub(super) begin: usize,
    /// Its RET.
    pub(super) end: usize,
    /// Whether other programs of the project may call it.
    pub(super) global: bool,
}

/// How the items of a program hang together.
#[derive(Debug, Clone, Default)]
pub(super) struct Frame {
    /// The END.
    pub(super) end: Option<usize>,
    /// The subroutines in the order of the source.
    pub(super) routines: Vec<Routine>,
    /// Where a jump, BREAK or FOR goes: JME, NEXT.
    pub(super) targets: BTreeMap<usize, usize>,
    /// Items that are never reached: behind END, outside of subroutines.
    pub(super) dead: Vec<bool>,
    /// Items that stand in an interlock.
    pub(super) interlocked: Vec<bool>,
    /// Items that may run more than once a scan: in loops, and in subroutines but those called once.
    pub(super) repeated: Vec<bool>,
}

/// Where an item stands.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
struct Site {
    routine: usize,
    /// The innermost open interlock: there may be thousands around it.
    interlock: Option<usize>,
    loops: Vec<usize>,
}

/// Works the frame out, or tells all that is wrong with it. `shared`: other programs may call its subroutines.
pub(super) fn frame(
    items: &[Item<'_>],
    family: Family,
    shared: bool,
    faults: &mut Faults<'_>,
) -> Frame {
    let mut frame = Frame { dead: vec![false; items.len()], ..Frame::default() };
    routines(items, family, &mut frame, faults);
    let sites = sites(items, &mut frame, faults);
    jumps(items, family, &sites, &mut frame, faults);
    frame.repeated = repeated(items, family, shared, &sites, &frame);
    frame.interlocked = sites.iter().map(|site| site.interlock.is_some()).collect();
    frame
}

fn repeated(
    items: &[Item<'_>],
    family: Family,
    shared: bool,
    sites: &[Site],
    frame: &Frame,
) -> Vec<bool> {
    let once = |routine: &Routine| {
        let called = |at: &usize| {
            matches!(items[*at].meaning(), "call" | "macro")
                && items[*at].number(family) == Some(routine.number)
        };
        let calls: Vec<usize> = (0..items.len()).filter(called).collect();
        matches!(calls[..], [at] if sites[at].loops.is_empty() && sites[at].routine == 0)
            && !routine.global
            && !shared
    };
    let many: Vec<&Routine> = frame.routines.iter().filter(|routine| !once(routine)).collect();
    let within = |at| many.iter().any(|routine| (routine.begin..=routine.end).contains(&at));
    (0..items.len()).map(|at| !sites[at].loops.is_empty() || within(at)).collect()
}

fn fault(item: &Item<'_>, code: Code, message: String, help: &str, faults: &mut Faults<'_>) {
    let file = faults.file().to_owned();
    let text = shown(&item.raw.text);
    faults.push(
        Diagnostic::line(code, &file, item.raw.line, text, message, help).at_step(item.raw.step),
    );
}

fn routines(items: &[Item<'_>], family: Family, frame: &mut Frame, faults: &mut Faults<'_>) {
    let mut open: Option<(usize, u32)> = None;
    let mut misplaced = None;
    for (at, item) in items.iter().enumerate() {
        match item.meaning() {
            "routine" => {
                if let Some((begin, _)) = open {
                    fault(
                        &items[begin],
                        Code::NoReturn,
                        "this subroutine has no RET".to_owned(),
                        "end it with RET before the next SBN",
                        faults,
                    );
                }
                let Some(number) = item.number(family) else {
                    fault(
                        item,
                        Code::Operand,
                        "a subroutine's number is a constant".to_owned(),
                        "write it as a number, such as SBN(092) 1",
                        faults,
                    );
                    continue;
                };
                if frame.routines.iter().any(|routine| {
                    routine.number == number && routine.global == item.name.starts_with('G')
                }) {
                    fault(
                        item,
                        Code::Twice,
                        format!("subroutine {number} is defined twice"),
                        "give one of them another number",
                        faults,
                    );
                }
                open = Some((at, number));
            }
            "return" => match open.take() {
                Some((begin, number)) => frame.routines.push(Routine {
                    number,
                    begin,
                    end: at,
                    global: items[begin].name.starts_with('G'),
                }),
                None => fault(
                    item,
                    Code::NoRoutine,
                    "this RET ends no subroutine".to_owned(),
                    "a subroutine begins with SBN",
                    faults,
                ),
            },
            "end" if open.is_none() => {
                frame.end = frame.end.or(Some(at));
            }
            "end" => {}
            _ if open.is_some() => {}
            _ if frame.end.is_some() => frame.dead[at] = true,
            "nothing" => {}
            _ if !frame.routines.is_empty() => misplaced = misplaced.or(Some(at)),
            _ => {}
        }
    }
    if let Some((begin, _)) = open {
        fault(
            &items[begin],
            Code::NoReturn,
            "this subroutine has no RET".to_owned(),
            "end it with RET",
            faults,
        );
    }
    if let Some(at) = misplaced {
        let help = "the PLC does not run what follows a subroutine: move the subroutines behind the program, before or behind END";
        fault(
            &items[at],
            Code::BehindSubroutine,
            "this stands in the program behind a subroutine".to_owned(),
            help,
            faults,
        );
    }
}

fn sites(items: &[Item<'_>], frame: &mut Frame, faults: &mut Faults<'_>) -> Vec<Site> {
    let mut sites = Vec::with_capacity(items.len());
    let mut site = Site::default();
    let mut interlocks: Vec<usize> = Vec::new();
    for (at, item) in items.iter().enumerate() {
        match item.meaning() {
            "routine" => {
                unclosed(items, &site, faults);
                interlocks.clear();
                site = Site { routine: at + 1, ..Site::default() };
            }
            "interlock-end" | "interlock-number-end" => {
                if item.meaning() == "interlock-end" {
                    interlocks.clear();
                } else if interlocks
                    .pop()
                    .is_none_or(|begin| items[begin].operands.first() != item.operands.first())
                {
                    fault(
                        item,
                        Code::Interlock,
                        "this MILC does not end the innermost open interlock".to_owned(),
                        "interlocks end in the reverse order of their begin",
                        faults,
                    );
                }
            }
            "next" => match site.loops.pop() {
                Some(begin) => {
                    frame.targets.insert(begin, at);
                }
                None => fault(
                    item,
                    Code::Loop,
                    "this NEXT ends no loop".to_owned(),
                    "a loop begins with FOR",
                    faults,
                ),
            },
            _ => {}
        }
        site.interlock = interlocks.last().copied();
        sites.push(site.clone());
        match item.meaning() {
            "interlock" | "interlock-number" => interlocks.push(at),
            "for" => site.loops.push(at),
            "return" => {
                unclosed(items, &site, faults);
                interlocks.clear();
                site = Site { routine: usize::MAX, ..Site::default() };
            }
            "end" => {
                unclosed(items, &site, faults);
                site.loops.clear();
            }
            _ => {}
        }
    }
    unclosed(items, &site, faults);
    for (at, item) in items.iter().enumerate().filter(|(_, item)| item.meaning() == "break") {
        match sites[at].loops.last().and_then(|begin| frame.targets.get(begin)) {
            Some(&next) => {
                frame.targets.insert(at, next);
            }
            None => fault(
                item,
                Code::Loop,
                "this BREAK stands in no loop".to_owned(),
                "a loop begins with FOR and ends with NEXT",
                faults,
            ),
        }
    }
    sites
}

fn unclosed(items: &[Item<'_>], site: &Site, faults: &mut Faults<'_>) {
    for &begin in &site.loops {
        fault(
            &items[begin],
            Code::Loop,
            "this FOR has no NEXT".to_owned(),
            "end the loop with NEXT",
            faults,
        );
    }
}

fn jumps(
    items: &[Item<'_>],
    family: Family,
    sites: &[Site],
    frame: &mut Frame,
    faults: &mut Faults<'_>,
) {
    for (at, item) in items.iter().enumerate() {
        let zero = item.meaning() == "jump-zero";
        if !zero && !matches!(item.meaning(), "jump" | "jump-if") {
            continue;
        }
        let Some(number) = (if zero { Some(0) } else { item.number(family) }) else {
            fault(
                item,
                Code::Operand,
                "the jump's number is not a constant, so its target is not known".to_owned(),
                "write the number as a constant, such as JMP(004) #1",
                faults,
            );
            continue;
        };
        let wanted = if zero { "jump-zero-end" } else { "jump-end" };
        let lands = |other: &Item<'_>| {
            other.meaning() == wanted && (zero || other.number(family) == Some(number))
        };
        let same = |other: usize| sites[other].routine == sites[at].routine;
        // Where several have the number, the PLC goes to the first of the program, wherever it stands.
        let first = (0..items.len()).find(|&other| lands(&items[other])).filter(|_| number != 0);
        if first
            .is_some_and(|first| first < at && (at..items.len()).any(|other| lands(&items[other])))
        {
            let message = format!(
                "there are several JMEs of number {number}, and this jump goes back to the first"
            );
            let help = "give each JMP and its JME a number of their own";
            fault(item, Code::Jump, message, help, faults);
            continue;
        }
        let Some(target) = (at + 1..items.len()).find(|&other| lands(&items[other]) && same(other))
        else {
            let before = (0..at).any(|other| lands(&items[other]) && same(other));
            let (message, help) = if before {
                (
                    "this jump goes back",
                    "the instructions between run until the condition turns, which may be for ever: no bound exists",
                )
            } else {
                (
                    "this jump has no JME of its number behind it",
                    "add the JME, or correct the number",
                )
            };
            fault(item, Code::Jump, message.to_owned(), help, faults);
            continue;
        };
        if sites[target].interlock != sites[at].interlock {
            fault(
                item,
                Code::Jump,
                "this jump leads into an interlock or out of one".to_owned(),
                "put JMP and JME both inside or both outside of IL and ILC",
                faults,
            );
        }
        if !sites[at].loops.starts_with(&sites[target].loops) {
            fault(
                item,
                Code::Jump,
                "this jump leads into a loop".to_owned(),
                "put JMP and JME both inside or both outside of FOR and NEXT",
                faults,
            );
        }
        frame.targets.insert(at, target);
    }
}
