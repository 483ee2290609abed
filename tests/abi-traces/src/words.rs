//! Words of the trace: the core's own names, which whoever comes through the C ABI finds for the numbers of the header.

use std::fmt::{Debug, Display};

use red_core::{Bound, Certificate, Config, EventKind, ShedReason};

/// What a call answered, or its error by name.
pub(crate) fn answer<T: Display, E: Debug>(answer: Result<T, E>) -> String {
    match answer {
        Ok(value) => format!("= {value}"),
        Err(error) => format!("! {error:?}"),
    }
}

pub(crate) fn or_none(number: Option<u64>) -> String {
    number.map_or_else(|| "-".to_owned(), |number| number.to_string())
}

pub(crate) fn config(c: &Config) -> String {
    let memory = or_none(c.memory.map(|memory| memory.0));
    let skew = or_none(c.merge_skew.map(red_core::Duration::as_nanos));
    let over = &c.overload;
    format!(
        "{} {memory} {:?} {:?} {:?} {} {skew} {} {:?} {:?} {:?} {} {} {} {} {:?} {}",
        c.lanes,
        c.rule,
        c.gate,
        c.reassign,
        u8::from(c.refine),
        u8::from(c.frame_cache),
        c.shed,
        c.late,
        c.best_case,
        over.utilisation.0,
        over.queue,
        over.ticks,
        over.tick.as_nanos(),
        c.admission,
        u8::from(c.preempt),
    )
}

pub(crate) fn certificate(c: &Certificate) -> String {
    let bound = match c.bound {
        Bound::LongPath { paths } => format!("LongPath {paths}"),
        other => format!("{other:?} 0"),
    };
    let (work, path, response) = (c.work.as_nanos(), c.critical_path.as_nanos(), c.response.as_nanos());
    let (fits, holds) = (u8::from(c.fits()), u8::from(c.memory_holds));
    let (limit, margin) = (c.limit.as_nanos(), c.margin().as_nanos());
    format!("{bound} {} {fits} {holds} {work} {path} {response} {limit} {margin}", c.lanes)
}

/// Why a job was given up, or that it was not.
pub(crate) fn shed(reason: Option<ShedReason>) -> &'static str {
    reason.map_or("done", ShedReason::name)
}

pub(crate) fn event(kind: EventKind) -> String {
    match kind {
        EventKind::Shed(reason) => format!("Shed {}", reason.name()),
        other => format!("{other:?}"),
    }
}
