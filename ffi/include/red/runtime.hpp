// Runtime: a scheduler with lanes, which are threads that call your functions.
#ifndef RED_RUNTIME_HPP
#define RED_RUNTIME_HPP

#include "action.hpp"
#include "body.hpp"
#include "config.hpp"
#include "dag.hpp"
#include "figures.hpp"
#include "report.hpp"

namespace red {

/// How a runtime runs. A value that cannot be is the status of the call that opens a runtime with it.
class RuntimeConfig {
public:
    /// SCHED_FIFO, memory locked, each lane alone on a CPU. Without the rights Runtime::start is refused. Priorities are 1 to
    /// 98; the watchdog runs one above.
    [[nodiscard]] static RuntimeConfig real_time(std::uint32_t priority = 80) noexcept {
        return RuntimeConfig(Mode::RealTime, priority);
    }
    /// Ordinary threads that share CPUs: no promise, and the report says so.
    [[nodiscard]] static RuntimeConfig best_effort() noexcept { return RuntimeConfig(Mode::BestEffort, 80); }

    /// No release from then on after the start; until Runtime::stop unless told.
    RuntimeConfig &duration(Duration length) noexcept {
        c_.duration_ns = length.ns();
        // For the library 0 says that there is no end, which is not what this call says.
        const Status zero = length.ns() == 0 ? RED_STATUS_OUT_OF_RANGE : RED_STATUS_OK;
        status_ = first_error(status_, length, zero);
        return *this;
    }
    /// How long jobs in flight may go on after that; 1 s unless told.
    RuntimeConfig &drain(Duration length) noexcept {
        c_.drain_ns = length.ns();
        status_ = first_error(status_, length);
        return *this;
    }

    [[nodiscard]] Status status() const noexcept { return status_; }
    /// All fields, as the C interface has them.
    [[nodiscard]] const red_runtime_config &c() const noexcept { return c_; }

private:
    RuntimeConfig(Mode mode, std::uint32_t priority) noexcept {
        c_.mode = static_cast<std::uint32_t>(mode);
        c_.priority = priority;
    }

    red_runtime_config c_ = RED_RUNTIME_CONFIG_INIT;
    Status status_{};
};

/// A scheduler of Caps16x256x64 with a clock and lanes: it releases jobs by the clock and when told, runs bodies, and keeps
/// what ended and happened until it is taken. Closed by the destructor, which stops it and waits for the bodies that run; so
/// what they use is declared before it. It does not wait for a body that hangs: see Body. From a body it can be neither
/// closed nor destroyed.
///
/// Every call may be made by several threads at once, but close, and take_outcomes and take_events: each of these by one at a
/// time. A thread that may call while another one closes uses the C interface, by a copy of c(). Bodies may make those that
/// say so. Names are given as the answers that they came in: the first error goes on.
class Runtime : public Handle<red_runtime, red_runtime_close> {
public:
    using Caps = Caps16x256x64;

    /// One that is not open.
    Runtime() noexcept = default;
    explicit Runtime(Status why) noexcept : Handle(why) {}

    /// Opens a runtime without tasks. This allocates about 2 MiB.
    [[nodiscard]] static Result<Runtime> open(const Config &policy, const RuntimeConfig &config) noexcept {
        Runtime runtime;
        const Status given = first_error(policy, config);
        const Status opened = given ? Status(red_runtime_open(&policy.c(), &config.c(), &runtime.c_)) : given;
        return opened ? Result<Runtime>(std::move(runtime)) : opened;
    }

    // What there is to run on, before the start.

