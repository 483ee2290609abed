// What a graph is made of, and when its jobs come: Node and Timing.
#ifndef RED_NODE_HPP
#define RED_NODE_HPP

#include "values.hpp"
#include "words.hpp"

namespace red {

/// What an encoder reads. Encoders of the same weights, frame and capture share one execution.
struct Frame {
    /// Which weights it has, a number of the host's; up to 65,535.
    std::uint32_t weights = 0;
    /// Which frame it reads, a number of the host's; up to 65,535.
    std::uint32_t frame = 0;
    /// Who captures the frame; without it every job has its own capture.
    Result<SensorId> sensor = SensorId();
};

/// A node: what it costs, where it runs, what it is. What cannot be is the status of the call that takes it.
class Node {
public:
    [[nodiscard]] static Node ordinary(Duration wcet) noexcept { return Node(Role::Ordinary, wcet); }
    /// The shared encoder of a MIMONet.
    [[nodiscard]] static Node shared_encoder(Duration wcet, Frame frame) noexcept {
        Node node(Role::SharedEncoder, wcet);
        node.c_.weights = frame.weights;
        node.c_.frame = frame.frame;
        node.c_.sensor = frame.sensor->value();
        return node.unless(frame.sensor.status());
    }
    /// A decoder: a successor of its encoder that reads the encoder's result.
    [[nodiscard]] static Node decoder(Duration wcet) noexcept { return Node(Role::Decoder, wcet); }

    /// The shortest that it takes; 0 unless told.
    Node &best_case(Duration bcet) noexcept { return c_.bcet_ns = bcet.ns(), unless(bcet.status()); }
    /// Once started it keeps its lane; co-runners can add so much to its cost.
    Node &atomic(Duration contention = Nanoseconds(0)) noexcept {
        c_.atomic = 1;
        c_.contention_ns = contention.ns();
        return unless(contention.status());
    }
    /// Bytes that it needs of its pool's budget.
    Node &memory(std::uint64_t bytes) noexcept { return c_.memory_bytes = bytes, *this; }
    /// Where it runs; in the first pool unless told.
    Node &pool(Result<PoolId> pool) noexcept { return c_.pool = pool->value(), unless(pool.status()); }

    [[nodiscard]] Nanoseconds wcet() const noexcept { return duration_from(c_.wcet_ns); }
    [[nodiscard]] Nanoseconds best_case() const noexcept { return duration_from(c_.bcet_ns); }
    [[nodiscard]] bool is_atomic() const noexcept { return c_.atomic != 0; }
    [[nodiscard]] Nanoseconds contention() const noexcept { return duration_from(c_.contention_ns); }
    [[nodiscard]] std::uint64_t memory() const noexcept { return c_.memory_bytes; }
    [[nodiscard]] PoolId pool() const noexcept { return PoolId(c_.pool); }
    [[nodiscard]] Role role() const noexcept { return static_cast<Role>(c_.role); }
    /// Of an encoder.
    [[nodiscard]] Frame frame() const noexcept { return {c_.weights, c_.frame, SensorId(c_.sensor)}; }

    /// What about it cannot be, as far as it is seen before a graph takes it.
    [[nodiscard]] constexpr Status status() const noexcept {
        return c_.role < wrong ? RED_STATUS_OK : static_cast<red_status>(c_.role - wrong);
    }
    [[nodiscard]] const red_node &c() const noexcept { return c_; }

    /// An ordinary node that costs nothing.
    Node() noexcept : Node(Role::Ordinary, Nanoseconds(0)) {}

private:
    friend class Dag;
    // A role from here on is an error: beside the struct of C there is no room for one where nodes lie in an array.
    static constexpr std::uint32_t wrong = 0x8000'0000;

    Node(Role role, Duration wcet) noexcept {
        c_.struct_size = sizeof c_;
        c_.abi_version = RED_ABI_VERSION;
        c_.wcet_ns = wcet.ns();
        c_.role = static_cast<std::uint32_t>(role);
        c_.sensor = RED_NONE;
        unless(wcet.status());
    }
    Node &unless(Status error) noexcept {
        if (!error && status()) {
            c_.role = wrong + static_cast<std::uint32_t>(error.code());
        }
        return *this;
    }

    red_node c_{};
};
static_assert(sizeof(Node) == sizeof(red_node) && std::is_standard_layout_v<Node>, "an array of them is one of C's");

/// When a task's jobs come and are due, and what they are worth. What cannot be is the status of the call that takes it.
class Timing {
public:
    /// Jobs that come at any time and are due so long after their release; 1 ns to 2^62 ns.
    [[nodiscard]] static Timing sporadic(Duration deadline) noexcept { return Timing(deadline); }
    /// Period, or minimum time between releases, which admission counts with.
    Timing &every(Duration period) noexcept {
        c_.period_ns = period.ns();
        // For the library 0 says that none was declared, which is not what this call says.
        const Status zero = period.ns() == 0 ? RED_STATUS_ZERO_PERIOD : RED_STATUS_OK;
        status_ = first_error(status_, period, zero);
        return *this;
    }
    /// Higher survives overload longer; 1 unless told.
    Timing &value(std::uint32_t value) noexcept { return c_.value = value, *this; }
    /// At least `keep` of any `of` consecutive jobs are never shed by choice.
    Timing &floor(std::uint32_t keep, std::uint32_t of) noexcept {
        c_.floor_keep = keep;
        c_.floor_of = of;
        return *this;
    }

    [[nodiscard]] Status status() const noexcept { return status_; }
    [[nodiscard]] const red_timing &c() const noexcept { return c_; }

private:
    explicit Timing(Duration deadline) noexcept : status_(deadline.status()) {
        c_.struct_size = sizeof c_;
        c_.abi_version = RED_ABI_VERSION;
        c_.deadline_ns = deadline.ns();
        c_.value = 1;
    }

    red_timing c_{};
    Status status_{};
};

} // namespace red

#endif
