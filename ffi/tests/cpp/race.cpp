// A race that ThreadSanitizer has to find: a body on a lane and this thread count without a lock.
#include "lanes.hpp"

int main() {
    int counted = 0;
    const auto count = [&] { counted++; };
    auto runtime = opened(1);
    CHECK(runtime.every(task_of(runtime, count), 0ms, 1ms).ok() && ended(runtime.start(), RED_OK));
    for (int i = 0; i < 50; i++) {
        counted++;
        std::this_thread::sleep_for(1ms);
    }
    ended_in_order(runtime);
    return check_end("race");
}
