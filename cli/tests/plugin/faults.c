/* Node bodies that go wrong, each in its own way. */
#define _GNU_SOURCE
#include <pthread.h>
#include <stddef.h>
#include <sys/mman.h>
#include <sys/syscall.h>
#include <time.h>
#include <unistd.h>

#include "red_plugin.h"

/* Does nothing, and does it well. */
int good(void *user, const red_plugin_context *context) {
    (void)user;
    (void)context;
    return 0;
}

/* Fails for job 1. */
int fails(void *user, const red_plugin_context *context) {
    (void)user;
    return context->job == 1 ? 7 : 0;
}

/* Does not want to be run. */
int refuses_open(uint32_t lane, void **user) {
    (void)lane;
    (void)user;
    return 9;
}

int refuses(void *user, const red_plugin_context *context) {
    return good(user, context);
}

/* Never returns for job 1. */
int hangs(void *user, const red_plugin_context *context) {
    (void)user;
    while (context->job == 1)
        pause();
    return 0;
}

/* Never returns. */
int always_hangs(void *user, const red_plugin_context *context) {
    (void)user;
    (void)context;
    for (;;)
        pause();
}

/* Takes the process down for job 1. */
int crashes(void *user, const red_plugin_context *context) {
    (void)user;
    volatile int *nowhere = NULL;
    return context->job == 1 ? *nowhere : 0;
}

/* Releases a job of task 1 from inside a step, as often as it is called. */
int releases(void *user, const red_plugin_context *context) {
    (void)user;
    return context->release(context->host, 1);
}

static uint64_t clock_ns(void) {
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (uint64_t)now.tv_sec * 1000000000u + (uint64_t)now.tv_nsec;
}

/* Fails unless the times that it is told are those of the clock, in their order. */
int reads_the_clock(void *user, const red_plugin_context *context) {
    (void)user;
    uint64_t now = clock_ns();
    int ordered = context->release_ns <= context->now_ns && context->now_ns <= now;
    /* The deadline is 20 s after the release, and has not passed. */
    int due = context->deadline_ns - context->release_ns == 20000000000u && now < context->deadline_ns;
    return ordered && due ? 0 : 1;
}

/* Keeps its CPU for ever in job 1. */
int spins(void *user, const red_plugin_context *context) {
    (void)user;
    volatile uint64_t turns = 0;
    while (context->job == 1)
        turns++;
    return 0;
}

/* Ends its thread in job 1, past everything that would notice. */
int dies(void *user, const red_plugin_context *context) {
    (void)user;
    if (context->job == 1)
        syscall(SYS_exit, 0);
    return 0;
}

/* Ends its thread in job 1 as POSIX has it. */
int leaves(void *user, const red_plugin_context *context) {
    (void)user;
    if (context->job == 1)
        pthread_exit(NULL);
    return 0;
}

/* Takes fresh memory in each step. */
int faults_pages(void *user, const red_plugin_context *context) {
    (void)user;
    (void)context;
    size_t size = 1 << 16;
    volatile char *fresh = mmap(NULL, size, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (fresh == MAP_FAILED)
        return 1;
    for (size_t at = 0; at < size; at += 4096)
        fresh[at] = 1;
    return 0;
}

/* Keeps its CPU for one to two seconds in each step. */
int works(void *user, const red_plugin_context *context) {
    (void)user;
    (void)context;
    struct timespec start, now;
    clock_gettime(CLOCK_MONOTONIC, &start);
    do
        clock_gettime(CLOCK_MONOTONIC, &now);
    while (now.tv_sec - start.tv_sec < 2);
    return 0;
}
