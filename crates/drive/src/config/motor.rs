//! The motor: what its data sheet says.

use super::check::{AxisConfigError, between, not_negative, positive};
use serde::{Deserialize, Serialize};

/// A permanent-magnet synchronous motor.
///
/// Currents and voltages in dq are amplitude-invariant (the length of the vector is the amplitude
/// of a phase), so `torque = torque_constant * i_q` and the back-EMF is
/// `(2/3) torque_constant * speed`: mechanical power `K_t i_q w` has to equal the electric power
/// `(3/2) u_emf i_q`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Motor {
    /// Resistance between two terminals, ohm. A phase has half of it.
    pub resistance_ohm: f64,
    /// Inductance between two terminals, H. A phase has half of it; the same in d and q (surface
    /// magnets).
    pub inductance_h: f64,
    /// Number of poles (twice the pole pairs).
    pub poles: u32,
    /// Inertia of the rotor, kg m2.
    pub inertia_kgm2: f64,
    /// Torque for one ampere of i_q, N m/A.
    pub torque_constant_nm_per_a: f64,
    /// Torque that it can give for ever, N m; used to express friction in parts of it.
    pub rated_torque_nm: f64,
    /// Viscous friction at the motor, N m s/rad.
    #[serde(default)]
    pub viscous_nm_s_per_rad: f64,
    /// Coulomb friction at the motor, N m.
    #[serde(default)]
    pub coulomb_nm: f64,
}

impl Motor {
    /// Checks every value.
    ///
    /// # Errors
    /// The first value out of range.
    pub fn check(&self) -> Result<(), AxisConfigError> {
        positive("resistance_ohm", self.resistance_ohm)?;
        positive("inductance_h", self.inductance_h)?;
        positive("inertia_kgm2", self.inertia_kgm2)?;
        positive("torque_constant_nm_per_a", self.torque_constant_nm_per_a)?;
        positive("rated_torque_nm", self.rated_torque_nm)?;
        not_negative("viscous_nm_s_per_rad", self.viscous_nm_s_per_rad)?;
        not_negative("coulomb_nm", self.coulomb_nm)?;
        between("poles", f64::from(self.poles), 2.0, 200.0)?;
        if self.poles % 2 == 1 {
            return Err(AxisConfigError::Range {
                key: "poles".to_owned(),
                value: f64::from(self.poles),
                allowed: "an even number".to_owned(),
            });
        }
        Ok(())
    }

    /// Resistance of a phase, ohm.
    pub fn phase_resistance_ohm(&self) -> f64 {
        0.5 * self.resistance_ohm
    }

    /// Inductance of a phase, H.
    pub fn phase_inductance_h(&self) -> f64 {
        0.5 * self.inductance_h
    }

    /// Back-EMF in q for a mechanical speed, V s/rad.
    pub fn back_emf_v_s_per_rad(&self) -> f64 {
        // amplitude-invariant dq frame: T = 3/2 p psi i_q and e_q = p psi w
        self.torque_constant_nm_per_a * 2.0 / 3.0
    }

    /// Pole pairs: electrical over mechanical angle.
    pub fn pole_pairs(&self) -> f64 {
        0.5 * f64::from(self.poles)
    }
}

// A motor whose torque is not even.

/// Harmonics of one kind that an axis may have.
pub const MAX_HARMONICS: usize = 4;

/// One harmonic over the motor's turn: `amplitude sin(per_turn theta_M + phase)`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Harmonic {
    /// Amplitude: N m for cogging (up to 100), parts of the torque constant for ripple (up to 0.2).
    pub amplitude: f64,
    /// Periods for one mechanical turn of the motor, 1 to 1000. Cogging has multiples of the least
    /// common multiple of slots and poles, ripple mostly 6 and 12 for each pole pair.
    pub per_turn: u32,
    /// Phase, degrees.
    #[serde(default)]
    pub phase_deg: f64,
}

/// Torque that depends on the motor's angle. In a file: a table `ripple`; left out, there is none.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Ripple {
    /// Torque without current, N m (magnets against slots); at most four harmonics.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub cogging: Vec<Harmonic>,
    /// Relative change of the torque constant, and with it of the back-EMF; at most four harmonics.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub torque: Vec<Harmonic>,
}

impl Ripple {
    /// Whether there is none.
    pub fn is_none(&self) -> bool {
        self.cogging.is_empty() && self.torque.is_empty()
    }

    /// Checks every value.
    ///
    /// # Errors
    /// The first value out of range.
    pub fn check(&self) -> Result<(), AxisConfigError> {
        for (key, list, highest) in [
            ("cogging", &self.cogging, 100.0),
            ("torque", &self.torque, 0.2),
        ] {
            between(
                &format!("{key}: number of harmonics"),
                list.len() as f64,
                0.0,
                MAX_HARMONICS as f64,
            )?;
            for (index, harmonic) in list.iter().enumerate() {
                harmonic
                    .check(highest)
                    .map_err(|e| e.within(&format!("{key}[{index}]")))?;
            }
        }
        Ok(())
    }
}

impl Harmonic {
    fn check(&self, highest: f64) -> Result<(), AxisConfigError> {
        between("amplitude", self.amplitude, 0.0, highest)?;
        between("per_turn", f64::from(self.per_turn), 1.0, 1000.0)?;
        between("phase_deg", self.phase_deg, -360.0, 360.0)
    }
}
