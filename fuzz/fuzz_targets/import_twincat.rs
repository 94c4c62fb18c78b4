#![no_main]

#[path = "../../crates/sim/tests/it/import_checks.rs"]
mod import_checks;

libfuzzer_sys::fuzz_target!(|data: &[u8]| import_checks::many("twincat", data));
