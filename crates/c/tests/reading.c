/*
 * What is said of a program without moving, as the command says it: reading PART CANON FORMATTED WRITTEN
 * EXPLAINED. Then machines, what a log tells against what it was made of, and misuse of all these.
 */

#include <lostmotion.h>
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static int faults;

#define THAT(condition)                                                                            \
    do {                                                                                           \
        if (!(condition)) {                                                                        \
            LmError why_;                                                                          \
            (void)lm_error(&why_);                                                                 \
            fprintf(stderr, "line %d: not so: %s [%s]\n", __LINE__, #condition, why_.message);     \
            faults++;                                                                              \
        }                                                                                          \
    } while (0)
#define OK(call) THAT((call) == LM_STATUS_OK)

static void refused(int line, LmStatus got, LmStatus wanted, const char *part)
{
    LmError error;
    (void)lm_error(&error);
    if (got == wanted && error.status == wanted && strstr(error.message, part))
        return;
    fprintf(stderr, "line %d: answered %d, wanted %d: %s\n", line, (int)got, (int)wanted,
            error.message);
    faults++;
}
#define REFUSED(call, status, part) refused(__LINE__, (call), LM_STATUS_##status, (part))

static char *file(const char *path)
{
    FILE *stream = fopen(path, "rb");
    if (!stream)
        exit(2);
    size_t room = 1 << 20, length = 0, more;
    char *text = malloc(room);
    while (text && (more = fread(text + length, 1, room - length - 1, stream)) > 0) {
        length += more;
        if (length + 1 == room)
            text = realloc(text, room *= 2);
    }
    fclose(stream);
    if (!text)
        exit(2);
    text[length] = 0;
    return text;
}

/* The text has to be that of the file; frees both. */
static void same(int line, LmText *text, const char *path)
{
    char *wanted = file(path);
    const char *got = "";
    OK(lm_text(text, &got, NULL));
    if (strcmp(got, wanted) != 0) {
        fprintf(stderr, "line %d: something else than %s\n", line, path);
        faults++;
    }
    OK(lm_text_free(text));
    free(wanted);
}

static void program(char **paths)
{
    LmProgram *part = NULL, *wrong = NULL;
    LmMachine *machine = NULL;
    LmOperations *operations = NULL, *other = NULL;
    LmOperation operation;
    LmFindings *findings = NULL;
    LmFinding finding;
    LmText *text = NULL;
    size_t count = 0, all = 0;
    uint32_t last = 0;
    static const char code[] = "G21 G90\nG1 Z-\nM2\n";
    OK(lm_program_from_file(paths[1], &part));
    OK(lm_program_from_text("wrong.ngc", code, sizeof code - 1, &wrong));
    OK(lm_machine_preset("vmc3", &machine));

    OK(lm_program_operations(part, NULL, NULL, &operations));
    char *canon = file(paths[2]), *at = canon;
    for (;;) {
        OK(lm_operations_next(operations, &operation));
        if (!operation.text)
            break;
        size_t length = strlen(operation.text);
        THAT(strncmp(at, operation.text, length) == 0 && at[length] == '\n');
        /* what holds before the first block has no place */
        THAT((operation.line > 0 || last == 0) && operation.line >= last);
        THAT((operation.line > 0) == (operation.column > 0) && operation.file == 0);
        last = operation.line;
        at += length + 1;
        count++;
    }
    THAT(*at == 0 && count > 3 && last > 3);
    /* the end stays the end */
    OK(lm_operations_next(operations, &operation));
    THAT(!operation.text);
    free(canon);
    OK(lm_operations_free(operations));
    REFUSED(lm_operations_next(operations, &operation), HANDLE, "has been freed");
    OK(lm_program_operations(wrong, machine, NULL, &other));
    LmStatus status;
    while ((status = lm_operations_next(other, &operation)) == LM_STATUS_OK && operation.text) {
    }
    refused(__LINE__, status, LM_STATUS_PROGRAM, "wrong.ngc:2:");
    OK(lm_program_free(wrong));
    REFUSED(lm_operations_next(other, NULL), NULL, "operation is null");
    OK(lm_operations_free(other));

    OK(lm_program_format_as(part, "{\"case\": \"lower\", \"indent\": 4}", &text));
    same(__LINE__, text, paths[3]);
    OK(lm_program_format_as(part, NULL, &text));
    OK(lm_text_free(text));
    OK(lm_program_resolved(part, NULL, NULL, 1, &text));
    same(__LINE__, text, paths[4]);
    OK(lm_program_explain_json(part, NULL, NULL, 3, &text));
    same(__LINE__, text, paths[5]);

    OK(lm_program_lint(part, machine, NULL, "{\"all\": \"warn\"}", &findings));
    OK(lm_findings_count(findings, &all));
    OK(lm_findings_free(findings));
    OK(lm_program_lint(part, machine, NULL, "{\"all\": \"allow\"}", &findings));
    OK(lm_findings_count(findings, &count));
    THAT(count == 0);
    OK(lm_findings_free(findings));
    OK(lm_program_from_text("wrong.ngc", code, sizeof code - 1, &wrong));
    OK(lm_program_lint(wrong, NULL, NULL, NULL, &findings));
    OK(lm_findings_get(findings, 0, &finding));
    THAT(finding.is_error && finding.line == 2 && strcmp(finding.code, "missing-number") == 0);
    OK(lm_findings_free(findings));

    REFUSED(lm_program_lint(part, NULL, NULL, "{\"nome\": \"warn\"}", &findings), OPTION, "nome");
    REFUSED(lm_program_lint(part, NULL, NULL, "{\"all\": \"loud\"}", &findings), OPTION, "loud");
    REFUSED(lm_program_lint(part, NULL, NULL, "[", &findings), OPTION, "levels");
    REFUSED(lm_program_format_as(part, "{\"case\": \"loud\"}", &text), OPTION, "loud");
    REFUSED(lm_program_format_as(part, "{\"kase\": \"upper\"}", &text), OPTION, "kase");
    REFUSED(lm_program_format_as(part, "{\"line_numbers\": \"0\"}", &text), OPTION, "line_numbers");
    REFUSED(lm_program_format_as(NULL, NULL, &text), NULL, "program is null");
    REFUSED(lm_program_resolved(wrong, NULL, NULL, 1, &text), PROGRAM, "wrong.ngc:2");
    REFUSED(lm_program_explain_json(part, NULL, NULL, 99999999, &text), OPTION, "no line");
    REFUSED(lm_program_operations(part, NULL, "{\"dialect\": \"pap\"}", &operations), OPTION, "pap");
    REFUSED(lm_program_operations(part, NULL, NULL, NULL), NULL, "operations is null");
    OK(lm_program_free(wrong));
    OK(lm_program_free(part));
    OK(lm_machine_free(machine));
}

static void machines(void)
{
    const char *name = NULL, *summary = NULL;
    size_t count = 0;
    int found = 0;
    while (lm_preset(count, &name, &summary) == LM_STATUS_OK) {
        LmMachine *machine = NULL, *again = NULL;
        LmText *json = NULL, *remarks = NULL, *first = NULL, *second = NULL;
        const char *text = NULL, *one = NULL, *two = NULL;
        THAT(*summary);
        found |= strcmp(name, "vmc3-worn") == 0;
        OK(lm_machine_preset(name, &machine));
        OK(lm_machine_json(machine, &json));
        OK(lm_text(json, &text, NULL));
        /* the object is the whole machine */
        OK(lm_machine_from_json(text, &again));
        OK(lm_machine_toml(machine, &first));
        OK(lm_machine_toml(again, &second));
        OK(lm_text(first, &one, NULL));
        OK(lm_text(second, &two, NULL));
        THAT(strcmp(one, two) == 0);
        OK(lm_machine_remarks(machine, &remarks));
        OK(lm_text_free(json));
        OK(lm_text_free(remarks));
        OK(lm_text_free(first));
        OK(lm_text_free(second));
        OK(lm_machine_free(machine));
        OK(lm_machine_free(again));
        count++;
    }
    REFUSED(lm_preset(count, &name, &summary), SIZE, "index");
    REFUSED(lm_preset(0, NULL, &summary), NULL, "name is null");
    THAT(found && count >= 5);
}

#define ROWS 12000

/* A figure of the document that `lm_identify` makes: the value that follows a key. */
static double figure(const char *document, const char *key)
{
    const char *at = strstr(document, key);
    at = at ? strstr(at, "\"value\":") : NULL;
    return at ? strtod(at + 8, NULL) : NAN;
}

static void logs(void)
{
    /* a body of known inertia and friction: drive = m a + v w + c sign(w) */
    static double time_s[ROWS], position[ROWS], drive[ROWS];
    const double mass = 120.0, viscous = 300.0, coulomb = 25.0, pi = acos(-1.0);
    for (int row = 0; row < ROWS; row++) {
        double t = 1e-3 * row, slow = 2.0 * pi * 0.4, fast = 2.0 * pi * 1.7;
        double at = 8.0 * sin(slow * t) + 1.5 * sin(fast * t);
        double speed = 1e-3 * (8.0 * slow * cos(slow * t) + 1.5 * fast * cos(fast * t));
        double rate = -1e-3 * (8.0 * slow * slow * sin(slow * t) + 1.5 * fast * fast * sin(fast * t));
        time_s[row] = t;
        position[row] = at;
        drive[row] = mass * rate + viscous * speed + (speed < 0 ? -coulomb : coulomb);
    }
    LmBodyLog log = {.unit = "mm", .count = ROWS, .time_s = time_s, .motor = position, .drive = drive};
    LmText *document = NULL;
    const char *text = "";
    OK(lm_identify(&log, &document));
    OK(lm_text(document, &text, NULL));
    THAT(fabs(figure(text, "\"inertia\"") / mass - 1.0) < 0.02);
    THAT(fabs(figure(text, "\"viscous\"") / viscous - 1.0) < 0.1);
    THAT(fabs(figure(text, "\"coulomb\"") / coulomb - 1.0) < 0.1);
    THAT(strstr(text, "\"lost_motion\":null") && strstr(text, "lost motion: "));
    OK(lm_text_free(document));
    log.drive = NULL;
    OK(lm_identify(&log, &document));
    OK(lm_text(document, &text, NULL));
    THAT(strstr(text, "\"body\":null"));
    OK(lm_text_free(document));

    log.unit = "inch";
    REFUSED(lm_identify(&log, &document), DATA, "inch");
    log.unit = "mm";
    log.motor = NULL;
    REFUSED(lm_identify(&log, &document), NULL, "log.motor is null");
    log.motor = position;
    position[7] = NAN;
    REFUSED(lm_identify(&log, &document), DATA, "log.motor is not finite in row 7");
    position[7] = 0.0;
    time_s[1] = -1.0;
    REFUSED(lm_identify(&log, &document), DATA, "");
    log.count = 2;
    REFUSED(lm_identify(&log, &document), DATA, "");
    log.count = 0;
    REFUSED(lm_identify(&log, &document), SIZE, "log.count");
    REFUSED(lm_identify(NULL, &document), NULL, "log is null");
    REFUSED(lm_identify(&log, NULL), NULL, "document is null");
}

int main(int argc, char **argv)
{
    if (argc != 6)
        return 2;
    program(argv);
    machines();
    logs();
    THAT(lm_handles() == 0);
    printf("reading: %d faults\n", faults);
    return faults != 0;
}
