//! What kernels compute, against the CPU.

use crate::{Bench, Failure, Figures};
use red_cuda::{Arguments, Buffer, CudaError, Kernel, Pinned, Stream};

const ROAD: &str = include_str!("../../../examples/kernels/road.ptx");

/// Numbers of an image, and rounds over each.
const NUMBERS: usize = 46_080;
const ROUNDS: u32 = 100;
const THREADS: u32 = 256;

/// A kernel of the obstacle scene with memory of its own.
struct Network {
    kernel: Kernel,
    arguments: Arguments,
    /// On the host and on the device.
    input: (Pinned, Buffer),
    output: (Pinned, Buffer),
}

impl Network {
    fn new(bench: &Bench) -> Result<Self, Failure> {
        let Bench { device, .. } = bench;
        let place = || Ok::<_, CudaError>((device.pinned(NUMBERS * 4)?, device.buffer(NUMBERS * 4)?));
        let (input, output) = (place()?, place()?);
        let grid = [(NUMBERS as u32).div_ceil(THREADS), 1, 1];
        let kernel = device.module(ROAD.as_bytes())?.kernel(c"encode", grid, [THREADS, 1, 1])?;
        let mut arguments = Arguments::new(4);
        let bits = [input.1.address(), output.1.address(), NUMBERS as u64, ROUNDS.into()];
        (0..4).for_each(|at| arguments.set(at, bits[at]));
        Ok(Self { kernel, arguments, input, output })
    }

    /// Sets what the next run reads.
    fn show(&mut self, image: &[f32]) {
        for (place, value) in self.input.0.bytes_mut().chunks_exact_mut(4).zip(image) {
            place.copy_from_slice(&value.to_ne_bytes());
        }
    }

    fn submit(&mut self, stream: &Stream) -> Result<(), CudaError> {
        stream.upload(&self.input.0, &self.input.1)?;
        stream.launch(&self.kernel, &mut self.arguments)?;
        stream.download(&self.output.1, &mut self.output.0)
    }

    /// How many of the numbers that came back are not those of the CPU.
    fn wrong(&self, image: &[f32]) -> usize {
        let same = |(bytes, value): (&[u8], &f32)| bytes == rounds(*value).to_ne_bytes();
        self.output.0.bytes().chunks_exact(4).zip(image).filter(|pair| !same(*pair)).count()
    }
}

/// What the kernel makes of a number.
fn rounds(value: f32) -> f32 {
    let (factor, more) = (f32::from_bits(0x3F7F_FF00), f32::from_bits(0x3A00_0000));
    (0..ROUNDS).fold(value, |value, _| value.mul_add(factor, more))
}

fn image(number: u32) -> Vec<f32> {
    (0..NUMBERS as u32).map(|place| (place * 7 + number) as f32 / 1e4).collect()
}

fn judged(wrong: usize) -> Result<usize, Failure> {
    if wrong == 0 {
        Ok(NUMBERS)
    } else {
        Err(format!("{wrong} of {NUMBERS} numbers are not what the CPU computes").into())
    }
}

pub(crate) fn kernel(bench: &Bench) -> Result<Figures, Failure> {
    let mut network = Network::new(bench)?;
    network.show(&image(1));
    let stream = bench.device.stream(0)?;
    network.submit(&stream)?;
    bench.device.synchronize()?;
    Ok(vec![format!("{} numbers are the same", judged(network.wrong(&image(1)))?)])
}

pub(crate) fn graph(bench: &Bench) -> Result<Figures, Failure> {
    let mut network = Network::new(bench)?;
    let stream = bench.device.stream(0)?;
    let graph = stream.capture(|stream| network.submit(stream))?;
    let mut compared = 0;
    for number in 2..5 {
        network.show(&image(number));
        stream.launch_graph(&graph)?;
        bench.device.synchronize()?;
        compared += judged(network.wrong(&image(number)))?;
    }
    Ok(vec![format!("{compared} numbers of three launches are the same")])
}
