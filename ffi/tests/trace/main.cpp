// Drives the workloads of a file through the C ABI and writes what it answered: the same text as `red-abi-traces traces`,
// byte for byte.
//
// usage: trace FILE [last-lane-first | drop-release]
//
// The second word is a mistake that a comparison has to find.

#include <cstdio>
#include <cstring>
#include <fstream>

#include "host.hpp"

void Host::happen(const Event &e) {
    const std::size_t first = static_cast<std::size_t>(e.first);
    const std::uint32_t lane = static_cast<std::uint32_t>(e.first);
    const std::string number = std::to_string(e.first) + " ";
    if (e.word == "admit") {
        admit(first);
    } else if (e.word == "release") {
        release(first, e.second, e.third);
    } else if (e.word == "remove") {
        red_status status = red_scheduler_remove_task(&scheduler, tasks[first].task, now);
        line("remove " + number + yes_or_no(status, RED_STATUS_UNKNOWN_TASK));
    } else if (e.word == "begin") {
        begin(first, static_cast<std::size_t>(e.second));
    } else if (e.word == "change") {
        Graph &edit = *edits[first];
        line("change " + number + (edit.is_open() ? edit.take(e.step) : "none"));
    } else if (e.word == "commit") {
        commit(first);
    } else if (e.word == "drop") {
        edits[first]->close();
        line("drop " + std::to_string(e.first));
    } else if (e.word == "retire") {
        line("retire " + number + yes_or_no(red_scheduler_retire_lane(&scheduler, lane), RED_STATUS_UNKNOWN_LANE));
    } else if (e.word == "restore") {
        line("restore " + number + yes_or_no(red_scheduler_restore_lane(&scheduler, lane), RED_STATUS_UNKNOWN_LANE));
    } else if (e.word == "stray") {
        stray(e.first, static_cast<std::uint32_t>(e.second));
    } else if (e.word == "back") {
        poll(now > e.first ? now - e.first : 0);
    } else if (e.word == "take") {
        take();
    } else {
        give_up("no such event: " + e.word);
    }
}

void Host::admit(std::size_t task) {
    Graph graph(of);
    graph.open();
    for (const Step &step : w.tasks[task].steps) line("make " + graph.take(step));
    const red_timing &timing = w.tasks[task].timing;
    text += graph.ask(w.config.rule, timing.deadline_ns, lanes, budgets);
    std::uint32_t id = 0;
    red_status status = red_scheduler_add_task(&scheduler, &graph.dag, &timing, &id);
    line("admit " + std::to_string(task) + " " + answer(status, std::to_string(id)));
    if (status != RED_OK) return;
    tasks[task] = {id, 0};
    red_certificate proof = RED_CERTIFICATE_INIT;
    need(red_scheduler_certificate(&scheduler, id, &proof), "a certificate");
    line("proof " + words_of(proof));
}

void Host::release(std::size_t task, std::uint64_t at, std::uint64_t capture) {
    if (mistake == Mistake::drop_release && ++releases == 3) return;
    Known &known = tasks[task];
    std::uint32_t job = 0;
    red_status status = at == now && capture == RED_NONE_64
                            ? red_scheduler_release(&scheduler, known.task, now, &job)
                            : red_scheduler_release_at(&scheduler, known.task, at, capture, now, &job);
    std::uint64_t index = known.released++;
    line("release " + std::to_string(task) + " " + answer(status, std::to_string(job)));
    status = red_scheduler_job(&scheduler, known.task, index, &job);
    line("job " + std::to_string(index) + " " + answer(status, std::to_string(job)));
}

void Host::begin(std::size_t place, std::size_t task) {
    Graph &edit = *edits[place];
    edit.close();
    red_status status =
        red_scheduler_edit(&scheduler, tasks[task].task, edit.memory->at, edit.memory->bytes, &edit.dag);
    line("begin " + std::to_string(place) + " " + std::to_string(task) + " " +
         yes_or_no(status, RED_STATUS_UNKNOWN_TASK));
}

void Host::commit(std::size_t place) {
    Graph &edit = *edits[place];
    std::string told = "none";
    if (edit.is_open()) {
        red_certificate proof = RED_CERTIFICATE_INIT;
        red_status status = red_scheduler_commit(&scheduler, &edit.dag, now, &proof);
        told = answer(status, words_of(proof));
        edit.close();
    }
    line("commit " + std::to_string(place) + " " + told);
}

void Host::stray(std::uint64_t unit, std::uint32_t task) {
    red_unit data = RED_UNIT_INIT;
    std::string completed = "runs";
    // What lanes run is not reported by strangers.
    if (red_scheduler_unit(&scheduler, unit, &data) != RED_OK)
        completed = answer(red_scheduler_complete(&scheduler, unit, now), "ok");
    std::uint32_t job = 0;
    red_status status = red_scheduler_release(&scheduler, task, now, &job);
    std::string released = answer(status, std::to_string(job));
    status = red_scheduler_job(&scheduler, task, unit, &job);
    line("stray " + completed + " " + released + " " + answer(status, std::to_string(job)));
}

void Host::take() {
    red_outcome outcome{};
    std::uint32_t count = 0;
    need(red_scheduler_take_outcome(&scheduler, &outcome, &count), "an outcome");
    if (count == 1) {
        ended(outcome);
    } else {
        line("no outcome");
    }
}

static const Class &class_of(const std::string &size) {
    for (const Class &one : CLASSES)
        if (size == one.size) return one;
    give_up("no such class: " + size);
}

int main(int count, char **words) {
    Mistake mistake = Mistake::none;
    if (count == 3 && std::strcmp(words[2], "last-lane-first") == 0) mistake = Mistake::last_lane_first;
    if (count == 3 && std::strcmp(words[2], "drop-release") == 0) mistake = Mistake::drop_release;
    if (count < 2 || count > 3 || (count == 3 && mistake == Mistake::none))
        give_up("usage: trace FILE [last-lane-first | drop-release]");
    std::ifstream file(words[1]);
    if (!file) give_up(std::string(words[1]) + " cannot be read");
    Reader reader(file);
    Workload workload;
    while (reader.next(workload)) {
        Host host(workload, class_of(workload.size), mistake);
        std::string text = host.run();
        if (std::fwrite(text.data(), 1, text.size(), stdout) != text.size()) return 1;
    }
    return std::fflush(stdout) == 0 ? 0 : 1;
}
