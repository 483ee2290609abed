/* Tasks of a runtime: admitted, edited, removed; before the start, while lanes run, and after the end. */
#include "runtime.h"

static struct dag_memory memory, edit_memory, other_memory;

static red_runtime open_enforcing(void) {
    red_config policy = preset(RED_PRESET_REDRT);
    policy.admission = RED_ADMISSION_ENFORCE;
    policy.memory_bytes = 1000;
    const red_runtime_config config = config_of(RED_MODE_BEST_EFFORT);
    red_runtime runtime = {0};
    CALL(RED_OK, red_runtime_open, &policy, &config, &runtime);
    return runtime;
}

static void admit(red_status wanted, red_runtime *runtime, red_node node, red_timing timing) {
    red_dag dag = open_dag(&memory);
    uint32_t task = RED_NONE;
    const red_callback callback = callback_of(add(&dag, node), nothing, NULL);
    CALL(wanted, red_runtime_add_task, runtime, &dag, &callback, 1, &timing, &task);
    EXPECT((task == RED_NONE) == (wanted != RED_OK));
    CALL(RED_OK, red_dag_close, &dag);
}

static void admission(void) {
    red_runtime runtime = open_enforcing();
    const red_node node = node_of(4 * MS);
    const red_timing timing = timing_of(SECOND);
    admit(RED_STATUS_DEADLINE, &runtime, node, timing_of(0));
    admit(RED_STATUS_UNSCHEDULABLE, &runtime, node, timing_of(3 * MS));
    red_timing floor = timing;
    floor.floor_keep = 2;
    floor.floor_of = 1;
    admit(RED_STATUS_OUT_OF_RANGE, &runtime, node, floor);
    red_timing newer = timing;
    newer.reserved = 1;
    admit(RED_STATUS_UNKNOWN_FIELD, &runtime, node, newer);
    red_node other = node;
    other.pool = 1;
    admit(RED_STATUS_UNKNOWN_POOL, &runtime, other, timing);
    other = node;
    other.memory_bytes = 1001;
    admit(RED_STATUS_MEMORY, &runtime, other, timing);
    admit(RED_STATUS_UNKNOWN_SENSOR, &runtime, encoder_of(MS, 0, 0), timing);

    uint32_t task = 7;
    red_dag dag = open_dag(&memory);
    CALL(RED_STATUS_EMPTY_GRAPH, red_runtime_add_task, &runtime, &dag, NULL, 0, &timing, &task);
    add(&dag, node);
    add(&dag, node);
    red_callback bodies[] = {callback_of(0, nothing, NULL), callback_of(0, nothing, NULL), callback_of(1, nothing, NULL)};
    CALL(RED_STATUS_NO_BODY, red_runtime_add_task, &runtime, &dag, bodies, 1, &timing, &task);
    CALL(RED_STATUS_UNKNOWN_NODE, red_runtime_add_task, &runtime, &dag, bodies, 3, &timing, &task);
    bodies[0].node = 2;
    CALL(RED_STATUS_UNKNOWN_NODE, red_runtime_add_task, &runtime, &dag, bodies, 2, &timing, &task);
    bodies[0].node = 256;
    CALL(RED_STATUS_UNKNOWN_NODE, red_runtime_add_task, &runtime, &dag, bodies, 2, &timing, &task);
    bodies[0].node = 0;
    bodies[0].reserved = 1;
    CALL(RED_STATUS_UNKNOWN_FIELD, red_runtime_add_task, &runtime, &dag, bodies, 1, &timing, &task);
    bodies[0] = callback_of(0, NULL, NULL);
    CALL(RED_STATUS_NO_BODY, red_runtime_add_task, &runtime, &dag, bodies + 1, 0, &timing, &task);
    CALL(RED_STATUS_NO_BODY, red_runtime_add_task, &runtime, &dag, bodies, 1, &timing, &task);
    CALL(RED_STATUS_TOO_LONG, red_runtime_add_task, &runtime, &dag, bodies, 1000, &timing, &task);
    CALL(RED_OK, red_dag_close, &dag);
    static struct small_dag_memory small_memory;
    red_dag small = open_small_dag(&small_memory);
    add(&small, node);
    CALL(RED_STATUS_OTHER_CLASS, red_runtime_add_task, &runtime, &small, bodies + 1, 1, &timing, &task);
    CALL(RED_OK, red_dag_close, &small);
    EXPECT(task == 7);
    for (int i = 0; i < 16; i++) admit(RED_OK, &runtime, node, timing);
    admit(RED_STATUS_TASKS_FULL, &runtime, node, timing);
    CALL(RED_OK, red_runtime_close, &runtime);
}

