// What a scheduler answers: actions, outcomes, units.
#ifndef RED_ACTION_HPP
#define RED_ACTION_HPP

#include "values.hpp"
#include "words.hpp"

#include <optional>

namespace red {

/// How a job ended.
class Outcome {
public:
    /// Its place may be used again from now on.
    [[nodiscard]] JobId job() const noexcept { return JobId(c_.job); }
    [[nodiscard]] TaskId task() const noexcept { return TaskId(c_.task); }
    /// The how-manieth job of its task, from 0.
    [[nodiscard]] std::uint64_t index() const noexcept { return c_.index; }
    [[nodiscard]] Time release() const noexcept { return time_from(c_.release_ns); }
    [[nodiscard]] Time deadline() const noexcept { return time_from(c_.deadline_ns); }
    /// When it ended.
    [[nodiscard]] Time at() const noexcept { return time_from(c_.at_ns); }
    /// From its release to its end.
    [[nodiscard]] Nanoseconds response() const noexcept { return at() - release(); }
    /// Why it was given up; Shed::Not: all its nodes completed.
    [[nodiscard]] Shed shed() const noexcept { return static_cast<Shed>(c_.shed); }
    [[nodiscard]] bool completed() const noexcept { return shed() == Shed::Not; }
    [[nodiscard]] bool on_time() const noexcept { return completed() && c_.at_ns <= c_.deadline_ns; }
    [[nodiscard]] const red_outcome &c() const noexcept { return c_; }

private:
    friend class Action;
    friend class Scheduler;
    red_outcome c_{};
};
static_assert(sizeof(Outcome) == sizeof(red_outcome) && std::is_standard_layout_v<Outcome>, "an array is one of C's");

/// A predicted deadline miss: told when it is known, and not when it is too late.
class Warning {
public:
    /// It is given up already where its outcome says so.
    [[nodiscard]] JobId job() const noexcept { return JobId(c_.job); }
    [[nodiscard]] TaskId task() const noexcept { return TaskId(c_.task); }
    /// The index of the job in its task, from 0.
    [[nodiscard]] std::uint64_t index() const noexcept { return c_.index; }
    [[nodiscard]] Time deadline() const noexcept { return time_from(c_.deadline_ns); }
    /// When that was known.
    [[nodiscard]] Time at() const noexcept { return time_from(c_.at_ns); }
    /// How long after its deadline it would end, by the estimates of then, in whole microseconds rounded up. 0: it would not be late, but goes so that the
    /// other job is in time.
    [[nodiscard]] Nanoseconds by() const noexcept { return duration_from(c_.by_ns); }
    /// Whose job takes the lanes it needs; nothing: it is late on its own.
    [[nodiscard]] std::optional<TaskId> because_of() const noexcept {
        return c_.because_task == RED_NONE ? std::nullopt : std::optional(TaskId(c_.because_task));
    }
    /// The index of that job in its task.
    [[nodiscard]] std::uint64_t because_index() const noexcept { return c_.because_index; }
    [[nodiscard]] const red_warning &c() const noexcept { return c_; }

private:
    friend class Scheduler;
    red_warning c_{};
};
static_assert(sizeof(Warning) == sizeof(red_warning) && std::is_standard_layout_v<Warning>, "an array is one of C's");

/// A unit that starts on its lane, or loses it.
struct Dispatch {
    UnitId unit;
    LaneId lane;
    /// Of the unit's first member: the one whose body runs.
    NodeId node;
};

/// One answer of a poll: `while (const auto action = scheduler.poll(now))`. It is false when there is nothing more to do,
/// and on an error, which status() tells.
class [[nodiscard]] Action {
public:
    [[nodiscard]] explicit operator bool() const noexcept { return status_.ok() && kind() != ActionKind::Nothing; }
    [[nodiscard]] Status status() const noexcept { return status_; }
    [[nodiscard]] ActionKind kind() const noexcept { return static_cast<ActionKind>(c_.kind); }
    /// A unit to start on its lane, and to report by Scheduler::complete or fail; nullptr: this is something else.
    [[nodiscard]] const Dispatch *dispatch() const & noexcept { return unit_of(ActionKind::Dispatch); }
    /// A unit to give to its lane, to start after what that runs and after Scheduler::waits_for. Only in pools that dispatch
    /// ahead.
    [[nodiscard]] const Dispatch *ahead() const & noexcept { return unit_of(ActionKind::Ahead); }
    /// A unit to take from its lane, which goes on later as another one. Only if the configuration preempts.
    [[nodiscard]] const Dispatch *preempt() const & noexcept { return unit_of(ActionKind::Preempt); }
    /// A job that ended. A lane that still runs one of its units must report it all the same.
    [[nodiscard]] const Outcome *ended() const & noexcept { return kind() == ActionKind::Ended ? &outcome_ : nullptr; }
    const Dispatch *dispatch() const && = delete;
    const Dispatch *ahead() const && = delete;
    const Dispatch *preempt() const && = delete;
    const Outcome *ended() const && = delete;
    [[nodiscard]] const red_action &c() const noexcept { return c_; }

private:
    friend class Scheduler;
    explicit Action(Status status) noexcept : status_(status) {}
    explicit Action(const red_action &c) noexcept
        : c_(c), dispatch_{UnitId(c.unit), LaneId(c.lane), NodeId(static_cast<std::uint32_t>(c.unit >> 8U & 0xffU))} {
        outcome_.c_ = c.outcome;
    }
    [[nodiscard]] const Dispatch *unit_of(ActionKind wanted) const noexcept {
        return kind() == wanted ? &dispatch_ : nullptr;
    }

