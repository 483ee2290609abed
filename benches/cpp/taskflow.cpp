// Taskflow: one task per node; all runs of a sample are handed over at once.
#include "common.hpp"
#include <taskflow/taskflow.hpp>

int main() {
  const Setup setup = read_setup();
  tf::Executor executor(setup.lanes);
  tf::Taskflow graph;
  std::vector<tf::Task> tasks;
  for (unsigned node = 0; node < setup.nodes; node++)
    tasks.push_back(graph.emplace([&setup, node] { setup.body(node); }));
  for (auto [from, to] : setup.edges) tasks[from].precede(tasks[to]);
  serve([&](unsigned runs) { executor.run_n(graph, runs).wait(); });
}
