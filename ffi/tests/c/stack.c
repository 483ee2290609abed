/* How much stack the calls of each class take at most: what docs/c-abi.md promises. Measured on a thread whose stack was
 * painted before; with `planted` one that takes more. */
#define _DEFAULT_SOURCE
#include "../check.h"
#include <pthread.h>
#include <red.h>
#include <stdlib.h>
#include <string.h>

#define MS UINT64_C(1000000)
#define STACK (1 << 20)
#define PAINT 0xA5

struct class {
    const char *name;
    red_status (*open_dag)(void *memory, size_t bytes, red_dag *dag);
    red_status (*open_scheduler)(void *memory, size_t bytes, const red_config *config, red_scheduler *scheduler);
    size_t dag_bytes, scheduler_bytes, stack_bytes;
    void *memory[3];
};

static void ok(const char *what, red_status status) {
    if (status != RED_OK) check_failed(what, (int)status, red_status_text(status));
}
#define OK(function, ...) ok(#function, function(__VA_ARGS__))

static red_node node_of(uint32_t role, uint64_t wcet_ns) {
    red_node node = RED_NODE_INIT;
    node.role = role;
    node.wcet_ns = wcet_ns;
    return node;
}

static void graph(const struct class *class, red_dag *dag) {
    OK(class->open_dag, class->memory[0], class->dag_bytes, dag);
    const red_node camera = node_of(RED_ROLE_ORDINARY, MS), encoder = node_of(RED_ROLE_SHARED_ENCODER, MS);
    const red_node decoders[] = {node_of(RED_ROLE_DECODER, MS), node_of(RED_ROLE_DECODER, MS)};
    uint32_t number = 0, stage = 0;
    OK(red_dag_add_node, dag, &camera, &number);
    OK(red_dag_add_node, dag, &camera, &stage);
    OK(red_dag_add_edge, dag, number, stage);
    OK(red_dag_refine, dag, stage, &encoder, decoders, 2, &stage);
    static red_placed_node nodes[256];
    static red_level levels[256];
    red_dag_summary summary = RED_DAG_SUMMARY_INIT;
    red_certificate certificate = RED_CERTIFICATE_INIT;
    size_t count = 0;
    for (uint32_t rule = 0; rule < 6; rule++) {
        OK(red_dag_place, dag, rule, 50 * MS, NULL, 0, nodes, 256, &count);
        (void)red_dag_share(dag, rule, 50 * MS, NULL, 0, levels, 256, &count);
    }
    OK(red_dag_summarize, dag, &summary);
    OK(red_dag_prove, dag, 50 * MS, NULL, NULL, 0, &certificate);
    OK(red_dag_node, dag, stage, &(red_node)RED_NODE_INIT);
    uint32_t after[256];
    OK(red_dag_successors, dag, stage, after, 256, &count);
    OK(red_dag_add_node, dag, &camera, &number);
    OK(red_dag_add_edge, dag, stage, number);
    OK(red_dag_remove_edge, dag, stage, number);
    OK(red_dag_remove_node, dag, number);
}

/* Until there is nothing to do; what ran last. */
static uint64_t drive(red_scheduler *scheduler, uint64_t now_ns) {
    red_action action = {0};
    uint64_t last = 0;
    OK(red_scheduler_poll, scheduler, now_ns, &action);
    while (action.kind != RED_ACTION_KIND_NOTHING) {
        if (action.kind == RED_ACTION_KIND_DISPATCH) {
            last = action.unit;
            red_unit unit = RED_UNIT_INIT;
            red_member members[64];
            size_t count = 0;
            OK(red_scheduler_unit, scheduler, last, &unit);
            OK(red_scheduler_members, scheduler, last, members, 64, &count);
            now_ns += MS;
            OK(red_scheduler_complete_and_poll, scheduler, last, now_ns, &action);
        } else {
            OK(red_scheduler_poll, scheduler, now_ns, &action);
        }
    }
    return last;
}

