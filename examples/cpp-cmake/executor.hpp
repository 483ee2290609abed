// An executor over the core: a thread for each lane, one lock around the scheduler, and a thread that keeps the time.
#ifndef EXECUTOR_HPP
#define EXECUTOR_HPP

#include <array>
#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <red.hpp>
#include <thread>

/// What ended, and how.
struct Counts {
    std::uint64_t released = 0, on_time = 0, missed = 0, shed = 0;
    /// Calls that were refused, though nothing should be.
    std::uint64_t refused = 0;
};

class Executor {
public:
    static constexpr std::uint32_t lanes = 2;
    /// Runs a node; called by the lane's thread, without the lock.
    using Body = void (*)(red::TaskId task, red::NodeId node);

    /// Takes a scheduler of so many lanes over. Threads start at once.
    Executor(red::Scheduler scheduler, Body body);
    /// Ends the lanes; jobs that are left are not waited for.
    ~Executor();
    Executor(const Executor &) = delete;
    Executor &operator=(const Executor &) = delete;

    /// Makes calls on the scheduler, `call(scheduler, now)`, and then carries out what it answers.
    template <class Call>
    auto with(Call call) {
        const std::lock_guard<std::mutex> lock(mutex_);
        const red::Time now = std::chrono::steady_clock::now();
        auto answer = call(scheduler_, now);
        carry_out(now);
        return answer;
    }
    /// Releases a job; one that finds no place is shed.
    void release(red::TaskId task);
    /// Sleeps until then, and lets the scheduler have its time meanwhile.
    void run_until(red::Time end);
    /// Until no job is in flight, or it takes too long; whether none is.
    bool drain();

    Counts counts();

private:
    struct Lane {
        red::UnitId unit;
        red::TaskId task;
        red::NodeId node;
        bool has_unit = false;
        std::condition_variable given;
        std::thread thread;
    };

    void work(Lane &lane);
    void carry_out(red::Time now);
    void start(const red::Dispatch &dispatch);
    void count(const red::Outcome &outcome);
    void expect(red::Status status);

    std::mutex mutex_;
    // Rung when something changed that the timekeeper waits for.
    std::condition_variable changed_;
    red::Scheduler scheduler_;
    Body body_;
    bool is_over_ = false;
    Counts counts_;
    std::array<Lane, lanes> lanes_;
};

#endif
