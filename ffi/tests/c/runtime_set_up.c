/* A runtime before it starts: opened, pools, sensors, CPUs, releases by the clock, a log. */
#define _GNU_SOURCE
#include "runtime.h"

#include <dirent.h>
#include <errno.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <unistd.h>

static void opening(void) {
    red_config policy = preset(RED_PRESET_REDRT);
    red_runtime_config config = config_of(RED_MODE_BEST_EFFORT);
    red_runtime runtime = {0};
    config.mode = 2;
    CALL(RED_STATUS_OUT_OF_RANGE, red_runtime_open, &policy, &config, &runtime);
    config = config_of(RED_MODE_REAL_TIME);
    config.priority = 99;
    CALL(RED_STATUS_OUT_OF_RANGE, red_runtime_open, &policy, &config, &runtime);
    config = config_of(RED_MODE_BEST_EFFORT);
    policy.lanes = 0;
    CALL(RED_STATUS_NO_LANE, red_runtime_open, &policy, &config, &runtime);
    policy.lanes = 33;
    CALL(RED_STATUS_POOLS_FULL, red_runtime_open, &policy, &config, &runtime);
    policy.lanes = 1;
    policy.preempt = 1;
    CALL(RED_STATUS_PREEMPTS, red_runtime_open, &policy, &config, &runtime);
    EXPECT(runtime.bits == 0);

    /* As many as there may be. */
    static struct small_dag_memory memories[256];
    static red_dag dags[256];
    size_t open = 0;
    while (open < 256 && red_dag_open_4x16x16(&memories[open], sizeof memories[open], &dags[open]) == RED_OK) open++;
    policy.preempt = 0;
    CALL(RED_STATUS_TOO_MANY_OPEN, red_runtime_open, &policy, &config, &runtime);
    CALL(RED_OK, red_dag_close, &dags[--open]);
    CALL(RED_OK, red_dag_close, &dags[--open]);
    runtime = open_runtime(1);
    const uint32_t task = add_task_of(&runtime, nothing, NULL);
    red_dag dag = open_small_dag(&memories[open]), edit = {0};
    static struct dag_memory edit_memory;
    CALL(RED_STATUS_TOO_MANY_OPEN, red_runtime_edit, &runtime, task, &edit_memory, sizeof edit_memory, &edit);
    CALL(RED_OK, red_dag_close, &dag);
    while (open > 0) CALL(RED_OK, red_dag_close, &dags[--open]);

    const red_runtime copy = runtime;
    CALL(RED_OK, red_runtime_close, &runtime);
    EXPECT(runtime.bits == 0);
    CALL(RED_STATUS_CLOSED, red_runtime_close, &runtime);
    runtime = copy;
    CALL(RED_STATUS_CLOSED, red_runtime_close, &runtime);
    CALL(RED_STATUS_CLOSED, red_runtime_release, &runtime, task, RED_NONE_64);
}

