//! The C interface of lostmotion: values of the library as C's, and nothing else. Users read
//! `include/lostmotion.h`, which is made from these files, and the book's chapters on C and on
//! embedding.
//!
//! Every function checks what it is given before it looks at it ([`border`]), and answers a status;
//! what went wrong is kept for the thread ([`error`]). What C holds are handles, which are looked up
//! and never followed ([`handle`]).

pub mod axis;
mod border;
pub mod compensator;
pub mod error;
pub mod failure;
#[cfg(feature = "fit")]
pub mod fit;
mod handle;
pub mod machine;
mod planned;
pub mod program;
pub mod reading;
pub mod rows;
pub mod run;
pub mod simulation;
#[cfg(test)]
mod tests;
pub mod text;
#[cfg(feature = "wasm")]
pub mod wasm;

use std::ffi::{CStr, c_char};

/// Version of the interface; it rises where a program that was compiled with an older header would
/// break.
pub const LM_ABI: u32 = 1;

/// The version of the library with a zero at its end.
const VERSION: &CStr =
    match CStr::from_bytes_with_nul(concat!(env!("CARGO_PKG_VERSION"), "\0").as_bytes()) {
        Ok(text) => text,
        Err(_) => c"",
    };

/// Version of the library, for example "0.1.0".
///
/// Threads: any. Real time: yes.
#[unsafe(no_mangle)]
pub extern "C" fn lm_version() -> *const c_char {
    VERSION.as_ptr()
}

/// Version of the interface of the library at hand: equal to `LM_ABI` of the header, or the two do
/// not fit.
///
/// Threads: any. Real time: yes.
#[unsafe(no_mangle)]
pub extern "C" fn lm_abi() -> u32 {
    LM_ABI
}

/// Handles that were made and not freed: 0 at the end of a program that frees all.
///
/// Threads: any. Real time: yes.
#[unsafe(no_mangle)]
pub extern "C" fn lm_handles() -> usize {
    handle::alive()
}
