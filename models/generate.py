#!/usr/bin/env python3
"""Writes the demo's MIMONet: one shared encoder and four heads, and all five as one graph.

    python -m pip install -r requirements.txt
    python generate.py            # writes the .onnx files beside this script
    python generate.py --check    # exit 1 when a committed file differs from what this script makes

The shapes follow ENet (segment), U-Net (lane), YOLO (detect) and PilotNet (control) at a fraction of their
width. The weights are fixed pseudo-random numbers: the work is that of real convolution networks, the answers
mean nothing. They come from the raw stream of PCG64, which numpy never changes, so the files are the same bytes
on every machine.
"""

import sys
import zlib
from pathlib import Path

import numpy as np
from onnx import TensorProto, checker, helper, numpy_helper

HEIGHT, WIDTH = 96, 160
FEATURES = 40
IMAGE = ("image", [1, 3, HEIGHT, WIDTH])
FEATURE = ("feature", [1, FEATURES, HEIGHT // 8, WIDTH // 8])


class Part:
    """A piece of the network: its nodes, its weights, and the shape of every tensor as it is built."""

    def __init__(self, name, source):
        self.name, self.source = name, source
        self.nodes, self.weights, self.shapes = [], [], {source[0]: source[1][1:]}
        self.result = None

    def weight(self, name, *shape, fan_in):
        """Uniform weights of variance 2 / fan_in (He), which keeps activations of one size at any depth."""
        raw = np.random.PCG64(zlib.crc32(name.encode())).random_raw(int(np.prod(shape)))
        unit = (raw >> np.uint64(40)).astype(np.float64) / 2**23 - 1.0
        self.constant(name, (unit * np.sqrt(6.0 / fan_in)).astype(np.float32).reshape(shape))

    def constant(self, name, array):
        self.weights.append(numpy_helper.from_array(array, name))

    def node(self, operator, inputs, name, shape, **attributes):
        self.nodes.append(helper.make_node(operator, inputs, [name], name=name, **attributes))
        self.shapes[name] = shape
        return name

    def conv(self, x, name, channels, kernel=3, stride=1, dilation=1, relu=True):
        name = f"{self.name}.{name}"
        c, h, w = self.shapes[x]
        self.weight(f"{name}.weight", channels, c, kernel, kernel, fan_in=c * kernel * kernel)
        self.constant(f"{name}.bias", np.zeros(channels, np.float32))
        y = self.node("Conv", [x, f"{name}.weight", f"{name}.bias"], name, [channels, h // stride, w // stride],
                      kernel_shape=[kernel] * 2, strides=[stride] * 2, dilations=[dilation] * 2,
                      pads=[dilation * (kernel // 2)] * 4)
        return self.relu(y) if relu else y

    def upconv(self, x, name, channels):
        name = f"{self.name}.{name}"
        c, h, w = self.shapes[x]
        self.weight(f"{name}.weight", c, channels, 2, 2, fan_in=c)
        self.constant(f"{name}.bias", np.zeros(channels, np.float32))
        return self.node("ConvTranspose", [x, f"{name}.weight", f"{name}.bias"], name, [channels, 2 * h, 2 * w],
                         kernel_shape=[2, 2], strides=[2, 2])

    def relu(self, x):
        return self.node("Relu", [x], f"{x}.relu", self.shapes[x])

    def add(self, a, b):
        return self.relu(self.node("Add", [a, b], f"{b}.sum", self.shapes[a]))

    def concat(self, a, b):
        (ca, h, w), (cb, _, _) = self.shapes[a], self.shapes[b]
        return self.node("Concat", [a, b], f"{a}.concat", [ca + cb, h, w], axis=1)

    def dense(self, x, name, inputs, outputs):
        name = f"{self.name}.{name}"
        self.weight(f"{name}.weight", outputs, inputs, fan_in=inputs)
        self.constant(f"{name}.bias", np.zeros(outputs, np.float32))
        return self.node("Gemm", [x, f"{name}.weight", f"{name}.bias"], name, [outputs], transB=1)

    def finish(self, operator, x, result):
        self.node(operator, [x], result, self.shapes[x])
        self.result = (result, [1] + self.shapes[x])
        return self


def encoder():
    """Three strides down to an eighth of the frame, with a residual block at the two lower scales."""
    p = Part("encoder", IMAGE)
    x = p.conv("image", "stem", 16, stride=2)
    x = p.conv(x, "low", 24)
    x = p.conv(x, "down4", 32, stride=2)
    x = p.add(x, p.conv(p.conv(x, "mid1", 32), "mid2", 32, relu=False))
    x = p.conv(x, "down8", FEATURES, stride=2)
    y = p.conv(p.conv(x, "high1", FEATURES), "high2", FEATURES, relu=False)
    return p.finish("Relu", p.node("Add", [x, y], "encoder.high.sum", p.shapes[x]), "feature")


def segment():
    """ENet: bottlenecks of growing dilation, then transposed convolutions up to half of the frame."""
    p = Part("segment", FEATURE)
    x = "feature"
    for dilation in (1, 2, 4):
        y = p.conv(x, f"narrow{dilation}", 16, kernel=1)
        y = p.conv(y, f"dilated{dilation}", 16, dilation=dilation)
        x = p.add(x, p.conv(y, f"widen{dilation}", FEATURES, kernel=1, relu=False))
    x = p.relu(p.upconv(x, "up4", 24))
    x = p.conv(x, "refine4", 24)
    return p.finish("Identity", p.upconv(x, "up2", 4), "segment")


def lane():
    """U-Net: one level down and up again with a skip connection, then up to half of the frame."""
    p = Part("lane", FEATURE)
    skip = p.conv("feature", "skip", 24)
    x = p.conv(skip, "down16", 32, stride=2)
    x = p.concat(p.relu(p.upconv(x, "up8", 24)), skip)
    x = p.conv(x, "join8", 24)
    x = p.conv(p.relu(p.upconv(x, "up4", 16)), "refine4", 16)
    return p.finish("Sigmoid", p.upconv(x, "up2", 2), "lane")


def detect():
    """YOLO: 3 anchors of box, objectness and 2 classes in every cell of the feature map."""
    p = Part("detect", FEATURE)
    x = p.conv("feature", "trunk1", FEATURES)
    x = p.conv(p.conv(x, "squeeze", 24, kernel=1), "expand", FEATURES)
    return p.finish("Sigmoid", p.conv(x, "boxes", 3 * (4 + 1 + 2), kernel=1, relu=False), "detect")


def control():
    """PilotNet: strided convolutions, then dense layers down to steering, throttle and brake."""
    p = Part("control", FEATURE)
    x = p.conv("feature", "conv1", 24)
    x = p.conv(x, "conv2", 24, stride=2)
    x = p.conv(x, "conv3", 16, stride=2)
    x = p.node("Flatten", [x], "control.flat", [int(np.prod(p.shapes[x]))])
    x = p.relu(p.dense(x, "dense1", p.shapes[x][0], 32))
    return p.finish("Tanh", p.dense(x, "dense2", 32, 3), "control")


def model(name, source, parts, results):
    value = lambda tensor: helper.make_tensor_value_info(tensor[0], TensorProto.FLOAT, tensor[1])
    graph = helper.make_graph([n for p in parts for n in p.nodes], name, [value(source)], [value(r) for r in results],
                              [w for p in parts for w in p.weights])
    proto = helper.make_model(graph, opset_imports=[helper.make_opsetid("", 13)], ir_version=8, producer_name="red")
    checker.check_model(proto, full_check=True)
    return proto.SerializeToString(deterministic=True)


def files():
    body, heads = encoder(), [lane(), segment(), detect(), control()]
    made = {f"{p.name}.onnx": model(p.name, p.source, [p], [p.result]) for p in [body, *heads]}
    made["whole.onnx"] = model("whole", IMAGE, [body, *heads], [p.result for p in heads])
    return made


def main():
    folder = Path(__file__).parent
    made = files()
    if sys.argv[1:] == ["--check"]:
        stale = [name for name, data in made.items() if not (folder / name).exists() or (folder / name).read_bytes() != data]
        sys.exit(f"differs from generate.py: {', '.join(stale)}; run models/generate.py" if stale else 0)
    for name, data in made.items():
        (folder / name).write_bytes(data)
        print(f"{name:14} {len(data):8} bytes")


if __name__ == "__main__":
    main()
