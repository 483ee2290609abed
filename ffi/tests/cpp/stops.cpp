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

} // namespace

int main() {
    from_a_body();
    from_a_handler();
    by_the_clock();
    by_the_destructor();
    return check_end("stops");
}
