use super::*;

#[test]
fn what_compilers_add_themselves_is_not_named_again() {
    let said = "   Compiling red-ffi\nnote: native-static-libs: -lgcc_s -lutil -lpthread -lutil -lm -lc\n";
    assert_eq!(needed(said), ["-lutil", "-lpthread", "-lm"]);
    assert_eq!(needed("nothing"), Vec::<String>::new());
}
