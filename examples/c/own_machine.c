/*
 * The whole chain on a machine that is made in code: checked like a file.
 *
 * A plotter of two axes, first with a tight gap, then edited to a wide one. A description that makes no
 * sense is refused with the keys of a machine file. As own_machine.rs.
 */

#include "check.h"

/* An axis as a machine file has it, for a letter: that of the X of an embedded mill, with limits of its
 * own. */
#define AXIS(letter)                                                                               \
    "[axis." letter ".limits]\n"                                                                   \
    "min_mm = -200.0\nmax_mm = 200.0\nvelocity_mm_s = 150.0\n"                                     \
    "acceleration_mm_s2 = 1500.0\njerk_mm_s3 = 30000.0\n"                                          \
    "[axis." letter ".transmission.linear]\nlead_mm = 16.0\n"                                      \
    "[axis." letter ".motor]\n"                                                                    \
    "resistance_ohm = 0.42\ninductance_h = 0.0045\npoles = 10\ninertia_kgm2 = 0.00189\n"           \
    "torque_constant_nm_per_a = 1.08\nrated_torque_nm = 11.0\n"                                    \
    "viscous_nm_s_per_rad = 0.002\ncoulomb_nm = 0.15\n"                                            \
    "[axis." letter ".load.slide]\n"                                                               \
    "screw_inertia_kgm2 = 0.00198\nmass_kg = 300.0\nviscous_n_s_per_m = 500.0\n"                   \
    "coulomb_n = 300.0\nstiffness_n_per_um = 238.0\ndamping_n_s_per_mm = 22.0\n"                   \
    "gap_um = 5.0\nscale_um = 0.1\n"                                                               \
    "[axis." letter ".drive]\n"                                                                    \
    "current_gain_v_per_a = 11.31\ncurrent_time_s = 0.01071\n"                                     \
    "velocity_gain_a_s_per_rad = 2.702\nvelocity_time_s = 0.007943\n"                              \
    "position_gain_per_s = 62.8\nvelocity_feedforward = 1.0\n"                                     \
    "acceleration_feedforward = 1.0\ncurrent_limit_a = 28.0\nbus_voltage_v = 560.0\n"              \
    "encoder_counts_per_rev = 1048576\nvoltage_delay_periods = 1\n"

static const char plotter[] =
    "name = \"plotter\"\n[kinematics]\nkind = \"cartesian\"\n" AXIS("x") AXIS("y");

int main(void)
{
    static const char code[] = "G21 G90 G17 G94\nG0 X30 Y0\nG3 I-30 P2 F2400\nM2\n";
    LmProgram *program = NULL;
    CHECK(lm_program_from_text("circle.ngc", code, sizeof code - 1, &program));

    LmMachine *machines[2] = {NULL, NULL};
    CHECK(lm_machine_from_toml("plotter", plotter, &machines[0]));
    static const char *const names[] = {"plotter", "worn plotter"};
    const char *const keys[] = {"name", "axis.x.load.slide.gap_um"};
    const char *const values[] = {"\"worn plotter\"", "40.0"};
    CHECK(lm_machine_edit(machines[0], keys, values, 2, &machines[1]));
    for (size_t index = 0; index < 2; index++) {
        LmSimulation *simulation = NULL;
        LmRun *run = NULL;
        CHECK(lm_simulation_new(program, machines[index], &simulation));
        CHECK(lm_simulation_run(simulation, &run));
        LmMethodResult first;
        CHECK(lm_run_result(run, 0, &first));
        printf("%s: %s leaves %.1f um of backlash at most\n", names[index], first.method,
               first.backlash.max);
        CHECK(lm_run_free(run));
        CHECK(lm_simulation_free(simulation));
    }

    const char *const key = "axis.y.drive.position_gain_per_s", *const value = "-1.0";
    LmMachine *refused = NULL;
    LmError error;
    if (lm_machine_edit(machines[1], &key, &value, 1, &refused) == LM_STATUS_MACHINE) {
        CHECK(lm_error(&error));
        for (size_t index = 0; index < error.findings; index++) {
            LmFinding found;
            CHECK(lm_error_finding(index, &found));
            printf("%s: %s\n", found.key, found.message);
        }
    }

    CHECK(lm_machine_free(machines[0]));
    CHECK(lm_machine_free(machines[1]));
    CHECK(lm_program_free(program));
    return 0;
}
