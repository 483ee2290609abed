// An executor that runs callbacks on lanes of RED: each timer, and the subscriptions that it feeds from topic to topic, is a
// task with a deadline from the timer's tick to the last callback.
#ifndef RED_EXECUTOR_HPP
#define RED_EXECUTOR_HPP

#include <chrono>
#include <deque>
#include <map>
#include <rclcpp.hpp>
#include <red.hpp>
#include <string>
#include <vector>

/// What the executor has to know and rclcpp does not tell.
struct RedTable {
    /// By the name of a node: what one of its callbacks takes at most.
    std::map<std::string, std::chrono::nanoseconds> wcets;
    /// By the name of the node that has the timer: from tick to last callback.
    std::map<std::string, std::chrono::nanoseconds> deadlines;
};

class RedExecutor : public rclcpp::Executor {
public:
    RedExecutor(RedTable table, const red::Config &policy, const red::RuntimeConfig &config);

    void add_node(std::shared_ptr<rclcpp::Node> node) override;
    /// Makes a task of each chain, starts the lanes, and returns after cancel. status() says how it went.
    void spin() override;
    /// From any thread, also a callback or a signal handler.
    void cancel() override;

    [[nodiscard]] red::Status status() const { return status_; }
    /// Why it could not spin, and what to do about it.
    [[nodiscard]] std::string message() const;
    [[nodiscard]] red::Result<red::Report> report() const { return runtime_->report(); }
    /// Ticks of a timer to the ends of its chain, of jobs that ended since the last call. While it spins, or after.
    [[nodiscard]] std::vector<red::Outcome> take_outcomes();

private:
    /// A callback on a lane. Groups that exclude each other are serialised by a lock: it is held for a callback's length at
    /// most, but its wait is not in the WCET.
    struct Callback {
        std::shared_ptr<rclcpp::TimerBase> timer;
        std::shared_ptr<rclcpp::SubscriptionBase> subscription;
        void operator()() const;
    };

    red::Status add_chain(const rclcpp::Node &node, const std::shared_ptr<rclcpp::TimerBase> &timer);
    red::Result<red::NodeId> add_callback(
        red::Dag &dag, red::Bodies &bodies, const std::string &node, Callback callback);

    RedTable table_;
    std::vector<std::shared_ptr<rclcpp::Node>> nodes_;
    // A deque: bodies keep the addresses. Before the runtime, whose lanes call them.
    std::deque<Callback> callbacks_;
    red::DagMemory<red::Runtime::Caps> memory_;
    red::Result<red::Runtime> runtime_;
    red::Status status_{};
};

#endif
