// Config: how a scheduler decides.
#ifndef RED_CONFIG_HPP
#define RED_CONFIG_HPP

#include "values.hpp"
#include "words.hpp"

namespace red {

/// How a scheduler decides: one of the named configurations, changed as you like. A value that cannot be is the status of
/// the call that opens a scheduler with it.
class Config {
public:
    /// redrt().
    Config() noexcept : Config(RED_PRESET_REDRT) {}
    /// The paper's baseline: unrefined graphs, one deadline per job, and nothing else.
    [[nodiscard]] static Config edf() noexcept { return Config(RED_PRESET_EDF); }
    /// The paper's RED-FG: refined, level shares, level barrier.
    [[nodiscard]] static Config red_fg() noexcept { return Config(RED_PRESET_RED_FG); }
    /// The paper's RED-IDA: RED-FG with re-assignment at each dispatch.
    [[nodiscard]] static Config red_ida() noexcept { return Config(RED_PRESET_RED_IDA); }
    /// The paper's RED: RED-IDA with merging, on-demand synchronisation and ProactiveDrop.
    [[nodiscard]] static Config red() noexcept { return Config(RED_PRESET_RED); }
    /// Ours: latest-start keys, precedence gating, merging, frame cache, hopeless-first shedding.
    [[nodiscard]] static Config redrt() noexcept { return Config(RED_PRESET_REDRT); }
    /// Ours, with lanes that wait for what is soon ready where nothing is preempted.
    [[nodiscard]] static Config redrt_lookahead() noexcept { return Config(RED_PRESET_REDRT_LOOKAHEAD); }

    /// Lanes of the first pool; 1 unless told.
    Config &lanes(std::uint32_t count) noexcept { return c_.lanes = count, *this; }
    /// Memory budget of the first pool in bytes; unlimited unless told.
    Config &memory(std::uint64_t bytes) noexcept { return c_.memory_bytes = bytes, *this; }
    Config &rule(Rule rule) noexcept { return c_.rule = number(rule), *this; }
    Config &gate(Gate gate) noexcept { return c_.gate = number(gate), *this; }
    Config &reassign(Reassign when) noexcept { return c_.reassign = number(when), *this; }
    /// Whether stages are to be refined into encoder and decoders; the host builds its graphs by it.
    Config &refine(bool yes) noexcept { return c_.refine = yes, *this; }
    /// Encoders of a frame become one unit if their releases are at most so far apart.
    Config &merge(Duration skew) noexcept { return set(c_.merge_skew_ns, skew); }
    Config &no_merge() noexcept { return c_.merge_skew_ns = RED_NONE_64, *this; }
    /// Whether encoder results are shared beyond their unit.
    Config &frame_cache(bool yes) noexcept { return c_.frame_cache = yes, *this; }
    Config &shedding(Shedding which) noexcept { return c_.shed = number(which), *this; }
    Config &late(Late late) noexcept { return c_.late = number(late), *this; }
    Config &best_case(BestCase from) noexcept { return c_.best_case = number(from), *this; }
    Config &admission(Admission admission) noexcept { return c_.admission = number(admission), *this; }
    /// Whether a waiting node takes the lane of a running one with a larger key.
    Config &preempt(bool yes) noexcept { return c_.preempt = yes, *this; }
    /// Busy share of all lanes in one tick that is overload, in millionths.
    Config &overload_utilisation(std::uint32_t ppm) noexcept { return c_.overload_utilisation_ppm = ppm, *this; }
    /// Ready sub-jobs above which it is overload.
    Config &overload_queue(std::uint16_t sub_jobs) noexcept { return c_.overload_queue = sub_jobs, *this; }
    /// Consecutive ticks until overload is lasting.
    Config &overload_ticks(std::uint8_t ticks) noexcept { return c_.overload_ticks = ticks, *this; }
    Config &overload_tick(Duration length) noexcept { return set(c_.overload_tick_ns, length); }

    [[nodiscard]] Status status() const noexcept { return status_; }
    /// All fields, as the C interface has them.
    [[nodiscard]] const red_config &c() const noexcept { return c_; }

private:
    friend class Scheduler;
    explicit Config(red_preset preset) noexcept {
        c_.struct_size = sizeof c_;
        c_.abi_version = RED_ABI_VERSION;
        status_ = red_config_preset(preset, &c_);
    }
    template <class Word>
    static constexpr std::uint32_t number(Word word) noexcept {
        return static_cast<std::uint32_t>(word);
    }
    Config &set(std::uint64_t &field, Duration given) noexcept {
        field = given.ns();
        status_ = first_error(status_, given);
        return *this;
    }

    red_config c_{};
    Status status_{};
};

} // namespace red

#endif
