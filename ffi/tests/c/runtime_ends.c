/* Where a runtime does not get to run, or is left over: rights that are missing, CPUs, threads, a child of fork. */
#define _GNU_SOURCE
#include "runtime.h"

#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <unistd.h>

static red_runtime runtime;
static red_scheduler logged;
static red_dag dag;
static struct dag_memory memory, edit_memory;
static uint32_t task;

static red_runtime open_real_time(uint32_t lanes) {
    red_config policy = preset(RED_PRESET_REDRT);
    policy.lanes = lanes;
    const red_runtime_config config = config_of(RED_MODE_REAL_TIME);
    red_runtime opened = {0};
    CALL(RED_OK, red_runtime_open, &policy, &config, &opened);
    return opened;
}

/* Fails to start so, and says what to do. */
static void refused(red_status wanted) {
    static char text[1024];
    size_t count = 7;
    CALL(RED_OK, red_runtime_message, &runtime, text, sizeof text, &count);
    EXPECT(count == 1 && text[0] == 0);
    CALL(wanted, red_runtime_start, &runtime);
    CALL(RED_OK, red_runtime_message, &runtime, text, sizeof text, &count);
    EXPECT(strstr(text, "fix: ") != NULL && count == strlen(text) + 1);
    fprintf(stderr, "as it should be: %s\n", text);
    CALL(RED_STATUS_TOO_SHORT, red_runtime_message, &runtime, text, 3, &count);
    uint32_t state = 7;
    CALL(RED_OK, red_runtime_state_of, &runtime, &state);
    EXPECT(state == RED_RUNTIME_STATE_FAILED);
    CALL(RED_OK, red_runtime_close, &runtime);
}

static void two_lanes_on_a_cpu(void) {
    const uint32_t cpus[] = {0, 0};
    runtime = open_real_time(2);
    CALL(RED_OK, red_runtime_pin, &runtime, cpus, 2);
    refused(RED_STATUS_CPUS);
}

/* As somebody without rights, and without a way to get them. */
static void become_nobody(void) {
    const struct rlimit none = {0, 0};
    EXPECT(setrlimit(RLIMIT_RTPRIO, &none) == 0 && setrlimit(RLIMIT_MEMLOCK, &none) == 0);
    EXPECT(geteuid() != 0 || setuid(65534) == 0);
}

static void without_rights(void) {
    become_nobody();
    runtime = open_real_time(1);
#ifdef __SANITIZE_ADDRESS__
    /* Real time asks the allocator for settings first, and this one has none. */
    printf("call red_runtime_start %d\nnot tried with this sanitizer: a start without rights\n", (int)RED_STATUS_NOT_PERMITTED);
    refused(RED_STATUS_SYSTEM);
#else
    refused(RED_STATUS_NOT_PERMITTED);
#endif
}

static void without_threads(void) {
    become_nobody();
    const struct rlimit none = {0, 0};
    EXPECT(setrlimit(RLIMIT_NPROC, &none) == 0);
    runtime = open_runtime(1);
    refused(RED_STATUS_SYSTEM);
}