static red_dag begin(red_runtime *runtime, uint32_t task, struct dag_memory *at) {
    red_dag edit = {0};
    CALL(RED_OK, red_runtime_edit, runtime, task, at, sizeof *at, &edit);
    return edit;
}

/* Adds a node to an edit, and tries to commit it; then the node goes again. */
static void commit_with(red_status wanted, red_runtime *runtime, red_dag *edit, red_node node) {
    red_certificate proof = RED_CERTIFICATE_INIT;
    const red_callback callback = callback_of(add(edit, node), nothing, NULL);
    CALL(wanted, red_runtime_commit, runtime, edit, &callback, 1, &proof);
    CALL(RED_OK, red_dag_remove_node, edit, callback.node);
}

/* A body that stays until it is let go. */
static int began, may_end;
static int holds(void *user, const red_context *context) {
    (void)user;
    (void)context;
    __atomic_store_n(&began, 1, __ATOMIC_RELEASE);
    await(&may_end);
    return RED_BODY_DONE;
}

static void edits(bool running) {
    red_runtime runtime = open_enforcing();
    const uint32_t task = add_task_of(&runtime, nothing, NULL), unknown = task + 1;
    if (running) CALL(RED_OK, red_runtime_start, &runtime);
    red_certificate proof = RED_CERTIFICATE_INIT;
    CALL(RED_OK, red_runtime_certificate, &runtime, task, &proof);
    EXPECT(proof.response_ns == MS && proof.limit_ns == 60 * SECOND);
    CALL(RED_STATUS_UNKNOWN_TASK, red_runtime_certificate, &runtime, unknown, &proof);
    CALL(RED_STATUS_UNKNOWN_TASK, red_runtime_remove_task, &runtime, unknown);

    red_dag edit = {0};
    CALL(RED_STATUS_UNKNOWN_TASK, red_runtime_edit, &runtime, unknown, &edit_memory, sizeof edit_memory, &edit);
    CALL(RED_STATUS_TOO_SHORT, red_runtime_edit, &runtime, task, &edit_memory, 16, &edit);
    CALL(RED_STATUS_MISALIGNED, red_runtime_edit, &runtime, task, edit_memory.bytes + 1, sizeof edit_memory, &edit);
    edit = begin(&runtime, task, &edit_memory);
    red_dag other = {0};
    CALL(RED_STATUS_OVERLAP, red_runtime_edit, &runtime, task, &edit_memory, sizeof edit_memory, &other);

    red_node node = node_of(MS);
    node.pool = 1;
    commit_with(RED_STATUS_UNKNOWN_POOL, &runtime, &edit, node);
    commit_with(RED_STATUS_UNKNOWN_SENSOR, &runtime, &edit, encoder_of(MS, 0, 0));
    node = node_of(MS);
    node.memory_bytes = 1001;
    commit_with(RED_STATUS_MEMORY, &runtime, &edit, node);
    commit_with(RED_STATUS_UNSCHEDULABLE, &runtime, &edit, node_of(61 * SECOND));
    const red_callback again = callback_of(0, nothing, NULL), nowhere = callback_of(9, nothing, NULL);
    CALL(RED_STATUS_HAS_BODY, red_runtime_commit, &runtime, &edit, &again, 1, &proof);
    CALL(RED_STATUS_UNKNOWN_NODE, red_runtime_commit, &runtime, &edit, &nowhere, 1, &proof);
    const uint32_t added = add(&edit, node_of(MS));
    CALL(RED_STATUS_NO_BODY, red_runtime_commit, &runtime, &edit, NULL, 0, &proof);
    CALL(RED_OK, red_dag_remove_node, &edit, added);
    CALL(RED_OK, red_dag_remove_node, &edit, 0);
    CALL(RED_STATUS_EMPTY_GRAPH, red_runtime_commit, &runtime, &edit, NULL, 0, &proof);
    CALL(RED_OK, red_dag_close, &edit);
    static struct small_dag_memory small_memory;
    red_dag small = open_small_dag(&small_memory);
    add(&small, node_of(MS));
    CALL(RED_STATUS_OTHER_CLASS, red_runtime_commit, &runtime, &small, NULL, 0, &proof);
    CALL(RED_OK, red_dag_close, &small);

    /* Of two edits the first one that is committed counts. */
    edit = begin(&runtime, task, &edit_memory);
    other = begin(&runtime, task, &other_memory);
    CALL(RED_OK, red_runtime_commit, &runtime, &edit, NULL, 0, &proof);
    CALL(RED_STATUS_CONFLICT, red_runtime_commit, &runtime, &other, NULL, 0, &proof);
    CALL(RED_OK, red_dag_close, &other);
    CALL(RED_OK, red_dag_close, &edit);
    /* Also where each adds a node, so that bodies are missing or there already. */
    edit = begin(&runtime, task, &edit_memory);
    other = begin(&runtime, task, &other_memory);
    const red_callback first = callback_of(add(&edit, node_of(MS)), nothing, NULL);
    const red_callback second = callback_of(add(&other, node_of(MS)), nothing, NULL);
    CALL(RED_OK, red_runtime_commit, &runtime, &edit, &first, 1, &proof);
    CALL(RED_STATUS_CONFLICT, red_runtime_commit, &runtime, &other, &second, 1, &proof);
    CALL(RED_OK, red_dag_close, &other);
    CALL(RED_OK, red_dag_close, &edit);
    edit = begin(&runtime, task, &edit_memory);
    CALL(RED_OK, red_runtime_remove_task, &runtime, task);
    CALL(RED_STATUS_UNKNOWN_TASK, red_runtime_commit, &runtime, &edit, NULL, 0, &proof);
    CALL(RED_OK, red_dag_close, &edit);
    CALL(RED_OK, red_runtime_close, &runtime);
}

