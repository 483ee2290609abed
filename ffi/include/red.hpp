// RED for C++17 and later: real-time scheduling of DAGs of neural networks. Header-only, over the C interface in red.h.
//
// Nothing here throws, allocates, or ends the program. Every call answers with a Status or a Result, which the compiler does
// not let you drop. Names and answers are taken as they came, so that an error goes on to the next call and it is enough to
// look at the last one:
//
//     static red::DagMemory<red::Caps4x16x16> dag_memory;
//     static red::SchedulerMemory<red::Caps4x16x16> memory;
//
//     auto dag = red::Dag::open(dag_memory);
//     const auto camera = dag->add_node(red::Node::ordinary(2ms));
//     const auto network = dag->add_node(red::Node::ordinary(8ms));
//     const auto edges = dag->chain({camera, network});
//     auto scheduler = red::Scheduler::open(memory, red::Config::redrt().lanes(2));
//     const auto task = scheduler->add_task(*dag, red::Timing::sporadic(50ms).every(50ms));
//     if (const auto status = red::first_error(edges, task); !status) return give_up(status.text());
//
// A Runtime is a scheduler with lanes, threads that call your functions; it needs Linux and red::runtime. Memory is yours and
// outlives what is opened in it. Handles (Dag, Scheduler, Runtime) are moved, not copied, and closed by their
// destructors. Times are std::chrono. What threads may do, and what is real time, is said in red.h for each call.
#ifndef RED_HPP
#define RED_HPP

#include "red/runtime.hpp"
#include "red/scheduler.hpp"

#endif
