/* Pools, sensors, tasks, edits. */
#include "calls.h"

static struct small_memory memory;
static struct small_dag_memory dag_memory, edit_memory, other_memory;

static void pools_and_sensors(void) {
    red_scheduler scheduler = open_small(&memory, 2);
    uint32_t pool = 0, sensor = 0, same = 0;
    CALL(RED_STATUS_NO_LANE, red_scheduler_add_pool, &scheduler, 0, RED_NONE_64, &pool);
    CALL(RED_STATUS_POOLS_FULL, red_scheduler_add_pool, &scheduler, 3, RED_NONE_64, &pool);
    CALL(RED_OK, red_scheduler_add_pool, &scheduler, 1, 1000, &pool);
    EXPECT(pool == 1);
    CALL(RED_STATUS_POOLS_FULL, red_scheduler_add_pool, &scheduler, 1, RED_NONE_64, &pool);
    uint64_t used = 7;
    CALL(RED_OK, red_scheduler_memory_used, &scheduler, 1, &used);
    EXPECT(used == 0);
    CALL(RED_STATUS_UNKNOWN_POOL, red_scheduler_memory_used, &scheduler, 2, &used);

    CALL(RED_STATUS_ZERO_PERIOD, red_scheduler_add_sensor, &scheduler, 0, &sensor);
    CALL(RED_OK, red_scheduler_add_sensor, &scheduler, 33 * MS, &sensor);
    CALL(RED_OK, red_scheduler_add_sensor, &scheduler, 33 * MS, &same);
    EXPECT(sensor == same);
    red_status status = RED_OK;
    for (uint64_t period = 1; status == RED_OK && period < 1000; period++)
        status = red_scheduler_add_sensor(&scheduler, period, &sensor);
    EXPECT(status == RED_STATUS_SENSORS_FULL);
    CALL(RED_STATUS_SENSORS_FULL, red_scheduler_add_sensor, &scheduler, 2000, &sensor);

    red_config config = RED_CONFIG_INIT;
    CALL(RED_OK, red_scheduler_config, &scheduler, &config);
    EXPECT(config.lanes == 2 && config.rule == RED_RULE_LATEST_START);
    CALL(RED_OK, red_scheduler_close, &scheduler);
}

/* Tries to admit a graph of one node. */
static void admit(red_status wanted, red_scheduler *scheduler, red_node node, red_timing timing) {
    red_dag dag = open_small_dag(&dag_memory);
    uint32_t task = 7;
    add(&dag, node);
    CALL(wanted, red_scheduler_add_task, scheduler, &dag, &timing, &task);
    EXPECT((task == 7) == (wanted != RED_OK));
    CALL(RED_OK, red_dag_close, &dag);
}

static void admission(void) {
    red_config config = preset(RED_PRESET_REDRT);
    config.admission = RED_ADMISSION_ENFORCE;
    config.memory_bytes = 1000;
    red_scheduler scheduler = {0};
    CALL(RED_OK, red_scheduler_open_4x16x16, &memory, sizeof memory, &config, &scheduler);
    const red_node node = node_of(4 * MS);
    const red_timing timing = timing_of(SECOND);
    admit(RED_STATUS_DEADLINE, &scheduler, node, timing_of(0));
    admit(RED_STATUS_DEADLINE, &scheduler, node, timing_of((UINT64_C(1) << 62) + 1));
    admit(RED_STATUS_UNSCHEDULABLE, &scheduler, node, timing_of(3 * MS));
    red_timing floor = timing;
    floor.floor_keep = 2;
    floor.floor_of = 1;
    admit(RED_STATUS_OUT_OF_RANGE, &scheduler, node, floor);
    red_timing newer = timing;
    newer.reserved = 1;
    admit(RED_STATUS_UNKNOWN_FIELD, &scheduler, node, newer);
    red_node elsewhere = node;
    elsewhere.pool = 1;
    admit(RED_STATUS_UNKNOWN_POOL, &scheduler, elsewhere, timing);
    red_node heavy = node;
    heavy.memory_bytes = 1001;
    admit(RED_STATUS_MEMORY, &scheduler, heavy, timing);
    admit(RED_STATUS_UNKNOWN_SENSOR, &scheduler, encoder_of(MS, 0, 0), timing);

    red_dag empty = open_small_dag(&dag_memory);
    uint32_t task = 7;
    CALL(RED_STATUS_EMPTY_GRAPH, red_scheduler_add_task, &scheduler, &empty, &timing, &task);
    CALL(RED_OK, red_dag_close, &empty);
    for (int i = 0; i < 4; i++) admit(RED_OK, &scheduler, node, timing);
    admit(RED_STATUS_TASKS_FULL, &scheduler, node, timing);
    CALL(RED_OK, red_scheduler_close, &scheduler);
}

static void begin(const red_scheduler *scheduler, uint32_t task, struct small_dag_memory *at, red_dag *edit) {
    CALL(RED_OK, red_scheduler_edit, scheduler, task, at, sizeof *at, edit);
}

/* Adds a node to an edit, and tries to commit it; then the node goes again. */
static void commit_with(red_status wanted, red_scheduler *scheduler, red_dag *edit, red_node node) {
    red_certificate proof = RED_CERTIFICATE_INIT;
    const uint32_t number = add(edit, node);
    CALL(wanted, red_scheduler_commit, scheduler, edit, 0, &proof);
    CALL(RED_OK, red_dag_remove_node, edit, number);
}

