//! Reads CSV exports of MELSEC programs: nothing may panic.
#![no_main]

mod common;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| common::read("MAIN.csv", bytes, Some("melsec-csv")));
