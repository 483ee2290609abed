use crate::Refusal::{DuplicateKey, Nesting, Quantity, Range, Syntax, Type, UnknownKey};
use crate::fixtures::{EXAMPLE_TOML, HEAD, refused, refused_as, with_nodes};
use crate::{Format, Place, Refusal};

fn refused_yaml(text: &str) -> crate::LoadError {
    refused_as(text.as_bytes(), Format::Yaml)
}

#[test]
fn broken_toml_is_refused_at_its_place() {
    let cases: [(&str, Refusal, (u32, u32)); 8] = [
        ("[[pool]]\nname = gpu\n", Syntax, (2, 8)),
        ("[[pool]]\nname \"gpu\"\n", Syntax, (2, 6)),
        ("[[pool]]\nname = \"gpu\"\nname = \"cpu\"\n", DuplicateKey, (3, 1)),
        ("[[pool]]\nname = \"gp", Syntax, (2, 11)),
        ("[[pool]\n", Syntax, (1, 8)),
        ("pool = [\n  { name = \"gpu\"", Syntax, (2, 17)),
        ("[pool]\nname = \"gpu\"\n", Type, (1, 1)),
        ("[[pool]]\nnmae = \"gpu\"\n", UnknownKey, (2, 1)),
    ];
    for (text, refusal, (line, column)) in cases {
        let error = refused(text);
        assert_eq!((error.refusal, error.place), (refusal, Some(Place { line, column })), "{text}: {error}");
    }
}

#[test]
fn broken_yaml_is_refused_at_its_place() {
    let cases: [(&str, Refusal, (u32, u32)); 15] = [
        ("pool:\n  - name: gpu\n    name: cpu\n", DuplicateKey, (3, 5)),
        ("pool:\n  - nmae: gpu\n", UnknownKey, (2, 5)),
        ("pool:\n  - name: [gpu\n", Syntax, (2, 11)),
        ("pool:\n  - name: \"gpu\n", Syntax, (3, 1)),
        ("pool:\n  - name: gpu\n   lanes: 2\n", Syntax, (3, 4)),
        ("pool:\n\t- name: gpu\n", Syntax, (2, 2)),
        ("pool: gpu\n", Type, (1, 7)),
        ("- pool\n", Type, (1, 1)),
        ("pool\n", Type, (1, 1)),
        ("pool: &p\n  - name: gpu\n", Syntax, (2, 3)),
        ("pool: *p\n", Syntax, (1, 7)),
        ("pool: !!seq []\n", Syntax, (1, 13)),
        ("[pool]: []\n", Syntax, (1, 1)),
        ("pool: []\n---\npool: []\n", Syntax, (3, 1)),
        ("pool:\n  - {name: 7, lanes: 1}\n", Type, (2, 12)),
    ];
    for (text, refusal, (line, column)) in cases {
        let error = refused_yaml(text);
        assert_eq!((error.refusal, error.place), (refusal, Some(Place { line, column })), "{text}: {error}");
    }
}

#[test]
fn a_plain_yaml_scalar_has_the_type_of_the_core_schema() {
    let pool = |lanes: &str| format!("pool:\n  - {{name: a, lanes: {lanes}}}\n");
    for integer in ["0", "-1", "0x21", "0o41", "33", "99999999999999999999"] {
        let error = refused_yaml(&pool(integer));
        assert!(matches!(error.refusal, Range | Refusal::Limit), "{integer}: {error}");
    }
    for other in ["1.0", "1e3", ".nan", "-.inf", "true", "~", "", "null", "two", "\"2\"", "1_0", "0x", "[1]"]
    {
        assert_eq!(refused_yaml(&pool(other)).refusal, Type, "{other}");
    }
    let memory = |memory: &str| format!("pool:\n  - {{name: a, lanes: 1, memory: {memory}}}\n");
    for unitless in ["5", "-5", "1.5", ".inf", "true", "1.5MiB", "-1B", "nan"] {
        assert_eq!(refused_yaml(&memory(unitless)).refusal, Quantity, "{unitless}");
    }
}

#[test]
fn numbers_of_the_wrong_kind_are_refused() {
    let value = |value: &str| refused(&format!("{HEAD}value = {value}\n")).refusal;
    for (text, refusal) in [
        ("-1", Range),
        ("4294967296", Range),
        ("1.5", Type),
        ("nan", Type),
        ("-inf", Type),
        ("1e400", Type),
        ("\"1\"", Type),
        ("true", Type),
        ("1979-05-27", Type),
        ("[1]", Type),
    ] {
        assert_eq!(value(text), refusal, "{text}");
    }
    assert_eq!(value(&"9".repeat(1_000_000)), Range);
}

