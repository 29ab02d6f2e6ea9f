//! Sound worst-case scan times of PLC programs.
//!
//! The stages, each in its own module: a [`front`] reads source text into a [`program::Program`]; the [`passes`]
//! process it in the same way for every dialect; [`timing`] gives every instruction its times from a table; [`scan`]
//! executes one scan symbolically into a [`scan::model::ScanModel`] and divides it into groups; [`solve`] finds each
//! group's maximum; [`replay`] checks each witness. [`audit`](mod@audit) calls all of these and compares the result
//! with a limit; [`measured`] compares it with measurements; [`report`] shows it. [`minasec`] emulates one machine,
//! [`emulated`] a CPU that runs any program with a table's times; [`link`] communicates with PLCs; [`iec`] reads the
//! languages of IEC 61131-3 and analyses their charts, using Petri nets ([`net`]); all of them use [`base`].
//! `docs/glossary.md` explains the terms.
//!
//! # Examples
//!
//! ```
//! let program = "LD X0\nMOV K1 D0\nLDI X0\nMOV K2 D1\nEND\n";
//! let report = scanbound::Analysis::new().file("main.il", program).cpu("Q26UDV").run()?;
//! println!("no scan takes longer than {}", report.upper());
//! # Ok::<(), scanbound::Error>(())
//! ```

mod analysis;

pub use analysis::{Analysis, Error, Report};
pub use scanbound_audit as audit;
pub use scanbound_base as base;
pub use scanbound_iec as iec;
pub use scanbound_ir as program;
pub use scanbound_link as link;
pub use scanbound_measured as measured;
pub use scanbound_nets as net;
pub use scanbound_passes as passes;
pub use scanbound_plant::{calibrate, emulated, minasec, simulation};
pub use scanbound_replay as replay;
pub use scanbound_report as report;
pub use scanbound_snet as snet;
pub use scanbound_solve as solve;
pub use scanbound_timing as timing;

/// Fronts: each reads the dialects of one kind of PLC and defines the meaning of their programs.
pub mod front {
    pub use scanbound_front::*;
    pub use scanbound_front_flowchart as flowchart;
    pub use scanbound_front_iec as iec;
    pub use scanbound_front_melsec as melsec;
    pub use scanbound_front_minasec as minasec;
    pub use scanbound_front_omron as omron;
    pub use scanbound_fronts::{FRONTS, detect, input, read};
}

/// Executes one scan symbolically into a model, and divides it into groups.
pub mod scan {
    pub use scanbound_model as model;
    pub use scanbound_model::groups;
    pub use scanbound_scan::*;
}
