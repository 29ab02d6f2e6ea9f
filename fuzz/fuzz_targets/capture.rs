//! Reads measurements: nothing may panic.
#![no_main]

use scanbound::measured::capture::{Selection, read};

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let _ = read("capture.csv", bytes, &Selection::default());
});
