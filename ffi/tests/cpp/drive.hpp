// Drives a scheduler in virtual time: lanes take as long as a scene says, and every action becomes a line.
#ifndef DRIVE_HPP
#define DRIVE_HPP

#include "tests.hpp"

#include <algorithm>
#include <functional>
#include <map>
#include <vector>

class Drive {
public:
    explicit Drive(red::Scheduler &scheduler) : scheduler_(scheduler) {}

    /// What a node of a task is called, and how long it takes; its WCET unless told.
    void name(red::Result<red::TaskId> task, red::Result<red::NodeId> node, std::string name) {
        names_[{*task, *node}] = std::move(name);
    }
    void takes(red::Result<red::TaskId> task, red::Result<red::NodeId> node, red::Nanoseconds time) {
        times_[{*task, *node}] = time;
    }
    /// Something that happens.
    void when(red::Nanoseconds time, std::function<void(red::Time)> what) { script_.emplace(at(time), std::move(what)); }
    void release(red::Nanoseconds time, red::Result<red::TaskId> task) {
        when(time, [this, task](red::Time now) { CHECK(scheduler_.release(task, now).ok()); });
    }

    /// Until nothing more happens; what happened, a line for each instant.
    std::string run() {
        for (;;) {
            red::Time next = script_.empty() ? red::never : script_.begin()->first;
            for (const auto &[lane, running] : running_) {
                next = std::min(next, running.end);
            }
            // A tick counts only while something goes on.
            if (next == red::never) {
                return std::move(log_);
            }
            const auto poll_at = scheduler_.poll_at();
            CHECK(poll_at.ok());
            instant(std::min(next, *poll_at));
        }
    }

private:
    struct Running {
        red::UnitId unit;
        red::Time end;
    };

    void instant(red::Time now) {
        line_.clear();
        for (auto lane = running_.begin(); lane != running_.end();) {
            if (lane->second.end > now) {
                ++lane;
                continue;
            }
            const red::Status done = scheduler_.complete(lane->second.unit, now);
            CHECK(done.ok() || done == RED_STATUS_LATE);
            lane = running_.erase(lane);
        }
        for (; !script_.empty() && script_.begin()->first <= now; script_.erase(script_.begin())) {
            script_.begin()->second(now);
        }
        while (const auto action = scheduler_.poll(now)) {
            if (const auto *dispatch = action.dispatch()) {
                start(*dispatch, now);
            } else if (const auto *outcome = action.ended()) {
                static const char *const why[] = {"", " hopeless", " overload", " urgency", " full", " late", " fault", " removed"};
                const auto *end = outcome->completed() && !outcome->on_time() ? " late" : why[outcome->c().shed];
                line_ += " -" + job(outcome->task(), outcome->index()) + end;
            }
        }
        CHECK(scheduler_.polled().ok());
        if (!line_.empty()) {
            log_ += std::to_string(now.time_since_epoch() / 1ms) + line_ + '\n';
        }
    }

    void start(const red::Dispatch &dispatch, red::Time now) {
        const auto unit = scheduler_.unit(dispatch.unit);
        CHECK(unit.ok() && running_.count(dispatch.lane) == 0);
        const auto place = std::pair(unit->first().task(), unit->first().node());
        line_ += " " + names_[place] + job(place.first, unit->first().index()) + "/" + std::to_string(dispatch.lane.value());
        const auto time = times_.count(place) > 0 ? times_[place] : unit->wcet();
        running_[dispatch.lane] = {dispatch.unit, now + time};
    }

    /// The job's task by its number, and its own.
    static std::string job(red::TaskId task, std::uint64_t index) {
        return std::to_string(task.value() & 0xffff) + "." + std::to_string(index);
    }

    red::Scheduler &scheduler_;
    std::map<std::pair<red::TaskId, red::NodeId>, std::string> names_;
    std::map<std::pair<red::TaskId, red::NodeId>, red::Nanoseconds> times_;
    std::multimap<red::Time, std::function<void(red::Time)>> script_;
    std::map<red::LaneId, Running> running_;
    std::string line_, log_;
};

#endif
