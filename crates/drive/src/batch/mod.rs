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

/// Axes for which it pays to make a group of their own for a further thread. A choice: the vectors of
/// a group cost the same however many lanes have an axis, and half of them should.
const WORTH_A_GROUP: usize = WIDTH / 2;

/// Axes in a group, so that no thread is idle while another has more than it needs: as many groups
/// for each thread, if that leaves enough axes in each.
fn group_size(axes: usize, threads: usize) -> usize {
    let groups = axes.div_ceil(WIDTH).next_multiple_of(threads);
    axes.div_ceil(groups.max(1)).max(WORTH_A_GROUP)
}

/// Axes that are stepped side by side.
pub struct AxisBatch {
    groups: Vec<Group>,
    threads: usize,
}

impl AxisBatch {
    /// Of axes that need not be alike. Those with the same cycles share vectors best if they are
    /// neighbours. `threads`: 1 steps all of them on the caller's thread; more
    /// share them out over the pool in force ([`threads::pool`]), which should have that many. The results do
    /// not depend on it.
    pub fn new(axes: Vec<Box<dyn AxisRunner>>, threads: usize) -> AxisBatch {
        let size = group_size(axes.len(), threads.max(1));
        let mut groups: Vec<Group> = Vec::new();
        for mut axis in axes {
            let periods = axis.current_loop().periods();
            match groups.last_mut() {
                Some(group) if group.takes(&*axis, periods, size) => group.add(axis),
                _ => groups.push(Group::new(axis, periods)),
            }
        }
        AxisBatch { groups, threads }
    }

    /// Number of axes.
    pub fn len(&self) -> usize {
        self.groups.iter().map(Group::len).sum()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.groups.is_empty()
    }

    /// The axes in their order.
    pub fn axes(&self) -> impl Iterator<Item = &dyn AxisRunner> {
        self.groups.iter().flat_map(Group::axes)
    }

    /// The axes in their order, to be told something.
    pub fn axes_mut(&mut self) -> impl Iterator<Item = &mut dyn AxisRunner> {
        self.groups.iter_mut().flat_map(Group::axes_mut)
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
        type Task<'a> = (&'a mut Group, &'a [&'a [Setpoint]], &'a mut [AxisOutput]);
        let mut tasks: Vec<Task<'_>> = Vec::with_capacity(self.groups.len());
        let (mut setpoints, mut outputs) = (setpoints, outputs);
        for group in &mut self.groups {
            // each group takes its part of both lists, as far as the shorter one goes
            let count = group.len().min(setpoints.len()).min(outputs.len());
            let (mine, others) = setpoints.split_at(count);
            let (my_outputs, other_outputs) = outputs.split_at_mut(count);
            (setpoints, outputs) = (others, other_outputs);
            tasks.push((group, mine, my_outputs));
        }
        let step = |(group, setpoints, outputs): Task<'_>| group.push(setpoints, outputs);
        // groups share nothing, so which thread takes which does not show in the results
        let results = threads::map(self.threads, tasks.into_iter(), step);
        results.into_iter().flatten().collect()
    }
}
