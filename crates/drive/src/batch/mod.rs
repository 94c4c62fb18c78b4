//! Several variants of an axis side by side: methods, gaps, gains, or whole axes.
//!
//! Most of an axis' time goes into the periods of the current loop. A batch takes them for up to
//! [`WIDTH`] axes at once with the widest vectors the processor has (`kernel`). The laws are those
//! of the single axis: they are written once over a number that is an `f64` there and a vector here
//! (`number`), and products and sums are not contracted, so the results are those of single runs to
//! the last bit. A lane in whose period something happens that is not a product with a table (a
//! contact made or broken, friction that stops or breaks away, a voltage at its limit) takes that
//! period by itself, as a single axis does. Measuring, position and velocity loop are vectors, too
//! (`tick`), for drives without filters, friction feed-forward and delayed commands whose axes do not
//! drift; the others do them lane by lane, and so do all compensators but `none`, which is not asked. Groups of lanes run on the caller's thread, or
//! on the threads of the pool in force if more than one is asked for.

mod group;
mod kernel;
mod lanes;
mod tick;
mod twins;
mod vector;

use crate::error::AxisError;
use crate::runner::{AxisOutput, AxisRunner};
use crate::signal::Setpoint;
use group::Group;
use lostmotion_base::threads;

pub use lanes::WIDTH;

/// Least axes in a group where there are threads for more groups. A choice: the vectors of a group
/// cost the same whether one lane or all have an axis, but events, compensators and models of their axes,
/// which go lane by lane, cost more.
const WORTH_A_GROUP: usize = 4;

/// How many groups axes are dealt out to: as many for each thread, so that none is idle while another
/// has more than it needs, if that leaves enough axes in each.
fn group_count(axes: usize, threads: usize) -> usize {
    let needed = axes.div_ceil(WIDTH);
    needed
        .next_multiple_of(threads)
        .min(axes / WORTH_A_GROUP)
        .max(needed)
}

/// Axes that are stepped side by side.
pub struct AxisBatch {
    groups: Vec<Group>,
    /// The group of each axis, in whose order a group has them.
    group_of: Vec<usize>,
    threads: usize,
}

impl AxisBatch {
    /// Axes that are stepped in vectors together, at most.
    pub const GROUP: usize = WIDTH;

    /// Of axes that need not be alike; those with the same cycles share vectors. `threads`: 1 steps all
    /// of them on the caller's thread; more share them out over the pool in force ([`threads::pool`]),
    /// which should have that many. The results do not depend on it.
    pub fn new(axes: Vec<Box<dyn AxisRunner>>, threads: usize) -> AxisBatch {
        // axes of one kind, by the ticks of a command cycle and the periods of a tick
        type Kind = (usize, u32);
        type Alike = Vec<(usize, Box<dyn AxisRunner>)>;
        let mut kinds: Vec<(Kind, Alike)> = Vec::new();
        let mut group_of = vec![0; axes.len()];
        for (index, mut axis) in axes.into_iter().enumerate() {
            let kind = (axis.servo_ticks(), axis.current_loop().periods());
            match kinds.iter_mut().find(|(known, _)| *known == kind) {
                Some((_, alike)) => alike.push((index, axis)),
                None => kinds.push((kind, vec![(index, axis)])),
            }
        }
        let mut groups: Vec<Group> = Vec::new();
        for ((servo_ticks, periods), alike) in kinds {
            // dealt out like cards: neighbours are the axes of one machine with one method, which cost
            // about the same
            let (first, count) = (groups.len(), group_count(alike.len(), threads.max(1)));
            groups.extend((0..count).map(|_| Group::new(servo_ticks as u32, periods)));
            for (card, (index, axis)) in alike.into_iter().enumerate() {
                group_of[index] = first + card % count;
                groups[group_of[index]].add(axis);
            }
        }
        AxisBatch {
            groups,
            group_of,
            threads,
        }
    }

    /// Number of axes.
    pub fn len(&self) -> usize {
        self.group_of.len()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.group_of.is_empty()
    }

    /// The axes in their order.
    pub fn axes(&self) -> impl Iterator<Item = &dyn AxisRunner> {
        in_order(&self.group_of, self.groups.iter().map(Group::axes))
    }

    /// The axes in their order, to be told something.
    pub fn axes_mut(&mut self) -> impl Iterator<Item = &mut dyn AxisRunner> {
        in_order(&self.group_of, self.groups.iter_mut().map(Group::axes_mut))
    }

    /// Gives each axis its setpoints and an output to append to, as [`AxisRunner::push`] does;
    /// `setpoints` and `outputs` are in the order of the axes, and what is missing in one of them
    /// leaves its axis where it is.
    ///
    /// # Errors
    /// Those of each axis, in their order. The setpoints before the faulty one have been taken;
    /// other axes go on.
    pub fn push(
        &mut self,
        setpoints: &[&[Setpoint]],
        outputs: &mut [AxisOutput],
    ) -> Vec<Result<(), AxisError>> {
        type Hands<'a> = (Vec<&'a [Setpoint]>, Vec<&'a mut AxisOutput>);
        let mut hands: Vec<Hands<'_>> = self.groups.iter().map(|_| Hands::default()).collect();
        let lanes = setpoints.iter().zip(outputs);
        for (group, (setpoints, output)) in self.group_of.iter().zip(lanes) {
            hands[*group].0.push(setpoints);
            hands[*group].1.push(output);
        }
        let step = |(group, (setpoints, mut outputs)): (&mut Group, Hands<'_>)| {
            group.push(&setpoints, &mut outputs)
        };
        // groups share nothing, so which thread takes which does not show in the results
        let tasks = self.groups.iter_mut().zip(hands);
        let results = threads::map(self.threads, tasks, step);
        in_order(&self.group_of, results.into_iter()).collect()
    }
}

/// What each group has of its axes, in the order of all axes; groups may have less.
fn in_order<T, I: IntoIterator<Item = T>>(
    group_of: &[usize],
    groups: impl Iterator<Item = I>,
) -> impl Iterator<Item = T> {
    let mut groups: Vec<I::IntoIter> = groups.map(I::into_iter).collect();
    group_of
        .iter()
        .filter_map(move |group| groups[*group].next())
}
