use super::*;

/// Fewer where each takes an interpreter.
const LETTERS: u32 = if cfg!(miri) { 50 } else { 10_000 };

#[test]
fn nothing_is_lost_and_nothing_comes_twice() {
    let mailbox = Mailbox::<u32, 4>::new();
    std::thread::scope(|s| {
        s.spawn(|| {
            let post = mailbox.claim().unwrap();
            for letter in 0..LETTERS {
                while post.push(letter).is_err() {
                    std::thread::yield_now();
                }
            }
        });
        let mut next = 0;
        while next < LETTERS {
            match mailbox.pop() {
                Some(letter) => {
                    assert_eq!(letter, next);
                    next += 1;
                }
                None => std::thread::yield_now(),
            }
        }
    });
    assert_eq!(mailbox.pop(), None);
}

#[test]
fn the_right_to_post_stays_with_who_has_it() {
    let mailbox = Mailbox::<u32, 4>::new();
    let post = mailbox.claim().expect("nobody has it");
    for _ in 0..2 {
        assert!(mailbox.claim().is_none(), "a claim that failed took the right away");
    }
    drop(post);
    assert!(mailbox.claim().is_some());
}
