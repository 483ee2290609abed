// How lanes come to their ends: by a body, a signal, the clock, a destructor.
#include "lanes.hpp"

#include <csignal>

namespace {

void from_a_body() {
    // Again and again: a body finds its runtime from the first instant on.
    for (int i = 0; i < 50; i++) {
        auto runtime = opened(2);
        const Runtime *self = &runtime;
        red::Status said = RED_STATUS_IDLE;
        const auto stop = [&] { said = self->stop(); };
        const auto task = task_of(runtime, stop);
        CHECK(runtime.once(task, 0ms).ok() && ended(runtime.start(), RED_OK));
        CHECK(ended(runtime.wait(), RED_OK) && ended(said, RED_OK));
        CHECK(runtime.report()->ending()->stopped() && ended(runtime.release(task), RED_STATUS_OVER));
    }
}

const Runtime *to_stop;
volatile std::sig_atomic_t handled;

void on_signal(int) {
    handled = handled + 1;
    static_cast<void>(to_stop->stop());
}

/// Of the program, which start leaves as it is.
void from_a_handler() {
    auto runtime = opened(1);
    to_stop = &runtime;
    struct sigaction mine {};
    mine.sa_handler = on_signal;
    CHECK(sigaction(SIGINT, &mine, nullptr) == 0);
    const auto nothing = [] {};
    CHECK(runtime.every(task_of(runtime, nothing), 0ms, 1ms).ok() && ended(runtime.start(), RED_OK));
    for (const int signal : {SIGINT, SIGTERM}) {
        struct sigaction now {};
        CHECK(sigaction(signal, nullptr, &now) == 0 && now.sa_handler == (signal == SIGINT ? on_signal : SIG_DFL));
    }
    until([&] { return jobs(runtime) > 3; });
    CHECK(ended(runtime.wait(1ms), RED_STATUS_TIMEOUT));
    CHECK(std::raise(SIGINT) == 0 && ended(runtime.wait(), RED_OK));
    CHECK(handled == 1 && runtime.report()->ending()->stopped() && std::signal(SIGINT, SIG_DFL) == on_signal);
}

void by_the_clock() {
    const auto nothing = [] {};
    auto runtime = Runtime::open(red::Config::redrt(), red::RuntimeConfig::best_effort().duration(20ms));
    CHECK(runtime->every(task_of(*runtime, nothing), 0ms, 5ms).ok() && ended(runtime->start(), RED_OK));
    CHECK(ended(runtime->wait(), RED_OK) && !runtime->report()->ending()->stopped());
    CHECK(runtime->report()->released() == 4);
}

/// Which waits for the body that runs.
void by_the_destructor() {
    std::atomic<int> begun = 0, done = 0;
    const auto slow = [&] {
        begun++;
        std::this_thread::sleep_for(20ms);
        done++;
    };
    {
        auto runtime = opened(1);
        CHECK(runtime.once(task_of(runtime, slow), 0ms).ok() && ended(runtime.start(), RED_OK));
        until([&] { return begun == 1; });
    }
    CHECK(done == 1);
}

/// Calls by copies of the handle end, and are told; none of them finds what is freed.
void while_others_call() {
    for (int i = 0; i < 20; i++) {
        const auto nothing = [] {};
        auto runtime = opened(1);
        const std::uint32_t task = task_of(runtime, nothing)->value();
        CHECK(ended(runtime.start(), RED_OK));
        std::atomic<int> calling = 0;
        const auto until_closed = [&calling, c = runtime.c()](auto call) {
            red_runtime copy = c;
            red_status said = call(copy);
            for (calling++; said != RED_STATUS_CLOSED; said = call(copy)) {
                CHECK(said == RED_OK || said == RED_STATUS_OVER || said == RED_STATUS_BUSY || said == RED_STATUS_MAILBOX_FULL);
            }
        };
        const auto release = [&](red_runtime &copy) { return red_runtime_release(&copy, task, RED_NONE_64); };
        const auto report = [](red_runtime &copy) {
            red_report told = RED_REPORT_INIT;
            return red_runtime_report(&copy, &told);
        };
        const auto wait = [](red_runtime &copy) { return red_runtime_wait(&copy, RED_NONE_64); };
        const auto figures = [](red_runtime &copy) {
            red_figures told = RED_FIGURES_INIT;
            return red_runtime_figures(&copy, &told);
        };
        std::thread others[] = {std::thread([&] { until_closed(release); }), std::thread([&] { until_closed(report); }),
            std::thread([&] { until_closed(figures); }), std::thread([&] { until_closed(wait); })};
        until([&] { return calling >= 3; });
        CHECK(ended(runtime.close(), RED_OK));
        for (std::thread &other : others) {
            other.join();
        }
    }
}

/// A start that is under way meanwhile is stopped, too; of two that close it, one does.
void while_others_start_and_close() {
    for (int i = 0; i < 20; i++) {
        auto runtime = opened(1);
        red_runtime first = runtime.c(), second = runtime.c();
        red_status started = RED_OK, said = RED_OK;
        std::thread starts([&] { started = red_runtime_start(&first); });
        std::thread closes([&] { said = red_runtime_close(&second); });
        const auto mine = runtime.close();
        starts.join();
        closes.join();
        CHECK(mine.ok() != (said == RED_OK) && (mine.ok() || ended(mine, RED_STATUS_CLOSED)));
        CHECK(started == RED_OK || started == RED_STATUS_CLOSED);
    }
}

/// A stop that comes before the lanes do is kept for them.
void while_another_starts() {
    for (int i = 0; i < 20; i++) {
        const auto nothing = [] {};
        auto runtime = opened(1);
        CHECK(runtime.every(task_of(runtime, nothing), 0ms, 1ms).ok());
        red_runtime copy = runtime.c();
        red_status started = RED_OK;
        std::thread starts([&] { started = red_runtime_start(&copy); });
        for (auto said = runtime.stop(); !said.ok(); said = runtime.stop()) {
            CHECK(ended(said, RED_STATUS_IDLE));
        }
        starts.join();
        CHECK(started == RED_OK && ended(runtime.wait(), RED_OK) && runtime.report()->ending()->stopped());
    }
}

/// Whatever the period is, as one that was meant in seconds.
void with_more_releases_than_any_lane_can_make() {
    std::atomic<int> ran = 0;
    const auto count = [&] { ran++; };
    auto runtime = opened(1);
    CHECK(runtime.every(task_of(runtime, count), 0ns, 1ns).ok() && ended(runtime.start(), RED_OK));
    until([&] { return ran > 2; });
    CHECK(runtime.figures().status().ok() && runtime.stop().ok() && ended(runtime.wait(), RED_OK));
}

} // namespace

int main() {
    from_a_body();
    from_a_handler();
    by_the_clock();
    by_the_destructor();
    while_others_call();
    while_others_start_and_close();
    while_another_starts();
    with_more_releases_than_any_lane_can_make();
    return check_end("stops");
}
