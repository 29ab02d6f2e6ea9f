//! Rungs as they are drawn say what the instruction list says.

use common::melsec::decoded;
use scanbound::base::facts::Facts;
use scanbound::front::melsec::memory::Family;
use scanbound::program::Program;
use scanbound::program::ladder::{Drawing, Rung, Symbol, rungs};
use scanbound::report::ladder::draw;
use std::collections::BTreeMap;

fn program(text: &str) -> Program {
    let text = text.replace("; ", "\n") + "\n";
    decoded(Family::Q, &[("a.il", &text)], &Facts::default()).expect("a program")
}

/// What stands before what is driven, with `*` for a series and `+` for branches.
fn told(text: &str) -> Vec<String> {
    let program = program(text);
    let of = |rung: &Rung| {
        let paths = rung.paths.iter().enumerate();
        let driven = paths.flat_map(|(path, one)| one.driven.iter().map(move |&one| (one, path)));
        let mut driven: Vec<(usize, usize)> = driven.collect();
        driven.sort_unstable();
        let text = |(element, path): (usize, usize)| {
            format!("{} -> {}", conditions(rung, path), rung.elements[element].text)
        };
        driven.into_iter().map(text).collect::<Vec<String>>()
    };
    rungs(&program).iter().flat_map(of).collect()
}

/// All conditions from the left rail to a path's end.
fn conditions(rung: &Rung, path: usize) -> String {
    let own = drawing(rung, &rung.paths[path].conditions);
    match rung.paths[path].from {
        Some(from) => format!("{} * {own}", conditions(rung, from)),
        None => own,
    }
}

fn drawing(rung: &Rung, drawn: &Drawing) -> String {
    let all = |all: &[Drawing], sign: &str| {
        all.iter().map(|one| drawing(rung, one)).collect::<Vec<_>>().join(sign)
    };
    match drawn {
        Drawing::One(element) => {
            let one = &rung.elements[*element];
            let sign = if one.symbol == Symbol::Negated { "!" } else { "" };
            format!("{sign}{}", one.label())
        }
        Drawing::Series(drawn) => all(drawn, " * "),
        Drawing::Parallel(drawn) => format!("({})", all(drawn, " + ")),
    }
}

#[test]
fn lists_become_contacts_in_series_and_in_parallel() {
    assert_eq!(told("LD X0; AND X1; OUT Y0; END"), ["X0 * X1 -> OUT Y0", " -> END"]);
    assert_eq!(told("LD X0; OR X1; ANI X2; OUT Y0; END")[0], "(X0 + X1) * !X2 -> OUT Y0");
    let blocks = "LD X0; AND X1; LD X2; ANI X3; ORB; LD X4; OR X5; ANB; SET Y0; END";
    assert_eq!(told(blocks)[0], "(X0 * X1 + X2 * !X3) * (X4 + X5) -> SET Y0");
    let three = "LD X0; OR X1; OR X2; OUT Y0; END";
    assert_eq!(told(three)[0], "(X0 + X1 + X2) -> OUT Y0");
    assert_eq!(
        told("LD X0; OUT Y0; AND X1; OUT Y1; END"),
        ["X0 -> OUT Y0", "X0 * X1 -> OUT Y1", " -> END"]
    );
    assert_eq!(told("LD= D0 K3; MOV K1 D1; END")[0], "LD= D0 K3 -> MOV K1 D1");
}

#[test]
fn branches_start_where_results_were_saved() {
    let text = "LD X0; MPS; AND X1; OUT Y0; MRD; LD X2; OR X3; ANB; OUT Y1; MPP; OUT Y2; END";
    assert_eq!(told(text)[..3], ["X0 * X1 -> OUT Y0", "X0 * (X2 + X3) -> OUT Y1", "X0 -> OUT Y2"]);
    let nested =
        "LD X0; MPS; AND X1; MPS; AND X2; OUT Y0; MPP; ANI X2; OUT Y1; MPP; AND X3; OUT Y2; END";
    assert_eq!(
        told(nested)[..3],
        ["X0 * X1 * X2 -> OUT Y0", "X0 * X1 * !X2 -> OUT Y1", "X0 * X3 -> OUT Y2"]
    );
}

/// Whether what is drawn conducts.
fn conducts(rung: &Rung, drawn: &Drawing, on: &BTreeMap<String, bool>) -> bool {
    match drawn {
        Drawing::One(element) => {
            let one = &rung.elements[*element];
            on[one.label()] != (one.symbol == Symbol::Negated)
        }
        Drawing::Series(all) => all.iter().all(|one| conducts(rung, one, on)),
        Drawing::Parallel(all) => all.iter().any(|one| conducts(rung, one, on)),
    }
}

