use crate::Refusal::{Conflict, Missing, Name, Path, Quantity, Range, Type, UnknownKey};
use crate::fixtures::{accepted, refused, with_nodes};
use crate::model::{Argument, Body, Work};

#[test]
fn bodies_stay_in_their_folder_and_are_complete() {
    let cuda = "cuda = { module = 'k.ptx', kernel = 'step', grid = [4, 2], block = [128], args = [-1, { f32 = '0.5' }, { f64 = '-1e-3' }, { input = '4KiB' }, { result = '1B' }] }";
    let node = |body: &str| format!("{{ name = 'a', wcet = '1ms', body = {{ {body} }} }}");
    let read = |body: &str| match accepted(&with_nodes(&node(body), "")).tasks.remove(0).nodes.remove(0).work
    {
        Work::Plain(part) => part.body,
        Work::Stage(_) => panic!("an ordinary node was written"),
    };
    let (module, kernel) = ("k.ptx".to_owned(), "step".to_owned());
    let numbers = [u64::MAX, 0x3F00_0000, 0xBF50_624D_D2F1_A9FC].map(Argument::Number);
    let args = [&numbers[..], &[Argument::Input(4096), Argument::Result(1)]].concat();
    let expected = Body::Cuda { module, kernel, grid: [4, 2, 1], block: [128, 1, 1], args, graph: false };
    assert_eq!(read(cuda), expected);
    assert_eq!(read("onnx = './m/a.onnx'"), Body::Onnx { path: "./m/a.onnx".to_owned() });
    let cases = [
        ("", Missing, "none of `spin`, `onnx`, `plugin`, `cuda`"),
        ("spin = '1ms', onnx = 'a'", Conflict, "both `spin` and `onnx`"),
        ("spin = '1ms', symbol = 'a'", Conflict, "`symbol`"),
        ("spin = 1", Quantity, "unit"),
        ("plugin = 'a.so'", Missing, "no `symbol`"),
        ("plugin = 'a.so', symbol = ''", Name, "function"),
        ("plugin = 'a.so', symbol = 'a b'", Name, "function"),
        ("plugin = '/usr/lib/a.so', symbol = 'f'", Path, "without `..`"),
        ("plugin = '../a.so', symbol = 'f'", Path, "without `..`"),
        ("onnx = 'm/../../a'", Path, "without `..`"),
        ("onnx = '..'", Path, "without `..`"),
        ("onnx = ''", Path, "without `..`"),
        ("onnx = '.'", Path, "without `..`"),
        ("onnx = \"a\\u0000b\"", Path, "a\\0b"),
        ("spn = '1ms'", UnknownKey, "did you mean `spin`?"),
        (&cuda.replace("k.ptx", "/k.ptx"), Path, "without `..`"),
        (&cuda.replace("[4, 2]", "[]"), Range, "one to three"),
        (&cuda.replace("[4, 2]", "[0]"), Range, "from 1"),
        (&cuda.replace("[128]", "[1, 1, 1, 1]"), Range, "one to three"),
        (&cuda.replace("[-1,", "[1.5,"), Type, "{ f32 = "),
        (&cuda.replace("'0.5'", "0.5"), Type, "text"),
        (&cuda.replace("'0.5'", "'1e39'"), Range, "a finite number"),
        (&cuda.replace("'-1e-3'", "'a half'"), Range, "a finite number"),
        (&cuda.replace("4KiB", "0B"), Range, "at least one byte"),
        (&cuda.replace("input", "result"), Conflict, "one `result` at most"),
        (&cuda.replace("input", "imput"), UnknownKey, "did you mean `input`?"),
        (
            &cuda.replace("input = '4KiB'", "input = '4KiB', output = '1B'"),
            Conflict,
            "both `input` and `output`",
        ),
        (&cuda.replace("kernel = 'step', ", ""), Missing, "no `kernel`"),
    ];
    for (body, refusal, words) in cases {
        let error = refused(&with_nodes(&node(body), ""));
        assert_eq!(error.refusal, refusal, "{body}: {error}");
        assert!(error.to_string().contains(words), "{body}: {error}");
    }
}
