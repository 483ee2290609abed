// A body out of which an exception comes in every other job, and one that calls back into its own runtime.
#include <cstdio>
#include <red.hpp>
#include <stdexcept>

using namespace std::chrono_literals;

static red::DagMemory<red::Caps16x256x64> memory, edit_memory;

int main() {
    auto runtime = red::Runtime::open(red::Config::redrt(), red::RuntimeConfig::best_effort());
    auto dag = red::Dag::open(memory);
    const auto node = dag->add_node(red::Node::ordinary(1ms));
    red::Result<red::TaskId> task = RED_STATUS_UNKNOWN_TASK;
    red::Status edited, waited, closed;
    const auto body = [&](const red::Context &context) {
        if (context.index() == 0) {
            auto edit = runtime->edit(task, edit_memory);
            edited = edit.status();
            waited = runtime->wait(0ms);
            red_runtime handle = runtime->c();
            closed = red_runtime_close(&handle);
            static_cast<void>(runtime->release(task).ok());
        }
        if (context.index() % 2 == 1) throw std::runtime_error("out of a body");
    };
    red::Bodies bodies;
    bodies.on(node, body);
    task = runtime->add_task(*dag, bodies, red::Timing::sporadic(1s));
    const auto started = runtime->start();
    if (!started) {
        std::printf("%s\n", started.text());
        return 1;
    }
    // The first one releases another from inside.
    for (unsigned released = 0; released < 9; released++) {
        if (!runtime->release(task)) return 2;
        const unsigned wanted = released + 2;
        for (;;) {
            const auto report = runtime->report();
            if (report->on_time() + report->missed() >= wanted) break;
        }
    }
    // One after the other: arguments of one call have no order.
    if (!runtime->stop()) return 3;
    if (!runtime->wait()) return 4;
    const auto report = runtime->report();
    std::printf("released %d, on time %d, shed %d, threw %d\n", int(report->released()), int(report->on_time()),
        int(report->shed()), int(report->threw()));
    std::printf("from the body: %d %d %d\n", int(edited.code()), int(waited.code()), int(closed.code()));
    red::Outcome room[16];
    int faults = 0;
    for (const auto &outcome : *runtime->take_outcomes(room)) faults += outcome.shed() == red::Shed::Fault;
    std::printf("faults %d\n", faults);
    return 0;
}
