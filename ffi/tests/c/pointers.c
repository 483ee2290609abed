/* Pointers that can be seen to be wrong: NULL and misaligned, for each pointer of each function; nothing has changed then. */
#include "calls.h"

static struct small_memory memory;
static struct small_dag_memory dag_memory, edit_memory;

static red_dag dag;
static red_scheduler scheduler;

static void of_graphs(void) {
    const red_node node = node_of(MS), encoder = encoder_of(MS, 0, RED_NONE), decoders[] = {decoder_of(MS)};
    uint32_t number = 7, lane = 1, found[16];
    size_t count = 7;
    uint64_t budget = RED_NONE_64;
    red_placed_node placed[16];
    red_level levels[16];
    red_certificate proof = RED_CERTIFICATE_INIT;
    red_dag_summary summary = RED_DAG_SUMMARY_INIT;
    red_node data = RED_NODE_INIT;
    WRONG(red_config, red_config_preset, 0, X);
    WRONG(red_dag, red_dag_open_4x16x16, &edit_memory, sizeof edit_memory, X);
    WRONG(red_dag, red_dag_close, X);
    WRONG(red_dag, red_dag_add_node, X, &node, &number);
    WRONG(red_node, red_dag_add_node, &dag, X, &number);
    WRONG(uint32_t, red_dag_add_node, &dag, &node, X);
    WRONG(red_dag, red_dag_add_edge, X, 0, 1);
    WRONG(red_dag, red_dag_remove_node, X, 0);
    WRONG(red_dag, red_dag_remove_edge, X, 0, 1);
    WRONG(red_dag, red_dag_refine, X, 0, &encoder, decoders, 1, &number);
    WRONG(red_node, red_dag_refine, &dag, 0, X, decoders, 1, &number);
    WRONG(red_node, red_dag_refine, &dag, 0, &encoder, X, 1, &number);
    WRONG(uint32_t, red_dag_refine, &dag, 0, &encoder, decoders, 1, X);
    WRONG(red_dag, red_dag_summarize, X, &summary);
    WRONG(red_dag_summary, red_dag_summarize, &dag, X);
    WRONG(red_dag, red_dag_node, X, 0, &data);
    WRONG(red_node, red_dag_node, &dag, 0, X);
    WRONG(red_dag, red_dag_successors, X, 0, found, 16, &count);
    WRONG(uint32_t, red_dag_successors, &dag, 0, X, 16, &count);
    WRONG(size_t, red_dag_successors, &dag, 0, found, 16, X);
    WRONG(red_dag, red_dag_place, X, 0, SECOND, NULL, 0, placed, 16, &count);
    WRONG(uint32_t, red_dag_place, &dag, 0, SECOND, X, 1, placed, 16, &count);
    WRONG(red_placed_node, red_dag_place, &dag, 0, SECOND, NULL, 0, X, 16, &count);
    WRONG(size_t, red_dag_place, &dag, 0, SECOND, NULL, 0, placed, 16, X);
    WRONG(red_dag, red_dag_share, X, RED_RULE_LEVEL_SUM, SECOND, NULL, 0, levels, 16, &count);
    WRONG(uint32_t, red_dag_share, &dag, RED_RULE_LEVEL_SUM, SECOND, X, 1, levels, 16, &count);
    WRONG(red_level, red_dag_share, &dag, RED_RULE_LEVEL_SUM, SECOND, NULL, 0, X, 16, &count);
    WRONG(size_t, red_dag_share, &dag, RED_RULE_LEVEL_SUM, SECOND, NULL, 0, levels, 16, X);
    WRONG(red_dag, red_dag_prove, X, SECOND, &lane, &budget, 1, &proof);
    WRONG(uint32_t, red_dag_prove, &dag, SECOND, X, &budget, 1, &proof);
    WRONG(uint64_t, red_dag_prove, &dag, SECOND, &lane, X, 1, &proof);
    WRONG(red_certificate, red_dag_prove, &dag, SECOND, &lane, &budget, 1, X);
    EXPECT(number == 7 && count == 7);
    CALL(RED_OK, red_dag_summarize, &dag, &summary);
    EXPECT(summary.nodes == 2);
}

