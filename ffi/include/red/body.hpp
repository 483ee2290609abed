// What runs for a node: functions of yours, and what they are told.
#ifndef RED_BODY_HPP
#define RED_BODY_HPP

#include "memory.hpp"

#include <memory>

namespace red {

/// What a body is told. It is there as long as the body runs.
class Context {
public:
    Context(const Context &) = delete;
    Context &operator=(const Context &) = delete;

    [[nodiscard]] TaskId task() const noexcept { return TaskId(c_.task); }
    [[nodiscard]] NodeId node() const noexcept { return NodeId(c_.node); }
    [[nodiscard]] LaneId lane() const noexcept { return LaneId(c_.lane); }
    [[nodiscard]] PoolId pool() const noexcept { return PoolId(c_.pool); }
    /// The how-manieth job of its task, from 0.
    [[nodiscard]] std::uint64_t index() const noexcept { return c_.job; }
    /// When the job was released.
    [[nodiscard]] Time release() const noexcept { return time_from(c_.release_ns); }
    /// When the job is due.
    [[nodiscard]] Time deadline() const noexcept { return time_from(c_.deadline_ns); }
    /// When the node should end.
    [[nodiscard]] Time sub_deadline() const noexcept { return time_from(c_.sub_deadline_ns); }
    /// Of the node.
    [[nodiscard]] Nanoseconds wcet() const noexcept { return duration_from(c_.wcet_ns); }
    /// Whether it writes or reads an encoder's result; output() is its number then, and stays the same result until nobody in
    /// flight needs it.
    [[nodiscard]] bool has_output() const noexcept { return c_.output != RED_NONE; }
    [[nodiscard]] std::uint32_t output() const noexcept { return c_.output; }
    /// The CUDA stream of the lane: a cudaStream_t; nullptr where there is none.
    [[nodiscard]] void *stream() const noexcept { return c_.stream; }
    [[nodiscard]] const red_context &c() const noexcept { return c_; }

private:
    friend class Bodies;
    explicit Context(const red_context &c) noexcept : c_(c) {}

    const red_context &c_;
};

/// Which function runs for which node: a list with room for a body of each node. It allocates nothing, and is copied by the
/// call that takes it; what a body is called on is not copied, and has to stay where it is until the runtime is closed:
/// declare it before the runtime. A body that hangs, for ten times its WCET and 100 ms, is waited for by nobody: what it uses
/// has to outlive it, so look at `Report::hung` before that goes.
///
/// A body takes a `const Context &` or nothing, and says how it went:
///
/// | returns | |
/// |---|---|
/// | nothing | it did its work |
/// | bool | true: it did |
/// | Status, Result | OK: it did |
/// | int | RED_BODY_DONE: it did |
///
/// If it did not, its job is given up with Shed::Fault, and other jobs go on. So it is for an exception, which ends here and
/// is counted apart: Report::threw. A body runs on several lanes at once if jobs of its task overlap. It returns: it neither
/// ends its thread nor leaves by longjmp. It may release jobs and stop the runtime; what would wait for lanes is
/// RED_STATUS_BUSY there.
class Bodies {
public:
    Bodies() noexcept {}

    /// Anything that can be called: `bodies.on(camera, grab)`.
    template <class Callable>
    Bodies &on(Result<NodeId> node, Callable &callable) noexcept {
        static_assert(!std::is_function_v<Callable>, "of a function: bodies.on<function>(node)");
        return add(node, call<Callable>, address(callable));
    }
    /// A method of an object: `bodies.on<&Robot::grab>(camera, robot)`.
    template <auto Method, class Object>
    Bodies &on(Result<NodeId> node, Object &object) noexcept {
        return add(node, call_method<Method, Object>, address(object));
    }
    /// A function: `bodies.on<grab>(camera)`.
    template <auto Function>
    Bodies &on(Result<NodeId> node) noexcept {
        return add(node, call_function<Function>, nullptr);
    }
    /// A function of the C interface, which is called as it is: an exception that leaves it ends the process. Give what may
    /// throw to one of the others.
    Bodies &on(Result<NodeId> node, red_body body, void *user) noexcept { return add(node, body, user); }

