//! The few largest of many, in constant memory.

use serde::{Deserialize, Serialize};

/// Keeps the `keep` items of largest size, largest first; of equal ones those that came first.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Worst<T> {
    keep: usize,
    items: Vec<(f64, T)>,
}

impl<T> Worst<T> {
    pub(crate) fn new(keep: usize) -> Worst<T> {
        Worst {
            keep,
            items: Vec::new(),
        }
    }

    pub(crate) fn offer(&mut self, size: f64, item: T) {
        let at = self.items.partition_point(|(other, _)| *other >= size);
        if at < self.keep {
            self.items.insert(at, (size, item));
            self.items.truncate(self.keep);
        }
    }

    pub(crate) fn iter(&self) -> impl Iterator<Item = &T> {
        self.items.iter().map(|(_, item)| item)
    }
}
