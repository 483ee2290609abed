//! What the stand-in driver wrote, read by the rules: what ran on a stream ran after what it had to, and a stream was told
//! to wait only where it must.

use std::collections::{HashMap, HashSet};

/// Kernels of which the second may run only after the first.
pub(crate) type Edges<'a> = HashSet<(&'a str, &'a str)>;

/// A line, in words.
fn words(line: &str) -> Vec<&str> {
    line.split(' ').collect()
}

/// Where the warm-up of all bodies is over: the lanes' own streams are made after it, and no later ones.
pub(crate) fn warm(log: &[String]) -> usize {
    let made = |line: &String| line.starts_with("call cuStreamCreateWithPriority");
    log.iter().rposition(made).expect("a lane has a stream")
}

/// How often each kernel ran, and panics if one began before the end of another that it depends on. The n-th run of a
/// kernel is of the n-th job.
pub(crate) fn precedence<'l>(log: &'l [String], edges: &Edges<'_>) -> HashMap<&'l str, usize> {
    let (mut begun, mut ended): (HashMap<&str, usize>, HashMap<&str, usize>) = Default::default();
    for line in log {
        match words(line)[..] {
            ["begin", _, kernel] => {
                let count = begun.entry(kernel).or_default();
                *count += 1;
                for (from, _) in edges.iter().filter(|(_, to)| *to == kernel) {
                    let before = ended.get(from).copied().unwrap_or_default();
                    assert!(
                        before >= *count,
                        "run {count} of {kernel} begins after {before} of {from} ended"
                    );
                }
            }
            ["end", _, kernel] => *ended.entry(kernel).or_default() += 1,
            _ => {}
        }
    }
    ended
}

/// A mark in a stream: whose, the how-manieth there, the kernel before it, and what the stream follows by then.
#[derive(Clone, Debug, Default)]
struct Mark<'l> {
    stream: &'l str,
    turn: usize,
    kernel: &'l str,
    follows: HashMap<&'l str, usize>,
}

/// How many waits there are, and panics at one that no edge across streams needs, or that an earlier one implies.
/// Streams that mark nothing are not the lanes': warm-up, and where the driver is asked to ring.
pub(crate) fn waits(log: &[String], edges: &Edges<'_>) -> usize {
    let marking: HashSet<&str> = log
        .iter()
        .filter_map(|line| match words(line)[..] {
            ["call", "cuEventRecord", stream, ..] => Some(stream),
            _ => None,
        })
        .collect();
    let mut streams: HashMap<&str, Mark<'_>> = HashMap::new();
    let mut marks: HashMap<&str, Mark<'_>> = HashMap::new();
    // Waited for since the last kernel, by stream.
    let mut waited: HashMap<&str, Vec<&str>> = HashMap::new();
    let mut count = 0;
    for line in log {
        match words(line)[..] {
            ["call", "cuLaunchKernel", stream, kernel, "=", "0"] if marking.contains(stream) => {
                for from in waited.remove(stream).unwrap_or_default() {
                    assert!(
                        edges.contains(&(from, kernel)),
                        "{kernel} waits for {from}, of which it needs nothing"
                    );
                }
                streams.entry(stream).or_default().kernel = kernel;
            }
            ["call", "cuEventRecord", stream, event, "=", "0"] => {
                let of = streams.entry(stream).or_default();
                of.stream = stream;
                of.turn += 1;
                of.follows.insert(stream, of.turn);
                marks.insert(event, of.clone());
            }
            ["call", "cuStreamWaitEvent", stream, event, "=", "0"] if marking.contains(stream) => {
                let mark = marks.get(event).unwrap_or_else(|| panic!("{line}: nothing was recorded"));
                assert_ne!(mark.stream, stream, "{line}: its own order is enough");
                let of = streams.entry(stream).or_default();
                let follows = of.follows.get(mark.stream).copied().unwrap_or_default();
                assert!(follows < mark.turn, "{line}: implied by what it waited for before");
                for (other, turn) in &mark.follows {
                    let known = of.follows.entry(other).or_default();
                    *known = (*known).max(*turn);
                }
                waited.entry(stream).or_default().push(mark.kernel);
                count += 1;
            }
            _ => {}
        }
    }
    count
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lines(text: &str) -> Vec<String> {
        text.split('/').map(str::to_owned).collect()
    }

    const RECORD: &str = "call cuLaunchKernel 1 a = 0/call cuEventRecord 1 event1 = 0";

    fn edges() -> Edges<'static> {
        Edges::from([("a", "b")])
    }

    #[test]
    #[should_panic(expected = "begins after 0")]
    fn a_run_before_its_predecessor_is_seen() {
        precedence(&lines("begin 1 a/begin 2 b/end 1 a"), &edges());
    }

    #[test]
    fn waits_across_streams_are_counted() {
        let log = format!(
            "{RECORD}/call cuStreamWaitEvent 2 event1 = 0/call cuLaunchKernel 2 b = 0/call cuEventRecord 2 event2 = 0"
        );
        assert_eq!(waits(&lines(&log), &edges()), 1);
    }

    #[test]
    #[should_panic(expected = "its own order is enough")]
    fn a_wait_on_the_same_stream_is_seen() {
        waits(&lines(&format!("{RECORD}/call cuStreamWaitEvent 1 event1 = 0")), &edges());
    }

    #[test]
    #[should_panic(expected = "implied")]
    fn a_wait_that_is_implied_is_seen() {
        let wait = "call cuStreamWaitEvent 2 event1 = 0";
        waits(&lines(&format!("{RECORD}/{wait}/{wait}/call cuEventRecord 2 event2 = 0")), &edges());
    }

    #[test]
    #[should_panic(expected = "of which it needs nothing")]
    fn a_wait_that_no_edge_needs_is_seen() {
        let log = format!(
            "{RECORD}/call cuStreamWaitEvent 2 event1 = 0/call cuLaunchKernel 2 c = 0/call cuEventRecord 2 event2 = 0"
        );
        waits(&lines(&log), &edges());
    }
}
