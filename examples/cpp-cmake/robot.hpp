// What the robot sees: a camera, a network with a shared encoder, control; a second network that reads the same frames; and an
// obstacle that comes and goes.
#ifndef ROBOT_HPP
#define ROBOT_HPP

#include "executor.hpp"

class Robot {
public:
    static constexpr std::chrono::milliseconds period{50};

    /// Adds both tasks.
    red::Status add_to(red::Scheduler &scheduler);
    /// The obstacle is there: the graph gets its detector, for the jobs that come. RED_STATUS_DRAINING: again later.
    red::Status see_obstacle(red::Scheduler &scheduler, red::Time now);
    /// It is gone.
    red::Status lose_obstacle(red::Scheduler &scheduler, red::Time now);
    /// Burns as much CPU time as the node takes.
    static void body(red::TaskId task, red::NodeId node);

    [[nodiscard]] red::TaskId cruise() const { return *cruise_; }
    [[nodiscard]] red::TaskId watch() const { return *watch_; }

private:
    red::Result<red::TaskId> cruise_ = red::TaskId(), watch_ = red::TaskId();
    red::Result<red::NodeId> camera_ = red::NodeId(), control_ = red::NodeId(), detector_ = red::NodeId();
};

#endif
