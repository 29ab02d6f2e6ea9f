//! The examples of the library, each run on its sample.

#[allow(dead_code)] // its `main`
#[path = "../../examples/bound.rs"]
mod bound;
#[allow(dead_code)] // its `main`
#[path = "../../examples/check.rs"]
mod check;

#[test]
fn the_example_of_a_bound_tells_both_bounds() {
    let answer = bound::bound(&["samples/sfc/line.st".to_owned()]).expect("a bound");
    let (lower, upper) = answer.split_once(", bound: ").expect("both bounds");
    // What controllers do differently in this chart is not stated.
    assert_eq!((lower, upper), ("longest scan found: 63.6 us", "71.6 us"));
}

#[test]
fn the_example_of_a_check_has_the_codes_of_the_command() {
    let code = |limit| check::check("samples/transfer-line/line.il", limit).expect("a verdict").1;
    assert_eq!((code("1s"), code("1ns")), (0, 1));
}
