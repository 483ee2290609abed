// Handles: opened, moved, closed, and what is left of them; errors that go on from call to call.
#include "tests.hpp"

#include <memory>

namespace {

red::SchedulerMemory<Small> memory, more;
red::DagMemory<Small> dag_memory, more_dag_memory;

/// Every call of a graph that is not open says why.
void answers_dag(red::Dag &dag, red_status why) {
    std::array<red::PlacedNode, 4> nodes;
    std::array<red::Level, 4> levels;
    std::array<red::NodeId, 4> ids;
    const auto node = red::Node::ordinary(1ms);
    CHECK(!dag.is_open() && ended(dag, why) && ended(dag.add_node(node), why) && ended(dag.add_edge(red::NodeId(0), red::NodeId(1)), why));
    CHECK(ended(dag.chain({}), why) && ended(dag.remove_node(red::NodeId(0)), why));
    CHECK(ended(dag.remove_edge(red::NodeId(0), red::NodeId(1)), why) && ended(dag.refine(red::NodeId(0), node, {}), why));
    CHECK(ended(dag.summarize(), why) && ended(dag.node(red::NodeId(0)), why) && ended(dag.successors(red::NodeId(0), ids), why));
    CHECK(ended(dag.place(red::Rule::LevelSum, 1s, nodes), why) && ended(dag.share(red::Rule::LevelSum, 1s, levels), why));
    CHECK(ended(dag.prove(1s), why) && ended(dag.close(), why));
}

/// Every call of a scheduler that is not open says why.
void answers(red::Scheduler &scheduler, red_status why) {
    const auto now = at(1ms);
    const red::TaskId task(0);
    const red::UnitId unit(0);
    std::array<red::Member, 4> members;
    std::array<red::Event, 4> events;
    const auto dag = red::Dag::open(dag_memory);
    CHECK(dag && !scheduler.is_open() && ended(scheduler, why) && ended(scheduler.add_pool(1), why));
    CHECK(ended(scheduler.add_sensor(1ms), why) && ended(scheduler.retire_lane(red::LaneId(0)), why));
    CHECK(ended(scheduler.restore_lane(red::LaneId(0)), why) && ended(scheduler.add_task(*dag, red::Timing::sporadic(1s)), why));
    CHECK(ended(scheduler.remove_task(task, now), why) && ended(scheduler.certificate(task), why));
    CHECK(ended(scheduler.edit(task, more_dag_memory), why) && ended(scheduler.commit(*dag, now), why));
    CHECK(ended(scheduler.release(task, now), why) && ended(scheduler.release_at(task, now, 1, now), why));
    CHECK(ended(scheduler.poll(now), why) && ended(scheduler.poll_on(red::LaneId(0), now), why) && ended(scheduler.polled(), why));
    CHECK(ended(scheduler.complete(unit, now), why) && ended(scheduler.complete_and_poll(unit, now), why));
    CHECK(ended(scheduler.fail(unit, now), why) && ended(scheduler.take_outcome(), why) && ended(scheduler.take_warning(), why) && ended(scheduler.poll_at(), why));
    CHECK(ended(scheduler.unit(unit), why) && ended(scheduler.members(unit, members), why) && ended(scheduler.job(task, 0), why));
    CHECK(ended(scheduler.executions(task, red::NodeId(0)), why) && ended(scheduler.figures(), why));
    CHECK(ended(scheduler.take_events(events), why) && ended(scheduler.memory_used(red::first_pool), why));
    std::array<red::UnitId, 4> units{unit, unit, unit, unit};
    CHECK(ended(scheduler.dispatch_ahead(red::first_pool), why) && ended(scheduler.lose_pool(red::first_pool, now), why));
    CHECK(ended(scheduler.waits_for(unit, units), why));
    CHECK(ended(scheduler.config(), why) && ended(scheduler.close(), why));
}

void never_opened() {
    red::Dag dag;
    answers_dag(dag, RED_STATUS_CLOSED);
    red::Scheduler scheduler;
    answers(scheduler, RED_STATUS_CLOSED);

    // One that could not be opened keeps the reason.
    auto refused = red::Scheduler::open(memory, red::Config::redrt().lanes(0));
    CHECK(ended(refused, RED_STATUS_NO_LANE));
    answers(*refused, RED_STATUS_NO_LANE);
    auto short_one = red::Dag::open<Small>(dag_memory.bytes().first(16));
    CHECK(ended(short_one, RED_STATUS_TOO_SHORT));
    answers_dag(*short_one, RED_STATUS_TOO_SHORT);
    const red::Span<std::byte> odd(dag_memory.bytes().data() + 1, dag_memory.bytes().size() - 1);
    CHECK(ended(red::Dag::open<Small>(odd), RED_STATUS_MISALIGNED));
}

void moves() {
    auto opened = red::Dag::open(dag_memory);
    red::Dag first = std::move(*opened);
    CHECK(first.is_open() && first.status().ok());
    answers_dag(*opened, RED_STATUS_CLOSED);
    CHECK(first.add_node(red::Node::ordinary(1ms)).ok());
    red::Dag second = std::move(first);
    answers_dag(first, RED_STATUS_CLOSED);
    CHECK(second.summarize()->nodes() == 1);

    // Assigned to: what it had is closed, and its memory free.
    auto third = red::Dag::open(more_dag_memory).value_or(red::Dag());
    third = std::move(second);
    CHECK(third.summarize()->nodes() == 1 && red::Dag::open(more_dag_memory).ok());
    red::Dag &itself = third;
    third = std::move(itself);
    CHECK(third.is_open() && third.close().ok());
    answers_dag(third, RED_STATUS_CLOSED);

    auto scheduler = red::Scheduler::open(memory, red::Config());
    red::Scheduler moved = std::move(*scheduler);
    answers(*scheduler, RED_STATUS_CLOSED);
    CHECK(moved.poll_at().ok());
    moved = red::Scheduler();
    answers(moved, RED_STATUS_CLOSED);
    static_assert(!std::is_copy_constructible_v<red::Dag> && !std::is_copy_assignable_v<red::Scheduler>);
    static_assert(std::is_nothrow_move_constructible_v<red::Dag> && std::is_nothrow_move_assignable_v<red::Scheduler>);
}

void closes() {
    {
        const auto dag = red::Dag::open(dag_memory);
        CHECK(dag && ended(red::Dag::open(dag_memory), RED_STATUS_OVERLAP));
    }
    // The destructor gave the memory back.
    auto dag = red::Dag::open(dag_memory);
    CHECK(dag && dag->close().ok() && ended(dag->close(), RED_STATUS_CLOSED) && ended(dag->close(), RED_STATUS_CLOSED));

    auto scheduler = red::Scheduler::open(memory, red::Config::redrt());
    CHECK(scheduler && scheduler->c().bits != 0 && scheduler->close().ok() && ended(scheduler->close(), RED_STATUS_CLOSED));
    CHECK(red::Scheduler::open(memory, red::Config::redrt()).ok());
}

void memories() {
    CHECK(memory.bytes().size() == Small::scheduler_bytes && Small::scheduler_needs() <= Small::scheduler_bytes);
    CHECK(red::Caps8x64x32::scheduler_needs() <= red::Caps8x64x32::scheduler_bytes);
    CHECK(red::Caps16x256x64::scheduler_needs() <= red::Caps16x256x64::scheduler_bytes);
    CHECK(red::align() > 0 && alignof(red::SchedulerMemory<Small>) % red::align() == 0);
    static_assert(!std::is_copy_constructible_v<red::DagMemory<Small>> && !std::is_move_constructible_v<red::SchedulerMemory<Small>>);

    // Where one likes: on the heap, in a larger class, and as bytes of one's own.
    const auto heap = std::make_unique<red::SchedulerMemory<red::Caps16x256x64>>();
    const auto graph = std::make_unique<red::DagMemory<red::Caps16x256x64>>();
    const auto large = red::Scheduler::open(*heap, red::Config().lanes(red::Caps16x256x64::lanes));
    auto large_dag = red::Dag::open(*graph);
    CHECK(large && large->figures()->lanes() == 32 && large_dag->add_node(red::Node()).ok());
    alignas(RED_ALIGN) static std::byte bytes[red::Caps8x64x32::scheduler_bytes];
    auto middle = red::Scheduler::open<red::Caps8x64x32>(bytes, red::Config());
    const auto middle_memory = std::make_unique<red::DagMemory<red::Caps8x64x32>>();
    auto middle_dag = red::Dag::open(*middle_memory);
    CHECK(middle && middle_dag->add_node(red::Node()).ok() && middle->add_task(*middle_dag, red::Timing::sporadic(1s)).ok());
    CHECK(ended(middle->add_task(*large_dag, red::Timing::sporadic(1s)), RED_STATUS_OTHER_CLASS));
}

/// The first error goes on, whatever comes after it.
void chains() {
    auto scheduler = red::Scheduler::open(memory, red::Config::redrt());
    auto dag = red::Dag::open(dag_memory);
    const auto bad = dag->add_node(red::Node::ordinary(-1ns));
    const auto good = dag->add_node(red::Node::ordinary(1ms));
    CHECK(ended(bad, RED_STATUS_OUT_OF_RANGE) && good);
    CHECK(ended(dag->add_edge(bad, good), RED_STATUS_OUT_OF_RANGE) && ended(dag->chain({good, bad, good}), RED_STATUS_OUT_OF_RANGE));
    CHECK(ended(dag->remove_node(bad), RED_STATUS_OUT_OF_RANGE) && ended(dag->remove_edge(good, bad), RED_STATUS_OUT_OF_RANGE));
    CHECK(ended(dag->node(bad), RED_STATUS_OUT_OF_RANGE));
    std::array<red::NodeId, 2> ids;
    CHECK(ended(dag->successors(bad, ids), RED_STATUS_OUT_OF_RANGE));
    const auto decoders = std::array{red::Node::decoder(1ms), red::Node::decoder(std::chrono::hours::max())};
    CHECK(ended(dag->refine(good, red::Node::shared_encoder(1ms, {}), decoders), RED_STATUS_TIME_OVERFLOW));

    const auto no_sensor = scheduler->add_sensor(0ns);
    CHECK(ended(no_sensor, RED_STATUS_ZERO_PERIOD));
    const auto encoder = red::Node::shared_encoder(1ms, {0, 0, no_sensor});
    CHECK(ended(encoder, RED_STATUS_ZERO_PERIOD) && ended(dag->add_node(encoder), RED_STATUS_ZERO_PERIOD));
    const auto no_pool = scheduler->add_pool(9);
    CHECK(ended(no_pool, RED_STATUS_POOLS_FULL) && ended(dag->add_node(red::Node::ordinary(1ms).pool(no_pool)), RED_STATUS_POOLS_FULL));
    // Of two errors the first one counts.
    CHECK(ended(red::Node::ordinary(-1ns).pool(no_pool), RED_STATUS_OUT_OF_RANGE));
    CHECK(ended(scheduler->memory_used(no_pool), RED_STATUS_POOLS_FULL));

    const auto no_task = scheduler->add_task(*dag, red::Timing::sporadic(0ns));
    CHECK(ended(no_task, RED_STATUS_DEADLINE) && ended(scheduler->release(no_task, at(0ns)), RED_STATUS_DEADLINE));
    CHECK(ended(scheduler->add_task(*dag, red::Timing::sporadic(1s).every(0ns)), RED_STATUS_ZERO_PERIOD));
    CHECK(ended(scheduler->add_task(*dag, red::Timing::sporadic(1s).every(-1s)), RED_STATUS_OUT_OF_RANGE));
    CHECK(ended(scheduler->add_task(*dag, red::Timing::sporadic(1s).floor(2, 1)), RED_STATUS_OUT_OF_RANGE));
    CHECK(ended(scheduler->certificate(no_task), RED_STATUS_DEADLINE) && ended(scheduler->job(no_task, 0), RED_STATUS_DEADLINE));
    auto no_edit = scheduler->edit(no_task, more_dag_memory);
    CHECK(ended(no_edit, RED_STATUS_DEADLINE) && ended(no_edit->add_node(red::Node()), RED_STATUS_DEADLINE));
    CHECK(ended(scheduler->commit(*no_edit, at(0ns)), RED_STATUS_DEADLINE));
    CHECK(ended(scheduler->executions(no_task, good), RED_STATUS_DEADLINE));
    CHECK(ended(scheduler->remove_task(no_task, at(0ns)), RED_STATUS_DEADLINE));
    CHECK(ended(red::Scheduler::open(more, red::Config().overload_tick(-5ms)), RED_STATUS_OUT_OF_RANGE));
    CHECK(ended(red::Scheduler::open(more, red::Config().merge(std::chrono::hours::max())), RED_STATUS_TIME_OVERFLOW));

    // Times that cannot be reach no call.
    const auto before = at(-1ns);
    const red::UnitId unit(0);
    const auto task = scheduler->add_task(*dag, red::Timing::sporadic(1s));
    CHECK(ended(scheduler->release(task, before), RED_STATUS_OUT_OF_RANGE));
    CHECK(ended(scheduler->release_at(task, before, std::nullopt, at(0ns)), RED_STATUS_OUT_OF_RANGE));
    CHECK(ended(scheduler->poll(before), RED_STATUS_OUT_OF_RANGE) && ended(scheduler->polled(), RED_STATUS_OUT_OF_RANGE));
    CHECK(ended(scheduler->poll_on(red::LaneId(0), before), RED_STATUS_OUT_OF_RANGE));
    CHECK(ended(scheduler->complete(unit, before), RED_STATUS_OUT_OF_RANGE) && ended(scheduler->fail(unit, before), RED_STATUS_OUT_OF_RANGE));
    CHECK(ended(scheduler->complete_and_poll(unit, before), RED_STATUS_OUT_OF_RANGE));
    CHECK(ended(scheduler->remove_task(task, before), RED_STATUS_OUT_OF_RANGE) && ended(scheduler->commit(*dag, before), RED_STATUS_OUT_OF_RANGE));
}

} // namespace

int main() {
    never_opened();
    moves();
    closes();
    memories();
    chains();
    return check_end("handles");
}
