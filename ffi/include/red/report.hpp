// What a runtime says about its run.
#ifndef RED_REPORT_HPP
#define RED_REPORT_HPP

#include "values.hpp"
#include "words.hpp"

#include <optional>

namespace red {

/// What is known when lanes have ended.
class Ending {
public:
    /// Whether lanes had SCHED_FIFO, locked memory and a CPU each. Without these there is no promise.
    [[nodiscard]] bool real_time() const noexcept { return c_.realtime != 0; }
    /// Why the run ended itself. Unless it is Surrender::No, the process is to be started anew.
    [[nodiscard]] Surrender surrender() const noexcept { return static_cast<Surrender>(c_.surrender); }
    /// Whether Runtime::stop ended it; else its duration did, or it itself.
    [[nodiscard]] bool stopped() const noexcept { return c_.stopped != 0; }
    /// Bodies that failed or threw.
    [[nodiscard]] std::uint64_t failed() const noexcept { return c_.failed; }
    /// Executions beyond the WCET.
    [[nodiscard]] std::uint64_t overruns() const noexcept { return c_.overruns; }
    /// Bodies that ran past ten times their WCET and 100 ms.
    [[nodiscard]] std::uint64_t hung() const noexcept { return c_.hung; }
    [[nodiscard]] std::uint64_t lanes_lost() const noexcept { return c_.lanes_lost; }
    /// Lane threads that ended though nobody asked them to.
    [[nodiscard]] std::uint64_t threads_died() const noexcept { return c_.threads_died; }
    /// Units that ended after their sub-deadlines.
    [[nodiscard]] std::uint64_t nodes_missed() const noexcept { return c_.nodes_missed; }
    /// Units dispatched.
    [[nodiscard]] std::uint64_t units() const noexcept { return c_.units; }
    /// Encoder sub-jobs that completed without executing.
    [[nodiscard]] std::uint64_t encoder_runs_saved() const noexcept { return c_.encoder_runs_saved; }
    /// Heap calls of lanes outside of bodies.
    [[nodiscard]] std::uint64_t allocations() const noexcept { return c_.allocations; }
    /// Of lanes.
    [[nodiscard]] std::uint64_t page_faults() const noexcept { return c_.page_faults; }
    /// Times that nobody got a CPU for 20 ms and more.
    [[nodiscard]] std::uint64_t standstills() const noexcept { return c_.standstills; }
    [[nodiscard]] Nanoseconds longest_standstill() const noexcept { return duration_from(c_.longest_standstill_ns); }
    /// Time that lanes spent deciding, per unit.
    [[nodiscard]] Nanoseconds overhead_per_unit() const noexcept { return duration_from(c_.overhead_ns_per_unit); }
    /// From when a unit could be dispatched to the start of its body: median, 99 of 100, and the longest.
    [[nodiscard]] Nanoseconds dispatch_p50() const noexcept { return duration_from(c_.dispatch_p50_ns); }
    [[nodiscard]] Nanoseconds dispatch_p99() const noexcept { return duration_from(c_.dispatch_p99_ns); }
    [[nodiscard]] Nanoseconds dispatch_max() const noexcept { return duration_from(c_.dispatch_max_ns); }
    /// Of a recorded run: inputs that found no room in the log, which then is not whole.
    [[nodiscard]] std::uint64_t log_dropped() const noexcept { return c_.log_dropped; }
    /// Waits of one CUDA stream for another, and predecessors that needed none.
    [[nodiscard]] std::uint64_t event_waits_issued() const noexcept { return c_.event_waits_issued; }
    [[nodiscard]] std::uint64_t event_waits_avoided() const noexcept { return c_.event_waits_avoided; }
    /// Units that were given to their streams while what they wait for ran.
    [[nodiscard]] std::uint64_t submissions_ahead() const noexcept { return c_.submissions_ahead; }
    /// How much less of the device's memory is free than at the start: the whole device waits where that is done late.
    [[nodiscard]] std::uint64_t late_memory_bytes() const noexcept { return c_.late_memory_bytes; }
    /// The error of the CUDA driver that ended the device for this process; 0: it works.
    [[nodiscard]] std::uint64_t device_error() const noexcept { return c_.device_error; }

private:
    friend class Report;
    explicit Ending(const red_report &c) noexcept : c_(c) {}
    red_report c_;
};

/// What became of a task's jobs so far.
class TaskReport {
public:
    TaskReport() noexcept { c_.struct_size = sizeof c_, c_.abi_version = RED_ABI_VERSION; }
    /// Jobs released. Those that are neither on time nor missed are in flight.
    [[nodiscard]] std::uint64_t released() const noexcept { return c_.released; }
    /// Jobs that completed by their deadlines.
    [[nodiscard]] std::uint64_t on_time() const noexcept { return c_.on_time; }
    /// Jobs that completed late or were given up.
    [[nodiscard]] std::uint64_t missed() const noexcept { return c_.missed; }
    /// Jobs that were given up for this reason.
    [[nodiscard]] std::uint64_t given_up(Shed reason) const noexcept {
        switch (reason) {
        case Shed::Hopeless: return c_.hopeless;
        case Shed::Overload: return c_.overload;
        case Shed::Urgency: return c_.urgency;
        case Shed::Full: return c_.full;
        case Shed::Late: return c_.late;
        case Shed::Fault: return c_.fault;
        case Shed::Removed: return c_.removed;
        default: return 0;
        }
    }
    /// Value of the jobs that were on time.
    [[nodiscard]] std::uint64_t value_on_time() const noexcept { return c_.value_on_time; }
    /// Value of all jobs released.
    [[nodiscard]] std::uint64_t value_released() const noexcept { return c_.value_released; }
    /// Jobs whose miss was predicted.
    [[nodiscard]] std::uint64_t warned() const noexcept { return c_.warned; }
    /// Whether the task has no floor, or kept it.
    [[nodiscard]] bool floor_kept() const noexcept { return c_.floor_kept != 0; }
    /// The fewest jobs on time in a window of the floor.
    [[nodiscard]] std::uint32_t floor_worst() const noexcept { return c_.floor_worst; }
    [[nodiscard]] const red_task_report &c() const noexcept { return c_; }

private:
    friend class Runtime;
    red_task_report c_{};
};

/// What a runtime did so far, or did.
class Report {
public:
    Report() noexcept { c_.struct_size = sizeof c_, c_.abi_version = RED_ABI_VERSION; }
    [[nodiscard]] RuntimeState state() const noexcept { return static_cast<RuntimeState>(c_.state); }
    /// Jobs released.
    [[nodiscard]] std::uint64_t released() const noexcept { return c_.released; }
    /// Jobs that completed by their deadlines.
    [[nodiscard]] std::uint64_t on_time() const noexcept { return c_.on_time; }
    /// Jobs that completed late or were given up.
    [[nodiscard]] std::uint64_t missed() const noexcept { return c_.missed; }
    /// Jobs that were given up, those that found no room at their release included.
    [[nodiscard]] std::uint64_t shed() const noexcept { return c_.shed; }
    /// Bodies out of which an exception came.
    [[nodiscard]] std::uint64_t threw() const noexcept { return c_.threw; }
    /// Outcomes that nobody took in time.
    [[nodiscard]] std::uint64_t outcomes_dropped() const noexcept { return c_.outcomes_dropped; }
    /// Events that nobody took in time.
    [[nodiscard]] std::uint64_t events_dropped() const noexcept { return c_.events_dropped; }
    /// The rest, once lanes have ended.
    [[nodiscard]] std::optional<Ending> ending() const noexcept {
        return state() == RuntimeState::Ended ? std::optional(Ending(c_)) : std::nullopt;
    }
    [[nodiscard]] const red_report &c() const noexcept { return c_; }

private:
    friend class Runtime;
    red_report c_{};
};

} // namespace red

#endif
