//! Reads instruction lists of every dialect: nothing may panic.
#![no_main]

mod common;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| common::read("main.il", bytes, None));
