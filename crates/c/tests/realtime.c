/*
 * Steps every method of the library on a thread that may neither allocate nor enter the system: allocations
 * are counted, and the kernel ends the thread at its first system call (seccomp, strict). The motion has
 * strokes that come again, short ones, reversals without a rest and pauses, so that what learns does. Each
 * method is stepped on a plain axis, on one that drifts and whose memory is full, and as a copy that was
 * made on the way. Faulty calls are made there, too. Linux with glibc.
 */

#define _GNU_SOURCE
#include <lostmotion.h>
#include <linux/seccomp.h>
#include <math.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#include <unistd.h>

extern void *__libc_malloc(size_t), *__libc_calloc(size_t, size_t), *__libc_realloc(void *, size_t);
extern void *__libc_memalign(size_t, size_t);
extern void __libc_free(void *);

static __thread int counts;
static volatile unsigned long touched;

void *malloc(size_t size)
{
    if (counts)
        touched++;
    return __libc_malloc(size);
}

void *calloc(size_t count, size_t size)
{
    if (counts)
        touched++;
    return __libc_calloc(count, size);
}

void *realloc(void *old, size_t size)
{
    if (counts)
        touched++;
    return __libc_realloc(old, size);
}

void free(void *old)
{
    if (counts && old)
        touched++;
    __libc_free(old);
}

int posix_memalign(void **out, size_t alignment, size_t size)
{
    if (counts)
        touched++;
    *out = __libc_memalign(alignment, size);
    return *out ? 0 : 12;
}

void *aligned_alloc(size_t alignment, size_t size)
{
    if (counts)
        touched++;
    return __libc_memalign(alignment, size);
}

enum { CYCLES = 40000, BEFORE_COPY = 9000, STROKES = 10 };

/* where each stroke goes, mm, and what it takes, cycles of 1 ms; a stroke to where the axis stands is a pause */
static const double TO[STROKES] = {20, 20, 0, 1, 0.2, 0.2, 12, 12, 2, 0};
static const int TAKES[STROKES] = {1000, 200, 1000, 300, 250, 500, 700, 60, 600, 400};

/* The setpoint of a cycle: speeds are raised cosines, so that positions, speeds and accelerations are smooth. */
static LmSetpoint setpoint_at(int n)
{
    int whole = 0, stroke = 0;
    for (int k = 0; k < STROKES; k++)
        whole += TAKES[k];
    n %= whole;
    while (n >= TAKES[stroke])
        n -= TAKES[stroke++];
    const double pi = 3.14159265358979323846;
    const double from = TO[(stroke + STROKES - 1) % STROKES], way = TO[stroke] - from;
    const double takes = TAKES[stroke] * 1e-3, part = n * 1e-3 / takes, turn = 2 * pi * part;
    LmSetpoint setpoint = {
        .position = from + way * (part - sin(turn) / (2 * pi)),
        .velocity = way / takes * (1 - cos(turn)),
        .acceleration = way / (takes * takes) * 2 * pi * sin(turn),
        .given = LM_SETPOINT_VELOCITY | LM_SETPOINT_ACCELERATION,
    };
    return setpoint;
}

typedef struct {
    LmAxis *axis;
    size_t ticks;
    int from;
    /* squares of the load's error over the first and the last quarter */
    volatile double first, last, gap;
    volatile int wrong, done;
} Job;

static void *loop(void *argument)
{
    Job *job = argument;
    LmAxisSample samples[16];
    lm_error_clear();
    counts = 1;
    if (prctl(PR_SET_SECCOMP, SECCOMP_MODE_STRICT) != 0)
        job->wrong = -1;
    for (int n = 0; n < CYCLES; n++) {
        LmSetpoint setpoint = setpoint_at(job->from + n);
        if (n % 2) {
            job->wrong += lm_axis_step(job->axis, &setpoint, samples, job->ticks) != LM_STATUS_OK;
        } else {
            job->wrong += lm_axis_setpoint(job->axis, &setpoint) != LM_STATUS_OK;
            for (size_t tick = 0; tick < job->ticks; tick++)
                job->wrong += lm_axis_tick(job->axis, &samples[tick]) != LM_STATUS_OK;
        }
        const double error = samples[0].reference - samples[0].load;
        if (n < CYCLES / 4)
            job->first += error * error;
        else if (n >= CYCLES - CYCLES / 4)
            job->last += error * error;
        job->gap = fabs(samples[0].gap_estimate);
        if (n % 1000 == 0) {
            job->wrong += lm_axis_step(NULL, &setpoint, samples, job->ticks) != LM_STATUS_NULL;
            job->wrong += lm_axis_step(job->axis, NULL, samples, job->ticks) != LM_STATUS_NULL;
            job->wrong += lm_axis_step(job->axis, &setpoint, samples, 1) != LM_STATUS_SIZE;
            job->wrong += lm_axis_tick(job->axis, &samples[0]) != LM_STATUS_SIZE;
            setpoint.position = NAN;
            job->wrong +=
                lm_axis_step(job->axis, &setpoint, samples, job->ticks) != LM_STATUS_DATA;
        }
    }
    counts = 0;
    job->done = 1;
    syscall(SYS_exit, 0);
    return NULL;
}

