#![no_main]

#[path = "../../crates/logs/tests/it/checks.rs"]
mod checks;

libfuzzer_sys::fuzz_target!(|data: &[u8]| checks::binary(data));
