/* A stand-in for libcuda.so.1, for tests: the same names and types, streams that are threads, kernels that only take time,
 * faults on demand, and a log of all calls. It is never shipped.
 *
 * RED_STAND_IN names a script, RED_STAND_IN_LOG a file to which the log is appended. Lines of the script:
 *
 *   version 12020            what cuDriverGetVersion answers
 *   devices 0                how many there are
 *   memory 1000000           bytes of the device
 *   load 87                  percent of the device's use, for its management library; without it that knows no device
 *   takes NAME 500           kernel NAME takes so many microseconds; `*` is every other one
 *   slows NAME 3 900         from its third run on it takes so many
 *   fault NAME 3 700         the third run of kernel NAME ends the context with this error
 *   hang NAME 1              the first run of kernel NAME never ends
 *   refuse cuMemAlloc_v2 2 2 the second call of that name answers this error, once
 *   delay cuLaunchKernel 50  each call of that name takes so many microseconds; nvmlInit_v2, too
 *   computes 1               kernels that kernels.c knows compute what they should
 *   wrong 1                  and then add so much to it
 *   ignores waits 1          streams do not wait for events
 *
 * Lines of the log: `call NAME [STREAM [WHAT]] = RESULT` when a call returns, `begin STREAM KERNEL` and `end STREAM KERNEL`
 * when a kernel runs. Streams and events are numbers from 1, in the order of their making. */
#ifndef STAND_IN_H
#define STAND_IN_H

#include <pthread.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "driver_api.h"

#define CUDA_SUCCESS 0u
#define CUDA_ERROR_INVALID_VALUE 1u
#define CUDA_ERROR_OUT_OF_MEMORY 2u
#define CUDA_ERROR_NOT_INITIALIZED 3u
#define CUDA_ERROR_INVALID_DEVICE 101u
#define CUDA_ERROR_INVALID_IMAGE 200u
#define CUDA_ERROR_INVALID_CONTEXT 201u
#define CUDA_ERROR_INVALID_PTX 218u
#define CUDA_ERROR_NOT_FOUND 500u
#define CUDA_ERROR_NOT_READY 600u
#define CUDA_ERROR_NOT_PERMITTED 800u

#define NAME_LENGTH 64

#define MOST_ARGUMENTS 4

/* What a kernel computes, and the bytes of its arguments. */
struct computation {
    const char *name;
    void (*run)(const uint64_t *arguments);
    unsigned count;
    unsigned char bytes[MOST_ARGUMENTS];
};

struct CUfunc_st {
    char name[NAME_LENGTH];
    /* NULL: it only takes time. */
    const struct computation *computation;
    struct CUfunc_st *next;
};

struct CUmod_st {
    char *text;
    struct CUfunc_st *functions;
};

struct CUevent_st {
    int number;
    /* How often it was recorded, and how many of those were reached; when the last one was. */
    uint64_t recorded, reached;
    uint64_t at_ns;
};

enum kind { KERNEL, RECORD, WAIT, CALL, COPY, SET };

/* What a stream does. */
struct operation {
    enum kind kind;
    struct CUfunc_st *kernel;
    uint64_t arguments[MOST_ARGUMENTS];
    struct CUevent_st *event;
    uint64_t turn;
    void (*function)(void *);
    void *argument;
    void *to;
    const void *from;
    size_t bytes;
    struct operation *next;
};

struct CUgraph_st {
    struct operation *first, **last;
};

struct CUgraphExec_st {
    struct CUgraph_st graph;
};

struct CUstream_st {
    int number;
    pthread_t thread;
    bool ends;
    struct CUgraph_st queue;
    struct CUgraph_st *capture;
};

/* One lock for everything, and one condition for every change. */
extern pthread_mutex_t lock;
extern pthread_cond_t changed;
/* The error that every call answers from now on; 0 while all is well. */
extern unsigned spent;

/* Memory of what has a handle, which is there until the process ends: others may still have that in their queues. */
void *kept(size_t bytes);

/* --- script.c --- */
uint64_t script_number(const char *key, uint64_t otherwise);
/* Of `key name nth value`: the value where this is that time; `counts` the times by name. */
bool script_at(const char *key, const char *name, uint64_t *value);
/* The same from that time on. */
uint64_t script_from(const char *key, const char *name, uint64_t otherwise);
uint64_t script_of(const char *key, const char *name, uint64_t otherwise);
void say(const char *format, ...) __attribute__((format(printf, 1, 2)));
uint64_t clock_ns(void);
void sleep_us(uint64_t microseconds);

/* --- kernels.c --- */
/* NULL: none that is known, or the script does not ask for it. */
const struct computation *computation_of(const char *name);

/* --- streams.c --- */
struct CUstream_st *stream_new(void);
void stream_end(struct CUstream_st *stream);
void stream_add(struct CUstream_st *stream, struct operation operation);
/* To be called with the lock held. */
void graph_add(struct CUgraph_st *graph, const struct operation *operation);
void graph_clear(struct CUgraph_st *graph);
void streams_drain(void);
/* Whether the calling thread runs a host function, which must not call CUDA. */
bool is_in_host_function(void);

#endif