    /// Adds a pool after the others, with a budget in bytes.
    Result<PoolId> add_pool(std::uint32_t lanes, std::uint64_t memory = RED_NONE_64) noexcept {
        std::uint32_t pool = RED_NONE;
        const Status added = said(red_runtime_add_pool(&c_, lanes, memory, &pool));
        return added ? Result<PoolId>(PoolId(pool)) : added;
    }
    /// Adds a pool after the others whose lanes are streams of a CUDA device, by its number from 0. The driver is loaded at run
    /// time; RED_STATUS_CUDA: message() says what is missing. A body there submits its work to Context::stream and returns
    /// without waiting for it. Make what it needs before the start, for the whole device may wait for an allocation.
    Result<PoolId> add_cuda_pool(
        std::uint32_t lanes, std::uint64_t memory = RED_NONE_64, std::uint32_t device = 0) noexcept {
        std::uint32_t pool = RED_NONE;
        const Status added = said(red_runtime_add_cuda_pool(&c_, device, lanes, memory, &pool));
        return added ? Result<PoolId>(PoolId(pool)) : added;
    }
    /// Makes a sensor known that captures a frame each period, from the start on. Sensors of one period are one.
    Result<SensorId> add_sensor(Duration period) noexcept {
        std::uint32_t sensor = RED_NONE;
        const Status added = period.status() ? said(red_runtime_add_sensor(&c_, period.ns(), &sensor)) : period.status();
        return added ? Result<SensorId>(SensorId(sensor)) : added;
    }
    /// In real time: lane i runs on the i-th of these CPUs; as many as lanes, each another one. They are chosen unless told.
    Status pin(Span<const std::uint32_t> cpus) noexcept { return said(red_runtime_pin(&c_, cpus.data(), cpus.size())); }
    /// Records every input in a log at `path`, which `redrt replay` feeds to a scheduler again. Before anything else is set up.
    Status record(const char *path) noexcept { return said(red_runtime_record(&c_, path)); }
    /// Has jobs of a task released by the clock: the first so long after the start, then each period.
    Status every(Result<TaskId> task, Duration first, Duration period) noexcept {
        // For the library 0 says that there is one only, which is not what this call says.
        const Status zero = period.ns() == 0 ? RED_STATUS_ZERO_PERIOD : RED_STATUS_OK;
        return releases(task, first, period, first_error(period, zero));
    }
    /// Has one job of a task released by the clock, so long after the start.
    Status once(Result<TaskId> task, Duration first) noexcept { return releases(task, first, Nanoseconds(0), Status()); }

    // Tasks, before the start and while lanes run.

    /// Admits a task. The graph is copied; `bodies` has one for each of its nodes.
    Result<TaskId> add_task(const Dag &dag, const Bodies &bodies, const Timing &timing) noexcept {
        std::uint32_t task = RED_NONE;
        const Status given = first_error(*this, dag, bodies, timing);
        const auto list = bodies.c();
        const Status added =
            given ? said(red_runtime_add_task(&c_, &dag.c(), list.data(), list.size(), &timing.c(), &task)) : given;
        return added ? Result<TaskId>(TaskId(task)) : added;
    }
    /// Removes a task; its jobs in flight are given up with Shed::Removed. Bodies that run go on to their ends.
    Status remove_task(Result<TaskId> task) noexcept {
        const Status given = first_error(*this, task);
        return given ? said(red_runtime_remove_task(&c_, task->value())) : given;
    }
    /// The bound on the response time of the task's newest graph, alone on its pools.
    [[nodiscard]] Result<Certificate> certificate(Result<TaskId> task) noexcept {
        Certificate proof;
        const Status given = first_error(*this, task);
        const Status looked = given ? said(red_runtime_certificate(&c_, task->value(), &proof.c_)) : given;
        return looked ? Result<Certificate>(proof) : looked;
    }
    /// What became of the task's jobs so far; also after the end of the run.
    [[nodiscard]] Result<TaskReport> report(Result<TaskId> task) const noexcept {
        TaskReport report;
        const Status given = first_error(*this, task);
        const Status looked = given ? said(red_runtime_task_report(&c_, task->value(), &report.c_)) : given;
        return looked ? Result<TaskReport>(report) : looked;
    }
    /// Begins an edit: the task's newest graph as one of its own, to be changed and given to commit. Closing it without a
    /// commit changes nothing.
    [[nodiscard]] Result<Dag> edit(Result<TaskId> task, DagMemory<Caps> &memory) noexcept {
        return edit(task, memory.bytes());
    }
    /// The same in memory of one's own, of Caps::dag_bytes and aligned to RED_ALIGN.
    [[nodiscard]] Result<Dag> edit(Result<TaskId> task, Span<std::byte> memory) noexcept {
        Dag dag;
        const Status given = first_error(*this, task);
        const Status opened =
            given ? said(red_runtime_edit(&c_, task->value(), memory.data(), memory.size(), &dag.c_)) : given;
        return opened ? Result<Dag>(std::move(dag)) : opened;
    }
    /// Applies an edit to the jobs that are released from now on; jobs in flight keep the graph of their release. `bodies` has
    /// one for each node that is new; others keep theirs.
    Result<Certificate> commit(const Dag &edited, const Bodies &bodies) noexcept {
        Certificate proof;
        const Status given = first_error(*this, edited, bodies);
        const auto list = bodies.c();
        const Status done =
            given ? said(red_runtime_commit(&c_, &edited.c(), list.data(), list.size(), &proof.c_)) : given;
        return done ? Result<Certificate>(proof) : done;
    }
    /// The same without new nodes.
    Result<Certificate> commit(const Dag &edited) noexcept { return commit(edited, Bodies()); }

