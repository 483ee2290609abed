// The enumerations, with the numbers that red.h gives them and its words for what they mean.
#ifndef RED_WORDS_HPP
#define RED_WORDS_HPP

#include "../red.h"

#include <cstdint>

namespace red {

/// How a node's sub-deadline follows from the end-to-end deadline.
enum class Rule : std::uint32_t {
    EndToEnd = RED_RULE_END_TO_END,
    LevelSum = RED_RULE_LEVEL_SUM,
    LevelGraham = RED_RULE_LEVEL_GRAHAM,
    PathProportional = RED_RULE_PATH_PROPORTIONAL,
    LatestFinish = RED_RULE_LATEST_FINISH,
    LatestStart = RED_RULE_LATEST_START,
};

/// What must be done before a node may start.
enum class Gate : std::uint32_t {
    Precedence = RED_GATE_PRECEDENCE,
    Level = RED_GATE_LEVEL,
    Lookahead = RED_GATE_LOOKAHEAD,
};

/// When sub-deadlines of jobs in flight are computed again.
enum class Reassign : std::uint32_t {
    Never = RED_REASSIGN_NEVER,
    OnDispatch = RED_REASSIGN_ON_DISPATCH,
    OnChange = RED_REASSIGN_ON_CHANGE,
};

/// Which jobs are given up.
enum class Shedding : std::uint32_t {
    Never = RED_SHEDDING_NEVER,
    LowestUrgency = RED_SHEDDING_LOWEST_URGENCY,
    Hopeless = RED_SHEDDING_HOPELESS,
};

/// What happens to a job that is past its deadline.
enum class Late : std::uint32_t {
    Continue = RED_LATE_CONTINUE,
    AbortJob = RED_LATE_ABORT_JOB,
};

/// Where best-case execution times come from.
enum class BestCase : std::uint32_t {
    Observed = RED_BEST_CASE_OBSERVED,
    Declared = RED_BEST_CASE_DECLARED,
};

/// What happens to a task, or an edit, whose certificate does not fit.
enum class Admission : std::uint32_t {
    Report = RED_ADMISSION_REPORT,
    Enforce = RED_ADMISSION_ENFORCE,
};

/// What a node is in a MIMONet.
enum class Role : std::uint32_t {
    Ordinary = RED_ROLE_ORDINARY,
    SharedEncoder = RED_ROLE_SHARED_ENCODER,
    Decoder = RED_ROLE_DECODER,
};

/// Which bound a certificate rests on.
enum class Bound : std::uint32_t {
    Graham = RED_BOUND_GRAHAM,
    LongPath = RED_BOUND_LONG_PATH,
    SeveralPools = RED_BOUND_SEVERAL_POOLS,
};

/// Why a job was given up.
enum class Shed : std::uint32_t {
    Not = RED_SHED_NOT,
    Hopeless = RED_SHED_HOPELESS,
    Overload = RED_SHED_OVERLOAD,
    Urgency = RED_SHED_URGENCY,
    Full = RED_SHED_FULL,
    Late = RED_SHED_LATE,
    Fault = RED_SHED_FAULT,
    Removed = RED_SHED_REMOVED,
};

/// What the host has to do.
enum class ActionKind : std::uint32_t {
    Nothing = RED_ACTION_KIND_NOTHING,
    Dispatch = RED_ACTION_KIND_DISPATCH,
    Preempt = RED_ACTION_KIND_PREEMPT,
    Ended = RED_ACTION_KIND_ENDED,
    Ahead = RED_ACTION_KIND_AHEAD,
};

/// What happened.
enum class EventKind : std::uint32_t {
    Other = RED_EVENT_KIND_OTHER,
    Released = RED_EVENT_KIND_RELEASED,
    Refused = RED_EVENT_KIND_REFUSED,
    Started = RED_EVENT_KIND_STARTED,
    Completed = RED_EVENT_KIND_COMPLETED,
    Hit = RED_EVENT_KIND_HIT,
    Preempted = RED_EVENT_KIND_PREEMPTED,
    Overran = RED_EVENT_KIND_OVERRAN,
    Ended = RED_EVENT_KIND_ENDED,
    Shed = RED_EVENT_KIND_SHED,
    Edited = RED_EVENT_KIND_EDITED,
    Evicted = RED_EVENT_KIND_EVICTED,
    Warned = RED_EVENT_KIND_WARNED,
};

/// How the lanes of a runtime run.
enum class Mode : std::uint32_t {
    RealTime = RED_MODE_REAL_TIME,
    BestEffort = RED_MODE_BEST_EFFORT,
};

/// Where a runtime is.
enum class RuntimeState : std::uint32_t {
    SetUp = RED_RUNTIME_STATE_SET_UP,
    Running = RED_RUNTIME_STATE_RUNNING,
    Ended = RED_RUNTIME_STATE_ENDED,
    Failed = RED_RUNTIME_STATE_FAILED,
};

/// Why a run ended itself.
enum class Surrender : std::uint32_t {
    No = RED_SURRENDER_NO,
    NoLane = RED_SURRENDER_NO_LANE,
    CpuGone = RED_SURRENDER_CPU_GONE,
    Other = RED_SURRENDER_OTHER,
};

} // namespace red

#endif
