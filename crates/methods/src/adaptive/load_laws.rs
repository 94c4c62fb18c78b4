//! A step of the load behind a motor whose motion is known.
//!
//! With the motor at a constant speed `u` (SI units at the motor):
//! ```text
//! D  = -b_L w_L - T_c - T_f sign(w_L)              all that resists it; it stands as long as T_f can hold the rest
//! r  = u - w_L - g D/J_L                           rate of the twist without the shaft, after g = h/2
//! T  = (k p + d r)/(1 + (g^2 k + g d)/J_L)         p: lead x + g r past the flank, 0 within the gap
//! w_L += h (T + D)/J_L                             to rest at most;   x += h (u - mean of w_L before and after)
//! ```
//! This is the midpoint rule, which takes no energy from a load that swings on its shaft; implicit Euler
//! (`g = h`), which ends swinging, in merged samples, that are longer.

use super::lanes::{Hypotheses, LANES, Lanes, Step};
use lostmotion_base::Number;

/// What a load's step computes with: divisions out of the inner loop. `g` is the time after which the shaft's torque
/// is taken, `h` that of a step.
#[derive(Clone, Copy, Default)]
pub(super) struct LoadLaws<N> {
    /// Half gap, stiffness and damping of the shaft, Coulomb friction, constant torque, viscous friction.
    half_gap: N,
    stiffness: N,
    damping: N,
    coulomb: N,
    constant: N,
    viscous: N,
    /// What is left of the load's speed against viscous friction, 1 - h b_L/J_L,
    keeps: N,
    /// and what the constant torque and friction take of it, h T_c/J_L and h T_f/J_L.
    slowed: [N; 2],
    /// What adds to the rate of the twist without the shaft: the constant torque, g T_c/J_L,
    by_constant: N,
    /// what friction adds to it or takes, g T_f/J_L,
    by_friction: N,
    /// and the part of the load's speed that it falls by, 1 - g b_L/J_L.
    by_speed: N,
    /// The last two times g: what they add to the twist.
    way: [N; 2],
    /// Stiffness and damping, over 1 + (g^2 k + g d)/J_L,
    shaft: [N; 2],
    /// and the same times h/J_L: the speed that they add.
    push: [N; 2],
    /// h, g, and the parts of a step for which the speeds before and after it count.
    step: N,
    ahead: N,
    before: N,
    after: N,
}

impl<N> LoadLaws<N> {
    /// Every number through a function.
    #[inline(always)]
    pub(super) fn map<M>(&self, function: impl Fn(&N) -> M) -> LoadLaws<M> {
        let two = |[a, b]: &[N; 2]| [function(a), function(b)];
        LoadLaws {
            half_gap: function(&self.half_gap),
            stiffness: function(&self.stiffness),
            damping: function(&self.damping),
            coulomb: function(&self.coulomb),
            constant: function(&self.constant),
            viscous: function(&self.viscous),
            keeps: function(&self.keeps),
            slowed: two(&self.slowed),
            by_constant: function(&self.by_constant),
            by_friction: function(&self.by_friction),
            by_speed: function(&self.by_speed),
            way: two(&self.way),
            shaft: two(&self.shaft),
            push: two(&self.push),
            step: function(&self.step),
            ahead: function(&self.ahead),
            before: function(&self.before),
            after: function(&self.after),
        }
    }
}

/// How a motor drives the loads over a sample.
pub(super) struct Driven<N> {
    /// Speed of the motor, rad/s, and its way in a step, rad.
    speed: N,
    way: N,
    /// Rate of the twist without the shaft, of a load with no speed and no friction, and that times g.
    onward: N,
    turned: N,
}

impl<N: Number> Driven<N> {
    #[inline(always)]
    pub(super) fn new(laws: &LoadLaws<N>, speed: f64) -> Driven<N> {
        let speed = laws.step.constant(speed);
        let onward = speed + laws.by_constant;
        Driven {
            speed,
            way: laws.step * speed,
            onward,
            turned: laws.ahead * onward,
        }
    }
}

