// Graphs, costs and bodies.
#include "robot.hpp"

#include <ctime>

using namespace std::chrono_literals;

namespace {

using Caps = red::Caps4x16x16;

// What nodes take. Their WCETs are more, for a machine that does other things too.
constexpr auto encoder_takes = 5ms;
constexpr auto others_take = 1ms;

red::Node encoder(red::Result<red::SensorId> front) { return red::Node::shared_encoder(10ms, {1, 0, front}); }

} // namespace

red::Status Robot::add_to(red::Scheduler &scheduler) {
    static red::DagMemory<Caps> cruise_memory, watch_memory;
    const auto front = scheduler.add_sensor(period);

    // The network is one node at first, and then refined into its encoder and decoders.
    auto dag = red::Dag::open(cruise_memory);
    const auto network = dag->add_node(red::Node::ordinary(16ms));
    const auto before = dag->add_node(red::Node::ordinary(3ms));
    const auto after = dag->add_node(red::Node::ordinary(3ms).atomic());
    const auto edges = dag->chain({before, network, after});
    const std::array decoders = {red::Node::decoder(3ms), red::Node::decoder(3ms)};
    const auto stage = dag->refine(network, encoder(front), decoders);
    // Nodes that come after the stage have moved up.
    camera_ = red::NodeId(before->value() + 2);
    control_ = red::NodeId(after->value() + 2);
    cruise_ = scheduler.add_task(*dag, red::Timing::sporadic(period).every(period).value(10).floor(3, 4));

    auto people = red::Dag::open(watch_memory);
    const auto same_encoder = people->add_node(encoder(front));
    const auto reader = people->add_node(red::Node::decoder(3ms));
    const auto edge = people->add_edge(same_encoder, reader);
    watch_ = scheduler.add_task(*people, red::Timing::sporadic(period).every(period));
    return red::first_error(edges, stage, cruise_, edge, watch_);
}

red::Status Robot::see_obstacle(red::Scheduler &scheduler, red::Time now) {
    static red::DagMemory<Caps> memory;
    auto edit = scheduler.edit(cruise_, memory);
    const auto detector = edit->add_node(red::Node::ordinary(6ms));
    const auto edges = edit->chain({camera_, detector, control_});
    if (!edges) {
        return edges;
    }
    const auto committed = scheduler.commit(*edit, now);
    if (committed) {
        detector_ = detector;
    }
    return committed.status();
}

red::Status Robot::lose_obstacle(red::Scheduler &scheduler, red::Time now) {
    static red::DagMemory<Caps> memory;
    auto edit = scheduler.edit(cruise_, memory);
    const auto removed = edit->remove_node(detector_);
    return removed ? scheduler.commit(*edit, now).status() : removed;
}

void Robot::body(red::TaskId, red::NodeId node) {
    // In both graphs node 0 is the encoder.
    const auto time = node == red::NodeId(0) ? encoder_takes : others_take;
    const auto used = [] {
        timespec now{};
        clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
        return std::chrono::seconds(now.tv_sec) + std::chrono::nanoseconds(now.tv_nsec);
    };
    for (const auto end = used() + time; used() < end;) {
    }
}
