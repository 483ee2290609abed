/* What the robot sees: a camera, a network with a shared encoder, and control; another network that reads the same frames. */
#ifndef SCENE_H
#define SCENE_H

#include <red.h>

#define MS UINT64_C(1000000)
/* A frame every so often, and how long its jobs may take. */
#define PERIOD_MS 100
#define DEADLINE_MS 120
/* Lanes: two streams of an accelerator, and the processor. */
#define LANES 3
/* Nodes of both tasks; the second encoder is not run. */
#define NODES 8

/* How long a unit really takes, in ms: less than its WCET. */
uint32_t takes_ms(uint32_t task, uint32_t node);
/* Adds pools, sensor and tasks. With another frame for the second task nothing can be shared. */
red_status add_scene(red_scheduler *scheduler, uint32_t other_frame, uint32_t tasks[2]);

#endif
