/* The loop: release, poll, complete, and what a host may ask meanwhile. */
#include "calls.h"

static struct small_memory memory;

static void one_job(void) {
    red_scheduler scheduler = open_small(&memory, 1);
    const uint32_t task = add_simple_task(&scheduler, 50 * MS);
    uint32_t job = 0, same = 0, count = 7;
    uint64_t at = 0;
    CALL(RED_OK, red_scheduler_poll_at, &scheduler, &at);
    EXPECT(at == RED_NONE_64);
    CALL(RED_STATUS_UNKNOWN_TASK, red_scheduler_release, &scheduler, task + 1, MS, &job);
    CALL(RED_OK, red_scheduler_release, &scheduler, task, MS, &job);
    CALL(RED_OK, red_scheduler_job, &scheduler, task, 0, &same);
    EXPECT(job == same);
    CALL(RED_STATUS_UNKNOWN_JOB, red_scheduler_job, &scheduler, task, 1, &same);

    const red_action action = poll(&scheduler, MS, RED_ACTION_KIND_DISPATCH);
    EXPECT(action.lane == 0 && (action.unit >> 8 & 0xff) == 0);
    red_unit unit = RED_UNIT_INIT;
    CALL(RED_OK, red_scheduler_unit, &scheduler, action.unit, &unit);
    EXPECT(unit.first.task == task && unit.first.deadline_ns == 51 * MS && unit.started_ns == MS);
    EXPECT(unit.wcet_ns == 4 * MS && unit.output == RED_NONE && unit.pool == 0);
    CALL(RED_STATUS_NOT_RUNNING, red_scheduler_unit, &scheduler, action.unit + (1 << 16), &unit);
    red_member members[2];
    size_t len = 0;
    CALL(RED_OK, red_scheduler_members, &scheduler, action.unit, members, 2, &len);
    EXPECT(len == 1 && members[0].job == job && members[0].release_ns == MS);
    CALL(RED_STATUS_TOO_SHORT, red_scheduler_members, &scheduler, action.unit, NULL, 0, &len);
    CALL(RED_STATUS_NOT_RUNNING, red_scheduler_members, &scheduler, 0, members, 2, &len);

    CALL(RED_OK, red_scheduler_complete, &scheduler, action.unit, 4 * MS);
    CALL(RED_STATUS_STALE, red_scheduler_complete, &scheduler, action.unit, 4 * MS);
    CALL(RED_STATUS_NOT_RUNNING, red_scheduler_complete, &scheduler, action.unit + (1 << 16), 4 * MS);
    red_outcome outcome;
    CALL(RED_OK, red_scheduler_take_outcome, &scheduler, &outcome, &count);
    EXPECT(count == 1 && outcome.job == job && outcome.shed == RED_SHED_NOT && outcome.at_ns == 4 * MS);
    CALL(RED_OK, red_scheduler_take_outcome, &scheduler, &outcome, &count);
    EXPECT(count == 0);
    poll(&scheduler, 4 * MS, RED_ACTION_KIND_NOTHING);

    red_executions executions = RED_EXECUTIONS_INIT;
    CALL(RED_OK, red_scheduler_executions, &scheduler, task, 0, &executions);
    EXPECT(executions.minimum_ns == 3 * MS && executions.maximum_ns == 3 * MS && executions.mean_ns == 3 * MS);
    CALL(RED_STATUS_UNKNOWN_NODE, red_scheduler_executions, &scheduler, task, 1, &executions);
    CALL(RED_STATUS_UNKNOWN_NODE, red_scheduler_executions, &scheduler, task + 1, 0, &executions);

    red_event events[4];
    CALL(RED_OK, red_scheduler_take_events, &scheduler, events, 4, &len);
    EXPECT(len == 4 && events[0].kind == RED_EVENT_KIND_RELEASED && events[1].kind == RED_EVENT_KIND_STARTED);
    EXPECT(events[2].kind == RED_EVENT_KIND_COMPLETED && events[3].kind == RED_EVENT_KIND_ENDED);
    CALL(RED_OK, red_scheduler_take_events, &scheduler, events, 4, &len);
    EXPECT(len == 0);
    CALL(RED_OK, red_scheduler_close, &scheduler);
}

