// oneTBB flow graph, one continue_node per node. Lightweight bodies run inside try_put of the predecessor.
#include "common.hpp"
#include <memory>
#include <oneapi/tbb/flow_graph.h>
#include <oneapi/tbb/global_control.h>
#include <oneapi/tbb/task_arena.h>
namespace flow = oneapi::tbb::flow;
using Node = flow::continue_node<flow::continue_msg, flow::lightweight>;

int main() {
  const Setup setup = read_setup();
  oneapi::tbb::global_control limit(oneapi::tbb::global_control::max_allowed_parallelism, setup.lanes);
  oneapi::tbb::task_arena arena(static_cast<int>(setup.lanes));
  arena.execute([&] {
    flow::graph graph;
    std::vector<std::unique_ptr<Node>> nodes;
    for (unsigned node = 0; node < setup.nodes; node++)
      nodes.push_back(std::make_unique<Node>(graph, [&setup, node](const flow::continue_msg &) {
        setup.body(node);
        return flow::continue_msg();
      }));
    std::vector<unsigned> indegree(setup.nodes);
    for (auto [from, to] : setup.edges) {
      flow::make_edge(*nodes[from], *nodes[to]);
      indegree[to]++;
    }
    std::vector<Node *> roots;
    for (unsigned node = 0; node < setup.nodes; node++)
      if (indegree[node] == 0) roots.push_back(nodes[node].get());
    serve([&](unsigned runs) {
      for (; runs > 0; runs--) {
        for (Node *root : roots) root->try_put(flow::continue_msg());
        graph.wait_for_all();
      }
    });
  });
}
