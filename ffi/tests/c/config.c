/* Versions, sizes, presets; structs that are of another version, and fields that cannot be. */
#include "calls.h"

#include <string.h>

static struct {
    _Alignas(RED_ALIGN) unsigned char bytes[RED_SCHEDULER_16X256X64_BYTES];
} memory;

static void versions_and_sizes(void) {
    CALLED(red_abi_version);
    EXPECT(red_abi_version() == RED_ABI_VERSION);
    CALLED(red_version);
    EXPECT(strcmp(red_version(), "0.1.0") == 0);
    CALLED(red_align);
    EXPECT(red_align() > 0 && RED_ALIGN % red_align() == 0);
    CALLED(red_scheduler_bytes_4x16x16);
    CALLED(red_scheduler_bytes_8x64x32);
    CALLED(red_scheduler_bytes_16x256x64);
    EXPECT(red_scheduler_bytes_4x16x16() <= RED_SCHEDULER_4X16X16_BYTES);
    EXPECT(red_scheduler_bytes_8x64x32() <= RED_SCHEDULER_8X64X32_BYTES);
    EXPECT(red_scheduler_bytes_16x256x64() <= RED_SCHEDULER_16X256X64_BYTES);
    CALLED(red_status_text);
    EXPECT(strcmp(red_status_text(RED_OK), "done") == 0);
    EXPECT(strcmp(red_status_text(-1), "no status of this library") == 0);
    EXPECT(strcmp(red_status_text(INT32_MAX), red_status_text(-1)) == 0);
}

static void presets(void) {
    for (uint32_t which = RED_PRESET_EDF; which <= RED_PRESET_REDRT_LOOKAHEAD; which++) EXPECT(preset(which).lanes == 1);
    EXPECT(preset(RED_PRESET_EDF).rule == RED_RULE_END_TO_END);
    EXPECT(preset(RED_PRESET_RED_FG).gate == RED_GATE_LEVEL);
    EXPECT(preset(RED_PRESET_REDRT_LOOKAHEAD).gate == RED_GATE_LOOKAHEAD);
    EXPECT(preset(RED_PRESET_RED_IDA).reassign == RED_REASSIGN_ON_DISPATCH);
    EXPECT(preset(RED_PRESET_RED).shed == RED_SHEDDING_LOWEST_URGENCY);
    EXPECT(preset(RED_PRESET_REDRT).frame_cache == 1 && preset(RED_PRESET_REDRT).memory_bytes == RED_NONE_64);
    red_config config = RED_CONFIG_INIT;
    CALL(RED_STATUS_OUT_OF_RANGE, red_config_preset, RED_PRESET_REDRT_LOOKAHEAD + 1, &config);
    EXPECT(config.lanes == 0);
}

static void heads(void) {
    red_config config = RED_CONFIG_INIT;
    config.struct_size = 8;
    CALL(RED_STATUS_STRUCT_SIZE, red_config_preset, RED_PRESET_EDF, &config);
    config.struct_size = sizeof config + 1;
    CALL(RED_STATUS_STRUCT_SIZE, red_config_preset, RED_PRESET_EDF, &config);
    config.struct_size = sizeof config;
    config.abi_version++;
    CALL(RED_STATUS_VERSION, red_config_preset, RED_PRESET_EDF, &config);

    /* A header that is newer than the library: its struct is longer. What it has beyond is zero, or refused. */
    struct {
        red_config known;
        uint64_t added;
    } newer = {.known = preset(RED_PRESET_REDRT), .added = 0};
    newer.known.struct_size = sizeof newer;
    red_scheduler scheduler = {0};
    CALL(RED_OK, red_scheduler_open_4x16x16, &memory, sizeof memory, &newer.known, &scheduler);
    CALL(RED_OK, red_scheduler_close, &scheduler);
    newer.added = 1;
    CALL(RED_STATUS_UNKNOWN_FIELD, red_scheduler_open_4x16x16, &memory, sizeof memory, &newer.known, &scheduler);
    /* As an output it is written to its end. */
    CALL(RED_OK, red_config_preset, RED_PRESET_EDF, &newer.known);
    EXPECT(newer.added == 0 && newer.known.struct_size == sizeof newer);
}

static void refused(red_status status, red_config config) {
    red_scheduler scheduler = {0};
    CALL(status, red_scheduler_open_4x16x16, &memory, sizeof memory, &config, &scheduler);
    CALL(status, red_scheduler_open_8x64x32, &memory, sizeof memory, &config, &scheduler);
    CALL(status, red_scheduler_open_16x256x64, &memory, sizeof memory, &config, &scheduler);
    EXPECT(scheduler.bits == 0);
}

#define REFUSED(status, field, wrong) \
    do { \
        red_config config = preset(RED_PRESET_REDRT); \
        config.field = wrong; \
        refused(status, config); \
    } while (0)

static void fields(void) {
    REFUSED(RED_STATUS_NO_LANE, lanes, 0);
    REFUSED(RED_STATUS_POOLS_FULL, lanes, 33);
    REFUSED(RED_STATUS_OUT_OF_RANGE, rule, RED_RULE_LATEST_START + 1);
    REFUSED(RED_STATUS_OUT_OF_RANGE, gate, RED_GATE_LOOKAHEAD + 1);
    REFUSED(RED_STATUS_OUT_OF_RANGE, reassign, RED_REASSIGN_ON_CHANGE + 1);
    REFUSED(RED_STATUS_OUT_OF_RANGE, refine, 2);
    REFUSED(RED_STATUS_OUT_OF_RANGE, frame_cache, 2);
    REFUSED(RED_STATUS_OUT_OF_RANGE, shed, RED_SHEDDING_HOPELESS + 1);
    REFUSED(RED_STATUS_OUT_OF_RANGE, late, RED_LATE_ABORT_JOB + 1);
    REFUSED(RED_STATUS_OUT_OF_RANGE, best_case, RED_BEST_CASE_DECLARED + 1);
    REFUSED(RED_STATUS_OUT_OF_RANGE, admission, RED_ADMISSION_ENFORCE + 1);
    REFUSED(RED_STATUS_OUT_OF_RANGE, preempt, 2);
    REFUSED(RED_STATUS_OUT_OF_RANGE, overload_queue, 65536);
    REFUSED(RED_STATUS_OUT_OF_RANGE, overload_ticks, 256);
    REFUSED(RED_STATUS_OUT_OF_RANGE, overload_tick_ns, 0);
}

void test_config(void) {
    versions_and_sizes();
    presets();
    heads();
    fields();
}
