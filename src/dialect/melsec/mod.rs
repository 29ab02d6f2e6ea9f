//! The MELSEC dialects: GX Works2 and GX Works3 CSV exports, and list text.

pub mod source;
