/*
 * The gap of an axis from a log of motor and load. As fit_gap.rs.
 */

#include <cmath>
#include <cstdio>
#include <lostmotion.hpp>
#include <vector>

int main()
{
    using namespace lostmotion;
    const auto machine = Machine::preset("vmc3-worn");
    Axis axis(machine, "y", "none", 0.0, false);
    const double rate = 3.0;
    std::vector<double> time_s, motor, load, current_a;
    for (int n = 0; n < 10000; n++) {
        const double phase = rate * n * 1e-3, sine = std::sin(phase);
        LmAxisSample samples[4];
        axis.step(moving(8.0 * sine, 8.0 * rate * std::cos(phase), -8.0 * rate * rate * sine),
                  samples, 4);
        for (const auto &sample : samples) {
            time_s.push_back(sample.time_s);
            motor.push_back(sample.motor);
            load.push_back(sample.load);
            current_a.push_back(sample.current_a);
        }
    }
    const LmLog log = {"mm",        time_s.size(), time_s.data(), motor.data(),
                       load.data(), current_a.data()};
    LmFit fit;
    check(lm_fit(&log, machine.get(), "y", &fit, nullptr));
    std::printf("true gap %.1f um, fitted %.1f um (95 %%: %.1f to %.1f)\n",
                machine.number("axis.y.load.slide.gap_um"), 1e3 * fit.gap, 1e3 * fit.gap_low,
                1e3 * fit.gap_high);
}
