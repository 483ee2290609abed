// Nothing of the headers or the library allocates, whether calls succeed or fail.
#include "tests.hpp"

#include <cstdlib>
#include <cstring>
#include <malloc.h>

namespace {

red::SchedulerMemory<Small> memory;
red::DagMemory<Small> dag_memory, edit_memory;

void use() {
    auto scheduler = red::Scheduler::open(memory, red::Config::redrt().lanes(2));
    auto dag = red::Dag::open(dag_memory);
    const auto a = dag->add_node(red::Node::ordinary(2ms)), b = dag->add_node(red::Node::ordinary(1ms));
    CHECK(dag->add_edge(a, b).ok() && ended(dag->add_edge(b, a), RED_STATUS_CYCLE));
    const auto task = scheduler->add_task(*dag, red::Timing::sporadic(10ms));
    auto edit = scheduler->edit(task, edit_memory);
    CHECK(scheduler->commit(*edit, at(0ns)).ok());
    for (auto now = at(0ns); now < at(100ms); now += 1ms) {
        static_cast<void>(scheduler->release(task, now));
        while (const auto action = scheduler->poll(now)) {
            if (const auto *dispatch = action.dispatch()) {
                CHECK(scheduler->complete(dispatch->unit, now).ok());
            }
        }
    }
}

/// Under sanitizers and valgrind the C library's numbers tell nothing.
bool has_own_allocator() {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
    return true;
#else
    const char *preload = std::getenv("LD_PRELOAD");
    return preload != nullptr && std::strstr(preload, "vgpreload") != nullptr;
#endif
}

} // namespace

int main() {
    use();
    const auto before = mallinfo2();
    use();
    const auto after = mallinfo2();
    CHECK(before.uordblks == after.uordblks && before.arena == after.arena && before.hblks == after.hblks);
    // That these numbers tell: not under sanitizers and valgrind, which have an allocator of their own.
    void *some = std::malloc(100'000);
    const bool told = mallinfo2().uordblks > after.uordblks || mallinfo2().hblks > after.hblks;
    CHECK(told || has_own_allocator());
    std::printf("allocations are %s\n", told ? "seen" : "not seen here");
    std::free(some);
    return check_end("quiet");
}
