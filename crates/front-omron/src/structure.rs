//! The control structure of a program: its end, subroutines, jumps, loops and interlocks. It is checked before
//! lowering.

use scanbound_base::code::Code;
use std::collections::BTreeMap;

use super::resolve::Item;
use super::source::Family;
use scanbound_base::diagnostic::Diagnostic;
use scanbound_front::Faults;
use scanbound_front::shown;

/// A subroutine.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Routine {
    pub(super) number: u32,
    /// The index of the SBN item.
    pub(super) begin: usize,
    /// The index of the RET item.
    pub(super) end: usize,
    /// Whether the subroutine is global (GSBN), so that other programs may call it.
    pub(super) global: bool,
}

/// The control structure of a program: subroutines, jumps, loops and interlocks.
#[derive(Debug, Clone, Default)]
pub(super) struct Structure {
    /// The index of the END item. `None` if there is none.
    pub(super) end: Option<usize>,
    /// The subroutines in source order.
    pub(super) routines: Vec<Routine>,
    /// For each jump, BREAK and FOR, by the index of its item: the index of the JME or NEXT item to which it leads.
    pub(super) targets: BTreeMap<usize, usize>,
    /// For each item, whether it never runs because it is after END and not in a subroutine.
    pub(super) dead: Vec<bool>,
    /// For each item, whether it is in an interlock, between IL and ILC or MILH/MILR and MILC.
    pub(super) interlocked: Vec<bool>,
    /// For each item, whether it may run several times in a scan: it is in a loop, or in a subroutine that is not
    /// called exactly once from the main part outside of loops, or that other programs may call.
    pub(super) repeated: Vec<bool>,
}

/// The subroutine, the loops and the interlock in which an item is.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
struct Site {
    /// The index of the subroutine's SBN item plus 1; 0 before the first subroutine, and `usize::MAX` between a RET and
    /// the next SBN.
    routine: usize,
    /// The innermost open interlock. Only this one is stored, because there may be thousands. `None` outside of
    /// interlocks.
    interlock: Option<usize>,
    /// The indices of the FOR items of the open loops, outermost first.
    loops: Vec<usize>,
}

/// Builds the control structure and reports all errors in it. `shared`: other programs may call the subroutines.
pub(super) fn structure(
    items: &[Item<'_>],
    family: Family,
    shared: bool,
    faults: &mut Faults<'_>,
) -> Structure {
    let mut structure = Structure { dead: vec![false; items.len()], ..Structure::default() };
    routines(items, family, &mut structure, faults);
    let sites = sites(items, &mut structure, faults);
    jumps(items, family, &sites, &mut structure, faults);
    structure.repeated = repeated(items, family, shared, &sites, &structure);
    structure.interlocked = sites.iter().map(|site| site.interlock.is_some()).collect();
    structure
}

fn repeated(
    items: &[Item<'_>],
    family: Family,
    shared: bool,
    sites: &[Site],
    structure: &Structure,
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
    let many: Vec<&Routine> = structure.routines.iter().filter(|routine| !once(routine)).collect();
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

fn routines(
    items: &[Item<'_>],
    family: Family,
    structure: &mut Structure,
    faults: &mut Faults<'_>,
) {
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
                        "write RET before the next SBN",
                        faults,
                    );
                }
                let Some(number) = item.number(family) else {
                    fault(
                        item,
                        Code::Operand,
                        "the number of the subroutine that begins here is not a constant"
                            .to_owned(),
                        "write a constant number, such as SBN(092) 1",
                        faults,
                    );
                    continue;
                };
                if structure.routines.iter().any(|routine| {
                    routine.number == number && routine.global == item.name.starts_with('G')
                }) {
                    fault(
                        item,
                        Code::Twice,
                        format!("subroutine {number} is defined twice"),
                        "give one of the two subroutines a new number",
                        faults,
                    );
                }
                open = Some((at, number));
            }
            "return" => match open.take() {
                Some((begin, number)) => structure.routines.push(Routine {
                    number,
                    begin,
                    end: at,
                    global: items[begin].name.starts_with('G'),
                }),
                None => fault(
                    item,
                    Code::NoRoutine,
                    "this RET is not in a subroutine".to_owned(),
                    "begin the subroutine with SBN",
                    faults,
                ),
            },
            "end" if open.is_none() => {
                structure.end = structure.end.or(Some(at));
            }
            "end" => {}
            _ if open.is_some() => {}
            _ if structure.end.is_some() => structure.dead[at] = true,
            "nothing" => {}
            _ if !structure.routines.is_empty() => misplaced = misplaced.or(Some(at)),
            _ => {}
        }
    }
    if let Some((begin, _)) = open {
        fault(
            &items[begin],
            Code::NoReturn,
            "this subroutine has no RET".to_owned(),
            "write RET at the end of the subroutine",
            faults,
        );
    }
    if let Some(at) = misplaced {
        let help = "move the subroutines to the end of the program, before or after END: the PLC does not run what follows a subroutine";
        fault(
            &items[at],
            Code::BehindSubroutine,
            "this instruction follows a subroutine, so the PLC never runs it".to_owned(),
            help,
            faults,
        );
    }
}