/* No call does anything in a child, and none waits. */
static void left_over(void) {
    red_dag other = {0};
    red_certificate proof = RED_CERTIFICATE_INIT;
    red_figures figures = RED_FIGURES_INIT;
    red_report report = RED_REPORT_INIT;
    red_outcome outcome;
    red_event event;
    const red_timing timing = timing_of(SECOND);
    const red_callback callback = callback_of(0, nothing, NULL);
    uint32_t number = 7;
    size_t count = 7;
    char text[8];
    CALL(RED_STATUS_FORKED, red_runtime_state_of, &runtime, &number);
    CALL(RED_STATUS_FORKED, red_runtime_message, &runtime, text, sizeof text, &count);
    CALL(RED_STATUS_FORKED, red_runtime_report, &runtime, &report);
    CALL(RED_STATUS_FORKED, red_runtime_start, &runtime);
    CALL(RED_STATUS_FORKED, red_runtime_release, &runtime, task, RED_NONE_64);
    CALL(RED_STATUS_FORKED, red_runtime_stop, &runtime);
    CALL(RED_STATUS_FORKED, red_runtime_wait, &runtime, RED_NONE_64);
    CALL(RED_STATUS_FORKED, red_runtime_figures, &runtime, &figures);
    CALL(RED_STATUS_FORKED, red_runtime_take_outcomes, &runtime, &outcome, 1, &count);
    red_warning warning;
    red_task_report of_task = RED_TASK_REPORT_INIT;
    CALL(RED_STATUS_FORKED, red_runtime_take_warnings, &runtime, &warning, 1, &count);
    CALL(RED_STATUS_FORKED, red_runtime_task_report, &runtime, task, &of_task);
    CALL(RED_STATUS_FORKED, red_runtime_take_events, &runtime, &event, 1, &count);
    CALL(RED_STATUS_FORKED, red_runtime_add_pool, &runtime, 1, RED_NONE_64, &number);
    CALL(RED_STATUS_FORKED, red_runtime_add_cuda_pool, &runtime, 0, 1, RED_NONE_64, &number);
    CALL(RED_STATUS_FORKED, red_runtime_add_sensor, &runtime, MS, &number);
    CALL(RED_STATUS_FORKED, red_runtime_pin, &runtime, &number, 1);
    CALL(RED_STATUS_FORKED, red_runtime_every, &runtime, task, 0, MS);
    CALL(RED_STATUS_FORKED, red_runtime_record, &runtime, "log");
    CALL(RED_STATUS_FORKED, red_runtime_add_task, &runtime, &dag, &callback, 1, &timing, &number);
    CALL(RED_STATUS_FORKED, red_runtime_remove_task, &runtime, task);
    CALL(RED_STATUS_FORKED, red_runtime_certificate, &runtime, task, &proof);
    CALL(RED_STATUS_FORKED, red_runtime_edit, &runtime, task, &edit_memory, sizeof edit_memory, &other);
    CALL(RED_STATUS_FORKED, red_runtime_commit, &runtime, &dag, NULL, 0, &proof);
    CALL(RED_STATUS_FORKED, red_runtime_close, &runtime);
    /* Nobody writes the log of a scheduler here, which goes on without it. */
    uint64_t dropped = 7;
    CALL(RED_STATUS_FORKED, red_record_end, &logged, 1, &dropped);
    CALL(RED_OK, red_scheduler_close, &logged);

#ifndef __SANITIZE_ADDRESS__
    /* One of its own works. Not with an allocator that a thread of the parent may have locked when it forked. */
    red_runtime own = open_runtime(1);
    const uint32_t mine = add_task_of(&own, nothing, NULL);
    CALL(RED_OK, red_runtime_every, &own, mine, 0, 0);
    CALL(RED_OK, red_runtime_start, &own);
    while (report.on_time == 0) CALL(RED_OK, red_runtime_report, &own, &report);
    CALL(RED_OK, red_runtime_close, &own);
#endif
}

#ifndef __SANITIZE_ADDRESS__
/* A body's thread is a lane of the parent's, and none of what the child opens. */
static void of_a_body(void) {
    red_runtime own = open_runtime(1);
    const uint32_t mine = add_task_of(&own, nothing, NULL);
    CALL(RED_OK, red_runtime_start, &own);
    red_figures figures = RED_FIGURES_INIT;
    CALL(RED_OK, red_runtime_figures, &own, &figures);
    CALL(RED_OK, red_runtime_remove_task, &own, mine);
    CALL(RED_OK, red_runtime_stop, &own);
    CALL(RED_OK, red_runtime_wait, &own, RED_NONE_64);
    CALL(RED_OK, red_runtime_close, &own);
}

static atomic_int has_forked;

static int forks(void *user, const red_context *context) {
    (void)user;
    (void)context;
    in_child(of_a_body);
    has_forked = 1;
    return RED_BODY_DONE;
}

static void forked_by_a_body(void) {
    red_runtime parent = open_runtime(1);
    const uint32_t task_that_forks = add_task_of(&parent, forks, NULL);
    CALL(RED_OK, red_runtime_every, &parent, task_that_forks, 0, 0);
    CALL(RED_OK, red_runtime_start, &parent);
    /* Without a call, which would count itself while the body does. */
    while (!has_forked) usleep(1000);
    CALL(RED_OK, red_runtime_close, &parent);
}
#endif

static void forked(void) {
    runtime = open_runtime(1);
    task = add_task_of(&runtime, nothing, NULL);
    CALL(RED_OK, red_runtime_edit, &runtime, task, &memory, sizeof memory, &dag);
    CALL(RED_OK, red_runtime_start, &runtime);
    char path[] = "red-test-XXXXXX";
    const int file = mkstemp(path);
    EXPECT(file >= 0);
    static struct small_memory small;
    logged = open_small(&small, 1);
    CALL(RED_OK, red_record_begin, &logged, path);
    in_child(left_over);
    uint64_t dropped = 7;
    CALL(RED_OK, red_record_end, &logged, 1, &dropped);
    CALL(RED_OK, red_scheduler_close, &logged);
    close(file);
    unlink(path);
    /* The parent's goes on. */
    CALL(RED_OK, red_runtime_release, &runtime, task, RED_NONE_64);
    red_report report = RED_REPORT_INIT;
    while (report.on_time == 0) CALL(RED_OK, red_runtime_report, &runtime, &report);
    CALL(RED_OK, red_dag_close, &dag);
    CALL(RED_OK, red_runtime_close, &runtime);
}

void test_ends(void) {
    two_lanes_on_a_cpu();
    in_child(without_rights);
    in_child(without_threads);
    forked();
#ifndef __SANITIZE_ADDRESS__
    forked_by_a_body();
#endif
}
