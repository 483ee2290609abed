// What the tests of running lanes share. No deadline is near and no period short, so that a slow machine changes nothing: under
// valgrind a release into a full table takes as long as a period of 1 ms.
#ifndef LANES_HPP
#define LANES_HPP

#include "tests.hpp"

#include <atomic>
#include <thread>

using red::Runtime;

inline red::DagMemory<Runtime::Caps> memory, edit_memory;

inline Runtime opened(std::uint32_t lanes) {
    return *Runtime::open(red::Config::redrt().lanes(lanes), red::RuntimeConfig::best_effort());
}

/// A task of one node with this body.
template <class Body>
red::Result<red::TaskId> task_of(Runtime &runtime, Body &body) {
    auto dag = red::Dag::open(memory);
    red::Bodies bodies;
    bodies.on(dag->add_node(red::Node::ordinary(1ms)), body);
    return runtime.add_task(*dag, bodies, red::Timing::sporadic(60s));
}

template <class Condition>
void until(Condition condition) {
    while (!condition()) {
        std::this_thread::sleep_for(1ms);
    }
}

/// Jobs that ended.
inline std::uint64_t jobs(const Runtime &runtime) {
    const auto report = runtime.report();
    return report->on_time() + report->missed();
}

inline red::Report ended_in_order(Runtime &runtime) {
    CHECK(runtime.stop().ok() && runtime.wait().ok());
    const auto report = *runtime.report();
    const auto end = *report.ending();
    CHECK(end.allocations() == 0 && end.surrender() == red::Surrender::No);
    CHECK(end.threads_died() == 0 && end.lanes_lost() == 0 && end.hung() == 0);
    return report;
}

#endif
