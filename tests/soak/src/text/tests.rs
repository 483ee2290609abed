use super::*;
use red_tests::rng::{Shape, random_workload};
use red_workload::{Format, parse};

#[test]
fn a_workload_is_read_as_it_was_written() {
    for seed in 0..300 {
        let workload = random_workload(seed, &Shape { nodes: 12, ..Shape::default() });
        let text = toml(&workload);
        let read = parse(text.as_bytes(), Format::Toml, "random").unwrap_or_else(|e| panic!("{e}\n{text}"));
        assert_eq!(read, workload, "seed {seed}\n{text}");
    }
}
