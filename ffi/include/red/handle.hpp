// What is open: owned by one, closed by its destructor.
#ifndef RED_HANDLE_HPP
#define RED_HANDLE_HPP

#include "values.hpp"

namespace red {

/// Something open, to be moved and not copied. One that is not open (default, moved from, closed, or the value of a Result
/// that has none) answers every call with RED_STATUS_CLOSED, or with why it could not be opened.
template <class C, red_status (*Close)(C *)>
class Handle {
public:
    Handle(const Handle &) = delete;
    Handle &operator=(const Handle &) = delete;

    /// Ends it; its memory is the caller's again. Of one that is not open, the reason.
    Status close() noexcept {
        const Status closed = said(Close(&c_));
        if (closed) {
            why_ = RED_STATUS_CLOSED;
        }
        return closed;
    }

    [[nodiscard]] bool is_open() const noexcept { return c_.bits != 0; }
    /// OK while it is open, else why it is not.
    [[nodiscard]] Status status() const noexcept { return is_open() ? Status() : why_; }
    /// What the C interface knows it by.
    [[nodiscard]] const C &c() const noexcept { return c_; }

protected:
    Handle() noexcept = default;
    explicit Handle(Status why) noexcept : why_(why) {}
    ~Handle() { static_cast<void>(close()); }
    Handle(Handle &&other) noexcept : c_(other.c_), why_(other.why_) { other.forget(); }
    Handle &operator=(Handle &&other) noexcept {
        if (this != &other) {
            static_cast<void>(close());
            c_ = other.c_;
            why_ = other.why_;
            other.forget();
        }
        return *this;
    }

    /// What a call of the C interface said, with the reason of a handle that is not open.
    [[nodiscard]] Status said(red_status status) const noexcept { return status == RED_STATUS_CLOSED ? closed() : status; }

    C c_{};

private:
    [[nodiscard]] Status closed() const noexcept { return is_open() ? RED_STATUS_CLOSED : why_; }
    void forget() noexcept {
        c_ = C{};
        why_ = RED_STATUS_CLOSED;
    }

    Status why_ = RED_STATUS_CLOSED;
};

} // namespace red

#endif
