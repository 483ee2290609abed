// Scheduler: tasks, the loop, and what a host may ask.
#ifndef RED_SCHEDULER_HPP
#define RED_SCHEDULER_HPP

#include "action.hpp"
#include "config.hpp"
#include "dag.hpp"
#include "figures.hpp"

namespace red {

/// A scheduler. It has no clock and no thread: a host tells it what happened, each time with the time that it is, and
/// carries out what poll answers.
///
/// One thread at a time makes calls that change it; meanwhile nobody looks. `const` calls may be several at once. Names are
/// given as the answers that they came in: the first error goes on.
class Scheduler : public Handle<red_scheduler, red_scheduler_close> {
public:
    /// One that is not open.
    Scheduler() noexcept = default;
    explicit Scheduler(Status why) noexcept : Handle(why) {}

    /// Opens a scheduler without tasks. The memory has to outlive it. Where something is open in it this is
    /// RED_STATUS_OVERLAP, also if the answer is to take that one's place: close it before.
    template <class Caps>
    [[nodiscard]] static Result<Scheduler> open(SchedulerMemory<Caps> &memory, const Config &config) noexcept {
        return open<Caps>(memory.bytes(), config);
    }
    /// The same in memory of one's own, of Caps::scheduler_bytes and aligned to RED_ALIGN.
    template <class Caps>
    [[nodiscard]] static Result<Scheduler> open(Span<std::byte> memory, const Config &config) noexcept {
        Scheduler scheduler;
        const Status opened =
            config.status() ? Caps::open(memory.data(), memory.size(), config.c(), scheduler.c_) : config.status();
        return opened ? Result<Scheduler>(std::move(scheduler)) : opened;
    }

    // What there is to run on.

    /// Adds a pool after the others, with a budget in bytes.
    Result<PoolId> add_pool(std::uint32_t lanes, std::uint64_t memory = RED_NONE_64) noexcept {
        std::uint32_t pool = RED_NONE;
        const Status added = said(red_scheduler_add_pool(&c_, lanes, memory, &pool));
        return added ? Result<PoolId>(PoolId(pool)) : added;
    }
    /// Has a pool dispatch ahead, because its lanes run by themselves what they are given, in its order, as streams of a GPU
    /// do: polls answer Action::ahead, too.
    Status dispatch_ahead(Result<PoolId> pool) noexcept {
        const Status given = first_error(*this, pool);
        return given ? said(red_scheduler_dispatch_ahead(&c_, pool->value())) : given;
    }
    /// Gives a pool up, because what its lanes ran on is gone: jobs that need it end with Shed::Fault, also later ones. Units
    /// that run there have to be reported all the same.
    Status lose_pool(Result<PoolId> pool, Instant now) noexcept {
        const Status given = first_error(*this, pool, now);
        return given ? said(red_scheduler_lose_pool(&c_, pool->value(), now.ns())) : given;
    }
    /// Makes a sensor known that captures a frame each period, from time 0 on. Sensors of one period are one.
    Result<SensorId> add_sensor(Duration period) noexcept {
        std::uint32_t sensor = RED_NONE;
        const Status added = period.status() ? said(red_scheduler_add_sensor(&c_, period.ns(), &sensor)) : period.status();
        return added ? Result<SensorId>(SensorId(sensor)) : added;
    }
    /// Takes an idle lane out of its pool, because nothing can run there any more. A pool without lanes starts nothing.
    Status retire_lane(LaneId lane) noexcept { return said(red_scheduler_retire_lane(&c_, lane.value())); }
    /// Puts a retired lane back.
    Status restore_lane(LaneId lane) noexcept { return said(red_scheduler_restore_lane(&c_, lane.value())); }

    /// Records every input from here on in a log, which `redrt replay` feeds to a scheduler again. Directly after open. Links
    /// red::runtime.
    Status record(const char *path) noexcept { return said(red_record_begin(&c_, path)); }
    /// Ends the log, and waits until it is written: how many inputs found no room; 0: it is whole.
    Result<std::uint64_t> end_record(Instant now) noexcept {
        std::uint64_t dropped = 0;
        const Status given = now.status();
        const Status ended = given ? said(red_record_end(&c_, now.ns(), &dropped)) : given;
        return ended ? Result<std::uint64_t>(dropped) : ended;
    }

    // Tasks.

