//! Compares the searches with each other, with brute force, and with Z3 on exported problems.

use super::testing::{Builder, Dice, brute, random, sound};
use super::{HAS_Z3, Limits, Method, Opinion, Problem, export, maximum, second_opinion};
use scanbound_base::time::Picos;
use scanbound_model::{Atom, Group, Lit, ScanModel, VarKind};
use std::io::Write;
use std::process::{Command, Stdio};

/// A model of medium size: chains of relays, step numbers, interlocks, and charges on all of them.
fn medium(seed: u64) -> ScanModel {
    let mut dice = Dice(seed);
    let mut b = Builder::default();
    let mut pool: Vec<Lit> = (0..4 + dice.below(8)).map(|_| b.bit()).collect();
    let mut steps = Vec::new();
    for _ in 0..1 + dice.below(4) {
        let word = b.variable(VarKind::Word);
        for step in 0..2 + dice.below(8) as u16 {
            steps.push(b.equals(word, 10 * step));
        }
        if dice.one_in(3) {
            pool.push(b.model.circuit.atom(Atom::WordBit(word, dice.below(6) as u8)));
        }
        if dice.one_in(3) {
            pool.push(b.model.circuit.atom(Atom::AtLeast(word, 1 + dice.below(90) as u16)));
        }
    }
    let pick = |dice: &mut Dice, pool: &[Lit]| {
        let lit = pool[dice.below(pool.len() as u64) as usize];
        if dice.one_in(2) { !lit } else { lit }
    };
    for _ in 0..dice.below(40) {
        let (x, y, z) = (pick(&mut dice, &pool), pick(&mut dice, &pool), pick(&mut dice, &pool));
        let circuit = &mut b.model.circuit;
        pool.push(match dice.below(5) {
            0 => circuit.ite(x, y, z),
            1 => circuit.xor(x, y),
            2 => circuit.or(x, y),
            _ => circuit.and(x, y),
        });
    }
    for _ in 0..10 + dice.below(40) {
        let guard = pick(&mut dice, &pool);
        let condition = match dice.below(3) {
            0 => pick(&mut dice, &pool),
            _ => steps[dice.below(steps.len() as u64) as usize],
        };
        let condition = b.model.circuit.and(guard, condition);
        let reached = if dice.one_in(4) { pick(&mut dice, &pool) } else { Lit::TRUE };
        // A few equal times give ties; times over four orders of magnitude do not.
        let on = [10, 1 + dice.below(50), 1_000 * dice.below(400)][dice.below(3) as usize];
        let off = if dice.one_in(2) { 0 } else { dice.below(2_000) };
        b.charge(reached, condition, on, off);
    }
    b.model
}

/// The maximum by every search method; all must agree.
fn agreed(model: &ScanModel, group: &Group, seed: u64) -> Picos {
    let limits = Limits::default();
    let by = [Method::Cores, Method::Auto, Method::Subsets].map(|method| {
        let found = maximum(model, group, method, &limits);
        sound(model, group, &found);
        assert_eq!(found.lower, found.upper, "seed {seed}: {method:?} is not exact");
        found
    });
    assert!(by.iter().all(|found| found.upper == by[0].upper), "seed {seed}: {by:?}");
    // Which of several longest scans is found, and the number of queries, are the same in every run.
    assert_eq!(maximum(model, group, Method::Auto, &limits), by[1], "seed {seed}");
    let opinion = second_opinion(model, group, &by[1], &limits);
    let expected = if HAS_Z3 { Opinion::Confirmed } else { Opinion::NoSolver };
    assert_eq!(opinion, Ok(expected), "seed {seed}");
    by[0].upper
}

/// The number of cases: the standard number times SCANBOUND_CASES.
fn cases(standard: u64) -> u64 {
    let factor = std::env::var("SCANBOUND_CASES").ok().and_then(|text| text.parse::<u64>().ok());
    standard * factor.unwrap_or(1)
}

/// The maximum of an exported group according to the `z3` binary.
fn exported(model: &ScanModel, group: &Group) -> Picos {
    let text = export::smt2(model, group, &|charge| format!("charge {charge}"));
    let mut z3 = Command::new("z3")
        .arg("-in")
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .expect("the z3 binary runs (Debian's package z3)");
    z3.stdin.take().expect("a pipe").write_all(text.as_bytes()).expect("written");
    let answer = z3.wait_with_output().expect("it ends");
    let answer = String::from_utf8_lossy(&answer.stdout).into_owned();
    // (objectives\n (scan 123)\n)
    let objective = answer.split_once("(scan ").and_then(|(_, rest)| rest.split_once(')'));
    let lost: u64 = objective.map_or("0", |(lost, _)| lost.trim()).parse().expect(&answer);
    Picos(Problem::new(model, group).naive() - lost)
}

#[test]
fn all_searches_agree_on_medium_groups() {
    for seed in 0..cases(8) {
        let model = medium(40_000 + seed);
        let group = Builder { model: model.clone() }.group();
        let most = agreed(&model, &group, seed);
        if seed % 4 == 0 {
            assert_eq!(exported(&model, &group), most, "seed {seed}");
        }
    }
}

#[test]
fn all_searches_agree_with_trying_everything() {
    for seed in 0..cases(24) {
        let model = random(80_000 + seed, 5 + seed % 70);
        let group = Builder { model: model.clone() }.group();
        let most = agreed(&model, &group, seed);
        assert_eq!(Some(most), brute(&model, &group), "seed {seed}");
        if seed % 8 == 0 && !group.charges.is_empty() {
            assert_eq!(exported(&model, &group), most, "seed {seed}");
        }
    }
}
