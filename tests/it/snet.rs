//! S-nets from the outside: the documentation's nets, the samples.

use scanbound::snet::{faults::faults, text};
use std::fs;
use std::path::Path;

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// The blocks of code of a page that begin so.
fn blocks(page: &str, begin: &str) -> Vec<String> {
    let text = fs::read_to_string(root().join(page)).expect("the page");
    let blocks = text.split("```").skip(1).step_by(2).map(|block| block.trim_start().to_owned());
    blocks.filter(|block| block.starts_with(begin)).collect()
}

#[test]
fn the_documentations_nets_are_right() {
    let nets = blocks("docs/snet.md", "net ");
    assert_eq!(nets.len(), 2);
    for net in nets {
        let diagram = text::read("docs/snet.md", &net).expect("a net");
        assert_eq!(faults(&diagram), [], "{net}");
        let again = text::read("", &text::write(&diagram)).expect("a net again");
        assert_eq!(again.without_lines(), diagram.without_lines());
    }
}
