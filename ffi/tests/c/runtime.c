/* What the tests of the runtime share. */
#define _GNU_SOURCE
#include "runtime.h"

#include <stdio.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

red_runtime_config config_of(uint32_t mode) {
    red_runtime_config config = RED_RUNTIME_CONFIG_INIT;
    config.mode = mode;
    return config;
}

red_runtime open_runtime(uint32_t lanes) {
    red_config policy = preset(RED_PRESET_REDRT);
    policy.lanes = lanes;
    const red_runtime_config config = config_of(RED_MODE_BEST_EFFORT);
    red_runtime runtime = {0};
    CALL(RED_OK, red_runtime_open, &policy, &config, &runtime);
    return runtime;
}

red_dag open_dag(struct dag_memory *memory) {
    red_dag dag = {0};
    CALL(RED_OK, red_dag_open_16x256x64, memory->bytes, sizeof memory->bytes, &dag);
    return dag;
}

int nothing(void *user, const red_context *context) {
    (void)user;
    (void)context;
    return RED_BODY_DONE;
}

red_callback callback_of(uint32_t node, red_body body, void *user) {
    const red_callback callback = {node, 0, body, user};
    return callback;
}

uint32_t add_task_of(red_runtime *runtime, red_body body, void *user) {
    static struct dag_memory memory;
    red_dag dag = open_dag(&memory);
    add(&dag, node_of(MS));
    const red_callback callback = callback_of(0, body, user);
    const red_timing timing = timing_of(60 * SECOND);
    uint32_t task = RED_NONE;
    CALL(RED_OK, red_runtime_add_task, runtime, &dag, &callback, 1, &timing, &task);
    CALL(RED_OK, red_dag_close, &dag);
    return task;
}

void await(const int *flag) {
    const struct timespec moment = {0, 1000000};
    while (__atomic_load_n(flag, __ATOMIC_ACQUIRE) == 0) nanosleep(&moment, NULL);
}

void in_child(void (*check)(void)) {
    fflush(NULL);
    const pid_t child = fork();
    if (child == 0) {
        check();
        const int failed = report();
        fflush(NULL);
        /* Into another program: what lanes of the parent had is lost here, and valgrind shall not say so. */
        execl("/bin/sh", "sh", "-c", failed == 0 ? "exit 0" : "exit 1", (char *)NULL);
        _exit(1);
    }
    int how = -1;
    EXPECT(child > 0 && waitpid(child, &how, 0) == child && WIFEXITED(how) && WEXITSTATUS(how) == 0);
}
