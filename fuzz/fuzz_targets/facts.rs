//! Reads facts: nothing may panic.
#![no_main]

libfuzzer_sys::fuzz_target!(|text: &str| {
    let _ = scanbound::base::facts::Facts::parse("facts.toml", text);
});
