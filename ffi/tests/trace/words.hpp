// Words of workloads and traces, and the numbers that the header has for them.
#ifndef WORDS_HPP
#define WORDS_HPP

#include <cstdint>
#include <cstdlib>
#include <iostream>
#include <string>

#include "red.h"

struct Word {
    const char *text;
    std::int64_t number;
};

[[noreturn]] inline void give_up(const std::string &why) {
    std::cerr << why << "\n";
    std::exit(2);
}

template <std::size_t N>
std::uint32_t number_of(const Word (&words)[N], const std::string &text) {
    for (const Word &word : words)
        if (text == word.text) return static_cast<std::uint32_t>(word.number);
    give_up("no such word: " + text);
}

template <std::size_t N>
std::string word_of(const Word (&words)[N], std::int64_t number) {
    for (const Word &word : words)
        if (number == word.number) return word.text;
    return "?" + std::to_string(number);
}

const Word PRESETS[] = {
    {"edf", RED_PRESET_EDF}, {"red-fg", RED_PRESET_RED_FG}, {"red-ida", RED_PRESET_RED_IDA},
    {"red", RED_PRESET_RED}, {"redrt", RED_PRESET_REDRT},
};
const Word RULES[] = {
    {"EndToEnd", RED_RULE_END_TO_END},         {"LevelSum", RED_RULE_LEVEL_SUM},
    {"LevelGraham", RED_RULE_LEVEL_GRAHAM},    {"PathProportional", RED_RULE_PATH_PROPORTIONAL},
    {"LatestFinish", RED_RULE_LATEST_FINISH},  {"LatestStart", RED_RULE_LATEST_START},
};
const Word GATES[] = {{"Precedence", RED_GATE_PRECEDENCE}, {"Level", RED_GATE_LEVEL}};
const Word REASSIGNS[] = {
    {"Never", RED_REASSIGN_NEVER}, {"OnDispatch", RED_REASSIGN_ON_DISPATCH}, {"OnChange", RED_REASSIGN_ON_CHANGE},
};
const Word SHEDDINGS[] = {
    {"Never", RED_SHEDDING_NEVER},
    {"LowestUrgency", RED_SHEDDING_LOWEST_URGENCY},
    {"Hopeless", RED_SHEDDING_HOPELESS},
};
const Word LATES[] = {{"Continue", RED_LATE_CONTINUE}, {"AbortJob", RED_LATE_ABORT_JOB}};
const Word BEST_CASES[] = {{"Observed", RED_BEST_CASE_OBSERVED}, {"Declared", RED_BEST_CASE_DECLARED}};
const Word ADMISSIONS[] = {{"Report", RED_ADMISSION_REPORT}, {"Enforce", RED_ADMISSION_ENFORCE}};
const Word ROLES[] = {
    {"Ordinary", RED_ROLE_ORDINARY}, {"SharedEncoder", RED_ROLE_SHARED_ENCODER}, {"Decoder", RED_ROLE_DECODER},
};
const Word BOUNDS[] = {
    {"Graham", RED_BOUND_GRAHAM}, {"LongPath", RED_BOUND_LONG_PATH}, {"SeveralPools", RED_BOUND_SEVERAL_POOLS},
};
const Word SHEDS[] = {
    {"done", RED_SHED_NOT},   {"hopeless", RED_SHED_HOPELESS}, {"overload", RED_SHED_OVERLOAD},
    {"urgency", RED_SHED_URGENCY}, {"full", RED_SHED_FULL},    {"late", RED_SHED_LATE},
    {"fault", RED_SHED_FAULT},     {"removed", RED_SHED_REMOVED},
};
const Word EVENTS[] = {
    {"Released", RED_EVENT_KIND_RELEASED}, {"Refused", RED_EVENT_KIND_REFUSED},
    {"Started", RED_EVENT_KIND_STARTED},   {"Completed", RED_EVENT_KIND_COMPLETED},
    {"Hit", RED_EVENT_KIND_HIT},           {"Preempted", RED_EVENT_KIND_PREEMPTED},
    {"Overran", RED_EVENT_KIND_OVERRAN},   {"Ended", RED_EVENT_KIND_ENDED},
    {"Shed", RED_EVENT_KIND_SHED},         {"Edited", RED_EVENT_KIND_EDITED},
    {"Evicted", RED_EVENT_KIND_EVICTED},   {"Warned", RED_EVENT_KIND_WARNED},
};
// Refusals, by the core's own names.
const Word REFUSALS[] = {
    {"Full", RED_STATUS_NODES_FULL},
    {"WorkOverflow", RED_STATUS_WORK_OVERFLOW},
    {"Cycle", RED_STATUS_CYCLE},
    {"Duplicate", RED_STATUS_DUPLICATE_EDGE},
    {"SecondEncoder", RED_STATUS_SECOND_ENCODER},
    {"UnknownNode", RED_STATUS_UNKNOWN_NODE},
    {"NoDecoder", RED_STATUS_NO_DECODER},
    {"Full", RED_STATUS_TASKS_FULL},
    {"Empty", RED_STATUS_EMPTY_GRAPH},
    {"Deadline", RED_STATUS_DEADLINE},
    {"UnknownPool", RED_STATUS_UNKNOWN_POOL},
    {"Memory", RED_STATUS_MEMORY},
    {"Unschedulable", RED_STATUS_UNSCHEDULABLE},
    {"UnknownTask", RED_STATUS_UNKNOWN_TASK},
    {"Conflict", RED_STATUS_CONFLICT},
    {"Busy", RED_STATUS_DRAINING},
    {"NoLane", RED_STATUS_NO_LANE},
    {"Full", RED_STATUS_POOLS_FULL},
    {"ZeroPeriod", RED_STATUS_ZERO_PERIOD},
    {"Full", RED_STATUS_SENSORS_FULL},
    {"UnknownSensor", RED_STATUS_UNKNOWN_SENSOR},
    {"Full", RED_STATUS_JOBS_FULL},
    {"Overflow", RED_STATUS_TIME_OVERFLOW},
    {"Stale", RED_STATUS_STALE},
    {"NotRunning", RED_STATUS_NOT_RUNNING},
    {"Late", RED_STATUS_LATE},
    {"Job", RED_STATUS_UNKNOWN_JOB},
};

