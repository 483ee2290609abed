// Lanes that are streams of a CUDA device, by a stand-in for its driver: bodies submit to the stream that they are given, and
// what follows them on the device does not wait for the CPU.
//
// usage: cuda [lost | none]
//
// "lost": the stand-in's script ends the device after a while. "none": it has no device.
#include "lanes.hpp"

#include <cstring>
#include <dlfcn.h>
#include <vector>

namespace {

/// What a body calls, as PyTorch and TensorRT do: the driver, on the stream that it was given.
using HostFunction = void (*)(void *);
unsigned (*launch)(void *stream, HostFunction function, void *user);

/// When a node's work ran on its stream, by job.
struct Work {
    std::vector<std::atomic<std::uint64_t>> begin, end;
    int took_us;
    std::atomic<std::uint64_t> next{0};
    explicit Work(int took) : begin(4096), end(4096), took_us(took) {}
    void submit(const red::Context &context) {
        CHECK(context.stream() != nullptr && context.pool() == red::PoolId(1) && context.index() < begin.size());
        launched = launch(context.stream(), run, this);
    }
    static void run(void *user) {
        Work &work = *static_cast<Work *>(user);
        const std::uint64_t job = work.next++;
        work.begin[job] = now();
        std::this_thread::sleep_for(std::chrono::microseconds(work.took_us));
        work.end[job] = now();
    }
    static std::uint64_t now() { return static_cast<std::uint64_t>(Runtime::now().time_since_epoch().count()); }
    // Two jobs may be on two streams at once.
    std::atomic<unsigned> launched{0};
};

struct Robot {
    Work encoder{2000}, lane{1000}, objects{1500};
    std::vector<std::atomic<std::uint64_t>> steered = std::vector<std::atomic<std::uint64_t>>(4096);
    bool refuses = false;
    void control(const red::Context &context) {
        CHECK(context.stream() == nullptr);
        steered[context.index()] = Work::now();
    }
    bool see(const red::Context &context) {
        encoder.submit(context);
        return !(refuses && context.index() == 3);
    }
};

red::Result<red::TaskId> robot_task(Runtime &runtime, red::PoolId gpu, Robot &robot) {
    auto dag = red::Dag::open(memory);
    const auto encoder = dag->add_node(red::Node::ordinary(4ms).pool(gpu));
    const auto lane = dag->add_node(red::Node::ordinary(3ms).pool(gpu)), objects = dag->add_node(red::Node::ordinary(3ms).pool(gpu));
    const auto control = dag->add_node(red::Node::ordinary(1ms));
    CHECK(dag->add_edge(encoder, lane).ok() && dag->add_edge(encoder, objects).ok());
    CHECK(dag->add_edge(lane, control).ok() && dag->add_edge(objects, control).ok());
    red::Bodies bodies;
    bodies.on<&Robot::see>(encoder, robot).on<&Work::submit>(lane, robot.lane).on<&Work::submit>(objects, robot.objects);
    bodies.on<&Robot::control>(control, robot);
    return runtime.add_task(*dag, bodies, red::Timing::sporadic(60s));
}

void runs() {
    Robot robot;
    auto runtime = opened(1);
    const auto gpu = runtime.add_cuda_pool(2);
    CHECK(gpu.ok() && *gpu == red::PoolId(1) && ended(runtime.add_cuda_pool(1, RED_NONE_64, 1), RED_STATUS_OUT_OF_RANGE));
    const auto task = robot_task(runtime, *gpu, robot);
    CHECK(task.ok() && runtime.every(task, 0ms, 10ms).ok() && runtime.start().ok());
    until([&] { return jobs(runtime) >= 40; });
    const auto report = ended_in_order(runtime);
    const std::uint64_t done = report.on_time();
    CHECK(done >= 40 && report.missed() == 0 && robot.encoder.launched == 0);
    // Jobs end in the order of their release: all have one deadline after it.
    for (std::uint64_t job = 0; job < done; job++) {
        CHECK(robot.lane.begin[job] >= robot.encoder.end[job] && robot.objects.begin[job] >= robot.encoder.end[job]);
        CHECK(robot.steered[job] >= robot.lane.end[job] && robot.steered[job] >= robot.objects.end[job]);
    }
    const auto end = *report.ending();
    CHECK(end.submissions_ahead() > 40 && end.event_waits_issued() > 0 && end.event_waits_avoided() > 0);
    CHECK(end.device_error() == 0 && end.late_memory_bytes() == 0 && end.failed() == 0);
}

void a_body_that_fails_gives_its_job_up() {
    Robot robot;
    robot.refuses = true;
    auto runtime = opened(1);
    const auto gpu = runtime.add_cuda_pool(2);
    CHECK(runtime.every(robot_task(runtime, *gpu, robot), 0ms, 30ms).ok() && runtime.start().ok());
    until([&] { return jobs(runtime) >= 10; });
    const auto report = ended_in_order(runtime);
    CHECK(report.missed() == 1 && report.shed() == 1 && report.ending()->failed() == 1);
}

void a_device_that_is_lost_ends_what_needs_it() {
    Robot robot;
    std::atomic<int> alone{0};
    auto count = [&] { alone++; };
    auto runtime = opened(1);
    const auto gpu = runtime.add_cuda_pool(2);
    CHECK(runtime.every(robot_task(runtime, *gpu, robot), 0ms, 20ms).ok());
    CHECK(runtime.every(task_of(runtime, count), 0ms, 20ms).ok() && runtime.start().ok());
    until([&] { return jobs(runtime) >= 60 && alone >= 25; });
    CHECK(runtime.stop().ok() && runtime.wait().ok());
    const auto report = *runtime.report();
    const auto end = *report.ending();
    CHECK(end.device_error() == 700 && end.lanes_lost() == 2 && report.shed() >= 10);
    CHECK(end.surrender() == red::Surrender::No);
}

void none() {
    auto runtime = opened(1);
    CHECK(ended(runtime.add_cuda_pool(1), RED_STATUS_CUDA));
    std::array<char, 1024> text{};
    CHECK(std::strstr(runtime.message(text), "nvidia-smi") != nullptr);
    // It can be done without.
    int ran = 0;
    auto count = [&] { ran++; };
    CHECK(runtime.once(task_of(runtime, count), 0ms).ok() && runtime.start().ok());
    until([&] { return jobs(runtime) == 1; });
    CHECK(ended_in_order(runtime).on_time() == 1 && ran == 1);
}

} // namespace

int main(int count, char **words) {
    const std::string what = count > 1 ? words[1] : "";
    if (what == "none") {
        none();
        return 0;
    }
    void *driver = dlopen("libcuda.so.1", RTLD_NOW);
    CHECK(driver != nullptr);
    void *function = dlsym(driver, "cuLaunchHostFunc");
    std::memcpy(&launch, &function, sizeof launch);
    if (what == "lost") {
        a_device_that_is_lost_ends_what_needs_it();
    } else {
        runs();
        a_body_that_fails_gives_its_job_up();
    }
    return 0;
}