/* What is released of a task that is gone is no job. */
static void gone(void) {
    red_runtime runtime = open_runtime(1);
    const uint32_t task = add_task_of(&runtime, nothing, NULL);
    CALL(RED_OK, red_runtime_start, &runtime);
    CALL(RED_OK, red_runtime_release, &runtime, task, RED_NONE_64);
    red_report report = RED_REPORT_INIT;
    while (report.on_time == 0) CALL(RED_OK, red_runtime_report, &runtime, &report);
    CALL(RED_OK, red_runtime_remove_task, &runtime, task);
    CALL(RED_OK, red_runtime_release, &runtime, task, RED_NONE_64);
    red_figures figures = RED_FIGURES_INIT;
    CALL(RED_OK, red_runtime_figures, &runtime, &figures);
    CALL(RED_OK, red_runtime_stop, &runtime);
    CALL(RED_OK, red_runtime_wait, &runtime, RED_NONE_64);
    CALL(RED_OK, red_runtime_report, &runtime, &report);
    EXPECT(report.released == 1 && report.on_time == 1 && report.shed == 0);
    CALL(RED_OK, red_runtime_close, &runtime);
}

/* A third graph waits until no job has the first. */
static void draining(void) {
    red_runtime runtime = open_runtime(2);
    const uint32_t task = add_task_of(&runtime, holds, NULL);
    CALL(RED_OK, red_runtime_every, &runtime, task, 0, 0);
    CALL(RED_OK, red_runtime_start, &runtime);
    await(&began);
    red_certificate proof = RED_CERTIFICATE_INIT;
    red_dag edit = begin(&runtime, task, &edit_memory);
    CALL(RED_OK, red_runtime_commit, &runtime, &edit, NULL, 0, &proof);
    CALL(RED_OK, red_dag_close, &edit);
    edit = begin(&runtime, task, &edit_memory);
    CALL(RED_STATUS_DRAINING, red_runtime_commit, &runtime, &edit, NULL, 0, &proof);
    CALL(RED_STATUS_TIMEOUT, red_runtime_wait, &runtime, 0);
    __atomic_store_n(&may_end, 1, __ATOMIC_RELEASE);
    while (red_runtime_commit(&runtime, &edit, NULL, 0, &proof) == RED_STATUS_DRAINING) {
    }
    CALL(RED_OK, red_dag_close, &edit);
    edit = begin(&runtime, task, &edit_memory);

    /* What is over. */
    CALL(RED_OK, red_runtime_stop, &runtime);
    CALL(RED_OK, red_runtime_wait, &runtime, RED_NONE_64);
    CALL(RED_STATUS_OVER, red_runtime_commit, &runtime, &edit, NULL, 0, &proof);
    CALL(RED_STATUS_OVER, red_runtime_edit, &runtime, task, &other_memory, sizeof other_memory, &edit);
    CALL(RED_STATUS_OVER, red_runtime_certificate, &runtime, task, &proof);
    CALL(RED_STATUS_OVER, red_runtime_remove_task, &runtime, task);
    CALL(RED_STATUS_OVER, red_runtime_release, &runtime, task, RED_NONE_64);
    red_figures figures = RED_FIGURES_INIT;
    CALL(RED_STATUS_OVER, red_runtime_figures, &runtime, &figures);
    CALL(RED_OK, red_dag_close, &edit);
    admit(RED_STATUS_OVER, &runtime, node_of(MS), timing_of(SECOND));
    CALL(RED_OK, red_runtime_stop, &runtime);
    CALL(RED_OK, red_runtime_close, &runtime);
}

void test_runtime_tasks(void) {
    admission();
    edits(false);
    edits(true);
    gone();
    draining();
}
