//! Drawings (FBD, LD, charts in XML), and bodies that no front reads.