static void failures(void) {
    red_scheduler scheduler = open_small(&memory, 1);
    const uint32_t task = add_simple_task(&scheduler, 50 * MS);
    uint32_t job = 0;
    CALL(RED_OK, red_scheduler_release, &scheduler, task, 0, &job);
    uint64_t unit = poll(&scheduler, 0, RED_ACTION_KIND_DISPATCH).unit;
    CALL(RED_STATUS_NOT_RUNNING, red_scheduler_fail, &scheduler, unit + (1 << 16), MS);
    CALL(RED_OK, red_scheduler_fail, &scheduler, unit, MS);
    CALL(RED_STATUS_STALE, red_scheduler_fail, &scheduler, unit, MS);
    EXPECT(poll(&scheduler, MS, RED_ACTION_KIND_ENDED).outcome.shed == RED_SHED_FAULT);

    /* Whose jobs were given up while it ran is late, and its lane is free again. */
    red_action next;
    for (int way = 0; way < 3; way++) {
        const uint32_t victim = add_simple_task(&scheduler, 50 * MS);
        CALL(RED_OK, red_scheduler_release, &scheduler, victim, MS, &job);
        unit = poll(&scheduler, MS, RED_ACTION_KIND_DISPATCH).unit;
        CALL(RED_OK, red_scheduler_remove_task, &scheduler, victim, MS);
        red_unit data = RED_UNIT_INIT;
        CALL(RED_STATUS_NOT_RUNNING, red_scheduler_unit, &scheduler, unit, &data);
        if (way == 0) CALL(RED_STATUS_LATE, red_scheduler_complete, &scheduler, unit, MS);
        if (way == 1) CALL(RED_STATUS_LATE, red_scheduler_fail, &scheduler, unit, MS);
        if (way == 2) CALL(RED_STATUS_LATE, red_scheduler_complete_and_poll, &scheduler, unit, MS, &next);
        poll(&scheduler, MS, RED_ACTION_KIND_ENDED);
    }
    red_figures figures = RED_FIGURES_INIT;
    CALL(RED_OK, red_scheduler_figures, &scheduler, &figures);
    EXPECT(figures.late_completions == 3 && figures.running == 0 && figures.jobs_in_flight == 0);
    EXPECT(figures.units == 4 && figures.lanes == 1);

    CALL(RED_OK, red_scheduler_release, &scheduler, task, 2 * MS, &job);
    CALL(RED_OK, red_scheduler_release, &scheduler, task, 2 * MS, &job);
    unit = poll(&scheduler, 2 * MS, RED_ACTION_KIND_DISPATCH).unit;
    CALL(RED_STATUS_NOT_RUNNING, red_scheduler_complete_and_poll, &scheduler, unit + (1 << 16), 3 * MS, &next);
    CALL(RED_OK, red_scheduler_complete_and_poll, &scheduler, unit, 3 * MS, &next);
    EXPECT(next.kind == RED_ACTION_KIND_ENDED && next.outcome.index == 1);
    CALL(RED_STATUS_STALE, red_scheduler_complete_and_poll, &scheduler, unit, 3 * MS, &next);
    CALL(RED_OK, red_scheduler_poll_on, &scheduler, 0, 3 * MS, &next);
    EXPECT(next.kind == RED_ACTION_KIND_DISPATCH);
    CALL(RED_STATUS_UNKNOWN_LANE, red_scheduler_poll_on, &scheduler, 256, 3 * MS, &next);
    CALL(RED_OK, red_scheduler_close, &scheduler);
}

/* Of two jobs of which one lane ends one in time, the other is warned of at once, and because of whom. It stays: it costs
 * nobody anything. */
