/*
 * The whole chain with a compensator of one's own, held against the library's.
 *
 * A compensator runs at the servo rate: it sees what a drive sees and answers with a correction. This one
 * adds half the gap at once where the commanded velocity changes its sign. As own_compensator.rs.
 */

#include "check.h"
#include <math.h>

/* What a compensator carries from tick to tick, one for each axis. */
typedef struct {
    double half_gap_rad;
    /* the direction of the last motion */
    double direction;
} Step;

static void *create(void *user, const LmAxisFacts *facts, double motor_position)
{
    (void)user, (void)motor_position;
    Step *step = malloc(sizeof *step);
    if (step)
        *step = (Step){.half_gap_rad = 0.5 * facts->gap_rad, .direction = 0.0};
    return step;
}

static void *copy(const void *state)
{
    Step *step = malloc(sizeof *step);
    if (step)
        *step = *(const Step *)state;
    return step;
}

static void destroy(void *state)
{
    free(state);
}

static void tick(void *state, const LmTick *seen, LmCorrection *correction)
{
    Step *step = state;
    if (fabs(seen->velocity) > 1e-6)
        step->direction = copysign(1.0, seen->velocity);
    correction->position = step->direction * step->half_gap_rad;
}

int main(void)
{
    static const char code[] = "G21 G90 G17 G94\nG0 X20 Y0 Z5\nG3 I-20 P3 F1500\nM2\n";
    LmProgram *program = NULL;
    LmMachine *machine = NULL;
    LmSimulation *simulation = NULL;
    CHECK(lm_program_from_text("circle.ngc", code, sizeof code - 1, &program));
    CHECK(lm_machine_preset("vmc3-worn", &machine));
    CHECK(lm_simulation_new(program, machine, &simulation));
    CHECK(lm_simulation_method(simulation, "none"));
    CHECK(lm_simulation_method(simulation, "fixed"));
    const LmCompensator step = {
        .size = sizeof step,
        .name = "step",
        .create = create,
        .copy = copy,
        .destroy = destroy,
        .step = tick,
    };
    CHECK(lm_simulation_compensator(simulation, &step));
    LmRun *run = NULL;
    CHECK(lm_simulation_run(simulation, &run));

    LmRunInfo info;
    CHECK(lm_run_info(run, &info));
    for (size_t index = 0; index < info.results; index++) {
        LmMethodResult result;
        CHECK(lm_run_result(run, index, &result));
        printf("%s: backlash RMS %.1f um\n", result.method, result.backlash.rms);
    }
    printf("recommended: %s\n", info.recommended ? info.recommended : "-");

    CHECK(lm_run_free(run));
    CHECK(lm_simulation_free(simulation));
    CHECK(lm_machine_free(machine));
    CHECK(lm_program_free(program));
    return 0;
}
