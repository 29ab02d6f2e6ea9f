//! What the targets that read programs share.

use scanbound::base::facts::Facts;
use scanbound::front::{self, Input, Options};

/// Reads and decodes one file.
pub fn read(name: &str, bytes: &[u8], dialect: Option<&str>) {
    let inputs = [Input { name: name.to_owned(), bytes: bytes.to_vec() }];
    let facts = Facts::default();
    if let Ok(project) = front::read(&inputs, dialect) {
        let _ = project.decode(&Options::new(&facts));
    }
}
