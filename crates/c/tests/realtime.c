/*
 * Steps every method on a thread that may neither allocate nor enter the system: allocations are counted,
 * and the kernel ends the thread at its first system call (seccomp, strict). Faulty calls are made there,
 * too. Linux with glibc.
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

enum { CYCLES = 30000 };

typedef struct {
    LmAxis *axis;
    size_t ticks;
    volatile int wrong, done;
} Job;

static void *loop(void *argument)
{
    Job *job = argument;
    LmAxisSample samples[16], one;
    lm_error_clear();
    counts = 1;
    if (prctl(PR_SET_SECCOMP, SECCOMP_MODE_STRICT) != 0)
        job->wrong = -1;
    for (int n = 0; n < CYCLES; n++) {
        /* strokes of two lengths with rests, as reading a gap needs them */
        const double t = n * 1e-3, swing = n % 8000 < 4000 ? 5.0 : 0.4;
        const double phase = 2.5 * t;
        LmSetpoint setpoint = {
            .position = swing * sin(phase),
            .velocity = 2.5 * swing * cos(phase),
            .acceleration = -6.25 * swing * sin(phase),
            .given = LM_SETPOINT_VELOCITY | LM_SETPOINT_ACCELERATION,
        };
        if (n % 2) {
            job->wrong += lm_axis_step(job->axis, &setpoint, samples, job->ticks) != LM_STATUS_OK;
        } else {
            job->wrong += lm_axis_setpoint(job->axis, &setpoint) != LM_STATUS_OK;
            for (size_t tick = 0; tick < job->ticks; tick++)
                job->wrong += lm_axis_tick(job->axis, &one) != LM_STATUS_OK;
        }
        if (n % 1000 == 0) {
            job->wrong += lm_axis_step(NULL, &setpoint, samples, job->ticks) != LM_STATUS_NULL;
            job->wrong += lm_axis_step(job->axis, NULL, samples, job->ticks) != LM_STATUS_NULL;
            job->wrong += lm_axis_step(job->axis, &setpoint, samples, 1) != LM_STATUS_SIZE;
            job->wrong += lm_axis_tick(job->axis, &one) != LM_STATUS_SIZE;
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

int main(void)
{
    LmMachine *machine = NULL;
    if (lm_machine_preset("vmc3-worn", &machine) != LM_STATUS_OK)
        return 1;
    /* a thread that the kernel ends may leave a lock of malloc: no waiting for it */
    alarm(300);
    const char *name, *summary;
    int stepped = 0, failed = 0;
    for (size_t index = 0; lm_method(index, &name, &summary) == LM_STATUS_OK; index++) {
        /* these remember the motion in lists that grow: the book says so */
        if (!strcmp(name, "iterative-learning") || !strcmp(name, "adaptive"))
            continue;
        Job job = {0};
        LmAxisInfo info;
        /* some need a fit before, some a scale that the machine has not */
        if (lm_axis_new(machine, "x", name, 0.0, false, &job.axis) != LM_STATUS_OK)
            continue;
        if (lm_axis_info(job.axis, &info) != LM_STATUS_OK)
            return 1;
        job.ticks = info.servo_ticks;
        touched = 0;
        pthread_t thread;
        if (pthread_create(&thread, NULL, loop, &job) != 0)
            return 1;
        pthread_join(thread, NULL);
        if (!job.done || job.wrong || touched) {
            fprintf(stderr, "%s: %s, %d answers wrong, %lu allocations\n", name,
                    job.done ? "done" : "ended by a system call", job.wrong, touched);
            failed++;
        }
        stepped++;
        if (!job.done)
            _exit(1);
        lm_axis_free(job.axis);
    }
    lm_machine_free(machine);
    printf("%d methods stepped, %d failed, %zu handles left\n", stepped, failed, lm_handles());
    return failed || stepped < 10 || lm_handles();
}