#[test]
fn the_unknown_key_that_comes_first_is_told() {
    let error = refused("zebra = 1\nanother = 2\n");
    assert!(error.problem.contains("zebra"), "{error}");
    let error = refused(&with_nodes("{ name = 'a', wcet = '1ms', before = ['b'] }", ""));
    assert_eq!(error.refusal, UnknownKey, "`before` belongs to events: {error}");
}

#[test]
fn a_misspelt_header_is_told_before_what_it_makes_of_the_others() {
    let task = |head: &str| format!("[[{head}]]\nname = 't'\ndeadline = '1s'\nonce = true\n");
    let node = "[[task.node]]\nname = 'a'\nwcet = '1ms'\n";
    let pool = "[[pool]]\nname = 'p'\nlanes = 1\n";
    for text in [
        format!("{pool}{}{node}{}{node}", task("Task"), task("task")),
        format!("{pool}{}{node}{}{node}", task("tasks"), task("task")),
        format!("{pool}{}{node}{}{node}", task("task"), task("Task")),
    ] {
        let error = refused(&text);
        assert_eq!(
            (error.refusal, error.nearest.as_ref().map(|near| near.name.as_str())),
            (UnknownKey, Some("task")),
            "{error}"
        );
    }
    let error = refused(&format!("{pool}{node}{}", task("task")));
    assert_eq!(error.refusal, DuplicateKey, "{error}");
}

#[test]
fn deep_nesting_is_refused_before_it_costs_anything() {
    let deep = 100_000;
    let toml = [
        format!("pool = {}", "[".repeat(deep)),
        format!("pool = {}{}", "[".repeat(deep), "]".repeat(deep)),
        format!("pool = {}", "{a=".repeat(deep)),
        format!("{}a = 1", "a.".repeat(deep)),
        format!("[{}a]", "a.".repeat(deep)),
        format!("pool = [{{ {}a = 1 }}]", "a.".repeat(deep)),
    ];
    for text in toml {
        assert_eq!(refused(&text).refusal, Nesting);
    }
    let blocks: String = (0..1_000).map(|depth| format!("{}a:\n", " ".repeat(depth))).collect();
    let yaml = [
        format!("pool: {}", "[".repeat(deep)),
        format!("pool: {}", "{a: ".repeat(deep)),
        format!("pool: {}", "- ".repeat(deep)),
        "- ".repeat(deep),
        "? ".repeat(deep),
        blocks,
    ];
    for text in yaml {
        let error = refused_yaml(&text);
        assert!(matches!(error.refusal, Nesting | Syntax), "{error}");
    }
    let in_strings = EXAMPLE_TOML.replacen('#', &format!("# {} \"", "[".repeat(deep)), 1);
    assert!(crate::parse(in_strings.as_bytes(), Format::Toml, "w").is_ok());
}

#[test]
fn large_hostile_files_are_refused() {
    // Large enough to show growth that is not linear as a test that does not end.
    let size = crate::MAX_FILE_BYTES as usize / 4;
    let fill = |piece: &str| piece.repeat(size / piece.len());
    let numbered = |line: fn(usize) -> String| -> String {
        (0..)
            .map(line)
            .scan(0, |length, line| {
                *length += line.len();
                (*length <= size).then_some(line)
            })
            .collect()
    };
    let bomb = "a: &a [x,x,x,x,x,x,x,x,x]\nb: &b [*a,*a,*a,*a,*a,*a,*a]\nc: [*b,*b,*b,*b,*b]\n".to_owned();
    let texts = [
        fill("a"),
        fill("\""),
        fill("["),
        fill("[]"),
        fill("a=1\n"),
        fill("a: 1\n"),
        fill("[[task]]\n"),
        fill("- - "),
        fill("? "),
        fill("#\n"),
        fill("'\n"),
        fill("&a "),
        fill("!<a> "),
        fill("%TAG ! a\n"),
        fill("--- a\n"),
        fill("- {name: a, lanes: 1}\n"),
        format!("pool: [{}]", fill("a,").split_off(18)),
        format!("pool = [{}]", fill("{},").split_off(18)),
        format!("pool = \"\"\"{}", fill("\n").split_off(18)),
        format!("pool: |\n{}", fill(" a\n").split_off(18)),
        numbered(|n| format!("k{n}: {n}\n")),
        numbered(|n| format!("k{n} = {n}\n")),
        numbered(|n| format!("a.k{n} = {n}\n")),
        bomb,
    ];
    for text in texts {
        for format in [Format::Toml, Format::Yaml] {
            refused_as(text.as_bytes(), format);
        }
    }
}
