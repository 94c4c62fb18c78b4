/*
 * The whole chain: from a part program to its contour error on a real machine, block by block.
 *
 * Every error splits into what the command does itself (rounded corners), what a machine without a gap
 * would add (servo), and what the gap adds (backlash). As simulate.rs.
 */

#include "check.h"

/* A run stays on this thread unless the setting "threads" says otherwise; false ends it. */
static bool goes_on(void *user, const LmProgress *progress)
{
    const double *most_s = user;
    return progress->simulated_s <= *most_s;
}

int main(void)
{
    static const char code[] =
        "G21 G90 G17 G94 G64 P0.005\nG0 X15 Y0 Z5\nG3 I-15 F1800\nG1 X0 Y15\nG1 X-15 Y0\nM2\n";
    LmProgram *program = NULL;
    LmMachine *machine = NULL;
    CHECK(lm_program_from_text("part.ngc", code, sizeof code - 1, &program));
    CHECK(lm_machine_preset("vmc3", &machine));

    LmSimulation *simulation = NULL;
    CHECK(lm_simulation_new(program, machine, &simulation));
    CHECK(lm_simulation_method(simulation, "none"));
    CHECK(lm_simulation_set(simulation, "tolerance_um", 10.0));
    double most_s = 3600.0;
    CHECK(lm_simulation_on_progress(simulation, goes_on, &most_s));
    LmRun *run = NULL;
    CHECK(lm_simulation_run(simulation, &run));

    LmRunInfo info;
    CHECK(lm_run_info(run, &info));
    printf("%s %g um\n", info.within_tolerance ? "within" : "outside", info.tolerance_um);
    LmMethodResult result;
    CHECK(lm_run_result(run, 0, &result));
    for (size_t index = 0; index < result.worst_blocks; index++) {
        LmBlock block;
        CHECK(lm_run_worst_block(run, 0, index, &block));
        printf("line %u `%s`: %+.1f um = command %+.1f, servo %+.1f, backlash %+.1f; %s\n",
               (unsigned)block.line, block.text, block.max_um, block.command_um, block.servo_um,
               block.backlash_um, block.cause);
    }

    CHECK(lm_run_free(run));
    CHECK(lm_simulation_free(simulation));
    CHECK(lm_machine_free(machine));
    CHECK(lm_program_free(program));
    return 0;
}
