use super::*;

const HEADER: &str = r#"/* A header.
 * typedef struct no_struct { uint32_t no_field; } no_struct;
 */
#ifndef RED_H
#define RED_ABI_VERSION 7

/**
 * How.
 */
enum red_status
#ifdef __cplusplus
  : int32_t
#endif // __cplusplus
 {
  /**
   * Done.
   */
  RED_STATUS_OK = 0,
};
#ifndef __cplusplus
typedef int32_t red_status;
#endif // __cplusplus

/**
 * A body.
 */
typedef void (*red_body)(void *context);

/**
 * A pair.
 */
typedef struct red_pair {
  /**
   * First.
   */
  uint32_t first;
  struct red_member rest[4];
  void (*call)(void *context,
               uint32_t number);
} red_pair;

typedef struct {
  uint64_t bits;
} red_handle;

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

/**
 * Opens.
 *
 * Threads: any.
 */
red_status red_open(struct red_pair *pair,
                    uint32_t number);

const char *red_version(void);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus
#endif
#define RED_PAIR_INIT {0}
"#;

#[test]
fn functions_come_with_what_is_said_about_them_and_structs_with_their_fields() {
    let found = Declared::of(HEADER);
    let names: Vec<_> = found.functions.iter().map(|function| &*function.name).collect();
    assert_eq!(names, ["red_open", "red_version"]);
    assert!(found.functions[0].doc.contains("Threads: any."), "{:?}", found.functions[0]);
    assert_eq!(found.functions[1].doc, "", "nothing is said about it");
    let fields = ["first", "rest", "call"].map(str::to_owned).to_vec();
    let pair = Struct { name: "red_pair".into(), fields };
    let handle = Struct { name: "red_handle".into(), fields: vec!["bits".into()] };
    assert_eq!(found.structs, [pair, handle]);
    assert_eq!((&*found.abi_version, found.set_up), ("7", vec!["red_pair".to_owned()]));
}