fn path_conducts(rung: &Rung, path: usize, on: &BTreeMap<String, bool>) -> bool {
    let one = &rung.paths[path];
    one.from.is_none_or(|from| path_conducts(rung, from, on)) && conducts(rung, &one.conditions, on)
}

/// The outputs that a list switches on, worked out from its text alone.
fn by_list(lines: &[String], on: &BTreeMap<String, bool>) -> BTreeMap<String, bool> {
    let (mut stack, mut saved, mut outputs) = (Vec::new(), Vec::new(), BTreeMap::new());
    for line in lines {
        let mut words = line.split(' ');
        let (name, device) = (words.next().expect("a name"), words.next().unwrap_or(""));
        let value = on.get(device).copied().unwrap_or(false);
        match name {
            "LD" => stack.push(value),
            "LDI" => stack.push(!value),
            "OUT" => _ = outputs.insert(device.to_owned(), *stack.last().expect("a result")),
            "MPS" => saved.push(*stack.last().expect("a result")),
            "MRD" => *stack.last_mut().expect("a result") = *saved.last().expect("saved"),
            "MPP" => *stack.last_mut().expect("a result") = saved.pop().expect("saved"),
            _ => {
                let last = if name.ends_with('B') {
                    stack.pop().expect("two results")
                } else {
                    value != name.ends_with('I')
                };
                let top = stack.last_mut().expect("a result");
                *top = if name.starts_with("AN") { *top && last } else { *top || last };
            }
        }
    }
    outputs
}

#[test]
fn what_is_drawn_conducts_where_the_list_switches_on() {
    let mut seed = 7u64;
    let mut random = move |below: u64| {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (seed >> 33) % below
    };
    let (mut outputs, mut branches) = (0, 0);
    for _ in 0..400 {
        let mut lines = vec![format!("LD X{}", random(5))];
        let (mut depth, mut saved, mut coils) = (1, 0, 0);
        for _ in 0..random(14) {
            let x = random(5);
            let line = match random(10) {
                0 | 1 => format!("AND X{x}"),
                2 => format!("ANI X{x}"),
                3 | 4 => format!("OR X{x}"),
                5 if depth < 4 => {
                    depth += 1;
                    format!("LDI X{x}")
                }
                6 if depth > 1 => {
                    depth -= 1;
                    ["ANB", "ORB"][random(2) as usize].to_owned()
                }
                7 if depth == 1 && saved < 3 => {
                    saved += 1;
                    "MPS".to_owned()
                }
                8 if depth == 1 && saved > 0 => "MRD".to_owned(),
                9 if depth == 1 => {
                    coils += 1;
                    format!("OUT Y{coils}")
                }
                _ => format!("ORI X{x}"),
            };
            lines.push(line);
        }
        for _ in 1..depth {
            lines.push("ANB".to_owned());
        }
        coils += 1;
        lines.push(format!("OUT Y{coils}"));
        for _ in 0..saved {
            coils += 1;
            lines.extend(["MPP".to_owned(), format!("OUT Y{coils}")]);
        }
        let program = program(&(lines.join("; ") + "; END"));
        let all = rungs(&program);
        for bits in 0..32u32 {
            let on: BTreeMap<String, bool> =
                (0..5).map(|x| (format!("X{x}"), bits >> x & 1 == 1)).collect();
            let mut drawn = BTreeMap::new();
            for rung in &all[..all.len() - 1] {
                for (path, one) in rung.paths.iter().enumerate() {
                    for &element in &one.driven {
                        drawn.insert(
                            rung.elements[element].label().to_owned(),
                            path_conducts(rung, path, &on),
                        );
                    }
                }
            }
            assert_eq!(drawn, by_list(&lines, &on), "{lines:?} {bits:05b}");
        }
        outputs += coils;
        branches += saved;
    }
    assert!(outputs > 500 && branches > 50, "{outputs} {branches}");
}

#[test]
fn a_rung_is_drawn_in_text() {
    let program = program("LD X0; OR M0; ANI X1; OUT M0; MPS; AND X2; SET Y5; MPP; MOV K1 D0; END");
    let rung = &rungs(&program)[0];
    let text = draw(rung, &|element| rung.elements[element].label().to_owned());
    insta::assert_snapshot!(text);
}
