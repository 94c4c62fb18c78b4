/*
 * The whole chain with a compensator of one's own, held against the library's. As own_compensator.rs.
 */

#include <cmath>
#include <cstdio>
#include <lostmotion.hpp>

class Step {
  public:
    explicit Step(const LmAxisFacts &facts) : half_gap_rad(0.5 * facts.gap_rad) {}

    LmCorrection step(const LmTick &tick)
    {
        if (std::abs(tick.velocity) > 1e-6)
            direction = std::copysign(1.0, tick.velocity);
        return {direction * half_gap_rad, 0.0, 0.0, 0.0};
    }

  private:
    double half_gap_rad;
    /* of the last motion */
    double direction = 0.0;
};

int main()
{
    using namespace lostmotion;
    const auto program = Program::from_text(
        "circle.ngc", "G21 G90 G17 G94\nG0 X20 Y0 Z5\nG3 I-20 P3 F1500\nM2\n");
    Simulation simulation(program, Machine::preset("vmc3-worn"));
    const auto run = simulation.method("none")
                         .method("fixed")
                         .compensator(compensator<Step>("step"))
                         .run();
    for (const auto &result : run.results())
        std::printf("%s: backlash RMS %.1f um\n", result.method, result.backlash.rms);
    const char *recommended = run.info().recommended;
    std::printf("recommended: %s\n", recommended ? recommended : "-");
}
