/* RED: real-time scheduling of DAGs of neural networks. The C ABI; made by `cargo xtask header`.
 *
 * Rules of every function (docs/c-abi.md has them in full):
 * - It returns a red_status. Outputs come last, are checked before anything happens, and are written on RED_OK only.
 * - No pointer may be NULL, but that of an array of length 0. A wrong one is a status where it can be seen.
 * - `const` in front of the object means: may be called by several threads at once, while nobody changes the object.
 * - Times are nanoseconds of one clock that the caller chooses; what the runtime takes and gives is CLOCK_MONOTONIC.
 * - "Real time: yes" means: no allocation, no system call, no waiting, a bound on the time.
 */


#ifndef RED_H
#define RED_H

#include <stddef.h>
#include <stdint.h>
#define RED_OK RED_STATUS_OK


/**
 * Alignment of all memory that is lent to this library.
 */
#define RED_ALIGN 64

/**
 * Bytes of a scheduler of 4 tasks of 16 nodes and 16 jobs in flight; 4 lanes in 2 pools, 64 events.
 */
#define RED_SCHEDULER_4X16X16_BYTES 20480

/**
 * Bytes of a graph for that scheduler.
 */
#define RED_DAG_4X16X16_BYTES 2048

/**
 * Bytes of a scheduler of 8 tasks of 64 nodes and 32 jobs in flight; 8 lanes in 4 pools, 256 events.
 */
#define RED_SCHEDULER_8X64X32_BYTES 131072

/**
 * Bytes of a graph for that scheduler.
 */
#define RED_DAG_8X64X32_BYTES 8192

/**
 * Bytes of a scheduler of 16 tasks of 256 nodes and 64 jobs in flight; 32 lanes in 32 pools, 1,024 events.
 */
#define RED_SCHEDULER_16X256X64_BYTES 1048576

/**
 * Bytes of a graph for that scheduler.
 */
#define RED_DAG_16X256X64_BYTES 32768

/**
 * A body did its work.
 */
#define RED_BODY_DONE 0

/**
 * A body failed: its job is given up with the reason RED_SHED_FAULT. So is it for every number but RED_BODY_DONE.
 */
#define RED_BODY_FAILED 1

/**
 * A C++ exception came out of a body. The trampoline of red.hpp returns it; it is counted apart.
 */
#define RED_BODY_THREW 2

/**
 * Version of the ABI that this header is of. A library of another one refuses every struct.
 */
#define RED_ABI_VERSION 1

/**
 * In the place of a number: none.
 */
#define RED_NONE UINT32_MAX

/**
 * In the place of a time, a budget or a capture: none; nothing to wait for; unlimited; the job's own.
 */
#define RED_NONE_64 UINT64_MAX

/**
 * How a call ended. Nothing has changed unless it is RED_STATUS_OK, or the function says otherwise; but a time that a
 * scheduler was told counts all the same, and it never goes back.
 */
enum red_status
#ifdef __cplusplus
  : int32_t
#endif // __cplusplus
 {
  /**
   * Done.
   */
  RED_STATUS_OK = 0,
  /**
   * A pointer is NULL: give one.
   */
  RED_STATUS_NULL_POINTER = 1,
  /**
   * An address is not aligned for its type: use alignas, or the alignment that the header says.
   */
  RED_STATUS_MISALIGNED = 2,
  /**
   * Memory or an array is too short: the header says the size, or the count that was written.
   */
  RED_STATUS_TOO_SHORT = 3,
  /**
   * Struct_size is not that of any version: begin with the INIT macro of the struct.
   */
  RED_STATUS_STRUCT_SIZE = 4,
  /**
   * Abi_version is another one: build against the header of the library that is loaded.
   */
  RED_STATUS_VERSION = 5,
  /**
   * A field that this library does not know, or a reserved one, is not zero: the header is newer than the library.
   */
  RED_STATUS_UNKNOWN_FIELD = 6,
  /**
   * The handle was closed, or never opened.
   */
  RED_STATUS_CLOSED = 7,
  /**
   * The handle is of another copy of this library, or made up.
   */
  RED_STATUS_FOREIGN = 8,
  /**
   * The handle is of something else: a graph is no scheduler.
   */
  RED_STATUS_OTHER_KIND = 9,
  /**
   * Graph and scheduler are of different capacity classes.
   */
  RED_STATUS_OTHER_CLASS = 10,
  /**
   * It is in use: another call goes on, or a body asked for what waits for a lane; call again later, from elsewhere.
   */
  RED_STATUS_BUSY = 11,
  /**
   * The memory overlaps with that of something open, or has the place of the answer in it.
   */
  RED_STATUS_OVERLAP = 12,
  /**
   * A number is outside of its enumeration or range, which the header says beside its field.
   */
  RED_STATUS_OUT_OF_RANGE = 13,
  /**
   * An array is longer than anything that could be meant.
   */
  RED_STATUS_TOO_LONG = 14,
  /**
   * As many handles are open as there may be: close one.
   */
  RED_STATUS_TOO_MANY_OPEN = 15,
  /**
   * A bug of this library: report it; what was called is closed.
   */
  RED_STATUS_INTERNAL = 16,
  /**
   * The capacity class has no room for another node.
   */
  RED_STATUS_NODES_FULL = 20,
  /**
   * The sum of all costs would not fit 64 bits.
   */
  RED_STATUS_WORK_OVERFLOW = 21,
  /**
   * The edge would close a cycle.
   */
  RED_STATUS_CYCLE = 22,
  /**
   * The edge is there already.
   */
  RED_STATUS_DUPLICATE_EDGE = 23,
  /**
   * A decoder reads the result of one encoder: make a node that fuses several an ordinary one.
   */
  RED_STATUS_SECOND_ENCODER = 24,
  /**
   * No such node in this graph, or it was named twice.
   */
  RED_STATUS_UNKNOWN_NODE = 25,
  /**
   * No such edge in this graph.
   */
  RED_STATUS_UNKNOWN_EDGE = 26,
  /**
   * A stage needs at least one decoder.
   */
  RED_STATUS_NO_DECODER = 27,
  /**
   * The capacity class has no room for another task.
   */
  RED_STATUS_TASKS_FULL = 40,
  /**
   * The graph has no node.
   */
  RED_STATUS_EMPTY_GRAPH = 41,
  /**
   * A deadline is 1 ns to 2^62 ns.
   */
  RED_STATUS_DEADLINE = 42,
  /**
   * No such pool: add it first.
   */
  RED_STATUS_UNKNOWN_POOL = 43,
  /**
   * A node, or an encoder and one of its decoders together, needs more memory than its pool has.
   */
  RED_STATUS_MEMORY = 44,
  /**
   * The certificate does not fit, and admission is enforced.
   */
  RED_STATUS_UNSCHEDULABLE = 45,
  /**
   * No such task, or it was removed.
   */
  RED_STATUS_UNKNOWN_TASK = 46,
  /**
   * Another commit came between, or the graph is no edit of this task: begin the edit again.
   */
  RED_STATUS_CONFLICT = 47,
  /**
   * The graph before the current one still has jobs: commit again when they have ended.
   */
  RED_STATUS_DRAINING = 48,
  /**
   * A pool needs at least one lane.
   */
  RED_STATUS_NO_LANE = 49,
  /**
   * The capacity class has no room for another pool, or for so many lanes.
   */
  RED_STATUS_POOLS_FULL = 50,
  /**
   * A period is at least 1 ns.
   */
  RED_STATUS_ZERO_PERIOD = 51,
  /**
   * The capacity class has no room for another sensor.
   */
  RED_STATUS_SENSORS_FULL = 52,
  /**
   * No such sensor: add it first.
   */
  RED_STATUS_UNKNOWN_SENSOR = 53,
  /**
   * No such lane, or it is not as this call needs it.
   */
  RED_STATUS_UNKNOWN_LANE = 54,
  /**
   * The configuration preempts, or opens graphs level by level: nothing can be dispatched ahead.
   */
  RED_STATUS_NOT_AHEAD = 55,
  /**
   * As many jobs are in flight as the capacity class has room for: count it as shed.
   */
  RED_STATUS_JOBS_FULL = 60,
  /**
   * A time is too long, or a release or its deadline lies beyond 2^63 ns.
   */
  RED_STATUS_TIME_OVERFLOW = 61,
  /**
   * The unit was reported before.
   */
  RED_STATUS_STALE = 62,
  /**
   * No such unit was ever dispatched.
   */
  RED_STATUS_NOT_RUNNING = 63,
  /**
   * The unit's jobs had been given up meanwhile; it is counted, and its lane is free.
   */
  RED_STATUS_LATE = 64,
  /**
   * No such job in flight.
   */
  RED_STATUS_UNKNOWN_JOB = 65,
  /**
   * A real-time right is missing: red_runtime_message says which, and how to get it.
   */
  RED_STATUS_NOT_PERMITTED = 80,
  /**
   * The lanes do not get a CPU each: red_runtime_message says why, and what to do.
   */
  RED_STATUS_CPUS = 81,
  /**
   * The system refused something: red_runtime_message says what, and what to do.
   */
  RED_STATUS_SYSTEM = 82,
  /**
   * A lane cannot interrupt a body: set preempt to 0.
   */
  RED_STATUS_PREEMPTS = 83,
  /**
   * A node has no body: give one for each.
   */
  RED_STATUS_NO_BODY = 84,
  /**
   * A node that was there before keeps its body: give bodies for new nodes only.
   */
  RED_STATUS_HAS_BODY = 85,
  /**
   * The runtime was started: this has to come before.
   */
  RED_STATUS_STARTED = 86,
  /**
   * The runtime was not started, or there is no log.
   */
  RED_STATUS_IDLE = 87,
  /**
   * No lane came to the releases before: release less often.
   */
  RED_STATUS_MAILBOX_FULL = 88,
  /**
   * The runtime was stopped, or its time is over.
   */
  RED_STATUS_OVER = 89,
  /**
   * The time has passed, and the runtime goes on.
   */
  RED_STATUS_TIMEOUT = 90,
  /**
   * A child of fork has no lanes: open a runtime of its own.
   */
  RED_STATUS_FORKED = 91,
  /**
   * A text is empty, not UTF-8, or not ended within 4,096 bytes.
   */
  RED_STATUS_TEXT = 92,
  /**
   * There is a log, or something was set up already: begin it before.
   */
  RED_STATUS_LOG_LATE = 93,
  /**
   * The log cannot be written there: errno says why.
   */
  RED_STATUS_LOG_FILE = 94,
  /**
   * The process has no memory left: nothing was done, free some and try again.
   */
  RED_STATUS_NO_MEMORY = 95,
  /**
   * There is no CUDA driver, or no device that works: red_runtime_message says what is missing.
   */
  RED_STATUS_CUDA = 96,
};
#ifndef __cplusplus
typedef int32_t red_status;
#endif // __cplusplus

/**
 * The named configurations.
 */
enum red_preset
#ifdef __cplusplus
  : uint32_t
#endif // __cplusplus
 {
  /**
   * The paper's baseline: unrefined graphs, one deadline per job, and nothing else.
   */
  RED_PRESET_EDF = 0,
  /**
   * The paper's RED-FG: refined, level shares, level barrier.
   */
  RED_PRESET_RED_FG = 1,
  /**
   * The paper's RED-IDA: RED-FG with re-assignment at each dispatch.
   */
  RED_PRESET_RED_IDA = 2,
  /**
   * The paper's RED: RED-IDA with merging, on-demand synchronisation and ProactiveDrop.
   */
  RED_PRESET_RED = 3,
  /**
   * Ours, and the default: latest-start keys, precedence gating, merging, frame cache, hopeless-first shedding.
   */
  RED_PRESET_REDRT = 4,
  /**
   * Ours, with lanes that wait for what is soon ready where nothing is preempted.
   */
  RED_PRESET_REDRT_LOOKAHEAD = 5,
};
#ifndef __cplusplus
typedef uint32_t red_preset;
#endif // __cplusplus

