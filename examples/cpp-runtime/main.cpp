// A camera, a network with a shared encoder, and control, on lanes of RED; an obstacle comes, and the graph gets one more
// network while the lanes run.
#include "options.hpp"
#include "robot.hpp"

#include <csignal>
#include <cstdio>

using namespace std::chrono_literals;

namespace {

volatile std::sig_atomic_t interrupted = 0;

void on_interrupt(int) { interrupted = 1; }

/// The graph: camera -> encoder -> lane, segment -> control. Two tasks read the camera's frames, so that an encoder's result
/// serves both.
struct Pipeline {
    red::Result<red::NodeId> encoder = RED_STATUS_UNKNOWN_NODE, control = RED_STATUS_UNKNOWN_NODE;
    red::Result<red::TaskId> task = RED_STATUS_UNKNOWN_TASK;
};

red::DagMemory<red::Runtime::Caps> memory, edit_memory;

Pipeline add_drive(red::Runtime &runtime, Robot &robot, red::Result<red::SensorId> front) {
    auto dag = red::Dag::open(memory);
    Pipeline drive;
    const auto camera = dag->add_node(red::Node::ordinary(300us));
    drive.encoder = dag->add_node(red::Node::shared_encoder(4ms, {1, 0, front}));
    const auto lane = dag->add_node(red::Node::decoder(1ms)), segment = dag->add_node(red::Node::decoder(1500us));
    drive.control = dag->add_node(red::Node::ordinary(500us));
    red::Bodies bodies;
    bodies.on<&Robot::grab>(camera, robot).on<&Robot::encode>(drive.encoder, robot).on<&Robot::decode>(lane, robot);
    bodies.on<&Robot::decode>(segment, robot).on<&Robot::steer>(drive.control, robot);
    const auto edges = red::first_error(
        dag->chain({camera, drive.encoder, lane, drive.control}), dag->chain({drive.encoder, segment, drive.control}));
    const auto timing = red::Timing::sporadic(40ms).every(33ms).value(2);
    drive.task = edges ? runtime.add_task(*dag, bodies, timing) : edges;
    return drive;
}

/// A task of lower value that watches the same frames.
red::Result<red::TaskId> add_watch(red::Runtime &runtime, Robot &robot, red::Result<red::SensorId> front) {
    auto dag = red::Dag::open(memory);
    const auto encoder = dag->add_node(red::Node::shared_encoder(4ms, {1, 0, front}));
    const auto depth = dag->add_node(red::Node::decoder(1ms));
    const auto edge = dag->add_edge(encoder, depth);
    red::Bodies bodies;
    bodies.on<&Robot::encode>(encoder, robot).on<&Robot::decode>(depth, robot);
    return edge ? runtime.add_task(*dag, bodies, red::Timing::sporadic(66ms).every(33ms)) : edge;
}

/// An obstacle: its detector goes between encoder and control, or out again. The next frames have the new graph.
red::Result<red::Certificate> edit(
    red::Runtime &runtime, Robot &robot, const Pipeline &drive, red::Result<red::NodeId> &detect, bool comes) {
    auto graph = runtime.edit(drive.task, edit_memory);
    if (!comes) {
        const auto removed = graph->remove_node(detect);
        return removed ? runtime.commit(*graph) : removed;
    }
    detect = graph->add_node(red::Node::decoder(2ms));
    const auto edges = graph->chain({drive.encoder, detect, drive.control});
    red::Bodies bodies;
    bodies.on<&Robot::detect>(detect, robot);
    return edges ? runtime.commit(*graph, bodies) : edges;
}

int give_up(const char *what, const char *why) {
    std::fprintf(stderr, "%s: %s\n", what, why);
    return 1;
}

void print_end(const red::Report &report) {
    const auto row = [](const char *name, std::uint64_t number) {
        std::printf("  %-28s %10llu\n", name, static_cast<unsigned long long>(number));
    };
    const auto latency = [](const char *name, red::Nanoseconds time) {
        std::printf("  dispatch latency, %-10s %10.3f us\n", name, static_cast<double>(time.count()) / 1e3);
    };
    std::printf("\n");
    row("jobs released", report.released());
    row("on time", report.on_time());
    row("missed", report.missed());
    row("  of them given up (shed)", report.shed());
    if (const auto end = report.ending()) {
        row("encoder runs saved", end->encoder_runs_saved());
        row("units dispatched", end->units());
        row("allocations while running", end->allocations());
        latency("p50", end->dispatch_p50());
        latency("p99", end->dispatch_p99());
        latency("max", end->dispatch_max());
        std::printf("  %-28s %10s\n", "lanes", end->real_time() ? "real time" : "best effort: no promise");
    }
}

} // namespace

