//! The log's command run again through the servo and the body that were found.

use super::{BodyLog, RigidBody, ServoGains};

/// Steps of the integration in a period of the log, at least. A choice: halving it moves the
/// position by less than a tenth of what is found for the residual.
const MIN_STEPS: usize = 10;

/// What the model does on the log's command.
#[derive(Clone, Debug, PartialEq)]
pub struct Replayed {
    /// Simulated position, as the motor's in the log.
    pub position: Vec<f64>,
    /// Simulated drive signal.
    pub drive: Vec<f64>,
    /// Root mean square of simulated less measured position.
    pub rms: f64,
    /// Largest difference.
    pub largest: f64,
}

/// Runs the closed loop of servo and body on the log's command; `None` where there is no law.
///
/// Between two samples of the log the drive signal is held, as a servo holds it. Friction holds the
/// body at rest while the drive signal is smaller.
pub fn replay(log: &BodyLog, body: &RigidBody, servo: &ServoGains) -> Option<Replayed> {
    let law = servo.law?;
    let inertia = body.inertia.value;
    if inertia <= 0.0 || log.command.len() != log.len() {
        return None;
    }
    let period = log.period_s;
    // Stable for any damping: the step is short against the time in which friction stops the body.
    let damping = body.viscous.value.abs() / inertia;
    let steps = ((4.0 * damping * period).ceil() as usize).clamp(MIN_STEPS, 1000);
    let step = period / steps as f64;
    let limit = log
        .drive
        .iter()
        .fold(0.0, |top: f64, drive| top.max(drive.abs()))
        * 1.5;
    let viscous = body.sided.map_or([body.viscous.value; 2], |sided| {
        sided.viscous.map(|figure| figure.value)
    });
    let (gain, position_gain) = (law.velocity_gain.value, law.position_gain_per_s.value);
    let (mut place, mut speed) = (log.motor[0], (log.motor[1] - log.motor[0]) / period);
    let mut integral = 0.0;
    let mut out = Replayed {
        position: Vec::with_capacity(log.len()),
        drive: Vec::with_capacity(log.len()),
        rms: 0.0,
        largest: 0.0,
    };
    // Speeds at the samples, for the age of the measured one.
    let mut speeds: Vec<f64> = Vec::with_capacity(log.len());
    let age = law.delay_s / period;
    for sample in 0..log.len() {
        out.position.push(place);
        speeds.push(speed);
        let before = |back: usize| speeds[sample.saturating_sub(back)];
        let whole = age.floor();
        let share = age - whole;
        let measured = (1.0 - share) * before(whole as usize) + share * before(whole as usize + 1);
        let error = log.command[sample] - place;
        let next = log.command.get(sample + 1).unwrap_or(&log.command[sample]);
        let reference = (next - log.command[sample.saturating_sub(1)]) / (2.0 * period);
        let asked = position_gain * error + law.feedforward * reference - measured;
        if let Some(time) = law.integral_time_s {
            integral += asked * period / time.value;
        }
        let drive = (gain * (asked + integral) + law.offset).clamp(-limit, limit);
        out.drive.push(drive);
        let force = drive - body.constant.value;
        for _ in 0..steps {
            let direction = if speed != 0.0 {
                speed.signum()
            } else {
                force.signum()
            };
            let slow = body.stribeck.map_or(0.0, |stribeck| {
                let ratio = speed / stribeck.speed.value;
                stribeck.above.value * lostmotion_base::math::exp(-ratio * ratio)
            });
            let coulomb = (body.coulomb.value + slow).max(0.0);
            if speed == 0.0 && force.abs() <= coulomb {
                continue;
            }
            let of_direction = viscous[usize::from(direction < 0.0)];
            let mut next =
                speed + step / inertia * (force - of_direction * speed - direction * coulomb);
            // Friction stops the body and does not turn it round.
            if next * direction < 0.0 {
                next = 0.0;
            }
            place += 0.5 * step * (speed + next);
            speed = next;
        }
        if !place.is_finite() {
            return None;
        }
    }
    let differences = out
        .position
        .iter()
        .zip(&log.motor)
        .map(|(simulated, measured)| simulated - measured);
    let square: f64 = differences
        .clone()
        .map(|difference| difference * difference)
        .sum();
    out.largest = differences.fold(0.0, |top: f64, difference| top.max(difference.abs()));
    out.rms = (square / log.len() as f64).sqrt();
    Some(out)
}
