/* A body whose first call is slow, as those of many libraries are: 11 ms once, 3 ms ever after. */
#include "red_plugin.h"
#include <stdint.h>
#include <time.h>

static uint64_t now_ns(void) {
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (uint64_t)t.tv_sec * 1000000000U + (uint64_t)t.tv_nsec;
}

static int calls;

int warm_step(void *state, const red_plugin_context *context) {
    (void)state, (void)context;
    for (const uint64_t end = now_ns() + (calls++ == 0 ? 11000000U : 3000000U); now_ns() < end;) {
    }
    return 0;
}
