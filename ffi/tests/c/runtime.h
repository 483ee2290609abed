/* What the tests of the runtime share. */
#ifndef RUNTIME_H
#define RUNTIME_H

#include "calls.h"

struct dag_memory {
    _Alignas(RED_ALIGN) unsigned char bytes[RED_DAG_16X256X64_BYTES];
};

/* Opened, best effort, with so many lanes. */
red_runtime open_runtime(uint32_t lanes);
red_runtime_config config_of(uint32_t mode);
red_dag open_dag(struct dag_memory *memory);
/* A body that does nothing, for a node. */
int nothing(void *user, const red_context *context);
red_callback callback_of(uint32_t node, red_body body, void *user);
/* A task of one node that costs 1 ms and is due after a minute. */
uint32_t add_task_of(red_runtime *runtime, red_body body, void *user);
/* Sleeps until it is not 0 any more. */
void await(const int *flag);
/* Makes a check in a child of fork, whose calls are written down too. */
void in_child(void (*check)(void));

void test_set_up(void);
void test_runtime_tasks(void);
void test_run(void);
void test_ends(void);
void test_memory(void);
void test_runtime_pointers(void);

#endif
