// Small values: arrays that are lent, names of things, and time.
#ifndef RED_VALUES_HPP
#define RED_VALUES_HPP

#include "status.hpp"

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <ratio>

namespace red {

/// Some Ts in a row that belong to somebody else: std::span for C++17.
template <class T>
class Span {
public:
    constexpr Span() noexcept = default;
    constexpr Span(T *data, std::size_t size) noexcept : data_(data), size_(size) {}
    template <std::size_t N>
    constexpr Span(T (&array)[N]) noexcept : data_(array), size_(N) {}
    /// Of anything with data() and size(): std::array, std::vector, another Span.
    template <class Row, class = std::enable_if_t<
                             std::is_convertible_v<std::remove_pointer_t<decltype(std::declval<Row &>().data())> (*)[], T (*)[]>
                             && std::is_convertible_v<decltype(std::declval<Row &>().size()), std::size_t>>>
    constexpr Span(Row &&row) noexcept : data_(row.data()), size_(row.size()) {}

    [[nodiscard]] constexpr T *data() const noexcept { return data_; }
    [[nodiscard]] constexpr std::size_t size() const noexcept { return size_; }
    [[nodiscard]] constexpr bool empty() const noexcept { return size_ == 0; }
    [[nodiscard]] constexpr T *begin() const noexcept { return data_; }
    [[nodiscard]] constexpr T *end() const noexcept { return data_ + size_; }
    /// The `i`-th; only below size(). A debug build asserts that.
    [[nodiscard]] constexpr T &operator[](std::size_t i) const noexcept { return RED_ASSERT(i < size_), data_[i]; }
    /// The first `count`, or all if they are fewer.
    [[nodiscard]] constexpr Span first(std::size_t count) const noexcept { return {data_, count < size_ ? count : size_}; }

private:
    T *data_ = nullptr;
    std::size_t size_ = 0;
};

template <class Row>
Span(Row &&) -> Span<std::remove_pointer_t<decltype(std::declval<Row &>().data())>>;

/// A name that the library gave, of one kind of thing: a node's is no task's. Without a number it names nothing.
template <class Kind, class Number>
class Id {
public:
    constexpr Id() noexcept = default;
    constexpr explicit Id(Number number) noexcept : number_(number) {}
    /// The number that the C interface has for it.
    [[nodiscard]] constexpr Number value() const noexcept { return number_; }
    [[nodiscard]] constexpr bool is_none() const noexcept { return number_ == none; }

    friend constexpr bool operator==(Id a, Id b) noexcept { return a.number_ == b.number_; }
    friend constexpr bool operator!=(Id a, Id b) noexcept { return a.number_ != b.number_; }
    friend constexpr bool operator<(Id a, Id b) noexcept { return a.number_ < b.number_; }

private:
    static constexpr Number none = std::numeric_limits<Number>::max();
    Number number_ = none;
};

/// A node of one graph.
using NodeId = Id<struct NodeKind, std::uint32_t>;
/// An admitted task.
using TaskId = Id<struct TaskKind, std::uint32_t>;
/// One release of a task, in flight.
using JobId = Id<struct JobKind, std::uint32_t>;
/// What a lane was given to run; a name is used once.
using UnitId = Id<struct UnitKind, std::uint64_t>;
/// A lane, counted over all pools in their order.
using LaneId = Id<struct LaneKind, std::uint32_t>;
/// A pool of lanes.
using PoolId = Id<struct PoolKind, std::uint32_t>;
/// A sensor whose captures jobs may share.
using SensorId = Id<struct SensorKind, std::uint32_t>;

/// The pool that a configuration makes.
inline constexpr PoolId first_pool{0};

/// What the library gives as a duration; what does not fit is the longest.
using Nanoseconds = std::chrono::nanoseconds;
/// An instant. std::chrono::steady_clock is CLOCK_MONOTONIC on Linux, the clock of the runtime.
using Time = std::chrono::time_point<std::chrono::steady_clock, Nanoseconds>;
/// Where a time is answered: not at all.
inline constexpr Time never = Time::max();

/// What methods take as a duration: any of std::chrono in whole units. One below zero is RED_STATUS_OUT_OF_RANGE and one
/// that 63 bits of nanoseconds do not hold RED_STATUS_TIME_OVERFLOW, of the call that it is given to; nothing wraps.
class Duration {
    template <class Rep, class Period>
    using Whole = std::enable_if_t<
        std::is_integral_v<Rep> && std::is_convertible_v<std::chrono::duration<Rep, Period>, Nanoseconds>>;

public:
    template <class Rep, class Period, class = Whole<Rep, Period>>
    constexpr Duration(std::chrono::duration<Rep, Period> given) noexcept {
        constexpr auto longest = static_cast<std::uint64_t>(Nanoseconds::max().count());
        constexpr auto unit = static_cast<std::uint64_t>(std::ratio_divide<Period, std::nano>::num);
        if constexpr (std::is_signed_v<Rep>) {
            if (given.count() < 0) {
                status_ = RED_STATUS_OUT_OF_RANGE;
                return;
            }
        }
        const auto count = static_cast<std::uint64_t>(given.count());
        if (count > longest / unit) {
            status_ = RED_STATUS_TIME_OVERFLOW;
            return;
        }
        ns_ = count * unit;
    }

    [[nodiscard]] constexpr std::uint64_t ns() const noexcept { return ns_; }
    [[nodiscard]] constexpr Status status() const noexcept { return status_; }

private:
    std::uint64_t ns_ = 0;
    Status status_{};
};

/// What methods take as an instant: a time of steady_clock in any whole unit. Refused as a Duration is.
class Instant {
public:
    template <class Unit>
    constexpr Instant(std::chrono::time_point<std::chrono::steady_clock, Unit> given) noexcept
        : since_(given.time_since_epoch()) {}

    [[nodiscard]] constexpr std::uint64_t ns() const noexcept { return since_.ns(); }
    [[nodiscard]] constexpr Status status() const noexcept { return since_.status(); }

private:
    Duration since_;
};

/// From the C interface; what does not fit is the longest.
[[nodiscard]] constexpr Nanoseconds duration_from(std::uint64_t ns) noexcept {
    constexpr auto longest = static_cast<std::uint64_t>(Nanoseconds::max().count());
    return Nanoseconds(static_cast<Nanoseconds::rep>(ns < longest ? ns : longest));
}

/// From the C interface; what does not fit is `never`.
[[nodiscard]] constexpr Time time_from(std::uint64_t ns) noexcept { return Time(duration_from(ns)); }

} // namespace red

template <class Kind, class Number>
struct std::hash<red::Id<Kind, Number>> {
    std::size_t operator()(red::Id<Kind, Number> id) const noexcept { return std::hash<Number>()(id.value()); }
};

#endif
