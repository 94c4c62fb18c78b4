/*
 * What must not be done is told, and harms nothing: nulls, handles that were freed, of another kind or
 * made up, sizes, values that are no numbers, texts that are no UTF-8, a handle in use.
 */

#include <lostmotion.h>
#include <math.h>
#include <pthread.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static int faults;

static void want(int line, LmStatus got, LmStatus wanted, const char *part)
{
    LmError error;
    (void)lm_error(&error);
    int told = wanted == LM_STATUS_OK ||
               (error.status == wanted && (!part || strstr(error.message, part)));
    if (got == wanted && told)
        return;
    fprintf(stderr, "line %d: answered %d, wanted %d: [%s] %s\n", line, (int)got, (int)wanted,
            error.code, error.message);
    faults++;
}

#define WANT(call, status, part) want(__LINE__, (call), LM_STATUS_##status, (part))
#define THAT(condition)                                                                            \
    do {                                                                                           \
        if (!(condition)) {                                                                        \
            fprintf(stderr, "line %d: not so: %s\n", __LINE__, #condition);                        \
            faults++;                                                                              \
        }                                                                                          \
    } while (0)

static LmSimulation *the_simulation;

/* Inside a run: its own simulation is in use, and the run can be ended. */
static bool reenter(void *user, const LmProgress *progress)
{
    (void)progress;
    LmRun *run = NULL;
    LmPlan plan;
    WANT(lm_simulation_free(the_simulation), BUSY, "in use");
    WANT(lm_simulation_set(the_simulation, "threads", 1), BUSY, "in use");
    WANT(lm_simulation_run(the_simulation, &run), BUSY, "in use");
    WANT(lm_simulation_plan(the_simulation, &plan), BUSY, "in use");
    WANT(lm_simulation_cancel(the_simulation), OK, NULL);
    ++*(int *)user;
    return true;
}

static bool ends(void *user, size_t method, const LmContourSample *samples, size_t count)
{
    (void)user, (void)method;
    return !(count && samples[0].time_s >= 0.0);
}

static void *create(void *user, const LmAxisFacts *facts, double at)
{
    (void)facts, (void)at;
    return user ? NULL : malloc(1);
}

static void *copy(const void *state)
{
    (void)state;
    return malloc(1);
}

static void step(void *state, const LmTick *tick, LmCorrection *correction)
{
    (void)state, (void)tick;
    correction->position = NAN;
}

static void *other_thread(void *argument)
{
    /* another thread has its own errors, and frees what it is given */
    LmError error;
    THAT(lm_error(&error) == LM_STATUS_OK && error.status == LM_STATUS_OK);
    WANT(lm_program_free(argument), OK, NULL);
    return NULL;
}

int main(void)
{
    LmError error;
    LmProgram *program = NULL, *second = NULL;
    LmMachine *machine = NULL, *edited = NULL;
    LmSimulation *simulation = NULL;
    LmRun *run = NULL;
    LmText *text = NULL;
    LmAxis *axis = NULL;
    const char *characters = NULL;
    double number = 0.0;
    static const char code[] = "G21 G90\nG1 X40 F3000\nX0\nX40\nX0\nX40\nM2\n";

    THAT(lm_abi() == LM_ABI && strlen(lm_version()) > 0);
    THAT(lm_error(&error) == LM_STATUS_OK && error.status == LM_STATUS_OK && !*error.message);

    /* nulls */
    WANT(lm_error(NULL), NULL, "error is null");
    WANT(lm_program_from_text(NULL, code, 5, &program), NULL, "name is null");
    WANT(lm_program_from_text("p", NULL, 5, &program), NULL, "code is null");
    WANT(lm_program_from_text("p", code, 5, NULL), NULL, "program is null");
    WANT(lm_machine_preset(NULL, &machine), NULL, "name is null");
    WANT(lm_simulation_new(NULL, NULL, &simulation), NULL, "program is null");
    WANT(lm_run_free(NULL), OK, NULL);
    WANT(lm_program_from_text("empty", NULL, 0, &second), OK, NULL);
    WANT(lm_program_free(second), OK, NULL);

    /* freed handles, other kinds, handles that are none */
    WANT(lm_program_from_text("part.ngc", code, sizeof code - 1, &program), OK, NULL);
    WANT(lm_machine_preset("vmc3", &machine), OK, NULL);
    WANT(lm_program_free(second), HANDLE, "has been freed");
    WANT(lm_simulation_new(second, machine, &simulation), HANDLE, "has been freed");
    WANT(lm_machine_free((LmMachine *)(void *)program), HANDLE, "no handle of a machine");
    WANT(lm_simulation_new((LmProgram *)(void *)machine, machine, &simulation), HANDLE,
         "no handle of a program");
    WANT(lm_program_free((LmProgram *)(void *)&faults), HANDLE, NULL);
    WANT(lm_program_free((LmProgram *)(uintptr_t)1), HANDLE, NULL);
    WANT(lm_program_free((LmProgram *)((uintptr_t)program + 1)), HANDLE, NULL);
    WANT(lm_program_free((LmProgram *)((uintptr_t)program | 0xffffffffu)), HANDLE, NULL);

    /* values */
    WANT(lm_machine_preset("vmc33", &edited), MACHINE, "vmc33");
    WANT(lm_machine_preset("\xff", &edited), OPTION, "UTF-8");
    const char *key = "axis.x.load.slide.gap_um", *value = "-3.0", *nothing = NULL;
    WANT(lm_machine_edit(machine, &key, &value, 1, &edited), MACHINE, "gap_um");
    WANT(lm_machine_edit(machine, &key, &nothing, 1, &edited), NULL, "a value is null");
    WANT(lm_machine_edit(machine, &key, &value, SIZE_MAX, &edited), SIZE, "keys");
    WANT(lm_machine_number(machine, "axis.x", &number), OPTION, "axis.x");
    WANT(lm_machine_from_toml("m.toml", "name = 3\n", &edited), MACHINE, "m.toml:1");
    THAT(lm_error(&error) == LM_STATUS_OK && error.line == 1 && error.findings >= 1);
    THAT(lm_error_finding(error.findings, &(LmFinding){0}) == LM_STATUS_SIZE);

    WANT(lm_simulation_new(program, machine, &simulation), OK, NULL);
    WANT(lm_simulation_set(simulation, "tolerance_um", NAN), OPTION, "NaN");
    WANT(lm_simulation_set(simulation, "tolerance", 3), OPTION, "no setting \"tolerance\"");
    WANT(lm_simulation_set(simulation, "threads", 1.5), OPTION, "threads");
    WANT(lm_simulation_set(simulation, "dialect", 3), OPTION, "dialect");
    WANT(lm_simulation_set_text(simulation, "dialect", "fanucc"), OK, NULL);
    WANT(lm_simulation_run(simulation, &run), OPTION, "fanucc");
    WANT(lm_simulation_set_text(simulation, "dialect", "linuxcnc"), OK, NULL);
    WANT(lm_simulation_set_json(simulation, "limits", "{"), OPTION, "JSON");
    WANT(lm_simulation_set_json(simulation, "interventions", "[[1.0, \"jump\", null]]"), OK, NULL);
    WANT(lm_simulation_run(simulation, &run), OPTION, "jump");
    WANT(lm_simulation_set_json(simulation, "interventions", "[]"), OK, NULL);
    WANT(lm_simulation_method(simulation, "nome"), OK, NULL);
    WANT(lm_simulation_run(simulation, &run), METHOD, "nome");
    WANT(lm_simulation_free(simulation), OK, NULL);
    WANT(lm_simulation_free(simulation), HANDLE, "has been freed");

    /* a program that is wrong, with its place */
    WANT(lm_program_from_text("wrong.ngc", "G21 G90\nG1 Z-\nM2\n", 17, &second), OK, NULL);
    WANT(lm_simulation_new(second, machine, &simulation), OK, NULL);
    WANT(lm_simulation_run(simulation, &run), PROGRAM, "wrong.ngc:2:");
    THAT(lm_error(&error) == LM_STATUS_OK && error.line == 2 && error.column > 0);
    WANT(lm_simulation_free(simulation), OK, NULL);
    pthread_t thread;
    THAT(pthread_create(&thread, NULL, other_thread, second) == 0);
    pthread_join(thread, NULL);
    WANT(lm_program_free(second), HANDLE, "has been freed");

    /* callbacks */
    int called = 0;
    WANT(lm_simulation_new(program, machine, &the_simulation), OK, NULL);
    WANT(lm_simulation_on_progress(the_simulation, reenter, &called), OK, NULL);
    WANT(lm_simulation_run(the_simulation, &run), CANCELLED, "cancelled");
    THAT(called == 1);
    WANT(lm_simulation_on_progress(the_simulation, NULL, NULL), OK, NULL);
    WANT(lm_simulation_on_contour(the_simulation, ends, NULL), OK, NULL);
    WANT(lm_simulation_run(the_simulation, &run), CANCELLED, "cancelled");
    WANT(lm_simulation_on_contour(the_simulation, NULL, NULL), OK, NULL);

    /* compensators */
    LmCompensator own = {.size = sizeof own, .name = "own", .create = create, .copy = copy,
                         .destroy = free};
    WANT(lm_simulation_compensator(the_simulation, &own), OPTION, "null");
    own.step = step;
    own.size = 8;
    WANT(lm_simulation_compensator(the_simulation, &own), SIZE, "compensator.size");
    own.size = sizeof own;
    WANT(lm_simulation_compensator(the_simulation, &own), OK, NULL);
    WANT(lm_simulation_run(the_simulation, &run), METHOD, "\"own\" has failed");
    WANT(lm_axis_with_compensator(machine, "x", &own, 0.0, true, &axis), OK, NULL);
    LmAxisSample samples[8];
    LmSetpoint setpoint = {.position = 0.0};
    WANT(lm_axis_step(axis, &setpoint, samples, 4), METHOD, "failed");
    WANT(lm_axis_step(axis, &setpoint, samples, 4), SIZE, "ticks left");
    WANT(lm_axis_free(axis), OK, NULL);
    own.user = &own;
    WANT(lm_axis_with_compensator(machine, "x", &own, 0.0, true, &axis), METHOD, "failed");
    WANT(lm_simulation_free(the_simulation), OK, NULL);

    /* runs */
    WANT(lm_simulation_new(program, machine, &simulation), OK, NULL);
    WANT(lm_simulation_run(simulation, &run), OK, NULL);
    LmMethodResult result;
    LmBlock block;
    WANT(lm_run_result(run, 1, &result), SIZE, "index");
    WANT(lm_run_worst_block(run, 0, 1000, &block), SIZE, "index");
    WANT(lm_run_number(run, "/results/0/cutting/maximum", &number), OPTION, "no number");
    WANT(lm_run_number(run, "/results/0/cutting/max", &number), OK, NULL);
    WANT(lm_run_result(run, 0, &result), OK, NULL);
    THAT(number == result.cutting.max);
    WANT(lm_run_page(run, &text), OPTION, "no page");
    WANT(lm_run_text(run, &text), OK, NULL);
    WANT(lm_text(text, &characters, NULL), OK, NULL);
    THAT(strstr(characters, "part.ngc on vmc3"));
    WANT(lm_text_free(text), OK, NULL);
    WANT(lm_text(text, &characters, NULL), HANDLE, "has been freed");
    WANT(lm_run_free(run), OK, NULL);
    WANT(lm_run_free(run), HANDLE, "has been freed");
    WANT(lm_simulation_free(simulation), OK, NULL);

    /* axes */
    WANT(lm_axis_new(machine, "q", "none", 0.0, true, &axis), OPTION, "no axis \"q\"");
    WANT(lm_axis_new(machine, "x", "nome", 0.0, true, &axis), METHOD, "nome");
    WANT(lm_axis_new(machine, "x", "none", NAN, true, &axis), METHOD, "start position");
    WANT(lm_axis_from_description("pap", "none", 0.0, true, &axis), OPTION, "pap");
    WANT(lm_axis_new(machine, "x", "none", 0.0, true, &axis), OK, NULL);
    WANT(lm_axis_step(axis, &setpoint, samples, 3), SIZE, "sample count: 3, it has to be 4");
    WANT(lm_axis_step(axis, &setpoint, NULL, 4), NULL, "samples is null");
    WANT(lm_axis_step(axis, (LmSetpoint *)((uintptr_t)&setpoint + 1), samples, 4), SIZE, "aligned");
    WANT(lm_axis_push(axis, &setpoint, SIZE_MAX, samples, 8), SIZE, "setpoints");
    setpoint.position = INFINITY;
    WANT(lm_axis_step(axis, &setpoint, samples, 4), DATA, "position is inf");
    setpoint = (LmSetpoint){.load_force = 1e9, .given = LM_SETPOINT_LOAD_FORCE};
    WANT(lm_axis_step(axis, &setpoint, samples, 4), DATA, "load_force");
    setpoint = (LmSetpoint){.given = 64};
    WANT(lm_axis_step(axis, &setpoint, samples, 4), SIZE, "setpoint.given");
    WANT(lm_axis_free(axis), OK, NULL);
    WANT(lm_axis_step(axis, &setpoint, samples, 4), HANDLE, "has been freed");

    /* logs */
    LmFit fit;
    double column[4] = {0.0, 1e-3, 2e-3, NAN};
    LmLog log = {.unit = "mm", .count = 4, .time_s = column, .motor = column, .load = column};
    WANT(lm_fit(&log, machine, "x", &fit, NULL), NULL, "current_a is null");
    log.current_a = column;
    WANT(lm_fit(&log, machine, "x", &fit, NULL), DATA, "not finite in row 3");
    column[3] = 3e-3;
    log.unit = "inch";
    WANT(lm_fit(&log, machine, "x", &fit, NULL), DATA, "inch");
    log.count = 0;
    WANT(lm_fit(&log, machine, "x", &fit, NULL), SIZE, "log.count");

    WANT(lm_machine_free(machine), OK, NULL);
    WANT(lm_program_free(program), OK, NULL);
    THAT(lm_handles() == 0);
    printf("misuse: %d faults\n", faults);
    return faults != 0;
}
