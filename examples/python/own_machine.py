"""The whole chain on a machine that is made in code: checked like a file.

A plotter of two axes, first with a tight gap, then edited to a wide one. A description that makes no
sense is refused with the keys of a machine file. As `own_machine.rs`.
"""

import copy

import lostmotion


def plotter() -> lostmotion.Machine:
    # The X axis of an embedded mill is a good start; every key of it may be changed.
    mill = lostmotion.Machine.preset("vmc3").to_dict()
    axis = mill["axis"]["x"]
    axis["limits"] = {
        "min_mm": -200.0,
        "max_mm": 200.0,
        "velocity_mm_s": 150.0,
        "acceleration_mm_s2": 1500.0,
        "jerk_mm_s3": 30_000.0,
    }
    axis["load"]["slide"]["gap_um"] = 5.0
    axes = {letter: copy.deepcopy(axis) for letter in "xy"}
    return lostmotion.Machine.from_dict(
        {"name": "plotter", "kinematics": {"kind": "cartesian"}, "axis": axes}
    )


program = lostmotion.Program("G21 G90 G17 G94\nG0 X30 Y0\nG3 I-30 P2 F2400\nM2\n", "circle.ngc")
tight = plotter()
wide = tight.edit({"name": "worn plotter", "axis.x.load.slide.gap_um": 40.0})
for machine in (tight, wide):
    first = lostmotion.simulate(program, machine).results[0]
    print(f"{machine.name}: {first.method} leaves {first.backlash.max:.1f} um of backlash at most")

try:
    wide.edit({"axis.y.drive.position_gain_per_s": -1.0})
except lostmotion.MachineError as error:
    for found in error.findings:
        print(f"{found.values['key']}: {found.message}")