static void of_schedulers(void) {
    const red_timing timing = timing_of(SECOND);
    red_config config = preset(RED_PRESET_REDRT);
    red_dag edit = {0};
    red_scheduler other = {0};
    red_certificate proof = RED_CERTIFICATE_INIT;
    uint32_t number = 7;
    uint64_t bytes = 7;
    static struct small_memory more;
    WRONG(red_config, red_scheduler_open_4x16x16, &more, sizeof more, X, &other);
    WRONG(red_scheduler, red_scheduler_open_4x16x16, &more, sizeof more, &config, X);
    WRONG(red_scheduler, red_scheduler_close, X);
    WRONG(red_scheduler, red_scheduler_add_pool, X, 1, 0, &number);
    WRONG(uint32_t, red_scheduler_add_pool, &scheduler, 1, 0, X);
    WRONG(red_scheduler, red_scheduler_add_sensor, X, MS, &number);
    WRONG(uint32_t, red_scheduler_add_sensor, &scheduler, MS, X);
    WRONG(red_scheduler, red_scheduler_config, X, &config);
    WRONG(red_config, red_scheduler_config, &scheduler, X);
    WRONG(red_scheduler, red_scheduler_memory_used, X, 0, &bytes);
    WRONG(uint64_t, red_scheduler_memory_used, &scheduler, 0, X);
    WRONG(red_scheduler, red_scheduler_add_task, X, &dag, &timing, &number);
    WRONG(red_dag, red_scheduler_add_task, &scheduler, X, &timing, &number);
    WRONG(red_timing, red_scheduler_add_task, &scheduler, &dag, X, &number);
    WRONG(uint32_t, red_scheduler_add_task, &scheduler, &dag, &timing, X);
    const uint32_t task = add_simple_task(&scheduler, SECOND);
    WRONG(red_scheduler, red_scheduler_remove_task, X, task, 0);
    WRONG(red_scheduler, red_scheduler_certificate, X, task, &proof);
    WRONG(red_certificate, red_scheduler_certificate, &scheduler, task, X);
    WRONG(red_scheduler, red_scheduler_edit, X, task, &edit_memory, sizeof edit_memory, &edit);
    WRONG(red_dag, red_scheduler_edit, &scheduler, task, &edit_memory, sizeof edit_memory, X);
    CALL(RED_OK, red_scheduler_edit, &scheduler, task, &edit_memory, sizeof edit_memory, &edit);
    WRONG(red_scheduler, red_scheduler_commit, X, &edit, 0, &proof);
    WRONG(red_dag, red_scheduler_commit, &scheduler, X, 0, &proof);
    WRONG(red_certificate, red_scheduler_commit, &scheduler, &edit, 0, X);
    CALL(RED_OK, red_dag_close, &edit);
    EXPECT(number == 7 && bytes == 7);
}

