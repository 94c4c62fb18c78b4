/*
 * One axis from setpoints to where its load really is.
 *
 * Drive, motor, screw with a gap, and slide, every 62.5 us, with a compensator in the drive. A slow sine
 * reverses often, and at each reversal the slide stays behind by what the method leaves of the gap. The
 * loop is fit for a real-time thread. As one_axis.rs.
 */

#include "check.h"
#include <math.h>

int main(void)
{
    LmMachine *machine = NULL;
    CHECK(lm_machine_preset("vmc3-worn", &machine));
    double gap_um = 0.0;
    CHECK(lm_machine_number(machine, "axis.x.load.slide.gap_um", &gap_um));
    printf("gap of X: %.0f um\n", gap_um);

    static const char *const methods[] = {"none", "fixed", "adaptive"};
    for (size_t index = 0; index < sizeof methods / sizeof *methods; index++) {
        /* With velocity and acceleration at hand the drive interpolates by its own law. */
        LmAxis *axis = NULL;
        CHECK(lm_axis_new(machine, "x", methods[index], 0.0, false, &axis));

        /* 5 mm to either side, 0.4 Hz: position, velocity, acceleration each millisecond. */
        const double rate = 2.5;
        double worst = 0.0;
        for (int n = 0; n < 6000; n++) {
            const double phase = rate * n * 1e-3;
            const LmSetpoint setpoint = {
                .position = 5.0 * sin(phase),
                .velocity = 5.0 * rate * cos(phase),
                .acceleration = -5.0 * rate * rate * sin(phase),
                .given = LM_SETPOINT_VELOCITY | LM_SETPOINT_ACCELERATION,
            };
            LmAxisSample samples[4];
            CHECK(lm_axis_step(axis, &setpoint, samples, 4));

            /* Lost motion: reference minus load at each servo tick, after the first second. */
            for (int tick = 0; n >= 1000 && tick < 4; tick++)
                worst = fmax(worst, fabs(samples[tick].reference - samples[tick].load));
        }
        printf("%s: largest following error %.0f um\n", methods[index], worst * 1e3);
        CHECK(lm_axis_free(axis));
    }
    CHECK(lm_machine_free(machine));
    return 0;
}
