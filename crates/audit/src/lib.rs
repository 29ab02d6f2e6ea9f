//! Audits a project: runs all stages from its files to an [`Audit`], in which everything that a report shows is already
//! computed.

pub mod advise;
mod assemble;
mod assumption;
mod audit;
pub mod breakdown;
#[cfg(test)]
mod charge_tests;
mod coactivity;
mod condition;
mod confirmed;
mod contradiction;
mod counts;
pub mod cpus;
mod cycle;
mod deciding;
pub mod difference;
pub mod doctor;
mod doubt;
mod drawn;
mod due;
mod exactness;
mod exclusive_relays;
mod executed;
pub mod explain;
mod fact;
mod failure;
#[cfg(any(test, feature = "testing"))]
pub mod fixture;
mod hints;
mod indices;
pub mod intervals;
mod invariants;
mod iterations;
pub mod ladder;
mod lag;
pub mod method;
mod model_search;
mod modelling;
mod names;
pub mod net;
pub mod offer;
mod parts;
mod pipeline;
mod power_up;
mod priced;
mod proved;
mod questions;
mod reachable;
mod real;
mod reason;
mod refinement;
mod related_relays;
mod request;
mod requested;
pub mod response;
mod restarted;
mod rung;
mod search;
mod solved_bound;
mod sources;
mod start_changes;
mod start_states;
mod stated;
mod steering;
#[cfg(test)]
mod steering_tests;
mod stretch;
mod table_use;
mod tasks;
mod timer_edges;
mod timers;
mod unbounded;
mod understood;
mod unknown;
mod unknown_writes;
pub mod verdict;
mod violations;
mod watchdog;
mod weight;
mod what_if;
mod worked_back;

pub use audit::Audit;
pub use coactivity::coactivity;
pub use cycle::{Cycle, SettingUse, Stretch, WaitingScan, Watchdog};
pub use doubt::Doubt;
pub use exactness::{Construct, Exactness, InexactUse, LanguageUse};
pub use fact::{Fact, Status};
pub use failure::Failure;
pub use names::comments_in;
pub use net::net_bound;
pub use parts::{
    ApproximationUse, AssumedUse, Bound, ChargeUse, Exclusion, FactorUse, Fate, FreeValue,
    GroupUse, LoopUse, NetworkUse, OverheadUse, PathStep, RunScan, RungUse, Share, TableUse, Tie,
    Value,
};
pub use pipeline::{
    Concluded, Followed, PreparedProject, Ready, audit, conclude, concluded, follow, read, ready,
};
pub use questions::{File, QuestionFormat, certificates, question};
pub use reason::Reason;
pub use request::{Progress, Request};
pub use requested::{Coactivity, InternalDevices, LimitedCount, Minor, NetBound, TaskUse, WhatIf};
pub use solved_bound::SolvedBound;
pub use tasks::tasks;

pub use assumption::Assumption;
pub use scanbound_ir::{Approximated, SummaryReason};
pub use scanbound_solve::{Engine, Opinion, SUBSET_SOLVER};
pub use scanbound_timing::price::{MorePoints, UnstatedBase, UnstatedPoints};
pub use scanbound_timing::table::Evidence;
pub use sources::{Source, SourceKind};
pub use unknown::{Counts, Unknown, UnknownKind};
pub use what_if::{what_if, what_if_offered};
