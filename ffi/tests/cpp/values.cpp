// Status, Result, Span, names and time: what they hold, and what becomes of misuse.
#include "tests.hpp"

#include <limits>
#include <memory>
#include <unordered_set>
#include <vector>

namespace {

void statuses() {
    const red::Status fine, cycle = RED_STATUS_CYCLE;
    CHECK(fine.ok() && fine && !cycle.ok() && !cycle);
    CHECK(cycle == RED_STATUS_CYCLE && cycle != fine && cycle.code() == RED_STATUS_CYCLE);
    CHECK(std::string(cycle.text()) == "the edge would close a cycle");
    CHECK(red::first_error(fine, fine).ok());
    CHECK(red::first_error(fine, cycle, red::Status(RED_STATUS_STALE)) == RED_STATUS_CYCLE);
    CHECK(red::is_compatible() && std::string(red::version()) == "0.1.0");
}

void results() {
    red::Result<int> seven = 7;
    const red::Result<int> none = RED_STATUS_STALE, also_none = red::Status(RED_STATUS_LATE);
    CHECK(seven.ok() && seven && seven.value() == 7 && *seven == 7 && seven.value_or(9) == 7);
    CHECK(!none && none.status() == RED_STATUS_STALE && none.value_or(9) == 9 && also_none.status() == RED_STATUS_LATE);
    CHECK(std::string(none.text()) == "the unit was reported before");
    *seven = 8;
    CHECK(*std::as_const(seven) == 8 && std::as_const(seven).value() == 8);

    // Without a value there is what T() is: no call of a Result is undefined.
    CHECK(*none == 0 && red::Result<red::NodeId>(RED_STATUS_STALE)->is_none());
    // "Done" is no reason why there is no value.
    CHECK(red::Result<int>(RED_STATUS_OK).status() == RED_STATUS_OUT_OF_RANGE);

    // Values that can only be moved.
    red::Result<std::unique_ptr<int>> owner = std::make_unique<int>(3);
    const std::unique_ptr<int> taken = std::move(owner).value();
    CHECK(taken && *taken == 3 && owner.ok() && *owner == nullptr);
    const auto other = red::Result<std::unique_ptr<int>>(RED_STATUS_STALE).value_or(std::make_unique<int>(4));
    CHECK(*other == 4 && **red::Result<std::unique_ptr<int>>(std::make_unique<int>(5)) == 5);
}

void spans() {
    int three[] = {1, 2, 3};
    std::array<int, 2> two = {4, 5};
    std::vector<int> four = {1, 2, 3, 4};
    const red::Span<int> span = three;
    CHECK(span.size() == 3 && span[2] == 3 && !span.empty() && span.data() == three);
    CHECK(red::Span<int>(two).size() == 2 && red::Span<const int>(four).size() == 4);
    CHECK(red::Span<const int>(span).size() == 3 && span.first(2).size() == 2 && span.first(9).size() == 3);
    CHECK(red::Span<int>().empty() && red::Span<int>().begin() == red::Span<int>().end());
    int sum = 0;
    for (const int number : span) {
        sum += number;
    }
    CHECK(sum == 6);
}

void names() {
    const red::NodeId one(1), two(2);
    CHECK(one == red::NodeId(1) && one != two && one < two && two.value() == 2 && !one.is_none());
    CHECK(red::NodeId().is_none() && red::UnitId().is_none() && red::UnitId(7).value() == 7);
    static_assert(red::first_pool.value() == 0);
    static_assert(!std::is_convertible_v<red::NodeId, red::TaskId> && !std::is_convertible_v<int, red::LaneId>);
    static_assert(!std::is_same_v<red::JobId, red::SensorId> && !std::is_same_v<red::PoolId, red::LaneId>);
    const std::unordered_set<red::NodeId> set = {one, two, one};
    CHECK(set.size() == 2);
}

void durations() {
    using Hours = std::chrono::hours;
    constexpr auto longest = std::numeric_limits<std::int64_t>::max();
    CHECK(red::Duration(3ms).ns() == 3'000'000 && red::Duration(0ns).status().ok());
    CHECK(red::Duration(std::chrono::nanoseconds::max()).ns() == static_cast<std::uint64_t>(longest));
    CHECK(ended(red::Duration(-1ns), RED_STATUS_OUT_OF_RANGE));
    CHECK(ended(red::Duration(std::chrono::nanoseconds::min()), RED_STATUS_OUT_OF_RANGE));
    // 106,751 days are the last whole ones in 63 bits of nanoseconds.
    CHECK(red::Duration(Hours(106'751 * 24)).status().ok());
    CHECK(ended(red::Duration(Hours(106'752 * 24)), RED_STATUS_TIME_OVERFLOW));
    CHECK(ended(red::Duration(Hours::max()), RED_STATUS_TIME_OVERFLOW));
    using Unsigned = std::chrono::duration<std::uint64_t, std::nano>;
    CHECK(red::Duration(Unsigned(5)).ns() == 5);
    CHECK(ended(red::Duration(Unsigned::max()), RED_STATUS_TIME_OVERFLOW));
    using Narrow = std::chrono::duration<std::uint8_t, std::milli>;
    CHECK(red::Duration(Narrow(std::uint8_t{200})).ns() == 200'000'000);
    // What would round is no duration of ours: say how, with std::chrono::duration_cast.
    static_assert(!std::is_constructible_v<red::Duration, std::chrono::duration<double>>);
    static_assert(!std::is_constructible_v<red::Duration, std::chrono::duration<int, std::pico>>);
    static_assert(!std::is_convertible_v<int, red::Duration>);
}

void instants() {
    CHECK(red::Instant(at(5ms)).ns() == 5'000'000);
    CHECK(ended(red::Instant(at(-1ns)), RED_STATUS_OUT_OF_RANGE) && ended(red::Instant(red::Time::min()), RED_STATUS_OUT_OF_RANGE));
    CHECK(red::Instant(red::never).status().ok());
    using Days = std::chrono::duration<std::int64_t, std::ratio<86'400>>;
    using FarAway = std::chrono::time_point<std::chrono::steady_clock, Days>;
    CHECK(ended(red::Instant(FarAway::max()), RED_STATUS_TIME_OVERFLOW));
    CHECK(red::Instant(std::chrono::steady_clock::now()).status().ok());
    static_assert(!std::is_constructible_v<red::Instant, std::chrono::system_clock::time_point>);

    CHECK(red::duration_from(7) == 7ns && red::duration_from(RED_NONE_64) == red::Nanoseconds::max());
    CHECK(red::time_from(7) == at(7ns) && red::time_from(RED_NONE_64) == red::never);
}

} // namespace

int main() {
    statuses();
    results();
    spans();
    names();
    durations();
    instants();
    return check_end("values");
}
