/* Graphs: made, changed, looked at. */
#include "calls.h"

static struct small_dag_memory memory;

static void build(void) {
    red_dag dag = open_small_dag(&memory);
    const uint32_t camera = add(&dag, node_of(2 * MS)), network = add(&dag, node_of(8 * MS));
    CALL(RED_OK, red_dag_add_edge, &dag, camera, network);
    CALL(RED_STATUS_DUPLICATE_EDGE, red_dag_add_edge, &dag, camera, network);
    CALL(RED_STATUS_CYCLE, red_dag_add_edge, &dag, network, camera);
    CALL(RED_STATUS_UNKNOWN_NODE, red_dag_add_edge, &dag, network, 9);
    CALL(RED_STATUS_UNKNOWN_NODE, red_dag_add_edge, &dag, network, RED_NONE);
    CALL(RED_STATUS_UNKNOWN_EDGE, red_dag_remove_edge, &dag, network, camera);
    CALL(RED_STATUS_UNKNOWN_NODE, red_dag_remove_edge, &dag, network, 256);
    CALL(RED_OK, red_dag_remove_edge, &dag, camera, network);
    CALL(RED_OK, red_dag_remove_node, &dag, network);
    CALL(RED_STATUS_UNKNOWN_NODE, red_dag_remove_node, &dag, network);

    const uint32_t one = add(&dag, encoder_of(MS, 0, RED_NONE)), other = add(&dag, encoder_of(MS, 1, RED_NONE));
    const uint32_t reader = add(&dag, decoder_of(MS));
    CALL(RED_OK, red_dag_add_edge, &dag, one, reader);
    CALL(RED_STATUS_SECOND_ENCODER, red_dag_add_edge, &dag, other, reader);
    CALL(RED_OK, red_dag_close, &dag);
}

static void nodes_that_cannot_be(void) {
    red_dag dag = open_small_dag(&memory);
    uint32_t number = 7;
    red_node node = node_of(MS);
    node.role = RED_ROLE_DECODER + 1;
    CALL(RED_STATUS_OUT_OF_RANGE, red_dag_add_node, &dag, &node, &number);
    node = node_of(MS);
    node.atomic = 2;
    CALL(RED_STATUS_OUT_OF_RANGE, red_dag_add_node, &dag, &node, &number);
    node = node_of(MS);
    node.contention_ns = 1;
    CALL(RED_STATUS_OUT_OF_RANGE, red_dag_add_node, &dag, &node, &number);
    node = encoder_of(MS, 65536, RED_NONE);
    CALL(RED_STATUS_OUT_OF_RANGE, red_dag_add_node, &dag, &node, &number);
    node = encoder_of(MS, 0, RED_NONE);
    node.weights = 65536;
    CALL(RED_STATUS_OUT_OF_RANGE, red_dag_add_node, &dag, &node, &number);
    node = node_of(UINT64_MAX);
    CALL(RED_OK, red_dag_add_node, &dag, &node, &number);
    node = node_of(1);
    number = 7;
    CALL(RED_STATUS_WORK_OVERFLOW, red_dag_add_node, &dag, &node, &number);
    EXPECT(number == 7);
    CALL(RED_OK, red_dag_close, &dag);

    /* Numbers that no pool and no sensor has are found where the node is added. */
    dag = open_small_dag(&memory);
    node = node_of(MS);
    node.pool = 256;
    CALL(RED_STATUS_UNKNOWN_POOL, red_dag_add_node, &dag, &node, &number);
    node = encoder_of(MS, 0, 256);
    CALL(RED_STATUS_UNKNOWN_SENSOR, red_dag_add_node, &dag, &node, &number);

    for (int i = 0; i < 16; i++) add(&dag, node_of(MS));
    node = node_of(MS);
    CALL(RED_STATUS_NODES_FULL, red_dag_add_node, &dag, &node, &number);
    CALL(RED_OK, red_dag_close, &dag);
}

