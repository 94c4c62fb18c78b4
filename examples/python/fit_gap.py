"""The gap of an axis from a log of motor and load.

A real log comes from a drive's trace (`lostmotion.fit` reads the files of many controls); here the
simulated axis writes one. The fit answers with a value and the interval that the log supports. As
`fit_gap.rs`.
"""

import numpy as np

import lostmotion

machine = lostmotion.Machine.preset("vmc3-worn")

# Ten seconds of a sine, every servo tick traced.
rate = 3.0
phase = rate * np.arange(10_000) * 1e-3
sine, cosine = np.sin(phase), np.cos(phase)
axis = lostmotion.Axis(machine, "y", differences=False)
trace = axis.push(8.0 * sine, velocity=8.0 * rate * cosine, acceleration=-8.0 * rate * rate * sine)

# The fit knows the motor's data sheet and what turns with it; the gap is what it looks for.
log = {
    "time_s": trace["t_s"],
    "motor": trace["motor_mm"],
    "load": trace["load_mm"],
    "current_a": trace["current_a"],
}
fit = lostmotion.fit(log, machine, "y", unit="mm")

true_um = machine.to_dict()["axis"]["y"]["load"]["slide"]["gap_um"]
low, high = (1e3 * end for end in fit.gap_interval)
print(f"true gap {true_um:.1f} um, fitted {1e3 * fit.gap:.1f} um (95 %: {low:.1f} to {high:.1f})")
