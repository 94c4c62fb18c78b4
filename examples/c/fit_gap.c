/*
 * The gap of an axis from a log of motor and load.
 *
 * A real log comes from a drive's trace; here the simulated axis writes one. The fit answers with a value
 * and the interval that the log supports. As fit_gap.rs.
 */

#include "check.h"
#include <math.h>

enum { CYCLES = 10000, TICKS = 4, ROWS = CYCLES * TICKS };

static double time_s[ROWS], motor[ROWS], load[ROWS], current_a[ROWS];

int main(void)
{
    LmMachine *machine = NULL;
    LmAxis *axis = NULL;
    CHECK(lm_machine_preset("vmc3-worn", &machine));
    CHECK(lm_axis_new(machine, "y", "none", 0.0, false, &axis));

    /* Ten seconds of a sine, every servo tick traced. */
    const double rate = 3.0;
    for (int n = 0; n < CYCLES; n++) {
        const double phase = rate * n * 1e-3;
        const LmSetpoint setpoint = {
            .position = 8.0 * sin(phase),
            .velocity = 8.0 * rate * cos(phase),
            .acceleration = -8.0 * rate * rate * sin(phase),
            .given = LM_SETPOINT_VELOCITY | LM_SETPOINT_ACCELERATION,
        };
        LmAxisSample samples[TICKS];
        CHECK(lm_axis_step(axis, &setpoint, samples, TICKS));
        for (int tick = 0; tick < TICKS; tick++) {
            const int row = n * TICKS + tick;
            time_s[row] = samples[tick].time_s;
            motor[row] = samples[tick].motor;
            load[row] = samples[tick].load;
            current_a[row] = samples[tick].current_a;
        }
    }

    /* The fit knows the motor's data sheet and what turns with it; the gap is what it looks for. */
    const LmLog log = {
        .unit = "mm",
        .count = ROWS,
        .time_s = time_s,
        .motor = motor,
        .load = load,
        .current_a = current_a,
    };
    LmFit fit;
    CHECK(lm_fit(&log, machine, "y", &fit, NULL));

    double true_um = 0.0;
    CHECK(lm_machine_number(machine, "axis.y.load.slide.gap_um", &true_um));
    printf("true gap %.1f um, fitted %.1f um (95 %%: %.1f to %.1f)\n", true_um, 1e3 * fit.gap,
           1e3 * fit.gap_low, 1e3 * fit.gap_high);
    CHECK(lm_axis_free(axis));
    CHECK(lm_machine_free(machine));
    return 0;
}