/**
 * How a node's sub-deadline follows from the end-to-end deadline D.
 */
enum red_rule
#ifdef __cplusplus
  : uint32_t
#endif // __cplusplus
 {
  /**
   * D for every node: job-level EDF.
   */
  RED_RULE_END_TO_END = 0,
  /**
   * Level shares in proportion to the level's cost (paper Def. 4).
   */
  RED_RULE_LEVEL_SUM = 1,
  /**
   * Level shares that cover Graham's bound of each level first.
   */
  RED_RULE_LEVEL_GRAHAM = 2,
  /**
   * D * head / (head + tail), for progress reports.
   */
  RED_RULE_PATH_PROPORTIONAL = 3,
  /**
   * D - tail.
   */
  RED_RULE_LATEST_FINISH = 4,
  /**
   * D - tail, dispatched by the latest start that can still meet D.
   */
  RED_RULE_LATEST_START = 5,
};
#ifndef __cplusplus
typedef uint32_t red_rule;
#endif // __cplusplus

/**
 * What must be done before a node may start.
 */
enum red_gate
#ifdef __cplusplus
  : uint32_t
#endif // __cplusplus
 {
  /**
   * Its predecessors.
   */
  RED_GATE_PRECEDENCE = 0,
  /**
   * Every node of a lower height, as the paper's level barrier has it.
   */
  RED_GATE_LEVEL = 1,
  /**
   * Its predecessors, and a more pressing node that is ready so soon that it would be late behind this one.
   */
  RED_GATE_LOOKAHEAD = 2,
};
#ifndef __cplusplus
typedef uint32_t red_gate;
#endif // __cplusplus

/**
 * When sub-deadlines of jobs in flight are computed again.
 */
enum red_reassign
#ifdef __cplusplus
  : uint32_t
#endif // __cplusplus
 {
  /**
   * Only when the graph changes.
   */
  RED_REASSIGN_NEVER = 0,
  /**
   * Level rules: of every job at each dispatch (paper section 4.3).
   */
  RED_REASSIGN_ON_DISPATCH = 1,
  /**
   * Level rules: of a job when one of its nodes ended.
   */
  RED_REASSIGN_ON_CHANGE = 2,
};
#ifndef __cplusplus
typedef uint32_t red_reassign;
#endif // __cplusplus

/**
 * Which jobs are given up.
 */
enum red_shedding
#ifdef __cplusplus
  : uint32_t
#endif // __cplusplus
 {
  /**
   * None.
   */
  RED_SHEDDING_NEVER = 0,
  /**
   * The paper's ProactiveDrop: lowest urgency first, while the overload lasts.
   */
  RED_SHEDDING_LOWEST_URGENCY = 1,
  /**
   * Jobs that no schedule can end in time, at once; and the least of those that would make others late.
   */
  RED_SHEDDING_HOPELESS = 2,
};
#ifndef __cplusplus
typedef uint32_t red_shedding;
#endif // __cplusplus

/**
 * What happens to a job that is past its deadline.
 */
enum red_late
#ifdef __cplusplus
  : uint32_t
#endif // __cplusplus
 {
  /**
   * It runs on.
   */
  RED_LATE_CONTINUE = 0,
  /**
   * It is given up.
   */
  RED_LATE_ABORT_JOB = 1,
};
#ifndef __cplusplus
typedef uint32_t red_late;
#endif // __cplusplus

/**
 * Where best-case execution times come from.
 */
enum red_best_case
#ifdef __cplusplus
  : uint32_t
#endif // __cplusplus
 {
  /**
   * The shortest of the last 8 executions, the declared one before the first.
   */
  RED_BEST_CASE_OBSERVED = 0,
  /**
   * The declared one, always.
   */
  RED_BEST_CASE_DECLARED = 1,
};
#ifndef __cplusplus
typedef uint32_t red_best_case;
#endif // __cplusplus

/**
 * What happens to a task, or an edit, whose certificate does not fit.
 */
enum red_admission
#ifdef __cplusplus
  : uint32_t
#endif // __cplusplus
 {
  /**
   * It is accepted.
   */
  RED_ADMISSION_REPORT = 0,
  /**
   * It is refused: RED_STATUS_UNSCHEDULABLE.
   */
  RED_ADMISSION_ENFORCE = 1,
};
#ifndef __cplusplus
typedef uint32_t red_admission;
#endif // __cplusplus

/**
 * What a node is in a MIMONet.
 */
enum red_role
#ifdef __cplusplus
  : uint32_t
#endif // __cplusplus
 {
  /**
   * Anything else.
   */
  RED_ROLE_ORDINARY = 0,
  /**
   * The shared encoder of a stage.
   */
  RED_ROLE_SHARED_ENCODER = 1,
  /**
   * A decoder: a successor of its encoder that reads the encoder's result.
   */
  RED_ROLE_DECODER = 2,
};
#ifndef __cplusplus
typedef uint32_t red_role;
#endif // __cplusplus

/**
 * Which bound a certificate rests on.
 */
enum red_bound
#ifdef __cplusplus
  : uint32_t
#endif // __cplusplus
 {
  /**
   * Graham 1969: L + ceil((W - L) / m).
   */
  RED_BOUND_GRAHAM = 0,
  /**
   * Long path: L + ceil((W - paths) / (m - j)), with j paths peeled.
   */
  RED_BOUND_LONG_PATH = 1,
  /**
   * Nodes in several pools.
   */
  RED_BOUND_SEVERAL_POOLS = 2,
};
#ifndef __cplusplus
typedef uint32_t red_bound;
#endif // __cplusplus

/**
 * Why a job was given up.
 */
enum red_shed
#ifdef __cplusplus
  : uint32_t
#endif // __cplusplus
 {
  /**
   * It was not: all its nodes completed.
   */
  RED_SHED_NOT = 0,
  /**
   * Not even its best case could end by the deadline.
   */
  RED_SHED_HOPELESS = 1,
  /**
   * Another job would have been late beside it.
   */
  RED_SHED_OVERLOAD = 2,
  /**
   * Lasting overload under the paper's rule; it had the lowest urgency.
   */
  RED_SHED_URGENCY = 3,
  /**
   * No place for another job: at its own release, or at that of a job of a higher rank.
   */
  RED_SHED_FULL = 4,
  /**
   * It was past its deadline, and the late policy is to abort.
   */
  RED_SHED_LATE = 5,
  /**
   * One of its nodes failed.
   */
  RED_SHED_FAULT = 6,
  /**
   * Its task was removed.
   */
  RED_SHED_REMOVED = 7,
};
#ifndef __cplusplus
typedef uint32_t red_shed;
#endif // __cplusplus

/**
 * What the host has to do.
 */
enum red_action_kind
#ifdef __cplusplus
  : uint32_t
#endif // __cplusplus
 {
  /**
   * Nothing, until something happens or the time of red_scheduler_poll_at comes.
   */
  RED_ACTION_KIND_NOTHING = 0,
  /**
   * Start the unit on its lane, and report it with red_scheduler_complete or red_scheduler_fail.
   */
  RED_ACTION_KIND_DISPATCH = 1,
  /**
   * Take the lane from this unit, which goes on later as another unit. Only if the configuration preempts.
   */
  RED_ACTION_KIND_PREEMPT = 2,
  /**
   * A job ended. A lane that still runs one of its units must report it all the same.
   */
  RED_ACTION_KIND_ENDED = 3,
  /**
   * Give the unit to its lane, to start after what that runs and after the units of red_scheduler_waits_for; report it
   * as any other. Only in pools of red_scheduler_dispatch_ahead.
   */
  RED_ACTION_KIND_AHEAD = 4,
};
#ifndef __cplusplus
typedef uint32_t red_action_kind;
#endif // __cplusplus

/**
 * What happened.
 */
enum red_event_kind
#ifdef __cplusplus
  : uint32_t
#endif // __cplusplus
 {
  /**
   * A kind that this header has no word for.
   */
  RED_EVENT_KIND_OTHER = 0,
  /**
   * A job was released.
   */
  RED_EVENT_KIND_RELEASED = 1,
  /**
   * A release found no place.
   */
  RED_EVENT_KIND_REFUSED = 2,
  /**
   * A sub-job started; each member of a unit has its own event.
   */
  RED_EVENT_KIND_STARTED = 3,
  /**
   * A sub-job that ran completed.
   */
  RED_EVENT_KIND_COMPLETED = 4,
  /**
   * An encoder completed without executing: its result was there.
   */
  RED_EVENT_KIND_HIT = 5,
  /**
   * A sub-job lost its lane to a smaller key.
   */
  RED_EVENT_KIND_PREEMPTED = 6,
  /**
   * A sub-job took longer than its WCET.
   */
  RED_EVENT_KIND_OVERRAN = 7,
  /**
   * All nodes of a job completed.
   */
  RED_EVENT_KIND_ENDED = 8,
  /**
   * A job was given up.
   */
  RED_EVENT_KIND_SHED = 9,
  /**
   * A task has a new graph.
   */
  RED_EVENT_KIND_EDITED = 10,
  /**
   * A kept result was thrown away for memory.
   */
  RED_EVENT_KIND_EVICTED = 11,
  /**
   * A job will miss its deadline, as far as is known: a red_warning says by how much and because of whom.
   */
  RED_EVENT_KIND_WARNED = 12,
};
#ifndef __cplusplus
typedef uint32_t red_event_kind;
#endif // __cplusplus

/**
 * How the lanes run.
 */
enum red_mode
#ifdef __cplusplus
  : uint32_t
#endif // __cplusplus
 {
  /**
   * SCHED_FIFO, memory locked, each lane alone on a CPU. Without the rights red_runtime_start is refused.
   */
  RED_MODE_REAL_TIME = 0,
  /**
   * Ordinary threads that share CPUs: no promise. red_report says so.
   */
  RED_MODE_BEST_EFFORT = 1,
};
#ifndef __cplusplus
typedef uint32_t red_mode;
#endif // __cplusplus

/**
 * Where a runtime is.
 */
enum red_runtime_state
#ifdef __cplusplus
  : uint32_t
#endif // __cplusplus
 {
  /**
   * It can be set up, and started.
   */
  RED_RUNTIME_STATE_SET_UP = 0,
  /**
   * Its lanes run.
   */
  RED_RUNTIME_STATE_RUNNING = 1,
  /**
   * Its lanes have ended.
   */
  RED_RUNTIME_STATE_ENDED = 2,
  /**
   * red_runtime_start was refused; red_runtime_message says why. It can be closed.
   */
  RED_RUNTIME_STATE_FAILED = 3,
};
#ifndef __cplusplus
typedef uint32_t red_runtime_state;
#endif // __cplusplus

/**
 * Why a run ended itself.
 */
enum red_surrender
#ifdef __cplusplus
  : uint32_t
#endif // __cplusplus
 {
  /**
   * It did not.
   */
  RED_SURRENDER_NO = 0,
  /**
   * No lane is left: bodies never returned, or their threads died.
   */
  RED_SURRENDER_NO_LANE = 1,
  /**
   * A lane's CPU was taken away.
   */
  RED_SURRENDER_CPU_GONE = 2,
  /**
   * For a reason that this header has no word for.
   */
  RED_SURRENDER_OTHER = 3,
};
#ifndef __cplusplus
typedef uint32_t red_surrender;
#endif // __cplusplus

