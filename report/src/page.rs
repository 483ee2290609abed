//! The page: everything that it needs is in it.

use crate::bars;
use crate::chain_view;
use crate::escape::{html, script};
use crate::histogram;
use crate::lanes_data;
use crate::model::Run;
use crate::overview;
use crate::sections;
use std::fmt::Write;

pub use crate::bars::Compared;

const THEME: &str = include_str!("theme.css");
const TIMELINE: &str = include_str!("timeline.js");

/// What a page says beside its runs.
#[derive(Clone, Debug, Default)]
pub struct Head {
    /// Its title: the workload's file.
    pub title: String,
    /// What made it.
    pub program: String,
    /// A line below the title.
    pub about: String,
    /// What programs read: one JSON object.
    pub data: String,
    /// How to have it again.
    pub command: String,
}

/// The page of one run, or of several beside each other.
#[must_use]
pub fn of_runs(head: &Head, runs: &[Run], compared: &[Compared]) -> String {
    let mut body = String::new();
    let several = runs.len() > 1;
    if several {
        body.push_str("<section><h2>Beside each other</h2>");
        for run in runs {
            let _infallible = write!(
                body,
                "<p class=\"lead\"><b>{}</b>: {}</p>",
                html(&upper(run)),
                sections::verdict(run)
            );
        }
        body.push_str(&bars::section(compared));
        body.push_str("</section>");
    }
    for (number, run) in runs.iter().enumerate() {
        of_run(&mut body, run, number, several);
    }
    document(head, &body, TIMELINE)
}

fn upper(run: &Run) -> String {
    run.policy.to_uppercase()
}

fn of_run(body: &mut String, run: &Run, number: usize, several: bool) {
    let _infallible = write!(body, "<section class=\"run\" id=\"run-{number}\">");
    if several {
        let _infallible = write!(body, "<h2>{}</h2>", html(&upper(run)));
    }
    let _infallible = write!(body, "<p class=\"lead\">{}</p>", sections::verdict(run));
    body.push_str(&sections::tiles(run));
    body.push_str(&sections::tasks(run));
    body.push_str("<h3>Timeline</h3>");
    timeline(body, run, number);
    body.push_str("<h3>Response times</h3><p class=\"note\">From release to end, of jobs that completed. Heights are roots of \
                   counts, so that a single late job can be seen.</p><div class=\"hists\">");
    run.tasks.iter().for_each(|task| body.push_str(&histogram::figure(task)));
    body.push_str("</div><h3>Misses and their causes</h3>");
    body.push_str(&chain_view::section(run));
    if !run.certificate.is_empty() {
        body.push_str("<h3>What admission says</h3>");
        body.push_str(&sections::certificate(run));
    }
    body.push_str("<h3>Facts</h3>");
    body.push_str(&sections::facts(run));
    body.push_str("</section>");
}

fn timeline(body: &mut String, run: &Run, number: usize) {
    let (data, is_whole) = lanes_data::json(run);
    let _infallible = write!(
        body,
        "<figure class=\"timeline\" data-run=\"{number}\">{}<div class=\"tools\"><button type=\"button\" data-do=\"in\" \
         aria-label=\"zoom in\">+</button><button type=\"button\" data-do=\"out\" aria-label=\"zoom out\">−</button>\
         <button type=\"button\" data-do=\"all\">whole run</button><button type=\"button\" data-do=\"previous\">◂ miss</button>\
         <button type=\"button\" data-do=\"next\">miss ▸</button><output></output></div><canvas tabindex=\"0\" role=\"img\" \
         aria-label=\"Timeline: lanes above, jobs below. Arrow keys move it, plus and minus zoom, n and p go to the next and the \
         previous miss; the tables of this page say the same.\"></canvas><div class=\"tip\" role=\"status\"></div>{}\
         <noscript><p class=\"note\">The drawing above is the whole run. With scripts allowed, a timeline to zoom stands here; all \
         tables are complete without it.</p></noscript>{}{}<script type=\"application/json\">{data}</script></figure>",
        overview::figure(run),
        LEGEND,
        sections::edits(run),
        sections::standstills(run),
    );
    if !is_whole {
        body.push_str("<p class=\"note\">The run has more executions than the timeline draws: it has those around its first \
                       window. The drawing of the whole run and all numbers have them all.</p>");
    }
}

const LEGEND: &str = "<ul class=\"keys lanes\"><li><i class=\"k-slice\"></i>a node on a lane, coloured by task</li>\
    <li><i class=\"k-shared\"></i>encoders that share one execution</li><li><i class=\"k-hit\"></i>encoder that took a result</li>\
    <li><i class=\"k-due\"></i>sub-deadline of a node, deadline of a job below the lanes</li><li><i class=\"k-subdeadline\"></i>beyond the sub-deadline</li>\
    <li><i class=\"k-late\"></i>job beyond its deadline</li><li><i class=\"k-edit\"></i>graph edit</li></ul>";

/// A whole document around a body.
pub(crate) fn document(head: &Head, body: &str, code: &str) -> String {
    let Head { title, program, about, data, command } = head;
    let title = html(title);
    let mut out = format!(
        "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"/>\n<meta name=\"viewport\" \
         content=\"width=device-width, initial-scale=1\"/>\n<meta name=\"color-scheme\" content=\"light dark\"/>\n\
         <meta name=\"generator\" content=\"{}\"/>\n<title>{title}</title>\n<style>\n{THEME}</style></head>\n<body><header>\
         <p class=\"mark\">redrt</p><h1>{title}</h1><p class=\"about\">{}</p></header>\n<main>",
        html(program),
        html(about)
    );
    out.push_str(body);
    let _infallible = write!(
        out,
        "</main>\n<footer><p>Made by {} with <code>{}</code>. Programs find every number in the script element \
         <code>redrt-data</code>.</p></footer>\n<script type=\"application/json\" id=\"redrt-data\">{}</script>\n",
        html(program),
        html(command),
        script(data)
    );
    if !code.is_empty() {
        let _infallible = write!(out, "<script>\n{code}</script>\n");
    }
    out.push_str("</body></html>\n");
    out
}

#[cfg(test)]
mod tests;
