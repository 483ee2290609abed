// Graphs: made step by step, and asked what they say.
#ifndef GRAPH_HPP
#define GRAPH_HPP

#include <cstdlib>
#include <memory>
#include <utility>
#include <vector>

#include "workload.hpp"

// Memory as the library wants it.
class Memory {
public:
    explicit Memory(std::size_t bytes) : bytes(bytes), at(std::aligned_alloc(RED_ALIGN, bytes)) {
        if (at == nullptr) give_up("no memory");
    }
    ~Memory() { std::free(at); }
    Memory(const Memory &) = delete;
    Memory &operator=(const Memory &) = delete;

    const std::size_t bytes;
    void *const at;
};

// What depends on the capacity class.
struct Class {
    const char *size;
    std::size_t scheduler_bytes, dag_bytes;
    red_status (*open_scheduler)(void *, size_t, const red_config *, red_scheduler *);
    red_status (*open_dag)(void *, size_t, red_dag *);
};

const Class CLASSES[] = {
    {"4x16x16", RED_SCHEDULER_4X16X16_BYTES, RED_DAG_4X16X16_BYTES, red_scheduler_open_4x16x16, red_dag_open_4x16x16},
    {"8x64x32", RED_SCHEDULER_8X64X32_BYTES, RED_DAG_8X64X32_BYTES, red_scheduler_open_8x64x32, red_dag_open_8x64x32},
    {"16x256x64", RED_SCHEDULER_16X256X64_BYTES, RED_DAG_16X256X64_BYTES, red_scheduler_open_16x256x64,
     red_dag_open_16x256x64},
};

// Of what must not be refused.
inline void need(red_status status, const char *what) {
    if (status != RED_OK) give_up(std::string(what) + ": " + red_status_text(status));
}

const std::size_t MOST_NODES = 256;

// A graph and its memory; closed when it goes.
class Graph {
public:
    explicit Graph(const Class &of) : of(of), memory(std::make_unique<Memory>(of.dag_bytes)) {}
    ~Graph() { close(); }
    Graph(const Graph &) = delete;
    Graph &operator=(const Graph &) = delete;

    const Class &of;
    std::unique_ptr<Memory> memory;
    red_dag dag = {0};

    void open() { need(of.open_dag(memory->at, memory->bytes, &dag), "a graph"); }
    void close() {
        if (is_open()) need(red_dag_close(&dag), "closing a graph");
    }
    bool is_open() const { return dag.bits != 0; }

    // One step, and what was answered.
    std::string take(const Step &step) {
        std::uint32_t number = 0;
        if (step.word == "node") {
            red_status status = red_dag_add_node(&dag, &step.nodes[0], &number);
            return answer(status, std::to_string(number));
        }
        if (step.word == "edge") return answer(red_dag_add_edge(&dag, step.from, step.to), "ok");
        if (step.word == "remove") return yes_or_no(red_dag_remove_node(&dag, step.from), RED_STATUS_UNKNOWN_NODE);
        if (step.word == "cut") return yes_or_no(red_dag_remove_edge(&dag, step.from, step.to), RED_STATUS_UNKNOWN_EDGE);
        if (step.word == "replace") return replace(step.from, step.nodes[0]);
        const red_node *decoders = step.nodes.size() > 1 ? &step.nodes[1] : nullptr;
        red_status status =
            red_dag_refine(&dag, step.from, &step.nodes[0], decoders, step.nodes.size() - 1, &number);
        return answer(status, std::to_string(number));
    }

    std::vector<std::uint32_t> successors(std::uint32_t node) const {
        std::vector<std::uint32_t> found(MOST_NODES);
        std::size_t count = 0;
        need(red_dag_successors(&dag, node, found.data(), found.size(), &count), "successors");
        found.resize(count);
        return found;
    }

    // What it says, line by line.
    std::string ask(std::uint32_t rule, std::uint64_t deadline, const std::vector<std::uint32_t> &lanes,
                    const std::vector<std::uint64_t> &budgets) const {
        auto n = [](auto number) { return " " + std::to_string(number); };
        red_dag_summary said = RED_DAG_SUMMARY_INIT;
        need(red_dag_summarize(&dag, &said), "a summary");
        std::string text = "graph" + n(said.nodes) + n(said.levels) + n(said.work_ns) + n(said.critical_path_ns) + "\n";
        std::vector<red_placed_node> placed(MOST_NODES);
        std::size_t count = 0;
        need(red_dag_place(&dag, rule, deadline, lanes.data(), lanes.size(), placed.data(), placed.size(), &count), "places");
        for (std::size_t i = 0; i < count; i++) {
            const red_placed_node &p = placed[i];
            red_node node = RED_NODE_INIT;
            need(red_dag_node(&dag, p.node, &node), "a node");
            text += "has" + n(p.node) + " " + words_of(node) + " before";
            for (std::uint32_t to : successors(p.node)) text += n(to);
            text += " at" + n(p.height) + n(p.tail_ns) + n(p.sub_deadline_ns) + n(p.key_ns) + "\n";
        }
        for (std::uint32_t by : {RED_RULE_LEVEL_SUM, RED_RULE_LEVEL_GRAHAM}) {
            std::vector<red_level> levels(MOST_NODES);
            need(red_dag_share(&dag, by, deadline, lanes.data(), lanes.size(), levels.data(), levels.size(), &count),
                 "shares");
            for (std::size_t i = 0; i < count; i++) {
                const red_level &l = levels[i];
                text += "level" + n(l.cost_ns) + n(l.graham_ns) + n(l.share_ns) + n(l.end_ns) + "\n";
            }
        }
        red_certificate proof = RED_CERTIFICATE_INIT;
        need(red_dag_prove(&dag, deadline, lanes.data(), budgets.data(), lanes.size(), &proof), "a proof");
        return text + "alone " + words_of(proof) + "\n";
    }

private:
    // The graph again, with another node in one place.
    std::string replace(std::uint32_t place, const red_node &by) {
        Graph now(of);
        now.open();
        std::string told;
        std::vector<std::uint32_t> nodes;
        std::uint32_t number = 0;
        for (std::uint32_t id = 0; id < MOST_NODES; id++) {
            red_node node = RED_NODE_INIT;
            if (red_dag_node(&dag, id, &node) != RED_OK) continue;
            nodes.push_back(id);
            red_status status = red_dag_add_node(&now.dag, id == place ? &by : &node, &number);
            told += answer(status, std::to_string(number)) + " ";
        }
        for (std::uint32_t from : nodes)
            for (std::uint32_t to : successors(from)) told += answer(red_dag_add_edge(&now.dag, from, to), "ok") + " ";
        std::swap(memory, now.memory);
        std::swap(dag, now.dag);
        if (!told.empty()) told.pop_back();
        return told;
    }
};

#endif
