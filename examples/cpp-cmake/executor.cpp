// The executor: what lanes do, and what becomes of actions.
#include "executor.hpp"

#include <algorithm>
#include <cstdio>

using namespace std::chrono_literals;

Executor::Executor(red::Scheduler scheduler, Body body) : scheduler_(std::move(scheduler)), body_(body) {
    for (Lane &lane : lanes_) {
        lane.thread = std::thread([this, &lane] { work(lane); });
    }
}

Executor::~Executor() {
    {
        const std::lock_guard<std::mutex> lock(mutex_);
        is_over_ = true;
    }
    for (Lane &lane : lanes_) {
        lane.given.notify_one();
        lane.thread.join();
    }
}

void Executor::release(red::TaskId task) {
    const std::lock_guard<std::mutex> lock(mutex_);
    const red::Time now = std::chrono::steady_clock::now();
    const auto job = scheduler_.release(task, now);
    counts_.released++;
    if (job.status() == RED_STATUS_JOBS_FULL) {
        counts_.shed++;
    } else {
        expect(job.status());
    }
    carry_out(now);
}

void Executor::run_until(red::Time end) {
    std::unique_lock<std::mutex> lock(mutex_);
    for (;;) {
        const red::Time now = std::chrono::steady_clock::now();
        carry_out(now);
        if (now >= end) {
            return;
        }
        // A poll that changed the time to poll at rings, so that this one is not slept through.
        changed_.wait_until(lock, std::min(end, scheduler_.poll_at().value_or(end)));
    }
}

bool Executor::drain() {
    const auto idle = [](const red::Scheduler &scheduler, red::Time) { return scheduler.figures()->jobs_in_flight() == 0; };
    for (int i = 0; i < 200 && !with(idle); i++) {
        run_until(std::chrono::steady_clock::now() + 10ms);
    }
    return with(idle);
}

Counts Executor::counts() {
    const std::lock_guard<std::mutex> lock(mutex_);
    return counts_;
}

void Executor::work(Lane &lane) {
    std::unique_lock<std::mutex> lock(mutex_);
    for (;;) {
        lane.given.wait(lock, [&] { return lane.has_unit || is_over_; });
        if (is_over_) {
            return;
        }
        const red::TaskId task = lane.task;
        const red::NodeId node = lane.node;
        lock.unlock();
        body_(task, node);
        lock.lock();
        lane.has_unit = false;
        const red::Time now = std::chrono::steady_clock::now();
        const red::Status done = scheduler_.complete(lane.unit, now);
        // Late: its job was given up meanwhile, and its end was counted then.
        expect(done == RED_STATUS_LATE ? red::Status() : done);
        carry_out(now);
        changed_.notify_one();
    }
}

void Executor::carry_out(red::Time now) {
    while (const auto action = scheduler_.poll(now)) {
        if (const auto *dispatch = action.dispatch()) {
            start(*dispatch);
        } else if (const auto *outcome = action.ended()) {
            count(*outcome);
        }
    }
    expect(scheduler_.polled());
}

void Executor::start(const red::Dispatch &dispatch) {
    Lane &lane = lanes_[dispatch.lane.value()];
    const auto unit = scheduler_.unit(dispatch.unit);
    expect(unit.status());
    lane.unit = dispatch.unit;
    lane.task = unit->first().task();
    lane.node = dispatch.node;
    lane.has_unit = true;
    lane.given.notify_one();
}

void Executor::count(const red::Outcome &outcome) {
    if (!outcome.completed()) {
        counts_.shed++;
    } else if (outcome.on_time()) {
        counts_.on_time++;
    } else {
        counts_.missed++;
    }
}

void Executor::expect(red::Status status) {
    if (!status) {
        counts_.refused++;
        std::fprintf(stderr, "refused: %s\n", status.text());
    }
}