/**
 * Configuration of a scheduler. Begin with RED_CONFIG_INIT and red_config_preset.
 */
typedef struct {
  /**
   * RED_CONFIG_INIT sets it.
   */
  uint32_t struct_size;
  /**
   * RED_CONFIG_INIT sets it.
   */
  uint32_t abi_version;
  /**
   * Lanes of the first pool; 1 up to the lanes of the capacity class.
   */
  uint32_t lanes;
  /**
   * One of red_rule.
   */
  uint32_t rule;
  /**
   * One of red_gate.
   */
  uint32_t gate;
  /**
   * One of red_reassign.
   */
  uint32_t reassign;
  /**
   * 1: stages are to be refined into encoder and decoders; the host builds its graphs by it. 0: not.
   */
  uint32_t refine;
  /**
   * 1: encoder results are shared beyond their unit. 0: not.
   */
  uint32_t frame_cache;
  /**
   * One of red_shedding.
   */
  uint32_t shed;
  /**
   * One of red_late.
   */
  uint32_t late;
  /**
   * One of red_best_case.
   */
  uint32_t best_case;
  /**
   * One of red_admission.
   */
  uint32_t admission;
  /**
   * 1: a waiting node takes the lane of a running one with a larger key. 0: not.
   */
  uint32_t preempt;
  /**
   * theta_u: busy share of all lanes in one tick that is overload, in millionths.
   */
  uint32_t overload_utilisation_ppm;
  /**
   * Q_max: ready sub-jobs above which it is overload; up to 65,535.
   */
  uint32_t overload_queue;
  /**
   * W: consecutive ticks until it is lasting; up to 255.
   */
  uint32_t overload_ticks;
  /**
   * Length of a tick; at least 1.
   */
  uint64_t overload_tick_ns;
  /**
   * Memory budget of the first pool; RED_NONE_64: unlimited.
   */
  uint64_t memory_bytes;
  /**
   * gamma of DynamicMerge; RED_NONE_64: no merging.
   */
  uint64_t merge_skew_ns;
} red_config;

/**
 * A graph: a place and a generation, no address. To be moved, not copied: of two copies one is left over.
 */
typedef struct {
  /**
   * For the library.
   */
  uint64_t bits;
} red_dag;

/**
 * A node: what it costs, where it runs, what it is. Begin with RED_NODE_INIT.
 */
typedef struct {
  /**
   * RED_NODE_INIT sets it.
   */
  uint32_t struct_size;
  /**
   * RED_NODE_INIT sets it.
   */
  uint32_t abi_version;
  /**
   * Worst-case execution time alone.
   */
  uint64_t wcet_ns;
  /**
   * Best-case execution time, at most wcet_ns, by which jobs are found hopeless; 0 if nothing is known.
   */
  uint64_t bcet_ns;
  /**
   * Of an atomic node: the delay that co-runners can add; else 0.
   */
  uint64_t contention_ns;
  /**
   * Footprint.
   */
  uint64_t memory_bytes;
  /**
   * Its pool; 0 is the first.
   */
  uint32_t pool;
  /**
   * 1: once started it keeps its lane. 0: not.
   */
  uint32_t atomic;
  /**
   * One of red_role.
   */
  uint32_t role;
  /**
   * Of an encoder: which weights it has, a number of the host's; up to 65,535.
   */
  uint32_t weights;
  /**
   * Of an encoder: which frame it reads, a number of the host's; up to 65,535.
   */
  uint32_t frame;
  /**
   * Of an encoder: the sensor that captures the frame, or RED_NONE: every job has its own capture.
   */
  uint32_t sensor;
} red_node;

/**
 * What a graph says as a whole.
 */
typedef struct {
  /**
   * RED_DAG_SUMMARY_INIT sets it.
   */
  uint32_t struct_size;
  /**
   * RED_DAG_SUMMARY_INIT sets it.
   */
  uint32_t abi_version;
  /**
   * Nodes.
   */
  uint32_t nodes;
  /**
   * Levels: the greatest height plus one.
   */
  uint32_t levels;
  /**
   * W: sum of all costs.
   */
  uint64_t work_ns;
  /**
   * L: cost of the critical path.
   */
  uint64_t critical_path_ns;
} red_dag_summary;

/**
 * Where a node stands in its graph, and when it is due. This struct does not grow.
 */
typedef struct {
  /**
   * Which node.
   */
  uint32_t node;
  /**
   * Its height: the longest chain of edges to it.
   */
  uint32_t height;
  /**
   * Longest path cost after it, excluding it.
   */
  uint64_t tail_ns;
  /**
   * When it should end, after the release; below 0 where the deadline is below the critical path.
   */
  int64_t sub_deadline_ns;
  /**
   * What dispatch orders by: the sub-deadline, under RED_RULE_LATEST_START less the node's cost.
   */
  int64_t key_ns;
} red_placed_node;

/**
 * What a level asks for and gets of a deadline. This struct does not grow.
 */
typedef struct {
  /**
   * The cost of its nodes.
   */
  uint64_t cost_ns;
  /**
   * Graham's bound of it alone.
   */
  uint64_t graham_ns;
  /**
   * Length of its share.
   */
  uint64_t share_ns;
  /**
   * When its share ends, after the release; of the last level, the deadline exactly.
   */
  uint64_t end_ns;
} red_level;

/**
 * A bound on the response time of a job that has its pools to itself.
 */
typedef struct {
  /**
   * RED_CERTIFICATE_INIT sets it.
   */
  uint32_t struct_size;
  /**
   * RED_CERTIFICATE_INIT sets it.
   */
  uint32_t abi_version;
  /**
   * One of red_bound.
   */
  uint32_t bound;
  /**
   * Of RED_BOUND_LONG_PATH: j.
   */
  uint32_t paths;
  /**
   * Lanes of the task's pool; the largest number where it uses several.
   */
  uint32_t lanes;
  /**
   * 1: the bound is met. 0: not.
   */
  uint32_t fits;
  /**
   * 1: memory cannot make a ready node wait. 0: it can, and the bound is not sufficient.
   */
  uint32_t memory_holds;
  /**
   * 0.
   */
  uint32_t reserved;
  /**
   * W: sum of all costs.
   */
  uint64_t work_ns;
  /**
   * L: cost of the critical path.
   */
  uint64_t critical_path_ns;
  /**
   * The bound's value.
   */
  uint64_t response_ns;
  /**
   * What it must not exceed: min(deadline, period).
   */
  uint64_t limit_ns;
  /**
   * limit_ns less response_ns.
   */
  int64_t margin_ns;
} red_certificate;

/**
 * A scheduler: a place and a generation, no address. To be moved, not copied: of two copies one is left over.
 */
typedef struct {
  /**
   * For the library.
   */
  uint64_t bits;
} red_scheduler;

/**
 * How a job ended. This struct does not grow.
 */
typedef struct {
  /**
   * The job; its place may be used again from now on.
   */
  uint32_t job;
  /**
   * Its task.
   */
  uint32_t task;
  /**
   * The how-manieth job of its task, from 0.
   */
  uint64_t index;
  /**
   * When it was released.
   */
  uint64_t release_ns;
  /**
   * When it was due.
   */
  uint64_t deadline_ns;
  /**
   * When it ended.
   */
  uint64_t at_ns;
  /**
   * One of red_shed.
   */
  uint32_t shed;
  /**
   * 0.
   */
  uint32_t reserved;
} red_outcome;

/**
 * One answer of a poll. This struct does not grow.
 */
typedef struct {
  /**
   * One of red_action_kind.
   */
  uint32_t kind;
  /**
   * Of a unit: its lane, counted over all pools in their order.
   */
  uint32_t lane;
  /**
   * Of a unit: its handle, used once. Bits 8 to 15 are the node of its first member.
   */
  uint64_t unit;
  /**
   * Of a job that ended. Else it is not written.
   */
  red_outcome outcome;
} red_action;

/**
 * A predicted deadline miss. This struct does not grow.
 */
typedef struct {
  /**
   * The job. It is given up already where its outcome says so.
   */
  uint32_t job;
  /**
   * Its task.
   */
  uint32_t task;
  /**
   * The index of the job in its task, from 0.
   */
  uint64_t index;
  /**
   * When it is due.
   */
  uint64_t deadline_ns;
  /**
   * When that was known.
   */
  uint64_t at_ns;
  /**
   * How long after its deadline it would end, by the estimates of then, in whole microseconds rounded up. 0: it would not be late, but goes so that the
   * other job is in time.
   */
  uint64_t by_ns;
  /**
   * The index of the job that takes the lanes it needs, in because_task; RED_NONE_64: it is late on its own.
   */
  uint64_t because_index;
  /**
   * Whose job takes the lanes it needs; RED_NONE: nobody's.
   */
  uint32_t because_task;
  /**
   * 0.
   */
  uint32_t reserved;
} red_warning;

/**
 * One sub-job of a unit. This struct does not grow.
 */
typedef struct {
  /**
   * The job.
   */
  uint32_t job;
  /**
   * Its task.
   */
  uint32_t task;
  /**
   * The node.
   */
  uint32_t node;
  /**
   * 0.
   */
  uint32_t reserved;
  /**
   * The how-manieth job of its task, from 0.
   */
  uint64_t index;
  /**
   * When the job was released.
   */
  uint64_t release_ns;
  /**
   * When the job is due.
   */
  uint64_t deadline_ns;
  /**
   * When the node should end.
   */
  uint64_t sub_deadline_ns;
} red_member;

/**
 * What a unit is.
 */
typedef struct {
  /**
   * RED_UNIT_INIT sets it.
   */
  uint32_t struct_size;
  /**
   * RED_UNIT_INIT sets it.
   */
  uint32_t abi_version;
  /**
   * Its first member: the one whose body runs.
   */
  red_member first;
  /**
   * Where it runs.
   */
  uint32_t lane;
  /**
   * The lane's pool.
   */
  uint32_t pool;
  /**
   * Number of the encoder result that it writes or reads, or RED_NONE. One number stays the same result until
   * nobody in flight needs it.
   */
  uint32_t output;
  /**
   * 0.
   */
  uint32_t reserved;
  /**
   * When it started.
   */
  uint64_t started_ns;
  /**
   * The worst-case execution time of the first member's node.
   */
  uint64_t wcet_ns;
} red_unit;

/**
 * What the executions of a node took, of its last 8.
 */
typedef struct {
  /**
   * RED_EXECUTIONS_INIT sets it.
   */
  uint32_t struct_size;
  /**
   * RED_EXECUTIONS_INIT sets it.
   */
  uint32_t abi_version;
  /**
   * Mean, or RED_NONE_64 before the first.
   */
  uint64_t mean_ns;
  /**
   * Shortest, or RED_NONE_64 before the first.
   */
  uint64_t minimum_ns;
  /**
   * Longest, or RED_NONE_64 before the first.
   */
  uint64_t maximum_ns;
} red_executions;

/**
 * What happened so far, and what is now.
 */
