// An executor in virtual time: what lanes report, what happens, what is to be started, and so on to the next instant. Every
// call and its answer is a line, and behind it are the events that it made.
#ifndef HOST_HPP
#define HOST_HPP

#include <algorithm>
#include <memory>
#include <optional>

#include "graph.hpp"

enum class Mistake { none, last_lane_first, drop_release };

// No execution takes longer, whatever its WCET.
const std::uint64_t LONGEST_NS = 1000000000;
const std::size_t MOST_MEMBERS = 1024;

class Host {
public:
    Host(const Workload &w, const Class &of, Mistake mistake)
        : w(w), of(of), mistake(mistake), memory(of.scheduler_bytes), lanes{w.config.lanes},
          budgets{w.config.memory_bytes}, tasks(w.tasks.size(), {RED_NONE, 0}) {
        for (auto &edit : edits) edit = std::make_unique<Graph>(of);
    }

    std::string run() {
        text = "workload " + std::to_string(w.seed) + " " + w.size + " " + w.policy + "\n";
        red_config preset = RED_CONFIG_INIT;
        need(red_config_preset(number_of(PRESETS, w.policy), &preset), "a preset");
        text += "preset " + words_of(preset) + "\n";
        need(of.open_scheduler(memory.at, memory.bytes, &w.config, &scheduler), "a scheduler");
        set_up();
        for (std::uint32_t instant = 0; instant < w.instants; instant++) {
            std::uint64_t at = next();
            if (at == RED_NONE_64) break;
            now = at;
            for (std::size_t turn = 0; turn < running.size(); turn++)
                report(mistake == Mistake::last_lane_first ? running.size() - 1 - turn : turn);
            for (; happened < w.events.size() && w.events[happened].at <= now; tell()) happen(w.events[happened++]);
            while (poll(now)) {
            }
            figures();
        }
        line("end " + std::to_string(now), false);
        need(red_scheduler_close(&scheduler), "closing a scheduler");
        return std::move(text);
    }

private:
    struct Running {
        std::uint64_t finish, unit;
        const Fate *fate;
        std::uint32_t task, node;
    };
    struct Known {
        std::uint32_t task;
        std::uint64_t released;
    };

    const Workload &w;
    const Class &of;
    const Mistake mistake;
    Memory memory;
    red_scheduler scheduler = {0};
    std::vector<std::uint32_t> lanes;
    std::vector<std::uint64_t> budgets;
    std::vector<Known> tasks;
    std::unique_ptr<Graph> edits[2];
    std::vector<std::optional<Running>> running;
    std::size_t started = 0, happened = 0, releases = 0;
    std::uint64_t now = 0;
    std::string text;

    void line(const std::string &words, bool timed = true) {
        text += timed ? std::to_string(now) + " " + words + "\n" : words + "\n";
    }

    void set_up() {
        red_config config = RED_CONFIG_INIT;
        need(red_scheduler_config(&scheduler, &config), "a configuration");
        line("config " + words_of(config), false);
        std::uint32_t number = 0;
        for (const Pool &pool : w.pools) {
            red_status status = red_scheduler_add_pool(&scheduler, pool.lanes, pool.memory, &number);
            if (status == RED_OK) {
                lanes.push_back(pool.lanes);
                budgets.push_back(pool.memory);
            }
            line("pool " + answer(status, std::to_string(number)), false);
        }
        for (std::uint64_t period : w.sensors) {
            red_status status = red_scheduler_add_sensor(&scheduler, period, &number);
            line("sensor " + answer(status, std::to_string(number)), false);
        }
        std::size_t all = 0;
        for (std::uint32_t of_pool : lanes) all += of_pool;
        running.resize(all);
    }

    std::uint64_t next() {
        std::uint64_t at = RED_NONE_64;
        need(red_scheduler_poll_at(&scheduler, &at), "when to poll");
        if (happened < w.events.size()) at = std::min(at, w.events[happened].at);
        for (const auto &it : running)
            if (it) at = std::min(at, it->finish);
        return at;
    }

    void report(std::size_t lane) {
        if (!running[lane] || running[lane]->finish > now) return;
        const Running it = *running[lane];
        running[lane].reset();
        for (int times = 0; times < (it.fate->repeats ? 2 : 1); times++) {
            red_action action{};
            red_status status;
            if (it.fate->how == "Fail") {
                status = red_scheduler_fail(&scheduler, it.unit, now);
            } else if (it.fate->how == "CompleteAndPoll") {
                status = red_scheduler_complete_and_poll(&scheduler, it.unit, now, &action);
            } else {
                status = red_scheduler_complete(&scheduler, it.unit, now);
            }
            line("report " + std::to_string(lane) + " " + std::to_string(it.unit) + " " + it.fate->how + " " +
                 answer(status, "ok"));
            tell();
            if (status == RED_OK && action.kind != RED_ACTION_KIND_NOTHING) act(action);
        }
        took(it.task, it.node);
        if (it.fate->how == "PollOn") {
            red_action action{};
            need(red_scheduler_poll_on(&scheduler, static_cast<std::uint32_t>(lane), now, &action), "a poll");
            asked(action);
        }
    }

