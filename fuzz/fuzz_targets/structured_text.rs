//! Reads IEC 61131-3 texts: nothing may panic.
#![no_main]

mod common;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| common::read("main.st", bytes, Some("iec-text")));
