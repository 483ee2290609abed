use super::*;

const SECOND_NS: u64 = 1_000_000_000;

/// Lines as they are seen: without colours.
fn seen(lines: &[String]) -> Vec<String> {
    let plain = |line: &String| {
        let mut pieces = line.split('\x1b');
        let first = pieces.next().unwrap_or_default().to_owned();
        pieces.fold(first, |seen, piece| seen + piece.split_once('m').map_or("", |(_, rest)| rest))
    };
    lines.iter().map(plain).collect()
}

fn view() -> (View, std::sync::Arc<Live>) {
    let obstacle_ns = Some((3 * SECOND_NS, 6 * SECOND_NS));
    (View::new("REDRT".to_owned(), 10 * SECOND_NS, obstacle_ns, vec!["cpu lane 0".to_owned()]), Live::new(1))
}

#[test]
fn misses_and_the_obstacle_are_where_they_happened() {
    let (mut view, live) = view();
    view.look_for_misses(SECOND_NS, &live);
    live.missed.store(2, Ordering::Relaxed);
    view.look_for_misses(2 * SECOND_NS, &live);
    view.look_for_misses(4 * SECOND_NS, &live);
    let lines = seen(&view.figures(4 * SECOND_NS, &live));
    assert!(lines[1].contains("[=======x========                        ]"), "{}", lines[1]);
    assert!(lines[2].contains("[............oooooooooooo................]  in sight"), "{}", lines[2]);
    assert!(seen(&view.figures(7 * SECOND_NS, &live))[0].contains("missed     2"));
    view.look_for_misses(7 * SECOND_NS, &live);
    assert!(seen(&view.figures(7 * SECOND_NS, &live))[2].ends_with("not in sight"));
}

#[test]
fn what_takes_longer_than_it_did_is_named_while_the_run_goes_on() {
    let (mut view, live) = view();
    let named = |view: &View| seen(&view.figures(SECOND_NS, &live)).iter().any(|line| line.contains("drift"));
    assert!(!named(&view));
    live.drifted.store(1, Ordering::Relaxed);
    view.look_for_misses(SECOND_NS, &live);
    assert!(named(&view));
}

#[test]
fn no_line_is_wider_than_a_terminal() {
    let (mut view, live) = view();
    for counter in [&live.released, &live.on_time, &live.missed, &live.shed, &live.saved] {
        counter.store(99_999, Ordering::Relaxed);
    }
    view.look_for_misses(10 * SECOND_NS, &live);
    let lines = seen(&view.figures(10 * SECOND_NS, &live));
    assert!(lines.iter().all(|line| line.chars().count() <= 80), "{lines:#?}");
}
