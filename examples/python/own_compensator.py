"""The whole chain with a compensator of one's own, held against the library's.

A compensator is an object that is asked at the servo rate: it sees what a drive sees and answers
with a correction. This one adds half the gap at once where the commanded velocity changes its sign.
In Python it is slow; `own_compensator.rs` is the same at full speed.
"""

import lostmotion
from lostmotion.compensators import AxisFacts


class Step:
    def __init__(self, facts: AxisFacts) -> None:
        self.half_gap_rad = 0.5 * facts.gap_rad
        # the direction of the last motion
        self.direction = 0.0

    def step(self, tick: lostmotion.Tick) -> float:
        if abs(tick.velocity) > 1e-6:
            self.direction = 1.0 if tick.velocity > 0.0 else -1.0
        return self.direction * self.half_gap_rad


program = lostmotion.Program("G21 G90 G17 G94\nG0 X20 Y0 Z5\nG3 I-20 P3 F1500\nM2\n", "circle.ngc")
run = lostmotion.simulate(program, "vmc3-worn", methods=["none", "fixed"], compensators={"step": Step})
for result in run.results:
    print(f"{result.method}: backlash RMS {result.backlash.rms:.1f} um")
print(f"recommended: {run.recommended or '-'}")
