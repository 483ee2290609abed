use super::*;
use crate::model::Figures;

fn task(responses_ns: &[u64]) -> Task {
    let response_ns =
        [responses_ns.first(), responses_ns.get(1), responses_ns.last()].map(Option::<&u64>::copied);
    let figures = Figures { response_ns, responses_ns: responses_ns.to_vec(), ..Figures::default() };
    Task { name: "a<b".to_owned(), deadline_ns: 50_000_000, figures, ..Task::default() }
}

#[test]
fn every_job_is_in_one_bar() {
    let values = [0, 1, 999, 50_000, 1_000_000, u64::MAX];
    for largest in [1, 1_000, u64::MAX] {
        assert_eq!(bins(&values, scale(largest, 0)).iter().sum::<u64>(), 6);
    }
    assert_eq!(bins(&[10, 20], scale(20, 0)).iter().filter(|count| **count == 1).count(), 2);
}

#[test]
fn labels_and_the_words_for_who_sees_no_bars_say_the_same() {
    let shown = figure(&task(&[10_000_000, 20_000_000, 80_000_000]));
    for words in
        ["median 10.0 ms", "p99 20.0 ms", "max 80.0 ms", "deadline 50.0 ms", "1 were later", "a&lt;b"]
    {
        assert!(shown.contains(words), "no `{words}` in {shown}");
    }
    assert!(shown.contains("class=\"late\"") && shown.contains("class=\"ok\""));
}

#[test]
fn a_task_without_a_completed_job_says_so() {
    assert!(figure(&task(&[])).contains("No job completed."));
}

#[test]
fn no_bar_lies_across_the_deadline() {
    for (largest, deadline) in [(350_000_000, 13_876_543), (20_000, 13_999), (1_000, 1_000), (90, 7)] {
        let each = scale(largest, deadline) / BINS as u64;
        assert!(each * BINS as u64 > largest);
        assert!(deadline.next_multiple_of(each) - deadline <= BINS as u64, "{largest} {deadline} {each}");
    }
}
