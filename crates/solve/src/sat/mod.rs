//! The SAT solver of the search by subsets: Z3, or BatSat in a build without Z3.

#[cfg(not(feature = "z3"))]
mod batsat;
#[cfg(feature = "z3")]
mod z3;

#[cfg(not(feature = "z3"))]
pub use batsat::{Sat, with_solver};
#[cfg(feature = "z3")]
pub use z3::{Sat, with_solver};
