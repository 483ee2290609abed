// A stand-in for the few parts of rclcpp that the executor touches; not ROS 2. Names and shapes are rclcpp's.
#ifndef STAND_IN_RCLCPP_HPP
#define STAND_IN_RCLCPP_HPP

#include <any>
#include <atomic>
#include <chrono>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

namespace rclcpp {

enum class CallbackGroupType { MutuallyExclusive, Reentrant };

/// Callbacks of a mutually exclusive group do not overlap.
class CallbackGroup {
public:
    using SharedPtr = std::shared_ptr<CallbackGroup>;
    explicit CallbackGroup(CallbackGroupType type) : type_(type) {}
    CallbackGroupType type() const { return type_; }
    std::mutex &turn() { return turn_; }

private:
    CallbackGroupType type_;
    std::mutex turn_;
};

/// A callback that waits for messages of a topic. The newest message counts.
class SubscriptionBase {
public:
    using SharedPtr = std::shared_ptr<SubscriptionBase>;
    SubscriptionBase(std::string topic, CallbackGroup::SharedPtr group) : topic_(std::move(topic)), group_(std::move(group)) {}
    virtual ~SubscriptionBase() = default;
    const std::string &get_topic_name() const { return topic_; }
    const CallbackGroup::SharedPtr &get_callback_group() const { return group_; }
    /// Hands the newest message to the callback; nothing where there is none.
    virtual void execute() = 0;
    virtual void offer(const std::any &message) = 0;

private:
    std::string topic_;
    CallbackGroup::SharedPtr group_;
};

template <class Message>
class Subscription : public SubscriptionBase {
public:
    using Callback = std::function<void(std::shared_ptr<const Message>)>;
    Subscription(std::string topic, CallbackGroup::SharedPtr group, Callback callback)
        : SubscriptionBase(std::move(topic), std::move(group)), callback_(std::move(callback)) {}

    void offer(const std::any &message) override {
        const std::lock_guard lock(mutex_);
        newest_ = std::any_cast<std::shared_ptr<const Message>>(message);
    }
    void execute() override {
        std::shared_ptr<const Message> taken;
        {
            const std::lock_guard lock(mutex_);
            taken.swap(newest_);
        }
        if (taken) {
            callback_(std::move(taken));
        }
    }

private:
    Callback callback_;
    std::mutex mutex_;
    std::shared_ptr<const Message> newest_;
};

/// A callback that the clock calls.
class TimerBase {
public:
    using SharedPtr = std::shared_ptr<TimerBase>;
    TimerBase(std::chrono::nanoseconds period, CallbackGroup::SharedPtr group, std::function<void()> callback)
        : period_(period), group_(std::move(group)), callback_(std::move(callback)) {}
    std::chrono::nanoseconds period() const { return period_; }
    const CallbackGroup::SharedPtr &get_callback_group() const { return group_; }
    void execute_callback() { callback_(); }

private:
    std::chrono::nanoseconds period_;
    CallbackGroup::SharedPtr group_;
    std::function<void()> callback_;
};

/// Which subscriptions a topic reaches, in this process.
using Topics = std::map<std::string, std::vector<std::weak_ptr<SubscriptionBase>>>;

template <class Message>
class Publisher {
public:
    using SharedPtr = std::shared_ptr<Publisher>;
    Publisher(std::shared_ptr<Topics> topics, std::string topic) : topics_(std::move(topics)), topic_(std::move(topic)) {}
    void publish(Message message) {
        const std::any any = std::shared_ptr<const Message>(std::make_shared<const Message>(std::move(message)));
        for (const auto &to : (*topics_)[topic_]) {
            if (const auto subscription = to.lock()) {
                subscription->offer(any);
            }
        }
    }

private:
    std::shared_ptr<Topics> topics_;
    std::string topic_;
};

/// All nodes of the process share their topics. Publishers and subscriptions are made before the executor spins.
class Node {
public:
    using SharedPtr = std::shared_ptr<Node>;
    explicit Node(std::string name) : name_(std::move(name)) {}
    const std::string &get_name() const { return name_; }

    CallbackGroup::SharedPtr create_callback_group(CallbackGroupType type) { return std::make_shared<CallbackGroup>(type); }
    template <class Message>
    std::shared_ptr<Publisher<Message>> create_publisher(const std::string &topic, int /* depth */) {
        published_.push_back(topic);
        (*topics())[topic];
        return std::make_shared<Publisher<Message>>(topics(), topic);
    }
    template <class Message, class Callback>
    std::shared_ptr<Subscription<Message>> create_subscription(
        const std::string &topic, int /* depth */, Callback callback, CallbackGroup::SharedPtr group = nullptr) {
        auto made = std::make_shared<Subscription<Message>>(topic, group ? group : group_, std::move(callback));
        (*topics())[topic].push_back(made);
        subscriptions_.push_back(made);
        return made;
    }
    template <class Callback>
    TimerBase::SharedPtr create_wall_timer(
        std::chrono::nanoseconds period, Callback callback, CallbackGroup::SharedPtr group = nullptr) {
        timers_.push_back(std::make_shared<TimerBase>(period, group ? group : group_, std::move(callback)));
        return timers_.back();
    }

    const std::vector<TimerBase::SharedPtr> &timers() const { return timers_; }
    const std::vector<SubscriptionBase::SharedPtr> &subscriptions() const { return subscriptions_; }
    /// Topics that it publishes.
    const std::vector<std::string> &published() const { return published_; }

private:
    static const std::shared_ptr<Topics> &topics() {
        static const auto all = std::make_shared<Topics>();
        return all;
    }

    std::string name_;
    CallbackGroup::SharedPtr group_ = std::make_shared<CallbackGroup>(CallbackGroupType::MutuallyExclusive);
    std::vector<TimerBase::SharedPtr> timers_;
    std::vector<SubscriptionBase::SharedPtr> subscriptions_;
    std::vector<std::string> published_;
};

class Executor {
public:
    virtual ~Executor() = default;
    virtual void add_node(std::shared_ptr<Node> node) = 0;
    /// Until cancel.
    virtual void spin() = 0;
    virtual void cancel() = 0;
};

} // namespace rclcpp

#endif
