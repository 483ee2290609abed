// Lanes that run: exceptions, releases from several threads, edits, tasks that come and go.
#include "lanes.hpp"

#include <vector>

namespace {

/// Every third job fails, by what a body returns or throws; the others, and other tasks, go on.
void failures() {
    auto runtime = opened(2);
    const auto throws = [](const red::Context &context) {
#ifdef __cpp_exceptions
        if (context.index() % 3 == 1) {
            throw 7;
        }
#else
        return context.index() % 3 == 1 ? RED_BODY_THREW : RED_BODY_DONE;
#endif
    };
    const auto fails = [](const red::Context &context) { return context.index() % 3 != 2; };
    const auto refuses = [](const red::Context &context) {
        return red::Status(context.index() % 3 == 0 ? RED_STATUS_MEMORY : RED_STATUS_OK);
    };
    int good = 0;
    const auto fine = [&] { good++; };
    const std::array tasks = {task_of(runtime, throws), task_of(runtime, fails), task_of(runtime, refuses), task_of(runtime, fine)};
    CHECK(ended(runtime.start(), RED_OK));
    std::uint64_t released = 0;
    for (int i = 0; i < 9; i++) {
        for (const auto &task : tasks) {
            CHECK(runtime.release(task).ok());
            released++;
            until([&] { return jobs(runtime) == released; });
        }
    }
    const auto report = ended_in_order(runtime);
    CHECK(report.threw() == 3 && report.ending()->failed() == 9 && report.shed() == 9 && report.on_time() == 27 && good == 9);
    std::array<red::Outcome, 64> room;
    std::size_t faults = 0;
    for (const auto &outcome : *runtime.take_outcomes(room)) {
        faults += outcome.shed() == red::Shed::Fault;
    }
    CHECK(faults == 9);
}

/// From eight threads and from bodies, all releases come, none twice.
void releases_from_everywhere() {
    constexpr int threads = 8, each = 100;
    auto runtime = opened(2);
    std::atomic<int> ran = 0, wrong = 0;
    const Runtime *self = &runtime;
    red::Result<red::TaskId> second = RED_STATUS_UNKNOWN_TASK;
    const auto count = [&] { ran++; };
    const auto again = [&](const red::Context &context) { return context.index() >= 50 || self->release(second).ok(); };
    const auto task = task_of(runtime, count);
    second = task_of(runtime, again);
    CHECK(ended(runtime.start(), RED_OK));
    std::vector<std::thread> others;
    for (int i = 0; i < threads; i++) {
        others.emplace_back([&] {
            for (int done = 0; done < each;) {
                const auto status = runtime.release(task);
                if (status.ok()) {
                    done++;
                } else if (status == RED_STATUS_MAILBOX_FULL || status == RED_STATUS_BUSY) {
                    std::this_thread::sleep_for(100us);
                } else {
                    wrong++;
                    done++;
                }
                static_cast<void>(runtime.report());
            }
        });
    }
    for (auto &other : others) {
        other.join();
    }
    until([&] { return jobs(runtime) == threads * each; });
    // What found no place among the jobs in flight was counted as shed.
    const auto before = runtime.report();
    CHECK(wrong == 0 && before->released() == threads * each && before->on_time() == static_cast<std::uint64_t>(ran));
    CHECK(before->on_time() + before->shed() == threads * each);
    CHECK(runtime.release(second).ok());
    until([&] { return jobs(runtime) == threads * each + 51; });
    ended_in_order(runtime);
}

/// A node comes and goes while lanes run.
void edits_while_lanes_run() {
    auto runtime = opened(2);
    std::atomic<int> ran = 0;
    const auto nothing = [] {};
    const auto seen = [&] { ran++; };
    auto dag = red::Dag::open(memory);
    const auto camera = dag->add_node(red::Node::ordinary(1ms)), control = dag->add_node(red::Node::ordinary(1ms));
    CHECK(dag->chain({camera, control}).ok());
    const auto task = runtime.add_task(*dag, red::Bodies().on(camera, nothing).on(control, nothing), red::Timing::sporadic(60s));
    CHECK(ended(runtime.every(task, 0ms, 10ms), RED_OK) && ended(runtime.start(), RED_OK));
    for (int i = 0; i < 20; i++) {
        const int before = ran;
        red::Status said;
        const auto commits = [&](const red::Dag &edit, const red::Bodies &bodies) {
            until([&] { return (said = runtime.commit(edit, bodies).status()) != RED_STATUS_DRAINING; });
            return said.ok();
        };
        red::Result<red::NodeId> detect = RED_STATUS_UNKNOWN_NODE;
        {
            auto edit = runtime.edit(task, edit_memory);
            detect = edit->add_node(red::Node::ordinary(1ms));
            CHECK(edit->chain({camera, detect, control}).ok());
            CHECK(commits(*edit, red::Bodies().on(detect, seen)));
        }
        until([&] { return ran > before; });
        auto edit = runtime.edit(task, edit_memory);
        CHECK(edit->remove_node(detect).ok() && commits(*edit, red::Bodies()));
    }
    CHECK(ended_in_order(runtime).ending()->failed() == 0);
}

/// What bodies of a removed task are called on is never that of the next one in its place.
template <int Which>
struct Own {
    std::atomic<int> &wrong;
    int mark = Which;
    void operator()() const { wrong += mark != Which; }
};

void tasks_that_replace_each_other() {
    auto runtime = opened(2);
    std::atomic<int> wrong = 0;
    Own<1> one{wrong};
    Own<2> two{wrong};
    CHECK(ended(runtime.start(), RED_OK));
    for (int i = 0; i < 200; i++) {
        const auto task = i % 2 == 0 ? task_of(runtime, one) : task_of(runtime, two);
        CHECK(runtime.release(task).ok() && runtime.release(task).ok());
        // So that lanes are about to call its body, or do.
        std::this_thread::sleep_for(i % 4 * 100us);
        CHECK(ended(runtime.remove_task(task), RED_OK));
    }
    ended_in_order(runtime);
    CHECK(wrong == 0);
}

/// Two runtimes do not know of each other, and one that is moved runs on.
void two_at_once() {
    auto first = opened(1), second = opened(1);
    std::atomic<int> a = 0, b = 0;
    const auto count_a = [&] { a++; };
    const auto count_b = [&] { b++; };
    CHECK(first.every(task_of(first, count_a), 0ms, 10ms).ok() && second.every(task_of(second, count_b), 0ms, 10ms).ok());
    CHECK(ended(first.start(), RED_OK) && ended(second.start(), RED_OK));
    until([&] { return a > 5 && b > 5; });
    ended_in_order(first);
    const int at_end = a, then = b;
    until([&] { return b > then + 5; });
    CHECK(a == at_end);
    Runtime moved = std::move(second);
    const int now = b;
    until([&] { return b > now + 5; });
    ended_in_order(moved);
}

} // namespace

int main() {
    failures();
    releases_from_everywhere();
    edits_while_lanes_run();
    tasks_that_replace_each_other();
    two_at_once();
    return check_end("lanes");
}