int main(int count, char **words) {
    const Options options = options_of(count, words);
    if (options.wrong) {
        return 2;
    }
    std::signal(SIGINT, on_interrupt);

    // Before the runtime, so that bodies have it until the last one has returned.
    Robot robot;
    const auto config = options.best_effort ? red::RuntimeConfig::best_effort() : red::RuntimeConfig::real_time();
    auto runtime = red::Runtime::open(red::Config::redrt().lanes(1), config);
    const auto front = runtime->add_sensor(33ms);
    const Pipeline drive = add_drive(*runtime, robot, front);
    const auto watch = add_watch(*runtime, robot, front);
    const auto ready = red::first_error(runtime->every(drive.task, 0ms, 33ms), runtime->every(watch, 0ms, 33ms));
    if (!ready) {
        return give_up("set-up", ready.text());
    }
    if (const auto started = runtime->start(); !started) {
        char text[1024];
        std::fprintf(stderr, "no real time: %s\n", runtime->message(text));
        std::fprintf(stderr, "--best-effort runs without it, and without a promise\n");
        return started == RED_STATUS_NOT_PERMITTED ? 3 : 1;
    }
    std::printf(options.best_effort ? "best effort: no promise\n" : "real time\n");

    // An obstacle is there from the first to the second third of the time.
    red::Result<red::NodeId> detect = RED_STATUS_UNKNOWN_NODE;
    bool there = false;
    const auto begin = std::chrono::steady_clock::now();
    const std::chrono::milliseconds length = std::chrono::seconds(options.seconds);
    auto next_line = begin + 1s;
    while (!interrupted && runtime->wait(20ms) == RED_STATUS_TIMEOUT) {
        const auto since = std::chrono::steady_clock::now() - begin;
        if (since >= length) {
            break;
        }
        const bool comes = since >= length / 3 && since < length * 2 / 3;
        if (comes != there) {
            const auto proof = edit(*runtime, robot, drive, detect, comes);
            if (proof) {
                there = comes;
                std::printf("%5.1f s  the obstacle %s; bound of a frame's response %.1f ms, limit %.1f ms\n",
                    std::chrono::duration<double>(since).count(), comes ? "comes" : "is gone",
                    static_cast<double>(proof->response().count()) / 1e6,
                    static_cast<double>(proof->limit().count()) / 1e6);
            } else if (proof.status() != RED_STATUS_DRAINING) {
                return give_up("edit", proof.text());
            }
        }
        if (std::chrono::steady_clock::now() >= next_line) {
            next_line += 1s;
            if (const auto so_far = runtime->report()) {
                std::printf("%5.1f s  released %5llu  on time %5llu  missed %4llu  detections %4u\n",
                    std::chrono::duration<double>(since).count(), static_cast<unsigned long long>(so_far->released()),
                    static_cast<unsigned long long>(so_far->on_time()),
                    static_cast<unsigned long long>(so_far->missed()), robot.detections());
                std::fflush(stdout);
            }
        }
    }
    // The runtime may have ended itself; then this changes nothing.
    const auto stopped = runtime->stop();
    const auto ended = runtime->wait();
    const auto report = runtime->report();
    if (const auto status = red::first_error(stopped, ended, report); !status) {
        return give_up("end", status.text());
    }
    print_end(*report);
    const bool in_order = report->ending() && report->ending()->surrender() == red::Surrender::No;
    return in_order ? 0 : give_up("end", "the runtime gave up: a lane is lost");
}
