//! Suggests the known name that a mistyped name was probably meant to be.

/// For names with fewer characters nothing is suggested, because too many other names are similar.
const SHORTEST: usize = 3;

/// The most similar known name, at most two edits away, or one edit if `wrong` has fewer than six characters. An edit
/// is a character changed, removed, added, or swapped with the next. Letter case is ignored. Among equally similar
/// names, one with the same characters in another order comes first. A name that differs in letter case alone is not
/// suggested. `None` if no known name is that similar, or `wrong` has fewer than three characters.
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

/// Whether two names consist of the same characters, in any order and letter case.
pub fn is_reordered(one: &str, other: &str) -> bool {
    let sorted = |name: &str| {
        let mut all: Vec<char> = name.to_uppercase().chars().collect();
        all.sort_unstable();
        all
    };
    sorted(one) == sorted(other)
}

/// The help text, preceded by "did you mean NAME?" if there is a similar name.
#[must_use]
pub fn with_suggestion(near: Option<String>, help: &str) -> String {
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
        // Two swapped digits are more probable than one wrong digit.
        assert_eq!(near("D34742", &["D34743", "D37442"]), found("D37442"));
        assert_eq!(near("D34742", &["D34743", "D37743"]), found("D34743"));
        assert_eq!(near("Q26UVD", &["Q26UDH", "Q26UDV"]), found("Q26UDV"));
        assert_eq!(near("d1o0", &["D100"]), found("D100"));
        // Short names get no suggestion, and a correct name does not suggest itself.
        assert_eq!(near("D1", &["D2", "M1"]), None);
        assert_eq!(near("D100", &["D100", "W7000"]), None);
        assert!(is_reordered("Q26UVD", "q26udv") && !is_reordered("Q26UDH", "Q26UDV"));
    }
}
