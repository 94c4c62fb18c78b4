/*
 * One axis from setpoints to where its load really is. As one_axis.rs.
 */

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <lostmotion.hpp>

int main()
{
    using namespace lostmotion;
    const auto machine = Machine::preset("vmc3-worn");
    std::printf("gap of X: %.0f um\n", machine.number("axis.x.load.slide.gap_um"));

    for (const char *method : {"none", "fixed", "adaptive"}) {
        Axis axis(machine, "x", method, 0.0, false);
        const double rate = 2.5;
        double worst = 0.0;
        for (int n = 0; n < 6000; n++) {
            const double phase = rate * n * 1e-3, sine = std::sin(phase);
            LmAxisSample samples[4];
            axis.step(moving(5.0 * sine, 5.0 * rate * std::cos(phase), -5.0 * rate * rate * sine),
                      samples, 4);
            for (const auto &sample : samples)
                if (n >= 1000)
                    worst = std::max(worst, std::abs(sample.reference - sample.load));
        }
        std::printf("%s: largest following error %.0f um\n", method, worst * 1e3);
    }
}
