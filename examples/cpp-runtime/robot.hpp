// What runs on the lanes: stand-ins for networks, which use up about as much CPU time as is planned for them.
#ifndef ROBOT_HPP
#define ROBOT_HPP

#include <atomic>
#include <red.hpp>
#include <time.h>

class Robot {
public:
    // Eight tenths of the WCET: what is left is for what a busy machine adds.
    void grab(const red::Context &context) noexcept { burn(context.wcet()); }
    void encode(const red::Context &context) noexcept { burn(context.wcet()); }
    void decode(const red::Context &context) noexcept { burn(context.wcet()); }
    void detect(const red::Context &context) noexcept {
        detections_.fetch_add(1, std::memory_order_relaxed);
        burn(context.wcet());
    }
    void steer(const red::Context &context) noexcept { burn(context.wcet()); }

    [[nodiscard]] unsigned detections() const noexcept { return detections_.load(std::memory_order_relaxed); }

private:
    /// CPU time of this thread, so that one that has to wait for its CPU does no more.
    static void burn(red::Nanoseconds wcet) noexcept {
        const red::Nanoseconds until = cpu_time() + wcet * 8 / 10;
        while (cpu_time() < until) {
        }
    }
    static red::Nanoseconds cpu_time() noexcept {
        timespec now{};
        clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
        return std::chrono::seconds(now.tv_sec) + red::Nanoseconds(now.tv_nsec);
    }

    std::atomic<unsigned> detections_{0};
};

#endif
