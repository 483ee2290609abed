//! Where interrupts are served.

use super::Finding;
use super::check::Check;
use super::tree::Tree;
use crate::placement::parse_cpu_list;

/// What occurs in the names that GPUs, and network cards without the name of their interface, give to their
/// interrupts; the last two are virtual network cards.
const DRIVERS: [&str; 9] =
    ["nvidia", "nvgpu", "host1x", "gk20a", "gv11b", "ga10b", "mlx", "-input.", "-output."];

pub(super) fn examine(tree: &Tree<'_>) -> Vec<Finding> {
    vec![balancer(tree), affinity(tree)]
}

fn balancer(tree: &Tree<'_>) -> Finding {
    const CHECK: Check = Check {
        id: "cpu.irqbalance",
        why: "it moves interrupts to CPUs that look idle, such as those of sleeping lanes",
        fix: "systemctl disable --now irqbalance, or IRQBALANCE_BANNED_CPULIST=<lane CPUs>",
    };
    CHECK.on(tree.runs("irqbalance"), |runs| {
        CHECK.pass_if(!runs, if runs { "running" } else { "not running" })
    })
}

fn affinity(tree: &Tree<'_>) -> Finding {
    const CHECK: Check = Check {
        id: "cpu.irq_affinity",
        why: "interrupts of the GPU and the network on a lane's CPU delay the lane; CPU 0 is left free for them",
        fix: "echo 0 > /proc/irq/<number>/smp_affinity_list for each of them",
    };
    let both = || Ok((tree.read("proc/interrupts")?, tree.names("sys/class/net")?));
    CHECK.on(both(), |(interrupts, networks)| {
        let of_interest = |action: &str| {
            DRIVERS.iter().any(|driver| action.contains(driver))
                || networks.iter().any(|network| action.starts_with(network.as_str()))
        };
        let elsewhere: Vec<_> = interrupts
            .lines()
            .filter_map(|line| {
                let (number, _) = line.trim_start().split_once(':')?;
                let action = line.split_whitespace().last().filter(|action| of_interest(action))?;
                let cpus = tree.read(&format!("proc/irq/{number}/smp_affinity_list")).ok()?;
                (parse_cpu_list(&cpus) != [0]).then(|| format!("{number} {action} on {cpus}"))
            })
            .collect();
        if elsewhere.is_empty() {
            CHECK.pass("none of the GPU or the network outside CPU 0")
        } else {
            CHECK.warn(elsewhere.join(", "))
        }
    })
}
