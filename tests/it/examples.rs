//! The examples of the library, each run on its sample.

#[allow(dead_code)] // its `main`
#[path = "../../examples/bound.rs"]
mod bound;
#[allow(dead_code)] // its `main`
#[path = "../../examples/check.rs"]
mod check;

#[test]
fn the_example_of_a_bound_finds_the_longest_scan() {
    let answer = bound::bound(&["samples/sfc/line.st".to_owned()]).expect("a bound");
    let (lower, upper) = answer.split_once(", bound: ").expect("both bounds");
    assert_eq!(lower.strip_prefix("longest scan found: "), Some(upper));
}

#[test]
fn the_example_of_a_check_has_the_codes_of_the_command() {
    let code = |limit| check::check("samples/transfer-line/line.il", limit).expect("a verdict").1;
    assert_eq!((code("1s"), code("1ns")), (0, 1));
}