    void took(std::uint32_t task, std::uint32_t node) {
        red_executions of_node = RED_EXECUTIONS_INIT;
        if (red_scheduler_executions(&scheduler, task, node, &of_node) != RED_OK) return line("took unknown");
        auto ns = [](std::uint64_t time) { return " " + or_none(time, time == RED_NONE_64); };
        line("took" + ns(of_node.mean_ns) + ns(of_node.minimum_ns) + ns(of_node.maximum_ns));
    }

    bool poll(std::uint64_t at) {
        red_action action{};
        need(red_scheduler_poll(&scheduler, at, &action), "a poll");
        return asked(action);
    }

    bool asked(const red_action &action) {
        if (action.kind == RED_ACTION_KIND_NOTHING) {
            line("nothing");
        } else {
            act(action);
        }
        tell();
        return action.kind != RED_ACTION_KIND_NOTHING;
    }

    void act(const red_action &action) {
        if (action.kind == RED_ACTION_KIND_DISPATCH) {
            start(action);
        } else if (action.kind == RED_ACTION_KIND_PREEMPT) {
            running.at(action.lane).reset();
            line("preempt " + std::to_string(action.lane) + " " + std::to_string(action.unit));
        } else {
            ended(action.outcome);
        }
    }

    void start(const red_action &action) {
        const Fate &fate = w.fates[started++ % w.fates.size()];
        auto n = [](std::uint64_t number) { return " " + std::to_string(number); };
        std::string words = "start" + n(action.lane) + n(action.unit);
        red_unit unit = RED_UNIT_INIT;
        if (red_scheduler_unit(&scheduler, action.unit, &unit) != RED_OK) return line(words + " unknown");
        std::uint64_t takes = std::min(unit.wcet_ns, LONGEST_NS) * fate.percent / 100;
        running.at(action.lane) = Running{now + takes, action.unit, &fate, unit.first.task, unit.first.node};
        words += n(unit.pool) + " " + or_none(unit.output, unit.output == RED_NONE) + n(unit.started_ns) + n(unit.wcet_ns);
        std::vector<red_member> members(MOST_MEMBERS);
        std::size_t count = 0;
        need(red_scheduler_members(&scheduler, action.unit, members.data(), members.size(), &count), "members");
        members.resize(count);
        // The first of the unit is one of its members.
        members.insert(members.begin(), unit.first);
        for (const red_member &m : members)
            words += n(m.task) + "." + std::to_string(m.index) + "." + std::to_string(m.node) + ":" +
                     std::to_string(m.job) + "@" + std::to_string(m.release_ns) + "," + std::to_string(m.deadline_ns) +
                     "," + std::to_string(m.sub_deadline_ns);
        line(words);
    }

    void ended(const red_outcome &o) {
        auto n = [](std::uint64_t number) { return " " + std::to_string(number); };
        line("end" + n(o.task) + "." + std::to_string(o.index) + ":" + std::to_string(o.job) + n(o.release_ns) +
             n(o.deadline_ns) + n(o.at_ns) + " " + word_of(SHEDS, o.shed));
    }

    // The events of the last call.
    void tell() {
        red_event events[8];
        for (std::size_t count = 8; count == 8;) {
            need(red_scheduler_take_events(&scheduler, events, 8, &count), "events");
            for (std::size_t i = 0; i < count; i++) {
                const red_event &e = events[i];
                std::string kind = word_of(EVENTS, e.kind);
                if (e.kind == RED_EVENT_KIND_SHED) kind += " " + word_of(SHEDS, e.shed);
                line("  " + std::to_string(e.at_ns) + " " + kind + " " + std::to_string(e.task) + "." +
                         std::to_string(e.job) + "." + std::to_string(e.node) + " " + std::to_string(e.lane),
                     false);
            }
        }
    }

    void figures() {
        auto n = [](std::uint64_t number) { return " " + std::to_string(number); };
        std::uint64_t at = 0, used = 0;
        need(red_scheduler_poll_at(&scheduler, &at), "when to poll");
        std::string words = "until " + or_none(at, at == RED_NONE_64) + " holding";
        for (std::uint32_t pool = 0; pool < lanes.size(); pool++) {
            need(red_scheduler_memory_used(&scheduler, pool, &used), "memory");
            words += n(used);
        }
        red_figures f = RED_FIGURES_INIT;
        need(red_scheduler_figures(&scheduler, &f), "figures");
        line(words + " counting" + n(f.units) + n(f.encoder_runs_saved) + n(f.overruns) + n(f.clock_steps_back) +
             n(f.late_completions) + n(f.evictions) + n(f.events_dropped) + n(f.lanes) + n(f.jobs_in_flight) +
             n(f.ready) + n(f.running) + n(f.can_dispatch));
    }

    void happen(const Event &e);
    void admit(std::size_t task);
    void release(std::size_t task, std::uint64_t at, std::uint64_t capture);
    void begin(std::size_t place, std::size_t task);
    void commit(std::size_t place);
    void stray(std::uint64_t unit, std::uint32_t task);
    void take();
};

#endif
