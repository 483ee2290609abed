// Dag: a graph, and what it says.
#ifndef RED_DAG_HPP
#define RED_DAG_HPP

#include "handle.hpp"
#include "memory.hpp"
#include "node.hpp"
#include "proof.hpp"

#include <initializer_list>

namespace red {

/// A graph of nodes without cycles. Nodes are given as the answers that named them: the first error goes on, so that it is
/// enough to look at the last one.
///
/// One thread at a time changes a graph; meanwhile nobody looks.
class Dag : public Handle<red_dag, red_dag_close> {
public:
    /// One that is not open.
    Dag() noexcept = default;
    explicit Dag(Status why) noexcept : Handle(why) {}

    /// Opens a graph without nodes. The memory has to outlive it. Where something is open in it this is
    /// RED_STATUS_OVERLAP, also if the answer is to take that one's place: close it before.
    template <class Caps>
    [[nodiscard]] static Result<Dag> open(DagMemory<Caps> &memory) noexcept {
        return open<Caps>(memory.bytes());
    }
    /// The same in memory of one's own, of Caps::dag_bytes and aligned to RED_ALIGN.
    template <class Caps>
    [[nodiscard]] static Result<Dag> open(Span<std::byte> memory) noexcept {
        Dag dag;
        const Status opened = Caps::open(memory.data(), memory.size(), dag.c_);
        return opened ? Result<Dag>(std::move(dag)) : opened;
    }

    /// Nodes are numbered from 0.
    Result<NodeId> add_node(const Node &node) noexcept {
        std::uint32_t number = RED_NONE;
        const Status added = node.status() ? said(red_dag_add_node(&c_, &node.c(), &number)) : node.status();
        return added ? Result<NodeId>(NodeId(number)) : added;
    }
    /// `to` starts after `from` has completed.
    Status add_edge(Result<NodeId> from, Result<NodeId> to) noexcept {
        const Status given = first_error(*this, from, to);
        return given ? said(red_dag_add_edge(&c_, from->value(), to->value())) : given;
    }
    /// Edges from each node to the next. Those before the first error stay.
    Status chain(std::initializer_list<Result<NodeId>> nodes) noexcept {
        Status all = status();
        const Result<NodeId> *before = nullptr;
        for (const Result<NodeId> &node : nodes) {
            all = first_error(all, node);
            if (all && before != nullptr) {
                all = add_edge(*before, node);
            }
            before = &node;
        }
        return all;
    }
    /// Removes a node and its edges. Other nodes keep their numbers.
    Status remove_node(Result<NodeId> node) noexcept {
        const Status given = first_error(*this, node);
        return given ? said(red_dag_remove_node(&c_, node->value())) : given;
    }
    Status remove_edge(Result<NodeId> from, Result<NodeId> to) noexcept {
        const Status given = first_error(*this, from, to);
        return given ? said(red_dag_remove_edge(&c_, from->value(), to->value())) : given;
    }

    /// What became of a node that was refined.
    struct Stage {
        NodeId encoder;
        /// The `i`-th decoder.
        [[nodiscard]] NodeId decoder(std::uint32_t i) const noexcept { return NodeId(encoder.value() + 1 + i); }
    };
    /// Replaces a node by a shared encoder and its decoders (paper Def. 6, Alg. 1). Edges into it lead to the encoder, edges
    /// out of it leave every decoder. Nodes after it get larger numbers.
    Result<Stage> refine(Result<NodeId> stage, const Node &encoder, Span<const Node> decoders) noexcept {
        Status given = first_error(*this, stage, encoder);
        for (const Node &decoder : decoders) {
            given = first_error(given, decoder);
        }
        std::uint32_t number = RED_NONE;
        const red_node *first = decoders.empty() ? nullptr : &decoders.data()->c_;
        const Status refined =
            given ? said(red_dag_refine(&c_, stage->value(), &encoder.c(), first, decoders.size(), &number)) : given;
        return refined ? Result<Stage>(Stage{NodeId(number)}) : refined;
    }

