#!/usr/bin/env python3
"""Writes reference.json: what a second engine, onnxruntime, makes of two frames of the scene.

    python -m pip install -r reference-requirements.txt
    python reference.py

The frames are drawn by `cargo run -p red-bodies --example frames -- models`. Of each tensor the file holds the
Euclidean norm and 64 values at equal steps; the tests of red-bodies hold the engines of RED to them.
"""

import json
from pathlib import Path

import numpy as np
import onnxruntime

FOLDER = Path(__file__).parent
HEADS = ["lane", "segment", "detect", "control"]


def run(name, tensor):
    session = onnxruntime.InferenceSession(FOLDER / f"{name}.onnx", providers=["CPUExecutionProvider"])
    names = [output.name for output in session.get_outputs()]
    return dict(zip(names, session.run(names, {session.get_inputs()[0].name: tensor})))


def digest(tensor):
    flat = tensor.reshape(-1)
    samples = flat[:: max(1, flat.size // 64)][:64]
    return {"norm": float(np.linalg.norm(flat.astype(np.float64))), "samples": [float(f"{v:.7g}") for v in samples]}


def main():
    frames = []
    for frame, index, obstacle in [("frame-clear.rgb", 0, False), ("frame-obstacle.rgb", 25, True)]:
        pixels = np.frombuffer((FOLDER / frame).read_bytes(), np.uint8).astype(np.float32) / np.float32(255)
        image = pixels.reshape(1, 3, 96, 160)
        tensors = run("encoder", image)
        for head in HEADS:
            tensors |= run(head, tensors["feature"])
        for name, tensor in run("whole", image).items():
            np.testing.assert_allclose(tensor, tensors[name], rtol=1e-5, atol=1e-6)
        frames.append({"file": frame, "frame": index, "obstacle": obstacle,
                       "tensors": {name: digest(tensor) for name, tensor in tensors.items()}})
    with open(FOLDER / "reference.json", "w", encoding="utf-8") as file:
        json.dump({"engine": f"onnxruntime {onnxruntime.__version__}", "frames": frames}, file, indent=1)
        file.write("\n")


if __name__ == "__main__":
    main()
