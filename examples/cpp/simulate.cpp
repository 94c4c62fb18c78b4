/*
 * The whole chain: from a part program to its contour error on a real machine, block by block. As
 * simulate.rs.
 */

#include <cstdio>
#include <lostmotion.hpp>

int main()
{
    using namespace lostmotion;
    const auto program = Program::from_text(
        "part.ngc",
        "G21 G90 G17 G94 G64 P0.005\nG0 X15 Y0 Z5\nG3 I-15 F1800\nG1 X0 Y15\nG1 X-15 Y0\nM2\n");
    Simulation simulation(program, Machine::preset("vmc3"));
    const auto run =
        simulation.method("none")
            .set("tolerance_um", 10.0)
            .on_progress([](const LmProgress &progress) { return progress.simulated_s <= 3600.0; })
            .run();

    const auto info = run.info();
    std::printf("%s %g um\n", info.within_tolerance ? "within" : "outside", info.tolerance_um);
    for (const auto &block : run.worst_blocks())
        std::printf("line %u `%s`: %+.1f um = command %+.1f, servo %+.1f, backlash %+.1f; %s\n",
                    static_cast<unsigned>(block.line), block.text, block.max_um, block.command_um,
                    block.servo_um, block.backlash_um, block.cause);
}
