//! Reads PLCopen XML: nothing may panic.
#![no_main]

mod common;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| common::read("plc.xml", bytes, Some("plcopen-xml")));
