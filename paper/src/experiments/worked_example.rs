//! Section 4.2: a chain of 20, 20 and 40 s within 120 s.

use crate::run::{PaperError, Run};
use crate::table::{Cell, Claim, Column, Table, Verdict};
use red_core::{Caps, Dag, DeadlineRule, Duration, Levels, Node, SubDeadlines, Wcet, shares};

/// Costs, level shares and sub-deadlines of the paper, in seconds.
const PAPER: [(&str, u64, u64, u64); 3] = [("A", 20, 30, 30), ("B", 20, 30, 60), ("C", 40, 60, 120)];
const DEADLINE_S: u64 = 120;
const S: u64 = 1_000_000_000;

pub(super) fn run(run: &Run<'_>) -> Result<Table, PaperError> {
    let rows = run.each(&[()], |()| Ok(rows()))?.concat();
    let exact = rows.iter().all(|row| row.last() == Some(&Verdict::Reproduced.into()));
    Ok(Table {
        name: "worked-example",
        title: "The worked example",
        source: "section 4.2",
        about: vec![
            "The chain A, B, C under the rule of Definition 4, by the scheduler's own function.".to_owned(),
        ],
        columns: vec![
            Column::words("node"),
            Column::numbers("cost", "s", 0),
            Column::numbers("share, paper", "s", 0),
            Column::numbers("share", "s", 0),
            Column::numbers("due, paper", "s", 0),
            Column::numbers("due", "s", 0),
            Column::words("verdict"),
        ],
        rows,
        claims: vec![Claim {
            claim: "shares of 30, 30 and 60 s sum to the deadline".to_owned(),
            paper: "120 s".to_owned(),
            ours: if exact { "120 s" } else { "another sum" }.to_owned(),
            verdict: if exact { Verdict::Reproduced } else { Verdict::NotReproducible },
            why: "rounded up to the prefix, not level by level, so the sum is exact for every graph",
        }],
    })
}

fn rows() -> Vec<Vec<Cell>> {
    let mut chain = Dag::<Caps<1, 4, 1>>::new();
    let nodes = PAPER.map(|(_, cost, _, _)| chain.add_node(Node::new(Wcet::from_nanos(cost * S))));
    let nodes = nodes.map(|node| node.unwrap_or(red_core::NodeId::new(0)));
    for pair in nodes.windows(2) {
        let _it_is_a_chain = chain.add_edge(pair[0], pair[1]);
    }
    let (levels, deadline) = (Levels::of(&chain), Duration::from_nanos(DEADLINE_S * S));
    let shares = shares(&levels, DeadlineRule::LevelSum, deadline, &[1]);
    let due = SubDeadlines::assign(&levels, DeadlineRule::LevelSum, deadline, &[1]);
    let row = |(level, node): (usize, red_core::NodeId)| {
        let (name, cost, share, end) = PAPER[level];
        let (our_share, our_end) = (shares[level].share, due.sub_deadline(node));
        let exact = our_share == share * S && our_end == (end * S).cast_signed();
        let verdict = if exact { Verdict::Reproduced } else { Verdict::NotReproducible };
        vec![
            Cell::from(name),
            Cell::from(cost as f64),
            Cell::from(share as f64),
            Cell::from(our_share as f64 / S as f64),
            Cell::from(end as f64),
            Cell::from(our_end as f64 / S as f64),
            Cell::from(verdict),
        ]
    };
    nodes.into_iter().enumerate().map(row).collect()
}