    /// Admits a task. The graph is copied.
    Result<TaskId> add_task(const Dag &dag, const Timing &timing) noexcept {
        std::uint32_t task = RED_NONE;
        const Status given = first_error(*this, dag, timing);
        const Status added = given ? said(red_scheduler_add_task(&c_, &dag.c(), &timing.c(), &task)) : given;
        return added ? Result<TaskId>(TaskId(task)) : added;
    }
    /// Removes a task; its jobs in flight are given up with Shed::Removed.
    Status remove_task(Result<TaskId> task, Instant now) noexcept {
        const Status given = first_error(*this, task, now);
        return given ? said(red_scheduler_remove_task(&c_, task->value(), now.ns())) : given;
    }
    /// The bound on the response time of the task's newest graph, alone on its pools.
    [[nodiscard]] Result<Certificate> certificate(Result<TaskId> task) const noexcept {
        Certificate proof;
        const Status given = first_error(*this, task);
        const Status looked = given ? said(red_scheduler_certificate(&c_, task->value(), &proof.c_)) : given;
        return looked ? Result<Certificate>(proof) : looked;
    }
    /// Begins an edit: the task's newest graph as one of its own, to be changed and given to commit. Closing it without a
    /// commit changes nothing. The memory is of this scheduler's class.
    template <class Caps>
    [[nodiscard]] Result<Dag> edit(Result<TaskId> task, DagMemory<Caps> &memory) const noexcept {
        return edit(task, memory.bytes());
    }
    [[nodiscard]] Result<Dag> edit(Result<TaskId> task, Span<std::byte> memory) const noexcept {
        Dag dag;
        const Status given = first_error(*this, task);
        const Status opened =
            given ? said(red_scheduler_edit(&c_, task->value(), memory.data(), memory.size(), &dag.c_)) : given;
        return opened ? Result<Dag>(std::move(dag)) : opened;
    }
    /// Applies an edit to the jobs that are released from now on; jobs in flight keep the graph of their release.
    Result<Certificate> commit(const Dag &edited, Instant now) noexcept {
        Certificate proof;
        const Status given = first_error(*this, edited, now);
        const Status done = given ? said(red_scheduler_commit(&c_, &edited.c(), now.ns(), &proof.c_)) : given;
        return done ? Result<Certificate>(proof) : done;
    }

    // The loop.

    /// Releases a job of a task now.
    Result<JobId> release(Result<TaskId> task, Instant now) noexcept {
        std::uint32_t job = RED_NONE;
        const Status given = first_error(*this, task, now);
        const Status released = given ? said(red_scheduler_release(&c_, task->value(), now.ns(), &job)) : given;
        return released ? Result<JobId>(JobId(job)) : released;
    }
    /// Releases a job whose release was earlier. `capture` is the number of the frame that it reads; without one, by the
    /// sensors' periods, and one of its own where a frame has no sensor.
    Result<JobId> release_at(
        Result<TaskId> task, Instant release, std::optional<std::uint64_t> capture, Instant now) noexcept {
        std::uint32_t job = RED_NONE;
        const Status given = first_error(*this, task, release, now);
        const Status released = given ? said(red_scheduler_release_at(&c_, task->value(), release.ns(),
                                            capture.value_or(RED_NONE_64), now.ns(), &job))
                                      : given;
        return released ? Result<JobId>(JobId(job)) : released;
    }
    /// The next thing to do: to be called until it is false, and again when something happened or at poll_at().
    Action poll(Instant now) noexcept {
        red_action action{};
        return polled(now.status() ? said(red_scheduler_poll(&c_, now.ns(), &action)) : now.status(), action);
    }
    /// poll for a lane that asks for itself: it is preferred among the free lanes of its pool.
    Action poll_on(LaneId lane, Instant now) noexcept {
        red_action action{};
        const Status given = now.status();
        return polled(given ? said(red_scheduler_poll_on(&c_, lane.value(), now.ns(), &action)) : given, action);
    }
    /// How the last poll ended: after the loop over polls, OK if there was nothing more to do.
    [[nodiscard]] Status polled() const noexcept { return first_error(*this, polled_); }
    /// A unit ended: all its members complete, and what follows them may start. RED_STATUS_LATE: its jobs had been given up;
    /// its lane is free all the same.
    Status complete(UnitId unit, Instant now) noexcept {
        return now.status() ? said(red_scheduler_complete(&c_, unit.value(), now.ns())) : now.status();
    }
    /// complete, and the first poll_on of the unit's lane, which costs less than both. On an error nothing was polled.
    Action complete_and_poll(UnitId unit, Instant now) noexcept {
        red_action action{};
        const Status given = now.status();
        return polled(
            given ? said(red_scheduler_complete_and_poll(&c_, unit.value(), now.ns(), &action)) : given, action);
    }
    /// A unit failed: the jobs of all its members are given up with Shed::Fault.
    Status fail(UnitId unit, Instant now) noexcept {
        return now.status() ? said(red_scheduler_fail(&c_, unit.value(), now.ns())) : now.status();
    }
    /// Takes how one job ended, so that its place can be used again before the next poll; nothing: there was none.
    Result<std::optional<Outcome>> take_outcome() noexcept {
        Outcome outcome;
        std::uint32_t count = 0;
        const Status taken = said(red_scheduler_take_outcome(&c_, &outcome.c_, &count));
        using Maybe = std::optional<Outcome>;
        return taken ? Result<Maybe>(count > 0 ? Maybe(outcome) : std::nullopt) : taken;
    }
    /// Takes one warning of a deadline that will be missed, as far as is known since the last poll or, where all lanes were
    /// busy, since the last event; nothing: there is none. After each of these, and before the next release.
    Result<std::optional<Warning>> take_warning() noexcept {
        Warning warning;
        std::uint32_t count = 0;
        const Status taken = said(red_scheduler_take_warning(&c_, &warning.c_, &count));
        using Maybe = std::optional<Warning>;
        return taken ? Result<Maybe>(count > 0 ? Maybe(warning) : std::nullopt) : taken;
    }
    /// When to poll even if nothing happens; `never`: not before something does. Any call may change it.
    [[nodiscard]] Result<Time> poll_at() const noexcept {
        std::uint64_t at_ns = RED_NONE_64;
        const Status looked = said(red_scheduler_poll_at(&c_, &at_ns));
        return looked ? Result<Time>(time_from(at_ns)) : looked;
    }

