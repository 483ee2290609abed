// The capacity classes, and memory for them.
#ifndef RED_MEMORY_HPP
#define RED_MEMORY_HPP

#include "values.hpp"

namespace red {

/// 4 tasks of 16 nodes, 16 jobs in flight; 4 lanes in 2 pools, 64 events.
struct Caps4x16x16 {
    static constexpr std::size_t tasks = 4, nodes = 16, jobs = 16, lanes = 4, pools = 2, events = 64;
    static constexpr std::size_t scheduler_bytes = RED_SCHEDULER_4X16X16_BYTES, dag_bytes = RED_DAG_4X16X16_BYTES;

    /// What a scheduler needs of scheduler_bytes on this machine.
    [[nodiscard]] static std::size_t scheduler_needs() noexcept { return red_scheduler_bytes_4x16x16(); }
    static Status open(void *memory, std::size_t bytes, const red_config &config, red_scheduler &scheduler) noexcept {
        return red_scheduler_open_4x16x16(memory, bytes, &config, &scheduler);
    }
    static Status open(void *memory, std::size_t bytes, red_dag &dag) noexcept {
        return red_dag_open_4x16x16(memory, bytes, &dag);
    }
};

/// 8 tasks of 64 nodes, 32 jobs in flight; 8 lanes in 4 pools, 256 events.
struct Caps8x64x32 {
    static constexpr std::size_t tasks = 8, nodes = 64, jobs = 32, lanes = 8, pools = 4, events = 256;
    static constexpr std::size_t scheduler_bytes = RED_SCHEDULER_8X64X32_BYTES, dag_bytes = RED_DAG_8X64X32_BYTES;

    /// What a scheduler needs of scheduler_bytes on this machine.
    [[nodiscard]] static std::size_t scheduler_needs() noexcept { return red_scheduler_bytes_8x64x32(); }
    static Status open(void *memory, std::size_t bytes, const red_config &config, red_scheduler &scheduler) noexcept {
        return red_scheduler_open_8x64x32(memory, bytes, &config, &scheduler);
    }
    static Status open(void *memory, std::size_t bytes, red_dag &dag) noexcept {
        return red_dag_open_8x64x32(memory, bytes, &dag);
    }
};

/// 16 tasks of 256 nodes, 64 jobs in flight; 32 lanes in 32 pools, 1,024 events.
struct Caps16x256x64 {
    static constexpr std::size_t tasks = 16, nodes = 256, jobs = 64, lanes = 32, pools = 32, events = 1024;
    static constexpr std::size_t scheduler_bytes = RED_SCHEDULER_16X256X64_BYTES, dag_bytes = RED_DAG_16X256X64_BYTES;

    /// What a scheduler needs of scheduler_bytes on this machine.
    [[nodiscard]] static std::size_t scheduler_needs() noexcept { return red_scheduler_bytes_16x256x64(); }
    static Status open(void *memory, std::size_t bytes, const red_config &config, red_scheduler &scheduler) noexcept {
        return red_scheduler_open_16x256x64(memory, bytes, &config, &scheduler);
    }
    static Status open(void *memory, std::size_t bytes, red_dag &dag) noexcept {
        return red_dag_open_16x256x64(memory, bytes, &dag);
    }
};

/// The alignment that memory of one's own needs here; RED_ALIGN is always enough.
[[nodiscard]] inline std::size_t align() noexcept { return red_align(); }

/// Room for one thing of the library: static, a member, or in an allocator's memory. It has to outlive the handle that is
/// opened in it, so declare it first. It stays where it is.
template <class Caps, std::size_t Bytes>
class alignas(RED_ALIGN) Memory {
public:
    Memory() noexcept = default;
    Memory(const Memory &) = delete;
    Memory &operator=(const Memory &) = delete;

    [[nodiscard]] Span<std::byte> bytes() noexcept { return bytes_; }

private:
    std::byte bytes_[Bytes];
};

/// Room for a scheduler of a class.
template <class Caps>
class SchedulerMemory : public Memory<Caps, Caps::scheduler_bytes> {};

/// Room for a graph of a class.
template <class Caps>
class DagMemory : public Memory<Caps, Caps::dag_bytes> {};

} // namespace red

#endif