    [[nodiscard]] Result<Summary> summarize() const noexcept {
        Summary summary;
        const Status looked = said(red_dag_summarize(&c_, &summary.c_));
        return looked ? Result<Summary>(summary) : looked;
    }
    /// The data of a node.
    [[nodiscard]] Result<Node> node(Result<NodeId> node) const noexcept {
        Node data;
        const Status given = first_error(*this, node);
        const Status looked = given ? said(red_dag_node(&c_, node->value(), &data.c_)) : given;
        return looked ? Result<Node>(data) : looked;
    }
    /// The direct successors of a node, smallest first, in `room`; Caps::nodes are enough.
    [[nodiscard]] Result<Span<const NodeId>> successors(Result<NodeId> node, Span<NodeId> room) const noexcept {
        std::size_t count = 0;
        const Status given = first_error(*this, node);
        auto *numbers = reinterpret_cast<std::uint32_t *>(room.data());
        const Status looked =
            given ? said(red_dag_successors(&c_, node->value(), numbers, room.size(), &count)) : given;
        return filled<NodeId>(looked, room, count);
    }
    /// All nodes, smallest first, with what a rule makes of a deadline, in `room`; Caps::nodes are enough. `lanes` are those
    /// of the first pools; others have one.
    [[nodiscard]] Result<Span<const PlacedNode>> place(
        Rule rule, Duration deadline, Span<PlacedNode> room, Span<const std::uint32_t> lanes = {}) const noexcept {
        std::size_t count = 0;
        const Status given = first_error(*this, deadline);
        auto *nodes = reinterpret_cast<red_placed_node *>(room.data());
        const Status looked = given ? said(red_dag_place(&c_, static_cast<std::uint32_t>(rule), deadline.ns(),
                                          lanes.data(), lanes.size(), nodes, room.size(), &count))
                                    : given;
        return filled<PlacedNode>(looked, room, count);
    }
    /// How Rule::LevelSum or Rule::LevelGraham divides a deadline among the levels, in `room`; Caps::nodes are enough.
    [[nodiscard]] Result<Span<const Level>> share(
        Rule rule, Duration deadline, Span<Level> room, Span<const std::uint32_t> lanes = {}) const noexcept {
        std::size_t count = 0;
        const Status given = first_error(*this, deadline);
        auto *levels = reinterpret_cast<red_level *>(room.data());
        const Status looked = given ? said(red_dag_share(&c_, static_cast<std::uint32_t>(rule), deadline.ns(),
                                          lanes.data(), lanes.size(), levels, room.size(), &count))
                                    : given;
        return filled<Level>(looked, room, count);
    }
    /// Bounds the response time of a job of this graph that has its pools to itself. `lanes` are those of the first pools,
    /// `memory` their budgets in bytes, RED_NONE_64 where there is none; both as long, or `memory` empty.
    [[nodiscard]] Result<Certificate> prove(
        Duration limit, Span<const std::uint32_t> lanes = {}, Span<const std::uint64_t> memory = {}) const noexcept {
        std::uint64_t budgets[Caps16x256x64::pools];
        for (std::uint64_t &budget : budgets) {
            budget = RED_NONE_64;
        }
        const bool differ = !memory.empty() && memory.size() != lanes.size();
        const Status given = first_error(*this, limit, Status(differ ? RED_STATUS_TOO_SHORT : RED_STATUS_OK));
        Certificate proof;
        const std::uint64_t *bytes = memory.empty() ? budgets : memory.data();
        const Status looked =
            given ? said(red_dag_prove(&c_, limit.ns(), lanes.data(), bytes, lanes.size(), &proof.c_)) : given;
        return looked ? Result<Certificate>(proof) : looked;
    }

private:
    friend class Runtime;
    friend class Scheduler;
    template <class T>
    static Result<Span<const T>> filled(Status status, Span<T> room, std::size_t count) noexcept {
        return status ? Result<Span<const T>>(Span<const T>(room.data(), count)) : status;
    }
};

} // namespace red

#endif
