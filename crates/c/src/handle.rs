//! Handles: what C holds in place of a pointer to one of ours.
//!
//! A handle is a number that looks like a pointer and points nowhere: kind, generation and place in
//! a table. So whatever C hands in, a null, a handle that was freed, one of another kind, a stray
//! pointer, is found in the table or is an error, and nothing is ever read through it.
//!
//! A call claims its object by one atomic exchange of the slot's lock and never waits: an object
//! that another thread is changing, or that is to be changed while another thread uses it, is
//! [`LmStatus::Busy`](crate::failure::LmStatus::Busy). Looking up takes no other lock and no memory,
//! so that a real-time thread may do it; making and freeing a handle do.

use crate::failure::{Brief, Failure, Reason};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, OnceLock, PoisonError, RwLock, TryLockError};

/// Slots of the first chunk; each further one has twice as many.
const FIRST: usize = 64;
/// Chunks: more slots than an index can name.
const CHUNKS: usize = 24;
/// Bits of a handle's parts, from below: place, generation, kind.
const PLACE_BITS: u32 = usize::BITS / 2;
const KIND_BITS: u32 = 4;
const LAST_GENERATION: usize = (1 << (PLACE_BITS - KIND_BITS)) - 1;

/// What C sees of an object: a type of its own that is never looked into.
pub(crate) trait Opaque: Sized + 'static {
    /// What stands behind it.
    type Object: Send + Sync;
    /// A number of its own, from 1 to 15.
    const KIND: usize;
    /// What it is called in messages.
    const NAME: &'static str;
    /// Where its objects are.
    fn table() -> &'static Table<Self::Object>;
}

/// Gives a type that C sees its number, its name and the table of what stands behind it.
macro_rules! opaque {
    ($name:ident($kind:literal, $text:literal) is $object:ty) => {
        impl $crate::handle::Opaque for $name {
            type Object = $object;
            const KIND: usize = $kind;
            const NAME: &'static str = $text;

            fn table() -> &'static $crate::handle::Table<$object> {
                static TABLE: $crate::handle::Table<$object> = $crate::handle::Table::new();
                &TABLE
            }
        }
    };
}
pub(crate) use opaque;

/// Handles that have been made and not freed.
static ALIVE: AtomicUsize = AtomicUsize::new(0);

/// How many there are.
pub(crate) fn alive() -> usize {
    ALIVE.load(Ordering::Relaxed)
}

/// Objects of one kind.
pub(crate) struct Table<T> {
    /// Slots never move and are never given back, so that looking up needs no lock.
    chunks: [OnceLock<Box<[Slot<T>]>>; CHUNKS],
    places: Mutex<Places>,
}

/// Which places are free.
struct Places {
    freed: Vec<usize>,
    /// The first that was never used.
    next: usize,
}

type Slot<T> = RwLock<Held<T>>;

/// What stands in a slot.
struct Held<T> {
    /// Of the handle that is valid now; it rises with each.
    generation: usize,
    object: Option<T>,
}

/// Chunk of a place, and where in it.
fn parted(place: usize) -> (usize, usize) {
    let rank = (place / FIRST + 1).ilog2();
    (rank as usize, place - FIRST * ((1 << rank) - 1))
}

impl<T> Table<T> {
    pub(crate) const fn new() -> Table<T> {
        Table {
            chunks: [const { OnceLock::new() }; CHUNKS],
            places: Mutex::new(Places {
                freed: Vec::new(),
                next: 0,
            }),
        }
    }

    /// The slot of a place that was given out once.
    fn slot(&self, place: usize) -> Option<&Slot<T>> {
        let (chunk, within) = parted(place);
        self.chunks.get(chunk)?.get()?.get(within)
    }
}

fn brief<H: Opaque>(reason: Reason) -> Failure {
    Failure::Brief(Brief {
        what: H::NAME,
        reason,
    })
}

/// Kind, generation and place of a handle.
fn parts(handle: usize) -> (usize, usize, usize) {
    let kind = handle >> (usize::BITS - KIND_BITS);
    let generation = (handle >> PLACE_BITS) & LAST_GENERATION;
    (kind, generation, handle & ((1 << PLACE_BITS) - 1))
}

/// The slot of a handle, with the generation that it has to have.
fn slot_of<H: Opaque>(handle: *const H) -> Result<(&'static Slot<H::Object>, usize), Failure> {
    if handle.is_null() {
        return Err(brief::<H>(Reason::Null));
    }
    let (kind, generation, place) = parts(handle.addr());
    if kind != H::KIND {
        return Err(brief::<H>(Reason::OtherKind));
    }
    let slot = H::table().slot(place);
    Ok((
        slot.ok_or_else(|| brief::<H>(Reason::NoHandle))?,
        generation,
    ))
}

