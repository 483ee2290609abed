// The paper's worked example: 20, 20 and 40 s in a chain, due after 120 s. Prints the sub-deadlines 30, 60 and 120 s.
#include <array>
#include <cstdio>
#include <red.hpp>

using namespace std::chrono_literals;

int main() {
    static red::DagMemory<red::Caps4x16x16> memory;
    auto dag = red::Dag::open(memory);
    const auto camera = dag->add_node(red::Node::ordinary(20s));
    const auto network = dag->add_node(red::Node::ordinary(20s));
    const auto control = dag->add_node(red::Node::ordinary(40s));
    const auto edges = dag->chain({camera, network, control});

    std::array<red::PlacedNode, 3> room;
    const auto nodes = dag->place(red::Rule::LevelSum, 120s, room);
    if (const auto status = red::first_error(edges, nodes); !status) {
        std::fprintf(stderr, "%s\n", status.text());
        return 1;
    }
    for (const auto &node : *nodes) {
        std::printf("%lld\n", static_cast<long long>(node.sub_deadline() / 1s));
    }
    return 0;
}
