//! Two masses, a gap and dry friction, integrated by Runge and Kutta's method in small steps with
//! every event located: shares no code with the program.

use super::{DAMPING, INERTIA, LEAD_M, LOAD_KG, STIFFNESS, Slide, TICK_S, motor_kg, run};
use std::f64::consts::TAU;

/// Step, s: 0.3 % of a radian of the shaft's swing, so that its error is below rounding.
const STEP_S: f64 = 2e-6;

/// Positions and speeds of motor and load, m and m/s.
type State = [f64; 4];

/// What a mass does: slides in a direction, or stands (0).
type Slides = [f64; 2];

/// Where the shaft is: no gap, between the flanks, or on one (-1, 1) in a branch of the law.
#[derive(Clone, Copy, Debug)]
enum Contact {
    Rigid,
    Gap,
    Flank(f64, f64),
}

#[derive(Clone, Copy)]
struct Axis {
    mass: [f64; 2],
    coulomb: [f64; 2],
    viscous: [f64; 2],
    half_gap: f64,
    law: &'static str,
}

impl Axis {
    fn of(slide: &Slide) -> Axis {
        let per_m = TAU / LEAD_M;
        assert!((motor_kg() - INERTIA * per_m * per_m).abs() < 1e-9);
        Axis {
            mass: [motor_kg(), LOAD_KG],
            coulomb: [slide.motor[0] * per_m, slide.load[0]],
            viscous: [slide.motor[1] * per_m * per_m, slide.load[1]],
            half_gap: 0.5e-6 * slide.gap_um,
            law: slide.law,
        }
    }

    /// Spring and damper along the normal of a flank.
    fn parts(&self, flank: f64, y: &State) -> [f64; 2] {
        let depth = flank * (y[0] - y[1]) - self.half_gap;
        [STIFFNESS * depth, DAMPING * flank * (y[2] - y[3])]
    }

    /// The branch of the law on a flank: as it is (0), no force (-1), or twice the spring (1).
    fn branch(&self, flank: f64, y: &State) -> f64 {
        let [spring, damper] = self.parts(flank, y);
        match self.law {
            "clamped" | "bounded" if spring + damper < 0.0 => -1.0,
            "bounded" if damper > spring => 1.0,
            _ => 0.0,
        }
    }

    /// Force of the shaft on the load.
    fn shaft(&self, contact: Contact, y: &State) -> f64 {
        match contact {
            Contact::Rigid => STIFFNESS * (y[0] - y[1]) + DAMPING * (y[2] - y[3]),
            Contact::Gap => 0.0,
            Contact::Flank(flank, branch) => {
                let [spring, damper] = self.parts(flank, y);
                let push = match branch {
                    -1.0 => 0.0,
                    1.0 => 2.0 * spring,
                    _ => spring + damper,
                };
                flank * push
            }
        }
    }

    /// On a flank, with the branch of the law there.
    fn landed(&self, flank: f64, y: &State) -> Contact {
        Contact::Flank(flank, self.branch(flank, y))
    }

    /// Forces on both masses without their Coulomb friction.
    fn forces(&self, contact: Contact, outside: f64, y: &State) -> [f64; 2] {
        let shaft = self.shaft(contact, y);
        [
            -shaft - self.viscous[0] * y[2],
            shaft - outside - self.viscous[1] * y[3],
        ]
    }

    fn rate(&self, contact: Contact, slides: Slides, outside: f64, y: &State) -> State {
        let forces = self.forces(contact, outside, y);
        let acceleration = |mass: usize| {
            if self.coulomb[mass] > 0.0 && slides[mass] == 0.0 {
                0.0
            } else {
                (forces[mass] - self.coulomb[mass] * slides[mass]) / self.mass[mass]
            }
        };
        [y[2], y[3], acceleration(0), acceleration(1)]
    }

    fn step(&self, contact: Contact, slides: Slides, outside: f64, y: &State, h: f64) -> State {
        let plus =
            |y: &State, k: &State, h: f64| -> State { std::array::from_fn(|i| y[i] + h * k[i]) };
        let rate = |y: &State| self.rate(contact, slides, outside, y);
        let k1 = rate(y);
        let k2 = rate(&plus(y, &k1, 0.5 * h));
        let k3 = rate(&plus(y, &k2, 0.5 * h));
        let k4 = rate(&plus(y, &k3, h));
        std::array::from_fn(|i| y[i] + h / 6.0 * (k1[i] + 2.0 * (k2[i] + k3[i]) + k4[i]))
    }

    /// What ends the mode that a state is in; `None` while it lasts.
    fn event(&self, contact: Contact, slides: Slides, outside: f64, y: &State) -> Option<Event> {
        let lead = y[0] - y[1];
        match contact {
            Contact::Gap if lead.abs() > self.half_gap => {
                return Some(Event::Contact(self.landed(lead.signum(), y)));
            }
            Contact::Flank(flank, _) if flank * lead < self.half_gap => {
                return Some(Event::Contact(Contact::Gap));
            }
            Contact::Flank(flank, branch) if self.branch(flank, y) != branch => {
                return Some(Event::Contact(self.landed(flank, y)));
            }
            _ => {}
        }
        let forces = self.forces(contact, outside, y);
        for mass in 0..2 {
            let (v, most) = (y[2 + mass], self.coulomb[mass]);
            if most == 0.0 {
                continue;
            }
            if slides[mass] == 0.0 && forces[mass].abs() > most {
                return Some(Event::Slides(mass, forces[mass].signum()));
            }
            if slides[mass] * v < 0.0 {
                return Some(Event::Stops(mass));
            }
        }
        None
    }
}

