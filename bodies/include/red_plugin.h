/* Node bodies in C: the interface between redrt and a plugin.
 *
 * A node with
 *
 *     body = { plugin = "libcontrol.so", symbol = "control_step" }
 *
 * calls control_step of that shared object on the lane that runs the node. Build it with
 *
 *     cc -shared -fPIC -O2 -o libcontrol.so control.c
 *
 * A plugin written in C++ declares its functions extern "C" and lets no exception out of them.
 */
#ifndef RED_PLUGIN_H
#define RED_PLUGIN_H

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Version of this interface. Fields are only ever added, at the end of the context, and then `size` grows and this
 * number stays; it changes when an old plugin would misread the context. */
#define RED_PLUGIN_ABI 1u

/* What a step may know of the job that it works for. Times are nanoseconds of CLOCK_MONOTONIC. The context itself is
 * valid during the call; `host` and `release` stay valid until the process ends, so that a plugin may keep them and
 * release jobs from threads of its own. */
typedef struct red_plugin_context {
    uint32_t size;        /* bytes that the host fills; a field beyond them is not there */
    uint32_t abi;         /* RED_PLUGIN_ABI of the host */
    uint64_t now_ns;      /* when the lane started the step */
    uint64_t release_ns;  /* when the job was released */
    uint64_t deadline_ns; /* when the job is due */
    uint64_t job;         /* job of the task, counted from 0 */
    uint32_t task;        /* task, in the order of the workload file */
    uint32_t lane;        /* lane that runs the step, counted over all pools */
    void *host;           /* hand this to `release` */
    /* Releases a job of `task`, from any thread, without waiting: 0 when the release is on its way, -1 when it is
     * refused (no such task, or the run is over). */
    int (*release)(void *host, uint32_t task);
    /* In a pool of kind cuda, the lane's stream (CUstream, cudaStream_t); NULL elsewhere. The step submits the node's
     * work to it and returns without waiting for it: no call that synchronises, allocates or uses another stream. The
     * device's primary context is the lane's. */
    void *stream;
} red_plugin_context;

/* SYMBOL: does the node's work once; 0 is success, and any other value makes the job fail. Called under real-time
 * priority: no allocation, no file, no lock that an ordinary thread may hold. Steps of two lanes may run at once,
 * each with its own `user`; calls with the same `user` never overlap. */
typedef int red_plugin_step(void *user, const red_plugin_context *context);

/* SYMBOL_open, optional: called once for each lane before real time starts, in an order and on a thread of the
 * host's choice. What it stores in *user is what that lane's steps get; without it they get NULL. Any value but 0
 * stops the start. */
typedef int red_plugin_open(uint32_t lane, void **user);

/* SYMBOL_close, optional: called once for each lane after its last step. */
typedef void red_plugin_close(void *user);

#ifdef __cplusplus
}
#endif

#endif