    // It would be gone when the body runs.
    template <class Callable>
    Bodies &on(Result<NodeId> node, const Callable &&callable) = delete;
    template <auto Method, class Object>
    Bodies &on(Result<NodeId> node, const Object &&object) = delete;

    /// The first error of a node's name, or RED_STATUS_TOO_LONG: more bodies than a graph has nodes. The call that takes the
    /// list says the same.
    [[nodiscard]] Status status() const noexcept { return status_; }
    [[nodiscard]] Span<const red_callback> c() const noexcept { return {list_, size_}; }

private:
    Bodies &add(Result<NodeId> node, red_body body, void *user) noexcept {
        const Status full = size_ < Caps16x256x64::nodes ? RED_STATUS_OK : RED_STATUS_TOO_LONG;
        status_ = first_error(status_, node, full);
        if (status_) {
            list_[size_++] = red_callback{node->value(), 0, body, user};
        }
        return *this;
    }

    template <class Callable>
    static void *address(Callable &callable) noexcept {
        return const_cast<void *>(static_cast<const volatile void *>(std::addressof(callable)));
    }
    template <class Callable>
    static int call(void *user, const red_context *context) noexcept {
        return guarded(*static_cast<Callable *>(user), *context);
    }
    template <auto Method, class Object>
    static int call_method(void *user, const red_context *context) noexcept {
        auto &object = *static_cast<Object *>(user);
        if constexpr (std::is_invocable_v<decltype(Method), Object &, const Context &>) {
            return guarded([&object](const Context &told) { return (object.*Method)(told); }, *context);
        } else {
            return guarded([&object] { return (object.*Method)(); }, *context);
        }
    }
    template <auto Function>
    static int call_function(void *, const red_context *context) noexcept {
        return guarded(Function, *context);
    }

    /// No exception goes on to a lane, which is not of C++.
    template <class Callable>
    static int guarded(Callable &&callable, const red_context &context) noexcept {
#ifdef __cpp_exceptions
        try {
            return answer(callable, context);
        } catch (...) {
            return RED_BODY_THREW;
        }
#else
        return answer(callable, context);
#endif
    }
    template <class Callable>
    static int answer(Callable &callable, [[maybe_unused]] const red_context &context) {
        if constexpr (std::is_invocable_v<Callable &, const Context &>) {
            return number([&]() -> decltype(auto) { return callable(Context(context)); });
        } else {
            static_assert(std::is_invocable_v<Callable &>, "a body takes a const red::Context &, or nothing");
            return number(callable);
        }
    }
    template <class Call>
    static int number(Call &&call) {
        using Said = std::decay_t<decltype(call())>;
        if constexpr (std::is_void_v<Said>) {
            return call(), RED_BODY_DONE;
        } else if constexpr (std::is_same_v<Said, bool>) {
            return call() ? RED_BODY_DONE : RED_BODY_FAILED;
        } else if constexpr (std::is_same_v<Said, int>) {
            return call();
        } else if constexpr (has_status<Said>(nullptr)) {
            return call().status().ok() ? RED_BODY_DONE : RED_BODY_FAILED;
        } else {
            static_assert(has_status<Said>(nullptr), "a body returns nothing, bool, int, red::Status or red::Result");
            return RED_BODY_FAILED;
        }
    }
    template <class Said>
    static constexpr bool has_status(decltype(std::declval<const Said &>().status()) *) noexcept {
        return std::is_same_v<decltype(std::declval<const Said &>().status()), Status>;
    }
    template <class Said>
    static constexpr bool has_status(...) noexcept {
        return false;
    }

    // What is beyond size_ is never read.
    red_callback list_[Caps16x256x64::nodes];
    std::size_t size_ = 0;
    Status status_{};
};

} // namespace red

#endif
