"""The whole chain: from a part program to its contour error on a real machine, block by block.

Every error splits into what the command does itself (rounded corners), what a machine without a
gap would add (servo), and what the gap adds (backlash). As `simulate.rs`.
"""

import lostmotion

program = lostmotion.Program(
    "G21 G90 G17 G94 G64 P0.005\nG0 X15 Y0 Z5\nG3 I-15 F1800\nG1 X0 Y15\nG1 X-15 Y0\nM2\n", "part.ngc"
)

# Other Python threads go on meanwhile; the callback ends the run by answering False.
run = lostmotion.simulate(
    program,
    "vmc3",
    method="none",
    tolerance_um=10.0,
    on_progress=lambda progress: progress.simulated_s <= 3600.0,
)

print("within" if run.within_tolerance else "outside", f"{run.data.tolerance_um:g} um")
for block in run["none"].worst_blocks:
    parts = block.parts_um
    print(
        f"line {block.block.span.line} `{block.text}`: {block.max_um:+.1f} um = command {parts.command:+.1f}, "
        f"servo {parts.servo:+.1f}, backlash {parts.backlash:+.1f}; {block.cause}"
    )