typedef struct {
  /**
   * RED_FIGURES_INIT sets it.
   */
  uint32_t struct_size;
  /**
   * RED_FIGURES_INIT sets it.
   */
  uint32_t abi_version;
  /**
   * Units dispatched.
   */
  uint64_t units;
  /**
   * Encoder sub-jobs that completed without executing.
   */
  uint64_t encoder_runs_saved;
  /**
   * Executions beyond the WCET, where the configuration takes samples of executions.
   */
  uint64_t overruns;
  /**
   * Calls whose now_ns was before an earlier one; the latest time was kept.
   */
  uint64_t clock_steps_back;
  /**
   * Completions of units whose jobs had been given up.
   */
  uint64_t late_completions;
  /**
   * Results thrown away for memory; their encoders run again.
   */
  uint64_t evictions;
  /**
   * Events that found no room; exact.
   */
  uint64_t events_dropped;
  /**
   * Lanes over all pools, retired ones too.
   */
  uint32_t lanes;
  /**
   * Jobs in flight.
   */
  uint32_t jobs_in_flight;
  /**
   * Sub-jobs that are ready and wait for a lane.
   */
  uint32_t ready;
  /**
   * Units that run.
   */
  uint32_t running;
  /**
   * 1: a pool has both a free lane and a sub-job that could start there, so red_scheduler_poll is to be called.
   */
  uint32_t can_dispatch;
  /**
   * 0.
   */
  uint32_t reserved;
} red_figures;

/**
 * One event. Fields that do not apply are 0. This struct does not grow.
 */
typedef struct {
  /**
   * When.
   */
  uint64_t at_ns;
  /**
   * The how-manieth job of its task, from 0.
   */
  uint64_t job;
  /**
   * One of red_event_kind.
   */
  uint32_t kind;
  /**
   * Of RED_EVENT_KIND_SHED: one of red_shed.
   */
  uint32_t shed;
  /**
   * Whose.
   */
  uint32_t task;
  /**
   * Which node.
   */
  uint32_t node;
  /**
   * Which lane.
   */
  uint32_t lane;
  /**
   * 0.
   */
  uint32_t reserved;
} red_event;

/**
 * How a runtime runs. Begin with RED_RUNTIME_CONFIG_INIT.
 */
typedef struct {
  /**
   * RED_RUNTIME_CONFIG_INIT sets it.
   */
  uint32_t struct_size;
  /**
   * RED_RUNTIME_CONFIG_INIT sets it.
   */
  uint32_t abi_version;
  /**
   * One of red_mode.
   */
  uint32_t mode;
  /**
   * Of SCHED_FIFO; 1 to 98, the watchdog runs one above. RED_RUNTIME_CONFIG_INIT: 80.
   */
  uint32_t priority;
  /**
   * No release from then on after the start; 0: until red_runtime_stop.
   */
  uint64_t duration_ns;
  /**
   * How long jobs in flight may go on after that. RED_RUNTIME_CONFIG_INIT: 1 s.
   */
  uint64_t drain_ns;
} red_runtime_config;

/**
 * A runtime: a place and a generation, no address. To be moved, not copied: of two copies one is left over.
 */
typedef struct {
  /**
   * For the library.
   */
  uint64_t bits;
} red_runtime;

/**
 * What a runtime did. What is marked "at the end" is RED_NONE_64, or 0 where it is of 32 bits, before the end, and where there was
 * no run.
 */
typedef struct {
  /**
   * RED_REPORT_INIT sets it.
   */
  uint32_t struct_size;
  /**
   * RED_REPORT_INIT sets it.
   */
  uint32_t abi_version;
  /**
   * One of red_runtime_state.
   */
  uint32_t state;
  /**
   * At the end. 1: lanes had SCHED_FIFO, locked memory and a CPU each. 0: not, so no promise.
   */
  uint32_t realtime;
  /**
   * At the end: one of red_surrender. Unless it is 0 the process is to be started anew.
   */
  uint32_t surrender;
  /**
   * At the end. 1: red_runtime_stop ended it. 0: its duration did, or it itself.
   */
  uint32_t stopped;
  /**
   * Jobs released. Those that are neither on time nor missed at the end were in flight when it was stopped
   * or drain_ns ran out.
   */
  uint64_t released;
  /**
   * Jobs that completed by their deadlines.
   */
  uint64_t on_time;
  /**
   * Jobs that completed late or were given up.
   */
  uint64_t missed;
  /**
   * Jobs that were given up, those that found no room at their release included.
   */
  uint64_t shed;
  /**
   * Bodies out of which a C++ exception came.
   */
  uint64_t threw;
  /**
   * Outcomes, and events, that nobody took in time.
   */
  uint64_t outcomes_dropped;
  /**
   * See outcomes_dropped.
   */
  uint64_t events_dropped;
  /**
   * At the end: bodies that failed or threw.
   */
  uint64_t failed;
  /**
   * At the end: executions beyond the WCET.
   */
  uint64_t overruns;
  /**
   * At the end: bodies that ran past ten times their WCET and 100 ms.
   */
  uint64_t hung;
  /**
   * At the end: lanes that were lost.
   */
  uint64_t lanes_lost;
  /**
   * At the end: lane threads that ended though nobody asked them to.
   */
  uint64_t threads_died;
  /**
   * At the end: units that ended after their sub-deadlines.
   */
  uint64_t nodes_missed;
  /**
   * At the end: units dispatched.
   */
  uint64_t units;
  /**
   * At the end: encoder sub-jobs that completed without executing.
   */
  uint64_t encoder_runs_saved;
  /**
   * At the end: heap calls of lanes outside of bodies.
   */
  uint64_t allocations;
  /**
   * At the end: page faults of lanes.
   */
  uint64_t page_faults;
  /**
   * At the end: times that nobody got a CPU for 20 ms and more.
   */
  uint64_t standstills;
  /**
   * At the end: the longest of them.
   */
  uint64_t longest_standstill_ns;
  /**
   * At the end: time that lanes spent deciding, per unit.
   */
  uint64_t overhead_ns_per_unit;
  /**
   * At the end: unit became dispatchable to body started, median.
   */
  uint64_t dispatch_p50_ns;
  /**
   * At the end: as dispatch_p50_ns, 99 of 100.
   */
  uint64_t dispatch_p99_ns;
  /**
   * At the end: as dispatch_p50_ns, the longest.
   */
  uint64_t dispatch_max_ns;
  /**
   * At the end, if it was recorded: inputs that found no room in the log, which then is not whole;
   * red_runtime_message says why if the system did not take it.
   */
  uint64_t log_dropped;
  /**
   * At the end, with a pool of CUDA streams: waits of one stream for another.
   */
  uint64_t event_waits_issued;
  /**
   * At the end, with a pool of CUDA streams: predecessors on the device that needed no such wait.
   */
  uint64_t event_waits_avoided;
  /**
   * At the end, with a pool of CUDA streams: units that were given to their streams while what they wait for ran.
   */
  uint64_t submissions_ahead;
  /**
   * At the end, with a pool of CUDA streams: how much less of the device's memory is free than at the start, whoever took it.
   * The whole device waits where that is done late.
   */
  uint64_t late_memory_bytes;
  /**
   * At the end: the error of the CUDA driver that ended the device for this process, so that nothing ran on it since; 0: it
   * works.
   */
  uint64_t device_error;
} red_report;

/**
 * What a body is told. Times are nanoseconds of CLOCK_MONOTONIC.
 */
typedef struct {
  /**
   * Size of this struct in the library.
   */
  uint32_t struct_size;
  /**
   * RED_ABI_VERSION of the library.
   */
  uint32_t abi_version;
  /**
   * The task.
   */
  uint32_t task;
  /**
   * The node.
   */
  uint32_t node;
  /**
   * Where it runs, counted over all pools.
   */
  uint32_t lane;
  /**
   * The lane's pool.
   */
  uint32_t pool;
  /**
   * Number of the encoder result that it writes or reads, or RED_NONE. One number stays the same result until
   * nobody in flight needs it.
   */
  uint32_t output;
  /**
   * 0.
   */
  uint32_t reserved;
  /**
   * The how-manieth job of its task, from 0.
   */
  uint64_t job;
  /**
   * When the job was released.
   */
  uint64_t release_ns;
  /**
   * When the job is due.
   */
  uint64_t deadline_ns;
  /**
   * When the node should end.
   */
  uint64_t sub_deadline_ns;
  /**
   * The node's worst-case execution time.
   */
  uint64_t wcet_ns;
  /**
   * The CUDA stream of the lane; NULL where there is none.
   */
  void *stream;
} red_context;

/**
 * What runs for a node, on a lane's thread: `user` is what came with it. It must return: not throw, not leave by longjmp, not
 * end its thread by pthread_exit. It may release jobs and stop the runtime; whatever would wait for a lane is
 * RED_STATUS_BUSY there.
 */
typedef int (*red_body)(void *user, const red_context *context);

/**
 * Which body runs for a node. This struct does not grow.
 */
typedef struct {
  /**
   * The node.
   */
  uint32_t node;
  /**
   * 0.
   */
  uint32_t reserved;
  /**
   * Its body.
   */
  red_body body;
  /**
   * What the body is called with; may be NULL, and must be there as long as a job of the node may run.
   */
  void *user;
} red_callback;

/**
 * When a task's jobs come and are due, and what they are worth.
 */
typedef struct {
  /**
   * RED_TIMING_INIT sets it.
   */
  uint32_t struct_size;
  /**
   * RED_TIMING_INIT sets it.
   */
  uint32_t abi_version;
  /**
   * End to end, relative to the release; 1 ns to 2^62 ns.
   */
  uint64_t deadline_ns;
  /**
   * Period, or minimum time between releases, for admission; 0: none declared.
   */
  uint64_t period_ns;
  /**
   * Rank under overload: a lower value costs none of a higher one its deadline, but for nodes that hold a lane; 1 is usual.
   */
  uint32_t value;
  /**
   * At least so many of any floor_of consecutive jobs are to be on time, before every value; 0 of 0: no floor.
   */
  uint32_t floor_keep;
  /**
   * See floor_keep; at least as many.
   */
  uint32_t floor_of;
  /**
   * 0.
   */
  uint32_t reserved;
} red_timing;

/**
 * What became of a task's jobs so far. Begin with RED_TASK_REPORT_INIT.
 */
typedef struct {
  /**
   * RED_TASK_REPORT_INIT sets it.
   */
  uint32_t struct_size;
  /**
   * RED_TASK_REPORT_INIT sets it.
   */
  uint32_t abi_version;
  /**
   * Jobs released. Those that are neither on time nor missed are in flight.
   */
  uint64_t released;
  /**
   * Jobs that completed by their deadlines.
   */
  uint64_t on_time;
  /**
   * Jobs that completed late or were given up.
   */
  uint64_t missed;
  /**
   * Jobs given up as RED_SHED_HOPELESS.
   */
  uint64_t hopeless;
  /**
   * Jobs given up as RED_SHED_OVERLOAD.
   */
  uint64_t overload;
  /**
   * Jobs given up as RED_SHED_URGENCY.
   */
  uint64_t urgency;
  /**
   * Jobs given up as RED_SHED_FULL, those that found no place at their release included.
   */
  uint64_t full;
  /**
   * Jobs given up as RED_SHED_LATE.
   */
  uint64_t late;
  /**
   * Jobs given up as RED_SHED_FAULT.
   */
  uint64_t fault;
  /**
   * Jobs given up as RED_SHED_REMOVED.
   */
  uint64_t removed;
  /**
   * Value of the jobs that were on time.
   */
  uint64_t value_on_time;
  /**
   * Value of all jobs released.
   */
  uint64_t value_released;
  /**
   * Jobs whose miss was predicted; red_runtime_take_warnings tells of each.
   */
  uint64_t warned;
  /**
   * Of a task with a floor: the fewest jobs that were on time in a window of floor_of consecutive ones. Jobs before the
   * first and after the last count as on time. A window of more than 128 jobs is kept as a stricter one of 128, and judged
   * as that.
   */
  uint32_t floor_worst;
  /**
   * 1: the task has no floor, or floor_worst is at least what it keeps. 0: it was broken.
   */
  uint32_t floor_kept;
} red_task_report;

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