static void stages(void) {
    red_dag dag = open_small_dag(&memory);
    const uint32_t camera = add(&dag, node_of(MS)), stage = add(&dag, node_of(9 * MS)), control = add(&dag, node_of(MS));
    CALL(RED_OK, red_dag_add_edge, &dag, camera, stage);
    CALL(RED_OK, red_dag_add_edge, &dag, stage, control);
    const red_node encoder = encoder_of(4 * MS, 0, RED_NONE);
    red_node decoders[17];
    for (int i = 0; i < 17; i++) decoders[i] = decoder_of(MS);
    uint32_t number = 7;
    CALL(RED_STATUS_UNKNOWN_NODE, red_dag_refine, &dag, 9, &encoder, decoders, 2, &number);
    CALL(RED_STATUS_NO_DECODER, red_dag_refine, &dag, stage, &encoder, NULL, 0, &number);
    CALL(RED_STATUS_NODES_FULL, red_dag_refine, &dag, stage, &encoder, decoders, 17, &number);
    CALL(RED_STATUS_TOO_LONG, red_dag_refine, &dag, stage, &encoder, decoders, 257, &number);
    decoders[1].wcet_ns = UINT64_MAX;
    CALL(RED_STATUS_WORK_OVERFLOW, red_dag_refine, &dag, stage, &encoder, decoders, 2, &number);
    decoders[1] = node_of(MS);
    decoders[1].role = 9;
    CALL(RED_STATUS_OUT_OF_RANGE, red_dag_refine, &dag, stage, &encoder, decoders, 2, &number);
    decoders[1] = decoder_of(MS);
    decoders[1].pool = 256;
    CALL(RED_STATUS_UNKNOWN_POOL, red_dag_refine, &dag, stage, &encoder, decoders, 2, &number);
    const red_node unseen = encoder_of(MS, 0, 256);
    decoders[1] = decoder_of(MS);
    CALL(RED_STATUS_UNKNOWN_SENSOR, red_dag_refine, &dag, stage, &unseen, decoders, 2, &number);
    decoders[1].struct_size += 8;
    CALL(RED_STATUS_STRUCT_SIZE, red_dag_refine, &dag, stage, &encoder, decoders, 2, &number);
    decoders[1] = decoder_of(2 * MS);
    EXPECT(number == 7);
    CALL(RED_OK, red_dag_refine, &dag, stage, &encoder, decoders, 2, &number);
    EXPECT(number == stage);

    red_node data = RED_NODE_INIT;
    CALL(RED_OK, red_dag_node, &dag, number + 2, &data);
    EXPECT(data.role == RED_ROLE_DECODER && data.wcet_ns == 2 * MS);
    CALL(RED_STATUS_UNKNOWN_NODE, red_dag_node, &dag, 9, &data);

    uint32_t successors[2];
    size_t count = 0;
    CALL(RED_OK, red_dag_successors, &dag, number, successors, 2, &count);
    EXPECT(count == 2 && successors[0] == number + 1 && successors[1] == number + 2);
    CALL(RED_STATUS_TOO_SHORT, red_dag_successors, &dag, number, successors, 1, &count);
    EXPECT(count == 2);
    CALL(RED_STATUS_TOO_LONG, red_dag_successors, &dag, number, successors, SIZE_MAX, &count);
    CALL(RED_STATUS_UNKNOWN_NODE, red_dag_successors, &dag, 9, successors, 2, &count);

    red_dag_summary summary = RED_DAG_SUMMARY_INIT;
    CALL(RED_OK, red_dag_summarize, &dag, &summary);
    EXPECT(summary.nodes == 5 && summary.levels == 4);
    EXPECT(summary.work_ns == 9 * MS && summary.critical_path_ns == 8 * MS);
    CALL(RED_OK, red_dag_close, &dag);
}