/* Everything that is refused once lanes run. */
static void what_comes_before(void) {
    red_runtime runtime = open_runtime(2);
    uint32_t pool = 7, sensor = 7, same = 7;
    CALL(RED_STATUS_NO_LANE, red_runtime_add_pool, &runtime, 0, RED_NONE_64, &pool);
    CALL(RED_STATUS_POOLS_FULL, red_runtime_add_pool, &runtime, 31, RED_NONE_64, &pool);
    CALL(RED_STATUS_POOLS_FULL, red_runtime_add_pool, &runtime, 300, RED_NONE_64, &pool);
    EXPECT(pool == 7);
    CALL(RED_OK, red_runtime_add_pool, &runtime, 1, 1000, &pool);
    EXPECT(pool == 1);
    CALL(RED_STATUS_CUDA, red_runtime_add_cuda_pool, &runtime, 7, 1, RED_NONE_64, &pool);
    CALL(RED_STATUS_NO_LANE, red_runtime_add_cuda_pool, &runtime, 0, 0, RED_NONE_64, &pool);
    CALL(RED_STATUS_POOLS_FULL, red_runtime_add_cuda_pool, &runtime, 0, 31, RED_NONE_64, &pool);
    CALL(RED_STATUS_POOLS_FULL, red_runtime_add_cuda_pool, &runtime, 0, 300, RED_NONE_64, &pool);
    EXPECT(pool == 1);
    CALL(RED_OK, red_runtime_add_cuda_pool, &runtime, 0, 2, 1000, &pool);
    CALL(RED_OK, red_runtime_add_cuda_pool, &runtime, 0, 1, RED_NONE_64, &pool);
    EXPECT(pool == 3);
    CALL(RED_STATUS_OUT_OF_RANGE, red_runtime_add_cuda_pool, &runtime, 7, 1, RED_NONE_64, &pool);
    CALL(RED_STATUS_OUT_OF_RANGE, red_runtime_add_cuda_pool, &runtime, UINT32_MAX, 1, RED_NONE_64, &pool);
    CALL(RED_STATUS_ZERO_PERIOD, red_runtime_add_sensor, &runtime, 0, &sensor);
    CALL(RED_OK, red_runtime_add_sensor, &runtime, 33 * MS, &sensor);
    CALL(RED_OK, red_runtime_add_sensor, &runtime, 33 * MS, &same);
    EXPECT(sensor == same);
    red_status status = RED_OK;
    for (uint64_t period = 1; status == RED_OK && period < 1000; period++)
        status = red_runtime_add_sensor(&runtime, period, &sensor);
    CALL(RED_STATUS_SENSORS_FULL, red_runtime_add_sensor, &runtime, 2000, &sensor);
    const uint32_t cpus[33] = {0, 1, 2}, beyond = 1024;
    CALL(RED_STATUS_TOO_LONG, red_runtime_pin, &runtime, cpus, 33);
    CALL(RED_STATUS_OUT_OF_RANGE, red_runtime_pin, &runtime, &beyond, 1);
    CALL(RED_OK, red_runtime_pin, &runtime, cpus, 3);
    CALL(RED_OK, red_runtime_pin, &runtime, NULL, 0);
    const uint32_t task = add_task_of(&runtime, nothing, NULL);
    CALL(RED_STATUS_UNKNOWN_TASK, red_runtime_every, &runtime, task + 1, 0, MS);
    CALL(RED_OK, red_runtime_every, &runtime, task, 0, 0);
    CALL(RED_STATUS_LOG_LATE, red_runtime_record, &runtime, "late.redlog");

    CALL(RED_STATUS_IDLE, red_runtime_release, &runtime, task, RED_NONE_64);
    CALL(RED_STATUS_IDLE, red_runtime_stop, &runtime);
    CALL(RED_STATUS_IDLE, red_runtime_wait, &runtime, 0);
    CALL(RED_OK, red_runtime_start, &runtime);
    CALL(RED_STATUS_STARTED, red_runtime_start, &runtime);
    CALL(RED_STATUS_STARTED, red_runtime_add_pool, &runtime, 1, RED_NONE_64, &pool);
    CALL(RED_STATUS_STARTED, red_runtime_add_cuda_pool, &runtime, 0, 1, RED_NONE_64, &pool);
    CALL(RED_STATUS_STARTED, red_runtime_add_sensor, &runtime, MS, &sensor);
    CALL(RED_STATUS_STARTED, red_runtime_pin, &runtime, cpus, 3);
    CALL(RED_STATUS_STARTED, red_runtime_every, &runtime, task, 0, MS);
    CALL(RED_STATUS_STARTED, red_runtime_record, &runtime, "late.redlog");
    CALL(RED_OK, red_runtime_close, &runtime);
}

/* A file that was not there before: its name is written over `name`. */
static int new_file(char *name) {
    const int file = mkstemp(name);
    EXPECT(file >= 0);
    return file;
}

/* How many this process has. */
static int threads(void) {
    DIR *all = opendir("/proc/self/task");
    EXPECT(all != NULL);
    int count = 0;
    while (readdir(all) != NULL) count += 1;
    closedir(all);
    return count;
}

/* What the runtime says in words begins so, and says what to do; or it says nothing. */
static void said(red_runtime *runtime, const char *begin) {
    char text[512];
    size_t count = 7;
    CALL(RED_OK, red_runtime_message, runtime, text, sizeof text, &count);
    EXPECT(strncmp(text, begin, strlen(begin)) == 0 && (begin[0] != 0 ? strstr(text, "fix: ") != NULL : count == 1));
}