/**
 * Fills a configuration with a named one of one lane and unlimited memory.
 *
 * Threads: any, at once. Real time: yes. Time: O(1). Errors: RED_STATUS_OUT_OF_RANGE: `preset` is not one of red_preset.
 */
red_status red_config_preset(uint32_t preset,
                             red_config *config);

/**
 * Opens a graph without nodes, for schedulers of 4 tasks of 16 nodes and 16 jobs. `memory`, of
 * RED_DAG_4X16X16_BYTES and aligned to RED_ALIGN, is the library's until red_dag_close.
 *
 * Threads: any, at once. Real time: yes. Time: O(nodes). Errors: RED_STATUS_TOO_SHORT, RED_STATUS_MISALIGNED,
 * RED_STATUS_OVERLAP, RED_STATUS_TOO_MANY_OPEN.
 */
red_status red_dag_open_4x16x16(void *memory,
                                size_t bytes,
                                red_dag *dag);

/**
 * Opens a graph without nodes, for schedulers of 8 tasks of 64 nodes and 32 jobs. `memory`, of
 * RED_DAG_8X64X32_BYTES and aligned to RED_ALIGN, is the library's until red_dag_close.
 *
 * Threads: any, at once. Real time: yes. Time: O(nodes). Errors: as red_dag_open_4x16x16.
 */
red_status red_dag_open_8x64x32(void *memory, size_t bytes, red_dag *dag);

/**
 * Opens a graph without nodes, for schedulers of 16 tasks of 256 nodes and 64 jobs, and for the runtime. `memory`, of
 * RED_DAG_16X256X64_BYTES and aligned to RED_ALIGN, is the library's until red_dag_close.
 *
 * Threads: any, at once. Real time: yes. Time: O(nodes). Errors: as red_dag_open_4x16x16.
 */
red_status red_dag_open_16x256x64(void *memory,
                                  size_t bytes,
                                  red_dag *dag);

/**
 * Closes a graph; its memory is the caller's again. Nothing that was made of it is touched.
 *
 * Threads: one at a time on a graph. Real time: yes. Time: O(1). Errors: RED_STATUS_CLOSED.
 */
red_status red_dag_close(red_dag *dag);

/**
 * Adds a node; nodes are numbered from 0.
 *
 * Threads: one at a time on a graph. Real time: yes. Time: O(nodes). Errors: RED_STATUS_NODES_FULL,
 * RED_STATUS_WORK_OVERFLOW, RED_STATUS_OUT_OF_RANGE: role, atomic, weights or frame, or contention without atomic,
 * RED_STATUS_UNKNOWN_POOL: the class has none of this number, RED_STATUS_UNKNOWN_SENSOR: an encoder's, above 255; whether the
 * scheduler has them is for it to say.
 */
red_status red_dag_add_node(red_dag *dag,
                            const red_node *node,
                            uint32_t *number);

/**
 * Adds an edge: `to` starts after `from` has completed.
 *
 * Threads: one at a time on a graph. Real time: yes. Time: O(nodes). Errors: RED_STATUS_CYCLE,
 * RED_STATUS_DUPLICATE_EDGE, RED_STATUS_SECOND_ENCODER, RED_STATUS_UNKNOWN_NODE.
 */
red_status red_dag_add_edge(red_dag *dag, uint32_t from, uint32_t to);

/**
 * Removes a node and its edges. Other nodes keep their numbers. In an edit its number is given again after the commit only,
 * as jobs in flight may have it.
 *
 * Threads: one at a time on a graph. Real time: yes. Time: O(nodes). Errors: RED_STATUS_UNKNOWN_NODE.
 */
red_status red_dag_remove_node(red_dag *dag,
                               uint32_t node);

/**
 * Removes an edge.
 *
 * Threads: one at a time on a graph. Real time: yes. Time: O(1). Errors: RED_STATUS_UNKNOWN_EDGE,
 * RED_STATUS_UNKNOWN_NODE.
 */
red_status red_dag_remove_edge(red_dag *dag, uint32_t from, uint32_t to);

/**
 * Replaces a node by a shared encoder and its decoders (paper Def. 6, Alg. 1). Edges into it lead to the encoder, edges
 * out of it leave every decoder. Later nodes move up: decoder j is node `encoder_number` + 1 + j. So a graph that
 * an edit gave is no edit any more: its commit is refused.
 *
 * Threads: one at a time on a graph. Real time: yes. Time: O(nodes + edges * decoders). Errors: RED_STATUS_UNKNOWN_NODE,
 * RED_STATUS_NO_DECODER, RED_STATUS_NODES_FULL, RED_STATUS_WORK_OVERFLOW, and those of the nodes.
 */
red_status red_dag_refine(red_dag *dag,
                          uint32_t stage,
                          const red_node *encoder,
                          const red_node *decoders,
                          size_t decoder_count,
                          uint32_t *encoder_number);

/**
 * Nodes, levels, work and critical path of a graph.
 *
 * Threads: any, while nobody changes the graph. Real time: yes. Time: O(nodes + edges). Errors: those of the handle.
 */
red_status red_dag_summarize(const red_dag *dag,
                             red_dag_summary *summary);

/**
 * The data of a node.
 *
 * Threads: any, while nobody changes the graph. Real time: yes. Time: O(1). Errors: RED_STATUS_UNKNOWN_NODE.
 */
red_status red_dag_node(const red_dag *dag,
                        uint32_t node,
                        red_node *data);

/**
 * The direct successors of a node, smallest first: up to `room` into `nodes`, and how many there are into `count`. If they
 * are more than `room`, only `count` is written.
 *
 * Threads: any, while nobody changes the graph. Real time: yes. Time: O(nodes). Errors: RED_STATUS_UNKNOWN_NODE,
 * RED_STATUS_TOO_SHORT.
 */
red_status red_dag_successors(const red_dag *dag,
                              uint32_t node,
                              uint32_t *nodes,
                              size_t room,
                              size_t *count);

/**
 * All nodes, smallest first, with their heights, tails, and sub-deadlines by `rule` (one of red_rule) for a deadline: up to
 * `room` into `nodes`, and how many there are into `count`. If they are more than `room`, only `count` is written.
 * `lanes` has the lanes of the first `pools` pools; others have one.
 *
 * Threads: any, while nobody changes the graph. Real time: yes. Time: O(nodes * pools + edges).
 * Errors: RED_STATUS_OUT_OF_RANGE: the rule, or more than 255 lanes. RED_STATUS_DEADLINE: above 2^62 ns.
 * RED_STATUS_NO_LANE, RED_STATUS_TOO_SHORT.
 */
red_status red_dag_place(const red_dag *dag,
                         uint32_t rule,
                         uint64_t deadline_ns,
                         const uint32_t *lanes,
                         size_t pools,
                         red_placed_node *nodes,
                         size_t room,
                         size_t *count);

/**
 * How a level rule divides a deadline among the levels of a graph: up to `room` into `levels`, and how many there are into
 * `count`. If they are more than `room`, only `count` is written. `rule` is RED_RULE_LEVEL_SUM or
 * RED_RULE_LEVEL_GRAHAM, `lanes` has the lanes of the first `pools` pools; others have one.
 *
 * Threads: any, while nobody changes the graph. Real time: yes. Time: O(nodes * pools + edges).
 * Errors: as red_dag_place.
 */
red_status red_dag_share(const red_dag *dag,
                         uint32_t rule,
                         uint64_t deadline_ns,
                         const uint32_t *lanes,
                         size_t pools,
                         red_level *levels,
                         size_t room,
                         size_t *count);

/**
 * Bounds the response time of a job of this graph that has its pools to itself. `lanes` and `memory_bytes` (RED_NONE_64:
 * unlimited) are of the first `pools` pools; others have one lane and unlimited memory.
 *
 * Threads: any, while nobody changes the graph. Real time: no. Time: O(lanes * (nodes + edges)). Errors:
 * RED_STATUS_NO_LANE, RED_STATUS_OUT_OF_RANGE: more than 255 lanes.
 */
red_status red_dag_prove(const red_dag *dag,
                         uint64_t limit_ns,
                         const uint32_t *lanes,
                         const uint64_t *memory_bytes,
                         size_t pools,
                         red_certificate *certificate);

/**
 * Releases a job of a task now. A job that finds no place has its index and its event all the same, and time goes on
 * whatever is answered.
 *
 * Threads: one at a time on a scheduler. Real time: yes. Time: O(nodes). Errors: RED_STATUS_UNKNOWN_TASK,
 * RED_STATUS_TIME_OVERFLOW, RED_STATUS_JOBS_FULL: the job's index is used up, and an event tells of it.
 */
red_status red_scheduler_release(red_scheduler *scheduler,
                                 uint32_t task,
                                 uint64_t now_ns,
                                 uint32_t *job);

/**
 * Releases a job whose release was at `release_ns`, for hosts that learn of it later. `capture` is the number of the frame
 * that it reads; RED_NONE_64: by the sensors' periods, and one of its own where a frame has no sensor. Else as
 * red_scheduler_release.
 *
 * Threads: one at a time on a scheduler. Real time: yes. Time: O(nodes). Errors: RED_STATUS_UNKNOWN_TASK,
 * RED_STATUS_TIME_OVERFLOW, RED_STATUS_JOBS_FULL: the job's index is used up, and an event tells of it.
 */
red_status red_scheduler_release_at(red_scheduler *scheduler,
                                    uint32_t task,
                                    uint64_t release_ns,
                                    uint64_t capture,
                                    uint64_t now_ns,
                                    uint32_t *job);

/**
 * The next thing to do; RED_ACTION_KIND_NOTHING until something happens or the time of red_scheduler_poll_at comes. To be
 * called until it says that.
 *
 * Threads: one at a time on a scheduler. Real time: yes. Time: O(log jobs) a dispatched node; O(jobs * (nodes + edges)) when
 * a job may be lost, at ticks of the monitor, and under re-assignment; with RED_SHEDDING_HOPELESS up to 67 + jobs runs of the
 * schedule ahead after a release, and in the next call at a later instant where all lanes were busy and nobody polled. Errors:
 * those of the handle.
 */
red_status red_scheduler_poll(red_scheduler *scheduler,
                              uint64_t now_ns,
                              red_action *action);

/**
 * red_scheduler_poll for a lane that asks for itself: it is preferred among the free lanes of its pool.
 *
 * Threads: one at a time on a scheduler. Real time: yes. Time: as red_scheduler_poll. Errors: RED_STATUS_UNKNOWN_LANE.
 */
red_status red_scheduler_poll_on(red_scheduler *scheduler,
                                 uint32_t lane_number,
                                 uint64_t now_ns,
                                 red_action *action);

/**
 * A unit ended: all its members complete, and what follows them may start. Time goes on whatever is answered.
 *
 * Threads: one at a time on a scheduler. Real time: yes. Time: O(successors + log jobs); with encoders O(jobs * encoders).
 * Errors: RED_STATUS_STALE, RED_STATUS_NOT_RUNNING; RED_STATUS_LATE: its lane is free all the same.
 */
red_status red_scheduler_complete(red_scheduler *scheduler,
                                  uint64_t unit,
                                  uint64_t now_ns);

/**
 * red_scheduler_complete and the first red_scheduler_poll_on of the unit's lane in one, which costs less than both.
 *
 * Threads: one at a time on a scheduler. Real time: yes. Time: as both. Errors: as red_scheduler_complete; nothing was
 * polled then.
 */
red_status red_scheduler_complete_and_poll(red_scheduler *scheduler,
                                           uint64_t unit,
                                           uint64_t now_ns,
                                           red_action *action);

