// Scenes driven to their end in virtual time; every action at its instant. A line is an instant in ms and what was done:
// "enc0.2/1" starts node enc of job 2 of task 0 on lane 1, "-0.2" is its end, with the reason if it is not on time.
#include "drive.hpp"

namespace {

red::SchedulerMemory<Small> memory;
red::DagMemory<Small> dag_memory, edit_memory;

void same(const char *scene, const std::string &log, const std::string &expected) {
    if (log != expected) {
        std::fprintf(stderr, "%s was\n%s, expected\n%s", scene, log.c_str(), expected.c_str());
    }
    CHECK(log == expected);
}

/// A diamond with a MIMONet in it, another task that reads the same frames with the same encoder, and an edit while jobs run.
void sharing() {
    auto scheduler = red::Scheduler::open(memory, red::Config::redrt().lanes(2));
    const auto cpu = scheduler->add_pool(1);
    const auto front = scheduler->add_sensor(20ms);
    const red::Frame frame{1, 0, front};
    red::Result<red::TaskId> cruise = RED_STATUS_UNKNOWN_TASK, watch = RED_STATUS_UNKNOWN_TASK;
    Drive drive(*scheduler);

    auto dag = red::Dag::open(dag_memory);
    const auto camera = dag->add_node(red::Node::ordinary(2ms).pool(cpu));
    const auto stage = dag->add_node(red::Node::ordinary(9ms));
    const auto depth = dag->add_node(red::Node::ordinary(3ms));
    const auto control = dag->add_node(red::Node::ordinary(2ms).atomic().pool(cpu));
    auto built = red::first_error(dag->chain({camera, stage, control}), dag->chain({camera, depth, control}));
    const std::array decoders = {red::Node::decoder(2ms), red::Node::decoder(3ms)};
    const auto net = dag->refine(stage, red::Node::shared_encoder(4ms, frame), decoders);
    // Nodes after the stage have moved up by as many as were added.
    const red::NodeId depth_now(depth->value() + 2), control_now(control->value() + 2);
    cruise = scheduler->add_task(*dag, red::Timing::sporadic(20ms).every(20ms));
    CHECK(red::first_error(built, net, cruise, dag->close()).ok());
    drive.name(cruise, camera, "cam");
    drive.name(cruise, net->encoder, "enc");
    drive.name(cruise, net->decoder(0), "lane");
    drive.name(cruise, net->decoder(1), "seg");
    drive.name(cruise, depth_now, "depth");
    drive.name(cruise, control_now, "ctl");

    dag = red::Dag::open(dag_memory);
    const auto encoder = dag->add_node(red::Node::shared_encoder(4ms, frame));
    const auto people = dag->add_node(red::Node::decoder(2ms));
    built = dag->add_edge(encoder, people);
    watch = scheduler->add_task(*dag, red::Timing::sporadic(30ms).every(20ms));
    CHECK(red::first_error(built, watch).ok());
    drive.name(watch, encoder, "enc");
    drive.name(watch, people, "people");

    for (const auto time : {0ms, 20ms, 40ms}) {
        drive.release(time, cruise);
        drive.release(time, watch);
    }
    // An obstacle, while job 1 runs, which keeps its graph: job 2 has the detector.
    drive.when(25ms, [&](red::Time now) {
        auto edit = scheduler->edit(cruise, edit_memory);
        const auto detect = edit->add_node(red::Node::ordinary(3ms));
        const auto edges = edit->chain({camera, detect, control_now});
        const auto proof = scheduler->commit(*edit, now);
        CHECK(red::first_error(edges, proof).ok() && proof->fits() && proof->work() == 19ms);
        drive.name(cruise, detect, "detect");
    });
    same("sharing", drive.run(),
        "0 enc1.0/0 cam0.0/2\n"
        "2 depth0.0/1\n"
        "4 seg0.0/0\n"
        "5 lane0.0/1\n"
        "7 people1.0/0 ctl0.0/2\n"
        "9 -0.0 -1.0\n"
        "20 enc1.1/0 cam0.1/2\n"
        "22 depth0.1/1\n"
        "24 seg0.1/0\n"
        "25 lane0.1/1\n"
        "27 people1.1/0 ctl0.1/2\n"
        "29 -0.1 -1.1\n"
        "40 enc1.2/0 cam0.2/2\n"
        "42 depth0.2/1\n"
        "44 seg0.2/0\n"
        "45 detect0.2/1\n"
        "47 lane0.2/0\n"
        "48 people1.2/1\n"
        "49 ctl0.2/2\n"
        "50 -1.2\n"
        "51 -0.2\n");
    CHECK(scheduler->figures()->encoder_runs_saved() == 3);
}

/// More load than a lane takes, 1.25 times: the task of the higher value loses nothing. When a release makes one of its jobs
/// late, a job of the other task goes, two of ten, and every job that runs is in time.
void overload() {
    auto scheduler = red::Scheduler::open(
        memory, red::Config::redrt().best_case(red::BestCase::Declared).overload_ticks(1));
    const auto load = [&](red::Nanoseconds wcet, red::Timing timing) {
        auto dag = red::Dag::open(dag_memory);
        const auto node = dag->add_node(red::Node::ordinary(wcet));
        const auto task = scheduler->add_task(*dag, timing);
        CHECK(red::first_error(node, task).ok());
        return task;
    };
    const auto high = load(10ms, red::Timing::sporadic(25ms).value(9));
    const auto low = load(15ms, red::Timing::sporadic(40ms).floor(1, 2));
    Drive drive(*scheduler);
    drive.name(high, red::NodeId(0), "h");
    drive.name(low, red::NodeId(0), "l");
    for (auto time = 0ms; time < 200ms; time += 20ms) {
        drive.release(time, high);
        drive.release(time, low);
    }
    same("overload", drive.run(),
        "0 h0.0/0\n"
        "10 -0.0 l1.0/0\n"
        "25 -1.0 h0.1/0\n"
        "35 -0.1 l1.1/0\n"
        "50 -1.1 h0.2/0\n"
        "60 -0.2 l1.2/0\n"
        "75 -1.2 h0.3/0\n"
        "80 -1.3 overload\n"
        "85 -0.3 h0.4/0\n"
        "95 -0.4 l1.4/0\n"
        "110 -1.4 h0.5/0\n"
        "120 -0.5 l1.5/0\n"
        "135 -1.5 h0.6/0\n"
        "140 -1.6 overload\n"
        "145 -0.6 h0.7/0\n"
        "155 -0.7 l1.7/0\n"
        "170 -1.7 h0.8/0\n"
        "180 -0.8 l1.8/0\n"
        "195 -1.8 h0.9/0\n"
        "205 -0.9 l1.9/0\n"
        "220 -1.9\n");
}

/// A pool of two lanes with memory for one network at a time.
void budget() {
    auto scheduler = red::Scheduler::open(memory, red::Config::redrt().lanes(2).memory(100));
    auto dag = red::Dag::open(dag_memory);
    const auto large = dag->add_node(red::Node::ordinary(4ms).memory(80));
    const auto other = dag->add_node(red::Node::ordinary(3ms).memory(30));
    const auto small = dag->add_node(red::Node::ordinary(2ms).memory(20));
    const auto task = scheduler->add_task(*dag, red::Timing::sporadic(50ms));
    CHECK(red::first_error(large, other, small, task).ok() && !scheduler->certificate(task)->memory_holds());
    Drive drive(*scheduler);
    drive.name(task, large, "large");
    drive.name(task, other, "other");
    drive.name(task, small, "small");
    drive.release(0ms, task);
    drive.when(1ms, [&](red::Time) { CHECK(*scheduler->memory_used(red::first_pool) == 100); });
    same("budget", drive.run(),
        "0 large0.0/0 small0.0/1\n"
        "4 other0.0/0\n"
        "7 -0.0\n");
    CHECK(*scheduler->memory_used(red::first_pool) == 0);
}

} // namespace

int main() {
    sharing();
    overload();
    budget();
    return check_end("scenario");
}
