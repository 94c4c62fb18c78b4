/* The document of a run: golden PART MACHINE METHOD.. */

#include <lostmotion.h>
#include <stdio.h>

#define DO(call)                                                                                   \
    if ((call) != LM_STATUS_OK) {                                                                  \
        LmError error;                                                                             \
        (void)lm_error(&error);                                                                    \
        fprintf(stderr, "%s\n", error.message);                                                    \
        return 1;                                                                                  \
    }

static bool count(void *user, size_t method, const LmBlock *blocks, size_t many)
{
    (void)method, (void)blocks;
    *(size_t *)user += many;
    return true;
}

int main(int argc, char **argv)
{
    if (argc < 4)
        return 2;
    LmProgram *program = NULL;
    LmMachine *machine = NULL;
    LmSimulation *simulation = NULL;
    LmRun *run = NULL;
    LmText *document = NULL;
    DO(lm_program_from_file(argv[1], &program));
    DO(lm_machine_preset(argv[2], &machine));
    DO(lm_simulation_new(program, machine, &simulation));
    for (int index = 3; index < argc; index++)
        DO(lm_simulation_method(simulation, argv[index]));
    DO(lm_simulation_set(simulation, "threads", 0));
    size_t blocks = 0;
    DO(lm_simulation_on_blocks(simulation, count, &blocks));
    DO(lm_simulation_run(simulation, &run));
    DO(lm_run_json(run, &document));
    const char *text;
    DO(lm_text(document, &text, NULL));
    fputs(text, stdout);
    DO(lm_text_free(document));
    DO(lm_run_free(run));
    DO(lm_simulation_free(simulation));
    DO(lm_machine_free(machine));
    DO(lm_program_free(program));
    return lm_handles() != 0 || blocks == 0;
}