/// Keeps an object, and gives its handle.
///
/// # Errors
/// More objects than handles can tell apart.
pub(crate) fn insert<H: Opaque>(object: H::Object) -> Result<*mut H, Failure> {
    let table = H::table();
    let place = {
        let mut places = table.places.lock().unwrap_or_else(PoisonError::into_inner);
        match places.freed.pop() {
            Some(place) => place,
            None => {
                let place = places.next;
                let (chunk, _) = parted(place);
                let full = || brief::<H>(Reason::Full);
                if place >> PLACE_BITS != 0 {
                    return Err(full());
                }
                table.chunks.get(chunk).ok_or_else(full)?.get_or_init(|| {
                    let empty = || {
                        RwLock::new(Held {
                            generation: 0,
                            object: None,
                        })
                    };
                    (0..FIRST << chunk).map(|_| empty()).collect()
                });
                places.next += 1;
                place
            }
        }
    };
    let slot = table
        .slot(place)
        .ok_or_else(|| brief::<H>(Reason::NoHandle))?;
    // Whoever comes with a handle that was freed holds it for a look only.
    let mut held = slot.write().unwrap_or_else(PoisonError::into_inner);
    held.generation += 1;
    held.object = Some(object);
    ALIVE.fetch_add(1, Ordering::Relaxed);
    let kind = H::KIND << (usize::BITS - KIND_BITS);
    let handle = kind | held.generation << PLACE_BITS | place;
    Ok(std::ptr::without_provenance_mut(handle))
}

/// Looks at an object; others may look at it, too.
///
/// # Errors
/// No handle of this kind, one that was freed, an object that another thread is changing; what the
/// look answers.
pub(crate) fn look<H: Opaque, R>(
    handle: *const H,
    work: impl FnOnce(&H::Object) -> Result<R, Failure>,
) -> Result<R, Failure> {
    let (slot, generation) = slot_of(handle)?;
    let held = match slot.try_read() {
        Ok(held) => held,
        Err(TryLockError::WouldBlock) => return Err(brief::<H>(Reason::Busy)),
        Err(TryLockError::Poisoned(_)) => return Err(brief::<H>(Reason::Broken)),
    };
    match &held.object {
        Some(object) if held.generation == generation => work(object),
        _ => Err(brief::<H>(Reason::Freed)),
    }
}

/// Changes an object that nobody else uses.
///
/// # Errors
/// As [`look`], and an object that anyone else uses.
pub(crate) fn change<H: Opaque, R>(
    handle: *mut H,
    work: impl FnOnce(&mut H::Object) -> Result<R, Failure>,
) -> Result<R, Failure> {
    let (slot, generation) = slot_of(handle)?;
    let mut held = match slot.try_write() {
        Ok(held) => held,
        Err(TryLockError::WouldBlock) => return Err(brief::<H>(Reason::Busy)),
        Err(TryLockError::Poisoned(_)) => return Err(brief::<H>(Reason::Broken)),
    };
    let held = &mut *held;
    match &mut held.object {
        Some(object) if held.generation == generation => work(object),
        _ => Err(brief::<H>(Reason::Freed)),
    }
}

/// Frees an object; nothing for a null.
///
/// # Errors
/// As [`change`]; one that has failed inside can be freed.
pub(crate) fn free<H: Opaque>(handle: *mut H) -> Result<(), Failure> {
    if handle.is_null() {
        return Ok(());
    }
    let (slot, generation) = slot_of(handle)?;
    let object = {
        let mut held = match slot.try_write() {
            Ok(held) => held,
            Err(TryLockError::WouldBlock) => return Err(brief::<H>(Reason::Busy)),
            Err(TryLockError::Poisoned(poisoned)) => {
                slot.clear_poison();
                poisoned.into_inner()
            }
        };
        if held.generation != generation {
            return Err(brief::<H>(Reason::Freed));
        }
        held.object
            .take()
            .ok_or_else(|| brief::<H>(Reason::Freed))?
    };
    ALIVE.fetch_sub(1, Ordering::Relaxed);
    // A place whose generations are used up is left alone: a handle never comes twice.
    if generation < LAST_GENERATION {
        let (_, _, place) = parts(handle.addr());
        let table = H::table();
        let mut places = table.places.lock().unwrap_or_else(PoisonError::into_inner);
        places.freed.push(place);
    }
    // After the locks: what an object does when it goes (callbacks of the caller's) is its own.
    drop(object);
    Ok(())
}