static void early_warning(void) {
    red_scheduler scheduler = open_small(&memory, 1);
    const uint32_t first = add_simple_task(&scheduler, 6 * MS), second = add_simple_task(&scheduler, 7 * MS);
    uint32_t job = 0, other = 0, count = 7;
    red_warning warning;
    CALL(RED_OK, red_scheduler_release, &scheduler, first, MS, &job);
    CALL(RED_OK, red_scheduler_release, &scheduler, second, MS, &other);
    CALL(RED_OK, red_scheduler_take_warning, &scheduler, &warning, &count);
    EXPECT(count == 0);
    poll(&scheduler, MS, RED_ACTION_KIND_DISPATCH);
    CALL(RED_OK, red_scheduler_take_warning, &scheduler, &warning, &count);
    EXPECT(count == 1 && warning.task == second && warning.job == other && warning.index == 0);
    EXPECT(warning.because_task == first && warning.because_index == 0 && warning.reserved == 0);
    EXPECT(warning.at_ns == MS && warning.deadline_ns == 8 * MS && warning.by_ns == MS);
    CALL(RED_OK, red_scheduler_take_warning, &scheduler, &warning, &count);
    EXPECT(count == 0);
    red_event events[4];
    size_t len = 0;
    CALL(RED_OK, red_scheduler_take_events, &scheduler, events, 4, &len);
    EXPECT(len == 4 && events[2].kind == RED_EVENT_KIND_WARNED && events[2].task == second);
    CALL(RED_OK, red_scheduler_close, &scheduler);
}

static void limits(void) {
    red_scheduler scheduler = open_small(&memory, 2);
    const uint32_t task = add_simple_task(&scheduler, 100 * MS);
    const uint64_t end = UINT64_C(1) << 63;
    uint32_t job = 0;
    CALL(RED_STATUS_TIME_OVERFLOW, red_scheduler_release_at, &scheduler, task, end, RED_NONE_64, 0, &job);
    CALL(RED_STATUS_UNKNOWN_TASK, red_scheduler_release_at, &scheduler, RED_NONE, 0, RED_NONE_64, 0, &job);
    for (uint64_t i = 0; i < 16; i++)
        CALL(RED_OK, red_scheduler_release_at, &scheduler, task, 10 * MS - i, i, 10 * MS, &job);
    CALL(RED_STATUS_JOBS_FULL, red_scheduler_release, &scheduler, task, 10 * MS, &job);
    CALL(RED_STATUS_JOBS_FULL, red_scheduler_release_at, &scheduler, task, 10 * MS, 0, 10 * MS, &job);

    const red_action action = poll(&scheduler, 10 * MS, RED_ACTION_KIND_DISPATCH);
    CALL(RED_STATUS_UNKNOWN_LANE, red_scheduler_retire_lane, &scheduler, action.lane);
    CALL(RED_STATUS_UNKNOWN_LANE, red_scheduler_retire_lane, &scheduler, 9);
    CALL(RED_STATUS_UNKNOWN_LANE, red_scheduler_restore_lane, &scheduler, 1);
    CALL(RED_OK, red_scheduler_retire_lane, &scheduler, 1);
    poll(&scheduler, 10 * MS, RED_ACTION_KIND_NOTHING);
    CALL(RED_OK, red_scheduler_restore_lane, &scheduler, 1);
    EXPECT(poll(&scheduler, 10 * MS, RED_ACTION_KIND_DISPATCH).lane == 1);

    /* The time of a call that is refused counts: now every job is hopeless. */
    CALL(RED_STATUS_TIME_OVERFLOW, red_scheduler_release, &scheduler, task, end, &job);
    EXPECT(poll(&scheduler, 10 * MS, RED_ACTION_KIND_ENDED).outcome.shed == RED_SHED_HOPELESS);
    CALL(RED_OK, red_scheduler_close, &scheduler);
}

