//! Which cells of a manifest are yet to be run, and what they need: a bit for each cell, so that a manifest
//! of millions takes no memory to speak of.

use crate::error::SweepError;
use crate::key::{Key, Keys};
use crate::manifest::{Cell, Cells, Header, Manifest};

/// A part of a sweep: cell `i` of every `n`, so that each has a like share of every program.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shard {
    /// Which, from 1.
    pub index: usize,
    /// Of how many.
    pub count: usize,
}

impl Shard {
    /// The whole sweep.
    pub const WHOLE: Shard = Shard { index: 1, count: 1 };
}

impl std::str::FromStr for Shard {
    type Err = String;

    /// `3/8` is the third of eight.
    ///
    /// ```
    /// use lostmotion_sweep::missing::Shard;
    ///
    /// assert_eq!("3/8".parse(), Ok(Shard { index: 3, count: 8 }));
    /// assert!("0/8".parse::<Shard>().is_err() && "9/8".parse::<Shard>().is_err());
    /// ```
    fn from_str(text: &str) -> Result<Shard, String> {
        let number = |text: &str| text.trim().parse::<usize>().ok();
        let pair = text.split_once('/');
        pair.and_then(|(index, count)| number(index).zip(number(count)))
            .filter(|(index, count)| (1..=*count).contains(index))
            .map(|(index, count)| Shard { index, count })
            .ok_or_else(|| {
                format!("`{text}` is not of the form I/N, with I from 1 to N; for example 3/8")
            })
    }
}

/// Cells that need something, and the first of them.
#[derive(Clone, Copy, Debug, Default)]
pub struct Need {
    /// How many.
    pub cells: usize,
    /// Key of the first.
    pub first: Option<Key>,
}

impl Need {
    fn count(&mut self, cell: &Cell) {
        self.cells += 1;
        self.first.get_or_insert(cell.key);
    }
}

/// What some cells need.
#[derive(Clone, Debug)]
pub struct Needs {
    /// All of the cells.
    pub all: Need,
    /// By program, in the order of the header.
    pub programs: Vec<Need>,
    /// By machine.
    pub machines: Vec<Need>,
}

impl Needs {
    /// Of no cells yet.
    pub fn none(header: &Header) -> Needs {
        Needs {
            all: Need::default(),
            programs: vec![Need::default(); header.programs.len()],
            machines: vec![Need::default(); header.machines.len()],
        }
    }

    /// Adds a cell.
    pub fn count(&mut self, cell: &Cell) {
        self.all.count(cell);
        let program = self.programs.get_mut(cell.program);
        let machine = self.machines.get_mut(cell.machine);
        for need in program.into_iter().chain(machine) {
            need.count(cell);
        }
    }
}

/// The cells of a shard that are not done yet, each key once: a bit for each cell of the manifest.
#[derive(Debug)]
pub struct Missing {
    bits: Vec<u64>,
    /// What they need.
    pub needs: Needs,
}

/// Bits of a word.
const BITS: usize = u64::BITS as usize;

impl Missing {
    /// Reads the manifest once.
    ///
    /// # Errors
    /// A manifest that is cut off, or has a line that is no cell.
    pub fn of(manifest: &Manifest, shard: Shard, done: &Keys) -> Result<Missing, SweepError> {
        let mut needs = Needs::none(&manifest.header);
        let (mut keys, mut read) = (Vec::new(), 0_usize);
        for cell in manifest.cells()? {
            let cell = cell?;
            if read % shard.count == shard.index - 1 && done.place(&cell.key).is_none() {
                needs.count(&cell);
                keys.push((cell.key, read));
            }
            read += 1;
        }
        // Two names of one program make cells of the same key, of which the first is run.
        let all = keys.len();
        keys.sort_unstable();
        keys.dedup_by_key(|(key, _)| *key);
        let mut bits = vec![0; read.div_ceil(BITS)];
        for (_, index) in &keys {
            if let Some(word) = bits.get_mut(index / BITS) {
                *word |= 1_u64 << (index % BITS);
            }
        }
        let mut missing = Missing { bits, needs };
        if keys.len() < all {
            missing.needs = Needs::none(&manifest.header);
            for cell in missing.cells(manifest)? {
                missing.needs.count(&cell?);
            }
        }
        Ok(missing)
    }

    /// Number of cells.
    pub fn len(&self) -> usize {
        self.needs.all.cells
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The cells, read anew from the manifest.
    ///
    /// # Errors
    /// As [`Manifest::cells`].
    pub fn cells(&self, manifest: &Manifest) -> Result<MissingCells, SweepError> {
        Ok(MissingCells {
            cells: manifest.cells()?,
            bits: self.bits.clone(),
            next: 0,
        })
    }
}

/// The cells that are missing, one after the other.
#[derive(Debug)]
pub struct MissingCells {
    cells: Cells,
    bits: Vec<u64>,
    /// Place of the cell that is read next.
    next: usize,
}

impl Iterator for MissingCells {
    type Item = Result<Cell, SweepError>;

    fn next(&mut self) -> Option<Result<Cell, SweepError>> {
        loop {
            let cell = self.cells.next()?;
            let word = self.bits.get(self.next / BITS).copied().unwrap_or_default();
            let is_missing = word >> (self.next % BITS) & 1 == 1;
            self.next += 1;
            if is_missing || cell.is_err() {
                return Some(cell);
            }
        }
    }
}
