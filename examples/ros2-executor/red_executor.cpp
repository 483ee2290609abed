#include "red_executor.hpp"

#include <algorithm>
#include <array>
#include <mutex>
#include <utility>

RedExecutor::RedExecutor(RedTable table, const red::Config &policy, const red::RuntimeConfig &config)
    : table_(std::move(table)), runtime_(red::Runtime::open(policy, config)), status_(runtime_.status()) {}

void RedExecutor::add_node(std::shared_ptr<rclcpp::Node> node) { nodes_.push_back(std::move(node)); }

void RedExecutor::spin() {
    for (const auto &node : nodes_) {
        for (const auto &timer : node->timers()) {
            if (status_.ok()) {
                status_ = add_chain(*node, timer);
            }
        }
    }
    if (status_.ok()) {
        status_ = runtime_->start();
    }
    if (status_.ok()) {
        status_ = runtime_->wait();
    }
}

void RedExecutor::cancel() { static_cast<void>(runtime_->stop()); }

std::string RedExecutor::message() const {
    std::array<char, 1024> room{};
    const std::string why = runtime_->message(room);
    return why.empty() ? status_.text() : why;
}

std::vector<red::Outcome> RedExecutor::take_outcomes() {
    std::array<red::Outcome, 64> room;
    std::vector<red::Outcome> all;
    for (;;) {
        const auto taken = runtime_->take_outcomes(room);
        all.insert(all.end(), taken->begin(), taken->end());
        if (taken->empty()) {
            return all;
        }
    }
}

void RedExecutor::Callback::operator()() const {
    const auto &group = timer ? timer->get_callback_group() : subscription->get_callback_group();
    std::unique_lock<std::mutex> turn(group->turn(), std::defer_lock);
    if (group->type() == rclcpp::CallbackGroupType::MutuallyExclusive) {
        turn.lock();
    }
    if (timer) {
        timer->execute_callback();
    } else {
        subscription->execute();
    }
}

red::Result<red::NodeId> RedExecutor::add_callback(
    red::Dag &dag, red::Bodies &bodies, const std::string &node, Callback callback) {
    const auto wcet = table_.wcets.find(node);
    if (wcet == table_.wcets.end()) {
        return RED_STATUS_UNKNOWN_NODE;
    }
    const auto made = dag.add_node(red::Node::ordinary(wcet->second));
    callbacks_.push_back(std::move(callback));
    bodies.on(made, callbacks_.back());
    return made;
}

/// From topic to topic, each node once: a topic that leads back to a node that is there already would be a cycle, which the
/// graph refuses.
red::Status RedExecutor::add_chain(const rclcpp::Node &node, const std::shared_ptr<rclcpp::TimerBase> &timer) {
    auto dag = red::Dag::open(memory_);
    red::Bodies bodies;
    const auto deadline = table_.deadlines.find(node.get_name());
    if (deadline == table_.deadlines.end()) {
        return RED_STATUS_DEADLINE;
    }
    struct Reached {
        const rclcpp::Node *node;
        rclcpp::SubscriptionBase *subscription;
        red::Result<red::NodeId> id;
    };
    std::vector<Reached> reached = {{&node, nullptr, add_callback(*dag, bodies, node.get_name(), {timer, nullptr})}};
    red::Status status = reached.front().id.status();
    for (std::size_t i = 0; i < reached.size() && status.ok(); i++) {
        const Reached from = reached[i];
        for (const auto &to : nodes_) {
            for (const auto &subscription : to->subscriptions()) {
                const auto &topics = from.node->published();
                if (std::find(topics.begin(), topics.end(), subscription->get_topic_name()) == topics.end()) {
                    continue;
                }
                auto known = std::find_if(reached.begin(), reached.end(),
                    [&](const Reached &other) { return other.subscription == subscription.get(); });
                if (known == reached.end()) {
                    reached.push_back({to.get(), subscription.get(),
                        add_callback(*dag, bodies, to->get_name(), {nullptr, subscription})});
                    known = std::prev(reached.end());
                }
                status = red::first_error(status, known->id, dag->add_edge(from.id, known->id));
            }
        }
    }
    if (!status) {
        return status;
    }
    const auto timing = red::Timing::sporadic(deadline->second).every(timer->period());
    const auto task = runtime_->add_task(*dag, bodies, timing);
    return runtime_->every(task, timer->period(), timer->period());
}
