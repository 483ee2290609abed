// What every method does with the answers of the library.
#include "tests.hpp"

namespace {

red::SchedulerMemory<Small> memory;
red::DagMemory<Small> dag_memory, edit_memory;

void configs() {
    using red::Config;
    CHECK(Config::edf().c().rule == RED_RULE_END_TO_END && Config::red_fg().c().gate == RED_GATE_LEVEL);
    CHECK(Config::red_ida().c().reassign == RED_REASSIGN_ON_DISPATCH && Config::red().c().shed == RED_SHEDDING_LOWEST_URGENCY);
    CHECK(Config::redrt().c().rule == RED_RULE_LATEST_START && Config().c().frame_cache == 1 && Config().status().ok());
    const red_config c = Config()
                             .lanes(2)
                             .memory(1000)
                             .rule(red::Rule::LevelGraham)
                             .gate(red::Gate::Level)
                             .reassign(red::Reassign::OnChange)
                             .refine(false)
                             .merge(3ms)
                             .frame_cache(false)
                             .shedding(red::Shedding::Never)
                             .late(red::Late::AbortJob)
                             .best_case(red::BestCase::Declared)
                             .admission(red::Admission::Enforce)
                             .preempt(true)
                             .overload_utilisation(900'000)
                             .overload_queue(5)
                             .overload_ticks(4)
                             .overload_tick(7ms)
                             .c();
    CHECK(c.lanes == 2 && c.memory_bytes == 1000 && c.rule == RED_RULE_LEVEL_GRAHAM && c.gate == RED_GATE_LEVEL);
    CHECK(c.reassign == RED_REASSIGN_ON_CHANGE && c.refine == 0 && c.merge_skew_ns == 3'000'000 && c.frame_cache == 0);
    CHECK(c.shed == RED_SHEDDING_NEVER && c.late == RED_LATE_ABORT_JOB && c.best_case == RED_BEST_CASE_DECLARED);
    CHECK(c.admission == RED_ADMISSION_ENFORCE && c.preempt == 1 && c.overload_utilisation_ppm == 900'000);
    CHECK(c.overload_queue == 5 && c.overload_ticks == 4 && c.overload_tick_ns == 7'000'000);
    CHECK(Config().no_merge().c().merge_skew_ns == RED_NONE_64);
    const auto scheduler = red::Scheduler::open(memory, Config().lanes(3));
    CHECK(scheduler->config()->c().lanes == 3);
}

void graphs() {
    auto dag = red::Dag::open(dag_memory);
    const auto node = red::Node::ordinary(9ms).best_case(2ms).atomic(1ms).memory(64).pool(red::PoolId(1));
    const auto stage = dag->add_node(node);
    const auto camera = dag->add_node(red::Node::ordinary(2ms)), control = dag->add_node(red::Node::ordinary(3ms).atomic());
    CHECK(dag->chain({camera, stage, control}).ok() && ended(dag->add_edge(control, camera), RED_STATUS_CYCLE));
    const auto data = dag->node(stage);
    CHECK(data->wcet() == 9ms && data->best_case() == 2ms && data->is_atomic() && data->contention() == 1ms);
    CHECK(data->memory() == 64 && data->pool() == red::PoolId(1) && data->role() == red::Role::Ordinary);
    CHECK(data->c().atomic == 1 && dag->node(control)->contention() == 0ns);

    const std::array decoders = {red::Node::decoder(1ms), red::Node::decoder(2ms)};
    const auto refined = dag->refine(stage, red::Node::shared_encoder(4ms, {1, 2, red::SensorId(0)}), decoders);
    CHECK(refined && dag->node(refined->decoder(1))->wcet() == 2ms);
    const auto frame = dag->node(refined->encoder)->frame();
    CHECK(frame.weights == 1 && frame.frame == 2 && *frame.sensor == red::SensorId(0));
    CHECK(dag->node(refined->encoder)->role() == red::Role::SharedEncoder);
    std::array<red::NodeId, 16> ids;
    const auto successors = dag->successors(refined->encoder, ids);
    CHECK(successors->size() == 2 && (*successors)[1] == refined->decoder(1));
    CHECK(ended(dag->successors(refined->encoder, red::Span(ids).first(1)), RED_STATUS_TOO_SHORT));
    CHECK(ended(dag->refine(refined->encoder, red::Node(), {}), RED_STATUS_NO_DECODER));

    const auto summary = dag->summarize();
    CHECK(summary->nodes() == 5 && summary->levels() == 4 && summary->work() == 12ms && summary->critical_path() == 11ms);
    CHECK(summary->c().nodes == 5);
    CHECK(dag->remove_edge(refined->encoder, refined->decoder(0)).ok() && dag->remove_node(refined->decoder(0)).ok());
    CHECK(ended(dag->remove_node(refined->decoder(0)), RED_STATUS_UNKNOWN_NODE) && dag->c().bits != 0);
}

void deadlines() {
    auto dag = red::Dag::open(dag_memory);
    const auto a = dag->add_node(red::Node::ordinary(20s)), b = dag->add_node(red::Node::ordinary(20s));
    const auto c = dag->add_node(red::Node::ordinary(40s));
    CHECK(dag->chain({a, b, c}).ok());
    std::array<red::PlacedNode, 16> nodes;
    std::array<red::Level, 16> levels;
    const auto placed = dag->place(red::Rule::LatestStart, 70s, nodes);
    CHECK(placed->size() == 3 && (*placed)[0].node() == *a && (*placed)[1].height() == 1 && (*placed)[0].tail() == 60s);
    CHECK((*placed)[0].sub_deadline() == 10s && (*placed)[0].key() == -10s && (*placed)[0].c().node == 0);
    const auto shares = dag->share(red::Rule::LevelSum, 120s, levels);
    CHECK(shares->size() == 3 && (*shares)[1].end() == 60s && (*shares)[2].share() == 60s);
    CHECK((*shares)[0].cost() == 20s && (*shares)[0].graham() == 20s && (*shares)[0].c().cost_ns > 0);
    CHECK(ended(dag->place(red::Rule::LevelSum, std::chrono::hours::max(), nodes), RED_STATUS_TIME_OVERFLOW));
    CHECK(ended(dag->share(red::Rule::LevelSum, -1s, levels), RED_STATUS_OUT_OF_RANGE));
    CHECK(ended(dag->share(red::Rule::EndToEnd, 1s, levels), RED_STATUS_OUT_OF_RANGE));

    const std::array<std::uint32_t, 2> lanes = {2, 1};
    const std::array<std::uint64_t, 2> budgets = {RED_NONE_64, 0};
    const auto proof = dag->prove(100s, lanes);
    CHECK(proof->fits() && proof->response() == 80s && proof->limit() == 100s && proof->margin() == 20s);
    CHECK(proof->work() == 80s && proof->critical_path() == 80s && proof->lanes() == 2 && proof->memory_holds());
    CHECK(proof->bound() == red::Bound::Graham && proof->paths() == 0 && proof->c().fits == 1);
    CHECK(dag->prove(79s, lanes, budgets)->margin() == -1s && dag->prove(80s)->fits());
    CHECK(ended(dag->prove(79s, lanes, red::Span(budgets).first(1)), RED_STATUS_TOO_SHORT));
    CHECK(ended(dag->prove(-1s), RED_STATUS_OUT_OF_RANGE));
}

void loop() {
    auto scheduler = red::Scheduler::open(memory, red::Config::redrt().lanes(2));
    auto dag = red::Dag::open(dag_memory);
    const auto sensor = scheduler->add_sensor(33ms);
    const auto pool = scheduler->add_pool(1, 1000);
    const auto encoder = dag->add_node(red::Node::shared_encoder(4ms, {0, 0, sensor}).memory(10).pool(pool));
    const auto decoder = dag->add_node(red::Node::decoder(2ms).pool(pool));
    CHECK(dag->add_edge(encoder, decoder).ok());
    const auto task = scheduler->add_task(*dag, red::Timing::sporadic(50ms).every(40ms).value(3).floor(1, 2));
    CHECK(task && scheduler->certificate(task)->limit() == 40ms && *scheduler->poll_at() == red::never);

    // Both jobs read frame 0, so one execution is for both.
    const auto job = scheduler->release(task, at(1ms)), second = scheduler->release_at(task, at(1ms), std::nullopt, at(2ms));
    CHECK(job && second && *scheduler->job(task, 0) == *job && ended(scheduler->job(task, 9), RED_STATUS_UNKNOWN_JOB));
    const auto action = scheduler->poll(at(2ms));
    CHECK(action && action.kind() == red::ActionKind::Dispatch && !action.preempt() && !action.ended());
    const auto *dispatch = action.dispatch();
    CHECK(dispatch && dispatch->node == *encoder && dispatch->lane == red::LaneId(2) && action.c().unit == dispatch->unit.value());
    CHECK(!scheduler->poll(at(2ms)) && scheduler->polled().ok());
    const auto unit = scheduler->unit(dispatch->unit);
    CHECK(unit->lane() == dispatch->lane && unit->pool() == *pool && unit->started() == at(2ms) && unit->wcet() == 4ms);
    CHECK(unit->has_output() && unit->output() == unit->c().output && unit->first().node() == *encoder);
    std::array<red::Member, Small::jobs> room;
    const auto members = scheduler->members(dispatch->unit, room);
    CHECK(members->size() == 2 && (*members)[1].index() + (*members)[0].index() == 1 && (*members)[0].task() == *task);
    CHECK((*members)[0].release() == at(1ms) && (*members)[0].deadline() == at(51ms) && (*members)[0].sub_deadline() < at(51ms));
    CHECK((*members)[0].job() == *job && (*members)[0].c().node == 0);
    CHECK(*scheduler->memory_used(pool) == 10 && *scheduler->memory_used(red::first_pool) == 0);
    const auto figures = scheduler->figures();
    CHECK(figures->units() == 1 && figures->running() == 1 && figures->jobs_in_flight() == 2 && figures->ready() == 0);
    CHECK(figures->lanes() == 3 && !figures->can_dispatch() && figures->c().units == 1);

    // The lane asks for itself; then the last of both.
    auto next = scheduler->complete_and_poll(dispatch->unit, at(5ms));
    CHECK(next && next.dispatch()->node == *decoder);
    CHECK(ended(scheduler->complete_and_poll(dispatch->unit, at(5ms)), RED_STATUS_STALE) && ended(scheduler->polled(), RED_STATUS_STALE));
    CHECK(scheduler->complete(next.dispatch()->unit, at(6ms)).ok());
    const auto outcome = scheduler->take_outcome();
    CHECK(outcome && *outcome && (*outcome)->completed() && (*outcome)->on_time() && (*outcome)->response() == 5ms);
    CHECK((*outcome)->task() == *task && (*outcome)->deadline() == at(51ms) && (*outcome)->shed() == red::Shed::Not);
    CHECK((*outcome)->at() == at(6ms) && (*outcome)->release() == at(1ms) && (*outcome)->c().shed == 0);
    CHECK(scheduler->take_outcome().ok() && !*scheduler->take_outcome());
    next = scheduler->poll_on(red::LaneId(2), at(6ms));
    CHECK(next.dispatch() && scheduler->fail(next.dispatch()->unit, at(7ms)).ok());
    next = scheduler->poll(at(7ms));
    CHECK(next.ended() && next.ended()->shed() == red::Shed::Fault && !next.ended()->on_time() && next.ended()->index() + (*outcome)->index() == 1);
    CHECK(next.ended()->job() != (*outcome)->job() || next.ended()->index() != (*outcome)->index());

    const auto executions = scheduler->executions(task, decoder);
    CHECK(executions->mean() == 1ms && executions->minimum() == 1ms && executions->maximum() == 1ms);
    CHECK(!scheduler->executions(task, encoder)->mean() && executions->c().mean_ns == 1'000'000);
    std::array<red::Event, 4> events;
    const auto first = scheduler->take_events(events);
    CHECK(first->size() == 4 && (*first)[0].kind() == red::EventKind::Released && (*first)[0].at() == at(1ms));
    CHECK((*first)[0].task() == *task && (*first)[1].job_index() == 1 && (*first)[2].kind() == red::EventKind::Started);
    CHECK((*first)[2].node() == *encoder && (*first)[2].lane() == red::LaneId(2) && (*first)[2].shed() == red::Shed::Not);
    CHECK((*first)[2].c().lane == 2);
    CHECK(figures->encoder_runs_saved() == 0 && scheduler->figures()->encoder_runs_saved() == 1);
    const auto all = scheduler->figures();
    CHECK(all->overruns() == 0 && all->clock_steps_back() == 0 && all->late_completions() == 0);
    CHECK(all->evictions() == 0 && all->events_dropped() == 0);

    CHECK(scheduler->retire_lane(red::LaneId(0)).ok() && ended(scheduler->retire_lane(red::LaneId(9)), RED_STATUS_UNKNOWN_LANE));
    CHECK(scheduler->restore_lane(red::LaneId(0)).ok());
    auto edit = scheduler->edit(task, edit_memory);
    CHECK(edit->add_edge(decoder, edit->add_node(red::Node::ordinary(1ms))).ok());
    CHECK(scheduler->commit(*edit, at(8ms))->work() == 7ms && ended(scheduler->commit(*edit, at(8ms)), RED_STATUS_CONFLICT));
    CHECK(ended(scheduler->edit(task, edit_memory.bytes()), RED_STATUS_OVERLAP) && scheduler->remove_task(task, at(8ms)).ok());
    CHECK(edit->close().ok() && ended(scheduler->edit(task, edit_memory), RED_STATUS_UNKNOWN_TASK));
}

void preemption() {
    auto scheduler = red::Scheduler::open(memory, red::Config::edf().preempt(true));
    auto dag = red::Dag::open(dag_memory);
    CHECK(dag->add_node(red::Node::ordinary(10ms)).ok());
    const auto slow = scheduler->add_task(*dag, red::Timing::sporadic(50ms)), fast = scheduler->add_task(*dag, red::Timing::sporadic(20ms));
    CHECK(scheduler->release(slow, at(0ns)).ok());
    const auto first = scheduler->poll(at(0ns));
    CHECK(scheduler->release(fast, at(1ms)).ok());
    const auto taken = scheduler->poll(at(1ms));
    CHECK(taken.preempt() && taken.preempt()->unit == first.dispatch()->unit && !taken.dispatch());
    CHECK(taken.kind() == red::ActionKind::Preempt);
}

/// A lane that runs by itself what it is given, as a stream does.
void ahead() {
    auto scheduler = red::Scheduler::open(memory, red::Config::redrt().lanes(2));
    auto dag = red::Dag::open(dag_memory);
    const auto encoder = dag->add_node(red::Node::ordinary(2ms));
    for (int i = 0; i < 2; i++) {
        CHECK(dag->add_edge(encoder, dag->add_node(red::Node::ordinary(1ms))).ok());
    }
    CHECK(scheduler->dispatch_ahead(red::first_pool).ok() && ended(scheduler->dispatch_ahead(red::PoolId(1)), RED_STATUS_UNKNOWN_POOL));
    CHECK(ended(scheduler->dispatch_ahead(scheduler->add_pool(0)), RED_STATUS_NO_LANE));
    const auto task = scheduler->add_task(*dag, red::Timing::sporadic(50ms));
    CHECK(scheduler->release(task, at(0ns)).ok());
    const auto first = scheduler->poll(at(0ns)), behind = scheduler->poll(at(0ns)), beside = scheduler->poll(at(0ns));
    CHECK(first.dispatch() && !first.ahead() && behind.ahead() && !behind.dispatch() && beside.kind() == red::ActionKind::Ahead);
    CHECK(behind.ahead()->lane == red::LaneId(0) && beside.ahead()->lane == red::LaneId(1));
    std::array<red::UnitId, 2> room{red::UnitId(0), red::UnitId(0)};
    CHECK(scheduler->waits_for(behind.ahead()->unit, room)->empty());
    const auto before = scheduler->waits_for(beside.ahead()->unit, room);
    CHECK(before->size() == 1 && (*before)[0] == first.dispatch()->unit);
    CHECK(ended(scheduler->lose_pool(red::PoolId(1), at(1ms)), RED_STATUS_UNKNOWN_POOL));
    CHECK(scheduler->lose_pool(red::first_pool, at(1ms)).ok());
    const auto ended_by_that = scheduler->poll(at(1ms));
    CHECK(ended_by_that.ended()->shed() == red::Shed::Fault);
}

/// Of two jobs of which one lane ends one in time, the one of the lower value is warned of at once, and because of whom.
void warnings() {
    auto scheduler = red::Scheduler::open(memory, red::Config::redrt().lanes(1));
    const auto task = [&](red::Nanoseconds deadline, std::uint32_t value) {
        auto dag = red::Dag::open(dag_memory);
        CHECK(dag->add_node(red::Node::ordinary(4ms)).ok());
        return scheduler->add_task(*dag, red::Timing::sporadic(deadline).value(value));
    };
    const auto low = task(6ms, 1), high = task(7ms, 2);
    CHECK(scheduler->release(low, at(1ms)).ok() && scheduler->release(high, at(1ms)).ok());
    CHECK(scheduler->take_warning().ok() && !*scheduler->take_warning());
    const auto ended = scheduler->poll(at(1ms));
    CHECK(ended.ended() && ended.ended()->shed() == red::Shed::Overload && ended.ended()->task() == *low);
    const auto warning = **scheduler->take_warning();
    CHECK(warning.task() == *low && warning.index() == 0 && warning.job() == ended.ended()->job());
    CHECK(warning.because_of() == *high && warning.because_index() == 0 && warning.by() == 0ns);
    CHECK(warning.at() == at(1ms) && warning.deadline() == at(7ms) && warning.c().by_ns == 0);
    CHECK(!*scheduler->take_warning());
}

} // namespace

int main() {
    warnings();
    ahead();
    configs();
    graphs();
    deadlines();
    loop();
    preemption();
    return check_end("calls");
}