static void of_the_loop(void) {
    red_action action = {0};
    red_outcome outcome;
    red_unit data = RED_UNIT_INIT;
    red_member members[4];
    red_executions executions = RED_EXECUTIONS_INIT;
    red_figures figures = RED_FIGURES_INIT;
    red_event events[4];
    uint32_t number = 7;
    uint64_t at = 7;
    size_t count = 7;
    const uint32_t task = add_simple_task(&scheduler, SECOND);
    WRONG(red_scheduler, red_scheduler_release, X, task, 0, &number);
    WRONG(uint32_t, red_scheduler_release, &scheduler, task, 0, X);
    WRONG(red_scheduler, red_scheduler_release_at, X, task, 0, 0, 0, &number);
    WRONG(uint32_t, red_scheduler_release_at, &scheduler, task, 0, 0, 0, X);
    EXPECT(number == 7);
    CALL(RED_OK, red_scheduler_release, &scheduler, task, 0, &number);
    WRONG(red_scheduler, red_scheduler_poll, X, 0, &action);
    WRONG(red_action, red_scheduler_poll, &scheduler, 0, X);
    WRONG(red_scheduler, red_scheduler_poll_on, X, 0, 0, &action);
    WRONG(red_action, red_scheduler_poll_on, &scheduler, 0, 0, X);
    const uint64_t unit = poll(&scheduler, 0, RED_ACTION_KIND_DISPATCH).unit;
    WRONG(red_scheduler, red_scheduler_unit, X, unit, &data);
    WRONG(red_unit, red_scheduler_unit, &scheduler, unit, X);
    WRONG(red_scheduler, red_scheduler_members, X, unit, members, 4, &count);
    WRONG(red_member, red_scheduler_members, &scheduler, unit, X, 4, &count);
    WRONG(size_t, red_scheduler_members, &scheduler, unit, members, 4, X);
    uint64_t units[4];
    WRONG(red_scheduler, red_scheduler_waits_for, X, unit, units, 4, &count);
    WRONG(uint64_t, red_scheduler_waits_for, &scheduler, unit, X, 4, &count);
    WRONG(size_t, red_scheduler_waits_for, &scheduler, unit, units, 4, X);
    WRONG(red_scheduler, red_scheduler_job, X, task, 0, &number);
    WRONG(uint32_t, red_scheduler_job, &scheduler, task, 0, X);
    WRONG(red_scheduler, red_scheduler_executions, X, task, 0, &executions);
    WRONG(red_executions, red_scheduler_executions, &scheduler, task, 0, X);
    WRONG(red_scheduler, red_scheduler_complete, X, unit, 0);
    WRONG(red_scheduler, red_scheduler_complete_and_poll, X, unit, 0, &action);
    WRONG(red_action, red_scheduler_complete_and_poll, &scheduler, unit, 0, X);
    WRONG(red_scheduler, red_scheduler_fail, X, unit, 0);
    WRONG(red_scheduler, red_scheduler_poll_at, X, &at);
    WRONG(uint64_t, red_scheduler_poll_at, &scheduler, X);
    WRONG(red_scheduler, red_scheduler_figures, X, &figures);
    WRONG(red_figures, red_scheduler_figures, &scheduler, X);
    WRONG(red_scheduler, red_scheduler_retire_lane, X, 0);
    WRONG(red_scheduler, red_scheduler_dispatch_ahead, X, 0);
    WRONG(red_scheduler, red_scheduler_lose_pool, X, 0, 0);
    WRONG(red_scheduler, red_scheduler_restore_lane, X, 0);
    /* None of these calls ended it, or took what it left. */
    CALL(RED_OK, red_scheduler_complete, &scheduler, unit, MS);
    WRONG(red_scheduler, red_scheduler_take_outcome, X, &outcome, &number);
    WRONG(red_outcome, red_scheduler_take_outcome, &scheduler, X, &number);
    WRONG(uint32_t, red_scheduler_take_outcome, &scheduler, &outcome, X);
    CALL(RED_OK, red_scheduler_take_outcome, &scheduler, &outcome, &number);
    EXPECT(number == 1);
    red_warning warning;
    WRONG(red_scheduler, red_scheduler_take_warning, X, &warning, &number);
    WRONG(red_warning, red_scheduler_take_warning, &scheduler, X, &number);
    WRONG(uint32_t, red_scheduler_take_warning, &scheduler, &warning, X);
    CALL(RED_OK, red_scheduler_take_warning, &scheduler, &warning, &number);
    EXPECT(number == 0);
    WRONG(red_scheduler, red_scheduler_take_events, X, events, 4, &count);
    WRONG(red_event, red_scheduler_take_events, &scheduler, X, 4, &count);
    WRONG(size_t, red_scheduler_take_events, &scheduler, events, 4, X);
    EXPECT(at == 7 && count == 7);
}

void test_pointers(void) {
    dag = open_small_dag(&dag_memory);
    add(&dag, node_of(MS));
    add(&dag, node_of(MS));
    scheduler = open_small(&memory, 1);
    of_graphs();
    of_schedulers();
    of_the_loop();
    CALL(RED_OK, red_dag_close, &dag);
    CALL(RED_OK, red_scheduler_close, &scheduler);
}
