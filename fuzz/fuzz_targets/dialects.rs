#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| lostmotion_fuzz::dialects(data));