/**
 * A unit failed: the jobs of all its members are given up with the reason RED_SHED_FAULT. Time goes on whatever is answered.
 *
 * Threads: one at a time on a scheduler. Real time: yes. Time: O(jobs * nodes). Errors: as red_scheduler_complete.
 */
red_status red_scheduler_fail(red_scheduler *scheduler,
                              uint64_t unit,
                              uint64_t now_ns);

/**
 * Takes the outcome of one job that ended, so that its place can be used again before the next poll. `count` is 1, or 0 where
 * there was none; then the outcome is not written.
 *
 * Threads: one at a time on a scheduler. Real time: yes. Time: O(1). Errors: those of the handle.
 */
red_status red_scheduler_take_outcome(red_scheduler *scheduler,
                                      red_outcome *outcome,
                                      uint32_t *count);

/**
 * Takes one warning of a deadline that will be missed, as far as is known since the last poll or, where all lanes were busy,
 * since the last event. Take warnings after each of these and before the next release. `count` is 1, or 0 where there was none; then the warning is not written. Only a configuration with
 * RED_SHEDDING_HOPELESS looks ahead and warns.
 *
 * Threads: one at a time on a scheduler. Real time: yes. Time: O(1). Errors: those of the handle.
 */
red_status red_scheduler_take_warning(red_scheduler *scheduler,
                                      red_warning *warning,
                                      uint32_t *count);

/**
 * Takes an idle lane out of its pool, because nothing can run there any more. A pool without lanes starts nothing.
 *
 * Threads: one at a time on a scheduler. Real time: yes. Time: O(1). Errors: RED_STATUS_UNKNOWN_LANE: there is no such
 * lane, or it runs something.
 */
red_status red_scheduler_retire_lane(red_scheduler *scheduler,
                                     uint32_t lane_number);

/**
 * Puts a retired lane back.
 *
 * Threads: one at a time on a scheduler. Real time: yes. Time: O(1). Errors: RED_STATUS_UNKNOWN_LANE: there is no such
 * lane, or it was not retired.
 */
red_status red_scheduler_restore_lane(red_scheduler *scheduler,
                                      uint32_t lane_number);

/**
 * Records every input of a scheduler from here on in a log at `path` (UTF-8), which `redrt replay` feeds to a scheduler again.
 * Directly after the scheduler was opened: before it was set up, a lane retired, or time passed. Writing is done by a thread of its own; calls on the scheduler write to memory.
 * Part of libred, not of libred_core.
 *
 * Threads: one at a time on a scheduler. Real time: no. Time: one file is created. Errors: RED_STATUS_TEXT,
 * RED_STATUS_LOG_LATE, RED_STATUS_LOG_FILE: errno says why, RED_STATUS_NO_MEMORY.
 */
red_status red_record_begin(red_scheduler *scheduler,
                            const char *path);

/**
 * Ends the log of a scheduler at `now_ns`, and waits until it is written. A log without this end is not whole, and is refused
 * by `redrt replay` after all that it has. `dropped` is how many inputs found no room; 0: the log is whole. Part of libred,
 * not of libred_core.
 *
 * Threads: one at a time on a scheduler. Real time: no. Time: until it is written. Errors: RED_STATUS_IDLE: there is no log;
 * RED_STATUS_LOG_FILE: it could not be written to its end, errno says why, and it is ended all the same;
 * RED_STATUS_FORKED: it is the parent's.
 */
red_status red_record_end(red_scheduler *scheduler,
                          uint64_t now_ns,
                          uint64_t *dropped);

/**
 * When red_scheduler_poll is to be called even if nothing happens; RED_NONE_64: not before something does. Any call may
 * change it.
 *
 * Threads: any, while nobody changes the scheduler. Real time: yes. Time: O(1). Errors: those of the handle.
 */
red_status red_scheduler_poll_at(const red_scheduler *scheduler,
                                 uint64_t *at_ns);

/**
 * What a unit is, while it runs and one of its jobs is in flight.
 *
 * Threads: any, while nobody changes the scheduler. Real time: yes. Time: O(1). Errors: RED_STATUS_NOT_RUNNING.
 */
red_status red_scheduler_unit(const red_scheduler *scheduler,
                              uint64_t unit,
                              red_unit *data);

/**
 * The members of a unit that runs: one, or the encoders that share one execution. Up to `room` into `members`, and how many
 * there are into `count`. If they are more than `room`, only `count` is written.
 *
 * Threads: any, while nobody changes the scheduler. Real time: yes. Time: O(jobs * nodes). Errors:
 * RED_STATUS_NOT_RUNNING, RED_STATUS_TOO_SHORT.
 */
red_status red_scheduler_members(const red_scheduler *scheduler,
                                 uint64_t unit,
                                 red_member *members,
                                 size_t room,
                                 size_t *count);

/**
 * The units of other lanes after which a unit that was dispatched ahead has to start: what its lane waits for besides what it
 * was given before. Up to `room` into `units`, and how many there are into `count`; none of a unit that counts as started. If
 * they are more than `room`, only `count` is written.
 *
 * Threads: any, while nobody changes the scheduler. Real time: yes. Time: O(lanes). Errors: RED_STATUS_NOT_RUNNING,
 * RED_STATUS_TOO_SHORT.
 */
red_status red_scheduler_waits_for(const red_scheduler *scheduler,
                                   uint64_t unit,
                                   uint64_t *units,
                                   size_t room,
                                   size_t *count);

/**
 * The job in flight that was the `index`-th of its task, from 0.
 *
 * Threads: any, while nobody changes the scheduler. Real time: yes. Time: O(jobs). Errors: RED_STATUS_UNKNOWN_JOB.
 */
red_status red_scheduler_job(const red_scheduler *scheduler,
                             uint32_t task,
                             uint64_t index,
                             uint32_t *job);

/**
 * What the last 8 executions of a node took, where the configuration takes samples.
 *
 * Threads: any, while nobody changes the scheduler. Real time: yes. Time: O(1). Errors: RED_STATUS_UNKNOWN_NODE: no such
 * node in the task's graph, or no such task.
 */
red_status red_scheduler_executions(const red_scheduler *scheduler,
                                    uint32_t task,
                                    uint32_t node,
                                    red_executions *executions);

/**
 * Counters and figures.
 *
 * Threads: any, while nobody changes the scheduler. Real time: yes. Time: O(jobs * nodes). Errors: those of the handle.
 */
red_status red_scheduler_figures(const red_scheduler *scheduler,
                                 red_figures *figures);

/**
 * Takes the oldest events of the record: up to `room` into `events`, and how many into `count`. What found no room in the
 * record is counted in red_figures: events_dropped.
 *
 * Threads: one at a time on a scheduler. Real time: yes. Time: O(room). Errors: those of the handle.
 */
red_status red_scheduler_take_events(red_scheduler *scheduler,
                                     red_event *events,
                                     size_t room,
                                     size_t *count);

/**
 * Opens a runtime: a scheduler of 16 tasks of 256 nodes and 64 jobs in flight, and lanes for it once it is started. Takes about
 * 2 MiB of memory, and as much again when it is started.
 *
 * Threads: any but a body's, at once. Real time: no. Time: O(memory). Errors: RED_STATUS_OUT_OF_RANGE: a field of a
 * configuration, each of which says its range; RED_STATUS_BUSY: from a body, RED_STATUS_NO_LANE, RED_STATUS_POOLS_FULL: more than 32 lanes, RED_STATUS_PREEMPTS, RED_STATUS_TOO_MANY_OPEN,
 * RED_STATUS_NO_MEMORY.
 */
red_status red_runtime_open(const red_config *policy,
                            const red_runtime_config *config,
                            red_runtime *runtime);

/**
 * Stops a runtime, waits for its end and for other calls on it that go on, and frees it. Calls that come later, by copies of
 * the handle, are RED_STATUS_CLOSED. A body that hung, as red_report counts them, may still run afterwards, and has to find
 * what it uses.
 *
 * Threads: any but a body's, at once: of several, one closes it. Real time: no. Time: until the bodies that run have returned,
 * as long as the watchdog gives them. Errors: RED_STATUS_CLOSED; RED_STATUS_BUSY: from a body; RED_STATUS_FORKED.
 */
red_status red_runtime_close(red_runtime *runtime);

/**
 * Where a runtime is: one of red_runtime_state.
 *
 * Threads: any, at once. Real time: no. Time: O(1), but until a start that goes on is over. Errors: those of the
 * handle, RED_STATUS_FORKED.
 */
red_status red_runtime_state_of(const red_runtime *runtime,
                                uint32_t *state);

/**
 * Why red_runtime_start or red_runtime_record was refused, or a log that was begun is not whole at the end, in words, with what
 * to do about it; empty where nothing of that is so. Up to `room` bytes into
 * `text`, with the byte that ends it, and how many it takes into `count`; if they are more than `room`, only that.
 *
 * Threads: any, at once. Real time: no. Time: O(length), but until a start that goes on is over. Errors:
 * RED_STATUS_TOO_SHORT, RED_STATUS_FORKED.
 */
red_status red_runtime_message(const red_runtime *runtime,
                               char *text,
                               size_t room,
                               size_t *count);

/**
 * What the runtime did so far, or did.
 *
 * Threads: any, at once. Real time: no. Time: O(1), but until a start that goes on is over. Errors: those of the
 * handle, RED_STATUS_FORKED.
 */
red_status red_runtime_report(const red_runtime *runtime,
                              red_report *report);

/**
 * Starts the lanes. In real time each lane is pinned, and as long as one is running all memory of the process is locked,
 * what comes later too, and the C library's allocator gives back none; if a right is missing nothing runs,
 * red_runtime_message says which and how to get it, and what was changed is changed back, but for a process that had memory
 * locked before: all of it is locked then. No signal handler is installed; lanes inherit the caller's mask of signals.
 *
 * Threads: any but a body's. Real time: no. Time: until all lanes are ready. Errors: RED_STATUS_NOT_PERMITTED,
 * RED_STATUS_CPUS, RED_STATUS_SYSTEM: after these the runtime can only be closed, and calls that set it up or look at its
 * tasks answer the same; RED_STATUS_STARTED, RED_STATUS_FORKED, RED_STATUS_NO_MEMORY; RED_STATUS_BUSY: from a body.
 */
red_status red_runtime_start(red_runtime *runtime);

/**
 * Releases a job of a task. `capture` is the number of the frame that it reads; RED_NONE_64: by the sensors' periods, and one
 * of its own where a frame has no sensor. A task that is not there is found out by a lane, and its release is dropped.
 *
 * Threads: any, at once, also a body. Real time: yes, with one system call if a lane has to be woken. Time: wait-free.
 * Errors: RED_STATUS_IDLE: not started; RED_STATUS_MAILBOX_FULL, RED_STATUS_OVER, RED_STATUS_FORKED; RED_STATUS_BUSY: as
 * many threads as can are releasing at this moment, try again.
 */
red_status red_runtime_release(const red_runtime *runtime,
                               uint32_t task,
                               uint64_t capture);

/**
 * Asks the lanes to end: nothing is released any more, no lane takes another unit, bodies that run are waited for by
 * red_runtime_wait. Where red_runtime_start is on its way, its lanes end before they begin anything. Again, or after the
 * end, it changes nothing.
 *
 * Threads: any, at once, also a body or a signal handler. Real time: yes, with one system call. Time: wait-free. Errors:
 * RED_STATUS_IDLE: red_runtime_start was not called, or was refused; RED_STATUS_FORKED.
 */
red_status red_runtime_stop(const red_runtime *runtime);