static void logs(void) {
    red_runtime runtime = open_runtime(1);
    static char endless[5000];
    memset(endless, 'a', sizeof endless - 1);
    CALL(RED_STATUS_NULL_POINTER, red_runtime_record, &runtime, NULL);
    CALL(RED_STATUS_TEXT, red_runtime_record, &runtime, "");
    CALL(RED_STATUS_TEXT, red_runtime_record, &runtime, "\xff");
    CALL(RED_STATUS_TEXT, red_runtime_record, &runtime, endless);
    errno = 0;
    CALL(RED_STATUS_LOG_FILE, red_runtime_record, &runtime, "/no such folder/red.redlog");
    EXPECT(errno == ENOENT);
    said(&runtime, "/no such folder/red.redlog: No such file");
    char path[] = "red-test-XXXXXX";
    const int file = new_file(path);
    CALL(RED_OK, red_runtime_record, &runtime, path);
    said(&runtime, "");
    CALL(RED_STATUS_LOG_LATE, red_runtime_record, &runtime, path);
    const uint32_t task = add_task_of(&runtime, nothing, NULL);
    CALL(RED_OK, red_runtime_every, &runtime, task, 0, 0);
    CALL(RED_OK, red_runtime_start, &runtime);
    red_report report = RED_REPORT_INIT;
    while (report.on_time == 0) CALL(RED_OK, red_runtime_report, &runtime, &report);
    CALL(RED_OK, red_runtime_stop, &runtime);
    CALL(RED_OK, red_runtime_wait, &runtime, RED_NONE_64);
    CALL(RED_OK, red_runtime_report, &runtime, &report);
    EXPECT(report.log_dropped == 0 && report.units == 1);
    CALL(RED_OK, red_runtime_close, &runtime);
    EXPECT(lseek(file, 0, SEEK_END) > 100);

    /* No room on the disk: of this process, a limit. */
    runtime = open_runtime(1);
    CALL(RED_OK, red_runtime_record, &runtime, path);
    struct rlimit before, tight;
    EXPECT(getrlimit(RLIMIT_FSIZE, &before) == 0);
    tight = before;
    tight.rlim_cur = 1;
    signal(SIGXFSZ, SIG_IGN);
    EXPECT(setrlimit(RLIMIT_FSIZE, &tight) == 0);
    CALL(RED_OK, red_runtime_start, &runtime);
    CALL(RED_OK, red_runtime_stop, &runtime);
    CALL(RED_OK, red_runtime_wait, &runtime, RED_NONE_64);
    EXPECT(setrlimit(RLIMIT_FSIZE, &before) == 0);
    CALL(RED_OK, red_runtime_report, &runtime, &report);
    EXPECT(report.log_dropped > 0);
    said(&runtime, "the log is not whole: File too large");
    CALL(RED_OK, red_runtime_close, &runtime);
    close(file);
    unlink(path);
}

/* Of a scheduler that is driven here. */
static void own_logs(void) {
    static struct small_memory memory;
    red_scheduler scheduler = open_small(&memory, 1);
    red_action action;
    uint64_t dropped = 7;
    uint32_t number;
    CALL(RED_STATUS_IDLE, red_record_end, &scheduler, 1, &dropped);
    CALL(RED_STATUS_TEXT, red_record_begin, &scheduler, "");
    errno = 0;
    CALL(RED_STATUS_LOG_FILE, red_record_begin, &scheduler, "/no such folder/red.redlog");
    EXPECT(errno == ENOENT);
    char path[] = "red-test-XXXXXX";
    const int file = new_file(path);
    CALL(RED_OK, red_record_begin, &scheduler, path);
    CALL(RED_STATUS_LOG_LATE, red_record_begin, &scheduler, path);
    CALL(RED_OK, red_scheduler_add_pool, &scheduler, 1, RED_NONE_64, &number);
    CALL(RED_OK, red_scheduler_poll, &scheduler, 1, &action);
    CALL(RED_OK, red_record_end, &scheduler, 2, &dropped);
    EXPECT(dropped == 0 && lseek(file, 0, SEEK_END) > 100);
    CALL(RED_STATUS_LOG_LATE, red_record_begin, &scheduler, path);
    CALL(RED_OK, red_scheduler_close, &scheduler);

    /* What a log would not have. */
    scheduler = open_small(&memory, 1);
    CALL(RED_OK, red_scheduler_poll, &scheduler, 1, &action);
    CALL(RED_STATUS_LOG_LATE, red_record_begin, &scheduler, path);
    CALL(RED_OK, red_scheduler_close, &scheduler);
    scheduler = open_small(&memory, 1);
    CALL(RED_OK, red_scheduler_retire_lane, &scheduler, 0);
    CALL(RED_STATUS_LOG_LATE, red_record_begin, &scheduler, path);
    CALL(RED_OK, red_scheduler_close, &scheduler);

    /* Who writes a log that nobody ends goes with its scheduler. */
    const int alone = threads();
    scheduler = open_small(&memory, 1);
    CALL(RED_OK, red_record_begin, &scheduler, path);
    EXPECT(threads() > alone);
    CALL(RED_OK, red_scheduler_close, &scheduler);
    while (threads() > alone) usleep(1000);

    /* No room on the disk: of this process, a limit. */
    scheduler = open_small(&memory, 1);
    CALL(RED_OK, red_record_begin, &scheduler, path);
    struct rlimit before, tight;
    EXPECT(getrlimit(RLIMIT_FSIZE, &before) == 0);
    tight = before;
    tight.rlim_cur = 1;
    signal(SIGXFSZ, SIG_IGN);
    EXPECT(setrlimit(RLIMIT_FSIZE, &tight) == 0);
    CALL(RED_OK, red_scheduler_poll, &scheduler, 1, &action);
    errno = 0;
    CALL(RED_STATUS_LOG_FILE, red_record_end, &scheduler, 2, &dropped);
    EXPECT(errno == EFBIG);
    EXPECT(setrlimit(RLIMIT_FSIZE, &before) == 0);
    CALL(RED_OK, red_scheduler_close, &scheduler);
    close(file);
    unlink(path);
}

void test_set_up(void) {
    opening();
    what_comes_before();
    logs();
    own_logs();
}
