// Workloads, read from the text that `red-abi-traces workloads` writes: one thing a line, `-` for none.
#ifndef WORKLOAD_HPP
#define WORKLOAD_HPP

#include <istream>
#include <string>
#include <vector>

#include "words.hpp"

struct Step {
    std::string word;
    std::uint32_t from = 0, to = 0;
    std::vector<red_node> nodes;
};

struct Task {
    red_timing timing = RED_TIMING_INIT;
    std::vector<Step> steps;
};

struct Pool {
    std::uint32_t lanes = 0;
    std::uint64_t memory = 0;
};

struct Fate {
    std::uint64_t percent = 0;
    std::string how;
    bool repeats = false;
};

struct Event {
    std::uint64_t at = 0;
    std::string word;
    std::uint64_t first = 0, second = 0, third = 0;
    Step step;
};

struct Workload {
    std::uint64_t seed = 0;
    std::string size, policy;
    std::uint32_t instants = 0;
    red_config config = RED_CONFIG_INIT;
    std::vector<Pool> pools;
    std::vector<std::uint64_t> sensors;
    std::vector<Task> tasks;
    std::vector<Fate> fates;
    std::vector<Event> events;
};

class Reader {
public:
    explicit Reader(std::istream &in) : in(in) {}

    // The next workload; false at the end.
    bool next(Workload &w) {
        std::string first;
        if (!(in >> first)) return false;
        if (first != "workload") give_up("a workload begins with another word: " + first);
        w = Workload();
        w.seed = number();
        w.size = word();
        w.policy = word();
        w.instants = small();
        for (std::string kind = word(); kind != "end"; kind = word()) item(kind, w);
        return true;
    }

private:
    std::istream &in;

    std::string word() {
        std::string text;
        if (!(in >> text)) give_up("the text ends within a workload");
        return text;
    }

    std::uint64_t number() { return std::stoull(word()); }
    std::uint32_t small() { return static_cast<std::uint32_t>(number()); }

    std::uint64_t number_or(std::uint64_t none) {
        std::string text = word();
        return text == "-" ? none : std::stoull(text);
    }

    void item(const std::string &kind, Workload &w) {
        if (kind == "config") {
            config(w.config);
        } else if (kind == "pool") {
            std::uint32_t lanes = small();
            w.pools.push_back({lanes, number_or(RED_NONE_64)});
        } else if (kind == "sensor") {
            w.sensors.push_back(number());
        } else if (kind == "task") {
            Task task;
            task.timing.deadline_ns = number();
            task.timing.period_ns = number();
            task.timing.value = small();
            task.timing.floor_keep = small();
            task.timing.floor_of = small();
            w.tasks.push_back(task);
        } else if (kind == "fate") {
            Fate fate;
            fate.percent = number();
            fate.how = word();
            fate.repeats = number() != 0;
            w.fates.push_back(fate);
        } else if (kind == "at") {
            w.events.push_back(event());
        } else {
            w.tasks.at(w.tasks.size() - 1).steps.push_back(step(kind));
        }
    }

    void config(red_config &c) {
        c.lanes = small();
        c.memory_bytes = number_or(RED_NONE_64);
        c.rule = number_of(RULES, word());
        c.gate = number_of(GATES, word());
        c.reassign = number_of(REASSIGNS, word());
        c.refine = small();
        c.merge_skew_ns = number_or(RED_NONE_64);
        c.frame_cache = small();
        c.shed = number_of(SHEDDINGS, word());
        c.late = number_of(LATES, word());
        c.best_case = number_of(BEST_CASES, word());
        c.overload_utilisation_ppm = small();
        c.overload_queue = small();
        c.overload_ticks = small();
        c.overload_tick_ns = number();
        c.admission = number_of(ADMISSIONS, word());
        c.preempt = small();
    }

    red_node node() {
        red_node n = RED_NODE_INIT;
        n.wcet_ns = number();
        n.bcet_ns = number();
        std::uint64_t contention = number_or(RED_NONE_64);
        n.atomic = contention != RED_NONE_64;
        n.contention_ns = n.atomic ? contention : 0;
        n.memory_bytes = number();
        n.pool = small();
        n.role = number_of(ROLES, word());
        n.weights = small();
        n.frame = small();
        n.sensor = static_cast<std::uint32_t>(number_or(RED_NONE));
        return n;
    }

    Step step(const std::string &kind) {
        Step s;
        s.word = kind;
        std::uint32_t nodes = 0;
        if (kind == "node") {
            nodes = 1;
        } else if (kind == "edge" || kind == "cut") {
            s.from = small();
            s.to = small();
        } else if (kind == "refine") {
            s.from = small();
            nodes = 1 + small();
        } else if (kind == "replace") {
            s.from = small();
            nodes = 1;
        } else if (kind == "remove") {
            s.from = small();
        } else {
            give_up("no such step: " + kind);
        }
        for (std::uint32_t i = 0; i < nodes; i++) s.nodes.push_back(node());
        return s;
    }

    Event event() {
        Event e;
        e.at = number();
        e.word = word();
        if (e.word == "take") return e;
        e.first = number();
        if (e.word == "release") {
            e.second = number();
            e.third = number_or(RED_NONE_64);
        } else if (e.word == "begin" || e.word == "stray") {
            e.second = number();
        } else if (e.word == "change") {
            e.step = step(word());
        }
        return e;
    }
};

#endif