/**
 * Waits until the runtime has ended, at most `timeout_ns`; RED_NONE_64: as long as it takes.
 *
 * Threads: any but a body's, at once. Real time: no. Time: the timeout. Errors: RED_STATUS_TIMEOUT: it goes on;
 * RED_STATUS_IDLE: not started; RED_STATUS_BUSY: from a body; RED_STATUS_FORKED; RED_STATUS_SYSTEM: a lane did not come up,
 * red_runtime_message says why.
 */
red_status red_runtime_wait(const red_runtime *runtime,
                            uint64_t timeout_ns);

/**
 * Counters and figures of the scheduler while lanes run, or before.
 *
 * Threads: any but a body's, at once. Real time: no. Time: until a lane has a turn. Errors: RED_STATUS_BUSY: from a body;
 * RED_STATUS_OVER: red_runtime_report has what is known at the end; RED_STATUS_FORKED, RED_STATUS_NO_MEMORY.
 */
red_status red_runtime_figures(red_runtime *runtime,
                               red_figures *now);

/**
 * Takes the oldest outcomes of jobs that ended: up to `room` into `outcomes`, and how many into `count`. 1,024 are kept; what
 * finds no room is counted in red_report: outcomes_dropped. A release for which 64 jobs in flight left no room became no job
 * and has no outcome; red_report counts it as released, missed and shed. Times are of CLOCK_MONOTONIC.
 *
 * Threads: one at a time. Real time: yes. Time: O(room). Errors: those of the handle, RED_STATUS_FORKED.
 */
red_status red_runtime_take_outcomes(red_runtime *runtime,
                                     red_outcome *outcomes,
                                     size_t room,
                                     size_t *count);

/**
 * Takes the oldest warnings of deadlines that will be missed: up to `room` into `warnings`, and how many into `count`. 1,024
 * are kept; what finds no room is counted in red_report: events_dropped. Times are of CLOCK_MONOTONIC.
 *
 * Threads: one at a time. Real time: yes. Time: O(room). Errors: those of the handle, RED_STATUS_FORKED.
 */
red_status red_runtime_take_warnings(red_runtime *runtime,
                                     red_warning *warnings,
                                     size_t room,
                                     size_t *count);

/**
 * Takes the oldest events: up to `room` into `events`, and how many into `count`. 8,192 are kept; what finds no room is counted
 * in red_report: events_dropped. Times are of CLOCK_MONOTONIC.
 *
 * Threads: one at a time. Real time: yes. Time: O(room). Errors: those of the handle, RED_STATUS_FORKED.
 */
red_status red_runtime_take_events(red_runtime *runtime,
                                   red_event *events,
                                   size_t room,
                                   size_t *count);

/**
 * Adds a pool of `lanes` lanes after the others; the first, 0, is that of the configuration. `memory_bytes` is its budget,
 * RED_NONE_64: unlimited. Before the start only.
 *
 * Threads: any, at once. Real time: no. Time: O(lanes). Errors: RED_STATUS_NO_LANE, RED_STATUS_POOLS_FULL,
 * RED_STATUS_STARTED, RED_STATUS_FORKED.
 */
red_status red_runtime_add_pool(red_runtime *runtime,
                                uint32_t lanes,
                                uint64_t memory_bytes,
                                uint32_t *pool);

/**
 * Adds a pool of `lanes` lanes after the others that are streams of a CUDA device, by its number from 0. The driver is loaded
 * at run time. A body of a node there has the lane's stream in its context, submits its work to that, and returns without
 * waiting for it: it has ended when the stream gets there. Nodes start on the device after those they follow, without the
 * CPU in between; what follows on the CPU starts when the stream got there. Streams are of the device's primary context, which
 * is the calling lane's; make what bodies need before the start, for the whole device may wait for an allocation or a module.
 * Before the start only; one device for a runtime.
 *
 * Threads: any, at once. Real time: no. Time: the driver's, on first use a second. Errors: RED_STATUS_CUDA,
 * RED_STATUS_OUT_OF_RANGE: another device than that of a pool before, RED_STATUS_NO_LANE, RED_STATUS_POOLS_FULL,
 * RED_STATUS_STARTED, RED_STATUS_FORKED, RED_STATUS_NO_MEMORY.
 */
red_status red_runtime_add_cuda_pool(red_runtime *runtime,
                                     uint32_t device,
                                     uint32_t lanes,
                                     uint64_t memory_bytes,
                                     uint32_t *pool);

/**
 * Makes a sensor known that captures a frame each `period_ns` from the start on; jobs released between two captures share
 * the earlier one. Sensors of one period are one: the frame's number tells them apart. Before the start only.
 *
 * Threads: any, at once. Real time: no. Time: O(sensors). Errors: RED_STATUS_ZERO_PERIOD, RED_STATUS_SENSORS_FULL,
 * RED_STATUS_STARTED, RED_STATUS_FORKED.
 */
red_status red_runtime_add_sensor(red_runtime *runtime,
                                  uint64_t period_ns,
                                  uint32_t *sensor);

/**
 * Pins lane i to the i-th of `cpus`, in real time: as many as there are lanes, each another one. Without this call they are
 * chosen, CPU 0 last. Before the start only.
 *
 * Threads: any, at once. Real time: no. Time: O(count). Errors: RED_STATUS_TOO_LONG: more than 32,
 * RED_STATUS_OUT_OF_RANGE: CPU 1024 and above, RED_STATUS_STARTED, RED_STATUS_FORKED, RED_STATUS_NO_MEMORY.
 */
red_status red_runtime_pin(red_runtime *runtime,
                           const uint32_t *cpus,
                           size_t count);

/**
 * Has jobs of a task released by the clock: the first `first_ns` after the start, then each `period_ns`; 0: one only. Before
 * the start only.
 *
 * Threads: any, at once. Real time: no. Time: O(1). Errors: RED_STATUS_UNKNOWN_TASK, RED_STATUS_STARTED,
 * RED_STATUS_FORKED, RED_STATUS_NO_MEMORY.
 */
red_status red_runtime_every(red_runtime *runtime,
                             uint32_t task,
                             uint64_t first_ns,
                             uint64_t period_ns);

/**
 * Records every input of the run in a log at `path` (UTF-8), which `redrt replay` feeds to a scheduler again. Before anything
 * else is set up.
 *
 * Threads: any, at once. Real time: no. Time: one file is created. Errors: RED_STATUS_TEXT, RED_STATUS_LOG_LATE,
 * RED_STATUS_LOG_FILE: red_runtime_message and errno say why, RED_STATUS_STARTED, RED_STATUS_FORKED, RED_STATUS_NO_MEMORY.
 */
red_status red_runtime_record(red_runtime *runtime,
                              const char *path);

/**
 * Nanoseconds of CLOCK_MONOTONIC, the clock of all times that the runtime takes and gives.
 *
 * Threads: any, at once. Real time: yes. Time: O(1). Errors: none besides a NULL or misaligned pointer.
 */
red_status red_runtime_now(uint64_t *now_ns);

/**
 * Admits a task, also while lanes run. The graph (of class 16x256x64) is copied; `callbacks` has a body for each of its nodes.
 *
 * Threads: any but a body's, at once, while nobody changes the graph. Real time: no. Time: until a lane has a turn. Errors:
 * RED_STATUS_TASKS_FULL, RED_STATUS_EMPTY_GRAPH, RED_STATUS_DEADLINE, RED_STATUS_UNKNOWN_POOL,
 * RED_STATUS_UNKNOWN_SENSOR, RED_STATUS_MEMORY, RED_STATUS_UNSCHEDULABLE, RED_STATUS_OTHER_CLASS,
 * RED_STATUS_OUT_OF_RANGE: floor_keep above floor_of; RED_STATUS_NO_BODY; RED_STATUS_UNKNOWN_NODE: a body for no node, or
 * two for one; RED_STATUS_BUSY: from a body; RED_STATUS_OVER, RED_STATUS_FORKED, RED_STATUS_NO_MEMORY.
 */
red_status red_runtime_add_task(red_runtime *runtime,
                                const red_dag *dag,
                                const red_callback *callbacks,
                                size_t callback_count,
                                const red_timing *timing,
                                uint32_t *task);

/**
 * Removes a task; its jobs in flight are given up with the reason RED_SHED_REMOVED. Bodies that run go on to their ends.
 *
 * Threads: any but a body's, at once. Real time: no. Time: until a lane has a turn. Errors: RED_STATUS_UNKNOWN_TASK,
 * RED_STATUS_BUSY: from a body; RED_STATUS_OVER, RED_STATUS_FORKED, RED_STATUS_NO_MEMORY.
 */
red_status red_runtime_remove_task(red_runtime *runtime,
                                   uint32_t task);

/**
 * The bound on the response time of the task's newest graph, alone on its pools.
 *
 * Threads: any but a body's, at once. Real time: no. Time: until a lane has a turn. Errors: RED_STATUS_UNKNOWN_TASK,
 * RED_STATUS_BUSY: from a body; RED_STATUS_OVER, RED_STATUS_FORKED, RED_STATUS_NO_MEMORY.
 */
red_status red_runtime_certificate(red_runtime *runtime,
                                   uint32_t task,
                                   red_certificate *certificate);

/**
 * What became of the task's jobs so far; also after the end of the run.
 *
 * Threads: any, at once, also a body. Real time: yes. Time: O(1). Errors: RED_STATUS_UNKNOWN_TASK, RED_STATUS_FORKED.
 */
red_status red_runtime_task_report(const red_runtime *runtime,
                                   uint32_t task,
                                   red_task_report *report);

/**
 * Begins an edit: opens the task's newest graph in `memory`, of RED_DAG_16X256X64_BYTES, to be changed, given to
 * red_runtime_commit, and closed. Closing it without a commit changes nothing.
 *
 * Threads: any but a body's, at once. Real time: no. Time: until a lane has a turn. Errors: RED_STATUS_UNKNOWN_TASK,
 * RED_STATUS_TOO_SHORT, RED_STATUS_MISALIGNED, RED_STATUS_OVERLAP, RED_STATUS_TOO_MANY_OPEN, RED_STATUS_BUSY: from a
 * body; RED_STATUS_OVER, RED_STATUS_FORKED, RED_STATUS_NO_MEMORY.
 */
red_status red_runtime_edit(red_runtime *runtime,
                            uint32_t task,
                            void *memory,
                            size_t bytes,
                            red_dag *dag);

/**
 * Applies an edit to the jobs that are released from now on; jobs in flight keep the graph of their release. `callbacks` has a
 * body for each node that is new; others keep theirs. An edit that was begun on another runtime is none of this one's:
 * RED_STATUS_CONFLICT.
 *
 * Threads: any but a body's, at once, while nobody changes the graph. Real time: no. Time: until a lane has a turn. Errors:
 * RED_STATUS_UNKNOWN_TASK, RED_STATUS_CONFLICT, RED_STATUS_DRAINING, RED_STATUS_EMPTY_GRAPH, RED_STATUS_UNKNOWN_POOL,
 * RED_STATUS_UNKNOWN_SENSOR, RED_STATUS_MEMORY, RED_STATUS_UNSCHEDULABLE, RED_STATUS_OTHER_CLASS, RED_STATUS_NO_BODY,
 * RED_STATUS_HAS_BODY, RED_STATUS_UNKNOWN_NODE: a body for no node, or two for one; RED_STATUS_BUSY: from a body;
 * RED_STATUS_OVER, RED_STATUS_FORKED, RED_STATUS_NO_MEMORY.
 */
red_status red_runtime_commit(red_runtime *runtime,
                              const red_dag *dag,
                              const red_callback *callbacks,
                              size_t callback_count,
                              red_certificate *certificate);