inline std::string or_none(std::uint64_t number, bool is_none) { return is_none ? "-" : std::to_string(number); }

// What a call answered, or why it was refused.
inline std::string answer(red_status status, const std::string &value) {
    return status == RED_OK ? "= " + value : "! " + word_of(REFUSALS, status);
}

// Of a call that answers with a word.
inline std::string yes_or_no(red_status status, red_status no) {
    if (status == RED_OK) return "= yes";
    return status == no ? "= no" : "! " + word_of(REFUSALS, status);
}

inline std::string words_of(const red_config &c) {
    auto n = [](std::uint64_t number) { return " " + std::to_string(number); };
    auto word = [](const auto &words, std::uint32_t number) { return " " + word_of(words, number); };
    return std::to_string(c.lanes) + " " + or_none(c.memory_bytes, c.memory_bytes == RED_NONE_64) +
           word(RULES, c.rule) + word(GATES, c.gate) + word(REASSIGNS, c.reassign) + n(c.refine) + " " +
           or_none(c.merge_skew_ns, c.merge_skew_ns == RED_NONE_64) + n(c.frame_cache) + word(SHEDDINGS, c.shed) +
           word(LATES, c.late) + word(BEST_CASES, c.best_case) + n(c.overload_utilisation_ppm) +
           n(c.overload_queue) + n(c.overload_ticks) + n(c.overload_tick_ns) + word(ADMISSIONS, c.admission) +
           n(c.preempt);
}

inline std::string words_of(const red_certificate &c) {
    auto n = [](auto number) { return " " + std::to_string(number); };
    return word_of(BOUNDS, c.bound) + n(c.paths) + n(c.lanes) + n(c.fits) + n(c.memory_holds) + n(c.work_ns) +
           n(c.critical_path_ns) + n(c.response_ns) + n(c.limit_ns) + n(c.margin_ns);
}

inline std::string words_of(const red_node &node) {
    auto n = [](std::uint64_t number) { return std::to_string(number) + " "; };
    return n(node.wcet_ns) + n(node.bcet_ns) + or_none(node.contention_ns, node.atomic == 0) + " " +
           n(node.memory_bytes) + n(node.pool) + word_of(ROLES, node.role) + " " + n(node.weights) + n(node.frame) +
           or_none(node.sensor, node.sensor == RED_NONE);
}

#endif