static void edits(void) {
    red_config config = preset(RED_PRESET_REDRT);
    config.admission = RED_ADMISSION_ENFORCE;
    config.memory_bytes = 1000;
    red_scheduler scheduler = {0};
    CALL(RED_OK, red_scheduler_open_4x16x16, &memory, sizeof memory, &config, &scheduler);
    const uint32_t task = add_simple_task(&scheduler, 50 * MS), unknown = task + 1;
    red_dag edit = {0}, other = {0};
    red_certificate proof = RED_CERTIFICATE_INIT;
    CALL(RED_OK, red_scheduler_certificate, &scheduler, task, &proof);
    EXPECT(proof.response_ns == 4 * MS && proof.limit_ns == 50 * MS);
    CALL(RED_STATUS_UNKNOWN_TASK, red_scheduler_certificate, &scheduler, unknown, &proof);

    CALL(RED_STATUS_UNKNOWN_TASK, red_scheduler_edit, &scheduler, unknown, &edit_memory, sizeof edit_memory, &edit);
    CALL(RED_STATUS_TOO_SHORT, red_scheduler_edit, &scheduler, task, &edit_memory, 16, &edit);
    CALL(RED_STATUS_MISALIGNED, red_scheduler_edit, &scheduler, task, edit_memory.bytes + 1, sizeof edit_memory, &edit);
    CALL(RED_STATUS_OVERLAP, red_scheduler_edit, &scheduler, task, &edit_memory, sizeof edit_memory, (red_dag *)(void *)&edit_memory);
    begin(&scheduler, task, &edit_memory, &edit);
    CALL(RED_STATUS_OVERLAP, red_scheduler_edit, &scheduler, task, &edit_memory, sizeof edit_memory, &other);

    red_node node = node_of(MS);
    node.pool = 1;
    commit_with(RED_STATUS_UNKNOWN_POOL, &scheduler, &edit, node);
    commit_with(RED_STATUS_UNKNOWN_SENSOR, &scheduler, &edit, encoder_of(MS, 0, 0));
    node = node_of(MS);
    node.memory_bytes = 1001;
    commit_with(RED_STATUS_MEMORY, &scheduler, &edit, node);
    commit_with(RED_STATUS_UNSCHEDULABLE, &scheduler, &edit, node_of(60 * MS));
    CALL(RED_OK, red_dag_remove_node, &edit, 0);
    CALL(RED_STATUS_EMPTY_GRAPH, red_scheduler_commit, &scheduler, &edit, 0, &proof);
    CALL(RED_OK, red_dag_close, &edit);

    /* Of two edits the first one that is committed counts. */
    begin(&scheduler, task, &edit_memory, &edit);
    begin(&scheduler, task, &other_memory, &other);
    CALL(RED_OK, red_scheduler_commit, &scheduler, &edit, 0, &proof);
    CALL(RED_STATUS_CONFLICT, red_scheduler_commit, &scheduler, &other, 0, &proof);
    CALL(RED_OK, red_dag_close, &other);
    CALL(RED_OK, red_dag_close, &edit);

    /* A third graph waits until no job has the first. */
    uint32_t job = 0;
    CALL(RED_OK, red_scheduler_release, &scheduler, task, 0, &job);
    begin(&scheduler, task, &edit_memory, &edit);
    CALL(RED_OK, red_scheduler_commit, &scheduler, &edit, 0, &proof);
    CALL(RED_OK, red_dag_close, &edit);
    begin(&scheduler, task, &edit_memory, &edit);
    CALL(RED_STATUS_DRAINING, red_scheduler_commit, &scheduler, &edit, 0, &proof);

    CALL(RED_OK, red_scheduler_remove_task, &scheduler, task, 0);
    CALL(RED_STATUS_UNKNOWN_TASK, red_scheduler_remove_task, &scheduler, task, 0);
    CALL(RED_STATUS_UNKNOWN_TASK, red_scheduler_commit, &scheduler, &edit, 0, &proof);
    CALL(RED_OK, red_dag_close, &edit);
    const red_action action = poll(&scheduler, 0, RED_ACTION_KIND_ENDED);
    EXPECT(action.outcome.shed == RED_SHED_REMOVED && action.outcome.job == job);
    CALL(RED_OK, red_scheduler_close, &scheduler);
}

/* A graph that did not come from an edit is no edit of any task. */
static void not_an_edit(void) {
    red_scheduler scheduler = open_small(&memory, 1);
    add_simple_task(&scheduler, 50 * MS);
    red_dag dag = open_small_dag(&dag_memory);
    add(&dag, node_of(9 * MS));
    red_certificate proof = RED_CERTIFICATE_INIT;
    CALL(RED_STATUS_CONFLICT, red_scheduler_commit, &scheduler, &dag, 0, &proof);
    CALL(RED_OK, red_dag_close, &dag);
    CALL(RED_OK, red_scheduler_close, &scheduler);
}

void test_tasks(void) {
    pools_and_sensors();
    admission();
    edits();
    not_an_edit();
}
