//! Sound worst-case scan times of PLC programs.
//!
//! The road, a room a stage: a [`front`] reads source text into a [`program::Program`]; [`passes`] make of it what is the
//! same for every dialect; [`timing`] gives every instruction its times from a table; [`scan`] executes one scan symbolically, yields a
//! [`scan::model::ScanModel`], and slices it into groups; [`solve`] finds each group's maximum; [`replay`] checks
//! each witness. [`audit`](mod@audit) is all that as one call, and holds its result against a limit; [`measured`] holds
//! it against measurements; [`report`] shows it. [`minasec`] emulates one machine, [`emulated`] a CPU that runs any
//! program by a table's times; [`link`] talks with PLCs; [`iec`] reads the languages of IEC 61131-3 and studies their
//! charts, on Petri nets ([`net`]); [`base`] is what all stand on.
//! `docs/glossary.md` explains the terms.
//!
//! # Examples
//!
//! The longest scan of a program, in picoseconds:
//!
//! ```
//! use scanbound::audit::{Request, audit};
//! use scanbound::base::facts::Facts;
//! use scanbound::front::Input;
//! use scanbound::timing::table::parse_override;
//!
//! let text = "LD X0\nMOV K1 D0\nLDI X0\nMOV K2 D1\nEND\n";
//! let inputs = [Input { name: "main.il".into(), bytes: text.into() }];
//! let facts = Facts::default();
//! let times = [parse_override("MOV=1.5us/0.3us").expect("a right price")];
//! let request = Request { cpu: Some("Q26UDV"), times: &times, ..Request::new(&inputs, &facts) };
//! let found = audit(&request)?;
//! // The two moves exclude each other, and the bound knows.
//! assert!(found.bound.exact() && found.bound.upper < found.bound.naive);
//! # Ok::<(), scanbound::audit::Failure>(())
//! ```

pub mod audit;
pub mod base;
pub mod calibrate;
pub mod emulated;
pub mod front;
pub mod iec;
pub mod link;
pub mod measured;
pub mod minasec;
pub mod net;
pub mod passes;
pub mod program;
pub mod replay;
pub mod report;
pub mod scan;
pub mod snet;
pub mod solve;
pub mod timing;