/* The same, with units that wait on their lanes. */
static void drive_ahead(red_scheduler *scheduler, uint64_t now_ns) {
    uint64_t units[64], before[32];
    size_t given, count = 0;
    do {
        red_action action = {0};
        given = 0;
        OK(red_scheduler_poll, scheduler, now_ns, &action);
        while (action.kind != RED_ACTION_KIND_NOTHING) {
            if (action.kind == RED_ACTION_KIND_AHEAD) OK(red_scheduler_waits_for, scheduler, action.unit, before, 32, &count);
            if (action.kind != RED_ACTION_KIND_ENDED) units[given++] = action.unit;
            OK(red_scheduler_poll, scheduler, now_ns, &action);
        }
        now_ns += MS;
        for (size_t i = 0; i < given; i++) OK(red_scheduler_complete, scheduler, units[i], now_ns);
    } while (given > 0);
}

static void look(const red_scheduler *scheduler, uint32_t task, uint64_t index) {
    red_config config = RED_CONFIG_INIT;
    red_figures figures = RED_FIGURES_INIT;
    red_certificate certificate = RED_CERTIFICATE_INIT;
    red_executions executions = RED_EXECUTIONS_INIT;
    uint64_t at_ns = 0, used_bytes = 0;
    uint32_t job = 0;
    OK(red_scheduler_config, scheduler, &config);
    OK(red_scheduler_figures, scheduler, &figures);
    OK(red_scheduler_certificate, scheduler, task, &certificate);
    OK(red_scheduler_executions, scheduler, task, 0, &executions);
    OK(red_scheduler_poll_at, scheduler, &at_ns);
    OK(red_scheduler_memory_used, scheduler, 0, &used_bytes);
    OK(red_scheduler_job, scheduler, task, index, &job);
}

/* A job whose first unit completes and whose second one fails. It is the `index`-th of its task. */
static void fail(red_scheduler *scheduler, uint32_t task, uint64_t index, uint64_t now_ns) {
    red_action action = {0};
    red_outcome outcome;
    uint32_t job = 0, taken = 0;
    OK(red_scheduler_release, scheduler, task, now_ns, &job);
    look(scheduler, task, index);
    OK(red_scheduler_poll_on, scheduler, 0, now_ns, &action);
    OK(red_scheduler_complete, scheduler, action.unit, now_ns);
    OK(red_scheduler_poll, scheduler, now_ns, &action);
    OK(red_scheduler_fail, scheduler, action.unit, now_ns);
    red_warning warning;
    OK(red_scheduler_take_warning, scheduler, &warning, &taken);
    OK(red_scheduler_take_outcome, scheduler, &outcome, &taken);
    CHECK(taken == 1);
}

static void run(const struct class *class) {
    red_dag dag = {0}, edit = {0};
    graph(class, &dag);
    red_config config = RED_CONFIG_INIT;
    OK(red_config_preset, RED_PRESET_REDRT, &config);
    red_scheduler scheduler = {0};
    OK(class->open_scheduler, class->memory[1], class->scheduler_bytes, &config, &scheduler);
    uint32_t pool = 0, sensor = 0, task = 0, job = 0, node = 0;
    OK(red_scheduler_add_pool, &scheduler, 1, RED_NONE_64, &pool);
    OK(red_scheduler_add_sensor, &scheduler, 10 * MS, &sensor);
    red_timing timing = RED_TIMING_INIT;
    timing.deadline_ns = 50 * MS;
    OK(red_scheduler_add_task, &scheduler, &dag, &timing, &task);
    OK(red_dag_close, &dag);
    for (uint64_t frame = 0; frame < 4; frame++) {
        const uint64_t now_ns = 100 * MS * frame;
        for (int jobs = 0; jobs < 2; jobs++) OK(red_scheduler_release, &scheduler, task, now_ns, &job);
        drive(&scheduler, now_ns);
        OK(red_scheduler_edit, &scheduler, task, class->memory[2], class->dag_bytes, &edit);
        const red_node obstacle = node_of(RED_ROLE_ORDINARY, MS);
        OK(red_dag_add_node, &edit, &obstacle, &node);
        red_certificate certificate = RED_CERTIFICATE_INIT;
        OK(red_scheduler_commit, &scheduler, &edit, now_ns + 50 * MS, &certificate);
        OK(red_dag_close, &edit);
    }
    fail(&scheduler, task, 8, 400 * MS);
    red_event events[16];
    size_t count = 0;
    OK(red_scheduler_take_events, &scheduler, events, 16, &count);
    OK(red_scheduler_dispatch_ahead, &scheduler, 0);
    for (int jobs = 0; jobs < 2; jobs++) OK(red_scheduler_release, &scheduler, task, 410 * MS, &job);
    drive_ahead(&scheduler, 410 * MS);
    OK(red_scheduler_retire_lane, &scheduler, 0);
    OK(red_scheduler_restore_lane, &scheduler, 0);
    /* Late from the start: given up. */
    OK(red_scheduler_release_at, &scheduler, task, 400 * MS, RED_NONE_64, 900 * MS, &job);
    drive(&scheduler, 900 * MS);
    OK(red_scheduler_release, &scheduler, task, 950 * MS, &job);
    OK(red_scheduler_lose_pool, &scheduler, 0, 950 * MS);
    drive(&scheduler, 950 * MS);
    OK(red_scheduler_remove_task, &scheduler, task, 1000 * MS);
    OK(red_scheduler_close, &scheduler);
}

