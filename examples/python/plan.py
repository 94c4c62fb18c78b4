"""From curves to samples of every joint, one each command cycle (1 ms), within all limits of
velocity, acceleration and jerk.

A corner under G64 is rounded within its tolerance; under G61 the tool comes to rest in it. The
difference in time is what the tolerance buys. As `plan.rs`.
"""

import numpy as np

import lostmotion

for mode in ("G61", "G64 P0.005", "G64 P0.05"):
    program = lostmotion.Program(f"G21 G90 G94 {mode}\nG0 X0 Y0 Z5\nG1 X30 F6000\nG1 Y30\nM2\n", "corner.ngc")
    plan = lostmotion.plan(program, "vmc3")
    peak = np.abs(plan.samples["x_acceleration_mm_s2"]).max()
    print(
        f"{mode}: {plan.duration_s:.3f} s for {plan.cutting_mm:.1f} mm of cutting, "
        f"X accelerates with up to {peak:.0f} mm/s2"
    )
