/* What some kernels compute, for tests that look at it: those of the obstacle scene and of the checks for a device. */
#include <math.h>
#include <stdatomic.h>
#include <string.h>

#include "stand_in.h"

/* As examples/kernels/road.ptx: the arguments are from, to, count, times. */
static void rounds(const uint64_t *arguments)
{
    const float *from = (const float *)(uintptr_t)arguments[0];
    float *to = (float *)(uintptr_t)arguments[1];
    float wrong = (float)script_number("wrong", 0);
    for (uint64_t place = 0; place < arguments[2]; place++) {
        float value = from[place];
        for (uint64_t done = 0; done < arguments[3]; done++) {
            value = fmaf(value, 0x1.fffep-1f, 0x1p-11f);
        }
        to[place] = value + wrong;
    }
}

/* As tests/gpu/kernels/checks.ptx: place, nanoseconds. */
static void stamp(const uint64_t *arguments)
{
    uint64_t *place = (uint64_t *)(uintptr_t)arguments[0];
    place[0] = clock_ns();
    sleep_us(arguments[1] / 1000);
    place[1] = clock_ns();
}

/* As there: place. */
static void gate(const uint64_t *arguments)
{
    _Atomic uint64_t *place = (_Atomic uint64_t *)(uintptr_t)arguments[0];
    uint64_t begin = clock_ns();
    atomic_store(&place[0], 1);
    while (atomic_load(&place[1]) == 0 && clock_ns() - begin < 2000000000u) {
    }
}

/* As bodies/kernels/spin.ptx: nanoseconds. */
static void spin(const uint64_t *arguments)
{
    sleep_us(arguments[0] / 1000);
}

static const struct computation KERNELS[] = {
    {"encode", rounds, 4, {8, 8, 4, 4}},
    {"stamp", stamp, 2, {8, 8}},
    {"gate", gate, 1, {8}},
    {"red_spin", spin, 1, {8}},
};

const struct computation *computation_of(const char *name)
{
    for (size_t i = 0; script_number("computes", 0) != 0 && i < sizeof KERNELS / sizeof *KERNELS; i++) {
        if (strcmp(KERNELS[i].name, name) == 0) {
            return &KERNELS[i];
        }
    }
    return NULL;
}
