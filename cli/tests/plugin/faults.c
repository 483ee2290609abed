/* Node bodies that go wrong, each in its own way. */
#include <stddef.h>
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
