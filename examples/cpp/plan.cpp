/*
 * From curves to samples of every joint, one each command cycle (1 ms). As plan.rs.
 */

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <lostmotion.hpp>

int main()
{
    using namespace lostmotion;
    const auto machine = Machine::preset("vmc3");
    for (const std::string mode : {"G61", "G64 P0.005", "G64 P0.05"}) {
        const auto program = Program::from_text(
            "corner.ngc", "G21 G90 G94 " + mode + "\nG0 X0 Y0 Z5\nG1 X30 F6000\nG1 Y30\nM2\n");
        double peak = 0.0;
        Simulation simulation(program, machine);
        const auto plan = simulation
                              .on_plan([&](const LmPlanSample *samples, std::size_t count) {
                                  for (std::size_t index = 0; index < count; index++)
                                      peak = std::max(peak, std::abs(samples[index].acceleration[0]));
                                  return true;
                              })
                              .plan();
        std::printf("%s: %.3f s for %.1f mm of cutting, X accelerates with up to %.0f mm/s2\n",
                    mode.c_str(), plan.duration_s, plan.cutting_mm, peak);
    }
}
