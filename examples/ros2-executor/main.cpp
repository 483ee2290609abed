// A camera, two networks and control as nodes of rclcpp, spun by the executor of RED. Prints latencies and misses.
#include "red_executor.hpp"

#include <algorithm>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <thread>
#include <time.h>

using namespace std::chrono_literals;

namespace {

struct Image {
    int number;
};
struct Found {
    int number;
};

RedExecutor *to_cancel;

void on_interrupt(int) { to_cancel->cancel(); }

/// Stands in for work.
void burn(std::chrono::nanoseconds length) {
    const auto cpu_time = [] {
        timespec now{};
        clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
        return std::chrono::seconds(now.tv_sec) + std::chrono::nanoseconds(now.tv_nsec);
    };
    const auto until = cpu_time() + length;
    while (cpu_time() < until) {
    }
}

double ms(std::chrono::nanoseconds time) { return static_cast<double>(time.count()) / 1e6; }

} // namespace

int main(int count, char **words) {
    bool best_effort = false;
    int seconds = 2;
    for (int i = 1; i < count; i++) {
        best_effort |= std::strcmp(words[i], "--best-effort") == 0;
        if (std::strcmp(words[i], "--seconds") == 0 && i + 1 < count) {
            seconds = std::max(1, std::atoi(words[i + 1]));
        }
    }
    const auto camera = std::make_shared<rclcpp::Node>("camera"), lane = std::make_shared<rclcpp::Node>("lane");
    const auto detect = std::make_shared<rclcpp::Node>("detect"), control = std::make_shared<rclcpp::Node>("control");
    const auto images = camera->create_publisher<Image>("image", 1);
    const auto lanes = lane->create_publisher<Found>("lanes", 1);
    const auto objects = detect->create_publisher<Found>("objects", 1);
    int frames = 0, steered = 0;
    const auto timer = camera->create_wall_timer(33ms, [&] {
        burn(300us);
        images->publish({frames++});
    });
    const auto a = lane->create_subscription<Image>("image", 1, [&](std::shared_ptr<const Image> image) {
        burn(3ms);
        lanes->publish({image->number});
    });
    const auto b = detect->create_subscription<Image>("image", 1, [&](std::shared_ptr<const Image> image) {
        burn(4ms);
        objects->publish({image->number});
    });
    // Two subscriptions of one node: its group keeps their callbacks apart.
    const auto c = control->create_subscription<Found>("lanes", 1, [&](std::shared_ptr<const Found>) {
        burn(200us);
        steered++;
    });
    const auto d = control->create_subscription<Found>("objects", 1, [&](std::shared_ptr<const Found>) {
        burn(200us);
        steered++;
    });

    RedTable table;
    table.wcets = {{"camera", 500us}, {"lane", 4ms}, {"detect", 5ms}, {"control", 300us}};
    table.deadlines = {{"camera", 33ms}};
    const auto config = best_effort ? red::RuntimeConfig::best_effort() : red::RuntimeConfig::real_time();
    RedExecutor executor(table, red::Config::redrt().lanes(1), red::RuntimeConfig(config).duration(std::chrono::seconds(seconds)));
    to_cancel = &executor;
    std::signal(SIGINT, on_interrupt);
    for (const auto &node : {camera, lane, detect, control}) {
        executor.add_node(node);
    }
    executor.spin();
    if (!executor.status().ok()) {
        std::fprintf(stderr, "%s\n", executor.message().c_str());
        return executor.status() == RED_STATUS_NOT_PERMITTED ? 3 : 1;
    }

    std::vector<std::chrono::nanoseconds> latencies;
    for (const auto &outcome : executor.take_outcomes()) {
        if (outcome.completed()) {
            latencies.push_back(outcome.response());
        }
    }
    const auto report = executor.report();
    if (!report || latencies.empty()) {
        std::fprintf(stderr, "no chain came to its end\n");
        return 1;
    }
    std::sort(latencies.begin(), latencies.end());
    const auto real_time = report->ending() && report->ending()->real_time();
    std::printf("%s\n", real_time ? "real time" : "best effort: no promise");
    std::printf("chains %llu  on time %llu  missed %llu  callbacks of control %d\n",
        static_cast<unsigned long long>(report->released()), static_cast<unsigned long long>(report->on_time()),
        static_cast<unsigned long long>(report->missed()), steered);
    std::printf("tick to last callback: median %.3f ms, p99 %.3f ms, max %.3f ms\n", ms(latencies[latencies.size() / 2]),
        ms(latencies[latencies.size() * 99 / 100]), ms(latencies.back()));
    return 0;
}