/* Steps an axis from a cycle on and frees it; answers what is wrong. */
static int run(const char *name, const char *kind, LmAxis *axis, int from)
{
    LmAxisInfo info;
    if (lm_axis_info(axis, &info) != LM_STATUS_OK)
        return 1;
    Job job = {.axis = axis, .ticks = info.servo_ticks, .from = from};
    touched = 0;
    pthread_t thread;
    if (pthread_create(&thread, NULL, loop, &job) != 0)
        return 1;
    pthread_join(thread, NULL);
    int failed = !job.done || job.wrong || touched;
    if (failed)
        fprintf(stderr, "%s, %s: %s, %d answers wrong, %lu allocations\n", name, kind,
                job.done ? "done" : "ended by a system call", job.wrong, touched);
    if (!job.done)
        _exit(1);
    /* a motion in which nothing is learned would prove nothing */
    const int told = !strcmp(name, "adaptive") && !strcmp(kind, "plain");
    if (told && !(fabs(job.gap - 0.5 * info.gap) < 0.1 * info.gap)) {
        fprintf(stderr, "%s, %s: learned a half gap of %g, not %g\n", name, kind, job.gap, 0.5 * info.gap);
        failed = 1;
    }
    if (!strcmp(name, "iterative-learning") && !(job.last < 0.5 * job.first)) {
        fprintf(stderr, "%s, %s: learned nothing, %g after %g\n", name, kind, job.last, job.first);
        failed = 1;
    }
    lm_axis_free(axis);
    return failed;
}

int main(void)
{
    /* what one of them may be told: a gap by a fit, a memory of 6 s; and an axis that changes on the way */
    const char *keys[] = {
        "axis.x.compensation.fitted_lookup.gap.um",
        "axis.x.compensation.estimate_shaft",
        "axis.x.compensation.iterative_learning.memory_s",
        "axis.x.drift.gap",
        "axis.x.drift.load_inertia",
        "axis.x.drift.stiffness",
    };
    const char *values[] = {
        "40.0", "true", "6.0",
        "{ factor = 1.3, over_s = 20.0 }",
        "{ factor = 1.2, over_s = 20.0 }",
        "{ factor = 0.9, over_s = 20.0 }",
    };
    LmMachine *preset = NULL, *machine = NULL, *drifting = NULL;
    if (lm_machine_preset("vmc3-worn", &preset) != LM_STATUS_OK ||
        lm_machine_edit(preset, keys, values, 1, &machine) != LM_STATUS_OK ||
        lm_machine_edit(preset, keys, values, 6, &drifting) != LM_STATUS_OK) {
        LmError error;
        lm_error(&error);
        fprintf(stderr, "%s\n", error.message);
        return 1;
    }
    /* a thread that the kernel ends may leave a lock of malloc: no waiting for it */
    alarm(600);
    const char *name, *summary;
    int stepped = 0, failed = 0;
    for (size_t index = 0; lm_method(index, &name, &summary) == LM_STATUS_OK; index++) {
        LmAxis *plain = NULL, *full = NULL, *first = NULL, *copy = NULL;
        LmAxisSample samples[16];
        LmAxisInfo info;
        if (lm_axis_new(machine, "x", name, 0.0, false, &plain) != LM_STATUS_OK ||
            lm_axis_new(drifting, "x", name, 0.0, false, &full) != LM_STATUS_OK ||
            lm_axis_new(machine, "x", name, 0.0, false, &first) != LM_STATUS_OK ||
            lm_axis_info(first, &info) != LM_STATUS_OK) {
            LmError error;
            lm_error(&error);
            fprintf(stderr, "%s: %s\n", name, error.message);
            return 1;
        }
        for (int n = 0; n < BEFORE_COPY; n++) {
            const LmSetpoint setpoint = setpoint_at(n);
            failed += lm_axis_step(first, &setpoint, samples, info.servo_ticks) != LM_STATUS_OK;
        }
        failed += lm_axis_copy(first, &copy) != LM_STATUS_OK;
        lm_axis_free(first);
        failed += run(name, "plain", plain, 0);
        failed += run(name, "drifting", full, 0);
        failed += run(name, "copy", copy, BEFORE_COPY);
        stepped++;
    }
    lm_machine_free(drifting);
    lm_machine_free(machine);
    lm_machine_free(preset);
    printf("%d methods stepped, %d failed, %zu handles left\n", stepped, failed, lm_handles());
    return failed || stepped < 20 || lm_handles();
}
