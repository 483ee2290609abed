//! Nodes: ordinary ones and MIMONet stages with their parts.

use std::collections::HashSet;

use super::pool::Seen;
use super::{PlacedNode, UniqueNames, body};
use crate::error::{Fault, Refusal, shown};
use crate::model::{Node, Part, Pool, Stage, Work};
use crate::tree::{Field, Fields};

/// Keys of a node; the last only in events.
const NODE_KEYS: [&str; 11] =
    ["name", "after", "wcet", "bcet", "body", "pool", "memory", "atomic", "contention", "mimonet", "before"];

/// Keys of a decoder; an encoder has all but the first.
const PART_KEYS: [&str; 8] = ["name", "wcet", "bcet", "body", "pool", "memory", "atomic", "contention"];

/// Where a node is written.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Origin {
    /// In the task's table.
    Task,
    /// In an event's `add`, where `before` puts it in front of nodes that are there already.
    Event,
}

/// Reads one node. Its references stay names.
pub(super) fn read(item: Field<'_>, origin: Origin, pools: Seen<'_>) -> Result<PlacedNode, Fault> {
    let keys = match origin {
        Origin::Task => &NODE_KEYS[..NODE_KEYS.len() - 1],
        Origin::Event => &NODE_KEYS,
    };
    let fields = Fields::open(item.tree, "a node", keys)?;
    let name = fields.need("name")?;
    let (after, after_at) = references(fields.get("after"))?;
    let (before, before_at) = references(fields.get("before"))?;
    let traits = Traits::in_pool(pools.default()).overridden(&fields, pools)?;
    let work = fields.exactly_one(&["wcet", "mimonet"])?;
    let mut bodies_at = Vec::new();
    let work = match work.key {
        "wcet" => Work::Plain(part(&fields, traits, pools, &mut bodies_at)?),
        _ => {
            for key in ["bcet", "body"] {
                fields.refuse(key, "it in the stage's encoder and decoders")?;
            }
            Work::Stage(stage(work, traits, pools, &mut bodies_at)?)
        }
    };
    let node = Node { name: name.name()?.to_owned(), after, before, work };
    Ok(PlacedNode { at: name.at(), node, after_at, before_at, bodies_at })
}

/// Reads a list of names with their places.
pub(super) fn references(field: Option<Field<'_>>) -> Result<(Vec<String>, Vec<usize>), Fault> {
    let mut seen = HashSet::new();
    let (mut names, mut places) = (Vec::new(), Vec::new());
    if let Some(field) = field {
        for item in field.list()? {
            let name = item.text()?;
            if !seen.insert(name) {
                let problem = format!("`{}` names `{}` twice", field.key, shown(name));
                return Err(Fault::new(item.at(), Refusal::Duplicate, problem, "each name once"));
            }
            names.push(name.to_owned());
            places.push(item.at());
        }
    }
    Ok((names, places))
}

/// What a stage's node says for all of its parts, and a part may say for itself.
#[derive(Clone, Copy)]
struct Traits {
    pool: usize,
    memory_bytes: u64,
    atomic: bool,
    /// With its place: whether it may stand is known only at the part.
    contention: Option<(u64, usize)>,
}

impl Traits {
    fn in_pool(pool: usize) -> Self {
        Self { pool, memory_bytes: 0, atomic: false, contention: None }
    }

    fn overridden(self, fields: &Fields<'_>, pools: Seen<'_>) -> Result<Self, Fault> {
        let atomic = fields.get("atomic").map(|field| field.boolean()).transpose()?;
        let own = fields.get("contention").map(|field| Ok((field.time()?, field.at()))).transpose()?;
        // A part that says that it is not atomic also says that the stage's contention does not hold for it.
        let inherited = self.contention.filter(|_| atomic != Some(false));
        Ok(Self {
            pool: fields.get("pool").map_or(Ok(self.pool), |field| pools.find(field))?,
            memory_bytes: fields.get("memory").map_or(Ok(self.memory_bytes), |field| field.memory())?,
            atomic: atomic.unwrap_or(self.atomic),
            contention: own.or(inherited),
        })
    }
}

