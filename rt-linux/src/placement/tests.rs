use std::path::Path;

use super::{choose_cpus, parse_cpu_list, shared_cores, usable_cpus};
use crate::setup::SetupError;

#[test]
fn cpu_0_is_left_free_while_others_suffice() {
    assert_eq!(choose_cpus(2, &[0, 1, 2, 3]).unwrap(), [1, 2]);
    assert_eq!(choose_cpus(3, &[0, 1, 2, 3]).unwrap(), [1, 2, 3]);
    assert_eq!(choose_cpus(4, &[0, 1, 2, 3]).unwrap(), [0, 1, 2, 3]);
    assert_eq!(choose_cpus(2, &[4, 6, 7]).unwrap(), [4, 6]);
    assert_eq!(choose_cpus(0, &[0]).unwrap(), [] as [usize; 0]);
}

#[test]
fn more_lanes_than_cpus_are_refused_with_both_numbers() {
    let error = choose_cpus(3, &[0, 1]).unwrap_err();
    assert!(matches!(&error, SetupError::MoreLanesThanCpus { lanes: 3, usable } if *usable == [0, 1]));
    let text = error.to_string();
    assert!(text.contains("3 lanes") && text.contains("2 usable CPUs"), "{text}");
}

#[test]
fn the_kernels_lists_are_read_and_nonsense_is_not() {
    assert_eq!(parse_cpu_list("0-2,5\n"), [0, 1, 2, 5]);
    assert_eq!(parse_cpu_list("7"), [7]);
    assert_eq!(parse_cpu_list("\n"), [] as [usize; 0]);
    assert_eq!(parse_cpu_list("3-1,x,2-y,4"), [4]);
    assert_eq!(parse_cpu_list("0-18446744073709551615").len(), 1024);
}

#[test]
fn this_thread_has_at_least_one_cpu() {
    assert!(!usable_cpus().unwrap().is_empty());
}

#[test]
fn a_machine_that_tells_nothing_shares_nothing() {
    assert_eq!(shared_cores(Path::new("/nonexistent"), &[0, 1]), []);
}

#[test]
fn hardware_threads_of_one_core_are_paired() {
    let root = std::env::temp_dir().join(format!("red-placement-{}", std::process::id()));
    for (cpu, siblings) in [(0, "0,2"), (1, "1,3"), (2, "0,2"), (3, "1,3")] {
        let folder = root.join(format!("sys/devices/system/cpu/cpu{cpu}/topology"));
        std::fs::create_dir_all(&folder).expect("a writable temporary folder");
        std::fs::write(folder.join("thread_siblings_list"), siblings).expect("a writable temporary folder");
    }
    assert_eq!(shared_cores(&root, &[0, 1]), []);
    assert_eq!(shared_cores(&root, &[1, 2, 3]), [(1, 3)]);
    assert_eq!(shared_cores(&root, &[0, 1, 2, 3]), [(0, 2), (1, 3)]);
    std::fs::remove_dir_all(&root).expect("made above");
}
