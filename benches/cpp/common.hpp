// What the helper programs share. Standard input: lanes, steps of a body, edges, nodes; the edges; the number of
// CPUs and the CPUs; then requests "runs samples". Each is answered by one line of nanoseconds per sample.
#pragma once
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <utility>
#include <vector>
#include <sched.h>
#include <unistd.h>

struct Setup {
  unsigned lanes = 1;
  std::uint64_t steps = 0;
  unsigned nodes = 0;
  std::vector<std::pair<unsigned, unsigned>> edges;

  // The same chain of dependent multiplications as the bodies in Rust.
  void body(std::uint64_t node) const {
    asm volatile("" ::"r"(node) : "memory");
    if (steps == 0) return;
    std::uint64_t value = node | 1;
    for (std::uint64_t step = 0; step < steps; step++) value = (value ^ (value >> 29)) * 0x9E3779B97F4A7C15ull;
    asm volatile("" ::"r"(value) : "memory");
  }
};

inline unsigned number() {
  unsigned value = 0;
  if (std::scanf("%u", &value) != 1) std::exit(2);
  return value;
}

// Reads the setup and moves to its CPUs before the library starts threads, which inherit them.
inline Setup read_setup() {
  Setup setup;
  setup.lanes = number();
  if (std::scanf("%lu", &setup.steps) != 1) std::exit(2);
  unsigned edges = number();
  setup.nodes = number();
  for (unsigned edge = 0; edge < edges; edge++) {
    unsigned from = number(), to = number();
    if (from >= setup.nodes || to >= setup.nodes) std::exit(2);
    setup.edges.push_back({from, to});
  }
  cpu_set_t cpus;
  CPU_ZERO(&cpus);
  for (unsigned left = number(); left > 0; left--) CPU_SET(number(), &cpus);
  if (sched_setaffinity(0, sizeof cpus, &cpus) != 0) std::exit(3);
  return setup;
}

// Answers requests until the input ends. run(k) executes the graph k times.
template <class Run> void serve(Run run) {
  unsigned runs = 0, samples = 0;
  while (std::scanf("%u %u", &runs, &samples) == 2) {
    alarm(60);  // a peer that hangs ends with its helper
    for (unsigned sample = 0; sample < samples; sample++) {
      auto start = std::chrono::steady_clock::now();
      run(runs);
      auto took = std::chrono::steady_clock::now() - start;
      std::printf("%llu ", static_cast<unsigned long long>(std::chrono::nanoseconds(took).count()));
    }
    std::printf("\n");
    std::fflush(stdout);
    alarm(0);
  }
}
