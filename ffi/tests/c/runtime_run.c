/* A runtime that runs: bodies that fail, bodies that call back, releases, what is told. */
#include "runtime.h"

static red_runtime runtime;
static uint32_t task;
static struct dag_memory memory, edit_memory;

static void wait_for_jobs(uint64_t jobs) {
    red_report report = RED_REPORT_INIT;
    while (report.on_time + report.missed < jobs) CALL(RED_OK, red_runtime_report, &runtime, &report);
}

static void end(void) {
    CALL(RED_OK, red_runtime_stop, &runtime);
    CALL(RED_OK, red_runtime_wait, &runtime, RED_NONE_64);
    CALL(RED_OK, red_runtime_close, &runtime);
}

/* Answers by the job's number. */
static int by_index(void *user, const red_context *context) {
    (void)user;
    return (int)context->job;
}

static void failures(void) {
    runtime = open_runtime(1);
    task = add_task_of(&runtime, by_index, NULL);
    CALL(RED_OK, red_runtime_start, &runtime);
    for (uint64_t i = 0; i < 4; i++) {
        CALL(RED_OK, red_runtime_release, &runtime, task, i);
        wait_for_jobs(i + 1);
    }
    red_outcome outcomes[8] = {{0}};
    red_event events[64] = {{0}};
    size_t count = 0;
    CALL(RED_OK, red_runtime_take_outcomes, &runtime, outcomes, 8, &count);
    EXPECT(count == 4);
    uint64_t now = 0;
    CALL(RED_OK, red_runtime_now, &now);
    for (uint64_t i = 0; i < 4; i++) {
        EXPECT(outcomes[i].index == i && outcomes[i].shed == (i == 0 ? RED_SHED_NOT : RED_SHED_FAULT));
        EXPECT(outcomes[i].release_ns <= outcomes[i].at_ns && outcomes[i].at_ns <= now);
        EXPECT(outcomes[i].deadline_ns == outcomes[i].release_ns + 60 * SECOND);
    }
    CALL(RED_OK, red_runtime_take_outcomes, &runtime, outcomes, 8, &count);
    EXPECT(count == 0);
    CALL(RED_OK, red_runtime_take_events, &runtime, events, 64, &count);
    EXPECT(count >= 8 && events[0].kind == RED_EVENT_KIND_RELEASED && events[0].task == task);
    red_figures figures = RED_FIGURES_INIT;
    CALL(RED_OK, red_runtime_figures, &runtime, &figures);
    EXPECT(figures.units == 4 && figures.jobs_in_flight == 0 && figures.lanes == 1);
    red_report report = RED_REPORT_INIT;
    CALL(RED_OK, red_runtime_report, &runtime, &report);
    EXPECT(report.state == RED_RUNTIME_STATE_RUNNING && report.units == RED_NONE_64 && report.realtime == 0);
    EXPECT(report.released == 4 && report.on_time == 1 && report.missed == 3 && report.shed == 3 && report.threw == 1);
    uint32_t state = 7;
    CALL(RED_OK, red_runtime_state_of, &runtime, &state);
    EXPECT(state == RED_RUNTIME_STATE_RUNNING);
    red_warning warnings[4];
    CALL(RED_OK, red_runtime_take_warnings, &runtime, warnings, 4, &count);
    EXPECT(count == 0);
    CALL(RED_OK, red_runtime_stop, &runtime);
    CALL(RED_OK, red_runtime_wait, &runtime, 60 * SECOND);
    red_task_report of_task = RED_TASK_REPORT_INIT;
    CALL(RED_STATUS_UNKNOWN_TASK, red_runtime_task_report, &runtime, task + 1, &of_task);
    CALL(RED_OK, red_runtime_task_report, &runtime, task, &of_task);
    EXPECT(of_task.released == 4 && of_task.on_time == 1 && of_task.missed == 3 && of_task.fault == 3);
    EXPECT(of_task.value_on_time == 1 && of_task.value_released == 4 && of_task.floor_kept == 1 && of_task.warned == 0);
    CALL(RED_OK, red_runtime_report, &runtime, &report);
    EXPECT(report.state == RED_RUNTIME_STATE_ENDED && report.failed == 3 && report.units == 4 && report.stopped == 1);
    EXPECT(report.allocations == 0 && report.surrender == RED_SURRENDER_NO && report.threads_died == 0);
    CALL(RED_OK, red_runtime_close, &runtime);
}

