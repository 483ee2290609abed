/* Calls that are written down: which function, and how it ended. At the end of the program they are printed, and held
 * against red.h by `coverage`. */
#ifndef CALLS_H
#define CALLS_H

#include <red.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define MS UINT64_C(1000000)
#define SECOND (1000 * MS)

/* A call that has to end so. */
#define CALL(expected, function, ...) called(__FILE__, __LINE__, #function, expected, function(__VA_ARGS__))
/* A call through a pointer, of the function with this name. */
#define CALL_BY(name, expected, function, ...) called(__FILE__, __LINE__, name, expected, function(__VA_ARGS__))
/* A function without a status was called. */
#define CALLED(function) called(__FILE__, __LINE__, #function, RED_OK, RED_OK)
#define EXPECT(condition) expected(__FILE__, __LINE__, #condition, condition)

/* Both wrong pointers in the place of one. `X` is where it goes. */
#define WRONG(type, function, ...) \
    do { \
        _Alignas(8) static unsigned char odd[512]; \
        type *X = NULL; \
        CALL(RED_STATUS_NULL_POINTER, function, __VA_ARGS__); \
        X = (type *)(void *)(odd + 1); \
        CALL(RED_STATUS_MISALIGNED, function, __VA_ARGS__); \
    } while (0)

void called(const char *file, int line, const char *function, red_status expected, red_status got);
void expected(const char *file, int line, const char *what, bool holds);
/* Prints every pair of function and status; what main returns. */
int report(void);

/* Memory of each class. */
struct small_memory {
    _Alignas(RED_ALIGN) unsigned char bytes[RED_SCHEDULER_4X16X16_BYTES];
};
struct small_dag_memory {
    _Alignas(RED_ALIGN) unsigned char bytes[RED_DAG_4X16X16_BYTES];
};

/* A node of this cost, an encoder of weights 1 that reads `frame`, a decoder. */
red_node node_of(uint64_t wcet_ns);
red_node encoder_of(uint64_t wcet_ns, uint32_t frame, uint32_t sensor);
red_node decoder_of(uint64_t wcet_ns);
red_timing timing_of(uint64_t deadline_ns);
red_config preset(uint32_t which);
/* Adds it; its number. */
uint32_t add(red_dag *dag, red_node node);
/* Opened in `memory` with REDRT and so many lanes. */
red_scheduler open_small(struct small_memory *memory, uint32_t lanes);
/* Opened in `memory`. */
red_dag open_small_dag(struct small_dag_memory *memory);
/* A task of one node that takes 4 ms and is due after `deadline_ns`. */
uint32_t add_simple_task(red_scheduler *scheduler, uint64_t deadline_ns);
/* What is polled at `now_ns`: has to be of this kind. */
red_action poll(red_scheduler *scheduler, uint64_t now_ns, uint32_t kind);

void test_config(void);
void test_graph(void);
void test_handles(void);
void test_pointers(void);
void test_tasks(void);
void test_loop(void);

#endif
