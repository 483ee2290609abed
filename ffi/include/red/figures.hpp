// What happened so far: counters, samples, events.
#ifndef RED_FIGURES_HPP
#define RED_FIGURES_HPP

#include "values.hpp"
#include "words.hpp"

#include <optional>

namespace red {

/// What happened so far, and what is now.
class Figures {
public:
    Figures() noexcept { c_.struct_size = sizeof c_, c_.abi_version = RED_ABI_VERSION; }
    /// Units dispatched.
    [[nodiscard]] std::uint64_t units() const noexcept { return c_.units; }
    /// Encoder sub-jobs that completed without executing.
    [[nodiscard]] std::uint64_t encoder_runs_saved() const noexcept { return c_.encoder_runs_saved; }
    /// Executions beyond the WCET, where the configuration takes samples of executions.
    [[nodiscard]] std::uint64_t overruns() const noexcept { return c_.overruns; }
    /// Calls whose time was before an earlier one; the latest time was kept.
    [[nodiscard]] std::uint64_t clock_steps_back() const noexcept { return c_.clock_steps_back; }
    /// Completions of units whose jobs had been given up.
    [[nodiscard]] std::uint64_t late_completions() const noexcept { return c_.late_completions; }
    /// Results thrown away for memory; their encoders run again.
    [[nodiscard]] std::uint64_t evictions() const noexcept { return c_.evictions; }
    /// Events that found no room.
    [[nodiscard]] std::uint64_t events_dropped() const noexcept { return c_.events_dropped; }
    /// Lanes over all pools, retired ones too.
    [[nodiscard]] std::uint32_t lanes() const noexcept { return c_.lanes; }
    [[nodiscard]] std::uint32_t jobs_in_flight() const noexcept { return c_.jobs_in_flight; }
    /// Sub-jobs that are ready and wait for a lane.
    [[nodiscard]] std::uint32_t ready() const noexcept { return c_.ready; }
    /// Units that run.
    [[nodiscard]] std::uint32_t running() const noexcept { return c_.running; }
    /// Whether a pool has both a free lane and a sub-job that could start there: poll.
    [[nodiscard]] bool can_dispatch() const noexcept { return c_.can_dispatch != 0; }
    [[nodiscard]] const red_figures &c() const noexcept { return c_; }

private:
    friend class Runtime;
    friend class Scheduler;
    red_figures c_{};
};

/// What the executions of a node took, of its last 8; nothing before the first.
class Executions {
public:
    Executions() noexcept { c_.struct_size = sizeof c_, c_.abi_version = RED_ABI_VERSION; }
    [[nodiscard]] std::optional<Nanoseconds> mean() const noexcept { return some(c_.mean_ns); }
    [[nodiscard]] std::optional<Nanoseconds> minimum() const noexcept { return some(c_.minimum_ns); }
    [[nodiscard]] std::optional<Nanoseconds> maximum() const noexcept { return some(c_.maximum_ns); }
    [[nodiscard]] const red_executions &c() const noexcept { return c_; }

private:
    friend class Scheduler;
    static std::optional<Nanoseconds> some(std::uint64_t ns) noexcept {
        return ns == RED_NONE_64 ? std::nullopt : std::optional(duration_from(ns));
    }
    red_executions c_{};
};

/// One event. What does not apply to its kind is 0.
class Event {
public:
    [[nodiscard]] EventKind kind() const noexcept { return static_cast<EventKind>(c_.kind); }
    [[nodiscard]] Time at() const noexcept { return time_from(c_.at_ns); }
    [[nodiscard]] TaskId task() const noexcept { return TaskId(c_.task); }
    /// The how-manieth job of its task, from 0.
    [[nodiscard]] std::uint64_t job_index() const noexcept { return c_.job; }
    [[nodiscard]] NodeId node() const noexcept { return NodeId(c_.node); }
    [[nodiscard]] LaneId lane() const noexcept { return LaneId(c_.lane); }
    /// Of EventKind::Shed: why.
    [[nodiscard]] Shed shed() const noexcept { return static_cast<Shed>(c_.shed); }
    [[nodiscard]] const red_event &c() const noexcept { return c_; }

private:
    red_event c_{};
};
static_assert(sizeof(Event) == sizeof(red_event) && std::is_standard_layout_v<Event>, "an array is one of C's");

} // namespace red

#endif