    // The run.

    /// Starts the lanes; returns when all are ready. If a right is missing nothing runs, message() says which and how to get
    /// it, and the runtime can only be closed. No signal handler is installed.
    Status start() noexcept { return said(red_runtime_start(&c_)); }
    /// Why start was refused, and what to do about it, in `room`; empty where it was not. A message that does not fit, or of a
    /// runtime that is not open, is the text of that status. 1,024 bytes are enough for all but odd paths.
    [[nodiscard]] const char *message(Span<char> room) const noexcept {
        std::size_t count = 0;
        const Status told = said(red_runtime_message(&c_, room.data(), room.size(), &count));
        return told ? room.data() : told.text();
    }
    /// Releases a job of a task now. `capture` is the number of the frame that it reads; without one, by the sensors' periods,
    /// and one of its own where a frame has no sensor. A body may do this.
    Status release(Result<TaskId> task, std::optional<std::uint64_t> capture = std::nullopt) const noexcept {
        const Status given = first_error(*this, task);
        return given ? said(red_runtime_release(&c_, task->value(), capture.value_or(RED_NONE_64))) : given;
    }
    /// Asks the lanes to end: nothing is released any more, no lane takes another unit, and wait waits for the bodies that
    /// run. A body or a signal handler may do this.
    Status stop() const noexcept { return said(red_runtime_stop(&c_)); }
    /// Waits until the lanes have ended.
    Status wait() const noexcept { return said(red_runtime_wait(&c_, RED_NONE_64)); }
    /// The same, at most so long: RED_STATUS_TIMEOUT if they go on.
    Status wait(Duration timeout) const noexcept {
        return timeout.status() ? said(red_runtime_wait(&c_, timeout.ns())) : timeout.status();
    }

    // What a program may ask. A body may do so too, but for figures.

    [[nodiscard]] Result<RuntimeState> state() const noexcept {
        std::uint32_t number = 0;
        const Status looked = said(red_runtime_state_of(&c_, &number));
        return looked ? Result<RuntimeState>(static_cast<RuntimeState>(number)) : looked;
    }
    /// What the runtime did so far, or did.
    [[nodiscard]] Result<Report> report() const noexcept {
        Report report;
        const Status looked = said(red_runtime_report(&c_, &report.c_));
        return looked ? Result<Report>(report) : looked;
    }
    /// Of its scheduler, before the start and while lanes run.
    [[nodiscard]] Result<Figures> figures() noexcept {
        Figures data;
        const Status looked = said(red_runtime_figures(&c_, &data.c_));
        return looked ? Result<Figures>(data) : looked;
    }
    /// Takes how the oldest jobs ended: as many as there are and `room` holds. 1,024 are kept.
    Result<Span<const Outcome>> take_outcomes(Span<Outcome> room) noexcept {
        std::size_t count = 0;
        auto *outcomes = reinterpret_cast<red_outcome *>(room.data());
        const Status taken = said(red_runtime_take_outcomes(&c_, outcomes, room.size(), &count));
        return Dag::filled<Outcome>(taken, room, count);
    }
    /// Takes the oldest warnings of deadlines that will be missed: as many as there are and `room` holds. 1,024 are kept.
    Result<Span<const Warning>> take_warnings(Span<Warning> room) noexcept {
        std::size_t count = 0;
        auto *warnings = reinterpret_cast<red_warning *>(room.data());
        const Status taken = said(red_runtime_take_warnings(&c_, warnings, room.size(), &count));
        return Dag::filled<Warning>(taken, room, count);
    }
    /// Takes the oldest events: as many as there are and `room` holds. 8,192 are kept.
    Result<Span<const Event>> take_events(Span<Event> room) noexcept {
        std::size_t count = 0;
        auto *events = reinterpret_cast<red_event *>(room.data());
        const Status taken = said(red_runtime_take_events(&c_, events, room.size(), &count));
        return Dag::filled<Event>(taken, room, count);
    }
    /// The clock of all times that a runtime takes and gives.
    [[nodiscard]] static Time now() noexcept {
        std::uint64_t now_ns = 0;
        static_cast<void>(red_runtime_now(&now_ns));
        return time_from(now_ns);
    }

private:
    Status releases(Result<TaskId> task, Duration first, Duration period, Status wrong) noexcept {
        const Status given = first_error(*this, task, first, wrong);
        return given ? said(red_runtime_every(&c_, task->value(), first.ns(), period.ns())) : given;
    }
};

} // namespace red

#endif
