//! Diagnostics as terminal text: the message, the line it is about with the fault underlined, and what to do.

use super::wrap;
use annotate_snippets::{AnnotationKind, Group, Level, Origin, Renderer, Snippet};
use scanbound_base::diagnostic::{Diagnostic, Severity};

/// The longest piece of a line that is shown, in characters.
const WINDOW: usize = 160;

/// What stands in front of a help's lines, with a line number of four digits.
const BEFORE_HELP: usize = 14;

/// The diagnostics one after another, with colour codes (`anstream` takes them off where they are not wanted); what is
/// said is no wider than the page, if one is given.
#[must_use]
pub fn diagnostics(found: &[Diagnostic], width: Option<usize>) -> String {
    let shown: Vec<String> = found.iter().map(|one| diagnostic(one, width) + "\n").collect();
    shown.join("\n")
}

fn diagnostic(found: &Diagnostic, width: Option<usize>) -> String {
    let fitted = |text: &str, before: usize| match width {
        Some(width) => wrap::lines(text, width.saturating_sub(before)).join("\n"),
        None => text.to_owned(),
    };
    // The level and the code stand in front.
    let message = fitted(&found.message, found.code.name().len() + "warning[]: ".len());
    let help = fitted(&found.help, BEFORE_HELP);
    let level = match found.severity {
        Severity::Error => Level::ERROR,
        Severity::Warning => Level::WARNING,
    };
    let mut group = Group::with_title(level.primary_title(&message).id(found.code.name()));
    let window = Window::of(found);
    if let Some(line) = found.line.filter(|_| !window.text.is_empty()) {
        let mut annotation = AnnotationKind::Primary.span(window.span.clone());
        if let Some(step) = found.step {
            annotation = annotation.label(format!("step {step}"));
        }
        group = group.element(
            Snippet::source(&window.text)
                .line_start(line as usize)
                .path(&found.file)
                .annotation(annotation),
        );
    } else if !found.file.is_empty() {
        let origin = Origin::path(&found.file);
        group = group.element(found.line.map_or(origin.clone(), |line| origin.line(line as usize)));
    }
    if !found.help.is_empty() {
        group = group.element(Level::HELP.message(&help));
    }
    Renderer::styled().render(&[group])
}

/// The part of the line that is shown: all of it, or what surrounds the fault where the line is very long.
struct Window {
    text: String,
    span: std::ops::Range<usize>,
}

impl Window {
    fn of(found: &Diagnostic) -> Window {
        let line = found.text.lines().next().unwrap_or_default();
        let clip = |at: usize| (0..=at.min(line.len())).rev().find(|&i| line.is_char_boundary(i));
        let (from, to) = found
            .span
            .map(|(from, to)| (clip(from).unwrap_or(0), clip(to).unwrap_or(0)))
            .filter(|(from, to)| from < to)
            .unwrap_or((0, line.len()));
        let before = line[..from].chars().count();
        let skipped = before.saturating_sub(WINDOW / 4);
        let mut text: String = line[..from].chars().skip(skipped).collect();
        if skipped > 0 {
            text.insert(0, '…');
        }
        let start = text.len();
        let room = WINDOW.saturating_sub(text.chars().count());
        text.extend(line[from..to].chars().take(room));
        let end = text.len();
        let room = WINDOW.saturating_sub(text.chars().count());
        text.extend(line[to..].chars().take(room));
        if line.chars().count() > skipped + WINDOW {
            text.push('…');
        }
        // Control characters of a garbled file must not reach the terminal, nor move the columns.
        let plain = |piece: &str| -> String {
            piece.chars().map(|c| if c.is_control() { ' ' } else { c }).collect()
        };
        let (head, middle) = (plain(&text[..start]), plain(&text[start..end]));
        let span = head.len()..head.len() + middle.len();
        Window { text: head + &middle + &plain(&text[end..]), span }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use scanbound_base::code::Code;

    fn shown(found: &[Diagnostic]) -> String {
        anstream::adapter::strip_str(&diagnostics(found, None)).to_string()
    }

    #[test]
    fn the_fault_is_underlined_under_japanese_text() {
        let fault = Diagnostic::line(
            Code::UnknownDevice,
            "搬送.csv",
            12,
            "LD 起動 X0G",
            "'X0G' is not a device",
            "X and Y are hexadecimal on this CPU",
        )
        .mark("X0G")
        .at_step(Some(34));
        insta::assert_snapshot!(shown(&[fault]), @r"
        error[unknown-device]: 'X0G' is not a device
          --> 搬送.csv:12:7
           |
        12 | LD 起動 X0G
           |         ^^^ step 34
           |
           = help: X and Y are hexadecimal on this CPU
        ");
    }

    #[test]
    fn faults_of_whole_files_and_lines_without_text_are_shown_too() {
        let whole =
            Diagnostic::file(Code::EmptyFile, "a.il", "the file is empty", "export it again");
        let mut bare = whole.clone().warning();
        bare.line = Some(7);
        insta::assert_snapshot!(shown(&[whole, bare]), @r"
        error[empty-file]: the file is empty
        --> a.il
         = help: export it again

        warning[empty-file]: the file is empty
        --> a.il:7
         = help: export it again
        ");
    }

    #[test]
    fn what_is_said_keeps_to_the_page() {
        let words = "many words ".repeat(20);
        let fault = Diagnostic::line(Code::NotAnInstruction, "a.il", 1234, "FAULT", &words, &words);
        let shown = diagnostics(&[fault], Some(60));
        let shown = anstream::adapter::strip_str(&shown).to_string();
        assert!(shown.lines().all(|line| line.chars().count() <= 60), "{shown}");
        assert_eq!(shown.matches("many words").count() + shown.matches("many\n").count(), 40);
    }

    #[test]
    fn a_very_long_line_is_cut_round_its_fault() {
        let text = format!("{}FAULT{}", "a".repeat(5_000), "\u{7}".repeat(5_000));
        let fault =
            Diagnostic::line(Code::NotAnInstruction, "a.il", 1, text, "m", "h").mark("FAULT");
        let shown = shown(&[fault]);
        assert!(shown.contains("aaFAULT"), "{shown}");
        assert!(shown.lines().all(|line| line.chars().count() < 200), "{shown}");
        assert!(!shown.contains('\u{7}'));
    }
}
