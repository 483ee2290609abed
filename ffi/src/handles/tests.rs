use super::*;
use crate::tests::{Block, ok};
use crate::{RED_ALIGN, RED_DAG_4X16X16_BYTES, red_dag, red_dag_close, red_dag_open_4x16x16};

#[test]
fn who_claimed_a_place_in_vain_does_not_keep_it_open() {
    let memory = Block::aligned(RED_DAG_4X16X16_BYTES, RED_ALIGN);
    let mut dag = red_dag::default();
    ok(red_dag_open_4x16x16(memory.lent(0), memory.bytes(), &raw mut dag));
    // As one does who saw it free a moment ago.
    let claim = TABLE[dag.bits as usize & 0xff].claim();
    ok(red_dag_close(&raw mut dag));
    drop(claim.expect("nobody else opens here"));
}
