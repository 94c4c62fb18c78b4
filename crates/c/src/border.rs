//! The border: what C hands in is checked here before anything looks at it, and no panic goes out.

use crate::failure::{Failure, LmStatus, Reason, c_text};
use std::any::Any;
use std::ffi::{CStr, CString, c_char};
use std::mem::MaybeUninit;
use std::panic::{AssertUnwindSafe, catch_unwind};

/// Does the work of a call: its failure is kept for the thread, a panic becomes one.
pub(crate) fn call(work: impl FnOnce() -> Result<(), Failure>) -> LmStatus {
    // What a panic leaves half done is behind a poisoned slot or goes with the call.
    match catch_unwind(AssertUnwindSafe(work)) {
        Ok(Ok(())) => LmStatus::Ok,
        Ok(Err(failure)) => failure.keep(),
        Err(panic) => Failure::internal(said(&*panic)).keep(),
    }
}

fn said(panic: &(dyn Any + Send)) -> String {
    let text = panic.downcast_ref::<&str>().map(|text| (*text).to_owned());
    text.or_else(|| panic.downcast_ref::<String>().cloned())
        .unwrap_or_else(|| "a fault of the library's own".to_owned())
}

fn checked<T>(pointer: *const T, what: &'static str) -> Result<(), Failure> {
    if pointer.is_null() {
        return Err(Failure::brief(what, Reason::Null));
    }
    if !pointer.is_aligned() {
        return Err(Failure::brief(what, Reason::Unaligned));
    }
    Ok(())
}

/// A text.
///
/// # Errors
/// A null; bytes that are not UTF-8.
///
/// # Safety
/// `text` is null or points to bytes that end with a zero and stay as they are for `'a`.
pub(crate) unsafe fn text<'a>(text: *const c_char, what: &'static str) -> Result<&'a str, Failure> {
    checked(text, what)?;
    // SAFETY: not null; the caller promises the zero at its end.
    let text = unsafe { CStr::from_ptr(text) };
    text.to_str().map_err(|error| {
        Failure::option(
            format!("{what} is no UTF-8: {error}"),
            "texts are UTF-8 and end with a zero",
        )
    })
}

/// A text that may be left out by a null.
///
/// # Errors
/// Bytes that are not UTF-8.
///
/// # Safety
/// As for [`text`].
pub(crate) unsafe fn maybe_text<'a>(
    pointer: *const c_char,
    what: &'static str,
) -> Result<Option<&'a str>, Failure> {
    if pointer.is_null() {
        return Ok(None);
    }
    // SAFETY: the caller's promise is the same.
    unsafe { text(pointer, what) }.map(Some)
}

/// Items one after the other; none for a null with a count of 0.
///
/// # Errors
/// A null with a count, a count that no memory has, a pointer that is not aligned.
///
/// # Safety
/// `items` is null or points to `count` items that stay as they are for `'a`.
pub(crate) unsafe fn list<'a, T>(
    items: *const T,
    count: usize,
    what: &'static str,
) -> Result<&'a [T], Failure> {
    if count == 0 {
        return Ok(&[]);
    }
    checked(items, what)?;
    let most = isize::MAX as usize / size_of::<T>().max(1);
    if count > most {
        return Err(Failure::brief(what, Reason::Size(count, most)));
    }
    // SAFETY: not null, aligned, no longer than memory can be; the caller promises its items.
    Ok(unsafe { std::slice::from_raw_parts(items, count) })
}

/// One item.
///
/// # Errors
/// A null, a pointer that is not aligned.
///
/// # Safety
/// `item` is null or points to an item that stays as it is for `'a`.
pub(crate) unsafe fn item<'a, T>(item: *const T, what: &'static str) -> Result<&'a T, Failure> {
    checked(item, what)?;
    // SAFETY: not null, aligned; the caller promises what it points to.
    Ok(unsafe { &*item })
}

/// Where an answer goes.
///
/// # Errors
/// A null, a pointer that is not aligned.
///
/// # Safety
/// `out` is null or points to room for a `T` that nothing else uses for `'a`.
pub(crate) unsafe fn out<'a, T>(
    out: *mut T,
    what: &'static str,
) -> Result<&'a mut MaybeUninit<T>, Failure> {
    checked(out, what)?;
    // SAFETY: not null, aligned; the caller promises the room. What is in it is not read.
    Ok(unsafe { &mut *out.cast::<MaybeUninit<T>>() })
}

/// Where several answers go.
///
/// # Errors
/// As for [`list`].
///
/// # Safety
/// `items` is null or points to room for `count` of `T` that nothing else uses for `'a`.
pub(crate) unsafe fn room<'a, T>(
    items: *mut T,
    count: usize,
    what: &'static str,
) -> Result<&'a mut [MaybeUninit<T>], Failure> {
    if count == 0 {
        return Ok(&mut []);
    }
    checked(items, what)?;
    let most = isize::MAX as usize / size_of::<T>().max(1);
    if count > most {
        return Err(Failure::brief(what, Reason::Size(count, most)));
    }
    // SAFETY: not null, aligned, no longer than memory can be; the caller promises the room. What is
    // in it is not read.
    Ok(unsafe { std::slice::from_raw_parts_mut(items.cast::<MaybeUninit<T>>(), count) })
}

/// Texts that are shown again and again, each made once.
#[derive(Default)]
pub(crate) struct Texts(std::collections::BTreeMap<String, CString>);

impl Texts {
    /// The text as C reads it, for as long as these texts live.
    pub(crate) fn of(&mut self, text: &str) -> *const c_char {
        if !self.0.contains_key(text) {
            self.0.insert(text.to_owned(), c_text(text));
        }
        self.0.get(text).map_or(c"".as_ptr(), |text| text.as_ptr())
    }
}