/* A unit goes to its lane while what comes before it runs; then the pool is lost. */
static void ahead(void) {
    red_scheduler scheduler = open_small(&memory, 2);
    CALL(RED_STATUS_UNKNOWN_POOL, red_scheduler_dispatch_ahead, &scheduler, 1);
    CALL(RED_OK, red_scheduler_dispatch_ahead, &scheduler, 0);
    struct small_dag_memory dag_memory;
    red_dag dag = open_small_dag(&dag_memory);
    const uint32_t nodes[4] = {add(&dag, node_of(2 * MS)), add(&dag, node_of(MS)), add(&dag, node_of(MS)), add(&dag, node_of(MS))};
    for (int i = 1; i < 4; i++) CALL(RED_OK, red_dag_add_edge, &dag, nodes[0], nodes[i]);
    const red_timing timing = timing_of(50 * MS);
    uint32_t task = RED_NONE, job = 0;
    CALL(RED_OK, red_scheduler_add_task, &scheduler, &dag, &timing, &task);
    CALL(RED_OK, red_dag_close, &dag);
    CALL(RED_OK, red_scheduler_release, &scheduler, task, 0, &job);
    const uint64_t first = poll(&scheduler, 0, RED_ACTION_KIND_DISPATCH).unit;
    const red_action behind = poll(&scheduler, 0, RED_ACTION_KIND_AHEAD), beside = poll(&scheduler, 0, RED_ACTION_KIND_AHEAD);
    EXPECT(behind.lane == 0 && beside.lane == 1);
    poll(&scheduler, 0, RED_ACTION_KIND_NOTHING);
    uint64_t units[2] = {7, 7};
    size_t count = 7;
    CALL(RED_OK, red_scheduler_waits_for, &scheduler, behind.unit, units, 2, &count);
    EXPECT(count == 0 && units[0] == 7);
    CALL(RED_STATUS_TOO_SHORT, red_scheduler_waits_for, &scheduler, beside.unit, units, 0, &count);
    EXPECT(count == 1 && units[0] == 7);
    CALL(RED_OK, red_scheduler_waits_for, &scheduler, beside.unit, units, 2, &count);
    EXPECT(count == 1 && units[0] == first && units[1] == 7);
    CALL(RED_OK, red_scheduler_complete, &scheduler, first, 2 * MS);
    CALL(RED_OK, red_scheduler_waits_for, &scheduler, beside.unit, units, 2, &count);
    EXPECT(count == 0);
    CALL(RED_STATUS_NOT_RUNNING, red_scheduler_waits_for, &scheduler, first, units, 2, &count);

    CALL(RED_STATUS_UNKNOWN_POOL, red_scheduler_lose_pool, &scheduler, 1, 2 * MS);
    CALL(RED_OK, red_scheduler_lose_pool, &scheduler, 0, 2 * MS);
    EXPECT(poll(&scheduler, 2 * MS, RED_ACTION_KIND_ENDED).outcome.shed == RED_SHED_FAULT);
    CALL(RED_STATUS_LATE, red_scheduler_fail, &scheduler, behind.unit, 2 * MS);
    CALL(RED_STATUS_LATE, red_scheduler_fail, &scheduler, beside.unit, 2 * MS);
    CALL(RED_OK, red_scheduler_release, &scheduler, task, 3 * MS, &job);
    EXPECT(poll(&scheduler, 3 * MS, RED_ACTION_KIND_ENDED).outcome.shed == RED_SHED_FAULT);
    poll(&scheduler, 3 * MS, RED_ACTION_KIND_NOTHING);
    CALL(RED_OK, red_scheduler_close, &scheduler);

    red_config config = preset(RED_PRESET_RED_FG);
    CALL(RED_OK, red_scheduler_open_4x16x16, memory.bytes, sizeof memory.bytes, &config, &scheduler);
    CALL(RED_STATUS_NOT_AHEAD, red_scheduler_dispatch_ahead, &scheduler, 0);
    CALL(RED_OK, red_scheduler_close, &scheduler);
}

/* A smaller key takes the lane; what ran goes on as another unit. */
static void preemption(void) {
    red_config config = preset(RED_PRESET_EDF);
    config.preempt = 1;
    red_scheduler scheduler = {0};
    CALL(RED_OK, red_scheduler_open_4x16x16, &memory, sizeof memory, &config, &scheduler);
    const uint32_t slow = add_simple_task(&scheduler, 50 * MS), fast = add_simple_task(&scheduler, 5 * MS);
    uint32_t job = 0;
    CALL(RED_OK, red_scheduler_release, &scheduler, slow, 0, &job);
    const uint64_t first = poll(&scheduler, 0, RED_ACTION_KIND_DISPATCH).unit;
    CALL(RED_OK, red_scheduler_release, &scheduler, fast, MS, &job);
    EXPECT(poll(&scheduler, MS, RED_ACTION_KIND_PREEMPT).unit == first);
    const uint64_t second = poll(&scheduler, MS, RED_ACTION_KIND_DISPATCH).unit;
    CALL(RED_STATUS_STALE, red_scheduler_complete, &scheduler, first, 2 * MS);
    CALL(RED_OK, red_scheduler_complete, &scheduler, second, 2 * MS);
    CALL(RED_OK, red_scheduler_close, &scheduler);
}

void test_loop(void) {
    one_job();
    failures();
    early_warning();
    limits();
    ahead();
    preemption();
}
