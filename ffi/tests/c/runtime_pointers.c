/* Pointers that can be seen to be wrong, for each pointer of each function of the runtime; nothing has changed then. */
#include "runtime.h"

static struct dag_memory memory, edit_memory;

void test_runtime_pointers(void) {
    red_runtime runtime = open_runtime(1);
    const uint32_t task = add_task_of(&runtime, nothing, NULL), cpu = 0;
    const red_config policy = preset(RED_PRESET_REDRT);
    const red_runtime_config config = config_of(RED_MODE_BEST_EFFORT);
    red_dag dag = open_dag(&memory), edit = {0};
    const red_callback callback = callback_of(add(&dag, node_of(MS)), nothing, NULL);
    const red_timing timing = timing_of(SECOND);
    red_certificate proof = RED_CERTIFICATE_INIT;
    red_figures figures = RED_FIGURES_INIT;
    red_report report_of = RED_REPORT_INIT;
    red_outcome outcomes[1];
    red_event events[1];
    uint32_t number = 7;
    size_t count = 7;
    char text[8];
    WRONG(red_config, red_runtime_open, X, &config, &runtime);
    WRONG(red_runtime_config, red_runtime_open, &policy, X, &runtime);
    WRONG(red_runtime, red_runtime_open, &policy, &config, X);
    WRONG(red_runtime, red_runtime_close, X);
    WRONG(red_runtime, red_runtime_state_of, X, &number);
    WRONG(uint32_t, red_runtime_state_of, &runtime, X);
    WRONG(red_runtime, red_runtime_message, X, text, sizeof text, &count);
    CALL(RED_STATUS_NULL_POINTER, red_runtime_message, &runtime, NULL, 1, &count);
    WRONG(size_t, red_runtime_message, &runtime, text, sizeof text, X);
    WRONG(red_runtime, red_runtime_report, X, &report_of);
    WRONG(red_report, red_runtime_report, &runtime, X);
    WRONG(red_runtime, red_runtime_start, X);
    WRONG(red_runtime, red_runtime_release, X, task, RED_NONE_64);
    WRONG(red_runtime, red_runtime_stop, X);
    WRONG(red_runtime, red_runtime_wait, X, 0);
    WRONG(red_runtime, red_runtime_figures, X, &figures);
    WRONG(red_figures, red_runtime_figures, &runtime, X);
    WRONG(red_runtime, red_runtime_take_outcomes, X, outcomes, 1, &count);
    WRONG(red_outcome, red_runtime_take_outcomes, &runtime, X, 1, &count);
    WRONG(size_t, red_runtime_take_outcomes, &runtime, outcomes, 1, X);
    red_warning warnings[1];
    WRONG(red_runtime, red_runtime_take_warnings, X, warnings, 1, &count);
    WRONG(red_warning, red_runtime_take_warnings, &runtime, X, 1, &count);
    WRONG(size_t, red_runtime_take_warnings, &runtime, warnings, 1, X);
    red_task_report of_task = RED_TASK_REPORT_INIT;
    WRONG(red_runtime, red_runtime_task_report, X, 0, &of_task);
    WRONG(red_task_report, red_runtime_task_report, &runtime, 0, X);
    WRONG(red_runtime, red_runtime_take_events, X, events, 1, &count);
    WRONG(red_event, red_runtime_take_events, &runtime, X, 1, &count);
    WRONG(size_t, red_runtime_take_events, &runtime, events, 1, X);
    WRONG(red_runtime, red_runtime_add_pool, X, 1, RED_NONE_64, &number);
    WRONG(uint32_t, red_runtime_add_pool, &runtime, 1, RED_NONE_64, X);
    WRONG(red_runtime, red_runtime_add_cuda_pool, X, 0, 1, RED_NONE_64, &number);
    WRONG(uint32_t, red_runtime_add_cuda_pool, &runtime, 0, 1, RED_NONE_64, X);
    WRONG(red_runtime, red_runtime_add_sensor, X, MS, &number);
    WRONG(uint32_t, red_runtime_add_sensor, &runtime, MS, X);
    WRONG(red_runtime, red_runtime_pin, X, &cpu, 1);
    WRONG(uint32_t, red_runtime_pin, &runtime, X, 1);
    WRONG(red_runtime, red_runtime_every, X, task, 0, MS);
    WRONG(red_runtime, red_runtime_record, X, "log");
    WRONG(uint64_t, red_runtime_now, X);
    WRONG(red_runtime, red_runtime_add_task, X, &dag, &callback, 1, &timing, &number);
    WRONG(red_dag, red_runtime_add_task, &runtime, X, &callback, 1, &timing, &number);
    WRONG(red_callback, red_runtime_add_task, &runtime, &dag, X, 1, &timing, &number);
    WRONG(red_timing, red_runtime_add_task, &runtime, &dag, &callback, 1, X, &number);
    WRONG(uint32_t, red_runtime_add_task, &runtime, &dag, &callback, 1, &timing, X);
    WRONG(red_runtime, red_runtime_remove_task, X, task);
    WRONG(red_runtime, red_runtime_certificate, X, task, &proof);
    WRONG(red_certificate, red_runtime_certificate, &runtime, task, X);
    WRONG(red_runtime, red_runtime_edit, X, task, &edit_memory, sizeof edit_memory, &edit);
    CALL(RED_STATUS_NULL_POINTER, red_runtime_edit, &runtime, task, NULL, sizeof edit_memory, &edit);
    WRONG(red_dag, red_runtime_edit, &runtime, task, &edit_memory, sizeof edit_memory, X);
    WRONG(red_runtime, red_runtime_commit, X, &dag, &callback, 1, &proof);
    WRONG(red_dag, red_runtime_commit, &runtime, X, &callback, 1, &proof);
    WRONG(red_callback, red_runtime_commit, &runtime, &dag, X, 1, &proof);
    WRONG(red_certificate, red_runtime_commit, &runtime, &dag, &callback, 1, X);
    EXPECT(number == 7 && count == 7);

    /* Handles of something else. */
    const red_runtime as_runtime = {dag.bits}, made_up = {UINT64_C(0x123456789abcdef0)};
    CALL(RED_STATUS_OTHER_KIND, red_runtime_stop, &as_runtime);
    CALL(RED_STATUS_FOREIGN, red_runtime_stop, &made_up);
    const red_dag as_dag = {runtime.bits};
    red_dag_summary summary = RED_DAG_SUMMARY_INIT;
    CALL(RED_STATUS_OTHER_KIND, red_dag_summarize, &as_dag, &summary);
    CALL(RED_OK, red_dag_close, &dag);
    CALL(RED_OK, red_runtime_close, &runtime);
}