static void *waste(void *argument) {
    volatile unsigned char bytes[STACK / 2];
    bytes[0] = bytes[sizeof bytes - 1] = 1;
    return argument;
}

static void *on_thread(void *argument) {
    run(argument);
    return NULL;
}

static void *nothing(void *argument) {
    return argument;
}

/* What a thread leaves of its stack. */
static size_t touched(void *(*begin)(void *), void *argument) {
    unsigned char *stack = aligned_alloc(4096, STACK);
    memset(stack, PAINT, STACK);
    pthread_attr_t attributes;
    pthread_t thread;
    CHECK(pthread_attr_init(&attributes) == 0);
    CHECK(pthread_attr_setstack(&attributes, stack, STACK) == 0);
    CHECK(pthread_create(&thread, &attributes, begin, argument) == 0);
    CHECK(pthread_join(thread, NULL) == 0);
    CHECK(pthread_attr_destroy(&attributes) == 0);
    size_t untouched = 0;
    while (untouched < STACK && stack[untouched] == PAINT) untouched++;
    free(stack);
    return STACK - untouched;
}

static void measure(struct class *class, void *(*begin)(void *)) {
    const size_t bytes[] = {class->dag_bytes, class->scheduler_bytes, class->dag_bytes};
    for (int i = 0; i < 3; i++) class->memory[i] = aligned_alloc(RED_ALIGN, bytes[i]);
    /* A thread takes some for itself. */
    const size_t taken = touched(begin, class) - touched(nothing, NULL);
    printf("%s: %zu bytes of stack, at most %zu\n", class->name, taken, class->stack_bytes);
    if (taken > class->stack_bytes) check_failed(class->name, 0, "more stack than is promised");
    for (int i = 0; i < 3; i++) free(class->memory[i]);
}

int main(int count, char **words) {
    struct class classes[] = {
        {"4x16x16", red_dag_open_4x16x16, red_scheduler_open_4x16x16, RED_DAG_4X16X16_BYTES, RED_SCHEDULER_4X16X16_BYTES,
         8 << 10, {0}},
        {"8x64x32", red_dag_open_8x64x32, red_scheduler_open_8x64x32, RED_DAG_8X64X32_BYTES, RED_SCHEDULER_8X64X32_BYTES,
         24 << 10, {0}},
        {"16x256x64", red_dag_open_16x256x64, red_scheduler_open_16x256x64, RED_DAG_16X256X64_BYTES,
         RED_SCHEDULER_16X256X64_BYTES, 96 << 10, {0}},
    };
    const int is_planted = count > 1 && strcmp(words[1], "planted") == 0;
    for (size_t i = 0; i < sizeof classes / sizeof classes[0]; i++) measure(&classes[i], is_planted ? waste : on_thread);
    return check_end("stack");
}