/* What a body may do is done; what would wait for its own lane is refused, and nothing stands still. */
static struct {
    red_status add_task, remove_task, certificate, edit, commit, figures, open, start, wait, close, release, report;
    int done;
} said;
static red_dag edit;

static int calls_back(void *user, const red_context *context) {
    (void)user;
    red_dag dag = {0};
    red_runtime copy = runtime;
    red_certificate proof = RED_CERTIFICATE_INIT;
    red_figures figures = RED_FIGURES_INIT;
    red_report report = RED_REPORT_INIT;
    const red_timing timing = timing_of(SECOND);
    const red_callback callback = callback_of(0, nothing, NULL);
    uint32_t other = 7;
    said.add_task = red_runtime_add_task(&runtime, &edit, &callback, 1, &timing, &other);
    said.remove_task = red_runtime_remove_task(&runtime, task);
    said.certificate = red_runtime_certificate(&runtime, task, &proof);
    said.edit = red_runtime_edit(&runtime, task, &memory, sizeof memory, &dag);
    said.commit = red_runtime_commit(&runtime, &edit, NULL, 0, &proof);
    said.figures = red_runtime_figures(&runtime, &figures);
    const red_config policy = preset(RED_PRESET_REDRT);
    const red_runtime_config config = config_of(RED_MODE_BEST_EFFORT);
    red_runtime another = {0};
    said.open = red_runtime_open(&policy, &config, &another);
    said.start = red_runtime_start(&runtime);
    said.wait = red_runtime_wait(&runtime, RED_NONE_64);
    said.close = red_runtime_close(&copy);
    said.report = red_runtime_report(&runtime, &report);
    said.release = context->job == 0 ? red_runtime_release(&runtime, task, RED_NONE_64) : RED_OK;
    __atomic_store_n(&said.done, 1, __ATOMIC_RELEASE);
    return RED_BODY_DONE;
}

static void re_entry(void) {
    runtime = open_runtime(1);
    task = add_task_of(&runtime, calls_back, NULL);
    CALL(RED_OK, red_runtime_edit, &runtime, task, &edit_memory, sizeof edit_memory, &edit);
    CALL(RED_OK, red_runtime_every, &runtime, task, 0, 0);
    CALL(RED_OK, red_runtime_start, &runtime);
    await(&said.done);
    wait_for_jobs(2);
    CALL(RED_OK, red_dag_close, &edit);
    /* A count of jobs does not order what their bodies wrote; the end of the lanes does. */
    end();
    const char *where = "from a body";
#define SAID(expected, what) called(where, __LINE__, "red_runtime_" #what, expected, said.what)
    SAID(RED_STATUS_BUSY, add_task);
    SAID(RED_STATUS_BUSY, remove_task);
    SAID(RED_STATUS_BUSY, certificate);
    SAID(RED_STATUS_BUSY, edit);
    SAID(RED_STATUS_BUSY, commit);
    SAID(RED_STATUS_BUSY, figures);
    SAID(RED_STATUS_BUSY, open);
    SAID(RED_STATUS_BUSY, start);
    SAID(RED_STATUS_BUSY, wait);
    SAID(RED_STATUS_BUSY, close);
    SAID(RED_OK, report);
    SAID(RED_OK, release);
#undef SAID
}

/* A lane that does not come to its mailbox. */
static int began, may_end;
static int holds(void *user, const red_context *context) {
    (void)user;
    if (context->job == 0) {
        __atomic_store_n(&began, 1, __ATOMIC_RELEASE);
        await(&may_end);
    }
    return RED_BODY_DONE;
}

static void too_many_releases(void) {
    runtime = open_runtime(1);
    task = add_task_of(&runtime, holds, NULL);
    CALL(RED_OK, red_runtime_start, &runtime);
    CALL(RED_OK, red_runtime_release, &runtime, task, RED_NONE_64);
    await(&began);
    red_status status = RED_OK;
    for (int i = 0; status == RED_OK && i < 100000; i++) status = red_runtime_release(&runtime, task, RED_NONE_64);
    CALL(RED_STATUS_MAILBOX_FULL, red_runtime_release, &runtime, task, RED_NONE_64);
    __atomic_store_n(&may_end, 1, __ATOMIC_RELEASE);
    wait_for_jobs(2);
    /* Of a task that is not there nothing comes. */
    status = RED_STATUS_MAILBOX_FULL;
    while (status == RED_STATUS_MAILBOX_FULL) status = red_runtime_release(&runtime, task + 1, RED_NONE_64);
    EXPECT(status == RED_OK);
    end();
}

void test_run(void) {
    failures();
    re_entry();
    too_many_releases();
}
