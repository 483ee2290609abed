//! What ROS 2 and other middleware over UDP need.

use super::Finding;
use super::check::{Check, Setting};
use super::tree::Tree;

const SETTINGS: [Setting; 2] = [
    Setting {
        check: Check {
            id: "network.rmem_max",
            why: "images over DDS lose fragments when the receive buffer (bytes) is smaller than a few of them",
            fix: "sysctl -w net.core.rmem_max=4194304",
        },
        path: "proc/sys/net/core/rmem_max",
        good: |value| value.parse().is_ok_and(|bytes: u64| bytes >= 4_000_000),
        absent: None,
    },
    Setting {
        check: Check {
            id: "network.loopback_multicast",
            why: "DDS discovery inside one machine uses multicast on the loopback interface (flag 0x1000)",
            fix: "ip link set lo multicast on",
        },
        path: "sys/class/net/lo/flags",
        good: |flags| {
            u32::from_str_radix(flags.trim_start_matches("0x"), 16).is_ok_and(|flags| flags & 0x1000 != 0)
        },
        absent: None,
    },
];

pub(super) fn examine(tree: &Tree<'_>) -> Vec<Finding> {
    SETTINGS.iter().map(|setting| setting.examine(tree)).collect()
}
