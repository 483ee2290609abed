/* Graphs, costs, pools. */
#include "scene.h"

#include <stddef.h>

enum { ACCELERATOR, PROCESSOR };

/* A node: what it may take, what it takes, where it runs, what it is. */
struct step {
    uint8_t wcet_ms, takes_ms, pool, role;
};

static const struct step cruise[] = {
    {2, 1, PROCESSOR, RED_ROLE_ORDINARY},         /* camera */
    {12, 9, ACCELERATOR, RED_ROLE_SHARED_ENCODER}, /* encoder */
    {4, 3, ACCELERATOR, RED_ROLE_DECODER},        /* lane */
    {6, 5, ACCELERATOR, RED_ROLE_DECODER},        /* segment */
    {9, 7, ACCELERATOR, RED_ROLE_DECODER},        /* objects */
    {3, 2, PROCESSOR, RED_ROLE_ORDINARY},         /* control */
};
static const struct step watch[] = {
    {12, 9, ACCELERATOR, RED_ROLE_SHARED_ENCODER}, /* encoder */
    {7, 5, ACCELERATOR, RED_ROLE_DECODER},        /* people */
};
/* Edges of both, as pairs of nodes. */
static const uint8_t cruise_edges[][2] = {{0, 1}, {1, 2}, {1, 3}, {1, 4}, {2, 5}, {3, 5}, {4, 5}};
static const uint8_t watch_edges[][2] = {{0, 1}};

#define LENGTH(array) (sizeof(array) / sizeof(array)[0])

static _Alignas(RED_ALIGN) unsigned char dag_memory[RED_DAG_4X16X16_BYTES];

uint32_t takes_ms(uint32_t task, uint32_t node) {
    return task == 0 ? cruise[node].takes_ms : watch[node].takes_ms;
}

static red_status add_task(red_scheduler *scheduler, const struct step *steps, size_t nodes, const uint8_t (*edges)[2],
                           size_t edge_count, uint32_t sensor, uint32_t frame, uint32_t *task) {
    red_dag dag = {0};
    red_status status = red_dag_open_4x16x16(dag_memory, sizeof dag_memory, &dag);
    for (size_t i = 0; i < nodes && status == RED_OK; i++) {
        red_node node = RED_NODE_INIT;
        node.wcet_ns = steps[i].wcet_ms * MS;
        node.pool = steps[i].pool;
        node.role = steps[i].role;
        if (node.role == RED_ROLE_SHARED_ENCODER) {
            node.frame = frame;
            node.sensor = sensor;
        }
        uint32_t number = 0;
        status = red_dag_add_node(&dag, &node, &number);
    }
    for (size_t i = 0; i < edge_count && status == RED_OK; i++) status = red_dag_add_edge(&dag, edges[i][0], edges[i][1]);
    if (status == RED_OK) {
        red_timing timing = RED_TIMING_INIT;
        timing.deadline_ns = DEADLINE_MS * MS;
        timing.period_ns = PERIOD_MS * MS;
        status = red_scheduler_add_task(scheduler, &dag, &timing, task);
    }
    /* The graph was copied: its memory is free for the next one. */
    const red_status closed = red_dag_close(&dag);
    return status == RED_OK ? closed : status;
}

red_status add_scene(red_scheduler *scheduler, uint32_t other_frame, uint32_t tasks[2]) {
    uint32_t pool = 0, front = 0;
    red_status status = red_scheduler_add_pool(scheduler, 1, RED_NONE_64, &pool);
    if (status == RED_OK) status = red_scheduler_add_sensor(scheduler, PERIOD_MS * MS, &front);
    if (status == RED_OK)
        status = add_task(scheduler, cruise, LENGTH(cruise), cruise_edges, LENGTH(cruise_edges), front, 0, &tasks[0]);
    if (status == RED_OK)
        status = add_task(scheduler, watch, LENGTH(watch), watch_edges, LENGTH(watch_edges), front, other_frame, &tasks[1]);
    return status;
}
