use super::*;

/// A console on which everything is as it should be.
const GOOD: &str = "\
RT realtime 1
RT locked 359772 kB
RT fifo red-lane-0 priority 70 cpus 1 faults 0 looks 15
RT fifo red-lane-1 priority 70 cpus 2 faults 0 looks 15
RT fifo red-watchdog priority 71 cpus 0 faults 0 looks 15
RT run {\"policy\":\"redrt\",\"tasks\":[{\"completed\":37,}],\"realtime\":true,\"page_faults\":0,\"allocations\":0,}
RT run ended with exit status: 0
RT doctor PASS kernel.preempt_rt: #1 SMP PREEMPT_RT
RT doctor PASS rights.rtprio: every priority
RT doctor PASS rights.memlock: any amount
RT doctor 36 pass, 20 warn, 0 fail
[   10.606834] reboot: Power down
";

#[test]
fn a_good_console_lacks_nothing() {
    assert_eq!(missing(GOOD), Vec::<String>::new());
    assert_eq!(missing(&GOOD.replace('\n', "\r\n")), Vec::<String>::new());
}

#[test]
fn every_line_that_is_missing_is_found() {
    let lines = GOOD.lines().filter(|line| line.starts_with("RT "));
    for line in lines {
        assert!(!missing(&GOOD.replace(line, "")).is_empty(), "nobody misses {line:?}");
    }
    assert!(missing("").len() >= EXPECTED.len());
}

#[test]
fn every_wrong_value_is_found() {
    let planted = [
        ("realtime 1", "realtime "),
        ("locked 359772", "locked 0"),
        ("cpus 1 faults", "cpus 0-2 faults"),
        ("cpus 2 faults 0", "cpus 2 faults 3"),
        ("cpus 2 faults 0 looks 15", "cpus 2 faults 0 looks 1"),
        ("priority 71", "priority 70"),
        ("\"completed\":37", "\"completed\":0"),
        ("\"realtime\":true", "\"realtime\":false"),
        ("\"page_faults\":0,", "\"page_faults\":12,"),
        ("\"allocations\":0,", "\"allocations\":1,"),
        ("exit status: 0", "exit status: 3"),
        ("PASS rights.memlock", "WARN rights.memlock"),
        (" 0 fail", " 10 fail"),
    ];
    for (right, wrong) in planted {
        assert!(GOOD.contains(right));
        assert!(!missing(&GOOD.replace(right, wrong)).is_empty(), "{wrong:?} passes");
    }
}