impl LoadLaws<Lanes> {
    #[inline(always)]
    pub(super) fn new(p: &Hypotheses, step: Step) -> LoadLaws<Lanes> {
        let (h, ahead) = (step.time_s, step.part * step.time_s);
        let each = |value: &dyn Fn(usize) -> f64| -> Lanes { Lanes(std::array::from_fn(value)) };
        let inverse = p.inertia.map(|inertia| 1.0 / inertia);
        let [gain, by_drag] = [h, ahead].map(|time| inverse.map(|inverse| time * inverse));
        let give = each(&|lane| by_drag[lane] * (ahead * p.stiffness[lane] + p.damping[lane]));
        let left = give.map(|give| 1.0 / (1.0 + give));
        let shaft = [&p.stiffness, &p.damping].map(|by| each(&|lane| by[lane] * left[lane]));
        let times = |a: &Lanes, b: &Lanes| each(&|lane| a[lane] * b[lane]);
        let by_friction = times(&by_drag, &p.coulomb);
        let by_speed = times(&by_drag, &p.viscous).map(|taken| 1.0 - taken);
        LoadLaws {
            half_gap: p.half_gap,
            stiffness: p.stiffness,
            damping: p.damping,
            coulomb: p.coulomb,
            constant: p.constant,
            viscous: p.viscous,
            keeps: times(&gain, &p.viscous).map(|taken| 1.0 - taken),
            slowed: [times(&gain, &p.constant), times(&gain, &p.coulomb)],
            by_constant: times(&by_drag, &p.constant),
            way: [&by_friction, &by_speed].map(|by| by.map(|by| ahead * by)),
            by_friction,
            by_speed,
            push: shaft.map(|by| times(&gain, &by)),
            shaft,
            step: Lanes([h; LANES]),
            ahead: Lanes([ahead; LANES]),
            before: Lanes([h * (1.0 - step.part); LANES]),
            after: Lanes([h * step.part; LANES]),
        }
    }
}

impl<N: Number> LoadLaws<N> {
    /// Lead and speed of loads after one step, and the torque of their shafts. `signs`: which way they move, or
    /// would. Sums are ordered so that what a step has to wait for comes last, and is short: the speed that the
    /// shaft adds does not wait for its torque.
    #[inline(always)]
    pub(super) fn step(&self, [lead, speed]: [N; 2], driven: &Driven<N>, signs: N) -> ([N; 2], N) {
        // rate and twist without the shaft; friction opposes the motion, or the torque that sets it in motion
        let free = (driven.onward + self.by_friction.copysign(signs)) - self.by_speed * speed;
        let turned = (driven.turned + self.way[0].copysign(signs)) - self.way[1] * speed;
        let twisted = lead + turned;
        let slid = (self.keeps * speed - self.slowed[0]) - self.slowed[1].copysign(signs);
        // the shaft, and the compliance of the load to its torque
        let pressed = self.pressed(twisted);
        let push = self.push[0] * pressed + self.push[1] * free;
        let torque = self.on_flank(twisted, self.shaft[0] * pressed + self.shaft[1] * free);
        let mut slid = slid + self.on_flank(twisted, push);
        // speed that would change its sign within the step is rest, unless the torque exceeds stiction: in few steps
        // of few loads, so that the others do not wait for it
        let turns = (slid * signs).less(slid.zero());
        if !N::none(turns) {
            let pull = torque - self.constant - self.viscous * speed;
            slid = N::choose(turns & pull.abs().at_most(self.coulomb), slid.zero(), slid);
        }
        (self.moved([lead, speed], driven, slid), torque)
    }

    /// The same where some may be at rest; one that moves is moved as in [`LoadLaws::step`].
    #[inline(always)]
    pub(super) fn step_of_resting(&self, load: [N; 2], driven: &Driven<N>) -> ([N; 2], N) {
        let [lead, speed] = load;
        // torque on the load if it stood: stiction holds it where Coulomb friction exceeds that
        let rests = speed.equals(speed.zero());
        let rate = driven.speed - speed;
        let twisted = lead + self.ahead * rate;
        let held = self.on_flank(
            twisted,
            self.stiffness * self.pressed(twisted) + self.damping * rate,
        );
        let pull = held - self.constant;
        let sticks = rests & pull.abs().at_most(self.coulomb);
        let ([lead, slid], torque) = self.step(load, driven, N::choose(rests, pull, speed));
        let stuck = self.moved(load, driven, speed);
        (
            [
                N::choose(sticks, stuck[0], lead),
                N::choose(sticks, stuck[1], slid),
            ],
            N::choose(sticks, held, torque),
        )
    }

    /// Lead and speed after a step at whose end the load has this speed.
    #[inline(always)]
    fn moved(&self, [lead, speed]: [N; 2], driven: &Driven<N>, slid: N) -> [N; 2] {
        [
            ((lead + driven.way) - self.before * speed) - self.after * slid,
            slid,
        ]
    }

    /// How far a lead of the motor is past the flank, zero within the gap.
    #[inline(always)]
    fn pressed(&self, lead: N) -> N {
        lead - lead.clamp(-self.half_gap, self.half_gap)
    }

    /// What acts on a flank alone; told from the lead itself, so that it need not wait for how far it is past that.
    #[inline(always)]
    fn on_flank(&self, lead: N, value: N) -> N {
        N::choose(self.half_gap.less(lead.abs()), value, value.zero())
    }
}
