//! The known name that a mistyped one was likely to mean.

/// Names of fewer characters are not guessed at: too many others are near.
const SHORTEST: usize = 3;

/// The nearest of the known names: few characters are changed, left out, added, or swapped with the next. Of equally near
/// ones, one of the same characters in another order.
pub fn nearest(wrong: &str, known: impl IntoIterator<Item = String>) -> Option<String> {
    let wrong = wrong.trim().to_uppercase();
    let length = wrong.chars().count();
    let most = if length < 2 * SHORTEST { 1 } else { 2 };
    let ranked = known.into_iter().filter_map(|name| {
        let upper = name.to_uppercase();
        let far = upper.chars().count().abs_diff(length);
        let distance =
            (length >= SHORTEST && far <= most).then(|| strsim::osa_distance(&wrong, &upper))?;
        (1..=most).contains(&distance).then(|| (distance, !is_reordered(&wrong, &upper), name))
    });
    ranked.min().map(|(_, _, name)| name)
}

/// Whether two names are made of the same characters.
pub fn is_reordered(one: &str, other: &str) -> bool {
    let sorted = |name: &str| {
        let mut all: Vec<char> = name.to_uppercase().chars().collect();
        all.sort_unstable();
        all
    };
    sorted(one) == sorted(other)
}

/// A help, headed by the name that was likely meant, if there is one.
#[must_use]
pub fn meant(near: Option<String>, help: &str) -> String {
    near.map_or(String::new(), |name| format!("did you mean {name}? ")) + help
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_nearest_is_a_slip_of_the_pen_away() {
        let near =
            |wrong: &str, known: &[&str]| nearest(wrong, known.iter().map(|&name| name.to_owned()));
        let found = |name: &str| Some(name.to_owned());
        assert_eq!(near("D34742", &["D100", "D37442"]), found("D37442"));
        // Digits that changed places come before a digit that is another.
        assert_eq!(near("D34742", &["D34743", "D37442"]), found("D37442"));
        assert_eq!(near("D34742", &["D34743", "D37743"]), found("D34743"));
        assert_eq!(near("Q26UVD", &["Q26UDH", "Q26UDV"]), found("Q26UDV"));
        assert_eq!(near("d1o0", &["D100"]), found("D100"));
        // Nothing is near what is short, and nothing is meant by its own name.
        assert_eq!(near("D1", &["D2", "M1"]), None);
        assert_eq!(near("D100", &["D100", "W7000"]), None);
        assert!(is_reordered("Q26UVD", "q26udv") && !is_reordered("Q26UDH", "Q26UDV"));
    }
}
