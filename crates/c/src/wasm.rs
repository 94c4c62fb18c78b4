//! Memory for JavaScript, whose own the library cannot see.

use std::alloc::{Layout, alloc_zeroed, dealloc};

/// Alignment of what is made: that of the largest field of any structure.
const ALIGNMENT: usize = 8;

/// Zeroed room of so many bytes, for structures, texts and lists; null where there is none.
#[unsafe(no_mangle)]
pub extern "C" fn lm_memory(bytes: usize) -> *mut u8 {
    match Layout::from_size_align(bytes.max(1), ALIGNMENT) {
        // SAFETY: the size is not zero.
        Ok(layout) => unsafe { alloc_zeroed(layout) },
        Err(_) => std::ptr::null_mut(),
    }
}

/// Gives such room back.
///
/// # Safety
/// `memory` is null or what `lm_memory` gave for as many bytes, given back once.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lm_memory_free(memory: *mut u8, bytes: usize) {
    if memory.is_null() {
        return;
    }
    if let Ok(layout) = Layout::from_size_align(bytes.max(1), ALIGNMENT) {
        // SAFETY: the caller's promise; the layout is the one that it was made with.
        unsafe { dealloc(memory, layout) };
    }
}