/// Reads what `traits` leaves open and checks the whole.
fn part(
    fields: &Fields<'_>,
    traits: Traits,
    pools: Seen<'_>,
    bodies_at: &mut Vec<usize>,
) -> Result<Part, Fault> {
    let wcet_ns = fields.need("wcet")?.time()?;
    let bcet_ns = fields.get("bcet").map_or(Ok(0), |field| field.time())?;
    if bcet_ns > wcet_ns {
        let problem = "`bcet` is above `wcet`";
        return Err(Fault::new(
            fields.place("bcet"),
            Refusal::Range,
            problem,
            "a best case up to the worst case",
        ));
    }
    if let Some((_, at)) = traits.contention.filter(|_| !traits.atomic) {
        let problem = "`contention` stands without `atomic = true`";
        return Err(Fault::new(at, Refusal::Conflict, problem, "`atomic = true`, or no `contention`"));
    }
    let body = body::read(fields.get("body"))?;
    bodies_at.push(fields.place("body"));
    let Traits { pool, memory_bytes, atomic, contention } = traits;
    let contention_ns = contention.map_or(0, |(time, _)| time);
    if let Some(budget) = pools.pool(pool).memory_bytes.filter(|budget| memory_bytes > *budget) {
        let problem = format!("this node needs {memory_bytes} bytes");
        let expected = budget_of(pools.pool(pool), budget);
        return Err(Fault::new(fields.place("memory"), Refusal::Memory, problem, expected));
    }
    Ok(Part { wcet_ns, bcet_ns, body, pool, memory_bytes, atomic, contention_ns })
}

fn stage(
    field: Field<'_>,
    traits: Traits,
    pools: Seen<'_>,
    bodies_at: &mut Vec<usize>,
) -> Result<Stage, Fault> {
    let fields = Fields::open(field.tree, "a stage", &["weights", "frame", "encoder", "decoders"])?;
    let weights = fields.need("weights")?.name()?.to_owned();
    let frame = fields.need("frame")?.name()?.to_owned();
    let encoder = Fields::open(fields.need("encoder")?.tree, "an encoder", &PART_KEYS[1..])?;
    let encoder = part(&encoder, traits.overridden(&encoder, pools)?, pools, bodies_at)?;
    let list = fields.need("decoders")?;
    let mut names = UniqueNames::of("decoder");
    let mut decoders = Vec::new();
    for item in list.list()? {
        let fields = Fields::open(item.tree, "a decoder", &PART_KEYS)?;
        let name = names.add(fields.need("name")?)?;
        if name == "encoder" {
            return Err(fields.need("name")?.fault(Refusal::Duplicate, "a name other than the encoder's"));
        }
        let decoder = part(&fields, traits.overridden(&fields, pools)?, pools, bodies_at)?;
        check_memory(&decoder, &encoder, pools, fields.place("memory"))?;
        decoders.push((name, decoder));
    }
    if decoders.is_empty() {
        return Err(list.fault(Refusal::Missing, "at least one decoder"));
    }
    Ok(Stage { weights, frame, encoder, decoders })
}

/// A decoder reads what its encoder wrote, so both are in memory at once.
fn check_memory(decoder: &Part, encoder: &Part, pools: Seen<'_>, at: usize) -> Result<(), Fault> {
    let pool = pools.pool(decoder.pool);
    let needed = u128::from(decoder.memory_bytes) + u128::from(encoder.memory_bytes);
    match pool.memory_bytes {
        Some(budget) if decoder.pool == encoder.pool && needed > budget.into() => {
            let problem = format!("this decoder and its encoder together need {needed} bytes");
            Err(Fault::new(at, Refusal::Memory, problem, budget_of(pool, budget)))
        }
        _ => Ok(()),
    }
}

fn budget_of(pool: &Pool, budget: u64) -> String {
    format!("at most the {budget} bytes of pool `{}`", pool.name)
}

#[cfg(test)]
mod tests;