/**
 * The version of the ABI that this library has: RED_ABI_VERSION of its header.
 *
 * Threads: any, at once. Real time: yes. Time: O(1). Errors: none.
 */
uint32_t red_abi_version(void);

/**
 * The version of this library, as "0.1.0". The text is constant.
 *
 * Threads: any, at once. Real time: yes. Time: O(1). Errors: none.
 */
const char *red_version(void);

/**
 * Opens a scheduler of 4 tasks of 16 nodes and 16 jobs in flight; 4 lanes in 2 pools, 64 events. `memory`, of
 * RED_SCHEDULER_4X16X16_BYTES and aligned to RED_ALIGN, is the library's until red_scheduler_close.
 *
 * Threads: any, at once. Real time: no. Time: O(memory). Errors: RED_STATUS_TOO_SHORT, RED_STATUS_MISALIGNED,
 * RED_STATUS_OVERLAP, RED_STATUS_TOO_MANY_OPEN, RED_STATUS_NO_LANE, RED_STATUS_POOLS_FULL: more lanes than the class has,
 * RED_STATUS_OUT_OF_RANGE: another field of the configuration.
 */
red_status red_scheduler_open_4x16x16(void *memory,
                                      size_t bytes,
                                      const red_config *config,
                                      red_scheduler *scheduler);

/**
 * Opens a scheduler of 8 tasks of 64 nodes and 32 jobs in flight; 8 lanes in 4 pools, 256 events. `memory`, of
 * RED_SCHEDULER_8X64X32_BYTES and aligned to RED_ALIGN, is the library's until red_scheduler_close.
 *
 * Threads: any, at once. Real time: no. Time: O(memory). Errors: as red_scheduler_open_4x16x16.
 */
red_status red_scheduler_open_8x64x32(void *memory,
                                      size_t bytes,
                                      const red_config *config,
                                      red_scheduler *scheduler);

/**
 * Opens a scheduler of 16 tasks of 256 nodes and 64 jobs in flight; 32 lanes in 32 pools, 1,024 events. `memory`, of
 * RED_SCHEDULER_16X256X64_BYTES and aligned to RED_ALIGN, is the library's until red_scheduler_close.
 *
 * Threads: any, at once. Real time: no. Time: O(memory). Errors: as red_scheduler_open_4x16x16.
 */
red_status red_scheduler_open_16x256x64(void *memory,
                                        size_t bytes,
                                        const red_config *config,
                                        red_scheduler *scheduler);

/**
 * Closes a scheduler; its memory is the caller's again. A log that red_record_end did not end is let go, and is not whole.
 *
 * Threads: one at a time on a scheduler. Real time: yes, without a log. Time: O(1). Errors: RED_STATUS_CLOSED.
 */
red_status red_scheduler_close(red_scheduler *scheduler);

/**
 * Adds a pool of `lanes` lanes after the others; the first, 0, is that of the configuration. `memory_bytes` is its budget,
 * RED_NONE_64: unlimited.
 *
 * Threads: one at a time on a scheduler. Real time: yes. Time: O(lanes). Errors: RED_STATUS_NO_LANE,
 * RED_STATUS_POOLS_FULL.
 */
red_status red_scheduler_add_pool(red_scheduler *scheduler,
                                  uint32_t lanes,
                                  uint64_t memory_bytes,
                                  uint32_t *pool);

/**
 * Has a pool dispatch ahead: its lanes run by themselves what they are given, in its order, as streams of a GPU do. Polls then
 * answer RED_ACTION_KIND_AHEAD, too: a unit that its lane is given while what comes before it runs. Certificates take it
 * into account.
 *
 * Threads: one at a time on a scheduler. Real time: yes. Time: O(1). Errors: RED_STATUS_UNKNOWN_POOL,
 * RED_STATUS_NOT_AHEAD.
 */
red_status red_scheduler_dispatch_ahead(red_scheduler *scheduler,
                                        uint32_t pool);

/**
 * Gives a pool up, because what its lanes ran on is gone: jobs that still need it end with RED_SHED_FAULT, and so does each
 * that is released from now on. Units that run there have to be reported all the same.
 *
 * Threads: one at a time on a scheduler. Real time: yes. Time: O(jobs * nodes). Errors: RED_STATUS_UNKNOWN_POOL.
 */
red_status red_scheduler_lose_pool(red_scheduler *scheduler,
                                   uint32_t pool,
                                   uint64_t now_ns);

/**
 * Makes a sensor known that captures a frame each `period_ns`, from time 0 on; jobs released between two captures share the
 * earlier one. Sensors of one period are one: the frame's number tells them apart.
 *
 * Threads: one at a time on a scheduler. Real time: yes. Time: O(sensors). Errors: RED_STATUS_ZERO_PERIOD,
 * RED_STATUS_SENSORS_FULL.
 */
red_status red_scheduler_add_sensor(red_scheduler *scheduler,
                                    uint64_t period_ns,
                                    uint32_t *sensor);

/**
 * The configuration of a scheduler.
 *
 * Threads: any, while nobody changes the scheduler. Real time: yes. Time: O(1). Errors: those of the handle.
 */
red_status red_scheduler_config(const red_scheduler *scheduler,
                                red_config *config);

/**
 * Bytes that running units and kept results hold of a pool's budget.
 *
 * Threads: any, while nobody changes the scheduler. Real time: yes. Time: O(1). Errors: RED_STATUS_UNKNOWN_POOL.
 */
red_status red_scheduler_memory_used(const red_scheduler *scheduler,
                                     uint32_t pool,
                                     uint64_t *used_bytes);

/**
 * Bytes that red_scheduler_open_4x16x16 needs here: at most RED_SCHEDULER_4X16X16_BYTES.
 *
 * Threads: any, at once. Real time: yes. Time: O(1). Errors: none.
 */
size_t red_scheduler_bytes_4x16x16(void);

/**
 * Bytes that red_scheduler_open_8x64x32 needs here: at most RED_SCHEDULER_8X64X32_BYTES.
 *
 * Threads: any, at once. Real time: yes. Time: O(1). Errors: none.
 */
size_t red_scheduler_bytes_8x64x32(void);

/**
 * Bytes that red_scheduler_open_16x256x64 needs here: at most RED_SCHEDULER_16X256X64_BYTES.
 *
 * Threads: any, at once. Real time: yes. Time: O(1). Errors: none.
 */
size_t red_scheduler_bytes_16x256x64(void);

/**
 * The alignment that all memory needs which is lent to this library: at most RED_ALIGN.
 *
 * Threads: any, at once. Real time: yes. Time: O(1). Errors: none.
 */
size_t red_align(void);

/**
 * A status in words, with what to do about it; of a number that is none, that it is none. The text is constant.
 *
 * Threads: any, at once. Real time: yes. Time: O(1). Errors: none.
 */
const char *red_status_text(int32_t status);

/**
 * Admits a task. The graph is copied.
 *
 * Threads: one at a time on a scheduler, while nobody changes the graph. Real time: no. Time: O(lanes * (nodes + edges) +
 * nodes log nodes). Errors: RED_STATUS_TASKS_FULL, RED_STATUS_EMPTY_GRAPH, RED_STATUS_DEADLINE,
 * RED_STATUS_UNKNOWN_POOL, RED_STATUS_UNKNOWN_SENSOR, RED_STATUS_MEMORY, RED_STATUS_UNSCHEDULABLE,
 * RED_STATUS_OTHER_CLASS, RED_STATUS_OUT_OF_RANGE: floor_keep above floor_of.
 */
red_status red_scheduler_add_task(red_scheduler *scheduler,
                                  const red_dag *dag,
                                  const red_timing *timing,
                                  uint32_t *task);

/**
 * Removes a task; its jobs in flight are given up with the reason RED_SHED_REMOVED.
 *
 * Threads: one at a time on a scheduler. Real time: yes. Time: O(jobs * nodes). Errors: RED_STATUS_UNKNOWN_TASK.
 */
red_status red_scheduler_remove_task(red_scheduler *scheduler,
                                     uint32_t task,
                                     uint64_t now_ns);

/**
 * The bound on the response time of the task's newest graph, alone on its pools.
 *
 * Threads: any, while nobody changes the scheduler. Real time: no. Time: O(lanes * (nodes + edges)). Errors:
 * RED_STATUS_UNKNOWN_TASK.
 */
red_status red_scheduler_certificate(const red_scheduler *scheduler,
                                     uint32_t task,
                                     red_certificate *certificate);

/**
 * Begins an edit: opens the task's newest graph as one of its own, to be changed and given to red_scheduler_commit, and
 * closed. `memory` is as for red_dag_open of the scheduler's class. Closing it without a commit changes nothing.
 *
 * Threads: any, while nobody changes the scheduler. Real time: no. Time: O(nodes + edges). Errors:
 * RED_STATUS_UNKNOWN_TASK, RED_STATUS_TOO_SHORT, RED_STATUS_MISALIGNED, RED_STATUS_OVERLAP, RED_STATUS_TOO_MANY_OPEN.
 */
red_status red_scheduler_edit(const red_scheduler *scheduler,
                              uint32_t task,
                              void *memory,
                              size_t bytes,
                              red_dag *dag);

/**
 * Applies an edit to the jobs that are released from now on; jobs in flight keep the graph of their release. An edit that was
 * begun on another scheduler is none of this one's: RED_STATUS_CONFLICT.
 *
 * Threads: one at a time on a scheduler, while nobody changes the graph. Real time: no. Time: O(nodes log nodes + lanes *
 * (nodes + edges)). Errors: RED_STATUS_UNKNOWN_TASK, RED_STATUS_CONFLICT, RED_STATUS_DRAINING, RED_STATUS_EMPTY_GRAPH,
 * RED_STATUS_UNKNOWN_POOL, RED_STATUS_UNKNOWN_SENSOR, RED_STATUS_MEMORY, RED_STATUS_UNSCHEDULABLE,
 * RED_STATUS_OTHER_CLASS.
 */
red_status red_scheduler_commit(red_scheduler *scheduler,
                                const red_dag *dag,
                                uint64_t now_ns,
                                red_certificate *certificate);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* RED_H */

/* What a struct that may grow begins with: its size and the version of the ABI that it was compiled for. */
#ifdef __cplusplus
#define RED_HEAD(type) static_cast<uint32_t>(sizeof(type)), RED_ABI_VERSION
#else
#define RED_HEAD(type) (uint32_t)sizeof(type), RED_ABI_VERSION
#endif

#define RED_CONFIG_INIT {RED_HEAD(red_config), 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0}
#define RED_NODE_INIT {RED_HEAD(red_node), 0, 0, 0, 0, 0, 0, 0, 0, 0, RED_NONE}
#define RED_TIMING_INIT {RED_HEAD(red_timing), 0, 0, 1, 0, 0, 0}
#define RED_CERTIFICATE_INIT {RED_HEAD(red_certificate), 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0}
#define RED_UNIT_INIT {RED_HEAD(red_unit), {0, 0, 0, 0, 0, 0, 0, 0}, 0, 0, 0, 0, 0, 0}
#define RED_FIGURES_INIT {RED_HEAD(red_figures), 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0}
#define RED_EXECUTIONS_INIT {RED_HEAD(red_executions), 0, 0, 0}
#define RED_DAG_SUMMARY_INIT {RED_HEAD(red_dag_summary), 0, 0, 0, 0}
#define RED_RUNTIME_CONFIG_INIT {RED_HEAD(red_runtime_config), 0, 80, 0, 1000000000}
#define RED_REPORT_INIT {RED_HEAD(red_report), 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0}
#define RED_TASK_REPORT_INIT {RED_HEAD(red_task_report), 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0}
