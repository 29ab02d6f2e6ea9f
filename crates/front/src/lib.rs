//! What a front is (the traits), and what all fronts share.
//!
//! A front reads the dialects of one kind of PLC and lowers their programs to a [`Program`](scanbound_ir::Program),
//! which does not show which front made it.

pub mod absent;
pub mod builder;
pub mod catalog;
pub mod encoding;
pub mod example;
pub mod faults;
mod foreign;
mod front;
mod input;
pub mod numbering;
mod place;
mod registry;
pub mod text;

pub use encoding::Named as Encoding;
pub use example::{Example, ExampleForm, Examples};
pub use faults::Faults;
pub use faults::shown;
pub use front::{Dialect, Front, MachineOptions, Options, Project, Sniff, SourceOptions, stopped};
pub use input::Input;
pub use place::WordPositions;
pub use place::{Caret, operand_spans, slice_range};
pub use registry::{FileKind, Fronts};
pub use text::stem;
pub use text::{BEGINNING, decoded, empty_comment_files};
