/* The firmware: every tick it tells the scheduler what happened and carries out what it answers. It ends with status 0 only
 * if everything was as it should be. */
#include "board.h"
#include "scene.h"

/* Frames of one run. */
#define FRAMES 30

static _Alignas(RED_ALIGN) unsigned char memory[RED_SCHEDULER_4X16X16_BYTES];

/* What a lane runs, until when. */
static struct {
    uint64_t unit;
    uint32_t until;
    bool is_busy;
} lanes[LANES];

static struct {
    uint32_t frames, ended, on_time, encoders, refused;
} seen;
static uint32_t tasks[2];

static void check(red_status status) {
    if (status != RED_OK) {
        seen.refused++;
        print(red_status_text(status));
        print("\n");
    }
}

static void start(red_scheduler *scheduler, const red_action *action, uint32_t now) {
    red_unit unit = RED_UNIT_INIT;
    check(red_scheduler_unit(scheduler, action->unit, &unit));
    const uint32_t task = unit.first.task == tasks[0] ? 0 : 1, node = unit.first.node;
    seen.encoders += task == 0 ? node == 1 : node == 0;
    lanes[action->lane].unit = action->unit;
    lanes[action->lane].until = now + takes_ms(task, node);
    lanes[action->lane].is_busy = true;
}

/* One tick: what happened, then what is to be done. */
static void step(red_scheduler *scheduler, uint32_t now) {
    const uint64_t now_ns = now * MS;
    for (int i = 0; i < LANES; i++) {
        if (!lanes[i].is_busy || lanes[i].until > now) continue;
        lanes[i].is_busy = false;
        check(red_scheduler_complete(scheduler, lanes[i].unit, now_ns));
    }
    if (now % PERIOD_MS == 0 && seen.frames < FRAMES) {
        seen.frames++;
        uint32_t job = 0;
        for (int i = 0; i < 2; i++) check(red_scheduler_release(scheduler, tasks[i], now_ns, &job));
    }
    for (;;) {
        red_action action;
        const red_status status = red_scheduler_poll(scheduler, now_ns, &action);
        check(status);
        if (status != RED_OK || action.kind == RED_ACTION_KIND_NOTHING) return;
        if (action.kind == RED_ACTION_KIND_DISPATCH) start(scheduler, &action, now);
        if (action.kind == RED_ACTION_KIND_ENDED) {
            seen.ended++;
            seen.on_time += action.outcome.shed == RED_SHED_NOT && action.outcome.at_ns <= action.outcome.deadline_ns;
        }
    }
}

static bool row(const char *what, uint32_t found, uint32_t expected) {
    print(what);
    print_number(found, 6);
    print(" of ");
    print_number(expected, 6);
    print(found == expected ? "\n" : "  WRONG\n");
    return found == expected;
}

int main(void) {
    red_config config = RED_CONFIG_INIT;
    check(red_config_preset(RED_PRESET_REDRT, &config));
    config.lanes = 2;
    red_scheduler scheduler = {0};
    check(red_scheduler_open_4x16x16(memory, sizeof memory, &config, &scheduler));
    /* A mistake to be found: nothing can be shared. */
    check(add_scene(&scheduler, was_told("other-frame"), tasks));

    start_ticks();
    uint32_t done = 0;
    step(&scheduler, 0);
    while (done < (FRAMES + 2) * PERIOD_MS) {
        sleep_until_interrupt();
        /* Every tick has its turn, if one took long too. */
        while (done < ticks()) step(&scheduler, ++done);
    }

    red_figures figures = RED_FIGURES_INIT;
    check(red_scheduler_figures(&scheduler, &figures));
    check(red_scheduler_close(&scheduler));
    bool is_right = true;
    is_right &= row("frames                ", seen.frames, FRAMES);
    is_right &= row("jobs ended            ", seen.ended, 2 * FRAMES);
    is_right &= row("jobs on time          ", seen.on_time, 2 * FRAMES);
    is_right &= row("encoders run          ", seen.encoders, FRAMES);
    is_right &= row("encoder runs saved    ", (uint32_t)figures.encoder_runs_saved, FRAMES);
    is_right &= row("units                 ", (uint32_t)figures.units, (NODES - 1) * FRAMES);
    is_right &= row("overruns              ", (uint32_t)figures.overruns, 0);
    is_right &= row("clock steps back      ", (uint32_t)figures.clock_steps_back, 0);
    is_right &= row("calls refused         ", seen.refused, 0);
    print("stack                 ");
    print_number(stack_used(), 6);
    print(" of ");
    print_number(stack_size(), 6);
    print(" bytes\n");
    return is_right ? 0 : 1;
}
