//! The call stacks that blocks were run under, as a tree: each call knows the one it was made from.

use lostmotion_base::span::Span;
use std::collections::BTreeMap;

/// Most distinct calls that are told apart; further ones count as made from the main program.
const MOST: usize = 100_000;

/// A call of a subroutine.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct CallSite {
    /// The subroutine.
    pub name: String,
    /// The block that called it.
    pub call: Span,
    /// Index of the call that this one was made in; 0 is the main program.
    pub within: u32,
}

/// All calls made so far, each kept once; index 0 is the main program and has no entry.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CallStacks {
    sites: Vec<CallSite>,
    known: BTreeMap<(u32, Span), u32>,
}

impl CallStacks {
    /// The call of an index, as [`lostmotion_base::span::BlockRef`] has it; none for the main
    /// program.
    pub fn get(&self, index: u32) -> Option<&CallSite> {
        self.sites.get((index as usize).checked_sub(1)?)
    }

    /// The calls that lead to an index, innermost first.
    pub fn trace(&self, index: u32) -> impl Iterator<Item = &CallSite> {
        std::iter::successors(self.get(index), |site| self.get(site.within))
    }

    /// The index of a call.
    pub(crate) fn enter(&mut self, name: &str, call: Span, within: u32) -> u32 {
        if let Some(&index) = self.known.get(&(within, call)) {
            // A label that is computed may name another subroutine at the same place.
            if self.get(index).is_some_and(|site| site.name == name) {
                return index;
            }
        }
        if self.sites.len() >= MOST {
            return 0;
        }
        self.sites.push(CallSite {
            name: name.to_owned(),
            call,
            within,
        });
        let index = self.sites.len() as u32;
        self.known.insert((within, call), index);
        index
    }
}
