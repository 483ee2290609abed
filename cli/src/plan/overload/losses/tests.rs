use super::*;

/// Jobs that are due one after the other, on time (`+`), given up (`-`) or not decided (`?`).
fn jobs(ends: &str) -> Vec<JobEnd> {
    let job = |(i, end): (usize, char)| {
        let release_ns = i as u64 * 10;
        let deadline_ns = release_ns + 10;
        let (at_ns, shed) = match end {
            '+' => (Some(release_ns + 5), None),
            '-' => (Some(release_ns + 5), Some(ShedReason::Overload)),
            _ => (None, None),
        };
        JobEnd { release_ns, deadline_ns, at_ns, shed }
    };
    ends.chars().enumerate().map(job).collect()
}

fn worst(m: u32, k: u32, ends: &str) -> (u32, bool) {
    let floor = Floor::of(m, k, &jobs(ends), ends.len() as u64 * 10);
    (floor.worst, floor.kept)
}

#[test]
fn the_worst_window_is_the_one_with_fewest_on_time() {
    assert_eq!(worst(3, 4, "++++++"), (4, true));
    assert_eq!(worst(3, 4, "+-+++-++"), (3, true));
    assert_eq!(worst(3, 4, "+-++-+++"), (2, false));
    assert_eq!(worst(0, 2, "----"), (0, true));
}

#[test]
fn a_window_that_is_not_full_has_lost_only_what_it_lost() {
    assert_eq!(worst(1, 4, "-"), (3, true));
    assert_eq!(worst(1, 4, "---?"), (1, true));
}