/* The paper's worked example: 20, 20 and 40 s, due after 120 s. */
static void deadlines(void) {
    red_dag dag = open_small_dag(&memory);
    const uint64_t costs[] = {20 * SECOND, 20 * SECOND, 40 * SECOND};
    for (uint32_t i = 0; i < 3; i++) {
        add(&dag, node_of(costs[i]));
        if (i > 0) CALL(RED_OK, red_dag_add_edge, &dag, i - 1, i);
    }
    red_placed_node nodes[3];
    red_level levels[3];
    size_t count = 0;
    const uint64_t due = 120 * SECOND;
    CALL(RED_OK, red_dag_place, &dag, RED_RULE_LEVEL_SUM, due, NULL, 0, nodes, 3, &count);
    EXPECT(count == 3 && nodes[0].sub_deadline_ns == (int64_t)(30 * SECOND));
    EXPECT(nodes[1].sub_deadline_ns == (int64_t)(60 * SECOND) && nodes[2].sub_deadline_ns == (int64_t)due);
    EXPECT(nodes[1].node == 1 && nodes[1].height == 1 && nodes[1].tail_ns == 40 * SECOND);
    CALL(RED_OK, red_dag_place, &dag, RED_RULE_LATEST_START, 70 * SECOND, NULL, 0, nodes, 3, &count);
    EXPECT(nodes[0].sub_deadline_ns == (int64_t)(10 * SECOND) && nodes[0].key_ns == -(int64_t)(10 * SECOND));
    CALL(RED_OK, red_dag_share, &dag, RED_RULE_LEVEL_SUM, due, NULL, 0, levels, 3, &count);
    EXPECT(count == 3 && levels[0].share_ns == 30 * SECOND && levels[2].end_ns == due);

    const uint32_t no_lane = 0, lane = 1, lanes = 256, many[33] = {0};
    const uint64_t unlimited = RED_NONE_64, far = (UINT64_C(1) << 62) + 1;
    CALL(RED_STATUS_TOO_SHORT, red_dag_place, &dag, RED_RULE_LEVEL_SUM, due, NULL, 0, nodes, 2, &count);
    CALL(RED_STATUS_OUT_OF_RANGE, red_dag_place, &dag, 6, due, NULL, 0, nodes, 3, &count);
    CALL(RED_STATUS_OUT_OF_RANGE, red_dag_place, &dag, RED_RULE_LEVEL_SUM, due, &lanes, 1, nodes, 3, &count);
    CALL(RED_STATUS_DEADLINE, red_dag_place, &dag, RED_RULE_LEVEL_SUM, far, NULL, 0, nodes, 3, &count);
    CALL(RED_STATUS_NO_LANE, red_dag_place, &dag, RED_RULE_LEVEL_SUM, due, &no_lane, 1, nodes, 3, &count);
    CALL(RED_STATUS_TOO_LONG, red_dag_place, &dag, RED_RULE_LEVEL_SUM, due, many, 33, nodes, 3, &count);
    CALL(RED_STATUS_TOO_SHORT, red_dag_share, &dag, RED_RULE_LEVEL_SUM, due, NULL, 0, levels, 2, &count);
    CALL(RED_STATUS_OUT_OF_RANGE, red_dag_share, &dag, RED_RULE_LATEST_START, due, NULL, 0, levels, 3, &count);
    CALL(RED_STATUS_DEADLINE, red_dag_share, &dag, RED_RULE_LEVEL_SUM, far, NULL, 0, levels, 3, &count);
    CALL(RED_STATUS_NO_LANE, red_dag_share, &dag, RED_RULE_LEVEL_SUM, due, &no_lane, 1, levels, 3, &count);

    red_certificate proof = RED_CERTIFICATE_INIT;
    CALL(RED_OK, red_dag_prove, &dag, due, &lane, &unlimited, 1, &proof);
    EXPECT(proof.fits == 1 && proof.response_ns == 80 * SECOND && proof.margin_ns == (int64_t)(40 * SECOND));
    CALL(RED_OK, red_dag_prove, &dag, 79 * SECOND, NULL, NULL, 0, &proof);
    EXPECT(proof.fits == 0 && proof.margin_ns == -(int64_t)SECOND && proof.bound == RED_BOUND_GRAHAM);
    CALL(RED_STATUS_NO_LANE, red_dag_prove, &dag, due, &no_lane, &unlimited, 1, &proof);
    CALL(RED_STATUS_OUT_OF_RANGE, red_dag_prove, &dag, due, &lanes, &unlimited, 1, &proof);
    CALL(RED_OK, red_dag_close, &dag);
}

void test_graph(void) {
    build();
    nodes_that_cannot_be();
    stages();
    deadlines();
}