    Status status_{};
    red_action c_{};
    Dispatch dispatch_{};
    Outcome outcome_{};
};

/// One sub-job of a unit.
class Member {
public:
    [[nodiscard]] JobId job() const noexcept { return JobId(c_.job); }
    [[nodiscard]] TaskId task() const noexcept { return TaskId(c_.task); }
    [[nodiscard]] NodeId node() const noexcept { return NodeId(c_.node); }
    /// The how-manieth job of its task, from 0.
    [[nodiscard]] std::uint64_t index() const noexcept { return c_.index; }
    /// When the job was released.
    [[nodiscard]] Time release() const noexcept { return time_from(c_.release_ns); }
    /// When the job is due.
    [[nodiscard]] Time deadline() const noexcept { return time_from(c_.deadline_ns); }
    /// When the node should end.
    [[nodiscard]] Time sub_deadline() const noexcept { return time_from(c_.sub_deadline_ns); }
    [[nodiscard]] const red_member &c() const noexcept { return c_; }

private:
    friend class Unit;
    red_member c_{};
};
static_assert(sizeof(Member) == sizeof(red_member) && std::is_standard_layout_v<Member>, "an array is one of C's");

/// What a unit is.
class Unit {
public:
    Unit() noexcept { c_.struct_size = sizeof c_, c_.abi_version = RED_ABI_VERSION; }
    /// The member whose body runs.
    [[nodiscard]] Member first() const noexcept {
        Member member;
        member.c_ = c_.first;
        return member;
    }
    [[nodiscard]] LaneId lane() const noexcept { return LaneId(c_.lane); }
    [[nodiscard]] PoolId pool() const noexcept { return PoolId(c_.pool); }
    /// Whether it writes or reads an encoder's result; output() is its number then, and stays the same result until nobody in
    /// flight needs it.
    [[nodiscard]] bool has_output() const noexcept { return c_.output != RED_NONE; }
    [[nodiscard]] std::uint32_t output() const noexcept { return c_.output; }
    [[nodiscard]] Time started() const noexcept { return time_from(c_.started_ns); }
    /// Of the first member's node.
    [[nodiscard]] Nanoseconds wcet() const noexcept { return duration_from(c_.wcet_ns); }
    [[nodiscard]] const red_unit &c() const noexcept { return c_; }

private:
    friend class Scheduler;
    red_unit c_{};
};

} // namespace red

#endif
