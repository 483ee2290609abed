use super::*;
use crate::tests::{Block, headed, ok};
use crate::*;

const NODES: usize = 255;
const JOBS: usize = 2;

#[test]
fn a_unit_of_more_members_than_a_graph_has_nodes_is_told_whole() {
    // Encoders of one frame in two jobs share one execution: more than any graph has nodes.
    let memory = Block::aligned(RED_SCHEDULER_16X256X64_BYTES, RED_ALIGN);
    let dag_memory = Block::aligned(RED_DAG_16X256X64_BYTES, RED_ALIGN);
    let (mut scheduler, mut dag) = (red_scheduler::default(), red_dag::default());
    let (mut number, mut task) = (0, 0);
    let mut config = headed!(red_config {});
    ok(red_config_preset(red_preset::Redrt as u32, &raw mut config));
    let (at, bytes) = (memory.lent(0), memory.bytes());
    ok(red_scheduler_open_16x256x64(at, bytes, &raw const config, &raw mut scheduler));
    ok(red_dag_open_16x256x64(dag_memory.lent(0), dag_memory.bytes(), &raw mut dag));
    let encoder = headed!(red_node { role: red_role::SharedEncoder as u32, wcet_ns: 10, sensor: RED_NONE });
    for _ in 0..NODES {
        ok(red_dag_add_node(&raw mut dag, &raw const encoder, &raw mut number));
    }
    let timing = headed!(red_timing { deadline_ns: 1_000_000_000, value: 1 });
    ok(red_scheduler_add_task(&raw mut scheduler, &raw const dag, &raw const timing, &raw mut task));
    for _ in 0..JOBS {
        ok(red_scheduler_release_at(&raw mut scheduler, task, 0, 7, 0, &raw mut number));
    }
    let mut action = red_action::EMPTY;
    ok(red_scheduler_poll(&raw mut scheduler, 0, &raw mut action));
    let mut members = vec![red_member::EMPTY; NODES * JOBS + 1];
    let (room, mut count) = (members.len(), 0);
    let told = members.as_mut_ptr();
    ok(red_scheduler_members(&raw const scheduler, action.unit, told, room, &raw mut count));
    assert_eq!(count, NODES * JOBS);
    assert!(members[..count].iter().all(|member| member.deadline_ns == 1_000_000_000));
    assert_eq!(members[count].deadline_ns, 0, "nothing is written behind them");
    let short = red_scheduler_members(&raw const scheduler, action.unit, told, count - 1, &raw mut count);
    assert_eq!((short, count), (red_status::TooShort, NODES * JOBS));
    ok(red_dag_close(&raw mut dag));
    ok(red_scheduler_close(&raw mut scheduler));
}
