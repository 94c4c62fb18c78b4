//! The load's place from reversal to reversal.

/// The load's place without its noise: it follows only what leaves a band around it.
pub(super) struct Followed {
    pub(super) place: Vec<f64>,
    /// Half the band's width.
    pub(super) band: f64,
    /// Rows at which it has turned round: by then the load has gone back by the whole band.
    pub(super) turned: Vec<bool>,
    /// Rows from where the load stands still before it turns round until it is known that it has:
    /// meanwhile the motor is anywhere within the gap.
    pub(super) unsure: Vec<bool>,
    pub(super) reversals: usize,
}

impl Followed {
    pub(super) fn of(column: &[f64], band: f64) -> Followed {
        let mut place = column.first().copied().unwrap_or(0.0);
        let (mut direction, mut advanced) = (0.0, 0);
        let mut followed = Followed {
            place: Vec::with_capacity(column.len()),
            band,
            turned: Vec::with_capacity(column.len()),
            unsure: Vec::with_capacity(column.len()),
            reversals: 0,
        };
        for &value in column {
            let ahead = value - place;
            let leaves = ahead.abs() > band;
            let turned = leaves && direction * ahead < 0.0;
            if leaves {
                direction = ahead.signum();
                place = value - direction * band;
            }
            followed.reversals += usize::from(turned);
            followed.turned.push(turned);
            // While it goes on, the load is at the band's edge but for its noise.
            followed
                .unsure
                .push(direction * (value - place) < 0.5 * band);
            followed.place.push(place);
            if turned {
                let now = followed.unsure.len() - 1;
                followed.unsure[advanced..now].fill(true);
            }
            if leaves {
                advanced = followed.unsure.len();
            }
        }
        followed
    }

    pub(super) fn range(&self) -> f64 {
        let least = self.place.iter().copied().fold(f64::INFINITY, f64::min);
        let most = self.place.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        most - least
    }
}
