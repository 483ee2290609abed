// What graphs and rules say: summaries, levels, certificates.
#ifndef RED_PROOF_HPP
#define RED_PROOF_HPP

#include "values.hpp"
#include "words.hpp"

namespace red {

/// What a graph says as a whole.
class Summary {
public:
    Summary() noexcept { c_.struct_size = sizeof c_, c_.abi_version = RED_ABI_VERSION; }
    [[nodiscard]] std::uint32_t nodes() const noexcept { return c_.nodes; }
    /// The greatest height plus one.
    [[nodiscard]] std::uint32_t levels() const noexcept { return c_.levels; }
    /// W: sum of all costs.
    [[nodiscard]] Nanoseconds work() const noexcept { return duration_from(c_.work_ns); }
    /// L: cost of the critical path.
    [[nodiscard]] Nanoseconds critical_path() const noexcept { return duration_from(c_.critical_path_ns); }
    [[nodiscard]] const red_dag_summary &c() const noexcept { return c_; }

private:
    friend class Dag;
    red_dag_summary c_{};
};

/// Where a node stands in its graph, and when it is due.
class PlacedNode {
public:
    [[nodiscard]] NodeId node() const noexcept { return NodeId(c_.node); }
    /// The longest chain of edges to it.
    [[nodiscard]] std::uint32_t height() const noexcept { return c_.height; }
    /// Longest path cost after it, excluding it.
    [[nodiscard]] Nanoseconds tail() const noexcept { return duration_from(c_.tail_ns); }
    /// When it should end, after the release; below 0 where the deadline is below the critical path.
    [[nodiscard]] Nanoseconds sub_deadline() const noexcept { return Nanoseconds(c_.sub_deadline_ns); }
    /// What dispatch orders by: the sub-deadline, under Rule::LatestStart less the node's cost.
    [[nodiscard]] Nanoseconds key() const noexcept { return Nanoseconds(c_.key_ns); }
    [[nodiscard]] const red_placed_node &c() const noexcept { return c_; }

private:
    red_placed_node c_{};
};

/// What a level asks for and gets of a deadline.
class Level {
public:
    /// Of its nodes.
    [[nodiscard]] Nanoseconds cost() const noexcept { return duration_from(c_.cost_ns); }
    /// Graham's bound of it alone.
    [[nodiscard]] Nanoseconds graham() const noexcept { return duration_from(c_.graham_ns); }
    /// Length of its share.
    [[nodiscard]] Nanoseconds share() const noexcept { return duration_from(c_.share_ns); }
    /// When its share ends, after the release; of the last level, the deadline exactly.
    [[nodiscard]] Nanoseconds end() const noexcept { return duration_from(c_.end_ns); }
    [[nodiscard]] const red_level &c() const noexcept { return c_; }

private:
    red_level c_{};
};

/// A bound on the response time of a job that has its pools to itself.
class Certificate {
public:
    Certificate() noexcept { c_.struct_size = sizeof c_, c_.abi_version = RED_ABI_VERSION; }
    /// Whether the bound is met.
    [[nodiscard]] bool fits() const noexcept { return c_.fits != 0; }
    [[nodiscard]] Bound bound() const noexcept { return static_cast<Bound>(c_.bound); }
    /// Of Bound::LongPath: how many paths were peeled.
    [[nodiscard]] std::uint32_t paths() const noexcept { return c_.paths; }
    /// Lanes of the task's pool; the largest number where it uses several.
    [[nodiscard]] std::uint32_t lanes() const noexcept { return c_.lanes; }
    /// Whether memory cannot make a ready node wait; where it can, the bound is not sufficient.
    [[nodiscard]] bool memory_holds() const noexcept { return c_.memory_holds != 0; }
    /// W: sum of all costs.
    [[nodiscard]] Nanoseconds work() const noexcept { return duration_from(c_.work_ns); }
    /// L: cost of the critical path.
    [[nodiscard]] Nanoseconds critical_path() const noexcept { return duration_from(c_.critical_path_ns); }
    /// The bound's value.
    [[nodiscard]] Nanoseconds response() const noexcept { return duration_from(c_.response_ns); }
    /// What it must not exceed: the smaller of deadline and period.
    [[nodiscard]] Nanoseconds limit() const noexcept { return duration_from(c_.limit_ns); }
    /// limit() less response().
    [[nodiscard]] Nanoseconds margin() const noexcept { return Nanoseconds(c_.margin_ns); }
    [[nodiscard]] const red_certificate &c() const noexcept { return c_; }

private:
    friend class Dag;
    friend class Runtime;
    friend class Scheduler;
    red_certificate c_{};
};

// Arrays of these are arrays of the C interface's.
static_assert(sizeof(PlacedNode) == sizeof(red_placed_node) && std::is_standard_layout_v<PlacedNode>);
static_assert(sizeof(Level) == sizeof(red_level) && std::is_standard_layout_v<Level>);
static_assert(sizeof(NodeId) == sizeof(std::uint32_t) && std::is_standard_layout_v<NodeId>);

} // namespace red

#endif
