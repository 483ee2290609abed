//! Bodies: what `redrt run` executes for a node.

use std::path::{Component, Path};
use std::str::FromStr;

use crate::error::{Fault, Refusal};
use crate::model::{Argument, Body};
use crate::tree::{Field, Fields};

/// Arguments of a CUDA kernel: CUDA passes at most 4 KiB of them.
const MAX_KERNEL_ARGUMENTS: usize = 512;

/// Reads a body; an absent one is none.
pub(super) fn read(field: Option<Field<'_>>) -> Result<Body, Fault> {
    let Some(field) = field else {
        return Ok(Body::None);
    };
    let fields = Fields::open(field.tree, "a body", &["spin", "onnx", "plugin", "symbol", "cuda", "graph"])?;
    let kind = fields.exactly_one(&["spin", "onnx", "plugin", "cuda"])?;
    if kind.key != "plugin" {
        fields.refuse("symbol", "a `symbol` only beside `plugin`")?;
    }
    if !matches!(kind.key, "plugin" | "cuda") {
        fields.refuse("graph", "a `graph` only beside `plugin` or `cuda`")?;
    }
    let graph = fields.get("graph").map(|field| field.boolean()).transpose()?.unwrap_or_default();
    match kind.key {
        "spin" => Ok(Body::Spin { duration_ns: kind.time()? }),
        "onnx" => Ok(Body::Onnx { path: path(kind)? }),
        "plugin" => Ok(Body::Plugin { path: path(kind)?, symbol: symbol(fields.need("symbol")?)?, graph }),
        _ => cuda(kind, graph),
    }
}

fn cuda(field: Field<'_>, graph: bool) -> Result<Body, Fault> {
    let fields = Fields::open(field.tree, "a CUDA body", &["module", "kernel", "grid", "block", "args"])?;
    Ok(Body::Cuda {
        module: path(fields.need("module")?)?,
        kernel: symbol(fields.need("kernel")?)?,
        grid: dimensions(fields.need("grid")?)?,
        block: dimensions(fields.need("block")?)?,
        args: fields.get("args").map(arguments).transpose()?.unwrap_or_default(),
        graph,
    })
}

/// One to three extents; those left out are 1.
fn dimensions(field: Field<'_>) -> Result<[u32; 3], Fault> {
    let items = field.list()?;
    if !(1..=3).contains(&items.len()) {
        return Err(field.fault(Refusal::Range, "a list of one to three integers"));
    }
    let mut extents = [1; 3];
    for (extent, item) in extents.iter_mut().zip(items) {
        *extent = item.count(1..=u32::MAX)?;
    }
    Ok(extents)
}

fn arguments(field: Field<'_>) -> Result<Vec<Argument>, Fault> {
    let items = field.list()?;
    if items.len() > MAX_KERNEL_ARGUMENTS {
        return Err(field.fault(Refusal::Limit, format!("at most {MAX_KERNEL_ARGUMENTS} arguments")));
    }
    let arguments: Vec<_> = items.map(argument).collect::<Result<_, _>>()?;
    if arguments.iter().filter(|argument| matches!(argument, Argument::Result(_))).count() > 1 {
        return Err(field.fault(Refusal::Conflict, "one `result` at most"));
    }
    Ok(arguments)
}

fn argument(item: Field<'_>) -> Result<Argument, Fault> {
    const KINDS: [&str; 6] = ["f32", "f64", "input", "output", "scratch", "result"];
    if !item.is_table() {
        let expected = "an integer, { f32 = \"0.5\" }, { f64 = \"0.5\" }, or memory as { input = \"4KiB\" }";
        let integer = item.integer().map_err(|_| item.fault(Refusal::Type, expected))?;
        return Ok(Argument::Number(integer.cast_unsigned()));
    }
    let fields = Fields::open(item.tree, "a kernel's argument", &KINDS)?;
    let kind = fields.exactly_one(&KINDS)?;
    match kind.key {
        "f32" => return float(kind, f32::is_finite).map(|value| Argument::Number(value.to_bits().into())),
        "f64" => return float(kind, f64::is_finite).map(|value| Argument::Number(value.to_bits())),
        _ => {}
    }
    let bytes = kind.memory()?;
    if bytes == 0 {
        return Err(kind.fault(Refusal::Range, "at least one byte"));
    }
    Ok(match kind.key {
        "input" => Argument::Input(bytes),
        "output" => Argument::Output(bytes),
        "scratch" => Argument::Scratch(bytes),
        _ => Argument::Result(bytes),
    })
}

/// A number with a point, in a text: the nearest that the type has.
fn float<F: FromStr + Copy>(field: Field<'_>, is_finite: fn(F) -> bool) -> Result<F, Fault> {
    let value = field.text()?.parse().ok().filter(|value| is_finite(*value));
    value.ok_or_else(|| field.fault(Refusal::Range, "a finite number such as \"0.5\" or \"-1e-3\""))
}

/// A path that stays in the workload file's folder: whoever starts a workload trusts that folder, not the disk.
fn path(field: Field<'_>) -> Result<String, Fault> {
    let path = field.text()?;
    let stays = |component| matches!(component, Component::Normal(_) | Component::CurDir);
    let is_allowed = Path::new(path).file_name().is_some() && Path::new(path).components().all(stays);
    if is_allowed && !path.contains('\0') {
        return Ok(path.to_owned());
    }
    Err(field.fault(Refusal::Path, "a file in or below the folder of the workload file, without `..`"))
}

/// A name in an object file; C++ and Rust mangle with these characters too.
fn symbol(field: Field<'_>) -> Result<String, Fault> {
    let name = field.text()?;
    if !name.is_empty() && name.bytes().all(|byte| byte.is_ascii_graphic()) {
        return Ok(name.to_owned());
    }
    Err(field.fault(Refusal::Name, "the name of a function as the object file has it"))
}

#[cfg(test)]
mod tests;
