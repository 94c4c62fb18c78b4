"""One axis from setpoints to where its load really is.

Drive, motor, screw with a gap, and slide, every 62.5 us, with a compensator in the drive. A slow
sine reverses often, and at each reversal the slide stays behind by what the method leaves of the
gap. As `one_axis.rs`.
"""

import numpy as np

import lostmotion

machine = lostmotion.Machine.preset("vmc3-worn")
gap_um = machine.to_dict()["axis"]["x"]["load"]["slide"]["gap_um"]
print(f"gap of X: {gap_um:.0f} um")

# 5 mm to either side, 0.4 Hz: commanded position, velocity, acceleration each millisecond.
rate = 2.5
phase = rate * np.arange(6000) * 1e-3
sine, cosine = np.sin(phase), np.cos(phase)

for method in ("none", "fixed", "adaptive"):
    # With velocity and acceleration at hand the drive interpolates by its own law.
    axis = lostmotion.Axis(machine, "x", method=method, differences=False)
    trace = axis.push(5.0 * sine, velocity=5.0 * rate * cosine, acceleration=-5.0 * rate * rate * sine)

    # Lost motion: reference minus load at each servo tick, after the first second.
    worst = np.abs(trace["reference_mm"] - trace["load_mm"])[4000:].max()
    print(f"{method}: largest following error {worst * 1e3:.0f} um")
