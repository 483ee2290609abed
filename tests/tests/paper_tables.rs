//! Tables of the paper against its text, against each other, and against arithmetic: sections 5 and 6.

/// The tardiness in seconds that a score has, where e^lambda multiplies it.
fn tardiness_s(score: f64, lambda: f64) -> f64 {
    (1.0 / score - 1.0) / lambda.exp()
}

fn percent(ours: f64, theirs: f64) -> f64 {
    100.0 * (ours / theirs - 1.0)
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

/// Table "variant deadline", in milliseconds.
const EDF: [f64; 6] = [5_869.0, 6_807.0, 6_865.0, 7_760.0, 8_737.0, 9_694.0];
const FG: [f64; 6] = [5_883.0, 6_006.0, 6_803.0, 7_856.0, 8_723.0, 9_688.0];
const IDA: [f64; 6] = [4_950.0, 4_929.0, 6_691.0, 7_465.0, 8_313.0, 9_045.0];
const RED: [f64; 6] = [4_455.0, 4_435.0, 4_456.0, 4_500.0, 5_930.0, 6_779.0];

#[test]
fn scores_are_of_end_to_end_tardiness_in_seconds() {
    // RED-FG on Nano, Table "variant lambda": four columns, one tardiness.
    let found = [(0.248, 0.001), (0.246, 0.01), (0.230, 0.1), (0.108, 1.0)].map(|(q, l)| tardiness_s(q, l));
    assert!(found.iter().all(|x| (x / 3.03 - 1.0).abs() < 0.01), "{found:?}");
    // With the exponent that the name "exponential distribution" suggests there would be four.
    let exponent = [(0.248_f64, 0.001_f64), (0.108, 1.0)].map(|(q, l)| (1.0 / q - 1.0).ln() / l);
    assert!(exponent[0] > 100.0 * exponent[1]);
}

#[test]
fn the_text_gives_other_percentages_than_its_table() {
    // Section 5.4: RED is 23.2, 20.1 and 17.1 % faster than EDF, RED-IDA and RED-FG.
    let table = [EDF, IDA, FG]
        .map(|theirs| mean(&RED.iter().zip(theirs).map(|(r, t)| percent(*r, t)).collect::<Vec<_>>()));
    assert!(
        table.iter().zip([-33.0, -24.5, -31.6]).all(|(found, known)| (found - known).abs() < 0.1),
        "{table:?}"
    );
    assert!(
        table[1] > table[2],
        "and RED-IDA is the better of the two, which the text has the other way round"
    );
}

#[test]
fn edf_slows_down_as_the_deadline_loosens() {
    // No work-conserving scheduler of one pipeline does.
    assert!(EDF.windows(2).all(|pair| pair[0] < pair[1]) && percent(EDF[5], EDF[0]) > 65.0);
}

#[test]
fn half_of_edfs_runs_are_on_time_for_a_deadline_below_its_mean() {
    // AGX Orin, urban, Table "extended": three scores give one budget, 17 s; EDF takes 27.90 s and misses 0.52.
    let budgets =
        [(27.90, 0.08), (27.94, 0.08), (24.65, 0.11)].map(|(latency, q)| latency - tardiness_s(q, 0.05));
    assert!(budgets.iter().all(|budget| (budget - 17.0).abs() < 0.06), "{budgets:?}");
    let (on_time, rest) = (0.48, 0.52);
    let longest_of_rest = (27.90 - on_time * 17.0) / rest;
    assert!(longest_of_rest > 37.0, "the others would take 38 s, a third more than any mean in that table");
}

#[test]
fn costs_of_tasks_are_below_zero_on_the_macbook() {
    // EDF runs one task after the other: urban L + O + S + O + C, emergency O + L + S + C, night 3 C.
    let (urban, emergency, night) = (7.76, 3.45, 1.44);
    let (control, detect) = (night / 3.0, urban - emergency);
    assert!(emergency - detect - control < 0.0, "L and S together");
}

#[test]
fn one_experiment_has_two_results() {
    // Obstacle-free, EDF: no burst (Table "burst") and nothing indivisible (Table "non-partitionable") are the same runs.
    for (platform, burst, partitionable) in
        [("Nano Orin", 48.83, 41.77), ("AGX Orin", 31.60, 26.59), ("Mac", 6.58, 5.64)]
    {
        assert!(percent(burst, partitionable) > 16.0, "{platform}");
    }
    let (three_tasks, five_tasks) = (41.77, 32.24);
    assert!(
        percent(three_tasks, five_tasks) > 0.0,
        "Nano Orin: obstacle-free takes longer than urban navigation"
    );
}

#[test]
fn the_encoder_is_not_heavy_by_the_papers_flops() {
    let apart = 4.111 + 2.655 + 0.465 + 0.283;
    let (together, others) = (6.704, 3.0);
    let encoder = (apart - together) / others;
    assert!(encoder < 0.28 && others * encoder / apart < 0.109, "at most 10.8 % of the work can be shared");
}

#[test]
fn half_of_the_latency_is_more_than_a_stage_can_share() {
    // Urban on AGX Orin, L = S = 1, O = 1.055, C = 0.82: two stages of two calls save two encoders.
    let all = 1.0 + 1.055 + 1.0 + 1.055 + 0.82;
    let encoder = all * (1.0 - 14.24 / 27.90) / 2.0;
    assert!(encoder > 1.2, "an encoder would have to take longer than the task that it is part of");
}

#[test]
fn red_is_not_the_fastest_in_every_scenario() {
    let [edf, fg, ida, red] = [13.96, 14.00, 11.35, 12.25];
    assert!(percent(red, ida) > 7.0 && percent(fg, edf) > 0.0, "night driving on AGX Orin");
}

#[test]
fn fine_grained_refinement_is_below_edf_where_the_text_has_it_above() {
    // Table "variant lambda", lambda 1: EDF and RED-FG.
    let pairs = [("Nano", 0.113, 0.108), ("Xavier", 0.616, 0.295), ("Orin", 0.954, 0.931)];
    assert!(
        pairs.iter().all(|(_, edf, fg)| fg < edf),
        "three of four, and the text says seven of eight above"
    );
}