fn sites(items: &[Item<'_>], structure: &mut Structure, faults: &mut Faults<'_>) -> Vec<Site> {
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
                        "this MILC does not end an open interlock, or not the innermost one"
                            .to_owned(),
                        "end interlocks in the reverse order of their beginning",
                        faults,
                    );
                }
            }
            "next" => match site.loops.pop() {
                Some(begin) => {
                    structure.targets.insert(begin, at);
                }
                None => fault(
                    item,
                    Code::Loop,
                    "this NEXT has no FOR before it".to_owned(),
                    "begin the loop with FOR",
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
        match sites[at].loops.last().and_then(|begin| structure.targets.get(begin)) {
            Some(&next) => {
                structure.targets.insert(at, next);
            }
            None => fault(
                item,
                Code::Loop,
                "this BREAK is outside a loop".to_owned(),
                "put the instruction between FOR and NEXT",
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
    structure: &mut Structure,
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
                "the jump number is not a constant, so its target is unknown".to_owned(),
                "write a constant number, such as JMP(004) #1",
                faults,
            );
            continue;
        };
        let wanted = if zero { "jump-zero-end" } else { "jump-end" };
        let lands = |other: &Item<'_>| {
            other.meaning() == wanted && (zero || other.number(family) == Some(number))
        };
        let same = |other: usize| sites[other].routine == sites[at].routine;
        // If several JMEs have the number, the CPU jumps to the first one in the program.
        let first = (0..items.len()).find(|&other| lands(&items[other])).filter(|_| number != 0);
        if first
            .is_some_and(|first| first < at && (at..items.len()).any(|other| lands(&items[other])))
        {
            let message = format!(
                "several JMEs have the number {number}, and this jump leads back to the first one"
            );
            let help = "give each JMP and its JME a different number";
            fault(item, Code::Jump, message, help, faults);
            continue;
        }
        let Some(target) = (at + 1..items.len()).find(|&other| lands(&items[other]) && same(other))
        else {
            let before = (0..at).any(|other| lands(&items[other]) && same(other));
            let (message, help) = if before {
                (
                    "this jump leads back",
                    "write the loop with FOR and NEXT: a jump back repeats until its condition changes, perhaps without end",
                )
            } else {
                (
                    "no JME with the number of this jump comes after it in the same subroutine or main program",
                    "add a JME with this number after the jump, or correct the number of the jump",
                )
            };
            fault(item, Code::Jump, message.to_owned(), help, faults);
            continue;
        };
        if sites[target].interlock != sites[at].interlock {
            fault(
                item,
                Code::Jump,
                "this jump leads into or out of an interlock (IL to ILC, or MILH or MILR to MILC)"
                    .to_owned(),
                "put the jump and its JME inside the same interlock, or both outside of interlocks",
                faults,
            );
        }
        if !sites[at].loops.starts_with(&sites[target].loops) {
            fault(
                item,
                Code::Jump,
                "this jump leads into a loop between FOR and NEXT".to_owned(),
                "put the jump and its JME inside the same loop, or both outside of loops",
                faults,
            );
        }
        structure.targets.insert(at, target);
    }
}