    // What a host may ask.

    /// What a unit is, while it runs and one of its jobs is in flight.
    [[nodiscard]] Result<Unit> unit(UnitId unit) const noexcept {
        Unit data;
        const Status looked = said(red_scheduler_unit(&c_, unit.value(), &data.c_));
        return looked ? Result<Unit>(data) : looked;
    }
    /// The members of a unit that runs, in `room`: one, or the encoders that share one execution.
    [[nodiscard]] Result<Span<const Member>> members(UnitId unit, Span<Member> room) const noexcept {
        std::size_t count = 0;
        auto *members = reinterpret_cast<red_member *>(room.data());
        const Status looked = said(red_scheduler_members(&c_, unit.value(), members, room.size(), &count));
        return Dag::filled<Member>(looked, room, count);
    }
    /// The units of other lanes after which one that was dispatched ahead has to start, in `room`.
    [[nodiscard]] Result<Span<const UnitId>> waits_for(UnitId unit, Span<UnitId> room) const noexcept {
        std::size_t count = 0;
        auto *units = reinterpret_cast<std::uint64_t *>(room.data());
        const Status looked = said(red_scheduler_waits_for(&c_, unit.value(), units, room.size(), &count));
        return Dag::filled<UnitId>(looked, room, count);
    }
    /// The job in flight that was the `index`-th of its task, from 0.
    [[nodiscard]] Result<JobId> job(Result<TaskId> task, std::uint64_t index) const noexcept {
        std::uint32_t job = RED_NONE;
        const Status given = first_error(*this, task);
        const Status looked = given ? said(red_scheduler_job(&c_, task->value(), index, &job)) : given;
        return looked ? Result<JobId>(JobId(job)) : looked;
    }
    /// What the last 8 executions of a node took, where the configuration takes samples.
    [[nodiscard]] Result<Executions> executions(Result<TaskId> task, Result<NodeId> node) const noexcept {
        Executions data;
        const Status given = first_error(*this, task, node);
        const Status looked =
            given ? said(red_scheduler_executions(&c_, task->value(), node->value(), &data.c_)) : given;
        return looked ? Result<Executions>(data) : looked;
    }
    [[nodiscard]] Result<Figures> figures() const noexcept {
        Figures data;
        const Status looked = said(red_scheduler_figures(&c_, &data.c_));
        return looked ? Result<Figures>(data) : looked;
    }
    /// Takes the oldest events of the record: as many as there are and `room` holds.
    Result<Span<const Event>> take_events(Span<Event> room) noexcept {
        std::size_t count = 0;
        auto *events = reinterpret_cast<red_event *>(room.data());
        const Status taken = said(red_scheduler_take_events(&c_, events, room.size(), &count));
        return Dag::filled<Event>(taken, room, count);
    }
    /// Bytes that running units and kept results hold of a pool's budget.
    [[nodiscard]] Result<std::uint64_t> memory_used(Result<PoolId> pool) const noexcept {
        std::uint64_t bytes = 0;
        const Status given = first_error(*this, pool);
        const Status looked = given ? said(red_scheduler_memory_used(&c_, pool->value(), &bytes)) : given;
        return looked ? Result<std::uint64_t>(bytes) : looked;
    }
    [[nodiscard]] Result<Config> config() const noexcept {
        Config config;
        const Status looked = said(red_scheduler_config(&c_, &config.c_));
        return looked ? Result<Config>(config) : looked;
    }

private:
    Action polled(Status status, const red_action &action) noexcept {
        polled_ = status;
        return status ? Action(action) : Action(status);
    }

    Status polled_{};
};

} // namespace red

#endif
