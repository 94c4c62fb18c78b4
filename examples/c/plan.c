/*
 * From curves to samples of every joint, one each command cycle (1 ms), within all limits of velocity,
 * acceleration and jerk.
 *
 * A corner under G64 is rounded within its tolerance; under G61 the tool comes to rest in it. The
 * difference in time is what the tolerance buys. As plan.rs.
 */

#include "check.h"
#include <math.h>
#include <string.h>

/* Takes the samples as they are made: a program of any length takes no memory. */
static bool take(void *user, const LmPlanSample *samples, size_t count)
{
    double *peak = user;
    for (size_t index = 0; index < count; index++)
        *peak = fmax(*peak, fabs(samples[index].acceleration[0]));
    return true;
}

int main(void)
{
    LmMachine *machine = NULL;
    CHECK(lm_machine_preset("vmc3", &machine));
    static const char *const modes[] = {"G61", "G64 P0.005", "G64 P0.05"};
    for (size_t index = 0; index < sizeof modes / sizeof *modes; index++) {
        char code[80];
        snprintf(code, sizeof code, "G21 G90 G94 %s\nG0 X0 Y0 Z5\nG1 X30 F6000\nG1 Y30\nM2\n",
                 modes[index]);
        LmProgram *program = NULL;
        LmSimulation *simulation = NULL;
        CHECK(lm_program_from_text("corner.ngc", code, strlen(code), &program));
        CHECK(lm_simulation_new(program, machine, &simulation));
        double peak = 0.0;
        CHECK(lm_simulation_on_plan(simulation, take, &peak));
        LmPlan plan;
        CHECK(lm_simulation_plan(simulation, &plan));
        printf("%s: %.3f s for %.1f mm of cutting, X accelerates with up to %.0f mm/s2\n",
               modes[index], plan.duration_s, plan.cutting_mm, peak);
        CHECK(lm_simulation_free(simulation));
        CHECK(lm_program_free(program));
    }
    CHECK(lm_machine_free(machine));
    return 0;
}
