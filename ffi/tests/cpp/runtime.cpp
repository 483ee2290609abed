// Every method of a runtime: what it answers, before the start, moved from, and closed.
#include "tests.hpp"

#include <cstring>
#include <type_traits>
#include <vector>

namespace {

using red::Runtime;
red::DagMemory<Runtime::Caps> memory, edit_memory;

Runtime opened(std::uint32_t lanes = 1) {
    return *Runtime::open(red::Config::redrt().lanes(lanes), red::RuntimeConfig::best_effort());
}

int ran;
void count() { ran++; }

/// Every call of a runtime that is not open says why.
void answers(Runtime &runtime, red_status why) {
    const red::TaskId task(0);
    std::array<red::Outcome, 4> outcomes;
    std::array<red::Event, 4> events;
    std::array<char, 64> text{};
    const auto dag = red::Dag::open(memory);
    const auto timing = red::Timing::sporadic(1s);
    CHECK(!runtime.is_open() && ended(runtime, why) && ended(runtime.add_pool(1), why) && ended(runtime.add_sensor(1ms), why));
    CHECK(ended(runtime.add_cuda_pool(1), why) && ended(runtime.pin({}), why) && ended(runtime.record("log"), why) && ended(runtime.every(task, 0ms, 1ms), why));
    CHECK(ended(runtime.once(task, 0ms), why) && ended(runtime.add_task(*dag, red::Bodies(), timing), why));
    CHECK(ended(runtime.remove_task(task), why) && ended(runtime.certificate(task), why));
    CHECK(ended(runtime.edit(task, edit_memory), why) && ended(runtime.commit(*dag), why) && ended(runtime.start(), why));
    CHECK(ended(runtime.commit(*dag, red::Bodies()), why) && ended(runtime.release(task), why) && ended(runtime.stop(), why));
    CHECK(ended(runtime.wait(), why) && ended(runtime.wait(1ms), why) && ended(runtime.state(), why));
    CHECK(ended(runtime.report(), why) && ended(runtime.figures(), why) && ended(runtime.take_outcomes(outcomes), why));
    std::array<red::Warning, 4> warnings;
    CHECK(ended(runtime.take_warnings(warnings), why) && ended(runtime.report(task), why));
    CHECK(ended(runtime.take_events(events), why) && std::strcmp(runtime.message(text), red_status_text(why)) == 0);
    CHECK(ended(runtime.close(), why));
}

void not_open() {
    Runtime never;
    answers(never, RED_STATUS_CLOSED);
    const auto effort = red::RuntimeConfig::best_effort();
    auto refused = Runtime::open(red::Config::redrt().lanes(0), effort);
    answers(*refused, RED_STATUS_NO_LANE);
    CHECK(ended(Runtime::open(red::Config::redrt().preempt(true), effort), RED_STATUS_PREEMPTS));
    CHECK(ended(Runtime::open(red::Config::redrt().merge(-1ms), effort), RED_STATUS_OUT_OF_RANGE));
    const auto policy = red::Config::redrt();
    CHECK(ended(Runtime::open(policy, red::RuntimeConfig::real_time(99)), RED_STATUS_OUT_OF_RANGE));
    CHECK(ended(Runtime::open(policy, red::RuntimeConfig::best_effort().duration(0s)), RED_STATUS_OUT_OF_RANGE));
    CHECK(ended(Runtime::open(policy, red::RuntimeConfig::best_effort().drain(-1s)), RED_STATUS_OUT_OF_RANGE));
    const auto config = red::RuntimeConfig::real_time(7).duration(2s).drain(3ms);
    CHECK(config.status().ok() && config.c().mode == RED_MODE_REAL_TIME && config.c().priority == 7);
    CHECK(config.c().duration_ns == 2'000'000'000 && config.c().drain_ns == 3'000'000);
    CHECK(red::RuntimeConfig::real_time().c().priority == 80 && effort.c().mode == RED_MODE_BEST_EFFORT);
    CHECK(effort.c().duration_ns == 0 && effort.c().drain_ns == 1'000'000'000);

    Runtime first = opened();
    Runtime second = std::move(first);
    CHECK(second.is_open() && second.add_pool(1).ok());
    answers(first, RED_STATUS_CLOSED);
    first = std::move(second);
    CHECK(first.is_open());
    answers(second, RED_STATUS_CLOSED);
    CHECK(first.close().ok());
    answers(first, RED_STATUS_CLOSED);
    static_assert(!std::is_copy_constructible_v<Runtime> && !std::is_copy_assignable_v<Runtime>);
    static_assert(std::is_nothrow_move_constructible_v<Runtime> && std::is_nothrow_move_assignable_v<Runtime>);
}

/// An error goes on from call to call.
void errors_go_on() {
    auto runtime = opened();
    const red::Result<red::TaskId> none = RED_STATUS_MEMORY;
    CHECK(ended(runtime.every(none, 0ms, 1ms), RED_STATUS_MEMORY) && ended(runtime.once(none, 0ms), RED_STATUS_MEMORY));
    CHECK(ended(runtime.remove_task(none), RED_STATUS_MEMORY) && ended(runtime.certificate(none), RED_STATUS_MEMORY));
    CHECK(ended(runtime.edit(none, edit_memory), RED_STATUS_MEMORY) && ended(runtime.release(none), RED_STATUS_MEMORY));
    CHECK(ended(runtime.every(red::TaskId(0), -1ms, 1ms), RED_STATUS_OUT_OF_RANGE));
    CHECK(ended(runtime.every(red::TaskId(0), 0ms, 0ms), RED_STATUS_ZERO_PERIOD) && ended(runtime.wait(-1ms), RED_STATUS_OUT_OF_RANGE));
    CHECK(ended(runtime.add_sensor(-1ms), RED_STATUS_OUT_OF_RANGE) && ended(runtime.add_sensor(0ms), RED_STATUS_ZERO_PERIOD));
    CHECK(ended(runtime.commit(red::Dag()), RED_STATUS_CLOSED) && ended(runtime.commit(red::Dag(RED_STATUS_OVERLAP)), RED_STATUS_OVERLAP));

    red::Bodies bodies;
    bodies.on<count>(red::Result<red::NodeId>(RED_STATUS_CYCLE));
    auto dag = red::Dag::open(memory);
    const auto node = dag->add_node(red::Node::ordinary(1ms));
    CHECK(ended(runtime.add_task(*dag, bodies, red::Timing::sporadic(1s)), RED_STATUS_CYCLE));
    red::Bodies many;
    for (int i = 0; i < 256; i++) {
        many.on<count>(node);
    }
    CHECK(many.status().ok() && ended(many.on<count>(node), RED_STATUS_TOO_LONG) && many.c().size() == 256);
    CHECK(ended(runtime.add_task(*dag, many, red::Timing::sporadic(1s)), RED_STATUS_TOO_LONG));
    CHECK(ended(runtime.add_task(*dag, red::Bodies(), red::Timing::sporadic(1s)), RED_STATUS_NO_BODY));
}

/// What a body may be, and what it is told.
struct Robot {
    int calls = 0;
    red::Time due{};
    void told(const red::Context &context) {
        calls++;
        due = context.deadline();
    }
    bool asked() const { return calls > 0; }
};
struct Counting {
    int calls = 0;
    red::Result<int> operator()() { return ++calls; }
};
red::Status fine() { return {}; }
int numbered(const red::Context &) { return RED_BODY_DONE; }
int of_c(void *user, const red_context *context) {
    *static_cast<std::uint32_t *>(user) = context->node;
    return RED_BODY_DONE;
}

void bodies_of_every_kind() {
    Robot robot;
    Counting counting;
    std::uint32_t of_c_ran = 0;
    std::uint64_t lambda_ran = 0;
    red::Time due{};
    const auto lambda = [&](const red::Context &context) {
        lambda_ran++;
        due = context.deadline();
        CHECK(context.index() == 0 && context.lane() == red::LaneId(0) && context.pool() == red::first_pool);
        CHECK(context.wcet() == 7ms && !context.has_output() && context.stream() == nullptr && context.c().node == 0);
        CHECK(context.release() + 60s == context.deadline() && context.sub_deadline() <= context.deadline());
        CHECK(context.release() <= Runtime::now() && context.node() == red::NodeId(0) && !context.task().is_none());
    };
    auto runtime = opened();
    auto dag = red::Dag::open(memory);
    std::array<red::Result<red::NodeId>, 8> nodes{RED_OK, RED_OK, RED_OK, RED_OK, RED_OK, RED_OK, RED_OK, RED_OK};
    for (std::size_t i = 0; i < nodes.size(); i++) {
        nodes[i] = dag->add_node(red::Node::ordinary(7ms));
        CHECK(i == 0 || dag->add_edge(nodes[i - 1], nodes[i]).ok());
    }
    red::Bodies bodies;
    bodies.on(nodes[0], lambda).on<&Robot::told>(nodes[1], robot).on<&Robot::asked>(nodes[2], std::as_const(robot));
    bodies.on(nodes[3], counting).on<fine>(nodes[4]).on<numbered>(nodes[5]).on<count>(nodes[6]).on(nodes[7], of_c, &of_c_ran);
    const auto task = runtime.add_task(*dag, bodies, red::Timing::sporadic(60s));
    CHECK(ended(runtime.once(task, 0ms), RED_OK) && *runtime.state() == red::RuntimeState::SetUp);
    const auto proof = runtime.certificate(task);
    CHECK(proof->fits() && proof->response() == 56ms && runtime.figures()->lanes() == 1);
    CHECK(!runtime.report()->ending() && ended(runtime.start(), RED_OK));
    while (runtime.report()->on_time() + runtime.report()->missed() == 0) {
    }
    CHECK(*runtime.state() == red::RuntimeState::Running && runtime.stop().ok() && runtime.wait().ok());
    CHECK(lambda_ran == 1 && robot.calls == 1 && robot.due == due && counting.calls == 1 && ran == 1 && of_c_ran == 7);
    const auto report = *runtime.report();
    CHECK(report.released() == 1 && report.on_time() == 1 && report.missed() == 0 && report.shed() == 0 && report.threw() == 0);
    CHECK(report.outcomes_dropped() == 0 && report.events_dropped() == 0 && report.state() == red::RuntimeState::Ended);
    const auto end = *report.ending();
    CHECK(!end.real_time() && end.stopped() && end.surrender() == red::Surrender::No && end.units() == 8 && end.failed() == 0);
    CHECK(end.allocations() == 0 && end.lanes_lost() == 0 && end.threads_died() == 0 && end.hung() == 0 && end.log_dropped() == 0);
    CHECK(end.dispatch_p50() <= end.dispatch_p99() && end.dispatch_p99() <= end.dispatch_max() && end.overhead_per_unit() > 0ns);
    CHECK(end.encoder_runs_saved() == 0 && end.nodes_missed() <= 8 && end.overruns() <= 8 && end.standstills() < 1000);
    CHECK(end.longest_standstill() >= 0ns && end.page_faults() < 1'000'000);
    const auto of_task = *runtime.report(task);
    CHECK(of_task.released() == 1 && of_task.on_time() == 1 && of_task.missed() == 0 && of_task.warned() == 0);
    CHECK(of_task.value_on_time() == 1 && of_task.value_released() == 1 && of_task.floor_kept() && of_task.floor_worst() == 0);
    for (const auto reason : {red::Shed::Not, red::Shed::Hopeless, red::Shed::Overload, red::Shed::Urgency, red::Shed::Full,
             red::Shed::Late, red::Shed::Fault, red::Shed::Removed}) {
        CHECK(of_task.given_up(reason) == 0);
    }
    std::array<red::Warning, 4> warnings;
    CHECK(of_task.c().released == 1 && runtime.take_warnings(warnings)->empty());
    std::array<red::Outcome, 4> outcomes;
    const auto taken = runtime.take_outcomes(outcomes);
    CHECK(taken->size() == 1 && (*taken)[0].on_time() && (*taken)[0].deadline() == due && (*taken)[0].task() == *task);
    std::array<red::Event, 64> events;
    CHECK(runtime.take_events(events)->size() >= 18 && events[0].kind() == red::EventKind::Released);
}

} // namespace

int main() {
    not_open();
    errors_go_on();
    bodies_of_every_kind();
    return check_end("runtime");
}
