// How calls end: Status, and Result, which is a status and a value.
#ifndef RED_STATUS_HPP
#define RED_STATUS_HPP

#include "../red.h"

#include <cassert>
#include <type_traits>
#include <utility>

/// What a debug build does with the two misuses that a program can look for: Result::value() without a value, and
/// Span::operator[] beyond the end. Define it before including <red.hpp> to have something else; with NDEBUG it is nothing.
#ifndef RED_ASSERT
#define RED_ASSERT(condition) assert(condition)
#endif

namespace red {

/// How a call ended: one of RED_STATUS_..., and what to do about it in words.
class [[nodiscard]] Status {
public:
    constexpr Status() noexcept = default;
    constexpr Status(red_status code) noexcept : code_(code) {}

    [[nodiscard]] constexpr bool ok() const noexcept { return code_ == RED_STATUS_OK; }
    [[nodiscard]] constexpr explicit operator bool() const noexcept { return ok(); }
    /// For `switch`, and to compare with.
    [[nodiscard]] constexpr red_status code() const noexcept { return code_; }
    /// What went wrong, and what to do about it. The text is constant.
    [[nodiscard]] const char *text() const noexcept { return red_status_text(code_); }
    /// Itself: so a Status answers what a Result answers.
    [[nodiscard]] constexpr Status status() const noexcept { return *this; }

    friend constexpr bool operator==(Status a, Status b) noexcept { return a.code_ == b.code_; }
    friend constexpr bool operator!=(Status a, Status b) noexcept { return a.code_ != b.code_; }

private:
    red_status code_ = RED_STATUS_OK;
};

/// A value, or why there is none. Where there is none, the value is what T() is, and a handle that answers every call with
/// that reason: so misuse is an answer too, and never undefined.
template <class T>
class [[nodiscard]] Result {
    static_assert(std::is_default_constructible_v<T> && std::is_move_constructible_v<T>);

public:
    using value_type = T;

    constexpr Result(T value) noexcept : value_(std::move(value)) {}
    /// Without a value. A status that says OK says nothing about why, and becomes RED_STATUS_OUT_OF_RANGE.
    constexpr Result(Status why) noexcept : value_(absent(why)), status_(why.ok() ? RED_STATUS_OUT_OF_RANGE : why) {}
    constexpr Result(red_status why) noexcept : Result(Status(why)) {}

    [[nodiscard]] constexpr bool ok() const noexcept { return status_.ok(); }
    [[nodiscard]] constexpr explicit operator bool() const noexcept { return ok(); }
    [[nodiscard]] constexpr Status status() const noexcept { return status_; }
    /// Why, in words.
    [[nodiscard]] const char *text() const noexcept { return status_.text(); }

    /// The value; only if ok(). A debug build asserts that.
    [[nodiscard]] constexpr const T &value() const & noexcept { return RED_ASSERT(ok()), value_; }
    [[nodiscard]] constexpr T &value() & noexcept { return RED_ASSERT(ok()), value_; }
    /// Of an answer that goes away, moved out of it: `for (const auto &event : runtime.take_events(room).value())` is right.
    [[nodiscard]] constexpr T value() && noexcept { return RED_ASSERT(ok()), std::move(value_); }
    /// The value, or this one.
    [[nodiscard]] constexpr T value_or(T other) const & noexcept { return ok() ? value_ : std::move(other); }
    [[nodiscard]] constexpr T value_or(T other) && noexcept { return ok() ? std::move(value_) : std::move(other); }

    /// The value, or what stands for none.
    [[nodiscard]] constexpr const T &operator*() const & noexcept { return value_; }
    [[nodiscard]] constexpr T &operator*() & noexcept { return value_; }
    [[nodiscard]] constexpr T operator*() && noexcept { return std::move(value_); }
    [[nodiscard]] constexpr const T *operator->() const noexcept { return &value_; }
    [[nodiscard]] constexpr T *operator->() noexcept { return &value_; }

private:
    static constexpr T absent([[maybe_unused]] Status why) noexcept {
        if constexpr (std::is_constructible_v<T, Status>) {
            return T(why);
        } else {
            return T();
        }
    }

    T value_;
    Status status_{};
};

/// The first of several answers that is not OK, or OK: `first_error(dag.add_edge(a, b), dag.add_edge(b, c))`. Which of the
/// calls is made first is the compiler's choice: where one has to follow another, give them names before.
template <class... Answers>
[[nodiscard]] constexpr Status first_error(const Answers &...answers) noexcept {
    Status first;
    ((first = first.ok() ? answers.status() : first), ...);
    return first;
}

/// The version of the library that is linked, as "0.1.0".
[[nodiscard]] inline const char *version() noexcept { return red_version(); }
/// Whether the library that is linked is of the ABI of these headers. One of another ABI refuses every struct.
[[nodiscard]] inline bool is_compatible() noexcept { return red_abi_version() == RED_ABI_VERSION; }

} // namespace red

#endif
