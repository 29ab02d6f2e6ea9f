//! Reads timing tables: nothing may panic.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let _ = scanbound::timing::table::Table::parse("table.csv", bytes);
});
