/* What is written down, and what tests share. */
#include "calls.h"
#include "../check.h"

#include <string.h>

struct pair {
    const char *function;
    red_status status;
};
static struct pair seen[1024];
static size_t seen_len;

void called(const char *file, int line, const char *function, red_status wanted, red_status got) {
    if (got != wanted) {
        check_failures++;
        fprintf(stderr, "%s:%d: %s: %d (%s), expected %d\n", file, line, function, (int)got, red_status_text(got),
                (int)wanted);
    }
    for (size_t i = 0; i < seen_len; i++) {
        if (seen[i].status == got && strcmp(seen[i].function, function) == 0) return;
    }
    if (seen_len < sizeof seen / sizeof seen[0]) seen[seen_len++] = (struct pair){function, got};
}

void expected(const char *file, int line, const char *what, bool holds) {
    if (!holds) check_failed(file, line, what);
}

int report(void) {
    for (size_t i = 0; i < seen_len; i++) printf("call %s %d\n", seen[i].function, (int)seen[i].status);
    return check_end("C");
}

red_node node_of(uint64_t wcet_ns) {
    red_node node = RED_NODE_INIT;
    node.wcet_ns = wcet_ns;
    return node;
}

red_node encoder_of(uint64_t wcet_ns, uint32_t frame, uint32_t sensor) {
    red_node node = node_of(wcet_ns);
    node.role = RED_ROLE_SHARED_ENCODER;
    node.weights = 1;
    node.frame = frame;
    node.sensor = sensor;
    return node;
}

red_node decoder_of(uint64_t wcet_ns) {
    red_node node = node_of(wcet_ns);
    node.role = RED_ROLE_DECODER;
    return node;
}

red_timing timing_of(uint64_t deadline_ns) {
    red_timing timing = RED_TIMING_INIT;
    timing.deadline_ns = deadline_ns;
    return timing;
}

red_config preset(uint32_t which) {
    red_config config = RED_CONFIG_INIT;
    CALL(RED_OK, red_config_preset, which, &config);
    return config;
}

uint32_t add(red_dag *dag, red_node node) {
    uint32_t number = RED_NONE;
    CALL(RED_OK, red_dag_add_node, dag, &node, &number);
    return number;
}

red_scheduler open_small(struct small_memory *memory, uint32_t lanes) {
    red_scheduler scheduler = {0};
    red_config config = preset(RED_PRESET_REDRT);
    config.lanes = lanes;
    CALL(RED_OK, red_scheduler_open_4x16x16, memory->bytes, sizeof memory->bytes, &config, &scheduler);
    return scheduler;
}

red_dag open_small_dag(struct small_dag_memory *memory) {
    red_dag dag = {0};
    CALL(RED_OK, red_dag_open_4x16x16, memory->bytes, sizeof memory->bytes, &dag);
    return dag;
}

uint32_t add_simple_task(red_scheduler *scheduler, uint64_t deadline_ns) {
    struct small_dag_memory memory;
    red_dag dag = open_small_dag(&memory);
    add(&dag, node_of(4 * MS));
    const red_timing timing = timing_of(deadline_ns);
    uint32_t task = RED_NONE;
    CALL(RED_OK, red_scheduler_add_task, scheduler, &dag, &timing, &task);
    CALL(RED_OK, red_dag_close, &dag);
    return task;
}

red_action poll(red_scheduler *scheduler, uint64_t now_ns, uint32_t kind) {
    red_action action;
    CALL(RED_OK, red_scheduler_poll, scheduler, now_ns, &action);
    EXPECT(action.kind == kind);
    return action;
}
