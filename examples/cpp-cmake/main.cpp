// A robot's perception on an executor of its own: robot [--seconds N]. Ctrl-C ends it with the summary too.
#include "robot.hpp"

#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>

using namespace std::chrono_literals;

namespace {

volatile std::sig_atomic_t interrupted = 0;

void interrupt(int) { interrupted = 1; }

void report(const Counts &counts, const red::Figures &figures) {
    const struct {
        const char *what;
        std::uint64_t count;
    } rows[] = {
        {"released", counts.released},
        {"on time", counts.on_time},
        {"missed", counts.missed},
        {"shed", counts.shed},
        {"units dispatched", figures.units()},
        {"encoder runs saved", figures.encoder_runs_saved()},
        {"calls refused", counts.refused},
    };
    for (const auto &row : rows) {
        std::printf("%-20s %8llu\n", row.what, static_cast<unsigned long long>(row.count));
    }
}

int run(red::Scheduler scheduler, Robot &robot, std::chrono::seconds length) {
    Executor executor(std::move(scheduler), Robot::body);
    const red::Time begin = std::chrono::steady_clock::now(), end = begin + length;
    const red::Time comes = begin + length / 3, goes = begin + length * 2 / 3;
    bool is_there = false;
    for (red::Time frame = begin; frame < end && interrupted == 0; frame += Robot::period) {
        executor.run_until(frame);
        const bool there = frame >= comes && frame < goes;
        if (there != is_there) {
            const red::Status edited = executor.with([&](red::Scheduler &it, red::Time now) {
                return there ? robot.see_obstacle(it, now) : robot.lose_obstacle(it, now);
            });
            // The graph before still has jobs: at the next frame, then.
            if (edited) {
                is_there = there;
                std::printf("%s\n", there ? "an obstacle comes into sight" : "the obstacle is gone");
            } else if (edited != RED_STATUS_DRAINING) {
                std::fprintf(stderr, "%s\n", edited.text());
                return 1;
            }
        }
        executor.release(robot.cruise());
        executor.release(robot.watch());
    }
    const bool is_drained = executor.drain();
    const auto figures = executor.with([](const red::Scheduler &it, red::Time) { return it.figures(); });
    const Counts counts = executor.counts();
    std::printf("%s\n", interrupted != 0 ? "interrupted" : "done");
    report(counts, *figures);
    const bool is_complete = is_drained && counts.released == counts.on_time + counts.missed + counts.shed;
    return is_complete && counts.refused == 0 ? 0 : 1;
}

} // namespace

int main(int count, char **words) {
    long seconds = 10;
    if (count == 3 && std::strcmp(words[1], "--seconds") == 0) {
        seconds = std::strtol(words[2], nullptr, 10);
    }
    if ((count != 1 && count != 3) || seconds < 1 || seconds > 86'400) {
        std::fprintf(stderr, "usage: robot [--seconds N]\n");
        return 2;
    }
    std::signal(SIGINT, interrupt);
    std::signal(SIGTERM, interrupt);

    static red::SchedulerMemory<red::Caps4x16x16> memory;
    Robot robot;
    auto scheduler = red::Scheduler::open(memory, red::Config::redrt().lanes(Executor::lanes));
    if (const red::Status added = robot.add_to(*scheduler); !added) {
        std::fprintf(stderr, "%s\n", added.text());
        return 1;
    }
    return run(std::move(*scheduler), robot, std::chrono::seconds(seconds));
}