#[derive(Clone, Copy, Debug)]
enum Event {
    Contact(Contact),
    Slides(usize, f64),
    Stops(usize),
}

/// The states at the ticks of a run with a force in each row of 1 ms.
fn integrate(axis: &Axis, start: State, forces: &[f64]) -> Vec<State> {
    let mut y = start;
    let mut contact = match y[0] - y[1] {
        _ if axis.half_gap == 0.0 => Contact::Rigid,
        lead if lead.abs() < axis.half_gap => Contact::Gap,
        lead => axis.landed(lead.signum(), &y),
    };
    let mut slides: Slides = [0, 1].map(|mass: usize| {
        if y[2 + mass] == 0.0 {
            0.0
        } else {
            y[2 + mass].signum()
        }
    });
    let mut out = Vec::new();
    for outside in forces {
        for _ in 0..4 {
            out.push(y);
            let mut left = TICK_S;
            let mut events = 0;
            while left > 0.0 {
                let h = STEP_S.min(left);
                let next = axis.step(contact, slides, *outside, &y, h);
                let Some(_) = axis.event(contact, slides, *outside, &next) else {
                    y = next;
                    left -= h;
                    continue;
                };
                // The instant after which the mode has ended, by halving.
                let (mut low, mut high) = (0.0, h);
                for _ in 0..60 {
                    let middle = 0.5 * (low + high);
                    let there = axis.step(contact, slides, *outside, &y, middle);
                    if axis.event(contact, slides, *outside, &there).is_some() {
                        high = middle;
                    } else {
                        low = middle;
                    }
                }
                y = axis.step(contact, slides, *outside, &y, high);
                left -= high;
                match axis.event(contact, slides, *outside, &y) {
                    Some(Event::Contact(to)) => contact = to,
                    Some(Event::Slides(mass, side)) => slides[mass] = side,
                    Some(Event::Stops(mass)) => {
                        y[2 + mass] = 0.0;
                        // Held, or pushed the other way at once.
                        let force = axis.forces(contact, *outside, &y)[mass];
                        slides[mass] = if force.abs() > axis.coulomb[mass] {
                            force.signum()
                        } else {
                            0.0
                        };
                    }
                    None => {}
                }
                events += 1;
                assert!(events < 1000, "the integrator chatters");
            }
        }
    }
    out
}

/// A small generator of its own: Lehmer's.
struct Dice(u64);

impl Dice {
    fn between(&mut self, low: f64, high: f64) -> f64 {
        self.0 = self.0 * 48_271 % 2_147_483_647;
        low + (high - low) * self.0 as f64 / 2_147_483_647.0
    }
}

/// Axes thrown and pushed about, with every law of the contact and friction on either mass: where
/// motor and load are, and what the shaft carries, is what the integrator finds.
#[test]
fn thrown_and_pushed_axes_move_as_integrated() {
    let mut dice = Dice(20_261_123);
    let mut worst: f64 = 0.0;
    for case in 0..18 {
        let law = ["linear", "clamped", "bounded"][case % 3];
        let slide = Slide {
            gap_um: if case % 6 == 5 {
                0.0
            } else {
                dice.between(5.0, 80.0)
            },
            law,
            motor: [
                if case % 2 == 0 {
                    dice.between(0.02, 0.1)
                } else {
                    0.0
                },
                dice.between(0.0, 3e-4),
            ],
            load: [
                if case % 4 < 2 {
                    dice.between(20.0, 120.0)
                } else {
                    0.0
                },
                dice.between(0.0, 500.0),
            ],
        };
        let [motor_mm_s, load_mm_s] = [(); 2].map(|()| dice.between(-25.0, 25.0));
        let in_gap = dice.between(-0.9, 0.9);
        // Every fourth shaft begins wound up, the others somewhere in their gaps.
        let wind_up_um = (case % 4 == 3).then(|| dice.between(-15.0, 15.0));
        let place = wind_up_um.map_or(format!("in_gap={in_gap}"), |um| format!("wind_up_um={um}"));
        let half_gap = 0.5e-6 * slide.gap_um;
        let lead = wind_up_um.map_or(in_gap * half_gap, |um| 1e-6 * um + um.signum() * half_gap);
        // A force that jumps in every fifth row and rests in between.
        let forces: Vec<f64> = (0..60)
            .scan(0.0, |force, row| {
                if row % 5 == 2 {
                    *force = dice.between(-300.0, 300.0);
                }
                Some(*force)
            })
            .collect();
        let start =
            format!("motor_velocity_mm_s={motor_mm_s},load_velocity_mm_s={load_mm_s},{place}");
        let rows = run(
            &slide,
            forces.len(),
            |row| forces[row],
            &["--drive-off", "--start", &start],
        )
        .masses();
        let axis = Axis::of(&slide);
        let begin = [0.0, -lead, 1e-3 * motor_mm_s, 1e-3 * load_mm_s];
        let expected = integrate(&axis, begin, &forces);
        assert_eq!(rows.len(), expected.len());
        for (tick, (at, y)) in rows.iter().zip(&expected).enumerate() {
            let off = (at.x[0] - y[0]).abs().max((at.x[1] - y[1]).abs());
            worst = worst.max(off);
            assert!(
                off < 1e-13,
                "case {case}, {law}, tick {tick}: {at:?} for {y:?}"
            );
        }
    }
    // 1e-13 m are 1e-8 of the smallest gap; printed with --nocapture.
    eprintln!("thrown and pushed axes: {worst:e} m at most off the integrator");
}
